"""Long runs of records in XML that are all written alike, by a pattern instead of a parser.

The first record of a run is parsed as XML.  Those that follow it and differ from it in nothing but
their texts (the same tags, attributes, order and spaces, plain texts without entities) mean what
it means; a regular expression takes the texts out, four times as fast.  Whatever else comes is
parsed.
"""

import re

# Texts: what numbers and dates can be; no references, no tags, no underscores (which Python's
# float would take for separators of digits).
_TEXT = rb"([^<>&_\s]{1,60})"
_TAG = re.compile(rb"<[^<>]*>")


_LONGEST = 4096  # bytes of a record: longer ones would take long to compile


def pattern_of(record, texts):
    """The pattern of records like this one, as bytes; None where it has other than plain texts.

    Parameters
    ----------
    record : bytes
        A whole element, well-formed.
    texts : int
        How many texts it must hold: these are the groups of the pattern.

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
