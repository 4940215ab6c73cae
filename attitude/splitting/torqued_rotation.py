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

import threading
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.motion import Motion
from attitude.spin import Spin
from attitude.splitting import schemes
from attitude.splitting.steps import FixedSteps, VaryingSteps
from attitude.splitting.system import System
from attitude.torques.torque import Torque

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, Real
    from attitude.epochs import Instant
    from attitude.splitting.schemes import Scheme

    TorqueFunction = Callable[[float, FloatArray, FloatArray], ArrayLike]


@dataclass(frozen=True, eq=False, repr=False, init=False)
class TorquedRotation(Motion):
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
    scheme : str or Scheme
        "kick-rotate-kick", "rotate-kick-rotate" and "hoa" of second order, "suzuki",
        "blanes-moan" and "force-gradient" of fourth order; see `attitude.splitting.schemes`.
    tolerance : float, optional
        Instead of `step`: largest error of a step, in rad of attitude and as relative change of
        the angular velocity, from 1e-14 to 1e-2.  The steps then vary with the motion: right for
        one encounter, not symplectic over many.

    Attributes
    ----------
    torques : tuple of Torque
    scheme : Scheme
    step, tolerance : float or None
        s, rad; one of them is None.

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

    smooth = True

    def __init__(
        self,
        body: Body,
        spin: Spin,
        torques: Torque | TorqueFunction | Iterable[Torque | TorqueFunction],
        step: Real | None = None,
        scheme: str | Scheme = "kick-rotate-kick",
        tolerance: Real | None = None,
    ) -> None:
        self._system: System
        self._grids: tuple[FixedSteps | VaryingSteps, FixedSteps | VaryingSteps]
        self._lock: threading.Lock
        if not isinstance(body, Body) or not isinstance(spin, Spin):
            raise AttitudeError(
                "TorquedRotation takes a Body, a Spin and torques; given were "
                f"{type(body).__name__} and {type(spin).__name__}."
            )
        self._set("body", body)
        self._set("spin", spin)
        self._set("torques", _torques(torques))
        self._set("scheme", schemes.scheme(scheme))
        if (step is None) == (tolerance is None):
            raise AttitudeError("a TorquedRotation takes either step=(s) or tolerance=(rad).")
        self._set("_system", System(self.body, self.spin, self.torques, self.scheme))
        self._set("_lock", threading.Lock())
        self._set("step", None if step is None else self._checked_step(step))
        self._set("tolerance", None if tolerance is None else _checked_tolerance(tolerance))
        self._set("_grids", (self._grid(1.0), self._grid(-1.0)))

    def _checked_step(self, step: Real) -> float:
        length = validation.positive(step, "step", unit="s")
        self._system.check_step(length)
        return length

    def _grid(self, sign: float) -> FixedSteps | VaryingSteps:
        """The states on one side of the epoch."""
        if self.step is not None:
            return FixedSteps(self._system, sign * self.step)
        assert self.tolerance is not None
        return VaryingSteps(self._system, sign, self.tolerance)

    def __reduce__(self):
        given = self.body, self.spin, self.torques, self.step, self.scheme, self.tolerance
        return TorquedRotation, given

    def __repr__(self) -> str:
        how = f"step {self.step:g} s" if self.tolerance is None else f"to {self.tolerance:g}"
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

    def _evaluate(
        self, seconds: FloatArray, low: FloatArray | None, order: int
    ) -> list[FloatArray]:
        # Attitudes and angular velocities are integrated together.
        states = self._states(seconds, low)
        found = [np.ascontiguousarray(part) for part in (states[..., :4], states[..., 4:])]
        if order > 1:
            found.append(self._system.acceleration(seconds, low, states))
        return found

    def _states(self, seconds: FloatArray, low: FloatArray | None) -> FloatArray:
        """(..., 7): wxyz body to ICRF, angular velocity over body axes."""
        flat = seconds.reshape(-1)
        rest = np.zeros(flat.size) if low is None else np.asarray(low).reshape(-1)
        out = np.full((flat.size, 7), np.nan)
        with np.errstate(invalid="ignore", over="ignore"):  # infinities are refused below
            total = flat + rest
        if np.any(np.isinf(total)):
            raise AttitudeError(
                "an epoch is infinite; give finite epochs, or NaN for a missing one."
            )
        with self._lock:
            for grid, here in zip(self._grids, (total >= 0.0, total < 0.0), strict=True):
                if np.any(here):
                    out[here] = grid.states(flat[here], rest[here])
        return self._system.over_body_axes(out).reshape(*seconds.shape, 7)


def _checked_tolerance(given: Real) -> float:
    tolerance = validation.positive(given, "tolerance")
    if not 1e-14 <= tolerance <= 1e-2:
        raise AttitudeError(
            f"tolerance is {tolerance!r}; give one from 1e-14 to 1e-2 (rad a step)."
        )
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
