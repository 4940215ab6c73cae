"""CCSDS messages as tables of keywords: tokens of KVN or XML, rows in bulk, and one generator.

A `Form` is the table of a kind of message.  Both notations are read into the same `Message`, by
calls of its `start`, `entry` and `stop` and of `MessageRows.take`, and written by the same calls
of a `Generator`.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import chain, groupby
from mmap import ACCESS_READ, mmap
from typing import IO, TYPE_CHECKING, TypeAlias

from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import BATCH, BulkRows, cut, is_number, opened
from attitude._textfiles.xml import ElementReader, escaped
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath, FloatArray
    from attitude._textfiles.lines import Fault, Lines


@dataclass(frozen=True)
class Form:
    """What a kind of message may hold.

    versions, header, meta: the versions, and the keywords of the header and the meta data; a
        keyword that ends in * stands for all that begin so.
    marks: "metadata" and "data" -> what marks them in KVN, if there are marks.  A message with
        "data" has segments, each with meta data and a block DATA; "" if the meta data end where it
        begins.
    """

    kind: str  # such as "AEM"
    versions: tuple[str, ...]
    header: tuple[str, ...]
    meta: tuple[str, ...] = ()
    family: str = "CCSDS"  # or "CIC"
    needed: tuple[str, ...] = ()  # keywords that the meta data must have
    # keyword of the meta data -> the one version that has it
    only: Mapping[str, str] = field(default_factory=dict)
    blocks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # block -> its keywords
    # keyword -> units that may stand behind its value; a value without a unit is in the first
    units: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    elements: Mapping[str, str] = field(default_factory=dict)  # element of XML -> block
    # block with rows -> the element of XML that holds one
    rows: Mapping[str, str] = field(default_factory=dict)
    # block that stands inside of another one -> that one
    inner: Mapping[str, str] = field(default_factory=dict)
    once: tuple[str, ...] = ()  # blocks that a message has once
    repeated: tuple[str, ...] = ()  # keywords that a block may have several times
    skipped: tuple[str, ...] = ()  # blocks that are not read
    # keyword of version 1.0, whose blocks have no marks in KVN -> block, and keyword there
    old: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    # elements of XML that stand between a block or a row and its keywords
    groups: tuple[str, ...] = ()
    anywhere: tuple[str, ...] = ()  # keywords of the meta data that stand in a block of XML
    marks: Mapping[str, str] = field(default_factory=dict)
    lenient: bool = False  # unknown meta data are left out, and marks of DATA may be missing
    spaced: bool = False  # whether empty lines stand around the written meta data

    def meta_of(self, version: str) -> tuple[str, ...]:
        """The keywords of the meta data in a version, in their order."""
        return tuple(word for word in self.meta if self.only.get(word, version) == version)


# The bytes with which a row begins in KVN.
_NUMERIC = frozenset(b"+-.0123456789")
# The block with the rows of a message that has segments.
_DATA = "DATA"
# The element of a number in a row of XML: tag, that of the element around it, and attributes.
Leaf: TypeAlias = tuple[str, str, Mapping[str, str]]


class MessageRows(BulkRows):
    """The rows of a block: base of classes that collect them, but numbers of XML in `unread`."""

    unread: Sequence[str] = ()

    def named(self, leaves: Sequence[Leaf]) -> Sequence[str]:
        """The names of the numbers of a row in XML; "EPOCH" for its epoch."""
        return [tag for tag, _, _ in leaves]


# Makes the rows of a block, from the count of entries of the first one (None in XML).
BeginRows: TypeAlias = Callable[["Block", "int | None"], MessageRows]


def comparable(name: str) -> str:
    """A value as such values are compared: an underscore is a blank, and several blanks are one.

    Source: CCSDS 504.0-B-2, 6.8.8.

    >>> comparable("SC_Body  1")
    'SC BODY 1'
    """
    return " ".join(name.replace("_", " ").split()).upper()


class Block(dict[str, str]):
    """Keywords and values of a part of a message, which begins in a line, and its rows.

    lines: keyword -> number of its line; order: (keyword, value, line) of all, repeated ones too.
    """

    def __init__(self, name: str, line: int, message: Message, meta: Block | None = None):
        super().__init__()
        self.name: str = name
        self.line: int = line
        self.lines: dict[str, int] = {}
        self.order: list[tuple[str, str, int]] = []
        self.comments: list[str] = []
        self.rows: MessageRows | None = None
        self.inner: list[Block] = []
        self.message: Message = message
        self.meta: Block = self if meta is None else meta

    def fault(self, sentence: str, keyword: str | None = None) -> AttitudeError:
        """The error for a keyword, in its line, or for the block."""
        line = self.line if keyword is None else self.lines.get(keyword, self.line)
        return self.message.fault(sentence, line or None)

    @contextmanager
    def located(self, keyword: str | None = None, what: str = "") -> Iterator[None]:
        """AttitudeErrors inside begin with file and line; `what` stands behind these."""
        try:
            yield
        except AttitudeError as err:
            if str(err).startswith(self.message.path):
                raise
            raise self.fault(f"{what}{err}", keyword) from err

    def put(self, keyword: str, value: str, line: int) -> None:
        """Add a keyword; AttitudeError for a repeated one, an empty one, and behind rows."""
        form = self.message.form
        if keyword in self and keyword not in form.repeated:
            raise self.message.fault(
                f"{cut(keyword, '')} is given twice, first in line {self.lines[keyword]}.", line
            )
        if not value and keyword in form.needed:
            raise self.message.fault(f"{keyword} has no value.", line)
        if self.rows is not None:
            raise self.message.fault(f"{keyword} stands behind the rows of its block.", line)
        self.order.append((keyword, value, line))
        self[keyword], self.lines[keyword] = value, line

    def begin_rows(self, count: int | None = None) -> MessageRows:
        """The rows of the block, of which the first has so many entries (None in XML)."""
        if self.rows is None:
            self.rows = self.message.begin_rows(self, count)
        return self.rows

    def needed(self, keyword: str) -> str:
        """The value of a keyword; AttitudeError if it is missing or empty."""
        if not self.get(keyword):
            raise self.fault(f"{self._lacks} {keyword}.")
        return self[keyword]

    @property
    def _lacks(self):
        """The beginning of a sentence; header and meta data have names in lower case."""
        is_block = self.name.isupper()
        return f"the block {self.name} lacks" if is_block else f"the {self.name} lack"

    def numbers(self, keyword: str, count: int = 1) -> list[float]:
        """The finite numbers of a keyword; a unit other than the standard's is refused."""
        value, unit = self.needed(keyword), ""
        if match := _UNIT.fullmatch(value):
            value, unit = match.groups()
        self.message.refuse_unit(keyword, unit.replace(" ", ""), self.lines[keyword])
        words = value.split()
        are_numbers = all(is_number(word.encode("ascii", "replace")) for word in words)
        values = list(map(float, words)) if are_numbers else []
        if len(values) != count or not all(map(math.isfinite, values)):
            what = "a finite number" if count == 1 else f"{count} finite numbers"
            what += "".join(f" in {unit}" for unit in self.message.form.units.get(keyword, ())[:1])
            raise self.fault(f"{keyword} is {cut(value)}; give {what}.", keyword)
        return values

    def number(self, keyword: str) -> float:
        """The one finite number of a keyword; see `numbers`."""
        return self.numbers(keyword)[0]

    def one_of(self, keyword: str, choices: Iterable[str], usual: str | None = None) -> str:
        """The choice that the value of a keyword is; AttitudeError for another value."""
        value = self.get(keyword, usual)
        by_name = {comparable(choice): choice for choice in choices}
        if value is None or comparable(value) not in by_name:
            what = f"{self._lacks} {keyword}"
            if value is not None:
                of_block = f" of the block {self.name}" if self.name.isupper() else ""
                what = f"{keyword}{of_block} is {cut(value)}"
            known = ", ".join(cut(choice, "") for choice in choices)
            raise self.fault(f"{what}; it must be one of {known}.", keyword)
        return by_name[comparable(value)]


