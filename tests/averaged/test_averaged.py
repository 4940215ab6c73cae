"""Mean rotation under weak torques, against mpmath, brute means and full integrations."""

import math
import pickle

import mpmath as mp
import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, quaternion, shape
from attitude._solver.march_layout import SLIP
from attitude.averaged import AveragedMotion, _tables, over_torus
from attitude.averaged import _means as means
from attitude.averaged import _polhode as polhode
from attitude.averaged import _rates as rates
from attitude.averaged._pack import Packed, Sampling
from attitude.epochs import instant
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
from tests.support.mean_motions import ENVISAT, EPOCH, GM, circle, spinning

SLOPE = math.asin(0.954)  # of the orbits
RNG = np.random.default_rng(1)
TILTED = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
BODY = Body(tensor=TILTED @ np.diag([10.0, 26.0, 20.0]) @ TILTED.T)
AXES = polhode.Axes(BODY)
PLACE = RNG.normal(size=3) * 1e7
TENSOR = (lambda m: m @ m.T)(RNG.normal(size=(3, 3)))


def still(t):
    return np.broadcast_to(PLACE, (len(t), 3)).copy()


def field(t, position):
    """T; it changes with time, since eddy currents feel that."""
    one = np.stack([0.02 + 0.01 * t, -0.01 + 0.02 * t, 0.03 - 0.01 * t], axis=-1)
    return one


TORQUES = {
    "gravity": GravityGradient(still, 3.9e14),
    "eddy": EddyCurrent(TENSOR, field, still),
    "dipole": MagneticDipole([0.3, -1.0, 0.4], field, still),
    "constant": ConstantTorque([0.3, -1.0, 0.4]),
    "damping": LinearDamping(TENSOR),
    "friction": InternalDissipation(1e-3),
}


@pytest.mark.parametrize("region", range(4))
@pytest.mark.parametrize("h", [1e-3, 0.6, 0.8, 5.0, 30.0])
def test_polhode_is_that_of_mpmath(region, h):
    """To 5e-14: h carries the rounding of y, 1e-13 of it at h = 1e-3."""
    y = AXES.separatrix + (h if region > 1 else -h)
    points = AXES.nodes(y, region, 7)
    with mp.workdps(30):
        m = mp.exp(-mp.mpf(h))
        quarter = mp.ellipk(m)
        for j, l in enumerate(points):
            u = 4 * quarter * (j + mp.mpf(1) / 2) / 7
            cn, dn = (float(mp.ellipfun(f, u, m=m)) for f in ("cn", "dn"))
            sine, cosine = (
                math.sin(math.atan(math.exp(y / 2))),
                math.cos(math.atan(math.exp(y / 2))),
            )
            sign = -1.0 if region % 2 else 1.0
            if region < 2:
                expected = sine * cn, sign * cosine * dn
            else:
                expected = sign * sine * dn, cosine * cn
            assert l[[0, 2]] == pytest.approx(expected, abs=5e-14)
            assert l @ l == pytest.approx(1.0, abs=1e-14)


def test_variables_come_back():
    """State to (|L|, y, region) and, at the crossing of y, to the energy again: 1e-14."""
    for omega in RNG.normal(size=(20, 3)):
        size, y, _ = AXES.state(omega)
        assert size == pytest.approx(np.linalg.norm(BODY.tensor @ omega), rel=1e-14)
        assert AXES.energy(size, y) == pytest.approx(0.5 * omega @ BODY.tensor @ omega, rel=1e-13)


