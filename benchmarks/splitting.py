"""How accurate are the splitting integrators around the exact free rotation, and what do they cost?

The script prints, and with --output draws,

    cost       time of the exact short step, and of a step under a constant torque and under
               gravity gradient
    orders     attitude error of each scheme on an eccentric orbit against a 34-digit integration
    circular   T + V - n L (normal), conserved on a circular orbit, over many orbits: the exact
               splitting and those that also split the kinetic energy, at the same step
    drift      the same energy from many starts: its slope, and the mean change of energy and
               momentum by rounding in the free motions, each with its standard error
    dop853     100 rotations under gravity gradient against DOP853 at 1e-13
    referee    error against cost of integrators of the free rotation
    tolerance  cost of an adaptive step, and the estimate of the error of 50 motions against it
    impulses   1e3 impulses: cost of a random epoch, and the error against a chain of oracles

    python benchmarks/splitting.py [--quick] [--output FOLDER] [part ...]

All parts take some half an hour, with --quick one minute.
"""

import argparse
import math
import sys
import time
from pathlib import Path

import numba
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from mpmath import mp, mpf

from attitude import Body, Spin, paths
from attitude._compilation.choice import compiling
from attitude._compilation.decorators import entry_point, subroutine
from attitude._solver.kernel import turned_by
from attitude._solver.march import march
from attitude._solver.step import advance, gains, loaded, stored
from attitude.arcs import Arcs, Impulse
from attitude.referee import _referee, compare
from attitude.splitting import SCHEMES, TorquedRotation
from attitude.torques import ConstantTorque, CustomTorque, GravityGradient, LinearDamping
from benchmarks.doc_tables import Table, markdown
from benchmarks.record import processor, writable_folder
from tests.support import torque_cases
from tests.support.gragg import EccentricOrbit, integrate
from tests.support.oracle import Oracle, conjugate, multiply, rotation_error
from tests.support.rounding import moved

BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(1, 15, 1))
TURN = 2.0 * np.pi
# On the circular orbit: units in which GM = a = n = 1; the body turns 12 times an orbit.
RATES = (6.0, 3.0, 10.0)
START = (1.0, 0.2, 0.3, 0.4)
STEPS_AN_ORBIT = 1000
MAKES = (
    "impulses",
    "cost of a step",
    "orders of schemes",
    "conservation",
    "drift of the energy",
    "energy error by spin",
)


def tables(quick):
    """The tables of docs/impulses.md and docs/torques.md; --quick makes those of costs."""
    costs, shown = impulses(quick, None)
    head = "1000 impulses, half over body axes and half over ICRF", "measured"
    yield Table("impulses", markdown(head, shown), costs=costs)
    costs = cost(quick, None)
    head = "ns", "free step", *SCHEMES
    rows = [
        ("constant torque", f"{costs['free step']:.0f}"),
        ("gravity gradient (without positions)", ""),
    ]
    rows = [
        (*row, *(f"{costs[f'{name}, {kind}']:.0f}" for name in SCHEMES))
        for row, kind in zip(rows, ("ConstantTorque", "GravityGradient"), strict=True)
    ]
    yield Table("cost of a step", markdown(head, rows), costs=costs)
    if quick:
        return
    counts, found = orders(False, None)
    rows = [
        (
            name,
            *(f"{each:.1e}" for each in errors[::2]),
            f"{math.log2(errors[0] / errors[2]) / 2:.2f}",
        )
        for name, errors in found.items()
    ]
    yield Table("orders of schemes", markdown(("steps an orbit", *counts[::2], "order"), rows))
    rows, spins = circular_orbit(False, None)
    head = "free motion", "scheme", "first", "last", "drift", "scatter", "time"
    yield Table("conservation", markdown(head, rows))
    head = (*("turns an orbit", "Dullweber, Leimkuhler & McLachlan / exact", "Reich / exact"),
            *("ns a step, exact", "of the first", "of the second"))  # fmt: skip
    yield Table("energy error by spin", markdown(head, spins))
    head = "scheme", "slope of T + V - n L", "median size", "T, free motions", "L², free motions"
    yield Table("drift of the energy", markdown(head, drift(False, None)))