class Message:
    """A message while it is read: header, meta data of the last segment, and blocks, open or not.

    where: "header", "meta data" or "data"; "" in messages without marks between these.
    """

    def __init__(
        self,
        form: Form,
        version: str,
        path: str,
        fault: Fault,
        begin_rows: BeginRows | None = None,
    ):
        self.form: Form = form
        self.version: str = version
        self.path: str = path
        self.fault: Fault = fault
        self.begin_rows: BeginRows = begin_rows or (lambda block, count: MessageRows(fault, ()))
        self.header: Block = Block("header", 0, self)
        self.meta: Block = Block("meta data", 0, self)
        self.blocks: list[Block] = []
        self.open: list[Block] = []
        self.where: str = "header" if "metadata" in form.marks else ""
        self.assumed: list[str] = []
        self._comments: list[str] = []
        self._old = form.old if version == "1.0" else {}

    def all(self, name: str) -> list[Block]:
        """The blocks of a name."""
        return [block for block in self.blocks if block.name == name]

    def assume(self, what: str) -> None:
        """Note what is assumed, once."""
        if what not in self.assumed:
            self.assumed.append(what)

    def start(self, name: str, line: int) -> None:
        """Begin a block, inside of another one or not."""
        outer, allowed = self.open[-1] if self.open else None, self.form.inner.get(name)
        if outer is not None and outer.name != allowed:
            raise self.fault(f"{name} begins before the end of {outer.name}.", line)
        if outer is None and allowed is not None:
            raise self.fault(f"{name} stands outside of {allowed}.", line)
        if name in self.form.once and any(block.meta is self.meta for block in self.all(name)):
            raise self.fault(f"the message has a second block {name}; it may have one.", line)
        blocks = self.blocks if outer is None else outer.inner
        blocks.append(Block(name, line, self, self.meta))
        self.open.append(blocks[-1])
        if name == _DATA:
            self.open[-1].comments.extend(self._comments)
            self._comments.clear()

    def stop(self, name: str, line: int) -> None:
        """End the innermost block, which must have this name."""
        if not self.open or self.open[-1].name != name:
            raise self.fault(f"{name}_STOP stands without {name}_START.", line)
        block = self.open.pop()
        if block.rows is not None:
            block.rows.convert()

    def entry(self, keyword: str, value: str, line: int) -> None:
        """Add a keyword where the reader is; AttitudeError if it is not known there."""
        block = self.open[-1] if self.open else None
        if keyword == "COMMENT":
            self._remarks(block).append(value)
        elif block is None and self._is_common(keyword):
            is_of_header = self.where != "meta data" and _is_among(keyword, self.form.header)
            (self.header if is_of_header else self.meta).put(keyword, value, line)
        elif keyword in self._old:
            self._in_version_1(block, keyword, value, line)
        elif block is not None and _is_among(keyword, self.form.blocks[block.name]):
            block.put(keyword, value, line)
        elif self.form.lenient and self.where == "meta data":
            self.assume(f"{cut(keyword, '')} is not known: left out")
        else:
            only = self.form.only.get(keyword)
            hint = f" (it belongs to version {only})" if only else ""
            raise self.fault(f"{cut(keyword, '')} is not known in {self._here()}{hint}.", line)

    def at_row(self, first: int, line: int) -> bool:
        """Whether a line of KVN that begins with this byte is a row of the open block."""
        form = self.form
        if form.lenient and self.lacks_data and chr(first).isdigit():
            self.start(_DATA, line)
        return first in _NUMERIC and bool(self.open) and self.open[-1].name in form.rows

    @property
    def lacks_data(self) -> bool:
        """Whether the meta data of a segment have ended and its data have not begun."""
        if self.where != "data" or _DATA not in self.form.blocks:
            return False
        return not self.blocks or self.blocks[-1].meta is not self.meta

    def is_skipping(self) -> bool:
        """Whether the open block is not read."""
        return bool(self.open) and self.open[-1].name in self.form.skipped

    def mark(self, mark: str, line: int) -> None:
        """Process a line of KVN with _START or _STOP."""
        name, _, end = mark.rpartition("_")
        if mark == "META_START":
            self.start_meta(mark, line)
        elif mark == "META_STOP":
            self.stop_meta(line)
            if self.form.marks.get("data") == "":
                self.start(_DATA, line)
        elif name not in self.form.blocks or self._old:
            known = ", ".join(["META", *(() if self._old else self.form.blocks)])
            raise self.fault(
                f"{cut(mark, '')} is not known in version {self.version}; known are {known}, each "
                "with _START and _STOP.",
                line,
            )
        elif self.where not in ("data", ""):
            raise self.fault(f"{mark} stands before META_STOP.", line)
        elif end == "START":
            self.start(name, line)
        else:
            self.stop(name, line)

    def start_meta(self, mark: str, line: int) -> None:
        """Begin the meta data of the message or of a segment; `mark` is what does so."""
        if self.where == "data" and _DATA in self.form.blocks:
            self._end_data(mark, line)
        elif self.where == "meta data":
            raise self.fault(f"{mark} stands before the end of the meta data before.", line)
        elif self.where == "data":
            raise self.fault(
                f"{mark} stands in the wrong place; an {self.form.kind} has one META block.", line
            )
        if self.where:
            self.meta, self.where = Block(self.meta.name, line, self), "meta data"
            self._comments.clear()

    def stop_meta(self, line: int) -> None:
        """End the meta data, which must be complete."""
        if not self.where:
            return
        if self.where != "meta data":
            raise self.fault("META_STOP stands without META_START.", line)
        self._refuse_incomplete(line)
        self.where = "data"

    def end(self, line: int | None = None) -> None:
        """End the message; AttitudeError if it ends inside of a block or before the data."""
        if not self.where:
            self._refuse_incomplete(line)
        elif self.where == "data" and _DATA in self.form.blocks:
            self._end_data(None, line)
        if self.open or self.where not in ("data", ""):
            mark = "META_START" if self.where == "header" else "META_STOP"
            mark = f"{self.open[-1].name}_STOP" if self.open else mark
            raise self.fault(f"the file ends before {mark}; is it cut off?", line)

    def _refuse_incomplete(self, line):
        for keyword in self.form.needed:
            if not self.meta.get(keyword):
                raise self.fault(
                    f"the meta data end without {keyword}, which they must have.", line
                )

    def _end_data(self, mark, line):
        """End the data of a segment at the mark of the next one, or at the end of the file."""
        lacking = "DATA_START" if self.lacks_data else ""
        is_marked = self.form.marks["data"] != ""
        if self.open and self.open[-1].name == _DATA and (self.form.lenient or not is_marked):
            if is_marked:
                self.assume("DATA_STOP is missing: the data end with the next segment or the file")
            self.stop(_DATA, line)
        elif self.open:
            lacking = f"{self.open[-1].name}_STOP"
        if lacking:
            what = "the file ends" if mark is None else f"{mark} stands"
            raise self.fault(f"{what} before {lacking}; is it cut off?", line)

    def refuse_between(self, shown: str, line: int) -> None:
        """AttitudeError for a line without = before or behind the data of a segment."""
        if self.where == "data" and not self.open and _DATA in self.form.blocks:
            mark = "DATA_START" if self.lacks_data else "META_START or the end"
            raise self.fault(f"{shown} stands where {mark} must be.", line)

    def refuse_unit(self, keyword: str, unit: str | None, line: int | None) -> None:
        """AttitudeError for a unit in which a keyword or a number of a row may not be."""
        allowed = self.form.units.get(keyword, ())
        if unit and unit not in allowed:
            known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
            raise self.fault(f"{keyword} is in {cut(unit)}{known}.", line)

    def _remarks(self, block):
        """The list of comments where the reader is; those behind the data of a segment are lost."""
        if block is not None:
            return block.comments
        if self.where == "data" and _DATA in self.form.blocks:
            return self._comments
        return (self.header if self.where in ("header", "") else self.meta).comments

    def _is_common(self, keyword):
        header = _is_among(keyword, self.form.header)
        meta = keyword in self.form.meta_of(self.version)
        return {"header": header, "meta data": meta, "": header or meta}.get(self.where, False)

    def _in_version_1(self, block, keyword, value, line):
        """Add a keyword of version 1.0 to its block; MAN_EPOCH_START begins a new maneuver."""
        name, known = self._old[keyword]
        if block is None:
            if not self.all(name) or keyword == "MAN_EPOCH_START":
                self.blocks.append(Block(name, line, self, self.meta))
            block = self.all(name)[-1]
        if block.name != name:
            raise self.fault(f"{keyword} is not known in {self._here()}.", line)
        block.put(known, value, line)

    def _here(self):
        """Where the reader is, and what is known there."""
        form, meta = self.form, self.form.meta_of(self.version)
        if self.open:
            name = self.open[-1].name
            old = [keyword for keyword, (block, _) in self._old.items() if block == name]
            place, known = f"the block {name}", old or form.blocks[name]
        elif self.where == "data":
            return f"an {form.kind} outside of a block"
        else:
            place = f"the {self.where or 'header and the meta data'} of an {form.kind}"
            known = {"header": form.header, "meta data": meta}.get(self.where, form.header + meta)
        words = f"; known are {', '.join(known)}" if known else ""
        return f"{place} of version {self.version}{words}"


