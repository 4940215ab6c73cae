"""What writers take: histories, tables, or a motion with epochs, in pieces that fit in memory."""

import numpy as np

from attitude import epochs
from attitude.attitude_table.table import AttitudeTable
from attitude.errors import AttitudeError
from attitude.history import AttitudeHistory
from attitude.motion import motion_of

PIECE = 16384


def only_segment(source, t, holder):
    """The one segment of what is given; AttitudeError for several, of which a file holds one."""
    parts = segments(source, t)
    if len(parts) != 1:
        raise AttitudeError(
            f"{len(parts)} segments are given; {holder} holds one. Write a file for each, or an "
            "AEM, ECSV or FITS."
        )
    return parts[0]


class Records:
    """One segment to be written: a motion and its epochs, evaluated piece by piece.

    Attributes
    ----------
    epoch : Instant
    seconds, low : (N,) arrays, low may be None
    has_rates : bool
        Whether its angular velocities are known better than from differences of attitudes.
    meta : dict
        What the file it came from said.
    """

    def __init__(self, motion, epoch, seconds, low, history=None):
        self.motion, self.epoch, self.seconds, self.low = motion, epoch, seconds, low
        self._history = history
        self.meta = dict(motion.meta)
        self.table = motion if isinstance(motion, AttitudeTable) else None
        if len(seconds) == 0:
            raise AttitudeError("there are no epochs to write; give one or more.")
        if not np.all(np.isfinite(seconds)):
            raise AttitudeError("some epochs are NaN, which no file can hold; leave them out.")
        steps = np.diff(seconds) if low is None else np.diff(seconds) + np.diff(low)
        if np.any(steps <= 0.0):
            k = int(np.flatnonzero(steps <= 0.0)[0])
            raise AttitudeError(
                f"epoch {k + 1} is not later than the one before it; files of attitudes hold "
                "increasing epochs, each once."
            )
        self.has_rates = motion.has_rates_at(seconds[:1], None if low is None else low[:1])

    def __len__(self):
        return len(self.seconds)

    def first_and_last(self):
        """The seconds and low of both ends, as arrays (2,)."""
        low = np.zeros(len(self.seconds)) if self.low is None else self.low
        return self.seconds[[0, -1]], low[[0, -1]]

    def pieces(self):
        """The records as AttitudeHistory pieces."""
        for start in range(0, len(self), PIECE):
            part = slice(start, start + PIECE)
            if self._history is not None:
                yield self._history[part]
            else:
                low = None if self.low is None else self.low[part]
                yield self.motion.at(self.seconds[part], low)


def segments(source, t=None):
    """The `Records` of what a writer was given.

    Parameters
    ----------
    source : AttitudeHistory, AttitudeTable, Records, a list of them (several segments), or with `t`
        anything that has ``.at(t)``
    t : epochs, as of ``.at(t)``
    """
    if isinstance(source, Records):
        return [source]
    if t is not None:
        return [_of_motion(source, t)]
    if isinstance(source, (list, tuple)):
        return [each for part in source for each in segments(part)]
    if isinstance(source, AttitudeTable):
        return [_of_history(part.history) for part in source.segments]
    if isinstance(source, AttitudeHistory):
        return [_of_history(source)]
    raise AttitudeError(
        f"{type(source).__name__} is given to be written; give an AttitudeHistory, an "
        "AttitudeTable, a list of them, or a motion and its epochs (t=)."
    )


def _of_history(history):
    if len(history.shape) != 1:
        raise AttitudeError(
            f"the epochs have shape {history.shape}; a file wants a row of them, (N,)."
        )
    return Records(motion_of(history.motion), history.epoch, history.seconds, history.low, history)


def _of_motion(motion, t):
    motion = motion_of(motion, "source")
    seconds, low = epochs.seconds_since(motion.epoch, t)
    if seconds.ndim != 1:
        raise AttitudeError(f"t has shape {seconds.shape}; a file wants a row of epochs, (N,).")
    return Records(motion, motion.epoch, seconds, low)
