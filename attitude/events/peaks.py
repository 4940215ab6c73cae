"""Local maxima of a function from its values alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.errors import AttitudeError
from attitude.events.advance import Advance
from attitude.events.search import difference, shifted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray
    from attitude.conditions.moments import Pair

_BLOCK = 8192
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# Golden sections of a bracket, to 1e-9 of its length.
_SECTIONS = 44
# A smooth peak is refined as the zero of its derivative, by differences over this part of a step.
_STENCIL = 0.08
_WEIGHTS = np.array([-1.0 / 60.0, 0.15, -0.75, 0.0, 0.75, -0.15, 1.0 / 60.0])
_SIXTH = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
_SMOOTH = 1e-5
_PLACES = np.arange(-3, 4)


def peaks(
    f: Callable[[FloatArray, FloatArray], ArrayLike],
    start: Pair,
    stop: Pair,
    step: float,
    sign: float,
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """The maxima of sign * f between samples one step apart, block by block.

    Parameters
    ----------
    f : callable
        Returns values (N,) at seconds (hi, lo), arrays (N,).
    start, stop : pairs of doubles
        s.
    step : float
        s; shortened so that it divides the span.
    sign : 1.0 or -1.0

    Yields
    ------
    hi, lo : (N,) arrays
        Seconds of the maxima.
    values : (N,) array
        f there.

    Raises
    ------
    AttitudeError
        If f returns another shape.
    """
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
            found = sign * np.asarray(f(*shifted(base, s)), dtype=np.float64)
            if found.shape != s.shape:
                raise AttitudeError(
                    f"the function returns shape {found.shape} for {s.size} epochs; it must return "
                    "a number for each."
                )
            return found

        y = value(s)
        left, right = _tops(y)
        # Neighbouring blocks share three samples: a peak belongs to the block that holds the
        # last of its samples, unless that is the first sample of the block.
        own = (right + first >= 2) & (right + first <= size + 1)
        found = _refined(value, s[left[own]], s[right[own]], step)
        if len(found):
            yield *shifted(base, found), sign * value(found)
        base = pairs.add(base, size * step)
        done += size
        advance.reached(base)
    advance.end()


def _tops(y):
    """Indices (left, right) of the neighbours of each sample, or pair of equal samples, above both.

    NaN counts as -inf.  Three or more equal samples are a plateau, which has no maximum.
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
    h = _STENCIL * step
    inside = (x - 6.0 * h > left) & (x + 6.0 * h < right)
    y = x.copy()
    for _ in range(3):
        around = value((y + h * _PLACES[:, None]).reshape(-1)).reshape(7, -1)
        slope = _WEIGHTS @ around / h
        bend = (around[2] - 2.0 * around[3] + around[4]) / (h * h)
        with np.errstate(divide="ignore", invalid="ignore"):
            move = -slope / bend
        y = np.where(inside & (bend < 0.0) & (np.abs(move) < h), y + move, y)
    # The error of the formula is in sixth differences; where these are not small against the second
    # difference, the top is not smooth on this scale, and the result of the sections is kept.
    smooth = np.abs(_SIXTH @ around) < _SMOOTH * np.abs(bend) * h * h
    return np.where(inside & smooth, y, x)
