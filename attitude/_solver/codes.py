"""Integer codes of the kinds of motion, shared by compiled code and Python."""

from __future__ import annotations

from typing import Final

# Modes of motion, the values of regime.Mode.
AT_REST: Final = 0
SPHERICAL: Final = 1
PRINCIPAL_AXIS: Final = 2
SEPARATRIX: Final = 3
SYMMETRIC: Final = 4
LONG_AXIS: Final = 5
SHORT_AXIS: Final = 6

# Forms in which an attitude is evaluated.
UNIFORM: Final = 0  # constant angular velocity: one phase
TRIGONOMETRIC: Final = 1  # theta functions of v, nome Q <= exp(-pi)
HYPERBOLIC: Final = 2  # the same after the modular transformation, nome Q' < exp(-pi)

# Faults of a body or state, found by constants.
FINE: Final = 0
BAD_MOMENT: Final = 1  # negative, NaN, infinite, or all zero
NO_TRIANGLE: Final = 2  # one moment exceeds the sum of the others beyond rounding
RATIO_TOO_LARGE: Final = 3  # moments that differ by more than a factor 1e45
SPIN_ABOUT_ROD: Final = 4  # angular velocity along an axis without inertia
UNEQUAL_ROD: Final = 5  # one moment is zero and the other two differ
BAD_RATE: Final = 6  # an angular velocity that is not finite
BAD_ATTITUDE: Final = 7  # a quaternion that is zero or not finite
LOST_RATE: Final = 8  # rates beside that about the middle axis that are too small to be kept
