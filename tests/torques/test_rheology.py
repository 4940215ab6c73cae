"""Friction of an ellipsoid of a material, against elasticity, Love's number and whole motions."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.frames import quaternion
from attitude.splitting import TorquedRotation
from attitude.torques import InternalDissipation, Maxwell, QualityFactor, Rheology, _rheology
from tests.support.torqued import cross, torque_at_start

AXES = np.array([1.0, 0.8, 0.6])
DENSITY = 2000.0
ROCK = Rheology((3, 2, 1), DENSITY, QualityFactor(5e9, 100))


def ellipsoid(axes=AXES, density=DENSITY):
    a, b, c = axes
    mass = 4.0 / 3.0 * np.pi * a * b * c * density
    return Body(moments=mass / 5.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b]))


def test_displacement_solves_the_equations_of_elasticity():
    """mu div grad u + (lambda + mu) grad div u = B r inside, and no stress on the surface."""
    poisson, h = 0.3, 1e-2
    first = 2.0 * poisson / (1.0 - 2.0 * poisson)
    # forces without a torque, as those of inertia are
    matrix = np.diag(AXES**2) @ [[-1.0, 0.3, 0.2], [0.3, 0.5, -0.4], [0.2, -0.4, -0.7]]
    numbers = (_rheology.displacement(AXES, poisson) @ matrix.ravel()).reshape(-1, 3)

    def u(r):
        return sum(
            row * np.prod(r ** np.array(e)) for row, e in zip(numbers, _rheology._ODD, strict=True)
        )

    def slope(function, r, k):  # exact for polynomials of fourth degree
        d = h * np.eye(3)[k]
        near, far = function(r + d) - function(r - d), function(r + 2 * d) - function(r - 2 * d)
        return (8.0 * near - far) / (12.0 * h)

    def stress(r):
        gradient = np.array([slope(u, r, k) for k in range(3)])  # [k, component]
        return first * np.trace(gradient) * np.eye(3) + gradient + gradient.T

    rng = np.random.default_rng(5)
    for _ in range(5):
        unit = rng.normal(size=3)
        unit /= np.linalg.norm(unit)
        inside = 0.6 * AXES * unit
        force = sum(slope(stress, inside, k)[k] for k in range(3))
        np.testing.assert_allclose(force, matrix @ inside, atol=1e-10)
        surface = AXES * unit
        normal = surface / AXES**2
        pushed = stress(surface) @ normal / np.linalg.norm(normal)
        np.testing.assert_allclose(pushed, 0.0, atol=1e-10)


def test_a_sphere_has_its_love_number():
    """b* G b = (2 pi/57) R^7 |b|^2 for a tide b, of a stiff sphere with k2 = 3 rho g R / 19 mu."""
    form = Rheology((2.0, 2.0, 2.0), 1.0, QualityFactor(1.0, 1.0))._form
    tide = np.array([[1.0, 0.3, 0.2], [0.3, -0.4, 0.5], [0.2, 0.5, -0.6]])
    wanted = 2.0 * np.pi / 57.0 * 2.0**7 * np.sum(tide * tide)
    assert tide.ravel() @ form @ tide.ravel() == pytest.approx(wanted, rel=1e-12)
    # squeezed evenly, it does not change its volume
    assert abs(np.eye(3).ravel() @ form @ np.eye(3).ravel()) < 1e-12 * wanted


def test_gravity_resists_as_in_a_sphere():
    """-Im k2 = -Im 3/2 / (1 + 19 / (2 J rho g R)) for soft and for stiff spheres."""
    radius, density = 2e5, 3000.0
    weight = density**2 * 4.0 / 3.0 * np.pi * 6.67430e-11 * radius**2
    for law in (Maxwell(1e9, 1e12), Maxwell(1e4, 1e15), QualityFactor(1e10, 30.0)):
        rheology, rates = Rheology((radius,) * 3, density, law), np.array([1e-6, 1e-4, 1e-2])
        j = law(rates)
        love = -np.imag(1.5 / (1.0 + 19.0 / (2.0 * j * weight)))
        # k2 = (3/2) (2/19) rho g R J_eff
        np.testing.assert_allclose(
            1.5 * 2.0 / 19.0 * weight * rheology.loss(rates), love, rtol=1e-9
        )


def test_the_form_is_that_of_any_unit_of_length():
    one = Rheology(AXES, 1.0, QualityFactor(1.0, 1.0))._form
    many = Rheology(1e4 * AXES, 1.0, QualityFactor(1.0, 1.0))._form
    np.testing.assert_allclose(many, 1e28 * one, rtol=1e-9, atol=1e-9 * 1e28 * np.abs(one).max())


def by_quadrature(rheology, motion, law, harmonics=40):
    """The mean power of a free rotation from attitudes of the package and a plain sum."""
    period = motion.regime.P_psi
    count = 512
    t = period * np.arange(count) / count
    history = motion.at(t)
    w, a = history.angular_velocity, history.angular_acceleration
    matrix = w[:, :, None] * w[:, None, :] - np.sum(w * w, axis=1)[:, None, None] * np.eye(3)
    for k in range(count):
        x, y, z = a[k]
        matrix[k] += [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    total = 0.0
    for n in range(1, harmonics):
        wave = np.exp(-2j * np.pi * n * np.arange(count) / count)
        b = np.tensordot(wave, matrix, 1).ravel() / count
        rate = n * 2.0 * np.pi / period
        energy = (b.conj() @ rheology._form @ b).real
        total += rate * -np.imag(law(np.array([rate])))[0] * energy
    return 2.0 * rheology.density**2 * total


@pytest.mark.parametrize("law", [QualityFactor(1e8, 40.0), Maxwell(1e8, 1e11)])
@pytest.mark.parametrize("omega", [(0.02, 0.01, 0.1), (0.1, 0.02, 0.03), (0.05, 0.03, 0.05)])
def test_power_of_a_polhode_by_its_attitudes(law, omega):
    body = ellipsoid()
    rheology = Rheology(AXES, DENSITY, law)
    motion = FreeRotation(body, Spin("2026-01-01", (1, 0, 0, 0), omega))
    low, _, high = body.moments
    momentum = np.linalg.norm(body.moments * omega)
    energy = 0.5 * np.sum(body.moments * np.array(omega) ** 2)
    p = (2.0 * energy / momentum**2 - 1.0 / high) / (1.0 / low - 1.0 / high)
    wanted = by_quadrature(rheology, motion, law)
    power = rheology.power(body, momentum, p)
    assert power == pytest.approx(wanted, rel=1e-9)
    # the same power by the strength of the torque
    strength = InternalDissipation(rheology).strength_at(body, momentum, p)
    t = motion.regime.P_psi * np.arange(512) / 512
    w = motion.at(t).angular_velocity
    across = np.sum(np.cross(w * body.moments / momentum, w) ** 2, axis=1).mean()
    assert strength * momentum * across == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize("omega", [(0.02, 0.01, 0.1), (0.1, 0.02, 0.03), (0.05, 0.03, 0.05)])
def test_the_motion_takes_the_strength_of_its_energy(omega):
    """The compiled table against the spline, over turned axes."""
    tensor = ellipsoid().moments
    turn, _ = np.linalg.qr(np.array([[1.0, 0.2, 0.3], [0.1, 1.0, -0.4], [0.3, 0.2, 1.0]]))
    turn *= np.linalg.det(turn)
    body = Body(tensor=turn @ np.diag(tensor) @ turn.T)
    rheology = Rheology(AXES, DENSITY, Maxwell(1e5, 1e6))
    spin = Spin("2026-01-01", (1, 0, 0, 0), turn @ omega)
    torque, h = InternalDissipation(rheology), 1e-2
    w = TorquedRotation(body, spin, torque, step=h).at([-h, 0.0, h]).angular_velocity
    energy = 0.5 * np.sum(w @ body.tensor * w, axis=-1)
    momentum = body.tensor @ w[1]
    size = np.linalg.norm(momentum)
    p = (2.0 * energy[1] / size**2 - 1.0 / tensor[2]) / (1.0 / tensor[0] - 1.0 / tensor[2])
    strength = torque.strength_at(body, size, p)
    power = strength * size * np.sum(np.cross(momentum / size, w[1]) ** 2)
    assert -(energy[2] - energy[0]) / (2.0 * h) == pytest.approx(power, rel=1e-4)
    np.testing.assert_allclose(torque_at_start(torque, body=body, spin=spin), 0.0, atol=1e-12)


def test_tilts_damp_at_the_rate_of_the_mean_power():
    """A small tilt decays by 2 power / (L^2 D p (1 - p)) in ln p, over many nutations."""
    body = ellipsoid()
    rheology = Rheology(AXES, DENSITY, QualityFactor(5e3, 5.0))
    low, _, high = body.moments
    omega = np.array([0.005, 0.0, 0.1])
    spin = Spin("2026-01-01", (1, 0, 0, 0), omega)
    motion = TorquedRotation(body, spin, InternalDissipation(rheology), step=1.0)
    t = np.linspace(0.0, 20000.0, 11)
    w = motion.at(t).angular_velocity
    momentum = np.linalg.norm(body.moments * omega)
    whole = 1.0 / low - 1.0 / high
    p = (np.sum(body.moments * w * w, axis=1) / momentum**2 - 1.0 / high) / whole
    assert p[-1] < 0.8 * p[0]
    pace = 2.0 * rheology.power(body, momentum, p[0]) / (momentum**2 * whole * p[0])
    # the tilt is small: the pace is constant to p
    np.testing.assert_allclose(np.log(p / p[0]), -pace * t, rtol=2e-2, atol=1e-3)


def test_a_rheology_against_dop853():
    """The slip with the strength of the spline, over turned axes, at fixed momentum."""
    low, middle, high = ellipsoid().moments
    turn, _ = np.linalg.qr(np.array([[1.0, 0.2, 0.3], [0.1, 1.0, -0.4], [0.3, 0.2, 1.0]]))
    turn *= np.linalg.det(turn)
    tensor = turn @ np.diag([low, middle, high]) @ turn.T
    body, spin = Body(tensor=tensor), Spin("2026-01-01", (1, 2, 3, 4), turn @ (0.05, 0.02, 0.06))
    torque = InternalDissipation(Rheology(AXES, DENSITY, QualityFactor(30.0, 3.0)))
    momentum = tensor @ spin.angular_velocity
    size = np.linalg.norm(momentum)
    nodes = np.linspace(0.0, 1.0, 20001)[1:-1]
    strengths = torque.strength_at(body, size, nodes)

    def slope(t, y):
        wxyz, along = y[:4] / np.linalg.norm(y[:4]), y[4:]
        omega = np.linalg.solve(tensor, along)
        p = (omega @ along / size**2 - 1.0 / high) / (1.0 / low - 1.0 / high)
        strength = float(np.interp(p, nodes, strengths))
        rate = omega + strength * cross(along / size, omega)
        turning = 0.5 * quaternion.multiply(wxyz, np.append(0.0, rate))
        return np.concatenate([turning, cross(along, rate)])

    start = np.concatenate([spin.wxyz, momentum])
    end = solve_ivp(slope, (0.0, 300.0), start, method="DOP853", rtol=1e-8, atol=1e-10).y[:, -1]
    found = TorquedRotation(body, spin, torque, step=0.05).at(300.0)
    before, after = spin.angular_velocity, np.linalg.solve(tensor, end[4:])
    assert after @ tensor @ after < 0.99 * (before @ tensor @ before)
    # two interpolations of the strength
    np.testing.assert_allclose(found.angular_velocity, after, atol=2e-6)
    miss = quaternion.multiply(quaternion.conjugate(end[:4]), found.wxyz)
    assert 2.0 * np.linalg.norm(miss[1:]) < 2e-4


@pytest.mark.parametrize("axes", [(1.0, 1.0, 0.6), (1.0, 0.6, 0.6)])
def test_symmetric_bodies(axes):
    body = ellipsoid(axes)
    rheology = Rheology(axes, DENSITY, QualityFactor(2e5, 5.0))
    spin = Spin("2026-01-01", (1, 0, 0, 0), (0.03, 0.01, 0.1))
    w = TorquedRotation(body, spin, InternalDissipation(rheology), step=1.0).at(1000.0)
    before = 0.5 * np.sum(body.moments * np.array(spin.angular_velocity) ** 2)
    assert 0.5 * np.sum(body.moments * w.angular_velocity**2) < before


@pytest.mark.parametrize("omega", [(0.0, 0.0, 0.1), (0.1, 0.0, 0.0), (0.0, 0.0, 0.0)])
def test_uniform_rotation_stays(omega):
    rheology = Rheology(AXES, DENSITY, QualityFactor(2e5, 5.0))
    spin = Spin("2026-01-01", (1, 0, 0, 0), omega)
    motion = TorquedRotation(ellipsoid(), spin, InternalDissipation(rheology), step=1.0)
    np.testing.assert_allclose(motion.at(100.0).angular_velocity, omega, atol=1e-15)


def test_relative_moments_are_those_of_the_ellipsoid():
    rheology = Rheology(AXES, DENSITY, QualityFactor(2e5, 5.0))
    whole, share = ellipsoid(), Body(moments=ellipsoid().moments / 1e3, relative=True)
    size = 0.1 * whole.moments[2]
    assert rheology.power(share, size, 0.1) == pytest.approx(rheology.power(whole, size, 0.1))
    # momentum in the unit of the body: the strength is that of the same rotation
    one = InternalDissipation(rheology).strength_at(whole, size, 0.1)
    two = InternalDissipation(rheology).strength_at(share, size / 1e3, 0.1)
    assert one == pytest.approx(two)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Rheology((1, 2), 1, QualityFactor(1, 1)), "axes"),
        (lambda: Rheology((1, 2, 0), 1, QualityFactor(1, 1)), "semi-axes above zero"),
        (lambda: Rheology((1, 2, 3), -1, QualityFactor(1, 1)), "density"),
        (lambda: Rheology((1, 2, 3), 1, 5e12), "give QualityFactor"),
        (lambda: Rheology((1, 2, 3), 1, QualityFactor(1, 1), 0.6), "from 0 to 0.5"),
        (lambda: Rheology((1, 2, 3), 1, lambda f: 1.0 + 1j * f).loss([1.0]), "not positive"),
        (lambda: ROCK.loss("a"), "frequency is 'a'"),
        (lambda: ROCK.loss(np.nan), "frequency holds nan"),
        (lambda: ROCK.strength_at(ellipsoid(), 1e6, 2.0), "numbers from 0 to 1"),
        (lambda: ROCK.strength_at(ellipsoid(), 0.0, 0.5), "give momenta above zero"),
        (lambda: ROCK.power(None, 1e6, 0.5), "body is None; give a Body"),
        (lambda: Maxwell(-1.0, 1.0), "rigidity"),
        (lambda: QualityFactor(1.0, 0.0), "quality"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        make()
