"""``attitude describe NAME|FILE.toml``: mode, periods, momentum and energy of a motion as text."""

from __future__ import annotations

import argparse
import textwrap

from attitude.cli import _options

HELP: str = "print mode, periods, momentum and energy of a spin file or a catalogued body"
EPILOG: str = """\
example:
  attitude describe toutatis.toml
  attitude describe "1P/Halley"

With a section [errors] in the spin file each number has its error of one standard deviation.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    _options.add_target_arguments(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the description; of an incomplete entry of the catalogue, the entry."""
    from attitude.motions._description import description

    entry = _options.incomplete(arguments)
    if entry is not None:
        print(entry)
        return
    found = _options.opened(arguments)
    for label in (found.label, found.source, found.note):
        if label:
            print(textwrap.fill(" ".join(label.split()), 98))
    if found.name or found.source or found.note:
        print()
    print(description(found.motion, predictable=True))
