"""Splitting integrators: torques between exact free motions, step after step.

A step is b0 kick, a1 free motion, b1 kick, ..., an free motion, bn kick, the coefficients in units
of the step; `attitude.schemes` holds them.  A kick changes the angular velocity at a fixed attitude
and epoch by the torque N there; with a coefficient g it also adds g h^3 times the torque of the
potential -N . I^-1 N (the commutator of torque, free motion and torque again): twice the slope of
N . y over turns of the body, y = I^-1 N being held, for which each torque has a function of y.

Torques are called by address, so that one compiled loop serves all of them, also those that a
user wrote.  Each is a C function

    void torque(double t, double *wxyz, double *omega, double *given, double *parameters,
                double *out)

of seconds since the epoch, the attitude body to inertial, the angular velocity over the body axes,
what was sampled for it at that epoch (a position, say) and its parameters; it fills the torque
over the body axes.
"""

import math

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from attitude.solution.attach import four, product, turned_by
from attitude.solution.machine import compiled, inlined
from attitude.solution.step import add, advance, gains

FINE, BAD_TORQUE, TOO_LONG = 0, 1, 2
# Kinds of torques, as in attitude.torques.torque.
BY_RATE, SLIP = 1, 2


@intrinsic
def _call(typingctx, address, t, wxyz, omega, given, parameters, out):
    """Call a torque; all but t are addresses."""

    def codegen(context, builder, signature, arguments):
        double = ir.DoubleType()
        pointer = double.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [double] + [pointer] * 5)
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        rest = [builder.inttoptr(each, pointer) for each in arguments[2:]]
        builder.call(function, [arguments[1], *rest])
        return context.get_dummy_value()

    i8, f8 = types.int64, types.float64
    return types.void(i8, f8, i8, i8, i8, i8, i8), codegen


