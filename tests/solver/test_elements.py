"""The normal form: there and back, its limits, and the derivatives by the elements."""

import mpmath
import numpy as np
import pytest

from attitude import Arcs, AttitudeError, Body, FreeRotation, Impulse, Spin
from attitude._solver.elements import Elements
from attitude.frames import quaternion as forms
from attitude.frames import representations as frames_representations
from attitude.frames.quaternion import conjugate, multiply

WXYZ = (1.0, 0.3, 0.2, -0.1)


def motion_of(moments, omega):
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=omega)
    return FreeRotation(Body(moments=moments, relative=True), spin)


def random_states(count, seed):
    generator = np.random.default_rng(seed)
    for _ in range(count):
        mass = np.sort(generator.uniform(0.02, 1.0, 3))  # second moments: any body
        yield mass.sum() - mass, generator.normal(size=3)


def test_there_and_back():
    for moments, omega in random_states(150, 1):
        motion = motion_of(moments, omega)
        again = FreeRotation.from_elements(motion.elements, epoch="2026-01-01", wxyz=WXYZ)
        ratios = np.sort(again.body.moments) - np.sort(moments) / max(moments)
        # Beside the separatrix 1 - X has fewer digits than X.
        loss = 1.0 / abs(motion.separatrix_distance)
        assert np.abs(ratios).max() < 1e-14 * loss
        assert again.mode == motion.mode
        other = np.sort(np.abs(again.spin.angular_velocity))
        assert np.abs(other - np.sort(np.abs(omega))).max() < 1e-13 * loss
        error = np.subtract(again.elements, motion.elements)
        error[2] = np.sin(error[2])
        assert np.abs(error).max() < 1e-13 * loss


@pytest.mark.parametrize("p", [1e-2, 1e-4, 1e-6, 1e-9, 1e-13, 1e-100])
@pytest.mark.parametrize("direction", [(1.0, 2.0, 0.0), (0.0, 2.0, 1.0), (1.0, 0.0, 0.01)])
def test_there_and_back_beside_an_axis_and_the_separatrix(p, direction):
    moments, omega = np.array([1.0, 2.0, 2.7]), p * np.array(direction)
    omega[int(np.argmin(direction))] = 1.0
    if p < 1e-99 and omega[1] == 1.0:
        p, omega = 1e-60, np.array([1e-60, 1.0, 1e-62])
    elements = motion_of(moments, omega).elements
    again = FreeRotation.from_elements(elements, epoch="2026-01-01", wxyz=WXYZ)
    assert np.abs(np.sort(again.body.moments) * 2.7 - moments).max() < 1e-14
    other = np.sort(np.abs(again.spin.angular_velocity)) / np.sort(omega) - 1.0
    # the two small rates are exponentials of the doubles of rho and X beside the separatrix
    assert np.abs(other).max() < (1e-11 if omega[1] == 1.0 else 2e-15)


@pytest.mark.parametrize("unit", [1e170, 1e-160, 1e-300])
def test_elements_in_any_unit_of_time(unit):
    elements = motion_of((1, 2, 2.7), (0.3, 0.2, 1.0)).elements
    scaled = (elements[0] * unit, elements[1] * unit, *elements[2:])
    again = FreeRotation.from_elements(scaled, epoch="2026-01-01", wxyz=WXYZ)
    assert np.abs(again.spin.angular_velocity / unit - (0.3, 0.2, 1.0)).max() < 4e-15
    assert np.abs(again.body.moments * 2.7 - (1, 2, 2.7)).max() < 4e-15


@pytest.mark.parametrize("excess", [0.0, 1e-12, 1e-8, 1e-4, 1e-2])
def test_there_and_back_beside_a_lamina(excess):
    generator = np.random.default_rng(4)
    for least in generator.uniform(0.05, 0.5, 10):
        moments, omega = (least, 1.0 - least + excess, 1.0), generator.normal(size=3)
        motion = motion_of(moments, omega)
        again = FreeRotation.from_elements(motion.elements, epoch="2026-01-01", wxyz=WXYZ)
        loss = 1.0 / abs(motion.separatrix_distance)
        ratios = np.sort(again.body.moments) - np.sort(moments) / max(moments)
        assert np.abs(ratios).max() < 1e-12 * loss


