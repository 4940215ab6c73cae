"""Laws of free rotation that hold for any input, as properties.

Where two results of the package are compared, the tolerance is twice its promise of 4e-15 rad.
Exact powers of two change no rounding at all: there the bits must be equal.
"""

import math
from concurrent.futures import ThreadPoolExecutor
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from attitude import propagate
from attitude.frames import quaternion
from tests.support import states
from tests.support.oracle import rotation_error

TWICE = 8e-15  # rad: two results, each right to 4e-15

any_state = states.strategy()
# A power of two scales no subnormal number exactly.
revolutions = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-290)
laws = settings(max_examples=60)


def _at(state, t, **options):
    return propagate(state.moments, state.wxyz0, state.omega0, t, **options)


def _same(wxyz, other, tolerance=TWICE):
    error = rotation_error(wxyz, [float(x) for x in other], signed=True)
    assert error <= tolerance


def _rounded(state):
    """The state with 26 bits a number, so that products with 26 bits are exact."""

    def short(x):
        fraction, power = math.frexp(x)
        return math.ldexp(round(math.ldexp(fraction, 26)), power - 26)

    moments = sorted(map(short, state.moments))
    if moments[2] > moments[0] + moments[1]:
        return None
    return state._replace(
        moments=tuple(map(short, state.moments)), omega0=tuple(map(short, state.omega0))
    )


# ---- what does not change ----------------------------------------------------------------------


@laws
@given(any_state, st.lists(revolutions, min_size=1, max_size=20))
def test_momentum_is_fixed_in_space(state, turns):
    """To 4e-15 of attitude, and 4e-15 of the largest rate times the inertia it meets."""
    t = np.array([0.0, *turns]) * states.revolution(state)
    wxyz, omega = _at(state, t, angular_velocity=True)
    moments = np.array(state.moments) / max(state.moments)
    omega = omega / (np.max(np.abs(omega)) or 1.0)
    momentum = quaternion.rotate(wxyz, moments * omega)
    size = np.linalg.norm(momentum[0])
    assert np.max(np.abs(momentum - momentum[0])) <= 2e-14 * size + 4e-15


@laws
@given(any_state, st.lists(revolutions, min_size=1, max_size=20))
def test_energy_is_fixed(state, turns):
    t = np.array([0.0, *turns]) * states.revolution(state)
    omega = _at(state, t, angular_velocity=True)[1]
    moments = np.array(state.moments) / max(state.moments)
    omega = omega / (np.max(np.abs(omega)) or 1.0)
    energy = np.sum(moments * omega**2, axis=-1)
    # each term to twice the error of its rate, 4e-15 of the largest
    tolerance = 2 * 4e-15 * np.sum(moments * np.abs(omega[0])) + 1e-14 * energy[0]
    assert np.all(np.abs(energy - energy[0]) <= tolerance)


# ---- going on, and going back ------------------------------------------------------------------


@laws
@given(any_state, st.floats(-3, 3), st.floats(-3, 3))
def test_restart_from_a_state_on_the_way(state, first, second):
    """From t1 as from 0, but for what rounding the state at t1 to doubles does to the future.

    That is measured: each rate at t1 is moved by four units in the last place of the largest.
    """
    t1, t2 = np.array([first, second]) * states.revolution(state)
    (wxyz, _), (omega, _) = _at(state, [t1, t2], angular_velocity=True)
    if any(i == 0.0 for i in state.moments):
        omega = np.where(np.array(state.moments) == 0.0, 0.0, omega)  # a rod: along it exactly 0
    direct = _at(state, t2)
    again = propagate(state.moments, wxyz, omega, t2 - t1)
    tolerance = 2 * TWICE
    for axis in range(3):
        if state.moments[axis] > 0.0:
            moved = omega.copy()
            moved[axis] += 4 * np.spacing(np.max(np.abs(omega)))
            change = propagate(state.moments, wxyz, moved, t2 - t1)
            tolerance += rotation_error(change, [float(x) for x in again])
    # and t2 - t1 is rounded
    rate = np.max(np.abs(omega)) * max(state.moments) / _least(state.moments)
    tolerance += rate * np.spacing(abs(t2 - t1))
    _same(again, direct, tolerance)


def _least(moments):
    return min(i for i in moments if i > 0.0)


@laws
@given(any_state, revolutions)
def test_time_reversal(state, turns):
    """Spun the other way and watched backwards, the body does the same."""
    t = turns * states.revolution(state)
    wxyz, omega = _at(state, t, angular_velocity=True)
    reverse = state._replace(omega0=tuple(-w for w in state.omega0))
    back, rates = _at(reverse, -t, angular_velocity=True)
    _same(back, wxyz)
    assert np.max(np.abs(rates + omega)) <= TWICE * np.max(np.abs(state.omega0)) * _spread(state)


