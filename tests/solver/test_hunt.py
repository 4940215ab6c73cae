"""Hunting the worst state: hypothesis climbs the error, and a soak tries a million.

Errors are those of certificates (attitude.proof), which take a hundredth of the time of the mpmath
oracle; the oracle looks at a sample.  A state that was ever found above the promise is pinned by
name in test_accuracy.py; tests/proof/test_certificate.py hunts in eight families.
"""

import numpy as np
import pytest
from hypothesis import given, settings, target
from hypothesis import strategies as st
from scipy.special import ellipk

from attitude import Body, FreeRotation, Spin, propagate
from attitude.arcs import Arcs, Impulse
from tests.support import states
from tests.support.differences import (
    conditioning,
    excess,
    relative,
    sensitivity,
    tensor_sensitivity,
)
from tests.support.measure import certified, errors

pytest.importorskip("flint", reason="python-flint is not installed")

PROMISE = 4e-15  # rad, and relative to the largest rate


@settings(max_examples=200)
@given(
    states.strategy(),
    st.floats(0.0, 9.0),
    st.sampled_from((1, -1)),
)
def test_no_state_is_found_above_the_promise(state, power, sign):
    t = sign * 10.0**power * states.revolution(state)
    (found,) = certified(state, [t])
    target(found.attitude * 1e15, label="attitude error in 1e-15 rad")
    target(found.rate * 1e15, label="rate error in 1e-15")
    assert found.attitude <= PROMISE and found.rate <= PROMISE, found


@settings(max_examples=150)
@given(
    st.floats(1e-3, 1.0),
    st.floats(0.0, 1.0),
    st.floats(0.0, 16.0),
    st.floats(0.0, 16.0),
    st.floats(-1.0, 1.0),
    st.floats(0.0, 9.0),
)
def test_no_corner_of_the_plane_is_above_the_promise(least, share, nearness, off, middle, power):
    """Moments, distances and rates as free numbers, so that the hunt can creep along a valley."""
    most = 1.0 + least * (1.0 - 10.0**-nearness) if share > 0.5 else 1.0 + least * share
    moments = (least, 1.0, min(most, 1.0 + least))
    rates = (1.0, middle, 10.0**-off) if share > 0.3 else (10.0**-off, middle, 1.0)
    state = states.State("free", moments, (0.4, -0.2, 0.8, 0.3), rates)
    (found,) = certified(state, [10.0**power * states.revolution(state)])
    target(found.attitude * 1e15, label="attitude error in 1e-15 rad")
    assert found.attitude <= PROMISE and found.rate <= PROMISE, found


def _excess(state, revolutions):
    """The largest error of a column over the promise, or over what last bits of the inputs change.

    The latter is 2^-52 times the condition number of docs/sensitivities.md.
    """
    times = [n * states.revolution(state) for n in revolutions]
    return excess(state.moments, state.wxyz0, state.omega0, times)


# Those of which an oracle of 90 digits differentiates the motion quickly.
_DIFFERENTIATED = (
    *("tumbling", "wobble", "middle_axis_wobble", "near_separatrix", "near_symmetric"),
    *("near_symmetric_near_separatrix", "near_spherical", "needle", "flat", "unequal_rates"),
    "one_rate_zero",
)


@pytest.mark.parametrize("power", [1, 6, 11, 15])
def test_no_derivative_of_a_flip_is_above_the_promise(power):
    """The middle axis, with 1e-1 to 1e-15 of the spin beside it."""
    state = states.State("flip", (1.0, 2.6, 2.0), (1, 0.3, 0, 0), (10.0**-power, 0.0, 1.0))
    assert _excess(state, (0.07, 1.3, 30.7)) <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("family", _DIFFERENTIATED)
def test_soak_of_derivatives(family):
    """110 states, ten of each family: seed 2, seven epochs from 1e-6 to 1e3 revolutions."""
    for state in states.sample(10, 2, [family]):
        assert _excess(state, (1e-6, 0.07, 0.4, 1.3, 5.3, 30.7, 1e3)) <= 1.0, state


def _solid(random):
    """Moments of a solid body, in any order."""
    parts = random.uniform(0.1, 1.0, 3)
    return tuple(map(float, np.sum(parts) - parts))


