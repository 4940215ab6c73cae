"""Alternatives to this project, with one interface: solve(moments, wxyz0, omega0, t).

Each module has ``peers()``, which returns a list of `Peer` or raises `Missing` with the reason.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

import numpy as np

MODULES = ("ours", "paper", "scipy_ivp", "heyoka_taylor", "astrojax_dp54", "dlm", "orekit")


class Missing(Exception):
    """The reason why a peer cannot be run."""


@dataclass(frozen=True)
class Peer:
    """One method at one setting.

    name     the method: settings of one method share it
    setting  tolerance or step, as text
    solve    (moments (3,), wxyz0 (4,), omega0 (3,), t (T,) ascending from 0) -> attitudes, body
             to inertial: wxyz (T, 4) or matrices (T, 3, 3), whichever the method returns
    furthest most revolutions that it reaches in a reasonable time
    """

    name: str
    setting: str
    solve: Callable
    furthest: float = 1e12


def every():
    """All peers that are installed, and (module, reason) of those that are not."""
    found, missing = [], []
    for module in MODULES:
        try:
            found += import_module(f"benchmarks.peers.{module}").peers()
        except Missing as err:
            missing.append((module, str(err)))
    return found, missing


def as_wxyz(attitudes):
    """Rows of quaternions, NaN where there is no answer."""
    attitudes = np.asarray(attitudes, dtype=float)
    if attitudes.ndim == 2:
        return attitudes
    from scipy.spatial.transform import Rotation

    good = np.all(np.isfinite(attitudes), axis=(-1, -2))
    out = np.full((len(attitudes), 4), np.nan)
    if np.any(good):
        out[good] = Rotation.from_matrix(attitudes[good]).as_quat(scalar_first=True)
    return out
