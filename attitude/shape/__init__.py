"""Shapes of bodies: triangle meshes, the ellipsoid, and spacecraft of simple parts.

Coordinates are metres in body axes.

mesh          `Mesh`
mesh_input    checks of its vertices, facets and materials
closure       edges, holes, facets that are doubled or inside out, connected parts
convexity     the test of convexity
integrals     mass, centre of mass and inertia: `MassProperties`
ellipsoid     `Ellipsoid`, in closed form and as a mesh
geodesic      even triangulations of the unit sphere
planes        `flat_sides`: facets of one normal and one material
solids        `box`, `cylinder`, `box_wing`
files         `read`: OBJ, DAMIT, STL, PLY
"""

from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._files import read
from attitude.shape._mesh import FlatSide, MassProperties, Mesh, flat_sides
from attitude.shape._solids import box, box_wing, cylinder

__all__ = [
    "Ellipsoid",
    "FlatSide",
    "MassProperties",
    "Mesh",
    "box",
    "box_wing",
    "cylinder",
    "flat_sides",
    "read",
]
