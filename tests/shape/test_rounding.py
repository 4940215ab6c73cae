"""Convex models stay convex when their coordinates are rounded, as those of DAMIT are."""

import importlib
import pickle

import numpy as np
import pytest
from scipy.spatial import ConvexHull, HalfspaceIntersection

from attitude import AttitudeError, light_curve, shape
from attitude.shape import Mesh
from attitude.shape._mesh import of_printed


def hull(points):
    """Vertices and facets, anticlockwise from outside, of the convex hull of points."""
    found = ConvexHull(points)
    facets = found.simplices.copy()
    a, b, c = np.moveaxis(points[facets], 1, 0)
    inward = np.sum(np.cross(b - a, c - a) * (a - points.mean(axis=0)), axis=1) < 0.0
    facets[inward] = facets[inward][:, ::-1]
    used, renumbered = np.unique(facets, return_inverse=True)
    return points[used], renumbered.reshape(-1, 3)


def polyhedron(count=300):
    """Large flat sides cut into triangles, as those of DAMIT, some of them slivers."""
    normals = np.random.default_rng(0).normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.linalg.norm(normals * (1.5, 1.2, 1.0), axis=1)
    sides = HalfspaceIntersection(np.c_[normals, -heights], np.zeros(3))
    return hull(np.unique(sides.intersections.round(9), axis=0))


def smooth(count=1000):
    points = np.random.default_rng(1).normal(size=(count, 3))
    return hull(points / np.linalg.norm(points, axis=1)[:, None] * (1.5, 1.2, 1.0))


def written(tmp_path, vertices, facets, form="%.6f"):
    lines = [f"{len(vertices)} {len(facets)}"]
    lines += [" ".join(form % x for x in row) for row in vertices]
    lines += [" ".join(map(str, row)) for row in facets + 1]
    path = tmp_path / "shape.txt"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("model", [polyhedron, smooth])
@pytest.mark.parametrize("form", ["%.6f", "%.5g", "%.4e", "%.3f"])
def test_a_convex_model_is_convex_after_rounding(model, form, tmp_path):
    vertices, facets = model()
    path = written(tmp_path, vertices, facets, form)
    if (model, form) == (polyhedron, "%.3f"):  # slivers without area
        with pytest.raises(AttitudeError, match="degenerate"):
            shape.read(path)
        return
    mesh = shape.read(path)
    assert mesh.is_convex
    sun, observer = (1.0, 0.0, 0.0), (0.6, 0.0, 0.8)
    found = light_curve.brightness(mesh, "lommel-seeliger", sun, observer)
    plain = light_curve.brightness(mesh, "lommel-seeliger", sun, observer, shadows=False)
    assert found == plain
    tables = importlib.import_module("attitude.light_curve._brightness")._visibility
    assert mesh not in tables  # no table of shadows is made


def test_without_the_digits_it_is_concave(tmp_path):
    mesh = shape.read(written(tmp_path, *polyhedron()))
    assert mesh.rounding == 5e-7
    assert not mesh.with_rounding(0.0).is_convex
    assert not Mesh(mesh.vertices, mesh.facets).is_convex


@pytest.mark.parametrize("depth", [1e-3, 1e-5])
def test_a_dent_is_a_dent(depth, tmp_path):
    """From twenty times the rounding on; on facets without slivers."""
    mesh = shape.Ellipsoid((1.5, 1.2, 1.0)).facets(2000)
    vertices = np.array(mesh.vertices)
    corner = np.argmax(vertices[:, 2])
    around = np.unique(mesh.facets[np.any(mesh.facets == corner, axis=1)])
    around = around[around != corner]
    vertices[corner] = vertices[around].mean(axis=0) - (0.0, 0.0, depth)
    read = shape.read(written(tmp_path, vertices, mesh.facets))
    assert not read.is_convex


def test_the_rounding_goes_with_the_mesh(tmp_path):
    mesh = shape.read(written(tmp_path, *polyhedron()), unit="km")
    assert mesh.rounding == pytest.approx(5e-4, rel=1e-12)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for other in (
        mesh.moved((1.0, 2.0, 3.0)),
        mesh.turned(turn),
        mesh.divided(1),
        mesh.reversed().reversed(),
        mesh.joined(shape.box((1, 1, 1))),
        pickle.loads(pickle.dumps(mesh)),
    ):
        assert other.rounding == mesh.rounding
    assert mesh.scaled(2.0).rounding == 2.0 * mesh.rounding
    assert mesh.scaled(2.0).is_convex
    assert mesh.moved((1.0, 2.0, 3.0)).is_convex


@pytest.mark.parametrize(
    ("printed", "rounding"),
    [
        (["0.5", "-1.250000", "0.000125"], 5e-7),
        (["1.25", "-0.375", "10.5"], 0.05),
        (["1.2346e+01", "1.2346e-03"], 5e-4),
        (["1234.5", "12.345", "1.2"], 0.05),
        (["1", "2", "-3"], 0.5),
        (["0.0", "-0.0"], 0.0),
    ],
)
def test_the_rounding_of_printed_numbers(printed, rounding):
    assert of_printed(printed) == pytest.approx(rounding, rel=1e-12)
