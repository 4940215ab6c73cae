"""Motion under torques: kicks between exact free motions.

torqued_rotation   `TorquedRotation`
steps              how it is integrated, with fixed or varying steps
schemes            the splitting schemes by name, `Scheme`
"""

from attitude.splitting.schemes import SCHEMES, Scheme, scheme
from attitude.splitting.torqued_rotation import TorquedRotation

__all__ = ["SCHEMES", "Scheme", "TorquedRotation", "scheme"]
