"""The blind search: candidate rates, ellipsoids from many starts, convex bodies, robust errors.

Rounds go on, with more pairs and more starts each, until the best solution leaves residuals as
small as the errors, or the time is over.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from attitude.inversion import _ellipsoid, _lattices, _pole_map, _refinement

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._ellipsoid import Pool
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import Refined, Weighted
    from attitude.inversion._shapes import Tie


# Model error, mag, of ellipsoids; that of convex bodies is estimated.
ELLIPSOID_ERROR = 0.07
# Standard deviation of the logarithms of the moments of motion and ellipsoid.
_TIE = 0.15
# The same for moments that are given, so wide that an iteration reaches them from any start.
_TIE_GIVEN = 0.03
# Pairs of frequencies, and starts of each pair of rates, in the first round; doubled in the next.
_PAIRS, _QUICK, _DEEP = 200, 4, 40
# Pairs of rates that get more starts; ellipsoids made convex; convex bodies with robust errors;
# rotations about one axis that are listed, and within which difference of evidence.
_CLASSES, _CONVEX, _FINAL, _FINAL_AXIAL, _AXIAL_BEHIND = 30, 40, 14, 48, 25.0
# Poles of one pair of rates.
_POLES = 7
# Precessions of which every nutation is tried.
_SCANNED = 3
# Starts of each pair of rates that the windows of the epochs displace.
_ALIASES = 12
# Rates that are fitted between looks at the clock.
_BLOCK = 200
# Rates of one solution: lambda/pi and f, turns per span; poles of one solution, cosine.
SAME_RATE, _SAME_POLE = 0.35, math.cos(math.radians(8.0))
# Without the floor: the share of the variance left, and the difference of evidence to the next
# periods, of a solution that is accepted.
LEFT, ALONE = 0.12, 120.0
_ROUNDS = 4
_AXIAL_RATES, _AXIAL_STARTS = 12, 12
# Poles of rotation about one axis are mapped where chi-squared of the best such rotation is at most
# this times that of the best solution; also at other rates that lie so little behind in evidence.
_AXIAL_WORSE, _AXIAL_MAPPED = 2.0, 60.0
# Rates, turns per span, that one map of poles comprises.
_AXIAL_RATE = 1.2
# Such rotations that are compared with a motion that explains the curve better by far.
_AXIAL_OTHERS = 3
# Tumbling bodies among all: the odds before the curve is seen.
TUMBLERS = 0.01


def never() -> bool:
    """False: a search goes on."""
    return False


def pole(state: FloatArray) -> FloatArray:
    """The direction (3,) of the angular momentum, ICRF."""
    return state[[7, 10, 13]]


def is_same(a: FloatArray, b: FloatArray) -> bool:
    """Whether two states have one mode, the same rates and the same pole."""
    return has_rates(a, b) and float(pole(a) @ pole(b)) > _SAME_POLE


def has_rates(a: FloatArray, b: FloatArray) -> bool:
    """Whether two states have one mode and the same rates."""
    if is_axial(a) or is_axial(b):
        return is_axial(a) and is_axial(b) and 2.0 * abs(a[0] - b[0]) < SAME_RATE
    same = 2.0 * abs(a[0] - b[0]) < SAME_RATE and abs(a[1] - b[1]) < SAME_RATE
    return bool(same)


def is_axial(state: FloatArray) -> bool:
    """Whether a state is rotation about one axis."""
    return bool(state[3] == _ellipsoid.AXIAL)


@dataclass(eq=False)
class Search:
    """A search and what it has found.

    Attributes
    ----------
    problem : CurveProblem
        With the model error of ellipsoids.
    most : float
        Largest frequency, turns per span.
    modes : tuple of str
    tie : Tie
        Of the moments of motion and shape.
    shifts : tuple of float
        Turns per span of a day, where the epochs lie at one time of the day.
    generator : Generator
    deadline : float
        `time.monotonic` at which the search ends.
    progress : callable
        Called with a text after each stage.
    convex : list of Refined
        The best first.
    solutions : list of Weighted
        The best first; those of the last `finish`.
    axial : list of Refined
        Rotations about one axis from a map of poles, the most probable first.
    beside : list of Weighted
        Those that are not among `solutions`, for a better pole lies near.
    is_complete : bool
        Whether the first round came to its end.
    """

    problem: CurveProblem
    most: float
    modes: tuple[str, ...]
    tie: Tie
    shifts: tuple[float, ...]
    generator: np.random.Generator
    deadline: float
    progress: Callable[[str], object]
    convex: list[Refined] = field(default_factory=list)
    solutions: list[Weighted] = field(default_factory=list)
    axial: list[Refined] = field(default_factory=list)
    beside: list[Weighted] = field(default_factory=list)
    is_complete: bool = False
    is_ellipsoid: bool = False
    notes: list[str] = field(default_factory=list)

    @property
    def is_over(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() > self.deadline

    def begin(self, states: Iterable[FloatArray]) -> None:
        """Make `solutions` from states alone, such as those that another search has found."""
        self.convex = [
            _refinement.refine(self.problem, each, tie=self.tie, fixed=self._fixed(each), gain=3e-3)
            for each in states
        ]
        self.convex.sort(key=lambda each: each.cost)
        self.finish()

    def follow(self, other: Search) -> None:
        """Make `solutions` from all bodies of a search of the same curve, with these terms."""
        self.begin([each.state for each in other.convex])
        self.is_complete = other.is_complete

    def run(self, is_ended: Callable[[], bool] = never) -> None:
        """Search until the floor is reached, the time is over, or `is_ended` after a round."""
        self._axial()
        for number in range(_ROUNDS):
            for pool in self._pools(number):
                self._refine(pool)
            if self.shifts and not self.is_over:
                rates = self._displaced()
                made = _ellipsoid.around(
                    self.problem, self.generator, rates, _ALIASES, iterations=30, tie=self._held
                )
                self._refine(_ellipsoid.in_order(_ellipsoid.best_of_each(made, len(rates))))
            if number == 0:
                self._axial_poles()
                self.is_complete = not self.is_over
            self.finish()
            if is_ended() or self.is_over or self.has_reached_floor:
                break

    @property
    def _held(self) -> _ellipsoid.Held:
        """What holds the moments of the motions of ellipsoids."""
        if self.tie.given is None:
            return _ellipsoid.Held(_TIE)
        a, b, c = np.log(self.tie.given).tolist()
        return _ellipsoid.Held(_TIE_GIVEN, (a, b, c))

    @property
    def has_reached_floor(self) -> bool:
        """Whether the best solution leaves residuals as small as the errors, or stands alone."""
        if not self.solutions:
            return False
        best = self.solutions[0]
        if _refinement.floor_ratio(best, self.problem) < _refinement.FLOOR:
            return True
        others = [e for e in self.solutions if not has_rates(e.refined.state, best.refined.state)]
        gap = min((each.evidence - best.evidence for each in others), default=0.0)
        left = _refinement.share_left(best, self.problem)
        return bool(gap > ALONE and left < LEFT)

    def _pools(self, number: int) -> Iterator[Pool]:
        """Ellipsoids of a round: of the lattices, then of every psi at the best phi."""
        more = 2**number
        found, _ = _lattices.lattice_pairs(self.problem, self.most, _PAIRS * more)
        rates = _lattices.candidates(found, self.most, self.modes, self.shifts)
        yield self._ellipsoids(rates, more, "periods of the lines")
        self.convex.sort(key=lambda each: each.cost)
        yield self._ellipsoids(self._scan(), more, "periods of psi")

    def _ellipsoids(self, rates: list[_lattices.Candidate], more: int, name: str) -> Pool:
        """Ellipsoids of rates, with more starts for the best."""
        problem = self.problem
        parts = []
        for start in range(0, len(rates), _BLOCK):
            part = rates[start : start + _BLOCK]
            made = _ellipsoid.around(problem, self.generator, part, _QUICK * more, tie=self._held)
            parts.append(_ellipsoid.best_of_each(made, len(part)))
            self.progress(f"ellipsoids: {start + len(part)} of {len(rates)} {name}")
            if self.is_over:
                break
        pool = _ellipsoid.in_order(*parts)
        deep = [pool]
        for rate in _ellipsoid.rates_of(pool, _CLASSES):
            if self.is_over:
                break
            deep.append(
                _ellipsoid.around(
                    problem, self.generator, [rate], _DEEP * more, iterations=40, tie=self._held
                )
            )
        return _ellipsoid.in_order(*deep)

    def _scan(self) -> list[_lattices.Candidate]:
        """Rates with the precession of the long axis of the best solutions, and every nutation."""
        rates = []
        used: list[float] = []
        for each in self.convex:
            state = each.state
            here = 2.0 * float(state[0])
            if not is_axial(state) and state[1] > 0.0:
                here -= float(state[1])
            if any(abs(here - other) < 0.4 for other in used):
                continue
            used.append(here)
            steps = np.arange(_lattices.LEAST, 0.6 * self.most, 0.4)
            if "LAM" in self.modes:
                rates += [_lattices.Candidate(0.5 * (here + f), f) for f in steps]
            if "SAM" in self.modes:
                rates += [_lattices.Candidate(0.5 * here, -f) for f in steps if f < 1.4 * here]
            if len(used) == _SCANNED:
                break
        return rates

    def _displaced(self) -> list[_lattices.Candidate]:
        """Rates of the best solutions with lines displaced by the windows of the epochs.

        Lines lie at even numbers of psi: a shift of a line moves psi by half of it.
        """
        rates: list[_lattices.Candidate] = []
        states: list[FloatArray] = []
        for each in self.convex:
            if is_axial(each.state) or any(has_rates(each.state, other) for other in states):
                continue
            states.append(each.state)
            nutation = abs(float(each.state[1]))
            phi = 2.0 * float(each.state[0]) - max(float(each.state[1]), 0.0)
            for shift in (0.0, *self.shifts):
                for part in (-1.0, -0.5, 0.5, 1.0) if shift else (0.0,):
                    moved = [(phi + part * shift, nutation), (phi, abs(nutation + part * shift))]
                    rates += [
                        _lattices.Candidate(0.5 * rate, f)
                        for a, b in moved
                        for rate, f in ((a + b, b), (a, -b), (a + 2.0 * b, -b))
                        if min(a, b) > _lattices.LEAST
                        and rate + max(-f, 0.0) < self.most
                        and ("LAM" if f > 0.0 else "SAM") in self.modes
                    ]
            if len(states) == _SCANNED:
                break
        return list(dict.fromkeys(rates))

    def _axial(self) -> None:
        """Rotations about one axis."""
        found = _lattices.lines(self.problem, self.most, _AXIAL_RATES)
        rates = np.unique(np.concatenate([found, 0.5 * found]))
        rates = rates[rates > _lattices.LEAST]
        pool = _ellipsoid.axial(self.problem, self.generator, rates, _AXIAL_STARTS)
        self._refine(_ellipsoid.in_order(pool), keep=_CONVEX // 2)
        self.progress("rotations about one axis")

    def _axial_poles(self) -> None:
        """Rotations about one axis from poles all over the sky, if one explains the curve."""
        axial = [each for each in self.convex if is_axial(each.state)]
        if not axial or self.is_over:
            return
        if axial[0].chi_squared > _AXIAL_WORSE * self.convex[0].chi_squared:
            return
        problem = self._with_own_error(axial[0])
        rates: list[Weighted] = []
        for each in axial:
            rate = float(each.state[0])
            if all(2.0 * abs(rate - o.refined.state[0]) > _AXIAL_RATE for o in rates):
                rates.append(self._robust(problem, each))
                if len(rates) > _AXIAL_OTHERS:
                    break
        rates.sort(key=lambda each: each.evidence)
        fixed = self._fixed(rates[0].refined.state)
        for one in rates:
            if one.evidence < rates[0].evidence + _AXIAL_MAPPED:
                given = one.refined.state, self.generator, self.tie, fixed, lambda: self.is_over
                self.axial += _pole_map.minima(rates[0].problem, self.problem, *given)
                self.progress(f"{len(self.axial)} poles of rotations about one axis")
        self.axial = _pole_map.most_probable(self.axial, len(problem))
        for minimum in self.axial[:_AXIAL_OTHERS]:
            self.convex.append(
                _refinement.refine(
                    self.problem, minimum.state, tie=self.tie, fixed=fixed, gain=3e-3
                )
            )
        self.convex.sort(key=lambda each: each.cost)

    def _refine(self, pool: Pool, keep: int = _CONVEX, poles: int = _POLES) -> None:
        """Add the convex bodies of the best distinct ellipsoids."""
        chosen: list[FloatArray] = []
        for state in pool.states:
            alike = [other for other in chosen if has_rates(state, other)]
            if len(alike) < poles and not any(is_same(state, other) for other in alike):
                chosen.append(state)
                if len(chosen) >= keep:
                    break
        for state in chosen:
            self.convex.append(
                _refinement.refine(
                    self.problem,
                    state,
                    tie=self.tie,
                    fixed=self._fixed(state),
                    gain=3e-3,
                )
            )
            if self.is_over and len(self.convex) > 4:
                break
        self.convex.sort(key=lambda each: each.cost)
        self.progress(f"{len(self.convex)} convex bodies")

    def finish(self) -> None:
        """Make `solutions` of the best convex bodies, with robust errors."""
        if not self.convex:
            return
        chosen: list[Refined] = []
        for each in self.convex:
            alike = [other for other in chosen if has_rates(each.state, other.state)]
            if len(alike) < _POLES and not any(is_same(each.state, o.state) for o in alike):
                chosen.append(each)
                if len(chosen) >= _FINAL:
                    break
        problem = self._with_own_error(chosen[0])
        found = [self._robust(problem, each) for each in chosen if not is_axial(each.state)]
        found += self._axial_solutions(problem)
        found.sort(key=lambda each: each.evidence)
        self.solutions = []
        for one in found:
            if not any(is_same(one.refined.state, o.refined.state) for o in self.solutions):
                self.solutions.append(one)
        error = problem.model_error
        self.progress(f"{len(self.solutions)} solutions, model error {error:.3f} mag")

    def _with_own_error(self, best: Refined) -> CurveProblem:
        """The problem with the model error that the residuals of a body show."""
        residual, _ = _refinement.residuals(self.problem, best.magnitude)
        error = _refinement.model_error(self.problem, residual)
        for _ in range(2):
            fitted = self._robust(self.problem.with_model_error(error), best)
            error = _refinement.model_error(self.problem, fitted.residual)
        return self.problem.with_model_error(error)

    def _axial_solutions(self, problem: CurveProblem) -> list[Weighted]:
        """Rotations about one axis with the errors of a problem, the most probable poles."""
        axial = [each for each in self.convex if is_axial(each.state)]
        if not self.axial:
            return [self._compared(problem, each) for each in axial[:_AXIAL_OTHERS]]
        found: list[Weighted] = []
        for each in self.axial:
            if not any(is_same(each.state, other.refined.state) for other in found):
                found.append(self._robust(problem, each))
        # their own prior ranks poles; with the one of tumbling bodies they are compared with those
        more = _refinement.widened(min(found, key=lambda each: each.evidence))
        found = [replace(each, evidence=each.evidence + more) for each in found]
        found, self.beside = _pole_map.listed(found, _AXIAL_BEHIND)
        found = found[:_FINAL_AXIAL]
        # the next period decides whether this one is accepted, however far it lies behind
        rates = np.array([each.refined.state[0] for each in found])
        others = [each for each in axial if 2.0 * np.abs(rates - each.state[0]).min() > _AXIAL_RATE]
        return found + [self._compared(problem, each) for each in others[:_AXIAL_OTHERS]]

    def _compared(self, problem: CurveProblem, given: Refined) -> Weighted:
        """A rotation about one axis with the evidence that tumbling bodies are ranked by."""
        found = self._robust(problem, given)
        return replace(found, evidence=found.evidence + _refinement.widened(found))

    def _robust(self, problem: CurveProblem, given: Refined) -> Weighted:
        # the more frequencies of nutation were tried, the better one fits by chance
        trials = 1.0 if is_axial(given.state) else self.most / TUMBLERS
        return _refinement.refined(
            problem,
            given.state,
            tie=self.tie,
            fixed=self._fixed(given.state),
            trials=trials,
        )

    def _fixed(self, state: FloatArray) -> BoolArray:
        """Parameters that stay: of the axis for rotation about one, of areas for ellipsoids."""
        fixed = np.zeros(_refinement.SIZE, bool)
        if is_axial(state):
            fixed[:8] = _ellipsoid.AXIAL_FIXED[:8]
        if self.is_ellipsoid:
            fixed[10:] = True
        return fixed
