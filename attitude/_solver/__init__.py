"""The exact free rotation on plain arrays: no units, no time scales, no objects.

Importing this package compiles nothing; each function is compiled at its first call and kept on
disk for the next process.  Symbols are those of van Zon & Schofield (2006).

evaluation      entry points: constants of B motions, and their attitudes
states          states of B bodies: attitudes and derivatives on grids and rows, by blocks, threads
records, codes  the records of the constants and derivatives of a motion, and integers in them
constants       the stages that fill a record: classes, rates and phases, coefficients
kernel          attitudes and rates from a record, in loops over bodies and epochs
series          the internal motion at given phases; elliptic, elliptic integrals
twofloat        arithmetic of pairs of doubles
sensitivities   entry points: derivatives, covariances, samples; covariance, errors that are given;
                sensitivity_loops, their set-up and loops, which take derivatives, tangents,
                uniform_tangents, columns and short_times
elements        the five elements of a motion
step            the same rotation over short times, for integrators
torqued_step    a step with torques; march (fixed steps), adaptive, march_layout (their arrays)
chains          states in pairs from arc to arc, and attitudes on a chain of arcs
regime          kind, periods and ranges of motions; regime_loops, their compiled loops
principal_axes  principal axes of inertia tensors, in whole numbers of 448 bits
vectors         vectors over body axes, angles between vectors, attitudes from labelled axes
chebyshev       smooth functions of time as Chebyshev polynomials
warm_up         compilation ahead of use
"""