def _is_among(keyword, words):
    """Whether a keyword is one of some, of which those with * stand for all that begin so."""
    return keyword in words or any(
        word.endswith("*") and keyword.startswith(word[:-1]) for word in words
    )


def read(path: FilePath, form: Form, begin_rows: BeginRows | None = None) -> Message:
    """A message in KVN or XML, recognized by the content."""
    with opened(path) as lines:
        line = _first(lines)
        if line is None and form.family != "CCSDS":
            line = b"<"  # other families have no XML
        if line is not None:
            return _of_kvn(lines, Message(*_head(lines, line, form), lines.fault, begin_rows))
    reader = _MessageReader(path, form, begin_rows)
    reader.run()
    if reader.message is None:
        raise reader.fault(f"there is no <{form.kind.lower()}> message in it.")
    return reader.message


# ---- Tokens of KVN: lines of KEYWORD = value

# Longest keyword, characters: sentences repeat them.
_LONGEST_KEYWORD = 60
# value [unit]
_UNIT = re.compile(r"(.*?)\s*\[([^][]*)\]")


def _of_kvn(lines: Lines, message: Message) -> Message:
    """The message of the lines behind the first."""
    line = next(lines, None)
    while line is not None:
        text = line.strip()
        if text and message.at_row(text[0], lines.number):
            line = _take_rows(lines, line, message.open[-1])
            continue
        if text.endswith((b"_START", b"_STOP")) and b"=" not in text and b" " not in text:
            message.mark(text.decode("ascii", "replace"), lines.number)
        elif text and not message.is_skipping():
            if b"=" not in text and not text.startswith(b"COMMENT"):
                message.refuse_between(cut(lines.text(line).strip()), lines.number)
            message.entry(*pair(lines, line), lines.number)
        line = next(lines, None)
    message.end()
    return message


