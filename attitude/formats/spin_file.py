"""Spin files: a body and its state of rotation in TOML, which is the whole of its free motion.

::

    name = "(4179) Toutatis"
    source = "Takahashi, Busch & Scheeres 2013, AJ 146, 95"
    note = "x is the intermediate, y the short, z the long axis"

    [body]
    moments = [3.0836, 3.235, 1.0]
    relative = true

    [spin]
    epoch = "1992-11-09T17:49:47"
    frame = "ecliptic"
    sequence = "313"
    angles = "145.498, 65.865, 241.524 deg"
    angular_velocity = "14.51, 33.529, -98.709 deg/day"

=========  =========================================================================================
[body]     ``moments`` (three), or ``tensor`` (three rows), or ``ellipsoid`` (three semi-axes), or
           ``masses`` with ``positions``; as in `Body`, `Body.from_ellipsoid`, `Body.from_points`.
           ``mass``, ``center_of_mass``; ``relative = true`` where the unit of inertia is unknown.
[spin]     ``epoch`` (UTC, or with the name of a time scale behind it), ``angular_velocity`` over
           the body axes, and the attitude from body axes to ``frame`` ("icrf" if left out): one of
           ``wxyz`` (scalar first), ``matrix`` (three rows), ``sequence`` with ``angles``.
at the top ``name``, ``source``, ``note``: text, all optional.
=========  =========================================================================================

A number is plain, and then in SI units and radians, or text with a unit.  A list is written
``[1.0, 2.0, 3.0]``, ``"1, 2, 3 deg/day"`` or ``["1 deg/day", "2 deg/day", "0.5 rpm"]``.  An epoch
that text to the nanosecond does not hold is written as two doubles,
``"820497600.0 + 1.5e-12 s TDB since J2000"``.
"""

import difflib
import json
import os
import re
import tomllib
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from attitude import epochs, gates
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.formats import measured
from attitude.formats.aside import written_whole
from attitude.free_rotation import FreeRotation
from attitude.frozen import Frozen
from attitude.spin import Spin

_TOP = ("name", "source", "note", "body", "spin")
# The ways to give a body or an attitude: what leads each, what it needs, what may go with it.
_BODIES = {
    "moments": ((), ("mass", "relative", "center_of_mass")),
    "tensor": ((), ("mass", "relative", "center_of_mass")),
    "ellipsoid": ((), ("mass",)),
    "masses": (("positions",), ("relative",)),
}
_ATTITUDES = {"wxyz": ((), ()), "matrix": ((), ()), "sequence": (("angles",), ())}
_SPIN = ("epoch", "angular_velocity")
_FLOAT = r"[+-]?[0-9.]+(?:e[+-]?[0-9]+)?"
_TWO_DOUBLES = re.compile(rf"({_FLOAT}) \+ ({_FLOAT}) s TDB since J2000")


@dataclass(frozen=True, eq=False)
class SpinFile(Frozen):
    """What a spin file holds.

    Attributes
    ----------
    body : Body
    spin : Spin
    name, source, note : str or None
    motion : FreeRotation
    """

    body: Body
    spin: Spin
    name: str = None
    source: str = None
    note: str = None

    @cached_property
    def motion(self):
        return FreeRotation(self.body, self.spin)


def read(path):
    """The body and spin of a file.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    SpinFile

    Raises
    ------
    AttitudeError
        For a file that cannot be read or is not TOML, for keys that are missing, unknown or one
        too many, for values of a wrong type, shape or unit, and for all that `Body` and `Spin`
        refuse; each begins with the name of the file.
    """
    path = os.fspath(path)
    try:
        with open(path, "rb") as file:
            content = file.read().decode("utf-8-sig")
    except OSError as err:
        raise AttitudeError(
            f"{path}: cannot be read ({err.strerror or err}); give the name of a spin file."
        ) from err
    except UnicodeDecodeError as err:
        raise AttitudeError(
            f"{path}: is not text in UTF-8 (byte {err.start}); a spin file is a TOML text."
        ) from err
    return parse(content, path)


def parse(text, origin="text"):
    '''The body and spin of a spin file's text; `origin` begins every error message.

    >>> parse("""
    ... body.moments = [10, 20, 26]
    ... spin.epoch = "2026-01-01"
    ... spin.wxyz = [1, 0, 0, 0]
    ... spin.angular_velocity = "6, 90, 6 deg/s"
    ... """).spin
    <Spin at 2026-01-01T00:00:00 UTC: angular velocity 0.10472, 1.5708, 0.10472 rad/s in body axes>
    '''
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        raise AttitudeError(syntax_error(str(err), text, origin)) from err
    try:
        refuse_unknown(content, _TOP, "the file")
        labels = {key: text_of(content, key) for key in ("name", "source", "note")}
        return of_sections(content, **labels)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err


