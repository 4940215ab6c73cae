"""Files of motions whose angular velocity jumps: cut at the jumps, or refused."""

import numpy as np
import pytest

from attitude import Body, FreeRotation, Spin
from attitude.arcs import Arcs, Impulse, InertiaChange
from attitude.errors import AttitudeError
from attitude.formats import _sampling, aem, apm, damit, spin_file, stk, tables

BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01T00:00:00.25", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.03, 0.02))
# Between records, at a record, and at the last record; the middle one has two doubles.
TIMES = (20.7, "2026-01-01T00:00:53.3500001", 100.0)
ARCS = Arcs(
    BODY,
    SPIN,
    [
        Impulse(at=TIMES[0], angular_momentum=(0.3, -0.2, 0.1)),
        InertiaChange(at=TIMES[1], body=Body(moments=(12, 18, 25)), angular_momentum=(0.1, 0.1, 0)),
        Impulse(at=TIMES[2], angular_momentum=(0.9, 0.9, 0.9)),
    ],
)
EPOCHS = np.linspace(0.0, 100.0, 101)
# Polynomials of degree 7 through records 1 s apart, at 0.04 rad/s, also at the ends of segments.
BETWEEN = 1e-9


def beside(breaks):
    """Epochs between all records, and close to the breaks on both sides."""
    near = np.concatenate([t + np.array([-0.3, -1e-3, -1e-6, 1e-6, 1e-3, 0.2]) for t in breaks])
    t = np.concatenate([EPOCHS[:-1] + 0.37, near])
    return t[t < EPOCHS[-1]]


def apart(motion, table, t):
    """The largest angle, rad, between a motion and a table read back."""
    a, b = motion.at(t).wxyz, table.at(motion.epoch.after(t) if np.ndim(t) == 0 else dates(t)).wxyz
    return np.max(2.0 * np.linalg.norm(a * np.sign(np.sum(a * b, axis=1))[:, None] - b, axis=1))


def dates(t):
    return [ARCS.epoch.after(float(each)) for each in t]


@pytest.mark.parametrize("name", ["a.aem", "a.xml", "a.ecsv", "a.fits", "a.parquet"])
@pytest.mark.parametrize("as_history", [False, True])
def test_files_with_segments_are_cut_at_the_breaks(tmp_path, name, as_history):
    path = tmp_path / name
    if name.endswith("parquet"):
        pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    source, t = (ARCS.at(EPOCHS), None) if as_history else (ARCS, EPOCHS)
    if name.endswith(("aem", "xml")):
        aem.write(path, source, t=t, xml=name.endswith("xml"))
        table = aem.read(path)
    else:
        tables.write(path, source, t=t)
        table = tables.read(path)
    assert [len(part) for part in table.segments] == [22, 35, 48]
    assert apart(ARCS, table, beside(ARCS.joints)) < BETWEEN
    # Both states stand at a break: the rates before and after.
    for k, joint in enumerate(ARCS.joints[:2]):
        ends = table.segments[k].angular_velocity[-1], table.segments[k + 1].angular_velocity[0]
        for found, shift in zip(ends, (-1e-9, 1e-9), strict=True):
            assert found == pytest.approx(ARCS.angular_velocity_at(joint + shift), abs=1e-8)
        assert np.linalg.norm(ends[0] - ends[1]) > 0.005
    # The last record is the state before the last impulse.
    last = ARCS.angular_velocity_at(100.0 - 1e-9)
    assert table.segments[-1].angular_velocity[-1] == pytest.approx(last, abs=1e-8)


def test_uncut_the_same_records_would_err_by_a_thousand_times_the_bound(tmp_path):
    """What the file held before: one segment, so that the test above can fail."""
    uncut = _sampling._of_motion(ARCS, EPOCHS)
    history = ARCS.at(uncut.seconds)
    from attitude.motions._table import AttitudeTable

    assert apart(ARCS, AttitudeTable.from_history(history), beside(ARCS.joints)) > 1e3 * BETWEEN


