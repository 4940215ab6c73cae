"""Quaternions as arrays (..., 4), scalar first.

The code is in frames/quaternion.py.
"""

from attitude.frames.quaternion import (
    conjugate,
    from_euler,
    from_matrix,
    matrix,
    multiply,
    rotate,
    unit,
)

__all__ = ["conjugate", "from_euler", "from_matrix", "matrix", "multiply", "rotate", "unit"]