def _take_rows(lines, line, block):
    """Take rows of a block from a line on; the first line that is none, None at the end."""
    rows = block.begin_rows(len(line.split()))
    if block.line == lines.number:
        block.message.assume("DATA_START is missing: the data begin with the first epoch")
    width, entries, places = rows.step, rows.entries, rows.lines
    for following in chain((line,), lines):
        tokens = following.split()
        if tokens and tokens[0][0] in _NUMERIC:
            if len(tokens) != width:
                tokens = rows.known(tokens, lines.number)
            entries.extend(tokens)
            places.append(lines.number)
            if len(places) == BATCH:
                rows.convert()
        elif tokens:
            return following
    return None


def _first(lines: Lines) -> bytes | None:
    """The first line that is neither empty nor a comment; None if the message is in XML."""
    for line in lines:
        text = line.lstrip(b"\xef\xbb\xbf \t")
        if text.startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
            return None
        if text and not text.startswith(b"COMMENT"):
            return line
    raise lines.fault("the file is empty.")


def _head(lines: Lines, line: bytes, form: Form) -> tuple[Form, str, str]:
    """Form, version and path of a message, from its first line."""
    keyword, value = pair(lines, line)
    wanted = f"{form.family}_{form.kind}_VERS"
    if keyword != wanted or value not in form.versions:
        other = keyword == f"CIC_{form.kind}_VERS" and form.family != "CIC"
        raise lines.fault(
            f"it begins with {cut(lines.text(line).strip())}; an {form.kind} begins with "
            f"{wanted} = {' or '.join(form.versions)}"
            + ("; attitude.formats.cic reads the dialect of CNES." if other else ".")
        )
    return form, value, lines.path


