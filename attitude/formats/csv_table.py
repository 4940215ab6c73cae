"""CSV files of attitudes; `csv_rows` has their columns.

The first line names the columns, in any order; readers skip unknown ones.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude.axes.axes import named
from attitude.errors import quoted
from attitude.formats import csv_rows
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.ccsds.attitude_types import Convention
from attitude.formats.csv_rows import ATTITUDE, RATES
from attitude.formats.rows import Rows
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import NoNumber, numbers, opened

if TYPE_CHECKING:
    from attitude.annotations import FilePath
    from attitude.attitude_table.table import AttitudeTable
    from attitude.formats.sources import Records

_BATCH = 16384


def write(path: FilePath, part: Records, *, rates: bool, sigma: bool = False) -> None:
    """Write one segment piece by piece.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    part : Records
    rates, sigma : bool
        Write angular velocities, and standard deviations.

    Raises
    ------
    AttitudeError
        If the file cannot be written, or a motion without a covariance has no standard deviations.
    """
    ends, rest = part.first_and_last()
    with written_whole(path, "the table") as file:
        file.write(",".join(csv_rows.names(rates=rates, sigma=sigma)) + "\n")
        for history in part.pieces():
            dates = ccsds_epochs.texts(history.epoch, history.seconds, history.low, "utc")
            low = 0.0 if history.low is None else history.low
            since = (history.seconds - ends[0]) + (low - rest[0])
            file.write(csv_rows.of_history(dates, since, history, rates=rates, sigma=sigma))


def read(path: FilePath, *, tolerance: float) -> AttitudeTable:
    """The attitudes of a file.

    `tolerance` is the largest deviation from 1 of the length of a quaternion.

    Raises
    ------
    AttitudeError
        For broken files; it names the file and the line.
    """
    with opened(path) as lines:
        names = _names(lines)
        kind = "QUATERNION/ANGVEL" if RATES[0] in names else "QUATERNION"
        columns = [*ATTITUDE, *(RATES if kind.endswith("ANGVEL") else ())]
        places = [names.index(name) for name in columns]
        where = names.index("utc")
        rows = Rows("utc", len(columns))
        batch: list[bytes] = []
        at: list[int] = []
        for line in lines:
            if not line.strip():
                continue
            parts = line.split(b",")
            if len(parts) != len(names):
                raise lines.fault(
                    f"it has {len(parts)} columns; the first line names {len(names)}."
                )
            batch.extend(parts)
            at.append(lines.number)
            if len(at) == _BATCH:
                _take(rows, batch, at, where, places, columns, lines)
                batch, at = [], []
        _take(rows, batch, at, where, places, columns, lines)
        if not rows.count:
            raise lines.fault("the file has no rows.")
        how = Convention(scalar_first=True, in_radians=True)
        meta = {"format": "CSV"}
        return rows.table(kind, how, named("ICRF"), lines.fault, tolerance=tolerance, meta=meta)


def _names(lines):
    for line in lines:
        text = lines.text(line).strip()
        if text and not text.startswith("#"):
            names = [name.strip().strip('"') for name in text.split(",")]
            lacking = [name for name in ("utc", *ATTITUDE) if name not in names]
            some = [name for name in RATES if name in names]
            if lacking or len(set(names)) < len(names) or len(some) not in (0, 3):
                raise lines.fault(
                    f"the first line names {quoted(', '.join(names), 120, '')}; it must name utc, "
                    f"{', '.join(ATTITUDE)} and none or all of {', '.join(RATES)}, each once."
                )
            return names
    raise lines.fault("the file is empty.")


def _take(rows, batch, at, where, places, columns, lines):
    if not at:
        return
    step = len(batch) // len(at)
    try:
        values = numbers(batch, step, places)
    except NoNumber as err:
        raise lines.fault(
            f"{columns[err.column]} is {err.shown}, which is no number.", at[err.line]
        ) from err
    rows.add([token.strip() for token in batch[where::step]], values, at, lines.fault)
