"""Ellipsoids from many starts: for given rates, random orientations, phases and shapes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.inversion import many_starts
from attitude.inversion.lattices import Candidate

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray
    from attitude.inversion.problem import CurveProblem

# ln rho of rotation about an axis, which is then fixed with f, the phase and X.
AXIAL = -20.0
AXIAL_FIXED = np.array([False, False, False, False, True, True, True, True, False, False])
_FREE = np.zeros(10, bool)
# Ratios of axes, rho and X of the starts; X in long- and in short-axis mode.
_AXES, _RHO, _X = (1.1, 3.0), (0.08, 0.9), (0.3, 0.65)
# Standard deviation of the logarithms of squared ratios of axes.
_RATIOS = 1.5


class Held(NamedTuple):
    """Standard deviation of the logarithms of the moments of the motion, and from which moments.

    From those of the ellipsoid, or from those given, of which moments has the logarithms,
    ascending.
    """

    width: float = math.inf
    moments: tuple[float, float, float] = (math.nan, math.nan, math.nan)


_FREELY = Held()
# Starts about a pole, each the best of so many random ones.
_AROUND, _SCREENS = 8, 8
# Relative difference of costs of two minima.
_DISTINCT = 1e-3


class Pool(NamedTuple):
    """States (S, 16) of `many_starts`, the best first, and their costs (S,)."""

    cost: FloatArray
    states: FloatArray


def rotations(generator: np.random.Generator, count: int) -> FloatArray:
    """Uniformly random rotation matrices (count, 9)."""
    q = generator.standard_normal((count, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1)[:, None]).T
    rows = (
        *(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack(rows, axis=-1)


def starts(
    generator: np.random.Generator, precession: FloatArray, nutation: FloatArray
) -> FloatArray:
    """A random start (S, 16) for each pair of rates (S,), turns per span."""
    count = len(precession)
    x = np.empty((count, many_starts.WIDTH))
    long_axis = nutation > 0.0
    x[:, 0], x[:, 1] = precession, nutation
    x[:, 2] = generator.random(count)
    x[:, 3] = np.log(generator.uniform(*_RHO, count))
    x[:, 4] = generator.random(count) * np.where(long_axis, *_X)
    x[:, 5:14] = rotations(generator, count)
    ratios = np.sort(generator.uniform(*_AXES, (count, 2)), axis=1)
    ratios = np.concatenate([np.ones((count, 1)), ratios], axis=1)
    axes = np.where(long_axis[:, None], ratios, ratios[:, ::-1])
    flat = -2.0 * np.log(axes)
    x[:, 14:] = flat[:, :2] - flat[:, 2:]
    return x


def minimised(
    problem: CurveProblem,
    states: FloatArray,
    iterations: int,
    *,
    tie: Held = _FREELY,
    fixed: BoolArray = _FREE,
    gain: float = 1e-4,
) -> Pool:
    """The states after an iteration from each, in their order."""
    priors = many_starts.Priors(_RATIOS, tie.width, tie.moments)
    return Pool(*many_starts.minimise(problem, states, fixed, priors, iterations, gain))


def screened(problem: CurveProblem, states: FloatArray, groups: int) -> FloatArray:
    """The best state (groups, 16) of each of so many equal groups."""
    cost = many_starts.costs(problem, states)
    size = len(states) // groups
    best = np.argmin(np.where(np.isfinite(cost), cost, np.inf).reshape(groups, size), axis=1)
    return states[best + size * np.arange(groups)]


def around(
    problem: CurveProblem,
    generator: np.random.Generator,
    rates: list[Candidate],
    count: int,
    *,
    screens: int = 8,
    iterations: int = 8,
    tie: Held = _FREELY,
) -> Pool:
    """Minima from `count` random starts for each pair of rates, in the order of the rates.

    Each start is the best of `screens` random ones.
    """
    each = np.repeat(np.array(rates), count * screens, axis=0)
    given = starts(generator, each[:, 0], each[:, 1])
    chosen = screened(problem, given, len(rates) * count)
    return minimised(problem, chosen, iterations, tie=tie)


def best_of_each(pool: Pool, groups: int) -> Pool:
    """The best state of each of so many equal groups."""
    size = len(pool.cost) // groups
    at = np.argmin(pool.cost.reshape(groups, size), axis=1) + size * np.arange(groups)
    return Pool(pool.cost[at], pool.states[at])


def in_order(*pools: Pool) -> Pool:
    """All states of pools, the best first."""
    cost = np.concatenate([each.cost for each in pools])
    states = np.concatenate([each.states for each in pools])
    order = np.argsort(cost, kind="stable")
    order = order[np.isfinite(cost[order])]
    return Pool(cost[order], states[order])


def axial(
    problem: CurveProblem, generator: np.random.Generator, rates: FloatArray, count: int
) -> Pool:
    """Rotations about one axis at rates (turns per span), from `count` starts for each."""
    each = np.repeat(rates, count * 8)
    given = starts(generator, 0.5 * each, -np.ones(len(each)))
    given[:, 2], given[:, 3], given[:, 4] = 0.0, AXIAL, 0.0
    chosen = screened(problem, given, len(rates) * count)
    return minimised(problem, chosen, 30, fixed=AXIAL_FIXED)


def axial_at_poles(
    problem: CurveProblem,
    generator: np.random.Generator,
    rates: FloatArray,
    poles: FloatArray,
    keep: int,
) -> Pool:
    """Rotations at rates (P,), turns per span, about directions (P, 3), which stay.

    `keep` for each, the best of some starts, in the order of the poles.
    """
    count, size = len(poles), _AROUND * _SCREENS
    each = np.repeat(0.5 * rates, size)
    given = starts(generator, each, -np.ones(len(each)))
    given[:, 2], given[:, 3], given[:, 4] = 0.0, AXIAL, 0.0
    third = np.repeat(poles, size, axis=0)
    first = np.cross(third, generator.standard_normal(third.shape))
    first /= np.linalg.norm(first, axis=1)[:, None]
    turns = np.stack([first, np.cross(third, first), third], axis=-1)
    given[:, 5:14] = turns.reshape(-1, 9)
    chosen = screened(problem, given, count * _AROUND)
    fixed = AXIAL_FIXED.copy()
    fixed[:2] = True
    pool = minimised(problem, chosen, 20, fixed=fixed)
    costs = pool.cost.reshape(count, _AROUND)
    at = np.argsort(costs, axis=1, kind="stable")
    ordered = np.take_along_axis(costs, at, axis=1)
    # starts that end at one minimum count once
    new = np.diff(ordered, axis=1, prepend=-np.inf) > _DISTINCT * np.abs(ordered)
    rank = np.where(new & np.isfinite(ordered), np.cumsum(new, axis=1), keep + 1)
    row, column = np.nonzero(rank <= keep)
    chosen_at = row * _AROUND + at[row, column]
    return Pool(pool.cost[chosen_at], pool.states[chosen_at])


def rates_of(pool: Pool, keep: int) -> list[Candidate]:
    """The rates of the best states, without repetition."""
    rates: list[Candidate] = []
    for state in pool.states:
        here = Candidate(float(state[0]), float(state[1]))
        if not any(
            2.0 * abs(here.precession - each.precession) < 0.4
            and abs(here.nutation - each.nutation) < 0.4
            for each in rates
        ):
            rates.append(here)
            if len(rates) >= keep:
                break
    return rates
