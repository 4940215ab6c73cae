"""Free arcs joined by impulses: against a chain of mpmath oracles, and by the laws of mechanics."""

import pickle

import numpy as np
import pytest
from mpmath import mp, mpf

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude._solver.chains import flow
from attitude.frames import quaternion
from attitude.torques import ConstantTorque, GravityGradient, InertiaHistory, LinearDamping
from attitude.torques._arcs import Arcs, Impulse, InertiaChange
from attitude.torques._torqued import TorquedRotation
from attitude.torques._triggers import AxisCrossesDirection, PointMeetsPlane
from tests.support import states
from tests.support.frames import definition
from tests.support.oracle import Oracle, conjugate, multiply, rate_error, rotation_error
from tests.support.torqued import cross

# The attitude of a free rotation errs by at most this (docs of FreeRotation), rad.
FREE = 4e-15
BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))


def kicks(count, seed=8, frames=("icrf", "body")):
    random = np.random.default_rng(seed)
    epochs = np.cumsum(random.uniform(0.05, 0.2, count))
    momenta = random.normal(size=(count, 3)) * 0.3
    return [
        Impulse(at=float(t), angular_momentum=momentum, frame=frames[k % len(frames)])
        for k, (t, momentum) in enumerate(zip(epochs, momenta, strict=True))
    ]


def chain(changes, body=BODY, spin=SPIN, wxyz=None):
    """Middles of the arcs, and the exact attitudes there: one oracle an arc, 45 digits.

    wxyz: the quaternion from which the spin was made; by default that of the spin.
    """
    tensor = mp.matrix([[mpf(float(x)) for x in row] for row in body.tensor])
    moments = [mpf(float(x)) for x in body.moments]
    given = np.array_equal(body.tensor, np.diag(body.moments))
    q = [mpf(float(x)) for x in (spin.wxyz if wxyz is None else wxyz)]
    q = multiply(turn_to_icrf(spin.frame), [x / mp.norm(q) for x in q])
    w = [mpf(float(x)) for x in spin.angular_velocity]
    last = mpf(0)
    for change in changes:
        if given:
            oracle = Oracle(moments, q, w, digits=45)  # ten times as quick
        else:
            oracle = Oracle.from_tensor(tensor.tolist(), q, w, digits=45)
        middle = float((last + mpf(change.at)) / 2)
        yield middle, oracle.at(mpf(middle) - last)[0]
        q, w = oracle.at(mpf(change.at) - last)
        momentum = [mpf(float(x)) for x in change.angular_momentum]
        if change.frame != "body":
            s = multiply(conjugate(q), turn_to_icrf(change.frame))
            momentum = multiply(multiply(s, [mpf(0), *momentum]), conjugate(s))[1:]
        w = list(mp.matrix(w) + mp.lu_solve(tensor, mp.matrix(momentum)))
        last = mpf(change.at)


def turn_to_icrf(frame):
    """The quaternion of the definition, 60 digits; all turns are less than half of one."""
    with mp.workdps(60):
        m = definition(frame)
        w = mp.sqrt(1 + m[0, 0] + m[1, 1] + m[2, 2]) / 2
        x, y, z = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
        return [w, x / (4 * w), y / (4 * w), z / (4 * w)]


def worst_of_chain(changes, body=BODY, spin=SPIN, wxyz=None):
    motion = Arcs(body, spin, changes)
    with mp.workprec(250):
        return max(
            rotation_error(motion.at(t).wxyz, exact, signed=True)
            for t, exact in chain(changes, body, spin, wxyz)
        )


def test_impulses_follow_the_chain_of_oracles():
    # Quaternion products at a joint add a rounding or two to that of a free rotation.
    assert worst_of_chain(kicks(24)) < FREE


def test_impulses_over_other_axes_follow_the_chain_of_oracles():
    """With a hundred rad between them: turned to ICRF in one double they erred by 1e-11 rad."""
    spin = Spin(
        epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1), frame="ecliptic"
    )
    changes = [
        Impulse(replaced.at * 50.0, replaced.angular_momentum, replaced.frame)
        for replaced in kicks(24, frames=("ecliptic", "eme2000", "body"))
    ]
    assert worst_of_chain(changes, spin=spin) < FREE


