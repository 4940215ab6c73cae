"""First guesses: the inertia from what a free rotation conserves, and the first state.

With attitudes, R I w = L at every record, which is linear in the inertia I and in L.  With angular
velocities alone, Euler's equations integrated over time, I w + integral of w x I w, do not change.
Either way the tensor is that for which the vectors vary least; a sphere where none is better.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import propagation, quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.fitting.model import Point

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.fitting.minimum import Problem
    from attitude.fitting.model import Model
    from attitude.fitting.observations import Observations

# Records of which a guess is made, at most.
_ENOUGH = 2000
# Weight of a sphere, relative to the squares of the angular velocities.
_SPHERE = 1e-12
# Repetitions of the weighting that removes outliers.
_REWEIGHTED = 15
# Records from whose states one is chosen, at most.
CANDIDATES = 16
# Records to either side of which medians are taken, and median deviations from which an outlier is.
_NEIGHBOURS, _SPIKE = 2, 6.0
# Angle between records, rad, up to which angular velocities are integrated.
_FARTHEST = 1.0


def velocities(wxyz: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Attitudes (N - 1, 4) between records (N, 4), and the angular velocities (N - 1, 3) there."""
    turn = forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(wxyz[:-1]), wxyz[1:]))
    middle = quaternion.multiply(wxyz[:-1], forms.from_rotation_vector(0.5 * turn))
    return middle, turn / np.diff(t)[:, None]


def inertia_of_attitudes(
    wxyz: FloatArray, omega: FloatArray, axes: str, *, robust: bool
) -> FloatArray:
    """The tensor (3, 3) of unit trace for which R I w varies least.

    Parameters
    ----------
    wxyz, omega : (K, 4) and (K, 3) arrays
        Attitudes, and angular velocities over the body axes, rad/s.
    axes : str
        "principal" or "free".
    robust : bool
        Whether records far from the others count less.
    """
    wxyz, omega = wxyz[:_ENOUGH], omega[:_ENOUGH]
    basis = _basis(axes)
    vectors = quaternion.matrix(wxyz) @ np.tensordot(omega, basis, axes=(1, 2)).transpose(0, 2, 1)
    return _least_varying(vectors, np.zeros(len(omega), np.int64), omega, basis, robust)


def inertia_of_rates(t: FloatArray, omega: FloatArray, axes: str, *, robust: bool) -> FloatArray:
    """The tensor (3, 3) of unit trace for which Euler's equations hold best.

    Raises
    ------
    AttitudeError
        For records that are more than `_FARTHEST` apart.
    """
    t, omega = t[:_ENOUGH], omega[:_ENOUGH]
    if robust:
        # An outlier would remain in all later integrals.
        omega = _without_spikes(omega)
    basis = _basis(axes)
    step = np.diff(t)
    speed = np.linalg.norm(omega, axis=1)
    joined = 0.5 * (speed[1:] + speed[:-1]) * step <= _FARTHEST
    if np.count_nonzero(joined) < min(len(basis), 3):
        raise AttitudeError(
            "the angular velocities are too far apart for a first guess of the inertia: fewer than "
            f"3 of their {len(step)} steps are turns of less than {_FARTHEST:g} rad. Give denser "
            "records, the body, or a motion near the truth, start=FreeRotation(...)."
        )
    vectors = np.empty((len(t), 3, len(basis)))
    for k, each in enumerate(basis):
        product = np.cross(omega, omega @ each)
        area = 0.5 * (product[1:] + product[:-1]) * step[:, None]
        if len(t) > 2:
            # The trapezium rule with slopes at the ends, of fourth order.
            slope = np.gradient(product, t, axis=0)
            area += (slope[:-1] - slope[1:]) * (step**2 / 12.0)[:, None]
        area[~joined] = 0.0
        vectors[:, :, k] = omega @ each
        vectors[1:, :, k] += np.cumsum(area, axis=0)
    group = np.concatenate([[0], np.cumsum(~joined)])
    return _least_varying(vectors, group, omega, basis, robust)


