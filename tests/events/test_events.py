"""Events between samples: against closed forms, dense samples, and the laws of mirrors."""

import pickle

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Scene, Spin, epochs, events, paths
from attitude.epochs import instant
from attitude.events._channels import Aberrated, Fixed
from attitude.events._search import source_of
from attitude.motions._table import AttitudeTable
from attitude.torques._arcs import Arcs, Impulse
from benchmarks import events as benchmark
from tests.support.places import DATA

TURN = 2.0 * np.pi


def spinning(rate=0.1, **keywords):
    spin = Spin(
        epoch="2026-01-01", wxyz=keywords.pop("wxyz", (1, 0, 0, 0)), angular_velocity=(0, 0, rate)
    )
    return FreeRotation(Body(moments=(1, 2, 3)), spin)


def tumbling(omega=(0.1, 1.5, 0.1)):
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=omega)
    return FreeRotation(Body(moments=(10, 20, 26)), spin)


# None is missed -----------------------------------------------------------------------------------


@pytest.mark.parametrize("number", range(6))
def test_none_is_missed_against_samples(number):
    # The benchmark itself, on six kinds of tumblers: events, changes that samples see, missed, ...
    found, seen, missed, *_ = benchmark.compare(number, rotations=30, step=3e-4)
    assert seen > 10 and missed == 0 and found >= seen


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9, 1e-11])
def test_tangencies_down_to_the_stated_tolerance(depth):
    # The direction passes the rim of the cone at that depth: in for 2 sqrt(2 depth / sin) or so.
    latitude = 0.3
    motion = spinning(1.0)
    direction = (np.cos(latitude), 0, np.sin(latitude))
    nearest = latitude  # of an axis in the equator to a direction at that latitude
    for side, count in ((1.0, 2), (-1.0, 0)):
        cone = events.in_cone(motion, (0, 1, 0), direction, nearest + side * depth)
        found = events.find_discrete(0, TURN, cone)
        assert len(found) == count
        if count:
            half = np.arccos(np.cos(nearest + depth) / np.cos(latitude))
            # Where the depth is d, the epoch is known to its rounding over sqrt(d).
            width = np.diff(found.seconds)[0]
            assert width == pytest.approx(2 * half, rel=1e-3)
            assert width > events.TOUCH


def test_a_wide_search_equals_many_narrow_ones():
    motion = tumbling()
    lit = events.illuminated(motion, (0, 1, 1), sun=(1, 0, 1))
    whole = events.find_discrete(0, 3000, lit)
    parts = [events.find_discrete(a, a + 37.5, lit) for a in np.arange(0, 3000, 37.5)]
    np.testing.assert_allclose(
        np.concatenate([part.seconds for part in parts]), whole.seconds, rtol=0, atol=1e-11
    )
    assert np.all(whole.values[1:] != whole.values[:-1])
    streamed = [part.seconds for part in events.stream(0, 30000, lit)]
    assert len(streamed) > 2
    long = events.find_discrete(0, 30000, lit)
    np.testing.assert_array_equal(np.concatenate(streamed), long.seconds)
    np.testing.assert_allclose(long.seconds[: len(whole)], whole.seconds, rtol=0, atol=1e-11)


# Against closed forms -----------------------------------------------------------------------------


def test_cone_crossings_of_a_uniform_rotation():
    found = events.find_discrete(
        0, 10 * TURN / 0.1, events.in_cone(spinning(), (1, 0, 0), (0, 1, 0), "10 deg")
    )
    angle = (
        np.pi / 2 + np.radians(10) * np.tile([-1.0, 1.0], 10) + np.repeat(np.arange(10), 2) * TURN
    )
    # 1e-9 of a turn is asked for; the epochs here have 1e-13 of one.
    np.testing.assert_allclose(found.seconds * 0.1, angle, rtol=0, atol=1e-13 * TURN)
    np.testing.assert_array_equal(found.values, np.tile([True, False], 10))
    assert found.spans().shape == (10, 2)
    np.testing.assert_allclose(np.diff(found.spans()), np.radians(20) / 0.1, atol=1e-10)


