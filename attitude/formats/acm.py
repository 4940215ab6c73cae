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
import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import pairs
from attitude._textfiles import messages
from attitude._textfiles.lines import NoNumber, cut, numbers, prefixed
from attitude._textfiles.messages import Form, Generator, comparable, refuse_line_breaks
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _time_scales
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.formats import _messages, _sampling
from attitude.formats._aem_message import refuse_contradictions
from attitude.formats._format import of_table, refuse_foreign, register_message
from attitude.formats._messages import INERTIA
from attitude.formats._records import (
    ANGLES,
    ANGLES_DOT,
    ANGVEL,
    Q_DOT,
    TOLERANCE,
    Convention,
    Q,
    Rows,
    columns_of,
    in_icrf,
    known_tolerance,
    refuse_length,
)
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _axes
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.motions._table import AttitudeTable
from attitude.torques._arcs import Arcs, Impulse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from attitude._support.annotations import Epochs, FilePath, FloatArray
    from attitude.formats._sampling import AttitudeSource
    from attitude.motions._history import AttitudeHistory
    from attitude.paths._path import Path

__all__ = ["AttitudeCovariance", "Comprehensive", "Maneuver", "read", "write"]


# ---- Keywords and elements of XML
# Source: CCSDS 504.0-B-2, section 5; names of elements as in Orekit and ccsds-ndm.  The columns of
# covariances are variances: the message holds no correlations.

