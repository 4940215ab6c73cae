"""The time in which errors of moments and rates grow to a tolerance of the attitude.

The errors that grow with time are those of two phases, whose rates are known to 31 digits: the
differences of these rates between inputs changed by their errors give the drift of the attitude,
without derivatives and without loss of digits by cancellation.  The errors of a covariance, which
may be correlated, are followed by the derivatives instead (`time_of_covariance`).
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import codes
from attitude._solver import covariance as covariances
from attitude._solver.regime import Mode, regime_of
from attitude._solver.states import Evaluation, States
from attitude._support import pairs, validation
from attitude._support.arrays import bisected
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._solver.regime import Regime
    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.motions._differentiable import Differentiable


# Periods beyond which attitudes are not computed to their last digits.
_MOST_PERIODS = 1e15
# Share of independent errors below which the sum of correlated ones is a rounding error.
_CANCELLED = 1e-12
_SAMPLES = 256  # in the interval in which the tolerance is reached
_PHASES = 64  # of one period, over which the largest error is taken


def predictable_time(
    moments: FloatArray,
    omega: FloatArray,
    *,
    moments_error: Reals = 0.0,
    rates_error: Reals = 0.0,
    tolerance: Real = 0.1,
) -> float:
    """Seconds until errors (3,) of moments and rates (3, 2) reach a tolerance of the attitude."""
    angle = validation.positive(tolerance, "tolerance", unit="rad")
    of_moments = _error(moments_error, "moments_error")
    of_rates = _error(rates_error, "rates_error")
    shifts = np.zeros((12, 2, 3))
    speed = math.hypot(*omega[:, 0])
    for k in range(3):
        for side, sign in enumerate((1.0, -1.0)):
            shifts[2 * k + side, 0, k] = sign * of_moments[k] * moments[k, 0]
            shifts[6 + 2 * k + side, 1, k] = sign * of_rates[k] * speed
    shifts = shifts[np.any(shifts != 0.0, axis=(1, 2))]
    if len(shifts) == 0:
        return math.inf
    state_given = np.stack([moments, omega])[None]
    shifted = pairs.add((state_given[..., 0], state_given[..., 1]), shifts)
    states = np.concatenate([state_given, np.stack(shifted, axis=-1)])
    constants = _constants(states, of_moments)
    middle = regime_of(states[:1, 0], constants[:1])
    changed = [regime_of(states[k : k + 1, 0], constants[k : k + 1]) for k in range(1, len(states))]
    return min(
        _drift_time(constants, middle, angle),
        *(_flip(middle, other) for other in changed),
    )


def time_of_covariance(motion: Differentiable, tolerance: Real) -> float:
    """Seconds until the largest standard deviation of the attitude reaches a tolerance."""
    angle = validation.positive(tolerance, "tolerance", unit="rad")

    def largest(seconds: FloatArray) -> FloatArray:
        variances = np.linalg.eigvalsh(motion._linear_covariance_at(seconds, None, False))[..., -1]
        return np.sqrt(np.maximum(variances, 0.0))

    if largest(np.zeros(1))[0] >= angle:
        return 0.0
    time = _first_time(largest, _time_scale(motion, angle), angle)
    if math.isfinite(time) and _is_rounding(motion, time, angle):
        return math.inf
    return min(time, flip_within_errors(motion))


def _time_scale(motion: Differentiable, angle: float) -> float:
    """The period of the errors, s; at rest the time in which a rate error turns by the angle."""
    speed = float(np.linalg.norm(motion.spin.angular_velocity))
    if speed == 0.0:
        covariance = motion.spin.covariance
        assert covariance is not None  # as the caller has found
        rate = float(np.sqrt(np.trace(covariance[3:6, 3:6])))
        return angle / rate if rate > 0.0 else 1.0
    period = motion.regime.P_psi
    return float(period) if np.isfinite(period) else 2.0 * math.pi / speed


def _first_time(largest: Callable[[FloatArray], FloatArray], period: float, angle: float) -> float:
    """The first time at which errors that grow in the mean over a period reach an angle, or inf."""
    start = period * np.linspace(0.0, 1.0, _SAMPLES + 1)
    phases = period * np.linspace(0.0, 1.0, _PHASES + 1)

    def is_reached(begin: float) -> bool:
        return bool(np.max(largest(begin + phases)) >= angle)

    # Beyond the epochs that the motion refuses, nothing is known to grow.
    with suppress(AttitudeError):
        if np.max(largest(start)) >= angle:
            return _crossing(largest, start, angle)
        low, high = 0.0, period
        while not is_reached(high):
            low, high = high, 2.0 * high
            if high > _MOST_PERIODS * period:
                return math.inf
        while high - low > period:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_reached(middle) else (middle, high)
        return _crossing(largest, np.linspace(low, high + period, _SAMPLES + 1), angle)
    return math.inf


def _crossing(
    largest: Callable[[FloatArray], FloatArray], seconds: FloatArray, angle: float
) -> float:
    """The first of increasing times at which the angle is reached, by bisection between them."""
    k = int(np.argmax(largest(seconds) >= angle))
    low, high = float(seconds[max(k - 1, 0)]), float(seconds[k])
    _, high = bisected(lambda time: not largest(np.array([time]))[0] >= angle, low, high, 60)
    return high


def _is_rounding(motion: Differentiable, seconds: float, angle: float) -> bool:
    """Whether errors cancel so far that the angle is a rounding error of their sum."""
    alone = motion.sensitivity_at(seconds) * np.sqrt(np.diag(motion._errors()))
    return bool(angle < _CANCELLED * np.linalg.norm(alone))


def flip_within_errors(motion: Differentiable) -> float:
    """Time to the next turn-over if one standard deviation crosses the separatrix, or inf."""
    time = math.inf
    for column in covariances.factor(motion._errors()).T:
        for sign in (1.0, -1.0):
            # Moments that are no body's have no turn-over.
            with suppress(AttitudeError):
                time = min(time, _flip(motion.regime, motion.changed(sign * column).regime))
    return time


def _drift_time(constants: Any, regime: Regime, tolerance: float) -> float:
    """The time from the changes of both phase rates, added in quadrature over the inputs."""
    psi = np.where(constants["form"] == codes.UNIFORM, 0.0, 1.0)
    psi = psi * np.where(constants["form"] == codes.HYPERBOLIC, 0.5, 1.0)
    nutation = constants["nutation"] * psi[:, None]
    total = 2.0 * _half_difference(constants["precession"])
    if regime.circulates == 0 or constants["form"][0] == codes.UNIFORM:
        drift = np.abs(total)  # the axis stays along the momentum, or turns over: see _flip
    else:
        psi = _half_difference(nutation)
        phi = total - psi
        angles = regime.nutation_L if regime.circulates < 0 else regime.nutation_S
        cosines = np.cos(angles)[:, None]
        squares = phi**2 + psi**2 + 2.0 * phi * psi * cosines
        drift = np.sqrt(np.maximum(squares, 0.0).max(axis=0))
    rate = 2.0 * math.pi * math.hypot(*drift)
    return tolerance / rate if rate > 0.0 else math.inf


def _half_difference(values):
    """Half of the change from minus to plus one error (N,), of pairs (1 + 2 N, 2)."""
    plus, minus = values[1::2], values[2::2]
    return 0.5 * ((plus[:, 0] - minus[:, 0]) + (plus[:, 1] - minus[:, 1]))


def _flip(regime: Regime, changed: Regime) -> float:
    """The time to the next turn-over if the changed motion is across the separatrix, else inf."""
    uniform = (Mode.AT_REST, Mode.SPHERICAL)
    if regime.circulates == changed.circulates or regime.mode in uniform:
        return math.inf
    if regime.mode is Mode.PRINCIPAL_AXIS and regime.one_minus_m == 1.0:
        return math.inf  # the equator of a symmetric body: nothing turns over
    return 0.5 * min(regime.P_psi, changed.P_psi)


def _constants(states, moments_error):
    try:
        source = States.of_principal_axes(states[:, 0], states[:, 1])
        return Evaluation(source).prepared(range(len(states)), rates=True).constants
    except AttitudeError as err:
        raise AttitudeError(
            f"with moments_error {moments_error.tolist()} the moments are not those of a body "
            f"({err}) Give smaller errors."
        ) from err


def _error(value: Reals, name: str) -> FloatArray:
    """Relative standard deviations (3,), from one number or three."""
    sigmas = validation.real(value, name)
    if sigmas.shape not in ((), (3,)):
        raise AttitudeError(f"{name} has shape {sigmas.shape}; give one number or three.")
    if np.any(sigmas < 0.0):
        raise AttitudeError(f"{name} is {sigmas.tolist()}; standard deviations are not negative.")
    return np.broadcast_to(sigmas, (3,))
