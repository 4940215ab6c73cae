"""Arrays of reflectances of laws that are evaluated facet by facet, compiled for each law."""

import math
from functools import cache

import numpy as np

from attitude.compilation.decorators import reduction_over
from attitude.compilation.instructions import fence

# How many numbers a law may keep of a phase angle.
TERMS = 8


@cache
def reflectances(of_phase, element):
    """The loop over elements of one row of numbers, for the functions of a law; see `law.Law`."""

    @reduction_over(of_phase, element)
    def evaluated(row, mu0, mu, half, out):
        """r in 1/sr, from half the phase angle; 0 where mu0 or mu is not positive."""
        now = np.empty(TERMS)
        for i in range(out.size):
            out[i] = 0.0
            if mu0[i] > 0.0 and mu[i] > 0.0:
                of_phase(row, math.cos(half[i]), math.sin(half[i]), now)
                out[i] = mu0[i] * fence(element(row, now, mu0[i], mu[i]))

    return evaluated
