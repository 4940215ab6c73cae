"""Facets in clusters of like normals, so that those turned away are passed over together.

A branch for each facet costs three times what it saves: it breaks the vector instructions.  One
bit for eight facets does not.  Which clusters a direction can light is looked up in a table of
small cells around the sphere; the clusters of the Sun and those of the observer are words of bits,
and what both share is summed.  With directions at random that is 35% of 1000 facets, where a
quarter of the facets are both lit and seen.

The facets of a cluster all rise along one axis: x, y, z or one of their opposites.  So a normal is
kept as the two slopes that are left when it is divided by its component along that axis, and the
cosine of an angle, over that component, is two products instead of three.
"""

import weakref
from dataclasses import dataclass

import numpy as np

# Facets in a cluster: one vector instruction (`compilation.simd`).  More would leave more of them.
SIZE = 8
# Numbers kept of a facet, each in rows of SIZE: two slopes, height along the axis, area.
ROWS = 4
# Clusters in a word of the table.
WORD = 64
# Cells along an edge of the cube from -1 to 1 in which directions are looked up, and what the
# table may take; coarser cells keep more clusters that turn out dark.
_CELLS = 32
_LARGEST = 1 << 26
# So that a component of 1, and a little more, still falls in the last cell.
_INSET = 1.0 - 1e-5
# The least component along the axis of a cluster; a single facet has at least 0.57.
_LEAST_HEIGHT = 0.25
# What directions may miss the unit sphere by, and single precision a cosine.
_SLACK = 1e-5

_made = weakref.WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Clusters:
    """A mesh laid out for the kernels.

    blocks : (C * ROWS * SIZE,), cluster by cluster: the slopes of normals along the two axes that
    follow that of the cluster, their heights along it, and areas in units of the whole area; in
    empty places the area is 0.
    axes : (C, 2) uint64: where, in (x, y, z, x, y, -x, -y, -z) of a direction, the first of its
    two components along the following axes stands, and that along the cluster's own.
    sky : (cells^3, C / WORD) uint64, a bit for each cluster that has a facet turned to some
    direction of the cell; cells away from the unit sphere are empty.
    cells : along an edge.
    order : (C * SIZE,), the facet in each place, -1 in empty ones.
    area : the whole area, m2.
    """

    blocks: np.ndarray
    axes: np.ndarray
    sky: np.ndarray
    cells: int
    order: np.ndarray
    area: float

    def __post_init__(self):
        for array in (self.blocks, self.axes, self.sky, self.order):
            array.flags.writeable = False

    def __reduce__(self):
        return Clusters, (self.blocks, self.axes, self.sky, self.cells, self.order, self.area)

    @property
    def count(self):
        """How many clusters; words of `sky` have room for more."""
        return len(self.axes)

    def rows(self):
        """A copy of `blocks` as (C, ROWS, SIZE), to be weighted and given to `aligned`."""
        return self.blocks.reshape(-1, ROWS, SIZE).copy()


def clusters_of(mesh):
    """The facets of a mesh as the kernels want them; made once, and kept as long as the mesh."""
    if mesh not in _made:
        _made[mesh] = clustered(mesh.normals, mesh.areas)
    return _made[mesh]


def clustered(normals, areas):
    """`Clusters` of (F, 3) unit normals and (F,) areas."""
    groups = _halved(normals, np.arange(len(normals)))
    total = float(np.sum(areas))
    blocks = np.zeros((len(groups), ROWS, SIZE))
    axes = np.empty((len(groups), 2), dtype=np.uint64)
    order = np.full((len(groups), SIZE), -1)
    for k, group in enumerate(groups):
        axis, opposite, _ = _common_axis(normals[group])
        axes[k] = axis + 1, axis + 5 * opposite
        own = np.roll(normals[group], -1 - axis, axis=1)
        height = np.abs(own[:, 2])
        here = blocks[k, :, : len(group)]
        here[0], here[1] = own[:, 0] / height, own[:, 1] / height
        here[2], here[3] = height, areas[group] / total
        order[k, : len(group)] = group
    cells, sky = _sky(normals, order)
    return Clusters(aligned(blocks), axes, sky, cells, order.reshape(-1), total)


def aligned(blocks):
    """A flat read-only copy that begins at a multiple of 64 bytes: whole vectors, 5% faster."""
    room = np.empty(blocks.size + 8)
    skip = -room.ctypes.data // 8 % 8
    copy = room[skip : skip + blocks.size]
    copy[:] = blocks.reshape(-1)
    copy.flags.writeable = False
    return copy


def cell_scale(cells):
    """A component times this, plus cells/2, is its place along an edge: see `sums`."""
    return 0.5 * cells * _INSET


def _common_axis(normals):
    """The axis along which the lowest rises most, whether it is the opposite one, and how much."""
    rise = np.concatenate([np.min(normals, axis=0), np.min(-normals, axis=0)])
    best = int(np.argmax(rise))
    return best % 3, best // 3, rise[best]


def _halved(normals, members):
    """Groups of at most SIZE with an axis in common: split at the median along the widest axis.

    Full groups first.
    """
    few = len(members) <= SIZE
    if few and _common_axis(normals[members])[2] >= _LEAST_HEIGHT:
        return [members]
    axis = np.argmax(np.ptp(normals[members], axis=0))
    members = members[np.argsort(normals[members, axis], kind="stable")]
    half = len(members) // 2 if few else -(-len(members) // SIZE) // 2 * SIZE
    return _halved(normals, members[:half]) + _halved(normals, members[half:])


def _sky(normals, order):
    words = -(-len(order) // WORD)
    cells = _CELLS
    while cells > 8 and cells**3 * words * 8 > _LARGEST:
        cells //= 2
    half = 0.5 / cell_scale(cells)
    middle = (2.0 * np.arange(cells) + 1.0 - cells) * half
    centers = np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1).reshape(-1, 3)
    nearest = np.linalg.norm(np.maximum(np.abs(centers) - half, 0.0), axis=1)
    farthest = np.linalg.norm(np.abs(centers) + half, axis=1)
    near = np.flatnonzero((nearest <= 1.0 + _SLACK) & (farthest >= 1.0 - _SLACK))
    looking = centers[near].astype(np.float32)
    # How much higher than in the middle a normal stands in the best corner of a cell.
    spare = (half * np.sum(np.abs(normals), axis=1) + _SLACK).astype(np.float32)
    sky = np.zeros((cells**3, words), dtype=np.uint64)
    for word in range(words):
        part = order[word * WORD : (word + 1) * WORD]
        height = looking @ normals[part.reshape(-1)].T.astype(np.float32)
        height += spare[part.reshape(-1)]
        height[:, part.reshape(-1) < 0] = -9.0
        shown = np.max(height.reshape(len(near), len(part), SIZE), axis=2) > 0.0
        weights = np.uint64(1) << np.arange(len(part), dtype=np.uint64)
        sky[near, word] = np.sum(np.where(shown, weights, np.uint64(0)), axis=1, dtype=np.uint64)
    return cells, sky
