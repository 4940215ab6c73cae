"""Files written to a tolerance: the reader of the format, and SPICE-like tools, stay within it."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, epochs, paths
from attitude.arcs import Arcs, Impulse
from attitude.cli import main
from attitude.formats import _sampling, aem, detect, spin_file, stk, tables
from attitude.frames import quaternion
from attitude.motions._table import AttitudeTable
from tests.support import orekit

BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.02))
MOTION = FreeRotation(BODY, SPIN)
ARCS = Arcs(BODY, SPIN, [Impulse(20.7, (0.1, 0.3, -0.2)), Impulse(53.125, (0.0, -0.4, 0.1))])
SPAN = 100.0


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def error(motion, table, joints=()):
    """Between the records and beside the joints; beside means beyond the rounding of UTC texts."""
    t = np.random.default_rng(5).uniform(0.0, SPAN, 3000)
    near = [joint + s for joint in joints for s in (-1e-3, -1e-6, 1e-6, 1e-3, 0.1, -0.1)]
    t = np.sort(np.concatenate([t, near]))
    dates = [motion.epoch.after(float(each)) for each in t]
    return apart(table.at(dates).wxyz, motion.at(t).wxyz)


def write(path, motion, **how):
    return detect.write(path, motion, start=0.0, stop=SPAN, **how)


@pytest.mark.parametrize("motion", [MOTION, ARCS], ids=["free", "arcs"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9, 1e-12])
@pytest.mark.parametrize("name", ["a.aem", "a.ecsv", "a.parquet"])
def test_hermite(tmp_path, name, tolerance, motion):
    if name.endswith("parquet"):
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    path = tmp_path / name
    made = write(path, motion, tolerance=tolerance)
    table = detect.read(path)
    joints = motion.joints
    assert made.error <= tolerance and len(table.segments) == made.segments == 1 + len(joints)
    assert made.records == len(table)
    # Dates, of 5e-13 and 6e-12 s, at 0.3 rad/s.
    assert error(motion, table, joints) < tolerance + 3e-12
    # The step is no smaller than needed: four times as long, the error is larger than allowed.
    if motion is MOTION and tolerance > 1e-11:
        t = np.arange(0.0, SPAN, 4.0 * made.step)
        coarse = AttitudeTable.from_history(MOTION.at(t))
        assert (
            apart(
                coarse.at(t[:-1] + 2.0 * made.step).wxyz, MOTION.at(t[:-1] + 2.0 * made.step).wxyz
            )
            > tolerance
        )


@pytest.mark.parametrize(
    ("how", "tolerance"),
    [
        ({"kind": "QUATERNION"}, 1e-9),
        ({"kind": "QUATERNION", "degree": 3}, 1e-6),
        ({"kind": "QUATERNION", "method": "slerp"}, 1e-4),
        ({"for_": "gmat"}, 1e-4),
        ({"kind": "EULER_ANGLE/DERIVATIVE", "sequence": "ZYX"}, 1e-9),
        ({"version": "1.0"}, 1e-10),
        ({"xml": True, "kind": "SPIN/NUTATION_MOM"}, 1e-8),
        ({"frame": "ITRF"}, 1e-9),
    ],
)
@pytest.mark.parametrize("motion", [MOTION, ARCS], ids=["free", "arcs"])
def test_the_interpolation_that_an_aem_states(tmp_path, how, tolerance, motion):
    made = aem.write(tmp_path / "a.aem", motion, start=0.0, stop=SPAN, tolerance=tolerance, **how)
    table = aem.read(tmp_path / "a.aem")
    assert made.error <= tolerance
    assert error(motion, table, motion.joints) < tolerance + 3e-12
    if how.get("for_") == "gmat" or how.get("method") == "slerp":
        assert "INTERPOLATION_METHOD = LINEAR" in (tmp_path / "a.aem").read_text()


@pytest.mark.parametrize("order", [1, 5, 7])
def test_stk(tmp_path, order):
    tolerance = 1e-4 if order == 1 else 1e-9
    made = stk.write(tmp_path / "a.a", MOTION, start=0, stop=SPAN, tolerance=tolerance, order=order)
    table = stk.read(tmp_path / "a.a")
    assert made.error <= tolerance and table.degree == order
    assert error(MOTION, table) < tolerance + 3e-12
    with pytest.raises(
        AttitudeError, match=r"jumps, or .* 20\.7 s after its epoch, and an STK file"
    ):
        stk.write(tmp_path / "b.a", ARCS, start=0, stop=SPAN, tolerance=1e-6)
    with pytest.raises(AttitudeError, match="and CSV holds one segment"):
        tables.write(tmp_path / "b.csv", ARCS, start=0, stop=SPAN, tolerance=1e-6)
    assert [each.name for each in tmp_path.iterdir()] == ["a.a"]
    # A stretch between two jumps.
    stk.write(tmp_path / "b.a", ARCS, start=20.7, stop=53.0, tolerance=1e-8)
    table = stk.read(tmp_path / "b.a")
    t = np.linspace(20.8, 52.9, 300)
    assert apart(table.at([ARCS.epoch.after(x) for x in t]).wxyz, ARCS.at(t).wxyz) < 1.1e-8


def test_stk_files_for_each_stretch(tmp_path, capsys):
    made = stk.write(tmp_path / "a.a", ARCS, start=0, stop=SPAN, tolerance=1e-8, split=True)
    (tmp_path / "z-2.a").mkdir()
    with pytest.raises(AttitudeError, match="is a folder"):
        stk.write(tmp_path / "z.a", ARCS, t=np.arange(0.0, SPAN + 1.0), split=True)
    assert not (tmp_path / "z-1.a").exists()
    (tmp_path / "z-2.a").rmdir()
    stk.write(tmp_path / "b.a", ARCS, t=np.arange(0.0, SPAN + 1.0), split=True)
    names = [f"{x}-{k}.a" for x in "ab" for k in (1, 2, 3)]
    assert sorted(each.name for each in tmp_path.iterdir()) == names
    ends = [0.0, *ARCS.joints, SPAN]
    assert made.segments == 3 and made.error <= 1e-8
    for k in range(3):
        table = stk.read(tmp_path / f"a-{k + 1}.a")
        t = np.linspace(ends[k] + 1e-6, ends[k + 1] - 1e-6, 200)
        dates = [ARCS.epoch.after(float(x)) for x in t]
        assert apart(table.at(dates).wxyz, ARCS.at(t).wxyz) < 1.1e-8
        # The rates at the end are those before the jump.
        last = ARCS.angular_velocity_at(ends[k + 1] - 1e-9)
        assert table.angular_velocity[-1] == pytest.approx(last, abs=1e-8)
    # Without a jump there is one file, of the given name.
    stk.write(tmp_path / "c.a", MOTION, start=0, stop=5.0, tolerance=1e-8, split=True)
    assert (tmp_path / "c.a").exists()
    aem.write(tmp_path / "d.aem", ARCS, t=np.arange(0.0, SPAN + 1.0))
    assert main(["convert", str(tmp_path / "d.aem"), str(tmp_path / "e.a")]) != 0
    assert main(["convert", str(tmp_path / "d.aem"), str(tmp_path / "e.a"), "--split"]) == 0
    assert len(list(tmp_path.glob("e-*.a"))) == 3


def test_csv(tmp_path):
    made = write(tmp_path / "a.csv", MOTION, tolerance=1e-9)
    assert made.segments == 1
    assert error(MOTION, detect.read(tmp_path / "a.csv")) < 1.1e-9


def test_a_table_with_a_gap(tmp_path):
    parts = [MOTION.at(np.arange(0.0, 41.0)), MOTION.at(np.arange(60.0, 101.0))]
    given = AttitudeTable.joined([AttitudeTable.from_history(part) for part in parts])
    made = aem.write(tmp_path / "a.aem", given, tolerance=1e-10)
    found = aem.read(tmp_path / "a.aem")
    assert made.segments == 2 and len(found.segments) == 2
    with pytest.raises(AttitudeError, match="no attitude at"):
        found.at(given.epoch.after(50.0))
    t = np.linspace(60.5, 99.5, 200)
    dates = [given.epoch.after(x) for x in t]
    assert apart(found.at(dates).wxyz, given.at(t).wxyz) < 1.1e-10
    # Part of it, within one segment.
    made = aem.write(tmp_path / "b.aem", given, start=5.0, stop=30.0, tolerance=1e-8)
    assert made.segments == 1
    assert aem.read(tmp_path / "b.aem").span[1].since(given.epoch) == pytest.approx(30.0, abs=1e-9)


def test_orekit_interpolates_within_the_tolerance(tmp_path):
    """It interpolates by another polynomial, of modified Rodrigues vectors, with eight records."""
    path = tmp_path / "a.aem"
    how = {"for_": "orekit", "frame": "EME2000", "object_id": "2026-001A", "object_name": "SAT"}
    aem.write(path, MOTION, start=0.0, stop=60.0, tolerance=1e-7, **how)
    from attitude import frames

    history = MOTION.at(np.linspace(3.0, 57.0, 100))
    theirs = orekit.interpolated(path, orekit.tt_seconds(history))
    theirs = quaternion.multiply(frames.wxyz_to_icrf("eme2000"), theirs)
    assert apart(theirs, history.wxyz) < 1e-7


BAD = [
    ({"tolerance": 0.0}, "tolerance is 0.0; give a number of rad"),
    ({"tolerance": True}, "tolerance is True; give a number of rad"),
    ({"tolerance": 1e-9, "t": [0.0, 1.0]}, "t and tolerance are given"),
    ({"t": [0.0, 1.0], "stop": 1.0}, "start or stop is given without tolerance="),
    ({"tolerance": 1e-9, "stop": 1.0}, "start is not given"),
    (
        {"tolerance": 1e-9, "start": 0.0, "stop": [1.0, 2.0]},
        "stop holds 2 epochs; give one finite epoch",
    ),
    ({"tolerance": 1e-9, "start": 1.0, "stop": 1.0}, "stop is not after start"),
]


@pytest.mark.parametrize(("how", "sentence"), BAD)
def test_what_is_refused(tmp_path, how, sentence):
    for name in ("a.aem", "a.a", "a.ecsv"):
        with pytest.raises(AttitudeError, match=sentence):
            detect.write(tmp_path / name, MOTION, **how)
    with pytest.raises(AttitudeError, match="AttitudeHistory is given with tolerance="):
        aem.write(tmp_path / "a.aem", MOTION.at([0.0, 1.0]), tolerance=1e-6)
    for name, unknown in (
        *(("a.acm", "start"), ("a.acm.xml", "start"), ("a.aem", "object"), ("a.bc", "body")),
        *(("a.toml", "object"), ("a.spin", "object"), ("a.csv", "object")),
    ):
        how = {"start": 0.0, "stop": 1.0, unknown: 0.5} if name not in ("a.toml", "a.spin") else {}
        with pytest.raises(AttitudeError, match=rf"is written without {unknown}=; beside .* takes"):
            MOTION.write(tmp_path / name, **{unknown: 0.5} | how)
    with pytest.raises(AttitudeError, match=r"motion.write\('.*a.acm', t\)\.$"):
        MOTION.write(tmp_path / "a.acm")
    assert not list(tmp_path.iterdir())


def test_what_the_epochs_of_a_file_cannot_hold(tmp_path):
    """Epochs of 5e-13 s at 0.15 rad/s; those of STK are doubles of seconds from a whole second."""
    span = {"start": 0.0, "stop": 10.0, "tolerance": 1e-14}
    with pytest.raises(AttitudeError, match=r"deviates by .* more than the tolerance 1e-14"):
        aem.write(tmp_path / "a.aem", MOTION, **span)
    assert not list(tmp_path.iterdir())
    assert stk.write(tmp_path / "a.a", MOTION, **span).error < 1e-14


def test_too_many_records(tmp_path):
    with pytest.raises(AttitudeError, match=r"needs .* records, more than 20000000"):
        how = {"method": "slerp", "kind": "QUATERNION", "tolerance": 1e-12}
        aem.write(tmp_path / "a.aem", MOTION, start=0.0, stop=1e6, **how)


@pytest.mark.parametrize("name", ["a.aem", "a.xml", "a.a", "a.ecsv", "a.csv"])
def test_on_the_command_line(tmp_path, capsys, name):
    spin, path = tmp_path / "a.toml", tmp_path / name
    spin_file.write(spin, MOTION)
    assert main(["convert", str(spin), str(path), "--stop", "100", "--tolerance", "1e-8"]) == 0
    said = capsys.readouterr().out
    assert "records at most" in said and "in 1 segment: error" in said
    assert error(MOTION, detect.read(path)) < 1.1e-8
    # With --step the tolerance is that of lengths, as before.
    made = ["convert", str(spin), str(path), "--stop", "10", "--step", "1", "--tolerance", "1e-3"]
    assert main(made) == 0 and "records" not in capsys.readouterr().out


@pytest.mark.parametrize("ending", ["aem", "acm", "cic", "quat", "a"])
def test_quaternions_in_axes_of_an_orbit_keep_their_sign(tmp_path, monkeypatch, ending):
    spin = Spin("2026-01-01", (0.5, 0.5, -0.5, 0.5), (2e-4, 1e-4, 1e-3))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    orbit = paths.kepler(
        **{"epoch": "2026-01-01", "semi_major_axis": "7000 km", "eccentricity": 0.01},
        **{"inclination": "51 deg", "node": "20 deg", "pericenter_argument": "10 deg"},
        **{"mean_anomaly": 0.3, "center": "earth", "frame": "icrf"},
    )
    frame = "VVLH" if ending == "a" else "LVLH"
    path = tmp_path / f"l.{ending}"
    monkeypatch.setattr(_sampling, "PIECE", 100)
    motion.write(path, t=np.arange(0.0, 90000.0, 60.0), frame=frame, orbit=orbit)
    rows = [line.split() for line in path.read_text().splitlines()]
    numbers = [row[-4:] for row in rows if len(row) in (5, 6) and row[0][0] in "0123456789"]
    if not numbers:  # with rates
        numbers = [row[1:5] for row in rows if len(row) == 8]
    wxyz = np.array(numbers, dtype=float)
    assert len(wxyz) == 1500
    assert np.min(np.sum(wxyz[1:] * wxyz[:-1], axis=1)) > 0.99


@pytest.mark.parametrize("ending", ["aem", "acm", "cic", "apm"])
@pytest.mark.parametrize("digits", [19, 20, -3, 1.5, "6", True])
def test_decimals_are_from_0_to_18(tmp_path, ending, digits):
    path = tmp_path / f"a.{ending}"
    t = {} if ending == "apm" else {"t": [0.94, 1.97]}
    with pytest.raises(AttitudeError, match=f"digits is {digits!r}; give a whole number from 0"):
        MOTION.write(path, **t, digits=digits)
    assert not list(tmp_path.iterdir())
    MOTION.write(path, **t, digits=18)
    assert detect.read(path) is not None


@pytest.mark.parametrize("ending", ["aem", "acm", "cic", "quat", "csv", "a"])
def test_no_segments_are_refused(tmp_path, ending):
    for source in ([], [MOTION.at([0.0, 1.0]), ()]):
        with pytest.raises(AttitudeError, match="no segments are given; give one or more"):
            detect.write(tmp_path / f"a.{ending}", source)


def test_writers_name_the_one_for_what_a_file_holds(tmp_path):
    with pytest.raises(AttitudeError, match=r"would hold a motion, .* use write_motion"):
        detect.write(tmp_path / "a.toml", MOTION, t=[0.0])
    with pytest.raises(AttitudeError, match=r"would hold attitudes at epochs, .* use write"):
        detect.write_motion(tmp_path / "a.aem", MOTION)
    for write in (detect.write, detect.write_motion):
        with pytest.raises(AttitudeError, match=r"any epoch of a span, .* use motion\.write with"):
            write(tmp_path / "a.bc", MOTION)


@pytest.mark.parametrize("ending", ["aem", "xml", "acm", "cic", "quat", "csv"])
def test_epochs_that_would_be_the_same_text_are_refused(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    step = 1e-13 if ending in ("acm", "cic") else 5e-12
    with pytest.raises(AttitudeError, match=r"two epochs are both written as .* farther apart"):
        MOTION.write(path, t=[0.0, step])
    if ending not in ("quat", "csv"):
        with pytest.raises(AttitudeError, match="two epochs are both written as"):
            MOTION.write(path, t=np.arange(20) * 0.1, digits=0)
    assert not list(tmp_path.iterdir())
    MOTION.write(path, t=[0.0])
    MOTION.write(path, t=[0.0, 1e-9])
    assert len(detect.read(path).seconds) == 2


def test_days_before_the_first_modified_julian_date_are_refused(tmp_path):
    path = tmp_path / "a.cic"
    with pytest.raises(AttitudeError, match="outside of 1858-11-17, the modified Julian date 0"):
        MOTION.write(path, t=["1858-11-16T00:00:00 TT"], time_system="TT")
    MOTION.write(path, t=["1858-11-17T12:00:00 TT"], time_system="TT")
    first = epochs.instant("1858-11-17T12:00:00 TT")
    assert detect.read(path).epoch.since(first) == pytest.approx(0.0, abs=1e-9)