_BLOCKS: dict[str, tuple[str, ...]] = {
    "ATT": (
        "ATT_ID",
        "ATT_PREV_ID",
        "ATT_BASIS",
        "ATT_BASIS_ID",
        "REF_FRAME_A",
        "REF_FRAME_B",
        "EULER_ROT_SEQ",
        "NUMBER_STATES",
        "ATT_TYPE",
        "RATE_TYPE",
    ),
    "PHYS": (
        "DRAG_COEFF",
        "WET_MASS",
        "DRY_MASS",
        "CP_REF_FRAME",
        "CP",
        "INERTIA_REF_FRAME",
        *INERTIA,
    ),
    "COV": ("COV_ID", "COV_PREV_ID", "COV_BASIS", "COV_BASIS_ID", "COV_REF_FRAME", "COV_TYPE"),
    "MAN": (
        "MAN_ID",
        "MAN_PREV_ID",
        "MAN_PURPOSE",
        "MAN_BEGIN_TIME",
        "MAN_END_TIME",
        "MAN_DURATION",
        "ACTUATOR_USED",
        "TARGET_MOMENTUM",
        "TARGET_MOM_FRAME",
        "TARGET_ATTITUDE",
        "TARGET_SPINRATE",
    ),
    "AD": (
        "AD_ID",
        "AD_PREV_ID",
        "AD_METHOD",
        "ATTITUDE_SOURCE",
        "EULER_ROT_SEQ",
        "NUMBER_STATES",
        "ATTITUDE_STATES",
        "COV_TYPE",
        "REF_FRAME_A",
        "REF_FRAME_B",
        "RATE_STATES",
        "SIGMA_U",
        "SIGMA_V",
        "RATE_PROCESS_NOISE_STDDEV",
    ),
    "SENSOR": (
        "SENSOR_NUMBER",
        "SENSOR_USED",
        "NUMBER_SENSOR_NOISE_COVARIANCE",
        "SENSOR_NOISE_STDDEV",
        "SENSOR_FREQUENCY",
    ),
    "USER": ("USER_DEFINED_*",),
}
_FORM = Form(
    "ACM",
    ("2.0",),
    _messages.HEADER,
    meta=(
        "OBJECT_NAME",
        "INTERNATIONAL_DESIGNATOR",
        "CATALOG_NAME",
        "OBJECT_DESIGNATOR",
        "ORIGINATOR_POC",
        "ORIGINATOR_POSITION",
        "ORIGINATOR_PHONE",
        "ORIGINATOR_EMAIL",
        "ORIGINATOR_ADDRESS",
        "ODM_MSG_LINK",
        "CENTER_NAME",
        "TIME_SYSTEM",
        "EPOCH_TZERO",
        "ACM_DATA_ELEMENTS",
        "START_TIME",
        "STOP_TIME",
        "TAIMUTC_AT_TZERO",
        "NEXT_LEAP_EPOCH",
        "NEXT_LEAP_TAIMUTC",
    ),
    blocks=_BLOCKS,
    needed=("OBJECT_NAME", "TIME_SYSTEM", "EPOCH_TZERO"),
    units=_messages.UNITS,
    # Orekit writes <SENSOR>.
    elements={**{name.lower(): name for name in _BLOCKS}, "SENSOR": "SENSOR"},
    rows={"ATT": "attLine", "COV": "covLine"},
    inner={"SENSOR": "AD"},
    once=("PHYS", "AD", "USER"),
    marks={"metadata": "META"},
)
# ATT_TYPE and RATE_TYPE -> columns.
_ATTITUDES = {
    "QUATERNION": Q,
    "EULER_ANGLES": ANGLES,
    "DCM": tuple(f"entry {i} {j}" for i in (1, 2, 3) for j in (1, 2, 3)),
}
_RATES = {
    "NONE": (),
    "ANGVEL": ANGVEL,
    "Q_DOT": Q_DOT,
    "EULER_RATE": ANGLES_DOT,
    "GYRO_BIAS": tuple(f"the bias {k}" for k in "XYZ"),
}
# RATE_TYPE -> the attitude type of a quaternion with such rates, if it is not QUATERNION.
_DECODED = {
    "ANGVEL": "QUATERNION/ANGVEL",
    "Q_DOT": "QUATERNION/DERIVATIVE",
    "EULER_RATE": "QUATERNION/ANGVEL",
}
# COV_TYPE -> columns, of which those of the attitude stand first.
_COVARIANCES = {
    f"{kind}{rates}": (*columns, *more)
    for kind, columns in (("ANGLE", ANGLES), ("QUATERNION", Q))
    for rates, more in (("", ()), ("_GYROBIAS", _RATES["GYRO_BIAS"]), ("_ANGVEL", ANGVEL))
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
        axes = _axes.known(self.momentum_frame or "")
        if axes is None:
            if self.momentum_frame is None:
                raise AttitudeError(
                    f"the maneuver {cut(self.purpose)} has no TARGET_MOM_FRAME, the axes of its "
                    "TARGET_MOMENTUM; give the impulse yourself."
                )
            return self.target_momentum, True
        if axes.turning:
            raise AttitudeError(
                f"TARGET_MOM_FRAME is {cut(axes.name, '')}, axes that turn; they must be fixed, "
                "or the body's."
            )
        turn = axes.to_icrf(self.begin, np.zeros(()), None)
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


# ---- The content of an Attitude Comprehensive Message

# s: more than the rounding of an epoch.
_ROUNDING = 1e-9


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
        if self.frame is not None and comparable(self.frame) != comparable(body):
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
        """The attitudes as one table.

        AttitudeError for none, for those of several bodies, and for blocks that overlap and
        contradict each other.
        """
        if not self.tables:
            raise AttitudeError("the message has no attitudes.")
        names = [table.meta["body_frame"].upper() for table in self.tables]
        if len({comparable(name) for name in names}) > 1:
            raise AttitudeError(
                f"the blocks of attitudes are those of {', '.join(dict.fromkeys(names))[:120]}; "
                "choose one of `tables` (in files of any format: segment=, on the command line "
                "--segment)."
            )
        refuse_contradictions(self.tables)
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
        rated = [item for item in self.tables if item.angular_velocity is not None]
        if self.body is None or not rated:
            lacking = "inertia" if self.body is None else "attitude with an angular velocity"
            raise AttitudeError(f"the message has no {lacking}, from which a motion would follow.")
        first = rated[0]
        _messages.refuse_other_axes(self.meta["inertia_frame"], first.meta["body_frame"])
        assert first.angular_velocity is not None
        spin = Spin(
            first.epoch.after(first.seconds[0], first.low[0]),
            first.wxyz[0],
            first.angular_velocity[0],
        )
        # Those that end at the epoch of the state, to rounding, are over; they are in any order.
        ends = [(m.begin.since(spin.epoch), m.end.since(spin.epoch), m) for m in self.maneuvers]
        later = [item for item in ends if item[0] >= 0.0 and item[1] > _ROUNDING]
        if not later:
            return FreeRotation(self.body, spin)
        later.sort(key=lambda item: item[0] + item[1])
        return Arcs(self.body, spin, [maneuver.impulse() for _, _, maneuver in later])


# ---- Rows of attitudes and covariances of an Attitude Comprehensive Message
# Conventions are those of `_records` for version 2.  A direction cosine matrix is that from
# A to B, column by column, as Orekit reads it; the components of ANGVEL are over the axes of B.


class _TimeTags:
    """The times of rows: dates, or seconds since EPOCH_TZERO; `scale` in lower case."""

    def __init__(self, scale, zero):
        self.scale, self.zero = scale, zero
        hi, lo = np.float64(zero.seconds), np.float64(zero.low)
        # Seconds of UTC, TAI, TT and GPS are the same; those of TDB, TCB, TCG and UT1 are not.
        self._uniform = scale in ("utc", "tai", "tt", "gps")
        self._base = _time_scales.tt_from_tdb(hi, lo) if self._uniform else (hi, lo)

    def after(self, seconds, low=0.0):
        """TDB seconds since J2000, hi and lo, of seconds + low since EPOCH_TZERO."""
        hi, lo = pairs.add(self._base, seconds, low)
        if self._uniform:
            hi, lo = _time_scales.tdb_from("tt", hi, lo)
        return np.asarray(hi), np.asarray(lo)

    def text(self, hi, lo, digits):
        """Seconds since EPOCH_TZERO, as decimal texts, of TDB seconds since J2000."""
        digits = ccsds_epochs.DIGITS if digits is None else digits
        pair = _time_scales.tt_from_tdb(hi, lo) if self._uniform else (hi, lo)
        hi, lo = pairs.add(pair, -self._base[0], -self._base[1])
        return ccsds_epochs.decimals(*ccsds_epochs.rounded(hi, lo, digits), digits)

    def parsed(self, tokens):
        """TDB seconds since J2000 of tags; BadEpoch for those that cannot be read."""
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
                    seconds, low = _decimals(some)
                    finite = np.abs(seconds) < _LARGEST
                    if not np.all(finite):
                        reason = "it is not finite or too large"
                        raise ccsds_epochs.BadEpoch(int(np.argmin(finite)), reason)
                    hi[rows], lo[rows] = self.after(seconds, low)
            except ccsds_epochs.BadEpoch as err:
                raise ccsds_epochs.BadEpoch(int(rows[err.index]), err.reason) from err
            except NoNumber as err:
                reason = "it is neither a date nor a number of seconds"
                raise ccsds_epochs.BadEpoch(int(rows[err.line]), reason) from err
        return hi, lo


def _decimals(tokens):
    """Numbers as pairs of doubles, (N,) and (N,): the digits before and behind the point."""
    whole = numbers(tokens, 1, [0])[:, 0]
    low = np.zeros(len(tokens))
    for k, token in enumerate(tokens):
        if _DECIMAL.fullmatch(token):
            first, _, decimals = token.partition(b".")
            sign = -1.0 if first.startswith(b"-") else 1.0
            whole[k], low[k] = float(first), sign * float(b"0." + decimals)
    return whole, low


# Seconds since EPOCH_TZERO beyond which no time is read.
_LARGEST = 1e15
# Such as 86400.333333333333, of which one double holds 11 decimals.
_DECIMAL = re.compile(rb"[+-]?\d{1,15}\.\d{1,18}")


class _TimedRows(Rows):
    """The rows of a block, at dates or at seconds since EPOCH_TZERO."""

    def __init__(self, block, names):
        super().__init__(_messages.scale_of(block.meta), block.message.fault, names)
        self.holds = f"{block.name} of this type has a time and {len(names)} numbers"
        self._tags = _tags(block.message)

    def _parsed(self, tokens):
        return self._tags.parsed(tokens)


def _reader(block, count):
    """The rows of a block ATT or COV."""
    if block.name == "COV":
        return _TimedRows(block, _COVARIANCES[block.one_of("COV_TYPE", _COVARIANCES)])
    kind, rate = _types(block)
    names, states = (*_ATTITUDES[kind], *_RATES[rate]), block.get("NUMBER_STATES")
    if states is not None and states != str(len(names)):
        raise block.fault(
            f"NUMBER_STATES is {cut(states)}; {kind} with the rates {rate} has {len(names)}.",
            "NUMBER_STATES",
        )
    return _TimedRows(block, names)


def _types(block):
    return block.one_of("ATT_TYPE", _ATTITUDES), block.one_of("RATE_TYPE", _RATES, "NONE")


def _rows(block):
    """Epoch, seconds and low since then, values and lines of the complete rows of a block."""
    if block.rows is None:
        raise block.fault(f"the block {block.name} has no rows.")
    return block.rows.joined()


def _table(block, tolerance, frame, orbit):
    """The AttitudeTable of a block ATT; the last three as in `read`."""
    epoch, seconds, low, values, lines = _rows(block)
    kind, rate = _types(block)
    axes, body, body_is_a = _messages.axes_of(block, frame)
    euler = kind == "EULER_ANGLES" or rate == "EULER_RATE"
    sequence = _messages.sequence_of(block) if euler else None
    angles, rates = np.split(values, [len(_ATTITUDES[kind])], axis=1)
    convention = Convention(
        to_body=not body_is_a,
        sequence=sequence,
        rates_over_body=not body_is_a,
        rates_of_angles=rate == "EULER_RATE",
    )
    meta = _said(block.message) | {
        "keywords": dict(block),
        "data_comments": tuple(block.comments),
        "frame": axes.name,
        "body_frame": body,
        "time_system": block.meta["TIME_SYSTEM"].upper(),
    }
    if rate == "GYRO_BIAS":
        meta["gyro_bias"] = np.radians(rates)
    fault = block.message.fault
    with block.located():
        if kind == "DCM":
            angles = _quaternions(angles, lines, tolerance, fault)
        elif kind == "QUATERNION":
            refuse_length(angles, lines, tolerance, fault)
        else:
            angles = forms.to_xyzw(quaternion.from_euler(sequence, np.radians(angles)))
        columns = np.concatenate((angles, rates), axis=1)
        where = epoch, seconds, low, orbit
        wxyz, speeds = in_icrf(_DECODED.get(rate, "QUATERNION"), columns, convention, axes, where)
        return AttitudeTable(epoch, seconds, wxyz, low=low, angular_velocity=speeds, meta=meta)


def _quaternions(entries, lines, tolerance, fault):
    """Quaternions (N, 4), scalar last, of matrices (N, 9) that few digits distort."""
    matrices = entries.reshape(-1, 3, 3)
    off = np.max(np.abs(np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)), axis=(1, 2))
    bad = ~(off <= 10.0 * tolerance) | ~(np.linalg.det(matrices) > 0.0)
    if np.any(bad):
        k = int(np.argmax(bad))
        raise fault(
            f"the matrix is no rotation: its product with its transpose is off 1 by {off[k]:.3g} "
            f"(up to {10.0 * tolerance:g} is accepted as rounding), or it is a reflection.",
            int(lines[k]),
        )
    left, _, right = np.linalg.svd(matrices)
    return forms.to_xyzw(
        quaternion.from_matrix(np.where(off[:, None, None] < 1e-12, matrices, left @ right))
    )


