"""C-kernels of tables with gaps, on a mission's clock and frame, and at SPICE's dates."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.cli import main
from attitude.formats import aem, apm, detect, spin_file
from attitude.frames import quaternion
from attitude.motions._table import AttitudeTable

spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
from attitude.formats import ck  # noqa: E402

SPIN = Spin(epoch="2026-03-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.02))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
# What the spacing of one double of TDB, 1.2e-7 s, is at 0.15 rad/s.
DOUBLE = 2e-8


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


@pytest.fixture
def pool():
    """Nothing is loaded before and after; returns SPICE's function that loads a kernel."""
    assert spice.ktotal("ALL") == 0
    yield lambda names: [spice.furnsh(str(name)) for name in names]
    spice.kclear()


def leap_seconds(path):
    """A kernel of leap seconds with the numbers of ERFA and SPICE's formula of TDB."""
    import erfa

    months = ["JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"]
    rows = [row for row in erfa.leap_seconds.get() if row["year"] >= 1972]
    pairs = [f"{row['tai_utc']:g}, @{row['year']}-{months[row['month'] - 1]}-1" for row in rows]
    path.write_text(
        "KPL/LSK\n\\begindata\nDELTET/DELTA_T_A = 32.184\nDELTET/K = 1.657D-3\n"
        "DELTET/EB = 1.671D-2\nDELTET/M = ( 6.239996D0 1.99096871D-7 )\n"
        "DELTET/DELTA_AT = ( " + "\n".join(pairs) + " )\n\\begintext\n"
    )
    return path


# Tables with gaps --------------------------------------------------------------------------------


def table(method, rates):
    t = np.concatenate([np.arange(0.0, 41.0, 2.0), np.arange(60.0, 101.0, 1.5)])
    parts = [MOTION.at(t[t < 50]), MOTION.at(t[t > 50])]
    how = {"rates": rates, "method": method}
    return AttitudeTable.joined([AttitudeTable.from_history(part, **how) for part in parts])


@pytest.mark.parametrize(
    ("method", "rates"),
    [("hermite", True), ("lagrange", True), ("lagrange", False), ("slerp", True), ("slerp", False)],
)
def test_records_at_their_own_epochs(tmp_path, pool, method, rates):
    given = table(method, rates)
    made = ck.write(tmp_path / "a.bc", given)
    # SPICE interpolates the same records by the same polynomials.
    assert made.error < 1e-11 and made.step == pytest.approx(2.0, abs=1e-6)
    if rates:  # SPICE interpolates them over inertial axes, a table over the body's
        assert made.rate_error < {"hermite": 1e-11, "lagrange": 1e-4, "slerp": 5e-3}[method]
    pool(made.kernels)
    cover = spice.ckcov(made.kernels[0], -999000, rates, "INTERVAL", 0.0, "TDB")
    assert spice.wncard(cover) == 2
    start = SPIN.epoch.seconds
    intervals = [spice.wnfetd(cover, k) for k in range(2)]
    assert np.array(intervals) - start == pytest.approx(np.array([[0, 40], [60, 100.5]]), abs=3e-7)
    for second in (0.7, 33.3, 61.9, 99.0):
        matrix = spice.pxform("J2000", "TUMBLER", start + second)
        true = given.at(given.epoch.after(start + second - given.epoch.seconds, -given.epoch.low))
        assert np.max(np.abs(matrix - true.dcm)) < DOUBLE
    with pytest.raises(spice.exceptions.SpiceyError):
        spice.pxform("J2000", "TUMBLER", start + 50.0)


def test_on_the_command_line_a_table_keeps_its_gaps(tmp_path, capsys):
    aem.write(tmp_path / "a.aem", table("hermite", True))
    assert main(["convert", str(tmp_path / "a.aem"), str(tmp_path / "b.bc")]) == 0
    assert "b.bc, b.tf, b.tsc: error" in capsys.readouterr().out
    with (
        ck.KernelAttitude([tmp_path / f"b.{x}" for x in ("bc", "tf", "tsc")], "TUMBLER") as found,
        pytest.raises(AttitudeError, match="no attitude of TUMBLER"),
    ):
        found.at(SPIN.epoch.after(50.0))


# SPICE's dates -----------------------------------------------------------------------------------


