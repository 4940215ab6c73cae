"""Years of mean rotation: windows of paths, trees, ends, resonances, ensembles, figures."""

import math

import numpy as np
import pytest

from attitude import AttitudeError, Body, Ensemble, FreeRotation, Spin, paths, shape
from attitude.averaged import AveragedHistory, AveragedMotion, _mean_state, _resonances
from attitude.averaged._pack import ripple_period
from attitude.splitting import TorquedRotation
from attitude.torques import (
    ConstantTorque,
    DipoleField,
    EddyCurrent,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    MagneticDipole,
    SolarRadiation,
)

EPOCH = "2026-01-01"
ENVISAT = Body(moments=(17023.0, 124826.0, 129112.0))
GOES = Body(moments=(3432.1, 980.5, 3570.0))
WING = shape.box_wing((2, 2, 2.3), (3.6, 2.7), gap=1.4, wings=1, wing_angle="17 deg")
AU, GM, DAY = 149597870700.0, 3.986004418e14, 86400.0
EARTH = paths.relative("earth", "sun")


def spinning(omega=(0.039, 0.0052, 0.026), wxyz=(0.8, 0.2, 0.4, 0.4)):
    return Spin(epoch=EPOCH, wxyz=wxyz, angular_velocity=omega)


def circle(radius, first=-1e9, last=1e9):
    """A circular orbit that is known for a span."""

    class Circle(paths.Path):
        name, center, source = "satellite", "earth", "a circle"
        span = tuple(spinning().epoch.after(t) for t in (first, last))

        def position(self, instant, seconds, low=None):
            t = np.asarray(seconds) + (instant.seconds - spinning().epoch.seconds)
            angle = math.sqrt(GM / radius**3) * t
            return radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)

    return Circle()


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
    with pytest.raises(AttitudeError, match="give a longer path, or other epochs"):
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


# ---- Resonances


def before_a_resonance(ratio, span):
    """Sunlight of one direction, and the mean state half a span before a resonance in LAM."""
    place = AU * np.array([-0.717137, 0.358569, -0.597614])

    def sun(t):
        return np.broadcast_to(place, (*np.shape(t), 3)).copy()

    light, rate = sunlit(sun), 2.0 * math.pi / 600.0
    first = AveragedMotion(
        GOES, spinning((0.0, 0.9 * rate, 0.1 * rate), (1, 0, 0, 0)), light, degree=16
    )
    listed = _resonances.listed(first.packing.torques)
    (y,) = [y for j, k, is_long, y in listed if is_long and (j, k) == ratio]
    x = np.append(3570.0 * rate * np.array([0.59761, 0.358569, 0.717137]), y)
    x[3] -= first.packing.rates_of(0.0, x, 2)[0][3] * span / 2.0
    return light, AveragedHistory(first.packing, np.array(0.0), x, np.array(2))


@pytest.mark.slow
def test_a_resonance_scatters_as_full_motions_do():
    """P_psi/P_phi = 5/6, 24 random phases: the deviation within 30 %, three of its errors."""
    span = 6.0 * DAY
    light, states = before_a_resonance((5, 6), span)
    rng, gaps = np.random.default_rng(0), []
    for _ in range(24):
        free = states.free_rotation(phases=tuple(rng.random(2)))
        motion = AveragedMotion(GOES, free.spin, light, degree=16)
        mean = float(motion.at(span).y)
        turn = 0.1 / np.linalg.norm(free.spin.angular_velocity)
        history = TorquedRotation(GOES, free.spin, light, step=turn).at(span)
        spin = Spin(motion.epoch.after(span), history.wxyz, history.angular_velocity)
        after = motion.axes.state(spin.angular_velocity)[1]
        bend = _mean_state.corrections(motion.axes, GOES, spin, motion.torques, motion.epoch, span)
        gaps.append(after - bend[1] - mean)
    (event,) = [event for event in motion.events if event.ratio == (5, 6)]
    assert event.kind == "resonance"
    assert not event.may_capture
    assert np.std(gaps) == pytest.approx(event.scatter, rel=0.3)


def test_a_strong_resonance_is_named():
    """P_psi/P_phi = 1/1 under sunlight: resonant terms are ten times the mean rate."""
    light, states = before_a_resonance((1, 1), 6.0 * DAY)
    motion = AveragedMotion(GOES, states.free_rotation(phases=(0.3, 0.6)).spin, light, degree=16)
    motion.at(8.0 * DAY)
    (event,) = [event for event in motion.events if event.ratio == (1, 1)]
    assert event.may_capture
    assert event.strength == pytest.approx(9.7, rel=0.1)
    assert "may capture" in str(event)


def test_friction_has_no_resonances():
    motion = AveragedMotion(ENVISAT, spinning((0.13, 0.0078, 0.0078)), InternalDissipation(1e-3))
    motion.at(1e5)
    assert {event.kind for event in motion.events} <= {"passage", "uniform rotation reached"}


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
