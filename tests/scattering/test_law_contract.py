"""The contract of scattering laws: a new one is a class, and works by its name everywhere."""

import ast
import inspect
import pickle
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import attitude
from attitude import AttitudeError, Scene, scattering
from attitude._compilation.decorators import reduction_subroutine
from attitude.formats import mission
from attitude.light_curve import brightness, mean_brightness
from attitude.scattering import Hapke, Law, LommelSeeliger, Material, Materials, parameter
from attitude.scattering._law import reflectances
from attitude.shape import Ellipsoid, box
from tests.support.missions import FIXED
from tests.support.places import ROOT

PAGE = (ROOT / "docs" / "light_curves.md").read_text()
SHAPE = Ellipsoid((3, 2, 1)).facets(320)
rng = np.random.default_rng(3)
SUN, OBSERVER = (v / np.linalg.norm(v, axis=1)[:, None] for v in rng.normal(size=(2, 200, 3)))
ALPHA = np.arccos(np.clip(np.sum(SUN * OBSERVER, axis=1), -1.0, 1.0))


@pytest.fixture(scope="module")
def new():
    """The laws that the page in docs defines, as a reader would define them."""
    (text,) = re.findall(r"### A law of one's own.*?```python\n(.*?)```", PAGE, re.DOTALL)
    names = {"__name__": "laws_of_a_reader"}
    exec(text, names)
    yield names
    for name in ("lunar-lambert", "minnaert"):
        scattering.forget(name)


def summed(law):
    """The brightness by the reflectances of all facets, in numpy."""
    mu0, mu = SUN @ SHAPE.normals.T, OBSERVER @ SHAPE.normals.T
    r = law.reflectance(mu0, mu, np.broadcast_to(ALPHA[:, None], mu.shape))
    return np.sum(r * mu * SHAPE.areas, axis=1)


@pytest.mark.parametrize("name", ["lunar-lambert", "minnaert"])
def test_a_new_law_by_its_name(new, name):
    """In `scattering.law`, in brightness, in a Scene and in a mission file."""
    law = scattering.law(name)
    assert type(law) is scattering.laws()[name] and law.name == name
    found = brightness(SHAPE, name, SUN, OBSERVER)
    # the angle of the expected sum is an arc cosine: 1e-8 near opposition
    assert found == pytest.approx(summed(law), rel=1e-7)
    options = {"center": None, "observer": (1, 0, 0), "sun": (1, 1, 0), "shape": SHAPE}
    scene = Scene(None, **options, law=name)
    assert scene.law == law
    text = FIXED.replace("[times]", f'[scattering]\nlaw = "{name}"\nalbedo = 0.3\n\n[times]')
    view = mission.parse(text).scene.at([0.0, 50.0])
    assert type(view.scene.law) is type(law) and view.scene.law.albedo == 0.3
    expected = brightness(
        view.scene.shape, type(law)(albedo=0.3), view.sun_direction, view.observer_direction
    )
    assert np.array_equal(view.brightness, expected) and np.all(expected > 0.0)


def test_a_new_law_is_what_it_says(new):
    mu0, mu, alpha = 0.3, 0.7, 0.5
    minnaert = new["Minnaert"](albedo=0.4, k=0.6)
    expected = 0.4 * 1.6 / (2.0 * np.pi) * mu0**0.6 * mu**-0.4
    assert minnaert.reflectance(mu0, mu, alpha) == pytest.approx(expected, rel=1e-14)
    lambert = brightness(SHAPE, scattering.Lambert(0.4), SUN, OBSERVER)
    found = brightness(SHAPE, new["Minnaert"](albedo=0.4, k=1.0), SUN, OBSERVER)
    assert found == pytest.approx(lambert, rel=1e-13)
    lunar = new["LunarLambert"](albedo=0.4, share=0.2, width="90 deg")
    expected = 0.4 / np.pi * np.exp(-alpha / (np.pi / 2)) * mu0 * (0.4 / (mu0 + mu) + 0.8)
    assert lunar.reflectance(mu0, mu, alpha) == pytest.approx(expected, rel=1e-14)
    # Laws with weights have a mean over all orientations too.
    means = [mean_brightness(SHAPE, new["LunarLambert"](width=w), 1.0) for w in (1.0, 2.0)]
    assert means[1] / means[0] == pytest.approx(np.exp(0.5), rel=1e-14)
    with pytest.raises(AttitudeError, match="phase function of its own"):
        mean_brightness(SHAPE, minnaert, 1.0)


