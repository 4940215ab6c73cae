"""AttitudeHistory: every view of the same rotations, sliced, copied and tabulated."""

import copy
import math
import pickle

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, AttitudeHistory, Body, FreeRotation, Spin
from attitude.frames import quaternion
from attitude.motions._history import _MANY

MOTION = FreeRotation(
    Body(moments=(10, 20, 26)),
    Spin(epoch="2026-01-01", wxyz=(0.5, 0.5, -0.5, 0.5), angular_velocity=(1, 15, 1)),
)
T = 1.5 * np.arange(40)  # s; sums with a power of two are exact


@pytest.fixture
def history():
    return MOTION.at(T)


# ---- conventions -------------------------------------------------------------------------------


def test_scalar_first_and_last(history):
    assert np.array_equal(history.xyzw[..., [3, 0, 1, 2]], history.wxyz)
    scipy = Rotation.from_quat(np.array(history.xyzw))
    assert np.max(np.abs(scipy.as_matrix() - history.matrix)) < 1e-15


def test_matrix_takes_body_to_inertial_and_dcm_back(history):
    v = np.array([0.3, -0.2, 0.9])
    out = history.body_to_inertial(v)
    assert out.shape == (40, 3)
    assert np.max(np.abs(history.matrix @ v - out)) < 1e-15
    assert np.max(np.abs(history.inertial_to_body(out) - v)) < 3e-15
    assert np.array_equal(history.dcm, np.swapaxes(history.matrix, 1, 2))
    each = np.random.default_rng(1).normal(size=(40, 3))
    back = history.inertial_to_body(history.body_to_inertial(each))
    assert np.max(np.abs(back - each)) < 3e-15


def test_long_histories_turn_vectors_as_short_ones_do():
    """In blocks, and from many epochs on compiled: each row as it is turned by itself."""
    long = MOTION.at(0.25 * np.arange(_MANY + 5))
    each = np.random.default_rng(3).normal(size=(len(long), 3))
    short = long[:10_000]  # more than a block, less than many
    for v in ((0.3, -0.2, 0.9), each):
        for name in ("body_to_inertial", "inertial_to_body"):
            found = getattr(long, name)(v)
            assert found.shape == (len(long), 3)
            part = getattr(short, name)(np.asarray(v)[: len(short)] if v is each else v)
            assert np.max(np.abs(found[: len(short)] - part)) <= 5e-16  # an ulp
            for k in (0, 8191, 8192, 9999, len(long) - 1):
                one = getattr(long[k], name)(each[k] if v is each else v)
                assert np.max(np.abs(found[k] - one)) <= 1e-15  # one of each of three sums
    assert not np.shares_memory(long.body_to_inertial(each), each)
    nothing = long.body_to_inertial((np.nan, 0.0, 0.0))
    assert np.all(np.isnan(nothing))


def test_the_paper_composes_a_from_three_angles(history):
    """(3.3): A = Rz(psi) Rx(theta) Rz(phi) as coordinate turns is the transpose of ZXZ here."""
    angles = history.euler("ZXZ")
    again = Rotation.from_euler("ZXZ", angles).as_matrix()
    assert np.max(np.abs(again - history.matrix)) < 2e-15
    assert np.array_equal(angles, history.euler("313"))
    assert angles.shape == (40, 3)


@pytest.mark.parametrize(
    ("sequence", "angles"), [("ZXZ", (0.7, 9e-8, 0.4)), ("XYZ", (0.7, 0.5 * math.pi - 5e-8, 0.4))]
)
def test_angles_beside_gimbal_lock_are_those_of_the_attitude(sequence, angles):
    wxyz = quaternion.from_euler(sequence, angles)
    spin = Spin(epoch="2026-01-01", wxyz=wxyz, angular_velocity=(0, 0, 0))
    found = FreeRotation(MOTION.body, spin).at([0.0]).euler(sequence)
    assert np.allclose(found, [angles], rtol=0, atol=1e-7)
    assert np.allclose(abs(quaternion.from_euler(sequence, found[0]) @ wxyz), 1.0, atol=1e-15)


def test_scipy_rotation(history):
    assert np.max(np.abs(history.as_rotation().as_matrix() - history.matrix)) < 1e-15
    one = MOTION.at(3.0)
    assert one.as_rotation().single
    assert one.euler("XYZ").shape == (3,)


