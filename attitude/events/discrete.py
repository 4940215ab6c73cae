"""Where conditions begin and cease."""

import numpy as np

from attitude import epochs, validation
from attitude.errors import AttitudeError
from attitude.events.conditions import Condition
from attitude.events.events import Events
from attitude.events.search import crossings, difference, one_source
from attitude.scene.scene import Scene

# Samples of a plain function in a block.
_BLOCK = 8192


def find_discrete(start, stop, f, *, step=None, epoch=None, tolerance=None):
    """When a condition begins and ceases.

    Parameters
    ----------
    start, stop : epochs or seconds
        TDB seconds since the motion's epoch, or any epochs that ``motion.at`` takes.
    f : Condition, list of Conditions of one motion, or function
        A function takes seconds (N,) and returns an integer or a bool for each: what
        `shadow_state` makes, for example.
    step : float or Quantity
        s; for a function only: its samples.  What happens and is over between two samples is
        missed.
    epoch : epoch, optional
        For a function only: from which seconds are counted, so that dates can be given and told.
    tolerance : float or Quantity, optional
        s; for a function only: how well events are located; 1e-9 of the step unless given.

    Returns
    -------
    Events
        ``times, values = find_discrete(...)``: values are what begins, True or False (the new
        state of a function).  Empty where nothing changes.

    Raises
    ------
    AttitudeError
        For a span that ends before it begins, and where attitudes are not known.

    Notes
    -----
    Of a free rotation and of arcs no event is missed, but for pairs nearer to each other than
    TOUCH = 1e-6 rad of the fastest rotation; epochs are good to 1e-12 of a turn and more, where
    the crossing is not a touch.  benchmarks/events.py compares with samples.  Motions that are
    known at epochs only (tables, torques), and directions by functions without bounds, are
    sampled for their rates, which is an estimate.
    """
    if not isinstance(f, Condition) and callable(f):
        return _of_function(start, stop, f, step, epoch, tolerance)
    if step is not None or epoch is not None or tolerance is not None:
        raise AttitudeError("step, epoch and tolerance go with a plain function; leave them out.")
    parts = list(stream(start, stop, f))
    conditions = [f] if isinstance(f, Condition) else f
    return Events.joined(conditions[0].epoch, parts)


def stream(start, stop, f):
    """The same, block by block: yields `Events` in order, for spans whose events fill memory.

    Parameters
    ----------
    start, stop, f : as of `find_discrete`, but for a function
    """
    if not isinstance(f, (Condition, list, tuple)):
        raise AttitudeError(
            f"f is {f!r}; give a Condition, such as events.in_cone(...), a list of them, or a "
            "function of seconds."
        )
    conditions = [f] if isinstance(f, Condition) else list(f)
    if not conditions:
        raise AttitudeError("the list of conditions is empty; give one or more.")
    source = one_source(conditions)
    start, stop = span(source.epoch, start, stop)
    channels, owner, offset = [], [], []
    for k, each in enumerate(conditions):
        offset.append(len(channels))
        channels += each.channels
        owner += [k] * len(each.channels)
    owner, offset = np.array(owner), np.array(offset)
    for hi, lo, channel, rising in crossings(source, channels, start, stop):
        which = owner[channel]
        values, kept = np.zeros(len(hi), bool), np.zeros(len(hi), bool)
        for k in np.unique(which):
            here = np.flatnonzero(which == k)
            own = channel[here] - offset[k]
            moment = source.at(hi[here], lo[here])
            kept[here], values[here] = _changes(conditions[k], moment, own, rising[here])
        if np.any(kept):
            yield Events(source.epoch, hi[kept], lo[kept], values[kept], which[kept])


def shadow_state(lit):
    """A function of seconds for `find_discrete`: 0 in full light, 1 in penumbra, 2 in umbra.

    Parameters
    ----------
    lit : Scene, or function
        A function of seconds (N,) that returns the fraction (N,) of the Sun's disc that is seen;
        of a Scene it is ``lit_fraction`` at the epochs of reception, and seconds and dates are
        those of its motion.

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


class ShadowState:
    """0 in full light, 1 in penumbra, 2 in umbra, at seconds (N,) since its epoch."""

    def __init__(self, lit, epoch=None):
        self.lit, self.epoch = lit, epoch

    def __call__(self, t):
        lit = self.lit.at(t).lit_fraction if isinstance(self.lit, Scene) else self.lit(t)
        fraction = np.asarray(lit, dtype=np.float64)
        return (fraction < 1.0).astype(np.int64) + (fraction <= 0.0)


def _changes(condition, moment, channel, rising):
    """Whether crossings of one of its channels change a condition, and to what."""
    if len(condition.channels) == 1:
        after = condition.states([rising])
        return np.ones(len(rising), bool), after
    signs = condition.signs(moment)
    before, after = [s.copy() for s in signs], [s.copy() for s in signs]
    for k in range(len(signs)):
        before[k][channel == k] = ~rising[channel == k]
        after[k][channel == k] = rising[channel == k]
    after = condition.states(after)
    return condition.states(before) != after, after


def span(epoch, start, stop):
    """Both ends as pairs of seconds since an epoch."""
    ends = []
    for value, name in ((start, "start"), (stop, "stop")):
        hi, lo = epochs.seconds_since(epoch, value, name=name)
        if hi.shape != () or not np.isfinite(hi):
            raise AttitudeError(f"{name} is {value!r}; give one finite epoch.")
        ends.append((float(hi), 0.0 if lo is None else float(lo)))
    if difference(*ends) < 0.0:
        raise AttitudeError(f"stop is {-difference(*ends):.9g} s before start; exchange them.")
    return ends


def plain_step(step):
    """The spacing in s at which a plain function is sampled; it must be given."""
    if step is None:
        raise AttitudeError(
            "a plain function does not say how fast it changes; give step=, the spacing in s at "
            "which it is sampled."
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
    found, left = [], begin
    while left < end:
        right = min(end, left + _BLOCK * step)
        t = np.linspace(left, right, max(2, 1 + int(np.ceil((right - left) / step))))
        found.append(_bisected(f, t, _states(f, t), tolerance))
        left = right
    if not found:
        found.append((np.zeros(0), _states(f, np.array([begin]))[:0]))
    seconds, values = (np.concatenate(part) for part in zip(*found, strict=True))
    return Events(epoch, seconds, np.zeros(len(seconds)), values)


def plain_span(start, stop, epoch):
    """Both ends in seconds, and the epoch or None."""
    if epoch is not None:
        epoch = epochs.instant(epoch)
        begin, end = (hi + lo for hi, lo in span(epoch, start, stop))
        return begin, end, epoch
    begin = validation.number(start, "start", unit="s")
    end = validation.number(stop, "stop", unit="s")
    if end < begin:
        raise AttitudeError(f"stop is {begin - end:.9g} s before start; exchange them.")
    return begin, end, None


def _bisected(f, t, states, tolerance):
    """Epochs and new states of all changes that samples show, and of those seen on the way."""
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
