"""Torque models against formulas written out here, potentials, and laws of mechanics."""

import ctypes

import numba
import numpy as np
import pytest
from astropy import units
from mpmath import mp, mpf

from attitude import AttitudeError, Body, FreeRotation, Mode, Spin, paths
from attitude._compilation.pointers import C_FUNCTION
from attitude._solver.march import kicks
from attitude.frames import quaternion
from attitude.shape import Mesh
from attitude.torques import (
    ConstantTorque,
    CustomTorque,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    SolarRadiation,
)
from attitude.torques._torqued import TorquedRotation
from tests.support.torqued import cross, torque_at_start

TENSOR = np.array([[20.0, 1.0, 0.5], [1.0, 24.0, 2.0], [0.5, 2.0, 30.0]])
BODY = Body(tensor=TENSOR)
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.2, -0.3))
MU = 3.986004418e14
PLACE = np.array([4e6, -5e6, 3e6])


def still(seconds):
    return np.broadcast_to(PLACE, (*np.shape(seconds), 3))


def gravity_gradient(wxyz):
    r = np.sqrt(PLACE @ PLACE)
    u = quaternion.matrix(wxyz).T @ PLACE / r
    return 3.0 * MU / r**3 * cross(u, TENSOR @ u)


def test_gravity_gradient_by_its_formula():
    found = torque_at_start(GravityGradient(still, MU), body=BODY, spin=SPIN)
    expected = gravity_gradient(SPIN.wxyz)
    assert np.max(np.abs(found - expected)) < 1e-13 * np.max(np.abs(expected)) + 1e-15
    named = torque_at_start(GravityGradient(still, "earth"), body=BODY, spin=SPIN)
    # MU is EGM96's, DE440's is 1.6e-8 less
    assert np.allclose(named, expected, rtol=1e-7, atol=0.0)
    assert not np.allclose(named, expected, rtol=1e-9, atol=0.0)


def turned(wxyz, axis, angle):
    return quaternion.multiply(wxyz, np.append(np.cos(angle / 2), np.sin(angle / 2) * axis))


def test_torque_is_the_slope_of_its_potential():
    model = GravityGradient(still, MU)
    found, h = gravity_gradient(SPIN.wxyz), 1e-4
    for k, axis in enumerate(np.eye(3)):
        sides = []
        for angle in (-h, h):
            spin = Spin(
                epoch="2026-01-01",
                wxyz=turned(SPIN.wxyz, axis, angle),
                angular_velocity=(0, 0, 0.1),
            )
            sides.append(model.potential(BODY, FreeRotation(BODY, spin).at(0.0)))
        slope = -(sides[1] - sides[0]) / (2.0 * h)
        # truncation h^2, and 1e-16 of the potential over h
        assert slope == pytest.approx(found[k], rel=1e-6, abs=1e-10 * np.max(np.abs(found)))


def called(compiled, wxyz, y, place, parameters):
    """What a compiled torque or slope answers."""
    out = np.zeros(3)
    given = [np.array(each, dtype=float) for each in (wxyz, y, place, parameters)]
    pointer = ctypes.POINTER(ctypes.c_double)
    C_FUNCTION(compiled.address)(0.0, *(each.ctypes.data_as(pointer) for each in (*given, out)))
    return out


def test_masses_by_name_are_those_of_orbits():
    for name in ("pluto", "saturn barycenter", "499", "301"):
        elements = dict.fromkeys(("eccentricity", "inclination", "node", "pericenter_argument"), 0)
        orbit = paths.kepler(center=name, semi_major_axis=1e9, epoch="2024-03-01", **elements)
        assert GravityGradient(orbit, name).mu == orbit.gm
    alone, system = (
        GravityGradient(lambda t: t, f"pluto{more}").mu for more in ("", " barycenter")
    )
    assert alone == pytest.approx(8.696e11, rel=1e-4) and system == 9.755e11


