"""``attitude plot NAME|FILE.toml``: a figure of a motion in four plots."""

from __future__ import annotations

import argparse
import os
import re

from attitude.cli import _options, _output

HELP: str = "draw a motion: polhode, body axes on the sky, rates and angles against time"
EPILOG: str = """\
example:
  attitude plot toutatis --output toutatis.png
  attitude plot "99942 Apophis (2014)" --phi0 "0 deg" --psi0 "0 deg" --epoch 2012-12-23
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    _options.add_target_arguments(parser)
    parser.add_argument(
        "--span", metavar="TIME", help='time to show, such as "20 d" (default: three slow turns)'
    )
    parser.add_argument(
        "--sky", default="ecliptic", metavar="FRAME", help="coordinates of the sky (ecliptic)"
    )
    kinds = ", ".join(_output.PICTURES)
    parser.add_argument(
        "--output",
        metavar="FILE",
        help=f"figure, its format by its ending: {kinds} (default: NAME.png)",
    )


def run(arguments: argparse.Namespace) -> None:
    """Draw the figure, write it to a file and print the name of the file."""
    from attitude import plots
    from attitude._support import validation

    state, label = _options.opened(arguments)
    name = arguments.output or _file_name(state.name or "", arguments.target)
    _output.kind_of(name, _output.PICTURES)
    span = None
    if arguments.span is not None:
        span = validation.real(arguments.span, "--span", unit="s")
    figure = plots.overview(state.motion, span=span, frame=arguments.sky, title=label)
    plots.saved(figure, name, dpi=150.0)
    print(name)


def _file_name(name: str, file_or_entry: str) -> str:
    """A PNG in the working directory, named after the entry of the catalogue or the file."""
    if _options.is_file(file_or_entry):
        name = re.sub(r"\.(toml|spin|apm|xml)$", "", os.path.basename(file_or_entry))
    words = "".join(letter if letter.isalnum() else " " for letter in name.lower()).split()
    return "-".join(words) + ".png"
