"""`propagate` under JAX: values, derivatives, transformations."""

import numpy as np
import pytest

import attitude
from attitude.errors import AttitudeError
from attitude.frames import quaternion

jax = pytest.importorskip("jax", reason="jax is not installed")
jnp = jax.numpy

MOMENTS = np.array([10.0, 20, 26])
WXYZ = np.array([1.0, 2, 3, 4])
T = np.array([0.0, 0.3, 2.0])
# Short- and long-axis mode, a principal axis, at rest.
RATES = np.array([[1.0, 15, 1], [9, 2, 1], [0, 0, 3], [0, 0, 0]])


@pytest.fixture(autouse=True)
def wide():
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


def _propagate(*arguments, **keywords):
    from attitude.jax import propagate

    return propagate(*arguments, **keywords)


@pytest.mark.parametrize("rates", RATES)
def test_derivatives_in_both_directions(rates):
    from jax.test_util import check_grads

    def both(*arguments):
        return _propagate(*arguments, angular_velocity=True)

    given = tuple(map(jnp.asarray, (MOMENTS, WXYZ, rates, T)))
    # differences of float64 with the steps of check_grads: 1e-5 of derivatives up to 100
    check_grads(both, given, order=1, modes=("fwd", "rev"), atol=1e-3, rtol=1e-5)


def test_derivatives_are_those_of_propagate():
    jacobian = jax.jacobian(_propagate, argnums=2)(MOMENTS, WXYZ, jnp.asarray(RATES[0]), T)
    wxyz, turns = attitude.propagate(MOMENTS, WXYZ, RATES[0], T, sensitivity=True)
    turn = np.concatenate([np.zeros((3, 1, 3)), turns[..., 3:6]], axis=1)
    expected = [0.5 * quaternion.multiply(turn[..., j], wxyz) for j in range(3)]
    assert np.max(np.abs(np.stack(expected, -1) - jacobian)) < 1e-14 * np.max(np.abs(turns))


def test_values_have_the_same_bits_under_jit_and_vmap():
    expected = attitude.propagate(MOMENTS, WXYZ, RATES, T)
    assert np.array_equal(_propagate(MOMENTS, WXYZ, RATES, T), expected)
    assert np.array_equal(jax.jit(_propagate)(MOMENTS, WXYZ, RATES, T), expected)
    over_rates = jax.vmap(_propagate, in_axes=(None, None, 0, None))
    assert np.array_equal(over_rates(MOMENTS, WXYZ, RATES, T), expected)
    twice = jax.vmap(over_rates, in_axes=(0, None, None, None))
    both = np.stack([MOMENTS, MOMENTS + np.array([0, 0, 1])])
    expected = attitude.propagate(both[:, None], WXYZ, RATES, T)
    assert np.array_equal(twice(both, WXYZ, RATES, T), expected)
    single = jax.vmap(_propagate, in_axes=(None, None, None, 0))(MOMENTS, WXYZ, RATES[0], T)
    assert single.shape == (3, 4)


def test_gradients_of_many_under_jit():
    def first(rates):
        return _propagate(MOMENTS, WXYZ, rates, 1.0)[0]

    many = jax.jit(jax.vmap(jax.grad(first)))(jnp.asarray(RATES))
    for rates, gradient in zip(RATES, many, strict=True):
        assert np.allclose(jax.grad(first)(jnp.asarray(rates)), gradient, rtol=1e-14, atol=0)


def test_bad_input():
    with pytest.raises(AttitudeError, match=r"omega0 has shape \(2,\)"):
        _propagate(MOMENTS, WXYZ, [1.0, 2.0], T)
    with pytest.raises(AttitudeError, match="do not broadcast"):
        _propagate(np.ones((2, 3)), WXYZ, np.ones((3, 3)), T)
    with pytest.raises(Exception, match="no body has a moment of inertia"):
        _propagate([1.0, 1, 5], WXYZ, RATES[0], T).block_until_ready()
    with pytest.raises(AttitudeError, match="complex"):
        _propagate(MOMENTS + 0j, WXYZ, RATES[0], T)
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(AttitudeError, match="float32"):
        _propagate(MOMENTS, WXYZ, RATES[0], T)
