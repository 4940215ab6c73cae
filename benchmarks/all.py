"""Remake every table and figure of README and docs, in place, and compare with the record.

    python benchmarks/all.py                   # all: hours
    python benchmarks/all.py --quick           # what can be made in ten minutes
    python benchmarks/all.py speed scene       # the tables of these scripts
    python benchmarks/all.py --quick --dry     # print and compare; write nothing

Each script runs in a process of its own, on one thread, compiled from the first call.  Ratios
(benchmarks/doc_tables.py) that differ from those of benchmarks/ratios.json by more than 10 % are
listed, and the record then takes the new ones.  Tables that --quick cannot afford, or whose
programs are not installed, stay as they are, and are named.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks import doc_tables as tables
from benchmarks import pictures
from benchmarks.record import ROOT

SETTINGS = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# Single calls are measured as machine code, not in Python while the process is young.
SETTINGS["ATTITUDE_COMPILE"] = "always"
CHILD = "--in-this-process"
# Seconds after which --quick starts no further script and ends the one that runs.
QUICK = 570.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scripts", nargs="*", metavar="script", help="only the tables of these")
    parser.add_argument("--quick", action="store_true", help="what can be made in ten minutes")
    parser.add_argument("--dry", action="store_true", help="write nothing")
    parser.add_argument("--no-figures", action="store_true", help="tables alone")
    parser.add_argument(CHILD, nargs=2, dest="child", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        name, file = given.child
        Path(file).write_text(json.dumps(tables.run_here(name, given.quick)), encoding="utf-8")
        return 0
    makers = tables.makers()
    unknown = sorted(set(given.scripts) - set(makers))
    if unknown:
        parser.error(f"{', '.join(unknown)} make no table; these do: {', '.join(makers)}")
    begin, failed = time.perf_counter(), []
    made, ratios = {}, {}
    for name in given.scripts or makers:
        left = QUICK - (time.perf_counter() - begin) if given.quick else None
        if left is not None and left < 1.0:
            print(f"{name:20} left: {', '.join(makers[name])}, ten minutes are over")
            continue
        try:
            found = of_script(name, given.quick, left)
        except subprocess.TimeoutExpired:
            print(f"{name:20} left: {', '.join(makers[name])}, ended after ten minutes")
            continue
        if found is None:
            failed.append(name)
            continue
        left = [each for each in makers[name] if each not in found["texts"]]
        print(
            f"{name:20} {found['seconds']:6.1f} s, propagate {found['propagate']:.2f} ns, load "
            f"{found['load']:.1f}"
            + (f"; left: {', '.join(left)}" if left else "")
            + "".join(f"; {each} is not installed" for each in found["missing"]),
            flush=True,
        )
        made |= found["texts"]
        ratios |= found["ratios"]
        if not given.dry:
            tables.write(found["texts"])
    if given.dry:
        for name, text in made.items():
            print(f"\n{name}\n{text}")
    if not given.scripts and not given.no_figures and not given.dry:
        for script, what in pictures.draw(given.quick):
            print(f"{script:36} {what}", flush=True)
            failed += [script] * what.endswith("FAILED")
    report(ratios, given.dry)
    print(f"\n{time.perf_counter() - begin:.0f} s" + "".join(f"\nFAILED: {x}" for x in failed))
    return 1 if failed else 0


def of_script(name, quick, seconds=None):
    """What a script makes, in a process of its own; None if it failed."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "made.json"
        command = [sys.executable, __file__, CHILD, name, str(file), *["--quick"] * quick]
        done = subprocess.run(command, cwd=ROOT, env={**os.environ, **SETTINGS}, timeout=seconds)
        return None if done.returncode else json.loads(file.read_text(encoding="utf-8"))


def report(ratios, dry):
    """Print the ratios that left the record, and renew it."""
    lines = list(tables.changes(tables.recorded(), ratios))
    compared = sum(map(len, ratios.values()))
    print(f"\n{compared} ratios; beyond {tables.LIMIT:.0%} of the record: {len(lines)}")
    for line in lines:
        print("  " + line)
    if not dry:
        tables.record(ratios)


if __name__ == "__main__":
    sys.exit(main())
