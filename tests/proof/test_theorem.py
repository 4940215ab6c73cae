"""Theorem 1 of docs/proof.md: how far roundings turn what the loops over epochs compute.

For all bodies, and epochs up to 1e15 turns: the package's own source is traced, every rounding is
bounded over boxes that cover all bodies and phases, and the machine code has the traced operations.
"""

import itertools
import math
import re
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

from attitude._compilation import decorators
from attitude._solver import codes, kernel, series
from attitude._solver.records import CONSTANTS
from attitude.proof import _error_bound
from tests.support import loop_bounds, rounding_bounds, traced

flint = pytest.importorskip("flint", reason="python-flint is not installed")

# Rotation angles, rad.
TRIGONOMETRIC = 2.70e-15
HYPERBOLIC = 2.99e-15
UNIFORM = 0.90e-15

U = 2.0**-53


def test_uniform_loop():
    assert 0.8e-15 < loop_bounds.uniform() <= UNIFORM


def test_trigonometric_loop():
    assert 2.0e-15 < loop_bounds.trigonometric() <= TRIGONOMETRIC


def test_hyperbolic_loop():
    assert 2.0e-15 < loop_bounds.hyperbolic() <= HYPERBOLIC


def test_the_package_uses_these_bounds():
    stated = {
        codes.UNIFORM: UNIFORM,
        codes.TRIGONOMETRIC: TRIGONOMETRIC,
        codes.HYPERBOLIC: HYPERBOLIC,
    }
    assert stated == _error_bound.LOOPS


def test_how_fast_the_pairs_turn():
    """Constants of `error_bound`: for all bodies and phases, and not much too large."""
    assert 2.2 < loop_bounds.turn_per_radian() <= _error_bound.PER_RADIAN
    assert 2.0 < loop_bounds.turn_per_y() <= _error_bound.PER_Y
    assert 1.0 < loop_bounds.turn_per_nome() <= _error_bound.PER_NOME


def test_how_fast_the_pairs_of_the_package_turn():
    """Differences of its own pairs at random bodies and phases: near the proved constants."""
    random = np.random.default_rng(7)
    found = {"radian": 0.0, "y": 0.0, "nome": 0.0}
    rho, shrunk = random.uniform(0.5, 1.0, 1500), random.uniform(0.0, 0.6, 1500)
    inside = rho**4 * shrunk**2 <= math.exp(-math.pi)
    for rows in loop_bounds.coefficients_of(rho[inside], shrunk[inside]):
        v = random.uniform(0.0, 1.6) * random.choice((0.0, 1.0))
        pairs = [
            series.trigonometric_pair(*rows, math.sin(v + h), math.cos(v + h)) for h in (0.0, 1e-6)
        ]
        found["radian"] = max(found["radian"], 2e6 * _between(*pairs))
    for _ in range(1500):
        nome, d = math.exp(-math.pi) * random.uniform(), random.uniform(0.0, math.pi / 4)
        y = -0.5 * math.log(nome) * random.choice((0.0, random.uniform(), 1.0))
        alpha = [
            [nome ** (n * n) * f((2 * n + 1) * d) for n in range(4)] for f in (math.cos, math.sin)
        ]
        one, two, three = (
            series.hyperbolic_pair(alpha, 1.0, 1.0, 0.0, (e, q / e, q * e))
            for e, q in (
                (math.exp(-2 * y), nome),
                (math.exp(-2 * y - 2e-6), nome),
                (math.exp(-2 * y), nome * (1.0 + 1e-6)),
            )
        )
        found["y"] = max(found["y"], 2e6 * _between(one, two))
        found["nome"] = max(found["nome"], 1e6 * _between(one, three) / nome)
    assert 2.0 < found["radian"] <= _error_bound.PER_RADIAN
    assert 1.9 < found["y"] <= _error_bound.PER_Y
    assert 0.9 < found["nome"] <= _error_bound.PER_NOME


