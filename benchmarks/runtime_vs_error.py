"""What does an attitude cost, and how large is its error?  This project and its alternatives.

    python benchmarks/runtime_vs_error.py            # about 25 minutes
    python benchmarks/runtime_vs_error.py --quick    # below 2 minutes

Every method propagates the same states to the same epochs, set-up included, in processor time;
errors are relative to the mpmath oracle of tests/support/oracle.py for the exact doubles given, at
12 of the epochs.  The script writes runtime_vs_error.png, .md (all rows) and .json (with machine,
versions and day) to --output (docs/figures).  Methods that are not installed are named and omitted.
"""

import argparse
import json
import sys
import textwrap
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks import peers, record
from benchmarks.doc_tables import Table, printed
from tests.support import oracle

SPANS = (10, 1e3, 1e6, 1e9)
COUNTS = (1, 1000, 100_000, 1_000_000)
UNIT = (1.0, 0.0, 0.0, 0.0)
DAY = 86400.0
MAKES = ("run time against error",)
NEEDS = ("heyoka", "orekit_jpype")


def tables(quick):
    """The table of docs/accuracy.md, with the files of docs/figures; 25 minutes."""
    if not quick:
        found = made(cases(), SPANS, COUNTS, 20.0, record.FIGURES)
        yield Table("run time against error", printed(_summary, found))


def cases():
    """name -> (moments, wxyz0, omega0)."""
    degrees = np.pi / 180.0
    toutatis = tuple(np.array([14.51, 33.529, -98.709]) * degrees / DAY)
    near = 1.7 * (1.7 - 1.0) / (2.3 * (2.3 - 1.7)) / 1.7  # (w3/w1)^2 on the separatrix
    return {
        "the paper's example": ((10.0, 20.0, 26.0), UNIT, (1.0, 15.0, 1.0)),
        "Toutatis": ((3.0836, 3.235, 1.0), UNIT, toutatis),
        "Apophis": ((0.61, 0.965, 1.0), UNIT, _apophis()),
        "wobble of 1e-6": ((1.0, 1.7, 2.3), UNIT, (7e-7, 7e-7, 1.0)),
        "symmetric but for 1e-9": ((1.0, 1.0 + 1e-9, 1.7), UNIT, (0.5, 0.3, 0.8)),
        "1e-10 from the separatrix": (
            (1.0, 1.7, 2.3),
            UNIT,
            (1.0, 0.3, float(np.sqrt(near)) * (1.0 + 1e-10)),
        ),
        "Dzhanibekov flip from 1e-6": ((1.0, 1.7, 2.3), UNIT, (1e-6, 1.0, 1e-6)),
    }


def _apophis():
    """Published moments and E/E0 = 1.0236 (Pravec et al. 2014), long axis in the plane of L."""
    a, c = 0.61, 1.0
    dynamic = c / 1.0236  # L^2 / 2E
    fast = 2.0 * np.pi / (27.38 * 3600.0)
    ratio = np.sqrt(c * (c - dynamic) / (a * (dynamic - a)))
    return (float(fast * ratio), 0.0, float(fast))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="fewer cases, spans and epochs")
    parser.add_argument("--output", default=str(record.FIGURES), help="folder (docs/figures)")
    parser.add_argument("--only", nargs="+", metavar="METHOD", help='such as attitude "heyoka"')
    arguments = parser.parse_args()
    folder = record.writable_folder(arguments.output)
    chosen, spans, counts, limit = cases(), SPANS, COUNTS, 20.0
    if arguments.quick:
        chosen = {name: chosen[name] for name in list(chosen)[::5]}
        spans, counts, limit = SPANS[:3], COUNTS[1:3], 0.7
    _summary(made(chosen, spans, counts, limit, folder, arguments.only))


