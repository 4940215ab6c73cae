"""``attitude geometry MISSION.toml``: what is seen of a body, from where and when, as a table."""

from itertools import chain

from attitude.cli import output
from attitude.errors import AttitudeError

HELP = "write what a mission file asks for: phase angle, directions, distances, ..."
EPILOG = """\
example:
  attitude geometry envisat-pass.toml --output pass.csv

A mission file names spin, centre, observer, times and columns; data/mission/ has examples. The
first column is the UTC at which light is received, the second the TDB seconds since the epoch of
the spin (or since the first row, where there is no spin). Without a unit in its name a column is
in SI units or radians. "attitude geometry --list" tells the columns.
"""
# Rows that are made and written at a time: long tables need no more memory than short ones.
_BLOCK = 65536
TIMES = ("start", "stop", "step")


def add_arguments(parser):
    parser.add_argument("file", metavar="MISSION.toml", nargs="?", help="mission file")
    for name in TIMES:
        parser.add_argument(f"--{name}", metavar="TIME", help=f"instead of the {name} in the file")
    parser.add_argument("--list", action="store_true", help="tell the columns there are, and stop")
    output.add_argument(parser)


def run(arguments):
    if arguments.list:
        _list()
        return
    if arguments.file is None:
        raise AttitudeError('give a mission file; see "attitude geometry --help".')
    from attitude.formats import mission as missions

    kind = output.kind_of(arguments.output)
    mission = missions.read(arguments.file)
    blocks = _blocks(mission, arguments)
    first = next(blocks)  # what cannot be computed is said before anything is written
    with output.opened(arguments.output) as file:
        write(file, kind, mission, first, blocks)


def _list():
    from attitude.scene import View

    for name, each in View.columns().items():
        unit = each.unit or "-"
        parts = f" ({', '.join(each.parts)})" if each.parts else ""
        print(f"{name:26}{unit:8}{each.about}{parts}")


def _blocks(mission, arguments):
    """Columns of some rows at a time: texts of UTC, then lists of numbers."""
    for view, digits in views(mission, arguments, _BLOCK):
        yield [*dates(view, digits), *numbers(mission, view)]


def views(mission, arguments, size, told=None):
    """(View, decimals of a second) of some epochs at a time, those of the command line first.

    `told`, if given, is called with the number of epochs that are done, and that of all.
    """
    given = {name: getattr(arguments, name) for name in TIMES}
    if "epochs" in mission.times and not any(given.values()):
        yield mission.scene.at(mission.times["epochs"]), 9
        return
    times = {
        name: value if value is not None else mission.times.get(name)
        for name, value in given.items()
    }
    grid = _grid(mission, times, {name for name, value in given.items() if value is not None})
    for begin in range(0, grid.count, size):
        yield mission.scene.since(grid.epoch, *grid.block(begin, size)), grid.digits
        if told is not None:
            told(min(begin + size, grid.count), grid.count)


def dates(view, digits):
    """The first two columns of a view: texts of UTC, and a list of TDB seconds."""
    import numpy as np

    from attitude.formats.ccsds import epochs as ccsds_epochs

    hi, lo = view.seconds, np.zeros(view.shape) if view.low is None else view.low
    return ccsds_epochs.texts(view.epoch, hi, lo, "utc", digits), hi.tolist()


def _grid(mission, times, given):
    """The Grid of three texts; `given` are the names of those on the command line."""
    from attitude.cli import grid

    missing = [name for name, value in times.items() if value is None]
    if missing:
        raise AttitudeError(f"--{missing[0]} is not given, in the file neither; give it.")
    epoch = mission.scene.epoch
    if epoch is None:
        from attitude import epochs

        epoch = epochs.instant(times["start"], "start")
    try:
        return grid.grid(epoch, *times.values())
    except AttitudeError as err:
        sentence = str(err)
        for name in set(TIMES) - given:
            sentence = sentence.replace(f"--{name}", f"[times] {name}")
        raise AttitudeError(sentence) from err


def numbers(mission, view):
    """The columns of a view as lists, in the order and units of the mission."""
    lists = []
    for each in mission.columns:
        value = getattr(view, each.name)
        rows = [value] if value.ndim == 1 else [value[:, k] for k in range(value.shape[1])]
        if value.dtype == bool:
            rows = [row.astype(int) for row in rows]
        elif each.factor != 1.0:
            rows = [row * each.factor for row in rows]
        lists += [row.tolist() for row in rows]
    return lists


def write(file, kind, mission, first, blocks):
    """Write the table of the columns of a mission, whose first block is made already."""
    from attitude.formats import csv_rows

    file.write(_header(kind, mission))
    for block in chain([first], blocks):
        file.write(csv_rows.text(*block))


def _labels(mission):
    """Name, unit and description of each column of numbers."""
    from attitude.scene import View

    known = View.columns()
    # In CSV only the name can tell the part.
    return [
        (f"{each.name}_{part}" if part else each.name, each.unit, known[each.name].about)
        for each in mission.columns
        for part in known[each.name].parts or ("",)
    ]


def _header(kind, mission):
    labels = _labels(mission)
    if kind == "csv":
        names = [f"{name} [{unit}]" if unit else name for name, unit, _ in labels]
        return ",".join(["utc", "tdb_seconds", *names]) + "\n"
    from astropy.units import Quantity

    from attitude.cli import table
    from attitude.textfiles import quantities

    row = table.first_row("2000-01-01T00:00:00")
    for name, unit, about in labels:
        is_flag = name.startswith("in_")
        row[name] = (
            Quantity([1.0], quantities.unit_of(unit, name)) if unit else [1 if is_flag else 1.0]
        )
        row[name].info.description = about
    row.meta = {"frame": "ICRF", "scene": repr(mission.scene), "name": mission.name or ""}
    return table.head(row)
