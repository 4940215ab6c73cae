"""Compiled: mean rates of momentum and energy, their integration, changes along the separatrix.

The state is L (3,) in N m s over ICRF axes and y (`_polhode`).  Each mean of a torque is one row of
`models` with a table in `data` and numbers of the epoch in `forcing`:

HARMONICS   a torque that is a function of one direction u in the body: for each degree l the means
            of l . N_l, gamma l . N_l / (p (1 - p)), N_l . grad, N_l . (l x grad) over the polhode,
            times `_tables.weights`.  The precession multiplies them by P_l(c) and P_l'(c),
            c = l . s, and nothing else.
TENSOR      a torque that is linear in a tensor T over inertial axes: ten numbers, as `TensorMean`.
FRICTION    of a rheology: logarithms of -dy/dt |L|/2 at nodes of ln |L|.
TORUS       any torque: evaluated at nodes of the nutation and of the precession.
DRIFT       dL/dt and dy/dt, numbers of the epoch: what second order adds (`_second_order`).

The factor |L|^exponent is that of all numbers of a table.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from attitude._compilation.decorators import entry_point, subroutine
from attitude._compilation.pointers import call, number, put, scratch
from attitude._solver.kernel import product
from attitude.averaged._polhode import (
    AXES_ENTRIES,
    INVERSES,
    LAM_PLUS,
    MATRIX,
    SEPARATRIX,
    SPREAD,
    TURN,
    direction,
    form,
    jacobi,
    theta_constants,
)

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray

HARMONICS: Final = 0
TENSOR: Final = 1
TORUS: Final = 2
FRICTION: Final = 3
DRIFT: Final = 4
# Entries of a row of `models`.
KIND: Final = 0
TABLE: Final = 1  # where in `data`
COLUMNS: Final = 2  # of the table
DEGREE: Final = 3
NODES: Final = 4  # directions, or epochs of an orbit
FORCING: Final = 5  # where in `forcing`
WIDTH: Final = 6  # numbers of an epoch
ARCS: Final = 7  # where in `data`
EXPONENT: Final = 8
STRENGTH: Final = 9  # where in `data`; behind it, of FRICTION, the first node and their spacing
FUNCTION: Final = 10  # addresses
PARAMETERS: Final = 11
SAMPLED: Final = 12  # numbers that the torque samples
NUTATION: Final = 13  # nodes of the torus
PRECESSION: Final = 14
SLIPS: Final = 15
MODEL_ENTRIES: Final = 16
# The table's coordinate: x = ln(exp(h) - 1), which is ln h near the separatrix and h far from it.
TABLE_START: Final = AXES_ENTRIES  # entries of data: first x, step, intervals
TABLE_STEP: Final = AXES_ENTRIES + 1
TABLE_COUNT: Final = AXES_ENTRIES + 2
# Of the recursions of P_n and of P_n' with the highest coefficient 1: the factors of the last but
# one of them, by degree.
RECURSIONS: Final = AXES_ENTRIES + 3
MOST: Final = 65
DATA_START: Final = AXES_ENTRIES + 3 + 2 * MOST
# Head of a block of `forcing`: first second, step, intervals (0: constant).
HEAD: Final = 3
# Nearest distance from the separatrix, and where the other side begins.
NEAREST: Final = 1e-7
BEYOND: Final = 1e-6
# What ends a call of `advance`.
REACHED, PASSAGE, CLAMPED, RELEASED, STRONG, FULL, BAD = range(7)
# A row of the trajectory: start, length of its step, s; region, end at which y is held (-1, 0, 1),
# and five coefficients of each of L and y in the share of the step.
ROW_START, ROW_STEP, ROW_REGION, ROW_HELD, ROW_TERMS = range(5)
ROW_END: Final = 24  # the second at which the row stops being valid
ROW_ENTRIES: Final = 25


# Golden section: phases of precession that no period of the nodes repeats.
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def recursions() -> FloatArray:
    """The factors (2 MOST,) of Clenshaw's sums: of P_n for n + 1, and of P_n' for n (DLMF 18.9)."""
    n = np.arange(float(MOST))
    legendre = (n + 1.0) ** 2 / (4.0 * (n + 1.0) ** 2 - 1.0)
    slopes = n * (n + 2.0) / ((2.0 * n + 1.0) * (2.0 * n + 3.0))
    return np.concatenate([legendre, slopes])


@subroutine
def place(data, y, region):
    """Interval of the tables, and the distance into it."""
    y_s = data[SEPARATRIX]
    h = abs(y - y_s)
    x = h if h > 36.0 else math.log(math.expm1(max(h, 1e-12)))
    step, count = data[TABLE_STEP], int(data[TABLE_COUNT])
    z = (x - data[TABLE_START]) / step
    z = min(max(z, 0.0), count - 1e-9)
    interval = int(z)
    return interval, (z - interval) * step


@subroutine
def interpolated(data, start, columns, region, interval, d, count, work, first):
    """Fill columns of a table at a place into work[first:]."""
    base = start + ((region * count + interval) * 4) * columns
    # slices, whose indices need no check for negative ones: the loop is vectorised
    third, second = data[base : base + columns], data[base + columns : base + 2 * columns]
    base += 2 * columns
    one, zero = data[base : base + columns], data[base + columns : base + 2 * columns]
    out = work[first : first + columns]
    for j in range(columns):
        out[j] = ((third[j] * d + second[j]) * d + one[j]) * d + zero[j]


@subroutine
def forced(t, forcing, start, width, work, first):
    """Fill the numbers of an epoch into work[first:]."""
    count = int(forcing[start + 2])
    base = start + HEAD
    if count == 0:
        for j in range(width):
            work[first + j] = forcing[base + j]
        return
    z = (t - forcing[start]) / forcing[start + 1]
    interval = min(max(int(z), 0), count - 1)
    d = (z - interval) * forcing[start + 1]
    base += interval * 4 * width
    for j in range(width):
        k = base + j
        work[first + j] = (
            (forcing[k] * d + forcing[k + width]) * d + forcing[k + 2 * width]
        ) * d + forcing[k + 3 * width]


@subroutine
def power(base, exponent):
    """base^exponent for a whole exponent."""
    if exponent == 0:
        return 1.0
    if exponent == 1:
        return base
    return base**exponent


@subroutine
def one_direction(data, work, table, s, degree, l0, l1, l2):
    """Torque over inertial axes and rate of y from one direction s[0:3] with its weight s[3].

    Clenshaw's sums of P_n and of P_n', each divided by its highest coefficient.
    """
    x, y, z, w = work[s], work[s + 1], work[s + 2], work[s + 3]
    c = x * l0 + y * l1 + z * l2
    a = a_after = e = e_after = p = p_after = v = v_after = 0.0
    k = table + 4 * degree
    for n in range(degree, 0, -1):
        back, steep = data[RECURSIONS + n], data[RECURSIONS + MOST + n]
        a, a_after = c * a + (work[k] - back * a_after), a
        e, e_after = c * e + (work[k + 1] - back * e_after), e
        p, p_after = c * p + (work[k + 2] - steep * p_after), p
        v, v_after = c * v + (work[k + 3] - steep * v_after), v
        k -= 4
    back = data[RECURSIONS]
    a = c * a + (work[table] - back * a_after)
    e = c * e + (work[table + 1] - back * e_after)
    a -= p * c
    return (
        w * (a * l0 + p * x + v * (l1 * z - l2 * y)),
        w * (a * l1 + p * y + v * (l2 * x - l0 * z)),
        w * (a * l2 + p * z + v * (l0 * y - l1 * x)),
        w * e,
        abs(w),
    )


@subroutine
def several_directions(data, work, table, count, degree, l0, l1, l2, legendre):
    """The same for the sum over directions, whose recursions run side by side."""
    # rows of work from `legendre`, as slices: c; P and P' before; P and P'; the sums a, e, p, v
    cosine, before, slope_before = (
        work[legendre : legendre + count],
        work[legendre + count : legendre + 2 * count],
        work[legendre + 2 * count : legendre + 3 * count],
    )
    value, slope = (
        work[legendre + 3 * count : legendre + 4 * count],
        work[legendre + 4 * count : legendre + 5 * count],
    )
    along, energy, radial, across = (
        work[legendre + 5 * count : legendre + 6 * count],
        work[legendre + 6 * count : legendre + 7 * count],
        work[legendre + 7 * count : legendre + 8 * count],
        work[legendre + 8 * count : legendre + 9 * count],
    )
    for q in range(count):
        k = 4 * q
        c = work[k] * l0 + work[k + 1] * l1 + work[k + 2] * l2
        cosine[q], before[q], value[q] = c, 1.0, c
        slope_before[q], slope[q] = 0.0, 1.0
        along[q] = work[table] + c * work[table + 4]
        energy[q] = work[table + 1] + c * work[table + 5]
        radial[q], across[q] = work[table + 6], work[table + 7]
    for n in range(2, degree + 1):
        k = table + 4 * n
        back, steep = data[RECURSIONS + n - 2], data[RECURSIONS + MOST + n - 2]
        t0, t1, t2, t3 = work[k], work[k + 1], work[k + 2], work[k + 3]
        for q in range(count):
            after = cosine[q] * value[q] - back * before[q]
            slope_after = cosine[q] * slope[q] - steep * slope_before[q]
            before[q], value[q] = value[q], after
            slope_before[q], slope[q] = slope[q], slope_after
            along[q] += after * t0
            energy[q] += after * t1
            radial[q] += slope_after * t2
            across[q] += slope_after * t3
    o0 = o1 = o2 = g = total = 0.0
    for q in range(count):
        k = 4 * q
        x, y, z, w = work[k], work[k + 1], work[k + 2], work[k + 3]
        p, v = radial[q], across[q]
        a = along[q] - p * cosine[q]
        o0 += w * (a * l0 + p * x + v * (l1 * z - l2 * y))
        o1 += w * (a * l1 + p * y + v * (l2 * x - l0 * z))
        o2 += w * (a * l2 + p * z + v * (l0 * y - l1 * x))
        g += w * energy[q]
        total += abs(w)
    return o0, o1, o2, g, total


@subroutine
def of_tensor(work, table, l0, l1, l2):
    """Torque over inertial axes and rate of y from a tensor T by rows, work[:9].

    Table: along l per tr T, l.T l, l.vec T; the same for y; across l per T l, l x T l, T' l,
    l x T' l, where vec T = (T21 - T12, ...).
    """
    x0 = work[0] * l0 + work[1] * l1 + work[2] * l2
    x1 = work[3] * l0 + work[4] * l1 + work[5] * l2
    x2 = work[6] * l0 + work[7] * l1 + work[8] * l2
    z0 = work[0] * l0 + work[3] * l1 + work[6] * l2
    z1 = work[1] * l0 + work[4] * l1 + work[7] * l2
    z2 = work[2] * l0 + work[5] * l1 + work[8] * l2
    trace = work[0] + work[4] + work[8]
    form_ = x0 * l0 + x1 * l1 + x2 * l2
    turn = (work[7] - work[5]) * l0 + (work[2] - work[6]) * l1 + (work[3] - work[1]) * l2
    a = work[table] * trace + work[table + 1] * form_ + work[table + 2] * turn
    e = work[table + 3] * trace + work[table + 4] * form_ + work[table + 5] * turn
    f0, f1 = work[table + 6], work[table + 7]
    f2, f3 = work[table + 8], work[table + 9]
    a -= (f0 + f2) * form_
    u0, u1, u2 = f1 * x0 + f3 * z0, f1 * x1 + f3 * z1, f1 * x2 + f3 * z2
    size = 0.0
    for k in range(9):
        size += work[k] * work[k]
    return (
        a * l0 + f0 * x0 + f2 * z0 + l1 * u2 - l2 * u1,
        a * l1 + f0 * x1 + f2 * z1 + l2 * u0 - l0 * u2,
        a * l2 + f0 * x2 + f2 * z2 + l0 * u1 - l1 * u0,
        e,
        math.sqrt(size),
    )


@subroutine
def at_size(values, table, columns, size, data, first):
    """exp of logarithms at nodes of ln |L| (values[table:]), by the cubic through four of them."""
    place = (math.log(size) - data[first]) / data[first + 1]
    at = min(max(place, 0.0), columns - 1.0)
    begin = min(max(int(at) - 1, 0), columns - 4)
    d = at - begin
    total = -values[table + begin] * (d - 1.0) * (d - 2.0) * (d - 3.0) / 6.0
    total += values[table + begin + 1] * d * (d - 2.0) * (d - 3.0) / 2.0
    total -= values[table + begin + 2] * d * (d - 1.0) * (d - 3.0) / 2.0
    total += values[table + begin + 3] * d * (d - 1.0) * (d - 2.0) / 6.0
    return math.exp(total)


@subroutine
def half_turned(x0, x1, x2, l0, l1, l2):
    """Half a turn that takes the unit vector x to l, not opposite to it: a quaternion."""
    a, b, c = x0 + l0, x1 + l1, x2 + l2
    size = math.sqrt(a * a + b * b + c * c)
    return 0.0, a / size, b / size, c / size


@subroutine
def turned_to(x, l0, l1, l2):
    """A quaternion that turns the unit vector x to l."""
    if x[0] * l0 + x[1] * l1 + x[2] * l2 > -0.9:
        return half_turned(x[0], x[1], x[2], l0, l1, l2)
    # nearly opposite: first half a turn about a vector across x, to -x
    b = (0.0, x[2], -x[1]) if abs(x[0]) < abs(x[1]) else (-x[2], 0.0, x[0])
    size = math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
    first = (0.0, b[0] / size, b[1] / size, b[2] / size)
    return product(half_turned(-x[0], -x[1], -x[2], l0, l1, l2), first)


@subroutine
def torque_at(t, q, x, size, data, sample, model, models, at):
    """A torque at one attitude: over inertial axes, and gamma . l N, from l (principal axes).

    q: principal axes to ICRF.  The returned energy rate is (w across L) . N / (L D).
    """
    turn = (data[TURN], -data[TURN + 1], -data[TURN + 2], -data[TURN + 3])
    body = product(q, turn)
    for k in range(4):
        put(at, k, body[k])
    w = (
        size * x[0] * data[INVERSES],
        size * x[1] * data[INVERSES + 1],
        size * x[2] * data[INVERSES + 2],
    )
    m = MATRIX
    for k in range(3):
        row = m + 3 * k
        put(at, 4 + k, data[row] * w[0] + data[row + 1] * w[1] + data[row + 2] * w[2])
        put(at, 8 + k, math.nan)
    function, parameters = models[model, FUNCTION], models[model, PARAMETERS]
    call(function, t, at, at + 32, sample, parameters, at + 64)
    n0, n1, n2 = number(at, 8), number(at, 9), number(at, 10)
    o0 = data[m] * n0 + data[m + 3] * n1 + data[m + 6] * n2
    o1 = data[m + 1] * n0 + data[m + 4] * n1 + data[m + 7] * n2
    o2 = data[m + 2] * n0 + data[m + 5] * n1 + data[m + 8] * n2
    if models[model, SLIPS] != 0:
        # a slip d: L is fixed, and its components over the body axes change by L x d
        o0, o1, o2 = (
            size * (x[1] * o2 - x[2] * o1),
            size * (x[2] * o0 - x[0] * o2),
            size * (x[0] * o1 - x[1] * o0),
        )
    mean = x[0] * w[0] + x[1] * w[1] + x[2] * w[2]
    rate = ((w[0] - mean * x[0]) * o0 + (w[1] - mean * x[1]) * o1 + (w[2] - mean * x[2]) * o2) / (
        size * data[SPREAD]
    )
    if models[model, SLIPS] != 0:
        return (0.0, 0.0, 0.0), rate, size * math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    v = (
        q[2] * o2 - q[3] * o1 + q[0] * o0,
        q[3] * o0 - q[1] * o2 + q[0] * o1,
        q[1] * o1 - q[2] * o0 + q[0] * o2,
    )
    s = q[1] * o0 + q[2] * o1 + q[3] * o2
    inertial = (
        q[0] * v[0] + s * q[1] + q[2] * v[2] - q[3] * v[1],
        q[0] * v[1] + s * q[2] + q[3] * v[0] - q[1] * v[2],
        q[0] * v[2] + s * q[3] + q[1] * v[1] - q[2] * v[0],
    )
    return inertial, rate, math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)


@subroutine
def over_precession(t, x, turn, size, l0, l1, l2, data, first, model, models, work, at):
    """Means over the precession and the orbit at one l (principal axes), as `torque_at`."""
    count, epochs = models[model, PRECESSION], models[model, NODES]
    sampled = models[model, SAMPLED]
    q0 = turned_to(x, l0, l1, l2)
    o0 = o1 = o2 = g = total = 0.0
    for k in range(epochs):
        sample = work.ctypes.data + 8 * (first + k * (sampled + 1) + 1)
        when = t + work[first + k * (sampled + 1)]
        for j in range(count):
            half = math.pi * (j + turn) / count
            s = math.sin(half)
            q = product((math.cos(half), s * l0, s * l1, s * l2), q0)
            torque, rate, strength = torque_at(when, q, x, size, data, sample, model, models, at)
            o0 += torque[0]
            o1 += torque[1]
            o2 += torque[2]
            g += rate
            total += strength
    share = 1.0 / (count * epochs)
    return o0 * share, o1 * share, o2 * share, g * share, total * share


@subroutine
def over_torus(t, y, region, size, l0, l1, l2, data, first, model, models, work, at):
    """Means over nutation, precession and orbit: torque over inertial axes, and y's part."""
    h = max(abs(y - data[SEPARATRIX]), 1e-12)
    constants = theta_constants(h)
    shape = form(data, region, h)
    pq = shape[0] * shape[0] * shape[1] * shape[1]
    # nodes for 1e-6 of a torque of the degree of the model, as measured
    k = constants[0]
    other = 0.5 * math.pi / constants[2] if not constants[1] else 1e300
    degree = models[model, NUTATION]
    count = degree + int((9 + degree) * k / min(other, 10.0 * k)) if other < 1e300 else degree
    o0 = o1 = o2 = g = total = 0.0
    for j in range(count):
        u = 4.0 * k * (j + 0.5) / count
        x = direction(region, shape, jacobi(u, constants))
        # the precession is shifted from node to node, so that few nodes of both alias less
        turn = GOLDEN * j
        mean = over_precession(t, x, turn, size, l0, l1, l2, data, first, model, models, work, at)
        o0 += mean[0]
        o1 += mean[1]
        o2 += mean[2]
        g += mean[3]
        total += mean[4]
    return o0 / count, o1 / count, o2 / count, g / (count * pq), total / count


