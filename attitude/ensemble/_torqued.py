"""`TorquedEnsemble`: many states under the same torques, with one scheme and one step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver.march_layout import OMEGA, STATE_ENTRIES, WXYZ
from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.blocks import ProgressBar, in_blocks
from attitude.ensemble._evaluation import EnsembleHistory
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.torques import _schemes
from attitude.torques._system import System
from attitude.torques._torqued import TorquedRotation, whole_steps

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FloatArray, IntArray, Real
    from attitude.ensemble._ensemble import Ensemble
    from attitude.torques._schemes import Scheme
    from attitude.torques._torque import Torque


# Steps for which torques are sampled together, and steps of all members in one compiled call: 50 ms
_STEPS, _TAKEN = 1024, 1 << 16


class TorquedHistory(EnsembleHistory):
    """Attitudes of the members of a TorquedEnsemble, with their angular velocities."""

    @cached_property
    def angular_acceleration(self) -> FloatArray:
        """AttitudeError: accelerations follow from the torques of a single member."""
        raise AttitudeError(
            "accelerations under torques are those of a single motion; take "
            "torqued[k].at(t).angular_acceleration."
        )


class TorquedEnsemble(Immutable):
    """The rotations of N bodies under the same torques.

    ensemble: states at one epoch; their frame, bodies and names.
    torques: as in `TorquedRotation`.
    step: s, of all members.
    scheme: as in `TorquedRotation`.
    AttitudeError for members with epochs of their own or that are not physical, a step that does
        not resolve the rotation of a member, and as `TorquedRotation`.

    Attitudes are those of ``TorquedRotation(body, spin, torques, step=step, scheme=scheme)``.
    States are integrated anew in each call of `at`, and are not kept.
    """

    ensemble: Ensemble
    torques: tuple[Torque, ...]
    step: float
    scheme: Scheme

    def __init__(
        self,
        ensemble: Ensemble,
        torques: Any,
        step: Real,
        scheme: str | Scheme = "kick-rotate-kick",
    ) -> None:
        self._systems: list[System]
        self._states: FloatArray
        if ensemble.epoch is None:
            raise AttitudeError(
                "the members have epochs of their own; torques need one epoch for all members."
            )
        if not ensemble.is_physical.all():
            raise AttitudeError(
                "some members are not physical; leave them out: ensemble[ensemble.is_physical]."
            )
        self._set("ensemble", ensemble)
        self._set("step", validation.positive(step, "step", unit="s"))
        self._set("scheme", _schemes.scheme(scheme))
        acting = torques if isinstance(torques, Iterable) else (torques,)
        self._set("torques", ())
        self._set("_systems", [])
        self._set("_states", np.zeros((0, STATE_ENTRIES)))
        if len(ensemble):
            first = TorquedRotation(
                ensemble[0].body, ensemble[0].spin, tuple(acting), step=None, scheme=self.scheme,
                step_tolerance=1e-2,
            )  # fmt: skip
            self._set("torques", first.torques)
            self._prepare()

    def _prepare(self) -> None:
        """Pack the bodies and the states of the members."""
        ensemble = self.ensemble
        shared = len(ensemble.principal_moments) == 1
        kept = [ensemble[k] for k in range(1 if shared else len(ensemble))]
        systems = [System(member.body, member.spin, self.torques, self.scheme) for member in kept]
        states = np.zeros((len(ensemble), STATE_ENTRIES))
        states[:, WXYZ] = self._over(systems, ensemble.wxyz_icrf)
        # By the products of single vectors, so that the bits are those of a TorquedRotation.
        for k, state in enumerate(states):
            state[WXYZ] /= np.sqrt(state[WXYZ] @ state[WXYZ])
            axes = systems[0 if shared else k].axes
            state[OMEGA] = ensemble.angular_velocity[k] @ axes
        speeds = np.sum(states[:, OMEGA] ** 2, axis=1)
        worst = int(np.argmax(speeds))
        try:
            motion = ensemble[worst]
            System(motion.body, motion.spin, self.torques, self.scheme).check_step(self.step)
        except AttitudeError as err:
            raise AttitudeError(f"{ensemble.label(worst)}: {err}") from err
        self._set("_systems", systems)
        self._set("_states", frozen(states))

    @staticmethod
    def _over(systems: list[System], wxyz: FloatArray) -> FloatArray:
        turns = np.array([system.turn for system in systems])
        return quaternion.multiply(wxyz, turns)

    def __len__(self) -> int:
        return len(self.ensemble)

    def __getitem__(self, k: int | str) -> TorquedRotation:
        """The motion of one member, of a number or a name."""
        motion = self.ensemble[self.ensemble.number(k)]
        return TorquedRotation(
            motion.body, motion.spin, self.torques, step=self.step, scheme=self.scheme
        )

    def __repr__(self) -> str:
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<TorquedEnsemble of {len(self)} members: {names}; step {self.step:g} s>"

    def at(self, t: Epochs, low: ArrayLike | None = None, *, threads: int = 1) -> TorquedHistory:
        """The attitudes and angular velocities of all members at some epochs.

        Shapes: t (T,).
        """
        times = _inputs.seconds_since(self.ensemble.start_of_seconds, t, low).mapped(np.array)
        hi = times.hi
        if hi.ndim != 1 or np.isinf(hi).any():
            raise AttitudeError(f"t is {validation.shown(t)}; give a row (T,) of finite epochs.")
        seconds, lo = hi, times.low
        out = np.full((len(self), len(seconds), 7), np.nan)
        total = seconds + lo
        for sign, side in ((1.0, total >= 0.0), (-1.0, total < 0.0)):
            if side.any() and len(self):
                self._integrate(sign * self.step, seconds, lo, np.flatnonzero(side), out, threads)
        if any(system.inertia is not None for system in self._systems):
            shared = len(self._systems) == 1
            for k, states in enumerate(out):
                system = self._systems[0 if shared else k]
                states[:, 4:] = system.turning(seconds, lo, states[:, 4:])
        shape = len(self), len(seconds)
        member = np.broadcast_to(np.arange(len(self))[:, None], shape)
        spread = times.mapped(lambda array: np.broadcast_to(array, shape))
        history = TorquedHistory(self.ensemble, member, *spread, out[..., :4])
        history.__dict__["angular_velocity"] = frozen(out[..., 4:])
        return history

    def _integrate(
        self,
        h: float,
        seconds: FloatArray,
        low: FloatArray,
        which: IntArray,
        out: FloatArray,
        threads: int,
    ) -> None:
        """Fill the states at epochs `which` of one direction of time."""
        first, states = self._systems[0], self._states.copy()
        first.check_span(float(np.max(np.abs(seconds[which]))), h)
        number, parts = whole_steps(seconds[which], low[which], h)
        order = np.lexsort((np.abs(parts), number))
        which, number, parts = which[order], number[order], parts[order]
        size = max(1, _TAKEN // _STEPS)
        bar = ProgressBar("torqued members")
        for start in range(0, int(number[-1]) + 1, _STEPS):
            steps = min(_STEPS, int(number[-1]) - start)
            final = start + _STEPS > number[-1]
            a, b = np.searchsorted(number, [start, start + steps + final])
            places = number[a:b] - start, np.ascontiguousarray(parts[a:b])
            samples = first.samples_of(start, h, steps, *places)

            def work(begin: int, end: int) -> None:
                some = states[begin:end]
                place = np.ix_(np.arange(begin, end), which[a:b])  # noqa: B023
                out[place] = self._marched(begin, some, start, h, places, samples)  # noqa: B023

            in_blocks(work, len(self), size, threads)
            bar(start + steps + 1, int(number[-1]) + 1)

    def _label(self, first: int, k: int) -> str:
        return self.ensemble.label(first + k)

    def _marched(
        self, first: int, states: FloatArray, start: int, h: float, here: Any, samples: Any
    ) -> FloatArray:
        """States (n, T, 7) over body axes of some members, which are advanced in place."""
        shared = len(self._systems) == 1
        systems: Sequence[System] = (
            self._systems if shared else self._systems[first : first + len(states)]
        )
        setup = (
            np.array([system.setup[0] for system in systems]),
            systems[0].setup[1],
            np.array([system.setup[2] for system in systems]),
        )
        number, parts = here
        advanced = systems[0].march_members(
            setup, states, start, h, number, parts, samples, label=partial(self._label, first)
        )
        for k in range(len(advanced)):
            advanced[k] = systems[0 if shared else k].over_body_axes(advanced[k])
        return advanced
