"""Photometry in exchange formats: ALCDEF, ADES (PSV and XML), MPC 80 columns, DAMIT.

Sources: ALCDEF standard 2.2 (minorplanetcenter.net/light_curve2); ADES, IAU standard of 2022
(github.com/IAU-ADES/ADES-Master); MPC, "Format for optical astrometric observations"; DAMIT as
`attitude.formats.damit.light_curve`.
"""

from __future__ import annotations

import re
from decimal import Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.errors import AttitudeError
from attitude.formats.damit.light_curve import read_damit_light_curves
from attitude.photometry import contents
from attitude.photometry.contents import BadRow, Contents, RawPoint
from attitude.physical_constants import ASTRONOMICAL_UNIT_M
from attitude.textfiles import xml

if TYPE_CHECKING:
    from attitude.annotations import FilePath

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

    Raises
    ------
    AttitudeError
        If blocks differ in light time (LTCAPP) or distances (REDUCEDMAGS), and as `contents`.
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
    found = contents.of_rows(rows, name, scale="utc", bad=bad)
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
            f"EXPJD of block {contents.listed(unmoved)} is not the middle, but EXPOSURE is not "
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
    return contents.of_rows(rows, name, bad=bad)


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
    return contents.of_rows(rows, name, scale="utc", bad=bad)


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
