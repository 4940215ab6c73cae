"""What do eight tools make of a torque-free brick?  Cases with exact answers, errors and times.

    python benchmarks/brick.py                # tables and figure of docs/brick.md; 6 minutes
    python benchmarks/brick.py cases          # write data/torque-free-cases.json anew
    python benchmarks/brick.py --only Orekit 42    # these tools anew, the others as they were

docs/figures/brick.json keeps what was measured.
The code of each tool is that of the page: a heading with the tool's name, below it the block that
defines ``solve``.  Tools that are not installed are named.  42 runs where the environment variable
FORTY_TWO names a folder in which it was built; elsewhere its formulas do (`forty_two_by_formulas`).
"""

import argparse
import json
import os
import re
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks import record
from benchmarks.doc_tables import Table
from benchmarks.stability import conditioning
from tests.support import oracle

CASES = record.ROOT / "data" / "torque-free-cases.json"
PAGE = record.ROOT / "docs" / "brick.md"
FIGURE = record.FIGURES / "brick.png"
KEPT = record.FIGURES / "brick.json"
MAKES = ("brick", "brick costs")
NEEDS = ("heyoka", "orekit_jpype", "Basilisk", "spiceypy")

TURNS = (0.0, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 1e4, 1e6, 1e9)
DIGITS = 25
EACH = 100.0  # turns that every tool is asked for
ORDER = (
    *("attitude", "scipy", "heyoka", "Orekit", "Basilisk"),
    *("42", "42, its formulas", "Tudat", "SPICE"),
)
UNIT = (1.0, 0.0, 0.0, 0.0)
TURNED = (0.5, 0.5, -0.5, 0.5)
BRICK = (13.0, 10.0, 5.0)  # 12 kg, edges 1, 2 and 3 m: (4 + 9, 1 + 9, 1 + 4)
DAY = 86400.0
# name -> what it is, moments, wxyz, angular velocity
STATES = {
    "brick": ("12 kg, edges 1, 2 and 3 m", BRICK, TURNED, (0.3, 0.2, -0.5)),
    "long axis": ("the brick, nearly about its long axis", BRICK, TURNED, (0.02, 0.05, 0.6)),
    "short axis": ("the brick, nearly about its short axis", BRICK, TURNED, (1.0, 0.01, 0.02)),
    "middle axis": ("the brick flips, as a T-handle does", BRICK, UNIT, (1e-6, 1.0, 1e-6)),
    "separatrix": (
        "the brick, 1e-10 from the separatrix",
        BRICK,
        UNIT,
        (1.0, 0.25, float(np.sqrt(13.0 * 3.0 / (5.0 * 5.0)) * (1.0 + 1e-10))),
    ),
    "wobble": ("the brick, 1e-6 from its short axis", BRICK, UNIT, (1.0, 7e-7, 7e-7)),
    "axis": ("the brick exactly about its short axis", BRICK, TURNED, (1.0, 0.0, 0.0)),
    "rod": ("edges 1, 1 and 3 m: two moments are equal", (10.0, 10.0, 2.0), UNIT, (0.3, 0.1, 0.7)),
    "cube": ("edges of 1 m", (2.0, 2.0, 2.0), TURNED, (0.3, -0.2, 0.5)),
    "paper": ("van Zon & Schofield 2006", (10.0, 20.0, 26.0), UNIT, (1.0, 15.0, 1.0)),
    "Toutatis": (
        "Takahashi et al. 2013, state of 9 November 1992",
        (3.0836, 3.235, 1.0),
        UNIT,
        tuple((np.radians((14.51, 33.529, -98.709)) / DAY).tolist()),
    ),
    "Apophis": (
        "moments and rates as of Pravec et al. 2014",
        (0.61, 0.965, 1.0),
        UNIT,
        (1.5e-4, 0.0, 6.4e-5),
    ),
}


def cases():
    """What the file has: each case with its answers."""
    rows = []
    for name, (about, moments, wxyz, rates) in STATES.items():
        turn = float(f"{2.0 * np.pi / np.linalg.norm(rates):.3g}")
        epochs = [float(f"{turns * turn:.12g}") for turns in TURNS]
        exact = oracle.Oracle(moments, wxyz, rates, digits=40)
        answers = []
        for t in epochs:
            quaternion, omega = exact.at(t)
            answers.append({"wxyz": _texts(quaternion), "angular_velocity": _texts(omega)})
        off = [float(f"{conditioning(moments, wxyz, rates, np.array([t])):.2g}") for t in epochs]
        rows.append(
            {"name": name, "about": about, "moments": moments, "wxyz": wxyz}
            | {"angular_velocity": rates, "turn": turn, "epochs": epochs}
            | {"conditioning": off, "answers": answers}
        )
    about = (
        "Torque-free rotation: exact answers. wxyz (scalar first) turns body components into "
        "inertial ones; kg m2, rad/s in body axes, s; see docs/brick.md. MIT licence."
    )
    return {"about": about, "digits": DIGITS, "cases": rows}


