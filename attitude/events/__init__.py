"""What happens between samples: events on the exact motion, none missed.

>>> from attitude import Body, FreeRotation, Spin, events
>>> motion = FreeRotation(
...     Body(moments=(10, 20, 26)),
...     Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1)),
... )
>>> lit = events.illuminated(motion, (0, 0, 1), sun=(1, 0, 1))
>>> times, values = events.find_discrete(0, 10, lit)

`find_discrete`, `find_maxima` and `find_minima` are called as in skyfield: with two epochs and
what is sought.
"""

from attitude.events.conditions import (
    SUN_RADIUS,
    Condition,
    beyond_plane,
    glint,
    illuminated,
    in_cone,
    past_meridian,
    visible,
)
from attitude.events.directions import Moving
from attitude.events.discrete import find_discrete, shadow_state, stream
from attitude.events.events import Events
from attitude.events.extrema import Quantity, brightness, find_maxima, find_minima, separation
from attitude.events.search import TOUCH

__all__ = [
    "SUN_RADIUS",
    "TOUCH",
    "Condition",
    "Events",
    "Moving",
    "Quantity",
    "beyond_plane",
    "brightness",
    "find_discrete",
    "find_maxima",
    "find_minima",
    "glint",
    "illuminated",
    "in_cone",
    "past_meridian",
    "separation",
    "shadow_state",
    "stream",
    "visible",
]
