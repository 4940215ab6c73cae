"""``attitude geometry MISSION.toml``: what is seen of a body, from where and when, as a table."""

import sys

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
_TIMES = ("start", "stop", "step")


def add_arguments(parser):
    parser.add_argument("file", metavar="MISSION.toml", nargs="?", help="mission file")
    for name in _TIMES:
        parser.add_argument(f"--{name}", metavar="TIME", help=f"instead of the {name} in the file")
    parser.add_argument("--list", action="store_true", help="tell the columns there are, and stop")
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="x.csv or x.ecsv (default: CSV to standard output); appears whole or not at all",
    )


def run(arguments):
    if arguments.list:
        _list()
        return
    if arguments.file is None:
        raise AttitudeError('give a mission file; see "attitude geometry --help".')
    from attitude.cli.propagate import _kind
    from attitude.formats import mission as missions
    from attitude.formats.aside import written_whole

    kind = _kind(arguments.output)
    mission = missions.read(arguments.file)
    blocks = _blocks(mission, arguments)
    first = next(blocks)  # what cannot be computed is said before anything is written
    if arguments.output is None:
        _write(sys.stdout, kind, mission, first, blocks)
    else:
        with written_whole(arguments.output, "--output") as file:
            _write(file, kind, mission, first, blocks)


def _list():
    from attitude.scene import View

    for name, each in View.columns().items():
        unit = each.unit or "-"
        parts = f" ({', '.join(each.parts)})" if each.parts else ""
        print(f"{name:26}{unit:8}{each.about}{parts}")


def _blocks(mission, arguments):
    """Dates and columns of some rows at a time: (texts of UTC, lists of numbers)."""
    from attitude.formats import ccsds_epochs

    given = {name: getattr(arguments, name) for name in _TIMES}
    if "epochs" in mission.times and not any(given.values()):
        view = mission.scene.at(mission.times["epochs"])
        yield _dates(ccsds_epochs, view, 9), _numbers(mission, view)
        return
    times = {
        name: value if value is not None else mission.times.get(name)
        for name, value in given.items()
    }
    grid = _grid(mission, times, {name for name, value in given.items() if value is not None})
    for begin in range(0, grid.count, _BLOCK):
        hi, lo = grid.block(begin, _BLOCK)
        view = mission.scene.since(grid.epoch, hi, lo)
        yield _dates(ccsds_epochs, view, grid.digits), _numbers(mission, view)


def _dates(ccsds_epochs, view, digits):
    import numpy as np

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
        for name in set(_TIMES) - given:
            sentence = sentence.replace(f"--{name}", f"[times] {name}")
        raise AttitudeError(sentence) from err


def _numbers(mission, view):
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


def _write(file, kind, mission, first, blocks):
    file.write(_header(kind, mission))
    block = first
    while block is not None:
        (dates, seconds), lists = block
        pattern = "%s" + ",%r" * (1 + len(lists)) + "\n"
        file.write("".join([pattern % row for row in zip(dates, seconds, *lists, strict=True)]))
        block = next(blocks, None)


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
    import io

    from astropy.table import QTable
    from astropy.time import Time
    from astropy.units import Quantity

    from attitude.formats import measured

    # astropy writes the head of a table of one row; the rows are ours, as they come.
    table = QTable({"utc": Time(["2000-01-01T00:00:00"], format="isot", scale="utc", precision=9)})
    table["tdb_seconds"] = Quantity([0.0], "s")
    for name, unit, about in labels:
        is_flag = name.startswith("in_")
        table[name] = (
            Quantity([1.0], measured.unit_of(unit, name)) if unit else [1 if is_flag else 1.0]
        )
        table[name].info.description = about
    table.meta = {"frame": "ICRF", "scene": repr(mission.scene), "name": mission.name or ""}
    text = io.StringIO()
    table.write(text, format="ascii.ecsv", delimiter=",")
    return "".join(text.getvalue().splitlines(keepends=True)[:-1])
