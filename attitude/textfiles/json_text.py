"""JSON text of plain values and arrays; numbers that are not finite become null."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np


def written(value: Any, *, indent: int | None = None) -> str:
    """The JSON of dicts, lists, text, numbers and arrays.

    Parameters
    ----------
    value : dict, list, str, number, bool, None or array
    indent : int, optional
        Spaces of each level; by default the text is one line without spaces.
    """
    separators = (",", ":") if indent is None else None
    return json.dumps(
        _plain(value), allow_nan=False, ensure_ascii=False, indent=indent, separators=separators
    )


def within_script(value: Any) -> str:
    """The JSON of a value for a script element of HTML, which no text in it ends or extends.

    The HTML standard ("Restrictions for contents of script elements") lets `</script`, `<!--` and
    `<script` change where the element ends, so that every `<` is escaped; the separators of lines
    U+2028 and U+2029 end lines of JavaScript before ES2019.
    """
    text = written(value)
    for each in ("<", "\u2028", "\u2029"):  # in JSON these stand within strings only
        text = text.replace(each, f"\\u{ord(each):04x}")
    return text


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
