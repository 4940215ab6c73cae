"""The quantities of a view that need a shape: brightness and magnitudes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.scene.lazy import kept, quantity
from attitude.scene.sky import Sky

if TYPE_CHECKING:
    from attitude.annotations import FloatArray


class Brightness(Sky):
    """Base of `View`: adds the brightness of the scene's shape under its scattering law."""

    @quantity("m2 / sr")
    def brightness(self) -> FloatArray:
        """Intensity towards the observer over the Sun's irradiance on the body, in sunlight."""
        scene = self.scene
        if scene.shape is None:
            raise AttitudeError(
                "brightness needs a shape, and the scene has none; give it shape=, an Ellipsoid or "
                "Mesh of attitude.shape."
            )
        sun, observer = (self._flat(v) for v in (self.sun_direction, self.observer_direction))
        known = np.flatnonzero(np.isfinite(sun[0]))
        is_whole = known.size == self.seconds.size
        if not is_whole:
            sun, observer = np.ascontiguousarray(sun[:, known]), observer[:, known]
        found = self._brightness_of(sun.T, observer.T)
        if not is_whole:
            found, some = np.full(self.seconds.size, np.nan), found
            found[known] = some
        return self._numbers(found)

    def _brightness_of(self, sun: FloatArray, observer: FloatArray) -> FloatArray:
        """The brightness (K,) of the shape for directions (K, 3) in body axes."""
        from attitude import light_curve

        scene = self.scene
        assert scene.shape is not None  # `brightness` refuses a scene without one
        return light_curve.brightness(
            scene.shape, scene.law, sun, observer, shadows=scene.shadows, threads=scene.threads
        )

    @quantity("mag")
    def reduced_magnitude(self) -> FloatArray:
        """Magnitude at 1 au from Sun and observer, V(1, 1, alpha), in full sunlight."""
        from attitude import light_curve

        bright, scene = np.asarray(self.brightness).reshape(-1), self.scene
        known = ~np.isnan(bright)
        out = np.full(bright.size, np.nan)
        if not known.any():
            return self._numbers(out)
        if scene.phase_function is None:
            band = scene.sun_magnitude
            given = {} if band is None else {"sun_magnitude": band}
            out[known] = light_curve.reduced_magnitude(bright[known], **given)
        else:
            assert scene.shape is not None  # `brightness` refuses a scene without one
            angles = np.asarray(self.phase_angle).reshape(-1)[known]
            out[known] = light_curve.phased_magnitude(
                bright[known], scene.shape, scene.law, angles, scene.phase_function
            )
        return self._numbers(out)

    @quantity("mag")
    def magnitude(self) -> FloatArray:
        """Apparent magnitude, in the shadow that other bodies cast; inf where nothing is seen.

        From a ground site NaN by day and below the horizon, unless site_limits=False.
        """
        return self.as_observed(self.magnitude_everywhere)

    def as_observed(self, magnitude: FloatArray) -> FloatArray:
        """Magnitudes (S), NaN where a ground site with limits does not observe."""
        scene = self.scene
        if not (scene.site_limits and scene.observer.has_horizon):
            return magnitude
        return np.where(self.is_observable, magnitude, np.nan)[()]

    @kept
    def magnitude_everywhere(self) -> FloatArray:
        """`magnitude` (S), whether or not a ground site observes the body."""
        from attitude.light_curve import magnitudes

        for line, name in ((self.sun_line, "sun"), (self.observer_line, "observer")):
            if line.distance is None:
                raise AttitudeError(
                    f"the {name} is a direction, infinitely far away, for which an apparent "
                    "magnitude is undefined; use reduced_magnitude, or give a path."
                )
        found = np.array(self.reduced_magnitude).reshape(-1)
        known = ~np.isnan(found)
        far = [
            np.asarray(each).reshape(-1)[known]
            for each in (self.sun_distance, self.observer_distance)
        ]
        found[known] += magnitudes.distance_modulus(*far)
        if self.scene.shadow_of:
            found += magnitudes.dimming(self.lit_fraction.reshape(-1))
        return self._numbers(found)
