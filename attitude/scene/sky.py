"""The quantities of a view that the observer measures on the sky."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from attitude import paths
from attitude.errors import AttitudeError
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.scene import angles, lines_of_sight
from attitude.scene.lazy import kept, quantity
from attitude.scene.pointing import Pointing

if TYPE_CHECKING:
    from attitude.annotations import BoolArray, FloatArray
    from attitude.scene.lines_of_sight import LineOfSight

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
        return self._elevation_of(self._flat(self.apparent_direction))

    @kept
    def zenith(self) -> FloatArray:
        """Unit vectors (3, N) to the zenith of a ground site at the epochs of reception, ICRF."""
        hi, lo = self._reception()
        scene, some = self.scene, self._reception_sample
        tolerance = None if scene.tolerance is None else _LEAST_TURN
        path = scene.observer.zenith_path
        return lines_of_sight.seen(path, self.epoch, hi, lo, some, tolerance).unit

    def _elevation_of(self, direction: FloatArray) -> FloatArray:
        return self._numbers(0.5 * np.pi - angles.between_units(self.zenith, direction))

    @quantity("rad")
    def azimuth(self) -> FloatArray:
        """Azimuth of the body at a ground site, from north through east, 0 to 2 pi."""
        direction = self._flat(self.apparent_direction)
        # The pole of ITRS: north on the horizon of the site.
        pole = np.moveaxis(self.scene.observer.pole(self.epoch, *self._reception()), -1, 0)
        east = np.cross(pole, self.zenith, axis=0)
        north = np.cross(self.zenith, east, axis=0)
        along = (np.sum(each * direction, axis=0) for each in (east, north))
        return self._numbers(angles.turned_positive(np.arctan2(*along)))

    # The sky of a ground site -------------------------------------------------------------------

    @quantity("rad")
    def sun_elevation(self) -> FloatArray:
        """Elevation of the Sun's centre above the horizon of a ground site, unrefracted."""
        zenith = self.zenith  # an observer without a horizon is refused first
        sun = np.broadcast_to(self.observer_sun_line.unit, zenith.shape)
        return self._elevation_of(self._seen(sun))

    @kept
    def moon_line(self) -> LineOfSight:
        """The `LineOfSight` from the observer at reception to the Moon when its light left; m."""
        scene = self.scene
        if scene.observer.is_direction:
            raise AttitudeError(
                "the observer is a direction, infinitely far away, where the direction to the Moon "
                "is undefined; give a path as the observer."
            )
        return self._sight("moon", scene.observer)

    @quantity("rad")
    def moon_elevation(self) -> FloatArray:
        """Elevation of the Moon's centre above the horizon of a ground site, unrefracted."""
        zenith = self.zenith
        return self._elevation_of(self._seen(np.broadcast_to(self.moon_line.unit, zenith.shape)))

    @quantity("rad")
    def moon_separation(self) -> FloatArray:
        """Angle at the observer between the Moon's centre and the body, 0 to pi."""
        body = self._flat(self.apparent_direction)
        moon = self._seen(np.broadcast_to(self.moon_line.unit, body.shape))
        return self._numbers(angles.between(body, moon))

    @quantity()
    def airmass(self) -> FloatArray:
        """Relative air mass towards the body by Young (1994), 1 at the zenith; NaN below 0 deg."""
        return self._numbers(angles.air_mass(np.asarray(self.elevation).reshape(-1)))

    @quantity()
    def sky_dark(self) -> BoolArray:
        """Whether the Sun at a ground site is lower than ``scene.night``."""
        sun = np.asarray(self.sun_elevation).reshape(-1)
        return self._flags(sun < self.scene.night)

    @quantity()
    def is_observable(self) -> BoolArray:
        """Whether a ground site has the body above its horizon, and a dark sky; True elsewhere."""
        if not self.scene.observer.has_horizon:
            return self._flags(~np.isnan(self.seconds.reshape(-1)))
        up = np.asarray(self.elevation).reshape(-1) > 0.0
        return self._flags(up & np.asarray(self.sky_dark).reshape(-1))
