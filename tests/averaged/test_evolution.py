"""Years of mean rotation: windows of paths, trees, ends, resonances, ensembles, figures."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from attitude import AttitudeError, Body, Ensemble, FreeRotation, Spin, paths, quaternion, shape
from attitude.averaged import (
    AveragedEvent,
    AveragedHistory,
    AveragedMotion,
    _mean_state,
    _resonances,
)
from attitude.averaged import _rates as layout
from attitude.averaged._pack import ripple_period
from attitude.averaged._polhode import Axes, Nutations
from attitude.splitting import TorquedRotation
from attitude.torques import (
    IGRF,
    ConstantTorque,
    DipoleField,
    EddyCurrent,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    MagneticDipole,
    Maxwell,
    QualityFactor,
    Rheology,
    SolarRadiation,
)
from tests.support.mean_motions import (
    AU,
    DAY,
    ENVISAT,
    EPOCH,
    GM,
    circle,
    late_passages,
    spinning,
)

RADIUS = 6.3712e6
GOES = Body(moments=(3432.1, 980.5, 3570.0))
WING = shape.box_wing((2, 2, 2.3), (3.6, 2.7), gap=1.4, wings=1, wing_angle="17 deg")
EARTH = paths.relative("earth", "sun")


def sunlit(path=EARTH):
    return SolarRadiation(WING, path, 0.3, 0.3)


def tumbling(passages="likeliest", **settings):
    """A box with a wing, a day's turn of which is 72 s: it tumbles within half a year."""
    spin = spinning(np.radians((0.1, 0.3, 4.8)), (0.71, 0.35, -0.42, 0.45))
    return AveragedMotion(GOES, spin, sunlit(), passages=passages, degree=12, **settings)


# ---- Windows, questions and their order


def test_a_window_keeps_the_places_of_its_numbers():
    """The last window is shorter: numbers of the second path stand elsewhere in it."""
    orbit = circle(42e6, -1e3, 2.5e7)
    torques = [GravityGradient(orbit, GM), EddyCurrent(1e6, DipoleField((0, 0, -7.8e22)), orbit)]
    motion = AveragedMotion(ENVISAT, spinning(), torques, orbit="followed")
    before, _ = motion.packing.rates_of(0.0, motion.start, motion.start_region)
    motion.packing.window(2.4999e7, 1.0)
    after, _ = motion.packing.rates_of(0.0, motion.start, motion.start_region)
    assert motion.packing.packed.length < 2.5e7
    assert np.array_equal(before, after)


def test_draws_of_one_direction_do_not_depend_on_the_other():
    torques = [InternalDissipation(1e-3), ConstantTorque((0, 0, 0.01))]
    spin = spinning((0.13, 0.0078, 0.0078))
    one, two = (AveragedMotion(ENVISAT, spin, torques, passages=5) for _ in range(2))
    two.at(-3e4)
    assert np.array_equal(one.at(2e5).momentum, two.at(2e5).momentum)


def test_events_end_with_the_epochs_asked():
    motion = tumbling()
    states = motion.at(np.linspace(0.0, 1.5 * 365.25 * DAY, 400))
    passages = [event for event in motion.events if event.kind == "passage"]
    assert len(passages) >= 2
    assert max(event.seconds for event in motion.events) <= 1.5 * 365.25 * DAY
    # the momentum circles an end of the axis of the largest moment, or of the smallest
    axis = np.argmax(np.abs(states.near_end), axis=1)
    moments = np.diag(motion.body.tensor)
    np.testing.assert_array_equal(moments[axis] == moments.max(), states.mode == "SAM")
    np.testing.assert_array_equal(moments[axis] == moments.min(), states.mode == "LAM")
    # each change of mode of the history lies at a passage
    changes = states.seconds[1:][states.mode[1:] != states.mode[:-1]]
    step = states.seconds[1]
    for change in changes:
        assert any(0.0 <= change - event.seconds <= step for event in passages)


def test_a_daily_turn_about_the_earth_is_averaged():
    """The parallax of a satellite does not shorten the steps, and changes nothing else."""
    orbit = paths.kepler(
        center="earth", semi_major_axis="42164 km", eccentricity=0.0, inclination="5 deg",
        node=0.0, pericenter_argument=0.0, epoch=EPOCH, frame="icrf",
    )  # fmt: skip
    light = sunlit(paths.relative(orbit, "sun"))
    assert ripple_period(light, spinning().epoch) == pytest.approx(86164.0, abs=1.0)
    spin = spinning(np.radians((0.1, 0.3, 4.8)), (0.71, 0.35, -0.42, 0.45))
    smooth = AveragedMotion(GOES, spin, light, tolerance=1e-9, degree=8)
    full = AveragedMotion(GOES, spin, light, orbit="followed", tolerance=1e-9, degree=8)
    one, two = smooth.at(100.0 * DAY), full.at(100.0 * DAY)
    assert len(smooth._tracks[0].rows) < 0.3 * len(full._tracks[0].rows)
    # the parallax, 2.8e-4 rad, of a torque that turns the momentum by 6e-3 rad a day
    assert np.linalg.norm(one.momentum - two.momentum) < 4e-6 * one.size


