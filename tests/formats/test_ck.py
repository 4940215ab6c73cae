"""C-kernels: SPICE itself, asked at random epochs, is the witness."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.frames import quaternion
from attitude.motions._table import AttitudeTable

spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
from attitude.formats import ck  # noqa: E402

SPIN = Spin(
    epoch="2026-01-01T00:00:00.123", wxyz=(1, 2, 3, 4), angular_velocity=(0.001, 0.0175, 0.001)
)
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def exact(et):
    """The motion at doubles of TDB seconds past J2000."""
    seconds = (et - SPIN.epoch.seconds) - SPIN.epoch.low
    low = ((et - SPIN.epoch.seconds) - seconds) - SPIN.epoch.low
    return MOTION.at(seconds, low)


@pytest.fixture
def loaded():
    kernels = []

    def load(*names):
        for name in names:
            spice.furnsh(name)
            kernels.append(name)

    yield load
    for name in kernels:
        spice.unload(name)


@pytest.mark.parametrize(
    ("kind", "tolerance", "rate_tolerance", "span"),
    [
        (5, 1e-9, None, 36000.0),
        (5, 1e-12, 1e-12, 300_000.0),  # two segments
        (5, 1e-4, 1e-10, 3600.0),
        (3, 1e-6, None, 3600.0),
    ],
)
def test_spice_reads_the_motion_within_the_tolerances(
    tmp_path, loaded, kind, tolerance, rate_tolerance, span
):
    how = {"kind": kind, "tolerance": tolerance, "rate_tolerance": rate_tolerance}
    made = ck.write(tmp_path / "a.bc", MOTION, 0.0, span, **how)
    assert made.error <= tolerance
    rate_tolerance = rate_tolerance or tolerance * 0.02
    loaded(*made.kernels)
    start = SPIN.epoch.seconds
    et = start + np.random.default_rng(9).uniform(0.01, span - 0.01, 500)
    true = exact(et)
    for k, second in enumerate(et):
        matrix = spice.pxform("J2000", "TUMBLER", second)
        # SPICE's epochs are doubles: et is taken as it is, and the kernel is exact there
        assert np.max(np.abs(matrix - true.dcm[k])) < tolerance + 4e-15
        again, rate, _ = spice.ckgpav(-999000, spice.sce2c(-999, second), 0.0, "J2000")
        assert np.max(np.abs(again - true.dcm[k])) < tolerance + 4e-15
        assert np.max(np.abs(rate - true.angular_velocity_inertial[k])) < rate_tolerance
    cover = spice.ckcov(made.kernels[0], -999000, True, "INTERVAL", 0.0, "TDB")
    ends = [spice.wnfetd(cover, 0)[0], spice.wnfetd(cover, spice.wncard(cover) - 1)[1]]
    assert abs(ends[0] - start) < 2e-7 and abs(ends[1] - start - span) < 2e-7


def test_the_attitude_is_read_back_through_spice(tmp_path):
    made = ck.write(tmp_path / "a.bc", MOTION, 0.0, 600.0, tolerance=1e-11)
    with ck.KernelAttitude(made.kernels, "TUMBLER") as kernel:
        t = np.random.default_rng(1).uniform(1.0, 599.0, (7, 3))
        times = MOTION.at(t).time
        read = kernel.at(times)
        # dates of 5e-12 s; what SPICE's double leaves out is put back
        assert apart(read.wxyz, MOTION.at(t).wxyz) < 3e-11
        off = read.angular_velocity - MOTION.at(t).angular_velocity
        assert np.max(np.abs(off)) < 1e-9  # rad/s: rates are those of the double, 1e-7 s away
        assert read.wxyz.shape == (7, 3, 4)
        assert np.isnan(kernel.at([np.nan]).wxyz).all()
        with pytest.raises(AttitudeError, match="no attitude of TUMBLER"):
            kernel.at("2027-01-01")
        with pytest.raises(AttitudeError, match="no moments of inertia"):
            kernel.angular_acceleration_at(t)
    with pytest.raises(AttitudeError, match="no attitude"):
        kernel.at(times)  # closed


def test_a_table_becomes_a_kernel(tmp_path):
    table = AttitudeTable.from_history(MOTION.at(np.arange(0.0, 601.0, 5.0)))
    made = ck.write(tmp_path / "a.bc", table, 0.0, 600.0, tolerance=1e-6)
    with ck.KernelAttitude(made.kernels, "TUMBLER") as kernel:
        t = table.epoch.after(77.7).time
        assert apart(kernel.at(t).wxyz, MOTION.at(77.7).wxyz) < 2e-6


def test_a_body_at_rest_and_one_that_spins_steadily(tmp_path):
    for rates in ((0, 0, 0), (0, 0, 0.01)):
        spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rates)
        motion = FreeRotation(Body(moments=(1, 2, 2.5)), spin)
        made = ck.write(tmp_path / "a.bc", motion, 0.0, 1e5, tolerance=1e-9)
        assert made.error < 1e-9


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ({"kind": 2}, "types 3 and 5"),
        ({"tolerance": 0.0}, "tolerance is"),
        ({"rate_tolerance": -1.0}, "rate_tolerance is"),
        ({"name": "two words"}, "name is"),
        ({"instrument": 5}, "instrument is 5"),
        ({"stop": 0.0}, "not after start"),
        ({"kind": 3, "tolerance": 1e-13, "stop": 1e7}, "records, more than"),
    ],
)
def test_what_cannot_be_written(tmp_path, how, sentence):
    settings = {"start": 0.0, "stop": 100.0, **how}
    with pytest.raises(AttitudeError, match=sentence):
        ck.write(tmp_path / "a.bc", MOTION, **settings)
    assert not list(tmp_path.iterdir())
    with pytest.raises(AttitudeError, match=r"\.bc"):
        ck.write(tmp_path / "a.ck", MOTION, 0.0, 1.0)


def test_unknown_frames_and_broken_kernels(tmp_path):
    with pytest.raises(AttitudeError, match="do not define"):
        ck.KernelAttitude([], "NOWHERE")
    junk = tmp_path / "junk.bc"
    junk.write_bytes(b"DAF/CK  " + bytes(3000))
    with pytest.raises(AttitudeError):
        ck.KernelAttitude(junk, "J2000")
    with pytest.raises(AttitudeError, match="cannot be read"):
        ck.KernelAttitude(tmp_path / "none.bc", "J2000")
    text = tmp_path / "broken.tf"
    text.write_text("KPL/FK\n\\begindata\nFRAME_X = abc def\n\\begintext\n")
    with pytest.raises(AttitudeError, match="cannot load"):
        ck.KernelAttitude(text, "J2000")
    assert spice.ktotal("ALL") == 0


def test_heads_that_end_the_process_in_spice_are_refused_before(tmp_path):
    """Found by mutation: SPICE believes the numbers of the first record, and crashes."""
    made = ck.write(tmp_path / "a.bc", MOTION, 0.0, 600.0)
    whole = (tmp_path / "a.bc").read_bytes()
    for place, value, sentence in [
        (13, 47, "states summaries of 2 doubles and"),
        (10, 231, "states summaries of"),
        (77, 9, "its summaries are not within it"),
        (86, 9, "shorter than its head states"),
    ]:
        changed = bytearray(whole)
        changed[place] = value
        (tmp_path / "a.bc").write_bytes(changed)
        with pytest.raises(AttitudeError, match=sentence):
            ck.KernelAttitude(made.kernels, "TUMBLER")
    (tmp_path / "a.bc").write_bytes(whole[:500])
    with pytest.raises(AttitudeError, match="ends before its first 1024 bytes"):
        ck.KernelAttitude(made.kernels, "TUMBLER")
    assert spice.ktotal("ALL") == 0


@pytest.fixture
def users_own(tmp_path):
    """What a user has in SPICE's pool: three kernels and variables of a program."""
    made = ck.write(tmp_path / "users.bc", MOTION, 0.0, 600.0)
    for name in made.kernels:
        spice.furnsh(name)
    spice.pdpool("USERS_NUMBERS", [1.0, 2.5])
    spice.pcpool("USERS_WORDS", ["one", "two words"])
    before = pool()
    yield made
    assert pool() == before
    assert np.array_equal(spice.gdpool("USERS_NUMBERS", 0, 9), [1.0, 2.5])
    assert list(spice.gcpool("USERS_WORDS", 0, 9)) == ["one", "two words"]
    spice.pxform("J2000", "TUMBLER", SPIN.epoch.seconds + 5.0)  # is still there
    spice.kclear()


