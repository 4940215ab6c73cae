"""Rows of attitudes and covariances of an Attitude Comprehensive Message.

Conventions are those of `attitude_types` for version 2.  A direction cosine matrix is that from A
to B, column by column, as Orekit reads it; the components of ANGVEL are over the axes of B.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table.table import AttitudeTable
from attitude.axes import axes
from attitude.epochs import time_scales
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError
from attitude.formats.acm.keywords import ATTITUDES, COVARIANCES, RATES
from attitude.formats.acm.message import AttitudeCovariance
from attitude.formats.ccsds import attitude_types
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.ccsds.attitude_types import Convention
from attitude.formats.rows import refuse_length, to_icrf
from attitude.textfiles.lines import NoNumber, cut, numbers

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.formats.acm.blocks import AcmBlock, CollectedAcm
    from attitude.paths.path import Path


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
        self._base = time_scales.tt_from_tdb(hi, lo) if self._uniform else (hi, lo)

    def after(
        self, seconds: FloatArray, low: FloatArray | float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """TDB seconds since J2000, hi and lo, of seconds + low since EPOCH_TZERO."""
        hi, lo = pairs.add(self._base, seconds, low)
        if self._uniform:
            hi, lo = time_scales.tdb_from("tt", hi, lo)
        return np.asarray(hi), np.asarray(lo)

    def text(self, hi: FloatArray, lo: FloatArray, digits: int) -> list[str]:
        """Seconds since EPOCH_TZERO, as decimal texts, of TDB seconds since J2000."""
        pair = time_scales.tt_from_tdb(hi, lo) if self._uniform else (hi, lo)
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
        found, body, body_is_a = axes.of_pair(
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
        wxyz, rates = to_icrf(forms.unit(wxyz), rates, found, epoch, seconds, low, orbit)
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
        numbers_of = forms.to_xyzw(forms.from_euler(how.sequence, np.radians(given)))
    columns, name = [numbers_of], "QUATERNION"
    if rate == "Q_DOT":
        columns, name = [numbers_of, rest], "QUATERNION/DERIVATIVE"
    elif rate in ("ANGVEL", "EULER_RATE"):
        columns, name = [numbers_of, rest], "QUATERNION/ANGVEL"
    if rate == "EULER_RATE":
        how = Convention(to_body=how.to_body, sequence=how.sequence, rates_of_angles=True)
    return attitude_types.decoded(name, np.concatenate(columns, axis=1), how)


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
        forms.from_matrix(np.where(off[:, None, None] < 1e-12, matrices, left @ right))
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
    """The variances of a block COV.

    Raises
    ------
    AttitudeError
        As `table`, and for negative variances.
    """
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
