"""`propagate` for JAX: exact attitudes with their derivatives, under jit, grad, jvp and vmap.

The compiled kernel runs in a callback; its derivatives are the closed forms of
`attitude.propagate(..., sensitivity=True)`, given to JAX as a rule (``custom_jvp``).  First
derivatives only, in both directions; on the processor, in float64.

>>> import jax
>>> jax.config.update("jax_enable_x64", True)
>>> import jax.numpy as jnp
>>> from attitude.jax import propagate
>>> state = jnp.array([10.0, 20, 26]), jnp.array([1.0, 0, 0, 0]), jnp.array([1.0, 15, 1])
>>> jax.jacobian(propagate, argnums=2)(*state, jnp.array([0.0, 1.0])).shape
(2, 4, 3)
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions._propagation import of_arrays
from attitude.motions._propagation import propagate as _compiled

try:
    import jax
    import jax.numpy as jnp
except ImportError as err:
    raise ImportError(f"attitude.jax needs jax: {validation.installing('jax')}.") from err

__all__ = ["propagate"]


def propagate(
    moments: Any, wxyz0: Any, omega0: Any, t: Any, *, angular_velocity: bool = False
) -> Any:
    """Exact attitudes of freely rotating bodies, as `attitude.propagate`, for JAX.

    Parameters
    ----------
    moments : (..., 3) array
        Principal moments of inertia about the body axes: any unit, any order.
    wxyz0 : (..., 4) array
        Attitude at t = 0, body to inertial, scalar first; of any length.
    omega0 : (..., 3) array
        Angular velocity at t = 0 over the body axes, rad/s.
    t : (..., T) array, or a number
        Seconds.  The last axis is time; the others broadcast with those of the bodies.
    angular_velocity : bool
        Whether the angular velocity is returned too.

    Returns
    -------
    wxyz : (..., T, 4) array
        Body to inertial, scalar first, unit length; without the T axis for a number t.
    omega : (..., T, 3) array, only with angular_velocity=True
        rad/s over the body axes.

    Raises
    ------
    AttitudeError
        Where 64-bit floats are switched off.  What `attitude.propagate` refuses (states that are
        not physical, rods in derivatives) JAX reports as an error of the callback, with the
        sentence in it.

    Notes
    -----
    Derivatives by all four arguments, to 4e-15 of the largest entry of a column; along wxyz0
    itself, whose length changes nothing, they vanish.
    """
    if not jax.config.read("jax_enable_x64"):
        raise AttitudeError(
            "JAX computes in float32, which has 7 digits; switch 64-bit floats on first: "
            'jax.config.update("jax_enable_x64", True).'
        )
    if any(map(np.iscomplexobj, (moments, wxyz0, omega0, t))):
        raise AttitudeError("an argument is complex; give real numbers.")
    arrays = [jnp.asarray(argument, dtype=jnp.float64) for argument in (moments, wxyz0, omega0, t)]
    return of_arrays(arrays, jnp.broadcast_to, _propagate, angular_velocity)


@jax.custom_jvp
def _propagate(moments, wxyz0, omega0, t):
    """Attitudes (..., T, 4) and angular velocities (..., T, 3) of (..., k) arrays."""
    return _call(False, (4,), (3,), arguments=(moments, wxyz0, omega0, t))


@_propagate.defjvp
def _tangents(primals, changes):
    moments, wxyz0 = primals[:2]
    d_moments, d_wxyz0, d_omega0, d_t = changes
    wxyz, omega, turns, rates = _call(True, (4,), (3,), (3, 9), (3, 9), arguments=primals)
    # the change of the first attitude as a rotation vector over inertial axes
    square = jnp.sum(wxyz0 * wxyz0, axis=-1, keepdims=True)
    inverse = wxyz0 * jnp.array([1.0, -1.0, -1.0, -1.0]) / square
    turn = 2.0 * _product(d_wxyz0, inverse)[..., 1:]
    change = jnp.concatenate([turn, d_omega0, d_moments], axis=-1)
    turned = jnp.einsum("...tij,...j->...ti", turns, change)
    d_omega = jnp.einsum("...tij,...j->...ti", rates, change)
    nothing = jnp.zeros((*turned.shape[:-1], 1))
    d_wxyz = 0.5 * _product(jnp.concatenate([nothing, turned], axis=-1), wxyz)
    # and with the epochs: the angular velocity, and Euler's equations
    spin = jnp.concatenate([nothing, omega], axis=-1)
    d_wxyz += 0.5 * d_t[..., None] * _product(wxyz, spin)
    inertia = moments[..., None, :]
    inverses = jnp.where(inertia > 0.0, 1.0 / jnp.where(inertia > 0.0, inertia, 1.0), 0.0)
    d_omega += d_t[..., None] * inverses * jnp.cross(inertia * omega, omega)
    return (wxyz, omega), (d_wxyz, d_omega)


def _call(sensitivity, *widths, arguments):
    """The compiled results, arrays (..., T, *width) of each width."""
    lead, count = arguments[0].shape[:-1], arguments[3].shape[-1]
    kinds = tuple(jax.ShapeDtypeStruct((*lead, count, *width), jnp.float64) for width in widths)
    run = partial(_in_numpy, sensitivity)
    return jax.pure_callback(run, kinds, *arguments, vmap_method="expand_dims")


def _in_numpy(sensitivity, *arguments):
    arrays = [np.asarray(argument, dtype=np.float64) for argument in arguments]
    # vmap adds axes of length 1 to what it does not map
    lead = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
    arrays[:3] = [np.broadcast_to(array, (*lead, array.shape[-1])) for array in arrays[:3]]
    outputs = _compiled(*arrays, angular_velocity=True, sensitivity=sensitivity)
    return tuple(np.ascontiguousarray(output) for output in outputs)


def _product(a, b):
    """The product of quaternions (..., 4), scalar first."""
    parts = (jnp.moveaxis(array, -1, 0) for array in (a, b))
    return jnp.stack(quaternion.product(*parts), axis=-1)
