"""Photometry in files of any known format, read as keywords of `LightCurve`.

Names of columns are read in any case, blanks as underscores.  A unit in square brackets, as in
``ra [h]`` and ``error [mmag]``, is converted or refused; words in round brackets count where they
are a unit of the same kind.

==================================  ==============================================================
jd, mjd, jd-2450000, mjd_tai ...    Julian dates in UTC; less a number; in another scale
utc, date, datetime, time, obstime  ISO dates in UTC; utc_emission: when the light left the body
bjd, bmjd, btjd, bkjd               at the barycenter of the solar system, TDB
hjd                                 at the Sun, UTC
mag, magnitude, m, v, r_mag         apparent magnitudes
flux, intensity, counts             in place of them
reduced_mag, reduced_flux           at 1 au from Sun and observer
zero_phase                          yes: at zero phase angle
zero_points                         of sessions: free, shared, or a standard deviation in mag
sigma, error, mag_err, e_vmag ...   standard errors, in the unit of the brightness
filter, band, filtercode, f ...     filter
site, station, stn, obs_code        code of the observatory
session, night, observer            session
exposure, exptime                   exposure times, s, of which the dates are the middles
object, designation                 one body: rows of several are refused
sun_x .. observer_z                 vectors from the body, au, over the axes of `frame`
ra, dec, delta                      place in the sky (deg, ICRF) and distance (au) from the Earth's
                                    centre, light time taken off
==================================  ==============================================================

A table without names has ten columns: jd_tdb, magnitude, sigma, session, and the vectors from the
body to Sun and observer, au; or two or three: date, magnitude, error.
"""

from __future__ import annotations

import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np

from attitude._support import quantity_text, validation
from attitude._support.constants import ASTRONOMICAL_UNIT_M, DAY_S, JD_OF_MJD_0, SPEED_OF_LIGHT_M_S
from attitude._support.quantity_text import counted, quoted
from attitude._textfiles import lines as textfiles_lines
from attitude._textfiles import toml, xml
from attitude.epochs import _inputs
from attitude.epochs._instants import J2000
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.formats.damit_light_curve import read_damit_light_curves
from attitude.paths import _composed

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath, FloatArray


Keywords: TypeAlias = dict[str, Any]

# ---- Rows of text as keywords of `LightCurve`

# Magnitudes beyond these stand for missing values in catalogues (99, 99.99, -99, 999).
_MISSING = (-50.0, 50.0)
# Julian dates of the years -2000 to 4700.
_JULIAN = (990_000.0, 3_440_000.0)
_BLANK = ("", "nan", "--", "-", "none", "null", "n/a", "inf", "-inf")
# Bad rows that a message names.
_NAMED = 6
# What a file may say about its epochs and magnitudes.
PLACES: Final = ("reception", "emission", "barycenter", "heliocenter")


class BadRow(NamedTuple):
    """A row of a file that is left out: its line, counted from 1, and the reason."""

    line: int
    reason: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


class RawPoint(NamedTuple):
    """One observation as text, as it stands in a file; "" where the file has no entry."""

    line: int
    time: str
    value: str
    error: str = ""
    filter: str = ""
    site: str = ""
    session: str = ""
    exposure: float = 0.0
    object: str = ""


def _of_rows(rows, name, *, scale=None, offset=0.0, is_flux=False, bad=None):
    """Keywords of `LightCurve` of rows of text, and "rows", the numbers of those that are used."""
    left_out, kept, numbers = list(bad or ()), [], []
    without = 0
    word = "flux" if is_flux else "magnitude"
    for k, row in enumerate(rows):
        if row.value.strip().lower() in _BLANK:
            without += 1
            continue
        reason, value, error = _brightness(row, word, is_flux)
        if reason is None and scale is not None:
            reason = _julian_fault(row.time, offset)
        if reason is None:
            kept.append(k)
            numbers.append((value, error))
        else:
            left_out.append(BadRow(row.line, reason))
    times, good, faults = _times([rows[k] for k in kept], scale, offset)
    left_out += faults
    kept, numbers = [kept[k] for k in good], [numbers[k] for k in good]
    left_out.sort(key=lambda row: row.line)
    if not kept:
        raise AttitudeError(
            f"{name}: no row can be used"
            + (f" ({counted(without, 'row')} without a {word})" if without else "")
            + (f"; {listed(left_out, '; ')}" if left_out else "")
            + "."
        )
    objects = sorted({rows[k].object.strip() for k in kept} - {""})
    if len(objects) > 1:
        raise AttitudeError(
            f"{name}: has photometry of {len(objects)} objects, "
            f"{quoted(listed(objects), 200, '')}; write that of each object into a file of its own."
        )
    verb = "has" if without == 1 else "have"
    notes = [f"{without} of {counted(len(rows), 'row')} {verb} no {word}."] if without else []
    notes += _repeated([rows[k] for k in kept], word)
    both = np.array(numbers).reshape(-1, 2)
    keywords = {
        "times": times,
        word: both[:, 0],
        "sigma": both[:, 1],
        "rows": np.array(kept),
        "name": objects[0] if objects else None,
        "bad": left_out,
        "notes": notes,
        "labels": [f"line {rows[k].line}, {rows[k].time.strip()[:40]}" for k in kept],
    }
    for key in ("filter", "site", "session"):
        words = [getattr(rows[k], key).strip() for k in kept]
        if any(words):
            keywords[key] = words
    exposures = [rows[k].exposure for k in kept]
    if any(exposures):
        keywords["exposure"] = np.array(exposures)
    return keywords


