"""CCSDS messages as blocks of keywords: read from KVN or XML by a table, and written in either.

A `Form` is the table of a kind of message.  Both notations are read into the same `Message`, by
calls of its `start`, `entry`, `row` and `stop`, and written by the same calls of a `Generator`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, TypeAlias

from attitude._textfiles import kvn
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import cut, is_number, opened
from attitude._textfiles.xml import MESSAGES, OUTSIDE, ElementReader, escaped
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath
    from attitude._textfiles.lines import Fault, Lines


@dataclass(frozen=True)
class Form:
    """What a kind of message may hold.

    kind: "AEM", "APM" or "ACM".
    versions, header, meta: the versions, and the keywords of the header and the meta data.
    blocks: block -> its keywords; one that ends in * stands for all that begin so.
    units: keyword -> units that may stand behind its value; a value without a unit is in the first.
    elements: element of XML -> block.
    rows: block with rows -> the element of XML that holds one.
    inner: block that stands inside of another one -> that one.
    once, repeated: blocks that a message has once, keywords that a block may have several times.
    old: keyword of version 1.0, whose blocks have no marks in KVN -> block, and keyword there.
    groups: elements of XML that stand between a block and its keywords.
    anywhere: keywords of the meta data that stand in a block of XML.
    marks: "metadata" and "data" -> what marks them in KVN, if there are marks.
    """

    kind: str
    versions: tuple[str, ...]
    header: tuple[str, ...]
    meta: tuple[str, ...] = ()
    blocks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    units: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    elements: Mapping[str, str] = field(default_factory=dict)
    rows: Mapping[str, str] = field(default_factory=dict)
    inner: Mapping[str, str] = field(default_factory=dict)
    once: tuple[str, ...] = ()
    repeated: tuple[str, ...] = ()
    old: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    groups: tuple[str, ...] = ()
    anywhere: tuple[str, ...] = ()
    marks: Mapping[str, str] = field(default_factory=dict)


class Block(dict[str, str]):
    """Keywords and values of a part of a message.

    name, line: the name, and the number of the line in which the block begins.
    lines: keyword -> number of its line.
    order: list of (keyword, value, line), all keywords in the order of the file, repeated ones too.
    tokens, places: the entries of all rows, and the line of each row.
    width: entries of a row; 0 before the first.
    message: the one that holds the block.
    """

    def __init__(self, name: str, line: int, message: Message):
        super().__init__()
        self.name: str = name
        self.line: int = line
        self.lines: dict[str, int] = {}
        self.order: list[tuple[str, str, int]] = []
        self.comments: list[str] = []
        self.tokens: list[bytes] = []
        self.places: list[int] = []
        self.width: int = 0
        self.inner: list[Block] = []
        self.message: Message = message

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
        """Add a keyword; AttitudeError for a repeated one, and behind rows."""
        if keyword in self and keyword not in self.message.form.repeated:
            raise self.message.fault(
                f"{cut(keyword, '')} is given twice, first in line {self.lines[keyword]}.", line
            )
        if self.tokens:
            raise self.message.fault(f"{keyword} stands behind the rows of its block.", line)
        self.order.append((keyword, value, line))
        self[keyword], self.lines[keyword] = value, line

    def needed(self, keyword: str) -> str:
        """The value of a keyword; AttitudeError if it is missing or empty."""
        if not self.get(keyword):
            raise self.fault(f"the {self.title} lack{'s' * self.is_block} {keyword}.")
        return self[keyword]

    @property
    def is_block(self) -> bool:
        """Whether this is a block, not the header or the meta data."""
        return self.name.isupper()

    @property
    def title(self) -> str:
        """The name in sentences."""
        return f"block {self.name}" if self.is_block else self.name

    def numbers(self, keyword: str, count: int = 1) -> list[float]:
        """The finite numbers of a keyword; a unit other than the standard's is refused."""
        value, unit = kvn.without_unit(self.needed(keyword))
        allowed = self.message.form.units.get(keyword, ())
        if unit and unit.replace(" ", "") not in allowed:
            known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
            raise self.fault(f"{keyword} is in {cut(unit)}{known}.", keyword)
        values = [_finite(word) for word in value.split()]
        if len(values) != count or not all(map(math.isfinite, values)):
            what = "a finite number" if count == 1 else f"{count} finite numbers"
            raise self.fault(f"{keyword} is {cut(value)}; give {what}.", keyword)
        return values

    def number(self, keyword: str) -> float:
        """The one finite number of a keyword; see `numbers`."""
        return self.numbers(keyword)[0]

    def one_of(self, keyword: str, choices: Iterable[str], usual: str | None = None) -> str:
        """The value of a keyword in upper case, out of some choices; AttitudeError for another."""
        value = self.get(keyword, usual)
        if value is None or value.upper() not in choices:
            state = "is missing" if value is None else f"is {cut(value)}"
            raise self.fault(
                f"{keyword} of the {self.title} {state}; it must be one of "
                f"{', '.join(cut(choice, '') for choice in choices)}.",
                keyword,
            )
        return value.upper()

    def row_fault(self, sentence: str, row: int) -> AttitudeError:
        """The error for a row, counted from 0."""
        return self.message.fault(sentence, self.places[row])