def _between(p, q):
    """The angle on S3 between two small-angle neighbours of any length."""
    p, q = (np.array(x) / np.linalg.norm(x) for x in (p, q))
    return float(np.linalg.norm(p - q * (p @ q)))


@pytest.mark.slow
def test_finer_boxes_lower_the_bounds():
    coarse = loop_bounds.trigonometric(16, 16, 32), loop_bounds.hyperbolic(24, 49, 24)
    usual = loop_bounds.trigonometric(), loop_bounds.hyperbolic()
    fine = loop_bounds.trigonometric(48, 48, 96), loop_bounds.hyperbolic(64, 129, 64)
    assert fine[0] < usual[0] < coarse[0] and fine[1] < usual[1] < coarse[1]


# ---- The boxes' premises


def _largest_error(polynomial, function, half_width, degree=24, pieces=1024):
    """An upper bound of |polynomial - function| on [-half_width, half_width], by Taylor series.

    The polynomial's degree is below `degree`; the rest of the function's series is at most
    (2 pi h)^degree / degree! on pieces of half the width h, which are narrow towards the ends.
    """
    ends = (half_width * -np.cos(np.linspace(0.0, np.pi, pieces + 1))).tolist()
    worst = 0.0
    with flint.ctx.workprec(200):
        flint.ctx.cap = degree
        for low, high in itertools.pairwise(ends):
            h = (flint.arb(high) - flint.arb(low)) / 2
            x = flint.arb_series([(flint.arb(high) + flint.arb(low)) / 2, 1], degree)
            difference = polynomial(x) - function(x)
            terms = [abs(difference[n]) * h**n for n in range(degree)]
            terms.append((2 * flint.arb.pi() * h) ** degree / math.factorial(degree))
            worst = max(worst, float(sum(terms, flint.arb(0)).upper()))
    return worst


def _named(prefix, numbers):
    return [flint.arb(getattr(series, f"{prefix}{n}")) for n in numbers]


def test_errors_of_the_polynomials():
    with flint.ctx.workprec(200):
        odd, even = _named("_SIN_", range(3, 14, 2)), _named("_COS_", range(2, 15, 2))
        powers = _named("_EXP_", range(1, 12))
        first = flint.arb(series._SIN_1) + flint.arb(series._SIN_1_LOW)
        two_pi, ln2 = 2 * flint.arb.pi(), flint.arb(2).log()

    def sine(x):
        return x * first + sum((c * x ** (2 * n + 3) for n, c in enumerate(odd)), 0 * x)

    def cosine(x):
        return 1 + sum((c * x ** (2 * n + 2) for n, c in enumerate(even)), 0 * x)

    def power(x):
        return 1 + sum((c * x ** (n + 1) for n, c in enumerate(powers)), 0 * x)

    assert _largest_error(sine, lambda x: (two_pi * x).sin(), 0.125) <= loop_bounds.SINE
    assert _largest_error(cosine, lambda x: (two_pi * x).cos(), 0.125) <= loop_bounds.COSINE
    assert _largest_error(power, lambda x: (-ln2 * x).exp(), 0.5) <= loop_bounds.EXP2


def test_a_wrong_digit_of_a_polynomial_shows(monkeypatch):
    monkeypatch.setattr(series, "_SIN_5", 81.60524927591203)  # the twelfth digit
    with pytest.raises(AssertionError):
        test_errors_of_the_polynomials()


