"""Loops of splitting integrators with fixed steps, for one state or many.

`torqued_step` has the step and the C functions of torques; `march_layout` the arrays.
"""

from __future__ import annotations

from attitude._compilation.decorators import entry_point, force_inlined, sized_entry_point
from attitude._compilation.pointers import scratch
from attitude._solver import march_layout as layout
from attitude._solver.step import gains, loaded, put_motion, stored
from attitude._solver.torqued_step import (
    accelerations_of,
    body_of,
    is_finite,
    kick,
    set_input,
    slip_of,
    torque_at,
    torqued_step,
    torques_of,
)


@sized_entry_point
def march(c, scheme, models, state, start, h, steps, at_kicks, kept, every):
    """Take `steps` steps.

    Given
        c        (30,) numbers of the body, scheme (3, n + 1), models (M, 5): `march_layout`
        start    number of steps from the epoch to the first, a double; h s, of either sign
        at_kicks (steps n + 1, columns) samples at the kicks, the last of a step being the first
                 of the next
        every    a state is kept after each `every` steps
    Changed
        state    (14,) as in step, over the principal axes in ascending order
    Filled
        kept     (steps // every, 14)
    Returned
        FINE, BAD_TORQUE or TOO_LONG; the seconds at which; and for TOO_LONG the angle turned
        between torques over the step, rad/s
    """
    n = scheme.shape[1] - 1
    work, samples, row = scratch(), at_kicks.ctypes.data, layout.ENTRY_BYTES * at_kicks.shape[1]
    body, plan, torques = body_of(c), (scheme.ctypes.data, n), torques_of(models)
    now = loaded(state)
    for step in range(steps):
        # Products: the bits of a state do not depend on the blocks in which steps are taken.
        t, end = (start + step) * h, (start + (step + 1)) * h
        first = samples + step * n * row
        now, fault, when, turn = torqued_step(
            body, plan, torques, now, t, end, h, first, row, work, step > 0
        )
        if fault != layout.FINE:
            return fault, when, turn
        if (step + 1) % every == 0:
            stored(now, kept[step // every])
    stored(now, state)
    return layout.FINE, 0.0, 0.0


@sized_entry_point
def revisit(c, scheme, models, states, starts, h, place, steps, parts, at_kicks, within, out):
    """States between steps: from kept ones by whole steps, then a part of one; returns as `march`.

    Given
        c, scheme, models, h   as in `march`
        states   (S, 14), starts (S,) numbers of steps from the epoch to them, doubles
        place    (T,) number of the state before each epoch, ascending
        steps    (T,) whole steps from there, ascending for each place
        parts    (T,) s after those, less than a step
        at_kicks (S, most n + 1, columns) samples at the kicks of whole steps
        within   (T, n + 1, columns) samples at the kicks of the parts
    Filled
        out      (T, 7) wxyz and angular velocity
    """
    n = scheme.shape[1] - 1
    work, row = scratch(), layout.ENTRY_BYTES * at_kicks.shape[2]
    samples, inner = at_kicks.ctypes.data, within.ctypes.data
    body, plan, torques = body_of(c), (scheme.ctypes.data, n), torques_of(models)
    first = last = 0
    while first < len(place):
        at = place[first]
        while last < len(place) and place[last] == at:
            last += 1
        kicks_of = samples + at * at_kicks.shape[1] * row, inner + first * (n + 1) * row, row, work
        _, fault, when, turn = _walked(
            body,
            plan,
            torques,
            loaded(states[at]),
            starts[at],
            h,
            0,
            kicks_of,
            steps[first:last],
            parts[first:last],
            out[first:last],
        )
        if fault != layout.FINE:
            return fault, when, turn
        first = last
    return layout.FINE, 0.0, 0.0


@force_inlined
def _walked(body, plan, torques, now, start, h, steps, kicks_of, number, parts, out):
    """The state after `steps` steps, and what `march` returns; fills out as `march_members`.

    kicks_of   addresses of the samples of whole steps and of parts, bytes of a row, and `scratch`
    """
    n, kept = plan[1], now
    samples, inner, row, work = kicks_of
    step, i, follows = 0, 0, False
    while step < steps or i < len(number):
        # a whole step, or a part of one to an epoch: one call, compiled once
        t = (start + step) * h
        sampled = i < len(number) and number[i] == step
        if sampled:
            kept, first, length = now, inner + i * (n + 1) * row, parts[i]
            end, follows = t + length, False
        else:
            first, length = samples + step * n * row, h
            end = (start + (step + 1)) * h
        if not sampled or length != 0.0:
            now, fault, when, turn = torqued_step(
                body, plan, torques, now, t, end, length, first, row, work, follows
            )
            if fault != layout.FINE:
                return now, fault, when, turn
        if sampled:
            put_motion(now, out[i])
            now, i = kept, i + 1
        else:
            step, follows = step + 1, True
    return now, layout.FINE, 0.0, 0.0


@entry_point
def accelerations(c, models, states, times, at_kicks, out):
    """Angular accelerations, out (T, 3), rad/s2 over principal axes, at states; returns as `march`.

    states are (T, 14), times (T,) s; c, models, at_kicks as in `march`, a row of these a state.
    """
    body, torques = body_of(c), torques_of(models)
    k1, k2, k3 = gains(body[0])
    work, samples, row = scratch(), at_kicks.ctypes.data, layout.ENTRY_BYTES * at_kicks.shape[1]
    for i in range(len(times)):
        state = loaded(states[i])
        w1, w2, w3 = state[1]
        set_input(body, state, work, 0.0, 0.0, 0.0)
        if not torque_at(torques, times[i], samples + i * row, work):
            return layout.BAD_TORQUE, times[i], 0.0
        a, b, d = accelerations_of(body, work)
        out[i, 0] = k1 * w2 * w3 + a
        out[i, 1] = k2 * w3 * w1 + b
        out[i, 2] = k3 * w1 * w2 + d
    return layout.FINE, 0.0, 0.0


@entry_point
def slips(c, models, states, times, at_kicks, out):
    """The turns, out (T, 3) rad/s, of the body under its momentum; the rest as `accelerations`."""
    body, torques = body_of(c), torques_of(models)
    work, samples, row = scratch(), at_kicks.ctypes.data, layout.ENTRY_BYTES * at_kicks.shape[1]
    for i in range(len(times)):
        set_input(body, loaded(states[i]), work, 0.0, 0.0, 0.0)
        slip = slip_of(body, torques, times[i], samples + i * row, work)
        if not is_finite(slip):
            return layout.BAD_TORQUE, times[i], 0.0
        out[i, 0], out[i, 1], out[i, 2] = slip
    return layout.FINE, 0.0, 0.0


@entry_point
def kicks(c, models, states, times, lengths, cubes, at_kicks, out):
    """Apply the torques to some states, as in a step: out (T, 14), the states after.

    Arguments and answer as in `accelerations`; lengths (T,) s for which torques act, at a fixed
    attitude; cubes (T,) s3, coefficient of the force gradient times the cube of the step.
    """
    body, torques = body_of(c), torques_of(models)
    work, samples, row = scratch(), at_kicks.ctypes.data, layout.ENTRY_BYTES * at_kicks.shape[1]
    for i in range(len(times)):
        state, fine = kick(
            body,
            torques,
            loaded(states[i]),
            times[i],
            lengths[i],
            cubes[i],
            samples + i * row,
            work,
            False,
        )
        if not fine:
            return layout.BAD_TORQUE, times[i], 0.0
        stored(state, out[i])
    return layout.FINE, 0.0, 0.0


# ---- The loop of a splitting integrator with fixed steps over many states of one or many bodies


@entry_point
def march_members(c, scheme, models, states, start, h, steps, number, parts, at_kicks, within, out):
    """Take `steps` steps with each of N states, and parts of steps to epochs between.

    Returns as `march`, and the member.

    Given
        c        (1 or N, 30), scheme (3, n + 1), models (1 or N, M, 5), start, h: as in `march`
        number   (T,) whole steps from the first to the one before each epoch, ascending, at most
                 `steps`
        parts    (T,) s after those, less than a step
        at_kicks (steps n + 1, columns) samples at the kicks of whole steps
        within   (T, n + 1, columns) samples at the kicks of the parts
    Changed
        states   (N, 14) as in step, over the principal axes in ascending order
    Filled
        out      (N, T, 7) wxyz and angular velocity
    """
    work, row = scratch(), layout.ENTRY_BYTES * at_kicks.shape[1]
    plan = scheme.ctypes.data, scheme.shape[1] - 1
    kicks_of = at_kicks.ctypes.data, within.ctypes.data, row, work
    for m in range(len(states)):
        body, torques = body_of(c[m if len(c) > 1 else 0]), torques_of(models[m % len(models)])
        now, fault, when, turn = _walked(
            body,
            plan,
            torques,
            loaded(states[m]),
            start,
            h,
            steps,
            kicks_of,
            number,
            parts,
            out[m],
        )
        if fault != layout.FINE:
            return fault, when, turn, m
        stored(now, states[m])
    return layout.FINE, 0.0, 0.0, 0
