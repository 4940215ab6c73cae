"""Motion under torques: kicks between exact free motions.

torqued_rotation   `TorquedRotation`
steps              states after fixed steps; `varying_steps`, after those that an estimate allows
bounded_steps      states within a tolerance over a span
front              the advance of adaptive steps; `pace`, sizes of blocks
system             body, torques and scheme, packed for the compiled loops
schemes            the splitting schemes by name, `Scheme`
ascending          principal axes in the order of the moments
"""

from attitude.torques._schemes import SCHEMES, Scheme, scheme
from attitude.torques._torqued import TorquedRotation

__all__ = ["SCHEMES", "Scheme", "TorquedRotation", "scheme"]
