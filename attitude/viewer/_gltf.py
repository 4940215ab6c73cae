"""glTF files (.glb): the mesh of a body with its rotation as an animation, for any 3D viewer."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support.arrays import units
from attitude.viewer import _subject
from attitude.viewer._page import seconds_a_second

if TYPE_CHECKING:
    from attitude._support.annotations import EpochOrSeconds, FilePath
    from attitude.motions._motion import HasAttitudes
    from attitude.scene._scene import Scene
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh


# Types of numbers, targets of buffers, and types of chunks, as glTF 2.0 numbers them.
_FLOAT = 5126
_UINT = 5125
_VERTICES = 34962
_INDICES = 34963
_JSON = 0x4E4F534A
_BIN = 0x004E4942
# Most facets that are written.
_MOST = 1_000_000
# From ICRF, whose z is north, to the axes of glTF, whose y is up: x, y, z, w.
_UPRIGHT = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]


def write_glb(
    path: FilePath,
    motion: HasAttitudes | Scene | str,
    *,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    speed: float | None = None,
) -> None:
    """Write the mesh of a body and its rotation as binary glTF 2.0.

    Parameters
    ----------
    path : str or path
        Ends in .glb.
    motion, start, stop, shape, title
        As in `view`; of a Scene the attitudes are those that its light shows.
    speed : float, optional
        Seconds of the motion in a second of the animation; by default a turn takes some 8 s.  It
        is written as "speed" into the extras of the animation.

    Raises
    ------
    AttitudeError
        As `view`.

    Notes
    -----
    Vertices are in m (1 for the largest distance where the size is unknown).  Viewers follow great
    circles between attitudes, which stay within 0.1 degree of the motion.  North of ICRF is up.
    """
    from attitude._support import validation
    from attitude._textfiles import toml
    from attitude._textfiles.atomic_write import written_whole

    path = _subject.output_name(path, ("glb",))
    subject = _subject.subject(motion, start, stop, shape=shape, title=title)
    poses = _subject.pieces(subject)
    pace = (
        seconds_a_second(subject, poses) if speed is None else validation.positive(speed, "speed")
    )
    surface = _subject.surface(subject, _MOST)
    size = surface.size if np.isfinite(surface.size) else 1.0
    buffer = _Buffer()
    vertices = buffer.add(surface.vertices * size, "<f4", "VEC3", _VERTICES)
    facets = buffer.add(surface.facets.reshape(-1, 1), "<u4", "SCALAR", _INDICES)
    times, turns = _keys(poses, pace)
    inputs = buffer.add(times[:, None], "<f4", "SCALAR")
    outputs = buffer.add(turns, "<f4", "VEC4")
    content = {
        "asset": {"version": "2.0", "generator": "attitude"},
        "scene": 0,
        "scenes": [{"nodes": [0], "name": subject.title}],
        "nodes": [
            {"name": "ICRF", "children": [1], "rotation": _UPRIGHT},
            {"name": subject.title, "mesh": 0},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": vertices}, "indices": facets}]}],
        "animations": [
            {
                "name": "rotation",
                "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
                "samplers": [{"input": inputs, "output": outputs, "interpolation": "LINEAR"}],
                "extras": {"speed": pace, "start_utc": subject.start.utc_iso},
            }
        ],
        **buffer.described(),
    }
    text = toml.written(content).encode("utf-8")
    with written_whole(path, binary=True) as file:
        file.write(_file(text, buffer.bytes))


def _keys(pieces: list[_subject.PosePiece], pace: float) -> tuple[Any, Any]:
    """Times of the animation that increase as float32, and quaternions x, y, z, w."""
    times = (np.concatenate([piece.times for piece in pieces]) / pace).astype(np.float32)
    turns = np.concatenate([piece.wxyz[:, [1, 2, 3, 0]] for piece in pieces])
    kept = np.concatenate([[True], np.diff(np.maximum.accumulate(times)) > 0.0])
    return times[kept], units(turns[kept])


class _Buffer:
    """The binary part of a file, and what stands where in it."""

    def __init__(self) -> None:
        self.bytes = b""
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []

    def add(self, array: Any, kind: str, shape: str, target: int | None = None) -> int:
        """Append an array; the number of its accessor."""
        rows = np.ascontiguousarray(array, dtype=kind)
        data = rows.tobytes()
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)}
        self._views.append(view | ({} if target is None else {"target": target}))
        self._accessors.append(
            {
                "bufferView": len(self._views) - 1,
                "componentType": _FLOAT if kind == "<f4" else _UINT,
                "count": len(rows),
                "type": shape,
                "min": rows.min(axis=0),
                "max": rows.max(axis=0),
            }
        )
        self.bytes += data  # a multiple of 4 bytes, as accessors need
        return len(self._accessors) - 1

    def described(self) -> dict[str, Any]:
        """The entries of the JSON about the buffer."""
        return {
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": len(self.bytes)}],
        }


def _file(text: bytes, data: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(data)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, total),
            struct.pack("<II", len(text), _JSON),
            text,
            struct.pack("<II", len(data), _BIN),
            data,
        ]
    )
