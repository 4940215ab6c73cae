"""Plain tables of quaternions (.quat): a line that names the columns, then a record a line.

The first line is ``# time w x y z`` or ``# time x y z w``.  Behind the columns may stand
``reference-to-body`` (by default the numbers are those of the rotation body to reference, as
`AttitudeHistory.wxyz`), ``frame=EME2000`` (ICRF by default) and ``epoch=2026-01-01T00:00:00``.
Times are dates in UTC, or TDB seconds since the epoch, which is then needed.  Further lines that
begin with # are comments.  Files are written with dates, ``w x y z``, body to reference.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.quat")
...     write(path, motion, t=[0.0, 10.0, 20.0])
...     table = read(path)
>>> table.wxyz.shape, table.epoch.utc_iso
((3, 4), '2026-01-01T00:00:00')
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude._support import pairs
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import cut, is_number, opened, text_of_rows
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.formats import _sampling
from attitude.formats._format import Format, refuse_foreign, register, table_reader
from attitude.formats._records import TOLERANCE, Convention, Rows, columns_of, known_tolerance
from attitude.motions._axes import named

if TYPE_CHECKING:
    from attitude._support.annotations import EpochOrSeconds, Epochs, FilePath
    from attitude.epochs._instants import Instant
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._table import AttitudeTable
    from attitude.paths._path import Path


__all__ = ["read", "write"]

# The columns that a first line may name, and whether the scalar stands first.
_ORDERS = {"time w x y z": True, "time x y z w": False}
_DIRECTIONS = ("body-to-reference", "reference-to-body")


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
) -> AttitudeTable:
    """A table of quaternions as an AttitudeTable without angular velocities.

    Parameters
    ----------
    path, tolerance, frame, orbit
        As of `aem.read`; `frame` replaces that of the first line.

    Returns
    -------
    AttitudeTable
        Relative to ICRF.

    Raises
    ------
    AttitudeError
        With file and line: for a first line that does not name the columns, seconds without an
        epoch, lines that are no record, and as `aem.read`.
    """
    known_tolerance(tolerance)
    with opened(path) as lines:
        scalar_first, words = _header(lines)
        to_body = words.get("direction", _DIRECTIONS[0]) == _DIRECTIONS[0]
        convention = Convention(scalar_first=scalar_first, to_body=to_body)
        if frame:
            axes = named(frame)
        else:
            with lines.located(1):
                axes = named(words.get("frame", "ICRF"))
        rows = _Records("utc", lines.fault, ("",) * 4)
        rows.epoch = words.get("epoch")
        for line in lines:
            tokens = line.split()
            if tokens and not tokens[0].startswith(b"#"):
                rows.take(rows.known(tokens, lines.number), lines.number)
        rows.convert()
        settings = {"meta": {"format": "quat", "frame": axes.name}}
        return rows.table(
            "QUATERNION", convention, axes, tolerance=tolerance, orbit=orbit, **settings
        )


def _header(lines):
    """Whether the scalar stands first, and the further words of the first line by their keys."""
    parts = lines.text(next(lines, b"")).removeprefix("#").split()
    order = " ".join(parts[:5])
    if order not in _ORDERS:
        raise lines.fault(
            f"it must name the columns: {' or '.join(f'# {columns}' for columns in _ORDERS)}.", 1
        )
    words = {}
    for word in parts[5:]:
        key, equals, value = word.partition("=")
        if word in _DIRECTIONS:
            key, value = "direction", word
        elif key not in ("frame", "epoch") or not equals:
            raise lines.fault(
                f"{cut(word)} is not known; behind the columns may stand {_DIRECTIONS[1]}, "
                "frame=NAME and epoch=DATE.",
                1,
            )
        if key in words:
            raise lines.fault(f"{cut(word)} is a second {key}; give one.", 1)
        words[key] = value
    if "epoch" in words:
        try:
            words["epoch"] = ccsds_epochs.instant(words["epoch"], "utc")
        except ccsds_epochs.BadEpoch as err:
            raise lines.fault(f"epoch {cut(words['epoch'])}: {err.reason}.", 1) from err
    return _ORDERS[order], words


class _Records(Rows):
    """The records, at dates or at seconds since the epoch of the first line."""

    holds = "a record has a time and 4 numbers"
    epoch: Instant | None = None

    def add(self, leads, values, lines):
        """Add N records, whose times are seconds if that of the first is a number."""
        if not is_number(leads[0][0]):
            super().add(leads, values, lines)
            return
        if self.epoch is None:
            raise self.fault(
                "its time is in seconds, but the first line has no epoch; add "
                "epoch=2026-01-01T00:00:00 (UTC) there, or write dates.",
                lines[0],
            )
        seconds = self.seconds_of(leads[0], lines)
        start = np.float64(self.epoch.seconds), np.float64(self.epoch.low)
        self.add_times(*pairs.add(start, seconds), values, lines)


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    tolerance: float | None = None,
    frame: str = "ICRF",
    orbit: Path | None = None,
) -> SampledFile | None:
    """Write attitudes as a table of quaternions: dates in UTC, w x y z, body to `frame`.

    Parameters
    ----------
    path, source, t, start, stop, tolerance, frame, orbit
        As of `aem.write`; one segment, without angular velocities.

    Returns
    -------
    SampledFile or None
        As `aem.write`.

    Raises
    ------
    AttitudeError
        For several segments, an unknown frame, and a file that cannot be written.
    """
    refuse_foreign(path, "quat")
    axes = named(frame)

    def write_records(target, parts):
        with written_whole(target, "the table of quaternions") as file:
            file.write(f"# time w x y z frame={axes.name}\n")
            convention, pieces = Convention(scalar_first=True), parts[0].pieces()
            for history, columns in columns_of(pieces, "QUATERNION", convention, axes, orbit):
                dates = ccsds_epochs.texts(history.epoch, history.seconds, history.low, "utc")
                file.write(text_of_rows(ccsds_epochs.distinct(dates), columns.T.tolist(), " "))

    writing = _sampling.Writing(
        _sampling.stated(None, None, has_rates=False),
        write_records,
        lambda target: read(target, orbit=orbit),
        name="the table of quaternions",
        holder="a table of quaternions",
    )
    return _sampling.write(path, source, t, (start, stop), tolerance, writing)


register(
    Format(
        name="quat",
        module=__name__,
        title="plain quaternions",
        endings=(".quat",),
        marks=tuple(f"# {order}".encode() for order in _ORDERS),
        read=table_reader(read),
        reading=("tolerance", "frame", "orbit"),
        write=write,
        writing=("frame", "orbit"),
        noun="a table of quaternions",
    )
)