@pytest.mark.parametrize("turns", [1e6, 1e9])
def test_precision_far_from_the_epoch(turns):
    # One double of seconds has 1e-10 of a turn at 1e6 turns, and 1e-7 at 1e9.
    motion = spinning(0.7)
    start = TURN / 0.7 * turns
    found = events.find_discrete(
        start, start + 30.0, events.in_cone(motion, (1, 0, 0), (0, 1, 0), 0.5)
    )
    from mpmath import mp, mpf

    with mp.workdps(40):
        for hi, lo, value in zip(found.seconds, found.low, found.values, strict=True):
            phase = (mpf(hi) + mpf(lo)) * mpf(0.7) / (2 * mp.pi)
            angle = float((phase - mp.floor(phase)) * 2 * mp.pi)
            wanted = np.pi / 2 - 0.5 if value else np.pi / 2 + 0.5
            assert angle == pytest.approx(wanted, abs=1e-12)
    assert len(found) >= 6


def test_a_flat_mirror_at_3_5_deg_per_second_flashes_for_0_08_s():
    # The mirrored observer runs over the Sun's disc (0.533 deg) at twice the rate of the mirror.
    motion = spinning(np.radians(3.5))
    sun, observer = (1, 0, 0), (np.cos(1.0), np.sin(1.0), 0)
    flash = events.glint(motion, (1, 0, 0), sun, observer)
    (begin, end) = events.find_discrete(0, 100, flash).spans()[0]
    assert end - begin == pytest.approx(2 * events.SUN_RADIUS / np.radians(7.0), rel=1e-9)
    assert end - begin == pytest.approx(0.08, abs=0.005)
    assert 0.5 * (begin + end) * np.radians(3.5) == pytest.approx(0.5, abs=1e-12)


def test_the_back_of_a_mirror_does_not_flash():
    motion = spinning(0.5)
    both = events.find_discrete(
        0, TURN / 0.5, events.glint(motion, (1, 0, 0), (1, 0, 0), (0, 1, 0))
    )
    assert len(both) == 2  # half a turn later the mirror shows its back
    grazing = events.glint(motion, (1, 0, 0), (1, 0, 0.001), (-1, 0, 0.002), sun_radius=0.01)
    times, values = events.find_discrete(0, TURN / 0.5, grazing)
    t = np.linspace(0, TURN / 0.5, 400001)
    states = grazing(t)
    changes = np.flatnonzero(states[1:] != states[:-1])
    assert len(changes) == len(times) > 0
    np.testing.assert_allclose(t[changes], times, atol=t[1])
    np.testing.assert_array_equal(values, states[changes + 1])


def test_aberration_of_mirrors_in_motion():
    motion = spinning(0.01)
    sun, observer = (1, 0, 0), (np.cos(1.0), np.sin(1.0), 0)

    def middle(velocity):
        flash = events.glint(motion, (1, 0, 0), sun, observer, velocity=velocity)
        return 0.5 * sum(events.find_discrete(0, 100, flash).seconds) * 0.01

    bisector = np.array([np.cos(0.5), np.sin(0.5), 0])
    along = np.array([-np.sin(0.5), np.cos(0.5), 0])
    rest, speed = middle(None), 3e6  # 1e-2 of the speed of light
    beta = speed / 299792458.0
    # In its own plane a mirror may move as it likes (to the second order, 5e-5).
    assert middle(speed * along) == pytest.approx(rest, abs=5e-5)
    # A mirror that comes reflects nearer to its normal than light falls in (Einstein 1905,
    # section 8): it must be turned towards the observer, by b sin of the angle of incidence.
    assert middle(speed * bisector) - rest == pytest.approx(beta * np.sin(0.5), rel=0.02)
    # Towards the Sun: what comes in is not bent, what goes out by b sin.
    assert middle(speed * np.array(sun)) - rest == pytest.approx(0.5 * beta * np.sin(1.0), rel=0.02)


def test_the_constant_of_aberration():
    moment = source_of(spinning()).at(np.zeros(1), np.zeros(1))
    u = Fixed((0, 1, 0))
    seen = Aberrated(u, (30e3, 0, 0), source_of(spinning()), sent=False).icrf(moment)
    # sin of the shift is b for a velocity at right angles: 20.6 arcsec.
    assert np.degrees(np.arcsin(seen[0])) * 3600 == pytest.approx(20.6406, abs=1e-3)
    sent = Aberrated(u, (30e3, 0, 0), source_of(spinning()), sent=True).icrf(moment)
    np.testing.assert_allclose(sent, seen * [-1, 1, 1], atol=1e-16)