def of_sections(content, **labels):
    """The `SpinFile` of the sections [body] and [spin] of a parsed text, and its labels."""
    body = _body(_section(content, "body"))
    return SpinFile(body, _spin(_section(content, "spin")), **labels)


def write(path, motion, *, name=None, source=None, note=None):
    """Write the body and spin of a motion, exactly: what is read back has the same bits.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    motion : FreeRotation, or a SpinFile
        Anything with a body and a spin; names, source and note of a SpinFile are kept.
    name, source, note : str, optional
    """
    content = text(motion, name=name, source=source, note=note)
    try:
        content.encode()
    except UnicodeEncodeError as err:
        raise AttitudeError(
            f"name, source or note holds {content[err.start]!r}, which is no character of UTF-8; "
            "leave it out."
        ) from err
    with written_whole(path, "spin file") as file:
        file.write(content)


def text(motion, *, name=None, source=None, note=None):
    """The text of a spin file; see `write`."""
    if not isinstance(getattr(motion, "body", None), Body):
        raise AttitudeError(
            f"motion is {motion!r}; a spin file holds a FreeRotation, or what read() returned."
        )
    body, spin = motion.body, motion.spin
    labels = {"name": name, "source": source, "note": note}
    lines = []
    for key, label in labels.items():
        label = getattr(motion, key, None) if label is None else label
        if label is not None:
            lines.append(f"{key} = {_quoted(label, key)}")
    lines += ["", "[body]", *_body_lines(body), "", "[spin]"]
    lines += [
        f"epoch = {_quoted(_epoch_text(spin.epoch), 'epoch')}  # {spin.epoch.utc_iso} UTC",
        f"frame = {_quoted(spin.frame, 'frame')}",
        f"wxyz = {_listed(spin.wxyz)}  # body to frame",
        f"angular_velocity = {_listed(spin.angular_velocity)}  # rad/s, body axes",
    ]
    return "\n".join(lines).lstrip("\n") + "\n"


# Reading: sections and keys -----------------------------------------------------------------------


def _body(section):
    way = _way(section, _BODIES, (), "body")
    relative = section.get("relative", False)
    if not isinstance(relative, bool):
        raise AttitudeError(f"[body] relative is {relative!r}; give true or false.")
    inertia, length = (None, None) if relative else ("kg m2", "m")
    extra = {}
    if "mass" in section:
        extra["mass"] = _numbers(section, "body", "mass", (), "kg")
    if "center_of_mass" in section:
        extra["center_of_mass"] = _numbers(section, "body", "center_of_mass", (3,), "m")
    if way == "moments":
        moments = _numbers(section, "body", "moments", (3,), inertia)
        return Body(moments=moments, relative=relative, **extra)
    if way == "tensor":
        tensor = _numbers(section, "body", "tensor", (3, 3), inertia)
        return Body(tensor=tensor, relative=relative, **extra)
    if way == "ellipsoid":
        axes = _numbers(section, "body", "ellipsoid", (3,), "m" if extra else None)
        return Body.from_ellipsoid(axes, **extra)
    masses = _numbers(section, "body", "masses", None, None if relative else "kg")
    positions = _numbers(section, "body", "positions", (..., 3), length)
    return Body.from_points(masses, positions, relative=relative)


def _spin(section):
    way = _way(section, _ATTITUDES, (*_SPIN, "frame"), "spin")
    for key in _SPIN:
        if key not in section:
            raise AttitudeError(_lacking("spin", key))
    given = {
        "epoch": _epoch(section["epoch"]),
        "angular_velocity": _numbers(section, "spin", "angular_velocity", (3,), "rad/s"),
        "frame": section.get("frame", "icrf"),
    }
    if way == "wxyz":
        return Spin(wxyz=_numbers(section, "spin", "wxyz", (4,), None), **given)
    if way == "matrix":
        return Spin.from_matrix(matrix=_numbers(section, "spin", "matrix", (3, 3), None), **given)
    angles = _numbers(section, "spin", "angles", (3,), "rad")
    return Spin.from_euler(sequence=section["sequence"], angles=angles, **given)


def _section(content, name):
    if name not in content:
        raise AttitudeError(f"the file has no section [{name}]; a spin file has [body] and [spin].")
    if not isinstance(content[name], dict):
        raise AttitudeError(f"{name} is {content[name]!r}; give a section that begins [{name}].")
    return content[name]


def _way(section, ways, common, name):
    """Which of several ways to say the same a section takes; no key may be unknown or surplus."""
    known = [*common]
    for way, (needed, optional) in ways.items():
        known += [way, *needed, *optional]
    refuse_unknown(section, known, f"[{name}]")
    taken = [way for way in ways if way in section]
    if not taken:
        # Half of a pair was given: say what the other half is.
        for way, (needed, _) in ways.items():
            if any(key in section for key in needed):
                raise AttitudeError(_lacking(name, way))
        raise AttitudeError(f"[{name}] has none of {_or(_spelled(ways))}; give one of them.")
    if len(taken) > 1:
        raise AttitudeError(f"[{name}] has both {taken[0]} and {taken[1]}; give one of them.")
    needed, optional = ways[taken[0]]
    for key in needed:
        if key not in section:
            raise AttitudeError(_lacking(name, key))
    for key in section:
        if key not in (*common, taken[0], *needed, *optional):
            raise AttitudeError(f"[{name}] {key} does not go with {taken[0]}; leave it out.")
    return taken[0]


