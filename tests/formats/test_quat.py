"""Plain tables of quaternions, and the registry in which a format is one file."""

import re

import numpy as np
import pytest

import attitude
from attitude import AttitudeError, Body, FreeRotation, Spin, cli
from attitude.cli import _options
from attitude.formats import _format, detect, quat, spin_file
from attitude.frames import quaternion
from benchmarks import doc_tables, file_formats
from tests.support.places import ROOT

MOTION = FreeRotation(
    Body(moments=(10, 20, 26)),
    Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.001, 0.002, 0.015)),
)
T = np.arange(0.0, 61.0, 10.0)
HISTORY = MOTION.at(T)
# The same in seconds of UTC, in which the command steps.
STEPS = MOTION.at([f"2026-01-01T00:0{k // 60}:{k % 60:02d}" for k in range(0, 61, 10)])


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def test_numbers_written_come_back_with_the_same_bits(tmp_path):
    path = tmp_path / "a.quat"
    quat.write(path, MOTION, t=T)
    assert path.read_text().startswith("# time w x y z frame=ICRF\n2026-01-01T00:00:00.0")
    found = quat.read(path)
    assert np.array_equal(found.wxyz, HISTORY.wxyz) and found.angular_velocity is None
    off = (found.epoch.seconds - MOTION.epoch.seconds) + (found.epoch.low - MOTION.epoch.low)
    assert np.max(np.abs(found.seconds + off - T)) <= 5e-13  # s: 12 decimals


@pytest.mark.parametrize("order", ["w x y z", "x y z w"])
@pytest.mark.parametrize("direction", ["", " body-to-reference", " reference-to-body"])
@pytest.mark.parametrize("in_seconds", [True, False])
def test_orders_directions_and_times(tmp_path, order, direction, in_seconds):
    """A quarter turn about z, from body to reference: x of the body is y of the reference."""
    scalar, last = np.sqrt(0.5), np.sqrt(0.5) * (-1.0 if "reference-to" in direction else 1.0)
    numbers = {"w": scalar, "x": 0.0, "y": 0.0, "z": float(last)}
    row = " ".join(repr(float(numbers[each])) for each in order.split())
    times = ("0", "2.5") if in_seconds else ("2026-01-01T00:00:00", "2026-001T00:00:02.5Z")
    header = f"# time {order}{direction}" + (" epoch=2026-01-01T00:00:00" if in_seconds else "")
    path = tmp_path / "lab.txt"  # recognized by its first line
    path.write_text("\n".join([header, "# made by hand", *(f"{t} {row}" for t in times)]) + "\n")
    found = detect.read(path)
    assert found.epoch.utc_iso == "2026-01-01T00:00:00"
    # TDB and UTC differ in rate by up to 3.4e-10.
    assert np.allclose(found.seconds, [0.0, 2.5], rtol=0, atol=1e-12 if in_seconds else 1e-9)
    assert np.allclose(quaternion.rotate(found.wxyz[0], np.array([1.0, 0, 0])), [0, 1, 0])


def test_other_axes(tmp_path):
    quat.write(tmp_path / "a.quat", HISTORY, frame="EME2000")
    text = (tmp_path / "a.quat").read_text()
    assert text.startswith("# time w x y z frame=EME2000\n")
    assert apart(quat.read(tmp_path / "a.quat").wxyz, HISTORY.wxyz) < 1e-15
    bias = apart(quat.read(tmp_path / "a.quat", frame="ICRF").wxyz, HISTORY.wxyz)
    assert 1.0e-7 < bias < 1.3e-7  # rad: 23 mas


def test_a_motion_to_a_tolerance(tmp_path):
    made = quat.write(tmp_path / "a.quat", MOTION, start=0.0, stop=600.0, tolerance=1e-9)
    assert made.error <= 1e-9
    t = np.linspace(1.0, 599.0, 97)
    assert (
        apart(quat.read(tmp_path / "a.quat").at(MOTION.at(t).time).wxyz, MOTION.at(t).wxyz) < 2e-9
    )


