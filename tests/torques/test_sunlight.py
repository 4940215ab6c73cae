"""Sunlight with shadows between facets and with eclipses, against rays and geometry."""

import ctypes

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

from attitude import AttitudeError, Body, FreeRotation, Spin, paths
from attitude._compilation.pointers import C_FUNCTION
from attitude.frames import quaternion
from attitude.light_curve import Visibility
from attitude.shape import Mesh, box
from attitude.splitting import TorquedRotation
from attitude.torques import SolarRadiation
from tests.support.torqued import angle, dop853, torque_at_start, turns_by_rates

AU = 149597870700.0
PRESSURE = 1361.0 / 299792458.0
BODY = Body(moments=(20.0, 24.0, 30.0), center_of_mass=(0.1, 0.05, -0.2))


def far(seconds):
    return np.broadcast_to([-AU, 0.0, 0.0], (*np.shape(seconds), 3))


def spin_towards(direction, omega=(0.1, 0.2, -0.3)):
    """An attitude at which the Sun, +x of ICRF, is in a direction over the body axes."""
    z = np.array(direction) / np.linalg.norm(direction)
    x = np.cross(z, [0.3, -0.5, 0.8])
    x /= np.linalg.norm(x)
    matrix = np.array([z, x, np.cross(z, x)])
    return Spin("2026-01-01", quaternion.from_matrix(matrix), omega)


def two_boxes(divisions=3):
    """A large box and a small one beside it, closed parts that shade each other."""
    large, small = box((2.0, 2.0, 2.0)), box((0.8, 0.8, 0.8))
    vertices = np.concatenate([large.vertices, small.vertices + np.array([2.5, 0.0, 0.3])])
    facets = np.concatenate([large.facets, small.facets + len(large.vertices)])
    return Mesh(vertices, facets).divided(divisions)


def by_rays(mesh, sun, diffuse=1.0):
    """The torque by rays from 16 places of each facet against all facets; N m."""
    rng = np.random.default_rng(3)
    u, v = rng.random((2, 16))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    weights = np.stack([1 - u - v, u, v], axis=1)
    corners = mesh.corners
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(sun, two)
    det = np.einsum("fi,fi->f", one, across)
    one_sun, one_two = np.cross(one, sun), np.cross(one, two)
    first_across, first_one_sun, first_one_two = (
        np.einsum("fi,fi->f", corners[:, 0], normal) for normal in (across, one_sun, one_two)
    )
    total = np.zeros(3)
    for k in np.flatnonzero(mesh.normals @ sun > 0.0):
        # place p less a corner c, by triple products: (p - c) . n = p . n - c . n
        places = weights @ corners[k]
        with np.errstate(divide="ignore", invalid="ignore"):
            a = (places @ across.T - first_across) / det
            b = (places @ one_sun.T - first_one_sun) / det
            ahead = (places @ one_two.T - first_one_two) / det
        met = (np.abs(det) > 1e-12) & (a >= 0) & (b >= 0) & (a + b <= 1) & (ahead > 1e-9)
        lit = np.count_nonzero(~np.any(met, axis=1))
        cosine = mesh.normals[k] @ sun
        push = -PRESSURE * mesh.areas[k] * cosine * (sun + 2 / 3 * diffuse * mesh.normals[k])
        total += lit / 16 * np.cross(mesh.centroids[k] - BODY.center_of_mass, push)
    return total


def test_without_shadows_nothing_changes_on_a_convex_body():
    shape = box((1.0, 2.0, 0.5)).divided(1)
    spin = spin_towards((0.3, -0.4, 0.8))
    plain, shaded = (
        torque_at_start(SolarRadiation(shape, far, 0.5, 0.2, shadows=shadows), body=BODY, spin=spin)
        for shadows in (False, True)
    )
    np.testing.assert_allclose(shaded, plain, atol=1e-15)


