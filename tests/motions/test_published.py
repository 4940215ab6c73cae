"""Published sets: there and back in every mode and convention, against what papers print."""

import math
from random import Random

import numpy as np
import pytest
from astropy import units as u

from attitude import AttitudeError, Body, FreeRotation, Mode, Spin
from attitude._solver.regime import regimes
from attitude.frames import quaternion
from attitude.motions import _conventions
from attitude.motions._published import (
    longest_P_phi,
    moments_from_ratios,
    possible,
    symmetric_moments,
    total_spin,
)
from attitude.motions._uncertainty import spread

APOPHIS = Body(moments=(0.61, 0.965, 1.0), relative=True)
POLE = np.radians([250.0, -75.0])
SET = {
    "mode": "SAM",
    "convention": "S",
    "P_psi": 263.0 * u.h,
    "P_phi": 27.38 * u.h,
    "pole": [250 * u.deg, -75 * u.deg],
    "phi0": 0.3,
    "psi0": 0.5,
    "epoch": "2012-12-23",
}


def motion_of(body, **periods):
    return FreeRotation(body, Spin.from_periods(body, **periods))


def turned_by(angle):
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def random_body(random):
    """Moments in any order about the body axes, or a full tensor."""
    x, y, z = (random.uniform(0.1, 1.0) for _ in range(3))
    moments = [y + z, x + z, x + y]
    random.shuffle(moments)
    if random.random() < 0.3:
        turn = quaternion.matrix(quaternion.unit([random.gauss(0, 1) for _ in range(4)]))
        tensor = turn @ np.diag(moments) @ turn.T
        return Body(tensor=0.5 * (tensor + tensor.T))
    return Body(moments=moments)


def random_state(random, body):
    wxyz = [random.gauss(0, 1) for _ in range(4)]
    rate = [random.gauss(0, 1) * 10.0 ** random.uniform(-6, 1) for _ in range(3)]
    frame = random.choice(("icrf", "ecliptic"))
    return Spin(epoch="2026-01-01", wxyz=wxyz, angular_velocity=rate, frame=frame)


def test_state_to_published_to_state_to_published():
    """1e-12 in periods and angles; those of the state are conditioned by the periods."""
    random, seen = Random(11), set()
    for _ in range(400):
        body = random_body(random)
        motion = FreeRotation(body, random_state(random, body))
        regime = motion.regime
        if regime.m < 1e-3 or regime.one_minus_m < 1e-3:
            continue  # a wobble of 1e-3 or less: the periods hold fewer digits of it
        for convention in "LS":
            table = motion.published(convention)
            again = FreeRotation(body, Spin.from_periods(body, **table.keywords()))
            back = again.published(convention)
            seen.add((table.mode, convention))
            assert back.mode == table.mode and back.frame == table.frame
            assert back.P_psi == pytest.approx(table.P_psi, rel=1e-12)
            assert back.P_phi == pytest.approx(table.P_phi, rel=1e-12)
            for name in ("phi0", "psi0"):
                assert abs(turned_by(getattr(back, name) - getattr(table, name))) < 1e-12
            np.testing.assert_allclose(np.sin(back.pole), np.sin(table.pole), atol=1e-12)
            np.testing.assert_allclose(np.cos(back.pole), np.cos(table.pole), atol=1e-12)
            # theta has half the digits where it turns back (psi at the end of its libration)
            assert back.theta0 == pytest.approx(table.theta0, abs=1e-5)
            assert back.energy_ratio == pytest.approx(table.energy_ratio, rel=1e-11)
    assert seen == {("LAM", "L"), ("LAM", "S"), ("SAM", "L"), ("SAM", "S")}