def test_derivatives_are_those_of_the_motion(history):
    """w from a difference quotient of the attitude; acceleration from Euler's equations."""
    step = 2.0**-20
    moved = [MOTION.at(T + s).matrix for s in (-step, step)]
    spin = history.dcm @ (moved[1] - moved[0]) / (2 * step)  # [w x] in body axes
    w = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    # w^3 step^2 / 6 and rounding over step: 6e-10 + 2e-10
    assert np.max(np.abs(w - history.angular_velocity)) < 4e-9
    inertial = np.einsum("nij,nj->ni", history.matrix, history.angular_velocity)
    assert np.max(np.abs(history.angular_velocity_inertial - inertial)) < 2e-14
    moments = np.array([10.0, 20.0, 26.0])
    w = history.angular_velocity
    torque = moments * history.angular_acceleration + np.cross(w, moments * w)
    assert np.max(np.abs(torque)) < 1e-11  # N m of 4500: no torque acts


def test_momentum_stays_in_the_history(history):
    momentum = history.body_to_inertial(np.array([10.0, 20.0, 26.0]) * history.angular_velocity)
    assert np.max(np.abs(momentum - MOTION.momentum)) < 4e-15 * 302


# ---- slices and shapes -------------------------------------------------------------------------


@pytest.mark.parametrize("asked_before", [False, True])
@pytest.mark.parametrize(
    "index",
    [slice(10, 20), slice(None, None, -3), 7, -1, [3, 1, 4], np.arange(40) % 2 == 0, (Ellipsis,)],
)
def test_slices_are_histories(history, index, asked_before):
    if asked_before:
        _ = history.angular_velocity
    part = history[index]
    assert isinstance(part, AttitudeHistory)
    assert np.array_equal(part.seconds, T[index])
    assert np.array_equal(part.wxyz, np.asarray(history.wxyz)[index])
    assert np.array_equal(part.angular_velocity, np.asarray(history.angular_velocity)[index])
    assert not part.wxyz.flags.writeable and not part.angular_velocity.flags.writeable


def test_slices_of_several_axes():
    grid = MOTION.at(T.reshape(5, 8))
    assert grid.wxyz.shape == (5, 8, 4) and len(grid) == 5
    assert np.array_equal(grid[1:3].wxyz, grid.wxyz[1:3])
    assert np.array_equal(grid[:, 2].wxyz, grid.wxyz[:, 2])
    assert np.array_equal(grid[2, 3].wxyz, grid.wxyz[2, 3])
    assert grid.matrix.shape == (5, 8, 3, 3) and grid.euler("ZXZ").shape == (5, 8, 3)
    assert np.allclose(grid.euler("ZXZ")[2, 3], grid[2, 3].euler("ZXZ"), rtol=0, atol=1e-15)
    v = np.random.default_rng(2).normal(size=(5, 8, 3))
    assert np.allclose(grid.body_to_inertial(v)[2, 3], grid[2, 3].body_to_inertial(v[2, 3]))
    with pytest.raises(AttitudeError, match=r"epochs have shape \(5, 8\); a table takes one row"):
        grid.table()


def test_a_scalar_has_no_length():
    one = MOTION.at(1.0)
    assert one.wxyz.shape == (4,) and one.angular_velocity.shape == (3,)
    assert one.matrix.shape == (3, 3) and one.xyzw.shape == (4,)
    with pytest.raises(TypeError, match="no length"):
        len(one)


def test_length_and_iteration(history):
    assert len(history) == 40
    assert np.array_equal([one.wxyz for one in history], history.wxyz)


# ---- values ------------------------------------------------------------------------------------


def test_a_history_does_not_change(history):
    for name in (
        *("wxyz", "xyzw", "seconds", "matrix", "dcm", "angular_velocity"),
        *("angular_acceleration", "angular_velocity_inertial"),
    ):
        with pytest.raises(ValueError, match="read-only"):
            getattr(history, name)[0] = 0.0
    with pytest.raises(AttributeError, match="does not change"):
        history.wxyz = np.zeros((40, 4))


@pytest.mark.parametrize("asked_before", [False, True])
def test_copies_are_the_same_history(history, asked_before):
    if asked_before:
        _ = history.angular_velocity
    for again in (
        copy.copy(history),
        copy.deepcopy(history),
        pickle.loads(pickle.dumps(history)),
    ):
        assert np.array_equal(again.wxyz, history.wxyz)
        assert np.array_equal(again.angular_velocity, history.angular_velocity)
        assert again.epoch == history.epoch
        assert not again.wxyz.flags.writeable and not again.seconds.flags.writeable
        assert np.array_equal(again[3:5].matrix, history.matrix[3:5])


