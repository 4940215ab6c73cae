"""Attitudes of the members of an ensemble at epochs."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from attitude import epochs, pairs
from attitude.errors import AttitudeError
from attitude.history import AttitudeHistory
from attitude.immutable import frozen

if TYPE_CHECKING:
    from astropy.table import QTable
    from astropy.time import Time

    from attitude.annotations import FloatArray, IntArray
    from attitude.ensemble.ensemble import Ensemble


class EnsembleHistory(AttitudeHistory):
    """The rotation of members of an ensemble, each at epochs of its own or at shared ones.

    Made by ``ensemble.at(t)``, of shape S = (N, T), or ``ensemble.at(t, member=index)``, of the
    shape S of the index.  It has all attributes and methods of `AttitudeHistory`.

    Attributes
    ----------
    ensemble : Ensemble
    member : (S) array of int
        The number of the member of each attitude.
    wxyz, xyzw : (S, 4) arrays
        Body to ICRF, scalar first or last; continuous in sign along the motion of a member.
    seconds, low : arrays of shape S (low may be None)
        TDB seconds since the epoch of the member: seconds + low.
    epoch : Instant
        The epoch of the ensemble, or J2000 if the members have epochs of their own.
    """

    ensemble: Ensemble
    member: IntArray

    def __init__(
        self,
        ensemble: Ensemble,
        member: IntArray,
        seconds: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
    ) -> None:
        super().__init__(ensemble, ensemble.start_of_seconds, seconds, low, wxyz)
        self._set("ensemble", ensemble)
        self._set("member", frozen(member))

    def __getitem__(self, index: Any) -> EnsembleHistory:
        """Some of the attitudes: history[3], history[:, 10:20], history[mask]."""
        part = super().__getitem__(index)
        member = np.asarray(self.member[index])
        found = EnsembleHistory(self.ensemble, member, part.seconds, part.low, part.wxyz)
        if "angular_velocity" in part.__dict__:
            found.__dict__["angular_velocity"] = part.angular_velocity
        return found

    def __repr__(self) -> str:
        size, members = self.seconds.size, len(self.ensemble)
        return f"<EnsembleHistory of {size} attitudes of an ensemble of {members}>"

    @cached_property
    def angular_velocity(self) -> FloatArray:
        """(S, 3) rad/s over the body axes."""
        return frozen(self.ensemble.evaluated(self.member, self.seconds, self.low))

    @cached_property
    def sensitivity(self) -> FloatArray:
        """(S, 3, 9) derivatives of the attitudes; see `Ensemble.sensitivity_at`."""
        found = self.ensemble.sensitivity_at(self.seconds, self.member, low=self.low)
        return frozen(cast("FloatArray", found))

    @cached_property
    def angular_acceleration(self) -> FloatArray:
        """(S, 3) rad/s2 over the body axes, by Euler's equations of the bodies at the epoch."""
        moments, axes = self.ensemble.principal_moments, self.ensemble.principal_axes
        which = self.member if len(moments) > 1 else np.zeros_like(self.member)
        given, turn = moments[which], axes[which]
        w = np.einsum("...ij,...i->...j", turn, self.angular_velocity)
        rate = np.zeros(w.shape)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            torque = (given[..., j] - given[..., k]) * w[..., j] * w[..., k]
            heavy = given[..., i] > 0.0
            rate[..., i] = np.where(heavy, torque / np.where(heavy, given[..., i], 1.0), 0.0)
        return frozen(np.einsum("...ij,...j->...i", turn, rate))

    @cached_property
    def time(self) -> Time:
        """The epochs (S) as an astropy Time in TDB, rounded to 5e-12 s; NaN epochs are masked."""
        if self.ensemble.epoch is not None:
            return epochs.times(self.epoch, self.seconds, self.low)
        start = self.ensemble.epochs_of(self.member)
        low = 0.0 if self.low is None else self.low
        return epochs.times(self.epoch, *pairs.add(start, self.seconds, low))

    def table(self, *, rates: bool = True, sigma: bool = False) -> QTable:
        """As `AttitudeHistory.table`, one row for each attitude, with columns member and name.

        Raises
        ------
        AttitudeError
            For standard deviations, which an ensemble does not have.
        """
        if sigma:
            raise AttitudeError("an ensemble has no standard deviations; leave out sigma=True.")
        flat = self if len(self.shape) == 1 else self._flattened()
        found = super(EnsembleHistory, flat).table(rates=rates)
        found.add_column(np.array(flat.member), index=0, name="member")
        if self.ensemble.names is not None:
            found.add_column(self.ensemble.names[flat.member], index=1, name="name")
        if self.ensemble.epoch is None:
            del found.meta["epoch"]
        return found

    def _flattened(self) -> EnsembleHistory:
        low = None if self.low is None else np.ravel(self.low)
        wxyz = self.wxyz.reshape(-1, 4)
        given = np.ravel(self.member), np.ravel(self.seconds), low
        return EnsembleHistory(self.ensemble, *given, wxyz)
