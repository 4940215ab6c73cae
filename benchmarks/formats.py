"""How fast are attitude files written and read, and what is lost?

    python benchmarks/formats.py [RECORDS]

It writes a tumbler's history (1e5 records by default) in every format into a temporary folder,
reads it, and prints CPU seconds, bytes and the largest differences.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude import Body, FreeRotation, Spin, epochs
from attitude._compilation.choice import compiling
from attitude.formats import aem, stk
from attitude.formats import tables as columns
from attitude.frames import quaternion
from benchmarks.doc_tables import Table, markdown

MAKES = ("formats",)
NEEDS = ("pyarrow",)


def tables(quick):
    """The table of docs/formats.md."""
    rows, costs = [], {}
    for name, writing, reading, size, angle, late in measured(100_000):
        rows.append(
            (
                name,
                f"{writing:.2f}",
                f"{reading:.2f}",
                f"{size:.1f}",
                *("same bits" if angle == 0.0 else f"{angle:.1e}", f"{late:.1e}"),
            )
        )
        costs |= {f"{name}, write": writing * 1e4, f"{name}, read": reading * 1e4}
    head = "format", "write", "read", "MB", "attitudes, rad", "epochs, s"
    yield Table("formats", markdown(head, rows), costs=costs)


def main(count):
    print(f"{count} records with angular velocity")
    print(f"{'format':28} {'write s':>8} {'read s':>8} {'MB':>7} {'rad':>9} {'epochs s':>9}")
    for name, writing, reading, size, angle, late in measured(count):
        print(f"{name:28} {writing:8.2f} {reading:8.2f} {size:7.1f} {angle:9.1e} {late:9.1e}")


def measured(count):
    """For each format: its name, CPU seconds, MB, and what is lost (rad, s)."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
    history = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(count) * 0.1)
    history.angular_velocity  # computed before the measurement  # noqa: B018
    ways = {
        "AEM 2.0": ("aem", aem.write, aem.read, {}),
        "AEM 1.0": ("aem", aem.write, aem.read, {"version": "1.0"}),
        "AEM 2.0, quaternions alone": ("aem", aem.write, aem.read, {"kind": "QUATERNION"}),
        "AEM 2.0, XML": ("xml", aem.write, aem.read, {"xml": True}),
        "STK .a": ("a", stk.write, stk.read, {}),
        "CSV": ("csv", columns.write, columns.read, {}),
        "ECSV": ("ecsv", columns.write, columns.read, {}),
        "FITS": ("fits", columns.write, columns.read, {}),
        "parquet": ("parquet", columns.write, columns.read, {}),
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, (ending, write, read, how) in ways.items():
            path = os.path.join(folder, f"attitude.{ending}")
            writing = best(lambda: write(path, history, **how))  # noqa: B023
            reading = best(lambda: read(path))  # noqa: B023
            size = os.path.getsize(path) / 1e6
            lost = losses(read(path), history)
            yield name, writing, reading, size, *lost


def best(call, times=3):
    """The least CPU time of some runs, in seconds."""
    took = []
    for _ in range(times):
        start = time.process_time()
        call()
        took.append(time.process_time() - start)
    return min(took)


def losses(table, history):
    """The largest angle in rad, and the largest difference of epochs in s."""
    turn = quaternion.multiply(quaternion.conjugate(table.wxyz), history.wxyz)
    angle = 2.0 * np.linalg.norm(turn[:, 1:], axis=1)
    hi, lo = epochs.seconds_since(history.epoch, table.epoch)
    late = (table.seconds - history.seconds + hi) + (table.low + lo)
    # the rounding of this product gives 1e-16 for identical quaternions
    angle[np.all(table.wxyz == history.wxyz, axis=1)] = 0.0
    return float(np.max(angle)), float(np.max(np.abs(late)))


if __name__ == "__main__":
    with compiling():
        main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000)
