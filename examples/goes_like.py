"""A box with a wing in geostationary orbit: the tree of its tumbling cycle under sunlight.

Sunlight slows the spin, the body begins to tumble about its long axis, spins up and returns to
short-axis rotation, year after year: the cycle that Benson & Scheeres (2021, J. Guid. Control Dyn.
44, 749) describe for GOES 8.  At each passage of the separatrix the next region is a coin with
computed odds, so a prediction is a tree of branches; all of them are followed here for three years.
Moments are about those of GOES 8; dimensions, materials and state are invented.

    python examples/goes_like.py
"""

from pathlib import Path

import numpy as np

from attitude import plots
from attitude.averaged import AveragedMotion, Branches
from attitude.formats import mission
from attitude.splitting import TorquedRotation

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "goes_like.png"
YEAR = 365.25 * 86400.0
YEARS = 3.0


def main() -> None:
    given = mission.read_motion(DATA / "mission" / "goes-like.toml")
    assert isinstance(given, TorquedRotation)
    motion = AveragedMotion(given.body, given.spin, given.torques, passages="all")
    print("years  branches  sum of odds  |L| of all branches (N m s)")
    for years in np.arange(0.5, YEARS + 0.1, 0.5):
        tree = motion.branches(years * YEAR)
        size = tree.at(years * YEAR).size
        print(
            f"{years:5.1f}{len(tree):10d}{np.sum(tree.odds):13.4f}"
            f"  {np.min(size):.1f} to {np.max(size):.1f}, mean {tree.odds @ size:.1f}"
        )
    print(f"\nThe likeliest of {len(tree)} branches after {YEARS:g} years:")
    for leaf in tree[:5]:
        days = [f"{event.seconds / 86400.0:.0f}" for event in leaf.events if event.odds]
        print(f"  {leaf.odds:.3f}  {' '.join(leaf.regions)}  (passages on day {', '.join(days)})")
    greater = AveragedMotion(given.body, given.spin, given.torques)
    greater.at(YEARS * YEAR)
    strong = [event for event in greater.events if event.may_capture and event.capture != 0.0]
    print(f"\nWith the greater odds at each passage {len(strong)} resonances may capture it.")
    for event in strong:
        print(f"  day {event.seconds / 86400.0:.0f}: {event}")
    draw(tree)


def draw(tree: Branches) -> None:
    from matplotlib import colormaps

    colors = colormaps["viridis"]
    t = np.linspace(0.0, YEARS * YEAR, 1501)
    states = tree.at(t)
    figure, (above, below) = plots.stacked((9, 7), 2)
    for k in np.argsort(states.odds):
        share = states.odds[k] / np.max(states.odds)
        style = {"color": colors(1.0 - share), "lw": 0.6 + 1.4 * share}
        above.plot(t / YEAR, states.size[k], **style)
        below.plot(t / YEAR, np.degrees(states.theta[k]), **style)
    edge = np.degrees(np.arctan(np.exp(0.5 * states.separatrix)))
    below.axhline(edge, color="0.4", ls="--", lw=1, label="separatrix")
    above.set(
        ylabel="|L| (N m s)",
        title=f"A box with a wing under sunlight: {len(tree)} branches, the likeliest dark",
    )
    below.set(xlabel="years", ylabel="theta, momentum to short axis (deg)")
    below.legend()
    figure.savefig(PICTURE, dpi=150)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
