"""`periods`: pairs of periods of a light curve by Fourier series in two frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.inversion import _evidence, _lattices, _problem
from attitude.inversion._curve import LightCurve
from attitude.photometry import _spectrum

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath, FloatArray, Real
    from attitude._support.tables import FlatTable
    from attitude.inversion._problem import CurveProblem


# Error of the model, mag, and turns per span searched at most.
_ERROR, _MOST_TURNS = 0.02, 1500.0
# Errors of the series, mag, of which the most probable one compares zero points.
_ERRORS = 0.02, 0.05, 0.1, 0.2, 0.4
# Pairs that are fitted with the linear terms, for each that is returned.
_MORE = 10


class Pair(NamedTuple):
    """A pair of frequencies, Hz, the share of the variance left, and what it is an alias of.

    The lower frequency is first; ``alias_of`` is the rank of a better pair from which this one
    differs by a cycle a day, or None.
    """

    first: float
    second: float
    left: float
    alias_of: int | None

    @property
    def periods(self) -> tuple[float, float]:
        """Both periods, s."""
        return 1.0 / self.first, 1.0 / self.second


class Periods(Sequence[Pair]):
    """Pairs of frequencies, the best first.

    Attributes
    ----------
    order : int
        Of the series.
    false_alarm : float
        The share of the variance left by the best pair of 1 of 100 light curves whose magnitudes
        are exchanged at random among the epochs; a pair that leaves less is significant.
    """

    def __init__(self, pairs: list[Pair], order: int, false_alarm: float) -> None:
        self._pairs, self.order, self.false_alarm = pairs, order, false_alarm

    @overload
    def __getitem__(self, index: int) -> Pair: ...

    @overload
    def __getitem__(self, index: slice) -> list[Pair]: ...

    def __getitem__(self, index: int | slice) -> Pair | list[Pair]:
        """The pair of a rank."""
        return self._pairs[index]

    def __len__(self) -> int:
        return len(self._pairs)

    def table(self) -> FlatTable:
        """A row for each pair."""
        from astropy import units

        from attitude._support.tables import FlatTable

        both = np.array([each[:2] for each in self._pairs]).reshape(-1, 2)
        return FlatTable(
            {
                "first": 1.0 / both[:, 0] / 86400.0 * units.d,
                "second": 1.0 / both[:, 1] / 86400.0 * units.d,
                "left": [each.left for each in self._pairs],
                "significant": [each.left < self.false_alarm for each in self._pairs],
                "alias_of": [-1 if each.alias_of is None else each.alias_of for each in self],
            }
        )

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure of the pairs in the plane of their frequencies; saved if a path is given."""
        from attitude.inversion import _figures

        return _figures.of_pairs(self, path)

    def __repr__(self) -> str:
        return f"<Periods: {len(self)} pairs of order {self.order}>"


def periods(
    curve: LightCurve, max_frequency: Real, *, order: int = 2, count: int = 20, seed: int = 0
) -> Periods:
    """Pairs of periods whose Fourier series fits a light curve best.

    Parameters
    ----------
    curve : LightCurve
    max_frequency : float, Quantity or text
        Hz, or such as "0.75 /d".
    order : int
        1 to 4: lines |i f1 + j f2| with |i|, |j| up to it.
    count : int
        Of the pairs returned.
    seed : int
        Of the permutations.

    Raises
    ------
    AttitudeError
        For an order out of range, and a curve that spans less than three turns at max_frequency.

    Notes
    -----
    A pair (f1, f2) and (f1 +- 2 f2, f2) share their lines but for the order at which the series
    ends, so that pairs are lattices of lines rather than periods of axes; `spin_states` decides.
    2 microseconds a pair at order 2, whatever the number of points (benchmarks/inversion.py).
    """
    if not isinstance(curve, LightCurve):
        raise AttitudeError(f"curve is {validation.shown(curve)}; give a LightCurve.")
    number = validation.count(order, "order")
    if number > 4:
        raise AttitudeError(f"order is {number}; give 1 to 4.")
    most = validation.positive(max_frequency, "max_frequency", unit="1/s")
    turns = most * curve.span
    if not 3.0 <= turns <= _MOST_TURNS:
        raise AttitudeError(
            f"the light curve spans {turns:.3g} turns at max_frequency; from 3 to "
            f"{_MOST_TURNS:.0f} are searched."
        )
    keep = validation.count(count, "count")
    # offsets of short sessions take up a rotation of days: one zero point is tried first
    zero_points = ["shared", "auto"] if curve.zero_points == "auto" else [curve.zero_points]
    tried, near = [], np.zeros((0, 2))
    for each in zero_points:
        problem, _ = _problem.problem(curve, most, _ERROR, each)
        near = np.concatenate(
            [near, _lattices.lattice_pairs(problem, turns, _MORE * keep, number)[0]]
        )
        exact = _lattices.exactly(problem, near, number)
        tried.append((_cost(problem, exact[0][:1], number), problem, exact))
    _, problem, exact = min(tried, key=lambda each: each[0])
    found, left = (each[:keep] for each in exact)
    found = np.sort(found, axis=1) / curve.span
    pairs: list[Pair] = []
    for (first, second), share in zip(found, left, strict=True):
        alias = _spectrum.alias_of(first, second, pairs, 0.6 / curve.span)
        pairs.append(Pair(float(first), float(second), float(share), alias))
    least = _spectrum.share_of_chance(
        problem.t, problem.root**2, problem.detrended, turns, number, seed
    )
    return Periods(pairs, number, least)


def _cost(problem: CurveProblem, pair: FloatArray, order: int) -> float:
    """-2 ln of the likelihood of a pair (1, 2), offsets marginal, at the best error of the model.

    But for the amplitudes of the lines, whose number is that of any zero points.
    """
    costs = []
    for error in _ERRORS:
        own = problem.with_model_error(error)
        chi_squared = own.chi_squared(np.zeros(len(own)))
        left = float(_lattices.exactly(own, pair, order)[1][0])
        size = 2.0 * float(np.sum(np.log(own.root)))
        costs.append(left * chi_squared - size + _evidence.volume_of_offsets(own))
    return min(costs)
