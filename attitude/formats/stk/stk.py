"""STK attitude files (.a): quaternions with and without rates, matrices, angles, vectors.

STK's quaternions turn the reference axes into those of the body, vector part first; they have the
numbers of the quaternion body to axes of this package, scalar last.  Rates are deg/s over the body
axes; Euler angles are deg, in the order of the sequence, as in `representations.from_euler`;
matrices are v_body = A v_axes, row by row.  ScenarioEpoch is UTC, and the times of records are
seconds of TAI since then, in one double: from a whole second of UTC, they are accurate to 1e-11 s
for spans of a day.

"J2000" is the mean equator and equinox of J2000, "ICRF" and "Inertial" of the Earth the ICRF,
"Fixed" ITRF, "VVLH" axes of an orbit; "TrueOfDate", "MeanOfDate" and "TEMEOfDate" also as
"...OfEpoch" with CoordinateAxesEpoch.  A file without InterpolationOrder is interpolated with order
1, as STK does, and so is one of order 0.  What else STK writes (`header`, `dates`, `sections`) is
read as well; what is refused is refused by name.
"""

from __future__ import annotations

import datetime
import os
from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs, quaternion
from attitude.attitude_table import interpolation
from attitude.attitude_table.table import AttitudeTable
from attitude.axes import orbit_axes
from attitude.epochs import time_scales
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.formats import sampling, sources
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.ccsds.attitude_types import Convention
from attitude.formats.rows import TOLERANCE, Rows, columns_of, known_tolerance
from attitude.formats.stk import dates
from attitude.formats.stk.header import Header, named
from attitude.formats.stk.sections import SECTIONS, pointed
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import NoNumber, numbers, opened

if TYPE_CHECKING:
    from attitude.annotations import EpochOrSeconds, Epochs, FilePath
    from attitude.formats.sampling import SampledFile
    from attitude.formats.sources import AttitudeSource
    from attitude.paths.path import Path

# Sections that are written.
WRITTEN: tuple[str, ...] = (
    *("AttitudeTimeQuatAngVels", "AttitudeTimeQuaternions", "AttitudeTimeQuatScalarFirst"),
    "AttitudeTimeEulerAngles",
)
# Kind of axes -> name in STK.
_NAMES = {
    **{"icrf": "ICRF", "eme2000": "J2000", "itrf": "Fixed", "teme": "TEMEOfDate", "lvlh": "VVLH"},
    **{"tod": "TrueOfDate", "mod": "MeanOfDate", "b1950": "B1950"},
}
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
        return _StkReader(lines).table(tolerance, frame, orbit)


