"""A satellite of known shape over a site: `python benchmarks/inversion_passes.py 20 7000 [2 [5]]`.

Circular orbits over a site, a box with one wing of random size and materials, tumbling by Euler's
equations (DOP853, `synthetic_curves`); brightness from facets divided in 16, with finer shadows.
200 points of 0.1 mag a pass; a third argument is the number of passes, an orbit apart, in one
curve, a fourth the budget in seconds, which is compared with what a search took.  The input has
shape, materials, moments and geometry, rates up to twice the true one are searched.  The rate
vector is compared over axes in space.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attitude import Body, FreeRotation, Spin, inversion, light_curve
from attitude.frames import quaternion
from attitude.scattering import Material, Materials
from attitude.shape import box_wing
from tests.support.synthetic_curves import _integrated, _matrices

EARTH, GM, TURN = 6378.0e3, 3.986e14, 7.292e-5  # m, m3/s2, rad/s
AU = 1.495978707e11
EPOCH = "2000-01-01T12:00:00 TDB"  # from which the seconds of a curve count


class Pass(NamedTuple):
    """A curve and what is known, and the truth: attitude matrix and rates at the epoch."""

    curve: inversion.LightCurve
    mesh: object
    law: Materials
    body: Body
    matrix: np.ndarray
    omega: np.ndarray
    most: float


def case(seed: int, passes: int = 1) -> Pass:
    """The curve of so many passes of a seed."""
    rng = np.random.default_rng(seed)
    size = np.array([rng.uniform(2.0, 6.0), rng.uniform(1.5, 3.0), rng.uniform(1.0, 2.5)])
    wing = rng.uniform(3.0, 8.0), rng.uniform(1.5, 3.0)
    mesh = box_wing(
        size, wing, gap=0.5, wing_axis="xyz"[rng.integers(3)], wing_angle=rng.uniform(0.2, 1.3),
        wings=1, thickness=0.1,
    )  # fmt: skip
    law = Materials(
        {
            "body": Material(0.25, 0.35, exponent=rng.uniform(30.0, 150.0)),
            "panel front": Material(0.05, 0.25, exponent=rng.uniform(50.0, 300.0)),
            "panel back": Material(0.3, 0.05, exponent=30.0),
            "panel edge": Material(0.3),
        }
    )
    body = Body.from_shape(mesh, density=100.0)
    seconds, sun, observer = _sky(rng, passes)
    period = math.exp(rng.uniform(math.log(25.0), math.log(150.0)))
    omega = rng.normal(size=3)
    omega *= 2.0 * math.pi / period / np.linalg.norm(omega)
    # over principal axes
    axes, moments = body.principal_axes, body.moments
    q = rng.normal(size=4)
    start = np.r_[q / np.linalg.norm(q), axes.T @ omega]
    seconds = seconds - seconds[0] + 1.0
    grid = np.concatenate([[0.0], seconds])
    turn = _matrices(_integrated(moments, start, grid)[:, :4]) @ axes.T
    seen = [np.einsum("tji,tj->ti", turn[1:], each) for each in (sun, _unit(observer))]
    flux = light_curve.brightness(mesh.divided(2), law, *seen)
    bright = flux > 1e-3 * np.mean(flux)
    magnitude = 5.0 - 2.5 * np.log10(np.where(bright, flux, 1.0))
    magnitude += 5.0 * np.log10(np.linalg.norm(observer, axis=1) / 1e6)
    magnitude += 0.1 * rng.normal(size=len(seconds))
    curve = inversion.LightCurve(
        seconds[bright],
        magnitude[bright],
        0.1,
        sun=AU * sun[bright],
        observer=observer[bright],
        light_time=False,
    )
    return Pass(curve, mesh, law, body, turn[0], omega, 2.0 / period)


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _sky(rng, passes):
    """Epochs (N,), s, and vectors (N, 3) to Sun (unit) and observer, m, of 200 points a pass."""
    radius = EARTH + rng.uniform(550e3, 950e3)
    rate = math.sqrt(GM / radius**3)
    off = rng.uniform(0.0, 0.12)  # of the site from the plane, rad

    def places(t):
        angle = TURN * t if passes > 1 else 0.0 * t
        site = EARTH * np.stack(
            [math.cos(off) * np.cos(angle), math.cos(off) * np.sin(angle), 0.0 * t + math.sin(off)],
            axis=-1,
        )
        return radius * np.stack([np.cos(rate * t), np.sin(rate * t), 0.0 * t], axis=-1), site

    seconds = []
    for k in range(passes):
        middle = 2.0 * math.pi * k / (rate - TURN)
        t = middle + np.linspace(-600.0, 600.0, 2401)
        place, site = places(t)
        line = place - site
        up = np.sum(line * site, axis=1) / EARTH > math.sin(math.radians(15.0)) * np.linalg.norm(
            line, axis=1
        )
        seconds.append(np.sort(rng.uniform(t[up][0], t[up][-1], 200)))
    seconds = np.concatenate(seconds)
    place, site = places(seconds)
    # the Sun is below the horizon of the site, and the satellite in its light
    while True:
        sun = _unit(rng.normal(size=3))
        below = site @ sun / EARTH
        across = np.linalg.norm(np.cross(place, sun), axis=1)
        dark = np.all((below > -0.4) & (below < -0.1))
        if dark and np.all((place @ sun > 0.0) | (across > EARTH)):
            break
    return seconds, np.broadcast_to(sun, (len(seconds), 3)), site - place


def judged(found: object, given: Pass) -> float:
    """The relative error of the rate vector, over axes in space, which no symmetry changes."""
    here = found.motion.at([EPOCH])
    rate = here.matrix[0] @ here.angular_velocity[0]
    truth = given.matrix @ given.omega
    return float(np.linalg.norm(rate - truth) / np.linalg.norm(truth))


def deviation(found: object, given: Pass) -> float:
    """The error of the rate vector, over axes in space, in its standard errors: of the worst axis.

    At the epoch of the solution, near the middle of a span.
    """
    spin = found.motion.spin
    wxyz = quaternion.from_matrix(given.matrix)
    truth = FreeRotation(given.body, Spin(EPOCH, wxyz, given.omega)).at([spin.epoch])
    here = found.motion.at([spin.epoch])
    rate = here.matrix[0] @ here.angular_velocity[0]
    # by a turn about axes in space, and by rates over the body's
    slopes = np.concatenate([np.cross(np.eye(3), rate).T, here.matrix[0]], axis=1)
    covariance = slopes @ spin.covariance[:6, :6] @ slopes.T
    error = rate - truth.matrix[0] @ truth.angular_velocity[0]
    return float(np.max(np.abs(error) / np.sqrt(np.diag(covariance))))


def main(arguments: list[str]) -> None:
    """Solve cases and print each and the sums."""
    print(run(*map(int, arguments)))


def run(count: int, seed: int, passes: int = 1, budget: int = 900) -> str:
    """Solve cases and print each; the sums."""
    right, claims, spent, deviations = 0, 0, [], []
    for k in range(count):
        given = case(seed + k, passes)
        begin = time.process_time()
        found = inversion.spin_states(
            given.curve, given.most, shape=given.mesh, law=given.law, moments=given.body,
            budget=float(budget),
        )  # fmt: skip
        spent.append(time.process_time() - begin)
        errors = [judged(each, given) for each in found]
        good = bool(errors) and errors[0] < 0.02
        right += good
        claims += found.verdict == "solved" and not good
        deviations.append(deviation(found[0], given))
        listed = [k for k, each in enumerate(errors) if each < 0.02]
        turns = np.linalg.norm(given.omega) * given.curve.span / (2.0 * math.pi)
        print(
            f"{k:2d} {turns:.1f} turns, {len(given.curve)} points: error of the rate "
            f"{100.0 * errors[0]:.2f} %, {deviations[-1]:.1f} sigma, rank {listed[:1]}, "
            f"{found.verdict}, rms {found[0].rms:.3f}, {spent[-1]:.1f} s",
            flush=True,
        )
    return (
        f"{count} curves: rate to 2 % in {right}, solved and wrong {claims}, "
        f"rates within 3 sigma in {sum(each < 3.0 for each in deviations)}, "
        f"processor median {np.median(spent):.1f} s, largest {max(spent):.1f} s"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
