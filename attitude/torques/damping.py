"""Losses: drag from outside, and friction within the body."""

from dataclasses import dataclass

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.torques.torque import BY_RATE, SLIP, Torque


@dataclass(frozen=True, eq=False)
class LinearDamping(Torque):
    """A drag torque -C w from outside: it takes both energy and angular momentum.

    Parameters
    ----------
    coefficient : float or (3, 3) array_like
        N m s; over the body axes.  A matrix must not add energy: its symmetric part has no
        negative eigenvalue.
    """

    coefficient: np.ndarray
    kind = BY_RATE

    def __post_init__(self):
        given = validation.real(self.coefficient, "coefficient", unit="N m s")
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

    def address(self):
        from attitude.torques.compiled import linear_damping

        return linear_damping.address

    def parameters(self, body):
        return self.coefficient.reshape(9).copy()


@dataclass(frozen=True, eq=False)
class InternalDissipation(Torque):
    """Friction within the body: energy falls at fixed angular momentum, towards short-axis spin.

    The body turns by an additional ``strength * (l x w)`` under its momentum, l being the
    direction of the momentum over the body axes, so that

        dE/dt = -strength L |l x w|^2 <= 0   and   L is fixed in space, to rounding.

    Parameters
    ----------
    strength : float
        Pure number, not negative: about the inverse of the quality factor.

    Notes
    -----
    Double-bracket dissipation (Bloch, Krishnaprasad, Marsden & Ratiu 1996, Commun. Math. Phys.
    175, 1), the simplest model that has these two laws; how its strength follows from a material
    is another matter (Breiter, Rozek & Vokrouhlicky 2012).  Integrated to second order in the
    step, whatever the scheme.
    """

    strength: float
    kind = SLIP

    def __post_init__(self):
        given = validation.number(self.strength, "strength")
        if given < 0.0:
            raise AttitudeError(f"strength is {given!r}; friction does not add energy: give >= 0.")
        self._set("strength", given)

    def address(self):
        from attitude.torques.compiled import internal_dissipation

        return internal_dissipation.address

    def parameters(self, body):
        return np.concatenate([[self.strength], body.tensor[np.triu_indices(3)]])
