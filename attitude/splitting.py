"""Motion under torques: kicks between exact free motions.

These names stand in `attitude.torques`: `TorquedRotation`, and the splitting schemes by name.
"""

from attitude.torques._schemes import SCHEMES, Scheme, scheme
from attitude.torques._torqued import TorquedRotation

__all__ = ["SCHEMES", "Scheme", "TorquedRotation", "scheme"]
