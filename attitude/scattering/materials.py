"""What spacecraft are made of: a diffuse part and a gloss, facet by facet."""

from dataclasses import dataclass

import numpy as np

from attitude.errors import AttitudeError
from attitude.scattering import lobes
from attitude.scattering.law import Law
from attitude.scattering.parameters import parameter


@dataclass(frozen=True)
class Material(Law):
    """A diffuse (Lambert) part and a glossy lobe about the mirror direction.

    Parameters
    ----------
    diffuse, specular : float
        Shares of the light, each 0 to 1, together at most 1.
    model : "phong" or "cook-torrance"
        Phong's lobe in its reciprocal, energy-conserving form,
        specular (n + 2) / (2 pi) cos^n, of the angle to the mirror direction; or Cook and
        Torrance's, specular D F G / (4 mu0 mu), with Beckmann's facets, Schlick's Fresnel term
        and V-shaped grooves.
    exponent : float
        n of Phong's lobe, 1 to 1e6; its half-width is near 1.18 / sqrt(n) rad.
    roughness : float
        rms slope m of Cook and Torrance's micro-facets, 0.001 to 1.
    f0 : float
        Their reflectance at normal incidence, 0 to 1.

    Notes
    -----
    The Sun is a point here: a lobe narrower than its disc (4.7 mrad) flashes too bright and too
    briefly; keep exponents below 1e5 unless that is meant.

    Source: Lafortune & Willems, CW 197, KU Leuven, 1994, eq. 9 (Phong); Cook & Torrance, ACM
    Trans. Graphics 1, 7, 1982; Schlick, Computer Graphics Forum 13, 233, 1994, eq. 15.
    """

    name = "material"
    of_phase = lobes.of_phase
    element = lobes.element

    diffuse: float = parameter(low=0.0, high=1.0)
    specular: float = parameter(0.0, low=0.0, high=1.0)
    model: str = parameter("phong", words=lobes.MODELS)
    exponent: float = parameter(100.0, low=1.0, high=1e6)
    roughness: float = parameter(0.1, low=1e-3, high=1.0)
    f0: float = parameter(1.0, low=0.0, high=1.0)

    def __post_init__(self):
        super().__post_init__()
        if self.diffuse + self.specular > 1.0 + 1e-12:
            raise AttitudeError(
                f"diffuse {self.diffuse} and specular {self.specular} add up to more than 1: the "
                "surface would return more light than it gets; lower one of them."
            )


class Materials(Law):
    """A `Material` for each name that the facets of a mesh carry.

    Parameters
    ----------
    by_name : dict of str to Material

    Examples
    --------
    >>> satellite = Materials({"body": Material(0.3, 0.2), "panel front": Material(0.05, 0.6)})
    >>> satellite["body"].specular
    0.2
    """

    of_phase = lobes.of_phase
    element = lobes.element

    def __init__(self, by_name):
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
                    f"material {name!r} is {material!r}; give an attitude.scattering.Material."
                )
        object.__setattr__(self, "_by_name", by_name)

    def __getitem__(self, name):
        if name not in self._by_name:
            known = ", ".join(repr(n) for n in self._by_name)
            raise AttitudeError(
                f"material {name!r} is unknown; known are {known}. Add it to Materials, or "
                "rename the facets."
            )
        return self._by_name[name]

    def __repr__(self):
        return f"Materials({self._by_name!r})"

    def reflectance(self, mu0, mu, alpha, *, material):
        """`Material.reflectance` of the material of that name."""
        return self[material].reflectance(mu0, mu, alpha)

    def rows(self, materials):
        """(M, W) rows of numbers, and (F,) which of them each facet has."""
        names = sorted(set(materials))
        rows = np.array([self[name].row() for name in names])
        number = {name: k for k, name in enumerate(names)}
        return rows, np.array([number[name] for name in materials], dtype=np.int64)
