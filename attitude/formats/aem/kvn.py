"""Attitude Ephemeris Messages in KEYWORD = value notation: CCSDS 504.0-B-1, 504.0-B-2 and CIC."""

from __future__ import annotations

from itertools import chain
from typing import IO, TYPE_CHECKING

from attitude.formats.aem import lenient
from attitude.formats.aem.message import Message, MessageSegment
from attitude.formats.ccsds import attitude_types
from attitude.formats.ccsds.attitude_types import HEADER, VERSIONS
from attitude.textfiles import kvn
from attitude.textfiles.lines import NoNumber, cut, numbers

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from attitude.attitude_table.table import AttitudeTable
    from attitude.formats.aem.message import Options
    from attitude.formats.aem.written import WrittenSegment
    from attitude.textfiles.lines import Lines

_BATCH = 16384


def read(lines: Lines, first: bytes, options: Options) -> AttitudeTable:
    """The AttitudeTable of an AEM in KVN; see `aem.read`.

    `first` is the first line that is not empty, which has been taken from `lines`.
    """
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
    mms = lenient.MMS if options.lenient and not options.cic else None
    of_mms = False
    for line in chain(first, lines):
        tokens = line.split()
        if len(tokens) == mms and tokens[0] != b"COMMENT":
            if not of_mms and not batch.numbers and not segment.rows.count:
                segment.take_columns_of_mms()
                batch, width, of_mms = _Batch(segment), segment.rows.width, True
            tokens = lenient.of_mms(tokens) if of_mms else tokens
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
                    f"{', '.join(attitude_types.COLUMNS[segment.kind])}."
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
        segment, names = self._segment, attitude_types.COLUMNS[self._segment.kind]
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


# Writing ------------------------------------------------------------------------------------------


def write_message(
    file: IO[str],
    version: str,
    header: Mapping[str, str],
    comments: Sequence[str],
    segments: Iterable[WrittenSegment],
) -> None:
    """Write a message in KVN to an open file; see `aem.write`."""
    file.write(f"CCSDS_AEM_VERS = {version}\n")
    file.writelines(f"COMMENT {text}\n" for text in comments)
    file.writelines(f"{key} = {value}\n" for key, value in header.items())
    for segment in segments:
        file.write("\nMETA_START\n")
        file.writelines(f"COMMENT {text}\n" for text in segment.comments)
        file.writelines(f"{key} = {value}\n" for key, value in segment.keywords.items())
        file.write("META_STOP\n\nDATA_START\n")
        file.writelines(f"COMMENT {text}\n" for text in segment.data_comments)
        write_rows(file, segment)
        file.write("DATA_STOP\n")


def write_rows(file: IO[str], segment: WrittenSegment) -> None:
    """Write the records of a segment, a line each, to an open file."""
    for epochs, columns in segment.rows():
        row = "%s" + " %r" * columns.shape[1] + "\n"
        lists = [epochs, *columns.T.tolist()]
        file.write("".join([row % each for each in zip(*lists, strict=True)]))
