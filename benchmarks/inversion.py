"""How often and how fast does the inversion of a light curve find the spin state?

    python benchmarks/inversion.py speed              a pair of frequencies, a likelihood
    python benchmarks/inversion.py costs              processor time of work over what is counted
    python benchmarks/inversion.py toutatis           the photometry of 1992-93 against radar
    python benchmarks/inversion.py tumblers 48 SEED   synthetic tumblers; also "nights", "axial",
                                                      "sessions", "slow-tumblers"; a fourth
                                                      number: from this case on
    python benchmarks/inversion.py constant 300 SEED  slow tumblers that are called constant
    python benchmarks/inversion.py nonconvex 24 SEED  bodies with shadows, offsets of nights; also
                                                      "albedo", "inertia", "wobble", "survey",
                                                      "outliers", "exposures", "moons", "rotators"

Nothing of a truth is in the input; the search goes up to 3.2 turns in a mean rotation.  Processor
seconds of one core; the first call, which compiles, is not counted.  Rotators about one axis whose
magnitude varies by less than its errors, which no light curve decides, are not drawn: their seeds
are printed (`synthetic_curves.is_decidable`, of the truth alone).

Bodies from "nonconvex" on are those of `mesh_curves`: random ones, or, where the environment
variable MESHES names a folder, its OBJ files.
"""

from __future__ import annotations

import itertools
import math
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attitude import catalog, inversion
from attitude.inversion import (
    _apparitions,
    _ellipsoid,
    _lattices,
    _problem,
    _refinement,
    _shapes,
    _verdicts,
)
from attitude.inversion._problem import CurveProblem
from attitude.inversion._settings import DEFAULT
from attitude.inversion._spin_states import is_constant
from attitude.photometry import _spectrum
from benchmarks.doc_tables import Table, markdown
from examples import toutatis_photometry
from tests.support import synthetic_curves
from tests.support.inversion_families import (
    KINDS,
    cases_of,
    curve_of,
    errors_of,
    judged,
    mirror_angle,
    share_of_sky,
    sides,
)
from tests.support.synthetic_curves import Case

# Difference of evidence within which a solution counts as listed; work of a search, s, its default.
LISTED, BUDGET = 20.0, 60.0
# Angle, deg, beyond which a pole of a rotator about one axis is another one, not its error.
LOBE = 60.0

MAKES = ("inversion",)


def tables(quick: bool):
    """The table of docs/inversion.md; synthetic curves, which take an hour, are run by hand."""
    pair, point = speed()
    spent, found = toutatis()
    sigma = np.array(found[0].periods_sigma) / 86400.0
    whole, _ = toutatis_photometry.angles_to_radar(found[0].motion)
    periods = np.array([found[0].P_phi, found[0].P_psi]) / 86400.0
    rows = [
        ("a pair of frequencies at order 2, whatever the number of points", f"{pair:.2g} us"),
        ("likelihood of an ellipsoid with ten derivatives", f"{point:.0f} ns a point"),
        (
            "Toutatis, 370 magnitudes, blind to 0.75 /d (`toutatis`)",
            f"rank 1 {found[0].mode}, P_phi {periods[0]:.3f} ± {sigma[1]:.3f} d, P_psi "
            f"{periods[1]:.3f} ± {sigma[0]:.3f} d, attitudes of December 1992 to "
            f"{min(whole):.0f}-{max(whole):.0f} degrees of radar's; {spent:.1f} s",
        ),
    ]
    costs = {"pair": pair * 1e3, "point": point, "Toutatis": spent * 1e6}
    yield Table("inversion", markdown(("what", "measured"), rows), costs=costs)


class Judgement(NamedTuple):
    """How a search came out: ranks, angles of poles (deg), processor seconds, and errors.

    `count` poles are listed; `share` of the sky lies within 15 degrees of them or their mirrors.
    `orbit`: the period of the orbit in the verdict over the true one; 0 where none is named.
    """

    rank: int | None
    listed: float
    own: float
    verdict: str
    spent: float
    errors: np.ndarray
    count: int
    share: float
    orbit: float = 0.0


def solved(case: Case, zero_points: str, budget: float) -> Judgement:
    """The search of one case, printed."""
    curve = curve_of(case, zero_points)
    begin = time.process_time()
    found = inversion.spin_states(curve, f"{case.most} /d", budget=budget)
    spent = time.process_time() - begin
    judgements = [judged(each, case) for each in found]
    right = [j for j, (near, _) in enumerate(judgements) if near]
    rows = [
        (each, angle)
        for each, (near, angle) in zip(found, judgements, strict=True)
        if near and each.evidence - found[0].evidence < LISTED
    ]
    listed = [min(angle, mirror_angle(each, case)) for each, angle in rows]
    poles = [side for each, _ in rows for side in sides(each)]
    rank = right[0] if right else None
    pole, own = min(listed, default=180.0), judgements[0][1] if judgements else 180.0
    has_mode = rank == 0 and found[0].mode == case.mode
    known = has_mode and own < (LOBE if case.mode == "PA" else 15.0)
    errors = errors_of(found[0], case) if known else np.zeros(0)
    word = "WRONG" if rank != 0 else "right" if has_mode else "right, a rotation"
    print(
        f"{case.mode} P_phi {case.P_phi:.4f} P_psi {case.P_psi:.4f} N {len(curve)}: "
        f"{word} (rank {rank}), pole {own:.0f} (listed {pole:.0f}, of {len(listed)}) deg, "
        f"{found.verdict}, {spent:.1f} s" + (f", errors {np.round(errors, 1)}" if known else ""),
        flush=True,
    )
    if rank != 0 or found.verdict == _verdicts.OPEN:
        print("   ", str(found).replace("\n", "\n    ")[:900], flush=True)
    share = share_of_sky(poles)
    named = found.verdict.startswith(_verdicts.SATELLITE) and case.orbit is not None
    orbit = float(found.verdict.split()[4]) / case.orbit if named else 0.0
    return Judgement(rank, pole, own, found.verdict, spent, errors, len(listed), share, orbit)


