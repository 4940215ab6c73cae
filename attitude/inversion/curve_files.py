"""Light curves in files: CSV with a line of names, or a table of numbers.

Columns of a CSV, in any order and spelling of the case; lines that begin with # are remarks.

=========================  ======================================================================
utc, date, datetime, time  ISO dates in UTC
jd_tdb, jd_utc, jd, mjd    Julian dates; jd and mjd are UTC
mag, magnitude, m          apparent magnitudes
flux                       in place of them
sigma, error, merr, ...    standard errors; mag_err, e_mag, flux_err
session, night, observer   the session of each point; filter, band
sun_x .. observer_z        vectors from the body, au, over the axes of `frame`
ra, dec, delta             place in the sky (deg, ICRF) and distance (au) from the Earth's centre,
                           light time taken off; the Sun's place follows from built-in series
=========================  ======================================================================

A table without names has ten columns: jd_tdb, magnitude, sigma, session, and the vectors from the
body to Sun and observer, au.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import paths
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError
from attitude.physical_constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude.textfiles import lines, records

if TYPE_CHECKING:
    from attitude.annotations import FilePath, FloatArray

_TIMES = ("jd_tdb", "jd_utc", "utc", "date", "datetime", "jd", "mjd", "time", "epoch")
_NAMES = {
    "magnitude": ("magnitude", "mag", "m", "v", "r_mag"),
    "flux": ("flux",),
    "sigma": ("sigma", "error", "merr", "mag_err", "e_mag", "err", "flux_err", "magerr"),
    "session": ("session", "night", "observer", "code"),
    "filter": ("filter", "band"),
}
_PLACE = (("ra_deg", "ra"), ("dec_deg", "dec"), ("delta", "delta_au"))
_WIDTH = 10
_J2000 = Instant(0.0)


def columns(path: FilePath, given: dict[str, Any]) -> dict[str, Any]:
    """Keywords of `LightCurve` from a file and from keywords, which replace those of the file.

    Raises
    ------
    AttitudeError
        For a file that cannot be read, and one without epochs or brightness.
    """
    name = os.fspath(path)
    text = lines.whole(name, "give a CSV of a light curve")
    kept = [row for row in text.split("\n") if row.strip() and not row.lstrip().startswith("#")]
    if not kept:
        raise AttitudeError(f"{name}: holds no rows; give a CSV of a light curve.")
    first = kept[0].replace(",", " ").split()
    if all(_is_number(each) for each in first):
        found = _of_numbers(kept, name)
    else:
        found = _of_names(records.of_csv("\n".join(kept), name), name)
    if any(each in given for each in ("scene", "path", "sun", "observer")):
        for key in ("sun", "observer", "frame"):
            found.pop(key, None)
    elif "frame" in found:  # of right ascensions
        given = {key: each for key, each in given.items() if key != "frame"}
    return {"name": os.path.splitext(os.path.basename(name))[0], **found, **given}


def _is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def _of_numbers(rows: list[str], name: str) -> dict[str, Any]:
    try:
        table = np.array([[float(each) for each in row.replace(",", " ").split()] for row in rows])
    except ValueError as err:
        raise AttitudeError(f"{name}: its rows are not {_WIDTH} numbers each ({err}).") from err
    if table.ndim != 2 or table.shape[1] != _WIDTH:
        raise AttitudeError(
            f"{name}: has no line of names and {table.shape[-1]} columns; a table without names "
            f"has {_WIDTH}: jd_tdb, magnitude, sigma, session, vectors to Sun and observer in au."
        )
    return {
        "times": _julian(table[:, 0], "tdb"),
        "magnitude": table[:, 1],
        "sigma": table[:, 2],
        "session": table[:, 3].astype(int),
        "sun": table[:, 4:7] * ASTRONOMICAL_UNIT_M,
        "observer": table[:, 7:10] * ASTRONOMICAL_UNIT_M,
    }


def _of_names(rows: list[dict[str, Any]], name: str) -> dict[str, Any]:
    if not rows:
        raise AttitudeError(f"{name}: has a line of names and no rows.")
    table = {key.strip().lower(): [row[key] for row in rows] for key in rows[0] if key}
    key = next((each for each in _TIMES if each in table), None)
    if key is None:
        raise AttitudeError(f"{name}: has no column of epochs; name one of {', '.join(_TIMES)}.")
    if "jd" in key:
        scale = "tdb" if key == "jd_tdb" else "utc"
        offset = 2400000.5 if key == "mjd" else 0.0
        times: Any = _julian(_numbers(table[key], key, name) + offset, scale)
    else:
        times = [str(each).strip() for each in table[key]]
    found: dict[str, Any] = {"times": times}
    for keyword, names in _NAMES.items():
        column = next((each for each in names if each in table), None)
        if column is not None:
            is_text = keyword in ("session", "filter")
            values = table[column]
            found[keyword] = values if is_text else _numbers(values, column, name)
    if "magnitude" in found and "flux" in found:
        del found["flux"]
    return found | _places(table, times, name)


def _places(table, times, name):
    """Vectors to Sun and observer, if the file has them."""
    found: dict[str, Any] = {}
    for place in ("sun", "observer"):
        keys = [f"{place}_{axis}" for axis in "xyz"]
        if all(key in table for key in keys):
            vectors = [_numbers(table[key], key, name) for key in keys]
            found[place] = np.stack(vectors, axis=-1) * ASTRONOMICAL_UNIT_M
    keys = [next((each for each in names if each in table), None) for names in _PLACE]
    if not found and all(key is not None for key in keys):
        ra, dec, delta = (_numbers(table[key], key, name) for key in keys)
        sun, observer = _of_sky(times, ra, dec, delta)
        found = {"sun": sun, "observer": observer, "frame": "icrf"}
    return found


def _of_sky(times, ra, dec, delta):
    """Vectors from the body, m, ICRF, from its place in the sky of the Earth's centre."""
    from attitude import epochs

    hi, lo = epochs.seconds_since(_J2000, times)
    t = np.asarray(hi + (0.0 if lo is None else lo))
    a, d = np.radians(ra), np.radians(dec)
    unit = np.stack([np.cos(d) * np.cos(a), np.cos(d) * np.sin(a), np.sin(d)], axis=-1)
    distance = delta * ASTRONOMICAL_UNIT_M
    earth = paths.body("earth", "builtin").position(_J2000, t)
    sun = paths.body("sun", "builtin").position(_J2000, t - distance / SPEED_OF_LIGHT_M_S)
    return sun - (earth + distance[:, None] * unit), -distance[:, None] * unit


def _julian(days: FloatArray, scale: str) -> Any:
    from astropy.time import Time

    whole = np.floor(days)
    return Time(whole, days - whole, format="jd", scale=scale)


def _numbers(values, key, name):
    try:
        return np.array([float(each) if str(each).strip() else np.nan for each in values])
    except (TypeError, ValueError) as err:
        raise AttitudeError(f"{name}: the column {key} holds text ({err}); give numbers.") from err