def _spread(state):
    """How much larger than at the start the largest rate can become."""
    momentum = max(i * abs(w) for i, w in zip(state.moments, state.omega0, strict=True))
    fastest = max(map(abs, state.omega0)) or 1.0
    return max(1.0, 2 * momentum / _least(state.moments) / fastest)


SLOWED = states.State("separatrix", (2.0, 5.0, 6.0), (1.0, 0.0, 0.0, 0.0), (-(2.0**-25),) * 3)


@laws
@given(any_state, st.integers(-40, 40), revolutions)
@example(SLOWED, 1, 238.0)
def test_rates_times_c_is_time_over_c(state, power, turns):
    """w -> c w with t -> t / c, bit by bit for a power of two; subnormal numbers are rounded."""
    c, t = 2.0**power, turns * states.revolution(state)
    faster = state._replace(omega0=tuple(c * w for w in state.omega0))
    wxyz, omega = _at(state, t, angular_velocity=True)
    other, rates = _at(faster, t / c, angular_velocity=True)
    tiny = np.finfo(float).tiny
    subnormal = np.minimum(np.abs(omega), np.abs(rates)) < tiny
    rounding = np.where(subnormal, max(c, 1.0) * np.finfo(float).smallest_subnormal, 0.0)
    assert np.array_equal(wxyz, other) and np.all(np.abs(c * omega - rates) <= rounding)


@laws
@given(any_state, st.integers(1, 2**26), st.integers(-(2**26), 2**26))
def test_rates_times_a_whole_number(state, c, n):
    """The same law where roundings differ: c w and t have few bits, so that c t is exact."""
    state = _rounded(state)
    if state is None:
        return
    t = math.ldexp(n, math.frexp(states.revolution(state))[1] - 26)
    faster = state._replace(omega0=tuple(c * w for w in state.omega0))
    _same(_at(state, c * t), _at(faster, t))


@laws
@given(any_state, st.integers(-60, 60), revolutions)
def test_moments_in_another_unit(state, power, turns):
    """Only their ratios count: bit by bit for a power of two."""
    t = turns * states.revolution(state)
    other = state._replace(moments=tuple(2.0**power * i for i in state.moments))
    for one, two in zip(
        _at(state, t, angular_velocity=True), _at(other, t, angular_velocity=True), strict=True
    ):
        assert np.array_equal(one, two)


@laws
@given(any_state, st.integers(1, 2**26), revolutions)
def test_moments_times_a_whole_number(state, c, turns):
    state = _rounded(state)
    if state is None:
        return
    t = turns * states.revolution(state)
    _same(_at(state, t), _at(state._replace(moments=tuple(c * i for i in state.moments)), t))


# ---- other axes --------------------------------------------------------------------------------

# The 24 ways to name the axes of a body x, y, z: signed permutations, odd ones with one sign.
NAMINGS = [
    (order, signs)
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
    if np.linalg.det(np.eye(3)[list(order)] * signs) > 0.0
]


@pytest.mark.parametrize(("order", "signs"), NAMINGS)
@settings(max_examples=8)
@given(any_state, revolutions)
def test_relabelled_axes(order, signs, state, turns):
    """The attitude of a body does not depend on which of its axes is called x."""
    t = turns * states.revolution(state)
    new_from_old = np.eye(3)[list(order)] * signs  # row i: the new axis i over the old axes
    relabelled = state._replace(
        moments=tuple(state.moments[k] for k in order),
        omega0=tuple((new_from_old @ state.omega0).tolist()),
    )
    turn = quaternion.from_matrix(new_from_old.T)
    start = quaternion.multiply(state.wxyz0, turn)
    wxyz, omega = _at(state, t, angular_velocity=True)
    other, rates = propagate(relabelled.moments, start, relabelled.omega0, t, angular_velocity=True)
    _same(other, quaternion.multiply(wxyz, turn), TWICE + 1e-15)
    # 1e-15: the product with a quarter turn, whose quaternion is rounded
    assert np.max(np.abs(rates - new_from_old @ omega)) <= TWICE * np.max(np.abs(omega))


@laws
@given(any_state, any_state, revolutions)
def test_rotating_the_inertial_frame(state, other, turns):
    """All attitudes turn with it, and the rates in body axes do not know."""
    t = turns * states.revolution(state)
    wxyz, omega = _at(state, t, angular_velocity=True)
    turn = np.array(other.wxyz0)
    turned = state._replace(wxyz0=tuple(quaternion.multiply(turn, state.wxyz0)))
    there, rates = _at(turned, t, angular_velocity=True)
    _same(there, quaternion.multiply(turn, wxyz), TWICE + 1e-15)
    assert np.array_equal(rates, omega)


@laws
@given(any_state, revolutions)
def test_the_sign_of_the_quaternion_is_that_of_the_start(state, turns):
    t = turns * states.revolution(state)
    negative = state._replace(wxyz0=tuple(-x for x in state.wxyz0))
    assert np.array_equal(_at(state, t), -_at(negative, t))


