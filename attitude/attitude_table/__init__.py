"""Attitudes at given epochs, and by interpolation between them.

table           `AttitudeTable`, read from a file or measured
interpolation   Hermite, Lagrange and great-circle interpolation of quaternions and rates
"""

from attitude.attitude_table.table import AttitudeTable

__all__ = ["AttitudeTable"]
