"""A body, the Sun and an observer at the epochs of observations: the geometry of a light curve.

``Scene(motion, center=...).at(times)`` is a `View`, which computes each quantity at its first use.
`docs/scene.md` defines the quantities.

_scene       `Scene`: the setting, checked
_view        `View`: the quantities at some epochs, each computed once, with standard deviations
_shadow      the fraction of the Sun's disc that is seen past other bodies
_light_time  directions and distances at many epochs, with light time
_angles      formulas on arrays; compiled loops
"""

from attitude.scene._scene import Scene
from attitude.scene._view import View

__all__ = ["Scene", "View"]
