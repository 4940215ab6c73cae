"""FreeRotation: mode, periods, momentum, energy, and epochs of every kind."""

import copy
import datetime
import math
import pickle

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time, TimeDelta
from mpmath import mp, mpf

from attitude import AttitudeError, AttitudeHistory, Body, FreeRotation, Mode, Spin, propagate
from tests.support import states
from tests.support.measure import motion_of
from tests.support.oracle import Oracle

EPOCH = "2026-01-01T00:00:00"
PAPER = FreeRotation(
    Body(moments=(10, 20, 26)),
    Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1)),
)


# ---- periods, against complete integrals in mpmath ---------------------------------------------


def _periods(state):
    """(psi, phi) in s: 4 K / wp, and 2 pi over the mean rate of phi, L/I3 + ... Pi(n|m) / K."""
    with mp.workdps(60):
        moments, omega = list(map(mpf, state.moments)), list(map(mpf, state.omega0))
        order = sorted(range(3), key=lambda k: moments[k])
        middle = moments[order[1]]
        d2 = sum(i * (i - middle) * w**2 for i, w in zip(moments, omega, strict=True))
        if d2 < 0:
            order.reverse()
        (i1, i2, i3), (w1, w2, w3) = ([row[k] for k in order] for row in (moments, omega))
        d1 = i2 * (i2 - i1) * w2**2 + i3 * (i3 - i1) * w3**2
        d3 = i1 * (i1 - i3) * w1**2 + i2 * (i2 - i3) * w2**2
        m = d3 * (i1 - i2) / (d1 * (i3 - i2))
        n = -(i3 / i1) * (i1 - i2) / (i2 - i3)
        speed = mp.sqrt(d1 * (i3 - i2) / (i1 * i2 * i3))
        momentum = mp.sqrt(sum((i * w) ** 2 for i, w in zip(moments, omega, strict=True)))
        quarter, third = mp.ellipk(m), mp.ellippi(n, m)
        mean = momentum / i3 * (1 + (i3 - i1) / i1 * third / quarter)
        return float(4 * quarter / speed), float(2 * mp.pi / abs(mean))


@pytest.mark.parametrize(
    "family", ["tumbling", "wobble", "near_symmetric", "near_spherical", "flat", "units"]
)
def test_periods_of_tumbling(family):
    """psi about the axis that L circulates about, phi of that axis about L: 1e-14."""
    for state in states.sample(10, families=[family], seed=31):
        motion = motion_of(state)
        psi, phi = _periods(state)
        assert motion.period_psi == pytest.approx(psi, rel=1e-14)
        assert motion.period_phi == pytest.approx(phi, rel=1e-13)


def test_the_rates_repeat_after_period_psi():
    for state in states.sample(4, families=["tumbling"], seed=32):
        motion = motion_of(state)
        omega = motion.angular_velocity_at(np.array([0.0, 1.0, 1000.0]) * motion.period_psi)
        assert np.max(np.abs(omega - omega[0])) < 1e-11  # rad/s: the period is rounded


def test_the_period_grows_without_bound_towards_the_separatrix():
    """Like log(1 / distance), with no jump down to 1e-16."""
    periods = []
    for k in range(1, 17):
        motion = motion_of(
            states.State("", (2.0, 5.0, 6.0), (1.0, 0, 0, 0), (1.0, 0.7, 1.0 + 10.0**-k))
        )
        periods.append(motion.period_psi)
        if motion.mode is not Mode.SEPARATRIX:
            assert motion.separatrix_distance > 0.0
    steps = np.diff(periods[4:15])
    # 10^-k is rounded in the sum, by up to 1e-2 of it at the last
    assert np.allclose(steps, steps[0], rtol=0.05)
    assert periods[15] == math.inf  # 1 + 1e-16 is 1


# ---- where it is ------------------------------------------------------------------------------


@pytest.mark.parametrize("family", ["near_separatrix", "tumbling", "wobble"])
def test_distance_to_the_separatrix_has_all_its_digits(family):
    """1 - 2 E I2 / L^2 in mpmath, positive in SAM: 1e-14 relative even where it is 1e-16."""
    for state in states.sample(12, families=[family], seed=33):
        with mp.workdps(80):
            moments, omega = list(map(mpf, state.moments)), list(map(mpf, state.omega0))
            energy = sum(i * w**2 for i, w in zip(moments, omega, strict=True))
            momentum2 = sum((i * w) ** 2 for i, w in zip(moments, omega, strict=True))
            exact = float(1 - energy * sorted(moments)[1] / momentum2)
        motion = motion_of(state)
        assert motion.separatrix_distance == pytest.approx(exact, rel=1e-14)
        assert (motion.mode is Mode.SHORT_AXIS) == (exact > 0)