def best(run, repeats):
    costs = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        costs.append(time.perf_counter() - begin)
    return min(costs)


# Cost ---------------------------------------------------------------------------------------------


@entry_point
def flights(m, h, count, state):
    moments = m[0], m[1], m[2]
    k, now = gains(moments), loaded(state)
    for _ in range(count):
        now = advance(moments, k, h, now)
    stored(now, state)


def cost(quick, output):
    # Many short runs: the best one is free of other load.
    count, repeats = 4_000, 100 if quick else 400
    print("cost of one step, ns (the best of many runs)")
    state, found = np.zeros(14), {}
    state[0], state[4:7] = 1.0, SPIN.angular_velocity
    for angle in (0.01, 0.1, 0.25, 0.5, 1.0):
        h = angle / np.hypot.reduce(state[4:7])
        flights(BODY.moments, h, 1, state)
        seconds = best(lambda h=h: flights(BODY.moments, h, count, state), repeats)
        print(f"  exact free step, {angle:5.2f} rad           {seconds / count * 1e9:8.0f}")
        if angle == 0.1:
            found["free step"] = seconds / count * 1e9
    h = 0.1 / np.hypot.reduce(SPIN.angular_velocity)
    for name in SCHEMES:
        each = {}
        for torque in (ConstantTorque((0, 0, 0)), GravityGradient(circular, 1.0)):
            system = TorquedRotation(BODY, SPIN, torque, step=h, scheme=name)._system
            rows = count * len(system.scheme.flights) + 1
            given = system.sampled(np.stack([h * np.arange(rows), np.zeros(rows)]))
            kept = np.empty((1, 14))

            def run(system=system, parameters=given, kept=kept):
                march(*system.setup, system.start.copy(), 0.0, h, count, parameters, kept, count)

            run()
            each[type(torque).__name__] = best(run, repeats) / count * 1e9
        shown = ", ".join(f"{key} {value:.0f}" for key, value in each.items())
        print(f"  step of {name:20s}        {shown}")
        found |= {f"{name}, {kind}": value for kind, value in each.items()}
    return found


# Orders -------------------------------------------------------------------------------------------


def eccentric_path(seconds, e=0.3):
    anomaly = seconds + e * np.sin(seconds)
    for _ in range(20):
        anomaly += (seconds - anomaly + e * np.sin(anomaly)) / (1.0 - e * np.cos(anomaly))
    x, y = np.cos(anomaly) - e, np.sqrt(1.0 - e * e) * np.sin(anomaly)
    return np.stack([x, y, 0.0 * x], axis=-1)


def orders(quick, output):
    span, start, w = TURN, (0.5, 0.5, 0.5, 0.5), (1.0, 4.0, 0.5)
    with mp.workdps(34):
        orbit = EccentricOrbit((10, 20, 26), mpf(0.3))
        y = [mpf(x) for x in (*start, *w)]
        exact = integrate(orbit.slope, mpf(0), y, mpf(span), 40, 14)
        finer = None if quick else integrate(orbit.slope, mpf(0), y, mpf(span), 60, 14)
        if finer:
            apart = max(abs(a - b) for a, b in zip(exact, finer, strict=True))
            print(
                f"34-digit integration: 40 and 60 steps of order 28 differ by {mp.nstr(apart, 2)}"
            )
    counts = [2**k for k in range(8, 12 if quick else 15)]
    print(
        f"one eccentric orbit (e = 0.3), {span * math.hypot(*w) / TURN:.1f} rotations: error, rad"
    )
    print(f"{'steps':>22s}" + "".join(f"{n:>9d}" for n in counts) + "   order")
    spin = Spin(epoch="2026-01-01", wxyz=start, angular_velocity=w)
    found = {}
    for name in SCHEMES:
        errors = []
        for n in counts:
            motion = TorquedRotation(
                BODY, spin, GravityGradient(eccentric_path, 1.0), step=span / n, scheme=name
            )
            errors.append(rotation_error(motion.at(span).wxyz, exact[:4], signed=True))
        found[name] = errors
        order = math.log2(errors[0] / errors[2]) / 2.0
        print(f"{name:>22s}" + "".join(f"{e:9.1e}" for e in errors) + f"{order:8.2f}")
    if output:
        draw_orders(np.array(counts), found, output)
    return counts, found


