"""The flat sides of a mesh: facets of one normal and one material."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.shape.mesh import Mesh
from attitude.validation import shown

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray

# Normals that differ by less than this, rad, are one: rounding of meshes in text files.
_SAME = 1e-5


class FlatSide(NamedTuple):
    """The facets of a mesh that share a normal and a material.

    Attributes
    ----------
    name : str
        The material; where several sides have it, with the axis of the normal ("body +x") or a
        number ("body 3", in order of the area).
    material : str
    normal : (3,) array
        Outward unit normal, body axes.
    area : float
        m2.
    facets : (K,) array of int
        Indices of the facets.
    """

    name: str
    material: str
    normal: FloatArray
    area: float
    facets: IntArray


def flat_sides(mesh: Mesh) -> tuple[FlatSide, ...]:
    """The flat sides of a mesh, of each material in order of decreasing area.

    Parameters
    ----------
    mesh : Mesh

    Raises
    ------
    AttitudeError
        For anything else.

    >>> from attitude.shape import box
    >>> [side.name for side in flat_sides(box((3, 2, 1)))][:2]
    ['surface -z', 'surface +z']
    """
    if not isinstance(mesh, Mesh):
        raise AttitudeError(f"mesh is {shown(mesh)}; give a Mesh, which has flat sides.")
    cell = np.rint(mesh.normals / _SAME).astype(np.int64)
    groups: dict[tuple[str, int, int, int], list[int]] = {}
    for k, (material, place) in enumerate(zip(mesh.materials, cell.tolist(), strict=True)):
        groups.setdefault(_place(groups, material, place), []).append(k)
    found = []
    for (material, *_), members in groups.items():
        facets = frozen(np.array(members))
        vector = np.sum(mesh.area_vectors[facets], axis=0)
        area = float(np.sum(mesh.areas[facets]))
        found.append((material, frozen(vector / np.linalg.norm(vector)), area, facets))
    found.sort(key=lambda each: (each[0], -round(each[2], 12), int(each[3][0])))
    return tuple(_named(found))


def _place(groups, material, place):
    """The key of the group of a facet: that of a neighbouring cell, if there is one."""
    x, y, z = place
    for key in ((material, x + i, y + j, z + k) for i in (0, -1, 1) for j in (0, -1, 1)
                for k in (0, -1, 1)):  # fmt: skip
        if key in groups:
            return key
    return material, x, y, z


def _named(found):
    """The sides with their names."""
    counts: dict[str, int] = {}
    alone = {material: sum(each[0] == material for each in found) == 1 for material, *_ in found}
    for material, normal, area, facets in found:
        counts[material] = counts.get(material, 0) + 1
        name = material
        if not alone[material]:
            axis = int(np.argmax(np.abs(normal)))
            name = f"{material} {counts[material]}"
            if abs(normal[axis]) > 1.0 - 1e-11:
                name = f"{material} {'-+'[int(normal[axis] > 0.0)]}{'xyz'[axis]}"
        yield FlatSide(name, material, normal, area, facets)
