"""What notebooks show of the objects of the package: tables, small plots, figures."""

import xml.etree.ElementTree

import numpy as np
import pytest

from attitude import (
    Arcs,
    AttitudeTable,
    Body,
    Ensemble,
    FreeRotation,
    Impulse,
    Scene,
    Spin,
    catalog,
    events,
    fit,
    fit_rates,
    inversion,
    paths,
    photometry,
    plots,
    scattering,
    shape,
)

PAPER = FreeRotation(
    Body(moments=(10, 20, 26)),
    Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1)),
)


def parsed(shown):
    """The HTML as XML, which the tables are too, and its words."""
    tree = xml.etree.ElementTree.fromstring(shown._repr_html_())
    return tree, " ".join(tree.itertext())


def test_a_motion():
    tree, words = parsed(PAPER)
    assert "Short-axis mode" in words and "2.34711299 s" in words and "kg m2/s" in words
    (svg,) = tree.iter("svg")
    paths = [each.get("d") for each in svg.iter("path")]
    assert len(paths) == 4 and all(each.startswith("M") for each in paths)


@pytest.mark.parametrize(
    ("moments", "rate"), [((1, 2, 3), (0, 0, 0)), ((0, 2, 2), (0, 1, 0))], ids=["rest", "rod"]
)
def test_a_motion_without_an_ellipsoid(moments, rate):
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rate)
    tree, _ = parsed(FreeRotation(Body(moments=moments), spin))
    assert not list(tree.iter("svg"))


def test_a_history():
    tree, words = parsed(PAPER.at(np.linspace(0, 10, 50)))
    assert "50 attitudes, body to ICRF, from 2026-01-01T00:00:00 UTC" in words
    assert len(list(tree.iter("tr"))) == 7 and len(list(tree.iter("path"))) == 4
    assert "1.000000" in parsed(PAPER.at(0.0))[1]
    assert "NaN" not in PAPER.at([0.0, np.nan, 1.0])._repr_html_().replace("nan", "")


def test_a_scene():
    ball = shape.Ellipsoid((3, 2, 1))
    tree, words = parsed(Scene(PAPER, None, (1, 0, 0), (0, 1, 0), shape=ball))
    assert "lommel-seeliger" in words and "reduced magnitude" in words
    assert len(list(tree.iter("path"))) == 1
    for start in (0.0, 5.0):  # a table of less than two turns, and one without its epoch
        history = PAPER.at(np.linspace(start, start + 0.5, 20))
        table = AttitudeTable(PAPER.epoch, history.seconds, history.wxyz)
        tree, _ = parsed(Scene(table, None, (1, 0, 0), (0, 1, 0), shape=ball))
        assert not list(tree.iter("path"))
    tree, _ = parsed(Scene(PAPER, None, (1, 0, 0), (0, 1, 0)))
    assert not list(tree.iter("path"))


def test_an_entry_of_the_catalogue_and_a_published_state():
    entry = catalog.entry("apophis")
    _, words = parsed(entry)
    assert entry.name in words and "P_phi" in words and entry.sources[0] in words
    _, words = parsed(PAPER.published("S"))
    assert "P_psi" in words and "E/E0" in words


def test_a_fit_and_a_table():
    t = np.linspace(0, 3, 40)
    rates = fit_rates(t, PAPER.at(t).angular_velocity, PAPER.body, epoch=PAPER.epoch)
    for found in (fit(PAPER.at(t)), rates):
        _, words = parsed(found)
        assert "40 records, rms" in words and "Short-axis mode" in words
    table = AttitudeTable("2026-01-01", [0, 10], [[1, 0, 0, 0], [0, 0, 0, 1]], method="slerp")
    assert "2026-01-01" in parsed(table)[1]


def test_figures_show_themselves():
    """Without a backend or a command: the object has a PNG."""
    assert plots.overview(PAPER)._repr_png_().startswith(b"\x89PNG")


def test_a_body_and_a_spin():
    assert "10, 20, 26 kg m2" in parsed(PAPER.body)[1]
    tensor = [[3.0, 0.1, 0.2], [0.1, 4.0, -0.3], [0.2, -0.3, 4.5]]
    assert "0.1, 4, -0.3" in parsed(Body(tensor=tensor, mass=7.0))[1]
    _, words = parsed(PAPER.spin.with_covariance({"attitude": "1 deg"}))
    assert "2026-01-01T00:00:00 UTC" in words and "863.247961 deg/s" in words
    assert "sigma of attitude 1 deg" in words


