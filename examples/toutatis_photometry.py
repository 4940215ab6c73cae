"""Toutatis from its photometry of 1992-93 alone, against the attitudes that radar saw.

The light curve has 370 magnitudes of 27 observers over 188 days.  The search knows nothing of the
body but that it turns less than 0.75 times a day.  It finds the long-axis mode, both periods, the
pole, moments and a convex shape; its verdict is "periods only", for other poles compete.  Radar
attitudes of December 1992 (Takahashi, Busch & Scheeres 2013, after Hudson & Ostro 1995) lie 6 to 19
degrees from those of the solution, axes being lines.  Some 40 seconds of processor.

    python examples/toutatis_photometry.py
"""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import FreeRotation, Spin, catalog, inversion
from attitude.frames import quaternion

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parent.parent / "data"
CURVE = DATA / "light_curve" / "toutatis-1992-photometry.csv"
PICTURE = "toutatis_photometry.png"
DAY = 86400.0


def radar() -> list[Spin]:
    """Radar attitudes of December 1992, body axes: intermediate, greatest, least moment."""
    with open(DATA / "toutatis-observed.csv") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [
            Spin.from_euler(
                epoch=row["utc"],
                sequence="313",
                angles=np.radians([float(row[f"{n}_deg"]) for n in ("alpha", "beta", "gamma")]),
                angular_velocity=(0.0, 0.0, 0.0),
                frame="ecliptic",
            )
            for row in rows
            if row["utc"] < "1993"
        ]


def angles_to_radar(motion: FreeRotation) -> tuple[Array, Array]:
    """Angles (N,) of the whole rotation and of the long axis, deg, the axes taken as lines."""
    seen = radar()
    order = np.argsort(motion.body.moments)
    mine = motion.at([spin.epoch for spin in seen]).matrix[:, :, order[[1, 2, 0]]]
    theirs = np.array([quaternion.matrix(spin.wxyz_icrf) for spin in seen])
    # three lines agree up to the signs of two, the third makes them right-handed
    cosines = np.sum(theirs * mine, axis=1)
    hand = np.sign(np.linalg.det(mine))
    best = np.full(len(seen), -1.0)
    for a in (1.0, -1.0):
        for b in (1.0, -1.0):
            traces = cosines @ [a, b, 0.0] + a * b * hand * cosines[:, 2]
            best = np.maximum(best, 0.5 * (traces - 1.0))
    whole = np.degrees(np.arccos(np.minimum(best, 1.0)))
    return whole, np.degrees(np.arccos(np.minimum(np.abs(cosines[:, 2]), 1.0)))


def main() -> None:
    curve = inversion.LightCurve.read(CURVE)
    print(curve)
    found = inversion.spin_states(curve, "0.75 /d")
    print(found, end="\n\n")
    best = found[0]
    known = catalog.entry("4179 Toutatis").motion().published("L")
    psi, phi = (each / DAY for each in best.periods_sigma)
    print(f"P_phi {best.P_phi / DAY:.3f} +- {phi:.3f} d, radar {known.P_phi / DAY:.3f} d")
    print(f"P_psi {best.P_psi / DAY:.3f} +- {psi:.3f} d, radar {known.P_psi / DAY:.3f} d")
    print("pole {:.1f} {:+.1f} deg, radar {:.1f} {:+.1f} deg".format(
        *np.degrees(best.pole), *np.degrees(known.pole)
    ))  # fmt: skip
    print(f"{'UTC':<20}{'attitude':>10}{'long axis':>11}   deg from radar")
    for spin, whole, axis in zip(radar(), *angles_to_radar(best.motion), strict=True):
        print(f"{spin.epoch.utc_iso:<20}{whole:10.0f}{axis:11.0f}")
    found.plot(PICTURE)
    print(f"Picture: {PICTURE}")


if __name__ == "__main__":
    main()
