"""Attitudes and rates against forty digits of mpmath, in all regimes, at all horizons.

The promise is 4e-15 rad and 4e-15 of the largest rate, whatever the body, the state and the
horizon: the phases are kept in two doubles, and what remains is the rounding of the last dozen
operations.  This file also fails when results become much worse or much better than recorded.
"""

import math
from random import Random

import numpy as np
import pytest

from attitude import Mode, propagate
from attitude._solver import codes
from attitude.errors import AttitudeError
from tests.support import states
from tests.support.measure import error_of, errors, worst
from tests.support.oracle import Oracle, rate_error
from tests.support.states import State, constants_of

PROMISE = 4e-15  # rad, and relative to the largest rate
HORIZONS = (10, 1e3, 1e6, 1e9)  # revolutions

every_family = pytest.mark.parametrize("family", states.FAMILIES)


@pytest.fixture(scope="module")
def measured():
    """Errors of 10 states of each family at 8 epochs, by family."""
    found = {}
    for state in states.sample(10):
        here = errors(state, states.epochs(state, HORIZONS))
        found.setdefault(state.family, []).extend(here)
    return found


@every_family
def test_every_regime_at_every_horizon(measured, family):
    """10 to 1e9 revolutions, both signs of t, the sign of the quaternion included."""
    attitude, rate = worst(measured[family])
    assert attitude.attitude <= PROMISE, attitude
    assert rate <= PROMISE


@pytest.mark.parametrize("revolutions", HORIZONS)
@pytest.mark.parametrize("sign", [1, -1])
def test_error_does_not_grow_with_the_horizon(measured, revolutions, sign):
    """The median at each horizon is that of all: phases in one double would give 1e-7 at 1e9."""
    found = [
        error.attitude
        for family in states.TUMBLING
        for error in measured[family]
        if 0.89 < sign * error.seconds / states.revolution(error.state) / revolutions < 1.01
    ]
    assert len(found) == 10 * len(states.TUMBLING)
    assert 1.8e-16 < np.median(found) < 4e-16  # rad; recorded: 2.6e-16 to 2.9e-16


def test_errors_are_those_recorded(measured):
    """Median and largest error of the whole sample: recorded 2.2e-16 and 1.1e-15 rad."""
    found = [error for family in measured.values() for error in family]
    attitude = [error.attitude for error in found]
    rate = [error.rate for error in found if error.rate > 0.0]
    assert 1e-16 < np.median(attitude) < 4e-16  # the promise is 6e-16
    assert 6e-16 < max(attitude) < 2e-15
    assert 6e-17 < np.median(rate) < 3e-16
    assert 3e-16 < max(rate) < 1.2e-15


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@every_family
def test_soak(family, seed):
    """A thousand more epochs of each family and seed: ten minutes in all."""
    found = []
    for state in states.sample(120, seed=seed, families=[family]):
        found += errors(state, states.epochs(state, HORIZONS, seed=seed))
    attitude, rate = worst(found)
    assert attitude.attitude <= PROMISE, attitude
    assert rate <= PROMISE
    assert np.median([error.attitude for error in found]) <= 6e-16


@every_family
def test_unit_length(family):
    """A quaternion of length 1 to a few units in the last place, at any horizon."""
    for state in states.sample(4, families=[family], seed=1):
        wxyz = propagate(state.moments, state.wxyz0, state.omega0, states.epochs(state))
        assert np.all(np.abs(np.sum(wxyz**2, axis=-1) - 1.0) < 4e-15)


@every_family
def test_at_the_epoch_itself(family):
    """t = 0 gives back the state, the sign of its quaternion included."""
    for state in states.sample(10, families=[family], seed=2):
        found = worst(errors(state, [0.0, -0.0]))
        assert found[0].attitude < 1.5e-15
        assert found[1] < 1.5e-15


@every_family
def test_short_of_a_revolution(family):
    """Epochs from 1e-12 of a revolution to a whole one, where phases start from small numbers."""
    (state,) = states.sample(1, families=[family], seed=3)
    unit = states.revolution(state)
    seconds = [sign * unit * 10.0**-k for k in range(0, 13, 3) for sign in (1, -1)]
    attitude, rate = worst(errors(state, seconds))
    assert attitude.attitude <= PROMISE
    assert rate <= PROMISE


