"""Layouts of the arrays of `torqued_step` and its loops: each entry by its name.

Indices count entries of 8 bytes, doubles or whole numbers of 64 bits.
"""

from __future__ import annotations

from typing import Final

ENTRY_BYTES: Final = 8

# Body: 30 doubles.
MOMENTS: Final = 0  # (3) principal moments, ascending, in a unit that makes the largest about 1
INVERSES: Final = 3  # (3) their inverses, in the unit of the torques
TURN: Final = 6  # (4) principal axes to body axes, wxyz
MATRIX: Final = 10  # (3, 3) the same as a matrix, by rows
LARGEST_TURN: Final = 19  # the largest angle of a free motion between two kicks, rad
DAMPING: Final = 20  # (3, 3) angular acceleration over the principal axes by the rate, 1/s, by rows
DAMPING_SIZE: Final = 29  # its largest sum of the sizes in a row
BODY_ENTRIES: Final = 30

# Scheme: three rows of n + 1 doubles, in units of the step.
KICKS: Final = 0
FLIGHTS: Final = 1  # free motions; the last entry is unused
GRADIENTS: Final = 2  # force gradients, in units of the cube of the step
SCHEME_ROWS: Final = 3

# Models: one row of 5 whole numbers for each torque.
FUNCTION: Final = 0  # address of the function of the torque
KIND: Final = 1  # one of the kinds below
PARAMETERS: Final = 2  # address of the parameters
COLUMN: Final = 3  # where the samples of the torque begin in a row of samples
SLOPE: Final = 4  # address of the function for the force gradient, or 0
MODEL_ENTRIES: Final = 5
MODEL_BYTES: Final = ENTRY_BYTES * MODEL_ENTRIES

# Kinds of torques.
BY_ATTITUDE: Final = 0  # depends on the attitude alone
BY_RATE: Final = 1  # depends on the angular velocity too
SLIP: Final = 2  # no torque, but a slip of the body under a fixed angular momentum
LINEAR: Final = 3  # is the angular velocity times a constant matrix, `Torque.by_rate`

# State: 14 doubles, over the principal axes in ascending order.
WXYZ: Final = slice(0, 4)
OMEGA: Final = slice(4, 7)  # rad/s
OMEGA_LOW: Final = slice(11, 14)  # what the doubles of OMEGA leave out, after that of WXYZ
STATE_ENTRIES: Final = 14

# Scratch memory of the torques: 13 of the 16 doubles of `pointers.scratch`.
INPUT_WXYZ: Final = 0  # (4) attitude at which a torque is evaluated, body to inertial
INPUT_OMEGA: Final = 4  # (3) angular velocity over the body axes; for SLOPE the vector y
TORQUE: Final = 7  # (3) sum of the torques, over the body axes
RETURNED: Final = 10  # (3) what the last function filled in
INPUT_WXYZ_BYTES: Final = ENTRY_BYTES * INPUT_WXYZ
INPUT_OMEGA_BYTES: Final = ENTRY_BYTES * INPUT_OMEGA
RETURNED_BYTES: Final = ENTRY_BYTES * RETURNED

# How a march ended.
FINE: Final = 0
BAD_TORQUE: Final = 1  # a torque is not finite
TOO_LONG: Final = 2  # a free motion turns by more than the largest angle
TOO_ROUGH: Final = 3  # no step is short enough for the tolerance

# Clock of adaptive steps: doubles, seconds since the epoch.
TIME: Final = 0  # of the state
LENGTH: Final = 1  # of the next step, of either sign
UNTIL: Final = 2  # steps are taken to here at least
LAST: Final = 3  # no step goes beyond; its absolute value
TOLERANCE: Final = 4  # of the error of a step
TURN_LIMIT: Final = 5  # the longest step times the angular velocity, rad
APART: Final = 6  # largest angle between the motions with whole and with halved steps, rad
TURNED: Final = 7  # angle by which the body has turned, rad
USUAL: Final = 8  # error of recent steps over the power of their length
ROUGH: Final = 9  # sum of the errors of steps at which the torque is not smooth
ROUGH_TURNED: Final = 10  # sum of these errors times TURNED at their steps
LIMIT: Final = 11  # steps end where the estimate of the error of paired motions exceeds it, rad
FINE_PIECE: Final = 12  # longest pieces of free motions in halves: see `step.advance_two`
WHOLE_PIECE: Final = 13  # in whole steps
CLOCK_ENTRIES: Final = 14

# Counters of adaptive steps: whole numbers.
TAKEN: Final = 0  # since the epoch
REFUSALS: Final = 1  # one after the other
KEPT: Final = 2  # rows filled by the last call
TRIED: Final = 3  # by the last call
COUNTERS: Final = 4

# A kept state of adaptive steps: 16 doubles, with which the same steps follow again.
KEPT_TIME: Final = 0
KEPT_LENGTH: Final = 1  # of the next step
KEPT_STATE: Final = slice(2, 16)
KEPT_ENTRIES: Final = 16
