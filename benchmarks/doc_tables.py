"""Tables of README and docs: who makes them, where they stand, and their ratios.

A script that makes tables names them in `MAKES`, and its `tables(quick)` yields a `Table` for each
of them, or for those that --quick can afford.  In a page the text stands between the two marks

    <!-- table: NAME -->
    <!-- end of table -->

on lines of their own, or within a line.  Costs are divided by what `propagate` takes for an epoch
in the same process, so that they are comparable between machines and days; other numbers are given
as ratios to something measured in the same run.
"""

import ast
import contextlib
import importlib
import io
import json
import os
import re
import time
from dataclasses import dataclass, field
from importlib.util import find_spec

from benchmarks.record import ROOT, processor

RECORD = ROOT / "benchmarks" / "ratios.json"
PAGES = ("README.md", "docs/*.md", "docs/howto/*.md")
END = "<!-- end of table -->"
BLOCK = re.compile(r"<!-- table: ([\w ,.-]+?) -->(.*?)" + re.escape(END), re.DOTALL)
LIMIT = 0.1


@dataclass(frozen=True)
class Table:
    """The text of one table in Markdown; costs in ns, and numbers that are ratios already."""

    name: str
    text: str
    costs: dict = field(default_factory=dict)
    ratios: dict = field(default_factory=dict)


def makers(folder=ROOT / "benchmarks"):
    """The names of the tables of each script, by the name of the script, without importing it."""
    found = {}
    for file in sorted(folder.glob("*.py")):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "MAKES":
                found[file.stem] = ast.literal_eval(node.value)
    return found


def pages(root=ROOT):
    """README and the pages of docs."""
    return [file for pattern in PAGES for file in sorted(root.glob(pattern))]


def names_in(text):
    """The names of the tables of a page, in order."""
    return [found[1] for found in BLOCK.finditer(text)]


def replaced(text, tables):
    """The text of a page with new tables, by name; those that are not given stay."""

    def body(match):
        new = tables.get(match[1])
        if new is None:
            return match[0]
        line = "\n" if match[2].startswith("\n") else ""
        return f"<!-- table: {match[1]} -->{line}{new.strip()}{line}{END}"

    return BLOCK.sub(body, text)


def write(tables, root=ROOT):
    """Put tables, texts by name, into all pages; the pages that changed."""
    changed = []
    for page in pages(root):
        before = page.read_text(encoding="utf-8")
        after = replaced(before, tables)
        if after != before:
            page.write_text(after, encoding="utf-8")
            changed.append(page)
    return changed


def changes(before, after, limit=LIMIT):
    """Lines for the ratios that differ from those of the record by more than the limit."""
    for name, ratios in after.items():
        for label, ratio in ratios.items():
            kept = before.get(name, {}).get(label)
            if kept and abs(ratio / kept - 1.0) > limit:
                change = 100.0 * (ratio / kept - 1.0)
                yield f"{name}: {label}: {kept:.3g} -> {ratio:.3g} ({change:+.0f} %)"


def recorded(file=RECORD):
    """The ratios of the record, by table."""
    return json.loads(file.read_text(encoding="utf-8"))["tables"] if file.is_file() else {}


def record(ratios, file=RECORD):
    """Put ratios into the record, beside those of tables that were not remade."""
    kept = recorded(file) | ratios
    text = json.dumps({"processor": processor(), "tables": kept}, indent=1, sort_keys=True)
    file.write_text(text + "\n", encoding="utf-8")


def reference():
    """What propagate takes for an epoch, ns of the processor: a measure of the machine."""
    import numpy as np

    from attitude import propagate

    t, least = np.linspace(0.0, 1e4, 10**5), np.inf
    out = np.empty((4, t.size)).T
    for _ in range(100):
        begin = time.thread_time()
        propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), t, out=out)
        least = min(least, time.thread_time() - begin)
    return least / t.size * 1e9


def printed(function, *arguments):
    """What a function prints, as a block of text."""
    kept = io.StringIO()
    with contextlib.redirect_stdout(kept):
        function(*arguments)
    lines = (line.rstrip() for line in kept.getvalue().strip("\n").splitlines())
    return "\n".join(["```text", *lines, "```"])


def markdown(head, rows, right=()):
    """A table in Markdown; columns whose numbers are in `right` are aligned to the right."""
    rule = ["---:" if k in right else "---" for k in range(len(head))]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in (head, rule, *rows))


def run_here(name, quick):
    """Make the tables of a script in this process: texts and ratios, and the reference, ns.

    A script names the packages that it cannot do without in `NEEDS`: a table without their rows
    would replace a whole one.
    """
    module = importlib.import_module(f"benchmarks.{name}")
    absent = [each for each in getattr(module, "NEEDS", ()) if find_spec(each) is None]
    before, begin = reference(), time.perf_counter()
    made = [] if absent else list(module.tables(quick))
    seconds, unit = time.perf_counter() - begin, min(before, reference())
    unknown = {table.name for table in made} - set(module.MAKES)
    if unknown:
        raise ValueError(f"benchmarks/{name}.py: {sorted(unknown)} are not in its MAKES")
    return {
        "texts": {table.name: table.text for table in made},
        "ratios": {
            table.name: table.ratios | {label: cost / unit for label, cost in table.costs.items()}
            for table in made
        },
        "missing": absent,
        "propagate": unit,
        "seconds": seconds,
        "load": os.getloadavg()[0],
    }
