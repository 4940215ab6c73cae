"""Losses: drag from outside, and friction within the body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.torques.torque import LINEAR, SLIP, Torque

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals
    from attitude.body import Body


@dataclass(frozen=True, eq=False, init=False)
class LinearDamping(Torque):
    """A drag torque -C w from outside: it removes energy and angular momentum.

    Parameters
    ----------
    coefficient : float, Quantity or (3, 3) array_like
        C in N m s, over the body axes.  A matrix must not add energy: its symmetric part has no
        negative eigenvalue.

    Attributes
    ----------
    coefficient : (3, 3) float64 array, read-only

    Raises
    ------
    AttitudeError
        For another shape or unit, and for a matrix that adds energy.
    """

    coefficient: FloatArray
    kind = LINEAR

    def __init__(self, coefficient: Real | Reals) -> None:
        given = validation.real(coefficient, "coefficient", unit="N m s")
        if given.shape == ():
            given = given * np.eye(3)
        given = validation.real(given, "coefficient", shape=(3, 3))
        least = np.linalg.eigvalsh(given + given.T).min()
        if least < -1e-12 * np.max(np.abs(given)):
            raise AttitudeError(
                "coefficient would add energy: its symmetric part has a negative eigenvalue. "
                "Give a matrix that is positive semidefinite."
            )
        self._set("coefficient", frozen(given))

    def address(self) -> int:
        """Address of `compiled.linear_damping`."""
        from attitude.torques.compiled import linear_damping

        return linear_damping.address

    def parameters(self, body: Body) -> FloatArray:
        """The matrix C by rows (9,), N m s."""
        return self.coefficient.reshape(9).copy()

    def by_rate(self) -> FloatArray:
        """-C, N m s."""
        return -self.coefficient


@dataclass(frozen=True, eq=False, init=False)
class InternalDissipation(Torque):
    """Friction within the body: energy falls at fixed angular momentum, towards short-axis spin.

    The body turns by an additional ``strength * (l x w)`` under its momentum, l being the
    direction of the momentum over the body axes, so that

        dE/dt = -strength L |l x w|^2 <= 0   and   L is fixed in space, to rounding.

    Parameters
    ----------
    strength : float
        Pure number, not negative: about the inverse of the quality factor.

    Raises
    ------
    AttitudeError
        For a negative strength.

    Notes
    -----
    Double-bracket dissipation (Bloch, Krishnaprasad, Marsden & Ratiu 1996, Commun. Math. Phys.
    175, 1), the simplest model with these two laws.  It does not derive the strength from a
    material; see Breiter, Rozek & Vokrouhlicky 2012.  Integrated to second order in the step,
    whatever the scheme.
    """

    strength: float
    kind = SLIP

    def __init__(self, strength: Real) -> None:
        given = validation.number(strength, "strength")
        if given < 0.0:
            raise AttitudeError(f"strength is {given!r}; friction does not add energy: give >= 0.")
        self._set("strength", given)

    def address(self) -> int:
        """Address of `compiled.internal_dissipation`."""
        from attitude.torques.compiled import internal_dissipation

        return internal_dissipation.address

    def parameters(self, body: Body) -> FloatArray:
        """The strength, and the tensor's upper triangle by rows (7,)."""
        return np.concatenate([[self.strength], body.tensor[np.triu_indices(3)]])
