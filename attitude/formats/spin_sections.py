"""The sections [body], [spin] and [errors] of spin and mission files, as a Body and a Spin.

See `spin_file` for the keys.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from attitude import epochs, validation
from attitude.body import Body
from attitude.errors import AttitudeError, quoted
from attitude.published.dynamic_inertia import moments_from_ratios
from attitude.sensitivities import covariance as covariances
from attitude.spin import Spin
from attitude.textfiles.lines import cut
from attitude.textfiles.toml import listed, refuse_unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

# Alternatives for a body and an attitude: leading key -> further keys needed, keys allowed.
_BODIES = {
    "moments": ((), ("mass", "relative", "center_of_mass")),
    "tensor": ((), ("mass", "relative", "center_of_mass")),
    "ellipsoid": ((), ("mass",)),
    "masses": (("positions",), ("relative",)),
    "A_over_C": (("B_over_C",), ()),
}
_ATTITUDES = {"wxyz": ((), ()), "matrix": ((), ()), "sequence": (("angles",), ())}
_SPIN = ("epoch", "angular_velocity")
# Keys of a published state, with their units; those that may be left out.
_PUBLISHED = {"P_psi": "s", "P_phi": "s", "pole": "rad", "phi0": "rad", "psi0": "rad"}
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
    "B_over_C": "0.965",
    "mode": '"SAM"',
    "convention": '"S"',
    "P_psi": '"263 h"',
    "P_phi": '"27.38 h"',
    "pole": '"250, -75 deg"',
    "phi0": '"152 deg"',
    "psi0": '"14 deg"',
}


def body_and_spin(content: Mapping[str, Any]) -> tuple[Body, Spin]:
    """The Body and the Spin of the sections [body], [spin] and [errors] of a parsed text.

    Raises
    ------
    AttitudeError
        For missing, unknown or surplus keys, values of a wrong type, shape or unit, and as `Body`
        and `Spin`.
    """
    body = _body(_section(content, "body"))
    section = _section(content, "spin")
    published = any(key in section for key in (*_PUBLISHED, *_PUBLISHED_WORDS))
    spin = _published(section, body) if published else _spin(section)
    return body, with_errors(content, body, spin)


def with_errors(content: Mapping[str, Any], body: Body, spin: Spin) -> Spin:
    """The Spin with the covariance of the section [errors], or itself without that section.

    Raises
    ------
    AttitudeError
        For unknown keys, a covariance beside standard deviations, values of a wrong type, shape,
        unit or sign, and as `Spin`.
    """
    if "errors" not in content:
        return spin
    section = _section(content, "errors")
    refuse_unknown(section, ("covariance", *_ERRORS), "[errors]")
    if not section:
        raise AttitudeError(
            "[errors] is empty; give standard deviations (attitude, angular_velocity, moments) or "
            "covariance, or leave the section out."
        )
    if "covariance" in section:
        for key in _ERRORS:
            if key in section:
                raise AttitudeError(
                    f"[errors] has both covariance and {cut(key, '')}; give one of them."
                )
        rows = _numbers(section, "errors", "covariance", None, None)
        return spin.with_covariance(covariances.known(rows, "[errors] covariance"))
    units = {**covariances.UNITS, "moments": None if body.relative else "kg m2"}
    given = {key: _numbers(section, "errors", key, None, units[key]) for key in section}
    return spin.with_covariance(covariances.known(given, "[errors]"))


def _body(section):
    way = _way(section, _BODIES, (), "body")
    relative = section.get("relative", False)
    if not isinstance(relative, bool):
        raise AttitudeError(f"[body] relative is {quoted(relative)}; give true or false.")
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
    if way == "A_over_C":
        ratios = (_numbers(section, "body", key, (), None) for key in ("A_over_C", "B_over_C"))
        return Body(moments=moments_from_ratios(*map(float, ratios)), relative=True)
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


def _published(section, body):
    """The Spin of a state as papers print it: mode, convention, periods, pole, angles."""
    needed = (*_PUBLISHED_WORDS, *_PUBLISHED, "epoch")
    refuse_unknown(section, (*needed, *_OF_PUBLISHED, *_ATTITUDES, *_SPIN), "[spin]")
    for key in (*_ATTITUDES, "angular_velocity"):
        if key in section:
            raise AttitudeError(
                f"[spin] {key} does not go with a published state (mode, convention, P_psi ...); "
                "leave one of them out."
            )
    for key in needed:
        if key not in section:
            raise AttitudeError(_lacking("spin", key))
    shapes = {"pole": (2,)}
    numbers = {
        key: _numbers(section, "spin", key, shapes.get(key, ()), unit)
        for key, unit in _PUBLISHED.items()
    }
    given = {key: each if key == "pole" else float(each) for key, each in numbers.items()}
    for key in (*_PUBLISHED_WORDS, *_OF_PUBLISHED):
        if key in section:
            given[key] = section[key]
    return Spin.from_periods(body, epoch=_epoch(section["epoch"]), **given)


def _section(content, name):
    if name not in content:
        raise AttitudeError(f"the file has no section [{name}]; a spin file has [body] and [spin].")
    if not isinstance(content[name], dict):
        raise AttitudeError(
            f"{name} is {quoted(content[name])}; give a section that begins [{name}]."
        )
    return content[name]


def _way(section, ways, common, name):
    """The leading key of the alternative that a section uses.

    AttitudeError for none or several, and for unknown, missing and surplus keys.
    """
    known = [*common]
    for way, (needed, optional) in ways.items():
        known += [way, *needed, *optional]
    refuse_unknown(section, known, f"[{name}]")
    taken = [way for way in ways if way in section]
    if not taken:
        # Half of a pair was given: the message names the other half.
        for way, (needed, _) in ways.items():
            if any(key in section for key in needed):
                raise AttitudeError(_lacking(name, way))
        raise AttitudeError(f"[{name}] has none of {listed(_spelled(ways))}; give one of them.")
    if len(taken) > 1:
        raise AttitudeError(f"[{name}] has both {taken[0]} and {taken[1]}; give one of them.")
    needed, optional = ways[taken[0]]
    for key in needed:
        if key not in section:
            raise AttitudeError(_lacking(name, key))
    for key in section:
        if key not in (*common, taken[0], *needed, *optional):
            raise AttitudeError(
                f"[{name}] {cut(key, '')} does not go with {taken[0]}; leave it out."
            )
    return taken[0]


def _lacking(section, key):
    return f"[{section}] has no {key}; give it, for example as {key} = {_EXAMPLES[key]}."


def _spelled(ways):
    return [" with ".join((way, *needed)) for way, (needed, _) in ways.items()]


def _epoch(value):
    if not isinstance(value, str):
        # TOML's own dates end at the microsecond; the parser drops further digits silently.
        raise AttitudeError(
            f"[spin] epoch is {value!s} without quotes; write it as text, like "
            '"2026-01-01T00:00:00".'
        )
    found = _TWO_DOUBLES.fullmatch(value)
    if found:
        return epochs.Instant(float(found.group(1)), float(found.group(2)))
    return epochs.instant(value, "[spin] epoch")


# Numbers ------------------------------------------------------------------------------------------


def _numbers(section, where, key, shape, unit):
    name = f"[{where}] {key}"
    return validation.real(_converted(section[key], name, unit), name, shape=shape, unit=unit)


def _converted(value, name, unit):
    """A number, a text or nested lists of them as floats in the unit."""
    if isinstance(value, str):
        return validation.real(value, name, unit=unit).tolist()
    if isinstance(value, list):
        kinds = {_kind(each) for each in value}
        if len(kinds) > 1:
            raise AttitudeError(
                f"{name} mixes plain numbers, text and lists; give all of its entries in one way."
            )
        return [_converted(each, name, unit) for each in value]
    if _kind(value) != "number":
        raise AttitudeError(f"{name} is {quoted(value)}; give numbers, or text with a unit.")
    try:
        return float(value)
    except OverflowError as err:
        raise AttitudeError(f"{name} is {str(value)[:20]}..., too large a number.") from err


def _kind(value):
    if isinstance(value, bool):
        return "bool"
    return {int: "number", float: "number"}.get(type(value), type(value).__name__)
