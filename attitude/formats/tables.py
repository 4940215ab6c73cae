"""Tables of attitudes: astropy QTable, ECSV, FITS, CSV, parquet.

A QTable, ECSV and FITS have the columns ``time`` (TDB, as two Julian dates: 5e-12 s), ``wxyz``
(body to ICRF, scalar first) and ``angular_velocity`` (rad/s over the body axes).
CSV has ``utc`` (12 decimals), ``tdb_seconds`` since the first row, ``w, x, y, z`` and
``omega_x, omega_y, omega_z``; parquet has ``tdb_jd1, tdb_jd2`` instead of the first two.  Numbers
are written such that reading gives the same doubles.  With ``sigma=True`` there are standard
deviations too: ``sigma`` (rad about the ICRF axes) and ``sigma_angular_velocity``, in CSV and
parquet ``sigma_x, sigma_y, sigma_z, sigma_omega_x, ...``; readers skip them.

Similar tables are read too: with any Time column, ``jd1`` and ``jd2`` (TDB) or ``utc`` for the
epochs, and either form of the other columns.  ``frame`` of the meta data names other axes than
ICRF.
"""

from __future__ import annotations

import io
import json
import os
import warnings
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs, validation
from attitude._support.quantity_text import quoted
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import opened, path_text, prefixed, text_of_rows, whole
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _inputs, _instants, _time_scales
from attitude.errors import AttitudeError
from attitude.formats import _sampling
from attitude.formats._format import Format, register, table_reader
from attitude.formats._records import TOLERANCE, Convention, Rows, in_icrf, known_tolerance
from attitude.frames import quaternion as forms
from attitude.motions._axes import named
from attitude.motions._table import AttitudeTable

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from astropy.table import QTable, Table

    from attitude._support.annotations import EpochOrSeconds, Epochs, FilePath, FloatArray
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._history import AttitudeHistory
    from attitude.paths._path import Path

__all__ = [
    "KINDS",
    "columns_of",
    "from_table",
    "kind_of",
    "qtable",
    "read",
    "write",
    "write_columns",
]


# ---- The CSV of attitudes: its columns, and rows whose numbers are read back as the same doubles

# Columns of the attitude (body to ICRF, scalar first) and of the angular velocity (rad/s, body).
ATTITUDE: tuple[str, ...] = ("w", "x", "y", "z")
RATES: tuple[str, ...] = ("omega_x", "omega_y", "omega_z")
# Their standard deviations: rad about the ICRF axes, rad/s over the body axes.
SIGMA: tuple[str, ...] = ("sigma_x", "sigma_y", "sigma_z")
SIGMA_RATES: tuple[str, ...] = ("sigma_omega_x", "sigma_omega_y", "sigma_omega_z")
# Order and units of the columns.
_CONVENTION = Convention(scalar_first=True, in_radians=True)


def names(*, rates: bool, sigma: bool = False) -> list[str]:
    """Names of the columns: UTC, TDB seconds, then those of `columns_of_numbers`."""
    columns = [*ATTITUDE, *(RATES if rates else ())]
    if sigma:
        columns += [*SIGMA, *(SIGMA_RATES if rates else ())]
    return ["utc", "tdb_seconds", *columns]


def columns_of_numbers(
    history: AttitudeHistory, *, rates: bool, sigma: bool = False
) -> list[FloatArray]:
    """Columns (N,) of a history: attitude, angular velocity, and their standard deviations."""
    columns = [*history.wxyz.T, *(history.angular_velocity.T if rates else ())]
    if sigma:
        # First the one from which the other one follows.
        of_rates = history.sigma_angular_velocity.T if rates else ()
        columns += [*history.sigma.T, *of_rates]
    return columns


def of_history(
    dates: Iterable[str], seconds: FloatArray, history: AttitudeHistory, **columns: bool
) -> str:
    """The text of N rows with the columns `names`, at seconds (N,)."""
    numbers = columns_of_numbers(history, **columns)
    return text(dates, seconds.tolist(), *(column.tolist() for column in numbers))


def text(dates: Iterable[str], *columns: Iterable[float]) -> str:
    """The text of rows: a date, and one number of each column."""
    return text_of_rows(dates, columns, ",")


# ---- CSV files of attitudes
# The first line names the columns, in any order; readers skip unknown ones.


