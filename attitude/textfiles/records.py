"""JSON values, and records of named fields from CSV."""

import csv
import io
import json

from attitude.errors import AttitudeError


def of_json(text, name):
    """The value that a JSON text holds; `name` stands for the file in the messages."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as err:
        raise AttitudeError(
            f"{name}, line {err.lineno}: it is not valid JSON ({err.msg}, column {err.colno})."
        ) from err
    except (ValueError, RecursionError) as err:  # numbers of thousands of digits; deep nesting
        raise AttitudeError(f"{name}: it is JSON that cannot be read ({err}).") from err


def of_csv(text, name):
    """The rows of a CSV text, each as a dict by the names in the first line."""
    rows = csv.DictReader(io.StringIO(text))
    try:
        return list(rows)
    except csv.Error as err:
        raise AttitudeError(
            f"{name}, line {rows.reader.line_num}: it is not valid CSV ({err})."
        ) from err
