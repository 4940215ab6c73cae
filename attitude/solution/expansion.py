"""Exact sums of products, for the one difference that decides the regime.

An expansion is a row of doubles, none overlapping another, smallest first, whose exact sum is the
number (Shewchuk, Discrete & Computational Geometry 18, 305, 1997).
"""

from attitude.solution.machine import inlined
from attitude.solution.twofloat import add, two_prod, two_sum


@inlined
def added(row, n, x):
    """Add x exactly to the expansion row[:n]; the number of its parts afterwards."""
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


@inlined
def product_added(row, n, w, x, y, z):
    """Add the product of four doubles exactly, which has eight parts."""
    p, e = two_prod(w, x)
    for wx in (p, e):
        q, f = two_prod(wx, y)
        for wxy in (q, f):
            r, g = two_prod(wxy, z)
            n = added(row, n, g)
            n = added(row, n, r)
    return n


@inlined
def rounded(row, n):
    """The expansion as a pair of doubles, to 32 digits: no part cancels a larger one."""
    total = (0.0, 0.0)
    for i in range(n):
        total = add(total, (row[i], 0.0))
    return total
