"""``attitude propagate``, ``attitude evolve``: attitudes at epochs, mean rotations over years."""

from __future__ import annotations

import argparse
import os
import re
import warnings
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.blocks import ProgressBar
from attitude._support.constants import DAY_S
from attitude.cli import _options, _output
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.errors import AttitudeError, AttitudeWarning

if TYPE_CHECKING:
    from attitude.averaged import AveragedHistory, AveragedMotion
    from attitude.cli._options import Grid
    from attitude.epochs._instants import Instant
    from attitude.torques._torqued import TorquedRotation

HELP: dict[str, str] = {
    "propagate": "write a table of attitudes at equally spaced epochs",
    "evolve": "write and draw the mean rotation under torques over months and years",
}
EPILOG: dict[str, str] = {
    "propagate": """\
example:
  attitude propagate toutatis.toml --start 1992-12-01 --stop 1992-12-20 --step "1 h" \\
      --output attitudes.csv
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
""",
    "evolve": """\
example:
  attitude evolve data/mission/goes-like.toml --until 2040-01-01 --output spin.csv --figure spin.png
  attitude evolve data/mission/goes-like.toml --until "2 yr" --passages all

The file is a mission file with a spin and sections [[torque]]; observer, columns and times are not
needed. Torques are averaged over nutation and precession (docs/averaged.md): attitudes are not
known, momentum and mode are.

columns:
  utc, tdb_seconds  ISO date, empty beyond the year 9999; TDB seconds since the epoch of the spin
  branch, odds      with --passages all: number of the branch, and its odds
  mode, end         SAM or LAM; + or -, the end of the circulated axis that the momentum is near
  momentum_x _y _z  angular momentum over the axes of ICRF, N m s
  theta             angle between momentum and short axis where the middle axis is across, rad
  energy            kinetic energy, J
  P_psi, P_phi      periods of nutation and of the long axis about the momentum, s
  weakness          |N| P / (2 pi |L|); means err by about this share of what changes, under
                    light by more (docs/averaged.md, limits)

With --output FILE passages of the separatrix, uniform rotation reached and left, and resonances are
listed on standard output. A mean motion ends where the torques are no longer weak, or where the
body turns too slowly for its path; the table then ends there, with a warning.
""",
}
# Rows computed and written in one block: the memory does not grow with the table.
_BLOCK = 16384
# Seconds of the steps of a table without --step.
_STEPS = (
    *(1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 10800, 21600, 43200),
    *(int(DAY_S) * factor * 10**power for power in range(7) for factor in (1, 2, 5)),
)
_ROWS = 1000
_MOST_ROWS = 1_000_000


def add_arguments(parser: argparse.ArgumentParser, command: str) -> None:
    """Add the options of one of both commands."""
    if command == "evolve":
        _add_arguments_of_evolve(parser)
        return
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


def _add_arguments_of_evolve(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="MISSION.toml", help="mission file with [[torque]]")
    parser.add_argument(
        "--until",
        required=True,
        metavar="TIME",
        help='last epoch: a date (UTC), or a time such as "20 yr" after the epoch of the spin',
    )
    parser.add_argument(
        "--step",
        metavar="TIME",
        help='time between rows, such as "10 d" (default: for at most 1000 rows)',
    )
    parser.add_argument(
        "--passages",
        default="likeliest",
        metavar="WORD",
        help="at the separatrix: likeliest (the default), all (every branch, with its odds), or a "
        "whole number, the seed of a draw",
    )
    parser.add_argument(
        "--least-tilt",
        default="0.01 deg",
        metavar="ANGLE",
        help="the greatest nutation to which damping may lead (0.01 deg)",
    )
    parser.add_argument(
        "--paths",
        default="auto",
        choices=("auto", "averaged", "followed"),
        help="average torques over the turn of their path, or follow it (auto: as they are weak)",
    )
    parser.add_argument(
        "--order",
        type=int,
        default=1,
        choices=(1, 2),
        help="means of first (the default) or second order in the torques: 2 follows all paths",
    )
    _output.add_figure(parser)
    _output.add_argument(parser, exception=", none with --figure alone")


