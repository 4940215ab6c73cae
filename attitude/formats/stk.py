"""STK attitude files (.a): quaternions with and without rates, matrices, Euler angles.

STK's quaternions turn the reference axes into those of the body, vector part first; they have the
numbers of the quaternion body to axes of this package, scalar last.  Rates are deg/s over the body
axes; Euler angles are deg, in the order of the sequence, as in `representations.from_euler`;
matrices are v_body = A v_axes, row by row.  ScenarioEpoch is UTC, and the times of records are
seconds of TAI since then, in one double: from a whole second of UTC, they are accurate to 1e-11 s
for spans of a day.

"J2000" is the mean equator and equinox of J2000, "ICRF" the ICRF, "Fixed" ITRF, "VVLH" axes of an
orbit.  A file without InterpolationOrder is interpolated with order 1, as STK does.
"""

from __future__ import annotations

import datetime
import re
from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs, quaternion
from attitude import representations as forms
from attitude.attitude_table import interpolation
from attitude.epochs import time_scales
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.formats import sources
from attitude.formats.ccsds import axes
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.ccsds.attitude_types import Convention
from attitude.formats.rows import TOLERANCE, Rows, columns_of, known_tolerance
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import NoNumber, numbers, opened

if TYPE_CHECKING:
    from attitude.annotations import Epochs, FilePath
    from attitude.attitude_table.table import AttitudeTable
    from attitude.formats.sources import AttitudeSource
    from attitude.paths.path import Path

# Section -> CCSDS attitude type of its columns, and whether the scalar stands first.
_SECTIONS = {
    "AttitudeTimeQuaternions": ("QUATERNION", False),
    "AttitudeTimeQuatScalarFirst": ("QUATERNION", True),
    "AttitudeTimeQuatAngVels": ("QUATERNION/ANGVEL", False),
    "AttitudeTimeEulerAngles": ("EULER_ANGLE", False),
    "AttitudeTimeDCM": ("DCM", False),
    "AttitudeTimeDCMAngVels": ("DCM/ANGVEL", False),
}
_WIDTHS = {
    **{"QUATERNION": 4, "QUATERNION/ANGVEL": 7, "EULER_ANGLE": 3},
    **{"DCM": 9, "DCM/ANGVEL": 12},
}
_BY_LOWER = {name.lower(): name for name in _SECTIONS}
_KEYWORDS = (
    *("NumberOfAttitudePoints", "BlockingFactor", "InterpolationOrder", "InterpolationMethod"),
    *("CentralBody", "ScenarioEpoch", "CoordinateAxes", "Sequence", "AttitudeDeviations"),
)
_KEYWORD_BY_LOWER = {name.lower(): name for name in _KEYWORDS}
_AXES = {"fixed": "ITRF", "vvlh": "LVLH"}
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_DATE = re.compile(r"(\d{1,2}) ([A-Za-z]{3}) (\d{4}) (\d{2}:\d{2}:\d{2})(\.\d*)?", re.ASCII)
_BATCH = 16384


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
        _read_banner(lines)
        keywords, where, section = _read_keywords(lines)
        reader = _StkReader(lines, keywords, where, section)
        return reader.table(tolerance, frame, orbit)


def _read_banner(lines):
    found = None
    for line in lines:
        text = lines.text(line).strip()
        if not text or text.startswith("#"):
            continue
        if found is None:
            found = re.fullmatch(r"stk\.v\.\d+\.\d+(\.\d+)?", text, re.ASCII | re.IGNORECASE)
            if found is None:
                raise lines.fault(f"it begins with {text[:40]!r}; an STK file begins with stk.v.")
        elif re.fullmatch(r"BEGIN\s+Attitude", text, re.IGNORECASE):
            return
        else:
            raise lines.fault(f"{text[:40]!r} stands where BEGIN Attitude must be.")
    raise lines.fault("the file ends before BEGIN Attitude; is it an STK attitude file?")