def _write_csv(path, segment, **columns):
    """Write one segment piece by piece."""
    ends, low_ends = segment.first_and_last()
    with written_whole(path, "the table") as file:
        file.write(",".join(names(**columns)) + "\n")
        for history in segment.pieces():
            dates = ccsds_epochs.texts(history.epoch, history.seconds, history.low, "utc")
            since = (history.seconds - ends[0]) + (pairs.Seconds.of(history).low - low_ends[0])
            file.write(of_history(ccsds_epochs.distinct(dates), since, history, **columns))


def _read_csv(path, tolerance):
    """The attitudes of a file."""
    with opened(path) as lines:
        names = _names(lines)
        kind = "QUATERNION/ANGVEL" if RATES[0] in names else "QUATERNION"
        columns = [*ATTITUDE, *(RATES if kind.endswith("ANGVEL") else ())]
        rows, date = Rows("utc", lines.fault, columns), names.index("utc")
        rows.arrange([names.index(name) for name in ("utc", *columns)], len(names))
        for line in lines:
            if not line.strip():
                continue
            entries = line.split(b",")
            if len(entries) != len(names):
                raise lines.fault(
                    f"it has {len(entries)} columns; the first line names {len(names)}."
                )
            entries[date] = entries[date].strip()
            rows.take(entries, lines.number)
        rows.convert()
        meta = {"format": "CSV"}
        return rows.table(kind, _CONVENTION, named("ICRF"), tolerance=tolerance, meta=meta)


def _names(lines):
    text = next(lines.texts(), None)
    if text is None:
        raise lines.fault("the file is empty.")
    names = [name.strip().strip('"') for name in text.split(",")]
    lacking = [name for name in ("utc", *ATTITUDE) if name not in names]
    some = [name for name in RATES if name in names]
    if lacking or len(set(names)) < len(names) or len(some) not in (0, 3):
        raise lines.fault(
            f"the first line names {quoted(', '.join(names), 120, '')}; it must name utc, "
            f"{', '.join(ATTITUDE)} and none or all of {', '.join(RATES)}, each once."
        )
    return names


# ---- Parquet files of attitudes, by pyarrow
# Columns are ``tdb_jd1, tdb_jd2, w, x, y, z``, ``omega_x, omega_y, omega_z`` and standard
# deviations, as in CSV; the meta data of `tables.qtable` stand as JSON under the key "attitude" of
# the schema.

# Rows of a group, which readers hold in memory at a time.
_GROUP = 1 << 17


def _write_parquet(path, parts, meta, **columns):
    """Write segments piece by piece."""
    pyarrow = _pyarrow()
    schema = pyarrow.schema(
        [(name, pyarrow.float64()) for name in ("tdb_jd1", "tdb_jd2", *names(**columns)[2:])],
        metadata={"attitude": json.dumps(meta), "wxyz": "body to ICRF, scalar first"},
    )
    with _parquet(path, schema) as writer:
        for history in (piece for segment in parts for piece in segment.pieces()):
            epoch = history.epoch
            time = pairs.Seconds.of(history).plus(epoch.seconds, epoch.low)
            numbers = [
                *_time_scales.jd_from_seconds(*time),
                *columns_of_numbers(history, **columns),
            ]
            arrays = [pyarrow.array(np.ascontiguousarray(column)) for column in numbers]
            writer.write_table(pyarrow.Table.from_arrays(arrays, schema=schema))


def write_parquet_columns(
    path: FilePath, columns: Mapping[str, Any], meta: Mapping[str, Any]
) -> None:
    """Write columns (N,) of numbers or text, in groups of rows."""
    pyarrow = _pyarrow()
    arrays = {name: pyarrow.array(np.ascontiguousarray(column)) for name, column in columns.items()}
    table = pyarrow.table(arrays).replace_schema_metadata({"attitude": json.dumps(dict(meta))})
    with _parquet(path, table.schema) as writer:
        writer.write_table(table, row_group_size=_GROUP)


@contextmanager
def _parquet(path, schema):
    with (
        written_whole(path, "the table", binary=True) as file,
        _pyarrow().parquet.ParquetWriter(file, schema) as writer,
    ):
        yield writer


