"""What follows from the derivatives of a free rotation: sensitivities, covariances, samples."""

from __future__ import annotations

from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Self, overload

import numpy as np

from attitude import epochs, quaternion, validation
from attitude import representations as forms
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation import sensitivity
from attitude.free_rotation.sensitivity import Sensitivity
from attitude.motion import Motion
from attitude.sensitivities import covariance as covariances
from attitude.sensitivities.elements import Elements, elements_of, state_of
from attitude.spin import Spin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from attitude.annotations import Epoch, Epochs, FloatArray, Real, Reals


# Squares of turns, rad2, that are rounding errors of attitudes.
_ROUNDING = 1e-28


class Differentiable(Motion):
    """A motion whose attitudes have derivatives by its initial state and its moments.

    A class of this kind is made from a Body and a Spin.
    """

    if TYPE_CHECKING:
        body: Body
        spin: Spin
        _constants: Any

        def __init__(self, body: Body, spin: Spin) -> None: ...

    @cached_property
    def _sensitivity(self) -> Sensitivity:
        return Sensitivity(self._constants, self.body, self.spin)

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
        Errors are 4e-15 of the largest entry of a column, near the separatrix 1e-15/mc: closed
        forms (docs/derivation.md), not differences.
        """
        seconds, lo = epochs.seconds_since(self.epoch, t, low)
        if axes not in ("inertial", "body"):
            raise AttitudeError(f'axes is {axes!r}; give "inertial" or "body".')
        validation.one_of(by, "by", ("state", "elements"))
        rates = validation.flag(angular_velocity, "angular_velocity")
        attitude, omega = self._sensitivity.at(seconds, lo, rates)
        if axes == "body":
            wxyz = self._evaluate(seconds, lo, 0)[0]
            attitude = sensitivity.to_body_axes(wxyz, self.spin.wxyz_icrf, attitude)
            if omega is not None:
                omega[..., :3] = omega[..., :3] @ quaternion.matrix(self.spin.wxyz_icrf)
        if by == "elements":
            change = self._sensitivity.by_elements()
            attitude = _combined(attitude, change)
            omega = None if omega is None else _combined(omega, change)
        return attitude if omega is None else (attitude, omega)

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
            `attitude.sensitivities.elements`.
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
        given = Elements(*numbers.tolist())
        moments, omega = state_of(given)
        if largest_moment is not None:
            moments *= validation.positive(largest_moment, "largest_moment", unit="kg m2")
        body = Body(moments=moments, relative=largest_moment is None)
        return cls(body, Spin(epoch, wxyz, omega, frame))

    def covariance_at(
        self, seconds: ArrayLike, low: ArrayLike | None = None, *, rates: bool = True
    ) -> FloatArray:
        """Covariance (S, 6, 6), or (S, 3, 3) without rates; see `Motion.covariance_at`."""
        hi, lo = epochs.plain_seconds(seconds, low)
        return self._sensitivity.covariance_at(hi, lo, rates)

    @property
    def momentum_covariance(self) -> FloatArray:
        """(3, 3) covariance of the momentum over ICRF axes; see `Motion.momentum_covariance`."""
        changes = sensitivity.of_momentum(self.body, self.spin) @ covariances.factor(self._errors())
        return changes @ changes.T

    def nonlinearity_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> FloatArray:
        """Second over first order (S,) of the attitude's errors of one standard deviation.

        From the motions of `sigma_points`; below 0.1 covariances describe the errors.
        """
        hi, lo = epochs.plain_seconds(seconds, low)
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
        found = np.sqrt(np.divide(second, first, out=np.zeros_like(first), where=first > _ROUNDING))
        # A turn of more than half a revolution is another one's: nothing is linear any more.
        far = np.max(np.sum(plus**2 + minus**2, axis=-1), axis=0) > 0.5 * np.pi**2
        return np.where(np.isnan(hi), np.nan, np.where(far, np.maximum(found, 1.0), found))

    def sigma_points(self) -> list[Self]:
        """Motions one standard deviation to either side along each principal axis of the errors.

        2 r motions for a covariance of rank r, in pairs; (mean, covariance) of any quantity over
        them is that of the linear theory where it is linear.

        Raises
        ------
        AttitudeError
            If the spin has no covariance, or its errors lead to moments that are no body's.
        """
        columns = covariances.factor(self._errors()).T
        points = [column for column in columns if np.any(column)]
        return [self.changed(sign * point) for point in points for sign in (1.0, -1.0)]

    def sample(self, count: int, seed: int = 0) -> list[Self]:
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
        number = validation.count(count, "count")
        factor = covariances.factor(self._errors())
        generator = np.random.default_rng(seed)
        found: list[Self] = []
        most = 10 * number + 100
        for _ in range(most):
            if len(found) == number:
                return found
            with suppress(AttitudeError):
                found.append(self.changed(factor @ generator.standard_normal(9)))
        raise AttitudeError(
            f"{most} draws gave {len(found)} motions whose moments are those of a body; give "
            "smaller errors of the moments."
        )

    def _errors(self) -> FloatArray:
        given = self.spin.covariance_icrf
        if given is None:
            raise AttitudeError(
                "the spin has no covariance; make it with Spin(..., covariance=...), or take "
                "spin.with_covariance(...)."
            )
        return given

    def changed(self, changes: ArrayLike) -> Self:
        """The motion after a change (9,) of the parameters of `sensitivity_at` (ICRF axes).

        Raises
        ------
        AttitudeError
            If the moments are then not those of a body.
        """
        given = validation.real(changes, "changes", shape=(9,))
        return type(self)(*sensitivity.changed(self.body, self.spin, given))


def _combined(columns: FloatArray, change: FloatArray) -> FloatArray:
    """Columns (..., 3, 8) by attitude and elements from those (..., 3, 9) by the state."""
    return np.concatenate([columns[..., :3], columns[..., 3:] @ change], axis=-1)
