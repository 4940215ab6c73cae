"""Several doubles as one value in compiled code."""

from fractions import Fraction

import numpy as np
import pytest

from attitude._compilation.decorators import entry_point
from attitude._compilation.instructions import fma
from attitude._compilation.simd import (
    add_in_columns,
    at_least,
    at_most,
    bits_set_in_bytes,
    chosen,
    doubles_of,
    eight,
    every,
    exponent,
    for_each,
    four,
    halved,
    inverse_power,
    lanes,
    largest_lane,
    nearest_eighth,
    packed,
    positive_bits,
    put_eight,
    root,
    sixteen,
    summed_for_each,
    summed_up,
)

A = 0.1, 1.0 / 3.0, -2.5, 1.1
B = 3.0, 0.7, 1e-9, -1.3
EIGHT = tuple(np.random.default_rng(8).normal(size=8))


@entry_point
def operations(a, b, x):
    """Sums over four lanes, weighted so that lanes which changed places would show."""
    p, q, weights = lanes(a), lanes(b), lanes((1.0, 2.0, 4.0, 8.0))
    return (
        summed_up((p + q) * weights),
        summed_up((p - q) * weights),
        summed_up(p * q * weights),
        summed_up(p / q * weights),
        summed_up((x - q) * weights),
        summed_up((p * x) * weights),
        summed_up((x / q) * weights),
        summed_up(root(lanes((4.0, 9.0, 2.0, 0.0))) * weights),
        summed_up(at_least(q, lanes((1.0, 1.0, 1.0, 1.0))) * weights),
        summed_up(at_most(q, lanes((1.0, 1.0, 1.0, 1.0))) * weights),
        summed_up(chosen(q, p, weights) * weights),
    )


@entry_point
def fused(a, b, x):
    """a b - (a b rounded) by lanes, and with doubles among them."""
    p, q = lanes(a), lanes(b)
    product = p * q
    return summed_up(fma(p, q, product * -1.0)), summed_up(fma(p, x, (p * x) * -1.0))


@entry_point
def repeated(a, b, x):
    """A formula over four numbers for each of two lanes, and for a double; its root."""
    two, weights = lanes((a[0], a[1])), lanes((1.0, 2.0, 4.0, 8.0))
    many = for_each(b, two) * two + lanes((x, a[2])) * for_each(a, two)
    found = doubles_of(summed_for_each(fma(many, two, -many), two))
    return found, summed_for_each(for_each(b, x) * x + weights, x), root(x)


@entry_point
def of_eight(array, word):
    read = eight(array, 1)
    return summed_up(read), summed_up(bits_set_in_bytes(word) * read)


@entry_point
def compared(array):
    read = eight(array, 0)
    return largest_lane(read), positive_bits(read)


@entry_point
def of_four(array):
    return doubles_of(four(array, 2) * 2.0)


@entry_point
def doubled(array, out):
    put_eight(out, 2, eight(array, 1) * 2.0)


@entry_point
def packed_by_any_llvm(array, by, out):
    put_eight(out, 0, packed(eight(array, 0), eight(by, 0)))


@entry_point
def moved(array, by, out):
    """Lanes without gaps, and numbers taken apart and put together."""
    a, b = eight(array, 0), eight(by, 0)
    put_eight(out, 0, packed(a, b))
    put_eight(out, 8, nearest_eighth(a))
    put_eight(out, 16, inverse_power(nearest_eighth(a)))
    n = exponent(a * a)
    put_eight(out, 24, n)
    put_eight(out, 32, halved(a, n))
    put_eight(out, 40, at_most(at_least(a, -1.0), every(0.5, a)))
    two = sixteen(array, 0)
    return summed_up(two * two)