def test_an_eclipse_takes_its_share_of_the_push():
    """A satellite at 7000 km behind the Earth for 34 % of its turn, in the plane of the Sun."""
    sun = paths.relative("earth", "sun").position(spinning().epoch, np.array([0.0]))[0]
    ex, ez = -sun / np.linalg.norm(sun), np.array([0.0, 0.0, 1.0])
    ey = np.cross(ez, ex) / np.linalg.norm(np.cross(ez, ex))
    normal = np.cross(ex, ey)
    tilt, node = math.acos(normal[2]), math.atan2(normal[0], -normal[1])
    orbit = paths.kepler(
        center="earth", semi_major_axis="7000 km", eccentricity=0.0, inclination=tilt,
        node=node, pericenter_argument=0.0, epoch=EPOCH, frame="icrf",
    )  # fmt: skip
    path = paths.relative(orbit, "sun")
    lit = SolarRadiation(WING, path, 0.3, 0.3)
    dark = SolarRadiation(WING, path, 0.3, 0.3, shadow_of=[EARTH])
    spin = spinning(np.radians((0.1, 0.3, 30.0)))
    rates = []
    for light in (lit, dark):
        motion = AveragedMotion(GOES, spin, light, degree=8)
        rates.append(motion.packing.rates_of(0.0, motion.start, motion.start_region)[0])
    share = np.linalg.norm(rates[1][:3]) / np.linalg.norm(rates[0][:3])
    expected = 1.0 - math.asin(6378.1 / 7000.0) / math.pi
    # 48 epochs a turn, and the penumbra: 1 %
    assert share == pytest.approx(expected, abs=0.012)


def ellipse(t):
    """About a focus, e = 0.4."""
    mean = 2.0 * math.pi * np.asarray(t) / 3e7
    anomaly = mean.copy()
    for _ in range(60):
        anomaly = mean + 0.4 * np.sin(anomaly)
    return _in_plane(np.cos(anomaly) - 0.4, math.sqrt(0.84) * np.sin(anomaly))


def spring(t):
    """An ellipse about its centre, as under a force in proportion to the distance."""
    angle = 2.0 * math.pi * np.asarray(t) / 3e7
    return _in_plane(np.cos(angle), 0.6 * np.sin(angle))


def beside(t):
    """A circle about a point beside the Sun, at one speed: no central force."""
    angle = 2.0 * math.pi * np.asarray(t) / 3e7
    return _in_plane(np.cos(angle) + 0.1, np.sin(angle))


def _in_plane(x, y):
    return AU * (x[..., None] * [0.6, 0.0, 0.8] + y[..., None] * [0.0, 1.0, 0.0])


@pytest.mark.parametrize(("path", "directions"), [(ellipse, 1), (spring, 1), (beside, 32)])
def test_a_turn_under_a_central_force_is_one_direction(path, directions):
    """1/r^2 makes time the angle: the normal stands for all directions, as their mean says."""
    mean, along = (
        AveragedMotion(GOES, spinning(), sunlit(path), orbit=orbit, degree=12)
        for orbit in ("averaged", "followed")
    )
    assert mean.packing.packed.models[0, layout.NODES] == directions
    t = 3e7 * (np.arange(400) + 0.5) / 400
    for region, pole in ((0, (0.3, 0.2, 0.9)), (3, (-0.7, 0.5, 0.1))):
        y = mean.axes.separatrix + (0.4 if region > 1 else -0.4)
        x = np.append(300.0 * np.array(pole), y)
        turn = np.array([along.packing.rates_of(when, x, region)[0] for when in t])
        # to the error of splines along the path
        scale = np.sqrt(np.mean(turn**2, axis=0))
        found = mean.packing.rates_of(0.0, x, region)[0]
        assert np.max(np.abs(found - np.mean(turn, axis=0)) / scale) < 3e-6


# ---- Trees


def test_branches_are_known_up_to_the_end_of_the_tree():
    motion = tumbling(passages="all")
    year = 365.25 * DAY
    t = np.linspace(0.0, year, 50)
    states = motion.at(t)
    leaves = motion.branches()
    assert states.momentum.shape == (len(leaves), 50, 3)
    assert np.array_equal(states.odds, leaves.odds)
    assert np.sum(states.odds) == pytest.approx(1.0, abs=0.01)
    assert np.all(np.diff(leaves.odds) <= 0.0)
    for leaf, momentum in zip(leaves, states.momentum, strict=True):
        assert np.array_equal(leaf.at(t).momentum, momentum)
        assert all(event.seconds <= year for event in leaf.events)
        assert len(leaf.regions) == 1 + sum(event.kind == "passage" for event in leaf.events)
    with pytest.raises(AttitudeError, match="longer tree"):
        leaves[0].at(2.0 * year)
    with pytest.raises(AttitudeError, match="longer tree"):
        leaves.at(-1.0)
    assert len(leaves.table()) == len(leaves)
    table = states[:, :].table()
    assert np.array_equal(table["size"].value, states.size.ravel(), equal_nan=True)
    table = states.table()
    assert np.array_equal(table["branch"], np.repeat(np.arange(1, len(leaves) + 1), 50))
    assert np.array_equal(table["odds"], np.repeat(leaves.odds, 50))
    with pytest.raises(AttitudeError, match="no epoch has been asked"):
        tumbling().branches()


def test_the_likeliest_motion_is_a_branch():
    motion = tumbling()
    states = motion.at(365.25 * DAY)
    leaves = motion.branches(365.25 * DAY).at(365.25 * DAY)
    gaps = np.linalg.norm(leaves.momentum - states.momentum, axis=1) / states.size
    assert np.min(gaps) < 1e-9


