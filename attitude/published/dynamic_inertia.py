"""The dynamic inertia D = L^2/2E from two periods, or from the energy, in a mode and a convention.

D is given by its position, the pair (y, 1 - y), both to full precision: y is 0 at the middle
moment, which is the separatrix, and 1 at the moment of the axis about which the momentum
circulates.  P_psi / P_phi decreases with y, from infinity to a limit, so that there is one
position or none.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.regime import Mode, known_convention

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from attitude.annotations import BoolArray, FloatArray, Real

_MODES: dict[str | Mode, str] = {
    "LAM": "LAM",
    "SAM": "SAM",
    Mode.LONG_AXIS: "LAM",
    Mode.SHORT_AXIS: "SAM",
}
_ROUNDING = 1e-14


def known_mode(mode: str | Mode | None) -> str:
    """The mode as "LAM" or "SAM"; AttitudeError for any other mode or text."""
    given = mode.upper() if isinstance(mode, str) else mode
    if given in _MODES:
        return _MODES[given]
    raise AttitudeError(
        f'mode is {mode!r}; give "LAM" (long-axis mode) or "SAM" (short-axis mode), or Mode.'
        "LONG_AXIS or Mode.SHORT_AXIS. The mode is required: in the other mode the same two "
        "periods belong to another state."
    )


def possible(moments: ArrayLike, P_psi: float, P_phi: float) -> list[tuple[str, str]]:
    """The combinations of mode and convention in which a motion has these periods.

    Parameters
    ----------
    moments : (3,) array_like
        Principal moments, ascending; of any unit, or relative.
    P_psi, P_phi : float
        In one unit.

    Returns
    -------
    list of (mode, convention)

    >>> possible((0.61, 0.965, 1.0), 263.0, 27.38)
    [('LAM', 'L'), ('LAM', 'S'), ('SAM', 'L'), ('SAM', 'S')]
    """
    found = []
    for mode in ("LAM", "SAM"):
        for convention in ("L", "S"):
            if _exists(moments, mode):
                ratio = P_psi / P_phi - (convention == "S")
                if not math.isnan(_solved(moments, mode, ratio)[0]):
                    found.append((mode, convention))
    return found


def longest_P_phi(moments: ArrayLike, mode: str | Mode, convention: str, P_psi: float) -> float:
    """The longest mean P_phi of motions with a given P_psi, in the unit of P_psi.

    It is the limit of rotation about the axis; every shorter P_phi is possible, the shorter the
    nearer to the separatrix.
    """
    turns, _ = cycle(moments, known_mode(mode), (1.0, 0.0))
    return P_psi / (turns + (known_convention(convention) == "S"))


def moments_from_ratios(A_over_C: Real, B_over_C: Real) -> FloatArray:
    """Relative moments (A, B, C = 1) from published ratios; AttitudeError if no body has them.

    >>> moments_from_ratios(0.61, 0.965)
    array([0.61 , 0.965, 1.   ])
    """
    a, b = validation.number(A_over_C, "A_over_C"), validation.number(B_over_C, "B_over_C")
    if not 0.0 < a <= b <= 1.0:
        raise AttitudeError(
            f"A/C is {a:.9g} and B/C is {b:.9g}; moments in the order A <= B <= C have 0 < A/C <= "
            "B/C <= 1. Check which axis is which."
        )
    if a + b < 1.0:
        raise AttitudeError(
            f"A/C is {a:.9g} and B/C is {b:.9g}; no body has a moment that exceeds the sum of the "
            f"other two: A/C must be at least {1.0 - b:.9g} for this B/C."
        )
    return np.array([a, b, 1.0])


def _exists(moments, mode):
    """Whether bodies with these moments, ascending, have motions in a mode."""
    a, b, c = moments
    return a > 0.0 and (b > a if mode == "LAM" else c > b)


def refuse_missing_mode(moments: FloatArray, mode: str) -> None:
    """AttitudeError if a body with these moments (3,), ascending, has no motion in the mode."""
    if not _exists(moments, mode):
        listed = ", ".join(f"{each:.9g}" for each in moments)
        why = "the least is zero" if moments[0] == 0.0 else (
            "the least two are equal" if mode == "LAM" else "the greatest two are equal"
        )  # fmt: skip
        raise AttitudeError(
            f"a body with the moments {listed} has no {mode}: {why}. "
            + ("Give another mode." if moments[2] > moments[0] > 0.0 else "Give rates instead.")
        )


def places(moments: FloatArray, long_axis: BoolArray, ratios: FloatArray) -> FloatArray:
    """Positions y, 1 - y and P_psi for a momentum of 1, (N, 3), of given P_psi / P_phi_L.

    Moments (N, 3), ascending; long_axis and ratios (N,).  NaN where no motion has the ratio.
    """
    from attitude.solution.place_of_d import positions_all

    out = np.empty((len(ratios), 3))
    positions_all(moments, long_axis, ratios, out)
    return out


def _solved(moments: ArrayLike, mode: str, ratio: float) -> FloatArray:
    """The position (3,) of `places` of one body, in a mode."""
    given = np.array([moments], dtype=float), np.array([mode == "LAM"])
    place: FloatArray = places(*given, np.array([ratio], dtype=float))[0]
    return place


def cycle(moments: ArrayLike, mode: str, position: Sequence[float]) -> FloatArray:
    """P_psi / P_phi_L of a position (y, 1 - y), and P_psi for a momentum of 1.

    Moments (3,), ascending; mode "LAM" or "SAM".
    """
    from attitude.solution.place_of_d import cycles_all

    out = np.empty((1, 2))
    y, rest = (np.array([each], dtype=float) for each in position)
    cycles_all(np.array([moments], dtype=float), np.array([mode == "LAM"]), y, rest, out)
    return out[0]


def from_periods(
    moments: FloatArray, mode: str, convention: str, P_psi: float, P_phi: float
) -> FloatArray:
    """The position (y, 1 - y) of two periods, and P_psi for a momentum of 1.

    Parameters
    ----------
    moments : (3,) array
        Ascending.
    mode : "LAM" or "SAM"
    convention : "L" or "S"
    P_psi, P_phi : float
        s

    Raises
    ------
    AttitudeError
        If no motion has them; the text has the range of P_phi, and the combinations of mode and
        convention in which a motion exists.
    """
    ratio = P_psi / P_phi - (convention == "S")
    found = _solved(moments, mode, ratio)
    if not math.isnan(found[0]):
        return found
    longest = longest_P_phi(moments, mode, convention, P_psi)
    if P_phi <= longest:
        raise AttitudeError(
            f"P_psi is {P_psi / P_phi:.6g} times P_phi; such a motion is nearer to the separatrix "
            "than double precision resolves. Give rates instead."
        )
    others = possible(moments, P_psi, P_phi)
    listed = ", ".join(f"{each} with {labels}" for each, labels in others)
    raise AttitudeError(
        f"P_phi is {P_phi:.9g} s and P_psi is {P_psi:.9g} s; with these moments in {mode}, "
        f'convention "{convention}", P_phi can be {longest:.9g} s at the most for this P_psi. '
        + (
            f"A motion with these periods exists in: {listed}."
            if others
            else "No other mode or convention has a motion with these periods: check the moments."
        )
    )


def from_energy(
    moments: FloatArray, energy_ratio: Real, mode: str | Mode | None = None
) -> tuple[str, tuple[float, float]]:
    """Mode and position (y, 1 - y) for E/E0 = 2 E C / L^2; moments (3,), ascending.

    Raises
    ------
    AttitudeError
        For an energy that no motion has, or none in the given mode; the text has the range that is
        possible.
    """
    a, b, c = moments
    ratio = validation.number(energy_ratio, "energy_ratio")
    if a == 0.0 or a == c:
        raise AttitudeError(
            "the energy does not determine the motion of a sphere or of a rod; give rates instead."
        )
    if not 1.0 <= ratio <= c / a * (1.0 + _ROUNDING):
        raise AttitudeError(
            f"energy_ratio is {ratio:.9g}; 2 E C / L^2 of this body lies between 1 (rotation about "
            f"the short axis) and {c / a:.9g} (about the long axis)."
        )
    found = "SAM" if b * ratio < c else "LAM"
    if mode is not None and known_mode(mode) != found:
        low, high = {"SAM": (1.0, c / b), "LAM": (c / b, c / a)}[known_mode(mode)]
        raise AttitudeError(
            f"mode is {known_mode(mode)}, but energy_ratio {ratio:.9g} belongs to {found}: with "
            f"these moments {known_mode(mode)} has {low:.9g} to {high:.9g}."
        )
    # C - D = C (ratio - 1) / ratio and so on: no difference is formed by subtracting D.
    if b * ratio < c:
        rest = c * (ratio - 1.0) / (ratio * (c - b))
        return "SAM", ((c - b * ratio) / (ratio * (c - b)), rest)
    if b * ratio > c:
        rest = max(c - a * ratio, 0.0) / (ratio * (b - a))
        return "LAM", ((b * ratio - c) / (ratio * (b - a)), rest)
    raise AttitudeError(
        f"energy_ratio is {ratio:.9g}, exactly C/B: on the separatrix there are no periods. Give "
        "angles and rates instead."
    )
