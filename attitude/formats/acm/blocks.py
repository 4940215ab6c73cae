"""Attitude Comprehensive Messages in KVN and XML, read into blocks of keywords and rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from attitude.formats.acm.keywords import BLOCKS, META, ONCE, ROWS, VERSIONS
from attitude.formats.ccsds.attitude_types import HEADER
from attitude.textfiles import kvn
from attitude.textfiles.lines import cut
from attitude.textfiles.xml import MESSAGES, OUTSIDE, ElementReader

if TYPE_CHECKING:
    from attitude.annotations import FilePath
    from attitude.textfiles.lines import Fault, Lines

_USER = "USER_DEFINED_"


@dataclass
class AcmBlock:
    """A block of a message.

    Attributes
    ----------
    name : str
        One of BLOCKS.
    line : int
        Number of the line in which it begins.
    values, lines : dict
        Keyword -> value, and -> number of its line.
    comments : list of str
    tokens, places : list of bytes, list of int
        The entries of all rows, and the line of each row.
    width : int
        Entries of a row; 0 before the first.
    inner : list of AcmBlock
        Sensors.
    """

    name: str
    line: int
    values: dict[str, str] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    tokens: list[bytes] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    width: int = 0
    inner: list[AcmBlock] = field(default_factory=list)


class CollectedAcm:
    """A message while it is read.

    Parameters
    ----------
    path : str
    fault : callable
        Makes the error for a sentence and the number of a line.

    Attributes
    ----------
    path, fault
        As given.
    header, meta, lines : dict
        Keyword -> value; of both -> number of its line.
    comments, meta_comments : list of str
    blocks : list of AcmBlock
    """

    def __init__(self, path: str, fault: Fault):
        self.path: str = path
        self.fault: Fault = fault
        self.header: dict[str, str] = {}
        self.meta: dict[str, str] = {}
        self.lines: dict[str, int] = {}
        self.comments: list[str] = []
        self.meta_comments: list[str] = []
        self.blocks: list[AcmBlock] = []

    def put_common(self, where: str, keyword: str, value: str, line: int) -> None:
        """Add a keyword of the header or the meta data; AttitudeError if unknown or repeated."""
        into, known = (self.header, HEADER) if where == "header" else (self.meta, META)
        if keyword not in known:
            raise self.fault(
                f"{cut(keyword, '')} is not known in the {where} of an ACM; known are "
                f"{', '.join(known)}.",
                line,
            )
        if keyword in into:
            raise self.fault(f"{keyword} is given twice.", line)
        into[keyword], self.lines[keyword] = value, line

    def put(self, block: AcmBlock, keyword: str, value: str, line: int) -> None:
        """Add a keyword to a block; AttitudeError if it is unknown, repeated or behind rows."""
        known = BLOCKS[block.name]
        if keyword not in known and not (block.name == "USER" and keyword.startswith(_USER)):
            listed = ", ".join(known) or f"those that begin with {_USER}"
            raise self.fault(
                f"{cut(keyword, '')} is not known in the block {block.name}; known are {listed}.",
                line,
            )
        if keyword in block.values:
            raise self.fault(
                f"{cut(keyword, '')} is given twice, first in line {block.lines[keyword]}.", line
            )
        if block.tokens:
            raise self.fault(f"{keyword} stands behind the rows of its block.", line)
        block.values[keyword], block.lines[keyword] = value, line

    def row(self, block: AcmBlock, entries: list[bytes], line: int) -> None:
        """Add a row to a block; AttitudeError for another number of entries than before."""
        if block.width and len(entries) != block.width:
            raise self.fault(
                f"the row has {len(entries)} entries, and those before have {block.width}.", line
            )
        block.width = len(entries)
        block.tokens.extend(entries)
        block.places.append(line)

    def begin(self, name: str, outer: AcmBlock | None, line: int) -> AcmBlock:
        """Begin a block, inside of another one (a sensor) or not."""
        if outer is not None:
            if outer.name != "AD" or name != "SENSOR":
                raise self.fault(f"{name} begins before the end of {outer.name}.", line)
            outer.inner.append(AcmBlock(name, line))
            return outer.inner[-1]
        if name == "SENSOR":
            raise self.fault("SENSOR stands outside of AD.", line)
        if name in ONCE and any(block.name == name for block in self.blocks):
            raise self.fault(f"the message has a second block {name}; it may have one.", line)
        self.blocks.append(AcmBlock(name, line))
        return self.blocks[-1]


def read_kvn(lines: Lines, first: bytes) -> CollectedAcm:
    """The message of an ACM in KVN; `first` is the first line that is not empty.

    Raises
    ------
    AttitudeError
        For lines that are not KVN, and unknown, misplaced or repeated keywords and blocks.
    """
    kvn.version(lines, first, "ACM", VERSIONS)
    message = CollectedAcm(lines.path, lines.fault)
    where = "header"
    open_blocks: list[AcmBlock] = []
    for line in lines:
        text = line.strip()
        if not text:
            continue
        mark = text.decode("ascii", "replace")
        if mark.endswith(("_START", "_STOP")) and "=" not in mark and " " not in mark:
            where = _marked(message, mark, where, open_blocks, lines.number)
            continue
        block = open_blocks[-1] if open_blocks else None
        if block is not None and block.name in ROWS and _is_row(text):
            message.row(block, text.split(), lines.number)
            continue
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            comments = message.comments if where == "header" else message.meta_comments
            (comments if block is None else block.comments).append(value)
        elif block is not None:
            message.put(block, keyword, value, lines.number)
        elif where in ("header", "meta data"):
            message.put_common(where, keyword, value, lines.number)
        else:
            raise lines.fault(f"{cut(keyword, '')} stands outside of a block.")
    if open_blocks or where != "data":
        name = open_blocks[-1].name if open_blocks else "META"
        raise lines.fault(f"the file ends before {name}_STOP; is it cut off?")
    return message


def _is_row(text):
    """Whether a line is a row: it begins with a number or a date."""
    return b"=" not in text and text[:1] in b"+-.0123456789"


def _marked(message, mark, where, open_blocks, line):
    """Where the reader is after a line with _START or _STOP; changes `open_blocks`."""
    name, _, end = mark.rpartition("_")
    if name == "META":
        if (where, end) == ("header", "START"):
            return "meta data"
        if (where, end) == ("meta data", "STOP"):
            return "data"
        raise message.fault(f"{mark} stands in the wrong place; an ACM has one META block.", line)
    if name not in BLOCKS:
        raise message.fault(
            f"{cut(mark, '')} is not known; blocks are META, {', '.join(BLOCKS)}.", line
        )
    if where != "data":
        raise message.fault(f"{mark} stands before META_STOP.", line)
    if end == "START":
        outer = open_blocks[-1] if open_blocks else None
        open_blocks.append(message.begin(name, outer, line))
    elif not open_blocks or open_blocks[-1].name != name:
        raise message.fault(f"{mark} stands without {name}_START.", line)
    else:
        open_blocks.pop()
    return "data"


# XML ----------------------------------------------------------------------------------------------

_OUTER = ("acm", "ndm", "header", "body", "segment", "metadata", "data")


def read_xml(path: FilePath) -> CollectedAcm:
    """The message of an ACM in XML.

    Raises
    ------
    AttitudeError
        For a file that cannot be read or is not well-formed, and as `read_kvn`.
    """
    reader = _AcmReader(path)
    reader.run()
    if reader.message is None:
        raise reader.fault("there is no <acm> message in it.")
    found: CollectedAcm = reader.message
    return found


class _AcmReader(ElementReader):
    """Collects the message; `_tags` are those of the open elements, `_open` the open blocks."""

    def __init__(self, path):
        super().__init__(path)
        self._tags, self._open, self._attributes = [], [], {}
        self._comments = []

    def begin(self, tag, attributes):
        if tag in MESSAGES or (self.message is None and tag not in OUTSIDE):
            self.version(tag, attributes, "acm", VERSIONS)
            self.message = CollectedAcm(self.path, self.fault)
            self.message.comments.extend(self._comments)
        elif self._is_block(tag):
            outer = self._open[-1] if self._open else None
            self._open.append(self.message.begin(tag.upper(), outer, self.line))
        self._tags.append(tag)
        self._attributes = attributes

    def _is_block(self, tag):
        # Orekit writes <SENSOR>.
        if self._tags[-1:] == ["ad"]:
            return tag.lower() == "sensor"
        return self._tags[-1:] == ["data"] and tag.islower() and tag.upper() in BLOCKS

    def end(self, tag, text):
        self._tags.pop()
        if self.message is None:
            self._comments += [text] if tag == "COMMENT" else []
            return
        if tag in _OUTER:
            return
        above, block = self._tags[-1:], self._open[-1] if self._open else None
        if block is not None and tag.lower() == block.name.lower():
            self._open.pop()
        elif tag == "COMMENT":
            comments = self.message.meta_comments if above == ["metadata"] else None
            comments = self.message.comments if comments is None else comments
            (comments if block is None else block.comments).append(text)
        elif block is not None:
            self._in_block(block, tag, text)
        elif above == ["header"]:
            self.message.put_common("header", tag, text, self.line)
        elif above == ["metadata"]:
            self.message.put_common("meta data", tag, self._value(text), self.line)
        else:
            raise self.fault(f"<{tag[:40]}> stands outside of a block.")

    def _in_block(self, block, tag, text):
        if tag == ROWS.get(block.name):
            self.message.row(block, text.encode("ascii", "replace").split(), self.line)
        elif block.name == "USER" and tag == "USER_DEFINED":
            keyword = _USER + self._attributes.get("parameter", "")
            self.message.put(block, keyword, text, self.line)
        else:
            self.message.put(block, tag, self._value(text), self.line)

    def _value(self, text):
        unit = self._attributes.get("units")
        return text if unit is None else f"{text} [{unit}]"