def test_roundings_of_the_phase():
    """`phase` errs by at most 7 u^2 a turn and 4 u^2; |lo| stays below 2^-53 up to 1e15 turns."""
    random = np.random.default_rng(3)
    worst = 0.0
    for _ in range(4000):
        rate = random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-6, 3)
        turns = random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-3, 15)
        t = turns / rate
        t_low = random.uniform(-0.5, 0.5) * np.spacing(t)
        rate_low = random.uniform(-0.5, 0.5) * np.spacing(rate)
        start = random.uniform(-0.5, 0.5)
        start_low = random.uniform(-0.5, 0.5) * np.spacing(start)
        numbers = [float(x) for x in (rate, rate_low, start, start_low, t, t_low)]
        s, lo, _ = series.phase(*numbers, 1.0)
        a, b, c, d, e, f = map(Fraction, numbers)
        exact = (a + b) * (e + f) + c + d
        off = exact - Fraction(float(s)) - Fraction(float(lo))
        off -= round(off)
        assert abs(lo) <= 2.0**-53 and abs(s) <= 0.5
        worst = max(worst, abs(float(off)) / (7.0 * U * U * abs(turns) + 4.0 * U * U))
    assert 0.01 < worst <= 1.0


_TURNED = [
    ("neg", (1,)),
    ("mul", (6, 4)),
    ("fma", (0, 5, 7)),
    ("mul", (0, 4)),
    ("fma", (1, 5, 9)),
    ("neg", (3,)),
    ("mul", (11, 4)),
    ("fma", (2, 5, 12)),
    ("mul", (2, 4)),
    ("fma", (3, 5, 14)),
]


def test_the_parts_bounded_by_hand_are_those_of_the_source():
    """`turned` and `_store_attitude` have the operations for which docs/proof.md has a bound."""
    trace = traced.Trace()
    pair, (sine, cosine) = trace.inputs("ar", "ai", "br", "bi"), trace.inputs("s", "c")
    traced.rebound(series.turned, traced.replacements())(pair, sine, cosine)
    assert trace.nodes[6:] == _TURNED

    trace = traced.Trace()
    frame = [trace.inputs(*(f"f{j}{k}" for k in range(4))) for j in range(4)]
    pair, rows = trace.inputs("ar", "ai", "br", "bi"), [{} for _ in range(4)]
    traced.rebound(kernel._store_attitude, traced.replacements())(frame, pair, rows, 0)
    counts = trace.counts([row[0].place for row in rows], ("ar", "ai", "br", "bi"))
    # norm: 2 fma, 2 products, 1 sum; root, division; 4 products with it; each row 2 fma, 2 products
    # and a sum
    wanted = {"fma": 10, "mul": 14, "sum": 5, "sqrt": 1, "div": 1}
    assert {name: counts[name] for name in wanted} == wanted


# ---- Faults that are put in


def test_an_omitted_rounding_shows():
    """Leaving out the rounding of the last sum of the cosine lowers the bound."""
    whole = loop_bounds.turn_of_sine_cosine()
    trace = traced.Trace()
    outputs, _ = loop_bounds._polynomials_and_turn(*trace.inputs("r", "lo"), 0)
    last = outputs[0].place, outputs[1].place
    assert loop_bounds.turn_of_sine_cosine(omitted=last) < 0.9 * whole


def test_a_worse_arrangement_shows(monkeypatch):
    """`lo` applied after a further rounding of sine and cosine raises the bound."""
    eighth = traced.rebound(series.sincos_of_eighth, traced.replacements())

    def worse(polynomials):
        return tuple((x * 3.0) / 3.0 for x in polynomials)

    rebound = traced.rebound

    def with_fault(function, names, memo=None):
        if function is series.sincos_of_eighth:
            return lambda x: worse(eighth(x))
        return rebound(function, names, memo)

    monkeypatch.setattr(traced, "rebound", with_fault)
    assert loop_bounds.uniform() > UNIFORM


def test_the_lemma_bounds_what_is_measured():
    """Errors of sine and cosine of random phases against balls: below the bound, above a tenth."""
    random = np.random.default_rng(1)
    worst = 0.0
    with flint.ctx.workprec(120):
        for _ in range(3000):
            r, lo = float(random.uniform(-0.5, 0.5)), float(random.uniform(-1, 1)) * 2.0**-55
            sine, cosine = (flint.arb(float(x)) for x in series.sincos(r, lo))
            x = 2 * flint.arb.pi() * (flint.arb(r) + flint.arb(lo))
            worst = max(worst, 2.0 * abs(float(sine * x.cos() - cosine * x.sin())))
    bound = loop_bounds.turn_of_sine_cosine()
    assert 0.1 * bound < worst <= bound


