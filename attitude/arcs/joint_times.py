"""The times of changes, as far as they are given, in two doubles and in order."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs
from attitude.arcs.triggers import Trigger
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.arcs.changes import Change
    from attitude.epochs import Instant

    Pair = tuple[float, float]


def given(changes: Sequence[Change], epoch: Instant) -> list[Pair | None]:
    """Seconds (high, low) since an epoch of each change; None for one at an event.

    Raises
    ------
    AttitudeError
        For times that are not one finite epoch, equal, or not in order after the epoch.
    """
    times = [_seconds(change.at, epoch, f"changes[{k}].at") for k, change in enumerate(changes)]
    _check_order(times)
    return times


def _seconds(at: Any, epoch: Instant, name: str) -> Pair | None:
    if isinstance(at, Trigger):
        return None
    seconds, low = epochs.seconds_since(epoch, at, name=name)
    if np.ndim(seconds):
        raise AttitudeError(f"{name} holds {np.size(seconds)} epochs; give one.")
    pair = float(seconds), 0.0 if low is None else float(low)
    if not np.isfinite(sum(pair)):
        raise AttitudeError(f"{name} is {pair[0]}; give a finite epoch.")
    return pair


def _check_order(times: list[Pair | None]) -> None:
    before, whose = (0.0, 0.0), "the epoch of the spin"
    for k, time in enumerate(times):
        if time is None:
            continue
        if time <= before:
            early = (before[0] - time[0]) + (before[1] - time[1])
            how = f"{early:.2g} s earlier than" if time < before else "the same as"
            raise AttitudeError(
                f"changes[{k}] at {time[0]:.9g} s is {how} {whose} ({before[0]:.9g} s); give "
                "changes in order of time, after the epoch of the spin, and one change where "
                "several have the same epoch."
            )
        before, whose = time, f"changes[{k}]"
