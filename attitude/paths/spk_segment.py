"""The base class of the segments of a kernel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from attitude import frames
from attitude.epochs.inputs import Instant
from attitude.paths.bodies import body_name
from attitude.paths.path import Path

if TYPE_CHECKING:
    from attitude.paths.spk import Kernel

# The supported inertial frames of SPICE, by SPICE's numbers.
FRAMES: dict[int, str] = {1: "icrf", 17: "ecliptic"}


class Segment(Path):
    """A segment of an SPK file: one body, relative to one center, over one span.

    Attributes
    ----------
    kernel : Kernel
    number : int
        Position of the segment in the file, from 0.
    rotation : (3, 3) array, read-only
        Axes of the segment to ICRF.
    is_turned : bool
        Whether the axes differ from ICRF.
    name, center, source, span
        As for all paths.
    """

    def __init__(self, kernel: Kernel, number: int, name: str, segment: Any) -> None:
        self.kernel = kernel
        self.number = number
        self.name = name
        self.center = body_name(segment.center)
        self.source = kernel.source
        self.span = Instant(segment.start_second), Instant(segment.end_second)
        self.rotation = frames.matrix_to_icrf(FRAMES[segment.frame])
        self.is_turned = segment.frame != 1

    def __reduce__(self) -> tuple[Any, ...]:
        return self.kernel.segment, (self.number,)

    def _in_icrf(self, vectors):
        """Vectors (3, N) over ICRF axes."""
        return self.rotation @ vectors if self.is_turned else vectors
