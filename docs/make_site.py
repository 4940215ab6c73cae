"""Build the site into docs/_build/html: warnings are errors, and no network is used.

    pip install -e ".[docs]"
    python docs/make_site.py [--no-notebooks]

It writes the pages of the API from the list of public modules, and the list of all files, takes the
gallery from its stored outputs, and runs the notebooks; docs/_build keeps their results while they
do not change; with --no-notebooks they are shown without results.
"""

import importlib
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path[:0] = [str(DOCS.parent), str(DOCS)]

import make_map

import attitude


def api_pages():
    """A page for each public module, their list, and the list of all files."""
    folder = DOCS / "api"
    folder.mkdir(exist_ok=True)
    names = attitude.PUBLIC_MODULES
    shown = set()
    for name in names:
        # The names of the package itself are indexed where they are defined.
        options = "   :no-index:\n" if name == "attitude" else _elsewhere(name, shown)
        text = f".. automodule:: {name}\n   :members:\n{options}"
        text = f"# {name}\n\n```{{eval-rst}}\n{text}```\n"
        (folder / f"{name}.md").write_text(text)
    (folder / "files.md").write_text(make_map.page())
    listed = "\n".join([*names, "files"])
    (folder / "index.md").write_text(
        "# API reference\n\nThe public modules, made from their docstrings; "
        "`attitude.PUBLIC_MODULES` is the same list. Other modules may change in any release; "
        "all files are listed at the end.\n\n"
        f"```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n"
    )


def _elsewhere(name, shown):
    """The option that leaves out classes of which another page has shown the description.

    `shown` has these classes, and takes those of the module.
    """
    try:
        module = importlib.import_module(name)
    except ImportError:  # jax, torch
        return ""
    classes = {}
    for label in getattr(module, "__all__", ()):
        with suppress(attitude.AttitudeError):  # needs a package that is not installed
            if isinstance(getattr(module, label), type):
                classes[label] = getattr(module, label)
    again = sorted(label for label, value in classes.items() if value in shown)
    shown.update(classes.values())
    return f"   :exclude-members: {', '.join(again)}\n" if again else ""


def main():
    """Build; the exit code of sphinx."""
    api_pages()
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q"]
    if "--no-notebooks" in sys.argv:
        command += ["-D", "nb_execution_mode=off"]
    return subprocess.run([*command, str(DOCS), str(DOCS / "_build" / "html")]).returncode


if __name__ == "__main__":
    sys.exit(main())