def run(arguments: argparse.Namespace, command: str) -> None:
    """Write the table."""
    if command == "evolve":
        _evolve(arguments)
        return
    kind = _output.kind_of(
        arguments.output, hint="`attitude convert` writes AEM, C-kernels and other formats."
    )
    motion = _options.motion_of(arguments)
    epochs = _options.grid(motion.spin.epoch, arguments.start, arguments.stop, arguments.step)
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


# ---- The mean rotation


def _evolve(arguments: argparse.Namespace) -> None:
    """Compute the mean rotation of a mission file, then write table and figure together."""
    from attitude._textfiles.atomic_write import written_whole
    from attitude.averaged import AveragedMotion

    kind = _output.kind_of(arguments.output)
    picture = _output.picture_of(arguments)
    full, passages = _torqued(arguments)
    epochs = _epochs(full.spin.epoch, arguments)
    motion = AveragedMotion(
        full.body,
        full.spin,
        full.torques,
        orbit=arguments.paths,
        passages=passages,
        least_tilt=validation.number(arguments.least_tilt, "--least-tilt", unit="rad"),
        order=arguments.order,
    )
    hi, low = epochs.block(0, epochs.count)
    last = _last(motion, float(hi[-1] + low[-1]))
    count = int(np.count_nonzero(np.abs(hi + low) <= abs(last)))
    states = motion.at(hi[:count] + low[:count])
    text = figure = None
    if arguments.output is not None or picture is None:
        text = _text_of(states, epochs, kind)
    if picture is not None:
        stem = os.path.splitext(os.path.basename(arguments.file))[0]
        label = _options.content_of_mission(arguments.file).get("name") or stem
        figure = motion.plot(until=last, title=f"{label}\nmean rotation under torques")
    with ExitStack() as files:
        if text is not None:
            files.enter_context(_output.opened(arguments.output)).write(text)
        if figure is not None:
            file = files.enter_context(written_whole(arguments.figure, "--figure", binary=True))
            figure.savefig(file, format=picture, dpi=130)
    if arguments.output is not None:
        _print_events(motion, last)


def _torqued(arguments: argparse.Namespace) -> tuple[TorquedRotation, Any]:
    """The motion of a mission file under its torques, and the choice at the separatrix."""
    from attitude.formats import mission
    from attitude.torques._torqued import TorquedRotation

    passages: Any = arguments.passages
    if passages.isascii() and passages.isdigit():
        passages = int(passages)
    elif passages not in ("likeliest", "all"):
        raise AttitudeError(
            f"--passages is {passages!r}; give likeliest, all, or a whole number, the seed of a "
            "draw."
        )
    if arguments.order == 2 and arguments.paths == "averaged":
        raise AttitudeError(
            "--order 2 follows the paths of torques, and --paths is averaged; give --paths "
            "followed, or --order 1."
        )
    full = mission.read_motion(arguments.file)
    if not isinstance(full, TorquedRotation):
        raise AttitudeError(
            f"{arguments.file} has no sections [[torque]], without which nothing evolves; give "
            'them, as in [[torque]] kind = "gravity_gradient".'
        )
    return full, passages


def _epochs(start: Instant, arguments: argparse.Namespace) -> Grid:
    """The epochs of the rows, from the epoch of the spin."""
    until, step = arguments.until, arguments.step
    if re.fullmatch(r"\s*\d{4}\s*", until):
        raise AttitudeError(f'--until is {until}; give a date, "{until}-01-01", or "{until} s".')
    is_far = _options.is_beyond_dates(start, until, "--until")
    if is_far:
        span = float(_options.duration(until, "--until"))
    else:
        span = _options.one(start, until, "--until").since(start)
    if span == 0.0:
        raise AttitudeError("--until is the epoch of the spin; give another epoch.")
    if step is None:
        least = abs(span) / _ROWS
        step = f"{next((seconds for seconds in _STEPS if seconds >= least), _STEPS[-1])} s"
    ahead = step.strip().lstrip("+-")
    pace = f"-{ahead}" if span < 0.0 else ahead
    times = _options.grid(start, "0", until, pace, is_far=is_far)
    if times.count > _MOST_ROWS:
        raise AttitudeError(
            f"--step {step} makes {times.count} rows, more than {_MOST_ROWS}; take a longer step."
        )
    return times


