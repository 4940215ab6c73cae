"""The elements of an AEM in XML: their names and units."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

# Version -> attitude type -> element of a record.
ELEMENTS: dict[str, dict[str, str]] = {
    "2.0": {
        "QUATERNION": "quaternionEphemeris",
        "QUATERNION/DERIVATIVE": "quaternionDerivative",
        "QUATERNION/ANGVEL": "quaternionAngVel",
        "EULER_ANGLE": "eulerAngle",
        "EULER_ANGLE/DERIVATIVE": "eulerAngleDerivative",
        "EULER_ANGLE/ANGVEL": "eulerAngleAngVel",
        "SPIN": "spin",
        "SPIN/NUTATION": "spinNutation",
        "SPIN/NUTATION_MOM": "spinNutationMom",
    },
    "1.0": {
        "QUATERNION": "quaternionState",
        "QUATERNION/DERIVATIVE": "quaternionDerivative",
        "QUATERNION/ANGVEL": "quaternionEulerRate",
        "EULER_ANGLE": "eulerAngle",
        "EULER_ANGLE/ANGVEL": "eulerAngleRate",
        "SPIN": "spin",
        "SPIN/NUTATION": "spinNutation",
    },
}
RECORDS: set[str] = {element for names in ELEMENTS.values() for element in names.values()}
# Elements between those of records and those of numbers.
GROUPS: tuple[str, ...] = (
    *("quaternion", "quaternionDot", "quaternionRate", "angVel"),
    *("rotationAngles", "rotationRates"),
)


def unit(name: str) -> str | None:
    """The unit of a column; None for pure numbers."""
    if name.startswith("Q"):
        return "1/s" if name.endswith("_DOT") else None
    if name == "NUTATION_PER":
        return "s"
    return "deg/s" if name.endswith(("_DOT", "_VEL")) or name.startswith("ANGVEL") else "deg"


def scalar_first(columns: Sequence[str]) -> list[str]:
    """Names of columns with QC before Q1, Q2, Q3, as under QUATERNION_TYPE = FIRST of version 1."""
    groups = [columns[k : k + 4] for k in range(0, len(columns), 4)]
    return [n for g in groups for n in ((*g[3:], *g[:3]) if g[3:4] and g[3][:2] == "QC" else g)]