def test_meridian_transits_average_to_the_period_of_phi():
    # The long axis circles the momentum in P_phi (its own convention) on the average.
    motion = tumbling((9.0, 2.0, 1.0))
    past = events.past_meridian(motion, None, (1, 0.2, 0.3))
    transits = events.find_discrete(0, 2000 * motion.regime.P_phi_L, past)
    transits = transits[transits.values]
    mean = (transits.seconds[-1] - transits.seconds[0]) / (len(transits) - 1)
    assert mean == pytest.approx(motion.regime.P_phi_L, rel=1e-3)
    assert len(transits) == pytest.approx(2000, abs=2)


# Extrema ------------------------------------------------------------------------------------------


def test_nearest_approaches_are_zeros_of_the_derivative():
    motion = tumbling()
    near = events.separation(motion, (1, 2, 3), (0, 1, 1))
    times, angles = events.find_minima(0, 500, near)
    farthest, _ = events.find_maxima(0, 500, near)
    t = np.linspace(0, 500, 500001)
    y = near(t)
    least = t[1:-1][(y[1:-1] < y[:-2]) & (y[1:-1] <= y[2:])]
    np.testing.assert_allclose(times, least, atol=2e-3)
    assert abs(len(farthest) - len(times)) <= 1
    # Second order: a microsecond to either side it is farther by 1e-12 rad or less, not nearer.
    for dt in (-1e-4, 1e-4):
        assert np.all(near(times + dt) > angles)


def test_moving_and_fixed_directions_agree():
    motion = tumbling()
    moving = events.Moving(lambda t: np.tile([0.0, 1.0, 1.0], (len(t), 1)))
    for make in (
        lambda d: events.find_minima(0, 200, events.separation(motion, (1, 2, 3), d)),
        lambda d: events.find_discrete(0, 200, events.in_cone(motion, (1, 2, 3), d, 0.4)),
    ):
        one, other = make((0, 1, 1)), make(moving)
        np.testing.assert_allclose(one.seconds, other.seconds, rtol=0, atol=1e-10)


def test_a_moving_direction_after_an_impulse():
    """The rate of the rotation is thousand times that of the first epoch of the search."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e-3, 2e-3, 1.2e-3))
    kick = Impulse(at=1000.0, angular_momentum=(0, 30.0, 5.0))
    arcs, turn = Arcs(Body(moments=(10, 20, 26)), spin, [kick]), TURN / 5e3
    angle = events.separation(
        arcs,
        (0.2, 0.5, 1),
        lambda t: np.stack([np.cos(turn * t), np.sin(turn * t), 0.3 + 0 * t], axis=-1),
    )
    t = np.linspace(0.0, 1200.0, 600001)
    y = angle(t)
    least = t[1:-1][(y[1:-1] < y[:-2]) & (y[1:-1] <= y[2:])]
    assert len(events.find_minima(0.0, 900.0, angle)) == np.sum(least < 900.0)
    found = events.find_minima(0.0, 1200.0, angle)
    np.testing.assert_allclose(found.seconds, least, rtol=0, atol=2e-3)


@pytest.mark.parametrize("direction", ["sun", "observer"])
def test_extrema_in_a_scene_up_to_the_ends_of_its_path(direction):
    """Exact slopes of directions that move, of light that is delayed, against samples."""
    start = epochs.instant("2026-01-01")
    orbit = paths.kepler(
        epoch=start, semi_major_axis=8e6, eccentricity=0.01, inclination=1.0, node=0.3,
        pericenter_argument=2.0, mean_anomaly=1.0, center="earth",
    )  # fmt: skip
    t = np.arange(0.0, 601.0, 30.0)
    table = paths.table(t, *orbit.state(start, t), start=start, center="earth")
    scene = Scene(tumbling((0.1, 0.15, 0.1)), table, "earth", light_time=False)
    angle = events.separation(scene, (1, 0.2, 0.3), direction)
    found = events.find_minima(*table.span, angle)
    scene = Scene(tumbling((0.1, 0.15, 0.1)), orbit, "earth")
    angle = events.separation(scene, (1, 0.2, 0.3), direction)
    delayed = events.find_minima(*table.span, angle)
    sampled = events.find_minima(*table.span, angle, step=0.1)
    assert len(found) == len(delayed) > 10
    np.testing.assert_allclose(delayed.seconds, sampled.seconds, rtol=0, atol=1e-8)


def test_extrema_of_arcs_in_a_scene():
    """Joints are seen a light time later: there extrema are searched by values."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 0.2, 0.12))
    kick = Impulse(at=50.0, angular_momentum=(0, 3.0, 0.5))
    arcs = Arcs(Body(moments=(10, 20, 26)), spin, [kick])
    scene = Scene(arcs, None, (1, 0, 0), (0.6, 0.8, 0.0))
    one, other = (events.separation(each, (0, 1, 1), (0.6, 0.8, 0)) for each in (scene, arcs))
    found, expected = (events.find_maxima(0.0, 300.0, each) for each in (one, other))
    np.testing.assert_allclose(found.seconds, expected.seconds, rtol=0, atol=1e-6)