def draw_orders(counts, results, output):
    figure, axes = new_figure()
    for name, errors in results.items():
        work = counts * max(SCHEMES[name].evaluations, 1)
        axes.loglog(work, errors, "o-", label=f"{name} (order {SCHEMES[name].order})", ms=4)
    axes.set(
        xlabel="torque evaluations an orbit",
        ylabel="attitude error after one orbit (rad)",
        title="Gravity gradient, e = 0.3, against a 34-digit integration",
    )
    save(figure, axes, output, "splitting_orders.png")


# Circular orbit -----------------------------------------------------------------------------------


def circular(seconds):
    return np.stack([np.cos(seconds), np.sin(seconds), 0.0 * seconds], axis=-1)


def circular_path():
    """The same orbit as a path, evaluated in two doubles of time, exact also over 1e5 orbits."""
    zero = dict.fromkeys(("eccentricity", "inclination", "node", "pericenter_argument"), 0.0)
    return paths.kepler(
        **zero, mean_anomaly=0.0, epoch=SPIN.epoch, semi_major_axis=1.0, gm=1.0, frame="icrf"
    )


@subroutine
def gravity_kick(m, q, w, x, y, h):
    u = turned_by((q[0], -q[1], -q[2], -q[3]), (x, y, 0.0))
    return (
        w[0] + 3.0 * h * (m[2] - m[1]) / m[0] * u[1] * u[2],
        w[1] + 3.0 * h * (m[0] - m[2]) / m[1] * u[2] * u[0],
        w[2] + 3.0 * h * (m[1] - m[0]) / m[2] * u[0] * u[1],
    )


@subroutine
def jacobi(m, q, w, x, y):
    u = turned_by((q[0], -q[1], -q[2], -q[3]), (x, y, 0.0))
    kinetic = 0.5 * (m[0] * w[0] * w[0] + m[1] * w[1] * w[1] + m[2] * w[2] * w[2])
    potential = 1.5 * (m[0] * u[0] * u[0] + m[1] * u[1] * u[1] + m[2] * u[2] * u[2])
    normal = turned_by(q, (m[0] * w[0], m[1] * w[1], m[2] * w[2]))[2]
    return kinetic + potential - normal


@entry_point
def classical(kind, m, start, points, orbits, out):
    """Kick-rotate-kick with the free motion of another scheme; fills the extremes of each window.

    points: cosines and sines (2, steps an orbit + 1); out: (windows, 2), over `orbits` in total.
    """
    i = m[0], m[1], m[2]
    q = start[0], start[1], start[2], start[3]
    w = start[4], start[5], start[6]
    steps = points.shape[1] - 1
    h = 2.0 * math.pi / steps
    first = jacobi(i, q, w, points[0, 0], points[1, 0])
    each = orbits // len(out)
    for window in range(len(out)):
        least, most = math.inf, -math.inf
        for _ in range(each):
            for k in range(steps):
                w = gravity_kick(i, q, w, points[0, k], points[1, k], 0.5 * h)
                q, w = _referee.one_step(kind, i, q, w, h)
                w = gravity_kick(i, q, w, points[0, k + 1], points[1, k + 1], 0.5 * h)
                error = jacobi(i, q, w, points[0, k + 1], points[1, k + 1]) / first - 1.0
                least, most = min(least, error), max(most, error)
        out[window, 0], out[window, 1] = least, most


def energies(history, gradient):
    w = history.angular_velocity
    kinetic = 0.5 * np.sum(w * w * BODY.moments, axis=-1)
    normal = history.body_to_inertial(w * BODY.moments)[..., 2]
    return kinetic + gradient.potential(BODY, history) - normal


def watched(name, orbits, windows, looks=40, epochs=100):
    """Extremes (windows, 2) and means (windows,) of a scheme's energy error.

    In each window some evenly spread orbits are evaluated at random epochs, all by one
    TorquedRotation.
    """
    spin = Spin(epoch=SPIN.epoch, wxyz=START, angular_velocity=RATES)
    gradient = GravityGradient(circular_path(), 1.0)
    motion = TorquedRotation(BODY, spin, gradient, step=TURN / STEPS_AN_ORBIT, scheme=name)
    first = energies(motion.at([0.0]), gradient)[0]
    random = np.random.default_rng(2006)
    out, means = np.empty((windows, 2)), np.empty(windows)
    for window in range(windows):
        which = np.arange(looks) * (orbits / windows / looks)
        t = TURN * (orbits / windows * window + which[:, None] + random.random((looks, epochs)))
        error = energies(motion.at(t), gradient) / first - 1.0
        out[window], means[window] = (error.min(), error.max()), error.mean()
    return out, means


