"""The head of a SPICE binary kernel, which SPICE takes at its word: a wrong one ends the process.

Source: the DAF Required Reading of SPICE: the file record is the first 1024 bytes; ND and NI
stand at byte 8, the addresses of the first and last summary records and of the first free double
word (counted from 1) at byte 76, the byte order at byte 88.
"""

import os
import struct

_RECORD = 1024
_ORDERS = {b"LTL-IEEE": "<", b"BIG-IEEE": ">"}
_SUMMARIES = {b"DAF/CK": (2, 6), b"DAF/SPK": (2, 6), b"DAF/PCK": (2, 5)}


def fault(path):
    """What is wrong with the head of a kernel, as a sentence; None where nothing is seen.

    Files that are no DAF, or in the byte order of old machines, are left to SPICE.
    """
    with open(path, "rb") as file:
        head = file.read(_RECORD)
    kind, order = head[:8].rstrip(), _ORDERS.get(head[88:96])
    if kind not in _SUMMARIES or (order is None and len(head) == _RECORD):
        return None
    if len(head) < _RECORD:
        return "it ends before its first 1024 bytes"
    summary = struct.unpack(order + "2i", head[8:16])
    first, last, free = struct.unpack(order + "3i", head[76:88])
    records = os.path.getsize(path) // _RECORD
    if summary != _SUMMARIES[kind]:
        return f"it says that its summaries have {summary[0]} doubles and {summary[1]} integers"
    if not (1 < first <= records and 1 < last <= records and free > _RECORD // 8):
        return "its summaries are not within it"
    if _RECORD * records < 8 * (free - 1):
        return "it is shorter than it says, as if cut off"
    return None
