"""Motion under torques: kicks between exact free motions.

>>> import numpy as np
>>> from attitude import Body, Spin
>>> from attitude.splitting import TorquedRotation
>>> from attitude.torques import ConstantTorque
>>> body = Body(moments=(10, 20, 26))
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
>>> motion = TorquedRotation(body, spin, ConstantTorque((0, 0, 0.26)), step=0.1)
>>> motion.at(10.0).angular_velocity.round(12)          # 0.01 rad/s2 for 10 s
array([0. , 0. , 0.1])
"""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from attitude import epochs, validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation.differentiable import Differentiable
from attitude.spin import Spin
from attitude.splitting import schemes
from attitude.splitting.bounded_steps import BoundedSteps
from attitude.splitting.sensitivity import TorquedSensitivity
from attitude.splitting.steps import FixedSteps
from attitude.splitting.system import System
from attitude.splitting.varying_steps import VaryingSteps
from attitude.torques.torque import Torque

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude.annotations import Epoch, FloatArray, Real
    from attitude.epochs import Instant
    from attitude.splitting.schemes import Scheme
    from attitude.splitting.step_mesh import StepMesh

    TorqueFunction = Callable[[float, FloatArray, FloatArray], ArrayLike]
    _Steps = FixedSteps | VaryingSteps | BoundedSteps

