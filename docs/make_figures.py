"""Make the pictures of docs/conventions.md.

python docs/make_figures.py
"""

from pathlib import Path

import numpy as np

from attitude import Body, catalog, plots
from attitude.frames import quaternion
from attitude.motions import _conventions

FIGURES = Path(__file__).parent / "figures"
PHI = "#0072b2"
THETA = "#d55e00"
PSI = "#009e73"


def main():
    FIGURES.mkdir(exist_ok=True)
    labellings().savefig(FIGURES / "labellings.png", dpi=110)
    angles_in_both().savefig(FIGURES / "angles.png", dpi=110)
    toutatis = catalog.entry("4179 Toutatis").motion()
    plots.overview(toutatis, title="(4179) Toutatis").savefig(FIGURES / "toutatis.png", dpi=110)


def labellings():
    """An elongated body, its momentum, and the angles of either convention."""
    figure = plots.new_figure((9.0, 5.0))
    body = Body(moments=(0.4, 0.85, 1.0), relative=True)
    lengths = np.sqrt(2.5 * (body.moments.sum() - 2.0 * body.moments))
    for k, convention in enumerate("LS"):
        axes = figure.add_subplot(1, 2, k + 1, projection="3d")
        turn = _conventions.axes(body, convention)
        attitude = _matrix(np.radians(40.0), np.radians(55.0), np.radians(35.0))
        _ellipsoid(axes, attitude @ turn.T, lengths)
        names = ("x = B", "y = C", "z = A (long)") if convention == "L" else (
            "x = A", "y = B", "z = C (short)"
        )  # fmt: skip
        for j, name in enumerate(names):
            _arrow(axes, 1.5 * attitude[:, j], name, "black")
        _arrow(axes, np.array([0.0, 0.0, 1.5]), "momentum", "#cc79a7")
        node = np.array([np.cos(np.radians(40.0)), np.sin(np.radians(40.0)), 0.0])
        axes.plot(*np.outer(node, [0.0, 1.5]), "--", color="gray", linewidth=0.8)
        x, y, z = np.eye(3)
        across = np.cross(attitude[:, 2], node)
        _arc(axes, x, y, 0.0, np.radians(40.0), "phi", PHI)
        _arc(axes, z, np.cross(node, z) * -1.0, 0.0, -np.radians(55.0), "theta", THETA)
        _arc(axes, node, across, 0.0, np.radians(35.0), "psi", PSI)
        axes.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), zlim=(-0.9, 1.7))
        axes.set_box_aspect((2.6, 2.6, 2.6), zoom=1.2)
        axes.set_axis_off()
        axes.view_init(24.0, 15.0)
        axes.set_title(f'convention "{convention}"')
    return figure


def _matrix(phi, theta, psi):
    return quaternion.matrix(_conventions.euler_wxyz(phi, theta, psi))


def _ellipsoid(axes, turn, lengths):
    u, v = np.mgrid[0 : 2 * np.pi : 41j, 0 : np.pi : 21j]
    points = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    points = np.einsum("ij,jkl->ikl", turn * lengths * 0.5, points)
    axes.plot_surface(*points, color="#cccccc", alpha=0.35, linewidth=0.0)


def _arrow(axes, end, name, color):
    axes.quiver(0.0, 0.0, 0.0, *end, color=color, arrow_length_ratio=0.08, linewidth=1.4)
    axes.text(*(1.08 * end), name, color=color, fontsize=9, ha="center")


def _arc(axes, first, second, start, end, name, color):
    angle = np.linspace(start, end, 40)[:, None]
    line = 1.15 * (np.cos(angle) * first + np.sin(angle) * second)
    axes.plot(*line.T, color=color, linewidth=2.0)
    axes.text(*(1.12 * line[20]), name, color=color, fontsize=10)


def angles_in_both():
    """The angles of one SAM and one LAM motion in both conventions."""
    apophis = catalog.entry("99942 Apophis (2014)").motion(phi0=0.0, psi0=0.0, epoch="2012-12-23")
    toutatis = catalog.entry("4179 Toutatis").motion()
    figure = plots.new_figure((9.0, 7.0))
    grid = figure.subplots(2, 2)
    for row, (motion, name) in enumerate(((apophis, "Apophis, SAM"), (toutatis, "Toutatis, LAM"))):
        seconds = np.linspace(0.0, 1.5 * motion.period_psi, 2001)
        for axes, convention in zip(grid[row], "LS", strict=True):
            plots.angles(axes, motion, seconds, convention=convention)
            axes.set_title(f'{name}, convention "{convention}"', fontsize=10)
    return figure


if __name__ == "__main__":
    main()
