"""`FreeRotation`: attitudes of a body at any epoch from the state at one epoch."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from attitude import frames
from attitude._solver import codes, evaluation
from attitude._solver.elements import Elements, elements_of, state_of
from attitude._solver.regime import Mode, regime_of, regimes
from attitude._solver.sensitivities import Sensitivity
from attitude._solver.states import States
from attitude._support import markup, pairs, validation
from attitude._support.arrays import frozen, new_array
from attitude._support.constants import VERMILION
from attitude._support.synonyms import checks_arguments
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions import _conventions, _predictability, _published
from attitude.motions._body import Body
from attitude.motions._differentiable import Differentiable
from attitude.motions._motion import RateBounds
from attitude.motions._spin import Spin, refuse_others

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude._solver.regime import Regime
    from attitude._support.annotations import Epoch, EpochOrSeconds, Epochs, FloatArray, Real, Reals
    from attitude.epochs._instants import Instant
    from attitude.motions._published import Published
    from attitude.motions._uncertainty import Uncertain
    from attitude.proof._certificate import Certificate
    from attitude.proof._chain import Chain, Joint
    from attitude.proof._error_bound import ErrorBound


# ---- The state of a motion at another epoch, as a Spin with its covariance


def spin_of(motion: Any, epoch: EpochOrSeconds) -> Spin:
    """The Spin at one epoch of a motion, in the frame of its spin, or ICRF without one."""
    hi, lo = _inputs.one_since(motion.epoch, epoch, "epoch")
    history = motion.at(hi, low=lo)
    at: Instant = motion.epoch.after(hi, lo)
    spin = getattr(motion, "spin", None)
    frame = "icrf" if spin is None else spin.frame
    wxyz = history.wxyz if frame == "icrf" else _over_axes(frame, history.wxyz)
    spin_then = Spin(at, wxyz, history.angular_velocity, frame)
    if spin is None or spin.covariance is None:
        return spin_then
    return spin_then.with_covariance(_covariance(motion, hi, lo, frame))


def _over_axes(frame: str, wxyz: FloatArray) -> FloatArray:
    """Attitudes (..., 4), body to a frame, of those to ICRF."""
    return quaternion.multiply(quaternion.conjugate(frames.wxyz_to_icrf(frame)), wxyz)


def _covariance(motion: Any, hi: float, lo: float, frame: str) -> FloatArray:
    """The covariance (9, 9) there, with the attitude over the axes of a frame."""
    attitude, rates = motion.sensitivity_at(hi, lo, angular_velocity=True)
    changes = np.eye(9)
    changes[:3], changes[3:6] = frames.matrix_to_icrf(frame).T @ attitude, rates
    covariance: FloatArray = changes @ motion.spin.covariance_icrf @ changes.T
    return 0.5 * (covariance + covariance.T)


# ---- Upper bounds of the derivatives of a body-fixed direction, to prove intervals free of zeros
# A body axis a, seen from inertial axes, moves by R a with
#
#     |(R a)'| <= |w|,   |(R a)''| <= |w'| + |w|^2,   |(R a)'''| <= |w''| + 3 |w'| |w| + |w|^3.
#
# For a free rotation the greatest |w| follows from energy and momentum, and Euler's equations
# w1' = k1 w2 w3 with |k| <= 1 (no moment exceeds the sum of the others) give the rest:
# |w'|^2 <= sum k_i^2 w_j^2 w_k^2, also <= |w|^4 / 3, and |w''| <= sqrt(2) |w'| |w|.

# Factor that covers the rounding of the closed forms.
_ROUNDED = 1.0 + 1e-12


def of_free_rotation(body: Body, omega: FloatArray) -> RateBounds:
    """`RateBounds` of a free rotation from its angular velocity (3,), rad/s in body axes."""
    moments = np.asarray(body.moments)
    rates = body.rates_about_principal_axes(np.array(omega))[:, 0]
    w = float(np.max(regimes(moments, rates).spin_rate_range)) if np.any(rates) else 0.0
    rate = _acceleration(moments, rates, w)
    w, rate = w * _ROUNDED, rate * _ROUNDED
    with np.errstate(over="ignore"):  # infinity is a bound, too
        third = np.sqrt(2.0) * rate * w + 3.0 * rate * w + np.float64(w) ** 3
    return RateBounds(w, rate + w * w, float(third))


def _acceleration(moments: FloatArray, rates: FloatArray, w: float) -> float:
    """A bound of |w'|: the lower of that from the greatest components and |w|^2 / sqrt 3."""
    some = moments > 0.0
    if not w > 0.0:
        return 0.0
    scaled = rates / w
    # by a power of two, which is exact: squares of moments neither overflow nor underflow
    moments = np.ldexp(moments, -np.frexp(np.max(moments))[1])
    energy = np.sum(moments * scaled**2)
    momentum = np.sum((moments * scaled) ** 2)
    squares = np.zeros(3)
    squares[some] = np.minimum(energy / moments[some], momentum / moments[some] ** 2)
    total = 0.0
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        if some[i]:
            gain = (moments[j] - moments[k]) / moments[i]
            total += gain * gain * squares[j] * squares[k]
    share = float(min(np.sqrt(total), np.sqrt(1.0 / 3.0)))
    return w * w * share if share else 0.0


