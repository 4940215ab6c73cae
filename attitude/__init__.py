"""Exact attitude of freely tumbling spacecraft and asteroids at any epoch.

Heavy packages are imported where they are used, so that ``import attitude`` costs little.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from attitude import moved
from attitude.errors import AttitudeError as AttitudeError

if TYPE_CHECKING:
    # The names of _MODULES and _WHERE, for editors and type checkers.
    import attitude.arcs
    import attitude.attitude_table
    import attitude.axes
    import attitude.body
    import attitude.catalog
    import attitude.conditions
    import attitude.ensemble
    import attitude.epochs
    import attitude.errors
    import attitude.events
    import attitude.fitting
    import attitude.formats
    import attitude.frames
    import attitude.free_rotation
    import attitude.history
    import attitude.inversion
    import attitude.jacobi
    import attitude.jax
    import attitude.light_curve
    import attitude.motion
    import attitude.paths
    import attitude.photometry
    import attitude.plots
    import attitude.propagation
    import attitude.published
    import attitude.quaternion
    import attitude.referee
    import attitude.regime
    import attitude.representations
    import attitude.scattering
    import attitude.scene
    import attitude.sensitivities
    import attitude.shape
    import attitude.spectrum
    import attitude.spin
    import attitude.splitting
    import attitude.survey
    import attitude.torch
    import attitude.torques
    import attitude.viewer  # noqa: F401
    from attitude.arcs.arcs import Arcs as Arcs
    from attitude.arcs.arcs import Impulse as Impulse
    from attitude.arcs.arcs import InertiaChange as InertiaChange
    from attitude.attitude_table.table import AttitudeTable as AttitudeTable
    from attitude.body import Body as Body
    from attitude.compilation.status import compilation_status as compilation_status
    from attitude.ensemble.ensemble import Ensemble as Ensemble
    from attitude.fitting import fit as fit
    from attitude.fitting import fit_directions as fit_directions
    from attitude.fitting import fit_rates as fit_rates
    from attitude.free_rotation.free_rotation import FreeRotation as FreeRotation
    from attitude.history import AttitudeHistory as AttitudeHistory
    from attitude.propagation import propagate as propagate
    from attitude.referee.referee import compare as compare
    from attitude.regime import Mode as Mode
    from attitude.scene.scene import Scene as Scene
    from attitude.spin import Spin as Spin
    from attitude.splitting.torqued_rotation import TorquedRotation as TorquedRotation

__version__ = "0.1.0"

moved.install()

# The module that defines each name, imported when the name is first used.
_WHERE = {
    "Arcs": "attitude.arcs.arcs",
    "AttitudeHistory": "attitude.history",
    "AttitudeTable": "attitude.attitude_table.table",
    "Body": "attitude.body",
    "Ensemble": "attitude.ensemble.ensemble",
    "FreeRotation": "attitude.free_rotation.free_rotation",
    "Impulse": "attitude.arcs.arcs",
    "InertiaChange": "attitude.arcs.arcs",
    "Mode": "attitude.regime",
    "Scene": "attitude.scene.scene",
    "Spin": "attitude.spin",
    "TorquedRotation": "attitude.splitting.torqued_rotation",
    "compilation_status": "attitude.compilation.status",
    "compare": "attitude.referee.referee",
    "fit": "attitude.fitting",
    "fit_directions": "attitude.fitting",
    "fit_rates": "attitude.fitting",
    "propagate": "attitude.propagation",
}

__all__ = ["AttitudeError", *sorted(_WHERE)]

# The modules whose names are public; others may change in any release.
PUBLIC_MODULES: tuple[str, ...] = (
    "attitude",
    *(
        f"attitude.{name}"
        for name in (
            *("arcs", "arcs.triggers", "attitude_table", "axes.axes", "body", "catalog"),
            *("conditions.condition", "conditions.observable", "ensemble"),
            *("ensemble.partitioned", "epochs", "errors", "events", "fitting", "formats"),
            *("formats.acm", "formats.aem", "formats.apm", "formats.cic", "formats.ck"),
            *("formats.damit",),
            *("formats.detect", "formats.mission", "formats.photometry", "formats.spin_file"),
            *("formats.stk", "formats.tables", "frames", "free_rotation", "history", "inversion"),
            *(
                "jacobi",
                "jax",
                "light_curve",
                "motion",
                "paths",
                "paths.two_body",
                "photometry",
                "plots",
            ),
            *("propagation", "published", "published.dynamic_inertia"),
            *("published.regular_precession", "published.uncertainty", "quaternion", "referee"),
            *("regime", "representations", "scattering", "scene", "sensitivities.columns"),
            *("sensitivities.covariance", "sensitivities.elements", "shape", "spectrum", "spin"),
            *("splitting", "survey", "torch", "torques", "viewer"),
        )
    ),
)


# Those that are imported when they are first used as attributes, such as attitude.events.
_MODULES = tuple(dict.fromkeys(name.split(".")[1] for name in PUBLIC_MODULES[1:]))


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    def __getattr__(name: str) -> Any:
        if name in _MODULES:
            return import_module(f"attitude.{name}")
        if name not in _WHERE:
            raise AttributeError(f"module 'attitude' has no attribute {name!r}")
        value = getattr(import_module(_WHERE[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_MODULES, "__version__"})