def pool():
    """Loaded kernels in their order, and the names of all variables."""
    count = spice.ktotal("ALL")
    return [spice.kdata(k, "ALL")[0] for k in range(count)], set(spice.gnpool("*", 0, 1000))


@pytest.mark.parametrize("same", [True, False])
def test_what_the_user_has_loaded_stays(tmp_path, users_own, same):
    other = ck.write(tmp_path / "other.bc", MOTION, 0.0, 600.0, name="OTHER", instrument=-5000)
    made, name = (users_own, "TUMBLER") if same else (other, "OTHER")
    kernel = ck.KernelAttitude(made.kernels, name)
    kernel.at(SPIN.epoch.after(5.0))
    kernel.close()
    kernel.close()  # a second time does nothing
    with ck.KernelAttitude(made.kernels, name) as kernel, pytest.raises(AttitudeError):
        kernel.at("2030-01-01")
    meta = tmp_path / "meta.tm"
    meta.write_text(
        f"KPL/MK\n\\begindata\nKERNELS_TO_LOAD = ( '{made.kernels[1]}', 'none.bc' )\n\\begintext\n"
    )
    for names, frame in [
        ([*made.kernels, tmp_path / "none.tsc"], name),
        ([meta], name),
        (made.kernels, "NOWHERE"),
    ]:
        with pytest.raises(AttitudeError):
            ck.KernelAttitude(names, frame)