def test_impulses_of_a_tensor_follow_the_chain_of_oracles():
    """Over ICRF, with twenty rad between them: what one double leaves out of the turn from the
    principal to the body axes had grown to 1e-13 rad, and to 2e-12 of random ones.
    """
    body = Body(tensor=[[14.1, -0.16, 1.12], [-0.16, 10.3, 4.99], [1.12, 4.99, 7.5]])
    changes = [
        Impulse(1.3 * (k + 1), tuple(60.0 * np.sin([k + 1.0, 2.0 * k, 3.0 - k])), "icrf")
        for k in range(8)
    ]
    assert worst_of_chain(changes, body) < FREE


@pytest.mark.parametrize("frame", ["icrf", "ecliptic"])
@pytest.mark.parametrize("wxyz", [(3.0, -1.0, 7.0, 2.0), (1e-200, 2e-200, -3e-200, 1e-201)])
def test_a_quaternion_of_any_length_follows_the_chain_of_oracles(frame, wxyz):
    """With twenty rad between impulses: the rounding of its unit quaternion had grown to 1e-13."""
    spin = Spin(epoch="2026-01-01", wxyz=wxyz, angular_velocity=(1, 15, 1), frame=frame)
    changes = [
        Impulse(1.3 * (k + 1), tuple(60.0 * np.sin([k + 1.0, 2.0 * k, 3.0 - k])), "icrf")
        for k in range(8)
    ]
    assert worst_of_chain(changes, spin=spin, wxyz=wxyz) < FREE


@pytest.mark.slow
def test_a_thousand_impulses_cost_no_accuracy():
    assert worst_of_chain(kicks(1000)) < FREE


@pytest.mark.parametrize("revolutions", [0.05, 3.0, 1e4, 1e9])
def test_flow_in_two_doubles(revolutions):
    """What is carried over a joint has 25 digits, in every regime."""
    for state in states.sample(1):
        rest = not any(state.omega0)
        # The exact separatrix runs for ever towards the middle axis, in the unstable direction.
        if rest or state.family == "separatrix":
            continue
        time = revolutions * states.revolution(state)
        moments, w = np.zeros((3, 2)), np.zeros((3, 2))
        moments[:, 0], w[:, 0] = state.moments, state.omega0
        identity = np.array([[1.0, 0.0, 0.0, 0.0]])
        record = states.constants_of(moments[None], identity, w[None].copy(), identity)[0]
        q = np.zeros((4, 2))
        q[0, 0] = 1.0
        flow(record, (time, 0.0), q, w)
        exact, rates = Oracle(state.moments, (1, 0, 0, 0), state.omega0, digits=50).at(time)
        with mp.workprec(300):
            found = [mpf(float(a)) + mpf(float(b)) for a, b in q]
            turning = [mpf(float(a)) + mpf(float(b)) for a, b in w]
            # 1e-30 a piece, and the rates' 32 digits times the angle turned (1e10 rad at most);
            # within 1e-16 of the separatrix errors grow by 1/sqrt(1e-16).
            limit = 1e-26 + 1e-31 * 6.3 * revolutions
            limit *= 1e8 if "separatrix" in state.family or "middle" in state.family else 1.0
            assert rotation_error(found, exact, signed=True) < limit, state
            assert rate_error(turning, rates) < limit, state


