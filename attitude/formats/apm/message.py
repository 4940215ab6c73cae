"""An Attitude Parameter Message while it is read: its blocks, with the keywords of version 2."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar

from attitude.formats.apm.keywords import META, REPEATED, UNITS
from attitude.formats.ccsds.attitude_types import HEADER
from attitude.textfiles import kvn
from attitude.textfiles.lines import cut, is_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from attitude.errors import AttitudeError
    from attitude.textfiles.lines import Fault

_Choice = TypeVar("_Choice")


class Block(dict[str, str]):
    """A block of a message: keyword -> value.

    Attributes
    ----------
    name : str
        One of BLOCKS.
    line : int
        Number of the line in which the block begins.
    lines : dict of int
        Keyword -> number of its line.
    order : list of (keyword, value, line)
        All keywords in the order of the file, repeated ones too.
    comments : list of str
    """

    def __init__(self, name: str, line: int):
        super().__init__()
        self.name: str = name
        self.line: int = line
        self.lines: dict[str, int] = {}
        self.order: list[tuple[str, str, int]] = []
        self.comments: list[str] = []


class Collected:
    """A message while it is read: header, meta data, blocks.

    Parameters
    ----------
    version : str
    fault : callable
        Makes the error for a sentence and the number of a line.
    path : str
        Name of the file.

    Attributes
    ----------
    version, fault, path
        As given.
    header, meta : dict of str
        Keyword -> value; meta holds EPOCH too.
    lines : dict of int
        Keyword of header or meta data -> number of its line.
    comments : list of str
    blocks : list of Block
    """

    def __init__(self, version: str, fault: Fault, path: str):
        self.version: str = version
        self.fault: Fault = fault
        self.path: str = path
        self.header: dict[str, str] = {}
        self.meta: dict[str, str] = {}
        self.lines: dict[str, int] = {}
        self.comments: list[str] = []
        self.blocks: list[Block] = []

    def put_common(self, keyword: str, value: str, line: int) -> bool:
        """Add a keyword of header or meta data, or EPOCH; False, and nothing added, for others.

        Raises
        ------
        AttitudeError
            For a repeated keyword.
        """
        if keyword not in (*HEADER, *META, "EPOCH"):
            return False
        into = self.header if keyword in HEADER else self.meta
        if keyword in into:
            raise self.fault(f"{keyword} is given twice.", line)
        into[keyword], self.lines[keyword] = value, line
        return True

    def put(self, block: Block, keyword: str, value: str, line: int) -> None:
        """Add a keyword of version 2 to a block; AttitudeError for a repeated one."""
        if keyword in block and keyword not in REPEATED:
            raise self.fault(
                f"{keyword} is given twice, first in line {block.lines[keyword]}.", line
            )
        block.order.append((keyword, value, line))
        block[keyword], block.lines[keyword] = value, line

    def unknown(self, keyword: str, line: int) -> AttitudeError:
        """The error for an unknown keyword."""
        return self.fault(
            f"{keyword} is not known in an APM of version {self.version}, or not in this place.",
            line,
        )


def number(message: Collected, block: Block, keyword: str, kind: str | None = None) -> float:
    """The value of a keyword as a finite float.

    Parameters
    ----------
    message, block : Collected, Block
    keyword : str
    kind : str, optional
        One of UNITS: the units that the value may have; without it, none.

    Raises
    ------
    AttitudeError
        If the keyword is missing, its value is not a finite number, or is in another unit.
    """
    if keyword not in block:
        raise message.fault(f"the block {block.name} lacks {keyword}.", block.line)
    line = block.lines[keyword]
    value, unit = kvn.without_unit(block[keyword])
    allowed = () if kind is None else UNITS[kind]
    if unit and unit.replace(" ", "") not in allowed:
        known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
        raise message.fault(f"{keyword} is in {cut(unit)}{known}.", line)
    found = float(value) if is_number(value.encode("ascii", "replace")) else math.nan
    if not math.isfinite(found):
        raise message.fault(f"{keyword} is {value[:40]!r}, which is no finite number.", line)
    return found


def needs(message: Collected, keyword: str) -> str:
    """The value of a keyword of the meta data; AttitudeError if it is missing."""
    if not message.meta.get(keyword):
        raise message.fault(f"the message lacks {keyword}.", None)
    return message.meta[keyword]


def one_of(
    message: Collected, block: Block, keyword: str, choices: Mapping[str, _Choice]
) -> _Choice:
    """The meaning of a keyword's value, out of some choices; AttitudeError for another value."""
    value = block.get(keyword)
    if value is None or value.upper() not in choices:
        given = "is not given" if value is None else f"is {cut(value)}"
        raise message.fault(
            f"{keyword} of the block {block.name} {given}; it must be one of "
            f"{', '.join(cut(each, '') for each in choices)}.",
            block.lines.get(keyword, block.line),
        )
    return choices[value.upper()]
