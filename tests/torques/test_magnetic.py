"""Torques of magnetic fields and thin air, against formulas and integrations written out here."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs, paths
from attitude._textfiles.lines import packaged
from attitude.frames import quaternion
from attitude.shape import box
from attitude.splitting import TorquedRotation
from attitude.torques import (
    IGRF,
    AerodynamicTorque,
    DipoleField,
    EddyCurrent,
    MagneticDipole,
    MagneticField,
    _magnetic,
)
from tests.support.torqued import angle, cross, dop853, torque_at_start, turns_by_rates

TENSOR = np.array([[20.0, 1.0, 0.5], [1.0, 24.0, 2.0], [0.5, 2.0, 30.0]])
BODY = Body(tensor=TENSOR)
SPIN = Spin(epoch="2024-03-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.2, -0.3))
CURRENTS = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, -0.2], [0.0, -0.2, 3.0]]) * 1e6
EARTH = DipoleField((1e22, -2e22, -7.5e22))
# A circular orbit: radius in m, inclination.
AXIS = 7.1e6
NORMAL = np.radians(98.0)
RATE = np.sqrt(3.986004418e14 / AXIS**3)


def orbit(seconds):
    u = RATE * np.asarray(seconds)
    tilted = np.sin(u) * np.cos(NORMAL), np.sin(u) * np.sin(NORMAL)
    return AXIS * np.stack([np.cos(u), *tilted], axis=-1)


def dipole(r, moment=EARTH.moment):
    """-grad of mu0/4pi m.r/r^3."""
    size = np.sqrt(r @ r)
    return 1.00000000055e-7 * (3.0 * r * (r @ moment) / size**5 - moment / size**3)


def dipole_rate(t, h=0.1):
    """By differences of fourth order."""
    f = [dipole(orbit(t + k * h)) for k in (-2, -1, 1, 2)]
    return (8.0 * (f[2] - f[1]) - (f[3] - f[0])) / (12.0 * h)


# ---- Fields


@pytest.mark.parametrize(
    ("r", "colatitude", "longitude", "year", "expected"),
    [
        # radial, southward and eastward components in nT by ppigrf 2.1.0, IGRF-14
        (6771.2e3, 30.0, 40.0, 2020.0, (-43357.565, -12013.720, 2532.151)),
        (7200.0e3, 98.0, -120.0, 2025.0, (1685.473, -20066.235, 3427.034)),
        (6371.2e3, 150.0, 10.0, 1990.0, (28674.972, -14788.746, -6838.061)),
        (42164.0e3, 90.0, 75.0, 2005.0, (30.569, -103.831, -9.802)),
    ],
)
def test_igrf_by_another_program(r, colatitude, longitude, year, expected):
    t, p = np.radians(colatitude), np.radians(longitude)
    up = np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    south = np.array([np.cos(t) * np.cos(p), np.cos(t) * np.sin(p), -np.sin(t)])
    east = np.array([-np.sin(p), np.cos(p), 0.0])
    years, table = _magnetic._coefficients()
    coefficients = table[np.flatnonzero(years == year)]
    found = _magnetic._gradient((r * up)[None], coefficients, 13)[0]
    by_axis = [found @ axis * 1e9 for axis in (up, south, east)]
    np.testing.assert_allclose(by_axis, expected, atol=2e-3)  # its printed digits


def test_igrf_turns_with_the_earth():
    """Over one sidereal day the field at a fixed place of ICRF returns, half way it does not."""
    instant = epochs.instant("2024-03-01")
    place = np.broadcast_to((7e6, 1e6, 2e6), (3, 3))
    seconds = np.array([0.0, 43082.05, 86164.0905])
    field = IGRF().at(instant, seconds, np.zeros(3), place)
    size = np.linalg.norm(field[0])
    assert np.linalg.norm(field[2] - field[0]) < 1e-4 * size
    assert np.linalg.norm(field[1] - field[0]) > 1e-2 * size
    tilted = IGRF(1).at(instant, seconds, np.zeros(3), place)
    assert np.linalg.norm(tilted[0] - field[0]) > 0.01 * size


def test_fields_along_a_path_are_fitted():
    """Values and rates of the pieces against the field itself and its differences."""
    instant, seconds = epochs.instant("2024-03-01"), np.linspace(-3000.0, 9000.0, 97)
    low = np.zeros(97)
    on_path = EddyCurrent(1.0, IGRF(), orbit)._on_path
    fitted, direct = on_path.at(instant, seconds, low), on_path._differenced(instant, seconds, low)
    scale = np.abs(direct).max(axis=0)
    scale = np.repeat([scale[:3].max(), scale[3:].max()], 3)
    assert np.all(np.abs(fitted - direct)[:, :3] < 1e-12 * scale[:3])
    # differences with half a second err by 1e-11
    assert np.all(np.abs(fitted - direct)[:, 3:] < 1e-10 * scale[3:])


@pytest.mark.parametrize("start", [0.0, np.pi])
def test_fields_along_an_eccentric_orbit(start):
    """From the apocenter, where the path turns 30 times more slowly, or the pericenter."""
    transfer = paths.kepler(
        epoch="2024-03-01",
        center="earth",
        semi_major_axis=2.4371e7,
        eccentricity=0.73,
        inclination=0.5,
        node=0.3,
        pericenter_argument=0.4,
        mean_anomaly=start,
    )
    instant, seconds, low = epochs.instant("2024-03-01"), np.linspace(0, 4e4, 401), np.zeros(401)
    on_path = EddyCurrent(1.0, IGRF(), transfer)._on_path
    fitted, direct = on_path.at(instant, seconds, low), on_path._differenced(instant, seconds, low)
    for part, tolerance in ((slice(0, 3), 1e-12), (slice(3, 6), 2e-9)):  # of the differences
        size = np.linalg.norm(direct[:, part], axis=1)
        error = np.linalg.norm(fitted[:, part] - direct[:, part], axis=1)
        assert np.max(error / size) < tolerance


def test_threads_that_forget_pieces_leave_those_of_others(monkeypatch):
    """While one thread computes, another one reaches the bound of what is kept."""
    instant, low = epochs.instant("2024-03-01"), np.zeros(97)
    seconds = np.linspace(0.0, 6000.0, 97)
    field = EddyCurrent(1.0, IGRF(), orbit)._on_path
    expected = field.at(instant, seconds + 3000.0, low)

    class Interrupted(_magnetic.FieldOnPath):
        def direct(self, *epoch):
            if not others:
                others.append(np.linspace(-1e5, -9e4, 97))
                on_path.at(instant, others[0], low)
            return super().direct(*epoch)

    others = [None]  # epochs of the other thread
    on_path = Interrupted(IGRF(), field._path)
    on_path.at(instant, seconds, low)
    for _, pieces in on_path._pieces.values():
        monkeypatch.setattr(pieces, "most", 110)
    others.clear()
    assert np.array_equal(on_path.at(instant, seconds + 3000.0, low), expected)
    assert others


def test_a_field_with_a_kink_is_not_fitted_there():
    class Kinked(MagneticField):
        is_smooth = True

        def at(self, instant, seconds, low, position):
            return 1e-5 + 1e-8 * np.abs(seconds[:, None] - 61.0) * np.ones(3)

    on_path = EddyCurrent(1.0, Kinked(), orbit)._on_path
    seconds = np.linspace(0.0, 400.0, 41)
    found = on_path.at(epochs.instant("2024-03-01"), seconds, np.zeros(41))
    np.testing.assert_allclose(found[:, 0], 1e-5 + 1e-8 * np.abs(seconds - 61.0), rtol=1e-11)


def field_by_potential(seconds, r, instant):
    """-grad of the potential of IGRF-14 by Legendre functions of scipy, over astropy's axes."""
    from astropy.coordinates import GCRS, ITRS, CartesianRepresentation
    from astropy.time import Time
    from scipy.special import factorial, lpmv

    lines = [
        line.split()
        for line in packaged("reference/igrf14.txt").splitlines()
        if not line.startswith("#")
    ]
    years = np.array(lines[0], dtype=float)
    time = Time(2451545.0, instant.seconds / 86400.0, format="jd", scale="tdb")
    time = Time(time.jd1, time.jd2 + seconds / 86400.0, format="jd", scale="tdb")
    itrs = GCRS(CartesianRepresentation(r, unit="m"), obstime=time).transform_to(ITRS(obstime=time))
    turn = (
        np.array(
            [
                GCRS(CartesianRepresentation(e, unit="m"), obstime=time)
                .transform_to(ITRS(obstime=time))
                .cartesian.xyz.to_value("m")
                for e in np.eye(3) * 1e7
            ]
        ).T
        / 1e7
    )

    def potential(place):
        size = np.linalg.norm(place)
        longitude, total = np.arctan2(place[1], place[0]), 0.0
        for n, m, *numbers in lines[1:]:
            degree, order = int(n), abs(int(m))
            number = np.interp(time.jyear + 0.5 / 365.25, years, np.array(numbers, dtype=float))
            norm = np.sqrt(
                (2.0 if order else 1.0) * factorial(degree - order) / factorial(degree + order)
            )
            legendre = (-1.0) ** order * lpmv(order, degree, place[2] / size)
            wave = np.sin if int(m) < 0 else np.cos
            total += (
                6371200.0 * (6371200.0 / size) ** (degree + 1)
                * number * norm * legendre * wave(order * longitude)
            )  # fmt: skip
        return total * 1e-9

    place, h = itrs.cartesian.xyz.to_value("m"), 2e3
    slopes = []
    for axis in np.eye(3):
        one, two, three, four = (potential(place + k * h * axis) for k in (-2, -1, 1, 2))
        slopes.append((8.0 * (three - two) - (four - one)) / (12.0 * h))
    return -turn.T @ np.array(slopes)


