"""Where ensembles come from: published periods, tables, files and random draws."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from astropy import units
from astropy.table import MaskedColumn, QTable, Table
from astropy.time import Time

from attitude import AttitudeError, Body, Ensemble, FreeRotation, Mode, Spin
from tests.support import states
from tests.support.places import ROOT

EPOCH = "2026-01-01"
SPIN = Spin(EPOCH, (1, 2, 3, 4), (0.01, 0.02, 0.15), "ecliptic")
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)


def _ensemble(**options):
    given = states.sample(1, seed=4)[:12]
    return Ensemble(
        moments=[s.moments for s in given],
        wxyz=[s.wxyz0 for s in given],
        angular_velocity=[s.omega0 for s in given],
        **{"epoch": EPOCH, **options},
    )


def _equal(one, other):
    t = np.array([0.0, 1e3, 1e8])
    assert np.array_equal(one.at(t).wxyz, other.at(t).wxyz)
    assert np.array_equal(one.at(t).angular_velocity, other.at(t).angular_velocity)
    assert [one.epoch_of(k) for k in range(len(one))] == [
        other.epoch_of(k) for k in range(len(one))
    ]
    assert one.frame == other.frame and one.relative == other.relative
    assert (one.names is None) == (other.names is None)
    assert one.names is None or list(one.names) == list(other.names)


def test_published_periods():
    moments = np.array([(0.61, 0.965, 1.0), (0.5, 0.9, 1.0), (0.3, 0.95, 1.0)])
    shared = {"phi0": "30 deg", "pole": ["250 deg", "-75 deg"], "epoch": EPOCH}
    given = {
        "mode": ["SAM", "LAM", "SAM"],
        "convention": ["S", "L", "S"],
        "P_psi": np.array([263.0, 300.0, np.nan]) * units.h,
        "P_phi": np.array([27.38, 100.0, np.nan]) * units.h,
        "psi0": [0.0, 1.0, np.nan],
        "P": np.array([np.nan, np.nan, 5.0]) * units.h,
    }
    names = ["Apophis", "b", "relaxed"]
    ensemble = Ensemble.from_periods(moments=moments, **shared, **given, names=names)
    assert ensemble.relative and ensemble.frame == "ecliptic"
    for k in range(3):
        own = {name: values[k] for name, values in given.items()}
        kept = ("P",) if k == 2 else ("mode", "convention", "P_psi", "P_phi", "psi0")
        body = Body(moments=moments[k], relative=True)
        spin = Spin.from_periods(body, **shared, **{name: own[name] for name in kept})
        single, t = FreeRotation(body, spin), np.array([0.0, 1e4, 1e7])
        assert np.array_equal(ensemble[k].at(t).wxyz, ensemble.at(t).wxyz[k])
        assert np.max(np.abs(single.at(t).wxyz - ensemble.at(t).wxyz[k])) < 1e-9
    assert abs(ensemble["Apophis"].period_psi / (263 * 3600) - 1) < 1e-9
    given["P_psi"][1] = 1.0 * units.h
    with pytest.raises(AttitudeError, match="Member 'b'"):
        Ensemble.from_periods(moments=moments, **shared, **given, names=names)
    kept = Ensemble.from_periods(moments=moments, **shared, **given, names=names, on_error="nan")
    assert kept.is_physical.tolist() == [True, False, True]
    with pytest.raises(AttitudeError, match="either body= or moments="):
        Ensemble.from_periods(**shared, **given)


@pytest.mark.parametrize("ending", ["ecsv", "fits", "parquet"])
def test_files_give_back_the_bits(ending, tmp_path):
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    tensor = Ensemble(
        tensors=[[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]], wxyz=(1, 2, 3, 4),
        angular_velocity=(1, 2, 3), epoch="2027-01-01T00:00:00.1", names=["rotated"],
    )  # fmt: skip
    motions = Ensemble.of([MOTION, MOTION])
    named = _ensemble(names=[f"n{k}" for k in range(12)])
    for k, ensemble in enumerate((_ensemble(frame="ecliptic"), named + tensor, motions)):
        path = tmp_path / f"{k}.{ending}"
        ensemble.write(path)
        _equal(Ensemble.from_table(path), ensemble)
        assert len(list(tmp_path.iterdir())) == k + 1
    with pytest.raises(AttitudeError, match="cannot be written"):
        named.write(tmp_path / "no" / f"x.{ending}")
    for name in ("x.csv", "x"):
        with pytest.raises(AttitudeError, match=r"tables end in .ecsv, .fits, .parquet, .fit\."):
            named.write(tmp_path / name)
    with pytest.raises(AttitudeError, match="cannot be read"):
        Ensemble.from_table(tmp_path / f"none.{ending}")


@pytest.mark.parametrize(
    ("ending", "name", "sentence"),
    [
        ("fits", "Šteins", "FITS has no letter 'Š', only those of ASCII; give .ecsv or .parquet"),
        ("ecsv", "#1", "a name begins with '#', as comments in ECSV do; give .fits"),
    ],
)
def test_names_that_a_file_cannot_hold(ending, name, sentence, tmp_path):
    others = {"ecsv", "fits"} - {ending}
    ensemble = Ensemble.of([MOTION, MOTION], names=[f" {name}\t", "b"])
    with pytest.raises(AttitudeError, match=sentence):
        ensemble.write(tmp_path / f"x.{ending}")
    assert not list(tmp_path.iterdir())
    ensemble.write(tmp_path / f"x.{others.pop()}")
    assert list(Ensemble.from_table(next(tmp_path.iterdir())).names) == [name, "b"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of files are those of Unix")
@pytest.mark.parametrize("ending", ["ecsv", "fits", "parquet"])
def test_a_full_disk_leaves_what_was_there(ending, tmp_path):
    """In a process of its own, whose files may not exceed a size."""
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    code = f"""
        import os, resource
        from attitude import AttitudeError, Ensemble
        from tests.ensemble.test_sources import MOTION
        ensemble, path = Ensemble.of([MOTION] * 500), "{tmp_path}/e.{ending}"
        ensemble[:5].write(path)
        before = open(path, "rb").read()
        hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2, hard))
        try:
            ensemble.write(path)
        except AttitudeError as err:
            print(err)
        assert open(path, "rb").read() == before and os.listdir("{tmp_path}") == ["e.{ending}"]
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True,
        cwd=ROOT, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert "cannot be written" in run.stdout


