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
           or the ratios of papers, ``A_over_C`` with ``B_over_C``; or ``density`` (kg/m3) of the
           ellipsoid or of the solid of [shape].
           ``mass``, ``center_of_mass``; ``relative = true`` where the unit of inertia is unknown.
[spin]     ``epoch`` (UTC, or with the name of a time scale behind it), ``angular_velocity`` over
           the body axes, and the attitude from body axes to ``frame`` ("icrf" if left out): one of
           ``wxyz`` (scalar first), ``matrix`` (three rows), ``sequence`` with ``angles``.  Or a
           published state, as in `Spin.from_periods`: ``mode`` ("LAM", "SAM"), ``convention``
           ("L", "S"), ``P_psi``, ``P_phi``, ``pole`` (longitude, latitude in ``frame``, "ecliptic"
           if left out), ``phi0``, ``psi0``, ``epoch``, and ``theta_branch`` where psi librates or
           theta0 exceeds 90 degrees.
           Of a relaxed rotator: ``P``, ``pole``, ``phi0``, ``epoch``.
[errors]   optional; one standard deviation, one number or three: ``attitude`` (about the axes of
           ``frame``), ``angular_velocity`` (body axes), ``moments`` (of the principal moments, in
           the unit of the body); or ``covariance``, nine or six rows as in `Spin`, in rad, rad/s
           and the unit of the body.
[shape]    optional, with [scattering]: the shape of the body and its scattering law, as in mission
           files (`attitude.formats.mission`), which take them where they have no [shape].
top level  ``name``, ``source``, ``note``: text, all optional.
=========  =========================================================================================

A number is plain, in SI units and radians, or text with a unit.  A list is written
``[1.0, 2.0, 3.0]``, ``"1, 2, 3 deg/day"`` or ``["1 deg/day", "2 deg/day", "0.5 rpm"]``.  An epoch
that differs from its date to the nanosecond is written as two doubles,
``"820497600.0 + 1.5e-12 s TDB since J2000"``.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import covariance as covariances
from attitude._support import validation
from attitude._support.arrays import Immutable
from attitude._support.quantity_text import quoted
from attitude._textfiles import toml
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import cut, path_text, prefixed
from attitude._textfiles.toml import listed, refuse_unknown
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.formats._format import Format, OpenedFile, refuse_foreign, register
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._published import moments_from_ratios
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Mapping

    from attitude._support.annotations import FilePath
    from attitude.scattering._law import Law
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh

__all__ = ["SpinFile", "of_sections", "parse", "read", "text", "write"]


# ---- The sections [body], [spin] and [errors] of spin and mission files, as a Body and a Spin

# Alternatives for a body and an attitude: leading key -> further keys needed, keys allowed.
_BODIES = {
    "moments": ((), ("mass", "relative", "center_of_mass")),
    "tensor": ((), ("mass", "relative", "center_of_mass")),
    "ellipsoid": ((), ("mass", "density")),
    "masses": (("positions",), ("relative",)),
    "A_over_C": (("B_over_C",), ()),
    "density": ((), ()),
}
_ATTITUDES = {"wxyz": ((), ()), "matrix": ((), ()), "sequence": (("angles",), ())}
_SPIN = ("epoch", "angular_velocity")
# Keys of a published state, with their units; those that may be left out.
_PUBLISHED = {"P_psi": "s", "P_phi": "s", "pole": "rad", "phi0": "rad", "psi0": "rad", "P": "s"}
_PUBLISHED_WORDS = ("mode", "convention")
_OF_PUBLISHED = ("theta_branch", "frame")
_ERRORS = ("attitude", "angular_velocity", "moments")
_FLOAT = r"[+-]?[0-9.]+(?:e[+-]?[0-9]+)?"
_TWO_DOUBLES = re.compile(rf"({_FLOAT}) \+ ({_FLOAT}) s TDB since J2000")
_EXAMPLES = {
    "epoch": '"2026-01-01T00:00:00"',
    "angular_velocity": '"14.51, 33.529, -98.709 deg/day"',
    "sequence": '"313"',
    "angles": '"145.498, 65.865, 241.524 deg"',
    "masses": '["1 kg", "2 kg"]',
    "positions": '["0, 0, 1 m", "0, 1, 0 m"]',
    "A_over_C": "0.61",
    "B_over_C": "0.965",
    "mode": '"SAM"',
    "convention": '"S"',
    "P": '"4.3 h"',
    "P_psi": '"263 h"',
    "P_phi": '"27.38 h"',
    "pole": '"250, -75 deg"',
    "phi0": '"152 deg"',
    "psi0": '"14 deg"',
}


