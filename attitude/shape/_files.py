"""Shapes in files: OBJ and DAMIT's shape.txt, read strictly here; STL and PLY through trimesh."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, pairwise
from operator import mul, sub
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.quantity_text import quoted
from attitude._support.validation import flag
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import path_text, prefixed, whole
from attitude.errors import AttitudeError
from attitude.shape._mesh import SURFACE, Mesh, of_printed, of_single_precision

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath, FloatArray, IntArray

    Parts = tuple[FloatArray, IntArray, str | tuple[str, ...]]


_FORMATS = {".obj": "obj", ".txt": "damit", ".stl": "stl", ".ply": "ply"}
# Statements of OBJ without influence on the surface.
_IGNORED = {"vt", "vn", "vp", "o", "g", "s", "mtllib", "l", "p", "usemap", "maplib"}


def read(
    path: FilePath,
    *,
    unit: str = "m",
    format: str | None = None,
    closed: bool = True,
    repair: bool = False,
) -> Mesh:
    """The mesh in a file.

    Parameters
    ----------
    path : str or path
        OBJ (.obj), DAMIT (.txt), STL (.stl) or PLY (.ply); the last two need trimesh, which cuts
        the polygons of PLY as if they were convex.
    unit : str
        Of the numbers in the file, as astropy spells it: "m", "km".  DAMIT models mostly have a
        unit of their own: read them in "m", then use `Mesh.scaled`.
    format : "obj", "damit", "stl" or "ply", optional
        By default that of the ending of the file.
    closed : bool
        Whether the surface must bound a solid; False for a sheet such as a panel.
    repair : bool
        Whether trimesh merges vertices, drops degenerate facets, reverses facets and fills small
        holes first.  Materials are then lost.

    Returns
    -------
    Mesh

    Raises
    ------
    AttitudeError
        For a file that is missing, cut short or malformed (with the line), and for meshes that
        `Mesh` or, with ``closed``, `Mesh.require_closed` refuse.
    """
    closed, repair = flag(closed, "closed"), flag(repair, "repair")
    file, kind = _file_and_kind(path, format, "read")
    if not file.is_file():
        raise AttitudeError(f"{file}: there is no such file; give the path of a shape.")
    factor = _metres(unit)
    if kind in ("stl", "ply"):
        parts = _through_trimesh(file, kind)
        rounding = of_single_precision(parts[0])
    else:
        advice = 'give a shape in text, or format="stl" or "ply" for a binary one'
        lines = whole(file, advice).splitlines()
        parts = (read_obj if kind == "obj" else read_damit)(lines, file.name)
        rounding = of_printed(_coordinates(lines, kind))
    vertices, facets, materials = parts
    if repair:
        vertices, facets, materials = _repaired(vertices, facets)
    with prefixed(file.name):
        mesh = Mesh(vertices * factor, facets, materials, open=not closed)
        mesh = mesh.with_rounding(rounding * factor)
        return mesh.require_closed() if closed else mesh


def write(path: FilePath, mesh: Mesh, *, unit: str = "m", format: str | None = None) -> None:
    """Write a mesh; see `Mesh.write`."""
    _, kind = _file_and_kind(path, format, "written")
    vertices = mesh.vertices / _metres(unit)
    if kind in ("obj", "damit"):
        lines = obj_lines if kind == "obj" else damit_lines
        with written_whole(path, "shape") as text:
            text.writelines(f"{line}\n" for line in lines(vertices, mesh))
        return
    trimesh = _trimesh()
    with np.errstate(over="ignore"):
        single = vertices.astype(np.float32).astype(np.float64)
    try:
        Mesh(*_merged(single, mesh.facets), open=mesh.may_be_open)
    except AttitudeError as err:
        raise AttitudeError(
            f"{os.fspath(path)}: {kind} has 32 bits for a coordinate, too few for this mesh: it "
            "could not be read back. Move it to the origin, scale it, or write .obj."
        ) from err
    content = trimesh.Trimesh(vertices, mesh.facets, process=False).export(file_type=kind)
    with written_whole(path, "shape", binary=True) as binary:
        binary.write(content)


def obj_lines(vertices: FloatArray, mesh: Mesh) -> Iterator[str]:
    """The lines of a Wavefront OBJ: vertices (V, 3), then the facets with their materials."""
    yield from (f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist())
    material = SURFACE
    for name, (a, b, c) in zip(mesh.materials, (mesh.facets + 1).tolist(), strict=True):
        if name != material:
            if name.split() != name.split(" ") or "#" in name:
                raise AttitudeError(
                    f"the material {quoted(name)} cannot stand in an OBJ file: its name holds '#' "
                    "or blanks beyond single ones between words; rename it."
                )
            yield f"usemtl {name}"
            material = name
        yield f"f {a} {b} {c}"


def damit_lines(vertices: FloatArray, mesh: Mesh) -> Iterator[str]:
    """The lines of a DAMIT shape model; see `read_damit`."""
    yield f"{len(vertices)} {len(mesh)}"
    yield from (f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist())
    yield from (f"{a} {b} {c}" for a, b, c in (mesh.facets + 1).tolist())


def _file_and_kind(path, format, done):
    """The Path of a file to be read or written, and its format: as given, or of its ending."""
    file = Path(path_text(path))
    kind = _FORMATS.get(file.suffix.lower(), "") if format is None else str(format)
    if kind not in _FORMATS.values():
        other = "" if format is None else f", or give one of these as format=, not {quoted(format)}"
        raise AttitudeError(
            f"{file.name or file}: a shape is {done} as obj, damit, stl or ply; name the file "
            f".obj, .txt, .stl or .ply{other}."
        )
    return file, kind


def read_obj(lines: Iterable[str], name: str = "OBJ") -> Parts:
    """Vertices, facets and materials of the lines of a Wavefront OBJ; polygons become fans."""
    vertices: list[list[float]] = []
    facets: list[tuple[int, int, int]] = []
    materials: list[str] = []
    material = SURFACE
    for number, line in _statements(lines):
        key, *fields = line.split()
        where = f"{name}, line {number}"
        if key == "v":
            # x y z, with a weight or three colours after them in some dialects.
            if len(fields) not in (3, 4, 6, 7):
                raise AttitudeError(
                    f"{where}: a vertex has 3 coordinates, this has {len(fields)}: "
                    f"{quoted(line, 120)}; the file may be cut short."
                )
            vertices.append(_numbers(fields[:3], where))
        elif key == "f":
            corners = [_corner(field, len(vertices), where) for field in fields]
            if len(corners) < 3:
                raise AttitudeError(
                    f"{where}: a facet has at least 3 vertices, this has {len(corners)}: "
                    f"{quoted(line, 120)}; the file may be cut short."
                )
            fan = _fan(corners, vertices, where)
            facets += fan
            materials += [material] * len(fan)
        elif key == "usemtl":
            material = " ".join(fields) or SURFACE
        elif key not in _IGNORED:
            raise AttitudeError(
                f"{where}: {quoted(key)} is no statement of a polygon mesh; give v, f, usemtl and "
                "decorations (vt, vn, o, g, s, mtllib)."
            )
    if not facets:
        raise AttitudeError(f"{name}: holds no facets; give an OBJ file that is not cut short.")
    return np.array(vertices), np.array(facets), tuple(materials)


def _fan(corners: list[int], vertices: list[list[float]], where: str) -> list[tuple[int, int, int]]:
    """The triangles of a polygon, from its first corner from which none folds over another."""
    for k in range(len(corners)):
        first, *others = corners[k:] + corners[:k]
        fan = [(first, b, c) for b, c in pairwise(others)]
        if len(fan) == 1:
            return fan
        normals = [_area_vector(*(vertices[n] for n in facet)) for facet in fan]
        total = [sum(components) for components in zip(*normals, strict=True)]
        if all(sum(map(mul, normal, total)) > 0.0 for normal in normals):
            return fan
    raise AttitudeError(
        f"{where}: lines from no corner of the polygon cut it into triangles that lie side by "
        "side; give it as triangles."
    )


def _area_vector(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> tuple[float, ...]:
    """Twice the area vector of a triangle; in plain numbers, since files have many polygons."""
    (x, y, z), (u, v, w) = map(sub, b, a), map(sub, c, a)
    return y * w - z * v, z * u - x * w, x * v - y * u


def read_damit(lines: Iterable[str], name: str = "shape.txt") -> Parts:
    """Vertices, facets and material of the lines of a DAMIT shape model.

    The numbers of vertices and facets; x y z of each vertex; three vertex numbers of each facet.
    """
    statements = list(_statements(lines))
    if not statements:
        raise AttitudeError(
            f"{name}: is empty; its first line must hold the numbers of vertices and facets."
        )
    number, first = statements[0]
    where = f"{name}, line {number}"
    try:
        vertex_count, facet_count = (int(field) for field in first.split())
    except ValueError as err:
        raise AttitudeError(
            f"{where}: must give the numbers of vertices and facets, holds {first[:60]!r}."
        ) from err
    if vertex_count < 1 or facet_count < 1:
        raise AttitudeError(
            f"{where}: a shape needs vertices and facets, this counts {quoted(first)}."
        )
    expected = 1 + vertex_count + facet_count
    if len(statements) != expected:
        short = len(statements) < expected
        raise AttitudeError(
            f"{name}, line {statements[-1][0]}: the file {'ends here' if short else 'goes on'} "
            f"after {len(statements)} lines, where {vertex_count} vertices and {facet_count} "
            f"facets need {expected}; it is {'cut short' if short else 'not as line 1 counts'}."
        )
    vertices: list[list[float]] = []
    facets: list[list[int]] = []
    for at, line in statements[1:]:
        where = f"{name}, line {at}"
        fields = line.split()
        if len(fields) != 3:
            raise AttitudeError(
                f"{where}: must hold 3 numbers, holds {len(fields)}: {line[:60]!r}; the file may "
                "be cut short, or its facets may not be triangles."
            )
        if len(vertices) < vertex_count:
            vertices.append(_numbers(fields, where))
        else:
            facets.append([_corner(field, vertex_count, where) for field in fields])
    return np.array(vertices), np.array(facets), SURFACE


def _statements(lines: Iterable[str]) -> Iterator[tuple[int, str]]:
    """Number from 1 and text of each line that is neither empty nor a comment.

    A line that ends in a backslash goes on in the next one.
    """
    begun = ""
    for number, line in enumerate(chain(lines, [""]), start=1):
        text = f"{begun} {line.split('#', 1)[0]}".strip()
        begun = text[:-1] if text.endswith("\\") else ""
        if text and not begun:
            yield number, text


def _coordinates(lines: Iterable[str], kind: str | None) -> Iterator[str]:
    """The printed coordinates of the vertices of an OBJ or DAMIT file."""
    for number, (_, line) in enumerate(_statements(lines)):
        fields = line.split()
        if kind == "obj" and fields[0] == "v":
            yield from fields[1:4]
        elif kind == "damit" and number > 0 and any("." in field for field in fields):
            yield from fields


def _numbers(fields: Sequence[str], where: str) -> list[float]:
    try:
        values = [float(field) for field in fields]
    except ValueError as err:
        raise AttitudeError(f"{where}: {quoted(' '.join(fields))} are not numbers.") from err
    if not np.all(np.isfinite(values)):
        raise AttitudeError(
            f"{where}: {quoted(' '.join(fields))}; every coordinate must be finite."
        )
    return values


def _corner(field: str, count: int, where: str) -> int:
    """Index from 0 of "7", "7/1", "7//3", "7/1/3", or from the end, "-1"."""
    try:
        index = int(field.split("/", 1)[0])
    except ValueError as err:
        raise AttitudeError(f"{where}: {quoted(field)} is no vertex number.") from err
    resolved = count + index if index < 0 else index - 1
    if not 0 <= resolved < count:
        raise AttitudeError(
            f"{where}: vertex {index} does not exist; give one of the {count} above, numbered from "
            "1."
        )
    return resolved


def _metres(unit: str) -> float:
    from astropy import units

    try:
        return validation.positive(float(units.Unit(unit).to("m")), "unit")
    except (AttitudeError, ValueError, TypeError, units.UnitConversionError):
        raise AttitudeError(
            f'unit is {quoted(unit)}; give a length that astropy knows, such as "m" or "km".'
        ) from None


def _trimesh() -> Any:
    try:
        import trimesh
    except ImportError as err:
        raise AttitudeError(
            "STL and PLY files, and repair=True, need the package trimesh: "
            f"{validation.installing('mesh')}."
        ) from err
    return trimesh


def _through_trimesh(path: Path, kind: str) -> Parts:
    trimesh = _trimesh()
    try:
        loaded = trimesh.load(path, file_type=kind, force="mesh", process=False)
        vertices, facets = np.array(loaded.vertices), np.array(loaded.faces)
    except Exception as err:
        raise AttitudeError(
            f"{path.name}: trimesh cannot read it as {kind} ({err}); it may be cut short: give a "
            f"whole {kind} file."
        ) from err
    if len(facets) == 0:
        raise AttitudeError(f"{path.name}: holds no facets; give a whole {kind} file.")
    # STL repeats the corners of each facet.
    return *_merged(vertices, facets), SURFACE


def _merged(vertices: FloatArray, facets: IntArray) -> tuple[FloatArray, IntArray]:
    """The mesh with one vertex for equal coordinates."""
    vertices, number = np.unique(vertices, axis=0, return_inverse=True)
    return vertices, number.reshape(-1)[facets]


def _repaired(vertices: FloatArray, facets: IntArray) -> Parts:
    trimesh = _trimesh()
    mesh = trimesh.Trimesh(vertices, facets, process=True, validate=True)
    mesh.update_faces(mesh.nondegenerate_faces())
    try:
        trimesh.repair.fill_holes(mesh)
        trimesh.repair.fix_normals(mesh, multibody=True)
    except ImportError as err:
        raise AttitudeError(
            f"repair=True needs a package of trimesh that is not installed ({err}): "
            f"{validation.installing('mesh')}."
        ) from err
    return np.array(mesh.vertices), np.array(mesh.faces), SURFACE
