"""Fourier series in one or more frequencies, refined in all parameters: Gauss and Newton's steps.

With lines at n . f (whole numbers n, frequencies f) the model is linear but in f.  The joint
matrix of the linear terms and of the derivatives by f gives the step, and at the minimum the
covariance of f.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.spectrum.samples import Samples

# Steps at most, and the part of the resolution 1/span below which a step is the last.
_STEPS, _LAST = 25, 1e-7
# Eigenvalues of scaled normal equations below this part of the greatest belong to lines that the
# span does not resolve.
_RANK = 1e-11


@dataclass(frozen=True, eq=False)
class RefinedSeries:
    """A series at the least squares of all its parameters.

    Attributes
    ----------
    frequencies : (D,) array
        Hz.
    covariance : (D, D) array
        Of the frequencies, Hz2; from the residuals, whatever the scale of the errors.
    numbers : (K, D) array of int
        Of the lines.
    offsets : (C,) array
        Zero points of the curves.
    cosines, sines : (K,) arrays
        Of 2 pi n . f (t - start).
    start : float
        s, the middle of the samples.
    residuals : (N,) array
        In the unit of the values.
    chi_squared : float
        With the errors of the samples, or with unit weights.
    parameters : int
    """

    frequencies: FloatArray
    covariance: FloatArray
    numbers: IntArray
    offsets: FloatArray
    cosines: FloatArray
    sines: FloatArray
    start: float
    residuals: FloatArray
    chi_squared: float
    parameters: int

    @property
    def errors(self) -> FloatArray:
        """Standard errors (D,) of the frequencies, Hz."""
        found: FloatArray = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return found

    @property
    def amplitudes(self) -> FloatArray:
        """(K,) half of the peak-to-peak value of each line."""
        return np.hypot(self.cosines, self.sines)

    @property
    def rms(self) -> float:
        """Root of the mean square of the residuals, in the unit of the values."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def wave(self, t: FloatArray, chosen: FloatArray | None = None) -> FloatArray:
        """The sum of the lines (of those chosen by a mask) at seconds t, without zero points."""
        angles = _angles(t, self.start, self.frequencies, self.numbers)
        keep = np.ones(len(self.numbers)) if chosen is None else chosen
        found: FloatArray = np.cos(angles) @ (self.cosines * keep) + np.sin(angles) @ (
            self.sines * keep
        )
        return found


def refined(
    samples: Samples, frequencies: FloatArray, numbers: IntArray, steps: int = _STEPS
) -> RefinedSeries:
    """The series of least squares near given frequencies.

    Parameters
    ----------
    samples : Samples
    frequencies : (D,) array
        Hz.
    numbers : (K, D) array of int
        Of the lines, without zero.
    steps : int
        At most.

    Raises
    ------
    AttitudeError
        For fewer values than unknowns.
    """
    numbers = np.asarray(numbers).reshape(len(numbers), -1)
    lines, dimensions = numbers.shape
    parameters = samples.curves + 2 * lines + dimensions
    if len(samples.t) <= parameters:
        raise AttitudeError(
            f"{len(samples.t)} values are given for {parameters} unknowns; give more values, or a "
            "lower order."
        )
    start = float(0.5 * (samples.t.min() + samples.t.max()))
    f = np.array(frequencies, dtype=float)
    weights = samples.weights
    unit = 1.0 / max(samples.span, 1e-300)
    matrix, solution, residuals = _solved(samples, f, numbers, start, weights)
    chi = float(residuals @ residuals)
    for _ in range(steps):
        joint = _joint(samples, f, numbers, start, weights, matrix, solution, unit)
        step = _least_squares(joint, residuals)[-dimensions:]
        step *= min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300))
        scale = 1.0
        while scale > 0.05:
            tried = f + scale * step * unit
            found = _solved(samples, tried, numbers, start, weights)
            if found[2] @ found[2] <= chi:
                break
            scale *= 0.5
        else:
            break
        f, (matrix, solution, residuals) = tried, found
        chi = float(residuals @ residuals)
        if np.abs(scale * step).max() < _LAST:
            break
    joint = _joint(samples, f, numbers, start, weights, matrix, solution, unit)
    freedom = max(1, len(samples.t) - parameters)
    inverse = np.linalg.pinv(joint.T @ joint, hermitian=True)[-dimensions:, -dimensions:]
    return RefinedSeries(
        f,
        inverse * unit**2 * chi / freedom,
        numbers,
        solution[: samples.curves],
        solution[samples.curves : samples.curves + lines],
        solution[samples.curves + lines :],
        start,
        residuals / weights,
        chi,
        parameters,
    )


