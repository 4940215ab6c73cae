"""Loops of splitting integrators with steps as long as an error estimate allows.

Each step is taken whole and in two halves from one state, the whole one together with the first
half (`two_steps`).  The state after the halves goes on; the difference of both, divided by 2^p - 1
for a scheme of order p, is its error.  A step is kept as long as its error is within the tolerance
and no much longer one would be: between changes the samples of paths can be computed in advance.

A second motion may go along that takes all steps whole.  Steps of both follow the same mesh, once
halved, so the difference of the motions bounds the error of the first at any later time wherever
halving the steps halves the error: with all that the motion made of the errors of earlier steps.
"""

from __future__ import annotations

import math
from typing import Final

from attitude._compilation.decorators import entry_point, force_inlined, subroutine
from attitude._compilation.pointers import scratch
from attitude._compilation.simd import doubles_of, lanes, positive_bits
from attitude._solver import march_layout as layout
from attitude._solver.step import BOTH, advance_two, gains, kicked, loaded, put_motion, stored
from attitude._solver.torqued_step import (
    FASTEST,
    accelerations_by,
    body_of,
    coefficient,
    gained_by,
    is_finite,
    is_short,
    rate_gained,
    set_input,
    torque_of,
    torqued_step,
    torques_of,
)

# ---- One step of a splitting integrator of each of two motions, computed together
# The free motions of both are computed in SIMD vectors (`step.advance_two`); torques are called one
# after the other.

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
    pieces    squares of the longest pieces of free motions of both: `step.advance_two`
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
        fraction = coefficient(plan, layout.KICKS, j)
        known = known and j == 0
        if fraction != 0.0:
            if linear and not is_short(body, longest):
                return states, (False, one), ONE_BY_ONE, 0.0
            if not known:
                when = times[0][1] if j == last else times[0][0] + done * lengths[0]
                one, well = _accelerated(body, torques, state, 0, when, samples[0] + j * row, work)
                if not well:
                    return states, (False, one), layout.BAD_TORQUE, when
            two = one
            if second == OTHER or (second == SAME_START and j > 0):
                when = times[1][1] if j == last else times[1][0] + done * lengths[1]
                two, well = _accelerated(body, torques, state, 1, when, samples[1] + j * row, work)
                if not well:
                    return states, (False, one), layout.BAD_TORQUE, when
            both, size = _pair_of_three(one, two), abs(fraction) * longest
            if linear:
                both = gained_by(body[5], both, state[1])
            change = rate_gained(body, both, fraction * h, size, linear)
            state = kicked(state, change, _ZERO)
        if j < last:
            fraction = coefficient(plan, layout.FLIGHTS, j)
            flight, (w1, w2, w3) = fraction * h, state[1]
            speed = w1 * w1 + w2 * w2 + w3 * w3
            within = positive_bits(limit - flight * flight * speed) & positive_bits(FASTEST - speed)
            if within != BOTH:
                return states, (False, one), ONE_BY_ONE, 0.0
            state, fine = advance_two(body[0], k, flight, state, squares)
            if not fine:
                return states, (False, one), ONE_BY_ONE, 0.0
            done += fraction
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
def _accelerated(body, torques, state, k, when, samples, work):
    """The acceleration in lane k of a state by torques that are not LINEAR; whether finite."""
    q, w = _four_of(state[0], k), _three_of(state[1], k)
    set_input(body, (q, w, q, w), work, 0.0, 0.0, 0.0)
    torque = torque_of(torques, when, samples, work, False)
    return accelerations_by(body, torque), is_finite(torque)


@subroutine
def apart(state):
    """The states in both lanes."""
    q, w, q_low, w_low = state
    return (
        (_four_of(q, 0), _three_of(w, 0), _four_of(q_low, 0), _three_of(w_low, 0)),
        (_four_of(q, 1), _three_of(w, 1), _four_of(q_low, 1), _three_of(w_low, 1)),
    )


