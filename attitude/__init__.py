"""Exact attitude of freely tumbling spacecraft and asteroids at any epoch.

Heavy packages are imported where they are used, so that ``import attitude`` costs little.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from attitude._support.synonyms import absent
from attitude.errors import AttitudeError as AttitudeError

__version__ = "0.1.0"


# The module that defines each name, imported when the name is first used; type checkers read
# __init__.pyi.
_WHERE = {
    "Arcs": "attitude.torques._arcs",
    "AttitudeHistory": "attitude.motions._history",
    "AttitudeTable": "attitude.motions._table",
    "Body": "attitude.motions._body",
    "Ensemble": "attitude.ensemble._ensemble",
    "FreeRotation": "attitude.motions._free_rotation",
    "Impulse": "attitude.torques._arcs",
    "InertiaChange": "attitude.torques._arcs",
    "Mode": "attitude._solver.regime",
    "Scene": "attitude.scene._scene",
    "Spin": "attitude.motions._spin",
    "TorquedRotation": "attitude.torques._torqued",
    "certify": "attitude.motions._free_rotation",
    "compilation_status": "attitude._compilation.decorators",
    "compare": "attitude.referee._referee",
    "fit": "attitude.fitting._attitudes",
    "fit_directions": "attitude.fitting._attitudes",
    "fit_rates": "attitude.fitting._attitudes",
    "propagate": "attitude.motions._propagation",
}

__all__ = ["AttitudeError", *sorted(_WHERE)]

# The modules of formats that register one, in the order in which sentences list their endings.
FORMAT_MODULES: tuple[str, ...] = (
    "aem",
    "apm",
    "acm",
    "stk",
    "cic",
    "spin_file",
    "damit",
    "ck",
    "tables",
    "quat",
)
# The modules whose names are public; others may change in any release.
_PUBLIC: tuple[str, ...] = (
    "attitude",
    "attitude.arcs",
    "attitude.averaged",
    "attitude.catalog",
    "attitude.conditions",
    "attitude.ensemble",
    "attitude.epochs",
    "attitude.errors",
    "attitude.events",
    "attitude.fitting",
    "attitude.formats",
    "attitude.formats.damit_light_curve",
    "attitude.formats.detect",
    "attitude.formats.mission",
    "attitude.frames",
    "attitude.frames.quaternion",
    "attitude.frames.representations",
    "attitude.inversion",
    "attitude.jacobi",
    "attitude.jax",
    "attitude.light_curve",
    "attitude.motions",
    "attitude.paths",
    "attitude.photometry",
    "attitude.plots",
    "attitude.proof",
    "attitude.published",
    "attitude.quaternion",
    "attitude.referee",
    "attitude.representations",
    "attitude.scattering",
    "attitude.scene",
    "attitude.shape",
    "attitude.splitting",
    "attitude.survey",
    "attitude.torch",
    "attitude.torques",
    "attitude.viewer",
    *(f"attitude.formats.{name}" for name in FORMAT_MODULES),
)
PUBLIC_MODULES: tuple[str, ...] = tuple(sorted(_PUBLIC))

# Those that are imported when they are first used as attributes, such as attitude.events.
_MODULES = tuple(dict.fromkeys(name.split(".")[1] for name in PUBLIC_MODULES[1:]))


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        try:
            return import_module(f"attitude.{name}")
        except ImportError as err:  # jax, torch: to hasattr, help and inspect a name that is absent
            raise AttributeError(str(err), name=name) from err
    if name not in _WHERE:
        raise absent("attitude", name)
    value = getattr(import_module(_WHERE[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_MODULES, "__version__"})
