"""`compare`: error and cost of integrators of the free rotation against the exact solution.

The first use that van Zon & Schofield (2006) name for the exact solution.

>>> from attitude import Body, Spin
>>> from attitude.referee import compare
>>> body = Body(moments=(10, 20, 26))
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
>>> result = compare(["rk4", "dlm"], body, spin, span=10.0, steps=(0.01, 0.005))
>>> [round(order, 1) for order in result.orders()["dlm"]]
[2.0]
"""

from __future__ import annotations

import math
import time
import timeit
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from attitude._compilation.decorators import entry_point, subroutine
from attitude._solver.kernel import product, turned_by
from attitude._solver.step import gains, increment, pieces, rates
from attitude._support import validation
from attitude._support.arrays import Immutable
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import refuse_others
from attitude.torques._schemes import ascending

if TYPE_CHECKING:
    from astropy.table import QTable
    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray, Real
    from attitude.motions._body import Body
    from attitude.motions._spin import Spin

    Step = Callable[[FloatArray, FloatArray, FloatArray, float], tuple[ArrayLike, ArrayLike]]


# ---- Results of `compare`: errors and cost of each run, measured orders, a table


@dataclass(frozen=True, eq=False)
class Run(Immutable):
    """The errors (rad, and relative) and wall time, s, of one integrator at one step, s.

    Of an adaptive integrator: at a relative tolerance; its seconds per step are NaN.
    """

    name: str
    step: float
    attitude_error: float
    rate_error: float
    energy_drift: float
    momentum_drift: float
    seconds: float
    seconds_per_step: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Immutable):
    """The runs of `compare`; print it for a table.

    span: s.
    """

    runs: tuple[Run, ...]
    span: float

    def of(self, name: str) -> tuple[Run, ...]:
        """The runs of one integrator, in the order of the steps given."""
        return tuple(run for run in self.runs if run.name == name)

    def orders(self) -> dict[str, tuple[float, ...]]:
        """Measured order of the attitude error from each step to the next: {name: (order, ...)}."""
        orders = {}
        for name in dict.fromkeys(run.name for run in self.runs):
            runs = self.of(name)
            orders[name] = tuple(
                float(np.log(a.attitude_error / b.attitude_error) / np.log(a.step / b.step))
                for a, b in pairwise(runs)
                if b.attitude_error > 0.0 and a.step != b.step
            )
        return orders

    def table(self) -> QTable:
        """The runs as an astropy QTable, one row a run, columns as the attributes of `Run`."""
        from astropy.table import QTable

        names = Run.__dataclass_fields__
        return QTable({name: [getattr(run, name) for run in self.runs] for name in names})

    def __repr__(self) -> str:
        lines = [
            f"against the exact rotation over {self.span:g} s",
            f"{'integrator':20s} {'step or tol':>11s} {'attitude/rad':>12s} {'rates':>8s} "
            f"{'energy':>8s} {'momentum':>8s} {'cost/ms':>8s} {'ns/step':>8s}",
        ]
        for run in self.runs:
            cost = "" if np.isnan(run.seconds_per_step) else f"{run.seconds_per_step * 1e9:8.0f}"
            lines.append(
                f"{run.name:20s} {run.step:11.3g} {run.attitude_error:12.1e} {run.rate_error:8.1e} "
                f"{run.energy_drift:8.1e} {run.momentum_drift:8.1e} {run.seconds * 1e3:8.2f} {cost}"
            )
        return "\n".join(lines)


# ---- One step of the free rotation by integrators of the literature
# Each takes three moments, four components of the attitude (body to inertial), three of the angular
# velocity over the principal axes, and a step, as tuples, and returns attitude and angular
# velocity.

DLM, REICH, CELLEDONI_SAFSTROM, BUSS, RK4, EXACT = range(6)


