"""The states of N members, as the compiled solution takes them, in ICRF."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import evaluation, frames, quaternion
from attitude.solution import codes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray

# The constants of so many members are computed together: they stay in the second-level cache.
BLOCK = 512


@dataclass(frozen=True, eq=False)
class Members:
    """States from which `evaluation.prepared` makes the constants of members.

    Attributes
    ----------
    moments : (1 or N, 3, 2) array
        Principal moments in pairs of doubles.
    principal : (1 or N, 4) array
        Unit quaternion from principal to body axes.
    rates : (N, 3) or (N, 3, 2) array
        rad/s over the principal axes; the low parts are zero where only the first doubles are kept.
    differences : (N, 3, 2) array or None
        See `Body.differences`; NaN for members without.
    wxyz, low : (N, 4) arrays
        Attitudes from body axes to ICRF; `low`, their second doubles, is None if all are zero.
    """

    moments: FloatArray
    principal: FloatArray
    rates: FloatArray
    differences: FloatArray | None
    wxyz: FloatArray
    low: FloatArray | None

    def __len__(self) -> int:
        """The number of members."""
        return self.wxyz.shape[0]

    def taken(self, index: Any) -> Members:
        """Some of the members."""
        one = len(self.moments) == 1
        return Members(
            self.moments if one else self.moments[index],
            self.principal if len(self.principal) == 1 else self.principal[index],
            self.rates[index],
            None if self.differences is None else self.differences[index],
            self.wxyz[index],
            None if self.low is None else self.low[index],
        )

    def states(self, which: slice | IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Moments (B, 3, 2), attitudes (B, 4) and rates (B, 3, 2) of some members."""
        wxyz, rates = self.wxyz[which], self.rates[which]
        moments = self.moments
        if len(moments) == 1:
            moments = np.broadcast_to(moments, (len(wxyz), 3, 2)).copy()
        else:
            moments = moments[which]
        if rates.ndim == 2:
            pairs = np.zeros((len(wxyz), 3, 2))
            pairs[..., 0] = rates
            rates = pairs
        return moments, wxyz, rates

    def prepared(
        self, which: slice | IntArray, *, rates: bool = True
    ) -> tuple[NDArray[Any], IntArray]:
        """The constants (B,) of some members, and which of them (K,) are not physical.

        Those are given constants that evaluate to NaN.
        """
        moments, wxyz, omega = self.states(which)
        principal = self.principal if len(self.principal) == 1 else self.principal[which]
        constants, faults = evaluation.prepared(
            moments,
            wxyz,
            omega,
            principal,
            differences=None if self.differences is None else self.differences[which],
            rates=rates,
            wxyz_low=None if self.low is None else self.low[which],
        )
        if not faults:
            return constants, _NONE
        bad = np.flatnonzero(constants["fault"])
        for name in ("frame", "rates", "psi_rate", "phi_rate"):
            constants[name][bad] = np.nan
        constants["form"][bad], constants["mode"][bad] = codes.UNIFORM, NO_MODE
        return constants, bad

    def faults(self) -> IntArray:
        """Numbers (K,) of the members that are not physical."""
        found = [_NONE]
        for first in range(0, len(self), BLOCK):
            moments, wxyz, rates = self.states(slice(first, first + BLOCK))
            bad = evaluation.faults_of(moments, wxyz, rates)
            if len(bad):
                found.append(bad + first)
        return np.concatenate(found)

    def fault(self, k: int) -> str:
        """The sentence on member k, which is not physical."""
        which = slice(k, k + 1)
        constants, _ = self.prepared(which)
        moments, wxyz, rates = self.states(which)
        return evaluation.fault_of(constants[0], moments[0], wxyz[0], rates[0])


# Members whose constants take 34 MB.
_MOST_KEPT = 35_000
# Mode of a member that is not physical.
NO_MODE = -1
_NONE: IntArray = np.zeros(0, dtype=np.int64)


class Kept:
    """Members whose constants are kept once prepared, if they are few; for several epochs.

    Parameters
    ----------
    members : Members
    first : int
        Number of the first one.
    """

    def __init__(self, members: Members, first: int = 0, constants: Any = None) -> None:
        self._members, self._first = members, first
        if constants is None and len(members) <= _MOST_KEPT:
            parts = [members.prepared(slice(k, k + BLOCK)) for k in range(0, len(members), BLOCK)]
            constants = [found for found, _ in parts]
            constants = np.concatenate(constants) if constants else members.prepared(slice(0))[0]
        self._constants = constants

    def taken(self, which: slice) -> Members | Kept:
        """Some of the members."""
        if self._constants is None:
            return self._members.taken(which)
        return Kept(self._members, which.start, self._constants)

    def prepared(self, which: slice, *, rates: bool = True) -> tuple[NDArray[Any], IntArray]:
        """As `Members.prepared`, without the numbers of those that are not physical."""
        part = slice(self._first + which.start, self._first + which.stop)
        return self._constants[part], _NONE


def joined(parts: Sequence[Members]) -> Members:
    """The members of several parts, one after the other."""
    counts = [len(part) for part in parts]

    def rows(arrays: Sequence[FloatArray]) -> FloatArray:
        first = arrays[0]
        if len(first) == 1 and all(each is first for each in arrays):
            return first
        given = zip(arrays, counts, strict=True)
        return np.concatenate([np.broadcast_to(a, (n, *a.shape[1:])) for a, n in given])

    rates = [part.rates for part in parts]
    if len({each.ndim for each in rates}) > 1:
        rates = [
            np.stack([each, np.zeros_like(each)], axis=-1) if each.ndim == 2 else each
            for each in rates
        ]
    differences = None
    if any(part.differences is not None for part in parts):
        unknown = [np.full((n, 3, 2), np.nan) for n in counts]
        both = zip((part.differences for part in parts), unknown, strict=True)
        differences = np.concatenate([b if a is None else a for a, b in both])
    return Members(
        rows([part.moments for part in parts]),
        rows([part.principal for part in parts]),
        np.concatenate(rates),
        differences,
        np.concatenate([part.wxyz for part in parts]),
        joined_rows([(part.low, part.wxyz) for part in parts]),
    )


def joined_rows(parts: Sequence[tuple[FloatArray | None, FloatArray]]) -> FloatArray | None:
    """Joined low parts, zero where a part has None; None if all are.  With arrays of the shapes."""
    if all(low is None for low, _ in parts):
        return None
    return np.concatenate([np.zeros_like(high) if low is None else low for low, high in parts])


def to_icrf(
    frame: str, wxyz: FloatArray, low: FloatArray | None
) -> tuple[FloatArray, FloatArray | None]:
    """Attitudes (N, 4) and their second doubles (or None) in ICRF, as `Spin` has them.

    Parameters
    ----------
    frame : str
    wxyz : (N, 4) array
        Quaternions to the frame, of unit length if `low` is given.
    low : (N, 4) array or None
    """
    if low is None:
        wxyz, low = quaternion.all_unit_in_pairs(wxyz)
    if frame == "icrf":
        return wxyz, low
    turned = quaternion.multiply(frames.wxyz_to_icrf(frame), wxyz)
    if low is None:
        return turned, None
    rounded = np.flatnonzero(low.any(axis=1))
    pairs = np.stack([wxyz[rounded], low[rounded]], axis=-1)
    found = frames.attitude_to_icrf(frame, pairs)
    second = np.zeros(wxyz.shape)
    turned[rounded], second[rounded] = found[..., 0], found[..., 1]
    return turned, second
