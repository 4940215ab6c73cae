"""Exactly degenerate bodies and states: the same figures as any other, and no special call."""

import math

import numpy as np
import pytest

from attitude import AttitudeError, Mode, propagate
from tests.support import states
from tests.support.measure import by_motion, by_propagate, error_of, errors, motion_of, worst
from tests.support.oracle import Oracle
from tests.support.states import State

PROMISE = 4e-15  # rad, and relative to the largest rate
WXYZ = (0.5, -0.1, 0.7, 0.5)

MODES = {
    "sphere": {Mode.SPHERICAL},
    "symmetric": {Mode.SYMMETRIC},
    "symmetric_equatorial": {Mode.PRINCIPAL_AXIS},
    "symmetric_polar": {Mode.PRINCIPAL_AXIS},
    "principal_axis": {Mode.PRINCIPAL_AXIS},
    "middle_axis": {Mode.PRINCIPAL_AXIS},
    "one_rate_zero": {Mode.LONG_AXIS, Mode.SHORT_AXIS},
    "separatrix": {Mode.SEPARATRIX},
    "rest": {Mode.AT_REST},
    "rod": {Mode.PRINCIPAL_AXIS},
}

every_degenerate_family = pytest.mark.parametrize("family", states.DEGENERATE)


def test_every_degenerate_family_has_a_mode():
    assert set(MODES) == set(states.DEGENERATE)


@every_degenerate_family
@pytest.mark.parametrize("evaluate", [by_propagate, by_motion])
def test_same_figures_as_any_other(family, evaluate):
    """4e-15 rad at 10 to 1e9 revolutions by both entry points, no worse than recorded (1e-15)."""
    found = []
    for state in states.sample(8, families=[family], seed=11):
        found += errors(state, states.epochs(state), evaluate)
    attitude, rate = worst(found)
    assert attitude.attitude <= 1.5e-15, attitude
    assert rate <= 1.5e-15
    assert np.median([error.attitude for error in found]) <= 4e-16


@every_degenerate_family
def test_mode_is_named(family):
    found = {motion_of(state).mode for state in states.sample(40, families=[family])}
    assert found == MODES[family]


@pytest.mark.parametrize(
    ("family", "mode"),
    [
        ("wobble", {Mode.SHORT_AXIS, Mode.LONG_AXIS}),
        ("near_symmetric", {Mode.SHORT_AXIS, Mode.LONG_AXIS}),
        ("near_separatrix", {Mode.SHORT_AXIS, Mode.LONG_AXIS}),
        ("middle_axis_wobble", {Mode.SHORT_AXIS, Mode.LONG_AXIS}),
    ],
)
def test_nearly_degenerate_is_not_degenerate(family, mode):
    """1e-15 from symmetric, principal or separatrix is none of them: no tolerance decides."""
    sample = states.sample(40, families=[family])
    assert {motion_of(state).mode for state in sample} == mode
    for state in sample:
        assert motion_of(state).mode.name.startswith(
            {"LAM": "LONG", "SAM": "SHORT"}[Oracle(state.moments, WXYZ, state.omega0).mode]
        )


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("moments", "axis", "about"),
    [
        ((10.0, 20.0, 26.0), 0, "long"),
        ((10.0, 20.0, 26.0), 2, "short"),
        ((26.0, 10.0, 20.0), 1, "long"),
        ((1.0, 1.0, 1.5), 2, "short"),
        ((1.0, 1.0, 0.5), 2, "long"),
        ((0.25, 0.75, 1.0), 2, "short"),
    ],
)
def test_periods_about_an_axis_are_those_of_a_vanishing_wobble(moments, axis, about, sign):
    """psi turns at w sqrt((I3 - I1)(I3 - I2)/(I1 I2)); psi and phi together at w."""
    omega = [0.0, 0.0, 0.0]
    omega[axis] = sign * 0.8
    still = motion_of(State("", moments, WXYZ, tuple(omega)))
    wobbling = motion_of(
        State("", moments, WXYZ, tuple(w if w else 1e-9 for w in omega)),
    )
    assert still.circulates_about == wobbling.circulates_about == about
    # a wobble of 1e-9 changes the periods by its square
    assert still.period_psi == pytest.approx(wobbling.period_psi, rel=1e-14)
    assert still.period_phi == pytest.approx(wobbling.period_phi, rel=1e-14)
    i3, (i1, i2) = moments[axis], np.delete(moments, axis)
    expected = 2 * math.pi / 0.8 * math.sqrt(i1 * i2 / ((i3 - i1) * (i3 - i2)))
    assert still.period_psi == pytest.approx(expected, rel=1e-14)
    turns = {"short": -1, "long": 1}[about] / still.period_psi + 1 / still.period_phi
    assert turns == pytest.approx(0.8 / (2 * math.pi), rel=1e-13)


@pytest.mark.parametrize(("third", "about"), [(0.4, "long"), (1.7, "short")])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_periods_of_regular_precession(third, about, axis):
    """psi: (I3 - I1)/I1 w3; phi: L/I1, both exact for a symmetric body."""
    moments, omega = [1.0, 1.0, 1.0], [0.3, 0.3, 0.3]
    moments[axis], omega[axis] = third, -0.7
    motion = motion_of(State("", tuple(moments), WXYZ, tuple(omega)))
    momentum = math.hypot(0.3, 0.3, third * 0.7)
    assert motion.circulates_about == about
    assert motion.period_psi == pytest.approx(2 * math.pi / (abs(third - 1) * 0.7), rel=1e-14)
    assert motion.period_phi == pytest.approx(2 * math.pi / momentum, rel=1e-14)