def _repeated(rows: Sequence[RawPoint], word: str) -> list[str]:
    """A note of rows that repeat others, and of the sessions that consist of such rows."""
    first: dict[tuple[str, ...], RawPoint] = {}
    repeats: list[tuple[RawPoint, RawPoint]] = []
    for row in rows:
        key = tuple(word.strip() for word in (row.time, row.value, row.filter, row.site))
        earlier = first.setdefault(key, row)
        if earlier.session != row.session:  # in one session they are averaged
            repeats.append((row, earlier))
    if not repeats:
        return []
    count = Counter(row.session for row in rows)
    again = Counter((row.session, earlier.session) for row, earlier in repeats)
    whole = [
        f"session {row[:40]!r} repeats {earlier[:40]!r}"
        for (row, earlier), many in again.items()
        if many == count[row]
    ]
    row, earlier = repeats[0]
    return [
        f"{len(repeats)} of {len(rows)} rows {'repeats' if len(repeats) == 1 else 'repeat'} the "
        f"date, {word}, filter and site of others (line {row.line} those of line {earlier.line})"
        + (f"; {listed(whole)}" if whole else "")
        + (": it counts twice." if len(repeats) == 1 else ": they count twice.")
    ]


def listed(items: Sequence[object], mark: str = ", ") -> str:
    """The first six of some items, with a mark between them, and how many follow."""
    more = len(items) - _NAMED
    end = f"{mark.strip(', ')} and {more} more" if more > 0 else ""
    return mark.join(map(str, items[:_NAMED])) + end


def _report(name: str, left_out: list[BadRow], bad: str) -> None:
    """Warn of bad rows, or raise an AttitudeError for them."""
    if not left_out or bad == "ignore":
        return
    rows = counted(len(left_out), "row")
    words = f"{name}: {rows} cannot be used: {listed(left_out, '; ')}"
    if bad == "refuse":
        raise AttitudeError(f'{words}; correct or delete them, or give bad="warn".')
    warnings.warn(f"{words}. Left out.", AttitudeWarning, stacklevel=5)


def _brightness(row: RawPoint, word: str, is_flux: bool) -> tuple[str | None, float, float]:
    """What is wrong with the numbers of a row, or None; its value and error."""
    text = row.value.strip()
    if text[:1] in "<>":
        return f"the {word} {text[:20]!r} is a limit", 0.0, 0.0
    value, error = _float(text), np.nan
    if value is None:
        return f"the {word} is {text[:20]!r}, which is no number", 0.0, 0.0
    if not np.isfinite(value) or not (is_flux or _MISSING[0] < value < _MISSING[1]):
        return f"the {word} {text[:20]} stands for a missing value", 0.0, 0.0
    if row.error.strip().lower() not in _BLANK:
        deviation = _float(row.error)
        if deviation is None:
            return f"the error is {row.error.strip()[:20]!r}, which is no number", 0.0, 0.0
        if deviation < 0.0 or deviation > 1e300:
            return f"the error is {row.error.strip()[:20]}, not above zero", 0.0, 0.0
        error = deviation if deviation > 0.0 else np.nan
    return None, value, error


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _julian_fault(text: str, offset: float) -> str | None:
    number = _float(text)
    if number is None:
        return f"the date is {text.strip()[:30]!r}, which is no number"
    if not _JULIAN[0] < number + offset < _JULIAN[1]:
        return f"the date {text.strip()[:30]} is no Julian date"
    return None


def _times(rows, scale, offset):
    """Epochs of rows, the numbers of the rows whose dates can be read, and the others."""
    good, faults = list(range(len(rows))), []
    if not rows:
        return [], good, faults
    if scale is not None:
        return julian([row.time for row in rows], scale, offset), good, faults
    dates = [iso(row.time) for row in rows]
    try:
        _inputs.past_j2000(dates)
    except AttitudeError:
        for k, row in enumerate(rows):
            try:
                _inputs.past_j2000([dates[k]])
            except AttitudeError as err:
                reason = str(err).split(";")[0].replace("t is ", "the date ")
                faults.append(BadRow(row.line, reason))
                good.remove(k)
    return [dates[k] for k in good], good, faults


def iso(text: str) -> str:
    """A date as it stands in files, in the spelling of ISO 8601.

    >>> iso("2011/09/13 7:46:00")
    '2011-09-13 07:46:00'
    """
    matched = re.fullmatch(
        r"\s*(\d{4})[-/. ](\d{1,2})[-/. ](\d{1,2})(?:[T ]+(\d{1,2})(:.*))?\s*", text
    )
    if matched is None:
        return text.strip()
    year, month, day, hour, fraction = matched.groups()
    date = f"{year}-{int(month):02d}-{int(day):02d}"
    return date if hour is None else f"{date} {int(hour):02d}{fraction}"


def julian(days: Sequence[str] | FloatArray, scale: str, offset: float = 0.0) -> Any:
    """Julian dates as a Time: the whole days and the rest are two doubles."""
    from astropy.time import Time

    parts = [str(day).strip().partition(".") for day in days]
    exact = all(re.fullmatch(r"\d+", a) and re.fullmatch(r"\d*", b) for a, _, b in parts)
    if exact:
        whole = np.array([float(a) for a, _, _ in parts])
        fractions = np.array([float(f"0.{b or 0}") for _, _, b in parts])
    else:
        numbers = np.array([float(day) for day in days])
        whole = np.floor(numbers)
        fractions = numbers - whole
    added = np.floor(offset)
    return Time(whole + added, fractions + (offset - added), format="jd", scale=scale)


# ---- Photometry in exchange formats: ALCDEF, ADES (PSV and XML), MPC 80 columns, DAMIT
# Sources: ALCDEF standard 2.2 (minorplanetcenter.net/light_curve2); ADES, IAU standard of 2022
# (github.com/IAU-ADES/ADES-Master); MPC, "Format for optical astrometric observations"; DAMIT as
# `attitude.formats.damit_light_curve`.

