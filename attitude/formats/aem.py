"""CCSDS Attitude Ephemeris Messages, versions 1.0 and 2.0, KVN and XML, read and written.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.aem")
...     write(path, motion.at([0.0, 10.0, 20.0]), object_name="SATELLITE")
...     table = read(path)
>>> table.wxyz.shape, table.method, table.degree, table.epoch.utc_iso
((3, 4), 'hermite', 5, '2026-01-01T00:00:00')

For the conventions see `_records`.  Quaternions are written with 17 digits and come back
with the same bits, epochs within half a picosecond if they need 12 decimals, else within 1e-11 s;
the motion between records is not in the file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from attitude._support.synonyms import arguments
from attitude._textfiles import messages
from attitude.errors import AttitudeError
from attitude.formats import _aem_message, _recipes, _records, _sampling
from attitude.formats._aem_message import Options, WrittenSegment, written_kind
from attitude.formats._format import (
    Option,
    message_labels,
    refuse_foreign,
    register_message,
    table_reader,
)
from attitude.formats._messages import VERSIONS, written_header
from attitude.formats._records import TOLERANCE
from attitude.frames import quaternion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import EpochOrSeconds, Epochs, FilePath
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._table import AttitudeTable
    from attitude.paths._path import Path

__all__ = ["read", "write"]


@arguments({}, 'aem.read("m.aem")')
def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    rates: str | None = None,
    object: str | None = None,
    segment: int | None = None,
    lenient: bool = False,
) -> AttitudeTable:
    """A message as an AttitudeTable.

    Parameters
    ----------
    path : str or path
        KVN or XML, version 1.0 or 2.0, recognized by the content.
    tolerance : float
        Largest deviation from 1 of the length of a quaternion; quaternions are made unit.
    frame : str, optional
        The external axes of the file, if their name in the file is not known; names that are
        known stand in motions/_axes.py.
    orbit : Path, optional
        Path of the body about its center, for attitudes relative to LVLH or RTN.
    rates : str, optional
        What the rates of QUATERNION/RATE and EULER_ANGLE/RATE of version 1 are: "body", components
        of the angular velocity over the axes of RATE_FRAME, or "euler", derivatives of the angles
        of EULER_ROT_SEQ.  By default "body" with a warning, or "euler" where the file names an axis
        twice (see `old_rates`).
    object : str, optional
        OBJECT_ID or OBJECT_NAME of the segments to read, where the file has several objects.
    segment : int, optional
        The place of the one segment to read, counted from 0.
    lenient : bool
        Read a message in KVN whose operator leaves out DATA_START, DATA_STOP, OBJECT_ID, START_TIME
        or others, adds keywords, or has the columns of MMS (see `lenient`);
        ``table.meta["assumed"]`` lists what was assumed.

    Returns
    -------
    AttitudeTable
        Relative to ICRF; its `meta` and that of each of its segments hold keywords and comments.

    Raises
    ------
    AttitudeError
        For a file that cannot be read or does not follow the standard; the message names file,
        line and keyword.  For segments of several objects or body frames, and segments that
        contradict each other where they overlap.
    """
    options = Options(tolerance, frame, orbit, rates, object, segment, lenient)
    return _aem_message.read(path, _aem_message.FORM, options)


@arguments({"motion": "give source="}, 'aem.write("m.aem", motion, start=0, stop=60)')
def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    tolerance: float | None = None,
    for_: str | None = None,
    version: str | None = None,
    xml: bool = False,
    kind: str | None = None,
    frame: str | None = None,
    time_system: str | None = None,
    rates: str | None = None,
    rates_over: str = "body",
    sequence: str | None = None,
    scalar_first: bool = False,
    object_name: str | None = None,
    object_id: str | None = None,
    center: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    method: str | None = None,
    degree: int | None = None,
    creation_date: str | None = None,
    digits: int | None = None,
    orbit: Path | None = None,
) -> SampledFile | None:
    """Write attitudes as an AEM.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    source : AttitudeHistory, AttitudeTable, a list of them (segments), or a motion with `t`
        A motion is evaluated piece by piece, so that long histories need little memory.
    t : epochs, optional
        Epochs of the records, of any kind that ``.at(t)`` takes; (N,).
    start, stop : epochs, or TDB seconds since the epoch of the motion
        With `tolerance`: the span, by default that of a table.
    tolerance : float, optional
        Instead of `t`: largest angle, rad, between the motion and the attitudes that a reader
        interpolates by the method that the file states; the epochs of the records follow from it
        (see `_sampling`).
    for_ : str, optional
        The tool that shall read the file: "gmat", "orekit", "stk" or "brahe".  Settings that are
        left open become those that the tool accepts (see `_recipes`).
    version : str, optional
        "2.0" by default, or "1.0" (what GMAT and others read).
    xml : bool
        XML instead of KVN.
    kind : str, optional
        The attitude type, by its name in version 2: "QUATERNION/ANGVEL" by default, in version 1
        "QUATERNION/DERIVATIVE"; "QUATERNION" for tables without angular velocities.
    frame : str, optional
        The external axes, by default those of the file that a table was read from, or "ICRF".
    time_system : str, optional
        UTC, TAI, TT, TDB or GPS; by default that of the file that a table was read from, or UTC.
    rates : str, optional
        Version 1.0 with the types QUATERNION/RATE and EULER_ANGLE/RATE, whose readers disagree:
        "body" or "euler", as in `read`.
    rates_over : str
        "body" or "frame": the axes of angular velocities.
    sequence : str, optional
        Axes of Euler angles, "ZXZ" by default.
    scalar_first : bool
        Version 1.0: QC before Q1, Q2, Q3.
    object_name, object_id, center, body_frame, originator : str, optional
        Keywords; by default those of the file that a table was read from, or "UNKNOWN".
    comments : sequence of str, optional
        Comments of the header; by default those of the file that a table was read from.
    method, degree : str, int, optional
        Interpolation recommended to readers: by default that of a table, or Hermite or Lagrange of
        degree 7, less if there are few records.
    creation_date : str, optional
        Now, in UTC, by default.
    digits : int, optional
        Decimals of the seconds, 0 to 18; by default the fewest of 3, 6, 9 and 12 that return the
        epochs to 1e-11 s.
    orbit : Path, optional
        Path of the body about its center, for LVLH and RTN.

    Returns
    -------
    SampledFile or None
        With `tolerance`: the number of records, the step and the error of the file read back.

    Raises
    ------
    AttitudeError
        For unknown names of versions, types, axes or time systems, for epochs that do not increase,
        for settings that the tool `for_` does not read, and for a file that cannot be written.
    """
    refuse_foreign(path, "aem")
    meta, has_rates = _sampling.known_of(source, t)
    settings: dict[str, Any] = {
        "version": version,
        "xml": xml,
        "kind": kind,
        "frame": frame,
        "time_system": time_system,
        "rates": _records.known_rates(rates),
        "rates_over": rates_over,
        "sequence": sequence,
        "scalar_first": scalar_first,
        "digits": digits,
        "orbit": orbit,
        "method": method,
        "degree": degree,
        "body_frame": body_frame,
        "for_": for_,
    }
    settings = _recipes.of_aem(for_, settings, has_rates)
    settings["version"] = version = settings["version"] or "2.0"
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; AEM has {' and '.join(VERSIONS)}.")
    settings["sequence"] = quaternion.known_sequence(settings["sequence"] or "ZXZ").upper()
    settings["names"] = (object_name, object_id, center, settings["body_frame"])
    header = written_header(meta, creation_date, originator, comments)
    stated = "", 0
    if tolerance is not None:
        rated = _records.has_rates(written_kind(settings, has_rates))
        stated = _sampling.stated(settings["method"], settings["degree"], rated, source)
        settings["method"], settings["degree"] = stated

    def write_records(target, segments):
        written = [WrittenSegment(records, settings).parts for records in segments]
        messages.write(target, _aem_message.FORM, version, header, written, xml=xml)

    writing = _sampling.Writing(
        stated,
        write_records,
        lambda target: read(target, orbit=orbit, rates=rates),
        "the AEM",
    )
    return _sampling.write(path, source, t, (start, stop), tolerance, writing)


_OPTIONS = (
    Option("version", "of CCSDS messages (default 2.0)", {"metavar": "1.0|2.0"}),
    Option("type", "attitude type of an AEM, section of STK", {"metavar": "NAME"}),
    Option("frame", "axes of OUT, such as ICRF or EME2000", {"metavar": "NAME"}),
    Option(
        "frame-in",
        "external axes of IN, where its file does not name them, such as ICRF or EME2000",
        {"metavar": "NAME"},
        of_reading=True,
    ),
    Option("time-system", "of CCSDS messages: UTC, TAI, TDB, ..", {"metavar": "NAME"}),
    Option(
        "for",
        "settings of an AEM that a tool accepts: gmat, orekit, stk or brahe",
        {"metavar": "TOOL"},
    ),
    Option(
        "rates",
        "what the rates of AEM and APM 1.0 are, read or written: angular velocity, or "
        "derivatives of the Euler angles",
        {"choices": ("body", "euler")},
        of_reading=True,
    ),
    Option(
        "object",
        "OBJECT_ID or OBJECT_NAME of the segments of IN to read",
        {"metavar": "NAME"},
        of_reading=True,
    ),
    Option(
        "segment",
        "the one segment of IN to read, counted from 0",
        {"metavar": "N", "type": int},
        of_reading=True,
    ),
    Option(
        "lenient",
        "read an AEM that leaves out parts of the standard; prints what was assumed",
        {"action": "store_true"},
        of_reading=True,
    ),
    Option(
        "method",
        "interpolation that an AEM states, or of a C-kernel (hermite or linear)",
        {"choices": ("hermite", "lagrange", "linear")},
        refusal="has no meaning for a file like {output}; leave it out.",
    ),
)
register_message(
    "aem",
    "CCSDS AEM",
    write,
    _OPTIONS,
    module=__name__,
    read=table_reader(read),
    reading=("tolerance", "frame", "orbit", "rates", "object", "segment", "lenient"),
    writing=("version", "type", "frame", "time_system", "for", "rates", "method", "orbit"),
    renamed={"type": "kind", "for": "for_"},
    noun="an AEM",
    labels=message_labels,
)
