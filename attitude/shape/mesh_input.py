"""Checks of the vertices, facets and materials of a mesh, each with the facets at fault named."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError, quoted
from attitude.shape.closure import doubled_facets

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.shape.closure import Edges


def vertices_of(value: Any) -> FloatArray:
    """A new array (V, 3) of finite coordinates, m.

    Raises
    ------
    AttitudeError
        For another shape or unit, and coordinates that are not finite.
    """
    array = validation.real(value, "vertices", unit="m", finite=False)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise AttitudeError(f"vertices has shape {array.shape}; give (V, 3), in m.")
    bad = np.flatnonzero(~np.all(np.isfinite(array), axis=1))
    if len(bad):
        raise AttitudeError(
            f"vertices {listed(bad)} hold NaN or infinity (the first is {array[bad[0]]}); every "
            "coordinate must be finite."
        )
    return array


def facets_of(value: Any, count: int) -> IntArray:
    """A new array (F, 3) of indices from 0 into so many vertices.

    Raises
    ------
    AttitudeError
        For another shape or type, and indices without a vertex.
    """
    try:
        array = np.array(value)
    except ValueError as err:
        raise AttitudeError("facets is ragged; give (F, 3): three vertices for each.") from err
    if (
        array.ndim != 2
        or array.shape[1:] != (3,)
        or len(array) == 0
        or array.dtype.kind not in "iu"
    ):
        raise AttitudeError(
            f"facets has shape {array.shape} of {array.dtype}; give (F, 3) whole numbers, indices "
            "from 0 into the vertices."
        )
    array = np.ascontiguousarray(array, dtype=np.int64)
    bad = np.flatnonzero(np.any((array < 0) | (array >= count), axis=1))
    if len(bad):
        raise AttitudeError(
            f"facets {listed(bad)} name vertices that do not exist (the first is "
            f"{array[bad[0]].tolist()}); there are {count}, numbered from 0."
        )
    return array


def materials_of(given: Any, count: int) -> tuple[str, ...]:
    """The name of the material of each of so many facets.

    Raises
    ------
    AttitudeError
        For another number of names, and anything but text.
    """
    try:
        names = (given,) * count if isinstance(given, str) else tuple(given)
    except TypeError as err:
        raise AttitudeError(
            f"materials is {quoted(given)}; give one name for all facets, or one for each."
        ) from err
    if len(names) != count or not all(isinstance(name, str) for name in names):
        raise AttitudeError(
            f"materials has {len(names)} entries for {count} facets; give one name for each facet, "
            "or a single name for all."
        )
    return names


def refuse_degenerate(corners: FloatArray, areas: FloatArray) -> None:
    """Raise the AttitudeError for facets (F, 3, 3) without area beyond the rounding of corners."""
    a, b, c = np.moveaxis(corners, 1, 0)
    edge = np.sqrt(np.max([np.sum(d * d, axis=-1) for d in (b - a, c - b, a - c)], axis=0))
    # Corners known to half an ulp leave a cross product of two edges uncertain by this much.
    size = np.max(np.abs(corners), axis=(1, 2))
    noise = 4.0 * np.finfo(float).eps * size * edge
    flat = np.flatnonzero(~(2.0 * areas > noise))
    if len(flat):
        raise AttitudeError(
            f"facets {listed(flat)} are degenerate: their corners lie on a line or coincide, so "
            "they have no normal. Remove them and merge the vertices that coincide."
        )


def refuse_doubled(corners: FloatArray) -> None:
    """Raise the AttitudeError for two facets among (F, 3, 3) that are the same."""
    pair = doubled_facets(corners)
    if pair is not None:
        raise AttitudeError(
            f"facets {pair[0]} and {pair[1]} are doubled: they have the same corners in the same "
            "order, so that their area would count twice. Remove one of them, or read the file "
            "with repair=True."
        )


def refuse_repeated(facets: IntArray, edges: Edges) -> None:
    """Raise the AttitudeError for edges that facets (F, 3) pass twice in the same direction."""
    if len(edges.repeated) == 0:
        return
    own = facets[edges.repeated]
    passed = np.stack([own, own[:, [1, 2, 0]]], axis=-1).reshape(-1, 2)
    each, times = np.unique(passed, axis=0, return_counts=True)
    start, end = each[np.argmax(times > 1)]
    raise AttitudeError(
        f"facets {listed(edges.repeated)} run against a neighbour: an edge is passed twice in the "
        f"same direction (first that from vertex {start} to vertex {end}). Turn the facets the "
        "same way, vertices anticlockwise seen from outside, remove those in excess, or read the "
        "file with repair=True."
    )


def listed(indices: IntArray) -> str:
    """The first few indices as text."""
    shown = ", ".join(str(int(i)) for i in indices[:8])
    return shown if len(indices) <= 8 else f"{shown} and {len(indices) - 8} more"
