"""Spin files: a body and its state of rotation in TOML, which determine its free motion.

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

    [errors]
    attitude = "3 deg"
    angular_velocity = "0.1, 0.2, 0.5 deg/day"
    moments = [0.02, 0.02, 0.0]

=========  =========================================================================================
[body]     ``moments`` (three), or ``tensor`` (three rows), or ``ellipsoid`` (three semi-axes), or
           ``masses`` with ``positions``; as in `Body`, `Body.from_ellipsoid`, `Body.from_points`;
           or the ratios of papers, ``A_over_C`` with ``B_over_C``.
           ``mass``, ``center_of_mass``; ``relative = true`` where the unit of inertia is unknown.
[spin]     ``epoch`` (UTC, or with the name of a time scale behind it), ``angular_velocity`` over
           the body axes, and the attitude from body axes to ``frame`` ("icrf" if left out): one of
           ``wxyz`` (scalar first), ``matrix`` (three rows), ``sequence`` with ``angles``.  Or a
           published state, as of `Spin.from_periods`: ``mode`` ("LAM", "SAM"), ``convention``
           ("L", "S"), ``P_psi``, ``P_phi``, ``pole`` (longitude, latitude in ``frame``, "ecliptic"
           if left out), ``phi0``, ``psi0``, ``epoch``, and ``theta_branch`` where psi librates.
[errors]   optional; one standard deviation, one number or three: ``attitude`` (about the axes of
           ``frame``), ``angular_velocity`` (body axes), ``moments`` (of the principal moments, in
           the unit of the body); or ``covariance``, nine or six rows as of `Spin`, in rad, rad/s
           and the unit of the body.
top level  ``name``, ``source``, ``note``: text, all optional.
=========  =========================================================================================

A number is plain, in SI units and radians, or text with a unit.  A list is written
``[1.0, 2.0, 3.0]``, ``"1, 2, 3 deg/day"`` or ``["1 deg/day", "2 deg/day", "0.5 rpm"]``.  An epoch
that differs from its date to the nanosecond is written as two doubles,
``"820497600.0 + 1.5e-12 s TDB since J2000"``.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs
from attitude.body import Body
from attitude.errors import AttitudeError, quoted
from attitude.formats import spin_sections
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.immutable import Immutable
from attitude.sensitivities import covariance as covariances
from attitude.spin import Spin
from attitude.textfiles import toml
from attitude.textfiles.atomic_write import written_whole

if TYPE_CHECKING:
    from collections.abc import Mapping

    from attitude.annotations import FilePath

_KEYS = ("name", "source", "note", "body", "spin", "errors")


@dataclass(frozen=True, eq=False)
class SpinFile(Immutable):
    """The content of a spin file.

    Attributes
    ----------
    body : Body
    spin : Spin
    name, source, note : str or None
        Name of the body, source of the numbers, remarks.
    motion : FreeRotation
    """

    body: Body
    spin: Spin
    name: str | None = None
    source: str | None = None
    note: str | None = None

    @cached_property
    def motion(self) -> FreeRotation:
        """The free rotation of the body from its spin."""
        return FreeRotation(self.body, self.spin)


def read(path: FilePath) -> SpinFile:
    """The body and spin in a spin file.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    SpinFile

    Raises
    ------
    AttitudeError
        For a file that cannot be read or is not TOML, for missing, unknown or surplus keys, for
        values of a wrong type, shape or unit, and as `Body` and `Spin`; each message begins with
        the name of the file.
    """
    path = os.fspath(path)
    return parse(toml.read(path, "spin file"), path)


def parse(text: str, origin: str = "text") -> SpinFile:
    '''The body and spin in the text of a spin file; `origin` begins every error message.

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
        toml.refuse_unknown(content, _KEYS, "the file")
        labels = {key: toml.text_of(content, key) for key in ("name", "source", "note")}
        return of_sections(content, **labels)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err


def of_sections(content: Mapping[str, Any], **labels: str | None) -> SpinFile:
    """The `SpinFile` of the sections [body], [spin] and [errors] of a parsed text.

    `labels` are its name, source and note.  AttitudeError as `read`.
    """
    body, spin = spin_sections.body_and_spin(content)
    return SpinFile(body, spin, **labels)


def write(
    path: FilePath,
    motion: FreeRotation | SpinFile,
    *,
    name: str | None = None,
    source: str | None = None,
    note: str | None = None,
) -> None:
    """Write body, spin and errors of a motion exactly: `read` gives the same bits.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    motion : FreeRotation or SpinFile
        Name, source and note of a SpinFile are kept unless others are given.
    name, source, note : str, optional

    Raises
    ------
    AttitudeError
        For another type of motion, labels that are not text in UTF-8, or a file that cannot be
        written.
    """
    content = text(motion, name=name, source=source, note=note)
    try:
        content.encode()
    except UnicodeEncodeError as err:
        raise AttitudeError(
            f"name, source or note holds {content[err.start]!r}, which UTF-8 cannot encode; leave "
            "it out."
        ) from err
    with written_whole(path, "spin file") as file:
        file.write(content)


def text(
    motion: FreeRotation | SpinFile,
    *,
    name: str | None = None,
    source: str | None = None,
    note: str | None = None,
) -> str:
    """The text of a spin file; see `write` for the parameters."""
    if not isinstance(motion, (FreeRotation, SpinFile)):
        raise AttitudeError(
            f"motion is {quoted(motion)}; a spin file holds a FreeRotation. Give one, or a "
            "SpinFile."
        )
    body, spin = motion.body, motion.spin
    labels = {"name": name, "source": source, "note": note}
    lines: list[str] = []
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
        *_error_lines(spin.covariance),
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


def _error_lines(covariance):
    """Standard deviations if they give the same bits, else the rows of the covariance."""
    if covariance is None:
        return []
    sigma = covariances.components(covariance)
    if sigma is not None:
        rows = {key: each for key, each in sigma.items() if np.any(each)} or {
            "attitude": np.zeros(3)
        }
        return ["", "[errors]", *(f"{key} = {_listed(row)}" for key, row in rows.items())]
    part = covariance[:6, :6]
    whole = np.zeros((9, 9))
    whole[:6, :6] = part
    kept = part if whole.tobytes() == covariance.tobytes() else covariance
    unit = "rad, axes of the frame; rad/s, body axes" + ("; moments" if len(kept) == 9 else "")
    return [
        "",
        "[errors]",
        f"covariance = [  # {unit}",
        *(f"    {_listed(row)}," for row in kept),
        "]",
    ]


def _epoch_text(instant):
    iso = instant.utc_iso
    if epochs.instant(iso) == instant:
        return iso
    return f"{instant.seconds!r} + {instant.low!r} s TDB since J2000"


def _listed(row):
    return "[" + ", ".join(repr(float(number)) for number in row) + "]"
