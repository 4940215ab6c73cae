"""STK attitude files (.a): quaternions with and without rates, matrices, angles, vectors.

STK's quaternions turn the reference axes into those of the body, vector part first; they have the
numbers of the quaternion body to axes of this package, scalar last.  Rates are deg/s over the body
axes; Euler angles are deg, in the order of the sequence, as in `representations.from_euler`;
matrices are v_body = A v_axes, row by row.  ScenarioEpoch is UTC, and the times of records are
seconds of TAI since then, in one double: from a whole second of UTC, they are accurate to 1e-11 s
for spans of a day.

"J2000" is the mean equator and equinox of J2000, "ICRF" and "Inertial" of the Earth the ICRF,
"Fixed" ITRF, "VVLH" axes of an orbit; "TrueOfDate", "MeanOfDate" and "TEMEOfDate" also as
"...OfEpoch" with CoordinateAxesEpoch.  Fixed and those of date are known for the Earth.  A file
without InterpolationOrder is interpolated with order 1, as STK does, and so is one of order 0.
What else STK writes is read as well; what is refused is refused by name.
"""

from __future__ import annotations

import datetime
import os
import re
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._support import pairs
from attitude._support.arrays import units
from attitude._support.constants import DAY_S
from attitude._textfiles.atomic_write import require_writable, written_whole
from attitude._textfiles.lines import is_number, opened, text_of_rows
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _time_scales
from attitude.epochs._instants import J2000, Instant
from attitude.errors import AttitudeError
from attitude.formats import _sampling
from attitude.formats._format import Format, Option, refuse_foreign, register, table_reader
from attitude.formats._records import (
    LATEST,
    TOLERANCE,
    Convention,
    Rows,
    columns_of,
    known_tolerance,
)
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _axes as motions_axes
from attitude.motions import _table
from attitude.motions._table import AttitudeTable
from attitude.paths._tabulated import MOST_DEGREE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import EpochOrSeconds, Epochs, FilePath, FloatArray
    from attitude._textfiles.lines import Lines
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._axes import Axes
    from attitude.paths._path import Path

__all__ = ["read", "write"]


# ---- Dates as STK writes them, and the times of records
# ScenarioEpoch and TimeFormat UTCG: ``1 Jul 1999 00:00:00.00``, the month by three letters or its
# whole name, with or without quotation marks; also ISO 8601.  TimeFormat says what stands before
# the numbers of a record: EpSec (the default), EpMin, EpHr and EpDay count from ScenarioEpoch in
# TAI.

MONTHS: tuple[str, ...] = (
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
)
_DATE = re.compile(r"(\d{1,2}) ([A-Za-z]{3,9}) (\d{4}) (\d{1,2}):(\d{2}):(\d{2})(\.\d*)?", re.ASCII)
_ISO = re.compile(r"\d{4}-(\d{2}-\d{2}|\d{3})T\d{2}:\d{2}:\d{2}(\.\d*)?Z?", re.ASCII)
# TimeFormat in lower case -> seconds of its unit, and for dates the words of one.
UNITS: dict[str, float] = {"epsec": 1.0, "epmin": 60.0, "ephr": 3600.0, "epday": DAY_S}
DATES: dict[str, int] = {"utcg": 4, "iso-ymd": 1, "iso-yd": 1}
FORMATS: str = "EpSec, EpMin, EpHr, EpDay, UTCG, ISO-YMD, ISO-YD"


def iso(text: str) -> str | None:
    """A date as CCSDS time code, or None if it is no date of STK.

    >>> iso('"1 July 1999 00:00:00.00"'), iso("1 Jul 1999 7:30:00"), iso("Today")
    ('1999-07-01T00:00:00.00', '1999-07-01T07:30:00', None)
    """
    date_text = " ".join(text.strip().strip("\"'").split())
    if _ISO.fullmatch(date_text):
        return date_text
    match = _DATE.fullmatch(date_text)
    if match is None:
        return None
    date, month, year, hour, minute, second, fraction = match.groups()
    months = [k for k, name in enumerate(MONTHS) if month.title() in (name, name[:3])]
    if not months:
        return None
    time = f"{int(hour):02d}:{minute}:{second}{fraction or ''}".rstrip(".")
    return f"{year}-{months[0] + 1:02d}-{int(date):02d}T{time}"


