"""A light curve as numbers: scaled epochs, directions, magnitudes, and projected-out terms.

Epochs are in units of the span, from the middle, so that rates are turns per span.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray

# Eigenvalues of the scaled linear terms, relative to 1, below which a combination is a copy.
_COPY = 1e-10


def _inverse_factor(terms: FloatArray, prior: FloatArray) -> FloatArray:
    """W (L, K) with W W^T the inverse of B^T B + V^-1."""
    inner = terms.T @ terms + np.diag(1.0 / prior**2)
    scale = np.sqrt(np.diag(inner))
    scale[scale == 0.0] = 1.0
    values, vectors = np.linalg.eigh(inner / np.outer(scale, scale))
    kept = values > _COPY
    found: FloatArray = vectors[:, kept] / np.sqrt(values[kept]) / scale[:, None]
    return found


@dataclass(frozen=True, eq=False)
class CurveProblem:
    """Magnitudes with weights, and the terms in which they are linear.

    Attributes
    ----------
    t : (N,) array
        Epochs of emission from the middle of the span, in spans.
    span : float
        s.
    sun, observer : (3, N) array
        Unit vectors, ICRF.
    magnitude : (N,) array
        Reduced to unit distances.
    sigma : (N,) array
        Of the magnitudes as given.
    terms : (N, L) array
        Terms in which the magnitude is linear.
    prior : (L,) array
        Standard deviation of the coefficient of each term; infinite for a free one.
    model_error : float
        Magnitudes, added to sigma in quadrature.
    """

    t: FloatArray
    span: float
    sun: FloatArray
    observer: FloatArray
    magnitude: FloatArray
    sigma: FloatArray
    terms: FloatArray
    prior: FloatArray
    model_error: float
    root: FloatArray
    u: FloatArray
    y: FloatArray

    @classmethod
    def of(
        cls,
        t: FloatArray,
        span: float,
        sun: FloatArray,
        observer: FloatArray,
        magnitude: FloatArray,
        sigma: FloatArray,
        terms: FloatArray,
        prior: FloatArray,
        model_error: float,
    ) -> CurveProblem:
        """The problem with a model error; `root`, `u` and `y` follow from the rest."""
        root = 1.0 / np.hypot(sigma, model_error)
        inverse = _inverse_factor(terms * root[:, None], prior)
        # Marginal over coefficients of variance V: I - B (V^-1 + B^T B)^-1 B^T
        u = np.ascontiguousarray(((terms * root[:, None]) @ inverse).T)
        # a constant is a free term of every curve
        y = magnitude - np.average(magnitude, weights=root**2)
        return cls(
            np.ascontiguousarray(t),
            span,
            np.ascontiguousarray(sun),
            np.ascontiguousarray(observer),
            magnitude,
            sigma,
            terms,
            prior,
            model_error,
            root,
            u,
            np.ascontiguousarray(y),
        )

    def with_model_error(self, model_error: float) -> CurveProblem:
        """The same magnitudes with another model error."""
        given = self.t, self.span, self.sun, self.observer, self.magnitude
        return CurveProblem.of(*given, self.sigma, self.terms, self.prior, model_error)

    def with_sigma(self, sigma: FloatArray) -> CurveProblem:
        """The same magnitudes with other errors (N,), and no model error."""
        given = self.t, self.span, self.sun, self.observer, self.magnitude
        return CurveProblem.of(*given, sigma, self.terms, self.prior, 0.0)

    def part(self, chosen: BoolArray) -> CurveProblem:
        """Some of the points (N,) alone."""
        return CurveProblem.of(
            self.t[chosen],
            self.span,
            self.sun[:, chosen],
            self.observer[:, chosen],
            self.magnitude[chosen],
            self.sigma[chosen],
            self.terms[chosen],
            self.prior,
            self.model_error,
        )

    def __len__(self) -> int:
        return len(self.t)

    def coefficients(self, model: FloatArray) -> FloatArray:
        """Coefficients (L,) of the linear terms for model magnitudes (N,)."""
        b = self.terms * self.root[:, None]
        inverse = _inverse_factor(b, self.prior)
        found: FloatArray = inverse @ (inverse.T @ (b.T @ ((self.magnitude - model) * self.root)))
        return found

    @property
    def detrended(self) -> FloatArray:
        """Magnitudes (N,) without the linear terms that fit them best."""
        found: FloatArray = self.magnitude - self.terms @ self.coefficients(np.zeros(len(self)))
        return found

    def chi_squared(self, model: FloatArray) -> float:
        """Sum of squares of weighted residuals, least over the coefficients."""
        r = (self.magnitude - model) * self.root
        along = self.u @ r
        return float(r @ r - along @ along)
