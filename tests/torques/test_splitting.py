"""The short exact step, the splitting schemes around it, and what they conserve."""

import pickle
from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf

from attitude import Arcs, AttitudeError, AttitudeTable, Body, FreeRotation, Impulse, Spin, paths
from attitude._compilation.decorators import entry_point
from attitude._solver.step import (
    LONGEST_PIECE,
    advance,
    gains,
    increment,
    loaded,
    pieces,
    rates,
    stored,
)
from attitude.arcs import AxisCrossesDirection
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.torques import (
    ConstantTorque,
    CustomTorque,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    _torqued,
)
from attitude.torques._schemes import SCHEMES, Scheme, scheme
from attitude.torques._torqued import TorquedRotation
from tests.support import states
from tests.support.gragg import EccentricOrbit, integrate
from tests.support.oracle import Oracle, rate_error, rotation_error
from tests.support.rounding import moved
from tests.support.torqued import cross

BODY = Body(moments=(10, 20, 26))
MOMENTS = BODY.moments


@entry_point
def steps(m, h, count, state):
    moments = m[0], m[1], m[2]
    k, now = gains(moments), loaded(state)
    for _ in range(count):
        now = advance(moments, k, h, now)
    stored(now, state)


@entry_point
def how_many(m, w, h):
    moments = m[0], m[1], m[2]
    return pieces(gains(moments), (w[0], w[1], w[2]), h)


@entry_point
def one_piece(m, w, h):
    moments = m[0], m[1], m[2]
    w = w[0], w[1], w[2]
    return increment(moments, w, rates(gains(moments), w), h)


def ascending(state):
    """Moments and rates of a state over right-handed axes of ascending moments; None for a rod."""
    moments, w = np.array(state.moments), np.array(state.omega0)
    order = np.argsort(moments, kind="stable")
    if moments[order[0]] == 0.0:
        return None
    sign = np.sign(np.linalg.det(np.eye(3)[:, order]))
    return moments[order], sign * w[order]


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 0.1, 0.3, 1.0, 3.0])
def test_step_against_the_oracle_in_every_regime(angle):
    for state in states.sample(3):
        given = ascending(state)
        if given is None:
            continue
        moments, w = given
        h = angle * states.revolution(state) / (2.0 * np.pi)
        exact, rates = Oracle(moments.tolist(), (1, 0, 0, 0), w.tolist(), digits=25).at(h)
        found = np.zeros(14)
        found[0], found[4:7] = 1.0, w
        steps(moments, h, 1, found)
        # an increment is as good as one rounding of the angle turned; the sum is rounded once
        assert rotation_error(found[:4], exact, signed=True) < 2.5e-16 + 4e-16 * angle, state
        assert rate_error(found[4:7], rates) < 4e-16 * (1.0 + angle), state


def test_a_long_time_is_taken_in_pieces():
    moments, w = np.array([10.0, 20.0, 26.0]), np.array([1.0, 15.0, 1.0])
    one, many = np.zeros(14), np.zeros(14)
    one[0] = many[0] = 1.0
    one[4:7] = many[4:7] = w
    steps(moments, 1.0, 1, one)
    steps(moments, 0.01, 100, many)
    # 15 rad, 1e-16 each, near the separatrix where errors grow
    assert np.max(np.abs(one[:7] - many[:7])) < 1e-13


def test_what_spins_steadily_takes_one_piece():
    assert how_many(np.ones(3), np.array([1.0, 2.0, 3.0]), 1e3) == 1
    assert how_many(np.array([1.0, 2.0, 2.5]), np.array([0.0, 0.0, 3.0]), 1e-3) == 1
    assert how_many(np.array([1.0, 2.0, 2.5]), np.zeros(3), 1e9) == 1


def test_continuous_across_the_number_of_pieces():
    """With nextafter on both sides of the time at which one piece becomes two."""
    for state in states.sample(2):
        given = ascending(state)
        if given is None or not np.any(given[1]):
            continue
        moments, w = given
        low, high = 0.0, 1e4 * states.revolution(state)
        if how_many(moments, w, high) < 2:
            continue
        while np.nextafter(low, high) < high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if how_many(moments, w, middle) < 2 else (low, middle)
        sides = []
        for h in (low, high):
            found = np.zeros(14)
            found[0], found[4:7] = 1.0, w
            steps(moments, h, 1, found)
            sides.append(found)
        assert (how_many(moments, w, low), how_many(moments, w, high)) == (1, 2)
        # a slow wobble of a fast spin turns far in one piece: rounding times that angle
        turned = 1.0 + low * np.hypot.reduce(w)
        assert np.max(np.abs(sides[0][:4] - sides[1][:4])) < 4e-16 * turned, state
        scale = np.max(np.abs(w))
        assert np.max(np.abs(sides[0][4:7] - sides[1][4:7])) < 8e-16 * scale, state
    assert LONGEST_PIECE == 0.1


