"""Pages without a browser: what they hold, how large they are, and what is refused."""

import base64
import json
import re
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from attitude import (
    Arcs,
    AttitudeTable,
    Body,
    FreeRotation,
    Impulse,
    Scene,
    Spin,
    catalog,
    cli,
    epochs,
    shape,
)
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.formats import mission
from attitude.frames import quaternion
from attitude.viewer import _page, _subject, view
from attitude.viewer._subject import subject
from tests.support.places import ROOT

DAY = 86400.0
FLIP = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.001, 1, 0.001))


def toutatis():
    return catalog.entry("toutatis").motion()


def content(page):
    """The value that a page holds."""
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.html, re.S)
    return json.loads(text.group(1))


def array(text, kind, width):
    return np.frombuffer(base64.b64decode(text), kind).reshape(-1, width)


def slerp_error(what, count=3000):
    """Largest angle, degrees, between great circles of a page and the motion."""
    worst = 0.0
    for piece in _subject.pieces(what):
        rows = np.random.default_rng(1).integers(0, len(piece.wxyz) - 1, count)
        part = np.random.default_rng(2).random(count)
        ends = [np.rint(piece.wxyz[rows + k] * 32767.0) for k in (0, 1)]
        ends = [each / np.linalg.norm(each, axis=1)[:, None] for each in ends]
        dot = np.sum(ends[0] * ends[1], axis=1)
        omega = np.arccos(np.clip(np.abs(dot), 0, 1))
        sine = np.maximum(np.sin(omega), 1e-12)
        weights = np.sin((1 - part) * omega) / sine, np.sign(dot) * np.sin(part * omega) / sine
        made = weights[0][:, None] * ends[0] + weights[1][:, None] * ends[1]
        made /= np.linalg.norm(made, axis=1)[:, None]
        true = what.at(piece.start + (rows + part) * piece.step).wxyz
        off = quaternion.multiply(quaternion.conjugate(true), made)
        angles = 2 * np.arctan2(np.linalg.norm(off[:, 1:], axis=1), np.abs(off[:, 0]))
        worst = max(worst, np.degrees(angles).max())
    return worst


@pytest.mark.parametrize(
    "what",
    [
        subject(toutatis(), stop=30 * DAY),
        subject(catalog.entry("envisat").motion(), stop=3600.0),
        subject(FreeRotation(Body(moments=(10, 20, 26)), FLIP), stop=300.0),
        subject(FreeRotation(Body(moments=(1, 1, 1)), FLIP), stop=300.0),
        subject(toutatis(), start="2004-01-01", stop="2004-02-01"),
    ],
    ids=["toutatis", "envisat", "flip", "uniform", "later"],
)
def test_great_circles_stay_within_a_tenth_of_a_degree(what):
    assert slerp_error(what) < 0.1


def test_a_uniform_rotation_needs_few_attitudes():
    """The step is as wide as the motion allows: of a uniform rotation 2 rad, not its period."""
    what = subject(FreeRotation(Body(moments=(1, 1, 1)), FLIP), stop=300.0)
    (piece,) = _subject.pieces(what)
    assert len(piece.wxyz) == 152


def test_thirty_days_of_toutatis_are_small():
    """Below 300 kB beside the library, with Sun, observer, light curve and mesh."""
    body = shape.Ellipsoid((2.1, 1.2, 1.0)).facets(1000)
    scene = Scene(toutatis(), None, observer=(1, 0.2, 0.1), sun=(0.3, 1, 0.2), shape=body)
    made = view(scene, stop=30 * DAY)
    library = len((_page.FOLDER / "three" / "three.min.js").read_text())
    assert len(made.html) - library < 300_000
    data = content(made)
    # 2592000 s of TDB are 0.7 ms less of UTC.
    assert data["utc"] == ["1992-11-09T17:49:47", "1992-12-09T17:49:46.999333959"]
    times = array(data["curve"]["times"], "<f8", 1)[:, 0]
    values = array(data["curve"]["values"], "<f4", 1)[:, 0]
    expected = scene.at(times).reduced_magnitude
    assert np.allclose(values, expected, rtol=0, atol=1e-5)
    assert data["curve"]["label"] == "reduced magnitude"


