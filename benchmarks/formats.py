"""How fast are attitude files written and read, and what is lost?

    python benchmarks/formats.py [RECORDS]

It writes a tumbler's history (1e5 records by default) in every format into a temporary folder,
reads it, and prints CPU seconds, bytes and the largest differences.
"""

import os
import sys
import tempfile
import time

import numpy as np

from attitude import Body, FreeRotation, Spin, epochs, quaternion
from attitude.formats import aem, stk, tables


def main(count):
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
    history = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(count) * 0.1)
    history.angular_velocity  # computed before the measurement  # noqa: B018
    ways = {
        "AEM 2.0": ("aem", aem.write, aem.read, {}),
        "AEM 1.0": ("aem", aem.write, aem.read, {"version": "1.0"}),
        "AEM 2.0, quaternions alone": ("aem", aem.write, aem.read, {"kind": "QUATERNION"}),
        "AEM 2.0, XML": ("xml", aem.write, aem.read, {"xml": True}),
        "STK .a": ("a", stk.write, stk.read, {}),
        "CSV": ("csv", tables.write, tables.read, {}),
        "ECSV": ("ecsv", tables.write, tables.read, {}),
        "FITS": ("fits", tables.write, tables.read, {}),
        "parquet": ("parquet", tables.write, tables.read, {}),
    }
    print(f"{count} records with angular velocity")
    print(f"{'format':28} {'write s':>8} {'read s':>8} {'MB':>7} {'rad':>9} {'epochs s':>9}")
    with tempfile.TemporaryDirectory() as folder:
        for name, (ending, write, read, how) in ways.items():
            path = os.path.join(folder, f"attitude.{ending}")
            writing = best(lambda: write(path, history, **how))  # noqa: B023
            reading = best(lambda: read(path))  # noqa: B023
            size = os.path.getsize(path) / 1e6
            lost = losses(read(path), history)
            print(
                f"{name:28} {writing:8.2f} {reading:8.2f} {size:7.1f} {lost[0]:9.1e} {lost[1]:9.1e}"
            )


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
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000)
