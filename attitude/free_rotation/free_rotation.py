"""The free rotation of a body from its state at an epoch, exact at any other."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from attitude import frames, propagation, published, quaternion
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation import polhode, predictability, rate_bounds
from attitude.immutable import frozen
from attitude.motion import Motion
from attitude.published import conventions
from attitude.regime import Mode, regime_of
from attitude.spin import Spin

# "Within rounding": what changes of some units in the last place of the input can reach.
_ROUNDING = 16.0 * np.finfo(float).eps


@dataclass(frozen=True, eq=False, repr=False)
class FreeRotation(Motion):
    """Torque-free motion of a rigid body, in closed form.

    Parameters
    ----------
    body : Body
    spin : Spin

    Attributes
    ----------
    mode : Mode
        Exact statement about the doubles given; see also `within_rounding`.
    period_psi, period_phi : float
        Seconds: of the rotation about the axis that the momentum circulates about (the long axis
        in long-axis mode, the short one in short-axis mode), and the mean period in which that
        axis goes about the momentum.  Limits, or inf, in the other modes.
    momentum : (3,) array
        In ICRF, kg m2/s (in the body's unit of inertia if that is relative).
    energy : float
        J (likewise).

    Notes
    -----
    Attitudes err by at most 4e-15 rad for the exact doubles given, at any epoch within 1e15 turns
    (5e-14 rad at 5e16, beyond which epochs are refused): van Zon & Schofield (2006), in the form
    of docs/derivation.md.  What limits a prediction is the input.

    >>> motion = FreeRotation(
    ...     Body(moments=(10, 20, 26)),
    ...     Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1)),
    ... )
    >>> motion.mode.name, round(motion.period_psi, 6), round(motion.period_phi, 6)
    ('SHORT_AXIS', 2.347113, 0.370161)
    >>> motion.at(60.0).wxyz.shape
    (4,)
    """

    body: Body = field()
    spin: Spin = field()

    def __post_init__(self):
        if not isinstance(self.body, Body) or not isinstance(self.spin, Spin):
            raise AttitudeError(
                "FreeRotation takes a Body and a Spin, as in FreeRotation(body, spin); given were "
                f"{type(self.body).__name__} and {type(self.spin).__name__}."
            )
        body, spin = self.body, self.spin
        constants = propagation.constants_of(
            body.moments_as_pairs[None],
            spin.wxyz_icrf[None],
            body.rates_about_principal_axes(spin.angular_velocity)[None],
            body.principal_wxyz[None],
            differences=body.differences(spin.angular_velocity),
        )
        self._set("_constants", frozen(constants))

    def __reduce__(self):
        # The constants are made anew: what is in them may change between versions.
        return FreeRotation, (self.body, self.spin)

    @property
    def epoch(self):
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    def rate_bounds(self, seconds):
        """`RateBounds` of a body axis, the same at all epochs."""
        return rate_bounds.of_free_rotation(self.body, self.spin.angular_velocity)

    def angular_acceleration_at(self, seconds, low=None, *, angular_velocity=None):
        """Euler's equations: (..., 3) rad/s2 in body axes, at TDB seconds since the epoch."""
        if angular_velocity is None:
            angular_velocity = self.angular_velocity_at(seconds, low)
        return self.angular_acceleration_from(angular_velocity)

    def angular_acceleration_from(self, angular_velocity):
        """Euler's equations: (..., 3) rad/s2 in body axes, from angular velocities there."""
        axes, moments = self.body.principal_axes, self.body.moments
        w = np.moveaxis(angular_velocity @ axes, -1, 0)
        rate = np.zeros(w.shape)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            if moments[i] > 0.0:
                rate[i] = (moments[j] - moments[k]) / moments[i] * w[j] * w[k]
        return np.moveaxis(rate, 0, -1) @ axes.T

    @property
    def mode(self):
        return Mode(int(self._constants["mode"][0]))

    @property
    def period_psi(self):
        return _period(self._constants["psi_rate"][0])

    @property
    def period_phi(self):
        return _period(self._constants["phi_rate"][0])

    @cached_property
    def regime(self):
        """The `Regime` of the motion: E/E0, periods in both conventions, ranges, times."""
        return regime_of(self.body.moments_as_pairs[None], self._constants)

    def published(self, convention, frame=None):
        """The motion as observers print it: mode, periods, pole, angles at the epoch.

        Parameters
        ----------
        convention : "L" or "S"
            Whether phi is the angle of the long or of the short axis about the momentum.
        frame : str, optional
            Of the pole; that of the spin unless given.

        Returns
        -------
        Published
            ``Spin.from_periods(body, **published.keywords())`` makes the same spin.
        """
        frame = self.spin.frame if frame is None else frames.known(frame)
        wxyz = quaternion.multiply(
            quaternion.conjugate(frames.wxyz_to_icrf(frame)), self.spin.wxyz_icrf
        )
        return published.published(
            self.body,
            self.regime,
            self.spin.wxyz if frame == self.spin.frame else wxyz,
            self.spin.angular_velocity,
            convention=convention,
            epoch=self.spin.epoch,
            frame=frame,
        )

    def angles(self, t, convention, frame=None):
        """Euler angles (S, 3) about the momentum at epochs t: phi, theta, psi, in rad.

        3-1-3, of the axes in either labelling, as in `published`: phi from the meridian of growing
        colatitude of the pole in `frame` (that of the spin unless given); phi, psi in [0, 2 pi).
        """
        frame = self.spin.frame if frame is None else frame
        wxyz = quaternion.multiply(
            quaternion.conjugate(frames.wxyz_to_icrf(frame)), self.at(t).wxyz
        )
        wxyz = quaternion.multiply(wxyz, conventions.axes_wxyz(self.body, convention))
        momentum = frames.matrix_to_icrf(frame).T @ self.momentum
        momentum = quaternion.rotate(quaternion.conjugate(wxyz), momentum)
        return np.stack(conventions.angles_of(wxyz, momentum)[1:], axis=-1)

    def polhode(self, points=361):
        """The path of the angular velocity in the body (points, 3), rad/s, over one P_psi.

        Closed in the modes that circulate; see attitude.free_rotation.polhode.
        """
        return polhode.polhode(self._constants[0], self.body.principal_axes, points)

    def herpolhode(self, t):
        """The path (S, 2) of the angular velocity on the invariable plane, rad/s, at epochs t.

        About the foot of the momentum, towards the axes of attitude.free_rotation.polhode.plane.
        """
        return polhode.herpolhode(self.momentum, self.at(t).angular_velocity_inertial)

    def predictable_time(self, *, moments_error=0.0, rates_error=0.0, tolerance=0.1):
        """Seconds for which the attitude is known to a tolerance, given errors of the input.

        Parameters
        ----------
        moments_error : float or (3,) array_like
            One standard deviation of each principal moment, relative to it.
        rates_error : float or (3,) array_like
            One standard deviation of each angular velocity component over the principal axes,
            relative to the magnitude of the angular velocity.
        tolerance : float or Quantity
            rad.

        See attitude.free_rotation.predictability.
        """
        return predictability.predictable_time(
            self.body.moments_as_pairs,
            self.body.rates_about_principal_axes(self.spin.angular_velocity),
            moments_error=moments_error,
            rates_error=rates_error,
            tolerance=tolerance,
        )

    smooth = True

    @cached_property
    def momentum(self):
        in_body = self.body.tensor @ self.spin.angular_velocity
        return frozen(quaternion.rotate(self.spin.wxyz_icrf, in_body))

    @cached_property
    def energy(self):
        rates = self.body.rates_about_principal_axes(self.spin.angular_velocity)[:, 0]
        return float(0.5 * np.sum(self.body.moments * rates**2))

    @property
    def circulates_about(self):
        """ "long" or "short": the axis that the momentum circulates about; None if it does not.

        Also told for symmetric bodies and for rotation about an extreme axis, the limit of a
        vanishing wobble.
        """
        axis = int(self._constants["circulates"][0])
        if axis < 0 or self.mode is Mode.SEPARATRIX:
            return None
        moments = self.body.moments
        others = np.delete(moments, axis)
        return "long" if moments[axis] <= others.min() else "short"

    @cached_property
    def separatrix_distance(self):
        """1 - 2 E I2 / L^2 for the middle moment I2: 0 on the separatrix, negative in LAM.

        Formed without cancellation, so that it has all its digits also where it is 1e-16.
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

    @cached_property
    def within_rounding(self):
        """Modes that do not hold exactly, but would after changes in the last places of the input.

        A tuple of `Mode`.  A turned symmetric tensor is never exactly symmetric, and a rate
        converted from degrees is rarely exactly on the separatrix.
        """
        found = []
        moments = np.sort(self.body.moments)
        rates = np.abs(self.body.rates_about_principal_axes(self.spin.angular_velocity)[:, 0])
        close = np.diff(moments) <= _ROUNDING * moments[-1]
        if np.all(close):
            found.append(Mode.SPHERICAL)
        elif self.mode is not Mode.AT_REST:
            if np.sum(rates > _ROUNDING * rates.max()) == 1:
                found.append(Mode.PRINCIPAL_AXIS)
            elif not np.any(close) and abs(self.separatrix_distance) <= _ROUNDING:
                found.append(Mode.SEPARATRIX)
        if np.any(close) and not np.all(close):
            found.append(Mode.SYMMETRIC)
        return tuple(mode for mode in found if mode is not self.mode)

    def __repr__(self):
        return f"<FreeRotation: {self.mode.name}, from {self.spin.epoch.utc_iso} UTC>"

    def __str__(self):
        from attitude.free_rotation.description import description

        return description(self)

    def _evaluate(self, seconds, low, order):
        shape = seconds.shape
        t = np.ascontiguousarray(seconds).reshape(1, -1)
        t_low = None if low is None else np.ascontiguousarray(low).reshape(1, -1)
        wxyz = np.empty((1, 4, t.size))
        omega = np.empty((1, 3, t.size)) if order else None
        propagation.evaluate(self._constants, t, t_low, wxyz, omega)
        found = [wxyz[0].T.reshape(*shape, 4)]
        if order:
            found.append(omega[0].T.reshape(*shape, 3))
        if order > 1:
            found.append(self.angular_acceleration_from(found[1]))
        return found


def _period(rate):
    return math.inf if rate == 0.0 else float(abs(1.0 / rate))
