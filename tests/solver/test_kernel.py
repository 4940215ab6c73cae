"""The polynomials and bit tricks of the loops over epochs, against mpmath."""

import math

import numba
import numpy as np
import pytest
from mpmath import mp, mpf

from attitude._solver.series import LONGEST, exp2_of_minus, negated_if_odd, phase, sincos

U = 2.0**-53


@numba.njit(error_model="numpy")
def _sincos(s, lo):
    out = np.empty((2, len(s)))
    for i in range(len(s)):
        out[0, i], out[1, i] = sincos(s[i], lo[i])
    return out


@numba.njit(error_model="numpy")
def _exp2(a):
    out = np.empty(len(a))
    for i in range(len(a)):
        out[i] = exp2_of_minus(a[i])
    return out


@numba.njit(error_model="numpy")
def _phase(rate, start, t, t_low, winds):
    return phase(rate[0], rate[1], start[0], start[1], t, t_low, winds)


@numba.njit(error_model="numpy")
def _negated(x, n):
    return negated_if_odd(x, n)


def _around(values):
    """Each value with its neighbours, on both sides."""
    near = [np.asarray(values, dtype=float)]
    for direction in (-np.inf, np.inf):
        one = np.nextafter(near[0], direction)
        near += [one, np.nextafter(one, direction)]
    return np.concatenate(near)


# ---- sine and cosine of turns ------------------------------------------------------------------


def _check_sincos(s, lo, bound):
    found = _sincos(s, lo)
    with mp.workdps(40):
        for k in range(len(s)):
            turns = 2 * (mpf(float(s[k])) + mpf(float(lo[k])))
            exact = mp.sinpi(turns), mp.cospi(turns)
            assert abs(found[0, k] - exact[0]) <= bound, (s[k], lo[k])
            assert abs(found[1, k] - exact[1]) <= bound, (s[k], lo[k])


def test_sine_and_cosine_at_random():
    """1.1 units of the last place of 1: the rounding of the result, and a little."""
    s = np.random.default_rng(1).uniform(-0.75, 0.75, 3000)
    _check_sincos(s, np.zeros_like(s), 1.1 * U)


def test_sine_and_cosine_at_the_joints():
    """Every eighth of a turn, where quadrants and polynomials change, and the doubles around."""
    s = _around(np.arange(-24, 25) / 8)
    _check_sincos(s, np.zeros_like(s), 1.1 * U)


def test_sine_and_cosine_of_two_doubles():
    """The second double moves them as the first would."""
    rng = np.random.default_rng(2)
    s = rng.uniform(-0.75, 0.75, 1000)
    lo = rng.uniform(-0.5, 0.5, 1000) * np.spacing(s)
    _check_sincos(s, lo, 1.6 * U)


def test_small_angles_keep_their_relative_accuracy():
    s = 10.0 ** np.random.default_rng(3).uniform(-300, -2, 500)
    sine = _sincos(s, np.zeros_like(s))[0]
    with mp.workdps(40):
        for x, found in zip(s.tolist(), sine.tolist(), strict=True):
            assert abs(found / mp.sinpi(2 * mpf(x)) - 1) < 3 * U


def test_quarter_turns_are_exact():
    found = _sincos(np.arange(-8, 9) / 4, np.zeros(17))
    assert set(np.abs(found).ravel()) == {0.0, 1.0}
    assert np.array_equal(found[0][8:13], [0.0, 1.0, 0.0, -1.0, 0.0])
    assert np.array_equal(found[1][8:13], [1.0, 0.0, -1.0, 0.0, 1.0])


def test_nan_turns():
    assert np.isnan(_sincos(np.array([np.nan, np.inf]), np.zeros(2))).all()


# ---- powers of two -----------------------------------------------------------------------------


def test_powers_of_two():
    """Relative 1e-16 and a little: at random, at whole and half numbers and around them."""
    rng = np.random.default_rng(4)
    a = np.concatenate(
        [
            rng.uniform(0, 4, 1500),
            rng.uniform(0, 1000, 1500),
            10.0 ** rng.uniform(-300, 0, 200),
            np.abs(_around(np.arange(1, 60) / 2)),
            [0.0, 1000.0],
        ]
    )
    found = _exp2(a)
    with mp.workdps(40):
        for x, y in zip(a.tolist(), found.tolist(), strict=True):
            assert abs(y / mp.power(2, -mpf(x)) - 1) < 1.2e-16 * 1.5


def test_powers_of_two_where_nothing_is_left():
    found = _exp2(np.array([1000.0, 1001.0, 1e9, 1e300, np.inf]))
    assert np.all((found >= 0.0) & (found <= 2.0**-1000))
    assert np.isnan(_exp2(np.array([np.nan]))).all()
    assert _exp2(np.array([0.0, 1.0, 2.0, 10.0])).tolist() == [1.0, 0.5, 0.25, 2.0**-10]


# ---- phases ------------------------------------------------------------------------------------


def _two(value):
    hi = float(value)
    return hi, float(value - mpf(hi))


@pytest.mark.parametrize("turns", [0.1, 3.0, 1e3, 1e6, 1e9, 1e12, 1e15, LONGEST])
def test_phases_keep_their_fraction(turns):
    """rate t + start less its whole turns: 1e-16 of a turn to 1e15 turns, 1e-14 at the end."""
    rng = np.random.default_rng(5)
    with mp.workdps(60):
        for _ in range(200):
            rate = _two(mpf(rng.uniform(0.1, 1)) + mpf(rng.uniform(-1, 1)) * mpf(2) ** -60)
            start = _two(mpf(rng.uniform(-0.5, 0.5)) + mpf(rng.uniform(-1, 1)) * mpf(2) ** -60)
            t = float(rng.choice([-1, 1]) * turns / rate[0] * rng.uniform(0.9, 0.999))
            t_low = float(rng.uniform(-0.5, 0.5) * np.spacing(t))
            s, lo, parity = _phase(rate, start, t, t_low, 1.0)
            exact = sum(map(mpf, rate)) * (mpf(t) + mpf(t_low)) + sum(map(mpf, start))
            rest = exact - (mpf(s) + mpf(lo))
            whole = mp.nint(rest)
            assert abs(s) <= 0.75
            assert abs(rest - whole) < (1e-16 if turns <= 1e15 else 1e-14)
            assert int(parity - whole) % 2 == 0


def test_a_phase_that_does_not_return():
    """winds = 0 keeps whole turns: on the exact separatrix."""
    s, lo, parity = _phase((3.0, 0.0), (0.25, 0.0), 7.0, 0.0, 0.0)
    assert (s + lo, parity) == (21.25, 0.0)


@pytest.mark.parametrize("n", [0.0, 1.0, 2.0, -1.0, -3.0, 7.0, -8.0, 2.0**40, 2.0**40 + 1])
def test_signs_by_parity(n):
    for x in (1.5, -1.5, 0.0):
        expected = -x if n % 2 else x
        found = _negated(x, n)
        assert found == expected and math.copysign(1, found) == math.copysign(1, expected)
