"""Where a quantity is greatest or least: nearest approaches, and extrema of brightness."""

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.events.conditions import axis_or_long, chord_squared, dot, turning
from attitude.events.directions import Fixed, direction_of, source_of, values_at
from attitude.events.discrete import plain_span, plain_step, span
from attitude.events.events import Events
from attitude.events.peaks import peaks
from attitude.events.rate_bounds import Sampled, pieces
from attitude.events.search import crossings

# Samples of a quantity whose derivatives have no bounds, in rad of the rotation.
_SAMPLES = 0.05
# Derivatives by differences: 6th order over this many rad of the fastest rotation.
_STENCIL = 4e-3
_WEIGHTS = ((1, 0.75), (2, -0.15), (3, 1.0 / 60.0))


class Quantity:
    """A number at every epoch, of which `find_maxima` and `find_minima` are sought.

    ``quantity(t)`` tells it; `slope` is a channel with the sign of its growth, or None.
    """

    def __init__(self, source, value, slope=None):
        self.source, self._value, self.slope = source, value, slope

    @property
    def epoch(self):
        return self.source.epoch

    def __call__(self, t, low=None):
        return values_at(self.source, self._value, t, low)


def separation(motion, axis, direction):
    """The angle between a body axis and a direction, rad: its minima are conjunctions.

    Parameters
    ----------
    motion : FreeRotation, anything else with ``.at(t)``, or Scene
    axis : (3,) array_like or None
        In body axes; None is the long axis, that of least inertia.
    direction : as of `in_cone`

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
    >>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    >>> times, values = find_minima(0, 60, separation(motion, None, (0, 1, 0.5)))
    >>> times.round(9), values.round(9)                  # a quarter turn, and the latitude
    (array([15.70796327]), array([0.46364761]))
    """
    source = source_of(motion)
    axis = axis_or_long(axis, source)
    seen = direction_of(direction, "direction", source)

    def angle(moment):
        u = moment.body(seen)
        return 2.0 * np.arctan2(np.sqrt(chord_squared(u, axis)), np.sqrt(chord_squared(u, -axis)))

    return Quantity(source, angle, Receding(axis, seen))


def brightness(scene):
    """What the observer of a Scene receives, m2/sr times the fraction of the Sun that is free.

    See ``view.brightness`` and ``view.lit_fraction``; the scene needs a shape.
    """
    source = source_of(scene)
    if source.scene is None:
        raise AttitudeError(
            f"{type(scene).__name__} is given, which has no brightness; give a Scene with a shape, "
            "or a function of seconds to the search."
        )

    def value(moment):
        view = moment.view
        return view.brightness * view.lit_fraction if source.scene.shadow_of else view.brightness

    return Quantity(source, value)


def find_maxima(start, stop, f, *, step=None, epoch=None):
    """The local maxima of a quantity strictly within a span.

    Parameters
    ----------
    start, stop : epochs or seconds
        As of `find_discrete`.
    f : Quantity or function
        What `separation` and `brightness` make, or a function of seconds (N,) that returns (N,)
        numbers.
    step : float or Quantity, optional
        s; of samples, for a function and for a brightness: a twentieth of a radian of rotation
        (the default of a brightness) is right for light curves.  Maxima that lie between samples
        which do not show them are missed.
    epoch : epoch, optional
        For a function only: from which seconds are counted.

    Returns
    -------
    Events
        ``times, values = find_maxima(...)``; the values are those of f.  Of a flat top the middle
        is returned.

    Notes
    -----
    Extrema of a separation are zeros of its exact derivative, bracketed by bounds of the next
    ones: for free rotations none is missed but pairs within TOUCH rad of the rotation, and epochs
    are good to 1e-12 of a turn.  Those of a function are searched by its values: where these are
    smooth, epochs are good to 1e-10 of the time scale in which they change, at kinks to rounding.
    """
    return _extrema(start, stop, f, step, epoch, 1.0)


def find_minima(start, stop, f, *, step=None, epoch=None):
    """The local minima of a quantity strictly within a span; see `find_maxima`."""
    return _extrema(start, stop, f, step, epoch, -1.0)


def _extrema(start, stop, f, step, epoch, sign):
    if not isinstance(f, Quantity):
        if not callable(f):
            raise AttitudeError(
                f"f is {f!r}; give events.separation(...) or a function of seconds."
            )
        step = plain_step(step)
        begin, end, epoch = plain_span(start, stop, epoch)
        return _joined(
            epoch, peaks(lambda t, low: f(t + low), (begin, 0.0), (end, 0.0), step, sign)
        )
    if epoch is not None:
        raise AttitudeError("epoch goes with a plain function; leave it out.")
    begin, end = span(f.source.epoch, start, stop)
    limit = pieces(f.source, begin, end)[0][2]
    if step is None and f.slope is not None and not _is_rough(limit):
        return Events.joined(f.epoch, list(_by_slope(f, begin, end, sign)), float)
    if step is None:
        rate = limit.guess(f.source, begin)
        step = _SAMPLES / rate if rate > 0.0 else max(end[0] - begin[0], 1.0) / 64.0
    step = validation.positive(step, "step", unit="s")
    return _joined(f.epoch, peaks(f, begin, end, step, sign))


def _is_rough(limit):
    return isinstance(limit, Sampled) and not limit.smooth


def _by_slope(f, begin, end, sign):
    # The slope is that of the cosine: where it begins to grow the angle is greatest.
    for hi, lo, _, rising in crossings(f.source, [f.slope], begin, end):
        wanted = rising if sign > 0.0 else ~rising
        hi, lo = hi[wanted], lo[wanted]
        yield Events(f.epoch, hi, lo, f(hi, lo))


def _joined(epoch, found):
    parts = [Events(epoch, hi, lo, values) for hi, lo, values in found]
    return Events.joined(epoch, parts, float)


class Receding:
    """The rate of change of u.a, of a direction u and a body axis a: rises at greatest angles."""

    def __init__(self, axis, direction):
        self._axis, self.directions, self._rate = axis, (direction,), None
        # Differences lose what the spacing divides by; in units of the greatest rate.
        self.noise = 0.0 if isinstance(direction, Fixed) else 1e-12

    def value(self, moment):
        direction = self.directions[0]
        u = moment.body(direction)
        if isinstance(direction, Fixed):
            w = moment.history.angular_velocity
            a = self._axis
            # u' = u x w over body axes, times a.
            return (
                u[..., 0] * (w[..., 1] * a[2] - w[..., 2] * a[1])
                + u[..., 1] * (w[..., 2] * a[0] - w[..., 0] * a[2])
                + u[..., 2] * (w[..., 0] * a[1] - w[..., 1] * a[0])
            )
        return self._by_differences(moment)

    def _by_differences(self, moment):
        source, direction = moment.source, self.directions[0]
        rate = self._stencil_rate(moment)
        d = _STENCIL / rate
        total = 0.0
        for k, weight in _WEIGHTS:
            ahead, behind = (
                dot(source.at(moment.hi, moment.lo + side * k * d).body(direction), self._axis)
                for side in (1.0, -1.0)
            )
            total = total + weight * (ahead - behind)
        return total / d

    def _stencil_rate(self, moment):
        # The same spacing for all blocks, so that an epoch has one value.
        if self._rate is None:
            start = (float(moment.hi.flat[0]), float(moment.lo.flat[0]))
            limit = pieces(moment.source, start, start)[0][2]
            self._rate = limit.guess(moment.source, start) or 1.0
        return self._rate

    def bounds(self, rates, drifts):
        return turning(rates, drifts[0])[1:]
