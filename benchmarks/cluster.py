"""What do the processes of a dask cluster give for many members at epochs of their own?

    python benchmarks/cluster.py

Wall time of the brightness of 2 10^5 ellipsoids at 160 epochs each, in 20 partitions, reduced to a
mean in each partition, by one call in this process, and by the processes of a LocalCluster.  Beside
it: what the same processes do to a loop that computes nothing else (sha256), which shows how many
cores the machine gives.  It needs the extra ``dask``.
"""

import hashlib
import time
from functools import partial

import numpy as np

from attitude import Ensemble
from attitude.ensemble._partitioned import PartitionedEnsemble

MEMBERS = 200_000
EPOCHS = 160
PARTS = 20
SHAPE = (3.0, 2.0, 1.0)
SUN = (1.0, 0.0, 0.0)
OBSERVER = (0.8, 0.6, 0.0)


def mean_of(ensemble, seed):
    """The mean brightness of the members of a partition at random epochs."""
    t = np.random.default_rng(seed).uniform(0.0, 1e6, (len(ensemble), EPOCHS))
    return ensemble.brightness(t, sun=SUN, observer=OBSERVER, shape=SHAPE).mean()


def hashed(ensemble, seed):
    """Half a second of a processor."""
    digest, start = b"", time.process_time()
    while time.process_time() - start < 0.25:
        digest = hashlib.sha256(digest * 64 + bytes(4096)).digest()
    return digest


def main():
    import dask
    import dask.array as da
    import distributed

    random = np.random.default_rng(1)
    given = {
        "moments": random.uniform(1.0, 1.9, (MEMBERS, 3)),
        "wxyz": random.normal(size=(MEMBERS, 4)),
        "angular_velocity": random.normal(size=(MEMBERS, 3)),
    }
    whole = Ensemble(**given, epoch="2026-01-01")
    mean_of(whole[:1000], 0)
    rows = MEMBERS * EPOCHS
    alone = timed(lambda: mean_of(whole, 0))
    print(f"one call in this process        {alone:7.2f} s  {alone / rows * 1e9:6.1f} ns a row")
    chunk = MEMBERS // PARTS
    lazy = {
        name: da.from_array(each, chunks=(chunk, each.shape[1])) for name, each in given.items()
    }
    for workers in (1, 2):
        with (
            distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            many = PartitionedEnsemble.of_arrays(**lazy, epoch="2026-01-01")
            dask.compute(*many.map(mean_of, range(PARTS)))  # each process loads the machine code
            client.cancel(client.futures)
            again = timed(partial(dask.compute, *many.map(mean_of, range(100, 100 + PARTS))))
            bare = timed(partial(dask.compute, *many.map(hashed, range(PARTS))))
        print(
            f"LocalCluster of {workers} process(es)     {again:7.2f} s  "
            f"{again / rows * 1e9:6.1f} ns a row;  sha256 {bare:6.2f} s"
        )


def timed(call):
    """Wall seconds of one call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
