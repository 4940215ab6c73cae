"""QTable, ECSV, FITS, CSV and parquet: the same doubles come back."""

import os

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs, paths
from attitude.errors import AttitudeWarning
from attitude.formats import acm, cic, quat, stk, tables
from attitude.motions._table import AttitudeTable

SPIN = Spin(epoch="2016-12-31T23:59:50.25", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
HISTORY = MOTION.at(np.arange(60) / 3.0)


def late(read, history):
    hi, lo = epochs.seconds_since(history.epoch, read.epoch)
    return np.max(np.abs((read.seconds - history.seconds + hi) + (read.low + lo)))


def skip_without_pyarrow(ending):
    if ending == "parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")


@pytest.mark.parametrize("ending", ["ecsv", "fits", "csv", "parquet"])
@pytest.mark.parametrize("rates", [True, False])
def test_there_and_back(tmp_path, ending, rates):
    skip_without_pyarrow(ending)
    path = tmp_path / f"a.{ending}"
    tables.write(path, HISTORY, rates=rates)
    found = tables.read(path)
    assert np.array_equal(found.wxyz, HISTORY.wxyz)
    assert late(found, HISTORY) < 1e-11  # s: a double of days, in UTC 12 decimals
    if not rates:
        assert found.angular_velocity is None
    else:
        assert np.array_equal(found.angular_velocity, HISTORY.angular_velocity)
    assert os.listdir(tmp_path) == [f"a.{ending}"]


@pytest.mark.parametrize("ending", ["ecsv", "fits", "csv", "parquet"])
@pytest.mark.parametrize("rates", [True, False])
def test_standard_deviations_are_written(tmp_path, monkeypatch, ending, rates):
    from attitude.formats import _sampling

    skip_without_pyarrow(ending)
    monkeypatch.setattr(_sampling, "PIECE", 25)
    spin = SPIN.with_covariance({"attitude": "1 deg", "angular_velocity": 1e-4, "moments": 0.1})
    history = FreeRotation(MOTION.body, spin).at(HISTORY.seconds)
    path = tmp_path / f"a.{ending}"
    tables.write(path, history, rates=rates, sigma=True)
    assert np.array_equal(tables.read(path).wxyz, HISTORY.wxyz)
    whole = ending in ("ecsv", "fits")
    if whole:
        from astropy.table import QTable

        found = QTable.read(path, **({"astropy_native": True} if ending == "fits" else {}))
        assert found["sigma"].unit == "rad"
        sigma = found["sigma"].value
    elif ending == "csv":
        found = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding=None)
        sigma = np.stack([found[f"sigma_{axis}"] for axis in "xyz"], axis=-1)
    else:
        found = tables.read_parquet(path)
        sigma = np.stack([found[f"sigma_{axis}"] for axis in "xyz"], axis=-1)
    assert np.array_equal(sigma, history.sigma)
    expected = history.sigma_angular_velocity if rates else None
    names = found.colnames if ending != "csv" else found.dtype.names
    if whole and rates:
        assert np.array_equal(found["sigma_angular_velocity"].to_value("rad / s"), expected)
    elif rates:
        assert np.array_equal(found["sigma_omega_y"], expected[:, 1])
    else:
        assert not any("omega" in name or "velocity" in name for name in names)


def test_no_standard_deviations_without_a_covariance(tmp_path):
    for ending in ("ecsv", "csv"):
        with pytest.raises(AttitudeError, match="the spin has no covariance"):
            tables.write(tmp_path / f"a.{ending}", HISTORY, sigma=True)
        with pytest.raises(AttitudeError, match="AttitudeTable has no derivatives"):
            tables.write(tmp_path / f"a.{ending}", AttitudeTable.from_history(HISTORY), sigma=True)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("ending", ["ecsv", "fits", "parquet"])
def test_segments_and_interpolation_are_kept(tmp_path, ending):
    skip_without_pyarrow(ending)
    parts = [HISTORY[:30], HISTORY[40:]]
    given = AttitudeTable.joined(
        [AttitudeTable.from_history(part, method="lagrange", degree=5) for part in parts]
    )
    path = tmp_path / f"a.{ending}"
    tables.write(path, given)
    found = tables.read(path)
    assert len(found.segments) == 2
    assert (found.method, found.degree) == ("lagrange", 5)
    assert np.array_equal(found.wxyz, given.wxyz)
    with pytest.raises(AttitudeError, match="CSV holds one"):
        tables.write(tmp_path / "x.csv", given)


def test_a_motion_is_written_piece_by_piece(tmp_path, monkeypatch):
    from attitude.formats import _sampling

    for ending in ("csv", "parquet"):
        skip_without_pyarrow(ending)
        monkeypatch.setattr(_sampling, "PIECE", 7)
        path = tmp_path / f"a.{ending}"
        tables.write(path, MOTION, t=np.arange(60) / 3.0)
        assert np.array_equal(tables.read(path).wxyz, HISTORY.wxyz)


