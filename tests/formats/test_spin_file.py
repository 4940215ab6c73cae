"""Spin files: what is written is read back bit by bit; what is wrong is told in a sentence."""

import importlib
import os
import pickle
import signal
import stat
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from attitude import AttitudeError, Body, FreeRotation, Spin, catalog, scattering, shape
from attitude._support import validation
from attitude._textfiles.atomic_write import made_whole, written_whole
from attitude.epochs._instants import Instant
from attitude.formats import mission, spin_file
from tests.support import states
from tests.support.places import ROOT

GOOD = {
    "body": {"moments": "[10, 20, 26]"},
    "spin": {
        "epoch": '"2026-01-01T00:00:00"',
        "wxyz": "[1, 0, 0, 0]",
        "angular_velocity": "[1, 15, 1]",
    },
}


def toml(body=None, spin=None, top="", errors=None):
    """A good file with some keys changed; None leaves a key out, and the section [errors]."""
    lines = [top]
    for name, changes in (("body", body), ("spin", spin)):
        lines.append(f"[{name}]")
        content = {**GOOD[name], **(changes or {})}
        lines += [f"{key} = {value}" for key, value in content.items() if value is not None]
    if errors is not None:
        lines += ["[errors]", *(f"{key} = {value}" for key, value in errors.items())]
    return "\n".join(lines)


def bits(array):
    return np.asarray(array, dtype=float).tobytes()


def same(one, other):
    for name in ("moments", "tensor", "principal_axes", "center_of_mass", "moments_as_pairs"):
        assert bits(getattr(one.body, name)) == bits(getattr(other.body, name)), name
    assert one.body.relative == other.body.relative
    assert one.body.mass == other.body.mass
    assert one.spin.epoch == other.spin.epoch
    assert one.spin.frame == other.spin.frame
    assert bits(one.spin.wxyz) == bits(other.spin.wxyz)
    assert bits(one.spin.angular_velocity) == bits(other.spin.angular_velocity)
    if one.spin.covariance is None:
        assert other.spin.covariance is None
    else:
        assert bits(one.spin.covariance) == bits(other.spin.covariance)


# What is written ----------------------------------------------------------------------------------


@given(
    state=states.strategy(),
    frame=st.sampled_from(["icrf", "ecliptic", "eme2000"]),
    seconds=st.floats(-1e10, 1e10),
    low=st.floats(-1e-9, 1e-9),
    relative=st.booleans(),
    note=st.none() | st.text(st.characters(codec="utf-8")),
)
def test_every_bit_comes_back(state, frame, seconds, low, relative, note):
    body = Body(moments=state.moments, relative=relative)
    spin = Spin(Instant(seconds, low), state.wxyz0, state.omega0, frame)
    given_file = spin_file.SpinFile(body, spin, note=note)
    found = spin_file.parse(spin_file.text(given_file))
    same(found, given_file)
    assert found.note == note
    t = np.array([0.0, 1.0, -7.5]) * states.revolution(state)
    assert bits(found.motion.at(t).wxyz) == bits(given_file.motion.at(t).wxyz)


@given(
    entries=st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3),
    mass=st.none() | st.floats(1e-3, 1e30),
    center=st.lists(st.floats(-10, 10), min_size=3, max_size=3),
)
def test_every_bit_of_a_tensor_comes_back(entries, mass, center):
    xy, xz, yz = entries
    tensor = np.array([[10.0, xy, xz], [xy, 11.0, yz], [xz, yz, 12.0]])
    body = Body(tensor=tensor, mass=mass, center_of_mass=center)
    spin = Spin("2026-01-01", (0.1, 0.2, 0.3, 0.4), (0.1, 0.2, 0.3))
    motion = FreeRotation(body, spin)
    same(spin_file.parse(spin_file.text(motion)), motion)


def test_writing_what_was_read_keeps_the_labels(tmp_path):
    path = tmp_path / "a.toml"
    first = spin_file.parse(toml(top='name = "A \\"b\\""\nsource = "C\\nd \\u007f"\nnote = "ä"'))
    spin_file.write(path, first)
    second = spin_file.read(path)
    same(first, second)
    assert (second.name, second.source, second.note) == ('A "b"', "C\nd \x7f", "ä")
    spin_file.write(path, second, note="new")
    assert spin_file.read(path).note == "new"
    assert spin_file.read(path).name == 'A "b"'


