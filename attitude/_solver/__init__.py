"""The exact free rotation on plain arrays: no units, no time scales, no objects.

Importing this package compiles nothing; each function is compiled at its first call and kept on
disk for the next process.  Symbols are those of van Zon & Schofield (2006).

records, codes    the records of a motion's constants and derivatives, and the integers in them
twofloat          arithmetic of pairs of doubles
elliptic, series  the functions of the solution
constants         the stages that fill a record
kernel            attitudes and rates from a record, in loops over bodies and epochs
evaluation        entry points: constants of B motions, and their attitudes; `batches`, in blocks
step, chains      the same rotation over short times; from state to state, in pairs
torqued_step      a step of an integrator with torques; `march`, `adaptive`, its loops
regime, regimes   mode, periods and ranges of a motion, and the motion of given periods
principal_axes    principal axes of inertia tensors, in whole numbers of 448 bits
sensitivities     entry points of derivatives and covariances; `tangents`, `columns`, `sensitivity`,
                  `derivatives`, `uniform_tangents`, `short_times`, their parts
elements          the free rotation in five numbers; `covariance`, errors that are given
vectors           vectors over body axes, angles between vectors, attitudes of labelled axes
chebyshev         polynomials on equal pieces of a span
warm_up           compilation ahead of use
"""
