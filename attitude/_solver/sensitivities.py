"""How attitudes depend on the initial state and the inertia: derivatives, errors, samples."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cache, cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._compilation.deferral import uncollected
from attitude._compilation.simd import LINE
from attitude._solver import codes, covariance, evaluation
from attitude._solver.elements import tangents_by_elements
from attitude._solver.records import BLOCK, COLUMNS, ROWS, TANGENTS
from attitude._support import pairs
from attitude._support.arrays import frozen, new_array, read_only
from attitude._support.pairs import Seconds
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
# The epoch of the state, of one body.
_EPOCH = frozen(np.zeros((1, 1)))
# Power of two of the largest rate, rad/s, beyond which terms of the third order, and products of
# two of them, leave the range of doubles.
_LARGEST_TEMPO = 300
# Growth of a rotation about an unstable axis, as a power of e, beyond which squares overflow.
_MOST_GROWTH = 280.0


def tangents_of(
    moments: FloatArray, wxyz: FloatArray, principal: FloatArray, constants: NDArray[Any]
) -> NDArray[Any]:
    """Derivatives of the elements of B motions; AttitudeError where there are none: `why_none`."""
    lacking = without_derivatives(moments, constants)
    if len(lacking):
        raise AttitudeError(why_none(moments[lacking[0]]))
    return tangents_of_all(moments, wxyz, principal, constants)


def tangents_of_all(
    moments: FloatArray, wxyz: FloatArray, principal: FloatArray, constants: NDArray[Any]
) -> NDArray[Any]:
    """The derivatives of the elements of B motions, constants (B,), all of which have some."""
    tangents = np.zeros(len(constants), TANGENTS)
    arrays = [evaluation.writable(array) for array in (moments, wxyz, principal, constants)]
    forms = set(constants["form"].tolist())
    if codes.UNIFORM in forms:
        _compiled()[0].uniform_setup(*arrays, tangents)
    if forms != {codes.UNIFORM}:
        _compiled()[0].tumbling_setup(*arrays, tangents, np.empty(ROWS * BLOCK))
    return tangents


def without_derivatives(moments: FloatArray, constants: NDArray[Any]) -> IntArray:
    """Numbers (K,) of the motions, moments (B, 3, 2), that are refused; see `why_none`."""
    is_extreme = np.abs(constants["tempo"]) > _LARGEST_TEMPO
    return np.flatnonzero(is_extreme | np.any(moments[:, :, 0] == 0.0, axis=1))


def why_none(moments: FloatArray) -> str:
    """The sentence on a motion without derivatives, moments (3, 2)."""
    if moments[:, 0].all():
        return (
            "products of its rates leave the range of doubles; sensitivities need a largest rate "
            "between 1e-90 and 1e90 rad/s, or a body at rest."
        )
    return (
        f"moments are {moments[:, 0].tolist()}; sensitivities need three moments above zero: the "
        "rotation of an ideal rod about itself is undefined."
    )


def evaluate(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    t: FloatArray,
    t_low: FloatArray | None,
    attitude: FloatArray,
    omega: FloatArray | None = None,
    *,
    edges: IntArray | None = None,
    factors: FloatArray | None = None,
) -> None:
    """As `evaluate_all`; AttitudeError for a body with an epoch beyond its reach."""
    arrays = attitude, omega
    body = evaluate_all(constants, tangents, t, t_low, *arrays, edges=edges, factors=factors)
    _refuse(constants, tangents, body, t, t_low, edges)


def evaluate_all(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    t: FloatArray,
    t_low: FloatArray | None,
    attitude: FloatArray,
    omega: FloatArray | None = None,
    *,
    edges: IntArray | None = None,
    all_digits: bool = True,
    factors: FloatArray | None = None,
) -> int:
    """Fill attitude, omega (B, 3, P, T) with derivatives of B motions at t, t_low (1 or B, T).

    Returns -1, or the number of a body with an epoch beyond its reach; then not all are filled.

    edges: (B + 1,), of rows (1, R) of epochs, of which those of a body stand between two edges.
    all_digits: whether columns have all digits near the epoch of the state, by series; otherwise
        those of their terms, and series only where these cancel to 4e-12.
    factors: as in `Factored`, with the tangents of that; None: of the parameters themselves.
    """
    short = _short_of(constants, tangents, t, edges, omega is not None, all_digits, factors)
    return _in_blocks(constants, tangents, short, t, t_low, 0, (attitude, omega), edges)


def refusal(
    constants: NDArray[Any],
    tangents: NDArray[Any] | None,
    body: int,
    t: FloatArray,
    t_low: FloatArray | None,
) -> str:
    """The sentence on one of B motions and epochs (T,) of which one is beyond its reach; with
    tangents, beyond that of its derivatives.
    """
    if tangents is not None:
        far = np.nanmax(np.abs(Seconds(t, t_low).rounded), initial=0.0)
        if far > reaches(tangents)[body]:
            rate = float(_growth(tangents)[body])
            return (
                f"an epoch lies {far:.3g} s from that of the state; this rotation about its middle "
                f"axis is unstable and multiplies errors by e every {1.0 / rate:.3g} s. Give "
                f"epochs within {_MOST_GROWTH / rate:.3g} s."
            )
    return evaluation.refusal(constants[body], t, t_low)


def _refuse(constants, tangents, body, t, t_low, edges=None):
    """Raise the AttitudeError of a body with an epoch beyond its reach, unless its number is -1."""
    if body >= 0:
        few = slice(None) if edges is None else slice(edges[body], edges[body + 1])
        few = body if len(t) > 1 else 0, few
        raise AttitudeError(refusal(constants, tangents, body, *Seconds(t, t_low).taken(few)))


class Factored(NamedTuple):
    """What `covariances` needs of B motions and the covariances of their parameters.

    tangents: of parameters of which the given ones are combinations by the factors.
    """

    factors: FloatArray  # (B, 9, 9), W of covariances W W^T; W^T makes columns triangular
    tangents: NDArray[Any]  # (B,)


def factored(constants: NDArray[Any], tangents: NDArray[Any], factors: FloatArray) -> Factored:
    """The `Factored` of motions for factors W (B, 9, 9) of covariances W W^T."""
    turned, order = factors.copy(), list(_compiled()[2].ORDER)
    members = np.flatnonzero(constants["form"] != codes.UNIFORM)
    if members.size:
        weights, offset = tangents["weights"][members], tangents["offset"][members]
        stacked = np.concatenate([weights[:, order], offset], axis=1) @ factors[members]
        turns = np.linalg.qr(np.swapaxes(stacked, 1, 2), mode="complete")[0]
        turned[members] = factors[members] @ turns
    mixed = _mixed(tangents, turned)
    for column, row in enumerate(order):  # what is zero but for rounding
        mixed["weights"][members, row, column + 1 :] = 0.0
    return Factored(turned, mixed)


def covariances(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    of: Factored,
    t: FloatArray,
    t_low: FloatArray | None,
    out: FloatArray,
) -> None:
    """Fill out (B, 3, 3, T) with the covariances of B motions at given epochs."""
    short = _short_of(constants, tangents, t, None, out.shape[1] == 6, True, of.factors)
    body = _in_blocks(constants, of.tangents, short, t, t_low, 1, (out, out), None)
    _refuse(constants, of.tangents, body, t, t_low)


def _short_of(constants, tangents, t, edges, rates, every, factors):
    """The series of motions with epochs near that of the state, and their numbers (B,); -1: none.

    Those of every motion, or of those whose terms cancel; of parameters of which the ones of the
    state are combinations by `factors` (B, 9, 9), if given.
    """
    loops, count, span = _compiled()[1], len(constants), np.empty(len(constants))
    constants, tangents = evaluation.writable(constants), evaluation.writable(tangents)
    loops.spans_of(constants, span)
    of_terms = tangents["spans"][:, 0 if every else 1]
    few = np.flatnonzero((of_terms == 0) & (constants["form"] != codes.UNIFORM) & every)
    speed = np.linalg.norm(constants["omega"][few, :, 0], axis=1)
    span[few] = np.minimum(span[few], np.ldexp(1.0 / speed, -constants["tempo"][few]))
    most = np.maximum(of_terms, 1)
    reach = np.empty(count)
    loops.reaches(tangents, span * most, reach)
    if not every:
        few = (constants["form"] != codes.UNIFORM) & (of_terms == 0)
        reach[few & (tangents["slow"][:, 0] == 0.0)] = -1.0
    farthest, numbers = np.empty((count, 2)), np.full(count, -1)
    every_epoch = _edges(edges, count, 0, t.shape[1])
    loops.farthest_near(read_only(t), every_epoch, reach, farthest)
    if not np.any(farthest >= 0.0 if rates else farthest > 0.0):
        return np.empty(0, loops.SHORT), numbers
    # series reach as far as the epochs on each side; motions without such epochs have none
    chosen = np.flatnonzero(np.any(farthest >= 0.0, axis=1))
    steps = np.ceil(farthest[chosen] / np.maximum(span[chosen, None], 1e-300))
    spans = np.clip(steps, 1, most[chosen, None]).astype(np.int64)
    short = np.zeros(len(chosen) + int(np.sum(spans - 1)), loops.SHORT)
    loops.short_setup(constants, tangents, chosen, span, spans, short)
    if factors is not None:
        turned = np.moveaxis(factors, 1, 2)[short["motion"]]
        short["series"] = turned[:, None] @ short["series"]
    numbers[chosen] = np.arange(len(chosen))
    return short, numbers


def _mixed(tangents, factors):
    """The records for parameters of which the given ones are linear combinations."""
    mixed = evaluation.copy_of(tangents)
    for name in ("weights", "offset", "amplitudes"):
        mixed[name] = tangents[name] @ factors
    for name in ("uniform", "uniform_rates"):
        mixed[name] = tangents[name] @ factors[:, None]
    return mixed


def _in_blocks(constants, tangents, short, t, t_low, kind, outputs, runs):
    """Call the loops of each form, so many epochs at a time that Ctrl-C is heard; -1, or a body
    with an epoch beyond its reach.  `short`: as of `_short_of`.
    """
    body = _first_that_overflows(tangents, t, t_low, runs)
    if body >= 0:
        return body
    constants, tangents = evaluation.writable(constants), evaluation.writable(tangents)
    t, t_low = read_only(t), _NO_LOW if t_low is None else read_only(t_low)
    block = np.empty(ROWS * BLOCK)
    forms = set(constants["form"].tolist())
    for edges in _parts(runs, len(constants), t.shape[1]):
        for form in forms:
            loop = _compiled()[0].OF_FORM[form][kind]
            body = loop(constants, tangents, *short, t, t_low, block, *outputs, edges)
            if body >= 0:
                return body
    return -1


def _parts(runs, bodies, count):
    """Edges (B, 2) of the epochs of each body, for each call of a loop."""
    size = max(evaluation.EPOCHS // (4 * max(bodies, 1)), 1) if runs is None else max(count, 1)
    for first in range(0, count, size):
        yield _edges(runs, bodies, first, min(first + size, count))


def _edges(runs, bodies, first, end):
    """Edges (B, 2) of the epochs of each body: of its run, or from the first to the end."""
    if runs is None:
        return np.full((bodies, 2), (first, end), dtype=np.int64)
    return np.stack([runs[:-1], runs[1:]], axis=1)


def reaches(tangents: NDArray[Any]) -> FloatArray:
    """The largest |t| (B,), s, to which derivatives of motions stay in the range of doubles."""
    growth = _growth(tangents)
    with np.errstate(divide="ignore"):
        return np.where(growth > 0.0, _MOST_GROWTH / growth, np.inf)


def _growth(tangents):
    """The rates (B,), 1/s, at which rotations about an unstable axis multiply errors by e."""
    return 4.0 * np.pi * tangents["wobble"][:, 0] * tangents["grows"]


def _first_that_overflows(tangents, t, t_low, runs):
    """The number of the first body whose derivatives overflow at an epoch, or -1."""
    if not np.any(tangents["grows"]):
        return -1
    reach = reaches(tangents)
    far = np.abs(Seconds(t, t_low).rounded)
    if runs is None:
        far = np.nanmax(far, axis=1, initial=0.0)
    else:
        far = [np.nanmax(far[0, a:b], initial=0.0) for a, b in pairwise(runs.tolist())]
    beyond = np.flatnonzero(far > reach)
    return int(beyond[0]) if len(beyond) else -1


# ---- Derivatives and covariances of the attitudes of one free rotation


class Derivatives(ABC):
    """The derivatives of a motion at any epoch, and the covariances that follow from them."""

    @abstractmethod
    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9), ICRF axes, and of the angular velocity, body axes."""

    @abstractmethod
    def by_elements(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """As `at`, (S, 3, 8), by the first attitude and the elements at the epoch."""

    def covariance_at(
        self, of_state: FloatArray, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> FloatArray:
        """Covariances (S, 3, 3) of the attitude, or (S, 6, 6), from that (9, 9) of the state."""
        attitude, omega = self.at(seconds, low, rates)
        both = attitude if omega is None else np.concatenate([attitude, omega], axis=-2)
        factored = both @ covariance.factor(of_state)
        return factored @ np.swapaxes(factored, -1, -2)


class Sensitivity(Derivatives):
    """The derivatives of one motion, with the arguments of `tangents_of`, at any epoch."""

    def __init__(
        self,
        moments: FloatArray,
        wxyz: FloatArray,
        principal: FloatArray,
        constants: NDArray[Any],
    ) -> None:
        self._constants = constants
        self._tangents = tangents_of(moments, wxyz, principal, constants)
        self._last: tuple[FloatArray, Factored] | None = None

    def _factored(self, of_state: FloatArray) -> Factored:
        """The factors for a covariance (9, 9); those of the last one are kept."""
        last = self._last
        if last is None or not np.array_equal(last[0], of_state):
            factors = covariance.factor(of_state)[None]
            last = of_state.copy(), factored(self._constants, self._tangents, factors)
            self._last = last
        return last[1]

    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9), ICRF axes, and of the angular velocity, body axes."""
        return self._columns(self._tangents, None, seconds, low, rates)

    def _columns(self, tangents, factors, seconds, low, rates):
        t, t_low = pairs.rows(seconds, low)
        attitude = new_array(1, 3, 9, t.size)
        omega = new_array(1, 3, 9, t.size) if rates else None
        evaluate(self._constants, tangents, t, t_low, attitude, omega, factors=factors)
        shape = (*seconds.shape, 3, 9)
        changes = np.moveaxis(attitude[0], -1, 0).reshape(shape)
        return changes, None if omega is None else np.moveaxis(omega[0], -1, 0).reshape(shape)

    def by_elements(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """As `Derivatives.by_elements`."""
        of = self.of_elements
        attitude, omega = self._columns(of.tangents, of.factors, seconds, low, rates)
        return attitude[..., :8], None if omega is None else omega[..., :8]

    @cached_property
    def of_elements(self) -> Factored:
        """The `Factored` whose parameters are the first attitude, the elements, and nothing."""
        of = tangents_by_elements(self._constants[0])
        tangents = evaluation.copy_of(self._tangents)
        record, factors = tangents[0], np.eye(9)[None]
        for name in ("weights", "amplitudes", "offset"):
            record[name][:, 3:] = 0.0
        record["weights"][:, 3:8], record["amplitudes"][:, 3:8] = of.weights, of.amplitudes
        record["by_third"], record["spans"] = of.by_third, 0
        # the state by the elements, without series: from the columns at the epoch
        columns = np.empty((2, 1, 3, 9, 1))
        none = np.empty(0, _compiled()[1].SHORT), np.full(1, -1)
        _in_blocks(self._constants, tangents, none, _EPOCH, None, 0, columns, None)
        record["offset"][:, 3:] = -columns[0, 0, :, 3:, 0]
        factors[0, 3:, 3:] = 0.0
        factors[0, 3:6, 3:8] = columns[1, 0, :, 3:8, 0]
        moments = 1.0 / (record["inverse"] * record["moment_unit"])
        factors[0, 6:, 3:8] = moments[:, None] * of.log_moments
        return Factored(factors, tangents)

    def covariance_at(
        self, of_state: FloatArray, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> FloatArray:
        """As `Derivatives.covariance_at`, in one loop over the epochs."""
        t, t_low = pairs.rows(seconds, low)
        size = 6 if rates else 3
        # Rows of whole lines of the cache are stored faster.
        out = new_array(1, size, size, -(-t.size // LINE) * LINE)
        of = self._factored(of_state)
        covariances(self._constants, self._tangents, of, t, t_low, out)
        filled: FloatArray = np.moveaxis(out[0, ..., : t.size], -1, 0)
        return filled.reshape(*seconds.shape, size, size)


@cache
def _compiled():
    """The modules of set-up and loops, of series for short times, and of columns."""
    with uncollected():
        from attitude._solver import columns, sensitivity_loops, short_times

    return sensitivity_loops, short_times, columns
