"""Rotations joined by instantaneous changes: free ones, or under torques.

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

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import frames
from attitude._solver import evaluation, sensitivities
from attitude._solver.evaluation import EPOCHS
from attitude._solver.records import CONSTANTS
from attitude._solver.sensitivities import Derivatives
from attitude._solver.states import Solved, States, compiled
from attitude._support import markup, pairs, validation
from attitude._support.arrays import Valued, frozen, read_only
from attitude._support.synonyms import arguments
from attitude._textfiles.lines import prefixed
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._body import Body
from attitude.motions._differentiable import Differentiable
from attitude.motions._free_rotation import (
    FreeRotation,
    chain_of,
    inertia_of,
    of_free_rotation,
)
from attitude.motions._history import AttitudeHistory
from attitude.motions._spin import Spin, refuse_others
from attitude.torques._torqued import TorquedRotation
from attitude.torques._triggers import Trigger, first_crossing

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import (
        BoolArray,
        EpochOrSeconds,
        Epochs,
        FloatArray,
        Real,
        Reals,
    )
    from attitude.epochs._instants import Instant
    from attitude.motions._motion import RateBounds
    from attitude.proof._certificate import Certificate
    from attitude.torques._schemes import Scheme
    from attitude.torques._torque import AnyTorques, Torque

    MomentumFunction = Callable[[AttitudeHistory], Reals]
    AnyMomentum = Reals | MomentumFunction
    Pair = tuple[float, float]

__all__ = ["Arcs", "Impulse", "InertiaChange"]

# ---- Instantaneous changes between free arcs: angular momentum added, inertia replaced


class Change(Valued):
    """Base of `Impulse` and `InertiaChange`, with `at`, `angular_momentum` and `frame`."""

    at: EpochOrSeconds | Trigger
    angular_momentum: FloatArray | MomentumFunction
    frame: str
    _value: tuple[str, ...] = ("at", "angular_momentum", "frame")

    def _set_change(self, at, angular_momentum, frame):
        """Check and keep the attributes, while the object is constructed."""
        frame = frame if frame == "body" else frames.known(frame)
        if not callable(angular_momentum):
            angular_momentum = frozen(
                validation.real(angular_momentum, "angular_momentum", shape=(3,), unit="kg m2/s")
            )
        self._set_all(at=at, angular_momentum=angular_momentum, frame=frame)

    def added_momentum(self, before: Callable[[], AttitudeHistory], name: str) -> FloatArray:
        """Angular momentum (3,) that the change adds, kg m2/s in its frame.

        `before()` returns the history of the epoch of the change, before it.
        """
        momentum = self.angular_momentum
        if not callable(momentum):
            return momentum
        value = momentum(before())
        return validation.real(value, f"{name}.angular_momentum(...)", shape=(3,), unit="kg m2/s")


@dataclass(frozen=True, eq=False, init=False)
class Impulse(Change):
    """Angular momentum added in an instant.

    Parameters
    ----------
    at : epoch, seconds or Trigger
        TDB seconds since the epoch of the spin, an epoch of any kind that `Spin` takes, or an
        event such as `PointMeetsPlane`: its first time after the change before.
    angular_momentum : (3,) array_like, or function
        kg m2/s (in the body's unit of inertia if that is relative).  A function is called with
        the AttitudeHistory of that one epoch, before the change, and returns the vector.
    frame : str
        "body": over the body axes at that epoch; "icrf", "eme2000" or "ecliptic".

    Attributes
    ----------
    at : as given
    angular_momentum : (3,) array, or function
    frame : str

    Raises
    ------
    AttitudeError
        For another shape or unit, numbers that are not finite, and an unknown frame.
    """

    at: EpochOrSeconds | Trigger
    angular_momentum: FloatArray | MomentumFunction
    frame: str = "body"

    @arguments(
        dict.fromkeys(("t", "time", "epoch"), "use at=")
        | dict.fromkeys(
            ("torque", "delta_h", "momentum", "impulse"),
            "use angular_momentum=, kg m2/s: torque times duration",
        ),
        "Impulse(at=60.0, angular_momentum=(0, 0, -13))",
    )
    def __init__(
        self,
        at: EpochOrSeconds | Trigger,
        angular_momentum: AnyMomentum,
        frame: str = "body",
    ) -> None:
        self._set_change(at, angular_momentum, frame)


@dataclass(frozen=True, eq=False, init=False)
class InertiaChange(Change):
    """The body becomes another in an instant: a boom is deployed, a servicer docks.

    Body axes, attitude and angular momentum stay; the angular velocity follows from them.

    Parameters
    ----------
    at : epoch, seconds or Trigger
        As for `Impulse`.
    body : Body
        The body from then on, over the same body axes.
    angular_momentum : (3,) array_like, or function
        Angular momentum added by the change, such as that of a servicer; as for `Impulse`.
    frame : str
        As for `Impulse`.

    Attributes
    ----------
    at : as given
    body : Body
    angular_momentum : (3,) array, or function
    frame : str

    Raises
    ------
    AttitudeError
        As for `Impulse`, and for anything but a Body.
    """

    at: EpochOrSeconds | Trigger
    body: Body
    angular_momentum: FloatArray | MomentumFunction
    frame: str = "body"
    _value = ("at", "body", "angular_momentum", "frame")

    def __init__(
        self,
        at: EpochOrSeconds | Trigger,
        body: Body,
        angular_momentum: AnyMomentum = (0.0, 0.0, 0.0),
        frame: str = "body",
    ) -> None:
        self._set("body", validation.instance(body, Body, "body", "a Body"))
        self._set_change(at, angular_momentum, frame)


def known_changes(changes: Change | Iterable[Change]) -> tuple[Change, ...]:
    """One change or several as a tuple; AttitudeError for anything else."""
    if isinstance(changes, Change):
        return (changes,)
    if not isinstance(changes, Iterable):
        raise AttitudeError(
            f"changes is {validation.shown(changes)}; give an Impulse or InertiaChange, or a list "
            "of them."
        )
    several = tuple(changes)
    for k, change in enumerate(several):
        wanted = "Impulse or InertiaChange objects"
        validation.instance(change, Change, f"changes[{k}]", wanted)
    return several


# ---- The times of changes, as far as they are given, in two doubles and in order


def times_of(changes: Sequence[Change], epoch: Instant) -> list[Pair | None]:
    """Seconds (high, low) since an epoch of each change; None for one at an event."""
    times: list[Pair | None] = []
    before, whose = (0.0, 0.0), "the epoch of the spin"
    for k, change in enumerate(changes):
        if isinstance(change.at, Trigger):
            times.append(None)
            continue
        time = _inputs.one_since(epoch, change.at, f"changes[{k}].at")
        if time <= before:
            early = (before[0] - time[0]) + (before[1] - time[1])
            order = f"{early:.2g} s earlier than" if time < before else "the same as"
            raise AttitudeError(
                f"changes[{k}] at {time[0]:.9g} s is {order} {whose} ({before[0]:.9g} s); give "
                "changes in order of time, after the epoch of the spin, and one change where "
                "several have the same epoch."
            )
        before, whose = time, f"changes[{k}]"
        times.append(time)
    return times


# ---- Derivatives of the attitudes of a chain of arcs by the state and the moments at its epoch
# Each arc has the derivatives of a free rotation by its own first state; at a joint the change of
# that state follows from the change of the momentum, L' = L + dL and w' = I'^-1 L'.  The product of
# these maps is the derivative by the state at the epoch of the chain.

# Turn, rad, of the central differences of an event's function: their error is 1e-11 of its scale.
_STEP = 1e-5


class _FreeArc:
    """One arc of free rotation, from its first attitude (4,) and its record of CONSTANTS."""

    def __init__(self, body: Body, wxyz: FloatArray, record: Any) -> None:
        self._body, self._constants = body, record[None]
        self._sensitivity = sensitivities.Sensitivity(
            body.moments_as_pairs[None], wxyz[None], body.principal_wxyz[None], self._constants
        )

    def _evaluate(self, seconds, low, order):
        """Attitude and angular velocity at one epoch."""
        wxyz, omega = np.empty((1, 4, 1)), np.empty((1, 3, 1))
        evaluation.evaluate(self._constants, *pairs.rows(seconds, low), wxyz, omega)
        return [wxyz[0, :, 0], omega[0, :, 0]]

    def turning_rate_at(self, seconds, low, *, wxyz, angular_velocity):
        """As `Motion.turning_rate_at`, of one epoch."""
        return angular_velocity

    def angular_acceleration_at(self, seconds, low, *, angular_velocity):
        """As `Motion.angular_acceleration_at`, of one epoch."""
        tensor = self._body.tensor
        torque = np.cross(tensor @ angular_velocity, angular_velocity)
        return np.asarray(np.linalg.solve(tensor, torque))


class _ChainedSensitivity(Derivatives):
    """The derivatives of one chain of N + 1 arcs from starts (N + 1, 2), s, at any epoch.

    AttitudeError for a change whose momentum is a function of the motion.
    """

    def __init__(self, arcs, starts, bodies, changes, epoch):
        for k, change in enumerate(changes):
            if callable(change.angular_momentum):
                raise AttitudeError(
                    f"the momentum of changes[{k}] is a function of the motion, which has no "
                    "derivative in closed form; give the momentum as three numbers."
                )
        self._arcs, self._starts, self._bodies = arcs, starts, bodies
        self._epoch, self._changes = epoch, tuple(changes)
        # the maps (9, 9) from the first state of the chain to that of each arc
        self._maps = [np.eye(9)]
        for k, change in enumerate(self._changes):
            self._maps.append(self._over_joint(k, change) @ self._maps[k])

    def at(self, seconds, low, rates):
        """Changes of attitude (S, 3, 9), ICRF axes, and of the angular velocity, body axes."""
        return self._chained(self._maps, seconds, low, rates)

    def by_momenta(self, seconds, low):
        """As `at` without rates, by the momenta of the changes (3 N), each in its own frame."""
        count = len(self._changes)
        maps = [np.zeros((9, 3 * count))]
        for k, change in enumerate(self._changes):
            after = self._over_joint(k, change) @ maps[k]
            turn = np.eye(3)
            if change.frame != "body":
                wxyz = self._state(k, self._starts[k + 1])[0]
                turn = quaternion.matrix(wxyz).T @ frames.matrix_to_icrf(change.frame)
            after[3:6, 3 * k : 3 * k + 3] += np.linalg.solve(self._bodies[k + 1].tensor, turn)
            maps.append(after)
        return self._chained(maps, seconds, low, False)

    def _chained(self, maps, seconds, low, rates, by_elements=False):
        """Changes (S, 3, P) of attitude and rates from those (9, P) of each arc's first state."""
        t, t_low = pairs.Seconds(seconds, low).flat
        width = maps[0].shape[1]
        attitude = np.full((t.size, 3, width), np.nan)
        omega = np.full((t.size, 3, width), np.nan) if rates else None
        high, t_low, arcs = _numbers_of_arcs(self._starts, t, t_low)
        for k in np.unique(arcs):
            on = arcs == k
            one, two = self._on_arc(int(k), high[on], t_low[on], rates, by_elements and k == 0)
            attitude[on] = one @ maps[k]
            if omega is not None:
                assert two is not None
                omega[on] = two @ maps[k]
        shape = (*np.shape(seconds), 3, width)
        return attitude.reshape(shape), None if omega is None else omega.reshape(shape)

    def by_elements(self, seconds, low, rates):
        """As `at`, (S, 3, 8), by the first attitude and the elements of the first arc."""
        maps = [np.eye(8)]
        for k, change in enumerate(self._changes):
            maps.append(self._over_joint(k, change, by_elements=k == 0) @ maps[k])
        return self._chained(maps, seconds, low, rates, by_elements=True)

    def _on_arc(self, k, high, low, rates, by_elements=False):
        """The columns (n, 3, 9) by the first state of an arc, or (n, 3, 8) by its elements."""
        of = self._arcs[k]._sensitivity
        return (of.by_elements if by_elements else of.at)(
            *_since(self._starts[k], high, low), rates
        )

    def _over_joint(self, k: int, change: Change, by_elements: bool = False) -> FloatArray:
        """The map (9, 9) from the first state of an arc to that of the next; (9, 8): elements."""
        end = self._starts[k + 1]
        attitude, omega = self._on_arc(k, end[:1], end[1:], True, by_elements)
        assert omega is not None
        width = attitude.shape[-1]
        whole = np.zeros((9, width))
        moments = self._arcs[k]._sensitivity.of_elements.factors[0] if by_elements else np.eye(9)
        whole[:3], whole[3:6], whole[6:] = attitude[0], omega[0], moments[6:, :width]
        wxyz, before = self._state(k, end)
        old: Body = self._bodies[k]
        new: Body = self._bodies[k + 1]
        added = np.asarray(change.angular_momentum, dtype=np.float64)
        matrix = quaternion.matrix(wxyz)
        momentum = _by_state(old, before)
        if change.frame != "body":
            inertial = np.sum(frames.vector_to_icrf(change.frame, added), axis=-1)
            # R^T dL turns with the attitude
            momentum[:, :3] += matrix.T @ np.cross(inertial, np.eye(3)).T
            added = matrix.T @ inertial
        after = np.asarray(np.linalg.solve(new.tensor, old.tensor @ before + added), np.float64)
        joint = np.zeros((9, 9))
        joint[:3, :3] = np.eye(3)
        if not isinstance(change, InertiaChange):
            momentum[:, 6:] -= _by_state(new, after)[:, 6:]
            joint[6:, 6:] = np.eye(3)
        joint[3:6] = np.linalg.solve(new.tensor, momentum)
        product: FloatArray = joint @ whole
        if isinstance(change.at, Trigger):
            later = self._delay(k, change.at, end, wxyz, before) @ whole[:3]
            product += np.outer(joint @ self._rate(k, wxyz, before, end), later)
            product -= np.outer(self._rate(k + 1, wxyz, after, end), later)
        return product

    def _delay(self, k, event, end, wxyz, omega):
        """The change (3,) of the time of the event that ends arc k with the attitude then."""
        rates = {
            "angular_velocity": omega,
            "turning_rate": self._turning_rate(k, wxyz, omega, end),
        }
        values = []
        for turn in _STEP * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)]):
            turned = quaternion.multiply(forms.from_rotation_vector(turn), wxyz)
            history = AttitudeHistory(
                None, self._epoch, np.asarray(end[0]), np.asarray(end[1]), turned
            )
            history.__dict__.update(rates)
            values.append(event.values(history))
        gradient = np.array([float(value[0]) for value in values[1:]])
        slopes = (gradient[:3] - gradient[3:]) / (2.0 * _STEP)
        return -slopes / float(values[0][1])

    def _state(self, k: int, end: FloatArray) -> list[FloatArray]:
        """Attitude and angular velocity on arc k at an epoch (2,)."""
        return self._arcs[k]._evaluate(*_since(self._starts[k], *end), 1)

    def _rate(self, k: int, wxyz: FloatArray, omega: FloatArray, end: FloatArray) -> FloatArray:
        """The rates (9,) of attitude (inertial axes), velocity and moments on arc k at `end`."""
        t = _since(self._starts[k], *end)
        acceleration = self._arcs[k].angular_acceleration_at(*t, angular_velocity=omega)
        turn = quaternion.matrix(wxyz) @ self._turning_rate(k, wxyz, omega, end)
        return np.concatenate([turn, acceleration, np.zeros(3)])

    def _turning_rate(self, k: int, wxyz: FloatArray, omega: FloatArray, end: FloatArray) -> Any:
        """The rate (3,) at which the attitude turns on arc k at `end`, body axes."""
        t = _since(self._starts[k], *end)
        return self._arcs[k].turning_rate_at(*t, wxyz=wxyz, angular_velocity=omega)


