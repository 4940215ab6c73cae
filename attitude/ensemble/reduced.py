"""Percentiles, histograms and coverage of quantities, without an array of members and epochs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from attitude import validation
from attitude.blocks import in_blocks
from attitude.ensemble import evaluate, quantities
from attitude.ensemble.answer import EnsembleHistory
from attitude.ensemble.attitudes import Evaluated
from attitude.ensemble.members import Kept
from attitude.errors import AttitudeError
from attitude.progress import ProgressBar

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import Epochs, FloatArray, IntArray, Reals
    from attitude.ensemble.ensemble import Ensemble
    from attitude.ensemble.rows import MemberGrid
    from attitude.scene.scene import Scene

# Numbers held at a time: 8 MB for each thread.
_HELD = 1 << 20
# Epochs that are evaluated together at least, since each part costs a set-up of all members.
_FEWEST = 16
# Members that are evaluated together: their attitudes stay in the second-level cache.
_FEW = 256


class Coverage(NamedTuple):
    """How long, and with what gaps, a quantity of each member is within its bounds.

    Attributes
    ----------
    fraction : (N,) array
        Of the span of epochs: intervals with both ends within count whole, with one end half.
    longest_gap : (N,) array
        s; the longest time between two epochs within that follow each other, or between such an
        epoch and an end of the span; the whole span where none is within.
    """

    fraction: FloatArray
    longest_gap: FloatArray


class Reduced(Evaluated):
    """Base of `Ensemble`: statistics of quantities over members or over epochs."""

    def percentiles(
        self,
        quantity: Any,
        t: Epochs,
        percentages: Reals = (5.0, 50.0, 95.0),
        *,
        scene: Scene | None = None,
        low: ArrayLike | None = None,
        threads: int = 1,
    ) -> FloatArray:
        """Percentiles of a quantity over the members, at each epoch.

        Parameters
        ----------
        quantity : str, AngleTo or callable
            The name of a quantity of `scene` with one number at each epoch ("magnitude",
            "aspect_angle" ...); an `AngleTo(axis, target)`; or a function that takes an
            EnsembleHistory (n, T) and returns numbers (n, T).
        t : (T,) or (N, T)
            As of `at`; with a scene (T,), the epochs at which light is received.
        percentages : (P,) array_like
            0 to 100; between two members the numbers are interpolated linearly, as by numpy.
        scene : Scene, optional
            Its motion is replaced by each member.
        threads : int
            Each takes some 20 MB.

        Returns
        -------
        (P, T) array
            NaN is left out; NaN where no member has a number.

        Raises
        ------
        AttitudeError
            For other quantities, percentages out of range, and as `at`.

        Notes
        -----
        Epochs are evaluated in parts of some 1e6 numbers, of at least 16 epochs; constants of up
        to 35,000 members are kept meanwhile, those of more are set up for each part.
        """
        wanted = validation.real(percentages, "percentages")
        if wanted.ndim != 1 or np.any((wanted < 0.0) | (wanted > 100.0)):
            raise AttitudeError(f"percentages are {wanted.tolist()}; give a row of 0 to 100.")
        known, grid = quantities.known(quantity, scene, self, t, low)
        length = grid.t.shape[1]
        out, kept = np.full((len(wanted), length), np.nan), Kept(self._members)
        size = max(_FEWEST, _HELD // max(len(self), 1))

        def work(begin: int, end: int) -> None:
            epochs = slice(begin, end)
            values = np.empty((end - begin, len(self)))
            for first in range(0, len(self), _FEW):
                which = slice(first, min(first + _FEW, len(self)))
                values[:, which] = self._measured(known, grid, kept, which, epochs).T
            out[:, epochs] = _percentiles(values, wanted, known.finished)

        if len(self):
            in_blocks(work, length, size, threads, ProgressBar("percentiles"))
        return out

    def histograms(
        self,
        quantity: Any,
        t: Epochs,
        edges: Reals,
        *,
        scene: Scene | None = None,
        low: ArrayLike | None = None,
    ) -> IntArray:
        """Numbers of members (T, B) in each of B bins, at each epoch.

        Parameters
        ----------
        quantity, t, scene, low
            As of `percentiles`.
        edges : (B + 1,) array_like
            Ascending, in the unit of the quantity; a bin holds its lower edge, the last one both.

        Raises
        ------
        AttitudeError
            For edges that do not ascend, and as `percentiles`.
        """
        bounds = validation.real(edges, "edges")
        if bounds.ndim != 1 or len(bounds) < 2 or np.any(np.diff(bounds) <= 0.0):
            raise AttitudeError(f"edges are {validation.shown(edges)}; give an ascending row.")
        known, grid = quantities.known(quantity, scene, self, t, low)
        bins, length = len(bounds) - 1, grid.t.shape[1]
        counts = np.zeros(length * bins, dtype=np.int64)
        bar, done = ProgressBar("histograms"), 0
        for which, epochs in grid.pieces(_HELD >> 2):
            values = known.finished(self._measured(known, grid, self._members, which, epochs))
            place = np.searchsorted(bounds, values, side="right") - 1
            place[values == bounds[-1]] = bins - 1
            inside = (place >= 0) & (place < bins) & ~np.isnan(values)
            row = np.broadcast_to(np.arange(epochs.start, epochs.stop), values.shape)
            index = (row * bins + place)[inside]
            counts += np.bincount(index, minlength=len(counts))
            done += values.size
            bar(done, len(self) * length)
        return counts.reshape(length, bins)

    def coverage(
        self,
        quantity: Any,
        t: Epochs,
        *,
        least: float = -np.inf,
        greatest: float = np.inf,
        scene: Scene | None = None,
        low: ArrayLike | None = None,
        threads: int = 1,
    ) -> Coverage:
        """The fraction of time for which a quantity is within bounds, and its longest gap.

        Parameters
        ----------
        quantity, t, scene, low
            As of `percentiles`; epochs ascend, and are so close that no crossing is lost.
        least, greatest : float
            Bounds, which are within; in the unit of the quantity.  NaN is not within.
        threads : int

        Returns
        -------
        Coverage

        Raises
        ------
        AttitudeError
            For epochs that do not ascend, fewer than two, and as `percentiles`.
        """
        known, grid = quantities.known(quantity, scene, self, t, low)
        if grid.t.shape[1] < 2 or not np.all(np.diff(grid.t) > 0.0):
            raise AttitudeError("t does not ascend, or holds fewer than two epochs; give (T,).")
        fraction, gap = np.empty((2, len(self)))
        size = max(1, (_HELD >> 2) // grid.t.shape[1])
        every = slice(0, grid.t.shape[1])

        def work(begin: int, end: int) -> None:
            which = slice(begin, end)
            values = known.finished(self._measured(known, grid, self._members, which, every))
            with np.errstate(invalid="ignore"):
                within = (values >= least) & (values <= greatest)
            times = grid.t[which] if len(grid.t) > 1 else grid.t
            fraction[which], gap[which] = _covered(within, times)

        in_blocks(work, len(self), size, threads, ProgressBar("coverage"))
        return Coverage(fraction, gap)

    def _measured(
        self, known: Any, grid: MemberGrid, source: Any, which: slice, epochs: slice
    ) -> FloatArray:
        """What a quantity measures of some members at some epochs."""
        own = which if len(grid.t) > 1 else slice(None)
        t = np.ascontiguousarray(grid.t[own, epochs])
        low = None if grid.t_low is None else np.ascontiguousarray(grid.t_low[own, epochs])
        count, length = which.stop - which.start, epochs.stop - epochs.start
        wxyz = np.empty((count, 4, length))
        members = source.taken(which)
        evaluate.grid(
            members, lambda k: self.label(k + which.start), t, low, wxyz, None, 1,
            self.on_error == "raise",
        )  # fmt: skip
        numbers = np.broadcast_to(np.arange(which.start, which.stop)[:, None], (count, length))
        lows = None if low is None else np.broadcast_to(low, (count, length))
        seconds = np.broadcast_to(t, (count, length))
        whole = cast("Ensemble", self)
        history = EnsembleHistory(whole, numbers, seconds, lows, np.moveaxis(wxyz, 1, 2))
        found: FloatArray = known.measured(history, epochs)
        return found


def _percentiles(values: FloatArray, percentages: FloatArray, finished: Any) -> FloatArray:
    """Percentiles (P, T) of rows (T, N), which are reordered."""
    unknown = np.isnan(values).any(axis=1)
    if unknown.any():
        out = np.full((len(percentages), len(values)), np.nan)
        out[:, ~unknown] = _percentiles(values[~unknown], percentages, finished)
        for k in np.flatnonzero(unknown):
            row = values[k][~np.isnan(values[k])]
            if len(row):
                out[:, [k]] = _percentiles(row[None], percentages, finished)
        return out
    place = percentages / 100.0 * (values.shape[1] - 1)
    below = np.floor(place).astype(np.int64)
    ranks = np.concatenate([below, np.minimum(below + 1, values.shape[1] - 1)])
    # the numbers of two members, of which a quantity may be known by another that grows with it
    lower, upper = np.split(finished(_of_ranks(values, ranks)), 2, axis=1)
    found: FloatArray = lower + (upper - lower) * (place - below)
    return found.T


def _of_ranks(values: FloatArray, ranks: IntArray) -> FloatArray:
    """The numbers (T, R) of given ranks in rows (T, N): a third of the time of a partition."""
    from attitude.ensemble.quantity_loops import BINS, candidates

    out = np.empty((len(values), len(ranks)))
    memory = np.empty(BINS, dtype=np.int64), np.empty(BINS, dtype=np.int64)
    found, places = np.empty(values.shape[1] + 1), np.empty(len(ranks), dtype=np.int64)
    for k, row in enumerate(values):
        count = candidates(row, ranks, *memory, found, places)
        out[k] = np.sort(found[:count])[places]
    return out


def _covered(within: Any, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fraction of the span and longest gap (n,) of flags (n, T) at ascending times (1 or n, T)."""
    steps, span = np.diff(times), times[:, -1] - times[:, 0]
    ends = 0.5 * (within[:, 1:].astype(np.float64) + within[:, :-1])
    fraction = np.sum(ends * steps, axis=1) / span
    # The last time within up to each epoch, and the first one from it on.
    first, last = times[:, :1], times[:, -1:]
    seen = np.where(within, times, first)
    before = np.maximum.accumulate(seen, axis=1)
    gap = np.max(times[:, 1:] - before[:, :-1], axis=1, where=within[:, 1:], initial=0.0)
    final = np.where(within.any(axis=1), last[:, 0] - before[:, -1], span)
    return fraction, np.maximum(gap, final)