# Share of the step that the estimate allows, and limits of a change.
_SAFETY: Final = 0.9
_SHRINK: Final = 0.2
_GROW: Final = 4.0
# A step grows if it may by this factor at least.
_WORTH_GROWING: Final = 1.5
# Before the step is long enough for its asymptotic order, estimates are too small by a factor of up
# to 2.6 (blanes-moan under gravity gradient); they are multiplied by this.
_MARGIN: Final = 3.0
_MOST_REFUSALS: Final = 60
# Errors of steps over the power p + 1 of their length change by less than this factor from step to
# step where the torque is smooth; a larger one shows a kink or a jump.
_UNUSUAL: Final = 30.0
# Below this share of the tolerance it is not looked for; below this error it is rounding.
_NEGLIGIBLE: Final = 1e-3
_ROUNDED: Final = 1e-17
# The first steps, whose length is a guess, show no order.
_GUESSED: Final = 8
# What `two_steps` knows of the torque at the start of a step.
_UNKNOWN: Final = False, (0.0, 0.0, 0.0)


@entry_point
def adapt(c, scheme, models, clock, counts, fine, coarse, order, most, at_kicks, kept, every):
    """Try up to `most` steps, until the seconds clock[UNTIL] are reached; as `march`, or TOO_ROUGH.

    Given
        c, scheme, models   as in `march`
        order    of the scheme
        at_kicks (steps, 3 n + 2, columns) samples at the kicks of whole and halved steps of the
                 length clock[LENGTH], at a change of which the loop ends; of no steps if no torque
                 takes samples
        every    a state is kept after each so many steps since the epoch
    Changed
        clock, counts   `march_layout`
        fine     (14,) the state
        coarse   (14,) that of the motion with whole steps, or (0,)
    Filled
        kept     (K, 16); the loop ends when it is full
    """
    n = scheme.shape[1] - 1
    work, row = scratch(), layout.ENTRY_BYTES * at_kicks.shape[2]
    rows, stride = at_kicks.shape[0], (3 * n + 2) * row
    body, plan, torques = body_of(c), (scheme.ctypes.data, n), torques_of(models)
    paired, held = len(coarse) > 0, _UNKNOWN
    pieces = _longest_pieces(clock, plan, torques)
    state = loaded(fine)
    beside = loaded(coarse) if paired else state
    t, length = clock[layout.TIME], clock[layout.LENGTH]
    scale = _MARGIN / (2.0**order - 1.0)
    fault, when, turn = layout.FINE, 0.0, 0.0
    taken = filled = tried = 0
    while tried < most and filled < len(kept) and abs(t) < abs(clock[layout.UNTIL]):
        before, longest = length, _longest(clock[layout.TURN_LIMIT], state[1])
        if abs(length) > longest:
            length = math.copysign(_SAFETY * longest, length)
        if rows > 0 and (taken == rows or length != before):
            break
        end = _ended(t, length, clock[layout.LAST])
        middle, h = t + 0.5 * (end - t), end - t
        if not abs(t) < abs(middle) < abs(end):
            fault, when = layout.TOO_ROUGH, t
            break
        tried += 1
        times, sampled = (t, middle, end), (at_kicks.ctypes.data + taken * stride, row, work)
        whole, other, halves, fault, when, turn, ahead = _tried(
            body, plan, torques, times, state, beside, paired, sampled, held, pieces
        )
        if fault == layout.BAD_TORQUE:
            break
        error = math.inf if fault != layout.FINE else scale * _difference(state, whole, halves)
        fault = layout.FINE
        # a step that ends at the last epoch is no reason to change the length of others
        cut = abs(t + length) > clock[layout.LAST]
        longest = abs(length) if cut else _SAFETY * _longest(clock[layout.TURN_LIMIT], halves[1])
        length, accepted = _judged(clock, counts, error, h, length, order, longest)
        if accepted:
            _watch(clock, counts, error, h, order, halves[1])
            t, state, beside = end, halves, other
            # samples of the end of a step and of the start of the next may differ by a rounding
            held = ahead if rows == 0 else _UNKNOWN
            taken += 1
            if paired:
                clock[layout.APART] = max(clock[layout.APART], _angle(state, beside))
            if counts[layout.TAKEN] % every == 0:
                kept[filled, layout.KEPT_TIME], kept[filled, layout.KEPT_LENGTH] = t, length
                stored(state, kept[filled, 2:])
                filled += 1
        elif counts[layout.REFUSALS] > _MOST_REFUSALS:
            fault, when = layout.TOO_ROUGH, t
            break
        if (rows > 0 and length != before) or (paired and estimated(clock) > clock[layout.LIMIT]):
            break
    clock[layout.TIME], clock[layout.LENGTH] = t, length
    counts[layout.KEPT], counts[layout.TRIED] = filled, tried
    stored(state, fine)
    if paired:
        stored(beside, coarse)
    return fault, when, turn