def test_shapes_are_drawn():
    mesh = shape.box((1, 2, 3), material="foil")
    tree, words = parsed(mesh)
    assert "8, 12" in words and "6 m3" in words and "foil" in words
    assert len(list(tree.iter("path"))) == 6  # two facets on each of the three sides that are seen
    tree, words = parsed(shape.Ellipsoid((3, 2, 1)))
    assert "25.1327 m3" in words and 150 < len(list(tree.iter("path"))) < 350  # about half
    assert not list(parsed(shape.Ellipsoid((3, 2, 1)).facets(5000))[0].iter("path"))


def test_arcs_have_a_row_each():
    arcs = Arcs(PAPER.body, PAPER.spin, [Impulse(at=60.0, angular_momentum=(0, 0, 100))])
    tree, words = parsed(arcs)
    assert len(list(tree.iter("tr"))) == 3
    assert "2.34711299" in words and "Impulse" in words and "60" in words
    after = arcs.at(100.0)
    spin = Spin(arcs.epoch.after(100.0), after.wxyz, after.angular_velocity)
    assert f"{FreeRotation(PAPER.body, spin).period_phi:.8g}" in words


def test_an_ensemble_and_a_view():
    _, words = parsed(Ensemble.of([PAPER] * 12))
    assert "12 members" in words and "2.34711299" in words and "..." in words
    view = Scene(PAPER, None, (1, 0, 0), (0, 1, 0), shape=shape.Ellipsoid((3, 2, 1))).at([0, 1, 2])
    assert not list(parsed(view)[0].iter("path"))
    peak = float(np.max(view.reduced_magnitude))
    tree, words = parsed(view)
    assert f"{peak:.6g}" in words and len(list(tree.iter("path"))) == 1


def test_timetables():
    orbit = paths.uniform((7e6, 0, 0), (0, 7500.0, 0), epoch="2026-01-01", center="earth")
    scene = Scene(PAPER, orbit, paths.site("0 deg", "0 deg"), sun=(1, 0, 0))
    _, words = parsed(events.passes(scene, 0.0, 86400.0))
    assert "Passes, times in UTC" in words and "elevation [deg]" in words
    near = scene.quantity("observer_distance") < "1e5 km"
    _, words = parsed(events.windows(near, 0.0, 20000.0))
    assert "1 Windows" in words and "2026-01-01T00:00:00.000" in words
    law = scattering.Materials({"surface": scattering.Material(0.1, 0.5)})
    mirror = Scene(PAPER, None, (1, 0, 0), (0, 1, 0), shape=shape.box((1, 2, 3)), law=law)
    _, words = parsed(events.glints(mirror, 0.0, 1.0))
    assert "Glints, times in UTC" in words and "side" in words


def test_a_light_curve_and_solutions():
    """A body that turns about one axis, searched for a second."""
    motion = FreeRotation(
        Body(moments=(1, 2, 2.5), relative=True),
        Spin(epoch="2026-01-01", wxyz=(0.8, 0.6, 0, 0), angular_velocity=(0, 0, 3e-4)),
    )
    times = np.linspace(0.0, 10 * 86400.0, 120)
    au = 1.495978707e11
    angle = 0.2 + 2e-7 * times
    sun = au * np.stack([np.cos(angle), np.sin(angle), 0.1 + 0 * angle], axis=1)
    observer = au * np.array([1.0, 0.1, 0.3])
    scene = Scene(motion, None, (1.0, 0.1, 0.3), (1, 0.2, 0.1), shape=shape.Ellipsoid((2, 1.3, 1)))
    magnitude = scene.at(times).reduced_magnitude
    curve = photometry.LightCurve(
        motion.at(times).time, magnitude, 0.02, sun=sun, observer=np.tile(observer, (120, 1))
    )
    tree, words = parsed(curve)
    assert "120" in words and len(list(tree.iter("path"))) == 1
    found = inversion.spin_states(curve, "6 /d", modes=("LAM",), budget="1 s")
    _, words = parsed(found)
    assert found.verdict in words and "P_phi [h]" in words
    tree, words = parsed(found[0])
    assert found[0].mode in words and f"{found[0].rms:.4f} mag" in words
    assert len(list(tree.iter("svg"))) == 2