def circular_orbit(quick, output):
    """Print the error of each scheme's conserved energy, by windows of the whole time."""
    orbits, windows = (2_000, 20) if quick else (100_000, 50)
    points = np.stack([f(np.linspace(0.0, TURN, STEPS_AN_ORBIT + 1)) for f in (np.cos, np.sin)])
    start = np.concatenate([np.array(START) / np.sqrt(np.dot(START, START)), RATES])
    turn = TURN / STEPS_AN_ORBIT * math.hypot(*RATES)
    print(f"circular orbit, {orbits} orbits, {STEPS_AN_ORBIT} steps each ({turn:.3f} rad a step):")
    print("largest relative error of T + V - n L in the first and the last window; drift of its")
    print("mean over all orbits, and scatter of the windows about it")
    found, lines, spins = {}, [], []
    for name, kind in (("dlm", _referee.DLM), ("reich", _referee.REICH)):
        out = np.empty((windows, 2))
        begin = time.perf_counter()
        classical(kind, BODY.moments, start, points, orbits, out)
        line = report(name, out, out.mean(axis=1), orbits, time.perf_counter() - begin, found)
        names = {"dlm": "Dullweber, Leimkuhler & McLachlan", "reich": "Reich"}
        lines.append((names[name], "kick-rotate-kick", *line))
    for name in ("kick-rotate-kick", "hoa", "force-gradient", "blanes-moan"):
        begin = time.perf_counter()
        out, means = watched(name, orbits, windows)
        line = report(name, out, means, orbits, time.perf_counter() - begin, found)
        lines.append(("exact", name, *line))
    exact = spread(found["kick-rotate-kick"][0])
    ratio = {name: spread(found[name][0]) / exact for name in ("dlm", "reich")}
    print(
        "energy error relative to that of kick-rotate-kick with the exact free motion, at the same "
        f"step: Dullweber-Leimkuhler-McLachlan {ratio['dlm']:.1f}, Reich {ratio['reich']:.1f}"
    )
    print("the same ratio for other spins at the same turn a step, from torques as strong as the")
    print("spin to torques much weaker, and the cost of a step in the same loop, ns")
    print("                          DLM    Reich     exact   DLM   Reich")
    for times in (1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8):
        (exact, dlm, reich), costs = other_spin(start, times)
        listed = "".join(f"{1e9 * cost:6.0f}" for cost in costs)
        print(
            f"  {times * math.hypot(*RATES):5.1f} turns an orbit {dlm / exact:8.1f} "
            f"{reich / exact:8.1f}   {listed}"
        )
        ratios = f"{times * math.hypot(*RATES):.3g}", f"{dlm / exact:.2g}", f"{reich / exact:.2g}"
        spins.append((*ratios, *(f"{1e9 * each:.0f}" for each in costs)))
    if output:
        draw_circular(found, output)
    return lines, spins


def other_spin(start, times):
    """Energy errors over 40 orbits of the exact splitting, DLM and Reich, and seconds per step.

    Spin and steps an orbit are multiplied by `times`.
    """
    steps = round(times * STEPS_AN_ORBIT)
    angles = np.linspace(0.0, TURN, steps + 1)
    points, start = np.stack([np.cos(angles), np.sin(angles)]), start.copy()
    start[4:] *= times
    errors, costs, out = [], [], np.empty((1, 2))
    for kind in (_referee.EXACT, _referee.DLM, _referee.REICH):
        took = best(lambda kind=kind: classical(kind, BODY.moments, start, points, 40, out), 3)
        errors.append(spread(out))
        costs.append(took / (40 * steps))
    return errors, costs


def spread(out):
    return float(np.max(np.abs(out)))


