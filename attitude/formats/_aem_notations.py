"""Attitude Ephemeris Messages in KVN and XML, read and written."""

from __future__ import annotations

import re
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from attitude._textfiles import kvn
from attitude._textfiles.lines import NoNumber, cut, numbers
from attitude._textfiles.messages import Form, Generator, XmlGenerator
from attitude._textfiles.xml import MESSAGES, OUTSIDE, ElementReader
from attitude.formats import _aem_message, _attitude_types
from attitude.formats._aem_message import Message, MessageSegment
from attitude.formats._messages import HEADER, VERSIONS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import FilePath
    from attitude._textfiles.lines import Lines
    from attitude.formats._aem_message import Options, WrittenSegment
    from attitude.motions._table import AttitudeTable


# Version -> attitude type -> element of a record.
ELEMENTS: dict[str, dict[str, str]] = {
    "2.0": {
        "QUATERNION": "quaternionEphemeris",
        "QUATERNION/DERIVATIVE": "quaternionDerivative",
        "QUATERNION/ANGVEL": "quaternionAngVel",
        "EULER_ANGLE": "eulerAngle",
        "EULER_ANGLE/DERIVATIVE": "eulerAngleDerivative",
        "EULER_ANGLE/ANGVEL": "eulerAngleAngVel",
        "SPIN": "spin",
        "SPIN/NUTATION": "spinNutation",
        "SPIN/NUTATION_MOM": "spinNutationMom",
    },
    "1.0": {
        "QUATERNION": "quaternionState",
        "QUATERNION/DERIVATIVE": "quaternionDerivative",
        "QUATERNION/ANGVEL": "quaternionEulerRate",
        "EULER_ANGLE": "eulerAngle",
        "EULER_ANGLE/ANGVEL": "eulerAngleRate",
        "SPIN": "spin",
        "SPIN/NUTATION": "spinNutation",
    },
}
RECORDS: set[str] = {element for names in ELEMENTS.values() for element in names.values()}
# Elements between those of records and those of numbers.
GROUPS: tuple[str, ...] = (
    *("quaternion", "quaternionDot", "quaternionRate", "angVel"),
    *("rotationAngles", "rotationRates"),
)


def unit_of_element(name: str) -> str | None:
    """The unit of a column; None for pure numbers."""
    if name.startswith("Q"):
        return "1/s" if name.endswith("_DOT") else None
    if name == "NUTATION_PER":
        return "s"
    return "deg/s" if name.endswith(("_DOT", "_VEL")) or name.startswith("ANGVEL") else "deg"


def scalar_first(columns: Sequence[str]) -> list[str]:
    """Names of columns with QC before Q1, Q2, Q3, as under QUATERNION_TYPE = FIRST of version 1."""
    groups = [columns[k : k + 4] for k in range(0, len(columns), 4)]
    return [n for g in groups for n in ((*g[3:], *g[:3]) if g[3:4] and g[3][:2] == "QC" else g)]


# ---- Attitude Ephemeris Messages in KEYWORD = value notation: CCSDS 504.0-B-1, 504.0-B-2 and CIC

_BATCH = 16384


def read_kvn(lines: Lines, first: bytes, options: Options) -> AttitudeTable:
    """The AttitudeTable of an AEM in KVN; `first` is the line already taken; see `aem.read`."""
    family = "CIC" if options.cic else "CCSDS"
    version = kvn.version(lines, first, "AEM", VERSIONS, family)
    if options.cic:  # both versions of CIC have the keywords of version 1.0
        message = Message(lines.path, "1.0", options, title=f"CIC AEM {version}")
    else:
        message = Message(lines.path, version, options)
    _read_header(lines, message)
    another = True
    while another:
        segment = MessageSegment(message, lines.fault)
        _read_meta(lines, segment)
        another = _read_data(lines, segment)
    return message.table()