def test_any_order_of_epochs_and_of_scattered_or_dense_ones():
    motion = Arcs(BODY, SPIN, kicks(30))
    t = np.linspace(-1.0, motion.joints[-1] + 1.0, 2001)
    dense = motion.at(t)
    order = np.random.default_rng(1).permutation(len(t))
    assert np.array_equal(motion.at(t[order]).wxyz, dense.wxyz[order])
    assert np.array_equal(motion.at(t[17]).wxyz, dense.wxyz[17])
    assert np.array_equal(motion.at(t[::50]).angular_velocity, dense.angular_velocity[::50])
    assert motion.at(t.reshape(3, 667)).wxyz.shape == (3, 667, 4)
    assert np.all(np.isnan(motion.at([np.nan, 1.0]).wxyz) == [[True] * 4, [False] * 4])
    # continuous in sign: no two neighbours on opposite sides
    assert np.min(np.sum(dense.wxyz[1:] * dense.wxyz[:-1], axis=-1)) > 0.9


@pytest.mark.parametrize("inertia", [600, -600])
def test_moments_may_be_in_any_unit(inertia):
    """Squares of the momentum are no doubles at a joint either."""
    given = []
    for size in (1.0, 2.0**inertia):
        kick = Impulse(at=2.0, angular_momentum=(0.1 * size, 0, 0))
        motion = Arcs(Body(moments=size * np.array([1.0, 2.0, 2.7])), SPIN, [kick])
        columns = motion.sensitivity_at([1.0, 3.0])
        given.append((motion.at([1.0, 3.0]).wxyz, columns[..., :6], size * columns[..., 6:]))
    for one, two in zip(*given, strict=True):
        assert np.max(np.abs(one - two)) <= 4e-15 * np.max(np.abs(one))


def test_no_change_is_free_rotation():
    t = np.linspace(-5.0, 50.0, 100)
    free = FreeRotation(BODY, SPIN).at(t).wxyz
    assert np.array_equal(Arcs(BODY, SPIN, []).at(t).wxyz, free)
    nothing = Arcs(BODY, SPIN, [Impulse(20.0, (0, 0, 0))]).at(t).wxyz
    assert np.max(np.abs(nothing - free)) < FREE


def test_the_array_floor():
    """Numbers in, numbers out: what `at` wraps, and what was given stays as it was."""
    motion = Arcs(BODY, SPIN, kicks(30))
    t = np.linspace(-1.0, motion.joints[-1] + 1.0, 101)
    assert np.array_equal(motion.wxyz_at(t), motion.at(t).wxyz)
    assert t.flags.writeable
    assert motion.wxyz_at(1.5).shape == (4,)
    assert np.array_equal(motion.wxyz_at(1.5), motion.at(1.5).wxyz)
    assert np.array_equal(motion.wxyz_at([1.5, 2.0], [1e-9, 0.0])[0], motion.at(1.5, 1e-9).wxyz)
    # two summands in the wrong order are the same epoch
    assert np.array_equal(motion.wxyz_at(1e-9, 1.5), motion.at(1.5, 1e-9).wxyz)


def test_the_low_part_decides_at_a_joint():
    """An epoch a hair before the joint is on the arc before it."""
    motion = Arcs(BODY, SPIN, [Impulse(2.0, (0, 0, 40.0))])
    before, at, after = (motion.at(2.0, low).angular_velocity for low in (-1e-17, 0.0, 1e-17))
    assert np.max(np.abs(at - after)) < 1e-14
    assert at[2] - before[2] == pytest.approx(40.0 / 26.0)


def test_no_change_is_free_rotation_of_a_tensor_too():
    """Near the separatrix, where two doubles of the moments are not enough."""
    tensor = [[2.0, 1e-9, 0.0], [1e-9, 2.5, 1e-10], [0.0, 1e-10, 2.6]]
    body = Body(tensor=tensor)
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e-9, 2.0, 1e-9))
    t = np.linspace(-5.0, 1e6, 100)
    assert np.array_equal(Arcs(body, spin, []).at(t).wxyz, FreeRotation(body, spin).at(t).wxyz)


def test_epochs_beyond_reach_are_a_sentence():
    motion = Arcs(BODY, SPIN, kicks(3))
    for t in (np.inf, -np.inf, 1e30, [0.0, 1e300], [np.nan, 1e300]):
        with pytest.raises(AttitudeError, match=r"lies .* s from that of the state"):
            motion.at(t)
    for low in (np.inf, -np.inf):
        with pytest.raises(AttitudeError, match=r"lies .*inf s from that of the state"):
            motion.at(1.0, low)
    with pytest.raises(AttitudeError, match="lies inf s from that of the state"):
        motion.at(1e308, 1e308)


