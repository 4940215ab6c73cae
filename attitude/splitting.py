"""Rotation under torques by splitting schemes.

It hands on names of `attitude.torques`; the code is in torques/_torqued.py and _schemes.py.
"""

from attitude.torques._schemes import SCHEMES, Scheme, scheme
from attitude.torques._torqued import TorquedRotation

__all__ = ["SCHEMES", "Scheme", "TorquedRotation", "scheme"]