def test_a_scene_is_shown_as_it_is_received():
    """The attitude at a time of the page is that of the light that arrives."""
    made = cli_page("data/mission/apophis-2012.toml", "--stop", "2012-12-12")
    from attitude.formats import mission

    scene = mission.read(str(ROOT / "data/mission/apophis-2012.toml")).scene
    piece = made["poses"][0]
    row = 40
    wxyz = array(piece["wxyz"], "<i2", 4)[row].astype(float)
    wxyz /= np.linalg.norm(wxyz)
    from attitude import epochs

    start = epochs.instant("2012-12-02")
    seen = scene.since(start, np.array([piece["start"] + row * piece["step"]]))
    assert abs(seen.attitude.wxyz[0] @ wxyz) > 1.0 - 1e-8
    given = scene.motion.at(seen.seconds).wxyz[0]
    assert abs(given @ wxyz) < 1.0 - 1e-6  # without light time it is another attitude


def cli_page(*words, tmp="view.html"):
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / tmp
        first, *rest = words
        given = str(ROOT / first) if "/" in first else first
        assert cli.main(["view", given, *rest, "--output", str(out)]) == 0
        text = out.read_text()
    found = re.search(r'id="data">(.*?)</script>', text, re.S)
    return json.loads(found.group(1))


def test_the_command_takes_every_source():
    assert cli_page("toutatis", "--stop", "3 d")["duration"] == pytest.approx(3 * DAY)
    assert cli_page("data/spin/paper.toml")["poinsot"] is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AttitudeWarning)
        table = cli_page("tests/data/two-segments.aem")
    assert table["surface"]["kind"] == "box" and table["momentum"] is None
    lit = cli_page("toutatis", "--sun", "1, 0, 0", "--observer", "0, 1, 0", "--stop", "1 d")
    assert lit["curve"] is not None


def test_the_command_takes_a_c_kernel(tmp_path):
    pytest.importorskip("spiceypy")
    from attitude.formats import ck

    ck.write(tmp_path / "t.bc", toutatis(), 0.0, 2 * DAY, tolerance=1e-6)
    out = tmp_path / "t.html"
    arguments = ["--start", "1992-11-09T18:00:00", "--stop", "1992-11-10T18:00:00"]
    assert cli.main(["view", str(tmp_path / "t.bc"), *arguments, "--output", str(out)]) == 0
    assert out.stat().st_size > 500_000


def test_the_mesh_of_a_file(tmp_path):
    file = tmp_path / "body.obj"
    file.write_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    data = cli_page("toutatis", "--shape", str(file), "--unit", "km")
    assert data["surface"]["size"] == pytest.approx(2000.0)
    assert array(data["surface"]["facets"], "<u4", 3).shape == (4, 3)


def test_too_many_facets_are_drawn_with_fewer():
    ball = shape.Ellipsoid((1.0, 0.8, 0.7)).facets(80_000)
    what = subject(toutatis(), shape=ball)
    with pytest.warns(AttitudeWarning, match="79380 facets, of which a page draws 20000"):
        found = _subject.surface(what, 20_000)
    assert 8_000 < len(found.facets) <= 20_000
    # Still the same body: its extent and volume to a few cells.
    assert np.allclose(np.ptp(found.vertices, axis=0), [2.0, 1.6, 1.4], atol=0.05)
    a, b, c = np.moveaxis(found.vertices[found.facets], 1, 0)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 0.56, rel=0.02)


def test_a_body_at_rest_is_drawn():
    still = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0))
    data = content(view(FreeRotation(Body(moments=(1, 2, 3)), still)))
    assert data["momentum"] is None and data["poinsot"] is None and data["turns"] is False
    assert data["duration"] == 3600.0


def test_a_rod_is_drawn_without_poinsot():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 1, 0))
    data = content(view(FreeRotation(Body(moments=(0, 2, 2)), spin)))
    assert data["poinsot"] is None and data["surface"]["kind"] == "ellipsoid of inertia"