def test_units_and_ranges_of_a_new_law_hold_in_mission_files(new):
    def law(keys):
        return mission.parse(FIXED + f'[scattering]\nlaw = "lunar-lambert"\n{keys}\n').scene.law

    assert law('width = "45 deg"').width == pytest.approx(np.pi / 4, rel=1e-15)
    with pytest.raises(AttitudeError, match=r"\[scattering\] width is 90.* from 0.01 to 10 rad"):
        law("width = 90")
    with pytest.raises(AttitudeError, match="width is in m; give it in rad"):
        law('width = "1 m"')
    with pytest.raises(AttitudeError, match="'widht' that is not known; did you mean 'width'"):
        law("widht = 1")


def test_the_law_says_whether_ellipsoids_have_a_closed_form(new):
    shape = Ellipsoid((3, 2, 1))

    @dataclass(frozen=True)
    class Dimming(Law):
        """Lommel-Seeliger's law with a phase function."""

        name = "dimming"
        has_ellipsoid_form = True

        @property
        def weights(self):
            return LommelSeeliger().weights

        def phase(self, alpha):
            return np.cos(0.5 * alpha)

    try:
        found = brightness(shape, "dimming", SUN, OBSERVER)
        with pytest.raises(AttitudeError, match="the law 'dimming' or 'lommel-seeliger' only"):
            brightness(shape, "minnaert", SUN, OBSERVER)
        text = FIXED + '[scattering]\nlaw = "dimming"\n'
        assert isinstance(mission.parse(text).scene.shape, Ellipsoid)
        with pytest.raises(AttitudeError, match="has a key 'albedo' that is not known"):
            mission.parse(text + "albedo = 1\n")
    finally:
        scattering.forget("dimming")
    expected = brightness(shape, "lommel-seeliger", SUN, OBSERVER) * np.cos(0.5 * ALPHA)
    assert found == pytest.approx(expected, rel=1e-7)


def test_a_name_that_was_taken_out_is_unknown():
    @dataclass(frozen=True)
    class Brief(scattering.Lambert):
        """Lambert's law under another name."""

        name = "brief"

    assert scattering.law("brief") == Brief()
    scattering.forget("brief")
    for use in (
        lambda: scattering.law("brief"),
        lambda: brightness(SHAPE, "brief", SUN, OBSERVER),
        lambda: Scene(None, observer=(1, 0, 0), sun=(1, 1, 0), law="brief"),
    ):
        with pytest.raises(
            AttitudeError, match=r"law is 'brief'; give one of 'lambert', 'lommel-seeliger', "
        ):
            use()
    with pytest.raises(
        AttitudeError, match=r"law is 'brief'; give one of 'lambert'.* 'hapke', 'material'"
    ):
        mission.parse(FIXED + '[scattering]\nlaw = "brief"\n')
    with pytest.raises(AttitudeError, match="no law is called 'brief'"):
        scattering.forget("brief")


