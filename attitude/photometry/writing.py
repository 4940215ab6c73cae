"""Photometry as CSV with named columns."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.physical_constants import ASTRONOMICAL_UNIT_M
from attitude.textfiles.atomic_write import written_whole

if TYPE_CHECKING:
    from attitude.annotations import FilePath
    from attitude.photometry.table import Photometry

# Names of the columns of dates that are not those of an observer.
_CENTERS = {"barycenter": "bjd_tdb", "heliocenter": "hjd"}

# What a spreadsheet runs as a formula; a sign before a number is none.
_FORMULA = re.compile(r"[=@]|[+-](?![\d., +-]*(deg)?$)")


def write(path: FilePath, data: Photometry) -> None:
    """Write the points as CSV; see `Photometry.write`.

    Dates at the barycenter or the Sun are Julian dates, others ISO dates in UTC; vectors to Sun and
    observer are in au over the axes of ICRF.  What the dates and the brightness mean stands in the
    remarks above the names.
    """
    center = _CENTERS.get(data.time_of)
    brightness = "flux" if data.is_flux else "reduced_mag" if data.unit_distances else "mag"
    names = [
        center or ("utc_emission" if data.time_of == "emission" else "utc"),
        brightness,
        "sigma",
    ]
    if center:
        time = data.times.tdb if center == "bjd_tdb" else data.times.utc
        dates = [
            f"{np.longdouble(a) + np.longdouble(b):.12f}"
            for a, b in zip(time.jd1, time.jd2, strict=True)
        ]
    else:
        dates = ccsds_epochs.texts(data.epoch, data.seconds, None, "utc")
    columns: list[list[str]] = [list(dates), [repr(float(each)) for each in data.value]]
    columns.append([repr(float(each)) if each > 0.0 else "" for each in data.sigma])
    for key in ("filter", "site", "session"):
        words = getattr(data, f"{key}s")
        if any(words):
            names.append(key)
            cells = [_cell(word) for word in words]
            columns.append([cells[k] for k in getattr(data, key)])
    for key in ("sun", "observer"):
        vectors = getattr(data, key)
        if vectors is not None:
            names += [f"{key}_{axis}" for axis in "xyz"]
            columns += [[repr(float(x)) for x in each] for each in vectors.T / ASTRONOMICAL_UNIT_M]
    with written_whole(path, "photometry") as file:
        file.write(f"# {_remark(data.name or 'photometry')}: times of {data.time_of}\n")
        file.write(",".join(names) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*columns, strict=True))


def _cell(word: str) -> str:
    """A word as a cell: in quotes where CSV needs them, behind ' where a spreadsheet would run it.

    >>> print(_cell("T, W"), _cell("=1+A1"), _cell("-70.7, -30.2 deg"))
    "T, W" "'=1+A1" "-70.7, -30.2 deg"
    """
    word = " ".join(word.split())
    runs = _FORMULA.match(word) is not None
    if not runs and not any(mark in word for mark in ',;"'):
        return word
    return '"' + ("'" if runs else "") + word.replace('"', '""') + '"'


def _remark(text: str) -> str:
    """A text on one line whose parts between separators are no formulas."""
    return re.sub(r"[,;]\s*(?=[=+@-])", " ", " ".join(text.split()))
