"""Rows of a file to an AttitudeTable, and a history to rows: axes, directions, units, length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs
from attitude._textfiles.lines import NoNumber, numbers
from attitude._textfiles.messages import MessageRows
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.formats import _attitude_types
from attitude.formats import _ccsds_epochs as ccsds_epochs
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._table import AttitudeTable, refuse_speed

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from attitude._support.annotations import FloatArray, IntArray
    from attitude._textfiles.lines import Fault
    from attitude.formats._attitude_types import Convention
    from attitude.motions._axes import Axes
    from attitude.motions._history import AttitudeHistory
    from attitude.paths._path import Path


# Largest deviation from 1 of the length of a quaternion: some files print few digits.
TOLERANCE: float = 1e-3
# Seconds since J2000 beyond which no epoch is read: 30 million years.
_LARGEST = 1e15
# Rounding of START_TIME and STOP_TIME, s: files write them with fewer digits than epochs.
_ROUNDED = 1e-3


def known_tolerance(tolerance: float) -> float:
    """The tolerance of the length of quaternions itself; AttitudeError if it is not 0 or more."""
    number = isinstance(tolerance, (int, float)) and not isinstance(tolerance, bool)
    if not (number and tolerance >= 0.0):
        raise AttitudeError(
            f"tolerance is {tolerance!r}; give the largest deviation from 1 of the length of a "
            "quaternion, 0 or more."
        )
    return tolerance


class Rows(MessageRows):
    """The records of one segment while they are read, with epochs in a scale in lower case."""

    def __init__(self, scale: str, fault: Fault, names: Sequence[str], lead: int = 1):
        super().__init__(fault, names, lead)
        self.scale: str = scale
        self.count: int = 0
        # Epochs hi and lo, values and lines of some rows each.
        self._parts: list[tuple[FloatArray, FloatArray, FloatArray, IntArray]] = []

    def add(
        self, leads: Sequence[Sequence[bytes]], values: FloatArray, lines: Sequence[int]
    ) -> None:
        """Add N records, whose epochs stand before the numbers; values are (N, names)."""
        try:
            hi, lo = self._parsed(*leads)
        except ccsds_epochs.BadEpoch as err:
            shown = b" ".join(tokens[err.index] for tokens in leads)[:38].decode("ascii", "replace")
            raise self.fault(
                f"the epoch {shown!r} cannot be read: {err.reason}.", lines[err.index]
            ) from err
        self.add_times(hi, lo, values, lines)

    def _parsed(self, tokens, of_day=None):
        """TDB seconds since J2000, hi and lo, of epochs; or of days and their seconds."""
        if of_day is None:
            return ccsds_epochs.parsed(tokens, self.scale)
        return ccsds_epochs.parsed_days(tokens, of_day, self.scale)

    def seconds_of(self, tokens: Sequence[bytes], lines: Sequence[int]) -> FloatArray:
        """Times that are numbers, (N,); AttitudeError for others."""
        try:
            return numbers(tokens, 1, [0])[:, 0]
        except NoNumber as err:
            raise self.fault(f"{err.shown} is no number.", lines[err.line]) from err

    def add_times(
        self, hi: FloatArray, lo: FloatArray, values: FloatArray, lines: Sequence[int]
    ) -> None:
        """Add N records whose epochs are TDB seconds since J2000, hi + lo."""
        finite = np.isfinite(values).all(axis=1) & (np.abs(hi) < _LARGEST)
        if not np.all(finite):
            k = int(np.argmin(finite))
            raise self.fault("it holds a number that is not finite or too large.", lines[k])
        last = self._parts[-1] if self._parts else (hi[:0], lo[:0])
        last_hi, last_lo = last[0][-1:], last[1][-1:]
        steps = np.diff(np.append(last_hi, hi)) + np.diff(np.append(last_lo, lo))
        if np.any(steps <= 0.0):
            k = int(np.argmax(steps <= 0.0))
            what = "is that of the record before" if steps[k] == 0.0 else "goes backwards"
            raise self.fault(
                f"the epoch {what}; records must follow each other in time.",
                lines[k + (not self._parts)],
            )
        if len(hi):
            self._parts.append((hi, lo, values, np.asarray(lines)))
            self.count += len(hi)

    def refuse_outside(self, start: Instant | None, stop: Instant | None) -> None:
        """AttitudeError for a record before START_TIME or after STOP_TIME by more than 1 ms."""
        for hi, lo, _, lines in self._parts:
            for end, sign, what in ((start, 1.0, "before START"), (stop, -1.0, "after STOP")):
                if end is None:
                    continue
                inside = sign * ((hi - end.seconds) + (lo - end.low))
                if np.any(inside < -_ROUNDED):
                    k = int(np.argmax(inside < -_ROUNDED))
                    raise self.fault(
                        f"the record is {-inside[k]:.6g} s {what}_TIME of the meta data.",
                        int(lines[k]),
                    )

    def joined(self) -> tuple[Instant, FloatArray, FloatArray, FloatArray, IntArray]:
        """First epoch, TDB seconds since it, hi and lo (N,), columns (N, width), lines (N,)."""
        if not self._parts:
            raise self.fault("the file has no attitudes.", None)
        hi, lo, values, lines = map(np.concatenate, zip(*self._parts, strict=True))
        epoch = Instant(hi[0], lo[0])
        return epoch, *pairs.add((hi, lo), -epoch.seconds, -epoch.low), values, lines

    def table(
        self,
        kind: str,
        convention: Convention,
        axes: Axes,
        *,
        tolerance: float = TOLERANCE,
        orbit: Path | None = None,
        **settings: Any,
    ) -> AttitudeTable:
        """The AttitudeTable of the records, relative to ICRF."""
        epoch, seconds, low, values, lines = self.joined()
        if kind.startswith("QUATERNION"):
            refuse_length(values[:, :4], lines, tolerance, self.fault)
        wxyz, rates = in_icrf(kind, values, convention, axes, (epoch, seconds, low, orbit))
        return AttitudeTable(epoch, seconds, wxyz, low=low, angular_velocity=rates, **settings)


def in_icrf(
    kind: str,
    rows: FloatArray,
    convention: Convention,
    axes: Axes,
    where: tuple[Instant, FloatArray, FloatArray, Path | None],
) -> tuple[FloatArray, FloatArray | None]:
    """wxyz (N, 4) and rates (N, 3) relative to ICRF from rows (N, columns) in some axes.

    where: what axes turn with: epoch, seconds since it, hi and lo (N,), path of the body.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # refuse_speed refuses overflow
        wxyz, rates = _attitude_types.decoded(kind, rows, convention)
    wxyz = quaternion.unit(wxyz)
    if axes.kind in ("icrf", "gcrf"):
        return wxyz, rates
    refuse_speed(rates)
    wxyz = quaternion.multiply(axes.to_icrf(*where), wxyz)
    if rates is not None:
        turning = axes.angular_velocity(*where)
        if turning is not None:
            rates = rates + quaternion.rotate(quaternion.conjugate(wxyz), turning)
    return forms.continuous(wxyz) if axes.turning else wxyz, rates


