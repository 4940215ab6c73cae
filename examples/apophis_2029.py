"""Apophis seen from the Earth around 13 April 2029: position, illumination and brightness.

The path is integrated from JPL's solution (an OEM file of three segments).  The rotation is that of
Pravec et al. (2014); its phases in 2029 are unknown and assumed here, so that the light curve shows
the kind of curve to expect, but not the times of its maxima.  The tides of the Earth change the
rotation at the encounter; a free rotation does not include this.

    python examples/apophis_2029.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import Body, epochs
from attitude.formats import mission
from attitude.scattering import LommelSeeligerLambert
from attitude.scene import Scene, View
from attitude.shape import Ellipsoid

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "apophis_2029.png"
# Mean diameter, m: Brozovic et al. 2018, Icarus 300, 115.
DIAMETER = 340.0
# A sphere with this law has the geometric albedo (1 + a) (1/8 + c/6) = 0.30 that Mueller et al.
# 2014 (A&A 566, A22) found for Apophis; its phase function stays positive up to 179 degrees.
LAW = LommelSeeligerLambert(c=0.45, a=0.5, d=0.1, k=-0.32)


def ellipsoid(body: Body) -> Ellipsoid:
    """The homogeneous ellipsoid with a body's ratios of moments and the mean diameter."""
    a, b, c = np.sort(body.moments)
    squares = np.array([b + c - a, a + c - b, a + b - c])
    axes = np.sqrt(squares)
    axes *= 0.5 * DIAMETER / np.prod(axes) ** (1.0 / 3.0)
    # Sort the semi-axes into the order of the moments.
    return Ellipsoid(axes[np.argsort(np.argsort(body.moments))])


def date(start: epochs.Instant, seconds: float) -> str:
    """UTC to the minute; steps of TDB differ from those of UTC by microseconds."""
    return start.after(seconds + 0.01).utc_iso[:16]


def main() -> None:
    found = mission.read(DATA / "mission" / "apophis-2029.toml")
    motion, center = found.scene.motion, found.scene.center
    assert motion is not None and motion.body is not None  # the file has both
    shape = ellipsoid(motion.body)
    scene = Scene(motion, center, shape=shape.facets(1000), law=LAW)
    print(found.name)
    print(f"semi-axes of the ellipsoid: {np.round(shape.semi_axes, 1)} m", end="\n\n")

    start = epochs.instant("2029-04-07")
    hours = np.arange(0, 13 * 24 * 60 + 1) / 60.0  # every minute of 13 days
    view = scene.since(start, hours * 3600.0)
    nearest = int(np.argmin(view.observer_distance))

    print(f"{'UTC':<18}{'distance km':>13}{'phase':>8}{'elong.':>8}{'aspect':>8}{'mag':>7}")
    for k in [*range(0, len(view), 1440), nearest]:
        print(
            f"{date(start, hours[k] * 3600.0):<18}{view.observer_distance[k] / 1e3:13.0f}"
            f"{np.degrees(view.phase_angle[k]):8.2f}{np.degrees(view.solar_elongation[k]):8.2f}"
            f"{np.degrees(view.aspect_angle[k]):8.2f}{view.magnitude[k]:7.2f}"
        )
    print(
        f"\nClosest {date(start, hours[nearest] * 3600.0)} UTC: "
        f"{view.observer_distance[nearest] / 1e3:.0f} km, light {view.light_time[nearest]:.3f} s."
    )
    print("Computed:", ", ".join(view.evaluated))
    draw(view, hours / 24.0, hours[nearest] / 24.0)


def draw(view: View, days: NDArray[np.float64], nearest: float) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(4, 1, figsize=(9, 11), sharex=True, layout="constrained")
    panels[0].semilogy(days, view.observer_distance / 1e3, color="C0")
    panels[0].set(
        title="(99942) Apophis from the centre of the Earth, April 2029", ylabel="distance (km)"
    )
    panels[1].plot(days, np.degrees(view.phase_angle), color="C1", label="phase angle")
    panels[1].plot(days, np.degrees(view.solar_elongation), color="C2", label="solar elongation")
    panels[1].set(ylabel="deg", ylim=(0, 180), yticks=range(0, 181, 45))
    panels[1].legend(loc="center left")
    panels[2].plot(days, np.degrees(view.aspect_angle), color="C3", label="aspect angle")
    panels[2].plot(
        days, np.degrees(view.observer_axis_angles[:, 0]), color="C4", lw=0.9,
        label="long axis from the line of sight",
    )  # fmt: skip
    panels[2].set(ylabel="deg", ylim=(0, 220), yticks=range(0, 181, 45))
    panels[2].legend(loc="upper left", ncols=2)
    panels[3].plot(days, view.magnitude, color="C0", lw=0.9)
    panels[3].invert_yaxis()
    panels[3].set(
        ylabel="V magnitude of the ellipsoid",
        xlabel="days since 7 April 2029 00:00 UTC (grey: rotation changed by the encounter)",
        xlim=(0, days[-1]),
    )
    for panel in panels:
        panel.grid(alpha=0.3)
        panel.axvline(nearest, color="k", lw=0.8, ls="--")
    for panel in panels[2:]:
        panel.axvspan(nearest, days[-1], color="0.85", zorder=0)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
