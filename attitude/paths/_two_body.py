"""Two-body motion from orbital elements, on any conic, compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import frames
from attitude._compilation.decorators import quickly_compiled, subroutine
from attitude._compilation.instructions import fma
from attitude._solver.twofloat import two_sum
from attitude._support import validation
from attitude._support.arrays import read_only
from attitude._support.synonyms import arguments
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.paths._path import FrozenArrays, Path, known_center, label_of, since

if TYPE_CHECKING:
    from attitude._support.annotations import Epoch, FloatArray, Real
    from attitude.epochs._instants import Instant


# ---- Compiled two-body motion along any conic, from the time of pericentre
# With the universal variable s (ds = dt / r), k = GM, q the pericentre distance, e the eccentricity
# and b = k (1 - e) / q, Kepler's equation for all conics is
#
#     t = q s + k e s^3 c3(b s^2),
#
# and in the plane of the orbit, x towards the pericentre,
#
#     x = q - k s^2 c2,   y = sqrt(k q (1 + e)) s c1,   r = q + k e s^2 c2,
#
# c1, c2, c3 being Stumpff's functions of b s^2.  No term cancels near the parabola or near the
# pericentre, where E - e sin E would.
#
# Source: Stumpff (1959); Danby, Fundamentals of Celestial Mechanics (1988), section 6.9.

# Below this |z| Stumpff's series is summed; above, their closed forms lose less than 3 bits.
_SERIES = 1.0
# Bisection of the bracket alone needs 64 steps at most; Newton's method mostly needs 4.
_MOST_STEPS = 100


@subroutine
def _stumpff(z):
    """c1, c2, c3 of z."""
    if abs(z) < _SERIES:
        # z^n / (2n + 2)! and / (2n + 3)!: ten terms leave 2e-21 at |z| = 1.
        c2 = c3 = 0.0
        for n in range(9, -1, -1):
            c2 = (1.0 - z * c2) / ((2.0 * n + 1.0) * (2.0 * n + 2.0))
            c3 = (1.0 - z * c3) / ((2.0 * n + 2.0) * (2.0 * n + 3.0))
        return 1.0 - z * c3, c2, c3
    if z > 0.0:
        root = math.sqrt(z)
        sine, half = math.sin(root), math.sin(0.5 * root)
        return sine / root, 2.0 * half * half / z, (root - sine) / (root * z)
    root = math.sqrt(-z)
    sine, half = math.sinh(root), math.sinh(0.5 * root)
    return sine / root, 2.0 * half * half / -z, (sine - root) / (root * -z)


@subroutine
def _solve(t, q, e, k, b):
    """The universal variable s >= 0 of a time t >= 0 since the pericentre."""
    if t == 0.0:
        return 0.0
    # The distance grows from q on, so s <= t / q.  On a closed orbit s is at most that of half a
    # revolution; on an open one s^3 k e / 6 <= t (c3 >= 1/6).
    high = t / q
    if b > 0.0:
        high = min(high, math.pi / math.sqrt(b) * (1.0 + 1e-15))
    elif e > 0.0:
        high = min(high, (6.0 * t / (k * e)) ** (1.0 / 3.0))
    low, s = 0.0, high
    for _ in range(_MOST_STEPS):
        c1, c2, c3 = _stumpff(b * s * s)
        excess = fma(k * e * s * s, s * c3, q * s - t)
        if excess > 0.0:
            high = s
        else:
            low = s
        r = fma(k * e, s * s * c2, q)
        # Newton's step, corrected by the second derivative (Halley).
        step = excess / r
        step = excess / (r - 0.5 * step * k * e * s * c1)
        new = s - step
        if not (low <= new <= high):
            new = 0.5 * (low + high)
        if abs(new - s) <= 2.3e-16 * s:
            return new
        s = new
    return s


@quickly_compiled
def states(hi, lo, base_hi, base_lo, period, q, e, k, basis, position, velocity):
    """Fill position and velocity (3, N), m and m/s, at epochs hi (N,) + lo (N,) or (1,) seconds.

    The pericentre is base_hi + base_lo seconds before the instant from which hi and lo count;
    period is inf for open orbits; basis (2, 3) holds the unit vectors towards the pericentre and
    90 deg on.
    """
    b = k * (1.0 - e) / q
    across = math.sqrt(k * q * (1.0 + e))
    step = 0 if lo.size == 1 else 1
    for n in range(hi.size):
        t, remainder = two_sum(base_hi, hi[n])
        remainder += base_lo + lo[n * step]
        if period < math.inf:
            turns = math.floor((t + remainder) / period + 0.5)
            t = fma(-turns, period, t)
        t += remainder
        s = math.copysign(_solve(abs(t), q, e, k, b), t)
        c1, c2, _ = _stumpff(b * s * s)
        x, y = q - k * s * s * c2, across * s * c1
        r = fma(k * e, s * s * c2, q)
        # dx/ds = -k s c1 and dy/ds = across c0, with c0 = 1 - z c2.
        vx, vy = -k * s * c1 / r, across * (1.0 - b * s * s * c2) / r
        for axis in range(3):
            position[axis, n] = x * basis[0, axis] + y * basis[1, axis]
            velocity[axis, n] = vx * basis[0, axis] + vy * basis[1, axis]


# m3/s2 of DE440, in TDB (Park et al., AJ 161, 105, 2021, table 2); of planets without their moons
# those of NAIF's gm_de440.tpc.
GM: dict[str, float] = {
    "sun": 1.32712440041279419e20,
    "mercury": 2.2031868551e13,
    "venus": 3.24858592e14,
    "earth": 3.98600435507e14,
    "moon": 4.902800118e12,
    "mars": 4.2828373621e13,
    "mars barycenter": 4.2828375816e13,
    "jupiter": 1.2668653190e17,
    "jupiter barycenter": 1.26712764100e17,
    "saturn": 3.7931206234e16,
    "saturn barycenter": 3.7940584841800e16,
    "uranus": 5.7939512565e15,
    "uranus barycenter": 5.794556400e15,
    "neptune": 6.8351031455e15,
    "neptune barycenter": 6.836527100580e15,
    "pluto": 8.696138178e11,
    "pluto barycenter": 9.75500e11,
}


@dataclass(frozen=True, eq=False, repr=False)
class Kepler(FrozenArrays, Path):
    """Two-body motion.  Made by `kepler` and `mpc_orbit`.

    Attributes
    ----------
    pericenter_distance, eccentricity, gm : float
        m, 1, m3/s2.
    pericenter : Instant
        An epoch of pericentre.
    basis : (2, 3) array, read-only
        Unit vectors towards the pericentre, and 90 deg on in the plane; ICRF axes.
    name, center, source
        As for all paths.
    """

    pericenter_distance: float
    eccentricity: float
    gm: float
    pericenter: Instant
    basis: FloatArray
    name: str
    center: str | Path
    source: str

    @property
    def period(self) -> float:
        """Orbital period in s; inf on open orbits."""
        if self.eccentricity >= 1.0:
            return math.inf
        axis = self.pericenter_distance / (1.0 - self.eccentricity)
        return 2.0 * math.pi * axis * math.sqrt(axis / self.gm)

    def _state(self, instant, hi, lo):
        position, velocity = np.empty((3, hi.size)), np.empty((3, hi.size))
        states(
            read_only(hi),
            read_only(lo),
            *since(instant, self.pericenter),
            self.period,
            self.pericenter_distance,
            self.eccentricity,
            self.gm,
            self.basis,
            position,
            velocity,
        )
        return position, velocity


_HINTS = {
    **dict.fromkeys(("a", "sma"), 'give semi_major_axis=, m or text such as "1.2 au"'),
    **dict.fromkeys(("e", "ecc"), "give eccentricity="),
    **dict.fromkeys(("i", "inc"), 'give inclination=, rad or text such as "12 deg"'),
    **dict.fromkeys(("raan", "Omega", "ascending_node", "longitude_of_node"), "give node="),
    **dict.fromkeys(("w", "argp", "omega", "argument_of_pericenter"), "give pericenter_argument="),
    **dict.fromkeys(("M", "M0", "ma", "nu", "true_anomaly"), "give mean_anomaly="),
    **dict.fromkeys(("q", "perihelion"), "give pericenter_distance="),
    **dict.fromkeys(("mu", "GM"), "give gm=, m3/s2"),
}


@arguments(
    _HINTS,
    'kepler(epoch="2026-01-01", semi_major_axis="0.92 au", eccentricity=0.19, '
    'inclination="3.3 deg", node="204 deg", pericenter_argument="126 deg", mean_anomaly=0.0)',
)
def kepler(
    *,
    eccentricity: Real,
    inclination: Real,
    node: Real,
    pericenter_argument: Real,
    epoch: Epoch,
    semi_major_axis: Real | None = None,
    pericenter_distance: Real | None = None,
    mean_anomaly: Real | None = None,
    center: Path | str | int = "sun",
    gm: Real | None = None,
    frame: str = "ecliptic",
    name: str = "orbit",
    source: str = "two-body motion",
) -> Kepler:
    """The path of two-body motion from its elements.

    Parameters
    ----------
    semi_major_axis or pericenter_distance : float or Quantity
        m; one of the two.  A semi-major axis is negative on hyperbolas.
    eccentricity : float
        0 or more; any conic.
    inclination, node, pericenter_argument : float or Quantity
        Radians, or Quantities and text such as "3.3 deg".
    epoch : anything that `epochs.instant` takes
        The epoch of the mean anomaly; of the pericentre where no mean anomaly is given.
    mean_anomaly : float or Quantity, optional
        Radians, on ellipses and hyperbolas.
    center : Path, str or int
        A path, or a body by name or NAIF number.
    gm : float or Quantity, optional
        m3/s2; that of DE440 for the Sun, the Moon, planets and barycentres of planets with their
        moons, if not given.
    frame : str
        Axes of the elements, one of `frames.FRAMES`; the ecliptic by default, about the Earth too.
    name, source : str
        See `Path`.

    Raises
    ------
    AttitudeError
        For elements that define no orbit, and for a center without a known GM.

    Notes
    -----
    Solves Kepler's equation to 1e-15 of the distance at any eccentricity (against 40 digits);
    200 to 400 ns an epoch.  No perturbations: an asteroid leaves its osculating orbit by
    thousands of km within months.
    """
    e = validation.number(eccentricity, "eccentricity")
    if e < 0.0:
        raise AttitudeError(f"eccentricity is {e!r}; it must be zero or greater.")
    origin = known_center(center)
    k = gm_of(origin) if gm is None else validation.positive(gm, "gm", unit="m3/s2")
    q = _pericenter_distance(semi_major_axis, pericenter_distance, e)
    angles = {"inclination": inclination, "node": node, "pericenter_argument": pericenter_argument}
    turns = [validation.number(value, label, unit="rad") for label, value in angles.items()]
    pericenter = _inputs.instant(epoch)
    if mean_anomaly is not None:
        anomaly = validation.number(mean_anomaly, "mean_anomaly", unit="rad")
        if e == 1.0:
            raise AttitudeError(
                "a parabola (eccentricity 1) has no mean anomaly; leave it out, and give the time "
                "of pericentre as epoch."
            )
        axis = q / abs(1.0 - e)
        if e < 1.0:
            anomaly = math.remainder(anomaly, 2.0 * math.pi)
        pericenter = pericenter.after(-anomaly * axis * math.sqrt(axis / k))
    basis = _perifocal(*turns) @ frames.matrix_to_icrf(frame).T
    return Kepler(q, e, k, pericenter, basis, name, origin, source)


def gm_of(center: str | Path, name: str = "gm") -> float:
    """The GM in m3/s2 of a center as `known_center` returns it; name: of the parameter for it."""
    if center in GM:
        return GM[center]
    raise AttitudeError(f"the GM of {label_of(center)} is not known here; give {name} in m3/s2.")


def _pericenter_distance(axis, distance, e):
    """The pericentre distance in m from one of the two lengths."""
    if (axis is None) == (distance is None):
        raise AttitudeError("give one of semi_major_axis and pericenter_distance.")
    if distance is not None:
        return validation.positive(distance, "pericenter_distance", unit="m")
    axis = validation.number(axis, "semi_major_axis", unit="m")
    distance = axis * (1.0 - e)
    if not distance > 0.0:
        raise AttitudeError(
            f"semi_major_axis is {axis!r} and eccentricity {e!r}, which define no orbit: the axis "
            "is positive on ellipses, negative on hyperbolas, and a parabola needs "
            "pericenter_distance."
        )
    return distance


def _perifocal(inclination, node, argument):
    """Unit vectors (2, 3) towards the pericentre and 90 deg on, in the frame of the elements."""
    (ci, si), (cn, sn), (cw, sw) = (
        (math.cos(angle), math.sin(angle)) for angle in (inclination, node, argument)
    )
    return np.array(
        [
            [cn * cw - sn * ci * sw, sn * cw + cn * ci * sw, si * sw],
            [-cn * sw - sn * ci * cw, -sn * sw + cn * ci * cw, si * cw],
        ]
    )
