"""Proved bounds of the errors of attitudes: certificates at epochs, and one bound for all epochs.

`FreeRotation.certificate`, `Arcs.certificate`, `attitude.certify` and `FreeRotation.error_bound`
return them.  They need python-flint, the extra ``proof``; docs/proof.md has the theorems, what they
rest on and how to check them.

_certificate  bounds of the errors of attitudes at epochs
_error_bound  one bound at all epochs: constants enclosed, and the theorem of the loops
_exact        the exact attitude of a free rotation in balls; branches decided in fractions
_chain        free rotations joined by changes, in fractions
_intervals    arrays of intervals, rounded outward; the turn of a direction in four dimensions
"""

from attitude.proof._certificate import Certificate
from attitude.proof._error_bound import ErrorBound

__all__ = ["Certificate", "ErrorBound"]
