"""The inertia of N bodies as arrays, one row for all of them or one each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import validation
from attitude.batches import symmetric_tensors
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.solution.principal import PrincipalAxes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, Reals

_IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])
# Tensors whose principal axes are computed in one call, in 10 ms, between two signals.
_BLOCK = 512


class Given(NamedTuple):
    """What a caller gave as bodies, one row for all of them or one each.

    Attributes
    ----------
    array : (1 or N, 3) or (1 or N, 3, 3) array
        Principal moments about the body axes, or tensors; kg m2, or relative.
    relative : bool
        Whether the unit is unknown.
    bodies : (1 or N,) array of Body, or None
        The bodies, if objects were given.
    """

    array: FloatArray
    relative: bool
    bodies: NDArray[np.object_] | None

    @property
    def size(self) -> int:
        """1, or the number of bodies."""
        return self.array.shape[0]

    def resolved(self, omega: FloatArray, raises: bool) -> tuple[Inertia, Resolved]:
        """The inertia, and angular velocities (N, 3) of its N members over the principal axes.

        Raises
        ------
        AttitudeError
            For tensors that are not symmetric, unless their moments are to be NaN.
        """
        count = len(self.array)
        moments, axes = np.zeros((count, 3, 2)), np.broadcast_to(np.eye(3), (count, 3, 3))
        if self.array.ndim == 2:
            moments[..., 0] = self.array
            principal = np.broadcast_to(_IDENTITY, (count, 4))
            return Inertia(*self, moments, axes, principal), Resolved(omega, None)
        axes, principal = np.empty((count, 3, 3)), np.empty((count, 4))
        rates, differences = np.empty((2, len(omega), 3, 2))
        for first in range(0, len(omega), _BLOCK):
            part = slice(first, first + _BLOCK)
            if count > 1 or first == 0:
                of = part if count > 1 else slice(0, 1)
                some = symmetric_tensors(self.array[of], first, count, raises=raises)
                found = PrincipalAxes.of(some)
                moments[of], axes[of], principal[of] = found.moments, found.axes[..., 0], found.wxyz
            rates[part], differences[part] = found.over_axes(omega[part].copy())
        inertia = Inertia(*self, moments, axes, principal)
        if np.isnan(differences[:, 0, 0]).all() and not rates[..., 1].any():
            return inertia, Resolved(np.ascontiguousarray(rates[..., 0]), None)
        return inertia, Resolved(rates, differences)


class Resolved(NamedTuple):
    """Angular velocities of N members over their principal axes.

    Attributes
    ----------
    rates : (N, 3, 2) array, or (N, 3) where the low parts are zero
        rad/s, in pairs of doubles.
    differences : (N, 3, 2) array or None
        See `PrincipalAxes.over_axes`; NaN for members without.
    """

    rates: FloatArray
    differences: FloatArray | None


@dataclass(frozen=True, eq=False)
class Inertia:
    """Moments of N bodies; arrays have the leading axis 1 if all bodies share one inertia.

    Attributes
    ----------
    given, relative, bodies
        As of `Given`.
    moments : (1 or N, 3, 2) array
        Principal moments in pairs of doubles.
    axes : (1 or N, 3, 3) array
        Columns: the principal axes in body axes.
    principal : (1 or N, 4) array
        The unit quaternion from principal to body axes.
    """

    given: FloatArray
    relative: bool
    bodies: NDArray[np.object_] | None
    moments: FloatArray
    axes: FloatArray
    principal: FloatArray

    def __len__(self) -> int:
        """1, or the number of bodies."""
        return self.given.shape[0]

    def body(self, k: int) -> Body:
        """The Body of member k."""
        k = k if len(self) > 1 else 0
        if self.bodies is not None:
            found: Body = self.bodies[k]
            return found
        kind = "moments" if self.given.ndim == 2 else "tensor"
        return Body(**{kind: self.given[k]}, relative=self.relative)

    def taken(self, index: Any) -> Inertia:
        """The inertia of some of the members."""
        if len(self) == 1:
            return self
        bodies = None if self.bodies is None else self.bodies[index]
        arrays = (each[index] for each in (self.moments, self.axes, self.principal))
        return Inertia(self.given[index], self.relative, bodies, *arrays)

    @property
    def has_tensors(self) -> bool:
        """Whether the principal axes of any member may differ from its body axes."""
        return self.given.ndim == 3

    def tensors(self) -> FloatArray:
        """Inertia tensors (1 or N, 3, 3) in body axes."""
        return self.given if self.has_tensors else self.given[:, :, None] * np.eye(3)


def of_moments(moments: Reals, relative: bool) -> Given:
    """Principal moments (3,) or (N, 3) about the body axes."""
    unit = None if relative else "kg m2"
    given = validation.real(moments, "moments", unit=unit, finite=False)
    return Given(_leading(given, "moments", (3,)), relative, None)


def of_tensors(tensors: Reals, relative: bool) -> Given:
    """Tensors (3, 3) or (N, 3, 3) in body axes."""
    unit = None if relative else "kg m2"
    given = validation.real(tensors, "tensors", unit=unit, finite=False)
    return Given(_leading(given, "tensors", (3, 3)), relative, None)


def of_bodies(bodies: Sequence[Body]) -> Given:
    """Body objects, one for all members or one each."""
    for k, each in enumerate(bodies):
        if not isinstance(each, Body):
            raise AttitudeError(
                f"body {k} is {validation.shown(each)}; give one Body, or one for each member."
            )
    relative = {each.relative for each in bodies}
    if len(relative) > 1:
        raise AttitudeError(
            "some bodies have relative moments and others have moments in kg m2; give members of "
            "both kinds as two ensembles."
        )
    objects = np.empty(len(bodies), dtype=object)
    objects[:] = bodies
    plain = all(each.has_given_axes for each in bodies)
    given = np.array([each.moments if plain else each.tensor for each in bodies])
    return Given(
        given.reshape(len(bodies), *((3,) if plain else (3, 3))), True in relative, objects
    )


def joined(parts: Sequence[Inertia], counts: Sequence[int]) -> Inertia:
    """The inertia of ensembles of `counts` members, one after the other."""
    first = parts[0]
    if len({each.relative for each in parts}) > 1:
        raise AttitudeError(
            "one ensemble has relative moments and another has moments in kg m2; they stay apart."
        )
    if all(each is first and len(each) == 1 for each in parts):
        return first
    tensors = any(each.has_tensors for each in parts)

    def rows(arrays: Sequence[Any]) -> Any:
        pairs = zip(arrays, counts, strict=True)
        return np.concatenate([np.broadcast_to(a, (n, *a.shape[1:])) for a, n in pairs])

    given = rows([each.tensors() if tensors else each.given for each in parts])
    bodies = None
    if all(each.bodies is not None for each in parts):
        bodies = rows([each.bodies for each in parts])
    names = "moments", "axes", "principal"
    arrays = (rows([getattr(each, name) for each in parts]) for name in names)
    return Inertia(given, first.relative, bodies, *arrays)


def _leading(array: FloatArray, name: str, last: tuple[int, ...]) -> FloatArray:
    """The array with one leading axis."""
    if array.shape == last:
        return array[None]
    if array.ndim == len(last) + 1 and array.shape[1:] == last:
        return array
    shape = ", ".join(map(str, last))
    raise AttitudeError(f"{name} has shape {array.shape}; give ({shape}) or (N, {shape}).")