def instant(text: str, what: str) -> Instant:
    """The Instant of a date in UTC; `what` is the name of the keyword in the error message."""
    code = iso(text)
    if code is None:
        shown = repr(text[:40]) if text else "not given"
        raise AttitudeError(
            f"{what} is {shown}; write a date in UTC like 1 Jan 2026 00:00:00.000, and not the "
            "name of a time that STK knows."
        )
    try:
        return ccsds_epochs.instant(code, "utc")
    except ccsds_epochs.BadEpoch as err:
        raise AttitudeError(f"{what} is {text[:40]!r}: {err.reason}.") from err


def _tai_of(hi, lo):
    """TAI seconds since J2000, hi and lo, of TDB seconds since J2000."""
    return pairs.add(_time_scales.tt_from_tdb(hi, lo), -_time_scales.TT_MINUS_TAI)


# ---- The sections of an STK attitude file: the columns of each, as attitudes
# Yaw, pitch and roll (YPR) stand in this order; they turn the body about the axes z, y and x of the
# reference in the order of Sequence, so that the rotation is that of Euler angles in the inverse
# order.  Sections of rates alone give the angles at the first record (InitialEulerAngle,
# InitialYPRAngle); the angles follow from rates that are linear between records.  Vectors are the
# direction of body x in J2000 (ECI) or Fixed (ECF), with body z as near to the center as it can be;
# CoordinateAxes has no effect on them.
#
# Source: help of STK 12, "Attitude File Format (*.a)" and "AddAttitude ECIYPR".


class Section(NamedTuple):
    """What rows of a section hold: a CCSDS attitude type, numbers behind the time, form."""

    kind: str
    width: int
    form: str
    scalar_first: bool = False
    initial: str | None = None  # keyword of the angles at the first record
    axes: str | None = None  # those that CoordinateAxes cannot set


_BOTH = "EULER_ANGLE/DERIVATIVE"
SECTIONS: dict[str, Section] = {
    "AttitudeTimeQuaternions": Section("QUATERNION", 4, "quaternion"),
    "AttitudeTimeQuatScalarFirst": Section("QUATERNION", 4, "quaternion", scalar_first=True),
    "AttitudeTimeQuatAngVels": Section("QUATERNION/ANGVEL", 7, "quaternion"),
    "AttitudeTimeEulerAngles": Section("EULER_ANGLE", 3, "euler"),
    "AttitudeTimeYPRAngles": Section("EULER_ANGLE", 3, "ypr"),
    "AttitudeTimeEulerAnglesAndRates": Section(_BOTH, 6, "euler"),
    "AttitudeTimeYPRAnglesAndRates": Section(_BOTH, 6, "ypr"),
    "AttitudeTimeEulerAngleRates": Section(_BOTH, 3, "euler rates", initial="InitialEulerAngle"),
    "AttitudeTimeYPRAngleRates": Section(_BOTH, 3, "ypr rates", initial="InitialYPRAngle"),
    "AttitudeTimeDCM": Section("QUATERNION", 9, "matrix"),
    "AttitudeTimeDCMAngVels": Section("QUATERNION/ANGVEL", 12, "matrix"),
    "AttitudeTimeECIVector": Section("QUATERNION", 3, "vector", axes="EME2000"),
    "AttitudeTimeECFVector": Section("QUATERNION", 3, "vector", axes="ITRF"),
}
# Sections that are refused by name, each with the reason.
REFUSED: dict[str, str] = {
    "AttitudeTimeAngVels": "it holds angular velocities without attitudes, which fit_rates takes",
    "AttitudeTimeAzElAngles": "it holds the pointing of a sensor",
    "AttitudeTimeAzElAnglesAndRates": "it holds the pointing of a sensor",
}
# Sequences that the sections take if the file gives none.
USUAL: dict[str, str] = {"euler": "313", "ypr": "321"}


