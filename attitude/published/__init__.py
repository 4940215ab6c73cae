"""Spin states as papers print them: periods, pole and angles, in either convention, and back.

published            `from_periods` and its kin, `published`: states to and from published numbers
conventions          the axes of the L and S conventions and their Euler angles
dynamic_inertia      L^2/2E and the moments that published periods and ratios admit
regular_precession   the limit of a symmetric body
uncertainty          `spread`: which states rounded published numbers admit
"""

from attitude.published.published import (
    Published,
    from_angles,
    from_energy,
    from_periods,
    from_pole,
    published,
    relaxed,
)

__all__ = [
    "Published",
    "from_angles",
    "from_energy",
    "from_periods",
    "from_pole",
    "published",
    "relaxed",
]
