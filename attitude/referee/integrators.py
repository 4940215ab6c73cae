"""One step of the free rotation by integrators of the literature; see `attitude.referee`.

Each takes three moments, four components of the attitude (body to inertial), three of the angular
velocity over the principal axes, and a step, as tuples, and returns attitude and angular velocity.
"""

import math

from attitude.compilation.decorators import entry_point, subroutine
from attitude.solution.given_axes import product, turned_by
from attitude.solution.step import gains, increment, pieces, rates

DLM, REICH, CELLEDONI_SAFSTROM, BUSS, RK4, EXACT = range(6)


@subroutine
def one_step(kind, moments, q, w, h):
    """One step of length h by the integrator of a number: DLM to EXACT."""
    if kind == DLM:
        return dullweber_leimkuhler_mclachlan(moments, q, w, h)
    if kind == REICH:
        return reich(moments, q, w, h)
    if kind == CELLEDONI_SAFSTROM:
        return celledoni_safstrom(moments, q, w, h)
    if kind == BUSS:
        return buss(moments, q, w, h)
    if kind == RK4:
        return runge_kutta(moments, q, w, h)
    return exact(moments, q, w, h)


@entry_point
def run(kind, moments, start, h, every, out):
    """Fill out (T, 7) with the start and the states after each `every` steps.

    kind: DLM to EXACT; moments (3,); start (7,): wxyz and angular velocity; h s.
    """
    i = moments[0], moments[1], moments[2]
    q = start[0], start[1], start[2], start[3]
    w = start[4], start[5], start[6]
    for k in range(len(out)):
        if k > 0:
            for _ in range(every):
                q, w = one_step(kind, i, q, w, h)
        for j in range(4):
            out[k, j] = q[j]
        for j in range(3):
            out[k, 4 + j] = w[j]


@subroutine
def exact(moments, q, w, h):
    """The increments of `solution.step`, without compensated summation."""
    k = gains(moments)
    count = pieces(k, w, h)
    part = h / count
    for _ in range(count):
        (s, x, y, z), d, n, _ = increment(moments, w, rates(k, w), part)
        q = product(q, (1.0 + (s + n), x, y, z))
        w = w[0] + d[0], w[1] + d[1], w[2] + d[2]
    return q, w


@subroutine
def dullweber_leimkuhler_mclachlan(moments, q, w, h):
    """The kinetic energy split by axes: turns about x, y, z, y, x.

    J. Chem. Phys. 107, 5840 (1997).
    """
    momentum = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    q, momentum = _about(0, momentum[0] / moments[0], q, momentum, 0.5 * h)
    q, momentum = _about(1, momentum[1] / moments[1], q, momentum, 0.5 * h)
    q, momentum = _about(2, momentum[2] / moments[2], q, momentum, h)
    q, momentum = _about(1, momentum[1] / moments[1], q, momentum, 0.5 * h)
    q, momentum = _about(0, momentum[0] / moments[0], q, momentum, 0.5 * h)
    return q, (momentum[0] / moments[0], momentum[1] / moments[1], momentum[2] / moments[2])


@subroutine
def reich(moments, q, w, h):
    """A symmetric top and the rest of the kinetic energy about x (1994, Physica D 76, 375)."""
    i1, i2, i3 = moments
    momentum = i1 * w[0], i2 * w[1], i3 * w[2]
    rest = 1.0 / i1 - 1.0 / i2
    q, momentum = _about(0, rest * momentum[0], q, momentum, 0.5 * h)
    # the top turns about L by |L|/I2 in space, and about its axis by the difference
    q, momentum = _turned(q, momentum, (momentum[0] / i2, momentum[1] / i2, momentum[2] / i2), h)
    q, momentum = _about(2, (1.0 / i3 - 1.0 / i2) * momentum[2], q, momentum, h)
    q, momentum = _about(0, rest * momentum[0], q, momentum, 0.5 * h)
    return q, (momentum[0] / i1, momentum[1] / i2, momentum[2] / i3)