def test_the_ends_of_a_kernel_can_be_asked(tmp_path):
    """Dates are no doubles of TDB: the nearest one may lie 1e-7 s outside of the coverage."""
    for epoch in ("2026-01-01", "2026-01-01T00:00:00.1", "2026-03-04T05:06:07.89"):
        spin = Spin(epoch=epoch, wxyz=(1, 2, 3, 4), angular_velocity=(0.001, 0.0175, 0.001))
        motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
        made = ck.write(tmp_path / "a.bc", motion, 0.0, 600.0)
        with ck.KernelAttitude(made.kernels, "TUMBLER") as kernel:
            times = motion.at([0.0, 600.0]).time
            assert apart(kernel.at(times).wxyz, motion.at([0.0, 600.0]).wxyz) < 2e-9
            assert apart(kernel.at(epoch).wxyz, motion.at(0.0).wxyz) < 2e-9


@pytest.mark.parametrize(
    ("kind", "rates"), [(1, True), (1, False), (2, True), (3, True), (3, False)]
)
def test_kernels_of_others_are_read(tmp_path, kind, rates):
    """Written by SPICE's own writers: type 1 (pointings), 2 (constant rates), 3 (linear).

    Type 2 always has angular velocities.
    """
    made = ck.write(tmp_path / "a.bc", MOTION, 0.0, 600.0)  # for its frame and clock kernels
    ticks = np.arange(0.0, 601.0, 1.0) * 2.0**20
    start = float(np.floor(SPIN.epoch.seconds * 2**23) / 2**23)  # of the clock, not after the epoch
    et = start + ticks / 2.0**20
    true = exact(et[1:])
    quats = np.ascontiguousarray(quaternion.conjugate(true.wxyz))
    spins = np.ascontiguousarray(true.angular_velocity_inertial)
    path = tmp_path / "others.bc"
    handle = spice.ckopn(str(path), "others", 0)
    t = ticks[1:]
    about = (handle, t[0], t[-1], -999000, "J2000")
    if kind == 1:
        spice.ckw01(*about, rates, "x", len(t), t, quats, spins)
    elif kind == 2:
        ends = np.append(t[1:], t[-1] + 2.0**20)
        scale = np.full(len(t), 2.0**-20)
        spice.ckw02(
            handle, t[0], ends[-1], -999000, "J2000", "x", len(t), t, ends, quats, spins, scale
        )
    else:
        spice.ckw03(*about, rates, "x", len(t), t, quats, spins, 1, t[:1])
    spice.ckcls(handle)
    with ck.KernelAttitude([path, *made.kernels[1:]], "TUMBLER") as kernel:
        read = kernel.at(et[1:])
        assert apart(read.wxyz, true.wxyz) < 1e-8  # 1e-7 s between the two clocks
        assert kernel.has_rates_at(et[1:2]) == rates
        if rates:
            assert np.max(np.abs(read.angular_velocity - true.angular_velocity)) < 1e-8
            return
        with pytest.raises(AttitudeError, match="no angular velocities"):
            _ = read.angular_velocity
        from attitude.formats import aem

        aem.write(tmp_path / "a.aem", kernel, t=et[1:50])
        assert aem.read(tmp_path / "a.aem").angular_velocity is None


@pytest.mark.parametrize("content", [b"", b"hello", b"DAF/CK  "])
def test_a_kernel_that_is_cut_off_is_told_in_one_line(tmp_path, content):
    path = tmp_path / "cut.bc"
    path.write_bytes(content)
    with pytest.raises(AttitudeError, match=r"cut\.bc: .*(FILEREADFAILED|1024 bytes)") as error:
        ck.KernelAttitude([path], "TUMBLER")
    assert "\n" not in str(error.value)
