"""The epochs at which conditions begin and cease."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, validation
from attitude.conditions.condition import Condition, Joinable, condition_of
from attitude.errors import AttitudeError
from attitude.events.advance import Advance
from attitude.events.combined import changed, channels_of, one_source, sign_changes
from attitude.events.events import Events
from attitude.events.search import difference
from attitude.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from typing import TypeAlias

    from numpy.typing import ArrayLike

    from attitude.annotations import Epoch, EpochOrSeconds, FloatArray, IntArray, Real
    from attitude.conditions.moments import Pair

    # A state (N,) at seconds (N,).
    StateFunction: TypeAlias = Callable[[FloatArray], ArrayLike]

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
        TDB seconds since the motion's epoch, or epochs of any type that ``motion.at`` takes.
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
    given = [f] if isinstance(f, Joinable) else list(f)
    if not given:
        raise AttitudeError("the list of conditions is empty; give one or more.")
    conditions = [condition_of(each, "the list of conditions") for each in given]
    source = one_source(conditions)
    begin, end = span(source.epoch, start, stop)
    channels = channels_of(conditions)
    for hi, lo, number, rising in sign_changes(conditions, channels, begin, end):
        if not len(hi):
            continue
        moment = source.at(hi, lo)
        found = [changed(each, channels, moment, number, rising) for each in conditions]
        which, row = np.nonzero([kept for kept, _ in found])
        if len(row):
            order = np.lexsort((which, row))
            which, row = which[order], row[order]
            values = np.array([after for _, after in found])[which, row]
            yield Events(source.epoch, hi[row], lo[row], values, which)


def shadow_state(lit: Scene | StateFunction) -> ShadowState:
    """A function of seconds for `find_discrete`: 0 in full light, 1 in penumbra, 2 in umbra.

    Parameters
    ----------
    lit : Scene, or function
        A function of seconds (N,) returns the fraction (N,) of the Sun's disc that is seen.  For a
        Scene the fraction is ``lit_fraction`` at epochs of reception, and seconds count from the
        epoch of its motion.

    >>> lit = lambda t: np.clip(0.5 + np.cos(0.001 * t), 0, 1)
    >>> times, states = find_discrete(0, 6000, shadow_state(lit), step=60)
    >>> times.round(3), states            # penumbra, umbra, penumbra, light
    (array([1047.198, 2094.395, 4188.79 , 5235.988]), array([1, 2, 1, 0]))
    """
    if isinstance(lit, Scene):
        return ShadowState(lit, lit.epoch)
    if not callable(lit):
        raise AttitudeError(f"lit is {lit!r}; give a Scene or a function of seconds.")
    return ShadowState(lit)


class ShadowState(Joinable):
    """0 in full light, 1 in penumbra, 2 in umbra, at seconds (N,); made by `shadow_state`.

    That of a Scene stands for the condition that the body is in shadow: penumbra or umbra.

    Attributes
    ----------
    lit : Scene or function
        Gives the fraction of the Sun's disc that is seen.
    epoch : Instant or None
        From which seconds count, if `lit` is a Scene with a motion.
    """

    def __init__(self, lit: Scene | StateFunction, epoch: epochs.Instant | None = None) -> None:
        self.lit, self.epoch = lit, epoch

    def __call__(self, t: FloatArray) -> IntArray:
        lit = self.lit.at(t).lit_fraction if isinstance(self.lit, Scene) else self.lit(t)
        fraction = np.asarray(lit, dtype=np.float64)
        return (fraction < 1.0).astype(np.int64) + (fraction <= 0.0)

    @property
    def condition(self) -> Condition:
        """The condition that a part of the Sun's disc is hidden.

        Raises
        ------
        AttitudeError
            For a shadow by a function of seconds.
        """
        if not isinstance(self.lit, Scene):
            raise AttitudeError(
                "the shadow is a function of seconds, which has no scene; give a Scene to "
                "shadow_state to combine it with other conditions."
            )
        return self.lit.quantity("lit_fraction") < 1.0


def span(epoch: epochs.Instant, start: EpochOrSeconds, stop: EpochOrSeconds) -> tuple[Pair, Pair]:
    """Start and stop as pairs of TDB seconds since an epoch.

    Raises
    ------
    AttitudeError
        For ends that are not one finite epoch each, and a stop before the start.
    """
    ends = []
    for value, name in ((start, "start"), (stop, "stop")):
        hi, lo = epochs.seconds_since(epoch, value, name=name)
        if hi.shape != () or not np.isfinite(hi):
            raise AttitudeError(f"{name} is {value!r}; give one finite epoch.")
        ends.append((float(hi), 0.0 if lo is None else float(lo)))
    begin, end = ends
    if difference(begin, end) < 0.0:
        raise AttitudeError(f"stop is {-difference(begin, end):.9g} s before start; exchange them.")
    return begin, end


def plain_step(step: Real | None) -> float:
    """The spacing of samples of a plain function, s.

    Raises
    ------
    AttitudeError
        For a step that is not given, or not positive.
    """
    if step is None:
        raise AttitudeError(
            "the rate of change of a plain function is unknown; give step=, the spacing of its "
            "samples in s."
        )
    return validation.positive(step, "step", unit="s")


def _of_function(start, stop, f, step, epoch, tolerance):
    step = plain_step(step)
    tolerance = (
        1e-9 * step if tolerance is None else validation.positive(tolerance, "tolerance", unit="s")
    )
    own = f.epoch if isinstance(f, ShadowState) else None
    if own is not None and epoch is not None:
        raise AttitudeError("the function has the epoch of its scene; leave epoch= out.")
    begin, end, epoch = plain_span(start, stop, own if epoch is None else epoch)
    found, left, advance = [], begin, Advance((begin, 0.0), (end, 0.0))
    while left < end:
        right = min(end, left + _BLOCK * step)
        t = np.linspace(left, right, max(2, 1 + int(np.ceil((right - left) / step))))
        found.append(_bisected(f, t, _states(f, t), tolerance))
        left = right
        advance.reached((left, 0.0))
    if not found:
        found.append((np.zeros(0), _states(f, np.array([begin]))[:0]))
    seconds, values = (np.concatenate(part) for part in zip(*found, strict=True))
    return Events(epoch, seconds, np.zeros(len(seconds)), values)


def plain_span(
    start: EpochOrSeconds, stop: EpochOrSeconds, epoch: Epoch | None
) -> tuple[float, float, epochs.Instant | None]:
    """Start and stop for a plain function in seconds, and the epoch from which they count."""
    if epoch is not None:
        instant = epochs.instant(epoch)
        begin, end = (hi + lo for hi, lo in span(instant, start, stop))
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
    times = np.concatenate(times) if times else np.zeros(0)
    values = np.concatenate(values) if values else states[:0]
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