@subroutine
def _longest_pieces(clock, plan, torques):
    """The squares of the longest pieces of free motions for `two_steps`; zeros if it cannot be."""
    if not can_be_two(plan, torques):
        return 0.0, 0.0
    return clock[layout.FINE_PIECE] ** 2, clock[layout.WHOLE_PIECE] ** 2


@subroutine
def _tried(body, plan, torques, times, state, beside, paired, addresses, held, pieces):
    """A step whole, that of the motion beside it, and in two halves; then as `torqued_step`.

    times      s at its start, middle and end
    addresses      address of its samples, bytes of a row of them, and address of the scratch memory
    held       as in `two_steps`, which is returned for the next step
    pieces     of `_longest_pieces`
    """
    n = plan[1]
    t, middle, end = times
    first, row, work = addresses
    if pieces[0] > 0.0:
        half, h, two = 0.5 * (end - t), end - t, (state, state)
        known, whole, outcome, when = held, state, ONE_BY_ONE, 0.0
        for run in range(2):  # one call, compiled once
            begin, stop, samples, second = t, middle, n + 1, SAME_START
            if run == 1:
                whole = two[1]
                two = two[0], beside if paired else two[0]
                begin, stop, samples, second = middle, end, 2 * n + 1, OTHER if paired else ALONE
            two, known, outcome, when = two_steps(
                body,
                plan,
                torques,
                two,
                second,
                ((begin, stop), (t, end)),
                (half, h),
                (first + samples * row, first),
                row,
                work,
                known,
                pieces,
            )
            if outcome != layout.FINE:
                break
        if outcome != ONE_BY_ONE:
            return whole, two[1], two[0], outcome, when, 0.0, known
    now = whole = other = state
    fault, when, turn = layout.FINE, 0.0, 0.0
    for run in range(4):  # one call, compiled once
        if run == 1 and not paired:
            continue
        begin, stop, h, samples = t, end, end - t, 0
        if run == 1:
            now = beside
        elif run == 2:
            now, stop, h, samples = state, middle, 0.5 * (end - t), n + 1
        elif run == 3:
            begin, h, samples = middle, 0.5 * (end - t), 2 * n + 1
        now, fault, when, turn = torqued_step(
            body, plan, torques, now, begin, stop, h, first + samples * row, row, work, run == 3
        )
        if fault != layout.FINE:
            break
        if run == 0:
            whole = now
        elif run == 1:
            other = now
    return whole, other, now, fault, when, turn, _UNKNOWN


@subroutine
def _judged(clock, counts, error, h, length, order, longest):
    """Length of the next step, up to `longest`, s, and whether one of h s and error is accepted."""
    tolerance = clock[layout.TOLERANCE]
    accepted = error <= tolerance
    if accepted:
        counts[layout.REFUSALS] = 0
        counts[layout.TAKEN] += 1
    if accepted and tolerance < _same(order) * error and abs(h) <= abs(length):
        return length, True
    ratio = math.pow(tolerance / max(error, 1e-300), 1.0 / (order + 1.0))
    factor = min(max(_SAFETY * ratio, _SHRINK), _GROW)
    if not accepted:
        counts[layout.REFUSALS] += 1
        # an error of NaN has no factor
        return (h * factor if factor < 1.0 else h * _SHRINK), False
    longer = min(abs(h) * factor, longest)
    if longer > _WORTH_GROWING * abs(length):
        length = math.copysign(longer, h)
    return length, True