@subroutine
def rates(t, x, region, data, models, forcing, work, at, out):
    """Fill dL/dt and dy/dt (4,) for x (4,): L, y; return eps, the weakness of the torques."""
    size = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    l0, l1, l2 = x[0] / size, x[1] / size, x[2] / size
    interval, d = place(data, x[3], region)
    count = int(data[TABLE_COUNT])
    o0 = o1 = o2 = g = eps = 0.0
    for k in range(len(models)):
        kind, columns, nodes = models[k, KIND], models[k, COLUMNS], models[k, NODES]
        width = models[k, WIDTH]
        forced(t, forcing, models[k, FORCING], width, work, 0)
        if kind == TORUS:
            mean = over_torus(t, x[3], region, size, l0, l1, l2, data, 0, k, models, work, at)
            factor, strength = 1.0, 1.0
        elif kind == DRIFT:
            mean = (work[0], work[1], work[2], 0.5 * size * work[3], 0.0)
            factor, strength = 1.0, 1.0
        else:
            table = width
            interpolated(data, models[k, TABLE], columns, region, interval, d, count, work, table)
            if kind == TENSOR:
                mean = of_tensor(work, table, l0, l1, l2)
            elif kind == FRICTION:
                lost = at_size(work, table, columns, size, data, models[k, STRENGTH] + 1)
                mean = (0.0, 0.0, 0.0, -lost, lost)
            elif nodes == 1:
                mean = one_direction(data, work, table, 0, models[k, DEGREE], l0, l1, l2)
            else:
                mean = several_directions(
                    data, work, table, nodes, models[k, DEGREE], l0, l1, l2, table + columns
                )
            factor = power(size, models[k, EXPONENT])
            strength = data[models[k, STRENGTH]]
        o0 += factor * mean[0]
        o1 += factor * mean[1]
        o2 += factor * mean[2]
        g += factor * mean[3]
        eps += factor * strength * mean[4]
    out[0], out[1], out[2] = o0, o1, o2
    out[3] = 2.0 * g / size
    return eps * data[2] / (size * size)


