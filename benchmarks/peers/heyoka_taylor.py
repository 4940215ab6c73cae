"""heyoka: Taylor integration, compiled."""

from functools import cache

import numpy as np

from benchmarks.peers import Missing, Peer


def peers():
    try:
        import heyoka  # noqa: F401
    except ImportError as err:
        raise Missing("package heyoka is not installed") from err
    return [
        Peer("heyoka", f"{tolerance:.0e}", _solver(tolerance), 2e6)
        for tolerance in (1e-6, 1e-9, 2.3e-16)
    ]


@cache
def _integrator(tolerance):
    import heyoka as hy

    w, x, y, z, p, q, r = hy.make_vars("w", "x", "y", "z", "p", "q", "r")
    equations = [
        (w, 0.5 * (-x * p - y * q - z * r)),
        (x, 0.5 * (w * p + y * r - z * q)),
        (y, 0.5 * (w * q + z * p - x * r)),
        (z, 0.5 * (w * r + x * q - y * p)),
        (p, hy.par[0] * q * r),
        (q, hy.par[1] * r * p),
        (r, hy.par[2] * p * q),
    ]
    return hy.taylor_adaptive(equations, [1.0] * 7, tol=tolerance)


def _solver(tolerance):
    def solve(moments, wxyz0, omega0, t):
        integrator = _integrator(tolerance)
        i1, i2, i3 = (float(x) for x in moments)
        integrator.pars[:] = ((i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3)
        integrator.time = 0.0
        integrator.state[:4] = wxyz0
        integrator.state[4:] = omega0
        # The grid must start where the integrator stands.
        skip = 0 if t[0] == 0.0 else 1
        found = integrator.propagate_grid(np.concatenate([np.zeros(skip), t]))[-1]
        if len(found) != len(t) + skip:
            raise ArithmeticError("heyoka stopped early")
        return found[skip:, :4]

    return solve
