"""Envisat over Graz on 23 October 2013: a tumbling satellite observed from a ground station.

The script reads a mission file (path from two-line elements, tensor of inertia, spin period from
the laser station of Graz), prints the pass and draws elevation, distance, angles to the body axes,
and the position angle of its long axis on the sky.  The state of rotation is assumed: see
data/spin/envisat.toml.

    python examples/envisat_pass.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import epochs
from attitude.formats import mission
from attitude.scene import Scene, View

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "envisat_pass.png"
AXES = ("least", "middle", "greatest")


def date(start: epochs.Instant, seconds: float) -> str:
    """UTC to the second; steps of TDB differ from those of UTC by microseconds."""
    return start.after(seconds + 0.01).utc_iso[:19]


def main() -> None:
    found = mission.read(DATA / "mission" / "envisat-pass.toml")
    scene = found.scene
    print(found.name)
    print(scene, end="\n\n")

    start = epochs.instant(found.times["start"])
    seconds = np.linspace(0.0, 810.0, 1621)
    view = scene.since(start, seconds)
    elevation = np.degrees(view.elevation)
    top = int(np.argmax(elevation))

    print(f"{'UTC':<22}{'elevation':>10}{'km':>9}{'phase':>8}{'aspect':>8}{'to long axis':>14}")
    for k in range(120, len(view), 120):
        if elevation[k] > 10.0:
            print(
                f"{date(start, seconds[k]):<22}{elevation[k]:10.2f}"
                f"{view.observer_distance[k] / 1e3:9.1f}{np.degrees(view.phase_angle[k]):8.2f}"
                f"{np.degrees(view.aspect_angle[k]):8.2f}"
                f"{np.degrees(view.observer_axis_angles[k, 0]):14.2f}"
            )
    print(
        f"\nCulmination {date(start, seconds[top])} UTC at {elevation[top]:.1f} deg, "
        f"{view.observer_distance[top] / 1e3:.1f} km."
    )
    shadow(scene, start)
    print("Positions:", view.sources["observer_line"])
    draw(view, seconds, start)


def shadow(scene: Scene, start: epochs.Instant) -> None:
    """Print the times in umbra and penumbra within one orbit."""
    seconds = np.arange(0.0, 6100.0, 0.25)
    lit = scene.since(start, seconds).lit_fraction
    dark = np.flatnonzero(lit == 0.0)
    penumbra = np.count_nonzero((lit > 0.0) & (lit < 1.0)) * 0.25
    first, last = (date(start, seconds[k]) for k in (dark[0], dark[-1]))
    print(
        f"In the next orbit it is in the Earth's umbra from {first} to {last} UTC, and "
        f"{penumbra:.1f} s in its penumbra."
    )


def draw(view: View, seconds: NDArray[np.float64], start: epochs.Instant) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    minutes = seconds / 60.0
    figure, (above, middle, below) = plt.subplots(
        3, 1, figsize=(9, 9), sharex=True, layout="constrained"
    )
    above.plot(minutes, np.degrees(view.elevation), color="C0")
    above.set(title="Envisat over Graz, 23 October 2013", ylabel="elevation (deg)", ylim=(0, 92))
    above.yaxis.label.set_color("C0")
    right = above.twinx()
    right.plot(minutes, view.observer_distance / 1e3, color="C1")
    right.set_ylabel("distance (km)", color="C1")

    for k, name in enumerate(AXES):
        angle = np.degrees(view.observer_axis_angles[:, k])
        middle.plot(minutes, angle, color=f"C{k + 2}", label=f"axis of {name} inertia")
    middle.plot(minutes, np.degrees(view.aspect_angle), "k--", lw=1, label="angular momentum")
    middle.plot(minutes, np.degrees(view.phase_angle), "k:", lw=1.5, label="Sun (phase angle)")
    middle.set(ylabel="angle from the line of sight (deg)", ylim=(0, 225), yticks=range(0, 181, 30))
    middle.legend(ncols=3, loc="upper center", fontsize=9, framealpha=0.9)

    # Do not draw steps of 360 deg across north.
    angle = np.degrees(view.long_axis_position_angle)
    angle[1:][np.abs(np.diff(angle)) > 180.0] = np.nan
    below.plot(minutes, angle, color="C4")
    below.set(
        ylabel="position angle of the long axis (deg)",
        xlabel=f"minutes since {start.utc_iso[:16]} UTC (attitude: assumed state)",
        ylim=(0, 360),
        yticks=range(0, 361, 90),
        xlim=(0, minutes[-1]),
    )
    for panel in (above, middle, below):
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
