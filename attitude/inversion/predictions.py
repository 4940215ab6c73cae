"""Magnitudes that a solution predicts, with the errors of motion, shape and zero points."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs
from attitude.errors import AttitudeError
from attitude.inversion import curve_problem, refinement
from attitude.inversion.curve import LightCurve
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S

if TYPE_CHECKING:
    from attitude.annotations import Epochs, FloatArray
    from attitude.inversion.curve_fit import CurveFit


def predicted(
    solution: CurveFit, times: Epochs | LightCurve | None
) -> tuple[FloatArray, FloatArray]:
    """Apparent magnitudes (T,) and their standard errors; see `CurveFit.predict`."""
    curve = solution.curve
    emission, sun, observer = _geometry(curve, times)
    alpha = _angle(sun, observer)
    own = solution.weighted.problem
    terms = _terms(solution, emission, alpha)
    unit = [(each / np.linalg.norm(each, axis=1)[:, None]).T for each in (sun, observer)]
    there = replace(own, t=emission / own.span, sun=unit[0].copy(), observer=unit[1].copy())
    here = solution._model(own)
    coefficients = own.coefficients(here.magnitude)
    made = solution._model(there)
    size = np.linalg.norm(sun, axis=1) * np.linalg.norm(observer, axis=1) / ASTRONOMICAL_UNIT_M**2
    magnitude = made.magnitude + terms @ coefficients + 5.0 * np.log10(size)
    # the linear terms follow the parameters
    b = own.terms * own.root[:, None]
    inverse = np.linalg.pinv(b.T @ b + np.diag(1.0 / own.prior**2), hermitian=True)
    follow = -inverse @ (b.T @ (here.jacobian * own.root).T)
    slopes = made.jacobian.T + terms @ follow
    variance = np.sum(
        (slopes @ refinement.inverse(solution.weighted.refined.normal)) * slopes, axis=1
    )
    variance += np.sum((terms @ inverse) * terms, axis=1)
    floor = float(np.median(np.abs(solution.residuals))) * 1.48
    return magnitude, np.sqrt(np.maximum(variance, 0.0) + floor**2)


def _geometry(curve: LightCurve, times: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Epochs of emission from that of the curve, and vectors to Sun and observer."""
    if times is None:
        return curve.emission, curve.sun, curve.observer
    if isinstance(times, LightCurve):
        shift = times.epoch.seconds - curve.epoch.seconds
        return times.emission + shift, times.sun, times.observer
    hi, lo = epochs.seconds_since(curve.epoch, times)
    t = np.atleast_1d(np.asarray(hi + (0.0 if lo is None else lo), dtype=float))
    known, first = np.unique(curve.seconds, return_index=True)
    outside = (t < known[0]) | (t > known[-1])
    if np.any(outside):
        raise AttitudeError(
            f"{np.count_nonzero(outside)} of {len(t)} epochs lie outside of the light curve, whose "
            "geometry ends there; give a LightCurve of these epochs (its magnitudes do not matter)."
        )
    sun, observer = (
        np.stack([np.interp(t, known, vectors[first, k]) for k in range(3)], axis=1)
        for vectors in (curve.sun, curve.observer)
    )
    late = float(np.median(curve.seconds - curve.emission))
    light = np.linalg.norm(observer, axis=1) / SPEED_OF_LIGHT_M_S if late > 0.0 else 0.0
    return t - light, sun, observer


def _terms(solution: CurveFit, emission: FloatArray, alpha: FloatArray) -> FloatArray:
    """Linear terms (T, L) at other epochs: of the first filter, sessions at their mean."""
    own = solution.weighted.problem
    found = np.zeros((len(emission), own.terms.shape[1]))
    made = curve_problem.phase_terms(alpha, emission / own.span)
    found[:, : made.shape[1]] = made
    found[:, made.shape[1]] = 1.0
    return found


def _angle(a: FloatArray, b: FloatArray) -> FloatArray:
    cross = np.linalg.norm(np.cross(a, b), axis=1)
    found: FloatArray = np.arctan2(cross, np.sum(a * b, axis=1))
    return found
