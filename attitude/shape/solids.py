"""Boxes, cylinders and the box-wing satellite, as closed meshes about the origin."""

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.shape.mesh import SURFACE, Mesh

_AXES = {"x": 0, "y": 1, "z": 2}


def box(size, *, material=SURFACE, center=(0.0, 0.0, 0.0)):
    """A box of (3,) m along x, y, z about `center`: 12 facets, two a side (-x, +x, -y, ... +z)."""
    size = validation.real(size, "size", shape=(3,), unit="m")
    center = validation.real(center, "center", shape=(3,), unit="m")
    if not np.all(size > 0.0):
        raise AttitudeError(f"size is {size.tolist()}; each edge must be greater than zero, in m.")
    bits = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    facets = [t for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    return Mesh(center + (bits - 0.5) * size, facets, material)


def cylinder(radius, height, *, sides=64, axis="z", material=SURFACE):
    """A prism of `sides` sides with the volume of a circular cylinder, along a body axis.

    Its cross-section has the area of the circle, pi radius^2, so volume and mass are those of the
    cylinder; the lateral area differs by 0.04% at 64 sides, falling with their square.
    """
    radius = validation.positive(radius, "radius", unit="m")
    height = validation.positive(height, "height", unit="m")
    axis = _AXES[validation.one_of(axis, "axis", tuple(_AXES))]
    if not (isinstance(sides, (int, np.integer)) and 3 <= sides <= 100_000):
        raise AttitudeError(f"sides is {sides!r}; give a whole number from 3 to 100000.")
    turn = 2.0 * np.pi / sides
    rim = radius * np.sqrt(turn / np.sin(turn))
    k = np.arange(sides)
    circle = np.stack([rim * np.cos(k * turn), rim * np.sin(k * turn)], axis=1)
    flat = np.concatenate([circle, circle, np.zeros((2, 2))])
    level = np.repeat([-0.5, 0.5, -0.5, 0.5], [sides, sides, 1, 1]) * height
    # Cyclic order of the axes keeps the hand, so that normals stay outward.
    vertices = np.roll(np.column_stack([flat, level]), axis - 2, axis=1)
    after, top = (k + 1) % sides, k + sides
    bottom, lid = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    facets = np.concatenate(
        [
            np.stack([k, after, top], axis=1),
            np.stack([after, after + sides, top], axis=1),
            np.stack([bottom, after, k], axis=1),
            np.stack([lid, top, after + sides], axis=1),
        ]
    )
    return Mesh(vertices, facets, material)


def box_wing(
    body,
    wing,
    *,
    gap=0.0,
    thickness=0.02,
    wing_axis="y",
    wing_angle=0.0,
    wings=2,
    materials=("body", "panel front", "panel back", "panel edge"),
):
    """A box with one or two solar wings: the satellite of radiation-pressure models.

    Parameters
    ----------
    body : (3,) array_like
        Edges of the box along x, y, z: m.
    wing : (2,) array_like
        Length of a wing along the wing axis and its width across: m.
    gap : float
        Between box and wing: m.
    thickness : float
        Of a wing: m.
    wing_axis : "x", "y" or "z"
        The axis along which the wings stand off the box, symmetric about its centre.
    wing_angle : float or Quantity
        Radians: turn of the wings about that axis.  At zero the fronts face the next axis in the
        order x, y, z, x (z for wings along y).
    wings : 1 or 2
        One stands on the positive side.
    materials : four str
        Names for box, wing front, wing back and wing edges.

    Returns
    -------
    Mesh
        12 facets for the box and 12 for each wing; parts do not overlap.
    """
    body = validation.real(body, "body", shape=(3,), unit="m")
    length, width = validation.real(wing, "wing", shape=(2,), unit="m")
    gap = validation.number(gap, "gap", unit="m")
    thickness = validation.positive(thickness, "thickness", unit="m")
    angle = validation.number(wing_angle, "wing_angle", unit="rad")
    along = _AXES[validation.one_of(wing_axis, "wing_axis", tuple(_AXES))]
    validation.one_of(wings, "wings", (1, 2))
    if gap < 0.0:
        raise AttitudeError(f"gap is {gap!r} m; it must not be negative, or parts would overlap.")
    names = tuple(materials)
    if len(names) != 4:
        raise AttitudeError(f"materials has {len(names)} names; give four: {_FOUR}.")
    front, across = (along + 1) % 3, (along + 2) % 3
    size = np.empty(3)
    size[along], size[front], size[across] = length, thickness, width
    turn = np.eye(3)
    c, s = np.cos(angle), np.sin(angle)
    turn[front, front], turn[front, across] = c, -s
    turn[across, front], turn[across, across] = s, c
    mesh = box(body, material=names[0])
    for side in (1.0, -1.0)[:wings]:
        center = np.zeros(3)
        center[along] = side * (body[along] / 2.0 + gap + length / 2.0)
        labels = [names[3]] * 12
        labels[4 * front + 2 : 4 * front + 4] = [names[1]] * 2
        labels[4 * front : 4 * front + 2] = [names[2]] * 2
        mesh = mesh.joined(box(size, material=labels, center=center).turned(turn))
    return mesh


_FOUR = "of the box, the wing's front, its back and its edges"
