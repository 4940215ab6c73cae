"""Numbers followed by a unit, as text in files and on the command line.

>>> numbers_and_unit("14.51, 33.529, -98.709 deg/day", "rate")
(['14.51', '33.529', '-98.709'], 'deg/day')
>>> in_unit("6, 1.5 rpm", "rate", "deg/s").round(12)
array([36.,  9.])
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from attitude import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    import numpy as np
    from astropy.units import UnitBase
    from numpy.typing import NDArray

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
            f"{name} is {text!r}; write numbers followed by one unit, like "
            '"14.51 deg/day" or "14.51, 33.529, -98.709 deg/day".'
        )
    numbers, unit = found.groups()
    return re.split(_BETWEEN, numbers), (unit or "").strip()


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
        ) from err


def in_unit(text: str, name: str, unit: str | None) -> NDArray[np.float64]:
    """The numbers of a text in a unit: an array () or (N,).

    Parameters
    ----------
    text : str
        Numbers without a unit are in `unit`.
    name : str
        Name of the value in the error message.
    unit : str or None
        None for pure numbers.

    Raises
    ------
    AttitudeError
        If the text cannot be read, or its unit does not convert to `unit`.
    """
    numbers, given = numbers_and_unit(text, name)
    values: Any = [float(number) for number in numbers]
    values = values if len(values) > 1 else values[0]
    if given:
        from astropy.units import Quantity

        values = Quantity(values, unit_of(given, name))
    return validation.real(values, name, unit=unit)
