"""Text files by line, as a whole, or by their first bytes; errors name the file and the line.

A line ends in a line feed, a carriage return or both.  Text is UTF-8, with or without a mark of
the byte order.
"""

import io
import os
from contextlib import contextmanager

import numpy as np

from attitude.errors import AttitudeError

# Longer lines are no attitude data but a binary or a broken file, bytes.
LONGEST = 20_000
_RECOGNIZED = 4096


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
            start = file.peek(1)
            returns_alone = b"\r" in start and b"\n" not in start
            yield Lines(_ReturnsAsFeeds(file) if returns_alone else file, path)
    except OSError as err:
        raise unreadable(path, err) from err


class _ReturnsAsFeeds:
    """An open binary file whose lines end in carriage returns alone, read with line feeds."""

    def __init__(self, file):
        # Latin-1 maps each byte to one character and back.
        self._text = io.TextIOWrapper(file, encoding="latin-1", newline=None)

    def readline(self, size):
        return self._text.readline(size).encode("latin-1")


def of_text(text, name):
    """The `Lines` of a text; `name` stands for the file in the messages."""
    return Lines(io.BytesIO("\n".join(text.splitlines()).encode("utf-8", "surrogatepass")), name)


def whole(path, advice):
    """The text of a file; `advice` ends the message of an error: what to do or to give."""
    try:
        with open(path, "rb") as file:
            text = file.read().decode("utf-8-sig")
    except OSError as err:
        raise AttitudeError(
            f"{os.fspath(path)}: cannot be read ({err.strerror or err}); {advice}."
        ) from err
    except UnicodeDecodeError as err:
        raise AttitudeError(
            f"{os.fspath(path)}: is not text in UTF-8 (byte {err.start}); {advice}."
        ) from err
    return text.replace("\r\n", "\n").replace("\r", "\n")


def beginning(path):
    """The first 4096 bytes of a file, from the first that is not blank: enough to recognize it."""
    try:
        with open(path, "rb") as file:
            return file.read(_RECOGNIZED).lstrip(b"\xef\xbb\xbf \t\r\n")
    except OSError as err:
        raise unreadable(path, err) from err


def packaged(name):
    """The text of a data file of this package, by its path below ``attitude/``."""
    from importlib import resources

    return resources.files("attitude").joinpath(name).read_text("utf-8")


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
    # An underscore elsewhere in the line, in an epoch or a name, is allowed.
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
