"""What do ensembles cost?

    python benchmarks/ensembles.py              all but the main belt
    python benchmarks/ensembles.py main-belt [N]  5e6 (or N) members x 220 visits, two threads

Times are of the processor (of one thread), the least of some repetitions, but for threads; beside
them stands what numpy.sin takes in the same run, by which machines are compared.
"""

import hashlib
import os
import resource
import sys
import threading
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import Body, Ensemble, FreeRotation, Impulse, Spin, propagate
from attitude._compilation.choice import compiling
from attitude.ensemble import AngleTo
from attitude.torques import LinearDamping
from benchmarks.doc_tables import Table, markdown

EPOCH = "2026-01-01"
VISITS = 160
RNG = np.random.default_rng(17)
MAKES = ("ensembles", "two threads")


def tables(quick):
    """The tables of docs/ensembles.md and docs/scale.md."""
    found = rows(10**4 if quick else 10**5) | grid() | monte_carlo() | detumbling()
    shown = {
        "construction and check of a member": ("construction", "µs", 1e3),
        "constants of a member, and an attitude": ("one epoch each", "µs", 1e3),
        "attitudes of a member at 160 own epochs, sorted rows": ("sorted", "µs", 1e3),
        "the same into new memory": ("new memory", "µs", 1e3),
        "the same, rows in random order": ("random order", "µs", 1e3),
        "nine derivatives of a member at 160 own epochs": ("derivatives", "µs", 1e3),
        "brightness of an ellipsoid at 160 own epochs": ("brightness", "µs", 1e3),
        "an attitude of 1e4 members at 2000 shared epochs": ("shared", "ns", 1.0),
        "percentiles of 1e4 states at 720 epochs": ("percentiles", "s", 1e9),
        "a step of a member under damping": ("step", "µs", 1e3),
        "an impulse of a member": ("impulse", "µs", 1e3),
    }
    cells = [(text, f"{found[key] / unit:.2g} {name}") for text, (key, name, unit) in shown.items()]
    yield Table("ensembles", markdown(("what", "time"), cells), costs=found)
    if not quick:
        found = threads()
        cells = [(name, f"{ratio:.2f}") for name, ratio in found.items()]
        text = markdown(("work", "one thread over two, wall clock"), cells)
        yield Table("two threads", text, ratios=found)


def main():
    load = os.getloadavg()[0]
    print(f"{os.cpu_count()} processors, numpy {np.__version__}, load {load:.1f}")
    x = np.linspace(0.0, 1e4, 10**6)
    out = np.empty_like(x)
    sine = best(lambda: np.sin(x, out=out)) * 1e3
    t = np.linspace(0.0, 1e4, 10**6)
    one = best(lambda: propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), t)) * 1e3
    print(f"numpy.sin {sine:.2f} ns, propagate {one:.2f} ns an epoch (0.8 of numpy.sin at best)\n")
    rows(10**5)
    grid()
    monte_carlo()
    detumbling()
    threads()


def states(count, seed=1):
    """Moments, attitudes and rates of bodies in both modes, some days a turn."""
    rng = np.random.default_rng(seed)
    moments = np.sort(rng.uniform(0.4, 1.0, (count, 3)))
    moments[:, 2] = np.minimum(moments[:, 2], 0.99 * (moments[:, 0] + moments[:, 1]))
    wxyz = rng.normal(size=(count, 4))
    wxyz /= np.linalg.norm(wxyz, axis=1)[:, None]
    return moments, wxyz, rng.normal(size=(count, 3)) * 1e-4


def ensemble(count, seed=1):
    moments, wxyz, omega = states(count, seed)
    return Ensemble(moments=moments, wxyz=wxyz, angular_velocity=omega, epoch=EPOCH, relative=True)


def visits(count, number=VISITS, seed=2):
    """Members, epochs over ten years, and vectors to Sun and observer of sorted ragged rows."""
    rng = np.random.default_rng(seed)
    member = np.repeat(np.arange(count), number)
    sun, observer = rng.normal(size=(2, member.size, 3))
    return member, rng.uniform(0.0, 3.2e8, member.size), sun, observer


