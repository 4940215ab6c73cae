"""Pictures of README and docs, and the commands that draw them."""

import re
import subprocess
import sys
from importlib.util import find_spec

from benchmarks.doc_tables import pages
from benchmarks.record import FIGURES, ROOT

# Arguments of the interpreter, the files of docs/figures, whether --quick runs the command, and the
# packages that it needs.
COMMANDS = (
    (
        ["benchmarks/stability.py"],
        ["stability.png", "stability.md", "stability.json"],
        False,
        ("heyoka", "orekit_jpype"),
    ),
    (
        ["benchmarks/runtime_vs_error.py"],
        ["runtime_vs_error.png", "runtime_vs_error.md", "runtime_vs_error.json"],
        False,
        ("heyoka", "orekit_jpype"),
    ),
    (
        ["benchmarks/splitting.py", "orders", "circular", "referee", "--output", "docs/figures"],
        ["splitting_orders.png", "splitting_circular.png", "referee.png"],
        False,
        (),
    ),
    (
        ["benchmarks/photometry.py", "figures"],
        ["toutatis_periodogram.png", "toutatis_two_periods.png"],
        False,
        (),
    ),
    (
        ["benchmarks/brick.py"],
        ["brick.png", "brick.json"],
        False,
        ("heyoka", "orekit_jpype", "Basilisk", "spiceypy"),
    ),
    (["benchmarks/proof.py", "figure"], ["proof.png"], True, ("flint",)),
    (["docs/make_figures.py"], ["labellings.png", "angles.png", "toutatis.png"], True, ()),
    *(
        ([f"examples/{name}.py"], [f"{name}.png"], False, ())
        for name in (
            "apophis_2029_torque",
            "apophis_light_curve",
            "despin",
            "envisat_glints",
            "relaxation",
            "t_handle",
            "yorp",
        )
    ),
    (["docs/make_gallery.py"], ["gallery"], False, ("PIL",)),
    (["docs/make_first_screen.py"], ["first_screen"], False, ("PIL",)),
)


def shown(root=ROOT):
    """Pictures below docs/figures that README and docs show."""
    link = re.compile(r"\]\((?:docs/)?figures/([\w/.-]+\.(?:png|webp|gif|svg))\)")
    return {name for page in pages(root) for name in link.findall(page.read_text("utf-8"))}


def drawn():
    """Files and folders of docs/figures that the commands make."""
    return {name for _, names, _, _ in COMMANDS for name in names}


def draw(quick):
    """Run the commands, each in a process; yields the command and what was done."""
    for (script, *more), names, short, packages in COMMANDS:
        absent = [each for each in packages if find_spec(each) is None]
        if absent:
            yield script, f"{', '.join(names)} left: {', '.join(absent)} not installed"
        elif quick and not short:
            yield script, f"{', '.join(names)} left, longer than --quick allows"
        else:
            # Examples write into the folder in which they run.
            folder = FIGURES if script.startswith("examples/") else ROOT
            done = subprocess.run([sys.executable, ROOT / script, *more], cwd=folder)
            yield script, f"{', '.join(names)} " + ("FAILED" if done.returncode else "drawn")