def test_slope_of_gravity_gradient_times_a_held_vector():
    """N . y differentiated along turns about each axis."""
    from attitude.torques._compiled import gravity_gradient_slope

    y, h = np.array([0.3, -0.2, 0.5]), 1e-4
    parameters = GravityGradient(still, MU).parameters(BODY)
    found = called(gravity_gradient_slope, SPIN.wxyz, y, PLACE, parameters)
    slopes = [
        (
            gravity_gradient(turned(SPIN.wxyz, axis, h))
            - gravity_gradient(turned(SPIN.wxyz, axis, -h))
        )
        @ y
        / (2.0 * h)
        for axis in np.eye(3)
    ]
    # truncation h^2, and 1e-16 of the torque over h
    assert np.allclose(found, slopes, rtol=1e-6, atol=1e-9 * np.max(np.abs(slopes)))


def test_slope_of_a_torque_without_a_potential():
    """(y . d) N - N x y, which is the slope of N . y where there is a potential."""
    from attitude.torques._compiled import constant_slope, gravity_gradient_slope

    y, h = np.array([0.3, -0.2, 0.5]), 1e-4
    size = np.sqrt(y @ y)
    sides = [gravity_gradient(turned(SPIN.wxyz, y / size, k * h * size)) for k in (-1.0, 1.0)]
    along = (sides[1] - sides[0]) / (2.0 * h) - np.cross(gravity_gradient(SPIN.wxyz), y)
    parameters = GravityGradient(still, MU).parameters(BODY)
    found = called(gravity_gradient_slope, SPIN.wxyz, y, PLACE, parameters)
    assert np.allclose(along, found, rtol=1e-6, atol=1e-9 * np.max(np.abs(found)))
    torque = np.array([0.1, 0.2, -0.3])
    found = called(constant_slope, SPIN.wxyz, y, PLACE, torque)
    assert np.allclose(found, -np.cross(torque, y), rtol=1e-15, atol=1e-16)


def test_torques_add():
    torques = GravityGradient(still, MU), ConstantTorque((1e-4, 2e-4, 0))
    both = torque_at_start(*torques, body=BODY, spin=SPIN)
    assert np.allclose(
        both, gravity_gradient(SPIN.wxyz) + np.array([1e-4, 2e-4, 0]), rtol=1e-12, atol=1e-15
    )


def test_constant_torque_spins_up_a_sphere():
    sphere = Body(moments=(5, 5, 5))
    rest = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    history = TorquedRotation(sphere, rest, ConstantTorque((0.1, 0.2, 0)), step=0.05).at(10.0)
    # exact: w = N t / I, and a turn by N t^2 / 2 I about N
    assert np.allclose(history.angular_velocity, (0.2, 0.4, 0), rtol=1e-14, atol=1e-15)
    angle = np.hypot(0.1, 0.2) * 100.0 / 10.0
    expected = np.append(np.cos(angle / 2), np.sin(angle / 2) * np.array([1, 2, 0]) / np.sqrt(5))
    # kick-rotate-kick is the trapezium rule for the angle, exact for a constant torque
    assert np.max(np.abs(history.wxyz - expected)) < 1e-13


def test_linear_damping_of_a_sphere_is_exponential():
    sphere = Body(moments=(5, 5, 5))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.3, 0.2, -0.1))
    for scheme in ("kick-rotate-kick", "blanes-moan"):
        motion = TorquedRotation(sphere, spin, LinearDamping(0.2), step=0.1, scheme=scheme)
        found = motion.at(20.0).angular_velocity
        # kicks are exact: 200 steps round
        assert np.allclose(found, np.array([0.3, 0.2, -0.1]) * np.exp(-0.8), rtol=1e-14)


