"""The mean rotation under weak torques, over years: `AveragedMotion`.

_polhode      the energy in one variable, nodes and means of a nutation in closed form
_means        the means of torques: closed forms, tables of one direction, the torus
_tables       spherical harmonics of a torque and their sums over polhodes, kept on disk
_pack         means and paths as the compiled loops take them
_rates        compiled: mean rates, their integration, the odds at the separatrix
_mean_state   from a state to its mean state
_second_order what second order adds to mean rates
_mean_torques the torques of one body, packed for all of its states; windows of their paths
_tracks       the integration in one direction of time, events
_resonances   resonances of nutation and precession: where, scatter, strength
_history      `AveragedHistory`, mean states at epochs
_motion       `AveragedMotion`, branches
_ensemble     `AveragedEnsemble`, many states that share tables
_plots        figures
"""

from attitude.averaged._ensemble import AveragedEnsemble, AveragedEnsembleHistory
from attitude.averaged._history import AveragedHistory
from attitude.averaged._means import Mean, over_torus, register
from attitude.averaged._motion import AveragedMotion, Branch, Branches
from attitude.averaged._resonances import HIGHEST
from attitude.averaged._tracks import AveragedEvent

__all__ = [
    "HIGHEST",
    "AveragedEnsemble",
    "AveragedEnsembleHistory",
    "AveragedEvent",
    "AveragedHistory",
    "AveragedMotion",
    "Branch",
    "Branches",
    "Mean",
    "over_torus",
    "register",
]
