"""Values in text: how sentences quote and count them, and numbers followed by a unit.

Arguments, files and the command line have one grammar of units: `validation.real` reads it.

>>> numbers_and_unit("14.51, 33.529, -98.709 deg/day", "rate")
(['14.51', '33.529', '-98.709'], 'deg/day')
>>> str(unit_of("rpm", "rate"))
'cycle / min'
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from attitude._support.constants import DAY_S
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from astropy.units import UnitBase


_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_BETWEEN = r"(?:\s*,\s*|\s+)"
_NUMBERS = re.compile(rf"\s*({_NUMBER}(?:{_BETWEEN}{_NUMBER})*)\s*([^-+.,0-9\s].*)?")
# Common spellings that astropy does not read.
_SPELLINGS = {
    "seconds": "s",
    "minutes": "min",
    "hours": "h",
    "days": "day",
    "weeks": "week",
    "years": "yr",
    "degrees": "deg",
    "radians": "rad",
    "rpm": "cycle/min",
    "rev": "cycle",
    "revolutions": "cycle",
}
# Common units with the factors by which astropy converts them, to the bit: reading them does not
# import astropy, which takes 0.1 s.
_TIMES = {"s": 1.0, "min": 60.0, "h": 3600.0, "hour": 3600.0, "d": DAY_S, "day": DAY_S}
_TURNS = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "cycle": 2.0 * math.pi}
_COMMON = {
    "rad": {**_TURNS, "arcmin": math.pi / 10800.0, "arcsec": math.pi / 648000.0},
    "s": {**_TIMES, "ms": 1e-3, "week": 604800.0, "yr": 31557600.0},
    "m": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3},
    "m/s": {"m/s": 1.0, "km/s": 1e3},
    "kg": {"kg": 1.0},
    "kg m2": {"kg m2": 1.0, "kg m^2": 1.0},
    "rad/s": {
        f"{turn}/{time}": size / size_of_time
        for turn, size in _TURNS.items()
        for time, size_of_time in _TIMES.items()
    },
}
_WORD = re.compile("|".join(rf"\b{word}\b" for word in _SPELLINGS))


# ---- How sentences quote input and count things


def quoted(value: object, most: int = 60, mark: str | None = None) -> str:
    """A value as a sentence quotes it: on one line, at most `most` characters.

    In the quotation marks of Python, or in `mark`, which may be empty.

    >>> quoted("SC_BODY_1"), quoted("x" * 50, 12, "")
    ("'SC_BODY_1'", 'xxxxxxxxx...')
    """
    try:
        text = repr(value) if mark is None else f"{mark}{value}{mark}"
    except ValueError:  # an integer of more digits than Python writes
        return f"a very large {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= most else text[: most - 3] + "..."


def counted(number: int, noun: str, plural: str = "") -> str:
    """A number of things: "1 row", "2 rows"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"


# ---- Numbers followed by a unit


def numbers_and_unit(text: str, name: str) -> tuple[list[str], str]:
    """The numbers of a text, as written, and its unit or ""; `name` stands in the error message."""
    match = _NUMBERS.fullmatch(text)
    if match is None:
        raise AttitudeError(
            f"{name} is {quoted(text)}, which is not a number with a unit that astropy knows; "
            'write it like "5.2 h" or "14.51, 33.529, -98.709 deg/day".'
        )
    numbers, unit = match.groups()
    return re.split(_BETWEEN, numbers), (unit or "").strip()


def is_quantity(text: str) -> bool:
    """Whether a text is one or several numbers followed by a word, such as "3 d"."""
    match = _NUMBERS.fullmatch(text)
    unit = match and match.group(2)
    return unit is not None and re.search(r"(?<![A-Za-z*^-])[0-9]", unit) is None


def common_factor(text: str, target: str | None) -> float | None:
    """What converts numbers in a common unit to `target`; None for a unit to be read by `unit_of`.

    >>> common_factor("km", "m"), common_factor("deg", "s")
    (1000.0, None)
    """
    return _COMMON.get(target or "", {}).get(_spelled(text).replace(" / ", "/"))


def _spelled(text: str) -> str:
    return _WORD.sub(lambda word: _SPELLINGS[word.group()], text)


def unit_of(text: str, name: str) -> UnitBase:
    """The astropy unit with a name, plurals, "rpm" and "rev"; `name` stands in the error."""
    from astropy import units

    guess = None
    try:
        unit = units.Unit(_spelled(text))
        if isinstance(unit, units.UnitBase):  # no structure of units, no logarithm of one
            return unit
    except (ValueError, TypeError, ArithmeticError, RecursionError) as err:
        # Only the guess in astropy's message helps here.
        guess = re.search(r"Did you mean (.{1,60}?)\?", str(err))
    raise AttitudeError(
        f"{name} is in {quoted(text)}, which is not a unit that astropy knows"
        + (f" (did you mean {guess.group(1)}?)." if guess else ".")
    ) from None


# ---- Times in the unit that their size asks for

TIME_UNITS: dict[str, float] = {"d": DAY_S, "h": 3600.0, "min": 60.0, "s": 1.0}


def time_unit(longest: float) -> tuple[float, str]:
    """The unit that suits a time or a span of seconds: its length in s, and its name.

    Days from 2 days on, h, min, or s below 2 minutes.

    >>> [time_unit(each)[1] for each in (5.4 * 86400.0, 7200.0, 600.0, 111.0, float("inf"))]
    ['d', 'h', 'min', 's', 'd']
    """
    size = abs(longest)
    suiting = (unit for unit, length in TIME_UNITS.items() if size >= 2.0 * length)
    name = next(suiting, "s")
    return TIME_UNITS[name], name


def of_time(seconds: float, digits: int = 6) -> str:
    """A time with the unit of its size.

    >>> of_time(19123.0), of_time(111.4)
    ('5.31194 h', '111.4 s')
    """
    size, unit = time_unit(seconds)
    return f"{seconds / size:.{digits}g} {unit}"