def test_impulses_make_pieces():
    motion = toutatis()
    arcs = Arcs(motion.body, motion.spin, Impulse(2 * DAY, 0.5 * motion.momentum, "icrf"))
    data = content(view(arcs, stop=4 * DAY))
    assert [each["start"] for each in data["poses"]] == [0.0, 2 * DAY]
    assert ["impulses", "1 in the span"] in data["facts"]
    before, after = (array(each["rates"], "<f4", 3) for each in data["poses"])
    expected = arcs.angular_velocity_at(np.array([2 * DAY - 1e-3, 2 * DAY]))
    assert np.allclose(before[-1], expected[0], rtol=1e-5)
    assert np.allclose(after[0], expected[1], rtol=1e-5)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"stop": 1e9 * 7 * DAY}, "needs .* attitudes"),
        ({"stop": np.nan}, "stop is nan; give one finite epoch"),
        ({"start": [0.0, np.nan]}, "start holds 2 epochs"),
        ({"start": 5.0, "stop": 5.0}, "give a stop after the start"),
        ({"shape": "toutatis.obj"}, "shape is str"),
        ({"output": "/nowhere/view.html"}, "/nowhere"),
        ({"output": "toutatis.pdf"}, "output is 'toutatis.pdf'; give a name that ends in .html or"),
        ({"output": 3}, "output is 3; give the name of a file"),
        ({"title": 3}, "title is 3; give text"),
    ],
)
def test_bad_input_is_a_sentence(settings, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        view(toutatis(), **settings)


def test_a_scene_without_a_motion_is_refused():
    with pytest.raises(AttitudeError, match="the scene has no motion"):
        view(Scene(None, None, (1, 0, 0), (0, 1, 0)))


def test_a_missing_shape_file_is_a_sentence(capsys):
    assert cli.main(["view", "toutatis", "--shape", "nowhere.obj"]) == 2
    assert "nowhere.obj" in capsys.readouterr().err


def test_a_table_needs_no_inertia():
    table = AttitudeTable("2026-01-01", [0, 10], [[1, 0, 0, 0], [0, 0, 0, 1]], method="slerp")
    data = content(view(table))
    assert data["duration"] == 10.0
    assert ["moments", "unknown: without them no momentum is drawn"] in data["facts"]


@pytest.mark.parametrize(
    "title",
    [
        "</script><b>&",
        "<!--<script>",
        "<!-- <SCRIPT",
        "</SCRIPT x>-->",
        "--><script>",
        "a\u2028b\u2029c",
        "{{script}}\\u003c",
    ],
)
def test_text_of_a_title_ends_no_script(title):
    """A parser of the HTML standard finds the same elements as with a plain title."""
    import html5lib

    made, plain = (
        html5lib.parse(view(toutatis(), title=text).html, namespaceHTMLElements=False)
        for text in (title, "plain")
    )
    assert [each.tag for each in made.iter()] == [each.tag for each in plain.iter()]
    assert made.find("head/title").text == title
    data, other = (each.find(".//script[@id='data']").text for each in (made, plain))
    assert json.loads(data)["title"] == title
    assert [each.text for each in made.iter("script") if each.text != data] == [
        each.text for each in plain.iter("script") if each.text != other
    ]
    assert not set(data) & {"<", "\u2028", "\u2029"}  # as text of JavaScript too


_PIECES = (
    *("<", "</", "<!--", "-->", "--!>", "<!", "<?", "]]>", "<![CDATA[", ">", "/", " ", "\n", "\r"),
    *("script", "SCRIPT", "ſcript", "style", "title", "textarea", "noscript", "svg", "plaintext"),
    *("&", "&lt;", "&amp", "&#60;", "&#x3c", '"', "'", "\\", "\\u003c", "\\n", "${", "`", "{{"),
    *("data", "}}", "{{data}}", "{{script}}", "\u2028", "\u2029", "\x0b", "\x1b", "\x7f", "\t"),
    *("\ufeff", "\u202e", "é", "漢", "🛰", "\\1", "\\g<0>", "%s", "id=", "onload=", "src", "x", "1"),
)


@pytest.mark.parametrize(
    "seed, count", [(35, 300), *(pytest.param(k, 5000, marks=pytest.mark.slow) for k in range(4))]
)
def test_hunt_of_titles(seed, count, monkeypatch):
    """Titles of one to twelve pieces: the page has the elements of a plain one, and the title."""
    import html5lib

    whole = _page._text  # the library and the style take most of the time of the parser
    short = {name: whole(name) for name in ("viewer.html", "three/LICENSE", "three/VERSION")}
    monkeypatch.setattr(_page, "_text", lambda name: short.get(name, "let one = 1;"))
    plain = html5lib.parse(_page.page({"title": "plain"}), namespaceHTMLElements=False)
    tags = [each.tag for each in plain.iter()]
    random = np.random.default_rng(seed)
    for _ in range(count):
        title = "".join(random.choice(_PIECES, random.integers(1, 13)))
        made = html5lib.parse(_page.page({"title": title}), namespaceHTMLElements=False)
        assert [each.tag for each in made.iter()] == tags, title
        # The standard makes one line feed of both ends of a line.
        as_text = title.replace("\r\n", "\n").replace("\r", "\n")
        assert (made.find("head/title").text or "") == as_text, title
        assert json.loads(made.find(".//script[@id='data']").text) == {"title": title}, title


def test_a_page_in_a_notebook_is_a_frame():
    assert "srcdoc" in view(toutatis())._repr_html_()


def test_the_library_is_whole_and_named():
    text = (_page.FOLDER / "three" / "three.min.js").read_text()
    assert f"three.js {_page.version()}" in text[:100]
    assert "MIT License" in (_page.FOLDER / "three" / "LICENSE").read_text()
    import runpy

    names = runpy.run_path(str(ROOT / "docs" / "make_three.py"))["NAMES"]
    sources = "".join((_page.FOLDER / f"{name}.js").read_text() for name in _page.SCRIPTS)
    used = set(re.findall(r"\bTHREE\.(\w+)", sources)) - {"OrbitControls"}
    assert used == set(names)
    assert {file.stem for file in _page.FOLDER.glob("*.js")} == set(_page.SCRIPTS)
    for file in _page.FOLDER.glob("*.js"):
        assert len(file.read_text().splitlines()) <= 400
    # Joined scripts share one scope: no two files define the same name.
    defined = re.findall(r"^(?:export )?(?:class|function|const|let) (\w+)", sources, re.M)
    assert len(defined) == len(set(defined))


def test_the_shade_is_that_of_the_scene():
    """Envisat leaves the Earth's shadow: at all seconds of 40 minutes, as the View has it."""
    scene = mission.read(ROOT / "data" / "mission" / "envisat-glints.toml").scene
    what = _subject.subject(scene, "2013-10-23T20:40:00", "2013-10-23T21:20:00")
    found = _subject.shade(what)
    seconds = np.arange(0.0, 2400.0)
    exact = what.view(seconds).lit_fraction
    assert exact.min() == 0.0 and exact.max() == 1.0
    # Lines over steps of 0.07 s: the penumbra takes 9 s.
    assert np.abs(np.interp(seconds, found.times, found.lit) - exact).max() < 1e-3
    assert found.names == "the Earth's"
    sunlit = _subject.subject(scene, "2013-10-23T21:05:00", "2013-10-23T21:06:00")
    assert _subject.shade(sunlit) is None
    assert _subject.shade(_subject.subject(scene.motion)) is None


def days_of_envisat(count):
    scene = mission.read(ROOT / "data" / "mission" / "envisat-glints.toml").scene
    orbit = Scene(None, scene.center, scene.observer, scene.sun)
    start = epochs.instant("2013-10-23")
    return _subject.Subject(None, orbit, None, start, count * DAY, "", None, "")


@pytest.mark.filterwarnings("ignore:ENVISAT is evaluated")
def test_a_long_span_has_all_eclipses(monkeypatch):
    """Of 60 days of Envisat against samples each minute."""
    what = days_of_envisat(60.0)
    seconds = np.arange(0.0, 60.0 * DAY, 60.0)
    exact = what.view(seconds).lit_fraction
    shade = _subject.shade(what)
    drawn = np.interp(seconds, shade.times, shade.lit)
    assert np.mean(np.abs(drawn - exact) > 0.5) < 0.01
    monkeypatch.setattr(_subject, "_MOST_SHADE", 1025)
    with pytest.warns(AttitudeWarning, match="shorter eclipses are not drawn"):
        _subject.shade(what)


@pytest.mark.filterwarnings("error")
def test_a_long_span_has_all_passes(monkeypatch):
    """The direction to a site over 10 days of Envisat, as lines between neighbours draw it."""
    what = days_of_envisat(10.0)
    rows = _subject.directions(what, "observer")
    middle = rows[1:] + rows[:-1]
    times = (np.arange(len(middle)) + 0.5) * what.duration / len(middle)
    sines = np.linalg.norm(np.cross(middle, what.toward("observer", times)), axis=1)
    assert np.all(sines < np.radians(0.1) * np.linalg.norm(middle, axis=1))
    monkeypatch.setattr(_subject, "_MOST_DIRECTIONS", 8193)
    with pytest.warns(AttitudeWarning, match="directions to the observer are 105.5 s apart"):
        _subject.directions(what, "observer")


def test_the_light_curve_of_many_turns(monkeypatch):
    """A box that turns 2001 times has two maxima a turn, whose light curve is that of one turn."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1))
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    scene = Scene(motion, sun=(1, 0, 0), observer=(0.6, 0.8, 0), shape=shape.box((1, 2, 3)))
    for turns, points in ((2001, 40_020), (10, 800)):
        curve = _subject.light_curve(_subject.subject(scene, 0.0, 2.0 * np.pi * turns))
        rises = np.diff(np.sign(np.diff(curve["magnitudes"])))
        assert np.sum(rises > 0) >= 2 * turns and len(curve["times"]) <= points
    monkeypatch.setattr(_subject, "_MOST_POINTS", 10_000)
    with pytest.warns(AttitudeWarning, match="the light curve has a point every"):
        _subject.light_curve(_subject.subject(scene, 0.0, 2.0 * np.pi * 2001))


def test_fine_meshes_are_smooth_and_boxes_are_not():
    motion = catalog.entry("toutatis").motion()
    for what, smooth in (
        (shape.Ellipsoid((2.0, 1.2, 1.0)).facets(4000), True),
        (shape.box((2.0, 1.2, 1.0)), False),
    ):
        assert _subject.surface(_subject.subject(motion, shape=what)).smooth == smooth


def test_the_title_is_no_path(tmp_path, monkeypatch, capsys):
    """A spin file without a name, in a folder: its name without folder and ending."""
    folder = tmp_path / "some" / "folder"
    folder.mkdir(parents=True)
    lines = ["[body]", "moments = [10, 20, 26]", "[spin]", 'epoch = "2026-01-01"',
             "wxyz = [1, 0, 0, 0]", "angular_velocity = [0.1, 1.5, 0.1]"]  # fmt: skip
    (folder / "brick.toml").write_text("\n".join(lines))
    monkeypatch.chdir(tmp_path)
    assert cli.main(["view", str(folder / "brick.toml")]) == 0
    assert capsys.readouterr().out == "brick.html\n"
    assert "<title>brick</title>" in (tmp_path / "brick.html").read_text()


def test_toutatis_is_shown_as_in_december_1992(tmp_path, monkeypatch):
    """Sun and Earth against the phase angles of JPL Horizons in the photometry of that month."""
    monkeypatch.chdir(tmp_path)
    assert cli.main(["view", "toutatis", "--output", "t.html"]) == 0
    page = content(SimpleNamespace(html=(tmp_path / "t.html").read_text()))
    assert page["title"] == "(4179) Toutatis, December 1992"
    assert page["curve"] is not None and page["surface"]["kind"] == "mesh"
    assert page["utc"][0].startswith("1992-12-08") and page["duration"] == pytest.approx(
        22 * DAY, abs=1e-2
    )
    scene = mission.read(catalog.entry("toutatis").scene).scene
    table = ROOT / "data" / "light_curve" / "toutatis-1992-photometry.csv"
    rows = [line.split(",") for line in table.read_text().splitlines() if "1992-12-" in line[:8]]
    rows = [row for row in rows if "1992-12-08" <= row[0][:10] < "1992-12-30"]
    phase = np.degrees(scene.at([row[0] for row in rows]).phase_angle)
    published = np.array([float(row[11]) for row in rows])
    assert len(rows) > 100 and published.min() < 25.0 and published.max() > 90.0
    assert np.abs(phase - published).max() < 0.05  # deg: a Kepler ellipse through these places
    # With a shape, a span, other directions or values of the state there is no such scene.
    assert cli.main(["view", "toutatis", "--sun", "1,0,0", "--observer", "0,1,0"]) == 0
    assert (tmp_path / "4179-toutatis.html").exists()