@subroutine
def _same(order):
    """Below this multiple of the error the tolerance allows no step that is worth growing to."""
    return (_WORTH_GROWING / _SAFETY) ** (order + 1)


@entry_point
def between(c, scheme, models, states, times, place, parts, within, out):
    """States between adaptive steps, by two halves of a shorter step; returns as `march`.

    Given
        c, scheme, models   as in `march`
        states   (S, 14), times (S,) s
        place    (T,) number of the state before each epoch
        parts    (T,) s after it
        within   (T, 2 n + 1, columns) samples at the kicks
    Filled
        out      (T, 7) wxyz and angular velocity
    """
    n = scheme.shape[1] - 1
    work, row = scratch(), layout.ENTRY_BYTES * within.shape[2]
    body, plan, torques = body_of(c), (scheme.ctypes.data, n), torques_of(models)
    for i in range(len(place)):
        t, h = times[place[i]], 0.5 * parts[i]
        first = within.ctypes.data + i * (2 * n + 1) * row
        state = loaded(states[place[i]])
        for half in range(2 if h != 0.0 else 0):
            state, fault, when, turn = torqued_step(
                body,
                plan,
                torques,
                state,
                t + half * h,
                t + (half + 1) * h,
                h,
                first + half * n * row,
                row,
                work,
                half > 0,
            )
            if fault != layout.FINE:
                return fault, when, turn
        put_motion(state, out[i])
    return layout.FINE, 0.0, 0.0


@subroutine
def estimated(clock):
    """The estimate of the error of the motion with halved steps so far, rad.

    An error of the angular velocity becomes one of attitude by the turn that follows.
    """
    rough = (1.0 + clock[layout.TURNED]) * clock[layout.ROUGH] - clock[layout.ROUGH_TURNED]
    return clock[layout.APART] + rough


@subroutine
def _longest(limit, w):
    """The longest step at the angular velocity w, s."""
    speed = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    return limit / speed if speed > 0.0 else math.inf


@subroutine
def _ended(t, length, last):
    """The seconds at which a step from t ends: no later than `last`."""
    end = t + length
    return end if abs(end) <= last else math.copysign(last, length)


@subroutine
def _difference(start, one, two):
    """How far two states are apart: rad, and the change of the angular velocity over its size."""
    a, b, w = one[1], two[1], start[1]
    change = max(
        abs((a[0] - b[0]) + (one[3][0] - two[3][0])),
        abs((a[1] - b[1]) + (one[3][1] - two[3][1])),
        abs((a[2] - b[2]) + (one[3][2] - two[3][2])),
    )
    size = max(abs(b[0]), abs(b[1]), abs(b[2]), abs(w[0]), abs(w[1]), abs(w[2]))
    return max(_angle(one, two), change / size if size > 0.0 else 0.0)


@subroutine
def _angle(one, two):
    """The angle between the attitudes of two states, if small, rad."""
    p, q, p_low, q_low = one[0], two[0], one[2], two[2]
    total = 0.0
    for k in range(4):
        d = (p[k] - q[k]) + (p_low[k] - q_low[k])
        total += d * d
    return 2.0 * math.sqrt(total)


@subroutine
def _watch(clock, counts, error, h, order, w):
    """Sum the turn of the body, and the errors of steps in which the torque is not smooth."""
    speed = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    clock[layout.TURNED] += abs(h) * speed
    if error <= _ROUNDED:
        return
    power, usual = abs(h) ** (order + 1), clock[layout.USUAL]
    ratio = error / power
    if counts[layout.TAKEN] <= _GUESSED:
        clock[layout.USUAL] = max(ratio, usual)
        return
    if ratio > _UNUSUAL * usual and error > _NEGLIGIBLE * clock[layout.TOLERANCE]:
        # neither state of such a step is known to be the better one
        whole = error * (2.0**order - 1.0) / _MARGIN
        clock[layout.ROUGH] += whole
        clock[layout.ROUGH_TURNED] += whole * clock[layout.TURNED]
    clock[layout.USUAL] = min(max(ratio, usual / _UNUSUAL), usual * _UNUSUAL)