class Decoder:
    """Rows of a section to the columns of its CCSDS attitude type, with Euler angles of `sequence`.

    initial: the angles at the first record, deg, in the order of the section's columns.
    """

    def __init__(
        self, section: Section, sequence: str | None, initial: Sequence[float] | None = None
    ):
        self.section: Section = section
        self.sequence: str | None = sequence
        self._places = [0, 1, 2]
        if section.form.startswith("ypr"):
            assert sequence is not None
            if len(set(sequence.upper())) < 3:
                raise AttitudeError(
                    f"Sequence is {sequence}; yaw, pitch and roll turn about each axis once."
                )
            self.sequence = sequence[::-1].upper()
            self._places = ["ZYX".index(axis) for axis in self.sequence]
        self._angles = None if initial is None else np.array(initial, dtype=float)
        self._before: tuple[float, FloatArray] | None = None

    def columns(self, seconds: FloatArray, values: FloatArray) -> FloatArray:
        """The columns (N, columns) of the attitude type, at seconds (N,) from values (N, width)."""
        form = self.section.form
        if form == "matrix":
            wxyz = forms.from_dcm(values[:, :9].reshape(-1, 3, 3))
            return np.concatenate([forms.to_xyzw(wxyz), values[:, 9:]], axis=1)
        if form.endswith("rates"):
            values = np.concatenate([self._integrated(seconds, values), values], axis=1)
        if form.startswith(("ypr", "euler")):
            groups = [values[:, k : k + 3][:, self._places] for k in range(0, values.shape[1], 3)]
            return np.concatenate(groups, axis=1)
        return values

    def _integrated(self, seconds, rates):
        """The angles (N, 3): those of the first record, and the integral of linear rates."""
        if self._before is not None:
            seconds = np.concatenate([[self._before[0]], seconds])
            rates = np.concatenate([self._before[1][None], rates])
        steps = np.diff(seconds)[:, None] * 0.5 * (rates[1:] + rates[:-1])
        integrals = self._angles + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        self._angles, first = integrals[-1], self._before is not None
        self._before = seconds[-1], rates[-1]
        return integrals[1:] if first else integrals


def _pointed(values, axes, epoch, hi, lo, orbit):
    """Quaternions (N, 4), scalar last, of body x along values (N, 3), body z nearest the center."""
    position = motions_axes.state(hi, lo, orbit, "the direction to the center")[0]
    outer = axes.to_icrf(epoch, hi, lo, orbit)
    nadir = -quaternion.rotate(quaternion.conjugate(outer), position)
    x, down = (_unit(v) for v in (values, nadir))
    y = np.cross(down, x)
    length = np.linalg.norm(y, axis=1, keepdims=True)
    if not np.all(length > 1e-9):
        raise AttitudeError(
            "a vector is of length zero or points to or away from the center, which leaves the "
            "rotation about it undefined."
        )
    y = y / length
    return forms.to_xyzw(quaternion.from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1)))


def _unit(v):
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return units(v / np.max(np.abs(v), axis=1, keepdims=True))


# ---- The head of an STK attitude file: version, keywords, axes, interpolation, times

_KEYWORDS = (
    "MessageLevel",
    "NumberOfAttitudePoints",
    "BlockingFactor",
    "InterpolationOrder",
    "InterpolationMethod",
    "CentralBody",
    "ScenarioEpoch",
    "TimeFormat",
    "CoordinateAxes",
    "CoordinateAxesEpoch",
    "Sequence",
    "AttitudeDeviations",
    "InitialQuaternion",
    "InitialEulerAngle",
    "InitialYPRAngle",
)
_BY_LOWER = {name.lower(): name for name in (*SECTIONS, *REFUSED)}
_KEYWORD_BY_LOWER = {name.lower(): name for name in _KEYWORDS}
# Names of STK for axes that other files name otherwise.
_AXES = {"fixed": "ITRF", "vvlh": "LVLH", "inertial": "ICRF"}
# Kind of axes that STK defines for each body -> the bodies for which they are known.
_OF_BODIES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys({*motions_axes.TURNING.values()} - {*motions_axes.OF_ORBIT}, ("Earth",)),
    "inertial": ("Earth", "Sun"),  # ICRF
}


