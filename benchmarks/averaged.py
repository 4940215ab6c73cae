"""How far are mean rotations from the full motion, and what do they cost?

python benchmarks/averaged.py [--quick]
"""

import argparse
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from attitude import Body, Spin, quaternion
from attitude.averaged import AveragedMotion
from attitude.averaged import _mean_state as mean_state
from attitude.averaged import _rates as rates
from attitude.averaged._polhode import LAM_PLUS, Axes, Nutations
from attitude.shape import Ellipsoid, Mesh
from attitude.splitting import TorquedRotation
from attitude.torques import (
    ConstantTorque,
    DipoleField,
    EddyCurrent,
    GravityGradient,
    InternalDissipation,
    SolarRadiation,
)

EPOCH = "2026-01-01"
DAY, YEAR, AU = 86400.0, 365.25 * 86400.0, 149597870700.0
EARTH, SUN, RADIUS = 3.986004418e14, 1.32712440018e20, 6.3712e6


# ---- Orbits, shapes, states


@dataclass(frozen=True)
class Orbit:
    """A Keplerian orbit."""

    axis: float  # m
    eccentricity: float
    mu: float
    inclination: float = 0.0
    node: float = 0.0
    argument: float = 0.3

    @property
    def period(self):
        return 2.0 * math.pi * math.sqrt(self.axis**3 / self.mu)

    @property
    def frame(self):
        """Rows: towards the pericentre, along the motion there, the normal."""
        i, o = self.inclination, self.node
        normal = np.array([math.sin(i) * math.sin(o), -math.sin(i) * math.cos(o), math.cos(i)])
        ascending = np.array([math.cos(o), math.sin(o), 0.0])
        across = np.cross(normal, ascending)
        c, s = math.cos(self.argument), math.sin(self.argument)
        return np.array([c * ascending + s * across, -s * ascending + c * across, normal])

    def __call__(self, t):
        """Positions (..., 3), m."""
        e = self.eccentricity
        mean = 2.0 * math.pi * np.asarray(t, dtype=float) / self.period
        anomaly = mean + e * np.sin(mean)
        for _ in range(40):
            step = (anomaly - e * np.sin(anomaly) - mean) / (1.0 - e * np.cos(anomaly))
            anomaly = anomaly - step
            if np.all(np.abs(step) < 1e-14 * np.maximum(1.0, np.abs(mean))):
                break
        along = self.axis * (np.cos(anomaly) - e)
        across = self.axis * math.sqrt(1.0 - e * e) * np.sin(anomaly)
        return along[..., None] * self.frame[0] + across[..., None] * self.frame[1]


def spin_of(moments, omega, pole, phase=0.7):
    """The Spin of rates (3,) over the principal axes whose momentum points to a pole."""
    momentum = np.asarray(moments) * omega
    start, end = momentum / np.linalg.norm(momentum), np.asarray(pole) / np.linalg.norm(pole)
    half = (start + end) / np.linalg.norm(start + end)
    turn = np.array([math.cos(0.5 * phase), *(math.sin(0.5 * phase) * end)])
    return Spin(
        epoch=EPOCH,
        wxyz=quaternion.multiply(turn, np.array([0.0, *half])),
        angular_velocity=np.asarray(omega, dtype=float),
    )


@dataclass(frozen=True)
class Facets:
    """Facets over the principal axes of a body, the least moment first."""

    areas: Any
    normals: Any
    centroids: Any
    moments: Any
    diffuse: Any = 1.0
    mirrored: Any = 0.0

    def sunlight(self, path):
        return SolarRadiation(self, path, diffuse=self.diffuse, mirrored=self.mirrored)


def over_principal_axes(shape, tensor, center, diffuse, mirrored):
    """Facets of areas, normals and centroids over the principal axes."""
    areas, normals, centroids = shape
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0.0:
        axes[:, 1] *= -1.0
    return Facets(areas, normals @ axes, (centroids - center) @ axes, moments, diffuse, mirrored)


