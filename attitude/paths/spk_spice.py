"""Segments of SPK files that only SPICE can read: types 1, 5, 8 to 21, through spiceypy.

SPICE keeps loaded kernels in a pool for the whole process; this module reads one segment of one
file by its own handle, and neither uses nor changes the pool.  SPICE is not thread-safe: compress
the path of such a segment before several threads use it.
"""

from __future__ import annotations

import importlib.util
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import calls, pairs
from attitude.errors import AttitudeError
from attitude.paths.spk_segment import Segment

if TYPE_CHECKING:
    from attitude.paths.spk import Kernel


class SpiceSegment(Segment):
    """A segment that SPICE evaluates, one epoch at a time: some 4 microseconds each.

    SPICE takes epochs as one double of seconds past J2000 (1e-7 s, 4 mm at 30 km/s); the motion in
    the remaining time is added by the velocity.
    """

    def __init__(self, kernel: Kernel, number: int, name: str, segment: Any) -> None:
        super().__init__(kernel, number, name, segment)
        if importlib.util.find_spec("spiceypy") is None:
            raise AttitudeError(
                f"{kernel.source} has {name} in a segment of type {segment.data_type}, which needs "
                f"SPICE; install it by {calls.installing('spice')}."
            )
        self._arguments = (kernel.file, number)

    def _state(self, instant, hi, lo):
        import spiceypy

        self.check_span(instant, hi, lo)
        seconds, rest = pairs.add((hi, lo), instant.seconds, instant.low)
        seconds, rest = np.broadcast_arrays(seconds, rest)
        handle, descriptor = _handle(*self._arguments)
        states = np.empty((seconds.size, 6))
        for k, second in enumerate(seconds.tolist()):
            try:
                states[k] = spiceypy.spkpvn(handle, descriptor, second)[1]
            except spiceypy.exceptions.SpiceyError as err:
                spiceypy.reset()
                raise AttitudeError(
                    f"SPICE cannot evaluate {self.name} in {self.source} at {second!r} s past "
                    f"J2000 ({err.short}); check the file with SPICE's brief."
                ) from err
        position, velocity = 1e3 * states.T[:3], 1e3 * states.T[3:]
        position += velocity * rest
        return self._in_icrf(position), self._in_icrf(velocity)


@lru_cache(maxsize=64)
def _handle(file, number):
    """SPICE's handle of a file, opened for reading outside of the pool, and a descriptor."""
    import spiceypy

    handle = spiceypy.dafopr(file)
    spiceypy.dafbfs(handle)
    for _ in range(number + 1):
        spiceypy.daffna()
    return handle, spiceypy.dafgs()[:5]
