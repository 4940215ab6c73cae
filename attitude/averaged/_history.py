"""`AveragedHistory`: mean states at epochs, and the free rotations that have them."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import regime as solver_regime
from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude.averaged._polhode import LAM_PLUS, REGIONS, Nutations, shares
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Iterable

    from astropy.table import QTable

    from attitude._support.annotations import FilePath, FloatArray, IntArray, Real
    from attitude.averaged._mean_torques import Packing
    from attitude.averaged._tracks import AveragedEvent
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body


class AveragedHistory(Immutable):
    """Mean states at epochs of shape S, made by `AveragedMotion.at`.

    Attributes
    ----------
    seconds : array of shape S
        TDB seconds since the epoch of the spin.
    odds : array
        (B,) of the branches of ``passages="all"``, for which S is (B, ...); else empty.
    momentum : (S, 3) array
        N m s over ICRF axes.
    y : array of shape S
        2 ln tan theta.
    region : array of shape S
        0 to 3: SAM+, SAM-, LAM+, LAM-.
    """

    def __init__(
        self,
        packing: Packing,
        seconds: FloatArray,
        states: FloatArray,
        region: IntArray,
        odds: FloatArray | None = None,
    ) -> None:
        self._packing: Packing
        self.__dict__.update(
            _packing=packing,
            seconds=frozen(np.array(seconds)),
            momentum=frozen(np.array(states[..., :3])),
            y=frozen(np.array(states[..., 3])),
            region=frozen(np.array(region)),
            odds=frozen(np.zeros(0) if odds is None else np.array(odds)),
        )

    seconds: FloatArray
    momentum: FloatArray
    y: FloatArray
    region: IntArray
    odds: FloatArray

    @property
    def epoch(self) -> Instant:
        """Instant from which the seconds count."""
        return self._packing.torques.instant

    @property
    def body(self) -> Body:
        """The body."""
        return self._packing.torques.body

    def __len__(self) -> int:
        if not self.seconds.shape:
            raise TypeError("a history of one scalar epoch has no length")
        return len(self.seconds)

    def __getitem__(self, index: Any) -> AveragedHistory:
        """The history of some of the epochs."""
        states = np.concatenate([self.momentum, self.y[..., None]], axis=-1)[index]
        return AveragedHistory(self._packing, self.seconds[index], states, self.region[index])

    def __repr__(self) -> str:
        return f"<AveragedHistory of {self.seconds.size} epochs>"

    @property
    def separatrix(self) -> float:
        """y of the separatrix."""
        return self._packing.axes.separatrix

    @property
    def size(self) -> FloatArray:
        """|L| (S,) in N m s."""
        return np.asarray(np.sqrt(np.sum(self.momentum**2, axis=-1)))

    @property
    def pole(self) -> FloatArray:
        """Unit vectors (S, 3) along the momentum, ICRF axes."""
        return np.asarray(self.momentum / self.size[..., None])

    @property
    def theta(self) -> FloatArray:
        """The angle (S,) in rad between momentum and short axis, where the middle one is across."""
        return np.asarray(np.arctan(np.exp(0.5 * self.y)))

    @property
    def mode(self) -> Any:
        """ "SAM" or "LAM" for each epoch (S,)."""
        return np.where(self.region < LAM_PLUS, "SAM", "LAM")

    @property
    def near_end(self) -> FloatArray:
        """Unit vectors (S, 3) over the body axes: the end of the axis that the momentum circles."""
        ends = np.array([self._packing.axes.end(k) for k in range(4)])
        return np.asarray(ends[self.region])

    @property
    def energy(self) -> FloatArray:
        """Kinetic energy (S,) in J."""
        return self._packing.axes.energy(self.size, self.y)

    @cached_property
    def P_psi(self) -> FloatArray:
        """Periods of the nutation (S,) in s."""
        out = np.full(self.y.size, np.nan)
        flat, region = self.y.reshape(-1), self.region.reshape(-1)
        for k in range(4):
            chosen = (region == k) & np.isfinite(flat)
            h = np.abs(flat[chosen] - self._packing.axes.separatrix)
            out[chosen] = Nutations.of(self._packing.axes, k, np.maximum(h, 1e-15)).period
        return frozen(out.reshape(self.y.shape) / self.size)

    @cached_property
    def P_phi(self) -> FloatArray:
        """Mean periods (S,) in s of the long axis about the momentum."""
        axes = self._packing.axes
        p, complement = shares(self.y)
        zero = np.zeros_like(p)
        unit = np.stack([np.sqrt(p), zero, np.sqrt(complement)], axis=-1)
        omega = (self.size[..., None] * unit / axes.moments).reshape(-1, 3)
        known = np.isfinite(omega[:, 0])
        out = np.full(len(omega), np.nan)
        if np.any(known):
            out[known] = solver_regime.regimes(axes.moments, omega[known]).P_phi_L
        return frozen(out.reshape(self.y.shape))

    @cached_property
    def weakness(self) -> FloatArray:
        """|N| P/(2 pi |L|) (S,), the share of the momentum that torques change in a radian."""
        states = np.concatenate([self.momentum, self.y[..., None]], axis=-1).reshape(-1, 4)
        flat = zip(self.seconds.reshape(-1), states, self.region.reshape(-1), strict=True)
        values = [
            self._packing.weakness_of(float(t), x, int(k)) if np.isfinite(x[3]) else np.nan
            for t, x, k in flat
        ]
        return frozen(np.array(values).reshape(self.y.shape))

    def free_rotation(self, phases: tuple[Real, Real] | None = None, seed: int = 0) -> FreeRotation:
        """The exact free rotation with the mean momentum and energy of one epoch.

        Parameters
        ----------
        phases : (float, float), optional
            Of nutation and precession, in turns.  Means leave both unknown: without them they are
            drawn at random.
        seed : int
            Of the draw.

        Raises
        ------
        AttitudeError
            For a history of more than one epoch; choose one, ``states[k]``.
        """
        if self.seconds.shape:
            raise AttitudeError(
                f"the history has {self.seconds.size} epochs, and a free rotation starts from one; "
                "choose it, as in states[0].free_rotation()."
            )
        if phases is None:
            one, two = validation.generator(seed).random(2)
        else:
            one, two = (validation.number(phase, "phases") for phase in phases)
        axes = self._packing.axes
        count = 4096
        nodes = axes.nodes(float(self.y), int(self.region), count)
        unit = nodes[int((one % 1.0) * count) % count]
        unit = unit / np.sqrt(unit @ unit)
        omega = axes.matrix @ (float(self.size) * unit / axes.moments)
        start, target = axes.matrix @ unit, self.pole
        half = start + target
        if half @ half < 1e-12:
            half = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
        wxyz = np.array([0.0, *(half / np.sqrt(half @ half))])
        angle = math.pi * two
        turn = np.array([math.cos(angle), *(math.sin(angle) * target)])
        epoch = self.epoch.after(float(self.seconds))
        spin = Spin(
            epoch=epoch, wxyz=quaternion.multiply(turn, wxyz), angular_velocity=omega, frame="icrf"
        )
        return FreeRotation(self.body, spin)

    def plot(
        self,
        path: FilePath | None = None,
        *,
        events: Iterable[AveragedEvent] = (),
        title: str | None = None,
    ) -> Any:
        """A figure of momentum, tilt, pole and periods against time, with events.

        Parameters
        ----------
        path : str or path, optional
            File of the picture to write, in a format of matplotlib.
        events : iterable of AveragedEvent
            Those to mark, as `AveragedMotion.events`.
        title : str, optional

        Returns
        -------
        matplotlib Figure

        Raises
        ------
        AttitudeError
            For a history of other shapes than epochs (T,) or branches (B, T).
        """
        from attitude.averaged import _plots

        return _plots.of_history(self, events, path, title)

    def table(self) -> QTable:
        """A QTable with a row for each epoch: times, momentum, theta, mode, energy, periods.

        Epochs of several axes in the order of their elements; those of all branches one branch
        after another, with its number from 1 on, `branch`, and its `odds`.
        """
        from astropy.table import QTable
        from astropy.units import Quantity

        t = self.seconds.ravel()
        table = QTable({"time": _instants.times(self.epoch, t)})
        table["tdb_seconds"] = Quantity(t, "s")
        if len(self.odds):
            table["branch"] = np.repeat(np.arange(1, len(self) + 1), len(t) // len(self))
            table["odds"] = self.odds[table["branch"] - 1]
        for name, unit in (("size", "N m s"), ("theta", "rad"), ("energy", "J")):
            table[name] = Quantity(getattr(self, name).ravel(), unit)
        for k, name in enumerate(("pole_x", "pole_y", "pole_z")):
            table[name] = self.pole[..., k].ravel()
        table["region"] = np.array(REGIONS)[self.region.ravel()]
        for name in ("P_psi", "P_phi"):
            table[name] = Quantity(getattr(self, name).ravel(), "s")
        return table
