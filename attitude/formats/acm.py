"""CCSDS Attitude Comprehensive Messages (504.0-B-2, section 5), KVN and XML, read and written.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.01, 0, 0.1),
...             covariance={"attitude": 0.01, "angular_velocity": 1e-4})
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.acm")
...     write(path, motion, t=[0.0, 10.0, 20.0], object_name="SATELLITE")
...     message = read(path)
>>> message.table.wxyz.shape, message.covariances[0].kind, message.body.moments.round(9)
((3, 4), 'ANGLE_ANGVEL', array([1., 2., 3.]))
>>> message.motion.at(10.0).wxyz.round(6) == motion.at(10.0).wxyz.round(6)
array([ True,  True,  True,  True])

The message holds variances, no correlations: those about the body axes are written.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._support import pairs
from attitude._textfiles import kvn
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import NoNumber, cut, is_number, numbers, opened
from attitude._textfiles.xml import MESSAGES, OUTSIDE, ElementReader, escaped
from attitude.epochs import _time_scales
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.formats import _attitude_types, _sampling, apm
from attitude.formats import _ccsds_epochs as ccsds_epochs
from attitude.formats._attitude_types import HEADER, Convention
from attitude.formats._format import of_table, register_message
from attitude.formats._records import TOLERANCE, columns_of, known_tolerance, refuse_length, to_icrf
from attitude.formats.apm import known_products, tensor
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _axes
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.motions._table import AttitudeTable
from attitude.torques._arcs import Arcs, Impulse

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude._support.annotations import Epochs, FilePath, FloatArray
    from attitude._textfiles.lines import Fault, Lines
    from attitude.formats._sampling import AttitudeSource, Records
    from attitude.motions._axes import Axes
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import Motion
    from attitude.paths._path import Path

__all__ = ["AttitudeCovariance", "Comprehensive", "Maneuver", "read", "write"]


# ---- Keywords, units and elements of XML of Attitude Comprehensive Messages
# Source: CCSDS 504.0-B-2, section 5; names of elements as in Orekit and ccsds-ndm.  The columns of
# covariances are variances: the message holds no correlations.

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


# ---- Maneuvers of an Attitude Comprehensive Message, as impulses and torques


@dataclass(frozen=True, eq=False)
class Maneuver:
    """A maneuver: the torque is not in the message, but what it achieves.

    Attributes
    ----------
    begin, end : Instant
        The same if the message gives neither a duration nor an end.
    purpose : str
    target_momentum : (3,) array or None
        Angular momentum after the maneuver, kg m2/s, over the axes of `momentum_frame`.
    momentum_frame : str or None
        TARGET_MOM_FRAME.
    target_attitude : (4,) array or None
        Attitude after the maneuver, scalar first: the numbers of the message, whose frames are
        those of its attitudes.
    target_spin_rate : float or None
        rad/s.
    values : mapping
        All keywords of the block.
    comments : tuple of str
    """

    begin: Instant
    end: Instant
    purpose: str
    target_momentum: FloatArray | None
    momentum_frame: str | None
    target_attitude: FloatArray | None
    target_spin_rate: float | None
    values: Mapping[str, str] = field(repr=False)
    comments: tuple[str, ...] = field(repr=False)

    def _target(self) -> tuple[FloatArray, bool]:
        """The angular momentum to be reached, and whether it is over body axes; else over ICRF."""
        if self.target_momentum is None:
            raise AttitudeError(
                f"the maneuver {cut(self.purpose)} has no TARGET_MOMENTUM, from which an impulse "
                "or a torque would follow."
            )
        found = _axes.known(self.momentum_frame or "")
        if found is None:
            if self.momentum_frame is None:
                raise AttitudeError(
                    f"the maneuver {cut(self.purpose)} has no TARGET_MOM_FRAME, the axes of its "
                    "TARGET_MOMENTUM; give the impulse yourself."
                )
            return self.target_momentum, True
        if found.turning:
            raise AttitudeError(
                f"TARGET_MOM_FRAME is {cut(found.name, '')}, axes that turn; they must be fixed, "
                "or the body's."
            )
        turn = found.to_icrf(self.begin, 0.0, None)
        return quaternion.rotate(turn, self.target_momentum), False

    def impulse(self) -> Impulse:
        """The maneuver as an Impulse in its middle, after which the momentum is the target.

        Raises
        ------
        AttitudeError
            Without a target momentum, or if its frame is unknown or turns.
        """
        target, of_body = self._target()

        def added(history: AttitudeHistory) -> FloatArray:
            momentum = history.motion.momentum_in_body(history)
            now = momentum if of_body else history.body_to_inertial(momentum)
            added_momentum: FloatArray = target - now.reshape(3)
            return added_momentum

        middle = self.begin.after(0.5 * self.end.since(self.begin))
        return Impulse(middle, added, "body" if of_body else "icrf")

    def mean_torque(self, momentum: FloatArray) -> FloatArray:
        """The mean torque (3,), N m, that leads from an angular momentum to the target.

        Parameters
        ----------
        momentum : (3,) array
            Before the maneuver, kg m2/s, over ICRF, or over body axes if the target is.

        Raises
        ------
        AttitudeError
            As `impulse`, and for a maneuver without a duration.
        """
        duration = self.end.since(self.begin)
        if not duration > 0.0:
            raise AttitudeError(
                f"the maneuver {cut(self.purpose)} has no duration, and an infinite torque; take "
                "impulse()."
            )
        torque: FloatArray = (self._target()[0] - momentum) / duration
        return torque


# ---- Attitude Comprehensive Messages in KVN and XML, read into blocks of keywords and rows

_USER = "USER_DEFINED_"


@dataclass
class AcmBlock:
    """A block of a message.

    Attributes
    ----------
    name : str
        One of BLOCKS.
    line : int
        Number of the line in which it begins.
    values, lines : dict
        Keyword -> value, and -> number of its line.
    comments : list of str
    tokens, places : list of bytes, list of int
        The entries of all rows, and the line of each row.
    width : int
        Entries of a row; 0 before the first.
    inner : list of AcmBlock
        Sensors.
    """

    name: str
    line: int
    values: dict[str, str] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    tokens: list[bytes] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    width: int = 0
    inner: list[AcmBlock] = field(default_factory=list)


class CollectedAcm:
    """A message while it is read.

    Parameters
    ----------
    path : str
    fault : callable
        Makes the error for a sentence and the number of a line.

    Attributes
    ----------
    path, fault
        As given.
    header, meta, lines : dict
        Keyword -> value; of both -> number of its line.
    comments, meta_comments : list of str
    blocks : list of AcmBlock
    """

    def __init__(self, path: str, fault: Fault):
        self.path: str = path
        self.fault: Fault = fault
        self.header: dict[str, str] = {}
        self.meta: dict[str, str] = {}
        self.lines: dict[str, int] = {}
        self.comments: list[str] = []
        self.meta_comments: list[str] = []
        self.blocks: list[AcmBlock] = []

    def put_common(self, where: str, keyword: str, value: str, line: int) -> None:
        """Add a keyword of the header or the meta data; AttitudeError if unknown or repeated."""
        into, known = (self.header, HEADER) if where == "header" else (self.meta, META)
        if keyword not in known:
            raise self.fault(
                f"{cut(keyword, '')} is not known in the {where} of an ACM; known are "
                f"{', '.join(known)}.",
                line,
            )
        if keyword in into:
            raise self.fault(f"{keyword} is given twice.", line)
        into[keyword], self.lines[keyword] = value, line

    def put(self, block: AcmBlock, keyword: str, value: str, line: int) -> None:
        """Add a keyword to a block; AttitudeError if it is unknown, repeated or behind rows."""
        known = BLOCKS[block.name]
        if keyword not in known and not (block.name == "USER" and keyword.startswith(_USER)):
            listed = ", ".join(known) or f"those that begin with {_USER}"
            raise self.fault(
                f"{cut(keyword, '')} is not known in the block {block.name}; known are {listed}.",
                line,
            )
        if keyword in block.values:
            raise self.fault(
                f"{cut(keyword, '')} is given twice, first in line {block.lines[keyword]}.", line
            )
        if block.tokens:
            raise self.fault(f"{keyword} stands behind the rows of its block.", line)
        block.values[keyword], block.lines[keyword] = value, line

    def row(self, block: AcmBlock, entries: list[bytes], line: int) -> None:
        """Add a row to a block; AttitudeError for another number of entries than before."""
        if block.width and len(entries) != block.width:
            raise self.fault(
                f"the row has {len(entries)} entries, and those before have {block.width}.", line
            )
        block.width = len(entries)
        block.tokens.extend(entries)
        block.places.append(line)

    def begin(self, name: str, outer: AcmBlock | None, line: int) -> AcmBlock:
        """Begin a block, inside of another one (a sensor) or not."""
        if outer is not None:
            if outer.name != "AD" or name != "SENSOR":
                raise self.fault(f"{name} begins before the end of {outer.name}.", line)
            outer.inner.append(AcmBlock(name, line))
            return outer.inner[-1]
        if name == "SENSOR":
            raise self.fault("SENSOR stands outside of AD.", line)
        if name in ONCE and any(block.name == name for block in self.blocks):
            raise self.fault(f"the message has a second block {name}; it may have one.", line)
        self.blocks.append(AcmBlock(name, line))
        return self.blocks[-1]


def read_kvn(lines: Lines, first: bytes) -> CollectedAcm:
    """The message of an ACM in KVN; `first` is the first line that is not empty."""
    kvn.version(lines, first, "ACM", VERSIONS)
    message = CollectedAcm(lines.path, lines.fault)
    where = "header"
    open_blocks: list[AcmBlock] = []
    for line in lines:
        text = line.strip()
        if not text:
            continue
        mark = text.decode("ascii", "replace")
        if mark.endswith(("_START", "_STOP")) and "=" not in mark and " " not in mark:
            where = _marked(message, mark, where, open_blocks, lines.number)
            continue
        block = open_blocks[-1] if open_blocks else None
        if block is not None and block.name in ROWS and _is_row(text):
            message.row(block, text.split(), lines.number)
            continue
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            comments = message.comments if where == "header" else message.meta_comments
            (comments if block is None else block.comments).append(value)
        elif block is not None:
            message.put(block, keyword, value, lines.number)
        elif where in ("header", "meta data"):
            message.put_common(where, keyword, value, lines.number)
        else:
            raise lines.fault(f"{cut(keyword, '')} stands outside of a block.")
    if open_blocks or where != "data":
        name = open_blocks[-1].name if open_blocks else "META"
        raise lines.fault(f"the file ends before {name}_STOP; is it cut off?")
    return message


def _is_row(text):
    """Whether a line is a row: it begins with a number or a date."""
    return b"=" not in text and text[:1] in b"+-.0123456789"


def _marked(message, mark, where, open_blocks, line):
    """Where the reader is after a line with _START or _STOP; changes `open_blocks`."""
    name, _, end = mark.rpartition("_")
    if name == "META":
        if (where, end) == ("header", "START"):
            return "meta data"
        if (where, end) == ("meta data", "STOP"):
            return "data"
        raise message.fault(f"{mark} stands in the wrong place; an ACM has one META block.", line)
    if name not in BLOCKS:
        raise message.fault(
            f"{cut(mark, '')} is not known; blocks are META, {', '.join(BLOCKS)}.", line
        )
    if where != "data":
        raise message.fault(f"{mark} stands before META_STOP.", line)
    if end == "START":
        outer = open_blocks[-1] if open_blocks else None
        open_blocks.append(message.begin(name, outer, line))
    elif not open_blocks or open_blocks[-1].name != name:
        raise message.fault(f"{mark} stands without {name}_START.", line)
    else:
        open_blocks.pop()
    return "data"


# ---- XML

_OUTER = ("acm", "ndm", "header", "body", "segment", "metadata", "data")


def read_xml(path: FilePath) -> CollectedAcm:
    """The message of an ACM in XML."""
    reader = _AcmReader(path)
    reader.run()
    if reader.message is None:
        raise reader.fault("there is no <acm> message in it.")
    found: CollectedAcm = reader.message
    return found


class _AcmReader(ElementReader):
    """Collects the message; `_tags` are those of the open elements, `_open` the open blocks."""

    def __init__(self, path):
        super().__init__(path)
        self._tags, self._open, self._attributes = [], [], {}
        self._comments = []

    def begin(self, tag, attributes):
        if tag in MESSAGES or (self.message is None and tag not in OUTSIDE):
            self.version(tag, attributes, "acm", VERSIONS)
            self.message = CollectedAcm(self.path, self.fault)
            self.message.comments.extend(self._comments)
        elif self._is_block(tag):
            outer = self._open[-1] if self._open else None
            self._open.append(self.message.begin(tag.upper(), outer, self.line))
        self._tags.append(tag)
        self._attributes = attributes

    def _is_block(self, tag):
        # Orekit writes <SENSOR>.
        if self._tags[-1:] == ["ad"]:
            return tag.lower() == "sensor"
        return self._tags[-1:] == ["data"] and tag.islower() and tag.upper() in BLOCKS

    def end(self, tag, text):
        self._tags.pop()
        if self.message is None:
            self._comments += [text] if tag == "COMMENT" else []
            return
        if tag in _OUTER:
            return
        above, block = self._tags[-1:], self._open[-1] if self._open else None
        if block is not None and tag.lower() == block.name.lower():
            self._open.pop()
        elif tag == "COMMENT":
            comments = self.message.meta_comments if above == ["metadata"] else None
            comments = self.message.comments if comments is None else comments
            (comments if block is None else block.comments).append(text)
        elif block is not None:
            self._in_block(block, tag, text)
        elif above == ["header"]:
            self.message.put_common("header", tag, text, self.line)
        elif above == ["metadata"]:
            self.message.put_common("meta data", tag, self._value(text), self.line)
        else:
            raise self.fault(f"<{tag[:40]}> stands outside of a block.")

    def _in_block(self, block, tag, text):
        if tag == ROWS.get(block.name):
            self.message.row(block, text.encode("ascii", "replace").split(), self.line)
        elif block.name == "USER" and tag == "USER_DEFINED":
            keyword = _USER + self._attributes.get("parameter", "")
            self.message.put(block, keyword, text, self.line)
        else:
            self.message.put(block, tag, self._value(text), self.line)

    def _value(self, text):
        unit = self._attributes.get("units")
        return text if unit is None else f"{text} [{unit}]"


# ---- The content of an Attitude Comprehensive Message


@dataclass(frozen=True, eq=False)
class AttitudeCovariance:
    """Variances of the attitude at epochs; the message holds no correlations.

    Attributes
    ----------
    epoch : Instant
    seconds, low : (N,) arrays
        seconds + low are TDB seconds since the epoch.
    kind : str
        COV_TYPE.
    variances : (N, columns) array
        rad2 of angles, pure numbers of quaternions (Q1, Q2, Q3, QC), rad2/s2 of angular velocities
        and biases of gyroscopes.
    frame : str or None
        COV_REF_FRAME: the axes of the angles and rates.
    meta : dict
        Keywords and comments of the block.
    """

    epoch: Instant
    seconds: FloatArray
    low: FloatArray
    kind: str
    variances: FloatArray
    frame: str | None
    meta: dict[str, Any] = field(repr=False)

    @property
    def matrix(self) -> FloatArray:
        """(N, columns, columns): the variances as diagonal matrices."""
        return self.variances[:, :, None] * np.eye(self.variances.shape[1])

    def in_icrf(self, table: AttitudeTable) -> FloatArray:
        """(N, 3, 3) rad2, covariance of the rotation vector over ICRF axes.

        Parameters
        ----------
        table : AttitudeTable
            The attitudes, of the body in whose axes the variances are.

        Raises
        ------
        AttitudeError
            For variances of quaternions or in the axes of another body, and for epochs at which
            the table has no attitude.
        """
        body = table.meta["body_frame"]
        if not self.kind.startswith("ANGLE"):
            raise AttitudeError(
                f"COV_TYPE is {self.kind}, whose variances are no covariance of a rotation; it "
                "must be one of ANGLE, ANGLE_GYROBIAS, ANGLE_ANGVEL."
            )
        if self.frame is not None and self.frame.upper() != body.upper():
            raise AttitudeError(
                f"COV_REF_FRAME is {cut(self.frame, '')}, and the attitudes are those of "
                f"{cut(body, '')}; the variances cannot be turned to ICRF."
            )
        shift = self.epoch.since(table.epoch)
        matrix = table.at(self.seconds + shift, self.low).matrix
        turned: FloatArray = matrix * self.variances[:, None, :3] @ np.swapaxes(matrix, -1, -2)
        return turned


@dataclass(frozen=True, eq=False)
class Comprehensive:
    """The content of an ACM.

    Attributes
    ----------
    epoch : Instant
        EPOCH_TZERO.
    tables : tuple of AttitudeTable
        One for each block of attitudes; `meta` has its keywords, and under "gyro_bias" (N, 3)
        rad/s the biases of gyroscopes.
    covariances : tuple of AttitudeCovariance
    body : Body or None
        Over the axes that INERTIA_REF_FRAME names (``meta["inertia_frame"]``).
    maneuvers : tuple of Maneuver
    meta : dict
        Header, meta data, comments, and the blocks PHYS, AD and USER as text.
    """

    epoch: Instant
    tables: tuple[AttitudeTable, ...]
    covariances: tuple[AttitudeCovariance, ...]
    body: Body | None
    maneuvers: tuple[Maneuver, ...]
    meta: dict[str, Any] = field(repr=False)

    @property
    def table(self) -> AttitudeTable:
        """The attitudes as one table; AttitudeError for none, or those of several bodies."""
        if not self.tables:
            raise AttitudeError("the message has no attitudes.")
        frames = list(dict.fromkeys(each.meta["body_frame"].upper() for each in self.tables))
        if len(frames) > 1:
            raise AttitudeError(
                f"the blocks of attitudes are those of {', '.join(frames)[:120]}; choose one of "
                "`tables` (in files of any format: segment=, on the command line --segment)."
            )
        return AttitudeTable.joined(self.tables)

    @property
    def motion(self) -> FreeRotation | Arcs:
        """The motion from the first attitude with an angular velocity, with maneuvers as impulses.

        Raises
        ------
        AttitudeError
            Without inertia or angular velocities, for an inertia over other axes, and as
            `Maneuver.impulse`.
        """
        rated = [each for each in self.tables if each.angular_velocity is not None]
        if self.body is None or not rated:
            lacking = "inertia" if self.body is None else "attitude with an angular velocity"
            raise AttitudeError(f"the message has no {lacking}, from which a motion would follow.")
        first, inertia = rated[0], self.meta["inertia_frame"]
        if inertia is not None and inertia.upper() != first.meta["body_frame"].upper():
            raise AttitudeError(
                f"the inertia is over the axes {cut(inertia, '')}, but the attitudes are those of "
                f"{cut(first.meta['body_frame'], '')}; give a Body over these axes."
            )
        assert first.angular_velocity is not None
        spin = Spin(
            first.epoch.after(first.seconds[0], first.low[0]),
            first.wxyz[0],
            first.angular_velocity[0],
        )
        later = [each for each in self.maneuvers if each.begin.since(spin.epoch) >= 0.0]
        if not later:
            return FreeRotation(self.body, spin)
        return Arcs(self.body, spin, [each.impulse() for each in later])


# ---- Rows of attitudes and covariances of an Attitude Comprehensive Message
# Conventions are those of `_attitude_types` for version 2.  A direction cosine matrix is that from
# A to B, column by column, as Orekit reads it; the components of ANGVEL are over the axes of B.


class TimeTags:
    """The times of rows: dates, or seconds since EPOCH_TZERO.

    Parameters
    ----------
    scale : str
        Time scale of the message in lower case.
    zero : Instant
        EPOCH_TZERO.
    """

    def __init__(self, scale: str, zero: Instant):
        self.scale: str = scale
        self.zero: Instant = zero
        hi, lo = np.float64(zero.seconds), np.float64(zero.low)
        # Seconds of UTC, TAI, TT and GPS are the same; those of TDB, TCB, TCG and UT1 are not.
        self._uniform = scale in ("utc", "tai", "tt", "gps")
        self._base = _time_scales.tt_from_tdb(hi, lo) if self._uniform else (hi, lo)

    def after(
        self, seconds: FloatArray, low: FloatArray | float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """TDB seconds since J2000, hi and lo, of seconds + low since EPOCH_TZERO."""
        hi, lo = pairs.add(self._base, seconds, low)
        if self._uniform:
            hi, lo = _time_scales.tdb_from("tt", hi, lo)
        return np.asarray(hi), np.asarray(lo)

    def text(self, hi: FloatArray, lo: FloatArray, digits: int) -> list[str]:
        """Seconds since EPOCH_TZERO, as decimal texts, of TDB seconds since J2000."""
        pair = _time_scales.tt_from_tdb(hi, lo) if self._uniform else (hi, lo)
        hi, lo = pairs.add(pair, -self._base[0], -self._base[1])
        whole = np.floor(hi)
        ticks = np.rint(((hi - whole) + lo) * 10.0**digits)
        carry = np.floor(ticks / 10.0**digits)
        whole, ticks = whole + carry, ticks - carry * 10.0**digits
        both = zip(whole.astype(np.int64).tolist(), ticks.astype(np.int64).tolist(), strict=True)
        return [f"{n}.{part:0{digits}d}" if digits else f"{n}" for n, part in both]

    def parsed(self, tokens: list[bytes]) -> tuple[FloatArray, FloatArray]:
        """TDB seconds since J2000 of tags; BadEpoch or NoNumber for those that cannot be read.

        A decimal number is read in two doubles.
        """
        dated = np.array([b"T" in token for token in tokens])
        hi, lo = np.empty(len(tokens)), np.empty(len(tokens))
        for which in (True, False):
            rows = np.flatnonzero(dated == which)
            some = [tokens[k] for k in rows]
            if not some:
                continue
            try:
                if which:
                    hi[rows], lo[rows] = ccsds_epochs.parsed(some, self.scale)
                else:
                    hi[rows], lo[rows] = self.after(*_decimals(some))
            except ccsds_epochs.BadEpoch as err:
                raise ccsds_epochs.BadEpoch(int(rows[err.index]), err.reason) from err
            except NoNumber as err:
                raise NoNumber(int(rows[err.line]), 0, some[err.line]) from err
        return hi, lo


def _decimals(tokens):
    """Numbers as pairs of doubles, (N,) and (N,): the digits before and behind the point."""
    whole = numbers(tokens, 1, [0])[:, 0]
    low = np.zeros(len(tokens))
    for k, token in enumerate(tokens):
        if _DECIMAL.fullmatch(token):
            first, _, rest = token.partition(b".")
            sign = -1.0 if first.startswith(b"-") else 1.0
            whole[k], low[k] = float(first), sign * float(b"0." + rest)
    return whole, low


# Such as 86400.333333333333, of which one double holds 11 decimals.
_DECIMAL = re.compile(rb"[+-]?\d{1,15}\.\d{1,18}")


def _rows(message: CollectedAcm, block: AcmBlock, tags: TimeTags, width: int) -> Any:
    """Epochs hi and lo (N,), and numbers (N, width), of a block's rows."""
    if not block.places:
        raise message.fault(f"the block {block.name} has no rows.", block.line)
    if block.width != width + 1:
        raise message.fault(
            f"a row has {block.width} entries; {block.name} of this type has a time and {width} "
            "numbers.",
            block.places[0],
        )
    step = width + 1
    try:
        values = numbers(block.tokens, step, range(1, step))
        hi, lo = tags.parsed(block.tokens[::step])
    except NoNumber as err:
        raise message.fault(f"{err.shown} is no number.", block.places[err.line]) from err
    except ccsds_epochs.BadEpoch as err:
        shown = cut(block.tokens[err.index * step].decode("ascii", "replace"))
        raise message.fault(
            f"the time {shown} cannot be read: {err.reason}.", block.places[err.index]
        ) from err
    finite = np.isfinite(values).all(axis=1) & np.isfinite(hi) & (np.abs(hi) < 1e15)
    if not np.all(finite):
        k = int(np.argmin(finite))
        raise message.fault("it holds a number that is not finite or too large.", block.places[k])
    steps = np.diff(hi) + np.diff(lo)
    if np.any(steps <= 0.0):
        k = int(np.argmax(steps <= 0.0))
        raise message.fault(
            "its time is not later than that of the row before.", block.places[k + 1]
        )
    return hi, lo, values


