"""Maneuvers of an Attitude Comprehensive Message, as impulses and torques."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from attitude import quaternion
from attitude.arcs.changes import Impulse
from attitude.axes import axes
from attitude.errors import AttitudeError
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from collections.abc import Mapping

    from attitude.annotations import FloatArray
    from attitude.epochs import Instant
    from attitude.history import AttitudeHistory


@dataclass(frozen=True, eq=False)
class Maneuver:
    """A maneuver: the torque is not in the message, but what it achieves.

    Attributes
    ----------
    begin, end : Instant
        The same if the message gives neither a duration nor an end.
    purpose : str
    target_momentum : (3,) array or None
        Angular momentum after the maneuver, kg m2/s, over the axes of `momentum_frame`.
    momentum_frame : str or None
        TARGET_MOM_FRAME.
    target_attitude : (4,) array or None
        Attitude after the maneuver, scalar first: the numbers of the message, whose frames are
        those of its attitudes.
    target_spin_rate : float or None
        rad/s.
    values : mapping
        All keywords of the block.
    comments : tuple of str
    """

    begin: Instant
    end: Instant
    purpose: str
    target_momentum: FloatArray | None
    momentum_frame: str | None
    target_attitude: FloatArray | None
    target_spin_rate: float | None
    values: Mapping[str, str] = field(repr=False)
    comments: tuple[str, ...] = field(repr=False)

    def _target(self) -> tuple[FloatArray, bool]:
        """The angular momentum to be reached, and whether it is over body axes; else over ICRF."""
        if self.target_momentum is None:
            raise AttitudeError(
                f"the maneuver {cut(self.purpose)} has no TARGET_MOMENTUM, from which an impulse "
                "or a torque would follow."
            )
        found = axes.known(self.momentum_frame or "")
        if found is None:
            if self.momentum_frame is None:
                raise AttitudeError(
                    f"the maneuver {cut(self.purpose)} has no TARGET_MOM_FRAME, the axes of its "
                    "TARGET_MOMENTUM; give the impulse yourself."
                )
            return self.target_momentum, True
        if found.turning:
            raise AttitudeError(
                f"TARGET_MOM_FRAME is {cut(found.name, '')}, axes that turn; they must be fixed, "
                "or the body's."
            )
        turn = found.to_icrf(self.begin, 0.0, None)
        return quaternion.rotate(turn, self.target_momentum), False

    def impulse(self) -> Impulse:
        """The maneuver as an Impulse in its middle, after which the momentum is the target.

        Raises
        ------
        AttitudeError
            Without a target momentum, or if its frame is unknown or turns.
        """
        target, of_body = self._target()

        def added(history: AttitudeHistory) -> FloatArray:
            momentum = history.motion.momentum_in_body(history)
            now = momentum if of_body else history.body_to_inertial(momentum)
            added_momentum: FloatArray = target - now.reshape(3)
            return added_momentum

        middle = self.begin.after(0.5 * self.end.since(self.begin))
        return Impulse(middle, added, "body" if of_body else "icrf")

    def mean_torque(self, momentum: FloatArray) -> FloatArray:
        """The mean torque (3,), N m, that leads from an angular momentum to the target.

        Parameters
        ----------
        momentum : (3,) array
            Before the maneuver, kg m2/s, over ICRF, or over body axes if the target is.

        Raises
        ------
        AttitudeError
            As `impulse`, and for a maneuver without a duration.
        """
        duration = self.end.since(self.begin)
        if not duration > 0.0:
            raise AttitudeError(
                f"the maneuver {cut(self.purpose)} has no duration, and an infinite torque; take "
                "impulse()."
            )
        torque: FloatArray = (self._target()[0] - momentum) / duration
        return torque