@pytest.mark.parametrize(
    ("moments", "omega", "phi"),
    [
        ((1.0, 1.0, 1.0), (0.1, 0.2, 0.2), 2 * math.pi / 0.3),  # sphere: about w
        ((1.0, 1.0, 1.5), (0.3, 0.4, 0.0), 2 * math.pi / 0.5),  # equatorial: about w
        ((10.0, 20.0, 26.0), (0.0, -0.5, 0.0), 2 * math.pi / 0.5),  # middle axis
        ((0.0, 1.0, 1.0), (0.0, 0.3, 0.4), 2 * math.pi / 0.5),  # rod
        ((2.0, 5.0, 6.0), (1.0, 0.7, 1.0), 10 * math.pi / math.hypot(2, 3.5, 6)),  # L / I2
        ((10.0, 20.0, 26.0), (0.0, 0.0, 0.0), math.inf),
    ],
)
def test_where_nothing_circulates_the_period_is_infinite(moments, omega, phi):
    motion = motion_of(State("", moments, WXYZ, omega))
    assert motion.circulates_about is None
    assert motion.period_psi == math.inf
    assert motion.period_phi == pytest.approx(phi, rel=1e-14)


def test_the_middle_axis_stays_where_it_is():
    """Unstable, yet exact rotation about it goes on for ever: 1e12 revolutions."""
    wxyz, omega = propagate(
        (10, 20, 26), (1, 0, 0, 0), (0, 2.0, 0), [0.5e12 * math.pi], angular_velocity=True
    )
    assert np.all(omega == (0.0, 2.0, 0.0))
    exact = Oracle((10.0, 20.0, 26.0), (1.0, 0.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    assert error_of(wxyz[0], exact.at(0.5e12 * math.pi)[0]) < PROMISE


def test_the_separatrix_ends_at_the_middle_axis():
    """From one sense of the middle axis to the other, once: w2 -> -+ L / I2 for t -> +- inf."""
    moments, omega0 = (2.0, 5.0, 6.0), (1.0, 0.7, 1.0)
    size = math.hypot(2.0, 3.5, 6.0) / 5.0
    _, omega = propagate(moments, WXYZ, omega0, [-1e9, 1e9], angular_velocity=True)
    signs = np.sign(omega[:, 1])
    assert sorted(signs) == [-1.0, 1.0]
    assert np.all(np.abs(omega[:, 1]) == pytest.approx(size, rel=4e-15))
    assert np.all(np.abs(omega[:, [0, 2]]) < 1e-100)  # rad/s: sech of 1e9


def test_rates_too_small_to_follow_are_refused_where_they_turn_the_body_over():
    """Below 2^-400 of the spin about the middle axis; elsewhere they are 0, above they count."""
    for omega in ((1e-125, 1.0, 0.0), (0.0, -1.0, 1e-200), (1e-100, 1.0, 1e-130)):
        with pytest.raises(AttitudeError, match="turn the body over"):
            propagate((1, 2, 2.6), WXYZ, omega, [2000.0])
    for moments, omega in (((1, 2, 2.6), (1e-125, 1e-130, 1.0)), ((1, 2, 2), (1e-125, 1.0, 0.0))):
        zeros = [w if w == 1.0 else 0.0 for w in omega]
        assert np.array_equal(*(propagate(moments, WXYZ, w, [2e3]) for w in (omega, zeros)))
    for omega in ((3e-120, 1.0, 0.0), (4e-119, 1.0, 3e-119)):
        state = State("flip", (1.0, 2.0, 2.6), WXYZ, omega)
        assert worst(errors(state, [500.0, 580.0, 2000.0]))[0].attitude <= PROMISE


def test_rest_is_rest():
    wxyz, omega = propagate(
        (10, 20, 26), WXYZ, (0, -0.0, 0), [0.0, 1e300, -1e300, 1.0], angular_velocity=True
    )
    assert np.all(wxyz == wxyz[0]) and np.all(omega == 0.0)
    assert np.allclose(wxyz[0], np.array(WXYZ) / np.linalg.norm(WXYZ), rtol=0, atol=2e-16)


def test_a_flat_body_within_rounding_is_one():
    """0.1 + 0.2 exceeds 0.3 by rounding, in either sense: 1e-14 of the triangle is forgiven."""
    for moments in ((0.1, 0.2, 0.3), (0.1, 0.2, 0.1 + 0.2), (0.1, 0.2, math.nextafter(0.3, 1))):
        state = State("flat", moments, WXYZ, (0.4, 0.3, -0.8))
        assert worst(errors(state, states.epochs(state)))[0].attitude <= PROMISE


@pytest.mark.parametrize("zero", [(0.0, 0.0), (-0.0, 0.0), (0.0, -0.0), (-0.0, -0.0)])
def test_signs_of_zero_do_not_matter(zero):
    """About each axis, in either sense: -0.0 is 0.0."""
    for axis in range(3):
        for rate in (1.5, -1.5):
            plain, signed = [0.0, 0.0, 0.0], list(np.insert(zero, axis, rate))
            plain[axis] = rate
            results = [propagate((10, 20, 26), WXYZ, w, [0.3, 1e6]) for w in (plain, signed)]
            assert np.array_equal(*results)
