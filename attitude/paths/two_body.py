"""Two-body motion from orbital elements, on any conic."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, frames, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen, read_only
from attitude.paths.path import Path, since
from attitude.paths.uniform import known_center

if TYPE_CHECKING:
    from attitude.annotations import Epoch, FloatArray, Real
    from attitude.epochs.instants import Instant

# m3/s2 of DE440, in TDB (Park et al., AJ 161, 105, 2021, table 2).
GM: dict[str, float] = {
    "sun": 1.32712440041279419e20,
    "mercury": 2.2031868551e13,
    "venus": 3.24858592e14,
    "earth": 3.98600435507e14,
    "moon": 4.902800118e12,
    "mars barycenter": 4.2828375816e13,
    "jupiter barycenter": 1.26712764100e17,
    "saturn barycenter": 3.7940584841800e16,
    "uranus barycenter": 5.794556400e15,
    "neptune barycenter": 6.836527100580e15,
    "pluto barycenter": 9.75500e11,
}


@dataclass(frozen=True, eq=False, repr=False)
class Kepler(Immutable, Path):
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

    def __post_init__(self) -> None:
        frozen(self.basis)

    @property
    def period(self) -> float:
        """Orbital period in s; inf on open orbits."""
        if self.eccentricity >= 1.0:
            return math.inf
        axis = self.pericenter_distance / (1.0 - self.eccentricity)
        return 2.0 * math.pi * axis * math.sqrt(axis / self.gm)

    def _state(self, instant, hi, lo):
        from attitude.paths import conic

        position, velocity = np.empty((3, hi.size)), np.empty((3, hi.size))
        orbit = self.pericenter_distance, self.eccentricity, self.gm, self.basis
        at = read_only(hi), read_only(lo), *since(instant, self.pericenter)
        conic.states(*at, self.period, *orbit, position, velocity)
        return position, velocity


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
        m3/s2; that of DE440 for the Sun and the planets, if not given.
    frame : str
        Axes of the elements, one of `frames.FRAMES`.
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
    k = _gm(origin) if gm is None else validation.positive(gm, "gm", unit="m3/s2")
    q = _pericenter_distance(semi_major_axis, pericenter_distance, e)
    angles = [
        validation.number(value, label, unit="rad")
        for value, label in (
            (inclination, "inclination"),
            (node, "node"),
            (pericenter_argument, "pericenter_argument"),
        )
    ]
    pericenter = epochs.instant(epoch)
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
    basis = _perifocal(*angles) @ frames.matrix_to_icrf(frame).T
    return Kepler(q, e, k, pericenter, basis, name, origin, source)


def _gm(center):
    """The GM in m3/s2 of a center by name."""
    if center in GM:
        return GM[center]
    label = center if isinstance(center, str) else center.name
    raise AttitudeError(f"the GM of {label} is not known here; give gm in m3/s2.")


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