def _covariance(block):
    """The AttitudeCovariance of a block COV."""
    epoch, seconds, low, variances, lines = _rows(block)
    kind = block.one_of("COV_TYPE", _COVARIANCES)
    if np.any(variances < 0.0):
        row = int(np.argmax(np.any(variances < 0.0, axis=1)))
        raise block.message.fault("a variance is negative.", int(lines[row]))
    # All but the components of quaternions.
    variances[:, 0 if kind.startswith("ANGLE") else len(Q) :] *= np.radians(1.0) ** 2
    meta = {"keywords": dict(block), "data_comments": tuple(block.comments)}
    frame = block.get("COV_REF_FRAME")
    return AttitudeCovariance(epoch, seconds, low, kind, variances, frame, meta)


# ---- The meaning of a message


def _interpreted(message, tolerance, frame, orbit, products):
    """The Comprehensive of a Message; the other parameters as in `read`."""
    products = _messages.known_products(products, message.version)
    tags = _tags(message)
    _refuse_times(message.meta, tags)
    physics = next(iter(message.all("PHYS")), None)
    for block in message.all("AD"):
        _refuse_sensors(block)
    meta = _said(message) | {
        "meta_comments": tuple(message.meta.comments),
        "inertia_frame": None if physics is None else physics.get("INERTIA_REF_FRAME"),
        "blocks": tuple(
            (b.name, dict(b), tuple(b.comments), tuple(dict(s) for s in b.inner))
            for b in message.blocks
        ),
    }
    body = None if physics is None else _body(physics, products)
    return Comprehensive(
        tags.zero,
        tuple(_table(b, tolerance, frame, orbit) for b in message.all("ATT")),
        tuple(_covariance(b) for b in message.all("COV")),
        body,
        tuple(_maneuver(b, tags) for b in message.all("MAN")),
        meta,
    )


