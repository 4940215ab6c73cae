"""Attitude Ephemeris Messages in XML.

The elements are those of CCSDS 505.0-B-1 and 505.0-B-2 (section 4.8) for version 1.0, and of CCSDS
504.0-B-2, section 7, with CCSDS 505.0-B-3, for version 2.0.
"""

import re

import numpy as np

from attitude.formats.aem import elements
from attitude.formats.aem.message import HEADER, VERSIONS, Message, Segment
from attitude.formats.aem.xml_records import pattern_of
from attitude.formats.ccsds import attitude_types
from attitude.textfiles.lines import NoNumber, numbers
from attitude.textfiles.xml import MESSAGES, OUTSIDE, ElementReader, escaped

_BATCH = 4096
_BEGIN, _END = b"<attitudeState>", b"</attitudeState>"
# Longer ones, in bytes, do not wait for their end; more layouts in a file are not worth a pattern.
_LONGEST_RECORD, _MOST_PATTERNS = 1 << 16, 50
_SCHEMA = {
    "1.0": "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-2.0.0-master-2.0.xsd",
    "2.0": "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd",
}


def read(path, options):
    """The AttitudeTable of an AEM in XML; see `aem.read`."""
    reader = _Reader(path, options)
    reader.run()
    if not reader.done:
        raise reader.fault("there is no <aem> message in it.")
    return reader.message.table()


class _Reader(ElementReader):
    """Collects the message; records that are written like the one before go by a pattern."""

    def __init__(self, path, options):
        super().__init__(path)
        self._options = options
        self._segment = self._record = None
        self._place = []
        self._attributes = {}
        self._held, self._pattern = b"", None
        self._outside = []
        self._patterns, self._ended_at = {}, 0
        self.done = False

    def take(self, piece, last=False):
        buffer, at = self._held + piece, 0
        self._held = b""
        while True:
            if self._pattern is not None:
                at = self._take_alike(buffer, at)
            end = buffer.find(_END, at) + len(_END)
            if end < len(_END):
                break
            start = buffer.rfind(_BEGIN, at, end)
            self.feed(buffer[at:end])
            self._pattern = self._pattern_of(buffer[start:end]) if start >= 0 else None
            at = end
        # The beginning of a record waits for its end, but not for ever.
        start = buffer.find(b"<", at) if self._pattern is not None else buffer.find(_BEGIN, at)
        if start < 0:
            start = len(buffer)
        elif last or len(buffer) - start > _LONGEST_RECORD:
            start, self._pattern = len(buffer), None
        self.feed(buffer[at:start], last)
        self._held = buffer[start:]

    def _pattern_of(self, record):
        """The pattern of the record that was fed last, if the parser has just finished it."""
        if self._ended_at + len(_END) != self.fed:
            return None
        source = pattern_of(record, 1 + len(self._order))
        if source is not None and source not in self._patterns:
            if len(self._patterns) >= _MOST_PATTERNS:
                return None
            self._patterns[source] = re.compile(source)
        return self._patterns.get(source)

    def _take_alike(self, buffer, at):
        """Take records off the buffer; returns where the first that is not alike begins."""
        match, tokens, lines, line = self._pattern.match, [], [], self.line
        while found := match(buffer, at):
            tokens += found.groups()
            line += buffer.count(b"\n", at, found.end())
            lines.append(line)
            at = found.end()
        if lines:
            self._take()
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
            self.message = Message(self.path, version, self._options, comments=self._outside)
        elif tag == "segment":
            self._segment = Segment(self.message, self.fault)
            self._rows, self._tokens, self._lines = [], [], []
        elif tag == "data":
            if self._segment is None or self._segment.rows is None:
                raise self.fault("<data> stands before the end of <metadata>.")
        elif tag == "attitudeState":
            if self._segment is None or self._segment.rows is None:
                raise self.fault("<attitudeState> stands outside of <data>.")
            self._record, self._epoch = {}, None
            self._columns = attitude_types.COLUMNS[self._segment.kind]
        self._attributes = attributes
        self._place.append(tag)

    def end(self, tag, text):
        self._place.pop()
        above = self._place[-1] if self._place else None
        if self._record is not None:
            self._in_record(tag, text, above)
        elif above == "header":
            self._in_header(tag, text)
        elif above == "ndm" and tag == "COMMENT":
            self._outside.append(text)
        elif above == "metadata":
            self._in_metadata(tag, text)
        elif tag == "metadata" and self._segment is not None:
            self._segment.begin(self.line)
        elif above == "data":
            self._in_data(tag, text)
        elif tag == "segment" and self._segment is not None:
            if self._segment.rows is None:
                raise self.fault("the segment has no <metadata>.")
            self._take()
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
            label = self._attributes.get("rate", "XYZ"[int(tag[-1]) - 1])
            return f"ANGVEL_{label[:1].upper()}"
        return tag

    def _put(self, name, text):
        if name not in self._columns or name in self._record:
            raise self.fault(
                f"{name} does not belong into a record of "
                f"{self._segment.values['ATTITUDE_TYPE']}, or not twice."
            )
        given, unit = self._attributes.get("units"), elements.unit(name)
        if given and given != unit:
            raise self.fault(f"{name} is given in {given!r}; it must be in {unit or 'no unit'}.")
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
        names = self._names()
        self._rows.append([self._record[name] for name in names])
        self._tokens.append(self._epoch)
        self._lines.append(self.line)
        # Where its texts stand in it, for those that follow and are written alike.
        places = {name: k + (k >= self._epoch_at) for k, name in enumerate(self._record)}
        self._order, self._ended_at = [places[name] for name in names], self.place
        self._record = None
        if len(self._rows) == _BATCH:
            self._take()

    def _names(self):
        """The columns in the order in which rows have them."""
        return (
            elements.scalar_first(self._columns)
            if self._segment.how.scalar_first
            else self._columns
        )

    def _take(self):
        if self._rows:
            self._segment.rows.add(self._tokens, np.array(self._rows), self._lines, self.fault)
            self._rows, self._tokens, self._lines = [], [], []


