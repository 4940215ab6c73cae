"""Earth satellites from mean elements: TLE and OMM, propagated by SGP4.

The rotation from the frame of SGP4 (TEME) to GCRS is that of skyfield, without skyfield's 200
microseconds an epoch.  Elapsed time is that of TAI; skyfield and the sgp4 library alone subtract
UTC, so that a satellite jumps by 7 km at a leap second.

Sources: Vallado, Crawford, Hujsak & Kelso, AIAA 2006-6753; Rhodes, python-sgp4.
"""

from __future__ import annotations

import os
import re
import warnings
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import compress
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs, validation
from attitude._support.constants import DAY_S, JD_OF_MJD_0
from attitude._support.quantity_text import quoted
from attitude._support.synonyms import arguments
from attitude._textfiles import messages, toml, xml
from attitude._textfiles.lines import of_text, whole
from attitude.epochs import _inputs, _time_scales
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames._earth import pole_of_teme, to_gcrs
from attitude.paths._path import KM, Path, since, spelled
from attitude.paths._spk import Succession

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude._support.annotations import FilePath, FloatArray


# rad/min of one revolution a day.
_PER_DAY = 2.0 * np.pi / 1440.0
# EPHEMERIS_TYPE, beside 0, of elements for SGP4: SGP, SGP4 and SDP4; 4 is SGP4-XP.
_SGP4_TYPES = ("1", "2", "3")
# Days from the epoch of the elements beyond which a path warns.
_WARNED = 14.0
# Days beyond which it refuses.
_REFUSED = 365.25
_OMM_NEEDED = (
    "EPOCH",
    "MEAN_MOTION",
    "ECCENTRICITY",
    "INCLINATION",
    "RA_OF_ASC_NODE",
    "ARG_OF_PERICENTER",
    "MEAN_ANOMALY",
    "BSTAR",
)
# Fields that SGP4 does not use: the library sgp4 reads these instead of those of an OMM.
_OMM_UNUSED = {
    "CLASSIFICATION_TYPE": "U",
    "OBJECT_ID": "1957-001A",
    "EPHEMERIS_TYPE": "0",
    "ELEMENT_SET_NO": "999",
    "REV_AT_EPOCH": "0",
    "NORAD_CAT_ID": "0",
    "MEAN_MOTION_DOT": "0",
    "MEAN_MOTION_DDOT": "0",
}


@dataclass(frozen=True, eq=False, repr=False)
class Satellite(Path):
    """A satellite on mean elements, the lines of a TLE or the fields of an OMM, at an epoch."""

    lines: tuple[str, ...] | tuple[tuple[str, str], ...]
    epoch: Instant
    name: str
    source: str
    any_epoch: bool = False
    center = "earth"

    def _position(self, instant, hi, lo):
        return self._turned(instant, hi, lo, 1)[0]

    def _state(self, instant, hi, lo):
        return self._turned(instant, hi, lo, 2)

    def _turned(self, instant, hi, lo, count):
        base = since(instant, self.epoch)
        elapsed = (base[0] + hi) + (base[1] + lo)
        # The rounding error of that sum moves a satellite by less than 1e-7 m a year.
        vectors = self._teme(elapsed, instant, hi)[:count]
        seconds = pairs.add((hi, np.broadcast_to(lo, hi.shape)), instant.seconds, instant.low)
        pole = pole_of_teme(*seconds)
        return tuple(to_gcrs(*pole, vector) for vector in vectors)

    def _teme(self, elapsed, instant, hi):
        """Positions and velocities (3, N) over TEME axes, m and m/s."""
        model = _model(self.lines)
        # The rates of TDB and TAI agree to 3e-10, 1 ms a month.
        days = _elapsed_tai(self.epoch, elapsed) / DAY_S
        if not self.any_epoch and days.size:
            self._check_distance(days)
        whole = np.floor(days)
        jd = model.jdsatepoch + whole
        errors, position, velocity = model.sgp4_array(jd, model.jdsatepochF + (days - whole))
        if errors.any():
            self._refuse(errors, instant, hi)
        return position.T * KM, velocity.T * KM

    def _check_distance(self, days):
        """Refuse epochs beyond a year from that of the elements; warn once beyond two weeks."""
        farthest = float(np.nanmax(np.abs(days), initial=0.0))
        if farthest > _REFUSED:
            raise AttitudeError(
                f"{self.name} is evaluated {farthest:.4g} days from the epoch of its elements "
                f"({spelled(self.epoch)}), where positions of SGP4 mean little; give elements of "
                f"an epoch within {_REFUSED:.0f} days, or any_epoch=True (true in a file)."
            )
        if farthest > _WARNED and not self.__dict__.get("_has_warned"):
            object.__setattr__(self, "_has_warned", True)
            warnings.warn(
                f"{self.name} is evaluated {farthest:.3g} days from the epoch of its elements "
                f"({spelled(self.epoch)}), where SGP4 errs by tens of kilometres; give newer ones.",
                AttitudeWarning,
                stacklevel=2,
            )

    def _refuse(self, errors, instant, hi):
        """Raise the AttitudeError for SGP4's first error code that is not zero."""
        from sgp4.api import SGP4_ERRORS

        bad = int(np.argmax(errors != 0))
        at = instant.after(hi[bad])
        days = (at.seconds - self.epoch.seconds) / DAY_S
        raise AttitudeError(
            f"SGP4 gives no position of {self.name} at {spelled(at)}, {days:+.1f} days from the "
            f"elements' epoch: {SGP4_ERRORS[int(errors[bad])]}; give times nearer to that epoch, "
            "or elements of a nearer epoch."
        )