@compiled
def march(c, scheme, models, state, start, h, steps, given, kept, every):
    """Take some steps.

    Given
        c        (20,) moments ascending (3), their inverses (3), principal axes to body axes as
                 wxyz (4) and as matrix by rows (9), the largest angle of a free motion (1)
        scheme   (3, n + 1) kicks, free motions (the last entry unused), force gradients
        models   (M, 5) each torque's address, its kind (`attitude.torques.torque`), the address
                 of its parameters, where its samples begin in a row, and the address of the
                 function for its force gradient
        start    s since the epoch; h s, of either sign
        given    (steps n + 1, columns) samples at the kicks, the last of a step being the first
                 of the next
        every    states are kept after each so many steps
    Changed
        state    (14,) as in solution.step, over the principal axes in ascending order
    Filled
        kept     (steps // every, 14)
    Returned
        what went wrong (or FINE), the seconds at which, and for a step that is too long the turn
        between torques over the step, rad/s
    """
    n = scheme.shape[1] - 1
    work = np.zeros(16)
    here, row = work.ctypes.data, 8 * given.shape[1]
    samples = given.ctypes.data
    body, limit, what = _body(c), c[19], _kinds(models)
    for step in range(steps):
        t, first = start + step * h, samples + step * n * row
        fault, when, turn = _step(
            body, limit, what, scheme, models, state, t, h, first, row, work, here, step > 0
        )
        if fault != FINE:
            return fault, when, turn
        if (step + 1) % every == 0:
            _copied(state, kept[step // every])
    return FINE, 0.0, 0.0


@compiled
def revisit(c, scheme, models, states, starts, h, place, steps, parts, given, within, out):
    """States between steps: whole steps from those that were kept, then a part of one.

    Given
        c, scheme, models, h   as in `march`
        states   (S, 14), starts (S,) s
        place    (T,) which of these each epoch follows, ascending; steps (T,) whole ones from
                 there, ascending for each place; parts (T,) s after those, less than a step
        given    (S, most n + 1, columns) samples at the kicks of whole steps
        within   (T, n + 1, columns) and of the parts
    Filled
        out      (T, 7) wxyz and angular velocity
    """
    n = scheme.shape[1] - 1
    work, state, last = np.zeros(16), np.zeros(14), np.zeros(14)
    here, row = work.ctypes.data, 8 * given.shape[2]
    samples, inner = given.ctypes.data, within.ctypes.data
    body, limit, what = _body(c), c[19], _kinds(models)
    now, done = -1, 0
    for i in range(len(place)):
        if place[i] != now:
            now, done = place[i], 0
            _copied(states[now], state)
        while done < steps[i]:
            t, first = starts[now] + done * h, samples + (now * given.shape[1] + done * n) * row
            fault, when, turn = _step(
                body, limit, what, scheme, models, state, t, h, first, row, work, here, False
            )
            if fault != FINE:
                return fault, when, turn
            done += 1
        _copied(state, last)
        if parts[i] != 0.0:
            t, first = starts[now] + done * h, inner + i * (n + 1) * row
            fault, when, turn = _step(
                body, limit, what, scheme, models, last, t, parts[i], first, row, work, here, False
            )
            if fault != FINE:
                return fault, when, turn
        _copied(last, out[i])
    return FINE, 0.0, 0.0


@inlined
def _copied(row, out):
    """As many numbers of a row as `out` takes.

    For an assignment of array to array, numba would compile the text of an error of shapes: 1.7 s.
    """
    for k in range(len(out)):
        out[k] = row[k]


@compiled
def accelerations(c, models, states, times, given, out):
    """Rates of change of the angular velocity, at states (T, 14) and times (T,): out (T, 3)."""
    body = _body(c)
    k1, k2, k3 = gains(body[0])
    work = np.zeros(16)
    here, samples = work.ctypes.data, given.ctypes.data
    for i in range(len(times)):
        w1, w2, w3 = states[i, 4], states[i, 5], states[i, 6]
        _see(body, states[i], work, 0.0, 0.0, 0.0)
        if not _torque(models, times[i], samples + 8 * i * given.shape[1], work, here):
            return BAD_TORQUE, times[i], 0.0
        a, b, d = _accelerations(body, work)
        out[i, 0] = k1 * w2 * w3 + a
        out[i, 1] = k2 * w3 * w1 + b
        out[i, 2] = k3 * w1 * w2 + d
    return FINE, 0.0, 0.0


@inlined
def _body(c):
    """Plain numbers, read once: arrays handed down a call cost more than all the arithmetic."""
    return (
        (c[0], c[1], c[2]),
        (c[3], c[4], c[5]),
        (c[6], c[7], c[8], c[9]),
        ((c[10], c[11], c[12]), (c[13], c[14], c[15]), (c[16], c[17], c[18])),
    )


@inlined
def _kinds(models):
    """Whether a torque depends on the rates, and whether one is a slip."""
    rates = slips = False
    for model in range(len(models)):
        rates = rates or models[model, 1] == BY_RATE
        slips = slips or models[model, 1] == SLIP
    return rates, slips


@inlined
def _step(body, limit, what, scheme, models, state, t, h, first, row, work, here, held):
    """One step; `held` tells that work still has the torque of its first kick.

    first, row   address of the samples of the first kick, and bytes to those of the next
    work, here   16 numbers for the torques, and their address
    """
    last = scheme.shape[1] - 1
    k = gains(body[0])
    done = 0.0
    for j in range(last + 1):
        if scheme[0, j] != 0.0:
            cubed = scheme[2, j] * h * h * h
            samples = first + j * row
            kept = held and j == 0
            if not _kick(
                body,
                what,
                models,
                state,
                t + done * h,
                scheme[0, j] * h,
                cubed,
                samples,
                work,
                here,
                kept,
            ):
                return BAD_TORQUE, t + done * h, 0.0
        if j < last:
            flight = scheme[1, j] * h
            w1, w2, w3 = state[4], state[5], state[6]
            turn = abs(flight) * math.sqrt(w1 * w1 + w2 * w2 + w3 * w3)
            if turn > limit:
                return TOO_LONG, t + done * h, turn / abs(h)
            advance(body[0], k, flight, state)
            done += scheme[1, j]
    return FINE, 0.0, 0.0


@inlined
def _kick(body, what, models, state, t, h, cubed, samples, work, here, held):
    """Torques for h seconds at a fixed attitude; False if one is not a number."""
    rates, slips = what
    fine = True
    if slips:
        fine = _slip(body, models, state, t, 0.5 * h, samples, work, here)
    if rates:
        fine = fine and _by_runge_kutta(body, models, state, t, h, samples, work, here)
    else:
        # work[7:10] is the torque over the body axes
        if not held or slips:
            _see(body, state, work, 0.0, 0.0, 0.0)
            fine = fine and _torque(models, t, samples, work, here)
        _apply(body, state, h, work)
    if cubed != 0.0 and fine:
        fine = _gradient(body, models, state, t, cubed, samples, work, here)
    if slips and fine:
        fine = _slip(body, models, state, t, 0.5 * h, samples, work, here)
    return fine


@inlined
def _gradient(body, models, state, t, cubed, samples, work, here):
    """The kick by the force gradient, after that by the torque in work[7:10], which stays."""
    n1, n2, n3 = work[7], work[8], work[9]
    a, b, d = _accelerations(body, work)
    for k in range(3):
        row = body[3][k]
        work[4 + k] = row[0] * a + row[1] * b + row[2] * d
    x = y = z = 0.0
    for model in range(len(models)):
        _ask(models, model, models[model, 4], t, samples, here)
        x, y, z = x + work[10], y + work[11], z + work[12]
    work[7], work[8], work[9] = 2.0 * x, 2.0 * y, 2.0 * z
    fine = _finite(work, 7)
    _apply(body, state, cubed, work)
    work[7], work[8], work[9] = n1, n2, n3
    return fine


@inlined
def _see(body, state, work, d1, d2, d3):
    """work[0:7]: attitude and angular velocity (plus d) over the body axes."""
    s, matrix = body[2], body[3]
    q = product((state[0], state[1], state[2], state[3]), (s[0], -s[1], -s[2], -s[3]))
    work[0], work[1], work[2], work[3] = q
    w1, w2, w3 = state[4] + d1, state[5] + d2, state[6] + d3
    work[4] = matrix[0][0] * w1 + matrix[0][1] * w2 + matrix[0][2] * w3
    work[5] = matrix[1][0] * w1 + matrix[1][1] * w2 + matrix[1][2] * w3
    work[6] = matrix[2][0] * w1 + matrix[2][1] * w2 + matrix[2][2] * w3


@inlined
def _ask(models, model, address, t, samples, here):
    """work[10:13]: what one function says of work[0:7]."""
    given = samples + 8 * models[model, 3]
    _call(address, t, here, here + 32, given, models[model, 2], here + 80)


@inlined
def _torque(models, t, samples, work, here):
    """work[7:10]: the sum of the torques."""
    x = y = z = 0.0
    for model in range(len(models)):
        if models[model, 1] != SLIP:
            _ask(models, model, models[model, 0], t, samples, here)
            x, y, z = x + work[10], y + work[11], z + work[12]
    work[7], work[8], work[9] = x, y, z
    return _finite(work, 7)


@inlined
def _finite(work, k):
    size = abs(work[k]) + abs(work[k + 1]) + abs(work[k + 2])
    return size < math.inf


@inlined
def _accelerations(body, work):
    """The torque in work[7:10] as rates of change over the principal axes."""
    inverse, m = body[1], body[3]
    a, b, c = work[7], work[8], work[9]
    return (
        inverse[0] * (m[0][0] * a + m[1][0] * b + m[2][0] * c),
        inverse[1] * (m[0][1] * a + m[1][1] * b + m[2][1] * c),
        inverse[2] * (m[0][2] * a + m[1][2] * b + m[2][2] * c),
    )


@inlined
def _apply(body, state, h, work):
    d1, d2, d3 = _accelerations(body, work)
    add(state, 4, h * d1)
    add(state, 5, h * d2)
    add(state, 6, h * d3)


@inlined
def _by_runge_kutta(body, models, state, t, h, samples, work, here):
    """A torque that depends on the angular velocity: fourth order at the fixed attitude."""
    x = y = z = 0.0
    a = b = c = 0.0
    for stage in range(4):
        ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
        weight = h / 3.0 if stage == 1 or stage == 2 else h / 6.0
        _see(body, state, work, ahead * a, ahead * b, ahead * c)
        if not _torque(models, t, samples, work, here):
            return False
        a, b, c = _accelerations(body, work)
        x, y, z = x + weight * a, y + weight * b, z + weight * c
    add(state, 4, x)
    add(state, 5, y)
    add(state, 6, z)
    return True


@inlined
def _slip(body, models, state, t, h, samples, work, here):
    """The body turns under its own momentum, which stays fixed in space; midpoint rule."""
    i, s = body[0], body[2]
    back = s[0], -s[1], -s[2], -s[3]
    for model in range(len(models)):
        if models[model, 1] == SLIP:
            momentum = i[0] * state[4], i[1] * state[5], i[2] * state[6]
            dx = dy = dz = 0.0
            turn = (1.0, 0.0, 0.0, 0.0)
            for stage in range(2):
                _see(body, state, work, dx, dy, dz)
                _ask(models, model, models[model, 0], t, samples, here)
                if not _finite(work, 10):
                    return False
                v = turned_by(back, (work[10], work[11], work[12]))
                turn = _half_turn(v, 0.25 * h if stage == 0 else 0.5 * h)
                # over body axes that turn by v, a fixed vector turns back
                left = turned_by((turn[0], -turn[1], -turn[2], -turn[3]), momentum)
                dx = left[0] / i[0] - state[4]
                dy = left[1] / i[1] - state[5]
                dz = left[2] / i[2] - state[6]
            q = product(four(state), turn)
            for k in range(4):
                add(state, k, q[k] - state[k])
            add(state, 4, dx)
            add(state, 5, dy)
            add(state, 6, dz)
    return True


@inlined
def _half_turn(v, half):
    """The quaternion of a turn by 2 half |v| about v."""
    size = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if size == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    sine = math.sin(half * size) / size
    return math.cos(half * size), sine * v[0], sine * v[1], sine * v[2]
