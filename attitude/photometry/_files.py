"""`read`: photometry in files of any known format.

Names of columns are read in any case, without units in brackets, blanks as underscores:

==================================  ==============================================================
utc, date, datetime, time, obstime  ISO dates in UTC; utc_emission: when the light left the body
jd, jd_utc, mjd, jd-2450000         Julian dates in UTC; ``jd-NUMBER`` is a date less a number
jd_tdb, jd_tt, jd_tai               in another scale
bjd, bjd_tdb                        at the barycenter of the solar system, TDB
hjd                                 at the Sun, UTC
mag, magnitude, m, v, r_mag         apparent magnitudes
reduced_mag                         at 1 au from Sun and observer
flux, intensity, counts             in place of them
sigma, error, merr, mag_err ...     standard errors, in the unit of the brightness
filter, band                        filter
site, station, stn, obs_code        code of the observatory
session, night, observer            session
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
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude._support.quoting import quoted
from attitude._textfiles import lines as textfiles_lines
from attitude._textfiles import toml, xml
from attitude.epochs import _inputs
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.formats.damit_light_curve import read_damit_light_curves
from attitude.paths import _composed
from attitude.photometry import _curve
from attitude.photometry._curve import BadRow, Contents, Photometry, RawPoint

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath, FloatArray


# ---- Photometry in exchange formats: ALCDEF, ADES (PSV and XML), MPC 80 columns, DAMIT
# Sources: ALCDEF standard 2.2 (minorplanetcenter.net/light_curve2); ADES, IAU standard of 2022
# (github.com/IAU-ADES/ADES-Master); MPC, "Format for optical astrometric observations"; DAMIT as
# `attitude.formats.damit_light_curve`.

# Days of the exposure by which a date moves to its middle.
_MIDDLE = {"START": 0.5, "END": -0.5}
_SECONDS = 86400.0
_NO = ("", "NONE", "FALSE")
# Columns of ADES that are used.
_OPTICAL = ("obsTime", "mag", "rmsMag", "band", "stn")
# Julian date of 1970-01-01.
_JD_OF_1970 = Decimal("2440587.5")
# The beginning of a date of the MPC, by which its records are recognized; and a whole one.
_PACKED = re.compile(r"\d{4} \d\d \d\d", re.ASCII)
_MPC_DATE = re.compile(r"(\d{4}) (\d\d) (\d\d)(?:\.(\d*))?", re.ASCII)


def of_alcdef(text: str, name: str) -> Contents:
    """The `Contents` of an ALCDEF file: each block of metadata begins a session.

    Dates are Julian dates in UTC at the middle of an exposure, or moved there by EXPJD and
    EXPOSURE.  Magnitudes of blocks with DIFFERMAGS are relative: they are sessions with zero points
    of their own, as all sessions are.
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
    found = _curve.of_rows(rows, name, scale="utc", bad=bad)
    light, reduced = (
        {meta.get(key, "").upper() not in _NO for meta in seen} for key in ("LTCAPP", "REDUCEDMAGS")
    )
    if len(light) > 1 or len(reduced) > 1:
        raise AttitudeError(
            f"{name}: some blocks have {'LTCAPP' if len(light) > 1 else 'REDUCEDMAGS'} and others "
            "have not; write those with and those without into files of their own."
        )
    if True in light:
        found.time_of = "emission"
    found.unit_distances = True in reduced
    objects = {meta.get("OBJECTNAME") or meta.get("MPCDESIG", "") for meta in seen}
    found.more["name"] = ", ".join(sorted(objects - {""})) or None
    if any(meta.get("DIFFERMAGS", "").upper() == "TRUE" for meta in seen):
        found.notes.append("Some sessions have differential magnitudes (DIFFERMAGS).")
    unmoved = [k for k, meta in enumerate(seen, 1) if _shifted(meta) and not _exposure(meta) > 0.0]
    if unmoved:
        found.notes.append(
            f"EXPJD of block {_curve.listed(unmoved)} is not the middle, but EXPOSURE is not "
            "given: the dates are used as they stand."
        )
    places = {(m.get("OBSLONGITUDE", ""), m.get("OBSLATITUDE", "")) for m in seen}
    if found.site is None and len(places) == 1 and "" not in (place := places.pop()):
        found.site = [f"{place[0]}, {place[1]} deg"] * len(found.value)
    return found


