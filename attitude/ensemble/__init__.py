"""Many freely rotating bodies as one object: attitudes, periods and brightness as arrays.

How to use it::

    from attitude import Ensemble

    bodies = Ensemble(moments=moments, wxyz=wxyz, angular_velocity=rates, epoch="2026-01-01")
    bodies.at([0.0, 3600.0]).wxyz  # arrays of N rows in, (N, 2, 4) out

_ensemble      `Ensemble`: the states of N members, and what they answer; `EnsembleHistory`;
               `ArcsEnsemble` and `TorquedEnsemble`, the same states with impulses or torques
_evaluation    the epochs of a call: grid or rows
_quantities    `AngleTo` and other quantities, for percentiles, histograms and coverage
_partitioned   `PartitionedEnsemble`: members in the partitions of dask
_members       epochs, inertia and states of the members as the compiled solution takes them
_light         brightness and magnitudes, block by block
_tables        columns of tables; random draws
_arcs          chains of free arcs of N states with the same impulses
"""

from typing import TYPE_CHECKING

from attitude._support.synonyms import of_module
from attitude.ensemble._ensemble import Ensemble, EnsembleHistory
from attitude.ensemble._quantities import AngleTo

__all__ = ["AngleTo", "Ensemble", "EnsembleHistory", "PartitionedEnsemble"]

if TYPE_CHECKING:
    from attitude.ensemble._partitioned import PartitionedEnsemble
else:
    # Its module needs dask.
    __getattr__ = of_module(__name__, {"PartitionedEnsemble": "attitude.ensemble._partitioned"})
