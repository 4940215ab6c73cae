"""Brightness of a convex body from the areas of its facets by normal, with derivatives; compiled.

Lommel-Seeliger plus a share of Lambert: S = mu0 mu (1/(mu0 + mu) + c) for each lit and seen facet.
"""

from __future__ import annotations

from attitude.compilation.decorators import reduction


@reduction
def shares(sun, observer, normals, areas, lambert, parts, by_directions):
    """Brightness of each facet and epoch, into parts (N, F), and slopes, into (N, 6).

    sun, observer (N, 3): unit vectors over body axes; normals (3, F); areas (F,).  The slopes are
    those of the sum by the vectors to Sun and observer.
    """
    count = areas.size
    for i in range(sun.shape[0]):
        s0, s1, s2 = sun[i, 0], sun[i, 1], sun[i, 2]
        o0, o1, o2 = observer[i, 0], observer[i, 1], observer[i, 2]
        a0 = a1 = a2 = b0 = b1 = b2 = 0.0
        for j in range(count):
            x, y, z = normals[0, j], normals[1, j], normals[2, j]
            m0 = max(s0 * x + s1 * y + s2 * z, 0.0)
            m = max(o0 * x + o1 * y + o2 * z, 0.0)
            area = areas[j] if m0 * m > 0.0 else 0.0
            over = 1.0 / max(m0 + m, 1e-9)
            parts[i, j] = area * m0 * m * (over + lambert)
            by_m0 = area * m * (m * over * over + lambert)
            by_m = area * m0 * (m0 * over * over + lambert)
            a0 += by_m0 * x
            a1 += by_m0 * y
            a2 += by_m0 * z
            b0 += by_m * x
            b1 += by_m * y
            b2 += by_m * z
        by_directions[i, 0], by_directions[i, 1], by_directions[i, 2] = a0, a1, a2
        by_directions[i, 3], by_directions[i, 4], by_directions[i, 5] = b0, b1, b2
