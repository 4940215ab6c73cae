"""``attitude view NAME|FILE``: a page, an animation or a file for other viewers of a motion."""

from __future__ import annotations

import argparse
import os
import re
from typing import Any

from attitude._support import validation
from attitude.cli import _options, _output
from attitude.errors import AttitudeError

# ---- What ``attitude view`` shows: the motion or scene of a file, or of a name in the catalogue

# Keys of a spin file; a TOML with others is a mission file.
_OF_SPIN_FILES = {"name", "source", "note", "body", "spin", "errors", "shape", "scattering"}


def opened(arguments: argparse.Namespace) -> dict[str, Any]:
    """The arguments of `viewer.view`: motion or scene, span, shape, title, magnitude."""
    from attitude.formats import detect
    from attitude.shape import _files

    target: str = arguments.target
    mesh: Any = None
    if arguments.shape is not None:
        mesh = _files.read(arguments.shape, unit=arguments.unit or "m")
    else:
        _options.refuse(arguments, ("unit",), "a view without --shape")
    is_file = _options.is_file(target)
    if is_file:
        _options.refuse_completing(arguments)
    is_message = is_file and not target.endswith((".toml", ".spin", ".apm"))
    read = detect.format_of(target) if is_message else None
    choices = _options.of_reading(arguments, target, read)
    if read is not None and read.holds == "span" and None in (arguments.start, arguments.stop):
        raise AttitudeError(f"{target} has no span of its own; give --start and --stop.")
    path = _options.path_of(arguments)
    if path is not None and (read is None or "orbit" not in read.reading):
        raise AttitudeError(f"--orbit has no meaning for {target}; leave it out.")
    if is_file and target.endswith(".toml") and _is_mission(target):
        return _of_mission(arguments, target, mesh)
    if not is_file and (scene := _scene_of(arguments)) is not None:
        return _of_mission(arguments, scene, mesh)
    law: Any = None
    if is_message:
        motion = detect.opened(target, orbit=path, **choices).motion
        title = _stem(target)
    else:
        state = _options.opened(arguments)[0]
        motion, law, mesh = state.motion, state.law, mesh or state.shape
        # A spin file without a name shows that of the file, not the path typed.
        title = _stem(target) if state.name in (target, None) else str(state.name)
    ends = {"start": arguments.start, "stop": arguments.stop}
    return {"motion": _lit(arguments, motion, mesh, law), **ends, "shape": mesh, "title": title}


def _is_mission(path):
    from attitude._textfiles import toml

    content = toml.parsed(toml.read(path, "spin file or mission file"), path)
    spin = content.get("spin")
    is_named = isinstance(spin, str) or (isinstance(spin, dict) and "catalog" in spin)
    return is_named or bool(content.keys() - _OF_SPIN_FILES)


def _scene_of(arguments):
    """The mission file of an entry of the catalogue that is shown as it stands; else None."""
    from attitude import catalog

    options = ("shape", "sun", "observer", "start", "stop")
    if _options.completing(arguments) or any(getattr(arguments, x) is not None for x in options):
        return None
    return catalog.entry(arguments.target).scene


def _of_mission(arguments, path, mesh):
    from attitude.formats import mission

    for name in ("sun", "observer"):
        if getattr(arguments, name) is not None:
            raise AttitudeError(f"--{name} is given, but {path} is a mission file; write it there.")
    content = mission.read(path)
    if content.scene.motion is None:
        raise AttitudeError(f"{path}: has no spin, without which nothing turns; give spin = ...")
    dates = content.times.get("epochs", [None])
    source = {
        "motion": content.scene,
        "start": arguments.start or content.times.get("start", dates[0]),
        "stop": arguments.stop or content.times.get("stop", dates[-1]),
        "shape": mesh,
        "title": content.name or _stem(path),
    }
    if content.magnitude is not None:
        label = "magnitude" if content.magnitude.kind == "apparent" else "reduced magnitude"
        source["magnitude"] = content.magnitude.of, label
    return source


def _stem(path):
    """The name of a file without folder and ending."""
    return os.path.splitext(os.path.basename(path))[0]


