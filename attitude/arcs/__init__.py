"""Free motion between instantaneous changes: manoeuvres, impacts, deployments, dockings.

arcs       `Arcs`
changes    `Impulse`, `InertiaChange`
triggers   changes at an event instead of an epoch: `AxisCrossesDirection`, `PointMeetsPlane`
"""

from attitude.arcs.arcs import Arcs
from attitude.arcs.changes import Impulse, InertiaChange
from attitude.arcs.triggers import AxisCrossesDirection, PointMeetsPlane

__all__ = ["Arcs", "AxisCrossesDirection", "Impulse", "InertiaChange", "PointMeetsPlane"]