# Days of the exposure by which a date moves to its middle.
_MIDDLE = {"START": 0.5, "END": -0.5}
_ALCDEF_PLACE = ("OBSLONGITUDE", "OBSLATITUDE")
_NO = ("", "NONE", "FALSE")
# Columns of ADES that are used, and those that name the body, of which the first one counts.
_OPTICAL = ("obsTime", "mag", "rmsMag", "band", "stn")
_DESIGNATIONS = ("permID", "provID", "trkSub")
# Julian date of 1970-01-01.
_JD_OF_1970 = Decimal("2440587.5")
# The beginning of a date of the MPC, by which its records are recognized; and a whole one.
_PACKED = re.compile(r"\d{4} \d\d \d\d", re.ASCII)
_MPC_DATE = re.compile(r"(\d{4}) (\d\d) (\d\d)(?:\.(\d*))?", re.ASCII)


def of_alcdef(text: str, name: str) -> Keywords:
    """Keywords of `LightCurve` from an ALCDEF file: each block of metadata begins a session.

    Dates are UTC at the middle of an exposure, or moved there by EXPJD and EXPOSURE.
    """
    rows: list[RawPoint] = []
    bad: list[BadRow] = []
    meta: dict[str, str] = {}
    seen: list[dict[str, str]] = []
    for number, line in enumerate(text.splitlines(), 1):
        key, _, value = line.strip().partition("=")
        key = key.strip().upper()
        if key == "STARTMETADATA":
            meta = {}
            seen.append(meta)
        elif key == "DATA":
            parts = value.split("\t" if meta.get("DELIMITER", "").upper() == "TAB" else "|")
            if len(parts) < 2:
                bad.append(BadRow(number, f"it has {len(parts)} entries; a date and a magnitude"))
                continue
            rows.append(_alcdef_row(number, parts, meta, len(seen)))
        elif value and key not in meta:
            meta[key] = value.strip()
    keywords = _of_rows(rows, name, scale="utc", bad=bad)
    light, reduced = (
        {meta.get(key, "").upper() not in _NO for meta in seen} for key in ("LTCAPP", "REDUCEDMAGS")
    )
    if len(light) > 1 or len(reduced) > 1:
        raise AttitudeError(
            f"{name}: some blocks have {'LTCAPP' if len(light) > 1 else 'REDUCEDMAGS'} and others "
            "have not; write those with and those without into files of their own."
        )
    keywords["time_of"] = "emission" if True in light else "reception"
    keywords["unit_distances"] = True in reduced
    relative = [meta.get("DIFFERMAGS", "").upper() == "TRUE" for meta in seen]
    if any(relative):
        # nights of other observers are on one scale to some hundredths at best
        keywords["zero_points"] = "free"
        keywords["notes"].append(
            f"{sum(relative)} of {counted(len(seen), 'block')} "
            f"{'has' if sum(relative) == 1 else 'have'} differential magnitudes (DIFFERMAGS): the "
            "zero points of all sessions are free."
        )
    unmoved = [
        k
        for k, meta in enumerate(seen, 1)
        if _shifted(meta) and not _exposure(meta.get("EXPOSURE", "")) > 0.0
    ]
    if unmoved:
        keywords["notes"].append(
            f"EXPJD of block {listed(unmoved)} is not the middle, but EXPOSURE is not "
            "given: the dates are used as they stand."
        )
    return keywords


def _alcdef_row(number: int, parts: list[str], meta: dict[str, str], block: int) -> RawPoint:
    date = parts[0].strip()
    shift, exposure = _shifted(meta), _exposure(meta.get("EXPOSURE", ""))
    try:
        if shift and exposure > 0.0:
            whole, _, fraction = date.partition(".")
            date = f"{int(whole) + float(f'0.{fraction or 0}') + shift * exposure / DAY_S:.9f}"
    except (ValueError, OverflowError):
        pass  # a date that is no number, or too large, is reported with its row
    band = meta.get("FILTER") or meta.get("MAGBAND", "")
    session = f"{block} {meta.get('SESSIONDATE', '')}".strip()
    error = parts[2].strip() if len(parts) > 2 else ""
    site = meta.get("MPCCODE", "")
    if site.lower() in (*_BLANK, "xxx", "---"):
        place = [meta.get(key, "") for key in _ALCDEF_PLACE]
        site = "" if "" in place else f"{place[0]}, {place[1]} deg"
    body = " ".join((meta.get("OBJECTNAME") or meta.get("MPCDESIG", "")).split())
    return RawPoint(number, date, parts[1].strip(), error, band, site, session, exposure, body)


def _shifted(meta: dict[str, str]) -> float:
    """The part of the exposure from the date of a block to its middle."""
    return _MIDDLE.get(meta.get("EXPJD", "").upper(), 0.0)


def _exposure(text: str) -> float:
    """An exposure, s; 0 if it is unknown."""
    number = _float(text)
    return number if number is not None and 0.0 < number < np.inf else 0.0


def of_ades_text(text: str, name: str) -> Keywords:
    """Keywords of `LightCurve` from an ADES file in PSV; rows without a magnitude are left out."""
    names: list[str] = []
    rows, bad = [], []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith(("#", "!")):
            names = [] if line.startswith("#") else names
            continue
        parts = [word.strip() for word in line.split("|")]
        if not names or "obsTime" in parts:
            names = parts
            continue
        entries = dict(zip(names, parts, strict=False))
        if len(parts) > len(names):
            bad.append(BadRow(number, f"it has {len(parts)} entries, and the header {len(names)}"))
        else:
            rows.append(_ades_row(number, entries))
    return _of_rows(rows, name, bad=bad)