def made(chosen, spans, counts, limit, folder, only=None):
    """Measure all methods, or those of some names, and write the files; what the JSON has."""
    methods, missing = peers.every()
    methods = [method for method in methods if only is None or method.name in only]
    for module, reason in missing:
        print(f"left out: {module}: {reason}")
    start = time.perf_counter()
    rows = []
    for method in methods:
        _compile(method)
    for number, (name, state) in enumerate(chosen.items(), 1):
        exact = oracle.Oracle(*state)
        for method in methods:
            for span in spans:
                rows += measure(method, name, state, exact, span, counts, limit)
            done = time.perf_counter() - start
            print(
                f"\r{done:5.0f} s  case {number}/{len(chosen)}  {name}: {method.name} "
                f"{method.setting}".ljust(100),
                end="",
                flush=True,
            )
    print()
    result = {"machine": record.machine(), "missing": missing, "rows": rows}
    (folder / "runtime_vs_error.json").write_text(json.dumps(result, indent=1) + "\n")
    table = _table(rows, result["machine"])
    (folder / "runtime_vs_error.md").write_text(table)
    _figure(rows, spans, folder / "runtime_vs_error.png")
    print(
        f"written: {folder}/runtime_vs_error.png, .md, .json; {time.perf_counter() - start:.0f} s"
    )
    return result


def measure(method, case, state, exact, span, counts, limit):
    """One row for each number of epochs; a run beyond the time limit is omitted and marked."""
    moments, wxyz0, omega0 = state
    revolution = 2.0 * np.pi / np.linalg.norm(omega0)
    rows = []
    spent = []  # (number of epochs, seconds)
    for count in counts:
        row = {
            "method": method.name,
            "setting": method.setting,
            "case": case,
            "span": span,
            "epochs": count,
        }
        t = (
            np.linspace(0.0, span * revolution, count)
            if count > 1
            else np.array([span * revolution])
        )
        if span > method.furthest:
            row["left out"] = "the span is beyond what it reaches in a reasonable time"
        elif (expected := _extrapolated(spent, count)) > limit:
            row["left out"] = f"would take about {expected:.0f} s"
        else:
            try:
                wxyz, seconds = _timed(method, moments, wxyz0, omega0, t)
                row["ns"] = seconds / count * 1e9
                row["error"] = _error(wxyz, exact, t)
                spent.append((count, seconds))
            except Exception as err:  # a failure of a method is a result
                row["broke"] = (
                    f"{type(err).__name__}: {str(err).splitlines()[0][:90] if str(err) else ''}"
                )
        rows.append(row)
    return rows


def _extrapolated(spent, count):
    """Estimated seconds for a number of epochs: the cost of the span plus that of each epoch."""
    if not spent:
        return 0.0
    few, least = spent[0]
    most, longest = spent[-1]
    slope = max(0.0, longest - least) / (most - few) if most > few else 0.0
    return longest + slope * (count - most)


def _compile(method):
    """Run a method once on easy states, so that compilation is not timed."""
    try:
        method.solve((1.0, 1.7, 2.3), UNIT, (0.3, 0.5, 1.0), np.linspace(0.0, 1.0, 3))
        method.solve((1.0, 1.7, 2.3), UNIT, (1e-3, 1.0, 1e-3), np.linspace(0.0, 1.0, 3))
    except Exception as err:
        print(f"{method.name}: {err}")


def _timed(method, moments, wxyz0, omega0, t):
    """Attitudes, and the least processor time of up to seven runs, in s.

    What else the machine does lengthens the time on the clock of a run of seconds, which is not
    repeated.
    """
    least, spent = np.inf, 0.0
    for _ in range(7):
        start = time.process_time()
        wxyz = method.solve(moments, wxyz0, omega0, t)
        seconds = time.process_time() - start
        least, spent = min(least, seconds), spent + seconds
        if spent > 0.5:
            break
    return wxyz, least


def _error(wxyz, exact, t):
    """The largest error in rad at up to 12 of the epochs, the last among them."""
    worst = 0.0
    chosen = np.unique(np.linspace(0, len(t) - 1, 12).astype(int))
    for k, row in zip(chosen, peers.as_wxyz(wxyz[chosen]).tolist(), strict=True):
        if not np.all(np.isfinite(row)):
            return float("nan")
        worst = max(worst, oracle.rotation_error(row, exact.at(float(t[k]))[0]))
    return worst