def test_one_step_is_time_reversible():
    for state in states.sample(2):
        given = ascending(state)
        if given is None:
            continue
        moments, w = given
        h = 0.2 * states.revolution(state) / (2.0 * np.pi)
        found = np.zeros(14)
        found[0], found[4:7] = 1.0, w
        steps(moments, h, 1, found)
        steps(moments, -h, 1, found)
        assert np.max(np.abs(found[:4] - (1, 0, 0, 0))) < 1e-15
        assert np.max(np.abs(found[4:7] - w)) <= 1e-15 * np.max(np.abs(w))


@pytest.mark.parametrize("rates", [(1.0, 15.0, 1.0), (5.0, 0.3, 0.2), (0.1, 0.2, 4.0)])
def test_energy_and_momentum_do_not_drift(rates):
    """A million steps: compensated sums leave the rounding of an increment, and no bias."""
    state, count = np.zeros(14), 1_000_000
    state[0], state[4:7] = 1.0, rates
    h = 0.1 / np.hypot.reduce(rates)
    steps(MOMENTS, h, count, state)
    exact = state[4:7] + state[11:14]
    energy = np.sum(MOMENTS * exact**2) / np.sum(MOMENTS * np.square(rates)) - 1.0
    momentum = np.sum((MOMENTS * exact) ** 2) / np.sum((MOMENTS * rates) ** 2) - 1.0
    # a random walk of 1e6 whole roundings, 1.1e-16 * 1e3; a bias of a hundredth of one a step
    # would give 1e-12
    assert abs(energy) < 1.1e-13 and abs(momentum) < 1.1e-13
    assert abs(np.sum((state[:4] + state[7:11]) ** 2) - 1.0) < 1.1e-13


def test_the_quaternion_keeps_its_length():
    """Eight starts of 400,000 steps of 0.08 rad: it walks by 1e-20 a step at the most.

    What rounding leaves out of a step, not turned with the next, made it 1.6e-19 a step longer.
    """
    m, random = np.array([1.0, 2.0, 2.5]), np.random.default_rng(8)
    for _ in range(8):
        state = np.zeros(14)
        state[0], state[4:7] = 1.0, random.normal(size=3)
        steps(m, 0.08 / np.hypot.reduce(state[4:7]), 400_000, state)
        q = [Fraction(x) + Fraction(low) for x, low in zip(state[:4], state[7:11], strict=True)]
        assert abs(float(sum(x * x for x in q) - 1)) < 1.2e-14


@pytest.mark.parametrize("moments", [(1.0, 2.0, 2.5), (10.0, 20.0, 26.0), (3.0, 4.0, 5.0)])
def test_rounding_has_no_mean(moments):
    """A million motions of 0.25 rad from momenta of all directions, which the motion leaves so.

    Products with rounded constants moved T by 1e-2 of what one motion rounds, always the same
    way: 6e-18 an orbit of a thousand steps under gravity gradient.
    """
    count, m = 1_000_000, np.array(moments)
    momenta = np.random.default_rng(77).normal(size=(count, 3))
    momenta /= np.sqrt(np.sum(momenta**2, axis=1))[:, None]
    starts, sums = np.zeros((count, 14)), np.zeros((2, 3))
    starts[:, 0], starts[:, 4:7] = 1.0, 10.0 * m[1] * momenta / m
    moved(m, np.array([0.025]), starts, sums)
    # each change is a few roundings of a motion of 0.25 rad
    assert np.all(np.sqrt(sums[:, 1] / count) < 2e-17)
    # 6e-21: four standard errors of the mean of a million such
    assert np.all(np.abs(sums[:, 0]) < 4.0 * np.sqrt(sums[:, 1]))


@pytest.mark.parametrize("moments", [(1.0, 2.0, 2.5), (0.2, 0.8, 0.8000001)])
def test_rounding_has_no_mean_along_one_motion(moments):
    """From one start and with one step S, e1 and e3 are always the same numbers.

    Products with them that were rounded by themselves moved T by up to 1e-18 a step, 20 times what
    the walk of its roundings leaves of the mean.
    """
    m, random, scores = np.array(moments), np.random.default_rng(5), []
    for _ in range(12):
        momentum = random.normal(size=3)
        state = np.zeros(14)
        state[0] = 1.0
        state[4:7] = 10.0 * m[1] * momentum / np.sqrt(momentum @ momentum) / m
        changes, before = [], state.copy()
        for _ in range(16):
            steps(m, 0.05, 4000, state)
            changes.append(relative_change_of_energy(m, before, state))
            before = state.copy()
        mean, error = np.mean(changes), np.std(changes, ddof=1) / 4.0
        scores.append(abs(mean) / error)
    assert np.median(scores) < 2.0