def report(name, out, means, orbits, seconds, results):
    results[name] = out, orbits
    t = (np.arange(len(means)) + 0.5) / len(means)
    line = np.polyfit(t, means, 1)
    scatter = np.std(means - np.polyval(line, t))
    print(
        f"  {name:18s} {np.max(np.abs(out[0])):9.2e} {np.max(np.abs(out[-1])):9.2e} "
        f"{line[0]:+10.1e} {scatter:9.1e}   {orbits} orbits in {seconds:.0f} s",
        flush=True,
    )
    edges = (f"{np.max(np.abs(out[k])):.2e}" for k in (0, -1))
    return *edges, f"{line[0]:.0e}", f"{scatter:.0e}", f"{seconds:.0f} s"


def draw_circular(results, output):
    figure, axes = new_figure()
    for name, (out, orbits) in results.items():
        edges = np.linspace(0.0, orbits, len(out) + 1)
        label = {
            "dlm": "kinetic energy split by axes (Dullweber, Leimkuhler & McLachlan)",
            "reich": "symmetric top and rest (Reich)",
        }.get(name, f"exact free motion: {name}")
        axes.stairs(np.max(np.abs(out), axis=1), edges, label=label, baseline=None, lw=1.5)
    axes.set(
        yscale="log",
        xlabel="orbits",
        ylabel="largest relative error of T + V - n L",
        title=f"Gravity gradient on a circular orbit, {STEPS_AN_ORBIT} steps an orbit",
    )
    save(figure, axes, output, "splitting_circular.png")


# Drift --------------------------------------------------------------------------------------------


@entry_point
def jacobis(m, states, points, begin, out):
    """T + V - n L of states (S, 14), at the points (2, steps an orbit) from number `begin` on."""
    i, orbit = (m[0], m[1], m[2]), points.shape[1]
    for k in range(len(states)):
        s = states[k]
        size = 1.0 / math.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[3] * s[3])
        q = size * s[0], size * s[1], size * s[2], size * s[3]
        place = (begin + k) % orbit
        out[k] = jacobi(i, q, (s[4], s[5], s[6]), points[0, place], points[1, place])


def drift(quick, output):
    """Print slopes of the energy from random starts, and mean rounding errors of free motions."""
    starts, orbits = (4, 100) if quick else (16, 1000)
    print(f"{starts} random starts of {orbits} orbits; relative changes an orbit, their mean over")
    print("the starts and its standard error; in brackets the median of the sizes of the slopes,")
    print("and the size of the change in free motions in units of the random walk of rounding")
    print("(1 for a pure random walk); last, the size of this walk of T in 100,000 orbits")
    print(f"{'':18s}{'T + V - n L':^32s}{'T, free motions':^30s}{'L^2, free motions':^30s}    walk")
    shown = []
    for name in ("kick-rotate-kick", "hoa", "suzuki", "force-gradient", "blanes-moan"):
        random = np.random.default_rng(2006)
        runs = [one_start(name, random, orbits) for _ in range(starts)]
        slopes, sums = (np.array(part) for part in zip(*runs, strict=True))
        changes, errors = sums[:, :, 0] / orbits, np.sqrt(sums[:, :, 1]) / orbits
        error, size = np.std(slopes, ddof=1) / math.sqrt(starts), np.median(np.abs(slopes))
        line = f"{name:18s}{np.mean(slopes):+9.1e} +- {error:.1e} ({size:.1e})"
        cells = [name, f"{np.mean(slopes):.0e} ± {error:.0e}", f"{size:.1e}"]
        for n in range(2):
            error = math.sqrt(np.sum(errors[:, n] ** 2)) / starts
            ratio = math.sqrt(np.mean((changes[:, n] / errors[:, n]) ** 2))
            line += f"  {np.mean(changes[:, n]):+9.1e} +- {error:.1e} ({ratio:.1f})"
            cells.append(f"{np.mean(changes[:, n]):.1e} ± {error:.1e}")
        shown.append(cells)
        far = math.sqrt(np.mean(sums[:, 0, 2]) / orbits * 100_000)
        print(f"{line}   {far:.0e}", flush=True)
    return shown