@pytest.mark.parametrize("h", [1e-6, 0.02, 0.7, 9.0, -2.0])
def test_a_kick_of_damping_is_exact(h):
    """At a fixed attitude, w' = a + J w has an exponential; and -h undoes h."""
    damping = LinearDamping([[6.0, 1.0, -2.0], [0.5, 9.0, 3.0], [1.0, -4.0, 8.0]])
    body = Body(tensor=TENSOR / 20.0)
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.4, 0.3, -0.2))
    motion = TorquedRotation(body, spin, [damping, ConstantTorque((1.0, -2.0, 0.5))], step=0.1)
    system, start = motion._system, motion._system.start[None]

    def kicked(state, h):
        out, rest = np.empty_like(state), (np.zeros(1), np.zeros((1, 1)))
        numbers, _, models = system.setup
        system.run(kicks, 0.0, numbers, models, state, rest[0], np.full(1, h), *rest, out)
        return out

    rate = -np.linalg.solve(body.tensor, damping.coefficient)
    both = np.zeros((4, 4))
    both[:3, :3], both[:3, 3] = rate, np.linalg.solve(body.tensor, (1.0, -2.0, 0.5))
    with mp.workdps(30):  # scipy's exponential errs by 6e-13 where it grows
        exact = mp.expm(mpf(h) * mp.matrix(both)) * mp.matrix([*spin.angular_velocity, 1.0])
        expected = np.array([float(x) for x in exact[:3]])
    after = kicked(start, h)
    found = system.axes @ after[0, 4:7]
    # rounding of the 100 pieces of the longest kick; of the rates' matrix where it grows by e^13
    assert np.max(np.abs(found - expected)) < 2e-14 * np.max(np.abs(expected))
    back = kicked(after, -h)[0, 4:7] - start[0, 4:7]
    # undone growth leaves the rounding of the larger side
    assert np.max(np.abs(back)) < 1e-15 * np.exp(abs(h) * np.max(np.abs(np.linalg.eigvals(rate))))


def test_a_kick_of_strong_damping_stays_finite():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.4, 0.3, -0.2))
    motion = TorquedRotation(BODY, spin, LinearDamping(400.0), step=1.0)
    assert np.max(np.abs(motion.at(10.0).angular_velocity)) < 1e-50


def test_damping_on_the_schemes_order():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.4, 0.3, -0.2))
    damping = LinearDamping(np.diag([0.3, 0.2, 0.1]))
    fine = TorquedRotation(BODY, spin, damping, step=0.01, scheme="blanes-moan").at(30.0)
    for scheme, order in (("kick-rotate-kick", 2), ("suzuki", 4), ("blanes-moan", 4)):
        errors = [
            np.max(
                np.abs(
                    TorquedRotation(BODY, spin, damping, step=h, scheme=scheme).at(30.0).wxyz
                    - fine.wxyz
                )
            )
            for h in (0.8, 0.4)
        ]
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.45), scheme


def test_internal_dissipation_relaxes_at_fixed_momentum():
    body = Body(moments=(10, 20, 26))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(8, 1, 1))
    assert FreeRotation(body, spin).mode is Mode.LONG_AXIS
    motion = TorquedRotation(body, spin, InternalDissipation(0.02), step=0.01)
    history = motion.at(np.linspace(0.0, 300.0, 1501))
    w = history.angular_velocity
    momentum = history.body_to_inertial(w * body.moments)
    size = np.sqrt(momentum[0] @ momentum[0])
    # 30,000 steps, whose rounding is summed with compensation
    assert np.max(np.abs(momentum - momentum[0])) < 1e-14 * size
    energy = 0.5 * np.sum(w * w * body.moments, axis=-1)
    assert np.all(np.diff(energy) < 1e-12 * energy[0])
    # the least energy at this momentum, and the spin about the short axis
    assert energy[-1] == pytest.approx(size**2 / (2.0 * 26.0), rel=1e-6)
    assert abs(w[-1, 2]) == pytest.approx(size / 26.0, rel=1e-6)


def test_internal_dissipation_takes_the_stated_power():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.4, 0.3, -0.2))
    strength, h = 1e-3, 1e-3
    motion = TorquedRotation(BODY, spin, InternalDissipation(strength), step=h)
    w = motion.at([-h, 0.0, h]).angular_velocity
    energy = 0.5 * np.sum(w @ TENSOR * w, axis=-1)
    momentum = TENSOR @ w[1]
    size = np.sqrt(momentum @ momentum)
    power = -strength * size * np.sum(np.cross(momentum / size, w[1]) ** 2)
    # 1e-16 of the energy over 2 h, and h^2
    assert (energy[2] - energy[0]) / (2 * h) == pytest.approx(power, rel=1e-5)


