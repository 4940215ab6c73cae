"""First stage: refuse what is not physical, find uniform rotations, and D2 of what tumbles.

The state is scaled by powers of two, so that no unit overflows or loses digits.  D2, the one
invariant that is a difference of positive terms, is computed exactly where they cancel; its sign is
the side of the separatrix.  Symbols are those of van Zon & Schofield (2006), section 3.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.compilation.instructions import larger
from attitude.solution import codes
from attitude.solution.twofloat import (
    less,
    mul,
    pair,
    product_added,
    put,
    rounded,
    same,
    square,
    sub,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

# The square of a rate below this fraction of the largest component would underflow: it is 0.
_NO_RATE = 2.0**-400
# Beside a larger one it changes D2 by less than 2^-200.
_RATE_TO_SPARE = 2.0**-300
_LARGEST_RATIO = 1e45
# Rounded moments may violate the triangle inequality by this fraction.
_ROUNDING = 1e-14
# D2 below this fraction of the sum of its terms is computed again, exactly.
_CANCELLED = 0.0625
# Parts of D2: two moments of 2, a difference of 4, a squared rate of 4, a product of 8.
_MOST_PARTS = 2 * 2 * 4 * 4 * 8


@sized_entry_point
def classify_all(moments, wxyz, omega, constants):
    """Check, scale and sort B states.

    Given
        moments    (B, 3, 2) principal moments of inertia, pairs, any unit and order
        wxyz       (B, 4) body to inertial at the epoch
        omega      (B, 3, 2) rad/s over the principal axes, pairs
    Filled
        constants  (B,) fault, mode (as far as it does not depend on D2), form, the scaled state,
                   its ascending order, and D2 to the rounding of its terms
    Returned
        how many have a fault, rotate uniformly, and need D2 computed exactly
    """
    faults = uniform = cancelled = 0
    for b in range(len(constants)):
        c = constants[b]
        c.fault = _fault(moments[b], wxyz[b], omega[b])
        if c.fault != codes.FINE:
            faults += 1
            continue
        _scale(moments[b], omega[b], c)
        if _loses_a_rate(omega[b], c):
            c.fault = codes.LOST_RATE
            faults += 1
        elif _rotates_uniformly(c):
            uniform += 1
        elif _order(c):
            cancelled += 1
    return faults, uniform, cancelled


def refine_all(constants: NDArray[Any]) -> None:
    """Fill D2 of those of B states (solution.record) whose terms cancel, rounded once."""
    # An array allocated in compiled code would cost another tenth of a second of compilation.
    _refine_all(constants, np.empty(_MOST_PARTS))


@sized_entry_point
def _refine_all(constants, expansion):
    """`refine_all`, with the memory of an expansion of _MOST_PARTS."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.cancelled == 1:
            put(c.d2, _exact_middle_invariant(c, expansion))


@subroutine
def _fault(moments, wxyz, omega):
    """The code of what is not physical in a state, or codes.FINE."""
    least, most, total = moments[0, 0], 0.0, 0.0
    for k in range(3):
        moment = moments[k, 0]
        if not (moment >= 0.0 and moment < math.inf):
            return codes.BAD_MOMENT
        if not abs(omega[k, 0]) < math.inf:
            return codes.BAD_RATE
        least, most, total = -larger(-least, -moment), larger(most, moment), total + moment
    size = 0.0
    for k in range(4):
        if not abs(wxyz[k]) < math.inf:
            return codes.BAD_ATTITUDE
        size = larger(size, abs(wxyz[k]))
    if size == 0.0:
        return codes.BAD_ATTITUDE
    if most == 0.0:
        return codes.BAD_MOMENT
    if most > (total - most) * (1.0 + _ROUNDING):
        return codes.NO_TRIANGLE
    if least > 0.0:
        return codes.RATIO_TOO_LARGE if least < most / _LARGEST_RATIO else codes.FINE
    for k in range(3):
        if moments[k, 0] == 0.0:
            i, j = (k + 1) % 3, (k + 2) % 3
            if moments[i, 0] != moments[j, 0] or moments[i, 1] != moments[j, 1]:
                return codes.UNEQUAL_ROD
            if omega[k, 0] != 0.0:
                return codes.SPIN_ABOUT_ROD
    return codes.FINE


