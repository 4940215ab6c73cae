"""The constants of one motion: a record of numbers.

The stages of `solution.motion` fill it, `solution.kernel` reads it.  Rates are in turns per second,
phases in turns, pairs are (hi, lo).
"""

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
        # parameters of the series: T = 2 K'/K, eta / K', sqrt(1 - n), sqrt((1 - l) / (1 + l))
        ("stretch", "f8"),
        ("fraction", "f8"),
        ("root", "f8"),
        ("wobble", "f8"),
        ("internal", "f8", 4),  # q_int(0), not normalised
        # internal pair (alpha, beta) to the attitude of the given axes; columns w, x, y, z
        # (uniform: row 0 is q(0), row 1 q(0) times the unit axis)
        ("frame", "f8", (4, 4)),
        # series of alpha and beta: see solution.coefficients
        ("alpha", "f8", (2, 4)),
        ("beta", "f8", (2, 4)),
        ("decay", "f8"),  # hyperbolic: exp(-2|y|) = 2**(-decay |dx|)
        ("nome", "f8"),  # Q, hyperbolic: Q'
        ("tilt", "f8"),  # hyperbolic: d / pi, turns of precession per half turn of dx
        # series of the angular velocity over the internal axes (uniform: row 0 is the constant),
        # and the internal axes in the given ones
        ("rates", "f8", (4, 5)),
        ("axes", "f8", (3, 3)),
        # for solution.regimes and the methods of a motion
        ("psi_rate", "f8"),  # mean turns per second of the third Euler angle (3-1-3), signed
        ("phi_rate", "f8"),  # and of the first
        ("m", "f8"),
        ("mc", "f8", 2),
        ("quarter", "f8", 2),  # K(m)
        ("amplitudes", "f8", 3),
    ]
)
