"""What a search returns: epochs in two doubles, and what happens at each."""

from functools import cached_property

import numpy as np

from attitude import epochs
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen


class Events(Immutable):
    """Events in order of time; ``times, values = events`` takes them apart.

    Attributes
    ----------
    epoch : Instant or None
        From which seconds are counted; None where a plain function of seconds was searched.
    seconds, low : (N,) arrays
        TDB seconds since `epoch`: seconds + low.
    values : (N,) array
        What begins there: True or False of a condition, the state of a plain function; of an
        extremum, the value that is reached.
    which : (N,) array of int
        Number of the condition, where several were searched at once; else zeros.
    time : astropy Time
        The epochs in TDB (made when first asked for).
    """

    def __init__(self, epoch, seconds, low, values, which=None):
        self._set("epoch", epoch)
        self._set("seconds", frozen(seconds))
        self._set("low", frozen(low))
        self._set("values", frozen(values))
        self._set("which", frozen(np.zeros(len(seconds), int) if which is None else which))

    @classmethod
    def joined(cls, epoch, parts, kind=bool):
        """The events of several searches, one after the other, as one."""
        if not parts:
            return cls(epoch, np.zeros(0), np.zeros(0), np.zeros(0, kind), np.zeros(0, int))
        columns = zip(*((p.seconds, p.low, p.values, p.which) for p in parts), strict=True)
        return cls(epoch, *(np.concatenate(column) for column in columns))

    @cached_property
    def time(self):
        if self.epoch is None:
            raise AttitudeError(
                "the epoch is not known, since a plain function of seconds was searched; give "
                "epoch= to the search to have dates."
            )
        return epochs.times(self.epoch, self.seconds, self.low)

    def __iter__(self):
        """The two arrays (times, values); the times are `seconds`."""
        return iter((self.seconds, self.values))

    def __len__(self):
        return len(self.seconds)

    def __getitem__(self, index):
        """Some of the events: events[:10], events[events.values], events[events.which == 2]."""
        index = np.atleast_1d(np.arange(len(self))[index])
        return Events(
            self.epoch, self.seconds[index], self.low[index], self.values[index], self.which[index]
        )

    def at(self, source):
        """What a motion or a scene is at these epochs."""
        return source.at(self.seconds, self.low)

    def spans(self):
        """Of one condition: (begin, end) in seconds of each span that is within the search, (M, 2).

        A span that is cut by an end of the search is left out.
        """
        if self.values.dtype != bool or len(np.unique(self.which)) > 1:
            raise AttitudeError(
                "spans are those of one condition that begins and ceases; pick it with "
                "events[events.which == k]."
            )
        begins = np.flatnonzero(self.values[:-1] & ~self.values[1:])
        return np.stack([self.seconds[begins], self.seconds[begins + 1]], axis=-1)

    def __repr__(self):
        start = "" if self.epoch is None else f" from {self.epoch.utc_iso} UTC"
        return f"<{len(self)} Events, seconds{start}>"