def test_a_qtable_there_and_back_and_other_spellings():
    table = tables.qtable(HISTORY)
    assert np.array_equal(tables.from_table(table).wxyz, HISTORY.wxyz)
    assert np.array_equal(tables.from_table(HISTORY.table()).wxyz, HISTORY.wxyz)
    from astropy.table import Table

    time = HISTORY.time
    other = Table({"jd1": time.jd1, "jd2": time.jd2})
    for k, name in enumerate("wxyz"):
        other[name] = HISTORY.wxyz[:, k]
    assert late(tables.from_table(other), HISTORY) < 1e-11
    degrees = HISTORY.table()
    degrees["angular_velocity"] = degrees["angular_velocity"].to("deg/s")
    off = tables.from_table(degrees).angular_velocity - HISTORY.angular_velocity
    assert np.max(np.abs(off)) < 3e-17
    for lacking in ("time", "wxyz"):
        broken = HISTORY.table()
        del broken[lacking]
        with pytest.raises(AttitudeError, match="it has no"):
            tables.from_table(broken)
    from astropy import units

    unknown = units.Unit("</data> / s", parse_strict="silent")  # out of a mutated ECSV
    for unit in (units.m, unknown):
        broken = HISTORY.table()
        rates = np.array(HISTORY.angular_velocity)
        broken["angular_velocity"] = units.Quantity(rates, unit, subok=True)
        with pytest.raises(AttitudeError, match=r"the table: .*angular_velocity"):
            tables.from_table(broken)
        broken = HISTORY.table(rates=False)
        for k, name in enumerate(("omega_x", "omega_y", "omega_z")):
            broken[name] = units.Quantity(rates[:, k], unit)
        with pytest.raises(AttitudeError, match=r"the table: .*angular_velocity"):
            tables.from_table(broken)
    broken = HISTORY.table()
    broken["wxyz"] = broken["wxyz"] * 2.0
    with pytest.raises(AttitudeError, match="off 1 by 1"):
        tables.from_table(broken)


