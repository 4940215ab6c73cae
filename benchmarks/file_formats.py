"""Which formats of attitude files are there?

    python benchmarks/all.py file_formats

remakes the tables of docs/formats.md from the registry of formats.
"""

import inspect

from attitude.formats import formats
from benchmarks.doc_tables import Table, markdown

MAKES = ("file formats", "keywords of writers")
_HELD = {
    "records": "attitudes at epochs",
    "motion": "a free rotation",
    "span": "attitudes at any epoch of a span",
}


def tables(quick):
    """The tables of docs/formats.md, a row for each format (XML has the keywords of KVN)."""
    rows = [
        (
            entry.title,
            f"`{entry.module.rpartition('.')[2]}`",
            code(entry.endings),
            _HELD[entry.holds],
            code(entry.reading),
        )
        for entry in formats().values()
    ]
    head = ("format", "module", "endings", "holds", "keywords")
    yield Table("file formats", markdown(head, rows))
    written = [
        (entry.title, code(name for name in [*inspect.signature(entry.write).parameters][2:]))
        for entry in formats().values()
        if not entry.name.endswith("-xml")
    ]
    yield Table("keywords of writers", markdown(("format", "keywords of `write`"), written))


def code(words):
    """Words as code, with commas between them."""
    return ", ".join(f"`{word}`" for word in words)
