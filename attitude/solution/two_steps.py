"""One step of a splitting integrator of each of two motions, computed together.

The free motions of both are computed in SIMD vectors (`solution.two_flights`); torques are called
one after the other.
"""

from typing import Final

from attitude.compilation.decorators import force_inlined, subroutine
from attitude.compilation.simd import doubles_of, lanes, positive_bits
from attitude.solution import march_layout as layout
from attitude.solution.motion_state import kicked
from attitude.solution.step import gains
from attitude.solution.torqued_step import (
    FASTEST,
    accelerations_by,
    coefficient,
    gained_by,
    is_finite,
    is_short,
    rate_gained,
    set_input,
    torque_of,
)
from attitude.solution.two_flights import BOTH, advance_two

_ZERO = 0.0, 0.0, 0.0
# What the second motion is: none, one from the state of the first, or another.
ALONE: Final = 0
SAME_START: Final = 1
OTHER: Final = 2
# Besides how a march ended: the steps are to be taken one by one.
ONE_BY_ONE: Final = -1


@subroutine
def can_be_two(plan, torques):
    """Whether `two_steps` takes a scheme and torques."""
    _, _, rates, slips, _ = torques
    gradient = False
    for j in range(plan[1] + 1):
        gradient = gradient or coefficient(plan, layout.GRADIENTS, j) != 0.0
    return not (rates or slips or gradient)


@force_inlined
def two_steps(
    body, plan, torques, states, second, times, lengths, samples, row, work, held, pieces
):
    """The states after one step of each of two motions.

    second    ALONE (its state is then that of the first), SAME_START or OTHER
    times     (s at the start, at the end) of each, as in `torqued_step`
    lengths   s, of each
    samples   of each, the address of those of the first kick
    held      whether the acceleration at the start of the first by torques that are not LINEAR is
              known, and that
    pieces    squares of the longest pieces of free motions of both: `two_flights.advance_two`
    Returned
        both states; `held` for a step that follows the first; FINE, BAD_TORQUE or ONE_BY_ONE; and
        for BAD_TORQUE the seconds at which
    """
    last, linear = plan[1], torques[4]
    k, h, limit = gains(body[0]), lanes(lengths), body[4] * body[4]
    state, done = joined(states[0], states[1]), 0.0
    (known, one), longest = held, max(abs(lengths[0]), abs(lengths[1]))
    squares = lanes(pieces)
    for j in range(last + 1):
        part = coefficient(plan, layout.KICKS, j)
        known = known and j == 0
        if part != 0.0:
            if linear and not is_short(body, longest):
                return states, (False, one), ONE_BY_ONE, 0.0
            q, w = _at(state, 0)
            when = times[0][1] if j == last else times[0][0] + done * lengths[0]
            if not known:
                set_input(body, (q, w, q, w), work, 0.0, 0.0, 0.0)
                torque = torque_of(torques, when, samples[0] + j * row, work, False)
                if not is_finite(torque):
                    return states, (False, one), layout.BAD_TORQUE, when
                one = accelerations_by(body, torque)
            two = one
            if second == OTHER or (second == SAME_START and j > 0):
                when = times[1][1] if j == last else times[1][0] + done * lengths[1]
                q, w = _at(state, 1)
                set_input(body, (q, w, q, w), work, 0.0, 0.0, 0.0)
                torque = torque_of(torques, when, samples[1] + j * row, work, False)
                if not is_finite(torque):
                    return states, (False, one), layout.BAD_TORQUE, when
                two = accelerations_by(body, torque)
            both, size = _pair_of_three(one, two), abs(part) * longest
            if linear:
                both = gained_by(body[5], both, state[1])
            change = rate_gained(body, both, part * h, size, linear)
            state = kicked(state, change, _ZERO)
        if j < last:
            part = coefficient(plan, layout.FLIGHTS, j)
            flight, (w1, w2, w3) = part * h, state[1]
            speed = w1 * w1 + w2 * w2 + w3 * w3
            within = positive_bits(limit - flight * flight * speed) & positive_bits(FASTEST - speed)
            if within != BOTH:
                return states, (False, one), ONE_BY_ONE, 0.0
            state, fine = advance_two(body[0], k, flight, state, squares)
            if not fine:
                return states, (False, one), ONE_BY_ONE, 0.0
            done += part
    ends = coefficient(plan, layout.KICKS, last) != 0.0
    return apart(state), (ends, one), layout.FINE, 0.0


@subroutine
def _pair_of_three(a, b):
    """Two vectors as one, of a lane for each."""
    return lanes((a[0], b[0])), lanes((a[1], b[1])), lanes((a[2], b[2]))


@subroutine
def _pair_of_four(a, b):
    """Two quaternions as one, of a lane for each."""
    return lanes((a[0], b[0])), lanes((a[1], b[1])), lanes((a[2], b[2])), lanes((a[3], b[3]))


@subroutine
def joined(a, b):
    """Two states as one, of a lane for each."""
    return (
        _pair_of_four(a[0], b[0]),
        _pair_of_three(a[1], b[1]),
        _pair_of_four(a[2], b[2]),
        _pair_of_three(a[3], b[3]),
    )


@subroutine
def _three_of(a, k):
    """Lane k of a vector."""
    return doubles_of(a[0])[k], doubles_of(a[1])[k], doubles_of(a[2])[k]


@subroutine
def _four_of(a, k):
    """Lane k of a quaternion."""
    return doubles_of(a[0])[k], doubles_of(a[1])[k], doubles_of(a[2])[k], doubles_of(a[3])[k]


@subroutine
def _at(state, k):
    """The attitude and the angular velocity in lane k of a state."""
    return _four_of(state[0], k), _three_of(state[1], k)


@subroutine
def apart(state):
    """The states in both lanes."""
    q, w, q_low, w_low = state
    return (
        (_four_of(q, 0), _three_of(w, 0), _four_of(q_low, 0), _three_of(w_low, 0)),
        (_four_of(q, 1), _three_of(w, 1), _four_of(q_low, 1), _three_of(w_low, 1)),
    )
