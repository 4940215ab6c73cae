"""A light curve of very many points from the command line: `python benchmarks/inversion_points.py`.

A tumbler of `synthetic_curves` with so many points an hour that its CSV has a million rows (another
number as argument).  Processor seconds and memory are those of `attitude invert` as a process of
its own, compiled code read from the cache.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.support import synthetic_curves
from tests.support.inversion_families import STYLES

NAMES = "jd_tdb,mag,sigma,session,sun_x,sun_y,sun_z,observer_x,observer_y,observer_z"


def write(path: Path, points: int) -> synthetic_curves.Case:
    """A CSV of about so many points; the case."""
    style = STYLES[2]
    hours = style["nights"] * sum(style["hours"]) / 2.0
    style = {**style, "per_hour": points / hours, "even": True, "noise": 0.1}
    case = synthetic_curves.case(7500000, style)
    rows = case.jd, case.magnitude, case.sigma, case.session, case.sun, case.observer
    formats = ["%.9f", "%.4f", "%.4f", "%d"] + 6 * ["%.9f"]
    np.savetxt(path, np.column_stack(rows), fmt=formats, delimiter=",", header=NAMES, comments="")
    return case


def run(points: int) -> tuple[float, float, str]:
    """Processor seconds, memory in GB, and the text printed, of the command."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "curve.csv"
        case = write(path, points)
        options = ["--max-frequency", f"{case.most} /d", "--frame", "ecliptic", "--budget", "900 s"]
        command = [sys.executable, "-m", "attitude", "invert", str(path), *options]
        made = subprocess.run(command, capture_output=True, text=True, check=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0**2
    print(made.stdout)
    print(
        f"{len(case.jd)} points: truth {case.mode}, P_phi {case.P_phi:.5f}, P_psi {case.P_psi:.5f}"
    )
    print(f"{spent:.1f} s of processor, {memory:.2f} GiB")
    return spent, memory, made.stdout


if __name__ == "__main__":
    run(int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000)