def body_and_spin(content: Mapping[str, Any], shape: Any, folder: str) -> tuple[Body, Spin]:
    """The Body and the Spin of the sections [body], [spin] and [errors] of a parsed text.

    shape: the section [shape], of which a density makes the body; folder: of its file.
    """
    body = _body(_section(content, "body"), shape, folder)
    section = _section(content, "spin")
    published = any(key in section for key in (*_PUBLISHED, *_PUBLISHED_WORDS))
    spin = _published(section, body) if published else _spin(section)
    return body, with_errors(content, body, spin)


def with_errors(content: Mapping[str, Any], body: Body, spin: Spin) -> Spin:
    """The Spin with the covariance of the section [errors], or itself without that section."""
    if "errors" not in content:
        return spin
    section = _section(content, "errors")
    refuse_unknown(section, ("covariance", *_ERRORS), "[errors]")
    if not section:
        raise AttitudeError(
            "[errors] is empty; give standard deviations (attitude, angular_velocity, moments) or "
            "covariance, or leave the section out."
        )
    for key in _ERRORS:
        if "covariance" in section and key in section:
            raise AttitudeError(f"[errors] has both covariance and {key}; give one of them.")
    units = {**covariances.UNITS, "moments": None if body.relative else "kg m2", "covariance": None}
    errors = {key: _numbers(section, "errors", key, None, units[key]) for key in section}
    if "covariance" in errors:
        known = covariances.known(errors["covariance"], "[errors] covariance")
    else:
        known = covariances.known(errors, "[errors]")
    return spin.with_covariance(known)


def _body(section, shape, folder):
    way = _way(section, _BODIES, (), "body")
    relative = section.get("relative", False)
    if not isinstance(relative, bool):
        raise AttitudeError(f"[body] relative is {quoted(relative)}; give true or false.")

    def value(key, shape, unit=None):
        return _numbers(section, "body", key, shape, None if relative and unit != "m" else unit)

    extra = {}
    if "mass" in section:
        extra["mass"] = _numbers(section, "body", "mass", (), "kg")
    if "center_of_mass" in section:
        extra["center_of_mass"] = value("center_of_mass", (3,), "m")
    if way == "moments":
        return Body(moments=value("moments", (3,), "kg m2"), relative=relative, **extra)
    if way == "tensor":
        return Body(tensor=value("tensor", (3, 3), "kg m2"), relative=relative, **extra)
    if way == "ellipsoid":
        axes = value("ellipsoid", (3,), "m")
        if "density" in section:
            if extra:
                raise AttitudeError("[body] has both mass and density; give one of them.")
            from attitude.shape._ellipsoid import Ellipsoid

            density = float(value("density", (), "kg/m3"))
            return Body.from_shape(Ellipsoid(axes), density=density)
        return Body.from_ellipsoid(axes, **extra)
    if way == "A_over_C":
        ratios = (float(value(key, ())) for key in ("A_over_C", "B_over_C"))
        return Body(moments=moments_from_ratios(*ratios), relative=True)
    if way == "density":
        if shape is None:
            raise AttitudeError("[body] density is that of a section [shape]; give the section.")
        from attitude.formats import _surface as surface

        solid = surface.shape_of(shape, None, partial(surface.beside, folder=folder))["shape"]
        return Body.from_shape(solid, density=float(value("density", (), "kg/m3")))
    masses = value("masses", None, "kg")
    positions = _numbers(section, "body", "positions", (..., 3), None if relative else "m")
    return Body.from_points(masses, positions, relative=relative)


