"""The exact state of free rotations joined by changes, in fractions as long as they are exact."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs
from attitude._support.arrays import frozen
from attitude.errors import AttitudeError
from attitude.proof import _certificate, _exact
from attitude.proof._certificate import Certificate
from attitude.proof._exact import Number, Solution, conjugate, cross, dot, rational, rotated

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


@dataclass(frozen=True)
class Joint:
    """A change between two arcs."""

    seconds: FloatArray  # (2,), since the epoch, the sum of two doubles
    # (3, 2), angular momentum that it adds, each component the sum of two doubles
    added: FloatArray
    in_body: bool  # whether that is over the body axes, or over ICRF
    # of the next arc: (3,) principal moments about the body axes, or a (3, 3) tensor
    inertia: FloatArray


class Chain:
    """Arcs from an exact state on.

    inertia: of the first arc, (3,) or (3, 3), as those of joints.
    wxyz: (4, 2), attitude at the epoch, body to ICRF, each component the sum of two doubles.
    rates: (3,), angular velocity at the epoch over the body axes, rad/s.
    order: of the moments of the first arc, where equal ones leave it open.
    axes: (3, 3), columns: principal axes of the first tensor, where two equal moments leave them
        open, or a rate of zero the sense of one.
    """

    def __init__(
        self,
        inertia: FloatArray,
        wxyz: FloatArray,
        rates: FloatArray,
        joints: Sequence[Joint] = (),
        order: Sequence[int] | None = None,
        axes: FloatArray | None = None,
    ):
        self._inertia = [_fractions(inertia), *(_fractions(joint.inertia) for joint in joints)]
        self._wxyz = [rational(*row) for row in wxyz.tolist()]
        self._rates = [rational(x) for x in rates.tolist()]
        self._starts = [rational(0.0), *(rational(*joint.seconds) for joint in joints)]
        self._joints = joints
        self._choice = order, None if axes is None else _fractions(axes.T)
        # Precision and arc -> its solution.
        self._solutions: dict[tuple[int, int], Solution] = {}

    def solution(self, arc: int = 0) -> Solution:
        """The `Solution` of an arc at the present precision; Undecided for too few bits."""
        bits = _exact.flint().ctx.prec
        for k in range(arc + 1):
            if (bits, k) not in self._solutions:
                state = self._after(bits, k) if k else (self._wxyz, self._rates, *self._choice)
                self._solutions[bits, k] = Solution(self._inertia[k], *state)
        return self._solutions[bits, arc]

    def _after(self, bits: int, arc: int) -> tuple[list[Number], list[Number]]:
        """Attitude and angular velocity at the beginning of an arc, after the change."""
        before, joint = self._solutions[bits, arc - 1], self._joints[arc - 1]
        wxyz = before.at(self._starts[arc] - self._starts[arc - 1])
        rates = before.given_rates if before.form == "uniform" else before.rates(wxyz)
        added = [rational(*row) for row in joint.added.tolist()]
        if not joint.in_body and any(x != 0 for x in added):
            added = rotated(conjugate(wxyz), [_exact.ball(x) for x in added])
        momentum = _times(self._inertia[arc - 1], rates)
        momentum = [x + y for x, y in zip(momentum, added, strict=True)]
        return wxyz, _solved(self._inertia[arc], momentum)

    def certificate(
        self,
        seconds: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
        rates: FloatArray | None = None,
    ) -> Certificate:
        """The certificate of attitudes (..., 4), and angular velocities (..., 3), at epochs (...).

        AttitudeError for epochs that are not finite, and as `certified`.
        """
        shape = seconds.shape
        lows = np.broadcast_to(pairs.Seconds(seconds, low).low, shape)
        if not np.all(np.isfinite(seconds)) or not np.all(np.isfinite(lows)):
            raise AttitudeError("an epoch is not finite; it has no attitude to be certified.")
        flat = seconds.ravel().tolist(), lows.ravel().tolist()
        times = [rational(*pair) for pair in zip(*flat, strict=True)]
        arcs = [max(bisect_right(self._starts, t) - 1, 0) for t in times]
        certificate = _certificate.certified(
            [
                (partial(self.solution, arc), [k for k, a in enumerate(arcs) if a == arc])
                for arc in sorted(set(arcs))
            ],
            [t - self._starts[arc] for t, arc in zip(times, arcs, strict=True)],
            (frozen(seconds.copy()), frozen(lows.copy())),
            wxyz.reshape(-1, 4),
            None if rates is None else rates.reshape(-1, 3),
        )
        return certificate.reshaped(shape)


def _fractions(inertia: FloatArray) -> Any:
    rows = inertia.tolist()
    if inertia.ndim == 1:
        return [rational(x) for x in rows]
    return [[rational(x) for x in row] for row in rows]


def _times(inertia, v):
    """The angular momentum of rates."""
    if isinstance(inertia[0], list):
        return [dot(row, v) for row in inertia]
    return [i * x for i, x in zip(inertia, v, strict=True)]


def _solved(inertia, momentum):
    """The rates of an angular momentum."""
    if isinstance(inertia[0], list):
        first, second, third = inertia
        columns = cross(second, third), cross(third, first), cross(first, second)
        whole = dot(first, columns[0])
        return [
            sum(column[k] * x for column, x in zip(columns, momentum, strict=True)) / whole
            for k in range(3)
        ]
    if any(i == 0 for i in inertia):
        raise AttitudeError(
            "a moment of inertia is zero; changes of such a body cannot be certified."
        )
    return [x / i for x, i in zip(momentum, inertia, strict=True)]
