"""Sections [shape], [scattering] and [magnitude] of spin and mission files, read and written."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.quantity_text import quoted
from attitude._textfiles import toml
from attitude._textfiles.lines import prefixed
from attitude._textfiles.toml import refuse_unknown, way_of
from attitude.errors import AttitudeError
from attitude.light_curve import _magnitudes
from attitude.scattering import _law as scattering_law
from attitude.scattering import _materials as scattering_materials
from attitude.scattering import _weighted
from attitude.shape import _ellipsoid as shape_ellipsoid
from attitude.shape import _files, _mesh, _solids

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from attitude._support.annotations import FilePath, FloatArray
    from attitude.motions._body import Body
    from attitude.scattering._law import Law
    from attitude.scene._scene import Scene
    from attitude.scene._view import View


# The key of each kind of shape, with the further keys that it allows.
_SHAPES = {
    "ellipsoid": ("diameter", "facets"),
    "box": (),
    "cylinder": (),
    "box_wing": (),
    "file": ("unit", "format"),
    "mesh": (),
}
_ANY_SHAPE = ("divided", "shadows")
# Units of the numbers in tables of dimensions; None for words and whole numbers.
_CYLINDER = {"radius": "m", "height": "m", "sides": None, "axis": None}
_BOX_WING = {
    **{"body": "m", "wing": "m", "gap": "m", "thickness": "m"},
    **{"wing_axis": None, "wing_angle": "rad", "wings": None},
}
_MESH = {"vertices": "m", "facets": None, "materials": None}
# What makes a shape from a table of dimensions, these, and those that must be given.
_TABLES: dict[str, tuple[Callable[..., Any], Mapping[str, str | None], tuple[str, ...]]] = {
    "cylinder": (_solids.cylinder, _CYLINDER, ("radius", "height")),
    "box_wing": (_solids.box_wing, _BOX_WING, ("body", "wing")),
    "mesh": (lambda **table: _mesh.Mesh(**table).require_closed(), _MESH, ("vertices", "facets")),
}
# Facets of an ellipsoid by default.
FACETS = 1000


@dataclass(frozen=True)
class MagnitudeScale:
    """The kind of magnitudes of a light curve.

    Attributes
    ----------
    kind : str
        "apparent" or "reduced".
    sun_distance, observer_distance : float or None
        Distances of the body, m, for a Sun or an observer that the scene has as a direction.
    """

    kind: str
    sun_distance: float | None = None
    observer_distance: float | None = None

    def of(self, view: View, *, everywhere: bool = False) -> FloatArray:
        """The magnitudes of a View, (S,); inf where no part of the body is both lit and seen.

        NaN where a ground site does not observe it (`View.is_observable`), unless `everywhere`, or
        the scene has site_limits=False.
        """
        magnitudes = self._everywhere(view)
        return magnitudes if everywhere else view.as_observed(magnitudes)

    def _everywhere(self, view):
        if self.kind == "reduced":
            return view.reduced_magnitude
        if self.sun_distance is None and self.observer_distance is None:
            return view.magnitude_everywhere
        sun, observer = self.sun_distance, self.observer_distance
        sun = view.sun_distance if sun is None else sun
        observer = view.observer_distance if observer is None else observer
        magnitudes = view.reduced_magnitude + _magnitudes.distance_modulus(sun, observer)
        if view.scene.shadow_of:
            magnitudes = magnitudes + _magnitudes.shadow_dimming(view.lit_fraction)
        return magnitudes


def shape_of(
    section: Any, body: Body | None, opened: Callable[[Any, str], FilePath]
) -> dict[str, Any]:
    """The arguments ``shape`` and, if given, ``shadows`` of a Scene from a section [shape]."""
    section = toml.section_of(section, "shape")
    known = {*_SHAPES, *_ANY_SHAPE, *(key for words in _SHAPES.values() for key in words)}
    refuse_unknown(section, sorted(known), "[shape]")
    way = way_of(section, _SHAPES, "[shape]")
    for key in section:
        if key not in (way, *_ANY_SHAPE, *_SHAPES[way]):
            raise AttitudeError(
                f"[shape] {quoted(key, mark='')} does not go with {way}; leave it out."
            )
    settings: dict[str, Any] = {}
    if "shadows" in section:
        settings["shadows"] = validation.one_of(
            section["shadows"], "[shape] shadows", (True, False)
        )
    if way == "file":
        path = opened(section["file"], "[shape] file")
        options = {key: section[key] for key in ("unit", "format") if key in section}
        settings["shape"] = _files.read(path, **options)
    elif way == "ellipsoid":
        settings["shape"] = _ellipsoid(section, body)
    elif way == "box":
        settings["shape"] = _solids.box(number_of(section["box"], "[shape] box", "m"))
    else:
        make, units, needed = _TABLES[way]
        settings["shape"] = make(**table_of(section[way], f"[shape] {way}", units, needed))
    if "divided" in section:
        if way == "ellipsoid":
            raise AttitudeError("[shape] divided does not go with ellipsoid; give facets.")
        settings["shape"] = settings["shape"].divided(section["divided"])
    return settings


def facets_for(
    section: Mapping[str, Any], shape: shape_ellipsoid.Ellipsoid | _mesh.Mesh, law: Law | None
) -> shape_ellipsoid.Ellipsoid | _mesh.Mesh:
    """The shape, or facets of an ellipsoid: without a law of closed form, or by `section`."""
    is_cut = law is None or "facets" in section or not law.has_ellipsoid_form
    if isinstance(shape, shape_ellipsoid.Ellipsoid) and is_cut:
        return shape.facets(section.get("facets", FACETS))
    return shape


def law_of(section: Any, shape: shape_ellipsoid.Ellipsoid | _mesh.Mesh) -> Law:
    """The law of a section [scattering], for a shape."""
    section = toml.section_of(section, "scattering")
    if "materials" in section:
        refuse_unknown(section, ("materials",), "[scattering] with materials")
        return _materials(section["materials"], shape)
    name, known = section.get("law", "lommel-seeliger"), scattering_law.laws()
    if not isinstance(name, str) or name not in known:
        raise AttitudeError(
            f"[scattering] law is {quoted(name)}; give one of {', '.join(map(repr, known))}, or a "
            "table of materials."
        )
    numbers = {key: value for key, value in section.items() if key != "law"}
    return _law(known[name], numbers, "[scattering]")


def scale_of(section: Any) -> dict[str, Any]:
    """The arguments phase_function and sun_magnitude of a Scene from a [magnitude] section."""
    section = toml.section_of(section, "magnitude")
    known = ("kind", "sun_magnitude", "h", "g", "g1", "g2", "sun_distance", "observer_distance")
    refuse_unknown(section, known, "[magnitude]")
    function = _phase_function(section)
    if "sun_magnitude" not in section:
        return {"phase_function": function}
    band = validation.number(section["sun_magnitude"], "[magnitude] sun_magnitude", unit="mag")
    if function is not None:
        raise AttitudeError(
            "[magnitude] has both h and sun_magnitude, but h alone sets the scale of magnitudes; "
            "leave one out."
        )
    return {"phase_function": function, "sun_magnitude": band}


def magnitude_of(section: Mapping[str, Any], scene: Scene) -> MagnitudeScale:
    """The `MagnitudeScale` of a section [magnitude], for a Scene."""
    distances, far = {}, []
    for key, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer)):
        if place.is_direction and key not in section:
            far.append(key)
        if key in section:
            if not place.is_direction:
                raise AttitudeError(
                    f"[magnitude] {key} is given, but the {key.partition('_')[0]} is "
                    f"{place.name}, whose distance is known; leave it out."
                )
            value = number_of(section[key], f"[magnitude] {key}", "m")
            distances[key] = validation.positive(value, f"[magnitude] {key}", unit="m")
    kind = section.get("kind", "reduced" if far else "apparent")
    validation.one_of(kind, "[magnitude] kind", ("apparent", "reduced"))
    if kind == "apparent" and far:
        raise AttitudeError(
            f"[magnitude] kind is apparent, which needs {' and '.join(far)} for a direction; give "
            'it in [magnitude], or kind = "reduced".'
        )
    return MagnitudeScale(kind, **distances)


def _ellipsoid(section, body):
    axes = section["ellipsoid"]
    if axes != "moments":
        if "diameter" in section:
            raise AttitudeError('[shape] diameter goes with ellipsoid = "moments"; leave it out.')
        return shape_ellipsoid.Ellipsoid(number_of(axes, "[shape] ellipsoid", "m"))
    if body is None:
        raise AttitudeError(
            '[shape] ellipsoid is "moments", but there is no spin with a body; give one, or three '
            "semi-axes."
        )
    if np.any(body.tensor != np.diag(np.diag(body.tensor))):
        raise AttitudeError(
            '[shape] ellipsoid is "moments", but the inertia tensor of the body is not diagonal; '
            "give three semi-axes."
        )
    diameter = number_of(section.get("diameter", 1.0), "[shape] diameter", "m")
    return shape_ellipsoid.Ellipsoid.of_moments(np.diag(body.tensor), diameter=diameter)


def _law(kind, section, where):
    """A law of a class from a table whose keys are the fields of the class."""
    parameters = kind.parameters()
    refuse_unknown(section, list(parameters), f"{where} ({kind.name})")
    values = {}
    for key, value in section.items():
        parameter = parameters[key]
        values[key] = (
            value if parameter.words else number_of(value, f"{where} {key}", parameter.unit)
        )
    for key in kind.required():
        if key not in values:
            raise AttitudeError(f"{where} has no {key}; give {parameters[key]}.")
    try:
        return kind(**values)
    except AttitudeError as err:
        raise AttitudeError(f"{where} {err}") from err


def _materials(section, shape):
    if not isinstance(section, dict) or not all(
        isinstance(material, dict) for material in section.values()
    ):
        raise AttitudeError(
            f"[scattering] materials is {validation.shown(section)}; give a table for each group "
            "of facets, as in [scattering.materials.body]."
        )
    if isinstance(shape, shape_ellipsoid.Ellipsoid):
        raise AttitudeError(
            "[scattering] has materials, which belong to groups of facets, but an ellipsoid has "
            "none; give a law."
        )
    carried = sorted(set(shape.materials))
    for name in section:
        if name not in carried:
            raise AttitudeError(
                f"[scattering] materials has {quoted(name)}, which no facet carries; the facets of "
                f"the shape carry {quoted(', '.join(map(repr, carried)), 120, '')}."
            )
    for name in carried:
        if name not in section:
            raise AttitudeError(
                f"[scattering] materials has no {quoted(name)}, which facets of the shape carry; "
                "give it."
            )
    kind = scattering_materials.Material
    return scattering_materials.Materials(
        {key: _law(kind, value, f"[scattering] {key}") for key, value in section.items()}
    )


def _phase_function(section):
    """Reduced magnitude as a function of the phase angle (rad); None without h."""
    names = [key for key in ("g", "g1", "g2") if key in section]
    if "h" not in section:
        if names:
            raise AttitudeError(
                f"[magnitude] has {names[0]} but no h; give the absolute magnitude."
            )
        return None
    numbers = {}
    for key in ("h", *names):
        where = f"[magnitude] {key}"
        numbers[key] = validation.number(number_of(section[key], where, None), where)
    if names in ([], ["g"]):
        form = _weighted.hg
    elif names == ["g1", "g2"]:
        form = _weighted.hg1g2
    else:
        raise AttitudeError(
            f"[magnitude] has h with {' and '.join(names)}; give h and g, or h, g1 and g2."
        )

    function = partial(form, **numbers)
    function(np.zeros(1))  # raises now for parameters out of range
    return function


def table_of(
    section: Any, where: str, units: Mapping[str, str | None], needed: Sequence[str]
) -> dict[str, Any]:
    """What makes a shape, from a table, in SI units and radians."""
    if not isinstance(section, dict):
        keys = ", ".join(units)
        raise AttitudeError(f"{where} is {quoted(section)}; give a table of {keys}, in braces.")
    refuse_unknown(section, tuple(units), where)
    columns = {
        key: value if units[key] is None else number_of(value, f"{where} {key}", units[key])
        for key, value in section.items()
    }
    for key in needed:
        if key not in columns:
            unit = ", in m" if units[key] == "m" else ""
            raise AttitudeError(f"{where} has no {key}; give it{unit}.")
    return columns


def number_of(value: Any, name: str, unit: str | None) -> Any:
    """A number, a list or a text of a file, as a float or an array in the unit."""
    return validation.real(value, name, unit=unit)[()]


# ---- Shape and law of a spin or mission file, whatever else it holds


def of_file(path: str) -> tuple[shape_ellipsoid.Ellipsoid | _mesh.Mesh, Law]:
    """Shape and law of the sections [shape] and [scattering] of a file in TOML."""
    content = _with_section(path, "shape", "a file with one, or a mesh")
    if isinstance(content["shape"], dict) and content["shape"].get("ellipsoid") == "moments":
        raise AttitudeError(f'{path}: [shape] ellipsoid is "moments"; give three semi-axes here.')
    file = partial(beside, folder=os.path.dirname(path))
    with prefixed(path):
        shape = shape_of(content["shape"], None, file)["shape"]
        return shape, law_of(content.get("scattering", {}), shape)


def law_of_file(path: str, shape: shape_ellipsoid.Ellipsoid | _mesh.Mesh) -> Law:
    """The law of the section [scattering] of a file in TOML, for a shape."""
    content = _with_section(path, "scattering", "a file with one")
    with prefixed(path):
        return law_of(content["scattering"], shape)


def _with_section(path, name, advice):
    content = toml.parsed(toml.read(path, f"file with a section [{name}]"), path)
    if name not in content:
        raise AttitudeError(f"{path}: has no section [{name}]; give {advice}.")
    return content


def beside(value: Any, name: str, folder: str) -> str:
    """A file named relative to a folder; AttitudeError for what is not text."""
    if not isinstance(value, str):
        raise AttitudeError(f"{name} is {quoted(value)}; give the name of a file.")
    return os.path.join(folder, os.path.expanduser(value))


# ---- The lines of sections [shape] and [scattering]


def shape_lines(shape: shape_ellipsoid.Ellipsoid | _mesh.Mesh) -> list[str]:
    """The section [shape], of which `shape_of` makes the same numbers."""
    if isinstance(shape, shape_ellipsoid.Ellipsoid):
        return ["[shape]", f"ellipsoid = {shape.semi_axes.tolist()!r}  # m"]
    if not isinstance(shape, _mesh.Mesh):
        raise AttitudeError(f"shape is {validation.shown(shape)}; give a Mesh or an Ellipsoid.")
    lines = ["[shape.mesh]", "vertices = [  # m"]
    lines += [f"    {row!r}," for row in shape.vertices.tolist()]
    lines += ["]", "facets = [  # vertices from 0, anticlockwise seen from outside"]
    lines += [f"    {row!r}," for row in shape.facets.tolist()]
    lines.append("]")
    if set(shape.materials) != {_mesh.SURFACE}:
        names = ", ".join(toml.quoted(material, "materials") for material in shape.materials)
        lines.append(f"materials = [{names}]")
    return lines


def law_lines(law: Law) -> list[str]:
    """The section [scattering], of which `law_of` makes an equal law, if its name is registered."""
    if law.by_material:
        lines: list[str] = []
        for name, material in law.by_material.items():
            head = f"[scattering.materials.{toml.quoted(name, 'materials')}]"
            lines += [*([""] if lines else []), head, *_fields(material)]
        return lines
    if not has_lines(law):
        raise AttitudeError(
            f"law is {validation.shown(law)}, which has no name in attitude.scattering.laws(); "
            "give one of these, or Materials."
        )
    return ["[scattering]", f"law = {toml.quoted(str(law.name), 'law')}", *_fields(law)]


def has_lines(law: Law) -> bool:
    """Whether a file can hold a law: Materials, and laws with a registered name."""
    return bool(law.by_material) or scattering_law.laws().get(str(law.name)) is type(law)


def _fields(law: Law) -> list[str]:
    values = law.values()
    texts = {k: toml.quoted(v, k) if isinstance(v, str) else repr(v) for k, v in values.items()}
    return [f"{name} = {text}" for name, text in texts.items()]
