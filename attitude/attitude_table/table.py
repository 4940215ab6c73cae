"""A history that was measured or read from a file, which answers ``.at(t)`` like a FreeRotation."""

from functools import cached_property

import numpy as np

from attitude import epochs, frames, pairs, quaternion, validation
from attitude import representations as forms
from attitude.attitude_table import interpolation
from attitude.errors import AttitudeError
from attitude.history import AttitudeHistory
from attitude.immutable import frozen
from attitude.motion import Motion

# How far outside of its records a table answers: the rounding of epochs given as dates, in s.
_SLACK = 1e-9
_FASTEST = 1e30


class AttitudeTable(Motion):
    """Attitudes at some epochs, and by interpolation between them.

    Parameters
    ----------
    epoch : str, astropy Time, Instant, ...
        From which plain numbers of t are counted.
    t : (N,) array_like
        Increasing: TDB seconds since the epoch, or epochs of any kind (see `FreeRotation.at`).
    wxyz : (N, 4) array_like
        Body to `frame`, scalar first, of unit length to 1e-3 (rounded ones are made unit); any
        sign.
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
        Of the interpolating polynomial, 7 if nothing is said; reduced where there are too few
        records.
    usable : pair of epochs, optional
        Between which the table may be asked; first and last record by default.
    meta : dict, optional
        What the file says otherwise: names, comments.

    Attributes
    ----------
    epoch : Instant
    seconds, low, wxyz, angular_velocity : arrays
        The records, attitudes in ICRF; angular_velocity is None where none were given.
    method, degree : str, int
        How it is interpolated.
    segments : tuple of AttitudeTable
        The parts of a file with several; (self,) for one.
    span : (Instant, Instant)
    history : AttitudeHistory
        The records themselves.

    Raises
    ------
    AttitudeError
        For epochs that do not increase, shapes, quaternions that are no attitudes.

    >>> table = AttitudeTable("2026-01-01", [0, 10], [[1, 0, 0, 0], [0, 0, 0, 1]], method="slerp")
    >>> table.at(5.0).wxyz.round(12)
    array([0.70710678, 0.        , 0.        , 0.70710678])
    """

    def __init__(
        self,
        epoch,
        t,
        wxyz,
        *,
        angular_velocity=None,
        low=None,
        frame="icrf",
        method=None,
        degree=None,
        usable=None,
        meta=None,
    ):
        epoch = epochs.instant(epoch)
        hi, lo = epochs.seconds_since(epoch, t, low)
        if hi.ndim != 1 or not len(hi):
            raise AttitudeError(f"t has shape {hi.shape}; a table wants a row of epochs, (N,).")
        hi, lo = pairs.two_sum(hi, np.zeros(len(hi)) if lo is None else lo)
        _refuse_disorder(hi, lo)
        wxyz = validation.real(wxyz, "wxyz", shape=(len(hi), 4))
        wxyz = forms.unit(wxyz, tolerance=1e-3)
        if frames.known(frame) not in ("icrf", "gcrf"):
            wxyz = quaternion.multiply(frames.wxyz_to_icrf(frame), wxyz)
        if angular_velocity is not None:
            angular_velocity = validation.real(
                angular_velocity, "angular_velocity", shape=(len(hi), 3), unit="rad/s"
            )
            refuse_speed(angular_velocity)
            angular_velocity = frozen(angular_velocity)
        method, degree = interpolation.settled(
            method, degree, len(hi), angular_velocity is not None
        )
        self._set("epoch", epoch)
        self._set("seconds", frozen(hi))
        self._set("low", frozen(np.asarray(lo)))
        self._set("wxyz", frozen(wxyz))
        self._set("angular_velocity", angular_velocity)
        self._set("method", method)
        self._set("degree", degree)
        self._set("meta", dict(meta or {}))
        self._set("_limits", self._usable(usable))
        self._set("_parts", None)

    @classmethod
    def from_history(cls, history, *, rates=True, method=None, degree=None, meta=None):
        """A table of the attitudes (and, with rates, angular velocities) of a history (N,)."""
        return cls(
            history.epoch,
            np.array(history.seconds),
            history.wxyz,
            low=None if history.low is None else np.array(history.low),
            angular_velocity=history.angular_velocity if rates else None,
            method=method,
            degree=degree,
            meta=meta,
        )

    @classmethod
    def joined(cls, tables, *, meta=None):
        """Several tables as the segments of one.  Where they overlap, the earlier one answers.

        Nothing is interpolated across the gap between two segments.
        """
        tables = [part for table in tables for part in table.segments]
        if not tables:
            raise AttitudeError("there are no segments to join; give one table or more.")
        if len(tables) == 1 and meta is None:
            return tables[0]
        epoch = tables[0].epoch
        parts = tuple(table._counted_from(epoch) for table in tables)
        self = object.__new__(cls)
        rates = [part.angular_velocity for part in parts]
        joined = {
            "epoch": epoch,
            "seconds": np.concatenate([part.seconds for part in parts]),
            "low": np.concatenate([part.low for part in parts]),
            "wxyz": np.concatenate([part.wxyz for part in parts]),
            "angular_velocity": None if any(r is None for r in rates) else np.concatenate(rates),
            "method": parts[0].method,
            "degree": parts[0].degree,
            "meta": dict(parts[0].meta if meta is None else meta),
            "_parts": parts,
            "_limits": None,
        }
        for name, value in joined.items():
            self._set(name, frozen(value) if isinstance(value, np.ndarray) else value)
        return self

    def __len__(self):
        return len(self.seconds)

    def __repr__(self):
        first, last = self.span
        parts = f" in {len(self.segments)} segments" if len(self.segments) > 1 else ""
        return (
            f"<AttitudeTable: {len(self)} records{parts} from {first.utc_iso} to {last.utc_iso} "
            f"UTC, {self.method} of degree {self.degree}>"
        )

    @property
    def segments(self):
        return (self,) if self._parts is None else self._parts

    @property
    def span(self):
        """First and last epoch at which it answers, as Instants."""
        ends = [part._limits for part in self.segments]
        first, last = min(end[0] for end in ends), max(end[1] for end in ends)
        return self.epoch.after(*first), self.epoch.after(*last)

    @cached_property
    def history(self):
        """The records as an AttitudeHistory, just as they were given."""
        history = AttitudeHistory(self, self.epoch, self.seconds, self.low, self.wxyz)
        if self.angular_velocity is not None:
            history.__dict__["angular_velocity"] = self.angular_velocity
        return history

    def has_rates_at(self, seconds, low=None):
        """Whether angular velocities were given."""
        return self.angular_velocity is not None

    def _evaluate(self, seconds, low, order):
        hi = np.ravel(seconds)
        lo = np.zeros(hi.size) if low is None else np.ravel(low)
        out = [np.full((hi.size, width), np.nan) for width in (4, 3, 3)[: order + 1]]
        left = ~np.isnan(hi + lo)
        for part in self.segments:
            inside = np.flatnonzero(left)
            inside = inside[part._answers(hi[inside], lo[inside])]
            if len(inside):
                values = part._interpolated(hi[inside], lo[inside], order)
                for array, value in zip(out, values, strict=True):
                    array[inside] = value
                left[inside] = False
        if np.any(left):
            self._refuse_outside(hi[left][0])
        return [array.reshape(*np.shape(seconds), array.shape[-1]) for array in out]

    def _refuse_outside(self, seconds):
        spans = [
            f"{self.epoch.after(*part._limits[0]).utc_iso} to "
            f"{self.epoch.after(*part._limits[1]).utc_iso}"
            for part in self.segments
        ]
        listed = ", ".join(spans[:4]) + (", ..." if len(spans) > 4 else "")
        where = f"{self.epoch.after(seconds).utc_iso} UTC" if np.isfinite(seconds) else seconds
        raise AttitudeError(
            f"the table has no attitude at {where}; it answers from {listed} UTC. Ask within, or "
            "fit a free rotation to it, which has no limits."
        )

    # One segment ----------------------------------------------------------------------------------

    @cached_property
    def nodes(self):
        """(N, 4): the records with continuous signs."""
        return frozen(forms.continuous(self.wxyz))

    @property
    def hi(self):
        return self.seconds

    @property
    def lo(self):
        return self.low

    @property
    def rates(self):
        return self.angular_velocity

    @cached_property
    def _coarse(self):
        """Which steps turn the body by more than half a turn, so far as its rates tell."""
        if self.angular_velocity is None:
            return np.zeros(len(self), dtype=bool)
        speed = np.linalg.norm(self.angular_velocity, axis=1)
        turn = np.diff(self.seconds) * 0.5 * (speed[1:] + speed[:-1])
        return np.append(turn > np.pi, False)

    def _answers(self, hi, lo):
        first, last = self._limits
        since = (hi - first[0]) + (lo - first[1])
        until = (last[0] - hi) + (last[1] - lo)
        return (since >= -_SLACK) & (until >= -_SLACK)

    def _interpolated(self, hi, lo, order):
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
        out = interpolation.evaluate(self, row, ahead, order=order)
        out[0][exact] = self.nodes[row[exact]]
        if order and self.angular_velocity is not None:
            out[1][exact] = self.angular_velocity[row[exact]]
        return out

    def _usable(self, usable):
        limits = (self.seconds[0], self.low[0]), (self.seconds[-1], self.low[-1])
        limits = [tuple(map(float, end)) for end in limits]
        for k, end in enumerate(usable or ()):
            if end is not None:
                hi, lo = epochs.seconds_since(self.epoch, epochs.instant(end, "usable"))
                beyond = (hi - limits[k][0]) + (lo - limits[k][1])
                if (beyond > 0.0) == (k == 0):  # inside of the records; never beyond them
                    limits[k] = float(hi), float(lo)
        return tuple(limits)

    def _counted_from(self, epoch):
        """The same segment, its seconds counted from another epoch."""
        if epoch == self.epoch:
            return self
        shift = pairs.add((self.epoch.seconds, self.epoch.low), -epoch.seconds, -epoch.low)
        other = object.__new__(AttitudeTable)
        for name, value in self.__dict__.items():
            if name not in ("history",):
                other._set(name, value)
        hi, lo = pairs.add((self.seconds, self.low), *shift)
        limits = (pairs.add(end, *shift) for end in self._limits)
        other._set("epoch", epoch)
        other._set("seconds", frozen(hi))
        other._set("low", frozen(lo))
        other._set("_limits", tuple((float(a), float(b)) for a, b in limits))
        return other


def refuse_speed(rates):
    """AttitudeError for angular velocities whose squares would overflow, or that did already."""
    if rates is not None and not np.all(np.abs(rates) <= _FASTEST):
        raise AttitudeError(
            f"an angular velocity is not finite or above {_FASTEST:g} rad/s; no body turns so fast."
        )


def _refuse_disorder(hi, lo):
    if not np.all(np.isfinite(hi + lo)):
        raise AttitudeError("t holds an epoch that is not finite; leave such records out.")
    steps = np.diff(hi) + np.diff(lo)
    if np.any(steps <= 0.0):
        k = int(np.flatnonzero(steps <= 0.0)[0])
        what = "is the same as" if steps[k] == 0.0 else "is earlier than"
        raise AttitudeError(
            f"epoch {k + 1} of t {what} the one before it; give increasing epochs, each once."
        )
