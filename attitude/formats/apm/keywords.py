"""Keywords, units and elements of XML of the blocks of Attitude Parameter Messages.

Version 1 has other names for the keywords of version 2.
"""

from __future__ import annotations

# Keywords of the meta data.
META: tuple[str, ...] = ("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "TIME_SYSTEM")
_Q = ("Q1", "Q2", "Q3", "QC")
_SPIN = ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL")
_NUTATION = ("NUTATION", "NUTATION_PER", "NUTATION_PHASE")
_FRAMES = ("REF_FRAME_A", "REF_FRAME_B")
# Keywords of the blocks of version 2, by the name in their _START and _STOP.
BLOCKS: dict[str, tuple[str, ...]] = {
    "QUAT": (*_FRAMES, *_Q, *(f"{name}_DOT" for name in _Q)),
    "EULER": (
        *(*_FRAMES, "EULER_ROT_SEQ", "ANGLE_1", "ANGLE_2", "ANGLE_3"),
        *("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"),
    ),
    "ANGVEL": (*_FRAMES, "ANGVEL_FRAME", "ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"),
    "SPIN": (*_FRAMES, *_SPIN, *_NUTATION, "MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"),
    "INERTIA": ("INERTIA_REF_FRAME", "IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"),
    "MAN": (
        *("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME", "MAN_TOR_X", "MAN_TOR_Y"),
        *("MAN_TOR_Z", "MAN_DELTA_MASS"),
    ),
}
# Keyword of version 1 -> block, and keyword of version 2 (or its own, if version 2 has none).
OLD: dict[str, tuple[str, str]] = {
    **{name: ("QUAT", name) for name in BLOCKS["QUAT"][2:]},
    **{"Q_FRAME_A": ("QUAT", "REF_FRAME_A"), "Q_FRAME_B": ("QUAT", "REF_FRAME_B")},
    "Q_DIR": ("QUAT", "DIR"),
    **{"EULER_FRAME_A": ("EULER", "REF_FRAME_A"), "EULER_FRAME_B": ("EULER", "REF_FRAME_B")},
    **{"EULER_DIR": ("EULER", "DIR"), "EULER_ROT_SEQ": ("EULER", "EULER_ROT_SEQ")},
    "RATE_FRAME": ("EULER", "RATE_FRAME"),
    **{f"{axis}_ANGLE": ("EULER", f"{axis}_ANGLE") for axis in "XYZ"},
    **{f"{axis}_RATE": ("EULER", f"{axis}_RATE") for axis in "XYZ"},
    **{"SPIN_FRAME_A": ("SPIN", "REF_FRAME_A"), "SPIN_FRAME_B": ("SPIN", "REF_FRAME_B")},
    "SPIN_DIR": ("SPIN", "DIR"),
    **{name: ("SPIN", name) for name in (*_SPIN, *_NUTATION)},
    "INERTIA_REF_FRAME": ("INERTIA", "INERTIA_REF_FRAME"),
    **{
        f"I{i}{j}": ("INERTIA", f"I{'XYZ'[i - 1]}{'XYZ'[j - 1]}")
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i <= j
    },
    **{name: ("MAN", name) for name in ("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME")},
    **{f"MAN_TOR_{k}": ("MAN", f"MAN_TOR_{'XYZ'[k - 1]}") for k in (1, 2, 3)},
}
# Keywords of version 1 that may be repeated in a block, for sequences such as 313.
REPEATED: tuple[str, ...] = ("X_ANGLE", "Y_ANGLE", "Z_ANGLE", "X_RATE", "Y_RATE", "Z_RATE")
# Kind of number -> units that may stand behind it; a number without a unit is in the first.
UNITS: dict[str, tuple[str, ...]] = {
    "ANGLE": ("deg",),
    "RATE": ("deg/s",),
    "DOT": ("1/s",),
    "INERTIA": ("kg*m**2", "kg*m^2", "kg.m**2"),
    "PERIOD": ("s",),
}
# Element -> block, in XML of either version; and version -> block -> element, for writing.
XML_BLOCKS: dict[str, str] = {
    **{"quaternionState": "QUAT", "eulerAngleState": "EULER", "eulerElementsThree": "EULER"},
    **{"angularVelocity": "ANGVEL", "spin": "SPIN", "eulerElementsSpin": "SPIN"},
    **{"inertia": "INERTIA", "spacecraftParameters": "INERTIA", "maneuverParameters": "MAN"},
}
XML_NAMES: dict[str, dict[str, str]] = {
    "2.0": {
        **{"QUAT": "quaternionState", "EULER": "eulerAngleState", "ANGVEL": "angularVelocity"},
        **{"SPIN": "spin", "INERTIA": "inertia"},
    },
    "1.0": {
        **{"QUAT": "quaternionState", "EULER": "eulerElementsThree", "SPIN": "eulerElementsSpin"},
        "INERTIA": "spacecraftParameters",
    },
}