def run(cases: Iterable[Case], zero_points: str, first: int = 0) -> str:
    """Solve cases and print each with its number from `first`; the sums, printed too."""
    rows = []
    for k, case in enumerate(cases, first):
        print(f"{k:2d}", end=" ")
        rows.append(solved(case, zero_points, BUDGET))
    total = len(rows)
    firsts = sum(row.rank == 0 for row in rows)
    tens = sum(row.rank is not None and row.rank < 10 for row in rows)
    claims = sum(not row.verdict.endswith("not solved") and row.rank != 0 for row in rows)
    wrong = sum(row.verdict == "solved" and row.own >= 15.0 for row in rows)
    opened = sum(row.verdict == "not solved" for row in rows)
    # the first call compiles
    cpu = [row.spent for row in rows[1:]] or [row.spent for row in rows]
    errors = np.concatenate([row.errors for row in rows])
    inside = ", ".join(str(np.sum(np.abs(errors) < k)) for k in (1, 2, 3))
    sums = (
        f"mode and periods at rank 1 in {firsts} of {total}, among the first ten in {tens}; pole "
        f"or mirror within 15 degrees listed in {sum(row.listed < 15.0 for row in rows)} (by "
        f"chance {sum(row.share for row in rows):.1f}; poles listed: median "
        f"{np.median([row.count for row in rows]):.0f}, at most {max(row.count for row in rows)}), "
        f"pole at rank 1 in {sum(row.own < 15.0 for row in rows)}; false claims {claims}, solved "
        f"with another pole {wrong}, not solved {opened}; {inside} of {len(errors)} "
        f"parameters within 1, 2, 3 sigma; processor median {np.median(cpu):.1f}, 90 % within "
        f"{np.percentile(cpu, 90):.1f}, at most "
        f"{max(cpu):.1f} s"
    )
    named = [row.orbit for row in rows if row.orbit]
    if named:
        right = sum(abs(each - 1.0) < 0.01 for each in named)
        sums += f"; a satellite named in {len(named)}, with the period of its orbit in {right}"
    print(sums)
    return sums


def called_constant(count: int, seed: int) -> tuple[list[int], int]:
    """Numbers of slow tumblers that are called constant, and how many offsets explain; printed.

    Constant is said where it holds with one zero point.  Where offsets of the sessions within their
    prior explain the curve, both explanations are compared after the search and both are given.
    """
    kind, found, explained = KINDS["slow-tumblers"], [], 0
    for k, case in enumerate(cases_of(kind, count, seed)):
        curve = curve_of(case, kind.zero_points)
        given = case.most / 86400.0, DEFAULT.ellipsoid_error
        one, own = (_problem.problem(curve, *given, each)[0] for each in ("shared", "auto"))
        explained += is_constant(own)
        if is_constant(one):
            varies = synthetic_curves.variation(case)
            print(f"{k}: {case.mode} P_phi {case.P_phi:.3f} d, {varies:.3f} mag")
            found.append(k)
    print(
        f"{len(found)} of {count} slow tumblers are called constant; zero points of the sessions "
        f"within their prior explain {explained}"
    )
    return found, explained


def speed() -> tuple[float, float]:
    """Cost of a pair of frequencies at order 2, us, and of a likelihood with derivatives, ns."""
    rng = np.random.default_rng(0)
    t, w = np.sort(rng.uniform(-0.5, 0.5, 400)), rng.uniform(50.0, 200.0, 400)
    y = np.cos(150.0 * t) + 0.1 * rng.normal(size=400)
    transforms = _spectrum.tables(t, w, y, 1.0 / 3.0, 5000)
    first, second = rng.integers(5, 600, (2, 20000))
    lines = _spectrum.harmonics(2)
    spent = _best(lambda: _spectrum.decreases(transforms, first, second, lines))
    pair = spent / 20000 * 1e6
    print(f"pair, order 2: {pair:.2f} us")
    sun, observer = rng.normal(size=(2, 3, 400))
    sun, observer = sun / np.linalg.norm(sun, axis=0), observer / np.linalg.norm(observer, axis=0)
    terms = np.ones((400, 1)), np.full(1, np.inf)
    given = t, 1.0, sun, observer, np.zeros(400), np.ones(400), *terms, 0.0
    curve = _ellipsoid.EllipsoidCurve(CurveProblem(*given))
    states = np.tile([20.3, 14.7, 0.2, -1.0, 0.2, *np.eye(3).ravel(), 0.7, 0.4], (100, 1))
    spent = _best(lambda: curve.products(states)) / 100
    print(f"likelihood with ten derivatives: {spent / 400 * 1e9:.0f} ns a point")
    body = np.concatenate([states[0], np.zeros(_refinement.WIDTH - _ellipsoid.WIDTH)])
    counted = CurveProblem(*given)
    with _refinement.limited():
        step = _best(lambda: _refinement.refine(counted, body, iterations=2)) / 2.0
    estimate = counted.settings.step_cost + 400 * counted.settings.body_cost
    print(f"step of a body, 400 points: {step * 1e3:.2f} ms, counted as {estimate * 1e3:.2f}")
    return pair, spent / 400 * 1e9


