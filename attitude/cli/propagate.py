"""``attitude propagate NAME|FILE.toml``: attitudes at equally spaced epochs as a table."""

from __future__ import annotations

import argparse

from attitude._support.blocks import ProgressBar
from attitude.cli import _options, _output
from attitude.errors import AttitudeError

HELP: str = "write a table of attitudes at equally spaced epochs"
EPILOG: str = """\
example:
  attitude propagate toutatis.toml --start 1992-12-01 --stop 1992-12-20 --step "1 h" \\
      --output toutatis.csv
  attitude propagate "4179 Toutatis" --stop "30 d" --step "6 h"

columns:
  utc            ISO date
  tdb_seconds    TDB seconds since the epoch of the spin file
  w x y z        attitude from body axes to ICRF, a quaternion with its scalar first
  omega_x _y _z  with --rates: angular velocity over the body axes, rad/s
  sigma_x _y _z  with --sigma: standard deviations of the attitude about the axes of ICRF, rad;
                 sigma_omega_x _y _z with --rates: of the angular velocity, rad/s

A mission file with sections [[torque]] is propagated under these torques.

--sigma needs the section [errors] of the spin file.

A date may end in the name of a time scale ("2026-01-01T00:00:00 TDB"). Steps, and times after the
epoch, are seconds of UTC, of TDB if the start is a date in TDB.

AEM, C-kernels and other formats are written by "attitude convert".
"""
# Rows computed and written in one block: the memory does not grow with the table.
_BLOCK = 16384


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    _options.add_target_arguments(parser)
    parser.add_argument(
        "--start",
        default="0",
        metavar="TIME",
        help='date (UTC), or seconds or a time such as "3 d" after the epoch (default: the epoch)',
    )
    parser.add_argument("--stop", required=True, metavar="TIME", help="last epoch, as --start")
    parser.add_argument(
        "--step", required=True, metavar="TIME", help='time between rows, such as "10 s" or "1 h"'
    )
    parser.add_argument(
        "--rates", action="store_true", help="write the angular velocity over the body axes too"
    )
    parser.add_argument(
        "--sigma",
        action="store_true",
        help="write the standard deviations that follow from the [errors] of the spin file too",
    )
    _output.add_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Write the table."""
    from attitude.cli import _output
    from attitude.cli._options import grid

    kind = _output.kind_of(
        arguments.output, hint="`attitude convert` writes AEM, C-kernels and other formats."
    )
    motion = _options.motion_of(arguments)
    epochs = grid(motion.spin.epoch, arguments.start, arguments.stop, arguments.step)
    if arguments.sigma and motion.spin.covariance is None:
        raise AttitudeError(
            f"{arguments.target} has no section [errors], from which --sigma follows; give it, for "
            'example with attitude = "1 deg".'
        )
    columns = {"rates": arguments.rates, "sigma": arguments.sigma}
    # An epoch out of reach is refused before a row is written.
    _output.rows(epochs, motion, epochs.count - 1, 1, **columns)
    with _output.opened(arguments.output) as file:
        file.write(_output.header(kind, motion, **columns))
        progress = ProgressBar("attitudes")
        for first in range(0, epochs.count, _BLOCK):
            file.write(_output.rows(epochs, motion, first, _BLOCK, **columns))
            progress(min(first + _BLOCK, epochs.count), epochs.count)
