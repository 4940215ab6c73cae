"""Principal axes of full inertia tensors, to 115 digits.

Beside the separatrix D2 is 1e-16 of its terms, or 1e-32 for a body that spins about its middle
axis, and 1e9 revolutions multiply its relative error by 1e9: moments and axes to 31 digits do not
suffice.  The doubles of a tensor are integers over a power of two, so Jacobi's rotations run in
integers of 448 bits (`solution.diagonal`); a tensor is diagonalised once, in 11 us.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.compilation.wide import BITS, WORDS, load, store, wide
from attitude.solution.diagonal import (
    COLUMNS,
    KEPT,
    NEEDED,
    VALUES,
    as_double,
    diagonalise,
    integer_of,
    largest_of,
    length_of,
    magnitude,
    product_of,
    put_pair,
    put_tensor,
    rounded,
    sort_axes,
)
from attitude.solution.diagonal_start import approach
from attitude.solution.vectors import quaternion_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray

# Asymmetry of a tensor, relative to its largest entry, that counts as rounding.
ASYMMETRY: float = 1e-13
# Rounding error of a moment that is zero, relative to the largest.
_ZERO_MOMENT = 1e-15


@subroutine
def _is_diagonal(t):
    return t[0, 1] == 0.0 and t[0, 2] == 0.0 and t[1, 2] == 0.0


@subroutine
def _given_axes(t, kept, moments, axes):
    """Fill the results of a diagonal tensor: its diagonal, in this order, about the body axes."""
    for k in range(KEPT):
        store(kept, k, wide(0))
    for k in range(3):
        moments[k, 0], moments[k, 1] = t[k, k], 0.0
        for i in range(3):
            axes[i, k, 0], axes[i, k, 1] = 1.0 if i == k else 0.0, 0.0


@subroutine
def _rod(kept, moments):
    """Set a least moment that is zero within rounding to 0, and the others to their mean."""
    if not -_ZERO_MOMENT * moments[2, 0] <= moments[0, 0] <= 0.0:
        return
    store(kept, VALUES, wide(0))
    for part in range(2):
        mean = 0.5 * (moments[1, part] + moments[2, part])
        moments[0, part], moments[1, part], moments[2, part] = 0.0, mean, mean


@sized_entry_point
def _principal_all(tensors, w, words, moments, axes, wxyz):
    """Fill the arrays of `PrincipalAxes` of tensors (B, 3, 3); w is memory for NEEDED numbers."""
    for b in range(len(tensors)):
        kept, t = words[b], tensors[b]
        if _is_diagonal(t):
            _given_axes(t, kept, moments[b], axes[b])
        else:
            size = largest_of(t[0, 0], t[1, 1], t[2, 2])
            exponent = math.frexp(max(size, largest_of(t[0, 1], t[0, 2], t[1, 2])))[1]
            put_tensor(t, exponent, w)
            approach(t, exponent, axes[b, :, :, 0], axes[b, :, :, 1], wxyz[b], w)
            diagonalise(w)
            sort_axes(w, kept)
            for k in range(3):
                put_pair(moments[b, k], load(kept, VALUES + k), exponent)
                for i in range(3):
                    put_pair(axes[b, i, k], load(kept, COLUMNS + 3 * k + i), 0)
            _rod(kept, moments[b])
        quaternion_of(axes[b, :, :, 0], wxyz[b])


@sized_entry_point
def _over_axes_all(words, omega, rates, differences):
    """Fill the results of `PrincipalAxes.over_axes`."""
    for n in range(len(omega)):
        w = words[n if len(words) > 1 else 0]
        x, y, z = omega[n, 0], omega[n, 1], omega[n, 2]
        largest = largest_of(x, y, z)
        given = length_of(load(w, COLUMNS)) + length_of(load(w, COLUMNS + 1)) == 0
        given = given and length_of(load(w, COLUMNS + 2)) == 0
        if given or not largest < math.inf:
            for k in range(3):
                rates[n, k, 0], rates[n, k, 1] = omega[n, k], 0.0
                differences[n, k, 0] = differences[n, k, 1] = math.nan
        else:
            exponent = math.frexp(largest)[1]
            p, q, r = (
                integer_of(x, exponent),
                integer_of(y, exponent),
                integer_of(z, exponent),
            )
            _resolve(w, p, q, r, exponent, rates[n], differences[n])


@subroutine
def _resolve(w, x, y, z, exponent, rates, differences):
    """Fill the results of one body: x, y, z is its angular velocity over 2**exponent."""
    tempo = 0.0
    first = along = wide(0)
    for k in range(3):
        i = COLUMNS + 3 * k
        total = product_of(load(w, i), x) + product_of(load(w, i + 1), y)
        along = rounded(total + product_of(load(w, i + 2), z))
        put_pair(rates[k], along, exponent)
        tempo = max(tempo, abs(as_double(along)))
        if k == 0:
            first = along
    if length_of(load(w, VALUES)) == 0:
        for k in range(3):
            differences[k, 0] = differences[k, 1] = math.nan
    else:
        _put_differences(w, first, along, math.frexp(tempo)[1] - BITS, differences)


@subroutine
def _put_differences(w, x, z, tempo, out):
    """Fill the differences of one body: x and z are the rates about the outer axes."""
    a, b, c = load(w, VALUES), load(w, VALUES + 1), load(w, VALUES + 2)
    inertia = math.frexp(as_double(c))[1] - BITS
    x, z = magnitude(x), magnitude(z)
    of_greatest = product_of(product_of(c, c - b), product_of(z, z))
    of_least = product_of(product_of(a, b - a), product_of(x, x))
    put_pair(out[0], b - a, -inertia)
    put_pair(out[1], c - b, -inertia)
    put_pair(out[2], of_greatest - of_least, -2 * (inertia + tempo))


class PrincipalAxes(NamedTuple):
    """Principal moments and axes of B symmetric tensors, whose doubles are taken as exact.

    Attributes
    ----------
    words : (B, 7 KEPT) array
        The moments and the axes to 115 digits, integers of `compilation.wide`.
    moments : (B, 3, 2) array
        Pairs of doubles in the unit of the tensors: ascending, of a diagonal tensor its diagonal.
        A least moment that is zero within rounding is 0; the body is then a rod.
    axes : (B, 3, 3, 2) array
        Pairs of doubles: unit columns over the body axes, right-handed.  The largest component of
        each is positive, except where that would make the third left-handed.
    wxyz : (B, 4) array
        Unit quaternions from the principal axes to the body axes, w >= 0.
    """

    words: NDArray[np.int64]
    moments: FloatArray
    axes: FloatArray
    wxyz: FloatArray

    @classmethod
    def of(cls, tensors: FloatArray) -> PrincipalAxes:
        """Those of tensors (B, 3, 3), symmetric and finite."""
        count = len(tensors)
        found = cls(
            np.empty((count, WORDS * KEPT), dtype=np.int64),
            np.empty((count, 3, 2)),
            np.empty((count, 3, 3, 2)),
            np.empty((count, 4)),
        )
        _principal_all(tensors, np.empty(WORDS * NEEDED, dtype=np.int64), *found)
        return found

    def over_axes(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angular velocities over the principal axes, and differences beside them.

        Parameters
        ----------
        omega : (N, 3) array
            rad/s over the body axes; N is B, or any number for one tensor.

        Returns
        -------
        rates : (N, 3, 2) array
            rad/s over the principal axes, pairs of doubles; not finite where omega is not.
        differences : (N, 3, 2) array
            Pairs that those of moments and rates have to fewer digits: B - A, C - B and D2 = L^2 -
            2 E B for moments A <= B <= C, moments and rates divided by the powers of two that bring
            the largest of each into [1/2, 1).  NaN for diagonal tensors and rods, where nothing is
            lost.
        """
        rates, differences = np.empty((len(omega), 3, 2)), np.empty((len(omega), 3, 2))
        _over_axes_all(self.words, omega, rates, differences)
        return rates, differences