# ---- The machine code


def _ir(name, low, rates):
    """The optimized LLVM code of a loop in one of its forms."""
    from numba import from_dtype, types

    from attitude._compilation import lowering

    entry = getattr(kernel, name)
    dispatcher = lowering.dispatcher(entry.py_func, entry.targetoptions, False)
    numbers = types.Array(types.float64, 2, "C", readonly=True)
    record = types.Array(from_dtype(CONSTANTS), 1, "C", readonly=True)
    out = types.Array(types.float64, 3, "C")
    whole = (types.int64,) * 3
    times = (numbers, numbers if low else types.none)
    dispatcher.compile((record, *times, out, out if rates else types.none, *whole))
    return dispatcher.inspect_llvm(dispatcher.signatures[0])


# numba 0.60 calls sqrt by its name in C.
_CALL = re.compile(r"call [^\n]*?(<\d+ x double>|double) @(?:llvm\.)?(fma|rint|sqrt|fabs)")
_OPERATION = re.compile(r"= f(add|sub|mul|div|neg) (<\d+ x double>|double) ")
_FLAGGED = re.compile(r"= f\w+ (?:fast|nnan|ninf|nsz|arcp|contract|afn|reassoc)|call (?:fast|nnan)")
_NAMES = {"add": "sum", "sub": "sum"}


@pytest.mark.skipif(decorators.UNCOMPILED, reason="compilation is switched off")
@pytest.mark.parametrize("rates", [False, True], ids=["", "rates"])
@pytest.mark.parametrize("low", [False, True], ids=["", "second doubles"])
@pytest.mark.parametrize("name", ["uniform", "trigonometric", "hyperbolic"])
def test_machine_code_has_the_operations_of_the_trace(name, low, rates):
    """No flag that allows other roundings, and in the loop over epochs each traced operation."""
    text = _ir(name, low, rates)
    assert not _FLAGGED.search(text)
    if "@llvm.fma" not in text:
        pytest.skip("this machine has no fused multiply-add: it is emulated, with the same bits")
    found = {"vector": Counter(), "scalar": Counter()}
    for kind, operation in _CALL.findall(text):
        found["scalar" if kind == "double" else "vector"][operation] += 1
    for operation, kind in _OPERATION.findall(text):
        found["scalar" if kind == "double" else "vector"][_NAMES.get(operation, operation)] += 1
    traced_counts = loop_bounds.operations_of_loop(name, low=low, rates=rates)
    known = {key: traced_counts[key] for key in ("fma", "mul", "sum", "div", "sqrt", "neg", "rint")}
    # `any_beyond` reads all epochs before: |t + low|, unrolled.
    magnitudes = found["vector"]["fabs"] - traced_counts["abs"]
    vector = {key: found["vector"][key] for key in known}
    vector["sum"] -= magnitudes if low else 0
    scalar = found["scalar"]
    if found["vector"]["fma"]:
        assert vector == known
        assert all(scalar[key] == known[key] for key in ("fma", "rint", "sqrt"))
    assert all(scalar[key] >= known[key] for key in known)


def test_derivatives_of_the_analysis():
    """Reverse mode over a traced program gives the derivative of the sine."""
    trace = traced.Trace()
    outputs, _ = loop_bounds._polynomials_and_turn(*trace.inputs("r", "lo"), 0)
    values, _ = rounding_bounds.forward(
        trace.nodes, {name: rounding_bounds.of(x) for name, x in (("r", 0.07), ("lo", 1e-17))}
    )
    slopes = rounding_bounds.derivatives(trace.nodes, values, outputs[0].place)
    assert abs(float(slopes[0].lo) - 2 * math.pi * math.cos(2 * math.pi * 0.07)) < 1e-12