def _spin(section):
    way = _way(section, _ATTITUDES, (*_SPIN, "frame"), "spin")
    _require(section, "spin", _SPIN)
    values = {
        "epoch": _epoch(section["epoch"]),
        "angular_velocity": _numbers(section, "spin", "angular_velocity", (3,), "rad/s"),
        "frame": section.get("frame", "icrf"),
    }
    if way == "wxyz":
        return Spin(wxyz=_numbers(section, "spin", "wxyz", (4,), None), **values)
    if way == "matrix":
        return Spin.from_matrix(matrix=_numbers(section, "spin", "matrix", (3, 3), None), **values)
    angles = _numbers(section, "spin", "angles", (3,), "rad")
    return Spin.from_euler(sequence=section["sequence"], angles=angles, **values)


def _published(section, body):
    """The Spin of a state as papers print it: mode, convention, periods, pole, angles."""
    known = (*_PUBLISHED_WORDS, *_PUBLISHED, "epoch")
    refuse_unknown(section, (*known, *_OF_PUBLISHED, *_ATTITUDES, *_SPIN), "[spin]")
    for key in (*_ATTITUDES, "angular_velocity"):
        if key in section:
            raise AttitudeError(
                f"[spin] {key} does not go with a published state (mode, convention, P_psi ...); "
                "leave one of them out."
            )
    one = ("P", "pole", "phi0", "epoch")
    _require(section, "spin", one if "P" in section else [key for key in known if key != "P"])
    values = {key: section[key] for key in (*_PUBLISHED_WORDS, *_OF_PUBLISHED) if key in section}
    for key in [key for key in _PUBLISHED if key in section]:
        shape = (2,) if key == "pole" else ()
        number = _numbers(section, "spin", key, shape, _PUBLISHED[key])
        values[key] = number if key == "pole" else float(number)
    return Spin.from_periods(body, epoch=_epoch(section["epoch"]), **values)


def _section(content, name):
    if name not in content:
        raise AttitudeError(f"the file has no section [{name}]; a spin file has [body] and [spin].")
    return toml.section_of(content[name], name)


def _way(section, ways, common, name):
    """The leading key of the one alternative that a section uses."""
    known = [*common]
    for way, (needed, optional) in ways.items():
        known += [way, *needed, *optional]
    refuse_unknown(section, known, f"[{name}]")
    taken = [way for way in ways if way in section]
    taken = [way for way in taken if not any(way in ways[other][1] for other in taken)]
    if not taken:
        # Half of a pair was given: the message names the other half.
        for way, (needed, _) in ways.items():
            if any(key in section for key in needed):
                _require(section, name, [way])
        spelled = [" with ".join((way, *needed)) for way, (needed, _) in ways.items()]
        raise AttitudeError(f"[{name}] has none of {listed(spelled)}; give one of them.")
    if len(taken) > 1:
        raise AttitudeError(f"[{name}] has both {taken[0]} and {taken[1]}; give one of them.")
    needed, optional = ways[taken[0]]
    _require(section, name, needed)
    for key in section:
        if key not in (*common, taken[0], *needed, *optional):
            raise AttitudeError(
                f"[{name}] {cut(key, '')} does not go with {taken[0]}; leave it out."
            )
    return taken[0]


def _require(section, name, keys):
    """AttitudeError for the first key that a section lacks."""
    for key in keys:
        if key not in section:
            raise AttitudeError(
                f"[{name}] has no {key}; give it, for example as {key} = {_EXAMPLES[key]}."
            )


def _epoch(value):
    if not isinstance(value, str):
        # TOML's own dates end at the microsecond; the parser drops further digits silently.
        raise AttitudeError(
            f"[spin] epoch is {value!s} without quotes; write it as text, like "
            '"2026-01-01T00:00:00".'
        )
    match = _TWO_DOUBLES.fullmatch(value)
    if match:
        return _instants.Instant(float(match.group(1)), float(match.group(2)))
    return _inputs.instant(value, "[spin] epoch")


