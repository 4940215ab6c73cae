"""CCSDS orbit ephemeris messages (OEM) in KVN and XML.

Source: CCSDS 502.0-B-3, Orbit Data Messages, section 5 (versions 1 to 3).  Its units are km and
km/s.  Covariances and accelerations are ignored.  States over axes of the Earth (ITRF, TEME, TOD,
...) are turned to ICRF and interpolated there.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from attitude._textfiles import messages
from attitude._textfiles.lines import prefixed
from attitude._textfiles.messages import Form, MessageRows
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import _earth
from attitude.paths._composed import relative
from attitude.paths._path import KM, SSB, body_name
from attitude.paths._spk import Succession
from attitude.paths._tabulated import table

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude._support.annotations import FilePath, FloatArray
    from attitude._textfiles.lines import Fault
    from attitude.paths._path import EphemerisLike, Path


_AXES = ("X", "Y", "Z")
_STATE = (*_AXES, *(f"{axis}_DOT" for axis in _AXES))
_ACCELERATION = tuple(f"{axis}_DDOT" for axis in _AXES)
_NEEDED = ("OBJECT_NAME", "CENTER_NAME", "REF_FRAME", "TIME_SYSTEM", "START_TIME", "STOP_TIME")
_FORM = Form(
    "OEM",
    ("1.0", "2.0", "3.0"),
    ("*",),
    meta=(
        *_NEEDED,
        "OBJECT_ID",
        "REF_FRAME_EPOCH",
        "USEABLE_START_TIME",
        "USEABLE_STOP_TIME",
        "INTERPOLATION",
        "INTERPOLATION_DEGREE",
    ),
    needed=_NEEDED,
    blocks={"DATA": (), "COVARIANCE": ()},
    units={
        **dict.fromkeys(_AXES, ("km",)),
        **dict.fromkeys(_STATE[3:], ("km/s",)),
        **dict.fromkeys(_ACCELERATION, ("km/s**2",)),
    },
    elements={"data": "DATA", "covarianceMatrix": "COVARIANCE"},
    rows={"DATA": "stateVector"},
    inner={"COVARIANCE": "DATA"},
    skipped=("COVARIANCE",),
    marks={"metadata": "META", "data": ""},
)


class _States(MessageRows):
    """The states of a segment: epochs, states (N, 6) in km and km/s, and the last line."""

    holds = "a state has an epoch and 6 finite numbers (km, km/s), or 9 with accelerations"
    others: Mapping[int, Sequence[int]] = {10: range(7)}
    unread = _ACCELERATION

    def __init__(self, fault: Fault):
        super().__init__(fault, _STATE)
        self.times: list[str] = []
        self.states: list[FloatArray] = []
        self.line: int = 0

    def add(self, leads, values, lines):
        """Add N states."""
        finite = np.isfinite(values).all(axis=1)
        if not np.all(finite):
            k = int(np.argmin(finite))
            raise self.fault(f"a number is not finite; {self.holds}.", lines[k])
        self.times.extend(token.decode("ascii", "replace") for token in leads[0])
        self.states.append(values)
        self.line = lines[-1]


def oem(
    file: FilePath,
    *,
    ephemeris: EphemerisLike = None,
    degree: int | None = None,
    center: Path | str | int | None = None,
) -> Path:
    """The path in an OEM file.

    Parameters
    ----------
    file : path
        A message in KVN or XML about one object; any number of segments, each interpolated on its
        own by its keywords INTERPOLATION and INTERPOLATION_DEGREE (Hermite or Lagrange polynomials;
        Hermite of degree 7 without them), reduced to what its states allow as in `table`.  One that
        has a single state, as at a manoeuvre, covers no time and is left out.
    ephemeris : Ephemeris, path of a kernel, or None
        See `ephemeris`; used if the segments have different centers.
    degree : int, optional
        Replaces the degree in the file.
    center : Path, str or int, optional
        Replaces CENTER_NAME, such as BENNU: the path of that body, or a body by its name or NAIF
        number.

    Returns
    -------
    Path
        ``center`` is that of the segments, or "ssb" if they differ.  At an epoch that two
        segments cover, the later one in the file is used.

    Raises
    ------
    AttitudeError
        With file, line and keyword, for a keyword that is missing or unknown and a value that
        cannot be read; for a frame or a time system that is not supported; for segments of several
        objects; for segments of several centers with `center`.
    """
    message = messages.read(file, _FORM, lambda block, count: _States(block.message.fault))
    objects = {block.meta["OBJECT_NAME"] for block in message.blocks}
    if len(objects) > 1:
        raise AttitudeError(
            f"{message.path} holds several objects ({', '.join(sorted(objects))}); give a file for "
            "each."
        )
    several = [block for block in message.blocks if not _is_single(block.rows)]
    names = {block.meta["CENTER_NAME"] for block in message.blocks}
    if center is not None and len(names) > 1:
        raise AttitudeError(
            f"{message.path} has several centers ({', '.join(sorted(names))}), which one center= "
            "cannot replace; leave it out, or give a file for each."
        )
    paths = [_path(block, message.path, degree, center) for block in several or message.blocks]
    if len({path.center for path in paths}) > 1:
        paths = [relative(path, SSB, ephemeris) for path in paths]
    return paths[0] if len(paths) == 1 else Succession(tuple(reversed(paths)), paths[0].name)


def _is_single(rows):
    """Whether a segment has one state."""
    return rows is not None and len(rows.times) == 1


def _path(block, origin, degree, center):
    """The path of the data of one segment of a file, from its center or from the one given."""
    meta = block.meta
    where = f"{origin}, segment at line {meta.line}"
    with prefixed(where):
        scale = ccsds_epochs.known(meta["TIME_SYSTEM"])
    frame = _earth.kind_of(meta["REF_FRAME"])
    if frame is None:
        raise AttitudeError(
            f"{where}: REF_FRAME is {meta['REF_FRAME']}; it must be one of "
            f"{', '.join((*_earth.FIXED_NAMES, *_earth.TURNING_NAMES))}."
        )
    if block.rows is None:
        raise AttitudeError(f"{where}: there are no states.")
    rows = block.rows
    interpolation, degree = _interpolation(meta, where, degree)
    with np.errstate(over="ignore"):  # `table` refuses what is not finite
        states = KM * np.concatenate(rows.states)
    span = _useable(meta, rows.times, scale, where)
    with prefixed(f"{where} (states to line {rows.line})"):
        return table(
            [_dated(time, scale) for time in rows.times],
            states[:, :3],
            states[:, 3:],
            interpolation=interpolation,
            degree=degree,
            center=_center_of(meta) if center is None else center,
            frame=frame,
            name=meta["OBJECT_NAME"],
            source=os.path.basename(origin),
            span=span,
        )


def _center_of(meta):
    """The body that the file names."""
    try:
        return body_name(meta["CENTER_NAME"], "CENTER_NAME")
    except AttitudeError as err:
        raise AttitudeError(f"{err} center= gives the path of any other body.") from err


def _interpolation(meta, where, degree):
    """The interpolation and degree of a segment, as `table` takes them."""
    name = meta.get("INTERPOLATION", "HERMITE").upper()
    if degree is None:
        text = meta.get("INTERPOLATION_DEGREE", "7")
        if not text.isdigit():
            raise AttitudeError(
                f"{where}: INTERPOLATION_DEGREE is {text}; it must be a whole number."
            )
        degree = int(text)
    if name == "LINEAR":
        return "lagrange", 1
    if name not in ("HERMITE", "LAGRANGE"):
        raise AttitudeError(
            f"{where}: INTERPOLATION is {name}; it must be HERMITE, LAGRANGE or LINEAR."
        )
    return name.lower(), degree


def _useable(meta, times, scale, where):
    """The useable time of a segment, or None for that of its states."""
    for prefix in ("", "USEABLE_"):
        keys = f"{prefix}START_TIME", f"{prefix}STOP_TIME"
        texts = [meta.get(key, time) for key, time in zip(keys, (times[0], times[-1]), strict=True)]
        span = tuple(_inputs.instant(_dated(text, scale), f"{where}: epoch") for text in texts)
        if span[1].since(span[0]) < 0.0 and all(key in meta for key in keys):
            raise AttitudeError(f"{where}: {keys[1]} is before {keys[0]}.")
    return span if any(key in meta for key in keys) else None


def _dated(text, scale):
    """An epoch of a segment as text with its time scale."""
    return f"{text.removesuffix('Z')} {scale.upper()}"