def _choice(message, block, keyword, choices, usual=None):
    value = block.values.get(keyword, usual)
    if value is None or value.upper() not in choices:
        given = "is missing" if value is None else f"is {cut(value)}"
        raise message.fault(
            f"{keyword} of the block {block.name} {given}; it must be one of "
            f"{', '.join(cut(each, '') for each in choices)}.",
            block.lines.get(keyword, block.line),
        )
    return value.upper()


def table(
    message: CollectedAcm,
    block: AcmBlock,
    tags: TimeTags,
    tolerance: float,
    frame: str | None,
    orbit: Path | None,
) -> AttitudeTable:
    """The AttitudeTable of a block ATT; see `acm.read` for the parameters.

    Raises
    ------
    AttitudeError
        For missing keywords, values that are not known, and rows that cannot be read.
    """
    kind = _choice(message, block, "ATT_TYPE", ATTITUDES)
    rate = _choice(message, block, "RATE_TYPE", RATES, "NONE")
    width = ATTITUDES[kind] + RATES[rate]
    states = block.values.get("NUMBER_STATES")
    if states is not None and states != str(width):
        raise message.fault(
            f"NUMBER_STATES is {cut(states)}; {kind} with the rates {rate} has {width}.",
            block.lines["NUMBER_STATES"],
        )
    for keyword in ("REF_FRAME_A", "REF_FRAME_B"):
        if not block.values.get(keyword):
            raise message.fault(f"the block ATT lacks {keyword}.", block.line)
    try:
        found, body, body_is_a = _axes.of_pair(
            block.values["REF_FRAME_A"], block.values["REF_FRAME_B"], frame
        )
    except AttitudeError as err:
        raise message.fault(str(err), block.lines["REF_FRAME_B"]) from err
    sequence = _sequence(message, block, kind, rate)
    hi, lo, values = _rows(message, block, tags, width)
    given, rest = values[:, : ATTITUDES[kind]], values[:, ATTITUDES[kind] :]
    how = Convention(to_body=not body_is_a, sequence=sequence, rates_over_body=not body_is_a)
    meta = _meta(message, block, found.name, body)
    epoch = Instant(float(hi[0]), float(lo[0]))
    seconds, low = pairs.add((hi, lo), -epoch.seconds, -epoch.low)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            wxyz, rates = _decoded(message, block, kind, rate, given, rest, how, tolerance)
        wxyz, rates = to_icrf(quaternion.unit(wxyz), rates, found, epoch, seconds, low, orbit)
        if rate == "GYRO_BIAS":
            meta["gyro_bias"] = np.radians(rest)
        return AttitudeTable(epoch, seconds, wxyz, low=low, angular_velocity=rates, meta=meta)
    except AttitudeError as err:
        if str(err).startswith(message.path):
            raise
        raise message.fault(str(err), block.line) from err