# ---- The motion

# Relative change that counts as rounding of the input: 16 units in the last place.
_ROUNDING = 16.0 * np.finfo(float).eps


_TAKES = "give body=Body(...) and spin=Spin(...)"
_HINTS = {
    **dict.fromkeys(("moments", "inertia", "tensor", "I"), f"{_TAKES}; Body takes the inertia"),
    **dict.fromkeys(("wxyz", "quaternion", "q0", "omega", "omega0"), f"{_TAKES}; Spin the state"),
    **dict.fromkeys(("angular_velocity", "w0", "epoch", "frame"), f"{_TAKES}; Spin the state"),
}


@checks_arguments(_HINTS, "FreeRotation(Body(moments=(10, 20, 26)), spin)")
@dataclass(frozen=True, eq=False, repr=False)
class FreeRotation(Differentiable):
    """Torque-free motion of a rigid body, in closed form.

    Parameters
    ----------
    body : Body
    spin : Spin

    Attributes
    ----------
    mode : Mode
        Of the exact doubles given; see also `within_rounding`.
    period_psi, period_phi : float
        s; of the rotation about the axis about which the momentum circulates (the long axis in
        long-axis mode, the short one in short-axis mode), and the mean period of that axis about
        the momentum.  Limits, or inf, in the other modes.
    momentum : (3,) array
        In ICRF, kg m2/s (in the body's unit of inertia if that is relative).
    energy : float
        J (in the body's unit of inertia if that is relative).

    Raises
    ------
    AttitudeError
        For objects of other classes; from `at`, for epochs more than 5e16 turns away.

    Notes
    -----
    Attitudes err by at most 4e-15 rad for the exact doubles given, at any epoch within 1e15 turns
    (5e-14 rad at 5e16 turns): van Zon & Schofield (2006), in the form of docs/derivation.md.
    Errors of the input limit a prediction, see `predictable_time`.

    >>> motion = FreeRotation(
    ...     Body(moments=(10, 20, 26)),
    ...     Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1)),
    ... )
    >>> motion.mode.name, round(motion.period_psi, 6), round(motion.period_phi, 6)
    ('SHORT_AXIS', 2.347113, 0.370161)
    >>> motion.at(60.0).wxyz.shape
    (4,)
    """

    # Without field(), dataclass takes None, the class attribute of Motion, as the default.
    body: Body = field()
    spin: Spin = field()
    _value = ("body", "spin")
    smooth = True
    _has_closed_form = True

    def __post_init__(self) -> None:
        body, spin = self.body, self.spin
        refuse_others(
            body, spin, "FreeRotation takes a Body and a Spin, as in FreeRotation(body, spin)"
        )
        self._constants: Any
        wxyz, low = spin.wxyz_icrf, None
        if spin.is_rounded:
            low = spin.wxyz_icrf_as_pairs[None, :, 1].copy()
        rates, differences = body.over_principal_axes(spin.angular_velocity)
        states = States(
            body.moments_as_pairs[None],
            body.principal_wxyz[None],
            rates,
            differences,
            wxyz[None],
            low,
        )
        solved = states.solved()
        if len(solved.bad):
            raise AttitudeError(solved.fault(0))
        self.__dict__["_constants"] = frozen(solved.constants)

    # ---- Construction

    @classmethod
    def from_elements(
        cls,
        elements: Elements | Sequence[float],
        *,
        epoch: Epoch,
        wxyz: Reals,
        frame: str = "icrf",
        largest_moment: Real | None = None,
    ) -> Self:
        """The motion with given elements.

        Parameters
        ----------
        elements : Elements or five numbers
            precession_rate, nutation_rate (rad/s), phase (rad), rho, X; see
            `elements`.
        epoch, wxyz, frame
            As for `Spin`: attitude at the epoch of the principal axes in the order of the solution
            (the momentum circulates about the third, the second is the middle one).
        largest_moment : float or Quantity, optional
            kg m2.  Without it the moments are relative, the largest being 1.

        Raises
        ------
        AttitudeError
            For elements outside their range, and elements that no body has.
        """
        numbers = validation.real(elements, "elements", shape=(5,), finite=False)
        moments, omega = state_of(Elements(*numbers.tolist()))
        if largest_moment is not None:
            moments *= validation.positive(largest_moment, "largest_moment", unit="kg m2")
        body = Body(moments=moments, relative=largest_moment is None)
        return cls(body, Spin(epoch, wxyz, omega, frame))

    def _with(self, body: Body, spin: Spin) -> Self:
        return type(self)(body, spin)

    def __reduce__(self) -> tuple[Any, ...]:
        # The constants are computed anew: their record may change between versions.
        return FreeRotation, (self.body, self.spin)

    # ---- Text

    def __repr__(self) -> str:
        return f"<FreeRotation: {self.mode.name}, from {self.spin.epoch.utc_iso} UTC>"

    def __str__(self) -> str:
        from attitude.motions._description import description

        return description(self)

    def _repr_html_(self) -> str:
        """The description as a table, and the polhode, for notebooks."""
        return markup.table(
            *markup.rows_of(str(self)), *pictures(self.body, self.energy, self.polhode)
        )

    # ---- States at epochs

    @property
    def epoch(self) -> Instant:
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    # ---- Proofs

    def certificate(
        self, t: Epochs, low: ArrayLike | None = None, *, angular_velocity: bool = False
    ) -> Certificate:
        """Proved upper bounds of the errors of `at`, rad, at each epoch.

        Parameters
        ----------
        t, low : epochs
            As `at` takes them; finite.
        angular_velocity : bool
            Bound the errors of the angular velocities too (`Certificate.rate_error`, rad/s).

        Returns
        -------
        Certificate
            Its `error` bounds the rotation angle between ``at(t).wxyz`` and the exact solution for
            the doubles of body and spin (see `attitude.certify`).

        Raises
        ------
        AttitudeError
            As `at` and `attitude.certify`.
        """
        hi, lo = _inputs.seconds_since(self.epoch, t, low)
        wxyz, *rates = self._evaluate(hi, lo, int(angular_velocity))
        return chain_of(self.body, self.spin).certificate(hi, lo, wxyz, *rates)

    def error_bound(self) -> ErrorBound:
        """Two numbers b0, b1: every attitude errs by at most b0 + b1 |t| rad, by proof.

        t is in seconds since the epoch, up to 1e15 turns.

        Raises
        ------
        AttitudeError
            If the theorem of docs/proof.md does not hold for the constants of this motion, and
            without python-flint (extra ``proof``).
        """
        from attitude.proof._error_bound import error_bound_of

        record = self._constants[0]
        tumbles = record["form"] != codes.UNIFORM
        chain = chain_of(self.body, self.spin, record=record if tumbles else None)
        return error_bound_of(record, chain.solution)

    def angular_acceleration_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        angular_velocity: FloatArray | None = None,
    ) -> FloatArray:
        """Angular acceleration (..., 3), rad/s2 in body axes, at TDB seconds since the epoch.

        By Euler's equations from `angular_velocity` (..., 3), rad/s in body axes at these epochs,
        which is computed if it is not given.
        """
        if angular_velocity is None:
            angular_velocity = self.angular_velocity_at(seconds, low)
        return self.angular_acceleration_from(angular_velocity)

    def angular_acceleration_from(self, angular_velocity: FloatArray) -> FloatArray:
        """Angular acceleration (..., 3), rad/s2, of angular velocities (..., 3), rad/s.

        Both over the body axes: Euler's equations.
        """
        axes, moments = self.body.principal_axes, self.body.moments
        angular_velocity = validation.rows(angular_velocity, "angular_velocity", 3, unit="rad/s")
        w = np.moveaxis(angular_velocity @ axes, -1, 0)
        rate = np.zeros(w.shape)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            if moments[i] > 0.0:
                with np.errstate(over="ignore"):
                    rate[i] = (moments[j] - moments[k]) / moments[i] * w[j] * w[k]
        if np.isinf(rate).any():
            raise AttitudeError(
                f"the angular velocity is {np.nanmax(np.abs(w)):.3g} rad/s, whose square is beyond "
                "the range of doubles: it has no angular acceleration; give one below 1e150 rad/s."
            )
        return np.moveaxis(rate, 0, -1) @ axes.T

    def rate_bounds(self, seconds: float) -> RateBounds:
        """`RateBounds` of a body-fixed direction, the same at all epochs."""
        return of_free_rotation(self.body, self.spin.angular_velocity)

    def _evaluate(
        self, seconds: FloatArray, low: FloatArray | None, order: int
    ) -> list[FloatArray]:
        shape, (t, t_low) = seconds.shape, pairs.rows(seconds, low)
        wxyz = new_array(1, 4, t.size)
        omega = new_array(1, 3, t.size) if order else None
        evaluation.evaluate(self._constants, t, t_low, wxyz, omega)
        arrays = [wxyz[0].T.reshape((*shape, 4))]
        if omega is not None:
            arrays.append(omega[0].T.reshape((*shape, 3)))
        if order > 1:
            arrays.append(self.angular_acceleration_from(arrays[1]))
        return arrays

    @cached_property
    def _sensitivity(self) -> Sensitivity:
        body, wxyz = self.body, self.spin.wxyz_icrf
        return Sensitivity(
            body.moments_as_pairs[None], wxyz[None], body.principal_wxyz[None], self._constants
        )

    # ---- Mode, periods and invariants

    @property
    def mode(self) -> Mode:
        """The `Mode` of the exact doubles given; see also `within_rounding`."""
        return Mode(int(self._constants["mode"][0]))

    @cached_property
    def within_rounding(self) -> tuple[Mode, ...]:
        """Modes other than `mode` that rounding of the input by a few last places could produce.

        A rotated tensor of a symmetric body is hardly ever exactly symmetric, and a rate converted
        from degrees hardly ever exactly on the separatrix.
        """
        modes = []
        moments = np.sort(self.body.moments)
        rates = np.abs(self.body.rates_about_principal_axes(self.spin.angular_velocity)[:, 0])
        close = np.diff(moments) <= _ROUNDING * moments[-1]
        if np.all(close):
            modes.append(Mode.SPHERICAL)
        elif self.mode is not Mode.AT_REST:
            if np.sum(rates > _ROUNDING * rates.max()) == 1:
                modes.append(Mode.PRINCIPAL_AXIS)
            elif not np.any(close) and self._constants["d2"][0, 0] <= self._rounding_of_d2():
                modes.append(Mode.SEPARATRIX)
        if np.any(close) and not np.all(close):
            modes.append(Mode.SYMMETRIC)
        return tuple(mode for mode in modes if mode is not self.mode)

    def _rounding_of_d2(self):
        """By how much rounding of the input changes D2 = L^2 - 2 E I2, of the scaled state."""
        c, outer = self._constants[0], self._constants["order"][0, [0, 2]]
        moments, rates, gaps = c["moments"][outer, 0], np.abs(c["omega"][outer, 0]), c["gaps"][:, 0]
        largest, fastest = moments[1], np.abs(c["omega"][:, 0]).max()
        # rounding of a tensor turns its axes by that of the largest moment over the gap
        is_turned = not np.array_equal(self.body.principal_axes, np.eye(3))
        by_rates = 2.0 * moments * (largest if is_turned else gaps) * rates * fastest
        return _ROUNDING * np.sum(by_rates + (2.0 * moments + gaps) * largest * rates**2)

    @property
    def circulates_about(self) -> str | None:
        """ "long" or "short": the axis about which the momentum circulates; None for neither.

        For symmetric bodies and for rotation about an extreme axis it is the axis of the limit of
        a vanishing nutation.
        """
        axis = int(self._constants["circulates"][0])
        if axis < 0 or self.mode is Mode.SEPARATRIX:
            return None
        moments = self.body.moments
        others = np.delete(moments, axis)
        return "long" if moments[axis] <= others.min() else "short"

    @cached_property
    def separatrix_distance(self) -> float:
        """1 - 2 E I2 / L^2 for the middle moment I2: 0 on the separatrix, negative in LAM.

        Computed without cancellation: all its digits are significant, even at 1e-16.  NaN at rest.
        """
        rates = self.body.rates_about_principal_axes(self.spin.angular_velocity)[:, 0]
        moments = self.body.moments
        if not np.any(rates):
            return math.nan
        scale = np.max(np.abs(rates))
        squares = moments / moments.max() * (rates / scale) ** 2
        total = np.sum(moments / moments.max() * squares)
        if self.mode in (Mode.LONG_AXIS, Mode.SHORT_AXIS, Mode.SYMMETRIC, Mode.SEPARATRIX):
            c = self._constants[0]
            sign = -1.0 if self.circulates_about == "long" else 1.0
            momentum = c["moments"][:, 0] * c["omega"][:, 0]
            return float(sign * c["d2"][0] / np.sum(momentum**2))
        middle = np.sort(moments)[1]
        return float(np.sum((moments - middle) / moments.max() * squares) / total)

    @property
    def period_psi(self) -> float:
        """Period in s of the rotation about the axis about which the momentum circulates."""
        return _period(self._constants["psi_rate"][0])

    @property
    def period_phi(self) -> float:
        """Mean period in s of the axis of `period_psi` about the momentum."""
        return _period(self._constants["phi_rate"][0])

    @cached_property
    def regime(self) -> Regime:
        """The `Regime` of the motion: E/E0, periods in both conventions, ranges, times."""
        return regime_of(self.body.moments_as_pairs[None], self._constants)

    @cached_property
    def momentum(self) -> FloatArray:
        """Angular momentum (3,) in ICRF, kg m2/s, or rad/s times the relative unit of inertia."""
        in_body = self.body.tensor @ self.spin.angular_velocity
        return frozen(quaternion.rotate(self.spin.wxyz_icrf, in_body))

    @cached_property
    def energy(self) -> float:
        """Kinetic energy in J, or in rad2/s2 times the relative unit of inertia."""
        rates = self.body.rates_about_principal_axes(self.spin.angular_velocity)[:, 0]
        with np.errstate(over="ignore"):
            energy = float(0.5 * np.sum(self.body.moments * rates**2))
        if not energy < math.inf:
            raise AttitudeError(
                f"the kinetic energy of rates up to {np.abs(rates).max():.3g} rad/s is beyond the "
                "range of doubles; give lower rates."
            )
        return energy

    @cached_property
    def elements(self) -> Elements:
        """The normal form: rates, phase, amplitude and ellipticity of the motion.

        Raises
        ------
        AttitudeError
            Where no nutation is defined: at rest, spheres, the middle axis, and the equator of a
            symmetric body.
        """
        return elements_of(self._constants[0])

    # ---- Forms of papers, and curves

    def _free_at(self, at: EpochOrSeconds | None) -> FreeRotation:
        return self if at is None else super()._free_at(at)

    def _published(self, convention: str, frame: str | None) -> Published:
        """The state in the form of papers, see `published`."""
        frame = self.spin.frame if frame is None else frames.known(frame)
        spin = self.spin
        return _published.published(
            self.body,
            self.regime,
            spin.wxyz if frame == spin.frame else _over_axes(frame, spin.wxyz_icrf),
            spin.angular_velocity,
            convention=convention,
            epoch=spin.epoch,
            frame=frame,
        )

    def angles(self, t: Epochs, convention: str, frame: str | None = None) -> FloatArray:
        """Euler angles (S, 3) about the momentum at epochs t: phi, theta, psi, in rad.

        3-1-3 angles of the axes of a convention, as in `published`: phi counts from the direction
        of growing colatitude at the pole in `frame` (by default that of the spin); phi and psi in
        [0, 2 pi).  AttitudeError for a body at rest.
        """
        _published.refuse_rest(self.regime)
        frame = self.spin.frame if frame is None else frame
        wxyz = _over_axes(frame, self.at(t).wxyz)
        wxyz = quaternion.multiply(wxyz, _conventions.axes_wxyz(self.body, convention))
        momentum = frames.matrix_to_icrf(frame).T @ self.momentum
        momentum = quaternion.rotate(quaternion.conjugate(wxyz), momentum)
        return np.stack(_conventions.angles_of(wxyz, momentum)[1:], axis=-1)

    def obliquity(self, orbit: Any, at: EpochOrSeconds | None = None) -> float:
        """The angle between the angular momentum and that of an orbit, 0 to pi rad.

        Parameters
        ----------
        orbit : Path or skyfield object
            Of the body about its center; one about the barycentre is taken about the Sun.
        at : epoch or seconds, optional
            Of the osculating orbit; that of the spin by default.
        """
        from attitude.motions._axes import obliquity

        hi, lo = _inputs.one_since(self.epoch, self.epoch if at is None else at, "at")
        assert self.momentum is not None  # that of a free rotation is constant
        return float(obliquity(self.momentum, orbit, self.epoch, np.array(hi), np.array(lo)))

    def polhode(self, points: int = 361) -> FloatArray:
        """The path (points, 3) of the angular velocity in body axes, rad/s, over one P_psi.

        A closed curve where the momentum circulates.
        """
        return polhode_of(self._constants[0], self.body.principal_axes, points)

    def herpolhode(self, t: Epochs) -> FloatArray:
        """The path (S, 2) of the angular velocity in the invariable plane, rad/s, at epochs t.

        Its origin is on the momentum, its axes point to growing colatitude and longitude of the
        direction of the momentum in ICRF.
        """
        return herpolhode(self.momentum, self.at(t).angular_velocity_inertial)

    # ---- Errors

    def predictable_time(
        self,
        *,
        moments_error: Reals | None = None,
        rates_error: Reals | None = None,
        tolerance: Real = 0.1,
    ) -> float:
        """Seconds until errors of the input reach a tolerance of the attitude.

        Without `moments_error` and `rates_error` the errors are those of the spin's covariance:
        the result is when the largest standard deviation of the attitude reaches the tolerance.

        Parameters
        ----------
        moments_error : float or (3,) array_like
            One standard deviation of each principal moment, relative to it.
        rates_error : float or (3,) array_like
            One standard deviation of each angular velocity component over the principal axes,
            relative to the magnitude of the angular velocity.
        tolerance : float or Quantity
            rad.

        Returns
        -------
        float
            s; inf too for a spin of which no errors are known (its ``covariance`` is None).
        """
        if moments_error is None and rates_error is None and self.spin.covariance is not None:
            return _predictability.time_of_covariance(self, tolerance)
        return _predictability.predictable_time(
            self.body.moments_as_pairs,
            self.body.rates_about_principal_axes(self.spin.angular_velocity),
            moments_error=0.0 if moments_error is None else moments_error,
            rates_error=0.0 if rates_error is None else rates_error,
            tolerance=tolerance,
        )

    def deviations(self) -> dict[str, Uncertain]:
        """Periods, angles, momentum and energy with their errors of one standard deviation.

        By name, such as ``deviations()["period_psi"].plus``: what `print(motion)` shows.

        Raises
        ------
        AttitudeError
            If the spin has no covariance.
        """
        from attitude.motions._description import deviations

        return deviations(self, self._errors())


