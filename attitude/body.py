"""Mass properties: principal moments of inertia and where their axes lie in the body."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from attitude import quaternion, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.solution.principal import PrincipalAxes

# Asymmetry of a tensor, relative to its largest entry, that is taken for rounding.
_ASYMMETRY = 1e-13
# What rounding leaves of a moment that is zero, relative to the largest.
_ZERO_MOMENT = 1e-15
# What measured moments may miss the triangle inequality by, as in the compiled solution.
_TRIANGLE = 1e-14
# Principal axes that are the body axes, as pairs of doubles.
_GIVEN_AXES = np.stack([np.eye(3), np.zeros((3, 3))], axis=-1)


@dataclass(frozen=True, eq=False, repr=False)
class Body(Immutable):
    """A rigid body's inertia.

    Give moments or tensor, not both.

    Parameters
    ----------
    moments : (3,) array_like, optional
        Principal moments about the body axes x, y, z in kg m2, in any order.
    tensor : (3, 3) array_like, optional
        Inertia tensor about the centre of mass in body axes, kg m2.  Its doubles are taken as
        exact; moments and axes are found to 115 digits.
    mass : float, optional
        kg.
    relative : bool
        Whether the unit of the moments is unknown: energy and momentum are then in that unit.

    Attributes
    ----------
    moments : (3,) array
        As given, or the eigenvalues of the tensor in ascending order (of a diagonal one: its
        diagonal as it is).
    principal_axes : (3, 3) array
        Columns: the unit vectors of the principal axes in body axes, right-handed.
    tensor : (3, 3) array
    center_of_mass : (3,) array
        In the coordinates of the points or shape that the body was made from, m.

    Raises
    ------
    AttitudeError
        For moments that are negative or not finite or violate the triangle inequality beyond
        rounding, a tensor that is not symmetric, wrong shapes and units.

    >>> Body(tensor=[[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]]).moments
    array([2., 2., 3.])
    """

    moments: np.ndarray = None
    tensor: np.ndarray = None
    mass: float = None
    relative: bool = False
    center_of_mass: np.ndarray = None
    principal_axes: np.ndarray = field(init=False)

    def __post_init__(self):
        unit = None if self.relative else "kg m2"
        if (self.moments is None) == (self.tensor is None):
            raise AttitudeError("a Body takes either moments=(3 numbers) or tensor=(3 x 3).")
        if self.mass is not None:
            self._set("mass", validation.positive(self.mass, "mass", unit="kg"))
        center = (0.0, 0.0, 0.0) if self.center_of_mass is None else self.center_of_mass
        center = validation.real(center, "center_of_mass", shape=(3,), unit="m")
        self._set("center_of_mass", frozen(center))
        if self.tensor is None:
            self._from_moments(validation.real(self.moments, "moments", shape=(3,), unit=unit))
        else:
            self._from_tensor(validation.real(self.tensor, "tensor", shape=(3, 3), unit=unit))
        for array in (self.moments, self.tensor, self.principal_axes, self._moments, self._axes):
            frozen(array)

    @classmethod
    def from_points(cls, masses, positions, *, relative=False):
        """A rigid set of point masses.

        Parameters
        ----------
        masses : (N,) array_like
            kg, positive.
        positions : (N, 3) array_like
            m, in body axes, from any origin.  The inertia is that about the centre of mass: van
            Zon & Schofield (2006), eqs. 2.1 and 2.2.
        """
        masses = validation.real(masses, "masses", unit=None if relative else "kg")
        positions = validation.real(positions, "positions", unit=None if relative else "m")
        if masses.ndim != 1 or positions.shape != (len(masses), 3) or len(masses) == 0:
            raise AttitudeError(
                f"masses have shape {masses.shape} and positions {positions.shape}; give (N,) and "
                "(N, 3)."
            )
        if np.any(masses <= 0.0):
            raise AttitudeError("masses must all be greater than zero.")
        total = masses.sum()
        center = masses @ positions / total
        arms = positions - center
        second = (masses[:, None] * arms).T @ arms
        tensor = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
        mass = None if relative else total
        return cls(tensor=tensor, mass=mass, relative=relative, center_of_mass=center)

    @classmethod
    def from_ellipsoid(cls, axes, *, mass=None):
        """A homogeneous ellipsoid.

        Parameters
        ----------
        axes : (3,) array_like
            Semi-axes along body x, y, z: m, or any unit without a mass.
        mass : float, optional
            kg.  Without it the moments are relative.
        """
        axes = validation.real(axes, "axes", shape=(3,), unit=None if mass is None else "m")
        if np.any(axes <= 0.0):
            raise AttitudeError(f"axes are {axes.tolist()}; semi-axes must be greater than zero.")
        kilograms = 1.0 if mass is None else validation.positive(mass, "mass", unit="kg")
        squares = axes**2
        moments = 0.2 * kilograms * (squares.sum() - squares)
        return cls(moments=moments, mass=mass, relative=mass is None)

    @classmethod
    def from_shape(cls, shape, *, density=None):
        """A homogeneous solid of a shape.

        Parameters
        ----------
        shape : attitude.shape.Mesh or attitude.shape.Ellipsoid
            A closed mesh, m; the body axes are the axes of the shape.
        density : float, optional
            kg/m3.  Without it the moments are relative.

        Raises
        ------
        AttitudeError
            For what is no shape, a mesh that is open or inside out, and a density not above zero.
        """
        known = density is not None
        density = validation.positive(density, "density", unit="kg/m3") if known else 1.0
        if not hasattr(shape, "mass_properties"):
            raise AttitudeError(f"shape is {shape!r}; give an attitude.shape Mesh or Ellipsoid.")
        found = shape.mass_properties(density=density)
        return cls(
            tensor=found.inertia,
            mass=found.mass if known else None,
            relative=not known,
            center_of_mass=found.center_of_mass,
        )

    def __repr__(self):
        unit = "relative" if self.relative else "kg m2"
        listed = ", ".join(f"{moment:.9g}" for moment in self.moments)
        return f"<Body: principal moments {listed} {unit}>"

    def _from_moments(self, moments):
        _check(moments, "moments")
        pairs = np.zeros((3, 2))
        pairs[:, 0] = moments
        self._keep(moments, np.diag(moments), pairs, None)

    def _from_tensor(self, tensor):
        off = np.max(np.abs(tensor - tensor.T))
        largest = np.max(np.abs(tensor))
        if off > _ASYMMETRY * largest:
            raise AttitudeError(
                f"tensor is not symmetric: entries across its diagonal differ by {off:.3g}. Give "
                "a symmetric inertia tensor (products of inertia with a minus sign)."
            )
        if largest > 0.25 * np.finfo(float).max:
            raise AttitudeError(
                f"tensor holds {largest:.3g}, so large that sums overflow; give smaller numbers."
            )
        tensor = 0.5 * (tensor + tensor.T)
        if np.all(tensor == np.diag(np.diag(tensor))):
            self._from_moments(np.diag(tensor).copy())
            return
        found = PrincipalAxes.of(tensor)
        pairs = _rod_within_rounding(found.moments())
        _check(pairs[:, 0], "the principal moments of tensor")
        self._keep(pairs[:, 0].copy(), tensor, pairs, found)

    def _keep(self, moments, tensor, pairs, found):
        axes = _GIVEN_AXES if found is None else found.axes()
        self._set("moments", moments)
        self._set("tensor", tensor)
        self._set("principal_axes", axes[..., 0].copy())
        self._set("_moments", pairs)
        self._set("_axes", axes)
        self._set("_found", found)

    def rates_about_principal_axes(self, omega):
        """Components (3, 2), pairs of doubles, of an angular velocity (3,) in body axes."""
        if self._found is None:
            return np.stack([omega, np.zeros(3)], axis=-1)
        return self._found.rates(omega)

    def differences(self, omega):
        """What two doubles of moments and rates would lose beside the separatrix, (3, 2), or None.

        None where they lose nothing, the moments being given: see
        `attitude.solution.principal.PrincipalAxes.differences`.
        """
        if self._found is None or self.moments[0] == 0.0:
            return None
        return self._found.differences(omega)

    @cached_property
    def principal_wxyz(self):
        """The unit quaternion (4,) from principal to body axes."""
        if np.array_equal(self.principal_axes, np.eye(3)):
            return frozen(np.array([1.0, 0.0, 0.0, 0.0]))
        return frozen(quaternion.from_matrix(self.principal_axes))

    @property
    def moments_as_pairs(self):
        """The principal moments to 31 digits: (3, 2), each the sum of its two doubles."""
        return self._moments


def _check(moments, name):
    if np.any(moments < 0.0) or not np.any(moments > 0.0):
        raise AttitudeError(
            f"{name} are {_listed(moments)}; moments of inertia must not be negative, and at most "
            "one of them can be zero."
        )
    excess = moments.max() - (moments.sum() - moments.max())
    if excess > _TRIANGLE * moments.max():
        raise AttitudeError(
            f"{name} are {_listed(moments)}; no body has a moment of inertia that exceeds the sum "
            f"of the other two (here by {excess:.3g}). Check the numbers and their units."
        )


def _rod_within_rounding(pairs):
    """A least eigenvalue that rounding made negative is a rod's zero; the others are then equal."""
    if -_ZERO_MOMENT * pairs[2, 0] <= pairs[0, 0] <= 0.0:
        mean = 0.5 * (pairs[1] + pairs[2])
        return np.array([[0.0, 0.0], mean, mean])
    return pairs


def _listed(row):
    return "(" + ", ".join(f"{x:.17g}" for x in row) + ")"
