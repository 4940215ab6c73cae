"""The page: one HTML file with the library three.js, the viewer's own scripts and its data."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

from attitude.textfiles import json_text, lines

FOLDER: Path = Path(__file__).resolve().parent / "page"
# The viewer's scripts, in the order in which they are joined: each uses those before it.
SCRIPTS: tuple[str, ...] = (
    *("bytes", "poses", "clock", "surface", "labels", "arrows", "poinsot", "stage"),
    *("quality", "views", "curve", "panel", "keys", "main"),
)


def page(data: dict[str, Any]) -> str:
    """The HTML of a page from the value of `page_data.content`."""
    parts = {
        "title": html.escape(data["title"]),
        "style": _text("style.css"),
        "licence": html.escape(f"three.js {version()}: {_text('three/LICENSE')}"),
        "three": _text("three/three.min.js"),
        "data": json_text.within_script(data),
        "script": script(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found.group(1)], _text("viewer.html"))


def script() -> str:
    """The scripts as one: without the lines that import, and the word export."""
    joined = []
    for name in SCRIPTS:
        text = _text(f"{name}.js")
        text = re.sub(r"^import .*;\n", "", text, flags=re.MULTILINE)
        joined.append(re.sub(r"^export ", "", text, flags=re.MULTILINE))
    return "\n".join(joined)


def version() -> str:
    """The release of three.js in the package."""
    return _text("three/VERSION").strip()


def _text(name: str) -> str:
    return lines.whole(str(FOLDER / name), "install the package again")