SIGMA = st.lists(st.floats(0.0, 10.0), min_size=3, max_size=3)


@given(attitude=SIGMA, rates=SIGMA, moments=SIGMA)
def test_every_bit_of_standard_deviations_comes_back(attitude, rates, moments):
    sigma = {"attitude": attitude, "angular_velocity": rates, "moments": moments}
    spin = Spin("2026-01-01", (0.1, 0.2, 0.3, 0.4), (0.1, 0.2, 0.3), "ecliptic", sigma)
    text = spin_file.text(spin_file.SpinFile(Body(moments=(1, 2, 3)), spin))
    assert "covariance" not in text
    same(spin_file.parse(text), spin_file.SpinFile(Body(moments=(1, 2, 3)), spin))


@pytest.mark.parametrize("size", [6, 9])
@pytest.mark.parametrize("seed", range(5))
def test_every_bit_of_a_covariance_comes_back(size, seed):
    root = np.random.default_rng(seed).normal(size=(size, size)) / 3.0
    spin = Spin("2026-01-01", (1, 0, 0, 0), (0.1, 0.2, 0.3), covariance=root @ root.T)
    given_file = spin_file.SpinFile(Body(moments=(1, 2, 3)), spin)
    text = spin_file.text(given_file)
    assert text.partition("covariance = [")[2].count("[") == size
    same(spin_file.parse(text), given_file)


def test_errors_in_units():
    found = spin_file.parse(
        toml(
            errors={
                "attitude": '"1 deg"',
                "angular_velocity": '"1, 2, 3 deg/s"',
                "moments": '"1e3 g m2"',
            }
        )
    )
    sigma = np.sqrt(np.diag(found.spin.covariance))
    expected = [*np.radians([1, 1, 1, 1, 2, 3]), 1, 1, 1]
    assert sigma == pytest.approx(expected, rel=1e-15)
    assert np.count_nonzero(found.spin.covariance) == 9
    assert found.motion.at(0.0).sigma_deg == pytest.approx([1, 1, 1], rel=1e-12)
    relative = spin_file.parse(
        toml(body={"relative": "true"}, errors={"moments": "[0.1, 0.2, 0.3]"})
    )
    assert np.sqrt(np.diag(relative.spin.covariance))[6:] == pytest.approx([0.1, 0.2, 0.3])


def test_an_epoch_in_utc_is_written_as_a_date():
    assert 'epoch = "2016-12-31T23:59:60.5"' in spin_file.text(
        spin_file.parse(toml(spin={"epoch": '"2016-12-31T23:59:60.5"'}))
    )


def test_a_spin_file_can_be_pickled():
    found = spin_file.parse(toml())
    same(pickle.loads(pickle.dumps(found)), found)


def test_what_cannot_be_written():
    found = spin_file.parse(toml())
    with pytest.raises(AttitudeError, match="holds a FreeRotation"):
        spin_file.write("never.toml", 3)
    with pytest.raises(AttitudeError, match="name is 5; give text"):
        spin_file.write("never.toml", found, name=5)
    with pytest.raises(AttitudeError, match="which UTF-8 cannot encode"):
        spin_file.write("never.toml", found, name="\ud800")
    assert not os.path.exists("never.toml")


# What is read -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "rate",
    [
        '"14.51, 33.529, -98.709 deg/day"',
        '["14.51 deg/day", "33.529 deg/day", "-98.709 deg/day"]',
        '["14.51 deg/d", "33.529 degrees/day", "-98.709deg/day"]',
    ],
)
def test_units(rate):
    found = spin_file.parse(toml(spin={"angular_velocity": rate})).spin
    radians = np.radians([14.51, 33.529, -98.709]) / 86400.0
    # Two roundings of the factor and one of the product.
    assert found.angular_velocity == pytest.approx(radians, rel=4e-16, abs=0)


