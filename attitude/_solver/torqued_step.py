"""One step of a splitting integrator: torques between exact free motions.

A step is b0 kick, a1 free motion, b1 kick, ..., an free motion, bn kick, the coefficients (of
`attitude.torques._schemes`) in units of the step.  A kick changes the angular velocity at a fixed
attitude and epoch by the torque N there; with a coefficient g it also adds g h^3 times the torque
of the potential -N . I^-1 N (the commutator of torque, free motion and torque): twice the slope of
N . y over turns of the body at constant y = I^-1 N, for which each torque has a function of y.

Torques are called by address, so that one compiled loop serves all of them, also those that users
write.  Each is a C function

    void torque(double t, double *wxyz, double *omega, double *given, double *parameters,
                double *out)

of seconds since the epoch, the attitude body to inertial, the angular velocity over the body axes,
the samples for that epoch (such as a position) and its parameters; it fills the torque over the
body axes.  A function that returns without filling it, because of an exception, leaves NaN.

The loops pass addresses to the functions they call, never arrays (see `pointers`).
"""

from __future__ import annotations

import math
from typing import Final

from attitude._compilation.decorators import force_inlined, subroutine
from attitude._compilation.instructions import fma
from attitude._compilation.pointers import call, number, put, put_three, whole
from attitude._solver import march_layout as layout
from attitude._solver.kernel import product, turned_by
from attitude._solver.march_layout import BY_RATE, LINEAR, SLIP
from attitude._solver.step import advance, gains, kicked, moved_by

_ZERO = 0.0, 0.0, 0.0
# (rad/s)^2; below it, fourth powers of the rate are finite.
FASTEST: Final = 1e150
# Longer kicks of LINEAR torques, in units of their fastest rate, are by Runge-Kutta as BY_RATE.
_LONGEST_DAMPING: Final = 256.0


@subroutine
def body_of(c):
    """The numbers c of `march` as tuples: moments, inverses, quaternion, matrix, largest angle;
    then the matrix of damping by rows, and its size.
    """
    d = layout.DAMPING
    return (
        (c[layout.MOMENTS], c[layout.MOMENTS + 1], c[layout.MOMENTS + 2]),
        (c[layout.INVERSES], c[layout.INVERSES + 1], c[layout.INVERSES + 2]),
        (c[layout.TURN], c[layout.TURN + 1], c[layout.TURN + 2], c[layout.TURN + 3]),
        (
            (c[layout.MATRIX], c[layout.MATRIX + 1], c[layout.MATRIX + 2]),
            (c[layout.MATRIX + 3], c[layout.MATRIX + 4], c[layout.MATRIX + 5]),
            (c[layout.MATRIX + 6], c[layout.MATRIX + 7], c[layout.MATRIX + 8]),
        ),
        c[layout.LARGEST_TURN],
        (
            (c[d], c[d + 1], c[d + 2]),
            (c[d + 3], c[d + 4], c[d + 5]),
            (c[d + 6], c[d + 7], c[d + 8]),
        ),
        c[layout.DAMPING_SIZE],
    )


@subroutine
def torques_of(models):
    """The address of `models`, their number, whether one is BY_RATE, SLIP, LINEAR."""
    rates = slips = linear = False
    for model in range(len(models)):
        rates = rates or models[model, layout.KIND] == BY_RATE
        slips = slips or models[model, layout.KIND] == SLIP
        linear = linear or models[model, layout.KIND] == LINEAR
    return models.ctypes.data, len(models), rates, slips, linear