def test_a_direction_that_moves_faster_than_the_body():
    # At rest under a Sun that circles at 2 rad/s: crossings every pi/2 s.
    motion = FreeRotation(
        Body(moments=(1, 2, 3)),
        Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0)),
    )

    def sun(t):
        return np.stack([np.cos(2 * t), np.sin(2 * t), 0.0 * t], axis=-1)

    for given in (sun, events.Moving(sun, rate=2.0, acceleration=4.0)):
        times, values = events.find_discrete(
            0.1, 1000.1, events.illuminated(motion, (1, 0, 0), given)
        )
        np.testing.assert_allclose(times, np.pi / 4 + np.pi / 2 * np.arange(len(times)), atol=1e-10)
        assert len(times) == 637 and not values[0]


def test_extrema_of_a_plain_function():
    found = events.find_maxima(0, 1000, lambda t: np.sin(t) + 0.3 * np.cos(2.3 * t), step=0.05)
    slope = np.cos(found.seconds) - 0.69 * np.sin(2.3 * found.seconds)
    assert len(found) == 191
    # 1e-9 of a turn for a smooth light curve, of which values alone would give 1e-8.
    assert np.max(np.abs(slope)) < 6e-9
    kinks = events.find_minima(0, 1000, lambda t: np.abs(np.sin(t - 0.3)), step=0.05)
    np.testing.assert_allclose(kinks.seconds, 0.3 + np.pi * np.arange(319), atol=1e-9)
    flat = events.find_maxima(0, 10, lambda t: np.minimum(t, 3.0), step=0.1)
    assert len(flat) == 0


# Shadow, and plain states -------------------------------------------------------------------------


def test_states_of_a_plain_function_none_lost_within_a_step():
    # From light to umbra and back between two samples: the penumbra between is found too.
    lit = events.shadow_state(lambda t: np.clip(20.0 * np.sin(t), 0.0, 1.0))
    times, states = events.find_discrete(0.5, 8.0, lit, step=0.5)
    np.testing.assert_array_equal(states, [1, 2, 1, 0])
    a = np.arcsin(1 / 20)
    wanted = [np.pi - a, np.pi, 2 * np.pi, 2 * np.pi + a]
    np.testing.assert_allclose(times, wanted, rtol=0, atol=1e-9)
    dated = events.find_discrete(0.5, 8.0, lit, step=0.5, epoch="2026-01-01")
    assert dated.time.scale == "tdb" and len(dated.time) == len(times)


# Scenes -------------------------------------------------------------------------------------------


def test_a_scene_without_distance_is_its_motion():
    from attitude.scene import Scene

    motion = tumbling()
    scene = Scene(motion, center=None, observer=(1, 1, 0), sun=(1, 0, 1))
    normal = (0, 1, 1)
    for one, other in (
        (events.glint(scene, normal, sun_radius=0.5),
         events.glint(motion, normal, (1, 0, 1), (1, 1, 0), sun_radius=0.5)),
        (events.illuminated(scene, normal), events.illuminated(motion, normal, (1, 0, 1))),
        (events.in_cone(scene, normal, "observer", 0.4),
         events.in_cone(motion, normal, (1, 1, 0), 0.4)),
    ):  # fmt: skip
        found, wanted = (events.find_discrete(0, 400, each) for each in (one, other))
        assert len(found) > 4
        np.testing.assert_array_equal(found.values, wanted.values)
        np.testing.assert_allclose(found.seconds, wanted.seconds, rtol=0, atol=1e-11)


def apophis_scene():
    from attitude import catalog, paths
    from attitude.scene import Scene
    from attitude.shape import Ellipsoid

    body, spin = catalog.load("99942 Apophis (2014)", phi0=0.0, psi0=0.0, epoch="2013-01-05")
    center = paths.oem(DATA / "paths" / "apophis-2012-2013.oem")
    motion = FreeRotation(body, spin)
    return Scene(
        motion, center=center, observer="earth", shape=Ellipsoid((180, 130, 120)),
        ephemeris="builtin",
    )  # fmt: skip