def test_published_to_state_to_published():
    random, seen = Random(12), set()
    for _ in range(400):
        body = random_body(random)
        moments = body.moments[_conventions.order(body)]
        mode, convention = random.choice(("LAM", "SAM")), random.choice("LS")
        P_psi = 10.0 ** random.uniform(-3, 8)
        P_phi = longest_P_phi(moments, mode, convention, P_psi) * random.uniform(0.5, 0.98)
        librates = (mode == "LAM") == (convention == "S")
        center = random.choice((0.0, math.pi)) + (0.5 * math.pi if mode == "LAM" else 0.0)
        given = {
            "mode": mode,
            "convention": convention,
            "P_psi": P_psi,
            "P_phi": P_phi,
            "pole": (random.uniform(0, 2 * math.pi), random.uniform(-1.5, 1.5)),
            "phi0": random.uniform(0, 2 * math.pi),
            "psi0": center + 0.05 * random.uniform(-1, 1) if librates else random.uniform(0, 6.28),
            "theta_branch": random.choice(("acute", "obtuse")),
        }
        motion = motion_of(body, **given, epoch="2026-01-01")
        table = motion.published(convention)
        seen.add((mode, convention))
        assert table.mode == mode and motion.mode is (
            Mode.LONG_AXIS if mode == "LAM" else Mode.SHORT_AXIS
        )
        assert table.P_psi == pytest.approx(P_psi, rel=1e-12)
        assert table.P_phi == pytest.approx(P_phi, rel=1e-12)
        assert table.theta_branch == given["theta_branch"]
        assert table.frame == "ecliptic"
        np.testing.assert_allclose(table.pole, given["pole"], rtol=0, atol=1e-12)
        # phi and psi are told apart by sin theta
        sine = math.sin(table.theta0)
        for name in ("phi0", "psi0"):
            assert abs(turned_by(getattr(table, name) - given[name])) * sine < 1e-12
    assert len(seen) == 4


def test_labels_do_not_depend_on_the_order_of_the_moments():
    """The same table for a body whose axes are named otherwise is the same motion of the body."""
    table = dict(SET, psi0=0.4)
    straight = motion_of(APOPHIS, **table)
    t = np.linspace(0.0, 1e6, 7)
    for moments in ((0.965, 1.0, 0.61), (1.0, 0.965, 0.61), (0.61, 1.0, 0.965)):
        other = Body(moments=moments, relative=True)
        turned = motion_of(other, **table)
        for convention in "LS":
            np.testing.assert_allclose(
                np.cos(turned.angles(t, convention) - straight.angles(t, convention)),
                1.0,
                atol=1e-13,
            )
            labels = [
                motion.at(t).body_to_inertial(_conventions.axes(body, convention)[:, 2])
                for motion, body in ((straight, APOPHIS), (turned, other))
            ]
            np.testing.assert_allclose(*labels, atol=1e-12)


def test_the_attitude_is_the_product_of_the_printed_rotations():
    motion = motion_of(APOPHIS, **SET)
    table = motion.published("S")

    def about(axis, angle):
        c, s = math.cos(angle), math.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[i, i] = matrix[j, j] = c
        matrix[j, i], matrix[i, j] = s, -s
        return matrix

    longitude, latitude = POLE
    product = about(2, longitude) @ about(1, math.pi / 2 - latitude)
    product = product @ about(2, 0.3) @ about(0, table.theta0) @ about(2, 0.5)
    np.testing.assert_allclose(quaternion.matrix(motion.spin.wxyz), product, atol=1e-15)
    # sin^2 theta0 of the paper's formula, with D = C / (E/E0)
    a, b, c = APOPHIS.moments
    d = c / table.energy_ratio
    square = (1 / d - 1 / c) / (math.sin(0.5) ** 2 / a + math.cos(0.5) ** 2 / b - 1 / c)
    assert math.sin(table.theta0) ** 2 == pytest.approx(square, rel=1e-12)


def test_apophis_as_pravec_printed_it():
    motion = motion_of(APOPHIS, **SET)
    assert motion.published("S").energy_ratio == pytest.approx(1.0236, abs=5e-5)
    # the strongest signal of the light curve, 30.56 h
    assert motion.published("L").P_phi / 3600.0 == pytest.approx(30.562, abs=5e-4)
    assert motion.mode is Mode.SHORT_AXIS
    # 2 pi / P_psi is not the spin rate: nine times too slow
    assert motion.regime.mean_spin_rate * 263 * 3600 / (2 * math.pi) == pytest.approx(8.7, abs=0.1)


