"""Random states of eight families, and the certified errors of what the package answers."""

import numpy as np

from attitude import propagate
from attitude.proof._chain import Chain

# Names of the kinds of `random_states`, in their order.
KINDS = (
    *("generic", "nearly symmetric", "near an axis", "near the separatrix", "nearly a sphere"),
    *("needle", "degenerate", "near the middle axis"),
)


def random_states(count, seed):
    """States of eight families (moments, attitudes, rates, seconds), as arrays."""
    generator = np.random.default_rng(seed)
    kind = np.arange(count) % 8
    sides = generator.uniform(0.2, 3.0, (count, 3)) ** 2
    moments = sides[:, [1, 0, 0]] + sides[:, [2, 2, 1]]
    rates = generator.normal(size=(count, 3))
    small = 10.0 ** -generator.uniform(1.0, 15.5, count)
    of = [kind == k for k in range(8)]
    moments[of[1]] = np.stack(
        [0 * small + 2, 2 * (1 + small), 3 + generator.uniform(size=count)], axis=1
    )[of[1]]
    moments[of[2]] = (3.0, 4.0, 6.0)
    rates[of[2]] = np.stack([0 * small + 1.5, small, -0.7 * small], axis=1)[of[2]]
    moments[of[3]] = (10.0, 20.0, 26.0)
    first = generator.uniform(0.5, 2.0, count)
    third = first * np.sqrt(100 / 156) * (1 + generator.choice((-1, 1), count) * small)
    rates[of[3]] = np.stack([first, 0.3 * rates[:, 1], third], axis=1)[of[3]]
    moments[of[4]] = np.stack([0 * small + 2, 2 * (1 + small), 2 * (1 + 2.3 * small)], axis=1)[
        of[4]
    ]
    moments[of[5]] = np.stack([small, 0 * small + 1, 1 + 0.7 * small], axis=1)[of[5]]
    degenerate = np.array([[1, 1, 2], [2, 1, 2], [2, 2, 2], [2, 3, 5], [1, 2, 3]], float)
    turning = [[0.3, -0.4, 0.5], [0.75, 0.5, 0.25], [0, 0.8, 0], [0, 0, 0.7], [0.3, -0.4, 0]]
    moments[of[6]] = degenerate[generator.integers(0, 5, count)][of[6]]
    rates[of[6]] = np.array(turning)[generator.integers(0, 5, count)][of[6]]
    moments[of[7]] = (1.0, 2.0, 3.0)
    rates[of[7]] = np.stack([small, 0 * small + 1, 0.3 * small], axis=1)[of[7]]
    wxyz = generator.normal(size=(count, 4))
    turns = generator.choice((-1, 1), count) * 10.0 ** generator.uniform(-2, 9, count)
    return moments, wxyz, rates, turns / np.abs(rates).max(axis=1)


def certified_errors(moments, wxyz, rates, t):
    """Proved errors (B,), rad, of the array floor at one epoch of each state.

    Every one is certified, and has the sign of the continuous motion.
    """
    found = propagate(moments, wxyz, rates, t[:, None])[:, 0]
    errors = np.empty(len(t))
    for k in range(len(t)):
        pairs = np.stack([wxyz[k], np.zeros(4)], axis=1)
        certificate = Chain(moments[k], pairs, rates[k]).certificate(
            t[k : k + 1], None, found[k : k + 1]
        )
        assert certificate.same_sign[0], (moments[k], wxyz[k], rates[k], t[k])
        errors[k] = certificate.error[0]
    return errors


def hunted(count, seed):
    """Certified errors (count,) of random states, one epoch each."""
    return certified_errors(*random_states(count, seed))
