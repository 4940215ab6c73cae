"""The free rotation through a measured attitude history, by least squares.

The residual of a record is the turn in rad, over the body axes, from the model to the record.  The
first guess follows from the conservation of angular momentum: R I w = L at every record, which is
linear in the inertia I and in L.  From there the span grows in stages to the whole table, so that
no phase of a tumbler is wrong by a revolution.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from attitude import propagation, quaternion, validation
from attitude import representations as forms
from attitude.attitude_table.table import AttitudeTable
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.history import AttitudeHistory
from attitude.immutable import Immutable, frozen
from attitude.spin import Spin

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Reals

# Step of central differences of the model, which errs by 1e-15: derivatives are good to 1e-10.
_STEP = 1e-5
# Records of the first stage, at least.
_FEWEST = 6
# Bound of the logarithms of the second moments of mass: beyond, the body is a rod or a disc.
_LIMIT = 18.0


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Immutable):
    """A free rotation fitted to records, and its residuals.

    Attributes
    ----------
    motion : FreeRotation
        From the epoch of the table; moments are relative unless a body was given.
    residuals : (N, 3) array
        rad, over the body axes: the turn from the model to each record.
    rate_residuals : (N, 3) array or None
        rad/s: given angular velocities less those of the model.
    covariance : (P, P) array
        Of the parameters, for records whose errors are as large as the residuals: turn of the
        first attitude (3, rad, body axes), angular velocity then (3, rad/s), logarithms of the
        second moments of mass (the rest).  Infinite for parameters that the records leave
        undetermined.
    """

    motion: FreeRotation
    residuals: FloatArray
    rate_residuals: FloatArray | None
    covariance: FloatArray = field(repr=False)

    @property
    def rms(self) -> float:
        """Root mean square of the angles of the residuals, rad."""
        return float(np.sqrt(np.mean(np.sum(self.residuals**2, axis=1))))

    def __repr__(self) -> str:
        return f"<Fit: {len(self.residuals)} records, rms {self.rms:.3g} rad, {self.motion!r}>"


def fit(
    table: AttitudeTable | AttitudeHistory,
    body: Body | None = None,
    *,
    axes: str = "principal",
    sigma: Reals = 1.0,
    rate_sigma: Reals | None = None,
) -> Fit:
    """The free rotation with the least squared residuals to the attitudes of a table.

    Parameters
    ----------
    table : AttitudeTable or AttitudeHistory
        Three records or more, with a body two; steps of less than half a turn unless it has
        angular velocities.
    body : Body, optional
        Of known inertia; by default the inertia is fitted too, as ratios.
    axes : str
        Without a body: "principal" if the body axes are the principal axes, "free" if the
        principal axes are fitted too.
    sigma : float or (N,) array
        Standard errors of the attitudes, rad.
    rate_sigma : float or (N,) array, optional
        Standard errors of given angular velocities, rad/s; by default `sigma` times their mean
        size.  inf leaves them out.

    Returns
    -------
    Fit

    Raises
    ------
    AttitudeError
        For too few records, errors that are not greater than zero, and attitudes from which no
        motion follows.

    Notes
    -----
    Moments follow from the wobble alone: a steady rotation fits any body, and the one returned is
    close to a sphere.

    >>> from attitude import FreeRotation
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1))
    >>> motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    >>> found = fit(AttitudeTable.from_history(motion.at(np.arange(0.0, 60.0, 0.5))))
    >>> found.rms < 1e-9, (found.motion.body.moments / found.motion.body.moments[0]).round(6)
    (True, array([1. , 2. , 2.6]))
    """
    records = _Records(table, sigma, rate_sigma)
    model = _Model(body, axes)
    if len(records) < (3 if model.count > 6 else 2):
        raise AttitudeError(_too_few(len(records)))
    x = model.guess(records)
    for count in records.stages():
        x = _improved(model, records.first(count), x)
    return _result(model, records, x)


def _too_few(count: int) -> str:
    """The sentence about a table that is too short."""
    plural = "" if count == 1 else "s"
    return f"the table has {count} record{plural}; give three or more (two with body=)."


class _Records:
    """Epochs, attitudes and rates of a table as arrays, with their weights."""

    rates: FloatArray | None
    rate_weight: FloatArray | None

    def __init__(
        self,
        table: AttitudeTable | AttitudeHistory,
        sigma: Reals,
        rate_sigma: Reals | None,
    ) -> None:
        history = table.history if isinstance(table, AttitudeTable) else table
        if not isinstance(history, AttitudeHistory) or len(history.shape) != 1:
            raise AttitudeError(
                f"table is {validation.shown(table)}; give an AttitudeTable, or an AttitudeHistory "
                "of epochs (N,)."
            )
        if not len(history):
            raise AttitudeError(_too_few(0))
        self.epoch = history.epoch
        low = np.zeros(len(history)) if history.low is None else np.asarray(history.low)
        self.t, self.low = np.asarray(history.seconds), low
        self.origin = self.t[0], low[0]
        self.wxyz = np.asarray(history.wxyz)
        given = table.angular_velocity if isinstance(table, AttitudeTable) else None
        if not isinstance(table, AttitudeTable):
            given = history.angular_velocity
        self.rates = None if given is None else np.asarray(given)
        self.weight = 1.0 / self._sigmas(sigma, "sigma")
        self.rate_weight = None
        if self.rates is not None:
            size = np.sqrt(np.mean(np.sum(self.rates**2, axis=1)))
            usual = np.mean(1.0 / self.weight) * size if size > 0.0 else np.inf
            self.rate_weight = 1.0 / self._sigmas(
                usual if rate_sigma is None else rate_sigma, "rate_sigma"
            )

    def _sigmas(self, value: Reals, name: str) -> FloatArray:
        given = validation.real(value, name, finite=False)
        if given.shape not in ((), self.t.shape) or not np.all(given > 0.0):
            raise AttitudeError(
                f"{name} is {validation.shown(value)}; give one number greater than zero, or one "
                "for each record."
            )
        return np.broadcast_to(given, self.t.shape)

    def __len__(self) -> int:
        return len(self.t)

    def first(self, count: int) -> _Records:
        """The first records of these."""
        part = object.__new__(_Records)
        part.__dict__.update(self.__dict__)
        for name in ("t", "low", "wxyz", "rates", "weight", "rate_weight"):
            value = getattr(self, name)
            setattr(part, name, None if value is None else value[:count])
        return part

    def since(self) -> FloatArray:
        """Seconds since the first record."""
        return (self.t - self.origin[0]) + (self.low - self.origin[1])

    def stages(self) -> list[int]:
        """Numbers of records of the stages of the fit: about one turn, then half as many more."""
        turn = 2.0 * np.pi / max(self.speed(), 1e-300)
        count = max(_FEWEST, int(np.searchsorted(self.since(), turn)))
        counts = []
        while count < len(self):
            counts.append(count)
            count = max(count + 1, int(1.5 * count))
        return [*counts, len(self)]

    def speed(self) -> float:
        """The mean angular speed, rad/s."""
        return float(np.mean(np.linalg.norm(self.velocities()[1], axis=1)))

    def velocities(self) -> tuple[FloatArray, FloatArray]:
        """Attitudes (K, 4) and the angular velocities (K, 3) there, given or by differences."""
        if self.rates is not None:
            return self.wxyz, self.rates
        step = quaternion.multiply(quaternion.conjugate(self.wxyz[:-1]), self.wxyz[1:])
        turn = forms.to_rotation_vector(step)
        middle = quaternion.multiply(self.wxyz[:-1], forms.from_rotation_vector(0.5 * turn))
        return middle, turn / np.diff(self.since())[:, None]


class _Model:
    """The motion of parameters: turn of the first attitude, its rate, logarithms of the shape."""

    base: FloatArray  # the first attitude, from which the turn counts

    def __init__(self, body: Body | None, axes: str) -> None:
        if body is not None and not isinstance(body, Body):
            raise AttitudeError(f"body is {body!r}; give a Body, or leave it out.")
        if axes not in ("principal", "free"):
            raise AttitudeError(f'axes is {axes!r}; give "principal" or "free".')
        self.body, self.axes = body, axes
        shapes = 0 if body is not None else (2 if axes == "principal" else 5)
        self.count = 6 + shapes

    def guess(self, records: _Records) -> FloatArray:
        """The parameters from the conservation of angular momentum; see the top of the file."""
        wxyz, omega = records.velocities()
        self.base = records.wxyz[0]
        x = np.zeros(self.count)
        early = 1 if records.rates is not None else min(2, len(omega))
        x[3:6] = np.mean(omega[:early], axis=0)
        # 2000 records are enough for a guess.
        part = slice(0, max(_FEWEST, min(len(omega), 2000)))
        if self.body is None:
            x[6:] = self._shape_of(self._inertia(wxyz[part], omega[part]))
        return x

    def _inertia(self, wxyz: FloatArray, omega: FloatArray) -> FloatArray:
        """The tensor of unit trace for which R I w varies least; a sphere where none is better."""
        basis = _diagonals() if self.axes == "principal" else _symmetric()
        vectors = np.stack([quaternion.rotate(wxyz, omega @ each) for each in basis], axis=-1)
        vectors = (vectors - vectors.mean(axis=0)).reshape(-1, len(basis))
        normal = vectors.T @ vectors
        sphere = np.array([np.trace(each) / np.sum(each**2) for each in basis])
        floor = 1e-12 * np.sum(omega**2)
        found = np.linalg.solve(normal + floor * np.eye(len(basis)), sphere)
        tensor = np.tensordot(found, basis, axes=1)
        return tensor / np.trace(tensor)

    def _shape_of(self, tensor: FloatArray) -> FloatArray:
        """Logarithms of the second moments of mass, which may be any positive numbers."""
        second = 0.5 * np.trace(tensor) * np.eye(3) - tensor
        values, vectors = np.linalg.eigh(0.5 * (second + second.T))
        values = np.maximum(values, 1e-3 * np.max(np.abs(values)))
        logarithm = (vectors * np.log(values)) @ vectors.T
        logarithm -= np.trace(logarithm) / 3.0 * np.eye(3)
        if self.axes == "principal":
            return np.diag(logarithm)[:2]
        return np.array([logarithm[0, 0], logarithm[1, 1], *logarithm[[0, 0, 1], [1, 2, 2]]])

    def tensor(self, shape: FloatArray) -> FloatArray:
        """The inertia tensor of unit trace from the logarithms of `_shape_of`."""
        a, b = shape[:2]
        logarithm = np.diag([a, b, -a - b])
        if len(shape) == 5:
            for value, (i, j) in zip(shape[2:], ((0, 1), (0, 2), (1, 2)), strict=True):
                logarithm[i, j] = logarithm[j, i] = value
        values, vectors = np.linalg.eigh(logarithm)
        second = (vectors * np.exp(values - values.max())) @ vectors.T
        tensor = np.trace(second) * np.eye(3) - second
        return 0.5 * (tensor + tensor.T) / np.trace(tensor)

    def bodies(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Principal moments (B, 3) and their axes (B, 3, 3, right-handed) of parameters (B, P)."""
        if self.body is not None:
            moments, axes = self.body.moments, self.body.principal_axes
            return np.tile(moments, (len(points), 1)), np.tile(axes, (len(points), 1, 1))
        if self.axes == "principal":
            tensors = [np.diag(self.tensor(point[6:])) for point in points]
            return np.array(tensors), np.tile(np.eye(3), (len(points), 1, 1))
        moments, axes = np.linalg.eigh(np.array([self.tensor(point[6:]) for point in points]))
        axes[np.linalg.det(axes) < 0.0, :, 2] *= -1.0
        return moments, axes

    def evaluate(self, points: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Attitudes (B, N, 4) and rates (B, N, 3) over the body axes of parameters (B, P)."""
        moments, axes = self.bodies(points)
        start = quaternion.multiply(self.base, forms.from_rotation_vector(points[:, :3]))
        to_body = forms.from_matrix(axes)  # principal to body axes
        wxyz, omega = propagation.propagate(
            moments,
            quaternion.multiply(start, to_body),
            np.einsum("bij,bi->bj", axes, points[:, 3:6]),
            t,
            angular_velocity=True,
        )
        wxyz = quaternion.multiply(wxyz, quaternion.conjugate(to_body)[:, None])
        return wxyz, np.einsum("bij,bnj->bni", axes, omega)

    def residuals(self, points: FloatArray, records: _Records) -> FloatArray:
        """Weighted residuals (B, M) of parameters (B, P)."""
        wxyz, omega = self.evaluate(points, records.since())
        turn = quaternion.multiply(quaternion.conjugate(wxyz), records.wxyz)
        parts = [forms.to_rotation_vector(turn) * records.weight[:, None]]
        if records.rates is not None:
            assert records.rate_weight is not None
            parts.append((records.rates - omega) * records.rate_weight[:, None])
        return np.concatenate(parts, axis=1).reshape(len(points), -1)


def _improved(model: _Model, records: _Records, x: FloatArray) -> FloatArray:
    """The parameters of least squares, from a guess."""
    from scipy.optimize import least_squares

    scale = np.ones(model.count)
    scale[3:6] = max(records.speed(), 1e-300)
    limit = np.full(model.count, np.inf)
    limit[6:] = _LIMIT

    def jacobian(y: FloatArray) -> FloatArray:
        steps = np.eye(model.count) * _STEP
        points = y + np.concatenate([steps, -steps])
        values = model.residuals(points * scale, records)
        return ((values[: model.count] - values[model.count :]) / (2.0 * _STEP)).T

    found = least_squares(
        lambda y: model.residuals((y * scale)[None], records)[0],
        np.clip(x / scale, -limit, limit),
        jac=jacobian,
        bounds=(-limit, limit),
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
        max_nfev=60,
        x_scale="jac",
    )
    return found.x * scale


def _result(model: _Model, records: _Records, x: FloatArray) -> Fit:
    values = model.residuals(x[None], records)[0]
    steps = np.diag(_STEP * np.where(np.arange(model.count) // 3 == 1, records.speed() or 1.0, 1.0))
    ahead, behind = (model.residuals(x + each, records) for each in (steps, -steps))
    slopes = ((ahead - behind) / (2.0 * np.diag(steps)[:, None])).T
    count = len(records)
    free = max(values.size - model.count, 1)
    covariance = _inverse(slopes.T @ slopes) * (values @ values / free)
    wxyz, omega = (each[0] for each in model.evaluate(x[None], records.since()))
    turn = quaternion.multiply(quaternion.conjugate(wxyz), records.wxyz)
    if model.body is not None:
        body = model.body
    elif model.axes == "principal":
        body = Body(moments=np.diag(model.tensor(x[6:])), relative=True)
    else:
        body = Body(tensor=model.tensor(x[6:]), relative=True)
    start = quaternion.multiply(model.base, forms.from_rotation_vector(x[:3]))
    spin = Spin(records.epoch.after(*records.origin), start, x[3:6])
    rates = None if records.rates is None else frozen(records.rates - omega)
    residuals = frozen(forms.to_rotation_vector(turn).reshape(count, 3))
    return Fit(FreeRotation(body, spin), residuals, rates, frozen(covariance))


def _inverse(normal: FloatArray) -> FloatArray:
    """The inverse of a normal matrix; infinite variances where it is singular to rounding."""
    size = np.sqrt(np.maximum(np.diag(normal), 0.0))
    known = size > 0.0
    scaled = normal / np.outer(np.where(known, size, 1.0), np.where(known, size, 1.0))
    values, vectors = np.linalg.eigh(scaled)
    lost = values <= 1e-12
    inverse = (vectors / np.where(lost, 1.0, values)) @ vectors.T
    inverse /= np.outer(np.where(known, size, 1.0), np.where(known, size, 1.0))
    unknown = ~known | np.any(np.abs(vectors[:, lost]) > 1e-3, axis=1)
    inverse[unknown, unknown] = np.inf
    return inverse


def _diagonals() -> FloatArray:
    """A basis (3, 3, 3) of the diagonal matrices."""
    return np.array([np.diag(row) for row in np.eye(3)])


def _symmetric() -> FloatArray:
    """A basis (6, 3, 3) of the symmetric matrices."""
    off = [np.zeros((3, 3)) for _ in range(3)]
    for matrix, (i, j) in zip(off, ((0, 1), (0, 2), (1, 2)), strict=True):
        matrix[i, j] = matrix[j, i] = 1.0
    return np.array([*_diagonals(), *off])