def test_units_of_all_kinds():
    found = spin_file.parse(
        toml(
            body={
                "moments": '"1e7, 2e7, 2.5e7 g m2"',
                "mass": '"2 t"',
                "center_of_mass": '"1, 2, 3 cm"',
            },
            spin={"angular_velocity": '"6, 0, 1.5 rpm"'},
        )
    )
    assert found.body.moments == pytest.approx([1e4, 2e4, 2.5e4], rel=1e-15)
    assert found.body.mass == 2000.0
    assert found.body.center_of_mass == pytest.approx([0.01, 0.02, 0.03], rel=1e-15)
    assert found.spin.angular_velocity == pytest.approx([0.2 * np.pi, 0, 0.05 * np.pi], rel=1e-15)


def test_bodies_of_all_kinds():
    def body(**keys):
        return spin_file.parse(toml(body={"moments": None, **keys})).body

    tensor = body(tensor='["2, 0, 0 kg m2", "0, 2.5, 0.5 kg m2", "0, 0.5, 2.5 kg m2"]')
    assert tensor.moments == pytest.approx([2, 2, 3], rel=1e-15)
    ellipsoid = body(ellipsoid='"3, 2, 1 km"', mass="5e12")
    assert ellipsoid.moments == pytest.approx([5e18, 1e19, 1.3e19], rel=1e-15)
    assert not ellipsoid.relative
    dense = body(ellipsoid='"3, 2, 1 km"', density='"2 g/cm3"')
    assert dense.mass == pytest.approx(1.6e13 * np.pi, rel=1e-15) and not dense.relative
    assert body(ellipsoid="[3, 2, 1]").relative
    sized = body(ellipsoid='"380, 240, 180 m"')  # as shape.Ellipsoid takes it
    assert sized.relative and sized.moments == pytest.approx([18000.0, 35360.0, 40400.0], rel=1e-15)
    points = body(
        masses='"1, 1, 2, 2 kg"', positions="[[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]"
    )
    assert sorted(points.moments) == pytest.approx([2, 4, 6], rel=1e-15)
    assert points.mass == 6.0
    assert body(moments="[0.3, 0.9, 1.0]", relative="true").relative


def test_attitudes_of_all_kinds():
    def spin(**keys):
        return spin_file.parse(toml(spin={"wxyz": None, **keys})).spin

    half = np.sqrt(0.5)
    quarter = [half, 0, 0, half]  # about z
    assert spin(wxyz="[1, 0, 0, 1]").wxyz == pytest.approx(quarter, abs=2e-16)
    assert spin(matrix="[[0, -1, 0], [1, 0, 0], [0, 0, 1]]").wxyz == pytest.approx(
        quarter, abs=2e-16
    )
    assert spin(sequence='"313"', angles='"30, 0, 60 deg"').wxyz == pytest.approx(
        quarter, abs=2e-16
    )
    assert spin(sequence='"ZXZ"', angles="[1.5707963267948966, 0, 0]").wxyz == pytest.approx(
        quarter, abs=2e-16
    )
    assert spin(wxyz="[1, 0, 0, 0]", frame='"EME2000"').frame == "eme2000"


def test_epochs_in_other_scales():
    found = spin_file.parse(toml(spin={"epoch": '"2000-01-01T12:00:00 TDB"'})).spin
    assert found.epoch == Instant(0.0)
    found = spin_file.parse(toml(spin={"epoch": '"12.5 + -1e-17 s TDB since J2000"'})).spin
    assert found.epoch == Instant(12.5, -1e-17)


