"""The pressure of sunlight on the facets of a body (the YORP effect, solar torque)."""

from dataclasses import dataclass

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude.torques.torque import Torque, path_of, positions, span_of

SOLAR_CONSTANT = 1361.0  # W/m2 at 1 au: Kopp & Lean 2011


@dataclass(frozen=True, eq=False)
class SolarRadiation(Torque):
    """The torque of sunlight on flat facets.

    Parameters
    ----------
    shape : object with ``areas`` (N,) m2, ``normals`` (N, 3) and ``centroids`` (N, 3) m
        In the coordinates of `Body.from_shape`, such as a mesh.
    path : Path, or function
        The body's position from the Sun, m; see `GravityGradient`.
    diffuse, mirrored : float or (N,) array_like
        Fractions of the light that leave a facet by Lambert's law and as from a mirror, together
        at most 1; the rest is absorbed.  What is absorbed and radiated at once as heat leaves by
        Lambert's law too: diffuse=1 is Rubincam's approximation of YORP.
    flux : float
        W/m2 at 1 au.

    Notes
    -----
    Facets do not shade each other: exact for convex shapes.  Force on a facet: Wertz (1978),
    Spacecraft Attitude Determination and Control, eq. 17-35.  Rubincam (2000), Icarus 148, 2.

    The torque has a kink where a facet turns into the light: schemes of any order err there by the
    second power of the step.
    """

    shape: object
    path: object
    diffuse: np.ndarray = 1.0
    mirrored: np.ndarray = 0.0
    flux: float = SOLAR_CONSTANT
    columns = 3

    def __post_init__(self):
        self._set("path", path_of(self.path, "path"))
        missing = [x for x in ("areas", "normals", "centroids") if not hasattr(self.shape, x)]
        if missing:
            raise AttitudeError(
                f"shape is {type(self.shape).__name__} without {', '.join(missing)}; give a mesh."
            )
        count = len(self.shape.areas)
        for name in ("diffuse", "mirrored"):
            given = np.broadcast_to(validation.real(getattr(self, name), name), (count,)).copy()
            self._set(name, frozen(given))
        total = self.diffuse + self.mirrored
        if min(self.diffuse.min(), self.mirrored.min()) < 0.0 or total.max() > 1.0:
            raise AttitudeError(
                "diffuse and mirrored are fractions of the light: not negative, at most 1 "
                f"together; given up to {total.max():.3g}."
            )
        self._set("flux", validation.positive(self.flux, "flux", unit="W/m2"))

    def address(self):
        from attitude.torques.compiled import solar_radiation

        return solar_radiation.address

    def parameters(self, body):
        if body.relative:
            raise AttitudeError(
                "the moments of the body are relative, and light pressure is in newtons; give a "
                "Body with moments in kg m2."
            )
        arms = np.asarray(self.shape.centroids) - body.center_of_mass
        normals = np.asarray(self.shape.normals)
        vectors = np.concatenate([normals, arms, np.cross(arms, normals)], axis=1).T
        rows = [self.shape.areas, *vectors, self.diffuse, self.mirrored]
        strength = self.flux / SPEED_OF_LIGHT_M_S * ASTRONOMICAL_UNIT_M**2
        return np.concatenate([[strength, len(arms)], np.ravel(rows)])

    def span(self, instant):
        return span_of(self.path, instant)

    def sample(self, instant, seconds, low):
        return positions(self.path, instant, seconds, low, "path")
