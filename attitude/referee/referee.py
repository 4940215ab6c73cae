"""Run an integrator against the exact free rotation: how wrong is it, and what does it cost?

The first use that van Zon & Schofield (2006) name for the exact solution.

>>> from attitude import Body, Spin
>>> from attitude.referee import compare
>>> body = Body(moments=(10, 20, 26))
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
>>> result = compare(["rk4", "dlm"], body, spin, span=10.0, steps=(0.01, 0.005))
>>> [round(order, 1) for order in result.orders()["dlm"]]
[2.0]
"""

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from attitude import quaternion, validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.immutable import Immutable
from attitude.spin import Spin
from attitude.splitting.ascending import ascending

# Name, number in referee.integrators, what it is.
_SHIPPED = {
    "dlm": "Dullweber, Leimkuhler & McLachlan 1997: kinetic energy split by axes",
    "reich": "Reich 1994: a symmetric top and the rest",
    "celledoni-safstrom": "Celledoni & Safstrom 2006: exact rates, attitude by a Magnus series",
    "buss": "Buss 2000: augmented second order",
    "rk4": "classical Runge-Kutta on quaternion and rates",
    "exact-step": "the exact short step of this package",
}
# Those around the exact flow, which want the moments in ascending order.
_EXACT = ("celledoni-safstrom", "exact-step")
_SCIPY = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
_REPEATS = 3
# Below it scipy takes this one instead, and warns.
_LEAST_TOLERANCE = 100.0 * np.finfo(float).eps
_MOST_STEPS = 2.0**53


