"""CCSDS Attitude Parameter Messages, versions 1.0 and 2.0, KVN and XML: one state and the inertia.

An APM with inertia and angular velocity determines a Body and a Spin; a FreeRotation is written as
one APM.  Conventions of quaternions, angles, rates and spin are those of `_attitude_types`; the
sign of the products of inertia is that of each version's book unless `products` is given (see
`known_products`).  Maneuvers are kept among the keywords only.

If a message has the attitude in several forms, the first of quaternion, Euler angles and spin is
used, and for the rates the first of ANGVEL, derivatives of the quaternion, of the angles, spin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from attitude._textfiles import kvn
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import cut, is_number, opened
from attitude._textfiles.xml import MESSAGES, OUTSIDE, ElementReader, escaped
from attitude.errors import AttitudeError
from attitude.formats import _attitude_types
from attitude.formats import _ccsds_epochs as ccsds_epochs
from attitude.formats._attitude_types import HEADER, VERSIONS, Convention
from attitude.formats._format import OpenedFile, message_labels, register_message
from attitude.formats._records import TOLERANCE, known_tolerance, to_icrf
from attitude.formats._sampling import refuse_breaks
from attitude.frames import quaternion as forms
from attitude.frames import representations as frames_representations
from attitude.motions import _axes as motions_axes
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.motions._table import refuse_speed

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude._support.annotations import FilePath, FloatArray
    from attitude._textfiles.lines import Fault, Lines
    from attitude.epochs._instants import Instant
    from attitude.paths._path import Path

__all__ = ["Parameters", "read", "write"]


# ---- Keywords, units and elements of XML of the blocks of Attitude Parameter Messages
# Version 1 has other names for the keywords of version 2.

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


# ---- The sign of the products of inertia in an Attitude Parameter Message
# "tensor"    IXY (I12) is the entry of the inertia tensor, -integral of x y dm.  Version 1: "the
#             inertia cross products used for this message assume a negative double integral", CCSDS
#             504.0-B-1, 3.2.5.2.5.  Orekit reads both versions with this sign.
# "integral"  IXY is the integral of x y dm, and the entry of the tensor is -IXY: the matrix of
#             version 2, CCSDS 504.0-B-2, annex F6.  brahe reads version 2 with this sign.

_SIGNS = {"tensor": 1.0, "integral": -1.0}
_OF_VERSION = {"1.0": "tensor", "2.0": "integral"}
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def known_products(products: str | None, version: str) -> str:
    """The convention of the products of inertia, by default that of the version's book."""
    if products is None:
        return _OF_VERSION[version]
    if products not in _SIGNS:
        raise AttitudeError(f'products is {products!r}; give "tensor" or "integral".')
    return products


def tensor(values: Sequence[float], products: str) -> FloatArray:
    """The inertia tensor (3, 3), kg m2, from IXX, IYY, IZZ, IXY, IXZ, IYZ in kg m2.

    >>> tensor((10.0, 20.0, 26.0, 0.5, 0.0, 0.0), "integral")
    array([[10. , -0.5,  0. ],
           [-0.5, 20. ,  0. ],
           [ 0. ,  0. , 26. ]])
    """
    found = np.zeros((3, 3))
    for (i, j), value in zip(_PLACES, values, strict=True):
        found[i, j] = found[j, i] = value if i == j else _signed(value, products)
    return found


def inertia_values(tensor: FloatArray, products: str) -> list[float]:
    """IXX, IYY, IZZ, IXY, IXZ, IYZ in kg m2 from an inertia tensor (3, 3) in kg m2."""
    entries = [(i == j, float(tensor[i, j])) for i, j in _PLACES]
    return [value if diagonal else _signed(value, products) for diagonal, value in entries]


def _signed(value, products):
    return _SIGNS[products] * value + 0.0  # -0.0 becomes 0.0


# ---- An Attitude Parameter Message while it is read: its blocks, with the keywords of version 2

_Choice = TypeVar("_Choice")


class Block(dict[str, str]):
    """A block of a message: keyword -> value.

    Attributes
    ----------
    name : str
        One of BLOCKS.
    line : int
        Number of the line in which the block begins.
    lines : dict of int
        Keyword -> number of its line.
    order : list of (keyword, value, line)
        All keywords in the order of the file, repeated ones too.
    comments : list of str
    """

    def __init__(self, name: str, line: int):
        super().__init__()
        self.name: str = name
        self.line: int = line
        self.lines: dict[str, int] = {}
        self.order: list[tuple[str, str, int]] = []
        self.comments: list[str] = []


