"""Propagate errors of published numbers to periods, angles and energy.

One input at a time is moved to either end of its error, and the changes of a result are added in
quadrature (`in_quadrature`); ends that do not exist are replaced (`possible_end`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._solver.regime import known_convention, regimes
from attitude._support import validation
from attitude._support.arrays import bisected
from attitude.errors import AttitudeError
from attitude.motions._published import dynamic_inertia_from_periods as from_periods
from attitude.motions._published import known_mode, moments_from_ratios, refuse_missing_mode
from attitude.motions._published import places_of_dynamic_inertia as places

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._solver.regime import Mode
    from attitude._support.annotations import FloatArray, Reals


_RESULTS = (
    "energy_ratio",
    "dynamic_inertia",
    "P_psi",
    "P_phi_L",
    "P_phi_S",
    "theta_least",
    "theta_greatest",
    "libration",
    "spin_rate_along",
)


class Uncertain(NamedTuple):
    """A value and its errors downward and upward, both positive, in the unit of the value."""

    value: float
    minus: float
    plus: float


def spread(
    *,
    A_over_C: Reals,
    B_over_C: Reals,
    mode: str | Mode,
    convention: str,
    P_psi: Reals,
    P_phi: Reals,
) -> dict[str, Uncertain]:
    """Errors of E/E0, periods and angles that follow from errors of the published numbers.

    Parameters
    ----------
    A_over_C, B_over_C : float, (value, error) or (value, minus, plus)
        Ratios of the moments A <= B <= C; signs of the errors do not matter.
    P_psi, P_phi : float, (value, error) or (value, minus, plus)
        s or Quantities.
    mode, convention
        As in `Spin.from_periods`.

    Returns
    -------
    dict of str to Uncertain
        energy_ratio (2EC/L^2), dynamic_inertia (over C), P_psi, P_phi_L, P_phi_S (s), theta_least,
        theta_greatest (rad; the range of the nutation angle of the convention's axis), libration
        (rad), spin_rate_along (2E/L, rad/s).  One input at a time is moved to either end of its
        error; the changes of a result are added in quadrature, downward and upward separately.
        An end at which no body or no motion of the mode exists is replaced by the farthest
        possible value.

    Raises
    ------
    AttitudeError
        If no motion has the values themselves.

    Examples
    --------
    >>> found = spread(
    ...     A_over_C=(0.61, -0.08, 0.11), B_over_C=(0.965, -0.015, 0.009),
    ...     mode="SAM", convention="S", P_psi="263 h", P_phi="27.38 h",
    ... )
    >>> "{:.4f} -{:.4f} +{:.4f}".format(*found["energy_ratio"])
    '1.0236 -0.0253 +0.0217'
    """
    known, convention = known_mode(mode), known_convention(convention)
    inputs = np.array(
        [
            _with_errors(A_over_C, "A_over_C", None),
            _with_errors(B_over_C, "B_over_C", None),
            _with_errors(P_psi, "P_psi", "s"),
            _with_errors(P_phi, "P_phi", "s"),
        ]
    )
    values = inputs[:, 0]
    moments = moments_from_ratios(*values[:2])
    refuse_missing_mode(moments, known)

    def exists(inputs: FloatArray) -> bool:
        return not np.isnan(_results(inputs[None], known, convention)).any()

    ends = [values]
    for k in range(4):
        for error in (-inputs[k, 1], inputs[k, 2]):
            step = np.zeros(4)
            step[k] = error
            ends.append(possible_end(values, step, exists))
    results_at = _results(np.array(ends), known, convention)
    if np.isnan(results_at[0]).any():
        from_periods(moments, known, convention, *values[2:])  # raises the error with its text
    return dict(zip(_RESULTS, in_quadrature(results_at), strict=True))


def in_quadrature(results: FloatArray) -> list[Uncertain]:
    """The first of rows (1 + N, K), with errors down and up from those of the N ends."""
    with np.errstate(invalid="ignore"):
        change = results[1:] - results[0]
        minus = np.sqrt(np.sum(np.minimum(change, 0.0) ** 2, axis=0))
        plus = np.sqrt(np.sum(np.maximum(change, 0.0) ** 2, axis=0))
    return [
        Uncertain(float(value), float(less), float(more))
        for value, less, more in zip(results[0], minus, plus, strict=True)
    ]


def possible_end(
    values: FloatArray, step: FloatArray, exists: Callable[[FloatArray], bool]
) -> FloatArray:
    """values + step, or the farthest point in that direction that exists, by bisection."""
    if not np.any(step) or exists(values + step):
        return values + step
    share, _ = bisected(lambda share: exists(values + share * step), 0.0, 1.0, 30)
    return values + share * step


def _results(sets, mode, convention):
    """The results (N, 9) of inputs (N, 4); NaN where no motion exists."""
    a, b, P_psi, P_phi = sets.T
    fine = (a > 0.0) & (a <= b) & (b <= 1.0) & (a + b >= 1.0) & (P_psi > 0.0) & (P_phi > 0.0)
    out = np.full((len(sets), len(_RESULTS)), np.nan)
    positions = np.full((len(sets), 3), np.nan)
    moments = np.column_stack([a, b, np.ones(len(sets))])
    long_axis = np.full(len(sets), mode == "LAM")
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = P_psi / P_phi - (convention == "S")
    positions[fine] = places(moments[fine], long_axis[fine], ratios[fine])
    fine &= ~np.isnan(positions[:, 0])
    if not np.any(fine):
        return out
    moments, (y, one_minus_y, unit_period) = moments[fine], positions[fine].T
    rates = _rates(moments, mode, y, one_minus_y) * (unit_period / P_psi[fine])[:, None]
    regime = regimes(moments, rates)
    theta = regime.nutation(convention)
    out[fine] = np.column_stack(
        [
            regime.energy_ratio,
            regime.dynamic_inertia,
            regime.P_psi,
            regime.P_phi_L,
            regime.P_phi_S,
            theta,
            regime.libration,
            regime.spin_rate_along,
        ]
    )
    return out


def _rates(moments, mode, y, one_minus_y):
    """The angular velocity (N, 3) for L = 1 where the momentum crosses the plane of A and C."""
    a, b, c = moments.T
    if mode == "LAM":
        below, above = (b - a) * one_minus_y, (c - b) + (b - a) * y
    else:
        below, above = (b - a) + (c - b) * y, (c - b) * one_minus_y
    # l_A^2 : l_C^2 = A (C-D) : C (D-A)
    along_a, along_c = np.sqrt(a * above), np.sqrt(c * below)
    size = np.hypot(along_a, along_c)
    return np.column_stack([along_a / (size * a), np.zeros(len(a)), along_c / (size * c)])


def _with_errors(value: Reals, name: str, unit: str | None) -> tuple[float, float, float]:
    """A value and its errors downward and upward, both positive."""
    sigmas = validation.real(value, name, unit=unit)
    if sigmas.shape not in ((), (2,), (3,)):
        raise AttitudeError(
            f"{name} has shape {sigmas.shape}; give a value, (value, error) or (value, minus, "
            "plus)."
        )
    known, *errors = np.atleast_1d(sigmas).tolist()
    minus, plus = (abs(errors[0]), abs(errors[-1])) if errors else (0.0, 0.0)
    return known, minus, plus