def of_ades_xml(text: str, name: str) -> Keywords:
    """Keywords of `LightCurve` from ADES in XML, without a document type or entities."""
    records = xml.records(text, name, "optical")
    if not records:
        raise AttitudeError(f"{name}: holds no <optical>, the element of photometry in ADES.")
    return _of_rows([_ades_row(k, record) for k, record in enumerate(records, 1)], name)


def _ades_row(number: int, entries: dict[str, str]) -> RawPoint:
    date, value, error, band, site = (entries.get(key, "") for key in _OPTICAL)
    body = next(filter(None, (entries.get(key, "").strip() for key in _DESIGNATIONS)), "")
    exposure = _exposure(entries.get("exp", ""))
    return RawPoint(number, date, value, error, band, site, exposure=exposure, object=body)


def of_mpc(text: str, name: str) -> Keywords:
    """Keywords of `LightCurve` from MPC records of 80 columns, without headers and radar."""
    rows, bad, moving = [], [], 0
    for number, line in enumerate(text.splitlines(), 1):
        if not is_mpc(line):
            if len(line.strip()) >= 75 and _PACKED.match(line[15:32].strip()) is None:
                bad.append(BadRow(number, f"its date is {line[15:32].strip()!r}"))
            continue
        if line[14] in "sSrRvVxX":  # the second line of a satellite, radar; replaced records
            moving += line[14] in "SV" and bool(line[65:70].strip())
            continue
        rows.append(_mpc_row(number, line))
    keywords = _of_rows(rows, name, scale="utc", bad=bad)
    if moving:
        records = counted(moving, "record is", "records are")
        keywords["notes"].append(f"{records} of satellites or roving observers, and left out.")
    return keywords


def is_mpc(line: str) -> bool:
    """Whether a line is an MPC record of 80 columns."""
    return 77 <= len(line.rstrip()) <= 81 and _PACKED.match(line[15:32].strip()) is not None


def _mpc_row(number: int, line: str) -> RawPoint:
    date = line[15:32].strip()
    matched = _MPC_DATE.fullmatch(date)
    if matched is not None:
        year, month, day, fraction = matched.groups()
        try:
            midnight = Decimal(np.datetime64(f"{year}-{month}-{day}", "D").astype(int).item())
            date = str(midnight + _JD_OF_1970 + Decimal(f"0.{fraction or 0}"))
        except ValueError:
            pass  # no day of that month: reported with its row, as a date in another form
    value, band, site = line[65:70].strip(), line[70].strip(), line[77:80].strip()
    body = line[:5].strip()
    if not (body.startswith("~") or body[-1:].isdigit()):  # no number of a minor planet
        body = line[:12].strip()
    return RawPoint(number, date, value, "", band, site, object=body)


def of_damit(text: str, name: str) -> Keywords:
    """Keywords of `LightCurve` from DAMIT light curves: sessions at unit distances."""
    from astropy.time import Time

    curves = read_damit_light_curves(name)

    def joined(key: str) -> FloatArray:
        return np.concatenate([getattr(curve, key) for curve in curves])

    keywords: Keywords = {
        "times": Time(joined("jd"), joined("jd_low"), format="jd", scale="tdb"),
        "flux": joined("brightness"),
        "sun": joined("sun") * ASTRONOMICAL_UNIT_M,
        "observer": joined("earth") * ASTRONOMICAL_UNIT_M,
        "frame": "ecliptic",
        "session": [str(k) for k, curve in enumerate(curves, 1) for _ in range(len(curve))],
        "time_of": "emission",
        "unit_distances": True,
        "labels": [
            f"point {n + 1} of light curve {k}, {curve.jd[n]:.6f}"
            for k, curve in enumerate(curves, 1)
            for n in range(len(curve))
        ],
        "bad": [],
        "notes": [],
    }
    relative = [str(k) for k, curve in enumerate(curves, 1) if not curve.calibrated]
    if relative:
        keywords["zero_points"] = tuple(relative)
        keywords["notes"].append(
            f"{len(relative)} of {counted(len(curves), 'session')} "
            f"{'is' if len(relative) == 1 else 'are'} relative: their zero points are free"
            + ("; the others share one." if len(relative) < len(curves) else ".")
        )
    elif len(curves) > 1:
        keywords["zero_points"] = "shared"
    return keywords


# ---- Tables of photometry whose columns have names: CSV and other separated text, and ECSV

