"""Epochs: dates, Time objects and plain seconds to TDB seconds in two doubles, and back.

_inputs        `instant`, `seconds_since`, `past_j2000`, `plain_seconds`: each kind of epoch, read
_instants      `Instant`, `times`; dates as text
_time_scales   every time scale to TDB and back, for arrays
_ccsds         time systems and time codes of CCSDS messages
"""

from attitude.epochs._inputs import instant, past_j2000, plain_seconds, seconds_since
from attitude.epochs._instants import Instant, times

__all__ = ["Instant", "instant", "past_j2000", "plain_seconds", "seconds_since", "times"]