def _finite(word):
    return float(word) if is_number(word.encode("ascii", "replace")) else math.nan


class Message:
    """A message while it is read: header, meta data and blocks.

    fault: makes the error for a sentence and the number of a line.

    open: those that have begun and not ended.
    where: "header", "meta data" or "data"; "" in messages without marks between these.
    """

    def __init__(self, form: Form, version: str, path: str, fault: Fault):
        self.form: Form = form
        self.version: str = version
        self.path: str = path
        self.fault: Fault = fault
        self.header: Block = Block("header", 0, self)
        self.meta: Block = Block("meta data", 0, self)
        self.blocks: list[Block] = []
        self.open: list[Block] = []
        self.where: str = "header" if "metadata" in form.marks else ""
        self._old = form.old if version == "1.0" else {}

    def all(self, name: str) -> list[Block]:
        """The blocks of a name."""
        return [block for block in self.blocks if block.name == name]

    def start(self, name: str, line: int) -> None:
        """Begin a block, inside of another one or not."""
        outer, allowed = self.open[-1] if self.open else None, self.form.inner.get(name)
        if outer is not None and outer.name != allowed:
            raise self.fault(f"{name} begins before the end of {outer.name}.", line)
        if outer is None and allowed is not None:
            raise self.fault(f"{name} stands outside of {allowed}.", line)
        if name in self.form.once and self.all(name):
            raise self.fault(f"the message has a second block {name}; it may have one.", line)
        blocks = self.blocks if outer is None else outer.inner
        blocks.append(Block(name, line, self))
        self.open.append(blocks[-1])

    def stop(self, name: str, line: int) -> None:
        """End the innermost block, which must have this name."""
        if not self.open or self.open[-1].name != name:
            raise self.fault(f"{name}_STOP stands without {name}_START.", line)
        self.open.pop()

    def entry(self, keyword: str, value: str, line: int) -> None:
        """Add a keyword where the reader is; AttitudeError if it is not known there."""
        block = self.open[-1] if self.open else None
        if keyword == "COMMENT":
            common = self.header if self.where in ("header", "") else self.meta
            (common if block is None else block).comments.append(value)
        elif block is None and self._is_common(keyword):
            (self.header if keyword in self.form.header else self.meta).put(keyword, value, line)
        elif keyword in self._old:
            self._in_version_1(block, keyword, value, line)
        elif block is not None and self._is_known(keyword, block.name):
            block.put(keyword, value, line)
        else:
            raise self.fault(f"{cut(keyword, '')} is not known in {self._here()}.", line)

    def row(self, entries: list[bytes], line: int) -> None:
        """Add a row to the open block; AttitudeError for another number of entries than before."""
        block = self.open[-1]
        if block.width and len(entries) != block.width:
            raise self.fault(
                f"the row has {len(entries)} entries, and those before have {block.width}.", line
            )
        block.width = len(entries)
        block.tokens.extend(entries)
        block.places.append(line)

    def has_rows(self) -> bool:
        """Whether the open block may have rows."""
        return bool(self.open) and self.open[-1].name in self.form.rows

    def mark(self, mark: str, line: int) -> None:
        """Process a line of KVN with _START or _STOP."""
        name, _, end = mark.rpartition("_")
        if name == "META":
            steps = {("header", "START"): "meta data", ("meta data", "STOP"): "data", ("", end): ""}
            if (self.where, end) not in steps:
                raise self.fault(
                    f"{mark} stands in the wrong place; an {self.form.kind} has one META block.",
                    line,
                )
            self.where = steps[self.where, end]
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

    def refuse_open(self) -> None:
        """AttitudeError if the file ends inside of a block or before the data."""
        if self.open or self.where not in ("data", ""):
            name = self.open[-1].name if self.open else "META"
            raise self.fault(f"the file ends before {name}_STOP; is it cut off?", None)

    def _is_known(self, keyword, name):
        return any(
            keyword == known or (known.endswith("*") and keyword.startswith(known[:-1]))
            for known in self.form.blocks[name]
        )

    def _is_common(self, keyword):
        header, meta = keyword in self.form.header, keyword in self.form.meta
        return {"header": header, "meta data": meta, "": header or meta}.get(self.where, False)

    def _in_version_1(self, block, keyword, value, line):
        """Add a keyword of version 1.0 to its block; MAN_EPOCH_START begins a new maneuver."""
        name, known = self._old[keyword]
        if block is None:
            if not self.all(name) or keyword == "MAN_EPOCH_START":
                self.blocks.append(Block(name, line, self))
            block = self.all(name)[-1]
        if block.name != name:
            raise self.fault(f"{keyword} is not known in {self._here()}.", line)
        block.put(known, value, line)

    def _here(self):
        """Where the reader is, and what is known there."""
        form = self.form
        if self.open:
            name = self.open[-1].name
            old = [keyword for keyword, (block, _) in self._old.items() if block == name]
            place, known = f"the block {name}", old or form.blocks[name]
        elif self.where == "data":
            return f"an {form.kind} outside of a block"
        else:
            place = f"the {self.where or 'header and the meta data'} of an {form.kind}"
            header, meta = (self.where in (name, "") for name in ("header", "meta data"))
            known = (*form.header * header, *form.meta * meta)
        return f"{place} of version {self.version}; known are {', '.join(known)}"


