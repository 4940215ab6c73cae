"""The base class of paths: position and velocity at any TDB epoch, relative to a center.

The methods of a path take arrays of epochs, each the sum of an `epochs.Instant` and one or two
doubles of seconds, as `epochs.seconds_since` returns them, so that no epoch is rounded to a single
double of seconds or days.  Positions are in metres and velocities in m/s, on ICRF axes, relative
to `path.center`: the name of a body ("ssb", "sun", "earth", ...) or another path.  `relative`
joins paths with different centers.

What a new kind of path defines
-------------------------------
``name``, ``center``, ``source`` and ``span`` as attributes or properties, and two methods over
flat arrays of finite epochs: ``_position(instant, hi, lo)``, which returns (3, N), and
``_state(instant, hi, lo)``, which returns two of them.  hi has shape (N,), lo (N,) or (1,).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn, cast

import numpy as np

from attitude import pairs
from attitude.epochs import time_scales
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.memory import components_last
from attitude.paths.place import Place

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray

J2000: Instant = Instant(0.0)
_NO_LOW = np.zeros(1)
_NO_LOW.setflags(write=False)


class Path(Place):
    """Something with a position and a velocity at any TDB epoch; the base of all kinds of paths.

    Attributes
    ----------
    name : str
        Name of the body, spacecraft or place that moves along the path.
    center : str or Path
        Origin of the positions: the name of a body, or another path.
    source : str
        Origin of the numbers: the kernel, file or model.
    span : (Instant, Instant) or None
        First and last epoch; None where there is no limit.
    roughness : float
        Upper bound in m of the distance from a smooth curve, for a source that rounds positions
        more coarsely than a double of metres does.
    is_slow : bool
        Whether a position costs tens of microseconds, so that a few hundred are fitted faster.
    is_direction : bool
        False.
    has_horizon : bool
        True for a place on the ground, which defines `zenith`.
    """

    name: str = "path"
    center: str | Path = "ssb"
    source: str = "given"
    span: tuple[Instant, Instant] | None = None
    roughness: float = 0.0
    is_slow: bool = False

    def position(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Position relative to the center in m, ICRF axes.

        Parameters
        ----------
        instant : epochs.Instant
        seconds : (...) float64 array
            TDB seconds from the instant.
        low : (...) float64 array, optional
            What `seconds` rounds off; the epochs are instant + seconds + low.

        Returns
        -------
        (..., 3) float64 array
            A view of component-major memory.  NaN where the epoch is NaN.

        Raises
        ------
        AttitudeError
            For an epoch outside of `span`.
        """
        return self._evaluate(instant, seconds, low, self._position_alone)[0]

    def velocity(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Velocity relative to the center in m/s of TDB, ICRF axes; see `position`."""
        return self._evaluate(instant, seconds, low, self._velocity_alone)[0]

    def state(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Position in m and velocity in m/s; see `position`."""
        position, velocity = self._evaluate(instant, seconds, low, self._state)
        return position, velocity

    def _position(self, instant: Instant, hi: FloatArray, lo: FloatArray) -> FloatArray:
        """Positions (3, N) at finite epochs instant + hi + lo."""
        return self._state(instant, hi, lo)[0]

    def _state(
        self, instant: Instant, hi: FloatArray, lo: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities (3, N) at finite epochs instant + hi + lo."""
        raise NotImplementedError(f"{type(self).__name__} defines no _state")

    def _position_alone(self, instant, hi, lo):
        return (self._position(instant, hi, lo),)

    def _velocity_alone(self, instant, hi, lo):
        return (self._state(instant, hi, lo)[1],)

    def _evaluate(self, instant, seconds, low, method):
        """Results (..., 3) of a method that takes flat arrays of finite epochs."""
        hi = np.asarray(seconds, dtype=np.float64)
        shape, lo = hi.shape, _NO_LOW
        if low is not None:
            lo = np.asarray(low, dtype=np.float64)
            if lo.shape != shape:
                shape = np.broadcast_shapes(shape, lo.shape)
                lo = np.broadcast_to(lo, shape)
            lo = np.ascontiguousarray(lo).reshape(-1)
        if hi.shape != shape:
            hi = np.broadcast_to(hi, shape)
        hi = np.ascontiguousarray(hi).reshape(-1)
        if not hi.size:
            return (np.zeros((*shape, 3)),) * (2 if method == self._state else 1)
        # The sum is finite exactly where every term of it is.
        if np.isfinite(hi.sum() + lo.sum()) or np.isfinite(hi + lo).all():
            rows = method(instant, hi, lo)
        else:
            rows = self._without_nan(instant, hi, lo, method)
        return tuple(components_last(row.reshape(3, *shape)) for row in rows)

    def _without_nan(self, instant, hi, lo, method):
        """Results (3, N) of a method, NaN where the epoch is NaN."""
        total = hi + lo
        known = ~np.isnan(total)
        if np.isinf(total).any():
            raise AttitudeError(
                f"an epoch for {self.name} is infinite; give finite seconds, or NaN where there is "
                "no epoch."
            )
        found = method(instant, hi[known], np.broadcast_to(lo, hi.shape)[known])
        rows = []
        for part in found:
            row = np.full((3, hi.size), np.nan)
            row[:, known] = part
            rows.append(row)
        return rows

    def refuse_outside(self, instant: Instant, seconds: float) -> NoReturn:
        """Raise the AttitudeError for the epoch instant + seconds, which is outside of the span."""
        assert self.span is not None
        first, last = self.span
        raise AttitudeError(
            f"{self.name} is known from {spelled(first)} to {spelled(last)} ({self.source}), but "
            f"an epoch is {spelled(instant.after(float(seconds)))}; leave that epoch out, or give "
            "a path that covers it."
        )

    def check_span(self, instant: Instant, hi: FloatArray, lo: FloatArray) -> None:
        """Raise an AttitudeError if an epoch instant + hi + lo lies outside of the span."""
        if self.span is None or not hi.size:
            return
        first, last = (since(each, instant) for each in self.span)
        # Mostly the sums of the extremes lie within, and no other sum is needed.
        least, most = (hi.min(), lo.min()), (hi.max(), lo.max())
        if _later(least, first) > 0.0 and _later(last, most) > 0.0:
            return
        for bound, side in ((first, 1.0), (last, -1.0)):
            # The sum is rounded once, which matters between neighbouring doubles only.
            beyond = side * ((hi - bound[0]) + (lo - bound[1]))
            if beyond.min() < 0.0:
                self.refuse_outside(instant, hi[np.argmin(beyond)])

    def __repr__(self) -> str:
        center = self.center if isinstance(self.center, str) else self.center.name
        return f"<path of {self.name} from {center}: {self.source}>"


def _later(one, other):
    """Seconds from another epoch to one, each in two parts, rounded once or twice."""
    return (one[0] - other[0]) + (one[1] - other[1])


def since(instant: Instant, start: Instant) -> tuple[float, float]:
    """TDB seconds from start to instant as two floats."""
    return pairs.add((instant.seconds, instant.low), -start.seconds, -start.low)


def julian(instant: Instant, hi: FloatArray, lo: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A two-part Julian date of TDB for the epochs instant + hi + lo, to 5e-12 s."""
    date = time_scales.jd_from_seconds(*pairs.add((hi, lo), instant.seconds, instant.low))
    return cast("tuple[FloatArray, FloatArray]", date)


def spelled(instant: Instant) -> str:
    """An instant as text in TDB to the millisecond, for messages."""
    import erfa

    jd = time_scales.jd_from_seconds(np.float64(instant.seconds), np.float64(instant.low))
    year, month, day, clock = erfa.ufunc.d2dtf(b"TDB", 3, *jd)[:4]
    hour, minute, second, milli = (clock[name] for name in ("h", "m", "s", "f"))
    return f"{year:04d}-{month:02d}-{day:02d}T{hour:02d}:{minute:02d}:{second:02d}.{milli:03d} TDB"


def common_span(paths: Iterable[Any]) -> tuple[Instant, Instant] | None:
    """First and last epoch that all paths (or motions) cover, or None if none has a limit."""
    spans = [path.span for path in paths if path.span is not None]
    if not spans:
        return None
    first = max((span[0] for span in spans), key=lambda each: (each.seconds, each.low))
    last = min((span[1] for span in spans), key=lambda each: (each.seconds, each.low))
    return first, last