def test_kernels_that_answer_str2et(tmp_path, pool):
    """TDB of ERFA and of SPICE differ by 3e-5 s, which is 1e-5 rad at 0.4 rad/s."""
    fast = FreeRotation(
        Body(moments=(10, 20, 26)), Spin(SPIN.epoch, (1, 2, 3, 4), (0.1, 0.35, 0.2))
    )
    dates = [f"2026-03-01T00:{m:02d}:{s:06.3f}" for m, s in ((0, 1.5), (7, 0.25), (15, 59.125))]
    lsk = leap_seconds(tmp_path / "naif.tls")
    errors = {}
    for scale in ("tdb", "spice"):
        made = ck.write(
            tmp_path / f"{scale}.bc", fast, 0.0, 1000.0, tolerance=1e-9, time_scale=scale
        )
        assert made.error <= 1e-9
        pool([lsk, *made.kernels])
        errors[scale] = max(
            np.max(np.abs(spice.pxform("J2000", "TUMBLER", spice.str2et(d)) - fast.at(d).dcm))
            for d in dates
        )
        spice.kclear()
    assert errors["spice"] < 1e-9 + 5e-8  # one double of TDB at 0.4 rad/s
    assert errors["tdb"] > 1e-6
    with pytest.raises(AttitudeError, match="time_scale is 'utc'"):
        ck.write(tmp_path / "a.bc", fast, 0.0, 10.0, time_scale="utc")


# A mission's own clock and frames ----------------------------------------------------------------

CLOCK = """\
KPL/SCLK
\\begindata
SCLK_KERNEL_ID = ( @2026-01-01 )
SCLK_DATA_TYPE_77 = ( 1 )
SCLK01_TIME_SYSTEM_77 = ( 2 )
SCLK01_N_FIELDS_77 = ( 2 )
SCLK01_MODULI_77 = ( 4294967296 65536 )
SCLK01_OFFSETS_77 = ( 0 0 )
SCLK01_OUTPUT_DELIM_77 = ( 1 )
SCLK_PARTITION_START_77 = ( 0.0 )
SCLK_PARTITION_END_77 = ( 2.8E14 )
SCLK01_COEFFICIENTS_77 = ( 0.0 {start} 1.0000001 )
\\begintext
"""
FRAMES = """\
KPL/FK
\\begindata
FRAME_PROBE_BUS = -77000
FRAME_-77000_NAME = 'PROBE_BUS'
FRAME_-77000_CLASS = 3
FRAME_-77000_CLASS_ID = -77000
FRAME_-77000_CENTER = -77
CK_-77000_SCLK = -77
CK_-77000_SPK = -77
\\begintext
"""


def test_the_clock_and_the_frame_of_a_mission(tmp_path, pool):
    clock, frames = tmp_path / "probe.tsc", tmp_path / "probe.tf"
    clock.write_text(CLOCK.format(start=repr(SPIN.epoch.seconds - 1e6)))
    frames.write_text(FRAMES)
    lsk = leap_seconds(tmp_path / "naif.tls")
    how = {"clock": [clock, lsk], "frame_kernel": frames, "name": "PROBE_BUS"}
    # The clock is one double of TDB, so that the tolerance cannot be finer.
    made = ck.write(tmp_path / "a.bc", MOTION, 0.0, 600.0, tolerance=1e-7, **how)
    assert made.kernels == tuple(map(str, (tmp_path / "a.bc", frames, clock, lsk)))
    assert made.error <= 1e-7 and spice.ktotal("ALL") == 0
    assert not (tmp_path / "a.tsc").exists() and not (tmp_path / "a.tf").exists()
    pool(made.kernels)
    for second in np.random.default_rng(2).uniform(1.0, 599.0, 50):
        et = SPIN.epoch.seconds + second
        matrix = spice.pxform("J2000", "PROBE_BUS", et)
        true = MOTION.at((et - SPIN.epoch.seconds) - SPIN.epoch.low)
        assert np.max(np.abs(matrix - true.dcm)) < 1e-7 + DOUBLE
    spice.kclear()
    # A table on that clock, and on the command line.
    made = ck.write(tmp_path / "b.bc", table("hermite", True), **how)
    assert made.error < 1e-7
    spin_file.write(tmp_path / "a.toml", MOTION)
    words = ["convert", str(tmp_path / "a.toml"), str(tmp_path / "c.bc"), "--stop", "60"]
    words += ["--tolerance", "1e-7", "--rate-tolerance", "1e-6", "--body", "PROBE_BUS"]
    assert main([*words, "--clock", str(clock), str(lsk), "--frame-kernel", str(frames)]) == 0
    assert {each.name for each in tmp_path.glob("c.*")} == {"c.bc"}


def test_what_is_refused(tmp_path):
    frames, clock = tmp_path / "probe.tf", tmp_path / "none.tsc"
    frames.write_text(FRAMES)
    clock.write_text("KPL/SCLK\n")
    for how, sentence in (
        ({"frame_kernel": frames}, "defines no frame 'TUMBLER' of class 3"),
        ({"clock": clock}, "define 0 clocks; give the clock kernel"),
        ({"clock": frames, "time_scale": "spice"}, 'time_scale="spice" is for the clock'),
    ):
        with pytest.raises(AttitudeError, match=sentence):
            ck.write(tmp_path / "a.bc", MOTION, 0.0, 60.0, **how)
    assert not (tmp_path / "a.bc").exists() and spice.ktotal("ALL") == 0
    with pytest.raises(AttitudeError, match="start or stop is missing"):
        ck.write(tmp_path / "a.bc", table("hermite", True), 0.0)