# Name of a column of dates: scale (None: text), offset in days, where light is.  The first one that
# a table has counts: dates of the observer, which need no path, before those at a center.
_TIMES: dict[str, tuple[str | None, float, str]] = {
    "jd": ("utc", 0.0, "reception"),
    "mjd": ("utc", JD_OF_MJD_0, "reception"),
    "midpointmjdtai": ("tai", JD_OF_MJD_0, "reception"),  # Rubin
    "utc": (None, 0.0, "reception"),
    "utc_emission": (None, 0.0, "emission"),
    "bjd": ("tdb", 0.0, "barycenter"),
    "bmjd": ("tdb", JD_OF_MJD_0, "barycenter"),
    "btjd": ("tdb", 2457000.0, "barycenter"),  # TESS
    "bkjd": ("tdb", 2454833.0, "barycenter"),  # Kepler
    "hjd": ("utc", 0.0, "heliocenter"),
    **dict.fromkeys(
        ("date", "datetime", "date_obs", "obstime", "time", "epoch"), (None, 0.0, "reception")
    ),
}
_BARE_DATE = re.compile(r"\s*(\d{4}[-/. ]\d{1,2}[-/. ]\d{1,2})?\s*")
_CLOCK = re.compile(r"\s*(\d{1,2}:\d\d(:\d\d(\.\d*)?)?Z?)?\s*")
# One of these Julian dates in another scale, less a number, or both.
_JULIAN_NAME = re.compile(r"(\w*jd)(?:_(utc|tdb|tt|tai))?(?:_*-_*(\d+(?:\.\d*)?))?")
_NAMES: dict[str, tuple[str, ...]] = {
    "magnitude": ("magnitude", "mag", "m", "v", "r_mag", "vmag", "rmag", "magpsf"),
    "reduced": ("reduced_magnitude", "reduced_mag", "redmag"),
    "flux": ("flux", "intensity", "counts", "brightness", "psfflux", "ujy"),
    "reduced flux": ("reduced_flux",),
    "error": (
        "sigma",
        "error",
        "merr",
        "mag_err",
        "e_mag",
        "dm",
        "err",
        "flux_err",
        "magerr",
        "rmsmag",
        "sigmag",
        "mag_error",
        "e_flux",
        "fluxerr",
        "flux_error",
        "uncertainty",
        "dmag",
        "sigmapsf",
        "psffluxerr",
        "dujy",
    ),
    "exposure": ("exposure", "exptime", "exp_time", "exposure_time"),
    "session": ("session", "night", "observer", "code", "curve"),
    "filter": (
        "filter",
        "band",
        "filt",
        "fid",
        "filtercode",
        "filterid",
        "filter_name",
        "filtername",
        "passband",
        "f",
    ),
    "site": ("site", "station", "stn", "obs_code", "mpc_code", "observatory", "mpccode"),
    "object": ("object", "designation"),
}
# Forced photometry of ATLAS: its m is -m where the flux is negative, and dates are the starts of
# exposures of 30 s (fallingstar-data.com/forcedphot/resultdesc).
_ATLAS = {"mjd", "ujy", "dujy"}
_ATLAS_MIDDLE = 15.0 / DAY_S
_BRIGHTNESS = ("magnitude", "reduced", "flux", "reduced flux")
# Names of columns of errors of another column, and columns of brightness where they have errors.
_ERROR_OF = r"(?:e|err|error|sigma)_{0}(?:_\w+)?|{0}_?(?:err|error|sigma)"
_BANDS = (*"ubvrigzjhk",)
_MEANINGS = {"zero_phase": ("no", "yes"), "zero_points": ("free", "shared")}
_TEXTS = ("error", "filter", "site", "session", "object")
_PLACE = (("ra_deg", "ra"), ("dec_deg", "dec"), ("delta", "delta_au"))
# Units of these, and the least and the greatest number.
_SKY = (("deg", -360.0, 360.0), ("deg", -90.0, 90.0), ("au", 1e-9, 1e9))
_AXES = [f"{place}_{axis}" for place in ("sun", "observer") for axis in "xyz"]
_WIDTH = 10
# The first line of `LightCurve.write`: the name of the body.
_TITLE = re.compile(rf"# (.+): times of (?:{'|'.join(PLACES)})\s")
_BRACKET = re.compile(r"\s*([\[(])(.*?)[\])]")


class _Column(NamedTuple):
    """The entries of a column; its unit, "" if there is none, and whether it can be a remark."""

    entries: list[str]
    unit: str = ""
    is_remark: bool = False


_Table: TypeAlias = Mapping[str, _Column]


def of_text(text: str, name: str, columns: Mapping[str, str] | None = None) -> Keywords:
    """Keywords of `LightCurve` from a table in text."""
    rows = _with_remark(toml.of_separated(text, name), text, name, columns or {})
    if not rows:
        raise AttitudeError(f"{name}: holds no rows; give a table of photometry.")
    width, first = len(rows[0][1]), "the first row"
    if all(map(_is_number, rows[0][1])):
        names = _names_of_width(width, name)
    else:
        (_, names), *rows = rows
        first = "the line of names"
        if not rows:
            raise AttitudeError(f"{name}: has a line of names and no rows.")
    bad = [
        BadRow(line, f"it has {len(entries)} entries, and {first} {width}")
        for line, entries in rows
        if len(entries) != width
    ]
    rows = [row for row in rows if len(row[1]) == width]
    table = {}
    for k, (word, key) in enumerate(zip(names, map(_plain, names), strict=True)):
        bracket = _BRACKET.search(word)
        mark, unit = bracket.groups() if bracket else ("", "")
        if key in table and _meaning(key):
            raise AttitudeError(f"{name}: has two columns {quoted(key)}; rename or delete one.")
        table[key] = _Column([entries[k] for _, entries in rows], unit.strip(), mark == "(")
    keywords = _of_table(table, [line for line, _ in rows], name, columns, bad)
    titled = _TITLE.match(text)
    keywords["name"] = keywords["name"] or (titled and titled[1])
    return keywords


def _with_remark(rows, text, name, columns):
    """Rows of a table, behind names of columns that stand in a remark, as in "# JD mag err"."""
    if rows and any(map(_is_number, rows[0][1])):
        first, entries = rows[0]
        renamed = set(map(_plain, columns.values()))
        for remark in reversed(text.splitlines()[: first - 1]):
            for _, names in toml.of_separated(remark.lstrip("# \t"), name):
                keys = map(_plain, names)
                is_known = any(key in renamed or _meaning(key) == "date" for key in keys)
                if is_known and len(names) == len(entries):
                    return [(0, names), *rows]
    return rows