def _table(rows, machine):
    lines = [
        "# Run time against error, all rows",
        "",
        f"Made by benchmarks/runtime_vs_error.py on {record.described(machine)}",
        "",
        "| case | method | setting | revolutions | epochs | ns an epoch | error, rad |",
        "| --- | --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for row in rows:
        if "ns" in row:
            error = f"{row['error']:.1e}" if row["error"] == row["error"] else "NaN"
            answer = f"{row['ns']:.3g} | {error}"
        else:
            answer = "- | " + (row.get("broke") or row["left out"])
        lines.append(
            f"| {row['case']} | {row['method']} | {row['setting']} | {row['span']:.0e} | "
            f"{row['epochs']:.0e} | {answer} |"
        )
    return "\n".join(lines) + "\n"


def _summary(result):
    """Versions and day; median cost at 1e5 epochs and worst error, by method and span."""
    rows = result["rows"]
    print(textwrap.fill(record.described(result["machine"]), 100))
    print()
    spans = sorted({row["span"] for row in rows})
    print(f"{'':34}" + "".join(f"{f'{span:.0e} revolutions':>26}" for span in spans))
    print(f"{'method':34}" + f"{'ns an epoch   worst error':>26}" * len(spans))
    for key in dict.fromkeys((row["method"], row["setting"]) for row in rows):
        cells = []
        for span in spans:
            here = [r for r in rows if (r["method"], r["setting"], r["span"]) == (*key, span)]
            cost = [r["ns"] for r in here if "ns" in r and r["epochs"] == 100_000]
            errors = [r["error"] for r in here if "ns" in r]
            broke = sum("broke" in r for r in here) + sum(e != e for e in errors)
            errors = [e for e in errors if e == e]
            cell = f"{np.median(cost):9.0f}" if cost else "        -"
            cell += f"{max(errors):12.1e}" if errors else "           -"
            cells.append(f"{cell}{f' {broke}x' if broke else '':>5}")
        print(f"{' '.join(key):34}" + "".join(f"{cell:>26}" for cell in cells))
    print("Nx: N answers that were NaN or an exception.")


def _figure(rows, spans, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    columns = min(2, len(spans))
    lines = -(-len(spans) // columns)
    figure, axes = plt.subplots(
        lines, columns, figsize=(9.0, 4.0 * lines + 1.4), sharex=True, sharey=True,
        layout="constrained", squeeze=False,
    )  # fmt: skip
    panels = axes.flat[: len(spans)]
    names = list(dict.fromkeys(row["method"] for row in rows))
    for axis, span in zip(panels, spans, strict=True):
        for k, name in enumerate(names):
            here = [r for r in rows if r["method"] == name and r["span"] == span and "ns" in r]
            most = {}
            for row in here:  # the longest array of each setting
                key = row["case"], row["setting"]
                if row["epochs"] >= most.get(key, row)["epochs"] and row["epochs"] <= 100_000:
                    most[key] = row
            colour = f"C{k}"
            good = [r for r in most.values() if r["error"] == r["error"]]
            axis.scatter(
                [r["ns"] for r in good],
                [max(r["error"], 1e-17) for r in good],
                s=60 if k == 0 else 22,
                color=colour,
                marker="*" if k == 0 else "o",
                alpha=0.9 if k == 0 else 0.55,
                label=name,
                zorder=3 if k == 0 else 2,
            )
            settings = list(dict.fromkeys(r["setting"] for r in good))
            medians = [
                [np.median([r[what] for r in good if r["setting"] == each]) for each in settings]
                for what in ("ns", "error")
            ]
            axis.plot(*medians, color=colour, alpha=0.6, lw=1)
            lost = [r for r in most.values() if r["error"] != r["error"]]
            axis.scatter([r["ns"] for r in lost], [5.0] * len(lost), color=colour, marker="x", s=30)
        axis.set(xscale="log", yscale="log")
        axis.set_title(f"{span:.0e} revolutions".replace("e+0", "e"))
        axis.axhline(4e-15, color="0.7", lw=0.8, ls="--")
        axis.grid(alpha=0.25)
    for axis in axes[-1]:
        axis.set_xlabel("cost of an epoch, set-up included (ns)")
    for axis in axes[:, 0]:
        axis.set_ylabel("attitude error (rad)\n× at the top: NaN")
    panels[0].set_ylim(1e-17, 10.0)
    handles, labels = [], []
    for axis in panels:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            if label not in labels:
                handles.append(handle)
                labels.append(label)
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    states = len({row["case"] for row in rows})
    figure.suptitle(f"Run time against error: {states} states, a point each")
    figure.savefig(path, dpi=130)
    plt.close(figure)


if __name__ == "__main__":
    main()
