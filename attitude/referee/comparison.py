"""Results of `compare`: errors and cost of each run, measured orders, a table."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from attitude.immutable import Immutable

if TYPE_CHECKING:
    from astropy.table import QTable


@dataclass(frozen=True, eq=False)
class Run(Immutable):
    """The errors and the cost of one integrator at one step or tolerance.

    Attributes
    ----------
    name : str
        Of the integrator.
    step : float
        s; of an adaptive integrator its relative tolerance.
    attitude_error : float
        rad, the largest over the epochs compared; the sign of the quaternion is ignored.
    rate_error : float
        Of the angular velocity, relative to its largest component.
    energy_drift, momentum_drift : float
        Largest relative change of the energy, and of the momentum as a vector in ICRF.
    seconds : float
        Wall time of the whole run.
    seconds_per_step : float
        NaN for an adaptive integrator.
    """

    name: str
    step: float
    attitude_error: float
    rate_error: float
    energy_drift: float
    momentum_drift: float
    seconds: float
    seconds_per_step: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Immutable):
    """The runs of `compare`; print it for a table.

    Attributes
    ----------
    runs : tuple of Run
    span : float
        s.
    """

    runs: tuple[Run, ...]
    span: float

    def of(self, name: str) -> tuple[Run, ...]:
        """The runs of one integrator, in the order of the steps given."""
        return tuple(run for run in self.runs if run.name == name)

    def orders(self) -> dict[str, tuple[float, ...]]:
        """Measured order of the attitude error from each step to the next: {name: (order, ...)}."""
        found = {}
        for name in dict.fromkeys(run.name for run in self.runs):
            runs = self.of(name)
            found[name] = tuple(
                float(np.log(a.attitude_error / b.attitude_error) / np.log(a.step / b.step))
                for a, b in pairwise(runs)
                if b.attitude_error > 0.0 and a.step != b.step
            )
        return found

    def table(self) -> QTable:
        """The runs as an astropy QTable, one row a run, columns as the attributes of `Run`."""
        from astropy.table import QTable

        names = Run.__dataclass_fields__
        return QTable({name: [getattr(run, name) for run in self.runs] for name in names})

    def __repr__(self) -> str:
        lines = [
            f"against the exact rotation over {self.span:g} s",
            f"{'integrator':20s} {'step or tol':>11s} {'attitude/rad':>12s} {'rates':>8s} "
            f"{'energy':>8s} {'momentum':>8s} {'cost/ms':>8s} {'ns/step':>8s}",
        ]
        for run in self.runs:
            each = "" if np.isnan(run.seconds_per_step) else f"{run.seconds_per_step * 1e9:8.0f}"
            lines.append(
                f"{run.name:20s} {run.step:11.3g} {run.attitude_error:12.1e} {run.rate_error:8.1e} "
                f"{run.energy_drift:8.1e} {run.momentum_drift:8.1e} {run.seconds * 1e3:8.2f} {each}"
            )
        return "\n".join(lines)