@entry_point
def rates_at(t, x, region, data, models, forcing, work, out, repeat):
    """`rates` for Python, repeated for measurements of its time."""
    at = scratch()
    eps = 0.0
    for _ in range(repeat):
        eps = rates(t, x, region, data, models, forcing, work, at, out)
    return eps


@entry_point
def changes_on_arcs(t, x, data, models, forcing, arcs, seconds, work, out):
    """Fill the changes of y (4,) along the arcs of the separatrix (`Axes.arcs`) in one lap."""
    at = scratch()
    size = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    l0, l1, l2 = x[0] / size, x[1] / size, x[2] / size
    p = 1.0 / (1.0 + math.exp(-data[SEPARATRIX]))
    pq = p * (1.0 - p)
    out[:] = 0.0
    for k in range(len(models)):
        kind, columns, nodes = models[k, KIND], models[k, COLUMNS], models[k, NODES]
        width = models[k, WIDTH]
        forced(t, forcing, models[k, FORCING], width, work, 0)
        for arc in range(4):
            g = 0.0
            if kind == TORUS:
                for j in range(len(seconds)):
                    u = (arcs[arc, j, 0], arcs[arc, j, 1], arcs[arc, j, 2])
                    mean = over_precession(
                        t, u, 0.6 * j, size, l0, l1, l2, data, 0, k, models, work, at
                    )
                    g += mean[3] * seconds[j] / pq
            else:
                base = models[k, ARCS] + arc * columns
                for j in range(columns):
                    work[width + j] = data[base + j]
                if kind == TENSOR:
                    g = of_tensor(work, width, l0, l1, l2)[3]
                elif kind == FRICTION:
                    g = -at_size(work, width, columns, size, data, models[k, STRENGTH] + 1)
                else:
                    for q in range(nodes):
                        g += one_direction(data, work, width, 4 * q, models[k, DEGREE], l0, l1, l2)[
                            3
                        ]
                g *= power(size, models[k, EXPONENT])
            # the lap takes 1/L of the seconds at L = 1
            out[arc] += 2.0 * g / (size * size)


