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
def times(row, n, pair, out):
    """The exact product of the expansion row[:n] and a pair, in out; the number of its parts."""
    count = 0
    for i in range(n):
        for x in pair:
            p, e = two_prod(row[i], x)
            count = added(out, count, e)
            count = added(out, count, p)
    return count


@inlined
def rounded(row, n):
    """The expansion as a pair of doubles, to 32 digits: no part cancels a larger one."""
    total = (0.0, 0.0)
    for i in range(n):
        total = add(total, (row[i], 0.0))
    return total