def _period(rate: float) -> float:
    """The period in s of a rate in turns per second."""
    return math.inf if rate == 0.0 else float(abs(1.0 / rate))


# ---- Poinsot's curves in closed form: the path of the angular velocity in the body and in space


def polhode_of(constants: Any, principal_axes: FloatArray, points: int) -> FloatArray:
    """One circuit of the angular velocity in body axes.

    Shapes: principal_axes (3, 3).

    w1 = a1 cos am, w2 = -a2 sin am, w3 = a3 sqrt(cos^2 am + (1-m) sin^2 am) over the axes in
    Jacobi order: van Zon & Schofield (2006), eqs. 3.36-3.41.
    """
    count = validation.count(points, "points", 2, 10_000_000)
    if constants["form"] == codes.UNIFORM:
        w = np.ldexp(constants["omega"][:, 0], int(constants["tempo"]))
        return np.tile(principal_axes @ w, (count, 1))
    first, second, minus1, minus3 = constants["jacobi"]
    third = 3 - first - second
    turn = np.pi if constants["mode"] != codes.SEPARATRIX else 0.5 * np.pi
    am = np.linspace(-turn, turn, count)
    if third == constants["order"][2]:
        am = am[::-1]  # in short-axis mode the amplitude decreases with time
    cosine, sine = np.cos(am), np.sin(am)
    if turn < 3.0:
        cosine[[0, -1]] = 0.0
    inner = np.empty((3, count))
    inner[0] = cosine
    inner[1] = -sine
    inner[2] = np.sqrt(cosine**2 + constants["mc"][0] * sine**2)
    inner *= constants["amplitudes"][:, None]
    even = (second - first) % 3 == 1
    signs = np.array([1 - 2 * minus1, 1.0, 1 - 2 * minus3])
    signs[1] = signs[0] * signs[2] * (1.0 if even else -1.0)
    over_principal = np.empty((3, count))
    over_principal[[first, second, third]] = signs[:, None] * inner
    return (principal_axes @ over_principal).T