class _StkReader:
    """Reads the records behind the keywords of a file."""

    def __init__(self, lines):
        self._lines = lines
        self._header = Header(lines)
        self._section = self._header.section
        self._decoder = self._header.decoder
        self._start = self._origin = None
        # Words of a row before its numbers.
        self._lead = dates.DATES.get(self._header.time_format, 1)

    def table(self, tolerance, frame, orbit):
        lines, header, section = self._lines, self._header, self._section
        found = header.axes(frame)
        if self._header.time_format in dates.UNITS:
            self._start = header.start()
        scale = "utc" if self._start is None else "tai"
        rows = Rows(scale, section.width)
        if section.form == "vector":
            orbit_axes.known_path(orbit, "the direction to the center")
        self._vectors = found, orbit
        ended = self._read_rows(rows)
        if header.count is not None and rows.count != header.count:
            raise lines.fault(
                f"the file has {rows.count} records, but NumberOfAttitudePoints is {header.count}"
                + ("." if ended else "; is it cut off?"),
            )
        if not rows.count:
            raise lines.fault("the file has no attitudes.")
        how = Convention(scalar_first=section.scalar_first, sequence=self._decoder.sequence)
        meta = {
            "format": "STK",
            "keywords": dict(header.keywords),
            "frame": found.name,
            "center": header.keywords.get("CentralBody"),
        }
        try:
            return rows.table(
                section.kind,
                how,
                found,
                lines.fault,
                tolerance=tolerance,
                orbit=orbit,
                method=header.method,
                degree=header.degree,
                meta=meta,
            )
        except AttitudeError as err:
            if str(err).startswith(lines.path):
                raise
            raise lines.fault(str(err)) from err

    def _read_rows(self, rows):
        """Add the records up to END Attitude; False if the file ends before it."""
        lines, tokens, places = self._lines, [], []
        width = self._section.width + self._lead
        for line in lines:
            parts = line.replace(b'"', b"").split()
            if len(parts) == width and not line.lstrip().startswith(b"#"):
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
                    f"it has {len(parts)} entries; a record has a time"
                    f"{f' of {self._lead} words' if self._lead > 1 else ''} and "
                    f"{self._section.width} numbers."
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
        lead, step = self._lead, self._section.width + self._lead
        try:
            values = numbers(tokens, step, range(lead, step))
        except NoNumber as err:
            raise self._lines.fault(f"{err.shown} is no number.", places[err.line]) from err
        if not np.all(np.isfinite(values)):
            k = int(np.argmin(np.isfinite(values).all(axis=1)))
            raise self._lines.fault("it holds a number that is not finite.", places[k])
        hi, lo = self._epochs(tokens, step, places)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                if self._origin is None:
                    self._origin = hi[0], lo[0]
                seconds = (hi - self._origin[0]) + (lo - self._origin[1])
                values = self._decoder.columns(seconds, values)
                if self._section.form == "vector":
                    found, orbit = self._vectors
                    values = pointed(values, found, Instant(0.0), hi, lo, orbit)
        except AttitudeError as err:
            raise self._lines.fault(f"in the records from here on, {err}", places[0]) from err
        rows.add_times(hi, lo, values, places, self._lines.fault)

    def _epochs(self, tokens, step, places):
        """TDB seconds since J2000, hi and lo, of some rows."""
        lines = self._lines
        if self._start is None:
            words = [word for k in range(self._lead) for word in tokens[k::step]]
            count = len(places)
            rows = [word for k in range(count) for word in words[k::count]]
            codes = dates.of_rows(rows, self._lead)
            try:
                return ccsds_epochs.parsed(codes, "utc")
            except ccsds_epochs.BadEpoch as err:
                shown = codes[err.index][:40].decode("ascii", "replace")
                raise lines.fault(
                    f"the time {shown!r} cannot be read: {err.reason}.", places[err.index]
                ) from err
        try:
            seconds = numbers(tokens, step, range(1))[:, 0]
        except NoNumber as err:
            raise lines.fault(f"{err.shown} is no number.", places[err.line]) from err
        if not np.all(np.isfinite(seconds)):
            k = int(np.argmin(np.isfinite(seconds)))
            raise lines.fault("its time is not finite.", places[k])
        unit = dates.UNITS[self._header.time_format]
        pair = (seconds, 0.0) if unit == 1.0 else pairs.product(seconds, unit)
        tai = pairs.add((np.float64(self._start[0]), np.float64(self._start[1])), *pair)
        return time_scales.tdb_from("tai", *tai)


