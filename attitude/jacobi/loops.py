"""The compiled loops of elliptic integrals and functions over arrays."""

import math

from attitude.compilation.decorators import entry_point
from attitude.solution.elliptic import complete_and_phase, quarter_and_fraction
from attitude.solution.second_kind import integrals, third_kind_degenerate

# The AGM is quadratic: from 1e-9 apart to the rounding of doubles.
_CLOSE = 1e-9
_MOST = 12


@entry_point
def complete(m, mc, first, second):
    """K and E of parameters m (N,) with complements mc > 0."""
    for k in range(len(m)):
        whole, part = integrals(m[k], mc[k])
        first[k] = whole
        second[k] = whole - m[k] * part


@entry_point
def third(n, mc, out):
    """Pi(n, m) for characteristics n <= 0 (N,) and complements mc > 0."""
    for k in range(len(n)):
        root = math.sqrt(mc[k])
        low = (mc[k] - root * root) / (2.0 * root)
        p = 1.0 - n[k]
        rest = (1.0 - p) - n[k]
        ratio, whole, _ = complete_and_phase(
            (root, low), (p, rest), (1.0, 0.0), (1.0, 0.0), (0.0, 0.0)
        )
        out[k] = ratio[0] * whole[0]


@entry_point
def incomplete(cosine, sine, mc, first, second):
    """F and E of amplitudes in the first quadrant, by cosine and sine (N,)."""
    for k in range(len(mc)):
        c, s = cosine[k], sine[k]
        whole, fraction = quarter_and_fraction(math.sqrt(mc[k]), c, s)
        first[k] = whole * fraction
        m = 1.0 - mc[k]
        # DLMF 19.25.9: E = F - m s^3 R_D(c^2, 1 - m s^2, 1) / 3
        square = c * c + mc[k] * s * s
        second[k] = first[k] - m * s**3 * third_kind_degenerate(c * c, square, 1.0) / 3.0


@entry_point
def amplitude(u, mc, out):
    """am(u, m) for 0 <= u <= K (N,), by the AGM and back (DLMF 22.20(ii))."""
    for k in range(len(u)):
        a, b = 1.0, math.sqrt(mc[k])
        means = [a]
        halves = [0.0]
        for _ in range(_MOST):
            c = 0.5 * (a - b)
            a, b = 0.5 * (a + b), math.sqrt(a * b)
            means.append(a)
            halves.append(c)
            if abs(c) <= _CLOSE * a:
                break
        phi = math.ldexp(a * u[k], len(means) - 1)
        for step in range(len(means) - 1, 0, -1):
            phi = 0.5 * (phi + math.asin(halves[step] / means[step] * math.sin(phi)))
        out[k] = phi
