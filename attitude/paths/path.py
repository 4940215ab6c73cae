"""What a path is: something with a position and a velocity at any TDB epoch, relative to a center.

A path answers for arrays of epochs, each the sum of an `epochs.Instant` and one or two doubles of
seconds, as `epochs.seconds_since` returns them, so that nothing is lost to a single double of
seconds or days.  Positions are in metres and velocities in m/s, on ICRF axes, relative to
`path.center`: the name of a body ("ssb", "sun", "earth", ...) or another path.  `relative` joins
paths with different centers.

What a new kind of path defines
-------------------------------
``name``, ``center``, ``source`` and ``span`` as attributes or properties, and two methods over
flat arrays of finite epochs: ``_position(instant, hi, lo)``, which returns (3, N), and
``_state(instant, hi, lo)``, which returns two of them.  hi has shape (N,), lo (N,) or (1,).
"""

import numpy as np
from numpy.typing import ArrayLike

from attitude import pairs
from attitude.epochs import time_scales
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.paths.place import Place

J2000 = Instant(0.0)
_NO_LOW = np.zeros(1)
_NO_LOW.setflags(write=False)


class Path(Place):
    """Something with a position and a velocity at any TDB epoch; the base of all kinds of paths.

    Attributes
    ----------
    name : str
        What it is the path of.
    center : str or Path
        What it is relative to.
    source : str
        Where the numbers come from: the kernel, file or model.
    span : (Instant, Instant) or None
        First and last epoch; None where there is no limit.
    roughness : float
        How far the positions lie from a smooth curve in m, where their source rounds more than a
        double of metres does.
    is_direction : bool
        False.
    has_horizon : bool
        True of a place on the ground, which defines `zenith`.
    """

    name: str = "path"
    center: "str | Path" = "ssb"
    source: str = "given"
    span: tuple[Instant, Instant] | None = None
    roughness: float = 0.0

    def position(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> np.ndarray:
        """Position relative to the center in m, ICRF axes.

        Parameters
        ----------
        instant : epochs.Instant
        seconds : (...) float64 array
            TDB seconds from the instant.
        low : (...) float64 array, optional
            What `seconds` leaves out; the epochs are instant + seconds + low.

        Returns
        -------
        (..., 3) float64 array
            A view of component-major memory.  NaN where the epoch is NaN.

        Raises
        ------
        AttitudeError
            For an epoch outside of `span`.
        """
        return self._answer(instant, seconds, low, self._position_alone)[0]

    def velocity(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> np.ndarray:
        """Velocity relative to the center in m/s of TDB, ICRF axes; see `position`."""
        return self._answer(instant, seconds, low, self._velocity_alone)[0]

    def state(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity; see `position`."""
        return self._answer(instant, seconds, low, self._state)

    def _position_alone(self, instant, hi, lo):
        return (self._position(instant, hi, lo),)

    def _velocity_alone(self, instant, hi, lo):
        return (self._state(instant, hi, lo)[1],)

    def _answer(self, instant, seconds, low, method):
        hi = np.asarray(seconds, dtype=np.float64)
        shape, lo = hi.shape, _NO_LOW
        if low is not None:
            lo = np.asarray(low, dtype=np.float64)
            shape = np.broadcast_shapes(shape, lo.shape)
            lo = np.ascontiguousarray(np.broadcast_to(lo, shape)).reshape(-1)
        hi = np.ascontiguousarray(np.broadcast_to(hi, shape)).reshape(-1)
        if not hi.size:
            return (np.zeros((*shape, 3)),) * (2 if method == self._state else 1)
        # The sum is finite exactly where every term of it is.
        if np.isfinite(hi.sum() + lo.sum()) or np.isfinite(hi + lo).all():
            rows = method(instant, hi, lo)
        else:
            rows = self._where_known(instant, hi, lo, method)
        return tuple(np.moveaxis(row.reshape(3, *shape), 0, -1) for row in rows)

    def _where_known(self, instant, hi, lo, method):
        total = hi + lo
        known = ~np.isnan(total)
        if np.isinf(total).any():
            raise AttitudeError(
                f"an epoch at which {self.name} is asked for is infinite; give finite seconds, or "
                "NaN where there is none."
            )
        found = method(instant, hi[known], np.broadcast_to(lo, hi.shape)[known])
        rows = []
        for part in found:
            row = np.full((3, hi.size), np.nan)
            row[:, known] = part
            rows.append(row)
        return rows

    def _position(self, instant, hi, lo):
        return self._state(instant, hi, lo)[0]

    def _state(self, instant, hi, lo):
        raise NotImplementedError(f"{type(self).__name__} defines no _state")

    def refuse_outside(self, instant, seconds):
        """Raise the AttitudeError for epochs outside of the span; seconds: one that is."""
        first, last = self.span
        raise AttitudeError(
            f"{self.name} is known from {spelled(first)} to {spelled(last)} ({self.source}), but "
            f"was asked for at {spelled(instant.after(float(seconds)))}; leave that epoch out, or "
            "give a path that covers it."
        )

    def check_span(self, instant, hi, lo):
        """Raise an AttitudeError if an epoch lies outside of the span."""
        if self.span is None or not hi.size:
            return
        first, last = (since(each, instant) for each in self.span)
        for bound, side in ((first, 1.0), (last, -1.0)):
            # Rounded once, which decides between neighbouring doubles only.
            beyond = side * ((hi - bound[0]) + (lo - bound[1]))
            if beyond.min() < 0.0:
                self.refuse_outside(instant, hi[np.argmin(beyond)])

    def __repr__(self):
        center = self.center if isinstance(self.center, str) else self.center.name
        return f"<path of {self.name} from {center}: {self.source}>"


def since(instant, start):
    """Seconds from start to instant as two floats."""
    return pairs.add((instant.seconds, instant.low), -start.seconds, -start.low)


def julian(instant, hi, lo):
    """A two-part Julian date of TDB, to 5e-12 s."""
    return time_scales.jd_from_seconds(*pairs.add((hi, lo), instant.seconds, instant.low))


def spelled(instant):
    """An instant as text in TDB, for messages."""
    import erfa

    jd = time_scales.jd_from_seconds(np.float64(instant.seconds), np.float64(instant.low))
    year, month, day, clock = erfa.ufunc.d2dtf(b"TDB", 3, *jd)[:4]
    hour, minute, second, milli = (clock[name] for name in ("h", "m", "s", "f"))
    return f"{year:04d}-{month:02d}-{day:02d}T{hour:02d}:{minute:02d}:{second:02d}.{milli:03d} TDB"


def common_span(paths):
    """The epochs that all paths cover, or None where none of them has a limit."""
    spans = [path.span for path in paths if path.span is not None]
    if not spans:
        return None
    first = max((span[0] for span in spans), key=lambda each: (each.seconds, each.low))
    last = min((span[1] for span in spans), key=lambda each: (each.seconds, each.low))
    return first, last