def momentum(history, body):
    return history.body_to_inertial(history.angular_velocity @ body.tensor)


def test_an_impulse_adds_what_it_says():
    turned = Body(tensor=[[2.0, 0.3, 0.1], [0.3, 2.5, 0.5], [0.1, 0.5, 2.6]])
    for frame in ("body", "icrf", "ecliptic"):
        motion = Arcs(turned, SPIN, [Impulse("2026-01-01T00:00:07.5", (1, -2, 3), frame)])
        at = motion.joints[0]
        before, after = momentum(motion.at(np.nextafter(at, 0.0)), turned), None
        history = motion.at(at)
        after = momentum(history, turned)
        added = after - before
        if frame == "body":
            added = history.inertial_to_body(added)
        elif frame == "ecliptic":
            added = FreeRotationAxes.to_ecliptic(added)
        # 1e-14 of a momentum of 40 kg m2/s, and 1e-15 s of rotation at 15 rad/s
        assert np.max(np.abs(added - (1, -2, 3))) < 1e-12


def test_a_despin_loop_goes_on_after_the_body_has_stopped():
    """Each impulse leaves 1e-16 of the rate before; squares of 1e-160 rad/s underflow."""
    stop = [Impulse(10.0 * k, lambda h: -h.angular_velocity @ BODY.tensor) for k in range(1, 25)]
    motion = Arcs(BODY, SPIN, stop)
    history = motion.at([35.0, 115.0, 125.0, 500.0])
    assert np.all(np.abs(history.angular_velocity) < 1e-40)
    assert np.ptp(history.wxyz, axis=0).max() < 1e-15
    slow = Spin("2026-01-01", (1, 0, 0, 0), (1e-170, 2e-170, 1e-170))
    history = Arcs(BODY, slow, [Impulse(9.0, (1e-3, 0.0, 0.0))]).at([5.0, 20.0])
    assert history.angular_velocity[0] == pytest.approx(slow.angular_velocity, rel=1e-15, abs=0)
    expected = [1e-3 / BODY.moments[0], 0.0, 0.0]
    assert history.angular_velocity[1] == pytest.approx(expected, abs=1e-160)


class FreeRotationAxes:
    """The ecliptic of J2000 by its definition: one turn about x by 84381.448 arcsec."""

    @staticmethod
    def to_ecliptic(v):
        angle = np.radians(84381.448 / 3600.0)
        c, s = np.cos(angle), np.sin(angle)
        return np.array([v[0], c * v[1] + s * v[2], -s * v[1] + c * v[2]])


def test_deployment_keeps_momentum_and_attitude():
    long = Body(tensor=[[40.0, 1.0, 0.0], [1.0, 20.0, 2.0], [0.0, 2.0, 50.0]])
    motion = Arcs(BODY, SPIN, [InertiaChange(3.0, long), Impulse(5.0, (1, 0, 0))])
    before, after = motion.at(np.nextafter(3.0, 0.0)), motion.at(3.0)
    assert np.max(np.abs(before.wxyz - after.wxyz)) < 1e-14
    # 330 kg m2/s to 1e-14
    assert np.max(np.abs(momentum(before, BODY) - momentum(after, long))) < 3e-12
    assert motion.body_at(2.0) is BODY and motion.body_at(6.0) is long
    # Euler's equations with the body of each epoch
    for t, body in ((2.0, BODY), (4.0, long)):
        at = motion.at(t)
        w = at.angular_velocity
        expected = np.linalg.solve(body.tensor, np.cross(body.tensor @ w, w))
        assert np.allclose(at.angular_acceleration, expected, rtol=1e-13, atol=1e-12)


