"""Elementary functions of SIMD vectors against 40 digits, compiled and in Python."""

import math

import numpy as np
import pytest
from mpmath import mp

from attitude._compilation.decorators import reduction
from attitude._compilation.elementary import (
    binary_logarithm,
    cosine_and_sine,
    power_of_half,
    share_of_half_turn,
)
from attitude._compilation.simd import eight, put_eight

rng = np.random.default_rng(6)


@reduction
def powers(values, out):
    for i in range(0, values.size, 8):
        put_eight(out, i, power_of_half(eight(values, i)))


@reduction
def shares(values, out):
    for i in range(0, values.size, 8):
        put_eight(out, i, share_of_half_turn(eight(values, i)))


@reduction
def logarithms(values, out):
    for i in range(0, values.size, 8):
        put_eight(out, i, binary_logarithm(eight(values, i)))


SMALL = rng.uniform(0.0, 1.0, 400) ** 3
CASES = {
    "powers": (powers, np.concatenate([SMALL, 60.0 * SMALL, 999.0 * SMALL]), 3e-15, 3e-16),
    "shares": (shares, np.concatenate([SMALL, [0.0, 1.0, 1e-9, 0.5], SMALL[:4]]), 8e-15, 0),
    "logarithms": (
        logarithms,
        np.concatenate([SMALL + 1e-9, 1.0 + 1e-6 * SMALL, 1.0 - 1e-6 * SMALL, 1e-300**SMALL]),
        4e-16,
        0,
    ),
}  # fmt: skip


def exact(name, x):
    if name == "powers":
        return mp.mpf(2) ** -x
    return 2 / mp.pi * mp.atan(x) if name == "shares" else mp.log(x, 2)


@pytest.mark.parametrize("name", CASES)
def test_elementary_functions_to_40_digits(name):
    """Relative errors: the bound that each function states."""
    function, given, relative, growth = CASES[name]
    out, in_python = np.empty_like(given), np.empty_like(given)
    function(given, out)
    function.py_func(given, in_python)
    with mp.workdps(40):
        for x, compiled, python in zip(given, out, in_python, strict=True):
            want = exact(name, mp.mpf(float(x)))
            bound = (relative + growth * x) * abs(want)
            assert abs(mp.mpf(float(compiled)) - want) <= bound, (x, compiled)
            assert abs(mp.mpf(float(python)) - want) <= bound, (x, python)


def test_powers_of_large_numbers_are_nothing():
    out = np.empty(8)
    powers(np.array([1000.0, 1001.0, 1e9, 1e300, np.inf, 1022.0, 5e4, 2e3]), out)
    assert np.all((out > 0.0) & (out < 1e-300))


@reduction
def turned(values, cosines, sines):
    for i in range(0, values.size, 8):
        c, s = cosine_and_sine(eight(values, i))
        put_eight(cosines, i, c)
        put_eight(sines, i, s)


def test_cosine_and_sine_of_turns():
    """Also of many turns, whose whole part is removed exactly."""
    given = np.concatenate([np.linspace(-1.0, 1.0, 4096), 1e6 + np.arange(64) / 64.0])
    cosines, sines = np.empty(given.size), np.empty(given.size)
    turned(given, cosines, sines)
    exact = 2.0 * math.pi * (given - np.rint(given))
    assert cosines == pytest.approx(np.cos(exact), abs=2e-13)
    assert sines == pytest.approx(np.sin(exact), abs=2e-13)
