"""Torques on a body: what `attitude.splitting.TorquedRotation` integrates."""

from importlib import import_module

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


def __getattr__(name):
    if name not in _WHERE:
        raise AttributeError(f"module 'attitude.torques' has no attribute {name!r}")
    value = getattr(import_module(_WHERE[name]), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_WHERE})