def test_branches_of_the_past():
    motion = AveragedMotion(ENVISAT, spinning((0.13, 0.0078, 0.0078)), LinearDamping(0.05))
    leaves = motion.branches(-1e5)
    assert leaves.until == -1e5
    assert leaves.at(np.array([-1e5, 0.0])).size.shape == (len(leaves), 2)


# ---- Ends, errors


def test_a_body_too_slow_for_its_path_ends_with_an_event():
    """Damping slows the spin until ten turns take as long as the orbit, which is followed."""
    torques = [LinearDamping(1.0), GravityGradient(circle(42e6), GM * 1e-3)]
    motion = AveragedMotion(ENVISAT, spinning((0.0, 0.0, 0.03)), torques, orbit="followed")
    last = motion.reaches(1e6)
    end = motion.ends(1e6)
    assert end.kind == "too slow for its path"
    assert end.seconds == last < 1e6
    turn = 2.0 * math.pi * 129112.0 / float(motion.at(last).size)
    period = 2.0 * math.pi * math.sqrt(42e6**3 / GM)
    slow = motion.packing.torques.slowest(*_state(motion.at(last)))
    assert turn <= slow
    assert 10.0 * slow == pytest.approx(period, rel=1e-6)
    with pytest.raises(AttitudeError, match=r"too slow for its path.*TorquedRotation"):
        motion.at(1e6)


def _state(states):
    return float(states.size), float(states.y), int(states.region)


def test_a_path_that_is_shorter_than_the_span_is_a_sentence():
    motion = AveragedMotion(ENVISAT, spinning(), GravityGradient(circle(12e6, -1e5, 1e6), GM))
    motion.at(9e5)
    with pytest.raises(AttitudeError, match="give a longer path, a field of one epoch"):
        motion.at(2e6)


@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_the_estimate_bounds_the_error_of_first_order(scale):
    orbit = circle(7.141e6)
    torque = EddyCurrent(scale * np.diag([1e6, 2.2e6, 3e6]), DipoleField((1e22, 0, -7.8e22)), orbit)
    motion = AveragedMotion(ENVISAT, spinning((0.13, 0.0078, 0.0078)), torque)
    found = motion.check(1000)
    estimate = float(motion.error_estimate(found["seconds"]))
    assert abs(found["size"]) < max(estimate, 1e-9)
    assert found["pole"] < estimate < 0.1 * abs(found["size change"])


def test_the_estimate_has_the_harmonics_that_are_left_out():
    """The error of first order alone is below half of the error of |L|."""
    motion = AveragedMotion(GOES, spinning((0.05, 0.004, 0.003)), sunlit())
    found = motion.check(60)
    estimate = float(motion.error_estimate(found["seconds"]))
    assert abs(found["size"]) < estimate < 0.1 * abs(found["size change"])
    assert found["pole"] < 3.0 * estimate


def test_the_estimate_under_sunlight_averaged_over_an_orbit():
    """The place on the orbit at the epoch, and harmonics beyond the degree, as shares of torque."""
    motion = AveragedMotion(GOES, spinning((0.0, 0.01, 9.0)), sunlit(), orbit="averaged", degree=12)
    first, rate = motion.at(0.0), motion.at(0.0).size / GOES.moments[2]
    start, later = motion.error_estimate([1.0, 1.0 + 365.25 * DAY])
    assert start == pytest.approx(first.weakness * rate * 365.25 * DAY / (2.0 * math.pi), rel=1e-3)
    assert later - start == pytest.approx(
        0.25 / 12**2 * first.weakness * rate * 365.25 * DAY, rel=0.05
    )


# ---- Resonances


RESONANT_PLACE = AU * np.array([-0.717137, 0.358569, -0.597614])


def before_a_resonance(ratio, span):
    """Sunlight of one direction, and the mean state half a span before a resonance in LAM."""

    def sun(t):
        return np.broadcast_to(RESONANT_PLACE, (*np.shape(t), 3)).copy()

    light, rate = sunlit(sun), 2.0 * math.pi / 600.0
    first = AveragedMotion(
        GOES, spinning((0.0, 0.9 * rate, 0.1 * rate), (1, 0, 0, 0)), light, degree=16
    )
    listed = _resonances.listed(first.packing.torques)
    (y,) = [y for j, k, is_long, y in listed if is_long and (j, k) == ratio]
    x = np.append(3570.0 * rate * np.array([0.59761, 0.358569, 0.717137]), y)
    x[3] -= first.packing.rates_of(0.0, x, 2)[0][3] * span / 2.0
    return light, AveragedHistory(first.packing, np.array(0.0), x, np.array(2))


def crossing(ratio, span, until, torque=None):
    """The motion that crosses a resonance after half a span, and its event."""
    light, states = before_a_resonance(ratio, span)
    spin = states.free_rotation(phases=(0.3, 0.6)).spin
    motion = AveragedMotion(GOES, spin, torque or light, degree=16)
    motion.at(until)
    (event,) = [event for event in motion.events if event.ratio == ratio]
    return motion, event