def test_files_of_one_segment_refuse_a_break(tmp_path):
    for name, write in (("a.csv", tables.write), ("a.a", stk.write)):
        path = tmp_path / name
        with pytest.raises(AttitudeError, match=r"jumps at 20\.7, 53\.1.* holds one segment"):
            write(path, ARCS, t=EPOCHS)
        assert not path.exists()
        # A stretch between breaks has none.
        write(path, ARCS, t=EPOCHS[22:53])
        read = tables.read if name.endswith("csv") else stk.read
        assert apart(ARCS, read(path), EPOCHS[22:52] + 0.3) < BETWEEN


def test_files_of_a_state_refuse_a_motion_with_jumps(tmp_path):
    """An APM of it held the state at the epoch, from which readers propagate past the impulse."""
    for name, write in (("a.apm", apm.write), ("a.spin", damit.write), ("a.toml", spin_file.write)):
        with pytest.raises(AttitudeError, match=r"3 jumps of .* first 20\.7 s after|FreeRotation"):
            write(tmp_path / name, ARCS)
        assert not (tmp_path / name).exists()
    apm.write(tmp_path / "a.apm", Arcs(BODY, SPIN, []))
    assert apm.read(tmp_path / "a.apm").spin.epoch == SPIN.epoch


def test_motions_without_breaks_are_one_segment_as_before():
    free = FreeRotation(BODY, SPIN)
    (part,) = _sampling.segments(free, EPOCHS)
    assert part.seconds is not None and not part.after_break and len(part) == len(EPOCHS)
    (part,) = _sampling.segments(ARCS, EPOCHS[60:90])
    assert len(part) == 30
    # A break at the first record belongs to the stretch before.
    (part,) = _sampling.segments(ARCS, ARCS.joints[0] + np.arange(20.0))
    assert part.seconds[0] == ARCS.joints[0] and len(part) == 20


@pytest.mark.parametrize(("kind", "tolerance"), [(5, 1e-9), (5, 1e-12), (3, 1e-6)])
def test_a_kernel_keeps_its_tolerance_on_both_sides_of_a_break(tmp_path, kind, tolerance):
    """It claimed 1.3e-15 rad and erred by 2.1e-6: SPICE interpolated across the jump."""
    spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    from attitude.formats import ck

    made = ck.write(tmp_path / "a.bc", ARCS, 0.0, 120.0, kind=kind, tolerance=tolerance)
    assert made.error <= tolerance
    steps = np.random.default_rng(1).uniform(-2.0, 2.0, 60) * made.step
    t = np.concatenate([EPOCHS + 0.37, *(joint + steps for joint in ARCS.joints)])
    # SPICE's epochs are doubles of seconds past J2000.
    et = ARCS.epoch.seconds + t
    seconds = (et - ARCS.epoch.seconds) - ARCS.epoch.low
    true = ARCS.at(seconds, ((et - ARCS.epoch.seconds) - seconds) - ARCS.epoch.low)
    names = list(made.kernels)
    try:
        for name in names:
            spice.furnsh(name)
        for k, second in enumerate(et):
            ticks = spice.sce2c(-999, second)
            matrix, rate, _ = spice.ckgpav(-999000, ticks, 0.0, "J2000")
            assert np.max(np.abs(matrix - true.dcm[k])) < tolerance + 4e-15
            assert np.max(np.abs(rate - true.angular_velocity_inertial[k])) < tolerance
    finally:
        for name in names:
            spice.unload(name)


def test_a_kernel_of_many_breaks_closer_than_its_step(tmp_path):
    pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    from attitude.formats import ck

    random = np.random.default_rng(3)
    at = np.cumsum(random.uniform(1e-4, 0.3, 200))
    kicks = [Impulse(at=float(t), angular_momentum=random.normal(size=3) * 0.1) for t in at]
    made = ck.write(tmp_path / "a.bc", Arcs(BODY, SPIN, kicks), 0.0, 60.0, tolerance=1e-10)
    assert made.error <= 1e-10
    twice = [
        Impulse(at=10.0, angular_momentum=(1, 0, 0)),
        Impulse(at=10.0 + 2e-15, angular_momentum=(1, 0, 0)),
    ]
    with pytest.raises(AttitudeError, match="jumps twice within the rounding"):
        ck.write(tmp_path / "b.bc", Arcs(BODY, SPIN, twice), -1e6, 60.0)
