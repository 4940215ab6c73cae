"""CCSDS orbit ephemeris messages (OEM) in keyword = value notation.

Source: CCSDS 502.0-B-3, Orbit Data Messages, section 5 (versions 1 to 3).  Its units are km and
km/s.  Covariances and accelerations are ignored.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from attitude import frames
from attitude._textfiles import kvn
from attitude._textfiles.lines import opened
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.paths._composed import relative
from attitude.paths._path import SSB, body_name
from attitude.paths._spk import Succession
from attitude.paths._tabulated import table

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath
    from attitude.paths._path import EphemerisLike, Path


_NEEDED = ("OBJECT_NAME", "CENTER_NAME", "REF_FRAME", "TIME_SYSTEM", "START_TIME", "STOP_TIME")
_KNOWN = (
    *_NEEDED,
    *("OBJECT_ID", "REF_FRAME_EPOCH", "USEABLE_START_TIME", "USEABLE_STOP_TIME"),
    *("INTERPOLATION", "INTERPOLATION_DEGREE"),
)
# The frame in `frames.FRAMES` for each supported name of the standard.
_FRAMES = {"ICRF": "icrf", "GCRF": "gcrf", "GCRF1": "gcrf", "EME2000": "eme2000", "ICRF2": "icrf",
           "ICRF3": "icrf", "ECLIPJ2000": "ecliptic"}  # fmt: skip
_SYSTEMS = ("UTC", "TAI", "GPS", "TT", "TDB", "TCG", "TCB", "UT1")


@dataclass
class _Segment:
    """The lines of one segment: its metadata, and epochs and states with their line numbers."""

    line: int
    given: dict[str, str] = field(default_factory=dict)
    times: list[str] = field(default_factory=list)
    states: list[list[float]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)


def oem(file: FilePath, *, ephemeris: EphemerisLike = None, degree: int | None = None) -> Path:
    """The path in an OEM file.

    Parameters
    ----------
    file : path
        A message about one object; any number of segments, each interpolated on its own by its
        keywords INTERPOLATION and INTERPOLATION_DEGREE (Hermite or Lagrange polynomials; Hermite
        of degree 7 without them).
    ephemeris : Ephemeris, path of a kernel, or None
        See `ephemeris`; used if the segments have different centers.
    degree : int, optional
        Replaces the degree in the file.

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
        objects.
    """
    with opened(file) as lines:
        segments = _segments(lines)
    objects = {segment.given["OBJECT_NAME"] for segment in segments}
    if len(objects) > 1:
        raise AttitudeError(
            f"{lines.path} holds several objects ({', '.join(sorted(objects))}); give a file for "
            "each."
        )
    paths = [_path(segment, lines.path, degree) for segment in segments]
    if len({path.center for path in paths}) > 1:
        paths = [relative(path, SSB, ephemeris) for path in paths]
    return paths[0] if len(paths) == 1 else Succession(tuple(reversed(paths)), paths[0].name)


def _segments(lines):
    """The segments of a message."""
    found, segment, where = [], None, "header"
    for line in lines:
        text = lines.text(line).strip()
        if not text or kvn.comment_of(text) is not None:
            continue
        if lines.number == 1 or (where == "header" and not found and "CCSDS_OEM_VERS" in text):
            if not text.startswith("CCSDS_OEM_VERS"):
                raise lines.fault(
                    f"the first line is {kvn.shown(text)}, not CCSDS_OEM_VERS = ...; give an OEM "
                    "in keyword = value notation (not XML)."
                )
            continue
        if text == "META_START":
            if where == "metadata":
                raise lines.fault(f"line {segment.line} is META_START too; META_STOP is missing.")
            segment, where = _Segment(lines.number), "metadata"
            found.append(segment)
        elif text == "META_STOP":
            where = _closed(segment, where, lines)
        elif text == "COVARIANCE_START":
            where = "covariance"
        elif text == "COVARIANCE_STOP":
            where = "data"
        elif where == "metadata":
            _keyword(segment, line, lines)
        elif where == "data":
            _state(segment, text, lines)
        elif where == "header" and "=" not in text:
            raise lines.fault(
                f"{kvn.shown(text)} stands before META_START; only keyword = value lines do."
            )
    if where == "metadata":
        raise lines.fault("META_START has no META_STOP.", segment.line)
    if not found:
        raise AttitudeError(f"{lines.path} has no META_START, so no segment; give an OEM file.")
    return found


def _closed(segment, where, lines):
    """The part of the message after META_STOP; the metadata must be complete."""
    if where != "metadata":
        raise lines.fault("META_STOP has no META_START before it.")
    for keyword in _NEEDED:
        if keyword not in segment.given:
            raise lines.fault(
                f"the metadata from line {segment.line} on lack {keyword}, which is required in "
                "every segment."
            )
    return "data"


def _keyword(segment, line, lines):
    """Add a line KEYWORD = value to the metadata of a segment."""
    keyword, value = kvn.pair(lines, line)
    if not value:
        raise lines.fault(f"{keyword} has no value.")
    if keyword not in _KNOWN:
        raise lines.fault(
            f"{keyword} is no keyword of OEM metadata; these are {', '.join(_KNOWN)}."
        )
    if keyword in segment.given:
        raise lines.fault(f"{keyword} is given twice.")
    segment.given[keyword] = value


def _state(segment, text, lines):
    """Add a line with an epoch and a state to a segment."""
    time, *numbers = text.split()
    try:
        state = [float(each) for each in numbers]
    except ValueError:
        state = []
    if len(state) not in (6, 9) or not np.isfinite(state).all():
        raise lines.fault(
            f"{kvn.shown(text)} is no state; it must be an epoch and 6 finite numbers (km, km/s), "
            "or 9 with accelerations."
        )
    segment.times.append(time)
    segment.states.append(state[:6])
    segment.lines.append(lines.number)


def _path(segment, origin, degree):
    """The path of one segment of a file."""
    given = segment.given
    where = f"{origin}, segment at line {segment.line}"
    if given["TIME_SYSTEM"] not in _SYSTEMS:
        raise AttitudeError(
            f"{where}: TIME_SYSTEM is {given['TIME_SYSTEM']}; it must be one of "
            f"{', '.join(_SYSTEMS)}."
        )
    frame = _FRAMES.get(given["REF_FRAME"])
    if frame is None:
        raise AttitudeError(
            f"{where}: REF_FRAME is {given['REF_FRAME']}; it must be one of these inertial frames: "
            f"{', '.join(_FRAMES)}."
        )
    if not segment.states:
        raise AttitudeError(f"{where}: there are no states.")
    interpolation, degree = _interpolation(given, where, degree)
    states = 1e3 * np.array(segment.states)
    try:
        return table(
            [_dated(each, given) for each in segment.times],
            states[:, :3],
            states[:, 3:],
            interpolation=interpolation,
            degree=degree,
            center=body_name(given["CENTER_NAME"], "CENTER_NAME"),
            frame=frames.known(frame),
            name=given["OBJECT_NAME"],
            source=os.path.basename(origin),
            span=_useable(segment, where),
        )
    except AttitudeError as err:
        last = segment.lines[-1]
        raise AttitudeError(f"{where} (states to line {last}): {err}") from err


def _interpolation(given, where, degree):
    """The interpolation and degree of a segment, as `table` takes them."""
    name = given.get("INTERPOLATION", "HERMITE").upper()
    if degree is None:
        text = given.get("INTERPOLATION_DEGREE", "1" if name == "LINEAR" else "7")
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


def _useable(segment, where):
    """The span of a segment: its useable time, which lies within its states."""
    given = segment.given
    first = given.get("USEABLE_START_TIME", segment.times[0])
    last = given.get("USEABLE_STOP_TIME", segment.times[-1])
    span = tuple(_inputs.instant(_dated(each, given), "epoch") for each in (first, last))
    ends = [_inputs.instant(_dated(segment.times[k], given), "epoch") for k in (0, -1)]
    if not _before(ends[0], span[0]) or not _before(span[1], ends[1]):
        raise AttitudeError(
            f"{where}: the useable time {first} to {last} is not within the states, "
            f"{segment.times[0]} to {segment.times[-1]}."
        )
    return span


def _before(one, other):
    """Whether one instant is not later than another."""
    return (one.seconds, one.low) <= (other.seconds, other.low)


def _dated(text, given):
    """An epoch of a segment as text with its time system."""
    return f"{text.removesuffix('Z')} {given['TIME_SYSTEM']}"