class Header:
    """The keywords of a file up to the name of its section, which are read from its lines.

    AttitudeError for a file that is no STK attitude file, and keywords or values that are not
        known.
    """

    def __init__(self, lines: Lines):
        self._lines = lines
        self.keywords: dict[str, str] = {}
        self._where: dict[str, int] = {}
        _read_banner(lines)
        self.section: Section = SECTIONS[self._read_keywords()]
        self.count: int | None = self._whole("NumberOfAttitudePoints", None)
        self.interpolation: dict[str, Any] = self._interpolation()
        time_format = self.keywords.get("TimeFormat", "EpSec").strip("\"'")
        self.time_format: str = time_format.lower()
        if self.time_format not in (*UNITS, *DATES):
            raise self._fault(
                "TimeFormat", f"TimeFormat is {time_format[:40]!r}; known are {FORMATS}."
            )
        # Checked before the records are read.
        self.decoder: Decoder = self._decoder()

    def _fault(self, keyword, sentence):
        """The error for the value of a keyword."""
        return self._lines.fault(sentence, self._where.get(keyword))

    def _located(self, keyword, what=""):
        """AttitudeErrors inside are those of a keyword."""
        return self._lines.located(self._where.get(keyword), what)

    def start(self) -> tuple[np.float64, np.float64]:
        """ScenarioEpoch: TAI seconds since J2000 in two doubles."""
        with self._located("ScenarioEpoch"):
            start = instant(self.keywords.get("ScenarioEpoch", ""), "ScenarioEpoch")
        hi, lo = _tai_of(np.float64(start.seconds), np.float64(start.low))
        return np.float64(hi), np.float64(lo)

    def axes(self, frame: str | None) -> Axes:
        """The reference axes; `frame` replaces CoordinateAxes."""
        with self._located("CoordinateAxes"):
            if frame is not None:
                return motions_axes.named(frame)
            if self.section.axes is not None:
                return self._axes(self.section.axes)
            if "CoordinateAxes" not in self.keywords:
                raise AttitudeError(
                    "the file has no CoordinateAxes, which names the axes that the attitudes are "
                    f"relative to; add it to the file, or give {motions_axes.AS_FRAME}."
                )
            return self._axes(self.keywords["CoordinateAxes"])

    def _axes(self, name):
        words = name.split()
        custom = len(words) > 1 and words[0].lower() in ("custom", "awb")
        lower = (words[1] if custom else name).lower()
        if custom and lower != "vvlh":
            raise AttitudeError(
                f"CoordinateAxes is {name[:40]!r}, axes that a scenario of STK defines; give "
                f"what they are with {motions_axes.AS_FRAME}."
            )
        if lower == "lvlh":
            raise AttitudeError(
                "CoordinateAxes is LVLH, in which STK's x points away from the center, as that of "
                'RTN, and that of CCSDS along the orbit; give frame="RTN" or frame="LVLH" (on the '
                "command line --frame-in)."
            )
        kind = motions_axes.OF_EPOCH.get(motions_axes.normal(lower))
        if kind is not None:
            epoch = instant(self.keywords.get("CoordinateAxesEpoch", ""), "CoordinateAxesEpoch")
            axes = motions_axes.Axes(name, kind, at=epoch)
        else:
            known = _AXES.get(lower, lower if custom else name)
            axes = motions_axes.named(known, "CoordinateAxes")
        kind = lower if lower == "inertial" else axes.kind
        _refuse_body(kind, name, self.keywords.get("CentralBody", ""))
        return axes

    def _read_keywords(self):
        """The name of the section; sets `keywords`."""
        lines = self._lines
        for text in lines.texts():
            keyword, value = (*text.split(None, 1), "")[:2]
            known = _BY_LOWER.get(keyword.lower())
            if known in REFUSED:
                raise lines.fault(f"the section {known} is not read: {REFUSED[known]}.")
            if known is not None and not value:
                return known
            name = _KEYWORD_BY_LOWER.get(keyword.lower())
            if name is None:
                raise lines.fault(
                    f"{keyword[:40]!r} is not known; known are {', '.join(_KEYWORDS)} and "
                    "sections such as AttitudeTimeQuaternions."
                )
            if name in self.keywords:
                raise lines.fault(f"{name} is given twice.")
            self.keywords[name], self._where[name] = value.strip(), lines.number
        raise lines.fault("the file ends before its data; is it cut off?")

    def _whole(self, keyword, default):
        text = self.keywords.get(keyword)
        if text is None:
            return default
        # MATLAB's %f, with which many write these files, writes 3.000000.
        if not re.fullmatch(r"\d{1,12}(\.0*)?", text, re.ASCII):
            raise self._fault(keyword, f"{keyword} is {text[:40]!r}; give a whole number.")
        return int(text.partition(".")[0])

    def _interpolation(self):
        """Method and degree, as of AttitudeTable."""
        degree, most = self._whole("InterpolationOrder", 1), MOST_DEGREE
        if degree > most:
            raise self._fault(
                "InterpolationOrder", f"InterpolationOrder is {degree}; it must be 0 to {most}."
            )
        method = self.keywords.get("InterpolationMethod", "Lagrange")
        if method.lower() not in ("lagrange", "hermite"):
            raise self._fault(
                "InterpolationMethod",
                f"InterpolationMethod is {method[:40]!r}; give Lagrange or Hermite.",
            )
        if degree < 2:
            return {"method": "slerp", "degree": 1}
        return {"method": method.lower(), "degree": degree}

    def _decoder(self):
        """The Decoder of the section, from Sequence and the angles at the first record."""
        section, keyword = self.section, self.section.initial or "Sequence"
        form = section.form.partition(" ")[0]
        if form not in USUAL:
            return Decoder(section, None)
        sequence, initial = self.keywords.get("Sequence", USUAL[form]), None
        with self._located(keyword, f"{keyword}: "):
            if section.initial is not None:
                words = self.keywords.get(keyword, "").split()
                if len(words) != 4 or not all(map(is_number, (w.encode() for w in words[1:]))):
                    raise AttitudeError(
                        f"it is {' '.join(words)[:40]!r}; the section has rates alone and needs a "
                        "sequence and three angles in deg."
                    )
                sequence, initial = words[0], [float(word) for word in words[1:]]
                if not np.all(np.isfinite(initial)):
                    raise AttitudeError("an angle is not finite.")
            # Letters in lower case would be axes outside of the body.
            sequence = sequence.upper()
            if form == "ypr":
                sequence = sequence.translate(str.maketrans("RPY", "XYZ"))
            return Decoder(section, quaternion.known_sequence(sequence), initial)


