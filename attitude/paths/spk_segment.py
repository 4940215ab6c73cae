"""What all segments of a kernel have in common, whoever evaluates them."""

from attitude import frames
from attitude.epochs.inputs import Instant
from attitude.paths.bodies import body_name
from attitude.paths.path import Path

# The inertial frames of SPICE that are read, by its numbers.
FRAMES = {1: "icrf", 17: "ecliptic"}


class Segment(Path):
    """A part of an SPK file: one body, from one center, over one span."""

    def __init__(self, kernel, number, name, segment):
        self.kernel = kernel
        self.number = number
        self.name = name
        self.center = body_name(segment.center)
        self.source = kernel.source
        self.span = Instant(segment.start_second), Instant(segment.end_second)
        self.rotation = frames.matrix_to_icrf(FRAMES[segment.frame])
        self.is_turned = segment.frame != 1

    def __reduce__(self):
        return self.kernel.segment, (self.number,)

    def _in_icrf(self, vectors):
        return self.rotation @ vectors if self.is_turned else vectors
