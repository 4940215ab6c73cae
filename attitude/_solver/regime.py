"""The kind of motion of a state, its periods and ranges; on arrays of states.

With A <= B <= C the principal moments, L the angular momentum and E the energy, the dynamic inertia
D = L^2/2E decides about which axis the momentum circulates in the body: the long axis (that of A)
for D < B, the short axis (that of C) for D > B.  Two labellings of the axes are in use; `Regime`
has both.  "L": the Euler angle phi is that of the long axis about the momentum, "S": of the short
axis.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import codes
from attitude._support import validation
from attitude._support.arrays import Immutable, frozen, read_only
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._solver.states import Evaluation, States
    from attitude._support.annotations import FloatArray, Reals


class Mode(IntEnum):
    """The kinds of free rotation, in the order in which they are tested.

    A mode is exact for the doubles given: a body is SYMMETRIC when two of its moments are the same
    number.  `FreeRotation.within_rounding` lists the modes that hold within rounding of the input.
    """

    AT_REST = codes.AT_REST
    SPHERICAL = codes.SPHERICAL
    PRINCIPAL_AXIS = codes.PRINCIPAL_AXIS
    SEPARATRIX = codes.SEPARATRIX
    SYMMETRIC = codes.SYMMETRIC
    LONG_AXIS = codes.LONG_AXIS
    SHORT_AXIS = codes.SHORT_AXIS

    @property
    def phrase(self) -> str:
        """The mode in words."""
        return _PHRASES[self]


_PHRASES = {
    Mode.AT_REST: "at rest",
    Mode.SPHERICAL: "uniform rotation of a body with three equal moments",
    Mode.PRINCIPAL_AXIS: "uniform rotation about a principal axis",
    Mode.SEPARATRIX: "on the separatrix, between long-axis and short-axis mode",
    Mode.SYMMETRIC: "regular precession of a symmetric body",
    Mode.LONG_AXIS: "long-axis mode (LAM): the momentum circulates about the axis of least inertia",
    Mode.SHORT_AXIS: (
        "short-axis mode (SAM): the momentum circulates about the axis of greatest inertia"
    ),
}


def known_convention(convention: str) -> str:
    """The labelling "L" or "S" in capitals."""
    capital = convention.upper() if isinstance(convention, str) else None
    if capital in ("L", "S"):
        return capital
    raise AttitudeError(
        f'convention is {convention!r}; give "L" where phi is the angle of the long axis about '
        'the momentum, "S" where it is that of the short axis.'
    )


# Type checkers take each of these properties for an attribute of the type returned here.


def _number_of(name: str, meaning: str) -> Any:
    """The property of a field (S,) of the rows: a float for one state."""
    return property(lambda self: self._number(name), doc=meaning)


def _period_of(name: str, meaning: str) -> Any:
    """The property of the period, s, of a rate in turns per second."""
    return property(lambda self: period_of(self._rows[name]), doc=meaning)


def _range_of(name: str, meaning: str) -> FloatArray:
    """The property of a field (S, 2) of the rows: the least and the greatest value."""
    accessor: Any = property(lambda self: self._rows[name], doc=meaning)
    return accessor


class Regime(Immutable):
    """Periods, ranges and times of the motions of states of shape S; made by `regimes`.

    All attributes have shape S (a float for one state); ranges have shape (S, 2), the least and the
    greatest value.  Periods of what does not move are inf; at rest, angles to the momentum and
    quotients by it are NaN.

    Notes
    -----
    Relative error at most 1e-15 for the doubles given, near every limit, except where these
    doubles leave the number open: one unit in the last place of an input changes 1 - m by 2e-16, so
    that P_psi near the separatrix is that of the exact input.  Sources: van Zon & Schofield (2006),
    eqs. 3.32-3.48; Samarasinha & A'Hearn, Icarus 93, 194 (1991), for the two labellings.
    """

    _rows: NDArray[Any]
    _mean: FloatArray

    def __init__(self, rows: NDArray[Any]) -> None:
        self._set("_rows", frozen(rows))

    def _number(self, name: str) -> Any:
        value = self._rows[name]
        return value.item() if value.ndim == 0 else value

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape S of the states, () for one."""
        return self._rows.shape

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: Any) -> Regime:
        return Regime(np.array(self._rows[index]))

    @property
    def mode(self) -> Any:
        """Codes of `Mode`, or a Mode for one state."""
        code = self._number("mode")
        return Mode(code) if self.shape == () else code

    circulates = _number_of(
        "circulates",
        "1 where the momentum circulates about the short axis, -1 about the long one, 0 neither.",
    )
    energy_ratio = _number_of(
        "energy_ratio",
        "2 E C / L^2, observers' E/E0: 1 for rotation about the short axis, C/B on the separatrix, "
        "C/A for rotation about the long axis.",
    )
    dynamic_inertia = _number_of("dynamic_inertia", "D = L^2 / 2E, in the unit of the moments.")
    m = _number_of(
        "m",
        "Parameter of the elliptic functions.  For a uniform rotation the limit: 0, and 1 about "
        "the middle axis.",
    )
    one_minus_m = _number_of("mc", "1 - m, with all its digits.")
    libration = _number_of(
        "libration",
        "Amplitude, rad, of psi in the labelling in which it librates: about 0 or 180 deg with "
        '"L" in short-axis mode, about 90 or 270 deg with "S" in long-axis mode.',
    )
    spin_rate = _number_of("speed", "Magnitude of the angular velocity at the epoch, rad/s.")
    spin_rate_along = _number_of(
        "speed_along",
        "Component of the angular velocity along the momentum, 2 E / L, rad/s: constant.",
    )
    flip_time = _number_of(
        "flip",
        "pi / wp, s: the time in which the middle axis would turn over at its greatest rate.  "
        "Half of P_psi is flip_time + dwell_time.",
    )
    dwell_time = _number_of(
        "dwell",
        "Half of P_psi less flip_time, s, spent with the middle axis near the momentum.  On the "
        "separatrix it is inf, and the departure from the middle axis grows e-fold in "
        "flip_time / pi.",
    )

    P_psi = _period_of(
        "psi_rate",
        "Period, s, of psi, the angle about the axis that the momentum circulates about.",
    )
    P_phi_L = _period_of("phi_rate_long", "Mean period, s, of the long axis about the momentum.")
    P_phi_S = _period_of(
        "phi_rate_short",
        "Mean period, s, of the short axis about the momentum: 1/P_phi_S = 1/P_phi_L + 1/P_psi.",
    )

    nutation_L = _range_of(
        "nutation_long",
        "Range (S, 2), rad, of the angle between the long axis and the momentum.  If the momentum "
        "circulates about this axis, the end of the axis nearer to it.",
    )
    nutation_S = _range_of(
        "nutation_short",
        "Range (S, 2), rad, of the angle between the short axis and the momentum.  If the momentum "
        "circulates about this axis, the end of the axis nearer to it.",
    )
    precession_rate_L = _range_of(
        "precession_long", "Range (S, 2), rad/s, of d phi/dt of the long axis."
    )
    precession_rate_S = _range_of(
        "precession_short", "Range (S, 2), rad/s, of d phi/dt of the short axis."
    )

    def P_phi(self, convention: str) -> Any:
        """Mean period of phi, s, in the labelling "L" or "S"."""
        return self.P_phi_L if known_convention(convention) == "L" else self.P_phi_S

    def nutation(self, convention: str) -> FloatArray:
        """Range (S, 2), rad, of the angle of the axis of a labelling to the momentum."""
        return self.nutation_L if known_convention(convention) == "L" else self.nutation_S

    def precession_rate(self, convention: str) -> FloatArray:
        """Range (S, 2), rad/s, of d phi/dt in the labelling "L" or "S"."""
        if known_convention(convention) == "L":
            return self.precession_rate_L
        return self.precession_rate_S

    @property
    def spin_rate_range(self) -> FloatArray:
        """Range (S, 2), rad/s, of the magnitude of the angular velocity."""
        return frozen(np.sort(self._rows["speed_at"], axis=-1))

    @property
    def mean_spin_rate(self) -> Any:
        """Average over time, rad/s, of the magnitude of the angular velocity."""
        if "_mean" not in self.__dict__:
            from attitude._solver.regime_loops import mean_speeds

            mean = np.empty(self._rows.size)
            mean_speeds(self._rows.reshape(-1), mean)
            self._set("_mean", frozen(mean.reshape(self.shape)))
        return self._mean.item() if self.shape == () else self._mean

    def __repr__(self) -> str:
        if self.shape == ():
            return (
                f"<Regime: {self.mode.name}, E/E0 {self.energy_ratio:.6g}, P_psi {self.P_psi:.6g} "
                f"s, P_phi {self.P_phi_L:.6g} s (L), {self.P_phi_S:.6g} s (S)>"
            )
        return f"<Regime of {self._rows.size} states>"