def _said(message):
    """What the meta data of the message and of each table begin with."""
    return _messages.said_by(message, message.meta, "ACM 2.0", "INTERNATIONAL_DESIGNATOR")


def _tags(message):
    meta = message.meta
    scale = _messages.scale_of(meta)
    return _TimeTags(scale, _messages.epoch_of(meta, "EPOCH_TZERO", scale))


def _refuse_times(meta, tags):
    """AttitudeError for times of the meta data that are no epochs, or in the wrong order.

    Records outside of START_TIME and STOP_TIME are read: the examples of Orekit have them.
    """
    ends = {}
    for keyword in ("START_TIME", "STOP_TIME", "NEXT_LEAP_EPOCH"):
        if keyword in meta:
            with _messages.epochs_named(meta, keyword):
                hi, lo = tags.parsed([meta[keyword].encode("ascii", "replace")])
            ends[keyword] = Instant(hi[0], lo[0])
    _messages.refuse_reversed(meta, ends.get("START_TIME"), ends.get("STOP_TIME"))


def _body(block, products):
    """The Body of a block PHYS, or None; AttitudeError for values that are no numbers."""
    if "CP_REF_FRAME" in block and "CP" not in block:
        raise block.fault("CP_REF_FRAME is given without CP.", "CP_REF_FRAME")
    for keyword, count in (("CP", 3), ("WET_MASS", 1), ("DRY_MASS", 1), ("DRAG_COEFF", 1)):
        if keyword in block:
            block.numbers(keyword, count)
    present = [name for name in INERTIA if name in block]
    lacking = [name for name in INERTIA if name not in block]
    if not present:
        return None
    if lacking:
        raise block.fault(
            f"the block PHYS has {', '.join(present)}, but lacks {', '.join(lacking)}."
        )
    return _messages.body_of(block, products)


