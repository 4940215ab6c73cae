"""`propagate` for PyTorch: values, derivatives, transformations."""

import numpy as np
import pytest

import attitude
from attitude.errors import AttitudeError
from attitude.frames import quaternion

torch = pytest.importorskip("torch", reason="torch is not installed")

# torch warns of itself at its first forward derivative
pytestmark = pytest.mark.filterwarnings("ignore:.*torch.jit.script")

MOMENTS = np.array([10.0, 20, 26])
WXYZ = np.array([1.0, 2, 3, 4])
T = np.array([0.0, 0.3, 2.0])
# Short- and long-axis mode, a principal axis, at rest.
RATES = np.array([[1.0, 15, 1], [9, 2, 1], [0, 0, 3], [0, 0, 0]])


def _propagate(*arguments, **keywords):
    from attitude.torch import propagate

    return propagate(*arguments, **keywords)


def _tensors(*arrays):
    return tuple(torch.tensor(each, requires_grad=True) for each in arrays)


@pytest.mark.parametrize("rates", RATES)
def test_derivatives_in_both_directions(rates):
    def both(*arguments):
        return _propagate(*arguments, angular_velocity=True)

    given = _tensors(MOMENTS, WXYZ, rates, T)
    # differences with steps of 1e-6: 1e-8 of derivatives up to 100
    assert torch.autograd.gradcheck(both, given, atol=1e-4, rtol=1e-5, check_forward_ad=True)


def test_derivatives_are_those_of_propagate():
    (rates,) = _tensors(RATES[0])
    jacobian = torch.autograd.functional.jacobian(
        lambda w: _propagate(MOMENTS, WXYZ, w, T), rates
    ).numpy()
    wxyz, turns = attitude.propagate(MOMENTS, WXYZ, RATES[0], T, sensitivity=True)
    turn = np.concatenate([np.zeros((3, 1, 3)), turns[..., 3:6]], axis=1)
    expected = [0.5 * quaternion.multiply(turn[..., j], wxyz) for j in range(3)]
    assert np.max(np.abs(np.stack(expected, -1) - jacobian)) < 1e-14 * np.max(np.abs(turns))


def test_values_have_the_same_bits_under_vmap():
    expected = attitude.propagate(MOMENTS, WXYZ, RATES, T)
    given = tuple(torch.tensor(each) for each in (MOMENTS, WXYZ, RATES, T))
    assert np.array_equal(_propagate(*given).numpy(), expected)
    mapped = torch.func.vmap(_propagate, in_dims=(None, None, 0, None))(*given)
    assert np.array_equal(mapped.numpy(), expected)
    gradients = torch.func.vmap(torch.func.grad(lambda w: _propagate(MOMENTS, WXYZ, w, 1.0)[0]))(
        given[2]
    )
    for rates, gradient in zip(given[2], gradients, strict=True):
        one = torch.func.grad(lambda w: _propagate(MOMENTS, WXYZ, w, 1.0)[0])(rates)
        assert torch.allclose(one, gradient, rtol=1e-14, atol=0.0)


def test_shared_epochs_and_broadcast_bodies_sum_their_gradients():
    moments, wxyz, rates, t = _tensors(MOMENTS, WXYZ, RATES, T)
    torch.sum(_propagate(moments, wxyz, rates, t)[..., 1]).backward()
    assert [tuple(each.grad.shape) for each in (moments, wxyz, rates, t)] == [
        (3,), (4,), (4, 3), (3,)
    ]  # fmt: skip
    total = torch.zeros(3, dtype=torch.float64)
    for row in RATES:
        (one,) = _tensors(MOMENTS)
        torch.sum(_propagate(one, WXYZ, row, T)[..., 1]).backward()
        total += one.grad
    assert torch.allclose(total, moments.grad, rtol=1e-12)


def test_numbers_of_a_list_may_be_tensors():
    moments = (*_tensors(*MOMENTS[:2]), MOMENTS[2])
    stacked = torch.tensor(MOMENTS, requires_grad=True)
    for one in (moments, stacked):
        torch.sum(_propagate(one, WXYZ, RATES[0], T)[..., 1]).backward()
    assert [each.grad for each in moments[:2]] == list(stacked.grad[:2])


def test_second_derivatives_are_refused():
    def loss(w):
        return torch.sum(_propagate(MOMENTS, WXYZ, w, T)[..., 0] ** 2)

    (rates,) = _tensors(RATES[0])
    (gradient,) = torch.autograd.grad(loss(rates), rates, create_graph=True)
    for second in (
        lambda: torch.autograd.functional.hessian(loss, rates),
        lambda: torch.func.jacrev(torch.func.jacrev(loss))(rates),
        lambda: torch.func.hessian(loss)(rates),
        lambda: torch.func.jacfwd(torch.func.jacfwd(loss))(rates),
        lambda: torch.sum(gradient**2).backward(),
    ):
        with pytest.raises(AttitudeError, match="first derivatives only"):
            second()


def test_bad_input():
    with pytest.raises(AttitudeError, match="moments is 'a'"):
        _propagate("a", WXYZ, RATES[0], T)
    with pytest.raises(AttitudeError, match=r"omega0 has shape \(2,\)"):
        _propagate(MOMENTS, WXYZ, [1.0, 2.0], T)
    with pytest.raises(AttitudeError, match="do not broadcast"):
        _propagate(np.ones((2, 3)), WXYZ, np.ones((3, 3)), T)
    with pytest.raises(AttitudeError, match="no body has a moment of inertia"):
        _propagate([1.0, 1, 5], WXYZ, RATES[0], T)
    with pytest.raises(AttitudeError, match="float64"):
        _propagate(torch.ones(3), WXYZ, RATES[0], T)