def brute(torque, y, region, momentum, nutation=200, precession=16):
    """dL/dt over ICRF axes and dy/dt by the trapezoidal rule over both phases."""
    size = np.linalg.norm(momentum)
    unit = momentum / size
    points = np.repeat(AXES.nodes(y, region, nutation), precession, axis=0)
    angle = math.pi * (np.arange(len(points)) % precession)[:, None] / precession
    half = np.concatenate([np.zeros((len(points), 1)), unit + points], axis=1)
    half /= np.linalg.norm(half, axis=1)[:, None]
    turn = np.concatenate([np.cos(angle), np.sin(angle) * unit], axis=1)
    back = quaternion.conjugate(AXES.numbers[polhode.TURN : polhode.MATRIX])
    wxyz = quaternion.multiply(quaternion.multiply(turn, half), back)
    omega = size * points / AXES.moments
    given = torque.sample(instant(EPOCH), np.zeros(1), np.zeros(1))
    if not given.shape[1]:
        given = np.zeros((1, 1))
    given = np.ascontiguousarray(np.broadcast_to(given, (len(points), given.shape[1])))
    parameters = np.append(np.asarray(torque.parameters(BODY), dtype=float), 0.0)
    over_body = np.ascontiguousarray(omega @ AXES.matrix.T)
    found = np.empty((len(points), 3))
    rates.torques_at(
        torque.address(),
        parameters.ctypes.data,
        np.zeros(len(points)),
        np.ascontiguousarray(wxyz),
        over_body,
        given,
        found,
    )
    if torque.kind == SLIP:
        found, mean = np.cross(size * points @ AXES.matrix.T, found), np.zeros(3)
    else:
        mean = quaternion.rotate(wxyz, found).mean(axis=0)
    along = np.sum(omega * points, axis=1)
    rate = np.sum((omega - along[:, None] * points) * (found @ AXES.matrix), axis=1)
    p, rest = polhode.shares(np.array(y))
    dy = 2.0 * np.mean(rate) / (size**2 * AXES.spread * p * rest)
    return np.append(mean, dy)


@pytest.mark.parametrize("name", TORQUES)
@pytest.mark.parametrize("how", ["table", "torus"])
def test_means_are_those_of_the_trapezoid(name, how):
    """Splines err by less than 1e-7 of the larger rate; the torus to rounding."""
    torque = TORQUES[name]
    found = means.means_of(torque, BODY, AXES, 4) if how == "table" else [over_torus(torque)]
    sampling = Sampling(torque, math.inf, False, math.inf)
    packed = Packed(AXES, BODY, [(sampling, mean) for mean in found], instant(EPOCH))
    forcing = packed.window(0, math.inf, (0.0, 0.0))
    rng = np.random.default_rng(5)
    for region in range(4):
        for h in (1e-3, 0.4, 3.0):
            y = AXES.separatrix + (h if region > 1 else -h)
            momentum, out = 7.0 * rng.normal(size=3), np.empty(4)
            arguments = packed.data, packed.models, forcing, packed.work, out, 1
            rates.rates_at(0.0, np.append(momentum, y), region, *arguments)
            expected = brute(torque, y, region, momentum)
            scale = np.max(np.abs(expected))
            assert np.max(np.abs(out - expected)) < (1e-7 if how == "table" else 1e-12) * scale


@pytest.mark.parametrize("omega", [(0.039, 0.0052, 0.026), (0.13, 0.0078, 0.0078)])
def test_gravity_gradient_agrees_with_the_full_motion(omega):
    """Pole within 2e-3 of its change; |L| and energy are constant to 1e-6.

    Without the turn of the path in the mean states they are to 1e-5.
    """
    torque = GravityGradient(circle(12e6, slope=SLOPE), GM)
    found = AveragedMotion(ENVISAT, spinning(omega), torque).check(1000)
    assert found["pole change"] > 0.05
    assert found["pole"] < 2e-3 * found["pole change"]
    assert abs(found["size"]) < 1e-6
    assert abs(found["energy"]) < 1e-6


def test_a_path_may_begin_at_the_epoch():
    """Spans are rounded inwards, to 5e-324 s behind the epoch here; its state is known."""
    motion = AveragedMotion(
        ENVISAT, spinning(), GravityGradient(circle(12e6, 0.0, 3e4), GM), orbit="followed"
    )
    states = motion.at([0.0, 2.9e4])
    assert np.array_equal(states.momentum[0], motion.start[:3])
    assert np.all(np.isfinite(states.weakness))
    with pytest.raises(AttitudeError, match="outside of the paths and fields"):
        motion.at(-1.0)


