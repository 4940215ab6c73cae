"""Meshes, the ellipsoid and the spacecraft parts: integrals against closed forms and trimesh."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from attitude.errors import AttitudeError
from attitude.shape import Ellipsoid, Mesh, box, box_wing, cylinder
from attitude.shape._ellipsoid import unit_sphere

small = arrays(np.float64, 3, elements=st.floats(-10, 10))


def rotation(vector):
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vector).as_matrix()


def peanut(frequency=6):
    vertices, facets = unit_sphere(frequency)
    return Mesh(vertices * np.sqrt(vertices[:, :1] ** 2 + 0.12), facets)


def test_a_box_has_the_textbook_inertia():
    given_box = box((1.0, 2.0, 3.0), center=(100.0, 0.0, 0.0)).mass_properties(density=2.0)
    assert given_box.mass == pytest.approx(12.0, rel=1e-14)
    assert given_box.center_of_mass == pytest.approx([100.0, 0.0, 0.0], abs=1e-13)
    expected = np.diag([4 + 9, 1 + 9, 1 + 4])
    # 1e-12: coordinates of 100 m resolve 1e-14 m.
    assert np.max(np.abs(given_box.inertia - expected)) < 1e-12


def test_a_cylinder_has_the_volume_and_nearly_the_inertia_of_a_round_one():
    for axis, k in (("x", 0), ("y", 1), ("z", 2)):
        given_one = cylinder(0.5, 3.0, sides=200, axis=axis).mass_properties(density=10.0)
        mass = 10.0 * np.pi * 0.25 * 3.0
        assert given_one.mass == pytest.approx(mass, rel=1e-13)
        moments = np.diag(given_one.inertia)
        # The prism's second moment exceeds the circle's by (pi/n)^4 terms: 1e-7 at 200 sides.
        assert moments[k] == pytest.approx(mass * 0.25 / 2.0, rel=1e-6)
        assert moments[k - 1] == pytest.approx(mass * (0.25 / 4.0 + 9.0 / 12.0), rel=1e-6)


def test_facets_of_an_ellipsoid_approach_its_closed_form():
    exact = Ellipsoid((3.0, 2.0, 1.0))
    errors = []
    for count in (500, 2000, 8000):
        mesh = exact.facets(count)
        assert len(mesh) == count
        assert mesh.is_closed and mesh.is_convex
        # The facets of the sphere have its area before they are stretched.
        assert mesh.area == pytest.approx(exact.area, rel=1e-2 * 500 / count)
        properties, closed = mesh.mass_properties(density=1.0), exact.mass_properties(density=1.0)
        errors.append(np.max(np.abs(properties.inertia - closed.inertia)) / closed.inertia[2, 2])
    # As the number of facets: a factor of 4 each time.
    assert 3.5 < errors[0] / errors[1] < 4.5 and 3.5 < errors[1] / errors[2] < 4.5


def test_an_ellipsoid_of_given_moments():
    given = Ellipsoid((3.0, 1.0, 2.0))
    moments = np.diag(given.mass_properties(density=7.0).inertia)
    again = Ellipsoid.of_moments(moments, diameter=2.0 * 6.0 ** (1.0 / 3.0))
    assert again.semi_axes == pytest.approx(given.semi_axes, rel=1e-12)
    with pytest.raises(AttitudeError, match="less than the sum of the others"):
        Ellipsoid.of_moments((1, 1, 2))


def test_the_area_of_an_ellipsoid():
    assert Ellipsoid((2.0, 2.0, 2.0)).area == pytest.approx(16.0 * np.pi, rel=1e-14)
    a, c = 1.0, 2.0  # prolate: 2 pi a^2 (1 + c / (a e) asin e)
    e = np.sqrt(1.0 - a * a / c / c)
    expected = 2.0 * np.pi * a * a * (1.0 + c / (a * e) * np.arcsin(e))
    assert Ellipsoid((a, a, c)).area == pytest.approx(expected, rel=1e-14)


def test_a_spherical_shell():
    shell = Ellipsoid((1.0, 1.0, 1.0)).facets(20000).mass_properties(surface_density=3.0)
    assert shell.mass == pytest.approx(12.0 * np.pi, rel=1e-12)
    assert np.diag(shell.inertia) == pytest.approx(2.0 / 3.0 * shell.mass, rel=1e-3)


@given(small, small)
def test_moving_and_turning_a_solid_moves_and_turns_its_mass_properties(offset, vector):
    mesh = peanut(2)
    before = mesh.mass_properties(density=1.0)
    matrix = rotation(vector)
    after = mesh.turned(matrix).moved(offset).mass_properties(density=1.0)
    assert after.mass == pytest.approx(before.mass, rel=1e-13)
    assert np.max(np.abs(after.center_of_mass - matrix @ before.center_of_mass - offset)) < 1e-13
    assert np.max(np.abs(after.inertia - matrix @ before.inertia @ matrix.T)) < 1e-12


def test_against_trimesh():
    trimesh = pytest.importorskip("trimesh", reason="trimesh, the witness, is not installed")
    mesh = peanut().moved((0.3, -0.2, 0.1))
    theirs = trimesh.Trimesh(mesh.vertices, mesh.facets, process=False)
    theirs.density = 5.0
    ours = mesh.mass_properties(density=5.0)
    assert theirs.is_watertight
    assert ours.mass == pytest.approx(theirs.mass, rel=1e-12)
    assert np.max(np.abs(ours.center_of_mass - theirs.center_mass)) < 1e-12
    assert np.max(np.abs(ours.inertia - theirs.moment_inertia)) < 1e-11
    assert not mesh.is_convex


def test_density_or_surface_density():
    with pytest.raises(AttitudeError, match="either density"):
        box((1, 1, 1)).mass_properties()
    with pytest.raises(AttitudeError, match="greater than zero"):
        box((1, 1, 1)).mass_properties(density=-1.0)


def test_a_hole_names_its_facets():
    whole = Ellipsoid((1, 1, 1)).facets(80)
    holed = Mesh(whole.vertices, np.delete(whole.facets, 7, axis=0), open=True)
    edge = set(whole.facets[7])
    around = [k for k, f in enumerate(holed.facets) if len(edge & set(f)) == 2]
    assert list(holed.open_facets) == around
    with pytest.raises(AttitudeError, match=f"facets {around[0]}, {around[1]}, {around[2]} lie"):
        holed.mass_properties(density=1.0)
    assert holed.mass_properties(surface_density=1.0).mass > 0.0


def turned(facets):
    facets[3] = facets[3, ::-1]
    return facets


@pytest.mark.parametrize(
    ("spoil", "sentence", "always"),
    [
        (turned, r"facets 2, 3, \d+, \d+ run against a neighbour: .*from vertex \d to", True),
        (lambda f: np.append(f, f[7:8], axis=0), "facets 7 and 12 are doubled", True),
        (lambda f: np.append(f, np.roll(f[7:8], 1, axis=1), axis=0), "facets 7 and 12 are", True),
        (lambda f: np.append(f, f[7:8, ::-1], axis=0), "run against a neighbour", True),
        (lambda f: np.delete(f, 5, axis=0), "facets 0, 4, 9 lie at a hole.*open=True", False),
    ],
)
def test_a_facet_turned_doubled_or_missing_is_refused_with_its_number(spoil, sentence, always):
    """Summed silently, one of them changes the brightness of a box by up to 17 %."""
    whole = box((3, 2, 1))
    facets = spoil(whole.facets.copy())
    with pytest.raises(AttitudeError, match=sentence):
        Mesh(whole.vertices, facets)
    if always:
        with pytest.raises(AttitudeError, match=sentence):
            Mesh(whole.vertices, facets, open=True)
    else:
        assert not Mesh(whole.vertices, facets, open=True).is_closed


def test_a_facet_doubled_between_vertices_of_its_own_is_refused():
    whole = box((3, 2, 1))
    vertices = np.concatenate([whole.vertices, whole.corners[4]])
    with pytest.raises(AttitudeError, match="facets 4 and 12 are doubled"):
        Mesh(vertices, np.append(whole.facets, [[8, 9, 10]], axis=0), open=True)
    with pytest.raises(AttitudeError, match="facets 0 and 12 are doubled"):
        whole.joined(whole)
    with pytest.raises(AttitudeError, match="open is '1'"):
        Mesh(whole.vertices, whole.facets, open="1")


def test_sheets_plates_and_parts_that_touch_are_legal():
    sheet = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], open=True)
    for mesh in (sheet, sheet.moved((1, 0, 0)), sheet.divided(1), sheet.reversed()):
        assert mesh.may_be_open and not mesh.is_closed
    assert (
        sheet.joined(box((1, 1, 1))).may_be_open and pickle.loads(pickle.dumps(sheet)).may_be_open
    )
    # The two sides of a plate, and two boxes with one edge in common.
    assert Mesh(sheet.vertices, [[0, 1, 2], [0, 2, 1]]).is_closed
    one, other = box((1, 1, 1)), box((1, 1, 1), center=(1, 1, 0))
    both = np.concatenate([one.vertices, other.vertices])
    vertices, number = np.unique(both, axis=0, return_inverse=True)
    joined = number.reshape(-1)[np.concatenate([one.facets, other.facets + 8])]
    assert len(vertices) == 14 and Mesh(vertices, joined).volume == pytest.approx(2.0)


def rises(mesh):
    """The largest height of a vertex above a facet, over the size: the definition of convexity."""
    middle = np.mean(mesh.vertices, axis=0)
    height = mesh.normals @ (mesh.vertices - middle).T
    level = np.einsum("fi,fi->f", mesh.normals, mesh.centroids - middle)
    return np.max(height - level[:, None]) / np.max(np.abs(mesh.vertices - middle))


def hull(points):
    from scipy.spatial import ConvexHull

    found = ConvexHull(points)
    facets = found.simplices.copy()
    a, b, c = np.moveaxis(points[facets], 1, 0)
    inward = np.einsum("fi,fi->f", np.cross(b - a, c - a), found.equations[:, :3]) < 0.0
    facets[inward] = facets[inward, ::-1]
    used, number = np.unique(facets, return_inverse=True)
    return Mesh(points[used], number.reshape(-1, 3))


def test_convexity_by_edges_is_that_of_the_definition():
    rng = np.random.default_rng(4)
    for k in range(60):
        points = rng.normal(size=(30, 3)) * rng.uniform(0.01, 3, 3) + 10.0 ** rng.uniform(-3, 3)
        mesh = hull(points)
        assert mesh.is_convex and rises(mesh) < 1e-12
        # One vertex drawn inward by 1e-9 to 1e-1: mostly a dent at once, sometimes not yet.
        vertices = mesh.vertices.copy()
        moved = rng.integers(len(vertices))
        vertices[moved] += (np.mean(vertices, axis=0) - vertices[moved]) * 10.0 ** -(1 + k % 9)
        dented = Mesh(vertices, mesh.facets)
        assert dented.is_convex == (rises(dented) < 1e-12)
    assert not peanut().is_convex


def test_convex_edges_alone_do_not_make_a_body_convex():
    """A surface that winds twice about its middle has convex edges, and two parts have as well."""
    angle = np.arange(5) * 4.0 * np.pi / 5.0
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(5)], axis=1)
    k = np.arange(5)
    caps = [
        np.stack([k, (k + 1) % 5, np.full(5, 5)], 1),
        np.stack([(k + 1) % 5, k, np.full(5, 6)], 1),
    ]
    star = Mesh(np.concatenate([ring, [[0, 0, 0.7], [0, 0, -0.7]]]), np.concatenate(caps))
    assert star.is_closed and not len(star.inward_facets) and not star.is_convex
    assert not box((1, 1, 1)).joined(box((1, 1, 1), center=(3, 0, 0))).is_convex
    assert not box((2, 2, 2)).joined(box((1, 1, 1))).is_convex
    # A body so flat that its middle is in its surface, and a plate without a volume.
    assert box((1, 1, 1e-13)).is_convex
    assert Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]]).is_convex


def test_the_test_of_convexity_is_linear(monkeypatch):
    """No height of every vertex above every facet: those of 80,000 facets took 12 s."""
    from attitude.shape import _mesh

    def refuse(*arguments):
        raise AssertionError("all pairs were compared")

    monkeypatch.setattr(_mesh, "_all_below", refuse)
    assert Ellipsoid((3, 2, 1)).facets(80_000).is_convex and not peanut(20).is_convex


def test_an_inside_out_body_is_refused_and_a_cavity_is_not():
    outer, inner = box((4, 4, 4)), box((1, 1, 1))
    with pytest.raises(AttitudeError, match="inside out: the normals of facets 0, 1"):
        outer.reversed().require_closed()
    hollow = outer.joined(inner.reversed())
    assert hollow.mass_properties(density=1.0).mass == pytest.approx(63.0)
    beside = outer.joined(inner.moved((9, 0, 0)).reversed())
    assert list(beside.inward_facets) == list(range(12, 24))


@pytest.mark.parametrize(
    ("vertices", "facets", "sentence"),
    [
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], "facets 0 are degenerate"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 1]], "facets 0 are degenerate"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "vertices 2 hold NaN"),
        ([[0, 0, 0], [1, 0, 0], [0, -1e61, 0]], [[0, 1, 2]], r"vertex lies at 1e\+61 m; give at"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "facets 0 name vertices"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], r"give \(V, 3\)"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1]], "facets is ragged"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0.0, 1.0, 2.0]], "whole numbers"),
    ],
)
def test_bad_meshes_are_refused_in_a_sentence(vertices, facets, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        Mesh(vertices, facets)


def test_bad_parts_are_refused_in_a_sentence():
    with pytest.raises(AttitudeError, match="must be greater than zero"):
        Ellipsoid((1, 0, 1))
    with pytest.raises(AttitudeError, match="each edge"):
        box((1, -1, 1))
    with pytest.raises(AttitudeError, match="sides is 2"):
        cylinder(1, 1, sides=2)
    with pytest.raises(AttitudeError, match="gap is -1"):
        box_wing((1, 1, 1), (1, 1), gap=-1)
    with pytest.raises(AttitudeError, match="materials is 5; give four names"):
        box_wing((1, 1, 1), (1, 1), materials=5)
    with pytest.raises(AttitudeError, match="count is 3"):
        Ellipsoid((1, 1, 1)).facets(3)
    with pytest.raises(AttitudeError, match="materials is 5"):
        Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], 5)
    with pytest.raises(AttitudeError, match="give another Mesh"):
        box((1, 1, 1)).joined(Ellipsoid((1, 1, 1)))
    with pytest.raises(AttitudeError, match="no rotation"):
        box((1, 1, 1)).turned(np.diag([1.0, 1.0, -1.0]))


def test_divided_facets_are_the_same_surface():
    whole = box_wing((2, 3, 4), (5, 2), gap=0.5)
    fine = whole.divided(2)
    assert len(fine) == 16 * len(whole) and fine.is_closed and not len(fine.inward_facets)
    assert fine.volume == pytest.approx(whole.volume, rel=1e-13)
    assert fine.areas.reshape(-1, 16).sum(axis=1) == pytest.approx(whole.areas, rel=1e-13)
    assert np.allclose(fine.normals[::16], whole.normals)
    assert fine.materials[::16] == whole.materials and whole.divided(0) is whole
    with pytest.raises(AttitudeError, match="divided -1 times"):
        whole.divided(-1)


def test_box_wing_faces_where_it_says():
    satellite = box_wing((2, 3, 4), (5, 2), gap=0.5, wing_axis="y")
    assert satellite.is_closed and not len(satellite.inward_facets) and not satellite.is_convex
    front = [k for k, name in enumerate(satellite.materials) if name == "panel front"]
    assert np.allclose(satellite.normals[front], [0, 0, 1])
    assert np.sum(satellite.areas[front]) == pytest.approx(2 * 5 * 2)
    turned = box_wing((2, 3, 4), (5, 2), wing_axis="y", wing_angle=np.pi / 2)
    assert np.allclose(turned.normals[front], [1, 0, 0])


def test_quantities_are_metres_inside():
    from astropy import units

    assert Ellipsoid((1, 1, 1) * units.km).volume == pytest.approx(4e9 / 3 * np.pi)


def test_values_are_frozen_also_after_pickling():
    mesh = pickle.loads(pickle.dumps(box((1, 2, 3), material="foil")))
    for array in (mesh.vertices, mesh.facets, mesh.areas, mesh.normals):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    assert mesh.materials == ("foil",) * 12
    ellipsoid = pickle.loads(pickle.dumps(Ellipsoid((1, 2, 3))))
    assert not ellipsoid.semi_axes.flags.writeable
    assert not ellipsoid.mass_properties(density=1).inertia.flags.writeable