# Epochs in a block.
_EPOCHS = 1 << 17
# rad
_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False, repr=False, init=False)
class TorquedRotation(Differentiable):
    """Rotation of a rigid body under torques, by a splitting scheme around exact free motion.

    Parameters
    ----------
    body : Body
        All of whose moments are greater than zero.
    spin : Spin
        The state at its epoch; the motion reaches from it in both directions.
    torques : Torque, function, or sequence of them
        See `attitude.torques`.  A function is taken as a `CustomTorque`.
    step : float, optional
        s, or a Quantity: fixed.
    scheme : str or Scheme, optional
        "kick-rotate-kick", "rotate-kick-rotate" and "hoa" of second order, "suzuki",
        "blanes-moan" and "force-gradient" of fourth order; see `attitude.splitting.schemes`.  By
        default "blanes-moan" with `tolerance`, otherwise "kick-rotate-kick".
    tolerance : float, optional
        Instead of `step`: largest error of an attitude, rad, from 1e-14 to 1e-2; 1e-9 if neither
        `step` nor `step_tolerance` is given.  The steps vary with the motion: right for one
        encounter, not symplectic over many.
    step_tolerance : float, optional
        Instead of these: largest error of a step, in rad of attitude and as relative change of the
        angular velocity, from 1e-14 to 1e-2.  Errors of steps add up, and may grow.
    span : pair of epochs, optional
        With `tolerance`: first and last epoch, as ``at`` takes them, for which the steps are
        planned; by default the first epochs asked.  See Notes for others.

    Attributes
    ----------
    torques : tuple of Torque
    scheme : Scheme
    step, tolerance, step_tolerance : float or None
        s, rad, rad; two of them are None.

    Raises
    ------
    AttitudeError
        For a step that cannot resolve the rotation, a torque that is not finite or of another
        shape, epochs that a path does not cover.

    Notes
    -----
    Between steps, the motion is that of a shorter last step: the order of the scheme holds at
    every epoch, and the motion is continuous.  States are integrated on demand, and every 32nd is
    kept, every 64th once there are 131,072 and so on: later calls, in any order of epochs, start
    from the nearest, and 1e8 steps need no more memory (15 MB) than 4e6.  Paths are evaluated at
    epochs of two doubles.  Free motion errs by rounding times the angle turned
    (solution/step.py), summed with compensation and without a mean: the energy walks at random
    by 2e-14 in 1e8 steps of 0.08 rad.

    With `tolerance`, the difference from a motion with steps twice as long, from the epoch on, is
    the estimate of the error (`error_estimate`), which is 2 to 15 times smaller; all steps are
    shortened together until the estimate is within the tolerance.  An epoch beyond the span has the
    steps planned anew if the estimate exceeds the tolerance there; the last digits of earlier
    epochs then change within the tolerance.  A torque that acts for less than a step may be missed:
    give a fixed step that resolves it.

    Derivatives (`sensitivity_at`, and with them covariances) are those of the scheme with its
    steps: of free motions in closed form, of torques by differences of fourth order, 1e-12 of the
    torque where it is smooth.  They take some 40 times as long as the motion.

    "force-gradient" takes any number of `GravityGradient`, `ConstantTorque`, and `CustomTorque`
    with a slope; other torques are refused by name.

    Source: van Zon & Schofield, Phys. Rev. E 75, 056701 (2007), cond-mat/0612404; van Zon,
    Omelyan & Schofield, J. Chem. Phys. 128, 136102 (2008).
    """

    body: Body
    spin: Spin
    torques: tuple[Torque, ...]
    step: float | None
    scheme: Scheme
    tolerance: float | None
    step_tolerance: float | None

    smooth = True

    _value = (
        *("body", "spin", "torques", "scheme"),
        *("step", "tolerance", "step_tolerance", "_span_given"),
    )

    def __init__(
        self,
        body: Body,
        spin: Spin,
        torques: Torque | TorqueFunction | Iterable[Torque | TorqueFunction],
        step: Real | None = None,
        scheme: str | Scheme | None = None,
        tolerance: Real | None = None,
        *,
        step_tolerance: Real | None = None,
        span: tuple[Epoch | float, Epoch | float] | None = None,
    ) -> None:
        self._system: System
        self._grids: tuple[_Steps, _Steps]
        self._lock: threading.Lock
        self._horizons: tuple[float, float]
        self._span_given: Any
        if not isinstance(body, Body) or not isinstance(spin, Spin):
            raise AttitudeError(
                "TorquedRotation takes a Body, a Spin and torques; given were "
                f"{type(body).__name__} and {type(spin).__name__}."
            )
        self._set("body", body)
        self._set("spin", spin)
        self._set("torques", _torques(torques))
        if sum(each is not None for each in (step, tolerance, step_tolerance)) > 1:
            raise AttitudeError(
                "a TorquedRotation takes one of step=(s), tolerance=(rad) and step_tolerance=(rad)."
            )
        if step is None and step_tolerance is None and tolerance is None:
            tolerance = _TOLERANCE
        if scheme is None:
            scheme = "kick-rotate-kick" if tolerance is None else "blanes-moan"
        self._set("scheme", schemes.scheme(scheme))
        self._set("_system", System(self.body, self.spin, self.torques, self.scheme))
        self._set("step", None if step is None else self._checked_step(step))
        for name, given in (("tolerance", tolerance), ("step_tolerance", step_tolerance)):
            self._set(name, None if given is None else _checked_tolerance(given, name))
        self._set("_span_given", span)
        self._set("_horizons", self._planned(span))
        self._forget()
        _living[id(self)] = self

    def _checked_step(self, step: Real) -> float:
        length = validation.positive(step, "step", unit="s")
        self._system.check_step(length)
        return length

    def _forget(self) -> None:
        """Start without integrated states, and with a lock that no thread holds."""
        self._set("_lock", threading.Lock())
        self._set("_grids", (self._grid(0), self._grid(1)))

    def _planned(self, span: Any) -> tuple[float, float]:
        """Seconds after and before the epoch for which steps are planned."""
        if span is None:
            return 0.0, 0.0
        if self.tolerance is None:
            raise AttitudeError(
                "span is for tolerance=, the error over a span; leave it out with step= and "
                "step_tolerance=."
            )
        hi, lo = epochs.seconds_since(self.epoch, span, name="span")
        ends = hi if lo is None else hi + lo
        if ends.shape != (2,) or not np.all(np.isfinite(ends)) or ends[0] > ends[1]:
            raise AttitudeError(f"span is {span!r}; give two epochs, the earlier one first.")
        return max(float(ends[1]), 0.0), max(-float(ends[0]), 0.0)

    def _grid(self, side: int) -> _Steps:
        """The states after the epoch (0) or before it (1)."""
        sign = -1.0 if side else 1.0
        if self.step is not None:
            return FixedSteps(self._system, sign * self.step)
        if self.step_tolerance is not None:
            return VaryingSteps(self._system, sign, self.step_tolerance)
        assert self.tolerance is not None
        return BoundedSteps(self._system, sign, self.tolerance, self._horizons[side])

    def __reduce__(self):
        given = {"tolerance": self.tolerance, "step_tolerance": self.step_tolerance}
        how = {"step": self.step, "scheme": self.scheme, "span": self._span_given, **given}
        return partial(TorquedRotation, **how), (self.body, self.spin, self.torques)

    @cached_property
    def _sensitivity(self) -> TorquedSensitivity:
        given = self._system, self.body, self.spin
        return TorquedSensitivity(*given, self._mesh, self._states)

    def sensitivity_with_torques(
        self, others: Iterable[tuple[float, Iterable[Iterable[Torque]]]]
    ) -> TorquedSensitivity:
        """The derivatives by the state, the moments and parameters of the torques.

        Parameters
        ----------
        others : iterable of (float, 4 tuples of Torque)
            For each parameter a step, and the torques with it changed by the step times +1, -1,
            +2, -2 (`sensitivity.NODES`).

        Returns
        -------
        TorquedSensitivity
            Whose ``at(seconds, low, rates)`` has a column for each parameter after the nine.
        """
        parameters = [
            (size, [System(self.body, self.spin, tuple(each), self.scheme) for each in torques])
            for size, torques in others
        ]
        given = self._system, self.body, self.spin
        return TorquedSensitivity(*given, self._mesh, self._states, parameters)

    def _mesh(self, side: int, until: float) -> StepMesh:
        """The steps after the epoch (0) or before it (1) that reach `until`, s."""
        with self._lock:
            return self._grids[side].mesh(until)

    def _with(self, body: Body, spin: Spin) -> Self:
        made, (_, _, torques) = self.__reduce__()
        other: Self = made(body, spin, torques)
        return other

    def __repr__(self) -> str:
        if self.step is not None:
            how = f"step {self.step:g} s"
        elif self.step_tolerance is not None:
            how = f"to {self.step_tolerance:g} rad a step"
        else:
            how = f"to {self.tolerance:g} rad"
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<TorquedRotation: {names}; {self.scheme.name}, {how}>"

    @property
    def epoch(self) -> Instant:
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    @property
    def steps_taken(self) -> tuple[float, float]:
        """(first, last) seconds since the epoch between which states have been integrated."""
        ahead, behind = (grid.reached for grid in self._grids)
        return behind, ahead

    @property
    def error_estimate(self) -> float:
        """Estimate of the largest error of an attitude, rad, at the epochs asked so far.

        With `tolerance` and `span`, in the span.  With `step` and `step_tolerance`, each access
        integrates the motion again with other steps.  Rounding and the truncation of the steps are
        estimated; errors of the body, the state and the torques are not.
        """
        with self._lock:
            return max(grid.estimate() for grid in self._grids)

    def _evaluate(
        self, seconds: FloatArray, low: FloatArray | None, order: int
    ) -> list[FloatArray]:
        # Attitudes and angular velocities are integrated together, in blocks of epochs: Ctrl-C is
        # heard between them, and the memory beside the result is bounded.
        flat = seconds.reshape(-1)
        rest = np.zeros(flat.size) if low is None else np.asarray(low).reshape(-1)
        found = [np.empty((flat.size, width)) for width in (4, 3, 3)[: max(order, 1) + 1]]
        for begin in range(0, flat.size, _EPOCHS):
            here = slice(begin, begin + _EPOCHS)
            states = self._states(flat[here], rest[here])
            found[0][here], found[1][here] = states[:, :4], states[:, 4:]
            if order > 1:
                found[2][here] = self._system.acceleration(flat[here], rest[here], states)
        return [part.reshape(*seconds.shape, part.shape[-1]) for part in found]

    def _states(self, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """(N, 7): wxyz body to ICRF, angular velocity over body axes, at seconds + low (N,)."""
        out = np.full((seconds.size, 7), np.nan)
        with np.errstate(invalid="ignore", over="ignore"):  # infinities are refused below
            total = seconds + low
        if np.any(np.isinf(total)):
            raise AttitudeError(
                "an epoch is infinite; give finite epochs, or NaN for a missing one."
            )
        with self._lock:
            for grid, here in zip(self._grids, (total >= 0.0, total < 0.0), strict=True):
                if np.any(here):
                    out[here] = grid.states(seconds[here], low[here])
        return self._system.over_body_axes(out)


# All motions of the process by their identity: equal motions have locks of their own.
_living: weakref.WeakValueDictionary[int, TorquedRotation] = weakref.WeakValueDictionary()


def _after_fork() -> None:
    """In a forked process, free the locks of threads that do not live there.

    States that such a thread was changing are discarded.
    """
    for motion in list(_living.values()):
        if motion._lock.locked():
            motion._forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _checked_tolerance(given: Real, name: str) -> float:
    tolerance = validation.positive(given, name)
    if not 1e-14 <= tolerance <= 1e-2:
        raise AttitudeError(f"{name} is {tolerance!r}; give one from 1e-14 to 1e-2 (rad).")
    return tolerance


def _torques(given: Any) -> tuple[Torque, ...]:
    validation.refuse_class(given, "torques")
    if isinstance(given, Torque) or callable(given):
        given = (given,)
    if not isinstance(given, Iterable):
        raise AttitudeError(
            f"torques is {validation.shown(given)}; give an object of attitude.torques, a function "
            "of (t, wxyz, omega), or a list of them."
        )
    found = []
    for k, torque in enumerate(given):
        if not isinstance(torque, Torque):
            validation.refuse_class(torque, f"torques[{k}]")
            if not callable(torque):
                raise AttitudeError(
                    f"torques holds {torque!r}; give objects of attitude.torques, or functions of "
                    "(t, wxyz, omega)."
                )
            from attitude.torques.custom import CustomTorque

            torque = CustomTorque(torque)
        found.append(torque)
    if not found:
        raise AttitudeError("torques is empty; give a torque, or use FreeRotation.")
    return tuple(found)
