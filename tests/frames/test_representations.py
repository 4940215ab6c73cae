"""Every form of an attitude goes there and back, agrees with scipy, and means what it says."""

import numpy as np
import pytest
from astropy import units as u
from scipy.spatial.transform import Rotation

from attitude import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms

# A few units in the last place: what a handful of operations on numbers below 1 can lose.
ROUNDING = 2e-15


def attitudes(count=2000, seed=6):
    """Random attitudes, and the nasty ones: no turn, tiny turns, half turns, gimbal lock."""
    random = np.random.default_rng(seed)
    usual = random.normal(size=(count, 4))
    tiny = np.concatenate([np.ones((60, 1)), random.normal(size=(60, 3))], axis=1)
    tiny[:, 1:] *= 10.0 ** -np.arange(60)[:, None] / 4
    half = random.normal(size=(40, 4))
    half[:, 0] = 0.0
    axes = np.concatenate([np.eye(4), -np.eye(4)])
    exact = [[1, 1, 0, 0], [1, 0, 1, 0], [1, 0, 0, 1], [1, 1, 1, 1], [1, -1, 1, 1], [0, 1, 1, 0]]
    near = np.array(exact)[:, None] * np.ones((12, 1))
    near = near + 10.0 ** -np.arange(5, 17)[:, None] * random.normal(size=(6, 12, 4))
    every = np.concatenate([usual, tiny, half, axes, np.array(exact, float), near.reshape(-1, 4)])
    return every / np.linalg.norm(every, axis=1, keepdims=True)


def angle_between(p, q):
    """The turn in rad that leads from one attitude to the other."""
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return 2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0]))


@pytest.mark.parametrize("sequence", forms.EULER_SEQUENCES)
@pytest.mark.parametrize("letters", [str.upper, str.lower])
def test_euler_angles_there_and_back(sequence, letters):
    q = attitudes()
    angles = forms.to_euler(letters(sequence), q)
    assert np.max(angle_between(quaternion.from_euler(letters(sequence), angles), q)) < ROUNDING
    middle = angles[:, 1] + (0.5 * np.pi if sequence[0] != sequence[2] else 0.0)
    assert np.all((middle >= -1e-15) & (middle <= np.pi + 1e-15))
    assert np.all(np.abs(angles[:, [0, 2]]) <= np.pi)


@pytest.mark.parametrize("sequence", forms.EULER_SEQUENCES)
def test_euler_angles_are_those_of_scipy(sequence):
    random = np.random.default_rng(3)
    angles = random.uniform(-3.0, 3.0, (500, 3))
    theirs = Rotation.from_euler(sequence, angles)
    assert (
        np.max(angle_between(quaternion.from_euler(sequence, angles), forms.from_rotation(theirs)))
        < 3e-15
    )
    mine = forms.to_euler(sequence, forms.from_rotation(theirs))
    # away from gimbal lock by 1e-2 the angles themselves agree to 1e-13 rad
    lock = np.sin(mine[:, 1]) if sequence[0] == sequence[2] else np.cos(mine[:, 1])
    apart = (mine - theirs.as_euler(sequence) + np.pi) % (2.0 * np.pi) - np.pi
    assert np.max(np.abs(apart[np.abs(lock) > 1e-2])) < 1e-13


def test_a_sequence_by_numbers_is_the_same_and_its_order_is_that_of_the_paper():
    a, b, c = 0.3, 0.7, -1.1
    x, z = np.eye(3)[[0, 2]]
    turns = [Rotation.from_rotvec(angle * axis) for angle, axis in ((a, z), (b, x), (c, z))]
    wanted = (turns[0] * turns[1] * turns[2]).as_matrix()
    assert np.allclose(forms.to_matrix(quaternion.from_euler("313", (a, b, c))), wanted, atol=1e-15)
    assert np.allclose(forms.to_matrix(quaternion.from_euler("313", (a, b, c))), wanted, atol=1e-15)


