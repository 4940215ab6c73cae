"""The derivatives of one motion: a record of numbers beside `solution.record`.

The change of attitude at t is a rotation vector over inertial axes.  For motions that tumble, and
the column of one parameter,

    eta = offset + (time t + wind k) z + (rate t + phase) B1 + second B2 + third B3

where z is the direction of the angular momentum, B1, B2, B3 are the changes with the nutation phase
and with two more elements, and k is the number of the passage of the hyperbolic form.  The third
element of that form also changes the scale of the phase y of a passage, and the phase from one
passage to the next: B3 contains -(by_third[0] y + by_third[1] k) B1.
"""

import numpy as np

# Epochs are computed in blocks.  The rows of a block lie in one array: with distances that are
# known when the loops are compiled, LLVM needs no test of overlap and vectorises the loops.  Rows
# 4096 bytes apart would share the lines of the cache.
BLOCK = 248
SECONDS, BASIS, PASSED = (BLOCK * row for row in (0, 1, 10))
WXYZ, OMEGA, ARGUMENTS, FOUND = (BLOCK * row for row in (11, 15, 18, 22))
TURNED, SUMS, ZEROS, ONES, NEAR_SUMS = (BLOCK * row for row in (25, 28, 49, 50, 51))
ROWS = 57

# Parameters: initial attitude (3), angular velocity (3), principal moments (3).  A change of the
# initial attitude over inertial axes stays as it is, and changes no angular velocity.
TURNS = 3
COLUMNS = 9

# Rows of `weights`.
TIME, RATE, PHASE, SECOND, THIRD, WIND = range(6)

TANGENTS: np.dtype[np.void] = np.dtype(
    [
        # elements by angular velocity over the given body axes (3) and by the moments as given (3)
        ("by_input", "f8", (7, 6)),
        ("weights", "f8", (6, COLUMNS)),
        ("by_third", "f8", 2),
        ("offset", "f8", (3, COLUMNS)),
        # axes with z along the momentum, in which the solution is written, to inertial axes
        ("invariant", "f8", (3, 3)),
        # series of solution.tangent_series, and z of the three vectors of the trigonometric form
        ("series", "f8", (8, 5)),
        ("upright", "f8", 3),
        # angular momentum and its change, inertial axes; inverse inertia, principal axes
        ("momentum", "f8", 3),
        ("impulse", "f8", (3, COLUMNS)),
        ("of_moment", "f8", (3, COLUMNS)),  # change of the principal moments
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