def _numbers_of_arcs(starts, seconds, low):
    """Epochs (S,) in normalised pairs, and the numbers of the arcs that they lie on."""
    arcs = np.zeros(seconds.size, dtype=np.int64)
    with np.errstate(invalid="ignore", over="ignore"):
        high, remainder = pairs.two_sum(seconds, low)
        for start, more in starts[1:]:
            arcs += (high > start) | ((high == start) & (remainder >= more))
    return high, remainder, arcs


def _by_state(body: Body, omega: FloatArray) -> FloatArray:
    """The change (3, 9) of the momentum over the body axes with that of the state."""
    axes = body.principal_axes
    change = np.zeros((3, 9))
    change[:, 3:6] = body.tensor
    change[:, 6:] = axes * (axes.T @ omega)
    return change


_NO_LOW = frozen(np.zeros(1))


def _since(start: FloatArray, high: ArrayLike, low: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Seconds since the start of an arc, in two doubles."""
    with np.errstate(invalid="ignore"):
        hi, lo = pairs.add((np.asarray(high), np.asarray(low)), -start[0], -start[1])
    return hi, lo


_HINTS = dict.fromkeys(("impulses", "impulse", "maneuvers", "events", "arcs"), "give changes=")
# Arguments of `TorquedRotation` that `Arcs` takes for arcs under torques.
_STEPPING = ("step", "scheme", "tolerance", "step_tolerance")


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Arcs(Differentiable):
    """Free rotation between instantaneous changes, exact on every arc; or rotation under torques.

    Parameters
    ----------
    body : Body
        Until an `InertiaChange`.
    spin : Spin
        The state at its epoch; the first arc has no beginning.
    changes : Impulse, InertiaChange, or sequence of them
        In order of time, after the epoch of the spin.
    torques : Torque, function, or sequence of them, optional
        As for `TorquedRotation`, on all arcs.  Functions are called with seconds since the epoch
        of the spin.
    step, scheme, tolerance, step_tolerance : optional
        With torques, of each arc, as for `TorquedRotation`.  An error at a joint goes on along the
        next arc.

    Attributes
    ----------
    changes : tuple of Impulse and InertiaChange
    torques : tuple of Torque
    step, scheme, tolerance, step_tolerance : as given
    joints : (N,) array
        TDB seconds since the epoch of the spin at which the changes happen, those of events found.

    Raises
    ------
    AttitudeError
        For epochs that are equal or not in order, events that do not happen, changes that leave no
        physical state, and as `TorquedRotation`.

    Notes
    -----
    At a joint the state is that after it.  From joint to joint the state is carried in two
    doubles (1e-30 a joint), so that a thousand impulses cost no accuracy: the
    attitude errs as a free rotation does, by 4e-15 rad for the exact doubles given, over the axes
    of any frame.  Errors of the input are not covered: an impulse at a wrong phase changes the
    whole motion after it.  The times of events are rounded to a double.

    Under torques the state at a joint is a double, and an event is searched among attitudes
    at most an eighth of a radian apart: two crossings between neighbours are missed.

    Source: van Zon & Schofield (2006), section 1: dynamics driven by events.
    """

    body: Body
    spin: Spin
    changes: tuple[Change, ...]
    torques: tuple[Torque, ...]
    step: float | None
    scheme: str | Scheme | None
    tolerance: float | None
    step_tolerance: float | None

    smooth = True

    _value = ("body", "spin", "changes", "torques", *_STEPPING)

    @arguments(_HINTS, "Arcs(body, spin, [Impulse(at=60.0, angular_momentum=(0, 0, -13))])")
    def __init__(
        self,
        body: Body,
        spin: Spin,
        changes: Change | Iterable[Change],
        torques: AnyTorques | None = None,
        *,
        step: Real | None = None,
        scheme: str | Scheme | None = None,
        tolerance: Real | None = None,
        step_tolerance: Real | None = None,
    ) -> None:
        self._bodies: Sequence[Body]
        self._constants: FloatArray
        self._starts: FloatArray
        self._torqued: tuple[TorquedRotation, ...]
        refuse_others(body, spin, "Arcs takes a Body, a Spin and a list of changes")
        self._set_all(body=body, spin=spin, changes=known_changes(changes))
        stepping: dict[str, Any] = dict(
            zip(_STEPPING, (step, scheme, tolerance, step_tolerance), strict=True)
        )
        for name, value in stepping.items():
            self._set(name, value)
            if torques is None and value is not None:
                raise AttitudeError(
                    f"{name} is for the integration of torques; give torques=, or leave it out."
                )
        self._set_all(torques=(), _torqued=())
        if torques is None:
            self._build()
            return
        first = TorquedRotation(body, spin, torques, **stepping)
        self._set("torques", first.torques)
        if any(torque.changes_inertia for torque in first.torques):
            raise AttitudeError(
                "arcs take no InertiaHistory; give the changes of inertia as InertiaChange, or use "
                "TorquedRotation."
            )
        self._integrate(first)

    @cached_property
    def _sensitivity(self) -> _ChainedSensitivity:
        arcs: Sequence[_FreeArc] | Sequence[TorquedRotation] = self._torqued
        if not arcs:
            later = self.wxyz_at(self._starts[1:, 0], self._starts[1:, 1])
            wxyz = np.concatenate([self.spin.wxyz_icrf[None], later])
            arcs = [_FreeArc(*of) for of in zip(self._bodies, wxyz, self._constants, strict=True)]
        return _ChainedSensitivity(arcs, self._starts, self._bodies, self.changes, self.epoch)

    def _with(self, body: Body, spin: Spin) -> Arcs:
        constructor, (_, _, *others) = self.__reduce__()
        return constructor(body, spin, *others)

    def __reduce__(self) -> tuple[Any, ...]:
        if not self.torques:
            return Arcs, (self.body, self.spin, self.changes)
        stepping = {name: getattr(self, name) for name in _STEPPING}
        return partial(Arcs, **stepping), (self.body, self.spin, self.changes, self.torques)

    def _repr_html_(self) -> str:
        """A table for notebooks: begin, mode and periods of each arc."""
        rows: list[tuple[str, ...]] = [
            ("begins, s", "change", "mode", "period psi, s", "period phi, s")
        ]
        changes = ["-", *(type(item).__name__ for item in self.changes)]
        for change, begin in zip(changes, [0.0, *self.joints.tolist()], strict=True):
            body, spin = self._bodies[0], self.spin
            if change != "-":
                body, state = self.body_at(begin), self.at(begin)
                spin = Spin(self.epoch.after(begin), state.wxyz, state.angular_velocity)
            arc = FreeRotation(body, spin)
            periods = (f"{item:.9g}" for item in (arc.period_psi, arc.period_phi))
            rows.append(("-" if change == "-" else f"{begin:.9g}", change, arc.mode.name, *periods))
        return markup.table(f"{len(self)} arcs from {self.spin.epoch.utc_iso} UTC", rows)

    def __repr__(self) -> str:
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        under = f" under {names}" if names else ""
        return f"<Arcs: {len(self)} from {self.spin.epoch.utc_iso} UTC{under}>"

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
        return self._evaluate(*_inputs.plain_seconds(seconds, low), 0)[0]

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
        times = _inputs.plain_seconds(seconds, low)
        if self._torqued:
            return self._evaluate(*times, 2)[2]
        if angular_velocity is None:
            angular_velocity = self.angular_velocity_at(*times)
        angular_velocity = validation.real(
            angular_velocity, "angular_velocity", shape=(*times.hi.shape, 3), finite=False
        )
        out = np.empty(angular_velocity.shape)
        for body, on in self._bodies_on(times):
            motion = FreeRotation(body, self.spin)
            out[on] = motion.angular_acceleration_from(angular_velocity[on])
        out[np.isnan(times.hi)] = np.nan
        return out

    def turning_rate_at(
        self,
        seconds: ArrayLike,
        low: ArrayLike | None = None,
        *,
        wxyz: FloatArray,
        angular_velocity: FloatArray,
    ) -> FloatArray:
        """As `Motion.turning_rate_at`."""
        if not self._torqued:
            return angular_velocity
        times = pairs.Seconds(*_inputs.plain_seconds(seconds, low))
        numbers = _numbers_of_arcs(self._starts, *times.flat)[2].reshape(times.hi.shape)
        rates = np.array(angular_velocity)
        for k in np.unique(numbers):
            on = numbers == k
            t = _since(self._starts[k], times.hi[on], times.low[on])
            rates[on] = self._torqued[k].turning_rate_at(
                *t, wxyz=wxyz[on], angular_velocity=angular_velocity[on]
            )
        return rates

    def certificate(
        self, t: Epochs, low: ArrayLike | None = None, *, angular_velocity: bool = False
    ) -> Certificate:
        """Proved upper bounds of the errors of `at`, rad, as `FreeRotation.certificate`.

        Times and momenta of the changes are exact (momenta over ICRF to 31 digits).

        Raises
        ------
        AttitudeError
            For epochs behind a change whose time is that of an event or whose momentum is a
            function, and as `attitude.certify`.
        """
        from attitude.proof._chain import Joint

        if self._torqued:
            raise AttitudeError(
                "arcs under torques are integrated, and cannot be certified; give arcs without "
                "torques=."
            )
        times = _inputs.seconds_since(self.epoch, t, low)
        wxyz, *rates = self._evaluate(*times, int(angular_velocity))
        joints = []
        for k, change in enumerate(self.changes):
            start = self._starts[k + 1]
            if isinstance(change.at, Trigger) or callable(change.angular_momentum):
                hi, low_part = times.hi, times.low
                if np.any((hi > start[0]) | ((hi == start[0]) & (low_part >= start[1]))):
                    raise AttitudeError(
                        f"changes[{k}] happens at an event, or its momentum is a function: both "
                        "are rounded, and epochs behind it cannot be certified."
                    )
                break
            added = np.zeros((3, 2))
            added[:, 0] = change.angular_momentum
            if change.frame != "body":
                added = frames.vector_to_icrf(change.frame, added[:, 0])
            body = self._bodies[k + 1]
            joints.append(Joint(start, added, change.frame == "body", inertia_of(body)))
        return chain_of(self.body, self.spin, joints).certificate(*times, wxyz, *rates)

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
        for body, on in self._bodies_on(pairs.Seconds.of(history)):
            out[on] = history.angular_velocity[on] @ body.tensor
        return out

    def breaks(self) -> FloatArray:
        """The joints in two doubles of TDB seconds since the epoch, (N, 2)."""
        return self._starts[1:].copy()

    def rate_bounds(self, seconds: float) -> RateBounds | None:
        """`RateBounds` of the free arc of an epoch, TDB seconds since that of the spin."""
        if self._torqued:
            return None
        omega = self.angular_velocity_at(validation.number(seconds, "seconds", unit="s"))
        return of_free_rotation(self.body_at(float(seconds)), omega)

    def body_at(self, t: EpochOrSeconds) -> Body:
        """The Body at one epoch, of any kind that `at` takes."""
        return self._bodies[self._arc(*_inputs.one_since(self.spin.epoch, t))]

    def _bodies_on(self, times: pairs.Seconds) -> list[tuple[Body, BoolArray]]:
        """Each Body, and at which epochs (S,) the motion has it; the first at NaN."""
        arcs = _numbers_of_arcs(self._starts, *times.flat)[2].reshape(np.shape(times.hi))
        bodies = self._bodies
        first = [k for k, body in enumerate(bodies) if not k or body is not bodies[k - 1]]
        spans = pairwise([*first, len(bodies)])
        return [(bodies[begin], (begin <= arcs) & (arcs < end)) for begin, end in spans]

    # ---- How the arcs are joined

    def _build(self) -> None:
        body, spin = self.body, self.spin
        wxyz = spin.wxyz_icrf_as_pairs[None]
        states = States(
            body.moments_as_pairs[None],
            body.principal_wxyz[None],
            *body.over_principal_axes(spin.angular_velocity),
            wxyz[..., 0].copy(),
            wxyz[..., 1].copy() if spin.is_rounded else None,
        )
        chain = CarriedStates(states, wxyz, body._axes[None])
        records = np.empty(len(self.changes) + 1, dtype=CONSTANTS)
        records[0] = _constants(chain.solved)
        self._set("_constants", frozen(records[:1]))
        for k, (change, time, added, _) in enumerate(self._joints()):
            chain.join(change, added, _since(self._starts[-1], *map(np.float64, time)))
            with prefixed(f"changes[{k}] leaves no physical state"):
                records[k + 1] = _constants(chain.solved)
            self._set("_constants", frozen(records[: k + 2]))

    def _integrate(self, first: TorquedRotation) -> None:
        """The arcs under torques, from the first one on."""
        constructor, (_, _, torques) = first.__reduce__()
        self._set("_torqued", (first,))
        for k, (change, time, added, body) in enumerate(self._joints()):
            wxyz, omega = self._evaluate(np.asarray(time[0]), np.asarray(time[1]), 1)
            if change.frame != "body":
                inertial = np.sum(frames.vector_to_icrf(change.frame, added), axis=-1)
                added = quaternion.rotate(quaternion.conjugate(wxyz), inertial)
            momentum = self._bodies[k].tensor @ omega + added
            start = self.spin.epoch.after(*time)
            with prefixed(f"changes[{k}] leaves no state to integrate"):
                rate = np.linalg.solve(body.tensor, momentum)
                spin = Spin(epoch=start, wxyz=wxyz, angular_velocity=rate)
                arc = constructor(body, spin, torques, origin=self.spin.epoch)
            self._set("_torqued", (*self._torqued, arc))

    def _joints(self):
        """Each change, its time and momentum, evaluated on the arcs before it; the next body."""
        times = times_of(self.changes, self.spin.epoch)
        starts = np.zeros((len(times) + 1, 2))
        self._set("_bodies", (self.body,))
        for k, change in enumerate(self.changes):
            self._set("_starts", frozen(starts[: k + 1].copy()))
            time = self._time_of(change, times[k:], float(starts[k, 0]), f"changes[{k}]")
            added = change.added_momentum(partial(self._before, time), f"changes[{k}]")
            body = change.body if isinstance(change, InertiaChange) else self._bodies[k]
            yield change, time, added, body
            starts[k + 1] = time
            self._set("_bodies", (*self._bodies, body))
        self._set_all(_starts=frozen(starts), joints=frozen(starts[1:, 0].copy()))

    def _time_of(self, change, times, start, name):
        """The time of a change, the first one, or where its trigger first fires behind a start."""
        time = times[0]
        if time is None:
            assert isinstance(change.at, Trigger)
            end = next((t[0] for t in times if t is not None), np.inf)
            time = first_crossing(change.at, self, start, end, name), 0.0
        with prefixed(f"{name}.at"):
            self._evaluate(*map(np.asarray, time), 0)
        return time

    def _before(self, time: Pair) -> AttitudeHistory:
        """The history of the epoch of a change while only the arcs before it are known."""
        return self.at(time[0]) if time[1] == 0.0 else self.at(time[0], time[1])

    # ---- Evaluation

    def _evaluate(self, seconds, low, order):
        if self._torqued:
            return self._evaluate_torqued(seconds, low, order)
        shape = seconds.shape
        flat = np.ascontiguousarray(seconds).reshape(-1)
        seconds_low = None if low is None else np.ascontiguousarray(low).reshape(-1)
        wxyz = np.empty((1, 4, flat.size))
        omega = np.empty((1, 3, flat.size)) if order else None
        for begin in range(0, flat.size, EPOCHS):  # Python acts on Ctrl-C between the calls
            # Read-only views: one type of array, one compilation.
            t = read_only(flat[begin : begin + EPOCHS])
            if seconds_low is None:
                t_low = _NO_LOW if t.size == 1 else frozen(np.zeros(t.size))
            else:
                # The low part decides between equal high parts: the pair is normalised.
                with np.errstate(invalid="ignore", over="ignore"):
                    pair = pairs.two_sum(t, seconds_low[begin : begin + EPOCHS])
                t, t_low = frozen(pair[0]), frozen(pair[1])
            beyond = compiled().evaluate_arcs(
                self._constants, self._starts, t, t_low, wxyz, omega, begin
            )
            if beyond >= 0:
                self._refuse(float(t[beyond]))
        answers = [wxyz[0].T.reshape(*shape, 4)]
        if order:
            assert omega is not None
            answers.append(omega[0].T.reshape(*shape, 3))
        if order > 1:
            answers.append(self.angular_acceleration_at(seconds, low, angular_velocity=answers[1]))
        return answers

    def _evaluate_torqued(self, seconds, low, order):
        times = pairs.Seconds(seconds, low).flat
        high, remainder, numbers = _numbers_of_arcs(self._starts, *times)
        answers = [np.empty((high.size, width)) for width in (4, 3, 3)[: max(order, 1) + 1]]
        for k in np.unique(numbers):
            on = numbers == k
            of_arc = self._torqued[k]._evaluate(
                *_since(self._starts[k], high[on], remainder[on]), order
            )
            for out, values in zip(answers, of_arc, strict=True):
                out[on] = values
        return [array.reshape(*seconds.shape, array.shape[-1]) for array in answers]

    def _refuse(self, t: float) -> None:
        """Raise the AttitudeError of a free rotation for an epoch beyond its reach."""
        k = self._arc(t)
        since_start = np.array([t - self._starts[k, 0]])
        raise AttitudeError(evaluation.refusal(self._constants[k], since_start, None))

    def _arc(self, t: float, low: float = 0.0) -> int:
        """The number of the arc of one epoch."""
        return max(sum((high, more) <= (t, low) for high, more in self._starts.tolist()) - 1, 0)


def _constants(solved: Solved) -> Any:
    """The record of the one motion; AttitudeError for a state that is not physical."""
    if len(solved.bad):
        raise AttitudeError(solved.fault(0))
    return solved.constants[0]


class CarriedStates:
    """States of B bodies, carried from arc to arc in pairs; `solved` has the constants of an arc.

    states: at the start of the first arc; wxyz (B, 4, 2), their attitudes.
    axes: (1 or B, 3, 3, 2) columns, the principal axes in body axes.
    """

    def __init__(self, states: States, wxyz: FloatArray, axes: FloatArray) -> None:
        self.solved = states.solved()
        self._wxyz, self._omega = wxyz.copy(), self.solved.omega.copy()
        self._inertia = self.solved.moments, axes, self.solved.principal

    def join(self, change: Change, added: Any, length: Any) -> None:
        """Carry the states over an arc of `length` (2,), s, and through the change at its end."""
        in_body, in_space = np.zeros(3), np.zeros((3, 2))
        if change.frame == "body":
            in_body[:] = added
        else:
            in_space[:] = frames.vector_to_icrf(change.frame, added)
        inertia = tuple(map(read_only, self._inertia))
        compiled().join_members(
            self.solved.constants,
            *inertia,
            np.array(length),
            self._wxyz,
            self._omega,
            in_body,
            in_space,
        )
        if isinstance(change, InertiaChange):
            new = change.body
            compiled().exchange_members(*inertia[:2], new.moments_as_pairs, new._axes, self._omega)
            self._inertia = new.moments_as_pairs[None], new._axes[None], new.principal_wxyz[None]
        moments, _, principal = self._inertia
        wxyz = self._wxyz[..., 0].copy()
        self.solved = States(moments, principal, self._omega.copy(), None, wxyz).solved()