def regimes(moments: Reals, omega: Reals) -> Regime:
    """The `Regime` of many states: modes, periods, ranges.

    Parameters
    ----------
    moments : (..., 3) array_like
        Principal moments of inertia, any unit, any order.
    omega : (..., 3) array_like
        Angular velocity over the principal axes, rad/s.

    Raises
    ------
    AttitudeError
        For the first state that is not physical, and for no states.

    >>> found = regimes((10, 20, 26), [(1, 15, 1), (9, 2, 1)])
    >>> found.P_psi.round(6), found.P_phi_L.round(6), found.P_phi_S.round(6)
    (array([2.347113, 1.253201]), array([0.439469, 1.383953]), array([0.370161, 0.657668]))
    """
    from attitude._solver.states import States

    moments, omega, lead = _states(moments, omega)
    if not len(moments):
        raise AttitudeError("moments and omega hold no state; give at least one.")
    states = States.of_principal_axes(moments, omega)
    rows, _ = summary(_evaluation(states), len(states))
    return Regime(rows.reshape(lead))


def regime_of(moments: FloatArray, constants: NDArray[Any]) -> Regime:
    """The Regime of one motion, from its moments (1, 3, 2), pairs, and its constants (1,)."""
    from attitude._solver.regime_loops import REGIME

    rows = np.zeros(1, REGIME)
    _fill(moments, constants, rows)
    return Regime(rows.reshape(()))


