"""XML from untrusted files: no document type, no entities, no external references.

expat, the standard library's parser, fetches nothing by itself and knows entities only from a
document type declaration; a file that has one is refused before anything in it is read.
"""

import os
from xml.parsers import expat

from attitude.errors import AttitudeError
from attitude.textfiles.lines import unreadable

_PIECE = 1 << 20
_DEEPEST = 32
_LONGEST = 20_000


# Messages that CCSDS 505.0-B-3 knows, and what may stand around one.
MESSAGES = ("acm", "aem", "apm", "cdm", "ocm", "oem", "omm", "opm", "rdm", "tdm")
OUTSIDE = ("ndm", "COMMENT", "MESSAGE_ID")


class Events:
    """Calls `begin(tag, attributes)` and `end(tag, text)` of a subclass for each element.

    `message` is what a subclass makes of the file, None before the message begins; `line` is the
    line of the file where the parser stands.  A subclass may keep pieces of the file from the
    parser (`take`) if it counts their lines (`skipped`).
    """

    def __init__(self, path):
        self.path, self.message = os.fspath(path), None
        self.fed = self.skipped = 0
        self._depth = 0
        self._text, self._length = [], 0
        self._error = None
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

    @property
    def line(self):
        return self._parser.CurrentLineNumber + self.skipped

    @property
    def place(self):
        """Of all the bytes that the parser was fed, that at which the present tag begins."""
        return self._parser.CurrentByteIndex

    def fault(self, sentence, line=None):
        return AttitudeError(f"{self.path}, line {line or self.line}: {sentence}")

    def version(self, tag, attributes, kind, known):
        """The version that the element tells with which a message of some kind begins."""
        found = attributes.get("version")
        if tag != kind or found not in known:
            raise self.fault(
                f"its outermost element is <{tag[:40]}> of version {found!r}; an {kind.upper()} is "
                f'<{kind} id="CCSDS_{kind.upper()}_VERS" version="{" or ".join(known)}">.'
            )
        if self.message is not None:
            raise self.fault("it holds several messages; write each into a file of its own.")
        return found

    def run(self):
        """Parse the file."""
        try:
            with open(self.path, "rb") as file:
                self._parse(iter(lambda: file.read(_PIECE), b""))
        except OSError as err:
            raise unreadable(self.path, err) from err

    def run_text(self, text):
        """Parse a text in place of the file: the encoding that it declares does not matter."""
        self._parse([text])

    def _parse(self, pieces):
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
            raise self.fault(f"its encoding cannot be read ({err}); give UTF-8.") from err

    def take(self, piece, last=False):
        """What the file holds, piece by piece; the last one is empty."""
        self.feed(piece, last)

    def feed(self, piece, last=False):
        """Give a piece to the parser."""
        self.fed += len(piece)
        self._parser.Parse(piece, last)

    def _start(self, tag, attributes):
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self.fault(f"its elements are nested deeper than {_DEEPEST}.")
        self._text, self._length = [], 0
        self.begin(tag, attributes)

    def _stop(self, tag):
        self._depth -= 1
        text = "".join(self._text).strip() if self._text else ""
        self._text, self._length = [], 0
        self.end(tag, text)

    def _characters(self, text):
        self._length += len(text)
        if self._length > _LONGEST:
            raise self.fault(f"a text in it is longer than {_LONGEST} characters.")
        self._text.append(text)

    def _refuse_document_type(self, *_):
        raise self.fault(
            "it has a document type declaration, which can define entities and external "
            "references; such files are refused. CCSDS messages have none: delete it."
        )

    def _refuse_entities(self, *_):
        raise self.fault("it refers to an entity; such files are refused: write its text.")


def records(text, name, tag):
    """Of each element of a tag, in their order, the texts of its leaves: [{tag: text}, ...].

    Where a leaf is repeated in the element, the last one counts.

    Parameters
    ----------
    text : str
    name : str
        What stands for the file in the messages.
    tag : str

    >>> records("<a><b><c>1</c><d>x &amp; y</d></b><b/></a>", "text", "b")
    [{'c': '1', 'd': 'x & y'}, {'b': ''}]
    """
    reader = _Records(name, tag)
    reader.run_text(text)
    return reader.found


class _Records(Events):
    """Collects the leaves of the elements of one tag."""

    def __init__(self, name, tag):
        super().__init__(name)
        self._tag, self._open, self._is_leaf = tag, [], False
        self.found = []

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


def escaped(text):
    """Text as it stands between tags."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