def _refuse_body(kind, name, body):
    """AttitudeError for axes of a CentralBody other than the bodies for which they are known."""
    bodies = _OF_BODIES.get(kind)
    if bodies and body and body.title() not in bodies:
        raise AttitudeError(
            f"the axes are {name[:40]} of {body[:40]!r}, and are known for the "
            f"{' and the '.join(bodies)} only: give what they are with {motions_axes.AS_FRAME}."
        )


def _read_banner(lines):
    texts = lines.texts()
    for text in texts:
        if not re.fullmatch(r"stk\.v\.\d+\.\d+(\.\d+)?", text, re.ASCII | re.IGNORECASE):
            raise lines.fault(f"it begins with {text[:40]!r}; an STK file begins with stk.v.")
        break
    for text in texts:
        if not re.fullmatch(r"BEGIN\s+Attitude", text, re.IGNORECASE):
            raise lines.fault(f"{text[:40]!r} stands where BEGIN Attitude must be.")
        return
    raise lines.fault("the file ends before BEGIN Attitude; is it an STK attitude file?")


# Sections that are written.
WRITTEN: tuple[str, ...] = (
    "AttitudeTimeQuatAngVels",
    "AttitudeTimeQuaternions",
    "AttitudeTimeQuatScalarFirst",
    "AttitudeTimeEulerAngles",
)
# Kind of axes -> name in STK.
_NAMES = {
    **{"icrf": "ICRF", "eme2000": "J2000", "itrf": "Fixed", "teme": "TEMEOfDate", "lvlh": "VVLH"},
    **{"tod": "TrueOfDate", "mod": "MeanOfDate", "b1950": "B1950"},
}


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
) -> AttitudeTable:
    """An STK attitude file as an AttitudeTable; see `aem.read` for parameters and errors."""
    known_tolerance(tolerance)
    with opened(path) as lines:
        header = Header(lines)
        records = _Records(lines, header, frame, orbit)
        has_ended = records.read(lines)
        if header.count is not None and records.count != header.count:
            raise lines.fault(
                f"the file has {records.count} records, but NumberOfAttitudePoints is "
                f"{header.count}" + ("." if has_ended else "; is it cut off?"),
            )
        convention = Convention(
            scalar_first=header.section.scalar_first, sequence=header.decoder.sequence
        )
        meta = {
            "format": "STK",
            "keywords": dict(header.keywords),
            "frame": records.axes.name,
            "center": header.keywords.get("CentralBody"),
        }
        with lines.located():
            return records.table(
                header.section.kind,
                convention,
                records.axes,
                tolerance=tolerance,
                orbit=orbit,
                meta=meta,
                **header.interpolation,
            )


