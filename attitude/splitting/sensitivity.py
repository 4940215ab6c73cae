"""Derivatives of a torqued motion by its state and its moments: the chain of those of its steps.

A step is a product of kicks and free motions.  The derivative of a free motion is in closed form
(`attitude.sensitivities.columns`); that of a kick, whose torque may be any function, is taken by
differences of fourth order of the change that the compiled kick makes.  Their product is the
derivative of the scheme with its steps, not of an integration beside it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import evaluation, quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.free_rotation.sensitivity import Derivatives, changed
from attitude.sensitivities import columns
from attitude.solution.march_layout import OMEGA, OMEGA_LOW, STATE_ENTRIES, WXYZ
from attitude.splitting.system import System
from attitude.torques.torque import BY_RATE, LINEAR, SLIP

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.spin import Spin
    from attitude.splitting.step_mesh import StepMesh

# Steps whose derivatives are in memory together: 4 MB.
_BLOCK = 4096
# rad, and shares of the rate and of the moments: differences of fourth order with these err by
# 1e-12 of a torque that is smooth in them.
_TURN, _SHARE = 1e-3, 1e-3
NODES = np.array([1.0, -1.0, 2.0, -2.0])
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12.0
# One-sided, for moments: at a flat body they cannot change to both sides.
_SIDED = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
# Moments (rows) by the second moments of mass (columns), which are independent and not negative.
_BY_MASS = np.ones((3, 3)) - np.eye(3)


class TorquedSensitivity(Derivatives):
    """The derivatives of one torqued motion at any epoch.

    Parameters
    ----------
    system : System
    body, spin : Body, Spin
    meshes : callable
        ``meshes(side, until)``: the `StepMesh` of the steps after (0) or before (1) the epoch that
        reaches `until`, s.
    states : callable
        ``states(seconds, low)``: states (N, 7) over the body axes at seconds + low (N,).
    parameters : sequence of (float, sequence of System)
        For each parameter of the torques by which `at` has a column after those of the state: a
        step, and the systems at it times `NODES`.
    """

    def __init__(
        self,
        system: System,
        body: Body,
        spin: Spin,
        meshes: Callable[[int, float], StepMesh],
        states: Callable[[FloatArray, FloatArray], FloatArray],
        parameters: Sequence[tuple[float, Sequence[System]]] = (),
    ) -> None:
        self._system, self._body, self._meshes, self._states = system, body, meshes, states
        self._others = self._with_other_moments(spin)
        self._parameters = tuple(parameters)
        self._width = 9 + len(self._parameters)
        kinds = {torque.kind for torque in system.torques}
        self._by_rate, self._slips = bool({BY_RATE, LINEAR} & kinds), SLIP in kinds

    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9 + P), ICRF axes, and of the angular velocity, body axes."""
        t = np.asarray(seconds, dtype=np.float64).reshape(-1)
        rest = np.zeros(t.size) if low is None else np.asarray(low, dtype=np.float64).reshape(-1)
        found = np.full((t.size, self._width, self._width), np.nan)
        with np.errstate(invalid="ignore"):
            sides = t + rest >= 0.0, t + rest < 0.0
        for side, here in enumerate(sides):
            if np.any(here):
                found[here] = self._on_side(side, t[here], rest[here])
        shape = (*np.shape(seconds), 3, self._width)
        omega = found[:, 3:6].reshape(shape) if rates else None
        return found[:, :3].reshape(shape), omega

    def by_elements(self) -> FloatArray:
        """Refused: the elements of a torqued motion change with time."""
        raise AttitudeError(
            'by is "elements"; a motion under torques has no constant elements. Give by="state".'
        )

    def _on_side(self, side: int, t: FloatArray, low: FloatArray) -> FloatArray:
        """The maps (T, 9 + P, 9 + P) from the epoch to t + low, of one direction."""
        order = np.argsort(np.abs(t + low), kind="stable")
        t, low = t[order], low[order]
        mesh = self._meshes(side, float(t[-1] + low[-1]))
        place, parts = mesh.place(t, low)
        found = np.empty((len(t), self._width, self._width))
        whole = np.eye(self._width)
        for first in range(0, mesh.count, _BLOCK):
            end = min(first + _BLOCK, mesh.count)
            starts = mesh.times[:, first:end]
            states = self._states(*starts)
            begin, stop = np.searchsorted(place, [first, end])
            before = np.empty((end - first, self._width, self._width))
            steps = self._maps(states, starts, mesh.lengths(first, end), mesh.halves)
            for k, step in enumerate(steps):
                before[k] = whole
                whole = step @ whole
            here = place[begin:stop] - first
            last = self._maps(states[here], starts[:, here], parts[begin:stop], mesh.halves)
            found[order[begin:stop]] = last @ before[here]
        return found

    def _maps(
        self, states: FloatArray, starts: FloatArray, lengths: FloatArray, halves: int
    ) -> FloatArray:
        """The maps (N, 9 + P, 9 + P) of steps from states (N, 7) over the body axes."""
        whole = np.broadcast_to(np.eye(self._width), (len(states), self._width, self._width))
        length, wxyz, omega = lengths / halves, states[:, :4], states[:, 4:]
        for half in range(halves):
            begin = np.stack([starts[0] + half * length, starts[1]])
            times = self._system.kick_times(begin, length)
            wxyz, omega, step = self._step(wxyz, omega, times, length)
            whole = step @ whole
        return whole

    def _step(
        self, wxyz: FloatArray, omega: FloatArray, times: FloatArray, h: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """States after steps of lengths h (N,), and the maps (N, 9 + P, 9 + P)."""
        scheme = self._system.scheme
        whole = np.broadcast_to(np.eye(self._width), (len(h), self._width, self._width))
        for j, (part, gradient) in enumerate(zip(scheme.kicks, scheme.gradients, strict=True)):
            if part != 0.0 or gradient != 0.0:
                given = times[..., j], part * h, gradient * h**3
                wxyz, omega, change = self._kick(wxyz, omega, *given)
                whole = change @ whole
            if j < len(scheme.flights) and scheme.flights[j] != 0.0:
                wxyz, omega, change = self._flight(wxyz, omega, scheme.flights[j] * h)
                whole = change @ whole
        return wxyz, omega, whole

    def _flight(
        self, wxyz: FloatArray, omega: FloatArray, t: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """States after free motions for t (N,) seconds, and the maps (N, 9 + P, 9 + P)."""
        count, principal = len(t), self._body.principal_wxyz[None]
        moments = np.repeat(self._body.moments_as_pairs[None], count, axis=0)
        rates = np.zeros((count, 3, 2))
        rates[..., 0] = omega @ self._body.principal_axes
        wxyz = np.ascontiguousarray(wxyz)
        constants = evaluation.constants_of(moments, wxyz, rates, principal)
        tangents = columns.tangents_of(moments, wxyz, principal, constants)
        after, turning = np.empty((count, 4, 1)), np.empty((count, 3, 1))
        evaluation.evaluate(constants, t[:, None], None, after, turning)
        found = np.zeros((count, self._width, self._width))
        attitude, rate = np.empty((count, 3, 9, 1)), np.empty((count, 3, 9, 1))
        columns.evaluate(constants, tangents, t[:, None], None, attitude, rate)
        found[:, :3, :9], found[:, 3:6, :9] = attitude[..., 0], rate[..., 0]
        found[:, 6:, 6:] = np.eye(self._width - 6)
        return after[..., 0], turning[..., 0], found

    def _kick(
        self,
        wxyz: FloatArray,
        omega: FloatArray,
        times: FloatArray,
        h: FloatArray,
        cubed: FloatArray,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """States after torques for h (N,) seconds, and the maps (N, 9 + P, 9 + P)."""
        count = len(h)
        given = times, h, cubed, self._system.sampled(times)
        after, gained = _kicked(self._system, wxyz, omega, given)
        maps = np.broadcast_to(np.eye(self._width), (count, self._width, self._width)).copy()
        many = times.repeat(4, axis=1), *(np.repeat(each, 4, axis=0) for each in given[1:])
        pace = _SHARE * np.sqrt(np.sum(omega**2 + gained**2, axis=1))
        pace = np.where(pace > 0.0, pace, 1.0)
        for j in range(6 if self._by_rate or self._slips else 3):
            q, w = wxyz.repeat(4, axis=0), omega.repeat(4, axis=0)
            if j < 3:
                size = np.full(count, _TURN)
                turns = forms.from_rotation_vector(_TURN * NODES[:, None] * np.eye(3)[j])
                q = quaternion.multiply(np.tile(turns, (count, 1)), q)
            else:
                size = pace
                w[:, j - 3] += (NODES * pace[:, None]).reshape(-1)
            ends, gains = _kicked(self._system, q, w, many)
            if self._slips:
                turned = _turns(ends, after.repeat(4, axis=0)).reshape(count, 4, 3)
                maps[:, :3, j] = np.einsum("nks,k->ns", turned, _WEIGHTS) / size[:, None]
            # a difference of the changes: the state itself would hide a weak torque by rounding
            changes = gains.reshape(count, 4, 3) - gained[:, None]
            maps[:, 3:6, j] += np.einsum("nks,k->ns", changes, _WEIGHTS) / size[:, None]
        by_mass = np.zeros((count, 6, 3))
        longest = _SHARE * float(np.max(self._body.moments))
        for j, others in enumerate(self._others):
            for weight, other in zip(_SIDED[1:], others, strict=True):
                end, gain = _kicked(other, wxyz, omega, given)
                if self._slips:
                    by_mass[:, :3, j] += weight / longest * _turns(end, after)
                by_mass[:, 3:, j] += weight / longest * (gain - gained)
        maps[:, :6, 6:9] = by_mass @ np.linalg.inv(_BY_MASS)
        for j, (step, systems) in enumerate(self._parameters, start=9):
            for weight, other in zip(_WEIGHTS / step, systems, strict=True):
                end, gain = _kicked(other, wxyz, omega, given)
                if self._slips:
                    maps[:, :3, j] += weight * _turns(end, after)
                maps[:, 3:6, j] += weight * (gain - gained)
        return after, omega + gained, maps

    def _with_other_moments(self, spin: Spin) -> list[list[System]]:
        """Systems whose three second moments of mass are larger by four steps each."""
        size = _SHARE * float(np.max(self._body.moments))
        systems = []
        for column in _BY_MASS.T:
            found = []
            for k in range(1, 5):
                change = np.concatenate([np.zeros(6), k * size * column])
                body, _ = changed(self._body, spin, change)
                found.append(System(body, spin, self._system.torques, self._system.scheme))
            systems.append(found)
        return systems


def _kicked(
    system: System, wxyz: FloatArray, omega: FloatArray, given: tuple[Any, ...]
) -> tuple[FloatArray, FloatArray]:
    """Attitudes (N, 4) after kicks, and the changes (N, 3) of the angular velocity, body axes."""
    from attitude.solution.march import kicks

    times, h, cubed, samples = given
    states = np.zeros((len(h), STATE_ENTRIES))
    states[:, WXYZ] = quaternion.multiply(wxyz, system.turn)
    states[:, OMEGA] = omega @ system.axes
    out = np.empty_like(states)
    numbers, _, models = system.setup
    first = np.ascontiguousarray(times[0])
    system.run(kicks, 0.0, numbers, models, states, first, h, cubed, samples, out)
    gained = (out[:, OMEGA] - states[:, OMEGA]) + out[:, OMEGA_LOW]
    return quaternion.multiply(out[:, WXYZ], quaternion.conjugate(system.turn)), (
        gained @ system.axes.T
    )


def _turns(wxyz: FloatArray, reference: FloatArray) -> FloatArray:
    """Rotation vectors (N, 3), inertial axes, from reference attitudes to others."""
    return forms.to_rotation_vector(quaternion.multiply(wxyz, quaternion.conjugate(reference)))