def _alcdef_row(number: int, parts: list[str], meta: dict[str, str], block: int) -> RawPoint:
    date = parts[0].strip()
    shift, exposure = _shifted(meta), _exposure(meta)
    try:
        if shift and exposure > 0.0:
            whole, _, rest = date.partition(".")
            date = f"{int(whole) + float(f'0.{rest or 0}') + shift * exposure / _SECONDS:.9f}"
    except (ValueError, OverflowError):
        pass  # a date that is no number, or too large, is reported with its row
    band = meta.get("FILTER") or meta.get("MAGBAND", "")
    session = f"{block} {meta.get('SESSIONDATE', '')}".strip()
    error = parts[2].strip() if len(parts) > 2 else ""
    return RawPoint(number, date, parts[1].strip(), error, band, meta.get("MPCCODE", ""), session)


def _shifted(meta: dict[str, str]) -> float:
    """The part of the exposure from the date of a block to its middle."""
    return _MIDDLE.get(meta.get("EXPJD", "").upper(), 0.0)


def _exposure(meta: dict[str, str]) -> float:
    """The exposure of a block, s; 0 if it is not given."""
    try:
        return float(meta.get("EXPOSURE", "0"))
    except ValueError:
        return 0.0


def of_ades_text(text: str, name: str) -> Contents:
    """The `Contents` of an ADES file in PSV; rows without a magnitude are left out."""
    names: list[str] = []
    rows, bad = [], []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith(("#", "!")):
            names = [] if line.startswith("#") else names
            continue
        parts = [each.strip() for each in line.split("|")]
        if not names or "obsTime" in parts:
            names = parts
            continue
        entries = dict(zip(names, parts, strict=False))
        if len(parts) > len(names):
            bad.append(BadRow(number, f"it has {len(parts)} entries, and the header {len(names)}"))
        else:
            rows.append(_ades_row(number, entries))
    return _of_ades(rows, name, bad)


def of_ades_xml(text: str, name: str) -> Contents:
    """The `Contents` of an ADES file in XML, which may have no document type and no entities."""
    found = xml.records(text, name, "optical")
    if not found:
        raise AttitudeError(f"{name}: holds no <optical>, the element of photometry in ADES.")
    return _of_ades([_ades_row(k, each) for k, each in enumerate(found, 1)], name, [])


def _ades_row(number: int, entries: dict[str, str]) -> RawPoint:
    date, value, error, band, site = (entries.get(key, "") for key in _OPTICAL)
    return RawPoint(number, date, value, error, band, site)


def _of_ades(rows: list[RawPoint], name: str, bad: list[BadRow]) -> Contents:
    return _curve.of_rows(rows, name, bad=bad)


def of_mpc(text: str, name: str) -> Contents:
    """The `Contents` of MPC records of 80 columns; lines of headers and of radar are left out."""
    rows, bad = [], []
    for number, line in enumerate(text.splitlines(), 1):
        if not is_mpc(line):
            if len(line.strip()) >= 75 and _PACKED.match(line[15:32].strip()) is None:
                bad.append(BadRow(number, f"its date is {line[15:32].strip()!r}"))
            continue
        if line[14] in "sSrRvVxX":  # the second line of a satellite, radar; replaced records
            continue
        rows.append(_mpc_row(number, line))
    return _curve.of_rows(rows, name, scale="utc", bad=bad)


def is_mpc(line: str) -> bool:
    """Whether a line is an MPC record of 80 columns."""
    return 77 <= len(line.rstrip()) <= 81 and _PACKED.match(line[15:32].strip()) is not None


def _mpc_row(number: int, line: str) -> RawPoint:
    date = line[15:32].strip()
    found = _MPC_DATE.fullmatch(date)
    if found is not None:
        year, month, day, rest = found.groups()
        try:
            midnight = Decimal(np.datetime64(f"{year}-{month}-{day}", "D").astype(int).item())
            date = str(midnight + _JD_OF_1970 + Decimal(f"0.{rest or 0}"))
        except ValueError:
            pass  # no day of that month: reported with its row, as a date in another form
    return RawPoint(number, date, line[65:70].strip(), "", line[70].strip(), line[77:80].strip())