def _texts(values):
    """Decimals of numbers of mpmath."""
    return [oracle.mp.nstr(value, DIGITS) for value in values]


def text_of(data):
    """JSON with a line for each list of numbers."""
    text = json.dumps(data, indent=1)
    return re.sub(r"\[\s+([^\[\]{}]*?)\s+\]", lambda m: f"[{' '.join(m[1].split())}]", text) + "\n"


def tools():
    """(name, solve) of each tool of the page, and (name, reason) of those that do not load."""
    found, missing = [], []
    for title, body in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE.read_text(), re.M | re.S):
        block = re.search(r"^```py\n(.*?def solve\(.*?)^```", body, re.M | re.S)
        if block is None:
            continue
        if title == "42" and "FORTY_TWO" not in os.environ:
            found.append(("42, its formulas", forty_two_by_formulas))
            continue
        names = {"__name__": f"tool_{len(found)}"}
        try:
            exec(compile(block.group(1), f"docs/brick.md, {title}", "exec"), names)
        except Exception as err:  # an import, or a Java virtual machine
            missing.append((title, f"{type(err).__name__}: {err}"))
            continue
        found.append((title, names["solve"]))
    return found, missing


def forty_two_by_formulas(moments, wxyz0, omega0, t, turn):
    """RK4 with 200 steps a turn on rates and quaternion, which each step normalises."""
    a, b, c = moments

    def derivative(state):
        w, x, y, z, p, q, r = state.tolist()
        return np.array(
            [
                (-x * p - y * q - z * r) / 2,
                (w * p + y * r - z * q) / 2,
                (w * q + z * p - x * r) / 2,
                (w * r + x * q - y * p) / 2,
                (b - c) / a * q * r,
                (c - a) / b * r * p,
                (a - b) / c * p * q,
            ]
        )

    step, state = turn / 200, np.array([*wxyz0, *omega0], dtype=float)
    found, wanted = [], set(np.rint(np.array(t) / step).astype(int).tolist())
    for k in range(max(wanted) + 1):
        if k in wanted:
            found.append(state[:4])
        first = derivative(state)
        second = derivative(state + 0.5 * step * first)
        third = derivative(state + 0.5 * step * second)
        fourth = derivative(state + step * third)
        state = state + step * (first / 6 + second / 3 + third / 3 + fourth / 6)
        state[:4] /= np.linalg.norm(state[:4])
    return found


def errors(wxyz, case):
    """Rotations between a tool's answers and the exact ones, rad, NaN where there is no answer."""
    found = []
    for row, answer in zip(wxyz, case["answers"], strict=False):
        exact = [oracle.mpf(text) for text in answer["wxyz"]]
        row = [float(value) for value in row]
        finite = bool(np.all(np.isfinite(row)))
        found.append(oracle.rotation_error(row, exact) if finite else np.nan)
    return np.array(found)


def measure(names=None, cases=None):
    """Run all tools, or those of some names, on all cases or some, and keep what came out.

    A tool is asked for the epochs up to EACH turns; a closed form for all of them.
    """
    found, missing = tools()
    for case in json.loads(CASES.read_text())["cases"]:
        for name, solve in found:
            if (names and name not in names) or (cases and case["name"] not in cases):
                continue
            epochs = np.array(case["epochs"])
            if name not in ("attitude", "Orekit"):
                epochs = epochs[epochs <= EACH * case["turn"] * 1.001]
            row = _run(solve, case, epochs)
            kept = results()
            kept["rows"].setdefault(name, {})[case["name"]] = row
            kept["machine"], kept["missing"] = record.machine(), missing
            whole = KEPT.with_suffix(".new")
            whole.write_text(text_of(kept))
            whole.replace(KEPT)
            print(f"{name:18s} {case['name']:12s} {row.get('refused', '')}", flush=True)


def results():
    """What docs/figures/brick.json has: rows by tool and case."""
    return json.loads(KEPT.read_text()) if KEPT.exists() else {"rows": {}}


