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
from attitude.fitting._model import Model, Point
from attitude.fitting._observations import Rates
from attitude.frames import quaternion
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import BoolArray, FloatArray, IntArray, Real, Reals
    from attitude.fitting._model import Prediction
    from attitude.fitting._observations import Observations


# ---- Robust losses: how much a record counts whose residual is large
# A loss rho is a function of z, the square of a residual over that of its standard error times
# `f_scale`; rho(z) is z for small z.  The names are those of scipy.optimize.least_squares, but a
# residual is the whole vector of a record, so that a result does not depend on the axes.

NAMES = ("linear", "soft_l1", "huber", "cauchy")
# Factor of the scale of a robust loss in the stages before the last one.
_WIDE = 30.0


@dataclass(frozen=True)
class Loss:
    """A loss and its scale."""

    name: str  # one of `NAMES`
    scale: float  # in standard errors: where residuals begin to count as outliers
    usual: float | None = None  # the standard error of a residual times its weight, if known

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
_MOST = 1000
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
# The same, beyond a step of half a turn, from which turns are not counted: a sixth of that.
_COUNTED = 0.5
# Rms, rad, of residuals that are right in any case, and of those that are large where errors are
# not known.
_NEGLIGIBLE = 1e-9
_LARGE = 0.1
# Share of the records of each half of them that are no outliers, at least, and the square of
# residuals that is usual, in numbers that a record measures.
_INLIERS = 0.5
_USUAL = 1.7
# Correlation of residuals with neighbours, up to so many records away, from which they are alike.
_ALIKE = 0.3
_LAGS = 8
# Misfit up to which residuals that are not alike count as errors that are given too small.
_EXCUSED = 5.0
# Misfit from which a warning is given.
_UNEXPLAINED = 2.0
# Sine of the angle between momentum and angular velocity up to which a rotation is nearly steady.
_WOBBLE = 0.05
# Decrease of the cost, in variances of a record, from which a wobble is evident: 20 of chi2; and
# how many times that is a wobble whose minimum is plain.
_EVIDENT = 10.0
_PLAIN = 10.0
# Frequencies of a wobble that are tried, and records for that, at most.
_MOST_WOBBLES = 400
# Those from which the iteration begins, at most: until one is lower than others promise.
_BEST = 24
# Epochs of prediction.
_PREDICTED = 64
# Variance, rad2, of each component of the rotation vector of an attitude of which nothing is known:
# a third of pi^2/3 + 2, the mean square of the angle of uniformly random rotations.
UNKNOWN = (np.pi**2 / 3.0 + 2.0) / 3.0


@dataclass(frozen=True)
class Linearised:
    """The loss near a point.

    variance: of the records, in units of their standard errors: that of residuals as large as
        these; without more numbers than parameters the given one, or infinite.
    bending, normal: the second derivatives (P, P) of the cost, from first ones of the residuals:
        with the weights of the loss, and with those of the standard errors alone.
    """

    point: Point
    predicted: Prediction
    cost: float  # half the sum of the losses
    gradient: FloatArray  # (P,), the direction of descent: minus the derivative of the cost
    variance: float
    bending: FloatArray
    normal: Decomposed
    gap: int = 0  # number of the record before which turns are not counted; 0: none


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
        freedom = numbers - int(np.count_nonzero(by_errors.values > _LOST))
        # Huber's variance of a robust estimate; that of least squares with a linear loss.
        variance = score / max(freedom, 1) / max(bend / max(numbers, 1), _LEAST_BEND) ** 2
        if freedom <= 0:
            variance = np.inf if self.loss.usual is None else self.loss.usual**2
        bending = weighted if robust else normal
        return Linearised(point, predicted, cost, gradient, variance, bending, by_errors)

    def minimum(self, point: Point, *, last: bool = True) -> Linearised:
        """The loss near the point of least loss, from a point near it."""
        lowest = 0.5 * records.floor(self.observed, float(np.linalg.norm(point.omega)))
        share = _LAST if last else _LAST_EARLY

        def enough(states: NDArray[Any]) -> FloatArray:
            gain = share * states[0].variance
            return np.array([max(gain if gain < np.inf else 0.0, lowest)])

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
    model: Model,
    observed: Observations,
    loss: Loss,
    point: Point,
    first: int,
    *,
    is_start: bool = False,
) -> Linearised:
    """The loss near its least point, from a first guess, or from a start that the caller gives.

    Stages take the first records, so many that no phase of a tumbler is wrong by a revolution: the
    next stage extends to where attitudes are predicted to `_REACH`.  From a start, and from the
    stage before a gap that is longer, the loss of all records is minimised at once too.
    """
    total, count, gap = len(observed), min(first, len(observed)), 0
    start, before = [point] if is_start else [], []
    while count < total or total > _MOST_RECORDS or loss.robust:
        stage = Problem(model, observed.at(thinned(count)), loss.wide).minimum(point, last=False)
        point = stage.point
        if count == total:
            break
        reach, error = _reach(model, observed, stage, count)
        turns = np.diff(observed.t) * float(np.linalg.norm(point.omega))
        gaps = np.flatnonzero(turns > np.pi) + 1
        if reach == count and count in gaps:
            before = [point]
            gap = count if error > _COUNTED else gap
        ends = [max(int(1.5 * count), count + 1), *gaps[gaps >= max(reach, count + 1)][:1]]
        count = min(max(reach, int(min(ends))), total)
    problem = Problem(model, observed, loss)
    trials = [problem.minimum(trial) for trial in (point, *before, *start)]
    best = min(trials, key=lambda trial: trial.cost)
    return replace(best, gap=0 if is_start else gap)