@force_inlined
def torqued_step(body, plan, torques, state, t, end, h, first, row, work, held):
    """The state after one step, and what `march` returns.

    t, end       s at which the step starts and ends; `end` is that of the last kick: the rounded
                 sum of `t` and `h` may be another, and the torque there serves the next step
    held         whether `work` has the torque at the start, left by the step that ended there
    plan         the address of the scheme, and the number of its free motions
    first, row   address of the samples of the first kick, and bytes to those of the next
    work         address of the scratch memory of the torques: `march_layout`
    """
    last = plan[1]
    k, limit = gains(body[0]), body[4]
    held = held and coefficient(plan, layout.KICKS, last) != 0.0
    done = 0.0
    for j in range(last + 1):
        fraction = coefficient(plan, layout.KICKS, j)
        gradient = coefficient(plan, layout.GRADIENTS, j)
        when = end if j == last else t + done * h
        if fraction != 0.0 or gradient != 0.0:
            state, fine = kick(
                body,
                torques,
                state,
                when,
                fraction * h,
                gradient * h * h * h,
                first + j * row,
                work,
                held and j == 0,
            )
            if not fine:
                return state, layout.BAD_TORQUE, when, 0.0
        if j < last:
            fraction = coefficient(plan, layout.FLIGHTS, j)
            flight = fraction * h
            w1, w2, w3 = state[1]
            speed = w1 * w1 + w2 * w2 + w3 * w3
            if flight * flight * speed > limit * limit or speed > FASTEST:
                return state, layout.TOO_LONG, when, abs(fraction) * math.sqrt(speed)
            state = advance(body[0], k, flight, state)
            done += fraction
    return state, layout.FINE, 0.0, 0.0


@subroutine
def coefficient(plan, row, j):
    """Coefficient j in a row of the scheme."""
    return number(plan[0], row * (plan[1] + 1) + j)


@force_inlined
def kick(body, torques, state, t, h, cubed, samples, work, held):
    """The state after h seconds of torques at a fixed attitude, and whether they are finite."""
    _, _, rates, slips, linear = torques
    fine = True
    if slips:
        state, fine = _slipped(body, torques, state, t, h, samples, work)
    elif rates or (linear and not is_short(body, h)):
        state, fine = _by_runge_kutta(body, torques, state, t, h, samples, work)
    else:
        # TORQUE in work is the torque over the body axes
        if not held or linear:
            set_input(body, state, work, 0.0, 0.0, 0.0)
            fine = torque_at(torques, t, samples, work)
        change = rate_gained(body, accelerations_of(body, work), h, abs(h), linear)
        state = kicked(state, change, _ZERO)
    if cubed != 0.0 and fine:
        state, fine = _gradient(body, torques, state, t, cubed, samples, work)
    return state, fine


@subroutine
def _gradient(body, torques, state, t, cubed, samples, work):
    """The state after the kick by the force gradient of TORQUE, which is kept."""
    n1, n2, n3 = _three(work, layout.TORQUE)
    a, b, d = accelerations_of(body, work)
    for k in range(3):
        row = body[3][k]
        put(work, layout.INPUT_OMEGA + k, row[0] * a + row[1] * b + row[2] * d)
    x = y = z = 0.0
    for model in range(torques[1]):
        a, b, d = _call_torque(torques, model, layout.SLOPE, t, samples, work)
        x, y, z = x + a, y + b, z + d
    put_three(work, layout.TORQUE, 2.0 * x, 2.0 * y, 2.0 * z)
    fine = is_finite(_three(work, layout.TORQUE))
    change = rate_gained(body, accelerations_of(body, work), cubed, 0.0, False)
    state = kicked(state, change, _ZERO)
    put_three(work, layout.TORQUE, n1, n2, n3)
    return state, fine


@subroutine
def set_input(body, state, work, d1, d2, d3):
    """Fill INPUT: attitude and angular velocity (plus d) over the body axes."""
    s, matrix = body[2], body[3]
    q, w, _, _ = state
    a, b, c, d = product(q, (s[0], -s[1], -s[2], -s[3]))
    put(work, layout.INPUT_WXYZ, a)
    put_three(work, layout.INPUT_WXYZ + 1, b, c, d)
    w1, w2, w3 = w[0] + d1, w[1] + d2, w[2] + d3
    put(work, layout.INPUT_OMEGA, matrix[0][0] * w1 + matrix[0][1] * w2 + matrix[0][2] * w3)
    put(work, layout.INPUT_OMEGA + 1, matrix[1][0] * w1 + matrix[1][1] * w2 + matrix[1][2] * w3)
    put(work, layout.INPUT_OMEGA + 2, matrix[2][0] * w1 + matrix[2][1] * w2 + matrix[2][2] * w3)


@subroutine
def _entry(torques, model, column):
    """The whole number in a column of the row of one torque."""
    return whole(torques[0] + layout.MODEL_BYTES * model, column)