def mesh(facets=320, is_concave=False):
    """A lumpy body of 150 m, m; the hull of its points, or with a hollow."""
    from scipy.spatial import ConvexHull

    ellipsoid = Ellipsoid(0.5 * np.array([150.0, 128.0, 93.0])).facets(facets)
    points = ellipsoid.vertices
    x, y, z = points.T / np.sqrt(np.sum(points**2, axis=-1))
    bumps = 0.3 * x * z * (x - 0.5 * y) + 0.3 * x * y * z - 0.2 * x * y**2
    if is_concave:
        hollow = (x - 0.2) ** 2 + (y - 0.3) ** 2 + (z - 0.93) ** 2
        bumps = bumps - 0.45 * np.exp(-hollow / 0.25)
        return Mesh(points * (1.0 + bumps)[:, None], ellipsoid.facets)
    hull = ConvexHull(points * (1.0 + bumps)[:, None])
    corners = hull.points[hull.simplices]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flip = np.sum(outwards * hull.equations[:, :3], axis=-1) < 0
    return Mesh(hull.points, np.where(flip[:, None], hull.simplices[:, ::-1], hull.simplices))


def asteroid():
    """The facets of the convex mesh."""
    shape = mesh()
    body = Body.from_shape(shape, density=2500.0)
    sides = shape.areas, shape.normals, shape.centroids
    return over_principal_axes(sides, body.tensor, body.center_of_mass, 1.0, 0.0)


def _box():
    """Sides of a bus of 2.0 x 2.0 x 2.3 m: centre, normal, area, diffuse, mirrored."""
    size = np.array([2.0, 2.0, 2.3])
    for k in range(3):
        for sign in (1.0, -1.0):
            normal = sign * np.eye(3)[k]
            yield 0.5 * normal * size, normal, np.prod(np.delete(size, k)), 0.1, 0.45


def _wing_and_sail():
    """One canted wing with its trim tab, and a cone on a boom on the other side."""
    cant, tab = math.radians(17.0), math.radians(42.0)
    for angle, y, area, diffuse, mirrored in (
        (cant, -3.5, 4.8 * 2.7, 0.05, 0.2),
        (tab, -6.3, 1.5, 0.05, 0.6),
    ):
        normal = np.array([math.cos(angle), 0.0, math.sin(angle)])
        for sign in (1.0, -1.0):
            yield np.array([0.0, y, 0.1]), sign * normal, area, diffuse, mirrored
    for k in range(8):
        angle = 2.0 * math.pi * (k + 0.5) / 8.0
        normal = np.array([0.97 * math.cos(angle), 0.22, 0.97 * math.sin(angle)])
        center = np.array([0.3 * math.cos(angle), 14.5, 0.3 * math.sin(angle)])
        yield center, normal / np.linalg.norm(normal), 0.75, 0.1, 0.7


def satellite():
    """A satellite like GOES 8: a bus, one wing, and a sail; the geometry is invented."""
    rows = [*_box(), *_wing_and_sail()]
    centers, normals, areas, diffuse, mirrored = (np.array(x) for x in zip(*rows, strict=True))
    tensor = np.array([[3432.1, 12.0, 5.0], [12.0, 980.5, 30.0], [5.0, 30.0, 3570.0]])
    center = np.array([0.02, -0.15, 0.03])
    return over_principal_axes((areas, normals, centers), tensor, center, diffuse, mirrored)


# ---- Accuracy: the mean state of the full motion at the end, and the averaged motion's


@dataclass(frozen=True)
class Case:
    """A motion, its span, and how both are integrated."""

    name: str
    moments: Any
    omega: Any
    torques: Any
    seconds: float
    turn: float  # rad of the body in a step of the full motion
    scheme: str = "suzuki"
    orbit: Any = "followed"
    pole: Any = (0.5, 0.3, 0.6)
    phase: float = 0.7


