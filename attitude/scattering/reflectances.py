"""Arrays of reflectances of laws that are evaluated facet by facet, compiled for each law."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from attitude.compilation.decorators import reduction_over
from attitude.compilation.instructions import fence
from attitude.compilation.simd import lanes, largest_lane

if TYPE_CHECKING:
    from attitude.compilation.decorators import Compilable, EntryPoint

# Upper bound of the number of terms that a law computes from a phase angle.
TERMS = 8
_ONES = (1.0,) * 8


@cache
def reflectances(of_phase: Compilable, element: Compilable, in_lanes: bool = False) -> EntryPoint:
    """The loop over elements with one row of numbers, for the functions of a law; see `law.Law`.

    The result is called with row (W,), mu0, mu, half the phase angle (rad) and the output, (N,)
    each.  With `in_lanes` the function is ``elements`` of a law, else its ``element``.
    """
    if in_lanes:

        @reduction_over(of_phase, element)
        def evaluated(row, mu0, mu, half, out):
            """r in 1/sr, from half the phase angle; 0 where mu0 or mu is not positive."""
            phase_terms = np.empty(TERMS)
            for i in range(out.size):
                out[i] = 0.0
                if mu0[i] > 0.0 and mu[i] > 0.0:
                    of_phase(row, math.cos(half[i]), math.sin(half[i]), phase_terms)
                    # Each element has another phase angle: it fills all lanes.
                    p, q = lanes(_ONES) * mu0[i], lanes(_ONES) * mu[i]
                    out[i] = mu0[i] * largest_lane(element(row, phase_terms, p, q))

    else:

        @reduction_over(of_phase, element)
        def evaluated(row, mu0, mu, half, out):
            """r in 1/sr, from half the phase angle; 0 where mu0 or mu is not positive."""
            phase_terms = np.empty(TERMS)
            for i in range(out.size):
                out[i] = 0.0
                if mu0[i] > 0.0 and mu[i] > 0.0:
                    of_phase(row, math.cos(half[i]), math.sin(half[i]), phase_terms)
                    out[i] = mu0[i] * fence(element(row, phase_terms, mu0[i], mu[i]))

    return evaluated