def _sequence(message, block, kind, rate):
    if kind != "EULER_ANGLES" and rate != "EULER_RATE":
        return None
    try:
        return quaternion.known_sequence(block.values.get("EULER_ROT_SEQ", "").upper())
    except AttitudeError as err:
        line = block.lines.get("EULER_ROT_SEQ", block.line)
        raise message.fault(f"EULER_ROT_SEQ: {err}", line) from err


def _decoded(message, block, kind, rate, given, rest, how, tolerance):
    """Attitudes and rates relative to the external axes, from the columns of a block."""
    if kind == "DCM":
        numbers_of = _quaternions(message, block, given, tolerance)
    elif kind == "QUATERNION":
        refuse_length(given, block.places, tolerance, message.fault)
        numbers_of = given
    else:
        numbers_of = forms.to_xyzw(quaternion.from_euler(how.sequence, np.radians(given)))
    columns, name = [numbers_of], "QUATERNION"
    if rate == "Q_DOT":
        columns, name = [numbers_of, rest], "QUATERNION/DERIVATIVE"
    elif rate in ("ANGVEL", "EULER_RATE"):
        columns, name = [numbers_of, rest], "QUATERNION/ANGVEL"
    if rate == "EULER_RATE":
        how = Convention(to_body=how.to_body, sequence=how.sequence, rates_of_angles=True)
    return _attitude_types.decoded(name, np.concatenate(columns, axis=1), how)


