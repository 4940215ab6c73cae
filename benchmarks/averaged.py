"""How far are mean rotations from the full motion, and what do they cost?

python benchmarks/averaged.py [--quick] [TABLE ...]
"""

import argparse
import contextlib
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[1]))

from attitude import AttitudeError, Body, Ensemble, Spin, quaternion
from attitude.averaged import AveragedHistory, AveragedMotion, _resonances, _tables
from attitude.averaged import _mean_state as mean_state
from attitude.averaged import _rates as rates
from attitude.averaged._means import means_of
from attitude.averaged._pack import Packed, Sampling
from attitude.averaged._polhode import LAM_PLUS, REGIONS, Axes, Nutations
from attitude.epochs import instant
from attitude.shape import Ellipsoid, Mesh
from attitude.splitting import TorquedRotation
from attitude.torques import (
    ConstantTorque,
    DipoleField,
    EddyCurrent,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    SolarRadiation,
)
from benchmarks.doc_tables import Table, markdown
from tests.support.mean_motions import late_passages

MAKES = (
    "averaged",
    "averaged orders",
    "averaged odds",
    "averaged passages",
    "averaged leaves",
    "averaged kicks",
    "averaged phases",
    "averaged costs",
)
EPOCH = "2026-01-01"
# Seconds; metres.
DAY = 86400.0
YEAR = 365.25 * DAY
AU = 149597870700.0
# GM of the Earth and of the Sun, m3/s2; radius of the Earth in models of its field, m.
EARTH = 3.986004418e14
SUN = 1.32712440018e20
RADIUS = 6.3712e6
# Trees that split at resonances: least kick and branches at most.
SPLIT = ((8e-4, 256), (4e-4, 4096))


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
    settings = {"tolerance": 1e-9, "least_tilt": 1e-8, **settings}
    motion = AveragedMotion(body, spin, case.torques, orbit=case.orbit, **settings)
    motion.at(case.seconds)  # loads machine code
    motion = AveragedMotion(body, spin, case.torques, orbit=case.orbit, **settings)
    begin = time.process_time()
    mean = motion.at(case.seconds)
    costs.append(time.process_time() - begin)
    start = motion.at(0.0)
    found = {"turns": case.seconds * rate / (2.0 * math.pi), "eps": float(start.weakness)}
    found["full"], found["averaged"] = costs
    return found | differences(mean, mean_of(motion, history, case.seconds), start)


def differences(mean, truth, start):
    """|L|, energy, pole, y and regions: a mean state less the truth, the truth less the start."""
    found, size, energy = {}, float(start.size), float(start.energy)
    found["size change"] = (float(truth[0]) - size) / size
    found["size"] = (float(mean.size) - float(truth[0])) / size
    found["energy change"] = (truth[3] - energy) / energy
    found["energy"] = (float(mean.energy) - truth[3]) / energy
    found["pole change"] = angle(truth[2], start.pole)
    found["pole"] = angle(truth[2], mean.pole)
    found["y"] = float(mean.y) - truth[1]
    found["y change"] = truth[1] - float(start.y)
    found["regions"] = [int(start.region), int(mean.region), truth[4]]
    return found


def orders(case):
    """eps; errors of osculating states as means, of mean states, of second order; its seconds.

    With harmonics to degree 64, whose errors are less than those of second order.
    """
    settings = {"tolerance": 1e-9, "least_tilt": 1e-8, "degree": 64, "orbit": "followed"}
    body = Body(moments=case.moments)
    spin = spin_of(case.moments, case.omega, case.pole, case.phase)
    step = case.turn / float(np.linalg.norm(case.omega))
    full = TorquedRotation(body, spin, case.torques, step=step, scheme=case.scheme)
    history, found = full.at(case.seconds), []
    motion = AveragedMotion(body, spin, case.torques, **settings)
    _, y, region = motion.axes.state(spin.angular_velocity)
    momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ body.tensor)
    track = motion._tracks[0].resumed(0.0, np.append(momentum, y), region)
    track.extend(case.seconds, motion._choose)
    ends = []
    for t in (0.0, case.seconds):
        states, regions = track.states(np.array([t]))
        ends.append(AveragedHistory(motion.packing, np.array(t), states[0], regions[0]))
    found.append(differences(ends[1], mean_of(motion, history, case.seconds, False), ends[0]))
    for order in (1, 2):
        motion = AveragedMotion(body, spin, case.torques, order=order, **settings)
        begin = time.process_time()
        mean = motion.at(case.seconds)
        cost = time.process_time() - begin
        found.append(differences(mean, mean_of(motion, history, case.seconds), motion.at(0.0)))
    return float(motion.at(0.0).weakness), found, cost


