"""What each tool accepts: settings of the writers, by the name of the tool.

A recipe fills the settings that the caller leaves open, and refuses those that the tool does not
read. Sources: the readers of GMAT R2020a (CCSDSAEMSegment and its subclasses: EME2000 and
SC_BODY_1 only; QUATERNION with LINEAR; version 1.0),
Orekit 13 (derivatives of Euler angles in version 1; degree + 1 records to interpolate), brahe 1.8
(version 2.0 only), the help of STK 12 on importing attitudes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Recipe:
    """Settings for one tool."""

    tool: str  # its name in error messages
    settings: Mapping[str, Any]  # settings of the writer of the format, by name
    # values of settings that the tool reads, where it does not read all
    allowed: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    samples: bool = False  # it interpolates from degree + 1 records, with angular velocities too


_EME2000 = ("EME2000", "J2000")
AEM: dict[str, Recipe] = {
    "gmat": Recipe(
        "GMAT",
        {
            **{"version": "1.0", "kind": "QUATERNION", "frame": "EME2000", "time_system": "UTC"},
            **{"body_frame": "SC_BODY_1", "method": "slerp", "degree": 1},
        },
        {
            **{"version": ("1.0",), "kind": ("QUATERNION",), "frame": _EME2000},
            **{"time_system": ("UTC",), "body_frame": ("SC_BODY_1",), "xml": (False,)},
            **{"method": ("slerp", "linear"), "degree": (1,)},
        },
    ),
    "orekit": Recipe(
        "Orekit",
        {"version": "2.0", "kind": "QUATERNION/ANGVEL", "body_frame": "SC_BODY_1"},
        {"rates": ("euler", None)},
        samples=True,
    ),
    "stk": Recipe(
        "STK",
        {
            **{"version": "1.0", "kind": "QUATERNION", "frame": "EME2000", "time_system": "UTC"},
            **{"body_frame": "SC_BODY_1", "method": "lagrange"},
        },
        {"version": ("1.0",), "xml": (False,), "time_system": ("UTC",)},
    ),
    "brahe": Recipe("brahe", {"version": "2.0"}, {"version": ("2.0",)}),
}


def of_aem(tool: str | None, chosen: dict[str, Any], has_rates: bool) -> dict[str, Any]:
    """The settings of `aem.write` for a tool: those given, and for the others its recipe's."""
    if tool is None:
        return chosen
    recipe = AEM.get(tool.lower()) if isinstance(tool, str) else None
    if recipe is None:
        raise AttitudeError(
            f"for_ (--for) is {tool!r}; known tools are {', '.join(AEM)}. SPICE reads x.bc, Cesium "
            "columns of x.csv, both without it."
        )
    if recipe.tool == "GMAT" and chosen.get("kind") == "EULER_ANGLE":
        raise AttitudeError(
            "kind is 'EULER_ANGLE', whose angles GMAT interpolates across their jumps from 180 to "
            "-180 deg, a whole turn between two records; leave kind out for QUATERNION."
        )
    settings = dict(chosen)
    for name, value in recipe.settings.items():
        if settings.get(name) is None:
            settings[name] = value
    if not has_rates and chosen.get("kind") is None:
        settings["kind"] = settings["kind"] and settings["kind"].partition("/")[0]
    for name, values in recipe.allowed.items():
        if chosen.get(name) is not None and chosen[name] not in values:
            raise AttitudeError(
                f"{name} is {chosen[name]!r}, which {recipe.tool} does not read; it must be "
                f"{' or '.join(repr(value) for value in values if value is not None)}."
            )
    return settings


def degree_of(tool: str | None, degree: int, count: int) -> int:
    """The degree of interpolation that is written for a tool, of a segment of `count` records."""
    recipe = AEM.get(tool.lower()) if tool else None
    return min(degree, count - 1) if recipe is not None and recipe.samples else degree