@pytest.mark.parametrize("family", states.TUMBLING)
def test_epochs_in_two_doubles(family):
    """What one double of t leaves out moves the attitude, and is honoured: 1e15 revolutions."""
    (state,) = states.sample(1, families=[family], seed=4)
    t = 1e15 * states.revolution(state)
    low = 0.37 * math.ulp(t)
    exact = Oracle(state.moments, state.wxyz0, state.omega0)
    wxyz, omega = propagate(
        state.moments, state.wxyz0, state.omega0, [t], t_low=[low], angular_velocity=True
    )
    found = errors(state, [t], lambda *_: (wxyz, omega))
    assert found[0].attitude > 1e-4  # the oracle at t alone: it makes a difference
    right = exact.at(t, low)
    assert error_of(wxyz[0], right[0]) <= 1e-14  # rad: near the end of the reach, 5e16 turns
    assert rate_error(omega[0], right[1]) <= 1e-14


# ---- across the switches between forms ---------------------------------------------------------

# Bodies whose rate about one axis is raised until L crosses to the other side of the switch.
SWITCHES = {
    "short axis": ((10.0, 20.0, 26.0), (1.0, 3.0, None)),
    "long axis": ((10.0, 20.0, 26.0), (None, 3.0, 1.0)),
    "needle": ((1e-5, 1.0, 1.000005), (0.3, 0.7, None)),
    "needle about its length": ((1e-5, 1.0, 1.000005), (None, 0.7, 0.3)),
    "nearly symmetric": ((1.0, 1.0 + 1e-12, 1.7), (0.4, -0.6, None)),
    "flat": ((0.25, 0.75, 1.0), (-0.2, 0.5, None)),
}


def _with(omega, rate):
    return tuple(rate if w is None else w for w in omega)


def _constants(moments, omega):
    pairs = np.zeros((2, 1, 3, 2))
    pairs[0, 0, :, 0], pairs[1, 0, :, 0] = moments, omega
    identity = np.array([[1.0, 0.0, 0.0, 0.0]])
    return constants_of(pairs[0], identity, pairs[1], identity)[0]


