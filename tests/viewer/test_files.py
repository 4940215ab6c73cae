"""Animations and files for other viewers, each opened by a reader of another project."""

import itertools
import json
import shutil
import warnings

import numpy as np
import pytest

from attitude import Body, FreeRotation, Scene, Spin, cli, paths, shape
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.frames import quaternion
from attitude.viewer import _animation, _subject, animate, write_cosmographia, write_czml, write_glb
from tests.support.places import ROOT

TLE = ROOT / "data" / "paths" / "envisat-2013.tle"


def tumbler():
    spin = Spin(epoch="2013-10-23", wxyz=(0.5, 0.5, -0.5, 0.5), angular_velocity=(0.02, 0.05, 0.01))
    return FreeRotation(Body(moments=(10, 20, 26)), spin)


def orbiting():
    return Scene(tumbler(), paths.tle(TLE), shape=shape.box((10, 4, 4)))


def lit():
    body = shape.Ellipsoid((2.0, 1.2, 1.0))
    return Scene(tumbler(), None, observer=(1, 0.2, 0.1), sun=(0.3, 1, 0.2), shape=body)


def angle(p, q):
    off = quaternion.multiply(quaternion.conjugate(p), q)
    return np.degrees(2.0 * np.arctan2(np.linalg.norm(off[..., 1:], axis=-1), np.abs(off[..., 0])))


def slerped(keys, turns, times):
    """Attitudes wxyz along great circles between rows x, y, z, w; by scipy."""
    from scipy.spatial.transform import Rotation, Slerp

    found = Slerp(keys, Rotation.from_quat(turns))(times).as_quat()
    return found[:, [3, 0, 1, 2]]


def test_czml_is_that_of_the_motion(tmp_path):
    """Against skyfield's rotation of the Earth, and read by the models of czml3."""
    path = tmp_path / "envisat.czml"
    write_czml(path, orbiting(), stop=1200.0, title="Envisat")
    document, body = json.loads(path.read_text())
    assert document["version"] == "1.0" and body["position"]["referenceFrame"] == "INERTIAL"
    rows = np.array(body["orientation"]["unitQuaternion"]).reshape(-1, 5)
    times = np.linspace(0.0, 1200.0, 301)
    made = slerped(rows[:, 0], rows[:, 1:], times)

    from skyfield.api import load
    from skyfield.framelib import itrs

    history = tumbler().at(times)
    moments = load.timescale(builtin=True).tdb_jd(history.time.jd)
    turn = np.moveaxis(itrs.rotation_at(moments), -1, 0)  # ICRF to ITRS
    expected = quaternion.multiply(quaternion.from_matrix(turn), history.wxyz)
    assert angle(made, expected).max() < 0.1
    place = np.array(body["position"]["cartesian"]).reshape(-1, 4)
    orbit = orbiting().center.position(tumbler().epoch, place[:, 0])
    assert np.allclose(place[:, 1:], orbit, rtol=0, atol=1e-3)


def test_czml_is_read_by_another_parser(tmp_path):
    czml3 = pytest.importorskip("czml3", reason="czml3 is not installed")
    properties = pytest.importorskip("czml3.properties")
    path = tmp_path / "envisat.czml"
    write_czml(path, orbiting(), stop=600.0, model="https://example.org/envisat.glb")
    document, body = json.loads(path.read_text())
    assert czml3.Packet(**document).version == "1.0"
    assert properties.Orientation(**body["orientation"]).unitQuaternion is not None
    assert czml3.Packet(**body).model is not None


@pytest.mark.parametrize("scene", [tumbler(), lit()], ids=["no path", "directions"])
def test_czml_needs_an_orbit_of_the_earth(tmp_path, scene):
    with pytest.raises(AttitudeError, match="a path about the Earth"):
        write_czml(tmp_path / "x.czml", scene)


