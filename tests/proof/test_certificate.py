"""Certificates against two other witnesses: the oracle of mpmath, and rigorous quadrature."""

import random
import re

import numpy as np
import pytest

from attitude import Arcs, AttitudeError, Body, FreeRotation, Impulse, InertiaChange, Spin, certify
from tests.support import hunting, states
from tests.support.measure import motion_of
from tests.support.oracle import Oracle, rate_error, rotation_error

flint = pytest.importorskip("flint", reason="python-flint is not installed")

# Above the true error by less: the radius of a ball.
TIGHT = 1e-18


def _times(state, generator, count=2):
    turns = [
        generator.choice((-1.0, 1.0)) * 10.0 ** generator.uniform(-1.0, 9.0) for _ in range(count)
    ]
    return np.array(turns) * states.revolution(state)


def _agrees(motion, oracle, t):
    """Whether a certificate is not below the error by the oracle, and above it by 1e-18 at most."""
    low = 0.0 * t  # seconds, not what looks like a Julian date
    certificate = motion.certificate(t, low, angular_velocity=True)
    history = motion.at(t, low)
    for k, seconds in enumerate(t):
        wxyz, omega = oracle.at(seconds)
        error = abs(rotation_error(history.wxyz[k], wxyz, signed=True))
        assert certificate.same_sign[k] == (error < np.pi)
        if error > 1e-12:  # an exact separatrix of a tensor, of which the package has 115 digits
            angle = min(error, 2.0 * np.pi - error)
            assert abs(certificate.error[k] - angle) <= 1e-14, (seconds, error)
            continue
        gap = certificate.error[k] - error
        assert -1e-24 <= gap <= TIGHT, (seconds, error, certificate.error[k])
        relative = rate_error(history.angular_velocity[k], omega)
        largest = max(abs(float(x)) for x in omega)
        assert relative * largest <= certificate.rate_error[k] * (1 + 1e-12) + 1e-300


def _families(family, count, seed, epochs=2):
    """Compare the certificates of some states of a family with the oracle; how many there were."""
    generator, compared = random.Random(f"{family} {seed}"), 0
    for state in states.sample(count, seed, [family]):
        try:
            motion = motion_of(state)
        except AttitudeError:
            continue  # rates that the solution refuses to drop
        oracle = Oracle(state.moments, state.wxyz0, state.omega0, digits=30)
        _agrees(motion, oracle, _times(state, generator, epochs))
        compared += 1
    return compared


def _of_tensor(tensor, wxyz, omega, t):
    """The same for a full tensor."""
    motion = FreeRotation(Body(tensor=tensor), Spin("2026-01-01", wxyz, omega))
    _agrees(motion, Oracle.from_tensor(motion.body.tensor.tolist(), wxyz, omega, digits=30), t)


# Three times a rotation matrix: tensors of whole numbers with moments of whole numbers.
_TURN = np.array([[1, -2, 2], [2, -1, -2], [2, 2, 1]])


def _exact_tensor(generator):
    """A tensor and rates of whole numbers whose motion is degenerate: symmetric, on the separatrix,
    or without one of the rates over the principal axes.
    """
    kind = generator.randrange(4)
    rates = [generator.randint(-9, 9) for _ in range(3)]
    if kind == 0:  # a symmetric body
        equal, other = generator.randint(3, 40), generator.randint(1, 5)
        moments = [equal, equal, other]
    elif kind == 1:  # the separatrix of moments a, b, c
        a, b, c, first, third = generator.choice(states._SEPARATRIX)
        moments, rates = [a, b, c], [first, rates[1], third]
    else:  # two rates or one
        moments = generator.sample(range(10, 20), 3)
        rates[generator.randrange(3)] = 0
        if kind == 3:
            rates[generator.randrange(3)] = 0
    order = generator.sample(range(3), 3)
    moments, rates = [moments[k] for k in order], [rates[k] for k in order]
    tensor = (_TURN @ np.diag(moments) @ _TURN.T).astype(float)
    return tensor, (_TURN @ rates).astype(float)


def _of_exact_tensors(count, seed):
    generator = random.Random(seed)
    for _ in range(count):
        tensor, omega = _exact_tensor(generator)
        wxyz = [generator.uniform(-1.0, 1.0) for _ in range(4)]
        speed = float(np.linalg.norm(omega)) or 1.0
        t = generator.choice((-1.0, 1.0)) * 10.0 ** generator.uniform(-1.0, 9.0) / speed
        _of_tensor(tensor, wxyz, omega.tolist(), np.array([t]))


@pytest.mark.parametrize("family", states.FAMILIES)
def test_contains_the_oracle(family):
    assert _families(family, 4, 38) >= 2


