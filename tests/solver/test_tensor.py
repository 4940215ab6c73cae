"""Bodies in axes that are not principal: the doubles of the tensor taken as exact."""

import numpy as np
import pytest
from mpmath import mp, mpf

from attitude import Body, FreeRotation, Mode, Spin
from tests.support import states
from tests.support.measure import DIGITS, error_of
from tests.support.oracle import Oracle, rate_error

FAMILIES = (
    *("tumbling", "wobble", "near_symmetric", "near_spherical", "needle", "spinning_needle"),
    *("flat", "units", "unequal_rates", "symmetric", "sphere", "principal_axis"),
    # 31 digits of moments and rates would be 15 to 19 digits of what decides here: D2 of a state
    # 1e-16 from the separatrix, the least moment of a body that is 1e-12 thin.
    *("near_separatrix", "middle_axis_wobble", "extreme_needle"),
)
LIMIT = 4e-15  # rad, and of the largest rate: that of exact moments, at 1e3 and 1e9 revolutions


def _motion(rows, wxyz0, omega0):
    spin = Spin(epoch="2026-01-01", wxyz=wxyz0, angular_velocity=omega0)
    return FreeRotation(Body(tensor=rows), spin)


def _errors(rows, state, omega0, seconds):
    exact = Oracle.from_tensor(rows, state.wxyz0, omega0, digits=DIGITS)
    history = _motion(rows, state.wxyz0, omega0).at(seconds)
    right = [exact.at(t) for t in seconds]
    attitude = [error_of(q, r[0]) for q, r in zip(history.wxyz, right, strict=True)]
    rates = zip(history.angular_velocity, right, strict=True)
    return attitude, [rate_error(w, r[1]) for w, r in rates]


@pytest.mark.parametrize("family", FAMILIES)
def test_full_tensor_at_1e3_and_1e9_revolutions(family):
    """Nothing is lost against a body whose moments are given."""
    for state in states.sample(3, families=[family], seed=21):
        rows, omega0 = states.tensor(state)
        attitude, rates = _errors(rows, state, omega0, states.epochs(state, (10, 1e3, 1e9)))
        assert max(attitude) <= LIMIT
        assert max(rates) <= LIMIT


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_soak(family):
    for state in states.sample(60, families=[family], seed=22):
        rows, omega0 = states.tensor(state)
        attitude, _ = _errors(rows, state, omega0, states.epochs(state, (10, 1e3, 1e9)))
        assert max(attitude) <= LIMIT


@pytest.mark.parametrize("family", FAMILIES)
def test_principal_moments_and_axes(family):
    """Against mpmath: each moment to its own 31 digits, axes that give back the tensor."""
    for state in states.sample(3, families=[family], seed=23):
        rows, _ = states.tensor(state)
        body = Body(tensor=rows)
        with mp.workdps(60):
            exact = mp.eigsy(mp.matrix(rows), eigvals_only=True)
            for pair, right in zip(body.moments_as_pairs, exact, strict=True):
                assert abs(mpf(pair[0]) + mpf(pair[1]) - right) < 1e-31 * right
        axes, largest = body.principal_axes, np.max(np.abs(rows))
        assert np.max(np.abs(axes.T @ axes - np.eye(3))) < 1e-15
        assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-15)
        again = axes @ np.diag(body.moments) @ axes.T
        assert np.max(np.abs(again - rows)) < 2e-15 * largest
        assert np.all(np.diff(body.moments) >= 0.0)


@pytest.mark.parametrize("tensor", [np.diag([26.0, 10.0, 20.0]), np.diag([1.0, 1.0, 1.0])])
def test_a_diagonal_tensor_is_moments(tensor):
    """In the order of its diagonal, bit for bit the same motion."""
    moments = np.diag(tensor)
    spin = Spin(epoch="2026-01-01", wxyz=(0.5, 0.5, -0.5, 0.5), angular_velocity=(0.3, -1, 0.2))
    one = FreeRotation(Body(tensor=tensor), spin)
    two = FreeRotation(Body(moments=moments), spin)
    assert np.array_equal(one.body.moments, moments)
    t = np.linspace(-1e6, 1e6, 50)
    assert np.array_equal(one.at(t).wxyz, two.at(t).wxyz)
    assert np.array_equal(one.at(t).angular_velocity, two.at(t).angular_velocity)