BAD = [
    (toml(body={"moment": "[1, 2, 3]"}), r"\[body\] has a key 'moment'.*did you mean 'moments'"),
    (toml(spin={"angular_velocty": "1"}), r"\[spin\].*did you mean 'angular_velocity'"),
    (toml(spin={"Frame": "1"}), r"did you mean 'frame'"),
    (toml(spin={"qqqq": "1"}), r"\[spin\] has a key 'qqqq' that is not known; allowed are angles,"),
    (toml(top="nmae = 'x'"), r"the file has a key 'nmae'.*did you mean 'name'"),
    (toml(top="name = 5"), r"name is 5; give text in quotes"),
    ("", r"no section \[body\]"),
    ("[body]\nmoments=[1,2,3]", r"no section \[spin\]"),
    ("body = 3\n[spin]", r"body is 3; give a section"),
    (toml(body={"moments": None}), r"\[body\] has none of moments, tensor, ell"),
    (toml(body={"tensor": "[[1]]"}), r"\[body\] has both moments and tensor; give one"),
    (toml(body={"moments": None, "positions": "[[1, 2, 3]]"}), r"\[body\] has no masses"),
    (toml(body={"moments": None, "masses": "[1]"}), r"\[body\] has no positions"),
    (toml(body={"moments": None, "ellipsoid": "[1,2,3]", "mass": "1", "density": "1"}), "both ma"),
    (toml(body={"moments": None, "ellipsoid": "[1,2,3]", "density": "0"}), "density is 0"),
    (toml(body={"density": "1"}), "both moments and density"),
    (toml(body={"positions": "[1]"}), r"positions does not go with moments; leave it out"),
    (toml(body={"moments": None, "ellipsoid": "[1,2,3]", "relative": "true"}), "does not go"),
    (toml(body={"relative": "1"}), r"relative is 1; give true or false"),
    (toml(body={"moments": "[1, 2, 5]"}), "exceeds the sum"),
    (toml(body={"moments": "[1, 2]"}), r"moments has shape \(2,\); give \(3\)"),
    (toml(body={"moments": "[1, nan, 1]"}), "must be finite"),
    (toml(body={"moments": "[1, true, 1]"}), "mixes plain numbers"),
    (toml(body={"moments": "[true, true, true]"}), "is True; give numbers"),
    (toml(body={"moments": '[1, "2 kg m2", 1]'}), "mixes plain numbers"),
    (toml(body={"moments": '"1, 2, 3 kg"'}), "in kg; give it in kg m2"),
    (toml(body={"moments": '"1, 2, 3 kg m2"', "relative": "true"}), "must be a pure number"),
    (toml(body={"moments": '"1; 2; 3 kg m2"'}), "a unit that astropy knows|write numbers"),
    (toml(body={"moments": f"[1, 2, 1{'0' * 400}]"}), "too large a number"),
    (toml(body={"moments": f"[1, 2, {'9' * 4300}]"}), "too large a number"),
    (toml(body={"moments": f"[1, 2, 0x{'f' * 5000}]"}), "too large a number"),
    (toml(body={"moments": f"[1, 2, {'9' * 5000}]"}), "a number has more digits than Python reads"),
    (toml(body={"moments": f"{'[' * 9999}"}), "or lists are nested too deeply"),
    (toml(body={"moments": '"1, 2, 2.5 (m, kg)"'}), r"is in '\(m, kg\)', which is not a unit"),
    (toml(body={"moments": '"1, 2, 2.5 dB(mW)"'}), r"is in 'dB\(mW\)', which is not a unit"),
    (toml(body={"moments": "{a = 1}"}), "give numbers, or text with a unit"),
    (toml(body={"moments": "[]"}), r"moments has shape \(0,\)"),
    (toml(body={"mass": "-1"}), "mass is -1.0; it must be greater"),
    (toml(body={"moments": None, "tensor": "[[1, 2, 3], [4, 5]]"}), "ragged"),
    (toml(spin={"wxyz": None}), r"\[spin\] has none of wxyz, matrix or sequence with angles"),
    (toml(spin={"wxyz": None, "angles": "[1, 2, 3]"}), r"\[spin\] has no sequence; give it"),
    (toml(spin={"wxyz": None, "sequence": "'313'"}), r"\[spin\] has no angles; give it"),
    (toml(spin={"wxyz": None, "sequence": "'311'", "angles": "[1, 2, 3]"}), "sequence is '311'"),
    (toml(spin={"angles": "[1]"}), "angles does not go with wxyz"),
    (toml(spin={"wxyz": "[0, 0, 0, 0]"}), "wxyz holds .0, 0, 0, 0"),
    (toml(spin={"wxyz": None, "matrix": "[[1,0,0],[0,1,0],[0,0,-1]]"}), "reflection"),
    (toml(spin={"epoch": None}), r"\[spin\] has no epoch; give it, for example"),
    (toml(spin={"angular_velocity": None}), r"\[spin\] has no angular_velocity; give it"),
    (toml(spin={"epoch": "2026-01-01T00:00:00"}), "without quotes"),
    (toml(spin={"epoch": "5"}), "epoch is 5 without quotes"),
    (toml(spin={"epoch": '"2026-02-30"'}), r"\[spin\] epoch is '2026-02-30', a date that does not"),
    (toml(spin={"epoch": '"soon"'}), "cannot be read as a date"),
    (toml(spin={"frame": '"teme"'}), "frame is 'teme'; it must be one of"),
    (toml(spin={"frame": "5"}), "frame is 5"),
    (toml(spin={"frame": "['icrf']"}), "frame is"),
    (toml(spin={"angular_velocity": '"1, 2, 3 dge/day"'}), "not a unit that astropy knows"),
    (toml(spin={"angular_velocity": '"1, 2, 3 m/s"'}), "give it in rad/s"),
    (toml(spin={"angular_velocity": '"fast"'}), "not a number with a unit"),
    (toml(errors={}), r"\[errors\] is empty; give standard deviations"),
    ("errors = 3\n" + toml(), "errors is 3; give a section"),
    (toml(errors={"atitude": 1}), r"\[errors\] has a key 'atitude'.*did you mean 'attitude'"),
    (toml(errors={"attitude": '"1 m"'}), r"\[errors\] attitude is in m; give it in rad"),
    (toml(errors={"attitude": -1}), r"\[errors\] attitude is .*; give one standard deviation"),
    (toml(errors={"attitude": "[1, 2]"}), r"\[errors\] attitude is .*; give one standard dev"),
    (toml(errors={"attitude": "nan"}), "every number in it must be finite"),
    (toml(errors={"moments": '"1 kg"'}), "in kg; give it in kg m2"),
    (toml(body={"relative": "true"}, errors={"moments": '"1 kg m2"'}), "must be a pure number"),
    (toml(errors={"covariance": "[[1]]"}), r"\[errors\] covariance has shape \(1, 1\); give"),
    (toml(errors={"covariance": "[]", "moments": 1}), "has both covariance and moments; give one"),
    (toml(errors={"covariance": "'1, 2 deg'"}), "must be a pure number"),
    (toml(errors={"covariance": np.diag([1, 1, 1, 1, 1, -1]).tolist()}), "variances are not neg"),
    ("[body]\nmoments = [1, 2, \n[spin]", "not valid TOML"),
    ("a = 1\na = = 2\nb = 3", r"text, line 2, column \d+: is not valid TOML: "),
    ("a = 1\na = 2", r"text, line 2.*: is not valid TOML: cannot overwrite a value\."),
    ("a = [1", r"text, line 1 \(the end\): is not valid TOML: "),
]  # fmt: skip