@pytest.mark.parametrize("seed", range(6))
def test_contains_the_oracle_of_tensors(seed):
    generator = random.Random(seed)
    state = states.sample(1, seed, ["tumbling"])[0]
    tensor, omega = states.tensor(state, generator)
    _of_tensor(tensor, state.wxyz0, omega, _times(state, generator))


def test_contains_the_oracle_of_degenerate_tensors():
    _of_exact_tensors(10, 38)


# 1e4 states in all: 26 families of 310, tensors of 14 of them, exactly degenerate tensors.


@pytest.mark.slow
@pytest.mark.parametrize("family", states.FAMILIES)
def test_ten_thousand_states(family):
    assert _families(family, 310, 2006, epochs=1) >= 150


@pytest.mark.slow
@pytest.mark.parametrize("family", states.TUMBLING)
def test_ten_thousand_states_of_tensors(family):
    generator = random.Random(family)
    for state in states.sample(100, 2007, [family]):
        tensor, omega = states.tensor(state, generator)
        try:
            _of_tensor(tensor, state.wxyz0, omega, _times(state, generator, 1))
        except AttitudeError as err:
            assert re.search(
                "triangle|exceeds the sum|zero within rounding|turn the body", str(err)
            )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_ten_thousand_states_of_degenerate_tensors(seed):
    _of_exact_tensors(60, seed)


@pytest.mark.parametrize("off", [1e-16, 1e-30, 1e-100, 1e-300, 5e-324])
@pytest.mark.parametrize("rates", [(0.1, 0.2, 0.3), (0.1, 0.1, 0.3), (0.3, 0.3, 1e-200)])
def test_nearly_equal_moments_of_a_tensor_are_distinguished(off, rates):
    """Moments 2 - off, 2 + off, 3: separated by bits, not by isolating the roots."""
    tensor = [[2.0, off, 0.0], [off, 2.0, 0.0], [0.0, 0.0, 3.0]]
    motion = FreeRotation(Body(tensor=tensor), Spin("2026-01-01", (1, 2, 3, 4), rates))
    certificate = motion.certificate([1.0, -1e6])
    assert np.all(certificate.error <= 4e-15) and certificate.bits.max() <= 1 << 14


@pytest.mark.parametrize(
    ("tensor", "rates"),
    [
        ([[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]], (0.3, 0.2, -0.7)),  # symmetric: 2, 2, 3
        ([[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]], (0.0, 1.0, 1.0)),  # about its axis
        ([[3, 1, 0], [1, 3, 0], [0, 0, 3]], (1.0, 1.0, 0.0)),  # moments 2, 3, 4
        ([[3, 1, 0], [1, 3, 0], [0, 0, 3]], (1.0, 0.5, 0.25)),
        ([[3, 1, 0], [1, 3, 0], [0, 0, 3]], (0.0, 0.0, 1.0)),  # the middle axis
        ([[3, 1, 0], [1, 3, 0], [0, 0, 3]], (0.0, 0.0, 0.0)),
    ],
)
def test_degenerate_tensors_are_decided(tensor, rates):
    motion = FreeRotation(Body(tensor=tensor), Spin("2026-01-01", (1, 2, 3, 4), rates))
    certificate = motion.certificate([0.0, 1.5, -1e6], angular_velocity=True)
    assert np.all(certificate.error <= 4e-15) and np.all(certificate.same_sign)
    assert np.all(certificate.rate_error <= 4e-15)


def test_the_separatrix_of_a_tensor_is_decided():
    """Moments 36, 45, 81 turned by a matrix of thirds: L^2 = 2 E I2 holds in fractions."""
    turn = np.array([[1, -2, 2], [2, -1, -2], [2, 2, 1]])
    tensor = turn @ np.diag([4.0, 5.0, 9.0]) @ turn.T
    motion = FreeRotation(
        Body(tensor=tensor), Spin("2026-01-01", (1, 0, 0, 0), turn @ (3.0, 1.0, 1.0))
    )
    certificate = motion.certificate([0.3, -5.0])
    assert motion.mode.name == "SEPARATRIX"
    assert np.all(certificate.error < 4e-15) and np.all(certificate.bits == 128)