# ---- conversion to astropy ---------------------------------------------------------------------


def test_time_is_tdb(history):
    assert history.time.scale == "tdb"
    expected = Time("2026-01-01", scale="utc").tdb + T * u.s
    assert np.max(np.abs((history.time - expected).to_value("s"))) < 1e-9


def test_table(history):
    table = history.table()
    assert table.colnames == ["time", "wxyz", "angular_velocity"]
    assert np.array_equal(table["wxyz"], history.wxyz)
    assert table["angular_velocity"].unit == u.rad / u.s
    assert np.array_equal(table["angular_velocity"].value, history.angular_velocity)
    assert "angular_velocity" not in history.table(rates=False).colnames
    assert table.meta["frame"] == "ICRF"
    table["wxyz"][0] = 0.0  # the user's own copy
    assert history.wxyz[0, 0] != 0.0


def test_table_survives_a_file(history, tmp_path):
    """ECSV keeps every bit of the numbers."""
    from astropy.table import QTable

    table = history.table()
    table.write(tmp_path / "table.ecsv")
    again = QTable.read(tmp_path / "table.ecsv")
    assert np.array_equal(again["wxyz"], history.wxyz)
    assert np.all(again["time"] == table["time"])


def test_tables_keep_both_doubles_of_epochs(tmp_path):
    """Attitudes at the epochs that come back from files agree to 1e-9 rad at 15 rad/s."""
    from astropy.table import QTable
    from astropy.time import Time

    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    history = motion.at(np.linspace(0.0, 1e5, 11) + 1.0 / 3.0)
    history.table().write(tmp_path / "h.ecsv")
    history.table().write(tmp_path / "h.csv")
    ecsv = QTable.read(tmp_path / "h.ecsv")["time"]
    assert ecsv.scale == "tdb"
    csv = QTable.read(tmp_path / "h.csv")
    csv = Time(csv["tdb_jd1"], csv["tdb_jd2"], format="jd", scale="tdb")
    for time in (ecsv, csv):
        again = motion.at(time).as_rotation()
        # Two Julian dates resolve 5e-12 s, 1e-10 rad at 15 rad/s.
        assert np.max((again * history.as_rotation().inv()).magnitude()) < 1e-9


def test_csv_of_dates_in_utc_names_the_scale(tmp_path):
    from astropy.time import Time

    from attitude._support.tables import FlatTable

    time = Time(["2026-01-01T00:00:00.123456789", "2026-01-02"], scale="utc")
    table = FlatTable({"time": time, "rise": time.copy()})
    table.write(tmp_path / "t.csv")
    lines = (tmp_path / "t.csv").read_text().splitlines()
    assert lines[0] == "utc,rise_utc"
    assert lines[1].split(",")[0] == "2026-01-01T00:00:00.123456789"


# ---- NaN and what is refused -------------------------------------------------------------------


def test_nan_epochs(history):
    history = MOTION.at([0.0, math.nan, 1.0])
    assert np.array_equal(np.isnan(history.matrix).any(axis=(1, 2)), [False, True, False])
    assert np.array_equal(np.asarray(history.time.mask), [False, True, False])
    for ask in (history.as_rotation, lambda: history.euler("ZXZ")):
        with pytest.raises(AttitudeError, match=r"some attitudes are NaN.*leave them out"):
            ask()
    clean = history[~np.isnan(history.seconds)]
    assert len(clean.as_rotation()) == 2


@pytest.mark.parametrize(
    ("v", "message"),
    [
        ((1, 2), r"v has shape \(2,\); give \(..., 3\)"),
        (5.0, r"v has shape \(\)"),
        ("up", "v is 'up'"),
        (None, "v is None; give real numbers"),
    ],
)
def test_bad_vectors(history, v, message):
    for turn in (history.body_to_inertial, history.inertial_to_body):
        with pytest.raises(AttitudeError, match=message):
            turn(v)


@pytest.mark.parametrize("sequence", ["ZZX", "zXz", "Z", "", 31, 3131, None, 1.5])
def test_bad_sequences(history, sequence):
    with pytest.raises(AttitudeError, match="give three axes, no two neighbours equal"):
        history.euler(sequence)
