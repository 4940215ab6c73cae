"""The lines in the spectrum of a tumbler's light curve: frequencies from two periods.

For a Sun and an observer in constant inertial directions the brightness of a tumbling body is a
function of two angles, each of which is linear in time plus periodic terms: its spectrum consists
of lines at |i / P_phi + j / P_psi| for whole i and j.  In the other convention of the axes 1/P_phi
differs by 1/P_psi, so that the same lines have other numbers i, j.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.motion import Motion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import Real


class Line(NamedTuple):
    """One line: i and j of |i / P_phi + j / P_psi|, its frequency in Hz and period in s."""

    i: int
    j: int
    frequency: float
    period: float


def lines(
    motion: Motion | Sequence[Real],
    order: int | Sequence[int] = 2,
    *,
    convention: str | None = None,
) -> list[Line]:
    """The lines of the spectrum of a tumbler's light curve.

    Parameters
    ----------
    motion : FreeRotation, or pair (P_psi, P_phi)
        s, or Quantities.
    order : int or pair (order of psi, order of phi)
        Lines with |j| and i up to these.
    convention : "L" or "S", optional
        Of P_phi, with a motion: the long or the short axis; by default the one about which the
        momentum circulates.

    Returns
    -------
    list of Line
        In order of frequency; (i, j) and (-i, -j) are one line, with i >= 0.

    Raises
    ------
    AttitudeError
        For a motion without periods, an order that is not a whole number above zero, and a
        convention with a pair of periods.

    >>> hour = 3600.0
    >>> main = [line for line in lines((263.0 * hour, 27.38 * hour)) if (line.i, line.j) == (1, -1)]
    >>> round(main[0].period / hour, 2)              # of (99942) Apophis, Pravec et al. 2014
    30.56
    """
    psi, phi = _frequencies(motion, convention)
    found = []
    for i, j in line_numbers(known_orders(order)):
        frequency = abs(i * phi + j * psi)
        found.append(Line(i, j, frequency, 1.0 / frequency if frequency > 0.0 else np.inf))
    return sorted(found, key=lambda line: line.frequency)


def line_numbers(orders: tuple[int, int]) -> list[tuple[int, int]]:
    """All (i, j) except (0, 0), one of (i, j) and (-i, -j)."""
    of_psi, of_phi = orders
    found = [(0, j) for j in range(1, of_psi + 1)]
    return found + [(i, j) for i in range(1, of_phi + 1) for j in range(-of_psi, of_psi + 1)]


def known_orders(order: Any) -> tuple[int, int]:
    """The orders of psi and of phi from one whole number or two, else an AttitudeError."""
    pair = (order, order) if np.ndim(order) == 0 else tuple(order)
    whole = all(isinstance(n, (int, np.integer)) and not isinstance(n, bool) for n in pair)
    if len(pair) != 2 or not whole or min(pair) < 0 or max(pair) < 1:
        raise AttitudeError(
            f"order is {order!r}; give a whole number above zero, or two of them: of psi, of phi."
        )
    return int(pair[0]), int(pair[1])


def _frequencies(motion, convention):
    """1 / P_psi and 1 / P_phi in Hz."""
    if isinstance(motion, Motion):
        found = motion.regime
        P_phi = motion.period_phi if convention is None else found.P_phi(convention)
        return 1.0 / motion.period_psi, 1.0 / P_phi
    if convention is not None:
        raise AttitudeError(
            f"convention is {convention!r}, but a pair of periods has one already; leave it out, "
            "or give a motion."
        )
    try:
        P_psi, P_phi = motion
    except (TypeError, ValueError) as err:
        raise AttitudeError(
            f"motion is {motion!r}; give a FreeRotation, or the pair (P_psi, P_phi)."
        ) from err
    return (
        1.0 / validation.positive(P_psi, "P_psi", unit="s"),
        1.0 / validation.positive(P_phi, "P_phi", unit="s"),
    )
