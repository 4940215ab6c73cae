"""``attitude geometry MISSION.toml``: the observing geometry of a body as a table."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import IO, TYPE_CHECKING, Any

from attitude._support.blocks import ProgressBar
from attitude.cli import _options, _output
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.formats.mission import Mission
    from attitude.scene._view import View


HELP: str = "write the columns of a mission file: phase angle, directions, distances, ..."
EPILOG: str = """\
example:
  attitude geometry envisat-pass.toml --output pass.csv

A mission file names spin, centre, observer, times and columns; data/mission/ has examples. The
first column is the UTC at which light is received, the second the TDB seconds since the epoch of
the spin (or since the first row, where there is no spin). Without a unit in its name a column is
in SI units or radians. "attitude geometry --list" prints the columns there are.
"""
# Rows computed and written in one block: the memory does not grow with the table.
_BLOCK = 65536
# Options of the command line and keys of [times].
TIMES: tuple[str, ...] = ("start", "stop", "step")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="MISSION.toml", nargs="?", help="mission file")
    for name in TIMES:
        parser.add_argument(f"--{name}", metavar="TIME", help=f"replaces the {name} of the file")
    parser.add_argument("--list", action="store_true", help="print the columns there are, and exit")
    _output.add_argument(parser)


def run(arguments: argparse.Namespace) -> None:
    """Write the table, or print the columns."""
    if arguments.list:
        _options.refuse(arguments, (*TIMES, "output"), "--list")
        _list()
        return
    if arguments.file is None:
        raise AttitudeError('give a mission file; see "attitude geometry --help".')
    from attitude.formats import mission as formats_mission

    kind = _output.kind_of(arguments.output)
    mission = formats_mission.read(arguments.file)
    if not mission.columns:
        raise AttitudeError(
            f"{arguments.file}: columns is missing; give a list of quantities, such as "
            '["phase_angle deg"], from those that `attitude geometry --list` prints.'
        )
    views_of_blocks = views(mission, arguments, _BLOCK, ProgressBar("geometry"))
    blocks = ([*dates(view, digits), *numbers(mission, view)] for view, digits in views_of_blocks)
    first = next(blocks)  # errors are raised before a row is written
    with _output.opened(arguments.output) as file:
        write(file, kind, mission, first, blocks)


def _list() -> None:
    """Print the columns that a mission file may name."""
    from attitude.scene._view import View

    columns = View.columns()
    width = max(map(len, columns)) + 1
    for name, column in columns.items():
        unit = column.unit or "-"
        parts = f" ({', '.join(column.parts)})" if column.parts else ""
        print(f"{name:{width}}{unit:8}{column.about}{parts}")


def views(
    mission: Mission,
    arguments: argparse.Namespace,
    size: int,
    progress: Callable[[int, int], None],
) -> Iterator[tuple[View, int]]:
    """Views of blocks of epochs, each with the decimals of a second that its dates need."""
    choices = {name: getattr(arguments, name) for name in TIMES}
    if "epochs" in mission.times and not any(choices.values()):
        yield mission.scene.at(mission.times["epochs"]), 9
        return
    grid = _grid(mission, {name: value for name, value in choices.items() if value is not None})
    for begin in range(0, grid.count, size):
        yield mission.scene.since(grid.epoch, *grid.block(begin, size)), grid.digits
        progress(min(begin + size, grid.count), grid.count)


def dates(view: View, digits: int) -> tuple[list[str], list[float]]:
    """The first two columns of a view: texts of UTC with `digits` decimals, and TDB seconds."""
    from attitude.epochs import _ccsds as ccsds_epochs

    texts = ccsds_epochs.texts(view.epoch, view.seconds, view.low, "utc", digits)
    return texts, view.seconds.tolist()


def _grid(mission, options):
    """The Grid of start, stop and step, of which some are given on the command line."""
    times = {name: options.get(name, mission.times.get(name)) for name in TIMES}
    missing = [name for name, value in times.items() if value is None]
    if missing:
        raise AttitudeError(
            f"the file has no {missing[0]}; give it there, in [times], or as --{missing[0]}."
        )
    epoch = mission.scene.epoch
    if epoch is None:
        from attitude.epochs import _inputs

        epoch = _inputs.instant(times["start"], "start")
    try:
        return _options.grid(epoch, *times.values())
    except AttitudeError as err:
        sentence = str(err)
        for name in set(TIMES) - options.keys():
            sentence = sentence.replace(f"--{name}", f"[times] {name}")
        raise AttitudeError(sentence) from err


def numbers(mission: Mission, view: View) -> list[list[float]]:
    """The columns of a view as lists, in the order and units of the mission."""
    lists = []
    for column in mission.columns:
        value = getattr(view, column.name)
        rows = [value] if value.ndim == 1 else [value[:, k] for k in range(value.shape[1])]
        if value.dtype == bool:
            rows = [row.astype(int) for row in rows]
        elif column.factor != 1.0:
            rows = [row * column.factor for row in rows]
        lists += [row.tolist() for row in rows]
    return lists


def write(
    file: IO[str], kind: str, mission: Mission, first: list[Any], blocks: Iterable[list[Any]]
) -> None:
    """Write the table of a mission, "csv" or "ecsv", whose `first` block is computed already."""
    from attitude.formats import tables

    file.write(_header(kind, mission))
    for block in chain([first], blocks):
        file.write(tables.text(*block))


def _header(kind, mission):
    from attitude.scene._view import View

    known = View.columns()
    # CSV has no description: the part is in the name.
    labels = [
        (f"{one.name}_{axis}" if axis else one.name, one.unit, known[one.name].about)
        for one in mission.columns
        for axis in known[one.name].parts or ("",)
    ]
    if kind == "csv":
        names = [f"{name} [{unit}]" if unit else name for name, unit, _ in labels]
        return ",".join(["utc", "tdb_seconds", *names]) + "\n"
    meta = {"frame": "ICRF", "scene": repr(mission.scene), "name": mission.name or ""}
    return _output.head([("tdb_seconds", "s", None), *labels], meta)
