"""The epochs of a call: a grid of members and epochs, or rows each of one member."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import propagation
from attitude.errors import AttitudeError
from attitude.immutable import read_only

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray


class MemberGrid:
    """All of N members at T epochs.

    Parameters
    ----------
    count : int
        N.
    t, t_low : (1 or N, T) arrays
        Seconds t + t_low since the epoch of the member; t_low may be None.
    scalar : bool
        Whether one epoch was given, so that the answers have no axis of epochs.

    Attributes
    ----------
    shape : tuple
        S: (N, T), or (N,) for one epoch.
    member : (S) array of int
    seconds, low : (S) arrays
    """

    def __init__(self, count: int, t: FloatArray, t_low: FloatArray | None, scalar: bool) -> None:
        self.count, self.scalar = count, scalar
        # Epochs that all members share are few: a copy does not change with the caller's array.
        few = len(t) == 1 and t.size < 1 << 20
        self.t = t.copy() if few else np.ascontiguousarray(t)
        self.t_low = None if t_low is None else np.ascontiguousarray(t_low)
        self.shape: tuple[int, ...] = (count,) if scalar else (count, t.shape[1])
        numbers = np.arange(count)
        self.member = self._over_epochs(numbers[:, None])
        self.seconds = self._over_epochs(self.t)
        self.low = None if self.t_low is None else self._over_epochs(self.t_low)

    def _over_epochs(self, array):
        found = np.broadcast_to(array, (self.count, self.t.shape[1]))
        return found[:, 0] if self.scalar else found

    def layout(self, width: int) -> tuple[tuple[int, ...], tuple[int, ...], bool]:
        """The last arguments of `propagation.result_memory`."""
        return (self.count, self.t.shape[1]), (width,), self.scalar

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (N, W, T) as (S, W), in `out` if it is given."""
        return propagation.result(memory, out, self.scalar, 1)


class MemberRows:
    """MemberRows of one epoch of one member each.

    Parameters
    ----------
    member : (S) array of int
    seconds, low : (S) arrays
        Seconds + low since the epoch of the member; low may be None.
    """

    def __init__(self, member: IntArray, seconds: FloatArray, low: FloatArray | None) -> None:
        self.member = member
        self.seconds = read_only(seconds)
        self.low = None if low is None else read_only(low)
        self.shape: tuple[int, ...] = seconds.shape

    def flat(self) -> tuple[IntArray, FloatArray, FloatArray | None]:
        """Members, seconds and their second doubles as arrays (R,)."""
        low = None if self.low is None else np.ascontiguousarray(self.low).reshape(-1)
        member = np.ascontiguousarray(self.member).reshape(-1)
        return member, np.ascontiguousarray(self.seconds).reshape(-1), low

    def layout(self, width: int) -> tuple[tuple[int, ...], tuple[int, ...], bool]:
        """The last arguments of `propagation.result_memory`."""
        return (self.seconds.size,), (width,), False

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (W, R) as (S, W), in `out` if it is given."""
        if out is not None:
            if len(self.shape) != 1:
                raise AttitudeError(
                    f"out is given for rows of shape {self.shape}; give rows (R,) with out=."
                )
            return propagation.result(memory, out, False, 0)
        return np.moveaxis(memory.reshape(len(memory), *self.shape), 0, -1)
