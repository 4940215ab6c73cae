"""The torque of a point mass on an extended body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude._support.pairs import Seconds
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.paths import _two_body
from attitude.paths._path import body_name
from attitude.torques._torque import Torque, path_of, positions

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray, Real
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.motions._history import AttitudeHistory
    from attitude.paths._path import Path
    from attitude.torques._torque import AnyPath


@dataclass(frozen=True, eq=False, init=False)
class GravityGradient(Torque):
    """The gravity-gradient torque 3 GM/r^3 u x (I u) of a point mass.

    Parameters
    ----------
    path : Path, or function
        The body's centre of mass from the point mass, or the reverse: the sign has no effect.
        A function takes TDB seconds (...) since the epoch of the spin and returns (..., 3), m,
        over ICRF axes.
    mu : float, Quantity or str
        GM of the point mass in m3/s2, or a body by name or digits of its NAIF number: "sun",
        "moon", a planet alone ("saturn") or with its moons ("saturn barycenter").

    Attributes
    ----------
    path : Path
    mu : float
        m3/s2.

    Raises
    ------
    AttitudeError
        For a path or GM of another type, a body whose GM is not known, a path from another named
        body than that one, a GM that is not positive.

    Notes
    -----
    MacCullagh's formula, the first term of the expansion in (size of the body)/r.  The scheme
    "force-gradient" accepts one or several of these torques.
    """

    path: Path
    mu: float
    columns = 3
    _function = "gravity_gradient"
    _slope = "gravity_gradient_slope"

    def __init__(self, path: AnyPath, mu: Real) -> None:
        self._set("path", path_of(path, "path"))
        if isinstance(mu, str):
            mu = self._gm_of(body_name(mu, "mu"))
        self._set("mu", validation.positive(mu, "mu", unit="m3/s2"))

    def _gm_of(self, mass: str) -> float:
        """The GM in m3/s2 of a body by name, which is at one end of the path."""
        names = str(self.path.center), self.path.name.lower()
        ends = [name.removesuffix(" barycenter") for name in names]
        if ends[0] in _two_body.GM and mass.removesuffix(" barycenter") not in ends:
            raise AttitudeError(
                f"path is relative to {names[0]}, and mu is that of {mass}; give a path "
                f"relative to {mass}, or mu in m3/s2."
            )
        return _two_body.gm_of(mass, "mu")

    def parameters(self, body: Body) -> FloatArray:
        """GM, and the upper triangle by rows of the tensor less a multiple of the identity (7,)."""
        # A spherical part of the tensor causes no torque, and would only cancel.
        tensor = body.tensor - np.min(np.diag(body.tensor)) * np.eye(3)
        return np.concatenate([[self.mu], tensor[np.triu_indices(3)]])

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """Positions (K, 3) in m along the path, ICRF axes.

        Raises
        ------
        AttitudeError
            If one of them is the zero vector, or not finite.
        """
        places = positions(self.path, instant, seconds, low, "path")
        if not np.all(np.any(places != 0.0, axis=-1)):
            raise AttitudeError("path passes through the point mass; give a path at a distance.")
        return places

    def potential(self, body: Body, history: AttitudeHistory) -> FloatArray:
        """The potential energy (S,) in J of the torque, at the epochs of a history.

        GM/(2 r^3) (3 u . I u - tr I), without the part -GM m/r, which no attitude changes.
        """
        r = self.sample(history.epoch, *Seconds.of(history).flat).reshape(*history.shape, 3)
        distance = np.sqrt(np.sum(r * r, axis=-1))
        u = quaternion.rotate(quaternion.conjugate(history.wxyz), r / distance[..., None])
        form = np.sum(u * (u @ body.tensor), axis=-1)
        return 0.5 * self.mu / distance**3 * (3.0 * form - np.trace(body.tensor))