# ---- Integration: Dormand & Prince's pair of orders 5 and 4 with its continuous extension of
# order 4 (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, section II.6)


@subroutine
def stage(x, k, h, weights, count, out):
    """Fill x plus a combination of `count` slopes."""
    for j in range(4):
        total = 0.0
        for i in range(count):
            total += weights[i] * k[i, j]
        out[j] = x[j] + h * total


@subroutine
def at_share(row, share, out):
    """Fill the state (4,) at a share of a step."""
    remaining = 1.0 - share
    for j in range(4):
        k = ROW_TERMS + j
        a = row[k + 12] + remaining * row[k + 16]
        a = row[k + 8] + share * a
        a = row[k + 4] + remaining * a
        out[j] = row[k] + share * a


@subroutine
def keep_terms(row, x, end, k, h):
    """Fill the terms of the continuous extension of a step."""
    weights = (
        -12715105075.0 / 11282082432.0,
        0.0,
        87487479700.0 / 32700410799.0,
        -10690763975.0 / 1880347072.0,
        701980252875.0 / 199316789632.0,
        -1453857185.0 / 822651844.0,
        69997945.0 / 29380423.0,
    )
    for j in range(4):
        gain = end[j] - x[j]
        bend = h * k[0, j] - gain
        total = 0.0
        for i in range(7):
            total += weights[i] * k[i, j]
        row[ROW_TERMS + j] = x[j]
        row[ROW_TERMS + 4 + j] = gain
        row[ROW_TERMS + 8 + j] = bend
        row[ROW_TERMS + 12 + j] = gain - h * k[6, j] - bend
        row[ROW_TERMS + 16 + j] = h * total