def point_of(model: Model, observed: Observations, start: object) -> Point:
    """The point of a motion that the caller gives as the first guess.

    Raises
    ------
    AttitudeError
        For another object, and principal axes that are not along the body axes.
    """
    from attitude.free_rotation.free_rotation import FreeRotation

    if not isinstance(start, FreeRotation):
        raise AttitudeError(f"start is {start!r}; give a FreeRotation, or leave it out.")
    tensor = start.body.tensor / np.trace(start.body.tensor)
    off = np.max(np.abs(tensor - np.diag(np.diag(tensor))))
    if model.body is None and model.axes == "principal" and off > 1e-9:
        raise AttitudeError(
            "start has a body whose principal axes are not along the body axes; give "
            'axes="free", or a start with Body(moments=...).'
        )
    state = start.at(observed.epoch)
    return Point(np.array(state.wxyz), np.array(state.angular_velocity), model.shape_of(tensor))


def states_at_first(
    model: Model, shape: FloatArray, states: tuple[FloatArray, FloatArray, FloatArray]
) -> list[Point]:
    """Points (K) at the first record of states at other epochs.

    Parameters
    ----------
    model : Model
    shape : (k,) array
    states : arrays (K,), (K, 4), (K, 3)
        Seconds since the first record, attitudes and angular velocities (body axes).
    """
    t, wxyz, omega = states
    moments, axes = model.principal(shape)
    to_body = forms.from_matrix(axes)
    wxyz, omega = propagation.propagate(
        moments,
        quaternion.multiply(wxyz, to_body),
        omega @ axes,
        -t[:, None],
        angular_velocity=True,
    )
    first = quaternion.multiply(wxyz[:, 0], quaternion.conjugate(to_body))
    return [Point(q, axes @ w, shape) for q, w in zip(first, omega[:, 0], strict=True)]


def best_state(
    problem: Problem,
    shape: FloatArray,
    states: tuple[FloatArray, FloatArray, FloatArray],
) -> Point:
    """The first of some states, or with a robust loss, as some are outliers, the best one.

    Parameters
    ----------
    problem : Problem
        Of the records of the first stage.
    shape, states
        As for `states_at_first`.
    """
    many = CANDIDATES if problem.loss.robust else 1
    t, wxyz, omega = states
    points = states_at_first(problem.model, shape, (t[:many], wxyz[:many], omega[:many]))
    if many == 1:
        return points[0]
    return min(points, key=lambda point: problem.linearised(point).cost)


def _without_spikes(omega: FloatArray) -> FloatArray:
    """The rates (K, 3), with the medians of their neighbours in place of outliers."""
    padded = np.pad(omega, ((_NEIGHBOURS, _NEIGHBOURS), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1, axis=0)
    medians = np.median(windows, axis=-1)
    away = np.linalg.norm(omega - medians, axis=1)
    return np.where((away > _SPIKE * np.median(away))[:, None], medians, omega)


def _least_varying(
    vectors: FloatArray,
    group: IntArray,
    omega: FloatArray,
    basis: FloatArray,
    robust: bool,
) -> FloatArray:
    """The tensor of unit trace whose vectors (K, 3, B) vary least within groups (K,) of records."""
    sphere = np.array([np.trace(each) / np.sum(each**2) for each in basis])
    floor = _SPHERE * np.sum(omega**2) * np.eye(len(basis))
    weight = np.ones(len(vectors))
    found = sphere
    for _ in range(_REWEIGHTED if robust else 1):
        total = np.bincount(group, weight)
        centred = vectors - _sums(vectors, group, weight)[group] / total[group, None, None]
        flat = centred.reshape(-1, len(basis))
        normal = flat.T @ (flat * np.repeat(weight, 3)[:, None])
        found = np.linalg.solve(normal + floor, sphere)
        found = found / np.tensordot(found, basis, axes=1).trace()
        size = np.linalg.norm(centred @ found, axis=1)
        weight = 1.0 / np.maximum(size, 0.1 * np.median(size) + 1e-300)
        weight /= weight.max()
    tensor: FloatArray = np.tensordot(found, basis, axes=1)
    return tensor


def _sums(vectors: FloatArray, group: IntArray, weight: FloatArray) -> FloatArray:
    """Weighted sums (G, 3, B) of the vectors (K, 3, B) of each group."""
    sums = np.zeros((group[-1] + 1, *vectors.shape[1:]))
    np.add.at(sums, group, vectors * weight[:, None, None])
    return sums


def _basis(axes: str) -> FloatArray:
    """A basis (B, 3, 3) of the diagonal matrices, or of the symmetric ones for free axes."""
    found = [np.diag(row) for row in np.eye(3)]
    if axes == "free":
        for i, j in ((0, 1), (0, 2), (1, 2)):
            matrix = np.zeros((3, 3))
            matrix[i, j] = matrix[j, i] = 1.0
            found.append(matrix)
    return np.array(found)
