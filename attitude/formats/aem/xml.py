"""Attitude Ephemeris Messages in XML, read.

The elements are those of CCSDS 505.0-B-1 and 505.0-B-2 (section 4.8) for version 1.0, and of CCSDS
504.0-B-2, section 7, with CCSDS 505.0-B-3, for version 2.0.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from attitude.formats.aem import elements
from attitude.formats.aem.message import Message, MessageSegment
from attitude.formats.aem.xml_records import pattern_of
from attitude.formats.ccsds import attitude_types
from attitude.formats.ccsds.attitude_types import HEADER, VERSIONS
from attitude.textfiles.lines import NoNumber, cut, numbers
from attitude.textfiles.xml import MESSAGES, OUTSIDE, ElementReader

if TYPE_CHECKING:
    from attitude.annotations import FilePath
    from attitude.attitude_table.table import AttitudeTable
    from attitude.formats.aem.message import Options

_BATCH = 4096
_BEGIN, _END = b"<attitudeState>", b"</attitudeState>"
# Longest incomplete record, bytes, that is kept back from the parser until its end is read, so that
# a pattern can match it.
_LONGEST_RECORD = 1 << 16
# Layouts of records in one file for which patterns are compiled.
_MOST_PATTERNS = 50


def read(path: FilePath, options: Options) -> AttitudeTable:
    """The AttitudeTable of an AEM in XML; see `aem.read`."""
    reader = _AemReader(path, options)
    reader.run()
    if not reader.done:
        raise reader.fault("there is no <aem> message in it.")
    return reader.message.table()


class _AemReader(ElementReader):
    """Collects the message; records that differ from the last one in their texts match a pattern.

    `_tags` are the tags of the open elements, `_comments` the comments before the message, `_rest`
    the bytes that are kept back from the parser.
    """

    def __init__(self, path, options):
        super().__init__(path)
        self._options = options
        self._segment = self._record = None
        self._tags = []
        self._attributes = {}
        self._comments = []
        self._rest, self._pattern = b"", None
        self._patterns, self._ended_at = {}, 0
        self.done = False

    def take(self, piece, last=False):
        """Match records that follow a parsed one; give everything else to the parser."""
        buffer, at = self._rest + piece, 0
        self._rest = b""
        while True:
            if self._pattern is not None:
                at = self._match_records(buffer, at)
            end = buffer.find(_END, at) + len(_END)
            if end < len(_END):
                break
            start = buffer.rfind(_BEGIN, at, end)
            self.feed(buffer[at:end])
            self._pattern = self._pattern_of(buffer[start:end]) if start >= 0 else None
            at = end
        # The beginning of a record is kept until its end is read, up to some length.
        start = buffer.find(b"<", at) if self._pattern is not None else buffer.find(_BEGIN, at)
        if start < 0:
            start = len(buffer)
        elif last or len(buffer) - start > _LONGEST_RECORD:
            start, self._pattern = len(buffer), None
        self.feed(buffer[at:start], last)
        self._rest = buffer[start:]

    def _pattern_of(self, record):
        """The pattern of the last record, if the parser has just finished it."""
        if self._ended_at + len(_END) != self.fed:
            return None
        source = pattern_of(record, 1 + len(self._order))
        if source is not None and source not in self._patterns:
            if len(self._patterns) >= _MOST_PATTERNS:
                return None
            self._patterns[source] = re.compile(source)
        return self._patterns.get(source)

    def _match_records(self, buffer, at):
        """Add the records that match the pattern; the offset of the first that does not."""
        match, tokens, lines, line = self._pattern.match, [], [], self.line
        while found := match(buffer, at):
            tokens += found.groups()
            line += buffer.count(b"\n", at, found.end())
            lines.append(line)
            at = found.end()
        if lines:
            self._flush()
            self.skipped += line - self.line
            epoch, names = self._epoch_at, self._names()
            try:
                values = numbers(tokens, 1 + len(names), self._order)
            except NoNumber as err:
                raise self.fault(
                    f"{names[err.column]} is {err.shown}, which is no number.", lines[err.line]
                ) from err
            self._segment.rows.add(tokens[epoch :: 1 + len(names)], values, lines, self.fault)
        return at

    def begin(self, tag, attributes):
        if self._record is not None:
            pass
        elif tag in MESSAGES or (self.message is None and tag not in OUTSIDE):
            version = self.version(tag, attributes, "aem", VERSIONS)
            self.message = Message(self.path, version, self._options, comments=self._comments)
        elif tag == "segment":
            self._segment = MessageSegment(self.message, self.fault)
            self._rows, self._tokens, self._lines = [], [], []
        elif tag == "data":
            if self._segment is None or self._segment.rows is None:
                raise self.fault("<data> stands before the end of <metadata>.")
        elif tag == "attitudeState":
            if self._segment is None or self._segment.rows is None:
                raise self.fault("<attitudeState> stands outside of <data>.")
            self._record, self._epoch, self._letters = {}, None, {}
            self._columns = attitude_types.COLUMNS[self._segment.kind]
        self._attributes = attributes
        self._tags.append(tag)

    def end(self, tag, text):
        self._tags.pop()
        above = self._tags[-1] if self._tags else None
        if self._record is not None:
            self._in_record(tag, text, above)
        elif above == "header":
            self._in_header(tag, text)
        elif above == "ndm" and tag == "COMMENT":
            self._comments.append(text)
        elif above == "metadata":
            self._in_metadata(tag, text)
        elif tag == "metadata" and self._segment is not None:
            self._segment.begin(self.line)
        elif above == "data":
            self._in_data(tag, text)
        elif tag == "segment" and self._segment is not None:
            if self._segment.rows is None:
                raise self.fault("the segment has no <metadata>.")
            self._flush()
            self._segment.finish(self.line)
            self._segment = None
        elif tag == "aem":
            if not self.message.tables:
                raise self.fault("the message has no <segment>.")
            self.done = True

    def _in_header(self, tag, text):
        if tag == "COMMENT":
            self.message.comments.append(text)
        elif tag in HEADER and tag not in self.message.header:
            self.message.header[tag] = text
        else:
            raise self.fault(f"<{tag}> does not belong into the header, or not twice.")

    def _in_metadata(self, tag, text):
        if self._segment is None:
            raise self.fault("<metadata> stands outside of a <segment>.")
        if tag == "COMMENT":
            self._segment.comments.append(text)
        else:
            self._segment.add(tag, text, self.line)

    def _in_data(self, tag, text):
        if tag != "COMMENT":
            raise self.fault(f"<{tag}> does not belong into <data>; an AEM has <attitudeState>.")
        self._segment.data_comments.append(text)

    def _in_record(self, tag, text, above):
        if tag in self._columns:
            self._put(tag, text)
        elif tag == "attitudeState":
            self._finish_record()
        elif tag == "EPOCH":
            if self._epoch is not None:
                raise self.fault("the record has two epochs.")
            self._epoch, self._epoch_at = text.encode("ascii", "replace"), len(self._record)
        elif text:
            self._put(self._name(tag, above), text)
        elif tag not in elements.RECORDS and tag not in elements.GROUPS:
            raise self.fault(f"<{tag}> is empty or not known among the records.")

    def _name(self, tag, above):
        """The name of the column that an element holds."""
        if tag in ("rotation1", "rotation2", "rotation3"):
            if above == "rotationAngles":
                return f"ANGLE_{tag[-1]}"
            place = int(tag[-1]) - 1
            self._letters[place] = self._attributes.get("rate", "")[:1].upper()
            return f"ANGVEL_{'XYZ'[place]}"
        return tag

    def _put(self, name, text):
        if name not in self._columns or name in self._record:
            raise self.fault(
                f"{name} does not belong into a record of "
                f"{self._segment.values['ATTITUDE_TYPE']}, or not twice."
            )
        given, unit = self._attributes.get("units"), elements.unit(name)
        if given and given != unit:
            raise self.fault(f"{name} is given in {cut(given)}; it must be in {unit or 'no unit'}.")
        try:
            self._record[name] = float(text)
        except ValueError as err:
            raise self._no_number(name, text) from err
        if "_" in text:  # which Python takes for a separator of digits
            raise self._no_number(name, text)

    def _no_number(self, name, text):
        return self.fault(f"{name} is {text[:40]!r}, which is no number.")

    def _finish_record(self):
        names = self._columns
        if self._epoch is None or len(self._record) < len(names):
            lacking = [name for name in names if name not in self._record]
            if self._epoch is None:
                lacking.insert(0, "EPOCH")
            raise self.fault(f"the record lacks {', '.join(lacking)}.")
        if self._letters:
            self._name_rates()
        names = self._names()
        self._rows.append([self._record[name] for name in names])
        self._tokens.append(self._epoch)
        self._lines.append(self.line)
        # The places of its texts, which are those of following records that match its pattern.
        places = {name: k + (k >= self._epoch_at) for k, name in enumerate(self._record)}
        self._order, self._ended_at = [places[name] for name in names], self.place
        self._record = None
        if len(self._rows) == _BATCH:
            self._flush()

    def _name_rates(self):
        """Give the rates of version 1, which stand in the record by number, the axes they name."""
        segment = self._segment
        letters = "".join(self._letters.get(k, "") for k in range(3))
        if len(letters) == 3 and len(set(letters)) < 3:
            segment.take_derivatives()
        usual = segment.how.sequence.upper() if segment.how.rates_of_angles else "XYZ"
        letters = letters or usual
        places = attitude_types.rates_by_axis(letters, usual)
        if places is None:
            raise self.fault(f"the rates are those of {', '.join(letters)}, not of {usual}.")
        names = {f"ANGVEL_{'XYZ'[k]}": f"ANGVEL_{'XYZ'[places.index(k)]}" for k in range(3)}
        self._record = {names.get(name, name): value for name, value in self._record.items()}

    def _names(self):
        """The columns in the order of the rows."""
        return (
            elements.scalar_first(self._columns)
            if self._segment.how.scalar_first
            else self._columns
        )

    def _flush(self):
        """Add the rows that the parser has read to the segment."""
        if self._rows:
            self._segment.rows.add(self._tokens, np.array(self._rows), self._lines, self.fault)
            self._rows, self._tokens, self._lines = [], [], []
