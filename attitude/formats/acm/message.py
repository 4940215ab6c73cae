"""The content of an Attitude Comprehensive Message."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.arcs import Arcs
from attitude.attitude_table.table import AttitudeTable
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.spin import Spin
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body
    from attitude.epochs import Instant
    from attitude.formats.acm.maneuvers import Maneuver


@dataclass(frozen=True, eq=False)
class AttitudeCovariance:
    """Variances of the attitude at epochs; the message holds no correlations.

    Attributes
    ----------
    epoch : Instant
    seconds, low : (N,) arrays
        seconds + low are TDB seconds since the epoch.
    kind : str
        COV_TYPE.
    variances : (N, columns) array
        rad2 of angles, pure numbers of quaternions (Q1, Q2, Q3, QC), rad2/s2 of angular velocities
        and biases of gyroscopes.
    frame : str or None
        COV_REF_FRAME: the axes of the angles and rates.
    meta : dict
        Keywords and comments of the block.
    """

    epoch: Instant
    seconds: FloatArray
    low: FloatArray
    kind: str
    variances: FloatArray
    frame: str | None
    meta: dict[str, Any] = field(repr=False)

    @property
    def matrix(self) -> FloatArray:
        """(N, columns, columns): the variances as diagonal matrices."""
        return self.variances[:, :, None] * np.eye(self.variances.shape[1])

    def in_icrf(self, table: AttitudeTable) -> FloatArray:
        """(N, 3, 3) rad2, covariance of the rotation vector over ICRF axes.

        Parameters
        ----------
        table : AttitudeTable
            The attitudes, of the body in whose axes the variances are.

        Raises
        ------
        AttitudeError
            For variances of quaternions or in the axes of another body, and for epochs at which
            the table has no attitude.
        """
        body = table.meta["body_frame"]
        if not self.kind.startswith("ANGLE"):
            raise AttitudeError(
                f"COV_TYPE is {self.kind}, whose variances are no covariance of a rotation; it "
                "must be one of ANGLE, ANGLE_GYROBIAS, ANGLE_ANGVEL."
            )
        if self.frame is not None and self.frame.upper() != body.upper():
            raise AttitudeError(
                f"COV_REF_FRAME is {cut(self.frame, '')}, and the attitudes are those of "
                f"{cut(body, '')}; the variances cannot be turned to ICRF."
            )
        shift = self.epoch.since(table.epoch)
        matrix = table.at(self.seconds + shift, self.low).matrix
        turned: FloatArray = matrix * self.variances[:, None, :3] @ np.swapaxes(matrix, -1, -2)
        return turned


@dataclass(frozen=True, eq=False)
class Comprehensive:
    """The content of an ACM.

    Attributes
    ----------
    epoch : Instant
        EPOCH_TZERO.
    tables : tuple of AttitudeTable
        One for each block of attitudes; `meta` has its keywords, and under "gyro_bias" (N, 3)
        rad/s the biases of gyroscopes.
    covariances : tuple of AttitudeCovariance
    body : Body or None
        Over the axes that INERTIA_REF_FRAME names (``meta["inertia_frame"]``).
    maneuvers : tuple of Maneuver
    meta : dict
        Header, meta data, comments, and the blocks PHYS, AD and USER as text.
    """

    epoch: Instant
    tables: tuple[AttitudeTable, ...]
    covariances: tuple[AttitudeCovariance, ...]
    body: Body | None
    maneuvers: tuple[Maneuver, ...]
    meta: dict[str, Any] = field(repr=False)

    @property
    def table(self) -> AttitudeTable:
        """The attitudes as one table; AttitudeError for none, or those of several bodies."""
        if not self.tables:
            raise AttitudeError("the message has no attitudes.")
        frames = list(dict.fromkeys(each.meta["body_frame"].upper() for each in self.tables))
        if len(frames) > 1:
            raise AttitudeError(
                f"the blocks of attitudes are those of {', '.join(frames)[:120]}; choose one of "
                "`tables` (in files of any format: segment=, on the command line --segment)."
            )
        return AttitudeTable.joined(self.tables)

    @property
    def motion(self) -> FreeRotation | Arcs:
        """The motion from the first attitude with an angular velocity, with maneuvers as impulses.

        Raises
        ------
        AttitudeError
            Without inertia or angular velocities, for an inertia over other axes, and as
            `Maneuver.impulse`.
        """
        rated = [each for each in self.tables if each.angular_velocity is not None]
        if self.body is None or not rated:
            lacking = "inertia" if self.body is None else "attitude with an angular velocity"
            raise AttitudeError(f"the message has no {lacking}, from which a motion would follow.")
        first, inertia = rated[0], self.meta["inertia_frame"]
        if inertia is not None and inertia.upper() != first.meta["body_frame"].upper():
            raise AttitudeError(
                f"the inertia is over the axes {cut(inertia, '')}, but the attitudes are those of "
                f"{cut(first.meta['body_frame'], '')}; give a Body over these axes."
            )
        assert first.angular_velocity is not None
        spin = Spin(
            first.epoch.after(first.seconds[0], first.low[0]),
            first.wxyz[0],
            first.angular_velocity[0],
        )
        later = [each for each in self.maneuvers if each.begin.since(spin.epoch) >= 0.0]
        if not later:
            return FreeRotation(self.body, spin)
        return Arcs(self.body, spin, [each.impulse() for each in later])
