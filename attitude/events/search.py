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

from typing import TYPE_CHECKING, Final

import numpy as np

from attitude import pairs
from attitude.errors import AttitudeError
from attitude.events.advance import Advance
from attitude.events.rate_bounds import pieces
from attitude.events.root_finding import refined
from attitude.motion import RateBounds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from attitude.annotations import BoolArray, FloatArray, IntArray
    from attitude.conditions.channel import Channel
    from attitude.conditions.moments import Moment, Pair, Source

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
    """The sign changes of channels, block by block in order of time.

    Parameters
    ----------
    source : Source
    channels : sequence of Channel
    start, stop : pairs of doubles
        TDB seconds since the epoch of the source.
    advance : Advance, optional
        Of the search of which this span is a part; by default the span has a bar of its own.

    Yields
    ------
    hi, lo : (N,) arrays
        Seconds of the sign changes, in order.
    channel : (N,) array of int
        Index of the channel.
    rising : (N,) array of bool
        Whether the sign changes to positive.

    Raises
    ------
    AttitudeError
        If a value is not finite.
    """
    own = Advance(start, stop) if advance is None else advance
    for base, moment, knots, bounds in blocks(source, channels, start, stop):
        own.reached(base)
        values = np.stack([channel.value(moment) for channel in channels])
        if not np.all(np.isfinite(values)):
            raise AttitudeError(
                "an attitude or a direction is not finite within the search; give a span in which "
                "all of them are known."
            )
        found = []
        in_scene = source.scene is not None
        touch = SCENE_TOUCH if in_scene else TOUCH
        for k, channel in enumerate(channels):
            first, second, fastest = bounds[k]

            def evaluate(
                s: FloatArray, channel: Channel = channel, base: Pair = base
            ) -> FloatArray:
                return channel.value(source.at(*shifted(base, s)))

            noise = channel.noise * (_SCENE_NOISE if in_scene else 1.0)
            brackets = isolated(evaluate, knots, values[k], first, second, touch / fastest, noise)
            s = refined(evaluate, *brackets)
            found.append((s, np.full(len(s), k), brackets[2] < 0.0))
        s, which, rising = (np.concatenate(part) for part in zip(*found, strict=True))
        if len(s):
            order = np.argsort(s, kind="stable")
            yield *shifted(base, s[order]), which[order], rising[order]
    if advance is None:
        own.end()


def blocks(
    source: Source, channels: Sequence[Channel], start: Pair, stop: Pair
) -> Iterator[tuple[Pair, Moment, FloatArray, list[tuple[float, float, float]]]]:
    """Blocks of knots: base pair, Moment, knots in seconds from the base, bounds of each channel.

    The knots are `limit.spacing` rad apart at the rate that bounds rotation and directions.  The
    bounds are those of the first two derivatives, then that rate.
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
                yield (
                    base,
                    moment,
                    knots,
                    [
                        (*channel.bounds(rates, [drifts[d] for d in channel.directions]), fastest)
                        for channel in channels
                    ],
                )
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
    """Brackets of single sign changes: rows a, b, f(a), f(b) (4, N), not in order.

    Parameters
    ----------
    evaluate : callable
        f, times (K,) to values (K,).
    knots, values : (M,) arrays
        Times in ascending order, and f there.
    first, second : float
        Upper bounds of |f'| and |f''|.
    touch : float
        Length of the shortest intervals.
    noise : float
        Rounding error of f.
    """
    a, b, p, q = knots[:-1], knots[1:], values[:-1], values[1:]
    found = []
    while len(a):
        h = b - a
        change = (p < 0.0) != (q < 0.0)
        open_ = ~_free_of_zeros(h, np.abs(p), np.abs(q), first, second, noise)
        single = change & ((np.abs(q - p) > 0.5 * second * h * h) | (h <= touch))
        found.append(np.stack([part[single] for part in (a, b, p, q)]))
        rest = ~single & (h > touch) & (change | open_)
        a, b, p, q = _divided(evaluate, a[rest], b[rest], p[rest], q[rest])
    return np.concatenate(found, axis=1)


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