@pytest.mark.parametrize("seconds", [0.0, 2000.0, 40000.0])
def test_igrf_by_its_potential_over_astropys_axes(seconds):
    from astropy.utils import iers

    instant = epochs.instant("2024-03-01")
    with iers.conf.set_temp("auto_download", False):  # astropy 6.1 asks the network first
        wanted = field_by_potential(seconds, orbit(seconds), instant)
    found = IGRF().at(instant, np.array([seconds]), np.zeros(1), orbit(seconds)[None])[0]
    # differences of the potential, and astropy's GCRS to ITRS of places at rest
    np.testing.assert_allclose(found, wanted, rtol=0, atol=3e-9 * np.linalg.norm(wanted))


def test_igrf_of_one_epoch():
    place, zero = np.array([[7e6, 1e6, 2e6]]), np.zeros(1)
    spring = epochs.instant("2024-03-01")
    one, two = (model.at(spring, zero, zero, place) for model in (IGRF(), IGRF(epoch="2024-03-01")))
    np.testing.assert_array_equal(one, two)
    late = IGRF(epoch="2025-01-01").at(epochs.instant("2060-03-01"), zero, zero, place)
    assert 0.5 < np.linalg.norm(late) / np.linalg.norm(one) < 2.0
    with pytest.raises(AttitudeError, match="IGRF covers 1955 to 2030"):
        IGRF(epoch="2040-01-01")