def _run(solve, case, epochs):
    """{"turns", "errors"} or {"refused"}: a failure of a tool is a result; and the seconds."""
    state = case["moments"], case["wxyz"], case["angular_velocity"]
    begun = _processor()
    try:
        wxyz = solve(*state, epochs, case["turn"])
    except Exception as err:
        return {"refused": f"{type(err).__name__}: {str(err).splitlines()[0][:80]}"}
    seconds = float(f"{_processor() - begun:.3g}")
    off = [float(f"{value:.2g}") for value in errors(wxyz, case)]
    turns = [float(f"{value:.3g}") for value in epochs / case["turn"]]
    return {"turns": turns, "errors": off, "seconds": seconds}


def _processor():
    """Seconds of processor of this process and of those it started."""
    started = os.times()
    return time.process_time() + started.children_user + started.children_system


def _said(reason):
    return reason if reason == "not run" else "refused"


def _worst(values):
    return "NaN" if np.any(np.isnan(values)) else f"{max(np.max(values), 0.0):.0e}"


def tables(quick):
    """Both tables of docs/brick.md, and its figure."""
    if not quick:
        measure()
        draw()
        yield Table("brick", table())
        yield Table("brick costs", costs())


def table():
    """Largest errors up to EACH turns, cases by tools."""
    kept = results()
    names = [name for name in ORDER if name in kept["rows"]]
    lines = [
        f"Largest error up to {EACH:.0f} turns, rad; {record.described(kept['machine'])}",
        "",
        f"| case | {' | '.join(names)} | conditioning |",
        "| --- |" + " ---: |" * (len(names) + 1),
    ]
    for case in json.loads(CASES.read_text())["cases"]:
        cells = []
        for name in names:
            row = kept["rows"][name].get(case["name"], {"refused": "not run"})
            near = np.array(row.get("turns", ())) <= EACH * 1.001
            off = np.array(row.get("errors", ()), dtype=float)
            cells.append(_worst(off[near]) if len(off) else _said(row["refused"]))
        count = sum(t <= EACH * case["turn"] * 1.001 for t in case["epochs"])
        cells.append(_worst(np.array(case["conditioning"][:count])))
        lines.append(f"| {case['name']} | {' | '.join(cells)} |")
    for title, reason in kept["missing"]:
        lines.append(f"\nNot run: {title} ({reason}).")
    return "\n".join(lines)


def costs():
    """Processor time of the same calls: the median of the cases."""
    kept = results()["rows"]
    lines = [
        f"Processor time for the epochs up to {EACH:.0f} turns, set-up included, median of cases:",
        "",
        "| tool | ms |",
        "| --- | ---: |",
    ]
    for name in (each for each in ORDER if each in kept):
        spent = [row["seconds"] for row in kept[name].values() if "seconds" in row]
        lines.append(f"| {name} | {1e3 * np.median(spent):.2g} |")
    return "\n".join(lines)


def draw(output=FIGURE):
    """Errors against turns in two cases, a line for each tool."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    cases = {case["name"]: case for case in json.loads(CASES.read_text())["cases"]}
    kept = results()["rows"]
    titles = {"brick": "the brick tumbles", "middle axis": "the brick flips about its middle axis"}
    with plt.rc_context({"font.size": 11}):
        figure, axes = plt.subplots(2, 1, figsize=(7.0, 7.6), sharex=True, layout="constrained")
        for axis, (name, title) in zip(axes, titles.items(), strict=True):
            case = cases[name]
            turns = np.array(case["epochs"][1:]) / case["turn"]
            limit = np.maximum(case["conditioning"][1:], 1e-18)
            axis.fill_between(turns, 1e-18, limit, color="#e4e4e4")
            for k, tool in enumerate(each for each in ORDER if each in kept):
                row = kept[tool].get(name, {})
                if "errors" in row:
                    style = {"color": f"C{k}", "marker": "osD^vPX*d"[k], "markersize": 5}
                    off = np.maximum(row["errors"][1:], 1e-17)
                    axis.loglog(row["turns"][1:], off, label=tool, **style)
            axis.set(title=title, ylabel="error, rad", ylim=(1e-17, 10.0))
            axis.grid(alpha=0.3)
        axes[1].set_xlabel("turns; grey: what one unit in the last place of the input does")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.savefig(output, dpi=100)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", nargs="?", choices=("tables", "cases"), default="tables")
    parser.add_argument("--only", nargs="+", metavar="TOOL", help='such as heyoka "42"')
    parser.add_argument("--cases", nargs="+", metavar="CASE", help="such as brick paper")
    arguments = parser.parse_args()
    if arguments.what == "cases":
        CASES.write_text(text_of(cases()))
    else:
        measure(arguments.only, arguments.cases)
        if not arguments.cases:
            draw()
            print(table(), costs(), sep="\n\n")


if __name__ == "__main__":
    main()
