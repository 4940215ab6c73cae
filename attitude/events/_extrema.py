"""The maxima and minima of an observable: nearest approaches, extrema of brightness."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import polynomial as polynomials

from attitude._support import pairs, validation
from attitude.conditions._conditions import Channel, Joinable, Observable, fastest
from attitude.conditions._search import Advance, Sampled, crossings, difference, pieces, shifted
from attitude.errors import AttitudeError
from attitude.events._channels import Fixed, axis_or_long, chord_squared, direction_of, dot, turning
from attitude.events._search import Events, plain_span, plain_step, source_of, span
from attitude.frames import quaternion

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epoch, EpochOrSeconds, FloatArray, Real, Reals
    from attitude.conditions._moments import Drift, Moment, Pair, SearchDirection, Source
    from attitude.events._channels import AnyDirection
    from attitude.events._search import AnyMotion
    from attitude.motions._motion import RateBounds
    from attitude.scene._scene import Scene

    ValueFunction: TypeAlias = Callable[[FloatArray], ArrayLike]


# ---- Local maxima of a function from its values alone

_BLOCK = 8192
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# Golden sections of a bracket, to 1e-9 of its length.
_SECTIONS = 44
# A smooth peak is refined as the zero of its derivative, by differences over this part of a step.
_STENCIL_OF_PEAKS = 0.08
_WEIGHTS_OF_PEAKS = np.array([-1.0 / 60.0, 0.15, -0.75, 0.0, 0.75, -0.15, 1.0 / 60.0])
_SIXTH = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
_SMOOTH = 1e-5
_PLACES = np.arange(-3, 4)


def _peaks(f, start, stop, step, sign):
    """The maxima of sign * f between samples one step apart, block by block."""
    total = difference(start, stop)
    count = max(2, int(np.ceil(total / step)))
    step = total / count
    base, done, advance = start, 0, Advance(start, stop)
    while done < count and total > 0.0:
        size = min(_BLOCK, count - done)
        # One more sample on either side, since a peak shows by its neighbours.
        first = -1 if done else 0
        last = size + 1 if done + size < count else size
        s = np.arange(first, last + 1) * step

        def value(s, base=base):
            values = sign * validation.returned(f(*shifted(base, s)), "the function")
            if values.shape != s.shape:
                raise AttitudeError(
                    f"the function returns shape {values.shape} for {s.size} epochs; it must "
                    "return a number for each."
                )
            return values

        y = value(s)
        left, right = _tops(y)
        # Neighbouring blocks share three samples: a peak belongs to the block that holds the
        # last of its samples, unless that is the first sample of the block.
        inside = (right + first >= 2) & (right + first <= size + 1)
        peaks_found = _refined(value, s[left[inside]], s[right[inside]], step)
        if len(peaks_found):
            yield *shifted(base, peaks_found), sign * value(peaks_found)
        base = pairs.add(base, size * step)
        done += size
        advance.reached(base)
    advance.end()


def _tops(y):
    """Indices (left, right) of the neighbours of each sample, or pair of equal ones, above both.

    NaN counts as -inf. Three or more equal samples are a plateau, which has no maximum.
    """
    y = np.where(np.isnan(y), -np.inf, y)
    begin = np.concatenate([[0], np.flatnonzero(y[1:] != y[:-1]) + 1])
    end = np.concatenate([begin[1:] - 1, [len(y) - 1]])
    inner = (begin > 0) & (end < len(y) - 1) & (end - begin <= 1)
    left, right = begin[inner] - 1, end[inner] + 1
    top = (y[left + 1] > y[left]) & (y[right - 1] > y[right])
    return left[top], right[top]


def _refined(value, a, b, step):
    """The place of the maximum in each bracket (a, b)."""
    if not len(a):
        return a
    left, right = a, b
    for _ in range(_SECTIONS):
        c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
        p, q = value(c), value(d)
        # The maximum lies between equal values.
        a, b = np.where(p > q, a, c), np.where(p >= q, d, b)
        if np.all(b - a <= 1e-10 * step):
            break
    x = 0.5 * (a + b)
    return _polished(value, x, left, right, step)


def _polished(value, x, left, right, step):
    """Newton steps on the derivative by differences, kept within the flat part of a smooth top."""
    h = _STENCIL_OF_PEAKS * step
    inside = (x - 6.0 * h > left) & (x + 6.0 * h < right)
    y = x.copy()
    for _ in range(3):
        around = value((y + h * _PLACES[:, None]).reshape(-1)).reshape(7, -1)
        slope = _WEIGHTS_OF_PEAKS @ around / h
        bend = (around[2] - 2.0 * around[3] + around[4]) / (h * h)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = -slope / bend
        y = np.where(inside & (bend < 0.0) & (np.abs(move) < h), y + move, y)
    # The error of the formula is in sixth differences; where these are not small against the second
    # difference, the top is not smooth on this scale, and the result of the sections is kept.
    smooth = np.abs(_SIXTH @ around) < _SMOOTH * np.abs(bend) * h * h
    return np.where(inside & smooth, y, x)


# Derivatives by differences: 6th order over this many rad of the fastest rotation.
_STENCIL = 4e-3
# From the middle of the seven epochs to an end of the span, at least, in units of their spacing.
_REACH = 3.01
# Coefficients (6, 7) of the derivatives of Lagrange's polynomials through the seven epochs.
_SLOPES = np.stack(
    [
        polynomials.polyder(polynomials.polyfromroots(np.delete(_PLACES, k)))
        / np.prod(_PLACES[k] - np.delete(_PLACES, k))
        for k in range(len(_PLACES))
    ],
    axis=1,
)


def separation(motion: AnyMotion, axis: Reals | None, direction: AnyDirection) -> Observable:
    """The angle between a body axis and a direction, rad: its minima are nearest approaches.

    Parameters
    ----------
    motion : Motion, other object with ``.at(t)``, or Scene
    axis : (3,) array_like or None
        In body axes; None is the long axis, that of least moment of inertia.
    direction : as in `in_cone`

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
    >>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    >>> times, values = find_minima(0, 60, separation(motion, None, (0, 1, 0.5)))
    >>> times.round(9), values.round(9)                  # a quarter turn, and the latitude
    (array([15.70796327]), array([0.46364761]))
    """
    source = source_of(motion)
    unit = axis_or_long(axis, source)
    seen = direction_of(direction, "direction", source)
    return Observable(
        source, partial(_angle, unit, seen), partial(Receding, unit, seen), unit="rad"
    )


def _angle(axis: FloatArray, direction: SearchDirection, moment: Moment) -> FloatArray:
    """The angle (N,) between a body axis and a direction, rad."""
    u = moment.body(direction)
    return 2.0 * np.arctan2(np.sqrt(chord_squared(u, axis)), np.sqrt(chord_squared(u, -axis)))


def brightness(scene: Scene) -> Observable:
    """The brightness of a body in the shadow of others: brightness times lit fraction, m2/sr.

    See ``view.brightness`` and ``view.lit_fraction``; the scene needs a shape.

    Raises
    ------
    AttitudeError
        For a motion instead of a Scene.
    """
    source = source_of(scene)
    if source.scene is None:
        raise AttitudeError(
            f"{type(scene).__name__} is given, which has no brightness; give a Scene with a shape, "
            "or a function of seconds to the search."
        )
    return Observable(source, _brightness, unit="m2 / sr")


def _brightness(moment: Moment) -> FloatArray:
    view = moment.view
    return view.brightness * view.lit_fraction if moment.source.scene.shadow_of else view.brightness


def find_maxima(
    start: EpochOrSeconds,
    stop: EpochOrSeconds,
    f: Observable | ValueFunction,
    *,
    step: Real | None = None,
    epoch: Epoch | None = None,
) -> Events:
    """The local maxima of an observable strictly within a span.

    Parameters
    ----------
    start, stop : epochs or seconds
        As in `find_discrete`.
    f : Observable or function
        An Observable of `separation` or `brightness`, or a function of seconds (N,) that returns
        numbers (N,).
    step : float or Quantity, optional
        s; the spacing of samples, for a function (required) and for a brightness: by default 0.05
        rad of rotation, which resolves light curves.  Maxima that the samples do not show are
        missed.
    epoch : epoch, optional
        For a function only: the epoch from which its seconds count.

    Returns
    -------
    Events
        ``times, values = find_maxima(...)``; the values are those of f.  A top that is flat
        over three samples or more, such as no brightness in an umbra, is none.

    Raises
    ------
    AttitudeError
        For a span that ends before it begins, a function without a step, and epochs at which an
        attitude or a direction is unknown.

    Notes
    -----
    Extrema of a separation are zeros of its exact derivative, bracketed by bounds of the next
    derivatives: for free rotations all are found, except pairs within TOUCH rad of the rotation,
    and the error of epochs is below 1e-12 of a turn.  Extrema of a function are searched by its
    values: the error of epochs is 1e-10 of the time scale on which smooth values change, and
    rounding at kinks.
    """
    return _extrema(start, stop, f, step, epoch, 1.0)


def find_minima(
    start: EpochOrSeconds,
    stop: EpochOrSeconds,
    f: Observable | ValueFunction,
    *,
    step: Real | None = None,
    epoch: Epoch | None = None,
) -> Events:
    """The local minima of an observable strictly within a span; see `find_maxima`."""
    return _extrema(start, stop, f, step, epoch, -1.0)


def _extrema(start, stop, f, step, epoch, sign):
    if not isinstance(f, Observable):
        if isinstance(f, Joinable):
            raise AttitudeError(
                f"f is {f!r}, which is true or false and has no extrema; search it with "
                "find_discrete or windows."
            )
        if not callable(f):
            raise AttitudeError(
                f"f is {f!r}; give events.separation(...) or a function of seconds."
            )
        spacing = plain_step(step)
        first, last, instant = plain_span(start, stop, epoch)
        return _joined(
            instant, _peaks(lambda t, low: f(t + low), (first, 0.0), (last, 0.0), spacing, sign)
        )
    if epoch is not None:
        raise AttitudeError("epoch is for a plain function, not for an Observable; leave it out.")
    begin, end = span(f.source, start, stop)
    if step is None and f.slope is not None:
        # Interpolated attitudes have kinks, arcs seen in a scene jumps of the rate: there the slope
        # has no bounded derivative.
        limit = pieces(f.source, begin, end)[0][2]
        if limit.smooth if isinstance(limit, Sampled) else np.isfinite(limit.bounds.second):
            slope, extrema = f.slope(f.source, begin, end), []
            # The slope is that of the cosine: where it changes to positive, the angle is largest.
            for hi, lo, _, rising in crossings(f.source, [slope], begin, end):
                chosen = rising if sign > 0.0 else ~rising
                hi, lo = hi[chosen], lo[chosen]
                extrema.append((hi, lo, f(hi, lo)))
            return _joined(f.epoch, extrema, f.unit)
    spacing = f.spacing(begin, end) if step is None else plain_step(step)
    return _joined(f.epoch, _peaks(f, begin, end, spacing, sign), f.unit)


def _joined(epoch, extrema, unit=""):
    parts = [Events(epoch, hi, lo, values) for hi, lo, values in extrema]
    return Events.joined(epoch, parts, float, unit)


class Receding(Channel):
    """The derivative of u.a in a span, exact for a constant direction u; others are differenced."""

    def __init__(
        self,
        axis: FloatArray,
        direction: SearchDirection,
        source: Source,
        start: Pair,
        stop: Pair,
    ) -> None:
        self._axis, self.directions = axis, (direction,)
        # Division by the spacing amplifies rounding; in units of the largest rate.
        self.noise = 0.0 if isinstance(direction, Fixed) else 1e-12
        self._start, self._stop = start, stop
        # The same spacing in all blocks, so that an epoch has the same value in each.
        length = difference(start, stop)
        rate = fastest(source, start, stop) + direction.guess(source, start, length)
        self._spacing = min(_STENCIL / rate if rate > 0.0 else np.inf, length / (2.0 * _REACH))

    def value(self, moment: Moment) -> FloatArray:
        """The derivative (N,), 1/s."""
        direction = self.directions[0]
        u, w, a = moment.body(direction), moment.history.angular_velocity, self._axis
        # u' = u x w in body axes, times a.
        of_rotation = (
            u[..., 0] * (w[..., 1] * a[2] - w[..., 2] * a[1])
            + u[..., 1] * (w[..., 2] * a[0] - w[..., 0] * a[2])
            + u[..., 2] * (w[..., 0] * a[1] - w[..., 1] * a[0])
        )
        if isinstance(direction, Fixed):
            return of_rotation
        change, delay = self._differenced(moment, direction)
        of_direction = quaternion.rotate(quaternion.conjugate(moment.history.wxyz), change)
        # A scene shows the rotation by the light that left earlier.
        return dot(of_direction, a) + (1.0 - delay) * of_rotation

    def _differenced(
        self, moment: Moment, direction: SearchDirection
    ) -> tuple[FloatArray, FloatArray]:
        """The derivatives of a direction on ICRF axes, (N, 3) in 1/s, and of the light time.

        By seven epochs about each, moved where they would lie outside of the span.
        """
        source, spacing = moment.source, self._spacing
        after = (moment.hi - self._start[0]) + (moment.lo - self._start[1])
        before = (self._stop[0] - moment.hi) + (self._stop[1] - moment.lo)
        reach = _REACH * spacing
        offset = np.clip(0.0, reach - after, before - reach)
        weights = polynomials.polyval(-offset / spacing, _SLOPES) / spacing
        change, delay = np.zeros((*moment.hi.shape, 3)), np.zeros(moment.hi.shape)
        for place, weight in zip(_PLACES, weights, strict=True):
            if np.any(weight):
                there = source.at(*pairs.add((moment.hi, moment.lo), offset + place * spacing))
                change += weight[..., None] * there.inertial(direction)
                if source.scene is not None:
                    delay += weight * there.view.light_time
        return change, delay

    def bounds(self, rates: RateBounds, drifts: Sequence[Drift]) -> tuple[float, float]:
        """Upper bounds of the first two derivatives, those of u.a one order higher."""
        return turning(rates, drifts[0])[1:]