def one_start(name, random, orbits):
    """The relative slope of T + V - n L per orbit, and the sums of `tests.support.rounding.moved`.

    The energy of a regular motion oscillates with a few periods.  A smooth bell over each half of
    the time averages these out (Das, Saiki, Sander & Yorke 2017).
    """
    direction = random.normal(size=3)
    rates = math.hypot(*RATES) * direction / math.hypot(*direction)
    spin = Spin(epoch=SPIN.epoch, wxyz=random.normal(size=4), angular_velocity=rates)
    h = TURN / STEPS_AN_ORBIT
    gradient = GravityGradient(circular_path(), 1.0)
    system = TorquedRotation(BODY, spin, gradient, step=h, scheme=name)._system
    points = np.ascontiguousarray(circular(h * np.arange(STEPS_AN_ORBIT))[:, :2].T)
    energy, sums = np.empty((orbits, STEPS_AN_ORBIT)), np.zeros((2, 3))
    state, times = system.start.copy(), system.scheme.flights * h
    for orbit in range(orbits):
        states = system.march(state, orbit * STEPS_AN_ORBIT, h, STEPS_AN_ORBIT, 1)
        jacobis(system.moments, states, points, 1, energy[orbit])
        moved(system.moments, times, states, sums)
    early, late = (energy / energy[0, 0] - 1.0).reshape(2, -1)
    x = (np.arange(len(early)) + 0.5) / len(early)
    bell = np.exp(-1.0 / (x * (1.0 - x)))
    return bell @ (late - early) / np.sum(bell) / (0.5 * orbits), sums


# DOP853 -------------------------------------------------------------------------------------------


def dop853(quick, output):
    from scipy.integrate import solve_ivp

    moments, rotations = BODY.moments, 100
    spin = Spin(epoch="2026-01-01", wxyz=START, angular_velocity=RATES)
    span = rotations * TURN / math.hypot(*RATES)

    def slope(t, y):
        a, b, c, d, x, v, z = y
        size = a * a + b * b + c * c + d * d
        p, r = math.cos(t), math.sin(t)
        u = (
            ((a * a + b * b - c * c - d * d) * p + 2 * (b * c + a * d) * r) / size,
            (2 * (b * c - a * d) * p + (a * a - b * b + c * c - d * d) * r) / size,
            (2 * (b * d + a * c) * p + 2 * (c * d - a * b) * r) / size,
        )
        return (
            0.5 * (-b * x - c * v - d * z),
            0.5 * (a * x + c * z - d * v),
            0.5 * (a * v + d * x - b * z),
            0.5 * (a * z + b * v - c * x),
            (moments[1] - moments[2]) / moments[0] * (v * z - 3.0 * u[1] * u[2]),
            (moments[2] - moments[0]) / moments[1] * (z * x - 3.0 * u[2] * u[0]),
            (moments[0] - moments[1]) / moments[2] * (x * v - 3.0 * u[0] * u[1]),
        )

    start = np.concatenate([spin.wxyz, spin.angular_velocity])
    solved = solve_ivp(slope, (0.0, span), start, method="DOP853", rtol=1e-13, atol=1e-15)
    end = solved.y[:4, -1] / np.sqrt(np.sum(solved.y[:4, -1] ** 2))
    print(f"{rotations} rotations under gravity gradient: difference from DOP853 at 1e-13, rad")
    counts = (20, 40, 80) if quick else (20, 40, 80, 160, 320, 640)
    print(f"{'steps a rotation':>22s}" + "".join(f"{n:>9d}" for n in counts))
    for name in SCHEMES:
        row = []
        for n in counts:
            motion = TorquedRotation(
                BODY, spin, GravityGradient(circular, 1.0), step=span / rotations / n, scheme=name
            )
            row.append(rotation_error(motion.at(span).wxyz, end, signed=True))
        print(f"{name:>22s}" + "".join(f"{e:9.1e}" for e in row))


# Referee ------------------------------------------------------------------------------------------


