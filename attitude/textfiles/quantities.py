"""Numbers with a unit behind them, as people write them in files and on the command line.

>>> numbers_and_unit("14.51, 33.529, -98.709 deg/day", "rate")
(['14.51', '33.529', '-98.709'], 'deg/day')
>>> in_unit("6, 1.5 rpm", "rate", "deg/s").round(12)
array([36.,  9.])
"""

import re

from attitude import validation
from attitude.errors import AttitudeError

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_BETWEEN = r"(?:\s*,\s*|\s+)"
_NUMBERS = re.compile(rf"\s*({_NUMBER}(?:{_BETWEEN}{_NUMBER})*)\s*([^-+.,0-9\s].*)?")
# What people write and astropy does not read.
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


def numbers_and_unit(text, name):
    """The numbers of a text, as they are written, and its unit, "" where there is none.

    Raises
    ------
    AttitudeError
        For a text that is not one or several numbers, with commas or spaces between, and at most
        one unit.
    """
    found = _NUMBERS.fullmatch(text)
    if found is None:
        raise AttitudeError(
            f"{name} is {text!r}; write numbers with one unit behind them, like "
            '"14.51 deg/day" or "14.51, 33.529, -98.709 deg/day".'
        )
    numbers, unit = found.groups()
    return re.split(_BETWEEN, numbers), (unit or "").strip()


def unit_of(text, name):
    """The astropy unit that a text names; also in the plural, and rpm and rev."""
    from astropy import units

    try:
        return units.Unit(_WORD.sub(lambda word: _SPELLINGS[word.group()], text))
    except (ValueError, TypeError) as err:
        # Of astropy's message the guess alone is of use here.
        guess = re.search(r"Did you mean (.*?)\?", str(err))
        raise AttitudeError(
            f"{name} is in {text!r}, which is not a unit that astropy knows"
            + (f" (did you mean {guess.group(1)}?)." if guess else ".")
        ) from err


def in_unit(text, name, unit):
    """The numbers of a text in a unit (None: pure numbers): a scalar array or (N,).

    Numbers without a unit are in that unit already.
    """
    numbers, given = numbers_and_unit(text, name)
    values = [float(number) for number in numbers]
    values = values if len(values) > 1 else values[0]
    if given:
        from astropy.units import Quantity

        values = Quantity(values, unit_of(given, name))
    return validation.real(values, name, unit=unit)
