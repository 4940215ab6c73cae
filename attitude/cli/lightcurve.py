"""``attitude lightcurve MISSION.toml``: how bright a body is, as a table and a figure."""

import sys
from contextlib import ExitStack
from dataclasses import replace
from itertools import chain

from attitude.cli import geometry, output
from attitude.errors import AttitudeError

HELP = "write and draw the light curve that a mission file asks for"
EPILOG = """\
example:
  attitude lightcurve apophis-2012.toml --output curve.ecsv --figure curve.png

A mission file with a section [shape] names spin, centre, observer, times and how the body looks
([scattering], [magnitude]); data/mission/ has examples, docs/light_curves.md tells the keys.
Columns: UTC at which light is received, TDB seconds since the epoch of the spin, the magnitude
(inf where nothing of the body is both lit and seen), brightness in m2/sr, phase angle, distances,
the fraction of the Sun's disc that other bodies leave free, elevation over a ground site, then the
columns of the file.  As x.txt the curve has DAMIT's format: brightness at unit distances, less what
shadows take away, against the dates at which the light left.  With --figure alone no table is
written.
"""
# Distances from here on are told in au, m.
_FAR = 1e9
# Epochs at a time: long curves need no more memory than short ones, but for what a figure keeps.
_BLOCK = 65536
# What DAMIT's file keeps.
_DAMIT = ("reduced", "hi", "lo", "to_sun", "to_observer")


def add_arguments(parser):
    parser.add_argument("file", metavar="MISSION.toml", help="mission file with a section [shape]")
    for name in geometry.TIMES:
        parser.add_argument(f"--{name}", metavar="TIME", help=f"instead of the {name} in the file")
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="x.csv, x.ecsv, or x.txt as DAMIT has it (default: CSV to standard output); appears "
        "whole or not at all",
    )
    kinds = ", ".join(output.PICTURES)
    parser.add_argument(
        "--figure", metavar="FILE", help=f"picture, its kind by its ending: {kinds}"
    )


def run(arguments):
    from attitude.formats import mission as missions
    from attitude.textfiles.atomic_write import written_whole

    kind = output.kind_of(arguments.output, ("csv", "ecsv", "txt"))
    picture = _picture(arguments.figure)
    mission = missions.read(arguments.file)
    if mission.magnitude is None:
        raise AttitudeError(
            f"{arguments.file}: has no section [shape], without which there is no brightness; give "
            'it, as in shape.ellipsoid = "300, 200, 150 m".'
        )
    if kind == "txt":
        _require_paths(mission.scene, arguments.output)
    views = geometry.views(mission, arguments, _BLOCK, _told)
    first = next(views)  # what cannot be computed is said before anything is written
    mission = replace(mission, columns=_columns(mission, first[0]))
    curve = _Curve(mission, chain([first], views), kind, is_drawn=picture is not None)
    # Left in reverse: an error with the figure leaves no table either.
    with ExitStack() as stack:
        # Opened before the table: what is wrong with one file is not said of the other.
        drawn = picture and stack.enter_context(
            written_whole(arguments.figure, "--figure", binary=True)
        )
        if kind == "txt" or (picture and arguments.output is None):
            curve.run()
        else:
            curve.write(stack.enter_context(output.opened(arguments.output)))
        if drawn:
            curve.draw(drawn, picture)
        if kind == "txt":
            curve.write_damit(arguments.output)
    if picture is not None:
        print(arguments.figure)


