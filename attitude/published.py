"""Convert spin states from and to the form of papers: periods, pole and angles.

These names stand in `attitude.motions`: `published`; `from_energy`, `from_pole` ..., the reverse
conversions, `states_from_periods` for arrays of bodies; `possible` and `moments_from_ratios`, the
moments that published periods and ratios admit; `symmetric_moments` and `total_spin`, the limit of
a symmetric body; `spread`, how errors of published numbers propagate to periods and angles.
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
