"""Orbit lines of the Minor Planet Center: MPCORB.DAT for minor planets, CometEls.txt for comets.

Elements are heliocentric, on the ecliptic of J2000, at TT epochs.  Sources: the MPC's pages
MPOrbitFormat and CometOrbitFormat.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from attitude._support.constants import ASTRONOMICAL_UNIT_M, DAY_S
from attitude.epochs._inputs import instant
from attitude.errors import AttitudeError
from attitude.paths._two_body import GM, kepler

if TYPE_CHECKING:
    from attitude._support.annotations import Real
    from attitude.paths._two_body import Kepler


# Columns of the two kinds of lines, counted from 0.
_MINOR_PLANET = {
    "mean anomaly": (26, 35),
    "argument of perihelion": (37, 46),
    "longitude of the node": (48, 57),
    "inclination": (59, 68),
    "eccentricity": (70, 79),
    "semi-major axis": (92, 103),
}
_COMET = {
    "year of perihelion": (14, 18),
    "month of perihelion": (19, 21),
    "day of perihelion": (22, 29),
    "perihelion distance": (30, 39),
    "eccentricity": (41, 49),
    "argument of perihelion": (51, 59),
    "longitude of the node": (61, 69),
    "inclination": (71, 79),
}
_PACKED_DATE = re.compile(r"[I-L]\d\d[1-9A-C][1-9A-V]")


def mpc_orbit(line: str, *, gm: Real = GM["sun"]) -> Kepler:
    """The heliocentric two-body path of an orbit line of the Minor Planet Center.

    Parameters
    ----------
    line : str
        One line of MPCORB.DAT (with a packed epoch such as K25BL in columns 21-25), or one of
        CometEls.txt.
    gm : float or Quantity
        GM of the Sun, m3/s2.

    Raises
    ------
    AttitudeError
        For a line of neither file, or with a column that cannot be read; the message has its name.

    Notes
    -----
    The period follows from the semi-major axis, as in skyfield; the mean motion is printed with
    fewer digits.
    """
    if not isinstance(line, str):
        raise AttitudeError(f"the orbit line is {line!r}; give one line of text.")
    line = line.rstrip("\r\n")
    if _PACKED_DATE.fullmatch(line[20:25]):
        return _minor_planet(line, gm)
    if len(line) >= 79 and line[14:18].strip().lstrip("-").isdigit():
        return _comet(line, gm)
    raise AttitudeError(
        f"the orbit line {line[:60]!r} is neither of MPCORB.DAT (a packed epoch such as K25BL in "
        "columns 21-25) nor of CometEls.txt (the year of perihelion in columns 15-18); give a "
        "whole line, with its spaces."
    )


def is_line(text: str) -> bool:
    """Whether a text begins as a line of MPCORB.DAT or is one of CometEls.txt."""
    text = text.rstrip("\r\n")
    if "\n" in text or len(text) < 79:
        return False
    is_comet = re.fullmatch(r"\s*-?\d+ \d\d [ \d]\d\.\d+\s*", text[14:29])
    return bool(_PACKED_DATE.fullmatch(text[20:25]) or is_comet)


def names(line: str) -> set[str]:
    """Number, name, designation of the body of a line, in lower case."""
    label, packed = _labels(line)
    numbered = re.match(r"\((\d+)\)\s*(.*)", label)
    words = {label, packed, packed.lstrip("0")}
    if numbered:
        words |= {*numbered.groups(), f"{numbered[1]} {numbered[2]}"}
    return {word.lower() for word in words} - {""}


def _labels(line):
    """The number and name of the body of a line as it prints them, and the packed designation."""
    if _PACKED_DATE.fullmatch(line[20:25]):
        return line[166:194].strip(), line[:7].strip()
    return line[102:158].strip(), line[:12].strip()


def _minor_planet(line, gm):
    """The path of a line of MPCORB.DAT."""
    value = _numbers(line, _MINOR_PLANET)
    packed = line[20:25]
    # The letters of a packed date are digits from 10 on.
    century, month, day = (int(packed[k], 36) for k in (0, 3, 4))
    return kepler(
        semi_major_axis=value["semi-major axis"] * ASTRONOMICAL_UNIT_M,
        mean_anomaly=f"{value['mean anomaly']!r} deg",
        epoch=f"{100 * century + int(packed[1:3]):04d}-{month:02d}-{day:02d} TT",
        source="MPC orbit line",
        **_shared(value, gm, line),
    )


def _comet(line, gm):
    """The path of a line of CometEls.txt."""
    value = _numbers(line, _COMET)
    day = value["day of perihelion"]
    midnight = f"{int(value['year of perihelion']):04d}-{int(value['month of perihelion']):02d}"
    start = instant(f"{midnight}-{int(day):02d} TT", "the time of perihelion")
    return kepler(
        pericenter_distance=value["perihelion distance"] * ASTRONOMICAL_UNIT_M,
        # A second of TT equals one of TDB to 3e-10, and the day is printed to 9 s.
        epoch=start.after((day - int(day)) * DAY_S),
        source="MPC comet orbit line",
        **_shared(value, gm, line),
    )


def _shared(value, gm, line):
    """Arguments of `kepler` that both kinds of lines have."""
    label, packed = _labels(line)
    return {
        "eccentricity": value["eccentricity"],
        "inclination": f"{value['inclination']!r} deg",
        "node": f"{value['longitude of the node']!r} deg",
        "pericenter_argument": f"{value['argument of perihelion']!r} deg",
        "gm": gm,
        "name": label or packed,
        "center": "sun",
        "frame": "ecliptic",
    }


def _numbers(line, columns):
    """The numbers in the columns of a line, by their names."""
    numbers = {}
    for name, (first, last) in columns.items():
        text = line[first:last].strip()
        try:
            numbers[name] = float(text)
        except ValueError as err:
            raise AttitudeError(
                f"the orbit line {line[:40]!r}... has {text!r} for the {name} in columns "
                f"{first + 1}-{last}; it must be a number."
            ) from err
    return numbers
