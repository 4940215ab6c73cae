"""What the first results cost: in fresh processes, with an empty and with a filled cache.

    python benchmarks/first_use.py [--quick] [--calls [NAME]]

Each time is the least of three processes (features that compile for seconds: one), in CPU seconds,
with the ratio to one that only imports numpy.  Empty: the folder of machine code is new for each
process.  Compiled: the same with ATTITUDE_COMPILE=always and an empty folder; features that have no
such number compile in any case, or nothing.

--calls: how a call becomes fast that a process repeats.  For each public entry point, in a process
of its own with an empty folder of machine code: CPU time of calls 1, 10, 100 and 1000, the longest
pause (a call that compiles) and its number, and the seconds that ran in Python in all.  A row ends
after `CALLS_BUDGET` s of calls that compile nothing.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.doc_tables import Table, markdown

MAKES = ("first use", "repeated calls")
MOTION = """
import numpy as np
from attitude import Body, FreeRotation, Spin
body = Body(moments=(10, 20, 26))
spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
motion = FreeRotation(body, spin)
"""
PROPAGATE = [
    *("-m", "attitude", "propagate", "data/spin/toutatis.toml", "--start", "1992-12-02"),
    *("--stop", "1992-12-19", "--step", "1 d", "--output"),
]
ENVISAT = [
    *("-m", "attitude", "lightcurve", "data/mission/envisat-glints.toml"),
    *("--start", "2013-10-23T19:18:00", "--stop", "2013-10-23T19:21:00", "--step", "1 s"),
]
CURVE = "data/light_curve/toutatis-1992-photometry.csv"
PERIODS = "--min", "1 d", "--max", "40 d"
INVERT = "--max-frequency", "0.75 /d", "--budget", "2 s"
BASE = "import numpy"
SMALL = {
    BASE: "import numpy",
    "imports of the next line": "from attitude import Body, FreeRotation, Spin",
    "one attitude of a FreeRotation": MOTION + "motion.at(60.0)",
    "`attitude describe toutatis`": ["-m", "attitude", "describe", "toutatis"],
    "`attitude propagate`, 18 epochs": PROPAGATE,
    "`attitude view toutatis`": ["-m", "attitude", "view", "toutatis", "--output"],
    "`attitude lightcurve`, Envisat, 181 epochs": ENVISAT,
    "`attitude periods`, 370 points": ["-m", "attitude", "periods", CURVE, *PERIODS],
    "`attitude invert`, a search of 2 s": ["-m", "attitude", "invert", CURVE, *INVERT],
    "passes over a site, two days": """
from attitude import Scene, events, paths
orbit = paths.kepler(
    epoch="2026-01-01", center="earth", semi_major_axis=7e6, eccentricity=0.01, inclination=1.0,
    node=0.1, pericenter_argument=0.2, mean_anomaly=0.3,
)
scene = Scene(None, orbit, observer=paths.site("10 deg", "45 deg"))
events.passes(scene, "2026-01-01", "2026-01-03")
""",
    "a covariance at eleven epochs": MOTION
    + """
FreeRotation(body, spin.with_covariance({"attitude": 0.1})).covariance_at(np.linspace(0, 100, 11))
""",
    "a fit to 101 attitudes": MOTION
    + """
from attitude import AttitudeTable, fit
t = np.linspace(0, 10, 101)
found = fit(AttitudeTable("2026-01-01", t, motion.at(t).wxyz))
assert found.rms < 1e-9
""",
    "an ensemble of 100 members": MOTION
    + """
from attitude.ensemble import Ensemble
Ensemble.of([motion] * 100).at(np.linspace(0, 100, 11))
""",
}
LARGE = {
    "2e5 attitudes": MOTION + "motion.at(np.arange(2e5))",
    "a scene with an ellipsoid, ten magnitudes": MOTION
    + """
from attitude import Scene, shape
scene = Scene(motion, "mars barycenter", shape=shape.Ellipsoid((3, 2, 1)))
scene.at(np.linspace(0.0, 6e3, 10)).magnitude
""",
    "a chain with one impulse": MOTION
    + """
from attitude.arcs import Arcs, Impulse
Arcs(body, spin, [Impulse(at=5.0, angular_momentum=(0.1, 0.2, 0.3))]).at(np.linspace(0, 50, 23))
""",
    "a torque": MOTION
    + """
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque
TorquedRotation(body, spin, ConstantTorque((0.01, 0, 0)), step=0.01).at(np.linspace(0.0, 3.0, 7))
""",
    "a search for events": MOTION
    + """