def mean_of(motion, history, seconds, is_mean=True):
    """|L|, y, pole, energy and region of the mean, or osculating, state of a full motion."""
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
    if not is_mean:
        shift, bend = np.zeros(3), 0.0
    momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ motion.body.tensor) - shift
    size = float(np.linalg.norm(momentum))
    energy = float(motion.axes.energy(np.array(size), np.array(y - bend)))
    return size, y - bend, momentum / size, energy, region


def angle(one, two):
    """rad between unit vectors."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, two)), one @ two))


ENVISAT = np.array([17023.0, 124826.0, 129112.0])


def gravity_cases(quick):
    """Point mass, followed along the orbit; at four times the rate the torque is weak."""
    for eccentricity in (0.0, 0.4):
        orbit = Orbit(12e6, eccentricity, EARTH, 1.2, 0.5)
        for mode, omega in (("SAM", (0.03, 0.004, 0.02)), ("LAM", (0.1, 0.006, 0.006))):
            for rate in (1.3, 5.2):
                yield Case(
                    f"gravity, e = {eccentricity}, {mode}",
                    ENVISAT,
                    rate * np.array(omega),
                    GravityGradient(orbit, EARTH),
                    orbit.period * (5 if quick else 30),
                    0.35,
                    "blanes-moan",
                )


def eddy_cases(quick):
    """An anisotropic tensor on a polar orbit, averaged over the orbit."""
    orbit = Orbit(RADIUS + 770e3, 0.0, EARTH, math.radians(98.5), 0.4)
    tensor = np.diag([1.0e6, 2.2e6, 3.0e6])
    tensor += np.array([[0, 0.1e6, 0], [0.1e6, 0, 0.2e6], [0, 0.2e6, 0]])
    torque = EddyCurrent(tensor, DipoleField((0.0, 0.0, -3e-5 * RADIUS**3 * 1e7)), orbit)
    days = 4 if quick else 100
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
    """Moments of Toutatis; the second passes the separatrix."""
    moments = np.array([1.0, 3.0836, 3.235])
    for mode, omega, span in (
        ("SAM", (5.0, 30.0, 60.0), 5e4),
        ("LAM", (98.709, 14.51, 33.529), 2e4),
    ):
        yield Case(
            f"friction, {mode}",
            moments,
            np.radians(np.array(omega)) / DAY,
            InternalDissipation(1e-4),
            span * DAY * (0.1 if quick else 1.0),
            0.03,
            "kick-rotate-kick",
        )


def light_cases(quick):
    """Steps that resolve kinks: those of 0.25 rad err by 5e-3 of the change of |L|."""
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
            f"sunlight, 3 m, {mode}",
            small.moments,
            rate * np.array(omega),
            small.sunlight(orbit),
            orbit.period * (0.02 if quick else 1.0),
            0.04,
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
            0.03,
            "kick-rotate-kick",
        )


def all_cases(quick):
    for group in (gravity_cases, eddy_cases, friction_cases, light_cases):
        yield from group(quick)


# ---- Envisat, whose momentum was seen to precess in 4.8 d (2013) and 3.4 d (2015)


def envisat():
    """Days of a turn of the momentum about the orbit's normal in 2013.5 and 2015.5."""
    still = Orbit(RADIUS + 767e3, 0.0, EARTH, math.radians(98.4))

    def turned(v, t):
        angle = 2.0 * math.pi / YEAR * np.asarray(t)  # the node follows the Sun
        c, s = np.cos(angle), np.sin(angle)
        return np.stack(
            [c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1], v[..., 2]], -1
        )

    def path(t):
        return turned(still(t), t)

    normal = still.frame[2]
    across = np.cross(normal, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    tilt = math.radians(8.53)
    axes = Axes(Body(moments=ENVISAT))
    unit = axes.nodes(2.0 * math.log(math.tan(math.radians(1.0))), 0, 16)[3]
    omega = ENVISAT[2] * 2.0 * math.pi / 120.674 * unit / axes.moments
    spin = spin_of(ENVISAT, omega, math.sin(tilt) * across - math.cos(tilt) * normal)
    field = DipoleField((0.0, 0.0, -3e-5 * RADIUS**3 * 1e7))
    torques = [EddyCurrent(588280.57, field, path), GravityGradient(path, EARTH)]
    motion = AveragedMotion(Body(moments=ENVISAT), spin, torques, orbit="averaged")
    found = []
    for years in (0.5, 2.5):
        t = years * YEAR + np.linspace(0.0, 12.0 * DAY, 600)
        poles, normals = motion.at(t).pole, turned(np.broadcast_to(normal, (600, 3)), t)
        one = np.cross(normals, [0.0, 0.0, 1.0])
        two = np.cross(normals, one)
        phase = np.unwrap(np.arctan2(np.sum(poles * two, 1), np.sum(poles * one, 1)))
        found.append(2.0 * math.pi / abs(np.polyfit(t, phase, 1)[0]) / DAY)
    return found


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


def beside_sun(t):
    """The circle of `sun_of_geo` about a place beside the Sun: no turn under a central force."""
    return sun_of_geo()(t) + 0.1 * AU * np.array([0.0, -0.91748, -0.39779])


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


def held(strength, count, seed=1):
    """Odds that P_psi/P_phi = 1/1 captures, and whether full motions are held, of random phases.

    Sunlight of one direction, and damping that leaves the energy at its place: the loop in which
    motions are held grows as |L| falls.
    """
    box = satellite()
    body, axes = Body(moments=box.moments), Axes(Body(moments=box.moments))
    places = [y for j, k, is_long, y in _resonances.places(axes) if is_long and j == k == 1]
    nutation = Nutations.of(axes, LAM_PLUS, np.array([places[0] - axes.separatrix]))
    lost = nutation.gamma[0] * nutation.squares[0] / axes.moments
    damping = LinearDamping(strength * np.diag([1.0, 0.0, -lost[0] / lost[2]]))
    torques = [box.sunlight(still_sun), damping]
    momentum = axes.moments[2] * 2.0 * math.pi / 600.0 * np.array([0.598, 0.359, 0.717])
    state = np.append(momentum, places[0])
    unit = axes.nodes(places[0], LAM_PLUS, 8)[0]
    spin = spin_of(axes.moments, np.linalg.norm(momentum) * unit / axes.moments, momentum)
    packing = AveragedMotion(body, spin, torques).packing
    span = 13.0 * DAY
    state = state - span * packing.rates_of(0.0, state, LAM_PLUS)[0]
    start = AveragedHistory(packing, np.array(0.0), state, np.array(LAM_PLUS))
    motion = AveragedMotion(body, start.free_rotation(phases=(0.1, 0.2)).spin, torques)
    motion.at(2.0 * span)
    event = next(e for e in motion.events if e.ratio == (1, 1))
    rng, stay = np.random.default_rng(seed), []
    for _ in range(count):
        free = start.free_rotation(phases=tuple(rng.random(2)))
        step = 0.1 / np.linalg.norm(free.spin.angular_velocity)
        end = TorquedRotation(body, free.spin, torques, step=step).at(event.seconds + event.lasts)
        stay.append(abs(axes.state(end.angular_velocity)[1] - places[0]) < event.width)
    return event.capture, np.array(stay)


def still_sun(t):
    """Positions from the Sun that do not change."""
    place = AU * np.array([-0.717137, 0.358569, -0.597614])
    return np.broadcast_to(place, (*np.shape(t), 3)).copy()


def geo_member(phase, years=1.6):
    """A full motion like GOES 8 beside the nearest leaf of its tree, each 0.2 years.

    The leaf, the error of its |L|, that with the kicks of the resonances at the phases of the full
    motion, the root mean square that the leaf states over unknown phases, and the errors of the
    nearest leaves of trees that split at resonances.
    """
    light, motion = goes_member(phase)
    body, spin = motion.body, motion.spin
    t = np.arange(0.0, years + 1e-9, 0.2) * YEAR
    tree = motion.branches(float(t[-1]))
    crossings = [_resonances.crossed(leaf._track, leaf.until) for leaf in tree]
    times = np.unique([e.seconds for events in crossings for e in events if e.scatter > 2e-5])
    # the rate grows by a factor of four
    step = 0.04 / np.linalg.norm(spin.angular_velocity)
    full = TorquedRotation(body, spin, light, step=step, scheme="kick-rotate-kick")
    history = full.at(np.concatenate([t, times]))
    truth = np.array([mean_of(motion, history[k], t[k])[0] for k in range(len(t))])
    gaps = np.array([leaf.at(t).size / truth - 1.0 for leaf in tree])
    best = int(np.argmin(np.max(np.abs(gaps), axis=1)))
    states = {when: history[len(t) + k] for k, when in enumerate(times)}
    known = kicked(motion, tree[best], crossings[best], states, t) / truth - 1.0
    scatter = float(np.max(tree[best].scatter(t)["size"]))
    error, of_kicks = (float(np.max(np.abs(gap))) for gap in (gaps[best], known))
    return tree[best], [error, scatter, of_kicks, *(nearest(motion, truth, t, *s) for s in SPLIT)]


def nearest(motion, truth, t, least, most):
    """The largest error of |L| (T,) of the nearest leaf of a tree."""
    tree = motion.branches(float(t[-1]), least_kick=least, most=most)
    return min(float(np.max(np.abs(leaf.at(t).size / truth - 1.0))) for leaf in tree)


def beside_leaves(phase, step=0.03):
    """Largest errors of |L| of the nearest leaf, each 0.2 of 1.6 years: without and with splits.

    Of the member with steps of so many radians: the same start as of `geo_member`, but other phases
    from the third resonance on.
    """
    light, motion = goes_member(phase)
    t = np.arange(0.0, 1.6 + 1e-9, 0.2) * YEAR
    seconds = step / np.linalg.norm(motion.spin.angular_velocity)
    full = TorquedRotation(
        motion.body, motion.spin, light, step=seconds, scheme="kick-rotate-kick"
    ).at(t)
    truth = np.array([mean_of(motion, full[k], t[k])[0] for k in range(len(t))])
    return [nearest(motion, truth, t, *split) for split in ((None, 256), *SPLIT)]


def kicked(motion, leaf, crossings, states, t):
    """|L| of a leaf at seconds (T,), kicked at resonances by the phases of a full motion, N m s."""
    track, size = leaf._track, leaf.at(t).size.copy()
    passages = [event for event in leaf.events if event.kind == "passage"]
    for event in crossings:
        if event.seconds not in states:
            continue
        x, region = track.states(np.array([event.seconds]))
        x = x[0] + kick_of(motion, event, states[event.seconds])
        onward = [REGIONS.index(e.after) for e in passages if e.seconds > event.seconds]
        track = track.resumed(event.seconds, x, int(region[0]))
        track.extend(float(t[-1]), _resonances.along(onward))
        later = t > event.seconds
        size[later] = np.linalg.norm(track.states(t[later])[0][:, :3], axis=1)
    return size


def kick_of(motion, event, history):
    """What a crossing adds to L and y (4,), by the phases of a full motion close to it.

    The beat and its angle are integrated under the resonant terms of y, as a pendulum, to both
    sides until the terms average out.
    """
    spin = Spin(motion.epoch.after(event.seconds), history.wxyz, history.angular_velocity,
                frame="icrf")  # fmt: skip
    terms, beats, _ = mean_state.series(
        motion.axes, motion.body, spin, motion.torques, motion.epoch, event.seconds
    )
    (j, k), (size, y, region) = event.ratio, motion.axes.state(spin.angular_velocity)
    slope = size * _resonances._slope(motion.axes, y, (j, k, 0))
    momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ motion.body.tensor)
    mean = motion.packing.rates_of(event.seconds, np.append(momentum, y), region)[0]
    orders = np.arange(1, 32 // k)
    rows = np.argmin(np.abs(beats[:, k * orders]), axis=0)
    lines = terms[rows, k * orders]

    def rate(_, state):
        kick = 2.0 * np.real(np.exp(1j * orders * state[0]) @ lines)
        # of k w_phi - j w_psi
        return np.concatenate([[state[1], -slope * (mean[3] + kick[3])], kick])

    total, span = np.zeros(4), 3.0 * event.lasts
    for sign in (1.0, -1.0):
        begin = np.concatenate([[0.0, beats[rows[0], k]], np.zeros(4)])
        found = solve_ivp(
            rate, (0.0, sign * span), begin, rtol=1e-8, atol=1e-14, max_step=span / 300
        )
        angle_, beat = found.y[:2, -1]
        # of the end, the mean state
        waves = 2.0 * np.real(np.exp(1j * orders * angle_) / (1j * orders * beat) @ lines)
        total += sign * (found.y[2:, -1] - waves)
    return total


def goes_member(phase, **settings):
    """The light and the mean motion of a member like GOES 8."""
    box = satellite()
    body, light = Body(moments=box.moments), box.sunlight(sun_of_geo())
    spin = geo_spin(Axes(body), phase, 2.4 * phase + 0.1)
    settings = {"orbit": "followed", "tolerance": 1e-8, **settings}
    return light, AveragedMotion(body, spin, light, **settings)


def drawn(motion, t, rng, weak):
    """|L| (T,) of a mean motion with passages by their odds and kicks at drawn phases.

    Of resonances whose scatter of y is at least 1e-4; weak: the others, filled.
    """
    track, last = motion._tracks[0].resumed(0.0, motion.start, motion.start_region), 0.0
    while True:
        track.extend(float(t[-1]), lambda one, crossing: None)
        reached, kick = float(min(track.clock[0], t[-1])), None
        for when, j, k, y in _resonances._times(track, reached):
            kind = j, k, int(track.states(np.array([when]))[1][0])
            if when <= last or kind in weak:
                continue
            event, rows = _resonances._event(track, when, (j, k, 0), y)
            if event.scatter < 1e-4:
                weak.add(kind)
                continue
            last = when + min(event.lasts, 0.9 * (reached - when))
            angles = 2.0 * math.pi * rng.random(len(rows) // 2)
            kick = np.concatenate([np.cos(angles), np.sin(angles)]) @ rows
            break
        if kick is not None:
            track = track.kicked(last, kick)
        elif track.waits is None or track.reaches(float(t[-1])):
            return np.linalg.norm(track.states(t)[0][:, :3], axis=1)
        else:
            first, second = track.waits.odds
            goes_first = rng.random() < track.waits.odds[first]
            track.pass_to(first if goes_first else second, track.waits)


def kicks(quick):
    """The table of trees that split at resonances: how near their leaves come to drawn motions."""
    _, motion = goes_member(0)
    t = np.arange(0.0, 1.6 + 1e-9, 0.2) * YEAR
    rng, weak, rows = np.random.default_rng(1), set(), []
    sizes = np.array([drawn(motion, t, rng, weak) for _ in range(10 if quick else 40)])
    for least, most in ((None, 256), (1.2e-3, 256), *SPLIT):
        begin = time.process_time()
        tree = motion.branches(float(t[-1]), least_kick=least, most=most)
        cost = time.process_time() - begin
        leaves_ = np.array([leaf.at(t).size for leaf in tree])
        errors = np.array([np.min(np.max(np.abs(leaves_ / one - 1.0), axis=1)) for one in sizes])
        scatter = float(np.max(tree[0].scatter(t)["size"]))
        rows.append(["none" if least is None else f"{least:.1e}", len(tree), f"{cost:.2g}",
                     f"{scatter:.1e}", f"{np.median(errors):.1e}", f"{np.max(errors):.1e}",
                     f"{np.sum(errors <= 2e-3)} of {len(errors)}"])  # fmt: skip
        if least is None:
            scatter = float(np.max(scatter_behind(tree[0], t)))
            rows.append(["those before the passage known", "", "", f"{scatter:.1e}", "", "", ""])
    heads = ("least_kick", "leaves", "seconds", "scatter of the likeliest", "median error",
             "largest", "within 2e-3")  # fmt: skip
    return Table("averaged kicks", markdown(heads, rows))


def scatter_behind(leaf, t):
    """The scatter of |L| (T,) of a leaf by what happens behind its first passage."""
    track = leaf._track.branched()
    passage = next(event for event in leaf.events if event.kind == "passage")
    for key, (event, _) in track.resonances.items():
        if event.seconds < passage.seconds:
            track.resonances[key] = event, np.zeros((0, 4))
    return _resonances.scatter(track, t)[:, 0]


def phase_errors(phase, ratios, turns):
    """Errors in rad, before resonances of ratios, of means of orders 1 and 2 and of full motions.

    Of the angle of a resonance as the frequencies of mean states make it, against the full motion
    with the last of its steps, turns in rad; and of |L|.
    """
    light, motion = goes_member(phase)
    leaf = motion.branches(75.0 * DAY)[0]
    events = _resonances.crossed(leaf._track, leaf.until)
    t = np.linspace(0.0, 72.9 * DAY, 487)
    states = [goes_member(phase, order=order, degree=64)[1].at(t) for order in (1, 2)]
    found = [(one.size, one.y) for one in states]
    for turn in turns:
        step = turn / np.linalg.norm(motion.spin.angular_velocity)
        full = TorquedRotation(
            motion.body, motion.spin, light, step=step, scheme="kick-rotate-kick"
        )
        history = full.at(t)
        rows = np.array([mean_of(motion, history[k], t[k])[:2] for k in range(len(t))])
        found.append((rows[:, 0], rows[:, 1]))
    errors = []
    for j, k in ratios:
        event = next(e for e in events if e.ratio == (j, k) and e.before == "SAM+")
        behind = int(np.searchsorted(t, event.seconds - 0.5 * event.lasts))
        angles = []
        for size, y in found:
            one, two = _resonances.frequencies(motion.axes, y)
            angles.append(np.trapezoid((size * (j * one - k * two))[:behind], t[:behind]))
        sizes = [size[behind - 1] / found[-1][0][behind - 1] - 1.0 for size, _ in found]
        errors.append([*(np.array(angles)[:-1] - angles[-1]), *sizes[:-1]])
    return np.array(errors)


def phases(quick):
    """The table of phases at the resonances before the first passage."""
    ratios, members = ((4, 1), (5, 1), (6, 1), (7, 1)), (0,) if quick else (0, 1, 2)
    errors = [phase_errors(member, ratios, (0.08, 0.04)) for member in members]
    sizes, rows = np.sqrt(np.mean(np.square(errors), axis=0)), []
    for (j, k), row in zip(ratios, sizes, strict=True):
        angles = [f"{angle_:.2f}" for angle_ in row[:3]]
        rows.append([f"{j}/{k}", *angles, *(f"{share:.0e}" for share in row[3:])])
    heads = ("P_psi/P_phi", "first order", "second", "full, 0.08 rad",
             "L, first order", "second", "full, 0.08 rad")  # fmt: skip
    return Table("averaged phases", markdown(heads, rows))


def passages(quick):
    """The table of the times by which full motions pass the separatrix early or late."""
    rows = []
    for name, body, torques in list(coin_cases())[:3]:
        passage, times = late_passages(body, torques, 60 if quick else 400)
        sizes, means = np.sqrt(np.mean(times**2, axis=0)), np.mean(times[:, 0])
        rows.append([name, len(times), f"{passage.delay:.2f}", f"{sizes[0]:.2f}", f"{means:+.2f}",
                     f"{sizes[1]:.2f}"])  # fmt: skip
    heads = "motion", "full motions", "predicted, s", "behind, s", "mean, s", "at 4000 s"
    return Table("averaged passages", markdown(heads, rows))


# ---- Costs


def rate_cost(motion, repeat=20000):
    """Seconds of processor of one call of the compiled right-hand side."""
    packed, out = motion.packing.packed, np.empty(4)
    window = motion.packing.window(0.0, 1.0)
    forcing = window.forcing
    given = 0.0, motion.start.copy(), motion.start_region, packed.data, window.models
    rates.rates_at(*given, forcing, packed.work, out, 10)
    found = []
    for _ in range(5):
        begin = time.process_time()
        rates.rates_at(*given, forcing, packed.work, out, repeat)
        found.append((time.process_time() - begin) / repeat)
    return min(found)


def costs():
    """Rows of the costs: what is measured, and seconds of processor."""
    box = satellite()
    body, light = Body(moments=box.moments), box.sunlight(sun_of_geo())
    spin = geo_spin(Axes(body), 0, 0.1)
    motion = AveragedMotion(body, spin, light, orbit="followed")
    yield "right-hand side: sunlight of one direction, degree 32", rate_cost(motion)
    averaged = AveragedMotion(body, spin, box.sunlight(beside_sun), orbit="averaged")
    yield "32 directions of an orbit, degree 32", rate_cost(averaged, 2000)
    friction = AveragedMotion(body, spin, InternalDissipation(1e-5))
    yield "friction, in closed form", rate_cost(friction)
    gravity = GravityGradient(Orbit(12e6, 0.0, EARTH, 1.2, 0.5), EARTH)
    tensor = AveragedMotion(body, spin, gravity, orbit="averaged")
    yield "gravity gradient, in closed form", rate_cost(tensor)
    spans = []
    for seed in range(6):
        motion = AveragedMotion(body, spin, light, orbit="followed", passages=seed)
        motion.at(YEAR)
        begin = time.process_time()
        motion.at(30.0 * YEAR)
        spans.append(time.process_time() - begin)
    yield "30 years of a satellite like GOES 8, median of 6 draws", float(np.median(spans))
    yield "the same for 1000 members, after their first year", members(body, light)
    yield "1 million years of sunlight and friction, 150 m, median of 12", *million_years()
    yield "table of a mesh of 316 facets, degree 32, not on disk", table_cost()


def members(body, light, count=1000):
    """Seconds of processor for 30 years of members with random tilts and poles, one thread."""
    axes, rng = Axes(body), np.random.default_rng(4)
    tilts = 2.0 * np.log(np.tan(np.radians(rng.uniform(1.0, 6.0, count))))
    units = np.array([axes.nodes(float(y), 0, 8)[rng.integers(8)] for y in tilts])
    rates_ = axes.moments[2] * 2.0 * math.pi / 60.0 * units / axes.moments
    ensemble = Ensemble(body, rng.normal(size=(count, 4)), rates_, EPOCH)
    means = ensemble.averaged(light, passages=1, orbit="followed", on_error="nan")
    means.at(YEAR)
    begin = time.process_time()
    means.at(30.0 * YEAR)
    return time.process_time() - begin


def million_years(count=12):
    """Median and largest seconds of processor, of random states of a turn in 1 h."""
    facets, orbit = asteroid(), Orbit(1.006 * AU, 0.23, SUN)
    body = Body(moments=facets.moments)
    axes, rng, spans = Axes(body), np.random.default_rng(1), []
    for _ in range(count):
        y = axes.separatrix + 2.0 * rng.normal()
        unit = axes.nodes(y, 0 if y < axes.separatrix else 2, 16)[3]
        omega = axes.moments[2] * 2.0 * math.pi / 3600.0 * unit / axes.moments
        spin = spin_of(axes.moments, omega, rng.normal(size=3))
        torques = [facets.sunlight(orbit), InternalDissipation(1e-9)]
        motion = AveragedMotion(body, spin, torques, orbit="averaged", passages=1)
        motion.at(YEAR)
        begin = time.process_time()
        with contextlib.suppress(AttitudeError):  # "no longer weak" ends some of them
            motion.at(1e6 * YEAR)
        spans.append(time.process_time() - begin)
    return float(np.median(spans)), max(spans)


def table_cost():
    """Seconds of processor for harmonics and sums of the convex mesh."""
    shape = mesh()
    body = Body.from_shape(shape, density=2500.0)
    torque, axes = SolarRadiation(shape, sun_of_geo()), Axes(body)
    parameters = torque.parameters(body)
    field = _tables.field_of(torque.address(), parameters, axes, torque.columns)
    _tables.sums_of(_tables.harmonics(field, 2), axes)
    begin = time.process_time()
    _tables.sums_of(_tables.harmonics(field, 32), axes)
    return time.process_time() - begin


# ---- Error of the mean torque of a mesh by degree, against nodes of both phases


def mesh_errors(is_concave, shadows, degree, count=201):
    """Errors of the mean torque of four states, in units of its root mean square."""
    shape = mesh(is_concave=is_concave)
    body = Body.from_shape(shape, density=2500.0)
    axes = Axes(body)
    sun = -AU * np.array([0.6, -0.3, 0.5]) / np.linalg.norm([0.6, -0.3, 0.5])

    def path(t):
        return np.broadcast_to(sun, (len(t), 3)).copy()

    torque = SolarRadiation(shape, path, shadows=shadows)
    still = Sampling(torque, math.inf, False, math.inf)
    means = [(still, mean) for mean in means_of(torque, body, axes, degree)]
    packed = Packed(axes, body, means, instant(EPOCH))
    forcing, errors = packed.window(0, math.inf, (0.0, 0.0)), []
    for region, h, pole in (
        (0, 1.5, (0.3, 0.2, 0.9)),
        (2, 2.0, (0.8, 0.3, -0.3)),
        (1, 0.3, (0.9, 0.1, 0.3)),
        (3, 0.5, (-0.2, 0.5, 0.4)),
    ):
        y = axes.separatrix + (h if region >= LAM_PLUS else -h)
        state, out = np.append(1e6 * np.array(pole), y), np.empty(4)
        rates.rates_at(0.0, state, region, packed.data, packed.models, forcing, packed.work, out, 1)
        truth, size = over_nodes(axes, body, torque, state, region, count)
        errors.append(float(np.linalg.norm(out[:3] - truth) / size))
    return errors


def over_nodes(axes, body, torque, state, region, count):
    """The mean torque (3,) over nodes of both phases, and the root mean square of the torque."""
    momentum = state[:3]
    size = np.linalg.norm(momentum)
    points, unit = axes.nodes(state[3], region, count), momentum / size
    halves = (unit + points) / np.linalg.norm(unit + points, axis=1)[:, None]
    first = np.concatenate([np.zeros((count, 1)), halves], axis=1)
    angles = math.pi * (np.arange(count) + 0.37) / count
    turns = np.concatenate([np.cos(angles)[:, None], np.sin(angles)[:, None] * unit], axis=1)
    back = quaternion.conjugate(quaternion.from_matrix(axes.matrix))
    wxyz = quaternion.multiply(quaternion.multiply(turns, first[:, None]), back).reshape(-1, 4)
    given = torque.sample(instant(EPOCH), np.zeros(1), np.zeros(1))
    given = np.ascontiguousarray(np.broadcast_to(given, (len(wxyz), given.shape[1])))
    parameters = np.append(np.asarray(torque.parameters(body), dtype=float), 0.0)
    found, zero = np.empty((len(wxyz), 3)), np.zeros((len(wxyz), 3))
    rates.torques_at(
        torque.address(), parameters.ctypes.data, zero[:, 0].copy(), wxyz, zero, given, found
    )
    inertial = quaternion.rotate(wxyz, found)
    return inertial.mean(axis=0), float(np.sqrt(np.mean(np.sum(found**2, axis=1))))


# ---- Tables


def _share(errors, key):
    """Error over change; the error itself in brackets where the mean is constant."""
    change = errors[f"{key} change"]
    if abs(change) <= 10.0 * abs(errors[key]):  # both are 0 where nothing moves |L|
        return f"({abs(errors[key]):.0e})"
    return f"{abs(errors[key] / change):.1e}"


def accuracy(quick):
    """The table of errors over changes."""
    rows = []
    for case in all_cases(quick):
        found = compared(case)
        names = "size", "energy", "pole"
        shares = [_share(found, name) for name in names]
        times = f"{found['full']:.2g}", f"{found['averaged']:.2g}"
        turns = f"{found['turns']:,.0f}"
        rows.append([case.name, turns, f"{found['eps']:.0e}", *shares, *times])
    days = envisat()
    rows.append(["Envisat, 2013.5: 4.8 d observed", "", "", "", "", f"{days[0]:.2f} d", "", ""])
    rows.append(["Envisat, 2015.5: 3.4 d observed", "", "", "", "", f"{days[1]:.2f} d", "", ""])
    heads = "motion", "turns", "eps", "L", "energy", "pole", "full, s", "averaged, s"
    return Table("averaged", markdown(heads, rows))


def by_order(quick):
    """The table of what mean states and second order gain, for paths that are followed."""
    rows = []
    for case in all_cases(quick):
        if case.orbit != "followed":
            continue
        eps, found, cost = orders(case)
        cells = [", ".join(_share(one, name) for name in ("size", "energy", "pole"))
                 for one in found]  # fmt: skip
        rows.append([case.name, f"{eps:.0e}", *cells, f"{cost:.2g}"])
    heads = "motion", "eps", "osculating", "mean states", "second order", "second order, s"
    return Table("averaged orders", markdown(heads, rows))


def odds(quick):
    """The table of odds at the separatrix, and of members of a tree."""
    count = 40 if quick else 300
    rows = []
    for name, body, torques in coin_cases():
        predicted, reached = coin(body, torques, count)
        rows.append([name, "SAM+", f"{predicted:.3f}", _frequency(reached == 0, predicted)])
    if not quick:
        predicted, reached = geo_coin(count)
        rows.append(
            ["like GOES 8", "LAM+", f"{predicted:.3f}", _frequency(reached == 2, predicted)]
        )
    for strength in (3e-4, 8e-4):
        predicted, stay = held(strength, count)
        name = f"sunlight, damping {strength:.0e}"
        rows.append([name, "held at 1/1", f"{predicted:.3f}", _frequency(stay, predicted)])
    return Table("averaged odds", markdown(("motion", "region", "odds", "full motions"), rows))


def _frequency(hits, odds):
    """The share of full motions, and its distance from the odds in standard deviations."""
    deviation = math.sqrt(max(odds * (1.0 - odds), 1e-12) / len(hits))
    return f"{np.mean(hits):.3f} of {len(hits)} ({(np.mean(hits) - odds) / deviation:+.1f} sigma)"


def leaves(_):
    """The table of full motions and the leaves next to them: 200 s of processor each."""
    rows = []
    for phase in range(8):
        leaf, errors = geo_member(phase)
        numbers = (f"{error:.1e}" for error in (*errors, *beside_leaves(phase)))
        rows.append([phase, *passed(leaf, 1.6 * YEAR), *numbers])
    heads = ("phase", "regions", "odds", "error of L", "scatter of the leaf", "phases known",
             "of 256 leaves", "of 4096", "again, of 8", "of 256", "of 4096")  # fmt: skip
    return Table("averaged leaves", markdown(heads, rows))


def passed(leaf, until):
    """The regions of a branch up to a time, s, and the product of the odds of its passages."""
    events = [e for e in leaf.events if e.kind == "passage" and e.seconds <= until]
    odds = math.prod(event.odds[event.after] for event in events)
    return " ".join([leaf.regions[0], *(event.after for event in events)]), f"{odds:.3f}"


def prices(quick):
    """The table of costs, and of errors of the mean torque of meshes."""
    rows = [[name, *(f"{1e6 * t:.2f} us" if t < 1e-4 else f"{t:.3f} s" for t in times)]
            for name, *times in costs()]  # fmt: skip
    rows = [[name, ", at most ".join(times)] for name, *times in rows]
    for label, settings in (
        ("convex mesh", (False, False)),
        ("concave mesh", (True, False)),
        ("concave mesh, shadows", (True, True)),
    ):
        worst = [max(mesh_errors(*settings, degree)) for degree in (16, 32)]
        text = f"{worst[0]:.0e} at degree 16, {worst[1]:.0e} at 32, of the torque"
        rows.append([f"error of the mean torque: {label}", text])
    return Table("averaged costs", markdown(("what", "processor"), rows))


def made(quick, names):
    """The tables of these names, one after the other; not that of leaves for --quick."""
    makers = accuracy, by_order, odds, passages, leaves, kicks, phases, prices
    for name, make in zip(MAKES, makers, strict=True):
        if name in names and not (quick and make is leaves):
            yield make(quick)


def tables(quick):
    """The tables of docs/averaged.md."""
    yield from made(quick, MAKES)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="short spans, fewer motions")
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"of: {', '.join(MAKES)}")
    given = parser.parse_args()
    for table in made(given.quick, given.tables or MAKES):
        print(table.text, flush=True)


if __name__ == "__main__":
    main()
