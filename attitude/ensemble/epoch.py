"""Epochs of members, and the epochs at which they are evaluated, as TDB seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import epochs, pairs, validation
from attitude.epochs import kinds
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, IntArray

_DATES = "ISO dates in UTC, an astropy or skyfield Time, datetimes or datetime64"


class Seconds(NamedTuple):
    """Epochs of members that are seconds already.

    Attributes
    ----------
    high, low : (1 or N,) arrays
        TDB seconds past J2000: high + low.
    """

    high: FloatArray
    low: FloatArray


def of_members(given: Any) -> FloatArray:
    """The epochs of members as TDB seconds past J2000 in two doubles, (2, 1) or (2, N).

    Raises
    ------
    AttitudeError
        For plain numbers, dates that cannot be read, and epochs that are not one or a row.
    """
    if isinstance(given, epochs.Instant):
        return np.array([[given.seconds], [given.low]])
    if isinstance(given, Seconds):
        return np.stack(pairs.two_sum(*given))
    if given is None:
        raise AttitudeError(f"epoch is missing; give one epoch, or one for each member: {_DATES}.")
    kind, _, _ = kinds.entries(given, "epoch", _DATES)
    if kind in kinds.LENGTHS:
        raise AttitudeError(
            f"epoch is {validation.shown(given)}, a length of time; give one epoch, or one for "
            f"each member: {_DATES}."
        )
    hi, lo = epochs.past_j2000(given, "epoch")
    if hi.ndim > 1:
        raise AttitudeError(f"epoch has shape {hi.shape}; give one epoch, or one for each member.")
    found = np.stack(pairs.two_sum(hi, lo)).reshape(2, -1)
    bad = np.flatnonzero(~np.isfinite(found[0]))
    if len(bad):
        raise AttitudeError(
            f"epoch {bad[0]} of {found.shape[1]} is missing (NaT, NaN or masked); give a date for "
            "each member."
        )
    return found


def shared(
    start: FloatArray, t: Any, low: ArrayLike | None, count: int
) -> tuple[FloatArray, FloatArray | None, bool]:
    """Epochs of all of N members: seconds and their second doubles, (1 or N, T), and if T is one.

    Parameters
    ----------
    start : (2, 1) or (2, N) array
        Of `of_members`.
    t : array_like, (), (T,) or (N, T)
        Seconds, durations or epochs, as for `attitude.epochs.seconds_since`.
    low : array_like or None
        Second double of plain seconds.
    count : int
        N.

    Raises
    ------
    AttitudeError
        As `attitude.epochs.seconds_since`; for other shapes; for TimeDeltas if the members have
        several epochs.
    """
    dates = _dates(start, t, low)
    hi, lo = _plain(start, t, low) if dates is None else dates
    if hi.ndim > 2 or (hi.ndim == 2 and len(hi) != count):
        raise AttitudeError(
            f"t has shape {hi.shape}; give (T,) for all members or ({count}, T), one row for each; "
            "for other rows give member=."
        )
    scalar = hi.ndim == 0
    hi = np.atleast_2d(hi)
    lo = None if lo is None else np.atleast_2d(lo)
    if dates is not None and lo is not None:
        hi, lo = pairs.add((hi, lo), -start[0][:, None], -start[1][:, None])
    return hi, lo, scalar


def received(
    start: epochs.Instant, shared: epochs.Instant | None, t: Any, low: ArrayLike | None
) -> tuple[FloatArray, FloatArray | None]:
    """Epochs (T,) of a scene as seconds since `start`, in two doubles.

    Raises
    ------
    AttitudeError
        For other shapes, and for plain seconds if the members share no epoch.
    """
    if shared is None:
        hi, lo = pairs.add(epochs.past_j2000(t, "t"), -start.seconds, -start.low)
    else:
        hi, lo = epochs.seconds_since(start, t, low)
    if hi.ndim != 1:
        raise AttitudeError(f"t has shape {hi.shape}; give (T,), the epochs of a scene.")
    return hi, lo


def of_rows(
    start: FloatArray, t: Any, low: ArrayLike | None, member: IntArray
) -> tuple[FloatArray, FloatArray | None, IntArray]:
    """Epochs of rows of any shape S: seconds, their second doubles and the members, of shape S.

    Parameters
    ----------
    start, t, low
        As of `shared`; t of shape S, or one epoch.
    member : array of int of shape S, or one number
        The member of each row.

    Raises
    ------
    AttitudeError
        As `shared`.
    """
    dates = _dates(start, t, low)
    hi, lo = _plain(start, t, low) if dates is None else dates
    if hi.shape != member.shape:
        if hi.ndim and member.ndim:
            raise AttitudeError(
                f"t has shape {hi.shape} and member {member.shape}; give one member for each epoch."
            )
        shape = hi.shape if hi.ndim else member.shape
        hi = np.array(np.broadcast_to(hi, shape))
        member = np.array(np.broadcast_to(member, shape))
        lo = None if lo is None else np.array(np.broadcast_to(lo, shape))
    if dates is not None and lo is not None:
        hi, lo = pairs.add((hi, lo), -start[0][member], -start[1][member])
    return hi, lo, member


def _plain(
    start: FloatArray, t: Any, low: ArrayLike | None
) -> tuple[FloatArray, FloatArray | None]:
    """Seconds as given, or since the one epoch of all members."""
    # Without members any epoch will do.
    first = epochs.Instant(*start[:, 0]) if start.shape[1] else epochs.Instant(0.0)
    return epochs.seconds_since(first, t, low)


def _dates(
    start: FloatArray, t: Any, low: ArrayLike | None
) -> tuple[FloatArray, FloatArray] | None:
    """Dates past J2000 if the members have epochs of their own; None for seconds."""
    if start.shape[1] == 1 or (type(t) is np.ndarray and t.dtype == np.float64):
        return None
    kind, _, _ = kinds.entries(t, "t", _DATES)
    if kind == "TimeDelta":
        raise AttitudeError(
            "t is a TimeDelta, but the members have epochs of their own; give seconds, a Quantity "
            "or dates."
        )
    if kind in kinds.LENGTHS:
        return None
    if low is not None:
        raise AttitudeError(
            f"low is given, but t is {validation.shown(t)}; leave out low, the second double of "
            "plain seconds."
        )
    return epochs.past_j2000(t, "t")
