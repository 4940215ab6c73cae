"""Convert spin states from and to the form of papers: periods, pole and angles.

published            `published`, and `from_energy`, `from_pole` ...: the reverse conversions
states, arrays       `from_periods` for one body, `states_from_periods` for arrays of bodies
conventions          the axes of the L and S conventions and their Euler angles
dynamic_inertia      L^2/2E and the moments that published periods and ratios admit
regular_precession   the limit of a symmetric body
uncertainty          `spread`: how errors of published numbers propagate to periods and angles
"""

from attitude.motions._published import (
    PeriodStates,
    Published,
    from_angles,
    from_energy,
    from_pole,
    moments_from_ratios,
    possible,
    published,
    states_from_periods,
    symmetric_moments,
    total_spin,
)
from attitude.motions._published import states_from_two_periods as from_periods
from attitude.motions._uncertainty import spread

__all__ = [
    "PeriodStates",
    "Published",
    "from_angles",
    "from_energy",
    "from_periods",
    "from_pole",
    "moments_from_ratios",
    "possible",
    "published",
    "spread",
    "states_from_periods",
    "symmetric_moments",
    "total_spin",
]
