"""Text files line by line, with a sentence that names file and line for whatever is wrong."""

import os
from contextlib import contextmanager

import numpy as np

from attitude.errors import AttitudeError

# Longer lines are no attitude data but a binary or a broken file, bytes.
LONGEST = 20_000


class Lines:
    """The lines of an open file as bytes, without their ends; `number` is that of the last one."""

    def __init__(self, file, path):
        self._file = file
        self.path = os.fspath(path)
        self.number = 0

    def __iter__(self):
        return self

    def __next__(self):
        line = self._file.readline(LONGEST + 1)
        if not line:
            raise StopIteration
        self.number += 1
        if len(line) > LONGEST:
            raise self.fault(f"the line is longer than {LONGEST} characters; is it a text file?")
        return line.rstrip(b"\r\n")

    def fault(self, sentence, line=None):
        """An AttitudeError that begins with the name of the file and the number of the line."""
        return AttitudeError(f"{self.path}, line {line or self.number or 1}: {sentence}")

    def text(self, line):
        """A line of keywords as text."""
        try:
            text = line.decode("utf-8")
        except UnicodeDecodeError as err:
            raise self.fault("it is not UTF-8 text; is it a text file?") from err
        if "\x00" in text:
            raise self.fault("it holds zero bytes; is it a text file?")
        return text.removeprefix("\ufeff")


@contextmanager
def opened(path):
    """The `Lines` of a file.

    Raises
    ------
    AttitudeError
        Where it cannot be read.
    """
    try:
        with open(path, "rb") as file:
            yield Lines(file, path)
    except OSError as err:
        raise unreadable(path, err) from err


def unreadable(path, err):
    return AttitudeError(f"{os.fspath(path)!r} cannot be read: {err.strerror or err}.")


def numbers(tokens, step, places):
    """Columns of numbers (N, columns) out of the entries of some lines, one after the other.

    Parameters
    ----------
    tokens : list of bytes
        `step` for each line.
    places : sequence of int
        Which of them are the columns.

    Raises
    ------
    NoNumber
        With the line, counted from 0, and the place among `places` of the first that is none.
    """
    try:
        if b"_" in b"".join(tokens):  # which Python takes for a separator of digits
            raise ValueError("underscore")
        return np.array([list(map(float, tokens[place::step])) for place in places]).T
    except ValueError:
        for line in range(len(tokens) // step):
            for column, place in enumerate(places):
                if not is_number(tokens[line * step + place]):
                    raise NoNumber(line, column, tokens[line * step + place]) from None
    # An underscore elsewhere in the line is not our business.
    return np.array([list(map(float, tokens[place::step])) for place in places]).T


class NoNumber(Exception):
    """Where it stands, and what stands there, as text."""

    def __init__(self, line, column, token):
        super().__init__(line, column, token)
        self.line, self.column = line, column
        self.shown = repr(token[:40].decode("ascii", "replace"))


def is_number(token):
    """Whether bytes are a number as Python reads them, but for underscores between digits."""
    try:
        float(token)
    except ValueError:
        return False
    return b"_" not in token
