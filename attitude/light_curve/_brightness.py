"""Brightness of a shape under a law: checks of directions, the choice of the loop, blocks."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING

import numpy as np

from attitude._support.arrays import frozen, read_only
from attitude._support.blocks import ProgressBar, in_blocks
from attitude._support.validation import output, shown
from attitude.errors import AttitudeError
from attitude.light_curve import _sums
from attitude.light_curve._sums import (
    SIZE,
    WORD,
    aligned,
    arranged,
    clusters_of,
    packs_of,
    summed_few_facets,
)
from attitude.light_curve._visibility import POINTS, Visibility
from attitude.scattering._law import law as known_law
from attitude.scattering._law import laws
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from typing import Any

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import FloatArray, IntArray
    from attitude.scattering._law import Law


# ---- Directions of Sun and observer, checked, as one array per component for the compiled loops

# Tolerance of the squared length of a unit vector.
_UNIT = 1e-6


def paired(
    sun: ArrayLike, observer: ArrayLike
) -> tuple[NDArray[Any], NDArray[Any], tuple[int, ...]]:
    """Both directions as arrays (N, 3), if possible without a copy, and the shape of the result."""
    arrays = []
    for value, name in ((sun, "sun"), (observer, "observer")):
        try:
            array = np.asarray(value)
        except ValueError as err:
            raise AttitudeError(f"{name} is ragged; give unit vectors (..., 3).") from err
        if array.ndim < 1 or array.shape[-1] != 3 or array.dtype.kind not in "fiu":
            raise AttitudeError(
                f"{name} has shape {array.shape} of {array.dtype}; give unit vectors (..., 3)."
            )
        arrays.append(array)
    try:
        shape = np.broadcast_shapes(arrays[0].shape, arrays[1].shape)
    except ValueError as err:
        raise AttitudeError(
            f"sun has shape {arrays[0].shape} and observer {arrays[1].shape}; they must broadcast."
        ) from err
    # A reshape would copy a broadcast direction: skip it for arrays of two axes.
    flat = [
        np.broadcast_to(a, shape) if len(shape) == 2 else np.broadcast_to(a, shape).reshape(-1, 3)
        for a in arrays
    ]
    return flat[0], flat[1], shape[:-1]


def components(sun: NDArray[Any], observer: NDArray[Any], begin: int, end: int) -> list[FloatArray]:
    """Six contiguous float64 arrays of a block: x, y, z of the Sun, then of the observer."""
    parts = []
    for array, name in ((sun, "sun"), (observer, "observer")):
        # read-only everywhere: one compiled version
        parts_of = [
            read_only(np.ascontiguousarray(array[begin:end, k], dtype=np.float64)) for k in range(3)
        ]
        # The sum of (|v|^2 - 1)^2 exceeds the bound if any single vector does; NaN stays NaN.
        if not _sums.stray(*parts_of) <= _UNIT**2:
            _refuse_the_first(parts_of, name, begin)
        parts.extend(parts_of)
    return parts


def _refuse_the_first(xyz: list[FloatArray], name: str, begin: int) -> None:
    """Raise for the first vector beyond the bound, if any: the sum of many may exceed it too."""
    excess = xyz[0] ** 2 + xyz[1] ** 2 + xyz[2] ** 2 - 1.0
    wrong = np.flatnonzero(~(np.abs(excess) <= _UNIT))
    if len(wrong):
        bad = int(wrong[0])
        raise AttitudeError(
            f"{name} at epoch {begin + bad} is {[float(v[bad]) for v in xyz]}; give finite "
            "vectors of length 1."
        )


# Epochs in a block: some 0.5 MB of temporary arrays, and a few milliseconds of work; more of an
# ellipsoid, since threads wait for each other between blocks.
BLOCK = 8192
_BLOCK_OF_ELLIPSOIDS = 32768

# Facets that are gathered at a time, 0.4 MB of temporary arrays.
_GATHERED = 16384

# Tables of shadows; each lives as long as its mesh.
_visibility: weakref.WeakKeyDictionary[Mesh, Visibility] = weakref.WeakKeyDictionary()


def brightness(
    shape: Ellipsoid | Mesh,
    law: str | Law,
    sun: ArrayLike,
    observer: ArrayLike,
    *,
    shadows: bool | Visibility = True,
    threads: int = 1,
    out: FloatArray | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> FloatArray:
    """Intensity that a body sends to the observer, over the Sun's irradiance on it.

    Parameters
    ----------
    shape : Ellipsoid or Mesh
        An ellipsoid needs a law with a closed form (Lommel-Seeliger); for other laws give its
        facets, `Ellipsoid.facets`.
    law : str or Law
        A law of `attitude.scattering`, or its name.
    sun, observer : (..., 3) array_like
        Unit vectors from the body to Sun and observer in body axes.  Arrays (N, 3) of float64 in
        component-major memory are read in place; others are copied block by block.
    shadows : bool or Visibility
        Whether facets of a mesh that is not convex shade and hide each other.  True makes a table
        at the first use of a mesh (0.5 s for 2000 facets, 4 s for 20,000), shows a bar meanwhile,
        and keeps the table as long as the mesh, and on disk; `Visibility.of` makes one beforehand.
        Convex meshes need none.
    threads : int
        Number of threads; it does not change the bits of the result.
    out : (...) float64 array, optional
        Output array in C order.
    progress : callable, optional
        Called with (number of epochs done, number of epochs) after each block; by default a bar on
        a terminal.

    Returns
    -------
    (...) array
        m2/sr, 0 where no facet is both lit and seen; for magnitudes see
        `attitude.light_curve.reduced_magnitude`.

    Raises
    ------
    AttitudeError
        For vectors that are not unit to 1e-6 or not finite, arrays that do not broadcast,
        inside-out meshes, facets whose material the law lacks, and ellipsoids under a law without
        a closed form.

    Notes
    -----
    Memory beyond the arguments and the result: 2 MB, and the table of shadows (by default at most
    256 MiB).  Speed and accuracy are measured by benchmarks/light_curve.py.

    Examples
    --------
    A white sphere of radius 1 m under Lambert's law at full phase returns 2/3 m2/sr.

    >>> from attitude.shape import Ellipsoid
    >>> sphere = Ellipsoid((1, 1, 1)).facets(5000)
    >>> print(brightness(sphere, "lambert", [0, 0, 1], [0, 0, 1]).round(3))
    0.667
    """
    law = known_law(law)
    suns, observers, shape_out = paired(sun, observer)
    kernel = kernel_of(shape, law, shadows, threads)
    out = output(out, shape_out)
    flat, work = out.reshape(-1), with_phase(kernel, law)

    def fill(begin: int, end: int) -> None:
        work(components(suns, observers, begin, end), flat[begin:end])

    bar = ProgressBar("light curve") if progress is None else progress
    block = _BLOCK_OF_ELLIPSOIDS if isinstance(shape, Ellipsoid) else BLOCK
    in_blocks(fill, flat.size, block, threads, bar)
    return out if out.ndim else out[()]


def with_phase(
    kernel: Callable[..., object], law: Law
) -> Callable[[Sequence[FloatArray], FloatArray], None]:
    """The function of `components` and an output array: a `kernel_of` the law, and its phase."""
    has_phase = law.has_phase
    if has_phase:
        from attitude._solver.vectors import separation

    def work(parts: Sequence[FloatArray], out: FloatArray) -> None:
        kernel(*parts, out)
        if has_phase:
            out *= law.phase(separation(*parts))

    return work


def stream(
    shape: Ellipsoid | Mesh,
    law: str | Law,
    blocks: Iterable[tuple[ArrayLike, ArrayLike]],
    *,
    shadows: bool | Visibility = True,
    threads: int = 1,
    progress: Callable[[int], object] | None = None,
) -> Iterator[FloatArray]:
    """Yield the brightness (m2/sr) of each pair of direction arrays, for curves longer than memory.

    Parameters
    ----------
    shape, law, shadows, threads : as in `brightness`
    blocks : iterable of pairs (sun, observer)
        Arrays (..., 3) as in `brightness`.  Only one block is in memory at a time if the iterable
        is lazy.
    progress : callable, optional
        Called with the number of epochs done after each block.
    """
    done = 0
    for directions in blocks:
        try:
            sun, observer = directions
        except (TypeError, ValueError) as err:
            raise AttitudeError(
                f"blocks holds {shown(directions)}; give pairs of arrays: (sun, observer)."
            ) from err
        block = brightness(shape, law, sun, observer, shadows=shadows, threads=threads)
        done += np.size(block)
        if progress is not None:
            progress(done)
        yield block


def kernel_of(
    shape: object, law: Law, shadows: bool | Visibility, threads: int
) -> Callable[..., object]:
    """The function of six components and an output for a block, without the phase function."""
    if isinstance(shape, Ellipsoid):
        return _ellipsoid_kernel(shape, law)
    if not isinstance(shape, Mesh):
        raise AttitudeError(f"shape is {shape!r}; give an attitude.shape Ellipsoid or Mesh.")
    if len(shape.inward_facets):
        shape.require_closed()
    table = _table(shape, shadows, threads)
    summed = (_facet_kernel if law.weights is None else _fused_kernel)(shape, law, table)
    area = clusters_of(shape).area

    def kernel(*arrays: FloatArray) -> None:
        # sums over areas in units of the whole one: totals below a fixed bound count as 0
        summed(*arrays)
        arrays[-1][:] *= area

    return kernel


def _ellipsoid_kernel(shape, law):
    require_ellipsoid_form(law)
    axes, factor = tuple(float(axis) for axis in shape.semi_axes), law.weights[0]
    return lambda *arrays: _sums.ellipsoid(*axes, factor, *arrays)


def require_ellipsoid_form(law: Law) -> None:
    """AttitudeError for a law without a closed form of an ellipsoid."""
    if not law.has_ellipsoid_form:
        names = " or ".join(
            repr(name) for name, entry in laws().items() if entry.has_ellipsoid_form
        )
        raise AttitudeError(
            f"law is {law!r}, but an ellipsoid has a closed form under the law {names} only; give "
            "its facets, Ellipsoid.facets(count), or that law."
        )


def _table(mesh: Mesh, shadows: bool | Visibility, threads: int) -> Visibility | None:
    """The table of shadows of a mesh; None if nothing casts a shadow or shadows are off."""
    if isinstance(shadows, Visibility):
        if not shadows.is_of(mesh):
            raise AttitudeError(
                "shadows is the Visibility of another mesh; give Visibility.of(mesh)."
            )
        return shadows
    if shadows is not True and shadows is not False:
        raise AttitudeError(f"shadows is {shadows!r}; give True, False or a Visibility.")
    if not shadows or mesh.is_convex:
        return None
    if mesh not in _visibility:
        _visibility[mesh] = Visibility.of(mesh, threads=threads)
    return _visibility[mesh]


def _fused_kernel(mesh, law, table):
    """The sum for laws with weights: the weights are part of the rows of each facet."""
    clusters = clusters_of(mesh)
    blocks = clusters.rows()
    height, area = blocks[:, 2], blocks[:, 3] / (1 if table is None else POINTS)
    seeliger, lambert = law.weights
    blocks[:, 2], blocks[:, 3] = seeliger * area * height, lambert * area * height**2
    tables = aligned(blocks), clusters.axes, clusters.sky, clusters.cells
    if table is None:
        return lambda *arrays: _sums.fused(*tables, None, None, None, *arrays)
    masks = table.masks.view(np.uint64)

    def kernel(*arrays):
        _sums.fused(*tables, masks, *_cells(table.resolution, arrays), *arrays)

    return kernel


def _cells(resolution, arrays):
    """The cells (N,) of the Sun's directions and of the observer's, the first six arrays."""
    return [cells_of_directions(resolution, arrays[k : k + 3]) for k in (0, 3)]


def _halves(directions):
    """Cosines and sines (2, N) of half the phase angles, of directions by component."""
    half = np.empty((2, directions[0].size))
    _sums.halves(*directions, *half)
    return half


def cells_of_directions(resolution: int, directions: Sequence[FloatArray]) -> FloatArray:
    """The indices (N,) of the cells of directions by component (N,), as `_sums` takes them."""
    if resolution == 0:
        return np.zeros(directions[0].size)
    missing = -directions[0].size % SIZE
    if missing:
        # read-only as `components` gives them: one compiled version
        directions = [frozen(np.append(one, np.ones(missing))) for one in directions]
    cells = np.empty(directions[0].size)
    _sums.cells_of(*directions, float(resolution), cells)
    return cells


def _facet_kernel(mesh, law, table):
    """The sum for laws that are evaluated facet by facet, over facets that `gather` finds."""
    clusters = clusters_of(mesh)
    rows, number = law.rows(mesh.materials)
    # Names of the same material are one row: fewer facets are filled up.
    rows, same = np.unique(rows, axis=0, return_inverse=True)
    number = same.reshape(-1)[number]
    packs = packs_of(mesh, number, len(rows), clusters.order)
    if packs is not None and law.elements is not None:
        return _few_kernel(law, rows, packs, table)
    which = np.where(clusters.order < 0, -1, number[clusters.order])
    masks, resolution = frozen(np.zeros((1, clusters.count), dtype=np.uint64)), 0
    if table is not None:
        masks, resolution = table.masks.view(np.uint64), table.resolution
    records = (
        clusters.blocks,
        clusters.axes,
        clusters.sky,
        clusters.cells,
        _segments(which, len(rows)),
        which.astype(float),
        masks,
    )
    element = law.element if law.elements is None else law.elements
    summed = _sums.over_facets(law.of_phase, element, law.elements is not None)
    size = max(_GATHERED, SIZE * (clusters.count + 2 * len(rows)))

    def kernel(*arrays):
        *directions, out = arrays
        ends = np.empty((min(out.size, size // SIZE), len(rows)), dtype=np.int64)
        cells = _cells(resolution, directions)
        arguments = *records, *cells, *directions, *np.empty((3, size)), ends
        summed(rows, arguments, *_halves(directions), out)

    return kernel


def _few_kernel(law, rows, packs, table):
    """The sum over a mesh of few facets, all of which are evaluated."""
    masks, resolution = arranged(np.zeros((1, 0), dtype=np.uint8), packs), 0
    if table is not None:
        masks, resolution = table.arranged(packs), table.resolution
    summed = summed_few_facets(law.of_phase, law.elements)

    def kernel(*arrays):
        *directions, out = arrays
        cells, half = _cells(resolution, directions), _halves(directions)
        summed(rows, packs.first, packs.facets, masks, *cells, *directions, *half, out)

    return kernel


def _segments(which: IntArray, rows: int) -> NDArray[np.uint64]:
    """The `segments` of `_sums.gather`, for the row (places,) of each place, -1 if it is empty."""
    segments = []
    of_clusters = which.reshape(-1, SIZE)
    for row in range(rows):
        holds = np.any(of_clusters == row, axis=1)
        padded = np.zeros(-(-len(holds) // WORD) * WORD, dtype=np.uint8)
        padded[: len(holds)] = holds
        words = np.packbits(padded, bitorder="little").view("<u8")
        # each row has a segment, be it empty
        used = np.flatnonzero(words) if np.any(words) else [0]
        segments += [(word, int(words[word]), row) for word in used]
    return np.array(segments, dtype=np.uint64)
