"""``attitude describe NAME|FILE.toml``: a motion in words and figures."""

import textwrap

from attitude.cli import target

HELP = "tell mode, periods, momentum and energy of a spin file or a catalogued body"
EPILOG = """\
example:
  attitude describe toutatis.toml
  attitude describe "1P/Halley"
"""


def add_arguments(parser):
    target.add_arguments(parser)


def run(arguments):
    from attitude.free_rotation.description import description

    entry = target.incomplete(arguments)
    if entry is not None:
        print(entry)
        return
    found = target.opened(arguments)
    for label in (found.name, found.source, found.note):
        if label:
            print(textwrap.fill(" ".join(label.split()), 98))
    if found.name or found.source or found.note:
        print()
    print(description(found.motion))
