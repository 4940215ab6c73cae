"""What the first results cost: in fresh processes, with an empty and with a filled cache.

    python benchmarks/first_use.py [--quick]

Each time is the least of three processes, in CPU seconds, with the ratio to one that only imports
numpy.  Empty: the folder of machine code is new for each process.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile

MOTION = """
from attitude import Body, FreeRotation, Spin
body = Body(moments=(10, 20, 26))
spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
motion = FreeRotation(body, spin)
"""
PROPAGATE = [
    *("-m", "attitude", "propagate", "data/spin/toutatis.toml", "--start", "1992-12-02"),
    *("--stop", "1992-12-19", "--step", "1 d", "--output"),
]
FEATURES = {
    "import numpy": "import numpy",
    "imports of the next line": "from attitude import Body, FreeRotation, Spin",
    "one attitude of a FreeRotation": MOTION + "motion.at(60.0)",
    "attitude describe toutatis": ["-m", "attitude", "describe", "toutatis"],
    "attitude propagate, 18 epochs": PROPAGATE,
    "2e5 attitudes (compiled)": MOTION + "import numpy as np; motion.at(np.arange(2e5))",
}
COMPILED = {
    "a chain with an impulse and an event": "impulses",
    "torques": "torques",
    "a scene with an event": "scenes_and_events",
    "meshes with shadows, all laws": "light_curves",
    "derivatives": "derivatives",
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "--quick", action="store_true", help="one process each, no compiled features"
    )
    arguments = parser.parse_args()
    rounds = 1 if arguments.quick else 3
    base = None
    print(f"{'CPU seconds (x import numpy)':<40}{'empty cache':>18}{'later':>18}")
    for name, code in FEATURES.items():
        row = [least(code, rounds, fresh) for fresh in (True, False)]
        base = base or row[1]
        print(f"{name:<40}" + "".join(f"{each:9.2f} ({each / base:5.1f})" for each in row))
    if arguments.quick:
        return
    for name, feature in COMPILED.items():
        lines = f"from attitude import warm_up; warm_up.{feature}()"
        row = [least(lines, 1, fresh) for fresh in (True, False)]
        print(f"{name:<40}" + "".join(f"{each:9.2f} ({each / base:5.1f})" for each in row))


def least(code, rounds, fresh):
    """Least CPU seconds of a process; the first of those that find a filled cache fills it."""
    with tempfile.TemporaryDirectory() as folder:
        times = []
        for number in range(rounds if fresh else rounds + 1):
            cache = os.path.join(folder, str(number) if fresh else "kept")
            command = [sys.executable, *(code if isinstance(code, list) else ["-c", code])]
            if command[-1] == "--output":
                command.append(os.path.join(folder, "out.csv"))
            begin = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                command,
                env={**os.environ, "NUMBA_CACHE_DIR": cache},
                stdout=subprocess.DEVNULL,
                check=True,
            )
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            times.append(end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)
        return min(times if fresh else times[1:])


if __name__ == "__main__":
    main()
