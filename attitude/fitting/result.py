"""What a fit returns: the motion, its errors, and the residuals."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from attitude import markup, quaternion
from attitude.fitting import minimum
from attitude.fitting.observations import Observations, Rates
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.immutable import Immutable, frozen
from attitude.spin import Spin

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.fitting.minimum import Linearised
    from attitude.fitting.model import Model

# Errors of the directions of principal axes, rad, from which they count as those of a symmetric
# body, whose motion does not depend on them.
_UNCERTAIN = 0.05


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Immutable):
    """A free rotation fitted to records, and its residuals.

    Attributes
    ----------
    motion : FreeRotation
        From the epoch of the first record; moments are relative, with the sum 1, unless a body was
        given.  Its spin has a covariance, so that `motion.at(t)` has errors (`history.sigma`).
    residuals : (N, 3) array
        rad, over the body axes: the turn from the model to each attitude, or the least turn from
        the model to an attitude that agrees with each direction.  (0, 3) without either.
    rate_residuals : (N, 3) array or None
        rad/s: given angular velocities less those of the model.
    covariance : (P, P) array
        Of the parameters, for records whose errors are as large as the residuals: turn of the
        first attitude (3, rad, body axes), angular velocity then (3, rad/s), logarithms of the
        second moments of mass (the rest: 2 of the diagonal, with axes="free" 3 more, xy, xz, yz).
        Infinite for parameters that the records leave undetermined.

    Notes
    -----
    The covariance of the spin is finite.  Combinations of parameters that the records leave
    undetermined have there the variance 1.76 of an attitude of which nothing is known (rad2; the
    angular velocity in units of its size; the logarithms of the second moments).  A given body
    counts as exact.  With axes="free" the errors of attitude and angular velocity are those of the
    principal axes: the nine parameters of a spin hold no errors of their directions in the body,
    which do not grow with time; these are in `covariance`.  Errors of more than 0.05 rad are those
    of equal axes of a nearly symmetric body, and are left out of the covariance of the spin.
    """

    motion: FreeRotation
    residuals: FloatArray
    rate_residuals: FloatArray | None
    covariance: FloatArray = field(repr=False)

    @property
    def rms(self) -> float:
        """Root mean square of the angles of the residuals, rad; NaN if there are none."""
        return _rms(self.residuals)

    @property
    def rate_rms(self) -> float:
        """Root mean square of the sizes of the residuals of rates, rad/s; NaN without rates."""
        return np.nan if self.rate_residuals is None else _rms(self.rate_residuals)

    def _repr_html_(self) -> str:
        """A table for notebooks: residuals, then the motion with its errors."""
        size = self.rms if len(self.residuals) else self.rate_rms
        unit = "rad" if len(self.residuals) else "rad/s"
        count = len(self.residuals) or len(self.rate_residuals or ())
        head, rows = markup.rows_of(str(self.motion))
        first = ("records", f"{count}, rms {size:.3g} {unit}")
        return markup.table(f"Fit. {head}", [first, *rows])

    def __repr__(self) -> str:
        if len(self.residuals) or self.rate_residuals is None:
            return f"<Fit: {len(self.residuals)} records, rms {self.rms:.3g} rad, {self.motion!r}>"
        count = len(self.rate_residuals)
        return f"<Fit: {count} records, rms {self.rate_rms:.3g} rad/s, {self.motion!r}>"


def result(model: Model, observed: Observations, best: Linearised) -> Fit:
    """The Fit of the point of least loss."""
    point = best.point
    body = model.body_of(point.shape)
    spin = Spin(
        observed.epoch,
        point.wxyz,
        point.omega,
        covariance=_spin_covariance(model, body, best),
    )
    turns, rates = np.zeros((0, 3)), None
    for kind in observed.kinds:
        residuals = np.ascontiguousarray(kind.residuals(best.predicted))
        if isinstance(kind, Rates):
            rates = frozen(residuals)
        else:
            turns = residuals
    covariance = minimum.covariance(best.normal, best.variance)
    return Fit(FreeRotation(body, spin), frozen(turns), rates, frozen(covariance))


def _spin_covariance(model: Model, body: Body, best: Linearised) -> FloatArray:
    """The covariance (9, 9) of the spin."""
    point = best.point
    speed = float(np.linalg.norm(point.omega)) or 1.0
    factor = minimum.bounded_factor(best.normal, best.variance, speed)
    axes = body.principal_axes
    chain = model.chain(point, _logarithms(model, point.shape, axes), axes)
    state, turns = chain.state.copy(), chain.turns.copy()
    with np.errstate(over="ignore", invalid="ignore"):
        spread = np.sum((turns @ factor) ** 2, axis=1)
    turns[~(spread < _UNCERTAIN**2)] = 0.0
    omega = axes.T @ point.omega
    state[:3, 6:] = (quaternion.matrix(point.wxyz) @ axes @ turns)[:, 6:]
    state[3:6, 6:] = np.cross(omega, turns.T).T[:, 6:]
    state[3:6] = axes @ state[3:6]
    errors = state @ factor
    product: FloatArray = errors @ errors.T
    return 0.5 * (product + product.T)


def _logarithms(model: Model, shape: FloatArray, axes: FloatArray) -> FloatArray:
    return np.zeros(3) if model.body is not None else model.logarithms(shape, axes)


def _rms(vectors: FloatArray) -> float:
    if not len(vectors):
        return np.nan
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))
