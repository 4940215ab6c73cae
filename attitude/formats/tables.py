"""Tables of attitudes: astropy QTable, ECSV, FITS, CSV, parquet.

A QTable, ECSV and FITS have the columns ``time`` (TDB, as two Julian dates: 5e-12 s), ``wxyz``
(body to ICRF, scalar first) and ``angular_velocity`` (rad/s over the body axes).
CSV has ``utc`` (12 decimals), ``tdb_seconds`` since the first row, ``w, x, y, z`` and
``omega_x, omega_y, omega_z``; parquet has ``tdb_jd1, tdb_jd2`` instead of the first two.  Numbers
are written such that reading gives the same doubles.  With ``sigma=True`` there are standard
deviations too: ``sigma`` (rad about the ICRF axes) and ``sigma_angular_velocity``, in CSV and
parquet ``sigma_x, sigma_y, sigma_z, sigma_omega_x, ...``; readers skip them.

Similar tables are read too: with any Time column, ``jd1`` and ``jd2`` (TDB) or ``utc`` for the
epochs, and either form of the other columns.
"""

from __future__ import annotations

import io
import os
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, pairs
from attitude import representations as forms
from attitude.attitude_table.table import AttitudeTable
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.formats import csv_table, parquet, sampling, sources
from attitude.formats.csv_rows import ATTITUDE, RATES
from attitude.formats.rows import TOLERANCE, known_tolerance
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import whole

if TYPE_CHECKING:
    from astropy.table import QTable, Table

    from attitude.annotations import EpochOrSeconds, Epochs, FilePath
    from attitude.formats.sampling import SampledFile
    from attitude.formats.sources import AttitudeSource

_ENDINGS = ("ecsv", "fits", "csv", "parquet")
KINDS: dict[str, str] = {f".{each}": each for each in _ENDINGS} | {".fit": "fits"}


def qtable(
    source: AttitudeSource, *, t: Epochs | None = None, rates: bool = True, sigma: bool = False
) -> QTable:
    """An astropy QTable of a history, a table or a motion with epochs.

    Segments follow each other; ``segment`` in the meta data holds the numbers of their first rows.

    Parameters
    ----------
    source, t
        As of `aem.write`.
    rates : bool
        False leaves angular velocities out.
    sigma : bool
        Add standard deviations, which follow from the covariance of the motion's spin.

    Raises
    ------
    AttitudeError
        As `sources.segments`, and for standard deviations of a motion without a covariance.
    """
    from astropy.table import vstack

    parts = sources.segments(source, t)
    with_rates = rates and all(part.has_rates for part in parts)
    tables: list[QTable] = []
    first: list[int] = []
    for part in parts:
        first.append(sum(map(len, tables)))
        tables.extend(piece.table(rates=with_rates, sigma=sigma) for piece in part.pieces())
    table = tables[0] if len(tables) == 1 else vstack(tables, metadata_conflicts="silent")
    table.meta = {
        "frame": "ICRF",
        "wxyz": "body to ICRF, scalar first",
        "segment": first,
        **_interpolation(parts[0]),
    }
    for key in ("object_name", "object_id", "center"):
        if parts[0].meta.get(key):
            table.meta[key] = parts[0].meta[key]
    return table


def from_table(
    table: Table, origin: str = "the table", *, tolerance: float = TOLERANCE
) -> AttitudeTable:
    """An AttitudeTable from an astropy table; see the module's docstring for the columns.

    Parameters
    ----------
    table : astropy Table or QTable
    origin : str
        Name of the table in error messages.
    tolerance : float
        Largest deviation from 1 of the length of a quaternion.

    Raises
    ------
    AttitudeError
        For missing columns, and values of a wrong type, shape or unit.
    """
    known_tolerance(tolerance)
    time = _times(table, origin)
    wxyz = _columns(table, "wxyz", ATTITUDE, origin, unit=None)
    if wxyz is None:
        raise AttitudeError(f"{origin}: it has no attitudes; give a column wxyz, or w, x, y, z.")
    rates = _columns(table, "angular_velocity", RATES, origin, unit="rad/s")
    meta = {str(key).lower(): value for key, value in table.meta.items()}
    starts = meta.get("segment", [0])
    method, degree = meta.get("method"), meta.get("degree")
    try:
        wxyz = forms.unit(wxyz, tolerance=tolerance)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err
    return _segmented(time, wxyz, rates, starts, method, degree, meta, origin)


