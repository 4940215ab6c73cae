"""Boxes, cylinders and the box-wing satellite, as closed meshes about the origin."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

import numpy as np

from attitude._support import validation
from attitude._support.synonyms import arguments
from attitude.errors import AttitudeError
from attitude.shape._mesh import SURFACE, Mesh

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude._support.annotations import Real, Reals


_AXES = ("x", "y", "z")


@arguments({}, "box((1, 2, 3))")
def box(
    size: Reals,
    *others: Real,
    material: str | Iterable[str] = SURFACE,
    center: Reals = (0.0, 0.0, 0.0),
) -> Mesh:
    """A box of 12 facets, two a side in the order -x, +x, -y, +y, -z, +z.

    Parameters
    ----------
    size : (3,) array_like
        Edges along x, y, z: m.  Three numbers may also be three arguments.
    material : str or sequence of 12 str
    center : (3,) array_like
        m.

    Raises
    ------
    AttitudeError
        For edges that are not greater than zero.
    """
    if others:
        size = cast("Reals", [size, *others])
    edges = validation.real(size, "size", shape=(3,), unit="m")
    middle = validation.real(center, "center", shape=(3,), unit="m")
    if not np.all(edges > 0.0):
        raise AttitudeError(f"size is {edges.tolist()}; each edge must be greater than zero, in m.")
    bits = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    facets = [t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    return Mesh(middle + (bits - 0.5) * edges, facets, material)


def cylinder(
    radius: Real,
    height: Real,
    *,
    sides: int = 64,
    axis: str = "z",
    material: str | Iterable[str] = SURFACE,
) -> Mesh:
    """A prism with the volume of a circular cylinder, about the origin along a body axis.

    Its cross-section has the area of the circle, pi radius^2, so volume and mass are those of the
    cylinder; the lateral area differs by 0.04% at 64 sides, falling with their square.

    Parameters
    ----------
    radius, height : float or Quantity
        m.
    sides : int
        From 3 to 100,000.
    axis : "x", "y" or "z"
    material : str, or sequence of 4 sides str
        Facets of the sides first, then those of the two ends.

    Raises
    ------
    AttitudeError
        For lengths that are not greater than zero, and another number of sides.
    """
    r = validation.positive(radius, "radius", unit="m")
    length = validation.positive(height, "height", unit="m")
    along = _AXES.index(validation.one_of(axis, "axis", _AXES))
    sides = validation.count(sides, "sides", 3, 100_000)
    turn = 2.0 * np.pi / sides
    rim = r * np.sqrt(turn / np.sin(turn))
    k = np.arange(sides)
    circle = np.stack([rim * np.cos(k * turn), rim * np.sin(k * turn)], axis=1)
    flat = np.concatenate([circle, circle, np.zeros((2, 2))])
    level = np.repeat([-0.5, 0.5, -0.5, 0.5], [sides, sides, 1, 1]) * length
    # A cyclic permutation of the axes is a rotation: normals stay outward.
    vertices = np.roll(np.column_stack([flat, level]), along - 2, axis=1)
    after, top = (k + 1) % sides, k + sides
    bottom, lid = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    around = [(k, after, top), (after, after + sides, top)]
    ends = [(bottom, after, k), (lid, top, after + sides)]
    facets = np.concatenate([np.stack(corners, axis=1) for corners in around + ends])
    return Mesh(vertices, facets, material)


def box_wing(
    body: Reals,
    wing: Reals,
    *,
    gap: Real = 0.0,
    thickness: Real = 0.02,
    wing_axis: str = "y",
    wing_angle: Real = 0.0,
    wings: int = 2,
    materials: Iterable[str] = ("body", "panel front", "panel back", "panel edge"),
) -> Mesh:
    """A box with one or two solar wings: the satellite of radiation-pressure models.

    Parameters
    ----------
    body : (3,) array_like
        Edges of the box along x, y, z: m.
    wing : (2,) array_like
        Length of a wing along the wing axis and its width across: m.
    gap : float or Quantity
        Between box and wing: m, not negative.
    thickness : float or Quantity
        Of a wing: m.
    wing_axis : "x", "y" or "z"
        The axis along which the wings extend, symmetric about the centre of the box.
    wing_angle : float or Quantity
        Turn of the wings about that axis, rad.  At zero the fronts face the next axis in the order
        x, y, z, x (z for wings along y).
    wings : 1 or 2
        A single wing is on the positive side.
    materials : four str
        Names for box, wing front, wing back and wing edges.

    Returns
    -------
    Mesh
        12 facets for the box and 12 for each wing; parts do not overlap.

    Raises
    ------
    AttitudeError
        For lengths that are not greater than zero, a negative gap, another axis or number of wings
        or of materials.
    """
    edges = validation.real(body, "body", shape=(3,), unit="m")
    length, width = validation.real(wing, "wing", shape=(2,), unit="m")
    apart = validation.number(gap, "gap", unit="m")
    depth = validation.positive(thickness, "thickness", unit="m")
    angle = validation.number(wing_angle, "wing_angle", unit="rad")
    along = _AXES.index(validation.one_of(wing_axis, "wing_axis", _AXES))
    wings = validation.count(wings, "wings", 1, 2)
    if apart < 0.0:
        raise AttitudeError(
            f"gap is {apart!r} m; it must not be negative, or the parts would overlap."
        )
    names = tuple(materials) if isinstance(materials, Iterable) else ()
    if isinstance(materials, str) or len(names) != 4:
        raise AttitudeError(
            f"materials is {validation.shown(materials)}; give four names: of the box, the wing's "
            "front, its back and its edges."
        )
    front, across = (along + 1) % 3, (along + 2) % 3
    size = np.empty(3)
    size[along], size[front], size[across] = length, depth, width
    turn = np.eye(3)
    c, s = np.cos(angle), np.sin(angle)
    turn[front, front], turn[front, across] = c, -s
    turn[across, front], turn[across, across] = s, c
    mesh = box(edges, material=names[0])
    for side in (1.0, -1.0)[:wings]:
        center = np.zeros(3)
        center[along] = side * (edges[along] / 2.0 + apart + length / 2.0)
        labels = [names[3]] * 12
        labels[4 * front + 2 : 4 * front + 4] = [names[1]] * 2
        labels[4 * front : 4 * front + 2] = [names[2]] * 2
        mesh = mesh.joined(box(size, material=labels, center=center).turned(turn))
    return mesh
