"""Splitting schemes: the order and the lengths of kicks and free motions in a step.

A step of length h is  kick b0 h, free motion a1 h, kick b1 h, ..., free motion an h, kick bn h,
the same forwards and backwards; each is time-reversible and, where the torque has a potential,
symplectic.  The free motion is exact, so momentum about any axis without torque is conserved to
rounding, and the error is that of the commutator of torque and motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray
    from attitude.motions._body import Body


# ---- Principal axes in the order of their moments, as the exact short step takes them


def ascending(body: Body) -> tuple[FloatArray, FloatArray]:
    """Principal moments (3,) in ascending order, and the axes (3, 3) they belong to."""
    order = np.argsort(body.moments, kind="stable")
    axes = body.principal_axes[:, order]
    moments = body.moments[order]
    moments = np.ldexp(moments, -int(np.frexp(moments[2])[1]))
    return moments, axes if np.linalg.det(axes) > 0.0 else -axes


# Largest deviation from 1 of the sum of published coefficients, of 15 digits.
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False, init=False)
class Scheme(Immutable):
    """The coefficients of a splitting scheme, in units of the step.

    Parameters
    ----------
    name : str
    order : int
        Of the error in the step.
    kicks : (n + 1,) array_like
    flights : (n,) array_like
        Of the free motions between the kicks.
    gradients : (n + 1,) array_like
        Of the force gradient, in units of the cube of the step.
    source : str

    Raises
    ------
    AttitudeError
        For arrays of other lengths, and kicks or flights that do not add up to 1.
    """

    name: str
    order: int
    kicks: FloatArray
    flights: FloatArray
    gradients: FloatArray
    source: str

    def __init__(
        self,
        name: str,
        order: int,
        kicks: ArrayLike,
        flights: ArrayLike,
        gradients: ArrayLike,
        source: str,
    ) -> None:
        self._set_all(name=name, source=source)
        coefficients = {"kicks": kicks, "flights": flights, "gradients": gradients}
        for label, values in coefficients.items():
            self._set(label, frozen(validation.real(values, f"{label} of a Scheme")))
        shapes = [array.shape for array in (self.kicks, self.flights, self.gradients)]
        count = self.flights.size
        if count < 1 or shapes != [(count + 1,), (count,), (count + 1,)]:
            raise AttitudeError(
                f"a Scheme has kicks, flights and gradients of shapes {shapes}; give n + 1, n and "
                "n + 1 numbers, n at least 1."
            )
        for label, shares in (("kicks", self.kicks), ("flights", self.flights)):
            total = math.fsum(shares)
            if abs(total - 1.0) > _ROUNDING:
                raise AttitudeError(
                    f"the {label} of a Scheme add up to {total!r}; they are shares of a step: give "
                    "numbers that add up to 1."
                )
        self._set("order", validation.count(order, "order"))

    @property
    def evaluations(self) -> int:
        """Torque evaluations a step (that of the last kick serves the first of the next step)."""
        used = (self.kicks != 0.0) | (self.gradients != 0.0)
        shared = int(used[0] and used[-1])
        return int(np.count_nonzero(used)) - shared + 2 * int(np.count_nonzero(self.gradients))


def scheme(name: str | Scheme) -> Scheme:
    """A scheme by its name, or the scheme itself.

    Parameters
    ----------
    name : str or Scheme
        One of `SCHEMES`.

    Raises
    ------
    AttitudeError
        For any other name; the message lists them.
    """
    if isinstance(name, Scheme):
        return name
    if not isinstance(name, str) or name not in SCHEMES:
        listed = ", ".join(repr(known) for known in SCHEMES)
        raise AttitudeError(f"scheme is {name!r}; give one of {listed}, or a Scheme.")
    return SCHEMES[name]


def _both_ways(half, middle):
    return [*half, *middle, *reversed(half)]


def _suzuki():
    p = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
    parts = [p, p, 1.0 - 4.0 * p, p, p]
    kicks = [0.5 * p, p, 0.5 * (1.0 - 3.0 * p), 0.5 * (1.0 - 3.0 * p), p, 0.5 * p]
    return Scheme(
        "suzuki", 4, kicks, parts, [0.0] * 6, "Suzuki 1990, Phys. Lett. A 146, 319: five steps"
    )


def _blanes_moan():
    b = [0.0829844064174052, 0.396309801498368, -0.0390563049223486]
    a = [0.245298957184271, 0.604872665711080]
    a.append(0.5 - sum(a))
    return Scheme(
        "blanes-moan",
        4,
        _both_ways(b, [1.0 - 2.0 * sum(b)]),
        _both_ways(a, []),
        [0.0] * 7,
        "Blanes & Moan 2002, J. Comput. Appl. Math. 142, 313: SRKN 6, order 4",
    )


_XI = 0.1931833275037836

SCHEMES: dict[str, Scheme] = {
    entry.name: entry
    for entry in (
        Scheme(
            "kick-rotate-kick",
            2,
            [0.5, 0.5],
            [1.0],
            [0.0, 0.0],
            "van Zon & Schofield 2007, Phys. Rev. E 75, 056701 (cond-mat/0612404)",
        ),
        Scheme(
            "rotate-kick-rotate", 2, [0.0, 1.0, 0.0], [0.5, 0.5], [0.0] * 3, "its adjoint order"
        ),
        Scheme(
            "hoa",
            2,
            [_XI, 1.0 - 2.0 * _XI, _XI],
            [0.5, 0.5],
            [0.0] * 3,
            "van Zon, Omelyan & Schofield 2008, J. Chem. Phys. 128, 136102; McLachlan 1995",
        ),
        _suzuki(),
        _blanes_moan(),
        Scheme(
            "force-gradient",
            4,
            [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
            [0.5, 0.5],
            [0.0, 1.0 / 72.0, 0.0],
            "Suzuki 1995; Chin 1997, Phys. Lett. A 226, 344; van Zon, Omelyan & Schofield 2008",
        ),
    )
}
