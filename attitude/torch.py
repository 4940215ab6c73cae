"""`propagate` for PyTorch: exact attitudes with their derivatives, for autograd and torch.func.

The compiled kernel runs on the processor, in float64; its derivatives are the closed forms of
`attitude.propagate(..., sensitivity=True)`.  First derivatives only.

>>> import torch
>>> from attitude.torch import propagate
>>> rate = torch.tensor([1.0, 15, 1], dtype=torch.float64, requires_grad=True)
>>> wxyz = propagate([10, 20, 26], [1, 0, 0, 0], rate, [0.0, 1.0])
>>> wxyz[1, 0].backward()
>>> rate.grad.shape
torch.Size([3])
"""

from __future__ import annotations

from typing import Any

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.motions._propagation import of_arrays
from attitude.motions._propagation import propagate as _compiled

try:
    import torch
except ImportError as err:
    raise ImportError(f"attitude.torch needs torch: {validation.installing('torch')}.") from err

__all__ = ["propagate"]


def propagate(
    moments: Any, wxyz0: Any, omega0: Any, t: Any, *, angular_velocity: bool = False
) -> Any:
    """Exact attitudes of freely rotating bodies, as `attitude.propagate`, for tensors.

    Parameters
    ----------
    moments : (..., 3) tensor or array_like
        Principal moments of inertia about the body axes: any unit, any order.
    wxyz0 : (..., 4) tensor or array_like
        Attitude at t = 0, body to inertial, scalar first; of any length.
    omega0 : (..., 3) tensor or array_like
        Angular velocity at t = 0 over the body axes, rad/s.
    t : (..., T) tensor or array_like, or a number
        Seconds.  The last axis is time; the others broadcast with those of the bodies.
    angular_velocity : bool
        Whether the angular velocity is returned too.

    Returns
    -------
    wxyz : (..., T, 4) float64 tensor
        Body to inertial, scalar first, unit length; without the T axis for a number t.
    omega : (..., T, 3) float64 tensor, only with angular_velocity=True
        rad/s over the body axes.

    Raises
    ------
    AttitudeError
        For tensors that are not float64 or not in the memory of the processor, shapes that do not
        broadcast, what `attitude.propagate` refuses (for derivatives, rods too), and second
        derivatives.

    Notes
    -----
    Derivatives by all four arguments, to 4e-15 of the largest entry of a column; along wxyz0
    itself, whose length changes nothing, they vanish.
    """
    arguments = (("moments", moments), ("wxyz0", wxyz0), ("omega0", omega0), ("t", t))
    tensors = [_tensor(value, name) for name, value in arguments]
    return of_arrays(tensors, torch.broadcast_to, _Propagation.apply, angular_velocity)


def _tensor(value, name):
    if not isinstance(value, torch.Tensor):
        if isinstance(value, (list, tuple)) and any(map(torch.is_tensor, value)):
            return torch.stack([_tensor(number, name) for number in value])
        return torch.as_tensor(validation.real(value, name, finite=False))
    if value.dtype != torch.float64:
        raise AttitudeError(
            f"{name} is a tensor of {value.dtype}, which has too few digits; give float64, such as "
            f"{name}.double()."
        )
    if value.device.type != "cpu":
        raise AttitudeError(
            f"{name} is on the device {value.device}; the kernel runs on the processor: give "
            f"{name}.cpu()."
        )
    return value


