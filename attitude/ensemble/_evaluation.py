"""Epochs of a call (grid or rows), and attitudes and derivatives of members at them."""

from __future__ import annotations

from functools import cache, cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from attitude._compilation.deferral import uncollected
from attitude._solver import evaluation, sensitivities
from attitude._solver.series import LONGEST
from attitude._support import pairs
from attitude._support.arrays import frozen, read_only
from attitude._support.blocks import ProgressBar, in_blocks, in_rectangles
from attitude._support.pairs import Seconds
from attitude.ensemble._members import BLOCK
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.motions import _propagation
from attitude.motions._history import AttitudeHistory

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from astropy.table import QTable
    from astropy.time import Time
    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray, IntArray
    from attitude.ensemble._ensemble import Ensemble
    from attitude.ensemble._members import Kept, Members


# Rows in a piece of work: a millisecond, and 0.15 s if each row is of another member.
ROWS = 1 << 17
# Numbers of members that are surveyed or sorted in one call of compiled code.
_SURVEYED = 1 << 19
# Unsorted rows are brought into runs unless their runs are at least as long in the mean: a set-up
# takes as long as some 100 rows, sorting a row as long as 2 to 4.
_LONG_RUN = 64


def grid(
    members: Members | Kept,
    label: Callable[[int], str],
    t: Seconds,
    wxyz: FloatArray,
    rates: FloatArray | None,
    threads: int,
    raises: bool = True,
) -> None:
    """Fill attitudes and angular velocities of N members at T epochs each.

    Shapes: t (1 or N, T), wxyz (N, 4, T), rates (N, 3, T).
    """
    count, length = wxyz.shape[0], t.hi.shape[1]
    if not count or not length:
        return
    t = t.mapped(read_only)

    def work(part: slice, epochs: tuple[int, int]) -> None:
        constants, _ = members.prepared(part, rates=rates is not None)
        times = t.taken(part) if len(t.hi) > 1 else t
        out = wxyz[part], None if rates is None else rates[part]
        failed = evaluation.evaluate_all(constants, *times, *out, *epochs)
        if failed < 0:
            return
        if raises:
            few = failed if len(t.hi) > 1 else 0, slice(*epochs)
            refuse(constants[failed], times.taken(few), label(part.start + failed))
        reachable = within(times, reaches(constants)[:, None])
        evaluation.evaluate_all(constants, *reachable, *out, *epochs)

    most = evaluation.EPOCHS
    bar = ProgressBar("attitudes")
    in_rectangles(work, count, length, BLOCK, most, most, threads, bar)


def ragged(
    runs: Callable[..., None],
    member: IntArray,
    t: Seconds,
    order: IntArray | None,
    first: FloatArray,
    second: FloatArray | None,
    threads: int,
) -> None:
    """Fill two results at R rows, each of one of N members.

    Shapes: member (R,), t (R,), order (R,), first, second (..., R).
    """
    if not len(member):
        return

    def direct(begin: int, end: int) -> None:
        runs(member, begin, end, t, first, second)

    def gathered(begin: int, end: int) -> None:
        assert order is not None
        some = order[begin:end]
        arrays = [array for array in (first, second) if array is not None]
        copies = [np.empty((*array.shape[:-1], len(some))) for array in arrays]
        both = copies[0], None if second is None else copies[1]
        runs(member[some], 0, len(some), t.taken(some), *both)
        for whole, copy in zip(arrays, copies, strict=True):
            np.moveaxis(whole, -1, 0)[some] = np.moveaxis(copy, -1, 0)

    bar = ProgressBar("rows")
    in_blocks(direct if order is None else gathered, len(member), ROWS, threads, bar)


