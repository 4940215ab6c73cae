"""How a surface element returns sunlight, and how a whole body dims with phase.

A law gives the bidirectional reflectance r, in 1/sr: the radiance that leaves an element over the
irradiance of a surface facing the Sun.  The brightness of a body is the integral of r mu dA over
the area that is both lit and seen, in m2/sr.  mu0 and mu are the cosines of incidence and emission,
alpha is the phase angle.  A Lambert surface of albedo 1 has r = mu0 / pi; r / mu0 is symmetric in
mu0 and mu for every law here (Helmholtz reciprocity).

_law         `Law`, the base class: what a new law defines; the registry of laws by name
_weighted    Lambert's and Lommel-Seeliger's laws, and their sum; phase functions of asteroids
_hapke       Hapke's law
_materials   a diffuse part and a glossy lobe, for all facets or by name
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from attitude._compilation.decorators import reduction_subroutine
from attitude._support.synonyms import of_module
from attitude.scattering._hapke import Hapke
from attitude.scattering._law import Law, NumberField, forget, law, laws, parameter
from attitude.scattering._materials import Material, Materials
from attitude.scattering._weighted import Lambert, LommelSeeliger, LommelSeeligerLambert, hg, hg1g2

__all__ = [
    "Hapke",
    "Lambert",
    "Law",
    "LommelSeeliger",
    "LommelSeeligerLambert",
    "Material",
    "Materials",
    "NumberField",
    "forget",
    "hg",
    "hg1g2",
    "law",
    "laws",
    "parameter",
    "reduction_subroutine",
]

# Defining a law registers its name: every module is imported, that of a new law too.
for _each in iter_modules(__path__, f"{__name__}."):
    import_module(_each.name)

if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