# --fit -------------------------------------------------------------------------------------------


def test_a_fit_tries_free_axes_too(tmp_path, capsys):
    """The APM of a body with small products of inertia was 3.6 degrees off."""
    body = Body(tensor=[[10.0, 0.4, -0.2], [0.4, 20.0, 0.3], [-0.2, 0.3, 26.0]])
    motion = FreeRotation(body, SPIN)
    aem.write(tmp_path / "a.aem", motion, t=np.arange(0.0, 400.0, 2.0))
    words = ["convert", str(tmp_path / "a.aem"), str(tmp_path / "b.apm"), "--fit"]
    assert main(words) == 0
    assert "with free axes" in capsys.readouterr().out
    assert apart(apm.read(tmp_path / "b.apm").wxyz, motion.at(0.0).wxyz) < 1e-6
    # The best that principal axes can do, which is refused unless it is accepted.
    assert main([*words, "--axes", "principal"]) != 0
    assert "more than 0.01" in capsys.readouterr().err
    assert main([*words, "--axes", "principal", "--rms", "0.5"]) == 0
    assert apart(apm.read(tmp_path / "b.apm").wxyz, motion.at(0.0).wxyz) > 1e-2


def test_methods(tmp_path):
    spin_file.write(tmp_path / "a.toml", MOTION)
    words = ["convert", str(tmp_path / "a.toml")]
    span = ["--stop", "60", "--tolerance", "1e-4"]
    assert main([*words, str(tmp_path / "a.aem"), *span, "--method", "linear"]) == 0
    assert detect.read(tmp_path / "a.aem").method == "slerp"
    assert main([*words, str(tmp_path / "a.bc"), *span, "--method", "linear"]) == 0
    for name, option in (("b.a", "--method"), ("b.ecsv", "--rate-tolerance"), ("b.aem", "--axes")):
        value = {"--method": "linear", "--axes": "free"}.get(option, "1e-6")
        assert main([*words, str(tmp_path / name), *span, option, value]) != 0
        assert not (tmp_path / name).exists()


@pytest.mark.parametrize("method", ["hermite", "lagrange", "slerp"])
def test_a_usable_span_is_that_of_the_kernel(tmp_path, method):
    given = MOTION.at(seconds := np.arange(0.0, 61.0))
    usable = [MOTION.epoch.after(second) for second in (4.0, 56.5)]
    table = AttitudeTable(
        MOTION.epoch, seconds, given.wxyz, angular_velocity=given.angular_velocity,
        method=method, usable=usable,
    )  # fmt: skip
    made = ck.write(tmp_path / "a.bc", table)
    assert made.error < 1e-9
    with ck.KernelAttitude(made.kernels, "TUMBLER") as kernel:
        for seconds, is_within in ((3.9, False), (4.1, True), (56.4, True), (56.6, False)):
            epoch = MOTION.epoch.after(seconds)
            if is_within:
                assert apart(kernel.at(epoch).wxyz, table.at(epoch).wxyz) < 1e-7
            else:
                with pytest.raises(AttitudeError, match="no attitude of TUMBLER"):
                    kernel.at(epoch)


@pytest.mark.parametrize(("method", "degree"), [("hermite", 5), ("lagrange", 2)])
def test_a_degree_that_spice_does_not_have(tmp_path, method, degree):
    history = MOTION.at(np.arange(0.0, 41.0, 2.0))
    given = AttitudeTable.from_history(history, method=method, degree=degree)
    with pytest.raises(AttitudeError, match=r"deviates by .* more than 1e-09: SPICE has"):
        ck.write(tmp_path / "a.bc", given)
    assert not list(tmp_path.iterdir())
    made = ck.write(tmp_path / "a.bc", given, tolerance=0.1)
    assert 1e-7 < made.error < 0.1
    with pytest.raises(AttitudeError, match="tolerance is nan; give a number of rad"):
        ck.write(tmp_path / "b.bc", given, tolerance=float("nan"))


def test_records_that_are_too_far_apart(tmp_path):
    spin = Spin("2026-01-01", (0.5, 0.5, -0.5, 0.5), (0.02, 0.01, 0.1))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    given = AttitudeTable.from_history(motion.at(np.arange(40) * 25.0))
    with pytest.raises(AttitudeError, match=r"\(SPICE\(BADQUATSIGN\)\)\. The body turns too far"):
        ck.write(tmp_path / "a.bc", given)
