"""What ``attitude view`` shows: the motion or scene of a file, or of a name in the catalogue."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Any, NamedTuple

from attitude.cli import target
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray
    from attitude.formats.mission import Mission
    from attitude.motion import Motion
    from attitude.scene import Scene, View
    from attitude.shape import Mesh

# Keys of a spin file; a TOML with others is a mission file.
_OF_SPIN_FILES = {"name", "source", "note", "body", "spin", "errors"}


class ViewSource(NamedTuple):
    """A motion or scene with its span and title, as `viewer.view` takes them."""

    motion: Motion | Scene
    start: Any
    stop: Any
    shape: Mesh | None
    title: str
    magnitude: tuple[Callable[[View], FloatArray], str] | None


def opened(arguments: argparse.Namespace) -> ViewSource:
    """The ViewSource of parsed arguments.

    Raises
    ------
    AttitudeError
        For files that cannot be read, unknown names, and directions without a shape to light.
    """
    from attitude import shape

    given = arguments.target
    mesh = None
    if arguments.shape is not None:
        mesh = shape.read(arguments.shape, unit=arguments.unit)
    if target.is_file(given) and given.endswith(".toml"):
        content = _content(given)
        spin = content.get("spin")
        named = isinstance(spin, str) or (isinstance(spin, dict) and "catalog" in spin)
        if set(content) - _OF_SPIN_FILES or named:
            return _of_mission(arguments, mesh)
    motion, title = _motion(arguments)
    source = ViewSource(motion, arguments.start, arguments.stop, mesh, title, None)
    return _lit(arguments, source)


def _content(path: str) -> dict[str, Any]:
    from attitude.textfiles import toml

    return toml.parsed(toml.read(path, "spin file or mission file"), path)


def _of_mission(arguments: argparse.Namespace, mesh: Mesh | None) -> ViewSource:
    from attitude.formats import mission as missions

    for name in ("sun", "observer"):
        if getattr(arguments, name) is not None:
            raise AttitudeError(
                f"--{name} is given, but {arguments.target} is a mission file; write it there."
            )
    found = missions.read(arguments.target)
    if found.scene.motion is None:
        raise AttitudeError(
            f"{arguments.target}: has no spin, without which nothing turns; give spin = ..."
        )
    start, stop = _times(found)
    title = found.name or os.path.basename(arguments.target)
    magnitude = None
    if found.magnitude is not None:
        label = "magnitude" if found.magnitude.kind == "apparent" else "reduced magnitude"
        magnitude = found.magnitude.of, label
    return ViewSource(
        found.scene,
        start if arguments.start is None else arguments.start,
        stop if arguments.stop is None else arguments.stop,
        mesh,
        title,
        magnitude,
    )


def _times(found: Mission) -> tuple[Any, Any]:
    """Start and stop of a mission file, as far as it has them."""
    if "epochs" in found.times:
        return found.times["epochs"][0], found.times["epochs"][-1]
    return found.times.get("start"), found.times.get("stop")


def _motion(arguments: argparse.Namespace) -> tuple[Motion, str]:
    given = arguments.target
    if target.is_file(given) and not given.endswith((".toml", ".spin", ".apm")):
        from attitude.formats import detect

        found = detect.opened(given, body=arguments.body, kernels=arguments.kernels or ())
        return found.motion, os.path.basename(given)
    one = target.opened(arguments)
    return one.motion, one.name


def _lit(arguments: argparse.Namespace, source: ViewSource) -> ViewSource:
    """With --sun and --observer the scene of the motion, lit and seen from these directions."""
    given = {name: getattr(arguments, name) for name in ("sun", "observer")}
    if not any(given.values()):
        return source
    from attitude import paths, validation
    from attitude.scene import Scene
    from attitude.shape import Ellipsoid

    for name, words in given.items():
        if words is None:
            raise AttitudeError(f'--{name} is missing; give both, as in --{name} "1, 0, 0".')
    sun, observer = (
        paths.direction(validation.real(" ".join(words), f"--{name}", shape=(3,)), name=name)
        for name, words in given.items()
    )
    motion: Any = source.motion
    shape: Any = source.shape
    if shape is None and motion.body is not None:
        shape = Ellipsoid.of_moments(motion.body.moments)
    scene = Scene(motion, None, observer, sun, shape=shape)
    return source._replace(motion=scene)
