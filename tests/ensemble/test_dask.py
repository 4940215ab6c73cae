"""Ensembles in partitions of dask: the bits of one ensemble, also when a process is killed."""

import os
import signal
import sys
import time
from datetime import date
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import pytest
from astropy.time import Time

from attitude import AttitudeError, Ensemble
from attitude.ensemble._partitioned import PartitionedEnsemble

needs_dask = pytest.mark.skipif(
    find_spec("dask") is None or find_spec("distributed") is None or find_spec("pandas") is None,
    reason="dask and distributed are not installed (the extra dask)",
)
T = np.linspace(0.0, 1e4, 30)


def arrays(count=90):
    random = np.random.default_rng(6)
    return {
        "moments": random.uniform(1.0, 1.9, (count, 3)),
        "wxyz": random.normal(size=(count, 4)),
        "angular_velocity": random.normal(size=(count, 3)),
    }


def whole(columns, **more):
    return Ensemble(**columns, epoch="2026-01-01", **more)


def lazy(columns, chunk=40):
    import dask.array as da

    return {
        name: da.from_array(each, chunks=(chunk, each.shape[1])) for name, each in columns.items()
    }


@needs_dask
def test_arrays_in_chunks_have_the_bits_of_one_ensemble():
    import dask.array as da

    given = arrays()
    many = PartitionedEnsemble.of_arrays(**lazy(given), epoch="2026-01-01")
    right = whole(given).at(T, angular_velocity=True)
    attitudes, rates = many.at(T, angular_velocity=True)
    assert attitudes.chunks[0] == (40, 40, 10) and len(many) == 90
    np.testing.assert_array_equal(attitudes.compute(), right.wxyz)
    np.testing.assert_array_equal(rates.compute(), right.angular_velocity)
    own = np.random.default_rng(1).uniform(0.0, 1e3, (90, 4))
    found = many.at(da.from_array(own, chunks=(30, 2)))  # chunks of another size
    np.testing.assert_array_equal(found.compute(), whole(given).at(own).wxyz)
    axes = np.random.default_rng(2).uniform(1.0, 2.0, (90, 3))
    bright = many.brightness(T, (1.0, 0, 0), (0.6, 0.8, 0), shape=da.from_array(axes, chunks=90))
    right = whole(given).brightness(T, sun=(1.0, 0, 0), observer=(0.6, 0.8, 0), shape=axes)
    np.testing.assert_array_equal(bright.compute(), right)


@needs_dask
def test_dataframes_ragged_rows_and_files(tmp_path):
    import dask
    import dask.dataframe as dd
    import pandas

    given = arrays()
    ensemble = whole(given, names=[f"body {k}" for k in range(90)])
    table = ensemble.table().to_pandas()
    many = PartitionedEnsemble.of_dataframe(dd.from_pandas(table, npartitions=4))
    np.testing.assert_array_equal(many.at(T).compute(), ensemble.at(T).wxyz)
    unknown = PartitionedEnsemble.of_dataframe(dd.from_pandas(table, npartitions=4), count=False)
    np.testing.assert_array_equal(unknown.at(T).compute(), ensemble.at(T).wxyz)
    random = np.random.default_rng(3)
    member = np.sort(random.integers(0, 90, 400))
    seconds = random.uniform(0.0, 1e4, 400)
    names = np.array(ensemble.names)[member]
    counts = np.cumsum([0, *many.lengths])
    parts = [
        pandas.DataFrame({"member": names, "seconds": seconds})[(member >= low) & (member < high)]
        for low, high in pairwise(counts)
    ]
    rows = dd.from_delayed([dask.delayed(each) for each in parts], meta=parts[0].iloc[:0])
    found = many.rows(rows, angular_velocity=True).compute()
    right = ensemble.at(seconds, member=member, angular_velocity=True)
    np.testing.assert_array_equal(found[["w", "x", "y", "z"]].to_numpy(), right.wxyz)
    np.testing.assert_array_equal(
        found[["omega_x", "omega_y", "omega_z"]].to_numpy(), right.angular_velocity
    )
    files = dask.compute(*many.write(tmp_path / "out", T))
    again = pandas.concat([pandas.read_parquet(each) for each in files])
    np.testing.assert_array_equal(
        again[["w", "x", "y", "z"]].to_numpy().reshape(90, 30, 4), ensemble.at(T).wxyz
    )
    assert again["name"].iloc[0] == "body 0" and sorted(os.listdir(tmp_path / "out")) == [
        f"part-{k:05d}.parquet" for k in range(4)
    ]


def _slowly(ensemble, k):
    """Attitudes of a partition, half a second later."""
    time.sleep(0.5)
    return ensemble.at(T).wxyz


@needs_dask
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_of_processes_of_which_one_is_killed(tmp_path):
    import distributed

    given = arrays()
    right = whole(given).at(T).wxyz
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
            local_directory=str(tmp_path),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):  # fmt: skip
        many = PartitionedEnsemble.of_arrays(**lazy(given, 10), epoch="2026-01-01")
        np.testing.assert_array_equal(many.at(T).compute(), right)
        futures = client.compute(many.map(_slowly, range(9)))
        files = client.compute(many.write(tmp_path / "out", T))
        time.sleep(0.7)
        pids = client.run(os.getpid)
        os.kill(next(iter(pids.values())), signal.SIGKILL)
        np.testing.assert_array_equal(np.concatenate(client.gather(futures)), right)
        written = client.gather(files)
    import pandas

    found = pandas.concat([pandas.read_parquet(each) for each in written])
    np.testing.assert_array_equal(
        found[["w", "x", "y", "z"]].to_numpy().reshape(right.shape), right
    )
    assert sorted(os.listdir(tmp_path / "out")) == [f"part-{k:05d}.parquet" for k in range(9)]


@needs_dask
def test_what_is_refused():
    import dask.array as da

    given = lazy(arrays())
    with pytest.raises(AttitudeError, match=r"wxyz is .*give a dask array \(N, 4\)"):
        PartitionedEnsemble.of_arrays(**{**given, "wxyz": np.ones((90, 4))}, epoch="2026-01-01")
    with pytest.raises(AttitudeError, match="moments has 3 rows, but there are 90 members"):
        PartitionedEnsemble.of_arrays(**{**given, "moments": da.ones((3, 3))}, epoch="2026-01-01")
    with pytest.raises(AttitudeError, match="give a dask dataframe"):
        PartitionedEnsemble.of_dataframe([1, 2])
    many = PartitionedEnsemble.of_arrays(**given, epoch="2026-01-01")
    for one in (
        1.0,
        np.int64(3),
        np.array(3.0),
        Time("2026-01-02"),
        date(2026, 1, 2),
        "2026-01-02",
    ):
        with pytest.raises(AttitudeError, match="t is a single epoch"):
            many.at(one)
    bad = {**given, "angular_velocity": given["angular_velocity"] * np.nan}
    with pytest.raises(AttitudeError, match="angular velocity is"):
        PartitionedEnsemble.of_arrays(**bad, epoch="2026-01-01").at(T).compute()


def test_without_dask_there_is_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "dask", None)  # an import of it fails
    with pytest.raises(AttitudeError, match="dask is not installed"):
        PartitionedEnsemble.of_arrays(wxyz=None)