class Runs:
    """Evaluates rows of which those of one member stand together.

    members, label, raises: as in `grid`.
    """

    def __init__(self, members: Members, label: Callable[[int], str], raises: bool = True) -> None:
        self._members, self._label, self._raises = members, label, raises
        self._rows = compiled()

    def __call__(
        self,
        member: IntArray,
        begin: int,
        end: int,
        t: Seconds,
        wxyz: FloatArray,
        rates: FloatArray | None,
    ) -> None:
        """Fill the rows from `begin` to `end`.

        Shapes: member, t (R,), wxyz (4, R), rates (3, R).
        """
        who, starts = self.runs(member, begin, end)
        times = t.mapped(read_only).taken(None)
        out = wxyz[None], None if rates is None else rates[None]
        for first in range(0, len(who), BLOCK):
            some = who[first : first + BLOCK]
            constants, _ = self._members.prepared(consecutive(some), rates=rates is not None)
            edges = starts[first : first + len(some) + 1]
            records = read_only(constants)
            failed = self._rows.evaluate_runs(records, edges, *times, *out)
            if failed >= 0:
                reachable = self.nearer(constants, edges, t, failed, some)
                self._rows.evaluate_runs(records, edges, reachable[None], times.lo, *out)

    def nearer(
        self,
        constants: NDArray[Any],
        edges: IntArray,
        t: Seconds,
        failed: int,
        who: IntArray,
    ) -> FloatArray:
        """The epochs t (R,) with NaN beyond the reach of the runs `who` of rows between `edges`."""
        if self._raises:
            epochs_of_member = slice(edges[failed], edges[failed + 1])
            refuse(constants[failed], t.taken(epochs_of_member), self._label(int(who[failed])))
        reachable, rows = t.hi.copy(), slice(edges[0], edges[-1])
        reach = np.repeat(reaches(constants), np.diff(edges))
        reachable[rows] = within(t.taken(rows), reach).hi
        return read_only(reachable)

    def runs(self, member: IntArray, begin: int, end: int) -> tuple[IntArray, IntArray]:
        """The member (K,) of each run of rows, and their first rows and the end (K + 1,)."""
        who = np.empty(end - begin, dtype=np.int64)
        starts = np.empty(end - begin + 1, dtype=np.int64)
        count = self._rows.runs_of(read_only(member), begin, end, who, starts)
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


def consecutive(who: IntArray) -> slice | IntArray:
    """Numbers (K,), K >= 1, as a slice if each is one more than the last: arrays need no copy."""
    first, end = int(who[0]), int(who[-1]) + 1
    if end - first == len(who) and np.all(who[1:] > who[:-1]):
        return slice(first, end)
    return who


def reaches(constants: NDArray[Any]) -> FloatArray:
    """The largest |t| (B,), s, at which two doubles resolve the phases of motions."""
    phases = (np.abs(constants[name][:, 0]) for name in ("precession", "nutation"))
    with np.errstate(divide="ignore", over="ignore"):
        return np.minimum(LONGEST / np.maximum(*phases), np.finfo(float).max)


def within(t: Seconds, reach: FloatArray) -> Seconds:
    """The epochs with NaN in place of those beyond reach, in the shape that t and reach have."""
    with np.errstate(invalid="ignore"):
        reachable = np.where(np.abs(t.rounded) > reach, np.nan, t.hi)
    lows = t.mapped(lambda array: np.array(np.broadcast_to(array, reachable.shape), order="C")).lo
    return Seconds(reachable, lows).mapped(read_only)


def refuse(constants: NDArray[Any], t: Seconds, label: str) -> None:
    """Raise the AttitudeError of a member for epochs of which one is beyond its reach."""
    try:
        evaluation.refuse_epoch(constants, *t)
    except AttitudeError as err:
        raise AttitudeError(f"{label}: {err}") from None


@cache
def compiled() -> Any:
    """The module of compiled loops over runs of rows."""
    with uncollected():
        from attitude._solver import chains
    return chains


# ---- The epochs of a call: a grid of members and epochs, or rows each of one member


class Piece(NamedTuple):
    """Rows of which those of one member stand together.

    place: of the rows among all.
    member: (K,) array of int
    t: (K,), since the epoch of the member.
    """

    place: slice | IntArray
    member: IntArray
    t: Seconds


