"""The blind search: candidate rates, ellipsoids from many starts, convex bodies, robust errors.

Rounds go on, with more pairs and more starts each, until the verdict is met or the budget is spent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np

from attitude._support.arrays import distinct, in_turn
from attitude.inversion import (
    _ellipsoid,
    _evidence,
    _lattices,
    _neighbours,
    _pole_map,
    _refinement,
    _satellites,
    _shapes,
    _verdicts,
)
from attitude.inversion._ellipsoid import SearchState, is_axial
from attitude.inversion._refinement import MOTION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.inversion._ellipsoid import Pool
    from attitude.inversion._evidence import Robust
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import BodyFit, Refined
    from attitude.inversion._satellites import AdditivePair, Explained
    from attitude.inversion._settings import Settings
    from attitude.inversion._shapes import Tie


Fit = TypeVar("Fit")


def never(_: bool) -> bool:
    """False: a search goes on."""
    return False


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
    progress : callable
        Called with a text after each stage.
    convex : list of BodyFit
        The best first.
    solutions : list of Robust
        The best first; those of the last `finish`.
    axial : list of Refined
        Rotations about one axis from a map of poles, the most probable first.
    held_poles : list of Refined
        The best bodies at held poles that compete with those, the most probable first.
    beside : list of Robust
        Those that are not among `solutions`, for a better pole lies near.
    dips : list of AdditivePair
        Additive series that leave at most twice the residuals of the best.
    rival : Search
        For a rotation about one axis with a moon, if that competes.
    constant : str
        In words, how a constant brightness with zero points of the sessions competes.
    is_complete : bool
        Whether the first round came to its end.
    is_interrupted : bool
        Whether Ctrl-C ended it.
    redundancy : float
        Points that count as one in differences of evidence between poles.
    length : float
        Spans from one apparition to another one that is joined with it; 0 of one search.
    """

    problem: CurveProblem
    most: float
    modes: tuple[str, ...]
    tie: Tie
    shifts: tuple[float, ...]
    generator: np.random.Generator
    progress: Callable[[str], object]
    convex: list[BodyFit] = field(default_factory=list)
    solutions: list[Robust] = field(default_factory=list)
    axial: list[Refined] = field(default_factory=list)
    held_poles: list[Refined] = field(default_factory=list)
    beside: list[Robust] = field(default_factory=list)
    dips: list[AdditivePair] = field(default_factory=list)
    is_complete: bool = False
    is_interrupted: bool = False
    rival: Search | None = None
    constant: str = ""
    _mapped_rates: list[FloatArray] = field(default_factory=list)
    _short_fits: list[BodyFit] = field(default_factory=list, init=False)
    # Rotations about one axis with the prior of tumbling bodies.
    _wide: list[BodyFit] = field(default_factory=list, init=False)
    # Pairs of frequencies (P, 2) of the last round, the best first.
    _pairs: FloatArray = field(default_factory=lambda: np.empty((0, 2)), init=False)
    # Robust fits by the identities of what they depend on, with these objects.
    _known_fits: dict[tuple[int, ...], tuple[object, ...]] = field(default_factory=dict, init=False)
    _own_problems: list[CurveProblem] = field(default_factory=list, init=False)
    is_ellipsoid: bool = False
    redundancy: float = 1.0
    length: float = 0.0
    notes: list[str] = field(default_factory=list)

    @property
    def settings(self) -> Settings:
        """Those of the problem."""
        return self.problem.settings

    @property
    def is_over(self) -> bool:
        """Whether the budget is spent."""
        return self.problem.tally.is_over

    def is_same(self, a: FloatArray, b: FloatArray) -> bool:
        """Whether two states have one mode, the same rates and the same pole."""
        return self.has_rates(a, b) and _ellipsoid.have_pole(a, b, self.settings.same_pole)

    def has_rates(self, a: FloatArray, b: FloatArray) -> bool:
        """Whether two states have one mode and the same rates."""
        return bool(self._with_rates(a, b))

    def _with_rates(self, states: FloatArray, state: FloatArray) -> BoolArray:
        """Which of the states (..., 16 or more) have the mode and the rates of one."""
        return _ellipsoid.have_rates(states, state, self.settings.same_rate)

    def begin(self, states: Iterable[FloatArray]) -> None:
        """Make `solutions` from states alone, such as those that another search has found."""
        self.convex = [self._fit(state) for state in states]
        self.convex.sort(key=lambda fit: fit.cost)
        self.finish()

    def follow(self, other: Search) -> None:
        """Make `solutions` from the best bodies of a search of the same curve, with these terms."""
        self.begin([fit.state for fit in other.convex[: self.settings.convex]])
        self.is_complete = other.is_complete

    def run(self, is_ended: Callable[[bool], bool] = never) -> None:
        """Search until the verdict is met, the budget is spent, or `is_ended`.

        `is_ended` is called after each round, and in the first round also before poles are mapped
        (with False) and after the first bodies (with True: it is early).
        """
        self._axial()
        for number in range(self.settings.rounds):
            thinned = self._thinned(self.problem, number)
            self._short_fits = []
            for stage, pool in enumerate(self._pools(thinned, number)):
                self._refine(pool, thinned)
                if number == stage == 0 and self._ends(is_ended, is_early=True):
                    return
            if self.shifts and not self.is_over:
                rates = self._displaced()
                pool = self._around(thinned, rates, self.settings.alias_starts, 30)
                best_of_each = _ellipsoid.best_of_each(pool, len(rates))
                self._refine(_ellipsoid.in_order(best_of_each), thinned)
            if number == 0:
                # zero points decide what fits: the maps of poles are those of the right ones
                if self._ends(is_ended, is_early=False):
                    return
                self._axial_poles()
                self.is_complete = not self.is_over
            self.finish()
            if self._hardly_nutating():
                self.finish()
            # where a moon explains what no body does, poles of these are sought in vain
            is_first = number == 0 and bool(self.solutions) and not self.is_at_floor
            if is_first:
                self._compare_with_satellite()
            if not self._is_far_behind_satellite and self._other_poles():
                self.finish()
            if number == 0 and not is_first:
                self._compare_with_satellite()
            is_accepted = self.is_decided and not self._is_doubtful
            if self.is_over or is_accepted or is_ended(False):
                break
            are_all = self._poles_of_classes(number)
            if number == 0:
                # these maps look for tumbling states that ellipsoids misjudge
                self.is_complete = are_all or self._rotates_within_errors
            if not are_all or self.is_over or self.is_decided:
                break
            self.problem = self._clipped()

    def _ends(self, is_ended: Callable[[bool], bool], *, is_early: bool) -> bool:
        """Whether a search that can be ended is, by its solutions so far."""
        if is_ended is never or self.is_over:
            return False
        self.finish(self.settings.compared)
        return is_ended(is_early)

    @property
    def _held(self) -> _ellipsoid.Held:
        """What holds the moments of the motions of ellipsoids."""
        if self.tie.moments is None:
            return _ellipsoid.Held(self.settings.tie)
        a, b, c = np.log(self.tie.moments).tolist()
        return _ellipsoid.Held(self.settings.tie_given, (a, b, c))

    @property
    def is_decided(self) -> bool:
        """Whether the verdict is met."""
        if self.rival is not None:
            return self.satellite_is_ahead() > self.rival.needed_ahead
        return self.verdict_of(self.solutions, is_strict=True)[0] != _verdicts.OPEN

    @property
    def _is_doubtful(self) -> bool:
        """Whether a tumbling body is the best that hardly fits."""
        if self.rival or not self.solutions or is_axial(self.solutions[0].refined.state):
            return False
        return _verdicts.is_doubtful(self.solutions[0], self.problem)

    def verdict_of(
        self, solutions: Sequence[Robust], *, is_strict: bool = False
    ) -> tuple[str, str]:
        """The verdict of solutions of this search, and its criterion in words."""
        verdict = _verdicts.verdict(
            solutions,
            self.problem,
            self.is_complete,
            self.most,
            is_given_axis=self.modes == ("PA",),
            is_hidden=not self.tie.is_wide,
            is_interrupted=self.is_interrupted,
            is_strict=is_strict,
        )
        return _verdicts.of_dips(verdict, solutions, self.problem, self.dips)

    @property
    def _is_far_behind_satellite(self) -> bool:
        """Whether no map of poles brings tumbling bodies near the rival with a moon."""
        if self.rival is None:
            return False
        gained = self.settings.axial_tumbling
        return self.satellite_is_ahead() > self.rival.needed_ahead + gained

    def satellite_is_ahead(self) -> float:
        """By how much the evidence of the rival with a moon is better than that of the best.

        Without what points far from others gain, as those of a survey: noise makes dips of them.
        """
        if self.rival is None:
            return -math.inf
        is_far = ~_neighbours.are_close(self.problem, self.rival.problem.orbit)
        best, body = self.rival.solutions[0], self.solutions[0]
        gained = max(0.0, _evidence.gain(best, body, self.problem, is_far))
        return self.evidence() - self.rival.evidence() - gained

    @property
    def is_at_floor(self) -> bool:
        """Whether the best solution leaves no more than the errors."""
        return _evidence.floor_ratio(self.solutions[0], self.problem) < self.settings.floor

    @property
    def _rotates_within_errors(self) -> bool:
        """Whether a rotation about one axis is the best, and leaves no more than the errors."""
        if not self.solutions or not is_axial(self.solutions[0].refined.state):
            return False
        return self.is_at_floor

    @property
    def needed_ahead(self) -> float:
        """By how much the best rotation beside an orbit has to be ahead of every body alone."""
        return self.settings.satellite if self.is_at_floor else self.settings.alone

    def evidence(self) -> float:
        """That of the best solution among those of other zero points and series."""
        orbits = self.most if self.problem.orbit else 1.0
        return _evidence.among_problems(self.solutions[0], orbits)

    def _compare_with_satellite(self) -> None:
        """Search for a rotation about one axis beside the series of an orbit, if series fit."""
        if self.problem.orbit or not self.solutions:
            return
        if self.is_over:
            # moons imitate tumbling: it is not claimed without this comparison
            self.is_complete &= is_axial(self.solutions[0].refined.state)
            return
        least = (1.0 - self.settings.moon_share) * self.problem.tally.left
        rivals = self._beside_bodies(least)
        if not any(self._is_ahead(rival) for rival in rivals):
            rivals += self._beside_series(least)
        if not rivals:
            return
        rival = min(rivals, key=lambda one: one.evidence())
        self.progress(f"a satellite is {rival.evidence() - self.evidence():.1f} behind")
        ahead = self.evidence() - rival.evidence()
        if ahead > -self.settings.competing:
            # the map of its poles costs a sixth of a budget
            if ahead > rival.needed_ahead - self.settings.mapped_behind:
                rival._axial_poles()
            rival.is_complete = not self.is_over
            rival.finish()
            self.rival = rival

    def _is_ahead(self, rival: Search) -> bool:
        return rival.evidence() + rival.needed_ahead < self.evidence()

    def _beside_bodies(self, least: float) -> list[Search]:
        """Searches for rotations about one axis beside the orbits of what the best ones leave.

        None begins with less than the `least` of the budget left.
        """
        axial: list[BodyFit] = [
            one.refined for one in self.solutions if is_axial(one.refined.state)
        ]
        axial += [fit for fit in self.convex if is_axial(fit.state)]
        most = 1 if self.is_at_floor else self.settings.orbit_bodies
        bodies = distinct(axial, lambda a, b: self.has_rates(a.state, b.state), most)
        rivals: list[Search] = []
        for body in bodies:
            alone = self._explained(body)
            rates = alone.rate * np.array([0.5, 1.0, 2.0])
            orbits = self._with_orbits((pair, alone) for pair in _satellites.orbits_beside(alone))
            if body is bodies[0]:
                # beside a worse rotation a series takes up what that lacks: it says nothing of dips
                self.dips += [pair for pair, _ in orbits]
            rivals += self._rivals(orbits, rates, least)
            if not self.is_at_floor:
                # dips that are deeper than what the rotation shows are all that a body explains
                rivals += self._beside_series(least, alone.rate)
            is_spent = self.problem.tally.left < least
            if is_spent or any(self._is_ahead(rival) for rival in rivals):
                break
        return rivals

    def _beside_series(self, least: float, orbit: float | None = None) -> list[Search]:
        """Searches for a rotation about one axis beside orbits of pairs of series, or near one."""
        pairs = _satellites.rivals(self.problem, self.most, self.settings.orbits, orbit)
        orbits = self._with_orbits(
            (pair, _satellites.of_series(self.problem, pair.rotation)) for pair in pairs
        )
        self.dips += [pair for pair, _ in orbits]
        return self._rivals(orbits, _satellites.rates_of(pairs), least)

    def _with_orbits(
        self, pairs: Iterable[tuple[AdditivePair, Explained]]
    ) -> list[tuple[AdditivePair, CurveProblem]]:
        """Pairs that leave little, with how much they brighten, and the problem with each orbit."""
        most = self.settings.orbit_worse**2 * self._left
        return [self._with_orbit(pair, alone) for pair, alone in pairs if pair.left <= most]

    def _with_orbit(
        self, pair: AdditivePair, alone: Explained
    ) -> tuple[AdditivePair, CurveProblem]:
        problem = _satellites.beside(self.problem, pair, alone)
        return pair._replace(brightens=_satellites.brightening(problem, alone)), problem

    @property
    def _left(self) -> float:
        """The share of the variance that the best solution leaves."""
        return _evidence.share_left(self.solutions[0], self.problem)

    def _rivals(
        self,
        orbits: Sequence[tuple[AdditivePair, CurveProblem]],
        rates: FloatArray,
        least: float,
    ) -> list[Search]:
        """Searches for rotations about one axis at rates (R,) beside orbits."""
        rivals: list[Search] = []
        for pair, problem in orbits:
            if self.problem.tally.left < least:
                break
            if pair.only_dims:
                rivals += self._beside(problem, rates)
            elif self._may_brighten(pair, rivals):
                rivals += self._beside_other_rotation(problem, rates)
        return rivals

    def _may_brighten(self, pair: AdditivePair, rivals: Sequence[Search]) -> bool:
        """Whether a wrong rotation may have made the series of a moon brighten.

        Where the best solution is at the floor no such series came ahead.
        """
        is_sought = not self.is_at_floor and not any(self._is_ahead(rival) for rival in rivals)
        return is_sought and pair.left < self._left

    def _beside_other_rotation(self, problem: CurveProblem, rates: FloatArray) -> list[Search]:
        """The search beside the orbit of a problem, where a wrong rotation made it brighten."""
        rotations = self._beside(problem, rates)
        if not rotations:
            return []
        body = rotations[0].solutions[0].refined
        alone = self._explained(body)
        orbit = _satellites.fitted_beside(alone, problem.orbit)
        pair, problem = self._with_orbit(orbit, alone)
        return self._beside(problem, np.array([alone.rate])) if pair.only_dims else []

    def _beside(self, problem: CurveProblem, rates: FloatArray) -> list[Search]:
        """The search for a rotation about one axis at rates (R,), or at lines, beside an orbit."""
        rival = replace(
            self,
            problem=problem,
            convex=[],
            solutions=[],
            axial=[],
            held_poles=[],
            beside=[],
            dips=[],
            notes=[],
        )
        rival._axial(_satellites.rates_beside(problem, rates, self.most))
        rival.finish()
        return [rival] if rival.solutions else []

    def _explained(self, body: BodyFit) -> Explained:
        """What a rotation about one axis explains, all bodies near one."""
        problem = self.problem.with_model_error(self.settings.body_error)
        return _satellites.of_body(problem, body, self.tie, self._fixed(body.state))

    def _clipped(self) -> CurveProblem:
        """The problem with the weights that the points have beside the best solution.

        Outliers turn least squares to other rates; by Student's distribution they hardly count.
        """
        square = (self.solutions[0].residual / self.problem.errors) ** 2
        return self.problem.with_weights(_evidence.weights(square))

    def _thinned(self, problem: CurveProblem, number: int) -> CurveProblem:
        """A problem with as many of its points as ellipsoids of a round are fitted to."""
        problem = problem.with_few_nodes()
        step = round(len(problem) / (self.settings.scan_points * 2**number))
        return problem.part(np.arange(len(problem)) % step == 0) if step > 1 else problem

    def _pools(self, problem: CurveProblem, number: int) -> Iterator[Pool]:
        """Ellipsoids of a round: of the lattices, then of every psi with the best lines."""
        more = 2**number
        count = self.settings.pairs * more
        self._pairs, _ = _lattices.lattice_pairs(self.problem, self.most, count)
        rates = _lattices.candidates(self._pairs, self.most, self.modes, self.shifts)
        first = self._pairs[: self.settings.first_pairs * more]
        end = len(_lattices.candidates(first, self.most, self.modes, self.shifts))
        starts = self.settings.quick_starts * more
        yield self._ellipsoids(problem, rates, None, starts, end, more, "periods of the lines")
        if number == 0 and self._is_clear():
            return
        rates, poles = self._scan()
        starts = self.settings.scan_starts * more
        yield self._ellipsoids(problem, rates, poles, starts, len(rates), more, "periods of psi")

    def _is_clear(self) -> bool:
        """Whether a tumbling state is at the floor and others are far behind: none is sought."""
        if self.is_over or not self.convex or is_axial(self.convex[0].state):
            return False
        self.finish(self.settings.compared)
        best = self.solutions[0]
        return (
            not is_axial(best.refined.state)
            and self.is_at_floor
            and _verdicts.gap(self.solutions, self.problem) > self.settings.clear
        )

    def _ellipsoids(
        self,
        problem: CurveProblem,
        rates: list[_lattices.Candidate],
        poles: FloatArray | None,
        starts: int,
        end: int,
        more: int,
        name: str,
    ) -> Pool:
        """Ellipsoids of rates, from poles (R, P, 3) too if given, with more starts for the best.

        Each of the rates up to a number, `end`, has so many starts, others have half of these.
        A few starts of few steps miss one body in ten: each pair of rates has many, of which the
        best go on.
        """
        parts = []
        for start in range(0, len(rates), self.settings.block):
            block_of_rates = rates[start : start + self.settings.block]
            block_of_poles = None if poles is None else poles[start : start + len(block_of_rates)]
            parts.append(
                _ellipsoid.narrowed(
                    problem,
                    self.generator,
                    block_of_rates,
                    starts if start < end else max(1, starts // 2),
                    tie=self._held,
                    poles=block_of_poles,
                )
            )
            self.progress(f"ellipsoids: {start + len(block_of_rates)} of {len(rates)} {name}")
            if self.is_over:
                break
        pool = _ellipsoid.in_order(*parts)
        deep = [pool]
        settings = self.settings
        of_low_cost = pool.rows(np.flatnonzero(self._have_low_cost(pool)))
        rates_of_best = _ellipsoid.rates_of(of_low_cost, settings.classes)
        least = _ellipsoid.rates_of(pool, settings.deep_least)
        for rate in max(rates_of_best, least, key=len):
            if self.is_over:
                break
            count = settings.deep_starts * more
            deep.append(_ellipsoid.deep(problem, self.generator, rate, count, tie=self._held))
        return _ellipsoid.in_order(*deep)

    def _have_low_cost(self, pool: Pool) -> BoolArray:
        """Which ellipsoids (S,) of a pool do not cost far more than the best."""
        return pool.cost < self.settings.far_worse * pool.cost.min(initial=math.inf)

    def _around(
        self, problem: CurveProblem, rates: list[_lattices.Candidate], count: int, iterations: int
    ) -> Pool:
        """Ellipsoids from so many random starts for each pair of rates."""
        return _ellipsoid.around(
            problem, self.generator, rates, count, iterations=iterations, tie=self._held
        )

    def _scan(self) -> tuple[list[_lattices.Candidate], FloatArray]:
        """Rates with a line of the best solutions, of phi or of phi and psi, and every nutation.

        And the pole (R, 2, 3) of each of these, with its mirror image: of a body that is far from
        an ellipsoid few starts find the nutation and the pole at once.
        """
        rates: list[_lattices.Candidate] = []
        poles: list[FloatArray] = []
        used: list[float] = []
        normal = _pole_map.plane_of(self.problem)
        for fit in self.convex:
            fields = SearchState.of(fit.state)
            phi, psi = fields.rates
            both = np.stack([fields.pole, _pole_map.mirrored(fields.pole, normal)])
            for line in (phi, phi + psi):
                if len(rates) < self.settings.scan_rates and not any(
                    abs(line - other) < _lattices.STEP for other in used
                ):
                    used.append(line)
                    rates += _lattices.of_line(line, self.most, self.modes)
                    poles += [both] * (len(rates) - len(poles))
        return rates, np.array(poles).reshape(-1, 2, 3)

    def _displaced(self) -> list[_lattices.Candidate]:
        """Rates of the best solutions with lines displaced by the windows of the epochs.

        Lines lie at even numbers of psi: a shift of a line moves psi by half of it.
        """
        rates: list[_lattices.Candidate] = []
        tumbling = (fit.state for fit in self.convex if not is_axial(fit.state))
        for state in distinct(tumbling, self.has_rates, self.settings.scanned):
            phi, nutation = SearchState.of(state).rates
            for shift in (0.0, *self.shifts):
                for fraction in (-1.0, -0.5, 0.5, 1.0) if shift else (0.0,):
                    moved = [
                        (phi + fraction * shift, nutation),
                        (phi, abs(nutation + fraction * shift)),
                    ]
                    rates += [
                        _lattices.Candidate(0.5 * rate, f)
                        for a, b in moved
                        for rate, f in ((a + b, b), (a, -b), (a + 2.0 * b, -b))
                        if min(a, b) > _lattices.LEAST
                        and rate + max(-f, 0.0) < self.most
                        and ("LAM" if f > 0.0 else "SAM") in self.modes
                    ]
        return list(dict.fromkeys(rates))

    def _axial(self, rates: FloatArray | None = None) -> None:
        """Rotations about one axis at rates (R,), turns per span, or at those of strong lines."""
        if rates is None:
            rates = _lattices.rotations(self.problem, self.most, self.settings.axial_rates)
        rates = rates[rates > _lattices.LEAST]
        pool = _ellipsoid.axial(self.problem, self.generator, rates, self.settings.axial_starts)
        self._refine(_ellipsoid.in_order(pool), self.problem, keep=self.settings.convex // 2)
        self.progress("rotations about one axis")

    def _axial_poles(self) -> None:
        """Rotations about one axis from poles all over the sky, if one explains the curve."""
        axial = [fit for fit in self.convex if is_axial(fit.state)]
        if not axial or self.is_over:
            return
        problem = self._with_own_error(axial[0])
        if axial[0].chi_squared > self.settings.axial_worse * self.convex[0].chi_squared:
            # within the errors a tumbling body of other periods is no better
            rotation = self._robust(problem, axial[0])
            if _evidence.floor_ratio(rotation, problem) > self.settings.floor:
                return
        rates: list[Robust] = []
        for fit in axial:
            rate = SearchState.of(fit.state).precession
            others = (SearchState.of(one.refined.state).precession for one in rates)
            if all(2.0 * abs(rate - other) > self.settings.axial_width for other in others):
                rates.append(self._robust(problem, fit))
                if len(rates) > self.settings.axial_others:
                    break
        rates = _verdicts.behind_twice_the_period(rates, problem)
        rates = _evidence.ranked(rates)
        best, settings = rates[0], self.settings
        self.redundancy = _evidence.redundancy(best, problem)
        if self._is_far_behind(best, problem, settings.axial_tumbling):
            return
        coarse = replace(best.problem, settings=settings.with_coarse_map())
        for one in rates:
            if one.evidence < best.evidence + settings.axial_mapped:
                count = len(self.axial)
                state, is_best = one.refined.state, one is best
                leading = self._mapped(state, best.problem if is_best else coarse, problem)
                if leading and self._is_far_behind(
                    self._compared(problem, leading), problem, settings.axial_mapped
                ):
                    break
                if leading and not is_best and any(leading is fit for fit in self.axial[count:]):
                    self._mapped(leading.state, best.problem, problem)
        self.axial = self._most_probable(self.axial, problem)
        self.held_poles = self._most_probable(self.held_poles, problem)
        for minimum in self.axial[: self.settings.axial_others]:
            self.convex.append(self._fit(minimum.state))
        self.convex.sort(key=lambda fit: fit.cost)

    def _mapped(
        self, state: FloatArray, mapping: CurveProblem, problem: CurveProblem
    ) -> Refined | None:
        """The most probable rotation about one axis, after a map of poles at the rate of a state.

        A state (WIDTH,).
        """
        free, held = _pole_map.minima(
            mapping,
            self.problem,
            state,
            self.generator,
            self.tie,
            self._fixed(state),
            self.redundancy,
            lambda: self.is_over,
        )
        self.axial += free
        self.held_poles += held
        self.progress(f"{len(self.axial)} poles of rotations about one axis")
        return next(iter(self._most_probable(self.axial, problem)), None)

    def _most_probable(self, fits: list[Refined], problem: CurveProblem) -> list[Refined]:
        """Rotations about one axis that compete, the best first."""
        behind = self.settings.axial_pole_behind * self.redundancy
        return _pole_map.most_probable(fits, problem, behind)

    def _is_far_behind(self, rotator: Robust, problem: CurveProblem, width: float) -> bool:
        """Whether a tumbling body that has other lines is ahead of a rotation by a width."""
        best = self.convex[0]
        if is_axial(best.state):
            return False
        one = self._robust(problem, best)
        behind = rotator.evidence - one.evidence
        is_comb = _verdicts.counts_as(one, rotator, problem)
        return behind > width and not is_comb

    def _refine(self, pool: Pool, problem: CurveProblem, keep: int | None = None) -> None:
        """Add the convex bodies of the best distinct ellipsoids, which are those of a problem.

        Ellipsoids misjudge bodies that are far from one: pairs of rates, not single states, go on,
        in the order of convex bodies that are fitted in a few steps.
        """
        states = self._by_short_fits(pool, problem)
        chosen = self._various(states, self.settings.convex if keep is None else keep)
        self._add(self._worthy([states[k] for k in chosen]))
        self.progress(f"{len(self.convex)} convex bodies")

    def _various(self, states: Sequence[FloatArray], most: int) -> list[int]:
        """Numbers of states, `most` of them, of few poles for each pair of rates, each once."""
        chosen: list[int] = []
        motions = np.empty((0, _ellipsoid.WIDTH))
        for number, state in enumerate(states):
            alike = motions[self._with_rates(motions, state)]
            if len(alike) < self.settings.poles and not any(
                _ellipsoid.have_pole(state, other, self.settings.same_pole) for other in alike
            ):
                chosen.append(number)
                motions = np.concatenate([motions, state[None, : _ellipsoid.WIDTH]])
                if len(chosen) >= most:
                    break
        return chosen

    def _worthy(self, states: list[FloatArray]) -> list[FloatArray]:
        """States after a few convex steps, the best first, without those that stay far behind."""
        fits: list[BodyFit] = []
        problem = self.problem.with_few_nodes()
        for state in states:
            if self.is_over and fits:
                break
            fits.append(self._fit(state, self.settings.short_steps, problem))
        fits.sort(key=lambda fit: fit.cost)
        most = self.settings.short_worse * min(fit.cost for fit in (*fits[:1], *self.convex[:1]))
        return [
            fit.state
            for number, fit in enumerate(fits)
            if number < self.settings.short_least or fit.cost < most
        ]

    def _by_short_fits(self, pool: Pool, problem: CurveProblem) -> list[FloatArray]:
        """The states of a pool in the order of short convex fits of the best of each rates.

        Of all rates with few modes, of the best with all; to the points of the ellipsoids.
        """
        classes: list[list[FloatArray]] = []
        firsts = np.empty((0, _ellipsoid.WIDTH))
        have_low_cost = self._have_low_cost(pool)
        for number, state in enumerate(pool.states[: self.settings.short_states]):
            at = np.flatnonzero(self._with_rates(firsts, state))
            is_low = have_low_cost[number]
            most = self.settings.short_classes if is_low else self.settings.far_classes
            if at.size:
                classes[at[0]].append(state)
            elif len(classes) < most:
                classes.append([state])
                firsts = np.concatenate([firsts, state[None]])
        stages = (
            (len(classes), self.settings.first_steps, self.settings.short_modes),
            (self.settings.whole_classes, self.settings.short_steps, _shapes.MODES),
        )
        for most, steps, modes in stages:
            costs = []
            for members in classes[:most]:
                if self.is_over:
                    return list(pool.states)
                fit = self._fit(members[0], steps, problem, modes)
                members[0] = fit.state
                costs.append(fit.cost)
                if modes < _shapes.MODES and not is_axial(fit.state):
                    self._short_fits.append(fit)
            classes = [classes[k] for k in np.argsort(costs, kind="stable")]
        most = self.settings.short_members
        return [state for members in classes for state in members[:most]] + list(pool.states)

    def _fit(
        self,
        state: FloatArray,
        iterations: int = 20,
        problem: CurveProblem | None = None,
        modes: int = _shapes.MODES,
        gain: float = 3e-3,
    ) -> BodyFit:
        """The convex body near a state; of another problem, or with fewer modes, if given."""
        return _refinement.refine(
            self.problem if problem is None else problem,
            state,
            iterations=iterations,
            tie=self.tie,
            fixed=self._fixed(state),
            gain=gain,
            modes=modes,
        ).fitted

    def _add(self, states: Iterable[FloatArray], gain: float = 3e-3) -> None:
        """Add the convex bodies near states."""
        for state in states:
            self.convex.append(self._fit(state, gain=gain))
            if self.is_over and len(self.convex) > 4:
                break
        self.convex.sort(key=lambda body: body.cost)

    def _hardly_nutating(self) -> bool:
        """Make rotations about one axis of tumbling solutions that are hardly more; whether any.

        They compete with the prior of these: with their own they do not get to such shapes.
        """
        least = math.log(self.settings.wide)
        states = (SearchState.of(one.refined.state) for one in self.solutions)
        # rotation about the long axis is that of the most energy, which bodies lose
        short = (x.vector for x in states if x.nutation < 0.0 and x.log_rho < least)
        tried = [fit.state for fit in self._wide]
        rotations = map(_ellipsoid.without_nutation, short)
        new = (one for one in rotations if not any(self.is_same(one, state) for state in tried))
        starts = distinct(new, self.is_same, self.settings.axial_others)
        if self.is_over or not starts:
            return False
        tie = replace(self.tie, is_wide=True)
        for start in starts:
            fixed = self._fixed(start)
            wide = _refinement.refine(self.problem, start, tie=tie, fixed=fixed)
            self._wide.append(wide.fitted)
        return True

    def _other_poles(self) -> bool:
        """Add bodies at other poles with the rates of the best tumbling solutions; whether any.

        The mirror images of each, in the plane of the scene and in that of its pole, and minima
        all over the sky with both rates held.
        """
        leading = [
            one
            for one in self.solutions[: self.settings.mapped]
            if one.evidence < self.solutions[0].evidence + self.settings.mapped_behind
            and not is_axial(one.refined.state)
        ]
        before = len(self.convex)
        for one in leading:
            state = one.refined.state
            if self._is_to_be_mapped(state):
                self._add_mapped(state, state, *_pole_map.images(self.problem, state))
        self.progress(f"{len(self.convex) - before} bodies at other poles")
        return len(self.convex) > before

    def _poles_of_classes(self, number: int) -> bool:
        """Add the best bodies of short maps of poles at many pairs of rates; whether at all these.

        To thinned points, with the weights that they have beside the best solution: where outliers
        are most of what is left, bodies at any pole fit alike.  Where a body is far from an
        ellipsoid, ellipsoids with the true rates have wrong poles, or they mistake its rates: those
        of the best are tried too, and once more those of the new best.  Ends with `solutions` made
        anew.
        """
        clipped = self._clipped()
        thinned = self._thinned(clipped, number)
        odd = _lattices.candidates(self._pairs, self.most, self.modes, has_odd_lines=True)
        odd_rates = odd[: self.settings.odd_classes]
        with_odd_lines = _pole_map.with_lines(self.problem, self.generator, odd_rates)
        # those of bodies too: their steps from an ellipsoid may have led to rates that none had
        tumbling = (fit.state for fit in self.convex if not is_axial(fit.state))
        of_bodies = distinct(tumbling, self.has_rates, self.settings.body_classes)
        # in turn: the budget may end before the last ones
        states = in_turn(of_bodies, self._by_either_error(thinned), with_odd_lines)
        rates = distinct(states, self.has_rates, self.settings.mapped_classes)
        mapped: list[FloatArray] = []
        for _ in range(2):
            rates = [
                state
                for state in distinct((*rates, *self._mistaken()), self.has_rates)
                if not any(self.has_rates(state, other) for other in mapped)
            ]
            if not self._add_classes(clipped, thinned, rates):
                return False
            mapped += rates
            rates = []
        return True

    def _add_classes(
        self, clipped: CurveProblem, thinned: CurveProblem, rates: list[FloatArray]
    ) -> bool:
        """Add the best bodies of short maps of poles at rates of states; whether at all these."""
        settings = self.settings
        problem = clipped.with_model_error(settings.body_error)
        fits: list[BodyFit] = []
        are_all = True
        for state in rates:
            are_all = self.problem.tally.left >= settings.class_reserve
            if not are_all:
                break
            bodies = _pole_map.in_few_steps(thinned, self.generator, state, self._held, self.tie)
            fits += [
                self._fit(body.state, settings.short_steps, problem)
                for body in bodies[: settings.class_members]
            ]
        if not fits:
            return are_all
        fits.sort(key=lambda fit: fit.cost)
        states = [fit.state for fit in fits]
        best = [
            *distinct(states, self.has_rates, settings.class_finals),
            *distinct(states, self.is_same, settings.class_finals),
        ]
        self._add(self._fit(state, problem=problem).state for state in distinct(best, self.is_same))
        self.progress(f"{len(self.convex)} convex bodies after maps of many pairs of rates")
        self.finish()
        if self._other_poles():
            self.finish()
        return are_all

    def _by_either_error(self, thinned: CurveProblem) -> list[FloatArray]:
        """The states of short fits, the best with the error of ellipsoids or of bodies first."""
        rough = thinned.with_model_error(self.settings.body_error)
        steps, modes = self.settings.first_steps, self.settings.short_modes
        costs = [
            (fit.cost, self._fit(fit.state, steps, rough, modes).cost) for fit in self._short_fits
        ]
        places = np.argsort(np.argsort(np.array(costs).reshape(-1, 2), axis=0), axis=0)
        order = np.argsort(places.min(axis=1), kind="stable")
        return [self._short_fits[k].state for k in order]

    def _mistaken(self) -> Iterator[FloatArray]:
        """States at rates that ellipsoids mistake for those of the best tumbling bodies."""
        states = (one.refined.state for one in self.solutions)
        tumbling = (state for state in states if not is_axial(state))
        for state in distinct(tumbling, self.has_rates, self.settings.mistaken):
            fields = SearchState.of(state)
            for rate in _lattices.mistaken(*fields.rates, self.most, self.modes):
                yield fields._replace(precession=rate.precession, nutation=rate.nutation).vector

    def _is_to_be_mapped(self, state: FloatArray) -> bool:
        """Whether there is work left for the poles of a state, and no map from near its pole yet.

        Nor as many maps at its rates, from other poles, as are allowed.
        """
        mapped = [other for other in self._mapped_rates if self.has_rates(state, other)]
        width = self.settings.near_pole
        is_elsewhere = not any(_ellipsoid.have_pole(state, other, width) for other in mapped)
        return not self.is_over and is_elsewhere and len(mapped) < self.settings.maps

    def _add_mapped(self, state: FloatArray, *known: FloatArray) -> None:
        """Add the bodies of a map of poles at the rates of a state, behind known ones."""
        self._mapped_rates.append(state)
        with_rates = _pole_map.of_rates(
            self.problem, self.generator, state, self._held, self.tie, lambda: self.is_over
        )
        poles = distinct(
            (*known, *with_rates),
            lambda a, b: _ellipsoid.have_pole(a, b, self.settings.same_pole),
            bool(known) + self.settings.map_bodies,
        )
        self._add(poles[bool(known) :])

    def finish(self, most: int | None = None) -> None:
        """Make `solutions` of the best convex bodies, `most` of them, with robust errors."""
        if not self.convex:
            return
        most = self.settings.finals if most is None else most
        states = [fit.state for fit in self.convex]
        chosen = [self.convex[k] for k in self._various(states, most * self.settings.ranked)]
        problem = self._with_own_error(chosen[0])
        if self._takes_noise(problem, chosen[0]):
            problem = self._with_own_error(chosen[0])
        bodies = [self._ranked(problem, fit) for fit in chosen if not is_axial(fit.state)]
        tumbling = sorted(bodies, key=lambda fit: fit.cost)[:most]
        first = distinct(
            bodies, lambda a, b: self.has_rates(a.state, b.state), self.settings.firsts
        )
        tumbling += [fit for fit in first if all(fit is not other for other in tumbling)]
        solutions = [self._robust(problem, fit) for fit in tumbling]
        solutions += self._axial_solutions(problem, solutions)
        solutions += [self._compared(problem, fit) for fit in self._wide]
        solutions = _verdicts.behind_twice_the_period(solutions, problem)
        solutions = _verdicts.as_rotators(solutions, problem)
        solutions = _verdicts.behind_correlated(solutions, problem)
        self.solutions = distinct(
            _evidence.ranked(solutions), lambda a, b: self.is_same(a.refined.state, b.refined.state)
        )
        error = problem.model_error
        self.progress(f"{len(self.solutions)} solutions, model error {error:.3f} mag")

    def _ranked(self, problem: CurveProblem, body: BodyFit) -> BodyFit:
        """A body after some steps with the errors of a problem."""

        def fit() -> BodyFit:
            return self._fit(body.state, self.settings.ranked_steps, problem)

        return self._known(fit, problem, body, "ranked")

    def _takes_noise(self, problem: CurveProblem, best: BodyFit) -> bool:
        """Whether errors are enlarged, where neighbouring residuals of a good body exceed them."""
        one = self._robust(problem, best)
        if _evidence.share_left(one, problem) > self.settings.left:
            return False
        rates = SearchState.of(one.refined.state).rates
        factors = _neighbours.noise(problem, one.residual, sum(rates))
        factors = np.where(factors < self.settings.noisier, 1.0, factors)
        low, high = float(factors.min()), float(factors.max())
        if high == 1.0:
            return False
        self.problem = self.problem.with_errors(factors * self.problem.sigma)
        size, by = (f"{high:.1f}", "this factor")
        if low < high:
            size, by = (f"up to {high:.1f}", "the factor of each night")
        self.notes.append(
            f"neighbouring residuals differ {size} times as much as the errors say; errors are "
            f"taken to be larger by {by}."
        )
        return True

    def _with_own_error(self, best: BodyFit) -> CurveProblem:
        """The problem with the model error that the residuals of a body show."""
        return self._known(lambda: self._with_error_of(best), self.problem, best)

    def _with_error_of(self, best: BodyFit) -> CurveProblem:
        """That, or the one of another body with nearly the same error, whose fits are known."""
        problem = _evidence.with_error_of(self.problem, best.magnitude)
        for _ in range(2):
            residual = self._weighted(problem, best, is_wide=False).residual
            problem = problem.with_model_error(_evidence.model_error(problem, residual))
        for other in self._own_problems:
            is_alike = abs(other.model_error / problem.model_error - 1.0) < self.settings.same_error
            if is_alike and other.sigma is problem.sigma and other.terms is problem.terms:
                return other
        self._own_problems.append(problem)
        return problem

    def _axial_solutions(self, problem: CurveProblem, tumbling: Sequence[Robust]) -> list[Robust]:
        """Rotations about one axis with the errors of a problem, the most probable poles.

        Few of them where a tumbling state is ahead.
        """
        axial = [fit for fit in self.convex if SearchState.of(fit.state).is_axial]
        if not self.axial:
            return [self._compared(problem, fit) for fit in axial[: self.settings.axial_others]]
        listed_ones: list[Robust] = []
        rotator = self._compared(problem, self.axial[0])
        # those on its comb count as this rotation
        others = (one for one in tumbling if not _verdicts.counts_as(one, rotator, problem))
        ahead = min((one.evidence for one in others), default=math.inf)
        behind = rotator.evidence - ahead
        is_behind = behind > self.settings.mapped_behind
        most = self.settings.axial_others if is_behind else self.settings.axial_freed
        for fit in self.axial:
            if len(listed_ones) < most and not any(
                self.is_same(fit.state, other.refined.state) for other in listed_ones
            ):
                listed_ones.append(self._robust(problem, fit))
        # their own prior ranks poles; with the one of tumbling bodies they are compared with those
        best = _evidence.ranked(listed_ones)[0]
        more = _evidence.of_common_prior(best, self._compared(problem, best.refined))
        listed_ones = [_evidence.with_term(one, more) for one in listed_ones]
        listed_ones = _verdicts.behind_twice_the_period(listed_ones, problem)
        is_doubtful = _verdicts.is_doubtful(best, problem)
        behind = self.settings.alone if is_doubtful else self.settings.axial_behind
        behind *= _evidence.redundancy(best, problem)
        listed_ones, self.beside = _pole_map.listed(listed_ones, behind, self.settings)
        if not is_behind:
            listed_ones += self._between(problem, listed_ones, more, behind)
        listed_ones = listed_ones[: self.settings.axial_finals]
        next_ones = self._of_other_rates(listed_ones, axial, self.settings.axial_width)
        return listed_ones + [self._compared(problem, fit) for fit in next_ones]

    def _of_other_rates(
        self, entries: Sequence[Robust], fits: Iterable[BodyFit], width: float
    ) -> list[BodyFit]:
        """The best rotations about one axis at no rate of a list.

        The next period decides whether one is accepted, however far it lies behind.
        """
        rates = np.array([SearchState.of(one.refined.state).precession for one in entries])
        others = [
            fit
            for fit in fits
            if 2.0 * np.abs(rates - SearchState.of(fit.state).precession).min() > width
        ]
        return others[: self.settings.axial_others]

    def _known(self, make: Callable[[], Fit], *arguments: object) -> Fit:
        """The fit of these objects, made once: solutions are ranked anew whenever bodies come."""
        key = tuple(id(argument) for argument in arguments)
        if key not in self._known_fits:
            # what identifies the fit is kept, so that no other object gets its identity
            self._known_fits[key] = *arguments, make()
        return cast("Fit", self._known_fits[key][-1])

    def _compared(self, problem: CurveProblem, body: BodyFit) -> Robust:
        """A rotation about one axis with the prior and the evidence of tumbling bodies."""
        return self._robust(problem, body, is_wide=True)

    def _robust(self, problem: CurveProblem, body: BodyFit, *, is_wide: bool = False) -> Robust:
        """The body of largest posterior density near a body."""
        return self._known(
            lambda: self._weighted(problem, body, is_wide=is_wide), problem, body, is_wide
        )

    def _weighted(self, problem: CurveProblem, body: BodyFit, *, is_wide: bool) -> Robust:
        # the more frequencies of nutation were tried, the better one fits by chance
        trials = 1.0 if is_axial(body.state) else self.most / self.settings.odds
        return _evidence.refined(
            problem,
            body.state,
            tie=replace(self.tie, is_wide=True) if is_wide else self.tie,
            fixed=self._fixed(body.state),
            trials=trials,
        )

    def _between(
        self, problem: CurveProblem, entries: Sequence[Robust], more: float, behind: float
    ) -> list[Robust]:
        """Rotations at held poles that compete with the entries of a list, and are none of these.

        Where nearly any pole fits, minima alone do not say so.  None of them comes first, for the
        best were started from with the pole free.  `more` is added to their evidence.
        """
        places = max(0, self.settings.axial_finals - len(entries))
        states = [entry.refined.state for entry in entries]
        far = _pole_map.apart(self.held_poles, states, self.settings)
        held = [_evidence.with_term(self._at_pole(problem, fit), more) for fit in far[:places]]
        least = entries[0].evidence
        return [_evidence.at_least(one, least) for one in held if one.evidence < least + behind]

    def _at_pole(self, problem: CurveProblem, body: BodyFit) -> Robust:
        """The rotation about one axis of largest posterior density at the pole of a body."""
        fixed = self._fixed(body.state)
        held = fixed.copy()
        held[_refinement.TILT] = True

        def fit() -> Robust:
            return _evidence.refined(problem, body.state, tie=self.tie, fixed=fixed, held=held)

        return self._known(fit, problem, body, "held")

    def _fixed(self, state: FloatArray) -> BoolArray:
        """Parameters that stay: of the axis for rotation about one, of areas for ellipsoids."""
        fixed = np.zeros(_refinement.SIZE, bool)
        if is_axial(state):
            fixed[:MOTION] = _ellipsoid.AXIAL_FIXED[:MOTION]
        if self.is_ellipsoid:
            fixed[_ellipsoid.PARAMETERS :] = True
        return fixed
