"""Euler's equations step by step in 160 bits: periods as one would measure them.

Power series in time of the angular velocity and of the quaternion, summed in whole numbers of
2^-160: no elliptic function and nothing of the package is used.
"""

import math
from fractions import Fraction
from operator import mul

_BITS = 160
_ORDER = 40
_UNIT = 1 << _BITS


def measured(moments, omega, turns=20):
    """Period of the middle rate, and the turn of the body about the momentum in `turns` of them.

    Parameters
    ----------
    moments, omega : three floats each
        A tumbling state, not on the separatrix.

    Returns
    -------
    period : Fraction
        s, between two passages of the middle component through zero, `turns` apart, over `turns`.
    turned : float
        The body's turn about its momentum between them, as a part of a whole turn, in [0, 1).
    """
    middle = sorted(range(3), key=lambda k: moments[k])[1]
    steps = _steps(moments, omega)
    passages = []
    while len(passages) < turns + 1:
        start, length, w, q = next(steps)
        at = _upward(w[middle], length)
        if at is not None:
            passages.append((start + at, [_value(each, at) for each in (*w, *q)]))
    (first, before), (last, after) = passages[0], passages[-1]
    return Fraction(last - first, turns * _UNIT), _turn(moments, before, after)


def state(moments, omega, t):
    """Quaternion, 1 at the start, and rates after t > 0 seconds: seven Fractions."""
    wanted = int(Fraction(t) * _UNIT)
    for start, length, w, q in _steps(moments, omega):
        if wanted <= start + length:
            return [Fraction(_value(each, wanted - start), _UNIT) for each in (*q, *w)]
    raise AssertionError("steps go on for ever")


def _steps(moments, omega):
    """For ever: start, length, series of three rates and four components of the quaternion."""
    i = [Fraction(each) for each in moments]
    factors = [int((i[j] - i[k]) / i[n] * _UNIT) for n, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))]
    fastest = max(map(abs, omega)) * max(moments) / min(moments)
    length = int(Fraction(0.4 / fastest) * _UNIT)
    w = [int(Fraction(each) * _UNIT) for each in omega]
    q = [_UNIT, 0, 0, 0]
    start = 0
    while True:
        ws, qs = [[each] for each in w], [[each] for each in q]
        for n in range(_ORDER):
            for k, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
                rate = _product(ws[a], ws[b], n)
                ws[k].append((factors[k] * rate >> _BITS) // (n + 1))
            x, y, z = ws
            changes = (
                -_product(qs[1], x, n) - _product(qs[2], y, n) - _product(qs[3], z, n),
                _product(qs[0], x, n) + _product(qs[2], z, n) - _product(qs[3], y, n),
                _product(qs[0], y, n) + _product(qs[3], x, n) - _product(qs[1], z, n),
                _product(qs[0], z, n) + _product(qs[1], y, n) - _product(qs[2], x, n),
            )
            for k, change in enumerate(changes):
                qs[k].append(change // (2 * (n + 1)))
        yield start, length, ws, qs
        start += length
        w, q = [_value(each, length) for each in ws], [_value(each, length) for each in qs]


def _product(a, b, n):
    """Coefficient n of the product of two series."""
    return sum(map(mul, a[: n + 1], b[n::-1])) >> _BITS


def _value(series, t):
    total = 0
    for each in reversed(series):
        total = each + (total * t >> _BITS)
    return total


def _upward(series, length):
    """When the series passes zero upwards within the step, by bisection; or None."""
    if not _value(series, 0) < 0 <= _value(series, length):
        return None
    low, high = 0, length
    while high - low > 1:
        half = (low + high) // 2
        low, high = (half, high) if _value(series, half) < 0 else (low, half)
    return high


def _turn(moments, before, after):
    """From the quaternions and the momentum (w, x, y, z after the rates)."""
    w0, q0 = before[:3], [each / _UNIT for each in before[3:]]
    q1 = [each / _UNIT for each in after[3:]]
    a, b, c, d = q0
    inverse = (a, -b, -c, -d)
    relative = _quaternion_product(q1, inverse)
    momentum = [i * (w / _UNIT) for i, w in zip(moments, w0, strict=True)]
    turned = _quaternion_product(_quaternion_product(q0, (0.0, *momentum)), inverse)[1:]
    size = math.hypot(*turned)
    along = sum(map(mul, relative[1:], turned)) / size
    return 2.0 * math.atan2(along, relative[0]) / (2.0 * math.pi) % 1.0


def _quaternion_product(p, q):
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )
