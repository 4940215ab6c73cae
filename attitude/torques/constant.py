"""A torque that is fixed in the body: a thruster, a leak."""

from dataclasses import dataclass

import numpy as np

from attitude import validation
from attitude.immutable import frozen
from attitude.torques.torque import Torque


@dataclass(frozen=True, eq=False)
class ConstantTorque(Torque):
    """A torque with constant components over the body axes.

    Parameters
    ----------
    torque : (3,) array_like
        N m, or a Quantity.
    """

    torque: np.ndarray

    def __post_init__(self):
        self._set("torque", frozen(validation.real(self.torque, "torque", shape=(3,), unit="N m")))

    def address(self):
        from attitude.torques.compiled import constant

        return constant.address

    def slope_address(self):
        from attitude.torques.compiled import constant_slope

        return constant_slope.address

    def parameters(self, body):
        return np.array(self.torque)
