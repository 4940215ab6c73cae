"""Motions with parameters, and their least squares with a shape to a light curve.

A motion is a free rotation, one that impulses divide, or one under torques.  A point has a body
whose principal axes are its axes, a spin, and changes with numbers to find: the momentum of each
impulse (3), a torque that is fixed in the body (3), the strength of sunlight (1).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.inversion import _evidence, _refinement, _shapes
from attitude.inversion._refinement import Evaluation, Fitted, ShapeModel
from attitude.motions._body import Body
from attitude.motions._differentiable import changed
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.torques._arcs import Arcs, Impulse
from attitude.torques._radiation import SolarRadiation
from attitude.torques._system import NODES
from attitude.torques._torque import ConstantTorque, Torque
from attitude.torques._torqued import TorquedRotation
from attitude.torques._triggers import Trigger

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.epochs._instants import Instant
    from attitude.inversion._evidence import Weighted
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._shapes import KnownShape


Motion = FreeRotation | Arcs | TorquedRotation
# Parameters of the state: turn (rad, ICRF), rates (rad/s), ln I1/I3, ln I2/I3.
STATE = 8
# Error of the attitudes of torqued motions, rad: some 1e-4 mag.
_TOLERANCE = 1e-4
# Rates across a principal axis, over that about it, of rotation about one axis.
_ABOUT_ONE = 1e-12
# Step of the differences by a torque: a share of the torque that would stop the body in the span.
# A kick is linear in the torque.
_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class MovingPoint:
    """A state and the changes of the motion from then on."""

    body: Body
    spin: Spin  # of ICRF axes
    impulses: tuple[Impulse, ...]
    torques: tuple[Torque, ...]
    reach: tuple[float, float]  # first and last epoch of the curve, s since that of the spin

    @property
    def size(self) -> int:
        """The number of parameters."""
        return STATE + len(self.values)

    @property
    def changes(self) -> tuple[Impulse | Torque, ...]:
        """The impulses and torques."""
        return (*self.impulses, *self.torques)

    @property
    def axis(self) -> int | None:
        """The number of the principal axis about which the body rotates; None if it tumbles."""
        rates = np.abs(self.spin.angular_velocity)
        axis = int(np.argmax(rates))
        return axis if np.delete(rates, axis).max() <= _ABOUT_ONE * rates[axis] else None

    @property
    def motion(self) -> Motion:
        """The motion."""
        return self.motion_of(self.spin)

    def motion_of(self, spin: Spin) -> Motion:
        """The motion from another spin, such as the same with a covariance."""
        if self.impulses:
            return Arcs(self.body, spin, self.impulses)
        if self.torques:
            low, high = min(self.reach[0], 0.0), max(self.reach[1], 0.0)
            return TorquedRotation(
                self.body, spin, self.torques, tolerance=_TOLERANCE, span=(low, high)
            )
        return FreeRotation(self.body, spin)

    @property
    def log_ratios(self) -> FloatArray:
        """ln I1/I3 and ln I2/I3 (2,)."""
        return np.log(self.body.moments[:2] / self.body.moments[2])

    @property
    def values(self) -> FloatArray:
        """The numbers of the changes: momenta, torques (3 each), flux of sunlight in W/m2."""
        return np.concatenate([np.zeros(0), *map(_numbers, self.changes)])

    def attitudes(self, seconds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation matrices (N, 3, 3) to ICRF and rotation vectors (N, 3, P) by the parameters."""
        motion = self.motion
        matrix = motion.at(seconds).matrix
        if self.torques:
            assert isinstance(motion, TorquedRotation)
            sensitivities = motion.sensitivity_with_torques(self._others())
            columns = sensitivities.at(seconds, None, False)[0]
        else:
            columns = motion._sensitivity.at(seconds, None, False)[0]
            if isinstance(motion, Arcs):
                more = motion._sensitivity.by_momenta(seconds, None)[0]
                columns = np.concatenate([columns, more], axis=-1)
        slopes = np.delete(columns, 8, axis=-1)
        slopes[..., 6:8] *= self.body.moments[:2]
        return matrix, slopes

    def difference(self, origin: MovingPoint) -> FloatArray:
        """The parameters (P,) of this point from those of another."""
        turn = quaternion.multiply(self.spin.wxyz_icrf, quaternion.conjugate(origin.spin.wxyz_icrf))
        rates = self.spin.angular_velocity - origin.spin.angular_velocity
        ratios = self.log_ratios - origin.log_ratios
        values = self.values - origin.values
        return np.concatenate([forms.to_rotation_vector(turn), rates, ratios, values])

    def by_state(self) -> FloatArray:
        """Changes (9, P) of the state of `Spin.covariance` for unit changes of the parameters."""
        jacobian = np.zeros((9, self.size))
        jacobian[range(6), range(6)] = 1.0
        jacobian[6, 6], jacobian[7, 7] = self.body.moments[:2]
        return jacobian

    def moved(self, step: FloatArray) -> MovingPoint | None:
        """The point after a step of limited length; None if that is no body's."""
        longest = max(
            float(np.linalg.norm(step[:3])) / 0.5,
            float(np.abs(step[6:8]).max()) / 0.3,
            1.0,
        )
        step = step / longest
        changes = np.concatenate([step[:6], self.body.moments[:2] * np.expm1(step[6:8]), [0.0]])
        try:
            body, spin = changed(self.body, self.spin, changes)
        except AttitudeError:
            return None
        impulses, torques = self._changed(self.values + step[STATE:])
        return MovingPoint(body, spin, impulses, torques, self.reach)

    def _changed(self, values: FloatArray) -> tuple[tuple[Impulse, ...], tuple[Torque, ...]]:
        """The changes with other numbers."""
        changes: list[Any] = []
        for change in self.changes:
            count = len(_numbers(change))
            changes.append(_with_numbers(change, values[:count]))
            values = values[count:]
        first = len(self.impulses)
        return tuple(changes[:first]), tuple(changes[first:])

    def _others(self) -> list[tuple[float, list[tuple[Torque, ...]]]]:
        """A step for each number of the torques, and the torques there."""
        values = self.values
        length = max(self.reach[1] - self.reach[0], 1e-9)
        momentum = float(np.linalg.norm(self.body.tensor @ self.spin.angular_velocity))
        owners = [change for change in self.changes for _ in _numbers(change)]
        pairs_of = []
        for k, (value, owner) in enumerate(zip(values, owners, strict=True)):
            is_flux = isinstance(owner, SolarRadiation)
            size = _SHARE * (max(abs(float(value)), 1e-9) if is_flux else momentum / length)
            many = []
            for node in NODES:
                other = values.copy()
                other[k] += node * size
                many.append(self._changed(other)[1])
            pairs_of.append((size, many))
        return pairs_of


