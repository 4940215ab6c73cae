"""Which body a name means: the whole name, its number, or the beginning of a word of it.

A number means a body only as its whole number, and a year none: "41" is not 4179 Toutatis, and
"2008" not 2008 TC3, so that no body gets the numbers of another.

>>> matching("touta", {"4179 Toutatis": 1, "2008 TC3": 2})
[1]
>>> matching("41", {"4179 Toutatis": 1, "2008 TC3": 2})
[]
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Mapping

Item = TypeVar("Item")

# Letters of the beginning of a word by which a body is found.
_BEGUN = 3


def matching(name: str, items: Mapping[str, Item]) -> list[Item]:
    """The items that a name means.

    Parameters
    ----------
    name : str
        In any case, with or without brackets and apostrophes.
    items : dict
        By names of bodies, with a year in brackets where a body has several items.
    """
    key = _words(name)
    exact = [item for each, item in items.items() if _words(each) == key]
    if exact or not key:
        return exact
    return [item for each, item in items.items() if _means(key, _words(each.partition(" (")[0]))]


def _means(key: list[str], words: list[str]) -> bool:
    """Whether words occur in a name, in order, the last of them at least begun."""
    is_designation = len(words) > 1 and re.fullmatch(r"\d{4}", words[0]) and len(words[1]) < 6
    if is_designation and re.fullmatch(r"[a-z]{2}\d*", words[1]) and key == words[:1]:
        return False
    for start in range(len(words) - len(key) + 1):
        part = words[start : start + len(key)]
        begun = len(key[-1]) >= _BEGUN and key[-1].isalpha() and part[-1].startswith(key[-1])
        if part[:-1] == key[:-1] and (part[-1] == key[-1] or begun):
            return True
    return False


def _words(name: str) -> list[str]:
    """The words of a name in lower case, without brackets, apostrophes and slashes."""
    return re.sub(r"[()'/\u2018\u2019]", " ", name.lower()).split()
