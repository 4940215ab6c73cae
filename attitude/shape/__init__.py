"""Shapes of bodies: triangle meshes, the ellipsoid, and spacecraft of simple parts.

Coordinates are metres in body axes.

_mesh        `Mesh`, its checks, edges and convexity; `MassProperties`; `FlatSide`, `flat_sides`
_ellipsoid   `Ellipsoid`, in closed form and as a mesh
_solids      `box`, `cylinder`, `box_wing`
_files       `read` and `Mesh.write`: OBJ, DAMIT, STL, PLY
_comparison  `compare`: how much two bodies have in common, and by which turn
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.shape._comparison import ShapeComparison, compare
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._files import read
from attitude.shape._mesh import FlatSide, MassProperties, Mesh, flat_sides
from attitude.shape._solids import box, box_wing, cylinder

__all__ = [
    "Ellipsoid",
    "FlatSide",
    "MassProperties",
    "Mesh",
    "ShapeComparison",
    "box",
    "box_wing",
    "compare",
    "cylinder",
    "flat_sides",
    "read",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