def _of_table(table, lines, name, columns=None, bad=None):
    """Keywords of `LightCurve` from columns of text; lines (N,) of the rows."""
    chosen, stems, is_atlas = {}, {}, table.keys() >= _ATLAS
    for meant, column in (columns or {}).items():
        if _plain(column) not in table:
            raise AttitudeError(
                f"{name}: has no column {quoted(column)}; it has {_names_of(table) or 'none'}."
            )
        chosen[_plain(meant)], stems[_plain(meant)] = table[_plain(column)], _plain(column)
    # in place of all columns of the same meaning
    meanings = {_meaning(key) for key in chosen} - {""}
    others = {key: table[key] for key in table if _meaning(key) not in meanings}
    if is_atlas and not chosen.keys() & {*_NAMES["magnitude"]}:
        others = {key: others[key] for key in others if key not in ("m", "dm", "err")}
    table = _with_clocks(others | chosen)
    date, (scale, offset, place) = _dates(table, name)
    offset += _ATLAS_MIDDLE * (is_atlas and date == "mjd")
    brightness, key = next(
        ((kind, key) for kind in _BRIGHTNESS if (key := _key(table, kind))), ("", "")
    )
    if not key:
        raise AttitudeError(
            f"{name}: has no column of magnitudes or flux; name one mag or flux, or give "
            f"columns= with one of {_names_of(table)}."
        )
    is_flux = brightness.endswith("flux")
    dates = _in_unit(table, date, "d", name)
    known = [word for word in dates if word.strip().lower() not in _BLANK][:5]
    if scale is None and known and all(map(_is_number, known)):
        scale, offset = _scale_of_numbers(float(known[0]), name, date)
    unit = table[key].unit if is_flux else "mag"
    values = _in_unit(table, key, unit, name)
    texts = {kind: table[_key(table, kind)].entries for kind in _TEXTS if _key(table, kind)}
    error = "" if "error" in meanings else _error_of(table, stems.get(key, key))
    if error := error or _key(table, "error"):
        texts["error"] = _in_unit(table, error, unit, name)
    exposure = _key(table, "exposure")
    exposures = _in_unit(table, exposure, "s", name) if exposure else []
    rows = [
        RawPoint(
            line,
            dates[k],
            values[k],
            exposure=_exposure(exposures[k]) if exposures else 0.0,
            **{kind: entries[k] for kind, entries in texts.items()},
        )
        for k, line in enumerate(lines)
    ]
    keywords = _of_rows(rows, name, scale=scale, offset=offset, is_flux=is_flux, bad=bad)
    if is_atlas:
        what = "m" if brightness == "magnitude" else "uJy"
        keywords["notes"].append(
            f"It is forced photometry of ATLAS: {what} is used, and dates of the start of "
            "exposures are moved by 15 s to the middle."
        )
    keywords["notes"] += [] if "brightness" in meanings else _others(table, key)
    keywords |= {"time_of": place, "unit_distances": brightness.startswith("reduced")}
    return keywords | _geometry(table, keywords, name) | _meanings(table, keywords, name)


def _error_of(table: _Table, key: str) -> str:
    """The column that has the name of errors of another, "" if there is none."""
    form = re.compile(_ERROR_OF.format(re.escape(key)))
    return next((name for name in table if form.fullmatch(name)), "")


def _others(table: _Table, key: str) -> list[str]:
    """A note of the columns of brightness beside the one that is used."""
    others = [
        name
        for name in table
        if _meaning(name) == "brightness" or (name in _BANDS and _error_of(table, name))
    ]
    if others == [key]:
        return []
    used = f"{key} is used; in Python columns= chooses another."
    return [f"The columns {quoted(', '.join(others), 120, '')} hold brightness: {used}"]


def _meanings(table: _Table, keywords: Keywords, name: str) -> dict[str, Any]:
    """The phase angle and the zero points, where a curve was written with them."""
    more: dict[str, Any] = {}
    for key, allowed in _MEANINGS.items():
        if key not in table:
            continue
        words = [table[key].entries[k] for k in keywords["rows"]]
        kinds, is_phase = sorted(set(words)), key == "zero_phase"
        if len(kinds) == 1 and kinds[0] in allowed:
            more[key] = kinds[0] == "yes" if is_phase else kinds[0]
        elif len(kinds) == 1 and not is_phase and _is_number(kinds[0]):
            more[key] = float(kinds[0])
        elif kinds == list(allowed) and not is_phase and "session" in keywords:
            both = zip(keywords["session"], words, strict=True)
            more[key] = tuple(sorted({session for session, word in both if word == "free"}))
        else:
            raise AttitudeError(
                f"{name}: the column {key} holds {quoted(listed(kinds), 120, '')}; give "
                f"{' or '.join(allowed)} in all rows"
                + ("." if is_phase else ", or in those of a session, or a number.")
            )
    return more


def _in_unit(table: _Table, key: str, wanted: str, name: str) -> list[str]:
    """The entries of a column, those that are numbers in another unit than stands at its name."""
    column = table[key]
    if column.unit in ("", wanted):
        return column.entries
    try:
        unit = quantity_text.unit_of(column.unit, key)
        if key in _PLACE[0] and unit.is_equivalent("h"):
            factor = 15.0 * unit.to("h")
        else:
            factor = unit.to(quantity_text.unit_of(wanted, key))
    except ValueError:  # no unit, or of another kind
        if column.is_remark or _meaning(key) == "date":
            return column.entries
        raise AttitudeError(
            f"{name}: the column {quoted(key, mark='')} is in {quoted(column.unit)}; give it in "
            f"{quoted(wanted or 'the unit of the flux', mark='')}, or a unit that converts to it."
        ) from None
    return [repr(float(word) * factor) if _is_number(word) else word for word in column.entries]


def _plain(name: str) -> str:
    """A column's name without units, case and marks."""
    bare = _BRACKET.sub("", name.strip().strip('"').lower())
    return re.sub(r"(\s|\.(?!\d))+", "_", bare.strip())


