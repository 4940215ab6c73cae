"""Events between samples: where conditions change on the exact motion, and extrema.

>>> from attitude import Body, FreeRotation, Spin, events
>>> motion = FreeRotation(
...     Body(moments=(10, 20, 26)),
...     Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1)),
... )
>>> lit = events.illuminated(motion, (0, 0, 1), sun=(1, 0, 1))
>>> times, values = events.find_discrete(0, 10, lit)

`find_discrete`, `find_maxima` and `find_minima` are called as in skyfield: with two epochs and a
condition or an observable.

_search     `find_discrete`, `Events`, `shadow_state`, `stream`; thresholds of observables
_extrema    `find_maxima`, `find_minima`; the observables `separation` and `brightness`
_channels   `illuminated`, `visible`, `glint` and other conditions of axes, facets and mirrors
_windows    `windows`, `passes`, `glints`: intervals in which conditions hold, as a `Timetable`

`attitude.conditions` has `Condition`, `Observable` and the search for sign changes.
"""

import warnings
from typing import TYPE_CHECKING, Any

from attitude._support.synonyms import absent
from attitude.conditions._conditions import Condition, Observable
from attitude.conditions._search import TOUCH
from attitude.events._channels import (
    SUN_RADIUS,
    Moving,
    beyond_plane,
    glint,
    illuminated,
    in_cone,
    past_meridian,
    visible,
)
from attitude.events._extrema import brightness, find_maxima, find_minima, separation
from attitude.events._search import Events, find_discrete, shadow_state, stream
from attitude.events._windows import Glints, Passes, Timetable, Windows, glints, passes, windows

__all__ = [
    "SUN_RADIUS",
    "TOUCH",
    "Condition",
    "Events",
    "Glints",
    "Moving",
    "Observable",
    "Passes",
    "Timetable",
    "Windows",
    "beyond_plane",
    "brightness",
    "find_discrete",
    "find_maxima",
    "find_minima",
    "glint",
    "glints",
    "illuminated",
    "in_cone",
    "passes",
    "past_meridian",
    "separation",
    "shadow_state",
    "stream",
    "visible",
    "windows",
]

if not TYPE_CHECKING:  # so that type checkers know that there are no other names

    def __getattr__(name: str) -> Any:
        """The class `Observable` under its former name."""
        if name == "Quantity":
            warnings.warn(
                "attitude.events.Quantity is now attitude.events.Observable; use that name.",
                DeprecationWarning,
                stacklevel=2,
            )
            return Observable
        raise absent(__name__, name)
