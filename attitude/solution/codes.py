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

# What is wrong with a body or state, found where the invariants are made.
FINE = 0
RATIO_TOO_LARGE = 1  # moments that differ by more than a factor 1e45
SPIN_ABOUT_ROD = 2  # angular velocity along an axis without inertia
UNEQUAL_ROD = 3  # one moment is zero and the other two differ
NOT_A_BODY = 4  # negative, NaN or all-zero moments, or an angular velocity that is not finite
