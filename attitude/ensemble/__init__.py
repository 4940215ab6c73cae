"""Many freely rotating bodies as one object: attitudes, periods and brightness as arrays.

ensemble      `Ensemble`: the states of N members
attitudes     attitudes at epochs, and blocks of them
lit           brightness and magnitudes; `light`, their blocks; `light_loops`, the compiled loop
collection    construction, members, parts and joined ensembles
described     modes, periods, ranges and invariants
sources       published periods, tables and files, random draws
tables, draws columns of tables; draws from covariances and distributions
answer        `EnsembleHistory`, the attitudes
arguments     rows, names and numbers of members that agree
rows          the epochs of a call: a grid, or ragged rows
epoch         epochs of members, and seconds since them
inertia       moments and tensors of the members
members       states as the compiled solution takes them
reduced       percentiles, histograms and coverage; `quantities`, of what; `views`, of scenes
arcs          `ArcsEnsemble`: N states with the same impulses
torqued       `TorquedEnsemble`: N states under torques, one scheme and one step
evaluate      blocks of members and rows, in threads
partitioned   `PartitionedEnsemble`: members in the partitions of dask
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
