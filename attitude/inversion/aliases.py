"""How one spin state relates to another that fits the same light curve, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude.inversion import pole_map, search

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.inversion.problem import CurveProblem

# Angles within which poles are related, and frequencies, turns per span.
_NEAR, _RATE = math.radians(25.0), 0.5
_SIDEREAL_DAY, _DAY = 86164.0905, 86400.0


def rates(state: FloatArray) -> tuple[float, float]:
    """Frequencies of phi of the long axis and of psi, turns per span; psi 0 for one axis."""
    twice = 2.0 * float(state[0])
    if search.is_axial(state):
        return twice, 0.0
    nutation = abs(float(state[1]))
    return (twice - nutation if state[1] > 0.0 else twice), nutation


def plane_of(problem: CurveProblem) -> FloatArray:
    """The normal (3,) of the plane in which Sun and observer lie, seen from the body."""
    both = np.concatenate([problem.sun, problem.observer], axis=1)
    found: FloatArray = np.linalg.eigh(both @ both.T)[1][:, 0]
    return found


def relation(state: FloatArray, best: FloatArray, problem: CurveProblem) -> str:
    """The relation of a state to the best one: of modes, periods and poles.

    Parameters
    ----------
    state, best : (WIDTH,) arrays
    problem : CurveProblem
    """
    words = []
    if search.is_axial(state) != search.is_axial(best):
        words.append("rotation about one axis" if search.is_axial(state) else "tumbling")
    elif not (search.has_rates(state, best) or _sees_one_turn(state, best, problem)):
        words.append(_of_rates(state, best, problem.span))
    if state is best:
        return "best"
    words.append(_of_poles(search.pole(state), search.pole(best), plane_of(problem)))
    return ", ".join(words)


def _sees_one_turn(state: FloatArray, best: FloatArray, problem: CurveProblem) -> bool:
    return search.is_axial(best) and pole_map.has_turn(problem, state, best)


def _of_rates(state: FloatArray, best: FloatArray, span: float) -> str:
    (phi, psi), (phi0, psi0) = rates(state), rates(best)
    same_phi, same_psi = abs(phi - phi0) < _RATE, abs(psi - psi0) < _RATE
    other = (state[1] > 0.0) != (best[1] > 0.0)
    if other and 2.0 * abs(state[0] - best[0]) < _RATE and same_psi:
        return "other mode of the same lines"
    prefix = "other mode, " if other else ""
    both = (("phi", phi, phi0), ("psi", psi, psi0))
    # about one axis nothing turns at psi
    named = both if psi or psi0 else both[:1]
    for day in (span / _DAY, span / _SIDEREAL_DAY):
        for name, a, b in named:
            if abs(abs(a - b) - day) < _RATE:
                return f"{prefix}one cycle a day in {name}"
    for name, a, b in named:
        if abs(a - 2.0 * b) < _RATE:
            return f"{prefix}half the period of {name}"
        if abs(2.0 * a - b) < _RATE:
            return f"{prefix}twice the period of {name}"
    if same_phi or same_psi:
        return f"{prefix}other period of {'psi' if same_phi else 'phi'}"
    if abs(phi + psi - phi0 - psi0) < _RATE:
        return f"{prefix}same period of the short axis"
    return f"{prefix}other periods"


def mirrored(pole: FloatArray, normal: FloatArray) -> FloatArray:
    """The pole (3,) of the mirror image of a rotating body in the plane of a normal (3,).

    Directions in that plane see both alike.  Angular momentum is an axial vector: its part along
    the plane changes sign, so that the longitude from the plane's axis changes by half a turn.
    """
    found: FloatArray = 2.0 * (pole @ normal) * normal - pole
    return found


def _of_poles(pole: FloatArray, best: FloatArray, normal: FloatArray) -> str:
    mirror = mirrored(best, normal)
    near = math.cos(_NEAR)
    if pole @ best > near:
        return "same pole"
    for name, other in (
        ("mirror pole", mirror),
        ("antipode", -best),
        ("antipode of the mirror pole", -mirror),
    ):
        if pole @ other > near:
            return name
    return "other pole"