def _quaternions(message, block, given, tolerance):
    """The numbers of quaternions (N, 4), scalar last, of matrices that few digits distort."""
    matrices = given.reshape(-1, 3, 3)
    off = np.max(np.abs(np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)), axis=(1, 2))
    bad = ~(off <= 10.0 * tolerance) | ~(np.linalg.det(matrices) > 0.0)
    if np.any(bad):
        k = int(np.argmax(bad))
        raise message.fault(
            f"the matrix is no rotation: its product with its transpose is off 1 by {off[k]:.3g} "
            f"(up to {10.0 * tolerance:g} is accepted as rounding), or it is a reflection.",
            block.places[k],
        )
    left, _, right = np.linalg.svd(matrices)
    return forms.to_xyzw(
        quaternion.from_matrix(np.where(off[:, None, None] < 1e-12, matrices, left @ right))
    )


def _meta(message, block, frame, body):
    return {
        "format": "ACM 2.0",
        "keywords": dict(block.values),
        "data_comments": tuple(block.comments),
        "comments": tuple(message.comments),
        "object_name": message.meta.get("OBJECT_NAME"),
        "object_id": message.meta.get("INTERNATIONAL_DESIGNATOR"),
        "center": message.meta.get("CENTER_NAME"),
        "frame": frame,
        "body_frame": body,
        "time_system": message.meta["TIME_SYSTEM"].upper(),
    }


