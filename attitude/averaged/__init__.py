"""The mean rotation under weak torques, over years: `AveragedMotion`.

_polhode      the energy in one variable, nodes and means of a nutation in closed form
_means        the means of torques: closed forms, tables of one direction, the torus
_tables       spherical harmonics of a torque and their sums over polhodes, kept on disk
_pack         means and paths as the compiled loops take them
_rates        compiled: mean rates, their integration, the odds at the separatrix
_mean_state   from a state to its mean state
_motion       `AveragedMotion`, `AveragedHistory`, events, branches
"""

from attitude.averaged._means import Mean, over_torus, register
from attitude.averaged._motion import AveragedEvent, AveragedHistory, AveragedMotion, Branch

__all__ = [
    "AveragedEvent",
    "AveragedHistory",
    "AveragedMotion",
    "Branch",
    "Mean",
    "over_torus",
    "register",
]