def test_tables_of_astropy_and_mappings():
    ensemble = _ensemble(names=[f"n{k}" for k in range(12)])
    _equal(Ensemble.from_table(ensemble.table()), ensemble)
    table = QTable(
        {
            "name": ["a", "b"],
            "epoch": Time(["2026-01-01", "2026-01-02"]),
            "wxyz": [(1.0, 0, 0, 0), (0, 1.0, 0, 0)],
            "angular_velocity": [(0, 0, 1.0), (1, 0, 1.0)] * units.deg / units.s,
            "moments": [(1, 2, 2.5), (2, 3, 4)] * units.g * units.m**2,
        }
    )
    found = Ensemble.from_table(table, frame="ecliptic")
    assert np.allclose(found.angular_velocity[0], (0, 0, np.radians(1)))
    assert np.allclose(found.principal_moments[1], (2e-3, 3e-3, 4e-3))
    assert found.epoch_of(1) == Spin("2026-01-02", (1, 0, 0, 0), (0, 0, 1)).epoch
    columns = {
        "epoch": ["2026-01-01", "2026-01-02 TDB"], "w": [1, 0], "x": [0, 1], "y": [0, 0],
        "z": [0, 0], "omega_x": [0, 1], "omega_y": [0, 0], "omega_z": [1, 1],
        "moment_x": [1, 2], "moment_y": [2, 3], "moment_z": [2.5, 4],
    }  # fmt: skip
    mapped = Ensemble.from_table(columns, relative=True)
    assert mapped.relative and len(mapped) == 2
    for missing, sentence in (
        ("w", "it has no wxyz"),
        ("omega_z", "it has no angular_velocity"),
        ("moment_y", "it has neither moments nor tensor"),
        ("epoch", "it has no epochs"),
    ):
        rest = {name: each for name, each in columns.items() if name != missing}
        with pytest.raises(AttitudeError, match=f"the table: {sentence}"):
            Ensemble.from_table(rest)
    with pytest.raises(AttitudeError, match="the table: member 1 of 2: wxyz is"):
        Ensemble.from_table({**columns, "x": [0, 0]})
    texts = Table({**columns, "omega_x": MaskedColumn(["0", "x"], unit="deg / s")})
    with pytest.raises(AttitudeError, match=r"the table: omega_x is .*give real numbers in rad/s"):
        Ensemble.from_table(texts)
    with pytest.raises(AttitudeError, match="the table is 3; give"):
        Ensemble.from_table(3)