def referee(quick, output):
    names = ["dlm", "reich", "celledoni-safstrom", "buss", "rk4", "exact-step", "DOP853"]
    spin = Spin(epoch="2026-01-01", wxyz=START, angular_velocity=(2, 1, 5))
    steps = (0.04, 0.02, 0.01) if quick else (0.08, 0.04, 0.02, 0.01, 0.005, 0.0025, 0.00125)
    tolerances = (1e-9,) if quick else (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
    span = 10.0 if quick else 100.0
    result = compare(names, BODY, spin, span, steps=steps, tolerances=tolerances)
    print(result)
    for name, measured in result.orders().items():
        print(f"  order of {name}: {', '.join(f'{order:.1f}' for order in measured)}")
    if output:
        figure, axes = new_figure()
        for name in names:
            runs = result.of(name)
            axes.loglog(
                [run.seconds * 1e3 for run in runs],
                [run.attitude_error for run in runs],
                "o-",
                label=name,
                ms=4,
            )
        axes.set(
            xlabel="cost (ms)",
            ylabel="largest attitude error (rad)",
            title=f"Integrators of the free rotation against the exact one, {span:g} s",
        )
        save(figure, axes, output, "referee.png")


# Impulses -----------------------------------------------------------------------------------------


def impulses(quick, output):
    random = np.random.default_rng(2006)
    count = 1000
    epochs = np.cumsum(random.uniform(0.05, 0.2, count))
    momenta = random.normal(size=(count, 3)) * 0.3
    changes = [
        Impulse(float(t), momentum, ("icrf", "body")[k % 2])
        for k, (t, momentum) in enumerate(zip(epochs, momenta, strict=True))
    ]
    Arcs(BODY, SPIN, changes[:2]).at([0.0, 1.0])
    build = best(lambda: Arcs(BODY, SPIN, changes), 3)
    motion = Arcs(BODY, SPIN, changes)
    t = random.uniform(0.0, epochs[-1], 100_000)
    few = t[:1000].tolist()
    print(f"{count} impulses, constructed in {build * 1e3:.0f} ms; a random epoch costs")
    costs, shown = {"construction": build * 1e6}, []
    for call, times in (
        ("motion.wxyz_at(seconds), one by one", best(lambda: one_by_one(motion.wxyz_at, few), 20)),
        ("motion.at(seconds), one by one", best(lambda: one_by_one(motion.at, few), 20)),
    ):
        print(f"  {times / len(few) * 1e6:6.2f} us  {call}")
        costs[call] = times / len(few) * 1e9
        shown.append((f"a random epoch, `{call[:-12]}`", f"{costs[call] / 1e3:.1f} µs"))
    for what, epochs_of in (("in any order", t), ("in order", np.sort(t))):
        seconds = best(lambda some=epochs_of: motion.at(some), 10) / len(t)
        print(f"  {seconds * 1e6:6.2f} us  among {len(t)} {what}, in one motion.at(seconds)")
        costs[what] = seconds * 1e9
        shown.append((f"among 1e5 epochs {what} in one call", f"{seconds * 1e6:.2g} µs"))
    shown.append(("constructing the motion", f"{build:.2g} s"))
    checked = 100 if quick else count
    worst = 0.0
    with mp.workprec(250):
        moments = [mpf(float(x)) for x in BODY.moments]
        q = [mpf(float(x)) for x in SPIN.wxyz]
        w = [mpf(float(x)) for x in SPIN.angular_velocity]
        last = mpf(0)
        for change in changes[:checked]:
            oracle = Oracle(moments, q, w, digits=50)
            middle = float((last + mpf(change.at)) / 2)
            exact = oracle.at(mpf(middle) - last)[0]
            worst = max(worst, rotation_error(motion.wxyz_at(middle), exact, signed=True))
            q, w = oracle.at(mpf(change.at) - last)
            added = [mpf(float(x)) for x in change.angular_momentum]
            if change.frame == "icrf":
                added = multiply(multiply(conjugate(q), [mpf(0), *added]), q)[1:]
            w = [a + b / i for a, b, i in zip(w, added, moments, strict=True)]
            last = mpf(change.at)
    print(f"  worst error on {checked} arcs against a chain of 50-digit oracles: {worst:.1e} rad")
    shown.append(
        (f"worst error of {checked} against a chain of 50-digit oracles", f"{worst:.0e} rad")
    )
    return costs, shown


# Tolerances ---------------------------------------------------------------------------------------


@numba.njit
def periodic(t, q, w):
    return 1e-3 * math.sin(0.1 * t), 1e-3 * math.cos(0.07 * t), 0.0


def tolerance(quick, output):
    print("an adaptive step with its error estimate, us of the processor (the best of some runs)")
    spin = Spin(epoch=SPIN.epoch, wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 0.5, 0.1))
    torques = {
        "constant": ConstantTorque((1e-3, 2e-3, 0.0)),
        "compiled function": CustomTorque(periodic, depends_on_rate=False),
        "damping": LinearDamping(1e-4),
    }
    for name, limit in (
        ("kick-rotate-kick", 1e-9),
        ("hoa", 1e-9),
        ("force-gradient", 1e-12),
        ("suzuki", 1e-12),
        ("blanes-moan", 1e-12),
    ):
        shown = []
        for key, torque in torques.items():
            if name == "force-gradient" and key != "constant":
                continue
            found = []
            for _ in range(5 if quick else 30):
                motion = TorquedRotation(BODY, spin, torque, scheme=name, step_tolerance=limit)
                motion.at(0.1)
                found.append(step_cost(motion._grids[0]))
            shown.append(f"{key} {min(found):.2f}")
        print(f"  {name:20s} {', '.join(shown)}")
    shown = []
    for key, torque in torques.items():
        found = []
        for _ in range(5 if quick else 30):
            motion = TorquedRotation(BODY, spin, torque, tolerance=1e-7)
            motion.at(0.1)
            found.append(step_cost(motion._grids[0]._steps))
        shown.append(f"{key} {min(found):.2f}")
    print(f"  blanes-moan and the motion beside it (tolerance=): {', '.join(shown)}")
    print("error and estimate, rad, of 50 motions; their ratio, and that of estimate and tolerance")
    ratios = []
    for number in range(torque_cases.COUNT):
        case = torque_cases.case(number)
        motion = case.motion(tolerance=case.tolerance)
        finer = case.motion(tolerance=max(0.01 * case.tolerance, 1e-13), scheme="suzuki")
        found, exact = motion.at(case.seconds).wxyz, finer.at(case.seconds).wxyz
        error, estimate = torque_cases.angle(found, exact), motion.error_estimate
        ratios.append((error / estimate, estimate / case.tolerance))
        print(
            f"  {number:2d} {case.kind:10s} {error:.1e} {estimate:.1e}   {ratios[-1][0]:.3f}   "
            f"{ratios[-1][1]:.3f}"
        )
    least, most = np.min(ratios, axis=0), np.max(ratios, axis=0)
    held = sum(one <= 1.0 and two <= 1.0 for one, two in ratios)
    print(
        f"  held on {held} of {len(ratios)}: error over estimate {least[0]:.3f} to {most[0]:.3f}, "
        f"estimate over tolerance up to {most[1]:.3f}"
    )


