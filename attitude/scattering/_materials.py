"""Surface materials of spacecraft: a diffuse part and a glossy lobe, facet by facet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.decorators import reduction_subroutine, reduction_within
from attitude._compilation.elementary import binary_logarithm, power_of_half
from attitude._compilation.simd import at_least, at_most, chosen, every
from attitude._support import validation
from attitude._support.quantity_text import quoted
from attitude.errors import AttitudeError
from attitude.scattering._law import Law, parameter

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude._support.annotations import FloatArray, IntArray, Reals
    from attitude.scattering._law import NumberField


# ---- Compiled reflectances of `Material`: a Lambert part with Phong's or Cook and Torrance's lobe
# A row holds the fields of a `Material` in order: diffuse, specular, model, exponent, roughness,
# f0.

MODELS = ("phong", "cook-torrance")
_PHONG = float(MODELS.index("phong"))
# Below this cosine of a micro-facet's tilt Cook and Torrance's lobe underflows to zero.
_STEEPEST = 0.03
# Whole exponents up to this are raised by products, whose error is that of the cosine.
_MULTIPLIED = 256.0
_LEAST = 1e-300


@reduction_subroutine
def lobe_of_phase(row, cos_half, sin_half, phase_terms):
    """Write the terms that depend on the phase angle alone, for the model of a row."""
    if row[2] == _PHONG:
        _phong_of_phase(row, cos_half, sin_half, phase_terms)
    else:
        _cook_torrance_of_phase(row, cos_half, phase_terms)


@reduction_within
def lobe_elements(row, phase_terms, mu0, mu):
    """r / mu0 in 1/sr of several elements for the model of a row."""
    if row[1] <= 0.0:
        return every(phase_terms[0], mu0)
    if row[2] == _PHONG:
        return _phong(row, phase_terms, mu0, mu)
    return _cook_torrance(phase_terms, mu0, mu)


@reduction_subroutine
def _phong_of_phase(row, cos_half, sin_half, phase_terms):
    phase_terms[0] = row[0] / math.pi
    phase_terms[1] = row[1] * (row[3] + 2.0) / (2.0 * math.pi)
    phase_terms[2] = (cos_half - sin_half) * (cos_half + sin_half)


@reduction_within
def _phong(row, phase_terms, mu0, mu):
    mirrored = 2.0 * mu0 * mu - phase_terms[2]
    base = at_least(mirrored, _LEAST)
    if row[3] <= _MULTIPLIED and row[3] == math.floor(row[3]):
        lobe = every(1.0, base)
        left = int(row[3])
        while left > 0:
            if left & 1:
                lobe = lobe * base
            base = base * base
            left >>= 1
    else:
        lobe = power_of_half(binary_logarithm(base) * -row[3])
    return phase_terms[0] + phase_terms[1] * chosen(mirrored, lobe, every(0.0, lobe))


@reduction_subroutine
def _cook_torrance_of_phase(row, cos_half, phase_terms):
    versine = 1.0 - cos_half
    fresnel = row[5] + (1.0 - row[5]) * versine * versine * versine * versine * versine
    slope = row[4] * row[4]
    phase_terms[0] = row[0] / math.pi
    phase_terms[1] = row[1] * fresnel / (4.0 * math.pi * slope)
    phase_terms[2] = cos_half
    phase_terms[3] = 1.0 / (slope * math.log(2.0))


@reduction_within
def _cook_torrance(phase_terms, mu0, mu):
    # The micro-facet that mirrors the Sun to the observer bisects the phase angle.
    cos_half = phase_terms[2]
    both = 0.5 * (mu0 + mu)
    # For steeper ones the exponential is below 1e-480 at every roughness, and could end as 0/0.
    shown = both - _STEEPEST * cos_half
    if cos_half <= 0.0:
        return shown * 0.0 + phase_terms[0]
    # in units of cos(alpha/2) the cosine of the tilt of the facet is 1 at most
    tilt = at_most(at_least(both / cos_half, _STEEPEST), 1.0)
    inverse = 1.0 / (tilt * tilt)
    spread = power_of_half((inverse - 1.0) * phase_terms[3]) * (inverse * inverse)
    grooves = at_most((2.0 / cos_half) * tilt * at_most(mu0, mu), 1.0)
    lobe = spread * grooves / at_least(mu0 * mu, _LEAST)
    return phase_terms[0] + phase_terms[1] * chosen(shown, lobe, every(0.0, lobe))


# Of a fixed point whose error shrinks by 2 m^2 / (1 + tan^2) each time.
_ITERATIONS = 200


@dataclass(frozen=True)
class Material(Law):
    """A diffuse (Lambert) part and a glossy lobe about the mirror direction.

    Parameters
    ----------
    diffuse, specular : float
        Fractions of the light, each 0 to 1, together at most 1.
    model : "phong" or "cook-torrance"
        Phong's lobe in its reciprocal, energy-conserving form, specular (n + 2) / (2 pi) cos^n
        of the angle to the mirror direction; or Cook and Torrance's, specular D F G / (4 mu0 mu),
        with Beckmann's micro-facets, Schlick's Fresnel term and V-shaped grooves.
    exponent : float
        n of Phong's lobe, 1 to 1e6; its half-width is near 1.18 / sqrt(n) rad.
    roughness : float
        rms slope m of Cook and Torrance's micro-facets, 0.001 to 1.
    f0 : float
        Reflectance of the micro-facets at normal incidence, 0 to 1.

    Raises
    ------
    AttitudeError
        For a value out of its range, or diffuse + specular above 1.

    Notes
    -----
    The model treats the Sun as a point: a lobe narrower than its disc (4.7 mrad) gives flashes that
    are too bright and too short.  Keep exponents below 1e5 unless a point source is intended.

    Source: Lafortune & Willems, CW 197, KU Leuven, 1994, eq. 9 (Phong); Cook & Torrance, ACM
    Trans. Graphics 1, 7, 1982; Schlick, Computer Graphics Forum 13, 233, 1994, eq. 15.
    """

    name = "material"
    of_phase = lobe_of_phase
    elements = lobe_elements

    diffuse: NumberField = parameter(low=0.0, high=1.0)
    specular: NumberField = parameter(0.0, low=0.0, high=1.0)
    model: str = parameter("phong", words=MODELS)
    exponent: NumberField = parameter(100.0, low=1.0, high=1e6)
    roughness: NumberField = parameter(0.1, low=1e-3, high=1.0)
    f0: NumberField = parameter(1.0, low=0.0, high=1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.diffuse + self.specular > 1.0 + 1e-12:
            raise AttitudeError(
                f"diffuse {self.diffuse} and specular {self.specular} add up to more than 1: the "
                "surface would return more light than it gets; lower one of them."
            )

    def of_material(self, name: str) -> Material:
        """The material itself, which facets of all names have."""
        return self

    def lobe_half_width(self, fraction: float = 0.1) -> float:
        """The angle from the mirror direction at which the lobe falls to a fraction of its peak.

        rad, up to pi / 2; for Cook and Torrance's that of the distribution of micro-facets, which
        tilt by half of it.  0 for a material without a specular part.

        Raises
        ------
        AttitudeError
            For a fraction that is not between 0 and 1.
        """
        level = validation.number(fraction, "fraction")
        if not 0.0 < level < 1.0:
            raise AttitudeError(f"fraction is {level!r}; give one above 0 and below 1.")
        if self.specular == 0.0:
            return 0.0
        if self.model == "phong":
            return math.acos(level ** (1.0 / self.exponent))
        # exp(-tan^2 / m^2) / cos^4 = fraction, with the tangent squared as the unknown.
        square = -(self.roughness**2) * math.log(level)
        for _ in range(_ITERATIONS):
            square = self.roughness**2 * (2.0 * math.log1p(square) - math.log(level))
        return min(2.0 * math.atan(math.sqrt(square)), 0.5 * math.pi)


class Materials(Law):
    """A `Material` for each name that the facets of a mesh carry.

    Parameters
    ----------
    by_name : mapping of str to Material
        Materials by the name of a group of facets.

    Raises
    ------
    AttitudeError
        For an empty mapping, or values that are not `Material`.

    Examples
    --------
    >>> satellite = Materials({"body": Material(0.3, 0.2), "panel front": Material(0.05, 0.6)})
    >>> satellite["body"].specular
    0.2
    """

    of_phase = lobe_of_phase
    elements = lobe_elements
    _by_name: dict[str, Material]

    def __init__(self, by_name: Mapping[str, Material]) -> None:
        try:
            by_name = dict(by_name)
        except (TypeError, ValueError) as err:
            raise AttitudeError(
                f"Materials is given {by_name!r}; give a dict of a Material for each name."
            ) from err
        if not by_name:
            raise AttitudeError("Materials is empty; give a Material for each name of the mesh.")
        for name, material in by_name.items():
            if not isinstance(material, Material):
                raise AttitudeError(
                    f"material {quoted(name)} is {quoted(material)}; give an "
                    "attitude.scattering.Material."
                )
        object.__setattr__(self, "_by_name", by_name)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the groups of facets."""
        return tuple(self._by_name)

    @property
    def by_material(self) -> Mapping[str, Law]:
        """A dict of the Material of each group of facets, by its name."""
        return dict(self._by_name)

    def __getitem__(self, name: str) -> Material:
        if name not in self._by_name:
            known = ", ".join(repr(n) for n in self._by_name)
            raise AttitudeError(
                f"material {quoted(name)} is unknown; known are {known}. Add it to Materials, or "
                "rename the facets."
            )
        return self._by_name[name]

    def of_material(self, name: str) -> Material:
        """The material of a name; AttitudeError if it is unknown."""
        return self[name]

    def __repr__(self) -> str:
        return f"Materials({self._by_name!r})"

    # Facets of different materials reflect differently, so the name has no default.
    def reflectance(  # type: ignore[override]
        self, mu0: Reals, mu: Reals, alpha: Reals, *, material: str
    ) -> FloatArray:
        """`Law.reflectance`, in 1/sr, of the material with a name; AttitudeError if unknown."""
        return self[material].reflectance(mu0, mu, alpha)

    def rows(self, materials: Sequence[str]) -> tuple[FloatArray, IntArray]:
        """Rows of numbers (M, W), one for each name, and the row index (F,) of each facet."""
        names = sorted(set(materials))
        rows = np.array([self[name].row() for name in names])
        number = {name: k for k, name in enumerate(names)}
        return rows, np.array([number[name] for name in materials], dtype=np.int64)
