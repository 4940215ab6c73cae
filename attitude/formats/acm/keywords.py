"""Keywords, units and elements of XML of Attitude Comprehensive Messages.

Source: CCSDS 504.0-B-2, section 5; names of elements as in Orekit and ccsds-ndm.  The columns of
covariances are variances: the message holds no correlations.
"""

from __future__ import annotations

VERSIONS: tuple[str, ...] = ("2.0",)
META: tuple[str, ...] = (
    *("OBJECT_NAME", "INTERNATIONAL_DESIGNATOR", "CATALOG_NAME", "OBJECT_DESIGNATOR"),
    *("ORIGINATOR_POC", "ORIGINATOR_POSITION", "ORIGINATOR_PHONE", "ORIGINATOR_EMAIL"),
    *("ORIGINATOR_ADDRESS", "ODM_MSG_LINK", "CENTER_NAME", "TIME_SYSTEM", "EPOCH_TZERO"),
    *("ACM_DATA_ELEMENTS", "START_TIME", "STOP_TIME", "TAIMUTC_AT_TZERO", "NEXT_LEAP_EPOCH"),
    "NEXT_LEAP_TAIMUTC",
)
NEEDED: tuple[str, ...] = ("OBJECT_NAME", "TIME_SYSTEM", "EPOCH_TZERO")
BLOCKS: dict[str, tuple[str, ...]] = {
    "ATT": (
        *("ATT_ID", "ATT_PREV_ID", "ATT_BASIS", "ATT_BASIS_ID", "REF_FRAME_A", "REF_FRAME_B"),
        *("EULER_ROT_SEQ", "NUMBER_STATES", "ATT_TYPE", "RATE_TYPE"),
    ),
    "PHYS": (
        *("DRAG_COEFF", "WET_MASS", "DRY_MASS", "CP_REF_FRAME", "CP", "INERTIA_REF_FRAME"),
        *("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"),
    ),
    "COV": ("COV_ID", "COV_PREV_ID", "COV_BASIS", "COV_BASIS_ID", "COV_REF_FRAME", "COV_TYPE"),
    "MAN": (
        *("MAN_ID", "MAN_PREV_ID", "MAN_PURPOSE", "MAN_BEGIN_TIME", "MAN_END_TIME"),
        *("MAN_DURATION", "ACTUATOR_USED", "TARGET_MOMENTUM", "TARGET_MOM_FRAME"),
        *("TARGET_ATTITUDE", "TARGET_SPINRATE"),
    ),
    "AD": (
        *("AD_ID", "AD_PREV_ID", "AD_METHOD", "ATTITUDE_SOURCE", "EULER_ROT_SEQ"),
        *("NUMBER_STATES", "ATTITUDE_STATES", "COV_TYPE", "REF_FRAME_A", "REF_FRAME_B"),
        *("RATE_STATES", "SIGMA_U", "SIGMA_V", "RATE_PROCESS_NOISE_STDDEV"),
    ),
    "SENSOR": (
        *("SENSOR_NUMBER", "SENSOR_USED", "NUMBER_SENSOR_NOISE_COVARIANCE"),
        *("SENSOR_NOISE_STDDEV", "SENSOR_FREQUENCY"),
    ),
    # Its keywords are those of the user.
    "USER": (),
}
# Blocks that a message may have once only.
ONCE: tuple[str, ...] = ("PHYS", "AD", "USER")
# Blocks with rows, and the element of XML that holds one.
ROWS: dict[str, str] = {"ATT": "attLine", "COV": "covLine"}
# ATT_TYPE and RATE_TYPE -> columns.
ATTITUDES: dict[str, int] = {"QUATERNION": 4, "EULER_ANGLES": 3, "DCM": 9}
RATES: dict[str, int] = {"NONE": 0, "ANGVEL": 3, "Q_DOT": 4, "EULER_RATE": 3, "GYRO_BIAS": 3}
# COV_TYPE -> columns, and how many of them are variances of the attitude.
COVARIANCES: dict[str, tuple[int, int]] = {
    **{"ANGLE": (3, 3), "ANGLE_GYROBIAS": (6, 3), "ANGLE_ANGVEL": (6, 3)},
    **{"QUATERNION": (4, 4), "QUATERNION_GYROBIAS": (7, 4), "QUATERNION_ANGVEL": (7, 4)},
}
UNITS: dict[str, tuple[str, ...]] = {
    **{"WET_MASS": ("kg",), "DRY_MASS": ("kg",), "CP": ("m",)},
    **dict.fromkeys(BLOCKS["PHYS"][-6:], ("kg*m**2", "kg*m^2", "kg.m**2")),
    **dict.fromkeys(("MAN_BEGIN_TIME", "MAN_END_TIME", "MAN_DURATION"), ("s",)),
    "TARGET_MOMENTUM": ("N*m*s", "N.m.s"),
    "TARGET_SPINRATE": ("deg/s", "°/s"),
    "SENSOR_NOISE_STDDEV": ("deg",),
    "SENSOR_FREQUENCY": ("Hz",),
    "SIGMA_U": ("deg/s**1.5", "deg/s^1.5", "°/s**1.5"),
    "SIGMA_V": ("deg/s**0.5", "deg/s^0.5", "°/s**0.5"),
    "RATE_PROCESS_NOISE_STDDEV": ("deg/s**1.5", "deg/s^1.5", "°/s**1.5"),
    **dict.fromkeys(("TAIMUTC_AT_TZERO", "NEXT_LEAP_TAIMUTC"), ("s",)),
}