class Collected:
    """A message while it is read: header, meta data, blocks.

    Parameters
    ----------
    version : str
    fault : callable
        Makes the error for a sentence and the number of a line.
    path : str
        Name of the file.

    Attributes
    ----------
    version, fault, path
        As given.
    header, meta : dict of str
        Keyword -> value; meta holds EPOCH too.
    lines : dict of int
        Keyword of header or meta data -> number of its line.
    comments : list of str
    blocks : list of Block
    """

    def __init__(self, version: str, fault: Fault, path: str):
        self.version: str = version
        self.fault: Fault = fault
        self.path: str = path
        self.header: dict[str, str] = {}
        self.meta: dict[str, str] = {}
        self.lines: dict[str, int] = {}
        self.comments: list[str] = []
        self.blocks: list[Block] = []

    def put_common(self, keyword: str, value: str, line: int) -> bool:
        """Add a keyword of header or meta data, or EPOCH; False, and nothing added, for others."""
        if keyword not in (*HEADER, *META, "EPOCH"):
            return False
        into = self.header if keyword in HEADER else self.meta
        if keyword in into:
            raise self.fault(f"{keyword} is given twice.", line)
        into[keyword], self.lines[keyword] = value, line
        return True

    def put(self, block: Block, keyword: str, value: str, line: int) -> None:
        """Add a keyword of version 2 to a block; AttitudeError for a repeated one."""
        if keyword in block and keyword not in REPEATED:
            raise self.fault(
                f"{keyword} is given twice, first in line {block.lines[keyword]}.", line
            )
        block.order.append((keyword, value, line))
        block[keyword], block.lines[keyword] = value, line

    def unknown(self, keyword: str, line: int) -> AttitudeError:
        """The error for an unknown keyword."""
        return self.fault(
            f"{keyword} is not known in an APM of version {self.version}, or not in this place.",
            line,
        )


def number(message: Collected, block: Block, keyword: str, kind: str | None = None) -> float:
    """The value of a keyword as a finite float."""
    if keyword not in block:
        raise message.fault(f"the block {block.name} lacks {keyword}.", block.line)
    line = block.lines[keyword]
    value, unit = kvn.without_unit(block[keyword])
    allowed = () if kind is None else UNITS[kind]
    if unit and unit.replace(" ", "") not in allowed:
        known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
        raise message.fault(f"{keyword} is in {cut(unit)}{known}.", line)
    found = float(value) if is_number(value.encode("ascii", "replace")) else math.nan
    if not math.isfinite(found):
        raise message.fault(f"{keyword} is {value[:40]!r}, which is no finite number.", line)
    return found


def needs(message: Collected, keyword: str) -> str:
    """The value of a keyword of the meta data; AttitudeError if it is missing."""
    if not message.meta.get(keyword):
        raise message.fault(f"the message lacks {keyword}.", None)
    return message.meta[keyword]


def one_of(
    message: Collected, block: Block, keyword: str, choices: Mapping[str, _Choice]
) -> _Choice:
    """The meaning of a keyword's value, out of some choices; AttitudeError for another value."""
    value = block.get(keyword)
    if value is None or value.upper() not in choices:
        given = "is not given" if value is None else f"is {cut(value)}"
        raise message.fault(
            f"{keyword} of the block {block.name} {given}; it must be one of "
            f"{', '.join(cut(each, '') for each in choices)}.",
            block.lines.get(keyword, block.line),
        )
    return choices[value.upper()]


# ---- Attitude Parameter Messages in KVN and XML, read into blocks with the keywords of version 2
# Version 1 has other keywords, and no marks around its blocks in KVN.


def read_kvn(lines: Lines, first: bytes) -> Collected:
    """The message of an APM in KVN.

    `first` is the first line that is not empty, which has been taken from `lines`.
    """
    version = kvn.version(lines, first, "APM", VERSIONS)
    message = Collected(version, lines.fault, lines.path)
    current: Block | None = None
    for line in lines:
        if line.strip() in (b"", b"META_START", b"META_STOP"):
            continue
        mark = line.strip().decode("ascii", "replace")
        if version != "1.0" and mark.endswith(("_START", "_STOP")) and "=" not in mark:
            current = _marked(message, mark, current, lines.number)
            continue
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            (message.comments if current is None else current.comments).append(value)
        elif current is None and message.put_common(keyword, value, lines.number):
            pass
        elif version == "1.0" and keyword in OLD:
            name, new = OLD[keyword]
            block = _open_block(message, name, keyword, lines.number)
            message.put(block, new, value, lines.number)
        elif current is not None and keyword in BLOCKS[current.name]:
            message.put(current, keyword, value, lines.number)
        else:
            raise message.unknown(keyword, lines.number)
    if current is not None:
        raise lines.fault(f"the file ends before {current.name}_STOP; is it cut off?")
    return message


def _marked(message, mark, current, line):
    """The block that is open after a line with _START or _STOP; None after _STOP."""
    name, _, end = mark.rpartition("_")
    if name not in BLOCKS:
        raise message.fault(
            f"{cut(mark, '')} is not known; blocks are {', '.join(BLOCKS)}, each with _START and "
            "_STOP.",
            line,
        )
    if end == "START":
        if current is not None:
            raise message.fault(f"{mark} stands before {current.name}_STOP.", line)
        message.blocks.append(Block(name, line))
        return message.blocks[-1]
    if current is None or current.name != name:
        raise message.fault(f"{mark} stands without {name}_START.", line)
    return None