def columns_of(
    histories: Iterable[AttitudeHistory],
    kind: str,
    convention: Convention,
    axes: Axes,
    orbit: Path | None = None,
) -> Iterator[tuple[AttitudeHistory, FloatArray]]:
    """Pieces (N,) of one history, each with the columns (N, columns) of an attitude type.

    Units are deg, deg/s and s.  Quaternions in axes that turn are continuous in sign, also from
    piece to piece.
    """
    before = np.empty((0, 4))
    for history in histories:
        wxyz, rates, acceleration = _in_axes(history, kind, axes, orbit)
        if axes.turning:
            wxyz = forms.continuous(np.concatenate([before, wxyz]))[len(before) :]
            before = wxyz[-1:]
        yield history, _attitude_types.encoded(kind, wxyz, rates, acceleration, convention)


def _in_axes(history, kind, axes, orbit):
    """wxyz, rates and acceleration of a history in some axes; the last two if the type has them."""
    wxyz, rates, acceleration = np.asarray(history.wxyz), None, None
    if _attitude_types.has_rates(kind):
        rates = np.asarray(history.turning_rate)
    if kind in ("SPIN/NUTATION", "SPIN/NUTATION_MOM"):
        if axes.turning:
            raise AttitudeError(f"{kind} can be written in axes that do not turn, not {axes.name}.")
        acceleration = np.asarray(history.angular_acceleration)
    if axes.kind not in ("icrf", "gcrf"):
        where = history.epoch, history.seconds, history.low, orbit
        outer = axes.to_icrf(*where)
        if rates is not None:
            turning = axes.angular_velocity(*where)
            if turning is not None:
                rates = rates - quaternion.rotate(quaternion.conjugate(wxyz), turning)
        wxyz = quaternion.multiply(quaternion.conjugate(outer), wxyz)
    return wxyz, rates, acceleration


def refuse_length(
    quaternions: FloatArray, lines: Sequence[int] | IntArray, tolerance: float, fault: Fault
) -> None:
    """AttitudeError for quaternions (N, 4) whose length is off 1 by more than the tolerance."""
    with np.errstate(over="ignore"):
        off = np.abs(np.sqrt(np.sum(quaternions * quaternions, axis=1)) - 1.0)
    if np.any(off > tolerance):
        k = int(np.argmax(off > tolerance))
        raise fault(
            f"the length of the quaternion is off 1 by {off[k]:.3g}; up to {tolerance:g} is "
            "accepted as rounding (tolerance=).",
            int(lines[k]),
        )
