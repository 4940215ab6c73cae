"""Derivatives of the attitudes of a chain of arcs by the state and the moments at its epoch.

Each arc has the derivatives of a free rotation by its own first state; at a joint the change of
that state follows from the change of the momentum, L' = L + dL and w' = I'^-1 L'.  The product of
these maps is the derivative by the state at the epoch of the chain.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import evaluation, frames, pairs, quaternion
from attitude import representations as forms
from attitude.arcs.changes import InertiaChange
from attitude.arcs.triggers import Trigger
from attitude.errors import AttitudeError
from attitude.free_rotation.sensitivity import Derivatives
from attitude.history import AttitudeHistory
from attitude.sensitivities import columns
from attitude.sensitivities.elements import inputs_by_elements

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.arcs.changes import Change
    from attitude.body import Body
    from attitude.epochs.instants import Instant

# Turn, rad, of the central differences of an event's function: their error is 1e-11 of its scale.
_STEP = 1e-5


class ChainedSensitivity(Derivatives):
    """The derivatives of one chain at any epoch.

    Parameters
    ----------
    constants : (N + 1,) structured array
        Of the arcs, by `evaluation.constants_of`.
    starts : (N + 1, 2) array
        Their first epochs, s, in two doubles.
    bodies : sequence of Body
    wxyz : (N + 1, 4) array
        Attitudes at the starts, body to ICRF.
    changes : sequence of Change
        Between the arcs.  An event that moves with the state moves the joint.
    epoch : Instant
        From which the seconds count.

    Raises
    ------
    AttitudeError
        For a change whose momentum is a function of the motion.
    """

    def __init__(
        self,
        constants: Any,
        starts: FloatArray,
        bodies: Sequence[Body],
        wxyz: FloatArray,
        changes: Sequence[Change],
        epoch: Instant,
    ) -> None:
        for k, change in enumerate(changes):
            if callable(change.angular_momentum):
                raise AttitudeError(
                    f"the momentum of changes[{k}] is a function of the motion, which has no "
                    "derivative in closed form; give the momentum as three numbers."
                )
        self._constants, self._starts, self._bodies = constants, starts, bodies
        self._epoch, self._changes = epoch, tuple(changes)
        self._tangents = [
            columns.tangents_of(
                body.moments_as_pairs[None], start[None], body.principal_wxyz[None], record[None]
            )
            for body, start, record in zip(bodies, wxyz, constants, strict=True)
        ]
        self._maps = [np.eye(9)]
        for k, change in enumerate(changes):
            self._maps.append(self._over_joint(k, change) @ self._maps[k])

    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9), ICRF axes, and of the angular velocity, body axes."""
        return self._chained(self._maps, seconds, low, rates)

    def by_momenta(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool = False
    ) -> tuple[FloatArray, FloatArray | None]:
        """As `at`, by the momenta of the changes: columns (3 N), each in the frame of its change.

        Parameters
        ----------
        seconds, low : (S,) arrays
        rates : bool
        """
        count = len(self._changes)
        maps = [np.zeros((9, 3 * count))]
        for k, change in enumerate(self._changes):
            after = self._over_joint(k, change) @ maps[k]
            turn = np.eye(3)
            if change.frame != "body":
                wxyz, _ = self._state(k, self._starts[k + 1])
                turn = quaternion.matrix(wxyz).T @ frames.matrix_to_icrf(change.frame)
            after[3:6, 3 * k : 3 * k + 3] += np.linalg.solve(self._bodies[k + 1].tensor, turn)
            maps.append(after)
        return self._chained(maps, seconds, low, rates)

    def _chained(
        self,
        maps: Sequence[FloatArray],
        seconds: FloatArray,
        low: FloatArray | None,
        rates: bool,
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes (S, 3, P) of attitude and rates from those (9, P) of each arc's first state."""
        t = np.asarray(seconds, dtype=np.float64).reshape(-1)
        rest = np.zeros(t.size) if low is None else np.asarray(low, dtype=np.float64).reshape(-1)
        width = maps[0].shape[1]
        attitude = np.full((t.size, 3, width), np.nan)
        omega = np.full((t.size, 3, width), np.nan) if rates else None
        arcs = np.zeros(t.size, dtype=int)
        with np.errstate(invalid="ignore"):
            high, rest = pairs.two_sum(t, rest)
            for start, more in self._starts[1:]:
                arcs += (high > start) | ((high == start) & (rest >= more))
        for k in np.unique(arcs):
            on = arcs == k
            one, two = self._on_arc(int(k), high[on], rest[on], rates)
            attitude[on] = one @ maps[k]
            if omega is not None:
                assert two is not None
                omega[on] = two @ maps[k]
        shape = (*np.shape(seconds), 3, width)
        return attitude.reshape(shape), None if omega is None else omega.reshape(shape)

    def by_elements(self) -> FloatArray:
        """Changes (6, 5) of angular velocity and moments with the elements of the first arc."""
        return inputs_by_elements(self._constants[0], self._tangents[0]["by_input"][0])

    def _on_arc(
        self, k: int, high: FloatArray, low: FloatArray, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """The columns (n, 3, 9) by the first state of an arc."""
        begin = self._starts[k]
        with np.errstate(invalid="ignore"):
            t, rest = pairs.add((high, low), -begin[0], -begin[1])
        record = self._constants[k : k + 1]
        attitude = np.empty((1, 3, 9, t.size))
        omega = np.empty((1, 3, 9, t.size)) if rates else None
        columns.evaluate(record, self._tangents[k], t[None], rest[None], attitude, omega)
        found = np.moveaxis(attitude[0], -1, 0)
        return found, None if omega is None else np.moveaxis(omega[0], -1, 0)

    def _over_joint(self, k: int, change: Change) -> FloatArray:
        """The map (9, 9) from the first state of an arc to that of the next."""
        end = self._starts[k + 1]
        attitude, omega = self._on_arc(k, end[:1], end[1:], rates=True)
        assert omega is not None
        whole = np.zeros((9, 9))
        whole[:3], whole[3:6], whole[6:, 6:] = attitude[0], omega[0], np.eye(3)
        wxyz, before = self._state(k, end)
        old: Body = self._bodies[k]
        new: Body = self._bodies[k + 1]
        added = np.asarray(change.angular_momentum, dtype=np.float64)
        matrix = quaternion.matrix(wxyz)
        momentum = _by_state(old, before)
        if change.frame != "body":
            inertial = np.sum(frames.vector_to_icrf(change.frame, added), axis=-1)
            # R^T dL turns with the attitude
            momentum[:, :3] += matrix.T @ _cross_matrix(inertial)
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
            later = self._delay(change.at, end, wxyz, before) @ whole[:3]
            product += np.outer(joint @ _rate(old, matrix, before), later)
            product -= np.outer(_rate(new, matrix, after), later)
        return product

    def _delay(
        self, event: Trigger, end: FloatArray, wxyz: FloatArray, omega: FloatArray
    ) -> FloatArray:
        """The change (3,) of the time of an event with the attitude then."""
        values = []
        for turn in _STEP * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)]):
            turned = quaternion.multiply(forms.from_rotation_vector(turn), wxyz)
            time = np.asarray(end[0]), np.asarray(end[1])
            history = AttitudeHistory(None, self._epoch, *time, turned)
            history.__dict__["angular_velocity"] = omega
            values.append(event.values(history))
        gradient = np.array([float(each[0]) for each in values[1:]])
        slopes = (gradient[:3] - gradient[3:]) / (2.0 * _STEP)
        found: FloatArray = -slopes / float(values[0][1])
        return found

    def _state(self, k: int, end: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Attitude and angular velocity at the end of an arc."""
        t, rest = pairs.add((end[:1], end[1:]), -self._starts[k][0], -self._starts[k][1])
        wxyz, omega = np.empty((1, 4, 1)), np.empty((1, 3, 1))
        record = self._constants[k : k + 1]
        evaluation.evaluate(record, t[None], rest[None], wxyz, omega)
        return wxyz[0, :, 0], omega[0, :, 0]


def _rate(body: Body, matrix: FloatArray, omega: FloatArray) -> FloatArray:
    """The rate of change (9,) of attitude (inertial axes), angular velocity and moments."""
    torque = np.cross(body.tensor @ omega, omega)
    return np.concatenate([matrix @ omega, np.linalg.solve(body.tensor, torque), np.zeros(3)])


def _by_state(body: Body, omega: FloatArray) -> FloatArray:
    """The change (3, 9) of the momentum over the body axes with that of the state."""
    axes = body.principal_axes
    found = np.zeros((3, 9))
    found[:, 3:6] = body.tensor
    found[:, 6:] = axes * (axes.T @ omega)
    return found


def _cross_matrix(v: FloatArray) -> FloatArray:
    """M with M x = v x x."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