class NearestSets(Succession):
    """Element sets of one satellite by ascending epoch, of which that of the nearest counts.

    Position and velocity jump halfway between two epochs, by the error of SGP4.
    """

    parts: tuple[Satellite, ...]
    center = "earth"
    span = None  # type: ignore[assignment]

    @property
    def source(self) -> str:  # type: ignore[override]  # computed
        """The number of sets, and the first and last."""
        return f"{len(self.parts)} sets from {self.parts[0].source} to {self.parts[-1].source}"

    @cached_property
    def _changes(self) -> FloatArray:
        """Where the nearest set changes, in seconds since the epoch of the first."""
        epochs = np.array([path.epoch.since(self.parts[0].epoch) for path in self.parts])
        return 0.5 * (epochs[1:] + epochs[:-1])

    def _by_part(self, instant, hi, lo):
        """As that of `Succession`."""
        nearest = np.searchsorted(self._changes, hi - self.parts[0].epoch.since(instant) + lo)
        lo = np.broadcast_to(lo, hi.shape)
        for k in np.unique(nearest):
            inside = nearest == k
            yield self.parts[k], inside, (hi[inside], lo[inside])


def _joined(sets):
    """The path of the sets of one satellite, the last of each epoch."""
    last = {(path.epoch.seconds, path.epoch.low): path for path in sets}
    parts = tuple(last[epoch] for epoch in sorted(last))
    return parts[0] if len(parts) == 1 else NearestSets(parts, parts[-1].name)


def _elapsed_tai(epoch, elapsed):
    """Seconds of TAI since the epoch, from seconds of TDB."""
    start = np.float64(epoch.seconds), np.float64(epoch.low)
    first = _time_scales.difference_at(*start)
    return elapsed - (_time_scales.difference_at(start[0] + elapsed, start[1]) - first)


