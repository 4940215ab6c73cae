"""Numbers kept as the unevaluated sum of two doubles, about 32 digits.

A pair (hi, lo) has |lo| <= ulp(hi)/2.  Error-free transforms: Dekker (1971), Knuth (1969); pair
arithmetic with its error bounds: Joldes, Muller & Popescu, ACM TOMS 44, article 15 (2017).
"""

from __future__ import annotations

import math

from attitude._compilation.decorators import subroutine
from attitude._compilation.instructions import fma

ZERO = (0.0, 0.0)
ONE = (1.0, 0.0)
HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
TWO_PI = (6.283185307179586, 2.4492935982947064e-16)


@subroutine
def quick_two_sum(a, b):
    """a + b exactly, for |a| >= |b|."""
    s = a + b
    return s, b - (s - a)


@subroutine
def two_sum(a, b):
    """a + b exactly."""
    s = a + b
    c = s - a
    return s, (a - (s - c)) + (b - c)


@subroutine
def two_prod(a, b):
    """a b exactly, unless it underflows."""
    p = a * b
    return p, fma(a, b, -p)


@subroutine
def pair(row):
    """The first two entries of an array as a pair."""
    return row[0], row[1]


@subroutine
def put(row, a):
    """A pair into the first two entries of an array."""
    row[0] = a[0]
    row[1] = a[1]


@subroutine
def neg(a):
    """-a."""
    return -a[0], -a[1]


@subroutine
def absolute(a):
    """|a|."""
    return neg(a) if a[0] < 0.0 else a


@subroutine
def add(a, b):
    """a + b; relative error 3 u^2 for any signs (AccurateDWPlusDW)."""
    s, e = two_sum(a[0], b[0])
    t, f = two_sum(a[1], b[1])
    s, e = quick_two_sum(s, e + t)
    return quick_two_sum(s, e + f)


@subroutine
def sub(a, b):
    """a - b; relative error 3 u^2 for any signs."""
    return add(a, neg(b))


@subroutine
def mul(a, b):
    """a b; relative error 6 u^2 (DWTimesDW2)."""
    p, e = two_prod(a[0], b[0])
    return quick_two_sum(p, e + fma(a[0], b[1], a[1] * b[0]))


@subroutine
def scale(a, x):
    """a x for a double x."""
    p, e = two_prod(a[0], x)
    return quick_two_sum(p, fma(a[1], x, e))


@subroutine
def square(a):
    """a a; relative error 6 u^2."""
    p, e = two_prod(a[0], a[0])
    return quick_two_sum(p, fma(2.0 * a[0], a[1], e))


@subroutine
def div(a, b):
    """a / b; relative error 15 u^2."""
    q = a[0] / b[0]
    p, e = two_prod(q, b[0])
    remainder = ((a[0] - p) - e) + fma(-q, b[1], a[1])
    return quick_two_sum(q, remainder / b[0])


@subroutine
def sqrt(a):
    """The square root of a >= 0."""
    if a[0] <= 0.0:
        return 0.0, 0.0
    r = math.sqrt(a[0])
    remainder = fma(-r, r, a[0]) + a[1]
    return quick_two_sum(r, remainder / (2.0 * r))


@subroutine
def less(a, b):
    """Whether a < b."""
    return a[0] < b[0] or (a[0] == b[0] and a[1] < b[1])


@subroutine
def same(a, b):
    """Whether a == b."""
    return a[0] == b[0] and a[1] == b[1]


# Exact sums of products, for D2, the one difference that decides the regime.  An expansion is a row
# of doubles, none overlapping another, smallest first, whose exact sum is the number (Shewchuk,
# Discrete & Computational Geometry 18, 305, 1997).


@subroutine
def added(row, n, x):
    """Add x exactly to the expansion row[:n]; returns the number of its parts afterwards."""
    kept = 0
    for i in range(n):
        x, e = two_sum(x, row[i])
        if e != 0.0:
            row[kept] = e
            kept += 1
    if x != 0.0:
        row[kept] = x
        kept += 1
    return kept


@subroutine
def product_added(row, n, w, x, y, z):
    """Add the product of four doubles (eight parts) exactly; returns the number of parts."""
    p, e = two_prod(w, x)
    for wx in (p, e):
        q, f = two_prod(wx, y)
        for wxy in (q, f):
            r, g = two_prod(wxy, z)
            n = added(row, n, g)
            n = added(row, n, r)
    return n


@subroutine
def rounded(row, n):
    """The expansion row[:n] as a pair, to 32 digits: no part cancels a larger one."""
    total = (0.0, 0.0)
    for i in range(n):
        total = add(total, (row[i], 0.0))
    return total
