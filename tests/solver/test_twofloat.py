"""Error-free transforms, pairs of doubles and expansions, against exact fractions."""

import math
from fractions import Fraction
from random import Random

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from attitude._compilation.instructions import fma, rint
from attitude._solver import codes, twofloat
from tests.support.states import constants_of

U = Fraction(1, 2**53)

# ---- called from Python ------------------------------------------------------------------------


@numba.njit(error_model="numpy")
def _door(name, a, b):
    """One operation of two pairs as a pair; the name is a small whole number."""
    if name == 0:
        return twofloat.add(a, b)
    if name == 1:
        return twofloat.sub(a, b)
    if name == 2:
        return twofloat.mul(a, b)
    if name == 3:
        return twofloat.div(a, b)
    if name == 4:
        return twofloat.scale(a, b[0])
    if name == 5:
        return twofloat.square(a)
    if name == 6:
        return twofloat.sqrt(a)
    if name == 7:
        return twofloat.two_sum(a[0], b[0])
    if name == 8:
        return twofloat.two_prod(a[0], b[0])
    if name == 9:
        return twofloat.neg(a)
    if name == 10:
        return twofloat.absolute(a)
    return fma(a[0], b[0], a[1]), rint(a[0])


ADD, SUB, MUL, DIV, SCALE, SQUARE, SQRT, TWO_SUM, TWO_PROD, NEG, ABSOLUTE, FMA = range(12)


@numba.njit(error_model="numpy")
def _compare(a, b):
    return twofloat.less(a, b), twofloat.same(a, b)


def _value(pair):
    return Fraction(pair[0]) + Fraction(pair[1])


def _pair(value):
    """A fraction as a pair of doubles."""
    hi = float(value)
    return hi, float(value - Fraction(hi))


_double = st.builds(
    math.ldexp,
    st.one_of(st.floats(0.5, 1, exclude_max=True), st.floats(-1, -0.5, exclude_min=True)),
    st.integers(-120, 120),
)
_parts = st.integers(-(2**51) + 1, 2**51 - 1)  # of an ulp, 2^-52 each: no underflow
_pairs = st.builds(
    lambda hi, share: (hi, math.ldexp(share, -52) * math.ulp(hi)), _double, _parts
).map(lambda pair: _pair(_value(pair)))


# ---- error-free ---------------------------------------------------------------------------------


@given(_double, _double)
def test_two_sum_is_exact(a, b):
    s, e = _door(TWO_SUM, (a, 0.0), (b, 0.0))
    assert s == a + b and _value((s, e)) == Fraction(a) + Fraction(b)


@given(_double, _double)
def test_two_prod_is_exact(a, b):
    p, e = _door(TWO_PROD, (a, 0.0), (b, 0.0))
    assert p == a * b and _value((p, e)) == Fraction(a) * Fraction(b)


@given(_double, _double, _double)
def test_fma_rounds_once(a, b, c):
    found, _ = _door(FMA, (a, c), (b, 0.0))
    assert found == float(Fraction(a) * Fraction(b) + Fraction(c))


@given(st.floats(-(2.0**53), 2.0**53))
def test_rint_is_the_nearest_even(x):
    assert _door(FMA, (x, 0.0), (0.0, 0.0))[1] == np.rint(x)


# ---- pairs --------------------------------------------------------------------------------------


def _close(pair, exact, bound):
    assert abs(pair[1]) <= 0.5 * math.ulp(pair[0])  # a pair again
    assert abs(_value(pair) - exact) <= bound * U * U * abs(exact)


@given(_pairs, _pairs)
def test_sum(a, b):
    """3 u^2 and a little, whatever the signs and however much cancels."""
    _close(_door(ADD, a, b), _value(a) + _value(b), Fraction(301, 100))


@given(_pairs, st.integers(-3, 3), st.floats(-1, 1))
def test_difference_of_neighbours(a, steps, share):
    """Pairs that agree in all but the last places."""
    hi = a[0] + steps * math.ulp(a[0])
    b = _pair(Fraction(hi) + Fraction(0.499 * math.ulp(hi) * share))
    _close(_door(SUB, a, b), _value(a) - _value(b), Fraction(301, 100))


@given(_pairs, _pairs)
def test_product(a, b):
    _close(_door(MUL, a, b), _value(a) * _value(b), 6)


@given(_pairs, _pairs)
def test_quotient(a, b):
    _close(_door(DIV, a, b), _value(a) / _value(b), 15)


