"""All sign changes of smooth functions: subdivision with bounds of derivatives.

Between two knots h apart, with |f''| <= M and values p, q at the ends, there is

* no zero, if p and q have one sign and the least possible |f| is positive:
  (|p| + |q|)/2 - M h^2/8 - (|q| - |p|)^2 / (2 M h^2), or the lesser of |p|, |q| if these differ by
  M h^2/2 and more;
* exactly one, if they have opposite signs and |q - p| > M h^2/2, since then f' does not vanish;
* with |f'| <= B alone: none, if they have one sign and |p| + |q| > B h.

Any other interval is divided, down to TOUCH radians of the fastest rotation.  An interval of that
length with one sign at both ends holds a touch, or two crossings nearer to each other than that.

Time within a block is a single double, counted from the block's start, a pair of doubles: a block
spans at most 13000 radians, so that epochs are resolved to 2e-12 rad at any distance from the
motion's epoch.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from attitude._support import pairs
from attitude._support.blocks import ProgressBar
from attitude.conditions._moments import lengths
from attitude.errors import AttitudeError
from attitude.motions._motion import RateBounds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.conditions._conditions import Channel
    from attitude.conditions._moments import Moment, Pair, Source
    from attitude.motions._motion import Motion


# ---- How far a search in time is, as a bar on a terminal


class Advance:
    """The progress of a search that goes through its span, s, once or several times."""

    def __init__(self, start: Pair, stop: Pair, rounds: int = 1) -> None:
        self._start, self._length = start[0], stop[0] - start[0]
        self._rounds, self._done = rounds, 0
        self._bar = ProgressBar("events")

    def reached(self, seconds: Pair) -> None:
        """Draw: the current round is complete up to this time."""
        if self._length > 0.0:
            share = (seconds[0] - self._start) / self._length
            self._bar(self._done + share, self._rounds)

    def next_round(self) -> None:
        """The next round begins."""
        self._done += 1

    def end(self) -> None:
        """Complete the bar: a search may end before the last of its span."""
        self._bar(self._rounds, self._rounds)


# ---- Zeros within brackets, many at once, to the resolution of a double of time

_MOST_STEPS = 120


def refined(
    evaluate: Callable[[FloatArray, IntArray], FloatArray],
    a: FloatArray,
    b: FloatArray,
    p: FloatArray,
    q: FloatArray,
) -> FloatArray:
    """The zeros (N,) of functions in brackets a, b with values p, q of opposite sign, (N,) each.

    evaluate: values (K,) at times (K,) within the brackets of numbers (K,).
    Chandrupatla's method (Adv. Eng. Softw. 28, 145, 1997): each step is one call for all brackets.
    """
    x = np.where(np.abs(p) < np.abs(q), a, b)
    open_ = np.flatnonzero((p != 0.0) & (q != 0.0))
    x[p == 0.0] = a[p == 0.0]
    # x1 and x2 are the ends of the brackets, x1 the newer of them; x3 is the end
    # that the last step replaced.
    x1, x2, f1, f2 = a[open_], b[open_], p[open_], q[open_]
    fraction = np.clip(f1 / (f1 - f2), 0.001, 0.999)
    for _ in range(_MOST_STEPS):
        if not len(open_):
            break
        new = x1 + fraction * (x2 - x1)
        value = evaluate(new, open_)
        same = (value < 0.0) == (f1 < 0.0)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = new, value
        nearer = np.abs(f1) < np.abs(f2)
        x[open_] = np.where(nearer, x1, x2)
        width = np.abs(x2 - x1)
        tolerance = 2.0 * np.spacing(np.maximum(np.abs(x1), np.abs(x2)))
        done = (width <= tolerance) | (f1 == 0.0)
        keep = ~done
        open_ = open_[keep]
        x1, x2, x3, f1, f2, f3 = (array[keep] for array in (x1, x2, x3, f1, f2, f3))
        fraction = _next(x1, x2, x3, f1, f2, f3)
        edge = 0.5 * tolerance[keep] / width[keep]
        fraction = np.clip(fraction, edge, 1.0 - edge)
    return x


def _next(x1, x2, x3, f1, f2, f3):
    """The next point, as a fraction of the way from x1 (0) to x2 (1)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        xi = (x1 - x2) / (x3 - x2)
        phi = (f1 - f2) / (f3 - f2)
        trusted = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        alpha = (x3 - x1) / (x2 - x1)
        inverse = f1 / (f1 - f2) * f3 / (f3 - f2) - alpha * f1 / (f3 - f1) * f2 / (f2 - f3)
    return np.where(trusted & np.isfinite(inverse), inverse, 0.5)


# ---- Upper bounds of the derivatives of body-fixed directions over the parts of a search
# For a free rotation and for each arc of a chain the bounds are proven (`Motion.rate_bounds`); for
# other motions they are estimated from samples.

# Samples 0.25 rad apart show the largest rate of a smooth motion to a few percent.
_MARGIN = 1.25


class Bounded:
    """Bounds that hold at any time of a part; knots begin `spacing` rad apart, the fastest."""

    spacing: Final = 0.8

    def __init__(self, bounds: RateBounds) -> None:
        self.bounds = bounds

    def guess(self, source: Source, base: Pair) -> float:
        """The bound of the rate, rad/s."""
        return self.bounds.first

    def of(self, moment: Moment) -> RateBounds:
        """The bounds for a block of epochs."""
        return self.bounds


class Sampled:
    """Estimates for a motion without bounds: the largest samples of a block times 1.25.

    They prove nothing; a motion that is not smooth has no bound of its second derivative.
    """

    spacing: Final = 0.25

    def __init__(self, smooth: bool) -> None:
        self.smooth = smooth

    def guess(self, source: Source, base: Pair) -> float:
        """The rate at an epoch, rad/s."""
        moment = source.at(np.array([base[0]]), np.array([base[1]]))
        return _length(moment.history.angular_velocity)

    def of(self, moment: Moment) -> RateBounds:
        """The estimates for a block of epochs; inf for derivatives that are unknown."""
        w = _MARGIN * _length(moment.history.angular_velocity)
        if not self.smooth:
            return RateBounds(w, np.inf, np.inf)
        rate = _MARGIN * _length(moment.history.angular_acceleration)
        return RateBounds(w, rate + w * w, np.inf)


def pieces(source: Source, start: Pair, stop: Pair) -> list[tuple[Pair, Pair, Bounded | Sampled]]:
    """The parts (start, stop) of a span, pairs of seconds, with the bounds that hold in each.

    Each arc is a part. In a scene a joint is seen a light time later: the fastest arc bounds all.
    """
    motion = source.turning
    joints = motion.joints
    if motion.rate_bounds(start[0]) is None:
        return [(start, stop, Sampled(motion.smooth))]
    if not len(joints):
        return [(start, stop, Bounded(_bounds_at(motion, start[0])))]
    if source.scene is not None:
        in_each_arc = [joints[0] - 1.0, *joints]
        fastest = max(_bounds_at(motion, float(t)).first for t in in_each_arc)
        return [(start, stop, Bounded(RateBounds(fastest, np.inf, np.inf)))]
    inside = [(float(t), 0.0) for t in joints]
    inside = [t for t in inside if difference(start, t) > 0.0 and difference(t, stop) > 0.0]
    ends = [start, *inside, stop]
    return [(a, b, Bounded(_bounds_at(motion, a[0]))) for a, b in pairwise(ends)]


def _bounds_at(motion: Motion, seconds: float) -> RateBounds:
    bounds = motion.rate_bounds(seconds)
    assert bounds is not None  # a motion has bounds everywhere or nowhere
    return bounds


def _length(vectors: FloatArray) -> float:
    """The largest length of vectors (N, 3)."""
    largest = float(np.max(lengths(np.asarray(vectors))))
    if not np.isfinite(largest):
        raise AttitudeError(
            "the motion has no finite angular velocity at some epoch of the search; give a span in "
            "which it is known."
        )
    return largest


# Pairs of crossings nearer to each other than this, in rad of the fastest rotation, may be missed.
TOUCH: Final = 1e-6
# The directions of a scene jump by up to 4e-10 rad where its Chebyshev pieces meet: pairs of
# crossings nearer to each other than this (a chord 1e-9 rad deep) look like a touch.
SCENE_TOUCH: Final = 1e-4
# Rounding error of a channel in a scene, over that of the channel alone.
_SCENE_NOISE = 2.5e6
# Largest and least number of intervals between the first knots of a block.
BLOCK: Final = 16384
_LEAST = 32
_PARTS = 4
# The attitudes of a scene are those at emission, whose epochs run faster than those of reception by
# up to v/c.  This factor covers the third power of 1 + v/c, and the growth of the Sun's disc.
_DOPPLER = 1.01


def crossings(
    source: Source,
    channels: Sequence[Channel],
    start: Pair,
    stop: Pair,
    advance: Advance | None = None,
) -> Iterator[tuple[FloatArray, FloatArray, IntArray, BoolArray]]:
    """The sign changes of channels, block by block in order of time."""
    progress = Advance(start, stop) if advance is None else advance
    for base, moment, knots, bounds in _blocks(source, channels, start, stop):
        progress.reached(base)
        values = np.stack([channel.value(moment) for channel in channels])
        if not np.all(np.isfinite(values)):
            raise AttitudeError(
                "an attitude or a direction is not finite within the search; give a span in which "
                "all of them are known."
            )
        zeros = []
        in_scene = source.scene is not None
        touch = SCENE_TOUCH if in_scene else TOUCH
        for k, channel in enumerate(channels):
            first, second, fastest = bounds[k]

            def evaluate(s, channel=channel, base=base):
                return channel.value(source.at(*shifted(base, s)))

            noise = channel.noise * (_SCENE_NOISE if in_scene else 1.0)
            brackets = isolated(evaluate, knots, values[k], first, second, touch / fastest, noise)
            s = refined(lambda s, _: evaluate(s), *brackets)
            zeros.append((s, np.full(len(s), k), brackets[2] < 0.0))
        s, which, rising = (np.concatenate(column) for column in zip(*zeros, strict=True))
        if len(s):
            order = np.argsort(s, kind="stable")
            yield *shifted(base, s[order]), which[order], rising[order]
    if advance is None:
        progress.end()