def read_parquet(path: FilePath) -> Table:
    """The columns of a file as an astropy Table, with the meta data that `write` has written."""
    from astropy.table import Table

    pyarrow = _pyarrow()
    origin = path_text(path)
    try:
        table = pyarrow.parquet.read_table(origin)
        meta = meta_of(table)
    except OSError as err:
        raise AttitudeError(f"{origin}: it cannot be read: {_reason(err)}.") from err
    except (pyarrow.ArrowException, ValueError, TypeError) as err:
        raise AttitudeError(f"{origin}: it cannot be read as parquet: {_reason(err)}.") from err
    try:
        columns = {name: table[name].to_numpy() for name in table.column_names}
        return Table(columns, meta=meta if isinstance(meta, dict) else {})
    except (ValueError, TypeError, pyarrow.ArrowException) as err:
        raise AttitudeError(f"{origin}: its columns cannot be read ({err}).") from err


def _reason(err):
    """The message of another package in one line."""
    return " ".join(str(err).split())[:120]


def meta_of(table: Any) -> Any:
    """The meta data that `write` and `write_columns` have written, of an arrow table."""
    return json.loads((table.schema.metadata or {}).get(b"attitude", b"{}"))


def _pyarrow():
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as err:
        raise AttitudeError(
            "parquet files need pyarrow, which is not installed; install it by "
            f"{validation.installing('parquet')}."
        ) from err
    return pyarrow


_ENDINGS = ("ecsv", "fits", "csv", "parquet")
KINDS: dict[str, str] = {f".{ending}": ending for ending in _ENDINGS} | {".fit": "fits"}


def qtable(
    source: AttitudeSource, *, t: Epochs | None = None, rates: bool = True, sigma: bool = False
) -> QTable:
    """An astropy QTable of a history, a table or a motion with epochs.

    Segments follow each other; ``segment`` in the meta data holds the numbers of their first rows.
    """
    from astropy.table import vstack

    parts = _sampling.segments(source, t)
    with_rates = rates and _have_rates(parts)
    pieces = (piece for segment in parts for piece in segment.pieces())
    tables = [piece.table(rates=with_rates, sigma=sigma) for piece in pieces]
    table = tables[0] if len(tables) == 1 else vstack(tables, metadata_conflicts="silent")
    table.meta = {"frame": "ICRF", "wxyz": "body to ICRF, scalar first", **_said_of(parts)}
    for key in ("object_name", "object_id", "center"):
        if parts[0].meta.get(key):
            table.meta[key] = parts[0].meta[key]
    return table


def from_table(
    table: Table,
    origin: str = "the table",
    *,
    tolerance: float = TOLERANCE,
    orbit: Path | None = None,
) -> AttitudeTable:
    """An AttitudeTable from an astropy table; see the module's docstring for the columns."""
    known_tolerance(tolerance)
    time = _times(table, origin)
    wxyz = _columns(table, "wxyz", ATTITUDE, origin, unit=None)
    if wxyz is None:
        raise AttitudeError(f"{origin}: it has no attitudes; give a column wxyz, or w, x, y, z.")
    rates = _columns(table, "angular_velocity", RATES, origin, unit="rad/s")
    meta = {str(key).lower(): value for key, value in table.meta.items()}
    with prefixed(origin):
        wxyz = forms.unit(wxyz, tolerance=tolerance)
        axes, where = named(meta.get("frame", "ICRF")), (_instants.J2000, *time, orbit)
        if rates is None:
            wxyz, rates = in_icrf("QUATERNION", wxyz, _CONVENTION, axes, where)
        else:
            both = np.concatenate([wxyz, rates], axis=1)
            wxyz, rates = in_icrf("QUATERNION/ANGVEL", both, _CONVENTION, axes, where)
        return _segmented(time, wxyz, rates, meta)


def read(
    path: FilePath, *, tolerance: float = TOLERANCE, orbit: Path | None = None
) -> AttitudeTable:
    """An ECSV, FITS, CSV or parquet file, recognized by its ending, as an AttitudeTable.

    Parameters
    ----------
    path : str or path
    tolerance : float
        Largest deviation from 1 of the length of a quaternion.
    orbit : Path, optional
        Path of the body about its center, for attitudes relative to LVLH or RTN.

    Raises
    ------
    AttitudeError
        For an unknown ending and for broken files; it names the file, and the line of a CSV.
    """
    known_tolerance(tolerance)
    if kind_of(path) == "csv":
        return _read_csv(path, tolerance)
    return from_table(columns_of(path), os.fspath(path), tolerance=tolerance, orbit=orbit)


