"""A catalogue of Cosmographia beside a C-kernel: x.json, x.bc, x.tf, x.tsc, x.xyzv and x.obj."""

from __future__ import annotations

import os
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.scene._scene import Scene
from attitude.viewer import _subject

if TYPE_CHECKING:
    from attitude._support.annotations import EpochOrSeconds, FilePath
    from attitude.motions._motion import HasAttitudes
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh


# Facets of the mesh at most.
_MOST = 200_000
# km, of a body whose size is unknown.
_SIZE = 0.01
# The name in Cosmographia and the NAIF number.
_CENTERS = {"sun": ("Sun", 10), "earth": ("Earth", 399), "moon": ("Moon", 301), "ssb": ("SSB", 0)}
# NAIF numbers of clocks start below those of spacecraft, which artificial satellites have to
# -199999 (NAIF IDs Required Reading); of frames and instruments they are 1000 times as large.
_CLOCKS = -200_000
_HOW_MANY_CLOCKS = 800_000


def write_cosmographia(
    path: FilePath,
    motion: HasAttitudes | Scene | str,
    *,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    tolerance: float = 1e-6,
) -> None:
    """Write a catalogue that Cosmographia opens, and beside it the files that it names.

    Parameters
    ----------
    path : str or path
        Ends in .json; the others take its name.
    motion, start, stop, shape, title
        As in `view`.  The center of a Scene gives the trajectory (about the Sun, the Earth or the
        Moon); without one the body rests at the Sun.
    tolerance : float
        Largest error of the attitude in the C-kernel, rad.

    Raises
    ------
    AttitudeError
        As `view` and `formats.ck.write`, and for a path about another body.
    """
    from attitude._textfiles import toml
    from attitude._textfiles.atomic_write import written_whole
    from attitude.formats import ck

    path = _subject.output_name(path, ("json",))
    orbit = motion.center if isinstance(motion, Scene) else None
    seen = _subject.subject(motion, start, stop, shape=shape, title=title)
    ends = seen.start.time, seen.start.after(seen.duration).time
    subject = _subject.subject(seen.motion, *ends, shape=seen.shape)
    base = os.path.splitext(path)[0]
    name = os.path.basename(base)
    center, number = ("Sun", 10) if orbit is None else _center(orbit)
    frame, clock = _frame(seen.title)
    ck.write(
        f"{base}.bc",
        subject.motion,
        subject.start.time,
        subject.start.after(subject.duration).time,
        tolerance=tolerance,
        name=frame,
        instrument=1000 * clock,
        center=number,
        clock=clock,
    )
    surface = _subject.surface(subject, _MOST)
    with written_whole(f"{base}.obj") as file:
        file.writelines(_rows_of_obj(surface))
    trajectory: dict[str, Any] = {"type": "FixedPoint", "position": [0.0, 0.0, 0.0]}
    if orbit is not None:
        with written_whole(f"{base}.xyzv") as file:
            file.write(_states(subject, orbit))
        trajectory = {"type": "InterpolatedStates", "source": f"{name}.xyzv"}
    begin, end = (f"{date} UTC" for date in subject.utc(np.array([0.0, subject.duration])))
    catalogue = {
        "version": "1.0",
        "name": seen.title,
        "spiceKernels": [f"{name}.tsc", f"{name}.tf", f"{name}.bc"],
        "items": [
            {
                "class": "spacecraft" if center != "Sun" else "asteroid",
                "name": seen.title,
                "startTime": begin,
                "endTime": end,
                "center": center,
                "trajectoryFrame": "ICRF",
                "trajectory": trajectory,
                "bodyFrame": {"type": "Spice", "name": frame},
                "geometry": {
                    "type": "Mesh",
                    "source": f"{name}.obj",
                    # Radius in km to which Cosmographia scales the mesh.
                    "size": surface.size / 1000.0 if np.isfinite(surface.size) else _SIZE,
                    "meshRotation": [1, 0, 0, 0],
                },
            }
        ],
    }
    with written_whole(path) as file:
        file.write(toml.written(catalogue, indent=2) + "\n")


def _rows_of_obj(surface):
    """The rows of vertices, in the unit of the surface, and of facets."""
    yield from (f"v {x:.7g} {y:.7g} {z:.7g}\n" for x, y, z in surface.vertices.tolist())
    yield from (f"f {a} {b} {c}\n" for a, b, c in (surface.facets + 1).tolist())


def _frame(title):
    """Name of the frame of a title, and NAIF number of its clock, of catalogues loaded together."""
    plain = (letter if letter.isascii() and letter.isalnum() else "_" for letter in title.upper())
    name = "".join(plain)
    name = (name if name[:1].isalpha() else f"B_{name}")[:26]
    return name, _CLOCKS - zlib.crc32(title.encode()) % _HOW_MANY_CLOCKS


def _center(path):
    about = path.center
    if not isinstance(about, str) or about not in _CENTERS:
        raise AttitudeError(
            f"the path of {path.name} is about {about}; Cosmographia's catalogue takes a "
            f"path about one of {', '.join(_CENTERS)}."
        )
    return _CENTERS[about]


def _states(subject, center):
    """Rows of a Julian date (TDB), km and km/s."""
    times, position, velocity = _subject.trajectory(subject, center)
    dates = _instants.times(subject.start, times).tdb.jd
    table = np.column_stack([dates, position / 1000.0, velocity / 1000.0])
    return "".join(
        f"{row[0]:.9f} {' '.join(f'{number:.12g}' for number in row[1:])}\n" for row in table
    )