@pytest.mark.parametrize(
    ("there", "back"),
    [
        (forms.to_matrix, quaternion.from_matrix),
        (forms.to_dcm, forms.from_dcm),
        (forms.to_rotation_vector, forms.from_rotation_vector),
        (forms.to_axis_angle, lambda pair: forms.from_axis_angle(*pair)),
        (forms.to_mrp, forms.from_mrp),
        (forms.to_pole, lambda angles: forms.from_pole(*angles)),
        (forms.to_rotation, forms.from_rotation),
        (forms.to_xyzw, forms.from_xyzw),
    ],
)
def test_there_and_back(there, back):
    q = attitudes()
    assert np.max(angle_between(back(there(q)), q)) < ROUNDING
    one = q[7]
    assert angle_between(back(there(one)), one) < ROUNDING


def test_rotation_vectors_keep_their_relative_accuracy_when_tiny():
    vector = np.array([3.0, -4.0, 12.0]) * 10.0 ** -np.arange(0, 300, 13, dtype=float)[1:, None]
    back = forms.to_rotation_vector(forms.from_rotation_vector(vector))
    assert np.max(np.abs(back / vector - 1.0)) < 1e-15


def test_dcm_is_the_papers_matrix_and_matrix_its_transpose():
    quarter = forms.from_axis_angle((0, 0, 1), np.pi / 2)
    assert np.allclose(forms.to_matrix(quarter) @ (1, 0, 0), (0, 1, 0), atol=3e-16)
    assert np.allclose(forms.to_dcm(quarter) @ (0, 1, 0), (1, 0, 0), atol=3e-16)


def test_the_pole_is_where_body_z_points_and_mrp_stay_inside_the_unit_ball():
    q = attitudes()
    ra, dec, _ = forms.to_pole(q)
    z = quaternion.rotate(q, (0.0, 0.0, 1.0))
    seen = np.stack([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)], axis=-1)
    assert np.max(np.abs(seen - z)) < ROUNDING
    assert np.all((ra >= 0) & (ra < 2 * np.pi))
    assert np.max(np.linalg.norm(forms.to_mrp(q), axis=1)) <= 1.0 + 1e-15


@pytest.mark.parametrize("letters", [str.upper, str.lower])
@pytest.mark.parametrize("sequence", forms.EULER_SEQUENCES)
def test_euler_rates_are_the_derivatives_of_the_angles(sequence, letters):
    sequence = letters(sequence)
    random = np.random.default_rng(11)
    angles = random.uniform(0.3, 1.2, (50, 3))
    rates = random.normal(size=(50, 3))
    omega = forms.angular_velocity_from_euler_rates(sequence, angles, rates)
    h = 1e-5  # central difference: error h^2 / 6 times third derivatives of order 10
    ahead = quaternion.from_euler(sequence, angles + h * rates)
    behind = quaternion.from_euler(sequence, angles - h * rates)
    numeric = forms.angular_velocity_from_quaternion_rate(
        quaternion.from_euler(sequence, angles), (ahead - behind) / (2 * h)
    )
    assert np.max(np.abs(omega - numeric)) < 1e-8
    assert np.max(np.abs(forms.euler_rates(sequence, angles, omega) - rates)) < 1e-13


def test_quaternion_rates_there_and_back_and_the_two_frames_of_rates():
    q = attitudes(100)
    omega = np.random.default_rng(5).normal(size=(len(q), 3))
    rate = forms.quaternion_rate(q, omega)
    assert np.max(np.abs(forms.angular_velocity_from_quaternion_rate(q, rate) - omega)) < 5e-15
    inertial = forms.body_to_inertial_rates(q, omega)
    assert np.max(np.abs(forms.inertial_to_body_rates(q, inertial) - omega)) < 5e-15


def test_rates_may_have_a_unit():
    q, w = (0.5, 0.5, -0.5, 0.5), np.array([1.0, 2.0, 3.0])
    in_degrees = np.degrees(w) * u.deg / u.s
    rate = forms.quaternion_rate(q, w)
    np.testing.assert_allclose(forms.quaternion_rate(q, in_degrees), rate, rtol=1e-15)
    found = forms.angular_velocity_from_quaternion_rate(q, 60.0 * rate / u.min)
    np.testing.assert_allclose(found, w, rtol=1e-15)
    for function in (forms.euler_rates, forms.angular_velocity_from_euler_rates):
        found = function("ZXZ", (0.1, 0.2, 0.3), in_degrees)
        np.testing.assert_allclose(found, function("ZXZ", (0.1, 0.2, 0.3), w), rtol=1e-15)


