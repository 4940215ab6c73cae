"""The inertia of N bodies as arrays, one row for all of them or one each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, Reals

_IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])


class Resolved(NamedTuple):
    """Angular velocities of N members over their principal axes.

    Attributes
    ----------
    rates : (N, 3, 2) array, or (N, 3) where the low parts are zero
        rad/s, in pairs of doubles.
    differences : (N, 3, 2) array or None
        See `Body.differences`; NaN for members without.
    """

    rates: FloatArray
    differences: FloatArray | None


@dataclass(frozen=True, eq=False)
class Inertia:
    """Moments of N bodies; arrays have the leading axis 1 if all bodies share one inertia.

    Attributes
    ----------
    given : (1 or N, 3) or (1 or N, 3, 3) array
        Principal moments or tensors, from which a Body is made; kg m2, or relative.
    relative : bool
        Whether the unit is unknown.
    bodies : (1 or N,) array of Body, or None
        The bodies, if objects were given.
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

    def resolved(self, omega: FloatArray) -> Resolved:
        """Angular velocities (N, 3) over the principal axes; needs `bodies` if there are tensors.

        NaN for rates that are not finite.
        """
        if self.bodies is None or all(each.has_given_axes for each in self.bodies):
            return Resolved(omega, None)
        rates = np.full((len(omega), 3, 2), np.nan)
        differences = np.full((len(omega), 3, 2), np.nan)
        for k in np.flatnonzero(np.all(np.isfinite(omega), axis=1)):
            body = self.bodies[k if len(self) > 1 else 0]
            rates[k] = body.rates_about_principal_axes(omega[k])
            known = body.differences(omega[k])
            if known is not None:
                differences[k] = known
        return Resolved(rates, differences)

    @property
    def has_tensors(self) -> bool:
        """Whether the principal axes of any member may differ from its body axes."""
        return self.given.ndim == 3

    def tensors(self) -> FloatArray:
        """Inertia tensors (1 or N, 3, 3) in body axes."""
        return self.given if self.has_tensors else self.given[:, :, None] * np.eye(3)


def of_moments(moments: Reals, relative: bool) -> Inertia:
    """The inertia of principal moments (3,) or (N, 3) about the body axes."""
    unit = None if relative else "kg m2"
    given = validation.real(moments, "moments", unit=unit, finite=False)
    given = _leading(given, "moments", (3,))
    pairs = np.zeros((len(given), 3, 2))
    pairs[..., 0] = given
    axes = np.broadcast_to(np.eye(3), (len(given), 3, 3))
    principal = np.broadcast_to(_IDENTITY, (len(given), 4))
    return Inertia(given, relative, None, pairs, axes, principal)


def of_bodies(bodies: Sequence[Body]) -> Inertia:
    """The inertia of Body objects, one for all members or one each."""
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
    tensors = not all(each.has_given_axes for each in bodies)
    given = np.array([each.tensor if tensors else each.moments for each in bodies])
    return _found(given, bool(relative.pop()), objects)


def of_tensors(tensors: Reals, relative: bool) -> Inertia:
    """The inertia of tensors (3, 3) or (N, 3, 3), with its bodies.

    Raises
    ------
    AttitudeError
        For a tensor that no body has: its number and what is wrong.
    """
    unit = None if relative else "kg m2"
    given = _leading(validation.real(tensors, "tensors", unit=unit), "tensors", (3, 3))
    bodies = np.empty(len(given), dtype=object)
    for k, tensor in enumerate(given):
        try:
            bodies[k] = Body(tensor=tensor, relative=relative)
        except AttitudeError as err:
            raise AttitudeError(f"tensor {k} of {len(given)}: {err}") from err
    return _found(given, relative, bodies)


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
    arrays = (
        rows([getattr(each, name) for each in parts]) for name in ("moments", "axes", "principal")
    )
    return Inertia(given, first.relative, bodies, *arrays)


def _found(given: FloatArray, relative: bool, bodies: NDArray[np.object_]) -> Inertia:
    """The Inertia of Body objects."""
    return Inertia(
        given,
        relative,
        bodies,
        np.array([each.moments_as_pairs for each in bodies]).reshape(-1, 3, 2),
        np.array([each.principal_axes for each in bodies]).reshape(-1, 3, 3),
        np.array([each.principal_wxyz for each in bodies]).reshape(-1, 4),
    )


def _leading(array: FloatArray, name: str, last: tuple[int, ...]) -> FloatArray:
    """The array with one leading axis."""
    if array.shape == last:
        return array[None]
    if array.ndim == len(last) + 1 and array.shape[1:] == last:
        return array
    shape = ", ".join(map(str, last))
    raise AttitudeError(f"{name} has shape {array.shape}; give ({shape}) or (N, {shape}).")