@pytest.mark.parametrize(("content", "message"), BAD, ids=[message for _, message in BAD])
def test_what_is_wrong_is_told(content, message):
    with pytest.raises(AttitudeError, match=message) as caught:
        spin_file.parse(content)
    sentence = str(caught.value)
    assert sentence.startswith("text")
    assert sentence[-1] in ".?"
    assert "\n" not in sentence


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(AttitudeError, match=r"none\.toml: cannot be read \(No such file"):
        spin_file.read(tmp_path / "none.toml")
    with pytest.raises(AttitudeError, match="cannot be read"):
        spin_file.read(tmp_path)
    (tmp_path / "bytes.toml").write_bytes(b"name = '\xff'")
    with pytest.raises(AttitudeError, match="not text in UTF-8"):
        spin_file.read(tmp_path / "bytes.toml")
    (tmp_path / "bom.toml").write_bytes(b"\xef\xbb\xbf" + toml().encode())
    assert spin_file.read(tmp_path / "bom.toml").body.moments[2] == 26.0


@given(st.text(max_size=30))
def test_no_text_is_more_than_an_error(text):
    with suppress(AttitudeError):
        spin_file.parse(text)
    with suppress(AttitudeError):
        validation.real(text, "x", unit="s")


# Files that appear whole --------------------------------------------------------------------------


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(0o640)
    for error in (ValueError, KeyboardInterrupt):
        with pytest.raises(error), written_whole(path) as file:
            file.write("half of the new")
            raise error
        assert path.read_text() == "old"
        assert os.listdir(tmp_path) == ["a.txt"]
    with written_whole(path) as file:
        file.write("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert os.listdir(tmp_path) == ["a.txt"]


_WRITING = """
import signal, sys, threading, time
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # ignored below nohup
from attitude._textfiles.atomic_write import made_whole, written_whole

def write():
    with written_whole("a.txt") as file, made_whole("b.gif") as name, open(name, "w") as other:
        print(*(file.write("half"), other.write("half")), flush=True)
        while True:
            time.sleep(0.01)

if sys.argv[1] == "thread":  # signals reach the main thread
    with written_whole("c.txt"):
        threading.Thread(target=write, daemon=True).start()
        while True:
            time.sleep(0.01)
write()
"""


def _ended_while_writing(folder, number, where="main"):
    """Start a process that writes to files in a folder, and end it by a signal."""
    command = [sys.executable, "-c", _WRITING, where]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        assert any(name.endswith(".part") for name in os.listdir(folder))
        process.send_signal(number)
        assert process.wait(20) == -number


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM that a process can handle")
@pytest.mark.parametrize("where", ["main", "thread"])
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_signal_to_end_leaves_no_files(tmp_path, name, where):
    _ended_while_writing(tmp_path, getattr(signal, name), where)
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGKILL")
def test_the_next_write_deletes_what_a_killed_process_left(tmp_path):
    """And nothing of processes that live, of other names, or that another machine has locked."""
    _ended_while_writing(tmp_path, signal.SIGKILL)
    assert len(os.listdir(tmp_path)) == 2
    kept = [f".a.txt.{os.getppid()}.part", ".a.txt.x.part", ".aa.txt.1.part", ".a.txt.0.part"]
    for name in kept:
        (tmp_path / name).write_text("half")
    with written_whole(tmp_path / "a.txt") as file:
        file.write("new")
    with made_whole(tmp_path / "b.gif") as name:
        Path(name).write_text("new")
    assert sorted(os.listdir(tmp_path)) == sorted([*kept, "a.txt", "b.gif"])


@pytest.mark.skipif(os.name == "nt", reason="Windows has no locks of this kind")
def test_a_file_that_is_locked_is_in_use(tmp_path):
    import fcntl

    (tmp_path / ".a.txt.4194305.part").write_text("above the largest number of a process")
    with open(tmp_path / ".a.txt.4194305.part", "rb") as other:
        fcntl.flock(other, fcntl.LOCK_SH)
        with written_whole(tmp_path / "a.txt") as file:
            file.write("new")
    assert len(os.listdir(tmp_path)) == 2


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM that a process can handle")
def test_handlers_of_others_stay(tmp_path):
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    with written_whole(tmp_path / "a.txt"):
        assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
        with written_whole(tmp_path / "b.txt"):
            pass
        assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    try:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        with written_whole(tmp_path / "a.txt"):
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def test_a_link_is_kept_and_a_device_is_written_to(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with written_whole(tmp_path / "link") as file:
        file.write("x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "x"
    with written_whole(os.devnull) as file:
        file.write("x")
    assert not os.path.isfile(os.devnull)


def test_where_nothing_can_be_written(tmp_path):
    with pytest.raises(AttitudeError, match="is a folder"), written_whole(tmp_path):
        pass
    lost = written_whole(tmp_path / "no" / "a.txt")
    with pytest.raises(AttitudeError, match="cannot be written: No such file"), lost:
        pass


# Published states ---------------------------------------------------------------------------------

PUBLISHED = """
[body]
A_over_C = 0.61
B_over_C = 0.965
[spin]
mode = "SAM"
convention = "S"
P_psi = "263 h"
P_phi = "27.38 h"
pole = "250, -75 deg"
phi0 = "152 deg"
psi0 = "14 deg"
epoch = "2012-12-23"
"""


def test_a_published_state_is_a_spin():
    found = spin_file.parse(PUBLISHED).motion.published("S")
    assert found.mode == "SAM" and found.frame == "ecliptic"
    np.testing.assert_allclose(found.moment_ratios, [0.61, 0.965], rtol=1e-12)
    np.testing.assert_allclose(np.degrees(found.pole), [250.0, -75.0], rtol=1e-12)
    assert found.P_psi == pytest.approx(263 * 3600.0, rel=1e-12)
    assert found.P_phi == pytest.approx(27.38 * 3600.0, rel=1e-12)
    assert np.degrees([found.phi0, found.psi0]) == pytest.approx([152.0, 14.0], abs=1e-9)


def test_a_relaxed_rotator_of_a_shape_and_a_density(tmp_path):
    mesh = shape.box((2.0, 1.0, 3.0)).moved((0.1, 0.0, 0.0))
    mesh.write(tmp_path / "box.obj")
    text = (
        '[body]\ndensity = "2.5 g/cm3"\n[shape]\nfile = "box.obj"\n'
        '[spin]\nP = "4.3 h"\npole = "250, -75 deg"\nphi0 = "152 deg"\nepoch = "2012-12-23"\n'
    )
    (tmp_path / "box.toml").write_text(text)
    body = Body.from_shape(mesh, density=2500.0)
    spin = Spin.from_periods(
        body, P="4.3 h", pole="250, -75 deg", phi0="152 deg", epoch="2012-12-23"
    )
    for found in (
        spin_file.read(tmp_path / "box.toml"),
        mission.read_motion(tmp_path / "box.toml"),
    ):
        np.testing.assert_allclose(found.body.tensor, body.tensor, rtol=1e-12, atol=1e-6)
        np.testing.assert_allclose(found.body.center_of_mass, (0.1, 0.0, 0.0), atol=1e-12)
        np.testing.assert_allclose(found.spin.wxyz_icrf, spin.wxyz_icrf, atol=1e-15)
    for old, new, words in (
        ('[shape]\nfile = "box.obj"\n', "", "density is that of a section .shape."),
        ("phi0", 'mode = "SAM"\nphi0', "P is the one period of a relaxed rotator; leave out mode"),
        ('phi0 = "152 deg"\n', "", "no phi0"),
    ):
        with pytest.raises(AttitudeError, match=words):
            spin_file.parse(text.replace(old, new), folder=str(tmp_path))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('P_phi = "27.38 h"\n', "", r"\[spin\] has no P_phi; give it, for example as P_phi"),
        ('mode = "SAM"\n', "", r"\[spin\] has no mode"),
        ("B_over_C = 0.965\n", "", r"\[body\] has no B_over_C"),
        ("A_over_C = 0.61\n", "", r"\[body\] has no A_over_C; give it, for example as A_over_C"),
        (
            'phi0 = "152 deg"',
            'wxyz = [1, 0, 0, 0]\nphi0 = "152 deg"',
            "does not go",
        ),
        ('"250, -75 deg"', '"250 deg"', r"\[spin\] pole is one number"),
        ('"SAM"', '"PAM"', "mode"),
        ('"263 h"', '"263 kg"', "give it in s"),
        ("psi0 =", "psi_0 =", "did you mean 'psi0'"),
    ],
)
def test_published_states_that_are_wrong(old, new, words):
    assert old in PUBLISHED
    with pytest.raises(AttitudeError, match=words):
        spin_file.parse(PUBLISHED.replace(old, new))


# The shape in the file ----------------------------------------------------------------------------


def _shown(folder, text):
    (folder / "mission.toml").write_text(text)
    return mission.read(folder / "mission.toml").scene


def test_the_shape_is_kept_and_missions_take_it(tmp_path):
    motion = catalog.entry("toutatis").motion()
    mesh = shape.Ellipsoid((2.3, 1.2, 1.0)).facets(80)
    law = scattering.LommelSeeligerLambert(c=0.1, a=0.0, k=0.0)
    spin_file.write(tmp_path / "found.toml", motion, shape=mesh, law=law)
    found = spin_file.read(tmp_path / "found.toml")
    assert np.array_equal(found.shape.vertices, mesh.vertices)
    assert np.array_equal(found.shape.facets, mesh.facets) and found.law == law
    spin_file.write(tmp_path / "again.toml", found)
    assert (tmp_path / "again.toml").read_text() == (tmp_path / "found.toml").read_text()

    rest = (
        'observer.direction = [1, 0, 0]\nsun.direction = [0, 1, 0]\ntimes.epochs = ["1993-01-01"]'
    )
    scene = _shown(tmp_path, f'spin = "found.toml"\n{rest}')
    assert np.array_equal(scene.shape.vertices, mesh.vertices) and scene.law == law
    other = _shown(tmp_path, f'spin = "found.toml"\n{rest}\nshape.ellipsoid = "3, 2, 1 km"')
    assert isinstance(other.shape, shape.Ellipsoid) and other.law.name == "lommel-seeliger"
    lambert = _shown(tmp_path, f'spin = "found.toml"\n{rest}\nscattering.law = "lambert"')
    assert lambert.law.name == "lambert" and len(lambert.shape) == len(mesh)


def test_materials_and_ellipsoids_are_kept(tmp_path):
    motion = catalog.entry("toutatis").motion()
    both = shape.box((1, 2, 3), material="foil").joined(
        shape.box((1, 1, 1), material="solar panel").moved((5, 0, 0))
    )
    law = scattering.Materials(
        {"foil": scattering.Material(0.3, 0.2), "solar panel": scattering.Material(0.1)}
    )
    spin_file.write(tmp_path / "a.toml", motion, shape=both, law=law)
    found = spin_file.read(tmp_path / "a.toml")
    assert found.shape.materials == both.materials
    assert found.law["foil"] == law["foil"] and found.law.names == law.names
    spin_file.write(tmp_path / "b.toml", motion, shape=shape.Ellipsoid((3, 2, 1)))
    assert spin_file.read(tmp_path / "b.toml").shape.semi_axes.tolist() == [3.0, 2.0, 1.0]
    both.write(tmp_path / "body.obj")
    text = spin_file.text(motion) + '[shape]\nfile = "body.obj"\n[scattering]\nlaw = "lambert"\n'
    (tmp_path / "c.toml").write_text(text)
    assert spin_file.read(tmp_path / "c.toml").shape.materials == both.materials


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ('[scattering]\nlaw = "lambert"', "no .shape."),
        ('[shape]\nfile = "none.obj"', "no such file"),
        ("[shape]\nfile = 3", "give the name of a file"),
        ("[shape.mesh]\nvertices = [[0, 0, 0]]", "has no facets"),
        ("[shape.mesh]\nvertices = [[0, 0, 0]]\nfacets = [[0, 1, 2]]", "do not exist"),
        ("[shape]\nball = 3", "ball"),
        ("[shape]\nbox = [1, 2, 3]\nshadows = false", "mission file"),
    ],
)
def test_wrong_shapes_are_refused(tmp_path, lines, sentence):
    path = tmp_path / "a.toml"
    path.write_text(spin_file.text(catalog.entry("toutatis").motion()) + lines + "\n")
    with pytest.raises(AttitudeError, match=sentence) as error:
        spin_file.read(path)
    assert str(error.value).startswith(str(path))


