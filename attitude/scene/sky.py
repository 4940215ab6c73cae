"""The quantities of a view that the observer measures on the sky."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from attitude import paths
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.scene import angles, lines_of_sight
from attitude.scene.lazy import kept, quantity
from attitude.scene.pointing import Pointing

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# Largest error of a fitted zenith, rad: of the sum of some hundred roundings.
_LEAST_TURN = 1e-13


class Sky(Pointing):
    """Base of `View`: adds positions and angles on the observer's sky.

    With ``aberration=True`` in the scene, all of them are as the moving observer sees them.
    """

    @kept
    def observer_velocity(self) -> FloatArray:
        """Barycentric velocity (3, N) of the observer at the epochs of reception, m/s, ICRF."""
        scene = self.scene
        hi, lo = self._reception()
        # An observer that is a direction is refused by `relative`.
        observer = cast("paths.Path", scene.observer)
        path = paths.relative(observer, "ssb", scene.ephemeris)
        return np.moveaxis(path.velocity(self.epoch, hi, lo), -1, 0)

    def _seen(self, unit: FloatArray) -> FloatArray:
        """Directions (3, N) from the observer, aberrated if the scene has aberration=True."""
        if not self.scene.aberration or self.scene.observer.is_direction:
            return unit
        return angles.aberrated(unit, self.observer_velocity, SPEED_OF_LIGHT_M_S)

    @quantity("", ("x", "y", "z"))
    def apparent_direction(self) -> FloatArray:
        """Unit vector from the observer to the body, ICRF; aberrated if aberration=True."""
        return self._rows(self._seen(-self.observer_line.unit))

    @quantity("rad", ("right_ascension", "declination"))
    def apparent_position(self) -> FloatArray:
        """Right ascension (0 to 2 pi) and declination of apparent_direction, ICRF."""
        return self._rows(angles.longitude_and_latitude(self._flat(self.apparent_direction)))

    @quantity("rad")
    def solar_elongation(self) -> FloatArray:
        """Angle at the observer between the Sun and the body, 0 to pi."""
        body = self._flat(self.apparent_direction)
        sun = self._seen(self.observer_sun_line.unit)
        return self._numbers(angles.between_units(body, sun))

    @quantity("rad")
    def long_axis_position_angle(self) -> FloatArray:
        """Angle on the sky from north (ICRF) through east to the positive long axis, 0 to 2 pi."""
        axis = self._in_icrf(self._long_axis())
        return self._numbers(angles.position_angle(axis, self._flat(self.apparent_direction)))

    @quantity("rad")
    def elevation(self) -> FloatArray:
        """Elevation of the body above the horizon of a ground site, -pi/2 to pi/2, unrefracted."""
        hi, lo = self._reception()
        scene, some = self.scene, self._reception_sample
        tolerance = None if scene.tolerance is None else _LEAST_TURN
        path = scene.observer.zenith_path
        up = lines_of_sight.seen(path, self.epoch, hi, lo, some, tolerance).unit
        zenith_distance = angles.between_units(up, self._flat(self.apparent_direction))
        return self._numbers(0.5 * np.pi - zenith_distance)
