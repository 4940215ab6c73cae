"""Tables of photometry whose columns have names: CSV and other separated text, and ECSV.

Names are read in any case, without units in brackets, blanks as underscores:

==================================  ==============================================================
utc, date, datetime, time, obstime  ISO dates in UTC; utc_emission: when the light left the body
jd, jd_utc, mjd, jd-2450000         Julian dates in UTC; ``jd-NUMBER`` is a date less a number
jd_tdb, jd_tt, jd_tai               in another scale
bjd, bjd_tdb                        at the barycenter of the solar system, TDB
hjd                                 at the Sun, UTC
mag, magnitude, m, v, r_mag         apparent magnitudes; reduced_mag: at 1 au from Sun and observer
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

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, paths
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError, quoted
from attitude.photometry import contents
from attitude.photometry.contents import BadRow, Contents, RawPoint
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude.textfiles import records

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

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
    """The `Contents` of a table in text.

    Parameters
    ----------
    text : str
    name : str
        Of the file.
    columns : dict, optional
        Name of a column in the file, by the name it stands for: {"magnitude": "Vcal"}.

    Raises
    ------
    AttitudeError
        For a table without dates or brightness, and one without any row that can be used.
    """
    rows = records.of_separated(text, name)
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
    found = contents.of_rows(
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
    hi, lo = epochs.seconds_since(_J2000, times)
    t = np.asarray(hi + (0.0 if lo is None else lo))
    a, d = np.radians(ra), np.radians(dec)
    unit = np.stack([np.cos(d) * np.cos(a), np.cos(d) * np.sin(a), np.sin(d)], axis=-1)
    distance = delta * ASTRONOMICAL_UNIT_M
    earth = paths.body("earth", "builtin").position(_J2000, t)
    sun = paths.body("sun", "builtin").position(_J2000, t - distance / SPEED_OF_LIGHT_M_S)
    return sun - (earth + distance[:, None] * unit), -distance[:, None] * unit
