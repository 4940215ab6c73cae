"""Families of synthetic light curves for the inversion, and how their solutions are judged."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from astropy import units
from astropy.time import Time

from attitude import inversion
from attitude.frames import matrix_to_icrf
from attitude.inversion import _pole_map, _shapes
from attitude.inversion._ellipsoid import SearchState
from tests.support import mesh_curves, synthetic_curves
from tests.support.synthetic_curves import Case

# Mode, mean period of rotation (d), span (d), nights, hours a night, points an hour, noise (mag).
NAMES = ("mode", "P", "span", "nights", "hours", "per_hour", "noise")
STYLES = [
    dict(zip(NAMES, row, strict=True))
    for row in (
        ("SAM", 1.1, 90, 40, (3, 7), 2, 0.02),
        ("LAM", 2.2, 120, 45, (3, 7), 2, 0.02),
        ("LAM", 0.35, 30, 16, (3, 7), 5, 0.03),
        ("SAM", 0.25, 25, 14, (3, 7), 6, 0.02),
        ("SAM", 0.8, 60, 25, (2, 6), 3, 0.05),
        ("LAM", 3.5, 160, 60, (1, 4), 2, 0.05),
        ("LAM", 0.08, 5, 4, (4, 8), 15, 0.03),
        ("SAM", 0.5, 60, 30, (2, 6), 3, 0.03),
        ("LAM", 0.6, 60, 30, (2, 6), 3, 0.03),
        ("SAM", 1.3, 136, 38, (2, 6), 3, 0.03),
        ("SAM", 0.12, 6, 5, (4, 8), 12, 0.02),
        ("LAM", 1.0, 80, 35, (3, 6), 3, 0.03),
    )
]
NIGHTS = [
    {**style, "noise": 0.05, "zero": 0.3, "one_site": True, "per_hour": 2 * style["per_hour"]}
    for style in STYLES
]
AXIAL = [
    {**style, "mode": "PA", "P": P}
    for style, P in zip(
        STYLES, (0.2, 0.5, 0.3, 0.11, 0.4, 1.3, 0.09, 0.25, 0.6, 0.35, 0.12, 0.8), strict=True
    )
]
# Turns of days, seen in an hour to four of a night, whose offsets are not given.
SLOW = [
    dict(zip(NAMES, (*row, (1, 4), 2, noise), strict=True))
    for row, noise in zip(
        (
            ("LAM", 3.5, 160, 60),
            ("SAM", 2.5, 150, 60),
            ("LAM", 5.0, 200, 70),
            ("SAM", 4.0, 180, 65),
            ("LAM", 2.5, 120, 50),
            ("SAM", 3.0, 160, 60),
        ),
        (0.05, 0.05, 0.03, 0.03, 0.05, 0.05),
        strict=True,
    )
]


def _varied(styles: list[dict], kinds: tuple[str, ...], **more: object) -> list[dict]:
    """Styles with kinds of bodies in turn, and other keywords of `mesh_curves.case`."""
    bodies = itertools.cycle(kinds)
    return [{**style, "kind": next(bodies), **more} for style in styles]


LUMPY, CONCAVE = ("lumpy",), ("bilobed", "bent", "lumpy", "bent", "bilobed")
# Binaries: periods (d) of the primary, spans (d), nights.
BINARIES = [
    dict(zip(NAMES, ("PA", P, span, nights, (4, 8), 8, 0.015), strict=True))
    for P, span, nights in ((0.1, 20, 12), (0.13, 25, 14), (0.2, 30, 16), (0.11, 15, 10))
]


class Kind(NamedTuple):
    """What cases are drawn: styles, zero points, and whether undecidable ones are left out.

    `meshes`: by `mesh_curves`, with files where there are any.
    """

    styles: list[dict]
    zero_points: str
    decidable: bool = False
    meshes: bool = False

    def case(self, seed: int, number: int) -> Case:
        """The case of a seed, of the style of a number."""
        style = self.styles[number % len(self.styles)]
        if not self.meshes:
            return synthetic_curves.case(seed, style)
        folder = os.environ.get("MESHES")
        files = sorted(Path(folder).glob("*.obj")) if folder and style["kind"] != "lumpy" else None
        return mesh_curves.case(seed, style, files)


KINDS = {
    "tumblers": Kind(STYLES, "shared"),
    "nights": Kind(NIGHTS, "free"),
    "axial": Kind(AXIAL, "shared", decidable=True),
    "sessions": Kind(STYLES, "auto"),
    "slow-tumblers": Kind(SLOW, "auto", decidable=True),
    "nonconvex": Kind(_varied(STYLES, CONCAVE, zero=(0.02, 0.1)), "auto", meshes=True),
    "albedo": Kind(_varied(STYLES, LUMPY, spots=0.25), "shared", meshes=True),
    "inertia": Kind(_varied(STYLES, LUMPY, inertia=True), "shared", meshes=True),
    "wobble": Kind(_varied(STYLES, LUMPY, tilt=(1.5, 15.0)), "shared", meshes=True),
    "survey": Kind(
        _varied([x for x in STYLES if x["span"] >= 25], LUMPY, survey=(100, 200)), "shared",
        meshes=True,
    ),
    "outliers": Kind(
        _varied(STYLES, LUMPY, outliers=0.03, halved=True, clock=0.002), "shared", meshes=True
    ),
    "exposures": Kind(
        [
            {**style, "exposure": 0.2 * style["P"]}
            for style in _varied([x for x in STYLES if x["P"] < 0.7], LUMPY)
        ],
        "shared", meshes=True,
    ),
    "moons": Kind(_varied(BINARIES, LUMPY, moon=True, most=3.0), "shared", meshes=True),
    "rotators": Kind(
        _varied(AXIAL, CONCAVE, zero=(0.02, 0.05)), "auto", decidable=True, meshes=True
    ),
}  # fmt: skip


def curve_of(case: Case, zero_points: str) -> inversion.LightCurve:
    """The light curve of a case."""
    return inversion.LightCurve(
        Time(case.jd, format="jd", scale="tdb"),
        case.magnitude,
        case.sigma,
        sun=case.sun * units.au,
        observer=case.observer * units.au,
        session=case.session,
        filter=case.filter,
        exposure=case.exposure * units.day,
        zero_points=zero_points,
        frame="ecliptic",
    )


def judged(found: inversion.Solution, case: Case) -> tuple[bool, float]:
    """Whether mode and periods are right, and the angle to the true pole, deg.

    Where all lines of a tumbling body are those of the rotation found, it counts as this one.
    """
    span = np.ptp(case.jd)
    near = abs(86400.0 / found.P_phi - 1.0 / case.P_phi) * span < 0.35
    if case.mode != "PA":
        near &= abs(86400.0 / found.P_psi - 1.0 / case.P_psi) * span < 0.35
    pole = matrix_to_icrf("ecliptic").T @ SearchState.of(found.state).pole
    angle = math.degrees(math.acos(max(-1.0, min(1.0, float(pole @ case.pole)))))
    return bool(near and found.mode == case.mode) or is_comb(found, case), angle


def is_comb(found: inversion.Solution, case: Case) -> bool:
    """Whether both rates of a tumbling body are multiples of half the rotation that was found.

    Within a turn of the span, and 0.35 turns between the two; up to six, phi an even one.
    """
    if found.mode != "PA" or case.mode == "PA":
        return False
    half, rates = 43200.0 / found.P_phi, np.array([1.0 / case.P_phi, 1.0 / case.P_psi])
    multiples = np.rint(rates / half)
    if multiples[0] % 2 or multiples.min() < 1 or multiples.max() > 6:
        return False
    span = np.ptp(case.jd)
    apart = abs(rates[0] * multiples[1] - rates[1] * multiples[0])
    apart /= math.gcd(*multiples.astype(int))
    return bool(apart * span < 0.35 and np.abs(rates - multiples * half).max() * span < 1.0)


def sides(found: inversion.Solution) -> tuple[np.ndarray, np.ndarray]:
    """The pole, and its mirror image in the plane of the scene, ecliptic axes."""
    here, normal = SearchState.of(found.state).pole, _pole_map.plane_of(found.weighted.problem)
    turn = matrix_to_icrf("ecliptic").T
    return turn @ here, turn @ _pole_map.mirrored(here, normal)


def mirror_angle(found: inversion.Solution, case: Case) -> float:
    """The angle of the mirror pole in the plane of the scene to the true pole, deg."""
    return math.degrees(math.acos(max(-1.0, min(1.0, float(sides(found)[1] @ case.pole)))))


def errors_of(found: inversion.Solution, case: Case) -> np.ndarray:
    """Errors of two periods, the pole and two ratios of moments, in standard errors."""
    sigma = found.periods_sigma
    out = [(found.P_phi / 86400.0 - case.P_phi) / (sigma[1] / 86400.0)]
    pole = judged(found, case)[1]
    out.append(math.radians(pole) / found.pole_sigma / math.sqrt(1.5))
    if case.mode != "PA":
        out.append((found.P_psi / 86400.0 - case.P_psi) / (sigma[0] / 86400.0))
        moments, cov = found.motion.body.moments, found.covariance[6:, 6:]
        order = np.argsort(moments)
        scaled = moments[order] / moments[order[2]]
        wide = np.sqrt(np.maximum(np.diag(cov)[order], 0.0)) / moments[order[2]]
        out += [(scaled[k] - case.moments[k]) / max(wide[k], 1e-9) for k in (0, 1)]
    return np.array(out)


def cases_of(kind: Kind, count: int, seed: int) -> Iterator[Case]:
    """Cases of successive seeds, styles in turn; seeds that are left out are printed."""
    for k in range(count):
        case = kind.case(seed, k)
        while kind.decidable and not synthetic_curves.is_decidable(case):
            print(
                f"left out: seed {seed}, {synthetic_curves.variation(case):.3f} mag of variation "
                f"in errors of {math.sqrt(float(np.mean(case.sigma**2))):.3f}",
                flush=True,
            )
            seed += 1
            case = kind.case(seed, k)
        yield case
        seed += 1


def share_of_sky(poles: Iterable[np.ndarray]) -> float:
    """The share of the sky within 15 degrees of any of these directions (3,)."""
    sky = _shapes.even_directions(4000)
    near = [sky @ each > math.cos(math.radians(15.0)) for each in poles]
    return float(np.mean(np.any(near, axis=0))) if near else 0.0
