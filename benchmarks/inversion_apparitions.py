"""Is a motion found from years of light curves: sidereal period and pole, or numbers of turns?

    python benchmarks/inversion_apparitions.py rotators 12 SEED      synthetic, 25 years, blind
    python benchmarks/inversion_apparitions.py near 12 SEED          the same, periods to 1 %
    python benchmarks/inversion_apparitions.py without 12 SEED       blind, the true rates left out
    python benchmarks/inversion_apparitions.py damit FILE P LONGITUDE LATITUDE [FOLDER]
    python benchmarks/inversion_apparitions.py to-percent FILE P LONGITUDE LATITUDE
    python benchmarks/inversion_apparitions.py each FILE P LONGITUDE LATITUDE
    python benchmarks/inversion_apparitions.py blind FILE P LONGITUDE LATITUDE
    python benchmarks/inversion_apparitions.py two 6 SEED            tumblers, 2012-13 and 2020-21
    python benchmarks/inversion_apparitions.py drift 6 SEED          the same under a torque

`rotators`: relative nights and calibrated sparse points of another forward model
(`synthetic_curves`), blind from 2 to 24 h, budget 60 s. `without`: no window of the true rate, half
of it or twice is searched, so that each claim is wrong. `damit`: a file of relative light curves in
DAMIT's format, blind from 2 to 24 h and between P -+ 0.01 %, against the published period (h) and
pole (ecliptic, deg); with FOLDER, in which `convexinv` is built, the same curves by that program
from the published values. `to-percent`: that file with its period to 1 %. `each`: every apparition
of the file alone, as a rotation about one axis; `blind`: tumbling is searched for too, in the
settings of a user who knows nothing. `two`: tumbling bodies of `synthetic_curves` on the orbit of
(99942) Apophis, seen on 40 nights from 23 December 2012 to 15 April 2013 and on 60 from 15 November
2020 to 10 May 2021, three points an hour, errors of 0.03 mag; `drift`: under a torque fixed in the
body that changes its rates by 2 to 6 turns per span^2.
Processor seconds.
"""

from __future__ import annotations

import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from unittest import mock

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attitude import inversion
from attitude.inversion import _apparitions, _neighbours, _problem
from tests.support import inversion_families, synthetic_curves
from tests.support.apparition_curves import judged, rotator

BUDGET = 900.0
_HOURS = 3600.0


def _unit(longitude: float, latitude: float) -> np.ndarray:
    a, b = math.radians(longitude), math.radians(latitude)
    return np.array([math.cos(b) * math.cos(a), math.cos(b) * math.sin(a), math.sin(b)])


def solved(
    curve, known: float, pole: np.ndarray, budget: float = BUDGET, **given
) -> tuple[bool, float, float, str, float]:
    """A search, printed: as in `judged`, the verdict, and processor seconds."""
    begin = time.process_time()
    found = inversion.spin_states(curve, budget=budget, **given)
    spent = time.process_time() - begin
    right, own, listed = judged(found, curve, known, pole) if len(found) else (False, 180.0, 180.0)
    print(
        f"{len(curve)} points in {curve.span / 86400.0:.0f} d: "
        f"{'right' if right else 'WRONG'}, pole {own:.1f} (listed {listed:.1f}) deg, "
        f"{found.verdict}, {spent:.1f} s"
    )
    if len(found):
        best = found[0]
        sigma = best.periods_sigma[1] / _HOURS
        longitude, latitude = np.degrees(best.pole)
        print(
            f"    P {best.P_phi / _HOURS:.8f} +- {sigma:.1e} h (known {known:.8f}), pole "
            f"{longitude:.1f} {latitude:+.1f} +- {math.degrees(best.pole_sigma):.1f} deg, rms "
            f"{best.rms:.4f} mag\n    {found.criterion}",
            flush=True,
        )
    return right, own, listed, found.verdict, spent


