"""What `aem.read(lenient=True)` assumes of files of operators that leave parts of the standard out.

Definitive attitude of the MMS mission (GSFC) has the header of an AEM, and 21 columns: the epoch,
elapsed seconds, the quaternion (scalar last) from J2000 to the body, its rates in deg/s over the
body axes, phases, poles and a flag of quality.  The quaternion and the rates are read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.formats.aem.message import MessageSegment

# Columns of MMS, and those of them that are read: epoch, Q1, Q2, Q3, QC, rates X, Y, Z.
MMS: int = 21
_READ = (0, 2, 3, 4, 5, 6, 7, 8)
# Keyword -> what stands for it if it is missing; version 1 only, or both.
_MISSING = {
    **{"OBJECT_NAME": "UNKNOWN", "OBJECT_ID": "UNKNOWN", "TIME_SYSTEM": "UTC"},
    "ATTITUDE_TYPE": "QUATERNION",
}
_MISSING_1 = {"ATTITUDE_DIR": "A2B", "QUATERNION_TYPE": "LAST"}
_RATES = {"1.0": "RATE_FRAME", "2.0": "ANGVEL_FRAME"}


def fill(segment: MessageSegment) -> None:
    """Give a segment the keywords that it lacks, and note each of them.

    START_TIME and STOP_TIME are left out: they follow from the records.
    """
    version, values = segment.message.version, segment.values
    missing = {**_MISSING, **(_MISSING_1 if version == "1.0" else {})}
    if segment.message.options.cic:  # whose scalar stands first by default
        missing.pop("QUATERNION_TYPE")
    kind = values.get("ATTITUDE_TYPE", "")
    if kind.upper().endswith(("/RATE", "/ANGVEL")):
        missing[_RATES[version]] = values.get("REF_FRAME_B", "")
    if not kind.upper().startswith("QUATERNION") and kind:
        missing.pop("QUATERNION_TYPE", None)
    for keyword, value in missing.items():
        if not values.get(keyword):
            segment.values[keyword] = value
            segment.lines[keyword] = 1
            segment.assume(f"{keyword} is missing: {cut(value, '')}")
    for keyword in ("START_TIME", "STOP_TIME"):
        if not values.get(keyword) and not segment.message.options.cic:
            segment.assume(f"{keyword} is missing: that of the records")


def of_mms(tokens: Sequence[bytes]) -> list[bytes]:
    """The entries of a row of MMS that are read."""
    return [tokens[k] for k in _READ]