@pytest.mark.parametrize(
    ("law", "sentence"),
    [
        ("hapkee", "law is 'hapkee'; give one of 'lambert', 'lommel-seeliger', "),
        (Hapke, r"law is the class Hapke; give an instance: Hapke\(...\)"),
        (Law, "law is the class Law"),
        (None, "law is None; give one of"),
        (
            "material",
            r"has no default for diffuse; give attitude.scattering.Material\(...\)",
        ),
    ],
)
def test_a_scene_refuses_what_is_no_law_when_it_is_made(law, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        Scene(None, observer=(1, 0, 0), sun=(1, 1, 0), law=law)


@reduction_subroutine
def nothing(row, cos_half, sin_half, phase_terms):
    """Writes nothing."""


@reduction_subroutine
def white(row, phase_terms, mu0, mu):
    """Lambert's law."""
    return 1.0 / np.pi


@pytest.mark.parametrize(
    "parts",
    [
        {},
        {"of_phase": nothing},
        {"of_phase": nothing, "element": lambda row, phase_terms, mu0, mu: 1.0},
        {"of_phase": nothing, "element": white, "weights": (0.0, 1.0)},
    ],
)
def test_a_law_has_weights_or_compiled_functions(parts):
    with pytest.raises(AttitudeError, match="Partial must define either weights, or of_phase and"):
        type("Partial", (Law,), {"name": "partial", **parts})
    assert "partial" not in scattering.laws()


def test_a_name_is_one_law_s():
    parts = {"of_phase": nothing, "element": white}
    with pytest.raises(AttitudeError, match=r"Other is called 'hapke', as is .*hapke.Hapke; give"):
        type("Other", (Law,), {"name": "hapke", **parts})
    assert scattering.laws()["hapke"] is Hapke
    # Run again, as a cell of a notebook is, a definition takes the place of its former self.
    try:
        made = [type("Cell", (Law,), {"name": "cell", **parts}) for _ in range(2)]
        assert scattering.laws()["cell"] is made[1]
    finally:
        scattering.forget("cell")


def test_a_field_has_a_range():
    made = dataclass(frozen=True)(
        type("Bare", (Law,), {"weights": (0.0, 1.0), "k": 0.5, "__annotations__": {"k": float}})
    )
    with pytest.raises(AttitudeError, match="field k of the law Bare has neither range nor words"):
        made()


def test_words_of_a_law_are_numbers_in_its_row():
    @dataclass(frozen=True)
    class Worded(Law):
        """A law with a word; unnamed."""

        of_phase = nothing
        element = white
        kind: str = parameter("a", words=("a", "b"))
        share: float = parameter(0.5)

    assert Worded("b").row().tolist() == [1.0, 0.5]
    with pytest.raises(AttitudeError, match="kind is 'c'; it must be one of 'a', 'b'"):
        Worded("c")
    with pytest.raises(AttitudeError, match="share holds inf"):
        Worded(share=np.inf)
    assert Material(0.5).row().tolist() == [0.5, 0.0, 0.0, 100.0, 0.1, 1.0]


def test_machine_code_of_the_package_s_laws_is_kept():
    """Each pair of functions under its own key; a loop over functions from elsewhere is not."""
    given = np.full(7, 0.5)
    expected = {law: law.reflectance(given, given, given) for law in (Hapke(), Material(0.5))}
    for law, values in expected.items():
        anew, out = reflectances.__wrapped__(law.of_phase, law.elements, True), np.empty(7)
        anew(law.row(), given, given, 0.5 * given, out)
        assert np.array_equal(out, values)
        stats = anew.dispatcher.stats
        assert stats.cache_hits and not stats.cache_misses
        assert pickle.loads(pickle.dumps(law.elements)) is law.elements
    foreign = reflectances(nothing, white)
    out = np.empty(7)
    foreign(np.zeros(0), given, given, 0.5 * given, out)
    assert out == pytest.approx(0.5 / np.pi, rel=1e-15)
    assert foreign.dispatcher.stats.cache_path is None


def test_materials_are_a_law_by_names_of_facets():
    cube = box((1, 1, 1))
    law = Materials({name: Material(0.5) for name in set(cube.materials)})
    assert scattering.law(law) is law and law.name is None
    one = brightness(cube, Material(0.5), SUN, OBSERVER)
    assert np.array_equal(brightness(cube, law, SUN, OBSERVER), one)
    assert law != Materials({"body": Material(0.5)})


# ---- what goes with a law ----------------------------------------------------------------------


def shipped():
    """Laws by name, those of the package alone."""
    return {k: v for k, v in scattering.laws().items() if v.__module__.startswith("attitude.")}


def test_the_table_in_docs_is_that_of_the_registry():
    """Name, class and fields of every law, and nothing else."""
    table = PAGE[PAGE.index("## Scattering laws") : PAGE.index("### A law of one's own")]
    rows = re.findall(r'^\| "(.*?)" \| `(\w+)\((.*?)\)` \|', table, re.MULTILINE)
    assert {name: (made, fields.split(", ")) for name, made, fields in rows} == {
        name: (made.__name__, list(made.parameters())) for name, made in shipped().items()
    }
    assert len(rows) == table.count("\n| ") - 3  # the head, the line below it, Materials


def test_every_law_says_what_it_is():
    for made in (*shipped().values(), Materials):
        assert issubclass(made, Law) and getattr(scattering, made.__name__) is made
        assert set(made.parameters()) <= set(re.findall(r"\w+", inspect.getdoc(made)))


def test_nothing_probes_a_law():
    """No hasattr, getattr or isinstance outside of the module of the base class."""
    package = Path(attitude.__file__).parent
    probes = []
    for file in package.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
                continue
            if node.func.id in ("hasattr", "getattr", "isinstance") and node.args:
                probed = ast.unparse(node.args[0])
                if re.fullmatch(r"(.*[._])?law", probed):
                    probes.append(f"{file.relative_to(package)}: {ast.unparse(node)}")
    assert probes == []
