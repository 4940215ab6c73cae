"""A body, the Sun and an observer at the epochs of observations: the geometry of a light curve.

``Scene(motion, center=...).at(times)`` is a `View`, which computes each quantity at its first use.
`docs/scene.md` defines the quantities.
"""

from attitude.scene.scene import Scene
from attitude.scene.view import View

__all__ = ["Scene", "View"]