def relative_change_of_energy(m, before, after):
    def energy(state):
        w = [Fraction(x) + Fraction(low) for x, low in zip(state[4:7], state[11:14], strict=True)]
        return sum(Fraction(i) * x * x for i, x in zip(m, w, strict=True))

    return float(energy(after) / energy(before) - 1)


# Schemes ------------------------------------------------------------------------------------------

E = 0.3
SPAN = 4.0
START = (0.5, 0.5, 0.5, 0.5), (1.0, 4.0, 0.5)


def eccentric_path(seconds):
    """The orbit of `gragg.EccentricOrbit`, with 1 m and 1 s for units."""
    anomaly = seconds + E * np.sin(seconds)
    for _ in range(20):
        anomaly += (seconds - anomaly + E * np.sin(anomaly)) / (1.0 - E * np.cos(anomaly))
    x, y = np.cos(anomaly) - E, np.sqrt(1.0 - E * E) * np.sin(anomaly)
    return np.stack([x, y, 0.0 * x], axis=-1)


def eccentric(**how):
    spin = Spin(epoch="2026-01-01", wxyz=START[0], angular_velocity=START[1])
    return TorquedRotation(BODY, spin, GravityGradient(eccentric_path, 1.0), **how)


@pytest.fixture(scope="module")
def exact():
    """State after SPAN, 25 digits or more, by another method and in 34 digits."""
    with mp.workdps(34):
        orbit = EccentricOrbit((10, 20, 26), mpf(E))
        start = [mpf(x) for x in (*START[0], *START[1])]
        end = integrate(orbit.slope, mpf(0), start, mpf(SPAN), 32, 14)
        return end[:4], end[4:]


def errors(exact, **how):
    history = eccentric(**how).at(SPAN)
    return (
        rotation_error(history.wxyz, exact[0], signed=True),
        rate_error(history.angular_velocity, exact[1]),
    )


@pytest.mark.parametrize("name", SCHEMES)
def test_order_of_each_scheme(name, exact):
    """Against a 30-digit integration on an eccentric orbit: halving the step tells the order."""
    order = SCHEMES[name].order
    first = 400 if order == 2 else 100
    found = [errors(exact, step=SPAN / n, scheme=name) for n in (first, 2 * first, 4 * first)]
    for which in (0, 1):
        coarse, middle, fine = (each[which] for each in found)
        assert coarse > middle > fine > 0.0
        measured = np.log2(middle / fine)
        # the next term of the error, two orders up, at these steps
        assert abs(measured - order) < 0.3, (name, which, found)


def dipole(compiled_too):
    """A magnetic dipole in a field that turns, and how its torque times y changes with turns."""

    def over_body(t, q):
        w, x, y, z = q[0], q[1], q[2], q[3]
        b, c = np.cos(2.0 * t), np.sin(2.0 * t)
        # R^T (b, c, 0)
        return (
            (w * w + x * x - y * y - z * z) * b + 2.0 * (x * y + w * z) * c,
            2.0 * (x * y - w * z) * b + (w * w - x * x + y * y - z * z) * c,
            2.0 * (x * z + w * y) * b + 2.0 * (y * z - w * x) * c,
        )

    if compiled_too:
        import numba

        over_body = numba.njit(over_body)

    def torque(t, q, omega):
        b = over_body(t, q)
        return -2.0 * b[1], 2.0 * b[0], 0.0  # (0, 0, 2) x b

    def slope(t, q, y):
        b = over_body(t, q)
        u, v = 2.0 * y[1], -2.0 * y[0]  # y x m
        return v * b[2], -u * b[2], u * b[1] - v * b[0]

    if compiled_too:
        torque, slope = numba.njit(torque), numba.njit(slope)
    return CustomTorque(torque, False, slope)


SEVERAL = {
    "two masses": lambda: [
        GravityGradient(eccentric_path, 1.0),
        GravityGradient(lambda s: np.stack([0.0 * s, 2.0 + 0.0 * s, np.sin(s)], -1), 20.0),
    ],
    "a mass and a leak": lambda: [
        ConstantTorque((3.0, -2.0, 4.0)),
        GravityGradient(eccentric_path, 1.0),
    ],
    "a mass and a dipole": lambda: [GravityGradient(eccentric_path, 1.0), dipole(True)],
    "a plain dipole": lambda: dipole(False),
}


@pytest.mark.parametrize("name", SEVERAL)
def test_force_gradient_of_several_torques(name):
    """Fourth order, whether they have a potential or not, and beside each other."""
    spin = Spin(epoch="2026-01-01", wxyz=START[0], angular_velocity=START[1])
    torques = SEVERAL[name]()
    fine = TorquedRotation(BODY, spin, torques, step=2.0 / 2000, scheme="blanes-moan").at(2.0)
    errors = []
    for n in (50, 100, 200):
        motion = TorquedRotation(BODY, spin, torques, step=2.0 / n, scheme="force-gradient")
        errors.append(np.max(np.abs(motion.at(2.0).wxyz - fine.wxyz)))
    assert errors[0] > 1e-9
    assert np.log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.3), errors


