"""``attitude lightcurve``: the curve of a mission file as table, DAMIT file and figure."""

import csv
import io

import numpy as np
import pytest

from attitude import cli, epochs, light_curve, photometry, scattering
from attitude._support.constants import SPEED_OF_LIGHT_M_S
from attitude.formats import mission
from attitude.formats.damit_light_curve import read_damit_light_curves
from attitude.shape import Ellipsoid
from tests.support.examples import is_picture, run
from tests.support.missions import FIXED
from tests.support.places import DATA

MISSIONS = DATA / "mission"
# The same top at Mars, seen from the Earth.
EARTH = (
    FIXED.replace("observer.direction = [1, 0, 0]", 'center = "mars barycenter"')
    .replace("sun.direction = [1, 1, 0]", 'ephemeris = "builtin"')
    .replace('"0"', '"2026-06-01"')
    .replace('"360 s"', '"2026-06-02"')
    .replace('"30 s"', '"2 h"')
)


@pytest.fixture
def lightcurve(capsys):
    def call(*arguments):
        code = cli.main(["lightcurve", *map(str, arguments)])
        return code, *capsys.readouterr()

    return call


@pytest.fixture
def file(tmp_path):
    def made(text, name="m.toml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return made


def changed(old, new, text=FIXED):
    assert old in text
    return text.replace(old, new)


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def column(rows, name):
    return np.array([float(row[name]) for row in rows])


def test_the_curve_is_that_of_the_closed_form(lightcurve, file):
    code, out, err = lightcurve(file(FIXED))
    assert (code, err) == (0, "")
    rows = rows_of(out)
    assert list(rows[0])[2:] == [
        "reduced_magnitude [mag]",
        "brightness [m2 / sr]",
        "phase_angle [deg]",
    ]
    turn = np.radians(column(rows, "tdb_seconds"))
    observer = np.stack([np.cos(turn), -np.sin(turn), 0 * turn], axis=1)
    sun = np.stack([np.cos(turn - np.pi / 4), -np.sin(turn - np.pi / 4), 0 * turn], axis=1)
    expected = light_curve.brightness(Ellipsoid((3, 2, 1)), "lommel-seeliger", sun, observer)
    # Rounding of the directions of a turning body.
    assert np.allclose(column(rows, "brightness [m2 / sr]"), expected, rtol=1e-13)
    assert np.allclose(
        column(rows, "reduced_magnitude [mag]"), light_curve.reduced_magnitude(expected), atol=1e-12
    )
    assert np.allclose(column(rows, "phase_angle [deg]"), 45.0)


def test_ecsv_is_read_back_with_units_and_times(lightcurve, file, tmp_path):
    from astropy.table import QTable, Table

    path = tmp_path / "c.ecsv"
    assert lightcurve(file(FIXED), "--output", path)[0] == 0
    table = QTable.read(path)
    assert table["reduced_magnitude"].unit == "mag" and table["brightness"].unit == "m2 / sr"
    # steps are of UTC, as the start: those of TDB differ by the periodic terms of TDB - TT
    assert len(Table.read(path)) == 13
    assert table["tdb_seconds"][1].value == pytest.approx(30.0, abs=1e-7)
    assert abs((table["utc"][1] - table["utc"][0]).sec - 30.0) < 1e-6
    rows = rows_of(lightcurve(file(FIXED))[1])
    assert table["brightness"].value.tolist() == column(rows, "brightness [m2 / sr]").tolist()


def test_h_and_g_are_the_mean_over_all_orientations(lightcurve, file):
    text = FIXED + "\n[magnitude]\nh = 19.09\ng = 0.24\n"
    rows = rows_of(lightcurve(file(text))[1])
    shape, law = Ellipsoid((3, 2, 1)), scattering.LommelSeeliger()
    mean = light_curve.mean_brightness(shape, law, np.pi / 4)
    expected = scattering.hg(np.pi / 4, 19.09, 0.24) - 2.5 * np.log10(
        column(rows, "brightness [m2 / sr]") / mean
    )
    assert np.allclose(column(rows, "reduced_magnitude [mag]"), expected, atol=1e-12)
    # Size and albedo do not enter.
    small = changed("3, 2, 1 m", "3, 2, 1 cm", text) + '[scattering]\nalbedo = 0.1\nlaw = "lambert"'
    small = small.replace("lambert", "lommel-seeliger")
    other = rows_of(lightcurve(file(small))[1])
    assert np.allclose(column(other, "reduced_magnitude [mag]"), expected, atol=1e-9)


def test_directions_with_distances_have_apparent_magnitudes(lightcurve, file):
    text = FIXED + '[magnitude]\nsun_distance = "2 AU"\nobserver_distance = "0.5 AU"\n'
    rows = rows_of(lightcurve(file(text))[1])
    reduced = rows_of(lightcurve(file(FIXED))[1])
    # 5 log10(2 * 0.5) = 0
    assert np.allclose(
        column(rows, "magnitude [mag]"), column(reduced, "reduced_magnitude [mag]"), atol=1e-12
    )


def test_what_shows_nothing_is_inf_and_the_figure_leaves_it_out(lightcurve, file, tmp_path):
    text = changed("sun.direction = [1, 1, 0]", "sun.direction = [-1, 0, 0]")
    code, out, err = lightcurve(file(text))
    assert (code, err) == (0, "")
    assert {row["reduced_magnitude [mag]"] for row in rows_of(out)} == {"inf"}
    code, out, err = lightcurve(file(text), "--figure", tmp_path / "x.png")
    assert (code, err) == (0, "") and out == f"{tmp_path / 'x.png'}\n"


def test_damit_file_holds_the_geometry_of_the_scene(lightcurve, file, tmp_path):
    path = tmp_path / "lc.txt"
    code, out, err = lightcurve(file(EARTH), "--output", path)
    assert (code, out, err) == (0, "", "")
    (curve,) = read_damit_light_curves(path)
    found = mission.parse(EARTH)
    assert curve.calibrated and len(curve) == 13
    rows = rows_of(lightcurve(file(EARTH))[1])
    # From asteroid-centric vectors: what the table says of the same epochs.
    assert np.allclose(np.degrees(curve.phase_angle), column(rows, "phase_angle [deg]"), atol=1e-6)
    au = column(rows, "sun_distance [au]")
    assert np.allclose(np.linalg.norm(curve.sun, axis=1), au, rtol=1e-12)
    modulus = 5 * np.log10(au * np.linalg.norm(curve.earth, axis=1))
    assert np.allclose(curve.magnitude + modulus, column(rows, "magnitude [mag]"), atol=1e-9)
    # The light left some minutes before it was received.
    received = column(rows, "tdb_seconds")
    left = curve.seconds_since(found.scene.epoch)[0]
    assert np.allclose(received - left, np.linalg.norm(curve.earth, axis=1) * 499.004784, rtol=1e-6)


def _barycentric(curve):
    """A light curve with its dates at the barycenter of the solar system."""
    place = curve.scenes[""].observer.position(curve.epoch, curve.seconds)
    along = np.sum(place * curve.observer, axis=1) / np.linalg.norm(curve.observer, axis=1)
    bands = [curve.filters[k] for k in curve.filter]
    return photometry.LightCurve(
        curve.seconds - along / SPEED_OF_LIGHT_M_S, curve.value, epoch=curve.epoch, filter=bands,
        time_of="barycenter",
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["apparent", "reduced"])
@pytest.mark.parametrize(
    "dated", [lambda curve: curve, lambda curve: curve.reduced(), _barycentric],
    ids=["reception", "emission", "barycenter"],
)  # fmt: skip
def test_observations_are_compared_at_their_reception(lightcurve, file, tmp_path, kind, dated):
    """Whatever their dates are, reduced magnitudes with reduced ones, each filter by itself."""
    path = file(EARTH)
    rows = rows_of(lightcurve(path)[1])
    band = np.array(["V", "R"])[np.arange(13) % 2]
    magnitude = column(rows, "magnitude [mag]") + np.where(band == "V", 3.0, 3.5)
    dates, scene = [row["utc"] for row in rows], mission.read(path).scene
    dated(photometry.LightCurve(dates, magnitude, scene=scene, filter=band)).write(
        tmp_path / "seen.csv"
    )
    given = file(EARTH + f'[magnitude]\nkind = "{kind}"\n'), "--observed", tmp_path / "seen.csv"
    code, out, err = lightcurve(*given)
    assert code == 0 and out.startswith("utc,session,filter,observed,computed,residual\n")
    assert "V: 7 points, zero point +3.000" in err and "R: 6 points, zero point +3.500" in err
    assert "rms of 13 points: 0.000 mag" in err
    seconds = (
        epochs.seconds_since(scene.epoch, [row["utc"] for row in x])[0]
        for x in (rows, rows_of(out))
    )
    assert np.ptp(np.subtract(*seconds)) < 1e-4  # of a Julian date as a double
    code, out, err = lightcurve(*given, "--start", "0")
    assert code == 2 and "--start has no meaning for --observed" in err


def test_names_of_sessions_are_quoted(lightcurve, file, tmp_path):
    rows = rows_of(lightcurve(file(FIXED))[1])
    lines = [f'{row["utc"]},{row["reduced_magnitude [mag]"]},"Smith, J."' for row in rows]
    seen = file("\n".join(["utc,mag,session", *lines]), "seen.csv")
    assert {row["session"] for row in rows_of(lightcurve(file(FIXED), "--observed", seen)[1])} == {
        "Smith, J."
    }


def test_a_damit_file_of_a_day_is_refused(lightcurve, tmp_path):
    times = "--start", "2013-10-23T10:00", "--stop", "2013-10-23T10:10", "--step", "1 min"
    path = tmp_path / "lc.txt"
    code, _, err = lightcurve(MISSIONS / "envisat-glints.toml", "--output", path, *times)
    assert code == 2 and "at all 11 epochs the site does not observe the body" in err
    assert not path.exists()


def test_blocks_do_not_show(lightcurve, file, monkeypatch, tmp_path):
    whole = lightcurve(file(FIXED))[1]
    monkeypatch.setattr("attitude.cli.lightcurve._BLOCK", 5)
    assert lightcurve(file(FIXED))[1] == whole
    path, picture = tmp_path / "c.csv", tmp_path / "c.svg"
    assert lightcurve(file(FIXED), "--output", path, "--figure", picture)[0] == 0
    assert path.read_text() == whole and "</svg>" in picture.read_text()


def test_progress_is_told_to_a_terminal(lightcurve, file, monkeypatch):
    monkeypatch.setattr("attitude.cli.lightcurve._BLOCK", 5)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setattr("attitude._support.blocks._PATIENCE", 0.0)
    monkeypatch.setattr("attitude._support.blocks._INTERVAL", 0.0)
    err = lightcurve(file(FIXED))[2]
    assert " 38 %" in err and err.endswith("100 %\n")


def test_a_box_wing_with_materials_over_a_site(lightcurve, tmp_path):
    path, picture = tmp_path / "c.csv", tmp_path / "c.png"
    code, _, err = lightcurve(
        MISSIONS / "envisat-glints.toml", "--output", path, "--figure", picture,
        "--start", "2013-10-23T19:18:00", "--stop", "2013-10-23T19:21:00", "--step", "1 s",
    )  # fmt: skip
    assert (code, err) == (0, "") and is_picture(picture)
    rows = rows_of(path.read_text())
    lit, magnitude = column(rows, "lit_fraction"), column(rows, "magnitude [mag]")
    assert np.all(np.isinf(magnitude[lit == 0.0])) and np.all(np.isfinite(magnitude[lit > 0.0]))
    assert 0 < np.count_nonzero((lit > 0.0) & (lit < 1.0)) < 12
    # In the penumbra what falls on it is the share of the Sun's disc that is free.
    far = np.array([column(rows, f"{who}_distance [{unit}]") for who, unit in DISTANCES])
    sunlit = light_curve.apparent_magnitude(
        column(rows, "brightness [m2 / sr]"), far[0] * 149597870700.0, far[1] * 1e3
    )
    some = lit > 0.0
    assert np.allclose(magnitude[some], (sunlit - 2.5 * np.log10(np.where(some, lit, 1.0)))[some])
    # The glint of the panel that examples/envisat_glints.py finds at 19:20:13.6.
    assert rows[int(np.argmin(magnitude))]["utc"].startswith("2013-10-23T19:20:1")
    assert np.min(magnitude) < -2.0 and column(rows, "elevation [deg]").max() > 75.0


DISTANCES = (("sun", "au"), ("observer", "km"))
SHAPES = [
    ('box = "1, 2, 3 m"', 12, 6.0),
    ('cylinder = { radius = "1 m", height = 2, sides = 128, axis = "x" }', 512, 2 * np.pi),
    ("box_wing = { body = [1, 1, 1], wing = [2, 1], wings = 2, thickness = 0.1 }", 36, 1.4),
    ('ellipsoid = "1, 1, 1 m"\nfacets = 20', 20, None),
    ("box = [1, 1, 1]\ndivided = 1", 48, 1.0),
    ('file = "cube.obj"\nunit = "mm"', 12, 1e-9),
]


@pytest.mark.parametrize(("text", "facets", "volume"), SHAPES)
def test_shapes(file, text, facets, volume):
    cube = "".join(f"v {i >> 2 & 1} {i >> 1 & 1} {i & 1}\n" for i in range(8))
    cube += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
    file(cube, "cube.obj")
    found = mission.read(file(changed('ellipsoid = "3, 2, 1 m"', text))).scene.shape
    assert len(found) == facets
    assert volume is None or found.volume == pytest.approx(volume, rel=1e-12)


def test_an_ellipsoid_makes_facets_only_for_laws_that_want_them(file):
    def shape(law):
        return mission.parse(FIXED + f'[scattering]\nlaw = "{law}"').scene.shape

    assert isinstance(shape("lommel-seeliger"), Ellipsoid)
    assert 900 < len(shape("hapke")) < 1400
    text = changed('ellipsoid = "3, 2, 1 m"', 'ellipsoid = "moments"\ndiameter = "2 km"')
    axes = mission.parse(text.replace("[1, 2, 3]", "[5, 10, 13]")).scene.shape.semi_axes
    # Moments of 3 : 2 : 1 are as 5 : 10 : 13.
    assert axes / axes[2] == pytest.approx([3, 2, 1]) and np.prod(axes) == pytest.approx(1e9)


LAWS = [
    ('law = "lambert"\nalbedo = 0.3', scattering.Lambert(0.3)),
    (
        'law = "lommel-seeliger-lambert"\nc = 0.2\nd = "5 deg"',
        scattering.LommelSeeligerLambert(c=0.2, d=np.radians(5)),
    ),
    (
        'law = "hapke"\nw = 0.1\nroughness = "25 deg"',
        scattering.Hapke(w=0.1, roughness=np.radians(25)),
    ),
    (
        'law = "material"\ndiffuse = 0.2\nspecular = 0.1\nmodel = "cook-torrance"\nroughness = 0.2',
        scattering.Material(0.2, 0.1, "cook-torrance", roughness=0.2),
    ),
]


@pytest.mark.parametrize(("text", "law"), LAWS)
def test_laws(text, law):
    assert repr(mission.parse(FIXED + "[scattering]\n" + text).scene.law) == repr(law)


def test_a_spin_file_may_be_held_inline():
    inline = mission.parse(FIXED).scene.motion
    assert inline.body.relative and np.degrees(inline.spin.angular_velocity[2]) == pytest.approx(1)


BOX = changed('ellipsoid = "3, 2, 1 m"', 'box = "1, 1, 1 m"')
WRONG = [
    (
        'columns = ["phase_angle"]\n' + changed('[shape]\nellipsoid = "3, 2, 1 m"', ""),
        "has no section [shape]",
    ),
    (changed("ellipsoid =", "sphere ="), "a key 'sphere'"),
    (changed("[shape]", '[shape]\nbox = "1, 1, 1 m"'), "[shape] has ellipsoid and box"),
    (changed('"3, 2, 1 m"', '"3, 2, 1 kg"'), "[shape] ellipsoid is in kg"),
    (changed('"3, 2, 1 m"', '"3, 2, 0 m"'), "must be greater than zero"),
    (changed('"3, 2, 1 m"', "[3, 2, nan]"), "[shape] ellipsoid holds nan"),
    (changed('"3, 2, 1 m"', '"moments"\ndiameter = -1'), "diameter is -1.0"),
    (changed('ellipsoid = "3, 2, 1 m"', 'file = "none.obj"'), "not a file"),
    (changed('ellipsoid = "3, 2, 1 m"', 'file = "open.obj"'), "facets 0 lie at a hole"),
    (
        changed('ellipsoid = "3, 2, 1 m"', 'file = "inward.obj"'),
        "inside out: the normals of facets",
    ),
    (changed('ellipsoid = "3, 2, 1 m"', 'file = "short.obj"'), "line 3"),
    (changed('ellipsoid = "3, 2, 1 m"', 'box = "1, 1, 1 m"\nunit = "km"'), "does not go with box"),
    (changed('ellipsoid = "3, 2, 1 m"', "cylinder = { radius = 1 }"), "cylinder has no height"),
    (changed('ellipsoid = "3, 2, 1 m"', "box_wing = { bdy = [1, 1, 1] }"), "did you mean 'body'"),
    (changed('ellipsoid = "3, 2, 1 m"', "box_wing = [1]"), "give a table of body, wing"),
    (changed("[shape]", "[shape]\nshadows = 3"), "[shape] shadows is 3"),
    (changed("[shape]", "[shape]\ndivided = 3"), "divided does not go with ellipsoid"),
    (changed('ellipsoid = "3, 2, 1 m"', "box = [1, 1, 1]\ndivided = 0.5"), "divided 0.5 times"),
    (changed("[shape]", "[shape]\nfacets = 3") + '[scattering]\nlaw = "lambert"', "count is 3"),
    (FIXED + '[scattering]\nlaw = "lamberd"', "law is 'lamberd'"),
    (FIXED + '[scattering]\nlaw = "lambert"\nalbedo = 2', "albedo is 2.0; it must lie from 0 to 1"),
    (FIXED + '[scattering]\nlaw = "lambert"\nalbido = 2', "did you mean 'albedo'"),
    (FIXED + '[scattering]\nlaw = "hapke"\nroughness = "80 deg"', "roughness is 1.39"),
    (FIXED + '[scattering]\nlaw = "material"', "has no diffuse"),
    (FIXED + '[scattering]\nlaw = "material"\ndiffuse = 0.9\nspecular = 0.2', "more than 1"),
    (FIXED + "[scattering.materials.body]\ndiffuse = 0.1", "an ellipsoid has none"),
    (BOX + "[scattering.materials.bdy]\ndiffuse = 0.1", "'bdy', which no facet carries"),
    (BOX + "[scattering]\nmaterials = {}", "materials has no 'surface'"),
    (BOX + "[scattering]\nmaterials = 3", "materials is 3; give a table for each group"),
    (FIXED + '[magnitude]\nkind = "apparent"', "needs sun_distance and observer_distance"),
    (FIXED + '[magnitude]\nkind = "absolute"', "kind is 'absolute'"),
    (FIXED + "[magnitude]\ng = 0.1", "has g but no h"),
    (FIXED + "[magnitude]\nh = 10\ng1 = 0.1", "h with g1"),
    (FIXED + "[magnitude]\nh = 10\ng = 3", "g is 3.0"),
    (FIXED + "[magnitude]\nh = 10\nsun_magnitude = -26", "leave one out"),
    (FIXED + '[magnitude]\nh = 10\n[scattering]\nlaw = "hapke"', "phase function of its own"),
    (FIXED + '[magnitude]\nsun_distance = "-1 AU"', "sun_distance is -1"),
    (EARTH + '[magnitude]\nsun_distance = "1 AU"', "whose distance is known"),
    (changed("wxyz", "wxzy"), "did you mean 'wxyz'"),
    (changed("[body]\nmoments", "[other]\nmoments"), "a key 'other'"),
    (
        'spin = "x.toml"\n' + changed("[spin]", "[times]").partition("[times]")[0],
        "[body] and a spin",
    ),
    ("threads = 0\n" + FIXED, "threads is 0"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_what_is_wrong_is_a_sentence_and_nothing_is_written(
    lightcurve, file, tmp_path, text, message
):
    file("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "open.obj")
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    file(points + "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n", "inward.obj")
    file("v 0 0 0\nv 1 0 0\nv 0 1\n", "short.obj")
    path, picture = tmp_path / "c.csv", tmp_path / "c.png"
    code, out, err = lightcurve(file(text), "--output", path, "--figure", picture)
    assert code == 2 and out == "" and err.count("\n") == 1, err
    assert message in err and "Traceback" not in err
    assert {each.suffix for each in tmp_path.iterdir()} == {".toml", ".obj"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--output", "x.dat"), "ends in .csv or .ecsv or .txt"),
        (("--figure", "x.gif"), "ends in .png or .svg"),
        (("--figure", "no/x.png"), "cannot be written"),
        (("--output", "no/x.csv"), "cannot be written"),
        (("--output", "x.txt"), "the sun is a direction"),
        (("--step", "0 s"), "--step is zero"),
        (("--stop", "soon"), "--stop is 'soon'"),
    ],
)
def test_arguments(lightcurve, file, tmp_path, monkeypatch, arguments, message):
    path = file(FIXED)
    monkeypatch.chdir(tmp_path)
    code, out, err = lightcurve(path, *arguments)
    assert code == 2 and out == "" and message in err and err.count("\n") == 1
    assert [each.name for each in tmp_path.iterdir()] == ["m.toml"]


def test_an_error_with_the_figure_leaves_no_table(lightcurve, file, tmp_path):
    path = file(FIXED)
    (tmp_path / "old.csv").write_text("kept\n")
    code, _, err = lightcurve(
        path, "--output", tmp_path / "old.csv", "--figure", tmp_path / "no" / "x.png"
    )
    assert "--figure" in err and "x.png' cannot be written" in err and "old.csv" not in err
    assert code == 2 and (tmp_path / "old.csv").read_text() == "kept\n"
    assert {each.name for each in tmp_path.iterdir()} == {"m.toml", "old.csv"}


def test_an_interrupt_leaves_nothing(lightcurve, file, tmp_path, monkeypatch):
    from attitude.scene import View

    made = View.phase_angle.function

    def interrupted(view):
        if view.seconds[0] > 100.0:
            raise KeyboardInterrupt
        return made(view)

    monkeypatch.setattr("attitude.cli.lightcurve._BLOCK", 5)
    monkeypatch.setattr(View.phase_angle, "function", interrupted)
    code, _, _ = lightcurve(file(FIXED), "--output", tmp_path / "c.csv")
    assert code == 130 and [each.name for each in tmp_path.iterdir()] == ["m.toml"]


def test_a_damit_file_of_what_is_not_seen_is_refused(lightcurve, file, tmp_path):
    # The phase function of Kaasalainen's law ends at 1/|k| rad, here 6 deg.
    text = EARTH + '[scattering]\nlaw = "lommel-seeliger-lambert"\nk = -10\na = 0\n'
    path = tmp_path / "lc.txt"
    code, _, err = lightcurve(file(text), "--output", path)
    assert code == 2 and "nothing of the body is both lit and seen" in err
    assert not path.exists()


def test_a_damit_file_is_dimmed_by_shadows(lightcurve, tmp_path):
    satellite, path = MISSIONS / "envisat-glints.toml", tmp_path / "lc.txt"

    def asked(start, stop):
        times = "--start", f"2013-10-23T19:{start}", "--stop", f"2013-10-23T19:{stop}"
        return lightcurve(satellite, "--output", path, *times, "--step", "1 s")

    code, _, err = asked("13:00", "13:10")  # umbra
    assert code == 2 and "at 11 epochs nothing" in err and not path.exists()
    assert asked("19:15", "19:40")[0] == 0  # from penumbra into light
    (curve,) = read_damit_light_curves(path)
    view = mission.read(satellite).scene.at(
        [f"2013-10-23T19:19:{second}" for second in range(15, 41)]
    )
    assert 0.0 < view.lit_fraction[0] < 1.0 == view.lit_fraction[-1]
    seen = 10.0 ** (-0.4 * view.reduced_magnitude) * view.lit_fraction
    # Epochs of the command and of the list differ by their rounding, some 1e-11 s.
    assert curve.brightness == pytest.approx(seen, rel=1e-9)


def test_example_apophis_light_curve(tmp_path):
    found = run("apophis_light_curve.py", tmp_path)
    assert found.stderr == ""
    lines = found.stdout.splitlines()
    head = next(k for k, line in enumerate(lines) if line.startswith("  i   j"))
    strongest = lines[head + 1].split()
    assert strongest[:3] == ["2", "-2", "15.281"] and "2nd harmonic of 30.56 h" in lines[head + 1]
    assert float(strongest[4]) > 0.8
    assert "periodogram of the curve peaks at 15.28 h" in found.stdout
    assert is_picture(tmp_path / "apophis_light_curve.png")


@pytest.mark.slow
def test_example_envisat_glints(tmp_path):
    found = run("envisat_glints.py", tmp_path)
    assert found.stderr == ""
    lines = found.stdout.splitlines()
    head = next(k for k, line in enumerate(lines) if line.startswith("UTC"))
    rows = [line.split() for line in lines[head + 1 : head + 11]]
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    # Of ten glints six fall into the Earth's shadow, where nothing flashes.
    dark = [row for row in rows if row[6] == "0.00"]
    assert len(dark) == 6 and all(row[7] == row[8] == "inf" for row in dark)
    for row in rows:
        if row not in dark:
            assert row[1:3] == ["panel", "back"] and float(row[7]) < float(row[8]) - 1.5
    assert is_picture(tmp_path / "envisat_glints.png")
