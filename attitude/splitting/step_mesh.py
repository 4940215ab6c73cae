"""The lengths of the steps of a torqued motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class StepMesh:
    """The steps from the epoch in one direction of time.

    Attributes
    ----------
    times : (2, N + 1) array
        s since the epoch, in two doubles: the starts of N steps, and the end of the last.
    halves : int
        Into how many equal steps of the scheme each is divided.
    """

    times: FloatArray
    halves: int

    @property
    def count(self) -> int:
        """N + 1: the last step, which may be shorter, starts at the end of the others."""
        return self.times.shape[1]

    def lengths(self, first: int, end: int) -> FloatArray:
        """Lengths (K,) of the steps from there, s; 0 for one beyond the last."""
        hi, lo = self.times[:, first : end + 1]
        lengths = np.diff(hi) + np.diff(lo)
        return lengths if len(lengths) == end - first else np.append(lengths, 0.0)

    def place(self, t: FloatArray, low: FloatArray) -> tuple[IntArray, FloatArray]:
        """The steps in which epochs t + low lie, ascending in size, and the seconds from there."""
        place = np.searchsorted(np.abs(self.times[0]), np.abs(t + low), side="right") - 1
        return place, (t - self.times[0, place]) + (low - self.times[1, place])