# ---- Torques at an epoch


def eddy(wxyz, omega, field, rate):
    turn = quaternion.matrix(wxyz).T
    b = turn @ field
    return cross(CURRENTS @ (cross(omega, b) - turn @ rate), b)


def test_eddy_currents_by_their_formula():
    found = torque_at_start(EddyCurrent(CURRENTS, EARTH, orbit), body=BODY, spin=SPIN)
    wanted = eddy(SPIN.wxyz, SPIN.angular_velocity, dipole(orbit(0.0)), dipole_rate(0.0))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
    without = eddy(SPIN.wxyz, SPIN.angular_velocity, dipole(orbit(0.0)), np.zeros(3))
    assert np.abs(found - without).max() > 1e-3 * np.abs(wanted).max()


def test_a_function_as_field_and_a_number_as_tensor():
    function = EddyCurrent(5.0, lambda seconds, r: np.array([dipole(x) for x in r]), orbit)
    model = EddyCurrent(np.eye(3) * 5.0, EARTH, orbit)
    one, two = (torque_at_start(torque, body=BODY, spin=SPIN) for torque in (function, model))
    np.testing.assert_allclose(one, two, rtol=1e-9)


def test_dipole_by_its_formula():
    moment = np.array([0.3, -2.0, 1.0])
    found = torque_at_start(MagneticDipole(moment, EARTH, orbit), body=BODY, spin=SPIN)
    wanted = np.cross(moment, quaternion.matrix(SPIN.wxyz).T @ dipole(orbit(0.0)))
    # the torque is what a difference of larger terms leaves: 1e-16 of these
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-15)


def test_a_dipole_of_no_moment_has_no_torque():
    torque = EddyCurrent(1e6, DipoleField((0, 0, 0)), orbit)
    free, motion = FreeRotation(BODY, SPIN), TorquedRotation(BODY, SPIN, torque, step=1.0)
    assert angle(motion.at(50.0).wxyz, free.at(50.0).wxyz) < 1e-12


