"""Integrators of rigid-body motion judged against the exact solution.

referee       `compare`: error, energy and momentum drift and cost of any step function
integrators   integrators of the literature to compare with, compiled
"""

from attitude.referee.referee import compare

__all__ = ["compare"]
