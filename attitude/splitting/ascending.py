"""Principal axes as the short exact step (`attitude.solution.step`) wants them."""

import numpy as np


def ascending(body):
    """Principal moments in ascending order, and the axes they belong to.

    Given
        body     an `attitude.Body`
    Returned
        moments  (3,) times a power of two that puts the largest between 0.5 and 1: a free motion
                 depends on their ratios only
        axes     (3, 3) columns: unit vectors over the body axes, right-handed
    """
    order = np.argsort(body.moments, kind="stable")
    axes = body.principal_axes[:, order]
    moments = body.moments[order]
    moments = np.ldexp(moments, -int(np.frexp(moments[2])[1]))
    return moments, axes if np.linalg.det(axes) > 0.0 else -axes
