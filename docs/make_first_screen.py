"""The pictures of the first screen of README, into docs/figures/first_screen/.

    python docs/make_first_screen.py

needs matplotlib and Pillow.  The animation is what `attitude view toutatis` shows: Sun and Earth as
they were in December 1992; two ellipsoids in contact, of the size of Toutatis, stand for its shape.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from attitude import (
    Arcs,
    Body,
    FreeRotation,
    Impulse,
    Spin,
    catalog,
    epochs,
    photometry,
    plots,
    shape,
)
from attitude.formats import mission
from attitude.viewer import animate

FIGURES = Path(__file__).resolve().parent / "figures"
FOLDER = FIGURES / "first_screen"
DATA = FIGURES.parent.parent / "data"
# Pixels of a thumbnail, without letters: the table of README says below what it shows.
WIDTH = 320
HEIGHT = 130
PER_INCH = 100
BLUE = "#1f77b4"
ORANGE = "#d9730d"


def asteroids(axes):
    """Magnitudes of Toutatis at 1 au from 20 December 1992 to 28 January 1993."""
    curve = photometry.LightCurve.read(DATA / "light_curve" / "toutatis-1992-photometry.csv")
    shown = curve.seconds > epochs.instant("1992-12-20").since(curve.epoch)
    days, magnitudes = curve.seconds[shown] / 86400.0, curve.reduced_magnitude[shown]
    axes.plot(days, magnitudes, ".", color=BLUE, markersize=3)
    axes.invert_yaxis()


def debris(axes):
    """Brightness of a box-wing Envisat in three minutes of a pass."""
    found = mission.read(DATA / "mission" / "envisat-glints.toml")
    seconds = np.arange(0.0, 240.0, 0.25)
    view = found.scene.since(epochs.instant("2013-10-23T19:17:00"), seconds)
    axes.plot(seconds, found.magnitude.of(view), color=ORANGE, linewidth=1.0)
    axes.invert_yaxis()


def missions(axes):
    """The rate of a tumbling satellite that twelve pulses stop."""
    body = Body(moments=(17000.0, 125000.0, 129000.0))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.011, 0.045, 0.016))
    pulses = [
        Impulse(at=60.0 * k, angular_momentum=lambda h: -0.3 * h.angular_velocity @ body.tensor)
        for k in range(1, 10)
    ]
    t = np.linspace(0.0, 660.0, 1200)
    rate = np.degrees(np.linalg.norm(Arcs(body, spin, pulses).at(t).angular_velocity, axis=1))
    axes.plot(t, rate, color=BLUE, linewidth=1.5)
    axes.set(ylim=(0.0, None))


def mechanics(axes):
    """The middle axis of a body that spins about it, against the momentum."""
    body = Body(moments=(1.0, 2.0, 2.6))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1e-3, 4.0, 1e-3))
    motion = FreeRotation(body, spin)
    t = np.linspace(0.0, 2.0 * motion.period_psi, 1500)
    pole = motion.momentum / np.linalg.norm(motion.momentum)
    cosine = np.clip(motion.at(t).body_to_inertial([0, 1, 0]) @ pole, -1.0, 1.0)
    axes.plot(t, np.degrees(np.arccos(cosine)), color=ORANGE, linewidth=1.5)
    axes.set(ylim=(-10.0, 190.0))


def body():
    """Two ellipsoids in contact, as long, wide and high as Toutatis."""
    large = shape.Ellipsoid((950.0, 1150.0, 1350.0)).facets(500).moved((0.0, 0.0, -750.0))
    small = shape.Ellipsoid((750.0, 800.0, 1000.0)).facets(300).moved((0.0, 0.0, 1450.0))
    return large.joined(small)


def main():
    """Write all pictures."""
    FOLDER.mkdir(exist_ok=True)
    entry = catalog.entry("toutatis")
    body().write(Path(entry.scene).with_name("toutatis-like.obj"))
    scene = mission.read(entry.scene)
    animate(
        scene.scene, FOLDER / "toutatis.webp", start=scene.times["start"],
        stop=scene.times["stop"], magnitude=(scene.magnitude.of, "reduced magnitude"),
        frames=150, rate=18.0, size=(520, 440), title="(4179) Toutatis, December 1992",
    )  # fmt: skip
    motion = catalog.entry("toutatis").motion()
    plots.overview(motion, title="4179 Toutatis").savefig(FOLDER / "overview.png", dpi=80)
    for draw in (asteroids, debris, missions, mechanics):
        figure = plots.new_figure((WIDTH / PER_INCH, HEIGHT / PER_INCH))
        figure.set_layout_engine("none")
        axes = figure.add_axes((0.02, 0.03, 0.96, 0.94))
        draw(axes)
        axes.set(xticks=(), yticks=())
        for side in axes.spines.values():
            side.set_color("#cccccc")
        figure.savefig(FOLDER / f"{draw.__name__}.png", dpi=PER_INCH)


if __name__ == "__main__":
    main()