class _Propagation(torch.autograd.Function):
    """Attitudes (..., T, 4) and angular velocities (..., T, 3) of tensors (..., k)."""

    @staticmethod
    def forward(moments, wxyz0, omega0, t):
        return _call((moments, wxyz0, omega0, t), sensitivity=False)

    @staticmethod
    def setup_context(ctx, inputs, output):
        ctx.save_for_backward(*inputs, *output)
        ctx.save_for_forward(*inputs, *output)

    @staticmethod
    def backward(ctx, g_wxyz, g_omega):
        moments, wxyz0, omega0, t, wxyz, omega = ctx.saved_tensors
        turns, rates = _Derivatives.apply(moments, wxyz0, omega0, t)
        g_turn = torch.einsum("...ka,...k->...a", _left(wxyz), g_wxyz)
        by_change = torch.einsum("...tij,...ti->...j", turns, g_turn)
        by_change = by_change + torch.einsum("...tij,...ti->...j", rates, g_omega)
        by_wxyz0 = torch.einsum("...ak,...a->...k", _turn_by_wxyz(wxyz0), by_change[..., :3])
        slope, acceleration = _in_time(moments, wxyz, omega)
        by_t = torch.sum(g_wxyz * slope, -1) + torch.sum(g_omega * acceleration, -1)
        return by_change[..., 6:], by_wxyz0, by_change[..., 3:6], by_t.sum_to_size(t.shape)

    @staticmethod
    def jvp(ctx, d_moments, d_wxyz0, d_omega0, d_t):
        moments, wxyz0, omega0, t, wxyz, omega = ctx.saved_tensors
        turns, rates = _Derivatives.apply(moments, wxyz0, omega0, t)
        tangents = zip((d_wxyz0, d_omega0, d_moments), (wxyz0, omega0, moments), strict=True)
        changes = [torch.zeros_like(like) if d is None else d for d, like in tangents]
        turn = torch.einsum("...ak,...k->...a", _turn_by_wxyz(wxyz0), changes[0])
        change = torch.cat([turn, changes[1], changes[2]], -1)
        turned = torch.einsum("...tij,...j->...ti", turns, change)
        d_wxyz = torch.einsum("...ka,...a->...k", _left(wxyz), turned)
        d_omega = torch.einsum("...tij,...j->...ti", rates, change)
        if d_t is not None:
            slope, acceleration = _in_time(moments, wxyz, omega)
            d_wxyz = d_wxyz + d_t[..., None] * slope
            d_omega = d_omega + d_t[..., None] * acceleration
        return d_wxyz, d_omega

    @staticmethod
    def vmap(info, in_dims, *arguments):
        return _Propagation.apply(*_moved(info, in_dims, arguments)), (0, 0)


class _Derivatives(torch.autograd.Function):
    """Those (..., T, 3, 9) of attitudes and angular velocities; they have none themselves.

    A function of its own, because the rules of `_Propagation` see wrapped tensors in torch.func.
    """

    @staticmethod
    def forward(moments, wxyz0, omega0, t):
        return _call((moments, wxyz0, omega0, t), sensitivity=True)[2:]

    @staticmethod
    def setup_context(ctx, inputs, output):
        pass

    @staticmethod
    def backward(ctx, *gradients):
        raise AttitudeError(
            "attitude.torch has first derivatives only; give a loss that needs no second ones, or "
            "take differences of gradients."
        )

    jvp = backward

    @staticmethod
    def vmap(info, in_dims, *arguments):
        return _Derivatives.apply(*_moved(info, in_dims, arguments)), (0, 0)


def _moved(info, in_dims, arguments):
    """The arguments with the mapped axis first, of length 1 for epochs that are not mapped."""
    moved = [
        argument[None] if dim is None else argument.movedim(dim, 0)
        for argument, dim in zip(arguments, in_dims, strict=True)
    ]
    bodies = [argument.expand(info.batch_size, *argument.shape[1:]) for argument in moved[:3]]
    return *bodies, moved[3]


def _call(arguments, sensitivity):
    arrays = [tensor.detach().numpy() for tensor in arguments]
    outputs = _compiled(*arrays, angular_velocity=True, sensitivity=sensitivity)
    return tuple(torch.from_numpy(np.ascontiguousarray(output)) for output in outputs)


def _left(wxyz):
    """(..., 4, 3): changes of a quaternion with a rotation vector over inertial axes."""
    w, x, y, z = wxyz.unbind(-1)
    rows = [(-x, -y, -z), (w, z, -y), (-z, w, x), (y, -x, w)]
    return 0.5 * torch.stack([torch.stack(row, -1) for row in rows], -2)


def _right(wxyz):
    """(..., 4, 3): changes of a quaternion with a rotation vector over body axes."""
    w, x, y, z = wxyz.unbind(-1)
    rows = [(-x, -y, -z), (w, -z, y), (z, w, -x), (-y, x, w)]
    return 0.5 * torch.stack([torch.stack(row, -1) for row in rows], -2)


def _turn_by_wxyz(wxyz):
    """(..., 3, 4): the rotation vector, inertial axes, of changes of a quaternion of any length."""
    square = torch.sum(wxyz * wxyz, -1)[..., None, None]
    return 4.0 * _left(wxyz).transpose(-1, -2) / square


def _in_time(moments, wxyz, omega):
    """Rates of change of attitudes and, by Euler's equations, of angular velocities."""
    slope = torch.einsum("...ka,...a->...k", _right(wxyz), omega)
    inertia = moments[..., None, :].expand(omega.shape)
    momentum = torch.linalg.cross(inertia * omega, omega)
    still = torch.zeros_like(momentum)
    return slope, torch.where(inertia > 0.0, momentum / inertia, still)
