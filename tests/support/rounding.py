"""What rounding does, in a free motion, to energy and momentum: measured in two doubles."""

import numpy as np

from attitude._compilation.decorators import entry_point, subroutine
from attitude._solver.step import advance, gains, loaded, stored
from attitude._solver.twofloat import ZERO, add, mul, square, sub, two_prod, two_sum


@entry_point
def moved(m, times, states, sums):
    """Relative changes of T and L^2 over free motions from each state, one for each of `times`.

    Given
        m        (3,) moments in ascending order
        times    (n,) s
        states   (S, 14) as in `attitude._solver.step.loaded`
    Changed
        sums     (2, 3) of T and of L^2, to which are added: the changes; the squares of what the
                 motions from one state change together, since they round some things alike; the
                 squares of each
    """
    moments = m[0], m[1], m[2]
    k, state = gains(moments), np.zeros(14)
    for row in range(len(states)):
        before = _conserved(moments, states[row])
        together = (0.0, 0.0)
        for j in range(len(times)):
            stored(advance(moments, k, times[j], loaded(states[row])), state)
            after = _conserved(moments, state)
            energy = sub(after[0], before[0])[0] / before[0][0]
            momentum = sub(after[1], before[1])[0] / before[1][0]
            together = together[0] + energy, together[1] + momentum
            sums[0, 2] += energy * energy
            sums[1, 2] += momentum * momentum
        for n in range(2):
            sums[n, 0] += together[n]
            sums[n, 1] += together[n] * together[n]


@subroutine
def _conserved(moments, state):
    """2 T and L^2, pairs."""
    energy = momentum = ZERO
    for n in range(3):
        ww = square(two_sum(state[4 + n], state[11 + n]))
        energy = add(energy, mul(ww, (moments[n], 0.0)))
        momentum = add(momentum, mul(ww, two_prod(moments[n], moments[n])))
    return energy, momentum