def read(path: FilePath, form: Form) -> Message:
    """A message in KVN or XML, recognized by the content."""
    with opened(path) as lines:
        first = kvn.first(lines)
        if first is not None:
            return _of_kvn(lines, first, form)
    reader = _MessageReader(path, form)
    reader.run()
    if reader.message is None:
        raise reader.fault(f"there is no <{form.kind.lower()}> message in it.")
    message: Message = reader.message
    return message


def _of_kvn(lines: Lines, first: bytes, form: Form) -> Message:
    version = kvn.version(lines, first, form.kind, form.versions)
    message = Message(form, version, lines.path, lines.fault)
    for line in lines:
        text = line.strip()
        if text.endswith((b"_START", b"_STOP")) and b"=" not in text and b" " not in text:
            message.mark(text.decode("ascii", "replace"), lines.number)
        elif not text:
            continue
        elif message.has_rows() and b"=" not in text and text[:1] in b"+-.0123456789":
            message.row(text.split(), lines.number)  # it begins with a number or a date
        else:
            message.entry(*kvn.pair(lines, line), lines.number)
    message.refuse_open()
    return message


_PLACES = {"header": "header", "metadata": "meta data", "data": "data"}
_OUTER = ("ndm", "body", "segment", *_PLACES)


class _MessageReader(ElementReader):
    """Collects the message; `_tags` are the tags of the open elements and the blocks they begin."""

    def __init__(self, path, form):
        super().__init__(path)
        self._form = form
        self._tags, self._attributes, self._comments = [], {}, []

    def begin(self, tag, attributes):
        form, message, name = self._form, self.message, None
        if tag in MESSAGES or (message is None and tag not in OUTSIDE):
            version = self.version(tag, attributes, form.kind.lower(), form.versions)
            self.message = Message(form, version, self.path, self.fault)
            self.message.header.comments.extend(self._comments)
        elif tag in form.elements:
            outer = message.open[-1].name if message.open else None
            if self._above() == "data" or form.inner.get(form.elements[tag], "") == outer:
                name = form.elements[tag]
                message.start(name, self.line)
        elif tag in _PLACES and message is not None and message.where:
            message.where = _PLACES[tag]
        self._tags.append((tag, name))
        self._attributes = attributes

    def _above(self):
        return self._tags[-1][0] if self._tags else None

    def end(self, tag, text):
        name, message = self._tags.pop()[1], self.message
        if message is None:
            self._comments += [text] if tag == "COMMENT" else []
        elif name is not None:
            message.stop(name, self.line)
        elif tag not in (*_OUTER, self._form.kind.lower(), *self._form.groups):
            self._leaf(message, tag, text)

    def _leaf(self, message, tag, text):
        form, unit = self._form, self._attributes.get("units")
        label = self._attributes.get("angle") or self._attributes.get("rate")
        if message.has_rows() and tag == form.rows[message.open[-1].name]:
            message.row(text.encode("ascii", "replace").split(), self.line)
            return
        if tag.startswith("rotation") and label in form.repeated:
            tag = label
        elif tag == "USER_DEFINED":
            tag = f"USER_DEFINED_{self._attributes.get('parameter', '')}"
        if tag in form.anywhere and tag not in message.meta:
            message.meta.put(tag, text, self.line)
        elif not message.open and self._above() not in ("header", "metadata") and tag != "COMMENT":
            raise self.fault(f"<{tag[:40]}> stands outside of a block.")
        else:
            message.entry(tag, text if unit is None else f"{text} [{unit}]", self.line)


