"""Mission files: what they mean, and what is said of those that mean nothing."""

import numpy as np
import pytest

from attitude import AttitudeError, paths
from attitude.formats import mission, spin_file
from tests.support.kernels import kernel
from tests.support.places import DATA

FIXED = """
observer.direction = [1, 0, 0]
sun = { direction = [0, 1, 0], frame = "ecliptic" }
columns = ["phase_angle deg"]
times.epochs = ["2026-01-01", "2026-01-02T12:00:00 TDB"]
"""


def changed(old, new):
    assert old in FIXED
    return FIXED.replace(old, new)


def test_the_smallest_mission():
    found = mission.parse(FIXED)
    assert found.scene.motion is None and found.scene.center is None
    assert np.allclose(found.scene.at(found.times["epochs"]).phase_angle, np.pi / 2)
    assert [(each.name, each.unit) for each in found.columns] == [("phase_angle", "deg")]
    assert found.columns[0].factor == pytest.approx(180 / np.pi, rel=1e-15)
    assert mission.parse(changed(' deg"', '"')).columns[0].factor == 1.0


def test_envisat_is_where_its_parts_say():
    found = mission.read(DATA / "mission" / "envisat-pass.toml")
    assert found.scene.aberration and found.scene.observer.name == "Graz"
    spin = spin_file.read(DATA / "spin" / "envisat.toml")
    assert np.array_equal(found.scene.motion.spin.wxyz, spin.spin.wxyz)
    site = paths.site(np.radians(15.4933), np.radians(47.0671), 539.0)
    assert np.allclose(found.scene.observer.itrs, site.itrs, rtol=0, atol=1e-9)
    assert found.scene.center.lines == paths.tle(DATA / "paths" / "envisat-2013.tle").lines
    assert found.times == {
        "start": "2013-10-23T09:29:00", "stop": "2013-10-23T09:42:30", "step": "5 s",
    }  # fmt: skip


def test_apophis_takes_its_spin_from_the_catalogue():
    found = mission.read(DATA / "mission" / "apophis-2029.toml")
    assert found.scene.motion.period_psi == pytest.approx(263 * 3600, rel=1e-9)
    assert found.scene.center.name == "APOPHIS"
    assert "ASSUMED" in found.note


def test_errors_of_the_spin(tmp_path):
    errors = '\nerrors = { attitude = "2 deg", angular_velocity = "1 deg/day" }\n'
    spin = 'spin = { catalog = "Apophis", epoch = "2012-12-23", phi0 = 0.0, psi0 = 0.0 }'
    apophis = mission.parse(spin + errors + FIXED)
    given = np.sqrt(np.diag(apophis.scene.motion.spin.covariance))
    assert given[:3] == pytest.approx(np.radians([2.0] * 3), rel=1e-14)
    (tmp_path / "a.toml").write_text(spin_file.text(apophis.scene.motion))
    kept = mission.parse('spin = "a.toml"\n' + FIXED, folder=tmp_path).scene.motion.spin
    assert np.array_equal(kept.covariance, apophis.scene.motion.spin.covariance)
    other = mission.parse('spin = "a.toml"\nerrors.attitude = 0.1\n' + FIXED, folder=tmp_path)
    assert np.array_equal(np.diag(other.scene.motion.spin.covariance), [0.1**2] * 3 + [0.0] * 6)
    inline = mission.parse(FIXED + spin_file.text(apophis.scene.motion))
    assert np.array_equal(inline.scene.motion.spin.covariance, kept.covariance)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ('"mars barycenter"', str),
        ("4", str),
        ('{ site = "0.1, 0.2", height = 100.0 }', "Site"),
        ("{ site = [0.1, 0.2], long_term = true }", "Site"),
        (
            '{ kepler = { eccentricity = 0.1, inclination = "5 deg", node = 0.0, '
            'pericenter_argument = 0.0, epoch = "2026-01-01", semi_major_axis = "2 AU" } }',
            "Orbit",
        ),
    ],
)
def test_places(text, kind):
    found = mission.parse(f"center = {text}\n" + FIXED).scene.center
    if kind is str:
        assert found == "mars barycenter"
    else:
        assert isinstance(found, paths.Path)