def test_fourth_order_reaches_rounding(exact):
    attitude, rate = errors(exact, step=SPAN / 8192, scheme="blanes-moan")
    # 20 rad in 8192 steps of compensated sums; the start and the orbit are rounded
    assert attitude < 2e-14 and rate < 2e-14


def test_adaptive_steps_reach_the_tolerance(exact):
    for tolerance in (1e-8, 1e-11):
        motion = eccentric(step_tolerance=tolerance, scheme="blanes-moan")
        history = motion.at(SPAN)
        error = rotation_error(history.wxyz, exact[0], signed=True)
        count = motion._grids[0].steps
        # errors of steps add up, each below the tolerance
        assert error < tolerance * count
        assert 5 < count < 4000
    assert motion.steps_taken[1] >= SPAN


@pytest.mark.parametrize("how", [{"step": 0.01}, {"tolerance": 1e-9}, {"step_tolerance": 1e-9}])
def test_dense_output(how):
    """Between steps: the order of the scheme, continuous over steps, in any order of asking."""
    fine = eccentric(step=2e-4, scheme="blanes-moan")
    motion = eccentric(scheme="blanes-moan", **how)
    random = np.random.default_rng(3)
    t = random.uniform(-3.0, 3.0, 200)
    history, reference = motion.at(t), fine.at(t)
    limit = 2e-7 if "step" in how else 2e-6
    assert np.max(np.abs(history.wxyz - reference.wxyz)) < limit
    assert np.max(np.abs(history.angular_velocity - reference.angular_velocity)) < 10 * limit
    again = eccentric(scheme="blanes-moan", **how)
    back = again.at(t[::-1])
    assert np.max(np.abs(back.wxyz[::-1] - history.wxyz)) < 1e-14
    one = motion.at(t[5])
    assert one.wxyz.shape == (4,) and np.max(np.abs(one.wxyz - history.wxyz[5])) < 1e-14
    if "step" in how:
        edge = np.nextafter(0.64, [0.0, 1.0])
        sides = motion.at(edge)
        assert np.max(np.abs(sides.wxyz[0] - sides.wxyz[1])) < 1e-14
        assert np.max(np.abs(sides.angular_velocity[0] - sides.angular_velocity[1])) < 1e-13
    assert np.all(np.isnan(motion.at([np.nan, 0.1]).wxyz) == [[True] * 4, [False] * 4])
    assert motion.at(0.0).wxyz == pytest.approx(START[0], abs=1e-15)


def test_angular_acceleration_is_the_rate_of_the_angular_velocity():
    motion = eccentric(step=1e-3, scheme="blanes-moan")
    t, h = np.array([0.5, 1.5, -0.7]), 1e-4
    w = [motion.at(t + k * h).angular_velocity for k in (-2, -1, 1, 2)]
    slope = (w[0] - 8.0 * w[1] + 8.0 * w[2] - w[3]) / (12.0 * h)
    # fourth differences of 1e-12 over 1e-4, truncation 4^5 h^4 / 30
    assert np.max(np.abs(motion.at(t).angular_acceleration - slope)) < 1e-8


def test_friction_is_in_accelerations_and_in_the_rate_at_which_attitudes_turn():
    """The slip beside the angular velocity, which is that of the momentum."""
    friction, h = InternalDissipation(0.02), 1e-3
    spin = Spin("2026-01-01", (1, 0, 0, 0), (0.1, -0.2, 0.15))
    moving = TorquedRotation(Body(moments=(10, 17, 20)), spin, friction, step=0.01)
    stopped = Impulse(1.0, (0.1, 0.0, 0.0))
    arcs = Arcs(moving.body, spin, [stopped], friction, step=0.01)
    t = np.array([5.0, 0.4, 7.0])
    for motion in (moving, arcs):
        history, before, after = (motion.at(t + shift) for shift in (0.0, -h, h))
        slope = (after.angular_velocity - before.angular_velocity) / (2 * h)
        assert np.max(np.abs(history.angular_acceleration - slope)) < 1e-8
        rate = (after.wxyz - before.wxyz) / (2 * h)
        turning = forms.angular_velocity_from_quaternion_rate(history.wxyz, rate)
        assert np.max(np.abs(history.turning_rate - turning)) < 1e-7
        assert np.max(np.abs(history.angular_velocity - turning)) > 1e-4
        axis = AxisCrossesDirection((1, 0.2, 0.3), (0.3, 0.5, 1))
        ahead, behind = (axis.values(each)[0] for each in (after, before))
        assert np.allclose(axis.values(history)[1], (ahead - behind) / (2 * h), 0.0, 1e-7)
    table = AttitudeTable.from_history(moving.at(np.arange(30.0)))
    between = np.arange(5.5, 25.0)
    assert np.max(np.abs(table.at(between).wxyz - moving.at(between).wxyz)) < 1e-7