def test_events_as_received_on_earth():
    scene = apophis_scene()
    normal = np.array([0.6, 0.8, 0.0])
    lit = events.illuminated(scene, normal)
    span = 10 * 86400.0
    found = events.find_discrete(0, span, lit)
    t = np.linspace(0, span, 20001)
    states = scene.at(t).sun_direction @ normal > 0.0
    changes = np.flatnonzero(states[1:] != states[:-1])
    assert len(found) == len(changes) > 5
    np.testing.assert_allclose(found.seconds, t[changes], atol=t[1])
    # At the event the Sun is in the plane of the facet: 1e-9 of a turn.
    assert np.max(np.abs(scene.at(found.seconds, found.low).sun_direction @ normal)) < 6e-9


def test_both_lunar_eclipses_of_a_year_are_found_without_a_step():
    scene = Scene(None, "moon", "earth", ephemeris="builtin", shadow_of="earth")
    year = "2026-01-01", "2027-01-01"
    windows = events.windows(scene.quantity("lit_fraction") < 1.0, *year)
    # NASA's catalogue of lunar eclipses: the greatest of 3 March and 28 August, TD.
    greatest = ["2026-03-03T11:34:52 TT", "2026-08-28T04:14:04 TT"]
    middle = 0.5 * (windows.begin + windows.end)
    # s: of the Moon's centre alone, and the Earth's air is left out.
    np.testing.assert_allclose(middle, [instant(at).seconds for at in greatest], atol=120.0)
    changes = events.find_discrete(*year, events.shadow_state(scene), step=600.0)
    assert changes.values.tolist() == [1, 2, 1, 0] * 2
    np.testing.assert_allclose(changes.seconds[changes.values == 0], windows.end, atol=1e-5)


@pytest.mark.parametrize("days", [20, 1500])
def test_a_close_encounter_is_searched_finely_in_a_long_span(days):
    epoch = instant("2026-03-10T03:00:00")
    path = paths.kepler(
        pericenter_distance="20000 km", eccentricity=2.5, inclination="40 deg", node="10 deg",
        pericenter_argument="200 deg", epoch=epoch, center="earth", frame="icrf",
    )  # fmt: skip
    scene = Scene(None, path, "earth", ephemeris="builtin")
    t = np.linspace(-86400.0, 86400.0, 20001)
    view = scene.since(epoch, t)
    for name, threshold in (("phase_angle", 0.3), ("lit_fraction", 1.0), ("moon_separation", 0.5)):
        holds = np.asarray(getattr(view, name)) < threshold
        begins = t[1:][holds[1:] & ~holds[:-1]]
        span = epoch.after(-86400.0 * days), epoch.after(86400.0 * 1.04 * days)
        found = events.windows(scene.quantity(name) < threshold, *span).begin - epoch.seconds
        found = found[np.abs(found) < 86400.0]
        np.testing.assert_allclose(found, begins, atol=t[1] - t[0])
        assert len(found) == 1


def test_the_shadow_of_the_earth_on_a_satellite():
    from attitude import paths
    from attitude.scene import Scene

    motion = spinning()
    center = paths.tle(DATA / "paths" / "envisat-2013.tle")
    scene = Scene(motion, center=center, observer="earth", ephemeris="builtin", light_time=False)
    start, stop = "2013-10-23T06:00:00", "2013-10-23T14:00:00"
    found = events.find_discrete(start, stop, events.shadow_state(scene), step=60.0)
    assert found.epoch == motion.spin.epoch and np.all(np.diff(found.seconds) > 0.0)
    # Of each orbit penumbra, umbra, penumbra, light, in this order.
    first = int(np.flatnonzero(found.values == 0)[0]) + 1
    cycle = found.values[first:]
    np.testing.assert_array_equal(cycle, np.resize([1, 2, 1, 0], len(cycle)))
    assert len(cycle) >= 12
    # Half a microsecond before and after, far below the 10 s of a penumbra, the state differs.
    before, after = (np.asarray(scene.at(found.seconds + d).lit_fraction) for d in (-1e-6, 1e-6))
    states = [(f < 1.0).astype(int) + (f <= 0.0) for f in (before, after)]
    assert np.all(states[0] != states[1]) and np.array_equal(states[1], found.values)
    # Seen from the satellite the limb of the spheroid touches the outer or inner edge of the Sun:
    # a line to that edge is tangent to it.
    view = scene.at(found.seconds)
    sun = view.sun_direction_icrf * view.sun_distance[:, None]
    earth = view.observer_direction_icrf * view.observer_distance[:, None]
    across = np.cross(np.cross(earth, sun), sun)
    across /= np.linalg.norm(across, axis=1)[:, None]
    is_umbra = (found.values == 2) | (np.roll(found.values, 1) == 2)
    edge = sun + np.where(is_umbra, 1.0, -1.0)[:, None] * 6.957e8 * across
    squash = np.array([1.0, 1.0, 1.0 / (1.0 - 1.0 / 298.257223563)])
    ray, middle = edge * squash, earth * squash
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    height = np.linalg.norm(np.cross(ray, middle), axis=1)
    # km: the point of the disc that touches is not in the plane of the middles, as the Earth is
    # flat; 21 km of flattening, seen over a quarter of a degree.
    np.testing.assert_allclose(height[1:], 6378137.0, atol=2e3)
    with pytest.raises(AttitudeError, match="epoch of its scene"):
        events.find_discrete(0, 1, events.shadow_state(scene), step=1.0, epoch="2026-01-01")