def test_files_are_found_beside_the_mission(tmp_path):
    file = kernel("de421")
    (tmp_path / "k.bsp").symlink_to(file)
    (tmp_path / "sub").mkdir()
    text = f'ephemeris = "../k.bsp"\ncenter = {{ spk = "../k.bsp", target = "moon" }}\n{FIXED}'
    (tmp_path / "sub" / "m.toml").write_text(text)
    found = mission.read(tmp_path / "sub" / "m.toml")
    assert found.scene.center.name == "moon"
    assert found.scene.ephemeris.source == "k.bsp"


def test_shape_and_options():
    text = FIXED + '\n[shape]\nellipsoid = "3, 2, 1 km"\n[scattering]\nlaw = "lommel-seeliger"\n'
    assert np.allclose(mission.parse(text).scene.shape.semi_axes, [3000, 2000, 1000])
    text = 'light_time = false\ntolerance = "1 cm"\n' + FIXED
    scene = mission.parse(text).scene
    assert scene.light_time is False and scene.tolerance == 0.01
    assert mission.parse('tolerance = "none"\n' + FIXED).scene.tolerance is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (changed("columns", "column"), "a key 'column' .* did you mean 'columns'"),
        (changed('["phase_angle deg"]', "[]"), r"columns is \[\]; give a list"),
        (changed("phase_angle deg", "phase_angel deg"), "did you mean 'phase_angle'"),
        (changed("phase_angle deg", "phase_angle km"), "phase_angle is in rad"),
        (changed("phase_angle deg", "lit_fraction km"), "lit_fraction is a pure number"),
        (changed("phase_angle deg", "phase_angle dgree"), "not a unit"),
        (changed("[1, 0, 0]", "[0, 0, 0]"), "no direction"),
        (changed("observer.direction = [1, 0, 0]", ""), "the file has no center"),
        (changed("observer.direction", "observer.there"), "observer has none of tle"),
        (changed("times.epochs", "times.dates"), "a key 'dates'"),
        (changed("times.epochs = [", "other = ["), "a key 'other'"),
        (FIXED + 'times.step = "1 s"', "epochs and other keys"),
        ("times = 3\n" + FIXED[: FIXED.index("times")], "times is 3; give a section"),
        ("errors.attitude = 0.1\n" + FIXED, r"a section \[errors\], but no spin"),
        ("spin = 3\n" + FIXED, "spin is 3; give the name of a spin file"),
        ('spin = "none.toml"\n' + FIXED, "spin is 'none.toml', which is not a file"),
        ('spin = { catalog = "Apophis" }\n' + FIXED, "epoch"),
        (
            'center = { tle = "none.tle" }\n' + FIXED,
            "center tle is 'none.tle', which is not a file",
        ),
        ('center = { tle = "a", oem = "b" }\n' + FIXED, "center has tle and oem"),
        ('center = { spk = "a", tagret = 3 }\n' + FIXED, "did you mean 'target'"),
        ("center = { kepler = { e = 1 } }\n" + FIXED, "kepler has no argument e; give ecc"),
        ('center = { site = "1 deg" }\n' + FIXED, "give longitude and latitude"),
        ("center = [1, 2]\n" + FIXED, "give the name of a body, or a table"),
        ('ephemeris = "x.bsp"\n' + FIXED, "ephemeris is 'x.bsp', which is not a file"),
        ("name = 3\n" + FIXED, "name is 3; give text"),
        (FIXED + "\n[shape]\nsphere = 1", "a key 'sphere'"),
        (FIXED + "\n[shape]\nunit = 'm'", "none of ellipsoid, box"),
        (FIXED + "\n[magnitude]\nh = 19", r"a section \[magnitude\], but no \[shape\]"),
        (FIXED + "\n[shape", "is not valid TOML"),
    ],
)
def test_what_is_refused(text, message):
    with pytest.raises(AttitudeError, match=message) as caught:
        mission.parse(text, "m.toml")
    assert str(caught.value).startswith("m.toml")


def test_times_and_columns_may_be_left_to_the_command():
    text = FIXED[: FIXED.index("times")]
    assert mission.parse(text.replace('columns = ["phase_angle deg"]', "")).columns == ()
    assert mission.parse(text).times == {}
    assert mission.parse(text + "times.stop = 1.0").times == {"stop": "1"}
    with pytest.raises(AttitudeError, match="without quotes"):
        mission.parse(text + 'times.start = 2026-01-01\ntimes.stop = "1 d"\ntimes.step = 1')


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(AttitudeError, match="cannot be read"):
        mission.read(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(AttitudeError, match="mission file"):
        mission.read(tmp_path / "binary.toml")
