"""Build the site into docs/_build/html: warnings are errors, and no network is used.

    pip install -e ".[docs]"
    python docs/make_site.py [--no-notebooks]

It writes the pages of the API from the list of public modules, and the list of all files, takes the
gallery from its stored outputs, runs the notebooks, and checks every link and anchor of the pages;
docs/_build keeps the results of notebooks while they do not change; with --no-notebooks they are
shown without results.
"""

import importlib
import inspect
import re
import subprocess
import sys
from contextlib import suppress
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

DOCS = Path(__file__).resolve().parent
SITE = DOCS / "_build" / "html"
sys.path[:0] = [str(DOCS.parent), str(DOCS)]

import make_map

import attitude


def api_pages():
    """A page for each public module, an index with a sentence for each name, all files."""
    folder = DOCS / "api"
    folder.mkdir(exist_ok=True)
    sentences, homes = read_modules()
    names, modules = {}, []
    for module, sentence in sentences.items():
        modules.append(f"| [{module}]({module}.md) | {sentence} |")
        members = {label: value for (at, label), value in homes.items() if at == module}
        rows = []
        for label, (home, text) in members.items():
            rows.append(f"| {{py:obj}}`{label} <{home}.{label}>` | {text} |")
            names[f"{home}.{label}"] = label.lower(), rows[-1]
        table = "## Names\n\n| name | what it is |\n| --- | --- |\n" + "\n".join(rows) + "\n\n"
        head = f".. automodule:: {module}\n   :no-index:\n   :no-members:\n"
        away = sorted(label for label, (home, _) in members.items() if home != module)
        left = f"   :exclude-members: {', '.join(away)}\n" if away else ""
        body = f".. currentmodule:: {module}\n\n.. automodule:: {module}\n   :members:\n{left}"
        (folder / f"{module}.md").write_text(
            f"# {module}\n\n```{{eval-rst}}\n{head}```\n\n{table if rows else ''}"
            f"## In full\n\n```{{eval-rst}}\n{body}```\n"
        )
    (folder / "files.md").write_text(make_map.page())
    every = "\n".join(row for _, row in sorted(names.values()))
    listed = "\n".join([*attitude.PUBLIC_MODULES, "files"])
    (folder / "index.md").write_text(
        "# Find a name: API reference\n\nThe public modules, made from their docstrings; "
        "`attitude.PUBLIC_MODULES` is the same list. Other modules may change in any release; "
        "[all files](files.md) are listed with a line each.\n\n## Modules\n\n"
        f"| module | what it has |\n| --- | --- |\n{chr(10).join(modules)}\n\n"
        f"## All names\n\n| name | what it is |\n| --- | --- |\n{every}\n\n"
        f"```{{toctree}}\n:maxdepth: 1\n:hidden:\n\n{listed}\n```\n"
    )


def read_modules():
    """The sentence of each public module; (module, name) -> (home, sentence) of its names.

    The home of a name is the page that describes it: that of its own folder if this has the name,
    else the first one but `attitude` itself.
    """
    sentences, values = {}, {}
    for module in attitude.PUBLIC_MODULES:
        try:
            loaded = importlib.import_module(module)
        except ImportError:  # jax, torch
            root = Path(attitude.__file__).parents[1]
            file = root.joinpath(*module.split(".")).with_suffix(".py")
            sentences[module] = f"{make_map.first_line(file)}."
            continue
        sentences[module] = sentence_of(loaded)
        for label in getattr(loaded, "__all__", ()):
            with suppress(attitude.AttitudeError):  # needs a package that is not installed
                value = getattr(loaded, label)
                if callable(value) and inspect.getdoc(value):
                    values[module, label] = value
    homes = {}
    for (module, label), value in values.items():
        own = getattr(value, "__module__", "")
        others = [at for (at, _), other in values.items() if other is value and at != "attitude"]
        inside = [at for at in others if f"{own}.".startswith(f"{at}.")]
        home = max(inside, key=len, default=[*others, module][0])
        homes[module, label] = home, sentence_of(value)
    return sentences, homes


def sentence_of(value):
    """The first sentence of a docstring, as a cell of a table."""
    text = " ".join(inspect.getdoc(value).split("\n\n")[0].split())
    text = re.split(r"(?<=[.!?]) (?=[A-Z`])", text)[0]
    return text.replace("``", "`").replace("|", r"\|").replace("*", r"\*")


class _Page(HTMLParser):
    """Anchors of a page, and where its links and pictures lead."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.targets = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.anchors |= {values[key] for key in ("id", "name") if values.get(key)}
        self.targets += [values[key] for key in ("href", "src") if values.get(key)]


def broken(site=SITE):
    """(number of links checked, "page: target" of those that lead nowhere within the site)."""
    pages = {file: _Page(file.read_text("utf-8")) for file in site.rglob("*.html")}
    wrong, count = [], 0
    for file, page in pages.items():
        for target in page.targets:
            address = urlsplit(target)
            if address.scheme or address.netloc:
                continue
            path = unquote(address.path)
            other = (file.parent / path).resolve() if path else file
            count += 1
            anchor = unquote(address.fragment)
            lost = not other.exists()
            if anchor and other in pages:
                lost = anchor not in pages[other].anchors
            if lost:
                wrong.append(f"{file.relative_to(site)}: {target}")
    return count, sorted(set(wrong))


def main():
    """Build and check; the exit code of sphinx, or 1 for links that lead nowhere."""
    api_pages()
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q"]
    if "--no-notebooks" in sys.argv:
        command += ["-D", "nb_execution_mode=off"]
    code = subprocess.run([*command, str(DOCS), str(SITE)]).returncode
    count, wrong = broken()
    print(f"{count} links and anchors checked, {len(wrong)} lead nowhere", *wrong, sep="\n")
    return code or int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