def _read_header(lines, message):
    for line in lines:
        if not line.strip():
            continue
        if line.strip() == b"META_START":
            return
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            message.comments.append(value)
        elif keyword in HEADER and keyword not in message.header:
            message.header[keyword] = value
        else:
            raise lines.fault(
                f"{keyword} does not belong into the header, or not twice; give "
                f"{', '.join(HEADER)} and COMMENT, and then META_START."
            )
    raise lines.fault("the file ends before META_START; is it cut off?")


def _read_meta(lines, segment):
    for line in lines:
        if not line.strip():
            continue
        if line.strip() == b"META_STOP":
            segment.begin(lines.number)
            return
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            segment.comments.append(value)
        else:
            segment.add(keyword, value, lines.number)
    raise lines.fault("the file ends before META_STOP; is it cut off?")


def _begin_data(lines, segment):
    """Read up to the first record; the lines that were read and belong to the records."""
    options = segment.message.options
    if options.cic:
        return []
    for line in lines:
        if line.strip() == b"DATA_START":
            return []
        comment = kvn.comment_of(lines.text(line)) if options.lenient else None
        if comment is not None:
            segment.data_comments.append(comment)
        elif options.lenient and line.strip()[:1].isdigit():
            segment.assume("DATA_START is missing: the data begin with the first epoch")
            return [line]
        elif line.strip():
            raise lines.fault(f"{kvn.shown(lines.text(line))} stands where DATA_START must be.")
    return []


def _read_data(lines, segment):
    """Read the records of a segment; True if the meta data of another one follow."""
    options, first = segment.message.options, _begin_data(lines, segment)
    batch, width, lead = _Batch(segment), segment.rows.width, 2 if options.cic else 1
    mms = _aem_message.MMS if options.lenient and not options.cic else None
    of_mms = False
    for line in chain(first, lines):
        tokens = line.split()
        if len(tokens) == mms and tokens[0] != b"COMMENT":
            if not of_mms and not batch.numbers and not segment.rows.count:
                segment.take_columns_of_mms()
                batch, width, of_mms = _Batch(segment), segment.rows.width, True
            tokens = _aem_message.of_mms(tokens) if of_mms else tokens
        if len(tokens) == width + lead:
            if tokens[0] == b"COMMENT":
                segment.data_comments.append(kvn.comment_of(lines.text(line)))
                continue
            batch.tokens.extend(tokens)
            batch.numbers.append(lines.number)
            if len(batch.numbers) == _BATCH:
                batch.take()
                batch = _Batch(segment)
        elif tokens == [b"DATA_STOP"]:
            batch.take()
            segment.finish(lines.number)
            return _another_segment(lines)
        elif tokens == [b"META_START"] and (options.lenient or options.cic):
            return _end_data(segment, batch, lines.number, True)
        elif tokens:
            comment = kvn.comment_of(lines.text(line))
            if comment is None:
                epoch = "a day and its seconds" if options.cic else "an epoch"
                raise lines.fault(
                    f"it has {len(tokens)} entries; {cut(segment.values['ATTITUDE_TYPE'], '')} has "
                    f"{epoch} and {width} numbers: "
                    f"{', '.join(_attitude_types.COLUMNS[segment.kind])}."
                )
            segment.data_comments.append(comment)
    if not (options.lenient or options.cic):
        raise lines.fault("the file ends before DATA_STOP; is it cut off?")
    return _end_data(segment, batch, lines.number, False)


def _end_data(segment, batch, line, another):
    """Finish a segment without DATA_STOP; `another` itself."""
    if not segment.message.options.cic:
        segment.assume("DATA_STOP is missing: the data end with the next segment or the file")
    batch.take()
    segment.finish(line)
    return another