def read(path: FilePath, *, tolerance: float = TOLERANCE) -> AttitudeTable:
    """An ECSV, FITS, CSV or parquet file, recognized by its ending, as an AttitudeTable.

    Parameters
    ----------
    path : str or path
    tolerance : float
        Largest deviation from 1 of the length of a quaternion.

    Raises
    ------
    AttitudeError
        For an unknown ending and for broken files; it names the file, and the line of a CSV.
    """
    known_tolerance(tolerance)
    if kind_of(path) == "csv":
        return csv_table.read(path, tolerance=tolerance)
    return from_table(columns_of(path), os.fspath(path), tolerance=tolerance)


def columns_of(path: FilePath) -> Table:
    """The columns and meta data of an ECSV, FITS, CSV or parquet file as an astropy Table.

    Raises
    ------
    AttitudeError
        For an unknown ending and for files that cannot be read.
    """
    kind, origin = kind_of(path), os.fspath(path)
    if kind == "parquet":
        return parquet.read(path)
    readers = {"ecsv": _of_ecsv, "fits": _of_fits, "csv": _of_csv}
    try:
        return readers[kind](path)
    except AttitudeError:
        raise
    except OSError as err:
        raise AttitudeError(f"{origin}: it cannot be read: {err.strerror or err}.") from err
    except Exception as err:  # astropy raises exceptions of any type for broken files
        reason = " ".join(str(err).split())[:120] or type(err).__name__
        raise AttitudeError(f"{origin}: it cannot be read as {kind.upper()}: {reason}.") from None


def _of_ecsv(path):
    return _of_text(path, "give a table in ECSV", "ascii.ecsv")


def _of_csv(path):
    return _of_text(path, "give a table in CSV", "ascii.csv")


def _of_text(path, advice, notation):
    from astropy.table import QTable

    lines = whole(path, advice).split("\n")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return QTable.read(lines, format=notation)


def _of_fits(path):
    from astropy.table import QTable

    # astropy leaves a broken file open if it has opened it.
    with open(path, "rb") as file, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return QTable.read(file, format="fits", astropy_native=True)


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    tolerance: float | None = None,
    rates: bool = True,
    sigma: bool = False,
) -> SampledFile | None:
    """Write attitudes as ECSV, FITS, CSV or parquet, by the ending of the file.

    CSV and parquet are written piece by piece; ECSV and FITS are made in memory by astropy.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    source, t, start, stop, tolerance
        As of `aem.write`; CSV holds one segment.
    rates : bool
        False leaves angular velocities out.
    sigma : bool
        Add standard deviations, as in `qtable`.

    Returns
    -------
    SampledFile or None
        As `aem.write`.

    Raises
    ------
    AttitudeError
        For an unknown ending, several segments in CSV, a file that cannot be written, and as
        `qtable`.
    """
    kind = kind_of(path)
    if tolerance is None:
        sources.refuse_span(start, stop)
        _write(path, kind, source, t, rates, sigma)
        return None
    sources.refuse_epochs(t)
    motion = sources.one_motion(source)
    has_rates = rates and sources.known_of(source, None)[1]
    # CSV and the other tables of motions state no interpolation: readers take the usual one.
    table = motion if isinstance(motion, AttitudeTable) and kind != "csv" else None
    method, degree = sampling.stated(None, None, has_rates, table)
    return sampling.write(
        *(path, motion, start, stop, tolerance),
        method=method,
        degree=degree,
        name="CSV" if kind == "csv" else "the table",
        write_records=lambda target, parts: _write(target, kind, parts, None, rates, sigma),
        read=read,
        one_segment=kind == "csv",
    )


def _write(path, kind, source, t, rates, sigma):
    if kind == "csv":
        part = sources.only_segment(source, t, "CSV")
        csv_table.write(path, part, rates=rates and part.has_rates, sigma=sigma)
    elif kind == "parquet":
        parts = sources.segments(source, t)
        starts = np.cumsum([0, *map(len, parts)])[:-1].tolist()
        meta = {"frame": "ICRF", "segment": starts, **_interpolation(parts[0])}
        rates = rates and all(part.has_rates for part in parts)
        parquet.write(path, parts, rates=rates, meta=meta, sigma=sigma)
    else:
        table = qtable(source, t=t, rates=rates, sigma=sigma)
        if kind == "fits":
            table.meta["segment"] = ",".join(map(str, table.meta["segment"]))
        write_columns(path, table)


