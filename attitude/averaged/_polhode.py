"""The energy of a rotation in one variable, and the polhode as functions of it.

Principal moments A <= B <= C; l is the direction of the momentum L over the axes of A, B, C.
theta is the angle between the momentum and the axis of C where the momentum crosses the plane of
the axes of A and C, and y = 2 ln tan theta, so that p = sin^2 theta = (2E/L^2 - 1/C)/D with
D = 1/A - 1/C.  y grows with the energy at fixed |L|: -infinity is uniform rotation about the short
axis (C), +infinity about the long axis (A), and y_s, with tan^2 theta_s = A (C - B)/(C (B - A)),
the separatrix between the short-axis modes (SAM) and the long-axis modes (LAM).  With h = |y - y_s|
Jacobi's parameter is m = exp(-h) on both sides.  The angular velocity across the momentum has the
components L D gamma_i l_i, gamma = ((1 - p), p_s - p, -p).

Over u = 4 K (phase of the nutation):

    SAM  l = (sA sin theta cn, sA sC b sn, sC cos theta dn),  b^2 = p D/(1/B - 1/C)
    LAM  l = (sA sin theta dn, sA sC b sn, sC cos theta cn),  b^2 = (1 - p) D/(1/A - 1/B)

van Zon & Schofield, J. Comput. Phys. 225, 145 (2007), for the motion; DLMF 20.2 and 22.2 for the
functions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from attitude._compilation.decorators import entry_point, subroutine
from attitude._support.arrays import Immutable, frozen
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.torques._schemes import ascending

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray
    from attitude.motions._body import Body

# Regions: the mode, and the end of the circulated axis near which the momentum is.
SAM_PLUS: Final = 0
SAM_MINUS: Final = 1
LAM_PLUS: Final = 2
LAM_MINUS: Final = 3
REGIONS: Final = ("SAM+", "SAM-", "LAM+", "LAM-")
# y_s of bodies with two equal moments, which have one mode only.  exp(-60) is below rounding.
FARTHEST: Final = 60.0
# Places of numbers in `Axes.numbers`.
INVERSES: Final = 3  # 1/A, 1/B, 1/C
SPREAD: Final = 6  # D, 1/A - 1/B, 1/B - 1/C
SEPARATRIX: Final = 9  # y_s
TURN: Final = 10  # principal axes to body axes, a quaternion
MATRIX: Final = 14  # and as a matrix by rows
AXES_ENTRIES: Final = 23


@dataclass(frozen=True, eq=False, init=False)
class Axes(Immutable):
    """The principal axes of a body in the order A <= B <= C, as the compiled loops take them."""

    moments: FloatArray  # (3,), kg m2, ascending
    matrix: FloatArray  # (3, 3), columns: the principal axes over the body axes, right-handed
    numbers: FloatArray  # (AXES_ENTRIES,)

    def __init__(self, body: Body) -> None:
        moments = np.sort(body.moments)
        a, b, c = moments
        if a <= 0.0:
            raise AttitudeError(
                "the body is a rod, with a moment of zero; give it a small moment about its axis."
            )
        if c - a <= 1e-12 * c:
            raise AttitudeError(
                "the three moments of the body are equal: nothing nutates, and there is no mean "
                "to take. Integrate it by TorquedRotation."
            )
        _, matrix = ascending(body)
        self._set("moments", frozen(moments))
        self._set("matrix", frozen(np.ascontiguousarray(matrix)))
        numbers = np.empty(AXES_ENTRIES)
        numbers[:INVERSES] = moments
        numbers[INVERSES:SPREAD] = 1.0 / moments
        numbers[SPREAD:SEPARATRIX] = (c - a) / (a * c), (b - a) / (a * b), (c - b) / (b * c)
        with np.errstate(divide="ignore"):
            y_s = np.log(a * (c - b)) - np.log(c * (b - a))
        numbers[SEPARATRIX] = np.clip(y_s, -FARTHEST, FARTHEST)
        numbers[TURN:MATRIX] = quaternion.from_matrix(matrix)
        numbers[MATRIX:] = matrix.reshape(9)
        self._set("numbers", frozen(numbers))

    @property
    def spread(self) -> float:
        """D = 1/A - 1/C, 1/(kg m2)."""
        return float(self.numbers[SPREAD])

    @property
    def separatrix(self) -> float:
        """y_s."""
        return float(self.numbers[SEPARATRIX])

    def state(self, omega: FloatArray) -> tuple[float, float, int]:
        """|L| in N m s, y and the region of an angular velocity (3,) in rad/s, body axes.

        y from 2 E C - L^2 and L^2 - 2 E A as squares of single components: exact at both ends.
        """
        a, b, c = self.moments
        w = omega @ self.matrix
        momentum = self.moments * w
        size = float(np.sqrt(momentum @ momentum))
        if not size > 0.0:
            raise AttitudeError("the body does not rotate; give an angular velocity.")
        over_c = a * (c - a) * w[0] ** 2 + b * (c - b) * w[1] ** 2
        below_a = c * (c - a) * w[2] ** 2 + b * (b - a) * w[1] ** 2
        with np.errstate(divide="ignore"):
            y = np.log(a / c * over_c) - np.log(below_a)
        y = float(np.clip(y, -2.0 * FARTHEST, 2.0 * FARTHEST))
        return size, y, self.region(y, momentum)

    def region(self, y: float, momentum: FloatArray) -> int:
        """The region of y and a momentum (3,) over the principal axes."""
        if y < self.separatrix:
            return SAM_PLUS if momentum[2] >= 0.0 else SAM_MINUS
        return LAM_PLUS if momentum[0] >= 0.0 else LAM_MINUS

    def end(self, region: int) -> FloatArray:
        """Unit vector (3,) over the body axes: the end of the axis near which the momentum is."""
        axis = self.matrix[:, 2 if region < LAM_PLUS else 0]
        vector: FloatArray = axis if region in (SAM_PLUS, LAM_PLUS) else -axis
        return vector

    def energy(self, size: FloatArray, y: FloatArray) -> FloatArray:
        """Kinetic energy in J for |L| in N m s and y."""
        p, complement = shares(y)
        return 0.5 * size**2 * (p / self.moments[0] + complement / self.moments[2])

    def nodes(self, y: float, region: int, count: int) -> FloatArray:
        """Directions (count, 3) of the momentum over principal axes, uniform in time."""
        out = np.empty((count, 3))
        fill_nodes(self.numbers, region, abs(y - self.separatrix), out)
        return out

    @cached_property
    def arcs(self) -> tuple[FloatArray, FloatArray]:
        """The four arcs of the separatrix: l (4, N, 3) at nodes, and seconds (N,) of each at L = 1.

        Arc 2 [sA < 0] + [sC < 0] leads along the plane of B from one end of the middle axis to the
        other.  Integrands vanish at both ends as exp(-|v|), so the trapezoidal rule is exact to
        rounding.
        """
        v = np.arange(-200, 201) * 0.2
        p, complement = shares(np.array(self.separatrix))
        sine, cosine = np.sqrt(p), np.sqrt(complement)
        arcs = [
            np.stack(
                [sa * sine / np.cosh(v), sa * sc * np.tanh(v), sc * cosine / np.cosh(v)], axis=-1
            )
            for sa in (1.0, -1.0)
            for sc in (1.0, -1.0)
        ]
        return np.array(arcs), np.full(len(v), 0.2 / self.separatrix_pace)

    @property
    def separatrix_pace(self) -> float:
        """Rate, 1/s at L = 1, at which a motion on the separatrix nears the middle axis."""
        p, complement = shares(np.array(self.separatrix))
        pace = np.sqrt(p * self.spread * self.numbers[SPREAD + 1])
        other = np.sqrt(complement * self.spread * self.numbers[SPREAD + 2])
        return float(max(pace, other))


def shares(y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """p = sin^2 theta and 1 - p for y, each to rounding."""
    with np.errstate(over="ignore"):
        return 1.0 / (1.0 + np.exp(-y)), 1.0 / (1.0 + np.exp(y))


# ---- Elliptic functions, doubles


@subroutine
def quarter_period(b):
    """K for the complementary modulus b > 0."""
    a = 1.0
    for _ in range(12):
        close = abs(a - b) <= 1e-8 * a
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        if close:
            break
    return 0.5 * math.pi / a


@subroutine
def quarter_and_mean_square(m, mc):
    """K, and the mean of sn^2, without cancellation at both ends."""
    a, b = 1.0, math.sqrt(mc)
    # c_n^2/m of the iteration, doubled at each step
    share = 0.5
    c = 0.5 * m / (1.0 + b)
    weight = 1.0
    for _ in range(12):
        share += weight * c * c / m if m > 0.0 else 0.0
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        if c <= 1e-17 * a:
            break
        c = 0.25 * c * c / (0.5 * (a + b))
        weight *= 2.0
    return 0.5 * math.pi / a, share


@subroutine
def theta_constants(h):
    """K, whether real nome is used, pi/2 by the period of its variable, nome, theta 2, 3, 4.

    The nome of m <= 1/2, that of 1 - m above: at most exp(-pi).  theta 2 is over 2 nome^(1/4).
    """
    m, mc = math.exp(-h), -math.expm1(-h)
    k = quarter_period(math.sqrt(mc))
    other = quarter_period(math.sqrt(m)) if m > 1e-30 else 1e300
    real = m <= 0.5
    if real:
        nome = math.exp(-math.pi * (other / k)) if m > 1e-16 else 0.0625 * m
        pace = 0.5 * math.pi / k
    else:
        nome = math.exp(-math.pi * (k / other)) if mc > 1e-16 else 0.0625 * mc
        pace = 0.5 * math.pi / other
    q2 = nome * nome
    q4 = q2 * q2
    q9 = q4 * q4 * nome
    second = 1.0 + q2 + q4 * q2 + q9 * q2 * nome
    third = 1.0 + 2.0 * (nome + q4 + q9 + q4 * q4 * q4 * q4)
    fourth = 1.0 + 2.0 * (-nome + q4 - q9 + q4 * q4 * q4 * q4)
    return k, real, pace, nome, second, third, fourth


@subroutine
def jacobi(u, constants):
    """sn, cn, dn of u."""
    k, real, pace, nome, second, third, fourth = constants
    turns = round(u / (2.0 * k))
    sign = 1.0 if turns % 2 == 0 else -1.0
    v = pace * (u - 2.0 * k * turns)
    q2 = nome * nome
    q4 = q2 * q2
    q6 = q4 * q2
    q9 = q4 * q4 * nome
    q12 = q6 * q6
    q16 = q4 * q12
    if real:
        s, c = math.sin(v), math.cos(v)
        # angles 2 v, 4 v, 6 v, 8 v by multiplication
        c2, s2 = c * c - s * s, 2.0 * s * c
    else:
        e = math.exp(v)
        s, c = 0.5 * (e - 1.0 / e), 0.5 * (e + 1.0 / e)
        if abs(v) < 0.5:
            s = math.sinh(v)
        c2, s2 = c * c + s * s, 2.0 * s * c
    flip = 1.0 if real else -1.0
    c4, s4 = c2 * c2 - flip * s2 * s2, 2.0 * s2 * c2
    c6, s6 = c4 * c2 - flip * s4 * s2, s4 * c2 + c4 * s2
    c8 = c4 * c4 - flip * s4 * s4
    s3, c3 = s2 * c + c2 * s, c2 * c - flip * s2 * s
    s5, c5 = s4 * c + c4 * s, c4 * c - flip * s4 * s
    s7, c7 = s6 * c + c6 * s, c6 * c - flip * s6 * s
    one = s - q2 * s3 + q6 * s5 - q12 * s7
    two = c + q2 * c3 + q6 * c5 + q12 * c7
    three = 1.0 + 2.0 * (nome * c2 + q4 * c4 + q9 * c6 + q16 * c8)
    four = 1.0 + 2.0 * (-nome * c2 + q4 * c4 - q9 * c6 + q16 * c8)
    if real:
        sn, cn = third * one / (second * four), fourth * two / (second * four)
        dn = fourth * three / (third * four)
    else:
        sn = third * one / (fourth * two)
        cn = second * four / (fourth * two)
        dn = second * three / (third * two)
    return sign * sn, sign * cn, dn


@subroutine
def form(axes, region, h):
    """sin and cos of theta, gamma 2, the factor of sn, and the rate of u for L = 1."""
    y = axes[SEPARATRIX] + (h if region >= LAM_PLUS else -h)
    e = math.exp(-0.5 * abs(y))
    small, large = e / math.sqrt(1.0 + e * e), 1.0 / math.sqrt(1.0 + e * e)
    sine, cosine = (large, small) if y > 0.0 else (small, large)
    mc = -math.expm1(-h)
    d = axes[SPREAD]
    if region < LAM_PLUS:
        gap = axes[SPREAD + 2]
        gamma = gap * cosine * cosine * mc / d
        side, pace = sine * math.sqrt(d / gap), cosine * math.sqrt(d * gap)
    else:
        gap = axes[SPREAD + 1]
        gamma = -gap * sine * sine * mc / d
        side, pace = cosine * math.sqrt(d / gap), sine * math.sqrt(d * gap)
    return sine, cosine, gamma, min(side, 1.0), pace


@subroutine
def direction(region, shape, functions):
    """l over the principal axes, from `form` and sn, cn, dn."""
    sine, cosine, side = shape[0], shape[1], shape[3]
    sn, cn, dn = functions
    if region < LAM_PLUS:
        sign = 1.0 if region == SAM_PLUS else -1.0
        return sine * cn, sign * side * sn, sign * cosine * dn
    sign = 1.0 if region == LAM_PLUS else -1.0
    return sign * sine * dn, sign * side * sn, cosine * cn


@entry_point
def fill_nodes(axes, region, h, out):
    """Fill directions (M, 3) of the momentum over the principal axes, uniform in time."""
    constants = theta_constants(h)
    shape = form(axes, region, h)
    count = len(out)
    for j in range(count):
        u = 4.0 * constants[0] * (j + 0.5) / count
        x = direction(region, shape, jacobi(u, constants))
        out[j, 0], out[j, 1], out[j, 2] = x[0], x[1], x[2]


# ---- Means over a nutation in closed form, for all entries of a table


@dataclass(frozen=True, eq=False)
class Nutations:
    """Rotations of one body, each described by its region and h (arrays of one shape S)."""

    p: FloatArray  # sin^2 theta, (S)
    complement: FloatArray  # cos^2 theta, (S)
    gamma: FloatArray  # (S, 3)
    squares: FloatArray  # (S, 3), means of l_i^2
    along: FloatArray  # (S, 3), means of l_i; that of the circulated axis alone is not zero
    period: FloatArray  # (S), of the nutation in s for |L| = 1 N m s: P_psi = period / |L|

    @classmethod
    def of(cls, axes: Axes, region: int, h: FloatArray) -> Nutations:
        """The rotations of one region at h (N,)."""
        out = np.empty((len(h), 12))
        fill_means(axes.numbers, region, h, out)
        return cls(out[:, 0], out[:, 1], out[:, 2:5], out[:, 5:8], out[:, 8:11], out[:, 11])


@entry_point
def fill_means(axes, region, h, out):
    """Fill p, 1 - p, gamma (3), mean squares (3), means (3), period of `Nutations` (N, 12)."""
    for j in range(len(h)):
        m, mc = math.exp(-h[j]), -math.expm1(-h[j])
        k, square = quarter_and_mean_square(m, mc)
        sine, cosine, gamma, side, pace = form(axes, region, h[j])
        p, complement = sine * sine, cosine * cosine
        row = out[j]
        row[0], row[1] = p, complement
        row[2], row[3], row[4] = complement, gamma, -p
        middle = side * side * square
        row[6] = middle
        half = 0.5 * math.pi / k
        row[8], row[9], row[10] = 0.0, 0.0, 0.0
        if region < LAM_PLUS:
            row[5], row[7] = p * (1.0 - square), complement * (1.0 - m * square)
            row[10] = cosine * half * (1.0 if region == SAM_PLUS else -1.0)
        else:
            row[5], row[7] = p * (1.0 - m * square), complement * (1.0 - square)
            row[8] = sine * half * (1.0 if region == LAM_PLUS else -1.0)
        row[11] = 4.0 * k / pace
