"""What a file of photometry holds: good rows as arrays, bad rows with the reason of each."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from attitude import epochs
from attitude.errors import AttitudeError, AttitudeWarning

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray

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


@dataclass
class Contents:
    """The rows of a file that can be used.

    Attributes
    ----------
    name : str
        Of the file, in messages.
    times : Time or list of str
        Epochs (N,).
    value, error : (N,) arrays
        Magnitudes or fluxes; NaN where an error is unknown.
    is_flux : bool
    filter, site, session : list of str or None
    time_of : str
        Where light is at the times, one of `PLACES`.
    unit_distances : bool
        Whether the brightness is that at 1 au from Sun and observer.
    rows : (N,) array of int
        The numbers of the good rows among all of them.
    bad : list of BadRow
    notes : list of str
    more : dict
        Further keywords of `Photometry`, such as vectors to Sun and observer.
    """

    name: str
    times: Any
    value: FloatArray
    error: FloatArray
    is_flux: bool = False
    filter: list[str] | None = None
    site: list[str] | None = None
    session: list[str] | None = None
    time_of: str = "reception"
    unit_distances: bool = False
    rows: Any = None
    bad: list[BadRow] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)

    def keywords(self) -> dict[str, Any]:
        """The keywords of `Photometry` and of `LightCurve`, as far as the file has them."""
        found: dict[str, Any] = {
            "times": self.times,
            "flux" if self.is_flux else "magnitude": self.value,
        }
        if np.any(np.isfinite(self.error)):
            found["sigma"] = np.where(np.isfinite(self.error), self.error, 0.0)
        for name in ("filter", "site", "session"):
            words = getattr(self, name)
            if words is not None and any(words):
                found[name] = words
        return found | self.more


def of_rows(
    rows: Sequence[RawPoint],
    name: str,
    *,
    scale: str | None = None,
    offset: float = 0.0,
    is_flux: bool = False,
    bad: list[BadRow] | None = None,
) -> Contents:
    """The `Contents` of rows of text.

    Parameters
    ----------
    rows : sequence of RawPoint
    name : str
        Of the file.
    scale : str or None
        Time scale of Julian dates; None for dates as text (ISO 8601 in UTC).
    offset : float
        Added to the Julian dates.
    is_flux : bool
    bad : list of BadRow, optional
        Rows that were left out before.

    Raises
    ------
    AttitudeError
        If no row can be used.
    """
    left_out, kept, numbers = list(bad or ()), [], []
    without = 0
    word = "flux" if is_flux else "magnitude"
    for k, row in enumerate(rows):
        if row.value.strip().lower() in _BLANK:
            without += 1
            continue
        reason, value, error = _numbers(row, word, is_flux)
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
    left_out.sort(key=lambda each: each.line)
    if not kept:
        raise AttitudeError(
            f"{name}: no row can be used"
            + (f" ({without} rows have no {word})" if without else "")
            + (f"; {_listed(left_out)}" if left_out else "")
            + "."
        )
    notes = [f"{without} of {len(rows)} rows have no {word}."] if without else []
    notes += _repeated([rows[k] for k in kept], word)
    both = np.array(numbers).reshape(-1, 2)
    words: dict[str, Any] = {
        key: each if any(each) else None
        for key in ("filter", "site", "session")
        for each in [[getattr(rows[k], key).strip() for k in kept]]
    }
    return Contents(
        name,
        times,
        both[:, 0],
        both[:, 1],
        is_flux=is_flux,
        rows=np.array(kept),
        bad=left_out,
        notes=notes,
        filter=words["filter"],
        site=words["site"],
        session=words["session"],
    )


def _repeated(rows: Sequence[RawPoint], word: str) -> list[str]:
    """A note of rows that repeat others, and of the sessions that consist of such rows."""
    first: dict[tuple[str, ...], RawPoint] = {}
    repeats: list[tuple[RawPoint, RawPoint]] = []
    for row in rows:
        key = tuple(each.strip() for each in (row.time, row.value, row.filter, row.site))
        if (earlier := first.setdefault(key, row)) is not row:
            repeats.append((row, earlier))
    if not repeats:
        return []
    count = Counter(row.session for row in rows)
    again = Counter((row.session, earlier.session) for row, earlier in repeats)
    whole = [
        f"session {row[:40]!r} repeats {earlier[:40]!r}"
        for (row, earlier), many in again.items()
        if row != earlier and many == count[row]
    ]
    row, earlier = repeats[0]
    return [
        f"{len(repeats)} of {len(rows)} rows repeat the date, {word}, filter and site of others "
        f"(line {row.line} those of line {earlier.line})"
        + (f"; {listed(whole)}" if whole else "")
        + ": they count twice."
    ]


def listed(items: Sequence[object]) -> str:
    """The first six of some items, and how many follow."""
    more = len(items) - _NAMED
    return ", ".join(map(str, items[:_NAMED])) + (f" and {more} more" if more > 0 else "")


def report(contents: Contents, bad: str) -> None:
    """Warn of bad rows, or raise an AttitudeError for them.

    Parameters
    ----------
    contents : Contents
    bad : "warn", "refuse" or "ignore"
    """
    if not contents.bad or bad == "ignore":
        return
    many = len(contents.bad)
    said = (
        f"{contents.name}: {many} row{'s' if many > 1 else ''} cannot be used: "
        f"{_listed(contents.bad)}"
    )
    if bad == "refuse":
        raise AttitudeError(f'{said}; correct or delete them, or give bad="warn".')
    warnings.warn(f"{said}. Left out.", AttitudeWarning, stacklevel=3)


def _listed(bad: Sequence[BadRow]) -> str:
    more = len(bad) - _NAMED
    return "; ".join(map(str, bad[:_NAMED])) + (f"; and {more} more" if more > 0 else "")


def _numbers(row: RawPoint, word: str, is_flux: bool) -> tuple[str | None, float, float]:
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
        found = _float(row.error)
        if found is None:
            return f"the error is {row.error.strip()[:20]!r}, which is no number", 0.0, 0.0
        if found < 0.0 or found > 1e300:
            return f"the error is {row.error.strip()[:20]}, not above zero", 0.0, 0.0
        error = found if found > 0.0 else np.nan
    return None, value, error


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _julian_fault(text: str, offset: float) -> str | None:
    found = _float(text)
    if found is None:
        return f"the date is {text.strip()[:30]!r}, which is no number"
    if not _JULIAN[0] < found + offset < _JULIAN[1]:
        return f"the date {text.strip()[:30]} is no Julian date"
    return None


def _times(
    rows: Sequence[RawPoint], scale: str | None, offset: float
) -> tuple[Any, list[int], list[BadRow]]:
    """Epochs of rows, the numbers of the rows whose dates can be read, and the others."""
    everything = list(range(len(rows)))
    if not rows:
        return [], [], []
    if scale is not None:
        return julian([each.time for each in rows], scale, offset), everything, []
    dates = [iso(each.time) for each in rows]
    try:
        epochs.past_j2000(dates)
    except AttitudeError:
        good, faults = [], []
        for k, row in enumerate(rows):
            try:
                epochs.past_j2000([dates[k]])
                good.append(k)
            except AttitudeError as err:
                faults.append(
                    BadRow(row.line, str(err).split(";")[0].replace("t is ", "the date "))
                )
        return [dates[k] for k in good], good, faults
    return dates, everything, []


def iso(text: str) -> str:
    """A date as it stands in files, in the spelling of ISO 8601.

    >>> iso("2011/09/13 7:46:00")
    '2011-09-13 07:46:00'
    """
    found = re.fullmatch(
        r"\s*(\d{4})[-/. ](\d{1,2})[-/. ](\d{1,2})(?:[T ]+(\d{1,2})(:.*))?\s*", text
    )
    if found is None:
        return text.strip()
    year, month, day, hour, rest = found.groups()
    date = f"{year}-{int(month):02d}-{int(day):02d}"
    return date if hour is None else f"{date} {int(hour):02d}{rest}"


def julian(days: Sequence[str] | FloatArray, scale: str, offset: float = 0.0) -> Any:
    """Julian dates as a Time: the whole days and the rest are two doubles."""
    from astropy.time import Time

    parts = [str(each).strip().partition(".") for each in days]
    exact = all(re.fullmatch(r"\d+", a) and re.fullmatch(r"\d*", b) for a, _, b in parts)
    if exact:
        whole = np.array([float(a) for a, _, _ in parts])
        rest = np.array([float(f"0.{b or 0}") for _, _, b in parts])
    else:
        given = np.array([float(each) for each in days])
        whole = np.floor(given)
        rest = given - whole
    added = np.floor(offset)
    return Time(whole + added, rest + (offset - added), format="jd", scale=scale)