class MemberGrid:
    """All of N members at T epochs.

    count: N.
    t: (1 or N, T), since the epoch of the member.
    scalar: whether one epoch was given, so that the answers have no axis of epochs.
    first: number of the first member.

    shape: S: (N, T), or (N,) for one epoch.
    member: (S) array of int
    seconds: (S)
    """

    def __init__(self, count: int, t: Seconds, scalar: bool, first: int = 0) -> None:
        self.count, self.scalar, self.first = count, scalar, first
        # Epochs that all members share are few: a copy does not change with the caller's array.
        few = len(t.hi) == 1 and t.hi.size < 1 << 20
        hi = t.hi.copy() if few else t.hi
        self.t = Seconds(hi, t.lo).mapped(np.ascontiguousarray)
        self.length: int = t.hi.shape[1]
        self.shape: tuple[int, ...] = (count,) if scalar else (count, self.length)
        numbers = np.arange(first, first + count)
        self.member = self._over_epochs(numbers[:, None])
        self.seconds = self.t.mapped(self._over_epochs)

    def _over_epochs(self, array):
        spread = np.broadcast_to(array, (self.count, self.length))
        return spread[:, 0] if self.scalar else spread

    def pieces(self, most: int) -> list[tuple[slice, slice]]:
        """Members and epochs of parts of at most `most` rows, in order."""
        length = self.length
        span, size = min(length, most), max(1, most // max(length, 1))
        return [
            (slice(k, min(k + size, self.count)), slice(j, min(j + span, length)))
            for k in range(0, self.count if length else 0, size)
            for j in range(0, length, span)
        ]

    def piece(self, part: tuple[slice, slice]) -> Piece:
        """The rows of one of the `pieces`."""
        members, epochs = part
        length = self.length
        place = slice(
            members.start * length + epochs.start, (members.stop - 1) * length + epochs.stop
        )
        who = np.arange(members.start, members.stop).repeat(epochs.stop - epochs.start)
        shape = members.stop - members.start, epochs.stop - epochs.start

        def rows(array: FloatArray) -> FloatArray:
            values = array[members if len(array) > 1 else slice(None), epochs]
            return np.ascontiguousarray(np.broadcast_to(values, shape)).reshape(-1)

        return Piece(place, who, self.t.mapped(rows))

    def vectors(self, given: FloatArray, part: tuple[slice, slice]) -> FloatArray:
        """The rows (K, 3) of vectors (S, 3) in one of the `pieces`."""
        if self.scalar:
            return given[part[0]]
        return given[part].reshape(-1, 3)

    def parts(self, most: int) -> Iterator[tuple[Any, MemberGrid]]:
        """Grids of at most `most` attitudes, each after its place among the answers."""
        for members, epochs in self.pieces(most):
            rows_of_block = (members if len(self.t.hi) > 1 else slice(None)), epochs
            count = members.stop - members.start
            place = members if self.scalar else (members, epochs)
            yield place, MemberGrid(count, self.t.taken(rows_of_block), self.scalar, members.start)

    def memory(self, out: FloatArray | None, name: str, *width: int) -> FloatArray:
        """Component-major memory (N, *W, T) for an answer; that of `out` where possible."""
        shape = self.count, self.length
        return _propagation.result_memory(out, name, shape, width, self.scalar)

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (N, *W, T) as (S, *W), in `out` if it is given."""
        return _propagation.result(memory, out, self.scalar, 1)


class MemberRows:
    """Rows of one epoch of one of N members each.

    count: N.
    member: (S) array of int
    seconds: (S), since the epoch of the member.
    in_runs: whether rows of one member stand together, in long runs (`survey`), if known.
    """

    def __init__(
        self,
        count: int,
        member: IntArray,
        seconds: Seconds,
        in_runs: bool | None = None,
    ) -> None:
        self.count, self.member, self._in_runs = count, member, in_runs
        self.seconds = seconds.mapped(read_only)
        self.size: int = seconds.hi.size
        self.shape: tuple[int, ...] = seconds.hi.shape

    def pieces(self, most: int) -> list[slice | IntArray]:
        """The places of parts of `most` rows, of which those of one member stand together."""
        size, order = self.size, self.order
        parts = [slice(k, min(k + most, size)) for k in range(0, size, most)]
        return [*parts] if order is None else [order[block] for block in parts]

    def piece(self, part: slice | IntArray) -> Piece:
        """The rows of one of the `pieces`."""
        member, t = self.flat()
        return Piece(part, member[part], t.taken(part))

    def vectors(self, given: FloatArray, part: slice | IntArray) -> FloatArray:
        """The rows (K, 3) of vectors (S, 3) in one of the `pieces`."""
        return given[part] if given.ndim == 2 else given.reshape(-1, 3)[part]

    def flat(self) -> tuple[IntArray, Seconds]:
        """Members and their epochs (R,)."""

        def row(array: NDArray[Any]) -> NDArray[Any]:
            return np.ascontiguousarray(array).reshape(-1)

        return row(self.member), self.seconds.mapped(row)

    @cached_property
    def order(self) -> IntArray | None:
        """The order (R,) in which rows stand by member; None if they stand in long runs already."""
        if not self.size:
            return None
        member = self.flat()[0]
        in_runs = survey(member)[2] if self._in_runs is None else self._in_runs
        return None if in_runs else order_of(member, self.count)

    def parts(self, most: int) -> Iterator[tuple[slice, MemberRows]]:
        """Rows of at most `most` attitudes, each after their place among the rows (R,)."""
        member, seconds = self.flat()
        for first in range(0, self.size, most):
            place = slice(first, first + most)
            yield place, MemberRows(self.count, member[place], seconds.taken(place))

    def memory(self, out: FloatArray | None, name: str, *width: int) -> FloatArray:
        """Memory (*W, R) for an answer; that of `out` where possible."""
        if out is None and self.order is not None:
            # Rows are filled one by one: the numbers of each are together.
            return np.moveaxis(np.empty((self.size, *width)), 0, -1)
        return _propagation.result_memory(out, name, (self.size,), width, False)

    def shaped(self, memory: FloatArray, out: FloatArray | None) -> FloatArray:
        """Component-major memory (*W, R) as (S, *W), in `out` if it is given."""
        if out is not None:
            if len(self.shape) != 1:
                raise AttitudeError(
                    f"out is given for rows of shape {self.shape}; give rows (R,) with out=."
                )
            return _propagation.result(memory, out, False, 0)
        width = memory.shape[:-1]
        if memory.flags.c_contiguous:
            split = memory.reshape(*width, *self.shape)
            return np.moveaxis(split, range(len(width)), range(-len(width), 0))
        return np.moveaxis(memory, -1, 0).reshape(*self.shape, *width)


# ---- Attitudes of the members of an ensemble at epochs


class EnsembleHistory(AttitudeHistory):
    """The rotation of members of an ensemble, each at epochs of its own or at shared ones.

    Made by ``ensemble.at(t)``, of shape S = (N, T), or ``ensemble.at(t, member=index)``, of the
    shape S of the index.  It has all attributes and methods of `AttitudeHistory`.

    Attributes
    ----------
    ensemble : Ensemble
    member : (S) array of int
        The number of the member of each attitude.
    wxyz, xyzw : (S, 4) arrays
        Body to ICRF, scalar first or last; continuous in sign along the motion of a member.
    seconds, low : arrays of shape S (low may be None)
        TDB seconds since the epoch of the member: seconds + low.
    epoch : Instant
        The epoch of the ensemble, or J2000 if the members have epochs of their own.
    """

    ensemble: Ensemble
    member: IntArray

    def __init__(
        self,
        ensemble: Ensemble,
        member: IntArray,
        seconds: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
    ) -> None:
        super().__init__(ensemble, ensemble.start_of_seconds, seconds, low, wxyz)
        self._set("ensemble", ensemble)
        self._set("member", frozen(member))

    def __getitem__(self, index: Any) -> EnsembleHistory:
        """Some of the attitudes: history[3], history[:, 10:20], history[mask]."""
        history = super().__getitem__(index)
        member = np.asarray(self.member[index])
        chosen = EnsembleHistory(self.ensemble, member, history.seconds, history.low, history.wxyz)
        if "angular_velocity" in history.__dict__:
            chosen.__dict__["angular_velocity"] = history.angular_velocity
        return chosen

    def __repr__(self) -> str:
        size, members = self.seconds.size, len(self.ensemble)
        return f"<EnsembleHistory of {size} attitudes of an ensemble of {members}>"

    @cached_property
    def angular_velocity(self) -> FloatArray:
        """(S, 3) rad/s over the body axes."""
        return frozen(self.ensemble.evaluated(self.member, self.seconds, self.low))

    @cached_property
    def sensitivity(self) -> FloatArray:
        """(S, 3, 9) derivatives of the attitudes; see `Ensemble.sensitivity_at`."""
        columns = self.ensemble.sensitivity_at(self.seconds, self.member, low=self.low)
        return frozen(cast("FloatArray", columns))

    @cached_property
    def angular_acceleration(self) -> FloatArray:
        """(S, 3) rad/s2 over the body axes, by Euler's equations of the bodies at the epoch."""
        moments, axes = self.ensemble.principal_moments, self.ensemble.principal_axes
        which = self.member if len(moments) > 1 else np.zeros_like(self.member)
        differences, turn = moments[which], axes[which]
        w = np.einsum("...ij,...i->...j", turn, self.angular_velocity)
        rate = np.zeros(w.shape)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            torque = (differences[..., j] - differences[..., k]) * w[..., j] * w[..., k]
            heavy = differences[..., i] > 0.0
            rate[..., i] = np.where(heavy, torque / np.where(heavy, differences[..., i], 1.0), 0.0)
        return frozen(np.einsum("...ij,...j->...i", turn, rate))

    @cached_property
    def time(self) -> Time:
        """The epochs (S) as an astropy Time in TDB, rounded to 5e-12 s; NaN epochs are masked."""
        if self.ensemble.epoch is not None:
            return _instants.times(self.epoch, self.seconds, self.low)
        start = self.ensemble.epochs_of(self.member)
        times = Seconds.of(self)
        return _instants.times(self.epoch, *pairs.add(start, times.hi, times.low))

    def table(self, *, rates: bool = True, sigma: bool = False) -> QTable:
        """As `AttitudeHistory.table`, one row for each attitude, with columns member and name.

        Raises
        ------
        AttitudeError
            For standard deviations, which an ensemble does not have.
        """
        if sigma:
            raise AttitudeError("an ensemble has no standard deviations; leave out sigma=True.")
        flat = self if len(self.shape) == 1 else self._flattened()
        columns = super(EnsembleHistory, flat).table(rates=rates)
        columns.add_column(np.array(flat.member), index=0, name="member")
        if self.ensemble.names is not None:
            columns.add_column(self.ensemble.names[flat.member], index=1, name="name")
        if self.ensemble.epoch is None:
            del columns.meta["epoch"]
        return columns

    def _flattened(self) -> EnsembleHistory:
        times = Seconds.of(self).mapped(np.ravel)
        wxyz = self.wxyz.reshape(-1, 4)
        return EnsembleHistory(self.ensemble, np.ravel(self.member), *times, wxyz)


# ---- Derivatives of the attitudes of members of an ensemble at epochs

# Rows in a piece of work: some milliseconds.
_ROWS = 1 << 15


class MemberDerivatives:
    """Derivatives of members: of rows of which those of one member stand together, and of grids.

    label: name of a member in error messages.
    raises: whether members without derivatives and epochs beyond the reach of a member are refused;
        otherwise they give NaN.
    """

    def __init__(self, members: Members, label: Callable[[int], str], raises: bool) -> None:
        self._members, self._label, self._raises = members, label, raises
        self._runs = Runs(members, label, raises)

    def __call__(
        self,
        member: IntArray,
        begin: int,
        end: int,
        t: Seconds,
        attitude: FloatArray,
        omega: FloatArray | None,
    ) -> None:
        """Fill the rows from `begin` to `end`.

        Shapes: member, t (R,), attitude (3, 9, R), omega (3, 9, R).
        """
        who, starts = self._runs.runs(member, begin, end)
        for first in range(0, len(who), BLOCK):
            some = who[first : first + BLOCK]
            edges = starts[first : first + len(some) + 1]
            out = attitude[None], None if omega is None else omega[None]
            self._fill(some, t.taken(None), *out, edges)

    def grid(
        self,
        t: Seconds,
        attitude: FloatArray,
        omega: FloatArray | None,
        threads: int,
    ) -> None:
        """Fill the derivatives of N members at T epochs each.

        Shapes: t (1 or N, T), attitude, omega (N, 3, 9, T).
        """

        def work(part: slice, epochs: tuple[int, int]) -> None:
            times = t.taken(part) if len(t.hi) > 1 else t
            out = attitude[part], None if omega is None else omega[part]
            self._fill(np.arange(part.start, part.stop), times, *out, None)

        length = t.hi.shape[1]
        if length:
            bar = ProgressBar("derivatives")
            in_rectangles(work, len(attitude), length, BLOCK, length, _ROWS, threads, bar)

    def _fill(
        self,
        who: IntArray,
        t: Seconds,
        attitude: FloatArray,
        omega: FloatArray | None,
        edges: IntArray | None,
    ) -> None:
        """Fill the derivatives of a few members `who`; `edges` as in `sensitivities.evaluate`."""
        which = consecutive(who)
        constants, bad = self._members.prepared(which)
        moments, wxyz, _ = self._members.states(which)
        principal = self._members.principal
        principal = principal if len(principal) == 1 else principal[which]
        if not self._raises:
            unknown = np.any(moments[:, :, 0] == 0.0, axis=1)
            unknown[bad] = True
            moments = np.where(unknown[:, None, None], 1.0, moments)
        states = moments, wxyz, principal
        try:
            tangents = sensitivities.tangents_of(*states, constants)
            if not self._raises:
                for name in ("weights", "offset", "amplitudes", "uniform", "uniform_rates"):
                    tangents[name][unknown] = np.nan
                t = _near(constants, tangents, t, edges)
            sensitivities.evaluate(constants, tangents, *t, attitude, omega, edges=edges)
        except AttitudeError:
            self._refuse(who, constants, states, t, edges)
            raise

    def _refuse(
        self,
        who: IntArray,
        constants: NDArray[Any],
        states: tuple[FloatArray, FloatArray, FloatArray],
        t: Seconds,
        edges: IntArray | None,
    ) -> None:
        """Raise the AttitudeError of the first member that has one, with its name."""
        for k, number in enumerate(who.tolist()):
            arrays = [
                array[k : k + 1] if len(array) > 1 else array for array in (constants, *states)
            ]
            rows = slice(None) if edges is None else slice(edges[k], edges[k + 1])
            line = slice(k, k + 1) if len(t.hi) > 1 else slice(None)
            times = t.taken((line, rows)).mapped(np.ascontiguousarray).mapped(read_only)
            try:
                tangents = sensitivities.tangents_of(arrays[1], arrays[2], arrays[3], arrays[0])
                unused = np.empty((1, 3, sensitivities.PARAMETERS, times.hi.shape[1]))
                sensitivities.evaluate(arrays[0], tangents, *times, unused)
            except AttitudeError as err:
                raise AttitudeError(f"{self._label(number)}: {err}") from None


def _near(
    constants: NDArray[Any],
    tangents: NDArray[Any],
    t: Seconds,
    edges: IntArray | None,
) -> Seconds:
    """The epochs with NaN in place of those at which the derivatives of a member are unknown."""
    reach = np.fmin(reaches(constants), sensitivities.reaches(tangents))
    rows = slice(None) if edges is None else slice(edges[0], edges[-1])
    far = reach[:, None] if edges is None else np.repeat(reach, np.diff(edges))[None]
    reachable = within(t.taken((slice(None), rows)), far)
    if edges is None:
        return reachable
    whole = t.hi.copy()
    whole[:, rows] = reachable.hi
    return Seconds(read_only(whole), t.lo)
