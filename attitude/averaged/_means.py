"""Means of torques over nutation and precession: closed forms, tables of one direction, the torus.

`register` names the function that gives the means of a class of torques.  A torque without an entry
is averaged over nodes of the torus of both phases: slow, and always correct.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from attitude.averaged import _rates, _tables
from attitude.averaged._polhode import Axes, Nutations
from attitude.errors import AttitudeError
from attitude.torques._magnetic import EddyCurrent, MagneticDipole
from attitude.torques._radiation import AerodynamicTorque, SolarRadiation
from attitude.torques._torque import (
    ConstantTorque,
    GravityGradient,
    InertiaHistory,
    InternalDissipation,
    LinearDamping,
    Torque,
)

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray
    from attitude.motions._body import Body

    Numbers: TypeAlias = Callable[[FloatArray], FloatArray]

# Nodes of ln(|L|/C), rad/s, of the friction of a rheology: the first, their spacing and count.
_SIZES = math.log(1e-11), 0.5, 61


@dataclass(frozen=True, eq=False)
class Mean:
    """One mean, as the compiled loops take it.

    Attributes
    ----------
    kind : int
        HARMONICS, TENSOR, FRICTION or TORUS of `_rates`.
    numbers : callable
        Of samples (K, columns) of the torque: numbers (K, F) of the mean; F is 4 for a direction
        and its weight, 9 for a tensor by rows.
    means : (4, n + 1, C) array
        For each region at the nodes of `_tables.coordinates`.
    arcs : (4, C) array
        The same, integrated over time along the arcs of the separatrix at L = 1.
    exponent : int
        The numbers of the table are multiplied by |L|^exponent.
    strength : float
        An upper bound or root mean square of the torque for numbers of size 1 and L = 1.
    is_linear : bool
        Whether the numbers themselves may be averaged over an orbit.
    torque : Torque or None
        For the torus.
    sizes : (float, float)
        Of FRICTION: the first node of ln |L|, and their spacing.
    """

    kind: int
    numbers: Numbers
    means: FloatArray
    arcs: FloatArray
    exponent: int = 0
    strength: float = 0.0
    is_linear: bool = False
    torque: Torque | None = None
    sizes: tuple[float, float] = (0.0, 0.0)

    @property
    def degree(self) -> int:
        """Largest degree of the harmonics."""
        return self.arcs.shape[1] // 4 - 1


MeansFunction: TypeAlias = Callable[[Any, "Body", Axes, int], Sequence[Mean]]
Function = TypeVar("Function", bound=MeansFunction)
_MEANS: dict[type[Torque], MeansFunction] = {}


def register(kind: type[Torque]) -> Callable[[Function], Function]:
    """Decorator: the function (torque, body, axes, degree) returns the means of this class."""

    def named(function: Function) -> Function:
        _MEANS[kind] = function
        return function

    return named


def means_of(torque: Torque, body: Body, axes: Axes, degree: int) -> Sequence[Mean]:
    """The means of a torque: those of its class, or one over the torus."""
    for kind in type(torque).__mro__:
        if kind in _MEANS:
            return _MEANS[kind](torque, body, axes, degree)
    return [over_torus(torque)]


def over_torus(torque: Torque) -> Mean:
    """The mean of any torque over nodes of both phases."""
    return Mean(
        _rates.TORUS,
        lambda samples: samples,
        np.zeros((4, 2, 0)),
        np.zeros((4, 0)),
        0,
        1.0,
        torque=torque,
    )


def over_plane(mean: Mean) -> Mean:
    """That of a torque of one direction over all directions across a normal, by the normal.

    The mean of P_n(l . s) over them is P_n(0) P_n(l . normal) (Funk & Hecke), and its gradient by l
    is the mean of P_n'(l . s) s.
    """
    factors = np.repeat(np.polynomial.legendre.legvander(np.zeros(1), mean.degree)[0], 4)
    return replace(mean, means=mean.means * factors, arcs=mean.arcs * factors)


# ---- Closed forms


def _nutations(axes: Axes) -> list[Nutations]:
    h = _tables.distances(_tables.coordinates(axes))
    return [Nutations.of(axes, region, h) for region in range(4)]


def _on_arcs(axes: Axes) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """l (4, N, 3), seconds (N,), gamma (3,) and p (1 - p) on the separatrix.

    The last is infinite for a symmetric body, which has none.
    """
    arcs, seconds = axes.arcs
    p = float(1.0 / (1.0 + np.exp(-axes.separatrix)))
    return arcs, seconds, np.array([1.0 - p, 0.0, -p]), p * (1.0 - p) or math.inf


def _alone(samples: FloatArray) -> FloatArray:
    """The numbers of a torque without a direction."""
    return np.tile([0.0, 0.0, 1.0, 1.0], (len(samples), 1))


def _of_rates(
    along: Sequence[FloatArray],
    energy: Sequence[FloatArray],
    on_arcs: FloatArray,
    exponent: int,
    strength: float,
) -> Mean:
    """A mean from torque along L, and gamma l . N / (p (1 - p)), for each region."""
    means = np.zeros((4, len(along[0]), 4))
    means[..., 0], means[..., 1] = along, energy
    arcs = np.zeros((4, 4))
    arcs[:, 1] = on_arcs
    return Mean(_rates.HARMONICS, _alone, means, arcs, exponent, strength, True)


@register(InternalDissipation)
def friction(torque: InternalDissipation, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """dy/dt = -2 strength L D (sum gamma_i^2 <l_i^2>) / (p (1 - p)); L is fixed."""
    if not isinstance(torque.strength, float):
        return [_of_rheology(torque, body, axes)]
    factor = -torque.strength * axes.spread
    table = _nutations(axes)
    energy = [factor * np.sum(n.gamma**2 * n.squares, axis=1) / (n.p * n.complement) for n in table]
    arcs, seconds, gamma, pq = _on_arcs(axes)
    on_arcs = factor * np.sum((arcs * gamma) ** 2, axis=2) @ seconds / pq
    nothing = [np.zeros(len(n.p)) for n in table]
    return [_of_rates(nothing, energy, on_arcs, 2, -0.5 * factor)]


def _of_rheology(torque: InternalDissipation, body: Body, axes: Axes) -> Mean:
    """The same with a strength that depends on |L| and y: its logarithm at nodes of ln |L|."""
    first, spacing, count = _SIZES
    logarithms = first + math.log(float(np.max(body.moments))) + spacing * np.arange(count)
    sizes, lowest = np.exp(logarithms), np.exp(-690.0)

    def kept(strength: FloatArray, factor: FloatArray) -> FloatArray:
        return np.asarray(np.log(np.maximum(strength * factor, lowest)))

    means = []
    for n in _nutations(axes):
        strength = torque.strength_at(body, sizes, n.p[:, None])
        shape = axes.spread * np.sum(n.gamma**2 * n.squares, axis=1) / (n.p * n.complement)
        means.append(kept(strength, shape[:, None] * sizes**2))
    points, seconds, gamma, pq = _on_arcs(axes)
    on_arcs = axes.spread * np.sum((points * gamma) ** 2, axis=2) @ seconds / pq
    p = 1.0 / (1.0 + math.exp(-axes.separatrix))
    strength = torque.strength_at(body, sizes, np.full(1, p))
    arcs = kept(strength, on_arcs[:, None] * sizes**2)
    nodes = float(logarithms[0]), spacing
    return Mean(_rates.FRICTION, _alone, np.array(means), arcs, 0, 1.0, True, sizes=nodes)


@register(InertiaHistory)
def changing(torque: InertiaHistory, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """Refused: the moments are constants of the tables."""
    raise AttitudeError(
        "AveragedMotion has constant moments, and an InertiaHistory changes them; integrate by "
        "TorquedRotation through the change, and average from its last state on."
    )


@register(LinearDamping)
def damping(torque: LinearDamping, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """dL/dt = -L sum C_ii <l_i^2> / I_i along l, and gamma_i in the sum for y."""
    matrix = np.diag(axes.matrix.T @ torque.coefficient @ axes.matrix) / axes.moments
    table = _nutations(axes)
    along = [-n.squares @ matrix for n in table]
    energy = [-np.sum(n.gamma * n.squares * matrix, axis=1) / (n.p * n.complement) for n in table]
    arcs, seconds, gamma, pq = _on_arcs(axes)
    turned = axes.matrix.T @ torque.coefficient @ axes.matrix / axes.moments
    on_arcs = -np.einsum("ani,ij,anj,n->a", arcs * gamma, turned, arcs, seconds) / pq
    return [_of_rates(along, energy, on_arcs, 1, float(np.max(np.abs(turned))))]


@register(ConstantTorque)
def constant(torque: ConstantTorque, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """dL/dt = N_a <l_a> along l, a the circulated axis, and gamma_a in the product for y."""
    over = torque.torque @ axes.matrix
    table = _nutations(axes)
    along = [n.along @ over for n in table]
    energy = [(n.gamma * n.along) @ over / (n.p * n.complement) for n in table]
    arcs, seconds, gamma, pq = _on_arcs(axes)
    on_arcs = np.einsum("ani,i,n->a", arcs * gamma, over, seconds) / pq
    return [_of_rates(along, energy, on_arcs, 0, float(np.sqrt(over @ over)))]


@register(GravityGradient)
def gravity(torque: GravityGradient, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """dL/dt = -(3 sum I_i <l_i^2> - tr I)/2 l x (T l), T = 3 GM s s'/r^3; y is constant."""

    def numbers(places: FloatArray) -> FloatArray:
        r = np.sqrt(np.sum(places * places, axis=1))
        tensor = 3.0 * torque.mu * places[:, :, None] * places[:, None, :]
        tensors: FloatArray = (tensor / r[:, None, None] ** 5).reshape(-1, 9)
        return tensors

    table = _nutations(axes)
    means = np.zeros((4, len(table[0].p), 10))
    for region, n in enumerate(table):
        means[region, :, 7] = -0.5 * (3.0 * (n.squares @ axes.moments) - np.sum(axes.moments))
    # u x I u . gamma l: its mean over the precession and over one arc is not 0
    arcs = np.zeros((4, 10))
    points, seconds, gamma, pq = _on_arcs(axes)
    torques = np.cross(points, points * axes.moments)
    arcs[:, 4] = 1.5 * np.sum(torques * points * gamma, axis=2) @ seconds / pq
    arcs[:, 3] = -arcs[:, 4] / 3.0
    spread = 0.5 * float(axes.moments[2] - axes.moments[0])
    return [Mean(_rates.TENSOR, numbers, means, arcs, 0, spread, True)]


