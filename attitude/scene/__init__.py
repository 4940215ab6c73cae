"""A body, the Sun and an observer at the epochs of observations: the geometry of a light curve.

``Scene(motion, center=...).at(times)`` is a `View`, which computes each quantity at its first use.
`docs/scene.md` defines the quantities.

scene            `Scene`: the setting, checked
view             `View`: the quantities at some epochs; `lazy` computes each once
geometry         those of lines of sight alone; `shadow` of other bodies
pointing         those that need the attitude
sky              those that the observer measures
photometry       those that need a shape
errors           standard deviations of those that depend on the attitude
lines_of_sight   directions and distances at many epochs; `light_time`, their correction
angles, loops    formulas on arrays; compiled loops
"""

from attitude.scene._scene import Scene
from attitude.scene._view import View

__all__ = ["Scene", "View"]
