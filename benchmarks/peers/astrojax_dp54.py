"""astrojax: the adaptive Dormand-Prince 5(4) of a JAX library, compiled by XLA."""

from functools import cache

import numpy as np

from benchmarks.peers import Missing, Peer

# One shape for every number of epochs, so that XLA compiles once: the last epoch is repeated.
_CHUNK = 1000


def peers():
    try:
        import astrojax  # noqa: F401
    except ImportError as err:
        raise Missing("package astrojax is not installed") from err
    return [
        Peer("astrojax DP54", f"{tolerance:.0e}", _solver(tolerance), 2e3)
        for tolerance in (1e-6, 1e-9, 1e-12)
    ]


@cache
def _advance(tolerance):
    """(moments, time, state, step, epochs (_CHUNK,)) -> (time, state, step), states (_CHUNK, 7)."""
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp
    from astrojax.attitude_dynamics import (
        AttitudeDynamicsConfig,
        SpacecraftInertia,
        create_attitude_dynamics,
    )
    from astrojax.config import set_dtype
    from astrojax.integrators import AdaptiveConfig, dp54_step

    set_dtype(jnp.float64)
    control = AdaptiveConfig(abs_tol=tolerance, rel_tol=tolerance, max_step=np.inf)

    @jax.jit
    def advance(moments, time, state, step, epochs):
        inertia = SpacecraftInertia(I=jnp.diag(moments))
        config = AttitudeDynamicsConfig.torque_free(inertia)
        dynamics = create_attitude_dynamics(config, lambda _: jnp.zeros(3))

        def to_epoch(carry, epoch):
            def one(carry):
                time, state, step = carry
                left = epoch - time
                asked = jnp.minimum(step, left)
                taken = dp54_step(dynamics, time, state, asked, control)
                # The rest of the way to an epoch is short: it does not shorten the steps after it.
                shortened = (asked < step) & (taken.dt_used == asked)
                after = jnp.where(shortened, jnp.maximum(taken.dt_next, step), taken.dt_next)
                arrived = taken.dt_used >= left
                return jnp.where(arrived, epoch, time + taken.dt_used), taken.state, after

            carry = jax.lax.while_loop(lambda carry: carry[0] < epoch, one, carry)
            return carry, carry[1]

        return jax.lax.scan(to_epoch, (time, state, step), epochs)

    return advance


def _solver(tolerance):
    def solve(moments, wxyz0, omega0, t):
        advance = _advance(tolerance)
        # Its absolute tolerance is one number: the unit of time makes the rates 1.
        speed = np.linalg.norm(omega0)
        moments = np.asarray(moments, float)
        state = np.concatenate([wxyz0, np.asarray(omega0, float) / speed])
        carry = (np.float64(0.0), state, np.float64(0.1))
        out = np.empty((len(t), 4))
        for begin in range(0, len(t), _CHUNK):
            part = t[begin : begin + _CHUNK] * speed
            epochs = np.append(part, np.full(_CHUNK - len(part), part[-1]))
            carry, states = advance(moments, *carry, epochs)
            out[begin : begin + _CHUNK] = np.asarray(states)[: len(part), :4]
        return out

    return solve
