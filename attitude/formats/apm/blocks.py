"""Attitude Parameter Messages in KVN and XML, read into blocks with the keywords of version 2.

Version 1 has other keywords, and no marks around its blocks in KVN.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude.formats.apm.keywords import BLOCKS, OLD, REPEATED, XML_BLOCKS
from attitude.formats.apm.message import Block, Collected
from attitude.formats.ccsds.attitude_types import VERSIONS
from attitude.textfiles import kvn
from attitude.textfiles.lines import cut
from attitude.textfiles.xml import MESSAGES, OUTSIDE, ElementReader

if TYPE_CHECKING:
    from attitude.annotations import FilePath
    from attitude.textfiles.lines import Lines


def read_kvn(lines: Lines, first: bytes) -> Collected:
    """The message of an APM in KVN.

    `first` is the first line that is not empty, which has been taken from `lines`.

    Raises
    ------
    AttitudeError
        For lines that are not KVN, and unknown, misplaced or repeated keywords.
    """
    version = kvn.version(lines, first, "APM", VERSIONS)
    message = Collected(version, lines.fault, lines.path)
    current: Block | None = None
    for line in lines:
        if line.strip() in (b"", b"META_START", b"META_STOP"):
            continue
        mark = line.strip().decode("ascii", "replace")
        if version != "1.0" and mark.endswith(("_START", "_STOP")) and "=" not in mark:
            current = _marked(message, mark, current, lines.number)
            continue
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            (message.comments if current is None else current.comments).append(value)
        elif current is None and message.put_common(keyword, value, lines.number):
            pass
        elif version == "1.0" and keyword in OLD:
            name, new = OLD[keyword]
            block = _open_block(message, name, keyword, lines.number)
            message.put(block, new, value, lines.number)
        elif current is not None and keyword in BLOCKS[current.name]:
            message.put(current, keyword, value, lines.number)
        else:
            raise message.unknown(keyword, lines.number)
    if current is not None:
        raise lines.fault(f"the file ends before {current.name}_STOP; is it cut off?")
    return message


def _marked(message, mark, current, line):
    """The block that is open after a line with _START or _STOP; None after _STOP."""
    name, _, end = mark.rpartition("_")
    if name not in BLOCKS:
        raise message.fault(
            f"{cut(mark, '')} is not known; blocks are {', '.join(BLOCKS)}, each with _START and "
            "_STOP.",
            line,
        )
    if end == "START":
        if current is not None:
            raise message.fault(f"{mark} stands before {current.name}_STOP.", line)
        message.blocks.append(Block(name, line))
        return message.blocks[-1]
    if current is None or current.name != name:
        raise message.fault(f"{mark} stands without {name}_START.", line)
    return None


def _open_block(message, name, keyword, line):
    """The block of version 1 for a keyword; each MAN_EPOCH_START begins a new maneuver."""
    found = [block for block in message.blocks if block.name == name]
    if not found or (name == "MAN" and keyword == "MAN_EPOCH_START"):
        message.blocks.append(Block(name, line))
        return message.blocks[-1]
    return found[-1]


# Elements that group keywords.
_GROUPS = ("quaternion", "quaternionDot", "quaternionRate", "rotationAngles", "rotationRates")
_OUTER = ("apm", "ndm", "header", "body", "segment", "metadata", "data")


def read_xml(path: FilePath) -> Collected:
    """The message of an APM in XML.

    Raises
    ------
    AttitudeError
        For a file that cannot be read or is not well-formed, and unknown or repeated keywords.
    """
    reader = _ApmReader(path)
    reader.run()
    if reader.message is None:
        raise reader.fault("there is no <apm> message in it.")
    return reader.message


class _ApmReader(ElementReader):
    """Collects the message.

    `_tags` are the tags of the open elements, `_comments` the comments before the message.
    """

    def __init__(self, path):
        super().__init__(path)
        self._block, self._tags, self._attributes = None, [], {}
        self._comments = []

    def begin(self, tag, attributes):
        if tag in MESSAGES or (self.message is None and tag not in OUTSIDE):
            version = self.version(tag, attributes, "apm", VERSIONS)
            self.message = Collected(version, self.fault, self.path)
            self.message.comments.extend(self._comments)
        elif self._tags[-1:] == ["data"] and tag in XML_BLOCKS:
            self._block = Block(XML_BLOCKS[tag], self.line)
            self.message.blocks.append(self._block)
        self._tags.append(tag)
        self._attributes = attributes

    def end(self, tag, text):
        self._tags.pop()
        if self.message is None:
            self._comments += [text] if tag == "COMMENT" else []
            return
        if tag in _OUTER or tag in _GROUPS:
            return
        if self._tags[-1:] == ["data"] and tag in XML_BLOCKS:
            self._block = None
        elif tag == "COMMENT":
            (self.message.comments if self._block is None else self._block.comments).append(text)
        elif self._block is None or (tag == "EPOCH" and "EPOCH" not in self.message.meta):
            if not self.message.put_common(tag, text, self.line):
                raise self.message.unknown(tag, self.line)
        else:
            self._put(tag, text)

    def _put(self, tag, text):
        unit = self._attributes.get("units")
        value = text if unit is None else f"{text} [{unit}]"
        label = self._attributes.get("angle") or self._attributes.get("rate")
        if tag in ("rotation1", "rotation2", "rotation3") and label in REPEATED:
            tag = label
        if self.message.version == "1.0" and tag in OLD:
            name, tag = OLD[tag]
            if name != self._block.name:
                raise self.message.unknown(tag, self.line)
        elif tag not in BLOCKS[self._block.name]:
            raise self.message.unknown(tag, self.line)
        self.message.put(self._block, tag, value, self.line)