@subroutine
def one_step(kind, moments, q, w, h):
    """One step of length h by the integrator of a number: DLM to EXACT."""
    if kind == DLM:
        return dullweber_leimkuhler_mclachlan(moments, q, w, h)
    if kind == REICH:
        return reich(moments, q, w, h)
    if kind == CELLEDONI_SAFSTROM:
        return celledoni_safstrom(moments, q, w, h)
    if kind == BUSS:
        return buss(moments, q, w, h)
    if kind == RK4:
        return runge_kutta(moments, q, w, h)
    return exact(moments, q, w, h)


@entry_point
def run(kind, moments, start, h, every, out):
    """Fill out (T, 7) with the start and the states after each `every` steps.

    kind: DLM to EXACT; moments (3,); start (7,): wxyz and angular velocity; h s.
    """
    i = moments[0], moments[1], moments[2]
    q = start[0], start[1], start[2], start[3]
    w = start[4], start[5], start[6]
    for k in range(len(out)):
        if k > 0:
            for _ in range(every):
                q, w = one_step(kind, i, q, w, h)
        for j in range(4):
            out[k, j] = q[j]
        for j in range(3):
            out[k, 4 + j] = w[j]


@subroutine
def exact(moments, q, w, h):
    """The increments of `attitude._solver.step`, without compensated summation."""
    k = gains(moments)
    count = pieces(k, w, h)
    piece = h / count
    for _ in range(count):
        (s, x, y, z), d, n, _ = increment(moments, w, rates(k, w), piece)
        q = product(q, (1.0 + (s + n), x, y, z))
        w = w[0] + d[0], w[1] + d[1], w[2] + d[2]
    return q, w


@subroutine
def dullweber_leimkuhler_mclachlan(moments, q, w, h):
    """The kinetic energy split by axes: x, y, z, y, x.  J. Chem. Phys. 107, 5840 (1997)."""
    momentum = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    q, momentum = _about(0, momentum[0] / moments[0], q, momentum, 0.5 * h)
    q, momentum = _about(1, momentum[1] / moments[1], q, momentum, 0.5 * h)
    q, momentum = _about(2, momentum[2] / moments[2], q, momentum, h)
    q, momentum = _about(1, momentum[1] / moments[1], q, momentum, 0.5 * h)
    q, momentum = _about(0, momentum[0] / moments[0], q, momentum, 0.5 * h)
    return q, (momentum[0] / moments[0], momentum[1] / moments[1], momentum[2] / moments[2])


@subroutine
def reich(moments, q, w, h):
    """A symmetric top and the rest of the kinetic energy about x (1994, Physica D 76, 375)."""
    i1, i2, i3 = moments
    momentum = i1 * w[0], i2 * w[1], i3 * w[2]
    excess = 1.0 / i1 - 1.0 / i2
    q, momentum = _about(0, excess * momentum[0], q, momentum, 0.5 * h)
    # the top turns about L by |L|/I2 in space, and about its axis by the difference
    q, momentum = _turned(q, momentum, (momentum[0] / i2, momentum[1] / i2, momentum[2] / i2), h)
    q, momentum = _about(2, (1.0 / i3 - 1.0 / i2) * momentum[2], q, momentum, h)
    q, momentum = _about(0, excess * momentum[0], q, momentum, 0.5 * h)
    return q, (momentum[0] / i1, momentum[1] / i2, momentum[2] / i3)


@subroutine
def celledoni_safstrom(moments, q, w, h):
    """Exact Euler equations, attitude by a Magnus series, order 4.  J. Phys. A 39, 5463 (2006)."""
    one = _rates_after(moments, w, 0.21132486540518713 * h)
    two = _rates_after(moments, w, 0.7886751345948129 * h)
    half, more = 0.5 * h, h * h * 0.14433756729740643  # sqrt(3)/12
    turn = (
        half * (one[0] + two[0]) + more * (one[1] * two[2] - one[2] * two[1]),
        half * (one[1] + two[1]) + more * (one[2] * two[0] - one[0] * two[2]),
        half * (one[2] + two[2]) + more * (one[0] * two[1] - one[1] * two[0]),
    )
    return product(q, _exponential(turn, 1.0)), _rates_after(moments, w, h)


