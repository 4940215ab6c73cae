"""Layouts of the arrays of `solution.march`: each entry by its name.

Indices count entries of 8 bytes, doubles or whole numbers of 64 bits.
"""

ENTRY_BYTES = 8

# Body: 20 doubles.
MOMENTS = 0  # (3) principal moments, ascending, in a unit that makes the largest about 1
INVERSES = 3  # (3) their inverses, in the unit of the torques
TURN = 6  # (4) principal axes to body axes, wxyz
MATRIX = 10  # (3, 3) the same as a matrix, by rows
LARGEST_TURN = 19  # the largest angle of a free motion between two kicks, rad
BODY_ENTRIES = 20

# Scheme: three rows of n + 1 doubles, in units of the step.
KICKS = 0
FLIGHTS = 1  # free motions; the last entry is unused
GRADIENTS = 2  # force gradients, in units of the cube of the step
SCHEME_ROWS = 3

# Models: one row of 5 whole numbers for each torque.
FUNCTION = 0  # address of the function of the torque
KIND = 1  # as in attitude.torques.torque
PARAMETERS = 2  # address of the parameters
COLUMN = 3  # where the samples of the torque begin in a row of samples
SLOPE = 4  # address of the function for the force gradient, or 0
MODEL_ENTRIES = 5
MODEL_BYTES = ENTRY_BYTES * MODEL_ENTRIES

# State: 14 doubles, over the principal axes in ascending order.
WXYZ, OMEGA = slice(0, 4), slice(4, 7)  # attitude; angular velocity in rad/s
WXYZ_LOW, OMEGA_LOW = slice(7, 11), slice(11, 14)  # what their doubles leave out
STATE_ENTRIES = 14

# Scratch memory of the torques: 13 of the 16 doubles of `compilation.pointers.scratch`.
INPUT_WXYZ = 0  # (4) attitude at which a torque is evaluated, body to inertial
INPUT_OMEGA = 4  # (3) angular velocity over the body axes; for SLOPE the vector y
TORQUE = 7  # (3) sum of the torques, over the body axes
RETURNED = 10  # (3) what the last function filled in
INPUT_WXYZ_BYTES = ENTRY_BYTES * INPUT_WXYZ
INPUT_OMEGA_BYTES = ENTRY_BYTES * INPUT_OMEGA
RETURNED_BYTES = ENTRY_BYTES * RETURNED

# What the loops return first.
FINE, BAD_TORQUE, TOO_LONG = 0, 1, 2
