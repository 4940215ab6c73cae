"""The exact free rotation of two bodies over short times, computed together.

Formulas of `solution.step` in SIMD vectors of two lanes: two bodies in the time of one.
"""

import math
from typing import Final

from attitude.compilation.decorators import force_inlined, subroutine
from attitude.compilation.simd import chosen, doubles_of, lanes, positive_bits, root
from attitude.solution.motion_state import moved_by
from attitude.solution.phases import sincos_of_eighth
from attitude.solution.step import (
    NO_MOMENTUM,
    linear_turns,
    momentum_of,
    rates,
    speed_of,
    turn_and_change,
)

# The square of an eighth of a turn, and the bits of two lanes.
_EIGHTH: Final = 0.015625
BOTH: Final = 3
# More pieces than a right angle has for any body.
_MOST: Final = 1e6


@force_inlined
def advance_two(moments, k, h, state, squares):
    """Free motions of two bodies of the same moments.

    Given
        h, state   as in `step.advance`; SIMD vectors, of a lane for each body
        squares    of the longest pieces of both (see `step.LONGEST_PIECE`)
    Returned
        the state, and whether it is right: not for bodies at rest, and turns by more than a right
        angle
    """
    rate = rates(k, state[1])
    size, speed = speed_of(state[1], rate)
    part, left, count, uneven = h, h, 1.0, False
    if positive_bits(squares * size - speed * (h * h)) != BOTH:
        one, two = doubles_of(root(h * h * speed / (squares * size)))
        one, two = _pieces(one), _pieces(two)
        left, count, uneven = lanes((one, two)), max(one, two), one != two
        part = h / left
    while True:
        momentum, square = momentum_of(moments, state[1])
        over = 1.0 / root(square)
        energy, turns = linear_turns(momentum, state[1], part, over)
        linear = over, energy, sincos_of_eighth(turns)
        by = turn_and_change(moments, state[1], rate, part, momentum, square, linear)
        moved = moved_by(state, by)
        fine = positive_bits(square - NO_MOMENTUM) & positive_bits(_EIGHTH - turns * turns)
        if uneven:  # the body of fewer pieces keeps its state
            moved, left = _where(left, moved, state), left - 1.0
        count -= 1.0
        if fine != BOTH or not count > 0.0:
            return moved, fine == BOTH
        state, rate = moved, rates(k, moved[1])


@subroutine
def _pieces(length):
    """The number of pieces of a flight, by its length in longest pieces; one for NaN."""
    return max(1.0, 1.0 * math.ceil(length)) if length < _MOST else 1.0


@subroutine
def _where(left, one, two):
    """The lanes of a state where those of `left` are above zero, else those of another."""
    q, w, q_low, w_low = one
    p, v, p_low, v_low = two
    return (
        _four_where(left, q, p),
        _three_where(left, w, v),
        _four_where(left, q_low, p_low),
        _three_where(left, w_low, v_low),
    )


@subroutine
def _three_where(left, a, b):
    """`chosen` of vectors."""
    return chosen(left, a[0], b[0]), chosen(left, a[1], b[1]), chosen(left, a[2], b[2])


@subroutine
def _four_where(left, a, b):
    """`chosen` of quaternions."""
    one, two = chosen(left, a[0], b[0]), chosen(left, a[1], b[1])
    return one, two, chosen(left, a[2], b[2]), chosen(left, a[3], b[3])