def test_the_attitude_is_that_of_the_same_motion():
    for moments, omega in random_states(20, 2):
        motion = motion_of(moments, omega)
        order = np.argsort(moments)
        if motion.circulates_about == "long":
            order = order[::-1]
        axes = np.zeros((3, 3))
        axes[order, [0, 1, 2]] = 1.0
        # internal axes: the first and third rate are those of the solution's convention
        again = FreeRotation.from_elements(motion.elements, epoch="2026-01-01", wxyz=WXYZ)
        signs = np.sign(again.spin.angular_velocity * (axes.T @ omega))
        axes = axes * signs
        if np.linalg.det(axes) < 0.0:
            pytest.fail("the axes of from_elements are not a turn of those given")
        turn = multiply(WXYZ / np.linalg.norm(WXYZ), forms.from_matrix(axes))
        again = FreeRotation.from_elements(motion.elements, epoch="2026-01-01", wxyz=turn)
        t = np.linspace(0.0, 20.0, 5)
        found = again.at(t).matrix @ axes.T
        assert np.abs(found - motion.at(t).matrix).max() < 1e-11


def test_known_values_of_a_symmetric_body():
    motion = motion_of((2, 2, 3), (0.3, 0.4, 0.9))
    found = motion.elements
    tilt = np.arctan2(2 * 0.5, 3 * 0.9)
    speed = np.hypot(2 * 0.5, 3 * 0.9) / 2
    assert found.X == 0.0
    assert np.isclose(found.rho, np.tan(0.5 * tilt), rtol=1e-15)
    assert np.isclose(found.nutation_rate, 0.9 * (1 - 3 / 2), rtol=1e-15)
    assert np.isclose(2 * found.precession_rate, speed + found.nutation_rate, rtol=1e-15)


def test_limits():
    axis = motion_of((1, 2, 2.7), (0, 0, 1.0)).elements
    near = motion_of((1, 2, 2.7), (1e-9, 0, 1.0)).elements
    assert axis.rho == 0.0 and axis.phase == 0.0
    assert np.allclose([axis[0], axis[1], axis[4]], [near[0], near[1], near[4]], rtol=1e-12)
    long_axis = motion_of((1, 2, 2.7), (1.0, 0, 0)).elements
    near = motion_of((1, 2, 2.7), (1.0, 0, 1e-9)).elements
    assert np.allclose([*long_axis[:2], long_axis[4]], [*near[:2], near[4]], rtol=1e-12)
    on = motion_of((1, 2, 2.25), (0.75, 1.0, 1.0))
    assert on.mode.name == "SEPARATRIX" and on.elements[1:] == (0.0, 0.0, 1.0, 1.0)
    for moments, omega in (
        ((1, 2, 2.7), (0, 0, 0)),
        ((2, 2, 2), (1, 2, 3)),
        ((1, 2, 2.7), (0, 1, 0)),
        ((2, 2, 3), (0.3, 0.5, 0)),
    ):
        with pytest.raises(AttitudeError, match="no elements"):
            _ = motion_of(moments, omega).elements