from attitude.events import find_discrete, illuminated
find_discrete(0.0, 100.0, illuminated(motion, (0, 0, 1), sun=(1, 0, 1)))
""",
    "a mesh with shadows, ten magnitudes": MOTION
    + """
from attitude import Scene, shape
scene = Scene(motion, "mars barycenter", shape=shape.box_wing((10, 4, 4), (14, 5), wings=1))
scene.at(np.linspace(0.0, 6e3, 10)).magnitude
""",
}
# What has seconds of its own: a search for spin states, and a page with all epochs.
APART = "`attitude invert`, a search of 2 s", "`attitude view toutatis`"
# Set-up and call of public entry points, small calls that a script would repeat.
SCENE = """
from attitude import Scene, shape
scene = Scene(motion, "mars barycenter", shape=shape.Ellipsoid((3, 2, 1)))
"""
ORBIT = """
from attitude import Scene, events, paths
orbit = paths.kepler(
    epoch="2026-01-01", center="earth", semi_major_axis=7e6, eccentricity=0.01, inclination=1.0,
    node=0.1, pericenter_argument=0.2, mean_anomaly=0.3,
)
scene = Scene(None, orbit, observer=paths.site("10 deg", "45 deg"))
"""
TABLE = """
from attitude import AttitudeTable, fit, fit_directions, fit_rates
t = np.linspace(0, 10, 101)
history = motion.at(t)
table = AttitudeTable("2026-01-01", t, history.wxyz)
stars = np.resize([[1.0, 0, 0], [0, 1.0, 0]], (101, 3))
seen = history.inertial_to_body(stars)
"""
CURVE_OF_TWO = """
from attitude import photometry
from attitude.photometry import fit_series as series
t = np.sort(np.random.default_rng(1).uniform(0.0, 4e5, 200))
y = 15.0 + 0.2 * np.cos(2e-4 * t) + 0.1 * np.cos(3.3e-4 * t)
"""
COVARIANT = "motion = FreeRotation(body, spin.with_covariance({'attitude': 0.1}))\n"
MESH = """
from attitude import shape
from attitude.light_curve import brightness
from attitude.scattering import Lambert
mesh = shape.box_wing((10, 4, 4), (14, 5), wings=1)
turns = np.random.default_rng(0).normal(size=(100, 3))
turns /= np.linalg.norm(turns, axis=1)[:, None]
"""
CALLS = {
    "`propagate`, 1000 epochs": ("", "propagate(MOMENTS, WXYZ, RATES, T)"),
    "`propagate`, sensitivity, 1000 epochs": (
        "",
        "propagate(MOMENTS, WXYZ, RATES, T, sensitivity=True)",
    ),
    "`propagate`, 100 bodies, 11 epochs": (
        "bodies = np.array(RATES) * np.linspace(1, 2, 100)[:, None]\n",
        "propagate(MOMENTS, WXYZ, bodies, T[:11])",
    ),
    "`Body`, `Spin`, `FreeRotation`, one epoch": (
        "",
        "FreeRotation(Body(moments=MOMENTS), Spin(EPOCH, WXYZ, RATES)).at(60.0).wxyz",
    ),
    "`motion.at`, one epoch": ("", "motion.at(60.0).wxyz"),
    "`history.angular_velocity`, 1000 epochs": ("", "motion.at(T).angular_velocity"),
    "`motion.sensitivity_at`, 11 epochs": ("", "motion.sensitivity_at(T[:11])"),
    "`history.sigma`, 11 epochs": (COVARIANT, "motion.at(T[:11]).sigma"),
    "`history.covariance`, 1000 epochs": (COVARIANT, "motion.at(T).covariance"),
    "`history.nonlinearity`, 11 epochs": (COVARIANT, "motion.at(T[:11]).nonlinearity"),
    "`motion.regime`": ("", "FreeRotation(body, spin).regime.P_psi"),
    "`motion.published`": ("", "FreeRotation(body, spin).published('L')"),
    "`Spin.from_periods`": (
        "",
        "Spin.from_periods(Body(moments=(0.61, 0.965, 1.0), relative=True), mode='SAM', "
        "convention='S', P_psi='263 h', P_phi='27.38 h', pole=(1.0, 0.5), phi0=0.1, psi0=0.2, "
        "epoch=EPOCH)",
    ),
    "`Ensemble.at`, 100 members, 11 epochs": (
        "from attitude.ensemble import Ensemble\n",
        "Ensemble.of([motion] * 100).at(T[:11]).wxyz",
    ),
    "`Arcs.at`, one impulse, 23 epochs": (
        "from attitude.arcs import Arcs, Impulse\n",
        "Arcs(body, spin, [Impulse(at=5.0, angular_momentum=(0.1, 0.2, 0.3))]).at(T[:23]).wxyz",
    ),
    "`TorquedRotation.at`, 7 epochs": (
        "from attitude.splitting import TorquedRotation\n"
        "from attitude.torques import ConstantTorque\n",
        "TorquedRotation(body, spin, ConstantTorque((0.01, 0, 0)), step=0.01)"
        ".at(np.linspace(0.0, 3.0, 7)).wxyz",
    ),
    "`AttitudeTable.at`, 11 epochs": (TABLE, "table.at(t[:11] + 0.01).wxyz"),
    "`view.phase_angle`, 1000 epochs": (SCENE, "scene.at(T).phase_angle"),
    "`view.magnitude`, ellipsoid, ten epochs": (SCENE, "scene.at(T[:10]).magnitude"),
    "`view.magnitude_sigma`, ten epochs": (
        COVARIANT + SCENE,
        "scene.at(T[:10]).magnitude_sigma",
    ),
    "`light_curve.brightness`, mesh, 100 directions": (
        MESH,
        "brightness(mesh, Lambert(), turns, turns[::-1])",
    ),
    "`events.find_discrete`": (
        "from attitude.events import find_discrete, illuminated\n",
        "find_discrete(0.0, 100.0, illuminated(motion, (0, 0, 1), sun=(1, 0, 1)))",
    ),
    "`events.passes`, two days": (ORBIT, "events.passes(scene, '2026-01-01', '2026-01-03')"),
    "`fit`, 101 attitudes": (TABLE, "fit(table)"),
    "`fit_rates`, 101 rates": (
        TABLE,
        "fit_rates(history.time, history.angular_velocity, start=motion)",
    ),
    "`fit_directions`, 101 directions": (
        TABLE,
        "fit_directions(history.time, seen, stars, start=motion)",
    ),
    "`photometry.periods`, 200 points": (
        CURVE_OF_TWO,
        "photometry.periods(t, y, min_period=1e4, max_period=1e5)",
    ),
    "`photometry.fit_series`, two periods, 200 points": (
        CURVE_OF_TWO,
        "series(t, y, P_psi=31415.9, P_phi=19040.0)",
    ),
    "`jacobi.sn`, 100 numbers": (
        "from attitude import jacobi\n",
        "jacobi.sn(np.linspace(0, 3, 100), 0.5)",
    ),
}
CALLS_BUDGET = 4.0
COUNTED = 1, 10, 100, 1000
REPEATED = """
import json, sys
from time import process_time
from attitude import propagate, compilation_status
from attitude._compilation import decorators
EPOCH, MOMENTS, WXYZ, RATES = "2026-01-01", (10, 20, 26), (1, 0, 0, 0), (1, 15, 1)
T = np.linspace(0, 100, 1000)
{setup}
times, steady = [], 0.0
while len(times) < {most} and steady < {budget}:
    known = len(decorators.compiled_names())
    begin = process_time()
    {call}
    times.append(process_time() - begin)
    steady += times[-1] if len(decorators.compiled_names()) == known else 0.0
