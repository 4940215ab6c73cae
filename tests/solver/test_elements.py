"""The normal form: there and back, its limits, and the derivatives by the elements."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
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


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        ((1.0, 0.5, 0.0, 1.5, 0.1), "rho"),
        ((1.0, 0.5, 0.0, 0.0, 0.1), "rho"),
        ((1.0, 0.5, 0.0, 0.5, -0.1), "X"),
        ((1.0, 0.0, 0.0, 0.5, 0.1), "nutation_rate is 0"),
        ((1.0, 50.0, 0.0, 0.5, 0.1), "no body has"),
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
