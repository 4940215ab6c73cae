"""Principal axes by compiled integers of 448 bits: the bits of the same rotations in Python's."""

import numpy as np
import pytest

from attitude._compilation import wide
from attitude._compilation.decorators import entry_point, subroutine
from attitude._solver.principal_axes import PrincipalAxes
from attitude.frames import quaternion
from tests.support import principal_in_integers, states


def tensors():
    """Tensors (N, 3, 3) and angular velocities (N, 3), most of them close to a degenerate one."""
    rows, omega = [], []
    for state in states.sample(100, seed=31):
        tensor, rate = states.tensor(state)
        rows.append(tensor)
        omega.append(rate)
    special = (
        [[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]],
        [[8, 1, 1], [1, 8, 1], [1, 1, 8]],
        [[2, 1e-17, 0], [1e-17, 2, 0], [0, 0, 3]],
        [[2, 1e-200, 0], [1e-200, 3, 1e-100], [0, 1e-100, 4]],
        [[1, 1e-16, 0], [1e-16, 1, 0], [0, 0, 1]],
        [[1e-300, 0, 0], [0, 2e-300, 1e-301], [0, 1e-301, 2e-300]],
    )
    rows += [np.array(each, dtype=float) for each in special]
    omega += [np.array([0.3, -0.2, 0.5])] * (len(special) - 1) + [np.zeros(3)]
    keep = [k for k, each in enumerate(rows) if np.count_nonzero(each) > 3]
    return np.array(rows)[keep], np.array(omega)[keep]


def test_the_bits_of_the_rotations_in_python():
    given, omega = tensors()
    found = PrincipalAxes.of(given)
    rates, differences = found.over_axes(omega)
    rods = 0
    for k, tensor in enumerate(given):
        right = principal_in_integers.PrincipalAxes.of(tensor)
        moments = right.moments()
        if found.moments[k, 0, 0] == 0.0:
            rods += 1
        else:
            np.testing.assert_array_equal(found.moments[k], moments)
            np.testing.assert_array_equal(differences[k], right.differences(omega[k]))
        np.testing.assert_array_equal(found.axes[k], right.axes())
        np.testing.assert_array_equal(rates[k], right.rates(omega[k]))
        axes = quaternion.from_matrix(right.axes()[..., 0])
        np.testing.assert_array_equal(found.wxyz[k], axes)
    assert rods < 0.2 * len(given) and len(given) > 80


def test_a_tensor_in_a_batch_has_the_bits_it_has_alone():
    given, omega = tensors()
    both = PrincipalAxes.of(given)
    for k in range(0, len(given), 7):
        one = PrincipalAxes.of(given[k : k + 1])
        for name in ("moments", "axes", "wxyz"):
            np.testing.assert_array_equal(getattr(one, name)[0], getattr(both, name)[k])
        alone, together = one.over_axes(omega[k : k + 1]), both.over_axes(omega)
        for a, b in zip(alone, together, strict=True):
            np.testing.assert_array_equal(a[0], b[k])


def test_diagonal_tensors_and_rates_that_are_no_numbers():
    found = PrincipalAxes.of(
        np.array([np.diag([3.0, 1.0, 2.0]), [[2, 1, 0], [1, 2, 0], [0, 0, 2]]])
    )
    np.testing.assert_array_equal(found.moments[0, :, 0], [3.0, 1.0, 2.0])
    np.testing.assert_array_equal(found.wxyz[0], [1.0, 0.0, 0.0, 0.0])
    rates, differences = found.over_axes(np.array([[1e-300, 2.0, 1e300], [np.nan, 1.0, 1.0]]))
    np.testing.assert_array_equal(rates[0, :, 0], [1e-300, 2.0, 1e300])
    assert np.isnan(differences).all() and np.isnan(rates[1, 0, 0])


@subroutine
def _in_one(a, b, places):
    return wide.shifted(wide.times(a, b) + wide.product(a, b) - b, places)


@entry_point
def _all_of_wide(words, x, places, doubles):
    """Every function of `wide`; the numbers 0 and 1 of `words` give the numbers 2 to 5."""
    a, b = wide.load(words, 0), wide.load(words, 1)
    wide.store(words, 2, wide.times(a, b))
    wide.store(words, 3, wide.product(a, b))
    wide.store(words, 4, _in_one(a, b, places))
    wide.store(words, 5, wide.whole(x) + wide.wide(-places))
    doubles[0], doubles[1] = wide.double(a), wide.double(wide.load(words, 5))
    doubles[2] = 1.0 if wide.negative(a) else 0.0
    doubles[3] = wide.length(b)
    doubles[4] = wide.word(a)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_instructions_are_those_of_python(sign):
    random = np.random.default_rng(5)
    numbers = [0, 1, -1, 1 << 444, 5 << 441, (1 << 53) + 1, (1 << 54) + 1, 3 << 52]
    numbers += [int.from_bytes(random.bytes(55), "little") >> k for k in (0, 3, 64, 100, 383, 400)]
    for first in numbers:
        for second in numbers:
            for places, x in ((-64, 2.0**80), (-1, -3.0), (0, 0.0)):
                compiled, python = (np.zeros(7 * 6, dtype=np.int64) for _ in range(2))
                for words in (compiled, python):
                    wide.store(words, 0, sign * first)
                    wide.store(words, 1, second)
                results = np.zeros(5), np.zeros(5)
                _all_of_wide(compiled, x, places, results[0])
                _all_of_wide.py_func(python, x, places, results[1])
                np.testing.assert_array_equal(compiled, python)
                np.testing.assert_array_equal(*results)