@given(_pairs, _double)
def test_product_with_a_double(a, x):
    _close(_door(SCALE, a, (x, 0.0)), _value(a) * Fraction(x), 4)


@given(_pairs)
def test_square(a):
    _close(_door(SQUARE, a, a), _value(a) ** 2, 6)


@given(_pairs)
def test_square_root(a):
    """Squared again it is a, to twice the error of the root."""
    a = _door(ABSOLUTE, a, a)
    root = _door(SQRT, a, a)
    assert abs(root[1]) <= 0.5 * math.ulp(root[0])
    assert abs(_value(root) ** 2 - _value(a)) <= 2 * 4 * U * U * _value(a)


def test_square_root_of_nothing():
    for zero in ((0.0, 0.0), (-0.0, 0.0), (-1e-300, 0.0)):
        assert _door(SQRT, zero, zero) == (0.0, 0.0)


@given(_pairs, _pairs)
def test_sign_and_order(a, b):
    assert _value(_door(NEG, a, a)) == -_value(a)
    assert _value(_door(ABSOLUTE, a, a)) == abs(_value(a))
    for one, two in ((a, b), (a, a), (a, (a[0], math.nextafter(a[1], math.inf)))):
        assert _compare(one, two) == (_value(one) < _value(two), _value(one) == _value(two))


@pytest.mark.parametrize(("pair", "name"), [(twofloat.HALF_PI, "half"), (twofloat.TWO_PI, "two")])
def test_pi(pair, name):
    from mpmath import mp, mpf

    with mp.workdps(60):
        exact = mp.pi * {"half": mpf(1) / 2, "two": 2}[name]
        assert abs(mpf(pair[0]) + mpf(pair[1]) - exact) < 1e-32 * exact


# ---- expansions ---------------------------------------------------------------------------------


@numba.njit(error_model="numpy")
def _sum_of(terms, row):
    n = 0
    for x in terms:
        n = twofloat.added(row, n, x)
    return n, twofloat.rounded(row, n)


@numba.njit(error_model="numpy")
def _products_of(factors, row):
    n = 0
    for w, x, y, z in factors:
        n = twofloat.product_added(row, n, w, x, y, z)
    return n


def _exact(row):
    return sum(map(Fraction, row), Fraction(0))


@given(st.lists(_double, min_size=1, max_size=12), st.booleans())
def test_a_sum_of_doubles_is_exact(terms, cancel):
    """Also where all but the last bits of it cancel."""
    if cancel:
        terms += [-x for x in terms[:-1]] + [math.ldexp(terms[0], -100)]
    row = np.empty(2 * len(terms))
    n, rounded = _sum_of(np.array(terms), row)
    exact = _exact(terms)
    assert _exact(row[:n]) == exact
    assert np.all(np.diff(np.abs(row[:n])) > 0) and np.all(row[:n] != 0.0)
    assert abs(_value(rounded) - exact) <= 8 * U * U * abs(exact)


@given(st.lists(st.tuples(*[_double] * 4), min_size=1, max_size=4))
def test_a_sum_of_products_of_four_doubles_is_exact(factors):
    row = np.empty(64)
    n = _products_of(np.array(factors), row)
    exact = sum(math.prod(map(Fraction, each)) for each in factors)
    assert _exact(row[:n]) == exact


def test_the_difference_that_decides_the_regime_is_exact():
    """D2 of 2 5 6 at equal rates is 0, and of the next doubles what it is, not a rounding of it."""
    random = Random(7)
    bodies = [sorted(random.uniform(1, 1.9) for _ in range(3)) for _ in range(300)]
    omega = np.zeros((301, 3, 2))
    moments = np.zeros((301, 3, 2))
    moments[:, :, 0] = [*bodies, (2.0, 5.0, 6.0)]
    omega[:, :, 0] = (1.0, 0.4, 1.0)
    for k, (a, b, d) in enumerate(bodies):
        balance = math.sqrt(a * (b - a) / (d * (d - b)))
        omega[k, 2, 0] = balance + random.randint(-2, 2) * math.ulp(balance)
    identity = np.tile((1.0, 0.0, 0.0, 0.0), (301, 1))
    for c in constants_of(moments, identity, omega, identity[:1]):
        (a, b, d), (wa, _, wd) = map(_value, c["moments"]), map(_value, c["omega"])
        exact = abs(d * (d - b) * wd**2 - a * (b - a) * wa**2)
        assert abs(abs(_value(c["d2"])) - exact) <= 8 * U * U * exact
    assert c["mode"] == codes.SEPARATRIX and exact == 0