@pytest.mark.parametrize(
    ("moments", "omega"),
    [((10, 20, 26), (9, 2, 1)), ((10, 20, 26), (1, 15, 1)), ((10, 20, 26), (1, 2, 9)),
     ((1, 2, 2.7), (1.3888, 0.4, 1))],
)  # fmt: skip
def test_derivatives_by_the_elements(moments, omega):
    motion = motion_of(moments, omega)
    elements = motion.elements
    start = FreeRotation.from_elements(elements, epoch="2026-01-01", wxyz=WXYZ)
    t = np.array([0.0, 1.7, 30.0])
    found, rates = start.sensitivity_at(t, by="elements", angular_velocity=True)
    assert found.shape == (3, 3, 8) and rates.shape == (3, 3, 8)
    for k in range(5):
        step = 1e-6
        sides = []
        for sign in (1, -1):
            moved = np.array(elements)
            moved[k] += sign * step
            other = FreeRotation.from_elements(Elements(*moved), epoch="2026-01-01", wxyz=WXYZ)
            sides.append(other.at(t))
        turn = multiply(sides[0].wxyz, conjugate(sides[1].wxyz))
        numeric = frames_representations.to_rotation_vector(turn) / (2 * step)
        scale = np.abs(found[:, :, 3 + k]).max()
        assert np.abs(found[:, :, 3 + k] - numeric).max() < 1e-6 * scale
        numeric = (sides[0].angular_velocity - sides[1].angular_velocity) / (2 * step)
        assert np.abs(rates[:, :, 3 + k] - numeric).max() < 1e-6 * np.abs(rates).max()


def attitude_of(elements, t):
    """The attitude after t, from the first one, by the polynomials of the normal form."""
    wxyz = []
    for time in (0, t):
        precession, nutation, phase, rho, x = elements
        turn, s = mpmath.expj(nutation * time + phase), rho**4
        a, b = mpmath.mpf(1), rho * (1 / turn - x * turn)
        for n in range(1, 14):
            up, down = x ** (2 * n * n + n), x ** (2 * n * n - n)
            sign, odd = (-1) ** n, turn ** (2 * n + 1)
            a += sign * s ** (n * n) * (up * turn ** (2 * n) + down * turn ** (-2 * n))
            b += sign * s ** (n * n + n) * rho * up * (1 / odd - x ** (2 * n + 1) * odd)
        a, b = (mpmath.expj(precession * time) * number for number in (a, -1j * b))
        size = mpmath.sqrt(abs(a) ** 2 + abs(b) ** 2)
        wxyz.append([number / size for number in (a.real, b.real, b.imag, a.imag)])
    return product_of([wxyz[0][0], *(-number for number in wxyz[0][1:])], wxyz[1])


def product_of(p, q):
    scalar, vector = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], []
    for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        vector.append(p[0] * q[i] + p[i] * q[0] + p[j] * q[k] - p[k] * q[j])
    return [scalar, *vector]


@pytest.mark.parametrize(
    ("moments", "omega"),
    [((1, 2, 2.7), (0.3, 0.2, 1)), ((1, 2, 2.7), (1, 0.2, 0.3)), ((1, 2, 2.7), (0.2, 1, 0.1)),
     ((1, 2, 2.7), (1e-3, 2e-3, 1)), ((1, 2, 2.7), (1e-9, 2e-9, 1)),
     ((1, 2, 2.7), (1e-13, 2e-13, 1)), ((1, 2, 2.7), (1, 2e-13, 1e-13)),
     ((1, 2, 2.7), (1e-3, 1, 2e-3)), ((1, 2, 2.7), (1e-10, 1, 2e-10)),
     ((1, 2, 2 + 1e-9), (1e-6, 1e-3, 1)), ((1, 1, 1.7), (0.3, 0.2, 1)),
     ((1, 1 + 1e-7, 1 + 3e-7), (0.3, 0.2, 1)), ((1, 1 + 1e-11, 1 + 3e-11), (1, 2, 1))],
)  # fmt: skip
def test_derivatives_by_the_elements_to_their_last_digits(moments, omega):
    """Against differences of the polynomials at 80 digits; the angular velocity is R^T d eta/dt."""
    spin = Spin("2026-01-01", (1.0, 0.0, 0.0, 0.0), omega)
    motion = FreeRotation(Body(moments=moments), spin)
    c = motion._constants[0]
    axes = c["axes"]
    with mpmath.workdps(80):
        elements = [mpmath.mpf(number) for number in motion.elements]
        if elements[4] > 0:  # 1 - X has all digits
            elements[4] = mpmath.exp(-mpmath.pi / 2 * mpmath.mpf(c["stretch"]) * c["fraction"])
        step, later = mpmath.mpf(10) ** -22, mpmath.mpf(10) ** -12
        for t in (0.01, 1.3, 5.0):
            columns, rates = (
                array[0, :, 3:]
                for array in motion.sensitivity_at([t], by="elements", angular_velocity=True)
            )
            to_body = motion.at([t]).matrix[0].T
            for k in range(5):
                size = step * (elements[k] if k == 3 else 1)
                vectors = []
                for time in (t - later, t, t + later):
                    sides = []
                    for sign in (1, -1):
                        moved = list(elements)
                        moved[k] += sign * size
                        sides.append(attitude_of(moved, time))
                    turn = product_of(sides[0], [sides[1][0], *(-x for x in sides[1][1:])])
                    vectors.append([x / size for x in turn[1:]])
                column = axes @ np.array(vectors[1], dtype=float)
                assert np.abs(columns[:, k] - column).max() < 1e-14 * np.abs(column).max()
                slope = [(a - b) / (2 * later) for a, b in zip(vectors[2], vectors[0], strict=True)]
                slope = to_body @ axes @ np.array(slope, dtype=float)
                assert np.abs(rates[:, k] - slope).max() < 1e-14 * np.abs(slope).max()


