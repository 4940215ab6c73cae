"""The loop of a splitting integrator with fixed steps over many states of one or many bodies."""

from attitude.compilation.decorators import entry_point
from attitude.compilation.pointers import scratch
from attitude.solution import march_layout as layout
from attitude.solution.motion_state import loaded, stored
from attitude.solution.torqued_step import body_of, torqued_step, torques_of


@entry_point
def march_members(c, scheme, models, states, start, h, steps, number, parts, given, within, out):
    """Take `steps` steps with each of N states, and parts of steps to epochs between.

    Given
        c        (1 or N, 30) numbers of the bodies, scheme (3, n + 1), models (1 or N, M, 5):
                 `march_layout`
        start    number of steps from the epoch to the first, a double; h s, of either sign
        number   (T,) whole steps from the first to the one before each epoch, ascending, at most
                 `steps`
        parts    (T,) s after those, less than a step
        given    (steps n + 1, columns) samples at the kicks of whole steps
        within   (T, n + 1, columns) samples at the kicks of the parts
    Changed
        states   (N, 14) as in solution.step, over the principal axes in ascending order
    Filled
        out      (N, T, 7) wxyz and angular velocity
    Returned
        FINE, BAD_TORQUE or TOO_LONG; the seconds at which; for TOO_LONG the angle turned between
        torques over the step, rad/s; and the member
    """
    n = scheme.shape[1] - 1
    work, row = scratch(), layout.ENTRY_BYTES * given.shape[1]
    samples, inner, plan = given.ctypes.data, within.ctypes.data, (scheme.ctypes.data, n)
    for m in range(len(states)):
        body, torques = body_of(c[m if len(c) > 1 else 0]), torques_of(models[m % len(models)])
        now = kept = loaded(states[m])
        step, i, follows = 0, 0, False
        while step < steps or i < len(number):
            # a whole step, or a part of one to an epoch: one call, compiled once
            t = (start + step) * h
            part = i < len(number) and number[i] == step
            if part:
                kept, first, length = now, inner + i * (n + 1) * row, parts[i]
                end, follows = t + length, False
            else:
                first, length = samples + step * n * row, h
                end = (start + (step + 1)) * h
            if not part or length != 0.0:
                now, fault, when, turn = torqued_step(
                    body, plan, torques, now, t, end, length, first, row, work, follows
                )
                if fault != layout.FINE:
                    return fault, when, turn, m
            if part:
                q, w, _, _ = now
                for k in range(4):
                    out[m, i, k] = q[k]
                for k in range(3):
                    out[m, i, 4 + k] = w[k]
                now, i = kept, i + 1
            else:
                step, follows = step + 1, True
        stored(now, states[m])
    return layout.FINE, 0.0, 0.0, 0