def test_angles_of_no_epoch_are_no_numbers():
    motion = FreeRotation(
        Body(moments=(1, 2, 3)), Spin("2026-01-01", (1, 0, 0, 0), (0.1, 0.2, 0.3))
    )
    angles = motion.angles([0.0, np.nan], "L")
    assert np.all(np.isfinite(angles[0])) and np.all(np.isnan(angles[1]))
    resting = FreeRotation(motion.body, Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0)))
    with pytest.raises(AttitudeError, match="at rest"):
        resting.angles(0.0, "L")


def test_toutatis_from_its_state():
    body = Body(moments=(3.0836, 3.235, 1.0), relative=True)
    spin = Spin.from_angles(
        body,
        epoch="1992-11-09T17:49:47",
        convention="L",
        angles=[145.498, 65.865, 241.524] * u.deg,
        angular_velocity=[14.51, 33.529, -98.709] * u.deg / u.day,
    )
    table = FreeRotation(body, spin).published("L")
    assert table.mode == "LAM"
    assert table.P_psi / 86400.0 == pytest.approx(5.3685, abs=5e-5)
    assert table.P_phi / 86400.0 == pytest.approx(7.4117, abs=5e-5)
    direct = Spin.from_euler(
        epoch="1992-11-09T17:49:47",
        sequence="313",
        angles=[145.498, 65.865, 241.524] * u.deg,
        angular_velocity=[14.51, 33.529, -98.709] * u.deg / u.day,
        frame="ecliptic",
    )
    assert abs(spin.wxyz @ direct.wxyz) == pytest.approx(1.0, abs=4e-16)
    np.testing.assert_array_equal(spin.angular_velocity, direct.angular_velocity)


def test_halley_from_two_periods_and_an_angle():
    halley = {"mode": "LAM", "P_psi": "7.1 d", "P_phi": "3.69 d", "theta": "66 deg"}
    period, angle = total_spin(**halley)
    assert period / 86400.0 == pytest.approx(2.84, abs=0.005)
    assert math.degrees(angle) == pytest.approx(21.40, abs=0.005)
    # the same from the motion of the symmetric body that has these three numbers
    body = Body(moments=symmetric_moments(**halley), relative=True)
    motion = motion_of(
        body,
        mode="LAM",
        convention="L",
        P_psi="7.1 d",
        P_phi="3.69 d",
        pole=(0.0, 0.0),
        phi0=0.0,
        psi0=0.0,
        epoch="1986-03-09",
    )
    assert motion.published("L").theta0 == pytest.approx(math.radians(66.0), rel=1e-12)
    assert 2 * math.pi / motion.regime.spin_rate == pytest.approx(period, rel=1e-12)
    spin = motion.at(0.0).angular_velocity_inertial
    cosine = spin @ motion.momentum / np.linalg.norm(spin) / np.linalg.norm(motion.momentum)
    assert math.acos(cosine) == pytest.approx(angle, rel=1e-10)


def test_oblate_precession():
    # a coin: psi against phi at cos(theta) C/I - cos(theta), I/C = 1/2
    moments = symmetric_moments(mode="SAM", P_psi=10.0, P_phi=4.0, theta=0.3)
    found = regimes(moments, np.array([0.0, math.sin(0.3), math.cos(0.3)]) / moments)
    assert found.P_psi / found.P_phi_S == pytest.approx(2.5, rel=1e-14)
    with pytest.raises(AttitudeError, match=r"no body in SAM .* P_psi below twice P_phi"):
        symmetric_moments(mode="SAM", P_psi=10.0, P_phi=9.0, theta=0.3)
    with pytest.raises(AttitudeError, match=r"at most twice .* give theta up to 36.8699 deg"):
        symmetric_moments(mode="SAM", P_psi=10.0, P_phi=4.0, theta=0.7)
    for function in (symmetric_moments, total_spin):
        with pytest.raises(AttitudeError, match="90 deg or more"):
            function(mode="LAM", P_psi=10.0, P_phi=9.0, theta=1.6)


