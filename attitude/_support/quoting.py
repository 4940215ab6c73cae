"""How sentences quote input and count things."""

from __future__ import annotations


def quoted(value: object, most: int = 60, mark: str | None = None) -> str:
    """A value as a sentence quotes it: on one line, at most `most` characters.

    In the quotation marks of Python, or in `mark`, which may be empty.

    >>> quoted("SC_BODY_1"), quoted("x" * 50, 12, "")
    ("'SC_BODY_1'", 'xxxxxxxxx...')
    """
    try:
        text = repr(value) if mark is None else f"{mark}{value}{mark}"
    except ValueError:  # an integer of more digits than Python writes
        return f"a very large {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= most else text[: most - 3] + "..."


def counted(number: int, noun: str, plural: str = "") -> str:
    """A number of things: "1 row", "2 rows"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"
