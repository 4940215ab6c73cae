"""Brightness and magnitudes of the members of an ensemble."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from attitude import validation
from attitude.ensemble import light
from attitude.ensemble.attitudes import Evaluated
from attitude.light_curve.magnitudes import SUN_V

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray, Real, Reals
    from attitude.light_curve.visibility import Visibility
    from attitude.scattering import Law


class Lit(Evaluated):
    """Base of `Ensemble`: light at epochs."""

    def brightness(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        *,
        shape: Any,
        law: str | Law = "lommel-seeliger",
        shadows: bool | Visibility = True,
        low: ArrayLike | None = None,
        threads: int = 1,
        out: FloatArray | None = None,
        _magnitudes: tuple[float, bool] | None = None,
    ) -> FloatArray:
        """Intensity towards the observer over the Sun's irradiance, straight from the states.

        Parameters
        ----------
        t, member, low
            The epochs at which light leaves the body, as of `at`.
        sun, observer : (..., 3) array_like
            Vectors from the body in ICRF, of any length above zero, that broadcast to (S, 3);
            NaN gives NaN.
        shape : Ellipsoid, Mesh, N of them, or (3,) or (N, 3) array_like
            Arrays are semi-axes of ellipsoids along the body axes, m.
        law, shadows
            As of `light_curve.brightness`: ellipsoids need a law with a closed form.
        threads : int
            Number of threads; the bits of the answer do not depend on it.
        out : (S) float64 array in C order, optional

        Returns
        -------
        (S) array
            m2/sr.

        Raises
        ------
        AttitudeError
            As `at` and `light_curve.brightness`; for a shape that is missing.
        """
        found = self._epochs(t, low, member)
        to_sun = light.known_vectors(sun, "sun", found.shape)
        to_observer = light.known_vectors(observer, "observer", found.shape)
        shapes = light.known_shapes(shape, len(self), self.label)
        raises = self.on_error == "raise"
        source = light.Light(self._members, self.label, shapes, law, shadows, raises)
        result = light.output(out, found.shape)
        flat = result.reshape(-1)
        # Of the methods below: the Sun at 1 au, and whether at the lengths of the vectors.
        source.fill(found, to_sun, to_observer, flat, threads, *(_magnitudes or (None, False)))
        return result

    def reduced_magnitude(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        *,
        sun_magnitude: Real = SUN_V,
        **options: Any,
    ) -> FloatArray:
        """Magnitudes (S) at 1 au from Sun and observer: V(1, 1, alpha); inf where nothing is seen.

        Arguments as of `brightness`; `sun_magnitude` is that of the Sun at 1 au, by default in
        Johnson V.
        """
        band = validation.number(sun_magnitude, "sun_magnitude", unit="mag")
        return self.brightness(t, member, sun, observer, _magnitudes=(band, False), **options)

    def magnitude(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        *,
        sun_magnitude: Real = SUN_V,
        **options: Any,
    ) -> FloatArray:
        """Apparent magnitudes (S), for vectors to Sun and observer in m or Quantities.

        Arguments as of `reduced_magnitude`.
        """
        band = validation.number(sun_magnitude, "sun_magnitude", unit="mag")
        return self.brightness(t, member, sun, observer, _magnitudes=(band, True), **options)
