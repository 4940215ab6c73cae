"""What follows from the derivatives of a free rotation: sensitivities, covariances, samples."""

from __future__ import annotations

import math
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Literal, Self, TypeVar, overload

import numpy as np

from attitude._solver import covariance as covariances
from attitude._support import validation
from attitude._support.pairs import Seconds
from attitude.epochs import _inputs
from attitude.errors import AttitudeError, CovarianceWarning
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._body import Body, tensors_of
from attitude.motions._motion import Motion

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude._solver.sensitivities import Derivatives
    from attitude._support.annotations import Epochs, FloatArray
    from attitude.motions._spin import Spin

# Of samples: motions of one class.
Drawn = TypeVar("Drawn")


def changed(body: Body, spin: Spin, changes: FloatArray) -> tuple[Body, Spin]:
    """Body and Spin with one change (9,) of the parameters (ICRF axes)."""
    turn = forms.from_rotation_vector(changes[:3])
    wxyz = quaternion.multiply(turn, spin.wxyz_icrf)
    moved = type(spin)(spin.epoch, wxyz, spin.angular_velocity + changes[3:6])
    if not np.any(changes[6:]):
        return body, moved
    moments = body.moments + changes[6:]
    more: dict[str, Any] = {
        "mass": body.mass,
        "relative": body.relative,
        "center_of_mass": body.center_of_mass,
    }
    if np.array_equal(body.principal_axes, np.eye(3)):
        return Body(moments=moments, **more), moved
    return Body(tensor=tensors_of(moments, body.principal_axes), **more), moved


def samples(
    count: int,
    seed: int | np.random.Generator,
    covariance: FloatArray,
    changed_by: Callable[[FloatArray], Drawn],
    remedy: str,
) -> list[Drawn]:
    """Motions after changes (P,) drawn from a covariance (P, P); those of no body drawn anew."""
    number = validation.count(count, "count", 1, 10_000_000)
    factor = covariances.factor(covariance)
    generator = validation.generator(seed)
    drawn: list[Drawn] = []
    most = 10 * number + 100
    for _ in range(most):
        if len(drawn) == number:
            return drawn
        with suppress(AttitudeError):
            drawn.append(changed_by(factor @ generator.standard_normal(len(factor))))
    raise AttitudeError(
        f"{most} draws gave {len(drawn)} motions whose moments are those of a body; {remedy}."
    )


# Squares of turns, rad2, that are rounding errors of attitudes.
_ROUNDING = 1e-28
# Standard deviation of the attitude, rad, and nonlinearity from which a covariance means nothing: a
# normal distribution of 60 deg reaches round the circle, and half of the change is of second order.
_LARGEST_SIGMA = math.pi / 3.0
_LARGEST_NONLINEARITY = 0.5
# Standard deviation, rad, from which the nonlinearity is looked at: 2 r motions at one epoch.
_CHECKED_SIGMA = 0.25