@pytest.mark.slow
def test_a_resonance_scatters_as_full_motions_do():
    """P_psi/P_phi = 5/6, 24 random phases: deviations within 30 %, two to three of their errors."""
    span = 6.0 * DAY
    light, states = before_a_resonance((5, 6), span)
    rng, gaps, kicks = np.random.default_rng(0), [], []
    for _ in range(24):
        free = states.free_rotation(phases=tuple(rng.random(2)))
        motion = AveragedMotion(GOES, free.spin, light, degree=16)
        mean = float(motion.at(span).y)
        turn = 0.1 / np.linalg.norm(free.spin.angular_velocity)
        history = TorquedRotation(GOES, free.spin, light, step=turn).at(span)
        spin = Spin(motion.epoch.after(span), history.wxyz, history.angular_velocity)
        after = motion.axes.state(spin.angular_velocity)[1]
        given = motion.axes, GOES, spin, motion.torques, motion.epoch, span
        shift, bend = _mean_state.corrections(*given)
        gaps.append(after - bend - mean)
        momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ GOES.tensor) - shift
        kicks.append(momentum / motion.at(span).size - motion.at(span).pole)
    (event,) = [event for event in motion.events if event.ratio == (5, 6)]
    assert event.kind == "resonance"
    assert not event.may_capture
    assert np.std(gaps) == pytest.approx(event.scatter, rel=0.3)
    (branch,) = motion.branches(span)
    scatter = branch.scatter(span)
    assert float(scatter["y"]) == pytest.approx(event.scatter, rel=0.05)
    along = np.array(kicks) @ motion.at(span).pole
    across = np.array(kicks) - along[:, None] * motion.at(span).pole
    assert np.std(along) == pytest.approx(float(scatter["size"]), rel=0.3)
    deviation = np.sqrt(np.sum(np.var(across, axis=0)))
    assert deviation == pytest.approx(float(scatter["pole"]), rel=0.3)


def test_scatter_is_nothing_before_a_resonance_and_its_kick_behind():
    motion, event = crossing((5, 6), 6.0 * DAY, 6.0 * DAY)
    (branch,) = motion.branches(6.0 * DAY)
    scatter = branch.scatter(event.seconds + np.array([-1.0, 1.0, DAY]))
    assert scatter["y"].shape == (3,)
    assert scatter["size"][0] == scatter["y"][0] == scatter["pole"][0] == 0.0
    np.testing.assert_allclose(scatter["y"][1:], event.scatter, rtol=0.05)
    assert branch.scatter(0.0)["pole"].shape == ()
    with pytest.raises(AttitudeError, match="known from 0"):
        branch.scatter(1e9)


@pytest.mark.slow
def test_a_tree_that_splits_at_resonances_has_the_scatter_of_one_that_does_not():
    """The law of total variance: that of means of leaves and of what they leave, to 3 %."""
    motion, year = tumbling(), 365.25 * DAY
    t = np.linspace(0.4, 1.0, 4) * year
    plain, tree = motion.branches(year), motion.branches(year, least_kick=1e-3)
    assert len(plain) == 4 < len(tree) <= 256
    assert np.sum(tree.odds) == pytest.approx(1.0, abs=1e-9)
    assert all(branch.kicks == () for branch in plain)
    for branch in plain[::2]:
        leaves = [leaf for leaf in tree if leaf.regions == branch.regions]
        odds = np.array([leaf.odds for leaf in leaves])
        assert np.sum(odds) == pytest.approx(branch.odds, abs=1e-6)
        assert all(len(leaf.kicks) >= 2 for leaf in leaves)
        gaps = np.array([leaf.at(t).size / branch.at(t).size - 1.0 for leaf in leaves])
        left = np.array([leaf.scatter(t)["size"] for leaf in leaves])
        before = branch.scatter(t)["size"]
        assert np.all(np.max(left, axis=0)[1:] < 0.95 * before[1:])
        total = np.sqrt(odds @ (gaps**2 + left**2) / np.sum(odds))
        np.testing.assert_allclose(total, before, rtol=0.03)
    table = tree.table()
    assert [len(text.split()) for text in table["kicks"]] == [len(leaf.kicks) for leaf in tree]


def test_a_tree_of_the_past_splits_from_the_epoch_backwards():
    leaves = tumbling().branches(-80.0 * DAY, least_kick=3e-4)
    assert len(leaves) == 16
    assert leaves.odds.tolist() == [0.0625] * 16
    for leaf in leaves:
        first, second = (seconds for seconds, _ in leaf._track.kicks)
        assert 0.0 > first > second > -80.0 * DAY


def test_a_resonance_splits_into_quarters_of_its_phases():
    motion, event = crossing((5, 6), 6.0 * DAY, 6.0 * DAY)
    (whole,) = motion.branches(6.0 * DAY, least_kick=1.01 * event.scatter)
    leaves = motion.branches(6.0 * DAY, least_kick=0.99 * event.scatter)
    assert leaves.odds.tolist() == [0.25] * 4
    before, behind = event.seconds, event.seconds + 1.1 * event.lasts
    for leaf in leaves:
        assert np.array_equal(leaf.at(before).momentum, whole.at(before).momentum)
        # the mean of a cosine over a quarter of its turn about its top
        change = float(leaf.at(behind).y - whole.at(behind).y)
        assert abs(change) == pytest.approx(2.0 / math.pi * math.sqrt(2.0) * event.scatter, rel=0.1)
        assert leaf.kicks == pytest.approx((change,), rel=1e-3)
    assert sum(leaf.kicks[0] for leaf in leaves) == pytest.approx(0.0, abs=1e-15)
    with pytest.raises(AttitudeError, match="least_kick"):
        motion.branches(6.0 * DAY, least_kick=-1e-3)


