"""Motions of a body, and what they answer at epochs: attitudes, rates, periods, derivatives.

_body, _spin       `Body` and `Spin`: the inertia, and the state of rotation at an epoch
_motion, _history  `Motion`, the contract; `AttitudeHistory`, the attitudes that motions return
_free_rotation     `FreeRotation`; `certify`: proved distances of attitudes from the exact one;
                   _description, _predictability and _differentiable say more of it
_table             `AttitudeTable`: attitudes that are given at epochs
_propagation       `propagate`: plain arrays in, plain arrays out
_published         states in the form of papers; _conventions of their angles, _uncertainty
_axes              attitudes relative to other axes than ICRF

Chains of free rotations and motions under torques stand in `attitude.torques`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module

if TYPE_CHECKING:
    # The names of _WHERE, for editors and type checkers.
    from attitude._solver.regime import Mode as Mode
    from attitude.motions._body import Body as Body
    from attitude.motions._free_rotation import FreeRotation as FreeRotation
    from attitude.motions._history import AttitudeHistory as AttitudeHistory
    from attitude.motions._motion import Motion as Motion
    from attitude.motions._propagation import propagate as propagate
    from attitude.motions._spin import Spin as Spin
    from attitude.motions._table import AttitudeTable as AttitudeTable

# The module that defines each name, imported when the name is first used.
_WHERE = {
    "AttitudeHistory": "attitude.motions._history",
    "AttitudeTable": "attitude.motions._table",
    "Body": "attitude.motions._body",
    "FreeRotation": "attitude.motions._free_rotation",
    "Mode": "attitude._solver.regime",
    "Motion": "attitude.motions._motion",
    "Spin": "attitude.motions._spin",
    "propagate": "attitude.motions._propagation",
}

__all__ = sorted(_WHERE)


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__, _WHERE)


def __dir__() -> list[str]:
    return sorted({*globals(), *_WHERE})