@pytest.mark.parametrize(
    "moments", [(10.0, 20.0, 26.0), (2.0, 2.0001, 3.0), (1e-3, 1.0, 1.0007), (3.0, 6.0, 4.0)]
)
def test_rigorous_quadrature_overlaps(moments):
    """The second proof: no theta quotient, no integral of the third kind."""
    from attitude.motions._free_rotation import chain_of
    from attitude.proof._certificate import precision
    from attitude.proof._exact import rational
    from tests.support import quadrature

    generator = random.Random(str(moments))
    for _ in range(3):
        rates = [generator.gauss(0, 1) for _ in range(3)]
        motion = FreeRotation(Body(moments=moments), Spin("2026-01-01", (1, 1, -1, 1), rates))
        with precision(128):
            solution = chain_of(motion.body, motion.spin).solution()
            for t in (1.5, -40.0, 1e5):
                pairs = zip(
                    quadrature.attitude(solution, rational(t)),
                    solution.at(rational(t)),
                    strict=True,
                )
                for one, two in pairs:
                    assert one.overlaps(two) and one.rad() < 1e-20 and two.rad() < 1e-20


# ---- What a user sees


MOTION = FreeRotation(
    Body(moments=(10, 20, 26)), Spin("2026-01-01", (1, 0, 0, 0), (0.01, 0.15, 0.01))
)


def test_exact_quaternion_to_any_number_of_digits():
    state = (10.0, 20.0, 26.0), (1.0, 0.0, 0.0, 0.0), (0.01, 0.15, 0.01)
    exact = MOTION.certificate([0.0, 777.0]).exact(60)
    assert [float(x) for x in exact[0]] == [1.0, 0.0, 0.0, 0.0]
    wanted, _ = Oracle(*state, digits=70).at(777.0)
    import mpmath

    with mpmath.workdps(75):
        for x, y in zip(exact[1], wanted, strict=True):
            assert abs(mpmath.mpf(str(x)) - y) <= mpmath.mpf(10) ** -60
    assert MOTION.certificate([0.0]).exact(np.int64(5)).shape == (1, 4)
    for digits in (0, True, 2.0, 10_001):
        with pytest.raises(AttitudeError, match=f"digits is {digits}; give a whole number"):
            MOTION.certificate([0.0]).exact(digits)


def test_epochs_of_any_kind_and_shape():
    assert MOTION.certificate("2026-01-02").error.shape == ()
    assert MOTION.certificate([[1.0, 2.0]], [[1e-17, 0.0]]).error.shape == (1, 2)
    assert MOTION.certificate([]).error.shape == (0,)
    with pytest.raises(AttitudeError, match="an epoch is not finite"):
        MOTION.certificate([np.nan])


def test_what_is_assumed_is_printed():
    text = repr(MOTION.certificate([1.0, 2.0]))
    assert text.startswith("<Certificate: 2 attitudes, errors of at most ")
    assert "IEEE 754" in text and "FLINT" in text and "proved on paper" in text


def test_certify_measures_what_others_computed():
    wxyz = MOTION.at([5.0, 6.0]).wxyz
    certificate = certify(MOTION.body, MOTION.spin, [5.0, 6.0], wxyz * [[-3.0], [1.0]])
    assert np.all(certificate.error < 4e-15)
    assert certificate.same_sign.tolist() == [False, True]
    off = np.add(wxyz, (1e-6, 0.0, 0.0, 0.0))
    assert np.all(certify(MOTION.body, MOTION.spin, [5.0, 6.0], off).error > 1e-8)
    with pytest.raises(AttitudeError, match="wxyz"):
        certify(MOTION.body, MOTION.spin, [5.0], wxyz)
    with pytest.raises(AttitudeError, match="a Body and a Spin first; int and Spin are given"):
        certify(3, MOTION.spin, [5.0], wxyz[:1])
    rod = Body(moments=(1, 0, 1))
    with pytest.raises(AttitudeError, match="an axis without inertia is undefined"):
        certify(rod, MOTION.spin, [5.0], wxyz[:1])
    about_it = Spin("2026-01-01", (1, 0, 0, 0), (0.3, 0.0, 0.4))
    assert certify(rod, about_it, [0.0], [(1, 0, 0, 0)]).error[0] < 1e-30
    with pytest.raises(AttitudeError, match="not finite or zero"):
        certify(MOTION.body, MOTION.spin, [5.0], [[0.0, 0.0, 0.0, 0.0]])


def test_without_the_package_a_sentence_says_how_to_install_it(monkeypatch):
    import sys

    from attitude.proof import _exact

    monkeypatch.setitem(sys.modules, "flint", None)
    _exact.flint.cache_clear()
    with pytest.raises(AttitudeError, match=r"python-flint: pip install"):
        MOTION.certificate([1.0])
    _exact.flint.cache_clear()


@pytest.mark.parametrize("frame", ["icrf", "eme2000", "ecliptic"])
def test_attitudes_over_other_axes(frame):
    spin = Spin("2026-01-01", (1, 0.5, 0.25, -2), (0.01, 0.15, 0.01), frame)
    certificate = FreeRotation(MOTION.body, spin).certificate([1.0, 1e8])
    assert np.all(certificate.error < 4e-15)


