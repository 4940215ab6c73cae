"""States of B bodies: constants, and attitudes and derivatives at epochs, by blocks and threads."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from attitude._compilation.deferral import uncollected
from attitude._solver import codes, evaluation, sensitivities
from attitude._solver.principal_axes import ASYMMETRY, PrincipalAxes
from attitude._solver.series import LONGEST
from attitude._support import validation
from attitude._support.arrays import read_only
from attitude._support.blocks import ProgressBar, in_blocks, in_rectangles
from attitude._support.pairs import Seconds
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray


# The constants of so many bodies are computed together: they stay in the second-level cache.
BLOCK = 512
IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])
# Mode of a state that is not physical.
NO_MODE = -1
_NONE: IntArray = np.zeros(0, dtype=np.int64)


# ---- States, and their constants


class Solved:
    """Constants of B states, and the arrays from which they were computed.

    constants: (B,) of records.CONSTANTS, which evaluate to NaN for states that are not physical.
    moments, omega: (B, 3, 2), principal moments, and rad/s over the principal axes, in pairs.
    wxyz: (B, 4), attitudes of the given body axes.
    principal: (1 or B, 4), unit quaternions from principal to body axes.
    bad: (K,), numbers of the states that are not physical.
    """

    # written out: dataclass takes a millisecond of each import
    __slots__ = "bad", "constants", "moments", "omega", "principal", "wxyz"

    def __init__(
        self,
        constants: NDArray[Any],
        moments: FloatArray,
        omega: FloatArray,
        wxyz: FloatArray,
        principal: FloatArray,
        bad: IntArray,
    ) -> None:
        self.constants, self.moments, self.omega = constants, moments, omega
        self.wxyz, self.principal, self.bad = wxyz, principal, bad

    def prepared(self, numbers: range | IntArray, *, rates: bool = True) -> Solved:
        """Some of them; the constants have the series of the angular velocity."""
        which = _index(numbers)
        constants = self.constants[which]
        bad = np.flatnonzero(constants["fault"]) if len(self.bad) else self.bad
        moments, omega, wxyz = self.moments[which], self.omega[which], self.wxyz[which]
        return Solved(constants, moments, omega, wxyz, _some(self.principal, which), bad)

    def fault(self, k: int) -> str:
        """The sentence on state k, which is not physical."""
        return evaluation.fault_of(self.constants[k], self.moments[k], self.wxyz[k], self.omega[k])


class Source(Protocol):
    """What has the constants of states: `States`, `StatesOfTensors`, `Solved`."""

    def prepared(self, numbers: range | IntArray, *, rates: bool = True) -> Solved:
        """The constants of some states, those of the angular velocity only with rates."""


@dataclass(slots=True, eq=False)
class States:
    """States of B bodies, as the compiled solution takes them.

    The last axis of moments and omega may have pairs of doubles; without it second ones are zero.
    """

    moments: FloatArray  # (1 or B, 3) or (1 or B, 3, 2), principal moments
    principal: FloatArray  # (1 or B, 4), unit quaternions from principal to body axes
    omega: FloatArray  # (B, 3) or (B, 3, 2), rad/s over the principal axes
    differences: FloatArray | None  # (B, 3, 2), see `PrincipalAxes.over_axes`; NaN: none
    wxyz: FloatArray  # (B, 4), attitudes of the body axes
    low: FloatArray | None = None  # (B, 4), their second doubles; None if all are zero

    @classmethod
    def of_principal_axes(cls, moments: FloatArray, omega: FloatArray) -> States:
        """States over the principal axes, in inertial axes at first; moments, omega as above."""
        # of one state without a broadcast, which takes three microseconds
        wxyz = IDENTITY if len(omega) == 1 else np.broadcast_to(IDENTITY, (len(omega), 4))
        return cls(moments, IDENTITY, omega, None, wxyz)

    def __len__(self) -> int:
        """The number of states."""
        return self.wxyz.shape[0]

    def taken(self, index: Any) -> States:
        """Some of the states."""
        return States(
            _some(self.moments, index),
            _some(self.principal, index),
            self.omega[index],
            None if self.differences is None else self.differences[index],
            self.wxyz[index],
            None if self.low is None else self.low[index],
        )

    def pairs(self) -> tuple[FloatArray, FloatArray]:
        """Moments and angular velocities (B, 3, 2)."""
        moments, omega = self.moments, self.omega
        if moments.ndim == 2 or len(moments) < len(omega):
            moments = _in_pairs(moments, len(omega))
        return moments, _in_pairs(omega, len(omega)) if omega.ndim == 2 else omega

    def prepared(self, numbers: range | IntArray, *, rates: bool = True) -> Solved:
        """The constants of some states, those of the angular velocity only with rates."""
        # the one of one without slices, which take a microsecond
        states = self if len(self.wxyz) == 1 else self.taken(_index(numbers))
        return states.solved(rates=rates)

    def solved(self, *, rates: bool = True) -> Solved:
        """The constants of all states at once, those of the angular velocity only with rates."""
        moments, omega = self.pairs()
        constants, faults = evaluation.prepared(
            moments,
            self.wxyz,
            omega,
            self.principal,
            differences=self.differences,
            rates=rates,
            wxyz_low=self.low,
        )
        bad = _NONE
        if faults:
            bad = np.flatnonzero(constants["fault"])
            for name in ("frame", "rates", "psi_rate", "phi_rate"):
                constants[name][bad] = np.nan
            constants["form"][bad], constants["mode"][bad] = codes.UNIFORM, NO_MODE
        return Solved(constants, moments, omega, self.wxyz, self.principal, bad)

    def faults(self) -> IntArray:
        """Numbers (K,) of the states that are not physical."""
        bad_states = [_NONE]
        for first in range(0, len(self), BLOCK):
            states = self.taken(slice(first, first + BLOCK))
            moments, omega = states.pairs()
            bad = evaluation.faults_of(moments, states.wxyz, omega)
            if len(bad):
                bad_states.append(bad + first)
        return np.concatenate(bad_states)

    def fault(self, k: int) -> str:
        """The sentence on state k, which is not physical."""
        return self.taken(slice(k, k + 1)).solved().fault(0)


class StatesOfTensors(NamedTuple):
    """States of B bodies over axes that are not principal; these are found block by block."""

    tensors: FloatArray  # (B, 3, 3), whose doubles are exact
    wxyz: FloatArray  # (B, 4)
    omega: FloatArray  # (B, 3), rad/s over the body axes

    def prepared(self, numbers: range | IntArray, *, rates: bool = True) -> Solved:
        """The constants of some states, those of the angular velocity only with rates."""
        which = _index(numbers)
        tensors = symmetric_tensors(self.tensors[which], int(numbers[0]), len(self.tensors))
        axes = PrincipalAxes.of(tensors)
        over_axes = axes.over_axes(evaluation.writable(self.omega[which]))
        states = States(axes.moments, axes.wxyz, *over_axes, self.wxyz[which])
        return states.solved(rates=rates)


def joined(parts: Sequence[States]) -> States:
    """The states of several parts, one after the other."""
    counts = [len(states) for states in parts]

    def rows(arrays: Sequence[FloatArray]) -> FloatArray:
        first = arrays[0]
        if len(first) == 1 and all(array is first for array in arrays):
            return first
        return spread_rows(arrays, counts)

    rates = [states.omega for states in parts]
    if len({omega.ndim for omega in rates}) > 1:
        rates = [_in_pairs(omega, len(omega)) for omega in rates]
    differences = None
    if any(states.differences is not None for states in parts):
        unknown = [np.full((n, 3, 2), np.nan) for n in counts]
        both = zip((states.differences for states in parts), unknown, strict=True)
        differences = np.concatenate([b if a is None else a for a, b in both])
    return States(
        rows([states.moments for states in parts]),
        rows([states.principal for states in parts]),
        np.concatenate(rates),
        differences,
        np.concatenate([states.wxyz for states in parts]),
        joined_rows([(states.low, states.wxyz) for states in parts]),
    )


def spread_rows(arrays: Sequence[NDArray[Any]], counts: Sequence[int]) -> NDArray[Any]:
    """Arrays (1 or N, ...), each spread to the rows of its part, one after the other."""
    parts = zip(arrays, counts, strict=True)
    return np.concatenate([np.broadcast_to(a, (n, *a.shape[1:])) for a, n in parts])


def joined_rows(parts: Sequence[tuple[FloatArray | None, FloatArray]]) -> FloatArray | None:
    """Joined low parts, zero where a part has None; None if all are.  With arrays of the shapes."""
    if all(low is None for low, _ in parts):
        return None
    return np.concatenate([np.zeros_like(high) if low is None else low for low, high in parts])


def symmetric_tensors(
    tensors: FloatArray, first: int = 0, count: int = 1, *, raises: bool = True
) -> FloatArray:
    """Tensors (B, 3, 3) without the rounding of their asymmetry."""
    across = np.swapaxes(tensors, 1, 2)
    with np.errstate(invalid="ignore", over="ignore"):
        off, largest = (np.abs(array).max(axis=(1, 2)) for array in (tensors - across, tensors))
        mean = 0.5 * (tensors + across)
    # one that is not finite, or of which sums overflow
    bad = ~(off <= ASYMMETRY * largest) | ~np.isfinite(mean).all(axis=(1, 2))
    if bad.any() and not raises:
        mean[bad] = np.diag([np.nan] * 3)
        np.copyto(mean, 0.0, where=bad[:, None, None] & ~np.eye(3, dtype=bool))
    elif bad.any():
        k = int(np.flatnonzero(bad)[0])
        where = f"Tensor {first + k} of {count}" if count > 1 else "The tensor"
        raise AttitudeError(
            f"{where} is {tensors[k].tolist()}; give symmetric matrices of finite numbers "
            "(products of inertia with a minus sign), up to 8e307."
        )
    return np.ascontiguousarray(mean)


def _some(array, which):
    """Rows of some states, or the one of all."""
    return array if len(array) == 1 else array[which]


def _index(numbers):
    """Numbers (K,), K >= 1, as a slice if each is one more than the last: arrays need no copy."""
    first, end = int(numbers[0]), int(numbers[-1]) + 1
    if isinstance(numbers, range):
        return slice(first, end)
    if end - first == len(numbers) and (end == first + 1 or (numbers[1:] > numbers[:-1]).all()):
        return slice(first, end)
    return numbers


def _in_pairs(array, count):
    """Numbers (1 or B, 3), or pairs of doubles of them, as new pairs (B, 3, 2) of B states."""
    pairs = np.zeros((count, 3, 2))
    if array.ndim == 3:
        pairs[:] = array
    else:
        pairs[..., 0] = array
    return pairs


# ---- Attitudes and derivatives at epochs

# Rows in a piece of work: a millisecond, and 0.15 s if each row is of another member.
ROWS = 1 << 17
# Epochs of derivatives in a piece of work: some milliseconds.
_ROWS_OF_COLUMNS = 1 << 15
# Numbers of members that are surveyed or sorted in one call of compiled code.
_SURVEYED = 1 << 19
# Unsorted rows are brought into runs unless their runs are at least as long in the mean: a set-up
# takes as long as some 100 rows, sorting a row as long as 2 to 4.
_LONG_RUN = 64


class Results(NamedTuple):
    """Arrays to be filled, of B states at T epochs each; None for what is not computed.

    Of R rows, each of one state: (4, R), (3, R), (3, 9, R).  `sensitivities` has the 9 parameters.
    """

    wxyz: FloatArray | None = None  # (B, 4, T), attitudes, body to inertial
    rates: FloatArray | None = None  # (B, 3, T), angular velocities, rad/s over the body axes
    columns: FloatArray | None = None  # (B, 3, 9, T), derivatives of attitudes
    rate_columns: FloatArray | None = None  # (B, 3, 9, T), of angular velocities

    def mapped(self, function: Callable[[FloatArray], FloatArray]) -> Results:
        """Those arrays after a function of each."""
        return Results(*[None if array is None else function(array) for array in self])


class Evaluation:
    """Attitudes and derivatives of states at epochs.

    raises: whether states that are not physical or, of derivatives, rods, and epochs beyond the
        reach of a state are refused; otherwise they give NaN.
    """

    __slots__ = "all_digits", "label", "raises", "source"

    def __init__(
        self,
        source: Source,
        label: Callable[[int], str] = lambda k: "",
        raises: bool = True,
        all_digits: bool = True,
    ) -> None:
        self.source = source
        self.label = label  # name of a state in errors, by its number; empty for one state
        self.raises = raises
        self.all_digits = all_digits  # as in `sensitivities.evaluate_all`

    def grid(self, t: Seconds, out: Results, threads: int = 1, first: int = 0) -> None:
        """Fill results of B states, from number `first` on, at T epochs each; t (1 or B, T)."""
        only_columns = out.wxyz is None
        largest = out.columns if only_columns else out.wxyz
        assert largest is not None
        count, length = len(largest), t.hi.shape[1]
        if not count:
            return
        if threads != 1:
            threads = validation.count(threads, "threads")
        rows = _ROWS_OF_COLUMNS if only_columns else evaluation.EPOCHS
        if count <= BLOCK and count * length <= rows:
            # nothing to divide: one body at one epoch takes half the time without slices
            self._fill(range(first, first + count), t, out, (0, length))
            return

        def work(numbers: slice, epochs: tuple[int, int]) -> None:
            times = t.taken(numbers) if len(t.hi) > 1 else t
            arrays = out.mapped(lambda array: array[numbers])
            self._fill(range(first + numbers.start, first + numbers.stop), times, arrays, epochs)

        # A piece of work is some milliseconds long, and writes to few pages of memory.
        span = evaluation.EPOCHS if out.columns is None else max(length, 1)
        bar = ProgressBar("derivatives" if only_columns else "attitudes")
        in_rectangles(work, count, length, BLOCK, span, rows, threads, bar)

    def rows(
        self, member: IntArray, t: Seconds, order: IntArray | None, out: Results, threads: int = 1
    ) -> None:
        """Fill results of R rows at t (R,), each of the state member (R,).

        Rows of one state stand together, or do so in `order` (R,).
        """
        if not len(member):
            return

        def direct(begin: int, end: int) -> None:
            self.runs(member, begin, end, t, out)

        def gathered(begin: int, end: int) -> None:
            assert order is not None
            some = read_only(order[begin:end])
            copies = out.mapped(lambda array: np.empty((*array.shape[:-1], len(some))))
            self.runs(member[some], 0, len(some), t.taken(some), copies)
            for whole, copy in zip(out, copies, strict=True):
                if whole is not None and copy is not None:
                    numbers = whole.reshape(-1, len(member))
                    assert np.shares_memory(numbers, whole)
                    compiled().scattered(copy.reshape(-1, len(some)), some, numbers)

        bar = ProgressBar("rows")
        in_blocks(direct if order is None else gathered, len(member), ROWS, threads, bar)

    def runs(self, member: IntArray, begin: int, end: int, t: Seconds, out: Results) -> None:
        """Fill the rows from `begin` to `end`, of which those of one state stand together."""
        times, arrays = t.mapped(read_only).taken(None), out.mapped(lambda array: array[None])
        for numbers, edges in blocks_of_runs(member, begin, end):
            self._fill(numbers, times, arrays, edges)

    def reachable(
        self,
        failed: int,
        solved: Solved,
        numbers: range | IntArray,
        t: Seconds,
        edges: IntArray | None,
        tangents: NDArray[Any] | None = None,
    ) -> Seconds:
        """The epochs of a block with NaN for those beyond the reach of a state, unless refused.

        failed: number in the block of a state with such an epoch.
        numbers: of the states of the block.  edges: as in `sensitivities.evaluate`.
        """
        if self.raises:
            line = failed if len(t.hi) > 1 else 0
            span = slice(None) if edges is None else slice(edges[failed], edges[failed + 1])
            few = t.taken((line, span))
            sentence = sensitivities.refusal(solved.constants, tangents, failed, *few)
            self._refuse(int(numbers[failed]), sentence)
        reach = reaches(solved.constants)
        if tangents is not None:
            reach = np.fmin(reach, sensitivities.reaches(tangents))
        return _within(t, reach, edges)

    def _refuse(self, number: int, sentence: str) -> None:
        label = self.label(number)
        raise AttitudeError(f"{label}: {sentence}" if label else sentence)

    def prepared(self, numbers: range | IntArray, *, rates: bool = False) -> Solved:
        """The constants of some states, those of the angular velocity only with rates."""
        solved = self.source.prepared(numbers, rates=rates)
        if self.raises and len(solved.bad):
            k = int(solved.bad[0])
            self._refuse(int(numbers[k]), solved.fault(k))
        return solved

    def _fill(
        self,
        numbers: range | IntArray,
        t: Seconds,
        out: Results,
        span: tuple[int, int] | IntArray,
    ) -> None:
        """Fill results of a block of states at a span of epochs, or at rows between edges."""
        rates = out.rates is not None or out.rate_columns is not None
        solved = self.prepared(numbers, rates=rates)
        edges = None if isinstance(span, tuple) else span
        if out.wxyz is not None:
            failed = _attitudes(solved, t, out.wxyz, out.rates, span)
            if failed >= 0:
                times = self.reachable(failed, solved, numbers, t, edges)
                _attitudes(solved, times, out.wxyz, out.rates, span)
        if out.columns is not None:
            tangents = self._tangents(solved, numbers)
            records, arrays = (solved.constants, tangents), (out.columns, out.rate_columns)
            options: dict[str, Any] = {"edges": edges, "all_digits": self.all_digits}
            failed = sensitivities.evaluate_all(*records, *t, *arrays, **options)
            if failed >= 0:
                times = self.reachable(failed, solved, numbers, t, edges, tangents)
                sensitivities.evaluate_all(*records, *times, *arrays, **options)

    def _tangents(self, solved: Solved, numbers: range | IntArray) -> NDArray[Any]:
        """The derivatives of the elements of a block of states."""
        moments, wxyz, principal = solved.moments, solved.wxyz, solved.principal
        unknown = sensitivities.without_derivatives(moments, solved.constants)
        if self.raises and len(unknown):
            k = int(unknown[0])
            self._refuse(int(numbers[k]), sensitivities.why_none(moments[k]))
        if len(solved.bad):
            unknown = np.union1d(unknown, solved.bad)
        if len(unknown):
            moments = moments.copy()
            moments[unknown] = 1.0
        tangents = sensitivities.tangents_of_all(moments, wxyz, principal, solved.constants)
        if len(unknown):
            for name in (
                "weights",
                "offset",
                "amplitudes",
                "uniform",
                "uniform_rates",
                "principal",
            ):
                tangents[name][unknown] = np.nan
        return tangents


def _attitudes(solved, t, wxyz, rates, span):
    """Fill attitudes, rates of a block of states; -1, or a state with an epoch beyond its reach."""
    if isinstance(span, tuple):
        return evaluation.evaluate_all(solved.constants, t.hi, t.lo, wxyz, rates, *span)
    records = read_only(solved.constants)
    return compiled().evaluate_runs(records, span, t.hi, t.lo, wxyz, rates)


def blocks_of_runs(member: IntArray, begin: int, end: int) -> Iterator[tuple[IntArray, IntArray]]:
    """Numbers (K,) of a block of states whose rows stand together, and their first rows and the
    end (K + 1,), of the rows from `begin` to `end`.
    """
    who, starts = runs_of(member, begin, end)
    for first in range(0, len(who), BLOCK):
        numbers = who[first : first + BLOCK]
        yield numbers, starts[first : first + len(numbers) + 1]


def runs_of(member: IntArray, begin: int, end: int) -> tuple[IntArray, IntArray]:
    """The number (K,) of each run of rows, and their first rows and the end (K + 1,)."""
    who = np.empty(end - begin, dtype=np.int64)
    starts = np.empty(end - begin + 1, dtype=np.int64)
    count = compiled().runs_of(read_only(member), begin, end, who, starts)
    return who[:count], starts[: count + 1]


def survey(member: IntArray) -> tuple[int, int, bool]:
    """Least and greatest of R >= 1 numbers, and whether equal ones stand in long runs already."""
    parts = _surveyed(member)
    runs = np.array([compiled().surveyed(block) for block in parts])
    ascends = not runs[:, 3].any() and all(a[-1] <= b[0] for a, b in pairwise(parts))
    in_runs = ascends or len(member) >= _LONG_RUN * int(runs[:, 2].sum())
    return int(runs[:, 0].min()), int(runs[:, 1].max()), in_runs


def order_of(member: IntArray, count: int) -> IntArray:
    """The order in which rows (R,) stand by member."""
    places = np.zeros(count + 1, dtype=np.int64)
    for block in _surveyed(member):
        compiled().counted(block, places[1:])
    np.cumsum(places, out=places)
    order = np.empty(len(member), dtype=np.int64)
    for k, block in enumerate(_surveyed(member)):
        compiled().placed(block, k * _SURVEYED, places, order)
    return order


def _surveyed(member: IntArray) -> list[IntArray]:
    """Parts so short that Ctrl-C is heard between them."""
    numbers = read_only(member)
    return [numbers[k : k + _SURVEYED] for k in range(0, len(numbers), _SURVEYED)]


def reaches(constants: NDArray[Any]) -> FloatArray:
    """The largest |t| (B,), s, at which two doubles resolve the phases of motions."""
    phases = (np.abs(constants[name][:, 0]) for name in ("precession", "nutation"))
    with np.errstate(divide="ignore", over="ignore"):
        return np.minimum(LONGEST / np.maximum(*phases), np.finfo(float).max)


def _within(t: Seconds, reach: FloatArray, edges: IntArray | None) -> Seconds:
    """Epochs with NaN in place of those beyond the reach (B,) of a state."""
    rows = slice(None) if edges is None else slice(edges[0], edges[-1])
    far = reach[:, None] if edges is None else np.repeat(reach, np.diff(edges))
    some = t.taken((slice(None), rows))
    with np.errstate(invalid="ignore"):
        reachable = np.where(np.abs(some.rounded) > far, np.nan, some.hi)
    if edges is not None:
        whole = t.hi.copy()
        whole[:, rows] = reachable
        reachable = whole
    lows = t.mapped(lambda array: np.array(np.broadcast_to(array, reachable.shape), order="C")).lo
    return Seconds(reachable, lows).mapped(read_only)


@cache
def compiled() -> Any:
    """The module of compiled loops over runs of rows."""
    with uncollected():
        from attitude._solver import chains
    return chains