# ---- Numbers


def _numbers(section, where, key, shape, unit):
    name = f"[{where}] {key}"
    return validation.real(_converted(section[key], name, unit), name, shape=shape, unit=unit)


def _converted(value, name, unit):
    """A number, a text or nested lists of them as floats in the unit."""
    if isinstance(value, str):
        return validation.real(value, name, unit=unit).tolist()
    if isinstance(value, list):
        kinds = {_kind(item) for item in value}
        if len(kinds) > 1:
            raise AttitudeError(
                f"{name} mixes plain numbers, text and lists; give all of its entries in one way."
            )
        return [_converted(item, name, unit) for item in value]
    if _kind(value) != "number":
        raise AttitudeError(f"{name} is {quoted(value)}; give numbers, or text with a unit.")
    try:
        return float(value)
    except OverflowError as err:
        raise AttitudeError(f"{name} is {cut(value)}, too large a number.") from err


def _kind(value):
    return {int: "number", float: "number"}.get(type(value), type(value).__name__)


_KEYS = ("name", "source", "note", "body", "spin", "errors", "shape", "scattering")
# Keys that mission files have and spin files have not.
OF_MISSIONS: frozenset[str] = frozenset(
    ("center", "observer", "sun", "columns", "times", "magnitude", "torque")
)


@dataclass(frozen=True, eq=False)
class SpinFile(Immutable):
    """The content of a spin file.

    Attributes
    ----------
    body : Body
    spin : Spin
    name, source, note : str or None
        Name of the body, source of the numbers, remarks.
    shape : Ellipsoid, Mesh or None
    law : Law or None
        How its surface scatters light.
    motion : FreeRotation
    """

    body: Body
    spin: Spin
    name: str | None = None
    source: str | None = None
    note: str | None = None
    shape: Ellipsoid | Mesh | None = None
    law: Law | None = None

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
    path = path_text(path)
    return parse(toml.read(path, "spin file"), path, folder=os.path.dirname(path))


def parse(text: str, origin: str = "text", *, folder: str = ".") -> SpinFile:
    '''The body and spin in the text of a spin file.

    `origin` begins every error message; names of files are relative to `folder`.

    >>> parse("""
    ... body.moments = [10, 20, 26]
    ... spin.epoch = "2026-01-01"
    ... spin.wxyz = [1, 0, 0, 0]
    ... spin.angular_velocity = "6, 90, 6 deg/s"
    ... """).spin
    <Spin at 2026-01-01T00:00:00 UTC: angular velocity 0.10472, 1.5708, 0.10472 rad/s in body axes>
    '''
    content = toml.parsed(text, origin)
    with prefixed(origin):
        of_mission = OF_MISSIONS & content.keys()
        if of_mission:
            raise AttitudeError(
                f"the file has a key {min(of_mission)!r}, which mission files have: "
                "attitude.formats.mission reads it (read_motion its motion); a spin file has the "
                "sections [body], [spin], [errors] and [shape]."
            )
        refuse_unknown(content, _KEYS, "the file")
        labels = {key: toml.text_of(content, key) for key in ("name", "source", "note")}
        return of_sections(content, folder, **labels)


def of_sections(content: Mapping[str, Any], folder: str = ".", **labels: str | None) -> SpinFile:
    """The `SpinFile` of the sections [body], [spin], [errors] and [shape] of a parsed text.

    `labels` are its name, source and note.  AttitudeError as `read`.
    """
    body, spin = body_and_spin(content, content.get("shape"), folder)
    shape, law = _surface(content, body, folder)
    return SpinFile(body, spin, **labels, shape=shape, law=law)