def covariance(message: CollectedAcm, block: AcmBlock, tags: TimeTags) -> AttitudeCovariance:
    """The variances of a block COV."""
    kind = _choice(message, block, "COV_TYPE", COVARIANCES)
    width, of_attitude = COVARIANCES[kind]
    hi, lo, values = _rows(message, block, tags, width)
    if np.any(values < 0.0):
        k = int(np.argmax(np.any(values < 0.0, axis=1)))
        raise message.fault("a variance is negative.", block.places[k])
    square = np.radians(1.0) ** 2
    first = 0 if kind.startswith("ANGLE") else of_attitude
    variances = values.copy()
    variances[:, first:] *= square
    meta = {"keywords": dict(block.values), "data_comments": tuple(block.comments)}
    epoch = Instant(float(hi[0]), float(lo[0]))
    seconds, low = pairs.add((hi, lo), -epoch.seconds, -epoch.low)
    frame = block.values.get("COV_REF_FRAME")
    return AttitudeCovariance(epoch, seconds, low, kind, variances, frame, meta)


# ---- The meaning of the blocks of an Attitude Comprehensive Message

_INERTIA = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
_DATES = ("START_TIME", "STOP_TIME", "NEXT_LEAP_EPOCH")


def interpreted(
    message: CollectedAcm,
    tolerance: float,
    frame: str | None,
    orbit: Path | None,
    products: str | None,
) -> Comprehensive:
    """The content of a message; see `acm.read` for the parameters."""
    products = known_products(products, "2.0")
    tags = _tags(message)
    blocks = message.blocks
    meta: dict[str, Any] = {
        "format": "ACM 2.0",
        "header": dict(message.header),
        "comments": tuple(message.comments),
        "keywords": dict(message.meta),
        "meta_comments": tuple(message.meta_comments),
        "object_name": message.meta["OBJECT_NAME"],
        "object_id": message.meta.get("INTERNATIONAL_DESIGNATOR"),
        "center": message.meta.get("CENTER_NAME"),
        "inertia_frame": None,
        "blocks": tuple(
            (b.name, dict(b.values), tuple(b.comments), tuple(dict(s.values) for s in b.inner))
            for b in blocks
        ),
    }
    body = None
    for block in blocks:
        if block.name == "PHYS":
            body = _body(message, block, products)
            meta["inertia_frame"] = block.values.get("INERTIA_REF_FRAME")
            _check_physics(message, block)
        elif block.name == "AD":
            _check_sensors(message, block)
    return Comprehensive(
        tags.zero,
        tuple(
            table(message, block, tags, tolerance, frame, orbit)
            for block in blocks
            if block.name == "ATT"
        ),
        tuple(covariance(message, b, tags) for b in blocks if b.name == "COV"),
        body,
        tuple(_maneuver(message, b, tags) for b in blocks if b.name == "MAN"),
        meta,
    )


