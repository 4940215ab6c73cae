"""TOML files, JSON values and rows of CSV; errors for broken syntax, unknown keys, wrong values."""

from __future__ import annotations

import csv
import difflib
import io
import json
import math
import re
import tomllib
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import quantity_text
from attitude._textfiles.lines import cut, whole
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    import os
    from collections.abc import Collection, Iterable, Mapping, Sequence


def read(path: str | os.PathLike[str], kind: str) -> str:
    """The text of a file; `kind` is its kind in the error message, such as "spin file".

    AttitudeError if the file cannot be read or is not UTF-8.
    """
    return whole(path, f"give the name of a {kind}")


def parsed(text: str, origin: str) -> dict[str, Any]:
    """The content of a TOML text as dicts and lists; `origin`, as the file's name, is in errors."""
    if not isinstance(text, str):
        raise AttitudeError(f"{origin}: text is {cut(text)}; give the content of a TOML file.")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        raise AttitudeError(_syntax_error(str(err), text, origin)) from err
    except (ValueError, RecursionError) as err:
        raise AttitudeError(
            f"{origin}: is TOML that cannot be read: a number has more digits than Python reads, "
            "or lists are nested too deeply; write numbers as 1.5e9."
        ) from err


def refuse_unknown(section: Iterable[str], known: Collection[str], where: str) -> None:
    """AttitudeError for the first unknown key of a section `where`, with the nearest known key."""
    for key in section:
        if key not in known:
            similar = difflib.get_close_matches(key.lower(), known, n=1)
            raise AttitudeError(
                f"{where} has a key {cut(key)} that is not known; "
                + (
                    f"did you mean {similar[0]!r}?"
                    if similar
                    else f"allowed are {listed(sorted(set(known)))}."
                )
            )


def way_of(section: Mapping[str, Any], ways: Iterable[str], where: str) -> str:
    """The one key, out of several alternatives, that the section `where` has."""
    taken = [way for way in ways if way in section]
    if len(taken) != 1:
        raise AttitudeError(
            f"{where} has {' and '.join(taken) or 'none'} of {', '.join(ways)}; give one of them."
        )
    return taken[0]


def section_of(value: Any, name: str) -> dict[str, Any]:
    """A section itself; AttitudeError for another value under its name."""
    if not isinstance(value, dict):
        shown = quantity_text.quoted(value)
        raise AttitudeError(f"{name} is {shown}; give a section that begins [{name}].")
    return value


def text_of(content: Mapping[str, Any], key: str) -> str | None:
    """The text of a key, or None without the key; AttitudeError if the value is not text."""
    value = content.get(key)
    if value is not None and not isinstance(value, str):
        raise AttitudeError(f"{key} is {cut(value)}; give text in quotes.")
    return value


def quoted(value: object, key: str) -> str:
    """A text in quotes, as the value of a key; AttitudeError if the value is not text."""
    if not isinstance(value, str):
        raise AttitudeError(f"{key} is {cut(value)}; give text.")
    # JSON escapes as TOML does, except for the delete character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def listed(words: Sequence[str]) -> str:
    """Words as alternatives: "a, b or c"; "none" without words."""
    if len(words) < 2:
        return words[0] if words else "none"
    return ", ".join(words[:-1]) + " or " + words[-1]


def _syntax_error(message, text, origin):
    match = re.fullmatch(r"(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    if match is None:
        return f"{origin}: is not valid TOML: {message}."
    what, line, column = match.groups()
    line = line or text.rstrip().count("\n") + 1
    where = f"line {line}" + (f", column {column}" if column else " (the end)")
    return f"{origin}, {where}: is not valid TOML: {what[:1].lower() + what[1:]}."


# ---- JSON text of plain values and arrays; numbers that are not finite become null


def written(value: Any, *, indent: int | None = None) -> str:
    """The JSON of dicts, lists, text, numbers and arrays."""
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
    for mark in ("<", "\u2028", "\u2029"):  # in JSON these stand within strings only
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return text


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


# ---- JSON values, and rows of CSV as records of named fields

_GUARD = re.compile(r"^'(?=[=+@-])")


def of_json(text: str, name: str) -> Any:
    """The value in a JSON text; `name` is the name of the file in error messages."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as err:
        raise AttitudeError(
            f"{name}, line {err.lineno}: it is not valid JSON ({err.msg}, column {err.colno})."
        ) from err
    except (ValueError, RecursionError) as err:  # numbers of thousands of digits; deep nesting
        raise AttitudeError(f"{name}: it is JSON that cannot be read ({err}).") from err


def of_csv(text: str, name: str) -> list[dict[str, Any]]:
    """The rows of a CSV text as dicts by the entries of its first line; `name` is in errors."""
    rows = csv.DictReader(io.StringIO(text))
    try:
        return list(rows)
    except csv.Error as err:
        raise AttitudeError(
            f"{name}, line {rows.reader.line_num}: it is not valid CSV ({err})."
        ) from err


def of_separated(text: str, name: str) -> list[tuple[int, list[str]]]:
    """The rows of a table in text, each with the number of its line; remarks (#) are left out.

    An apostrophe before =, +, - or @, which keeps spreadsheets from running the entry, is left out.
    Entries are separated by the character out of comma, semicolon, tab and bar that the first row
    has most often, or by blanks if it has none.  `name` is the name of the file in error messages.
    """
    kept = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not kept:
        return []
    mark = max(",;\t|", key=kept[0][1].count)
    if mark not in kept[0][1]:
        return [(number, line.split()) for number, line in kept]
    rows = []
    for number, line in kept:
        try:
            entries = next(csv.reader([line], delimiter=mark))
        except (csv.Error, StopIteration) as err:
            raise AttitudeError(f"{name}, line {number}: it is not valid CSV ({err}).") from err
        rows.append((number, [_GUARD.sub("", entry.strip()) for entry in entries]))
    return rows
