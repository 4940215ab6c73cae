"""Principal axes of a full inertia tensor in Python's integers, for `test_principal.py`.

Beside the separatrix D2 is 1e-16 of its terms, or 1e-32 for a body that spins about its middle
axis, and 1e9 revolutions multiply its relative error by 1e9: moments and axes to 31 digits do not
suffice.  The doubles of a tensor are integers over a power of two, so Jacobi's rotations (Golub &
Van Loan, Matrix Computations, section 8.5) run here in integers; a body is diagonalised once, in a
quarter of a millisecond.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude._support.annotations import FloatArray

# Numbers are n / 2**_BITS; results are rounded to _KEPT bits: equal moments are then equal numbers.
_BITS = 448
_KEPT = 384
_HALF = 1 << (_BITS - 1)
_ONE = 1 << _BITS
# Off-diagonal elements below this change no bit that is kept.
_NEGLIGIBLE = 1 << (_BITS - _KEPT - 40)
_SWEEPS = 30


class PrincipalAxes(NamedTuple):
    """Eigenvalues and eigenvectors of one symmetric tensor, integers over 2**448.

    Attributes
    ----------
    exponent : int
        The moments are divided by 2**exponent.
    values : tuple of int
        The moments, ascending.
    columns : tuple of tuples of int
        Unit vectors over the body axes, the columns of a right-handed matrix; the largest
        component of each is positive, except where that would make the third left-handed.
    """

    exponent: int
    values: tuple[int, ...]
    columns: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, tensor: FloatArray) -> PrincipalAxes:
        """The principal axes of a tensor (3, 3) whose doubles are taken as exact."""
        exponent = _exponent_of(tensor.ravel())
        a = [[_as_integer(float(x), exponent) for x in row] for row in tensor]
        v = [[_ONE if i == j else 0 for j in range(3)] for i in range(3)]
        _diagonalise(a, v)
        values = [_rounded(a[k][k]) for k in range(3)]
        order = sorted(range(3), key=values.__getitem__)
        columns = _right_handed([[_rounded(row[k]) for row in v] for k in order])
        return cls(exponent, tuple(values[k] for k in order), columns)

    def moments(self) -> FloatArray:
        """Principal moments (3, 2), ascending, pairs of doubles in the unit of the tensor."""
        return np.array([_pair(n, self.exponent) for n in self.values])

    def axes(self) -> FloatArray:
        """The matrix (3, 3, 2), pairs of doubles, from principal to body axes: unit columns."""
        pairs = np.array([[_pair(x, 0) for x in column] for column in self.columns])
        return np.ascontiguousarray(np.swapaxes(pairs, 0, 1))

    def rates(self, omega: FloatArray) -> FloatArray:
        """Components (3, 2), pairs of doubles, over the principal axes of a vector (3,)."""
        exponent = _exponent_of(omega)
        return np.array([_pair(n, exponent) for n in self._components(omega, exponent)])

    def differences(self, omega: FloatArray) -> FloatArray:
        """Differences that the pairs of `moments` and `rates` have to fewer digits.

        Returns
        -------
        (3, 2) array
            Pairs: B - A, C - B and D2 = L^2 - 2 E B for moments A <= B <= C at the angular velocity
            omega (3,), moments and rates divided by the powers of two that bring the largest of
            each into [1/2, 1).
        """
        least, middle, greatest = self.values
        x, y, z = (abs(n) for n in self._components(omega, _exponent_of(omega)))
        of_greatest = _times(_times(greatest, greatest - middle), _times(z, z))
        of_least = _times(_times(least, middle - least), _times(x, x))
        inertia = _exponent_of([_pair(greatest, 0)[0]])
        tempo = _exponent_of([_pair(n, 0)[0] for n in (x, y, z)])
        return np.array(
            [
                _pair(middle - least, -inertia),
                _pair(greatest - middle, -inertia),
                _pair(of_greatest - of_least, -2 * (inertia + tempo)),
            ]
        )

    def _components(self, omega: FloatArray, exponent: int) -> list[int]:
        """Components of a vector, over 2**exponent, over the principal axes."""
        w = [_as_integer(float(x), exponent) for x in omega]
        return [_rounded(sum(map(_times, column, w))) for column in self.columns]


def _diagonalise(a: list[list[int]], v: list[list[int]]) -> None:
    """Turn the columns of v until a, in these axes, is diagonal."""
    for _ in range(_SWEEPS):
        busy = False
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p][q]) > _NEGLIGIBLE:
                _rotate(a, v, p, q)
                busy = True
        if not busy:
            return


def _rotate(a: list[list[int]], v: list[list[int]], p: int, q: int) -> None:
    """Turn axes p and q so that a[p][q] vanishes."""
    off = a[p][q]
    ratio = ((a[q][q] - a[p][p]) << (_BITS - 1)) // off
    tangent = (_ONE << _BITS) // (abs(ratio) + math.isqrt(ratio * ratio + (_ONE << _BITS)))
    if ratio < 0:
        tangent = -tangent
    cosine = (_ONE << _BITS) // math.isqrt(tangent * tangent + (_ONE << _BITS))
    sine = _times(tangent, cosine)
    change = _times(tangent, off)
    a[p][p] -= change
    a[q][q] += change
    a[p][q] = a[q][p] = 0
    r = 3 - p - q
    x, y = a[r][p], a[r][q]
    a[r][p] = a[p][r] = _times(cosine, x) - _times(sine, y)
    a[r][q] = a[q][r] = _times(sine, x) + _times(cosine, y)
    for row in v:
        x, y = row[p], row[q]
        row[p] = _times(cosine, x) - _times(sine, y)
        row[q] = _times(sine, x) + _times(cosine, y)


def _right_handed(columns: list[list[int]]) -> tuple[tuple[int, ...], ...]:
    """Eigenvectors with positive largest components, the third reversed if left-handed."""
    for column in columns:
        if max(column, key=abs) < 0:
            column[:] = [-x for x in column]
    (a, b, c), (d, e, f), (g, h, i) = columns
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0:
        columns[2] = [-x for x in columns[2]]
    return tuple(map(tuple, columns))


def _exponent_of(values: Iterable[float]) -> int:
    """The exponent of 2 that brings the largest magnitude into [1/2, 1)."""
    return math.frexp(max(abs(float(x)) for x in values))[1]


def _as_integer(x: float, exponent: int) -> int:
    """x / 2**exponent as an integer over 2**_BITS."""
    part, power = math.frexp(x)
    shift = power - exponent + _BITS - 53
    whole = int(part * 2.0**53)
    return whole << shift if shift >= 0 else (whole + (1 << (-shift - 1))) >> -shift


def _times(a: int, b: int) -> int:
    """The product, rounded to 2**-_BITS."""
    return (a * b + _HALF) >> _BITS


def _rounded(n: int) -> int:
    """n rounded to _KEPT bits after the binary point."""
    spare = _BITS - _KEPT
    return ((n + (1 << (spare - 1))) >> spare) << spare


def _pair(n: int, exponent: int) -> tuple[float, float]:
    """n / 2**_BITS times 2**exponent as the sum of two doubles."""
    high = float(n)
    low = float(n - int(high))
    return math.ldexp(high, exponent - _BITS), math.ldexp(low, exponent - _BITS)