print(json.dumps([times, compilation_status().seconds_in_python]))
"""
ALL = "from attitude.cli import _warm_up as warm_up\nfor each in warm_up.features(True): each()"


def tables(quick):
    """The table of docs/compilation.md."""
    rounds, rows, ratios = (1, [], {}) if quick else (3, [], {})
    base = None
    for name, cells in measured(rounds, everything=not quick):
        base = base or cells[1]
        rows.append((name, *("" if each is None else f"{each:.2f}" for each in cells)))
        for kind, seconds in zip(("empty", "later", "compiled"), cells, strict=True):
            if seconds is not None and name != BASE:
                ratios[f"{name}, {kind}"] = seconds / base
    head = "CPU seconds of a process", "empty cache", "later", "compiled at once, empty cache"
    yield Table("first use", markdown(head, rows, right=(1, 2, 3)), ratios=ratios)
    if not quick:
        head = "ms of call", *map(str, COUNTED), "longest pause, s", "at call", "s in Python"
        rows = [(name, *_spelled(*repeated(name))) for name in CALLS]
        yield Table("repeated calls", markdown(head, rows, right=range(1, len(head))))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="one process each")
    parser.add_argument("--calls", nargs="?", const="", help="repeated calls, of names with NAME")
    given = parser.parse_args()
    if given.calls is not None:
        cells = *(f"call {k}, ms" for k in COUNTED), "pause, s", "at call", "Python, s"
        print(f"{'':<50}" + "".join(f"{each:>14}" for each in cells))
        for name in CALLS:
            if given.calls in name:
                cells = _spelled(*repeated(name))
                print(f"{name:<50}" + "".join(f"{each:>14}" for each in cells), flush=True)
        return
    rounds = 1 if given.quick else 3
    base = None
    print(f"{'CPU seconds (x import numpy)':<44}{'empty cache':>18}{'later':>18}{'compiled':>18}")
    for name, cells in measured(rounds, everything=True):
        base = base or cells[1]
        shown = ("" if each is None else f"{each:.2f} ({each / base:5.1f})" for each in cells)
        print(f"{name:<44}" + "".join(f"{each:>18}" for each in shown), flush=True)


def measured(rounds, everything):
    """Names, and seconds with an empty cache, later, and compiled with an empty cache."""
    for name, code in SMALL.items():
        yield name, (least(code, rounds, True), least(code, rounds, False), None)
    for name, code in LARGE.items():
        found = [least(code, rounds, fresh) for fresh in (True, False)]
        yield name, (*found, least(code, 1, True, always=True))
    yield "all of the above in one process", (least(in_one_process(), 1, True), None, None)
    if everything:
        yield "all features, as `attitude warm-up --all`", (least(ALL, 1, True), None, None)


def repeated(name, most=COUNTED[-1]):
    """CPU seconds of the calls of a row of `CALLS`, and those that ran in Python."""
    setup, call = CALLS[name]
    code = MOTION + REPEATED.format(setup=setup, call=call, most=most, budget=CALLS_BUDGET)
    with tempfile.TemporaryDirectory() as cache:
        ran = subprocess.run(
            [sys.executable, "-c", code],
            cwd=ROOT,
            env={
                **os.environ,
                **dict.fromkeys(("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"), cache),
                "ATTITUDE_COMPILE": "automatic",
            },
            stdout=subprocess.PIPE,
            check=True,
        )
    return json.loads(ran.stdout)


def _spelled(times, in_python):
    """The cells of a row of repeated calls."""
    calls = [f"{1e3 * times[k - 1]:.3g}" if k <= len(times) else "" for k in COUNTED]
    longest = max(times)
    return (*calls, f"{longest:.2f}", str(times.index(longest) + 1), f"{in_python:.2f}")


def in_one_process():
    """The code of all rows, but those that are `APART`, one after the other."""
    parts = ["from attitude.cli import main"]
    for name, code in {**SMALL, **LARGE}.items():
        if name in APART:
            continue
        if isinstance(code, list):
            given = [each for each in code[2:] if each != "--output"]
            code = f"assert main({given!r}) == 0"
        parts.append(code)
    return "\n".join(parts)


def least(code, rounds, fresh, always=False):
    """Least CPU seconds of a process; the first of those that find a filled cache fills it."""
    with tempfile.TemporaryDirectory() as folder:
        times = []
        for number in range(rounds if fresh else rounds + 1):
            cache = os.path.join(folder, str(number) if fresh else "kept")
            command = [sys.executable, *(code if isinstance(code, list) else ["-c", code])]
            if command[-1] == "--output":
                command.append(
                    os.path.join(folder, "view.html" if "view" in command else "out.csv")
                )
            choice = {"ATTITUDE_COMPILE": "always" if always else "automatic"}
            begin = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                command,
                cwd=ROOT,
                # tables of shadows are kept there
                env={**os.environ, "NUMBA_CACHE_DIR": cache, "XDG_CACHE_HOME": cache, **choice},
                stdout=subprocess.DEVNULL,
                check=True,
            )
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            times.append(end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)
        return min(times if fresh else times[1:])


if __name__ == "__main__":
    main()