def _surface(content, body, folder):
    """Shape and law of the sections [shape] and [scattering]; None without [shape]."""
    if "shape" not in content:
        if "scattering" in content:
            raise AttitudeError(
                "the file has a section [scattering], but no [shape]; give a shape."
            )
        return None, None
    from attitude.formats import _surface as surface

    file = partial(surface.beside, folder=folder)
    settings = surface.shape_of(content["shape"], body, file)
    if "shadows" in settings:
        raise AttitudeError("[shape] shadows belongs to a mission file; leave it out.")
    law = surface.law_of(content.get("scattering", {}), settings["shape"])
    return surface.facets_for(content["shape"], settings["shape"], law), law


def write(
    path: FilePath,
    motion: FreeRotation | SpinFile,
    *,
    name: str | None = None,
    source: str | None = None,
    note: str | None = None,
    shape: Ellipsoid | Mesh | None = None,
    law: Law | None = None,
) -> None:
    """Write body, spin, errors and shape exactly: `read` gives the same bits.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.  Its ending is not that of another format.
    motion : FreeRotation or SpinFile
        Name, source, note, shape and law of a SpinFile are kept unless others are given.
    name, source, note : str, optional
    shape : Ellipsoid or Mesh, optional
    law : Law, optional
        Of the shape; a law with a name, or Materials.

    Raises
    ------
    AttitudeError
        For another type of motion, a law without a shape or a name, labels that are not text in
        UTF-8, the ending of another format, or a file that cannot be written.
    """
    refuse_foreign(path, "spin")
    content = text(motion, name=name, source=source, note=note, shape=shape, law=law)
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
    shape: Ellipsoid | Mesh | None = None,
    law: Law | None = None,
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
        *_surface_lines(motion, shape, law),
    ]
    return "\n".join(lines).lstrip("\n") + "\n"


# ---- The lines of the text


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
        rows = {key: deviations for key, deviations in sigma.items() if np.any(deviations)}
        rows = rows or {"attitude": np.zeros(3)}
        return ["", "[errors]", *(f"{key} = {_listed(row)}" for key, row in rows.items())]
    whole = np.zeros((9, 9))
    whole[:6, :6] = covariance[:6, :6]
    kept = whole[:6, :6] if whole.tobytes() == covariance.tobytes() else covariance
    unit = "rad, axes of the frame; rad/s, body axes" + ("; moments" if len(kept) == 9 else "")
    rows = [f"    {_listed(row)}," for row in kept]
    return ["", "[errors]", f"covariance = [  # {unit}", *rows, "]"]


def _surface_lines(motion, shape, law):
    """The sections [shape] and [scattering], if there is a shape."""
    if isinstance(motion, SpinFile):
        shape, law = shape or motion.shape, law or motion.law
    if shape is None:
        if law is not None:
            raise AttitudeError("law is given, but no shape whose law it is; give shape= too.")
        return []
    from attitude.formats import _surface as surface

    lines = ["", *surface.shape_lines(shape)]
    return lines if law is None else [*lines, "", *surface.law_lines(law)]


def _epoch_text(instant):
    iso = instant.utc_iso
    if _inputs.instant(iso) == instant:
        return iso
    return f"{instant.seconds!r} + {instant.low!r} s TDB since J2000"


def _listed(row):
    return "[" + ", ".join(repr(float(number)) for number in row) + "]"


def _opened(path):
    file = read(path)
    names = ("name", "source", "note", "shape", "law")
    return OpenedFile(file.motion, {name: getattr(file, name) for name in names})


def _labels(motion, said):
    """The labels of a spin file, from the names and comments of the file that was read."""
    name = said.get("name") or said.get("object_name")
    note = said.get("note") or " ".join(said.get("comments", ()))
    labels = {"name": name if name != "UNKNOWN" else None, "source": said.get("source")}
    labels |= {"note": note, "shape": said.get("shape"), "law": said.get("law")}
    return {key: text for key, text in labels.items() if text}


register(
    Format(
        name="spin",
        module=__name__,
        title="spin file, exact",
        endings=(".toml",),
        read=_opened,
        reading=(),
        write=write,
        holds="motion",
        labels=_labels,
    )
)