def halves(numbers):
    """The sum in the order of `summed_up`."""
    numbers = np.asarray(numbers, float)
    while len(numbers) > 1:
        numbers = numbers[: len(numbers) // 2] + numbers[len(numbers) // 2 :]
    return numbers[0]


def test_arithmetic_is_that_of_each_lane():
    a, b, w, x = np.array(A), np.array(B), np.array([1.0, 2.0, 4.0, 8.0]), 0.3
    wanted = (
        (a + b) * w,
        (a - b) * w,
        a * b * w,
        a / b * w,
        (x - b) * w,
        (a * x) * w,
        (x / b) * w,
        np.sqrt([4.0, 9.0, 2.0, 0.0]) * w,
        np.maximum(b, 1.0) * w,
        np.minimum(b, 1.0) * w,
        np.where(b > 0.0, a, w) * w,
    )
    assert operations(A, B, x) == tuple(halves(each) for each in wanted)


def test_fma_of_lanes_rounds_once():
    def left_out(p, q):
        return float(Fraction(p) * Fraction(q) - Fraction(p * q))

    found = fused(A, B, 0.7)
    assert found[0] == halves([left_out(p, q) for p, q in zip(A, B, strict=True)]) != 0.0
    assert found[1] == halves([left_out(p, 0.7) for p in A]) != 0.0


def test_eight_are_read_from_any_place():
    array = np.array([np.nan, *EIGHT, np.nan])
    word = np.uint64(0xFF_7F_3F_1F_0F_07_03_01)  # the lowest byte has one bit
    total, counted = of_eight(array, word)
    assert total == halves(EIGHT)
    assert counted == pytest.approx(np.dot(EIGHT, np.arange(1, 9)), rel=1e-15)


@pytest.mark.parametrize("largest", range(8))
def test_the_largest_lane_and_the_lanes_above_zero(largest):
    array = np.array([-3.0, 0.0, 5.0, -0.0, 1e-300, -1e-300, 2.0, -7.0])
    array[largest] = 9.0
    bits = sum(2**k for k in range(8) if array[k] > 0.0)
    assert compared(array) == (9.0, bits) == compared.py_func(array)
    assert compared(-np.abs(array) - 1.0) == (-np.min(np.abs(array)) - 1.0, 0)


@pytest.mark.parametrize("run", [of_four, of_four.py_func])
def test_four_are_read_and_taken_apart(run):
    assert run(np.array(EIGHT)) == tuple(2.0 * each for each in EIGHT[2:6])


@pytest.mark.parametrize("run", [doubled, doubled.py_func])
def test_eight_are_written_to_any_place(run):
    array, out = np.array([np.nan, *EIGHT]), np.full(11, -1.0)
    run(array, out)
    np.testing.assert_array_equal(out, [-1.0, -1.0, *(2.0 * np.array(EIGHT)), -1.0])


@entry_point
def added(array, rows, amounts):
    add_in_columns(array, 2, eight(rows, 0), eight(amounts, 0))


@pytest.mark.parametrize("run", [added, added.py_func])
def test_bytes_are_added_in_the_column_of_each_lane(run):
    array = np.full(34, 250, np.uint8)
    rows = np.array([0.0, 3.0, 1.0, 0.0, 2.0, 2.0, 3.0, 1.0])
    amounts = np.array([1.0, -1.0, 0.0, 7.0, 1.0, -2.0, 3.0, 1.0])
    run(array, rows, amounts)
    expected = np.full((4, 8), 250)
    expected[rows.astype(int), np.arange(8)] += amounts.astype(int)
    assert array[2:].tolist() == (expected % 256).reshape(-1).tolist()
    assert array[:2].tolist() == [250, 250]


def test_lanes_moved_and_numbers_taken_apart():
    a = np.array([*EIGHT, *B, *A])
    by = np.array([1.0, -1.0, 0.0, 2.0, np.nan, 3.0, -0.0, 1e-300])
    out, in_python = np.empty(48), np.empty(48)
    assert moved(a, by, out) == halves(a * a) == moved.py_func(a, by, in_python)
    assert out.tobytes() == in_python.tobytes()
    kept = a[:8][by > 0.0]
    assert out[:8].tolist() == [*kept, *[0.0] * (8 - len(kept))]
    eighths = np.round(8.0 * a[:8]) / 8.0
    assert out[8:16].tolist() == eighths.tolist()
    assert out[16:24] == pytest.approx(2.0**-eighths, rel=2e-16)
    fraction = a[:8] ** 2 / 2.0 ** out[24:32]
    assert np.all((fraction >= 0.75) & (fraction < 1.5))
    assert out[32:40].tolist() == (a[:8] / 2.0 ** out[24:32]).tolist()
    assert out[40:].tolist() == np.clip(a[:8], -1.0, 0.5).tolist()


@entry_point
def first_eight(array):
    """The sum of the first eight doubles."""
    return summed_up(eight(array, 0))


def test_strided_arrays_are_refused():
    """A vector is eight successive doubles of memory: those of a view are others."""
    numbers = np.arange(32.0)
    assert first_eight(numbers) == 28.0
    if not hasattr(first_eight, "dispatcher"):
        pytest.skip("Python takes any array")
    with pytest.raises(Exception, match="eight"):
        first_eight(numbers[::2])


def test_a_shorter_vector_is_repeated():
    """Each lane has the sums of its own formula, of the same pairs; compiled and in Python."""
    expected = []
    for lane, other in ((0.1, 0.75), (1.0 / 3.0, -2.5)):
        many = [fma(b, lane, 0.0) + other * a for a, b in zip(A, B, strict=True)]
        terms = [fma(each, lane, -each) for each in many]
        expected.append((terms[0] + terms[2]) + (terms[1] + terms[3]))
    sums = [0.75 * b + w for b, w in zip(B, (1.0, 2.0, 4.0, 8.0), strict=True)]
    for function in (repeated, repeated.py_func):
        found, total, square_root = function(A, B, 0.75)
        assert found == tuple(expected)
        assert total == (sums[0] + sums[2]) + (sums[1] + sums[3])
        assert square_root == np.sqrt(0.75)


def test_lanes_are_packed_without_the_instruction(monkeypatch):
    """One of LLVM 19; the oldest numba allowed has LLVM 14, where its call ended the process."""
    from attitude._compilation import simd_lowering

    monkeypatch.setattr(simd_lowering, "_COMPRESSES", 1000)
    array = np.arange(1.0, 9.0)
    for bits in range(256):
        by = np.array([1.0 if bits >> k & 1 else -0.0 for k in range(8)])
        out, expected = np.full(8, np.nan), np.zeros(8)
        kept = array[by > 0.0]
        expected[: len(kept)] = kept
        packed_by_any_llvm(array, by, out)
        assert np.array_equal(out, expected)