def _tags(message):
    for keyword in NEEDED:
        if not message.meta.get(keyword):
            raise message.fault(f"the meta data lack {keyword}.", None)
    try:
        scale = ccsds_epochs.known(message.meta["TIME_SYSTEM"])
    except AttitudeError as err:
        raise message.fault(str(err), message.lines["TIME_SYSTEM"]) from err
    for keyword in _DATES:
        if keyword in message.meta and not is_number(message.meta[keyword].encode()):
            _instant(message, keyword, scale)
    zero = _instant(message, "EPOCH_TZERO", scale)
    return TimeTags(scale, zero)


def _instant(message: CollectedAcm, keyword: str, scale: str) -> Instant:
    try:
        return ccsds_epochs.instant(message.meta[keyword], scale)
    except ccsds_epochs.BadEpoch as err:
        raise message.fault(
            f"{keyword} is {cut(message.meta[keyword])}, no epoch: {err.reason}.",
            message.lines[keyword],
        ) from err


def _numbers(message: CollectedAcm, block: AcmBlock, keyword: str, count: int) -> Any:
    """The finite numbers of a keyword, (count,); a unit other than the standard's is refused."""
    value, unit = kvn.without_unit(block.values[keyword])
    line, allowed = block.lines[keyword], UNITS.get(keyword, ())
    if unit and unit.replace(" ", "") not in allowed:
        known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
        raise message.fault(f"{keyword} is in {cut(unit)}{known}.", line)
    words = value.split()
    good = all(is_number(w.encode("ascii", "replace")) and math.isfinite(float(w)) for w in words)
    if len(words) != count or not good:
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise message.fault(f"{keyword} is {cut(value)}; give {what}.", line)
    return np.array([float(word) for word in words])


def _body(message, block, products):
    given = [name for name in _INERTIA if name in block.values]
    if not given:
        return None
    lacking = [name for name in _INERTIA if name not in block.values]
    if lacking:
        raise message.fault(
            f"the block PHYS has {', '.join(given)}, but lacks {', '.join(lacking)}.", block.line
        )
    values = [float(_numbers(message, block, name, 1)[0]) for name in _INERTIA]
    try:
        return Body(tensor=tensor(values, products))
    except AttitudeError as err:
        raise message.fault(f"the inertia: {err}", block.line) from err


def _check_physics(message, block):
    if "CP_REF_FRAME" in block.values and "CP" not in block.values:
        raise message.fault("CP_REF_FRAME is given without CP.", block.lines["CP_REF_FRAME"])
    for keyword, count in (("CP", 3), ("WET_MASS", 1), ("DRY_MASS", 1), ("DRAG_COEFF", 1)):
        if keyword in block.values:
            _numbers(message, block, keyword, count)