def fixed(samples: Samples, frequencies: FloatArray, numbers: IntArray) -> RefinedSeries:
    """The series at given frequencies, which are not refined; parameters as of `refined`.

    Its covariance is that of the frequencies as if they were free.

    Raises
    ------
    AttitudeError
        As `refined`.
    """
    return refined(samples, frequencies, numbers, steps=0)


def bootstrap(samples: Samples, found: RefinedSeries, draws: int, seed: int) -> FloatArray:
    """Frequencies (draws, D) of the series through points drawn anew with replacement.

    Parameters
    ----------
    samples : Samples
    found : RefinedSeries
        Of these samples.
    draws, seed : int
    """
    generator = validation.generator(seed)
    count = len(samples.t)
    unit = 1.0 / max(samples.span, 1e-300)
    dimensions = len(found.frequencies)
    out = np.empty((draws, dimensions))
    for draw in range(draws):
        often = np.bincount(generator.integers(0, count, count), minlength=count)
        weights = samples.weights * np.sqrt(often)
        f = found.frequencies.copy()
        for _ in range(4):
            matrix, solution, residuals = _solved(samples, f, found.numbers, found.start, weights)
            joint = _joint(samples, f, found.numbers, found.start, weights, matrix, solution, unit)
            step = _least_squares(joint, residuals)[-dimensions:]
            f = f + np.clip(step, -0.3, 0.3) * unit
        out[draw] = f
    return out


def _angles(t: FloatArray, start: float, frequencies: FloatArray, numbers: IntArray) -> FloatArray:
    """Angles (N, K) of the lines, rad; turns are reduced before they are multiplied by 2 pi."""
    turns = np.multiply.outer(t - start, numbers @ frequencies)
    found: FloatArray = 2.0 * np.pi * (turns - np.rint(turns))
    return found


def _solved(samples, f, numbers, start, weights):
    """Weighted matrix, coefficients and weighted residuals of the linear fit."""
    angles = _angles(samples.t, start, f, numbers)
    own = samples.curve[:, None] == np.arange(samples.curves)
    matrix = np.concatenate([own, np.cos(angles), np.sin(angles)], axis=1) * weights[:, None]
    right = samples.values * weights
    solution = _least_squares(matrix, right)
    return matrix, solution, right - matrix @ solution


def _least_squares(matrix, right):
    """The solution of least norm of scaled normal equations, corrected once by its residuals."""
    scale = np.sqrt(np.einsum("nk,nk->k", matrix, matrix))
    scale[scale == 0.0] = 1.0
    scaled = matrix / scale
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    inverse = np.where(values > _RANK * values[-1], 1.0 / np.maximum(values, 1e-300), 0.0)
    solution = vectors @ (inverse * (vectors.T @ (scaled.T @ right)))
    rest = right - scaled @ solution
    solution += vectors @ (inverse * (vectors.T @ (scaled.T @ rest)))
    return solution / scale


def _joint(samples, f, numbers, start, weights, matrix, solution, unit):
    """The matrix of all parameters: linear terms, and frequencies in units of 1/span."""
    lines = len(numbers)
    first = samples.curves
    cosines, sines = solution[first : first + lines], solution[first + lines :]
    # the weighted cosines and sines are columns of the matrix
    rate = matrix[:, first : first + lines] * sines - matrix[:, first + lines :] * cosines
    by_f = 2.0 * np.pi * unit * (samples.t - start)[:, None] * (rate @ numbers)
    return np.concatenate([matrix, by_f], axis=1)