def test_turned_axes_make_no_difference():
    """The same body described over other axes."""
    turn = quaternion.unit([0.3, -0.5, 0.2, 0.7])
    matrix = quaternion.matrix(turn)
    # components over the new axes are matrix @ those over the old ones
    body = Body(tensor=matrix @ np.diag(MOMENTS) @ matrix.T)
    spin = Spin(
        epoch="2026-01-01",
        wxyz=quaternion.multiply(START[0], quaternion.conjugate(turn)),
        angular_velocity=matrix @ START[1],
    )
    gradient = GravityGradient(eccentric_path, 1.0)
    t = np.linspace(0.0, 3.0, 7)
    turned = TorquedRotation(body, spin, gradient, step=0.01).at(t)
    plain = eccentric(step=0.01).at(t)
    back = quaternion.multiply(turned.wxyz, turn)
    assert np.max(np.abs(back - plain.wxyz)) < 1e-13
    assert np.max(np.abs(turned.angular_velocity - plain.angular_velocity @ matrix.T)) < 1e-12
    acceleration = plain.angular_acceleration @ matrix.T
    assert np.max(np.abs(turned.angular_acceleration - acceleration)) < 1e-11


def circular(n=1.0):
    return lambda seconds: np.stack(
        [np.cos(n * seconds), np.sin(n * seconds), 0.0 * seconds], axis=-1
    )


@pytest.mark.parametrize("name", SCHEMES)
def test_jacobi_energy_on_a_circular_orbit_is_bounded(name):
    """T + V - n L_normal of a tumbling body over 1000 orbits."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0.2, 0.3, 0.4), angular_velocity=(1.0, 6.0, 0.5))
    gradient = GravityGradient(circular(), 1.0)
    motion = TorquedRotation(BODY, spin, gradient, step=2.0 * np.pi / 400, scheme=name)
    t = 2.0 * np.pi * np.concatenate([np.linspace(0, 20, 301), np.linspace(980, 1000, 301)])
    history = motion.at(t)
    w = history.angular_velocity
    kinetic = 0.5 * np.sum(w * w * MOMENTS, axis=-1)
    normal = history.body_to_inertial(w * MOMENTS)[:, 2]
    jacobi = kinetic + gradient.potential(BODY, history) - normal
    error = jacobi / jacobi[0] - 1.0
    # the step turns the body by 0.1 rad; what the first 20 orbits show, the last 20 keep
    early, late = error[:301], error[301:]
    assert np.max(np.abs(early)) < (2e-4 if SCHEMES[name].order == 2 else 1e-6)
    assert np.max(np.abs(late)) < 1.5 * np.max(np.abs(early)) + 1e-12


@pytest.mark.slow
def test_rounding_does_not_drive_the_energy():
    """Two million steps whose truncation is 3e-13: the mean of the energy error stays.

    A rounded product of constants in solution/step.py, the same in every step, drove it by 3e-17 an
    orbit (6e-12 in 1e5 orbits of 1000 steps); see also `test_rounding_has_no_mean`.
    """
    path = paths.kepler(
        **dict.fromkeys(("eccentricity", "inclination", "node", "pericenter_argument"), 0.0),
        **{"mean_anomaly": 0.0, "semi_major_axis": 1.0, "gm": 1.0},
        epoch="2026-01-01",
        frame="icrf",
    )
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0.2, 0.3, 0.4), angular_velocity=(6.0, 3.0, 10.0))
    gradient = GravityGradient(path, 1.0)
    motion = TorquedRotation(BODY, spin, gradient, step=2.0 * np.pi / 2000, scheme="blanes-moan")
    random, means = np.random.default_rng(1), []
    for start in (0.0, 900.0):
        history = motion.at(2.0 * np.pi * (start + 100.0 * random.random(20_000)))
        w = history.angular_velocity
        jacobi = 0.5 * np.sum(w * w * MOMENTS, axis=-1) + gradient.potential(BODY, history)
        jacobi -= history.body_to_inertial(w * MOMENTS)[:, 2]
        means.append(np.mean(jacobi))
    # the means scatter by 1.1e-13 / sqrt(20,000), and by what rounding walks in 1e7 free motions
    assert abs(means[1] / means[0] - 1.0) < 1e-14


def test_a_last_kick_of_nothing_is_not_the_first_of_the_next_step():
    """Ruth's third order (1983) ends without one; its first kick had the torque of the third."""
    ruth = Scheme("ruth", 3, [7 / 24, 3 / 4, -1 / 24, 0], [2 / 3, -2 / 3, 1], [0] * 4, "Ruth 1983")
    exact = eccentric(step=2e-4, scheme="suzuki").at(1.0).wxyz
    found = [
        np.max(np.abs(eccentric(step=step, scheme=ruth).at(1.0).wxyz - exact))
        for step in (0.02, 0.01, 0.005)
    ]
    assert found[2] < 1e-6
    assert np.log2(found[0] / found[1]) > 2.7 and np.log2(found[1] / found[2]) > 2.7


