"""Standard deviations of the quantities of a view, from the covariance of the motion's spin.

A quantity changes with a small turn of the body by its gradient times the rotation vector, to first
order.  The gradient is in closed form but for brightness, which is differenced.  Paths are exact.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.history import turned_deviations
from attitude.scene.lazy import kept, quantity
from attitude.scene.photometry import Brightness

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

_XYZ = ("x", "y", "z")
_PLACE = ("longitude", "latitude")
_AXES = ("least", "middle", "greatest")
# Least turn over which brightness is differenced, rad: balances rounding and curvature.
_LEAST_STEP = 1e-5
# Cells of the sky along a right angle in the table of shadows of a mesh by default.
_CELLS = 64
# Magnitudes in a unit of the natural logarithm of brightness.
_MAGNITUDES = 2.5 / math.log(10.0)


class Errors(Brightness):
    """Base of `View`: adds the standard deviations of quantities that depend on the attitude.

    To first order in the errors.  AttitudeError if the motion's spin has no covariance.
    """

    @kept
    def turn_covariance(self) -> FloatArray:
        """Covariance (N, 3, 3) of the attitudes at emission: rotation vectors, rad, ICRF axes."""
        return self.attitude.attitude_covariance.reshape(-1, 3, 3)

    def _deviations(self, gradient: FloatArray) -> FloatArray:
        """Standard deviations (S) of numbers with gradients (N, 3) by turns, ICRF axes."""
        return self._numbers(turned_deviations(self.turn_covariance, gradient))

    def _in_rows(self, direction: FloatArray) -> FloatArray:
        """Directions (3, N) or (3, 1) as (N, 3)."""
        return np.broadcast_to(direction, (3, self.seconds.size)).T

    # Directions -----------------------------------------------------------------------------------

    @quantity("", _XYZ)
    def observer_direction_sigma(self) -> FloatArray:
        """Standard deviations of the components of observer_direction."""
        return self.attitude.inertial_to_body_sigma(self.observer_direction_icrf)

    @quantity("", _XYZ)
    def sun_direction_sigma(self) -> FloatArray:
        """Standard deviations of the components of sun_direction."""
        return self.attitude.inertial_to_body_sigma(self.sun_direction_icrf)

    @quantity("rad", _PLACE)
    def sub_observer_sigma(self) -> FloatArray:
        """Standard deviations of longitude and latitude of sub_observer."""
        return self._place_deviations(self.observer_direction)

    @quantity("rad", _PLACE)
    def sub_solar_sigma(self) -> FloatArray:
        """Standard deviations of longitude and latitude of sub_solar."""
        return self._place_deviations(self.sun_direction)

    def _place_deviations(self, direction: FloatArray) -> FloatArray:
        x, y, z = self._flat(direction)
        with np.errstate(divide="ignore", invalid="ignore"):
            across = np.hypot(x, y)
            by_longitude = np.stack([x * z / across**2, y * z / across**2, -np.ones(x.size)])
            by_latitude = np.stack([-y / across, x / across, np.zeros(x.size)])
        wxyz = self._flat(self.attitude.wxyz).T
        found = [
            turned_deviations(self.turn_covariance, quaternion.rotate(wxyz, gradient.T))
            for gradient in (by_longitude, by_latitude)
        ]
        return self._rows(np.stack(found))

    # Angles ---------------------------------------------------------------------------------------

    @quantity("rad")
    def phase_angle_sigma(self) -> FloatArray:
        """Standard deviation of phase_angle: 0, since it does not depend on the attitude."""
        return np.zeros(self.shape)

    @quantity("rad")
    def aspect_angle_sigma(self) -> FloatArray:
        """Standard deviation of aspect_angle; NaN where the angle is 0 or pi."""
        return self._angle_to_momentum_deviations(self.observer_line.unit)

    @quantity("rad")
    def sun_aspect_angle_sigma(self) -> FloatArray:
        """Standard deviation of sun_aspect_angle; NaN where the angle is 0 or pi."""
        return self._angle_to_momentum_deviations(self.sun_line.unit)

    def _angle_to_momentum_deviations(self, unit: FloatArray) -> FloatArray:
        covariance = self._motion().momentum_covariance
        axis = self._in_rows(self.momentum_direction_icrf)
        tilt = np.cross(axis, _axis_of(axis, self._in_rows(unit)))
        size = np.linalg.norm(np.asarray(self._motion().momentum))
        return self._numbers(turned_deviations(covariance, tilt) / size)

    @quantity("rad", _AXES)
    def observer_axis_angles_sigma(self) -> FloatArray:
        """Standard deviations of observer_axis_angles; NaN where an angle is 0 or pi."""
        return self._axis_deviations(self.observer_line.unit)

    @quantity("rad", _AXES)
    def sun_axis_angles_sigma(self) -> FloatArray:
        """Standard deviations of sun_axis_angles; NaN where an angle is 0 or pi."""
        return self._axis_deviations(self.sun_line.unit)

    def _axis_deviations(self, unit: FloatArray) -> FloatArray:
        body = self._body("a principal axis")
        direction = self._in_rows(unit)
        found = []
        for k in np.argsort(body.moments, kind="stable"):
            axis = self._in_icrf(body.principal_axes[:, k]).T
            found.append(turned_deviations(self.turn_covariance, _axis_of(axis, direction)))
        return self._rows(np.stack(found))

    @quantity("rad")
    def long_axis_position_angle_sigma(self) -> FloatArray:
        """Standard deviation of long_axis_position_angle; NaN for an axis along the line."""
        axis = self._in_icrf(self._long_axis()).T
        sight = self._flat(self.apparent_direction).T
        # The part across the line of sight turns about that line.
        part = axis - np.sum(axis * sight, axis=-1, keepdims=True) * sight
        across = np.cross(sight, part)
        with np.errstate(divide="ignore", invalid="ignore"):
            gradient = np.cross(axis, across) / np.sum(part * part, axis=-1, keepdims=True)
        return self._deviations(gradient)

    # Light ----------------------------------------------------------------------------------------

    @quantity("m2 / sr")
    def brightness_sigma(self) -> FloatArray:
        """Standard deviation of brightness, by differences over one standard deviation."""
        bright = np.asarray(self.brightness).reshape(-1)
        known = np.flatnonzero(np.isfinite(bright))
        out = np.full(bright.size, np.nan)
        if not known.size:
            return self._numbers(out)
        to_icrf = quaternion.matrix(self._flat(self.attitude.wxyz).T[known])
        covariance = np.swapaxes(to_icrf, -1, -2) @ self.turn_covariance[known] @ to_icrf
        values, axes = np.linalg.eigh(covariance)
        size = np.sqrt(np.maximum(values, 0.0))
        step = np.maximum(size, self._least_step())
        pair = [self._flat(v).T[known] for v in (self.sun_direction, self.observer_direction)]
        total = np.zeros(known.size)
        for k in range(3):
            turn = forms.from_rotation_vector(axes[:, :, k] * step[:, [k]])
            ahead = self._brightness_of(*(quaternion.rotate(turn, v) for v in pair))
            back = quaternion.conjugate(turn)
            behind = self._brightness_of(*(quaternion.rotate(back, v) for v in pair))
            total += (0.5 * (ahead - behind) * (size[:, k] / step[:, k])) ** 2
        out[known] = np.sqrt(total)
        return self._numbers(out)

    def _least_step(self) -> float:
        """The least turn that the brightness of the shape resolves, rad."""
        from attitude.light_curve import Visibility
        from attitude.shape import Mesh

        shape, shadows = self.scene.shape, self.scene.shadows
        if not isinstance(shape, Mesh) or shape.is_convex or shadows is False:
            return _LEAST_STEP
        cells = shadows.resolution if isinstance(shadows, Visibility) else _CELLS
        return 0.5 * math.pi / cells

    @quantity("mag")
    def reduced_magnitude_sigma(self) -> FloatArray:
        """Standard deviation of reduced_magnitude; NaN where nothing is seen."""
        return self._magnitude_deviations(self.reduced_magnitude)

    @quantity("mag")
    def magnitude_sigma(self) -> FloatArray:
        """Standard deviation of magnitude; NaN where nothing is seen."""
        return self._magnitude_deviations(self.magnitude)

    def _magnitude_deviations(self, magnitude: FloatArray) -> FloatArray:
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.asarray(self.brightness_sigma) / self.brightness
        return np.where(np.isfinite(magnitude), _MAGNITUDES * relative, np.nan)


def _axis_of(axis: FloatArray, direction: FloatArray) -> FloatArray:
    """The unit vectors (N, 3) about which a turn brings the axes to the directions; NaN for none.

    A turn about it changes the angle between them, one about any vector across it does not.
    """
    found = np.cross(axis, direction)
    size = np.sqrt(np.sum(found * found, axis=-1, keepdims=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(found / size)
