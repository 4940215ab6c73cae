"""Covariances of the nine parameters of a motion: read, checked and factored.

The parameters are the rotation vector of the first attitude (3, rad, inertial axes), the angular
velocity at the epoch (3, rad/s, body axes) and the principal moments (3, kg m2 or relative).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


# Asymmetry, and a negative eigenvalue of the correlations, that count as rounding.
_ROUNDING = 1e-9
# An eigenvalue of correlations that may be rounding: 9 rows of up to 9 products of doubles.
_NO_EIGENVALUE = 81.0 * float(np.finfo(float).eps)
# Names of standard deviations, and their units; the moments have that of the body.
UNITS: Final[Mapping[str, str | None]] = {
    "attitude": "rad",
    "angular_velocity": "rad/s",
    "moments": None,
}


def known(value: Any, name: str = "covariance") -> FloatArray:
    """A covariance (9, 9) of the parameters."""
    if isinstance(value, Mapping):
        return _of_components(value, name)
    matrix = validation.real(value, name)
    if matrix.shape not in ((9, 9), (6, 6)):
        raise AttitudeError(
            f"{name} has shape {matrix.shape}; give (9, 9): attitude, angular velocity and moments,"
            ' (6, 6) without the moments, or standard deviations such as {"attitude": "1 deg"}.'
        )
    full = np.zeros((9, 9))
    full[: len(matrix), : len(matrix)] = matrix
    variances = np.diag(full)
    if np.any(variances < 0.0):
        worst = int(np.argmin(variances))
        raise AttitudeError(
            f"{name} has {variances[worst]:.3g} on its diagonal (row {worst}); variances are not "
            "negative."
        )
    size = np.sqrt(variances)
    scale = np.outer(size, size)
    off = np.abs(full - full.T)
    if np.any(off > _ROUNDING * np.maximum(scale, np.abs(full))):
        i, j = np.unravel_index(int(np.argmax(off)), off.shape)
        raise AttitudeError(
            f"{name} is not symmetric: {full[i, j]:.6g} in row {i}, column {j}, and "
            f"{full[j, i]:.6g} in its mirror; give a symmetric matrix."
        )
    full = 0.5 * (full + full.T)
    lowest = float(np.linalg.eigvalsh(_correlations(full)[0]).min())
    if lowest < -_ROUNDING or np.any((scale == 0.0) & (full != 0.0)):
        raise AttitudeError(
            f"{name} is not positive: the least eigenvalue of its correlations is {lowest:.3g}; "
            "give a covariance."
        )
    return full


def components(covariance: FloatArray) -> dict[str, FloatArray] | None:
    """Standard deviations (3,) by name that `known` makes into the same bits; None for correlated
    errors, and for variances that are no squares of doubles.
    """
    sigma = np.sqrt(np.diag(covariance))
    if np.diag(sigma**2).tobytes() != covariance.tobytes():
        return None
    return {key: sigma[3 * k : 3 * k + 3] for k, key in enumerate(UNITS)}


def factor(covariance: FloatArray) -> FloatArray:
    """W (9, 9) of a covariance W W^T; columns of zeros where its rank is lower.

    Eigenvalues of the correlations that are rounding errors count as zero: their square roots,
    1e-8, would be errors in directions in which the covariance has none.
    """
    correlations, size = _correlations(covariance)
    values, vectors = np.linalg.eigh(correlations)
    values = np.where(values > _NO_EIGENVALUE, values, 0.0)
    return size[:, None] * (vectors * np.sqrt(values))


def _correlations(covariance):
    """Correlations, 0 where a variance is 0, and standard deviations."""
    size = np.sqrt(np.diag(covariance))
    over = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    return covariance * over[:, None] * over, size


def _of_components(sigmas: Mapping[str, Any], name: str) -> FloatArray:
    unknown = [key for key in sigmas if key not in UNITS]
    if unknown:
        raise AttitudeError(
            f'{name} has "{unknown[0]}"; its names are attitude, angular_velocity and moments.'
        )
    sigma = np.zeros(9)
    for k, (key, unit) in enumerate(UNITS.items()):
        if key in sigmas:
            value = validation.real(sigmas[key], f"{name} {key}", unit=unit)
            if value.shape not in ((), (3,)) or np.any(value < 0.0):
                raise AttitudeError(
                    f"{name} {key} is {validation.shown(value.tolist())}; give one standard "
                    "deviation, or three, not negative."
                )
            sigma[3 * k : 3 * k + 3] = value
    return np.diag(sigma**2)