def test_air_by_a_sum_over_facets():
    shape = box((1.0, 2.0, 0.5))
    body = Body(moments=(20.0, 24.0, 30.0), center_of_mass=(0.1, 0.05, -0.2))

    def air(height):
        return 1e-11 * np.exp(-(height - 7e5) / 6e4)

    torque = AerodynamicTorque(shape, orbit, air, 0.1)
    found = torque_at_start(torque, body=body, spin=SPIN)
    r, v = orbit(0.0), (orbit(1e-3) - orbit(-1e-3)) / 2e-3
    # within 0.2 deg of the axis of ICRF in 2024
    flow = quaternion.matrix(SPIN.wxyz).T @ (np.cross((0.0, 0.0, 7.292115e-5), r) - v)
    speed = np.sqrt(flow @ flow)
    density = air(np.sqrt(r @ r) - 6378137.0)
    wanted = np.zeros(3)
    for area, normal, place in zip(shape.areas, shape.normals, shape.centroids, strict=True):
        cosine = -normal @ flow / speed
        if cosine > 0.0:
            along = 0.9 * flow / speed - 2.0 * 0.1 * cosine * normal
            force = density * speed**2 * area * cosine * along
            wanted += np.cross(place - body.center_of_mass, force)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-4 * np.abs(wanted).max())


def test_no_air_no_torque():
    torque = AerodynamicTorque(box((1.0, 2.0, 0.5)), orbit, lambda height: 0.0 * height)
    body = Body(moments=(20.0, 24.0, 30.0), center_of_mass=(0.1, 0.05, -0.2))
    wxyz = TorquedRotation(body, SPIN, torque, step=1.0).at(100.0).wxyz
    np.testing.assert_allclose(wxyz, FreeRotation(body, SPIN).at(100.0).wxyz, atol=1e-13)


# ---- Motions


def test_eddy_currents_against_dop853():
    torque = EddyCurrent(CURRENTS, EARTH, orbit)
    motion = TorquedRotation(BODY, SPIN, torque, step=0.25, scheme="suzuki")

    def formula(t, wxyz, omega):
        return eddy(wxyz, omega, dipole(orbit(t)), dipole_rate(t))

    wxyz, omega = dop853(formula, BODY, SPIN, 600.0)
    history = motion.at(600.0)
    # the scheme is of fourth order: 2.6e-8 with steps twice as long
    assert angle(history.wxyz, wxyz) < 4e-9
    assert np.abs(history.angular_velocity - omega).max() < 1e-9


def test_a_dipole_against_dop853_by_a_scheme_with_slopes():
    moment = np.array([30.0, -200.0, 100.0])

    def torque(t, wxyz, omega):
        return cross(moment, quaternion.matrix(wxyz).T @ dipole(orbit(t)))

    motion = TorquedRotation(
        BODY, SPIN, MagneticDipole(moment, EARTH, orbit), step=0.2, scheme="force-gradient"
    )
    wxyz, _ = dop853(torque, BODY, SPIN, 300.0)
    assert angle(motion.at(300.0).wxyz, wxyz) < 1e-9


def test_currents_brake_and_turn_the_momentum():
    """In a field that neither turns nor changes energy falls, and w along B stays."""
    field = np.array([0.0, 0.0, 3e-5])
    still = EddyCurrent(1e9, lambda seconds, r: np.broadcast_to(field, r.shape), orbit)
    body = Body(moments=(20.0, 20.0, 20.0))
    spin = Spin("2024-03-01", (1, 0, 0, 0), (0.1, 0.0, 0.2))
    motion = TorquedRotation(body, spin, still, step=0.5)
    history = motion.at([0.0, 20.0, 40.0])
    inertial = history.angular_velocity_inertial
    np.testing.assert_allclose(inertial[:, 2], 0.2, rtol=1e-9)
    # dw_x/dt = -k B^2 w_x / I
    decay = np.exp(-1e9 * 9e-10 / 20.0 * np.array([0.0, 20.0, 40.0]))
    np.testing.assert_allclose(np.hypot(*inertial[:, :2].T), 0.1 * decay, rtol=2e-4)