def test_glints_of_a_scene_know_distance_and_velocity():
    # A panel whose normal is the bisector in the middle of the night: the flash is there.
    scene = apophis_scene()
    middle = scene.at(86400.0)
    normal = middle.sun_direction + middle.observer_direction
    plain = events.find_discrete(80000, 92800, events.glint(scene, normal))
    fixed = events.glint(scene, normal, sun_radius=np.arcsin(6.957e8 / middle.sun_distance))
    begin, end = plain.spans()[0]
    assert begin < 86400.0 < end
    np.testing.assert_allclose(
        events.find_discrete(80000, 92800, fixed).seconds, plain.seconds, atol=1e-3
    )
    # Aberration by the body's 30 km/s turns the mirror by 1e-4 rad at the most, and by some.
    moved = events.find_discrete(80000, 92800, events.glint(scene, normal, velocity="center"))
    rate = np.sqrt(np.sum(scene.motion.at(86400.0).angular_velocity ** 2))
    shift = np.abs(moved.seconds - plain.seconds) * rate
    # A chord of the disc that is not its diameter shifts by more at its ends.
    assert np.all(shift < 5e-4) and np.all(shift > 1e-7)


def test_extrema_of_brightness_of_a_scene():
    scene = apophis_scene()
    span = 5 * 86400.0
    bright = events.find_maxima(0, span, events.brightness(scene))
    t = np.linspace(0, span, 20001)
    y = scene.at(t).brightness
    tops = t[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:])]
    np.testing.assert_allclose(bright.seconds, tops, atol=1.5 * t[1])
    assert np.all(bright.values >= y.min()) and len(bright) > 5


# Other motions ------------------------------------------------------------------------------------


def test_arcs_change_their_pace_at_a_joint():
    body = Body(moments=(10, 20, 26))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.01))
    motion = Arcs(body, spin, [Impulse(at=100.0, angular_momentum=(3.0, 20.0, 50.0))])
    cone = events.in_cone(motion, (1, 2, 0), (0, 1, 1), 0.8)
    found = events.find_discrete(0, 200, cone)
    t = np.linspace(0, 200, 400001)
    states = cone(t)
    changes = np.flatnonzero(states[1:] != states[:-1])
    assert len(found) == len(changes) > 10
    np.testing.assert_allclose(found.seconds, t[changes], atol=t[1])


def test_a_table_is_searched_by_its_rates():
    motion = tumbling()
    table = AttitudeTable.from_history(motion.at(np.linspace(0, 60, 2001)))
    for source, atol in ((motion, 1e-13), (table, 1e-6)):
        found = events.find_discrete(1, 59, events.illuminated(source, (0, 1, 1), sun=(1, 0, 1)))
        exact = events.find_discrete(1, 59, events.illuminated(motion, (0, 1, 1), sun=(1, 0, 1)))
        np.testing.assert_allclose(found.seconds, exact.seconds, rtol=0, atol=atol)
        near = events.find_minima(1, 59, events.separation(source, (1, 2, 3), (0, 1, 1)))
        assert len(near) == len(
            events.find_minima(1, 59, events.separation(motion, (1, 2, 3), (0, 1, 1)))
        )