def test_circulation_is_told_by_name():
    for state in states.sample(20, families=["tumbling"], seed=34):
        motion = motion_of(state)
        expected = {Mode.LONG_AXIS: "long", Mode.SHORT_AXIS: "short"}[motion.mode]
        assert motion.circulates_about == expected
        assert Oracle(*state[1:]).mode == {"long": "LAM", "short": "SAM"}[expected]


def test_momentum_and_energy_of_the_example():
    """In ICRF and joule, fixed: as computed by hand for moments 10, 20, 26 and rates 1, 15, 1."""
    assert np.array_equal(PAPER.momentum, (10.0, 300.0, 26.0))
    assert PAPER.energy == 0.5 * (10 + 20 * 225 + 26)
    turned = FreeRotation(
        PAPER.body,
        Spin(
            epoch=EPOCH,
            wxyz=(math.sqrt(0.5), 0, 0, math.sqrt(0.5)),  # a quarter turn about z
            angular_velocity=(1, 15, 1),
        ),
    )
    assert np.allclose(turned.momentum, (-300.0, 10.0, 26.0), rtol=0, atol=1e-13)


def test_momentum_is_in_icrf_whatever_the_frame_of_the_spin():
    tilt = math.radians(84381.448 / 3600)
    spin = Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1), frame="ecliptic")
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    expected = (0, -3 * math.sin(tilt), 3 * math.cos(tilt))
    assert np.allclose(motion.momentum, expected, rtol=0, atol=2e-15)
    pole = motion.at(12345.0).body_to_inertial((0, 0, 1))
    assert np.allclose(pole, np.array(expected) / 3, rtol=0, atol=1e-15)


# ---- epochs of every kind ----------------------------------------------------------------------


def test_every_kind_of_epoch_is_the_same_instant():
    """Ten days later: TDB seconds, durations, dates; UTC days carry no leap second in 2026."""
    ten = 864000.0
    exact = PAPER.at(ten).wxyz
    for t in (
        864000,
        10 * u.day,
        datetime.timedelta(days=10),
        np.timedelta64(10, "D"),
        TimeDelta(10, format="jd", scale="tdb"),
    ):
        assert np.array_equal(PAPER.at(t).wxyz, exact), t
    seconds = None
    for t in (
        "2026-01-11",
        "2026-01-11T00:00:00",
        Time("2026-01-11", scale="utc"),
        datetime.datetime(2026, 1, 11),
        np.datetime64("2026-01-11"),
        ["2026-01-11"],
    ):
        history = PAPER.at(t)
        total = float(np.ravel(history.seconds)[0]) + float(np.ravel(history.low)[0])
        seconds = seconds or total
        assert total == pytest.approx(ten, abs=1e-3)  # s: TDB - TT changes by milliseconds
        assert total == pytest.approx(seconds, abs=1e-9)
        # 15 rad/s times the 1e-9 s that these agree to
        assert np.max(np.abs(np.ravel(history.wxyz) - PAPER.at(seconds).wxyz)) < 2e-8


def test_shapes_follow_the_epochs():
    for shape in ((), (0,), (1,), (5,), (2, 3), (2, 0)):
        history = PAPER.at(np.zeros(shape))
        assert history.wxyz.shape == (*shape, 4)
        assert history.angular_velocity.shape == (*shape, 3)
        assert history.shape == shape


def test_it_is_the_motion_of_propagate():
    """Bit by bit, for moments in body axes."""
    t = np.linspace(-1e8, 1e8, 301)
    wxyz, omega = propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), t, angular_velocity=True)
    history = PAPER.at(t)
    assert np.array_equal(history.wxyz, wxyz)
    assert np.array_equal(history.angular_velocity, omega)


@pytest.mark.parametrize("low", [1e-9, 10.0, 1e6, [1e-9], [-5.0, 3.0]])
def test_seconds_in_two_doubles(low):
    """t + low, whichever is the larger."""
    t = np.array([100.0, 200.0]) if np.size(low) == 2 else np.array([100.0])
    split, whole = PAPER.at(t, low=low), PAPER.at(t + np.array(low))
    assert np.max(np.abs(split.wxyz - whole.wxyz)) < 1e-6 * np.spacing(1e6) * 1e9
    exact = Oracle((10.0, 20.0, 26.0), (1.0, 0, 0, 0), (1.0, 15.0, 1.0))
    for k, (a, b) in enumerate(zip(t, np.broadcast_to(low, t.shape), strict=True)):
        right = [float(x) for x in exact.at(a, float(b))[0]]
        assert np.max(np.abs(split.wxyz[k] - right)) < 4e-15


