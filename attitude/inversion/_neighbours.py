"""Outliers, noise and correlation, from points that are close neighbours in time, and nights."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude._support.arrays import parted
from attitude._support.constants import DAY_S, GAP_OF_NIGHTS_S

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.inversion._problem import CurveProblem


# Standard deviations by which a point lies off its neighbours that is an outlier.
_OFF = 6.0
# The share of a turn, at the largest frequency, that a point and its neighbours span at most.
_CLOSE = 0.2
# Triples of neighbours from which noise is estimated at least.
_TRIPLES = 20
# The standard deviation of a normal distribution over the median of its absolute deviations.
_NORMAL = 1.4826
# Relative error of a night's noise times the root of its triples, which share points, thrice.
_BY_CHANCE = 4.5
# The least noise of magnitudes over their errors, 0.001 mag where these are assumed: equal ones
# show none.
_LEAST_NOISE = 0.05
# The largest share of the points of a survey that lie between close neighbours: half of those of
# four in an hour do.
_BETWEEN = 0.5
# Gap of the epochs, s, between two apparitions.
_APPARITION = 60.0 * DAY_S


def off_neighbours(
    problem: CurveProblem, values: FloatArray, turns: float
) -> tuple[FloatArray, FloatArray]:
    """How far values (N,) lie off the line through both neighbours, and the errors (N,) of that.

    Neighbours are of one session and filter: others have zero points of their own.  NaN where the
    three span more than `_CLOSE` of a turn; `turns` per span.
    """
    off, error = np.full(len(values), np.nan), np.full(len(values), np.nan)
    order = np.lexsort((problem.t, problem.series))
    t, series, values = problem.t[order], problem.series[order], values[order]
    variance = problem.sigma[order] ** 2
    length = t[2:] - t[:-2]
    close = (length * turns < _CLOSE) & (length > 0.0) & (series[2:] == series[:-2])
    share = np.where(close, (t[1:-1] - t[:-2]) / np.where(close, length, 1.0), 0.5)
    line = (1.0 - share) * values[:-2] + share * values[2:]
    spread = variance[1:-1] + (1.0 - share) ** 2 * variance[:-2] + share**2 * variance[2:]
    off[order[1:-1]] = np.where(close, values[1:-1] - line, np.nan)
    error[order[1:-1]] = np.where(close, np.sqrt(spread), np.nan)
    return off, error


def are_close(problem: CurveProblem, turns: float) -> BoolArray:
    """Which points (N,) are among three close neighbours; `turns` per span."""
    order = np.lexsort((problem.t, problem.series))
    is_between = np.isfinite(off_neighbours(problem, problem.y, turns)[0])[order]
    close = is_between.copy()
    close[:-1] |= is_between[1:]
    close[1:] |= is_between[:-1]
    out = np.empty_like(close)
    out[order] = close
    return out


def without_outliers(problem: CurveProblem, turns: float) -> tuple[CurveProblem, int]:
    """The problem in which points far off both neighbours hardly count, and how many they are.

    Their errors become as large as they are off.  The worst goes first, since its neighbours lie
    off it too.
    """
    sigma, values = problem.sigma.copy(), problem.y.copy()
    count = 0
    while True:
        off, error = off_neighbours(problem, values, turns)
        scaled = np.abs(off / error)
        known = np.isfinite(scaled)
        if np.count_nonzero(known) < _TRIPLES:
            break
        scaled = np.where(known, scaled, 0.0)
        worst = int(np.argmax(scaled))
        if scaled[worst] < _OFF * max(1.0, _NORMAL * float(np.median(scaled[known]))):
            break
        sigma[worst] = max(abs(float(off[worst])), sigma[worst])
        # as its neighbours have it
        values[worst] -= off[worst]
        count = int(np.count_nonzero(sigma != problem.sigma))
        if count > len(problem) // 10:
            return problem, 0
    return (problem.with_errors(sigma) if count else problem), count


def noise(problem: CurveProblem, residual: FloatArray, turns: float) -> FloatArray:
    """By what factors (N,) neighbouring residuals (N,) differ more than the errors say; at least 1.

    That of all points, and of a night where its own is larger by more than chance.
    """
    scaled, whole = _beside_errors(problem, residual, turns)
    whole = 1.0 if math.isnan(whole) else max(1.0, whole)
    factors = np.full(len(problem), whole)
    for night in nights_of(problem.seconds):
        values_of_night = scaled[night][np.isfinite(scaled[night])]
        if len(values_of_night) >= _TRIPLES:
            factor = _NORMAL * float(np.median(values_of_night))
            if factor > whole * (1.0 + _BY_CHANCE / np.sqrt(len(values_of_night))):
                factors[night] = factor
    return factors


def scatter(problem: CurveProblem, residual: FloatArray, turns: float) -> FloatArray:
    """By what factors (N,) residuals (N,) exceed the errors in sessions without close neighbours.

    Nothing else says how noisy the points of a survey are.  All are 1, unless the residuals of
    the other sessions are as small as the errors.
    """
    factors, is_sparse = np.ones(len(problem)), np.zeros(len(problem), bool)
    settings = problem.settings
    is_between = np.isfinite(off_neighbours(problem, residual, turns)[0])
    squares = residual**2 / (problem.sigma**2 + settings.floor_error**2)
    for number in np.unique(problem.series):
        session = problem.series == number
        if np.mean(is_between[session]) <= _BETWEEN:
            is_sparse |= session
            if np.count_nonzero(session) >= _TRIPLES:
                factors[session] = math.sqrt(max(1.0, trimmed(squares[session], settings.worst)))
    others = squares[~is_sparse]
    is_explained = len(others) >= _TRIPLES and trimmed(others, settings.worst) < settings.floor
    return factors if is_explained else np.ones(len(problem))


def trimmed(squares: FloatArray, worst: float) -> float:
    """The mean of the squares (N,) without the largest share of them."""
    return float(np.mean(np.sort(squares)[: max(1, int((1.0 - worst) * len(squares)))]))


def _beside_errors(
    problem: CurveProblem, values: FloatArray, turns: float
) -> tuple[FloatArray, float]:
    """How far values (N,) lie off their neighbours over the errors of that, and a robust mean.

    NaN where neighbours are not close; the mean is NaN of few.
    """
    off, error = off_neighbours(problem, values, turns)
    scaled = np.abs(off / error)
    known = scaled[np.isfinite(scaled)]
    return scaled, _NORMAL * float(np.median(known)) if len(known) >= _TRIPLES else math.nan


def common_share(problem: CurveProblem, residual: FloatArray, turns: float) -> float:
    """The share of the variance of residuals (N,) that close neighbours have in common, or 0."""
    scaled, apart = _beside_errors(problem, residual, turns)
    if math.isnan(apart):
        return 0.0
    known = np.isfinite(scaled)
    whole = _NORMAL * float(np.median(np.abs(residual[known]) / problem.sigma[known]))
    return 1.0 - (apart / whole) ** 2 if whole > apart else 0.0


def too_large(problem: CurveProblem) -> float:
    """By what factor the errors are larger than neighbouring magnitudes of a night show.

    1 where chance may do it.  Variation between neighbours counts as noise.  By a mean square: of
    magnitudes that are rounded to more than their noise the median difference is zero.
    """
    scaled, apart = _beside_errors(problem, problem.y, _CLOSE * problem.span / GAP_OF_NIGHTS_S)
    if math.isnan(apart):
        return 1.0
    known = scaled[np.isfinite(scaled)]
    factor = 1.0 / max(math.sqrt(float(np.mean(known**2))), _LEAST_NOISE)
    return factor if factor > 1.0 + _BY_CHANCE / math.sqrt(len(known)) else 1.0


def nights_of(seconds: FloatArray) -> list[IntArray]:
    """Numbers of the epochs (T,) of each night, in time order."""
    return parted(seconds, GAP_OF_NIGHTS_S)


def apparitions_of(seconds: FloatArray) -> list[IntArray]:
    """Numbers of the epochs (T,) of each apparition, ascending."""
    return [np.sort(numbers) for numbers in parted(seconds, _APPARITION)]