def moving_point(
    start: Motion, epoch: Instant, reach: tuple[float, float], arcs: Any, torques: Any
) -> MovingPoint:
    """The point of a motion and of changes that are given, at the epoch of its spin."""
    if not isinstance(start, (FreeRotation, Arcs, TorquedRotation)):
        raise AttitudeError(
            f"start is {type(start).__name__}; give a Solution or Refinement, a FreeRotation, Arcs "
            "or a TorquedRotation."
        )
    if arcs is None and isinstance(start, Arcs):
        arcs = start.changes
    if torques is None and isinstance(start, (Arcs, TorquedRotation)):
        torques = start.torques
    impulses, loads = _listed(arcs, Impulse, "arcs"), _listed(torques, Torque, "torques")
    if impulses and loads:
        raise AttitudeError("arcs and torques are both given; give one of them.")
    for k, impulse in enumerate(impulses):
        if callable(impulse.angular_momentum) or isinstance(impulse.at, Trigger):
            raise AttitudeError(
                f"arcs[{k}] depends on the motion; give an Impulse at an epoch with three numbers."
            )
    body, spin = start.body, start.spin
    axes = body.principal_wxyz
    wxyz = quaternion.multiply(spin.wxyz_icrf, axes)
    omega = spin.angular_velocity @ body.principal_axes
    body_alone = Body(moments=body.moments, relative=body.relative, mass=body.mass)
    moved = any(impulse.frame == "body" for impulse in impulses) or bool(loads)
    if moved and not np.allclose(body.principal_axes, np.eye(3)):
        raise AttitudeError(
            "the axes of the body are not its principal axes, over which momenta and torques are "
            "fitted; give a Body with moments=."
        )
    shift = epoch.seconds - spin.epoch.seconds
    ends = reach[0] + shift, reach[1] + shift
    point = MovingPoint(body_alone, Spin(spin.epoch, wxyz, omega), impulses, loads, ends)
    for k, time in enumerate(point.motion.joints if impulses else ()):
        if not ends[0] < time < ends[1]:
            raise AttitudeError(
                f"arcs[{k}] at {impulses[k].at} lies {'before' if time <= ends[0] else 'after'} "
                "all points of the light curve, which then says nothing of its momentum; leave it "
                "out."
            )
    return point