def _open_block(message, name, keyword, line):
    """The block of version 1 for a keyword; each MAN_EPOCH_START begins a new maneuver."""
    found = [block for block in message.blocks if block.name == name]
    if not found or (name == "MAN" and keyword == "MAN_EPOCH_START"):
        message.blocks.append(Block(name, line))
        return message.blocks[-1]
    return found[-1]


# Elements that group keywords.
_GROUPS = ("quaternion", "quaternionDot", "quaternionRate", "rotationAngles", "rotationRates")
_OUTER = ("apm", "ndm", "header", "body", "segment", "metadata", "data")


def read_xml(path: FilePath) -> Collected:
    """The message of an APM in XML."""
    reader = _ApmReader(path)
    reader.run()
    if reader.message is None:
        raise reader.fault("there is no <apm> message in it.")
    return reader.message


class _ApmReader(ElementReader):
    """Collects the message.

    `_tags` are the tags of the open elements, `_comments` the comments before the message.
    """

    def __init__(self, path):
        super().__init__(path)
        self._block, self._tags, self._attributes = None, [], {}
        self._comments = []

    def begin(self, tag, attributes):
        if tag in MESSAGES or (self.message is None and tag not in OUTSIDE):
            version = self.version(tag, attributes, "apm", VERSIONS)
            self.message = Collected(version, self.fault, self.path)
            self.message.comments.extend(self._comments)
        elif self._tags[-1:] == ["data"] and tag in XML_BLOCKS:
            self._block = Block(XML_BLOCKS[tag], self.line)
            self.message.blocks.append(self._block)
        self._tags.append(tag)
        self._attributes = attributes

    def end(self, tag, text):
        self._tags.pop()
        if self.message is None:
            self._comments += [text] if tag == "COMMENT" else []
            return
        if tag in _OUTER or tag in _GROUPS:
            return
        if self._tags[-1:] == ["data"] and tag in XML_BLOCKS:
            self._block = None
        elif tag == "COMMENT":
            (self.message.comments if self._block is None else self._block.comments).append(text)
        elif self._block is None or (tag == "EPOCH" and "EPOCH" not in self.message.meta):
            if not self.message.put_common(tag, text, self.line):
                raise self.message.unknown(tag, self.line)
        else:
            self._put(tag, text)

    def _put(self, tag, text):
        unit = self._attributes.get("units")
        value = text if unit is None else f"{text} [{unit}]"
        label = self._attributes.get("angle") or self._attributes.get("rate")
        if tag in ("rotation1", "rotation2", "rotation3") and label in REPEATED:
            tag = label
        if self.message.version == "1.0" and tag in OLD:
            name, tag = OLD[tag]
            if name != self._block.name:
                raise self.message.unknown(tag, self.line)
        elif tag not in BLOCKS[self._block.name]:
            raise self.message.unknown(tag, self.line)
        self.message.put(self._block, tag, value, self.line)


# ---- Attitude, rates and inertia from the blocks of an Attitude Parameter Message

_DIRECTIONS = {"A2B": True, "B2A": False}