def compared(case, **settings):
    """Errors and changes of |L|, energy and pole, eps, turns, and seconds of processor of both."""
    body, spin = (
        Body(moments=case.moments),
        spin_of(case.moments, case.omega, case.pole, case.phase),
    )
    rate = float(np.linalg.norm(case.omega))
    full = TorquedRotation(body, spin, case.torques, step=case.turn / rate, scheme=case.scheme)
    begin = time.process_time()
    history = full.at(case.seconds)
    costs = [time.process_time() - begin]
    motion = AveragedMotion(body, spin, case.torques, orbit=case.orbit, **settings)
    motion.at(0.001 * case.seconds)
    begin = time.process_time()
    mean = motion.at(case.seconds)
    costs.append(time.process_time() - begin)
    truth = mean_of(motion, history, case.seconds)
    start = motion.at(0.0)
    found = {"turns": case.seconds * rate / (2.0 * math.pi), "eps": float(start.weakness)}
    found["full"], found["averaged"] = costs
    size = float(start.size)
    found["size change"] = (float(truth[0]) - size) / size
    found["size"] = (float(mean.size) - float(truth[0])) / size
    energy = float(start.energy)
    found["energy change"] = (truth[3] - energy) / energy
    found["energy"] = (float(mean.energy) - truth[3]) / energy
    found["pole change"] = angle(truth[2], start.pole)
    found["pole"] = angle(truth[2], mean.pole)
    found["y"] = float(mean.y) - truth[1]
    found["y change"] = truth[1] - float(start.y)
    found["regions"] = [int(start.region), int(mean.region), truth[4]]
    return found


def mean_of(motion, history, seconds):
    """|L|, y, pole, energy and region of the mean state of one epoch of a full motion."""
    spin = Spin(
        epoch=motion.epoch.after(seconds),
        wxyz=history.wxyz,
        angular_velocity=history.angular_velocity,
        frame="icrf",
    )
    _, y, region = motion.axes.state(spin.angular_velocity)
    shift, bend = mean_state.corrections(
        motion.axes, motion.body, spin, motion.torques, motion.epoch, seconds
    )
    momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ motion.body.tensor) - shift
    size = float(np.linalg.norm(momentum))
    energy = float(motion.axes.energy(np.array(size), np.array(y - bend)))
    return size, y - bend, momentum / size, energy, region


