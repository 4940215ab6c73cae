"""Modes, periods, ranges and invariants of the members of an ensemble, as arrays."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import quaternion, regime
from attitude.ensemble.collection import Collection
from attitude.ensemble.members import BLOCK, NO_MODE
from attitude.immutable import frozen
from attitude.regime import Regime

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray


class Described(Collection):
    """Base of `Ensemble`: what follows from the constants of the members.

    Arrays are computed for all members at the first use of any of them, in 0.7 us a member.
    """

    @cached_property
    def _summary(self) -> tuple[NDArray[Any], FloatArray]:
        """Rows (N,) of the regimes, and turns per second (2, N) of psi and phi."""
        rows, rates = None, np.empty((2, len(self)))
        for first in range(0, max(len(self), 1), BLOCK):
            part = slice(first, min(first + BLOCK, len(self)))
            constants, bad = self._members.prepared(part)
            rates[:, part] = constants["psi_rate"], constants["phi_rate"]
            found = regime.rows_of(self._members.states(part)[0], constants)
            for name in found.dtype.names or ():
                found[name][bad] = NO_MODE if found.dtype[name].kind == "i" else np.nan
            rows = np.empty(len(self), found.dtype) if rows is None else rows
            rows[part] = found
        assert rows is not None
        return rows, rates

    @cached_property
    def regime(self) -> Regime:
        """The `Regime` (N,) of the members: periods, ranges and times in both conventions."""
        return Regime(self._summary[0].copy())

    @property
    def mode(self) -> NDArray[np.int64]:
        """(N,) codes of `Mode`; -1 for a member that is not physical."""
        found: NDArray[np.int64] = self.regime.mode
        return found

    @cached_property
    def period_psi(self) -> FloatArray:
        """(N,) periods, s, of the rotation about the axis about which the momentum circulates."""
        return _periods(self._summary[1][0])

    @cached_property
    def period_phi(self) -> FloatArray:
        """(N,) mean periods, s, of the axis of `period_psi` about the momentum."""
        return _periods(self._summary[1][1])

    @property
    def energy_ratio(self) -> FloatArray:
        """(N,) E/E0 = 2 E C / L^2: 1 for rotation about the short axis, NaN at rest."""
        found: FloatArray = self.regime.energy_ratio
        return found

    def nutation(self, convention: str) -> FloatArray:
        """Ranges (N, 2), rad, of the angle of the long ("L") or short axis to the momentum."""
        return self.regime.nutation(convention)

    @property
    def wxyz_icrf(self) -> FloatArray:
        """(N, 4) attitudes at the epochs of the members, body to ICRF, scalar first."""
        return self._members.wxyz

    @property
    def principal_moments(self) -> FloatArray:
        """(1 or N, 3) principal moments, kg m2 or relative, as `Body.moments`."""
        return self._inertia.moments[..., 0]

    @property
    def principal_axes(self) -> FloatArray:
        """(1 or N, 3, 3) principal axes in body axes, as columns."""
        return self._inertia.axes

    @property
    def relative(self) -> bool:
        """Whether the unit of the moments is unknown."""
        return self._inertia.relative

    @cached_property
    def momentum(self) -> FloatArray:
        """(N, 3) angular momenta in ICRF, kg m2/s, or rad/s times the relative unit of inertia."""
        if self._inertia.has_tensors:
            tensors = self._inertia.tensors()
            in_body = np.einsum("...ij,...j->...i", tensors, self.angular_velocity)
        else:
            in_body = self._inertia.given * self.angular_velocity
        return frozen(np.ascontiguousarray(quaternion.rotate(self.wxyz_icrf, in_body)))

    @cached_property
    def energy(self) -> FloatArray:
        """(N,) kinetic energies, J, or rad2/s2 times the relative unit of inertia."""
        rates = self._members.rates
        rates = rates if rates.ndim == 2 else rates[..., 0]
        return frozen(0.5 * np.sum(self.principal_moments * rates**2, axis=-1))


def _periods(rates: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore"):
        return frozen(np.abs(1.0 / rates))