@subroutine
def buss(moments, q, w, h):
    """Augmented second-order method, momentum fixed in space.  J. Comput. Phys. 164, 377 (2000)."""
    momentum = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    space = turned_by(q, momentum)
    k1, k2, k3 = gains(moments)
    # w' and the commutator w' x w of the space-fixed axes, seen from the body
    a, b, c = k1 * w[1] * w[2], k2 * w[2] * w[0], k3 * w[0] * w[1]
    half, twelfth = 0.5 * h, h * h / 12.0
    turn = (
        h * (w[0] + half * a + twelfth * (b * w[2] - c * w[1])),
        h * (w[1] + half * b + twelfth * (c * w[0] - a * w[2])),
        h * (w[2] + half * c + twelfth * (a * w[1] - b * w[0])),
    )
    q = product(q, _exponential(turn, 1.0))
    size = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    q = q[0] * size, q[1] * size, q[2] * size, q[3] * size
    m = turned_by((q[0], -q[1], -q[2], -q[3]), space)
    return q, (m[0] / moments[0], m[1] / moments[1], m[2] / moments[2])


@subroutine
def runge_kutta(moments, q, w, h):
    """The classical fourth order on quaternion and rates, the quaternion normalised."""
    k = gains(moments)
    zero = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    y = q[0], q[1], q[2], q[3], w[0], w[1], w[2]
    a = _slope(k, _ahead(y, zero, 0.0))
    b = _slope(k, _ahead(y, a, 0.5 * h))
    c = _slope(k, _ahead(y, b, 0.5 * h))
    d = _slope(k, _ahead(y, c, h))
    y = _ahead(_ahead(y, a, h / 6.0), b, h / 3.0)
    y = _ahead(_ahead(y, c, h / 3.0), d, h / 6.0)
    size = 1.0 / math.sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3])
    return (y[0] * size, y[1] * size, y[2] * size, y[3] * size), (y[4], y[5], y[6])


@subroutine
def _ahead(y, slope, h):
    """y + h slope."""
    return (
        y[0] + h * slope[0],
        y[1] + h * slope[1],
        y[2] + h * slope[2],
        y[3] + h * slope[3],
        y[4] + h * slope[4],
        y[5] + h * slope[5],
        y[6] + h * slope[6],
    )


@subroutine
def _slope(k, y):
    """The rate of change of attitude and angular velocity."""
    q = product((y[0], y[1], y[2], y[3]), (0.0, 0.5 * y[4], 0.5 * y[5], 0.5 * y[6]))
    return (
        q[0],
        q[1],
        q[2],
        q[3],
        k[0] * y[5] * y[6],
        k[1] * y[6] * y[4],
        k[2] * y[4] * y[5],
    )


@subroutine
def _rates_after(moments, w, h):
    """The angular velocity after h, exactly."""
    _, w = exact(moments, (1.0, 0.0, 0.0, 0.0), w, h)
    return w


@subroutine
def _about(axis, rate, q, momentum, h):
    """As `_turned`, about one of the principal axes."""
    v = (
        rate if axis == 0 else 0.0,
        rate if axis == 1 else 0.0,
        rate if axis == 2 else 0.0,
    )
    return _turned(q, momentum, v, h)


@subroutine
def _turned(q, momentum, rate, h):
    """Attitude and momentum over body axes after a turn at a constant rate, the momentum fixed."""
    turn = _exponential(rate, h)
    back = turn[0], -turn[1], -turn[2], -turn[3]
    return product(q, turn), turned_by(back, momentum)


@subroutine
def _exponential(v, h):
    """The quaternion of a turn by h |v| about v."""
    size = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if size == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    sine = math.sin(0.5 * h * size) / size
    return math.cos(0.5 * h * size), sine * v[0], sine * v[1], sine * v[2]


