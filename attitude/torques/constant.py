"""A torque that is fixed in the body: a thruster, a leak."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.immutable import frozen
from attitude.torques.torque import Torque

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Reals
    from attitude.body import Body


@dataclass(frozen=True, eq=False, init=False)
class ConstantTorque(Torque):
    """A torque with constant components over the body axes.

    Parameters
    ----------
    torque : (3,) array_like or Quantity
        N m.

    Raises
    ------
    AttitudeError
        For another shape or unit, and for numbers that are not finite.
    """

    torque: FloatArray

    def __init__(self, torque: Reals) -> None:
        self._set("torque", frozen(validation.real(torque, "torque", shape=(3,), unit="N m")))

    def address(self) -> int:
        """Address of `compiled.constant`."""
        from attitude.torques.compiled import constant

        return constant.address

    def slope_address(self) -> int:
        """Address of `compiled.constant_slope`."""
        from attitude.torques.compiled import constant_slope

        return constant_slope.address

    def parameters(self, body: Body) -> FloatArray:
        """The torque (3,), N m over the body axes."""
        return np.array(self.torque)