class _Batch:
    """Entries of some records, converted to numbers in one step."""

    def __init__(self, segment):
        self._segment = segment
        self.tokens, self.numbers = [], []

    def take(self):
        segment, names = self._segment, _attitude_types.COLUMNS[self._segment.kind]
        lead = 2 if segment.message.options.cic else 1
        step = len(names) + lead
        if not self.numbers:
            return
        try:
            values = numbers(self.tokens, step, range(lead, step))
        except NoNumber as err:
            raise segment.fault(
                f"{names[err.column]} is {err.shown}, which is no number.", self.numbers[err.line]
            ) from err
        of_day = self.tokens[1::step] if lead == 2 else None
        segment.rows.add(self.tokens[::step], values, self.numbers, segment.fault, of_day)


def _another_segment(lines):
    for line in lines:
        if line.strip() == b"META_START":
            return True
        if line.strip() and kvn.comment_of(lines.text(line)) is None:
            raise lines.fault(
                f"{kvn.shown(lines.text(line))} stands where META_START or the end must be."
            )
    return False


# ---- Runs of records in XML that differ in their texts only, read by a pattern instead of a parser
# The first record of a run is parsed as XML.  The following records that have the same tags,
# attributes, order and spaces, and plain texts without entities, have the same structure; a regular
# expression extracts their texts, four times as fast as the parser.  Everything else is parsed.

# Texts of numbers and dates: no references, no tags, no underscores (which Python's float takes
# for separators of digits).
_TEXT = rb"([^<>&_\s]{1,60})"
_TAG = re.compile(rb"<[^<>]*>")


_LONGEST = 4096  # bytes of a record: patterns of longer ones would take long to compile


def pattern_of(record: bytes, texts: int) -> bytes | None:
    """The regular expression of records with the structure of one; None for other than plain texts.

    record: a whole element, well-formed.
    texts: number of texts in the record, which are the groups of the expression.

    >>> found = re.compile(pattern_of(b"<a><b>1</b> <c u='m'>2</c></a>", 2))
    >>> found.match(b"  <a><b>3</b> <c u='m'>4</c></a>").groups()
    (b'3', b'4')
    >>> found.match(b"<a><b>3</b> <c u='s'>4</c></a>") is None
    True
    """
    if len(record) > _LONGEST or b"<!" in record or b"<?" in record or b"&" in record:
        return None
    parts, end = [rb"\s*"], 0
    for tag in _TAG.finditer(record):
        between = record[end : tag.start()]
        text = between.strip()
        if text:
            texts -= 1
            before, _, after = between.partition(text)
            parts += [re.escape(before), _TEXT, re.escape(after)]
        else:
            parts.append(re.escape(between))
        parts.append(re.escape(tag.group()))
        end = tag.end()
    if texts != 0 or end != len(record):
        return None
    return b"".join(parts)


# ---- Attitude Ephemeris Messages in XML, read
# The elements are those of CCSDS 505.0-B-1 and 505.0-B-2 (section 4.8) for version 1.0, and of
# CCSDS 504.0-B-2, section 7, with CCSDS 505.0-B-3, for version 2.0.

_BATCH_OF_XML = 4096
_BEGIN, _END = b"<attitudeState>", b"</attitudeState>"
# Longest incomplete record, bytes, that is kept back from the parser until its end is read, so that
# a pattern can match it.
_LONGEST_RECORD = 1 << 16
# Layouts of records in one file for which patterns are compiled.
_MOST_PATTERNS = 50


def read_xml(path: FilePath, options: Options) -> AttitudeTable:
    """The AttitudeTable of an AEM in XML; see `aem.read`."""
    reader = _AemReader(path, options)
    reader.run()
    if not reader.done:
        raise reader.fault("there is no <aem> message in it.")
    return reader.message.table()


