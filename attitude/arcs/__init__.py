"""Free motion between instantaneous changes: manoeuvres, impacts, deployments, dockings.

arcs         `Arcs`
changes      `Impulse`, `InertiaChange`
triggers     changes at an event instead of an epoch: `AxisCrossesDirection`, `PointMeetsPlane`
joint_times  the given times of changes, in order
sensitivity  derivatives of a chain by the state and the moments at its epoch
"""

from attitude.arcs.arcs import Arcs
from attitude.arcs.changes import Impulse, InertiaChange
from attitude.arcs.triggers import AxisCrossesDirection, PointMeetsPlane

__all__ = ["Arcs", "AxisCrossesDirection", "Impulse", "InertiaChange", "PointMeetsPlane"]
