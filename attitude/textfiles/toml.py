"""Texts in TOML: read with a sentence for what cannot be read, for syntax and unknown keys."""

import difflib
import json
import re
import tomllib

from attitude.errors import AttitudeError
from attitude.textfiles.lines import whole


def read(path, kind):
    """The text of a file; `kind` is what its users call it, such as "spin file"."""
    return whole(path, f"give the name of a {kind}")


def parsed(text, origin):
    """What a text says, as dicts and lists; `origin` begins the message of an error."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        raise AttitudeError(_syntax_error(str(err), text, origin)) from err


def refuse_unknown(section, known, where):
    """AttitudeError for the first key of a section that is not among those known."""
    for key in section:
        if key not in known:
            near = difflib.get_close_matches(key.lower(), known, n=1)
            raise AttitudeError(
                f"{where} has a key {key!r} that is not known; "
                + (
                    f"did you mean {near[0]!r}?"
                    if near
                    else f"allowed are {listed(sorted(set(known)))}."
                )
            )


def way_of(section, ways, where):
    """The one of several keys that a section has: which way it takes to say the same."""
    taken = [way for way in ways if way in section]
    if len(taken) != 1:
        raise AttitudeError(
            f"{where} has {' and '.join(taken) or 'none'} of {', '.join(ways)}; give one of them."
        )
    return taken[0]


def text_of(content, key):
    """The text that a key holds, or None without the key."""
    value = content.get(key)
    if value is not None and not isinstance(value, str):
        raise AttitudeError(f"{key} is {value!r}; give text in quotes.")
    return value


def quoted(value, key):
    """A text as the value of a key, in quotes."""
    if not isinstance(value, str):
        raise AttitudeError(f"{key} is {value!r}; give text.")
    # JSON escapes as TOML does, but for the delete character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def listed(words):
    """Words as alternatives: "a, b or c"; "none" where there is none."""
    if len(words) < 2:
        return words[0] if words else "none"
    return ", ".join(words[:-1]) + " or " + words[-1]


def _syntax_error(message, text, origin):
    found = re.fullmatch(r"(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    if found is None:
        return f"{origin}: is not valid TOML: {message}."
    what, line, column = found.groups()
    line = line or text.rstrip().count("\n") + 1
    where = f"line {line}" + (f", column {column}" if column else " (the end)")
    return f"{origin}, {where}: is not valid TOML: {what[:1].lower() + what[1:]}."
