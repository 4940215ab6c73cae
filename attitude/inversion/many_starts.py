"""Levenberg and Marquardt's iteration from many starts, for the ellipsoid.

A start is a row of 16 numbers: five elements, the orientation (9) of the axes along the momentum,
and two logarithms of squared ratios of axes, ln (c/a)^2 and ln (c/b)^2.  Terms in which the
magnitude is linear are projected out of each residual and derivative.

Magnitudes and derivatives are compiled; the steps of all starts are arrays of numpy, of which
nothing has to be compiled.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.inversion.ellipsoid_magnitudes import PARAMETERS, EllipsoidCurve
from attitude.inversion.moments_of_elements import moments, with_slopes

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray
    from attitude.inversion.problem import CurveProblem

# Entries of a start, and of those the elements that the moments follow from.
WIDTH = 16
OF_MOMENTS = [0, 1, 3, 4]
# Bounds of ln rho, X and of the logarithms of the shape.
LEAST_RHO, MOST_RHO, LEAST_X, MOST_X, MOST_RATIO = -8.0, -0.01, -0.3, 0.95, 6.0
# Longest step: rad of orientation, turns of phase, ln rho, X, logarithms of the shape.
_LONGEST = 0.6
# Damping at the start, and that at which no step lowers the sum of squares.
_DAMPING, _STUCK = 1e-2, 1e8


class Priors(NamedTuple):
    """What is known of shape and motion beside the curve.

    Standard deviations of the logarithms of the shape, ratios, and of those of the moments of the
    motion from the moments of the ellipsoid, tie, or from those given: their logarithms, ascending,
    or NaN.
    """

    ratios: float
    tie: float
    given: tuple[float, float, float]


class _Near(NamedTuple):
    """Sums of squares (S,), half their second derivatives, and minus half their first ones."""

    cost: FloatArray
    normal: FloatArray
    gradient: FloatArray


def are_allowed(states: FloatArray, is_axial: bool) -> BoolArray:
    """Which of the states (..., 16 or more) are within the bounds."""
    found = np.all(np.abs(states[..., 14:16]) < MOST_RATIO, axis=-1)
    if not is_axial:
        log_rho, x = states[..., 3], states[..., 4]
        found &= (x > LEAST_X) & (x < MOST_X) & (log_rho > LEAST_RHO) & (log_rho < MOST_RHO)
    return np.asarray(found)


def moved(states: FloatArray, steps: FloatArray) -> FloatArray:
    """States (..., W) after steps (..., 10 or more): orientations are turned about their own axes.

    What a state has beyond the 16 numbers stays.
    """
    angle = np.sqrt(np.sum(steps[..., :3] ** 2, axis=-1))
    half = 0.5 * angle
    w, s = np.cos(half), 0.5 * np.sinc(half / math.pi)
    p, q, r = (s * steps[..., k] for k in range(3))
    turn = np.empty((*w.shape, 3, 3))
    turn[..., 0, 0], turn[..., 0, 1] = 1.0 - 2.0 * (q * q + r * r), 2.0 * (p * q - w * r)
    turn[..., 0, 2], turn[..., 1, 0] = 2.0 * (p * r + w * q), 2.0 * (p * q + w * r)
    turn[..., 1, 1], turn[..., 1, 2] = 1.0 - 2.0 * (p * p + r * r), 2.0 * (q * r - w * p)
    turn[..., 2, 0], turn[..., 2, 1] = 2.0 * (p * r - w * q), 2.0 * (q * r + w * p)
    turn[..., 2, 2] = 1.0 - 2.0 * (p * p + q * q)
    new = states.copy()
    new[..., :5] += steps[..., 3:8]
    new[..., 5:14] = (states[..., 5:14].reshape(turn.shape) @ turn).reshape(*w.shape, 9)
    new[..., 14:16] += steps[..., 8:10]
    return new


def _steps(near: _Near, fixed: BoolArray, damping: FloatArray) -> FloatArray:
    """The damped steps (S, 10), scaled by the diagonal, of limited length."""
    diagonal = np.arange(PARAMETERS)
    scale = np.sqrt(near.normal[:, diagonal, diagonal]) + 1e-12
    scaled = near.normal / (scale[:, :, None] * scale[:, None, :])
    scaled[:, fixed, :] = scaled[:, :, fixed] = 0.0
    scaled[:, diagonal, diagonal] += np.where(fixed, 1.0, damping[:, None] + 1e-13)
    wanted = np.where(fixed, 0.0, near.gradient / scale)
    step: FloatArray = np.linalg.solve(scaled, wanted[:, :, None])[:, :, 0] / scale
    size = np.abs(step[:, 5:]) * (6.0, 2.0, 4.0, 1.0, 1.0)
    longest = np.maximum(np.sqrt(np.sum(step[:, :3] ** 2, axis=1)), size.max(axis=1))
    return step * (_LONGEST / np.maximum(longest, _LONGEST))[:, None]


def _wanted(states: FloatArray, priors: Priors) -> FloatArray:
    """Logarithms (2, S) of I1/I3 and I2/I3 of the ellipsoids, or of the moments given."""
    if math.isnan(priors.given[0]):
        a, b = np.exp(-states[:, 14:16]).T
        return np.log([(b + 1.0) / (a + b), (a + 1.0) / (a + b)])
    # the third axis is the long one in long-axis mode; X < 0 exchanges the first two
    low, middle, high = priors.given
    is_long = states[:, 1] > 0.0
    third, first = np.where(is_long, low, high), np.where(is_long, high, low)
    both = np.array([first, np.full(len(states), middle)]) - third
    return np.where(states[:, 4] >= 0.0, both, both[::-1])


def _tied(states: FloatArray, priors: Priors) -> tuple[FloatArray, FloatArray]:
    """Differences of the logarithms of the moments of the motions from those wanted, over the tie.

    An array (S, 2), and its derivatives (S, 2, 10) by the parameters.
    """
    ratios, slopes = with_slopes(states[:, OF_MOMENTS].T)
    rows = np.zeros((len(states), 2, PARAMETERS))
    rows[:, :, [3, 4, 6, 7]] = slopes.T
    if math.isnan(priors.given[0]):
        a, b = np.exp(-states[:, 14:16]).T
        rows[:, 0, 8], rows[:, 0, 9] = -a / (a + b), b / (b + 1.0) - b / (a + b)
        rows[:, 1, 8], rows[:, 1, 9] = a / (a + 1.0) - a / (a + b), -b / (a + b)
    return (ratios - _wanted(states, priors)).T / priors.tie, rows / priors.tie


def _cost(curve: EllipsoidCurve, states: FloatArray, priors: Priors) -> FloatArray:
    """The sums of squares (S,) of states, with those of the priors."""
    found = curve.costs(states) + _bend(priors) * np.sum(states[:, 14:16] ** 2, axis=1)
    if priors.tie < math.inf:
        ratios = moments(states[:, OF_MOMENTS].T).log_ratios
        found += np.sum((ratios - _wanted(states, priors)) ** 2, axis=0) / priors.tie**2
    return found


def _bend(priors: Priors) -> float:
    """Inverse variance of the logarithms of the shape."""
    return 1.0 / priors.ratios**2


def _linearised(curve: EllipsoidCurve, states: FloatArray, priors: Priors) -> _Near:
    """The sums of squares near states, with those of the priors."""
    products = curve.products(states)
    cost, normal, gradient = products[:, 0, 0], products[:, 1:, 1:], products[:, 1:, 0]
    shape = states[:, 14:16]
    cost += _bend(priors) * np.sum(shape**2, axis=1)
    normal[:, [8, 9], [8, 9]] += _bend(priors)
    gradient[:, 8:] -= _bend(priors) * shape
    if priors.tie < math.inf:
        tied, rows = _tied(states, priors)
        cost += np.sum(tied**2, axis=1)
        normal += rows.swapaxes(1, 2) @ rows
        gradient -= (tied[:, None, :] @ rows)[:, 0]
    return _Near(cost, normal, gradient)


def minimise(
    problem: CurveProblem,
    starts: FloatArray,
    fixed: BoolArray,
    priors: Priors,
    iterations: int,
    tolerance: float,
) -> tuple[FloatArray, FloatArray]:
    """The least sums of squares (S,) near starts (S, 16), and where they lie.

    Parameters
    ----------
    problem : CurveProblem
    starts : (S, 16) array
    fixed : (10,) array of bool
        Parameters that stay.
    priors : Priors
    iterations : int
    tolerance : float
        Relative gain that ends an iteration.
    """
    curve = EllipsoidCurve(problem)
    states, count = starts.copy(), len(starts)
    best, damping = np.full(count, np.inf), np.full(count, _DAMPING)
    normal, gradient = np.empty((count, PARAMETERS, PARAMETERS)), np.empty((count, PARAMETERS))
    # the starts that go on, and where they try next
    on, new = np.arange(count), starts
    for iteration in range(iterations):
        allowed = are_allowed(new, bool(fixed[6]))
        cost = np.full(len(on), np.inf)
        if iteration == iterations - 1:
            cost[allowed] = _cost(curve, new[allowed], priors)
            better = cost < best[on]
            best[on[better]], states[on[better]] = cost[better], new[better]
            break
        near = _linearised(curve, new[allowed], priors)
        cost[allowed] = near.cost
        better = cost < best[on]
        with np.errstate(invalid="ignore"):
            gain = best[on] - cost
        won, kept = on[better], better[allowed]
        best[won], states[won] = cost[better], new[better]
        normal[won], gradient[won] = near.normal[kept], near.gradient[kept]
        damping[on] *= 4.0
        damping[won] = np.maximum(0.075 * damping[won], 1e-9)
        ended = better & (iteration > 3) & (gain < tolerance * best[on])
        ended |= ~better & (damping[on] > _STUCK) | np.isinf(best[on])
        on = on[~ended]
        if not on.size:
            break
        here = _Near(best[on], normal[on], gradient[on])
        new = moved(states[on], _steps(here, fixed, damping[on]))
    return best, states


def costs(problem: CurveProblem, starts: FloatArray) -> FloatArray:
    """The sum of squares (S,) of each start (S, 16)."""
    return EllipsoidCurve(problem).costs(starts)
