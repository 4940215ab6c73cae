"""Where L^2/2E lies: from two periods, or from the energy, in a mode and a labelling.

A place is the pair (y, 1 - y), both with all their digits: D lies the part y of the way from the
middle moment, which is the separatrix, to the moment of the axis about which the momentum
circulates.  P_psi / P_phi falls all the way, from infinity to a limit, so that there is one place
or none.
"""

import math

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.regime import Mode, known_convention

_MODES = {
    "LAM": "LAM",
    "SAM": "SAM",
    Mode.LONG_AXIS: "LAM",
    Mode.SHORT_AXIS: "SAM",
}
_ROUNDING = 1e-14


def known_mode(mode):
    """ "LAM" or "SAM"."""
    given = mode.upper() if isinstance(mode, str) else mode
    if given in _MODES:
        return _MODES[given]
    raise AttitudeError(
        f'mode is {mode!r}; give "LAM" (long-axis mode) or "SAM" (short-axis mode), or Mode.'
        "LONG_AXIS or Mode.SHORT_AXIS. The same two periods belong to other states in the other "
        "mode, so that it must be given."
    )


def possible(moments, P_psi, P_phi):
    """Which combinations of mode and convention have a motion with these periods.

    Parameters
    ----------
    moments : (3,) array_like
        Principal moments, ascending; ratios will do.
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


def longest_P_phi(moments, mode, convention, P_psi):
    """The greatest mean P_phi that goes with a P_psi: that of a vanishing wobble.

    Any shorter one is possible, ever nearer to the separatrix.
    """
    turns, _ = cycle(moments, known_mode(mode), (1.0, 0.0))
    return P_psi / (turns + (known_convention(convention) == "S"))


def moments_from_ratios(A_over_C, B_over_C):
    """Relative moments (A, B, C = 1) from published ratios, checked.

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
    a, b, c = moments
    return a > 0.0 and (b > a if mode == "LAM" else c > b)


def refuse_missing_mode(moments, mode):
    """Raise if a body with these moments (3,), ascending, has no such mode."""
    if not _exists(moments, mode):
        listed = ", ".join(f"{each:.9g}" for each in moments)
        why = "the least is zero" if moments[0] == 0.0 else (
            "the least two are equal" if mode == "LAM" else "the greatest two are equal"
        )  # fmt: skip
        raise AttitudeError(
            f"a body with the moments {listed} has no {mode}: {why}. "
            + ("Give another mode." if moments[2] > moments[0] > 0.0 else "Give rates instead.")
        )


def _solved(moments, mode, ratio):
    from attitude.solution.place_of_d import positions_all

    out = np.empty((1, 3))
    moments = np.array([moments], dtype=float)
    positions_all(moments, np.array([mode == "LAM"]), np.array([ratio], dtype=float), out)
    return out[0]


def cycle(moments, mode, position):
    """Turns of phi of the long axis in one P_psi, and that period for a momentum of 1."""
    from attitude.solution.place_of_d import cycles_all

    out = np.empty((1, 2))
    y, rest = (np.array([each], dtype=float) for each in position)
    cycles_all(np.array([moments], dtype=float), np.array([mode == "LAM"]), y, rest, out)
    return out[0]


def from_periods(moments, mode, convention, P_psi, P_phi):
    """The place (y, 1 - y) that two periods belong to, and P_psi for a momentum of 1.

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
        If there is none: the range of P_phi, and the combinations that would have a motion.
    """
    ratio = P_psi / P_phi - (convention == "S")
    found = _solved(moments, mode, ratio)
    if not math.isnan(found[0]):
        return found
    longest = longest_P_phi(moments, mode, convention, P_psi)
    if P_phi <= longest:
        raise AttitudeError(
            f"P_psi is {P_psi / P_phi:.6g} times P_phi; such a motion is nearer to the separatrix "
            "than numbers can tell. Give rates instead."
        )
    others = possible(moments, P_psi, P_phi)
    listed = ", ".join(f"{each} with {labels}" for each, labels in others)
    raise AttitudeError(
        f"P_phi is {P_phi:.9g} s and P_psi is {P_psi:.9g} s; with these moments in {mode}, "
        f'convention "{convention}", P_phi can be {longest:.9g} s at the most for this P_psi. '
        + (
            f"These combinations would have a motion: {listed}."
            if others
            else "No other mode or convention has a motion with these periods either: check the "
            "moments."
        )
    )


def from_energy(moments, energy_ratio, mode=None):
    """Mode and place (y, 1 - y) for E/E0 = 2 E C / L^2; moments ascending.

    Raises
    ------
    AttitudeError
        For an energy that no motion has, or that contradicts the mode: what would be possible.
    """
    a, b, c = moments
    ratio = validation.number(energy_ratio, "energy_ratio")
    if a == 0.0 or a == c:
        raise AttitudeError(
            "the energy does not tell the motion of a sphere or of a rod; give rates instead."
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
    # C - D = C (ratio - 1) / ratio and so on, none by subtracting D
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