def test_the_command_converts_from_and_to_it(tmp_path, capsys):
    spin_file.write(tmp_path / "in.toml", MOTION)
    steps = ["--stop", "60", "--step", "10"]
    for given, made, *words in (
        ("in.toml", "a.quat", *steps, "--frame", "EME2000"),
        ("a.quat", "b.aem"),
        ("b.aem", "c.quat"),
        ("c.quat", "d.toml", "--fit"),
    ):
        names = [str(tmp_path / given), str(tmp_path / made)]
        assert cli.main(["convert", *names, *words]) == 0, capsys.readouterr().err
    assert apart(detect.read(tmp_path / "c.quat").wxyz, STEPS.wxyz) < 1e-13
    words = [str(tmp_path / "in.toml"), str(tmp_path / "e.quat"), *steps, "--version", "2.0"]
    assert cli.main(["convert", *words]) == 2
    assert "--version has no meaning for a table of quaternions" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "line 1: it must name the columns"),
        ("# time w x y\n", "line 1: it must name the columns"),
        ("# time w x y z inverse\n", "line 1: 'inverse' is not known"),
        ("# time w x y z epoch=soon\n", "line 1: epoch 'soon'"),
        ("# time w x y z frame=FOO\n", "line 1: frame is 'FOO'; known axes are"),
        ("# time w x y z frame=ICRF frame=ITRF\n", "line 1: 'frame=ITRF' is a second frame"),
        (
            "# time w x y z body-to-reference reference-to-body\n",
            "line 1: 'reference-to-body' is a second direction",
        ),
        ("# time w x y z\n", "has no attitudes"),
        ("# time w x y z\n0 1 0 0 0\n", "line 2: its time is in seconds"),
        ("# time w x y z epoch=2026-01-01T00:00:00\n0 1 0 0\n", "line 2: it has 4 entries"),
        ("# time w x y z epoch=2026-01-01T00:00:00\n0 1 0 0 a\n", "line 2: 'a' is no number"),
        ("# time w x y z epoch=2026-01-01T00:00:00\n0 2 0 0 0\n", "line 2: the length"),
        ("# time w x y z epoch=2026-01-01T00:00:00\n1 1 0 0 0\n1 1 0 0 0\n", "line 3: the epoch"),
        ("# time w x y z epoch=2026-01-01T00:00:00\nnan 1 0 0 0\n", "line 2: it holds a number"),
        ("# time w x y z\n2026-01-01T00:00:00 1 0 0 0\n5 1 0 0 0\n", "line 3: the epoch '5'"),
        ("# time w x y z\n2026-02-30T00:00:00 1 0 0 0\n", "line 2: the epoch"),
    ],
)
def test_what_is_refused(tmp_path, text, sentence):
    path = tmp_path / "a.quat"
    path.write_text(text)
    with pytest.raises(AttitudeError, match=re.escape(sentence)):
        detect.read(path)


def test_one_segment_only(tmp_path):
    with pytest.raises(AttitudeError, match="a table of quaternions holds one"):
        quat.write(tmp_path / "a.quat", [HISTORY[:3], HISTORY[4:]])
    assert not (tmp_path / "a.quat").exists()


# The registry -------------------------------------------------------------------------------------


def test_the_tables_of_the_docs_are_those_of_the_registry():
    """Names and endings as they are registered; conventions of each module, and of no other."""
    page = (ROOT / "docs" / "formats.md").read_text("utf-8")
    tables = {table.name: table.text for table in file_formats.tables(quick=True)}
    assert doc_tables.replaced(page, tables) == page
    conventions = page[page.index("| format | read | written |") :].split("\n\n")[0]
    firsts = [row.split("|")[1] for row in conventions.splitlines()[2:]]
    documented = {re.search(r"\(`(\w+)`", first).group(1) for first in firsts}
    assert documented == set(attitude.FORMAT_MODULES)


def test_every_file_that_registers_is_named():
    folder = ROOT / "attitude" / "formats"
    files = {file.stem for file in folder.glob("*.py") if "\nregister" in file.read_text("utf-8")}
    assert files == set(attitude.FORMAT_MODULES)


def test_options_that_writers_take_exist_once():
    names = [each.attribute for each in _options.of_formats()]
    assert len(set(names)) == len(names)
    known = {*names, "orbit", "tolerance"}  # of the command itself
    for each in _format.formats().values():
        assert set(each.writing) <= known, each.name
        assert set(each.fulfilled) <= known, each.name
        assert set(each.renamed) <= set(each.writing), each.name


def test_a_format_that_is_registered_is_detected_and_converted(tmp_path, capsys):
    """As a notebook may do: nothing else knows the format."""

    def read(path):
        return _format.of_table(quat.read(path, frame="EME2000"))

    def write(path, source, *, t=None, loud=False):
        quat.write(path, source, t=t, frame="EME2000")
        if loud:
            print("written")

    made = {"module": __name__, "read": read, "reading": (), "write": write, "is_sampled": False}
    made |= {"title": "of a test", "writing": ("loud",)}
    option = _format.Option("loud", "print a word", {"action": "store_true"})
    _format.register(_format.Format("mine", endings=(".mine",), options=(option,), **made))
    try:
        spin_file.write(tmp_path / "in.toml", MOTION)
        out = [str(tmp_path / "a.mine"), "--stop", "60", "--step", "10", "--loud"]
        assert cli.main(["convert", str(tmp_path / "in.toml"), *out]) == 0
        assert capsys.readouterr().out == "written\n"
        assert detect.to_write("x.mine") == "mine"
        (tmp_path / "a.mine").write_text((tmp_path / "a.mine").read_text().replace("# ", ""))
        assert apart(detect.read(tmp_path / "a.mine").wxyz, STEPS.wxyz) < 1e-15
        with pytest.raises(AttitudeError, match=r"share '\.a'"):
            _format.register(_format.Format("other", endings=(".a",), **made))
        out[0] = str(tmp_path / "a.csv")
        assert cli.main(["convert", str(tmp_path / "in.toml"), *out]) == 2
        assert "--loud has no meaning for a table" in capsys.readouterr().err
    finally:
        _format.forget("mine")
    with pytest.raises(AttitudeError, match="belongs to no format"):
        detect.to_write("x.mine")
    with pytest.raises(AttitudeError, match="no format is called 'mine'"):
        _format.forget("mine")
