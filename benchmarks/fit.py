"""What does a fit cost, and what did it cost with derivatives by differences?

    python benchmarks/fit.py

1000 attitudes over 48 turns of a tumbler, with errors of 1e-3 rad, inertia fitted.  Times are the
least of many repetitions of `fit`, in wall time and CPU time; ratios are of CPU times, which depend
less on what else the machine does.  "differences" is the method before derivatives in closed form,
CPU ms: central differences of the motion through scipy's least_squares, on stages of half as many
records more; measured in the same run, with the same parameters.  Both end at the same motion: the
last column is the greatest difference of their parameters in standard errors.
"""

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from attitude import (
    AttitudeTable,
    Body,
    FreeRotation,
    Spin,
    fit,
    fit_directions,
    fit_rates,
    propagate,
)
from attitude._compilation.choice import compiling
from attitude.frames import quaternion
from attitude.frames import representations as forms
from benchmarks.doc_tables import Table, markdown

EPOCH = "2026-01-01"
NOISE = 1e-3
T = np.linspace(0.0, 300.0, 1000)
TURN = forms.to_matrix(forms.from_axis_angle((1, 2, -1), 0.4))
STEP = 1e-5
MAKES = ("fit",)


def tables(quick):
    """The table of docs/fitting.md."""
    found = measured(10 if quick else 40)
    rows = [
        (name, f"{cpu:.1f}", *((f"{slow:.0f}", f"{slow / cpu:.0f}") if slow else ("", "")))
        for name, (_, cpu, slow, _) in found.items()
    ]
    costs = {name: each[1] * 1e6 for name, each in found.items()}
    head = "records", "closed form", "differences", "ratio"
    yield Table("fit", markdown(head, rows), costs=costs)


def main():
    print(f"{'1000 records, inertia fitted':<36} wall ms   CPU ms     differences    ratio   apart")
    for name, (wall, cpu, slow, apart) in measured(40).items():
        print(f"  {name:<34} {wall:8.2f} {cpu:8.2f}"
              + (f" {slow:15.1f} {slow / cpu:8.1f} {apart:7.1e}" if slow else ""))  # fmt: skip


