"""Attitudes of members at epochs: grids of members and epochs, and ragged rows."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import evaluation
from attitude.blocks import in_blocks, in_rectangles
from attitude.compilation.deferral import uncollected
from attitude.ensemble.members import BLOCK
from attitude.errors import AttitudeError
from attitude.immutable import read_only
from attitude.progress import ProgressBar
from attitude.solution.phases import LONGEST

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray
    from attitude.ensemble.members import Kept, Members

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
    t: FloatArray,
    low: FloatArray | None,
    wxyz: FloatArray,
    rates: FloatArray | None,
    threads: int,
    raises: bool = True,
) -> None:
    """Fill attitudes and angular velocities of N members at T epochs each.

    Parameters
    ----------
    members : Members or Kept
    label : callable
        Name of a member in error messages.
    t, low : (1 or N, T) arrays
        The epochs t + low, s; low may be None.
    wxyz : (N, 4, T) array
        Filled: body to ICRF.
    rates : (N, 3, T) array or None
        Filled: rad/s over the body axes.
    threads : int
    raises : bool
        Whether epochs beyond the reach of a member are refused; otherwise they give NaN.

    Raises
    ------
    AttitudeError
        For epochs so far away that two doubles of time do not resolve the phases.
    """
    count, length = wxyz.shape[0], t.shape[1]
    if not count or not length:
        return
    given = read_only(t), None if low is None else read_only(low)

    def work(part: slice, epochs: tuple[int, int]) -> None:
        constants, _ = members.prepared(part, rates=rates is not None)
        here = part if len(t) > 1 else slice(None)
        times = given[0][here], None if given[1] is None else given[1][here]
        out = wxyz[part], None if rates is None else rates[part]
        failed = evaluation.evaluated(constants, *times, *out, *epochs)
        if failed < 0:
            return
        if raises:
            few = failed if len(t) > 1 else 0, slice(*epochs)
            lows = None if times[1] is None else times[1][few]
            refuse(constants[failed], times[0][few], lows, label(part.start + failed))
        near = within(*times, reaches(constants)[:, None])
        evaluation.evaluated(constants, *near, *out, *epochs)

    most = evaluation.EPOCHS
    bar = ProgressBar("attitudes")
    in_rectangles(work, count, length, BLOCK, most, most, threads, bar)


def ragged(
    runs: Callable[..., None],
    member: IntArray,
    t: FloatArray,
    low: FloatArray | None,
    order: IntArray | None,
    first: FloatArray,
    second: FloatArray | None,
    threads: int,
) -> None:
    """Fill two results at R rows, each of one of N members.

    Parameters
    ----------
    runs : callable
        `Runs`, or another that takes its arguments: evaluates rows of which those of one member
        stand together.
    member : (R,) array
        Numbers of members, 0 to N - 1, in any order.
    t, low : (R,) arrays
        The epochs t + low, s; low may be None.
    order : (R,) array or None
        Of `order_of`.
    first, second : (..., R) arrays
        Filled by `runs`, as it is documented there; second may be None.
    threads : int

    Raises
    ------
    AttitudeError
        As `grid`.
    """
    if not len(member):
        return

    def direct(begin: int, end: int) -> None:
        runs(member, begin, end, t, low, first, second)

    def gathered(begin: int, end: int) -> None:
        assert order is not None
        some = order[begin:end]
        lows = None if low is None else low[some]
        given = [each for each in (first, second) if each is not None]
        found = [np.empty((*each.shape[:-1], len(some))) for each in given]
        both = found[0], None if second is None else found[1]
        runs(member[some], 0, len(some), t[some], lows, *both)
        for whole, part in zip(given, found, strict=True):
            np.moveaxis(whole, -1, 0)[some] = np.moveaxis(part, -1, 0)

    bar = ProgressBar("rows")
    in_blocks(direct if order is None else gathered, len(member), ROWS, threads, bar)


class Runs:
    """Evaluates rows of which those of one member stand together.

    Parameters
    ----------
    members, label, raises
        As of `grid`.
    """

    def __init__(self, members: Members, label: Callable[[int], str], raises: bool = True) -> None:
        self._members, self._label, self._raises = members, label, raises
        self._rows = compiled()

    def __call__(
        self,
        member: IntArray,
        begin: int,
        end: int,
        t: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
        rates: FloatArray | None,
    ) -> None:
        """Fill the rows from `begin` to `end`.

        Parameters
        ----------
        member, t, low : (R,) arrays
            As of `ragged`.
        begin, end : int
        wxyz : (4, R) array
            Filled: body to ICRF.
        rates : (3, R) array or None
            Filled: rad/s over the body axes.
        """
        who, starts = self.runs(member, begin, end)
        times = read_only(t)[None], None if low is None else read_only(low)[None]
        out = wxyz[None], None if rates is None else rates[None]
        for first in range(0, len(who), BLOCK):
            some = who[first : first + BLOCK]
            constants, _ = self._members.prepared(consecutive(some), rates=rates is not None)
            edges = starts[first : first + len(some) + 1]
            records = read_only(constants)
            failed = self._rows.evaluate_runs(records, edges, *times, *out)
            if failed >= 0:
                near = self.nearer(constants, edges, t, low, failed, some)
                self._rows.evaluate_runs(records, edges, near[None], times[1], *out)

    def nearer(
        self,
        constants: NDArray[Any],
        edges: IntArray,
        t: FloatArray,
        low: FloatArray | None,
        failed: int,
        who: IntArray,
    ) -> FloatArray:
        """The epochs t (R,) with NaN beyond the reach of the runs `who` of rows between `edges`.

        Raises
        ------
        AttitudeError
            Unless such epochs give NaN: the epochs of run `failed`.
        """
        if self._raises:
            here = slice(edges[failed], edges[failed + 1])
            lows = None if low is None else low[here]
            refuse(constants[failed], t[here], lows, self._label(int(who[failed])))
        near, rows = t.copy(), slice(edges[0], edges[-1])
        reach = np.repeat(reaches(constants), np.diff(edges))
        near[rows] = within(t[rows], None if low is None else low[rows], reach)[0]
        return read_only(near)

    def runs(self, member: IntArray, begin: int, end: int) -> tuple[IntArray, IntArray]:
        """The member (K,) of each run of rows, and their first rows and the end (K + 1,)."""
        who = np.empty(end - begin, dtype=np.int64)
        starts = np.empty(end - begin + 1, dtype=np.int64)
        count = self._rows.runs_of(read_only(member), begin, end, who, starts)
        return who[:count], starts[: count + 1]


def survey(member: IntArray) -> tuple[int, int, bool]:
    """Least and greatest of R >= 1 numbers, and whether equal ones stand in long runs already."""
    parts = _surveyed(member)
    found = np.array([compiled().surveyed(each) for each in parts])
    ascends = not found[:, 3].any() and all(a[-1] <= b[0] for a, b in pairwise(parts))
    in_runs = ascends or len(member) >= _LONG_RUN * int(found[:, 2].sum())
    return int(found[:, 0].min()), int(found[:, 1].max()), in_runs


def order_of(member: IntArray, count: int) -> IntArray:
    """The order in which rows (R,) stand by member."""
    places = np.zeros(count + 1, dtype=np.int64)
    for part in _surveyed(member):
        compiled().counted(part, places[1:])
    np.cumsum(places, out=places)
    order = np.empty(len(member), dtype=np.int64)
    for k, part in enumerate(_surveyed(member)):
        compiled().placed(part, k * _SURVEYED, places, order)
    return order


def _surveyed(member: IntArray) -> list[IntArray]:
    """Parts so short that Ctrl-C is heard between them."""
    given = read_only(member)
    return [given[k : k + _SURVEYED] for k in range(0, len(given), _SURVEYED)]


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


def within(
    t: FloatArray, low: FloatArray | None, reach: FloatArray
) -> tuple[FloatArray, FloatArray | None]:
    """The epochs with NaN in place of those beyond reach, in the shape that t and reach have."""
    with np.errstate(invalid="ignore"):
        near = np.where(np.abs(t if low is None else t + low) > reach, np.nan, t)
    lows = None if low is None else np.array(np.broadcast_to(low, near.shape), order="C")
    return read_only(near), None if lows is None else read_only(lows)


def refuse(constants: NDArray[Any], t: FloatArray, low: FloatArray | None, label: str) -> None:
    """Raise the AttitudeError of a member for epochs of which one is beyond its reach."""
    try:
        evaluation.refuse_epoch(constants, t, low)
    except AttitudeError as err:
        raise AttitudeError(f"{label}: {err}") from None


@cache
def compiled() -> Any:
    """The module of compiled loops over runs of rows."""
    with uncollected():
        from attitude.solution import rows
    return rows