@arguments(
    dict.fromkeys(("line1", "line2", "lines"), "give both lines: tle([line1, line2])"),
    'tle("satellite.tle")',
)
def tle(
    text: FilePath | Sequence[str], *, name: str | int | None = None, any_epoch: bool = False
) -> Path:
    """The path of a satellite from two-line elements, relative to the Earth.

    Parameters
    ----------
    text : str, path or sequence of str
        The two lines, with or without a line for the name before them: as one text, as a list of
        lines, or as the path of a file.  Of several sets of one satellite, in any order, that of
        the nearest epoch is used, of several of one epoch the last; the state jumps in between.
    name : str or int, optional
        Name or catalog number, to select one satellite of several.
    any_epoch : bool
        Whether the path accepts epochs beyond a year from that of the elements, without a warning
        beyond 14 days.

    Returns
    -------
    Path
        Relative to the center of the Earth.

    Raises
    ------
    AttitudeError
        For lines of another length or form, a wrong checksum, and more than one satellite without
        a name.  The path raises it for an epoch at which SGP4 has no orbit, and beyond 365.25 days
        from the epoch of the elements; beyond 14 days it warns (`AttitudeWarning`), once.

    Notes
    -----
    Positions are those of skyfield's EarthSatellite to 1 mm; 0.6 to 1 microsecond an epoch.  The
    error of SGP4 itself is 1 km at the epoch and grows by some km a day.

    >>> tle('''ENVISAT
    ... 1 27386U 02009A   13296.16551405  .00000100  00000-0  47533-4 0  8339
    ... 2 27386 098.4160 001.9229 0001126 079.5538 280.5787 14.37637337609529''')
    <path of ENVISAT from earth: TLE of 2013-10-23T03:59:27.596 TDB>
    """
    lines, label = _text_lines(text)
    chosen = _chosen(_pairs(lines, label), _names_of_lines, name, label)
    return _joined([_of_lines(satellite, label, any_epoch) for satellite in chosen])


def _of_lines(satellite, label, any_epoch):
    """The satellite of a name and two lines."""
    title, first, second = satellite
    _check_line(first, "1", label)
    _check_line(second, "2", label)
    if first[2:7] != second[2:7]:
        raise AttitudeError(
            f"{label}: line 1 is of satellite {first[2:7]} and line 2 of {second[2:7]}; give two "
            "lines of one."
        )
    if first[62] not in (" ", "0", *_SGP4_TYPES):
        raise AttitudeError(
            f"{label}: the type of the elements (column 63 of line 1) is {first[62]}, so they are "
            "not of SGP4; give elements of type 0."
        )
    return _satellite((first, second), title or first[2:7].strip(), "TLE", any_epoch)


def omm(
    message: Mapping[str, Any] | FilePath,
    *,
    name: str | int | None = None,
    any_epoch: bool = False,
) -> Path:
    """The path of a satellite from a CCSDS orbit mean-elements message; see `tle`.

    Parameters
    ----------
    message : dict, str or path
        The values by their CCSDS keywords; or a text or file in keyword = value notation, XML, JSON
        or CSV (the formats of Celestrak and Space-Track).
    name : str or int, optional
        OBJECT_NAME or NORAD_CAT_ID, to select one satellite of several.
    any_epoch : bool
        As in `tle`.

    Raises
    ------
    AttitudeError
        For a missing or unreadable field, and another theory, frame or time system; for XML with a
        document type or entities.
    """
    satellites, label = _satellites(message)
    chosen = _chosen(satellites, _names_of_record, name, label)
    return _joined([_of_fields(fields, label, any_epoch) for fields in chosen])


def _of_fields(fields, label, any_epoch):
    """The satellite of the fields of an OMM."""
    for keyword, allowed in (
        ("MEAN_ELEMENT_THEORY", ("SGP4", "SGP/SGP4", "SGP")),
        ("REF_FRAME", ("TEME",)),
        ("TIME_SYSTEM", ("UTC",)),
        ("CENTER_NAME", ("EARTH",)),
        ("EPHEMERIS_TYPE", ("0", *_SGP4_TYPES)),
    ):
        stated = fields.get(keyword) or allowed[0]
        if stated.upper() not in allowed:
            raise AttitudeError(f"{label}: {keyword} is {quoted(stated)}; it must be {allowed[0]}.")
    for keyword in _OMM_NEEDED:
        if not fields.get(keyword):
            raise AttitudeError(f"{label} has no {keyword}, which SGP4 needs.")
    fields = {key: value for key, value in fields.items() if value}
    epoch = _inputs.instant(f"{fields['EPOCH'].removesuffix('Z')} UTC", f"{label}: EPOCH")
    # The form that sgp4 reads, which has no leap seconds; the path counts from `epoch`.
    text = epoch.utc_iso.replace(":60", ":59")
    fields["EPOCH"] = f"{text[:19]}.{text[20:26] or 0}"
    title = fields.get("OBJECT_NAME") or fields.get("NORAD_CAT_ID", "0")
    return _satellite(tuple(sorted(fields.items())), title, "OMM", any_epoch, epoch)


