"""The map of the package in docs/architecture.md, from the first lines of its docstrings.

    python docs/make_map.py

writes it between the two marks; `tests/house/test_docs.py` compares.
"""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "architecture.md"
BEGIN, END = "<!-- map -->\n", "<!-- end of the map -->\n"


def first_line(file):
    """The first line of a module's docstring, without its full stop."""
    return ast.get_docstring(ast.parse(file.read_text())).splitlines()[0].rstrip(".")


def lines(folder, depth=0):
    """The lines of a folder: its files, then its folders, each with what it holds."""
    indent = "  " * depth
    files = sorted(folder.glob("*.py"))
    for file in files:
        if file.name not in ("__init__.py", "__main__.py"):
            yield f"{indent}{file.stem:{26 - len(indent)}s} {first_line(file)}"
    for inner in sorted(each for each in folder.iterdir() if (each / "__init__.py").is_file()):
        yield f"{indent}{inner.name + '/':{26 - len(indent)}s} {first_line(inner / '__init__.py')}"
        yield from lines(inner, depth + 1)


def page(text):
    """The text of the page with a new map."""
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    tree = "\n".join(lines(ROOT / "attitude"))
    return f"{before}{BEGIN}```text\n{tree}\n```\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text()))
