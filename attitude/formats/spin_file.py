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

import os
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from attitude import epochs
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.formats import spin_sections
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.immutable import Immutable
from attitude.spin import Spin
from attitude.textfiles import toml
from attitude.textfiles.atomic_write import written_whole


@dataclass(frozen=True, eq=False)
class SpinFile(Immutable):
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
    return parse(toml.read(path, "spin file"), path)


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
    content = toml.parsed(text, origin)
    try:
        toml.refuse_unknown(content, ("name", "source", "note", "body", "spin"), "the file")
        labels = {key: toml.text_of(content, key) for key in ("name", "source", "note")}
        return of_sections(content, **labels)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err


def of_sections(content, **labels):
    """The `SpinFile` of the sections [body] and [spin] of a parsed text, and its labels."""
    return SpinFile(*spin_sections.body_and_spin(content), **labels)


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
    if not isinstance(motion, (FreeRotation, SpinFile)):
        raise AttitudeError(
            f"motion is {motion!r}; a spin file holds a FreeRotation, or what read() returned."
        )
    body, spin = motion.body, motion.spin
    labels = {"name": name, "source": source, "note": note}
    lines = []
    for key, label in labels.items():
        if label is None and isinstance(motion, SpinFile):
            label = getattr(motion, key)
        if label is not None:
            lines.append(f"{key} = {toml.quoted(label, key)}")
    lines += ["", "[body]", *_body_lines(body), "", "[spin]"]
    lines += [
        f"epoch = {toml.quoted(_epoch_text(spin.epoch), 'epoch')}  # {spin.epoch.utc_iso} UTC",
        f"frame = {toml.quoted(spin.frame, 'frame')}",
        f"wxyz = {_listed(spin.wxyz)}  # body to frame",
        f"angular_velocity = {_listed(spin.angular_velocity)}  # rad/s, body axes",
    ]
    return "\n".join(lines).lstrip("\n") + "\n"


# The lines of the text ----------------------------------------------------------------------------


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