def test_a_body_at_rest_has_no_events():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    found = events.find_discrete(0, 1e6, events.illuminated(motion, (1, 0, 0), (1, 0, 1)))
    assert len(found) == 0 and found.values.dtype == bool and len(found.time) == 0


# What is returned, combined, refused --------------------------------------------------------------


def test_combined_conditions_follow_their_logic():
    motion = tumbling()
    lit = events.illuminated(motion, (0, 1, 1), sun=(1, 0, 1))
    seen = events.visible(motion, (0, 1, 1), observer=(1, 1, 0))
    t = np.linspace(0, 300, 300001)
    for both, wanted in (
        (lit & seen, lit(t) & seen(t)),
        (lit | ~seen, lit(t) | ~seen(t)),
        (~(lit & ~seen), ~(lit(t) & ~seen(t))),
    ):
        np.testing.assert_array_equal(both(t), wanted)
        times, values = events.find_discrete(0, 300, both)
        changes = np.flatnonzero(wanted[1:] != wanted[:-1])
        np.testing.assert_allclose(times, t[changes], atol=1.1e-3)
        np.testing.assert_array_equal(values, wanted[changes + 1])


def test_conditions_and_observables_pickle():
    """For processes that search spans in parallel; logic by closures could not be pickled."""
    motion, sun, observer = tumbling(), (1.0, 0.2, 0.1), (0.1, 1.0, 0.3)
    lit = events.illuminated(motion, (0, 0, 1), sun)
    seen = events.visible(motion, (0, 0, 1), observer)
    flash = events.glint(motion, (0, 0, 1), sun, observer, sun_radius=0.2)
    given = [lit, lit & ~seen | flash, events.in_cone(motion, (1, 0, 0), sun, 0.3)]
    again = pickle.loads(pickle.dumps(given))
    assert again[0].source.motion is again[2].source.motion
    for one, other in ((given, again), (given[1], again[1])):
        found, same = events.find_discrete(0.0, 100.0, one), events.find_discrete(0.0, 100.0, other)
        assert len(found) > 10
        assert np.array_equal(found.seconds, same.seconds)
        assert np.array_equal(found.values, same.values)
    angle = events.separation(motion, None, sun)
    for search in (events.find_maxima, events.find_minima):
        found, same = (search(0.0, 100.0, f) for f in (angle, pickle.loads(pickle.dumps(angle))))
        assert len(found) > 1
        assert np.array_equal(found.seconds, same.seconds)


def test_conditions_of_a_scene_pickle():
    scene = apophis_scene()
    lit, bright = events.illuminated(scene, (0.6, 0.8, 0.0)), events.brightness(scene)
    again, other = pickle.loads(pickle.dumps([lit, bright]))
    found, same = (events.find_discrete(0.0, 86400.0 * 3, each) for each in (lit, again))
    assert len(found) > 0 and np.array_equal(found.seconds, same.seconds)
    t = np.linspace(0.0, 86400.0, 5)
    assert np.array_equal(bright(t), other(t))