def test_a_lost_rate_would_show():
    """The attitude of a motion without a rate of 1e-125: 3.14 rad from the exact flip."""
    body = Body(moments=(1, 2, 3))
    still = FreeRotation(body, Spin("2026-01-01", (1, 0, 0, 0), (0, 1, 0)))
    spin = Spin("2026-01-01", (1, 0, 0, 0), (1e-125, 1, 1e-125))
    certificate = certify(body, spin, [500.5], still.at([500.5]).wxyz)
    assert certificate.error[0] > 0.1


# ---- Arcs


def test_arcs_between_exact_changes():
    changes = [
        Impulse(at=10.0, angular_momentum=(0.5, -0.25, 1.0)),
        Impulse(at=25.5, angular_momentum=(0.125, 0.5, -0.5), frame="ecliptic"),
        InertiaChange(at=40.0, body=Body(tensor=[[9, 1, 0], [1, 21, 0.5], [0, 0.5, 25]])),
    ]
    motion = Arcs(MOTION.body, MOTION.spin, changes)
    t = np.array([-3.0, 9.999, 10.0, 12.0, 25.5, 30.0, 40.0, 1e5])
    certificate = motion.certificate(t, angular_velocity=True)
    assert np.all(certificate.error < 4e-15) and np.all(certificate.same_sign)
    assert np.all(certificate.rate_error < 4e-15)
    # the same state by another way: a free rotation from the exact state after the first change
    exact = certificate.exact(40)[2]
    later = MOTION.certificate([10.0]).exact(40)[0]
    assert list(exact) == list(later)


def test_exact_degenerate_arcs_are_decided():
    """An impulse along the axis of a uniform rotation: by fractions, the next arc is uniform."""
    body, spin = Body(moments=(1, 2, 3)), Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0.5))
    motion = Arcs(body, spin, [Impulse(at=4.0, angular_momentum=(0, 0, 1.0))])
    assert np.all(motion.certificate([3.0, 5.0, 1e4]).error < 4e-15)


def test_a_thousand_changes_are_no_limit():
    body, spin = Body(moments=(1, 2, 3)), Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0.5))
    changes = [Impulse(at=k + 1.0, angular_momentum=(0, 0, 0.25 * (-1) ** k)) for k in range(1000)]
    assert Arcs(body, spin, changes).certificate([1000.5]).error < 4e-15


def test_changes_that_are_rounded_end_what_is_certified():
    changes = [
        Impulse(at=10.0, angular_momentum=lambda history: (0.0, 0.0, 1.0)),
        Impulse(at=20.0, angular_momentum=(0.0, 0.0, 1.0)),
    ]
    motion = Arcs(MOTION.body, MOTION.spin, changes)
    assert motion.certificate([9.0]).error[0] < 4e-15
    with pytest.raises(AttitudeError, match=r"changes\[0\] happens at an event, or"):
        motion.certificate([9.0, 15.0])


# ---- Hunts


def test_hunt():
    """12,500 states of eight families, every one certified."""
    assert hunting.hunted(12_500, 0).max() <= 2.5e-15


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 140))
def test_long_hunt(seed):
    """1e6 states."""
    assert hunting.hunted(25_000, seed).max() <= 2.5e-15


# The worst of 40,000 attitudes and epochs of one body, whose moments are those of the worst of an
# earlier million of states (1.94e-15 rad): 1.79e-15, 1.52e-15 and 1.50e-15 rad.
_NEARLY_SPHERE = (2.0, 2.00000000158537, 2.000000003646351)


@pytest.mark.parametrize(
    ("moments", "wxyz", "rates", "t"),
    [
        (
            _NEARLY_SPHERE,
            (-0.1879972274472172, 0.6114790901864524, 0.26172702962962024, -1.0560778114858114),
            (-0.04635510080776545, -1.3505291462058509, -0.25962443594501383),
            -706963.8302136711,
        ),
        (
            _NEARLY_SPHERE,
            (-0.2405454978301648, 0.6848522581197469, 0.6233961082546553, -1.0652235167232178),
            (-0.18316381564083797, -1.1286919961673363, 0.38755220110119254),
            -9365.309865103292,
        ),
        (
            _NEARLY_SPHERE,
            (0.7448927707989128, -0.11175480388132722, 1.5841856687934137, 0.18834060516842774),
            (0.32280529661110713, 1.3325969152158215, 0.42956238308525846),
            2.5725529627581016,
        ),
    ],
)
def test_worst_states(moments, wxyz, rates, t):
    arrays = [np.array([x], float) for x in (moments, wxyz, rates)]
    assert hunting.certified_errors(*arrays, np.array([t]))[0] <= 2.0e-15