@subroutine
def _call_torque(torques, model, function, t, samples, work):
    """Call the function in a column of a torque's row of `models`: its result, from RETURNED."""
    sample = samples + layout.ENTRY_BYTES * _entry(torques, model, layout.COLUMN)
    parameters = _entry(torques, model, layout.PARAMETERS)
    wxyz, omega = work + layout.INPUT_WXYZ_BYTES, work + layout.INPUT_OMEGA_BYTES
    out = work + layout.RETURNED_BYTES
    put_three(work, layout.RETURNED, math.nan, math.nan, math.nan)
    call(_entry(torques, model, function), t, wxyz, omega, sample, parameters, out)
    return _three(work, layout.RETURNED)


@subroutine
def torque_at(torques, t, samples, work):
    """Fill TORQUE with the sum of the torques; whether it is finite."""
    x, y, z = torque_of(torques, t, samples, work, True)
    put_three(work, layout.TORQUE, x, y, z)
    return is_finite((x, y, z))


@subroutine
def torque_of(torques, t, samples, work, with_linear):
    """The sum of the torques, with or without LINEAR ones."""
    x = y = z = 0.0
    for model in range(torques[1]):
        kind = _entry(torques, model, layout.KIND)
        if kind != SLIP and (with_linear or kind != LINEAR):
            a, b, c = _call_torque(torques, model, layout.FUNCTION, t, samples, work)
            x, y, z = x + a, y + b, z + c
    return x, y, z


@subroutine
def slip_of(body, torques, t, samples, work):
    """The sum of the slips at INPUT, rad/s over the principal axes."""
    s = body[2]
    x = y = z = 0.0
    for model in range(torques[1]):
        if _entry(torques, model, layout.KIND) == SLIP:
            v = _call_torque(torques, model, layout.FUNCTION, t, samples, work)
            a, b, c = turned_by((s[0], -s[1], -s[2], -s[3]), v)
            x, y, z = x + a, y + b, z + c
    return x, y, z


@subroutine
def _three(address, k):
    """Three doubles from place k on."""
    return number(address, k), number(address, k + 1), number(address, k + 2)


@subroutine
def is_finite(v):
    """Whether the numbers of a vector are finite."""
    return abs(v[0]) + abs(v[1]) + abs(v[2]) < math.inf


@subroutine
def accelerations_of(body, work):
    """TORQUE as rates of change of the angular velocity over the principal axes."""
    return accelerations_by(body, _three(work, layout.TORQUE))


@subroutine
def accelerations_by(body, torque):
    """A torque as rates of change of the angular velocity over the principal axes."""
    inverse, m = body[1], body[3]
    a, b, c = torque
    return (
        inverse[0] * (m[0][0] * a + m[1][0] * b + m[2][0] * c),
        inverse[1] * (m[0][1] * a + m[1][1] * b + m[2][1] * c),
        inverse[2] * (m[0][2] * a + m[1][2] * b + m[2][2] * c),
    )


@force_inlined
def rate_gained(body, acceleration, h, size, linear):
    """The change of the angular velocity by h seconds of torques at a fixed attitude.

    acceleration   by the torques at the start; doubles or SIMD vectors, as h
    size           the size of h, the largest of a vector
    linear         whether one of the torques is LINEAR

    With the acceleration a at the start and its change J by the angular velocity, the change x has
    x' = a + J x: x = h (a + J h/2 (a + J h/3 (a + ...))) over pieces with |J h| <= 1/2.  The terms
    left out are below 4e-17 of the first.
    """
    a, b, c = acceleration
    if not linear:
        return h * a, h * b, h * c
    rows, angle = body[5], size * body[6]
    count, terms = 1.0 + math.floor(2.0 * angle), 15.0
    if angle < 1e-5:
        terms = 3.0
    elif angle < 2.6e-4:
        terms = 4.0
    elif angle < 7.6e-3:
        terms = 6.0
    elif angle < 0.08:
        terms = 9.0
    piece = h / count
    x = y = z = 0.0 * h
    while count > 0.0:
        d1, d2, d3 = gained_by(rows, acceleration, (x, y, z))
        e1, e2, e3, k = d1, d2, d3, terms
        while k > 1.0:  # a loop over a range costs divisions of whole numbers
            share = piece / k
            shares = share * e1, share * e2, share * e3
            e1, e2, e3 = gained_by(rows, (d1, d2, d3), shares)
            k -= 1.0
        x, y, z = x + piece * e1, y + piece * e2, z + piece * e3
        count -= 1.0
    return x, y, z