TUMBLER = Body(moments=(1.0, 2.0, 2.6))
# state, torques, turns; the change of |L| or the pole, its error of first order, its gain by second
ORDERS = {
    "gravity": (
        ENVISAT,
        (0.13, 0.0078, 0.0078),
        GravityGradient(circle(12e6, slope=SLOPE), GM),
        1000,
        "pole",
        1e-3,
        5.0,
    ),
    "rates": (
        TUMBLER,
        (1.0, 0.2, 0.3),
        [ConstantTorque((1e-3, 5e-4, 5e-4)), LinearDamping(np.diag([2e-3, 1e-3, 3e-4]))],
        60,
        "size",
        1e-3,
        50.0,
    ),
    "slips": (
        TUMBLER,
        (0.1, 0.3, 1.0),
        [ConstantTorque((1e-3, 5e-4, 5e-4)), InternalDissipation(1e-3)],
        60,
        "size",
        1e-3,
        10.0,
    ),
}


@pytest.mark.parametrize("name", ORDERS)
def test_second_order_is_nearer_to_the_full_motion(name):
    """The full motion knows nothing of series; steps of the same sizes for both orders."""
    body, omega, torques, turns, key, most, gain = ORDERS[name]
    errors = []
    for order in (1, 2):
        motion = AveragedMotion(
            body, spinning(omega), torques, orbit="followed", order=order, tolerance=1e-9
        )
        found = motion.check(turns)
        errors.append(abs(found[key]) / abs(found[f"{key} change"]))
    assert most / 20.0 < errors[0] < most
    assert errors[1] < errors[0] / gain


def test_second_order_goes_through_the_separatrix():
    """Where the series does not hold, at the separatrix and below a forced wobble, it adds nothing.

    |L| is that of first order to 2e-3 of its change, the order of eps, in the same region.
    """
    torques = [InternalDissipation(1e-3), ConstantTorque((0, 0, 1e-4))]
    one, two = (
        AveragedMotion(TUMBLER, spinning((1.0, 0.2, 0.3)), torques, order=order) for order in (1, 2)
    )
    until = 1.5e4
    first, second = one.at(until), two.at(until)
    passages = [[e for e in m.events if e.kind == "passage"] for m in (one, two)]
    assert len(passages[0]) == len(passages[1]) == 1
    assert first.region == second.region < 2
    change = abs(float(first.size) - float(one.at(0.0).size))
    assert 0.0 < abs(float(first.size - second.size)) < 2e-3 * change
    assert two.at(-50.0).size == pytest.approx(float(one.at(-50.0).size), rel=1e-4)


def test_eddy_currents_agree_with_the_full_motion():
    """To 1e-3 of the changes of |L| and energy; 2e-3 of that of the pole."""
    torque = EddyCurrent(
        np.diag([1e6, 2.2e6, 3e6]), DipoleField((0, 0, -7.8e22)), circle(7.141e6, slope=SLOPE)
    )
    found = AveragedMotion(ENVISAT, spinning((0.13, 0.0078, 0.0078)), torque).check(2000)
    assert abs(found["size"]) < 1e-3 * abs(found["size change"])
    assert abs(found["energy"]) < 1e-3 * abs(found["energy change"])
    assert found["pole"] < 2e-3 * found["pole change"]


def test_friction_keeps_the_momentum_and_passes_the_separatrix_by_a_fair_coin():
    motion = AveragedMotion(ENVISAT, spinning((0.13, 0.0078, 0.0078)), InternalDissipation(1e-4))
    found = motion.check(2000)
    assert abs(found["size"]) < 1e-10
    assert abs(found["energy"]) < 1e-5 * abs(found["energy change"])
    (passage,) = [event for event in motion.events if event.kind == "passage"]
    assert passage.before == "LAM+"
    assert list(passage.odds.values()) == pytest.approx([0.5, 0.5], abs=1e-9)
    leaves = motion.branches(found["seconds"])
    assert sum(leaf.odds for leaf in leaves) == pytest.approx(1.0, abs=1e-12)
    assert {leaf.regions[-1] for leaf in leaves} == {"SAM+", "SAM-"}