def pair(lines: Lines, line: bytes) -> tuple[str, str]:
    """Keyword, in capital letters, and value of a line; a comment is ("COMMENT", text)."""
    text = lines.text(line)
    stripped = text.strip()
    if stripped.startswith("COMMENT"):
        return "COMMENT", stripped[7:].removeprefix("=").strip()
    keyword, equals, value = text.partition("=")
    if not equals or not 0 < len(keyword.strip()) <= _LONGEST_KEYWORD:
        raise lines.fault(f'{cut(stripped)} is no "KEYWORD = value".')
    return keyword.strip().upper(), value.strip()


def values(lines: Lines, first: str) -> list[dict[str, str]]:
    """Keyword -> value of each message of one block, without comments and units of numbers.

    first: the keyword that begins a message; the last value counts of any other.
    """
    blocks: list[dict[str, str]] = [{}]
    for keyword, value in (pair(lines, line) for line in lines if lines.text(line).strip()):
        if keyword == first and blocks[-1]:
            blocks.append({})
        if keyword != "COMMENT":
            number = value.partition("[")[0].strip()
            blocks[-1][keyword] = number if is_number(number.encode()) else value
    return blocks


# ---- Tokens of XML: CCSDS 505.0-B-3

# Messages, and the elements that may stand around one.
MESSAGES: tuple[str, ...] = ("acm", "aem", "apm", "cdm", "ocm", "oem", "omm", "opm", "rdm", "tdm")
_OUTSIDE = ("ndm", "COMMENT", "MESSAGE_ID")
_PARTS = frozenset(("header", "metadata", "data"))
_OUTER = frozenset(("ndm", "body", "segment", *_PARTS))
# Longest incomplete row, bytes, that is kept back from the parser until its end is read, so that a
# pattern can match it.
_LONGEST_ROW = 1 << 16
# Layouts of rows in one file for which patterns are compiled.
_MOST_PATTERNS = 50