@pytest.mark.slow
@pytest.mark.parametrize("power", range(1, 16))
def test_soak_of_flips(power):
    """60 states, p = 1e-1 to 1e-15, on both sides of the separatrix: seed 35 + the power."""
    random = np.random.default_rng(35 + power)
    for axis in (0, 2, 0, 2):
        moments, rates = _solid(random), np.zeros(3)
        order = np.argsort(moments)
        rates[order[1]] = random.choice((-1.0, 1.0))
        rates[order[axis]] = 10.0**-power * random.uniform(0.3, 1.0)
        state = states.State("flip", moments, (1, 0.3, 0, 0), tuple(map(float, rates)))
        assert _excess(state, (0.07, 0.4, 1.3, 5.3, 30.7)) <= 1.0, state


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_soak_of_cancelling_terms(seed):
    """100 states 3 to 95 % from the separatrix, six epochs each up to 3 K'/wp: seeds 0 to 9."""
    random = np.random.default_rng(seed)
    for _ in range(10):
        moments, mode, parameter = _solid(random), random.integers(2), random.uniform(0.03, 0.95)
        omega, unit = _tumbling(moments, mode, parameter, random.uniform(0.0, 2.0 * np.pi))
        state = states.State("cancelling", moments, (0.4, -0.2, 0.8, 0.3), omega)
        times = random.uniform(-3.0, 3.0, 6) * unit / states.revolution(state)
        assert _excess(state, times.tolist()) <= 1.0, state


def _tumbling(moments, mode, parameter, phase):
    """Angular velocity for m_c and the amplitude of sn and cn at the epoch; seconds K'/wp."""
    order = np.argsort(moments)[:: -1 if mode else 1]
    i1, i2, i3 = np.take(moments, order)
    first = i3 * (i3 - i1)
    third = (1.0 - parameter) * first * (i3 - i2) / (i1 - i2)
    omega = np.zeros(3)
    omega[order[0]] = np.sqrt(third / (i1 * (i1 - i3))) * np.cos(phase)
    omega[order[1]] = -np.sqrt(third / (i2 * (i2 - i3))) * np.sin(phase)
    omega[order[2]] = np.sqrt(1.0 - (1.0 - parameter) * np.sin(phase) ** 2)
    rate = np.sqrt(abs(first * (i3 - i2)) / (i1 * i2 * i3))
    return tuple(map(float, omega)), float(ellipk(parameter)) / rate


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_soak_of_the_first_radians(seed):
    """100 bodies, half of them near the separatrix, eight epochs of 0.3 to 7 rad: seeds 0 to 4."""
    random = np.random.default_rng(seed)
    for k in range(20):
        moments, mode, parameter = _solid(random), random.integers(2), 10 ** random.uniform(-4, 0)
        omega, _ = _tumbling(moments, mode, parameter, random.uniform(0.0, 2.0 * np.pi))
        if k % 2:
            omega = tuple(map(float, random.normal(size=3)))
        state = states.State("radians", moments, (0.4, -0.2, 0.8, 0.3), omega)
        turns = random.uniform(0.3, 7.0, 8) * random.choice((-1.0, 1.0), 8) / (2.0 * np.pi)
        assert _excess(state, turns.tolist()) <= 1.0, state


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_soak_of_needles(seed):
    """50 needles of 1e-1 to 1e-12, 1e-12 to 1 of the spin across their length: seeds 0 to 4."""
    random = np.random.default_rng(seed)
    for _ in range(10):
        thin = 10.0 ** random.uniform(-12.0, -1.0)
        moments = (thin, 1.0, 1.0 + float(thin * random.uniform(-0.9, 0.9)))
        across = 10.0 ** random.uniform(-12.0, 0.0)
        omega = (1.0, *map(float, across * random.normal(size=2)))
        state = states.State("needle", moments, (0.4, -0.2, 0.8, 0.3), omega)
        assert _excess(state, (0.07, 0.4, -1.3, 5.3, -30.7, 1e3)) <= 1.0, state


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_soak_of_tensors(seed):
    """10 bodies with products of inertia, five epochs each: seeds 0 to 9."""
    random = np.random.default_rng(seed)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    tensor = axes @ np.diag(_solid(random)) @ axes.T
    tensor = 0.5 * (tensor + tensor.T)
    omega, times = random.normal(size=3), [0.3, -1.7, 5.0, 40.0, 900.0]
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=omega)
    found = FreeRotation(Body(tensor=tensor), spin).sensitivity_at(times)
    assert relative(found, tensor_sensitivity(tensor, omega, times)).max() <= PROMISE


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_soak_of_impulses(seed):
    """10 chains of three impulses, epochs between and after them: seeds 0 to 9."""
    random = np.random.default_rng(seed)
    moments, wxyz, omega = _solid(random), (1.0, 0.3, -0.2, 0.1), random.normal(size=3)
    impulses = [(at, 0.5 * random.normal(size=3)) for at in (1.25, 3.5, 20.0)]
    times = [0.5, 2.0, 7.0, 21.0, 150.0]
    motion = Arcs(
        Body(moments=moments),
        Spin(epoch="2026-01-01", wxyz=wxyz, angular_velocity=omega),
        [Impulse(at=at, angular_momentum=momentum) for at, momentum in impulses],
    )
    found = motion.sensitivity_at(times, angular_velocity=True)
    given = moments, wxyz, omega, times, impulses
    for one, exact, bits in zip(found, sensitivity(*given), conditioning(*given), strict=True):
        assert np.all(relative(one, exact) <= np.maximum(PROMISE, bits))