# Names, in the order of the numbers of `one_step`, and sources.
_SHIPPED = {
    "dlm": "Dullweber, Leimkuhler & McLachlan 1997: kinetic energy split by axes",
    "reich": "Reich 1994: a symmetric top and the rest",
    "celledoni-safstrom": "Celledoni & Safstrom 2006: exact rates, attitude by a Magnus series",
    "buss": "Buss 2000: augmented second order",
    "rk4": "classical Runge-Kutta on quaternion and rates",
    "exact-step": "the exact short step of this package",
}
# Integrators around the exact flow, which take the moments in ascending order.
_EXACT = ("celledoni-safstrom", "exact-step")
_SCIPY = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
_REPEATS = 3
# scipy replaces smaller tolerances by this one, and warns.
_LEAST_TOLERANCE = 100.0 * np.finfo(float).eps
_MOST_STEPS = 2.0**53


def compare(
    integrators: str | Step | Sequence[str | Step],
    body: Body,
    spin: Spin,
    span: Real,
    *,
    steps: Real | Sequence[Real] | FloatArray = (),
    tolerances: float | Sequence[float] | FloatArray = (1e-12,),
    epochs: int = 100,
) -> Comparison:
    """Run integrators of the free rotation and compare them with the exact solution.

    Parameters
    ----------
    integrators : str, function, or sequence of them
        Names of integrators of this package ("dlm", "reich", "celledoni-safstrom", "buss", "rk4",
        "exact-step") and of scipy ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA"), or
        functions ``step(moments, wxyz, omega, h) -> (wxyz, omega)`` of the principal moments (3,),
        the attitude (4,) from principal axes to ICRF, the angular velocity (3,) over the principal
        axes and the step in seconds.
    body : Body
    spin : Spin
    span : float
        s, or a Quantity.
    steps : float or sequence of float
        s: for fixed steps.  Rounded so that a whole number fits between two epochs, of which there
        are fewer if a step is longer than the time between them.
    tolerances : float or sequence of float
        Relative tolerances for scipy; the absolute one is a thousandth of each.
    epochs : int
        Number of equally spaced epochs at which they are compared.

    Returns
    -------
    Comparison

    Raises
    ------
    AttitudeError
        For unknown names, functions that return other shapes, integrators that end in NaN, steps
        that are missing.

    Notes
    -----
    The exact solution errs by 4e-15 rad; smaller errors are not resolved.  Cost: the best of three
    runs without compilation, one run of functions and of scipy.
    """
    refuse_others(body, spin, "compare takes integrators, a Body, a Spin and a span")
    length = validation.positive(span, "span", unit="s")
    epochs = validation.count(epochs, "epochs")
    names = _sequence(integrators)
    lengths = [validation.positive(step, "steps", unit="s") for step in _sequence(steps)]
    if not len(names):
        raise AttitudeError("integrators is empty; give a name, a function, or several of them.")
    if lengths:
        epochs = max(1, min(epochs, round(length / max(lengths))))
    reference = _Reference(body, spin, length, epochs)
    runs = []
    for integrator in names:
        if isinstance(integrator, str) and integrator in _SCIPY:
            checked = [_tolerance(relative) for relative in _sequence(tolerances)]
            if not checked:
                raise AttitudeError("tolerances is empty; give those of the integrators of scipy.")
            runs += [reference.scipy(integrator, tolerance) for tolerance in checked]
            continue
        is_shipped = isinstance(integrator, str) and integrator in _SHIPPED
        if not callable(integrator) and not is_shipped:
            listed = ", ".join(repr(name) for name in (*_SHIPPED, *_SCIPY))
            raise AttitudeError(
                f"integrators holds {integrator!r}; give a function step(moments, wxyz, omega, h) "
                f"or one of {listed}."
            )
        if not lengths:
            raise AttitudeError("steps is empty; give the steps (s) of the integrators.")
        for h in lengths:
            runs.append(
                reference.function(integrator, h)
                if callable(integrator)
                else reference.shipped(integrator, h)
            )
    return Comparison(tuple(runs), length)


