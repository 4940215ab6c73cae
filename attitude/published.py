"""Spin states in the form of papers (periods, pole, angles), to and from attitude and rates.

The code is in motions/_published.py; `spread` is in motions/_uncertainty.py.
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