def of_damit(path: FilePath, name: str) -> Contents:
    """The `Contents` of DAMIT light curves: a session each, intensities at unit distances."""
    curves = read_damit_light_curves(path)
    count = [len(each) for each in curves]
    found = Contents(
        name,
        _damit_times(curves),
        np.concatenate([each.brightness for each in curves]),
        np.full(sum(count), np.nan),
        is_flux=True,
        time_of="emission",
        unit_distances=True,
        rows=np.arange(sum(count)),
    )
    found.session = [str(k) for k, n in enumerate(count, 1) for _ in range(n)]
    for key, attribute in (("sun", "sun"), ("observer", "earth")):
        vectors = np.concatenate([getattr(each, attribute) for each in curves])
        found.more[key] = vectors * ASTRONOMICAL_UNIT_M
    found.more["frame"] = "ecliptic"
    if not all(each.calibrated for each in curves):
        found.notes.append("Some sessions are relative: their zero points are their own.")
    return found


def _damit_times(curves: Any) -> Any:
    from astropy.time import Time

    jd, low = (np.concatenate([getattr(each, key) for each in curves]) for key in ("jd", "jd_low"))
    return Time(jd, low, format="jd", scale="tdb")


# ---- Tables of photometry whose columns have names: CSV and other separated text, and ECSV

# Name of a column of dates: scale (None: text), offset in days, where light is.
_TIMES: dict[str, tuple[str | None, float, str]] = {
    "bjd_tdb": ("tdb", 0.0, "barycenter"),
    "bjd": ("tdb", 0.0, "barycenter"),
    "bmjd": ("tdb", 2400000.5, "barycenter"),
    "hjd": ("utc", 0.0, "heliocenter"),
    "jd_tdb": ("tdb", 0.0, "reception"),
    "jd_tt": ("tt", 0.0, "reception"),
    "jd_tai": ("tai", 0.0, "reception"),
    "jd_utc": ("utc", 0.0, "reception"),
    "utc": (None, 0.0, "reception"),
    "utc_emission": (None, 0.0, "emission"),
    "date": (None, 0.0, "reception"),
    "datetime": (None, 0.0, "reception"),
    "date_obs": (None, 0.0, "reception"),
    "obstime": (None, 0.0, "reception"),
    "jd": ("utc", 0.0, "reception"),
    "mjd": ("utc", 2400000.5, "reception"),
    "mjd_utc": ("utc", 2400000.5, "reception"),
    "mjd_tdb": ("tdb", 2400000.5, "reception"),
    "time": (None, 0.0, "reception"),
    "epoch": (None, 0.0, "reception"),
}
_LESS = re.compile(r"(bjd|hjd|jd)(?:_(utc|tdb|tt|tai))?_*-_*(\d+(?:\.\d*)?)")
_NAMES: dict[str, tuple[str, ...]] = {
    "magnitude": ("magnitude", "mag", "m", "v", "r_mag", "vmag", "rmag"),
    "reduced": ("reduced_magnitude", "reduced_mag", "redmag"),
    "flux": ("flux", "intensity", "counts", "brightness"),
    "error": (
        *("sigma", "error", "merr", "mag_err", "e_mag", "err", "flux_err", "magerr", "rmsmag"),
        *("sigmag", "mag_error", "e_flux", "fluxerr", "flux_error", "uncertainty", "dmag"),
    ),
    "session": ("session", "night", "observer", "code", "curve"),
    "filter": ("filter", "band", "filt", "fid"),
    "site": ("site", "station", "stn", "obs_code", "mpc_code", "observatory", "mpccode"),
}
_PLACE = (("ra_deg", "ra"), ("dec_deg", "dec"), ("delta", "delta_au"))
_AXES = [f"{place}_{axis}" for place in ("sun", "observer") for axis in "xyz"]
_WIDTH = 10
_J2000 = Instant(0.0)


def of_text(text: str, name: str, columns: Mapping[str, str] | None = None) -> Contents:
    """The `Contents` of a table in text."""
    rows = toml.of_separated(text, name)
    if not rows:
        raise AttitudeError(f"{name}: holds no rows; give a table of photometry.")
    if all(_is_number(each) for each in rows[0][1]):
        return _without_names(rows, name)
    names, body = rows[0][1], rows[1:]
    if not body:
        raise AttitudeError(f"{name}: has a line of names and no rows.")
    bad = [
        BadRow(line, f"it has {len(each)} entries, and the line of names {len(names)}")
        for line, each in body
        if len(each) != len(names)
    ]
    body = [row for row in body if len(row[1]) == len(names)]
    table = {_plain(key): [each[k] for _, each in body] for k, key in enumerate(names)}
    return of_table(table, [line for line, _ in body], name, columns, bad)


