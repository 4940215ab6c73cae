"""TOML files: reading, and errors for broken syntax, unknown keys and wrong values."""

from __future__ import annotations

import difflib
import json
import re
import tomllib
from typing import TYPE_CHECKING, Any

from attitude.errors import AttitudeError
from attitude.textfiles.lines import cut, whole

if TYPE_CHECKING:
    import os
    from collections.abc import Collection, Iterable, Mapping, Sequence


def read(path: str | os.PathLike[str], kind: str) -> str:
    """The text of a file; `kind` is its kind in the error message, such as "spin file".

    Raises
    ------
    AttitudeError
        If the file cannot be read or is not UTF-8.
    """
    return whole(path, f"give the name of a {kind}")


def parsed(text: str, origin: str) -> dict[str, Any]:
    """The content of a TOML text as dicts and lists.

    `origin`, such as the name of the file, begins the error message.

    Raises
    ------
    AttitudeError
        With line and column, if the text is not TOML.
    """
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
    """AttitudeError for the first key of a section that is not known, with the nearest known key.

    `where` is the name of the section in the error message.
    """
    for key in section:
        if key not in known:
            near = difflib.get_close_matches(key.lower(), known, n=1)
            raise AttitudeError(
                f"{where} has a key {cut(key)} that is not known; "
                + (
                    f"did you mean {near[0]!r}?"
                    if near
                    else f"allowed are {listed(sorted(set(known)))}."
                )
            )


def way_of(section: Mapping[str, Any], ways: Iterable[str], where: str) -> str:
    """The one key, out of several alternatives, that a section has.

    `where` is the name of the section in the error message.

    Raises
    ------
    AttitudeError
        If the section has none of the alternatives, or more than one.
    """
    taken = [way for way in ways if way in section]
    if len(taken) != 1:
        raise AttitudeError(
            f"{where} has {' and '.join(taken) or 'none'} of {', '.join(ways)}; give one of them."
        )
    return taken[0]


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
    found = re.fullmatch(r"(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    if found is None:
        return f"{origin}: is not valid TOML: {message}."
    what, line, column = found.groups()
    line = line or text.rstrip().count("\n") + 1
    where = f"line {line}" + (f", column {column}" if column else " (the end)")
    return f"{origin}, {where}: is not valid TOML: {what[:1].lower() + what[1:]}."