@pytest.mark.parametrize("ending", ["ecsv", "fits", "csv", "parquet"])
def test_broken_files(tmp_path, ending):
    skip_without_pyarrow(ending)
    path = tmp_path / f"a.{ending}"
    with pytest.raises(AttitudeError, match="cannot be read"):
        tables.read(path)
    tables.write(path, HISTORY)
    whole = path.read_bytes()
    for junk in (b"", whole[: len(whole) // 2], bytes(range(256)) * 50, b"\x00" * 9000):
        path.write_bytes(junk)
        if ending == "csv" and junk == whole[: len(whole) // 2]:
            continue
        with pytest.raises(AttitudeError, match="a." + ending):
            tables.read(path)


@pytest.mark.parametrize("ending", ["ecsv", "fits", "csv", "parquet"])
def test_loose_quaternions_are_accepted_when_told(tmp_path, ending):
    skip_without_pyarrow(ending)
    path = tmp_path / f"a.{ending}"

    class Loose:
        """Attitudes that are 1 percent too long."""

        epoch, spin = SPIN.epoch, SPIN

        def at(self, t, low=None):
            history = MOTION.at(t, low)
            history.__dict__["wxyz"] = history.wxyz * 1.01
            return history

    tables.write(path, Loose(), t=np.arange(9.0))
    with pytest.raises(AttitudeError, match=r"a\..*off 1 by 0\.01"):
        tables.read(path)
    found = tables.read(path, tolerance=0.02)
    assert np.max(np.abs(found.wxyz - MOTION.at(np.arange(9.0)).wxyz)) < 3e-16
    with pytest.raises(AttitudeError, match="tolerance is"):
        tables.read(path, tolerance=-1)


def test_broken_csv_is_told_by_line(tmp_path):
    path = tmp_path / "a.csv"
    tables.write(path, HISTORY[:4])
    whole = path.read_text()
    for old, new, sentence in [
        ("utc,", "date,", "line 1: the first line names date"),
        ("w,x,y,z", "w,x,y,y", "line 1: the first line names"),
        ("2016-12-31T23:59:50", "2016-02-31T23:59:50", "line 2: the epoch"),
        ("0.182574", "O.182574", "line 2: w is 'O.182574"),
        ("0.182574", "0.282574", "line 2: the length of the quaternion"),
        ("0.182574", "1,0.182574", "line 2: it has 10 columns"),
    ]:
        assert old in whole
        path.write_text(whole.replace(old, new, 1))
        with pytest.raises(AttitudeError, match=sentence):
            tables.read(path)
    with pytest.raises(AttitudeError, match="tables end in"):
        tables.write(tmp_path / "a.xyz", HISTORY)


def test_what_the_command_line_writes_is_read(tmp_path):
    """CSV and ECSV of ``attitude propagate`` have the same columns."""
    from attitude import cli
    from attitude.formats import spin_file

    spin_file.write(tmp_path / "a.toml", MOTION)
    for ending in ("csv", "ecsv"):
        out = tmp_path / f"a.{ending}"
        asked = ["--stop", "10 s", "--step", "2 s", "--rates", "--output", str(out)]
        assert cli.main(["propagate", str(tmp_path / "a.toml"), *asked]) == 0
        found = tables.read(out)
        assert len(found) == 6 and found.angular_velocity is not None


@pytest.mark.parametrize("frame", ["ecliptic", "itrf", "lvlh"])
@pytest.mark.parametrize("ending", ["ecsv", "fits"])
@pytest.mark.parametrize("rates", [True, False])
def test_axes_that_the_meta_data_name(tmp_path, frame, ending, rates):
    orbit = paths.kepler(
        **{"epoch": "2016-12-31", "semi_major_axis": "7000 km", "eccentricity": 0.01},
        **{"inclination": "51 deg", "node": "20 deg", "pericenter_argument": "10 deg"},
        **{"mean_anomaly": 0.3, "center": "earth", "frame": "icrf"},
    )
    orbit = orbit if frame == "lvlh" else None
    path = tmp_path / f"a.{ending}"
    tables.write_columns(path, HISTORY.in_frame(frame, orbit=orbit).table(rates=rates))
    table = tables.read(path, orbit=orbit)
    assert np.max(np.abs(np.abs(np.sum(table.wxyz * HISTORY.wxyz, axis=1)) - 1.0)) < 1e-14
    if rates:
        assert np.allclose(table.angular_velocity, HISTORY.angular_velocity, rtol=0, atol=1e-12)
    if orbit is not None:
        with pytest.raises(AttitudeError, match="LVLH, axes of the orbit; give orbit="):
            tables.read(path)


def test_unknown_axes_in_the_meta_data():
    table = HISTORY.table()
    table.meta["frame"] = "FOO"
    with pytest.raises(AttitudeError, match="the table: frame is 'FOO'; known axes are"):
        tables.from_table(table)


@pytest.mark.parametrize("ending", ["ecsv", "fits", "parquet"])
def test_usable_spans_are_kept(tmp_path, ending):
    skip_without_pyarrow(ending)
    spans = [[MOTION.epoch.after(end) for end in ends] for ends in ((0.1, 5.2), (12.0, 18.3))]
    parts = [
        AttitudeTable(MOTION.epoch, part.seconds, part.wxyz, usable=span)
        for part, span in zip((HISTORY[:30], HISTORY[30:]), spans, strict=True)
    ]
    tables.write(tmp_path / f"a.{ending}", AttitudeTable.joined(parts))
    read = tables.read(tmp_path / f"a.{ending}")
    assert [list(part.span) for part in read.segments] == spans


@pytest.mark.parametrize(
    "module, name", [(tables, "a.csv"), (quat, "a.quat"), (stk, "a.a"), (cic, "a.cic"), (acm, "a")]
)
def test_usable_spans_that_are_lost_are_said(tmp_path, module, name):
    span = [MOTION.epoch.after(end) for end in (1.0, 5.0)]
    table = AttitudeTable(MOTION.epoch, HISTORY.seconds, HISTORY.wxyz, usable=span)
    with pytest.warns(AttitudeWarning, match="has no place for the usable span"):
        module.write(tmp_path / name, table)


@pytest.mark.parametrize("ending", ["ecsv", "fits", "parquet"])
def test_segments_of_different_interpolation(tmp_path, ending):
    skip_without_pyarrow(ending)
    late_history = MOTION.at(200.0 + HISTORY.seconds)
    one = AttitudeTable.from_history(HISTORY, method="slerp")
    two = AttitudeTable.from_history(late_history, method="hermite", degree=5)
    path = tmp_path / f"a.{ending}"
    tables.write(path, AttitudeTable.joined([one, two]))
    said = [(part.method, part.degree) for part in tables.read(path).segments]
    assert said == [("slerp", 1), ("hermite", 5)]
    plain = AttitudeTable.from_history(HISTORY, rates=False, method="slerp")
    with pytest.raises(AttitudeError, match="some segments have angular velocities and others"):
        tables.write(path, AttitudeTable.joined([plain, two]))
    tables.write(path, AttitudeTable.joined([plain, two]), rates=False)
    assert [part.method for part in tables.read(path).segments] == ["slerp", "lagrange"]