@pytest.mark.parametrize("masked", ["name", "epoch", "epoch_seconds", None])
def test_masked_cells_are_missing(masked, tmp_path):
    ensemble = _ensemble(names=[f"n{k}" for k in range(12)])
    table = Table(ensemble.table())
    if masked is None:
        table["name"] = table["name"].astype("S")
        table["epoch_seconds"].unit = None
        table["epoch_seconds"] = table["epoch_seconds"] / 86400.0 * units.day
        found = Ensemble.from_table(table)
        assert list(found.names) == list(ensemble.names)
        assert abs(found.epoch_of(3).since(ensemble.epoch_of(3))) < 1e-6
        return
    if masked == "epoch":
        table.remove_column("epoch_seconds")
        table["epoch"] = [EPOCH] * 12
    table[masked] = MaskedColumn(table[masked], mask=np.arange(12) == 3)
    with pytest.raises(AttitudeError, match=r"row 3 is missing|epoch 3 of 12|epoch_seconds has"):
        Ensemble.from_table(table)


def test_tables_without_rows():
    columns = {"epoch": [], **dict.fromkeys(("wxyz", "angular_velocity", "moments"))}
    columns |= {name: np.zeros((0, 4 if name == "wxyz" else 3)) for name in list(columns)[1:]}
    assert len(Ensemble.from_table(columns)) == 0


@pytest.mark.parametrize("ending", ["ecsv", "fits"])
@pytest.mark.parametrize("tensors", [False, True])
def test_no_members_are_written_and_read(ending, tensors, tmp_path):
    one = {"wxyz": (1, 0, 0, 0), "angular_velocity": (1, 2, 3), "epoch": EPOCH}
    given = {"tensors": [np.diag([1.0, 2.0, 2.5])]} if tensors else {"moments": [(1, 2, 2.5)]}
    none = Ensemble(**one, **given)[:0]
    none.write(tmp_path / f"none.{ending}")
    again = Ensemble.from_table(tmp_path / f"none.{ending}")
    assert len(none.table()) == len(again) == 0
    assert again.at([0.0, 1.0]).wxyz.shape == (0, 2, 4)


def test_csv(tmp_path):
    path = tmp_path / "states.csv"
    path.write_text(
        "name,epoch,w,x,y,z,omega_x,omega_y,omega_z,moment_x,moment_y,moment_z\n"
        "a,2026-01-01T00:00:00,1,0,0,0,0,0.1,0.1,1,2,2.5\n"
        "b,2026-01-02T00:00:00,1,0,0,0,0,0.1,0.1,1,2,2.5\n"
    )
    found = Ensemble.from_table(path)
    assert found.names.tolist() == ["a", "b"] and found.epoch is None
    path.write_text("w,x,y,z\n1,0,0\n")
    with pytest.raises(AttitudeError, match=r"states\.csv"):
        Ensemble.from_table(path)


def test_pandas_and_arrow():
    pandas, pyarrow = pytest.importorskip("pandas"), pytest.importorskip("pyarrow")
    ensemble = _ensemble(names=[f"n{k}" for k in range(12)])
    table = ensemble.table()
    columns = {name: np.array(table[name]) for name in table.colnames}
    _equal(Ensemble.from_table(pandas.DataFrame(columns)), ensemble)
    _equal(Ensemble.from_table(pyarrow.table(columns)), ensemble)
    dated = pandas.DataFrame(columns).drop(columns=["epoch_seconds", "epoch_low"])
    dated["epoch"] = pandas.to_datetime(["2026-01-01"] * 12)
    assert Ensemble.from_table(dated).epoch_of(3) == SPIN.epoch


