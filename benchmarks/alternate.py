"""Is one checkout slower than another?  A benchmark of both, alternately, in fresh processes.

    python benchmarks/alternate.py OLD NEW benchmarks/speed.py [arguments ...]
    python benchmarks/alternate.py -n 7 --limit 3 OLD NEW benchmarks/ensembles.py
    python benchmarks/alternate.py -c "import attitude; attitude.Body(moments=(1, 2, 3))" OLD NEW

OLD and NEW are roots of checkouts; options of alternate.py stand before them.  Each runs its own
copy of the script.  The figures of a run are the numbers that it prints, named by the words before
them in their line and by their column, and its processor time.  Printed are the medians of both and
the ratio of NEW to OLD, of figures that differ by more than --limit percent, or of all (--all),
with the spread of the ratios of neighbouring runs: a ratio within it says nothing.  Each checkout
has a folder of machine code of its own, filled by a first run that is not counted.
"""

import argparse
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w]|\.\d)")
SETTINGS = {
    "ATTITUDE_COMPILE": "always",
    **dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
}
SECONDS = "processor time, s"


def figures_of(text):
    """{name: number} of the numbers that a benchmark prints.

    A name is the words of the line before its first number, with the number of the figure in the
    line; lines with the same words are counted.
    """
    figures, lines = {}, {}
    for line in text.splitlines():
        numbers = list(NUMBER.finditer(line))
        if not numbers:
            continue
        words = " ".join(line[: numbers[0].start()].split()).strip("|: ")
        lines[words] = lines.get(words, 0) + 1
        name = words if lines[words] == 1 else f"{words} ({lines[words]})"
        for k, number in enumerate(numbers, 1):
            figures[f"{name} [{k}]"] = float(number[0])
    return figures


def run(root, command, cache):
    """The figures of one run in a fresh process."""
    environment = os.environ | SETTINGS | {"PYTHONPATH": str(root), "NUMBA_CACHE_DIR": cache}
    before = _processor_seconds()
    result = subprocess.run(
        [sys.executable, *command], cwd=root, env=environment, capture_output=True, text=True
    )
    if result.returncode:
        sys.exit(f"{' '.join(command)} failed in {root}:\n{result.stderr}")
    return figures_of(result.stdout) | {SECONDS: _processor_seconds() - before}


def _processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def compared(old, new):
    """[(figure, median of old, median of new, ratio, spread)] of runs of both.

    The ratio is the median of the ratios of neighbouring runs, the spread half the range between
    their quartiles.  Figures that are not positive in all runs have no ratio and are left out.
    """
    rows = []
    for name in old[0]:
        pairs = [
            (one[name], two[name])
            for one, two in zip(old, new, strict=True)
            if one.get(name, 0.0) > 0.0 and two.get(name, 0.0) > 0.0
        ]
        if len(pairs) < len(old):
            continue
        ratios = sorted(two / one for one, two in pairs)
        spread = 0.0
        if len(ratios) > 1:
            low, _, high = statistics.quantiles(ratios, n=4, method="inclusive")
            spread = 0.5 * (high - low)
        medians = (statistics.median(column) for column in zip(*pairs, strict=True))
        rows.append((name, *medians, statistics.median(ratios), spread))
    return rows


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("old", type=Path, help="root of a checkout")
    parser.add_argument("new", type=Path, help="root of the other checkout")
    parser.add_argument("-n", type=int, default=5, metavar="RUNS", help="of each; 5")
    parser.add_argument("--limit", type=float, default=3.0, metavar="PERCENT", help="3")
    parser.add_argument("--all", action="store_true", help="print every figure")
    parser.add_argument("-c", dest="code", help="statements in place of a script")
    parser.add_argument("command", nargs=argparse.REMAINDER, help="script and its arguments")
    given = parser.parse_args(arguments)
    command = ["-c", given.code] if given.code else given.command
    if not command:
        parser.error("Give a script of benchmarks/ and its arguments, or statements with -c.")
    roots = [given.old.resolve(), given.new.resolve()]
    for root in roots:
        if not given.code and not (root / command[0]).is_file():
            parser.error(f"{root} has no {command[0]}; give a script that both checkouts have.")
    runs = [[], []]
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        for root, cache in zip(roots, (one, two), strict=True):
            run(root, command, cache)
        for k in range(given.n):
            # The order changes, so that a drift of the machine's speed favours neither.
            order = (0, 1) if k % 2 == 0 else (1, 0)
            for which in order:
                runs[which].append(run(roots[which], command, (one, two)[which]))
    rows = compared(*runs)
    report(rows, given.limit / 100.0, show_all=given.all)
    absent = sorted(set(runs[0][0]) ^ set(runs[1][0]))
    if absent:
        print(f"{len(absent)} figures are those of one checkout only: {', '.join(absent[:5])}")


def report(rows, limit, *, show_all):
    """Print the figures that differ by more than a share, or all."""
    shown = [row for row in rows if show_all or row[0] == SECONDS or abs(row[3] - 1.0) > limit]
    print(f"{'figure':58}{'old':>12}{'new':>12}{'new/old':>9}{'spread':>8}")
    for name, old, new, ratio, spread in shown:
        sign = " *" if abs(ratio - 1.0) > max(limit, spread) else ""
        print(f"{name[:57]:58}{old:12.5g}{new:12.5g}{ratio:9.3f}{spread:8.3f}{sign}")
    middle = statistics.median(row[3] for row in rows)
    beyond = sum(abs(row[3] - 1.0) > max(limit, row[4]) for row in rows)
    print(
        f"{len(rows)} figures; median ratio {middle:.3f}; {beyond} differ by more than "
        f"{100.0 * limit:g} % and than their spread (*)."
    )


if __name__ == "__main__":
    main(sys.argv[1:])
