"""The pressure of sunlight on the facets of a body (the YORP effect, solar torque)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from attitude._support import validation
from attitude._support.arrays import frozen
from attitude._support.constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude.errors import AttitudeError
from attitude.torques._torque import Torque, path_of, positions, span_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.paths._path import Path
    from attitude.torques._torque import PositionFunction


SOLAR_CONSTANT: float = 1361.0  # W/m2 at 1 au: Kopp & Lean 2011


class FlatFacets(Protocol):
    """A shape of N flat facets, such as a `Mesh`, in the coordinates of `Body.from_shape`."""

    @property
    def areas(self) -> NDArray[Any]:
        """Areas (N,), m2."""

    @property
    def normals(self) -> NDArray[Any]:
        """Unit vectors (N, 3) outwards, body axes."""

    @property
    def centroids(self) -> NDArray[Any]:
        """Centroids (N, 3), m."""


@dataclass(frozen=True, eq=False, init=False)
class SolarRadiation(Torque):
    """The torque of sunlight on flat facets.

    Parameters
    ----------
    shape : FlatFacets
        Object with ``areas`` (N,) m2, ``normals`` (N, 3) and ``centroids`` (N, 3) m in the
        coordinates of `Body.from_shape`, such as a mesh.
    path : Path, or function
        The body's position from the Sun, m; see `GravityGradient`.
    diffuse, mirrored : float or (N,) array_like
        Fractions of the light that leave a facet by Lambert's law and as from a mirror, together
        at most 1; the rest is absorbed.  Absorbed light that is radiated at once as heat leaves by
        Lambert's law too: diffuse=1 is Rubincam's approximation of YORP.
    flux : float or Quantity
        W/m2 at 1 au.

    Attributes
    ----------
    path : Path
    diffuse, mirrored : (N,) float64 arrays, read-only
    flux : float
        W/m2.

    Raises
    ------
    AttitudeError
        For a shape without these attributes, a path of another type, fractions outside of 0 to 1,
        a flux that is not positive.

    Notes
    -----
    Facets do not shade each other: exact for convex shapes.  Force on a facet: Wertz (1978),
    Spacecraft Attitude Determination and Control, eq. 17-35.  Rubincam (2000), Icarus 148, 2.

    The torque has a kink where a facet turns into the light: schemes of any order err there by the
    second power of the step.
    """

    shape: FlatFacets
    path: Path
    diffuse: FloatArray
    mirrored: FloatArray
    flux: float
    columns = 3

    def __init__(
        self,
        shape: FlatFacets,
        path: Path | PositionFunction,
        diffuse: Real | Reals = 1.0,
        mirrored: Real | Reals = 0.0,
        flux: Real = SOLAR_CONSTANT,
    ) -> None:
        self._set("shape", shape)
        self._set("path", path_of(path, "path"))
        missing = [x for x in ("areas", "normals", "centroids") if not hasattr(shape, x)]
        if missing:
            raise AttitudeError(
                f"shape is {type(shape).__name__} without {', '.join(missing)}; give a mesh."
            )
        areas = np.asarray(shape.areas)
        if areas.ndim != 1 or areas.dtype.kind not in "fiu":
            raise AttitudeError(
                f"shape is {validation.shown(shape)}, whose areas are "
                f"{validation.shown(shape.areas)}; give a mesh, or areas (N,) in m2."
            )
        count = len(areas)
        for name, fraction in (("diffuse", diffuse), ("mirrored", mirrored)):
            given = validation.broadcast(
                validation.real(fraction, name), name, (count,), "facet of the shape"
            )
            self._set(name, frozen(given.copy()))
        total = self.diffuse + self.mirrored
        if min(self.diffuse.min(), self.mirrored.min()) < 0.0 or total.max() > 1.0:
            raise AttitudeError(
                "diffuse and mirrored are fractions of the light: not negative, at most 1 "
                f"together; given up to {total.max():.3g}."
            )
        self._set("flux", validation.positive(flux, "flux", unit="W/m2"))

    def address(self) -> int:
        """Address of `_compiled.solar_radiation`."""
        from attitude.torques._compiled import solar_radiation

        return solar_radiation.address

    def parameters(self, body: Body) -> FloatArray:
        """The parameters (2 + 12 N,) of `_compiled.solar_radiation`.

        Raises
        ------
        AttitudeError
            For a body whose moments are relative.
        """
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

    def span(self, instant: Instant) -> tuple[float, float]:
        """First and last TDB seconds since an instant that the path covers."""
        return span_of(self.path, instant)

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """The body's positions (K, 3) from the Sun in m, ICRF axes."""
        return positions(self.path, instant, seconds, low, "path")