def step_cost(grid):
    """us of the processor for a step of a motion of 20,000 s."""
    begin, before = time.thread_time(), grid.steps
    grid.extend(20000.0)
    return (time.thread_time() - begin) / (grid.steps - before) * 1e6


def one_by_one(call, epochs):
    for t in epochs:
        call(t)


def new_figure():
    from attitude import plots

    figure = plots.new_figure((8.0, 5.0))
    return figure, figure.add_subplot()


def save(figure, axes, output, name):
    axes.grid(alpha=0.3)
    axes.legend(fontsize=9, loc="best")
    figure.savefig(output / name, dpi=110)
    print(f"  drawn: {output / name}")


PARTS = {
    "cost": cost,
    "orders": orders,
    "circular": circular_orbit,
    "drift": drift,
    "dop853": dop853,
    "referee": referee,
    "impulses": impulses,
    "tolerance": tolerance,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="part", help=", ".join(PARTS))
    parser.add_argument("--quick", action="store_true", help="less of everything")
    parser.add_argument("--output", help="a folder for the figures")
    given = parser.parse_args()
    unknown = [part for part in given.parts if part not in PARTS]
    if unknown:
        parser.error(f"no part {unknown[0]!r}; there are {', '.join(PARTS)}")
    output = writable_folder(given.output) if given.output else None
    print(processor())
    for part in given.parts or PARTS:
        print(f"\n{part}")
        PARTS[part](given.quick, output)


if __name__ == "__main__":
    with compiling():
        main()