def _with_clocks(table: _Table) -> _Table:
    """The table with dates and times of day in one column; either alone yields to other epochs."""

    def column_of(names: tuple[str, ...], form: re.Pattern[str]) -> str:
        known = (key for key in names if key in table)
        return next((key for key in known if all(map(form.fullmatch, table[key].entries))), "")

    date, clock = column_of(("date", "date_obs"), _BARE_DATE), column_of(("time", "utc"), _CLOCK)
    others = {key: table[key] for key in table if key not in (date, clock)}
    times = table[clock].entries if clock else []
    if date and any(time.strip() for time in times):
        both = zip(table[date].entries, times, strict=True)
        days = [f"{day} {time}" if time.strip() else "" for day, time in both]
        return {"utc": _Column(days)} | others
    return others if any(_meaning(key) == "date" for key in others) else table


def _date_name(key: str) -> tuple[str, str | None, float]:
    """The name of dates without a scale and a number of days, and these."""
    matched = _JULIAN_NAME.fullmatch(key)
    return (matched[1], matched[2], float(matched[3] or 0.0)) if matched else (key, None, 0.0)


def _meaning(key: str) -> str:
    """What a column of a name holds, "" if the name is not known."""
    if _date_name(key)[0] in _TIMES:
        return "date"
    kind = next((kind for kind, names in _NAMES.items() if key in names), "")
    return "brightness" if kind in _BRIGHTNESS else kind


def _dates(table: _Table, name: str) -> tuple[str, tuple[str | None, float, str]]:
    for kind, (scale, offset, place) in _TIMES.items():
        for key in table:
            stem, other_scale, less = _date_name(key)
            if stem == kind:
                return key, (other_scale or scale, offset + less, place)
    raise AttitudeError(
        f"{name}: has no column of epochs; name one of {', '.join(_TIMES)}, Julian dates also "
        f"as in jd_tdb or mjd-50000, or give columns= with one of {_names_of(table)}."
    )


def _scale_of_numbers(first: float, name: str, key: str) -> tuple[str, float]:
    """Numbers under the name of a date: Julian dates in UTC, or modified ones."""
    for low, high, offset in ((2.4e6, 2.5e6, 0.0), (1e4, 1e5, JD_OF_MJD_0)):
        if low < first < high:
            return "utc", offset
    raise AttitudeError(
        f"{name}: the column {quoted(key, mark='')} begins with {first:g}, which is "
        "neither a date nor a Julian date; name it jd, mjd, or with what was taken off, as "
        "jd-2450000."
    )


def _names_of(table: _Table) -> str:
    """The names of the columns of a table, as far as a sentence holds them."""
    return quoted(", ".join(table), 120, "")


def _key(table: _Table, kind: str) -> str:
    """The name of the column of a kind, or ""."""
    return next((key for key in _NAMES[kind] if key in table), "")


def _is_number(text: str) -> bool:
    return _float(text) is not None


def _names_of_width(width: int, name: str) -> list[str]:
    """The names of the columns of a table that has none."""
    if width not in (2, 3, _WIDTH):
        raise AttitudeError(
            f"{name}: has no line of names and {width} columns; a table without names has 2 or 3 "
            f"(date, magnitude, error), or {_WIDTH}: jd_tdb, magnitude, sigma, session, vectors to "
            "Sun and observer in au."
        )
    if width == _WIDTH:
        return ["jd_tdb", "mag", "sigma", "session", *_AXES]
    return ["time", "mag", "sigma"][:width]


def _geometry(table: _Table, keywords: Keywords, name: str) -> dict[str, Any]:
    """Vectors to Sun and observer, if the table has them."""
    more: dict[str, Any] = {}
    for place, keys in (("sun", _AXES[:3]), ("observer", _AXES[3:])):
        if all(key in table for key in keys):
            vectors = [_numbers(table, key, "au", keywords, name) for key in keys]
            more[place] = np.stack(vectors, axis=-1) * ASTRONOMICAL_UNIT_M
    keys = [next((key for key in names if key in table), "") for names in _PLACE]
    if not more and all(keys):
        ra, dec, delta = (
            _numbers(table, key, unit, keywords, name, least, most)
            for key, (unit, least, most) in zip(keys, _SKY, strict=True)
        )
        sun, observer = _of_sky(keywords["times"], ra, dec, delta)
        more = {"sun": sun, "observer": observer, "frame": "icrf"}
    return more


def _numbers(table, key, unit, keywords, name, least=-np.inf, most=np.inf):
    """The numbers of the rows that are used, of a column whose entries have bounds."""
    entries = _in_unit(table, key, unit, name)
    shown = quoted(key, mark="")
    try:
        numbers = np.array([float(entries[k]) for k in keywords["rows"]])
    except ValueError as err:
        raise AttitudeError(
            f"{name}: the column {shown} holds text ({quoted(err, 120, '')}); give numbers."
        ) from None
    wrong = np.flatnonzero(~(np.isfinite(numbers) & (numbers >= least) & (numbers <= most)))
    if wrong.size:
        raise AttitudeError(
            f"{name}: the column {shown} holds {numbers[wrong[0]]:g} {unit} "
            f"({keywords['labels'][wrong[0]]}); give finite numbers"
            + (f" from {least:g} to {most:g} {unit}." if np.isfinite(least) else ".")
        )
    return numbers


def _of_sky(times, ra, dec, delta):
    """Vectors from the body, m, ICRF, from its place in the sky of the Earth's centre."""
    t = _inputs.seconds_since(J2000, times).rounded
    a, d = np.radians(ra), np.radians(dec)
    unit = np.stack([np.cos(d) * np.cos(a), np.cos(d) * np.sin(a), np.sin(d)], axis=-1)
    distance = delta * ASTRONOMICAL_UNIT_M
    earth = _composed.body("earth", "builtin").position(J2000, t)
    sun = _composed.body("sun", "builtin").position(J2000, t - distance / SPEED_OF_LIGHT_M_S)
    return sun - (earth + distance[:, None] * unit), -distance[:, None] * unit


