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

conditions     of axes, facets and mirrors; `attitude.conditions` has `Condition` and `Observable`
channels       the functions whose signs they take; `directions` that are compared with body axes
discrete       `find_discrete`, of conditions and of plain functions; `combined`, of several kinds
extrema        `find_maxima`, `find_minima`; `peaks`, of a plain function
windows        intervals in which a condition holds; `passes` over a site, `glints` of a mesh
timetable      their rows, as tables; `tops`, the greatest values within intervals
search         all sign changes of channels; `rate_bounds` of the motion, `root_finding` in brackets
levels         the epochs at which quantities pass thresholds
events         `Events`, the result; `sources`, what is searched
"""

import warnings
from typing import TYPE_CHECKING, Any

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
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