def columns_of(path: FilePath) -> Table:
    """The columns and meta data of an ECSV, FITS, CSV or parquet file as an astropy Table."""
    kind, origin = kind_of(path), os.fspath(path)
    if kind == "parquet":
        return read_parquet(path)
    try:
        return _of_fits(path) if kind == "fits" else _of_text(path, kind)
    except AttitudeError:
        raise
    except OSError as err:
        raise AttitudeError(f"{origin}: it cannot be read: {err.strerror or err}.") from err
    except Exception as err:  # astropy raises exceptions of any type for broken files
        reason = _reason(err) or type(err).__name__
        raise AttitudeError(f"{origin}: it cannot be read as {kind.upper()}: {reason}.") from None


def _of_text(path, kind):
    from astropy.table import QTable

    lines = whole(path, f"give a table in {kind.upper()}").split("\n")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return QTable.read(lines, format=f"ascii.{kind}")


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
        As in `aem.write`; CSV holds one segment.
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
    stated = "", 0
    if tolerance is not None:
        has_rates = rates and _sampling.known_of(source, None)[1]
        # CSV and the other tables of motions state no interpolation: readers take the usual one.
        stated = _sampling.stated(None, None, has_rates, None if kind == "csv" else source)
    writing = _sampling.Writing(
        stated,
        lambda target, parts: _write(target, kind, parts, rates, sigma),
        read,
        name="CSV" if kind == "csv" else "the table",
        holder="CSV" if kind == "csv" else None,
    )
    return _sampling.write(path, source, t, (start, stop), tolerance, writing)


def _write(path, kind, parts, rates, sigma):
    rates = rates and _have_rates(parts)
    if kind == "csv":
        _write_csv(path, parts[0], rates=rates, sigma=sigma)
    elif kind == "parquet":
        meta = {"frame": "ICRF", **_said_of(parts)}
        _write_parquet(path, parts, meta, rates=rates, sigma=sigma)
    else:
        table = qtable(parts, rates=rates, sigma=sigma)
        if kind == "fits":
            lists = {key: value for key, value in table.meta.items() if isinstance(value, list)}
            table.meta |= {key: ",".join(map(str, value)) for key, value in lists.items()}
        write_columns(path, table)


def write_columns(path: FilePath, table: Table) -> None:
    """Write an astropy table as ECSV, FITS or parquet, by the ending of the file.

    The file appears whole or not at all.  Parquet takes columns (N,) of numbers or text.
    """
    kind = _kind_among([ending for ending in KINDS if ending != ".csv"], path)
    if kind == "parquet":
        write_parquet_columns(path, {name: table[name] for name in table.colnames}, table.meta)
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
            try:
                table.write(content, format="fits")
            except UnicodeEncodeError as err:
                raise AttitudeError(
                    f"{os.fspath(path)!r}: FITS has no letter {err.object[err.start]!r}, only "
                    "those of ASCII; give .ecsv or .parquet."
                ) from None
    with written_whole(path, "the table", binary=kind == "fits") as file:
        file.write(content.getvalue())


def kind_of(path: FilePath) -> str:
    """The kind of a file by its ending: "ecsv", "fits", "csv" or "parquet"."""
    return _kind_among(KINDS, path)


def _kind_among(endings, path):
    ending = os.path.splitext(path_text(path))[1].lower()
    if ending not in endings:
        raise AttitudeError(
            f"{os.fspath(path)!r} ends in {ending!r}; tables end in {', '.join(endings)}."
        )
    return KINDS[ending]


def _have_rates(parts):
    """Whether all segments have angular velocities; AttitudeError if only some have."""
    known = {segment.has_rates for segment in parts}
    if len(known) > 1:
        raise AttitudeError(
            "some segments have angular velocities and others have none, and tables have them for "
            "all or none; give rates=False, or write an AEM."
        )
    return known == {True}