def test_docking_brings_momentum_along():
    both = Body(moments=(100, 200, 260))
    motion = Arcs(BODY, SPIN, [InertiaChange(1.0, both, angular_momentum=(5, 0, 0), frame="icrf")])
    before, after = motion.at(np.nextafter(1.0, 0.0)), motion.at(1.0)
    added = momentum(after, both) - momentum(before, BODY)
    assert np.max(np.abs(added - (5, 0, 0))) < 1e-12


def test_the_first_crossing_is_found():
    random = np.random.default_rng(4)
    for _ in range(8):
        axis, direction = random.normal(size=(2, 3))
        angle = random.uniform(0.3, 2.8)
        event = AxisCrossesDirection(axis, direction, angle)
        motion = FreeRotation(BODY, SPIN)
        t = np.linspace(0.0, 10.0, 200_001)
        value = event.values(motion.at(t))[0]
        change = np.flatnonzero((value[1:] < 0.0) != (value[:-1] < 0.0))
        if not len(change):
            with pytest.raises(AttitudeError, match="does not happen"):
                Arcs(
                    BODY,
                    SPIN,
                    [Impulse(AxisCrossesDirection(axis, direction, angle, 10.0), (1, 0, 0))],
                )
            continue
        found = Arcs(BODY, SPIN, [Impulse(event, (1, 0, 0))])
        assert t[change[0]] <= found.joints[0] <= t[change[0] + 1]
        here = event.values(motion.at(found.joints[0]))
        # at most two doubles of time off, at 15 rad/s
        assert abs(here[0]) < 1e-14 + 2.0 * abs(here[1]) * np.spacing(found.joints[0])


def test_a_body_that_does_not_turn_falls_on_a_plane():
    """Not turning, with its corner a metre above a floor at 2 m/s: half a second."""
    rest = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    fall = PointMeetsPlane((0.3, 0, -0.5), (0, 0, 1), start=(0, 0, 1.5), velocity=(0, 0, -2.0))
    motion = Arcs(BODY, rest, [Impulse(fall, (0, 1, 0))])
    assert motion.joints[0] == pytest.approx(0.5, rel=1e-15)
    centre = PointMeetsPlane((0, 0, 0), (0, 0, 1), start=(0, 0, 1.5), velocity=(0, 0, -2.0))
    assert Arcs(BODY, rest, [Impulse(centre, (0, 1, 0))]).joints[0] == pytest.approx(0.75)
    hovers = PointMeetsPlane((0.3, 0, -0.5), (0, 0, 1), start=(0, 0, 1.5))
    with pytest.raises(AttitudeError, match="a body that does not move"):
        Arcs(BODY, rest, [Impulse(hovers, (0, 1, 0))])


def test_an_event_a_century_ahead_is_found_as_sharply():
    """Time is counted from the block that is searched, not from the epoch."""
    late = 3e9
    event = AxisCrossesDirection((1, 0.2, 0), (0, 0.3, 1))
    motion = Arcs(BODY, SPIN, [Impulse(late, (0, 0, 0)), Impulse(event, (1, 0, 0))])
    at = motion.joints[1]
    assert late < at < late + 10.0
    value, rate = event.values(motion.at(at))
    # one double of 3e9 s, at some rad/s
    assert abs(value) < 2.0 * abs(rate) * np.spacing(late)


def test_bouncing_rod_keeps_its_energy():
    """The paper's use: free motion, collision search, impulse; an elastic wall that gives no push
    along itself, for a body whose centre of mass is held."""
    point = np.array([0.7, 0.2, -0.4])
    normal = np.array([0.0, 0.0, 1.0])

    def reflect(before):
        arm = before.body_to_inertial(point)
        lever = before.inertial_to_body(np.cross(arm, normal))
        rate = before.angular_velocity @ lever
        return -2.0 * rate / (lever @ np.linalg.solve(BODY.tensor, lever)) * lever

    event = PointMeetsPlane(point, normal, offset=0.3)
    motion = Arcs(BODY, SPIN, [Impulse(event, reflect) for _ in range(20)])
    t = np.linspace(0.0, motion.joints[-1], 20_000)
    history = motion.at(t)
    height = history.body_to_inertial(point)[:, 2]
    start = height[0] - 0.3
    assert np.all(np.sign(start) * (height - 0.3) > -1e-12)
    energy = 0.5 * np.sum(history.angular_velocity @ BODY.tensor * history.angular_velocity, -1)
    # 20 bounces of rounding each
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-13


