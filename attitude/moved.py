"""Earlier import paths of modules that moved, so that scripts written for them still run.

``from attitude.spread import spread`` imports from `attitude.published.uncertainty`.  The finder
is the last of ``sys.meta_path``: Python calls it only for modules that no other finder finds.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.machinery import ModuleSpec
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import ModuleType

# Earlier path: present path.
MOVED: Final[dict[str, str]] = {
    "attitude.check": "attitude.selftest",
    "attitude.crossing": "attitude.arcs.triggers",
    "attitude.dynamic_inertia": "attitude.published.dynamic_inertia",
    "attitude.interpolation": "attitude.attitude_table.interpolation",
    "attitude.labelling": "attitude.published.conventions",
    "attitude.polhode": "attitude.free_rotation.polhode",
    "attitude.precession": "attitude.published.regular_precession",
    "attitude.predictability": "attitude.free_rotation.predictability",
    "attitude.schemes": "attitude.splitting.schemes",
    "attitude.spread": "attitude.published.uncertainty",
    "attitude.events.moments": "attitude.conditions.moments",
    "attitude.formats.ccsds.axes": "attitude.axes.axes",
    "attitude.formats.ccsds.axis_names": "attitude.axes.axis_names",
    "attitude.formats.ccsds.earth_axes": "attitude.axes.earth_axes",
    "attitude.formats.ccsds.orbit_axes": "attitude.axes.orbit_axes",
    "attitude.formats.damit_light_curve": "attitude.formats.damit.light_curve",
    "attitude.formats.which": "attitude.formats.detect",
    "attitude.light_curve.blocks": "attitude.blocks",
}


class _Finder:
    """Finder and loader of modules under their earlier paths.

    Without the base classes of importlib.abc, which takes 15 ms to import.
    """

    def __init__(self) -> None:
        self._specs: dict[str, ModuleSpec | None] = {}

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        if fullname not in MOVED:
            return None
        return ModuleSpec(fullname, self)  # type: ignore[arg-type]  # no Loader by inheritance

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = import_module(MOVED[spec.name])
        self._specs[spec.name] = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        # The module has run already; importlib has overwritten its spec by that of the earlier
        # path.
        earlier = module.__spec__
        assert earlier is not None
        module.__spec__ = self._specs.pop(earlier.name)


def install() -> None:
    """Add the finder to ``sys.meta_path``, once."""
    if not any(isinstance(each, _Finder) for each in sys.meta_path):
        sys.meta_path.append(_Finder())