def test_glb_is_read_by_pygltflib_and_trimesh(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "body.glb"
    ball = shape.Ellipsoid((3.0, 2.0, 1.0)).facets(500)
    write_glb(path, tumbler(), stop=600.0, shape=ball, title="body", speed=10.0)
    mesh = trimesh.load(path, force="scene")
    found = next(iter(mesh.geometry.values()))
    assert found.is_watertight and found.volume == pytest.approx(ball.volume, rel=1e-6)
    assert np.allclose(found.vertices, ball.vertices, atol=1e-6)

    pygltflib = pytest.importorskip("pygltflib", reason="pygltflib is not installed")
    content = pygltflib.GLTF2().load(path)
    sampler = content.animations[0].samplers[0]
    keys, turns = (accessor(content, each) for each in (sampler.input, sampler.output))
    times = np.linspace(0.0, 600.0, 200)
    made = slerped(keys[:, 0].astype(float), turns, np.minimum(times / 10.0, keys[-1, 0]))
    assert angle(made, tumbler().at(times).wxyz).max() < 0.12  # float32 times add to 0.1


def accessor(content, k):
    """An array of a glTF file, float32."""
    one = content.accessors[k]
    part = content.bufferViews[one.bufferView]
    data = content.binary_blob()[part.byteOffset : part.byteOffset + part.byteLength]
    return np.frombuffer(data, "<f4").reshape(one.count, -1)


def test_glb_passes_the_validator(tmp_path):
    """Khronos' validator, where node and the npm package gltf-validator are installed."""
    import os
    import subprocess

    node, folder = shutil.which("node"), os.environ.get("GLTF_VALIDATOR")
    if node is None or folder is None:
        pytest.skip("GLTF_VALIDATOR does not name the folder of the npm package gltf-validator")
    path = tmp_path / "body.glb"
    write_glb(path, tumbler(), stop=600.0)
    code = (
        "require(process.argv[1]).validateBytes(new Uint8Array(require('fs').readFileSync("
        "process.argv[2]))).then(r => console.log(JSON.stringify(r.issues)))"
    )
    run = subprocess.run([node, "-e", code, folder, path], capture_output=True, text=True)
    issues = json.loads(run.stdout)
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]


def test_cosmographia_is_beside_a_c_kernel_that_spice_reads(tmp_path):
    spiceypy = pytest.importorskip("spiceypy")
    path = tmp_path / "envisat.json"
    write_cosmographia(path, orbiting(), stop=1200.0, title="Envisat 2013")
    catalogue = json.loads(path.read_text())
    (item,) = catalogue["items"]
    for name in (
        *catalogue["spiceKernels"],
        item["geometry"]["source"],
        item["trajectory"]["source"],
    ):
        assert (tmp_path / name).is_file()
    assert item["center"] == "Earth" and item["geometry"]["size"] == pytest.approx(
        np.linalg.norm([5, 2, 2]) / 1000
    )
    for name in catalogue["spiceKernels"]:
        spiceypy.furnsh(str(tmp_path / name))
    try:
        history = tumbler().at(np.linspace(1.0, 1199.0, 20))
        matrices = [
            spiceypy.pxform(item["bodyFrame"]["name"], "J2000", each)
            for each in history.epoch.seconds + history.seconds
        ]
    finally:
        spiceypy.kclear()
    assert np.allclose(matrices, history.matrix, rtol=0, atol=3e-6)
    rows = np.loadtxt(tmp_path / item["trajectory"]["source"])
    assert np.allclose(np.linalg.norm(rows[:, 1:4], axis=1), 7150, atol=60)  # km
    trimesh = pytest.importorskip("trimesh")
    assert trimesh.load(tmp_path / item["geometry"]["source"]).is_watertight


@pytest.mark.filterwarnings("error")
def test_trajectories_of_long_spans_are_dense(monkeypatch):
    """Of 10 days of Envisat: cubic Hermite curves between states, as Cosmographia's."""
    from scipy.interpolate import CubicHermiteSpline

    path, what = orbiting().center, _subject.subject(tumbler(), stop=864000.0)
    curve = CubicHermiteSpline(*_subject.trajectory(what, path))
    times = np.random.default_rng(1).uniform(0.0, what.duration, 4000)
    off = np.linalg.norm(curve(times) - path.position(what.start, times), axis=1)
    assert off.max() < 10.0  # m
    monkeypatch.setattr(_subject, "_MOST_STATES", 2001)
    with pytest.warns(AttitudeWarning, match="positions are 432 s apart, and off by up to .* m"):
        _subject.trajectory(what, path)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_catalogues_of_cosmographia_are_loaded_together(tmp_path, order):
    spiceypy = pytest.importorskip("spiceypy")
    motions, names = (tumbler(), lit()), ("B_4179_TOUTATIS", "B__RIS")
    for k, title in enumerate(("4179 Toutatis", "Éris")):
        write_cosmographia(tmp_path / f"{k}.json", motions[k], stop=100.0 + 500.0 * k, title=title)
        (item,) = json.loads((tmp_path / f"{k}.json").read_text())["items"]
        assert item["bodyFrame"]["name"] == names[k]
    try:
        for k in order:
            spiceypy.furnsh([str(tmp_path / f"{k}.{ending}") for ending in ("tsc", "tf", "bc")])
        for k, time in ((0, 50.0), (1, 500.0)):
            history = tumbler().at(time)
            matrix = spiceypy.pxform(names[k], "J2000", history.epoch.seconds + time)
            assert np.allclose(matrix, history.matrix, rtol=0, atol=3e-6)
            assert spiceypy.frinfo(spiceypy.namfrm(names[k]))[0] == 10  # the Sun
    finally:
        spiceypy.kclear()


