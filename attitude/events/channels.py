"""The channels of body axes and directions: smooth functions of time.

Each channel knows upper bounds of its first two derivatives, from the rates of the motion and the
drift of its directions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.conditions.channel import Channel
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SUN_RADIUS_M

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.conditions.moments import Drift, Moment, SearchDirection
    from attitude.motion import RateBounds

# Angular radius at 1 au of the nominal Sun, rad: 959.2 arcsec (IAU 2015 B3, 2012 B2).
SUN_RADIUS: float = np.arcsin(SUN_RADIUS_M / ASTRONOMICAL_UNIT_M)


class Height(Channel):
    """u.a of a direction u and a body axis a: positive within a right angle of the axis."""

    noise = 4e-16

    def __init__(self, axis: FloatArray, direction: SearchDirection) -> None:
        self.axis, self.directions = axis, (direction,)

    def value(self, moment: Moment) -> FloatArray:
        """u.a (N,)."""
        return dot(moment.body(self.directions[0]), self.axis)

    def bounds(self, rates: RateBounds, drifts: Sequence[Drift]) -> tuple[float, float]:
        """Upper bounds of the first two derivatives; see `turning`."""
        return turning(rates, drifts[0])[:2]


class Cone(Height):
    """u.a - cos(angle): positive within an angle (rad) of the axis.

    Computed as a difference of squared chords, which is exact for narrow cones too.
    """

    def __init__(self, axis: FloatArray, direction: SearchDirection, angle: float) -> None:
        super().__init__(axis, direction)
        # Chords start at the end of the axis that is nearer to the cone, where they are short.
        self._end = 1.0 if angle <= 0.5 * np.pi else -1.0
        nearer = angle if angle <= 0.5 * np.pi else np.pi - angle
        self._square = 2.0 * np.sin(0.5 * nearer) ** 2
        self.noise = 1e-15 * (np.sin(nearer) + 1e-16)

    def value(self, moment: Moment) -> FloatArray:
        """u.a - cos(angle) (N,)."""
        u = moment.body(self.directions[0])
        return self._end * (self._square - 0.5 * chord_squared(u, self._end * self.axis))


class Mirrored(Channel):
    """r.s - cos(radius) of the mirrored observer r = 2 (n.o) n - o and the Sun s, by chords.

    Parameters
    ----------
    normal : (3,) array
        Unit normal n of the mirror, body axes.
    sun, observer : SearchDirection
        s and o.
    radius : float or None
        rad; None: the radius of the Sun's disc at its distance in the scene.
    """

    def __init__(
        self,
        normal: FloatArray,
        sun: SearchDirection,
        observer: SearchDirection,
        radius: float | None,
    ) -> None:
        self._normal, self.directions = normal, (sun, observer)
        self._radius = radius
        self.noise = 2e-15 * np.sin(SUN_RADIUS if radius is None else radius)

    def value(self, moment: Moment) -> FloatArray:
        """r.s - cos(radius) (N,)."""
        return self._one_minus_cosine(moment) - 0.5 * self._chord_squared(moment)

    def off_mirror(self, moment: Moment) -> FloatArray:
        """The angle (N,) between the mirrored observer and the Sun, rad."""
        return 2.0 * np.arcsin(np.minimum(0.5 * np.sqrt(self._chord_squared(moment)), 1.0))

    def _chord_squared(self, moment: Moment) -> FloatArray:
        """|r - s|^2 (N,)."""
        sun, observer = (moment.body(each) for each in self.directions)
        twice = 2.0 * dot(observer, self._normal)
        square = np.zeros(moment.hi.shape)
        for k in range(3):
            part = twice * self._normal[k] - observer[..., k] - sun[..., k]
            square = square + part * part
        return square

    def _one_minus_cosine(self, moment: Moment) -> FloatArray | float:
        """1 - cos(radius)."""
        if self._radius is not None:
            return 2.0 * np.sin(0.5 * self._radius) ** 2
        sine = SUN_RADIUS_M / moment.view.sun_distance
        return sine * sine / (1.0 + np.sqrt(1.0 - sine * sine))

    def bounds(self, rates: RateBounds, drifts: Sequence[Drift]) -> tuple[float, float]:
        """Upper bounds of the first two derivatives.

        r.s = 2 (n.o)(n.s) - o.s, and o.s changes by the drifts alone.
        """
        s1, s2, _ = turning(rates, drifts[0])
        o1, o2, _ = turning(rates, drifts[1])
        s, o = drifts
        return (
            2.0 * (s1 + o1) + s.first + o.first,
            2.0 * (s2 + 2.0 * s1 * o1 + o2) + s.second + o.second + 2.0 * s.first * o.first,
        )


def turning(rates: RateBounds, drift: Drift) -> tuple[float, float, float]:
    """Upper bounds of the first three derivatives of u.a, a fixed in the body, u with a drift."""
    a1, a2, a3 = rates
    d1, d2, d3 = drift
    return (
        a1 + d1,
        a2 + 2.0 * a1 * d1 + d2,
        a3 + (3.0 * a2 * d1 if d1 else 0.0) + 3.0 * a1 * d2 + d3,
    )


def dot(u: FloatArray, a: FloatArray) -> FloatArray:
    """u.a of vectors (..., 3) and (3,), by component: an epoch has the same bits in any block."""
    return u[..., 0] * a[0] + u[..., 1] * a[1] + u[..., 2] * a[2]


def chord_squared(u: FloatArray, a: FloatArray) -> FloatArray:
    """|u - a|^2 of vectors (..., 3) and (3,)."""
    x, y, z = u[..., 0] - a[0], u[..., 1] - a[1], u[..., 2] - a[2]
    return x * x + y * y + z * z
