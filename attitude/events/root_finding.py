"""Zeros within brackets, many at once, to the resolution of a double of time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray

_MOST_STEPS = 120


def refined(
    evaluate: Callable[[FloatArray], FloatArray],
    a: FloatArray,
    b: FloatArray,
    p: FloatArray,
    q: FloatArray,
) -> FloatArray:
    """The zeros (N,) of a function in brackets with f(a) f(b) < 0.

    Chandrupatla's method (Advances in Engineering Software 28, 145, 1997): inverse quadratic
    interpolation where its conditions hold, bisection otherwise.  Each step is one call for all
    brackets that have not converged.

    Parameters
    ----------
    evaluate : callable
        Times (K,) to values (K,).
    a, b : (N,) arrays
        Ends of the brackets.
    p, q : (N,) arrays
        Values at a and b.
    """
    x = np.where(np.abs(p) < np.abs(q), a, b)
    open_ = np.flatnonzero((p != 0.0) & (q != 0.0))
    x[p == 0.0] = a[p == 0.0]
    # x1 and x2 are the ends of the brackets, x1 the newer of them; x3 is the end
    # that the last step replaced.
    x1, x2, f1, f2 = a[open_], b[open_], p[open_], q[open_]
    part = np.clip(f1 / (f1 - f2), 0.001, 0.999)
    for _ in range(_MOST_STEPS):
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
    """The next point, as a fraction of the way from x1 (0) to x2 (1)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        xi = (x1 - x2) / (x3 - x2)
        phi = (f1 - f2) / (f3 - f2)
        trusted = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        alpha = (x3 - x1) / (x2 - x1)
        inverse = f1 / (f1 - f2) * f3 / (f3 - f2) - alpha * f1 / (f3 - f1) * f2 / (f2 - f3)
    return np.where(trusted & np.isfinite(inverse), inverse, 0.5)
