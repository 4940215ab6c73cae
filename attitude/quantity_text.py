"""Numbers followed by a unit, as text: one grammar for arguments, files and the command line.

`validation.real` reads every text with it.

>>> numbers_and_unit("14.51, 33.529, -98.709 deg/day", "rate")
(['14.51', '33.529', '-98.709'], 'deg/day')
>>> str(unit_of("rpm", "rate"))
'cycle / min'
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

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
_WORD = re.compile("|".join(rf"\b{word}\b" for word in _SPELLINGS))


def numbers_and_unit(text: str, name: str) -> tuple[list[str], str]:
    """The numbers of a text, as they are written, and its unit, "" if it has none.

    `name` is the name of the value in the error message.

    Raises
    ------
    AttitudeError
        If the text is not one or several numbers, separated by commas or spaces, followed by at
        most one unit.
    """
    found = _NUMBERS.fullmatch(text)
    if found is None:
        raise AttitudeError(
            f"{name} is {_cut(repr(text))}, which is not a number with a unit that astropy knows; "
            'write it like "14.5 deg/day" or "14.51, 33.529, -98.709 deg/day".'
        )
    numbers, unit = found.groups()
    return re.split(_BETWEEN, numbers), (unit or "").strip()


def is_quantity(text: str) -> bool:
    """Whether a text is one or several numbers followed by a word, such as "3 d"."""
    found = _NUMBERS.fullmatch(text)
    unit = found and found.group(2)
    return unit is not None and re.search(r"(?<![A-Za-z*^-])[0-9]", unit) is None


def _cut(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."


def unit_of(text: str, name: str) -> UnitBase:
    """The astropy unit with a name; plurals, "rpm" and "rev" are known too.

    `name` is the name of the value in the error message.

    Raises
    ------
    AttitudeError
        If astropy does not know the unit.
    """
    from astropy import units

    try:
        return units.Unit(_WORD.sub(lambda word: _SPELLINGS[word.group()], text))
    except (ValueError, TypeError) as err:
        # Only the guess in astropy's message helps here.
        guess = re.search(r"Did you mean (.*?)\?", str(err))
        raise AttitudeError(
            f"{name} is in {text!r}, which is not a unit that astropy knows"
            + (f" (did you mean {guess.group(1)}?)." if guess else ".")
        ) from None