def test_draws_have_the_covariance():
    sigma = {"attitude": 0.01, "angular_velocity": 1e-3, "moments": 0.1}
    errors = SPIN.with_covariance(sigma)
    motion = FreeRotation(MOTION.body, errors)
    drawn = Ensemble.sample(motion, 4000, seed=1)
    same = Ensemble.sample(MOTION, 4000, np.random.default_rng(1), covariance=sigma)
    assert np.array_equal(drawn.wxyz, same.wxyz) and np.array_equal(drawn.energy, same.energy)
    # 4000 draws: standard deviations to 1.1 % (one sigma), means to 1.6 % of them
    assert np.all(np.abs(drawn.angular_velocity.std(axis=0) / 1e-3 - 1) < 0.06)
    assert np.all(np.abs(drawn.angular_velocity.mean(axis=0) - SPIN.angular_velocity) < 7e-5)
    assert np.all(np.abs(drawn.principal_moments.std(axis=0) / 0.1 - 1) < 0.06)
    singles = motion.sample(3, seed=1)
    for k, single in enumerate(singles):
        assert np.allclose(drawn[k].at(50.0).wxyz, single.at(50.0).wxyz, rtol=0, atol=1e-12)
    exact = Ensemble.sample(MOTION, 5, covariance={"attitude": "1 deg"})
    assert exact[2].body is MOTION.body


def test_draws_stay_physical():
    flat = FreeRotation(Body(moments=(1, 2, 2.9)), SPIN)
    drawn = Ensemble.sample(flat, 500, covariance={"moments": 0.2})
    moments = drawn.principal_moments
    assert len(drawn) == 500 and np.all(moments > 0)
    assert np.all(2 * moments.max(axis=1) <= moments.sum(axis=1) * (1 + 1e-14))
    with pytest.raises(AttitudeError, match="draws gave 0 motions"):
        Ensemble.sample(
            flat, 10, distributions={"moments": lambda generator, n: np.full((n, 3), (1, 1, 5.0))}
        )
    rotated = FreeRotation(Body(tensor=[[2, 0.1, 0], [0.1, 2.5, 0.5], [0, 0.5, 2.5]]), SPIN)
    turned = Ensemble.sample(rotated, 5, seed=2, covariance={"moments": 0.01, "attitude": 0.1})
    for k, single in enumerate(
        FreeRotation(rotated.body, SPIN.with_covariance({"moments": 0.01, "attitude": 0.1})).sample(
            5, 2
        )
    ):
        assert np.allclose(turned[k].body.tensor, single.body.tensor, rtol=1e-12)
        assert np.allclose(turned.at(9.0).wxyz[k], single.at(9.0).wxyz, rtol=0, atol=1e-11)


def test_distributions():
    from scipy import stats

    drawn = Ensemble.sample(
        MOTION, 50, seed=3,
        distributions={
            "angular_velocity": stats.uniform(0.01, 0.01),
            "wxyz": lambda generator, n: generator.normal(size=(n, 4)),
            "moments": stats.multivariate_normal((10, 20, 26), np.eye(3) * 0.01),
        },
    )  # fmt: skip
    assert np.all((drawn.angular_velocity >= 0.01) & (drawn.angular_velocity <= 0.02))
    assert drawn.principal_moments.std() > 0.05 and len(drawn) == 50
    assert set(drawn.mode.tolist()) <= {Mode.LONG_AXIS, Mode.SHORT_AXIS}
    assert len(Ensemble.sample(MOTION, 0, covariance={"attitude": 0.1})) == 0
    for options, sentence in (
        ({}, "the spin has no covariance"),
        ({"distributions": {}}, "give some of attitude"),
        ({"distributions": {"rates": 1}}, "rates"),
        ({"distributions": {"wxyz": lambda g, n: np.zeros((n, 4))}}, "holds a zero quaternion"),
        ({"distributions": {"moments": lambda g, n: np.ones(3)}}, "the draw of moments has shape"),
        ({"covariance": {"attitude": 1}, "distributions": {"moments": 1}}, "both given"),
        ({"count": -5, "covariance": {"attitude": 1}}, "count is -5"),
    ):  # fmt: skip
        with pytest.raises(AttitudeError, match=sentence):
            Ensemble.sample(MOTION, **{"count": 5, **options})


@pytest.mark.parametrize("seed", [-1, "a", 1.5])
def test_seeds_that_are_none(seed):
    sentence = "seed is .*; give a whole number, at least 0, or a numpy Generator"
    with pytest.raises(AttitudeError, match=sentence):
        Ensemble.sample(MOTION, 2, seed, covariance={"angular_velocity": 1e-3})
    spin = SPIN.with_covariance({"angular_velocity": 1e-3})
    with pytest.raises(AttitudeError, match=sentence):
        FreeRotation(MOTION.body, spin).sample(2, seed)