class Interpreted:
    """The state in the blocks of a message.

    Parameters
    ----------
    message : Collected
    tolerance, frame, orbit, products, rates
        As in `apm.read`.

    Attributes
    ----------
    epoch : Instant
        EPOCH of the message; set by `result`.
    """

    epoch: Instant

    def __init__(
        self,
        message: Collected,
        tolerance: float,
        frame: str | None,
        orbit: Path | None,
        products: str | None,
        rates: str | None = None,
    ):
        self._rates = _attitude_types.known_rates(rates)
        self._message, self._tolerance = message, tolerance
        self._frame, self._orbit = frame, orbit
        self._old = message.version == "1.0"
        self._products = known_products(products, message.version)
        # Block -> name of the body's axes in it.
        self._bodies: dict[str, str] = {}

    def result(
        self,
    ) -> tuple[Instant, FloatArray | None, FloatArray | None, Body | None, dict[str, Any]]:
        """The fields of `Parameters`: epoch, attitude, angular velocity, body, meta."""
        message = self._message
        for keyword in META:
            if keyword != "CENTER_NAME":
                needs(message, keyword)
        try:
            scale = ccsds_epochs.known(message.meta["TIME_SYSTEM"])
            self.epoch = ccsds_epochs.instant(needs(message, "EPOCH"), scale)
        except ccsds_epochs.BadEpoch as err:
            raise message.fault(
                f"EPOCH is {message.meta['EPOCH'][:38]!r}, no epoch: {err.reason}.",
                message.lines["EPOCH"],
            ) from err
        except AttitudeError as err:
            if str(err).startswith("TIME_SYSTEM"):
                raise message.fault(str(err), message.lines["TIME_SYSTEM"]) from err
            raise
        wxyz, rates, body_frame = self._state()
        meta = {
            "format": f"APM {message.version}",
            "header": dict(message.header),
            "comments": tuple(message.comments),
            "keywords": dict(message.meta),
            "blocks": tuple((b.name, dict(b), tuple(b.comments)) for b in message.blocks),
            "object_name": message.meta["OBJECT_NAME"],
            "object_id": message.meta["OBJECT_ID"],
            "center": message.meta.get("CENTER_NAME"),
            "body_frame": body_frame,
            "inertia_frame": self._inertia_frame(body_frame),
        }
        return self.epoch, wxyz, rates, self._body(), meta

    def _blocks(self, name):
        return [block for block in self._message.blocks if block.name == name]

    def _state(self):
        """Attitude and rates, each from the first block that has it; name of the body's axes."""
        attitude = rates = of_attitude = of_rates = None
        for name, meaning in (("QUAT", self._quat), ("EULER", self._euler), ("SPIN", self._spin)):
            for block in self._blocks(name)[:1]:
                found = self._named(meaning, block)
                if attitude is None and found[0] is not None:
                    attitude, of_attitude = found[0], block
                if rates is None and found[1] is not None:
                    rates, of_rates = found[1], block
        if attitude is None and self._blocks("INERTIA") and not self._blocks("ANGVEL"):
            return None, None, None
        if attitude is None:
            raise self._message.fault("the message has no attitude.", None)
        for block in self._blocks("ANGVEL")[:1]:
            rates, of_rates = self._named(self._angvel, block, attitude), block
        body = self._bodies[of_attitude.name]
        if rates is not None and self._bodies[of_rates.name].upper() != body.upper():
            raise self._message.fault(
                f"the block {of_rates.name} has the rates of "
                f"{cut(self._bodies[of_rates.name], '')}, but the block {of_attitude.name} the "
                f"attitude of {cut(body, '')}; a message is read for one "
                "body: delete one of the blocks.",
                of_rates.line,
            )
        if callable(rates):
            rates = self._named(rates, attitude)
        self._refuse_speed(rates)
        return attitude, rates, body

    def _named(self, meaning, block, *more):
        """What a block means; errors of its axes name the file and the line too."""
        try:
            return meaning(block, *more)
        except AttitudeError as err:
            if str(err).startswith(self._message.path):
                raise
            line = block.line if isinstance(block, Block) else None
            raise self._message.fault(str(err), line) from err

    def _refuse_speed(self, rates):
        try:
            refuse_speed(rates)
        except AttitudeError as err:
            raise self._message.fault(str(err), None) from err

    def _axes(self, block):
        """The external axes; whether the rotation leads from them to the body; whether A is it.

        The name of the body's axes is noted in `_bodies`.
        """
        message = self._message
        names = [block.get(key) for key in ("REF_FRAME_A", "REF_FRAME_B")]
        for key, name in zip(("REF_FRAME_A", "REF_FRAME_B"), names, strict=True):
            if not name:
                raise message.fault(f"the block {block.name} lacks {key}.", block.line)
        try:
            found, body, body_is_a = motions_axes.of_pair(*names, self._frame)
        except AttitudeError as err:
            raise message.fault(str(err), block.lines["REF_FRAME_B"]) from err
        self._bodies[block.name] = body
        to_body = not body_is_a
        if self._old and one_of(message, block, "DIR", _DIRECTIONS) is False:
            to_body = not to_body
        return found, to_body, body_is_a

    def _relative(self, kind, row, block, how, found):
        with np.errstate(over="ignore", invalid="ignore"):  # refuse_speed refuses overflow
            wxyz, rates = _attitude_types.decoded(kind, np.array([row]), how)
        return self._to_icrf(forms.unit(wxyz), rates, found)

    def _to_icrf(self, wxyz, rates, found):
        zero = np.zeros(1)
        wxyz, rates = to_icrf(wxyz, rates, found, self.epoch, zero, zero, self._orbit)
        return wxyz[0], None if rates is None else rates[0]

    def _numbers(self, block, names, kind=None):
        return [number(self._message, block, name, kind) for name in names]

    def _quat(self, block):
        found, to_body, _ = self._axes(block)
        row = self._numbers(block, ("Q1", "Q2", "Q3", "QC"))
        off = abs(float(np.sqrt(np.sum(np.square(row)))) - 1.0)
        if off > self._tolerance:
            raise self._message.fault(
                f"the length of the quaternion is off 1 by {off:.3g}; up to {self._tolerance:g} is "
                "accepted as rounding (tolerance=).",
                block.lines["QC"],
            )
        dots = [f"{name}_DOT" for name in ("Q1", "Q2", "Q3", "QC")]
        kind = "QUATERNION"
        if any(name in block for name in dots):
            row += self._numbers(block, dots, "DOT")
            kind = "QUATERNION/DERIVATIVE"
        return self._relative(kind, row, block, Convention(to_body=to_body), found)

    def _euler(self, block):
        found, to_body, body_is_a = self._axes(block)
        try:
            sequence = forms.known_sequence(block.get("EULER_ROT_SEQ", "").upper())
        except AttitudeError as err:
            raise self._message.fault(
                f"EULER_ROT_SEQ: {err}", block.lines.get("EULER_ROT_SEQ", block.line)
            ) from err
        how = Convention(to_body=to_body, sequence=sequence)
        if self._old:
            return self._old_euler(block, how, found, body_is_a)
        row = self._numbers(block, ("ANGLE_1", "ANGLE_2", "ANGLE_3"), "ANGLE")
        kind = "EULER_ANGLE"
        dots = ("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT")
        if any(name in block for name in dots):
            row += self._numbers(block, dots, "RATE")
            kind = "EULER_ANGLE/DERIVATIVE"
        return self._relative(kind, row, block, how, found)

    def _old_euler(self, block, how, found, body_is_a):
        """Version 1: angles under the names of their axes, rates over the axes of a frame."""
        letters = [name[0] for name, _, _ in block.order if name.endswith("_RATE")]
        derivatives = self._rates == "euler" or len(set(letters)) < len(letters)
        angles = self._by_axis(block, "ANGLE", how.sequence)
        rates = self._by_axis(block, "RATE", how.sequence if derivatives else None)
        wxyz = None
        if angles is not None:
            wxyz = self._relative("EULER_ANGLE", angles, block, how, found)[0]
        if rates is None:
            return wxyz, None
        if derivatives:
            return wxyz, self._of_derivatives(np.radians(rates), how, found)
        if self._rates is None:
            _attitude_types.warn(self._message.path, "the block of Euler angles")
        frames = {"EULER_FRAME_A": body_is_a, "EULER_FRAME_B": not body_is_a}
        over_body = one_of(self._message, block, "RATE_FRAME", frames)
        return wxyz, self._body_rates(np.radians(rates), over_body, found)

    def _of_derivatives(self, change, how, found):
        """A function: attitude -> rates relative to ICRF, from derivatives of Euler angles."""
        self._refuse_speed(change)

        def of(wxyz):
            zero = np.zeros(1)
            outer = found.to_icrf(self.epoch, zero, zero, self._orbit).reshape(4)
            inner = forms.multiply(forms.conjugate(outer), wxyz)
            rates = _attitude_types.of_euler_derivatives(inner[None], change[None], how)[0]
            own = found.angular_velocity(self.epoch, zero, zero, self._orbit)
            return rates if own is None else rates + forms.rotate(forms.conjugate(wxyz), own[0])

        return of

    def _body_rates(self, rates, over_body, found):
        """A function: attitude -> rates relative to ICRF, over the body axes."""

        self._refuse_speed(rates)

        def of(wxyz):
            zero = np.zeros(1)
            outer = found.to_icrf(self.epoch, zero, zero, self._orbit).reshape(4)
            body = forms.conjugate(wxyz)
            over = rates
            if not over_body:
                over = forms.rotate(forms.multiply(body, outer), rates)
            own = found.angular_velocity(self.epoch, zero, zero, self._orbit)
            return over if own is None else over + forms.rotate(body, own[0])

        return of

    def _by_axis(self, block, what, sequence):
        """Values of X_ANGLE, ... in the order of a sequence, or of X, Y, Z; None without any."""
        given = [item for item in block.order if item[0].endswith(f"_{what}")]
        if not given:
            return None
        needed = [f"{axis}_{what}" for axis in sequence or "XYZ"]
        names = [name for name, _, _ in given]
        if sorted(names) != sorted(needed):
            raise self._message.fault(
                f"the block EULER has {', '.join(names)}; {sequence or 'rates'} needs "
                f"{', '.join(needed)}.",
                given[0][2],
            )
        values = []
        for name in needed:
            place = next(k for k, item in enumerate(given) if item[0] == name)
            _, text, line = given.pop(place)
            block[name], block.lines[name] = text, line
            values.append(number(self._message, block, name, what))
        return values

    def _spin(self, block):
        found, _, _ = self._axes(block)
        row = self._numbers(block, ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE"), "ANGLE")
        row += self._numbers(block, ("SPIN_ANGLE_VEL",), "RATE")
        kind = "SPIN"
        if "NUTATION" in block:
            kind = "SPIN/NUTATION"
            row += self._numbers(block, ("NUTATION",), "ANGLE")
            row += self._numbers(block, ("NUTATION_PER",), "PERIOD")
            row += self._numbers(block, ("NUTATION_PHASE",), "ANGLE")
        elif "MOMENTUM_ALPHA" in block:
            kind = "SPIN/NUTATION_MOM"
            row += self._numbers(block, ("MOMENTUM_ALPHA", "MOMENTUM_DELTA"), "ANGLE")
            row += self._numbers(block, ("NUTATION_VEL",), "RATE")
        return self._relative(kind, row, block, Convention(), found)

    def _angvel(self, block, wxyz):
        found, to_body, body_is_a = self._axes(block)
        values = self._numbers(block, ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"), "RATE")
        a, b = block["REF_FRAME_A"].upper(), block["REF_FRAME_B"].upper()
        choices = {a: body_is_a, b: not body_is_a}
        over_body = one_of(self._message, block, "ANGVEL_FRAME", choices)
        rates = np.radians(values) * (1.0 if to_body else -1.0)
        return self._body_rates(rates, over_body, found)(wxyz)

    def _inertia_frame(self, body_frame):
        """Name of the axes of the inertia, by default the body's; None without inertia."""
        for block in self._blocks("INERTIA")[:1]:
            return block.get("INERTIA_REF_FRAME") or body_frame
        return None

    def _body(self):
        for block in self._blocks("INERTIA")[:1]:
            names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
            values = self._numbers(block, names, "INERTIA")
            try:
                return Body(tensor=tensor(values, self._products))
            except AttitudeError as err:
                raise self._message.fault(f"the inertia: {err}", block.line) from err
        return None


# ---- Attitude Parameter Messages to be written: their blocks, in either notation and version

# Name of a block, and its entries: keyword, value and unit ("" for none).
WrittenBlock: TypeAlias = tuple[str, list[tuple[str, str | float, str]]]


@dataclass
class WrittenMessage:
    """A message to be written.

    Attributes
    ----------
    version : str
    header, meta : dict of str
        Keyword -> value.
    comments : list of str
    epoch : str
        EPOCH, in the time system of the meta data.
    blocks : list of WrittenBlock
    """

    version: str
    header: dict[str, str]
    comments: list[str]
    meta: dict[str, str]
    epoch: str
    blocks: list[WrittenBlock]


def blocks(
    version: str,
    frame: str,
    body: str,
    wxyz: FloatArray,
    rates: FloatArray,
    meaning: str | None = None,
) -> list[WrittenBlock]:
    """The blocks of attitude and rates.

    Shapes: wxyz (4,), rates (3,).
    """
    quaternions: list[tuple[str, str | float, str]] = [
        (k, float(q), "") for k, q in zip(("Q1", "Q2", "Q3", "QC"), np.roll(wxyz, -1), strict=True)
    ]
    speeds = [float(rate) for rate in np.degrees(rates)]
    if version == "1.0":
        dots = np.roll(frames_representations.quaternion_rate(wxyz, rates), -1).tolist()
        names = ("Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT")
        first: list[tuple[str, str | float, str]]
        first = [("Q_FRAME_A", frame, ""), ("Q_FRAME_B", body, ""), ("Q_DIR", "A2B", "")]
        turning = [(name, dot, "1/s") for name, dot in zip(names, dots, strict=True)]
        found: list[WrittenBlock] = [("QUAT", [*first, *quaternions, *turning])]
        return found if meaning is None else [*found, _euler(frame, body, wxyz, rates, meaning)]
    frames: list[tuple[str, str | float, str]]
    frames = [("REF_FRAME_A", frame, ""), ("REF_FRAME_B", body, "")]
    components = [(f"ANGVEL_{a}", rate, "deg/s") for a, rate in zip("XYZ", speeds, strict=True)]
    return [
        ("QUAT", [*frames, *quaternions]),
        ("ANGVEL", [*frames, ("ANGVEL_FRAME", body, ""), *components]),
    ]


def _euler(frame, body, wxyz, rates, meaning):
    """The block of Euler angles of version 1."""
    angles = frames_representations.to_euler("ZYX", wxyz)
    speeds = np.degrees(rates)[::-1]
    if meaning == "euler":
        speeds = np.degrees(frames_representations.euler_rates("ZYX", angles, rates))
    return (
        "EULER",
        [
            *(("EULER_FRAME_A", frame, ""), ("EULER_FRAME_B", body, "")),
            *(("EULER_DIR", "A2B", ""), ("EULER_ROT_SEQ", "321", "")),
            ("RATE_FRAME", "EULER_FRAME_B", ""),
            *(
                (f"{a}_ANGLE", float(x), "deg")
                for a, x in zip("ZYX", np.degrees(angles), strict=True)
            ),
            *((f"{a}_RATE", float(x), "deg/s") for a, x in zip("ZYX", speeds, strict=True)),
        ],
    )


def inertia_block(version: str, body: Body, frame: str, products: str | None) -> WrittenBlock:
    """The block of inertia."""
    if body.relative:
        raise AttitudeError(
            "the moments of the body are relative, but an APM has kg m2; give moments in kg m2, or "
            "inertia=False."
        )
    names = ("11", "22", "33", "12", "13", "23")
    if version != "1.0":
        names = ("XX", "YY", "ZZ", "XY", "XZ", "YZ")
    values = inertia_values(body.tensor, known_products(products, version))
    entries = [(f"I{n}", value, "kg*m**2") for n, value in zip(names, values, strict=True)]
    return "INERTIA", [("INERTIA_REF_FRAME", frame, ""), *entries]


def write_kvn(file: IO[str], message: WrittenMessage) -> None:
    """Write a message in KEYWORD = value notation to an open file."""
    version = message.version
    file.write(f"CCSDS_APM_VERS = {version}\n")
    file.writelines(f"COMMENT {text}\n" for text in message.comments)
    for part in (message.header, message.meta):
        file.writelines(f"{key} = {value}\n" for key, value in part.items())
    file.write(f"EPOCH = {message.epoch}\n")
    for name, entries in message.blocks:
        file.write("\n" if version == "1.0" else f"\n{name}_START\n")
        for key, value, unit in entries:
            shown = value if isinstance(value, str) else repr(value)
            file.write(f"{key} = {shown}{f' [{unit}]' if unit else ''}\n")
        if version != "1.0":
            file.write(f"{name}_STOP\n")


def write_xml(file: IO[str], message: WrittenMessage) -> None:
    """Write a message in XML to an open file."""
    version = message.version
    schema = "2.0.0-master-2.0" if version == "1.0" else "4.0.0-master-4.0"

    def leaf(indent, key, value, unit="", attribute=""):
        shown = escaped(value) if isinstance(value, str) else repr(value)
        units = f' units="{unit}"' if unit else ""
        file.write(f"{' ' * indent}<{key}{attribute}{units}>{shown}</{key}>\n")

    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<apm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        '     xsi:noNamespaceSchemaLocation="https://sanaregistry.org/r/ndmxml_unqualified/'
        f'ndmxml-{schema}.xsd"\n     id="CCSDS_APM_VERS" version="{version}">\n  <header>\n'
    )
    for text in message.comments:
        leaf(4, "COMMENT", text)
    for key, value in message.header.items():
        leaf(4, key, value)
    file.write("  </header>\n  <body>\n    <segment>\n      <metadata>\n")
    for key, value in message.meta.items():
        leaf(8, key, value)
    file.write("      </metadata>\n      <data>\n")
    if version != "1.0":
        leaf(8, "EPOCH", message.epoch)
    for name, entries in message.blocks:
        element = XML_NAMES[version][name]
        file.write(f"        <{element}>\n")
        if version == "1.0" and name == "QUAT":
            leaf(10, "EPOCH", message.epoch)
        _write_entries(file, leaf, entries)
        file.write(f"        </{element}>\n")
    file.write("      </data>\n    </segment>\n  </body>\n</apm>\n")


def _write_entries(file, leaf, entries):
    """Write the keywords of a block; quaternion, angles and rates each have a group element."""
    groups = {
        "Q1": "quaternion",
        "Q1_DOT": "quaternionRate",
        "Z_ANGLE": "rotationAngles",
        "Z_RATE": "rotationRates",
    }
    inside, count = None, 0
    for key, value, unit in entries:
        if key in groups and inside is None:
            inside, count = groups[key], 0
            file.write(f"          <{inside}>\n")
        if inside is None:
            leaf(10, key, value, unit)
            continue
        count += 1
        if inside.startswith("quaternion"):
            leaf(12, key, value, unit)
        else:
            kind = "angle" if inside == "rotationAngles" else "rate"
            leaf(12, f"rotation{count}", value, unit, f' {kind}="{key}"')
        if count == (4 if inside.startswith("quaternion") else 3):
            file.write(f"          </{inside}>\n")
            inside = None


@dataclass(frozen=True, eq=False)
class Parameters:
    """The content of an APM.

    Attributes
    ----------
    epoch : Instant
    wxyz : (4,) array or None
        Attitude, body to ICRF, scalar first; None in a message with an inertia alone.
    angular_velocity : (3,) array or None
        rad/s over the body axes, relative to inertial space.
    body : Body or None
        Over the axes that INERTIA_REF_FRAME names (``meta["inertia_frame"]``).
    meta : dict
        Keywords of the header, the meta data and each block, and comments.
    """

    epoch: Instant
    wxyz: FloatArray | None
    angular_velocity: FloatArray | None
    body: Body | None
    meta: dict[str, Any] = field(repr=False)

    @property
    def spin(self) -> Spin:
        """The Spin, in ICRF; AttitudeError if the message has no attitude or angular velocity."""
        if self.wxyz is None:
            raise AttitudeError(
                "the message has no attitude; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        if self.angular_velocity is None:
            raise AttitudeError(
                "the message has no angular velocity; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        return Spin(self.epoch, self.wxyz, self.angular_velocity)

    @property
    def motion(self) -> FreeRotation:
        """The FreeRotation from this state; AttitudeError if the message lacks rates or inertia."""
        if self.body is None:
            raise AttitudeError(
                "the message has no inertia; give a Body: FreeRotation(body, parameters.spin)."
            )
        self.refuse_other_axes()
        return FreeRotation(self.body, self.spin)

    def refuse_other_axes(self) -> None:
        """AttitudeError if the inertia is over other axes than those whose attitude is given."""
        inertia, body = self.meta["inertia_frame"], self.meta["body_frame"]
        if body is None:
            return
        if inertia.upper() != body.upper():
            raise AttitudeError(
                f"the inertia is over the axes {cut(inertia, '')}, but the attitude is that of "
                f"{cut(body, '')}; give a Body over the axes of the attitude: "
                "FreeRotation(body, parameters.spin)."
            )


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    products: str | None = None,
    rates: str | None = None,
) -> Parameters:
    """A message as `Parameters`.

    Parameters
    ----------
    path, tolerance, frame, orbit
        As in `aem.read`.
    products : str, optional
        "tensor" if IXY is the entry of the inertia tensor, "integral" if the entry is -IXY; by
        default as in the book of the message's version (see `tensor`).
    rates : str, optional
        What X_RATE, Y_RATE, Z_RATE of version 1 are, as in `aem.read`.

    Raises
    ------
    AttitudeError
        As `aem.read`.
    """
    known_tolerance(tolerance)
    with opened(path) as lines:
        first = kvn.first(lines)
        message = None if first is None else read_kvn(lines, first)
    if message is None:
        message = read_xml(path)
    return Parameters(*Interpreted(message, tolerance, frame, orbit, products, rates).result())


def write(
    path: FilePath,
    motion: FreeRotation | Parameters,
    *,
    version: str = "2.0",
    xml: bool = False,
    frame: str | None = None,
    time_system: str = "UTC",
    inertia: bool = True,
    products: str | None = None,
    rates: str | None = None,
    object_name: str | None = None,
    object_id: str | None = None,
    center: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    creation_date: str | None = None,
    digits: int = ccsds_epochs.DIGITS,
) -> None:
    """Write the state and the inertia of a FreeRotation as an APM.

    Version 1 has the rates as derivatives of the quaternion; on those of its block of Euler angles
    readers disagree.

    Parameters
    ----------
    motion : FreeRotation or Parameters
        Names and comments of Parameters are kept unless others are given.
    frame : str, optional
        The external axes, which must be fixed; by default those of the spin.
    inertia : bool
        False leaves the inertia out (relative moments have no unit and cannot be written).
    products : str, optional
        As in `read`: the sign of the products of inertia.
    rates : str, optional
        Version 1.0: write the block of Euler angles (321) too, with "body" or "euler" rates.

    The other parameters are those of `aem.write`.

    Raises
    ------
    AttitudeError
        For unknown names of versions, axes or time systems, a state without rates or inertia, a
        motion whose angular velocity jumps, and a file that cannot be written.
    """
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; APM has {' and '.join(VERSIONS)}.")
    refuse_breaks(motion, "an APM")
    spin, body = motion.spin, motion.body if inertia else None
    if inertia and body is None:
        raise AttitudeError("there is no inertia to be written; give inertia=False.")
    meta: dict[str, Any] = {}
    if isinstance(motion, Parameters):
        meta = motion.meta
        if inertia:
            motion.refuse_other_axes()
    body_frame = body_frame or meta.get("body_frame") or "SC_BODY_1"
    center = center or meta.get("center")
    comments = list(meta.get("comments", ()) if comments is None else comments)
    found = motions_axes.named(frame or motions_axes.WRITTEN[spin.frame])
    if found.turning:
        raise AttitudeError(f"an APM is written in axes that do not turn, not {found.name}.")
    if (why := motions_axes.body_name_fault(body_frame)) is not None:
        raise AttitudeError(f"body_frame is {body_frame!r}, which {why}; give another name.")
    wxyz = spin.wxyz
    if found.kind != spin.frame:
        outer = forms.conjugate(found.to_icrf(spin.epoch, 0.0, None))
        wxyz = forms.multiply(outer, spin.wxyz_icrf)
    scale = ccsds_epochs.writable(time_system)
    message = WrittenMessage(
        version=version,
        header={"CREATION_DATE": creation_date or ccsds_epochs.now(), "ORIGINATOR": originator},
        comments=comments,
        meta={
            "OBJECT_NAME": object_name or meta.get("object_name") or "UNKNOWN",
            "OBJECT_ID": object_id or meta.get("object_id") or "UNKNOWN",
            **({"CENTER_NAME": center} if center else {}),
            "TIME_SYSTEM": scale.upper(),
        },
        epoch=ccsds_epochs.texts(spin.epoch, np.zeros(1), None, scale, digits)[0],
        blocks=blocks(
            version,
            found.name,
            body_frame,
            wxyz,
            spin.angular_velocity,
            _attitude_types.known_rates(rates),
        ),
    )
    if body is not None:
        message.blocks.append(inertia_block(version, body, body_frame, products))
    for text in (*message.header.values(), *message.meta.values(), *comments, body_frame):
        kvn.refuse_line_breaks(text)
    with written_whole(path, "the APM") as file:
        (write_xml if xml else write_kvn)(file, message)


def _opened(path, **keywords):
    message = read(path, **keywords)
    names = ("object_name", "object_id", "center", "comments")
    return OpenedFile(message.motion, {name: message.meta[name] for name in names})


def _labels(motion, said):
    """Names and comments, and whether the inertia has a unit to be written in."""
    return {"inertia": not motion.body.relative, **message_labels(motion, said)}


register_message(
    "apm",
    "CCSDS APM",
    write,
    module=__name__,
    read=_opened,
    reading=("tolerance", "frame", "orbit", "rates"),
    writing=("version", "frame", "time_system", "rates"),
    holds="motion",
    labels=_labels,
)
