"""The part of a view that the observer measures on the sky."""

import numpy as np

from attitude import paths
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.scene import angles
from attitude.scene.lazy import kept, quantity


class Sky:
    """Mixed into `View`.  With ``aberration=True`` all of it is as the moving observer sees it."""

    @kept
    def observer_velocity(self):
        """Barycentric velocity (3, N) of the observer at the epochs of reception, m/s, ICRF."""
        scene = self.scene
        hi, lo = self._reception()
        path = paths.relative(scene.observer, "ssb", scene.ephemeris)
        return np.moveaxis(path.velocity(self.epoch, hi, lo), -1, 0)

    def _seen(self, unit):
        """Directions (3, N) from the observer as the scene wants them."""
        if not self.scene.aberration or self.scene.observer.is_direction:
            return unit
        return angles.aberrated(unit, self.observer_velocity, SPEED_OF_LIGHT_M_S)

    @quantity("", ("x", "y", "z"))
    def apparent_direction(self):
        """Unit vector from the observer to the body, ICRF; aberrated if the scene says so."""
        return self._rows(self._seen(-self.observer_line.unit))

    @quantity("rad", ("right_ascension", "declination"))
    def apparent_position(self):
        """Right ascension (0 to 2 pi) and declination of apparent_direction, ICRF."""
        return self._rows(angles.longitude_and_latitude(self._flat(self.apparent_direction)))

    @quantity("rad")
    def solar_elongation(self):
        """Angle at the observer between the Sun and the body, 0 to pi."""
        body = self._flat(self.apparent_direction)
        sun = self._seen(np.broadcast_to(self.observer_sun_line.unit, body.shape))
        return self._numbers(angles.between(body, sun))

    @quantity("rad")
    def long_axis_position_angle(self):
        """On the sky, from north (ICRF) through east to the positive long axis, 0 to 2 pi."""
        axis = self._in_icrf(self._long_axis())
        return self._numbers(angles.position_angle(axis, self._flat(self.apparent_direction)))

    @quantity("rad")
    def elevation(self):
        """Of the body above the horizon of a ground site, -pi/2 to pi/2, without refraction."""
        hi, lo = self._reception()
        up = np.moveaxis(self.scene.observer.zenith(self.epoch, hi, lo), -1, 0)
        return self._numbers(0.5 * np.pi - angles.between(up, self._flat(self.apparent_direction)))
