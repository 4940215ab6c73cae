"""Sign changes of the channels of conditions, each searched only where it can decide one.

First the thresholds of observables (`levels`) are found over the whole span.  Between their
changes the conditions are open or decided whatever the other channels are; those are searched
(`search`) in the open parts only: glints above the horizon at night cost the time of the nights.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from attitude.conditions.channel import Level
from attitude.conditions.logic import undecided
from attitude.conditions.moments import same_source
from attitude.errors import AttitudeError
from attitude.events import levels
from attitude.events.advance import Advance
from attitude.events.search import crossings

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from attitude.annotations import BoolArray, IntArray
    from attitude.conditions.channel import Channel
    from attitude.conditions.condition import Condition
    from attitude.conditions.moments import Moment, Pair, Source
    from attitude.events.levels import Changes


def one_source(conditions: Sequence[Condition]) -> Source:
    """The source that all conditions share.

    Raises
    ------
    AttitudeError
        For conditions of different motions.
    """
    for each in conditions:
        if not same_source(each.source, conditions[0].source):
            raise AttitudeError(
                "the conditions are of different motions or scenes; search each separately."
            )
    return conditions[0].source


def channels_of(conditions: Sequence[Condition]) -> list[Channel]:
    """The different channels of conditions."""
    return list(dict.fromkeys(each for one in conditions for each in one.channels))


def sign_changes(
    conditions: Sequence[Condition], channels: Sequence[Channel], start: Pair, stop: Pair
) -> Iterator[Changes]:
    """The sign changes that can change a condition, block by block in order of time.

    Yields seconds hi + lo (N,), the number (N,) of the channel among `channels`, and whether the
    change is one to True (N,).
    """
    source = conditions[0].source
    slow = {k: each for k, each in enumerate(channels) if isinstance(each, Level)}
    fast = [k for k, each in enumerate(channels) if not isinstance(each, Level)]
    if not slow:
        yield from crossings(source, channels, start, stop)
        return
    spacings = levels.spacings([*slow.values()], start, stop)
    advance = Advance(start, stop, len(set(spacings)) + bool(fast))
    hi, lo, number, rising = levels.changes(
        source, [*slow.values()], start, stop, spacings, advance
    )
    found = hi, lo, np.array([*slow])[number], rising
    done = 0
    for first, last, begin, end, needed in _open_parts(
        conditions, channels, fast, found, start, stop
    ):
        yield _part(found, done, first)
        levelled = _part(found, first, last)
        yield from _merged(source, channels, needed, begin, end, levelled, advance)
        done = last
    advance.end()
    yield _part(found, done, len(hi))


def _part(found: Changes, first: int, last: int) -> Changes:
    hi, lo, number, rising = found
    part = slice(first, last)
    return hi[part], lo[part], number[part], rising[part]


def _open_parts(
    conditions: Sequence[Condition],
    channels: Sequence[Channel],
    fast: Sequence[int],
    found: Changes,
    start: Pair,
    stop: Pair,
) -> Iterator[tuple[int, int, Pair, Pair, IntArray]]:
    """The parts of a span in which a condition is open, joined where the same channels decide it.

    Numbers of the first change after the begin and after the end of the part, begin and end, and
    the numbers of the channels that can decide a condition there.
    """
    hi, lo, number, rising = found
    moment = conditions[0].source.at(np.array([start[0]]), np.array([start[1]]))
    # The sign of each channel before the first change and after each, -1 for those not searched.
    signs = np.full((len(channels), len(hi) + 1), -1)
    for k, channel in enumerate(channels):
        if k not in fast:
            place = np.where(number == k, np.arange(1, len(hi) + 1), 0)
            last = np.maximum.accumulate(np.concatenate([[0], place]))
            known = np.concatenate([channel.sign(moment), rising])
            signs[k] = known[last]
    need = np.zeros((len(channels), len(hi) + 1), dtype=bool)
    for each in conditions:
        own = [channels.index(channel) for channel in each.channels]
        is_open = undecided(each.logic, [signs[k] for k in own])
        for k in own:
            need[k] |= is_open & (k in fast)
    ends = [start, *zip(hi.tolist(), lo.tolist(), strict=True), stop]
    edges = (np.flatnonzero(np.any(need[:, 1:] != need[:, :-1], axis=0)) + 1).tolist()
    for a, b in pairwise([0, *edges, len(hi) + 1]):
        if np.any(need[:, a]):
            yield a, b - 1, ends[a], ends[b], np.flatnonzero(need[:, a])


def _merged(
    source: Source,
    channels: Sequence[Channel],
    needed: IntArray,
    begin: Pair,
    end: Pair,
    levelled: Changes,
    advance: Advance,
) -> Iterator[Changes]:
    """The sign changes of some channels in a part, with those of levels, in order of time."""
    first = 0
    some = [channels[k] for k in needed]
    for hi, lo, number, rising in crossings(source, some, begin, end, advance):
        upto = int(np.searchsorted(levelled[0], hi[-1]))
        more = _part(levelled, first, upto)
        t, rest = np.concatenate([hi, more[0]]), np.concatenate([lo, more[1]])
        which = np.concatenate([needed[number], more[2]])
        up = np.concatenate([rising, more[3]])
        order = np.lexsort((rest, t))
        yield t[order], rest[order], which[order], up[order]
        first = upto
    yield _part(levelled, first, len(levelled[0]))


def changed(
    condition: Condition,
    channels: Sequence[Channel],
    moment: Moment,
    number: IntArray,
    rising: BoolArray,
) -> tuple[BoolArray, BoolArray]:
    """Whether sign changes at a block of epochs change a condition, and its new states (N,).

    Changes of several channels at one epoch are one change.
    """
    places = {channel: k for k, channel in enumerate(condition.channels)}
    own = np.array([places.get(channel, -1) for channel in channels])[number]
    kept, states = np.zeros(len(own), bool), np.zeros(len(own), bool)
    some = np.flatnonzero(own >= 0)
    if not len(some):
        return kept, states
    if len(condition.channels) == 1:
        after = condition.states([rising])
        return (own == 0) & (condition.states([~rising]) != after), after
    at = moment.source.at(moment.hi[some], moment.lo[some])
    own, up, every = own[some], rising[some], np.arange(len(some))
    before = np.array(condition.signs(at))
    after = before.copy()
    before[own, every], after[own, every] = ~up, up
    new = (at.hi[1:] != at.hi[:-1]) | (at.lo[1:] != at.lo[:-1])
    together = np.concatenate([[0], np.cumsum(new)])
    for k in np.flatnonzero(np.bincount(together) > 1):
        # Each of these epochs, which are one, takes the signs of all channels that change there.
        group = np.flatnonzero(together == k)
        for j in group:
            before[own[j], group], after[own[j], group] = ~up[j], up[j]
    states[some] = condition.states(list(after))
    is_last = np.concatenate([new, [True]])
    kept[some] = (condition.states(list(before)) != states[some]) & is_last
    return kept, states
