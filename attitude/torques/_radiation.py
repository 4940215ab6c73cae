"""The push of sunlight and of thin air on the facets of a body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from attitude._support import pairs, validation
from attitude._support.arrays import frozen
from attitude._support.constants import (
    ASTRONOMICAL_UNIT_M,
    EARTH_RADIUS_M,
    SPEED_OF_LIGHT_M_S,
    SUN_RADIUS_M,
)
from attitude.errors import AttitudeError
from attitude.frames import _earth
from attitude.light_curve._brightness import cells_of_directions
from attitude.light_curve._visibility import Visibility
from attitude.paths._ground import RATE as EARTH_RATE_RAD_S
from attitude.paths._path import Path
from attitude.scene import _shadow
from attitude.shape._mesh import Mesh
from attitude.torques._torque import Torque, address_of, path_of, positions, refuse_relative

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.torques._torque import AnyPath


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
    shadows : bool or Visibility
        Whether facets shade each other: the table of `attitude.light_curve.Visibility`, of a `Mesh`
        only.  False is exact for convex shapes.
    shadow_of : Path, mapping, or sequence of Paths
        Bodies that eclipse the Sun: their paths from the Sun, with a name such as "earth" whose
        radius is known; or a mapping from paths to radii, m.

    Attributes
    ----------
    path : Path
    diffuse, mirrored : (N,) float64 arrays, read-only
    flux : float
        W/m2.
    shadows : Visibility or None
    shadow_of : tuple of (Path, float)
        Radii in m.

    Raises
    ------
    AttitudeError
        For a shape without these attributes, a path of another type, fractions outside of 0 to 1,
        a flux that is not positive, shadows of anything but a mesh, a body without a known radius.

    Notes
    -----
    With shadows the push on a facet is that on the share of eight points that is lit, interpolated
    between directions that are 90 deg / resolution apart; divide large facets (`Mesh.divided`).
    Light that other facets reflect is left out.  In the penumbra of an eclipse the push is that of
    the share of the Sun's disc that is free.  Force on a facet: Wertz (1978), Spacecraft Attitude
    Determination and Control, eq. 17-35.  Rubincam (2000), Icarus 148, 2.

    The torque has a kink where a facet turns into the light: schemes of any order err there by the
    second power of the step.
    """

    shape: FlatFacets
    path: Path
    diffuse: FloatArray
    mirrored: FloatArray
    flux: float
    shadows: Visibility | None
    shadow_of: tuple[tuple[Path, float], ...]
    columns = 3

    def __init__(
        self,
        shape: FlatFacets,
        path: AnyPath,
        diffuse: Real | Reals = 1.0,
        mirrored: Real | Reals = 0.0,
        flux: Real = SOLAR_CONSTANT,
        *,
        shadows: bool | Visibility = False,
        shadow_of: Path | Mapping[Path, Real] | Sequence[Path] = (),
    ) -> None:
        self._set("path", path_of(path, "path"))
        _set_facets(self, shape, diffuse, mirrored)
        self._set("flux", validation.positive(flux, "flux", unit="W/m2"))
        self._set_all(shadows=_visibility_of(shape, shadows), shadow_of=_occulters(shadow_of))

    def address(self) -> int:
        """Address of `_compiled.solar_radiation`, or of `shaded_radiation`."""
        return address_of("solar_radiation" if self.shadows is None else "shaded_radiation")

    @cached_property
    def _lit(self) -> FloatArray:
        """Shares (6 (n + 2)^2, N) of facets free of shadows, by cell of the sky, with margins."""
        table = self.shadows
        assert table is not None
        bits = np.array([bin(k).count("1") for k in range(256)]) / 8.0
        order = np.asarray(table.clusters.order)
        shares = np.empty((len(table.masks), len(self.diffuse)))
        shares[:, order] = bits[table.masks[:, : len(order)]]
        n = table.resolution
        middles = (np.arange(n + 2) + 0.5 - 1.0) * 2.0 / n - 1.0
        tangents = np.sign(middles) * ((1.0 + np.abs(middles)) ** 2 - 1.0) / 3.0
        v, u = np.meshgrid(tangents, tangents, indexing="ij")
        faces = []
        for face in range(6):
            w = np.full(u.shape, -1.0 if face % 2 else 1.0)
            faces.append([(w, u, v), (v, w, u), (u, v, w)][face // 2])
        directions = [np.ravel([face[k] for face in faces]) for k in range(3)]
        size = np.sqrt(sum(direction * direction for direction in directions))
        cells = cells_of_directions(n, [frozen(direction / size) for direction in directions])
        return frozen(shares[cells[: directions[0].size].astype(np.int64)])

    def parameters(self, body: Body) -> FloatArray:
        """The parameters of the function: (2 + 12 N,), with shadows two numbers before these.

        Raises
        ------
        AttitudeError
            For a body whose moments are relative.
        """
        strength = self.flux / SPEED_OF_LIGHT_M_S * ASTRONOMICAL_UNIT_M**2
        numbers = _facet_parameters(self, body, strength, "light pressure is in newtons")
        if self.shadows is None:
            return numbers
        return np.concatenate([[self._lit.ctypes.data, self.shadows.resolution], numbers])

    def contents(self, body: Body) -> tuple[FloatArray, ...]:
        """The numbers of the torque: `parameters`, with shares of light in place of an address."""
        parameters = self.parameters(body)
        return (parameters,) if self.shadows is None else (parameters[1:], self._lit)

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """The body's positions (K, 3) from the Sun in m, ICRF axes; as if farther in an eclipse."""
        place = positions(self.path, instant, seconds, low, "path")
        if not self.shadow_of:
            return place
        distance = np.sqrt(np.sum(place * place, axis=1))
        if np.any(distance <= SUN_RADIUS_M):
            raise AttitudeError(
                f"path comes within {np.min(distance):.6g} m of the centre of the Sun; give the "
                "body's position from the Sun."
            )
        lit = np.ones(len(place))
        for path, radius in self.shadow_of:
            other = positions(path, instant, seconds, low, f"the path of {path.name}")
            flattening = _shadow.flattening_of(str(path.name), radius)
            lit -= 1.0 - _shadow.lit_fraction(
                (other - place).T, radius, -place.T / distance, distance, flattening=flattening
            )
        # the push follows the inverse square of the distance: none at 1e100 times
        return place / np.sqrt(np.maximum(lit, 1e-200))[:, None]


@dataclass(frozen=True, eq=False, init=False)
class AerodynamicTorque(Torque):
    """The torque of thin air, which turns with the Earth, on flat facets.

    Parameters
    ----------
    shape : FlatFacets
        As for `SolarRadiation`.
    path : Path, or function
        The body's position from the centre of the Earth, m.
    density : float, Quantity, or function
        kg/m3, or a function of heights (K,) in m above the equator's radius that returns kg/m3.
    mirrored : float or (N,) array_like
        Fraction of the molecules that a facet reflects as a mirror; the others leave it slowly.

    Attributes
    ----------
    path : Path
    mirrored : (N,) float64 array, read-only

    Raises
    ------
    AttitudeError
        As `SolarRadiation`; from the motion, for a density that is negative or not finite.

    Notes
    -----
    Free molecules, fast beside their thermal speed: the force on a facet of area A that meets the
    air at the angle t is rho v^2 A cos t ((1 - mirrored) along the flow + 2 mirrored cos t along
    the inward normal); Wertz (1978), eq. 17-57, with mirrored = 0.  The air turns with the Earth
    about its pole (Montenbruck & Gill, Satellite Orbits, section 3.5).  Facets do not shade each
    other.
    """

    shape: FlatFacets
    path: Path
    density: Any
    mirrored: FloatArray
    columns = 3
    _function = "solar_radiation"

    def __init__(
        self,
        shape: FlatFacets,
        path: AnyPath,
        density: Real | Callable[[FloatArray], FloatArray],
        mirrored: Real | Reals = 0.0,
    ) -> None:
        self._set("path", path_of(path, "path"))
        _set_facets(self, shape, 0.0, mirrored)
        if not callable(density):
            density = validation.positive(density, "density", unit="kg/m3")
        self._set("density", density)

    def parameters(self, body: Body) -> FloatArray:
        """The parameters (2 + 12 N,) of `_compiled.solar_radiation`.

        Raises
        ------
        AttitudeError
            For a body whose moments are relative.
        """
        return _facet_parameters(self, body, 1.0, "the push of air is in newtons")

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """Vectors (K, 3) along the flow, ICRF axes, of length 1 / (v sqrt(density))."""
        first, last = self.span(instant)
        middle = np.clip(seconds, first + _STEP, last - _STEP)
        position = positions(self.path, instant, seconds, low, "path")
        before, after = (
            positions(self.path, instant, middle + k * _STEP, low, "path") for k in (-1, 1)
        )
        velocity = (after - before) / (2.0 * _STEP)
        hi, lo = pairs.add((seconds, low), instant.seconds, instant.low)
        x, y, locator = _earth.pole_of_date(hi, lo)
        pole = _earth.to_gcrs(x, y, locator, np.array([[0.0], [0.0], [1.0]]))
        flow = np.cross(EARTH_RATE_RAD_S * pole.T, position) - velocity
        speed = np.sqrt(np.sum(flow * flow, axis=-1))
        height = np.sqrt(np.sum(position * position, axis=-1)) - EARTH_RADIUS_M
        density = self.density(height) if callable(self.density) else self.density
        density = np.broadcast_to(np.asarray(density, dtype=np.float64), height.shape)
        if not np.all(np.isfinite(density)) or np.any(density < 0.0):
            raise AttitudeError(
                "density returned a number that is negative or not finite; it must return kg/m3 "
                "for heights in m."
            )
        # without air: a length that leaves no torque above 1e-200 N m
        length = 1.0 / (np.maximum(speed, 1e-9) * np.sqrt(np.maximum(density, 1e-200)))
        return flow / np.maximum(speed, 1e-9)[:, None] * length[:, None]


def _visibility_of(shape: Any, shadows: Any) -> Visibility | None:
    """The table of shadows of a mesh; None without shadows."""
    if shadows is False:
        return None
    if not isinstance(shape, Mesh):
        raise AttitudeError(
            f"shadows is {shadows!r}, but shape is {type(shape).__name__}; facets shade each other "
            "on a Mesh: give one of attitude.shape, or shadows=False."
        )
    if shadows is True:
        return Visibility.of(shape)
    if not isinstance(shadows, Visibility):
        raise AttitudeError(f"shadows is {shadows!r}; give True, False, or Visibility.of(shape).")
    if not shadows.is_of(shape):
        raise AttitudeError("shadows is the table of another mesh; give Visibility.of(shape).")
    return shadows


def _occulters(shadow_of: Any) -> tuple[tuple[Path, float], ...]:
    """Paths from the Sun, and radii in m, of bodies that eclipse it."""
    if isinstance(shadow_of, Path):
        shadow_of = (shadow_of,)
    named = shadow_of.items() if isinstance(shadow_of, Mapping) else [(p, None) for p in shadow_of]
    bodies = []
    for path, radius in named:
        if not isinstance(path, Path):
            raise AttitudeError(
                f"shadow_of holds {validation.shown(path)}; give the path of a body from the Sun, "
                'as in paths.relative("earth", "sun").'
            )
        if radius is None:
            radius = _shadow.radius_of(str(path.name))
        if radius is None:
            raise AttitudeError(
                f"the radius of {path.name}, in shadow_of, is not known here; give it in m, as in "
                "shadow_of={path: 1e6}."
            )
        bodies.append((path, validation.positive(radius, f"the radius of {path.name}", unit="m")))
    return tuple(bodies)


# s: half of the step over which a path is differenced.
_STEP = 0.5


def _set_facets(torque: Any, shape: FlatFacets, diffuse: Any, mirrored: Any) -> None:
    """Check and keep the shape and the fractions of its facets."""
    torque._set("shape", shape)
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
    fractions = []
    for name, fraction in (("diffuse", diffuse), ("mirrored", mirrored)):
        number = validation.real(fraction, name)
        numbers = validation.broadcast(number, name, (len(areas),), "facet of the shape")
        torque._set(name, frozen(numbers.copy()))
        fractions.append(numbers)
    total = fractions[0] + fractions[1]
    if min(fractions[0].min(), fractions[1].min()) < 0.0 or total.max() > 1.0:
        raise AttitudeError(
            "diffuse and mirrored are fractions: not negative, at most 1 together; given up to "
            f"{total.max():.3g}."
        )


def _facet_parameters(torque: Any, body: Body, strength: float, unit: str) -> FloatArray:
    """The parameters (2 + 12 N,) of `_compiled.solar_radiation`."""
    refuse_relative(body, unit)
    arms = np.asarray(torque.shape.centroids) - body.center_of_mass
    normals = np.asarray(torque.shape.normals)
    vectors = np.concatenate([normals, arms, np.cross(arms, normals)], axis=1).T
    rows = [torque.shape.areas, *vectors, torque.diffuse, torque.mirrored]
    return np.concatenate([[strength, len(arms)], np.ravel(rows)])