def _neighbours(inside, low, high):
    """The two adjacent doubles between which a condition changes from false to true."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return low, high
        low, high = (low, middle) if inside(middle) else (middle, high)


@pytest.mark.parametrize("name", SWITCHES)
def test_the_switch_of_forms_is_continuous(name):
    """T = 2K'/K = 1, m = 12 sqrt(2) - 16 = 0.9706: adjacent doubles, one in each series.

    Each is right to the promise where its nome is largest, e^-pi, and fewest terms would show.
    """
    moments, omega = SWITCHES[name]

    def trigonometric(rate):
        return _constants(moments, _with(omega, rate))["form"] == codes.TRIGONOMETRIC

    middle = moments[1]
    other = 0 if omega[2] is None else 2
    axis = 2 - other
    # on the separatrix: the terms of D2 are equal
    balance = abs(omega[other]) * math.sqrt(
        moments[other]
        * abs(moments[other] - middle)
        / (moments[axis] * abs(moments[axis] - middle))
    )
    low, high = _neighbours(trigonometric, balance * (1 + 1e-9), balance * 1e6)
    assert high == math.nextafter(low, math.inf)
    rates = [_constants(moments, _with(omega, rate)) for rate in (low, high)]
    assert [int(c["form"]) for c in rates] == [codes.HYPERBOLIC, codes.TRIGONOMETRIC]
    assert rates[0]["m"] == pytest.approx(12 * math.sqrt(2) - 16, rel=1e-13)
    for speed in (math.nextafter(low, 0.0), low, high, math.nextafter(high, math.inf)):
        state = State(name, moments, (0.5, -0.1, 0.3, 0.8), _with(omega, speed))
        attitude, rate = worst(errors(state, states.epochs(state)))
        assert attitude.attitude <= 2.5e-15, attitude
        assert rate <= 2e-15


@pytest.mark.parametrize("steps", [-3, -2, -1, 0, 1, 2, 3])
@pytest.mark.parametrize("w2", [0.0, 0.7, -3.0])
def test_one_last_place_off_the_separatrix(steps, w2):
    """2 5 6 with w1 = w3 is exactly on it; the next double is not, and its period is finite."""
    w3 = 1.0 + steps * (math.ulp(1.0) if steps > 0 else math.ulp(0.5))
    state = State("separatrix", (2.0, 5.0, 6.0), (0.5, 0.5, -0.5, 0.5), (1.0, w2, w3))
    expected = Mode.SEPARATRIX if steps == 0 else Mode.SHORT_AXIS if steps > 0 else Mode.LONG_AXIS
    assert Mode(int(_constants(state.moments, state.omega0)["mode"])) is expected
    attitude, rate = worst(errors(state, states.epochs(state, (1, 3, *HORIZONS))))
    assert attitude.attitude <= PROMISE, attitude
    assert rate <= PROMISE


def test_where_the_exact_difference_takes_over():
    """|D2| = 1/16 of the sum of its terms: below, the products are summed exactly."""
    a, b, c = 2.0, 5.0, 6.0
    edge = math.sqrt(a * (b - a) / (c * (c - b)) * 17 / 15)
    rate = edge - 3 * math.ulp(edge)
    for _ in range(7):
        state = State("switch", (a, b, c), (1.0, 0.0, 0.0, 0.0), (1.0, 0.4, rate))
        assert worst(errors(state, states.epochs(state)))[0].attitude <= 2.5e-15
        rate = math.nextafter(rate, math.inf)


@pytest.mark.parametrize("small", [0.0, 5e-324, 1e-300, 1e-150, 1e-100, 1e-50, 1e-20])
def test_a_wobble_that_vanishes(small):
    """From tumbling to uniform rotation: rates so small that their squares would be 0.

    About the middle axis a rate of 1e-150 still makes the body turn over after 100 revolutions;
    rates below 2^-400 of the largest count as 0 there, which is the next test.
    """
    for axis in (0, 2) if 0.0 < small < 2.0**-400 else (0, 1, 2):
        omega = [small * w for w in (1.0, -1.0, 1.0)]
        omega[axis] = -0.8
        state = State("vanishing", (10.0, 20.0, 26.0), (0.1, 0.7, -0.1, 0.7), tuple(omega))
        attitude, rate = worst(errors(state, states.epochs(state, (10, 1e9))))
        assert attitude.attitude <= PROMISE, attitude
        assert rate <= PROMISE


def test_rates_below_the_last_that_count():
    """2^-400 of the largest, 4e-121: less is 0, and refused where it turns the body over."""
    moments, below = (10.0, 20.0, 26.0), math.nextafter(2.0**-400, 0.0)
    assert Mode(int(_constants(moments, (2.0**-400, 0.75, 0.0))["mode"])) is Mode.LONG_AXIS
    assert Mode(int(_constants(moments, (below, 0.0, 0.75))["mode"])) is Mode.PRINCIPAL_AXIS
    with pytest.raises(AttitudeError, match="400"):
        _constants(moments, (below, 0.75, 0.0))


def test_any_length_of_the_quaternion_given():
    """Lengths from 1e-300 to 1e300 are the same attitude, to the last place."""
    state = states.sample(1)[0]
    random = Random(5)
    for power in (-1000, -300, 0, 300, 1000):
        wxyz0 = tuple(math.ldexp(random.uniform(-1, 1), power) for _ in range(4))
        given = state._replace(wxyz0=wxyz0)
        assert worst(errors(given, states.epochs(given)))[0].attitude <= 2e-15


# ---- published numbers -------------------------------------------------------------------------


def test_the_example_of_the_paper_at_its_horizon():
    """Moments 10, 20, 26, rates 1, 15, 1 (section 5), to t = 60 s as in figure 3."""
    state = State("paper", (10.0, 20.0, 26.0), (1.0, 0.0, 0.0, 0.0), (1.0, 15.0, 1.0))
    attitude, rate = worst(errors(state, np.linspace(0.0, 60.0, 61).tolist()))
    assert attitude.attitude <= 2e-15
    assert rate <= 2e-15
