"""Error and cost of integrators of the free rotation, measured against the exact solution.

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

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from attitude import quaternion, validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.referee.comparison import Comparison, Run
from attitude.spin import Spin
from attitude.splitting.ascending import ascending

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude.annotations import FloatArray, Real

    # step(moments, wxyz, omega, h) -> (wxyz, omega)
    Step = Callable[[FloatArray, FloatArray, FloatArray, float], tuple[ArrayLike, ArrayLike]]

# Names, in the order of the numbers of `referee.integrators`, and sources.
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
        s: for fixed steps.  Rounded so that a whole number fits between two epochs.
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
    if not isinstance(body, Body) or not isinstance(spin, Spin):
        raise AttitudeError(
            "compare takes integrators, a Body, a Spin and a span; given were "
            f"{type(body).__name__} and {type(spin).__name__}."
        )
    length = validation.positive(span, "span", unit="s")
    if not isinstance(epochs, (int, np.integer)) or isinstance(epochs, bool) or epochs < 1:
        raise AttitudeError(f"epochs is {epochs!r}; give a whole number from 1.")
    names, lengths = _sequence(integrators), _sequence(steps)
    if not len(names):
        raise AttitudeError("integrators is empty; give a name, a function, or several of them.")
    reference = _Reference(body, spin, length, epochs)
    runs = []
    for integrator in names:
        if isinstance(integrator, str) and integrator in _SCIPY:
            checked = [_tolerance(each) for each in _sequence(tolerances)]
            if not checked:
                raise AttitudeError("tolerances is empty; give those of the integrators of scipy.")
            runs += [reference.scipy(integrator, tolerance) for tolerance in checked]
            continue
        if not callable(integrator) and integrator not in _SHIPPED:
            listed = ", ".join(repr(name) for name in (*_SHIPPED, *_SCIPY))
            raise AttitudeError(
                f"integrators holds {integrator!r}; give a function step(moments, wxyz, omega, h) "
                f"or one of {listed}."
            )
        if not len(lengths):
            raise AttitudeError("steps is empty; give the steps (s) of the integrators.")
        for step in lengths:
            h = validation.positive(step, "steps", unit="s")
            runs.append(
                reference.function(integrator, h)
                if callable(integrator)
                else reference.shipped(integrator, h)
            )
    return Comparison(tuple(runs), length)


def _sequence(given: Any) -> Sequence[Any]:
    """The sequence given, or one of a single item."""
    return (given,) if isinstance(given, str) or np.ndim(given) == 0 else given


def _tolerance(given: Any) -> float:
    tolerance = validation.positive(given, "tolerances")
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
        from attitude.referee import integrators

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
        integrators.run(kind, moments, start, h, 1, out[:2])  # compiles
        cost = _best(lambda: integrators.run(kind, moments, start, h, every, out))
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

        def run() -> None:
            self._states(step, name, h, every, out)

        return self._run(name, h, out, _best(run, repeats=1), every * self.epochs)

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

        def run():
            return solve_ivp(
                slope,
                (0.0, self.span),
                self.start,
                method=name,
                rtol=tolerance,
                atol=1e-3 * tolerance,
                t_eval=self.times,
            )

        begin = time.perf_counter()
        solved = run()
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


def _pair(returned: Any, name: str) -> tuple[FloatArray, FloatArray]:
    """What a step returned, as two arrays."""
    try:
        q, w = (np.asarray(part, dtype=float) for part in returned)
    except (TypeError, ValueError):
        raise AttitudeError(
            f"{name} returned {returned!r}; it must return wxyz (4,) and omega (3,)."
        ) from None
    return q, w


def _refuse(name: str, seconds: float, h: float) -> NoReturn:
    raise AttitudeError(
        f"{name} is not finite, or a quaternion is zero, {seconds:.6g} s after the epoch at a "
        f"step of {h:.6g} s; give a shorter step."
    )


def _best(run: Callable[[], object], repeats: int = _REPEATS) -> float:
    """The least wall time of some runs, s."""
    costs = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        costs.append(time.perf_counter() - begin)
    return min(costs)