@subroutine
def slopes(t, x, h, held, region, data, models, forcing, work, at, k, trial):
    """Fill the seven slopes (7, 4) of a step, of which the first is known; eps at its end."""
    nodes = (0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0)
    table = (
        (0.2, 0.0, 0.0, 0.0, 0.0, 0.0),
        (3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0),
        (44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0),
        (
            19372.0 / 6561.0,
            -25360.0 / 2187.0,
            64448.0 / 6561.0,
            -212.0 / 729.0,
            0.0,
            0.0,
        ),
        (
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18656.0,
            0.0,
        ),
        (35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0),
    )
    eps = 0.0
    for i in range(1, 7):
        stage(x, k, h, table[i - 1], i, trial)
        eps = rates(t + nodes[i] * h, trial, region, data, models, forcing, work, at, k[i])
        if held != 0:
            k[i, 3] = 0.0
    return eps


@subroutine
def error_of(x, k, h, tolerance):
    """The largest error of a step in units of the tolerance; NaN stays NaN."""
    size = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    weights = (
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    )
    worst = 0.0
    for j in range(4):
        total = 0.0
        for i in range(7):
            total += weights[i] * k[i, j]
        error = abs(h * total) / (tolerance * (size if j < 3 else 1.0))
        if not error <= worst:
            worst = error
    return worst


