"""Envisat's momentum from 2013 on: eddy currents slow it, the gravity gradient turns its pole.

Mean rotation in the Earth's field (IGRF) on a circular orbit whose node follows the Sun, from the
state that Lin & Zhao (2018, Adv. Space Res. 61, 182) find at the beginning of 2013: a period of
120.674 s, the momentum 8.53 deg from the negative normal of the orbit.  The currents have one free
number, the magnetic tensor, chosen for the slowing of that paper in 2013 to 2015.  What follows
from it is compared: the period of 226 s that radar saw in March 2017 (Sommer et al. 2017, JBIS 70,
45), and the precession of the momentum, in 4.8 d in 2013 and 3.4 d in 2015 (Lin & Zhao).  Before
April 2012 the satellite was controlled.

The mean motion ends in 2018: a tumbling motion of small amplitude then takes a tenth of the orbit.
Radar also sees the satellite turn faster since that year (Fraunhofer FHR, annual report 2021),
which eddy currents cannot do: sunlight is left out here.

    python examples/envisat_momentum.py
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from attitude import Body, Spin, plots
from attitude.averaged import AveragedMotion
from attitude.torques import IGRF, EddyCurrent, GravityGradient

Array = NDArray[np.float64]

PICTURE = "envisat_momentum.png"
DAY, YEAR = 86400.0, 365.25 * 86400.0
MU = 3.986004418e14  # m3/s2
BODY = Body(moments=(17023.3, 124825.7, 129112.2))  # kg m2, published by ESA
# The elements of October 2013 (data/paths/envisat-2013.tle), the node moved to 2013.0.
AXIS = (MU / (14.37637337 * 2.0 * np.pi / DAY) ** 2) ** (1.0 / 3.0)
INCLINATION, NODE = np.radians(98.416), np.radians(71.0)
# S m4: a slowing of 4.5095e-4 a day, as published for 2013 to 2015
MAGNETIC = 6.03e5
PERIOD, TILT = 120.674, np.radians(8.53)
# Years, s: radar's period in March 2017; years, days: turns of the momentum (Lin & Zhao).
RADAR = 2017.2, 226.0
PRECESSION = (2013.5, 4.8), (2015.5, 3.4)


def normal_at(t: ArrayLike) -> Array:
    """The normal of the orbit (..., 3), whose node follows the Sun."""
    node = NODE + 2.0 * np.pi / YEAR * np.asarray(t, dtype=np.float64)
    s = np.sin(INCLINATION)
    z = np.full_like(node, np.cos(INCLINATION))
    return np.stack([s * np.sin(node), -s * np.cos(node), z], axis=-1)


def path(t: Array) -> Array:
    """Positions (..., 3) from the centre of the Earth, m."""
    node = NODE + 2.0 * np.pi / YEAR * t
    ascending = np.stack([np.cos(node), np.sin(node), np.zeros_like(node)], axis=-1)
    across = np.cross(normal_at(t), ascending)
    along = np.sqrt(MU / AXIS**3) * t
    place: Array = AXIS * (np.cos(along)[..., None] * ascending + np.sin(along)[..., None] * across)
    return place


def spin_at_start() -> Spin:
    """Nearly uniform rotation about the short axis, against the sense of the orbit."""
    normal = normal_at(0.0)
    aside = np.cross(normal, (0.0, 0.0, 1.0))
    pole = np.sin(TILT) * aside / np.linalg.norm(aside) - np.cos(TILT) * normal
    omega = 2.0 * np.pi / PERIOD * np.array([0.0, 0.002, 1.0])
    momentum = omega * BODY.moments
    half = momentum / np.linalg.norm(momentum) + pole
    wxyz = np.append(0.0, half / np.linalg.norm(half))
    return Spin("2013-01-01", wxyz, omega)


def turn_of_the_pole(motion: AveragedMotion, t: float) -> tuple[float, float]:
    """Days of a turn of the momentum about the normal, and its mean angle from the negative one."""
    times = t + np.linspace(0.0, 12.0 * DAY, 600)
    poles, normals = motion.at(times).pole, normal_at(times)
    one = np.cross(normals, (0.0, 0.0, 1.0))
    two = np.cross(normals, one)
    angle = np.unwrap(np.arctan2(np.sum(poles * two, axis=1), np.sum(poles * one, axis=1)))
    tilt = np.degrees(np.arccos(-np.sum(poles * normals, axis=1)))
    return 2.0 * np.pi / abs(float(np.polyfit(times, angle, 1)[0])) / DAY, float(np.mean(tilt))


def period_of(size: Array) -> Array:
    """s, of a turn about the short axis with a momentum."""
    period: Array = 2.0 * np.pi * BODY.moments.max() / size
    return period


def main() -> None:
    torques = [EddyCurrent(MAGNETIC, IGRF(), path), GravityGradient(path, MU)]
    motion = AveragedMotion(BODY, spin_at_start(), torques, orbit="averaged", least_tilt="0.1 deg")
    last = motion.reaches(7.0 * YEAR)
    print(f"{'year':>8}{'period':>10}{'published':>11}{'turn of the pole':>18}{'angle':>8}")
    rows = []
    for years in np.arange(0.0, last / YEAR - 12.0 / 365.25, 0.5):
        period = float(period_of(motion.at(years * YEAR).size))
        published = f"{fit(years):9.1f} s" if years < 2.8 else ""
        turn, tilt = turn_of_the_pole(motion, years * YEAR)
        rows.append((2013.0 + years, turn))
        print(f"{2013.0 + years:8.1f}{period:8.1f} s{published:>11}{turn:15.2f} d{tilt:9.2f}°")
    radar = float(period_of(motion.at((RADAR[0] - 2013.0) * YEAR).size))
    print(f"\nMarch 2017: {radar:.0f} s, radar {RADAR[1]:.0f} s")
    print(f"{2013.0 + last / YEAR:.1f}: the mean motion ends, {motion.ends(7.0 * YEAR)}")
    draw(motion, last, np.array(rows))


def fit(years: float) -> float:
    """The period in s that Lin & Zhao fit to glints of 2013 to 2015."""
    return float(PERIOD * np.exp(4.5095e-4 * 365.25 * years))


def draw(motion: AveragedMotion, last: float, turns: Array) -> None:
    t = np.linspace(0.0, last, 600)
    years = 2013.0 + t / YEAR
    figure, (above, middle, below) = plots.stacked((9, 9), 3)
    above.plot(years, period_of(motion.at(t).size), label="eddy currents and gravity gradient")
    shown = np.linspace(0.0, 2.8, 30)
    fitted = [fit(year) for year in shown]
    above.plot(2013.0 + shown, fitted, "k--", lw=2, label="glints, Lin & Zhao 2018")
    above.plot(*RADAR, "o", color="#d55e00", label="radar, Sommer et al. 2017")
    above.axvspan(2018.0, 2020.0, color="0.9", label="faster again, radar (FHR 2021)")
    above.set(ylabel="period of the spin (s)", title="Envisat after its end of April 2012")
    middle.plot(turns[:, 0], turns[:, 1], label="turn about the normal of the orbit")
    middle.plot(*np.transpose(PRECESSION), "ks", label="glints, Lin & Zhao 2018")
    middle.set(ylabel="turn of the momentum (d)", ylim=(0.0, None))
    span = np.linspace(0.0, 30.0 * DAY, 900)
    for start in (0.5 * YEAR, 2.5 * YEAR):
        states, normals = motion.at(start + span), normal_at(start + span)
        angle = np.degrees(np.arccos(-np.sum(states.pole * normals, axis=1)))
        below.plot(2013.0 + (start + span) / YEAR, angle, lw=0.8, color="#0072b2")
    below.axhspan(8.53 - 0.42, 8.53 + 0.42, color="0.85", label="mean, Lin & Zhao 2018")
    below.set(ylabel="from the negative normal (deg)", xlabel="year", xlim=(2012.8, 2020.0))
    for panel in (above, middle, below):
        panel.legend(fontsize=9)
    figure.savefig(PICTURE, dpi=150)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