class Facets:
    """Two plates of a box that is open elsewhere."""

    areas = np.array([2.0, 3.0])
    normals = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]])
    centroids = np.array([[0.5, 0.2, 0.1], [0.0, 0.3, 0.7]])


AU = 149597870700.0


def test_light_pressure_by_its_formula():
    # at 2 au, the Sun seen along +x and a little +y of ICRF
    sun = np.array([2.0, 0.5, 1.0])
    distance = 2.0 * AU
    place = -sun / np.sqrt(sun @ sun) * distance
    model = SolarRadiation(
        Facets, lambda s: np.broadcast_to(place, (*np.shape(s), 3)), diffuse=0.3, mirrored=[0.5, 0]
    )
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0.1, 0, 0), angular_velocity=(0, 0, 0))
    body = Body(tensor=TENSOR, center_of_mass=(0.1, 0.0, 0.0))
    found = torque_at_start(model, body=body, spin=spin)
    s = quaternion.matrix(spin.wxyz).T @ sun / np.sqrt(sun @ sun)
    total = np.zeros(3)
    for area, n, c, d, m in zip(
        Facets.areas, Facets.normals, Facets.centroids, (0.3, 0.3), (0.5, 0.0), strict=True
    ):
        cosine = max(n @ s, 0.0)
        push = (1.0 - m) * s + 2.0 * (m * cosine + d / 3.0) * n
        force = -1361.0 / 299792458.0 / 4.0 * area * cosine * push
        total += np.cross(c - (0.1, 0.0, 0.0), force)
    assert np.allclose(found, total, rtol=1e-12, atol=1e-20)


def lopsided():
    """A tetrahedron without symmetry: closed and convex, so that facets shade nothing."""
    corners = np.array([[1.0, 0.1, -0.6], [-0.9, 0.7, -0.5], [-0.2, -1.1, -0.4], [0.1, 0.2, 0.9]])
    mesh = Mesh(corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    mesh.require_closed()
    return mesh


def test_sunlight_spins_up_by_the_torque_averaged_over_rotations():
    """YORP: 400 rotations integrated, against the sum over facets at 720 phases of one."""
    mesh = lopsided()
    body = Body.from_shape(mesh, density=500.0)
    short = body.principal_axes[:, np.argmax(body.moments)]
    rate, sun = 0.05, np.array([0.6, 0.0, 0.8])
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rate * short)
    place = -sun * 5.0 * AU  # so far that the axis turns by no more than 1e-4
    light = SolarRadiation(mesh, lambda s: np.broadcast_to(place, (*np.shape(s), 3)), diffuse=0.7)
    period = 2.0 * np.pi / rate
    motion = TorquedRotation(body, spin, light, step=period / 51.3)
    phases = np.arange(64) / 64.0 - 0.5
    ends = []
    for middle in (0.0, 400.0 * period):
        history = motion.at(middle + period * phases)
        momentum = history.body_to_inertial(history.angular_velocity @ body.tensor)
        ends.append(np.mean(momentum, axis=0))
    found = (ends[1] - ends[0]) / (400.0 * period)

    total = np.zeros(3)
    for angle in 2.0 * np.pi * (np.arange(720) + 0.5) / 720:
        turn = np.append(np.cos(0.5 * angle), np.sin(0.5 * angle) * short)
        s = quaternion.matrix(turn).T @ sun
        for area, n, c in zip(mesh.areas, mesh.normals, mesh.centroids, strict=True):
            cosine = max(n @ s, 0.0)
            force = -1361.0 / 25.0 / 299792458.0 * area * cosine * (s + 2.0 / 3.0 * 0.7 * n)
            arm = quaternion.rotate(turn, c - body.center_of_mass)
            total += np.cross(arm, quaternion.rotate(turn, force)) / 720
    # the edge of the light crosses facets between the samples of both, 1/51^2 and 1/720^2
    assert np.max(np.abs(found - total)) < 2e-3 * np.max(np.abs(total))
    assert abs(total @ short) > 0.01 * np.max(np.abs(total))


def test_a_facet_in_the_dark_feels_nothing():
    model = SolarRadiation(Facets, lambda s: np.broadcast_to((AU, AU, AU), (*np.shape(s), 3)))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    assert np.array_equal(torque_at_start(model, body=BODY, spin=spin), np.zeros(3))


