"""The state of an integration: attitude and angular velocity as compensated sums.

A state is a tuple of wxyz (4), the angular velocity (3), and the lower halves of both (4), (3),
which the rounded sums leave out.  Its numbers are doubles, or SIMD vectors of a lane for each body.
"""

from attitude.compilation.decorators import force_inlined, subroutine
from attitude.compilation.instructions import fma
from attitude.solution.given_axes import product
from attitude.solution.twofloat import quick_two_sum, two_sum


@subroutine
def loaded(row):
    """A state from a row of 14: wxyz and angular velocity, then their lower halves."""
    return (
        (row[0], row[1], row[2], row[3]),
        (row[4], row[5], row[6]),
        (row[7], row[8], row[9], row[10]),
        (row[11], row[12], row[13]),
    )


@subroutine
def stored(state, row):
    """A state into a row of 14: the inverse of `loaded`."""
    q, w, q_low, w_low = state
    for n in range(4):
        row[n], row[7 + n] = q[n], q_low[n]
    for n in range(3):
        row[4 + n], row[11 + n] = w[n], w_low[n]


@force_inlined
def moved_by(state, by):
    """A state plus an increment."""
    q, _, low, _ = state
    turn, change, n, rest = by
    # n is nearly the same from step to step: it goes into the lower half, which turns with q.
    return kicked(turned(state, product(q, turn), n, product(low, turn)), change, rest)


@subroutine
def turned(state, change, n, rest):
    """A state whose quaternion is changed by (change + rest), then multiplied by 1 + n."""
    q, w, low, w_low = state
    a, e = _add(q[0], low[0], change[0])
    b, f = _add(q[1], low[1], change[1])
    c, g = _add(q[2], low[2], change[2])
    d, h = _add(q[3], low[3], change[3])
    low = (
        fma(n, a, e + rest[0]),
        fma(n, b, f + rest[1]),
        fma(n, c, g + rest[2]),
        fma(n, d, h + rest[3]),
    )
    return (a, b, c, d), w, low, w_low


@subroutine
def kicked(state, change, rest):
    """A state whose angular velocity is changed by (change + rest)."""
    q, w, q_low, low = state
    a, d = _add(w[0], low[0], change[0])
    b, e = _add(w[1], low[1], change[1])
    c, f = _add(w[2], low[2], change[2])
    return q, (a, b, c), q_low, (d + rest[0], e + rest[1], f + rest[2])


@subroutine
def _add(x, low, change):
    """x + low + change as a sum and its error: compensated summation.

    The error is exact if |change| >= |low|, else right to a rounding of the change.
    """
    change, lost = quick_two_sum(change, low)
    x, left = two_sum(x, change)
    return x, left + lost
