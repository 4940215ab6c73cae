"""The epochs at which conditions begin and cease: `find_discrete`, and its result `Events`.

Thresholds of observables are searched first, by bounds of derivatives or by samples.  A threshold
of a smooth observable is searched as the channels of axes are, between knots that are its `spacing`
apart and with bounds of its derivatives from the differences of the knots (1.5 times the largest
first, twice the largest second one), so that two changes between neighbouring knots are found too;
an observable with a stated `rate` is searched with that bound of its first derivative.  Others are
divided between samples of different state: two changes within a spacing are missed.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, frozen
from attitude.catalog import motion_of
from attitude.conditions._conditions import Joinable, Level, condition_of, undecided
from attitude.conditions._moments import Source, same_source
from attitude.conditions._search import Advance, crossings, difference, isolated, refined, shifted
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.scene._scene import Scene, refuse_plain

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from typing import TypeAlias

    from astropy.time import Time
    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import (
        BoolArray,
        Epoch,
        EpochOrSeconds,
        FloatArray,
        IntArray,
        Real,
    )
    from attitude._support.tables import FlatTable
    from attitude.conditions._conditions import Condition
    from attitude.conditions._moments import Pair
    from attitude.motions._motion import HasAttitudes

    AnyMotion: TypeAlias = HasAttitudes | Scene
    StateFunction: TypeAlias = Callable[[FloatArray], ArrayLike]


# Knots in a block.
_BLOCK_OF_LEVELS = 4096
# Least part of a spacing into which an interval is divided, of a smooth observable.
_SMOOTH_PART = 2.0**-10
# That of an observable with a stated rate, which costs more divisions and proves more.
_RATED_PART = 2.0**-30
# Margins of bounds by differences, as those of directions (`attitude.conditions._moments`).
_MARGINS = (1.5, 2.0)
# Parts into which a section divides an interval.
_PARTS = 16
# Sections end at this part of the spacing, or at the resolution of a double.
_RESOLUTION = 1e-9


def _level_changes(conditions, channels, slow, start, advance, searches):
    """All sign changes of levels, each with the parts of its search, in order of time.

    Those between samples are divided only where they can decide a condition; others stay at the
    second sample.
    """
    source, blocks = conditions[0].source, []
    for search in sorted(set(searches)):
        # Levels of one spacing are sampled together: a view computes each quantity once.
        some = [k for k, other in zip(slow, searches, strict=True) if other == search]
        for begin, stop, spacing in search:
            blocks += _blocks(source, [(k, slow[k]) for k in some], begin, stop, spacing, advance)
        advance.next_round()
    blocks = _with_zeros(source, channels, blocks)
    sampled = {block.channel for block in blocks if block.step}
    unknown = [k for k in range(len(channels)) if k not in slow or k in sampled]
    known = _in_order([block.changes() for block in blocks if block.channel not in unknown])
    if not sampled:
        return known
    need = _needed(conditions, channels, unknown, known, start)
    count = np.pad(np.cumsum(need, axis=1), ((0, 0), (1, 0)))
    return _in_order(
        [block.divided(source, channels, known[0], count).changes() for block in blocks]
    )


def _with_zeros(source, channels, blocks):
    """The blocks with zeros in place of brackets: those of a channel are refined together."""
    bracketed = [block for block in blocks if block.values is not None]
    others = [block for block in blocks if block.values is None]
    for number in {block.channel for block in bracketed}:
        some = [block for block in bracketed if block.channel == number]
        counts = [len(block.begin) for block in some]
        base = np.repeat(np.transpose([block.base for block in some]), counts, axis=1)

        def evaluate(s, of, number=number, base=base):
            return channels[number].value(source.at(*pairs.add(base[:, of], s)))

        begin = np.concatenate([block.begin for block in some])
        end = np.concatenate([block.end for block in some])
        values = np.concatenate([block.values for block in some], axis=1)
        zeros = np.split(refined(evaluate, begin, end, *values), np.cumsum(counts)[:-1])
        others += [
            block._replace(begin=s, end=s, values=None)
            for block, s in zip(some, zeros, strict=True)
        ]
    return others


class _Block(NamedTuple):
    """Changes of a channel, s after a base; if step > 0, between samples, begin and end, of it."""

    channel: int
    base: Pair
    begin: FloatArray
    end: FloatArray
    rising: BoolArray
    step: float = 0.0
    # (2, N) at begin and end, of brackets that `_with_zeros` takes
    values: FloatArray | None = None

    def changes(self) -> tuple[FloatArray, FloatArray, IntArray, BoolArray]:
        """Seconds hi + lo, channels and new signs (N,)."""
        channels = np.full(len(self.end), self.channel)
        return *shifted(self.base, self.end), channels, self.rising

    def divided(
        self, source: Source, channels: Sequence[Any], known: FloatArray, count: IntArray
    ) -> _Block:
        """The block with epochs of the changes that decide a condition.

        Shapes: known (M,), s; count (channels, M + 2) of the parts before each, and before all and
        after all, in which a channel decides one.
        """
        level, end = channels[self.channel], self.end.copy()
        first, last = (shifted(self.base, s)[0] for s in (self.begin, end))
        parts = np.searchsorted(known, first), np.searchsorted(known, last, side="right") + 1
        some = count[self.channel, parts[1]] > count[self.channel, parts[0]]
        end[some] = _sectioned(
            lambda s: level.sign(source.at(*shifted(self.base, s))),
            self.begin[some],
            end[some],
            self.rising[some],
            _RESOLUTION * self.step,
        )
        return self._replace(end=end)


def _in_order(blocks):
    """The changes of several blocks in order of time."""
    none = np.zeros(0), np.zeros(0), np.zeros(0, int), np.zeros(0, bool)
    columns = [np.concatenate(column) for column in zip(none, *blocks, strict=True)]
    order = np.lexsort((columns[1], columns[0]))
    return tuple(column[order] for column in columns)


def _blocks(source, levels, start, stop, spacing, advance):
    """The changes of levels, (channel, Level), between knots one spacing apart, by blocks."""
    base = start
    while (remaining := difference(base, stop)) > 0.0:
        advance.reached(base)
        count = int(min(_BLOCK_OF_LEVELS, max(4, np.ceil(remaining / spacing))))
        last = count * spacing >= remaining
        length = remaining if last else count * spacing
        knots = np.arange(count + 1, dtype=np.float64) * (length / count)
        knots[-1] = length
        moment = source.at(*shifted(base, knots), step=length / count)
        for k, level in levels:
            signs = level.sign(moment)
            values = np.asarray(level.value(moment), dtype=np.float64)
            yield _in_block(source, k, level, base, knots, values, signs)
        base = stop if last else pairs.add(base, length)


def _in_block(source, channel, level, base, knots, values, signs):
    """The `_Block` of the changes of a level."""
    observable = level.observable
    step = knots[1] - knots[0]
    if not (observable.is_smooth or observable.rate) or not np.all(np.isfinite(values)):
        k = np.flatnonzero(signs[1:] != signs[:-1])
        return _Block(channel, base, knots[k], knots[k + 1], signs[k + 1], step)
    if observable.rate:
        first, second, step_share = observable.rate, np.inf, _RATED_PART
    else:
        slopes = np.diff(values) / step
        first = _MARGINS[0] * float(np.max(np.abs(slopes)))
        second = _MARGINS[1] * float(np.max(np.abs(np.diff(slopes)))) / step
        step_share = _SMOOTH_PART

    def evaluate(s: FloatArray) -> FloatArray:
        return level.value(source.at(*shifted(base, s)))

    noise = 1e-9 * (abs(level.threshold) + float(np.max(np.abs(values))))
    brackets = isolated(evaluate, knots, values, first, second, step_share * step, noise)
    rising = (brackets[2] < 0.0) == level.comparison.startswith(">")
    return _Block(channel, base, *brackets[:2], rising, values=brackets[2:])


def _sectioned(sign, a, b, rising, width):
    """The first changes (N,) between samples of different sign, by sections of sixteen parts."""
    while len(a) and np.max(b - a) > max(width, 16.0 * np.spacing(np.max(np.abs(b)))):
        points = a + (b - a) * (np.arange(_PARTS + 1) / _PARTS)[:, None]
        points[-1] = b
        new = np.empty(points.shape, dtype=bool)
        new[0], new[-1] = ~rising, rising
        new[1:-1] = sign(points[1:-1].reshape(-1)).reshape(_PARTS - 1, -1)
        first = np.argmax(new == rising, axis=0)
        every = np.arange(len(first))
        a, b = points[first - 1, every], points[first, every]
    return b


# ---- Sign changes of the channels of conditions, each searched only where it can decide one
# First the thresholds of observables are found over the whole span.  Between their changes the
# conditions are open or decided whatever the other channels are; those are searched
# in the open parts only: glints above the horizon at night cost the time of the nights.


def _sign_changes(conditions, channels, start, stop):
    """Blocks of changes that can change a condition: seconds hi + lo, channel, to True (N,)."""
    source = conditions[0].source
    slow = {k: channel for k, channel in enumerate(channels) if isinstance(channel, Level)}
    fast = [k for k, channel in enumerate(channels) if not isinstance(channel, Level)]
    if not slow:
        yield from crossings(source, channels, start, stop)
        return
    searches = [level.observable._searches(start, stop) for level in slow.values()]
    advance = Advance(start, stop, len(set(searches)) + bool(fast))
    slow_changes = _level_changes(conditions, channels, slow, start, advance, searches)
    done = 0
    for first, last, begin, end, needed in _open_parts(
        conditions, channels, fast, slow_changes, start, stop
    ):
        yield _part(slow_changes, done, first)
        levelled = _part(slow_changes, first, last)
        yield from _merged(source, channels, needed, begin, end, levelled, advance)
        done = last
    advance.end()
    yield _part(slow_changes, done, len(slow_changes[0]))


def _part(changes, first, last):
    return tuple(column[first:last] for column in changes)


def _open_parts(conditions, channels, fast, slow_changes, start, stop):
    """The parts of a span in which a condition is open, joined where the same channels decide it.

    Numbers of the first change after begin and after end, both ends, and the deciding channels.
    """
    hi, lo, _, _ = slow_changes
    need = _needed(conditions, channels, fast, slow_changes, start)
    ends = [start, *zip(hi.tolist(), lo.tolist(), strict=True), stop]
    edges = (np.flatnonzero(np.any(need[:, 1:] != need[:, :-1], axis=0)) + 1).tolist()
    for a, b in pairwise([0, *edges, len(hi) + 1]):
        if np.any(need[:, a]):
            yield a, b - 1, ends[a], ends[b], np.flatnonzero(need[:, a])


def _needed(conditions, channels, unknown, changes, start):
    """Whether channels that are not known decide a condition, (channels, M + 1) between changes."""
    hi, _, number, rising = changes
    moment = conditions[0].source.at(np.array([start[0]]), np.array([start[1]]))
    # The sign of each channel before the first change and after each, -1 for those not known.
    signs = np.full((len(channels), len(hi) + 1), -1)
    for k, channel in enumerate(channels):
        if k not in unknown:
            place = np.where(number == k, np.arange(1, len(hi) + 1), 0)
            last = np.maximum.accumulate(np.concatenate([[0], place]))
            known = np.concatenate([channel.sign(moment), rising])
            signs[k] = known[last]
    need = np.zeros((len(channels), len(hi) + 1), dtype=bool)
    for condition in conditions:
        places_of = [channels.index(channel) for channel in condition.channels]
        is_open = undecided(condition.logic, [signs[k] for k in places_of])
        for k in places_of:
            need[k] |= is_open & (k in unknown)
    return need


def _merged(source, channels, needed, begin, end, levelled, advance):
    """The sign changes of some channels in a part, with those of levels, in order of time."""
    first = 0
    some = [channels[k] for k in needed]
    for hi, lo, number, rising in crossings(source, some, begin, end, advance):
        upto = int(np.searchsorted(levelled[0], hi[-1]))
        yield _in_order([(hi, lo, needed[number], rising), _part(levelled, first, upto)])
        first = upto
    yield _part(levelled, first, len(levelled[0]))


def _changed(condition, channels, moment, number, rising):
    """Whether sign changes (several at an epoch are one) change a condition; new states (N,)."""
    places = {channel: k for k, channel in enumerate(condition.channels)}
    numbers_of = np.array([places.get(channel, -1) for channel in channels])[number]
    kept, states = np.zeros(len(numbers_of), bool), np.zeros(len(numbers_of), bool)
    some = np.flatnonzero(numbers_of >= 0)
    if not len(some):
        return kept, states
    if len(condition.channels) == 1:
        after = condition.states([rising])
        return (numbers_of == 0) & (condition.states([~rising]) != after), after
    at = moment.source.at(moment.hi[some], moment.lo[some])
    numbers_of, up, every = numbers_of[some], rising[some], np.arange(len(some))
    before = np.array(condition.signs(at))
    after = before.copy()
    before[numbers_of, every], after[numbers_of, every] = ~up, up
    new = (at.hi[1:] != at.hi[:-1]) | (at.lo[1:] != at.lo[:-1])
    together = np.concatenate([[0], np.cumsum(new)])
    for k in np.flatnonzero(np.bincount(together) > 1):
        # Each of these epochs, which are one, takes the signs of all channels that change there.
        group = np.flatnonzero(together == k)
        for j in group:
            before[numbers_of[j], group], after[numbers_of[j], group] = ~up[j], up[j]
    states[some] = condition.states(list(after))
    is_last = np.concatenate([new, [True]])
    kept[some] = (condition.states(list(before)) != states[some]) & is_last
    return kept, states


# ---- The source of a search that a caller gives: a motion, an object with ``.at(t)``, or a Scene


def source_of(subject: AnyMotion) -> Source:
    """The Source of a motion, of any other object with ``.at(t)``, or of a Scene."""
    if not isinstance(subject, Scene):
        return Source(motion_of(subject))
    if subject.motion is None:
        raise AttitudeError(
            "the scene has no motion, and this event is one of a rotation; give a scene with a "
            "motion, or compare quantities that need none: scene.quantity(...)."
        )
    return Source(subject.motion, subject)


# ---- The result of a search: epochs in two doubles, and what happens at each


class Events(Immutable):
    """Events in order of time; ``times, values = events`` unpacks seconds and values.

    Attributes
    ----------
    epoch : Instant or None
        From which seconds count; None if a plain function of seconds was searched.
    seconds, low : (N,) arrays
        TDB seconds since `epoch`: seconds + low.
    values : (N,) array
        The new state of a condition (True or False) or of a plain function; for an extremum, the
        value that is reached, in the unit of the quantity.
    which : (N,) array of int
        Index of the condition, if several were searched at once; otherwise zeros.
    unit : str
        Of the values of extrema; "" for states.
    """

    epoch: _instants.Instant | None
    seconds: FloatArray
    low: FloatArray
    values: NDArray[Any]
    which: IntArray
    unit: str

    def __init__(
        self,
        epoch: _instants.Instant | None,
        seconds: FloatArray,
        low: FloatArray,
        values: NDArray[Any],
        which: IntArray | None = None,
        unit: str = "",
    ) -> None:
        which = np.zeros(len(seconds), int) if which is None else which
        self._set_all(unit=unit, epoch=epoch, seconds=frozen(seconds), low=frozen(low))
        self._set_all(values=frozen(values), which=frozen(which))

    @classmethod
    def joined(
        cls,
        epoch: _instants.Instant | None,
        parts: Sequence[Events],
        kind: type = bool,
        unit: str = "",
    ) -> Events:
        """The events of successive searches in one object; without any, values of a given type."""
        if not parts:
            return cls(epoch, np.zeros(0), np.zeros(0), np.zeros(0, kind), None, unit)
        columns = zip(*((p.seconds, p.low, p.values, p.which) for p in parts), strict=True)
        seconds, low, values, which = (np.concatenate(column) for column in columns)
        return cls(epoch, seconds, low, values, which, unit)

    @cached_property
    def time(self) -> Time:
        """The epochs (N,) as an astropy Time in TDB.

        Raises
        ------
        AttitudeError
            If `epoch` is None.
        """
        if self.epoch is None:
            raise AttitudeError(
                "the epoch is not known, since a plain function of seconds was searched; give "
                "epoch= to the search to have dates."
            )
        return _instants.times(self.epoch, self.seconds, self.low)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        """The two arrays (seconds, values)."""
        return iter((self.seconds, self.values))

    def __len__(self) -> int:
        return len(self.seconds)

    def __getitem__(self, index: Any) -> Events:
        """Some of the events: events[:10], events[events.values], events[events.which == 2]."""
        index = np.atleast_1d(np.arange(len(self))[index])
        columns = (self.seconds, self.low, self.values, self.which)
        seconds, low, values, which = (column[index] for column in columns)
        return Events(self.epoch, seconds, low, values, which, self.unit)

    def at(self, source: Any) -> Any:
        """``source.at(...)`` at these epochs: the AttitudeHistory of a motion, the View of a Scene.

        The source has the `epoch` of the events.
        """
        return source.at(self.seconds, self.low)

    def spans(self) -> FloatArray:
        """Begin and end (M, 2) in seconds of each span in which a condition holds.

        A span that begins or ends outside of the search is left out.

        Raises
        ------
        AttitudeError
            For events of several conditions, and events that are not those of conditions.
        """
        if self.values.dtype != bool or len(np.unique(self.which)) > 1:
            raise AttitudeError(
                "spans are those of one condition that begins and ceases; pick it with "
                "events[events.which == k]."
            )
        begins = np.flatnonzero(self.values[:-1] & ~self.values[1:])
        return np.stack([self.seconds[begins], self.seconds[begins + 1]], axis=-1)

    def table(self) -> FlatTable:
        """An astropy QTable: time (UTC), value, and which of several conditions.

        ``.write("x.ecsv")`` keeps times and units; ``.write("x.csv")`` has the numbers alone.

        Raises
        ------
        AttitudeError
            If `epoch` is None.
        """
        from astropy.units import Unit

        from attitude._support.tables import FlatTable

        time = self.time.utc
        time.format = "isot"
        events = FlatTable({"time": time}, meta={"times": "UTC"})
        events["value"] = self.values * Unit(self.unit) if self.unit else np.array(self.values)
        if np.any(self.which):
            events["which"] = np.array(self.which)
        return events

    def to_pandas(self) -> Any:
        """A pandas DataFrame of `table`; AttitudeError if pandas is not installed."""
        return self.table().to_pandas()

    def __repr__(self) -> str:
        start = "" if self.epoch is None else f" from {self.epoch.utc_iso} UTC"
        return f"<{len(self)} Events, seconds{start}>"


# ---- The epochs at which conditions begin and cease

# Samples of a plain function in a block.
_BLOCK = 8192


def find_discrete(
    start: EpochOrSeconds,
    stop: EpochOrSeconds,
    f: Joinable | Sequence[Joinable] | StateFunction,
    *,
    step: Real | None = None,
    epoch: Epoch | None = None,
    tolerance: Real | None = None,
) -> Events:
    """The epochs at which a condition begins and ceases.

    Parameters
    ----------
    start, stop : epochs or seconds
        TDB seconds since the motion's epoch, or epochs of any type that ``motion.at`` takes; of a
        scene without a motion epochs only.
    f : Condition, list of Conditions of one motion, or function
        A function takes seconds (N,) and returns an integer or a bool for each, for example one
        made by `shadow_state`.
    step : float or Quantity
        s; for a function only: the spacing of its samples.  A change that is reversed between two
        samples is missed.
    epoch : epoch, optional
        For a function only: the epoch from which its seconds count; start and stop may then be
        dates, and the events have dates.
    tolerance : float or Quantity, optional
        s; for a function only: the accuracy of the epochs; 1e-9 of the step by default.

    Returns
    -------
    Events
        ``times, values = find_discrete(...)``: values are the new states, True or False, or those
        of the function.  Empty if nothing changes.

    Raises
    ------
    AttitudeError
        For a span that ends before it begins, and epochs at which an attitude or a direction is
        unknown.

    Notes
    -----
    For free rotations and arcs all events are found, except pairs nearer to each other than
    TOUCH = 1e-6 rad of the fastest rotation; the error of epochs is below 1e-12 of a turn where
    the crossing is not a touch.  benchmarks/events.py compares with samples.  For motions that are
    known at epochs only (tables, torques), and for directions by functions without bounds, the
    rates are estimated from samples.
    """
    if isinstance(f, ShadowState) or (not isinstance(f, Joinable) and callable(f)):
        return _of_function(start, stop, f, step, epoch, tolerance)
    if step is not None or epoch is not None or tolerance is not None:
        raise AttitudeError(
            "step, epoch and tolerance are for a plain function, not for conditions; leave them "
            "out."
        )
    parts = list(stream(start, stop, f))
    first = f if isinstance(f, Joinable) else f[0]
    return Events.joined(first.condition.epoch, parts)


def stream(
    start: EpochOrSeconds, stop: EpochOrSeconds, f: Joinable | Sequence[Joinable]
) -> Iterator[Events]:
    """The events of `find_discrete` block by block, for spans with more events than memory holds.

    Parameters
    ----------
    start, stop : as in `find_discrete`
    f : Condition, or list of Conditions of one motion

    Yields
    ------
    Events
        In order of time.
    """
    if not isinstance(f, (Joinable, list, tuple)):
        raise AttitudeError(
            f"f is {f!r}; give a Condition, such as events.in_cone(...), a list of them, or a "
            "function of seconds."
        )
    functions = [f] if isinstance(f, Joinable) else list(f)
    if not functions:
        raise AttitudeError("the list of conditions is empty; give one or more.")
    conditions = [condition_of(condition, "the list of conditions") for condition in functions]
    source = conditions[0].source
    if not all(same_source(condition.source, source) for condition in conditions):
        raise AttitudeError(
            "the conditions are of different motions or scenes; search each separately."
        )
    begin, end = span(source, start, stop)
    channels = list(dict.fromkeys(channel for one in conditions for channel in one.channels))
    for hi, lo, number, rising in _sign_changes(conditions, channels, begin, end):
        if not len(hi):
            continue
        moment = source.at(hi, lo)
        changes_of = [
            _changed(condition, channels, moment, number, rising) for condition in conditions
        ]
        which, row = np.nonzero([kept for kept, _ in changes_of])
        if len(row):
            order = np.lexsort((which, row))
            which, row = which[order], row[order]
            values = np.array([after for _, after in changes_of])[which, row]
            yield Events(source.epoch, hi[row], lo[row], values, which)


def shadow_state(lit: Scene | StateFunction) -> ShadowState:
    """A function of seconds for `find_discrete`: 0 in full light, 1 in penumbra, 2 in umbra.

    Parameters
    ----------
    lit : Scene, or function
        A function of seconds (N,) returns the fraction (N,) of the Sun's disc that is seen.  For a
        Scene the fraction is ``lit_fraction`` at epochs of reception, and seconds count from the
        epoch of its motion, from J2000 without one.

    >>> lit = lambda t: np.clip(0.5 + np.cos(0.001 * t), 0, 1)
    >>> times, states = find_discrete(0, 6000, shadow_state(lit), step=60)
    >>> times.round(3), states            # penumbra, umbra, penumbra, light
    (array([1047.198, 2094.395, 4188.79 , 5235.988]), array([1, 2, 1, 0]))
    """
    if isinstance(lit, Scene):
        return ShadowState(lit, lit.epoch or _instants.J2000)
    if not callable(lit):
        raise AttitudeError(f"lit is {lit!r}; give a Scene or a function of seconds.")
    return ShadowState(lit)


class ShadowState(Joinable):
    """0 in full light, 1 in penumbra, 2 in umbra, at seconds (N,); made by `shadow_state`.

    That of a Scene stands for the condition that the body is in shadow: penumbra or umbra.
    """

    def __init__(self, lit: Scene | StateFunction, epoch: _instants.Instant | None = None) -> None:
        self.lit, self.epoch = lit, epoch

    def __call__(self, t: FloatArray) -> IntArray:
        lit = self.lit
        seen = lit.quantity("lit_fraction")(t) if isinstance(lit, Scene) else lit(t)
        fraction = validation.returned(seen, "lit")
        return (fraction < 1.0).astype(np.int64) + (fraction <= 0.0)

    @property
    def condition(self) -> Condition:
        """The condition that a part of the Sun's disc is hidden."""
        if not isinstance(self.lit, Scene):
            raise AttitudeError(
                "the shadow is a function of seconds, which has no scene; give a Scene to "
                "shadow_state to combine it with other conditions."
            )
        return self.lit.quantity("lit_fraction") < 1.0


