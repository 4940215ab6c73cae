"""Earlier import paths of modules that moved, so that scripts written for them go on.

``from attitude.spread import spread`` still imports, from `attitude.published.uncertainty`.  The
finder stands last in ``sys.meta_path``: it is reached only by names that do not exist.
"""

import sys
from importlib import import_module
from importlib.machinery import ModuleSpec

MOVED = {
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
    "attitude.formats.damit_light_curve": "attitude.formats.damit.light_curve",
    "attitude.formats.which": "attitude.formats.detect",
}


class _Finder:
    """Import a module under the path that it had."""

    def __init__(self):
        self._specs = {}

    def find_spec(self, fullname, path=None, target=None):
        return ModuleSpec(fullname, self) if fullname in MOVED else None

    def create_module(self, spec):
        module = import_module(MOVED[spec.name])
        self._specs[spec.name] = module.__spec__
        return module

    def exec_module(self, module):
        # It has run already; importlib has overwritten its spec with that of the earlier path.
        module.__spec__ = self._specs.pop(module.__spec__.name)


def install():
    """Add the finder to ``sys.meta_path``, once."""
    if not any(isinstance(each, _Finder) for each in sys.meta_path):
        sys.meta_path.append(_Finder())