# ---- values ------------------------------------------------------------------------------------


def test_a_motion_is_a_value():
    for name in ("momentum", "_constants"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(PAPER, name)[0] = 0
    with pytest.raises(AttributeError):
        PAPER.spin = None
    for again in (copy.copy(PAPER), copy.deepcopy(PAPER), pickle.loads(pickle.dumps(PAPER))):
        assert again.mode is Mode.SHORT_AXIS
        assert np.array_equal(again.at(7.0).wxyz, PAPER.at(7.0).wxyz)
        assert np.array_equal(again._constants, PAPER._constants)


def test_asking_does_not_freeze_what_was_given():
    t, low = np.array([1.0, 2.0]), np.zeros(2)
    PAPER.at(t, low=low)
    t[0] = low[0] = 5.0


def test_printing():
    assert repr(PAPER) == "<FreeRotation: SHORT_AXIS, from 2026-01-01T00:00:00 UTC>"
    assert "short" in str(PAPER).lower() and "2.347" in str(PAPER)


# ---- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "spin"),
    [
        (PAPER.spin, PAPER.body),
        (PAPER.body, None),
        ((10, 20, 26), PAPER.spin),
        (Body, PAPER.spin),
    ],
)
def test_what_makes_no_motion(body, spin):
    with pytest.raises(AttitudeError, match="FreeRotation takes a Body and a Spin"):
        FreeRotation(body, spin)


def test_a_rod_cannot_spin_about_itself():
    rod = Body(moments=(0, 1, 1))
    good = Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(0, 1, 2))
    assert FreeRotation(rod, good).mode is Mode.PRINCIPAL_AXIS
    bad = Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(1e-3, 1, 2))
    with pytest.raises(AttitudeError, match=r"axis without inertia.*Give 0 for that component"):
        FreeRotation(rod, bad)


def test_moments_too_far_apart():
    spin = Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(0, 1, 2))
    with pytest.raises(AttitudeError, match="may differ by a factor of at most 1e45"):
        FreeRotation(Body(moments=(1e-46, 1, 1)), spin)


@pytest.mark.parametrize(
    ("t", "low", "message"),
    [
        (1e17, None, "an epoch lies 1e\\+17 s from that of the state.*Give a nearer epoch"),
        ([0.0, -1e17], None, "1e\\+17 s"),
        (math.inf, None, "inf s"),
        (0.0, 1e17, "1e\\+17 s"),
        (0.0, math.inf, "inf s"),
        ("2026-99-01", None, "t is '2026-99-01', a date that does not exist"),
        ("soon", None, "t is 'soon', which cannot be read as a date"),
        (None, None, "t is None; give"),
        ([1.0, "2026-01-01"], None, "t mixes entries of several kinds"),
        (True, None, "t is True"),
        ([[1.0, 2.0], [3.0]], None, "t is ragged"),
        (5 * u.m, None, "t is in m; give it in s"),
        ("2026-01-11", 1e-9, "low is given, but t is .*; leave out low"),
        ([1.0, 2.0], [1.0, 2.0, 3.0], r"low has shape \(3,\), t has \(2,\)"),
    ],
)
def test_bad_epochs(t, low, message):
    with pytest.raises(AttitudeError, match=message):
        PAPER.at(t, low=low)


def test_infinity_is_no_epoch_even_at_rest():
    rest = FreeRotation(
        PAPER.body, Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    )
    for t in (math.inf, -math.inf):
        with pytest.raises(AttitudeError, match="inf s"):
            rest.at(t)


def test_nan_epochs_give_nan_in_their_place():
    history = PAPER.at([0.0, math.nan, 1.0])
    assert isinstance(history, AttitudeHistory)
    assert np.array_equal(np.isnan(history.wxyz).all(axis=-1), [False, True, False])
    assert np.array_equal(np.isnan(history.angular_velocity).all(axis=-1), [False, True, False])
    assert np.array_equal(history.wxyz[[0, 2]], PAPER.at([0.0, 1.0]).wxyz)
    nat = PAPER.at(np.array(["2026-01-02", "NaT"], dtype="datetime64[s]"))
    assert np.array_equal(np.isnan(nat.wxyz).all(axis=-1), [False, True])