def test_a_tree_has_as_many_branches_as_are_wanted():
    motion, year = tumbling(), 365.25 * DAY
    few, many = (motion.branches(year, least_kick=5e-4, most=most) for most in (64, 1024))
    assert len(few) <= 64 < 256 < len(many) <= 1024
    assert np.sum(many.odds) == pytest.approx(1.0, abs=1e-9)
    (likeliest,) = motion.branches(year, most=1)
    assert likeliest.regions == motion.branches(year)[0].regions
    with pytest.raises(AttitudeError, match="most"):
        motion.branches(year, most=0)


def test_the_loop_of_a_resonance_is_that_of_a_pendulum():
    """u' = a + b cos f has a loop of 16 sqrt(b) without a, none for b < a, a quadrature between."""
    area, flow, push = _resonances._loop(np.zeros(4), np.array([[0, 0, 0, 0.5]]), 1.0, 1.0)
    assert area == pytest.approx(16.0, rel=1e-4)
    assert push == 0.0

    def below(f):
        """How far the potential lies below that of the saddle, for a = 2.4 and b = 6."""
        return 2.4 * (f - saddle) + 6.0 * (math.sin(f) - math.sin(saddle))

    saddle = -math.acos(-0.4)
    turn = brentq(below, saddle - 2.0 * math.pi + 0.1, math.acos(-0.4) - 2.0 * math.pi)
    expected = quad(lambda f: 2.0 * math.sqrt(2.0 * max(below(f), 0.0)), turn, saddle, limit=200)[0]
    for sign in (1.0, -1.0):
        rates = sign * np.array([0.3, 0.0, 0.0, 0.4])
        area, flow, push = _resonances._loop(rates, np.array([[0, 0, 0, 0.5]]), 2.0, 3.0)
        assert area == pytest.approx(expected / 2.0, rel=1e-4)
        np.testing.assert_allclose(flow, [0.3 * sign * area, 0.0, 0.0], rtol=1e-12)
        assert push == pytest.approx(1.2)
    area, flow, _ = _resonances._loop(
        np.array([0, 0, 0, 1.1]), np.array([[0, 0, 0, 0.5]]), 1.0, 1.0
    )
    assert area == 0.0
    assert np.all(flow == 0.0)


def test_the_divergence_of_torques():
    """-C tr(1/I) of damping; 0 of light; friction draws motions away from the long axis."""
    spin = spinning((0.13, 0.0078, 0.0078))

    def divergence(body, torque):
        return _mean_state.divergence(body, spin, [torque], spin.epoch)

    expected = -0.002 * np.sum(1.0 / ENVISAT.moments)
    assert divergence(ENVISAT, LinearDamping(0.002)) == pytest.approx(expected, rel=1e-9)
    assert divergence(GOES, sunlit()) == 0.0
    assert divergence(ENVISAT, InternalDissipation(1e-3)) > 0.0
    about_short = spinning((0.001, 0.001, 0.1))
    friction = [InternalDissipation(1e-3)]
    assert _mean_state.divergence(ENVISAT, about_short, friction, spin.epoch) < 0.0


@pytest.mark.slow
def test_a_resonance_captures_as_full_motions_are_held():
    """P_psi/P_phi = 1/1, whose loop grows as damping takes L: 60 full motions.

    The odds are an estimate: their order is looked at.  Some are held, most pass.
    """
    body, count, axes = GOES, 60, Axes(GOES)
    light, states = before_a_resonance((1, 1), 2.0)
    place = float(states.y)
    lost = damping_shares(axes, place)
    damping = LinearDamping(3e-4 * axes.matrix @ np.diag([1.0, 0.0, lost]) @ axes.matrix.T)
    torques = [light, damping]
    given = spinning((0.009, 0.0, 0.001), (1, 0, 0, 0))
    packing = AveragedMotion(body, given, torques, degree=16).packing
    state = np.append(states.momentum, place)
    state = state - 9.0 * DAY * packing.rates_of(0.0, state, 2)[0]
    start = AveragedHistory(packing, np.array(0.0), state, np.array(2))
    spin = start.free_rotation(phases=(0.1, 0.2)).spin
    motion = AveragedMotion(body, spin, torques, degree=16)
    motion.at(40.0 * DAY)
    (event,) = [event for event in motion.events if event.ratio == (1, 1)]
    assert 0.03 < event.capture < 0.2
    assert f"odds {event.capture:.2g}" in str(event)
    rng, held = np.random.default_rng(5), 0
    for _ in range(count):
        free = start.free_rotation(phases=tuple(rng.random(2)))
        step = 0.1 / np.linalg.norm(free.spin.angular_velocity)
        # at a time that does not look like a Julian date
        later = event.seconds + 0.8 * event.lasts
        end = TorquedRotation(body, free.spin, torques, step=step).at(later)
        held += abs(axes.state(end.angular_velocity)[1] - place) < event.width
    assert 0.25 * count * event.capture < held < 4.0 * count * event.capture
    assert 0 < held < count // 2


def damping_shares(axes, y):
    """Damping about the short axis, in units of that about the long one, that leaves y in place."""
    nutation = Nutations.of(axes, 2, np.array([y - axes.separatrix]))
    lost = nutation.gamma[0] * nutation.squares[0] / axes.moments
    return -lost[0] / lost[2]


