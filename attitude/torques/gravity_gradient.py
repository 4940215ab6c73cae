"""The torque of a point mass on an extended body."""

from dataclasses import dataclass

import numpy as np

from attitude import quaternion, validation
from attitude.errors import AttitudeError
from attitude.paths import two_body
from attitude.torques.torque import Torque, path_of, positions, span_of

_BARYCENTER = " barycenter"
# m3/s2, by the names of the planets: seen from afar, a planet has the mass of its moons too.
GM = {name.removesuffix(_BARYCENTER): value for name, value in two_body.GM.items()}


@dataclass(frozen=True, eq=False)
class GravityGradient(Torque):
    """The gravity-gradient torque 3 GM/r^3 u x (I u) of a point mass.

    Parameters
    ----------
    path : Path, or function
        The body's centre of mass from the point mass (or the other way: only the line matters).
        A function takes TDB seconds (...) since the epoch of the spin and returns (..., 3), m,
        over ICRF axes.
    mu : float or str
        GM of the point mass in m3/s2, or "sun", "moon" or the name of a planet, "earth".

    Notes
    -----
    MacCullagh's formula, the first term of the expansion in (size of the body)/r.  The scheme
    "force-gradient" takes it, also several of them.
    """

    path: object
    mu: object
    columns = 3

    def __post_init__(self):
        self._set("path", path_of(self.path, "path"))
        if isinstance(self.mu, str):
            validation.one_of(self.mu, "mu", tuple(GM))
            self._set("mu", GM[self.mu])
        self._set("mu", validation.positive(self.mu, "mu", unit="m3/s2"))

    def address(self):
        from attitude.torques.compiled import gravity_gradient

        return gravity_gradient.address

    def slope_address(self):
        from attitude.torques.compiled import gravity_gradient_slope

        return gravity_gradient_slope.address

    def parameters(self, body):
        # The part of the tensor that a sphere has turns nothing, and would only cancel.
        tensor = body.tensor - np.min(np.diag(body.tensor)) * np.eye(3)
        return np.concatenate([[self.mu], tensor[np.triu_indices(3)]])

    def span(self, instant):
        return span_of(self.path, instant)

    def sample(self, instant, seconds, low):
        found = positions(self.path, instant, seconds, low, "path")
        if not np.all(np.any(found != 0.0, axis=-1)):
            raise AttitudeError("path passes through the point mass; give a path at a distance.")
        return found

    def potential(self, body, history):
        """The potential energy (S,) in J that goes with the torque, at the epochs of a history.

        Without the part -GM m/r that no attitude changes: GM/(2 r^3) (3 u . I u - tr I).
        """
        seconds = history.seconds.reshape(-1)
        low = np.zeros(seconds.size) if history.low is None else history.low.reshape(-1)
        r = self.sample(history.epoch, seconds, low).reshape(*history.shape, 3)
        distance = np.sqrt(np.sum(r * r, axis=-1))
        u = quaternion.rotate(quaternion.conjugate(history.wxyz), r / distance[..., None])
        form = np.sum(u * (u @ body.tensor), axis=-1)
        return 0.5 * self.mu / distance**3 * (3.0 * form - np.trace(body.tensor))
