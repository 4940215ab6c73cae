"""`AttitudeTable`: attitudes that were measured or read from a file, as a motion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude import frames
from attitude._support import pairs, validation
from attitude._support.arrays import frozen
from attitude._support.quantity_text import quoted
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._history import AttitudeHistory
from attitude.motions._motion import Motion
from attitude.paths._tabulated import newton_form, newton_values, refuse_uneven, settled_degree

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import BoolArray, Epoch, Epochs, FloatArray, IntArray, Reals
    from attitude.epochs._instants import Instant

    Limits: TypeAlias = tuple[tuple[float, float], tuple[float, float]]


# ---- Attitudes and rates between the records of a table: Lagrange, Hermite or great circles
# Each component of the quaternions is interpolated by the polynomial through a window of
# neighbouring records (Hermite: through their derivatives too), in Newton's form, and the result is
# normalised, as in SPICE's CK types 5 and 6.

METHODS: tuple[str, ...] = ("slerp", "lagrange", "hermite")
# The default: four records with rates, or eight without.
USUAL_DEGREE: int = 7
_CHUNK = 8192


def settled(method: str | None, degree: int | None, count: int, has_rates: bool) -> tuple[str, int]:
    """The method and degree of a table of `count` records, from those requested.

    None is the default.  Hermite without rates becomes Lagrange; for the degree see
    `settled_degree`; a single record is a fixed attitude ("slerp").
    """
    if method is None:
        method = "hermite" if has_rates else "lagrange"
    word = method.lower() if isinstance(method, str) else ""
    word = "slerp" if word in ("linear", "sphericallinear", "spherical linear") else word
    if word not in METHODS:
        raise AttitudeError(
            f"the interpolation method is {quoted(method, 40)}; it must be one of "
            f"{', '.join(METHODS)}."
        )
    method = word
    degree = USUAL_DEGREE if degree is None else degree
    if method == "hermite" and not has_rates:
        method = "lagrange"
    degree = settled_degree(degree, max(count, 2), method == "hermite")
    return ("slerp", 1) if method == "slerp" or count == 1 else (method, degree)


def evaluate(
    table: AttitudeTable, row: IntArray, ahead: FloatArray, *, order: int
) -> list[FloatArray]:
    """Attitudes of unit length and their derivatives; row (T,), ahead (T,)."""
    parts = [
        _evaluate(table, row[k : k + _CHUNK], ahead[k : k + _CHUNK], order)
        for k in range(0, max(len(row), 1), _CHUNK)
    ]
    return [np.concatenate(arrays) for arrays in zip(*parts, strict=True)]


def _evaluate(table, row, ahead, order):
    interpolated = _along_circles if table.method == "slerp" else _by_polynomial
    out = interpolated(table, row, ahead, order)
    if order and table.angular_velocity is not None and table.method != "hermite":
        out[1:] = _interpolated_rates(table, row, ahead)[:order]
    return out


def _by_polynomial(table, row, ahead, order):
    repeat = 2 if table.method == "hermite" else 1
    width = (table.degree + 1) // repeat
    first, x, scale, at = _window(table, row, ahead, width)
    rows = first + np.arange(width)[:, None]
    values, slopes = table.nodes[rows], None
    if repeat == 2:
        slopes = scale[:, None] * forms.quaternion_rate(values, table.angular_velocity[rows])
    p, *derivatives = newton_values(*newton_form(at, values, slopes), x, order)
    square = np.sum(p * p, axis=1, keepdims=True)
    out = [p / np.sqrt(square)]
    if order:
        turn, dp = quaternion.conjugate(p), derivatives[0]
        omega = 2.0 * quaternion.multiply(turn, dp)[:, 1:] / square
        out.append(omega / scale[:, None])
    if order > 1:
        # d/dt of 2 vec(q* q') / |q|^2, in which vec(q'* q') vanishes
        change = 2.0 * np.sum(p * dp, axis=1, keepdims=True)
        bend = 2.0 * quaternion.multiply(turn, derivatives[1])[:, 1:] - omega * change
        bend /= square
        out.append(bend / scale[:, None] ** 2)
    return out


def _window(table, row, ahead, width):
    """First record of each window; the epoch in it from the record before, in units of its length;
    its length in s; the epochs of its records.
    """
    first = np.clip(row - (width - 1) // 2, 0, len(table.seconds) - width)
    offsets = _apart(table, row, first + np.arange(width)[:, None])
    scale = offsets[-1] - offsets[0] if width > 1 else np.ones(len(row))
    return first, ahead / scale, scale, offsets / scale


def _apart(table, row, later):
    """Seconds from records to later ones."""
    return (table.seconds[later] - table.seconds[row]) + (table.low[later] - table.low[row])


def _along_circles(table, row, ahead, order):
    """The great circles from record to record, at a constant rate."""
    if len(table.seconds) == 1:
        return [table.nodes[row], np.zeros((len(row), 3)), np.zeros((len(row), 3))][: order + 1]
    start = np.minimum(row, len(table.seconds) - 2)
    step, since = _apart(table, start, start + 1), ahead + _apart(table, start, row)
    p, q = table.nodes[start], table.nodes[start + 1]
    turn = forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(p), q))
    turned = forms.from_rotation_vector(turn * (since / step)[:, None])
    out = [quaternion.multiply(p, turned), turn / step[:, None], np.zeros((len(row), 3))]
    return out[: order + 1]


def _interpolated_rates(table, row, ahead):
    """The rates of the records interpolated by the same method, componentwise; their derivative."""
    if len(table.seconds) == 1:
        return [table.angular_velocity[row], np.zeros((len(row), 3))]
    width = 2 if table.method == "slerp" else table.degree + 1
    first, x, scale, at = _window(table, row, ahead, width)
    values = table.angular_velocity[first + np.arange(width)[:, None]]
    p, dp = newton_values(*newton_form(at, values), x, 1)
    return [p, dp / scale[:, None]]


# Seconds beyond the limits of a table that count as within: the rounding of epochs given as dates.
_SLACK = 1e-9
# s from the epoch, at most: 3e10 years.
_FARTHEST = 1e18
# Greatest angular velocity, rad/s.
_FASTEST = 1e30
# Seconds from the epoch of a table up to which an error message writes a date.
_WRITTEN = 1e11


class AttitudeTable(Motion):
    """Attitudes given at epochs, and interpolated between them.

    Parameters
    ----------
    epoch : str, astropy Time, Instant, ...
        Epoch from which plain numbers t count.
    t : (N,) array_like
        Increasing: TDB seconds since the epoch, or epochs of any kind (see `FreeRotation.at`).
    wxyz : (N, 4) array_like
        Body to `frame`, scalar first, of unit length to 1e-3 (they are normalised); of any sign.
    angular_velocity : (N, 3) array_like, optional
        rad/s, body axes, relative to inertial space.
    low : (N,) array_like, optional
        With plain numbers t: t + low are the seconds.
    frame : str
        "icrf", "eme2000" or "ecliptic".
    method : str, optional
        "hermite" (with angular velocities; the default with them), "lagrange" (the default
        without) or "slerp".
    degree : int, optional
        Of the interpolating polynomial, by default 7; reduced if there are too few records.
    usable : pair of epochs, optional
        First and last epoch of interpolated attitudes; by default, and at most, those of the
        records.  A single record has no others.
    meta : dict, optional
        Names and comments of the file.

    Attributes
    ----------
    epoch : Instant
    seconds, low : (N,) arrays
        TDB seconds of the records since `epoch`: seconds + low.
    wxyz : (N, 4) array
        The records: body to ICRF, scalar first.
    angular_velocity : (N, 3) array or None
        rad/s over the body axes; None if none were given.
    method, degree : str, int
        Of the interpolation.
    segments : tuple of AttitudeTable
        The parts of a file with several; (self,) for one.
    span : (Instant, Instant)
    history : AttitudeHistory
        The records.

    Raises
    ------
    AttitudeError
        For epochs that do not increase, are beyond 1e18 s or have distances with ratios above
        1e15; for other shapes, and quaternions whose length is not 1.

    >>> table = AttitudeTable("2026-01-01", [0, 10], [[1, 0, 0, 0], [0, 0, 0, 1]], method="slerp")
    >>> table.at(5.0).wxyz.round(12)
    array([0.70710678, 0.        , 0.        , 0.70710678])
    """

    epoch: Instant
    seconds: FloatArray
    low: FloatArray
    wxyz: FloatArray
    angular_velocity: FloatArray | None
    method: str
    degree: int
    meta: dict[str, Any]
    _limits: Limits
    _parts: tuple[AttitudeTable, ...] | None

    _value = ("epoch", "seconds", "low", "wxyz", "angular_velocity", "method", "degree", "_limits")

    def __init__(
        self,
        epoch: Epoch,
        t: Epochs,
        wxyz: Reals,
        *,
        angular_velocity: Reals | None = None,
        low: ArrayLike | None = None,
        frame: str = "icrf",
        method: str | None = None,
        degree: int | None = None,
        usable: Sequence[Epoch | None] | None = None,
        meta: Mapping[str, Any] | None = None,
    ) -> None:
        start = _inputs.instant(epoch)
        times = _inputs.seconds_since(start, t, low)
        hi = times.hi
        if hi.ndim != 1 or not len(hi):
            raise AttitudeError(f"t has shape {hi.shape}; a table takes one row of epochs, (N,).")
        hi, lo = pairs.two_sum(hi, times.low)
        _refuse_disorder(hi, lo)
        attitudes = validation.real(wxyz, "wxyz", shape=(len(hi), 4))
        attitudes = quaternion.unit(attitudes, tolerance=1e-3)
        if frames.known(frame) not in ("icrf", "gcrf"):
            attitudes = quaternion.multiply(frames.wxyz_to_icrf(frame), attitudes)
        rates = None
        if angular_velocity is not None:
            rates = validation.real(
                angular_velocity, "angular_velocity", shape=(len(hi), 3), unit="rad/s"
            )
            refuse_speed(rates)
            rates = frozen(rates)
        method, degree = settled(method, degree, len(hi), rates is not None)
        self._set_all(
            epoch=start,
            seconds=frozen(hi),
            low=frozen(np.asarray(lo)),
            wxyz=frozen(attitudes),
            angular_velocity=rates,
            method=method,
            degree=degree,
            meta=_known_meta(meta),
            _parts=None,
        )
        self._set("_limits", self._usable(usable))

    @classmethod
    def from_history(
        cls,
        history: AttitudeHistory,
        *,
        rates: bool = True,
        method: str | None = None,
        degree: int | None = None,
        meta: Mapping[str, Any] | None = None,
    ) -> AttitudeTable:
        """A table of the attitudes (and, with rates, `turning_rate`) of a history (N,)."""
        wanted = "an AttitudeHistory, as motion.at(t) returns"
        validation.instance(history, AttitudeHistory, "history", wanted)
        seconds, low = pairs.Seconds.of(history).mapped(np.array)
        return cls(
            history.epoch,
            seconds,
            history.wxyz,
            low=low,
            angular_velocity=history.turning_rate if rates else None,
            method=method,
            degree=degree,
            meta=meta,
        )

    @classmethod
    def joined(
        cls, tables: Iterable[AttitudeTable], *, meta: Mapping[str, Any] | None = None
    ) -> AttitudeTable:
        """Several tables as the segments of one; where they overlap, the first one is used.

        Attitudes in the gap between two segments are not interpolated.

        Raises
        ------
        AttitudeError
            For no table, and other objects.
        """
        listed = tuple(tables) if isinstance(tables, Iterable) else (tables,)
        for k, table in enumerate(listed):
            validation.instance(table, AttitudeTable, f"tables[{k}]", "AttitudeTable objects")
        segments = [segment for table in listed for segment in table.segments]
        if not segments:
            raise AttitudeError("there are no segments to join; give one table or more.")
        if len(segments) == 1 and meta is None:
            return segments[0]
        epoch = segments[0].epoch
        parts = tuple(table._counted_from(epoch) for table in segments)
        self = object.__new__(cls)
        for name in ("seconds", "low", "wxyz", "angular_velocity"):
            columns = [getattr(segment, name) for segment in parts]
            known = all(column is not None for column in columns)
            self._set(name, frozen(np.concatenate(columns)) if known else None)
        self._set_all(
            epoch=epoch,
            method=parts[0].method,
            degree=parts[0].degree,
            meta=_known_meta(parts[0].meta if meta is None else meta),
            _parts=parts,
            _limits=None,
        )
        return self

    def __len__(self) -> int:
        return len(self.seconds)

    def __repr__(self) -> str:
        first, last = self.span
        parts = f" in {len(self.segments)} segments" if len(self.segments) > 1 else ""
        return (
            f"<AttitudeTable: {len(self)} records{parts} from {first.utc_iso} to {last.utc_iso} "
            f"UTC, {self.method} of degree {self.degree}>"
        )

    @property
    def segments(self) -> tuple[AttitudeTable, ...]:
        """The parts between which attitudes are not interpolated; (self,) for one."""
        return (self,) if self._parts is None else self._parts

    @property
    def span(self) -> tuple[Instant, Instant]:
        """First and last epoch of the attitudes, as Instants."""
        ends = [segment._limits for segment in self.segments]
        first, last = min(end[0] for end in ends), max(end[1] for end in ends)
        return self.epoch.after(*first), self.epoch.after(*last)

    @cached_property
    def history(self) -> AttitudeHistory:
        """The records as an AttitudeHistory, without interpolation."""
        history = AttitudeHistory(self, self.epoch, self.seconds, self.low, self.wxyz)
        if self.angular_velocity is not None:
            history.__dict__["angular_velocity"] = self.angular_velocity
        return history

    def has_rates_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> bool:
        """Whether the table has angular velocities."""
        return self.angular_velocity is not None

    def _evaluate(
        self, seconds: FloatArray, low: FloatArray | None, order: int
    ) -> list[FloatArray]:
        hi, lo = pairs.Seconds(seconds, low).flat
        out = [np.full((hi.size, width), np.nan) for width in (4, 3, 3)[: order + 1]]
        left = ~np.isnan(hi + lo)
        for segment in self.segments:
            inside = np.flatnonzero(left)
            inside = inside[segment._covers(hi[inside], lo[inside])]
            if len(inside):
                values = segment._interpolated(hi[inside], lo[inside], order)
                for array, value in zip(out, values, strict=True):
                    array[inside] = value
                left[inside] = False
        if np.any(left):
            self._refuse_outside(hi[left][0])
        return [array.reshape(*np.shape(seconds), array.shape[-1]) for array in out]

    def _refuse_outside(self, seconds: float) -> None:
        """AttitudeError for an epoch, in seconds, outside of all segments."""
        spans = [
            f"{self.epoch.after(*segment._limits[0]).utc_iso} to "
            f"{self.epoch.after(*segment._limits[1]).utc_iso}"
            for segment in self.segments
        ]
        listed = ", ".join(spans[:4]) + (", ..." if len(spans) > 4 else "")
        is_close = abs(seconds) < _WRITTEN
        where = f"{self.epoch.after(seconds).utc_iso} UTC" if is_close else f"{seconds:.9g} s"
        raise AttitudeError(
            f"the table has no attitude at {where}; its attitudes span {listed} UTC. Give epochs "
            "within, or fit a free rotation to the table, which has no limits."
        )

    # ---- One segment

    @cached_property
    def nodes(self) -> FloatArray:
        """(N, 4): the quaternions of the records, body to ICRF, with continuous signs."""
        return frozen(forms.continuous(self.wxyz))

    @cached_property
    def _coarse(self) -> BoolArray:
        """Whether the rates turn the body by more than half a turn to the next record, (N,)."""
        if self.angular_velocity is None:
            return np.zeros(len(self), dtype=bool)
        speed = np.linalg.norm(self.angular_velocity, axis=1)
        turn = np.diff(self.seconds) * 0.5 * (speed[1:] + speed[:-1])
        return np.append(turn > np.pi, False)

    def _covers(self, hi: FloatArray, lo: FloatArray) -> BoolArray:
        """Whether each epoch lies within the limits of the segment."""
        first, last = self._limits
        since = (hi - first[0]) + (lo - first[1])
        until = (last[0] - hi) + (last[1] - lo)
        return (since >= -_SLACK) & (until >= -_SLACK)

    def _interpolated(self, hi: FloatArray, lo: FloatArray, order: int) -> list[FloatArray]:
        row = np.searchsorted(self.seconds, hi, side="right") - 1
        row = np.clip(row, 0, len(self) - 1)
        ahead = (hi - self.seconds[row]) + (lo - self.low[row])
        behind = (ahead < 0.0) & (row > 0)
        row = row - behind
        ahead = (hi - self.seconds[row]) + (lo - self.low[row])
        exact = ahead == 0.0
        if np.any(self._coarse[row] & ~exact):
            k = int(row[np.flatnonzero(self._coarse[row] & ~exact)[0]])
            raise AttitudeError(
                f"records {k} and {k + 1} of the table are more than half a turn apart by their "
                "own angular velocities, so that attitudes between them cannot be interpolated; "
                "fit a free rotation to the table instead."
            )
        out = evaluate(self, row, ahead, order=order)
        out[0][exact] = self.nodes[row[exact]]
        if order and self.angular_velocity is not None:
            out[1][exact] = self.angular_velocity[row[exact]]
        return out

    def _usable(self, usable: Sequence[Epoch | None] | None) -> Limits:
        """First and last epoch, those of the records unless narrowed."""
        limits = [(float(self.seconds[k]), float(self.low[k])) for k in (0, -1)]
        ends: Any = (None, None) if usable is None else usable
        length = (len(ends),) if isinstance(ends, (list, tuple)) else np.shape(ends)
        if length != (2,):
            raise AttitudeError(
                f"usable is {validation.shown(usable)}; give a pair of epochs, either of which may "
                "be None."
            )
        for k, end in enumerate(ends):
            # Examples of the standard show the first record alone, which is before the usable time.
            if end is not None and len(self) > 1:
                hi, lo = _inputs.one_since(self.epoch, _inputs.instant(end, "usable"))
                beyond = (hi - limits[k][0]) + (lo - limits[k][1])
                if (beyond > 0.0) == (k == 0):  # inside of the records, not beyond them
                    limits[k] = hi, lo
        if limits[0] > limits[1]:
            raise AttitudeError(
                "the usable span ends before it begins, or lies outside of the records; give one "
                "between the first and the last record (usable=, USEABLE times of a message)."
            )
        return limits[0], limits[1]

    def _counted_from(self, epoch: Instant) -> AttitudeTable:
        """The same segment with its seconds counted from another epoch."""
        if epoch == self.epoch:
            return self
        shift = pairs.add((self.epoch.seconds, self.epoch.low), -epoch.seconds, -epoch.low)
        other = copy(self)
        other.__dict__.pop("history", None)
        hi, lo = pairs.add((self.seconds, self.low), *shift)
        limits = (pairs.add(end, *shift) for end in self._limits)
        ends = tuple((float(a), float(b)) for a, b in limits)
        other._set_all(epoch=epoch, seconds=frozen(hi), low=frozen(lo), _limits=ends)
        return other


def _known_meta(meta: Mapping[str, Any] | None) -> dict[str, Any]:
    """Names and comments; AttitudeError for anything but a mapping."""
    if meta is not None and not isinstance(meta, Mapping):
        raise AttitudeError(f"meta is {validation.shown(meta)}; give a mapping, such as a dict.")
    return dict(meta or {})


def refuse_speed(rates: FloatArray | None) -> None:
    """AttitudeError for angular velocities in rad/s above 1e30, whose squares may overflow."""
    if rates is not None and not np.all(np.abs(rates) <= _FASTEST):
        raise AttitudeError(
            f"an angular velocity is not finite or above {_FASTEST:g} rad/s; give finite angular "
            "velocities below that."
        )


def _refuse_disorder(hi: FloatArray, lo: FloatArray) -> None:
    """AttitudeError for epochs that are not finite, not increasing, too far or too uneven."""
    if not np.all(np.isfinite(hi + lo)):
        raise AttitudeError("t holds an epoch that is not finite; leave such records out.")
    farthest = np.abs(hi).max(initial=0.0)
    if farthest > _FARTHEST:
        raise AttitudeError(
            f"an epoch of t lies at {farthest:.3g} s; give {_FARTHEST:g} s at most."
        )
    steps = np.diff(hi) + np.diff(lo)
    if np.any(steps <= 0.0):
        k = int(np.flatnonzero(steps <= 0.0)[0])
        what = "is the same as" if steps[k] == 0.0 else "is earlier than"
        raise AttitudeError(
            f"epoch {k + 1} of t {what} the one before it; give increasing epochs, each once."
        )
    refuse_uneven(steps, "t")