class _Records(Rows):
    """The records behind the keywords of a file; axes are those of the file."""

    def __init__(self, lines, header, frame, orbit):
        lead, width = DATES.get(header.time_format, 1), header.section.width
        super().__init__("utc", lines.fault, ("",) * width, lead)
        words = f" of {lead} words" if lead > 1 else ""
        self.holds = f"a record has a time{words} and {width} numbers"
        self.axes = header.axes(frame)
        self._start = header.start() if header.time_format in UNITS else None
        self._header, self._orbit, self._origin = header, orbit, None
        if header.section.form == "vector":
            motions_axes.known_path(orbit, "the direction to the center")

    def read(self, lines):
        """Take the records up to END Attitude; False if the file ends before it."""
        for line in lines:
            tokens = line.replace(b'"', b"").split()
            if not tokens or tokens[0].startswith(b"#"):
                continue
            if len(tokens) != self.step and [word.lower() for word in tokens] == _END:
                self.convert()
                self._refuse_more(lines)
                return True
            self.take(self.known(tokens, lines.number), lines.number)
        self.convert()
        return False

    def _refuse_more(self, lines):
        """AttitudeError for lines behind END Attitude, but the plots of STK's simulator."""
        is_plotted = False
        for line in lines:
            words = line.lower().split()[:2] or [b"#"]
            if words[-1] == b"datagroup" and words[0] in (b"begin", b"end"):
                is_plotted = words[0] == b"begin"
            elif not is_plotted and not words[0].startswith(b"#"):
                raise lines.fault("there is more after END Attitude; delete it.")

    def add(self, leads, values, lines):
        """Add N records, of which the first ones have the lines."""
        finite = np.isfinite(values).all(axis=1)
        if not np.all(finite):
            raise self.fault("it holds a number that is not finite.", lines[int(np.argmin(finite))])
        hi, lo = self._epochs(leads, lines)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                if self._origin is None:
                    self._origin = hi[0], lo[0]
                seconds = (hi - self._origin[0]) + (lo - self._origin[1])
                values = self._header.decoder.columns(seconds, values)
                if self._header.section.form == "vector":
                    values = _pointed(values, self.axes, J2000, hi, lo, self._orbit)
        except AttitudeError as err:
            raise self.fault(f"in the records from here on, {err}", lines[0]) from err
        self.add_times(hi, lo, values, lines)

    def _epochs(self, leads, lines):
        """TDB seconds since J2000, hi and lo, of some rows."""
        if self._start is None:
            texts = (
                b" ".join(words).decode("ascii", "replace") for words in zip(*leads, strict=True)
            )
            # A date that STK does not write stays as it is; the reader of time codes refuses it.
            codes = [(iso(text) or text).encode("ascii", "replace") for text in texts]
            try:
                return ccsds_epochs.parsed(codes, "utc")
            except ccsds_epochs.BadEpoch as err:
                shown = codes[err.index][:40].decode("ascii", "replace")
                raise self.fault(
                    f"the time {shown!r} cannot be read: {err.reason}.", lines[err.index]
                ) from err
        seconds = self.seconds_of(leads[0], lines)
        is_near = np.abs(seconds) <= LATEST
        if not np.all(is_near):
            reason = f"its time is not finite, or beyond {LATEST:g}."
            raise self.fault(reason, lines[int(np.argmin(is_near))])
        unit = UNITS[self._header.time_format]
        pair = (seconds, 0.0) if unit == 1.0 else pairs.product(seconds, unit)
        return _time_scales.tdb_from("tai", *pairs.add(self._start, *pair))


