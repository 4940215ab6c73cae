"""The head of a SPICE binary kernel, checked: SPICE does not check it and ends the process.

Source: the DAF Required Reading of SPICE: the file record is the first 1024 bytes; ND and NI
stand at byte 8, the addresses of the first and last summary records and of the first free double
word (counted from 1) at byte 76, the byte order at byte 88.
"""

from __future__ import annotations

import os
import struct
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from attitude.annotations import FilePath

_RECORD = 1024
_ORDERS = {b"LTL-IEEE": "<", b"BIG-IEEE": ">"}
_SUMMARIES = {b"DAF/CK": (2, 6), b"DAF/SPK": (2, 6), b"DAF/PCK": (2, 5)}


def fault(path: FilePath) -> str | None:
    """The fault in the head of a kernel, as a sentence; None if there is none.

    Files that are not DAF, or in the byte order of old machines, are not checked.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    with open(path, "rb") as file:
        head = file.read(_RECORD)
    kind, order = head[:8].rstrip(), _ORDERS.get(head[88:96])
    if kind not in _SUMMARIES or (order is None and len(head) == _RECORD):
        return None
    if order is None or len(head) < _RECORD:
        return "it ends before its first 1024 bytes"
    summary = struct.unpack(order + "2i", head[8:16])
    first, last, free = struct.unpack(order + "3i", head[76:88])
    records = os.path.getsize(path) // _RECORD
    if summary != _SUMMARIES[kind]:
        return f"its head states summaries of {summary[0]} doubles and {summary[1]} integers"
    if not (1 < first <= records and 1 < last <= records and free > _RECORD // 8):
        return "its summaries are not within it"
    if _RECORD * records < 8 * (free - 1):
        return "it is shorter than its head states, as if cut off"
    return None
