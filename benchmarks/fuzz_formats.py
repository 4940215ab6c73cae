"""Mutated files of attitudes: an answer or an AttitudeError, in seconds, and no partial file.

    python benchmarks/fuzz_formats.py [FILES [SEED]]

mutates files of the readers FILES times (1e5 by default): AEM, APM and ACM in both notations, with
rates of version 1, several objects and left-out parts, CIC, STK files with every kind of section,
and photometry.  A sentence of more than 600 characters counts as a fault.
Every tenth file that is read is written again.  It prints the number of files that were read and
refused, the slowest (in processor time), and each other exception.  Files that cause one are kept,
and those that take more than 5 s.
"""

from __future__ import annotations

import collections
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

import numpy as np

from attitude import AttitudeError, photometry
from attitude.formats import acm, aem, apm, detect, stk
from tests.support.fuzzing import LONGEST_SENTENCE, mutated, samples

SLOWEST = 5.0
FAULTS_SHOWN = 20


def read(path: Path, name: str) -> object:
    """Read a file as the sample of this name is read."""
    if name.startswith("lenient"):
        return aem.read(path, lenient=True)
    if name.startswith("rates"):
        return aem.read(path, rates="euler")
    if name.startswith("apm"):
        return apm.read(path)
    if name.startswith("acm"):
        return acm.read(path)
    if name.startswith("photometry"):
        return photometry.read(path)
    if name.startswith("stk"):
        return stk.read(path)
    return detect.read(path)


def written_again(content: object, folder: Path) -> None:
    """Write what was read; after an error the folder has no new file."""
    table = content
    if isinstance(content, acm.Comprehensive):
        table = content.tables[0] if content.tables else None
    if not hasattr(table, "history"):
        return
    before = sorted(folder.iterdir())
    out = folder / "again.aem"
    try:
        aem.write(out, table, creation_date="x")
        aem.read(out)
        out.unlink()
    except AttitudeError:
        out.unlink(missing_ok=True)
    assert sorted(folder.iterdir()) == before, "a partial file was left"


def hunt(count: int, seed: int, show: bool = True) -> tuple[collections.Counter[str], float, int]:
    """Mutate and read `count` files; counts of outcomes, the slowest in s, and faults."""
    random = np.random.default_rng(seed)
    given = samples()
    names = sorted(given)
    outcomes: collections.Counter[str] = collections.Counter()
    slowest, faults = 0.0, 0
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number in range(count):
            name = names[number % len(names)]
            data, ending = given[name]
            path = Path(folder) / f"mutated.{ending}"
            path.write_bytes(mutated(data, random))
            start = time.process_time()
            try:
                try:
                    found = read(path, name)
                    outcomes["read"] += 1
                    if number % 10 == 0:
                        written_again(found, Path(folder))
                except AttitudeError as err:
                    outcomes["refused"] += 1
                    length = len(str(err).replace(str(path), ""))
                    assert 0 < length <= LONGEST_SENTENCE, f"a sentence of {length} characters"
            except Exception:
                faults += 1
                kept = Path(tempfile.gettempdir()) / f"fault-{seed}-{number}.{ending}"
                kept.write_bytes(path.read_bytes())
                if show and faults <= FAULTS_SHOWN:
                    print(f"{name}, kept as {kept}:\n{traceback.format_exc(limit=-4)}")
            spent = time.process_time() - start
            if spent > max(slowest, SLOWEST):
                shutil.copy(path, Path(tempfile.gettempdir()) / f"slow-{seed}-{number}.{ending}")
            slowest = max(slowest, spent)
    return outcomes, slowest, faults


def main() -> None:
    """Run the hunt and print its outcome."""
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    outcomes, slowest, faults = hunt(count, seed)
    print(
        f"{count} files, seed {seed}: {outcomes['read']} read, {outcomes['refused']} refused, "
        f"{faults} other exceptions; the slowest took {slowest:.2f} s of processor"
    )
    if faults or slowest > SLOWEST:
        sys.exit(1)


if __name__ == "__main__":
    main()