@subroutine
def event_of(t, x, held, region, limits, data, models, forcing, work, at, out):
    """Which event lies before the state, or 0: y at a limit, a hold that ends, strong torques."""
    eps = rates(t, x, region, data, models, forcing, work, at, out)
    if eps > limits[2]:
        return STRONG
    if held == 0:
        if x[3] < limits[0] or x[3] > limits[1]:
            return CLAMPED
    elif out[3] * held * limits[3] < 0.0:
        return RELEASED
    return 0


@subroutine
def event_behind(t, x, eps, held, region, limits, data, models, forcing, work, at, out):
    """`event_of` the end of a step, whose last slope gave eps."""
    if held != 0:
        return event_of(t, x, held, region, limits, data, models, forcing, work, at, out)
    if eps > limits[2]:
        return STRONG
    if x[3] < limits[0] or x[3] > limits[1]:
        return CLAMPED
    return 0


@subroutine
def located(row, status, held, region, limits, data, models, forcing, work, at, trial, other):
    """The event and the share of a step, by bisection, behind which it lies."""
    low, high = 0.0, 1.0
    t, h = row[ROW_START], row[ROW_STEP]
    for _ in range(48):
        middle = 0.5 * (low + high)
        at_share(row, middle, trial)
        when = t + middle * h
        inside = event_of(when, trial, held, region, limits, data, models, forcing, work, at, other)
        if inside != 0:
            high, status = middle, inside
        else:
            low = middle
    return status, high