def test_long_rodrigues_parameters_are_nearly_a_whole_turn():
    np.testing.assert_allclose(forms.from_mrp((1e160, 0, 0)), (-1.0, 2e-160, 0.0, 0.0), rtol=4e-16)
    np.testing.assert_array_equal(forms.from_mrp((3.0, 0, 0)), (-0.8, 0.6, 0.0, 0.0))


def test_continuous_signs_follow_a_spin_through_many_turns():
    t = np.linspace(0.0, 30.0, 400)
    path = forms.from_axis_angle((1, 2, 3), t)
    flipped = path * np.where(np.random.default_rng(1).random(400) < 0.5, -1.0, 1.0)[:, None]
    flipped[0] = path[0]
    assert np.array_equal(forms.continuous(flipped), path)


def test_unit_leaves_rounded_quaternions_bit_for_bit_and_tells_how_far_others_are():
    q = attitudes()
    assert np.array_equal(quaternion.unit(q), q)
    assert np.max(np.abs(np.linalg.norm(quaternion.unit(q * 7.0), axis=1) - 1.0)) < 4e-16
    with pytest.raises(AttitudeError, match=r"off 1 by 0\.01"):
        quaternion.unit(q * 1.01, tolerance=1e-3)
    for bad in ([0, 0, 0, 0], [np.nan, 0, 0, 1], [np.inf, 0, 0, 0]):
        with pytest.raises(AttitudeError, match="no attitude"):
            quaternion.unit(bad)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: quaternion.from_matrix(np.diag([1.0, 1.0, -1.0])), "reflection"),
        (lambda: quaternion.from_matrix(2.0 * np.eye(3)), "not a rotation"),
        (lambda: quaternion.from_euler("ZZX", (1, 2, 3)), "sequence"),
        (lambda: forms.to_euler("Q", (1, 0, 0, 0)), "sequence"),
        (lambda: forms.from_axis_angle((0, 0, 0), 1.0), "axis is zero"),
        (lambda: forms.euler_rates("ZXZ", (0.1, 0.0, 0.2), (1, 2, 3)), "gimbal lock"),
        (lambda: forms.euler_rates("ZXZ", np.ones((2, 3)), np.ones((3, 3))), r"angles \(2,\)"),
        (
            lambda: forms.angular_velocity_from_euler_rates(
                "ZXZ", np.ones((2, 3)), np.ones((3, 3))
            ),
            r"rates \(3,\)",
        ),
        (lambda: forms.from_axis_angle(np.ones((2, 3)), (1, 2, 3)), r"axis \(2,\)"),
        (lambda: forms.from_pole((1, 2), (0, 1, 2), 0), r"declination \(3,\)"),
        (lambda: forms.from_rotation_vector((1e200, 0, 0)), "longer than 1e154 rad"),
        (lambda: forms.from_rotation("x"), "scipy Rotation"),
        (lambda: forms.to_mrp([1, 2, 3]), "shape"),
        (lambda: forms.body_to_inertial_rates((1, 0, 0, 0), (1, 2, 3, 4)), "angular_velocity has"),
        (lambda: forms.inertial_to_body_rates((1, 0, 0, 0), (1, 2, 3, 4)), "angular_velocity has"),
        (lambda: quaternion.multiply((1, 0, 0), (1, 0, 0, 0)), r"p has shape \(3,\)"),
        (lambda: quaternion.multiply(np.ones((3, 4)), np.ones((2, 4))), "the same number of each"),
        (lambda: quaternion.rotate((1, 0, 0, 0), (1j, 0, 0)), "give real numbers"),
        (lambda: quaternion.rotate(np.ones((3, 4)), np.ones((2, 3))), "the same number of each"),
        (lambda: quaternion.conjugate((1j, 0, 0, 0)), "give real numbers"),
        (lambda: quaternion.matrix((1, 0, 0)), r"q has shape \(3,\)"),
    ],
)
def test_what_is_refused(call, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        call()
