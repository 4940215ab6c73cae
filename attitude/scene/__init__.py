"""A body, the Sun and an observer at the epochs of observations: the geometry of a light curve.

``Scene(motion, center=...).at(times)`` is a `View`, which computes each quantity at its first use.
`docs/scene.md` defines the quantities.

_scene        `Scene`: the setting, checked; its quantities as observables
_view         `View`: the quantities at some epochs, and their standard deviations
_light_time   directions and distances at many epochs, corrected for light time
_shadow       the part of the Sun's disc that other bodies leave free
_angles       formulas on arrays; compiled loops
"""

from attitude.scene._scene import Scene
from attitude.scene._view import View

__all__ = ["Scene", "View"]
