"""JSON values, and rows of CSV as records of named fields."""

from __future__ import annotations

import csv
import io
import json
import re
from typing import Any

from attitude.errors import AttitudeError

_GUARD = re.compile(r"^'(?=[=+@-])")


def of_json(text: str, name: str) -> Any:
    """The value in a JSON text; `name` is the name of the file in error messages.

    Raises
    ------
    AttitudeError
        If the text is not JSON, or its numbers or its nesting exceed Python's limits.
    """
    try:
        return json.loads(text)
    except json.JSONDecodeError as err:
        raise AttitudeError(
            f"{name}, line {err.lineno}: it is not valid JSON ({err.msg}, column {err.colno})."
        ) from err
    except (ValueError, RecursionError) as err:  # numbers of thousands of digits; deep nesting
        raise AttitudeError(f"{name}: it is JSON that cannot be read ({err}).") from err


def of_csv(text: str, name: str) -> list[dict[str, Any]]:
    """The rows of a CSV text, each as a dict whose keys are the entries of the first line.

    `name` is the name of the file in error messages.

    Raises
    ------
    AttitudeError
        If the text is not CSV.
    """
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

    Raises
    ------
    AttitudeError
        If a quoted entry does not end.
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
    found = []
    for number, line in kept:
        try:
            entries = next(csv.reader([line], delimiter=mark))
        except (csv.Error, StopIteration) as err:
            raise AttitudeError(f"{name}, line {number}: it is not valid CSV ({err}).") from err
        found.append((number, [_GUARD.sub("", each.strip()) for each in entries]))
    return found