@subroutine
def celledoni_safstrom(moments, q, w, h):
    """Exact Euler equations, attitude by a Magnus series of fourth order.

    J. Phys. A 39, 5463 (2006).
    """
    one = _rates_after(moments, w, 0.21132486540518713 * h)
    two = _rates_after(moments, w, 0.7886751345948129 * h)
    half, more = 0.5 * h, h * h * 0.14433756729740643  # sqrt(3)/12
    turn = (
        half * (one[0] + two[0]) + more * (one[1] * two[2] - one[2] * two[1]),
        half * (one[1] + two[1]) + more * (one[2] * two[0] - one[0] * two[2]),
        half * (one[2] + two[2]) + more * (one[0] * two[1] - one[1] * two[0]),
    )
    return product(q, _exponential(turn, 1.0)), _rates_after(moments, w, h)


@subroutine
def buss(moments, q, w, h):
    """Augmented second-order method, momentum fixed in space.

    J. Comput. Phys. 164, 377 (2000).
    """
    momentum = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    space = turned_by(q, momentum)
    k1, k2, k3 = gains(moments)
    # w' and the commutator w' x w of the space-fixed axes, seen from the body
    a, b, c = k1 * w[1] * w[2], k2 * w[2] * w[0], k3 * w[0] * w[1]
    half, twelfth = 0.5 * h, h * h / 12.0
    turn = (
        h * (w[0] + half * a + twelfth * (b * w[2] - c * w[1])),
        h * (w[1] + half * b + twelfth * (c * w[0] - a * w[2])),
        h * (w[2] + half * c + twelfth * (a * w[1] - b * w[0])),
    )
    q = product(q, _exponential(turn, 1.0))
    size = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    q = q[0] * size, q[1] * size, q[2] * size, q[3] * size
    m = turned_by((q[0], -q[1], -q[2], -q[3]), space)
    return q, (m[0] / moments[0], m[1] / moments[1], m[2] / moments[2])


@subroutine
def runge_kutta(moments, q, w, h):
    """The classical fourth order on quaternion and rates, the quaternion normalised."""
    k = gains(moments)
    zero = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    y = q[0], q[1], q[2], q[3], w[0], w[1], w[2]
    a = _slope(k, _ahead(y, zero, 0.0))
    b = _slope(k, _ahead(y, a, 0.5 * h))
    c = _slope(k, _ahead(y, b, 0.5 * h))
    d = _slope(k, _ahead(y, c, h))
    y = _ahead(_ahead(y, a, h / 6.0), b, h / 3.0)
    y = _ahead(_ahead(y, c, h / 3.0), d, h / 6.0)
    size = 1.0 / math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
    return (y[0] * size, y[1] * size, y[2] * size, y[3] * size), (y[4], y[5], y[6])


@subroutine
def _ahead(y, slope, h):
    """y + h slope."""
    return (
        y[0] + h * slope[0],
        y[1] + h * slope[1],
        y[2] + h * slope[2],
        y[3] + h * slope[3],
        y[4] + h * slope[4],
        y[5] + h * slope[5],
        y[6] + h * slope[6],
    )


@subroutine
def _slope(k, y):
    """The rate of change of attitude and angular velocity."""
    q = product((y[0], y[1], y[2], y[3]), (0.0, 0.5 * y[4], 0.5 * y[5], 0.5 * y[6]))
    return (
        q[0],
        q[1],
        q[2],
        q[3],
        k[0] * y[5] * y[6],
        k[1] * y[6] * y[4],
        k[2] * y[4] * y[5],
    )


@subroutine
def _rates_after(moments, w, h):
    """The angular velocity after h, exactly."""
    _, w = exact(moments, (1.0, 0.0, 0.0, 0.0), w, h)
    return w


@subroutine
def _about(axis, rate, q, momentum, h):
    """As `_turned`, about one of the principal axes."""
    v = (
        rate if axis == 0 else 0.0,
        rate if axis == 1 else 0.0,
        rate if axis == 2 else 0.0,
    )
    return _turned(q, momentum, v, h)


@subroutine
def _turned(q, momentum, rate, h):
    """Attitude and momentum over body axes after a turn at a constant rate, the momentum fixed."""
    turn = _exponential(rate, h)
    back = turn[0], -turn[1], -turn[2], -turn[3]
    return product(q, turn), turned_by(back, momentum)


@subroutine
def _exponential(v, h):
    """The quaternion of a turn by h |v| about v."""
    size = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if size == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    sine = math.sin(0.5 * h * size) / size
    return math.cos(0.5 * h * size), sine * v[0], sine * v[1], sine * v[2]
