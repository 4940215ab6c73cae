"""What the rates of version 1 of attitude messages are: body rates or derivatives of angles.

CCSDS 504.0-B-1 calls the columns of QUATERNION/RATE and EULER_ANGLE/RATE, and X_RATE, Y_RATE and
Z_RATE of an APM, body rates over the axes of RATE_FRAME in some sentences; its figure 3-6 has
Y_RATE, X_RATE, Y_RATE under EULER_ROT_SEQ 212, which can only be derivatives of the angles.  Files
of the MMS mission have body rates; Orekit reads and writes derivatives of the angles of
EULER_ROT_SEQ.  Repeated letters are read as derivatives; for all others the user decides, and the
default is body rates.  On QUATERNION/DERIVATIVE and Q1_DOT everybody agrees.
"""

from __future__ import annotations

import warnings

from attitude.errors import AttitudeError, AttitudeWarning

MEANINGS: tuple[str, ...] = ("body", "euler")


def known(rates: str | None, name: str = "rates") -> str | None:
    """The meaning itself; AttitudeError for an unknown one."""
    if rates is not None and rates not in MEANINGS:
        raise AttitudeError(
            f'{name} is {rates!r}; give "body" for components of the angular velocity, or "euler" '
            "for derivatives of the Euler angles."
        )
    return rates


def warn(path: str, what: str) -> None:
    """Warn that `what` in a file was read as body rates although it may be something else."""
    warnings.warn(
        f"{path}: the rates of {what} of version 1 are read as components of the angular velocity; "
        'some tools, such as Orekit, write derivatives of the Euler angles: give rates="body" or '
        'rates="euler".',
        AttitudeWarning,
        stacklevel=2,
    )
