"""How attitudes depend on the initial state and the inertia: derivatives, errors, samples."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._compilation.deferral import uncollected
from attitude._solver import codes, evaluation
from attitude._solver.records import BLOCK, COLUMNS, ROWS, TANGENTS
from attitude._support.arrays import frozen, read_only
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray


# ---- Derivatives of attitudes and angular velocities of B bodies, as arrays
# The nine parameters of a motion are the rotation vector of its first attitude (3, rad, inertial
# axes), its angular velocity at the epoch (3, rad/s, body axes) and its principal moments (3).

# Parameters of a motion.
PARAMETERS = COLUMNS
# In place of second doubles of the epochs, where there are none.
_NO_LOW = frozen(np.empty((1, 0)))
# Growth of a rotation about an unstable axis, as a power of e, beyond which squares overflow.
_MOST_GROWTH = 280.0


def tangents_of(
    moments: FloatArray, wxyz: FloatArray, principal: FloatArray, constants: NDArray[Any]
) -> NDArray[Any]:
    """The derivatives of the elements of B motions, constants (B,)."""
    if np.any(moments[:, :, 0] == 0.0):
        body = int(np.flatnonzero(np.any(moments[:, :, 0] == 0.0, axis=1))[0])
        raise AttitudeError(
            f"moments are {moments[body, :, 0].tolist()}; sensitivities need three moments above "
            "zero: the rotation of an ideal rod about itself is undefined."
        )
    tangents = np.zeros(len(constants), TANGENTS)
    arrays = [evaluation.writable(array) for array in (moments, wxyz, principal, constants)]
    uniform = np.any(constants["form"] == codes.UNIFORM)
    if uniform:
        _compiled(True)[0](*arrays, tangents)
    if not uniform or np.any(constants["form"] != codes.UNIFORM):
        _compiled(False)[0](*arrays, tangents, np.empty(ROWS * BLOCK))
    return tangents


def evaluate(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    t: FloatArray,
    t_low: FloatArray | None,
    attitude: FloatArray,
    omega: FloatArray | None = None,
    *,
    edges: IntArray | None = None,
    near: bool = True,
) -> None:
    """Fill attitude, omega (B, 3, P, T) with the derivatives of B motions at epochs t, t_low (1 or
    B, T).

    near: whether columns have all digits near the epoch of the state, by series; otherwise those
        of their terms, and series only where these cancel to 4e-12.
    """
    short = _short_of(constants, tangents, t, edges, omega is not None, near)
    _in_blocks(constants, tangents, short, t, t_low, 1, (attitude, omega), edges)


class Factored(NamedTuple):
    """What `covariances` needs of B motions and the covariances of their parameters.

    factors: (B, 9, 9), W of covariances W W^T, such that W^T makes the columns triangular.
    tangents: (B,) structured, those of parameters of which the given ones are combinations by the
        factors.
    """

    factors: FloatArray
    tangents: NDArray[Any]


def factored(constants: NDArray[Any], tangents: NDArray[Any], factors: FloatArray) -> Factored:
    """The `Factored` of motions for factors W (B, 9, 9) of covariances W W^T."""
    return Factored(*_triangular(constants, tangents, factors))


def covariances(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    of: Factored,
    t: FloatArray,
    t_low: FloatArray | None,
    out: FloatArray,
) -> None:
    """Fill out (B, 3, 3, T) with the covariances of B motions at given epochs."""
    short = _short_of(constants, tangents, t, None, out.shape[1] == 6, True)
    if len(short):
        factors = np.moveaxis(of.factors, 1, 2)[short["motion"]]
        short["series"] = factors[:, None] @ short["series"]
    _in_blocks(constants, of.tangents, short, t, t_low, 2, (out,), None)


def _short_of(constants, tangents, t, edges, rates, every):
    """The series of motions for epochs near that of the state, or none if no epoch needs them.

    Those of every motion, or of those whose terms cancel.
    """
    span = np.empty(len(constants))
    _short().spans_of(evaluation.writable(constants), span)
    of_terms = tangents["spans"][:, 0 if every else 1]
    spans = np.maximum(of_terms, 1)
    reach = np.empty(len(constants))
    _short().reaches(evaluation.writable(tangents), span * spans, reach)
    if not every:
        few = (constants["form"] != codes.UNIFORM) & (of_terms == 0)
        reach[few & (tangents["slow"][:, 0] == 0.0)] = -1.0
    far = reach[:, None] if edges is None else np.repeat(reach, np.diff(edges))[None]
    rows = np.abs(t if edges is None else t[:, edges[0] : edges[-1]])
    with np.errstate(invalid="ignore"):
        within = rows <= far
    if not np.any(within if rates else within & (rows != 0.0)):
        return np.empty(0, _short().SHORT)
    # series reach as far as the epochs on each side; motions without such epochs have none
    later = t if edges is None else t[:, edges[0] : edges[-1]]
    sides = [
        _farthest(np.where(within & (sign * later >= 0.0), rows, -1.0), edges) for sign in (1, -1)
    ]
    farthest = np.stack(sides, axis=1)
    span = np.where(np.any(farthest >= 0.0, axis=1), span, -1.0)
    steps = np.ceil(farthest / np.maximum(span, 1e-300)[:, None])
    spans = np.clip(steps, 1, spans[:, None]).astype(np.int64)
    short = np.zeros(len(constants) + int(np.sum(spans - 1)), _short().SHORT)
    records = evaluation.writable(constants), evaluation.writable(tangents)
    _short().short_setup(*records, span, spans, short)
    return short


def _farthest(distances, edges):
    """The largest of the rows (B, T), or of the runs of one row; -1 of runs without any."""
    if edges is None:
        return distances.max(axis=1, initial=-1.0)
    largest, filled = np.full(len(edges) - 1, -1.0), np.diff(edges) > 0
    if np.any(filled):
        largest[filled] = np.maximum.reduceat(distances[0], (edges[:-1] - edges[0])[filled])
    return largest


def _triangular(constants, tangents, factors):
    """Factors W Q with an orthogonal Q, and records with the zeros of columns."""
    turned, order = factors.copy(), _order()
    members = np.flatnonzero(constants["form"] != codes.UNIFORM)
    if members.size:
        weights, offset = tangents["weights"][members], tangents["offset"][members]
        stacked = np.concatenate([weights[:, order], offset], axis=1) @ factors[members]
        turns = np.linalg.qr(np.swapaxes(stacked, 1, 2), mode="complete")[0]
        turned[members] = factors[members] @ turns
    mixed = _mixed(tangents, turned)
    for column, row in enumerate(order):  # what is zero but for rounding
        mixed["weights"][members, row, column + 1 :] = 0.0
    return turned, mixed


def _mixed(tangents, factors):
    """The records for parameters of which the given ones are linear combinations."""
    mixed = evaluation.copy_of(tangents)
    for name in ("weights", "offset", "amplitudes"):
        mixed[name] = tangents[name] @ factors
    for name in ("uniform", "uniform_rates"):
        mixed[name] = tangents[name] @ factors[:, None]
    return mixed


def _in_blocks(constants, tangents, short, t, t_low, kind, outputs, runs):
    """Call the loops of each form, so many epochs at a time that Ctrl-C is heard."""
    _refuse_overflow(tangents, t, runs)
    records = evaluation.writable(constants), evaluation.writable(tangents)
    times = read_only(t), _NO_LOW if t_low is None else read_only(t_low)
    block = np.empty(ROWS * BLOCK)
    forms = set(constants["form"].tolist())
    for edges in _parts(runs, len(constants), t.shape[1]):
        for form in forms:
            loop = _compiled(form == codes.UNIFORM)[kind][form]
            body = loop(*records, short, *times, block, *outputs, edges)
            if body >= 0:
                few = body if len(t) > 1 else 0, slice(*edges[body].tolist())
                evaluation.refuse_epoch(
                    constants[body], t[few], None if t_low is None else t_low[few]
                )


def _parts(runs, bodies, count):
    """Edges (B, 2) of the epochs of each body, for each call of a loop."""
    if runs is not None:
        yield np.stack([runs[:-1], runs[1:]], axis=1)
        return
    size = max(evaluation.EPOCHS // (4 * max(bodies, 1)), 1)
    for first in range(0, count, size):
        yield np.full((bodies, 2), (first, min(first + size, count)), dtype=np.int64)


def reaches(tangents: NDArray[Any]) -> FloatArray:
    """The largest |t| (B,), s, to which derivatives of motions stay in the range of doubles."""
    growth = _growth(tangents)
    with np.errstate(divide="ignore"):
        return np.where(growth > 0.0, _MOST_GROWTH / growth, np.inf)


def _growth(tangents):
    """The rates (B,), 1/s, at which rotations about an unstable axis multiply errors by e."""
    return 4.0 * np.pi * tangents["wobble"][:, 0] * tangents["grows"]


def _refuse_overflow(tangents, t, runs):
    growth = _growth(tangents)
    if not np.any(growth > 0.0):
        return
    if runs is None:
        far = np.nanmax(np.abs(t), axis=1, initial=0.0)
    else:
        far = [np.nanmax(np.abs(t[0, a:b]), initial=0.0) for a, b in pairwise(runs.tolist())]
    if np.any(growth * far > _MOST_GROWTH):
        rate = float(np.max(growth))
        raise AttitudeError(
            f"an epoch lies {np.max(far):.3g} s from that of the state; this rotation about its "
            f"middle axis is unstable and multiplies errors by e every {1.0 / rate:.3g} s. Give "
            f"epochs within {_MOST_GROWTH / rate:.3g} s."
        )


@cache
def _short():
    with uncollected():
        from attitude._solver import short_times

    return short_times


@cache
def _order():
    """The rows of the weights in the order in which columns lose them."""
    with uncollected():
        from attitude._solver import columns

    return list(columns.ORDER)


@cache
def _compiled(uniform):
    """Set-up of uniform, or of other, motions, and the loops of each form."""
    with uncollected():
        from attitude._solver import sensitivity

    if uniform:
        return (
            sensitivity.uniform_setup,
            {codes.UNIFORM: sensitivity.uniform},
            {codes.UNIFORM: sensitivity.uniform_covariance},
        )
    return (
        sensitivity.tumbling_setup,
        {
            codes.TRIGONOMETRIC: sensitivity.trigonometric,
            codes.HYPERBOLIC: sensitivity.hyperbolic,
        },
        {
            codes.TRIGONOMETRIC: sensitivity.trigonometric_covariance,
            codes.HYPERBOLIC: sensitivity.hyperbolic_covariance,
        },
    )
