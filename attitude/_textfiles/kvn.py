"""The KEYWORD = value notation of CCSDS messages: AEM, APM, OEM and OMM."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from attitude._textfiles.lines import cut

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._textfiles.lines import Lines


# Longest keyword, characters: sentences repeat them.
_LONGEST_KEYWORD = 60
# value [unit]
_UNIT = re.compile(r"(.*?)\s*\[([^][]*)\]")


def first(lines: Lines) -> bytes | None:
    """The first line that is not empty; None if the message is in XML."""
    for line in lines:
        text = line.lstrip(b"\xef\xbb\xbf \t")
        if text.startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
            return None
        if text:
            return line
    raise lines.fault("the file is empty.")


def version(
    lines: Lines, line: bytes, kind: str, known: Sequence[str], family: str = "CCSDS"
) -> str:
    """The version in the first line of a message."""
    keyword, value = pair(lines, line)
    wanted = f"{family}_{kind}_VERS"
    if keyword != wanted or value not in known:
        other = keyword == f"CIC_{kind}_VERS" and family != "CIC"
        raise lines.fault(
            f"it begins with {shown(lines.text(line))}; an {kind} begins with {wanted} = "
            f"{' or '.join(known)}"
            + ("; attitude.formats.cic reads the dialect of CNES." if other else ".")
        )
    return value


def pair(lines: Lines, line: bytes) -> tuple[str, str]:
    """Keyword, in capital letters, and value of a line; a comment is ("COMMENT", text)."""
    text = lines.text(line)
    comment = comment_of(text)
    if comment is not None:
        return "COMMENT", comment
    keyword, equals, value = text.partition("=")
    if not equals or not 0 < len(keyword.strip()) <= _LONGEST_KEYWORD:
        raise lines.fault(f'{shown(text)} is no "KEYWORD = value".')
    return keyword.strip().upper(), value.strip()


def comment_of(text: str) -> str | None:
    """The text behind COMMENT or COMMENT=; None if the line does not begin with COMMENT."""
    text = text.strip()
    return text[7:].removeprefix("=").strip() if text.startswith("COMMENT") else None


def values(lines: Lines) -> dict[str, str]:
    """Keyword -> value of a message of one block, the last one counts; without comments and
    [units].
    """
    found = {}
    for line in lines:
        if not lines.text(line).strip():
            continue
        keyword, value = pair(lines, line)
        if keyword != "COMMENT":
            found[keyword] = value.partition("[")[0].strip()
    return found


def without_unit(value: str) -> tuple[str, str]:
    """Value and unit of ``1.5 [deg]``; the unit is "" if none is given."""
    found = _UNIT.fullmatch(value)
    return (found.group(1), found.group(2).strip()) if found else (value, "")


def shown(text: str) -> str:
    """A line as it appears in an error message: in quotes, at most 40 characters."""
    return cut(text.strip())
