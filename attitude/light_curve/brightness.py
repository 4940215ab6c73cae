"""Brightness of a shape under a law, for many directions: the door to the kernels."""

import weakref

import numpy as np

from attitude.errors import AttitudeError
from attitude.light_curve.blocks import in_blocks
from attitude.light_curve.clusters import aligned, clusters_of
from attitude.light_curve.directions import components, paired
from attitude.light_curve.visibility import POINTS, Visibility
from attitude.scattering import law as known_law
from attitude.scattering import laws
from attitude.shape import Ellipsoid, Mesh

# Epochs in a block: some 0.5 MB of temporaries, and a few milliseconds of work.
BLOCK = 8192

# A table that was made for a mesh lives as long as the mesh.
_visibility = weakref.WeakKeyDictionary()


def brightness(shape, law, sun, observer, *, shadows=True, threads=1, out=None, progress=None):
    """What a body sends to the observer for each pair of directions.

    Parameters
    ----------
    shape : Ellipsoid or Mesh
        An ellipsoid takes the Lommel-Seeliger law, in closed form; for any other law ask it for
        its facets.
    law : str or Law
        See `attitude.scattering`.
    sun, observer : (..., 3) array_like
        Unit vectors from the body to Sun and observer in body axes.  Views (N, 3) of
        component-major memory are read in place; others are copied block by block.
    shadows : bool or Visibility
        Whether facets of a mesh that is not convex shade and hide each other.  True makes a table
        at the first use of a mesh (seconds for 2000 facets) and keeps it as long as the mesh;
        `Visibility.of` makes one beforehand.  Convex meshes need none.
    threads : int
        Results are the same bits for any number.
    out : (...) float64 array, optional
        To be filled and returned.
    progress : callable, optional
        Called with (epochs done, epochs in all) after each block.

    Returns
    -------
    (...) array
        m2/sr; see `attitude.light_curve.reduced_magnitude`.  0 where nothing is both lit and seen.

    Raises
    ------
    AttitudeError
        For vectors that are not unit to 1e-6 or not finite, shapes that do not fit, inside-out
        meshes, materials without a law, and laws that a shape cannot take.

    Notes
    -----
    Memory beyond the arguments and the result: 2 MB, and the table of shadows (at most 256 MiB
    unless asked).  Measured speed and accuracy: benchmarks/light_curve.py.

    Examples
    --------
    A white sphere of radius 1 m under Lambert's law at full phase returns 2/3 m2/sr.

    >>> from attitude.shape import Ellipsoid
    >>> sphere = Ellipsoid((1, 1, 1)).facets(5000)
    >>> brightness(sphere, "lambert", [0, 0, 1], [0, 0, 1]).round(3)
    np.float64(0.667)
    """
    law = known_law(law)
    sun, observer, shape_out = paired(sun, observer)
    kernel = _kernel(shape, law, shadows, threads)
    if out is None:
        out = np.empty(shape_out)
    elif not (
        isinstance(out, np.ndarray)
        and out.shape == shape_out
        and out.dtype == np.float64
        and out.flags.c_contiguous
        and out.flags.writeable
    ):
        raise AttitudeError(
            f"out must be a writable float64 array of shape {shape_out} in C order."
        )
    flat = out.reshape(-1)
    if law.has_phase:
        from attitude.solution.vectors import separation

    def work(begin, end):
        parts = components(sun, observer, begin, end)
        kernel(*parts, flat[begin:end])
        if law.has_phase:
            flat[begin:end] *= law.phase(separation(*parts))

    in_blocks(work, flat.size, BLOCK, threads, progress)
    return out if out.ndim else out[()]


def stream(shape, law, blocks, *, shadows=True, threads=1, progress=None):
    """Yield the brightness of each (sun, observer) pair of arrays as it comes.

    For curves that are longer than memory: attitudes, directions and brightness of one block are
    all that exists at a time.  ``progress(epochs done)`` is called after each block.
    """
    done = 0
    for sun, observer in blocks:
        part = brightness(shape, law, sun, observer, shadows=shadows, threads=threads)
        done += np.size(part)
        if progress is not None:
            progress(done)
        yield part


def _kernel(shape, law, shadows, threads):
    """A function of six components and an output, for one block."""
    if isinstance(shape, Ellipsoid):
        return _ellipsoid_kernel(shape, law)
    if not isinstance(shape, Mesh):
        raise AttitudeError(f"shape is {shape!r}; give an attitude.shape Ellipsoid or Mesh.")
    if len(shape.inward_facets):
        shape.require_closed()
    table = _table(shape, shadows, threads)
    if law.weights is None:
        return _facet_kernel(shape, law, table)
    return _fused_kernel(shape, law, table)


def _ellipsoid_kernel(shape, law):
    if not law.has_ellipsoid_form:
        names = " or ".join(repr(name) for name, each in laws().items() if each.has_ellipsoid_form)
        raise AttitudeError(
            f"an ellipsoid has a closed form under the law {names} only, not under {law!r}: give "
            "its facets, Ellipsoid.facets(count), or that law."
        )
    from attitude.light_curve.closed_form import ellipsoid

    axes = tuple(float(axis) for axis in shape.semi_axes)
    return lambda *arrays: ellipsoid(*axes, law.weights[0], *arrays)


def _table(mesh, shadows, threads):
    if isinstance(shadows, Visibility):
        if not shadows.is_of(mesh):
            raise AttitudeError(
                "shadows is the Visibility of another mesh; make one with Visibility.of(mesh)."
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
    from attitude.light_curve import sums

    clusters = clusters_of(mesh)
    blocks = clusters.rows()
    height, area = blocks[:, 2], blocks[:, 3] / (1 if table is None else POINTS)
    seeliger, lambert = law.weights
    blocks[:, 2], blocks[:, 3] = seeliger * area * height, lambert * area * height**2
    rest = aligned(blocks), *_looked_up(clusters, table)
    return _times(clusters.area, lambda *arrays: sums.fused(*rest, *arrays))


def _facet_kernel(mesh, law, table):
    from attitude.light_curve import sums

    clusters = clusters_of(mesh)
    rows, number = law.rows(mesh.materials)
    which = np.where(clusters.order < 0, 0, number[clusters.order])
    rest = clusters.blocks, *_looked_up(clusters, table), rows, which
    summed = sums.by_facet(law.of_phase, law.element)
    return _times(clusters.area, lambda *arrays: summed(*rest, *arrays))


def _times(area, summed):
    """The kernel of a sum over areas that are parts of the whole.

    What counts as nothing in a sum is then the same for a pebble and for a planet.
    """

    def kernel(*arrays):
        summed(*arrays)
        arrays[-1][:] *= area

    return kernel


def _looked_up(clusters, table):
    """What a kernel asks for each direction: which clusters show, and which points are free."""
    free = (None, 0) if table is None else (table.masks.view(np.uint64), table.resolution)
    return clusters.axes, clusters.sky, clusters.cells, *free
