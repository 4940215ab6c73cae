"""All files of the package, each with the first line of its docstring.

    python docs/make_map.py

prints them; `docs/make_site.py` makes a page of the site from them.
"""

import ast
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "attitude"


def first_line(file):
    """The first line of a module's docstring, without its full stop."""
    return ast.get_docstring(ast.parse(file.read_text())).splitlines()[0].rstrip(".")


def lines(folder=PACKAGE, depth=0):
    """The lines of a folder: its files, then its folders, each with what it holds."""
    indent = "  " * depth
    for file in sorted(folder.glob("*.py")):
        if file.name not in ("__init__.py", "__main__.py"):
            yield f"{indent}{file.stem:{26 - len(indent)}s} {first_line(file)}"
    for inner in sorted(path.parent for path in folder.glob("*/__init__.py")):
        yield f"{indent}{inner.name + '/':{26 - len(indent)}s} {first_line(inner / '__init__.py')}"
        yield from lines(inner, depth + 1)


def page():
    """The page of the site."""
    return f"# Files\n\n```text\n{chr(10).join(lines())}\n```\n"


if __name__ == "__main__":
    print(*lines(), sep="\n")
