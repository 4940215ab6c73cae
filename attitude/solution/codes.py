"""Whole numbers that stand for the kinds of motion, shared by compiled code and Python."""

# Modes of motion; regime.Mode gives them their names.
AT_REST = 0
SPHERICAL = 1
PRINCIPAL_AXIS = 2
SEPARATRIX = 3
SYMMETRIC = 4
LONG_AXIS = 5
SHORT_AXIS = 6

# Forms in which an attitude is evaluated.
UNIFORM = 0  # constant angular velocity: one phase
TRIGONOMETRIC = 1  # theta functions of v, nome Q <= exp(-pi)
HYPERBOLIC = 2  # the same after the modular transformation, nome Q' < exp(-pi)

# What is wrong with a body or state, found where its constants are made.
FINE = 0
BAD_MOMENT = 1  # negative, NaN, infinite, or all zero
NO_TRIANGLE = 2  # one moment exceeds the sum of the others beyond rounding
RATIO_TOO_LARGE = 3  # moments that differ by more than a factor 1e45
SPIN_ABOUT_ROD = 4  # angular velocity along an axis without inertia
UNEQUAL_ROD = 5  # one moment is zero and the other two differ
BAD_RATE = 6  # an angular velocity that is not finite
BAD_ATTITUDE = 7  # a quaternion that is zero or not finite
