"""Compiled two-body motion along any conic, from the time of pericentre.

With the universal variable s (ds = dt / r), k = GM, q the pericentre distance, e the eccentricity
and b = k (1 - e) / q, Kepler's equation for all conics is

    t = q s + k e s^3 c3(b s^2),

and in the plane of the orbit, x towards the pericentre,

    x = q - k s^2 c2,   y = sqrt(k q (1 + e)) s c1,   r = q + k e s^2 c2,

c1, c2, c3 being Stumpff's functions of b s^2.  No term cancels near the parabola or near the
pericentre, where E - e sin E would.

Source: Stumpff (1959); Danby, Fundamentals of Celestial Mechanics (1988), section 6.9.
"""

import math

from attitude.compilation.decorators import quickly_compiled, subroutine
from attitude.compilation.instructions import fma
from attitude.solution.twofloat import two_sum

# Below this |z| Stumpff's series is summed; above, their closed forms lose less than 3 bits.
_SERIES = 1.0
# Bisection of the bracket alone needs 64 steps at most; Newton's method mostly needs 4.
_MOST_STEPS = 100


@subroutine
def _stumpff(z):
    """c1, c2, c3 of z."""
    if abs(z) < _SERIES:
        # z^n / (2n + 2)! and / (2n + 3)!: ten terms leave 2e-21 at |z| = 1.
        c2 = c3 = 0.0
        for n in range(9, -1, -1):
            c2 = (1.0 - z * c2) / ((2.0 * n + 1.0) * (2.0 * n + 2.0))
            c3 = (1.0 - z * c3) / ((2.0 * n + 2.0) * (2.0 * n + 3.0))
        return 1.0 - z * c3, c2, c3
    if z > 0.0:
        root = math.sqrt(z)
        sine, half = math.sin(root), math.sin(0.5 * root)
        return sine / root, 2.0 * half * half / z, (root - sine) / (root * z)
    root = math.sqrt(-z)
    sine, half = math.sinh(root), math.sinh(0.5 * root)
    return sine / root, 2.0 * half * half / -z, (sine - root) / (root * -z)


@subroutine
def _solve(t, q, e, k, b):
    """The universal variable s >= 0 of a time t >= 0 since the pericentre."""
    if t == 0.0:
        return 0.0
    # The distance grows from q on, so s <= t / q.  On a closed orbit s is at most that of half a
    # revolution; on an open one s^3 k e / 6 <= t (c3 >= 1/6).
    high = t / q
    if b > 0.0:
        high = min(high, math.pi / math.sqrt(b) * (1.0 + 1e-15))
    elif e > 0.0:
        high = min(high, (6.0 * t / (k * e)) ** (1.0 / 3.0))
    low, s = 0.0, high
    for _ in range(_MOST_STEPS):
        c1, c2, c3 = _stumpff(b * s * s)
        excess = fma(k * e * s * s, s * c3, q * s - t)
        if excess > 0.0:
            high = s
        else:
            low = s
        r = fma(k * e, s * s * c2, q)
        # Newton's step, corrected by the second derivative (Halley).
        step = excess / r
        step = excess / (r - 0.5 * step * k * e * s * c1)
        new = s - step
        if not (low <= new <= high):
            new = 0.5 * (low + high)
        if abs(new - s) <= 2.3e-16 * s:
            return new
        s = new
    return s


@quickly_compiled
def states(hi, lo, base_hi, base_lo, period, q, e, k, basis, position, velocity):
    """Fill position and velocity (3, N), m and m/s, at epochs hi (N,) + lo (N,) or (1,) seconds.

    The pericentre is base_hi + base_lo seconds before the instant from which hi and lo count;
    period is inf for open orbits; basis (2, 3) holds the unit vectors towards the pericentre and
    90 deg on.
    """
    b = k * (1.0 - e) / q
    across = math.sqrt(k * q * (1.0 + e))
    step = 0 if lo.size == 1 else 1
    for n in range(hi.size):
        t, rest = two_sum(base_hi, hi[n])
        rest += base_lo + lo[n * step]
        if period < math.inf:
            turns = math.floor((t + rest) / period + 0.5)
            t = fma(-turns, period, t)
        t += rest
        s = math.copysign(_solve(abs(t), q, e, k, b), t)
        c1, c2, _ = _stumpff(b * s * s)
        x, y = q - k * s * s * c2, across * s * c1
        r = fma(k * e, s * s * c2, q)
        # dx/ds = -k s c1 and dy/ds = across c0, with c0 = 1 - z c2.
        vx, vy = -k * s * c1 / r, across * (1.0 - b * s * s * c2) / r
        for axis in range(3):
            position[axis, n] = x * basis[0, axis] + y * basis[1, axis]
            velocity[axis, n] = vx * basis[0, axis] + vy * basis[1, axis]