def test_the_loop_of_a_torque_averaged_over_an_orbit_takes_few_nodes(monkeypatch):
    """16 epochs of 64 nodes of each phase have those of 256 at one epoch."""
    taken, series = [], _mean_state.series
    monkeypatch.setattr(
        _mean_state, "series", lambda *args: taken.append(args[-1]) or series(*args)
    )
    for orbit, nodes in (("averaged", [64] * 16), ("followed", [256])):
        packing = AveragedMotion(GOES, spinning(), sunlit(), orbit=orbit, degree=12).packing
        taken.clear()
        _resonances._resonant(packing, 0.0, np.array([0.0, 300.0, 400.0, 9.0]), 2, (1, 1, 0), 256)
        assert taken == nodes


def test_a_strong_resonance_is_named():
    """P_psi/P_phi = 1/1 under sunlight: resonant terms are ten times the mean rate."""
    _, event = crossing((1, 1), 6.0 * DAY, 8.0 * DAY)
    assert event.may_capture
    assert event.strength == pytest.approx(9.7, rel=0.1)
    assert "may capture" in str(event)


class Still(paths.Path):
    """The place of `before_a_resonance`, as a path that has no epoch."""

    name, center, source = "body", "sun", "a fixed place"

    def position(self, instant, seconds, low=None):
        return np.broadcast_to(RESONANT_PLACE, (*np.shape(seconds), 3)).copy()


@pytest.mark.parametrize(("ratio", "span"), [((1, 1), 80.0 * DAY), ((5, 6), 20.0 * DAY)])
def test_a_resonance_is_integrated_through(ratio, span):
    """To behind its width; the change of y there is that of the mean motion and its scatter."""
    motion, event = crossing(ratio, span, 0.9 * span, sunlit(Still()))
    place = float(motion.at(event.seconds).y)
    behind = motion.through(event, phases=(0.1, 0.4))
    seconds = float(behind.epoch.seconds - motion.epoch.seconds)
    assert seconds >= event.seconds + 0.999 * event.lasts
    mean = motion.at(seconds)
    before = float(motion.at(event.seconds - event.lasts).y)
    assert (float(behind.start[3]) - place) * (before - place) < 0.0
    assert abs(float(behind.start[3]) - place) > 0.9 * event.width
    if not event.may_capture:
        assert abs(float(behind.start[3] - mean.y)) < 3.0 * event.scatter
    assert float(behind.at(0.0).size) == pytest.approx(float(mean.size), rel=1e-2)


def test_what_is_no_resonance_is_not_integrated_through():
    motion, event = crossing((5, 6), 6.0 * DAY, 6.0 * DAY)
    with pytest.raises(AttitudeError, match="a function of seconds"):
        motion.through(event)
    with pytest.raises(AttitudeError, match="give one of the resonances"):
        motion.through(AveragedEvent("passage", 1.0, "SAM+", "LAM+"))
    with pytest.raises(AttitudeError, match="on its other side"):
        motion.through(replace(event, seconds=0.1 * event.lasts))


def test_resonances_with_an_orbit_are_listed():
    """w_phi - 2 w_psi = 4 n of eddy currents, whose kick is seen in full motions: 2.5e-4 in y.

    docs/averaged.md has the full motion, of 100 d; kicks of the two ways of the phases differ.
    """
    path = circle(RADIUS + 770e3, slope=math.radians(98.5))
    tensor = 1e6 * np.array([[1.0, 0.1, 0.0], [0.1, 2.2, 0.2], [0.0, 0.2, 3.0]])
    torque = EddyCurrent(tensor, DipoleField((0.0, 0.0, -7.76e22)), path)
    omega = np.array([0.01, 0.01, 0.045])
    start, pole = ENVISAT.moments * omega, np.array([0.5, 0.3, 0.6])
    half = start / np.linalg.norm(start) + pole / np.linalg.norm(pole)
    spin = spinning(omega, np.append(0.0, half / np.linalg.norm(half)))
    motion = AveragedMotion(ENVISAT, spin, torque, orbit="averaged")
    motion.at(40.0 * DAY)
    listed = [event for event in motion.events if event.turns and event.scatter > 3e-5]
    assert [(event.ratio, abs(event.turns)) for event in listed] == [((2, 1), 4)]
    (event,) = listed
    assert 1e-4 < event.scatter < 4e-4
    assert not event.may_capture
    assert "w_path" in str(event)
    assert 20.0 * DAY < event.seconds < 28.0 * DAY


def test_friction_has_no_resonances():
    motion = AveragedMotion(ENVISAT, spinning((0.13, 0.0078, 0.0078)), InternalDissipation(1e-3))
    motion.at(1e5)
    assert {event.kind for event in motion.events} <= {"passage", "uniform rotation reached"}


# ---- The separatrix


@pytest.mark.parametrize(
    ("push", "count"), [(0.0, 80), (0.5, 80), pytest.param(-0.8, 200, marks=pytest.mark.slow)]
)
def test_a_passage_is_early_or_late_as_in_full_motions(push, count):
    """Friction and a torque about the short axis: full motions of random phases.

    The root mean square of 16 to 60 such times within 35 %, two to three of its errors: they have
    long tails.
    """
    torques = [InternalDissipation(3e-4), ConstantTorque((0.0, 0.0, 1.06e-4 * push))]
    passage, early = late_passages(Body(moments=(1.0, 2.0, 2.6)), torques, count)
    assert passage.is_proved
    assert np.sqrt(np.mean(early[:, 0] ** 2)) == pytest.approx(passage.delay, rel=0.35)


