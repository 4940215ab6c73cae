"""Quaternion algebra against scipy, and the conventions that the names promise."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from attitude import AttitudeError
from attitude.frames import quaternion

_number = st.floats(-1, 1, allow_subnormal=False)


def _unit(row):
    size = math.hypot(*row)
    return np.array(row) / size if size > 1e-3 else np.array([1.0, 0.0, 0.0, 0.0])


units = st.lists(_number, min_size=4, max_size=4).map(_unit)
# Not so small that a product of a component is subnormal, with fewer digits.
_component = st.floats(-1e3, 1e3).map(lambda x: x if abs(x) > 1e-200 else 0.0)
vectors = st.lists(_component, min_size=3, max_size=3).map(np.array)


def _scipy(q):
    return Rotation.from_quat(np.asarray(q)[..., [1, 2, 3, 0]])


@given(units, units, vectors)
def test_the_product_turns_by_the_second_first(p, q, v):
    one = quaternion.rotate(quaternion.multiply(p, q), v)
    two = quaternion.rotate(p, quaternion.rotate(q, v))
    assert np.max(np.abs(one - two)) <= 2e-15 * math.hypot(*v)


@given(units, vectors)
def test_rotation_and_matrix_are_those_of_scipy(q, v):
    size = math.hypot(*v)
    assert np.max(np.abs(quaternion.matrix(q) - _scipy(q).as_matrix())) <= 1e-15
    assert np.max(np.abs(quaternion.rotate(q, v) - _scipy(q).apply(v))) <= 2e-15 * size
    assert np.max(np.abs(quaternion.matrix(q) @ v - quaternion.rotate(q, v))) <= 2e-15 * size


@given(units, vectors)
def test_the_conjugate_turns_back(q, v):
    back = quaternion.rotate(quaternion.conjugate(q), quaternion.rotate(q, v))
    assert np.max(np.abs(back - v)) <= 3e-15 * math.hypot(*v)


@given(units)
def test_from_matrix_and_back(q):
    """Up to the sign: w >= 0."""
    found = quaternion.from_matrix(quaternion.matrix(q))
    assert found[0] >= 0.0
    assert np.max(np.abs(found * np.sign(found @ q) - q)) <= 1e-15


@given(units, st.integers(-1000, 1000))
def test_a_quaternion_of_any_length(q, power):
    """Scaled by a power of two it is the same attitude, of the same sign, with no overflow."""
    found = quaternion.unit(np.ldexp(q, power))
    assert np.max(np.abs(found - q)) <= 3e-16
    assert found @ found == pytest.approx(1.0, abs=1e-15)


def test_leading_axes_broadcast():
    rng = np.random.default_rng(3)
    q = rng.normal(size=(5, 1, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    v = rng.normal(size=(7, 3))
    turned = quaternion.rotate(q, v)
    assert turned.shape == (5, 7, 3)
    for i in range(5):
        for j in range(7):
            one = quaternion.rotate(q[i, 0], v[j])
            assert np.max(np.abs(turned[i, j] - one)) < 1e-15
    assert quaternion.multiply(q, q[0]).shape == (5, 1, 4)
    assert quaternion.matrix(q).shape == (5, 1, 3, 3)


def test_a_vector_for_each_of_several_attitudes():
    """One attitude and many vectors, many attitudes and one vector."""
    q = np.array([math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    many = quaternion.rotate(q, np.eye(3))
    assert np.allclose(many, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], rtol=0, atol=4e-16)
    assert quaternion.rotate(np.stack([q, q]), (1, 0, 0)).shape == (2, 3)


@pytest.mark.parametrize(
    ("wxyz", "message"),
    [
        ((0, 0, 0, 0), "wxyz holds .* no attitude"),
        ((0, -0.0, 0, 0), "wxyz holds .* no attitude"),
        ((1, 0, 0), r"wxyz has shape \(3,\)"),
        ((1, 0, 0, math.nan), "wxyz holds .*nan"),
        ((1, 0, 0, math.inf), "wxyz holds .*inf"),
    ],
)
def test_what_is_no_attitude(wxyz, message):
    with pytest.raises(AttitudeError, match=message):
        quaternion.unit(wxyz)


@given(st.sampled_from([0.0, 1e-8, 1e-4, 0.9, 2.0]), units)
def test_how_far_from_a_rotation_a_matrix_may_be(off, q):
    """Rounded to six digits or so: up to 1e-6 in R^T R; the rest is refused."""
    matrix = quaternion.matrix(q) * (1.0 + off)
    if off <= 1e-8:
        found = quaternion.from_matrix(matrix)
        assert np.max(np.abs(found * np.sign(found @ q) - q)) <= 2 * off + 1e-15
    else:
        with pytest.raises(AttitudeError, match="matrix is not a rotation"):
            quaternion.from_matrix(matrix)
    with pytest.raises(AttitudeError, match="matrix is a reflection"):
        quaternion.from_matrix(-quaternion.matrix(q))
