"""`read`: photometry in files of any known format."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.photometry import contents, exchange_files, named_columns
from attitude.photometry.contents import Contents
from attitude.photometry.table import Photometry
from attitude.textfiles import lines

if TYPE_CHECKING:
    from attitude.annotations import FilePath

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
        CSV or other separated text and ECSV with named columns (`attitude.photometry.named_columns`
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
    """The `Contents` of a file; parameters and errors as of `read`."""
    name = os.fspath(path)
    validation.one_of(bad, "bad", ("warn", "refuse", "ignore"))
    text, notes = _decoded(name, encoding)
    kind = _kind(text, name) if format is None else validation.one_of(format, "format", FORMATS)
    if columns and kind not in ("csv", "ecsv"):
        raise AttitudeError(f"columns is given, but {name} is {kind}, whose columns are fixed.")
    if kind == "csv":
        found = named_columns.of_text(text, name, columns)
    elif kind == "ecsv":
        found = named_columns.of_table(*_of_ecsv(text, name), name, columns)
    elif kind == "damit":
        found = exchange_files.of_damit(path, name)
    else:
        reader = {
            "alcdef": exchange_files.of_alcdef,
            "ades-psv": exchange_files.of_ades_text,
            "ades-xml": exchange_files.of_ades_xml,
            "mpc": exchange_files.of_mpc,
        }[kind]
        found = reader(text, name)
    found.notes += notes
    contents.report(found, bad)
    return found


def _decoded(name: str, encoding: str | None) -> tuple[str, list[str]]:
    """The text of a file, and a note if its encoding is a guess."""
    advice = "give a file of photometry, or its encoding="
    try:
        return lines.whole(name, advice, encoding or "UTF-8"), []
    except AttitudeError as err:
        if encoding is not None or not isinstance(err.__cause__, UnicodeDecodeError):
            raise
        text = lines.whole(name, advice, "latin-1")
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
    if sum(exchange_files.is_mpc(row) for row in rows) > len(rows) // 3 and rows:
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
    """Columns of text of an ECSV, in the units of `named_columns`, and the lines of its rows."""
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
    """A column in days, magnitudes, degrees or au, as `named_columns` reads it."""
    unit = getattr(column, "unit", None)
    if unit is None:
        return column
    for wanted in ("d", "mag", "deg", "au"):
        if unit.is_equivalent(wanted):
            return getattr(column, "quantity", column).to_value(wanted)
    return column


def _text(value: Any) -> str:
    return "" if np.ma.is_masked(value) else str(getattr(value, "value", value))