@subroutine
def _scale(moments, omega, c):
    """The state times powers of two, the largest moment and rate being in [1/2, 1)."""
    most = fastest = 0.0
    for k in range(3):
        most, fastest = larger(most, moments[k, 0]), larger(fastest, abs(omega[k, 0]))
    inertia, tempo = math.frexp(most)[1], math.frexp(fastest)[1]
    c.tempo = tempo
    scaled_moments, scaled_omega = c.moments, c.omega
    for k in range(3):
        fast = abs(math.ldexp(omega[k, 0], -tempo)) >= _NO_RATE
        for part in range(2):
            scaled_moments[k, part] = math.ldexp(moments[k, part], -inertia)
            scaled_omega[k, part] = math.ldexp(omega[k, part], -tempo) if fast else 0.0


@subroutine
def _loses_a_rate(omega, c):
    """Whether a rate that counts as 0 decides how rotation about the middle axis turns over."""
    moments, scaled = c.moments, c.omega
    lost = False
    for k in range(3):
        lost = lost or (scaled[k, 0] == 0.0 and omega[k, 0] != 0.0)
    if lost:
        for k in range(3):
            i, j = k - 1, k - 2  # the other two
            here, one, two = pair(moments[k]), pair(moments[i]), pair(moments[j])
            if (less(one, here) and less(here, two)) or (less(two, here) and less(here, one)):
                return larger(abs(scaled[i, 0]), abs(scaled[j, 0])) < _RATE_TO_SPARE
    return False


@subroutine
def _rotates_uniformly(c):
    """Whether every product (Ij - Ik) wj wk of Euler's equations has a factor 0; fill the mode."""
    moments, omega = c.moments, c.omega
    equal = still = 0
    for k in range(3):
        j = k - 1  # -1, 0, 1: the axis before it
        if same(pair(moments[k]), pair(moments[j])):
            equal += 1
        elif omega[k, 0] != 0.0 and omega[j, 0] != 0.0:
            return False
        if omega[k, 0] == 0.0:
            still += 1
    c.form = codes.UNIFORM
    if still == 3:
        c.mode = codes.AT_REST
    elif equal == 3:
        c.mode = codes.SPHERICAL
    else:
        c.mode = codes.PRINCIPAL_AXIS
    return True


@subroutine
def _order(c):
    """Fill the ascending order and D2 = L^2 - 2 E I2, I2 the middle moment; whether D2 cancels.

    D2 is positive where the momentum circulates about the axis of greatest inertia.
    """
    # The next stage replaces it where the other form converges faster.
    c.form = codes.TRIGONOMETRIC
    p, q, r = 0, 1, 2
    moments, omega, order, gaps = c.moments, c.omega, c.order, c.gaps
    a, b, d = pair(moments[0]), pair(moments[1]), pair(moments[2])
    if less(b, a):
        p, q, a, b = q, p, b, a
    if less(d, b):
        q, r, b, d = r, q, d, b
    if less(b, a):
        p, q, a, b = q, p, b, a
    order[0], order[1], order[2] = p, q, r
    below, above = sub(b, a), sub(d, b)
    put(gaps[0], below)
    put(gaps[1], above)
    of_least = mul(mul(a, below), square(pair(omega[p])))
    of_greatest = mul(mul(d, above), square(pair(omega[r])))
    d2 = sub(of_greatest, of_least)
    put(c.d2, d2)
    cancelled = abs(d2[0]) < _CANCELLED * (of_greatest[0] + of_least[0])
    c.cancelled = 1 if cancelled else 0
    return cancelled


@subroutine
def _exact_middle_invariant(c, total):
    """d (d - b) wd^2 + a (a - b) wa^2, every product exact: 16 parts if the inputs are doubles."""
    count = np.int64(0)  # numba gives a literal its own type, and compiles callees for it too
    middle = c.moments[c.order[1]]
    for k in (2, 0):
        moment, rate = c.moments[c.order[k]], c.omega[c.order[k]]
        for i in range(2):
            for j in range(4):
                part = moment[j] if j < 2 else -middle[j - 2]
                if moment[i] * part == 0.0:
                    continue
                for m in range(2):
                    for n in range(2):
                        count = product_added(total, count, moment[i], part, rate[m], rate[n])
    return rounded(total, count)
