"""What does an attitude cost?

    python benchmarks/speed.py

Processor times are the least of many repetitions; ratios to numpy.sin are measured in the same run,
so that they are comparable between machines.  Start-up is measured in new processes.
"""

import os
import platform
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import Body, FreeRotation, Spin, propagate
from attitude._compilation.choice import compiling
from benchmarks.doc_tables import Table, printed
from benchmarks.record import processor

MOMENTS = np.array([10.0, 20.0, 26.0])
WXYZ = np.array([1.0, 0.0, 0.0, 0.0])
_PROPAGATE = "attitude.propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), {})"
_FIRST, _LARGE = (_PROPAGATE.format(each) for each in ("[0.0, 1.0]", "numpy.arange(2e5)"))
# What a new process does before, and what is measured; whether it begins without machine code.
STARTS = {
    "import numpy": ("pass", "import numpy", False),
    "import attitude": ("import numpy", "import attitude", False),
    "attitude.FreeRotation": ("import numpy, attitude", "attitude.FreeRotation", False),
    "first two attitudes, uncompiled": ("import numpy, attitude", _FIRST, False),
    "first 2e5 attitudes, cold disk cache": ("import numpy, attitude", _LARGE, True),
    "first 2e5 attitudes, warm disk cache": ("import numpy, attitude", _LARGE, False),
}
CASES = {
    "the paper's example": np.array([1.0, 15.0, 1.0]),
    "long-axis mode": np.array([9.0, 2.0, 1.0]),
    "1e-7 from the separatrix": np.array([0.003, 15.0, 0.003]),
    "a principal axis": np.array([0.0, 0.0, 15.0]),
}


MAKES = ("speed", "start-up", "cost of an epoch", "cost of a body")


def tables(quick):
    """The tables of README and docs/accuracy.md, without the call of 2 10^7 epochs."""
    found = {}

    def parts():
        versions()
        for part in (long_arrays, bodies, single, dates):
            found.update(part())

    text = printed(parts)
    yield Table("speed", text, costs=found)
    # Starts of a process vary with the disk: they are in the text alone.
    yield Table("start-up", printed(start_up))
    epoch, sine = found["into a given array"], found["numpy.sin into a given array"]
    yield Table("cost of an epoch", f"{epoch:.1f} ns = {epoch / sine:.2f} × `numpy.sin`")
    yield Table("cost of a body", f"{found['a body'] / 1e3:.2f} µs a body")


def main():
    versions()
    long_arrays()
    long_calls()
    bodies()
    single()
    dates()
    start_up()


def versions():
    packages = ("numpy", "scipy", "numba", "llvmlite", "astropy", "skyfield")
    print(f"{processor()}, Python {platform.python_version()}, ", end="")
    print(", ".join(f"{name} {version(name)}" for name in packages), "\n")


def long_arrays():
    t = np.linspace(0.0, 1e4, 10**6)
    memory, rates = np.empty((4, t.size)).T, np.empty((3, t.size)).T
    sine_out, found = np.empty_like(t), {}
    print("10^6 epochs of one body, one thread        ns an epoch    x numpy.sin   with rates")
    for name, omega in CASES.items():
        sine = best(lambda: np.sin(t))
        plain = best(lambda omega=omega: propagate(MOMENTS, WXYZ, omega, t))
        both = best(lambda omega=omega: propagate(MOMENTS, WXYZ, omega, t, angular_velocity=True))
        print(f"  {name:<40} {plain * 1e3:8.2f} {plain / sine:14.2f} {both / sine:13.2f}")
        found[name], found[name + ", with rates"] = plain * 1e3, both * 1e3
    omega = CASES["the paper's example"]
    sine = best(lambda: np.sin(t, out=sine_out))
    plain = best(lambda: propagate(MOMENTS, WXYZ, omega, t, out=memory))
    both = best(
        lambda: propagate(
            MOMENTS, WXYZ, omega, t, angular_velocity=True, out=memory, rates_out=rates
        )
    )
    print(f"  {'the same into a given array':<40} {plain * 1e3:8.2f} {plain / sine:14.2f}"
          f" {both / sine:13.2f}")  # fmt: skip
    found["into a given array"] = plain * 1e3
    found["numpy.sin into a given array"] = sine * 1e3
    found["numpy.sin"] = best(lambda: np.sin(t)) * 1e3
    print(f"  {'numpy.sin':<40} {found['numpy.sin']:8.2f}\n")
    return found


