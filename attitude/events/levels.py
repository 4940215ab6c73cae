"""The epochs at which observables pass thresholds: by bounds of derivatives, or by samples.

A threshold of a smooth observable is searched as the channels of axes are, between knots that are
its `spacing` apart and with bounds of its derivatives from the differences of the knots (1.5 times
the largest first, twice the largest second one), so that two changes between neighbouring knots are
found too; an observable with a stated `rate` is searched with that bound of its first derivative.
Others are divided between samples of different state: two changes within a spacing are missed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.events.root_finding import refined
from attitude.events.search import difference, isolated, shifted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from typing import TypeAlias

    from attitude.annotations import BoolArray, FloatArray, IntArray
    from attitude.conditions.channel import Level
    from attitude.conditions.moments import Pair, Source
    from attitude.events.advance import Advance

    # Seconds hi + lo (N,), number of the level (N,), and whether its sign changes to True (N,).
    Changes: TypeAlias = tuple[FloatArray, FloatArray, IntArray, BoolArray]

# Knots in a block.
_BLOCK = 4096
# Least part of a spacing into which an interval is divided: of a smooth observable, and of one with
# a stated rate, which costs more divisions and proves more.
_SMOOTH_PART, _RATED_PART = 2.0**-10, 2.0**-30
# Margins of bounds by differences, as those of directions (`attitude.conditions.moments`).
_MARGINS = (1.5, 2.0)
# Sections end at this part of the spacing, or at the resolution of a double.
_PARTS, _RESOLUTION = 16, 1e-9


def spacings(levels: Sequence[Level], start: Pair, stop: Pair) -> list[float]:
    """The times between samples of levels, s; levels of one spacing are sampled together."""
    return [level.observable.spacing(start, stop) for level in levels]


def changes(
    source: Source,
    levels: Sequence[Level],
    start: Pair,
    stop: Pair,
    spacing_of: Sequence[float],
    advance: Advance,
) -> Changes:
    """All sign changes of levels in a span, in order of time.

    Parameters
    ----------
    source : Source
    levels : sequence of Level
    start, stop : pairs of doubles
        TDB seconds since the epoch of the source.
    spacing_of : sequence of float
        Of `spacings`.
    advance : Advance
        Of the whole search; each spacing is a round.
    """
    found = []
    for spacing in sorted(set(spacing_of)):
        # Levels of one spacing are sampled together: a view computes each quantity once.
        some = [k for k, each in enumerate(spacing_of) if each == spacing]
        parts = _blocks(source, [levels[k] for k in some], start, stop, spacing, advance)
        found += [(hi, lo, np.asarray(some)[k], up) for hi, lo, k, up in parts]
        advance.next_round()
    if not found:
        return np.zeros(0), np.zeros(0), np.zeros(0, int), np.zeros(0, bool)
    hi, lo, number, rising = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.lexsort((lo, hi))
    return hi[order], lo[order], number[order], rising[order]


def _blocks(
    source: Source,
    levels: Sequence[Level],
    start: Pair,
    stop: Pair,
    spacing: float,
    advance: Advance,
) -> Iterator[Changes]:
    """The changes between knots one spacing apart, block by block."""
    base = start
    while (remaining := difference(base, stop)) > 0.0:
        advance.reached(base)
        count = int(min(_BLOCK, max(4, np.ceil(remaining / spacing))))
        last = count * spacing >= remaining
        length = remaining if last else count * spacing
        knots = np.arange(count + 1, dtype=np.float64) * (length / count)
        knots[-1] = length
        moment = source.at(*shifted(base, knots), step=length / count)
        for k, level in enumerate(levels):
            signs = level.sign(moment)
            values = np.asarray(level.value(moment), dtype=np.float64)
            s, rising = _in_block(source, level, base, knots, values, signs)
            yield *shifted(base, s), np.full(len(s), k), rising
        base = stop if last else pairs.add(base, length)


def _in_block(
    source: Source,
    level: Level,
    base: Pair,
    knots: FloatArray,
    values: FloatArray,
    signs: BoolArray,
) -> tuple[FloatArray, BoolArray]:
    """Seconds from the base (N,) of the changes of a level, and whether each is one to True."""
    observable = level.observable
    step = knots[1] - knots[0]
    if not (observable.is_smooth or observable.rate) or not np.all(np.isfinite(values)):
        return _sectioned(lambda s: level.sign(source.at(*shifted(base, s))), knots, signs)
    if observable.rate:
        first, second, part = observable.rate, np.inf, _RATED_PART
    else:
        slopes = np.diff(values) / step
        first = _MARGINS[0] * float(np.max(np.abs(slopes)))
        second = _MARGINS[1] * float(np.max(np.abs(np.diff(slopes)))) / step
        part = _SMOOTH_PART

    def evaluate(s: FloatArray) -> FloatArray:
        return level.value(source.at(*shifted(base, s)))

    noise = 1e-9 * (abs(level.threshold) + float(np.max(np.abs(values))))
    brackets = isolated(evaluate, knots, values, first, second, part * step, noise)
    s = refined(evaluate, *brackets)
    above = level.comparison.startswith(">")
    return s, (brackets[2] < 0.0) == above


def _sectioned(
    sign: Callable[[FloatArray], BoolArray], knots: FloatArray, signs: BoolArray
) -> tuple[FloatArray, BoolArray]:
    """The first change between samples of different sign, by sections of sixteen parts.

    A call for few epochs costs as much as one for hundreds.
    """
    k = np.flatnonzero(signs[1:] != signs[:-1])
    a, b, rising = knots[k], knots[k + 1], signs[k + 1]
    if not len(k):
        return a, rising
    width = _RESOLUTION * (knots[1] - knots[0])
    while np.max(b - a) > max(width, 16.0 * np.spacing(np.max(np.abs(b)))):
        points = a + (b - a) * (np.arange(_PARTS + 1) / _PARTS)[:, None]
        points[-1] = b
        new = np.empty(points.shape, dtype=bool)
        new[0], new[-1] = ~rising, rising
        new[1:-1] = sign(points[1:-1].reshape(-1)).reshape(_PARTS - 1, -1)
        first = np.argmax(new == rising, axis=0)
        every = np.arange(len(first))
        a, b = points[first - 1, every], points[first, every]
    return b, rising
