"""Names and NAIF numbers of the bodies of the solar system."""

from __future__ import annotations

import operator
from typing import Any

from attitude.errors import AttitudeError

SSB: str = "ssb"

# One name for each number; a planet and the barycentre of its system are two bodies, up to
# 100 km apart for Jupiter.
_NUMBERS = {
    SSB: 0,
    "mercury barycenter": 1,
    "venus barycenter": 2,
    "emb": 3,
    "mars barycenter": 4,
    "jupiter barycenter": 5,
    "saturn barycenter": 6,
    "uranus barycenter": 7,
    "neptune barycenter": 8,
    "pluto barycenter": 9,
    "sun": 10,
    "mercury": 199,
    "venus": 299,
    "earth": 399,
    "moon": 301,
    "mars": 499,
    "jupiter": 599,
    "saturn": 699,
    "uranus": 799,
    "neptune": 899,
    "pluto": 999,
}
_NAMES = {number: name for name, number in _NUMBERS.items()}
_OTHER_NAMES = {
    "solar system barycenter": SSB,
    "earth barycenter": "emb",
    "earth moon barycenter": "emb",
    "earth-moon barycenter": "emb",
    "geocenter": "earth",
    "luna": "moon",
}


def naif_index(value: Any) -> int | None:
    """A whole number of any type as an int; None for a bool and for values of other types."""
    if isinstance(value, bool):
        return None
    try:
        return operator.index(value)
    except TypeError:
        return None


def body_name(body: Any, name: str = "body") -> str:
    """The unique name of a body given by a name or a NAIF number.

    Parameters
    ----------
    body : str or int
        A number without a name here (an asteroid, a spacecraft) gives its digits.
    name : str
        Name of the parameter in the error message.

    Raises
    ------
    AttitudeError
        For a name that is not known.

    >>> body_name("Earth Barycenter"), body_name(10), body_name("2099942")
    ('emb', 'sun', '2099942')
    """
    if isinstance(body, str):
        given = " ".join(body.lower().replace("_", " ").replace("barycentre", "barycenter").split())
        given = _OTHER_NAMES.get(given, given)
        if given in _NUMBERS:
            return given
        if given.lstrip("-").isdigit():
            return _NAMES.get(int(given), str(int(given)))
    elif (number := naif_index(body)) is not None:
        return _NAMES.get(number, str(number))
    raise AttitudeError(
        f"{name} is {body!r}, which is not the name of a body; give a NAIF number, or one of "
        f"{', '.join(_NUMBERS)}."
    )


def naif_number(body: Any, name: str = "body") -> int:
    """The NAIF number of a body given by a name or a number; see `body_name`."""
    known = body_name(body, name)
    return _NUMBERS[known] if known in _NUMBERS else int(known)