@pytest.mark.parametrize("power", [-400, -250, -100, 100, 240])
def test_rates_far_from_one(power):
    """Units of time that no body has: the same motion, or a sentence."""
    unit = 2.0**power
    spin = Spin(
        epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=np.array([0.3, 0.6, 0.2]) * unit
    )
    exact = np.zeros(14)
    exact[0], exact[4:7] = 1.0, (0.3, 0.6, 0.2)
    steps(np.array([1.0, 2.0, 2.5]), 2.0, 1, exact)

    def found():
        motion = TorquedRotation(
            Body(moments=(1, 2, 2.5)), spin, ConstantTorque((0, 0, 0)), step=2.0 / unit
        )
        return motion.at(2.0 / unit)

    if power < -130:
        with pytest.raises(AttitudeError, match="at most 1e\\+40 s"):
            found()
    else:
        assert np.max(np.abs(found().wxyz - exact[:4])) < 1e-15


def test_rates_beyond_all_bodies_are_a_sentence():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e90, 2e90, 0))
    motion = TorquedRotation(Body(moments=(1, 2, 2.5)), spin, ConstantTorque((0, 0, 0)), step=1e-91)
    with pytest.raises(AttitudeError, match="faster than any step could resolve"):
        motion.at(1e-91)


@pytest.mark.parametrize("unit", [2.0**-600, 2.0**400])
def test_the_unit_of_the_moments_is_no_matter(unit):
    """Moments, and a torque with them, times a power of two: the same bits."""
    found = []
    for size in (1.0, unit):
        body, torque = (
            Body(moments=np.array([2.6, 1.0, 2.0]) * size),
            ConstantTorque((0, 0.1 * size, 0)),
        )
        spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(3, 1, 2))
        found.append(TorquedRotation(body, spin, torque, step=0.05).at([1.0, -2.5]))
    assert np.array_equal(found[0].wxyz, found[1].wxyz)
    assert np.array_equal(found[0].angular_velocity, found[1].angular_velocity)


def test_memory_has_a_bound(monkeypatch):
    """Every other kept state is given up when there are too many; the answer stays the same."""
    t = np.array([61.3, 3.2, 40.0, 0.02, 61.3, 61.31])
    usual = eccentric(step=0.01).at(t)
    monkeypatch.setattr(_torqued, "_MOST", 16)
    motion = eccentric(step=0.01)
    few = motion.at(t)
    assert np.array_equal(few.wxyz, usual.wxyz)
    assert np.array_equal(few.angular_velocity, usual.angular_velocity)
    grid = motion._grids[0]
    assert grid.count <= 17 and grid.every > 32 and grid.reached > 50.0
    backwards = motion.at(-t[::-1]).wxyz
    assert np.array_equal(backwards[::-1], eccentric(step=0.01).at(-t).wxyz)


def short_path(seconds_after):
    """A path that ends so many seconds after the epoch of the spin."""
    t = np.linspace(-5.0, seconds_after, 401)
    return paths.table(t, eccentric_path(t), start="2026-01-01", center="earth")


@pytest.mark.parametrize("how", [{"step": 0.01}, {"tolerance": 1e-9}, {"step_tolerance": 1e-9}])
def test_a_path_that_ends(how):
    """To its end the motion is known, and not a step more is asked of it; beyond, a sentence."""
    spin = Spin(epoch="2026-01-01", wxyz=START[0], angular_velocity=START[1])
    motion = TorquedRotation(BODY, spin, GravityGradient(short_path(4.0), 1.0), **how)
    whole = TorquedRotation(BODY, spin, GravityGradient(short_path(6.0), 1.0), **how)
    end = np.nextafter(4.0, 0.0)
    # two tables with other samples
    assert np.max(np.abs(motion.at(end).wxyz - whole.at(end).wxyz)) < 1e-7
    for t in (4.1, 9.0):
        with pytest.raises(AttitudeError, match=r"is known from .* but an epoch is"):
            motion.at(t)
    assert np.all(np.isfinite(motion.at([end, -4.9]).wxyz))


