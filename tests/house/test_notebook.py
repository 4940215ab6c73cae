"""What notebooks show of the objects of the package: tables, small plots, figures."""

import xml.etree.ElementTree

import numpy as np
import pytest

from attitude import AttitudeTable, Body, FreeRotation, Scene, Spin, catalog, fit, plots, shape

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
    found = fit(PAPER.at(t))
    _, words = parsed(found)
    assert "40, rms" in words and "Short-axis mode" in words
    table = AttitudeTable("2026-01-01", [0, 10], [[1, 0, 0, 0], [0, 0, 0, 1]], method="slerp")
    assert "2026-01-01" in parsed(table)[1]


def test_figures_show_themselves():
    """Without a backend or a command: the object has a PNG."""
    assert plots.overview(PAPER)._repr_png_().startswith(b"\x89PNG")
