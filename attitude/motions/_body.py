"""Mass properties: principal moments of inertia and the directions of their axes in the body."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver.evaluation import writable
from attitude._solver.principal_axes import ASYMMETRY, PrincipalAxes
from attitude._support import markup, validation
from attitude._support.arrays import Valued, frozen
from attitude._support.synonyms import arguments
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh


# Violation of the triangle inequality, relative to the largest moment, that measured moments may
# have; as in the compiled solution.
TRIANGLE: float = 1e-14
# Largest moment of which sums and differences are finite.
_LARGEST = 0.25 * float(np.finfo(float).max)
_ORIGIN = frozen(np.zeros(3))
# Principal axes equal to the body axes, as pairs of doubles.
_GIVEN_AXES = np.stack([np.eye(3), np.zeros((3, 3))], axis=-1)

_HINTS = {
    **dict.fromkeys(("inertia", "I", "inertia_tensor"), "give moments or tensor"),
    **dict.fromkeys(("Ixx", "Iyy", "Izz", "I1", "I2", "I3", "A", "B", "C"), "give moments"),
    "axes": "use Body.from_ellipsoid(axes)",
}


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Body(Valued):
    """The inertia of a rigid body.

    Parameters
    ----------
    moments : (3,) array_like, optional
        Principal moments about the body axes x, y, z in kg m2, in any order.
    tensor : (3, 3) array_like, optional
        Inertia tensor about the centre of mass in body axes, kg m2; in place of the moments.  Its
        doubles are taken as exact; moments and axes are computed to 115 digits.
    mass : float, optional
        kg.
    relative : bool
        True if the unit of the moments is unknown: energy and momentum are then in that unit.
    center_of_mass : (3,) array_like, optional
        m, in the coordinates of the points or shape from which the body was made; by default 0.

    Attributes
    ----------
    moments : (3,) array
        As given, or the eigenvalues of the tensor in ascending order (of a diagonal tensor, its
        diagonal), kg m2.
    principal_axes : (3, 3) array
        Columns: the unit vectors of the principal axes in body axes, right-handed.
    tensor : (3, 3) array
        kg m2, in body axes.
    mass : float or None
        kg.
    relative : bool
    center_of_mass : (3,) array
        m.

    Raises
    ------
    AttitudeError
        For moments that are negative or not finite or violate the triangle inequality beyond
        rounding, a tensor that is not symmetric, wrong shapes and units, and both moments and
        tensor or neither.

    >>> Body(tensor=[[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]]).moments
    array([2., 2., 3.])
    """

    moments: FloatArray
    tensor: FloatArray
    mass: float | None
    relative: bool
    center_of_mass: FloatArray
    principal_axes: FloatArray = field(init=False)

    _value = ("moments", "tensor", "mass", "relative", "center_of_mass")

    @arguments(_HINTS, "Body(moments=(10, 20, 26)) or Body(tensor=(3 x 3))")
    def __init__(
        self,
        moments: Reals | None = None,
        tensor: Reals | None = None,
        mass: Real | None = None,
        relative: bool = False,
        center_of_mass: Reals | None = None,
    ) -> None:
        self._moments: FloatArray
        self._axes: FloatArray
        self._found: PrincipalAxes | None
        if isinstance(moments, (int, float)):
            three = all(isinstance(number, (int, float)) for number in (moments, tensor, mass))
            listed = ", ".join(map(str, (moments, tensor, mass) if three else (10, 20, 26)))
            raise AttitudeError(
                f"Body takes its moments together: Body(moments=({listed})), or a tensor: "
                "Body(tensor=(3 x 3))."
            )
        relative = validation.flag(relative, "relative")
        unit = None if relative else "kg m2"
        if (moments is None) == (tensor is None):
            raise AttitudeError("a Body takes either moments=(3 numbers) or tensor=(3 x 3).")
        known_mass = None if mass is None else validation.positive(mass, "mass", unit="kg")
        center = _ORIGIN
        if center_of_mass is not None:
            known = validation.real(center_of_mass, "center_of_mass", shape=(3,), unit="m")
            center = frozen(known + 0.0)  # files leave out zeros, and their signs
        self._set_all(relative=relative, mass=known_mass, center_of_mass=center)
        if moments is not None:
            self._from_moments(validation.real(moments, "moments", shape=(3,), unit=unit))
        if tensor is not None:
            self._from_tensor(validation.real(tensor, "tensor", shape=(3, 3), unit=unit))
        for array in (self.moments, self.tensor, self.principal_axes, self._moments, self._axes):
            frozen(array)

    @classmethod
    @arguments({}, "Body.from_points([1, 2, 3], [(0, 0, 0), (1, 0, 0), (0, 2, 0)])")
    def from_points(cls, masses: Reals, positions: Reals, *, relative: bool = False) -> Body:
        """A rigid set of point masses.

        Parameters
        ----------
        masses : (N,) array_like
            kg, positive.
        positions : (N, 3) array_like
            m, in body axes, from any origin.  The inertia is computed about the centre of mass:
            van Zon & Schofield (2006), eqs. 2.1 and 2.2.
        relative : bool
            True if the units of masses and positions are unknown.

        Raises
        ------
        AttitudeError
            For other shapes, and a mass that is not above zero.
        """
        relative = validation.flag(relative, "relative")
        masses = validation.real(masses, "masses", unit=None if relative else "kg")
        positions = validation.real(positions, "positions", unit=None if relative else "m")
        if masses.ndim != 1 or positions.shape != (len(masses), 3) or len(masses) == 0:
            raise AttitudeError(
                f"masses have shape {masses.shape} and positions {positions.shape}; give (N,) and "
                "(N, 3)."
            )
        if np.any(masses <= 0.0):
            bad = masses[masses <= 0.0][0]
            raise AttitudeError(f"masses holds {bad}; every mass must be greater than zero.")
        with np.errstate(over="ignore", invalid="ignore"):
            total = masses.sum()
            center = masses @ positions / total
            arms = positions - center
            second = (masses[:, None] * arms).T @ arms
        _refuse_infinity(second, "masses and positions")
        tensor = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
        mass = None if relative else total
        return cls(tensor=tensor, mass=mass, relative=relative, center_of_mass=center)

    @classmethod
    @arguments(
        dict.fromkeys(("a", "b", "c", "semi_axes"), "give axes="),
        "Body.from_ellipsoid((380, 240, 180), mass=5e10)",
    )
    def from_ellipsoid(cls, axes: Reals, *, mass: Real | None = None) -> Body:
        """A homogeneous ellipsoid.

        Parameters
        ----------
        axes : (3,) array_like
            Semi-axes along body x, y, z: m, a Quantity, or text such as "380, 240, 180 m"; plain
            numbers in any unit without a mass.
        mass : float, optional
            kg.  Without it the moments are relative.

        Raises
        ------
        AttitudeError
            For another shape, and a semi-axis or mass that is not above zero.
        """
        axes = validation.real(axes, "axes", shape=(3,), unit="m")
        if np.any(axes <= 0.0):
            raise AttitudeError(f"axes are {axes.tolist()}; semi-axes must be greater than zero.")
        kilograms = 1.0 if mass is None else validation.positive(mass, "mass", unit="kg")
        with np.errstate(over="ignore", invalid="ignore"):
            squares = axes**2
            moments = 0.2 * kilograms * (squares.sum() - squares)
        _refuse_infinity(moments, "axes")
        return cls(moments=moments, mass=mass, relative=mass is None)

    @classmethod
    @arguments(
        {"mass": "give density=, or multiply: Body(tensor=mass / volume * tensor)"},
        "Body.from_shape(mesh, density=2000)",
    )
    def from_shape(
        cls,
        shape: Mesh | Ellipsoid,
        *,
        density: Real | None = None,
        surface_density: Real | None = None,
    ) -> Body:
        """A homogeneous solid of a shape, or a thin shell.

        Parameters
        ----------
        shape : attitude.shape.Mesh or attitude.shape.Ellipsoid
            A closed mesh, m; the body axes are the axes of the shape.
        density : float, optional
            kg/m3.  Without either density the moments are relative, those of a solid.
        surface_density : float, optional
            kg/m2, of a thin shell: a mesh, which may be open.

        Raises
        ------
        AttitudeError
            For any other object, a solid whose mesh is open or inside out, both densities, and one
            that is not above zero.
        """
        densities: dict[str, Any] = {"density": density, "surface_density": surface_density}
        known = {
            name: validation.positive(value, name, unit="kg/m3" if name == "density" else "kg/m2")
            for name, value in densities.items()
            if value is not None
        }
        if not hasattr(shape, "mass_properties"):
            raise AttitudeError(f"shape is {shape!r}; give an attitude.shape Mesh or Ellipsoid.")
        if surface_density is not None and not hasattr(shape, "vertices"):
            raise AttitudeError("surface_density is that of a Mesh; give ellipsoid.facets(1000).")
        properties = shape.mass_properties(**(known or {"density": 1.0}))
        return cls(
            tensor=properties.inertia,
            mass=properties.mass if known else None,
            relative=not known,
            center_of_mass=properties.center_of_mass,
        )

    def __repr__(self) -> str:
        unit = "relative" if self.relative else "kg m2"
        listed = ", ".join(f"{moment:.9g}" for moment in self.moments)
        return f"<Body: principal moments {listed} {unit}>"

    def _repr_html_(self) -> str:
        """A table for notebooks."""
        unit = "relative" if self.relative else "kg m2"
        rows = [("principal moments", f"{', '.join(f'{x:.9g}' for x in self.moments)} {unit}")]
        if np.any(self.tensor != np.diag(self.moments)):
            for k, row in enumerate(self.tensor):
                rows.append(("tensor" if k == 0 else "", ", ".join(f"{x:.9g}" for x in row)))
        if self.mass is not None:
            rows.append(("mass", f"{self.mass:.9g} kg"))
        if np.any(self.center_of_mass):
            place = ", ".join(f"{x:.6g}" for x in self.center_of_mass)
            rows.append(("center of mass", f"{place} m"))
        return markup.table("Body", rows)

    def _from_moments(self, moments: FloatArray) -> None:
        _check(moments, "moments")
        pairs = np.zeros((3, 2))
        pairs[:, 0] = moments
        self._keep(moments, np.diag(moments), pairs, None)

    def _from_tensor(self, tensor: FloatArray) -> None:
        # Floats of nine numbers are several times faster than arrays of them.
        (a, b, c), (d, e, f), (g, h, i) = tensor.tolist()
        off = max(abs(b - d), abs(c - g), abs(f - h))
        largest = max(map(abs, (a, b, c, d, e, f, g, h, i)))
        if off > ASYMMETRY * largest:
            raise AttitudeError(
                f"tensor is not symmetric: entries across its diagonal differ by {off:.3g}. Give "
                "a symmetric inertia tensor (products of inertia with a minus sign)."
            )
        _refuse_overflow(largest, "tensor")
        if off > 0.0:
            tensor = 0.5 * (tensor + tensor.T)
        if b == c == f == d == g == h == 0.0:
            self._from_moments(np.diag(tensor).copy())
            return
        principal = PrincipalAxes.of(tensor[None])
        _check(principal.moments[0, :, 0], "the principal moments of tensor")
        self._keep(principal.moments[0, :, 0].copy(), tensor, principal.moments[0], principal)

    def _keep(
        self,
        moments: FloatArray,
        tensor: FloatArray,
        pairs: FloatArray,
        principal: PrincipalAxes | None,
    ) -> None:
        axes = _GIVEN_AXES if principal is None else principal.axes[0]
        self._set_all(
            moments=moments,
            tensor=tensor,
            principal_axes=axes[..., 0].copy(),
            _moments=pairs,
            _axes=axes,
            _found=principal,
        )

    @property
    def has_given_axes(self) -> bool:
        """Whether the body axes are principal: moments were given, or a diagonal tensor."""
        return self._found is None

    def over_principal_axes(self, omega: FloatArray) -> tuple[FloatArray, FloatArray | None]:
        """Rates over principal axes and `differences` (1, 3, 2) of an angular velocity (3,)."""
        if self._found is None:
            rates = np.zeros((1, 3, 2))
            rates[..., 0] = omega
            return rates, None
        rates, differences = self._found.over_axes(writable(omega)[None])
        return rates, None if self.moments[0] == 0.0 else differences

    def rates_about_principal_axes(self, omega: FloatArray) -> FloatArray:
        """Components over the principal axes of an angular velocity (3,) over the body axes.

        (3, 2), each the sum of its two doubles, rad/s.
        """
        return self.over_principal_axes(omega)[0][0]

    def differences(self, omega: FloatArray) -> FloatArray | None:
        """B - A, C - B and L^2 - 2 E B of a tensor, which cancel near the separatrix, or None.

        (3, 2) pairs of doubles at the angular velocity omega (3,), rad/s in body axes, scaled as
        by `PrincipalAxes.over_axes`.  None if the moments were given
        or one of them is zero: the moments and rates then have all the digits.
        """
        differences = self.over_principal_axes(omega)[1]
        return None if differences is None else differences[0]

    @cached_property
    def principal_wxyz(self) -> FloatArray:
        """The unit quaternion (4,) from principal to body axes, scalar first."""
        if self._found is None:
            return frozen(np.array([1.0, 0.0, 0.0, 0.0]))
        return frozen(self._found.wxyz[0])

    @property
    def moments_as_pairs(self) -> FloatArray:
        """The principal moments to 31 digits, kg m2: (3, 2), each the sum of its two doubles."""
        return self._moments


def tensors_of(moments: FloatArray, axes: FloatArray) -> FloatArray:
    """Symmetric tensors (..., 3, 3) of moments (..., 3) about axes, the columns of (3, 3)."""
    products: FloatArray = (axes * moments[..., None, :]) @ axes.T
    return 0.5 * (products + np.swapaxes(products, -1, -2))


def _check(moments: FloatArray, name: str) -> None:
    """AttitudeError for principal moments that no body has."""
    x, y, z = moments.tolist()
    largest = max(x, y, z)
    _refuse_overflow(largest, name)
    if min(x, y, z) < 0.0 or not largest > 0.0:
        raise AttitudeError(
            f"{name} are {_listed(moments)}; moments of inertia must not be negative, and at most "
            "one of them can be zero."
        )
    excess = largest - (((x + y) + z) - largest)
    if excess > TRIANGLE * largest:
        raise AttitudeError(
            f"{name} are {_listed(moments)}; no body has a moment of inertia that exceeds the sum "
            f"of the other two (here by {excess:.3g}). Check the numbers and their units."
        )


def _refuse_infinity(products: FloatArray, name: str) -> None:
    """AttitudeError for moments that are beyond the largest double."""
    if not np.all(np.isfinite(products)):
        raise AttitudeError(
            f"the moments of inertia of these {name} exceed the largest double; give smaller "
            "numbers, for example in larger units."
        )


def _refuse_overflow(largest: float, name: str) -> None:
    """AttitudeError for moments whose sums may exceed the largest double."""
    if largest > _LARGEST:
        raise AttitudeError(
            f"{name} holds {largest:.3g}, so large that sums overflow; give numbers up to "
            f"{_LARGEST:.3g}, for example in a larger unit with relative=True."
        )


def _listed(row: Iterable[float]) -> str:
    return "(" + ", ".join(f"{x:.17g}" for x in row) + ")"