_END = [b"end", b"attitude"]


# ---- Writing


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    tolerance: float | None = None,
    section: str | None = None,
    frame: str = "ICRF",
    sequence: str = "ZXZ",
    center: str = "Earth",
    order: int | None = None,
    orbit: Path | None = None,
    split: bool = False,
) -> SampledFile | None:
    """Write attitudes as an STK attitude file.

    Parameters
    ----------
    path, source, t, start, stop, tolerance
        As in `aem.write`; one segment.
    section : str, optional
        "AttitudeTimeQuatAngVels" by default, "AttitudeTimeQuaternions" without rates; also
        "AttitudeTimeQuatScalarFirst" and "AttitudeTimeEulerAngles".
    frame : str
        "ICRF", "J2000" (EME2000), "B1950", "Fixed", "TrueOfDate", "MeanOfDate", "TEMEOfDate" or
        "VVLH" (with orbit=).
    sequence : str
        Axes of Euler angles.
    center : str
        CentralBody.
    order : int, optional
        InterpolationOrder: by default that of a table or 7, less if there are few records.
    orbit : Path, optional
        Path of the body about its center, for VVLH.
    split : bool
        Write a file for each stretch without jumps and gaps, if there are several: x-1.a, x-2.a,
        ... for x.a.

    Returns
    -------
    SampledFile or None
        As `aem.write`; of several files their sums and the largest step and error.

    Raises
    ------
    AttitudeError
        For several segments, an unknown section, frame, sequence or order, and a file that cannot
        be written.
    """
    refuse_foreign(path, "stk")
    has_rates = _sampling.known_of(source, t)[1]
    section = section or ("AttitudeTimeQuatAngVels" if has_rates else "AttitudeTimeQuaternions")
    if section not in WRITTEN:
        raise AttitudeError(f"section is {section!r}; it must be one of {', '.join(WRITTEN)}.")
    axes = motions_axes.named(_AXES.get(str(frame).lower(), frame))
    if axes.kind not in _NAMES:
        raise AttitudeError(
            f"frame is {frame!r}, which STK attitude files do not know; give one of "
            f"{', '.join(_NAMES.values())}."
        )
    _refuse_body(axes.kind, _NAMES[axes.kind], center)
    sequence = quaternion.known_sequence(sequence).upper()
    if order is not None and not (isinstance(order, int) and 1 <= order <= MOST_DEGREE):
        raise AttitudeError(f"order is {order!r}; give a whole number from 1 to {MOST_DEGREE}.")
    head = {"CentralBody": center, "CoordinateAxes": _NAMES[axes.kind]}
    if SECTIONS[section].kind == "EULER_ANGLE":
        head["Sequence"] = sequence.translate(str.maketrans("XYZ", "123"))
    convention = Convention(scalar_first=SECTIONS[section].scalar_first, sequence=sequence)
    write_file = partial(
        _write, section=section, axes=axes, convention=convention, head=head, orbit=orbit
    )
    is_of_records = split and tolerance is None and start is None and stop is None
    if is_of_records and len(parts := _sampling.segments(source, t)) > 1:
        _sampling.warn_of_usable(parts, "an STK file")
        for name, records in zip(_names(path, len(parts)), parts, strict=True):
            write_file(name, records, order=order)
        return None
    degree = order or (source.degree if isinstance(source, AttitudeTable) else _table.USUAL_DEGREE)
    kept = order if tolerance is None else degree
    how_written = _sampling.Writing(
        ("slerp" if degree == 1 else "lagrange", degree),
        lambda target, parts: write_file(target, parts[0], order=kept),
        lambda target: read(target, orbit=orbit),
        name="an STK file",
        holder="an STK file",
    )
    span = start, stop
    if tolerance is None or t is not None or not split:
        return _sampling.write(path, source, t, span, tolerance, how_written)
    count = len(_sampling.stretches_of(source, span))
    files = [
        _sampling.sampled(name, source, span, tolerance, how_written, stretch=k)
        for k, name in enumerate(_names(path, count))
    ]
    return _sampling.SampledFile(
        sum(file.records for file in files),
        sum(file.segments for file in files),
        max(file.step for file in files),
        max(file.error for file in files),
    )