def test_air_against_dop853():
    shape, density = box((1.0, 2.0, 0.5)), 1e-9
    body = Body(tensor=TENSOR, center_of_mass=(0.1, 0.05, -0.2))
    facets = shape.areas, shape.normals, shape.centroids - body.center_of_mass

    def torque(t, wxyz, omega):
        r, v = orbit(t), (orbit(t + 0.05) - orbit(t - 0.05)) / 0.1
        # third row of ERFA's pnm06a of that date
        pole = np.array([0.00233917, 3.80955e-5, 0.999997263])
        flow = quaternion.matrix(wxyz).T @ (cross(7.292115e-5 * pole, r) - v)
        areas, normals, arms = facets
        push = density * areas * np.maximum(-normals @ flow, 0.0)
        return np.sum(np.cross(arms, push[:, None] * flow), axis=0)

    motion = TorquedRotation(
        body, SPIN, AerodynamicTorque(shape, orbit, density), tolerance=1e-9, span=(0, 100)
    )
    wxyz, _ = dop853(torque, BODY, SPIN, 100.0)
    history = motion.at(100.0)
    turn = angle(history.wxyz, wxyz)
    by_air = angle(history.wxyz, FreeRotation(body, SPIN).at(100.0).wxyz)
    assert turn < 2e-7 * by_air < 1.0  # 4e-8 of the speed, by the torque's differences of 0.5 s


@pytest.mark.parametrize("kind", ["eddy", "dipole", "air"])
def test_derivatives_and_covariance(kind):
    body = Body(tensor=TENSOR, center_of_mass=(0.1, 0.05, -0.2))
    torque = {
        "eddy": EddyCurrent(CURRENTS * 100.0, IGRF(3), orbit),
        "dipole": MagneticDipole((3e3, -2e4, 1e4), IGRF(3), orbit),
        "air": AerodynamicTorque(box((1.0, 2.0, 0.5)), orbit, 1e-9),
    }[kind]
    spin = SPIN.with_covariance({"attitude": 1e-3, "angular_velocity": 1e-5})
    motion = TorquedRotation(body, spin, torque, step=0.1)
    t = 5.0
    attitude = motion.sensitivity_at(t)
    expected = turns_by_rates(
        lambda other: TorquedRotation(body, other, torque, step=0.1), SPIN, t, 1e-4
    )
    scale = np.abs(attitude).max()
    np.testing.assert_allclose(attitude[:, 3:6], expected, atol=1e-6 * scale)
    assert np.all(np.linalg.eigvalsh(motion.at(t).covariance) > -1e-12)


# ---- Refusals


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: EddyCurrent([[1, 1, 0], [0, 1, 0], [0, 0, 1]], EARTH, orbit), "not symmetric"),
        (lambda: EddyCurrent(-1.0, EARTH, orbit), "negative eigenvalue"),
        (lambda: EddyCurrent(1.0, "igrf", orbit), r"give IGRF\(\), DipoleField"),
        (lambda: EddyCurrent(1.0, IGRF, orbit), "field"),
        (lambda: IGRF(14), "degree is 14; the model has the degrees 1 to 13"),
        (lambda: MagneticDipole((1, 2), EARTH, orbit), "moment"),
        (lambda: AerodynamicTorque(box((1, 1, 1)), orbit, -1.0), "density"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        make()


def test_what_motions_refuse():
    relative = Body(moments=(1.0, 2.0, 2.5), relative=True)
    with pytest.raises(AttitudeError, match="moments of the body are relative"):
        TorquedRotation(relative, SPIN, EddyCurrent(1.0, EARTH, orbit), step=1.0).at(1.0)
    late = Spin("2035-01-01", (1, 0, 0, 0), (0, 0, 0.1))
    with pytest.raises(AttitudeError, match="IGRF covers 1955 to 2030"):
        TorquedRotation(BODY, late, EddyCurrent(1.0, IGRF(), orbit), step=1.0).at(1.0)
    bad = EddyCurrent(1.0, lambda seconds, r: r[:, :2], orbit)
    with pytest.raises(AttitudeError, match=r"field returned .* it must return"):
        TorquedRotation(BODY, SPIN, bad, step=1.0).at(1.0)


def test_a_field_of_ones_own():
    class Uniform(MagneticField):
        def at(self, instant, seconds, low, position):
            return np.broadcast_to((1e-5, 0.0, 0.0), position.shape)

    wanted = np.cross((0, 0, 1.0), quaternion.matrix(SPIN.wxyz).T @ (1e-5, 0, 0))
    found = torque_at_start(MagneticDipole((0, 0, 1.0), Uniform(), orbit), body=BODY, spin=SPIN)
    np.testing.assert_allclose(found, wanted, atol=1e-15)
