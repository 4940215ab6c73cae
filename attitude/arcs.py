"""Free motion between instantaneous changes: manoeuvres, impacts, deployments, dockings.

arcs         `Arcs`
changes      `Impulse`, `InertiaChange`
triggers     changes at an event instead of an epoch: `AxisCrossesDirection`, `PointMeetsPlane`
joint_times  the given times of changes, in order
sensitivity  derivatives of a chain by the state and the moments at its epoch
"""

from attitude.torques._arcs import Arcs, Impulse, InertiaChange
from attitude.torques._triggers import AxisCrossesDirection, PointMeetsPlane, Trigger

__all__ = ["Arcs", "AxisCrossesDirection", "Impulse", "InertiaChange", "PointMeetsPlane", "Trigger"]
