"""The derivatives of one motion: a record of numbers beside `solution.record`.

The change of attitude at t is a rotation vector over inertial axes.  For motions that tumble, and
the column of one parameter,

    eta = offset + (time t + n second) z + (rate t + phase) B1 + second B2 + third B3

where z is the direction of the angular momentum, and B1, B2, B3 are the changes with the nutation
phase and with two more elements.  In the hyperbolic form a change of the second element turns the
body about z by 4 from one passage to the next, between them by almost nothing: the even number n
counts it since the epoch, and B2 has the rest, which is small wherever B1 is.  The third element of
that form also changes the scale of the phase y of a passage, and the phase from one passage to the
next: B3 contains D B1, D = -(by_third[0] y + by_third[1] k), k the number of the passage.

The angular velocity changes by

    (rate t + phase + third D) W1 + nome W2 + amplitudes . w

where W1 and W2 are its derivatives by the phase and by the nome of its series.
"""

import numpy as np

# Epochs are computed in blocks.  The rows of a block lie in one array: with distances that are
# known when the loops are compiled, LLVM needs no test of overlap and vectorises the loops.  Rows
# 4096 bytes apart would share the lines of the cache.
BLOCK = 248
# Loops that read some rows and write others are vectorised where they write those further back.
SECONDS, BASIS, PASSED = (BLOCK * row for row in (0, 1, 10))
WXYZ, OMEGA, SCALED, DECAYED = (BLOCK * row for row in (11, 15, 18, 19))
BY_PHASE, BY_NOME, ARGUMENTS, FOUND = (BLOCK * row for row in (20, 23, 26, 30))
TURNED, SUMS, ZEROS, ONES, NEAR_SUMS = (BLOCK * row for row in (33, 36, 57, 58, 59))
ROWS = 65

# Parameters: initial attitude (3), angular velocity (3), principal moments (3).  A change of the
# initial attitude over inertial axes stays as it is, and changes no angular velocity.
TURNS = 3
COLUMNS = 9

# Rows of `weights`.
TIME, RATE, PHASE, SECOND, THIRD, NOME = range(6)

TANGENTS: np.dtype[np.void] = np.dtype(
    [
        # elements by angular velocity over the given body axes (3) and by the moments as given (3)
        ("by_input", "f8", (11, 6)),
        ("weights", "f8", (6, COLUMNS)),
        ("by_third", "f8", 2),
        # hyperbolic: n of the epoch, exp(-2|y|) = 2^(-decay |dx|), a pair, and Q'
        ("passed", "f8"),
        ("decay", "f8", 2),
        ("nome", "f8"),
        # angular velocity: d ln of its amplitudes, W1 of the products w2 w3, w3 w1, w1 w2, and the
        # derivatives of its series by their nome (trigonometric)
        ("amplitudes", "f8", (3, COLUMNS)),
        ("by_phase", "f8", 3),
        ("by_nome", "f8", (4, 5)),
        ("offset", "f8", (3, COLUMNS)),
        # axes with z along the momentum, in which the solution is written, to inertial axes
        ("invariant", "f8", (3, 3)),
        # series of solution.tangent_series, and z of the three vectors of the trigonometric form
        ("series", "f8", (8, 5)),
        ("upright", "f8", 3),
        # angular momentum, inertial axes; inverse inertia, principal axes
        ("momentum", "f8", 3),
        ("inverse", "f8", 3),
        ("principal", "f8", (3, 3)),
        # uniform rotation: turns per second of half the oscillation of a wobble, negative squared
        # where it grows, and what the scalars of solution.uniform_tangents multiply
        ("wobble", "f8", 2),
        ("grows", "f8"),
        ("uniform", "f8", (10, 3, COLUMNS)),
        ("uniform_rates", "f8", (4, 3, COLUMNS)),
    ]
)