@pytest.mark.slow
def test_soak_of_a_million_states():
    """1e6 random states: finite, unit, momentum and energy kept; 51,000 of them certified, and 500
    against mpmath.

    Momentum and energy see every error of the nutation, and of the attitude against it; the phase
    about the momentum is seen by certificates and the oracle alone.
    """
    count = 10**6
    moments, wxyz, omega, t = _many(count)
    q, w = propagate(moments, wxyz, omega, t[:, None], angular_velocity=True)
    q, w = q[:, 0], w[:, 0]
    assert np.all(np.isfinite(q)) and np.all(np.isfinite(w))
    assert np.max(np.abs(np.sum(q * q, axis=1) - 1.0)) < 2e-15
    before, after = _momentum(wxyz, moments * omega), _momentum(q, moments * w)
    size = np.linalg.norm(before, axis=1)
    assert np.max(np.linalg.norm(after - before, axis=1) / size) < 1.5e-14
    energy = np.sum(moments * omega**2, axis=1)
    assert np.max(np.abs(np.sum(moments * w**2, axis=1) / energy - 1.0)) < 1.5e-14
    # Certificates look where momentum is kept worst, and at random.
    worst = np.argsort(np.linalg.norm(after - before, axis=1) / size)[-1000:]
    for n, k in enumerate([*worst.tolist(), *range(0, count, 20)]):
        state = states.State(
            f"soak {k}", *(tuple(map(float, part[k])) for part in (moments, wxyz, omega))
        )
        for measured in (certified, errors) if n % 100 == 0 else (certified,):
            (found,) = measured(state, [float(t[k])])
            assert found.attitude <= PROMISE and found.rate <= PROMISE, found


def _many(count):
    """States with moments of ratio up to 1e3, rates of ratio up to 1e8, up to 1e9 revolutions."""
    random = np.random.default_rng(2006)
    # Any three sides of a triangle are sums of two of three positive numbers.
    parts = 10.0 ** random.uniform(-3.0, 0.0, (count, 3))
    moments = parts[:, [1, 2, 0]] + parts[:, [2, 0, 1]]
    wxyz = random.normal(size=(count, 4))
    omega = random.choice((-1.0, 1.0), (count, 3)) * 10.0 ** random.uniform(-8.0, 0.0, (count, 3))
    turns = random.choice((-1.0, 1.0), count) * 10.0 ** random.uniform(0.0, 9.0, count)
    return moments, wxyz, omega, turns * 2.0 * np.pi / np.linalg.norm(omega, axis=1)


def _momentum(wxyz, in_body):
    from attitude.frames import quaternion

    unit = wxyz / np.linalg.norm(wxyz, axis=1)[:, None]
    return quaternion.rotate(unit, in_body)