def refuse_unknown(section, known, where):
    for key in section:
        if key not in known:
            near = difflib.get_close_matches(key.lower(), known, n=1)
            raise AttitudeError(
                f"{where} has a key {key!r} that is not known; "
                + (
                    f"did you mean {near[0]!r}?"
                    if near
                    else f"allowed are {_or(sorted(set(known)))}."
                )
            )


_EXAMPLES = {
    "epoch": '"2026-01-01T00:00:00"',
    "angular_velocity": '"14.51, 33.529, -98.709 deg/day"',
    "sequence": '"313"',
    "angles": '"145.498, 65.865, 241.524 deg"',
    "masses": '["1 kg", "2 kg"]',
    "positions": '["0, 0, 1 m", "0, 1, 0 m"]',
}


def _lacking(section, key):
    return f"[{section}] has no {key}; give it, for example as {key} = {_EXAMPLES[key]}."


def _spelled(ways):
    return [" with ".join((way, *needed)) for way, (needed, _) in ways.items()]


def _or(words):
    return ", ".join(words[:-1]) + " or " + words[-1]


def text_of(content, key):
    value = content.get(key)
    if value is not None and not isinstance(value, str):
        raise AttitudeError(f"{key} is {value!r}; give text in quotes.")
    return value


def _epoch(value):
    if not isinstance(value, str):
        # TOML's own dates end at the microsecond, and what follows is lost without a word.
        raise AttitudeError(
            f"[spin] epoch is {value!s} without quotes; write it as text, like "
            '"2026-01-01T00:00:00".'
        )
    found = _TWO_DOUBLES.fullmatch(value)
    if found:
        return epochs.Instant(float(found.group(1)), float(found.group(2)))
    return epochs.instant(value, "[spin] epoch")


# Reading: numbers ---------------------------------------------------------------------------------


def _numbers(section, where, key, shape, unit):
    name = f"[{where}] {key}"
    return gates.real(_converted(section[key], name, unit), name, shape=shape, unit=unit)


def _converted(value, name, unit):
    """Text and lists of it as nested lists of floats in the unit."""
    if isinstance(value, str):
        return measured.in_unit(value, name, unit).tolist()
    if isinstance(value, list):
        kinds = {_kind(each) for each in value}
        if len(kinds) > 1:
            raise AttitudeError(
                f"{name} mixes plain numbers, text and lists; give all of its entries in one way."
            )
        return [_converted(each, name, unit) for each in value]
    if _kind(value) != "number":
        raise AttitudeError(f"{name} is {value!r}; give numbers, or text with a unit.")
    try:
        return float(value)
    except OverflowError as err:
        raise AttitudeError(f"{name} is {str(value)[:20]}..., too large a number.") from err


def _kind(value):
    if isinstance(value, bool):
        return "bool"
    return {int: "number", float: "number"}.get(type(value), type(value).__name__)


def syntax_error(message, text, origin):
    found = re.fullmatch(r"(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)", message)
    if found is None:
        return f"{origin}: is not valid TOML: {message}."
    what, line, column = found.groups()
    line = line or text.rstrip().count("\n") + 1
    where = f"line {line}" + (f", column {column}" if column else " (the end)")
    return f"{origin}, {where}: is not valid TOML: {what[:1].lower() + what[1:]}."


# Writing ------------------------------------------------------------------------------------------


def _body_lines(body):
    unit = "relative" if body.relative else "kg m2"
    if np.array_equal(body.tensor, np.diag(body.moments)):
        lines = [f"moments = {_listed(body.moments)}  # {unit}"]
    else:
        rows = [f"    {_listed(row)}," for row in body.tensor]
        lines = [f"tensor = [  # {unit}", *rows, "]"]
    if body.mass is not None:
        lines.append(f"mass = {float(body.mass)!r}  # kg")
    if np.any(body.center_of_mass):
        lines.append(f"center_of_mass = {_listed(body.center_of_mass)}  # m")
    if body.relative:
        lines.append("relative = true")
    return lines


def _epoch_text(instant):
    iso = instant.utc_iso
    if epochs.instant(iso) == instant:
        return iso
    return f"{instant.seconds!r} + {instant.low!r} s TDB since J2000"


def _listed(row):
    return "[" + ", ".join(repr(float(number)) for number in row) + "]"


def _quoted(value, key):
    if not isinstance(value, str):
        raise AttitudeError(f"{key} is {value!r}; give text.")
    # JSON escapes as TOML does, but for the delete character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
