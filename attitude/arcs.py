"""Chains of free rotations with impulses, changes of inertia and triggers.

It hands on names of `attitude.torques`; the code is in torques/_arcs.py and torques/_triggers.py.
"""

from attitude.torques._arcs import Arcs, Impulse, InertiaChange
from attitude.torques._triggers import AxisCrossesDirection, PointMeetsPlane, Trigger

__all__ = ["Arcs", "AxisCrossesDirection", "Impulse", "InertiaChange", "PointMeetsPlane", "Trigger"]
