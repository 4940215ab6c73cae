"""XML from untrusted files: no document type, no entities, no external references.

expat, the parser of the standard library, fetches nothing by itself and knows entities only from a
document type declaration; a file that has one is refused before its elements are read.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any
from xml.parsers import expat

from attitude._textfiles.lines import cut, unreadable
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


_PIECE = 1 << 20
_DEEPEST = 32
# Longest tag, characters: sentences repeat them.
_LONGEST_TAG = 100
_LONGEST = 20_000


class ElementReader:
    """Base of readers of XML: calls `begin` and `end` of a subclass, tags without namespaces.

    A subclass that interprets parts of the file itself overrides `take`, and adds the lines of
    these parts to `skipped`.  `message` is what it makes of the file.
    """

    def __init__(self, path: str | os.PathLike[str]):
        self.path: str = os.fspath(path)
        self.message: Any = None
        self.fed: int = 0
        self.skipped: int = 0
        self._depth = 0
        self._text: list[str] = []
        self._length = 0
        parser = self._parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
        parser.StartDoctypeDeclHandler = self._refuse_document_type
        parser.EntityDeclHandler = self._refuse_entities
        parser.ExternalEntityRefHandler = self._refuse_entities
        parser.SkippedEntityHandler = self._refuse_entities
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._stop
        parser.CharacterDataHandler = self._characters

    def begin(self, tag: str, attributes: dict[str, str]) -> None:
        """Called at the start tag of each element."""
        raise NotImplementedError(f"{type(self).__name__} defines no begin")

    def end(self, tag: str, text: str) -> None:
        """Called at the end tag of each element, with the text behind the last tag before it."""
        raise NotImplementedError(f"{type(self).__name__} defines no end")

    @property
    def line(self) -> int:
        """Number of the line of the file at which the parser is, counted from 1."""
        return self._parser.CurrentLineNumber + self.skipped

    @property
    def place(self) -> int:
        """Offset of the current tag among the bytes that the parser was given."""
        return self._parser.CurrentByteIndex

    def fault(self, sentence: str, line: int | None = None) -> AttitudeError:
        """An AttitudeError that begins with the name of the file and the number of the line."""
        return AttitudeError(f"{self.path}, line {line or self.line}: {sentence}")

    def version(self, tag: str, attributes: dict[str, str], kind: str, known: Sequence[str]) -> str:
        """The version of a message, from its outermost element."""
        number = attributes.get("version")
        if tag != kind or number is None or number not in known:
            raise self.fault(
                f"its outermost element is <{tag[:40]}> of version {cut(number)}; an "
                f'{kind.upper()} is <{kind} id="CCSDS_{kind.upper()}_VERS" '
                f'version="{" or ".join(known)}">.'
            )
        if self.message is not None:
            raise self.fault("it holds several messages; write each into a file of its own.")
        return number

    def run(self) -> None:
        """Parse the file."""
        try:
            with open(self.path, "rb") as file:
                self._parse(iter(lambda: file.read(_PIECE), b""))
        except OSError as err:
            raise unreadable(self.path, err) from err

    def run_text(self, text: str) -> None:
        """Parse a text instead of the file; the encoding that it declares has no effect."""
        self._parse([text])

    def _parse(self, pieces: Iterable[bytes | str]) -> None:
        try:
            for piece in pieces:
                self.take(piece)
            self.take(b"", last=True)
        except expat.ExpatError as err:
            raise self.fault(
                f"it is not well-formed XML ({expat.ErrorString(err.code)}).",
                err.lineno + self.skipped,
            ) from err
        except (LookupError, ValueError) as err:
            if isinstance(err, AttitudeError):
                raise
            raise self.fault(f"its encoding cannot be read ({cut(err, '')}); give UTF-8.") from err

    def take(self, piece: Any, last: bool = False) -> None:
        """Process the next piece of the file, bytes or str; the last one is empty."""
        self.feed(piece, last)

    def feed(self, piece: bytes | str, last: bool = False) -> None:
        """Give a piece to the parser."""
        self.fed += len(piece)
        self._parser.Parse(piece, last)

    def _start(self, tag, attributes):
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self.fault(f"its elements are nested deeper than {_DEEPEST}.")
        if len(tag) > _LONGEST_TAG:
            raise self.fault(f"the tag {cut(tag)} is longer than {_LONGEST_TAG} characters.")
        self._text, self._length = [], 0
        self.begin(tag.rpartition(":")[2], attributes)

    def _stop(self, tag):
        self._depth -= 1
        text = "".join(self._text).strip() if self._text else ""
        self._text, self._length = [], 0
        self.end(tag.rpartition(":")[2], text)

    def _characters(self, text):
        self._length += len(text)
        if self._length > _LONGEST:
            raise self.fault(f"a text in it is longer than {_LONGEST} characters.")
        self._text.append(text)

    def _refuse_document_type(self, *_):
        raise self.fault(
            "it has a document type declaration, which can define entities and external "
            "references; such files are refused. No format that is read here needs one: delete it."
        )

    def _refuse_entities(self, *_):
        raise self.fault("it refers to an entity; such files are refused: write its text.")


def records(text: str, name: str, tag: str) -> list[dict[str, str]]:
    """The texts of the leaves of each element with a tag; of repeated leaves the last one counts.

    >>> records("<a><b><c>1</c><d>x &amp; y</d></b><b/></a>", "text", "b")
    [{'c': '1', 'd': 'x & y'}, {'b': ''}]
    """
    reader = _LeafReader(name, tag)
    reader.run_text(text)
    return reader.found


class _LeafReader(ElementReader):
    """Collects the leaves of the elements with one tag."""

    def __init__(self, name: str, tag: str):
        super().__init__(name)
        self._tag = tag
        self._open: list[dict[str, str]] = []
        self._is_leaf = False
        self.found: list[dict[str, str]] = []

    def begin(self, tag, attributes):
        self._is_leaf = True
        if tag == self._tag:
            self._open.append({})
            self.found.append(self._open[-1])

    def end(self, tag, text):
        if self._is_leaf:
            for record in self._open:
                record[tag] = text
        self._is_leaf = False
        if tag == self._tag:
            self._open.pop()


def escaped(text: str) -> str:
    """A text as it stands between tags, with references for &, < and >."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
