"""The exact free rotation on plain arrays: no units, no time scales, no objects.

Importing this package compiles nothing; each function is compiled at its first call and kept on
disk for the next process.  Symbols are those of van Zon & Schofield (2006).

record, codes     the record of a motion's constants, and the integers in it
twofloat          arithmetic of pairs of doubles
elliptic, phases, series    the functions of the solution
classify, constants, coefficients, given_axes, uniform    the stages that fill a record
kernel            attitudes and rates from a record, in loops over bodies and epochs
motion            entry points: constants of B motions, and their attitudes
step, march       the same rotation over short times, and integrators with torques
flow, joints, chain    states in pairs from arc to arc, and attitudes on a chain of arcs
regimes, place_of_d    periods and ranges of a motion, and the motion of given periods
labelled_axes     attitudes and rates from pole and angles of labelled axes
diagonal, principal    principal axes of inertia tensors, in whole numbers of 448 bits
vectors           vectors over body axes, angles between vectors
warm_up           compilation ahead of use
"""
