"""Toutatis: how well does free rotation explain the radar observations?

The script propagates the state of 1992-11-09 (Takahashi, Busch & Scheeres 2013) to the 18 epochs of
radar attitudes, prints the angles between the predicted and the observed body axes, and draws them.

The prediction for December 1992 agrees to a few degrees, for the worst axis to about 15.  For
November 2008 it is off by more than 100 degrees, with any propagator of free rotation: the tides of
the Earth and the Sun, above all at the close approaches of 1992, 1996, 2000 and 2004, changed the
angular momentum.

    python examples/toutatis.py
"""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import AttitudeHistory, FreeRotation, Spin
from attitude.formats import spin_file

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "toutatis.png"
AXES = ("x", "y", "z")


def observations() -> list[Spin]:
    """Radar attitudes and rates."""
    with open(DATA / "toutatis-observed.csv") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [
            Spin.from_euler(
                epoch=row["utc"],
                sequence="313",
                angles=np.radians(
                    [float(row[f"{name}_deg"]) for name in ("alpha", "beta", "gamma")]
                ),
                angular_velocity=[
                    np.radians(float(row[f"w{k}_deg_day"])) / 86400.0 for k in (1, 2, 3)
                ],
                frame="ecliptic",
            )
            for row in rows
        ]


def errors(history: AttitudeHistory, seen: list[Spin]) -> tuple[Array, Array]:
    """Angles (N, 3) between predicted and observed body axes, and (N,) of the whole rotation."""
    from scipy.spatial.transform import Rotation

    observed = Rotation.from_quat([spin.wxyz_icrf for spin in seen], scalar_first=True)
    predicted = history.as_rotation()
    # Column k of a matrix is body axis k in ICRF.
    a, b = observed.as_matrix(), predicted.as_matrix()
    sine = np.linalg.norm(np.cross(a, b, axis=1), axis=1)
    cosine = np.sum(a * b, axis=1)
    return np.degrees(np.arctan2(sine, cosine)), np.degrees(
        (observed.inv() * predicted).magnitude()
    )


def main() -> None:
    motion = spin_file.read(DATA / "spin" / "toutatis.toml").motion
    print(motion, end="\n\n")

    seen = observations()
    history = motion.at([spin.epoch for spin in seen])
    axes, rotation = errors(history, seen)

    print("angle between the predicted and the observed body axis, and of the rotation (deg)")
    print(f"{'UTC':<20}{'days':>9}{'x':>8}{'y':>8}{'z':>8}{'rotation':>10}")
    for spin, seconds, (x, y, z), turn in zip(seen, history.seconds, axes, rotation, strict=True):
        date = spin.epoch.utc_iso
        print(f"{date:<20}{seconds / 86400:9.2f}{x:8.2f}{y:8.2f}{z:8.2f}{turn:10.2f}")
    print(f"\nDecember 1992: median {np.median(axes[:-1]):.1f}, worst {np.max(axes[:-1]):.1f} deg.")
    print(
        f"November 2008: {rotation[-1]:.0f} deg. Sixteen years of torques (tides at four close "
        "approaches\nto the Earth, and of the Sun) are not part of a free rotation."
    )
    draw(motion, seen, axes)


def draw(motion: FreeRotation, seen: list[Spin], axes: Array) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from attitude import epochs

    start = epochs.instant("1992-12-02")
    december = seen[:-1]
    day = np.array([epochs.seconds_since(start, spin.epoch)[0] for spin in december]) / 86400.0
    grid = np.linspace(0.0, 17.0, 1000)
    first = epochs.seconds_since(motion.spin.epoch, start)[0]
    rates = motion.at(first + grid * 86400.0).angular_velocity

    figure, (above, below) = plt.subplots(2, 1, figsize=(9, 7.5), sharex=True, layout="constrained")
    for k, name in enumerate(AXES):
        above.plot(day, axes[:-1, k], "os^"[k], color=f"C{k}", label=f"{name} axis")
        below.plot(grid, np.degrees(rates[:, k]) * 86400.0, color=f"C{k}")
        below.plot(
            day,
            [np.degrees(spin.angular_velocity[k]) * 86400.0 for spin in december],
            "os^"[k],
            color=f"C{k}",
            label=rf"$\omega_{name}$",
        )
    above.set(
        title="(4179) Toutatis: free rotation from 1992-11-09 against radar",
        ylabel="error of the predicted body axes (deg)",
        ylim=(0, None),
    )
    below.set(
        xlabel="days since 1992-12-02 00:00 UTC",
        ylabel="angular velocity over the body axes (deg/day)",
        ylim=(-125, 85),
    )
    above.legend(ncols=3, loc="upper right")
    below.legend(ncols=3, loc="upper right", title="points: radar, lines: free rotation")
    for panel in (above, below):
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