# Writing ------------------------------------------------------------------------------------------


def write_message(file, version, header, comments, segments):
    """A message in XML, to an open file; see `aem.write`."""
    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<aem xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        f'     xsi:noNamespaceSchemaLocation="{_SCHEMA[version]}"\n'
        f'     id="CCSDS_AEM_VERS" version="{version}">\n  <header>\n'
    )
    _leaves(file, 4, [("COMMENT", text) for text in comments])
    _leaves(file, 4, header.items())
    file.write("  </header>\n  <body>\n")
    for segment in segments:
        file.write("    <segment>\n      <metadata>\n")
        _leaves(file, 8, [("COMMENT", text) for text in segment.comments])
        _leaves(file, 8, segment.keywords.items())
        file.write("      </metadata>\n      <data>\n")
        _leaves(file, 8, [("COMMENT", text) for text in segment.data_comments])
        row = _template(segment, version)
        order = _as_in_template(segment)
        for epochs, columns in segment.rows():
            lists = [epochs, *columns[:, order].T.tolist()]
            file.write("".join([row % each for each in zip(*lists, strict=True)]))
        file.write("      </data>\n    </segment>\n")
    file.write("  </body>\n</aem>\n")


def _leaves(file, indent, pairs):
    for tag, text in pairs:
        file.write(f"{' ' * indent}<{tag}>{escaped(text)}</{tag}>\n")


def _as_in_template(segment):
    """Which of the segment's columns follow each other in the elements."""
    columns = attitude_types.COLUMNS[segment.kind]
    given = elements.scalar_first(columns) if segment.scalar_first else list(columns)
    return [given.index(name) for name in columns]


def _template(segment, version):
    """One record as text, with %s for the epoch and %r for each column."""
    kind, columns = segment.kind, attitude_types.COLUMNS[segment.kind]
    lines = ["<EPOCH>%s</EPOCH>"]
    for group, names in _groups(kind, columns, version):
        inner = [_leaf(name, version, k + 1, segment.sequence) for k, name in enumerate(names)]
        lines += [f"<{group}>", *inner, f"</{group}>"] if group else inner
    element = elements.ELEMENTS[version][kind]
    lines = [f"<{element}>", *lines, f"</{element}>"]
    return (
        "".join(["        <attitudeState>\n", *(f"          {line}\n" for line in lines)])
        + "        </attitudeState>\n"
    )


def _groups(kind, columns, version):
    if kind.startswith("SPIN"):
        return [(None, columns)]
    first = 4 if kind.startswith("QUATERNION") else 3
    given, rates = columns[:first], columns[first:]
    old = version == "1.0"
    if kind.startswith("QUATERNION"):
        groups = [("quaternion", given)]
        names = {
            "/DERIVATIVE": ("quaternionDot", "quaternionRate"),
            "/ANGVEL": ("angVel", "rotationRates"),
        }
    else:
        groups = [("rotationAngles" if old else None, given)]
        names = {"/DERIVATIVE": (None, None), "/ANGVEL": (None, "rotationRates")}
    if rates:
        groups.append((names["/" + kind.split("/")[1]][old], rates))
    return groups


def _leaf(name, version, number, sequence):
    if version == "1.0" and name.startswith("ANGLE"):
        label = f"{sequence[number - 1]}_ANGLE"
        return f'<rotation{number} angle="{label}" units="deg">%r</rotation{number}>'
    if version == "1.0" and name.startswith("ANGVEL"):
        return f'<rotation{number} rate="{name[-1]}_RATE" units="deg/s">%r</rotation{number}>'
    unit = elements.unit(name)
    return f'<{name} units="{unit}">%r</{name}>' if unit else f"<{name}>%r</{name}>"