def _satellite(lines, name, kind, any_epoch, epoch=None):
    """The satellite of two lines or of the fields of an OMM."""
    model = _model(lines)
    if epoch is None:
        utc = _tai_of_utc(np.float64(model.jdsatepoch), np.float64(model.jdsatepochF))
        epoch = Instant(*_time_scales.tdb_from("tai", *utc))
    elements = (model.bstar, model.ecco, model.inclo, model.nodeo, model.argpo, model.mo)
    if not (np.isfinite(elements).all() and 0.0 < model.no_kozai < np.inf):
        raise AttitudeError(
            f"the {kind} of {name} has an element that is not finite, or a mean motion of "
            f"{model.no_kozai / _PER_DAY:.4g} revolutions a day; give finite elements, and a "
            "positive mean motion."
        )
    flag = validation.flag(any_epoch, "any_epoch")
    return Satellite(lines, epoch, name, f"{kind} of {spelled(epoch)}", flag)


def _tai_of_utc(jd1, jd2):
    """TAI seconds past J2000 in two doubles from sgp4's two-part Julian date of UTC."""
    # sgp4 counts 86400 s in every day; a leap second follows at the end of its day.
    day = np.floor(jd1 - JD_OF_MJD_0 + jd2)
    second = ((jd1 - JD_OF_MJD_0 - day) + jd2) * DAY_S
    return _time_scales.tai_from_utc_day(day, second)


@lru_cache(maxsize=256)
def _model(lines):
    """sgp4's object for some elements, cached here because it cannot be pickled."""
    from sgp4 import omm as reader
    from sgp4.api import Satrec

    if isinstance(lines[0], str):
        return Satrec.twoline2rv(*lines)
    model = Satrec()
    fields = dict(lines)
    try:
        reader.initialize(model, {**fields, **_OMM_UNUSED})
    except (ValueError, KeyError) as err:
        raise AttitudeError(
            f"the OMM of {quoted(fields.get('OBJECT_NAME', 'a satellite'), mark='')} cannot be "
            f"read: {quoted(err, 120, mark='')}; check that field."
        ) from err
    return model


# ---- Reading


def _text_lines(source):
    """The lines of a text, list or file, and a label of it for messages."""
    lines, label = source, "TLE"
    if not isinstance(source, (list, tuple)) or not all(isinstance(line, str) for line in source):
        text, label = _text(source, "TLE")
        lines = text.splitlines()
    return [line.rstrip() for line in lines if line.strip()], label


def _text(source, kind):
    """A text, or the content of a file, and a label of it for messages."""
    if isinstance(source, str) and ("\n" in source or source.lstrip().startswith(("<", "{", "["))):
        return source, kind
    if not isinstance(source, (str, os.PathLike)):
        raise AttitudeError(
            f"the {kind} is {quoted(source)}; give its text, or the path of a file."
        )
    text = whole(source, f"give the path of a text file of the {kind}, or its text")
    return text, os.path.basename(os.fspath(source))


def _pairs(lines, label):
    """All satellites of a text: (name, line 1, line 2)."""
    satellites = []
    for k, line in enumerate(lines[:-1]):
        if line.startswith("1 ") and lines[k + 1].startswith("2 "):
            before = lines[k - 1] if k and not lines[k - 1].startswith(("1 ", "2 ")) else ""
            satellites.append((before.removeprefix("0 ").strip(), line, lines[k + 1]))
    if not satellites:
        raise AttitudeError(
            f'{label} has no two lines that start with "1 " and "2 "; give two-line elements.'
        )
    return satellites