def test_dates_and_several_conditions():
    motion = spinning()
    cones = [events.in_cone(motion, axis, (0, 1, 0), 0.2) for axis in np.eye(3)]
    found = events.find_discrete("2026-01-01", "2026-01-01T00:01:02", cones)
    np.testing.assert_array_equal(found.which, [1, 0, 0, 1])
    assert found.time.isscalar is False and found[found.which == 0].time[0].scale == "tdb"
    assert len(found.at(motion)) == 4
    with pytest.raises(AttitudeError, match="which == k"):
        found.spans()
    # Spans of one of several conditions, whatever its number.
    alone = events.find_discrete("2026-01-01", "2026-01-01T00:01:02", cones[0])
    swapped = events.find_discrete("2026-01-01", "2026-01-01T00:01:02", cones[::-1])
    assert alone.spans().shape == (1, 2)
    np.testing.assert_allclose(swapped[swapped.which == 2].spans(), alone.spans(), atol=1e-12)
    with pytest.raises(AttributeError):
        found.seconds = 0


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda m: events.in_cone(m, (0, 0, 0), (1, 0, 0), 0.1), "axis is zero"),
        (lambda m: events.in_cone(m, (1, 0, 0), (1, 0, 0), 0.0), "half_angle"),
        (lambda m: events.in_cone(m, (1, 0, 0), "sun", 0.1), "has no position"),
        (
            lambda m: events.in_cone(7, (1, 0, 0), (1, 0, 0), 0.1),
            "motion is int; give a",
        ),
        (lambda m: events.illuminated(m, (1, 0, 0)), "sun is None"),
        (lambda m: events.glint(m, (1, 0, 0), (1, 0, 0), (0, 1, 0), sun_radius=2.0), "sun_radius"),
        (lambda m: events.past_meridian(m, (1, 0, 0), m.momentum), "along the pole"),
        (lambda m: events.find_discrete(0, 1, []), "empty"),
        (lambda m: events.find_discrete(0, 1, np.sin), "step="),
        (lambda m: events.find_discrete(0, 1, np.sin, step=0.1), "bool or an integer"),
        (lambda m: events.find_maxima(0, 1, np.sin), "step="),
        (
            lambda m: events.find_discrete(1, 0, events.illuminated(m, (1, 0, 0), (1, 0, 0))),
            "before",
        ),
        (
            lambda m: events.find_discrete(0, np.nan, events.illuminated(m, (1, 0, 0), (1, 0, 0))),
            "finite",
        ),
        (
            lambda m: (
                events.illuminated(m, (1, 0, 0), (1, 0, 0))
                & events.illuminated(spinning(), (1, 0, 0), (1, 0, 0))
            ),
            "same motion",
        ),
        (
            lambda m: events.find_discrete(
                0, 9, events.illuminated(m, (1, 0, 0), lambda t: np.zeros((len(t), 3)))
            ),
            "zero or not finite",
        ),
        (lambda m: events.brightness(m), "no brightness"),
        (
            lambda m: events.find_maxima(0, 9, events.in_cone(m, (1, 0, 0), (1, 0, 0), 0.1)),
            "is true or false and has no extrema",
        ),
        (lambda m: events.find_maxima(0, 9, lambda t: "a", step=1), "the function returns 'a'"),
        (lambda m: events.shadow_state(lambda t: "a")(np.zeros(1)), "lit returns 'a'"),
        (lambda m: events.Moving(np.sin, rate=-1.0), "rate is -1.0; it must not be negative"),
        (lambda m: events.Moving(np.sin, acceleration=-5), "acceleration is -5.0; it must not be"),
        (
            lambda m: events.in_cone(m, (1, 0, 0), lambda t: "a", 0.1)(0.0),
            "direction returns 'a'; it must return an array of real numbers",
        ),
        (
            lambda m: events.in_cone(m, (1, 0, 0), lambda t: [[1.0, 0.0], [1.0]], 0.1)(0.0),
            "direction returns .*; it must return an array of real numbers",
        ),
        (
            lambda m: events.glint(m, (1, 0, 0), (1, 0, 0), (0, 1, 0), velocity=lambda t: "a")(0.0),
            "velocity returns 'a'",
        ),
        (lambda m: events.find_discrete(0, 1, None), "f is None; give a Condition"),
        (lambda m: events.find_discrete(0, 1, 5), "f is 5; give a Condition"),
    ],
)
def test_bad_input_is_a_sentence(call, said):
    with pytest.raises(AttitudeError, match=said):
        call(spinning(0.5))


@pytest.mark.parametrize(("start", "stop"), [(0.0, 9.0), ("2026-01-01", "3 d")])
def test_a_scene_without_a_motion_is_searched_between_dates(start, stop):
    scene = Scene(None, "mars barycenter", paths.site("11 deg", "48 deg"), ephemeris="builtin")
    elevation = scene.quantity("elevation")
    for call in (
        lambda: events.windows(elevation > 0.0, start, stop),
        lambda: events.passes(scene, start, stop),
        lambda: events.find_discrete(start, stop, elevation > 0.0),
        lambda: events.find_maxima(start, stop, elevation),
    ):
        with pytest.raises(AttitudeError, match="but a scene without a motion"):
            call()
    with pytest.raises(AttitudeError, match="of a scene> is compared with 0 by =="):
        elevation == 0  # noqa: B015


def test_the_former_name_of_observable_warns():
    """`Quantity`, as astropy calls another class, is still imported from attitude.events."""
    with pytest.warns(DeprecationWarning, match=r"is now attitude\.events\.Observable"):
        from attitude.events import Quantity
    assert Quantity is events.Observable
    assert isinstance(events.separation(spinning(), (1, 0, 0), (0, 1, 0)), Quantity)
    with pytest.raises(AttributeError, match=r"'attitude\.events' has no attribute 'Quantities'"):
        _ = events.Quantities