@register(MagneticDipole)
def dipole(torque: MagneticDipole, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """dL/dt = m_a <l_a> l x B; y is constant."""

    def numbers(samples: FloatArray) -> FloatArray:
        size = max(float(np.mean(np.sqrt(np.sum(samples**2, axis=1)))), 1e-300)
        return np.concatenate([samples / size, np.full((len(samples), 1), size)], axis=1)

    over = torque.moment @ axes.matrix
    table = _nutations(axes)
    means = np.zeros((4, len(table[0].p), 8))
    for region, n in enumerate(table):
        means[region, :, 7] = n.along @ over
    arcs = np.zeros((4, 8))
    points, seconds, gamma, pq = _on_arcs(axes)
    arcs[:, 5] = np.sum(np.cross(over, points) * points * gamma, axis=2) @ seconds / pq
    return [Mean(_rates.HARMONICS, numbers, means, arcs, 0, float(np.sqrt(over @ over)), True)]


# ---- Tensors: torques that are bilinear in a vector and another one


def tensor_numbers(x: FloatArray, points: FloatArray, gamma: FloatArray) -> FloatArray:
    """The ten numbers (N, 10) of `_rates.of_tensor` for N_i = e_ijk X_jm T_mk at l (N, 3).

    x: (N, 3, 3), over the principal axes as l; gamma (3,) by p (1 - p).  Over the precession T is
    a 1 + b l l' and the part of vec T along l, and the torque across l follows from T l and T' l.
    """
    over = np.sum(x * points[:, None, :], axis=2)  # X l
    trace = x[:, 0, 0] + x[:, 1, 1] + x[:, 2, 2]
    straight = np.stack(
        [x[:, 1, 2] - x[:, 2, 1], x[:, 2, 0] - x[:, 0, 2], x[:, 0, 1] - x[:, 1, 0]], axis=1
    )
    doubled = np.cross(over, points)
    skew = trace[:, None] * points - np.sum(x * points[:, :, None], axis=1)
    out = np.empty((len(points), 10))
    for first, arm in ((0, points), (3, points * gamma)):
        one, two, three = (np.sum(arm * vectors, axis=1) for vectors in (straight, doubled, skew))
        out[:, first] = 0.5 * (one - two)
        out[:, first + 1] = 1.5 * two - 0.5 * one
        out[:, first + 2] = -0.5 * three
    along = np.sum(points * over, axis=1)
    out[:, 6] = -0.5 * np.sum(points * straight, axis=1)
    out[:, 7] = 0.5 * (along - trace)
    out[:, 8] = 0.0  # by T' l: e_ijk (X l)_j is antisymmetric
    out[:, 9] = along
    return out


def _of_bilinear(
    axes: Axes, matrix: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """`means` and `arcs` of N_i = e_ijk X_jm T_mk, X a function of l, by nodes of the nutation."""
    h = _tables.distances(_tables.coordinates(axes))
    means = np.empty((4, len(h), 10))
    for region, n in enumerate(_nutations(axes)):
        gamma = n.gamma / (n.p * n.complement)[:, None]
        sign = 1.0 if region > 1 else -1.0
        for j, distance in enumerate(h):
            count = 24 + int(14.0 * max(1.0, -np.log(distance)))
            points = axes.nodes(axes.separatrix + sign * distance, region, count)
            means[region, j] = np.mean(tensor_numbers(matrix(points), points, gamma[j]), axis=0)
    points, seconds, gamma, pq = _on_arcs(axes)
    arcs = np.array([seconds @ tensor_numbers(matrix(x), x, gamma / pq) for x in points])
    arcs[:, :3] = arcs[:, 6:] = 0.0
    return means, arcs


@register(EddyCurrent)
def eddy(torque: EddyCurrent, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """(M (w x B - B')) x B: bilinear in B and B, and in B' and B."""
    torque.parameters(body)  # refuses relative moments
    tensor = axes.matrix.T @ torque.tensor @ axes.matrix
    size = float(np.max(np.abs(tensor)))

    def turned(points: FloatArray) -> FloatArray:
        # the rows of M [w x]
        return np.cross(tensor, (points / axes.moments)[:, None, :])

    def still(points: FloatArray) -> FloatArray:
        return np.broadcast_to(-tensor, (len(points), 3, 3))

    def squares(samples: FloatArray) -> FloatArray:
        return (samples[:, :3, None] * samples[:, None, :3]).reshape(-1, 9)

    def products(samples: FloatArray) -> FloatArray:
        return (samples[:, 3:6, None] * samples[:, None, :3]).reshape(-1, 9)

    def made() -> dict[str, FloatArray]:
        arrays = *_of_bilinear(axes, turned), *_of_bilinear(axes, still)
        return dict(zip(("means0", "arcs0", "means1", "arcs1"), arrays, strict=True))

    table = _tables.kept(("eddy",), (axes.numbers, tensor), made)
    strength = size / float(axes.moments[0])
    return [
        Mean(_rates.TENSOR, squares, table["means0"], table["arcs0"], 1, strength, True),
        Mean(_rates.TENSOR, products, table["means1"], table["arcs1"], 0, size, True),
    ]


# ---- Tables of one direction


@register(SolarRadiation)
@register(AerodynamicTorque)
def one_direction(torque: Torque, body: Body, axes: Axes, degree: int) -> list[Mean]:
    """Light and flow: a function of the direction of the sample, by its squared length."""
    parameters = np.asarray(torque.parameters(body), dtype=np.float64)

    def made() -> dict[str, FloatArray]:
        field = _tables.field_of(torque.address(), parameters, axes, torque.columns)
        coefficients = _tables.harmonics(field, degree)
        means, arcs = _tables.sums_of(coefficients, axes)
        return {"coefficients": coefficients, "means": means, "arcs": arcs}

    key = (type(torque).__name__, degree)
    contents = torque.contents(body) if isinstance(torque, SolarRadiation) else (parameters,)
    table = _tables.kept(key, (axes.numbers, *contents), made)

    def numbers(samples: FloatArray) -> FloatArray:
        square = np.sum(samples[:, :3] ** 2, axis=1)
        unit = samples[:, :3] / np.sqrt(square)[:, None]
        return np.concatenate([unit, (1.0 / square)[:, None]], axis=1)

    strength = float(np.sqrt(np.sum(table["coefficients"] ** 2) / (4.0 * np.pi)))
    return [Mean(_rates.HARMONICS, numbers, table["means"], table["arcs"], 0, strength)]