def _read_keywords(lines):
    keywords, where = {}, {}
    for line in lines:
        text = lines.text(line).strip()
        if not text or text.startswith("#"):
            continue
        if text.lower() in _BY_LOWER:
            return keywords, where, _BY_LOWER[text.lower()]
        keyword, _, value = text.partition(" ")
        name = _KEYWORD_BY_LOWER.get(keyword.lower())
        if name is None:
            raise lines.fault(
                f"{keyword[:40]!r} is not known; known are {', '.join(_KEYWORDS)} and the sections "
                f"{', '.join(_SECTIONS)}."
            )
        if name in keywords:
            raise lines.fault(f"{name} is given twice.")
        keywords[name], where[name] = value.strip(), lines.number
    raise lines.fault("the file ends before its data; is it cut off?")


class _StkReader:
    """Reads the records behind the keywords of a file."""

    def __init__(self, lines, keywords, where, section):
        self._lines, self._keywords, self._where = lines, keywords, where
        self._kind, self._scalar_first = _SECTIONS[section]
        self._epoch = self._scenario_epoch()
        self._width = _WIDTHS[self._kind]
        self._sequence = None
        if self._kind == "EULER_ANGLE":
            try:
                self._sequence = quaternion.known_sequence(keywords.get("Sequence", ""))
            except AttitudeError as err:
                raise lines.fault(f"Sequence: {err}", where.get("Sequence")) from err
        self._degree = self._whole("InterpolationOrder", 1)
        self._count = self._whole("NumberOfAttitudePoints", None)

    def table(self, tolerance, frame, orbit):
        lines, keywords = self._lines, self._keywords
        given = keywords.get("CoordinateAxes", "")
        try:
            found = axes.named(frame or _AXES.get(given.lower(), given), "CoordinateAxes")
        except AttitudeError as err:
            raise lines.fault(str(err), self._where.get("CoordinateAxes")) from err
        rows = Rows("tai", self._width)
        ended = self._read_rows(rows)
        if self._count is not None and rows.count != self._count:
            raise lines.fault(
                f"the file has {rows.count} records, but NumberOfAttitudePoints is {self._count}"
                + ("." if ended else "; is it cut off?"),
            )
        if not rows.count:
            raise lines.fault("the file has no attitudes.")
        kind = {"DCM": "QUATERNION", "DCM/ANGVEL": "QUATERNION/ANGVEL"}.get(self._kind, self._kind)
        how = Convention(scalar_first=self._scalar_first, sequence=self._sequence)
        meta = {
            "format": "STK",
            "keywords": dict(keywords),
            "frame": found.name,
            "center": keywords.get("CentralBody"),
        }
        method = "slerp" if self._degree == 1 else "lagrange"
        try:
            return rows.table(
                kind,
                how,
                found,
                lines.fault,
                tolerance=tolerance,
                orbit=orbit,
                method=method,
                degree=self._degree,
                meta=meta,
            )
        except AttitudeError as err:
            if str(err).startswith(lines.path):
                raise
            raise lines.fault(str(err)) from err

    def _read_rows(self, rows):
        """Add the records up to END Attitude; False if the file ends before it."""
        lines, tokens, places = self._lines, [], []
        for line in lines:
            parts = line.split()
            if len(parts) == self._width + 1 and not line.lstrip().startswith(b"#"):
                tokens.extend(parts)
                places.append(lines.number)
                if len(places) == _BATCH:
                    self._take(rows, tokens, places)
                    tokens, places = [], []
            elif [part.lower() for part in parts] == [b"end", b"attitude"]:
                self._take(rows, tokens, places)
                self._refuse_more()
                return True
            elif parts and not parts[0].startswith(b"#"):
                raise lines.fault(
                    f"it has {len(parts)} entries; a record has a time and {self._width} numbers."
                )
        self._take(rows, tokens, places)
        return False

    def _refuse_more(self):
        for line in self._lines:
            if line.strip() and not line.strip().startswith(b"#"):
                raise self._lines.fault("there is more after END Attitude.")

    def _take(self, rows, tokens, places):
        if not tokens:
            return
        step = self._width + 1
        try:
            values = numbers(tokens, step, range(step))
        except NoNumber as err:
            raise self._lines.fault(f"{err.shown} is no number.", places[err.line]) from err
        seconds, values = values[:, 0], values[:, 1:]
        if not np.all(np.isfinite(seconds)):
            k = int(np.argmin(np.isfinite(seconds)))
            raise self._lines.fault("its time is not finite.", places[k])
        if self._kind.startswith("DCM"):
            values = self._quaternions(values, places)
        tai = pairs.add(self._epoch, seconds)
        rows.add_times(*time_scales.tdb_from("tai", *tai), values, places, self._lines.fault)

    def _quaternions(self, values, places):
        try:
            wxyz = forms.from_dcm(values[:, :9].reshape(-1, 3, 3))
        except AttitudeError as err:
            raise self._lines.fault(f"in the records from here on, {err}", places[0]) from err
        return np.concatenate([forms.to_xyzw(wxyz), values[:, 9:]], axis=1)

    def _scenario_epoch(self):
        """TAI seconds since J2000 in two doubles."""
        lines, text = self._lines, self._keywords.get("ScenarioEpoch", "")
        found = _DATE.fullmatch(" ".join(text.split()))
        line = self._where.get("ScenarioEpoch")
        if found is None or found.group(2).title() not in _MONTHS:
            raise lines.fault(
                f"ScenarioEpoch is {text[:40]!r}; write it like 1 Jan 2026 00:00:00.000.", line
            )
        date, month, year, time, part = found.groups()
        number = _MONTHS.index(month.title()) + 1
        iso = f"{year}-{number:02d}-{int(date):02d}T{time}{part or ''}".rstrip(".")
        try:
            instant = ccsds_epochs.instant(iso, "utc")
        except ccsds_epochs.BadEpoch as err:
            raise lines.fault(f"ScenarioEpoch is {text[:40]!r}: {err.reason}.", line) from err
        tt = time_scales.tt_from_tdb(np.float64(instant.seconds), np.float64(instant.low))
        return pairs.add(tt, -time_scales.TT_MINUS_TAI)

    def _whole(self, keyword, default):
        text = self._keywords.get(keyword)
        if text is None:
            return default
        if not re.fullmatch(r"\d{1,12}", text, re.ASCII):
            raise self._lines.fault(
                f"{keyword} is {text[:40]!r}; give a whole number.", self._where[keyword]
            )
        most = interpolation.MOST_DEGREE
        if keyword == "InterpolationOrder" and not 1 <= int(text) <= most:
            raise self._lines.fault(
                f"{keyword} is {text}; it must be 1 to {most}.", self._where[keyword]
            )
        return int(text)


