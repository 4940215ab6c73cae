"""Two-body motion: Kepler's equation against 40 digits on every conic, lines of the MPC."""

import itertools
import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attitude import paths
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError

START = instant("2026-01-01 TDB")
AU = 149597870700.0
CERES = (
    "00001    3.35  0.15 K2555 188.70269   73.27343   80.25221   10.58780  0.0794013  0.21424651"
    "   2.7660512  0 E2024-V47  7330 125 1801-2024 0.80 M-v 30k MPCORBFIT  4000      (1) Ceres    "
    "          20241101"
)
COMET = (
    "    CK23A030  2024 09 27.7405  0.391423  1.000093  308.4925   21.5596  139.1109  20240702"
    "   4.8  3.2  C/2023 A3 (Tsuchinshan-ATLAS)                            MPC 172338"
)


def flat(**elements):
    given = {"inclination": 0.0, "node": 0.0, "pericenter_argument": 0.0, "epoch": START}
    return paths.kepler(**{**given, "frame": "icrf", **elements})


def exact(q, e, gm, t):
    """Perifocal x, y in 40 digits."""
    q, e, gm, t = (mpmath.mpf(each) for each in (q, e, gm, t))
    if e == 1:
        w = 3 * mpmath.sqrt(gm / (2 * q**3)) * abs(t) / 2
        y = mpmath.cbrt(w + mpmath.sqrt(w * w + 1))
        tangent = mpmath.sign(t) * (y - 1 / y)
        return q * (1 - tangent**2), 2 * q * tangent
    a = q / abs(1 - e)
    m = mpmath.sqrt(gm / a**3) * t
    if e < 1:
        m -= 2 * mpmath.pi * mpmath.nint(m / (2 * mpmath.pi))
        low, high = mpmath.mpf(0), mpmath.pi
        for _ in range(140):  # bisection: certain, and 140 bits
            middle = (low + high) / 2
            if middle - e * mpmath.sin(middle) > abs(m):
                high = middle
            else:
                low = middle
        anomaly = mpmath.sign(m) * low
        c, s = mpmath.cos(anomaly), mpmath.sin(anomaly)
        return a * (c - e), a * mpmath.sqrt(1 - e * e) * s
    low, high = mpmath.mpf(0), mpmath.asinh(abs(m) / e) + mpmath.cbrt(6 * abs(m)) + 1
    for _ in range(150):
        middle = (low + high) / 2
        if e * mpmath.sinh(middle) - middle > abs(m):
            high = middle
        else:
            low = middle
    anomaly = mpmath.sign(m) * low
    return a * (e - mpmath.cosh(anomaly)), a * mpmath.sqrt(e * e - 1) * mpmath.sinh(anomaly)


@pytest.mark.parametrize(
    "e", [0.0, 1e-9, 0.1, 0.7, 0.97, 1 - 1e-6, 1 - 1e-12, 1.0, 1 + 1e-12, 1 + 1e-6, 1.03, 2.0, 50.0]
)
def test_every_conic_agrees_with_40_digits(e):
    path = flat(pericenter_distance=1e11, eccentricity=e)
    random = np.random.default_rng(3)
    t = 10.0 ** random.uniform(-3, 8.5, 25) * random.choice([-1.0, 1.0], 25)
    ours = path.position(START, t)
    with mpmath.workdps(40):
        for k, second in enumerate(t):
            x, y = exact(1e11, e, path.gm, second)
            size = math.hypot(float(x), float(y))
            away = math.hypot(float(ours[k, 0] - x), float(ours[k, 1] - y))
            # 1e-14: of up to 60 revolutions in 3e8 s, whose period is rounded once.
            assert away < 1e-14 * size
    assert not ours[:, 2].any()


@given(st.floats(0.0, 3.0), st.floats(-3e8, 3e8))
@settings(max_examples=200)
def test_energy_and_momentum_hold_and_velocity_is_the_derivative(e, t):
    path = flat(pericenter_distance=1e11, eccentricity=e)
    position, velocity = path.state(START, t)
    r = np.linalg.norm(position)
    energy = 0.5 * velocity @ velocity - path.gm / r
    assert energy == pytest.approx(-path.gm * (1.0 - e) / 2e11, abs=4e-15 * 3 * path.gm / 1e11)
    momentum = np.cross(position, velocity)[2]
    assert momentum == pytest.approx(math.sqrt(path.gm * 1e11 * (1.0 + e)), rel=1e-13)


@given(st.floats(0.0, 2.0), st.floats(0.0, 1e8))
def test_motion_is_the_same_in_both_directions_of_time(e, t):
    path = flat(pericenter_distance=1e11, eccentricity=e)
    assert np.array_equal(path.position(START, t), path.position(START, -t) * [1, -1, 1])


def test_the_eccentricity_is_walked_across_the_parabola_without_a_step():
    around = [np.nextafter(1.0, 0.0), 1.0, np.nextafter(1.0, 2.0)]
    t = np.linspace(-1e9, 1e9, 101)
    found = [flat(pericenter_distance=1e11, eccentricity=e).position(START, t) for e in around]
    for one, other in itertools.pairwise(found):
        distance = np.linalg.norm(one, axis=-1)
        assert (np.linalg.norm(one - other, axis=-1) < 4e-15 * distance).all()