def _last(motion: AveragedMotion, until: float) -> float:
    """Seconds up to which the motion goes, with a warning where it ends before `until`."""
    if motion.passages == "all":
        return until
    last = motion.reaches(until)
    if last != until:
        end = motion.events[-1 if until > 0.0 else 0]
        date = _date(motion, last)
        warnings.warn(
            f"the mean motion ends at {date} UTC, {end.kind}; the table and the figure end there.",
            AttitudeWarning,
            stacklevel=2,
        )
    return last


def _columns(states: AveragedHistory) -> dict[str, tuple[Any, str]]:
    """Columns of rows (N,), or of branches and rows (B N,), each with its unit."""
    ends = np.array(["+", "-", "+", "-"])
    columns: dict[str, tuple[Any, str]] = {}
    if states.seconds.ndim == 2:
        number = np.broadcast_to(np.arange(1, len(states) + 1)[:, None], states.seconds.shape)
        columns["branch"] = number, ""
        columns["odds"] = np.broadcast_to(states.odds[:, None], states.seconds.shape), ""
    columns["mode"] = states.mode, ""
    columns["end"] = ends[states.region], ""
    for k, name in enumerate(("momentum_x", "momentum_y", "momentum_z")):
        columns[name] = states.momentum[..., k], "N m s"
    columns["theta"] = states.theta, "rad"
    columns["energy"] = states.energy, "J"
    columns["P_psi"], columns["P_phi"] = (states.P_psi, "s"), (states.P_phi, "s")
    columns["weakness"] = states.weakness, ""
    return {name: (np.ravel(values), unit) for name, (values, unit) in columns.items()}


def _text_of(states: AveragedHistory, epochs: Grid, kind: str) -> str:
    """The table as CSV or ECSV; numbers are read back as the same doubles."""
    hi, low = epochs.block(0, states.seconds.shape[-1])
    repeated = states.seconds.size // len(hi)
    dated = _options.has_date(epochs.epoch.seconds + hi)
    dates = ccsds_epochs.texts(epochs.epoch, hi[dated], low[dated], "utc", epochs.digits)
    dates = [*dates, *[""] * int(np.sum(~dated))] * repeated
    columns = {"tdb_seconds": (np.tile(hi, repeated), "s"), **_columns(states)}
    if kind == "csv":
        rows = [dates, *(values.tolist() for values, _ in columns.values())]
        lines = [",".join(map(str, row)) for row in zip(*rows, strict=True)]
        return "\n".join([",".join(["utc", *columns]), *lines, ""])
    meta = {"frame": "ICRF", "epoch": f"{epochs.epoch.utc_iso} UTC"}
    return _output.ecsv(dates, {name: (*column, None) for name, column in columns.items()}, meta)


def _print_events(motion: AveragedMotion, last: float) -> None:
    """A line for each event, or for each branch."""
    if motion.passages == "all":
        for number, branch in enumerate(motion.branches(last), start=1):
            print(f"branch {number}, odds {branch.odds:.4g}: {' '.join(branch.regions)}")
        return
    for event in motion.events:
        print(f"{_date(motion, event.seconds)} {event}")


def _date(motion: AveragedMotion, seconds: float) -> str:
    """The date in UTC to a second, or text where the calendar ends."""
    return re.sub(r"\.\d+$", "", motion.epoch.after(seconds).utc_iso)