def test_odds_follow_the_torque_about_the_short_axis():
    """A constant torque about it makes one end likelier, the opposite torque the other end."""
    spin = spinning((0.13, 0.0078, 0.0078))
    shares = []
    for torque in (0.02, -0.02):
        both = [InternalDissipation(1e-3), ConstantTorque((0.0, 0.0, torque))]
        motion = AveragedMotion(ENVISAT, spin, both)
        motion.at(1e5)
        passage = next(event for event in motion.events if event.kind == "passage")
        shares.append(passage.odds["SAM+"])
    assert abs(shares[0] - 0.5) > 0.01
    assert sum(shares) == pytest.approx(1.0, abs=0.02)  # L differs a little at the passage


def test_free_rotation_has_the_mean_momentum_and_energy():
    states = AveragedMotion(ENVISAT, spinning(), LinearDamping(0.05)).at([0.0, 1e5])
    free = states[1].free_rotation(phases=(0.1, 0.7))
    assert free.energy == pytest.approx(float(states.energy[1]), rel=1e-12)
    assert free.momentum == pytest.approx(states.momentum[1], rel=1e-12)
    assert free.period_psi == pytest.approx(float(states.P_psi[1]), rel=1e-10)


def test_answers_do_not_depend_on_earlier_questions():
    """Steps never end at an epoch that was asked."""
    one = AveragedMotion(ENVISAT, spinning(), LinearDamping(0.05))
    two = AveragedMotion(ENVISAT, spinning(), LinearDamping(0.05))
    one.at(3e4)
    assert np.allclose(one.at(9e4).momentum, two.at(9e4).momentum, rtol=1e-6, atol=0.0)


@pytest.mark.parametrize(
    ("torques", "settings", "words"),
    [
        (ConstantTorque((500.0, 0.0, 0.0)), {}, "not weak"),
        (GravityGradient(circle(1e5), GM), {}, "ten times slower"),
        (ConstantTorque((0.01, 0, 0)), {"orbit": "fixed"}, "orbit"),
        (ConstantTorque((0.01, 0, 0)), {"orbit": ["auto", "auto"]}, "2 entries for 1"),
        (ConstantTorque((0.01, 0, 0)), {"passages": "coin"}, "passages"),
        (ConstantTorque((0.01, 0, 0)), {"least_tilt": "40 deg"}, "least_tilt"),
        (ConstantTorque((0.01, 0, 0)), {"tolerance": 1.0}, "tolerance"),
        (ConstantTorque((0.01, 0, 0)), {"passages": None}, "seed of a draw"),
        (lambda t, q, w: (np.nan, 0.0, 0.0), {}, "not finite at the epoch"),
        (ConstantTorque((0.01, 0, 0)), {"order": 3}, "order is 3; give 1 or 2"),
        (ConstantTorque((0.01, 0, 0)), {"order": 2, "orbit": "averaged"}, "order=1"),
    ],
)
def test_refusals_are_sentences(torques, settings, words):
    with pytest.raises(AttitudeError, match=words):
        AveragedMotion(ENVISAT, spinning(), torques, **settings)


def test_questions_about_no_event_or_several_epochs_are_refused():
    motion = AveragedMotion(ENVISAT, spinning(), InternalDissipation(1e-3))
    for event in (None, "resonance", 3):
        with pytest.raises(AttitudeError, match="give one of the resonances"):
            motion.through(event)
    for ask in (motion.branches, motion.reaches, motion.ends):
        with pytest.raises(AttitudeError, match=r"shape \(2,\); give one epoch"):
            ask([1.0, 2.0])
    for body, spin in ((None, spinning()), (ENVISAT, None)):
        with pytest.raises(AttitudeError, match="takes a Body, a Spin"):
            AveragedMotion(body, spin, InternalDissipation(1e-3))


@pytest.mark.parametrize("torque", [InternalDissipation(1e-3), LinearDamping(0.002)])
def test_a_symmetric_body_has_no_separatrix(torque):
    """Whose numbers are not divided by zero: a warning is an error here."""
    AveragedMotion(Body(moments=(10, 10, 18)), spinning(), torque).at(10.0)