# Characters that no text in Latin-1 has.
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f-\x9f]")


def opened(
    path: FilePath,
    *,
    format: str | None = None,
    columns: Mapping[str, str] | None = None,
    bad: str = "warn",
    encoding: str | None = None,
) -> Keywords:
    """Keywords of `LightCurve` from a file, and "rows"; arguments as `LightCurve.read`."""
    name = textfiles_lines.path_text(path)
    validation.one_of(bad, "bad", ("warn", "refuse", "ignore"))
    text, notes = _decoded(name, encoding)
    if format is None:
        # Records of the MPC begin with blanks, which are columns.
        lines = text.lstrip("\ufeff\r\n").splitlines()[:200]
        head = Head(text.lstrip("\ufeff \t\r\n"), [line for line in lines if line.strip()])
        reader = next((reader for reader in READERS if reader.recognizes(head)), _TABLE)
    else:
        reader = _BY_NAME[validation.one_of(format, "format", FORMATS)]
    if not columns:
        keywords = reader.read(text, name)
    elif reader.has_names:
        keywords = reader.read(text, name, columns)
    else:
        raise AttitudeError(
            f"columns is given, but {name} is {reader.name}, whose columns are fixed."
        )
    keywords["notes"] += notes
    keywords["name"] = keywords.get("name") or os.path.splitext(os.path.basename(name))[0]
    _report(name, keywords["bad"], bad)
    return keywords


def text_of(path: FilePath) -> str:
    """The text of a file."""
    return _decoded(textfiles_lines.path_text(path), None)[0]


def _decoded(name: str, encoding: str | None) -> tuple[str, list[str]]:
    """The text of a file, and a note if its encoding is a guess."""
    advice = "give a file of photometry, or in Python its encoding="
    try:
        return textfiles_lines.whole(name, advice, encoding or "UTF-8"), []
    except AttitudeError as err:
        if encoding is not None or not isinstance(err.__cause__, UnicodeDecodeError):
            raise
        text = textfiles_lines.whole(name, advice, "latin-1")
        if _CONTROL.search(text):  # not text at all
            raise
    note = "The file is not in UTF-8 and was read as Latin-1; in Python encoding= says otherwise."
    return text, [note]


def of_ecsv(text: str, name: str, columns: Mapping[str, str] | None = None) -> Keywords:
    """Keywords of `LightCurve` from an ECSV, whose columns have units."""
    from astropy.table import Table
    from astropy.time import Time

    try:
        table = Table.read(text, format="ascii.ecsv")
    except Exception as err:  # astropy raises exceptions of any type for broken files
        reason = " ".join(str(err).split())[:120] or type(err).__name__
        raise AttitudeError(f"{name}: it cannot be read as ECSV: {reason}.") from None
    texts: dict[str, _Column] = {}
    for key in table.colnames:
        column = table[key]
        if isinstance(column, Time):
            fine = Time(column.tdb, precision=9, copy=True)
            texts.setdefault("utc", _Column([f"{date} TDB" for date in fine.isot]))
            continue
        unit = getattr(column, "unit", None)
        unit = getattr(unit, "function_unit", unit)  # mag of mag(AB)
        entries = [_text(value) for value in column]
        texts[key.lower()] = _Column(entries, "" if unit is None else str(unit))
    before = sum(1 for line in text.splitlines() if line.startswith("#")) + 2
    return _of_table(texts, range(before, before + len(table)), name, columns)


def _text(value: Any) -> str:
    return "" if np.ma.is_masked(value) else str(getattr(value, "value", value))


# ---- The readers: a row of `READERS` for each format


class Head(NamedTuple):
    """The beginning of a text: from its first letter on, and its first rows that are not empty."""

    start: str
    rows: list[str]


class Reader(NamedTuple):
    """A format of photometry.

    read: ``read(text, name)``, with `columns` as a third argument where columns have names, returns
        keywords of `LightCurve`; name is that of the file.
    """

    name: str
    recognizes: Callable[[Head], bool]  # the first of `READERS` to say yes reads a file
    read: Callable[..., Keywords]
    has_names: bool = False


def _is_xml(head: Head) -> bool:
    return head.start.startswith("<")


def _is_alcdef(head: Head) -> bool:
    return any(row.strip().upper() == "STARTMETADATA" for row in head.rows) and not _is_xml(head)


def _is_ades_text(head: Head) -> bool:
    has_version = head.start.lower().startswith("# version=")
    has_names = any("obsTime" in row and "|" in row for row in head.rows)
    return (has_version or has_names) and not _is_xml(head)


def _is_damit(head: Head) -> bool:
    """A number alone, then two whole numbers, then rows of eight."""
    words = [row.split() for row in head.rows[:3]]
    return (
        [len(word) for word in words[:2]] == [1, 2]
        and all(digits.isdigit() for word in words[:2] for digits in word)
        and len(words) > 2
        and len(words[2]) >= 8
    )


# What no other reader recognizes is a table, which sentences name first.
_TABLE = Reader("csv", lambda head: True, of_text, has_names=True)
READERS: tuple[Reader, ...] = (
    Reader("ecsv", lambda head: head.start.startswith("# %ECSV"), of_ecsv, has_names=True),
    Reader("alcdef", _is_alcdef, of_alcdef),
    Reader("ades-psv", _is_ades_text, of_ades_text),
    Reader("ades-xml", _is_xml, of_ades_xml),
    Reader("mpc", lambda head: sum(map(is_mpc, head.rows)) > len(head.rows) // 3, of_mpc),
    Reader("damit", _is_damit, of_damit),
)
_BY_NAME = {reader.name: reader for reader in (_TABLE, *READERS)}
FORMATS: tuple[str, ...] = tuple(_BY_NAME)
