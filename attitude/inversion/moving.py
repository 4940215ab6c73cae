"""Motions with parameters: a free rotation, one that impulses divide, or one under torques.

A point has a body whose principal axes are its axes, a spin, and changes with numbers to find: the
momentum of each impulse (3), a torque that is fixed in the body (3), the strength of sunlight (1).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, quaternion
from attitude import representations as forms
from attitude.arcs import Arcs, Impulse
from attitude.arcs.triggers import Trigger
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation import FreeRotation
from attitude.free_rotation.sensitivity import changed
from attitude.spin import Spin
from attitude.splitting import TorquedRotation
from attitude.splitting.sensitivity import NODES
from attitude.torques import ConstantTorque, SolarRadiation, Torque

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.epochs.instants import Instant

Motion = FreeRotation | Arcs | TorquedRotation
# Parameters of the state: turn (rad, ICRF), rates (rad/s), ln I1/I3, ln I2/I3.
STATE = 8
# Error of the attitudes of torqued motions, rad: some 1e-4 mag.
_TOLERANCE = 1e-4
# Step of the differences by a torque: a share of the torque that would stop the body in the span.
# A kick is linear in the torque.
_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class MovingPoint:
    """A state and the changes of the motion from then on.

    Attributes
    ----------
    body : Body
    spin : Spin
        Of ICRF axes.
    impulses : tuple of Impulse
    torques : tuple of Torque
    reach : (float, float)
        First and last epoch of the curve, s since that of the spin.
    """

    body: Body
    spin: Spin
    impulses: tuple[Impulse, ...]
    torques: tuple[Torque, ...]
    reach: tuple[float, float]

    @property
    def size(self) -> int:
        """The number of parameters."""
        return STATE + 3 * len(self.impulses) + sum(_numbers(each) for each in self.torques)

    @property
    def motion(self) -> Motion:
        """The motion."""
        return self.motion_of(self.spin)

    def motion_of(self, spin: Spin) -> Motion:
        """The motion from another spin, such as the same with a covariance."""
        if self.impulses:
            return Arcs(self.body, spin, self.impulses)
        if self.torques:
            low, high = min(self.reach[0], 0.0), max(self.reach[1], 0.0)
            return TorquedRotation(
                self.body, spin, self.torques, tolerance=_TOLERANCE, span=(low, high)
            )
        return FreeRotation(self.body, spin)

    @property
    def log_ratios(self) -> FloatArray:
        """ln I1/I3 and ln I2/I3 (2,)."""
        found: FloatArray = np.log(self.body.moments[:2] / self.body.moments[2])
        return found

    @property
    def values(self) -> FloatArray:
        """The numbers of the changes: momenta, torques (3 each), flux of sunlight in W/m2."""
        found = [np.asarray(each.angular_momentum, float) for each in self.impulses]
        for torque in self.torques:
            if isinstance(torque, ConstantTorque):
                found.append(np.asarray(torque.torque, float))
            elif isinstance(torque, SolarRadiation):
                found.append(np.array([torque.flux]))
        return np.concatenate(found) if found else np.zeros(0)

    def attitudes(self, seconds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation matrices (N, 3, 3) to ICRF and rotation vectors (N, 3, P) by the parameters."""
        motion = self.motion
        matrix = motion.at(seconds).matrix
        if self.torques:
            assert isinstance(motion, TorquedRotation)
            made = motion.sensitivity_with_torques(self._others())
            found = made.at(seconds, None, False)[0]
        else:
            found = motion._sensitivity.at(seconds, None, False)[0]
            if isinstance(motion, Arcs):
                more = motion._sensitivity.by_momenta(seconds, None)[0]
                found = np.concatenate([found, more], axis=-1)
        slopes = np.delete(found, 8, axis=-1)
        slopes[..., 6:8] *= self.body.moments[:2]
        return matrix, slopes

    def difference(self, origin: MovingPoint) -> FloatArray:
        """The parameters (P,) of this point from those of another."""
        turn = quaternion.multiply(self.spin.wxyz_icrf, quaternion.conjugate(origin.spin.wxyz_icrf))
        rates = self.spin.angular_velocity - origin.spin.angular_velocity
        ratios = self.log_ratios - origin.log_ratios
        values = self.values - origin.values
        return np.concatenate([forms.to_rotation_vector(turn), rates, ratios, values])

    def by_state(self) -> FloatArray:
        """Changes (9, P) of the state of `Spin.covariance` for unit changes of the parameters."""
        found = np.zeros((9, self.size))
        found[range(6), range(6)] = 1.0
        found[6, 6], found[7, 7] = self.body.moments[:2]
        return found

    def moved(self, step: FloatArray) -> MovingPoint | None:
        """The point after a step of limited length; None if that is no body's."""
        longest = max(
            float(np.linalg.norm(step[:3])) / 0.5,
            float(np.abs(step[6:8]).max()) / 0.3,
            1.0,
        )
        step = step / longest
        changes = np.concatenate([step[:6], self.body.moments[:2] * np.expm1(step[6:8]), [0.0]])
        try:
            body, spin = changed(self.body, self.spin, changes)
        except AttitudeError:
            return None
        impulses, torques = self._changed(self.values + step[STATE:])
        return MovingPoint(body, spin, impulses, torques, self.reach)

    def _changed(self, values: FloatArray) -> tuple[tuple[Impulse, ...], tuple[Torque, ...]]:
        """The changes with other numbers."""
        count = len(self.impulses)
        impulses = tuple(
            Impulse(each.at, values[3 * k : 3 * k + 3], each.frame)
            for k, each in enumerate(self.impulses)
        )
        torques, at = [], 3 * count
        for torque in self.torques:
            torques.append(_with_numbers(torque, values[at : at + _numbers(torque)]))
            at += _numbers(torque)
        return impulses, tuple(torques)

    def _others(self) -> list[tuple[float, list[tuple[Torque, ...]]]]:
        """A step for each number of the torques, and the torques there."""
        values = self.values
        length = max(self.reach[1] - self.reach[0], 1e-9)
        momentum = float(np.linalg.norm(self.body.tensor @ self.spin.angular_velocity))
        found = []
        for k, value in enumerate(values):
            is_flux = _numbers(self._owner(k)) == 1
            size = _SHARE * (max(abs(float(value)), 1e-9) if is_flux else momentum / length)
            many = []
            for node in NODES:
                other = values.copy()
                other[k] += node * size
                many.append(self._changed(other)[1])
            found.append((size, many))
        return found

    def _owner(self, number: int) -> Torque:
        """The torque to which a number belongs."""
        end = 0
        for torque in self.torques:
            end += _numbers(torque)
            if number < end:
                return torque
        raise AssertionError(number)


