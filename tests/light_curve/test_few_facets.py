"""The sum over meshes of few facets, all of which are evaluated."""

import numpy as np
import pytest

from attitude.light_curve import Visibility, _sums, brightness
from attitude.light_curve._sums import clusters_of
from attitude.scattering import Hapke, Material, Materials
from attitude.shape import Ellipsoid, Mesh, box_wing

SATELLITE = box_wing((10, 4, 4), (14, 5), gap=2.0, wings=1)
COOK = Material(0.2, 0.5, "cook-torrance", roughness=0.4)
COATS = Materials({
    "body": Material(0.25, 0.35, exponent=600),
    "panel front": COOK,
    "panel back": Material(0.3),
    "panel edge": Material(0.3),
})  # fmt: skip


def directions(count, seed):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    # Light along the axes meets facets edge on: cosines are zero.
    found[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    return found / np.linalg.norm(found, axis=1)[:, None]


def half_angle(sun, observer):
    """The phase angle, from tangents: an arc cosine would lose half of the digits."""
    apart = np.linalg.norm(sun - observer, axis=1), np.linalg.norm(sun + observer, axis=1)
    return 2.0 * np.arctan2(*apart)


def test_materials_against_numpy():
    """Three rows of a law, of which one has two names, and facets beside a pack that is full."""
    sun, observer = directions(400, 1), np.roll(directions(400, 2), 3, axis=0)
    alpha = half_angle(sun, observer)
    expected = np.zeros(len(sun))
    for name, normal, area in zip(
        SATELLITE.materials, SATELLITE.normals, SATELLITE.areas, strict=True
    ):
        mu0, mu = sun @ normal, observer @ normal
        shown = (mu0 > 0.0) & (mu > 0.0)
        r = COATS.reflectance(mu0[shown], mu[shown], alpha[shown], material=name)
        expected[shown] += r * mu[shown] * area
    found = brightness(SATELLITE, COATS, sun, observer, shadows=False)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-300)
    assert np.count_nonzero(found == 0.0) > 10


@pytest.mark.parametrize(
    "law", [COATS, Hapke(), Hapke(roughness=0.0)], ids=["coats", "rough", "smooth"]
)
def test_shadows_against_gathered_facets(law, monkeypatch):
    """The same sum over the facets that are both lit and seen, as larger meshes have it."""
    sun, observer = directions(500, 3), directions(500, 4)[::-1]
    table = Visibility.of(SATELLITE, resolution=16, keep=False)
    found = [brightness(SATELLITE, law, sun, observer, shadows=each) for each in (table, False)]
    monkeypatch.setattr(_sums, "MOST_PACKS", 0)
    gathered = [brightness(SATELLITE, law, sun, observer, shadows=each) for each in (table, False)]
    np.testing.assert_allclose(found, gathered, rtol=2e-14)
    assert np.count_nonzero(found[0] < 0.99 * found[1]) > 20


def test_tables_are_arranged_once():
    table = Visibility.of(SATELLITE, resolution=8, keep=False)
    clusters = clusters_of(SATELLITE)
    number = np.arange(len(SATELLITE)) % 2
    packs = _sums.packs_of(SATELLITE, number, 2, clusters.order)
    words = table.arranged(packs)
    assert table.arranged(packs) is words
    bits = words.view(np.uint8)
    for place, facet in enumerate(packs.order):
        column = np.flatnonzero(clusters.order == facet)[0] if facet >= 0 else None
        right = 0 if column is None else table.masks[:, column]
        assert np.all(bits[:, place] == right)
    other = _sums.packs_of(SATELLITE, 1 - number, 2, clusters.order)
    assert not np.array_equal(table.arranged(other), words)


def test_meshes_of_more_facets_are_gathered():
    mesh = Ellipsoid((3, 2, 1)).facets(80)
    assert isinstance(mesh, Mesh)
    order, number = clusters_of(mesh).order, np.zeros(len(mesh), dtype=int)
    assert _sums.packs_of(mesh, number, 1, order) is None
