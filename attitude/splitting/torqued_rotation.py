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

import threading
from dataclasses import dataclass, field

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.motion import Motion
from attitude.spin import Spin
from attitude.splitting.schemes import scheme
from attitude.splitting.steps import FixedSteps, System, VaryingSteps
from attitude.torques.torque import Torque


@dataclass(frozen=True, eq=False, repr=False)
class TorquedRotation(Motion):
    """Rotation of a rigid body under torques, by a splitting scheme around exact free motion.

    Parameters
    ----------
    body : Body
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
        Instead of `step`: rad of attitude, and relative change of the angular velocity, that a
        step may err by.  The steps then vary with the motion: right for one encounter, not
        symplectic over many.

    Raises
    ------
    AttitudeError
        For a step that cannot resolve the rotation, a torque that is not finite or of another
        shape, a path that does not cover the epochs asked for.

    Notes
    -----
    Between steps, the motion is that of a shorter last step: the order of the scheme holds at
    every epoch, and the answer is continuous.  States are integrated when they are first asked
    for, and every 32nd is kept, every 64th once there are 131,072 and so on: asking again, in any
    order, starts from the nearest, and 1e8 steps want no more memory (15 MB) than 4e6.  Paths are
    asked in two doubles of time.  Free motion errs by rounding times the angle turned
    (solution/step.py), summed with compensation and without a mean: the energy walks at random
    by 2e-14 in 1e8 steps of 0.08 rad.

    "force-gradient" takes any number of `GravityGradient`, `ConstantTorque`, and `CustomTorque`
    that tell their slope; other torques do not, and are refused by name.

    Source: van Zon & Schofield, Phys. Rev. E 75, 056701 (2007), cond-mat/0612404; van Zon,
    Omelyan & Schofield, J. Chem. Phys. 128, 136102 (2008).
    """

    body: Body = field()
    spin: Spin = field()
    torques: tuple = field()
    step: float = None
    scheme: object = "kick-rotate-kick"
    tolerance: float = None

    smooth = True

    def __post_init__(self):
        if not isinstance(self.body, Body) or not isinstance(self.spin, Spin):
            raise AttitudeError(
                "TorquedRotation takes a Body, a Spin and torques; given were "
                f"{type(self.body).__name__} and {type(self.spin).__name__}."
            )
        self._set("torques", _torques(self.torques))
        self._set("scheme", scheme(self.scheme))
        if (self.step is None) == (self.tolerance is None):
            raise AttitudeError("a TorquedRotation takes either step=(s) or tolerance=(rad).")
        self._set("_system", System(self.body, self.spin, self.torques, self.scheme))
        self._set("_lock", threading.Lock())
        if self.step is not None:
            self._set("step", validation.positive(self.step, "step", unit="s"))
            self._system.check_step(self.step)
            grids = tuple(FixedSteps(self._system, s * self.step) for s in (1.0, -1.0))
        else:
            self._set("tolerance", validation.positive(self.tolerance, "tolerance"))
            if not 1e-14 <= self.tolerance <= 1e-2:
                raise AttitudeError(
                    f"tolerance is {self.tolerance!r}; give one from 1e-14 to 1e-2 (rad a step)."
                )
            grids = tuple(VaryingSteps(self._system, s, self.tolerance) for s in (1.0, -1.0))
        self._set("_grids", grids)

    def __reduce__(self):
        return TorquedRotation, tuple(getattr(self, name) for name in self.__dataclass_fields__)

    def __repr__(self):
        how = f"step {self.step:g} s" if self.tolerance is None else f"to {self.tolerance:g}"
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<TorquedRotation: {names}; {self.scheme.name}, {how}>"

    @property
    def epoch(self):
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    @property
    def steps_taken(self):
        """(first, last) seconds since the epoch between which states have been integrated."""
        ahead, behind = (grid.reached for grid in self._grids)
        return behind, ahead

    def _evaluate(self, seconds, low, order):
        # Attitudes and angular velocities are integrated together.
        states = self._states(seconds, low)
        found = [np.ascontiguousarray(part) for part in (states[..., :4], states[..., 4:])]
        if order > 1:
            found.append(self._system.acceleration(seconds, low, states))
        return found

    def _states(self, seconds, low):
        """(..., 7): wxyz body to ICRF, angular velocity over body axes."""
        flat = seconds.reshape(-1)
        rest = np.zeros(flat.size) if low is None else np.asarray(low).reshape(-1)
        out = np.full((flat.size, 7), np.nan)
        with np.errstate(invalid="ignore", over="ignore"):  # what comes out is refused, or NaN
            total = flat + rest
        if np.any(np.isinf(total)):
            raise AttitudeError("an epoch is infinite; give finite epochs, or NaN for none.")
        with self._lock:
            for grid, here in zip(self._grids, (total >= 0.0, total < 0.0), strict=True):
                if np.any(here):
                    out[here] = grid.states(flat[here], rest[here])
        return self._system.over_body_axes(out).reshape(*seconds.shape, 7)


def _torques(given):
    if isinstance(given, Torque) or callable(given):
        given = (given,)
    found = []
    for torque in given:
        if not isinstance(torque, Torque):
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