def test_a_law_without_a_name_or_a_shape_is_not_written(tmp_path):
    motion = catalog.entry("toutatis").motion()

    class Nameless(scattering.Lambert):
        name = None

    for settings in ({"law": scattering.Lambert()}, {"shape": "ball"}):
        with pytest.raises(AttitudeError):
            spin_file.write(tmp_path / "a.toml", motion, **settings)
    with pytest.raises(AttitudeError, match="has no name"):
        spin_file.write(tmp_path / "a.toml", motion, shape=shape.box((1, 2, 3)), law=Nameless())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("module", "name", "ending"),
    [
        ("spin_file", "m.obj", "a shape"),
        ("spin_file", "m.aem", "AEM"),
        ("spin_file", "m.html", "a page"),
        ("aem", "m.toml", "spin file"),
        ("aem", "m.csv", "tables"),
        ("apm", "m.aem", "AEM"),
        ("stk", "m.png", "a picture"),
        ("quat", "m.bc", "SPICE"),
        ("damit", "m.toml", "spin file"),
    ],
)
def test_writers_refuse_the_endings_of_others(tmp_path, module, name, ending):
    writer = importlib.import_module(f"attitude.formats.{module}")
    with pytest.raises(AttitudeError, match=f"is the ending of.*{ending}"):
        writer.write(tmp_path / name, catalog.entry("toutatis").motion())
    assert list(tmp_path.iterdir()) == []
