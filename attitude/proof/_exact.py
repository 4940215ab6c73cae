"""Balls that contain the exact attitude of a free rotation; branches are decided in rationals.

A ball (Arb, python-flint) has a midpoint and a radius, and every operation encloses its result at
the precision of `flint.ctx`.  Formulas are those of docs/derivation.md, with nothing arranged
against cancellation: more bits cost less than care.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cached_property
from types import ModuleType
from typing import Any, TypeAlias

from attitude._support import validation
from attitude.errors import AttitudeError

# A fraction (flint.fmpq) or a ball (flint.arb); python-flint has no types.
Number: TypeAlias = Any
Vector: TypeAlias = Sequence[Number]


class Undecided(Exception):
    """The balls are too wide for a decision: more bits are needed."""


@cache
def flint() -> ModuleType:
    """The module flint; AttitudeError where python-flint is not installed."""
    try:
        import flint as module
    except ImportError as err:
        raise AttitudeError(
            "proofs need the package python-flint: "
            f"{validation.installing('proof')} (python-flint >= 0.9)."
        ) from err
    return module


def rational(*doubles: float) -> Number:
    """The exact sum of some finite doubles."""
    fmpq = flint().fmpq
    total = fmpq(0)
    for double in doubles:
        total += fmpq(*float(double).as_integer_ratio())
    return total


def ball(number: Number) -> Number:
    """A number as a ball at the present precision."""
    arb = flint().arb
    return number if isinstance(number, arb) else arb(number)


def sign(number: Number) -> int:
    """-1, 0 or 1; Undecided for a ball that contains zero."""
    if number > 0:
        return 1
    if number < 0:
        return -1
    if isinstance(number, flint().fmpq):
        return 0
    raise Undecided


# ---- Quaternions and vectors of balls; scalar first


def product(p: Vector, q: Vector) -> list[Number]:
    """The quaternion p q."""
    return [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]


def conjugate(q: Vector) -> list[Number]:
    """The quaternion q*."""
    return [q[0], -q[1], -q[2], -q[3]]


def unit(v: Vector) -> list[Number]:
    """A vector of any size as balls, divided by its length."""
    balls = [ball(x) for x in v]
    length = norm(balls)
    return [x / length for x in balls]


def norm(v: Vector) -> Number:
    """The length of a vector as a ball."""
    return ball(dot(v, v)).nonnegative_part().sqrt()


def rotated(q: Vector, v: Vector) -> list[Number]:
    """The vector q v q* (3)."""
    return product(product(q, [0 * q[0], *v]), conjugate(q))[1:]


def dot(a: Vector, b: Vector) -> Number:
    """The scalar product."""
    return sum((x * y for x, y in zip(a[1:], b[1:], strict=True)), a[0] * b[0])


def cross(a: Vector, b: Vector) -> list[Number]:
    """The vector product (3)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def of_matrix(rows: Sequence[Vector]) -> list[Number]:
    """A unit quaternion of the rotation matrix v_out = M v_in, of balls or whole numbers."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    outer = [
        [1 + a + e + i, h - f, c - g, d - b],
        [h - f, 1 + a - e - i, b + d, c + g],
        [c - g, b + d, 1 - a + e - i, f + h],
        [d - b, c + g, f + h, 1 - a - e + i],
    ]
    largest = max(range(4), key=lambda k: _middle(outer[k][k]))
    return unit(outer[largest])


def _middle(x: Number) -> float:
    return float(x.mid()) if isinstance(x, flint().arb) else float(x)


# ---- Principal axes, and every decision


class _Decided:
    """Moments and rates over principal axes, and the branches of the solution.

    `right` is the quaternion from principal to given body axes, or None where they are the same;
    `order` the axes by moments; `d2` |L^2 - 2 E I2|.
    """

    is_uniform = True
    right: list[Number] | None = None
    form = side = d2 = None

    def __init__(self, moments, rates, order):
        self.moments, self.rates, self.order = moments, rates, order
        self.signs = [0, 0, 0]


def _over_principal(moments, rates, order):
    """Decide a motion over its principal axes; `order` of equal moments may be prescribed."""
    by_moment = sorted(range(3), key=lambda k: moments[k]) if order is None else list(order)
    decided = _Decided(moments, rates, by_moment)
    for k in range(3):
        j = (k + 1) % 3
        if moments[k] != moments[j] and sign(rates[k]) and sign(rates[j]):
            decided.is_uniform = False
    if decided.is_uniform:
        return decided
    a, b, c = (moments[k] for k in by_moment)
    low, high = rates[by_moment[0]], rates[by_moment[2]]
    d2 = c * (c - b) * high * high - a * (b - a) * low * low
    decided.signs = [sign(x) for x in rates]
    decided.side = -1 if (side := sign(d2)) < 0 else 1
    equal = (c == b) if side < 0 else (b == a)  # the first two internal moments
    decided.form = "separatrix" if side == 0 else "symmetric" if equal else "theta"
    decided.d2 = abs(d2)
    return decided


def _of_tensor(tensor, rates, near_axes):
    """Decide a motion of a full tensor without diagonalising it.

    Moments are roots of the characteristic polynomial, whose discriminant says in fractions which
    of them are equal; axes are vector products of two rows of J - I; a rate about an axis vanishes
    if w, J w, J^2 w lie in a plane, and the separatrix is a root of the polynomial at L^2 / 2 E.
    """
    module = flint()
    momentum = [dot(row, rates) for row in tensor]
    if all(sign(x) == 0 for x in cross(momentum, rates)):
        return _Decided(None, rates, None)
    moments, single = _roots(tensor)
    axes = _axes(tensor, moments, single, near_axes)
    decided = _Decided(moments, [dot(axis, [ball(x) for x in rates]) for axis in axes], [0, 1, 2])
    decided.is_uniform = False
    decided.right = of_matrix([[axes[k][i] for k in range(3)] for i in range(3)])

    square, double_energy = dot(momentum, momentum), dot(rates, momentum)
    d2 = ball(square) - ball(double_energy) * moments[1]
    is_rational = isinstance(square, module.fmpq)
    at_root = is_rational and not (d2 > 0 or d2 < 0)
    if at_root and _determinant(tensor, square / double_energy) == 0:
        decided.form, decided.side, decided.d2 = "separatrix", 1, module.arb(0)
    else:
        decided.side = sign(d2)
        circulating = 2 if decided.side > 0 else 0
        decided.form = "symmetric" if single == circulating else "theta"
        decided.d2 = abs(d2)
    in_plane = dot(rates, cross(momentum, [dot(row, momentum) for row in tensor]))
    vanishes = single is not None or (is_rational and in_plane == 0)
    for k, rate in enumerate(decided.rates):
        if not vanishes or rate > 0 or rate < 0:
            decided.signs[k] = sign(rate)
        elif near_axes is not None:  # either sense will do
            along = dot(axes[k], [ball(x) for x in near_axes[k]])
            decided.signs[k] = -1 if along < 0 else 1
    return decided


def _determinant(tensor, x):
    """The determinant of J - x."""
    (a, b, c), (d, e, f), (g, h, i) = tensor
    return dot([a - x, b, c], cross([d, e - x, f], [g, h, i - x]))


def _roots(tensor):
    """The moments, ascending balls, and the place of one beside two equal ones, or None.

    With A = J - tr J / 3, p = tr A^2 / 6 and r = det A / 2, they are tr J / 3 + 2 sqrt(p) cos of
    (phi + 2 pi k) / 3 for cos phi = r / p^(3/2); two are equal if p^3 = r^2.  All of these are
    fractions.
    """
    pi = flint().arb.pi()
    mean = (tensor[0][0] + tensor[1][1] + tensor[2][2]) / 3
    p = sum((tensor[i][i] - mean) ** 2 for i in range(3)) / 6
    p += (tensor[0][1] ** 2 + tensor[0][2] ** 2 + tensor[1][2] ** 2) / 3
    r = _determinant(tensor, mean) / 2
    square = p**3 - r**2
    if square == 0:  # the root of p is r / p; p > 0, since the rotation is not uniform
        lone, both = ball(mean + 2 * r / p), ball(mean - r / p)
        return ([both, both, lone], 2) if r > 0 else ([lone, both, both], 0)
    phi = flint().arb.atan2(ball(square).sqrt(), ball(r)) / 3
    size = 2 * ball(p).sqrt()
    return [mean + size * (phi + 2 * pi * k / 3).cos() for k in (1, 2, 0)], None


def _axes(tensor, moments, single, near_axes):
    """Principal axes as unit vectors; `single` is the axis of symmetry, or None."""

    def axis(moment):
        rows = [
            [ball(tensor[i][k]) - (moment if i == k else 0) for k in range(3)] for i in range(3)
        ]
        normals = [cross(rows[i], rows[k]) for i, k in ((0, 1), (1, 2), (2, 0))]
        # not as doubles, whose least is 5e-324
        return unit(max(normals, key=lambda v: dot(v, v).mid()))

    if single is None:
        first, third = axis(moments[0]), axis(moments[2])
        return [first, cross(third, first), third]
    symmetry = axis(moments[single])
    if near_axes is None:
        least = min(range(3), key=lambda k: abs(float(symmetry[k].mid())))
        across = unit(cross(symmetry, [flint().arb(int(k == least)) for k in range(3)]))
    else:
        vector = [ball(x) for x in near_axes[(single + 1) % 3]]
        along = dot(vector, symmetry)
        across = unit([x - along * s for x, s in zip(vector, symmetry, strict=True)])
    axes = [symmetry] * 3
    axes[(single + 1) % 3], axes[(single + 2) % 3] = across, cross(symmetry, across)
    return axes


# ---- The solution at a precision


class Solution:
    """The exact motion at the present precision; Undecided, if this does not suffice for a branch.

    inertia: fractions, three principal moments about the body axes, or a symmetric 3 x 3 tensor.
    wxyz: attitude at t = 0, of any length.
    rates: angular velocity over the body axes, rad/s.
    order: of the moments, ascending, where equal ones leave it open.
    axes: near the principal axes of a tensor, or near the reverse of them: where two equal moments
        leave them open, those nearest; where a rate is zero, the sense of its axis.
    """

    def __init__(
        self,
        inertia: Any,
        wxyz: Vector,
        rates: Vector,
        order: Sequence[int] | None = None,
        axes: Sequence[Vector] | None = None,
    ):
        self.start: list[Number] = unit(wxyz)  # the unit quaternion at t = 0
        self.is_full: bool = isinstance(inertia[0], (list, tuple))
        if self.is_full:
            decided = _of_tensor(inertia, rates, axes)
        else:
            decided = _over_principal(inertia, rates, order)
        self.inertia, self.given_rates = inertia, rates
        self.decided = decided
        if decided.is_uniform:
            self.form: str = "uniform"
            balls = [ball(x) for x in rates]
            self.speed: Number = norm(balls)
            at_rest = all(isinstance(x, flint().fmpq) and x == 0 for x in rates)
            self.axis: list[Number] = [ball(0)] * 3 if at_rest else [x / self.speed for x in balls]
            return
        self.form = decided.form  # "uniform", "separatrix", "symmetric" or "theta"
        self._set_internal_axes()
        self._set_constants()
        self.first: list[Number] = self.internal(ball(0))
        left = product(self.start, self.body)
        self.left: list[Number] = product(left, conjugate(unit(self.first)))

    def _set_internal_axes(self):
        """Internal axis k is sign k times principal axis `order[k]`; the first, third rate >= 0."""
        decided = self.decided
        order = list(decided.order)
        if decided.side < 0:
            order.reverse()
        signs = [1, 1, 1]
        signs[0] = -1 if decided.signs[order[0]] < 0 else 1
        signs[2] = -1 if decided.signs[order[2]] < 0 else 1
        is_even = tuple(order) in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        signs[1] = (1 if is_even else -1) * signs[0] * signs[2]
        matrix = [[0] * 3 for _ in range(3)]
        for k in range(3):
            matrix[order[k]][k] = signs[k]
        self.order, self.signs = order, signs
        self.body = of_matrix(matrix)
        if decided.right is not None:
            self.body = product(decided.right, self.body)

    def _set_constants(self):
        """Amplitudes and phases of the form; symbols as in docs/derivation.md."""
        decided, order = self.decided, self.order
        i1, i2, i3 = (decided.moments[k] for k in order)
        w1, w2, w3 = (s * decided.rates[k] for s, k in zip(self.signs, order, strict=True))
        d12, d23, d13 = abs(i1 - i2), abs(i2 - i3), abs(i1 - i3)
        d1 = i2 * d12 * w2 * w2 + i3 * d13 * w3 * w3
        d3 = i1 * d13 * w1 * w1 + i2 * d23 * w2 * w2
        # a ball around zero has no power, but products
        square = (i1 * w1) * (i1 * w1) + (i2 * w2) * (i2 * w2) + (i3 * w3) * (i3 * w3)
        m, mc = ball(d3 * d12 / (d1 * d23)), ball(decided.d2 * d13 / (d1 * d23))
        wp = (1 if decided.side < 0 else -1) * ball(d1 * d23 / (i1 * i2 * i3)).sqrt()
        l = ball(i3 * d1 / (d13 * square)).sqrt()
        wobble = ball(i1 * d3 / (d13 * square)).sqrt() / (1 + l)  # sqrt((1 - l) / (1 + l))
        minus_n, one_minus_n = ball(i3 * d12 / (i1 * d23)), ball(i2 * d13 / (i1 * d23))
        momentum = ball(square).sqrt()
        c, s = ball(w1) * ball(i1 * d13).sqrt(), -ball(w2) * ball(i2 * d23).sqrt()
        length = norm([c, s])
        c, s = c / length, s / length
        pi = flint().arb.pi()
        self.wp = wp
        if self.form == "separatrix":
            self.y, self.rate, self.precession = (s / c).asinh() / 2, wp / 2, momentum / (2 * i2)
            self.d = (1 / minus_n.sqrt()).atan() / 2
            self.r = wobble * self.d.cos() / self.d.sin()
        elif self.form == "symmetric":
            self.precession = momentum / (2 * i3) * (1 + ball((i3 - i1) / i1) * (1 - l))
            self.x, self.rate, self.rho = flint().arb.atan2(s, c) / pi, wp / pi, wobble
        else:
            self._set_theta(m, mc, minus_n, one_minus_n, c, s)
            third = self._third_kind / self.quarter - l * (pi / 2) / self.quarter / (
                one_minus_n.sqrt()
            )
            self.precession = momentum / (2 * i3) * (1 + ball((i3 - i1) / i1) * third)
            self.r = wobble * self._quotient

    def _set_theta(self, m, mc, minus_n, one_minus_n, c, s):
        """Periods, nome and the imaginary shift of the theta functions."""
        arb, acb = flint().arb, flint().acb
        pi = arb.pi()
        quarter, other = pi / 2 / arb(1).agm(mc.sqrt()), pi / 2 / arb(1).agm(m.sqrt())
        start = s * acb.elliptic_rf(acb(c * c), acb(c * c + mc * s * s), acb(1)).real
        eta = acb.elliptic_rf(acb(minus_n), acb(m + minus_n), acb(one_minus_n)).real
        carlson = acb.elliptic_rj(acb(0), acb(mc), acb(1), acb(one_minus_n)).real
        self._third_kind = quarter - minus_n / 3 * carlson
        self.quarter, self.phase = quarter, start
        self.x, self.rate = start / (2 * quarter), self.wp / (2 * quarter)  # half turns of v
        self.tau, self.shift = acb(0, 2 * other / quarter), acb(0, eta / (2 * quarter))
        theta = self.shift.modular_theta(self.tau)
        self._quotient = theta[3].real / theta[0].imag

    def internal(self, t: Number) -> list[Number]:
        """The quaternion of internal axes to those of the momentum at t, of any length."""
        acb = flint().acb
        turn = acb(0, self.precession * t).exp()
        if self.form == "separatrix":
            z = acb(self.d, -(self.y + self.rate * t))
            alpha, beta = turn * z.cos(), acb(0, -1) * self.r * turn * z.sin()
        elif self.form == "symmetric":
            v = flint().arb.pi() * (self.x + self.rate * t)
            alpha, beta = turn, acb(0, -1) * self.rho * turn * acb(0, -v).exp()
        else:
            x = self.x + self.rate * t
            if not x.is_finite():
                raise Undecided
            # theta1 changes its sign with each half turn, theta4 does not
            half_turns = x.mid().floor().unique_fmpz()
            theta = (x - half_turns + self.shift).modular_theta(self.tau)
            alpha, beta = turn * theta[3], -self.r * turn * theta[0]
            if int(half_turns) & 1:
                beta = -beta
        return [alpha.real, beta.real, beta.imag, alpha.imag]

    def at(self, t: Number) -> list[Number]:
        """The exact unit quaternion at t seconds (a fraction or a ball): four balls."""
        t = ball(t)
        if self.form == "uniform":
            half = self.speed * t / 2
            sine = half.sin()
            return product(self.start, [half.cos(), *(sine * x for x in self.axis)])
        return product(product(self.left, unit(self.internal(t))), conjugate(self.body))

    def difference(self, wxyz: Vector, t: Number) -> list[Number]:
        """q exact* of a quaternion q of any length: of any length too, in other axes.

        Its vector has the length that the sine of half the angle between both asks for, and its
        scalar the sign of the cosine.
        """
        t = ball(t)
        if self.form == "uniform":
            return product(wxyz, conjugate(self.at(t)))
        turned = product(product(conjugate(self.left), wxyz), self.body)
        return product(turned, conjugate(self.internal(t)))

    def rates(self, wxyz: Vector) -> list[Number]:
        """The exact rad/s (3) over the body axes at an attitude `wxyz`: L is constant in space."""
        if self.form == "uniform":
            return [ball(x) for x in self.given_rates]
        right, moments = self.decided.right, self.decided.moments
        local = rotated(conjugate(wxyz), self.momentum)
        if right is not None:
            local = rotated(conjugate(right), local)
        over = [x / i for x, i in zip(local, moments, strict=True)]
        return over if right is None else rotated(right, over)

    @cached_property
    def momentum(self) -> list[Number]:
        """The angular momentum (3) over ICRF, but for uniform rotation."""
        decided = self.decided
        local = [ball(i * w) for i, w in zip(decided.moments, decided.rates, strict=True)]
        return rotated(
            self.start, local if decided.right is None else rotated(decided.right, local)
        )
