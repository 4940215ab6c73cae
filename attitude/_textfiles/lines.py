"""Text files by line, as a whole, or by their first bytes; errors name the file and the line.

A line ends in a line feed, a carriage return or both.  Text is UTF-8, with or without a byte order
mark.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, TypeAlias

import numpy as np

from attitude._support.quantity_text import quoted
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import NDArray


# Longest line that is read, bytes; binary and broken files have longer ones.
LONGEST: int = 20_000
_RECOGNIZED = 4096

# Makes the error for a line of a file from a sentence and the line's number; None: the last line.
Fault: TypeAlias = Callable[[str, int | None], AttitudeError]


class Lines:
    """Iterator over the lines of an open file as bytes; `number` is that of the last, from 1."""

    def __init__(self, file: BinaryIO | _ReturnsAsFeeds, path: str | os.PathLike[str]):
        self._file = file
        self.path: str = os.fspath(path)
        self.number: int = 0

    def __iter__(self) -> Iterator[bytes]:
        return self

    def __next__(self) -> bytes:
        line = self._file.readline(LONGEST + 1)
        if not line:
            raise StopIteration
        self.number += 1
        if len(line) > LONGEST:
            raise self.fault(f"the line is longer than {LONGEST} characters; is it a text file?")
        return line.rstrip(b"\r\n")

    def fault(self, sentence: str, line: int | None = None) -> AttitudeError:
        """An AttitudeError that begins with the name of the file and the number of the line."""
        return AttitudeError(f"{self.path}, line {line or self.number or 1}: {sentence}")

    @contextmanager
    def located(self, line: int | None = None, what: str = "") -> Iterator[None]:
        """AttitudeErrors inside begin with file and line; `what` stands behind these."""
        try:
            yield
        except AttitudeError as err:
            if str(err).startswith(self.path):
                raise
            raise self.fault(f"{what}{err}", line) from err

    def text(self, line: bytes) -> str:
        """A line as text; AttitudeError if it is not UTF-8 or holds zero bytes."""
        try:
            text = line.decode("utf-8")
        except UnicodeDecodeError as err:
            raise self.fault("it is not UTF-8 text; is it a text file?") from err
        if "\x00" in text:
            raise self.fault("it holds zero bytes; is it a text file?")
        return text.removeprefix("\ufeff")

    def texts(self) -> Iterator[str]:
        """The lines from here on that are neither empty nor a comment (#), without blanks."""
        for line in self:
            text = self.text(line).strip()
            if text and not text.startswith("#"):
                yield text


def path_text(path: object, name: str = "path") -> str:
    """The path of a file as text; AttitudeError for anything else, such as a file descriptor."""
    if isinstance(path, (str, bytes, os.PathLike)):
        return os.fsdecode(path)
    raise AttitudeError(f"{name} is {cut(path)}; give the name of a file, as text or a Path.")


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[Lines]:
    """The `Lines` of a file, which is closed at the end of the block."""
    path = path_text(path)
    try:
        with open(path, "rb") as file:
            start = file.peek(1)
            returns_alone = b"\r" in start and b"\n" not in start
            yield Lines(_ReturnsAsFeeds(file) if returns_alone else file, path)
    except OSError as err:
        raise unreadable(path, err) from err


@contextmanager
def prefixed(origin: str | os.PathLike[str]) -> Iterator[None]:
    """AttitudeErrors inside begin with the name of a file or another origin."""
    try:
        yield
    except AttitudeError as err:
        raise AttitudeError(f"{os.fspath(origin)}: {err}") from err


class _ReturnsAsFeeds:
    """An open binary file whose lines end in carriage returns alone, read with line feeds."""

    def __init__(self, file: BinaryIO):
        # Latin-1 maps each byte to one character and back.
        self._text = io.TextIOWrapper(file, encoding="latin-1", newline=None)

    def readline(self, size: int) -> bytes:
        return self._text.readline(size).encode("latin-1")


def text_of_rows(first: Iterable[object], columns: Iterable[Iterable[float]], mark: str) -> str:
    """The text of N rows: an entry of a first column, and numbers with all their digits."""
    columns = list(columns)
    pattern = "%s" + f"{mark}%r" * len(columns) + "\n"
    return "".join([pattern % row for row in zip(first, *columns, strict=True)])


def of_text(text: str, name: str) -> Lines:
    """The `Lines` of a text; `name` is the name of the file in error messages."""
    return Lines(io.BytesIO("\n".join(text.splitlines()).encode("utf-8", "surrogatepass")), name)


def whole(path: str | os.PathLike[str], advice: str, encoding: str = "UTF-8") -> str:
    """The text of a file, its lines ended by line feeds."""
    path = path_text(path)
    try:
        with open(path, "rb") as file:
            text = file.read().decode("utf-8-sig" if encoding == "UTF-8" else encoding)
    except OSError as err:
        raise AttitudeError(
            f"{os.fspath(path)}: cannot be read ({err.strerror or err}); {advice}."
        ) from err
    except UnicodeError as err:
        raise AttitudeError(
            f"{os.fspath(path)}: is not text in {encoding} (byte {getattr(err, 'start', 0)}); "
            f"{advice}."
        ) from err
    except (LookupError, TypeError, ValueError) as err:
        raise AttitudeError(
            f"encoding is {cut(encoding)}, which Python does not know; give one such as 'latin-1'."
        ) from err
    return text.replace("\r\n", "\n").replace("\r", "\n")


def beginning(path: str | os.PathLike[str]) -> bytes:
    """The first 4096 bytes of a file without leading blanks: enough to recognize its format."""
    path = path_text(path)
    try:
        with open(path, "rb") as file:
            return file.read(_RECOGNIZED).lstrip(b"\xef\xbb\xbf \t\r\n")
    except (OSError, ValueError) as err:  # a name with a null character
        raise unreadable(path, err) from err


def packaged(name: str) -> str:
    """The text of a data file of this package, by its path below ``attitude/``."""
    from importlib import resources

    return resources.files("attitude").joinpath(name).read_text("utf-8")


def path_of_packaged(name: str) -> str:
    """The path of a data file of this package, for readers of files that name others."""
    return str(Path(__file__).resolve().parent.parent / name)


def unreadable(path: str | os.PathLike[str], err: OSError | ValueError) -> AttitudeError:
    """The AttitudeError for a file that the system refuses to read."""
    reason = (isinstance(err, OSError) and err.strerror) or err
    return AttitudeError(f"{os.fspath(path)!r} cannot be read: {reason}.")


def numbers(tokens: Sequence[bytes], step: int, places: Sequence[int]) -> NDArray[np.float64]:
    """Columns of numbers (N, columns) from the entries of N lines."""
    columns = None
    with suppress(ValueError):
        columns = np.array([list(map(float, tokens[place::step])) for place in places]).T
    # Python takes an underscore for a separator of digits; in an epoch or a name it is allowed.
    if columns is None or b"_" in b"".join(tokens):
        for line in range(len(tokens) // step):
            for column, place in enumerate(places):
                if not is_number(tokens[line * step + place]):
                    raise NoNumber(line, column, tokens[line * step + place])
    assert columns is not None
    return columns


# Rows that are converted to numbers at a time.
BATCH: int = 16384


class BulkRows:
    """Rows of a file, converted to numbers in bulk: base of the classes that collect them.

    names: the numbers of a row; "" for those without a name.
    lead: entries before the numbers, such as an epoch, or a day and its seconds.
    order, step: the places of lead and names among the entries of a row, and the count of these.
    """

    holds: str = ""  # what a row holds, in sentences
    # other count of entries -> the places of those that are read
    others: Mapping[int, Sequence[int]] = {}

    def __init__(self, fault: Fault, names: Sequence[str], lead: int = 1):
        self.fault: Fault = fault  # an error of a sentence and a line
        self.names: Sequence[str] = names
        self.lead: int = lead
        self.entries: list[bytes] = []  # of the rows not yet converted
        self.lines: list[int] = []  # the line of each of these rows
        self.order: list[int] = list(range(lead + len(names)))
        self.step: int = lead + len(names)

    def add(
        self, leads: Sequence[Sequence[bytes]], values: NDArray[np.float64], lines: Sequence[int]
    ) -> None:
        """Add N rows: (lead, N) entries before the numbers, values (N, names), and the lines."""
        raise NotImplementedError(f"{type(self).__name__} defines no add")

    def known(self, tokens: list[bytes], line: int) -> list[bytes]:
        """The entries of a row that are read; AttitudeError for another count of entries."""
        if len(tokens) == self.step:
            return tokens
        if len(tokens) not in self.others:
            raise self.fault(f"it has {len(tokens)} entries; {self.holds}.", line)
        return [tokens[place] for place in self.others[len(tokens)]]

    def take(self, tokens: Sequence[bytes], line: int) -> None:
        """Take a row."""
        self.entries.extend(tokens)
        self.lines.append(line)
        if len(self.lines) >= BATCH:
            self.convert()

    def arrange(self, order: list[int], step: int) -> None:
        """Change the order of the entries of following rows."""
        if (order, step) != (self.order, self.step):
            self.convert()
            self.order, self.step = order, step

    def convert(self) -> None:
        """Convert and add the rows that were taken."""
        step = self.step
        if not self.lines:
            return
        try:
            values = numbers(self.entries, step, self.order[self.lead :])
        except NoNumber as err:
            name = self.names[err.column]
            sentence = f"{name} is {err.shown}, which" if name else err.shown
            raise self.fault(f"{sentence} is no number.", self.lines[err.line]) from err
        leads = [self.entries[place::step] for place in self.order[: self.lead]]
        self.add(leads, values, self.lines)
        self.entries.clear()
        self.lines.clear()


# Characters of a value that a sentence quotes.
_QUOTED = 40


def cut(value: object, mark: str | None = None) -> str:
    """A value as a sentence quotes it: at most 40 characters.

    In the quotation marks of Python, or in `mark`, which may be empty.

    >>> cut("SC_BODY_1"), cut("x" * 50, "")
    ("'SC_BODY_1'", 'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...')
    """
    return quoted(value, _QUOTED, mark)


class NoNumber(Exception):
    """An entry that is not a number: line and column, from 0, and its text in quotes."""

    def __init__(self, line: int, column: int, token: bytes):
        super().__init__(line, column, token)
        self.line: int = line
        self.column: int = column
        self.shown: str = repr(token[:40].decode("ascii", "replace"))


def is_number(token: bytes) -> bool:
    """Whether bytes are a number as Python reads it, without underscores between digits."""
    try:
        float(token)
    except ValueError:
        return False
    return b"_" not in token