def rows(count):
    """1e5 members are a tenth of the survey; the cost is linear from 1e4 on.  ns by name."""
    make = lambda: ensemble(count)  # noqa: E731
    made = make()
    member, t, sun, observer = visits(count)
    axes = RNG.uniform(0.5, 1.0, (count, 3))
    few = slice(0, VISITS)
    made.at(t[few], member[few])
    made.brightness(t[few], member[few], sun[few], observer[few], shape=axes)
    memory, numbers = np.zeros((4, member.size)).T, np.zeros(member.size)
    print(f"{count} members x {VISITS} visits            us a member   allowed")
    each = {"construction": best(make, 3) / count * 1e6}
    line("construction", each["construction"], None)
    one = best(lambda: made.at(t[:count], member[::VISITS])) / count * 1e6
    line("one epoch each", one, None)
    found = best(lambda: made.at(t, member, out=memory), 3) / count * 1e6
    each |= {"one epoch each": one, "sorted": found}
    line("attitudes, sorted rows", found, 1.3 + 0.012 * VISITS)
    new = best(lambda: made.at(t, member), 2) / count * 1e6
    line("  the same into new memory", new, None)
    order = RNG.permutation(member.size)
    mixed, later = member[order], t[order]
    each |= {"new memory": new, "random order": best(lambda: made.at(later, mixed), 1)}
    each["random order"] *= 1e6 / count
    line("  rows in random order", each["random order"], None)
    light = lambda: made.brightness(  # noqa: E731
        t, member, sun, observer, shape=axes, out=numbers
    )
    few, some = slice(0, 1000 * VISITS), np.zeros((1000 * VISITS, 3, 9))
    changes = lambda: made.sensitivity_at(t[few], member[few], out=some)  # noqa: E731
    each["derivatives"] = best(changes, 3) / 1e3 * 1e6
    line("nine derivatives, sorted rows", each["derivatives"], None)
    found = best(light, 3) / count * 1e6
    line("brightness of ellipsoids", found, 1.6 + 0.025 * VISITS)
    line("  1e6 x 160, in s", found, 6.0)
    print()
    each["brightness"] = found
    return {name: 1e3 * cost for name, cost in each.items()}


def line(name, value, allowed):
    print(f"  {name:<36} {value:12.3f}" + (f" {allowed:12.3f}" if allowed else ""))


def grid():
    made = ensemble(10**4)
    t = np.linspace(0.0, 1e7, 2000)
    made.at(t[:3])
    memory = np.moveaxis(np.zeros((10**4, 4, 2000)), 1, 2)
    found = best(lambda: made.at(t, out=memory), 2) / (10**4 * 2000) * 1e9
    print(f"1e4 members x 2000 shared epochs: {found:.2f} ns an attitude (10 allowed)")
    return {"shared": found}


def monte_carlo():
    spin = Spin(EPOCH, (1, 0, 0, 0), (0.01, 0.03, 0.02))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    sigma = {"attitude": 0.2, "angular_velocity": 0.005, "moments": 0.1}
    draws = Ensemble.sample(motion, 10**4, covariance=sigma)
    t, angle = np.linspace(0.0, 7200.0, 720), AngleTo((0, 0, 1), (1, 0, 0))
    draws[:300].percentiles(angle, t)
    found = best(lambda: draws.percentiles(angle, t), 3)
    print(f"percentiles of 1e4 states x 720 epochs: {found:.3f} s (0.3 allowed)")
    return {"percentiles": found * 1e9}


