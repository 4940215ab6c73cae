"""The least squares of a fit, by Levenberg and Marquardt's iteration, and its result.

Spans grow from the first records to all.  Derivatives are in closed form, and each trial point is
evaluated with them: most are accepted.
"""

from __future__ import annotations

import warnings
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import least_squares, markup, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.least_squares import Decomposed, Near
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.fitting import _observations as records
from attitude.fitting._observations import Rates
from attitude.frames import quaternion
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import BoolArray, FloatArray, IntArray, Real, Reals
    from attitude.fitting._model import Model, Point, Prediction
    from attitude.fitting._observations import Observations
    from attitude.motions._body import Body


# ---- Robust losses: how much a record counts whose residual is large
# A loss rho is a function of z, the square of a residual over that of its standard error times
# `f_scale`; rho(z) is z for small z.  The names are those of scipy.optimize.least_squares, but a
# residual is the whole vector of a record, so that a result does not depend on the axes.

NAMES = ("linear", "soft_l1", "huber", "cauchy")
# Factor of the scale of a robust loss in the stages before the last one.
_WIDE = 30.0


@dataclass(frozen=True)
class Loss:
    """A loss and its scale.

    name: one of `NAMES`.
    scale: in standard errors: where residuals begin to count as outliers.
    usual: the standard error of a residual times its weight; None where it is not known.
    """

    name: str
    scale: float
    usual: float | None = None

    @property
    def robust(self) -> bool:
        """Whether large residuals count less than in least squares."""
        return self.name != "linear"

    @property
    def wide(self) -> Loss:
        """The loss of motions that are not near the truth yet, whose residuals are large."""
        return replace(self, scale=_WIDE * self.scale)

    def values(self, squares: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Losses (N,), their first derivatives and their second times the argument."""
        z = squares / self.scale**2
        if self.name == "soft_l1":
            root = np.sqrt(1.0 + z)
            rho, first, second = 2.0 * (root - 1.0), 1.0 / root, -0.5 * z / root**3
        elif self.name == "huber":
            root = np.sqrt(np.maximum(z, 1.0))
            outside = z > 1.0
            rho = np.where(outside, 2.0 * root - 1.0, z)
            first, second = 1.0 / root, np.where(outside, -0.5 / root, 0.0)
        elif self.name == "cauchy":
            rho, first, second = np.log1p(z), 1.0 / (1.0 + z), -z / (1.0 + z) ** 2
        else:
            rho, first, second = z, np.ones_like(z), np.zeros_like(z)
        return rho * self.scale**2, first, second


def known_loss(name: str, f_scale: Real | None, sigma: Reals | None) -> Loss:
    """The loss of a name and scale."""
    if not isinstance(name, str) or name not in NAMES:
        listed = ", ".join(f'"{label}"' for label in NAMES)
        raise AttitudeError(f"loss is {validation.shown(name)}; it must be one of {listed}.")
    if name != "linear" and sigma is None and f_scale is None:
        raise AttitudeError(
            f'loss="{name}" needs the size of usual residuals; give sigma=, or f_scale= in the '
            "unit of the residuals."
        )
    scale = 1.0 if f_scale is None else validation.positive(f_scale, "f_scale")
    usual = scale if sigma is None and name != "linear" else None
    return Loss(name, scale, usual if sigma is None else 1.0)


# Eigenvalues of the scaled normal matrix, relative to 1, that are zero within rounding.
_LOST = 1e-12
# Damped so little that most steps are those of Gauss and Newton; ended by the gain they promise.
_RULE = least_squares.Rule(
    start=1e-7,
    least=1e-10,
    stuck=1e12,
    larger=30.0,
    gain=-1.0,
    settled=0,
    bounds_count=False,
)
# Least mean of the second derivative of the loss, of that for small residuals, in the variance.
_LEAST_BEND = 1e-3
# Largest step: rad of attitude, angular velocity relative to its size, logarithms of the shape.
_LONGEST = (0.5, 0.3, 1.0)
# Evaluations of the last stage, at most.
_MOST = 100
# Evaluations of a stage before, at most.
_MOST_EARLY = 12
# Gain of a step, in variances of a record, below which the iteration of the last stage ends: 1e-3
# standard errors of the parameters.
_LAST = 1e-6
# The same of a stage before: 0.3 standard errors.
_LAST_EARLY = 0.1
# Records of a stage before the last one: as many as determine a span well enough for the next.
_MOST_RECORDS = 100
# Predicted error of attitudes, rad, up to which the next stage extends.
_REACH = 0.05
# Rms, rad, of residuals that are right in any case, and of those that are large where errors are
# not known.
_NEGLIGIBLE = 1e-9
_LARGE = 0.1
# Share of the records that are no outliers, at least, and the square of residuals that is usual, in
# numbers that a record measures.
_INLIERS = 0.7
_USUAL = 1.7
# Correlation of residuals with neighbours, up to so many records away, from which they are alike.
_ALIKE = 0.3
_LAGS = 8
# Misfit up to which residuals that are not alike count as errors that are given too small.
_EXCUSED = 5.0
# Misfit from which a warning is given.
_UNEXPLAINED = 2.0
# Epochs of prediction.
_PREDICTED = 64
# Variance, rad2, of each component of the rotation vector of an attitude of which nothing is known:
# a third of pi^2/3 + 2, the mean square of the angle of uniformly random rotations.
UNKNOWN = (np.pi**2 / 3.0 + 2.0) / 3.0


@dataclass(frozen=True)
class Linearised:
    """The loss near a point.

    cost: half the sum of the losses.
    gradient: (P,), the direction of descent: minus the derivative of the cost.
    variance: of the records, in units of their standard errors: that of residuals as large as
        these.
    bending, normal: the second derivatives (P, P) of the cost, from first ones of the residuals:
        with the weights of the loss, and with those of the standard errors alone.
    """

    point: Point
    predicted: Prediction
    cost: float
    gradient: FloatArray
    variance: float
    bending: FloatArray
    normal: Decomposed


class Problem:
    """A model, observations and a loss."""

    def __init__(self, model: Model, observed: Observations, loss: Loss) -> None:
        self.model, self.observed, self.loss = model, observed, loss

    def linearised(self, point: Point) -> Linearised:
        """The loss near a point."""
        observed, count, robust = self.observed, self.model.count, self.loss.robust
        predicted = self.model.predict(point, observed.t, rates=observed.with_rates)
        cost, score, bend, numbers = 0.0, 0.0, 0.0, 0
        gradient = np.zeros(count)
        weighted, normal = np.zeros((count, count)), np.zeros((count, count))
        for kind in observed.kinds:
            residual, slopes = kind.compare(predicted)
            residual, slopes = residual * kind.weight, slopes * kind.weight
            squares = np.sum(residual**2, axis=0)
            rho, first, second = self.loss.values(squares)
            across = slopes.transpose(0, 2, 1)
            normal += (slopes @ across).sum(axis=0)
            if robust:
                weighted += ((slopes * first) @ across).sum(axis=0)
            gradient += (slopes @ (residual * first)[..., None]).sum(axis=0)[:, 0]
            cost += 0.5 * float(np.sum(rho))
            used = kind.weight > 0.0
            numbers += kind.dimensions * int(np.count_nonzero(used))
            score += float(np.sum(first**2 * squares))
            bend += float(np.sum((kind.dimensions * first + 2.0 * second)[used]))
        by_errors = Decomposed(normal)
        # Huber's variance of a robust estimate; that of least squares with a linear loss.
        variance = score / max(numbers - int(np.count_nonzero(by_errors.values > _LOST)), 1)
        variance /= max(bend / max(numbers, 1), _LEAST_BEND) ** 2
        bending = weighted if robust else normal
        return Linearised(point, predicted, cost, gradient, variance, bending, by_errors)

    def minimum(self, point: Point, *, last: bool = True) -> Linearised:
        """The loss near the point of least loss, from a point near it."""
        lowest = 0.5 * records.floor(self.observed, float(np.linalg.norm(point.omega)))
        share = _LAST if last else _LAST_EARLY

        def enough(states: NDArray[Any]) -> FloatArray:
            return np.array([max(share * states[0].variance, lowest)])

        problem = least_squares.Problem(self._near, self._moved, enough=enough)
        start, most = np.array([point], dtype=object), _MOST if last else _MOST_EARLY
        best = least_squares.minimum(problem, start, _RULE, most)
        return best.states[0] if np.isfinite(best.cost[0]) else self.linearised(point)

    def _near(self, points: NDArray[Any]) -> Near:
        """The loss near the one point (1,), infinite for a motion that has no derivatives."""
        try:
            linear = self.linearised(points[0])
        except AttitudeError:
            return Near(points, np.array([np.inf]), np.zeros((1, 1, 1)), np.zeros((1, 1)))
        states = np.array([linear], dtype=object)
        # Steps of a shape that the records leave undetermined are short.
        bending = linear.bending + 0.0
        shape = np.arange(6, len(bending))
        bending[shape, shape] += linear.cost / len(self.observed)
        return Near(states, np.array([linear.cost]), bending[None], linear.gradient[None])

    def _moved(self, states: NDArray[Any], steps: FloatArray) -> tuple[NDArray[Any], BoolArray]:
        """The point after a step (1, P) from the loss near another, and if the step is short."""
        point, step = states[0].point, steps[0]
        longest = np.repeat(_LONGEST, (3, 3, len(step) - 6))
        turned = _LONGEST[0] / max(float(np.ptp(self.observed.t)), 1e-300)
        longest[3:6] = max(_LONGEST[1] * float(np.linalg.norm(point.omega)), turned)
        is_short = np.all(np.abs(step) <= longest)
        return np.array([point.moved(step)], dtype=object), np.array([is_short])


def minimum_of_stages(
    model: Model, observed: Observations, loss: Loss, point: Point, first: int
) -> Linearised:
    """The loss near its least point, from a first guess.

    Stages take the first records, so many that no phase of a tumbler is wrong by a revolution: the
    next stage extends to where attitudes are predicted to `_REACH`.
    """
    total, count = len(observed), min(first, len(observed))
    while count < total or total > _MOST_RECORDS or loss.robust:
        stage = Problem(model, observed.at(thinned(count)), loss.wide).minimum(point, last=False)
        point = stage.point
        if count == total:
            break
        count = max(_reach(model, observed, stage, count), int(1.5 * count), count + 1)
        count = min(count, total)
    return Problem(model, observed, loss).minimum(point)


def _minimum_of_all(
    model: Model,
    observed: Observations,
    loss: Loss,
    point: Point,
    first: int,
    others: Callable[[], Sequence[Point]],
) -> Linearised:
    """The loss near its least point, from a first guess or, where that fails, from others.

    A warning says that none explains the records.
    """
    best = minimum_of_stages(model, observed, loss, point, first)
    misfit = misfit_of(observed, loss, best)
    if misfit <= 1.0:
        return best
    for other in others():
        with suppress(AttitudeError):
            trial = minimum_of_stages(model, observed, loss, other, first)
            if trial.cost < best.cost:
                best, misfit = trial, misfit_of(observed, loss, trial)
        if misfit <= 1.0:
            return best
    if misfit > _UNEXPLAINED:
        warnings.warn(
            "the residuals are far larger than the errors of the records: the motion that is found "
            "is a wrong one, or no free rotation fits. Give the body, a motion near the truth, "
            'start=FreeRotation(...), axes="free", or a robust loss if some records are outliers.',
            AttitudeWarning,
            stacklevel=5,
        )
    return best


def misfit_of(observed: Observations, loss: Loss, best: Linearised) -> float:
    """How much larger residuals are than those of a right motion; up to 1 where it may be right.

    They are compared with their standard errors, and where these are not known or too small, with
    their neighbours: errors of records are not alike, those of a motion are.
    """
    kind = observed.kinds[0]
    used = kind.weight > 0.0
    residuals = (kind.compare(best.predicted)[0] * kind.weight)[:, used]
    squares = np.sum(residuals**2, axis=0)
    one = kind.scale() * float(np.sum(kind.weight)) / max(len(squares), 1)
    if not np.sum(squares) > len(squares) * (_NEGLIGIBLE * one) ** 2:
        return 0.0
    if loss.usual is None:
        size = float(np.sqrt(np.mean(squares))) / (_LARGE * one)
    else:
        typical = np.quantile(squares, _INLIERS) if loss.robust else np.mean(squares)
        size = float(np.sqrt(typical / (_USUAL * kind.dimensions))) / loss.usual
        if size <= 1.0:
            return size
    residuals /= np.sqrt(squares + max(np.median(squares), 1e-9 * np.mean(squares)))
    count = len(squares)
    alike = 0.0
    for lag in range(1, min(_LAGS, count // 2) + 1):
        product = float(np.sum(residuals[:, lag:] * residuals[:, :-lag]))
        alike = max(alike, abs(product) / float(np.sum(residuals**2)))
    limit = max(_ALIKE, 4.0 / np.sqrt(kind.dimensions * count))
    return size if alike > limit or size > _EXCUSED else min(size, 1.0)


def covariance_at_minimum(normal: Decomposed, variance: float) -> FloatArray:
    """Covariance of the parameters; infinite variances of those that are undetermined."""
    lost = normal.values <= _LOST
    vectors = normal.vectors
    inverse: FloatArray = (vectors / np.where(lost, np.inf, normal.values)) @ vectors.T
    inverse *= variance / np.outer(normal.scale, normal.scale)
    unknown = normal.empty | np.any(np.abs(vectors[:, lost]) > 1e-3, axis=1)
    inverse[unknown] = inverse[:, unknown] = 0.0
    inverse[unknown, unknown] = np.inf
    return inverse


def bounded_factor(normal: Decomposed, variance: float, speed: float) -> FloatArray:
    """W of a covariance W W^T of the parameters; in undetermined directions it is `UNKNOWN`.

    That variance is in units of rad of the attitude, of the speed (rad/s) of the angular velocity
    and of the logarithms of the shape.
    """
    unit = np.ones(len(normal.scale))
    unit[3:6] = speed
    directions = normal.vectors / (normal.scale * unit)[:, None]
    length = np.linalg.norm(directions, axis=0)
    known = np.where(normal.values > _LOST, normal.values, np.nan)
    spread = np.fmin(variance * length**2 / known, UNKNOWN)
    directions *= unit[:, None] / length
    return directions * np.sqrt(spread)


def thinned(end: int, first: int = 0, most: int = _MOST_RECORDS) -> IntArray:
    """At most so many of the numbers first .. end - 1, evenly; by default those of a stage."""
    chosen = np.linspace(first, end - 1, min(end - first, most))
    return np.unique(chosen.round().astype(np.int64))


def _reach(model: Model, observed: Observations, stage: Linearised, count: int) -> int:
    """The number of first records that are predicted to `_REACH`."""
    ahead = thinned(len(observed), count, _PREDICTED)
    records_ahead = observed.at(ahead)
    try:
        predicted = model.predict(stage.point, records_ahead.t, rates=records_ahead.with_rates)
    except AttitudeError:
        return count
    speed = float(np.linalg.norm(stage.point.omega)) or 1.0
    factor = bounded_factor(stage.normal, stage.variance, speed)
    square = np.zeros(len(ahead))
    for kind in records_ahead.kinds:
        errors = factor.T @ (kind.compare(predicted)[1] / kind.scale())
        square = np.maximum(square, np.sum(errors**2, axis=(0, 1)))
    beyond = np.flatnonzero(square > _REACH**2)
    return int(ahead[beyond[0]]) if len(beyond) else len(observed)


# ---- What a fit returns: the motion, its errors, and the residuals

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
        head, rows = markup.rows_of(str(self.motion))
        return markup.table(f"Fit. {head}", [("fitted to", self._records()), *rows])

    def __repr__(self) -> str:
        return f"<Fit: {self._records()}, {self.motion!r}>"

    def _records(self) -> str:
        if len(self.residuals) or self.rate_residuals is None:
            return f"{len(self.residuals)} records, rms {self.rms:.3g} rad"
        return f"{len(self.rate_residuals)} records, rms {self.rate_rms:.3g} rad/s"


def fitted(
    model: Model,
    observed: Observations,
    loss: Loss,
    point: Point,
    first: int,
    others: Callable[[], Sequence[Point]] = tuple,
) -> Fit:
    """The motion of least loss, from a first guess, on so many records first, or from others."""
    best = _minimum_of_all(model, observed, loss, point, first, others)
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
    covariance = covariance_at_minimum(best.normal, best.variance)
    return Fit(FreeRotation(body, spin), frozen(turns), rates, frozen(covariance))


def _spin_covariance(model: Model, body: Body, best: Linearised) -> FloatArray:
    """The covariance (9, 9) of the spin."""
    point = best.point
    speed = float(np.linalg.norm(point.omega)) or 1.0
    factor = bounded_factor(best.normal, best.variance, speed)
    axes = body.principal_axes
    # Turns of equal axes are infinite, and left out below.
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        chain = model.chain(point, model.logarithms(point.shape, axes), axes)
        state, turns = chain.state.copy(), chain.turns.copy()
        spread = np.sum((turns @ factor) ** 2, axis=1)
    turns[~(spread < _UNCERTAIN**2)] = 0.0
    omega = axes.T @ point.omega
    state[:3, 6:] = (quaternion.matrix(point.wxyz) @ axes @ turns)[:, 6:]
    state[3:6, 6:] = np.cross(omega, turns.T).T[:, 6:]
    state[3:6] = axes @ state[3:6]
    errors = state @ factor
    product: FloatArray = errors @ errors.T
    return 0.5 * (product + product.T)


def _rms(vectors: FloatArray) -> float:
    if not len(vectors):
        return np.nan
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))
