"""How fast does the tilt of an ellipsoid of a linear material decay, by its mean power?

python benchmarks/relaxation.py
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from attitude import Body
from attitude.torques import QualityFactor, Rheology
from benchmarks.doc_tables import Table, markdown

MAKES = ("relaxation of a rheology",)
AXES, DENSITY, PERIOD, STRENGTH = np.array([1000.0, 800.0, 600.0]), 2000.0, 36000.0, 5e12
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


def tables(quick):
    """The table of docs/torques.md."""
    unit = STRENGTH / (DENSITY * AXES[0] ** 2 * (2.0 * np.pi / PERIOD) ** 3)
    seconds = times(0.5)
    rows = [["10^6 years", *(f"{each / MILLION_YEARS:.0f}" for each in seconds)]]
    rows.append(["in units", *(f"{each / unit:.1f}" for each in seconds)])
    ratios = np.divide(times(0.25), seconds)
    rows.append(["Poisson's ratio 1/4 by 1/2", *(f"{ratio:.3f}" for ratio in ratios)])
    yield Table("relaxation of a rheology", markdown(("tilt, deg", *TILTS), rows))


if __name__ == "__main__":
    for table in tables(False):
        print(table.text)
