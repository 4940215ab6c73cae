"""How a surface element returns sunlight, and how a whole body dims with phase.

A law gives the bidirectional reflectance r, in 1/sr: the radiance that leaves an element over the
irradiance of a surface facing the Sun.  A body's brightness is the integral of r mu dA over what
is lit and seen, in m2/sr.  mu0 and mu are cosines of incidence and emission, alpha is the phase
angle.  A Lambert surface of albedo 1 has r = mu0 / pi; r / mu0 is symmetric in mu0 and mu for
every law here (Helmholtz reciprocity).
"""

from attitude.scattering.hapke import Hapke
from attitude.scattering.laws import Lambert, LommelSeeliger, LommelSeeligerLambert
from attitude.scattering.materials import Material, Materials
from attitude.scattering.phase import hg, hg1g2

__all__ = [
    "Hapke",
    "Lambert",
    "LommelSeeliger",
    "LommelSeeligerLambert",
    "Material",
    "Materials",
    "hg",
    "hg1g2",
    "law",
]

_NAMED = {
    "lambert": Lambert,
    "lommel-seeliger": LommelSeeliger,
    "lommel-seeliger-lambert": LommelSeeligerLambert,
    "hapke": Hapke,
}


def law(given):
    """The law itself, or the one with usual parameters that a name stands for.

    Examples
    --------
    >>> law("lommel-seeliger")
    LommelSeeliger(albedo=1.0)
    """
    from attitude.errors import AttitudeError

    if isinstance(given, str) and given in _NAMED:
        return _NAMED[given]()
    if isinstance(given, type) and hasattr(given, "reflectance"):
        raise AttitudeError(
            f"law is the class {given.__name__}; give one of its values: {given.__name__}(...)."
        )
    if hasattr(given, "reflectance"):
        return given
    names = ", ".join(repr(name) for name in _NAMED)
    raise AttitudeError(
        f"law is {given!r}; give one of {names}, or a law with parameters such as "
        "attitude.scattering.Hapke(...) or Materials(...)."
    )