def angle(one, two):
    """rad between unit vectors."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, two)), one @ two))


ENVISAT = np.array([17023.0, 124826.0, 129112.0])


def gravity_cases(quick):
    for eccentricity in (0.0, 0.4):
        orbit = Orbit(12e6, eccentricity, EARTH, 1.2, 0.5)
        for mode, omega in (("SAM", (0.03, 0.004, 0.02)), ("LAM", (0.1, 0.006, 0.006))):
            yield Case(
                f"gravity, e = {eccentricity}, {mode}",
                ENVISAT,
                1.3 * np.array(omega),
                GravityGradient(orbit, EARTH),
                orbit.period * (10 if quick else 30),
                0.35,
                "blanes-moan",
            )


def eddy_cases(quick):
    orbit = Orbit(RADIUS + 770e3, 0.0, EARTH, math.radians(98.5), 0.4)
    tensor = np.diag([1.0e6, 2.2e6, 3.0e6])
    tensor += np.array([[0, 0.1e6, 0], [0.1e6, 0, 0.2e6], [0, 0.2e6, 0]])
    torque = EddyCurrent(tensor, DipoleField((0.0, 0.0, -3e-5 * RADIUS**3 * 1e7)), orbit)
    days = 10 if quick else 300
    for mode, omega in (("SAM", (0.01, 0.01, 0.045)), ("LAM", (0.05, 0.004, 0.01))):
        yield Case(
            f"eddy currents, {days} d, {mode}",
            ENVISAT,
            omega,
            torque,
            orbit.period * int(days * DAY / orbit.period),
            0.3,
            "suzuki",
            "averaged",
        )


def friction_cases(quick):
    moments = np.array([1.0, 3.0836, 3.235])
    for mode, strength, omega, span in (
        ("SAM", 1e-4, (5.0, 30.0, 60.0), 5e4),
        ("LAM", 1e-4, (98.709, 14.51, 33.529), 2e4),
    ):
        yield Case(
            f"friction, {mode}",
            moments,
            np.radians(np.array(omega)) / DAY,
            InternalDissipation(strength),
            span * DAY * (0.1 if quick else 1.0),
            0.03,
            "kick-rotate-kick",
        )


def light_cases(quick):
    facets = asteroid()
    orbit = Orbit(1.006 * AU, 0.23, SUN)
    rate = 2.0 * math.pi / (12.17 * 60.0)
    scale = 1.0 / 50.0  # to a body of 3 m
    small = Facets(
        facets.areas * scale**2,
        facets.normals,
        facets.centroids * scale,
        facets.moments * scale**5,
    )
    for mode, omega in (("SAM", (0.25, 0.1, 0.95)), ("LAM", (0.8, 0.05, 0.15))):
        yield Case(
            f"sunlight on 3 m, {mode}",
            small.moments,
            rate * np.array(omega),
            small.sunlight(orbit),
            orbit.period * (0.02 if quick else 2.0),
            0.25,
            "kick-rotate-kick",
        )
    box = satellite()
    orbit = Orbit(AU, 0.0167, SUN, math.radians(23.44))
    for mode, period, omega in (
        ("SAM", 200.0, (0.15, 0.1, 0.95)),
        ("SAM", 600.0, (0.15, 0.1, 0.95)),
        ("LAM", 200.0, (1.6, 0.1, 0.3)),
        ("LAM", 600.0, (1.6, 0.1, 0.3)),
    ):
        yield Case(
            f"box and wing, {period:.0f} s, {mode}",
            box.moments,
            2.0 * math.pi / period * np.array(omega),
            box.sunlight(orbit),
            DAY * (4.0 if quick else 60.0),
            0.12,
            "kick-rotate-kick",
        )


def all_cases(quick):
    for group in (gravity_cases, eddy_cases, friction_cases, light_cases):
        yield from group(quick)


# ---- Odds at the separatrix, by full motions of random phases


def state_of(motion, history):
    """Mode and end of a state of a full motion: 0 to 3."""
    return motion.axes.state(history.angular_velocity)[2]


def coin_cases():
    """Friction and a constant torque about the short axis, from the long-axis mode."""
    body = Body(moments=(1.0, 2.0, 2.6))
    strength = 3e-4
    # the torque, for L = 1 N m s, with which one of both arcs leads nowhere
    axes = Axes(body)
    arcs, seconds = axes.arcs
    p = 1.0 / (1.0 + math.exp(-axes.separatrix))
    gamma = np.array([1.0 - p, 0.0, -p])
    lost = axes.spread * np.sum((arcs[0] * gamma) ** 2, axis=-1) @ seconds
    limit = strength * lost / abs((arcs[0] * gamma)[:, 2] @ seconds)
    for share in (0.0, 0.5, -0.8, 1.5):
        push = limit * share
        yield (
            f"friction, {share:+.1f}",
            body,
            [
                InternalDissipation(strength),
                ConstantTorque((0.0, 0.0, push)),
            ],
        )


def coin(body, torques, count, seed=5):
    """Predicted odds of SAM+, the share of full motions that reach it, and their number."""
    rng = np.random.default_rng(seed)
    axes = Axes(body)
    reached, predicted = [], []
    for _ in range(count):
        # ahead of the separatrix by three laps and a random part of one
        y = axes.separatrix + 6e-3 * (3.0 + rng.random())
        nodes = axes.nodes(y, LAM_PLUS, 997)
        unit = nodes[rng.integers(997)]
        omega = unit / axes.moments
        spin = spin_of(axes.moments, omega, (0.0, 0.0, 1.0), 0.0)
        full = TorquedRotation(body, spin, torques, step=0.15 / np.linalg.norm(omega), scheme="hoa")
        period = Nutations.of(axes, LAM_PLUS, np.array([y - axes.separatrix])).period[0]
        end = full.at(14.0 * period)
        reached.append(axes.state(end.angular_velocity)[2])
        if len(predicted) < 8:
            motion = AveragedMotion(body, spin, torques)
            motion.at(14.0 * period)
            event = next(e for e in motion.events if e.kind == "passage")
            predicted.append(event.odds["SAM+"])
    return float(np.mean(predicted)), np.array(reached)


def sun_of_geo(ahead=0.0):
    """Positions from the Sun of a body at the Earth, on a circle, `ahead` s later."""

    def path(t):
        angle = 2.0 * math.pi * (np.asarray(t, dtype=float) + ahead) / 31557600.0
        over = np.stack([np.cos(angle), 0.91748 * np.sin(angle), 0.39779 * np.sin(angle)], axis=-1)
        return -AU * over

    return path


def geo_spin(axes, phase, turn):
    """A spin of 60 s about the short axis, with a tilt of 2 deg."""
    y = 2.0 * math.log(math.tan(math.radians(2.0)))
    unit = axes.nodes(y, 0, 8)[phase]
    omega = axes.moments[2] * 2.0 * math.pi / 60.0 * unit / axes.moments
    return spin_of(axes.moments, omega, (0.3, 0.2, 0.9), turn)


def geo_coin(count, seed=3):
    """Odds at the first passage of a satellite like GOES 8, and regions of full motions."""
    box = satellite()
    body = Body(moments=box.moments)
    light = box.sunlight(sun_of_geo())
    motion = AveragedMotion(body, geo_spin(Axes(body), 0, 0.1), light, orbit="followed")
    motion.at(0.4 * YEAR)
    passage = next(e for e in motion.events if e.kind == "passage")
    begin = passage.seconds - 0.004 * YEAR
    start, rng = motion.at(begin), np.random.default_rng(seed)
    later, reached = box.sunlight(sun_of_geo(begin)), []
    for _ in range(count):
        free = start.free_rotation(phases=tuple(rng.random(2)))
        rate = free.spin.angular_velocity
        spin = Spin(EPOCH, free.spin.wxyz_icrf, rate, frame="icrf")
        step = 0.16 / np.linalg.norm(rate)
        full = TorquedRotation(body, spin, later, step=step, scheme="kick-rotate-kick")
        reached.append(state_of(motion, full.at(2.0 * (passage.seconds - begin))))
    return passage.odds["LAM+"], np.array(reached)


def geo_member(phase, years=1.6):
    """|L| each 0.2 years of a full motion like GOES 8, and of the nearest leaf of its tree."""
    box = satellite()
    body = Body(moments=box.moments)
    light = box.sunlight(sun_of_geo())
    spin = geo_spin(Axes(body), phase, 2.4 * phase + 0.1)
    t = np.arange(0.0, years + 1e-9, 0.2) * YEAR
    # the rate grows by a factor of four
    step = 0.04 / np.linalg.norm(spin.angular_velocity)
    full = TorquedRotation(body, spin, light, step=step, scheme="kick-rotate-kick")
    begin = time.process_time()
    history = full.at(t)
    cost = time.process_time() - begin
    motion = AveragedMotion(body, spin, light, orbit="followed", tolerance=1e-8)
    truth = np.array([mean_of(motion, history[k], t[k])[0] for k in range(len(t))])
    leaves = motion.branches(float(t[-1]))
    errors = [float(np.max(np.abs(leaf.at(t).size / truth - 1.0))) for leaf in leaves]
    best = int(np.argmin(errors))
    return errors[best], leaves[best], len(leaves), cost


# ---- Costs


def rate_cost(motion, repeat=20000):
    """Seconds of processor of one call of the compiled right-hand side."""
    packed, out = motion.packed, np.empty(4)
    forcing, _ = motion.window(0.0, 1.0)
    given = 0.0, motion.start.copy(), motion.start_region, packed.data, packed.models
    rates.rates_at(*given, forcing, packed.work, out, 10)
    found = []
    for _ in range(5):
        begin = time.process_time()
        rates.rates_at(*given, forcing, packed.work, out, repeat)
        found.append((time.process_time() - begin) / repeat)
    return min(found)


def show(name, found):
    parts = []
    for key in ("size", "energy", "pole", "y"):
        change = found[key + " change"]
        ratio = abs(found[key] / change) if change else 0.0
        parts.append(f"{key} {found[key]:+.1e}/{change:+.1e}={ratio:.1e}")
    print(
        f"{name}: turns {found['turns']:.0f} eps {found['eps']:.1e}", *parts,
        f"full {found['full']:.1f} s averaged {found['averaged']:.3f} s", found["regions"],
        flush=True,
    )  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--count", type=int, default=300)
    options = parser.parse_args()
    if options.only == "coins":
        for name, body, torques in coin_cases():
            odds, reached = coin(body, torques, options.count)
            counts = np.bincount(reached, minlength=4) / len(reached)
            print(name, f"{odds:.3f}", counts, flush=True)
        return
    if options.only == "geo coin":
        odds, reached = geo_coin(options.count)
        print(f"{odds:.3f}", np.bincount(reached, minlength=4) / len(reached))
        return
    if options.only == "members":
        for phase in range(8):
            error, leaf, count, cost = geo_member(phase)
            print(phase, f"{error:.1e}", leaf.regions, leaf.odds, count, f"{cost:.1f}", flush=True)
        return
    for case in all_cases(options.quick):
        if options.only in case.name:
            show(case.name, compared(case))


if __name__ == "__main__":
    main()