def seconds_of(point: MovingPoint, epoch: Instant, seconds: FloatArray) -> FloatArray:
    """Seconds since the epoch of a point's spin, of seconds (N,) since another epoch."""
    return seconds + epoch.since(point.spin.epoch)


def _listed(changes: Any, kind: type, name: str) -> tuple[Any, ...]:
    """Impulses or torques that a caller gives, as a tuple of one kind."""
    if changes is None:
        return ()
    if isinstance(changes, kind):
        changes = (changes,)
    if not isinstance(changes, Iterable):
        raise AttitudeError(f"{name} is {changes!r}; give a list of {kind.__name__} objects.")
    items = tuple(changes)
    for k, item in enumerate(items):
        if not isinstance(item, kind):
            raise AttitudeError(f"{name}[{k}] is {item!r}; give {kind.__name__} objects.")
    return items


def _numbers(change: Impulse | Torque) -> FloatArray:
    """The numbers of a change that are found; torques of other kinds are known."""
    if isinstance(change, Impulse):
        return np.asarray(change.angular_momentum, float)
    if isinstance(change, ConstantTorque):
        return np.asarray(change.torque, float)
    return np.array([change.flux]) if isinstance(change, SolarRadiation) else np.zeros(0)


def _with_numbers(change: Impulse | Torque, values: FloatArray) -> Impulse | Torque:
    if isinstance(change, Impulse):
        return Impulse(change.at, values, change.frame)
    if isinstance(change, ConstantTorque):
        return ConstantTorque(values)
    if isinstance(change, SolarRadiation):
        radiation = SolarRadiation(change.shape, change.path, change.diffuse, change.mirrored)
        radiation._set("flux", float(values[0]))  # a fit may make the strength negative
        return radiation
    return change


# ---- Least squares of a motion with parameters and a shape, convex or known, to a light curve

# Shares of the points, those nearest in time to the epoch of the start, that are fitted first.
_STAGES = (0.25, 0.4, 0.6, 0.8)
# Iterations of a fit of some of the points, and where a fit begins anew.
_ITERATIONS = 12
# Iterations of a fit that is to end at its minimum.
_LAST = 40
# Mean square of residuals over the errors, above which the points are fitted in stages too.
_BAD = 1.5


@dataclass(frozen=True, eq=False)
class MovingState:
    """A point and the parameters of a convex shape, none for a known one."""

    point: MovingPoint
    shape: FloatArray


