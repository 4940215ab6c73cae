"""Where does each method break?  A map of the error over inertia and distance from special states.

    python benchmarks/stability.py            # about 3 minutes
    python benchmarks/stability.py --quick    # a coarser map, below 1 minute

In each of three planes the inertia runs from two equal moments at one end to two equal moments at
the other, both approached down to 1e-16; the state approaches rotation about the short axis, about
the long axis, and the separatrix, down to 1e-16.  Each state is propagated by 10 revolutions (this
project also by 1e9) and compared with the mpmath oracle of tests/support/oracle.py for the exact
doubles given.  The last row shows the conditioning: the change of the exact answer after 10
revolutions when one input changes by one unit in its last place, the error that any input in
doubles implies.

The script writes stability.png, stability.md and stability.json to --output (docs/figures).
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import propagate
from benchmarks import peers, record
from benchmarks.doc_tables import Table
from tests.support import oracle

NEAR = (10, 1e9)
# The least and the largest moment.
LEAST = 1.0
MOST = 1.7
ATTITUDE = (0.5, -0.1, 0.7, 0.3)
PLANES = ("short axis", "long axis", "separatrix")
BULK = ("attitude", "paper, numpy + scipy", "heyoka", "Orekit TorqueFree")
# Beyond this an answer is useless; NaN and exceptions are counted separately.
USELESS = 1e-3
MAKES = ("stability",)
NEEDS = ("heyoka", "orekit_jpype")


def tables(quick):
    """The table of docs/accuracy.md, with the files of docs/figures; three minutes."""
    if not quick:
        yield Table("stability", made(np.arange(17), record.FIGURES))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="every other power of ten")
    parser.add_argument("--output", default=str(record.FIGURES), help="folder (docs/figures)")
    arguments = parser.parse_args()
    folder = record.writable_folder(arguments.output)
    made(np.arange(0, 17, 4 if arguments.quick else 1), folder)


def made(powers, folder):
    """Write the files; the table in Markdown."""
    found, missing = peers.every()
    for module, reason in missing:
        print(f"left out: {module}: {reason}")
    methods = [m for m in found if m.name in BULK and m.setting in ("exact", "double", "2e-16")]
    rows = _columns(powers)
    start = time.perf_counter()
    labels = [f"{methods[0].name}, 1e9 revolutions", *(m.name for m in methods)]
    maps = {
        name: np.full((3, len(powers), len(rows)), np.nan) for name in [*labels, "conditioning"]
    }
    broke = {name: 0 for name in labels}
    for p, plane in enumerate(PLANES):
        for j, middle in enumerate(rows):
            for i, power in enumerate(powers):
                state = (LEAST, middle, MOST), ATTITUDE, _rates(plane, middle, power)
                _one(state, methods, maps, broke, (p, i, j))
            share = (p * len(rows) + j + 1) / (3 * len(rows))
            print(
                f"\r{time.perf_counter() - start:5.0f} s  {100 * share:3.0f} %", end="", flush=True
            )
    print()
    table = _table(maps, broke, labels, record.machine())
    print(table)
    (folder / "stability.md").write_text("# Stability, counted\n\n" + table)
    result = {
        "machine": record.machine(),
        "missing": missing,
        "powers": powers.tolist(),
        "middle_moment": [x.hex() for x in rows],
        "log10_error": {k: _log(v).round(2).tolist() for k, v in maps.items()},
    }
    (folder / "stability.json").write_text(json.dumps(result, allow_nan=True) + "\n")
    _figure(maps, labels, powers, folder / "stability.png")
    print(f"written: {folder}/stability.png, .md, .json")
    return table


def _columns(powers):
    """Middle moments from LEAST (1 + 1e-16) over the middle to MOST (1 - 1e-16)."""
    gap = MOST - LEAST
    share = 0.5 * 10.0 ** -powers.astype(float)
    low = [LEAST + gap * x for x in share[::-1]]
    high = [MOST - gap * x for x in share[1:]]
    return [float(x) for x in low + high]


def _rates(plane, middle, power):
    near = 10.0 ** -float(power)
    if plane == "short axis":
        return (0.6 * near, -0.8 * near, 1.0)
    if plane == "long axis":
        return (1.0, 0.6 * near, -0.8 * near)
    # D2 = I3 (I3 - I2) w3^2 - I1 (I2 - I1) w1^2: fix one rate, compute the other near D2 = 0.
    small, large = LEAST * (middle - LEAST), MOST * (MOST - middle)
    if small < large:
        return (1.0, 0.4, float(np.sqrt(small / large) * (1.0 + 0.5 * near)))
    return (float(np.sqrt(large / small) * (1.0 + 0.5 * near)), 0.4, 1.0)


def _one(state, methods, maps, broke, place):
    exact = oracle.Oracle(*state)
    revolution = 2.0 * np.pi / np.linalg.norm(state[2])
    near, far = (np.array([n * revolution]) for n in NEAR)
    for k, method in enumerate([methods[0], *methods]):
        t = far if k == 0 else near
        label = f"{method.name}, 1e9 revolutions" if k == 0 else method.name
        try:
            row = peers.as_wxyz(method.solve(*state, t))[0].tolist()
        except Exception:  # a failure of a method is a result
            broke[label] += 1
            continue
        if np.all(np.isfinite(row)):
            maps[label][place] = oracle.rotation_error(row, exact.at(float(t[0]))[0])
    maps["conditioning"][place] = conditioning(*state, near)


def conditioning(moments, wxyz0, omega0, t):
    """Largest rotation of the answer, in rad, when one moment or rate changes by one ulp."""
    inputs = np.array([*moments, *omega0])
    moved = np.repeat(inputs[None], 12, axis=0)
    for k in range(6):
        moved[2 * k, k] = np.nextafter(inputs[k], np.inf)
        moved[2 * k + 1, k] = np.nextafter(inputs[k], -np.inf)
    q = propagate(moved[:, :3], wxyz0, moved[:, 3:], t)[:, 0]
    base = propagate(moments, wxyz0, omega0, t)[0]
    off = q - base
    return 2.0 * np.max(np.linalg.norm(off - (off @ base)[:, None] * base, axis=1))


def _log(values):
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isnan(values), np.nan, np.log10(np.maximum(values, 1e-17)))


def _table(maps, broke, labels, machine):
    total = maps["conditioning"].size
    limit = np.maximum(4e-15, 10.0 * maps["conditioning"])
    lines = [
        f"{total} states; {record.described(machine)}",
        "",
        "| method | worst, rad | median, rad | NaN | exceptions | above 1e-3 rad | "
        "above 4e-15 rad and 10 x the conditioning |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for label in labels:
        errors = maps[label]
        nan = int(np.sum(np.isnan(errors))) - broke[label]
        known = errors[~np.isnan(errors)]
        worst, median = (np.max(known), np.median(known)) if known.size else (np.nan, np.nan)
        beyond = "-" if "1e9" in label else int(np.sum(errors > limit))
        lines.append(
            f"| {label} | {worst:.1e} | {median:.1e} | {nan} | "
            f"{broke[label]} | {int(np.sum(errors > USELESS))} | {beyond} |"
        )
    worst, median = np.max(maps["conditioning"]), np.median(maps["conditioning"])
    lines.append(f"| conditioning | {worst:.1e} | {median:.1e} | | | | |")
    return "\n".join(lines) + "\n"


def _figure(maps, labels, powers, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown = [*labels, "conditioning"]
    figure, axes = plt.subplots(
        len(shown),
        3,
        figsize=(9.0, 1.9 * len(shown) + 1.0),
        sharex=True,
        sharey=True,
        layout="constrained",
    )
    colours = matplotlib.colormaps["viridis"].copy()
    colours.set_bad("crimson")
    columns = 2 * len(powers) - 1
    centre = len(powers) - 1
    ticks = [0, centre // 2, centre, centre + (centre + 1) // 2, columns - 1]
    names = [f"{0.7 * 0.5 * 10.0 ** -powers[abs(k - centre)]:.0e}" for k in ticks]
    for row, name in enumerate(shown):
        for p in range(3):
            axis = axes[row, p]
            picture = axis.imshow(
                _log(maps[name][p]), cmap=colours, vmin=-16, vmax=0, aspect="auto", origin="upper"
            )
            axis.set_xticks(ticks, names, fontsize=9)
            rows = range(0, len(powers), max(1, len(powers) // 4))
            axis.set_yticks(list(rows), [f"1e-{powers[i]}" for i in rows], fontsize=9)
            if row == 0:
                axis.set_title(f"distance to the {PLANES[p]}", fontsize=10)
        axes[row, 0].set_ylabel(name.replace(", ", ",\n"), fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel("I2 - 1     |     1.7 - I2", fontsize=9)
    bar = figure.colorbar(picture, ax=axes, shrink=0.5, pad=0.015)
    bar.set_label("log10 of the attitude error, rad (red: NaN or exception)")
    figure.suptitle("Attitude error after 10 revolutions; moments (1, I2, 1.7)")
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main()
