"""Torques on a body, and motions with torques or instantaneous changes.

How to use it::

    from attitude import paths
    from attitude.splitting import TorquedRotation
    from attitude.torques import GravityGradient

    tides = GravityGradient(paths.oem("encounter.oem"), "earth")
    motion = TorquedRotation(free.body, free.spin, tides, step=60.0)
    motion.at("2029-04-14")

_torque             `Torque`, the contract; `GravityGradient`, `ConstantTorque`, `LinearDamping`,
                    `InternalDissipation`, `InertiaHistory`, `CustomTorque`
_radiation          `SolarRadiation`, `AerodynamicTorque`
_magnetic           `EddyCurrent`, `MagneticDipole`; fields: `IGRF`, `DipoleField`
_rheology           `Rheology`, `QualityFactor`, `Maxwell`: friction of an ellipsoid of a material
_compiled           the compiled functions of the built-in torques
_torqued            `TorquedRotation` (`attitude.splitting`); states after fixed and adaptive steps
_system             body, torques and scheme as the compiled loops take them; derivatives
_schemes            `Scheme`: splitting schemes by name
_arcs               `Arcs`, `Impulse`, `InertiaChange` (`attitude.arcs`)
_triggers           changes at an event instead of an epoch
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module

if TYPE_CHECKING:
    # These names, for editors and type checkers.
    from attitude.torques._magnetic import IGRF as IGRF
    from attitude.torques._magnetic import DipoleField as DipoleField
    from attitude.torques._magnetic import EddyCurrent as EddyCurrent
    from attitude.torques._magnetic import MagneticDipole as MagneticDipole
    from attitude.torques._magnetic import MagneticField as MagneticField
    from attitude.torques._radiation import AerodynamicTorque as AerodynamicTorque
    from attitude.torques._radiation import SolarRadiation as SolarRadiation
    from attitude.torques._rheology import Maxwell as Maxwell
    from attitude.torques._rheology import QualityFactor as QualityFactor
    from attitude.torques._rheology import Rheology as Rheology
    from attitude.torques._torque import ConstantTorque as ConstantTorque
    from attitude.torques._torque import CustomTorque as CustomTorque
    from attitude.torques._torque import GravityGradient as GravityGradient
    from attitude.torques._torque import InertiaHistory as InertiaHistory
    from attitude.torques._torque import InternalDissipation as InternalDissipation
    from attitude.torques._torque import LinearDamping as LinearDamping
    from attitude.torques._torque import Torque as Torque

# The names of each module, which is imported when one of them is first used.
_NAMES = {
    "_magnetic": ("DipoleField", "EddyCurrent", "IGRF", "MagneticDipole", "MagneticField"),
    "_radiation": ("AerodynamicTorque", "SolarRadiation"),
    "_rheology": ("Maxwell", "QualityFactor", "Rheology"),
    "_torque": (
        "ConstantTorque",
        "CustomTorque",
        "GravityGradient",
        "InertiaHistory",
        "InternalDissipation",
        "LinearDamping",
        "Torque",
    ),
}
_WHERE = {name: f"{__name__}.{file}" for file, names in _NAMES.items() for name in names}

__all__ = sorted(_WHERE)


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__, _WHERE)


def __dir__() -> list[str]:
    return sorted({*globals(), *_WHERE})
