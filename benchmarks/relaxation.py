"""How fast does the tilt of an ellipsoid of a linear material decay, by its mean power?

python benchmarks/relaxation.py
"""

import sys
from pathlib import Path

import numpy as np
from scipy.special import elliprd

sys.path.insert(0, str(Path(__file__).parents[1]))

from attitude import Body
from attitude.torques import Maxwell, QualityFactor, Rheology
from benchmarks.doc_tables import Table, markdown

MAKES = ("relaxation of a rheology", "creep under gravity")
# Semi-axes, m; kg/m3; s; mu Q, Pa.
AXES = np.array([1000.0, 800.0, 600.0])
DENSITY = 2000.0
PERIOD = 36000.0
STRENGTH = 5e12
MILLION_YEARS = 1e6 * 365.25 * 86400.0
TILTS = (1, 10, 20, 30, 45, 60)


def times(poisson):
    """Seconds in which tan of the tilt falls by a factor e, at each of TILTS."""
    mass = 4.0 / 3.0 * np.pi * np.prod(AXES) * DENSITY
    moments = mass / 5.0 * (np.sum(AXES**2) - AXES**2)
    rheology = Rheology(AXES, DENSITY, QualityFactor(STRENGTH / 1e3, 1e3), poisson)
    momentum = moments[2] * 2.0 * np.pi / PERIOD
    whole = 1.0 / moments[0] - 1.0 / moments[2]
    found = []
    for tilt in TILTS:
        p = np.sin(np.radians(tilt)) ** 2
        power = rheology.power(Body(moments=moments), momentum, p)
        found.append(momentum**2 * whole * p * (1.0 - p) / power)
    return found


# Toutatis: semi-axes (Hudson & Ostro 1995, Science 270, 84: 4.26, 2.03, 1.70 km), moments and rates
# (Ostro et al. 1999, Icarus 137, 122).
TOUTATIS = np.array([2130.0, 1015.0, 850.0])
TOUTATIS_DENSITY = 2100.0
TOUTATIS_MOMENTS = np.array([1.0, 3.0836, 3.235])
TOUTATIS_RATES = np.array([98.709, 14.51, 33.529])  # deg a day


def creep_of_toutatis():
    """Power by which its own gravity makes a Maxwell body creep, by that of the tumbling.

    A constant stress of body forces -rho B r takes rho^2 B G B/viscosity, a periodic one
    2 rho^2 sum b* G b/viscosity: the ratio depends on neither rigidity nor viscosity.
    """
    rheology = Rheology(TOUTATIS, TOUTATIS_DENSITY, QualityFactor(1e9, 100.0))
    squares = TOUTATIS**2
    # of the potential inside: pi G rho sum A_i x_i^2 (Chandrasekhar 1969, chapter 3)
    shares = [
        2.0 / 3.0 * np.prod(TOUTATIS) * elliprd(*np.delete(squares, k), squares[k])
        for k in range(3)
    ]
    gravity = np.diag(2.0 * np.pi * 6.6743e-11 * TOUTATIS_DENSITY * np.array(shares)).ravel()
    body = Body(moments=TOUTATIS_MOMENTS, relative=True)
    moments = rheology.moments(body)
    omega = np.radians(TOUTATIS_RATES) / 86400.0
    momentum = np.linalg.norm(moments * omega)
    p = np.sum(moments * omega**2) / momentum**2 - 1.0 / moments[2]
    p /= 1.0 / moments[0] - 1.0 / moments[2]
    # 2 rho^2 sum b* G b/viscosity, by a Maxwell body of viscosity 1
    tumbling = Rheology(TOUTATIS, TOUTATIS_DENSITY, Maxwell(1e30, 1e25)).power(body, momentum, p)
    static = TOUTATIS_DENSITY**2 * (gravity @ rheology._form @ gravity) / 1e25
    return static / tumbling


def tables(quick):
    """The tables of docs/torques.md."""
    unit = STRENGTH / (DENSITY * AXES[0] ** 2 * (2.0 * np.pi / PERIOD) ** 3)
    seconds = times(0.5)
    rows = [["10^6 years", *(f"{each / MILLION_YEARS:.0f}" for each in seconds)]]
    rows.append(["in units", *(f"{each / unit:.1f}" for each in seconds)])
    ratios = np.divide(times(0.25), seconds)
    rows.append(["Poisson's ratio 1/4 by 1/2", *(f"{ratio:.3f}" for ratio in ratios)])
    yield Table("relaxation of a rheology", markdown(("tilt, deg", *TILTS), rows))
    yield Table("creep under gravity", f"{creep_of_toutatis():.0e}")


if __name__ == "__main__":
    for table in tables(False):
        print(table.text)