def measured(rounds):
    """By name: wall and CPU ms of a fit, those by differences, and how far both are apart."""
    random, found_all = np.random.default_rng(4), {}
    for axes in ("principal", "free"):
        given = truth(axes)
        noise = forms.from_rotation_vector(random.normal(scale=NOISE, size=(len(T), 3)))
        wxyz = quaternion.multiply(given.at(T).wxyz, noise)
        rates = given.at(T).angular_velocity + random.normal(scale=NOISE, size=(len(T), 3))
        for with_rates in (False, True):
            table = AttitudeTable(EPOCH, T, wxyz, angular_velocity=rates if with_rates else None)
            found = fit(table, axes=axes)
            wall, cpu = best(lambda table=table, axes=axes: fit(table, axes=axes), rounds)
            before = Differences(table, axes)
            x = before.fitted()
            slow = best(before.fitted, max(1, rounds // 13))[1]
            apart = np.abs(before.apart(x, found)) / np.sqrt(np.diag(found.covariance))
            label = f"attitudes{' and rates' if with_rates else ''}"
            label += ", free axes" if axes == "free" else ""
            found_all[label] = wall, cpu, slow, np.max(apart)
    given = truth("principal")
    rates = given.at(T).angular_velocity + random.normal(scale=NOISE, size=(len(T), 3))
    stars = np.resize([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]], (len(T), 3))
    twice = np.repeat(T[::2], 2)
    pairs = given.at(twice).inertial_to_body(stars)
    pairs = pairs + random.normal(scale=NOISE, size=pairs.shape)
    single = given.at(T).inertial_to_body(stars)
    single = single + random.normal(scale=NOISE, size=single.shape)
    for name, call in {
        "angular velocities": lambda: fit_rates(T, rates, epoch=EPOCH),
        "directions, two at an epoch": lambda: fit_directions(twice, pairs, stars, epoch=EPOCH),
        "directions, one at an epoch": lambda: fit_directions(T, single, stars, epoch=EPOCH),
    }.items():
        found_all[name] = *best(call, rounds // 2), None, None
    return found_all


def truth(axes):
    """A short-axis tumbler of 6 s, its principal axes along the body axes or not."""
    body = Body(moments=(10, 20, 26))
    if axes == "free":
        body = Body(tensor=TURN @ np.diag([10.0, 20.0, 26.0]) @ TURN.T)
    spin = Spin(epoch=EPOCH, wxyz=(1, -2, 3, 0.5), angular_velocity=(0.1, 0.15, 1.0))
    return FreeRotation(body, spin)


def best(call, repetitions):
    """Least wall time and CPU time of a call, ms."""
    wall, cpu = [], []
    for _ in range(repetitions):
        started = time.perf_counter(), time.process_time()
        call()
        wall.append(time.perf_counter() - started[0])
        cpu.append(time.process_time() - started[1])
    return min(wall) * 1e3, min(cpu) * 1e3


class Differences:
    """The fit by central differences: turn, rates and logarithms of the second moments."""

    def __init__(self, table, axes):
        self.axes, self.wxyz = axes, np.asarray(table.wxyz)
        given = table.angular_velocity
        self.rates = None if given is None else np.asarray(given)
        if self.rates is None:
            step = quaternion.multiply(quaternion.conjugate(self.wxyz[:-1]), self.wxyz[1:])
            turn = forms.to_rotation_vector(step)
            middle = quaternion.multiply(self.wxyz[:-1], forms.from_rotation_vector(0.5 * turn))
            self.omega = turn / np.diff(T)[:, None]
            self.middle = middle
        else:
            self.middle, self.omega = self.wxyz, self.rates
        self.speed = float(np.mean(np.linalg.norm(self.omega, axis=1)))
        squares = 1.0 if self.rates is None else np.mean(np.sum(self.rates**2, axis=1))
        self.rate_weight = 1.0 / np.sqrt(squares)
        self.count = 8 if axes == "principal" else 11

    def fitted(self):
        x = self.guess()
        count = max(6, int(np.searchsorted(T, 2.0 * np.pi / self.speed)))
        while count < len(T):
            x = self.improved(x, count)
            count = max(count + 1, int(1.5 * count))
        return self.improved(x, len(T))

    def guess(self):
        from attitude.fitting._attitudes import inertia_of_attitudes
        from attitude.fitting._model import Model

        x = np.zeros(self.count)
        x[3:6] = np.mean(self.omega[: 1 if self.rates is not None else 2], axis=0)
        tensor = inertia_of_attitudes(self.middle, self.omega, self.axes, robust=False)
        x[6:] = Model(None, self.axes).shape_of(tensor)
        return x

    def improved(self, x, count):
        from scipy.optimize import least_squares

        scale = np.ones(self.count)
        scale[3:6] = self.speed
        limit = np.full(self.count, np.inf)
        limit[6:] = 18.0

        def jacobian(y):
            steps = np.eye(self.count) * STEP
            values = self.residuals((y + np.concatenate([steps, -steps])) * scale, count)
            return ((values[: self.count] - values[self.count :]) / (2.0 * STEP)).T

        found = least_squares(
            lambda y: self.residuals((y * scale)[None], count)[0],
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

    def residuals(self, points, count):
        moments, axes = self.bodies(points)
        start = quaternion.multiply(self.wxyz[0], forms.from_rotation_vector(points[:, :3]))
        to_body = quaternion.from_matrix(axes)
        wxyz, omega = propagate(
            moments,
            quaternion.multiply(start, to_body),
            np.einsum("bij,bi->bj", axes, points[:, 3:6]),
            T[:count],
            angular_velocity=True,
        )
        wxyz = quaternion.multiply(wxyz, quaternion.conjugate(to_body)[:, None])
        turn = quaternion.multiply(quaternion.conjugate(wxyz), self.wxyz[:count])
        parts = [forms.to_rotation_vector(turn)]
        if self.rates is not None:
            rates = np.einsum("bij,bnj->bni", axes, omega)
            parts.append((self.rates[:count] - rates) * self.rate_weight)
        return np.concatenate(parts, axis=1).reshape(len(points), -1)

    def bodies(self, points):
        tensors = np.array([self.tensor(point[6:]) for point in points])
        if self.axes == "principal":
            return np.diagonal(tensors, axis1=1, axis2=2), np.tile(np.eye(3), (len(points), 1, 1))
        moments, axes = np.linalg.eigh(tensors)
        axes[np.linalg.det(axes) < 0.0, :, 2] *= -1.0
        return moments, axes

    def tensor(self, shape):
        logarithm = np.diag([shape[0], shape[1], -shape[0] - shape[1]])
        for value, (i, j) in zip(shape[2:], ((0, 1), (0, 2), (1, 2)), strict=False):
            logarithm[i, j] = logarithm[j, i] = value
        values, vectors = np.linalg.eigh(logarithm)
        second = (vectors * np.exp(values - values.max())) @ vectors.T
        tensor = np.trace(second) * np.eye(3) - second
        return 0.5 * (tensor + tensor.T) / np.trace(tensor)

    def apart(self, x, fit):
        """Parameters less those of a Fit."""
        from attitude.fitting._model import Model

        start = quaternion.multiply(self.wxyz[0], forms.from_rotation_vector(x[:3]))
        turn = quaternion.multiply(quaternion.conjugate(fit.motion.spin.wxyz), start)
        shape = Model(None, self.axes).shape_of(fit.motion.body.tensor)
        rates = x[3:6] - fit.motion.spin.angular_velocity
        return np.concatenate([forms.to_rotation_vector(turn), rates, x[6:] - shape])


if __name__ == "__main__":
    with compiling():
        main()