# Writing ------------------------------------------------------------------------------------------


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    section: str | None = None,
    frame: str = "ICRF",
    sequence: str = "ZXZ",
    center: str = "Earth",
    order: int | None = None,
    orbit: Path | None = None,
) -> None:
    """Write attitudes as an STK attitude file.

    Parameters
    ----------
    path, source, t
        As of `aem.write`; one segment.
    section : str, optional
        "AttitudeTimeQuatAngVels" by default, "AttitudeTimeQuaternions" without rates; also
        "AttitudeTimeQuatScalarFirst" and "AttitudeTimeEulerAngles".
    frame : str
        "ICRF", "J2000" (EME2000), "Fixed", "TEMEOfDate" or "VVLH" (with orbit=).
    sequence : str
        Axes of Euler angles.
    center : str
        CentralBody.
    order : int, optional
        InterpolationOrder: by default that of a table or 7, less if there are few records.
    orbit : Path, optional
        Path of the body about its center, for VVLH.

    Raises
    ------
    AttitudeError
        For several segments, an unknown section, frame, sequence or order, and a file that cannot
        be written.
    """
    part = sources.only_segment(source, t, "an STK file")
    section = section or (
        "AttitudeTimeQuatAngVels" if part.has_rates else "AttitudeTimeQuaternions"
    )
    kind, scalar_first = _SECTIONS.get(section, ("", False))
    if not kind or kind.startswith("DCM"):
        written = [name for name in _SECTIONS if "DCM" not in name]
        raise AttitudeError(f"section is {section!r}; it must be one of {', '.join(written)}.")
    found = axes.named(_AXES.get(frame.lower(), frame))
    sequence = quaternion.known_sequence(sequence).upper()
    how = Convention(scalar_first=scalar_first, sequence=sequence)
    start, shift = _whole_second(part)
    if order is None:
        order = part.table.degree if part.table is not None else interpolation.USUAL_DEGREE
        order = max(min(order, len(part) - 1), 1)
    elif not (isinstance(order, int) and 1 <= order <= interpolation.MOST_DEGREE):
        raise AttitudeError(
            f"order is {order!r}; give a whole number from 1 to {interpolation.MOST_DEGREE}."
        )
    head = {
        "NumberOfAttitudePoints": len(part),
        "BlockingFactor": 20,
        "InterpolationOrder": order,
        "CentralBody": center,
        "ScenarioEpoch": start,
        "CoordinateAxes": _name_in_stk(found, frame),
    }
    if kind == "EULER_ANGLE":
        head["Sequence"] = sequence.translate(str.maketrans("XYZ", "123"))
    with written_whole(path, "the STK file") as file:
        file.write("stk.v.11.0\n\nBEGIN Attitude\n\n")
        file.writelines(f"{key} {value}\n" for key, value in head.items())
        file.write(f"\n{section}\n\n")
        for history in part.pieces():
            columns = columns_of(history, kind, how, found, orbit)
            seconds = shift(history)
            row = "%r" + " %r" * columns.shape[1] + "\n"
            lists = [seconds.tolist(), *columns.T.tolist()]
            file.write("".join([row % each for each in zip(*lists, strict=True)]))
        file.write("\nEND Attitude\n")