# ---- Friction of a material, and the error of a comparison


@pytest.mark.parametrize(
    "law", [QualityFactor(2e5, 5.0), Maxwell(2e5, 3e5), lambda f: (1.0 - 0.2j * np.sqrt(f)) / 2e5]
)
@pytest.mark.parametrize("omega", [(0.02, 0.03, 0.3), (0.4, 0.02, 0.05)])
def test_a_rheology_damps_as_the_full_motion(law, omega):
    """y to 3e-4 of its change, the order of the weakness; Maxwell's body passes the separatrix."""
    axes = np.array([1.0, 0.8, 0.5])
    mass = 4.0 / 3.0 * np.pi * 2000.0 * np.prod(axes)
    body = Body(moments=mass / 5.0 * (axes @ axes - axes**2))
    friction = InternalDissipation(Rheology(axes, 2000.0, law))
    motion = AveragedMotion(body, spinning(omega), friction)
    states = motion.at([0.0, 6e4])
    step = 0.1 / np.linalg.norm(omega)
    history = TorquedRotation(body, spinning(omega), friction, step=step).at(6e4)
    truth = motion.axes.state(history.angular_velocity)[1]
    assert abs(states.y[1] - truth) < 3e-4 * abs(states.y[1] - states.y[0])
    assert float(states.size[1]) == pytest.approx(float(states.size[0]), rel=1e-12)
    assert 1e-6 < states.weakness[0] < 0.05


def test_a_comparison_knows_its_own_error():
    """Light on facets needs steps of 0.04 rad; the error is that of twice the steps."""
    spin = spinning(np.radians((0.1, 0.3, 4.8)), (0.71, 0.35, -0.42, 0.45))
    motion = AveragedMotion(GOES, spin, sunlit(), degree=12)
    result = motion.check(300)
    assert result["step"] <= 0.075 / np.linalg.norm(spin.angular_velocity)
    for name in ("size", "energy", "pole"):
        full = motion._of_full_motion(result["seconds"], 0.25 * result["step"])
        coarse = motion._of_full_motion(result["seconds"], result["step"])
        if name == "pole":
            gap = np.linalg.norm(np.cross(full.pole, coarse.pole))
        else:
            gap = abs(float(getattr(coarse, name) / getattr(full, name)) - 1.0)
        assert gap <= max(2.0 * result[f"{name} error"], 1e-10)


# ---- Fields that turn with the Earth


@pytest.mark.slow
def test_a_field_is_averaged_over_days():
    """Means under weights of three days: those of 20 days of turns, one by one, to 2e-4."""
    path = circle(7.144e6, slope=math.radians(98.4))
    torque = EddyCurrent(1e6, IGRF(8), path)
    motion = AveragedMotion(ENVISAT, spinning((0.0, 0.001, 0.05)), torque, orbit="averaged")
    sampling, mean = motion.packing.packed.means[0]
    assert sampling.smooth == pytest.approx(3.0 * 86164.1, rel=1e-6)
    middle = 15.0 * DAY
    weighed = motion.packing.packed.sampled(sampling, mean, np.array([middle]))[0]
    count = 288
    turns = middle + sampling.period * (np.arange(count) - 0.5 * (count - 1))
    single = motion.packing.packed.sampled(replace(sampling, smooth=0.0), mean, turns)
    assert np.max(np.ptp(single, axis=0)) > 2e-2 * np.max(np.abs(weighed))  # within a day
    assert np.max(np.abs(np.mean(single, axis=0) - weighed)) < 2e-3 * np.max(np.abs(weighed))
    assert sampling.interval > 3.0 * DAY


# ---- Ensembles


def members(count=3):
    rng = np.random.default_rng(4)
    rates = np.radians((0.1, 0.3, 4.8)) * rng.uniform(0.8, 1.2, size=(count, 1))
    return Ensemble(GOES, rng.normal(size=(count, 4)), rates, EPOCH)


def test_members_are_the_motions_of_their_states():
    t = np.linspace(0.0, 365.25 * DAY, 9)
    ensemble = members().averaged(sunlit(), passages="likeliest", degree=12)
    states = ensemble.at(t)
    assert states.momentum.shape == (3, 9, 3)
    for k in (0, 2):
        alone = AveragedMotion(GOES, members()[k].spin, sunlit(), degree=12)
        assert np.array_equal(alone.at(t).momentum, states.momentum[k])
        assert np.array_equal(alone.at(t).P_phi, states.P_phi[k])
    again = members().averaged(sunlit(), passages="likeliest", degree=12).at(t, threads=2)
    assert np.array_equal(again.momentum, states.momentum)
    table = ensemble.table(t[-1])
    assert list(table["region"]) == [
        ("SAM+", "SAM-", "LAM+", "LAM-")[k] for k in states.region[:, -1]
    ]