def _refuse_sensors(block):
    """AttitudeError unless sensors have numbers of their own and the deviations that they state.

    Numbers may have gaps (CCSDS 504.0-B-2, note to 5.3.9.6).
    """
    lines: dict[int, int] = {}
    for sensor in block.inner:
        number = _counted(sensor, "SENSOR_NUMBER", "give a whole number from 1")
        if number in lines:
            raise sensor.fault(
                f"SENSOR_NUMBER {number} was used before, in line {lines[number]}.", "SENSOR_NUMBER"
            )
        lines[number] = sensor.lines["SENSOR_NUMBER"]
        count, values = "NUMBER_SENSOR_NOISE_COVARIANCE", "SENSOR_NOISE_STDDEV"
        if (count in sensor) != (values in sensor):
            raise sensor.fault(f"{count} and {values} belong together.")
        if count in sensor:
            sensor.numbers(values, _counted(sensor, count, "give a whole number"))


def _counted(block, keyword, advice):
    """The whole number, from 1, of a keyword."""
    text = block.get(keyword, "")
    number = int(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0
    if not number:
        raise block.fault(f"{keyword} is {cut(text)}; {advice}.", keyword)
    return number


def _maneuver(block, tags):
    """The Maneuver of a block MAN."""
    for keyword in ("MAN_PURPOSE", "MAN_BEGIN_TIME"):
        block.needed(keyword)
    if "MAN_END_TIME" in block and "MAN_DURATION" in block:
        raise block.fault(
            "MAN_END_TIME and MAN_DURATION are given; give one of both.", "MAN_DURATION"
        )
    if "TARGET_MOM_FRAME" in block and "TARGET_MOMENTUM" not in block:
        raise block.fault("TARGET_MOM_FRAME is given without TARGET_MOMENTUM.", "TARGET_MOM_FRAME")

    def values(keyword, count=1):
        return np.array(block.numbers(keyword, count)) if keyword in block else None

    first = last = block.number("MAN_BEGIN_TIME")
    if "MAN_END_TIME" in block:
        last = block.number("MAN_END_TIME")
    elif "MAN_DURATION" in block:
        last = first + block.number("MAN_DURATION")
    if last < first or max(abs(first), abs(last)) > _LARGEST:
        raise block.fault("the maneuver ends before it begins.")
    attitude, rate = values("TARGET_ATTITUDE", 4), values("TARGET_SPINRATE")
    if attitude is not None:
        if not abs(float(np.linalg.norm(attitude)) - 1.0) < 1e-3:
            raise block.fault("TARGET_ATTITUDE is no quaternion of unit length.", "TARGET_ATTITUDE")
        attitude = quaternion.unit(np.roll(attitude, 1))
    hi, lo = tags.after(np.array([first, last]))
    begin, end = map(Instant, hi, lo)
    return Maneuver(
        begin=begin,
        end=end,
        purpose=block["MAN_PURPOSE"],
        target_momentum=values("TARGET_MOMENTUM", 3),
        momentum_frame=block.get("TARGET_MOM_FRAME"),
        target_attitude=attitude,
        target_spin_rate=None if rate is None else math.radians(rate[0]),
        values=dict(block),
        comments=tuple(block.comments),
    )


# ---- Blocks to be written: name, keywords, comments, and epochs and columns of rows piece by piece


class _WrittenBlock(NamedTuple):
    name: str
    entries: list[tuple[str, str | float]]
    rows: Callable[[], Iterator[tuple[list[str], Any]]] = lambda: iter(())
    comments: tuple[str, ...] = ()


def _write_block(out, block):
    """Write a block, its rows piece by piece."""
    with out.part(block.name.lower(), block.name):
        out.comments(block.comments)
        out.entries(block.entries)
        for epochs, columns in block.rows():
            row = out.row(_FORM.rows[block.name], columns.shape[1])
            out.table(epochs, columns, row)


def _attitudes(records, frame, axes, body, texts, orbit):
    """The block ATT of a segment: quaternions, with angular velocities if it has them."""
    states, rated, kind = "4", [], "QUATERNION"
    if records.has_rates:
        states, rated, kind = "7", [("RATE_TYPE", "ANGVEL")], "QUATERNION/ANGVEL"
    entries = [("REF_FRAME_A", frame), ("REF_FRAME_B", body)]
    entries += [("NUMBER_STATES", states), ("ATT_TYPE", "QUATERNION"), *rated]

    def rows():
        for piece, columns in columns_of(records.pieces(), kind, Convention(), axes, orbit):
            yield ccsds_epochs.distinct(texts(piece)), columns

    return _WrittenBlock("ATT", entries, rows, tuple(records.meta.get("data_comments", ())))


def _covariances(records, body, texts):
    """The block COV of a segment: variances about the body axes, and of angular velocities."""
    entries = [("COV_BASIS", "PREDICTED"), ("COV_REF_FRAME", body), ("COV_TYPE", "ANGLE_ANGVEL")]

    def rows():
        for history in records.pieces():
            covariance = np.asarray(history.covariance)
            turn = np.swapaxes(history.matrix, -1, -2)
            angles = turn @ covariance[:, :3, :3] @ np.swapaxes(turn, -1, -2)
            both = [np.diagonal(m, axis1=1, axis2=2) for m in (angles, covariance[:, 3:, 3:])]
            yield texts(history), np.concatenate(both, axis=1) * np.degrees(1.0) ** 2

    return _WrittenBlock("COV", entries, rows)


def _physics(motion, epochs, frame, products):
    """The block PHYS in kg m2 of the body of a motion at the first of some epochs."""
    body, *later = (motion.body_at(motion.epoch.after(*map(float, epoch))) for epoch in epochs)
    if not all(np.array_equal(body.tensor, other.tensor) for other in later):
        warnings.warn(
            "an ACM holds one body: the inertia at its first epoch is written, and that it changes "
            "later is left out. Write a file for each stretch between changes of the inertia.",
            AttitudeWarning,
            stacklevel=3,
        )
    values = _messages.inertia_values(body.tensor, products, "2.0")
    mass = [] if body.mass is None else [("WET_MASS", float(body.mass))]
    inertia = [("INERTIA_REF_FRAME", frame), *zip(INERTIA, values, strict=True)]
    return _WrittenBlock("PHYS", [*mass, *inertia])


def _maneuvers(motion, breaks, seconds, frame, axes):
    """A block MAN for each impulse at some joints of a motion, with the momentum after it."""
    inner = None if axes.turning else quaternion.conjugate(axes.to_icrf(motion.epoch, 0.0, None))
    for hi, lo in breaks:
        after = motion.at(np.array([hi]), np.array([lo]))
        before = motion.at(np.array([hi]), np.array([np.nextafter(lo, -np.inf)]))
        old, new = (
            quaternion.rotate(h.wxyz, h.motion.momentum_in_body(h))[0] for h in (before, after)
        )
        if np.linalg.norm(new - old) <= 1e-12 * np.linalg.norm(new):
            continue  # a change of the inertia alone
        new = new if inner is None else quaternion.rotate(inner, new)
        entries = [("MAN_PURPOSE", "ATT_ADJUST"), ("MAN_BEGIN_TIME", seconds(hi, lo))]
        entries += [("MAN_DURATION", "0.0")]
        entries += [("TARGET_MOMENTUM", " ".join(repr(float(x)) for x in new))]
        entries += [("TARGET_MOM_FRAME", "ICRF" if axes.turning else frame)]
        yield _WrittenBlock("MAN", entries)


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
    return _interpreted(messages.read(path, _FORM, _reader), tolerance, frame, orbit, products)


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
    digits: int | None = None,
    orbit: Path | None = None,
) -> None:
    """Write attitudes as an ACM, with the body, the impulses and the errors of their motion.

    Each segment becomes a block ATT (quaternions and angular velocities, at seconds since the first
    epoch); the inertia in kg m2 a block PHYS; each impulse of `Arcs` a block MAN without duration,
    with the angular momentum after it; standard deviations a block COV for each segment.  PHYS has
    the inertia of the first epoch; where it changes later, an AttitudeWarning says so.

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
    refuse_foreign(path, "acm")
    parts = _sampling.segments(source, t)
    _sampling.warn_of_usable(parts, "an ACM")
    motion, meta = parts[0].motion, parts[0].meta
    axes = _axes.named(frame or meta.get("frame") or "ICRF")
    name = _axes.WRITTEN[axes.kind] if axes.name.islower() else axes.name
    body = _messages.written_body(body_frame, meta)
    scale = ccsds_epochs.writable(time_system or meta.get("time_system") or "UTC")

    begin, end = parts[0].first_and_last(), parts[-1].first_and_last()
    start, _ = ccsds_epochs.texts(parts[0].epoch, *begin, scale, digits)
    _, stop = ccsds_epochs.texts(parts[-1].epoch, *end, scale, digits)
    tags = _TimeTags(scale, ccsds_epochs.instant(start, scale))

    def texts(history: AttitudeHistory) -> list[str]:
        epoch = history.epoch
        return tags.text(*pairs.Seconds.of(history).plus(epoch.seconds, epoch.low), digits)

    def seconds(hi: float, lo: float) -> str:
        instant = motion.epoch.after(hi, lo)
        return tags.text(np.array([instant.seconds]), np.array([instant.low]), digits)[0]

    blocks = [_attitudes(records, name, axes, body, texts, orbit) for records in parts]
    has_inertia = motion.body is not None and not motion.body.relative
    if has_inertia:
        breaks = [joint for joint in motion.breaks() if begin[0][0] <= joint[0] <= end[0][1]]
        epochs = [np.array(begin)[:, 0], *breaks, np.array(end)[:, 1]]
        blocks.append(_physics(motion, epochs, body, products))
    if covariance is None:
        covariance = _has_covariance(parts[0])
    if covariance:
        blocks += [_covariances(records, body, texts) for records in parts]
    if has_inertia:
        blocks += _maneuvers(motion, breaks, seconds, name, axes)
    for block in blocks:
        refuse_line_breaks(*block.comments)

    def write_data(out: Generator) -> None:
        for block in blocks:
            _write_block(out, block)

    names = _messages.written_names(
        meta, object_name, object_id, center, "INTERNATIONAL_DESIGNATOR"
    )
    times = {
        "TIME_SYSTEM": scale.upper(),
        "EPOCH_TZERO": start,
        "ACM_DATA_ELEMENTS": ", ".join(block.name for block in blocks),
        "START_TIME": start,
        "STOP_TIME": stop,
    }
    messages.write(
        path,
        _FORM,
        "2.0",
        _messages.written_header(meta, creation_date, originator, comments),
        [(names | times, (), write_data)],
        xml=xml,
    )


def _has_covariance(records):
    """Whether the motion of a segment knows its errors."""
    try:
        records.motion.covariance_at(records.seconds[:1])
    except AttitudeError:
        return False
    return True


def _opened(path, *, segment, **keywords):
    """The attitudes of an ACM, and what it holds beside them."""
    message = read(path, **keywords)
    beside = {
        "inertia": message.body is not None,
        "covariances": message.covariances,
        "maneuvers": message.maneuvers,
    }
    left_out = {"left_out": tuple(name for name, present in beside.items() if present)}
    if segment is not None:
        if not 0 <= segment < len(message.tables):
            raise AttitudeError(
                f"{os.fspath(path)}: segment is {segment!r}; the message has {len(message.tables)} "
                "blocks of attitudes, counted from 0."
            )
        return of_table(message.tables[segment], left_out)
    with prefixed(path):
        return of_table(message.table, left_out)


register_message(
    "acm",
    "CCSDS ACM",
    write,
    module=__name__,
    read=_opened,
    reading=("tolerance", "frame", "orbit", "segment"),
    read_message=read,
    writing=("frame", "time_system", "orbit"),
    noun="an ACM",
    is_sampled=False,
)