def _chosen(satellites, names_of, name, label):
    """The sets of the only satellite, or of the one with a name or number; `names_of` has both."""
    different = named = [names_of(satellite) for satellite in satellites]
    if name is not None:
        wanted = str(name).strip().lower()
        chosen = [wanted == title.lower() or _number(wanted) == number for title, number in named]
        satellites = list(compress(satellites, chosen))
        # A catalog number is that of one satellite, under whatever names.
        different = [number for _, number in compress(named, chosen)]
    count = len(set(different))
    if count != 1:
        advice = f" satellites called {quoted(name)}; give another name."
        if name is None:
            some = [title or str(number) for title, number in dict.fromkeys(named)][:3]
            advice = f" satellites; give name= (--orbit-of), such as: {', '.join(some)}."
        raise AttitudeError(f"{label} holds {count}{advice}")
    return satellites


def _names_of_lines(satellite):
    """The name and the catalog number of (name, line 1, line 2)."""
    title, first, _ = satellite
    return title, _number(first[2:7].strip())


def _names_of_record(fields):
    """The name and the catalog number in the fields of an OMM."""
    return fields.get("OBJECT_NAME", ""), _number(fields.get("NORAD_CAT_ID", ""))


def _number(text):
    """A catalog number without leading zeros, and with digits for the letter of five characters."""
    from sgp4.alpha5 import from_alpha5

    return str(from_alpha5(text.upper())) if re.fullmatch("[0-9A-Za-z][0-9]+", text) else text


def _check_line(line, number, label):
    """Raise an AttitudeError for a line of another length, checksum or form."""
    if len(line) != 69:
        raise AttitudeError(
            f"{label}, line {number} of the elements has {len(line)} characters, not 69: "
            f"{quoted(line, 120)}; give it whole, with its spaces."
        )
    total = sum(int(c) if c.isdigit() else c == "-" for c in line[:68]) % 10
    if line[68] != str(total):
        raise AttitudeError(
            f"{label}, line {number} of the elements ends in the checksum {line[68]}, but its "
            f"digits sum to {total}: {quoted(line, 120)}; a character in it is wrong: get the line "
            "anew."
        )
    if not _LINES[number].fullmatch(line):
        raise AttitudeError(
            f"{label}, line {number} of the elements is not in the columns of the format: "
            f"{quoted(line, 120)}; give it whole, with its spaces."
        )


_LINES = {
    "1": re.compile(r"1 [ 0-9A-Z][ 0-9]{4}. .{8} [ \d]\d[ \d]{3}\.\d{8}[ +\-.\d]{32}[ \d]{4}\d"),
    "2": re.compile(
        r"2 [ 0-9A-Z][ 0-9]{4} [ \d]{3}\.\d{4} [ \d]{3}\.\d{4} [ \d]{7} "
        r"[ \d]{3}\.\d{4} [ \d]{3}\.\d{4} [ \d]{2}\.\d{8}[ \d]{5}\d"
    ),
}


def _satellites(message):
    """The fields of each satellite in a message, and a label of the message."""
    if hasattr(message, "items"):
        return [_as_text(message)], "the OMM"
    text, label = _text(message, "OMM")
    head = text.lstrip()
    if head.startswith("<"):
        # Not by a `Form`: one file holds many OMMs, of any version and with any further elements.
        return xml.records(text, label, "segment"), label
    if head.startswith(("{", "[")):
        values = toml.of_json(text, label)
        values = values if isinstance(values, list) else [values]
        if not all(isinstance(fields, dict) for fields in values):
            raise AttitudeError(
                f"{label} holds JSON values that are no objects; give an OMM as an object of its "
                "fields by name, or a list of them."
            )
        return [_as_text(fields) for fields in values], label
    if "=" not in text and "," in text:
        return [_as_text(fields) for fields in toml.of_csv(text, label)], label
    return messages.values(of_text(text, label), "CCSDS_OMM_VERS"), label


def _as_text(fields):
    """Keywords in upper case and values as text."""
    return {str(key).upper(): "" if value is None else str(value) for key, value in fields.items()}