def span(source: Source, start: EpochOrSeconds, stop: EpochOrSeconds) -> tuple[Pair, Pair]:
    """Start and stop, dates without a motion, as pairs of TDB seconds since a source's epoch."""
    if source.motion is None:
        refuse_plain(start, "start")
        refuse_plain(stop, "stop")
    return _since(source.epoch, start, stop)


def _since(epoch, start, stop):
    """Start and stop as pairs of TDB seconds since an epoch."""
    begin = _inputs.one_since(epoch, start, "start")
    end = _inputs.one_since(epoch, stop, "stop")
    if difference(begin, end) < 0.0:
        raise AttitudeError(f"stop is {-difference(begin, end):.9g} s before start; exchange them.")
    return begin, end


def plain_step(step: Real | None) -> float:
    """The spacing of samples of a plain function, s."""
    if step is None:
        raise AttitudeError(
            "the rate of change of a plain function is unknown; give step=, the spacing of its "
            "samples in s."
        )
    return validation.positive(step, "step", unit="s")


def _of_function(start, stop, f, step, epoch, tolerance):
    step = plain_step(step)
    if tolerance is None:
        tolerance = 1e-9 * step
    tolerance = validation.positive(tolerance, "tolerance", unit="s")
    epoch_of_f = f.epoch if isinstance(f, ShadowState) else None
    if epoch_of_f is not None and epoch is not None:
        raise AttitudeError("the function has the epoch of its scene; leave epoch= out.")
    begin, end, epoch = plain_span(start, stop, epoch_of_f if epoch is None else epoch)
    brackets, left, advance = [], begin, Advance((begin, 0.0), (end, 0.0))
    while left < end:
        right = min(end, left + _BLOCK * step)
        t = np.linspace(left, right, max(2, 1 + int(np.ceil((right - left) / step))))
        brackets.append(_bisected(f, t, _states(f, t), tolerance))
        left = right
        advance.reached((left, 0.0))
    if not brackets:
        brackets.append((np.zeros(0), _states(f, np.array([begin]))[:0]))
    seconds, values = (np.concatenate(arrays) for arrays in zip(*brackets, strict=True))
    return Events(epoch, seconds, np.zeros(len(seconds)), values)