def _minimum_of_all(
    model: Model,
    observed: Observations,
    loss: Loss,
    point: Point,
    first: int,
    others: Callable[[], Sequence[Point]],
    is_start: bool,
) -> Linearised:
    """The loss near its least point, from a first guess or, where that fails, from others.

    A warning says that none explains the records.
    """
    best = minimum_of_stages(model, observed, loss, point, first, is_start=is_start)
    best = _steady(model, observed, loss, best)
    misfit = misfit_of(observed, loss, best)
    if misfit <= 1.0:
        return best
    for other in others():
        with suppress(AttitudeError):
            trial = minimum_of_stages(model, observed, loss, other, first)
            trial = _steady(model, observed, loss, trial)
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
        halves = np.array_split(squares, 2) if loss.robust else ()
        typical = max((np.quantile(half, _INLIERS) for half in halves), default=np.mean(squares))
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
    if variance == np.inf:
        return np.diag(np.full(len(normal.scale), np.inf))
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


def _reach(
    model: Model, observed: Observations, stage: Linearised, count: int
) -> tuple[int, float]:
    """The number of first records that are predicted to `_REACH`, and the error of the next one."""
    ahead = thinned(len(observed), count, _PREDICTED)
    records_ahead = observed.at(ahead)
    try:
        predicted = model.predict(stage.point, records_ahead.t, rates=records_ahead.with_rates)
    except AttitudeError:
        return count, 0.0
    speed = float(np.linalg.norm(stage.point.omega)) or 1.0
    factor = bounded_factor(stage.normal, stage.variance, speed)
    square = np.zeros(len(ahead))
    for kind in records_ahead.kinds:
        errors = factor.T @ (kind.compare(predicted)[1] / kind.scale())
        square = np.maximum(square, np.sum(errors**2, axis=(0, 1)))
    error = float(np.sqrt(square[0]))
    beyond = np.append(np.flatnonzero(square > _REACH**2), len(ahead))[0]
    if beyond == 0 or beyond == len(ahead):
        return (count if beyond == 0 else len(observed)), error
    # The records between may have a gap: which of them is the first one that is not predicted?
    low, high = ahead[beyond - 1] + 1, ahead[beyond]
    if low == high:
        return int(high), error
    return _reach(model, observed.at(slice(high + 1)), stage, int(low))[0], error


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
        Of the parameters, for records whose errors are as large as the residuals (with no more
        numbers than parameters, as large as `sigma`; without it infinite): turn of the
        first attitude (3, rad, body axes), angular velocity then (3, rad/s), logarithms of the
        second moments of mass (the rest: 2 of the diagonal, with axes="free" 3 more, xy, xz, yz).
        Infinite for parameters that the records leave undetermined.

    Notes
    -----
    The covariance of the spin is finite.  Combinations of parameters that the records leave
    undetermined have there the variance 1.76 of an attitude of which nothing is known (rad2; the
    angular velocity in units of its size; the logarithms of the second moments).  A given body, or
    the sphere of a steady rotation, counts as exact.  With axes="free" the errors of attitude and
    angular velocity are those of the principal axes: the nine parameters of a spin hold no errors
    of their directions in the body, which do not grow with time; these are in `covariance`.  Errors
    of more than 0.05 rad are those of equal axes of a nearly symmetric body, and are left out of
    the covariance of the spin.
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
    *,
    is_start: bool,
) -> Fit:
    """The motion of least loss, from a first guess, on so many records first, or from others.

    is_start: whether the first guess is a start that the caller gives.
    """
    best = _minimum_of_all(model, observed, loss, point, first, others, is_start)
    for said in _open_questions(best):
        warnings.warn(said, AttitudeWarning, stacklevel=4)
    point, lost = best.point, model.count - len(best.gradient)
    body = model.body_of(np.pad(point.shape, (0, lost)))
    if lost:
        model = Model(body, "principal")
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
    covariance = np.diag(np.full(len(best.gradient) + lost, np.inf))
    covariance[: len(best.gradient), : len(best.gradient)] = covariance_at_minimum(
        best.normal, best.variance
    )
    return Fit(FreeRotation(body, spin), frozen(turns), rates, frozen(covariance))