@pytest.mark.parametrize("tiny", [5e-324, 1e-200, 1e-30, 1e-17])
def test_products_of_inertia_that_hardly_are(tiny):
    """Between diagonal and full there is no step: off-diagonal entries however small."""
    state = states.sample(1, families=["tumbling"])[0]
    rows = np.diag(state.moments)
    rows[0, 2] = rows[2, 0] = tiny
    seconds = states.epochs(state, (10, 1e3))
    with mp.workdps(40):
        exact = Oracle(state.moments, state.wxyz0, state.omega0, digits=DIGITS)
        history = _motion(rows, state.wxyz0, state.omega0).at(seconds)
        errors = [error_of(q, exact.at(t)[0]) for q, t in zip(history.wxyz, seconds, strict=True)]
    # the axes turn by tiny over the difference of moments, the attitude by a few times that
    assert max(errors) <= LIMIT + 1e5 * tiny


def test_equal_moments_in_turned_axes_stay_exactly_equal():
    """8 1 1 / 1 8 1 / 1 1 8 has moments 7, 7, 10: found equal, so the top is symmetric."""
    rows = [[8.0, 1.0, 1.0], [1.0, 8.0, 1.0], [1.0, 1.0, 8.0]]
    motion = _motion(rows, (1, 0, 0, 0), (0.3, -0.2, 0.5))
    assert np.array_equal(motion.body.moments, [7.0, 7.0, 10.0])
    assert motion.mode is Mode.SYMMETRIC or Mode.SYMMETRIC in motion.within_rounding


@pytest.mark.parametrize(
    ("family", "expected"),
    [
        ("symmetric", Mode.SYMMETRIC),
        ("sphere", Mode.SPHERICAL),
        ("principal_axis", Mode.PRINCIPAL_AXIS),
        ("separatrix", Mode.SEPARATRIX),
    ],
)
def test_what_holds_within_rounding_is_told(family, expected):
    """A turned and rounded tensor is not exactly degenerate, and `within_rounding` says of what."""
    for state in states.sample(10, families=[family], seed=24):
        rows, omega0 = states.tensor(state)
        motion = _motion(rows, state.wxyz0, omega0)
        assert motion.mode is expected or expected in motion.within_rounding


@pytest.mark.parametrize("omega", [(1e-7, 1, 1e-7), (1e-9, 1, 1e-8), (3e-8, 1, 0), (2e-14, 1, 0)])
def test_a_flip_far_from_the_separatrix_is_told_to_be_none_of_it(omega):
    """The distance is of the second order in the two other rates; their rounding is of them."""
    assert _motion(np.diag([1.0, 2.0, 2.7]), (1, 0, 0, 0), omega).within_rounding == ()
    on_it, moments = np.array([1e-7, 1, 1e-7 / np.sqrt(2.7 * 0.7)]), np.array([1.0, 2.0, 2.7])
    for order in ([0, 1, 2], [1, 2, 0]):
        motion = _motion(np.diag(moments[order]), (1, 0, 0, 0), on_it[order])
        assert motion.mode is Mode.SEPARATRIX or Mode.SEPARATRIX in motion.within_rounding


def test_momentum_and_energy_of_a_tensor():
    state = states.sample(1, families=["tumbling"])[0]
    rows, omega0 = states.tensor(state)
    motion = _motion(rows, state.wxyz0, omega0)
    exact = Oracle.from_tensor(rows, state.wxyz0, omega0)
    start = exact.at(0.0)
    right = np.array([float(x) for x in exact.momentum(*start)])
    assert np.max(np.abs(motion.momentum - right)) < 2e-15 * np.linalg.norm(right)
    assert motion.energy == pytest.approx(float(exact.energy(start[1])), rel=2e-15)
