"""The package in pure Python: the same answers where compilation is switched off."""

import os
import random
import struct
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from attitude._compilation import instructions, simd
from attitude._compilation.choice import mode
from attitude._compilation.decorators import elementwise, entry_point, force_inlined
from tests.support.places import ROOT

SCRIPT = ROOT / "tests" / "support" / "uncompiled_answers.py"
# Sums over facets and torques of facets, in any order and with fused products: 1e-15 of terms.
SUM = 1e-13


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The answers of a process that compiles, and of one that does not."""
    folder = tmp_path_factory.mktemp("answers")
    found = []
    for name in ("always", "never"):
        file = folder / f"{name}.npz"
        environment = {**os.environ, "ATTITUDE_COMPILE": name}
        subprocess.run([sys.executable, SCRIPT, file], env=environment, check=True)
        found.append(dict(np.load(file)))
    return found


def test_the_same_answers(both):
    compiled, uncompiled = both
    assert compiled.keys() == uncompiled.keys() and len(compiled) > 60
    for name, want in compiled.items():
        if name.startswith("exact"):
            known = ~np.isnan(want)
            assert np.array_equal(np.isnan(uncompiled[name]), ~known), name
            assert uncompiled[name][known].tobytes() == want[known].tobytes(), name
        else:
            scale = np.nanmax(np.abs(want))
            np.testing.assert_allclose(uncompiled[name], want, rtol=0, atol=SUM * scale)


@pytest.mark.parametrize("switch", [{"ATTITUDE_COMPILE": "never"}, {"NUMBA_DISABLE_JIT": "1"}])
def test_switched_off_without_numba(switch):
    code = (
        "import sys; from attitude import propagate;"
        "print(propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), 60.0).shape);"
        "print('numba' in sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **switch},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == ["(4,)", "False"]


def test_the_switches(monkeypatch):
    for name in ("ATTITUDE_COMPILE", "NUMBA_DISABLE_JIT"):
        monkeypatch.delenv(name, raising=False)
    assert mode() == "automatic"
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "0")
    assert mode() == "automatic"
    monkeypatch.setenv("ATTITUDE_COMPILE", "always")
    assert mode() == "always"
    monkeypatch.setenv("ATTITUDE_COMPILE", "never")
    assert mode() == "never"


INDICES = []


@elementwise
@force_inlined
def doubled(x, out):
    for i in range(len(x)):
        INDICES.append(i)
        out[i] = 2.0 * x[i]


def test_many_epochs_are_one_pass_in_python():
    """A pass over arrays, and a loop where that would take longer."""
    for count, passes in ((3, 3), (100, 1)):
        INDICES.clear()
        out = np.empty(count)
        doubled(np.arange(float(count)), out)
        assert np.array_equal(out, 2.0 * np.arange(count)) and len(INDICES) == passes


@entry_point
def compiled_fma(a, b, c, out):
    for k in range(len(out)):
        out[k] = instructions.fma(a[k], b[k], c[k])


@entry_point
def compiled_rint(a, out):
    for k in range(len(out)):
        out[k] = instructions.rint(a[k])


def some_doubles(count, seed):
    """Doubles of all sizes, near cancellation, zeros, infinities, NaN."""
    rng = random.Random(seed)
    special = [0.0, -0.0, float("inf"), float("-inf"), float("nan"), 5e-324, 1.7e308, 1.0, -1.0]
    found = []
    for _ in range(count):
        kind = rng.random()
        if kind < 0.05:
            found.append(rng.choice(special))
        elif kind < 0.15:
            found.append(struct.unpack("<d", rng.randbytes(8))[0])
        else:
            found.append(rng.uniform(-1, 1) * 2.0 ** rng.randint(-30, 30))
    return np.array(found)


def test_fma_in_python_is_the_instruction():
    """Also where a product and a sum nearly cancel, and at ties of the last rounding."""
    a, b, c = (some_doubles(8000, seed) for seed in (1, 2, 3))
    with np.errstate(all="ignore"):
        c[::3] = -(a * b)[::3]
        c[1::6] = (a * b * 2.0**53)[1::6]
        c[4::6] = (-a * b * (2.0**54 + 4.0))[4::6]
    want = np.empty(len(a))
    compiled_fma(a, b, c, want)
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(instructions.fma(a, b, c), want)
    for k in range(len(a)):
        given = a[k], b[k], c[k]
        found = instructions.fma(*map(float, given))
        assert found == want[k] or (found != found and want[k] != want[k]), given
        if all(map(np.isfinite, given)) and 1e-300 < abs(want[k]) < 1e300:
            assert found == float(Fraction(a[k]) * Fraction(b[k]) + Fraction(c[k]))


def test_rint_in_python_is_the_instruction():
    a = np.concatenate([some_doubles(5000, 5), np.arange(-9, 9) + 0.5, [2.0**52 + 1, -0.2]])
    want = np.empty(len(a))
    compiled_rint(a, want)
    found = np.array([instructions.rint(x) for x in a.tolist()])
    assert found.tobytes() == want.tobytes() == instructions.rint(a).tobytes()


def test_bits_of_a_double():
    for x in some_doubles(1000, 7).tolist():
        assert np.float64(instructions.from_bits(instructions.as_bits(x))).tobytes() == (
            np.float64(x).tobytes()
        )
    assert instructions.as_bits(-0.0) == -(2**63)
    assert instructions.from_bits(2**63) == 0.0  # bits beyond a signed word, as a shift makes them


def test_words():
    assert [instructions.bits_set(x) for x in (0, 1, 255)] == [0, 1, 8]
    assert instructions.lowest_bit(np.uint64(2**63)) == 63
    assert instructions.lowest_bit(np.uint64(12)) == 2
    assert simd.bits_set_in_bytes(0xFF00000000000103).lanes == (2, 1, 0, 0, 0, 0, 0, 8)


def test_lanes_in_python():
    a, b = simd.lanes((1.0, 2.0, 3.0, 4.0)), simd.lanes((4.0, 0.0, 2.0, -1.0))
    assert (a + b).lanes == (5.0, 2.0, 5.0, 3.0) and (1.0 - a).lanes == (0.0, -1.0, -2.0, -3.0)
    assert (2.0 * a / 4.0).lanes == (0.5, 1.0, 1.5, 2.0)
    assert (a / b).lanes == (0.25, float("inf"), 1.5, -4.0)
    assert simd.at_least(a, b).lanes == (4.0, 2.0, 3.0, 4.0)
    assert simd.summed_up(a) == 10.0 and simd.root(a).lanes[3] == 2.0
    assert instructions.fma(a, 2.0, b).lanes == (6.0, 4.0, 8.0, 7.0)