def test_the_same_periods_belong_to_four_states():
    combinations = possible(APOPHIS.moments, 263.0, 27.38)
    assert len(combinations) == 4
    assert possible(APOPHIS.moments[::-1], "263 h", 27.38 * u.h) == combinations
    energies = set()
    for mode, convention in combinations:
        librates = (mode == "LAM") == (convention == "S")
        psi0 = math.pi / 2 if mode == "LAM" and librates else 0.0
        motion = motion_of(
            APOPHIS, **{**SET, "mode": mode, "convention": convention, "psi0": psi0},
            theta_branch="acute" if librates else None,
        )  # fmt: skip
        assert motion.published(convention).P_phi == pytest.approx(27.38 * 3600, rel=1e-12)
        energies.add(round(motion.regime.energy_ratio, 3))
    assert len(energies) == 4


def test_from_energy_is_from_periods():
    motion = motion_of(APOPHIS, **SET)
    common = {name: SET[name] for name in ("convention", "pole", "phi0", "psi0", "epoch")}
    for period in ("P_psi", "P_phi"):
        again = Spin.from_energy(
            APOPHIS, energy_ratio=motion.regime.energy_ratio, **common, **{period: SET[period]}
        )
        # E/E0 - 1 = 0.024 is known to 1e-14, the angle theta to its half of that
        np.testing.assert_allclose(again.angular_velocity, motion.spin.angular_velocity, rtol=1e-12)
        np.testing.assert_allclose(again.wxyz, motion.spin.wxyz, atol=1e-12)
    ratio = motion.regime.energy_ratio
    with pytest.raises(AttitudeError, match=r"belongs to SAM.*LAM has 1.03\d+ to 1.63"):
        Spin.from_energy(APOPHIS, energy_ratio=ratio, **common, P_phi="27 h", mode="LAM")
    with pytest.raises(AttitudeError, match=r"between 1 .*and 1\.639"):
        Spin.from_energy(APOPHIS, energy_ratio=0.99, **common, P_phi="27 h")
    with pytest.raises(AttitudeError, match="one of P_psi and P_phi"):
        Spin.from_energy(APOPHIS, energy_ratio=1.02, **common)
    with pytest.raises(AttitudeError, match="separatrix"):
        Spin.from_energy(
            Body(moments=(0.5, 0.75, 1.0)), energy_ratio=4.0 / 3.0, **common, P_phi=1.0
        )


def test_from_pole_is_from_periods():
    motion = motion_of(APOPHIS, **SET)
    table = motion.published("S")
    common = {name: SET[name] for name in ("convention", "pole", "phi0", "epoch")}
    by_rates = Spin.from_pole(APOPHIS, **common, angular_velocity=motion.spin.angular_velocity)
    by_angles = Spin.from_pole(APOPHIS, **common, theta0=table.theta0, psi0=0.5, P_phi="27.38 h")
    for spin in (by_rates, by_angles):
        np.testing.assert_allclose(spin.wxyz, motion.spin.wxyz, atol=1e-14)
        np.testing.assert_allclose(spin.angular_velocity, motion.spin.angular_velocity, rtol=1e-12)
    with pytest.raises(AttitudeError, match="leave them out"):
        Spin.from_pole(APOPHIS, **common, angular_velocity=(1, 2, 3), psi0=0.5)
    with pytest.raises(AttitudeError, match="either angular_velocity, or theta0"):
        Spin.from_pole(APOPHIS, **common, theta0=0.1)
    with pytest.raises(AttitudeError, match="between 0 and 180 deg"):
        Spin.from_pole(APOPHIS, **common, theta0=-0.1, psi0=0.5, P_phi=1.0)


def test_relaxed_rotators_are_those_of_damit():
    """(lambda, beta, P, phi0, JD0): r_ecl = Rz(lambda) Ry(90 - beta) Rz(phi0 + 2 pi t / P) r."""
    given = {"P": "6 h", "pole": POLE, "phi0": "40 deg", "epoch": "2455000.5 TDB"}
    given["epoch"] = "2009-06-18"
    for body in (None, APOPHIS):
        spin = Spin.from_periods(body, **given)
        motion = FreeRotation(APOPHIS, spin)
        assert motion.mode is Mode.PRINCIPAL_AXIS
        t = 1234.5
        turn = quaternion.multiply(
            _conventions.pole_wxyz(POLE),
            _conventions.euler_wxyz(math.radians(40.0) + 2 * math.pi * t / 21600.0, 0.0, 0.0),
        )
        matrix = quaternion.matrix(turn)
        ours = np.linalg.inv(
            FreeRotation(APOPHIS, Spin(given["epoch"], (1, 0, 0, 0), (0, 0, 1), "ecliptic"))
            .at(0.0).matrix
        ) @ motion.at(t).matrix  # fmt: skip
        np.testing.assert_allclose(ours, matrix, atol=1e-14)
    table = motion.published("S")
    assert table.theta0 == 0.0 and table.energy_ratio == 1.0
    again = Spin.from_periods(APOPHIS, **table.keywords())
    np.testing.assert_allclose(again.angular_velocity, spin.angular_velocity, atol=1e-18)
    with pytest.raises(AttitudeError, match="relaxed rotator; leave out"):
        Spin.from_periods(APOPHIS, **given, mode="SAM")
    with pytest.raises(AttitudeError, match="body is None; give a Body, or one period P"):
        Spin.from_periods(None, **SET)


