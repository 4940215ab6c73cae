"""Derivatives and covariances of the attitudes of one free rotation."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.body import Body
from attitude.compilation.streaming import LINE
from attitude.memory import new_array
from attitude.sensitivities import columns
from attitude.sensitivities import covariance as covariances
from attitude.sensitivities.elements import inputs_by_elements

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray
    from attitude.spin import Spin


class Derivatives(ABC):
    """The derivatives of a motion at any epoch, and the covariances that follow from them."""

    @abstractmethod
    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9), ICRF axes, and of the angular velocity, body axes."""

    @abstractmethod
    def by_elements(self) -> FloatArray:
        """Changes (6, 5) of angular velocity and moments with the elements at the epoch."""

    def covariance_at(
        self, given: FloatArray, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> FloatArray:
        """Covariances (S, 3, 3) of the attitude, or (S, 6, 6), from that (9, 9) of the state."""
        attitude, omega = self.at(seconds, low, rates)
        both = attitude if omega is None else np.concatenate([attitude, omega], axis=-2)
        factored = both @ covariances.factor(given)
        found: FloatArray = factored @ np.swapaxes(factored, -1, -2)
        return found


class Sensitivity(Derivatives):
    """The derivatives of one motion at any epoch.

    Parameters
    ----------
    constants : (1,) structured array
        Of `evaluation.constants_of`.
    body, spin : Body, Spin
    """

    def __init__(self, constants: NDArray[Any], body: Body, spin: Spin) -> None:
        self._constants = constants
        self._tangents = columns.tangents_of(
            body.moments_as_pairs[None],
            spin.wxyz_icrf[None],
            body.principal_wxyz[None],
            constants,
        )
        self._last: tuple[FloatArray, columns.Factored] | None = None

    def _factored(self, given: FloatArray) -> columns.Factored:
        """The factors for a covariance (9, 9); those of the last one are kept."""
        last = self._last
        if last is None or not np.array_equal(last[0], given):
            factors = covariances.factor(given)[None]
            last = given.copy(), columns.factored(self._constants, self._tangents, factors)
            self._last = last
        return last[1]

    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9), ICRF axes, and of the angular velocity, body axes."""
        t, t_low = _row(seconds), None if low is None else _row(low)
        attitude = new_array(1, 3, 9, t.size)
        omega = new_array(1, 3, 9, t.size) if rates else None
        columns.evaluate(self._constants, self._tangents, t, t_low, attitude, omega)
        shape = (*seconds.shape, 3, 9)
        found = np.moveaxis(attitude[0], -1, 0).reshape(shape)
        return found, None if omega is None else np.moveaxis(omega[0], -1, 0).reshape(shape)

    def by_elements(self) -> FloatArray:
        """Changes (6, 5) of angular velocity and moments with the elements."""
        return inputs_by_elements(self._constants[0], self._tangents["by_input"][0])

    def covariance_at(
        self, given: FloatArray, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> FloatArray:
        """As `Derivatives.covariance_at`, in one loop over the epochs."""
        t, t_low = _row(seconds), None if low is None else _row(low)
        size = 6 if rates else 3
        # Rows of whole lines of the cache are stored faster.
        out = new_array(1, size, size, -(-t.size // LINE) * LINE)
        columns.covariances(self._constants, self._tangents, self._factored(given), t, t_low, out)
        found: FloatArray = np.moveaxis(out[0, ..., : t.size], -1, 0)
        return found.reshape(*seconds.shape, size, size)


def of_momentum(body: Body, spin: Spin) -> FloatArray:
    """Changes (3, 9) of the angular momentum, ICRF axes, for unit changes of the parameters."""
    to_icrf, axes = quaternion.matrix(spin.wxyz_icrf), body.principal_axes
    momentum = to_icrf @ body.tensor @ spin.angular_velocity
    by_turn = np.cross(np.eye(3), momentum).T
    by_moment = axes * (spin.angular_velocity @ axes)
    return np.concatenate([by_turn, to_icrf @ body.tensor, to_icrf @ by_moment], axis=1)


def to_body_axes(wxyz: FloatArray, start: FloatArray, attitude: FloatArray) -> FloatArray:
    """Changes of attitude (S, 3, 9) over inertial axes, over the body axes then and at first."""
    turned: FloatArray = np.swapaxes(quaternion.matrix(wxyz), -1, -2) @ attitude
    turned[..., :3] = turned[..., :3] @ quaternion.matrix(start)
    return turned


def changed(body: Body, spin: Spin, changes: FloatArray) -> tuple[Body, Spin]:
    """Body and Spin with one change (9,) of the parameters (ICRF axes).

    Raises
    ------
    AttitudeError
        If the moments are then not those of a body.
    """
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
    axes = body.principal_axes
    tensor = (axes * moments) @ axes.T
    return Body(tensor=0.5 * (tensor + tensor.T), **more), moved


def _row(array):
    return np.ascontiguousarray(array, dtype=np.float64).reshape(1, -1)
