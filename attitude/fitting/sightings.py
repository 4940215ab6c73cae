"""Attitudes and angular velocities from directions: Davenport's method, at epochs and over spans.

The attitude that fits weighted directions best is the eigenvector of the greatest eigenvalue of a
4 x 4 matrix that is linear in the products of their components.  Over a span in which the angular
velocity counts as constant, the directions are turned to its middle first: all angular velocities
of a grid are tried, the best ones are improved.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.fitting.minimum import Problem
from attitude.fitting.model import Model, Point

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.fitting.losses import Loss
    from attitude.fitting.observations import Directions, Observations

# Gap between the two greatest eigenvalues, of the sum of weights, from which an attitude is
# determined: two directions 3 deg apart.
_DETERMINED = 1e-3
# Directions of the first span, and of a later one at least and at most.
_FIRST, _LEAST, _LARGEST = 10, 6, 60
# Angle of a later span and from one to the next, rad, and number of spans.
_SPAN, _STRIDE, _SPANS = 1.0, 0.3, 60
# The grid: greatest turn between records, spacing across half a span, rad, and nodes improved.
_FASTEST, _SPACING, _BEST = 1.5, 0.4, 8


def attitudes(t: FloatArray, directions: Directions) -> tuple[FloatArray, FloatArray]:
    """Epochs (K,) with directions that determine an attitude, and these attitudes (K, 4).

    Parameters
    ----------
    t : (N,) array
        Seconds; equal for the directions of one epoch.
    directions : Directions
    """
    times, group = np.unique(t, return_inverse=True)
    products = np.einsum("n,ni,nj->nij", directions.weight, directions.known, directions.measured)
    sums = np.zeros((len(times), 3, 3))
    np.add.at(sums, group, products)
    total = np.bincount(group, directions.weight)
    values, vectors = np.linalg.eigh(_davenport(sums))
    determined = values[:, 3] - values[:, 2] > _DETERMINED * total
    return times[determined], vectors[determined, :, 3]


def spans(observed: Observations, loss: Loss) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States of short spans: seconds (K,), attitudes (K, 4), angular velocities (K, 3).

    Raises
    ------
    AttitudeError
        For directions at fewer than three epochs.
    """
    if len(np.unique(observed.t)) < 3:
        raise AttitudeError(
            "the directions are of fewer than three epochs and do not determine attitudes; give "
            "more, or a motion near the truth, start=FreeRotation(...)."
        )
    sphere = Model(Body(moments=(1.0, 1.0, 1.0)), "principal")
    found: list[tuple[float, Point]] = []
    begin, size, stride = 0, min(_FIRST, len(observed)), 1
    while begin + size <= len(observed) and len(found) < _SPANS:
        part, middle = _centred(observed, begin, size)
        problem = Problem(sphere, part, loss)
        if found:
            before, point = found[-1]
            turn = forms.from_rotation_vector(point.omega * (middle - before))
            wxyz = quaternion.multiply(point.wxyz, turn)
            best = problem.minimum(Point(wxyz, point.omega, point.shape))
        else:
            best = min((problem.minimum(each) for each in _nodes(part)), key=lambda each: each.cost)
            step = float(observed.t[-1] - observed.t[0]) / (len(observed) - 1)
            angle = max(float(np.linalg.norm(best.point.omega)) * step, 1e-300)
            size = int(np.clip(_SPAN / angle, _LEAST, _LARGEST))
            stride = int(np.clip(_STRIDE / angle, 1, _LARGEST))
            begin = max(begin, (_FIRST - size) // 2)
        found.append((middle, best.point))
        begin += stride
    states = zip(*((middle, point.wxyz, point.omega) for middle, point in found), strict=True)
    times, wxyz, omega = (np.array(each) for each in states)
    return times, wxyz, omega


def _centred(observed: Observations, begin: int, size: int) -> tuple[Observations, float]:
    """Records begin .. begin + size - 1, their seconds since the middle, and the middle."""
    part = observed.at(slice(begin, begin + size))
    middle = 0.5 * float(part.t[0] + part.t[-1])
    return replace(part, t=part.t - middle), middle


def _nodes(part: Observations) -> list[Point]:
    """The nodes of a grid of angular velocities that fit a span best, with their attitudes."""
    directions: Directions = part.kinds[0]  # type: ignore[assignment]
    half = float(np.max(np.abs(part.t)))
    step = 2.0 * half / (len(part) - 1)
    most = int(_FASTEST / step * half / _SPACING)
    line = np.arange(-most, most + 1) * (_SPACING / half)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[np.linalg.norm(grid, axis=1) <= line[-1] * (1.0 + 1e-9)]
    turns = forms.from_rotation_vector(grid[:, None] * part.t[:, None])
    turned = quaternion.rotate(turns, directions.measured)
    weighted = directions.known * directions.weight[:, None]
    values, vectors = np.linalg.eigh(_davenport(np.einsum("ni,gnj->gij", weighted, turned)))
    best = np.argsort(-values[:, 3])[:_BEST]
    return [Point(vectors[k, :, 3], grid[k], np.zeros(0)) for k in best]


def _davenport(sums: FloatArray) -> FloatArray:
    """Davenport's matrices (..., 4, 4) of sums (..., 3, 3) of inertial times body components."""
    found = np.empty((*sums.shape[:-2], 4, 4))
    trace = np.trace(sums, axis1=-2, axis2=-1)
    found[..., 0, 0] = trace
    for k, (i, j) in enumerate(((2, 1), (0, 2), (1, 0)), start=1):
        found[..., 0, k] = found[..., k, 0] = sums[..., i, j] - sums[..., j, i]
    found[..., 1:, 1:] = sums + np.swapaxes(sums, -1, -2) - trace[..., None, None] * np.eye(3)
    return found
