"""Cases of a folder: `python benchmarks/inversion_open.py FOLDER [FIRST LAST]`.

FOLDER has truths.json and a file NAME.txt for each NAME in it, as of a forward model that is no
part of the package.  Columns: Julian date (TDB) of reception, magnitude, its error, session, and
the vectors from the body to the Sun and to the observer, au, ecliptic axes.  A truth has mode,
P_psi_d, P_phi_long_d, pole_ecliptic_deg, moments (ascending, the largest 1), and in style the mean
period P of rotation, d; 3.2 turns in it are searched.  All magnitudes share one zero point.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import inversion
from tests.support.synthetic_curves import Case


def cases(folder: Path, first: int = 0, last: int | None = None) -> Iterator[Case]:
    """The cases of a folder, in the order of their names."""
    truths = json.loads((folder / "truths.json").read_text())
    for name in sorted(truths)[first:last]:
        truth, column = truths[name], np.loadtxt(folder / f"{name}.txt", ndmin=2).T
        longitude, latitude = np.radians(truth["pole_ecliptic_deg"])
        pole = np.array(
            [
                math.cos(latitude) * math.cos(longitude),
                math.cos(latitude) * math.sin(longitude),
                math.sin(latitude),
            ]
        )
        yield Case(
            column[0],
            column[1],
            column[2],
            column[3].astype(int),
            column[4:7].T,
            column[7:10].T,
            truth["mode"],
            truth["P_psi_d"],
            truth["P_phi_long_d"],
            pole,
            np.array(truth["moments"]),
            3.2 / truth["style"]["P"],
        )


def main(arguments: list[str]) -> None:
    """Solve the cases of a folder."""
    inversion.run(cases(Path(arguments[0]), *map(int, arguments[1:3])), "shared")


if __name__ == "__main__":
    main(sys.argv[1:])
