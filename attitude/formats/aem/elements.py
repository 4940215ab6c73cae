"""The names of the elements of an AEM in XML, and the units of what they hold."""

# The elements that hold a record, by version and type.
ELEMENTS = {
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
RECORDS = {element for names in ELEMENTS.values() for element in names.values()}
# What stands between them and the numbers, where it is not empty.
GROUPS = (
    *("quaternion", "quaternionDot", "quaternionRate", "angVel"),
    *("rotationAngles", "rotationRates"),
)


def unit(name):
    """The unit of a column, None for pure numbers."""
    if name.startswith("Q"):
        return "1/s" if name.endswith("_DOT") else None
    if name == "NUTATION_PER":
        return "s"
    return "deg/s" if name.endswith(("_DOT", "_VEL")) or name.startswith("ANGVEL") else "deg"


def scalar_first(columns):
    """The columns as version 1 has them in KVN with QUATERNION_TYPE = FIRST."""
    groups = [columns[k : k + 4] for k in range(0, len(columns), 4)]
    return [n for g in groups for n in (g[3:] + g[:3] if g[3:4] and g[3].startswith("QC") else g)]