def long_calls():
    """What the first write to new memory adds to a call whose result exceeds the caches."""
    count, block = 2 * 10**7, 10**6
    omega, t = CASES["the paper's example"], np.linspace(0.0, 1e4, 2 * 10**7)
    motion = FreeRotation(Body(moments=MOMENTS), Spin("2026-01-01", WXYZ, omega))
    used = np.zeros((4, count)).T

    def in_blocks():
        for first in range(0, count, block):
            propagate(MOMENTS, WXYZ, omega, t[first : first + block])

    print("2 10^7 epochs of one body                  ns an epoch")
    for name, call in {
        "motion.at": lambda: motion.at(t),
        "propagate": lambda: propagate(MOMENTS, WXYZ, omega, t),
        "the same into memory used before": lambda: propagate(MOMENTS, WXYZ, omega, t, out=used),
        "the same in 20 calls, results dropped": in_blocks,
        "zeros into as much new memory": lambda: np.empty((4, count)).fill(0.0),
    }.items():
        print(f"  {name:<40} {best(call, 5) / count * 1e9:8.2f}")
    print()


def bodies():
    random = np.random.default_rng(1)
    count = 10**5
    moments = random.uniform(1.0, 1.9, (count, 3))
    wxyz, omega = random.normal(size=(count, 4)), random.normal(size=(count, 3))
    t = random.uniform(0.0, 1e3, (count, 1))
    cost = best(lambda: propagate(moments, wxyz, omega, t), 10) / count
    print(f"10^5 bodies, one epoch each                {cost * 1e6:8.2f} us a body\n")
    return {"a body": cost * 1e9}


def single():
    omega = CASES["the paper's example"]
    body = Body(moments=MOMENTS)
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=omega)
    motion, found = FreeRotation(body, spin), {}
    for name, call in {
        "propagate, one epoch": lambda: propagate(MOMENTS, WXYZ, omega, 60.0),
        "motion.at, one epoch": lambda: motion.at(60.0),
        "constructing a FreeRotation": lambda: FreeRotation(body, spin),
    }.items():
        found[name] = best(call, 20, 500) * 1e9
        print(f"{name:<40}   {found[name] / 1e3:8.2f} us")
    print()
    return found


def dates():
    from astropy import units
    from astropy.time import Time

    count = 10**5
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=(1e-4, 2e-3, 1e-4))
    motion, found = FreeRotation(Body(moments=MOMENTS), spin), {}
    for name, days in (("a day", 1.0), ("a year", 365.0)):
        t = Time("2026-01-01T00:00:00") + np.linspace(0.0, days, count) * units.day
        cost = best(lambda t=t: motion.at(t), 10) / count
        found[f"a UTC epoch over {name}"] = cost * 1e9
        history = motion.at(t)
        # In two parts, since one double of seconds resolves 4e-9 s after a year.
        days, start = t.tdb, motion.spin.epoch.time
        whole, rest = days.jd1 - start.jd1, days.jd2 - start.jd2
        error = np.max(np.abs(history.seconds - whole * 86400.0 + history.low - rest * 86400.0))
        print(
            f"10^5 UTC epochs over {name:<19}   {cost * 1e6:8.2f} us an epoch, "
            f"{error:.0e} s from astropy's TDB"
        )
    print()
    return found


def start_up():
    """Processor time within new processes, the least of seven; of three without machine code."""
    print(f"{processor()}, Python {platform.python_version()}: s of processor, in a new process")
    with tempfile.TemporaryDirectory() as cache:
        process("import numpy, attitude", _LARGE, cache, 1)
        for name, (before, statement, is_cold) in STARTS.items():
            if is_cold:
                seconds = []
                for _ in range(3):
                    with tempfile.TemporaryDirectory() as empty:
                        seconds.append(process(before, statement, empty, 1))
                least = min(seconds)
            else:
                least = process(before, statement, cache)
            print(f"{name:<43} {least:7.4f} s")


def process(before, statement, cache, repetitions=7):
    """Least processor time of a statement in a new process, s."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache, "ATTITUDE_COMPILE": "automatic"}
    code = (
        f"import time; {before}; start = time.process_time(); {statement}; "
        "print(time.process_time() - start)"
    )
    command = [sys.executable, "-c", code]
    return min(
        float(subprocess.run(command, env=environment, check=True, stdout=-1).stdout)
        for _ in range(repetitions)
    )


def best(call, repetitions=30, loop=1):
    """Least processor time of a call, s."""
    call()
    least = np.inf
    for _ in range(repetitions):
        start = time.thread_time()
        for _ in range(loop):
            call()
        least = min(least, (time.thread_time() - start) / loop)
    return least


if __name__ == "__main__":
    with compiling():
        main()
