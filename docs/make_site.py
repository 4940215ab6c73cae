"""Build the site into docs/_build/html: warnings are errors, and no network is used.

    pip install -e ".[docs]"
    python docs/make_site.py [--no-notebooks]

It writes the pages of the API from the list of public modules, and the list of all files, takes the
gallery from its stored outputs, and runs the notebooks; docs/_build keeps their results while they
do not change; with --no-notebooks they are shown without results.
"""

import subprocess
import sys
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
    for name in names:
        # The names of the package itself are indexed where they are defined.
        index = "   :no-index:\n" if name == "attitude" else ""
        text = f".. automodule:: {name}\n   :members:\n{index}"
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


def main():
    """Build; the exit code of sphinx."""
    api_pages()
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q"]
    if "--no-notebooks" in sys.argv:
        command += ["-D", "nb_execution_mode=off"]
    return subprocess.run([*command, str(DOCS), str(DOCS / "_build" / "html")]).returncode


if __name__ == "__main__":
    sys.exit(main())
