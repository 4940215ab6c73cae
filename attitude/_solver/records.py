"""The constants of one motion, and its derivatives: records of numbers.

`constants` fills the first, `sensitivity` the second; `kernel` and `tangents` read them.  Rates are
in turns per second, phases in turns, pairs are (hi, lo).
"""

from __future__ import annotations

import numpy as np

CONSTANTS: np.dtype[np.void] = np.dtype(
    [
        ("fault", "i8"),  # codes.FINE, or what is not physical
        ("mode", "i8"),  # codes.AT_REST .. codes.SHORT_AXIS
        ("form", "i8"),  # codes.UNIFORM, TRIGONOMETRIC or HYPERBOLIC
        ("circulates", "i8"),  # number of the moment of the internal third axis; -1: none
        # the state, scaled by powers of two; pairs
        ("moments", "f8", (3, 2)),
        ("omega", "f8", (3, 2)),
        ("order", "i8", 3),  # indices of the moments, ascending
        ("gaps", "f8", (2, 2)),  # of the ascending moments: second less first, third less second
        ("jacobi", "i8", 4),  # first and second internal axis; 1 where the first, third is reversed
        ("d2", "f8", 2),  # L^2 - 2 E I2: signed at first, then its magnitude
        ("cancelled", "i8"),  # 1 where the terms of D2 nearly cancel: it is computed exactly
        ("tempo", "i8"),  # rates were scaled by 2**-tempo
        # phases: precession g t, half of the turns of phi + psi; nutation x = f t + x0, the turns
        # of psi (hyperbolic: 2 x; on the exact separatrix y = (wp t + eps) / 2 in rad)
        ("precession", "f8", 2),
        ("nutation", "f8", 2),
        ("nutation0", "f8", 2),
        ("winds", "f8"),  # 1 if whole half turns are removed from 2 x, 0 on the exact separatrix
        # parameters of the series: T = 2 K'/K, eta / K', sqrt((1 - l) / (1 + l))
        ("stretch", "f8"),
        ("fraction", "f8"),
        ("wobble", "f8"),
        ("internal", "f8", 4),  # q_int(0), not normalised
        # internal pair (alpha, beta) to the attitude of the given axes; columns w, x, y, z
        # (uniform: row 0 is q(0), row 1 q(0) times the unit axis)
        ("frame", "f8", (4, 4)),
        # series of alpha and beta: see constants
        ("alpha", "f8", (2, 4)),
        ("beta", "f8", (2, 4)),
        ("decay", "f8"),  # hyperbolic: exp(-2|y|) = 2**(-decay |dx|)
        ("nome", "f8"),  # Q, hyperbolic: Q'
        ("tilt", "f8"),  # hyperbolic: d / pi, turns of precession per half turn of dx
        # series of the angular velocity over the internal axes (uniform: row 0 is the constant),
        # and the internal axes in the given ones
        ("rates", "f8", (4, 5)),
        ("axes", "f8", (3, 3)),
        # for regimes and the methods of a motion
        ("psi_rate", "f8"),  # mean turns per second of the third Euler angle (3-1-3), signed
        ("phi_rate", "f8"),  # and of the first
        ("m", "f8"),
        ("mc", "f8", 2),
        ("quarter", "f8", 2),  # K(m)
        ("amplitudes", "f8", 3),
    ]
)


# ---- The derivatives of one motion: a record of numbers beside `CONSTANTS`
# The change of attitude at t is a rotation vector over inertial axes.  For motions that tumble, and
# the column of one parameter,
#
#     eta = offset + (time t + n second) z + (rate t + phase) B1 + second B2 + third B3
#
# where z is the direction of the angular momentum, and B1, B2, B3 are the changes with the nutation
# phase and with two more elements.  In the hyperbolic form a change of the second element turns the
# body about z by 4 from one passage to the next, between them by almost nothing: the even number n
# counts it since the epoch, and B2 has the rest, which is small wherever B1 is.  The third element
# of that form also changes the scale of the phase y of a passage, and the phase from one passage to
# the next: B3 contains D B1, D = -(by_third[0] y + by_third[1] k), k the number of the passage.
#
# The angular velocity changes by
#
#     (rate t + phase + third D) W1 + nome W2 + amplitudes . w
#
# where W1 and W2 are its derivatives by the phase and by the nome of its series.

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
        # series of `short_times` to either side that serve while the terms above cancel: for all
        # digits, and for least squares; 0 of columns by elements, which cancel within a radian
        ("spans", "i8", 2),
        # turns per second of the precession of a needle, a pair, where it is slow; otherwise 0
        ("slow", "f8", 2),
        # axes with z along the momentum, in which the solution is written, to inertial axes
        ("invariant", "f8", (3, 3)),
        # series of tangents, and z of the three vectors of the trigonometric form
        ("series", "f8", (8, 5)),
        ("upright", "f8", 3),
        # attitude at the epoch as given, to 1 rounding: that of the solution errs by as much as its
        # frame, which series from the epoch would keep
        ("start", "f8", 4),
        # angular momentum, inertial axes, and inverse inertia, principal axes, by scaled moments; a
        # unit of the given moments among the scaled ones
        ("momentum", "f8", 3),
        ("inverse", "f8", 3),
        ("moment_unit", "f8"),
        ("principal", "f8", (3, 3)),
        # uniform rotation: turns per second of half the oscillation of a wobble, negative squared
        # where it grows, and what the scalars of uniform_tangents multiply
        ("wobble", "f8", 2),
        ("grows", "f8"),
        # turns per second of half of spin - wobble and of half their sum, pairs; 0 but for needles
        # about their length
        ("beats", "f8", (2, 2)),
        ("uniform", "f8", (10, 3, COLUMNS)),
        ("uniform_rates", "f8", (4, 3, COLUMNS)),
    ]
)