@entry_point
def advance(clock, x, region, until, tolerance, limits, data, models, forcing, work, rows):
    """Integrate to an epoch or to the next event: what ended it (REACHED ...), count of the rows.

    Given and changed
        clock     (3,)  seconds; length of the next step with its sign; end at which y is held
        x         (4,)  L, y
        rows      (N, ROW_ENTRIES), filled
    Given
        region    of the state
        limits    (4,)  least and greatest y, greatest eps, sign of time
    """
    k, trial, other = np.empty((7, 4)), np.empty(4), np.empty(4)
    at = scratch()
    side = 1.0 if region >= LAM_PLUS else -1.0
    y_s, held = data[SEPARATRIX], int(clock[2])
    rates(clock[0], x, region, data, models, forcing, work, at, k[0])
    if held != 0:
        k[0, 3] = 0.0
    filled = 0
    while filled < len(rows):
        t, left = clock[0], until - clock[0]
        if left * limits[3] <= 0.0:
            return REACHED, filled
        h = clock[1] if abs(clock[1]) < abs(left) else left
        eps = slopes(t, x, h, held, region, data, models, forcing, work, at, k, trial)
        if not abs(trial[3]) <= 1e300 or not abs(eps) <= 1e300:
            return BAD, filled
        distance, before = side * (trial[3] - y_s), side * (x[3] - y_s)
        if distance < 0.0 and before > NEAREST:
            # shorter, to end close before the separatrix
            clock[1] = h * min(0.9, max(0.1, 0.98 * before / (before - distance)))
            if abs(clock[1]) > 1e-13 * (abs(t) + abs(clock[1])):
                continue
        worst = error_of(x, k, h, tolerance)
        if worst > 1.0 and distance >= 0.0:
            clock[1] = h * max(0.2, 0.9 * worst**-0.2)
            if abs(clock[1]) > 1e-13 * (abs(t) + abs(clock[1])):
                continue
        if distance < 0.0:
            return PASSAGE, filled
        row = rows[filled]
        row[ROW_START], row[ROW_STEP], row[ROW_END] = t, h, t + h
        row[ROW_REGION], row[ROW_HELD] = region, held
        keep_terms(row, x, trial, k, h)
        filled += 1
        status = event_behind(
            t + h, trial, eps, held, region, limits, data, models, forcing, work, at, other
        )
        if status != 0:
            status, high = located(
                row, status, held, region, limits, data, models, forcing, work, at, trial, other
            )
            at_share(row, high, trial)
            clock[0] = t + high * h
            row[ROW_END] = clock[0]
            for j in range(4):
                x[j] = trial[j]
            if status == CLAMPED:
                x[3] = limits[0] if x[3] < limits[0] else limits[1]
            return status, filled
        clock[0] = t + h
        for j in range(4):
            x[j], k[0, j] = trial[j], k[6, j]
        if distance < NEAREST:
            return PASSAGE, filled
        if abs(h) >= abs(clock[1]) or worst > 1.0:
            clock[1] = h * min(5.0, max(0.2, 0.9 * max(worst, 1e-10) ** -0.2))
    return FULL, filled


@entry_point
def torques_at(address, parameters, t, wxyz, omega, samples, out):
    """Fill a torque (N, 3) at times (N,), attitudes (N, 4), rates (N, 3), samples (N, C)."""
    at = scratch()
    for n in range(len(out)):
        for k in range(4):
            put(at, k, wxyz[n, k])
        for k in range(3):
            put(at, 4 + k, omega[n, k])
            put(at, 8 + k, math.nan)
        row = samples.ctypes.data + 8 * n * samples.shape[1]
        call(address, t[n], at, at + 32, row, parameters, at + 64)
        for k in range(3):
            out[n, k] = number(at, 8 + k)
    return 0