@subroutine
def is_short(body, h):
    """Whether a kick of LINEAR torques is by `rate_gained`."""
    return abs(h) * body[6] <= _LONGEST_DAMPING


@subroutine
def gained_by(m, a, v):
    """A vector and a matrix, by rows, times another: a + m v."""
    x, y, z = v
    return (
        fma(m[0][0], x, fma(m[0][1], y, fma(m[0][2], z, a[0]))),
        fma(m[1][0], x, fma(m[1][1], y, fma(m[1][2], z, a[1]))),
        fma(m[2][0], x, fma(m[2][1], y, fma(m[2][2], z, a[2]))),
    )


@subroutine
def _by_runge_kutta(body, torques, state, t, h, samples, work):
    """The state after h seconds of torques that depend on the angular velocity, fourth order."""
    x = y = z = 0.0
    a = b = c = 0.0
    for stage in range(4):
        ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
        weight = h / 3.0 if stage == 1 or stage == 2 else h / 6.0
        set_input(body, state, work, ahead * a, ahead * b, ahead * c)
        if not torque_at(torques, t, samples, work):
            return state, False
        a, b, c = accelerations_of(body, work)
        x, y, z = x + weight * a, y + weight * b, z + weight * c
    return kicked(state, (x, y, z), _ZERO), True


@subroutine
def _slipped(body, torques, state, t, h, samples, work):
    """The state after h seconds of torques, and of slips at constant momentum, fourth order.

    By Runge-Kutta, over the body axes at the start: of 1 + p, the turn of the body, whose rate is
    (1 + p) v/2 with the slip v, and of the momentum gained from the torques.
    """
    i = body[0]
    a = b = c = d = x = y = z = 0.0  # the rates of p and of the momentum
    turn, gained = (0.0, 0.0, 0.0, 0.0), _ZERO
    for stage in range(4):
        ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
        weight = h / 3.0 if stage == 1 or stage == 2 else h / 6.0
        p = ahead * a, ahead * b, ahead * c, ahead * d
        by = _turned_back(i, state[1], p, (ahead * x, ahead * y, ahead * z))
        set_input(body, moved_by(state, by), work, 0.0, 0.0, 0.0)
        fine = torque_at(torques, t, samples, work)
        v = slip_of(body, torques, t, samples, work)
        if not (fine and is_finite(v)):
            return state, False
        half = 0.0, 0.5 * v[0], 0.5 * v[1], 0.5 * v[2]
        a, b, c, d = product((1.0 + p[0], p[1], p[2], p[3]), half)
        n, q = accelerations_of(body, work), by[0]
        n = i[0] * n[0], i[1] * n[1], i[2] * n[2]
        x, y, z = turned_by((1.0 + q[0], q[1], q[2], q[3]), n)
        turn = (
            turn[0] + weight * a,
            turn[1] + weight * b,
            turn[2] + weight * c,
            turn[3] + weight * d,
        )
        gained = gained[0] + weight * x, gained[1] + weight * y, gained[2] + weight * z
    return moved_by(state, _turned_back(i, state[1], turn, gained)), True


@subroutine
def _turned_back(i, w, p, gained):
    """The increment, of `moved_by`, by a turn 1 + p of any length and momentum over first axes.

    Over axes that turn, a fixed vector turns back.  Differences alone are rounded.
    """
    s, x, y, z = p
    size = 2.0 * s + (s * s + x * x + y * y + z * z)  # less 1, the square of that of 1 + p
    root = math.sqrt(1.0 + size)
    f = -size / (root + 1.0 + size)
    s, x, y, z = s + f * (1.0 + s), x + f * x, y + f * y, z + f * z
    a, b, c = i[0] * w[0] + gained[0], i[1] * w[1] + gained[1], i[2] * w[2] + gained[2]
    a, b, c = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    e = 1.0 + s
    change = (
        (gained[0] - e * a + (y * c - z * b)) / i[0],
        (gained[1] - e * b + (z * a - x * c)) / i[1],
        (gained[2] - e * c + (x * b - y * a)) / i[2],
    )
    return (s, x, y, z), change, 0.0, _ZERO
