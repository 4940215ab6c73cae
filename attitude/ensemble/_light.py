"""Brightness of the members of an ensemble, from their states, block by block."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.decorators import entry_point, force_inlined, reduction_inlined
from attitude._solver import states
from attitude._solver.chains import evaluate_part
from attitude._solver.states import Results
from attitude._support import validation
from attitude._support.arrays import read_only
from attitude._support.blocks import ProgressBar, in_blocks
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.errors import AttitudeError
from attitude.light_curve._brightness import kernel_of, require_ellipsoid_form
from attitude.light_curve._magnitudes import of_brightness
from attitude.light_curve._sums import intensity
from attitude.scattering._law import law as known_law
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._solver.states import Evaluation
    from attitude._support.annotations import FloatArray, IntArray
    from attitude.ensemble._evaluation import MemberGrid, MemberRows, Piece
    from attitude.light_curve._visibility import Visibility
    from attitude.scattering._law import Law


# ---- The compiled loop from states to the brightness of ellipsoids, without an array of attitudes

# Rows that are evaluated at a time: their attitudes and directions stay in the first-level cache.
PIECE = 248


@entry_point
def ellipsoid_runs(
    constants, starts, t, t_low, sun, sun_steps, observer, observer_steps, axes, factor, work, out
):
    """Brightness, over the solar irradiance, of B runs of rows of ellipsoids.

    Given
        constants  (B,) records (attitude._solver.records.CONSTANTS), one of each run
        starts     (B + 1,) the rows of run b are starts[b] to starts[b + 1]
        t, t_low   (1, R) seconds since the epoch of the state; t_low may be None
        sun, observer  flat memory of vectors from the body, ICRF, of any length above zero:
                   component k of row r is at r times the first step and k times the second
        axes       (1 or B, 3) semi-axes, m
        factor     weight of the law of Lommel and Seeliger, 1/sr
        work       (1, 10, PIECE) memory
    Filled
        out        (R,) m2/sr
    Returned
        -1, or the first run with an epoch beyond its reach; it and those after it are not filled
    """
    for b in range(len(constants)):
        k = b if len(axes) > 1 else 0
        a, c, d = axes[k, 0], axes[k, 1], axes[k, 2]
        scale = 0.25 * math.pi * a * c * d * factor
        first, end = starts[b], starts[b + 1]
        while first < end:
            stop = min(first + PIECE, end)
            if evaluate_part(constants[b : b + 1], t, t_low, work, None, first, stop, 0):
                return b
            _take(sun, sun_steps, first, stop, 4, work[0])
            _take(observer, observer_steps, first, stop, 7, work[0])
            _shine(work[0], 1.0 / a, 1.0 / c, 1.0 / d, scale, stop - first)
            for k in range(stop - first):
                out[first + k] = work[0, 0, k]
            first = stop
    return -1


@force_inlined
def _take(memory, steps, first, end, to, work):
    """Vectors of the rows from `first` to `end`, as unit vectors, into three rows of `work`."""
    row, component = steps
    if row == 3 and component == 1:
        # LLVM vectorises a loop only with steps that are constant.
        directions = memory[3 * first : 3 * end]
        for k in range(end - first):
            _put(directions[3 * k], directions[3 * k + 1], directions[3 * k + 2], to, k, work)
    elif row == 1:
        one = memory[first:end]
        two = memory[component + first : component + end]
        three = memory[2 * component + first : 2 * component + end]
        for k in range(end - first):
            _put(one[k], two[k], three[k], to, k, work)
    else:
        for k in range(end - first):
            i = (first + k) * row
            _put(memory[i], memory[i + component], memory[i + 2 * component], to, k, work)


@reduction_inlined
def _put(x, y, z, to, k, work):
    """A vector as a unit vector in place k of three rows of `work`."""
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    work[to, k], work[to + 1, k], work[to + 2, k] = x * inverse, y * inverse, z * inverse


@force_inlined
def _shine(work, ia, ib, ic, scale, count):
    """The brightness in place of the first component of each attitude.

    Attitudes and the unit vectors of Sun and observer, over inertial axes, are the rows of one
    array: with several arrays LLVM does not vectorise the loop.
    """
    for k in range(count):
        w, x, y, z = work[0, k], work[1, k], work[2, k], work[3, k]
        a, b, c = _in_body(w, x, y, z, work[4, k], work[5, k], work[6, k])
        d, e, f = _in_body(w, x, y, z, work[7, k], work[8, k], work[9, k])
        work[0, k] = intensity(ia, ib, ic, scale, a, b, c, d, e, f)


@reduction_inlined
def _in_body(w, x, y, z, a, b, c):
    """The vector q* v q, as `attitude._solver.vectors.to_body` has it."""
    d = 2.0 * (y * c - z * b)
    e = 2.0 * (z * a - x * c)
    f = 2.0 * (x * b - y * a)
    return a - w * d + (y * f - z * e), b - w * e + (z * d - x * f), c - w * f + (x * e - y * d)


# Rows in a piece of work: 2 ms with ellipsoids, and 0.1 s if each is of another member.  Threads
# wait for the interpreter lock at each call of compiled code: the more of them, the longer.
_ROWS = 1 << 16
# Rows of meshes in a piece: a facet costs a nanosecond.
_ROWS_OF_MESHES = 1 << 12


class Light:
    """The brightness of members with `known_shapes`; shadows as in `light_curve.brightness`."""

    def __init__(
        self,
        evaluation: Evaluation,
        shapes: FloatArray | list[Ellipsoid | Mesh],
        law: str | Law,
        shadows: bool | Visibility,
    ) -> None:
        self._evaluation = evaluation
        self._law, self._shadows, self._shapes = known_law(law), shadows, shapes
        self._has_axes = isinstance(shapes, np.ndarray)
        if self._has_axes:
            require_ellipsoid_form(self._law)
        self._kernels: dict[int, Callable[..., object]] = {}

    def fill(
        self,
        rows: MemberGrid | MemberRows,
        sun: FloatArray,
        observer: FloatArray,
        out: FloatArray,
        threads: int,
        band: float | None = None,
        apparent: bool = False,
    ) -> None:
        """Fill brightness (R,), m2/sr, of rows, for vectors of shape (S, 3) in ICRF.

        With `band`, the magnitude of the Sun at 1 au, reduced magnitudes; and with `apparent` those
        at the lengths of the vectors in m.
        """
        parts: Sequence[Any] = rows.pieces(_ROWS if self._has_axes else _ROWS_OF_MESHES)
        if not self._has_axes:
            self._make_kernels(rows.member, threads)

        def work(begin: int, end: int) -> None:
            for block in parts[begin:end]:
                piece = rows.piece(block)
                both = rows.vectors(sun, block), rows.vectors(observer, block)
                in_place = isinstance(piece.place, slice)
                values = out[piece.place] if in_place else np.empty(len(piece.member))
                self._fill(piece, *both, values)
                if band is not None:
                    values[:] = of_brightness(values, band)
                if apparent:
                    values += _modulus(*both)
                if not in_place:
                    out[piece.place] = values

        in_blocks(work, len(parts), 1, threads, ProgressBar("light curves"))

    def _fill(self, piece: Piece, sun: FloatArray, observer: FloatArray, out: FloatArray) -> None:
        fill = self._of_ellipsoids if self._has_axes else self._of_meshes
        fill(piece, sun, observer, out)
        if self._law.has_phase:
            from attitude._solver.vectors import separation

            units = (read_only(component) for v in (sun, observer) for component in _unit(v))
            out *= self._law.phase(np.nan_to_num(separation(*units)))
        if np.isnan(out).any():
            self._explain(piece, sun, observer)

    def _of_ellipsoids(
        self, piece: Piece, sun: FloatArray, observer: FloatArray, out: FloatArray
    ) -> None:
        assert isinstance(self._shapes, np.ndarray) and self._law.weights is not None
        work = np.empty((1, 10, PIECE))
        vectors, factor = (*_memory(sun), *_memory(observer)), self._law.weights[0]
        t = piece.t.mapped(read_only).taken(None)

        for numbers, edges in states.blocks_of_runs(piece.member, 0, len(piece.member)):
            shapes = self._shapes if len(self._shapes) == 1 else self._shapes[numbers]
            solved = self._evaluation.prepared(numbers)
            records, others = read_only(solved.constants), (*vectors, shapes, factor, work, out)
            failed = ellipsoid_runs(records, edges, *t, *others)
            if failed >= 0:
                times = self._evaluation.reachable(failed, solved, numbers, t, edges)
                ellipsoid_runs(records, edges, *times, *others)

    def _make_kernels(self, member: IntArray, threads: int) -> None:
        """The functions that sum over the facets of each shape that occurs."""
        for k in [0] if len(self._shapes) == 1 else np.unique(member).tolist():
            shape = self._shapes[k]
            if id(shape) not in self._kernels:
                self._kernels[id(shape)] = kernel_of(shape, self._law, self._shadows, threads)

    def _of_meshes(
        self, piece: Piece, sun: FloatArray, observer: FloatArray, out: FloatArray
    ) -> None:
        from attitude._solver import vectors as solver_vectors

        count = len(piece.member)
        wxyz, turned = np.empty((4, count)), np.empty((2, 3, count))
        self._evaluation.runs(piece.member, 0, count, piece.t, Results(wxyz))
        for vectors, into in zip((sun, observer), turned, strict=True):
            solver_vectors.to_body(read_only(wxyz), read_only(_unit(vectors)), into)
        parts = [read_only(component) for both in turned for component in both]
        # Directions that are not known have no place among the facets.
        known = np.isfinite(turned).all(axis=(0, 1))
        if not known.all():
            parts = [
                read_only(np.where(known, component, k % 3 == 2))
                for k, component in enumerate(parts)
            ]
        if len(self._shapes) == 1:
            self._kernels[id(self._shapes[0])](*parts, out)
        else:
            who, starts = states.runs_of(piece.member, 0, count)
            for k, first, end in zip(who.tolist(), starts, starts[1:], strict=False):
                some = [component[first:end] for component in parts]
                self._kernels[id(self._shapes[k])](*some, out[first:end])
        out[~known] = np.nan

    def _explain(self, piece: Piece, sun: FloatArray, observer: FloatArray) -> None:
        """AttitudeError for vectors that have no direction; NaN vectors are missing ones."""
        for name, vectors in (("sun", sun), ("observer", observer)):
            with np.errstate(over="ignore"):
                squares = np.sum(vectors * vectors, axis=1)
            bad = np.flatnonzero((squares == 0.0) | np.isinf(squares))
            if len(bad):
                k = int(bad[0])
                label = self._evaluation.label(int(piece.member[k]))
                raise AttitudeError(
                    f"{name} of {label} is {vectors[k].tolist()}; give "
                    "vectors from the body of finite length above zero, or NaN where there is none."
                )


def known_shapes(
    shape: Any, count: int, label: Callable[[int], str]
) -> FloatArray | list[Ellipsoid | Mesh]:
    """Semi-axes (1 or N, 3) in m if all shapes are ellipsoids, else a list of 1 or N shapes."""
    if shape is None:
        raise AttitudeError(
            "shape is missing; give an Ellipsoid or a Mesh, or one for each member."
        )
    if isinstance(shape, (Ellipsoid, Mesh)):
        shapes = [shape]
    elif isinstance(shape, (list, tuple)) and any(
        one is None or isinstance(one, (Ellipsoid, Mesh)) for one in shape
    ):
        shapes = list(shape)
    else:
        return _known_axes(shape, count, label)
    if len(shapes) not in (1, count):
        raise AttitudeError(
            f"{len(shapes)} shapes are given for {count} members; give one, or one for each."
        )
    for k, one in enumerate(shapes):
        if one is None:
            raise AttitudeError(f"{label(k)}: its shape is missing; give an Ellipsoid or a Mesh.")
        if not isinstance(one, (Ellipsoid, Mesh)):
            raise AttitudeError(
                f"{label(k)}: its shape is {validation.shown(one)}; give an Ellipsoid or a Mesh."
            )
    ellipsoids = [one for one in shapes if isinstance(one, Ellipsoid)]
    if len(ellipsoids) == len(shapes):
        return np.array([one.semi_axes for one in ellipsoids]).reshape(-1, 3)
    return shapes


def _known_axes(shape: Any, count: int, label: Callable[[int], str]) -> FloatArray:
    axes = validation.real(shape, "shape", unit="m", finite=False)
    if axes.shape == (3,):
        axes = axes[None]
    if axes.ndim != 2 or axes.shape[1] != 3 or len(axes) not in (1, count):
        raise AttitudeError(
            f"shape has shape {axes.shape}; give semi-axes (3,) or ({count}, 3), an Ellipsoid or "
            "Mesh, or one for each member."
        )
    bad = np.flatnonzero(~np.all((axes > 0.0) & (axes < np.inf), axis=1))
    if len(bad):
        k = int(bad[0])
        raise AttitudeError(
            f"{label(k)}: its semi-axes are {axes[k].tolist()}; each is finite and greater than "
            "zero, in m."
        )
    return np.ascontiguousarray(axes)


def known_vectors(value: Any, name: str, shape: tuple[int, ...]) -> FloatArray:
    """Vectors (..., 3) broadcast to (*shape, 3), a view of what is given where possible."""
    if value is None:
        raise AttitudeError(f"{name} is missing; give vectors (..., 3) from the body, in ICRF.")
    array = validation.rows(value, name, 3, unit="m")
    try:
        return np.broadcast_to(array, (*shape, 3))
    except ValueError as err:
        raise AttitudeError(
            f"{name} has shape {array.shape} and the epochs {shape}; give (3,), or one vector for "
            f"each epoch, {(*shape, 3)}."
        ) from err


def _modulus(sun: FloatArray, observer: FloatArray) -> FloatArray:
    """5 log10 of the product of the lengths (K,), in au, of two vectors (K, 3) in m."""
    lengths = (np.sqrt(np.einsum("kj,kj->k", vectors, vectors)) for vectors in (sun, observer))
    one, other = (length / ASTRONOMICAL_UNIT_M for length in lengths)
    return 5.0 * np.log10(one * other)


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors (K, 3) as unit vectors by component, (3, K)."""
    rows = np.ascontiguousarray(vectors.T)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return rows / np.sqrt(np.sum(rows * rows, axis=0))


def _memory(vectors: FloatArray) -> tuple[FloatArray, tuple[int, int]]:
    """The memory of vectors (K, 3) as one row of numbers, and the steps of its two axes in it."""
    row, component = (step // 8 for step in vectors.strides)
    if row < 0 or component < 0 or any(step % 8 for step in vectors.strides):
        return read_only(np.ascontiguousarray(vectors).reshape(-1)), (3, 1)
    size = (len(vectors) - 1) * row + 2 * component + 1 if len(vectors) else 0
    flat = np.lib.stride_tricks.as_strided(vectors, (size,), (8,), writeable=False)
    return flat, (row, component)
