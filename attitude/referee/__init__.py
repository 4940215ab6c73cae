"""Integrators of rigid-body motion compared with the exact solution.

referee       `compare`: error, energy and momentum drift and cost of any step function
comparison    `Comparison`, `Run`: its results
integrators   integrators of the literature to compare with, compiled
"""

from attitude.referee._referee import compare

__all__ = ["compare"]