def _steady(model: Model, observed: Observations, loss: Loss, best: Linearised) -> Linearised:
    """The loss near its least point, of a sphere where the wobble of no body is evident.

    That of a nearly steady rotation has a minimum for each frequency of the wobble: all are tried.
    """
    moments, axes = model.principal(best.point.shape)
    omega = best.point.omega @ axes
    momentum = moments * omega
    size = float(np.linalg.norm(omega) * np.linalg.norm(momentum))
    is_steady = np.linalg.norm(np.cross(omega, momentum)) <= _WOBBLE * size
    if model.body is not None or not is_steady or best.variance == np.inf:
        return best
    start = Point(best.point.wxyz, best.point.omega, np.zeros(0))
    sphere = Problem(Model(Body(moments=np.ones(3)), "principal"), observed, loss).minimum(start)
    least = _EVIDENT * best.variance + records.floor(observed, float(np.linalg.norm(omega)))
    if sphere.cost > least and sphere.cost - best.cost < _PLAIN * least:
        few = Problem(model, observed.at(thinned(len(observed), most=_MOST_WOBBLES)), loss)
        shapes = _shapes_of_wobbles(model, sphere.point.omega, float(observed.t[-1]))
        wobbles = [few.linearised(replace(sphere.point, shape=shape)) for shape in shapes]
        promised = np.array([_promised(wobble) for wobble in wobbles])
        point, lowest = best.point, few.linearised(best.point).cost
        for k in np.argsort(promised, kind="stable")[:_BEST]:
            if lowest <= promised[k]:
                break
            is_evident = bool(wobbles[k].cost - promised[k] > least)
            trial = few.minimum(wobbles[k].point, last=is_evident)
            if trial.cost < lowest:
                point, lowest = trial.point, trial.cost
        best = replace(Problem(model, observed, loss).minimum(point), gap=best.gap)
    return replace(sphere, gap=best.gap) if sphere.cost - best.cost < least else best


def _promised(linearised: Linearised) -> float:
    """The cost after Gauss and Newton's step."""
    step = linearised.normal.inverse_factor(_LOST).T @ linearised.gradient
    return linearised.cost - 0.5 * float(step @ step)


def _shapes_of_wobbles(model: Model, omega: FloatArray, span: float) -> FloatArray:
    """Shapes (K, P - 6), symmetric about the axis of rotation, with wobbles half a cycle apart."""
    speed = float(np.linalg.norm(omega))
    axis = omega / (speed or 1.0)
    if model.axes == "principal":
        axis = np.eye(3)[np.argmax(np.abs(omega))]
    # Their frequencies, relative to the rotation, are those ratios.
    ratios = np.linspace(-1.0, 1.0, int(min(2.0 * speed * span / np.pi, _MOST_WOBBLES)) + 4)[1:-1]
    matrix = np.eye(3) - 3.0 * np.outer(axis, axis)
    elements = matrix[[0, 1, 0, 0, 1], [0, 1, 1, 2, 2]][: model.count - 6]
    return np.arctanh(ratios)[:, None] / 1.5 * elements


def _open_questions(best: Linearised) -> list[str]:
    """Sentences on what the records do not determine."""
    sentences = []
    if best.gap:
        sentences.append(
            f"turns between records {best.gap - 1} and {best.gap} (from 0) are not counted: the "
            f"records before predict the attitude to {_COUNTED:g} rad or worse there, so that "
            "motions of other numbers of turns may fit as well. Give records between, the body, "
            "or a motion near the truth, start=FreeRotation(...)."
        )
    if best.variance == np.inf:
        sentences.append(
            "the records have no more numbers than the motion has parameters, and residuals say "
            "nothing about their errors: those of the motion count as unknown. Give sigma=."
        )
    return sentences


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