@pytest.mark.parametrize(
    "sun",
    [
        (1.0, 0.1, 0.1),
        (0.2, 1.0, 0.3),
        pytest.param((1.0, 0.3, 0.2), marks=pytest.mark.slow),
        pytest.param((-1.0, 0.2, 0.1), marks=pytest.mark.slow),
    ],
)
def test_shadows_by_rays(sun):
    mesh, unit = two_boxes(), np.array(sun) / np.linalg.norm(sun)
    torque = SolarRadiation(mesh, far, shadows=Visibility.of(mesh, resolution=64, keep=False))
    found = torque_at_start(torque, body=BODY, spin=spin_towards(unit))
    plain = torque_at_start(SolarRadiation(mesh, far), body=BODY, spin=spin_towards(unit))
    wanted = by_rays(mesh, unit)
    force = PRESSURE * 4.0  # over one face of the large box, 1 m from the axis
    # a sixty-fourth of a right angle over the 1 m between the boxes, and 16 places a facet
    assert np.abs(found - wanted).max() < 0.01 * force
    if abs(sun[0]) == 1.0:
        assert np.abs(plain - wanted).max() > 0.03 * force


def test_the_torque_is_continuous_in_direction():
    """Half the spacing of directions, half the largest step: no jumps between cells and faces."""
    torque = SolarRadiation(two_boxes(2), far, shadows=True)
    parameters, pointer = torque.parameters(BODY), ctypes.POINTER(ctypes.c_double)
    function = C_FUNCTION(torque.address())

    def at(angle):
        sun = np.array([np.cos(angle), np.sin(angle), 0.3]) / np.sqrt(1.09)
        arrays = np.array([1.0, 0, 0, 0]), np.zeros(3), -AU * sun, parameters, np.zeros(3)
        function(0.0, *(array.ctypes.data_as(pointer) for array in arrays))
        return arrays[-1] / PRESSURE

    steps = []
    for count in (2000, 4000, 8000):
        around = np.array([at(angle) for angle in np.linspace(0.0, 2.0 * np.pi, count + 1)])
        steps.append(np.abs(np.diff(around, axis=0)).max())
    assert 1.6 < steps[0] / steps[1] < 2.4
    assert 1.6 < steps[1] / steps[2] < 2.4


