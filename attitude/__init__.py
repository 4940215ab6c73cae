"""Exact attitude of freely tumbling spacecraft and asteroids at any epoch.

Heavy packages are imported where they are used, so that ``import attitude`` costs little.
"""

from importlib import import_module

from attitude import moved
from attitude.errors import AttitudeError

__version__ = "0.1.0"

moved.install()

_WHERE = {
    "Arcs": "attitude.arcs.arcs",
    "AttitudeHistory": "attitude.history",
    "AttitudeTable": "attitude.attitude_table.table",
    "Body": "attitude.body",
    "FreeRotation": "attitude.free_rotation.free_rotation",
    "Impulse": "attitude.arcs.arcs",
    "InertiaChange": "attitude.arcs.arcs",
    "Mode": "attitude.regime",
    "Scene": "attitude.scene.scene",
    "Spin": "attitude.spin",
    "TorquedRotation": "attitude.splitting.torqued_rotation",
    "compare": "attitude.referee.referee",
    "fit": "attitude.fitting",
    "propagate": "attitude.propagation",
}

__all__ = ["AttitudeError", *sorted(_WHERE)]


def __getattr__(name):
    if name not in _WHERE:
        raise AttributeError(f"module 'attitude' has no attribute {name!r}")
    value = getattr(import_module(_WHERE[name]), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_WHERE})