# ---- Writing

_SCHEMAS = {"1.0": "2.0.0-master-2.0", "2.0": "4.0.0-master-4.0"}


class Generator:
    """Writes a message in KVN to an open file."""

    def __init__(self, file: IO[str], form: Form, version: str):
        self._file, self._form, self._version = file, form, version

    def write(self, text: str) -> None:
        """Write a text as it is."""
        self._file.write(text)

    @contextmanager
    def message(self) -> Iterator[None]:
        """The message around its parts."""
        self._file.write(f"CCSDS_{self._form.kind}_VERS = {self._version}\n")
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
        self._file.write(f"{key} = {_shown(value)}{self._unit(key, ' [{}]')}\n")

    def comments(self, comments: Iterable[str]) -> None:
        """Comments, one by one."""
        self._file.writelines(f"COMMENT {text}\n" for text in comments)

    def entries(self, entries: Iterable[tuple[str, str | float]]) -> None:
        """Keywords and values, with their units."""
        for key, value in entries:
            self.entry(key, value)

    def rows(self, texts: Iterable[str], element: str) -> None:
        """Rows, each an element of XML."""
        self._file.writelines(f"{text}\n" for text in texts)

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
        tag, text = element or key, escaped(_shown(value))
        unit = self._unit(key, ' units="{}"')
        self._file.write(f"{' ' * self._depth}<{tag}{unit}>{text}</{tag.split()[0]}>\n")

    def comments(self, comments: Iterable[str]) -> None:
        """Comments, one by one."""
        for text in comments:
            self.entry("COMMENT", text)

    def rows(self, texts: Iterable[str], element: str) -> None:
        """Rows, each an element of XML."""
        for text in texts:
            self.entry(element, text)


def _shown(value):
    return value if isinstance(value, str) else repr(value)


# Keywords of the meta data and comments of a segment, and the function that writes its data.
Segment: TypeAlias = tuple[Mapping[str, str], Sequence[str], Callable[[Generator], None]]


def write(
    path: FilePath,
    name: str,
    form: Form,
    version: str,
    header: Mapping[str, str],
    comments: Sequence[str],
    segments: Iterable[Segment],
    *,
    xml: bool,
) -> None:
    """Write a message to a file that appears whole or not at all; `name` is that in errors."""
    segments = list(segments)
    refuse_line_breaks(*header.values(), *comments)
    for keywords, remarks, _ in segments:
        refuse_line_breaks(*keywords.values(), *remarks)
    with written_whole(path, name) as file:
        out = (XmlGenerator if xml else Generator)(file, form, version)
        with out.message():
            with out.part("header"):
                out.comments(comments)
                out.entries(header.items())
            with out.part("body"):
                for keywords, remarks, write_data in segments:
                    with out.part("segment"):
                        with out.part("metadata"):
                            out.comments(remarks)
                            out.entries(keywords.items())
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