def test_an_arc_drives_what_a_history_drives():
    history = Arcs(BODY, SPIN, kicks(5)).at([0.1, 0.5])
    w = history.angular_velocity
    expected = quaternion.rotate(history.wxyz, w)
    assert np.array_equal(history.angular_velocity_inertial, expected)
    assert history[1:].wxyz.shape == (1, 4)
    assert "angular_velocity" in history.table().colnames


# Under torques ------------------------------------------------------------------------------------

# A circular orbit about the Earth, from ICRF's x: rad/s, m, m3/s2.
N = 1.0e-3
RADIUS = 7.2e6
GM = 3.986004418e14


def on_circle(seconds):
    angle = N * np.asarray(seconds)
    return RADIUS * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)


def thruster(t, wxyz, omega):
    """A torque of time and rate, so that a wrong origin of t or a wrong rate shows."""
    return (0.01 * np.sin(0.05 * t), 0.02 * np.cos(0.03 * t) - 0.01 * omega[1], 0.005 * omega[0])


def test_impulses_under_torques_follow_an_integrator():
    """Gravity gradient, a thruster, an impulse and a docking: DOP853, restarted at the joints."""
    from scipy.integrate import solve_ivp

    def slope(moments):
        def value(t, y):
            q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
            r = quaternion.matrix(q).T @ on_circle(t)
            size = np.linalg.norm(r)
            torque = 3.0 * GM / size**5 * cross(r, moments * r) + thruster(t, q, w)
            rate = 0.5 * np.array(quaternion.multiply(y[:4], [0.0, *w]))
            return np.concatenate([rate, (torque - cross(w, moments * w)) / moments])

        return value

    def carried(y, moments, t0, t1):
        given = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-15}
        return solve_ivp(slope(moments), (t0, t1), y, **given).y[:, -1]

    one, two = np.array([10.0, 20.0, 26.0]), np.array([12.0, 22.0, 30.0])
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.02, 0.3, 0.05))
    start = np.concatenate([spin.wxyz_icrf, spin.angular_velocity])
    pulse, docked = np.array([0.0, -2.0, 0.5]), np.array([0.3, 0.0, 0.1])
    struck = carried(start, one, 0.0, 50.0)
    struck[4:] += pulse / one
    larger = carried(struck, one, 50.0, 120.0)
    turn = quaternion.matrix(larger[:4] / np.linalg.norm(larger[:4]))
    larger[4:] = (one * larger[4:] + turn.T @ docked) / two
    exact = {
        -20.0: carried(start, one, 0.0, -20.0),
        49.0: carried(start, one, 0.0, 49.0),
        50.0: struck,
        80.0: carried(struck, one, 50.0, 80.0),
        120.0: larger,
        250.0: carried(larger, two, 120.0, 250.0),
    }
    changes = [
        Impulse(at=50.0, angular_momentum=pulse),
        InertiaChange(at=120.0, body=Body(two), angular_momentum=docked, frame="icrf"),
    ]
    torques = [thruster, GravityGradient(on_circle, "earth")]
    motion = Arcs(Body(one), spin, changes, torques, tolerance=1e-11)
    history = motion.at(list(exact))
    for k, state in enumerate(exact.values()):
        q = state[:4] / np.linalg.norm(state[:4])
        turned = quaternion.multiply(quaternion.conjugate(q), history.wxyz[k])
        # The tolerance of each of three arcs, grown tenfold along the last one.
        assert 2.0 * np.linalg.norm(turned[1:]) < 3e-11
        assert np.abs(history.angular_velocity[k] - state[4:]).max() < 3e-12
    spins = motion.angular_acceleration_at(80.0), slope(one)(80.0, exact[80.0])[4:]
    assert np.abs(spins[0] - spins[1]).max() < 1e-12
    assert motion.body_at(119.0).moments[0] == 10.0 and motion.body_at(120.0).moments[0] == 12.0
    assert "3 from" in repr(motion) and "under CustomTorque, GravityGradient" in repr(motion)


