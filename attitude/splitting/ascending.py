"""Principal axes in the order of their moments, as the exact short step takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body


def ascending(body: Body) -> tuple[FloatArray, FloatArray]:
    """Principal moments in ascending order, and the axes they belong to.

    Parameters
    ----------
    body : Body

    Returns
    -------
    moments : (3,) array
        Times a power of two that puts the largest between 0.5 and 1: a free motion depends on
        their ratios only.
    axes : (3, 3) array
        Columns: unit vectors over the body axes, right-handed.
    """
    order = np.argsort(body.moments, kind="stable")
    axes = body.principal_axes[:, order]
    moments = body.moments[order]
    moments = np.ldexp(moments, -int(np.frexp(moments[2])[1]))
    return moments, axes if np.linalg.det(axes) > 0.0 else -axes
