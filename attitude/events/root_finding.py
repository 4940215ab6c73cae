"""Zeros within brackets, many at once, to the last places of time."""

import numpy as np

_MOST = 120


def refined(evaluate, a, b, p, q):
    """The zeros (N,) of functions in brackets with f(a) f(b) < 0.

    Chandrupatla's method (Advances in Engineering Software 28, 145, 1997): inverse quadratic
    interpolation where it can be trusted, else halving; each step is one call for all that are
    still open.

    Parameters
    ----------
    evaluate : callable
        Of times (K,) -> values (K,); one function for all.
    a, b, p, q : (N,) arrays
        Ends and values there.
    """
    x = np.where(np.abs(p) < np.abs(q), a, b)
    open_ = np.flatnonzero((p != 0.0) & (q != 0.0))
    x[p == 0.0] = a[p == 0.0]
    # x2 is the newest end, x1 the other, x3 the one before.
    x1, x2, f1, f2 = a[open_], b[open_], p[open_], q[open_]
    part = np.clip(f1 / (f1 - f2), 0.001, 0.999)
    for _ in range(_MOST):
        if not len(open_):
            break
        new = x1 + part * (x2 - x1)
        value = evaluate(new)
        same = (value < 0.0) == (f1 < 0.0)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = new, value
        nearer = np.abs(f1) < np.abs(f2)
        x[open_] = np.where(nearer, x1, x2)
        width = np.abs(x2 - x1)
        tolerance = 2.0 * np.spacing(np.maximum(np.abs(x1), np.abs(x2)))
        done = (width <= tolerance) | (f1 == 0.0)
        keep = ~done
        open_ = open_[keep]
        x1, x2, x3, f1, f2, f3 = (part[keep] for part in (x1, x2, x3, f1, f2, f3))
        part = _next(x1, x2, x3, f1, f2, f3)
        edge = 0.5 * tolerance[keep] / width[keep]
        part = np.clip(part, edge, 1.0 - edge)
    return x


def _next(x1, x2, x3, f1, f2, f3):
    """Where between x1 (0) and x2 (1) to look next."""
    with np.errstate(divide="ignore", invalid="ignore"):
        xi = (x1 - x2) / (x3 - x2)
        phi = (f1 - f2) / (f3 - f2)
        trusted = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        alpha = (x3 - x1) / (x2 - x1)
        inverse = f1 / (f1 - f2) * f3 / (f3 - f2) - alpha * f1 / (f3 - f1) * f2 / (f2 - f3)
    return np.where(trusted & np.isfinite(inverse), inverse, 0.5)