def write_columns(path: FilePath, table: Table) -> None:
    """Write an astropy table as ECSV, FITS or parquet, by the ending of the file.

    The file appears whole or not at all.  Parquet takes columns (N,) of numbers or text.

    Raises
    ------
    AttitudeError
        For another ending, and a file that cannot be written.
    """
    kind = kind_of(path)
    if kind == "csv":
        raise AttitudeError(
            f"{os.fspath(path)!r} is CSV, which has no meta data; give .ecsv, .fits or .parquet."
        )
    if kind == "parquet":
        parquet.write_columns(path, {name: table[name] for name in table.colnames}, table.meta)
        return
    # astropy does not notice a full disk, so it writes into memory.
    content: Any
    if kind == "ecsv":
        content = io.StringIO()
        table.write(content, format="ascii.ecsv", serialize_method="jd1_jd2")
    else:
        content = io.BytesIO()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # lower-case keywords become upper-case
            table.write(content, format="fits")
    with written_whole(path, "the table", binary=kind == "fits") as file:
        file.write(content.getvalue())


def kind_of(path: FilePath) -> str:
    """The kind of a file by its ending: "ecsv", "fits", "csv" or "parquet".

    Raises
    ------
    AttitudeError
        For another ending.
    """
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending not in KINDS:
        raise AttitudeError(
            f"{os.fspath(path)!r} ends in {ending!r}; tables end in {', '.join(KINDS)}."
        )
    return KINDS[ending]


def _interpolation(part):
    if part.table is None:
        return {}
    return {"method": part.table.method, "degree": part.table.degree}


def _times(table, origin):
    """TDB in two doubles since J2000."""
    from astropy.time import Time

    for name in table.colnames:
        if isinstance(table[name], Time):
            given = table[name]
            break
    else:
        dates = [("tdb_jd1", "tdb_jd2"), ("jd1", "jd2"), ("JD1", "JD2")]
        found = [pair for pair in dates if set(pair) <= set(table.colnames)]
        if found:
            jd1, jd2 = (np.asarray(table[name], dtype=np.float64) for name in found[0])
            return time_scales.seconds_from_jd(jd1, jd2)
        if "utc" not in table.colnames:
            raise AttitudeError(
                f"{origin}: it has no epochs; give a Time column, or jd1 and jd2 (TDB), or utc."
            )
        given = [str(text) for text in table["utc"]]
    try:
        hi, lo = epochs.seconds_since(epochs.Instant(0.0), given)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err
    return hi, lo


def _columns(table, name, names, origin, unit):
    from attitude import validation

    try:
        if name in table.colnames:
            given = table[name]
        elif set(names) <= set(table.colnames):
            given = np.stack([_plain(table[each], unit) for each in names], axis=-1)
        else:
            return None
        return validation.real(given, name, shape=(len(table), len(names)), unit=unit)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err
    except (ValueError, TypeError) as err:  # from astropy, for unknown units
        reason = " ".join(str(err).split())[:120]
        raise AttitudeError(f"{origin}: the column {name} cannot be read ({reason}).") from None


def _plain(column, unit):
    value = getattr(column, "to_value", None)
    return np.asarray(value(unit) if value is not None and unit else column, dtype=np.float64)


def _segmented(time, wxyz, rates, starts, method, degree, meta, origin):
    hi, lo = time
    try:
        starts = starts.split(",") if isinstance(starts, str) else starts
        starts = [int(start) for start in np.atleast_1d(starts)]
        if starts[0] != 0 or np.any(np.diff([*starts, len(hi)]) <= 0):
            raise AttitudeError("the first rows of its segments do not increase within the table.")
        degree = None if degree is None else int(degree)
        epoch = epochs.Instant(float(hi[0]), float(lo[0]))
        hi, lo = pairs.add((hi, lo), -epoch.seconds, -epoch.low)
        parts = []
        for start, stop in zip(starts, [*starts[1:], len(hi)], strict=True):
            k = slice(start, stop)
            parts.append(
                AttitudeTable(
                    epoch,
                    np.array(hi[k]),
                    wxyz[k],
                    low=np.array(lo[k]),
                    angular_velocity=None if rates is None else rates[k],
                    method=method,
                    degree=degree,
                    meta=meta,
                )
            )
        return AttitudeTable.joined(parts)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err
    except (ValueError, TypeError, IndexError, AttributeError) as err:
        raise AttitudeError(f"{origin}: its epochs or its meta data are broken ({err}).") from err