def test_a_user_s_function_compiled_or_not():
    import numba

    def drag(t, wxyz, omega):
        return -0.2 * omega[0], -0.2 * omega[1] + 0.01 * t, -0.2 * omega[2]

    t = np.linspace(0.0, 5.0, 11)
    plain = TorquedRotation(BODY, SPIN, drag, step=0.1).at(t)
    fast = TorquedRotation(BODY, SPIN, numba.njit(drag), step=0.1).at(t)
    shipped = TorquedRotation(
        BODY,
        SPIN,
        [LinearDamping(0.2), CustomTorque(lambda t, q, w: (0.0, 0.01 * t, 0.0), False)],
        step=0.1,
    ).at(t)
    assert np.max(np.abs(plain.wxyz - fast.wxyz)) < 1e-14
    assert np.max(np.abs(plain.wxyz - shipped.wxyz)) < 1e-14


def test_arrays_of_a_user_s_function_do_not_lie_where_the_loop_works():
    """Any array of as many numbers as the loop keeps for itself had taken their place."""

    def torque(scratch):
        @numba.njit
        def function(t, q, w):
            if scratch:
                room = np.full(16, 7.0)
                return 0.1 * q[1] + 0.0 * room[3], 0.2 * q[2] - 0.1, 0.3 * q[0]
            return 0.1 * q[1], 0.2 * q[2] - 0.1, 0.3 * q[0]

        return CustomTorque(function, depends_on_rate=False)

    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 0.2, 0.3))
    motions = [TorquedRotation(BODY, spin, torque(scratch), step=0.05) for scratch in (True, False)]
    assert np.array_equal(motions[0].at(40.0).wxyz, motions[1].at(40.0).wxyz)


def nothing(t, wxyz, omega):
    return 0.0, 0.0, 0.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: GravityGradient(3.0, MU), "path is 3.0"),
        (lambda: GravityGradient(still, "vulcan"), "mu is 'vulcan'"),
        (lambda: GravityGradient(still, "ssb"), "GM of ssb is not known here; give mu"),
        (lambda: GravityGradient(paths.relative("moon", "earth"), "sun"), "relative to earth, and"),
        (lambda: GravityGradient(still, -1.0), "greater than zero"),
        (lambda: ConstantTorque((1, 2)), "shape"),
        (lambda: LinearDamping(np.eye(2)), "shape"),
        (lambda: InternalDissipation(-0.1), "does not add energy"),
        (lambda: SolarRadiation(None, still), "without areas, normals, centroids"),
        (lambda: SolarRadiation(Facets, still, diffuse=0.9, mirrored=0.2), "at most 1"),
        (lambda: CustomTorque(3), "function is 3"),
        (lambda: CustomTorque(nothing, slope=3), "slope is 3"),
        (lambda: CustomTorque(nothing, slope=nothing), "takes no such torque"),
        (
            lambda: CustomTorque(nothing, False, slope=lambda t, q, y: (1, 2)),
            "the slope of a CustomTorque returned",
        ),
        (lambda: CustomTorque(lambda t, q, w: (1, 2)), "must return three plain numbers"),
        (lambda: CustomTorque(lambda t, q, w: "abc"), "must return three plain numbers"),
        (lambda: CustomTorque(lambda t, q, w: (1, [2], 3)), "must return three plain numbers"),
        (lambda: CustomTorque(lambda t, q, w: [1, 2, 3] * units.mN), "three plain numbers"),
        (
            lambda: torque_at_start(
                SolarRadiation(Facets, still),
                body=Body(moments=(1, 2, 2.5), relative=True),
                spin=SPIN,
            ),
            "moments of the body are relative",
        ),
        (
            lambda: torque_at_start(
                GravityGradient(lambda s: np.zeros((len(s), 3)), MU), body=BODY, spin=SPIN
            ),
            "passes through the point mass",
        ),
    ],
)
def test_bad_input_is_a_sentence(call, message):
    with pytest.raises(AttitudeError, match=message):
        call()
