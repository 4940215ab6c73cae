"""Free motion between instantaneous changes: manoeuvres, impacts, deployments, dockings.

These names stand in `attitude.torques`: `Arcs`, with `Impulse` and `InertiaChange`; changes at an
event instead of an epoch by `AxisCrossesDirection`, `PointMeetsPlane` or another `Trigger`.
"""

from attitude.torques._arcs import Arcs, Impulse, InertiaChange
from attitude.torques._triggers import AxisCrossesDirection, PointMeetsPlane, Trigger

__all__ = ["Arcs", "AxisCrossesDirection", "Impulse", "InertiaChange", "PointMeetsPlane", "Trigger"]