class Differentiable(Motion):
    """A motion whose attitudes have derivatives by its initial state and its moments.

    A class of this kind has a ``body`` and a ``spin``, and defines ``_sensitivity``, its
    `Derivatives`, and ``_with(body, spin)``, the same motion from another state.

    `sensitivity_at` is the contract, the same for all of them: nine columns, for epochs in any
    form.
    """

    # Whether another motion takes no steps, so that covariances can look at the nonlinearity.
    _has_closed_form = False

    if TYPE_CHECKING:
        body: Body
        spin: Spin

        @property
        def _sensitivity(self) -> Derivatives: ...

    def _with(self, body: Body, spin: Spin) -> Self:
        raise NotImplementedError(f"{type(self).__name__} defines no _with")

    @overload
    def sensitivity_at(
        self,
        t: Epochs,
        low: ArrayLike | None = None,
        *,
        axes: str = "inertial",
        by: str = "state",
    ) -> FloatArray: ...

    @overload
    def sensitivity_at(
        self,
        t: Epochs,
        low: ArrayLike | None = None,
        *,
        angular_velocity: Literal[True],
        axes: str = "inertial",
        by: str = "state",
    ) -> tuple[FloatArray, FloatArray]: ...

    def sensitivity_at(
        self,
        t: Epochs,
        low: ArrayLike | None = None,
        *,
        angular_velocity: bool = False,
        axes: str = "inertial",
        by: str = "state",
    ) -> FloatArray | tuple[FloatArray, FloatArray]:
        """The derivatives of the attitude by the initial state and the moments, in closed form.

        Parameters
        ----------
        t, low
            Epochs, as for `at`.
        angular_velocity : bool
            Whether the derivatives of the angular velocity are returned too.
        axes : str
            "inertial" (ICRF) or "body": axes of the changes of attitude, then and at the epoch.
        by : str
            "state", or "elements": eight columns, of the attitude at the epoch (3) and of
            `elements` (5) in their order.

        Returns
        -------
        attitude : (S, 3, 9) array
            Rotation vector (rad) of the change of attitude for a unit change of the attitude at the
            epoch (3, rotation vector, rad), the angular velocity (3, rad/s, body axes) and the
            principal moments (3, in the unit of the body; their common scale changes nothing).
        omega : (S, 3, 9) array
            Of the angular velocity, body axes; only with `angular_velocity`.

        Raises
        ------
        AttitudeError
            For the rod, epochs that cannot be read, and epochs to which a rotation about an
            unstable axis multiplies errors by more than 1e121.

        Notes
        -----
        Closed forms (docs/derivation.md), not differences.  Errors are 4e-15 of the largest entry
        of a column, or 2^-52 of its condition number where that is more (docs/sensitivities.md), as
        after a passage near the separatrix.  By elements the same, but up to 1e-11 of the first
        columns by rho or X of a tilted needle, and of a nearly symmetric body beside its equator.
        For motions under torques see `attitude.splitting.TorquedRotation`.
        """
        seconds, lo = _inputs.seconds_since(self.epoch, t, low)
        validation.one_of(axes, "axes", ("inertial", "body"))
        validation.one_of(by, "by", ("state", "elements"))
        rates = validation.flag(angular_velocity, "angular_velocity")
        of = self._sensitivity
        columns_of = of.by_elements if by == "elements" else of.at
        attitude, omega = columns_of(seconds, lo, rates)
        if axes == "body":
            wxyz = self._evaluate(seconds, lo, 0)[0]
            start = quaternion.matrix(self.spin.wxyz_icrf)
            attitude = np.swapaxes(quaternion.matrix(wxyz), -1, -2) @ attitude
            for columns in (attitude,) if omega is None else (attitude, omega):
                columns[..., :3] = columns[..., :3] @ start
        return attitude if omega is None else (attitude, omega)

    def covariance_at(
        self, seconds: ArrayLike, low: ArrayLike | None = None, *, rates: bool = True
    ) -> FloatArray:
        """Covariance (S, 6, 6), or (S, 3, 3) without rates; see `Motion.covariance_at`."""
        hi, lo = _inputs.plain_seconds(seconds, low)
        covariance = self._linear_covariance_at(hi, lo, rates)
        self._warn_of_large(covariance, hi, lo)
        return covariance

    def _linear_covariance_at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> FloatArray:
        """`covariance_at` without the warning."""
        return self._sensitivity.covariance_at(self._errors(), seconds, low, rates)

    def _warn_of_large(
        self, covariance: FloatArray, seconds: FloatArray, low: FloatArray | None
    ) -> None:
        """Warn once if covariances (S, n, n) do not describe the errors of the attitude."""
        if "_has_warned" in self.__dict__ or not covariance.size:
            return
        variances = [covariance[..., k, k] for k in range(3)]
        largest = math.sqrt(
            np.fmax.reduce(
                [np.fmax.reduce(variance, axis=None) for variance in variances], initial=0.0
            )
        )
        if largest > _LARGEST_SIGMA:
            size_words = f"{math.degrees(largest):.3g} deg"
            self._warn(f"the standard deviation of the attitude reaches {size_words}")
            return
        # The nonlinearity grows with the errors: it is looked at again where they are larger.
        known = self.__dict__.get("_checked_sigma", _CHECKED_SIGMA)
        if not self._has_closed_form or not largest > known:
            return
        self._set("_checked_sigma", 1.5 * largest)
        at = np.unravel_index(np.nanargmax(sum(variances)), seconds.shape)
        with suppress(AttitudeError):  # errors that lead to moments of no body
            self.nonlinearity_at(*Seconds(seconds, low).taken(at))

    def _warn(self, what: str) -> None:
        """Warn, once for the motion, that its covariances mean little."""
        if "_has_warned" not in self.__dict__:
            self._set("_has_warned", True)
            warnings.warn(
                f"{what}: covariances do not describe such errors. Take motion.sample(n) (of an "
                "inversion solution.sample(n)), motion.sigma_points(), or epochs within "
                "motion.predictable_time().",
                CovarianceWarning,
                stacklevel=2,
            )

    @property
    def momentum_covariance(self) -> FloatArray:
        """(3, 3) covariance of the momentum over ICRF axes; see `Motion.momentum_covariance`."""
        if self.momentum is None:
            raise AttitudeError(
                f"the angular momentum of the motion ({self._kind}) changes with time; take "
                "motion.momentum_covariance_at(seconds)."
            )
        state, (turns, omega) = self.spin, np.eye(9)[:6].reshape(2, 3, 9)
        return self._momentum_covariance(state.wxyz_icrf, state.angular_velocity, turns, omega)

    def momentum_covariance_at(
        self, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Covariance (S, 3, 3) of the momentum; see `Motion.momentum_covariance_at`."""
        hi, lo = _inputs.plain_seconds(seconds, low)
        wxyz, rates = self._evaluate(hi, lo, 1)[:2]
        turns, omega = self._sensitivity.at(hi, lo, True)
        self._warn_of_large(turns @ self._errors() @ np.swapaxes(turns, -1, -2), hi, lo)
        return self._momentum_covariance(wxyz, rates, turns, omega)

    def _momentum_covariance(self, wxyz, rates, turns, omega):
        """(S, 3, 3) of states (S, 4), (S, 3) with derivatives (S, 3, 9) of turn and rates."""
        body = self.constant_body("the covariance of the angular momentum")
        tensor, axes, to_icrf = body.tensor, body.principal_axes, quaternion.matrix(wxyz)
        momentum = to_icrf @ (rates @ tensor)[..., None]
        in_body = tensor @ omega
        in_body[..., 6:] += axes * (rates @ axes)[..., None, :]
        changes = np.cross(turns, momentum, axis=-2) + to_icrf @ in_body
        changes = changes @ covariances.factor(self._errors())
        return changes @ np.swapaxes(changes, -1, -2)

    def nonlinearity_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> FloatArray:
        """Second over first order (S,) of the attitude's errors of one standard deviation.

        From the motions of `sigma_points`; below 0.1 covariances describe the errors.
        """
        hi, lo = _inputs.plain_seconds(seconds, low)
        wxyz = self._evaluate(hi, lo, 0)[0]
        turns = []
        for motion in self.sigma_points():
            other = motion._evaluate(hi, lo, 0)[0]
            turn = quaternion.multiply(other, quaternion.conjugate(wxyz))
            turns.append(forms.to_rotation_vector(turn))
        if not turns:
            return np.zeros(hi.shape)
        plus, minus = np.array(turns[0::2]), np.array(turns[1::2])
        first = np.sum((0.5 * (plus - minus)) ** 2, axis=(0, -1))
        second = np.sum((0.5 * (plus + minus)) ** 2, axis=(0, -1))
        shares = np.sqrt(
            np.divide(second, first, out=np.zeros_like(first), where=first > _ROUNDING)
        )
        # A turn of more than half a revolution is another one's: nothing is linear any more.
        far = np.max(np.sum(plus**2 + minus**2, axis=-1), axis=0) > 0.5 * np.pi**2
        unknown = np.isnan(wxyz[..., 0])
        shares = np.where(unknown, np.nan, np.where(far, np.maximum(shares, 1.0), shares))
        largest = float(np.fmax.reduce(shares, axis=None, initial=0.0))
        if largest > _LARGEST_NONLINEARITY:
            self._warn(f"the nonlinearity of the errors of the attitude reaches {largest:.2g}")
        return shares

    def sigma_points(self) -> list[Self]:
        """Motions one standard deviation to either side along each principal axis of the errors.

        2 r motions for a covariance of rank r, in pairs; (mean, covariance) of any quantity over
        them is that of the linear theory where it is linear.

        Raises
        ------
        AttitudeError
            If the spin has no covariance, or its errors lead to moments that are no body's.
        """
        points = [column for column in covariances.factor(self._errors()).T if np.any(column)]
        return [self.changed(sign * point) for point in points for sign in (1.0, -1.0)]

    def sample(self, count: int, seed: int | np.random.Generator = 0) -> list[Self]:
        """Motions drawn from the normal distribution of the covariance of the spin.

        Parameters
        ----------
        count : int
        seed : int
            Of numpy's default generator.

        Raises
        ------
        AttitudeError
            If the spin has no covariance, or if 9 of 10 draws are no body's moments.

        Notes
        -----
        Draws whose moments are no body's are drawn anew.
        """
        remedy = "give smaller errors of the moments"
        return samples(count, seed, self._errors(), self.changed, remedy)

    def _errors(self) -> FloatArray:
        covariance = self.spin.covariance_icrf
        if covariance is None:
            raise AttitudeError(
                "the spin has no covariance; make it with Spin(..., covariance=...), or take "
                "spin.with_covariance(...)."
            )
        return covariance

    def changed(self, changes: ArrayLike) -> Self:
        """The motion after a change (9,) of the parameters of `sensitivity_at` (ICRF axes).

        Raises
        ------
        AttitudeError
            If the moments are then not those of a body.
        """
        vector = validation.real(changes, "changes", shape=(9,))
        return self._with(*changed(self.body, self.spin, vector))
