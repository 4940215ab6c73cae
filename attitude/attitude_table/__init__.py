"""Attitudes given at epochs, and interpolated between them.

table           `AttitudeTable`: measured attitudes, or those of a file
interpolation   Hermite, Lagrange and great-circle interpolation of quaternions and rates
"""

from attitude.attitude_table.table import AttitudeTable

__all__ = ["AttitudeTable"]