def kinds_in(path: FilePath, text: bytes) -> list[str]:
    """The kinds of messages in a file in XML that begins with a text; of an <ndm> several."""
    pattern = re.compile(rf"<(?:[\w.-]+:)?({'|'.join(MESSAGES)})[\s>]".encode())
    if b"<ndm" not in text:
        return [kind.decode() for kind in pattern.findall(text)[:1]] or ["aem"]
    with open(path, "rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as content:
        return list(dict.fromkeys(kind.decode() for kind in pattern.findall(content)))


class _MessageReader(ElementReader):
    """Collects the message; rows that differ from the last one in their texts match a pattern."""

    def __init__(self, path, form, begin_rows):
        super().__init__(path)
        self._form, self._begin_rows = form, begin_rows
        # Tags of the open elements with the blocks they begin; then those of the open row.
        self._tags, self._attributes, self._comments = [], {}, []
        self._is_leaf, self._leaves, self._texts = False, None, []
        # The tag of the open message of another kind, in an <ndm> of several.
        self._other = None
        row = form.rows.get(_DATA, "")
        self._begin, self._end = f"<{row}>".encode(), f"</{row}>".encode()
        # Bytes that are kept back from the parser.
        self._rest, self._pattern, self._patterns, self._ended_at = b"", None, {}, 0

    def begin(self, tag, attributes):
        form, message, name = self._form, self.message, None
        if tag in MESSAGES and tag != form.kind.lower() and self._above() == "ndm":
            self._other = tag
        if self._other is not None:
            return
        if self._leaves is None:
            if tag in MESSAGES or (message is None and tag not in _OUTSIDE):
                version = self.version(tag, attributes, form.kind.lower(), form.versions)
                self.message = Message(form, version, self.path, self.fault, self._begin_rows)
                self.message.header.comments.extend(self._comments)
            elif tag in _PARTS and message is not None and message.where:
                self._enter(tag)
            if message is not None:
                name = self._started(tag)
        self._tags.append((tag, name))
        self._attributes, self._is_leaf = attributes, True

    def _enter(self, tag):
        """Enter a part of the message or of a segment."""
        if tag == "metadata":
            self.message.start_meta("<metadata>", self.line)
        elif tag == "data" and self.message.where != "data":
            raise self.fault("<data> stands before the end of <metadata>.")
        else:
            self.message.where = tag

    def _started(self, tag):
        """Begin the block of an element, or a row; the name of the block."""
        form, message = self._form, self.message
        outer = message.open[-1].name if message.open else None
        name = form.elements.get(tag)
        if outer in form.rows and tag == form.rows[outer]:
            self._leaves, self._texts = [], []
        elif name is not None and (
            self._above() == "data" or name == _DATA or form.inner.get(name, "") == outer
        ):
            message.start(name, self.line)
            return name
        return None

    def _above(self):
        return self._tags[-1][0] if self._tags else None

    def end(self, tag, text):
        if self._other is not None:
            self._other = None if tag == self._other else self._other
            return
        name, message = self._tags.pop()[1], self.message
        is_leaf, self._is_leaf = self._is_leaf, False
        if message is None:
            self._comments += [text] if tag == "COMMENT" else []
        elif self._leaves is not None:
            self._in_row(tag, text, is_leaf)
        elif name is not None:
            message.stop(name, self.line)
        elif tag == "metadata" and message.where:
            message.stop_meta(self.line)
        elif tag == self._form.kind.lower():
            message.end(self.line)
        elif tag not in _OUTER and tag not in self._form.groups:
            self._leaf(message, tag, text)

    def _leaf(self, message, tag, text):
        form, unit = self._form, self._attributes.get("units")
        label = self._attributes.get("angle") or self._attributes.get("rate")
        if message.is_skipping():
            return
        if tag.startswith("rotation") and label in form.repeated:
            tag = label
        elif tag == "USER_DEFINED":
            tag = f"USER_DEFINED_{self._attributes.get('parameter', '')}"
        if tag in form.anywhere and tag not in message.meta:
            message.meta.put(tag, text, self.line)
        elif not message.open and self._above() not in ("header", "metadata") and tag != "COMMENT":
            if _DATA not in form.blocks:  # between the parts of segments elements are not read
                raise self.fault(f"<{tag[:40]}> stands outside of a block.")
        else:
            message.entry(tag, text if unit is None else f"{text} [{unit}]", self.line)

    def _in_row(self, tag, text, is_leaf):
        """Add an element to the open row, or end the row."""
        block = self.message.open[-1]
        if tag == self._form.rows[block.name]:
            self._end_row(block.begin_rows(), text)
        elif is_leaf and (text or tag not in self._form.groups):
            self._leaves.append((tag, self._above(), self._attributes))
            self._texts.append(text.encode("ascii", "replace"))
        elif text or tag not in self._form.groups:
            raise self.fault(f"<{tag}> does not belong into a row, or has a text.")

    def _end_row(self, rows, text):
        """Add the open row: that of its elements, or of its text without any."""
        if self._leaves:
            rows.arrange(self._order(rows), len(self._leaves))
            rows.take(self._texts, self.line)
        else:
            tokens = text.encode("ascii", "replace").split()
            rows.take(rows.known(tokens, self.line), self.line)
        self._leaves, self._ended_at = None, self.place

    def _order(self, rows):
        """The places of lead and names among the leaves of the open row."""
        places: dict[str, int] = {}
        for place, name in enumerate(rows.named(self._leaves)):
            if name in places or name not in ("EPOCH", *rows.names, *rows.unread):
                raise self.fault(
                    f"{cut(name, '')} does not belong into a row, or not twice; {rows.holds}."
                )
            self.message.refuse_unit(name, self._leaves[place][2].get("units"), None)
            places[name] = place
        names = ("EPOCH", *rows.names)
        lacking = [name for name in names if name not in places]
        if lacking:
            raise self.fault(f"the row lacks {', '.join(lacking)}.")
        return [places[name] for name in names]

    # Runs of rows that differ in their texts only are read by a pattern instead of the parser.  The
    # first row of a run is parsed as XML.  The following rows that have the same tags, attributes,
    # order and spaces, and plain texts without entities, have the same structure; a regular
    # expression extracts their texts, four times as fast as the parser.  Everything else is parsed.

    def take(self, piece, last=False):
        """Match rows that follow a parsed one; give everything else to the parser."""
        if _DATA not in self._form.rows:
            self.feed(piece, last)
            return
        buffer, at = self._rest + piece, 0
        self._rest = b""
        while True:
            if self._pattern is not None:
                at = self._match_rows(buffer, at)
            end = buffer.find(self._end, at) + len(self._end)
            if end < len(self._end):
                break
            start = buffer.rfind(self._begin, at, end)
            self.feed(buffer[at:end])
            self._pattern = self._pattern_of(buffer[start:end]) if start >= 0 else None
            at = end
        # The beginning of a row is kept until its end is read, up to some length.
        start = buffer.find(b"<", at) if self._pattern is not None else buffer.find(self._begin, at)
        if start < 0:
            start = len(buffer)
        elif last or len(buffer) - start > _LONGEST_ROW:
            start, self._pattern = len(buffer), None
        self.feed(buffer[at:start], last)
        self._rest = buffer[start:]

    def _pattern_of(self, row):
        """The pattern of the last row, if the parser has just finished it."""
        if self._ended_at + len(self._end) != self.fed:
            return None
        source = pattern_of(row, self.message.open[-1].rows.step)
        if source is not None and source not in self._patterns:
            if len(self._patterns) >= _MOST_PATTERNS:
                return None
            self._patterns[source] = re.compile(source)
        return self._patterns.get(source)

    def _match_rows(self, buffer, at):
        """Add the rows that match the pattern; the offset of the first that does not."""
        match, rows, line = self._pattern.match, self.message.open[-1].rows, self.line
        entries, lines = rows.entries, rows.lines
        while texts := match(buffer, at):
            entries.extend(texts.groups())
            line += buffer.count(b"\n", at, texts.end())
            lines.append(line)
            at = texts.end()
        self.skipped += line - self.line
        if len(lines) >= BATCH:
            rows.convert()
        return at


# Texts of numbers and dates: no references, no tags, no underscores (which Python's float takes
# for separators of digits).
_TEXT = rb"([^<>&_\s]{1,60})"
_TAG = re.compile(rb"<[^<>]*>")
_LONGEST_PATTERN = 4096  # bytes of a row: patterns of longer ones would take long to compile


def pattern_of(row: bytes, texts: int) -> bytes | None:
    """The regular expression of rows with the structure of one; None for other than plain texts.

    row: a whole element, well-formed.
    texts: number of texts in the row, which are the groups of the expression.

    >>> pattern = re.compile(pattern_of(b"<a><b>1</b> <c u='m'>2</c></a>", 2))
    >>> pattern.match(b"  <a><b>3</b> <c u='m'>4</c></a>").groups()
    (b'3', b'4')
    >>> pattern.match(b"<a><b>3</b> <c u='s'>4</c></a>") is None
    True
    """
    if len(row) > _LONGEST_PATTERN or b"<!" in row or b"<?" in row or b"&" in row:
        return None
    pieces, end = [rb"\s*"], 0
    for tag in _TAG.finditer(row):
        between = row[end : tag.start()]
        text = between.strip()
        before, _, after = between.partition(text) if text else (between, b"", b"")
        texts -= bool(text)
        pieces += [re.escape(before), _TEXT * bool(text), re.escape(after + tag.group())]
        end = tag.end()
    return b"".join(pieces) if texts == 0 and end == len(row) else None


# ---- Writing

_SCHEMAS = {"1.0": "2.0.0-master-2.0", "2.0": "4.0.0-master-4.0"}


class Generator:
    """Writes a message in KVN to an open file."""

    def __init__(self, file: IO[str], form: Form, version: str):
        self._file, self._form, self._version = file, form, version

    def text_of(self, write: Callable[[Generator], None]) -> str:
        """What a function writes, as a text instead of in the file."""
        file, self._file = self._file, io.StringIO()
        try:
            write(self)
            return self._file.getvalue()
        finally:
            self._file = file

    @contextmanager
    def message(self) -> Iterator[None]:
        """The message around its parts."""
        self._file.write(f"{self._form.family}_{self._form.kind}_VERS = {self._version}\n")
        yield

    @contextmanager
    def part(self, element: str, mark: str | None = None) -> Iterator[None]:
        """A part: an element of XML, and between marks in KVN, or behind an empty line if ""."""
        mark = self._form.marks.get(element) if mark is None else mark
        if mark is not None:
            self._file.write(f"\n{mark}_START\n" if mark else "\n")
        yield
        if mark:
            self._file.write(f"{mark}_STOP\n")

    def entry(self, key: str, value: str | float, element: str = "") -> None:
        """A keyword with its unit; `element` is the tag in XML with attributes, if not the key."""
        self._file.write(f"{key} = {_written(value)}{self._unit(key, ' [{}]')}\n")

    def comments(self, comments: Iterable[str]) -> None:
        """Comments, one by one."""
        self._file.writelines(f"COMMENT {text}\n" for text in comments)

    def entries(self, entries: Iterable[tuple[str, str | float]]) -> None:
        """Keywords and values, with their units."""
        for key, value in entries:
            self.entry(key, value)

    def grouped(
        self, entries: Iterable[tuple[str, str | float]], groups: Mapping[str, str | None]
    ) -> None:
        """Keywords and values; in XML each group of them has an element around it."""
        self.entries(entries)

    def row(self, element: str, count: int) -> str:
        """The text of a row: %s for its epoch and %r for each of its numbers."""
        return "%s" + " %r" * count + "\n"

    def table(self, epochs: Sequence[str], columns: FloatArray, row: str) -> None:
        """MessageRows of N epochs and columns (N, count), each by its text from `row`."""
        records = zip(epochs, *columns.T.tolist(), strict=True)
        self._file.write("".join([row % record for record in records]))

    def metadata(self, keywords: Mapping[str, str], comments: Iterable[str]) -> None:
        """The meta data of a message or of a segment."""
        space = "\n" * self._form.spaced
        with self.part("metadata"):
            self.comments(comments)
            self._file.write(space)
            self.entries(keywords.items())
            self._file.write(space)

    def _unit(self, key, text):
        return text.format(self._form.units[key][0]) if key in self._form.units else ""


class XmlGenerator(Generator):
    """Writes a message in XML to an open file."""

    _depth = 0

    @contextmanager
    def message(self) -> Iterator[None]:
        """The message around its parts."""
        kind = self._form.kind
        self._file.write(
            '<?xml version="1.0" encoding="UTF-8"?>\n'
            f'<{kind.lower()} xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
            '     xsi:noNamespaceSchemaLocation="https://sanaregistry.org/r/ndmxml_unqualified/'
            f'ndmxml-{_SCHEMAS[self._version]}.xsd"\n'
            f'     id="CCSDS_{kind}_VERS" version="{self._version}">\n'
        )
        self._depth += 2
        yield
        self._file.write(f"</{kind.lower()}>\n")

    @contextmanager
    def part(self, element: str, mark: str | None = None) -> Iterator[None]:
        """An element."""
        self._file.write(f"{' ' * self._depth}<{element}>\n")
        self._depth += 2
        yield
        self._depth -= 2
        self._file.write(f"{' ' * self._depth}</{element}>\n")

    def entry(self, key: str, value: str | float, element: str = "") -> None:
        """An element with its unit."""
        tag, text = element or key, escaped(_written(value))
        unit = self._unit(key, ' units="{}"')
        self._file.write(f"{' ' * self._depth}<{tag}{unit}>{text}</{tag.split()[0]}>\n")

    def comments(self, comments: Iterable[str]) -> None:
        """Comments, one by one."""
        for text in comments:
            self.entry("COMMENT", text)

    def grouped(
        self, entries: Iterable[tuple[str, str | float]], groups: Mapping[str, str | None]
    ) -> None:
        """Keywords and values; angles and rates of version 1 are numbered, with their axes."""
        for group, members in groupby(entries, key=lambda entry: groups.get(entry[0])):
            if group is None:
                self.entries(members)
                continue
            label = _LABELS.get(group)
            with self.part(group):
                for k, (key, value) in enumerate(members):
                    self.entry(key, value, f'rotation{k + 1} {label}="{key}"' if label else key)

    def row(self, element: str, count: int) -> str:
        """The text of a row, an element."""
        numbers_of_row = "%s" + " %r" * count
        return self.text_of(lambda out: out.entry(element, numbers_of_row))


# Group of numbered elements of XML -> attribute that names their axes.
_LABELS = {"rotationAngles": "angle", "rotationRates": "rate"}


def _written(value):
    return value if isinstance(value, str) else repr(value)


# Keywords of the meta data and comments of a segment, and the function that writes its data.
Segment: TypeAlias = tuple[Mapping[str, str], Sequence[str], Callable[[Generator], None]]


def write(
    path: FilePath,
    form: Form,
    version: str,
    header: tuple[Mapping[str, str], Sequence[str]],
    segments: Sequence[Segment],
    *,
    xml: bool = False,
) -> None:
    """Write a message, whose header has keywords and comments, whole or not at all."""
    for keywords, remarks in (header, *(segment[:2] for segment in segments)):
        refuse_line_breaks(*keywords.values(), *remarks)
    name = "the CIC file" if form.family == "CIC" else f"the {form.kind}"
    with written_whole(path, name) as file:
        out = (XmlGenerator if xml else Generator)(file, form, version)
        with out.message():
            with out.part("header"):
                out.comments(header[1])
                out.entries(header[0].items())
            with out.part("body"):
                for keywords, remarks, write_data in segments:
                    with out.part("segment"):
                        out.metadata(keywords, remarks)
                        with out.part("data"):
                            write_data(out)


def refuse_line_breaks(*texts: object) -> None:
    """AttitudeError for names or comments that are not one line of printable text each."""
    for text in texts:
        if not isinstance(text, str) or not text.isprintable() or len(text) > 4000:
            raise AttitudeError(
                f"{cut(str(text))} cannot be a name or a comment in a message; give one line of "
                "text."
            )