def rotators(count: int, seed: int, is_blind: bool = True) -> str:
    """Synthetic rotators of 25 years, blind from 2 to 24 h or to 1 %; the sums, printed too."""
    rows = []
    for number in range(count):
        curve, period, pole = rotator(seed + number)
        print(f"{number:2d}", end=" ")
        given = ("2 h", "24 h") if is_blind else f"{1.004 * period} h"
        rows.append(solved(curve, period, pole, 60.0, period=given))
    spent = [row[4] for row in rows[1:]] or [rows[0][4]]
    sums = (
        f"number of turns at rank 1 in {sum(row[0] for row in rows)} of {count}; pole within 10 "
        f"degrees at rank 1 in {sum(row[1] < 10.0 for row in rows)}, listed in "
        f"{sum(row[2] < 10.0 for row in rows)}; solved and wrong "
        f"{sum(row[3] == 'solved' and not (row[0] and row[1] < 10.0) for row in rows)}, not solved "
        f"{sum(row[3] == 'not solved' for row in rows)}; processor median {np.median(spent):.1f}, "
        f"at most {max(spent):.1f} s"
    )
    print(sums)
    return sums


def without(count: int, seed: int) -> str:
    """Blind searches of `rotators` in which the true period is left out; the sums, printed too."""
    windows_of = _apparitions.windows
    claimed = 0
    for number in range(count):
        curve, period, _ = rotator(seed + number)
        true = curve.span / _HOURS / period

        def others(problem, low, high, true=true):
            chosen = windows_of(problem, low, high)
            wrong = [
                window
                for window in chosen.bounds
                if not any(
                    window[0] - 2.0 < ratio * true < window[1] + 2.0 for ratio in (0.5, 1, 2)
                )
            ]
            return chosen._replace(bounds=wrong)

        with mock.patch.object(_apparitions, "windows", others):
            found = inversion.spin_states(curve, period=("2 h", "24 h"))
        claimed += found.verdict != "not solved"
        print(
            f"{number:2d} P {period:.5f} h left out; {found.verdict}: {found.criterion}", flush=True
        )
    sums = f"a wrong period claimed in {claimed} of {count}"
    print(sums)
    return sums


def damit(file: str, period: float, longitude: float, latitude: float, folder: str = "") -> None:
    """A file of DAMIT's format against published values, and convexinv from these."""
    curve = inversion.LightCurve.read(file)
    pole = _unit(longitude, latitude)
    solved(curve, period, pole, max_frequency="12 /d", period=("2 h", "24 h"))
    near = f"{period * 0.9999} h", f"{period * 1.0001} h"
    solved(curve, period, pole, period=near)
    if folder:
        _convexinv(file, period, longitude, latitude, folder)


def _convexinv(file: str, period: float, longitude: float, latitude: float, folder: str) -> None:
    """The peer from the published period and pole, with its own example's settings."""
    rows = [f"{longitude} 1", f"{latitude} 1", f"{period} 1", "0", "0", "0.1", "6 6", "8"]
    rows += ["0.5 0", "0.1 0", "-0.5 0", "0.1 0", "50"]
    with tempfile.TemporaryDirectory() as place:
        given, out, curves = (Path(place) / name for name in ("input", "parameters", "curves"))
        given.write_text("\n".join(rows) + "\n")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        command = [str(Path(folder) / "convexinv"), "-o", str(Path(place) / "areas"), "-p"]
        with open(file) as stream:
            subprocess.run(
                [*command, str(out), str(given), str(curves)],
                stdin=stream, check=True, capture_output=True,
            )  # fmt: skip
        spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        model = np.array([float(row.split()[-1]) for row in curves.read_text().splitlines() if row])
        words = out.read_text().split()
    from attitude.formats.damit_light_curve import read_damit_light_curves

    left, at = [], 0
    for each in read_damit_light_curves(file):
        part = -2.5 * np.log10(each.brightness / model[at : at + len(each)])
        at += len(each)
        left.append(part - part.mean())
    rms = math.sqrt(float(np.mean(np.concatenate(left) ** 2)))
    print(
        f"convexinv: P {words[2]} h, pole {words[0]} {words[1]}, rms {rms:.4f} mag, {spent:.1f} s"
    )


def each(file: str, period: float, longitude: float, latitude: float, **given) -> None:
    """Every apparition of a file alone, up to 12 turns a day or as many as the span allows."""
    curve = inversion.LightCurve.read(file)
    problem, _ = _problem.problem(curve, 12.0 / 86400.0, 0.07, curve.zero_points)
    for on in _neighbours.apparitions_of(problem.seconds):
        if len(on) < 40:
            continue
        part = curve[on]
        most = f"{min(12.0, 0.96 * inversion.Settings().most_turns * 86400.0 / part.span)} /d"
        solved(part, period, _unit(longitude, latitude), max_frequency=most, **given)


# ---- Tumbling bodies