def plain_span(
    start: EpochOrSeconds, stop: EpochOrSeconds, epoch: Epoch | None
) -> tuple[float, float, _instants.Instant | None]:
    """Start and stop for a plain function in seconds, and the epoch from which they count."""
    if epoch is not None:
        instant = _inputs.instant(epoch)
        begin, end = (hi + lo for hi, lo in _since(instant, start, stop))
        return begin, end, instant
    # `number` refuses dates.
    begin = validation.number(start, "start", unit="s")  # type: ignore[arg-type]
    end = validation.number(stop, "stop", unit="s")  # type: ignore[arg-type]
    if end < begin:
        raise AttitudeError(f"stop is {begin - end:.9g} s before start; exchange them.")
    return begin, end, None


def _bisected(f, t, states, tolerance):
    """Epochs and new states of all changes between samples and between points of the bisection."""
    k = np.flatnonzero(states[1:] != states[:-1])
    a, b, p, q = t[k], t[k + 1], states[k], states[k + 1]
    times, values = [], []
    while len(a):
        done = b - a <= np.maximum(tolerance, 2.0 * np.spacing(np.abs(b)))
        times.append(b[done])
        values.append(q[done])
        a, b, p, q = a[~done], b[~done], p[~done], q[~done]
        if len(a):
            middle = a + 0.5 * (b - a)
            m = _states(f, middle)
            a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
            p, q = np.concatenate([p, m]), np.concatenate([m, q])
            change = p != q
            a, b, p, q = a[change], b[change], p[change], q[change]
    times, values = np.concatenate([t[:0], *times]), np.concatenate([states[:0], *values])
    order = np.argsort(times, kind="stable")
    return times[order], values[order]


def _states(f, t):
    states = np.asarray(f(t))
    if states.shape != t.shape or states.dtype.kind not in "biu":
        raise AttitudeError(
            f"the function returns {states.dtype} of shape {states.shape} for {t.size} epochs; it "
            "must return a bool or an integer for each."
        )
    return states
