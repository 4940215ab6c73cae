"""Axes of an orbit, from the position and velocity of the body about its center.

====  ============================================================================================
rtn   x away from the center, z along the orbit's momentum
lvlh  z to the center, y against the orbit's momentum
tnw   x along the velocity, z along the orbit's momentum
ntw   y along the velocity, z along the orbit's momentum
vnc   x along the velocity, y along the orbit's momentum
====  ============================================================================================

Source: SANA registry of orbit-relative reference frames.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.paths.path import Path
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude.annotations import FloatArray

# Epochs of two files are equal if they differ by at most the last decimal, s.
_SAME = 1e-12


def to_icrf(kind: str, hi: FloatArray, lo: FloatArray, orbit: Path | None, name: str) -> FloatArray:
    """Quaternions (N, 4) to ICRF from axes of an orbit.

    Parameters
    ----------
    kind : str
        A name of the table above.
    hi, lo : (N,) arrays
        hi + lo are TDB seconds since J2000.
    orbit : Path or None
        Path of the body about its center.
    name : str
        Name of the axes in error messages.

    Raises
    ------
    AttitudeError
        Without an orbit, and for epochs outside of its span.
    """
    position, velocity = state(hi, lo, orbit, name)
    normal = _unit(np.cross(position, velocity))
    if kind in ("rtn", "lvlh"):
        radial = _unit(position)
        transverse = np.cross(normal, radial)
        columns = (radial, transverse, normal) if kind == "rtn" else (transverse, -normal, -radial)
    else:
        along = _unit(velocity)
        columns = {
            "tnw": (along, np.cross(normal, along), normal),
            "ntw": (np.cross(along, normal), along, normal),
            "vnc": (along, normal, np.cross(along, normal)),
        }[kind]
    return forms.from_matrix(np.stack(columns, axis=-1))


def state(
    hi: FloatArray, lo: FloatArray, orbit: Path | None, name: str
) -> tuple[FloatArray, FloatArray]:
    """Position (N, 3) m and velocity (N, 3) m/s, over ICRF axes; see `to_icrf`."""
    orbit = known_path(orbit, name)
    for end, _, inside in ends(orbit, hi, lo):
        beyond = (inside < 0.0) & (inside >= -_SAME)
        hi, lo = np.where(beyond, end.seconds, hi), np.where(beyond, end.low, lo)
    position, velocity = orbit.state(epochs.Instant(0.0), hi, lo)
    return position, velocity


def known_path(orbit: object, name: str) -> Path:
    """The path itself; AttitudeError for anything else."""
    if isinstance(orbit, Path):
        return orbit
    given = "" if orbit is None else f", and orbit is {type(orbit).__name__}"
    raise AttitudeError(
        f"the attitude refers to {cut(name, '')}, axes of the orbit{given}; give orbit=, the path "
        "of the body about its center (on the command line --orbit, a file with the path)."
    )


def ends(
    orbit: Path, hi: FloatArray, lo: FloatArray
) -> Iterator[tuple[epochs.Instant, float, FloatArray]]:
    """Ends of the span of a path, if it has one: (end, sign, seconds of the epochs inside of it).

    The sign is 1 for the first end, -1 for the last.
    """
    for end, sign in zip(orbit.span or (), (1.0, -1.0), strict=False):
        yield end, sign, sign * ((hi - end.seconds) + (lo - end.low))


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)