@pytest.mark.slow
def test_members_of_second_order():
    """Each is its motion of second order, which differs from that of first order."""
    torques = [InternalDissipation(1e-3), ConstantTorque((0.05, 0.02, 0.05))]
    spins = [spinning((0.13, 0.0078, 0.0078)), spinning()]
    motions = Ensemble.of([FreeRotation(ENVISAT, spin) for spin in spins])
    one, two = (motions.averaged(torques, order=order).at([5e3]) for order in (1, 2))
    for k, spin in enumerate(spins):
        alone = AveragedMotion(ENVISAT, spin, torques, order=2).at([5e3])
        assert np.array_equal(alone.momentum, two.momentum[k])
    gaps = np.linalg.norm(one.momentum - two.momentum, axis=-1) / one.size
    assert np.all((gaps > 1e-9) & (gaps < 1e-3))
    with pytest.raises(AttitudeError, match="order is 3; give 1 or 2"):
        motions.averaged(torques, order=3)


def test_members_of_several_bodies_draw_each_for_itself():
    bodies = [ENVISAT, Body(moments=(17023.0, 120000.0, 129112.0)), ENVISAT, ENVISAT]
    spin = spinning((0.13, 0.0078, 0.0078))
    motions = [FreeRotation(body, spin) for body in bodies]
    ensemble = Ensemble.of(motions, names=list("abcd")).averaged(InternalDissipation(1e-3))
    states = ensemble.at([0.0, 1e5])
    assert states.energy[1, 0] == pytest.approx(motions[1].energy, rel=1e-5)
    assert len({int(region) for region in states.region[:, 1]}) == 2  # a fair coin, four times
    assert ensemble["b"].body is bodies[1]


def test_a_member_that_ends_is_unknown_beyond():
    torques = [LinearDamping(1.0), GravityGradient(circle(42e6), GM * 1e-3)]
    motions = [FreeRotation(ENVISAT, spinning((0.0, 0.0, w))) for w in (0.03, 300.0)]
    ensemble = Ensemble.of(motions).averaged(torques, orbit="followed")
    states = ensemble.at([0.0, 6e5])
    assert states.is_known.tolist() == [[True, False], [True, True]]
    assert np.isnan(states.P_phi[0, 1])
    assert states.mode[0, 1] == ""
    assert [None if end is None else end.kind for end in ensemble.ends(6e5)] == [
        "too slow for its path",
        None,
    ]


def test_members_that_means_refuse():
    spins = [spinning(), spinning((1e-5, 1e-6, 1e-5))]
    motions = Ensemble.of([FreeRotation(ENVISAT, spin) for spin in spins])
    with pytest.raises(AttitudeError, match="member 1: the torques are not weak"):
        motions.averaged(ConstantTorque((1e-3, 0, 0)))
    states = motions.averaged(ConstantTorque((1e-3, 0, 0)), on_error="nan").at([0.0, 10.0])
    assert states.is_known.tolist() == [[True, True], [False, False]]
    with pytest.raises(AttitudeError, match="follows a tree for each member"):
        motions.averaged(ConstantTorque((1e-3, 0, 0)), passages="all")
    with pytest.raises(AttitudeError, match="refused"):
        motions.averaged(ConstantTorque((1e-3, 0, 0)), on_error="nan")[1]
    other = Spin("2027-01-01", (1, 0, 0, 0), (0.0, 0.0, 0.1))
    several = Ensemble.of([FreeRotation(ENVISAT, spins[0]), FreeRotation(ENVISAT, other)])
    with pytest.raises(AttitudeError, match="epochs of their own"):
        several.averaged(ConstantTorque((1e-3, 0, 0)))


# ---- Figures


def test_a_figure_has_the_curves_and_the_events(tmp_path):
    motion = tumbling()
    end = 365.25 * DAY
    figure = motion.plot(tmp_path / "motion.png", until=end, title="tumbling")
    assert (tmp_path / "motion.png").read_bytes()[:4] == b"\x89PNG"
    momentum, tilt, _, periods, _ = figure.axes
    t, size = momentum.lines[0].get_data()
    assert np.allclose(size, motion.at(t * DAY).size, rtol=1e-12)
    theta = np.nansum([line.get_ydata() for line in tilt.lines[:2]], axis=0)
    assert np.allclose(theta, np.degrees(motion.at(t * DAY).theta))
    assert len(periods.lines) > 2
    passages = [event for event in motion.events if event.kind == "passage"]
    marks = [line for line in momentum.lines if np.ptp(line.get_xdata()) == 0.0]
    assert {round(event.seconds / DAY, 6) for event in passages} <= {
        round(float(line.get_xdata()[0]), 6) for line in marks
    }


def test_a_figure_of_branches(tmp_path):
    motion = tumbling(passages="all")
    figure = motion.plot(tmp_path / "tree.svg", until=365.25 * DAY)
    assert len(figure.axes[0].lines) == len(motion.branches(365.25 * DAY))
    with pytest.raises(AttitudeError, match="two at least"):
        motion.at(0.0).plot()
    with pytest.raises(AttitudeError, match="empty"):
        tumbling().plot(until=0.0)


def test_a_magnetic_dipole_moves_the_pole_alone():
    field = DipoleField((0, 0, -7.8e22))
    motion = AveragedMotion(ENVISAT, spinning(), MagneticDipole((10, 0, 50.0), field, circle(8e6)))
    states = motion.at([0.0, 1e5])
    assert states.size[1] == pytest.approx(states.size[0], rel=1e-9)
    assert np.linalg.norm(states.pole[1] - states.pole[0]) > 1e-4