@pytest.mark.parametrize("ending", ["webp", "gif"])
def test_an_animation_shows_the_turning_body(tmp_path, ending):
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    path = tmp_path / f"a.{ending}"
    done = []
    animate(lit(), path, stop=60.0, frames=5, size=(200, 180), progress=lambda *n: done.append(n))
    assert done == [(k, 5) for k in range(1, 6)]
    with image.open(path) as film:
        assert (film.n_frames, film.size) == (5, (200, 180))
        frames = []
        for k in range(5):
            film.seek(k)
            frames.append(np.asarray(film.convert("L"), dtype=float))
    # The body is drawn, and the curve grows: pixels change from frame to frame.
    assert all((each > 100).sum() > 300 for each in frames)
    assert all(np.abs(a - b).max() > 60 for a, b in itertools.pairwise(frames))


def test_an_animation_as_mp4(tmp_path):
    if shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed")
    path = tmp_path / "a.mp4"
    title = r"Cubesat $\foo$ 3"  # which is no mathematics
    for rate in (0.5, 20.0):
        animate(tumbler(), path, stop=60.0, title=title, frames=4, rate=rate, size=(160, 160))
        assert path.read_bytes()[4:8] == b"ftyp"


@pytest.mark.filterwarnings("ignore:the animation has a frame")
def test_the_clock_of_an_animation():
    """Seconds of TDB are some nanoseconds short of those of UTC."""
    for stop, end in ((20.0, "00:00:20"), (72000.0, "20:00")):
        picture = _animation._Picture(_subject.subject(tumbler(), stop=stop), 11, (160, 160))
        assert picture.utc[-1] == f"2013-10-23 {end}"


def test_frames_that_skip_turns_are_said(tmp_path):
    pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    with pytest.warns(AttitudeWarning, match=r"a frame every 200 s.* or frames at most \d"):
        animate(tumbler(), tmp_path / "a.gif", stop=400.0, frames=3, size=(160, 160))


def test_bad_outputs_are_sentences(tmp_path, capsys):
    for write, ending in ((write_glb, "glb"), (write_czml, "czml"), (write_cosmographia, "json")):
        with pytest.raises(AttitudeError, match=rf"ends in \.{ending}\."):
            write(tmp_path / "a.foo", orbiting())
    assert not list(tmp_path.iterdir())
    with pytest.raises(AttitudeError, match=r"ends in \.webp or \.gif or \.mp4"):
        animate(tumbler(), tmp_path / "a.avi")
    with pytest.raises(AttitudeError, match="rate is 1e-06 frames a second; give"):
        animate(tumbler(), tmp_path / "a.gif", rate=1e-6)
    assert cli.main(["view", "toutatis", "--output", "x.pdf"]) == 2
    assert ".czml" in capsys.readouterr().err
    both = ["view", "toutatis", "--output", "x.html", "--animate", "x.gif"]
    assert cli.main(both) == 2


def test_the_command_writes_them(tmp_path):
    pytest.importorskip("PIL")
    mission = str(ROOT / "data" / "mission" / "envisat-pass.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        out = tmp_path / "e.czml"
        assert cli.main(["view", mission, "--output", str(out)]) == 0
        assert len(json.loads(out.read_text())) == 2
        out = tmp_path / "t.webp"
        arguments = ["--stop", "2 d", "--frames", "3"]
        assert cli.main(["view", "toutatis", "--animate", str(out), *arguments]) == 0
        assert out.read_bytes()[8:12] == b"WEBP"
        out = tmp_path / "t.glb"
        assert cli.main(["view", "toutatis", "--output", str(out), "--stop", "2 d"]) == 0
        assert out.read_bytes()[:4] == b"glTF"


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["webp", "gif", "mp4"])
def test_an_animation_of_the_default_size_is_below_two_megabytes(ending, tmp_path):
    """Toutatis with axes, momentum, clock and light curve, as `attitude view` draws it."""
    if ending == "mp4" and shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed")
    pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    path = tmp_path / f"t.{ending}"
    assert cli.main(["view", "toutatis", "--animate", str(path)]) == 0
    assert 50_000 < path.stat().st_size < 2_000_000