def _lit(arguments, motion, shape, law):
    """With --sun and --observer the scene of the motion, lit and seen from these directions."""
    words = {name: getattr(arguments, name) for name in ("sun", "observer")}
    if not any(words.values()):
        return motion
    from attitude.paths import _path
    from attitude.scene._scene import Scene
    from attitude.shape._ellipsoid import Ellipsoid

    directions = []
    for name, texts in words.items():
        if texts is None:
            raise AttitudeError(f'--{name} is missing; give both, as in --{name} "1, 0, 0".')
        direction = validation.unit_vector(" ".join(texts), f"--{name}")
        directions.append(_path.direction(direction, name=name))
    if shape is None and motion.body is not None:
        shape = Ellipsoid.of_moments(motion.body.moments)
    law = "lommel-seeliger" if law is None else law
    return Scene(motion, None, *directions[::-1], shape=shape, law=law)


HELP: str = "write a page on which the body turns, an animation, or a file for other viewers"
EPILOG: str = """\
examples:
  attitude view toutatis --output toutatis.html
  attitude view data/mission/envisat-glints.toml --output envisat.html
  attitude view toutatis --shape toutatis.obj --unit km --sun "1, 0, 0" --observer "0, 1, 0"
  attitude view toutatis --animate toutatis.webp
  attitude view data/mission/envisat-pass.toml --output envisat.czml

Of toutatis it shows December 1992: Sun and Earth where they were, a shape of two ellipsoids, and
the light curve.
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
_FRAMES = 120


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    _options.add_target_arguments(parser, _FILES)
    parser.add_argument("--output", metavar="FILE", help="x.html (default: NAME.html), or as below")
    parser.add_argument("--animate", metavar="FILE", help="an animation in place of a page")
    parser.add_argument("--start", metavar="TIME", help="date (UTC), or seconds after the epoch")
    parser.add_argument("--stop", metavar="TIME", help="last epoch, as --start")
    parser.add_argument("--shape", metavar="FILE", help="mesh to draw: OBJ, DAMIT, STL or PLY")
    parser.add_argument("--unit", metavar="UNIT", help="of the mesh (default: m)")
    for name in ("sun", "observer"):
        parser.add_argument(
            f"--{name}", nargs="+", metavar="X,Y,Z", help=f"direction to the {name}, ICRF"
        )
    for option in _options.of_formats(of_reading=True):
        text = option.help.replace(" IN", " FILE")
        parser.add_argument(f"--{option.name}", help=text, **option.settings)
    _options.add_orbit_arguments(parser, "path of the body, where its axes are those of the orbit")
    parser.add_argument(
        "--frames", type=int, metavar="N", help=f"of an animation (default: {_FRAMES})"
    )


def run(arguments: argparse.Namespace) -> None:
    """Write the file and print its name."""
    from attitude._support.blocks import ProgressBar
    from attitude.viewer import _animation, _cosmographia, _czml, _gltf, _page

    if arguments.animate is not None and arguments.output is not None:
        raise AttitudeError("--animate and --output are given; give one of them.")
    if arguments.animate is None:
        _options.refuse(arguments, ("frames",), "a view without --animate")
    settings = opened(arguments)
    motion, magnitude = settings.pop("motion"), settings.pop("magnitude", None)
    for end in ("start", "stop"):  # dates, or times such as "3 d"
        if isinstance(settings[end], str):
            settings[end] = _options.one(motion.epoch, settings[end], f"--{end}")
    if arguments.animate is not None:
        name, is_animation = arguments.animate, True
        kind = _output.kind_of(name, _ANIMATIONS, "--animate")
    else:
        name, is_animation = arguments.output or _file_name(settings["title"]), False
        kind = _output.kind_of(name, _ENDINGS)
    if is_animation or kind == "html":
        settings["magnitude"] = magnitude
        settings["progress"] = ProgressBar("animation" if is_animation else "light curve")
    if is_animation:
        frames = _FRAMES if arguments.frames is None else arguments.frames
        _animation.animate(motion, name, frames=frames, **settings)
    elif kind == "html":
        _page.view(motion, output=name, **settings)
    else:
        writers: dict[str, Any] = {
            "czml": _czml.write_czml,
            "glb": _gltf.write_glb,
            "json": _cosmographia.write_cosmographia,
        }
        writers[kind](name, motion, **settings)
    print(name)


def _file_name(title):
    """A page in the working directory, named after what it shows."""
    words = re.findall(r"[a-z0-9]+", title.lower())
    return "-".join(words[:8] or ["motion"]) + ".html"
