"""`refine`: a motion and a shape from a start, with impulses or torques that are found too."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude.catalog import motion_of
from attitude.inversion import _errors, _moving, _problem, _refinement, _shapes, _states
from attitude.inversion._ellipsoid import OF_SHAPE
from attitude.inversion._problem import usable
from attitude.inversion._settings import DEFAULT
from attitude.inversion._shapes import MODES
from attitude.inversion._solution import CurveFit, Solution
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._evidence import Weighted
    from attitude.inversion._moving import Motion, MovingPoint, MovingState
    from attitude.inversion._problem import CurveProblem
    from attitude.motions._body import Body
    from attitude.motions._published import Published
    from attitude.motions._uncertainty import Uncertain
    from attitude.photometry._curve import LightCurve
    from attitude.scattering._law import Law
    from attitude.torques._arcs import Impulse
    from attitude.torques._torque import Torque


# Least frequency of a curve's averages, turns per span, if the start turns slower.
_LEAST_TURNS = 5.0


class Refinement(CurveFit):
    """A motion and a shape that fit a light curve; made by `refine`.

    Attributes
    ----------
    curve, weighted, evidence
        As in `CurveFit`.
    point : MovingPoint
        The state and the changes of the motion.
    rank, relation : int, str
        Among the solutions of `spin_states` for a known shape.
    rivals : tuple of (P,) arrays and floats
        Other minima near this one, found by `spin_states`: their parameters less those of this one,
        and by how much their evidence is larger.
    """

    weighted: Weighted[MovingState]

    def __init__(
        self,
        curve: LightCurve,
        weighted: Weighted[MovingState],
        problem: CurveProblem,
        fit: _moving.MovingFit,
        body: Body,
        *,
        rank: int = 0,
        relation: str = "best",
        rivals: tuple[tuple[FloatArray, float], ...] = (),
    ) -> None:
        super().__init__(curve, weighted, problem, rank, relation)
        self._fit = fit
        self._body = body
        self.point: MovingPoint = weighted.refined.state.point
        self.rivals = rivals

    @property
    def _is_known(self) -> bool:  # type: ignore[override]
        return self._fit.known is not None

    @property
    def moments(self) -> FloatArray:
        """(3,) principal moments at the epoch, ascending, in the unit of the body."""
        return np.sort(self.point.body.moments)

    @cached_property
    def covariance(self) -> FloatArray:
        """(P, P): turn (rad, ICRF), rates (rad/s), ln of two ratios of moments, the changes.

        As in `Solution.covariance`, with the error of the model by the jackknife and the spread of
        `rivals`; with impulses, torques or a shape that is found too, the covariance is that of the
        curvature in place of second moments.
        """
        problem, state = self.weighted.problem, self.weighted.refined.state

        def refitted(keep: BoolArray) -> FloatArray | None:
            again = self._fit.minimum(problem.part(keep), state, gain=1e-4)
            return again.fitted.state.point.difference(self.point)

        with _refinement.limited():
            errors_of = _errors.errors(
                self.weighted,
                self._model(problem),
                self._groups,
                self.point.size,
                refitted,
                self._second_moments(),
            )
        return errors_of.covariance + _errors.spread(errors_of.covariance, self.rivals)

    def _second_moments(self) -> FloatArray | None:
        """Those of the density of a free rotation of known shape; None for other motions."""
        fit, problem = self._fit, self.weighted.problem
        if fit.known is None or self.changes:
            return None
        seconds = _moving.seconds_of(self.point, fit.epoch, problem.seconds)
        return _errors.covariance_of_state(self.weighted, self.point, seconds, fit.known, fit.least)

    @cached_property
    def motion(self) -> Motion:
        """The motion, with the covariance of its state."""
        by = self.point.by_state()
        by_state = by @ self.covariance @ by.T
        spin = self.point.spin.with_covariance(0.5 * (by_state + by_state.T))
        return self.point.motion_of(spin)

    @property
    def mode(self) -> str:
        """ "LAM", "SAM", or "PA" for rotation about one axis, of the first arc."""
        return "PA" if self.point.axis is not None else str(self._published.mode or "PA")

    @property
    def P_psi(self) -> float:
        """s; infinite for rotation about one axis."""
        return float(self._published.P_psi)

    @property
    def P_phi(self) -> float:
        """s, of the long axis about the momentum."""
        return float(self._published.P_phi)

    @property
    def pole(self) -> FloatArray:
        """Longitude and latitude of the momentum, J2000 ecliptic, rad, on the first arc."""
        return self._published.pole

    @property
    def periods_sigma(self) -> tuple[float, float]:
        """Standard errors of P_psi and P_phi (long axis), s, on the first arc."""
        return self._deviation("period_psi"), self._deviation("P_phi_L")

    @property
    def pole_sigma(self) -> float:
        """Standard error of the direction of the momentum, rad, the larger of two."""
        across = math.cos(self.pole[1]) * self._deviation("longitude")
        return max(self._deviation("latitude"), across)

    def _deviation(self, name: str) -> float:
        """The mean of the errors downward and upward of a number of `FreeRotation.deviations`."""
        return 0.5 * (self._deviations[name].minus + self._deviations[name].plus)

    @cached_property
    def _deviations(self) -> dict[str, Uncertain]:
        return FreeRotation(self.motion.body, self.motion.spin).deviations()

    @cached_property
    def _published(self) -> Published:
        return FreeRotation(self.point.body, self.point.spin).published("L", frame="ecliptic")

    @property
    def states(self) -> tuple[FreeRotation, ...]:
        """The free rotation of each arc, its spin at the beginning of the arc."""
        motion = self.point.motion
        starts = np.concatenate([[0.0], motion.joints])
        motions = []
        for begin in starts:
            attitude = motion.at(float(begin))
            spin = Spin(motion.epoch.after(float(begin)), attitude.wxyz, attitude.angular_velocity)
            motions.append(FreeRotation(self.point.body, spin))
        return tuple(motions)

    @property
    def changes(self) -> tuple[Impulse | Torque, ...]:
        """The impulses or torques with the numbers that were found."""
        return self.point.changes

    @property
    def _is_changing(self) -> bool:
        return bool(self.changes)

    @property
    def values(self) -> FloatArray:
        """Their numbers: momenta and torques over their axes, W/m2 of sunlight."""
        return self.point.values

    @property
    def values_sigma(self) -> FloatArray:
        """Standard errors of `values`."""
        return np.sqrt(np.diag(self.covariance)[_moving.STATE :])

    @cached_property
    def shape(self) -> Mesh:
        """The closed convex mesh of the areas, of the volume of the unit sphere; or that given."""
        if self._fit.known is None:
            return super().shape
        return self._fit.known.over(self._body.principal_axes.T).mesh

    @property
    def law(self) -> Law:
        """The scattering law without its phase function, which the linear terms replace."""
        return super().law if self._fit.known is None else self._fit.known.law

    def _model(self, problem: CurveProblem) -> _refinement.ShapeModel:
        """Magnitudes and their derivatives at the epochs of a problem."""
        return self._fit.model(problem, self.weighted.refined.state)


def refine(
    curve: LightCurve,
    start: Solution | Refinement | Motion | str,
    *,
    arcs: Impulse | Sequence[Impulse] | None = None,
    torques: Torque | Sequence[Torque] | None = None,
    shape: str | Mesh = "convex",
    law: str | Law | None = None,
    moments: str | float | Body | Sequence[float] = "shape",
) -> Refinement:
    """The motion and the shape near a start that fit a light curve best.

    Parameters
    ----------
    curve : LightCurve
    start : Solution, Refinement, FreeRotation, Arcs, TorquedRotation, or name in the catalogue
        A motion near the truth at its epoch; a solution brings its shape too.  Rotation about one
        principal axis stays that: a torque that is found acts along the axis alone.
    arcs : Impulse or sequence of them, optional
        Changes of the momentum at known epochs, such as an encounter with a planet: their momenta
        are found, from those given.  One shape, a spin state on either side.  They lie between
        points of the curve, in order of time, after the epoch of the start: that of a solution is
        the middle of the curve, and an earlier start ``FreeRotation(body, motion.spin_at(date))``.
    torques : Torque or sequence of them, optional
        A `ConstantTorque` is found, and the strength of a `SolarRadiation` (YORP); other torques
        are taken as known.
    shape : str or Mesh
        "convex" or "ellipsoid", found too; or a known mesh.
    law : str or Law, optional
        Of a known mesh.
    moments
        As in `spin_states`; moments that are given, and those of the start with a known mesh, stay.

    Returns
    -------
    Refinement

    Raises
    ------
    AttitudeError
        For other kinds of start and change, arcs together with torques, impulses outside of the
        curve or not after the start, and a start without magnitudes at the epochs of the curve.

    Notes
    -----
    Derivatives are exact: of free motion in closed form, of arcs by the chain of their joints, of
    torques those of the scheme with its steps.  Where the start does not fit the whole curve, the
    points near its epoch are fitted first, then more and more.
    """
    curve = usable(curve)
    motion, chosen_shape = _start(start)
    tie = _states.of(moments)
    if isinstance(start, Solution):
        tie = replace(tie, is_wide=start.tie.is_wide)
    ends = float(curve.emission[0]), float(curve.emission[-1])
    point = _moving.moving_point(motion, curve.epoch, ends, arcs, torques)
    if tie.moments is not None:
        point = _states.with_moments(point, tie.moments)
    known = None
    if isinstance(shape, Mesh):
        known = _shapes.known(shape, law).over(motion.body.principal_axes)
        params = np.zeros(0)
    else:
        validation.one_of(shape, "shape", ("convex", "ellipsoid"))
        params = chosen_shape if chosen_shape is not None else _ellipsoid(point.body.moments)
        if shape == "ellipsoid":
            params = np.concatenate([params[:2], np.zeros(MODES)])
    rate = float(np.linalg.norm(point.spin.angular_velocity)) / (2.0 * math.pi)
    most = 3.0 * max(rate, _LEAST_TURNS / curve.span)
    zero_points = curve.zero_points
    for _ in range(2):
        problem, _ = _problem.problem(
            curve, most, DEFAULT.ellipsoid_error, zero_points, is_known=known is not None
        )
        fit = _moving.moving_fit(curve.epoch, problem, point, known, tie, shape == "ellipsoid")
        with _refinement.limited():
            fitted = fit.weighted(problem, _moving.MovingState(point, params))
        offsets = problem.offsets(fitted.refined.magnitude)
        if zero_points != "auto" or not _problem.are_free(offsets):
            break
        zero_points = "free"
    return Refinement(curve, fitted, problem, fit, motion.body)


def _start(start: Any) -> tuple[Any, FloatArray | None]:
    """The motion of a start and the parameters of its shape, if it has one."""
    if isinstance(start, Solution):
        return start.motion, start.state[OF_SHAPE].copy()
    if isinstance(start, Refinement):
        shape = start.weighted.refined.state.shape
        return start.point.motion, shape if len(shape) else None
    return motion_of(start) if isinstance(start, str) else start, None


def _ellipsoid(moments: FloatArray) -> FloatArray:
    """The parameters of the homogeneous ellipsoid with given moments."""
    squares = np.maximum(0.5 * moments.sum() - moments, 1e-3 * moments.max())
    parameters = np.zeros(_shapes.SIZE)
    parameters[:2] = np.log(squares[2] / squares[:2])
    return parameters