def test_symmetric_bodies_have_one_mode():
    oblate = Body(moments=(1.0, 1.0, 1.5))
    motion = motion_of(oblate, **{**SET, "P_psi": 10.0, "P_phi": 2.0})
    assert motion.mode is Mode.SYMMETRIC
    assert motion.published("S").P_phi == pytest.approx(2.0, rel=1e-14)
    with pytest.raises(AttitudeError, match="has no LAM: the least two are equal"):
        motion_of(oblate, **{**SET, "mode": "LAM"})
    with pytest.raises(AttitudeError, match="has no SAM: the greatest two are equal"):
        motion_of(Body(moments=(1.0, 1.5, 1.5)), **SET)
    with pytest.raises(AttitudeError, match="Give rates instead"):
        motion_of(Body(moments=(1.0, 1.0, 1.0)), **SET)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"P_psi": -1.0}, "P_psi is -1.0; it must be greater than zero"),
        ({"P_phi": 0.0}, "P_phi is 0.0"),
        ({"P_phi": 40.0 * u.h}, r"P_phi can be 12\d+.* s at the most"),
        ({"P_psi": 30.0 * u.h, "P_phi": 13.0 * u.h}, "A motion with these periods exists in: LAM"),
        ({"P_psi": 1e10 * u.h}, "nearer to the separatrix|do not determine its period"),
        ({"mode": "NPA"}, 'give "LAM"'),
        ({"mode": Mode.SYMMETRIC}, 'give "LAM"'),
        ({"mode": None}, "mode is missing"),
        ({"convention": "long"}, '"L" where phi'),
        ({"convention": None, "mode": None}, "mode, convention are missing"),
        ({"pole": (250, -75)}, "Plain numbers are radians"),
        ({"pole": ["250 deg", "-95 deg"]}, "latitude is .* between -90 and 90 deg"),
        ({"phi0": 152.0}, "phi0 is 152 rad .* -360 and 360 deg"),
        ({"psi0": "370 deg"}, "psi0"),
        ({"convention": "L"}, "psi librates in SAM .* theta_branch"),
        ({"convention": "L", "theta_branch": "acute", "psi0": 1.5}, "librates within .* deg of 0"),
        ({"theta_branch": "upper"}, 'give "acute" or "obtuse"'),
        ({"frame": "j2000"}, "two things"),
    ],
)
def test_impossible_sets_are_sentences(change, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        motion_of(APOPHIS, **{**SET, **change})


@pytest.mark.parametrize(
    ("make", "given"),
    [
        (Spin.from_periods, {"P": 100.0}),
        (Spin.from_periods, SET),
        (Spin.from_energy, {"energy_ratio": 1.2, "convention": "L", "P_psi": 300.0, "psi0": 0.0}),
        (Spin.from_pole, {"convention": "L", "angular_velocity": (0, 0, 1)}),
        (Spin.from_angles, {"convention": "L", "angles": (0, 0, 0), "angular_velocity": (0, 0, 1)}),
    ],
)
def test_what_is_no_body_is_a_sentence(make, given):
    usual = {"pole": (1.0, 0.2), "phi0": 0.1} if make != Spin.from_angles else {}
    with pytest.raises(AttitudeError, match=r"body is \(0.6, 0.9, 1\); give a Body"):
        make((0.6, 0.9, 1), **{"epoch": "2026-01-01", **usual, **given})


def test_the_greatest_possible_period_is_the_limit():
    for mode in ("LAM", "SAM"):
        for convention in "LS":
            longest = longest_P_phi(APOPHIS.moments, mode, convention, 1000.0)
            branch = "acute" if (mode == "LAM") == (convention == "S") else None
            given = {
                **SET, "mode": mode, "convention": convention, "P_psi": 1000.0,
                "psi0": math.pi / 2 if mode == "LAM" else 0.0, "theta_branch": branch,
            }  # fmt: skip
            motion_of(APOPHIS, **{**given, "P_phi": longest * (1 - 1e-9)})
            motion_of(APOPHIS, **{**given, "P_phi": longest})
            with pytest.raises(AttitudeError, match="at the most"):
                motion_of(APOPHIS, **{**given, "P_phi": longest * (1 + 1e-9)})


def test_ratios_are_checked():
    with pytest.raises(AttitudeError, match="A <= B <= C"):
        moments_from_ratios(0.9, 0.7)
    with pytest.raises(AttitudeError, match=r"at least 0\.4"):
        moments_from_ratios(0.3, 0.6)
    with pytest.raises(AttitudeError, match="A <= B <= C"):
        moments_from_ratios(0.9, 1.2)


def test_the_spread_of_uncertain_ratios():
    given = {"mode": "SAM", "convention": "S", "P_psi": "263 h", "P_phi": "27.38 h"}
    sure = spread(A_over_C=0.61, B_over_C=0.965, **given)
    motion = motion_of(APOPHIS, **SET)
    assert sure["energy_ratio"].value == pytest.approx(motion.regime.energy_ratio, rel=1e-14)
    assert sure["energy_ratio"][1:] == (0.0, 0.0)
    assert sure["theta_greatest"].value == pytest.approx(motion.regime.nutation_S[1], rel=1e-13)
    # one uncertain number: the ends are those of the states at its ends
    one = spread(A_over_C=(0.61, -0.02, 0.03), B_over_C=0.965, **given)["energy_ratio"]
    ends = [spread(A_over_C=a, B_over_C=0.965, **given)["energy_ratio"].value for a in (0.59, 0.64)]
    assert one.minus == pytest.approx(one.value - min(ends), rel=1e-9)
    assert one.plus == pytest.approx(max(ends) - one.value, rel=1e-9)
    # two add in quadrature; the published 1.024 +- 0.013 lies inside
    both = spread(A_over_C=(0.61, -0.08, 0.11), B_over_C=(0.965, -0.015, 0.009), **given)
    other = spread(A_over_C=0.61, B_over_C=(0.965, -0.015, 0.009), **given)["energy_ratio"]
    first = spread(A_over_C=(0.61, -0.08, 0.11), B_over_C=0.965, **given)["energy_ratio"]
    assert both["energy_ratio"].plus == pytest.approx(math.hypot(first.plus, other.plus), rel=1e-9)
    assert both["energy_ratio"].minus > 0.013 - 0.0005 and both["energy_ratio"].plus > 0.012
    # an error beyond what a body allows ends where bodies end
    wide = spread(A_over_C=(0.61, 0.6), B_over_C=0.965, **given)
    assert math.isfinite(wide["energy_ratio"].minus)
    with pytest.raises(AttitudeError, match="at the most"):
        spread(A_over_C=0.61, B_over_C=0.965, **{**given, "P_phi": "60 h"})
    with pytest.raises(AttitudeError, match=r"\(value, error\)"):
        spread(A_over_C=(0.61, 1, 2, 3), B_over_C=0.965, **given)


def test_a_body_at_rest_has_nothing_to_publish():
    still = FreeRotation(APOPHIS, Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0)))
    with pytest.raises(AttitudeError, match="at rest"):
        still.published("S")


def test_the_table_in_words():
    text = str(motion_of(APOPHIS, **SET).published("S"))
    assert "P_psi 10.9583333 d, P_phi 27.38 h" in text and "pole 250.000000 -75.000000" in text
    short = motion_of(APOPHIS, **{**SET, "P_psi": "263 ms", "P_phi": "27.38 ms"}).published("S")
    assert "P_psi 0.263 s, P_phi 0.02738 s\n" in str(short)
