"""Proved bounds of the errors of attitudes: certificates at epochs, and one bound for all epochs.

`FreeRotation.certificate`, `Arcs.certificate`, `attitude.certify` and `FreeRotation.error_bound`
return them.  They need python-flint, the extra ``proof``; docs/proof.md has the theorems, what they
rest on and how to check them.
"""

from attitude.proof._certificate import Certificate
from attitude.proof._error_bound import ErrorBound

__all__ = ["Certificate", "ErrorBound"]