# Writing ------------------------------------------------------------------------------------------


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
        As of `aem.write`; one segment.
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
    has_rates = sources.known_of(source, t)[1]
    section = section or ("AttitudeTimeQuatAngVels" if has_rates else "AttitudeTimeQuaternions")
    if section not in WRITTEN:
        raise AttitudeError(f"section is {section!r}; it must be one of {', '.join(WRITTEN)}.")
    found = named(frame)
    sequence = quaternion.known_sequence(sequence).upper()
    if order is not None and not (
        isinstance(order, int) and 1 <= order <= interpolation.MOST_DEGREE
    ):
        raise AttitudeError(
            f"order is {order!r}; give a whole number from 1 to {interpolation.MOST_DEGREE}."
        )
    head = {"CentralBody": center, "CoordinateAxes": _name_in_stk(found, frame)}
    if SECTIONS[section].kind == "EULER_ANGLE":
        head["Sequence"] = sequence.translate(str.maketrans("XYZ", "123"))
    how = Convention(scalar_first=SECTIONS[section].scalar_first, sequence=sequence)
    settings = (section, found, how, head)
    if tolerance is None:
        sources.refuse_span(start, stop)
        parts = sources.segments(source, t) if split else []
        if len(parts) < 2:
            parts = [sources.only_segment(source, t, "an STK file")]
        for name, part in zip(_names(path, len(parts)), parts, strict=True):
            _write(name, part, *settings, order, orbit)
        return None
    sources.refuse_epochs(t)
    motion = sources.one_motion(source)
    degree = order or (
        motion.degree if isinstance(motion, AttitudeTable) else interpolation.USUAL_DEGREE
    )
    count = sampling.count_of_stretches(motion, start, stop) if split else 1
    made = [
        sampling.write(
            *(name, motion, start, stop, tolerance),
            method="slerp" if degree == 1 else "lagrange",
            degree=degree,
            name="an STK file",
            write_records=lambda target, parts: _write(target, parts[0], *settings, degree, orbit),
            read=lambda target: read(target, orbit=orbit),
            one_segment=True,
            stretch=k if count > 1 else None,
        )
        for k, name in enumerate(_names(path, count))
    ]
    return sampling.SampledFile(
        sum(each.records for each in made),
        sum(each.segments for each in made),
        max(each.step for each in made),
        max(each.error for each in made),
    )


def _names(path, count):
    """The names of the files of `count` stretches."""
    if count == 1:
        return [path]
    stem, ending = os.path.splitext(os.fspath(path))
    return [f"{stem}-{k + 1}{ending}" for k in range(count)]


def _write(path, part, section, found, how, head, order, orbit):
    """Write one segment; `head` are the keywords that do not depend on its records."""
    start, shift = _whole_second(part)
    if order is None:
        order = part.table.degree if part.table is not None else interpolation.USUAL_DEGREE
        order = max(min(order, len(part) - 1), 1)
    numbers_of = {
        "NumberOfAttitudePoints": len(part),
        "BlockingFactor": 20,
        "InterpolationOrder": order,
    }
    with written_whole(path, "the STK file") as file:
        file.write("stk.v.11.0\n\nBEGIN Attitude\n\n")
        for key, value in (*numbers_of.items(), ("ScenarioEpoch", start), *head.items()):
            file.write(f"{key} {value}\n")
        file.write(f"\n{section}\n\n")
        for history in part.pieces():
            columns = columns_of(history, SECTIONS[section].kind, how, found, orbit)
            seconds = shift(history)
            row = "%r" + " %r" * columns.shape[1] + "\n"
            lists = [seconds.tolist(), *columns.T.tolist()]
            file.write("".join([row % each for each in zip(*lists, strict=True)]))
        file.write("\nEND Attitude\n")


def _name_in_stk(found, given):
    if found.kind not in _NAMES:
        raise AttitudeError(
            f"frame is {given!r}, which STK attitude files do not know; give one of "
            f"{', '.join(_NAMES.values())}."
        )
    return _NAMES[found.kind]


def _whole_second(part):
    """ScenarioEpoch as text, and a function: history -> seconds of TAI since ScenarioEpoch.

    ScenarioEpoch is the whole second of UTC at or before the first record.
    """
    seconds, low = part.first_and_last()
    hi, lo = pairs.add((seconds[0], low[0]), part.epoch.seconds, part.epoch.low)
    text = ccsds_epochs.texts(Instant(0.0), np.array([hi]), np.array([lo]), "utc", 12)[0]
    text = text.partition(".")[0]
    whole = ccsds_epochs.instant(text, "utc")
    tai0 = dates.tai_of(whole)
    date = datetime.date.fromisoformat(text[:10])
    shown = f"{date.day} {dates.MONTHS[date.month - 1][:3]} {date.year:04d} {text[11:]}.000000000"

    def shift(history):
        rest = 0.0 if history.low is None else history.low
        epochs = pairs.add((history.seconds, rest), history.epoch.seconds, history.epoch.low)
        tai = pairs.add(time_scales.tt_from_tdb(*epochs), -time_scales.TT_MINUS_TAI)
        hi, lo = pairs.add(tai, -tai0[0], -tai0[1])
        return hi + lo

    return shown, shift