class _AemReader(ElementReader):
    """Collects the message; records that differ from the last one in their texts match a pattern.

    `_rest` are the bytes that are kept back from the parser.
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
            self._columns = _attitude_types.COLUMNS[self._segment.kind]
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
        elif tag not in RECORDS and tag not in GROUPS:
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
        given, unit = self._attributes.get("units"), unit_of_element(name)
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
        if len(self._rows) == _BATCH_OF_XML:
            self._flush()

    def _name_rates(self):
        """Give the rates of version 1, which stand in the record by number, the axes they name."""
        segment = self._segment
        letters = "".join(self._letters.get(k, "") for k in range(3))
        if len(letters) == 3 and len(set(letters)) < 3:
            segment.take_derivatives()
        usual = segment.how.sequence.upper() if segment.how.rates_of_angles else "XYZ"
        letters = letters or usual
        places = _attitude_types.rates_by_axis(letters, usual)
        if places is None:
            raise self.fault(f"the rates are those of {', '.join(letters)}, not of {usual}.")
        names = {f"ANGVEL_{'XYZ'[k]}": f"ANGVEL_{'XYZ'[places.index(k)]}" for k in range(3)}
        self._record = {names.get(name, name): value for name, value in self._record.items()}

    def _names(self):
        """The columns in the order of the rows."""
        return scalar_first(self._columns) if self._segment.how.scalar_first else self._columns

    def _flush(self):
        """Add the rows that the parser has read to the segment."""
        if self._rows:
            self._segment.rows.add(self._tokens, np.array(self._rows), self._lines, self.fault)
            self._rows, self._tokens, self._lines = [], [], []


# ---- Writing

FORM = Form("AEM", VERSIONS, HEADER, marks={"metadata": "META", "data": "DATA"})


def write_data(segment: WrittenSegment, version: str, out: Generator) -> None:
    """Write comments and records of a segment."""
    out.comments(segment.data_comments)
    if isinstance(out, XmlGenerator):
        _write_rows(out.write, segment, _template(segment, version), _order(segment))
    else:
        write_lines(out.write, segment)


def write_lines(write: Callable[[str], object], segment: WrittenSegment) -> None:
    """Write the records of a segment, a line each."""
    count = len(_attitude_types.COLUMNS[segment.kind])
    _write_rows(write, segment, "%s" + " %r" * count + "\n", slice(None))


def _write_rows(write, segment, row, order):
    for epochs, columns in segment.rows():
        lists = [epochs, *columns[:, order].T.tolist()]
        write("".join([row % record for record in zip(*lists, strict=True)]))


def _order(segment):
    """The places of the segment's columns in the order of the elements."""
    columns = _attitude_types.COLUMNS[segment.kind]
    given = scalar_first(columns) if segment.scalar_first else list(columns)
    return [given.index(name) for name in columns]


def _template(segment, version):
    """The text of one record with %s for the epoch and %r for each column."""
    kind, columns = segment.kind, _attitude_types.COLUMNS[segment.kind]
    lines = ["<EPOCH>%s</EPOCH>"]
    for group, names in _groups(kind, columns, version):
        rates = segment.sequence if segment.rates_of_angles else "XYZ"
        inner = [_leaf(n, version, k, segment.sequence[k % 3], rates) for k, n in enumerate(names)]
        lines += [f"<{group}>", *inner, f"</{group}>"] if group else inner
    element = ELEMENTS[version][kind]
    lines = [f"<{element}>", *lines, f"</{element}>"]
    return (
        "".join(["        <attitudeState>\n", *(f"          {line}\n" for line in lines)])
        + "        </attitudeState>\n"
    )


def _groups(kind, columns, version):
    """Groups of columns in a record: (element or None, columns)."""
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


def _leaf(name, version, place, axis, rates):
    """The element of one column, `place` in its group, of the angle `axis`; `rates` as of version
    1.
    """
    tag = f"rotation{place + 1}"
    if version == "1.0" and name.startswith("ANGLE"):
        return f'<{tag} angle="{axis}_ANGLE" units="deg">%r</{tag}>'
    if version == "1.0" and name.startswith("ANGVEL"):
        return f'<{tag} rate="{rates[place]}_RATE" units="deg/s">%r</{tag}>'
    unit = unit_of_element(name)
    return f'<{name} units="{unit}">%r</{name}>' if unit else f"<{name}>%r</{name}>"