def _names(path, count):
    """The names of the files of `count` stretches."""
    if count == 1:
        return [path]
    stem, ending = os.path.splitext(os.fspath(path))
    names = [f"{stem}-{k + 1}{ending}" for k in range(count)]
    for name in names:  # before the first of them is written
        require_writable(name, "the STK file")
    return names


def _write(path, records, *, section, axes, convention, head, order, orbit):
    """Write one segment; `head` are the keywords that do not depend on its records."""
    start, shift = _whole_second(records)
    if order is None:
        order = records.table.degree if records.table is not None else _table.USUAL_DEGREE
        order = max(min(order, len(records) - 1), 1)
    numbers_of = {
        "NumberOfAttitudePoints": len(records),
        "BlockingFactor": 20,
        "InterpolationOrder": order,
    }
    with written_whole(path, "the STK file") as file:
        file.write("stk.v.11.0\n\nBEGIN Attitude\n\n")
        for key, value in (*numbers_of.items(), ("ScenarioEpoch", start), *head.items()):
            file.write(f"{key} {value}\n")
        file.write(f"\n{section}\n\n")
        kind = SECTIONS[section].kind
        for history, columns in columns_of(records.pieces(), kind, convention, axes, orbit):
            file.write(text_of_rows(shift(history).tolist(), columns.T.tolist(), " "))
        file.write("\nEND Attitude\n")


def _whole_second(records):
    """ScenarioEpoch (a whole second) as text, and a function: history -> seconds of TAI since."""
    seconds, low = records.first_and_last()
    hi, lo = pairs.add((seconds[0], low[0]), records.epoch.seconds, records.epoch.low)
    text = ccsds_epochs.texts(J2000, np.array([hi]), np.array([lo]), "utc", 12)[0]
    text = text.partition(".")[0]
    whole = ccsds_epochs.instant(text, "utc")
    tai0 = _tai_of(np.float64(whole.seconds), np.float64(whole.low))
    date = datetime.date.fromisoformat(text[:10])
    shown = f"{date.day} {MONTHS[date.month - 1][:3]} {date.year:04d} {text[11:]}.000000000"

    def shift(history):
        epoch = history.epoch
        tai = _tai_of(*pairs.Seconds.of(history).plus(epoch.seconds, epoch.low))
        hi, lo = pairs.add(tai, -tai0[0], -tai0[1])
        return hi + lo

    return shown, shift


register(
    Format(
        name="stk",
        module=__name__,
        title="STK attitude",
        endings=(".a",),
        marks=(b"stk.v.",),
        read=table_reader(read),
        reading=("tolerance", "frame", "orbit"),
        write=write,
        writing=("type", "frame", "orbit", "split"),
        renamed={"type": "section"},
        noun="an STK file",
        options=(
            Option(
                "split",
                "STK: a file x-1.a, x-2.a, ... for each stretch between impulses or gaps, "
                "each whole or not at all",
                {"action": "store_true"},
                refusal="is for STK files, not {output}; leave it out.",
            ),
        ),
        fulfilled={"for": "stk"},
    )
)
