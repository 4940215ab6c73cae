"""Integrators of rigid-body motion compared with the exact solution.

_referee   `compare`: error, energy and momentum drift and cost of any step function; its results
           `Comparison` and `Run`; integrators of the literature, compiled
"""

from attitude.referee._referee import compare

__all__ = ["compare"]