def test_angles_turn_the_orbit_as_textbooks_have_it():
    path = flat(
        semi_major_axis=AU, eccentricity=0.0, inclination="90 deg", node="90 deg",
        pericenter_argument="0 deg", mean_anomaly="0 deg",
    )  # fmt: skip
    assert path.position(START, 0.0) / AU == pytest.approx([0, 1, 0], abs=1e-15)  # at the node
    assert path.position(START, path.period / 4) / AU == pytest.approx([0, 0, 1], abs=1e-15)
    assert path.period / 86400.0 == pytest.approx(365.2568983, abs=1e-6)  # Gauss's year


def test_a_mean_anomaly_counts_from_the_pericentre():
    for e, axis in ((0.3, 1e11), (1.7, -1e11)):
        at_rest = flat(semi_major_axis=axis, eccentricity=e)
        later = flat(semi_major_axis=axis, eccentricity=e, mean_anomaly=0.4)
        seconds = 0.4 * abs(axis) * math.sqrt(abs(axis) / later.gm)
        away = later.position(START, 0.0) - at_rest.position(START, seconds)
        assert np.abs(away).max() < 1e-3


@pytest.mark.parametrize(
    "change, message",
    [
        ({"eccentricity": -0.1}, "zero or greater"),
        ({"eccentricity": np.nan}, "finite"),
        ({"semi_major_axis": None}, "give one of"),
        ({"pericenter_distance": 1e11}, "give one of"),
        ({"semi_major_axis": -1e11}, "no orbit"),
        ({"eccentricity": 1.5}, "no orbit"),
        ({"eccentricity": 1.0}, "parabola"),
        ({"gm": 0.0}, "greater than zero"),
        ({"center": "ssb"}, "GM of ssb is not known"),
        ({"inclination": "3 km"}, "inclination is in km"),
    ],
)
def test_elements_that_are_no_orbit_are_refused(change, message):
    given = {"semi_major_axis": 1e11, "eccentricity": 0.1}
    with pytest.raises(AttitudeError, match=message):
        flat(**{**given, **change})
    with pytest.raises(AttitudeError, match="no mean anomaly"):
        flat(pericenter_distance=1e11, eccentricity=1.0, mean_anomaly=0.0)


def kepler_of_skyfield(path, elements):
    from skyfield.data.spice import inertial_frames
    from skyfield.keplerlib import _KeplerOrbit  # its mpc module needs pandas

    from attitude.frames._earth import timescale

    ts = timescale()
    orbit = elements(_KeplerOrbit, ts, path.gm * 1e-9)
    orbit._rotation = inertial_frames["ECLIPJ2000"].T
    return paths.from_skyfield(orbit)


def test_an_mpc_line_of_a_minor_planet_moves_as_in_skyfield():
    path = paths.mpc_orbit(CERES)
    assert (path.name, path.center) == ("(1) Ceres", "sun")

    def elements(kind, ts, gm):
        p = 2.7660512 * (1.0 - 0.0794013**2)
        angles = 10.58780, 80.25221, 73.27343, 188.70269
        return kind._from_mean_anomaly(p, 0.0794013, *angles, ts.tt(2025, 5, 5), gm, 10, "Ceres")

    t = np.linspace(-1e8, 1e8, 21)
    theirs = kepler_of_skyfield(path, elements).position(START, t)
    # skyfield counts elapsed time in TT instead of TDB: up to 3 ms of 20 km/s.
    assert np.abs(path.position(START, t) - theirs).max() < 80.0


def test_an_mpc_line_of_a_comet_is_at_its_perihelion_when_it_says():
    path = paths.mpc_orbit(COMET)
    assert path.name.startswith("C/2023 A3") and path.period == math.inf
    at = instant("2024-09-27T17:46:19.2 TT")
    distance = np.linalg.norm(path.position(at, np.array([-3600.0, 0.0, 3600.0])), axis=-1)
    assert distance[1] / AU == pytest.approx(0.391423, abs=1e-12)
    assert distance[0] == pytest.approx(distance[2], rel=1e-9)
    assert distance[0] > distance[1]


@pytest.mark.parametrize(
    "line, message",
    [
        ("", "neither of MPCORB.DAT"),
        (None, "give one line of text"),
        (CERES.replace("0.0794013", "0.07x4013"), "'0.07x4013' for the eccentricity in columns 71"),
        (CERES.replace("K2555", "K25E5"), "neither of MPCORB.DAT"),
        (COMET.replace("0.391423", "0.39  23"), "perihelion distance in columns 31-39"),
        (CERES[:90], "for the semi-major axis"),
    ],
)
def test_lines_that_cannot_be_read_are_refused(line, message):
    with pytest.raises(AttitudeError, match=message):
        paths.mpc_orbit(line)