def costs() -> dict[str, float]:
    """Processor time of each kind of work of a search over what the tally counts, printed.

    Of the fastest of some runs, with 400 points: the costs of `Settings` are right where it is 1.
    """
    case = KINDS["tumblers"].case(7200000, 0)
    curve, most = curve_of(case, "shared"), case.most * np.ptp(case.jd)
    problem, _ = _problem.problem(curve, case.most / 86400.0, DEFAULT.ellipsoid_error, "shared")
    rates = [_lattices.Candidate(30.0, f) for f in np.linspace(-20.0, 20.0, 200)]
    rng = np.random.default_rng(0)
    states = _ellipsoid.starts(rng, *np.array(rates).T)
    held = _ellipsoid.Held(DEFAULT.tie)
    bodies = _ellipsoid.minimised(problem, states[:20], 8, tie=held).states
    combs, poles = _apparitions.Combs(problem), _shapes.even_directions(_apparitions.POLES)
    work = {
        "pairs of frequencies": lambda: _lattices.lattice_pairs(problem, min(most, 250.0), 200),
        "screened ellipsoids": lambda: _ellipsoid.costs(problem, states),
        "fitted ellipsoids": lambda: _ellipsoid.minimised(problem, states, 6, tie=held),
        "lopsided bodies": lambda: _bodies(problem, bodies, 3, DEFAULT.short_modes),
        "convex bodies": lambda: _bodies(problem, bodies, 20, _shapes.MODES),
        "rates about poles": lambda: _apparitions.scan(combs, poles, 100.0, 120.0, lambda: False),
    }
    ratios = {}
    with _refinement.limited():
        for name, call in work.items():
            before = problem.tally.spent
            call()
            counted = problem.tally.spent - before
            ratios[name] = _best(call, 8) / counted
            print(f"{name}: {ratios[name]:.2f} of {counted:.3f} s")
    return ratios


def _bodies(problem: CurveProblem, states: np.ndarray, iterations: int, modes: int) -> None:
    for state in states:
        _refinement.refine(problem, state, iterations=iterations, modes=modes)


def _best(call, repeat: int = 20) -> float:
    call()
    times = []
    for _ in range(repeat):
        begin = time.thread_time()
        call()
        times.append(time.thread_time() - begin)
    return min(times)


def toutatis() -> tuple[float, list[inversion.Solution]]:
    """The photometry of 1992-93, blind to 0.75 /d, against radar: seconds, and what was found."""
    data = Path(__file__).resolve().parents[1] / "data"
    curve = inversion.LightCurve.read(data / "light_curve" / "toutatis-1992-photometry.csv")
    inversion.spin_states(curve, "0.75 /d", budget=2.0)
    begin = time.process_time()
    found = inversion.spin_states(curve, "0.75 /d")
    spent = time.process_time() - begin
    print(f"{spent:.1f} s\n{found}\n{found[0].published('L')}")
    sigma = np.array(found[0].periods_sigma) / 86400.0
    print(
        f"standard errors: P_psi {sigma[0]:.4f}, P_phi {sigma[1]:.4f} d, "
        f"pole {math.degrees(found[0].pole_sigma):.1f} deg"
    )
    print(catalog.entry("4179 Toutatis").motion().published("L"))
    whole, axis = toutatis_photometry.angles_to_radar(found[0].motion)
    print("angles to the radar attitudes, deg:", np.round(whole).tolist())
    print("of the long axis:", np.round(axis).tolist())
    return spent, found


def main(arguments: list[str]) -> None:
    """Run what the arguments name."""
    what = arguments[0] if arguments else "speed"
    if what in ("speed", "costs", "toutatis"):
        {"speed": speed, "costs": costs, "toutatis": toutatis}[what]()
        return
    if what == "constant":
        called_constant(int(arguments[1]), int(arguments[2]))
        return
    kind, count, seed = KINDS[what], int(arguments[1]), int(arguments[2])
    first = int(arguments[3]) if len(arguments) > 3 else 0
    run(itertools.islice(cases_of(kind, count, seed), first, None), kind.zero_points, first)


if __name__ == "__main__":
    main(sys.argv[1:])
