"""What a body looks like: triangle meshes, the ellipsoid, and spacecraft of simple parts.

Coordinates are metres in body axes.  Nothing here knows of light or of time.
"""

from attitude.shape.ellipsoid import Ellipsoid
from attitude.shape.files import read
from attitude.shape.integrals import MassProperties
from attitude.shape.mesh import Mesh
from attitude.shape.solids import box, box_wing, cylinder

__all__ = ["Ellipsoid", "MassProperties", "Mesh", "box", "box_wing", "cylinder", "read"]
