"""``attitude describe NAME|FILE``: a motion as text; ``attitude catalog``: the published states."""

from __future__ import annotations

import argparse
import textwrap

from attitude.cli import _options, _output

HELP: dict[str, str] = {
    "describe": "print mode, periods, momentum and energy of a spin file or a catalogued body",
    "catalog": "list the published spin states that the package holds, or print one with sources",
}
EPILOG: dict[str, str] = {
    "describe": """\
example:
  attitude describe toutatis.toml
  attitude describe "1P/Halley"
  attitude describe toutatis --epoch 2029-04-13

With a section [errors] in the spin file each number has its error of one standard deviation.
""",
    "catalog": """\
examples:
  attitude catalog
  attitude catalog apophis

Names, or parts of them, are what other commands take in place of a spin file. What an entry lacks
is given by options, such as --phi0.
""",
}


def add_arguments(parser: argparse.ArgumentParser, command: str) -> None:
    """Add the options of one of both commands."""
    if command == "describe":
        _options.add_target_arguments(parser)
    else:
        parser.add_argument("name", metavar="NAME", nargs="?", help="of a body, or a part of it")


def run(arguments: argparse.Namespace, command: str) -> None:
    """Print a description or the catalogue."""
    _output.require_open()
    if command == "describe":
        _describe(arguments)
    else:
        _list(arguments.name)


def _list(name: str | None) -> None:
    """Print a line for each entry of the catalogue, or the entries of a name with their sources."""
    from attitude import catalog

    if name is not None:
        body = catalog.entry(name).name.partition(" (")[0]
        same = [title for title in catalog.names() if title.partition(" (")[0] == body]
        print("\n\n".join(str(catalog.entry(title)) for title in same))
        return
    entries = [catalog.entry(title) for title in catalog.names()]
    width = max(len(entry.name) for entry in entries)
    for entry in entries:
        lacking = f"lacks {', '.join(entry.missing)}" if entry.missing else "complete"
        print(f"{entry.name:{width}}  {entry.year}  {entry.mode or '-':3}  {lacking}")


def _describe(arguments: argparse.Namespace) -> None:
    """Print the description; of an incomplete entry of the catalogue, the entry."""
    from attitude.motions._description import description

    entry = _options.incomplete(arguments)
    if entry is not None:
        print(entry)
        return
    state, label = _options.opened(arguments)
    said = description(state.motion, predictable=True)  # its errors come before any output
    for text in (label, state.source, state.note):
        if text:
            print(textwrap.fill(" ".join(text.split()), 98))
    print()
    print(said)