# Orbits of Apophis (osculating, December 2012; synthetic_curves' elements) and the Earth.
_MOTION = synthetic_curves.GAUSS / 0.9222973**1.5
_APOPHIS = (0.9222973, 0.1911723, 0.0581371, -2.7154762, 2.2062004)
_APOPHIS += (1.4257796 + _MOTION * (2460000.5 - 2456262.5), _MOTION)
_EARTH = (1.0, 0.0167, 0.0, 0.0, 1.7966419, synthetic_curves.GAUSS * (2460000.5 - 2455931.5))
_EARTH += (synthetic_curves.GAUSS,)
_SEEN = [(2456284.5, 2456397.5, 40), (2459168.5, 2459344.5, 60)]


def tumbler(seed: int, mode: str, drift: float = 0.0) -> synthetic_curves.Case:
    """A tumbling body on the orbit of Apophis; drift: of its rates, turns per span^2."""
    style = {
        "mode": mode, "P": 1.1, "span": 3060, "hours": (2, 6), "per_hour": 3, "noise": 0.03,
        "orbits": (_APOPHIS, _EARTH), "apparitions": _SEEN, "drift": drift,
    }  # fmt: skip
    return synthetic_curves.case(seed, style)


def two(count: int, seed: int, drifts: bool = False) -> str:
    """Two apparitions of tumbling bodies, short- and long-axis mode in turn; the sums, printed."""
    rows, off = [], []
    for number in range(count):
        drift = (-1.0) ** (number // 2) * (2.0 + number % 5) if drifts else 0.0
        case = tumbler(seed + number, ("SAM", "LAM")[number % 2], drift)
        curve = inversion_families.curve_of(case, "shared")
        begin = time.process_time()
        found = inversion.spin_states(curve, f"{case.most} /d", budget=BUDGET, drift=drifts)
        spent = time.process_time() - begin
        right = [k for k, each in enumerate(found) if inversion_families.judged(each, case)[0]]
        rank = right[0] if right else None
        behind = math.nan if rank is None else found[rank].evidence - found[0].evidence
        near = sum(each.evidence - found[0].evidence < 13.0 for each in found)
        print(
            f"{number:2d} {case.mode} P_phi {case.P_phi:.4f} P_psi {case.P_psi:.4f} d, "
            f"{len(curve)} points: true numbers of turns at rank {rank}, {behind:.1f} behind; "
            f"{len(found)} pairs listed, {near} within 13; {found.verdict}, {spent:.1f} s",
            flush=True,
        )
        if drifts and len(found):
            best, square = found[0], curve.span**2
            off.append((best.drift * square - case.drift) / (best.drift_sigma * square))
            print(
                f"    drift of phi and psi {best.drift * square} +- {best.drift_sigma * square}, "
                f"true {case.drift} turns per span^2"
            )
        print("   ", str(found).replace("\n", "\n    ")[:1800], flush=True)
        rows.append((rank, behind, found.verdict, spent))
    sums = (
        f"true numbers of turns listed in {sum(row[0] is not None for row in rows)} of {count}, at "
        f"rank 1 in {sum(row[0] == 0 for row in rows)}; solved with others "
        f"{sum(row[2] != 'not solved' and row[0] != 0 for row in rows)}; processor median "
        f"{np.median([row[3] for row in rows]):.1f}, at most {max(row[3] for row in rows):.1f} s"
    )
    if off:
        sums += (
            f"; drifts off by {np.sqrt(np.mean(np.square(off))):.2f} standard errors rms, at most "
            f"{np.abs(off).max():.2f}"
        )
    print(sums)
    return sums


def main(arguments: list[str]) -> None:
    """Run what the arguments name."""
    what, *given = arguments or ["rotators", "2", "1"]
    if what in ("rotators", "near"):
        rotators(int(given[0]), int(given[1]), what == "rotators")
    elif what == "without":
        without(int(given[0]), int(given[1]))
    elif what in ("two", "drift"):
        two(int(given[0]), int(given[1]), what == "drift")
    elif what == "to-percent":
        curve, period = inversion.LightCurve.read(given[0]), float(given[1])
        solved(curve, period, _unit(*map(float, given[2:4])), period=f"{period} h")
    elif what == "damit":
        damit(given[0], *map(float, given[1:4]), *given[4:5])
    elif what == "blind":
        each(given[0], *map(float, given[1:4]), budget=60.0)
    else:
        each(given[0], *map(float, given[1:4]), modes=("PA",))


if __name__ == "__main__":
    main(sys.argv[1:])
