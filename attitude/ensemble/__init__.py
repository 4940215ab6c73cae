"""Many freely rotating bodies as one object: attitudes, periods and brightness as arrays.

_ensemble     `Ensemble`: the states of N members, their descriptions and their answers
_members      states as the compiled solution takes them; epochs, inertia, numbers of members
_evaluation   `EnsembleHistory`, attitudes at a grid or at ragged rows, in blocks and threads
_light        brightness and magnitudes, straight from states
_quantities   angles and order statistics of members; scenes of members
_tables       columns of tables and files; draws from covariances and distributions
_arcs         `ArcsEnsemble`: N states with the same impulses
_torqued      `TorquedEnsemble`: N states under torques, one scheme and one step
_partitioned  `PartitionedEnsemble`: members in the partitions of dask
"""

from typing import TYPE_CHECKING

from attitude.ensemble._ensemble import Ensemble
from attitude.ensemble._evaluation import EnsembleHistory
from attitude.ensemble._quantities import AngleTo

__all__ = ["AngleTo", "Ensemble", "EnsembleHistory", "PartitionedEnsemble"]

if TYPE_CHECKING:
    from attitude.ensemble._partitioned import PartitionedEnsemble
else:

    def __getattr__(name: str) -> type:
        """`PartitionedEnsemble`, whose module needs dask."""
        if name == "PartitionedEnsemble":
            from attitude.ensemble._partitioned import PartitionedEnsemble

            return PartitionedEnsemble
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
