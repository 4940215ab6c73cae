"""The KEYWORD = value notation of CCSDS messages: AEM, APM, OEM and OMM."""

import re

from attitude.errors import AttitudeError

# value [unit]
_UNIT = re.compile(r"(.*?)\s*\[([^][]*)\]")


def first(lines):
    """The first line that is not empty, of a message in this notation; None of one in XML."""
    for line in lines:
        text = line.lstrip(b"\xef\xbb\xbf \t")
        if text.startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
            return None
        if text:
            return line
    raise lines.fault("the file is empty.")


def version(lines, line, kind, known):
    """The version that the first line of a message of some kind, such as "AEM", tells."""
    keyword, value = pair(lines, line)
    if keyword != f"CCSDS_{kind}_VERS" or value not in known:
        raise lines.fault(
            f"it begins with {shown(lines.text(line))}; an {kind} begins with CCSDS_{kind}_VERS = "
            f"{' or '.join(known)}."
        )
    return value


def pair(lines, line):
    """Keyword, in capital letters, and value of a line; a comment is ("COMMENT", text)."""
    text = lines.text(line)
    comment = comment_of(text)
    if comment is not None:
        return "COMMENT", comment
    keyword, equals, value = text.partition("=")
    if not equals or not keyword.strip():
        raise lines.fault(f'{shown(text)} is no "KEYWORD = value".')
    return keyword.strip().upper(), value.strip()


def comment_of(text):
    """The text of a line that begins with COMMENT, also of COMMENT=text; None of others."""
    text = text.strip()
    return text[7:].removeprefix("=").strip() if text.startswith("COMMENT") else None


def values(lines):
    """Keyword -> value of a message of one block, such as an OMM: the last of each keyword.

    Comments are left out, and units: what follows an opening bracket.
    """
    found = {}
    for line in lines:
        if not lines.text(line).strip():
            continue
        keyword, value = pair(lines, line)
        if keyword != "COMMENT":
            found[keyword] = value.partition("[")[0].strip()
    return found


def without_unit(value):
    """The value and its unit, "" where none is given: ``1.5 [deg]``."""
    found = _UNIT.fullmatch(value)
    return (found.group(1), found.group(2).strip()) if found else (value, "")


def refuse_line_breaks(text):
    """Names and comments stand in one line each."""
    if not isinstance(text, str) or not text.isprintable() or len(text) > 4000:
        raise AttitudeError(
            f"{str(text)[:60]!r} cannot be a name or a comment in a message; give one line of text."
        )


def shown(text):
    text = repr(text.strip())
    return text if len(text) <= 60 else text[:56] + "...'"