@pytest.mark.slow
def test_agreement_with_dop853_over_100_rotations():
    """By the order of the schemes, down to what DOP853 itself errs by."""
    from scipy.integrate import solve_ivp

    rates = np.array([6.0, 3.0, 10.0])
    span = 100.0 * 2.0 * np.pi / np.sqrt(rates @ rates)

    def slope(t, y):
        q, w = y[:4] / np.sqrt(y[:4] @ y[:4]), y[4:]
        u = quaternion.rotate(quaternion.conjugate(q), [np.cos(t), np.sin(t), 0.0])
        torque = 3.0 * cross(u, MOMENTS * u) - cross(w, MOMENTS * w)
        return np.concatenate([0.5 * quaternion.multiply(q, np.append(0.0, w)), torque / MOMENTS])

    spin = Spin(epoch="2026-01-01", wxyz=(1, 0.2, 0.3, 0.4), angular_velocity=rates)
    start = np.concatenate([spin.wxyz, rates])
    solved = solve_ivp(slope, (0.0, span), start, method="DOP853", rtol=1e-13, atol=1e-15)
    end = solved.y[:4, -1] / np.sqrt(np.sum(solved.y[:4, -1] ** 2))
    gradient = GravityGradient(circular(), 1.0)
    for name in ("suzuki", "force-gradient", "blanes-moan"):
        found = []
        for n in (40, 80, 640):
            motion = TorquedRotation(BODY, spin, gradient, step=span / 100 / n, scheme=name)
            found.append(rotation_error(motion.at(span).wxyz, end, signed=True))
        assert np.log2(found[0] / found[1]) == pytest.approx(4.0, abs=0.4), name
        # DOP853 at 1e-13 ends 5e-11 rad away
        assert found[2] < 1e-10, name