def _check_sensors(message, block):
    """Sensors are counted from 1, each once, and have as many deviations as they state."""
    found: dict[int, int] = {}
    for sensor in block.inner:
        text = sensor.values.get("SENSOR_NUMBER", "")
        number = int(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0
        line = sensor.lines.get("SENSOR_NUMBER", sensor.line)
        if not number:
            raise message.fault(f"SENSOR_NUMBER is {cut(text)}; count from 1.", line)
        if number in found:
            raise message.fault(
                f"SENSOR_NUMBER {number} was used before, in line {found[number]}.", line
            )
        found[number] = line
        count, values = "NUMBER_SENSOR_NOISE_COVARIANCE", "SENSOR_NOISE_STDDEV"
        if (count in sensor.values) != (values in sensor.values):
            raise message.fault(f"{count} and {values} belong together.", sensor.line)
        if count in sensor.values:
            text = sensor.values[count]
            states = int(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0
            if not states:
                raise message.fault(
                    f"{count} is {cut(text)}; give a whole number.", sensor.lines[count]
                )
            _numbers(message, sensor, values, states)
    lacking = sorted(set(range(1, len(found) + 1)) - set(found))
    if lacking:
        raise message.fault(
            f"the block AD has {len(found)} sensors, but none of SENSOR_NUMBER {lacking[0]}.",
            block.line,
        )


def _maneuver(message, block, tags):
    values = block.values
    for keyword in ("MAN_PURPOSE", "MAN_BEGIN_TIME"):
        if not values.get(keyword):
            raise message.fault(f"the block MAN lacks {keyword}.", block.line)
    if "MAN_END_TIME" in values and "MAN_DURATION" in values:
        raise message.fault(
            "MAN_END_TIME and MAN_DURATION are given; give one of both.",
            block.lines["MAN_DURATION"],
        )
    if "TARGET_MOM_FRAME" in values and "TARGET_MOMENTUM" not in values:
        raise message.fault(
            "TARGET_MOM_FRAME is given without TARGET_MOMENTUM.", block.lines["TARGET_MOM_FRAME"]
        )

    def number(keyword):
        return float(_numbers(message, block, keyword, 1)[0]) if keyword in values else None

    first, last = number("MAN_BEGIN_TIME"), number("MAN_END_TIME")
    assert first is not None
    if last is None:
        last = first + (number("MAN_DURATION") or 0.0)
    if last < first or max(abs(first), abs(last)) > 1e15:
        raise message.fault("the maneuver ends before it begins.", block.line)
    begin, end = (_after(tags, seconds) for seconds in (first, last))
    target = attitude = None
    if "TARGET_MOMENTUM" in values:
        target = _numbers(message, block, "TARGET_MOMENTUM", 3)
    if "TARGET_ATTITUDE" in values:
        numbers = _numbers(message, block, "TARGET_ATTITUDE", 4)
        if not abs(float(np.linalg.norm(numbers)) - 1.0) < 1e-3:
            raise message.fault(
                "TARGET_ATTITUDE is no quaternion of unit length.", block.lines["TARGET_ATTITUDE"]
            )
        attitude = quaternion.unit(np.roll(numbers, 1))
    rate = number("TARGET_SPINRATE")
    return Maneuver(
        begin,
        end,
        values["MAN_PURPOSE"],
        target,
        values.get("TARGET_MOM_FRAME"),
        attitude,
        None if rate is None else math.radians(rate),
        dict(values),
        tuple(block.comments),
    )


def _after(tags, seconds):
    from attitude.epochs._instants import Instant

    hi, lo = tags.after(np.array([seconds]))
    return Instant(float(hi[0]), float(lo[0]))


# ---- Blocks of an Attitude Comprehensive Message to be written, in KVN and XML

# Texts of epochs, and columns, of some rows.
RowPieces: TypeAlias = Iterator[tuple[list[str], Any]]


@dataclass
class AcmBlockOut:
    """A block to be written.

    Attributes
    ----------
    name : str
    entries : list of (keyword, text)
    rows : callable or None
        Returns the rows piece by piece.
    comments : tuple of str
    """

    name: str
    entries: list[tuple[str, str]]
    rows: Callable[[], RowPieces] | None = None
    comments: tuple[str, ...] = field(default=())


def attitudes(
    part: Records,
    frame: str,
    found: Axes,
    body: str,
    texts: Callable[[AttitudeHistory], list[str]],
    orbit: Path | None,
) -> AcmBlockOut:
    """The block ATT of a segment: quaternions, with angular velocities if it has them."""
    kind = "QUATERNION/ANGVEL" if part.has_rates else "QUATERNION"
    entries = [("REF_FRAME_A", frame), ("REF_FRAME_B", body)]
    entries += [("NUMBER_STATES", "7" if part.has_rates else "4"), ("ATT_TYPE", "QUATERNION")]
    if part.has_rates:
        entries.append(("RATE_TYPE", "ANGVEL"))

    def rows() -> RowPieces:
        for history in part.pieces():
            yield texts(history), columns_of(history, kind, Convention(), found, orbit)

    return AcmBlockOut("ATT", entries, rows, tuple(part.meta.get("data_comments", ())))


def covariances(
    part: Records, body: str, texts: Callable[[AttitudeHistory], list[str]]
) -> AcmBlockOut:
    """The block COV of a segment: variances about the body axes, and of angular velocities."""
    entries = [("COV_BASIS", "PREDICTED"), ("COV_REF_FRAME", body), ("COV_TYPE", "ANGLE_ANGVEL")]

    def rows() -> RowPieces:
        for history in part.pieces():
            given = np.asarray(history.covariance)
            turn = np.swapaxes(history.matrix, -1, -2)
            angles = turn @ given[:, :3, :3] @ np.swapaxes(turn, -1, -2)
            both = [np.diagonal(m, axis1=1, axis2=2) for m in (angles, given[:, 3:, 3:])]
            yield texts(history), np.concatenate(both, axis=1) * np.degrees(1.0) ** 2

    return AcmBlockOut("COV", entries, rows)


def physics(body: Body, frame: str, products: str | None) -> AcmBlockOut:
    """The block PHYS of a body in kg m2; `products` as in `acm.read`."""
    names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
    values = apm.inertia_values(body.tensor, apm.known_products(products, "2.0"))
    entries = [("INERTIA_REF_FRAME", frame)]
    if body.mass is not None:
        entries.insert(0, ("WET_MASS", repr(float(body.mass))))
    entries += [(name, repr(value)) for name, value in zip(names, values, strict=True)]
    return AcmBlockOut("PHYS", entries)


def maneuvers(
    motion: Motion,
    seconds: Callable[[float, float], str],
    first: float,
    last: float,
    axes_of: tuple[str, Axes],
) -> list[AcmBlockOut]:
    """A block MAN for each impulse of a motion, with the angular momentum after it.

    Shapes: axes_of (str, Axes).
    """
    name, axes = ("ICRF", None) if axes_of[1].turning else axes_of
    inner = None if axes is None else quaternion.conjugate(axes.to_icrf(motion.epoch, 0.0, None))
    found = []
    for hi, lo in motion.breaks():
        if not first <= hi <= last:
            continue
        after = motion.at(np.array([hi]), np.array([lo]))
        before = motion.at(np.array([hi]), np.array([np.nextafter(lo, -np.inf)]))
        was, now = (
            quaternion.rotate(h.wxyz, h.motion.momentum_in_body(h))[0] for h in (before, after)
        )
        if np.linalg.norm(now - was) <= 1e-12 * np.linalg.norm(now):
            continue  # a change of the inertia alone
        now = now if inner is None else quaternion.rotate(inner, now)
        momentum = " ".join(repr(float(x)) for x in now)
        entries = [("MAN_PURPOSE", "ATT_ADJUST"), ("MAN_BEGIN_TIME", seconds(hi, lo))]
        entries += [("MAN_DURATION", "0.0"), ("TARGET_MOMENTUM", momentum)]
        found.append(AcmBlockOut("MAN", [*entries, ("TARGET_MOM_FRAME", name)]))
    return found


def write_kvn(
    file: IO[str],
    header: dict[str, str],
    comments: list[str],
    meta: dict[str, str],
    blocks: list[AcmBlockOut],
) -> None:
    """Write a message in KEYWORD = value notation to an open file."""
    file.write("CCSDS_ACM_VERS = 2.0\n")
    file.writelines(f"COMMENT {text}\n" for text in comments)
    file.writelines(f"{key} = {value}\n" for key, value in header.items())
    file.write("\nMETA_START\n")
    file.writelines(f"{key} = {value}\n" for key, value in meta.items())
    file.write("META_STOP\n")
    for block in blocks:
        file.write(f"\n{block.name}_START\n")
        file.writelines(f"COMMENT {text}\n" for text in block.comments)
        for key, value in block.entries:
            unit = f" [{UNITS[key][0]}]" if key in UNITS else ""
            file.write(f"{key} = {value}{unit}\n")
        for text in _row_texts(block):
            file.write(text + "\n")
        file.write(f"{block.name}_STOP\n")


def write_xml(
    file: IO[str],
    header: dict[str, str],
    comments: list[str],
    meta: dict[str, str],
    blocks: list[AcmBlockOut],
) -> None:
    """Write a message in XML to an open file."""
    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<acm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        '     xsi:noNamespaceSchemaLocation="https://sanaregistry.org/r/ndmxml_unqualified/'
        'ndmxml-4.0.0-master-4.0.xsd"\n     id="CCSDS_ACM_VERS" version="2.0">\n  <header>\n'
    )

    def leaf(indent: int, key: str, value: str) -> None:
        unit = f' units="{UNITS[key][0]}"' if key in UNITS else ""
        file.write(f"{' ' * indent}<{key}{unit}>{escaped(value)}</{key}>\n")

    for text in comments:
        leaf(4, "COMMENT", text)
    for key, value in header.items():
        leaf(4, key, value)
    file.write("  </header>\n  <body>\n    <segment>\n      <metadata>\n")
    for key, value in meta.items():
        leaf(8, key, value)
    file.write("      </metadata>\n      <data>\n")
    for block in blocks:
        file.write(f"        <{block.name.lower()}>\n")
        for text in block.comments:
            leaf(10, "COMMENT", text)
        for key, value in block.entries:
            leaf(10, key, value)
        for text in _row_texts(block):
            leaf(10, ROWS[block.name], text)
        file.write(f"        </{block.name.lower()}>\n")
    file.write("      </data>\n    </segment>\n  </body>\n</acm>\n")


def _row_texts(block):
    """The rows of a block as texts."""
    if block.rows is None:
        return
    for epochs, columns in block.rows():
        row = "%s" + " %r" * columns.shape[1]
        for each in zip(epochs, *columns.T.tolist(), strict=True):
            yield row % each


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    products: str | None = None,
) -> Comprehensive:
    """A message as `Comprehensive`.

    Parameters
    ----------
    path : str or path
        KVN or XML, recognized by the content.
    tolerance, frame, orbit
        As in `aem.read`.
    products : str, optional
        As in `apm.read`; by default the entry of the inertia tensor is -IXY.

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
    return interpreted(message, tolerance, frame, orbit, products)


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    xml: bool = False,
    covariance: bool | None = None,
    frame: str | None = None,
    time_system: str | None = None,
    products: str | None = None,
    object_name: str | None = None,
    object_id: str | None = None,
    center: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    creation_date: str | None = None,
    digits: int = ccsds_epochs.DIGITS,
    orbit: Path | None = None,
) -> None:
    """Write attitudes as an ACM, with the body, the impulses and the errors of their motion.

    Each segment becomes a block ATT (quaternions and angular velocities, at seconds since the first
    epoch); the inertia in kg m2 a block PHYS; each impulse of `Arcs` a block MAN without duration,
    with the angular momentum after it; standard deviations a block COV for each segment.

    Parameters
    ----------
    path, source, t, frame, time_system, object_name, object_id, center
        As in `aem.write`.
    body_frame, originator, comments, creation_date, digits, orbit
        As in `aem.write`.
    xml : bool
        XML instead of KVN.
    covariance : bool, optional
        Write variances; by default if the spin of the motion has a covariance (that of a
        `Fit.motion` has).
    products : str, optional
        As in `read`.

    Raises
    ------
    AttitudeError
        As `aem.write`, and for variances of a motion without a covariance.
    """
    parts = _sampling.segments(source, t)
    motion, meta = parts[0].motion, parts[0].meta
    found = _axes.named(frame or meta.get("frame") or "ICRF")
    name = _axes.WRITTEN[found.kind] if found.name.islower() else found.name
    body = body_frame or meta.get("body_frame") or "SC_BODY_1"
    if (why := _axes.body_name_fault(body)) is not None:
        raise AttitudeError(f"body_frame is {body!r}, which {why}; give another name.")
    scale = ccsds_epochs.writable(time_system or meta.get("time_system") or "UTC")

    begin = parts[0].first_and_last()
    end = parts[-1].first_and_last()
    start, _ = ccsds_epochs.texts(parts[0].epoch, *begin, scale, digits)
    _, stop = ccsds_epochs.texts(parts[-1].epoch, *end, scale, digits)
    tags = TimeTags(scale, ccsds_epochs.instant(start, scale))

    def texts(history: Any) -> list[str]:
        low = 0.0 if history.low is None else history.low
        epoch = history.epoch
        return tags.text(*pairs.add((history.seconds, low), epoch.seconds, epoch.low), digits)

    blocks = [attitudes(part, name, found, body, texts, orbit) for part in parts]
    if motion.body is not None and not motion.body.relative:
        blocks.append(physics(motion.body, body, products))
    if covariance is None:
        covariance = _has_covariance(parts[0])
    if covariance:
        blocks += [covariances(part, body, texts) for part in parts]
    if motion.body is not None and not motion.body.relative:
        blocks += maneuvers(
            motion,
            lambda hi, lo: _text_of(tags, motion.epoch.after(hi, lo), digits),
            float(begin[0][0]),
            float(end[0][1]),
            (name, found),
        )
    header = {"CREATION_DATE": creation_date or ccsds_epochs.now(), "ORIGINATOR": originator}
    keywords = {
        "OBJECT_NAME": object_name or meta.get("object_name") or "UNKNOWN",
        "INTERNATIONAL_DESIGNATOR": object_id or meta.get("object_id") or "UNKNOWN",
        **({"CENTER_NAME": center or meta["center"]} if center or meta.get("center") else {}),
        "TIME_SYSTEM": scale.upper(),
        "EPOCH_TZERO": start,
        "ACM_DATA_ELEMENTS": ", ".join(block.name for block in blocks),
        "START_TIME": start,
        "STOP_TIME": stop,
    }
    lines = list(meta.get("comments", ()) if comments is None else comments)
    more = [text for block in blocks for text in block.comments]
    for text in (*header.values(), *keywords.values(), *lines, *more, body):
        kvn.refuse_line_breaks(text)
    with written_whole(path, "the ACM") as file:
        (write_xml if xml else write_kvn)(file, header, lines, keywords, blocks)


def _has_covariance(part):
    """Whether the motion of a segment knows its errors."""
    try:
        part.motion.covariance_at(part.seconds[:1])
    except AttitudeError:
        return False
    return True


def _text_of(tags, instant, digits):
    """Seconds from EPOCH_TZERO to an Instant, as text."""
    return tags.text(np.array([instant.seconds]), np.array([instant.low]), digits)[0]


def _opened(path, *, segment, **keywords):
    """The attitudes of an ACM, or its motion if it has none."""
    message = read(path, **keywords)
    if segment is not None:
        if not 0 <= segment < len(message.tables):
            raise AttitudeError(
                f"{os.fspath(path)}: segment is {segment!r}; the message has {len(message.tables)} "
                "blocks of attitudes, counted from 0."
            )
        return of_table(message.tables[segment])
    try:
        return of_table(message.table if message.tables else message.motion)
    except AttitudeError as err:
        raise AttitudeError(f"{os.fspath(path)}: {err}") from err


register_message(
    "acm",
    "CCSDS ACM",
    write,
    module=__name__,
    read=_opened,
    reading=("tolerance", "frame", "orbit", "segment"),
    writing=("frame", "time_system", "orbit"),
    noun="an ACM",
    is_sampled=False,
)
