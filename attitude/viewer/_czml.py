"""CZML files for Cesium: the orbit of a satellite, and its attitude in the Earth's frame.

Cesium turns a model by the quaternion from body axes to Earth-fixed axes (ITRS); the position is
on ICRF axes ("INERTIAL").
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude._support import pairs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.paths import _ground
from attitude.scene._scene import Scene
from attitude.viewer import _subject

if TYPE_CHECKING:
    from attitude._support.annotations import EpochOrSeconds, FilePath, FloatArray
    from attitude.epochs._instants import Instant
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh


# Degree of Cesium's polynomials through the positions.
_DEGREE = 7
# Share of a tolerance that the turn of the Earth between two attitudes cannot exceed.
_TOLERANCE = 0.8 * _subject.TOLERANCE


def write_czml(
    path: FilePath,
    scene: Scene,
    *,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    shape: Ellipsoid | Mesh | None = None,
    title: str | None = None,
    model: str | None = None,
) -> None:
    """Write a CZML file: a clock, a path about the Earth, and the attitude along it.

    Parameters
    ----------
    path : str or path
        Ends in .czml.
    scene : Scene
        Its center is a path about the Earth (`paths.tle`, `paths.omm`, `paths.oem`).
    start, stop : epochs, or TDB seconds since the epoch of the motion
        As in `view`.
    shape
        Not written: Cesium draws models by their address; see `model`, and `write_glb`.
    title : str, optional
    model : str, optional
        Address of a glTF model, whose axes become the body axes; by default a box is drawn.

    Raises
    ------
    AttitudeError
        For a motion without a path about the Earth, epochs outside of the IERS table, and as
        `view`.

    Notes
    -----
    Between attitudes Cesium follows great circles, which stay within 0.1 degree of the motion.
    Epochs are those of the motion: light time plays no part.
    """
    from attitude._textfiles import toml
    from attitude._textfiles.atomic_write import written_whole

    path = _subject.output_name(path, ("czml",))
    if not isinstance(scene, Scene) or scene.center is None or scene.center.center != "earth":
        raise AttitudeError(
            "Cesium shows satellites of the Earth; give a Scene whose center is a path about the "
            "Earth, such as paths.tle(file), or a mission file with one."
        )
    if scene.motion is None:
        raise AttitudeError("the scene has no motion; give Scene(motion, ...) to write one.")
    subject = _subject.subject(scene.motion, start, stop, title=title or scene.center.name)
    with written_whole(path) as file:
        file.write(toml.written(_packets(subject, scene.center, model)))


def _packets(subject, center, model):
    """The packets of the document and of the body."""
    begin, end = (f"{date}Z" for date in subject.utc(np.array([0.0, subject.duration])))
    clock = {"interval": f"{begin}/{end}", "currentTime": begin}
    clock |= {"multiplier": 1, "range": "LOOP_STOP"}
    times, position, _ = _subject.trajectory(subject, center)
    packet = {
        "id": subject.title,
        "name": subject.title,
        "availability": f"{begin}/{end}",
        "position": {
            "interpolationAlgorithm": "LAGRANGE",
            "interpolationDegree": _DEGREE,
            "referenceFrame": "INERTIAL",
            "epoch": begin,
            "cartesian": np.column_stack([times, position]).ravel(),
        },
        "orientation": {
            "interpolationAlgorithm": "LINEAR",
            "interpolationDegree": 1,
            "epoch": begin,
            "unitQuaternion": _orientation(subject).ravel(),
        },
        "path": {"width": 1, "leadTime": 3000, "trailTime": 3000},
    }
    if model:
        packet["model"] = {"gltf": model, "minimumPixelSize": 64}
    else:
        packet["box"] = {"dimensions": {"cartesian": [10.0, 4.0, 4.0]}}
    return [{"id": "document", "name": subject.title, "version": "1.0", "clock": clock}, packet]


def _orientation(subject):
    """Rows of time in s, x, y, z, w: body to ITRS."""
    rows = []
    for piece in _subject.pieces(subject, _TOLERANCE):
        wxyz = quaternion.multiply(to_itrs(subject.start, piece.times), piece.wxyz)
        signs = np.cumprod(np.where(np.sum(wxyz[1:] * wxyz[:-1], axis=1) < 0.0, -1.0, 1.0))
        wxyz[1:] *= signs[:, None]
        rows.append(np.column_stack([piece.times, wxyz[:, 1:], wxyz[:, 0]]))
        # The attitude is continuous where the rate jumps: one row serves both sides.
    joined = [*(rows_of_piece[:-1] for rows_of_piece in rows[:-1]), rows[-1]]
    return np.concatenate(joined)


def to_itrs(start: Instant, times: FloatArray) -> FloatArray:
    """Quaternions (N, 4) from ICRF to ITRS at times in s after an Instant."""
    hi, lo = pairs.add((np.full(len(times), start.seconds), start.low), times)
    columns = [_ground.to_celestial(hi, lo, axis)[0] for axis in np.eye(3)]
    celestial = np.moveaxis(np.stack(columns, axis=1), -1, 0)
    return quaternion.conjugate(quaternion.from_matrix(celestial))