def test_compiled_and_plain_functions_have_one_time():
    import numba

    changes = [Impulse(at=0.7, angular_momentum=(0, -2, 0.5))]
    plain = Arcs(BODY, SPIN, changes, thruster, step=0.01)
    fast = Arcs(BODY, SPIN, changes, numba.njit(thruster), step=0.01)
    assert np.abs(plain.at([0.5, 1.5]).wxyz - fast.at([0.5, 1.5]).wxyz).max() < 1e-15


def test_an_impulse_of_nothing_changes_nothing_under_torques():
    """The joint lies on the grid of steps; its rate, a double, makes 2e-15 rad each second."""
    torques = [thruster, GravityGradient(on_circle, "earth")]
    one = Arcs(BODY, SPIN, Impulse(0.5, (0, 0, 0)), torques, step=0.01, scheme="suzuki")
    two = TorquedRotation(BODY, SPIN, torques, step=0.01, scheme="suzuki")
    t = [-0.3, 0.2, 0.5, 0.755, 3.0]
    assert np.abs(one.at(t).wxyz - two.at(t).wxyz).max() < 3e-14
    assert np.isnan(one.at([np.nan, 1.0]).wxyz[0]).all()


def test_events_and_functions_of_the_motion_under_torques():
    """An event is where it says; a function takes the momentum that is there: the body stops."""
    crossing = AxisCrossesDirection(axis=(1, 0, 0), direction=(0, 0, 1))
    stop = Impulse(at=crossing, angular_momentum=lambda h: -h.angular_velocity @ BODY.tensor)
    brake = LinearDamping(3.0)
    motion = Arcs(BODY, SPIN, [stop], brake, tolerance=1e-11)
    at = motion.joints[0]
    before = TorquedRotation(BODY, SPIN, brake, tolerance=1e-11)
    heights = before.at(np.linspace(0.0, at, 400)).body_to_inertial([1, 0, 0])[:, 2]
    assert abs(heights[-1]) < 1e-12
    assert np.all(heights[:-1] * heights[0] > 0.0)  # the first one
    assert np.linalg.norm(motion.at(at + 5.0).angular_velocity) < 1e-14
    assert abs(Arcs(BODY, SPIN, [stop]).joints[0] - at) > 1e-4  # brakes delay it
    with pytest.raises(AttitudeError, match=r"changes\[0\].at is AxisCrosses.*does not happen"):
        late = AxisCrossesDirection(axis=(1, 0, 0), direction=(0, 0, 1), within=1e-3)
        Arcs(BODY, SPIN, [Impulse(late, (1, 0, 0))], brake)


@pytest.mark.parametrize(
    ("rate", "within"), [(1e-3, None), (1e-9, None), (0.0, None), (0.0, 100.0), (1e-4, 300.0)]
)
def test_the_first_event_of_a_body_that_a_torque_spins_up(rate, within):
    """rate t + 0.005 t^2 is a right angle, after which the body turns ever faster."""
    crossing = AxisCrossesDirection(axis=(1, 0, 0), direction=(1, 0, 0), within=within)
    spin = Spin("2026-01-01", (1, 0, 0, 0), (0, 0, rate))
    arcs = Arcs(
        Body((10, 20, 26)), spin, Impulse(crossing, (0, 0, 0)), ConstantTorque((0, 0, 0.26))
    )
    expected = 100.0 * (np.sqrt(rate**2 + 0.01 * np.pi) - rate)
    assert arcs.joints[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"step": 1.0}, "step is for the integration of torques"),
        ({"torques": []}, "torques is empty"),
        ({"torques": 3}, "torques is 3; give"),
        ({"torques": LinearDamping(1.0), "step": 0.1, "tolerance": 1e-3}, "takes one of step"),
        ({"torques": LinearDamping(1.0), "step": 10.0}, "cannot resolve the motion"),
        ({"torques": thruster, "scheme": "force-gradient"}, "CustomTorque does not define"),
        ({"torques": InertiaHistory(lambda t: np.zeros((len(t), 3, 3)))}, "no InertiaHistory"),
    ],
)
def test_bad_torques_are_a_sentence(how, message):
    with pytest.raises(AttitudeError, match=message):
        Arcs(BODY, SPIN, kicks(2), **how)


