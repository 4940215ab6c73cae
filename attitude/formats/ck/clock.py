"""The clock of a C-kernel: one that is written beside it, or that of a mission.

The own clock counts 2^20 ticks a second, of TDB or, for SPICE's own relation between UTC and TDB,
of TDT (TT): then SPICE takes an epoch of `str2et` back to TT by the formula by which it made it.
With a mission's clock SPICE converts epochs, one double of TDB, to ticks.
"""

from __future__ import annotations

import os
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.errors import AttitudeError
from attitude.formats.ck import kernel_files
from attitude.formats.ck.spice_pool import LoadedKernels, spiceypy

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from attitude.annotations import FilePath, FloatArray

# Ticks a second: a power of two, so that doubles of seconds become ticks without rounding.
_TICKS = 2.0**20
_DATA_TYPE = "SCLK_DATA_TYPE_"


@dataclass(frozen=True)
class KernelClock:
    """A clock, for seconds counted from the begin of a kernel.

    Attributes
    ----------
    number : int
        NAIF number, negative.
    ticks : callable
        Encoded clock times (N,) of seconds (N,) since `first`.
    per_tick : float
        Seconds of a tick.
    text : str or None
        The clock kernel to be written; None for that of a mission.
    """

    number: int
    ticks: Callable[[FloatArray], FloatArray]
    per_tick: float
    text: str | None


def own(number: int, first: float, scale: str) -> KernelClock:
    """A clock that counts from `first`, seconds of TDB or TT since J2000, by `scale`."""
    system = {"tdb": 1, "tt": 2}[scale]
    text = kernel_files.CLOCK.format(
        start=repr(first), minus_clock=-number, system=system, scale=scale.upper()
    )
    return KernelClock(number, lambda seconds: seconds * _TICKS, 1.0 / _TICKS, text)


@contextmanager
def of_mission(files: Sequence[FilePath], first: float, span: float) -> Iterator[KernelClock]:
    """The clock of a mission, loaded until the end of the block.

    Parameters
    ----------
    files : sequence of paths
        One clock kernel, and leap seconds if it needs them.
    first, span : float
        Begin, TDB seconds since J2000, and length, s, of the C-kernel.

    Raises
    ------
    AttitudeError
        For files without a clock, or with several, and for epochs that the clock does not cover.
    """
    spice = spiceypy()
    known = _clocks(spice)
    with LoadedKernels(files):
        found = sorted(set(_clocks(spice)) - set(known)) or sorted(known)
        listed = ", ".join(os.fspath(name) for name in files)
        if len(found) != 1:
            raise AttitudeError(
                f"the files {listed} define {len(found)} clocks; give the clock kernel (SCLK) of "
                "one spacecraft."
            )
        number = -found[0]

        def ticks(seconds: FloatArray) -> FloatArray:
            try:
                return np.array([spice.sce2c(number, first + s) for s in seconds.tolist()])
            except spice.exceptions.SpiceyError as err:
                spice.reset()
                raise AttitudeError(
                    f"the clock {number} of {listed} has no time there ({err.short}); leap seconds "
                    "may be missing, or the epochs lie outside of its partitions."
                ) from err

        ends = ticks(np.array([0.0, span]))
        yield KernelClock(number, ticks, span / float(ends[1] - ends[0]), None)


def _clocks(spice: Any) -> list[int]:
    """The numbers, without their sign, of the clocks in the pool."""
    try:
        names = spice.gnpool(_DATA_TYPE + "*", 0, 1000)
    except spice.exceptions.NotFoundError:
        return []
    return [int(name.removeprefix(_DATA_TYPE)) for name in names]