def test_friction_lays_a_prolate_body_down_once():
    """To a turn about a short axis, where it stays."""
    body, spin = Body(moments=(10, 1000, 1000)), spinning((0.1, 0.03, 0.04))
    motion = AveragedMotion(body, spin, InternalDissipation(1e-3))
    assert motion.at(1e8).energy == pytest.approx(1.25 + 5e-7 + 5e-4, abs=1e-5)
    assert [str(event) for event in motion.events] == ["uniform rotation reached (LAM+)"]


@pytest.mark.parametrize(
    ("moments", "omega", "torque", "tilt", "mode"),
    [
        ((610, 965, 1000), (1e-5, 0, 0.04), InternalDissipation(1e-6), 0.3, "SAM"),
        ((500, 999.9, 1000), (1e-5, 0, 0.04), InternalDissipation(1e-6), "1 deg", "SAM"),
        ((610, 640, 1000), (0.04, 0, 1e-5), LinearDamping(1e-9), 0.45, "LAM"),
        ((0.19, 1000, 1000.01), (1e-6, 0.03, 0.04), ConstantTorque((1e-7, 0, 0)), 2e-4, "SAM"),
    ],
)
def test_the_least_tilt_leads_over_no_separatrix(moments, omega, torque, tilt, mode):
    motion = AveragedMotion(Body(moments=moments), spinning(omega), torque, least_tilt=tilt)
    assert [str(m) for m in motion.at([0.0, 1e4]).mode] == [mode, mode]
    assert not any(event.kind == "passage" for event in motion.events)


@pytest.mark.parametrize(
    ("moments", "omega"),
    [
        ((1, 500, 500.5), (-6.3605e-4, -4.9896e-4, -0.02246678)),
        ((5e3, 1e5, 1.001e5), (2e-5, 0.0012, 0.06)),
        ((1000, 1000.05, 1900), (0.06, 0.0005, 1e-7)),
    ],
)
def test_the_least_tilt_is_one_of_the_greatest_nutation(moments, omega):
    """States that nutate by more keep their energy, also next to an axis the separatrix nears."""
    body, spin = Body(moments=moments), spinning(omega)
    states = AveragedMotion(body, spin, InternalDissipation(1e-12)).at(0.0)
    assert states.P_psi == pytest.approx(FreeRotation(body, spin).period_psi, rel=1e-9)


@pytest.mark.parametrize("moments", [(10, 20, 26), (1, 500, 500.5), (1000, 1000.05, 1900)])
@pytest.mark.parametrize(("axis", "seconds"), [("S", 1e10), ("L", -1e10)])
def test_friction_leads_to_the_least_tilt(moments, axis, seconds):
    """From the long axis, forwards and backwards in time."""
    torque = InternalDissipation(1e-4)
    spin = spinning((0.1, 1e-5, 1e-6))
    motion = AveragedMotion(Body(moments=moments), spin, torque, least_tilt="2 deg")
    free = motion.at(seconds).free_rotation((0.0, 0.0))
    assert free.regime.nutation(axis)[1] == pytest.approx(math.radians(2.0), rel=1e-9)


def test_a_sphere_and_a_body_at_rest_are_refused():
    with pytest.raises(AttitudeError, match="equal"):
        AveragedMotion(Body(moments=(2, 2, 2)), spinning(), ConstantTorque((1e-6, 0, 0)))
    with pytest.raises(AttitudeError, match="does not rotate"):
        AveragedMotion(ENVISAT, spinning((0, 0, 0)), ConstantTorque((1e-6, 0, 0)))


def test_a_slowing_spin_ends_with_an_event():
    motion = AveragedMotion(ENVISAT, spinning(), [LinearDamping(2.0), ConstantTorque((0, 0.05, 0))])
    with pytest.raises(AttitudeError, match="no longer weak"):
        motion.at(1e8)
    assert motion.events[-1].kind == "no longer weak"


