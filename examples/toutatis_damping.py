"""In what time does Toutatis stop tumbling? One rotation, four materials, and the literature.

The mean rotation of a homogeneous ellipsoid of 4.60 x 2.29 x 1.92 km (Hudson, Ostro & Scheeres
2003, Icarus 161, 346) from the state of 1992, a long-axis mode, through the separatrix to rotation
about the short axis.  The friction follows from the material (`attitude.torques.Rheology`): quality
factors with mu Q = 5e12 Pa (Harris 1994, Icarus 107, 209) and a thousandth of it, and Maxwell
bodies whose viscosity loses as much as Q = 100 at the rate of the tumbling, and a thousandth of it.

Published estimates of the damping time have the form K mu Q / (rho a^2 w^3), and differ by K: the
rule of Harris, P = 17 D^(2/3) T^(1/3) in hours, km and 10^9 years, on the K of Burns & Safronov
(1973, MNRAS 165, 403); "a few times 10^2" of Sharma, Burns & Hui (2005, MNRAS 359, 79), who find
that earlier ones differ by factors of the order of 10.  Breiter, Rozek & Vokrouhlicky (2012, MNRAS
427, 755) find much smaller differences than claimed.  The numbers of a material are known worse.
Self-gravity, which Kwiecinski (2020, MNRAS 497, 19) finds to matter for a Maxwell body, enters as
in a sphere: these are times of a law and its numbers, and no prediction.

    python examples/toutatis_damping.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import plots
from attitude.averaged import AveragedMotion
from attitude.formats import spin_file
from attitude.torques import InternalDissipation, Maxwell, QualityFactor, Rheology

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "toutatis_damping.png"
YEAR, DAY = 365.25 * 86400.0, 86400.0
SEMI_AXES = 2300.0, 1145.0, 960.0
DENSITY = 2500.0  # kg/m3, assumed
RIGIDITY = 5e10  # Pa, with Q = 100
# rad/s of the nutation: the rotation about the long axis in 5.4 d
TUMBLING = 2.0 * np.pi / (5.4 * DAY)
MATERIALS = (
    ("mu Q = 5e12 Pa", QualityFactor(RIGIDITY, 100.0)),
    ("mu Q = 5e9 Pa", QualityFactor(RIGIDITY / 1000.0, 100.0)),
    ("Maxwell, as Q = 100", Maxwell(RIGIDITY, 100.0 * RIGIDITY / TUMBLING)),
    ("Maxwell, as Q = 1e5", Maxwell(RIGIDITY, 1e5 * RIGIDITY / TUMBLING)),
)
LONGEST = 1e18 * YEAR


def times(motion: AveragedMotion, degrees: float) -> tuple[float, float]:
    """s to the separatrix, and on to a greatest tilt of so many degrees from the short axis."""
    motion.at(LONGEST)
    passage = next(event for event in motion.events if event.kind == "passage")
    low, high = passage.seconds, LONGEST
    for _ in range(200):
        middle = 0.5 * (low + high)
        if float(motion.at(middle).theta) > np.radians(degrees):
            low = middle
        else:
            high = middle
    return passage.seconds, high - passage.seconds


def main() -> None:
    free = spin_file.read(DATA / "spin" / "toutatis.toml").motion
    size = float(np.linalg.norm(free.momentum))
    rate = size / float(free.body.moments.max())  # of the relaxed rotation
    print(f"{'material':24}{'to the separatrix':>19}{'then to 5 deg':>16}{'K':>8}")
    ways = []
    for name, law in MATERIALS:
        friction = InternalDissipation(Rheology(SEMI_AXES, DENSITY, law))
        motion = AveragedMotion(free.body, free.spin, friction, least_tilt="1 deg")
        first, second = times(motion, 5.0)
        strength = 1.0 / float(np.max(Rheology(SEMI_AXES, DENSITY, law).loss([TUMBLING])))
        unit = strength / (DENSITY * SEMI_AXES[0] ** 2 * rate**3)
        print(
            f"{name:24}{first / YEAR / 1e9:12.3g} Gyr{second / YEAR / 1e9:12.3g} Gyr"
            f"{(first + second) / unit:8.3g}"
        )
        ways.append((name, motion, 1.5 * (first + second)))
    unit = RIGIDITY * 100.0 / (DENSITY * SEMI_AXES[0] ** 2 * rate**3) / YEAR / 1e9
    diameter, hours = 2e-3 * np.cbrt(np.prod(SEMI_AXES)), 2.0 * np.pi / rate / 3600.0
    harris = (hours / 17.0) ** 3 / diameter**2
    published = (
        ("Harris 1994", harris, harris),
        ("Sharma et al. 2005, K of 200 to 500", 200.0 * unit, 500.0 * unit),
    )
    print(f"\nPublished rules for mu Q = 5e12 Pa and a turn of the momentum in {hours:.0f} h:")
    for name, low, high in published:
        ends = sorted({low, high})
        years, factors = (" to ".join(f"{end / one:.3g}" for end in ends) for one in (1.0, unit))
        print(f"  {name:38}{years:>16} Gyr, K = {factors}")
    draw(ways, published)


def draw(
    ways: list[tuple[str, AveragedMotion, float]], published: tuple[tuple[str, float, float], ...]
) -> None:
    figure, (panel,) = plots.stacked((9, 6), 1)
    for name, motion, end in ways:
        t = np.append(0.0, np.geomspace(1e-4 * end, end, 800))
        states = motion.at(t)
        panel.plot(t[1:] / YEAR / 1e9, np.degrees(states.theta[1:]), label=name)
    edge = np.degrees(np.arctan(np.exp(0.5 * states.separatrix)))
    panel.axhline(edge, color="0.4", ls="--", lw=1, label="separatrix")
    panel.axvline(4.6, color="0.6", ls=":", label="age of the solar system")
    for (name, low, high), color in zip(published, ("k", "0.6"), strict=True):
        panel.axvspan(low, max(high, 1.06 * low), color=color, alpha=0.4, label=name)
    panel.set(
        xscale="log",
        xlabel="10^9 years",
        ylabel="theta, momentum to short axis (deg)",
        ylim=(0.0, 45.0),
        title="Toutatis from long-axis to short-axis mode, by the material",
    )
    panel.legend(fontsize=9)
    figure.savefig(PICTURE, dpi=150)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
