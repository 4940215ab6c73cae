"""Epochs: dates, Time objects and plain seconds to TDB seconds in two doubles, and back.

inputs        `instant` and `seconds_since`: read the epochs that callers give
kinds         the kind of the epochs given, and their list
readers       a reader for each kind of epoch
instants      `Instant`, `times`
text          ISO 8601 and CCSDS dates
time_scales   every time scale to TDB and back, for arrays
"""

from attitude.epochs._inputs import instant, past_j2000, plain_seconds, seconds_since
from attitude.epochs._instants import Instant, times

__all__ = ["Instant", "instant", "past_j2000", "plain_seconds", "seconds_since", "times"]