def of(
    start: Motion, epoch: Instant, reach: tuple[float, float], arcs: Any, torques: Any
) -> MovingPoint:
    """The point of a motion and of changes that are given, at the epoch of its spin.

    Parameters
    ----------
    start : FreeRotation, Arcs or TorquedRotation
    epoch : Instant
        Of the curve.
    reach : (float, float)
        First and last epoch of the curve, s since its epoch.
    arcs : Impulse or sequence of them, optional
    torques : Torque or sequence of them, optional

    Raises
    ------
    AttitudeError
        For other kinds of motion or change, and for both arcs and torques.
    """
    if not isinstance(start, (FreeRotation, Arcs, TorquedRotation)):
        raise AttitudeError(
            f"start is {type(start).__name__}; give a Solution or Refinement, a FreeRotation, Arcs "
            "or a TorquedRotation."
        )
    if arcs is None and isinstance(start, Arcs):
        arcs = start.changes
    if torques is None and isinstance(start, TorquedRotation):
        torques = start.torques
    impulses, loads = _listed(arcs, Impulse, "arcs"), _listed(torques, Torque, "torques")
    if impulses and loads:
        raise AttitudeError("arcs and torques are both given; give one of them.")
    for k, impulse in enumerate(impulses):
        if callable(impulse.angular_momentum) or isinstance(impulse.at, Trigger):
            raise AttitudeError(
                f"arcs[{k}] depends on the motion; give an Impulse at an epoch with three numbers."
            )
    body, spin = start.body, start.spin
    axes = body.principal_wxyz
    wxyz = quaternion.multiply(spin.wxyz_icrf, axes)
    omega = spin.angular_velocity @ body.principal_axes
    own = Body(moments=body.moments, relative=body.relative, mass=body.mass)
    moved = any(each.frame == "body" for each in impulses) or bool(loads)
    if moved and not np.allclose(body.principal_axes, np.eye(3)):
        raise AttitudeError(
            "the axes of the body are not its principal axes, over which momenta and torques are "
            "fitted; give a Body with moments=."
        )
    shift = epoch.seconds - spin.epoch.seconds
    ends = reach[0] + shift, reach[1] + shift
    return MovingPoint(own, Spin(spin.epoch, wxyz, omega), impulses, loads, ends)


def seconds_of(point: MovingPoint, epoch: Instant, seconds: FloatArray) -> FloatArray:
    """Seconds since the epoch of a point's spin, of seconds (N,) since another epoch."""
    hi, lo = epochs.seconds_since(point.spin.epoch, epoch)
    return seconds + (float(hi) + (0.0 if lo is None else float(lo)))


def _listed(given: Any, kind: type, name: str) -> tuple[Any, ...]:
    """What is given, as a tuple of one kind."""
    if given is None:
        return ()
    if isinstance(given, kind):
        given = (given,)
    if not isinstance(given, Iterable):
        raise AttitudeError(f"{name} is {given!r}; give a list of {kind.__name__} objects.")
    found = tuple(given)
    for k, each in enumerate(found):
        if not isinstance(each, kind):
            raise AttitudeError(f"{name}[{k}] is {each!r}; give {kind.__name__} objects.")
    return found


def _numbers(torque: Torque) -> int:
    """How many numbers of a torque are found; others than these two kinds are known."""
    return 3 if isinstance(torque, ConstantTorque) else int(isinstance(torque, SolarRadiation))


def _with_numbers(torque: Torque, values: FloatArray) -> Torque:
    if isinstance(torque, ConstantTorque):
        return ConstantTorque(values)
    if isinstance(torque, SolarRadiation):
        made = SolarRadiation(torque.shape, torque.path, torque.diffuse, torque.mirrored)
        made._set("flux", float(values[0]))  # a fit may make the strength negative
        return made
    return torque
