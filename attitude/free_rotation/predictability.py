"""The time in which errors of moments and rates grow to a tolerance of the attitude.

The errors that grow with time are those of two phases, whose rates are known to 31 digits: the
differences of these rates between inputs changed by their errors give the drift of the attitude,
without derivatives and without loss of digits by cancellation.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import evaluation, validation
from attitude.errors import AttitudeError
from attitude.regime import Mode, regime_of
from attitude.solution import codes

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals
    from attitude.regime import Regime

_IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])


def predictable_time(
    moments: FloatArray,
    omega: FloatArray,
    *,
    moments_error: Reals = 0.0,
    rates_error: Reals = 0.0,
    tolerance: Real = 0.1,
) -> float:
    """Seconds until the error of the attitude reaches a tolerance.

    Parameters
    ----------
    moments, omega : (3, 2) arrays
        Principal moments and rates over the principal axes (rad/s), pairs of doubles.
    moments_error : float or (3,) array_like
        One standard deviation, relative to each moment; independent of each other.
    rates_error : float or (3,) array_like
        One standard deviation of each component relative to the magnitude of the angular velocity.
    tolerance : float or Quantity
        rad; the error of one standard deviation at the time returned.

    Returns
    -------
    float
        s; inf without errors.  Errors that do not grow (of the direction of the momentum, and of
        the angle to it) are not counted.  If the error of an input reaches across the separatrix,
        the result is at most the time to the next turn-over, half of P_psi.

    Raises
    ------
    AttitudeError
        For negative errors, and moments that with their errors are not those of a body.
    """
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
    given = np.stack([moments, omega])[None]
    states = np.concatenate([given, _shifted(given, shifts)])
    constants = _constants(states, of_moments)
    middle = regime_of(states[:1, 0], constants[:1])
    changed = [regime_of(states[k : k + 1, 0], constants[k : k + 1]) for k in range(1, len(states))]
    return min(
        _drift_time(constants, middle, angle),
        *(_flip(middle, other) for other in changed),
    )


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


def _half_difference(pairs):
    """Half of the change from minus to plus one error (N,), of pairs (1 + 2 N, 2)."""
    plus, minus = pairs[1::2], pairs[2::2]
    return 0.5 * ((plus[:, 0] - minus[:, 0]) + (plus[:, 1] - minus[:, 1]))


def _flip(given: Regime, changed: Regime) -> float:
    """The time to the next turn-over if the changed motion is across the separatrix, else inf."""
    uniform = (Mode.AT_REST, Mode.SPHERICAL)
    if given.circulates == changed.circulates or given.mode in uniform:
        return math.inf
    if given.mode is Mode.PRINCIPAL_AXIS and given.one_minus_m == 1.0:
        return math.inf  # the equator of a symmetric body: nothing turns over
    return 0.5 * min(given.P_psi, changed.P_psi)


def _shifted(given, shifts):
    """Sums of pairs and doubles, as pairs."""
    hi, lo = given[..., 0], given[..., 1]
    total = hi + shifts
    back = total - hi
    rest = (hi - (total - back)) + (shifts - back) + lo
    high = total + rest
    return np.stack([high, rest - (high - total)], axis=-1)


def _constants(states, moments_error):
    try:
        return evaluation.constants_of(
            np.ascontiguousarray(states[:, 0]),
            np.tile(_IDENTITY, (len(states), 1)),
            np.ascontiguousarray(states[:, 1]),
            _IDENTITY,
        )
    except AttitudeError as err:
        raise AttitudeError(
            f"with moments_error {moments_error.tolist()} the moments are not those of a body "
            f"({err}) Give smaller errors."
        ) from err


def _error(value: Reals, name: str) -> FloatArray:
    """Relative standard deviations (3,), from one number or three."""
    given = validation.real(value, name)
    if given.shape not in ((), (3,)):
        raise AttitudeError(f"{name} has shape {given.shape}; give one number or three.")
    if np.any(given < 0.0):
        raise AttitudeError(f"{name} is {given.tolist()}; standard deviations are not negative.")
    return np.broadcast_to(given, (3,))
