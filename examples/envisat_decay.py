"""Envisat from 2013 on: eddy currents slow its spin, gravity turns its momentum.

The satellite was controlled until April 2012.  It is followed here from the first day of 2013, when
its period was 120.7 s, by the means of gravity gradient and eddy currents over rotation and orbit.
One number is fitted, the magnetic tensor: to the slowing of the spin.  The turning of the momentum
about the normal of the orbit is then a prediction, and both are compared with what was observed.
The mean motion ends by itself in 2018, where a nutation takes a tenth of the orbit.  Light is left
out: since 2018 radar sees Envisat spin up, which eddy currents cannot do.

Published: the period 120.674 s exp(4.5095e-4 d) and the turns of the momentum in 4.8 d (2013) and
3.4 d (2015), Lin & Zhao (2018), Adv. Space Res. 61, 182; 134.74 s on 25 September 2013, Kucharski
et al. (2014), IEEE TGRS 52, 7651; 226 s in March 2017, Sommer et al. (2017), J. Br. Interplanet.
Soc. 70, 45; spin-up since 2018, Fraunhofer FHR, annual report 2021.

    python examples/envisat_decay.py
"""

import numpy as np
from numpy.typing import NDArray

from attitude import Body, Spin
from attitude.averaged import AveragedHistory, AveragedMotion
from attitude.torques import DipoleField, EddyCurrent, GravityGradient

Array = NDArray[np.float64]

PICTURE = "envisat_decay.png"
DAY, YEAR = 86400.0, 365.25 * 86400.0
GM, RADIUS, INCLINATION = 3.986004418e14, 6378.137e3 + 767e3, np.radians(98.4)
MOMENTS = (17023.0, 124826.0, 129112.0)  # kg m2
TENSOR = 5.883e5  # S m4, in all directions: fitted to the slowing
PERIOD, TILT = 120.674, np.radians(8.53)
# Years since 2013.0, s.
PERIODS = {"Kucharski et al. 2014": (0.732, 134.74), "Sommer et al. 2017": (4.2, 226.0)}
TURNS = {0.5: 4.8, 2.5: 3.4}  # d


def normal(t: Array) -> Array:
    """Of the orbit, which turns once a year with the Sun."""
    node = 2.0 * np.pi * np.asarray(t) / YEAR
    found: Array = np.stack(
        [
            np.sin(INCLINATION) * np.sin(node),
            -np.sin(INCLINATION) * np.cos(node),
            np.full_like(node, np.cos(INCLINATION)),
        ],
        axis=-1,
    )
    return found


def orbit(t: Array) -> Array:
    """Positions in m at seconds, ICRF axes: a circle in a plane that turns with the Sun."""
    t = np.asarray(t, dtype=np.float64)
    node, angle = 2.0 * np.pi * t / YEAR, np.sqrt(GM / RADIUS**3) * t
    along = np.stack([np.cos(node), np.sin(node), 0.0 * node], axis=-1)
    across = np.cross(normal(t), along)
    found: Array = np.cos(angle)[..., None] * along + np.sin(angle)[..., None] * across
    return RADIUS * found


def main() -> None:
    body = Body(moments=MOMENTS)
    zenith = normal(np.zeros(1))[0]
    side = np.cross(zenith, (0.0, 0.0, 1.0))
    pole = -np.cos(TILT) * zenith + np.sin(TILT) * side / np.linalg.norm(side)
    first = np.cross(pole, (1.0, 0.0, 0.0))
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(pole, first), pole], axis=1)
    rate = 2.0 * np.pi / PERIOD
    spin = Spin.from_matrix(
        epoch="2013-01-01", matrix=axes, angular_velocity=(0.002 * rate, 0.001 * rate, rate)
    )
    torques = [
        GravityGradient(orbit, GM),
        EddyCurrent(TENSOR, DipoleField((0.0, 0.0, -7.8e22)), orbit),
    ]
    motion = AveragedMotion(body, spin, torques, orbit="averaged")
    last = motion.reaches(7.0 * YEAR)
    print(f"mean motion until {2013.0 + last / YEAR:.1f}: {motion.events[-1]}")
    t = np.arange(0.0, last, 0.1 * DAY)
    states = motion.at(t)
    period = 2.0 * np.pi * MOMENTS[2] / states.size
    print("period of the spin (s)")
    for name, (years, seen) in PERIODS.items():
        found = np.interp(years * YEAR, t, period)
        print(f"  {2013.0 + years:.2f}: {found:.1f}, seen {seen} ({name})")
    fitted = PERIOD * np.exp(4.5095e-4 * t / DAY)
    print(f"  at most {100 * np.max(np.abs(period / fitted - 1)[t < 4.2 * YEAR]):.1f} % from the "
          "published exponential until March 2017")  # fmt: skip
    print("turn of the momentum about the normal of the orbit (d)")
    turns = turn_of(t, states)
    for years, seen in TURNS.items():
        turn = float(np.median(turns[np.abs(t / YEAR - years) < 0.1]))
        print(f"  {2013.0 + years:.1f}: {turn:.2f}, seen {seen}")
    off = np.degrees(np.arccos(np.clip(np.sum(states.pole * -normal(t), axis=1), -1.0, 1.0)))
    print(f"angle to the normal: {np.min(off):.1f} to {np.max(off):.1f} degrees")
    draw(t, period, fitted, turns, off)


def turn_of(t: Array, states: AveragedHistory) -> Array:
    """Days in which the momentum turns about the normal, at each epoch."""
    up = normal(t)
    node = 2.0 * np.pi * t / YEAR
    along = np.stack([np.cos(node), np.sin(node), 0.0 * node], axis=-1)
    across = np.cross(up, along)
    azimuth = np.unwrap(
        np.arctan2(np.sum(states.pole * across, axis=1), np.sum(states.pole * along, axis=1))
    )
    step = 100  # 10 d
    rate = np.abs(azimuth[step:] - azimuth[:-step]) / (t[step:] - t[:-step])
    found: Array = np.interp(t, 0.5 * (t[step:] + t[:-step]), 2.0 * np.pi / rate / DAY)
    return found


def draw(t: Array, period: Array, fitted: Array, turns: Array, off: Array) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    years = 2013.0 + t / YEAR
    figure, panels = plt.subplots(3, 1, figsize=(9, 9), sharex=True, layout="constrained")
    panels[0].plot(years, period, label="means of eddy currents and gravity")
    shown = t < 3.7 * YEAR
    panels[0].plot(years[shown], fitted[shown], "k--", lw=1, label="Lin & Zhao 2018, laser ranging")
    for name, (when, seen) in PERIODS.items():
        panels[0].plot(2013.0 + when, seen, "o", label=name)
    panels[0].axvspan(2018.0, 2020.0, color="0.9", label="radar sees spin-up")
    panels[0].set(ylabel="period (s)", title="Envisat: spin and momentum")
    panels[0].legend(fontsize=8)
    panels[1].plot(years, turns, lw=1)
    panels[1].plot([2013.0 + k for k in TURNS], list(TURNS.values()), "o", label="Lin & Zhao 2018")
    panels[1].set(ylabel="turn of the momentum (d)")
    panels[1].legend(fontsize=8)
    panels[2].plot(years, off, lw=0.5)
    panels[2].set(ylabel="momentum to normal of the orbit (deg)", xlabel="year")
    for panel in panels:
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
