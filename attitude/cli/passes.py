"""``attitude passes``, ``attitude glints``: what an observer sees of a mission file, as a table."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from attitude.cli import _options, _output
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.events._windows import Timetable

HELP: dict[str, str] = {
    "passes": "list the passes of a satellite over a ground site",
    "glints": "list the glints of the flat sides of a body: when, which, how bright",
}
_TIMES = """\
--start and --stop are dates (UTC) or times after the epoch of the spin; by default those of the
file. Times are UTC at which light is received. As x.csv or x.ecsv columns name their units.
"""
EPILOG: dict[str, str] = {
    "passes": f"""\
examples:
  attitude passes data/mission/envisat-pass.toml --start 2013-10-23 --stop 2013-10-24
  attitude passes --orbit data/paths/envisat-2013.tle --site "15.4933, 47.0671 deg" \\
      --start 2013-10-23 --stop 2013-10-24
  attitude passes data/mission/envisat-pass.toml --start 2013-10-23 --stop 2013-10-24 \\
      --elevation "1 deg" --sunlit --night "-6 deg" --output passes.csv

Columns: rise, culmination and set with azimuths, greatest elevation, distance and elevation of the
Sun at culmination; with --sunlit or --night also from when until when the satellite is visible.
{_TIMES}""",
    "glints": f"""\
examples:
  attitude glints data/mission/envisat-glints.toml --start 2013-10-23T20:40 --stop 2013-10-23T21:10
  attitude glints data/mission/envisat-glints.toml --side "body -y" --side "body +y" --all

Columns: side, start, peak and stop of the glint, magnitude of the whole body at the peak, angle off
the mirror direction, phase angle, share of the Sun's disc, elevation. The mission file needs a mesh
([shape]) and materials with a specular part ([scattering.materials]). --all lists also those in
shadow, below the horizon and by day.
{_TIMES}""",
}


def add_arguments(parser: argparse.ArgumentParser, command: str) -> None:
    """Add the options of one of both commands."""
    nargs = "?" if command == "passes" else None
    parser.add_argument("file", metavar="MISSION.toml", help="mission file", nargs=nargs)
    for name in ("start", "stop"):
        parser.add_argument(f"--{name}", metavar="TIME", help=f"replaces the {name} of the file")
    if command == "passes":
        _options.add_orbit_arguments(parser, "in place of the file: the path of the satellite")
        _options.add_site_argument(parser)
        parser.add_argument(
            "--elevation", default="0 deg", metavar="ANGLE", help="least elevation (0 deg)"
        )
        parser.add_argument(
            "--sunlit", action="store_true", help="passes in which the satellite is sunlit"
        )
        parser.add_argument(
            "--night", metavar="ANGLE", help='with the Sun lower than this, such as "-6 deg"'
        )
    else:
        parser.add_argument(
            "--side", action="append", metavar="NAME", help="a flat side; may be repeated (all)"
        )
        parser.add_argument(
            "--fraction",
            type=float,
            default=0.1,
            metavar="PART",
            help="a side glints while its lobe exceeds this part of its peak (0.1)",
        )
        parser.add_argument("--all", action="store_true", help="also those that nobody sees")
    parser.add_argument("--output", metavar="FILE", help="x.csv or x.ecsv (default: a text table)")


def run(arguments: argparse.Namespace, command: str) -> None:
    """Search, and print or write the table."""
    from attitude import events

    kind = _output.kind_of(arguments.output)
    mission = _mission(arguments, command)
    ends = [_end(mission, arguments, name, place) for name, place in (("start", 0), ("stop", -1))]
    timetable: Timetable
    if command == "passes":
        timetable = events.passes(
            mission.scene,
            *ends,
            elevation=arguments.elevation,
            sunlit=arguments.sunlit,
            night=arguments.night,
        )
    else:
        timetable = events.glints(
            mission.scene,
            *ends,
            sides=arguments.side,
            fraction=arguments.fraction,
            visible=not arguments.all,
        )
    count = len(timetable)
    one = {"passes": "pass", "glints": "glint"}[command]
    counted = f"{count or 'no'} {one if count == 1 else command}"
    if arguments.output is not None:
        _output.write_table(timetable.table(), arguments.output, kind)
        print(f"{arguments.output}: {counted}")
    elif count:
        print(timetable)
    else:
        start, stop = (end.utc_iso[:19] for end in ends)
        print(f"{counted} from {start} to {stop} UTC.")


def _mission(arguments, command):
    """The mission of the file, or of --orbit and --site."""
    from attitude.formats import mission as formats_mission
    from attitude.scene._scene import Scene

    options = ("orbit", "orbit_of", "site") if command == "passes" else ()
    if arguments.file is not None:
        _options.refuse(arguments, options, "a mission file, which names center and observer")
        return formats_mission.read(arguments.file)
    path, site = _options.path_of(arguments), _options.site_of(arguments)
    if path is None or site is None:
        raise AttitudeError(
            "there is no satellite or no site; give a mission file, or --orbit and --site."
        )
    return formats_mission.Mission(Scene(None, path, site), {}, ())


def _end(mission, arguments, name, place):
    """The start or stop of the search: that of the option, else of the file."""
    option, dates = getattr(arguments, name), mission.times.get("epochs")
    text = option or mission.times.get(name) or (dates[place] if dates else None)
    if text is None:
        raise AttitudeError(f"the {name} of the search is not known; give --{name}.")
    said = f"--{name}" if option else f"[times] {name}"
    if mission.scene.epoch is None:
        from attitude.epochs import _inputs

        return _inputs.instant(str(text), said)
    return _options.one(mission.scene.epoch, str(text), said)
