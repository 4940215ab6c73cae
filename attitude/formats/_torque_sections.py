"""Sections [[torque]] and [integration] of mission files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import torques
from attitude._support import validation
from attitude._support.quoting import quoted
from attitude._textfiles.toml import refuse_unknown, way_of
from attitude.errors import AttitudeError
from attitude.formats._surface import number_of, table_of
from attitude.paths import _composed
from attitude.torques._gravity_gradient import GM
from attitude.torques._torqued import TorquedRotation

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude._support.annotations import FloatArray
    from attitude.motions._free_rotation import FreeRotation
    from attitude.paths._path import Path
    from attitude.shape import _mesh


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
class Surroundings:
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


def motion_of(
    content: dict[str, Any], free: FreeRotation | None, around: Surroundings
) -> TorquedRotation:
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
        key: number_of(value, f"[integration] {key}", units[key]) if key in units else value
        for key, value in how.items()
    }
    return TorquedRotation(free.body, free.spin, acting, **options)


def _torque(kind: str, section: dict[str, Any], where: str, around: Surroundings) -> torques.Torque:
    """One torque of a file."""

    def number(key: str, unit: str | None) -> Any:
        if key not in section:
            raise AttitudeError(f"{where} has no {key}; give it{f', in {unit}' if unit else ''}.")
        return number_of(section[key], f"{where} {key}", unit)

    def options(**units: str | None) -> dict[str, Any]:
        return {key: number(key, unit) for key, unit in units.items() if key in section}

    def path(origin: str) -> Path:
        validation.one_of(origin, f"{where} body", tuple(GM))
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
    given = section.get("density")
    if not isinstance(given, dict):
        density: float = number("density", "kg/m3")
        return density
    units: dict[str, str | None] = {"density": "kg/m3", "height": "m", "scale_height": "m"}
    found = table_of(given, f"{where} density", units, tuple(units))
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
            return torques.DipoleField(number_of(given["dipole"], f"{where} field dipole", "A m2"))
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
