"""``attitude lightcurve MISSION.toml``: the brightness of a body as a table and a figure."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from itertools import chain
from typing import IO, TYPE_CHECKING, Any

from attitude.cli import geometry, output
from attitude.errors import AttitudeError
from attitude.progress import ProgressBar

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.formats.mission import Mission, MissionColumn
    from attitude.scene import Scene, View

HELP: str = "write and draw the light curve of a mission file"
EPILOG: str = """\
example:
  attitude lightcurve apophis-2012.toml --output curve.ecsv --figure curve.png

A mission file with a section [shape] names spin, centre, observer, times, scattering law and
magnitude ([scattering], [magnitude]); data/mission/ has examples, docs/light_curves.md lists the
keys. Columns: UTC at which light is received, TDB seconds since the epoch of the spin, the
magnitude (inf where nothing of the body is both lit and seen; over a ground site NaN by day and
below the horizon, unless the file has site_limits = false), brightness in m2/sr, phase angle,
distances, the fraction of the Sun's disc that other bodies leave free, elevation over a ground
site, then the columns of the file. As x.txt the curve is written in DAMIT's format: brightness at
unit distances, dimmed by shadows, against the dates at which the light left. With --figure alone no
table is written.
"""
# m; larger distances are written in au.
_FAR = 1e9
# Epochs in one block: the memory does not grow with the curve, except for the points of a figure.
_BLOCK = 65536
# Arrays kept for a file of DAMIT.
_DAMIT = ("reduced", "hi", "lo", "to_sun", "to_observer")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="MISSION.toml", help="mission file with a section [shape]")
    for name in geometry.TIMES:
        parser.add_argument(f"--{name}", metavar="TIME", help=f"replaces the {name} of the file")
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="x.csv, x.ecsv, or x.txt in DAMIT's format (default: CSV to standard output); appears "
        "whole or not at all",
    )
    parser.add_argument(
        "--observed",
        metavar="CURVE.csv",
        help="observations to compare with, in place of the times of the file: residuals with a "
        "zero point a session, and their rms",
    )
    kinds = ", ".join(output.PICTURES)
    parser.add_argument(
        "--figure", metavar="FILE", help=f"figure, its format by its ending: {kinds}"
    )


def run(arguments: argparse.Namespace) -> None:
    """Write the table, the file of DAMIT and the figure.

    Raises
    ------
    AttitudeError
        For a mission file, times or outputs that are not valid; nothing is written then.
    """
    from attitude.formats import mission as missions
    from attitude.textfiles.atomic_write import written_whole

    kind = output.kind_of(arguments.output, ("csv", "ecsv", "txt"))
    picture = _figure_kind(arguments.figure)
    mission = missions.read(arguments.file)
    if mission.magnitude is None:
        raise AttitudeError(
            f"{arguments.file}: has no section [shape], without which there is no brightness; give "
            'one, as in shape.ellipsoid = "300, 200, 150 m".'
        )
    if arguments.observed is not None:
        from attitude.cli import observed

        if kind != "csv":
            raise AttitudeError("--observed writes a CSV; give an --output x.csv.")
        observed.run(mission, arguments.observed, arguments.output, arguments.figure)
        return
    if kind == "txt":
        _require_paths(mission.scene, arguments.output)
    views = geometry.views(mission, arguments, _BLOCK, ProgressBar("light curve"))
    first = next(views)  # errors are raised before anything is written
    mission = replace(mission, columns=_columns(mission, first[0]))
    curve = _Curve(mission, chain([first], views), kind, is_drawn=picture is not None)
    # Contexts end in reverse order: an error with the figure leaves no table either.
    with ExitStack() as stack:
        # Opened before the table, so that an error names the file that it concerns.
        drawn = picture and stack.enter_context(
            written_whole(arguments.figure, "--figure", binary=True)
        )
        if kind == "txt" or (picture and arguments.output is None):
            curve.run()
        else:
            curve.write(stack.enter_context(output.opened(arguments.output)))
        if drawn and picture:
            curve.draw(drawn, picture)
        if kind == "txt":
            curve.write_damit(arguments.output)
    if picture is not None:
        print(arguments.figure)


class _Curve:
    """The light curve of a mission, block by block, and the arrays of a figure or file of DAMIT."""

    def __init__(
        self,
        mission: Mission,
        views: Iterable[tuple[View, int]],
        kind: str,
        *,
        is_drawn: bool,
    ) -> None:
        assert mission.magnitude is not None
        self._magnitude = mission.magnitude
        self._mission, self._views, self._kind = mission, views, kind
        self._is_drawn = is_drawn
        self._parts: list[dict[str, Any]] = []

    def write(self, file: IO[str]) -> None:
        """Compute all blocks and write each at once."""
        blocks = self._blocks()
        geometry.write(file, self._kind, self._mission, next(blocks), blocks)

    def run(self) -> None:
        """Compute all blocks for the arrays that are kept."""
        for view, _ in self._views:
            self._keep(view, self._magnitude.of(view))

    def draw(self, file: IO[bytes], kind: str) -> None:
        """Save the figure to a binary file in one of the formats of `output.PICTURES`."""
        from attitude.cli import curve_figure

        names = [name for name in self._parts[0] if name not in _DAMIT]
        kept = {name: self._joined(name) for name in names}
        curve_figure.of(self._mission, **kept).savefig(file, format=kind, dpi=150)

    def write_damit(self, path: str) -> None:
        """Write one calibrated curve, in units of magnitude 0 at unit distances.

        Raises
        ------
        AttitudeError
            If the brightness is zero at an epoch.
        """
        import numpy as np

        from attitude import epochs
        from attitude.formats.damit import light_curve as damit

        kept = [self._joined(name) for name in _DAMIT]
        observed = ~np.isnan(kept[0])  # not by day, nor below the horizon of a site
        reduced, hi, lo, sun, observer = (each[observed] for each in kept)
        if not np.all(np.isfinite(reduced)):
            raise AttitudeError(
                f"--output {path!r}: at {np.count_nonzero(~np.isfinite(reduced))} epochs nothing "
                "of the body is both lit and seen, which DAMIT's files cannot hold; give other "
                "times, or an --output x.csv."
            )
        left = epochs.times(self._parts[0]["epoch"], hi, lo)
        curve = damit.from_positions(left, 10.0 ** (-0.4 * reduced), sun, observer, calibrated=True)
        damit.write_damit_light_curves(path, curve)

    def _blocks(self) -> Iterator[list[Any]]:
        rest = replace(self._mission, columns=self._mission.columns[1:])
        for view, digits in self._views:
            magnitude = self._magnitude.of(view)
            self._keep(view, magnitude)
            columns = [magnitude.tolist(), *geometry.numbers(rest, view)]
            yield [*geometry.dates(view, digits), *columns]

    def _keep(self, view: View, magnitude: FloatArray) -> None:
        kept: dict[str, Any] = {}
        if self._is_drawn:
            kept = {"epoch": view.epoch, "seconds": view.seconds, "magnitude": magnitude}
            kept["phase_angle"] = view.phase_angle
            if view.scene.shadow_of:
                kept["lit_fraction"] = view.lit_fraction
            if view.scene.observer.has_horizon:
                kept["elevation"] = view.elevation
                kept["sun_elevation"] = view.sun_elevation
        if self._kind == "txt":
            import numpy as np

            from attitude.light_curve.magnitudes import dimming

            hi, lo = view.emission
            reduced = replace(self._magnitude, kind="reduced").of(view)
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

    def _joined(self, name: str) -> Any:
        import numpy as np

        parts = [part[name] for part in self._parts]
        return parts[0] if name == "epoch" else np.concatenate(parts)


def _columns(mission: Mission, view: View) -> tuple[MissionColumn, ...]:
    """The columns of every light curve, then those of the file."""
    from attitude.formats.mission import MissionColumn

    scene = view.scene
    assert mission.magnitude is not None
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
    given = {each.name: each for each in mission.columns}
    first = [given.pop(name) if name in given else MissionColumn(name, unit) for name, unit in own]
    return (*first, *given.values())


def _require_paths(scene: Scene, output: str) -> None:
    """Raise the AttitudeError for a Sun or observer without a distance."""
    for place, name in ((scene.sun, "sun"), (scene.observer, "observer")):
        if place.is_direction:
            raise AttitudeError(
                f"--output {output!r}: the {name} is a direction, but DAMIT's files hold vectors "
                "to Sun and observer; give it as a path, or an --output x.csv."
            )


def _figure_kind(figure: str | None) -> str | None:
    """The format of --figure, or None without it."""
    return None if figure is None else output.kind_of(figure, output.PICTURES, "--figure")