def of_table(
    table: dict[str, list[str]],
    lines: Sequence[int],
    name: str,
    columns: Mapping[str, str] | None = None,
    bad: list[BadRow] | None = None,
) -> Contents:
    """The `Contents` of columns of text under their names, as `of_text`; lines (N,) of the rows."""
    for meant, given in (columns or {}).items():
        if _plain(given) not in table:
            raise AttitudeError(
                f"{name}: has no column {quoted(given)}; it has {_listed(table) or 'none'}."
            )
        table = {_plain(meant): table[_plain(given)], **{k: v for k, v in table.items()}}
        table[_plain(meant)] = table[_plain(given)]
    date, (scale, offset, place) = _dates(table, name)
    brightness = next(
        (kind for kind in ("magnitude", "reduced", "flux") if _column(table, kind)), None
    )
    if brightness is None:
        raise AttitudeError(
            f"{name}: has no column of magnitudes or flux; name one mag or flux, or give "
            f"columns= with one of {_listed(table)}."
        )
    if scale is None and all(map(_is_number, table[date][:5])):
        scale, offset = _scale_of_numbers(table[date], name, date)
    texts = {key: _column(table, key) for key in ("error", "filter", "site", "session")}
    values = _column(table, brightness) or []
    rows = [
        RawPoint(
            line, table[date][k], values[k], **{key: col[k] for key, col in texts.items() if col}
        )
        for k, line in enumerate(lines)
    ]
    found = _curve.of_rows(
        rows, name, scale=scale, offset=offset, is_flux=brightness == "flux", bad=bad
    )
    found.time_of, found.unit_distances = place, brightness == "reduced"
    found.more.update(_geometry(table, found, name))
    return found


def _plain(name: str) -> str:
    """A column's name without units, case and marks."""
    bare = re.sub(r"\s*[\[(].*?[\])]", "", name.strip().strip('"').lower())
    return re.sub(r"[\s.]+", "_", bare.strip())


def _dates(table: Mapping[str, Any], name: str) -> tuple[str, tuple[str | None, float, str]]:
    for key, how in _TIMES.items():
        if key in table:
            return key, how
    for key in table:
        less = _LESS.fullmatch(key)
        if less:
            scale, _, place = _TIMES[less.group(1)]
            return key, (less.group(2) or scale, float(less.group(3)), place)
    raise AttitudeError(
        f"{name}: has no column of epochs; name one of {', '.join(_TIMES)}, or give columns= with "
        f"one of {_listed(table)}."
    )


def _scale_of_numbers(values: Sequence[str], name: str, key: str) -> tuple[str, float]:
    """Numbers under the name of a date: Julian dates in UTC, or modified ones."""
    first = float(next(each for each in values if each.strip()))
    for low, high, offset in ((2.4e6, 2.5e6, 0.0), (1e4, 1e5, 2400000.5)):
        if low < first < high:
            return "utc", offset
    raise AttitudeError(
        f"{name}: the column {quoted(key, mark='')} begins with {first:g}, which is "
        "neither a date nor a Julian date; name it jd, mjd, or with what was taken off, as "
        "jd-2450000."
    )


def _listed(table: Mapping[str, Any]) -> str:
    """The names of the columns of a table, as far as a sentence holds them."""
    return quoted(", ".join(table), 120, "")


def _column(table: Mapping[str, list[str]], kind: str) -> list[str] | None:
    return next((table[each] for each in _NAMES[kind] if each in table), None)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _without_names(rows: list[tuple[int, list[str]]], name: str) -> Contents:
    width = len(rows[0][1])
    if width not in (2, 3, _WIDTH):
        raise AttitudeError(
            f"{name}: has no line of names and {width} columns; a table without names has 2 or 3 "
            f"(date, magnitude, error), or {_WIDTH}: jd_tdb, magnitude, sigma, session, vectors to "
            "Sun and observer in au."
        )
    bad = [
        BadRow(line, f"it has {len(each)} entries, and the first row {width}")
        for line, each in rows
        if len(each) != width
    ]
    rows = [row for row in rows if len(row[1]) == width]
    names = ["jd_tdb", "mag", "sigma", "session", *_AXES] if width == _WIDTH else []
    names = names or ["time", "mag", "sigma"][:width]
    table = {key: [each[k] for _, each in rows] for k, key in enumerate(names)}
    return of_table(table, [line for line, _ in rows], name, None, bad)