def _said_of(parts):
    """The first rows of segments, and their interpolation if they are those of tables.

    Method and degree are lists if they are not those of all segments.  If one is usable in less
    than its rows, `usable` holds the first and last epoch of each: TDB seconds since J2000, each
    the sum of two numbers.
    """
    meta, tables = {"segment": np.cumsum([0, *map(len, parts)])[:-1].tolist()}, []
    for segment in parts:
        if segment.table is None:
            return meta
        tables.append(segment.table)
    for key in ("method", "degree"):
        values = [getattr(table, key) for table in tables]
        meta[key] = values if len(set(values)) > 1 else values[0]
    if any(segment.usable for segment in parts):
        ends = (end for table in tables for end in table.span)
        meta["usable"] = [number for end in ends for number in (end.seconds, end.low)]
    return meta


def _values_of(value):
    """The values of meta data as a list: of one value, or of several, in FITS text with commas."""
    return value.split(",") if isinstance(value, str) else np.atleast_1d(value).tolist()


def _times(table, origin):
    """TDB in two doubles since J2000."""
    from astropy.time import Time

    column = next((table[x] for x in table.colnames if isinstance(table[x], Time)), None)
    if column is None:
        for names in (("tdb_jd1", "tdb_jd2"), ("jd1", "jd2"), ("JD1", "JD2")):
            if set(names) <= set(table.colnames):
                dates = (np.asarray(table[name], dtype=np.float64) for name in names)
                return _time_scales.seconds_from_jd(*dates)
        if "utc" not in table.colnames:
            raise AttitudeError(
                f"{origin}: it has no epochs; give a Time column, or jd1 and jd2 (TDB), or utc."
            )
        column = [str(text) for text in table["utc"]]
    with prefixed(origin):
        return _inputs.seconds_since(_instants.J2000, column)


def _columns(table, name, names, origin, unit):
    try:
        if name in table.colnames:
            column = table[name]
        elif set(names) <= set(table.colnames):
            column = np.stack([_plain(table[one], unit) for one in names], axis=-1)
        else:
            return None
        with prefixed(origin):
            return validation.real(column, name, shape=(len(table), len(names)), unit=unit)
    except (ValueError, TypeError) as err:  # from astropy, for unknown units
        if isinstance(err, AttitudeError):
            raise
        raise AttitudeError(
            f"{origin}: the column {name} cannot be read ({_reason(err)})."
        ) from None


def _plain(column, unit):
    value = getattr(column, "to_value", None)
    return np.asarray(value(unit) if value is not None and unit else column, dtype=np.float64)


def _segmented(time, wxyz, rates, meta):
    """The AttitudeTable of rows with the meta data segment, method, degree and usable."""
    hi, lo = time
    try:
        starts = [int(start) for start in _values_of(meta.get("segment", 0))]
        if starts[0] != 0 or np.any(np.diff([*starts, len(hi)]) <= 0):
            raise AttitudeError("the first rows of its segments do not increase within the table.")
        methods, degrees = (
            values * len(starts) if len(values) == 1 else values
            for values in (_values_of(meta.get(key)) for key in ("method", "degree"))
        )
        usable: list[Any] = [None] * len(starts)
        if "usable" in meta:
            ends = np.reshape([float(end) for end in _values_of(meta["usable"])], (-1, 2, 2))
            usable = [[_instants.Instant(*end) for end in pair] for pair in ends]
        epoch = _instants.Instant(hi[0], lo[0])
        hi, lo = pairs.add((hi, lo), -epoch.seconds, -epoch.low)
        rows = map(slice, starts, [*starts[1:], len(hi)])
        parts = [
            AttitudeTable(
                epoch,
                np.array(hi[k]),
                wxyz[k],
                low=np.array(lo[k]),
                angular_velocity=None if rates is None else rates[k],
                method=method,
                degree=None if degree is None else int(degree),
                usable=pair,
                meta=meta,
            )
            for k, method, degree, pair in zip(rows, methods, degrees, usable, strict=True)
        ]
        return AttitudeTable.joined(parts)
    except (ValueError, TypeError, IndexError, AttributeError) as err:
        if isinstance(err, AttitudeError):
            raise
        raise AttitudeError(f"its epochs or its meta data are broken ({err}).") from err


register(
    Format(
        name="table",
        module=__name__,
        title="tables",
        endings=(".ecsv", ".fits", ".fit", ".csv", ".parquet"),
        read=table_reader(read),
        reading=("tolerance", "orbit"),
        write=write,
        noun="a table",
    )
)
