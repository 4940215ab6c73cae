"""Shapes from files: what is read, and what is refused with its line."""

from types import SimpleNamespace

import numpy as np
import pytest

from attitude.errors import AttitudeError
from attitude.shape import Ellipsoid, box, read

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
    with pytest.raises(AttitudeError, match="or give format="):
        read(tmp_path / "shape.xyz")
    with pytest.raises(AttitudeError, match="unit is 'kg'"):
        read(written(tmp_path, "a.obj", obj_of(CUBE)), unit="kg")
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
