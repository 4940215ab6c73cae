"""The mathematics of the solution: elliptic integrals and functions, theta functions, the paper.

Names are those of the Digital Library of Mathematical Functions (dlmf.nist.gov, chapters 19, 20
and 22), arguments are the parameter m = k^2 and the nome q; all functions take arrays.

_jacobi   `K`, `E`, `Pi`, `F`, `E_incomplete`, `nome`; `am`, `sn`, `cn`, `dn`, `theta`
_steps    `steps`: the constants of van Zon & Schofield (2006) for a motion, and its attitude

>>> from attitude import jacobi
>>> float(jacobi.sn(jacobi.K(0.5), 0.5).round(12))
1.0
"""

from attitude.jacobi._jacobi import E, E_incomplete, F, K, Pi, am, cn, dn, nome, sn, theta
from attitude.jacobi._steps import PaperSteps, steps

__all__ = [
    "E",
    "E_incomplete",
    "F",
    "K",
    "PaperSteps",
    "Pi",
    "am",
    "cn",
    "dn",
    "nome",
    "sn",
    "steps",
    "theta",
]