def _blocks(source, channels, start, stop):
    """Blocks of knots: base pair, Moment, knots in seconds from the base, bounds of each channel.

    The bounds are those of the first two derivatives, then that of the rate of all that turns.
    """
    directions = list(dict.fromkeys(d for channel in channels for d in channel.directions))
    total = difference(start, stop)
    drift = max((d.guess(source, start, total) for d in directions), default=0.0)
    for begin, end, limit in pieces(source, start, stop):
        base, rate = begin, limit.guess(source, begin) + drift
        while (remaining := difference(base, end)) > 0.0:
            needed = remaining * rate / limit.spacing
            count = int(min(BLOCK, max(_LEAST, np.ceil(needed)))) if rate > 0.0 else _LEAST
            last = needed <= BLOCK
            length = remaining if last else BLOCK * (limit.spacing / rate)
            knots = np.arange(count + 1, dtype=np.float64) * (length / count)
            knots[-1] = length
            moment = source.at(*shifted(base, knots), step=length / count)
            rates = limit.of(moment)
            if source.scene is not None:
                rates = RateBounds(*(bound * _DOPPLER for bound in rates))
            drifts = {d: d.drift(moment) for d in directions}
            fastest = rates.first + max((d.first for d in drifts.values()), default=0.0)
            if fastest > 2.0 * rate and fastest * length / count > limit.spacing:
                rate = fastest  # the guess was too slow: once more, with nearer knots
                continue
            if fastest > 0.0:
                bounds = [
                    (*channel.bounds(rates, [drifts[d] for d in channel.directions]), fastest)
                    for channel in channels
                ]
                yield base, moment, knots, bounds
            base = end if last else pairs.add(base, length)
            rate = fastest if fastest > 0.0 else rate


def isolated(
    evaluate: Callable[[FloatArray], FloatArray],
    knots: FloatArray,
    values: FloatArray,
    first: float,
    second: float,
    touch: float,
    noise: float,
) -> FloatArray:
    """Brackets of single sign changes between knots (M,): rows a, b, f(a), f(b) (4, N)."""
    a, b, p, q = knots[:-1], knots[1:], values[:-1], values[1:]
    brackets = []
    while len(a):
        h = b - a
        change = (p < 0.0) != (q < 0.0)
        open_ = ~_free_of_zeros(h, np.abs(p), np.abs(q), first, second, noise)
        single = change & ((np.abs(q - p) > 0.5 * second * h * h) | (h <= touch))
        brackets.append(np.stack([column[single] for column in (a, b, p, q)]))
        divisible = ~single & (h > touch) & (change | open_)
        a, b, p, q = _divided(evaluate, a[divisible], b[divisible], p[divisible], q[divisible])
    return np.concatenate(brackets, axis=1)


def _free_of_zeros(h, p, q, first, second, noise):
    """Whether no zero lies between two values with one sign and magnitudes p, q."""
    by_rate = p + q > first * h
    if not np.isfinite(second):
        return by_rate
    bend = 0.5 * second * h * h
    apart = np.abs(q - p)
    with np.errstate(divide="ignore", invalid="ignore"):
        dip = 0.5 * (p + q) - 0.25 * bend - 0.25 * apart * apart / bend
    least = np.where(apart >= bend, np.minimum(p, q), dip)
    return by_rate | (least > noise)


def _divided(evaluate, a, b, p, q):
    """The intervals, each divided into _PARTS: a, b, f(a), f(b), flat."""
    if not len(a):
        return a, b, p, q
    s = a + (b - a) * (np.arange(_PARTS + 1) / _PARTS)[:, None]
    s[-1] = b
    f = np.empty(s.shape)
    f[0], f[-1] = p, q
    f[1:-1] = evaluate(s[1:-1].reshape(-1)).reshape(_PARTS - 1, -1)
    return s[:-1].ravel(), s[1:].ravel(), f[:-1].ravel(), f[1:].ravel()


def shifted(base: Pair, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The pairs base + s, as arrays (N,)."""
    hi, lo = pairs.add(base, s)
    return hi, np.broadcast_to(lo, hi.shape) + 0.0


def difference(start: Pair, stop: Pair) -> float:
    """stop - start, rounded once."""
    hi, lo = pairs.add(stop, -start[0], -start[1])
    return float(hi + lo)