def test_the_key_of_a_shaded_table_has_no_address():
    """Equal torques have equal tables on disk, wherever their shares of light lie in memory."""
    mesh = shape.box_wing((2.0, 1.0, 1.0), (3.0, 1.0))
    body = Body(moments=(1700.0, 4000.0, 4500.0))
    first, second = (SolarRadiation(mesh, _at_earth, shadows=True) for _ in range(2))
    assert first.parameters(body)[0] != second.parameters(body)[0]
    for a, b in zip(first.contents(body), second.contents(body), strict=True):
        np.testing.assert_array_equal(a, b)


def _at_earth(seconds):
    return np.broadcast_to([1.496e11, 0.0, 0.0], (len(seconds), 3))


def _drag(t, wxyz, omega):
    return -0.05 * omega


@pytest.mark.parametrize("torque", [GravityGradient(_at_earth, 1e27), _drag])
def test_pickles_answer_as_the_motion(torque):
    """Means of closed form, and over nodes of both phases, whose function has an address."""
    motion = AveragedMotion(ENVISAT, spinning(), torque)
    states = motion.at([0.0, 3e3])
    again, history = pickle.loads(pickle.dumps((motion, states)))
    for found in (again.at([0.0, 3e3]), history):
        np.testing.assert_array_equal(found.momentum, states.momentum)
        np.testing.assert_array_equal(found.P_psi, states.P_psi)
    copied, own = again.packing.packed.models, motion.packing.packed.models
    assert (copied[0, rates.PARAMETERS] != own[0, rates.PARAMETERS]) == (torque is _drag)


@pytest.mark.parametrize("degree", [1, 2, 7, 32, 64])
@pytest.mark.parametrize("is_averaged", [False, True])
def test_sums_over_degrees_are_those_of_legendre(degree, is_averaged):
    """One direction by Clenshaw's sums, 32 directions by recursions: 1e-12 of the terms."""
    rng = np.random.default_rng(degree)
    sums = rng.normal(size=(degree + 1, 4)) / (1.0 + np.arange(degree + 1.0))[:, None] ** 2
    sums[0, 2:] = 0.0
    nodes = len(_tables.coordinates(AXES))
    table = np.broadcast_to((sums * _tables.weights(degree)).reshape(-1), (4, nodes, sums.size))

    def numbers(vectors):
        unit = vectors / np.linalg.norm(vectors, axis=1)[:, None]
        return np.concatenate([unit, np.full((len(vectors), 1), 0.7)], axis=1)

    torque = GravityGradient(circle(12e6, slope=SLOPE), GM)
    mean = means.Mean(rates.HARMONICS, numbers, table, table[:, 0], 0, 1.0)
    period = 2.0 * math.pi / math.sqrt(3.986004418e14 / 12e6**3)
    sampling = Sampling(torque, period, is_averaged, math.inf)
    packed = Packed(AXES, BODY, [(sampling, mean)], instant(EPOCH))
    forcing = packed.window(0, math.inf, (0.0, 0.0))
    momentum, out = np.array([2.0, -3.0, 5.0]), np.empty(4)
    state = np.append(momentum, AXES.separatrix + 0.7)
    rates.rates_at(0.0, state, 2, packed.data, packed.models, forcing, packed.work, out, 1)
    unit, expected = momentum / np.linalg.norm(momentum), np.zeros(4)
    directions = forcing[rates.HEAD :].reshape(-1, 4)
    assert len(directions) == (32 if is_averaged else 1)
    slopes = np.maximum(np.arange(degree + 1.0) * (np.arange(degree + 1.0) + 1.0), 1.0)
    for *s, weight in directions:
        c = unit @ s
        basis = np.eye(degree + 1)
        values = np.polynomial.legendre.legval(c, basis)
        steep = np.array(
            [np.polynomial.legendre.legval(c, np.polynomial.legendre.legder(row)) for row in basis]
        )
        along, energy = values @ sums[:, 0], values @ sums[:, 1]
        radial, across = (steep / slopes) @ sums[:, 2], (steep / slopes) @ sums[:, 3]
        expected[:3] += weight * (along * unit + radial * (s - c * unit))
        expected[:3] += weight * across * np.cross(unit, s)
        expected[3] += weight * 2.0 * energy / np.linalg.norm(momentum)
    assert np.allclose(out, expected, rtol=0.0, atol=1e-12 * np.max(np.abs(sums)))