@dataclass(frozen=True, eq=False)
class Run(Immutable):
    """One integrator at one step or tolerance.

    Attributes
    ----------
    name : str
    step : float
        s; of an adaptive integrator its relative tolerance.
    attitude_error : float
        rad, the largest over the epochs compared; the sign of the quaternion left aside.
    rate_error : float
        Of the angular velocity, relative to its largest component.
    energy_drift, momentum_drift : float
        Largest relative change of the energy, and of the momentum as a vector in ICRF.
    seconds : float
        Cost of the whole run.
    seconds_per_step : float
        NaN for an adaptive integrator.
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
    """The runs of `compare`; print it for a table."""

    runs: tuple
    span: float

    def of(self, name):
        """The runs of one integrator, in the order of the steps given."""
        return tuple(run for run in self.runs if run.name == name)

    def orders(self):
        """Measured order from each step to the next: {name: (order, ...)}."""
        found = {}
        for name in dict.fromkeys(run.name for run in self.runs):
            runs = self.of(name)
            found[name] = tuple(
                float(np.log(a.attitude_error / b.attitude_error) / np.log(a.step / b.step))
                for a, b in pairwise(runs)
                if b.attitude_error > 0.0 and a.step != b.step
            )
        return found

    def table(self):
        """The runs as an astropy QTable."""
        from astropy.table import QTable

        names = Run.__dataclass_fields__
        return QTable({name: [getattr(run, name) for run in self.runs] for name in names})

    def __repr__(self):
        lines = [
            f"against the exact rotation over {self.span:g} s",
            f"{'integrator':20s} {'step or tol':>11s} {'attitude/rad':>12s} {'rates':>8s} "
            f"{'energy':>8s} {'momentum':>8s} {'cost/ms':>8s} {'ns/step':>8s}",
        ]
        for run in self.runs:
            each = "" if np.isnan(run.seconds_per_step) else f"{run.seconds_per_step * 1e9:8.0f}"
            lines.append(
                f"{run.name:20s} {run.step:11.3g} {run.attitude_error:12.1e} {run.rate_error:8.1e} "
                f"{run.energy_drift:8.1e} {run.momentum_drift:8.1e} {run.seconds * 1e3:8.2f} {each}"
            )
        return "\n".join(lines)


def compare(integrators, body, spin, span, *, steps=(), tolerances=(1e-12,), epochs=100):
    """Run integrators of the free rotation against the exact answer.

    Parameters
    ----------
    integrators : str, function, or sequence of them
        Names of those that are shipped ("dlm", "reich", "celledoni-safstrom", "buss", "rk4",
        "exact-step"), of scipy's ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA"), or
        functions ``step(moments, wxyz, omega, h) -> (wxyz, omega)`` of the principal moments (3,),
        the attitude (4,) from principal axes to ICRF, the angular velocity (3,) over the principal
        axes and the step in seconds.
    body : Body
    spin : Spin
    span : float
        s, or a Quantity.
    steps : sequence of float
        s: for those with fixed steps.  Rounded so that a whole number fits between two epochs.
    tolerances : sequence of float
        Relative tolerances for scipy's; the absolute one is a thousandth of it.
    epochs : int
        At how many equal epochs they are compared.

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
    The exact answer errs by 4e-15 rad, so that nothing below that is told apart.  Cost: the best
    of three runs, compilation left out.
    """
    if not isinstance(body, Body) or not isinstance(spin, Spin):
        raise AttitudeError("compare takes integrators, a Body, a Spin and a span.")
    span = validation.positive(span, "span", unit="s")
    integrators, steps, tolerances = map(_several, (integrators, steps, tolerances))
    if not isinstance(epochs, (int, np.integer)) or isinstance(epochs, bool) or epochs < 1:
        raise AttitudeError(f"epochs is {epochs!r}; give a whole number from 1.")
    if not len(integrators):
        raise AttitudeError("integrators is empty; give a name, a function, or several of them.")
    judge = _Judge(body, spin, span, epochs)
    runs = []
    for integrator in integrators:
        if isinstance(integrator, str) and integrator in _SCIPY:
            if not len(tolerances):
                raise AttitudeError("tolerances is empty; give those of scipy's integrators.")
            checked = [_tolerance(each) for each in tolerances]
            runs += [judge.scipy(integrator, tolerance) for tolerance in checked]
            continue
        if not callable(integrator) and integrator not in _SHIPPED:
            listed = ", ".join(repr(name) for name in (*_SHIPPED, *_SCIPY))
            raise AttitudeError(
                f"integrators holds {integrator!r}; give a function step(moments, wxyz, omega, h) "
                f"or one of {listed}."
            )
        if not len(steps):
            raise AttitudeError("steps is empty; give the steps (s) of the integrators.")
        for step in steps:
            step = validation.positive(step, "steps", unit="s")
            runs.append(
                judge.function(integrator, step)
                if callable(integrator)
                else judge.shipped(integrator, step)
            )
    return Comparison(tuple(runs), span)


def _several(given):
    """What was given, or a sequence of it where it is one."""
    return (given,) if isinstance(given, str) or np.ndim(given) == 0 else given


def _tolerance(given):
    tolerance = validation.positive(given, "tolerances")
    if tolerance < _LEAST_TOLERANCE:
        raise AttitudeError(
            f"tolerances holds {tolerance:g}; scipy's integrators take none below "
            f"{_LEAST_TOLERANCE:.2g}."
        )
    return tolerance


class _Judge:
    """The exact answer at some epochs, and how an integrator's differs from it."""

    def __init__(self, body, spin, span, epochs):
        self.moments = np.array(body.moments)
        if self.moments.min() <= 0.0:
            raise AttitudeError("the body is a rod; most integrators divide by its zero moment.")
        self.span, self.epochs = span, epochs
        self.times = np.linspace(0.0, span, epochs + 1)
        history = FreeRotation(body, spin).at(self.times)
        turn = body.principal_wxyz
        self.wxyz = quaternion.multiply(history.wxyz, turn)
        self.omega = history.angular_velocity @ body.principal_axes
        self.start = np.concatenate([self.wxyz[0], self.omega[0]])
        ratios = self.moments / self.moments.min()
        self.fastest = float(
            np.sqrt(np.sum(ratios * self.omega[0] ** 2))
        )  # rad/s, whatever follows
        moments, axes = ascending(body)
        wxyz = quaternion.multiply(history.wxyz[0], quaternion.from_matrix(axes))
        start = np.concatenate([wxyz, history.angular_velocity[0] @ axes])
        # moments, start, and the quaternion from the principal axes as given to these
        back = quaternion.multiply(quaternion.from_matrix(axes.T), turn)
        self.ordered = moments, start, back

    def shipped(self, name, step):
        from attitude.referee import integrators as rivals

        every, h = self._fitted(step)
        out = np.empty((self.epochs + 1, 7))
        kind = list(_SHIPPED).index(name)
        moments, start, back = self.moments, self.start, None
        if name in _EXACT:
            moments, start, back = self.ordered
            if not h * self.fastest <= _MOST_STEPS:
                raise AttitudeError(
                    f"steps holds {h:g}, in which the body turns by up to {h * self.fastest:.3g} "
                    "rad, more than can be counted; give a shorter step."
                )
        rivals.run(kind, moments, start, h, 1, out[:2])
        cost = _best(lambda: rivals.run(kind, moments, start, h, every, out))
        if back is not None:
            out[:, :4] = quaternion.multiply(out[:, :4], back)
            out[:, 4:] = quaternion.rotate(quaternion.conjugate(back), out[:, 4:])
        finite = np.all(np.isfinite(out), axis=-1)
        if not np.all(finite):
            _refuse(name, int(np.argmin(finite)) * every * h, h)
        return self._run(name, h, out, cost, every * self.epochs)

    def function(self, step, h):
        every, h = self._fitted(h)
        out = np.empty((self.epochs + 1, 7))
        name = getattr(step, "__name__", type(step).__name__)
        self._states(step, name, h, 1, out[:2])

        def run():
            self._states(step, name, h, every, out)

        return self._run(name, h, out, _best(run, repeats=1), every * self.epochs)

    def _states(self, step, name, h, every, out):
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

    def scipy(self, name, tolerance):
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
            raise AttitudeError(f"{name} at {tolerance:g} gave up: {solved.message}")
        return self._run(name, tolerance, solved.y.T, cost, 0)

    def _fitted(self, step):
        """A whole number of steps between two epochs, and their length."""
        apart = self.span / self.epochs
        if not apart <= _MOST_STEPS * step:
            raise AttitudeError(
                f"steps holds {step:g}, of which the span has more than can be counted; give a "
                "longer step."
            )
        every = max(1, round(apart / step))
        return every, apart / every

    def _run(self, name, step, out, cost, count):
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


def _pair(answer, name):
    """What a step returned, as two arrays."""
    try:
        q, w = (np.asarray(part, dtype=float) for part in answer)
    except (TypeError, ValueError):
        raise AttitudeError(
            f"{name} returned {answer!r}; it must return wxyz (4,) and omega (3,)."
        ) from None
    return q, w


def _refuse(name, seconds, h):
    raise AttitudeError(
        f"{name} is not finite, or a quaternion of no length, {seconds:.6g} s after the epoch at a "
        f"step of {h:.6g} s; give a shorter step."
    )


def _best(run, repeats=_REPEATS):
    costs = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        costs.append(time.perf_counter() - begin)
    return min(costs)
