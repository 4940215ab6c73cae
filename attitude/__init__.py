"""Exact attitude of freely tumbling spacecraft and asteroids at any epoch.

Heavy packages are imported where they are used, so that ``import attitude`` costs little.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from attitude._support.synonyms import absent
from attitude.errors import AttitudeError as AttitudeError

if TYPE_CHECKING:
    # The names of _MODULES and _WHERE, for editors and type checkers.
    import attitude.arcs
    import attitude.averaged
    import attitude.catalog
    import attitude.conditions
    import attitude.ensemble
    import attitude.epochs
    import attitude.errors
    import attitude.events
    import attitude.fitting
    import attitude.formats
    import attitude.frames
    import attitude.inversion
    import attitude.jacobi
    import attitude.jax
    import attitude.light_curve
    import attitude.motions
    import attitude.paths
    import attitude.photometry
    import attitude.plots
    import attitude.proof
    import attitude.published
    import attitude.quaternion
    import attitude.referee
    import attitude.representations
    import attitude.scattering
    import attitude.scene
    import attitude.shape
    import attitude.splitting
    import attitude.survey
    import attitude.torch
    import attitude.torques
    import attitude.viewer  # noqa: F401
    from attitude._compilation.decorators import compilation_status as compilation_status
    from attitude._solver.regime import Mode as Mode
    from attitude.ensemble._ensemble import Ensemble as Ensemble
    from attitude.fitting._attitudes import fit as fit
    from attitude.fitting._attitudes import fit_directions as fit_directions
    from attitude.fitting._attitudes import fit_rates as fit_rates
    from attitude.motions._body import Body as Body
    from attitude.motions._certify import certify as certify
    from attitude.motions._free_rotation import FreeRotation as FreeRotation
    from attitude.motions._history import AttitudeHistory as AttitudeHistory
    from attitude.motions._propagation import propagate as propagate
    from attitude.motions._spin import Spin as Spin
    from attitude.motions._table import AttitudeTable as AttitudeTable
    from attitude.referee._referee import compare as compare
    from attitude.scene._scene import Scene as Scene
    from attitude.torques._arcs import Arcs as Arcs
    from attitude.torques._arcs import Impulse as Impulse
    from attitude.torques._arcs import InertiaChange as InertiaChange
    from attitude.torques._torqued import TorquedRotation as TorquedRotation

__version__ = "0.1.0"


# The module that defines each name, imported when the name is first used.
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
    "certify": "attitude.motions._certify",
    "compilation_status": "attitude._compilation.decorators",
    "compare": "attitude.referee._referee",
    "fit": "attitude.fitting._attitudes",
    "fit_directions": "attitude.fitting._attitudes",
    "fit_rates": "attitude.fitting._attitudes",
    "propagate": "attitude.motions._propagation",
}

__all__ = ["AttitudeError", *sorted(_WHERE)]

# The modules whose names are public; others may change in any release.
PUBLIC_MODULES: tuple[str, ...] = (
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
    "attitude.formats.acm",
    "attitude.formats.aem",
    "attitude.formats.apm",
    "attitude.formats.cic",
    "attitude.formats.ck",
    "attitude.formats.damit",
    "attitude.formats.damit_light_curve",
    "attitude.formats.detect",
    "attitude.formats.mission",
    "attitude.formats.quat",
    "attitude.formats.spin_file",
    "attitude.formats.stk",
    "attitude.formats.tables",
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
)

# Those that are imported when they are first used as attributes, such as attitude.events.
_MODULES = tuple(dict.fromkeys(name.split(".")[1] for name in PUBLIC_MODULES[1:]))


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    def __getattr__(name: str) -> Any:
        if name in _MODULES:
            return import_module(f"attitude.{name}")
        if name not in _WHERE:
            raise absent("attitude", name)
        value = getattr(import_module(_WHERE[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_MODULES, "__version__"})