def detumbling():
    spin = Spin(EPOCH, (1, 0, 0, 0), (0.01, 0.03, 0.02))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    draws = Ensemble.sample(motion, 1000, covariance={"angular_velocity": 0.005})
    torqued, t = draws.torqued(LinearDamping(0.02), step=2.0), np.linspace(0.0, 3600.0, 37)
    torqued.at(t[:2])
    found = best(lambda: torqued.at(t), 2) / (1000 * 1800) * 1e6
    print(
        f"detumbling: {found:.2f} us a step of a member; 1e4 states, 1800 steps: {18 * found:.0f} s"
    )
    step = found * 1e3
    kicks = [Impulse(at=60.0 * k, angular_momentum=(0.1, 0, 0)) for k in range(1, 11)]
    draws[:2].arcs(kicks).at(t)
    found = best(lambda: draws.arcs(kicks), 2) / 1e4 * 1e6
    print(f"ten impulses: {found:.0f} us a member and impulse")
    return {"step": step, "impulse": found * 1e3}


def threads():
    """Two threads of the same work against one: rows with light, numpy, and sha256."""
    made = ensemble(20_000)
    member, t, sun, observer = visits(20_000)
    numbers, x = np.zeros(member.size), np.linspace(0.0, 1e4, 4 * 10**5)
    text, parts = bytes(10**8), [np.empty_like(x), np.empty_like(x)]

    def light(count):
        made.brightness(t, member, sun, observer, shape=(3.0, 2.0, 1.0), out=numbers, threads=count)

    def attitudes(count):
        for _, part in made.blocks(t, member, rows=1 << 20, threads=count):
            del part

    def twice(work):
        """Twice the work, by one thread or by two."""

        def run(count):
            running = [threading.Thread(target=work, args=(k,)) for k in range(2)]
            if count == 1:
                work(0), work(1)
                return
            for each in running:
                each.start()
            for each in running:
                each.join()

        return run

    light(1), attitudes(1)
    print("\ntwo threads against one, of the wall clock")
    ratios = {}
    for name, work in {
        "brightness of rows": light,
        "attitudes of rows": attitudes,
        "numpy.sin": twice(lambda k: [np.sin(x, out=parts[k]) for _ in range(10)]),
        "sha256": twice(lambda k: hashlib.sha256(text).digest()),
    }.items():
        # In turn, and the least of many: what else runs on the machine slows both.
        rounds = [[wall(work, count) for count in (1, 2)] for _ in range(40)]
        one, two = (min(each) for each in zip(*rounds, strict=True))
        print(f"  {name:<36} {one / two:12.2f}")
        ratios[name] = one / two
    return ratios


def wall(work, *arguments):
    start = time.perf_counter()
    work(*arguments)
    return time.perf_counter() - start


def main_belt(count=5 * 10**6, number=220, block=1 << 15):
    """All members of the main belt that Rubin sees: states and light in blocks of members."""
    axes, spent, busy, total = np.array([(1.0, 0.7, 0.5)]), 0.0, 0.0, 0.0
    numbers = np.zeros(block * number)
    member, t, sun, observer = visits(block, number)
    ensemble(100).brightness(t[:9], member[:9], sun[:9], observer[:9], shape=axes)
    for first in range(0, count, block):
        size = min(block, count - first)
        given, few = states(size, first), slice(0, size * number)
        start, clock = time.perf_counter(), time.process_time()
        made = Ensemble(
            moments=given[0], wxyz=given[1], angular_velocity=given[2], epoch=EPOCH, relative=True
        )
        found = made.reduced_magnitude(
            t[few], member[few], sun[few], observer[few], shape=axes, threads=2, out=numbers[few]
        )
        total += float(found.mean())
        spent, busy = spent + time.perf_counter() - start, busy + time.process_time() - clock
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"{count} members x {number} visits, two threads: {spent:.1f} s (60 allowed) besides "
        f"making the input, half of the processor time {busy / 2:.1f} s, at most {peak:.2f} GiB "
        f"(2 allowed), mean magnitude {total / -(-count // block):.4f}; "
        f"load {os.getloadavg()[0]:.1f}"
    )


def best(call, repeats=5):
    """The least processor time, s."""
    found = []
    for _ in range(repeats):
        start = time.process_time()
        call()
        found.append(time.process_time() - start)
    return min(found)


if __name__ == "__main__":
    with compiling():
        main_belt(*map(int, sys.argv[2:3])) if sys.argv[1:2] == ["main-belt"] else main()