def test_a_free_body_stays_free():
    """A torque that vanishes leaves the exact free rotation, to the rounding of the steps."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
    t = np.linspace(-20.0, 20.0, 41)
    motion = TorquedRotation(BODY, spin, ConstantTorque((0, 0, 0)), step=0.01)
    free = FreeRotation(BODY, spin).at(t)
    # 300 rad, close to the separatrix, where a rounding grows to some hundred
    assert np.max(np.abs(motion.at(t).wxyz - free.wxyz)) < 1e-12


def test_second_epoch_in_two_doubles():
    motion = eccentric(step=0.01)
    h = 1e-9
    assert np.array_equal(motion.at(1.0, 0.0).wxyz, motion.at(1.0).wxyz)
    shifted = motion.at(1.0, h).wxyz
    assert np.max(np.abs(shifted - motion.at(1.0 + h).wxyz)) < 1e-15


def test_pickle_and_printing():
    motion = eccentric(step=0.01, scheme="suzuki")
    with pytest.raises((AttributeError, pickle.PicklingError)):
        pickle.dumps(TorquedRotation(BODY, motion.spin, lambda t, q, w: (0, 0, 0), step=0.1))
    again = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(again.at(1.0).wxyz, motion.at(1.0).wxyz)
    assert "suzuki" in repr(motion) and "0.01" in repr(motion)


def test_each_scheme_is_consistent_and_symmetric():
    for each in SCHEMES.values():
        assert sum(each.kicks) == pytest.approx(1.0, abs=1e-15)
        assert sum(each.flights) == pytest.approx(1.0, abs=1e-15)
        assert each.kicks == pytest.approx(each.kicks[::-1])
        assert each.flights == pytest.approx(each.flights[::-1])
        assert each.gradients == pytest.approx(each.gradients[::-1])
    own = Scheme("mine", 2, [0.0, 1.0, 0.0], [0.5, 0.5], [0.0] * 3, "test")
    assert scheme(own) is own


SPIN = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
NOTHING = ConstantTorque((0, 0, 0))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=1.0), "a step below 0.104 s could"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=0.1, tolerance=1e-9), "one of step="),
        (
            lambda: TorquedRotation(BODY, SPIN, NOTHING, tolerance=1e-9, step_tolerance=1e-9),
            "one of step=",
        ),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=0.1, span=(0, 1)), "for tolerance="),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, span=(1, 0)), "the earlier one first"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, span=(0, np.nan)), "the earlier one first"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, span=(0, 1, 2)), "give two epochs"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step_tolerance=1.0), "step_tolerance is 1.0"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=-0.1), "greater than zero"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, tolerance=1e-20), "from 1e-14"),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=0.1, scheme="rk4"), "one of 'kick-"),
        (lambda: TorquedRotation(BODY, SPIN, [], step=0.1), "torques is empty"),
        (lambda: TorquedRotation(BODY, SPIN, [3.0], step=0.1), "torques holds 3.0"),
        (lambda: TorquedRotation((1, 2, 3), SPIN, NOTHING, step=0.1), "takes a Body"),
        (
            lambda: TorquedRotation(
                BODY, SPIN, [NOTHING, LinearDamping(1.0)], step=0.1, scheme="force-gradient"
            ),
            "force gradient of every torque, which LinearDamping does not define",
        ),
        (
            lambda: TorquedRotation(Body(moments=(0, 5, 5)), SPIN, NOTHING, step=0.1),
            "the body is a rod",
        ),
        (
            lambda: TorquedRotation(BODY, SPIN, NOTHING, step=0.1).at(np.inf),
            "an epoch is infinite",
        ),
        (
            lambda: TorquedRotation(BODY, SPIN, ConstantTorque((0, 0, 40.0)), step=0.1).at(1e3),
            "cannot resolve the motion: .* s after the epoch",
        ),
        (
            lambda: TorquedRotation(
                BODY, SPIN, CustomTorque(lambda t, q, w: (0, 0, np.nan if t > 1 else 0)), step=0.05
            ).at(3.0),
            "the torque is not finite 1[.]",
        ),
        (
            lambda: TorquedRotation(
                BODY, SPIN, CustomTorque(lambda t, q, w: (0, 0) if t > 1 else (0, 0, 0)), step=0.05
            ).at(3.0),
            "must return three plain numbers",
        ),
        (
            lambda: TorquedRotation(
                BODY, SPIN, CustomTorque(lambda t, q, w: (0, 0, 1e250 if t > 1 else 0)), step=0.05
            ).at(3.0),
            "1[.].* s after the epoch the body turns faster than any step could resolve",
        ),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=0.1).at(1e300), "more than 2.53 steps"),
        (
            lambda: TorquedRotation(BODY, SPIN, NOTHING, tolerance=1e-9).at([0.0, -1e300]),
            "more than 2.53 steps",
        ),
        (lambda: TorquedRotation(BODY, SPIN, NOTHING, step=0.1).at(1e308, 1e308), "is infinite"),
        (
            lambda: TorquedRotation(
                BODY, SPIN, GravityGradient(lambda s: [["a"] * 3] * len(s), 1.0), step=0.05
            ).at(3.0),
            "path did not return an array of numbers",
        ),
        (lambda: Scheme("mine", 2, [1.0], [1.0], [0.0], "test"), "n [+] 1, n and n [+] 1"),
        (lambda: Scheme("mine", 2, [0.5, 0.6], [1.0], [0, 0], "test"), "kicks .* add up to 1.1"),
        (lambda: Scheme("mine", 2, [0.5, 0.5], [np.nan], [0, 0], "test"), "must be finite"),
        (lambda: Scheme("mine", 0, [0.5, 0.5], [1.0], [0, 0], "test"), "order is 0"),
        (
            lambda: TorquedRotation(
                BODY, SPIN, GravityGradient(lambda s: np.ones((len(s), 2)), 1.0), step=0.05
            ).at(3.0),
            "path returned an array of shape",
        ),
        (
            lambda: TorquedRotation(
                BODY,
                SPIN,
                GravityGradient(lambda s: np.where(s[:, None] < 2, np.ones(3), np.nan), 1.0),
                step=0.05,
            ).at(3.0),
            "path is not finite",
        ),
        (
            lambda: TorquedRotation(BODY, SPIN, LinearDamping(-1.0), step=0.1),
            "would add energy",
        ),
    ],
)
def test_bad_input_is_a_sentence(call, message):
    with pytest.raises(AttitudeError, match=message):
        call()


def test_no_step_is_short_enough_for_a_jump():
    """Adaptive steps over a torque that is not smooth end in a sentence, or within tolerance."""

    def noise(t, wxyz, omega):
        return np.sin(1e9 * t + np.array([0.0, 1.0, 2.0])) * 1e9

    for how in ({"tolerance": 1e-13}, {"step_tolerance": 1e-13}):
        motion = TorquedRotation(BODY, SPIN, CustomTorque(noise, False), **how)
        with pytest.raises(AttitudeError, match=r"not smooth there"):
            motion.at(1.0)


def test_thrusters_on_their_thresholds_are_refused_with_a_tolerance(monkeypatch):
    """Two axes slide along the edge of a dead band: a step for each of countless switches."""
    monkeypatch.setattr(_torqued, "_MANY_STEPS", 1 << 9)
    body, rates = Body(moments=(820, 910, 1250)), (4e-4, -4e-4, 8e-4)

    def thrusters(t, wxyz, omega):
        return tuple(-5.0 * np.sign(rate) * (abs(rate) > 3.5e-4) for rate in omega)

    spin = Spin(epoch="2027-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rates)
    motion = TorquedRotation(body, spin, CustomTorque(thrusters), tolerance=1e-5)
    with pytest.raises(AttitudeError, match="turns by less than a hundredth of the tolerance in"):
        motion.at(16.0)
    fixed = TorquedRotation(body, spin, CustomTorque(thrusters), step=0.05).at(16.0)
    assert np.all(np.abs(fixed.angular_velocity) < 4e-4)