def test_derivatives_of_arcs_by_the_elements_of_the_first():
    spin = Spin("2026-01-01", WXYZ, (0.3, 0.2, 1.0))
    body, kick = Body(moments=(1, 2, 2.7)), Impulse(2.0, (0.1, -0.2, 0.3))
    free, arcs = FreeRotation(body, spin), Arcs(body, spin, [kick])
    t = np.array([1.0, 5.0])
    columns = arcs.sensitivity_at(t, by="elements")
    assert np.array_equal(columns[0], free.sensitivity_at(t[:1], by="elements")[0])
    # the changes of the state at the epoch, of which all columns are combinations
    _, rates = free.sensitivity_at([0.0], by="elements", angular_velocity=True)
    changes = free._sensitivity.of_elements.factors[0][:, :8]
    assert np.abs(changes[3:6] - rates[0]).max() < 1e-15
    assert np.abs(arcs.sensitivity_at(t) @ changes - columns).max() < 1e-13


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        ((1.0, 0.5, 0.0, 1.5, 0.1), "rho"),
        ((1.0, 0.5, 0.0, 0.0, 0.1), "rho"),
        ((1.0, 0.5, 0.0, 0.5, -0.1), "X"),
        ((1.0, 0.0, 0.0, 0.5, 0.1), "nutation_rate is 0"),
        ((1.0, 50.0, 0.0, 0.5, 0.1), "no body has"),
        ((1.0, 0.5, 0.0, 1.0 - 1e-16, 1.0 - 1e-16), "separatrix to all digits"),
        ((np.nan, 0.5, 0.0, 0.5, 0.1), "finite"),
        ((1.0, 0.5, 0.0, 0.5), "shape"),
    ],
)
def test_what_is_refused(elements, words):
    with pytest.raises(AttitudeError, match=words):
        FreeRotation.from_elements(elements, epoch="2026-01-01", wxyz=WXYZ)


def test_the_scale_of_the_body():
    elements = motion_of((10, 20, 26), (9, 2, 1)).elements
    body = FreeRotation.from_elements(
        elements, epoch="2026-01-01", wxyz=WXYZ, largest_moment="26 kg m2"
    ).body
    assert not body.relative and np.allclose(np.sort(body.moments), [10, 20, 26], rtol=1e-14)


@pytest.mark.parametrize("inertia", [3, 600, -600])
def test_columns_by_the_elements_in_any_unit_of_inertia(inertia):
    """No element has the unit of inertia; powers of two change no bit."""
    columns = [
        motion_of(size * np.array([10.0, 20.0, 26.0]), (9, 2, 1)).sensitivity_at(
            [0.1, 3.0], by="elements"
        )
        for size in (1.0, 2.0**inertia)
    ]
    assert np.array_equal(*columns)
