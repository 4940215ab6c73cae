"""The head of an STK attitude file: version, keywords, axes, interpolation, times."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude.attitude_table import interpolation
from attitude.axes import axes, axis_names
from attitude.errors import AttitudeError
from attitude.formats.stk import dates
from attitude.formats.stk.sections import REFUSED, SECTIONS, USUAL, Decoder
from attitude.textfiles.lines import is_number

if TYPE_CHECKING:
    from attitude.axes.axes import Axes
    from attitude.formats.stk.sections import Section
    from attitude.textfiles.lines import Lines

_KEYWORDS = (
    *("MessageLevel", "NumberOfAttitudePoints", "BlockingFactor", "InterpolationOrder"),
    *("InterpolationMethod", "CentralBody", "ScenarioEpoch", "TimeFormat", "CoordinateAxes"),
    *("CoordinateAxesEpoch", "Sequence", "AttitudeDeviations", "InitialQuaternion"),
    *("InitialEulerAngle", "InitialYPRAngle"),
)
_BY_LOWER = {name.lower(): name for name in (*SECTIONS, *REFUSED)}
_KEYWORD_BY_LOWER = {name.lower(): name for name in _KEYWORDS}
# Names of STK for axes that other files name otherwise.
_AXES = {"fixed": "ITRF", "vvlh": "LVLH", "inertial": "ICRF"}
# Bodies whose axes "Inertial" of STK are those of the ICRF.
_ICRF_BODIES = ("earth", "sun", "")


def named(given: str) -> Axes:
    """The Axes of a name of STK; AttitudeError for another name."""
    return axes.named(_AXES.get(given.lower(), given))


class Header:
    """The keywords of a file up to the name of its section.

    Parameters
    ----------
    lines : Lines
        At the beginning of the file; they are read up to the first record.

    Attributes
    ----------
    keywords : dict of str
    section : Section
    count : int or None
        NumberOfAttitudePoints.
    method, degree : str, int
        Interpolation, as of AttitudeTable.
    time_format : str
        TimeFormat in lower case.

    Raises
    ------
    AttitudeError
        For a file that is no STK attitude file, and keywords or values that are not known.
    """

    def __init__(self, lines: Lines):
        self._lines = lines
        self.keywords: dict[str, str] = {}
        self._where: dict[str, int] = {}
        _read_banner(lines)
        self.section: Section = SECTIONS[self._read_keywords()]
        self.count: int | None = self._whole("NumberOfAttitudePoints", None)
        self.method: str
        self.degree: int
        self.method, self.degree = self._interpolation()
        given = self.keywords.get("TimeFormat", "EpSec").strip("\"'")
        self.time_format: str = given.lower()
        if self.time_format not in (*dates.UNITS, *dates.DATES):
            raise self.fault(
                "TimeFormat", f"TimeFormat is {given[:40]!r}; known are {dates.FORMATS}."
            )
        # Checked before the records are read.
        self.decoder: Decoder = self._decoder()

    def fault(self, keyword: str, sentence: str) -> AttitudeError:
        """The error for the value of a keyword."""
        return self._lines.fault(sentence, self._where.get(keyword))

    def start(self) -> tuple[float, float]:
        """ScenarioEpoch: TAI seconds since J2000 in two doubles."""
        try:
            found = dates.instant(self.keywords.get("ScenarioEpoch", ""), "ScenarioEpoch")
        except AttitudeError as err:
            raise self.fault("ScenarioEpoch", str(err)) from err
        hi, lo = dates.tai_of(found)
        return float(hi), float(lo)

    def axes(self, frame: str | None) -> Axes:
        """The reference axes; `frame` replaces CoordinateAxes."""
        try:
            if self.section.axes is not None:
                return axes.named(self.section.axes)
            if frame is not None:
                return axes.named(frame)
            if "CoordinateAxes" not in self.keywords:
                raise AttitudeError(
                    "the file has no CoordinateAxes, which names the axes that the attitudes are "
                    "relative to; add it to the file, or give frame=, such as frame='ICRF'."
                )
            return self._axes(self.keywords["CoordinateAxes"])
        except AttitudeError as err:
            raise self.fault("CoordinateAxes", str(err)) from err

    def _axes(self, given):
        words = given.split()
        custom = len(words) > 1 and words[0].lower() in ("custom", "awb")
        lower = (words[1] if custom else given).lower()
        if custom and lower != "vvlh":
            raise AttitudeError(
                f"CoordinateAxes is {given[:40]!r}, axes that a scenario of STK defines; give "
                "what they are with frame=."
            )
        if lower == "lvlh":
            raise AttitudeError(
                "CoordinateAxes is LVLH, in which STK's x points away from the center, as that of "
                'RTN, and that of CCSDS along the orbit; give frame="RTN" or frame="LVLH".'
            )
        if lower == "inertial":
            body = self.keywords.get("CentralBody", "").lower()
            if body not in _ICRF_BODIES:
                raise AttitudeError(
                    f"CoordinateAxes is Inertial of {body[:40]!r}; these axes are known for the "
                    "Earth and the Sun only: give what they are with frame=."
                )
        kind = axis_names.OF_EPOCH.get(axis_names.normal(lower))
        if kind is not None:
            epoch = dates.instant(
                self.keywords.get("CoordinateAxesEpoch", ""), "CoordinateAxesEpoch"
            )
            return axes.Axes(given, kind, at=epoch)
        return axes.named(_AXES.get(lower, lower if custom else given), "CoordinateAxes")

    def _read_keywords(self):
        """The name of the section; sets `keywords`."""
        lines = self._lines
        for line in lines:
            text = lines.text(line).strip()
            if not text or text.startswith("#"):
                continue
            keyword, value = (*text.split(None, 1), "")[:2]
            found = _BY_LOWER.get(keyword.lower())
            if found in REFUSED:
                raise lines.fault(f"the section {found} is not read: {REFUSED[found]}.")
            if found is not None and not value:
                return found
            name = _KEYWORD_BY_LOWER.get(keyword.lower())
            if name is None:
                raise lines.fault(
                    f"{keyword[:40]!r} is not known; known are {', '.join(_KEYWORDS)} and "
                    "sections such as AttitudeTimeQuaternions."
                )
            if name in self.keywords:
                raise lines.fault(f"{name} is given twice.")
            self.keywords[name], self._where[name] = value.strip(), lines.number
        raise lines.fault("the file ends before its data; is it cut off?")

    def _whole(self, keyword, default):
        text = self.keywords.get(keyword)
        if text is None:
            return default
        # MATLAB's %f, with which many write these files, writes 3.000000.
        if not re.fullmatch(r"\d{1,12}(\.0*)?", text, re.ASCII):
            raise self.fault(keyword, f"{keyword} is {text[:40]!r}; give a whole number.")
        return int(text.partition(".")[0])

    def _interpolation(self):
        degree, most = self._whole("InterpolationOrder", 1), interpolation.MOST_DEGREE
        if degree > most:
            raise self.fault(
                "InterpolationOrder",
                f"InterpolationOrder is {degree}; it must be 0 to {most}.",
            )
        given = self.keywords.get("InterpolationMethod", "Lagrange")
        if given.lower() not in ("lagrange", "hermite"):
            raise self.fault(
                "InterpolationMethod",
                f"InterpolationMethod is {given[:40]!r}; give Lagrange or Hermite.",
            )
        if given.lower() == "hermite" and degree > 1:
            return "hermite", degree
        return ("slerp", 1) if degree < 2 else ("lagrange", degree)

    def _decoder(self):
        """The Decoder of the section, from Sequence and the angles at the first record."""
        section, keyword = self.section, "Sequence"
        form = section.form.partition(" ")[0]
        if form not in USUAL:
            return Decoder(section, None)
        given, initial = self.keywords.get("Sequence", USUAL[form]), None
        try:
            if section.initial is not None:
                keyword = section.initial
                words = self.keywords.get(keyword, "").split()
                if len(words) != 4 or not all(map(is_number, (w.encode() for w in words[1:]))):
                    raise AttitudeError(
                        f"it is {' '.join(words)[:40]!r}; the section has rates alone and needs a "
                        "sequence and three angles in deg."
                    )
                given, initial = words[0], [float(word) for word in words[1:]]
                if not np.all(np.isfinite(initial)):
                    raise AttitudeError("an angle is not finite.")
            if form == "ypr":
                given = given.upper().translate(str.maketrans("RPY", "XYZ"))
            return Decoder(section, quaternion.known_sequence(given), initial)
        except AttitudeError as err:
            raise self.fault(keyword, f"{keyword}: {err}") from err


def _read_banner(lines):
    found = None
    for line in lines:
        text = lines.text(line).strip()
        if not text or text.startswith("#"):
            continue
        if found is None:
            found = re.fullmatch(r"stk\.v\.\d+\.\d+(\.\d+)?", text, re.ASCII | re.IGNORECASE)
            if found is None:
                raise lines.fault(f"it begins with {text[:40]!r}; an STK file begins with stk.v.")
        elif re.fullmatch(r"BEGIN\s+Attitude", text, re.IGNORECASE):
            return
        else:
            raise lines.fault(f"{text[:40]!r} stands where BEGIN Attitude must be.")
    raise lines.fault("the file ends before BEGIN Attitude; is it an STK attitude file?")
