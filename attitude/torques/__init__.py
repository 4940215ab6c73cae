"""Torques on a body, which `attitude.splitting.TorquedRotation` integrates."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # The names of _WHERE, for editors and type checkers.
    from attitude.torques.constant import ConstantTorque as ConstantTorque
    from attitude.torques.custom import CustomTorque as CustomTorque
    from attitude.torques.damping import InternalDissipation as InternalDissipation
    from attitude.torques.damping import LinearDamping as LinearDamping
    from attitude.torques.gravity_gradient import GravityGradient as GravityGradient
    from attitude.torques.radiation import SolarRadiation as SolarRadiation
    from attitude.torques.torque import Torque as Torque

# The module that defines each name, imported when the name is first used.
_WHERE = {
    "ConstantTorque": "attitude.torques.constant",
    "CustomTorque": "attitude.torques.custom",
    "GravityGradient": "attitude.torques.gravity_gradient",
    "InternalDissipation": "attitude.torques.damping",
    "LinearDamping": "attitude.torques.damping",
    "SolarRadiation": "attitude.torques.radiation",
    "Torque": "attitude.torques.torque",
}

__all__ = sorted(_WHERE)


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    def __getattr__(name: str) -> Any:
        if name not in _WHERE:
            raise AttributeError(f"module 'attitude.torques' has no attribute {name!r}")
        value = getattr(import_module(_WHERE[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_WHERE})
