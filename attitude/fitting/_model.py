"""The motion of parameters, and its derivatives in closed form.

A point has the first attitude, the angular velocity there and the shape: logarithms of the second
moments of mass, whose sum is zero.  Its parameters are the turn of the attitude (3, rad, body
axes), the change of the angular velocity (3, rad/s, body axes) and that of the shape: none for a
known body, 2 for principal axes along the body axes, 5 (two diagonal and three other elements of
the logarithm of the matrix) for free axes.

A change of the off-diagonal elements turns the principal axes, by angles that are the elements
over the differences of the eigenvalues.  In the derivative of the attitude of the body these
quotients cancel to a finite limit where two eigenvalues agree.  Its digits cancel too: closer
eigenvalues are moved to a difference of `_CLOSEST`, for the derivatives only.  This changes them by
`_CLOSEST` times the angle turned, as much as rounding does at that difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude._support import validation
from attitude._support.arrays import frozen
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _propagation
from attitude.motions._body import Body, tensors_of

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


# Bound of the logarithms of the second moments of mass: beyond, the body is a rod or a disc.
_LIMIT = 18.0
# The least second moment of mass of a first guess, of the largest.
_FLATTEST = 1e-3
# Difference of the logarithms of two second moments below which derivatives are those at it.
_CLOSEST = 3e-8
_PAIRS = ((0, 1), (0, 2), (1, 2))
_BODY_AXES = frozen(np.eye(3))


@dataclass(frozen=True)
class Point:
    """A first attitude (4,), body to ICRF, the angular velocity (3,) there, and the shape."""

    wxyz: FloatArray
    omega: FloatArray
    shape: FloatArray

    def moved(self, change: FloatArray) -> Point:
        """The point after a change (P,) of the parameters, its shape within the limits."""
        wxyz = quaternion.multiply(self.wxyz, forms.from_rotation_vector(change[:3]))
        shape = np.clip(self.shape + change[6:], -_LIMIT, _LIMIT)
        return Point(wxyz / np.linalg.norm(wxyz), self.omega + change[3:6], shape)


class Prediction(NamedTuple):
    """The motion of a point at N epochs, over the principal axes of inertia, and its derivatives.

    rates: the change of the angular velocity of the body, over the (unchanged) principal axes.
    """

    wxyz: FloatArray  # (N, 4), principal axes to ICRF
    omega: FloatArray | None  # (N, 3), rad/s, principal axes
    axes: FloatArray  # (3, 3), columns: the principal axes over the body axes
    to_body: FloatArray | None  # (4,), the same as a quaternion; None: they are the body axes
    # (3, P, N), turn of the body, ICRF axes, for a unit change of each parameter
    attitude: FloatArray
    rates: FloatArray | None  # (3, P, N)


class Chain(NamedTuple):
    """What a change of the parameters does to the nine parameters of the principal axes.

    state: first attitude of the principal axes (rad, ICRF axes), angular velocity (rad/s, principal
        axes), principal moments of the tensor of unit trace.
    """

    state: FloatArray  # (9, P)
    turns: FloatArray  # (3, P), turn of the principal axes in the body, rad, over themselves


class Model:
    """Free rotations of a known body, or of one of any shape with "principal" or "free" `axes`."""

    def __init__(self, body: Body | None, axes: str) -> None:
        if body is not None and not isinstance(body, Body):
            raise AttitudeError(f"body is {validation.shown(body)}; give a Body, or leave it out.")
        if not isinstance(axes, str) or axes not in ("principal", "free"):
            raise AttitudeError(f'axes is {validation.shown(axes)}; give "principal" or "free".')
        self.body, self.axes = body, axes
        shapes = 0 if body is not None else (2 if axes == "principal" else 5)
        self.count = 6 + shapes
        self._directions = _directions(shapes)

    def shape_of(self, tensor: FloatArray) -> FloatArray:
        """The shape of an inertia tensor, which need not be that of a body."""
        if self.body is not None:
            return np.zeros(0)
        second = 0.5 * np.trace(tensor) * np.eye(3) - tensor
        values, vectors = np.linalg.eigh(0.5 * (second + second.T))
        values = np.maximum(values, _FLATTEST * np.max(np.abs(values)))
        logarithm = (vectors * np.log(values)) @ vectors.T
        logarithm -= np.trace(logarithm) / 3.0 * np.eye(3)
        if self.axes == "principal":
            return np.diag(logarithm)[:2]
        return np.array([logarithm[0, 0], logarithm[1, 1], *(logarithm[pair] for pair in _PAIRS)])

    def body_of(self, shape: FloatArray) -> Body:
        """The body of a shape: the known one, or one whose relative moments have the sum 1."""
        if self.body is not None:
            return self.body
        moments, axes = self.principal(shape)
        if self.axes == "principal":
            return Body(moments=moments, relative=True)
        return Body(tensor=tensors_of(moments, axes), relative=True)

    def principal(self, shape: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Principal moments (3,) of a shape, and the axes (3, 3), columns, right-handed."""
        values, axes = self._eigen(shape)
        return self._moments_of(values), axes

    def predict(self, point: Point, t: FloatArray, *, rates: bool) -> Prediction:
        """The motion of a point at seconds t (N,) since its attitude, with derivatives."""
        values, axes = self._eigen(point.shape)
        apart = _apart(values) if self.axes == "free" and self.body is None else values
        chain = self.chain(point, apart, axes)
        to_body = None if axes is _BODY_AXES else quaternion.from_matrix(axes)
        start = point.wxyz if to_body is None else quaternion.multiply(point.wxyz, to_body)
        initial_rates = point.omega @ axes
        attitudes = [
            array[0]
            for array in _propagation.linearized(
                self._moments_of(apart),
                start[None],
                initial_rates[None],
                t,
                angular_velocity=rates,
            )
        ]
        wxyz, omega = attitudes[0], attitudes[1] if rates else None
        columns = chain.state.T @ attitudes[1 + rates].transpose(1, 2, 0)
        rate_columns = chain.state.T @ attitudes[3].transpose(1, 2, 0) if rates else None
        if np.any(chain.turns):
            # The attitude of the body is that of the principal axes, turned back by their turn.
            matrix = np.ascontiguousarray(quaternion.matrix(wxyz).transpose(1, 2, 0))
            columns -= chain.turns.T @ matrix
            if rate_columns is not None and omega is not None:
                rate_columns += np.cross(chain.turns.T[:, None], omega).transpose(2, 0, 1)
        if apart is not values:
            moments = self._moments_of(values)
            exact = _propagation.propagate(moments, start, initial_rates, t, angular_velocity=True)
            wxyz, omega = exact[0], exact[1] if rates else None
        return Prediction(wxyz, omega, axes, to_body, columns, rate_columns)

    def chain(self, point: Point, values: FloatArray, axes: FloatArray) -> Chain:
        """The chain rule to the motion of the principal axes (3, 3), of eigenvalues (3,)."""
        state, turns = np.zeros((9, self.count)), np.zeros((3, self.count))
        matrix = quaternion.matrix(point.wxyz)
        state[:3, :3] = matrix
        state[3:6, 3:6] = axes.T
        if self.body is not None:
            return Chain(state, turns)
        mass = np.exp(values - values.max())
        total = 2.0 * mass.sum()
        moments = (0.5 * total - mass) / total
        change = axes.T @ self._directions @ axes
        grown = change.diagonal(axis1=1, axis2=2) * (mass / total)
        all_grown = grown.sum(axis=1)[:, None]
        state[6:, 6:] = (all_grown - grown - 2.0 * moments * all_grown).T
        for i, j, axis in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
            there = change[:, i, j]
            turns[axis, 6:] = np.divide(
                there, values[j] - values[i], out=np.zeros_like(there), where=there != 0.0
            )
        if np.any(turns):
            state[:3] += matrix @ axes @ turns
            state[3:6] += np.cross(point.omega @ axes, turns.T).T
        return Chain(state, turns)

    def logarithms(self, shape: FloatArray, axes: FloatArray) -> FloatArray:
        """The eigenvalues (3,) of a shape for given principal axes; zeros for a known body."""
        if self.body is not None:
            return np.zeros(3)
        return np.einsum("ik,ij,jk->k", axes, self._logarithm(shape), axes)

    def _eigen(self, shape: FloatArray) -> tuple[FloatArray, FloatArray]:
        if self.body is not None:
            axes = self.body.principal_axes
            return np.zeros(3), _BODY_AXES if np.array_equal(axes, _BODY_AXES) else axes
        if self.axes == "principal":
            return np.array([shape[0], shape[1], -shape[0] - shape[1]]), _BODY_AXES
        values, axes = np.linalg.eigh(self._logarithm(shape))
        if np.linalg.det(axes) < 0.0:
            axes[:, 2] *= -1.0
        return values, axes

    def _logarithm(self, shape: FloatArray) -> FloatArray:
        """The symmetric matrix (3, 3) of a shape, of trace zero."""
        return np.tensordot(shape, self._directions, axes=1)

    def _moments_of(self, values: FloatArray) -> FloatArray:
        """Principal moments of the known body, or with the sum 1 of logarithms of second ones."""
        if self.body is not None:
            return self.body.moments
        mass = np.exp(values - values.max())
        sums = np.array([mass[1] + mass[2], mass[2] + mass[0], mass[0] + mass[1]])
        return sums / (2.0 * mass.sum())


def _directions(count: int) -> FloatArray:
    """The derivatives (count, 3, 3) of the logarithm of the second moments by the shape."""
    matrices = np.zeros((count, 3, 3))
    for k in range(min(count, 2)):
        matrices[k, k, k], matrices[k, 2, 2] = 1.0, -1.0
    for k, (i, j) in zip(range(2, count), _PAIRS, strict=False):
        matrices[k, i, j] = matrices[k, j, i] = 1.0
    return matrices


def _apart(values: FloatArray) -> FloatArray:
    """Ascending eigenvalues with differences of at least `_CLOSEST`; the same array if they are."""
    if np.all(np.diff(values) >= _CLOSEST):
        return values
    second = max(values[1], values[0] + _CLOSEST)
    return np.array([values[0], second, max(values[2], second + _CLOSEST)])