class _Curve:
    """The light curve of a mission, block by block, and what a figure or DAMIT's file keeps."""

    def __init__(self, mission, views, kind, *, is_drawn):
        self._mission, self._views, self._kind = mission, views, kind
        self._is_drawn, self._parts = is_drawn, []

    def write(self, file):
        """Make all blocks and write them as they come."""
        blocks = self._blocks()
        geometry.write(file, self._kind, self._mission, next(blocks), blocks)

    def run(self):
        """Make all blocks, for what is kept of them."""
        for view, _ in self._views:
            self._keep(view, self._mission.magnitude.of(view))

    def draw(self, file, kind):
        """Save the figure of what was kept to a binary file, as one of `output.PICTURES`."""
        from attitude.cli import curve_figure

        names = [name for name in self._parts[0] if name not in _DAMIT]
        kept = {name: self._joined(name) for name in names}
        curve_figure.of(self._mission, **kept).savefig(file, format=kind, dpi=150)

    def write_damit(self, path):
        """One calibrated curve of what was kept, in units of magnitude 0 at unit distances."""
        import numpy as np

        from attitude import epochs
        from attitude.formats.damit import light_curve as damit

        reduced, hi, lo, sun, observer = (self._joined(name) for name in _DAMIT)
        if not np.all(np.isfinite(reduced)):
            raise AttitudeError(
                f"--output {path!r}: at {np.count_nonzero(~np.isfinite(reduced))} epochs nothing "
                "of the body is both lit and seen, which DAMIT's files cannot hold; give other "
                "times, or an --output x.csv."
            )
        left = epochs.times(self._parts[0]["epoch"], hi, lo)
        curve = damit.from_positions(left, 10.0 ** (-0.4 * reduced), sun, observer, calibrated=True)
        damit.write_damit_light_curves(path, curve)

    def _blocks(self):
        rest = replace(self._mission, columns=self._mission.columns[1:])
        for view, digits in self._views:
            magnitude = self._mission.magnitude.of(view)
            self._keep(view, magnitude)
            columns = [magnitude.tolist(), *geometry.numbers(rest, view)]
            yield [*geometry.dates(view, digits), *columns]

    def _keep(self, view, magnitude):
        kept = {}
        if self._is_drawn:
            kept = {"epoch": view.epoch, "seconds": view.seconds, "magnitude": magnitude}
            kept["phase_angle"] = view.phase_angle
            if view.scene.shadow_of:
                kept["lit_fraction"] = view.lit_fraction
            if view.scene.observer.has_horizon:
                kept["elevation"] = view.elevation
        if self._kind == "txt":
            import numpy as np

            from attitude.light_curve.magnitudes import dimming

            hi, lo = view.emission
            reduced = replace(self._mission.magnitude, kind="reduced").of(view)
            if view.scene.shadow_of:  # reduced magnitudes are those in full sunlight
                reduced = reduced + dimming(view.lit_fraction)
            vectors = (
                np.asarray(unit) * np.asarray(distance)[:, None]
                for unit, distance in (
                    (view.sun_direction_icrf, view.sun_distance),
                    (view.observer_direction_icrf, view.observer_distance),
                )
            )
            zero = np.zeros(len(hi)) if lo is None else lo
            kept |= {
                "epoch": view.epoch,
                **dict(zip(_DAMIT, (reduced, hi, zero, *vectors), strict=True)),
            }
        self._parts.append(kept)

    def _joined(self, name):
        import numpy as np

        parts = [part[name] for part in self._parts]
        return parts[0] if name == "epoch" else np.concatenate(parts)


def _told(done, count):
    """How far it has come, to who sits before a terminal and has to wait."""
    if count > _BLOCK and sys.stderr.isatty():
        end = "\n" if done == count else ""
        print(f"\rattitude: {100.0 * done / count:3.0f} %", end=end, file=sys.stderr, flush=True)


def _columns(mission, view):
    """What is always told, then the columns of the file."""
    from attitude.formats.mission import Column

    scene = view.scene
    is_apparent = mission.magnitude.kind == "apparent"
    own = [("magnitude" if is_apparent else "reduced_magnitude", "mag"), ("brightness", "m2 / sr")]
    own.append(("phase_angle", "deg"))
    for name, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer)):
        if not place.is_direction:
            own.append((name, "au" if getattr(view, name)[0] > _FAR else "km"))
    if scene.shadow_of:
        own.append(("lit_fraction", ""))
    if scene.observer.has_horizon:
        own.append(("elevation", "deg"))
    asked = {each.name: each for each in mission.columns}
    own = [asked.pop(name, None) or Column(name, unit) for name, unit in own]
    return (*own, *asked.values())


def _require_paths(scene, output):
    for place, name in ((scene.sun, "sun"), (scene.observer, "observer")):
        if place.is_direction:
            raise AttitudeError(
                f"--output {output!r}: the {name} is a direction, but DAMIT's files hold vectors "
                "to Sun and observer; give it as a path, or an --output x.csv."
            )


def _picture(figure):
    """The kind of a figure, one that can be drawn here; None where none is asked for."""
    if figure is None:
        return None
    from attitude import plots

    kind = output.kind_of(figure, output.PICTURES, "--figure")
    plots.new_figure((1.0, 1.0))  # without matplotlib nothing is begun
    return kind