def _geometry(table: Mapping[str, list[str]], found: Contents, name: str) -> dict[str, Any]:
    """Vectors to Sun and observer, if the table has them."""
    more: dict[str, Any] = {}
    for place in ("sun", "observer"):
        keys = [f"{place}_{axis}" for axis in "xyz"]
        if all(key in table for key in keys):
            vectors = [_numbers(table[key], key, found, name) for key in keys]
            more[place] = np.stack(vectors, axis=-1) * ASTRONOMICAL_UNIT_M
    keys = [next((each for each in names if each in table), "") for names in _PLACE]
    if not more and all(keys):
        ra, dec, delta = (_numbers(table[key], key, found, name) for key in keys)
        sun, observer = _of_sky(found.times, ra, dec, delta)
        more = {"sun": sun, "observer": observer, "frame": "icrf"}
    return more


def _numbers(values: Sequence[str], key: str, found: Contents, name: str) -> FloatArray:
    try:
        return np.array([float(values[k]) for k in found.rows])
    except ValueError as err:
        raise AttitudeError(
            f"{name}: the column {quoted(key, mark='')} holds text "
            f"({quoted(err, 120, '')}); give numbers."
        ) from None


def _of_sky(
    times: Any, ra: FloatArray, dec: FloatArray, delta: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Vectors from the body, m, ICRF, from its place in the sky of the Earth's centre."""
    hi, lo = _inputs.seconds_since(_J2000, times)
    t = np.asarray(hi + (0.0 if lo is None else lo))
    a, d = np.radians(ra), np.radians(dec)
    unit = np.stack([np.cos(d) * np.cos(a), np.cos(d) * np.sin(a), np.sin(d)], axis=-1)
    distance = delta * ASTRONOMICAL_UNIT_M
    earth = _composed.body("earth", "builtin").position(_J2000, t)
    sun = _composed.body("sun", "builtin").position(_J2000, t - distance / SPEED_OF_LIGHT_M_S)
    return sun - (earth + distance[:, None] * unit), -distance[:, None] * unit


# Characters that no text in Latin-1 has.
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f-\x9f]")
FORMATS: tuple[str, ...] = ("csv", "ecsv", "alcdef", "ades-psv", "ades-xml", "mpc", "damit")


def read(
    path: FilePath,
    *,
    format: str | None = None,
    columns: Mapping[str, str] | None = None,
    bad: str = "warn",
    encoding: str | None = None,
    **given: Any,
) -> Photometry:
    """The photometry in a file.

    Parameters
    ----------
    path : str or path
        CSV or other separated text and ECSV with named columns (`attitude.photometry._files`
        lists the names), ALCDEF, ADES in PSV or XML, MPC records of 80 columns, DAMIT light curves.
    format : str, optional
        One of `FORMATS`; by default from the content.
    columns : dict, optional
        For named columns: the name in the file, by the name it stands for, such as
        {"magnitude": "Vcal", "jd": "T"}.
    bad : "warn", "refuse" or "ignore"
        What happens if rows cannot be used: a warning that names their lines and reasons, an error,
        or neither.  `Photometry.bad` lists them.
    encoding : str, optional
        Of the text, as Python names it; by default UTF-8, or with a note Latin-1 where it is not.
    **given
        Keywords of `Photometry`, which replace those of the file.

    Returns
    -------
    Photometry

    Raises
    ------
    AttitudeError
        For a file that cannot be read, an unknown format, and a file without any usable row.
    """
    found = opened(path, format=format, columns=columns, bad=bad, encoding=encoding)
    keywords = found.keywords()
    keywords.setdefault("name", _stem(path))
    keywords |= {"time_of": found.time_of, "unit_distances": found.unit_distances}
    if "flux" in given or "magnitude" in given:
        keywords.pop("flux", None)
        keywords.pop("magnitude", None)
    return Photometry(**keywords | given, bad=tuple(found.bad), notes=tuple(found.notes))


