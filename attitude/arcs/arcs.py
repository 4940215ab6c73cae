"""Free rotations joined by instantaneous changes, their state at each joint in two doubles.

>>> import numpy as np
>>> from attitude import Body, Spin
>>> from attitude.arcs import Arcs, Impulse
>>> body = Body(moments=(10, 20, 26))
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.5))
>>> stop = Impulse(at=60.0, angular_momentum=(0, 0, -13))
>>> motion = Arcs(body, spin, [stop])
>>> motion.at([59.0, 61.0]).angular_velocity
array([[0. , 0. , 0.5],
       [0. , 0. , 0. ]])
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, evaluation, frames, pairs, validation
from attitude.arcs import joint_times
from attitude.arcs.changes import Change, Impulse, InertiaChange
from attitude.arcs.sensitivity import ChainedSensitivity
from attitude.arcs.triggers import Trigger, first
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.evaluation import EPOCHS
from attitude.free_rotation import rate_bounds
from attitude.free_rotation.differentiable import Differentiable
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.immutable import frozen, read_only
from attitude.solution.record import CONSTANTS
from attitude.spin import Spin

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import BoolArray, EpochOrSeconds, FloatArray
    from attitude.epochs import Instant
    from attitude.history import AttitudeHistory
    from attitude.motion import RateBounds

    Pair = tuple[float, float]  # seconds since the epoch of the spin, high and low part

__all__ = ["Arcs", "Impulse", "InertiaChange"]

_NO_LOW = frozen(np.zeros(1))


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Arcs(Differentiable):
    """Free rotation between instantaneous changes; exact on every arc, at epochs in any order.

    Parameters
    ----------
    body : Body
        Until an `InertiaChange`.
    spin : Spin
        The state at its epoch; the first arc has no beginning.
    changes : Impulse, InertiaChange, or sequence of them
        In order of time, after the epoch of the spin.

    Attributes
    ----------
    changes : tuple of Impulse and InertiaChange
    joints : (N,) array
        TDB seconds since the epoch of the spin at which the changes happen, those of events found.

    Raises
    ------
    AttitudeError
        For epochs that are equal or not in order, events that do not happen, and changes that
        leave no physical state.

    Notes
    -----
    At a joint the state is that after it.  From joint to joint the state is carried in two
    doubles (solution/flow.py, 1e-30 a joint), so that a thousand impulses cost no accuracy: the
    attitude errs as a free rotation does, by 4e-15 rad for the exact doubles given, over the axes
    of any frame.  Errors of the input are not covered: an impulse at a wrong phase changes the
    whole motion after it.  The times of events are rounded to a double.

    Source: van Zon & Schofield (2006), section 1: dynamics driven by events.
    """

    body: Body
    spin: Spin
    changes: tuple[Change, ...]

    smooth = True

    _value = ("body", "spin", "changes")

    def __init__(self, body: Body, spin: Spin, changes: Change | Iterable[Change]) -> None:
        self._bodies: Sequence[Body]
        self._constants: FloatArray
        self._starts: FloatArray
        if not isinstance(body, Body) or not isinstance(spin, Spin):
            raise AttitudeError(
                "Arcs takes a Body, a Spin and a list of changes; given were "
                f"{type(body).__name__} and {type(spin).__name__}."
            )
        if isinstance(changes, Change):
            changes = (changes,)
        if not isinstance(changes, Iterable):
            raise AttitudeError(
                f"changes is {validation.shown(changes)}; give an Impulse or InertiaChange, or a "
                "list of them."
            )
        self._set("body", body)
        self._set("spin", spin)
        self._set("changes", tuple(changes))
        for k, change in enumerate(self.changes):
            if not isinstance(change, Change):
                raise AttitudeError(
                    f"changes[{k}] is {change!r}; give Impulse or InertiaChange objects."
                )
        self._build()

    @cached_property
    def _sensitivity(self) -> ChainedSensitivity:
        later = self.wxyz_at(self._starts[1:, 0], self._starts[1:, 1])
        wxyz = np.concatenate([self.spin.wxyz_icrf[None], later])
        parts = self._constants, self._starts, self._bodies, wxyz, self.changes, self.epoch
        return ChainedSensitivity(*parts)

    def _with(self, body: Body, spin: Spin) -> Arcs:
        return Arcs(body, spin, self.changes)

    def __reduce__(self) -> tuple[Any, ...]:
        return Arcs, (self.body, self.spin, self.changes)

    def __repr__(self) -> str:
        return f"<Arcs: {len(self.joints) + 1} from {self.spin.epoch.utc_iso} UTC>"

    def __len__(self) -> int:
        """The number of arcs."""
        return len(self.joints) + 1

    @property
    def epoch(self) -> Instant:
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    def wxyz_at(self, seconds: ArrayLike, low: ArrayLike | None = None) -> FloatArray:
        """Attitudes (..., 4), body to ICRF, at TDB seconds + low since the epoch.

        For inner loops: `at` without units, dates and the history.
        """
        return self._evaluate(*epochs.plain_seconds(seconds, low), 0)[0]

    def angular_acceleration_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        angular_velocity: FloatArray | None = None,
    ) -> FloatArray:
        """Rate of change of the angular velocity by Euler's equations with the body of each epoch.

        Parameters
        ----------
        seconds, low : array_like
            TDB seconds + low since the epoch.
        angular_velocity : (..., 3) array, optional
            rad/s there, if known.

        Returns
        -------
        (..., 3) array
            rad/s2, body axes.
        """
        seconds, low = epochs.plain_seconds(seconds, low)
        if angular_velocity is None:
            angular_velocity = self.angular_velocity_at(seconds, low)
        angular_velocity = validation.real(
            angular_velocity, "angular_velocity", shape=(*seconds.shape, 3), finite=False
        )
        out = np.empty(angular_velocity.shape)
        for body, on in self._bodies_on(seconds, low):
            motion = FreeRotation(body, self.spin)
            out[on] = motion.angular_acceleration_from(angular_velocity[on])
        out[np.isnan(seconds)] = np.nan
        return out

    def constant_body(self, what: str) -> Body:
        """The Body of all arcs.

        Parameters
        ----------
        what : str
            What needs it, for the beginning of the error message.

        Raises
        ------
        AttitudeError
            For a body that changes.
        """
        if any(isinstance(change, InertiaChange) for change in self.changes):
            raise AttitudeError(
                f"{what} follows from a body's inertia, which changes along these arcs; "
                "give a motion with one body."
            )
        return self.body

    def momentum_in_body(self, history: AttitudeHistory) -> FloatArray:
        """Angular momentum (S, 3), kg m2/s over the body axes, with the body of each epoch."""
        out = np.full(history.angular_velocity.shape, np.nan)
        for body, on in self._bodies_on(history.seconds, history.low):
            out[on] = history.angular_velocity[on] @ body.tensor
        return out

    def breaks(self) -> FloatArray:
        """The joints in two doubles of TDB seconds since the epoch, (N, 2)."""
        return self._starts[1:].copy()

    def rate_bounds(self, seconds: float) -> RateBounds:
        """`RateBounds` that hold on the arc of an epoch, TDB seconds since that of the spin."""
        omega = self.angular_velocity_at(validation.number(seconds, "seconds", unit="s"))
        return rate_bounds.of_free_rotation(self.body_at(float(seconds)), omega)

    def body_at(self, t: EpochOrSeconds) -> Body:
        """The Body at one epoch, of any kind that `at` takes."""
        seconds, low = epochs.seconds_since(self.spin.epoch, t)
        if np.ndim(seconds):
            raise AttitudeError(f"t holds {np.size(seconds)} epochs; give one.")
        return self._bodies[self._arc(float(seconds), 0.0 if low is None else float(low))]

    def _bodies_on(self, seconds: ArrayLike, low: ArrayLike | None) -> list[tuple[Body, BoolArray]]:
        """Each Body, and at which epochs (S,) the motion has it; the first at NaN."""
        seconds = np.asarray(seconds)
        rest = np.float64(0.0) if low is None else np.asarray(low)
        starts = [
            (body, *start)
            for k, (body, start) in enumerate(zip(self._bodies, self._starts, strict=True))
            if not k or body is not self._bodies[k - 1]
        ]
        since = [
            np.ones(np.shape(seconds), dtype=bool)
            if not k
            else (seconds > high) | ((seconds == high) & (rest >= more))
            for k, (_, high, more) in enumerate(starts)
        ]
        until = [~each for each in since[1:]] + [np.ones(np.shape(seconds), dtype=bool)]
        return [
            (body, here & before)
            for (body, *_), here, before in zip(starts, since, until, strict=True)
        ]

    # How the arcs are joined ---------------------------------------------------------------------

    def _build(self) -> None:
        times = joint_times.given(self.changes, self.spin.epoch)
        body, spin = self.body, self.spin
        q = spin.wxyz_icrf_as_pairs.copy()
        w = body.rates_about_principal_axes(spin.angular_velocity)
        bodies = [body]
        self._set("_bodies", bodies)
        records = np.empty(len(self.changes) + 1, dtype=CONSTANTS)
        starts = np.zeros((len(records), 2))
        low = q[None, :, 1].copy() if spin.is_rounded else None
        records[0] = _constants(body, q, w, body.differences(spin.angular_velocity), low)
        for k, change in enumerate(self.changes):
            name = f"changes[{k}]"
            time = times[k]
            # Events and functions of the change evaluate the arcs before it.
            self._set("_constants", frozen(records[: k + 1]))
            self._set("_starts", frozen(starts[: k + 1]))
            if time is None:
                assert isinstance(change.at, Trigger)
                end = next((t[0] for t in times[k + 1 :] if t is not None), np.inf)
                time = first(change.at, self, float(starts[k, 0]), end, name), 0.0
            self._check_reach(time, name)
            added = change.added_momentum(partial(self._before, time), name)
            body = self._join(change, added, body, time, starts[k], records[k], q, w)
            bodies.append(body)
            try:
                records[k + 1] = _constants(body, q, w)
            except AttitudeError as err:
                raise AttitudeError(f"{name} leaves no physical state: {err}") from err
            starts[k + 1] = time
        self._set("_bodies", tuple(bodies))
        self._set("_constants", frozen(records))
        self._set("_starts", frozen(starts))
        self._set("joints", frozen(starts[1:, 0].copy()))

    def _check_reach(self, time: Pair, name: str) -> None:
        try:
            self.wxyz_at(*time)
        except AttitudeError as err:
            raise AttitudeError(f"{name}.at: {err}") from err

    def _before(self, time: Pair) -> AttitudeHistory:
        """The history of the epoch of a change while only the arcs before it are known."""
        return self.at(time[0]) if time[1] == 0.0 else self.at(time[0], time[1])

    def _join(
        self,
        change: Change,
        added: FloatArray,
        body: Body,
        time: Pair,
        start: FloatArray,
        record: Any,
        q: FloatArray,
        w: FloatArray,
    ) -> Body:
        """Carry the state q, w from the start of an arc over its end, in place; the next body."""
        from attitude.solution.flow import flow
        from attitude.solution.joints import change_axes, exchange, strike

        hi, lo = pairs.add((np.float64(time[0]), np.float64(time[1])), -start[0], -start[1])
        length = float(hi), float(lo)
        change_axes(q, body._axes, body.principal_wxyz, 1.0)
        flow(record, body.moments_as_pairs, length, q, w)
        change_axes(q, body._axes, body.principal_wxyz, -1.0)
        in_body, in_space = np.zeros(3), np.zeros((3, 2))
        if change.frame == "body":
            in_body[:] = added
        else:
            in_space[:] = frames.vector_to_icrf(change.frame, added)
        strike(body.moments_as_pairs, body._axes, q, w, in_body, in_space)
        if isinstance(change, InertiaChange):
            new = change.body
            exchange(body.moments_as_pairs, body._axes, new.moments_as_pairs, new._axes, w)
            body = new
        return body

    # Evaluation ----------------------------------------------------------------------------------

    def _evaluate(self, seconds: FloatArray, low: ArrayLike | None, order: int) -> list[FloatArray]:
        shape = seconds.shape
        flat = np.ascontiguousarray(seconds).reshape(-1)
        rest = None if low is None else np.ascontiguousarray(low).reshape(-1)
        wxyz = np.empty((1, 4, flat.size))
        omega = np.empty((1, 3, flat.size)) if order else None
        for begin in range(0, flat.size, EPOCHS):  # Python acts on Ctrl-C between the calls
            # Read-only views: one type of array, one compilation.
            t = read_only(flat[begin : begin + EPOCHS])
            if rest is None:
                t_low = _NO_LOW if t.size == 1 else frozen(np.zeros(t.size))
            else:
                # The low part decides between equal high parts: the pair is normalised.
                with np.errstate(invalid="ignore", over="ignore"):
                    pair = pairs.two_sum(t, rest[begin : begin + EPOCHS])
                t, t_low = frozen(pair[0]), frozen(pair[1])
            beyond = _compiled()(self._constants, self._starts, t, t_low, wxyz, omega, begin)
            if beyond >= 0:
                self._refuse(float(t[beyond]))
        found = [wxyz[0].T.reshape(*shape, 4)]
        if order:
            assert omega is not None
            found.append(omega[0].T.reshape(*shape, 3))
        if order > 1:
            found.append(self.angular_acceleration_at(seconds, low, angular_velocity=found[1]))
        return found

    def _refuse(self, t: float) -> None:
        """Raise the AttitudeError of a free rotation for an epoch beyond its reach."""
        k = self._arc(t)
        local, out = np.array([[t - self._starts[k, 0]]]), np.empty((1, 4, 1))
        evaluation.evaluate(self._constants[k : k + 1], local, None, out, None)

    def _arc(self, t: float, low: float = 0.0) -> int:
        """The number of the arc of one epoch."""
        return max(sum((high, rest) <= (t, low) for high, rest in self._starts.tolist()) - 1, 0)


@cache
def _compiled():
    from attitude.solution.chain import evaluate_arcs

    return evaluate_arcs


def _constants(body, q, w, differences=None, low=None):
    """The record of the free motion from a state in pairs."""
    given = body.moments_as_pairs[None], q[None, :, 0].copy(), w[None].copy()
    more = {"differences": differences, "wxyz_low": low}
    return evaluation.constants_of(*given, body.principal_wxyz[None], **more)[0]
