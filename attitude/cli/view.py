"""``attitude view NAME|FILE``: a page, an animation or a file for other viewers of a motion."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING, Any

from attitude.cli import output, target, view_source
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.motion import Motion
    from attitude.scene import Scene

HELP: str = "write a page on which the body turns, an animation, or a file for other viewers"
EPILOG: str = """\
examples:
  attitude view toutatis --output toutatis.html
  attitude view data/mission/envisat-glints.toml --output envisat.html
  attitude view toutatis --shape toutatis.obj --unit km --sun "1, 0, 0" --observer "0, 1, 0"
  attitude view toutatis --animate toutatis.webp
  attitude view data/mission/envisat-pass.toml --output envisat.czml

Of a mission file the page shows what the light shows that is received at its times, with Sun,
observer and light curve.

endings that --output may have:
  .html  a page without a network      .glb   glTF with animation
  .czml  Cesium: an orbit about the    .json  a catalogue of Cosmographia, with C-kernel,
         Earth, and the attitude there        frame kernel and clock kernel beside it

endings that --animate may have: .webp, .gif, .mp4 (needs ffmpeg)
"""
_FILES = (
    "a spin file or mission file (.toml), DAMIT spin file, APM, AEM, ACM, STK attitude file, "
    "C-kernel or table"
)
_ENDINGS = ("html", "czml", "glb", "json")
_ANIMATIONS = ("webp", "gif", "mp4")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    target.add_arguments(parser, _FILES)
    parser.add_argument("--output", metavar="FILE", help="x.html (default: NAME.html), or as below")
    parser.add_argument("--animate", metavar="FILE", help="an animation in place of a page")
    parser.add_argument("--start", metavar="TIME", help="date (UTC), or seconds after the epoch")
    parser.add_argument("--stop", metavar="TIME", help="last epoch, as --start")
    parser.add_argument("--shape", metavar="FILE", help="mesh to draw: OBJ, DAMIT, STL or PLY")
    parser.add_argument("--unit", default="m", metavar="UNIT", help="of the mesh (default: m)")
    for name in ("sun", "observer"):
        parser.add_argument(
            f"--{name}", nargs="+", metavar="X,Y,Z", help=f"direction to the {name}, ICRF"
        )
    parser.add_argument("--body", metavar="NAME", help="name of the frame in a C-kernel")
    parser.add_argument(
        "--kernels", nargs="+", metavar="FILE", help="further kernels that a C-kernel needs"
    )
    parser.add_argument(
        "--frames", type=int, default=120, metavar="N", help="of an animation (default: 120)"
    )


def run(arguments: argparse.Namespace) -> None:
    """Write the file and print its name.

    Raises
    ------
    AttitudeError
        As `view_source.opened` and the writers of `attitude.viewer`.
    """
    from attitude import viewer
    from attitude.progress import ProgressBar

    if arguments.animate is not None and arguments.output is not None:
        raise AttitudeError("--animate and --output are given; give one of them.")
    source = view_source.opened(arguments)
    settings: dict[str, Any] = {
        "start": _epoch(source.motion, source.start, "start"),
        "stop": _epoch(source.motion, source.stop, "stop"),
        "shape": source.shape,
        "title": source.title,
    }
    if arguments.animate is not None:
        output.kind_of(arguments.animate, _ANIMATIONS, "--animate")
        settings["magnitude"] = source.magnitude
        settings["frames"] = arguments.frames
        bar = ProgressBar("animation")
        viewer.animate(source.motion, arguments.animate, progress=bar, **settings)
        print(arguments.animate)
        return
    name = arguments.output or _file_name(source.title)
    kind = output.kind_of(name, _ENDINGS)
    if kind == "html":
        settings["magnitude"] = source.magnitude
        settings["progress"] = ProgressBar("light curve")
        viewer.view(source.motion, output=name, **settings)
    else:
        writers: dict[str, Any] = {
            "czml": viewer.write_czml,
            "glb": viewer.write_glb,
            "json": viewer.write_cosmographia,
        }
        writers[kind](name, source.motion, **settings)
    print(name)


def _epoch(motion: Motion | Scene, given: Any, name: str) -> Any:
    """An epoch of the command line or of a mission file: a date, or a time such as "3 d"."""
    if not isinstance(given, str):
        return given
    from attitude.cli import grid

    assert motion.epoch is not None  # a scene that is shown has a motion
    return grid.one(motion.epoch, given, f"--{name}")


def _file_name(title: str) -> str:
    """A page in the working directory, named after what it shows."""
    words = re.findall(r"[a-z0-9]+", title.lower())
    return "-".join(words[:8] or ["motion"]) + ".html"
