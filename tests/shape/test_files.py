"""Shapes from files: what is read, and what is refused with its line."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude.errors import AttitudeError
from attitude.shape import Ellipsoid, box, compare, read

CUBE = box((1, 2, 3), material="foil")


def obj_of(mesh):
    lines = ["# a comment", "mtllib some.mtl", "o body", "usemtl foil"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a + 1}/1/1 {b + 1}//2 {c + 1}" for a, b, c in mesh.facets.tolist()]
    return "\n".join(lines) + "\n"


def damit_of(mesh):
    lines = [f"{len(mesh.vertices)} {len(mesh)}"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [f" {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.facets.tolist()]
    return "\n".join(lines) + "\n"


def written(folder, name, text):
    path = folder / name
    path.write_text(text)
    return path


def test_obj_and_damit_give_the_mesh_that_was_written(tmp_path):
    for name, text in (("a.obj", obj_of(CUBE)), ("shape.txt", damit_of(CUBE))):
        mesh = read(written(tmp_path, name, text))
        assert np.array_equal(mesh.vertices, CUBE.vertices)
        assert np.array_equal(mesh.facets, CUBE.facets)
    assert read(tmp_path / "a.obj").materials == CUBE.materials
    assert read(tmp_path / "a.obj", unit="km").volume == pytest.approx(6e9)


def test_obj_polygons_and_numbers_from_the_end(tmp_path):
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE.vertices)
    text += "".join("f " + " ".join(str(k - 8) for k in q) + "\n" for q in quads)
    assert np.array_equal(read(written(tmp_path, "q.obj", text)).facets, CUBE.facets)
    lines = text.replace(" -1", " \\\n-1")
    assert np.array_equal(read(written(tmp_path, "q.obj", lines)).facets, CUBE.facets)
    with pytest.raises(AttitudeError, match="line 27: vertex -99"):
        read(written(tmp_path, "q.obj", lines + "f -1 \\\n-99 1"))


def test_obj_polygons_that_are_not_convex(tmp_path):
    """A prism over a dart, each base given from each of its corners; volume 4."""
    base = [(4, 0), (0, 0), (0, 4), (1, 1)]
    text = "".join(f"v {x} {y} {z}\n" for z in (0, 1) for x, y in base)
    text += "".join(f"f {k + 1} {k + 5} {(k + 1) % 4 + 5} {(k + 1) % 4 + 1}\n" for k in range(4))
    for k in range(4):
        turned = [(j + k) % 4 + 1 for j in range(4)]
        bases = f"f {' '.join(map(str, turned))}\nf {' '.join(str(j + 4) for j in turned[::-1])}\n"
        mesh = read(written(tmp_path, "dart.obj", text + bases))
        assert mesh.volume == pytest.approx(4.0)
        assert mesh.area == pytest.approx(2 * 4.0 + 8.0 + 2.0 * np.sqrt(10.0))
    crossed = written(tmp_path, "x.obj", text + "f 1 6 5 2\n")
    with pytest.raises(AttitudeError, match=r"line 13: .*give it as triangles"):
        read(crossed, closed=False)


@pytest.mark.parametrize(
    ("name", "spoil", "sentence"),
    [
        ("a.obj", lambda t: t[: t.index("f ") - 30], r"holds no facets|line \d+: a vertex has"),
        ("a.obj", lambda t: t.replace("f 1/1/1 2//2 4\n", "f 1 2\n"), r"line 13: a facet has at"),
        ("a.obj", lambda t: t.replace("f 1/1/1", "f 99", 1), "line 13: vertex 99 does not exist"),
        ("a.obj", lambda t: t.replace("f 1/1/1", "f 0", 1), "vertex 0 does not exist"),
        ("a.obj", lambda t: t.replace("v -0.5", "v nan", 1), "line 5: .*finite"),
        ("a.obj", lambda t: t.replace("v -0.5", "v x", 1), "line 5: .*not numbers"),
        ("a.obj", lambda t: "curv2 1 2 3\n" + t, "line 1: 'curv2' is no statement"),
        ("a.obj", lambda t: t[: t.rindex("f ")], "a.obj: the mesh is not closed: facets"),
        ("s.txt", lambda t: t[: t.rindex("\n", 0, -1)], "line 20: the file ends here"),
        ("s.txt", lambda t: t[:-4], r"line 21: must hold 3 numbers, holds 1"),
        ("s.txt", lambda t: t + "1 2 3\n", "line 22: the file goes on"),
        ("s.txt", lambda t: t.replace("8 12", "eight 12"), "line 1: must give the numbers"),
        ("s.txt", lambda t: "", "is empty"),
    ],
)
def test_files_cut_short_or_wrong_name_their_line(tmp_path, name, spoil, sentence):
    text = spoil(obj_of(CUBE) if name.endswith("obj") else damit_of(CUBE))
    with pytest.raises(AttitudeError, match=sentence):
        read(written(tmp_path, name, text))


def test_open_surfaces_are_read_when_asked_for(tmp_path):
    text = obj_of(CUBE)
    path = written(tmp_path, "open.obj", text[: text.rindex("f ")])
    assert len(read(path, closed=False)) == 11


def test_names_and_formats(tmp_path):
    with pytest.raises(AttitudeError, match="there is no such file"):
        read(tmp_path / "none.obj")
    with pytest.raises(AttitudeError, match=r"name the file \.obj"):
        read(tmp_path / "shape.xyz")
    for unit in ("kg", "-1 km"):
        with pytest.raises(AttitudeError, match=f"unit is '{unit}'"):
            read(written(tmp_path, "a.obj", obj_of(CUBE)), unit=unit)
    (tmp_path / "b.obj").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(AttitudeError, match="is not text"):
        read(tmp_path / "b.obj")


@pytest.mark.parametrize("kind", ["stl", "ply"])
def test_stl_and_ply_through_trimesh(tmp_path, kind):
    trimesh = pytest.importorskip("trimesh", reason="trimesh, which reads them, is not installed")
    shape = Ellipsoid((3, 2, 1)).facets(320)
    path = tmp_path / f"a.{kind}"
    trimesh.Trimesh(shape.vertices, shape.facets, process=False).export(path)
    mesh = read(path)
    assert len(mesh) == 320 and mesh.is_closed
    assert mesh.volume == pytest.approx(shape.volume, rel=1e-6)  # STL holds single precision
    path.write_bytes(path.read_bytes()[:4000])
    with pytest.raises(AttitudeError, match=f"a.{kind}: "):
        read(path)


def test_repair_turns_facets_round_and_closes_holes(tmp_path):
    pytest.importorskip("trimesh", reason="trimesh, which repairs, is not installed")
    pytest.importorskip("networkx", reason="networkx, with which trimesh repairs, is not installed")
    mesh = Ellipsoid((1, 1, 1)).facets(80)
    facets = np.delete(mesh.facets, 4, axis=0)
    facets[10] = facets[10, ::-1]
    spoilt = SimpleNamespace(vertices=mesh.vertices, facets=facets)
    path = written(tmp_path, "r.obj", obj_of(spoilt))
    for closed in (True, False):
        with pytest.raises(
            AttitudeError, match=r"r\.obj: facets 7, 8, 9, 10 run against a neighbour"
        ):
            read(path, closed=closed)
    assert read(path, repair=True).volume == pytest.approx(mesh.volume, rel=1e-12)


@pytest.mark.parametrize("name", ["a.obj", "shape.txt", "a.stl", "a.ply"])
def test_a_mesh_that_is_written_is_read_back(tmp_path, name):
    if name.endswith(("stl", "ply")):
        pytest.importorskip("trimesh", reason="trimesh is not installed")
    mesh = Ellipsoid((3.1, 2.0, 0.7)).facets(80).joined(box((1, 1, 1)).moved((9, 0, 0)))
    mesh.write(tmp_path / name)
    again = read(tmp_path / name)
    if name in ("a.obj", "shape.txt"):
        assert np.array_equal(again.vertices, mesh.vertices)
        assert np.array_equal(again.facets, mesh.facets)
    assert again.volume == pytest.approx(mesh.volume, rel=2e-7)  # STL, PLY: 32 bits of coordinates
    mesh.write(tmp_path / name, unit="km")
    assert read(tmp_path / name, unit="km").volume == pytest.approx(mesh.volume, rel=2e-7)


@pytest.mark.parametrize("kind", ["stl", "ply"])
def test_a_mesh_is_not_written_where_32_bits_merge_its_vertices(tmp_path, kind):
    pytest.importorskip("trimesh", reason="trimesh is not installed")
    for mesh in (CUBE.moved((1e8, 0, 0)), CUBE.scaled(1e39)):
        with pytest.raises(AttitudeError, match=f"{kind} has 32 bits for a coordinate"):
            mesh.write(tmp_path / f"a.{kind}")
    assert list(tmp_path.iterdir()) == []


def test_materials_are_written_to_obj(tmp_path):
    both = CUBE.joined(box((1, 1, 1), material="solar panel").moved((5, 0, 0)))
    both.write(tmp_path / "a.obj")
    assert read(tmp_path / "a.obj").materials == both.materials
    odd = box((1, 1, 1), material="a  #b")
    with pytest.raises(AttitudeError, match="cannot stand in an OBJ"):
        odd.write(tmp_path / "b.obj")
    assert not (tmp_path / "b.obj").exists()


@pytest.mark.parametrize("name", ["a.toml", "a", "a.xyz"])
def test_a_mesh_is_not_written_under_another_ending(tmp_path, name):
    with pytest.raises(AttitudeError, match="written as obj, damit, stl or ply"):
        CUBE.write(tmp_path / name)
    with pytest.raises(AttitudeError, match="unit"):
        CUBE.write(tmp_path / "a.obj", unit="s")
    assert list(tmp_path.iterdir()) == []


def turn(*angles):
    return Rotation.from_euler("ZXZ", angles).as_matrix()


def test_equal_bodies_have_all_in_common():
    for mesh in (Ellipsoid((3, 2, 1)).facets(500), CUBE, CUBE.joined(CUBE.moved((2, 1, 0.5)))):
        other = mesh.turned(turn(0.3, 1.0, 2.0)).scaled(7.0).moved((5, 6, 7))
        found = compare(mesh, other)
        assert found.overlap == pytest.approx(1.0, abs=1e-6)
        assert found.axes[0] == pytest.approx(found.axes[1], rel=1e-9)
        # The axes of the second become those of the first, but for the symmetry of the body.
        tensor = [each.mass_properties(density=1.0).inertia for each in (mesh, other)]
        turned = found.matrix @ tensor[1] @ found.matrix.T
        assert turned / np.trace(turned) == pytest.approx(tensor[0] / np.trace(tensor[0]), abs=1e-7)
    # Of the turns that carry a body into itself the least one.
    for other in (CUBE, Ellipsoid((1, 2, 3))):
        assert compare(CUBE, other).turn == pytest.approx(0.0, abs=1e-9)


def test_the_overlap_of_cubes_and_of_ellipsoids():
    """A cube turned by 45 degrees has an octagon in common; concentric balls scale by volume."""
    cube = box((1, 1, 1))
    octagon = 2.0 * (np.sqrt(2.0) - 1.0)
    found = compare(cube, cube.turned(turn(np.pi / 4, 0, 0)), turned=False)
    assert found.overlap == pytest.approx(octagon / (2.0 - octagon), rel=1e-12)
    assert compare(cube, cube.turned(turn(0.2, 0.1, 0.0))).overlap > 1.0 - 1e-4
    # By integration over directions: the smaller of both radii, cubed.
    a, b = np.array([3.0, 2.0, 1.0]) / 6.0 ** (1 / 3), np.ones(3)
    on = Ellipsoid((1, 1, 1)).facets(20_000)
    u = on.centroids / np.linalg.norm(on.centroids, axis=1)[:, None]
    radii = [1.0 / np.linalg.norm(u / axes, axis=1) for axes in (a, b)]
    common = np.average(np.minimum(*radii) ** 3, weights=on.areas)
    found = compare(Ellipsoid((3, 2, 1)), Ellipsoid((1, 1, 1)))
    assert found.overlap == pytest.approx(common / (2.0 - common), abs=3e-3)  # 980 facets
    assert found.axes[0] == pytest.approx(a, rel=3e-3)


def test_a_body_that_is_not_convex_is_compared_by_points():
    """Two boxes apart against the larger one: at equal volumes the common part is known."""
    apart = box((2, 2, 2)).joined(box((1, 1, 1)).moved((5, 0, 0)))
    found = compare(apart, apart, turned=False)
    assert found.overlap == 1.0
    half = box((2, 2, 2)).joined(box((2, 2, 2)).moved((0, 0, 2.5)))  # two cubes, a gap between
    single = box((2, 2, 4.5)).moved((0, 0, 1.25))
    # Both have their centre in the gap; volumes 16 and 18, scaled to the same.
    factor = (16.0 / 18.0) ** (1.0 / 3.0)
    top = 2.25 * factor  # of the single box
    common = (2.0 * factor) ** 2 * 2.0 * (top - 0.25) / 16.0
    found = compare(half, single, turned=False)
    assert found.overlap == pytest.approx(common / (2.0 - common), abs=5e-3)


def test_only_shapes_are_compared():
    with pytest.raises(AttitudeError, match="second is"):
        compare(CUBE, (3, 2, 1))
    with pytest.raises(AttitudeError, match="turned is"):
        compare(CUBE, CUBE, turned="yes")
