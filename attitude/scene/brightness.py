"""The part of a view that needs a shape: how bright the body is."""

import numpy as np

from attitude.errors import AttitudeError
from attitude.scene.quantity import quantity


class Brightness:
    """Mixed into `View`."""

    @quantity("m2 / sr")
    def brightness(self):
        """Intensity towards the observer over the Sun's irradiance on the body, in sunlight."""
        from attitude import light_curve

        scene = self.scene
        if scene.shape is None:
            raise AttitudeError(
                "brightness needs a shape; give the scene shape=, an Ellipsoid or Mesh of "
                "attitude.shape."
            )
        sun, observer = (self._flat(v) for v in (self.sun_direction, self.observer_direction))
        known = np.flatnonzero(np.isfinite(sun[0]))
        is_whole = known.size == self.seconds.size
        if not is_whole:
            sun, observer = np.ascontiguousarray(sun[:, known]), observer[:, known]
        found = light_curve.brightness(
            scene.shape, scene.law, sun.T, observer.T, shadows=scene.shadows, threads=scene.threads
        )
        if not is_whole:
            found, some = np.full(self.seconds.size, np.nan), found
            found[known] = some
        return self._numbers(found)

    @quantity("mag")
    def reduced_magnitude(self):
        """Magnitude at 1 au from Sun and observer, V(1, 1, alpha), in full sunlight."""
        return self._magnitude(self.brightness)

    @quantity("mag")
    def magnitude(self):
        """Apparent magnitude, in the shadow that other bodies cast; inf where nothing is seen."""
        for found, name in ((self.sun_line, "sun"), (self.observer_line, "observer")):
            if found.distance is None:
                raise AttitudeError(
                    f"the {name} is a direction, infinitely far away, where an apparent magnitude "
                    "has no meaning; ask for reduced_magnitude, or give a path."
                )
        lit = self.brightness * self.lit_fraction if self.scene.shadow_of else self.brightness
        return self._magnitude(lit, self.sun_distance, self.observer_distance)

    def _magnitude(self, brightness, *distances):
        from attitude.light_curve import magnitudes

        given = np.asarray(brightness).reshape(-1)
        known = ~np.isnan(given)
        band = self.scene.sun_magnitude
        band = magnitudes.SUN_V if band is None else band
        out = np.full(given.size, np.nan)
        far = [np.asarray(each).reshape(-1)[known] for each in distances]
        made = magnitudes.apparent_magnitude if far else magnitudes.reduced_magnitude
        if known.any():
            out[known] = made(given[known], *far, sun_magnitude=band)
        return self._numbers(out)