def opened(
    path: FilePath,
    *,
    format: str | None = None,
    columns: Mapping[str, str] | None = None,
    bad: str = "warn",
    encoding: str | None = None,
) -> Contents:
    """The `Contents` of a file; parameters and errors as in `read`."""
    name = os.fspath(path)
    validation.one_of(bad, "bad", ("warn", "refuse", "ignore"))
    text, notes = _decoded(name, encoding)
    kind = _kind(text, name) if format is None else validation.one_of(format, "format", FORMATS)
    if columns and kind not in ("csv", "ecsv"):
        raise AttitudeError(f"columns is given, but {name} is {kind}, whose columns are fixed.")
    if kind == "csv":
        found = of_text(text, name, columns)
    elif kind == "ecsv":
        found = of_table(*_of_ecsv(text, name), name, columns)
    elif kind == "damit":
        found = of_damit(path, name)
    else:
        reader = {
            "alcdef": of_alcdef,
            "ades-psv": of_ades_text,
            "ades-xml": of_ades_xml,
            "mpc": of_mpc,
        }[kind]
        found = reader(text, name)
    found.notes += notes
    _curve.report(found, bad)
    return found


def _decoded(name: str, encoding: str | None) -> tuple[str, list[str]]:
    """The text of a file, and a note if its encoding is a guess."""
    advice = "give a file of photometry, or its encoding="
    try:
        return textfiles_lines.whole(name, advice, encoding or "UTF-8"), []
    except AttitudeError as err:
        if encoding is not None or not isinstance(err.__cause__, UnicodeDecodeError):
            raise
        text = textfiles_lines.whole(name, advice, "latin-1")
        if _CONTROL.search(text):  # not text at all
            raise
    return text, ["The file is not in UTF-8 and was read as Latin-1; encoding= says otherwise."]


def _stem(path: FilePath) -> str:
    return os.path.splitext(os.path.basename(os.fspath(path)))[0]


def _kind(text: str, name: str) -> str:
    """The format of a text by its first lines."""
    start = text.lstrip("\ufeff \t\r\n")
    rows = [row for row in start.splitlines()[:200] if row.strip()]
    if start.startswith("# %ECSV"):
        return "ecsv"
    if start.startswith("<"):
        return "ades-xml"
    if any(row.strip().upper() == "STARTMETADATA" for row in rows):
        return "alcdef"
    if start.lower().startswith("# version=") or any("obsTime" in r and "|" in r for r in rows):
        return "ades-psv"
    if sum(is_mpc(row) for row in rows) > len(rows) // 3 and rows:
        return "mpc"
    if _is_damit(rows):
        return "damit"
    return "csv"


def _is_damit(rows: list[str]) -> bool:
    """A number alone, then two whole numbers, then rows of eight."""
    words = [row.split() for row in rows[:3]]
    return (
        [len(each) for each in words[:2]] == [1, 2]
        and all(part.isdigit() for each in words[:2] for part in each)
        and len(words) > 2
        and len(words[2]) >= 8
    )


def _of_ecsv(text: str, name: str) -> tuple[dict[str, list[str]], list[int]]:
    """Columns of text of an ECSV, in the units of `of_table`, and the lines of its rows."""
    from astropy.table import Table
    from astropy.time import Time

    try:
        table = Table.read(text, format="ascii.ecsv")
    except Exception as err:  # astropy raises exceptions of any type for broken files
        reason = " ".join(str(err).split())[:120] or type(err).__name__
        raise AttitudeError(f"{name}: it cannot be read as ECSV: {reason}.") from None
    found: dict[str, list[str]] = {}
    for key in table.colnames:
        column = table[key]
        if isinstance(column, Time):
            fine = Time(column.tdb, precision=9, copy=True)
            found.setdefault("utc", [f"{each} TDB" for each in fine.isot])
            continue
        found[key.lower()] = [_text(each) for each in _in_units(column)]
    before = sum(1 for line in text.splitlines() if line.startswith("#")) + 2
    return found, list(range(before, before + len(table)))


def _in_units(column: Any) -> Any:
    """A column in days, magnitudes, degrees or au, as `of_table` reads it."""
    unit = getattr(column, "unit", None)
    if unit is None:
        return column
    for wanted in ("d", "mag", "deg", "au"):
        if unit.is_equivalent(wanted):
            return getattr(column, "quantity", column).to_value(wanted)
    return column


def _text(value: Any) -> str:
    return "" if np.ma.is_masked(value) else str(getattr(value, "value", value))
