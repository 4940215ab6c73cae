"""`Settings`: the thresholds of a search, each with its reason; `Tally`: the work that it has done.

A field is what decides which states are accepted, listed, compared or searched further, and how
many, and what work costs.  What belongs to a method stands beside it, as a constant with a reason:
grids, orders, steps and damping, laws of distributions, tests for degenerate shapes, and what a
record without a problem is judged by, as the dips of `_satellites.AdditivePair`.

A problem carries `Settings` and `Tally`, so that a search can be run with a changed threshold.  The
budget of a search is in seconds of one core, estimated from the work: a seed gives one result
on every machine and under every load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError

# Settings by which something is divided, of which a logarithm is taken, or without which nothing is
# left to fit.
_ABOVE_ZERO = frozenset(
    {
        "tie",
        "tie_given",
        "tumblers",
        "by_chance",
        "short_modes",
        "poles",
        "block",
        "quick_starts",
        "scan_starts",
        "deep_starts",
        "class_starts",
        "map_starts",
        "windows",
        "joined_poles",
        "known_fitted",
        "known_expected",
        "alias_starts",
        "axial_starts",
        "axial_coarser",
        "scan_points",
        "scan_rates",
    }
)


@dataclass
class Tally:
    """Work, estimated in seconds of one core, and the most that may be done.

    Attributes
    ----------
    budget, spent : float
    """

    budget: float = math.inf
    spent: float = 0.0

    def add(self, count: float, cost: float) -> None:
        """Count so many steps (times points) of a cost in seconds."""
        self.spent += count * cost

    @property
    def left(self) -> float:
        """What of the budget is left."""
        return self.budget - self.spent

    @property
    def is_over(self) -> bool:
        """Whether the budget is spent."""
        return self.left < 0.0


@dataclass(frozen=True)
class Settings:
    """Thresholds and sizes of the search for spin states.

    Differences of evidence are those of -2 ln.  "Point" is a point of the light curve.
    """

    # ---- Costs, s of one core of 2 GHz, by which work is counted: means of whole searches, beside
    # another process (of the fastest runs of parts, `benchmarks/inversion.py costs`, a fifth less)
    # A pair of frequencies.
    pair_cost: float = 3.0e-6
    # A pair of which the powers of the lines alone are summed.
    power_cost: float = 1.3e-7
    # An ellipsoid, a point, with derivatives and their products.
    ellipsoid_cost: float = 5.4e-8
    # The same without derivatives.
    screen_cost: float = 2.9e-8
    # A step of an ellipsoid, whatever the number of points.
    start_cost: float = 4.3e-6
    # The products of a linear term with the rows of an ellipsoid, a point.
    term_cost: float = 8.4e-10
    # A convex body, a point, with derivatives and its part of the normal matrix, half of it with
    # few modes.
    body_cost: float = 2.6e-6
    # The products of a linear term with the rows of a convex body, a point.
    body_term_cost: float = 4.0e-9
    # What of a step of a convex body does not depend on the points: its priors and the solution.
    step_cost: float = 3.3e-4
    # A step of the series of a rotation and an orbit, a point.
    series_cost: float = 4.4e-6
    # A term of the series of an orbit beside a body, a point.
    orbit_cost: float = 6.6e-8
    # A linear fit of functions that turn with a body, at one rate.
    comb_cost: float = 1.8e-5
    # The part of that fit of each night.
    cell_cost: float = 4.8e-8
    # A state of a known shape, a point and a facet.
    facet_cost: float = 1.5e-9
    # Of a body of known shape, from whole searches (`benchmarks/inversion_passes.py`, a budget):
    # its attitude and sums at an epoch.
    attitude_cost: float = 1.2e-7
    # From the same searches: its derivatives and step.
    slopes_cost: float = 8.0e-5

    # ---- Models of the search
    # Model error of ellipsoids, mag: hulls leave 0.04 to 0.1; that of convex bodies is estimated.
    ellipsoid_error: float = 0.07
    # ln of moments, of motion against ellipsoid: hulls with planed faces scatter by 0.1.
    tie: float = 0.15
    # The same for given moments, so wide that an iteration reaches them from any start.
    tie_given: float = 0.03

    # ---- Rounds
    # Pairs of frequencies that are fitted at most: of more, those whose lines have most power (of 8
    # million of a rotator these had all of the best 200).
    pairs_fitted: int = 300_000
    # Pairs of frequencies in the first round; doubled in each.
    pairs: int = 200
    # Pairs among them, the first, whose rates have all starts, others half: of 96 curves true pairs
    # came up to here in 78, later in 10.
    first_pairs: int = 60
    # Starts of each pair of rates that follow from these, in the first round; doubled in each:
    # three missed a needle (`nonconvex` 125008 of docs/inversion.md).
    quick_starts: int = 6
    # Starts of each pair of rates of a scan over nutations, in the first round; doubled in each.
    scan_starts: int = 6
    # Points that these ellipsoids are fitted to in the first round, at least, doubled in each:
    # their model error is larger than that of the points, and does not depend on their number.
    scan_points: int = 200
    # Starts of each of the best pairs of rates, since a few miss one body in ten.
    deep_starts: int = 40
    # Pairs of rates, the best, that get these whatever their cost.
    deep_least: int = 8
    # Rounds at most: the last one tries 64 times as many starts as the first.
    rounds: int = 7
    # Pairs of rates that get more starts.
    classes: int = 30
    # Ellipsoids of one stage that become convex bodies: 60 ms each.
    convex: int = 40
    # Pairs of rates whose best ellipsoids are made lopsided in a few steps, to rank the pairs: the
    # ellipsoids of true rates came up to 300th, these 1st to 31st.
    short_classes: int = 300
    # Pairs of rates among them, the first, whatever their cost.
    far_classes: int = 40
    # Cost of an ellipsoid over the least, above which no other pair of rates goes on: of 33 curves
    # true rates had up to 1.4 of it, and of clear ones all others had more than 4.
    far_worse: float = 3.0
    # Modes of these bodies, up to degree 4: with all 90 true rates came up to 130th.
    short_modes: int = 24
    # Steps of these bodies, which rank the pairs and no more.
    first_steps: int = 3
    # Pairs of rates, the best of these, whose bodies take steps with all modes.
    whole_classes: int = 60
    # The number of those steps.
    short_steps: int = 6
    # States, the best ellipsoids, among which pairs of rates are looked for.
    short_states: int = 4000
    # States of each pair of rates that go on before any other.
    short_members: int = 2
    # Cost after these steps, over the least, of bodies that take more.
    short_worse: float = 1.6
    # Bodies, the best, that take more steps whatever their cost.
    short_least: int = 8
    # Pairs of rates, the first of the short fits, that get a short map of poles where the best
    # bodies do not decide: ellipsoids leave the poles of bodies far from one.  True rates of three
    # curves that were found at wrong poles came 48th, 69th and 134th.
    mapped_classes: int = 130
    # Pairs of rates among them, the first, with lines at odd multiples of psi, of the best pairs of
    # frequencies: of a body of two lobes with four nights the true pair fitted best, and no other
    # had its rates.
    odd_classes: int = 50
    # Pairs of rates among them of the best bodies: the true ones of a curve with outliers were
    # those of the seventh body, and of no short fit.
    body_classes: int = 16
    # Tumbling states, the best, to whose rates those that are mistaken for them are added.
    mistaken: int = 2
    # What is left of the budget, s, for the bodies of these maps and their robust errors.
    class_reserve: float = 3.0
    # The floor of a tumbling body that is not accepted before these maps, and from which other
    # periods and poles compete within `alone`: three wrong bodies left 0.88, 0.89 and 0.94 of it,
    # one with a wrong pole 0.98, the true pole of a concave body 54 behind.
    doubtful: float = 0.85
    # Poles of a short map, 20 degrees apart.
    class_poles: int = 100
    # Starts at each of these poles: the best of several random ones each.
    class_starts: int = 2
    # Bodies of few modes, and their steps, of the best poles and of the best of these: in one stage
    # of four steps two of three curves missed the true pole.
    class_bodies: tuple[tuple[int, int], ...] = ((48, 2), (16, 6))
    # Bodies of each map, the best, that get all modes.
    class_members: int = 3
    # Of all maps the best bodies, and those of so many pairs of rates, that take more steps.
    class_finals: int = 16
    # Model error of bodies, mag, in maps of poles: with that of ellipsoids priors outweigh curves,
    # and true rates of one curve came 14th and 23rd that came first with this.
    body_error: float = 0.03
    # Bodies among which those of least cost with their own model error are chosen, over the number
    # chosen.
    ranked: int = 4
    # Steps that each of them takes with that error.
    ranked_steps: int = 10
    # Bodies fitted with robust errors: all that may compete, at 0.2 s each.
    finals: int = 14
    # Poles of one pair of rates among them.
    poles: int = 7
    # Pairs of rates, the best with the error of ellipsoids, whose first body is fitted so too: the
    # true one of a curve was first by that error, and by its own behind 14 of a rotation's comb.
    firsts: int = 3
    # Solutions, the best, whose rates get a map of poles.
    mapped: int = 3
    # Difference of evidence to the best within which they do.
    mapped_behind: float = 40.0
    # Poles of the map, 17 degrees apart.
    map_poles: int = 150
    # Starts at each of these poles, for phase, tilt and shape are not known.
    map_starts: int = 6
    # Bodies at these poles, the best with few modes, that get all: the best eight with all modes at
    # all poles came up to the 46th with few, one 97th.
    map_refined: int = 60
    # Maps of one pair of rates, from poles apart: the shape of a wrong one left out the true pole.
    maps: int = 2
    # Bodies of each map, the best, that become solutions.
    map_bodies: int = 16
    # Pairs of rates beyond which a scan over nutations begins no other line: two lines of each of
    # the best pairs of rates are scanned, some 1000 pairs of rates each, more of fast rotation.
    scan_rates: int = 3000
    # Precessions of which every displaced nutation is tried.
    scanned: int = 3
    # Difference of evidence of the next periods behind a tumbling state at the floor, after the
    # lattices, from which no nutations are scanned: twice that of a claim without the floor.
    clear: float = 240.0
    # Starts of each pair of rates that the windows of the epochs displace.
    alias_starts: int = 12
    # Rates that are fitted between looks at the tally.
    block: int = 200

    # ---- What is one solution
    # Difference of rates, turns per span: below, a curve of one span does not tell two apart.
    same_rate: float = 0.35
    # Relative difference of model errors below which bodies are compared with one of them.
    same_error: float = 0.02
    # Angle between poles of one solution, rad.
    same_pole: float = math.radians(8.0)

    # ---- Rotation about one axis
    # Strong lines whose rates, and half of them, are tried.
    axial_rates: int = 12
    # Starts at each of these rates, with random poles.
    axial_starts: int = 12
    # Poles of the map, 15 degrees apart.
    axial_poles: int = 200
    # Bodies at each of these poles: minima of shapes lie side by side.
    axial_bodies: int = 2
    # Bodies at held poles, the best, from which the pole is free.
    axial_freed: int = 80
    # The most by which these lie behind the best: a held pole is up to 8 degrees off.
    axial_pole_behind: float = 50.0
    # Listed rotations at most.
    axial_finals: int = 48
    # Difference of evidence to the best within which rotations are listed, and no other pole lies
    # where one apparition is solved: a wrong pole of a concave body was 12.3 ahead of the true one.
    axial_behind: float = 25.0
    # Poles are mapped where chi-squared of the best rotation is at most this times the best's.
    axial_worse: float = 2.0
    # Difference of evidence by which a tumbling body with other lines may be ahead: blind rotators
    # gain up to some hundred by their map.
    axial_tumbling: float = 200.0
    # Other rates that are mapped lie at most so far behind in evidence.
    axial_mapped: float = 60.0
    # By how much the map of another rate is coarser, in poles, bodies at each, and poles that are
    # freed: whether it comes first is seen at fewer, and then it is mapped as the best.
    axial_coarser: int = 2
    # Iterations at held poles after which those go on whose cost is at most so far above the least,
    # and so many of them beside the best of each pole: poles of final lists were 235 above it after
    # four iterations and at most the 89th, 63 and the 20th after six; others were 250 to 1700 above
    # it.
    axial_stages: tuple[tuple[int, float, int], ...] = ((4, 700.0, 160), (4, 200.0, 100))
    # Angle, rad, between poles that are the same entry of a list.
    axial_entry: float = math.radians(15.0)
    # Rates, turns per span, that one map of poles comprises.
    axial_width: float = 1.2
    # Rotations that are compared with a motion that explains the curve better by far.
    axial_others: int = 3

    # ---- Rotation about one axis in several apparitions
    # Windows of rates that are tried at least, and that notes name.
    windows: int = 6
    # The share of the budget after which no further window is tried.
    window_share: float = 0.75
    # What a series may leave of chi-squared, over what the best one leaves.
    window_left: float = 2.0
    # What series and ellipsoids may leave beside that, for the best may leave nothing.
    window_above: float = 30.0
    # Trials that become ellipsoids.
    window_trials: int = 240
    # Ellipsoids that become convex.
    window_bodies: int = 40
    # Chi-squared of an ellipsoid over that of the best, with which it becomes convex.
    window_worse: float = 1.6

    # ---- Moons
    # Orbits of each strong line that are kept in the scan.
    orbits_of_line: int = 12
    # Pairs of rotation and orbit, the best of the scan, that are fitted in two steps.
    orbits_fitted: int = 80
    # Pairs that are fitted in more; the best also with twice and half the period of the orbit.
    orbits_freed: int = 24
    # Orbits of the scan beside a body that are fitted.
    orbits_beside: int = 3
    # Orbits beside whose series the rotation is looked for once more: deep dips drown its lines.
    orbits_again: int = 4
    # Depth of the second dip, over the range, from which it is one: of true orbits 0.3 to 0.9, of
    # noise at twice their frequency up to 0.15.
    second_dip: float = 0.2
    # Pairs of rotation and orbit, the best, that become bodies.
    orbits: int = 4
    # The rms of their series, over that of the best solution, above which none does: for binaries
    # 0.9 to 1.3, for tumbling bodies 1.4 to 11.
    orbit_worse: float = 2.0
    # Difference of evidence by which a rotation at the floor beside an orbit has to be ahead of
    # every body alone.  Of curves without a moon of the benchmarks it was neither ahead nor
    # competed, a moon that is seen was 86 ahead.
    satellite: float = 60.0
    # Rotations about one axis, the best of so many rates, beside which orbits are looked for where
    # nothing explains the curve: the best one often has the rate of deep dips.
    orbit_bodies: int = 4
    # The share of what is left of the budget after which no other orbit gets bodies: those of moons
    # come first, and up to thirteen of a tumbling body left nothing for maps of poles.
    moon_share: float = 0.25
    # As orbit_worse, up to which no body that tumbles is claimed above the floor.
    orbit_alike: float = 1.2

    # ---- Several apparitions of a tumbling body
    # Solutions of each apparition, the best, that are joined with those of another.
    joined_solutions: int = 8
    # Their errors over those of the curvature: 2 to 3 where the model errs.
    joined_wider: float = 3.0
    # Chi-squared of a pair of numbers of turns, with those errors, above the least of two
    # solutions.
    joined_within: float = 25.0
    # Pairs of numbers of turns, the best, that are fitted in a few steps.
    joined_trials: int = 400
    # Pairs of numbers of turns, the best of these, that are fitted in more steps and listed.
    joined: int = 40
    # Poles of one pair of rates among those listed.
    joined_poles: int = 2

    # ---- Bodies of known shape
    # A model with errors of its own, such as shadows of coarse facets, fits no better: searches
    # that have to end at one cost.
    known_agreeing: int = 3
    # A cost over the least, up to which the two are one.
    known_alike: float = 1.03
    # Mean square of residuals over the errors of a state that these searches agree on, at most.
    known_rough: float = 4.0
    # The number of points over the cost at which a state fits: errors of the model are added to
    # those of the points.
    known_expected: float = 1.3
    # States of the search that are fitted at most.
    known_fitted: int = 12
    # Cost behind the best beyond which no state of the search is fitted.
    known_behind: float = 150.0
    # Like `floor`: a known shape has no areas that take up errors of the model.
    known_floor: float = 1.25

    # ---- Evidence
    # Tumbling bodies among those that are searched for: even odds before the curve is seen.  With
    # those of a catalogue, 0.01, noise hid tumbling bodies that fitted better by 80.
    tumblers: float = 0.5
    # By how much more a rotation about one axis has to lie behind a tumbling body that is claimed:
    # of catalogued bodies one in a hundred tumbles.
    against_axis: float = 9.2
    # Difference of likelihoods within which a rotation with one maximum a turn stands behind twice
    # its period: of 156 rotators of the benchmarks four had one, and none was hidden by this.
    doubled: float = 4.0
    # Mean square of residuals over sigma and `floor_error` of a solution that is accepted.
    floor: float = 1.0
    # Error, mag, of a model that fits well, beside sigma.
    floor_error: float = 0.01
    # Share of the points, the worst, that neither the floor nor the share of variance counts.
    worst: float = 0.03
    # The share of the variance that an accepted solution leaves, where it is not at the floor.
    left: float = 0.12
    # Difference of evidence to the next periods of such a solution: errors of the model are
    # correlated, so that differences of evidence are too large by a factor of some ten.
    alone: float = 120.0
    # Difference of evidence within which other periods compete: odds of 700 to 1.
    competing: float = 13.0
    # Difference of evidence within which other poles compete: odds of 400 to 1.
    competing_poles: float = 12.0
    # Differences of likelihoods, of a tumbling body and of a rotation about one axis, within which
    # poles compete that are up to twice as far behind in evidence, by a prior of shapes: four wrong
    # ones of tumbling bodies were 5 to 16 ahead, the last of a curve of six days of which 0.1 % is
    # left; some right ones are 10 and 13 ahead, and are not called solved.
    likely_poles: tuple[float, float] = (17.0, 9.5)
    # Cost of axes and moments of a tumbling body beside those of its shape, above which others have
    # to lie `alone` behind: a wrong state with 34 was 23 ahead, the right one not found yet.
    strained: float = 16.0
    # Turns in the span, of the slower period of a tumbling state, below which other periods have to
    # lie `alone` behind: zero points, phase angles and directions change as slowly.  The two wrong
    # states of docs/inversion.md that were claimed without this had 3 and 4 turns.
    few_turns: float = 6.0
    # The largest share of either of its periods that has no epoch, of a tumbling body that is
    # claimed: a moon with an orbit of a day, seen at one time of the day, was called tumbling with
    # 0.46.  Of 168 tumbling bodies of the benchmarks one has more than 0.3, 0.59 of 1.03 days.
    unseen: float = 0.4
    # Standard errors, of the difference of likelihoods between nights, within which other poles
    # compete however large the difference: residuals of a model that errs are correlated.
    pole_errors: float = 2.5
    # The share of the residuals' variance that neighbours have in common from which points count
    # as fewer than they are where poles compete: white residuals of 100 points reach 0.2.
    correlated: float = 0.3
    # Poles closer than this, rad, are errors of one pole, not rivals of it.
    near_pole: float = math.radians(15.0)
    # Standard errors of a pole within that angle where it is known: of a tumbling body or in
    # several apparitions, and of rotation about one axis in one, where the convex body of a
    # concave one fits as well and was up to 5.6 of them off.
    pole_widths: tuple[float, float] = (2.0, 6.0)
    # Distance, turns per span, within which lines are those of a rotation's comb: the resolution.
    comb_width: float = 1.0
    # Neighbouring residuals over the errors from which the errors are taken to be too small.
    noisier: float = 1.3
    # Least number of turns of psi, and half of that of phi.
    least_turns: float = 1.2
    # Least rho (the tangent of half the tilt of the axis) of a nutation that is no wobble.
    wide: float = 0.08
    # How often chance explains a nutation that fits better.
    by_chance: float = 0.1
    # Rho of a nutation that would be noticed where a rotation about one axis is solved.
    noticed: float = 0.16
    # Rates of that nutation over the rate of the rotation.
    noticed_rates: tuple[float, ...] = (0.2, 0.4, 0.8)
    # Rho of a nutation, of 45 degrees, that would be noticed where the period of a rotation is
    # claimed: a real rotator, (43) Ariadne, hides one of 29 where it was seen for two days.
    hidden: float = 0.414
    # By how much more than by chance, 21 to 23, it would fit better: of three tumbling bodies with
    # the rate of one axis it gained 6, 13 and 24; noise hides one in five that gains so much.
    noticed_by: float = 1.4

    # ---- Constant brightness
    # Standard deviations of chi-squared over the degrees of freedom, above 1, of a curve that is
    # not constant.
    constant: float = 3.0
    # The least ratio of chi-squared to the degrees of freedom that no constant curve has.
    constant_at_most: float = 1.5
    # Solutions of one zero point, the best of whose rates are refined with offsets of the sessions.
    compared: int = 6

    # ---- Epochs
    # Frequencies searched at most, turns per span; more need a shorter curve.
    most_turns: float = 1500.0
    # Of the epochs, the share that lies within the same third of the day for one site.
    one_site: float = 0.9

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            default = getattr(Settings, name)
            if isinstance(default, int):
                validation.count(value, name, int(name in _ABOVE_ZERO))
                continue
            numbers = validation.real(value, name, shape=None if np.ndim(default) else ())
            if np.any(numbers < 0.0) or (name in _ABOVE_ZERO and np.any(numbers == 0.0)):
                least = "greater than zero" if name in _ABOVE_ZERO else "at least 0"
                raise AttitudeError(f"{name} is {validation.shown(value)}; it must be {least}.")
            if not numbers.ndim:
                object.__setattr__(self, name, float(numbers))
        if not self.tumblers < 1.0:
            raise AttitudeError(f"tumblers is {self.tumblers:g}; it must be less than 1.")

    @property
    def odds(self) -> float:
        """Those of tumbling, against rotation about one axis, before the curve is seen."""
        return self.tumblers / (1.0 - self.tumblers)

    def with_coarse_map(self) -> Settings:
        """These, with a coarser map of the poles of rotations about one axis."""
        return replace(
            self,
            axial_poles=max(1, self.axial_poles // self.axial_coarser),
            axial_bodies=max(1, self.axial_bodies // self.axial_coarser),
            axial_freed=max(1, self.axial_freed // self.axial_coarser**2),
        )


DEFAULT = Settings()