def summary(states: Evaluation, count: int) -> tuple[NDArray[Any], FloatArray]:
    """Rows (N,) of the regimes of states, and turns per second (2, N) of psi and phi.

    States that are not physical, unless they are refused, have NaN and the mode NO_MODE.
    """
    from attitude._solver.regime_loops import REGIME
    from attitude._solver.states import BLOCK, NO_MODE

    rows, rates = np.zeros(count, REGIME), np.empty((2, count))
    for first in range(0, count, BLOCK):
        block = slice(first, min(first + BLOCK, count))
        solved = states.prepared(range(block.start, block.stop))
        rates[:, block] = solved.constants["psi_rate"], solved.constants["phi_rate"]
        some = rows[block]
        _fill(solved.moments, solved.constants, some)
        if len(solved.bad):
            for name in REGIME.names or ():
                some[name][solved.bad] = NO_MODE if REGIME[name].kind == "i" else np.nan
    return rows, rates


def _fill(moments, constants, rows):
    """Fill rows (B,) of `regimes.REGIME` from moments (B, 3, 2), pairs, and constants (B,)."""
    from attitude._solver.regime_loops import regimes_all

    # A motion keeps read-only arrays: one type of array for all.
    regimes_all(read_only(moments), read_only(constants), rows)


def _evaluation(states: States) -> Evaluation:
    from attitude._solver.states import Evaluation

    count = len(states)
    return Evaluation(states, lambda k: f"State {k} of {count}" if count > 1 else "")


def _states(moments: Reals, omega: Reals) -> tuple[FloatArray, FloatArray, tuple[int, ...]]:
    """Moments and rates as (N, 3) doubles, and their leading shape."""
    moments = validation.rows(moments, "moments", 3)
    omega = validation.rows(omega, "omega", 3, unit="rad/s")
    lead = validation.together(moments=moments[..., 0], omega=omega[..., 0])[0].shape
    both = (np.broadcast_to(vectors, (*lead, 3)).reshape(-1, 3) for vectors in (moments, omega))
    moments, omega = (np.ascontiguousarray(vectors) for vectors in both)
    return moments, omega, lead


def period_of(rate: Any) -> Any:
    """The period, s, of a rate in turns per second: inf for 0, a float for one state."""
    with np.errstate(divide="ignore"):
        value = 1.0 / np.abs(rate)
    return float(value) if np.ndim(value) == 0 else frozen(value)
