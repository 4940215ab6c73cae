"""How a torqued motion is integrated: the system, and its states after fixed or varying steps."""

import numpy as np

from attitude import quaternion
from attitude.errors import AttitudeError

# The largest turn between two torques: most torques vary with twice the attitude, and what varies
# with a body turning by more than this between samples is seen as something else.
LARGEST_TURN = 0.5 * np.pi
# Fixed steps: a state is kept after each so many; so many kept states are made at a time.
_EVERY, _RUN = 32, 64
# Adaptive steps: fraction of the step that the error estimate allows, and how it may change.
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 4.0
_MOST_REFUSALS = 60


class System:
    """What is integrated: body, torques and scheme, as the compiled loops want them."""

    def __init__(self, body, spin, torques, chosen):
        if np.min(body.moments) <= 0.0:
            raise AttitudeError(
                "the body is a rod, with a moment of zero, about whose axis any torque would turn "
                "it infinitely fast; give it a small moment there."
            )
        self.epoch, self.torques, self.scheme = spin.epoch, torques, chosen
        self.body = body
        order = np.argsort(body.moments, kind="stable")
        axes = body.principal_axes[:, order]
        self.axes = axes if np.linalg.det(axes) > 0.0 else -axes
        self.turn = quaternion.from_matrix(self.axes)
        self.moments = body.moments[order]
        self.start = np.zeros(14)
        self.start[:4] = quaternion.multiply(spin.wxyz_icrf, self.turn)
        self.start[:4] /= np.sqrt(self.start[:4] @ self.start[:4])
        self.start[4:7] = spin.angular_velocity @ self.axes
        self.setup = self._compiled_setup()

    def _compiled_setup(self):
        with_gradient = np.any(self.scheme.gradients != 0.0)
        gradient = self.torques[0].gradient_address() if with_gradient else 0
        if with_gradient and (len(self.torques) > 1 or gradient == 0):
            names = ", ".join(type(torque).__name__ for torque in self.torques)
            raise AttitudeError(
                f'the scheme "{self.scheme.name}" needs the force gradient of one torque, given '
                f'were {names}; take "suzuki" or "blanes-moan", or a GravityGradient alone.'
            )
        kept = [np.append(np.asarray(t.parameters(self.body), float), 0.0) for t in self.torques]
        self._parameters = kept  # the compiled loops hold no more than their addresses
        rows, column = [], 0
        for torque, parameters in zip(self.torques, kept, strict=True):
            rows.append([torque.address(), torque.kind, parameters.ctypes.data, column])
            column += torque.columns
        rows.append([int(gradient), 0, 0, 0])
        turn = np.concatenate([self.turn, self.axes.reshape(9)])
        numbers = np.concatenate([self.moments, 1.0 / self.moments, turn, [LARGEST_TURN]])
        chosen = self.scheme
        coefficients = np.array([chosen.kicks, np.append(chosen.flights, 0.0), chosen.gradients])
        return numbers, coefficients, np.array(rows, dtype=np.int64)

    def check_step(self, step):
        """Raise the AttitudeError for a step that cannot resolve the rotation at the epoch."""
        rate = float(np.sqrt(self.start[4:7] @ self.start[4:7]))
        rate *= float(np.max(np.abs(self.scheme.flights)))
        if step * rate > LARGEST_TURN:
            self._refuse(step, rate, 0.0)

    def _refuse(self, step, rate, t):
        """`rate`: of the turn between two torques over the length of the step, rad/s."""
        at = "at the epoch" if t == 0.0 else f"{t:.9g} s after the epoch"
        could = LARGEST_TURN / rate
        raise AttitudeError(
            f"a step of {abs(step):.6g} s cannot resolve the motion: {at} the body turns by "
            f"{abs(step) * rate:.3g} rad between two torques; a step below {could:.3g} s could "
            f"(at most {LARGEST_TURN:.2f} rad), and {0.1 * could:.2g} s is a good first choice."
        )

    def sampled(self, seconds):
        """What the torques are given at some epochs (...): (..., columns), at least one."""
        flat = np.ascontiguousarray(seconds).reshape(-1)
        parts = [torque.sample(self.epoch, flat) for torque in self.torques if torque.columns]
        parts = parts or [np.zeros((flat.size, 1))]
        joined = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.ascontiguousarray(joined).reshape(*np.shape(seconds), joined.shape[1])

    def kick_times(self, starts, h):
        """Epochs (..., n + 1) of the kicks of steps that start somewhere, of lengths h."""
        share = np.concatenate([[0.0], np.cumsum(self.scheme.flights)])
        share[-1] = 1.0
        return np.asarray(starts)[..., None] + np.asarray(h)[..., None] * share

    def march(self, state, start, h, steps, every):
        """Take steps of one length from a state, in place; the kept states (steps // every, 14)."""
        from attitude.solution.march import march

        times = self.kick_times(start + h * np.arange(steps), h)
        rows = np.append(times[:, :-1].reshape(-1), times[-1, -1])
        kept = np.empty((steps // every, 14))
        given = self.sampled(rows)
        self.judge(march(*self.setup, state, start, h, steps, given, kept, every), h)
        return kept

    def judge(self, answer, h):
        """Raise the AttitudeError for what a compiled loop says went wrong, if anything did."""
        fault, when, rate = answer
        if fault == 0:
            return
        for torque in self.torques:
            torque.explain()
        if fault == 2:
            self._refuse(h, rate, when)
        raise AttitudeError(
            f"the torque is not finite {when:.9g} s after the epoch; a torque must return finite "
            "numbers at all attitudes and epochs. Check it, or ask for earlier epochs only."
        )

    def over_body_axes(self, states):
        """(N, 7) of the integration as unit quaternions of the body axes, and rates over them."""
        out = np.empty(states.shape)
        q = quaternion.multiply(states[:, :4], quaternion.conjugate(self.turn))
        out[:, :4] = q / np.sqrt(np.sum(q * q, axis=-1))[:, None]
        out[:, 4:] = states[:, 4:] @ self.axes.T
        return out

    def acceleration(self, seconds, found):
        """Rates of change (..., 3) of the angular velocity over the body axes."""
        from attitude.solution.march import accelerations

        flat = found.reshape(-1, 7)
        known = np.all(np.isfinite(flat), axis=-1)
        states = np.zeros((int(known.sum()), 14))
        states[:, :4] = quaternion.multiply(flat[known, :4], self.turn)
        states[:, 4:7] = flat[known, 4:] @ self.axes
        t = seconds.reshape(-1)[known]
        out = np.full((len(flat), 3), np.nan)
        some = np.empty((len(t), 3))
        numbers, _, models = self.setup
        self.judge(accelerations(numbers, models, states, t, self.sampled(t), some), 0.0)
        out[known] = some @ self.axes.T
        return out.reshape((*found.shape[:-1], 3))

    def revisit(self, states, starts, h, place, steps, parts):
        """States (T, 14 -> 7) some whole steps and a part of one after kept states."""
        from attitude.solution.march import revisit

        most = int(steps.max()) if len(steps) else 0
        whole = starts[:, None] + h * np.arange(max(most, 1))
        times = self.kick_times(whole, h)
        rows = np.concatenate(
            [times[:, :, :-1].reshape(len(starts), -1), times[:, -1:, -1]], axis=1
        )
        given = self.sampled(rows if most else rows[:, :1])
        within = self.sampled(self.kick_times(starts[place] + h * steps, parts))
        out = np.empty((len(place), 7))
        answer = revisit(*self.setup, states, starts, h, place, steps, parts, given, within, out)
        self.judge(answer, h)
        return out


class FixedSteps:
    """States after every so many steps in one direction of time."""

    def __init__(self, system, h):
        self.system, self.h = system, h
        self.kept = [system.start[None].copy()]
        self.count = 1  # of kept states, that of the epoch included

    @property
    def reached(self):
        return (self.count - 1) * _EVERY * self.h

    def states(self, seconds, low):
        """(T, 7) at seconds + low of this direction."""
        out = np.empty((len(seconds), 7))
        order = np.argsort(np.abs(seconds + low), kind="stable")
        for begin in range(0, len(order), 4096):
            some = order[begin : begin + 4096]
            out[some] = self._some(seconds[some], low[some])
        return out

    def _some(self, seconds, low):
        """Epochs ordered by distance from the start."""
        number = np.floor((seconds + low) / self.h)
        hi, lo = _product(number, self.h)
        parts = (seconds - hi) + (low - lo)
        # a quotient that was rounded up to the next whole number
        early = parts * np.sign(self.h) < 0.0
        number[early] -= 1.0
        parts[early] += self.h
        number = np.maximum(number, 0.0).astype(np.int64)
        segment = number // _EVERY
        self._extend(int(segment[-1]))
        used, place = np.unique(segment, return_inverse=True)
        states = self._kept_states(used)
        starts = used * _EVERY * self.h
        steps = number - segment * _EVERY
        return self.system.revisit(states, starts, self.h, place, steps, parts)

    def _kept_states(self, numbers):
        if len(self.kept) > 1:
            self.kept = [np.concatenate(self.kept)]
        return self.kept[0][numbers]

    def _extend(self, last):
        while self.count <= last:
            run = min(_RUN, last + 1 - self.count)
            state = self.kept[-1][-1].copy()
            begin = (self.count - 1) * _EVERY * self.h
            self.kept.append(self.system.march(state, begin, self.h, run * _EVERY, _EVERY))
            self.count += run


class VaryingSteps:
    """States after every step, each as long as the error estimate allows."""

    def __init__(self, system, sign, tolerance):
        self.system, self.sign, self.tolerance = system, sign, tolerance
        self.times, self.kept = [0.0], [system.start.copy()]
        self.h = None

    @property
    def reached(self):
        return self.times[-1]

    def states(self, seconds, low):
        order = np.argsort(np.abs(seconds + low), kind="stable")
        seconds, low = seconds[order], low[order]
        self._extend(float(seconds[-1] + low[-1]))
        times = np.array(self.times)
        place = np.searchsorted(np.abs(times), np.abs(seconds + low), side="right") - 1
        parts = (seconds - times[place]) + low
        used, place = np.unique(place, return_inverse=True)
        kept = np.array([self.kept[k] for k in used])
        steps = np.zeros(len(place), dtype=np.int64)
        out = np.empty((len(seconds), 7))
        out[order] = self.system.revisit(kept, times[used], 0.0, place, steps, parts)
        return out

    def _extend(self, last):
        while abs(self.times[-1]) <= abs(last):
            self._step()

    def _step(self):
        """One step; its half steps, which are kept, tell how wrong it is."""
        system, t, state = self.system, self.times[-1], self.kept[-1]
        order = system.scheme.order
        h = self.h if self.h is not None else self._first()
        for _ in range(_MOST_REFUSALS):
            h = self.sign * min(abs(h), self._longest(state))
            end = t + h
            h = end - t
            whole, half = state.copy(), state.copy()
            system.march(whole, t, h, 1, 1)
            system.march(half, t, 0.5 * h, 2, 2)
            error = _difference(whole, half) / (2.0**order - 1.0)
            ratio = (self.tolerance / max(error, 1e-300)) ** (1.0 / (order + 1.0))
            factor = min(max(_SAFETY * ratio, _SHRINK), _GROW)
            if error <= self.tolerance or h == 0.0:
                self.times.append(end)
                self.kept.append(half)
                self.h = h * factor
                return
            h *= factor
        raise AttitudeError(
            f"no step {t:.9g} s after the epoch is short enough for a tolerance of "
            f"{self.tolerance:g}; the torque is not smooth there, or the tolerance is below "
            "rounding. Give a larger tolerance, or a fixed step."
        )

    def _longest(self, state):
        rate = np.sqrt(state[4:7] @ state[4:7])
        longest = np.max(np.abs(self.system.scheme.flights))
        return np.inf if rate == 0.0 else 0.5 * LARGEST_TURN / (rate * longest)

    def _first(self):
        longest = self._longest(self.kept[-1])
        return 0.1 * longest if np.isfinite(longest) else 1.0


def _difference(one, two):
    """How far two states are apart: rad, and the relative change of the angular velocity."""
    turned = 2.0 * np.max(np.abs((one[:4] - two[:4]) + (one[7:11] - two[7:11])))
    rate = np.max(np.abs(two[4:7]))
    change = np.max(np.abs((one[4:7] - two[4:7]) + (one[11:14] - two[11:14])))
    return max(turned, change / rate if rate > 0.0 else 0.0)


def _product(a, b):
    """a b in two doubles (Dekker 1971), |a| and |b| below 1e299."""
    p = a * b
    (a, a_low), (b, b_low) = _halves(a), _halves(b)
    return p, ((a * b - p) + a * b_low + a_low * b) + a_low * b_low


def _halves(x):
    """x as two numbers of 26 bits each."""
    big = 134217729.0 * x
    high = big - (big - x)
    return high, x - high