def pictures(body: Body, energy: float, curve: Callable[[int], FloatArray]) -> list[str]:
    """An SVG of the polhode (n, 3), of `curve`, on its ellipsoid; none at rest and for a rod."""
    if not energy > 0.0 or np.min(body.moments) <= 0.0:
        return []
    axes = body.principal_axes
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    circles = np.zeros((3, len(turn), 3))
    for k in range(3):
        circles[k, :, (k + 1) % 3], circles[k, :, (k + 2) % 3] = np.cos(turn), np.sin(turn)
    sections = circles * np.sqrt(2.0 * energy / body.moments) @ axes.T
    # Seen from a place above the first octant of the principal axes.
    right, up = np.array([[-0.6, 0.8, 0.0], [-0.36, -0.27, 0.89]]) @ axes.T
    return [
        markup.line_plot(
            [(points_of @ right, points_of @ up) for points_of in (*sections, curve(181))],
            "polhode on the ellipsoid of its energy, with the principal sections",
            colors=("#bbbbbb", "#bbbbbb", "#bbbbbb", VERMILION),
            is_equal=True,
        )
    ]


def plane(momentum: FloatArray) -> FloatArray:
    """Axes (2, 3), of growing colatitude and longitude, of the plane across the momentum (3,)."""
    x, y, z = momentum / np.max(np.abs(momentum))
    pole = np.array([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
    return quaternion.matrix(_conventions.pole_wxyz(pole)).T[:2]


def herpolhode(momentum: FloatArray, angular_velocity: FloatArray) -> FloatArray:
    """Components (..., 2) in the invariable plane of angular velocities (..., 3), rad/s.

    Over the axes of `plane`; momentum (3,) and angular velocities in one inertial frame.  The
    component along the momentum, 2 E / L, is constant.
    """
    if not np.any(momentum):
        raise AttitudeError("the body is at rest; without momentum there is no invariable plane.")
    return angular_velocity @ plane(momentum).T


# ---- Proved distances of attitudes from the exact free rotation of a body and spin


def certify(
    body: Body,
    spin: Spin,
    seconds: Epochs,
    wxyz: Reals,
    *,
    low: ArrayLike | None = None,
    angular_velocity: Reals | None = None,
) -> Certificate:
    """Proved distances of attitudes that anyone computed from the exact free rotation.

    Parameters
    ----------
    body, spin : Body, Spin
        Their doubles are exact: the moments, or the tensor if it is full; the attitude over ICRF
        (`Spin.wxyz_icrf_as_pairs`) and the angular velocity.
    seconds : (T,) array_like
        TDB seconds since the epoch of the spin, or epochs as `Motion.at` takes them.
    wxyz : (T, 4) array_like
        Attitudes, body to ICRF, scalar first, of any length; of either sign.
    low : (T,) array_like, optional
        A second double of the seconds.
    angular_velocity : (T, 3) array_like, optional
        rad/s over the body axes, to be certified too.

    Returns
    -------
    Certificate
        `error` is not less than the rotation angle between each attitude and the exact one.

    Raises
    ------
    AttitudeError
        For wrong shapes, numbers that are not finite, a spin about an axis without inertia,
        attitudes that 65,536 bits do not decide, and without python-flint (extra ``proof``).

    Notes
    -----
    Arb balls around the solution of van Zon & Schofield (2006), docs/proof.md.

    >>> import pytest
    >>> flint = pytest.importorskip("flint", reason="python-flint is not installed")
    >>> from attitude import Body, Spin
    >>> spin = Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0.5))
    >>> certificate = certify(Body(moments=(1, 2, 3)), spin, [0.0], [(1, 0, 1e-9, 0)])
    >>> f"{certificate.error[0]:.3e}"
    '2.000e-09'
    """
    refuse_others(body, spin, "certify takes a Body and a Spin first")
    _check_inertia(body, spin)
    hi, lo = _inputs.seconds_since(spin.epoch, seconds, low, name="seconds")
    wxyz = validation.real(wxyz, "wxyz", shape=(*hi.shape, 4))
    rates = None
    if angular_velocity is not None:
        rates = validation.real(
            angular_velocity, "angular_velocity", shape=(*hi.shape, 3), unit="rad/s"
        )
    return chain_of(body, spin).certificate(hi, lo, wxyz, rates)


def _check_inertia(body: Body, spin: Spin) -> None:
    """Refuse a spin about a principal axis without inertia."""
    rates = spin.angular_velocity
    if body.has_given_axes and np.any((body.moments == 0.0) & (rates != 0.0)):
        raise AttitudeError(
            f"the angular velocity is {rates.tolist()} rad/s and the moments are "
            f"{body.moments.tolist()}; the spin about an axis without inertia is undefined. Give 0 "
            "for that component, or a moment above zero."
        )


def chain_of(body: Body, spin: Spin, joints: Sequence[Joint] = (), record: Any = None) -> Chain:
    """The exact motion from the doubles of a body and a spin.

    Where equal moments leave the order of two axes open, or a rate of zero the sense of one, they
    are those of a record of the motion that tumbles (records.CONSTANTS).
    """
    from attitude.proof._chain import Chain

    order, axes = None, None if body.has_given_axes else body.principal_axes
    if record is not None:
        order = record["order"].tolist()
        if axes is not None:
            first, second, reverse1, reverse3 = record["jacobi"].tolist()
            senses = np.ones(3)
            senses[first], senses[3 - first - second] = 1 - 2 * reverse1, 1 - 2 * reverse3
            axes = axes * senses
    return Chain(
        inertia_of(body), spin.wxyz_icrf_as_pairs, spin.angular_velocity, joints, order, axes
    )


def inertia_of(body: Body) -> FloatArray:
    """The moments (3,) of a body if its axes are principal, else its tensor (3, 3)."""
    if body.moments.min() == 0.0 and not body.has_given_axes:
        raise AttitudeError(
            "a moment of inertia of the tensor is zero within rounding; such a body is certified "
            "over its principal axes only: give moments."
        )
    return body.moments if body.has_given_axes else body.tensor