# ---- the path and its sampling -----------------------------------------------------------------


@laws
@given(any_state, st.floats(-1e9, 1e9))
def test_continuous_sign(state, turns):
    """Neighbours in a dense sampling never flip, wherever on the path: |dq| <= |w| dt / 2."""
    unit = states.revolution(state) / 64 / _spread(state)
    t = turns * states.revolution(state)
    step = max(unit, 4 * np.spacing(abs(t)))
    if step > states.revolution(state) / 16 / _spread(state):
        return
    wxyz = _at(state, t + step * np.arange(-200, 201))
    assert np.min(np.sum(wxyz[1:] * wxyz[:-1], axis=-1)) > 0.9


@laws
@given(any_state, st.integers(1, 60))
def test_sparse_sampling_is_dense_sampling(state, stride):
    """The sign follows the path, not the samples: bit by bit."""
    t = np.linspace(-50, 50, 301) * states.revolution(state)
    dense = _at(state, t, angular_velocity=True)
    sparse = _at(state, t[::stride], angular_velocity=True)
    for one, two in zip(dense, sparse, strict=True):
        assert np.array_equal(one[::stride], two)


@laws
@given(any_state, st.lists(revolutions, min_size=1, max_size=40), st.integers(1, 7))
def test_alone_in_an_array_in_a_chunk_in_a_thread(state, turns, size):
    """The same bits, so that no result depends on how the work was cut up."""
    t = np.array(turns) * states.revolution(state)
    whole = _at(state, t, angular_velocity=True)
    alone = [_at(state, float(x), angular_velocity=True) for x in t]
    chunks = [t[i : i + size] for i in range(0, len(t), size)]
    with ThreadPoolExecutor(2) as pool:
        threaded = list(pool.map(lambda chunk: _at(state, chunk, angular_velocity=True), chunks))
    for k in range(2):
        assert np.array_equal(whole[k], [each[k] for each in alone])
        assert np.array_equal(whole[k], np.concatenate([each[k] for each in threaded]))
        assert np.array_equal(whole[k][::-1], _at(state, t[::-1], angular_velocity=True)[k])


@laws
@given(st.lists(any_state, min_size=1, max_size=12), st.lists(revolutions, max_size=5))
def test_a_batch_is_its_bodies_one_by_one(batch, turns):
    """Bit by bit, with common epochs and with epochs of their own."""
    moments, wxyz0, omega0 = (
        np.array([getattr(state, name) for state in batch])
        for name in ("moments", "wxyz0", "omega0")
    )
    common = np.array(turns) * states.revolution(batch[0])
    own = np.array([np.array(turns) * states.revolution(state) for state in batch])
    reach = 1e16 * min(map(states.revolution, batch)) / max(map(_spread, batch))
    if np.max(np.abs(common), initial=0.0) < reach:
        together = propagate(moments, wxyz0, omega0, common, angular_velocity=True)
        for k, state in enumerate(batch):
            one = _at(state, common, angular_velocity=True)
            assert all(np.array_equal(x[k], y) for x, y in zip(together, one, strict=True))
    together = propagate(moments, wxyz0, omega0, own, angular_velocity=True)
    for k, state in enumerate(batch):
        one = _at(state, own[k], angular_velocity=True)
        assert all(np.array_equal(x[k], y) for x, y in zip(together, one, strict=True))


@laws
@given(any_state, st.lists(st.one_of(revolutions, st.just(math.nan)), min_size=1, max_size=30))
def test_nan_in_its_place_only(state, turns):
    """A NaN epoch gives a NaN attitude and rate there, and the bits elsewhere stay."""
    t = np.array(turns) * states.revolution(state)
    bad = np.isnan(t)
    found = _at(state, t, angular_velocity=True)
    clean = _at(state, np.where(bad, 0.0, t), angular_velocity=True)
    for one, two in zip(found, clean, strict=True):
        assert np.all(np.isnan(one[bad]))
        assert np.array_equal(one[~bad], two[~bad])


# ---- epochs in two doubles ---------------------------------------------------------------------


@laws
@given(any_state, revolutions, st.floats(-1e6, 1e6))
def test_any_split_of_an_epoch(state, turns, share):
    """t + t_low is the epoch, whichever of the two is the larger: the sum is exact here."""
    unit = 2.0 ** math.frexp(states.revolution(state))[1]
    t, low = round(turns * 2**20) * unit / 2**20, round(share * 2**20) * unit / 2**20
    assert np.array_equal(_at(state, t, t_low=low), _at(state, t + low))
    assert np.array_equal(_at(state, t + low, t_low=0.0), _at(state, t + low))


@laws
@given(any_state, revolutions)
def test_nan_in_the_second_double(state, turns):
    t = np.full(3, turns * states.revolution(state))
    wxyz = _at(state, t, t_low=[0.0, math.nan, 0.0])
    assert np.array_equal(np.isnan(wxyz).any(axis=-1), [False, True, False])