def test_eclipses_take_the_light():
    """Behind the Earth none, beside it all, between a share that falls."""
    earth = paths.fixed((AU, 0.0, 0.0), center="sun", name="earth")

    def place(height):
        return lambda seconds: np.broadcast_to([AU + 7e6, height, 0.0], (*np.shape(seconds), 3))

    shape, spin, sizes = box((1.0, 2.0, 0.5)), spin_towards((0.3, -0.4, 0.8)), []
    for height in (0.0, 6.36e6, 6.378e6, 6.4e6, 7e6):
        torque = SolarRadiation(shape, place(height), shadow_of=earth)
        sizes.append(np.linalg.norm(torque_at_start(torque, body=BODY, spin=spin)))
    free = np.linalg.norm(torque_at_start(SolarRadiation(shape, place(7e6)), body=BODY, spin=spin))
    assert sizes[0] < 1e-15
    assert sizes[1] < sizes[2] < sizes[3] <= sizes[4] * (1.0 + 1e-5)
    assert 0.2 * free < sizes[2] < 0.8 * free
    assert sizes[4] == pytest.approx(free, rel=1e-9)
    # a smaller Earth shades less
    small = SolarRadiation(shape, place(6.36e6), shadow_of={earth: 6.2e6})
    assert np.linalg.norm(torque_at_start(small, body=BODY, spin=spin)) > 0.99 * free


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"shadows": "yes"}, "give True, False, or Visibility"),
        ({"shadow_of": "earth"}, "give the path of a body from the Sun"),
        ({"shadow_of": paths.fixed((1, 0, 0), center="sun", name="rock")}, "radius of rock"),
    ],
)
def test_what_is_refused(arguments, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        SolarRadiation(box((1.0, 2.0, 0.5)), far, **arguments)


def test_shadows_need_the_mesh_of_the_table():
    other = Visibility.of(box((1.0, 2.0, 0.6)), resolution=8, keep=False)
    with pytest.raises(AttitudeError, match="another mesh"):
        SolarRadiation(box((1.0, 2.0, 0.5)), far, shadows=other)

    class Facets:
        areas, normals, centroids = np.ones(1), np.eye(3)[:1], np.ones((1, 3))

    with pytest.raises(AttitudeError, match="shape is Facets"):
        SolarRadiation(Facets(), far, shadows=True)


# ---- Motions in shadows and through a penumbra, by another integrator

STRONG = 3e8  # W/m2: light turns the body within the span
RADIUS = 6.378e6
SHADE = paths.fixed((AU, 0.0, 0.0), center="sun", name="shade")
SPIN = Spin("2026-01-01", (1.0, 2.0, 3.0, 4.0), (0.05, 0.12, -0.08))


def through_penumbra(seconds):
    """From the edge of the umbra into the light, 32 km wide, in 60 s."""
    seconds = np.asarray(seconds)
    height = RADIUS - 2.5e4 + 900.0 * seconds
    return np.stack([np.full_like(height, AU + 7e6), height, 0.0 * height], axis=-1)


def free_share(place):
    """The free share of the Sun's disc behind a sphere, by rings of the disc on the sky.

    The sphere's limb has a radius of 1.1 rad there: two circles on a plane would err by 1.3e-4.
    """
    other = np.array([AU, 0.0, 0.0]) - place
    distance, apart = np.linalg.norm(place), np.linalg.norm(other)
    a, b = np.arcsin(6.957e8 / distance), np.arcsin(RADIUS / apart)
    c = np.arctan2(np.linalg.norm(np.cross(place, other)), -place @ other)

    def covered(r):
        """Half of the angle of the ring at r from the centre of the disc, times its radius."""
        cosine = (np.cos(b) - np.cos(c) * np.cos(r)) / (np.sin(c) * np.sin(r))
        return np.sin(r) * np.arccos(np.clip(cosine, -1.0, 1.0))

    kink = [abs(c - b)] if abs(c - b) < a else None  # the limb enters the rings there
    area = quad(covered, 0.0, a, points=kink, epsabs=1e-14, epsrel=1e-9)[0]
    return 1.0 - area / (np.pi * (1.0 - np.cos(a)))


@pytest.fixture(scope="module")
def lit_torques():
    """Light on two boxes: in the penumbra of a sphere, and far from it."""
    mesh = two_boxes(0)
    table = Visibility.of(mesh, resolution=16, keep=False)
    shade = {SHADE: RADIUS}
    return (
        SolarRadiation(mesh, through_penumbra, 0.6, 0.1, STRONG, shadows=table, shadow_of=shade),
        SolarRadiation(mesh, far, 0.6, 0.1, STRONG, shadows=table),
    )


def test_shadows_and_a_penumbra_against_dop853(lit_torques):
    """The torque of one attitude has tests of its own: its function, and eclipses of another."""
    shaded, torque = lit_torques
    parameters, pointer = torque.parameters(BODY), ctypes.POINTER(ctypes.c_double)
    function = C_FUNCTION(torque.address())
    times = np.linspace(0.0, 60.0, 241)
    # differs from the function by 1e-8 at most
    share = CubicSpline(times, [free_share(place) for place in through_penumbra(times)])

    def formula(t, wxyz, omega):
        arrays = wxyz, np.zeros(3), through_penumbra(t), parameters, np.zeros(3)
        function(t, *(np.ascontiguousarray(x).ctypes.data_as(pointer) for x in arrays[:4]),
                 arrays[4].ctypes.data_as(pointer))  # fmt: skip
        return arrays[4] * share(t)

    wxyz, omega = dop853(formula, BODY, SPIN, 60.0, rtol=1e-8, atol=1e-10)
    found = TorquedRotation(BODY, SPIN, shaded, step=0.02).at(60.0)
    free = FreeRotation(BODY, SPIN).at(60.0)
    turns = [angle(wxyz, other.wxyz) for other in (found, free)]
    assert turns[1] > 0.3
    # kinks of the facets: 7e-6 rad at this step, a quarter of that at half of it
    assert turns[0] < 2e-5
    assert np.max(np.abs(found.angular_velocity - omega)) < 1e-5


def test_derivatives_and_covariance_in_shadows(lit_torques):
    """Against differences of whole motions; the torque has kinks, so that both err by 1e-2."""
    spin = SPIN.with_covariance({"attitude": 1e-3, "angular_velocity": 1e-5})
    torque = lit_torques[0]
    motion = TorquedRotation(BODY, spin, torque, step=0.2)
    t = 30.0
    attitude = motion.sensitivity_at(t)
    free = FreeRotation(BODY, SPIN).sensitivity_at(t)
    scale = np.abs(attitude[:, 3:6]).max()
    expected = turns_by_rates(
        lambda other: TorquedRotation(BODY, other, torque, step=0.2), SPIN, t, 2e-4
    )
    np.testing.assert_allclose(attitude[:, 3:6], expected, atol=1e-2 * scale)
    assert np.abs(attitude[:, 3:6] - free[:, 3:6]).max() > 0.05 * scale
    assert np.all(np.linalg.eigvalsh(motion.at(t).covariance) > -1e-12)