def _sequence(value: Any) -> Sequence[Any]:
    """The sequence given, or one of a single item."""
    if isinstance(value, (list, tuple)):
        return value
    return (value,) if isinstance(value, str) or np.ndim(value) == 0 else value


def _tolerance(value: Any) -> float:
    tolerance = validation.positive(value, "tolerances")
    if tolerance < _LEAST_TOLERANCE:
        raise AttitudeError(
            f"tolerances holds {tolerance:g}; give tolerances of {_LEAST_TOLERANCE:.2g} and more, "
            "which the integrators of scipy accept."
        )
    return tolerance


class _Reference:
    """The exact states at some epochs, and the errors of integrators there."""

    def __init__(self, body: Body, spin: Spin, span: float, epochs: int) -> None:
        self.moments = np.array(body.moments)
        if self.moments.min() <= 0.0:
            raise AttitudeError(
                "the body is a rod, by whose zero moment most integrators divide; give it a small "
                "moment there."
            )
        self.span, self.epochs = span, epochs
        self.times = np.linspace(0.0, span, epochs + 1)
        history = FreeRotation(body, spin).at(self.times)
        turn = body.principal_wxyz
        self.wxyz = quaternion.multiply(history.wxyz, turn)
        self.omega = history.angular_velocity @ body.principal_axes
        self.start = np.concatenate([self.wxyz[0], self.omega[0]])
        ratios = self.moments / self.moments.min()
        # rad/s, an upper bound at any later epoch
        self.fastest = float(np.sqrt(np.sum(ratios * self.omega[0] ** 2)))
        moments, axes = ascending(body)
        wxyz = quaternion.multiply(history.wxyz[0], quaternion.from_matrix(axes))
        start = np.concatenate([wxyz, history.angular_velocity[0] @ axes])
        # moments and start in ascending order, and the quaternion from the given axes to these
        back = quaternion.multiply(quaternion.from_matrix(axes.T), turn)
        self.ordered = moments, start, back

    def shipped(self, name: str, step: float) -> Run:
        """Run an integrator of this package at one step, s."""

        every, h = self._fitted(step)
        out = np.empty((self.epochs + 1, 7))
        kind = list(_SHIPPED).index(name)
        moments, start, back = self.moments, self.start, None
        if name in _EXACT:
            moments, start, back = self.ordered
            if not h * self.fastest <= _MOST_STEPS:
                raise AttitudeError(
                    f"steps holds {h:g}, in which the body turns by up to {h * self.fastest:.3g} "
                    "rad, more than 2^53; give a shorter step."
                )
        run(kind, moments, start, h, 1, out[:2])  # compiles
        cost = _best(lambda: run(kind, moments, start, h, every, out))
        if back is not None:
            out[:, :4] = quaternion.multiply(out[:, :4], back)
            out[:, 4:] = quaternion.rotate(quaternion.conjugate(back), out[:, 4:])
        finite = np.all(np.isfinite(out), axis=-1)
        if not np.all(finite):
            _refuse(name, int(np.argmin(finite)) * every * h, h)
        return self._run(name, h, out, cost, every * self.epochs)

    def function(self, step: Step, h: float) -> Run:
        """Run a function at one step h, s."""
        every, h = self._fitted(h)
        out = np.empty((self.epochs + 1, 7))
        name = getattr(step, "__name__", type(step).__name__)
        self._states(step, name, h, 1, out[:2])

        cost = _best(lambda: self._states(step, name, h, every, out), repeats=1)
        return self._run(name, h, out, cost, every * self.epochs)

    def _states(self, step: Step, name: str, h: float, every: int, out: FloatArray) -> None:
        q, w = self.start[:4].copy(), self.start[4:].copy()
        for k in range(len(out)):
            if k:
                for _ in range(every):
                    q, w = _pair(step(self.moments, q, w, h), name)
            if q.shape != (4,) or w.shape != (3,):
                raise AttitudeError(
                    f"{name} returned shapes {q.shape} and {w.shape}; it must return wxyz (4,) and "
                    "omega (3,)."
                )
            out[k, :4], out[k, 4:] = q, w
            if not (np.all(np.isfinite(out[k])) and np.any(q)):
                _refuse(name, k * every * h, h)

    def scipy(self, name: str, tolerance: float) -> Run:
        """Run an integrator of scipy at one relative tolerance."""
        from scipy.integrate import solve_ivp

        i1, i2, i3 = self.moments
        k1, k2, k3 = (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3

        def slope(t, y):
            a, b, c, d, x, y_, z = y
            return (
                0.5 * (-b * x - c * y_ - d * z),
                0.5 * (a * x + c * z - d * y_),
                0.5 * (a * y_ + d * x - b * z),
                0.5 * (a * z + b * y_ - c * x),
                k1 * y_ * z,
                k2 * z * x,
                k3 * x * y_,
            )

        settings = {"method": name, "rtol": tolerance, "atol": 1e-3 * tolerance}
        begin = time.perf_counter()
        solved = solve_ivp(slope, (0.0, self.span), self.start, t_eval=self.times, **settings)
        cost = time.perf_counter() - begin
        if not solved.success or solved.y.shape[1] != len(self.times):
            raise AttitudeError(
                f"{name} at a tolerance of {tolerance:g} gave up: {solved.message} Give another "
                "integrator or tolerance."
            )
        return self._run(name, tolerance, solved.y.T, cost, 0)

    def _fitted(self, step: float) -> tuple[int, float]:
        """The number of steps between two epochs, and their length."""
        apart = self.span / self.epochs
        if not apart <= _MOST_STEPS * step:
            raise AttitudeError(
                f"steps holds {step:g}, of which the span has more than 2^53 between two epochs; "
                "give a longer step."
            )
        every = max(1, round(apart / step))
        return every, apart / every

    def _run(self, name: str, step: float, out: FloatArray, cost: float, count: int) -> Run:
        """The errors of states (T, 7) and their cost; count steps, or 0 if they vary."""
        q = out[:, :4] / np.sqrt(np.sum(out[:, :4] ** 2, axis=-1))[:, None]
        off = quaternion.multiply(quaternion.conjugate(self.wxyz), q)
        angle = 2.0 * np.arctan2(np.sqrt(np.sum(off[:, 1:] ** 2, axis=-1)), np.abs(off[:, 0]))
        w = out[:, 4:]
        energy = np.sum(self.moments * w * w, axis=-1)
        momentum = quaternion.rotate(q, self.moments * w)
        size = np.sqrt(np.sum(momentum[0] ** 2))
        rates = np.max(np.abs(self.omega))
        return Run(
            name,
            float(step),
            float(np.max(angle)),
            float(np.max(np.abs(w - self.omega)) / rates) if rates else 0.0,
            float(np.max(np.abs(energy - energy[0])) / energy[0]) if energy[0] else 0.0,
            float(np.max(np.abs(momentum - momentum[0])) / size) if size else 0.0,
            cost,
            cost / count if count else np.nan,
        )


def _pair(returned, name):
    """What a step returned, as two arrays."""
    try:
        q, w = (np.asarray(array, dtype=float) for array in returned)
        return q, w
    except (TypeError, ValueError):
        raise AttitudeError(
            f"{name} returned {returned!r}; it must return wxyz (4,) and omega (3,)."
        ) from None


def _refuse(name: str, seconds: float, h: float) -> NoReturn:
    raise AttitudeError(
        f"{name} is not finite, or a quaternion is zero, {seconds:.6g} s after the epoch at a "
        f"step of {h:.6g} s; give a shorter step."
    )


def _best(run, repeats=_REPEATS):
    """The least wall time of some runs, s."""
    return min(timeit.repeat(run, number=1, repeat=repeats))