@dataclass(frozen=True, eq=False)
class MovingFit:
    """What is fitted."""

    epoch: Instant  # of the curve
    known: KnownShape | None  # None for a convex shape, which is found too
    least: float  # flux of a known shape that counts as dark
    tie: _shapes.Tie  # of the moments of motion and shape
    fixed: BoolArray  # (P,), parameters that stay
    is_axial: bool = False  # rotation about the third axis, that of the shape's largest moment

    def model(self, problem: CurveProblem, state: MovingState) -> ShapeModel:
        """The magnitudes of a state, means over exposures, with derivatives."""
        point, nodes = state.point, problem.at_nodes
        seconds = seconds_of(point, self.epoch, nodes.seconds)
        matrix, slopes = point.attitudes(seconds)
        sun = np.ascontiguousarray(np.einsum("nij,in->nj", matrix, nodes.sun))
        observer = np.ascontiguousarray(np.einsum("nij,in->nj", matrix, nodes.observer))
        if self.known is None:
            lit = _shapes.magnitudes(sun, observer, state.shape)
        else:
            lit = self.known.lit(sun, observer, self.least)

        def by_motion() -> tuple[FloatArray, FloatArray]:
            across = np.einsum("nij,nj->ni", matrix, lit.across)
            of_motion = np.einsum("ni,nip->pn", across, slopes)
            return of_motion, of_motion[:0]

        return ShapeModel(problem, lit, by_motion)

    def at(self, problem: CurveProblem, state: MovingState) -> Evaluation[MovingState]:
        """A state with its cost."""
        computed = self.model(problem, state)
        priors = self._priors(state, computed.lit)
        return _refinement.evaluated(problem, state, computed, priors, self.fixed)

    def _priors(self, state: MovingState, lit: _shapes.BodyLight) -> _shapes.Priors:
        point = state.point
        if self.known is not None:
            nothing = np.zeros(point.size)
            return _shapes.Priors(np.zeros(0), np.zeros((0, point.size)), 0.0, nothing, nothing)
        moments = None
        if not self.is_axial:
            slopes = np.zeros((2, point.size))
            slopes[0, 6] = slopes[1, 7] = 1.0
            moments = _shapes.MotionMoments(point.log_ratios, slopes, False, False)
        return _shapes.penalties(state.shape, lit.areas, lit.slopes, moments, point.size, self.tie)

    def moved(self, state: MovingState, step: FloatArray) -> MovingState | None:
        """The state after a step; None outside of the bounds."""
        count = state.point.size
        shape = step[count:]
        if len(shape):
            longest = max(float(np.abs(shape[:2]).max()), float(np.abs(shape[2:]).max()) / 3.0)
            step = step * min(1.0, 0.5 / max(longest, 1e-12))
        point = state.point.moved(step[:count])
        if point is None:
            return None
        new = state.shape + step[count:]
        if len(new) and float(np.abs(new[:2]).max()) >= 6.0:
            return None
        return MovingState(point, new)

    def minimum(
        self,
        problem: CurveProblem,
        start: MovingState,
        iterations: int = _ITERATIONS,
        gain: float = 1e-3,
    ) -> Evaluation[MovingState]:
        """The state of least cost near a start."""

        def at(state: MovingState) -> Evaluation[MovingState]:
            try:
                return self.at(problem, state)
            except AttitudeError:
                return _impossible(state, len(self.fixed), len(problem))

        return _refinement.minimum(at, self.moved, start, iterations, gain)

    def weighted(self, problem: CurveProblem, start: MovingState) -> Weighted[MovingState]:
        """The state of largest posterior density, with Student's errors and a model error."""
        whole = problem.with_model_error(problem.settings.ellipsoid_error)
        best = self.minimum(whole, start, _LAST).fitted
        if best.chi_squared > _BAD * len(whole):
            grown = self._in_stages(whole, start)
            best = min(best, grown, key=lambda fit: fit.cost)
        if not math.isfinite(best.cost):
            self.at(whole, start)  # why there are none, if a motion or a shape says so
            raise AttitudeError("the start has no magnitudes at the epochs of the curve.")
        for _ in range(2):
            whole = _evidence.with_error_of(whole, best.magnitude)
            best = self.minimum(whole, best.state).fitted
        free = int(np.count_nonzero(~self.fixed[: start.point.size]))
        return _evidence.student(
            whole,
            best.state,
            lambda reweighted, state, gain: self.minimum(reweighted, state, _LAST, 0.1 * gain),
            free,
        )

    def _in_stages(self, problem: CurveProblem, start: MovingState) -> Fitted[MovingState]:
        """The least cost from fits of points near the epoch of the start, then of more."""
        seconds = seconds_of(start.point, self.epoch, problem.seconds)
        away = np.abs(seconds)
        state = start
        for share in _STAGES:
            chosen = away <= np.quantile(away, share)
            if np.count_nonzero(chosen) > 12:
                state = self.minimum(problem.part(chosen), state).fitted.state
        return self.minimum(problem, state, _LAST).fitted


def moving_fit(
    epoch: Instant,
    problem: CurveProblem,
    point: MovingPoint,
    known: KnownShape | None,
    tie: _shapes.Tie,
    is_ellipsoid: bool = False,
) -> MovingFit:
    """What is fitted to a problem from a point; moments that are given or of a known shape stay.

    A rotation about one axis stays one: rates and torques across the axis stay, and the moments,
    which do not move it.
    """
    fixed = np.zeros(point.size + (0 if known else _shapes.SIZE), bool)
    axis = point.axis
    if known is not None or tie.moments is not None or axis is not None:
        fixed[6:8] = True
    if axis is not None:
        across = [k for k in range(3) if k != axis]
        fixed[[3 + k for k in across]] = True
        at = STATE
        for change in point.changes:
            if isinstance(change, ConstantTorque):
                fixed[[at + k for k in across]] = True
            at += len(_numbers(change))
    if is_ellipsoid:
        fixed[point.size + _shapes.ELLIPSOID :] = True
    least = 0.0 if known is None else known.floor(problem.sun.T, problem.observer.T)
    is_axial = axis == 2 and tie.moments is None and int(np.argmax(point.body.moments)) == 2
    return MovingFit(epoch, known, least, tie, fixed, is_axial)


def _impossible(state: MovingState, size: int, count: int) -> Evaluation[MovingState]:
    """What a state without magnitudes is: of infinite cost."""
    fitted = Fitted(
        state,
        cost=math.inf,
        chi_squared=math.inf,
        strain=0.0,
        areas=np.zeros(0),
        magnitude=np.full(count, math.nan),
    )
    return Evaluation(fitted, lambda: (np.eye(size), np.zeros(size)))
