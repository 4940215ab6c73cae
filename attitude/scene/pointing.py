"""The quantities of a view that need the attitude: Sun and observer in body axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.immutable import frozen, read_only
from attitude.memory import new_array
from attitude.scene import angles
from attitude.scene.geometry import Geometry
from attitude.scene.lazy import kept, quantity

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.history import AttitudeHistory
    from attitude.motion import Motion

_INVERSE = np.array([[-1.0], [1.0], [1.0], [1.0]])
_XYZ = ("x", "y", "z")
_AXES = ("least", "middle", "greatest")
_PLACE = ("longitude", "latitude")


class Pointing(Geometry):
    """Base of `View`: adds directions in body axes, and angles to axes of the body."""

    @kept
    def attitude(self) -> AttitudeHistory:
        """The AttitudeHistory (S) of the body at the epochs of emission."""
        hi, lo = self.emission
        low = None if lo is None else lo.reshape(self.shape)
        return self._motion().at_seconds(hi.reshape(self.shape), low)

    def _motion(self) -> Motion:
        if self.scene.motion is None:
            raise AttitudeError(
                "the attitude of the body is needed, but the scene was made with motion=None; "
                "give a motion, or use quantities that need none, such as sun_direction_icrf or "
                "phase_angle."
            )
        return self.scene.motion

    def _wxyz(self) -> FloatArray:
        return read_only(np.ascontiguousarray(self._flat(self.attitude.wxyz)))

    def _in_body(self, unit: FloatArray) -> FloatArray:
        """ICRF vectors (3, N) or (3, 1) as (3, N) in body axes."""
        from attitude.solution import vectors

        out = new_array(3, self.seconds.size)
        vectors.to_body(self._wxyz(), read_only(np.ascontiguousarray(unit)), out)
        return out

    def _in_icrf(self, vector: FloatArray) -> FloatArray:
        """A body vector (3,) as (3, N) in ICRF."""
        from attitude.solution import vectors

        wxyz, column = self._wxyz(), read_only(vector.reshape(3, 1).copy())
        out = new_array(3, self.seconds.size)
        for part in angles.parts(out.shape[1]):
            # with -w the inverse rotation
            inverse, found = wxyz[:, part] * _INVERSE, np.empty((3, out[0, part].size))
            vectors.to_body(frozen(inverse), column, found)
            out[:, part] = found
        return out

    @quantity("", _XYZ)
    def observer_direction(self) -> FloatArray:
        """Unit vector from the body to the observer, body axes."""
        return self._rows(self._in_body(self.observer_line.unit))

    @quantity("", _XYZ)
    def sun_direction(self) -> FloatArray:
        """Unit vector from the body to the Sun, body axes."""
        return self._rows(self._in_body(self.sun_line.unit))

    @quantity("rad", _PLACE)
    def sub_observer(self) -> FloatArray:
        """East longitude (0 to 2 pi, x towards y) and latitude (to z) of observer_direction."""
        return self._rows(angles.longitude_and_latitude(self._flat(self.observer_direction)))

    @quantity("rad", _PLACE)
    def sub_solar(self) -> FloatArray:
        """East longitude (0 to 2 pi, x towards y) and latitude (to z) of sun_direction."""
        return self._rows(angles.longitude_and_latitude(self._flat(self.sun_direction)))

    @kept
    def momentum_direction_icrf(self) -> FloatArray:
        """Unit vector (3, N) or (3, 1) of the angular momentum, ICRF; (3, 1) if it is constant."""
        motion = self._motion()
        if motion.momentum is not None:
            momentum = np.asarray(motion.momentum, dtype=np.float64)[:, None]
        else:
            in_body = motion.momentum_in_body(self.attitude)
            momentum = self._flat(self.attitude.body_to_inertial(in_body))
        size = np.sqrt(np.sum(momentum * momentum, axis=0))
        if np.any(size == 0.0):
            raise AttitudeError(
                "the body is at rest, so that its angular momentum has no direction; use angles to "
                "its axes instead."
            )
        return momentum / size

    @quantity("rad")
    def aspect_angle(self) -> FloatArray:
        """Angle between the direction to the observer and the angular momentum, 0 to pi."""
        return self._angle_to_momentum(self.observer_line.unit)

    @quantity("rad")
    def sun_aspect_angle(self) -> FloatArray:
        """Angle between the direction to the Sun and the angular momentum, 0 to pi."""
        return self._angle_to_momentum(self.sun_line.unit)

    def _angle_to_momentum(self, unit: FloatArray) -> FloatArray:
        return self._numbers(angles.between_units(unit, self.momentum_direction_icrf))

    @quantity("rad", _AXES)
    def observer_axis_angles(self) -> FloatArray:
        """Angles from the direction to the observer to the principal axes, 0 to pi.

        The axes are in ascending order of their moments of inertia, in the senses of the columns of
        ``body.principal_axes``.
        """
        return self._axis_angles(self.observer_direction)

    @quantity("rad", _AXES)
    def sun_axis_angles(self) -> FloatArray:
        """Angles from the direction to the Sun to the principal axes, 0 to pi.

        The axes are in ascending order of their moments of inertia, in the senses of the columns of
        ``body.principal_axes``.
        """
        return self._axis_angles(self.sun_direction)

    def _axis_angles(self, direction: FloatArray) -> FloatArray:
        body = self._body("a principal axis")
        order = np.argsort(body.moments, kind="stable")
        flat, found = self._flat(direction), new_array(3, self.seconds.size)
        for row, k in zip(found, order, strict=True):
            row[:] = angles.between_units(body.principal_axes[:, [k]], flat)
        return self._rows(found)

    def _body(self, what: str) -> Body:
        return self._motion().constant_body(what)

    def _long_axis(self) -> FloatArray:
        """Unit vector (3,) in body axes of the axis of least moment of inertia."""
        body = self._body("the long axis")
        least = body.moments == body.moments.min()
        if np.sum(least) > 1:
            raise AttitudeError(
                f"the body has no long axis: {np.sum(least)} of its moments of inertia are the "
                "least one; use the angles to other axes."
            )
        return body.principal_axes[:, int(np.argmax(least))]