def _name_in_stk(found, given):
    names = {"icrf": "ICRF", "eme2000": "J2000", "itrf": "Fixed", "teme": "TEMEOfDate"}
    if found.kind == "lvlh":
        return "VVLH"
    if found.kind not in names:
        raise AttitudeError(
            f"frame is {given!r}, which STK attitude files do not know; give ICRF, J2000, Fixed, "
            "TEMEOfDate or VVLH."
        )
    return names[found.kind]


def _whole_second(part):
    """ScenarioEpoch as text, and a function: history -> seconds of TAI since ScenarioEpoch.

    ScenarioEpoch is the whole second of UTC at or before the first record.
    """
    seconds, low = part.first_and_last()
    hi, lo = pairs.add((seconds[0], low[0]), part.epoch.seconds, part.epoch.low)
    text = ccsds_epochs.texts(Instant(0.0), np.array([hi]), np.array([lo]), "utc", 12)[0]
    text = text.partition(".")[0]
    whole = ccsds_epochs.instant(text, "utc")
    tai0 = time_scales.tt_from_tdb(np.float64(whole.seconds), np.float64(whole.low))
    date = datetime.date.fromisoformat(text[:10])
    shown = f"{date.day} {_MONTHS[date.month - 1]} {date.year:04d} {text[11:]}.000000000"

    def shift(history):
        rest = 0.0 if history.low is None else history.low
        epochs = pairs.add((history.seconds, rest), history.epoch.seconds, history.epoch.low)
        hi, lo = pairs.add(time_scales.tt_from_tdb(*epochs), -tai0[0], -tai0[1])
        return hi + lo

    return shown, shift