def test_arcs_under_torques_are_values_and_are_not_certified():
    changes, brake = kicks(2), LinearDamping(1.0)
    motion = Arcs(BODY, SPIN, changes, brake, step=0.01, scheme="suzuki")
    again = pickle.loads(pickle.dumps(motion))
    assert motion == Arcs(BODY, SPIN, changes, brake, step=0.01, scheme="suzuki")
    assert motion not in (Arcs(BODY, SPIN, changes), Arcs(BODY, SPIN, changes, brake, step=0.01))
    assert np.array_equal(again.at([0.3, 2.0]).wxyz, motion.at([0.3, 2.0]).wxyz)
    assert motion.rate_bounds(0.0) is None
    with pytest.raises(AttitudeError, match="cannot be certified"):
        motion.certificate([1.0])


def test_pickle():
    motion = Arcs(BODY, SPIN, kicks(5))
    again = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(again.at([0.3, 9.0]).wxyz, motion.at([0.3, 9.0]).wxyz)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: [Impulse(2.0, (1, 0, 0)), Impulse(2.0, (1, 0, 0))], "the same as changes"),
        (lambda: [Impulse(2.0, (1, 0, 0)), Impulse(1.0, (1, 0, 0))], "earlier than changes"),
        (lambda: [Impulse(-1.0, (1, 0, 0))], "earlier than the epoch of the spin"),
        (lambda: [Impulse(0.0, (1, 0, 0))], "the same as the epoch of the spin"),
        (lambda: [Impulse("2025-12-31", (1, 0, 0))], "earlier than the epoch of the spin"),
        (
            lambda: [Impulse("2026-01-01T00:00:01", (1, 0, 0)), Impulse(1.0, (1, 0, 0))],
            "e-10 s earlier than changes",  # TDB and UTC seconds
        ),
        (lambda: [Impulse(np.nan, (1, 0, 0))], "finite epoch"),
        (lambda: [Impulse(1e308, (1, 0, 0))], r"changes\[0\].at: an epoch lies 1e\+308 s"),
        (lambda: [Impulse([1.0, 2.0], (1, 0, 0))], "holds 2 epochs"),
        (lambda: [Impulse(1.0, (1, 0))], "shape"),
        (lambda: [Impulse(1.0, (1, 0, np.nan))], "finite"),
        (lambda: [Impulse(1.0, (1, 0, 0), "itrf")], "frame"),
        (lambda: [Impulse(1.0, lambda history: (1, 2))], "shape"),
        (lambda: [(1.0, (1, 0, 0))], "Impulse or InertiaChange"),
        (lambda: [InertiaChange(1.0, (1, 2, 3))], "give a Body"),
        (lambda: [Impulse(AxisCrossesDirection((0, 0, 0), (0, 0, 1)), (1, 0, 0))], "axis is zero"),
    ],
)
def test_bad_input_is_a_sentence(make, message):
    with pytest.raises(AttitudeError, match=message):
        Arcs(BODY, SPIN, make())


def test_a_rod_cannot_be_spun_about_itself():
    rod = Body(moments=(0, 5, 5))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 1, 0))
    with pytest.raises(AttitudeError, match="leaves no physical state"):
        Arcs(rod, spin, [Impulse(1.0, (1, 0, 0))])
    assert Arcs(rod, spin, [Impulse(1.0, (0, 0, 1))]).at(2.0).wxyz.shape == (4,)
