"""A body, the Sun and an observer at the epochs of observations: the geometry of a light curve.

``Scene(motion, center=...).at(times)`` is a view, which makes each quantity when it is first asked
for, and only then: `docs/scene.md` says what each of them means.
"""

from attitude.scene.scene import Scene
from attitude.scene.view import View

__all__ = ["Scene", "View"]
