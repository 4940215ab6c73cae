"""How a torqued motion is integrated: the system, and its states after fixed or varying steps."""

import numpy as np

from attitude import pairs, quaternion
from attitude.errors import AttitudeError
from attitude.splitting.ascending import ascending

# The largest turn between two torques: most torques vary with twice the attitude, and what varies
# with a body turning by more than this between samples is seen as something else.
LARGEST_TURN = 0.5 * np.pi
# Fixed steps: a state is kept after each so many, at first.  When so many are kept (15 MB), every
# other one is given up, so that memory has a bound and an epoch costs a few hundred steps at most
# for each hundred million taken.
_EVERY, _MOST = 32, 1 << 17
# So many steps, or kicks of epochs asked for, are prepared at a time.
_STEPS, _ROWS = 2048, 1 << 18
# s; what would need others is no motion of a body.
_LEAST_STEP, _LONGEST_STEP = 1e-70, 1e40
# What a double counts without a gap.
_MOST_STEPS = 2.0**53
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
        self.moments, self.axes = ascending(body)
        self.turn = quaternion.from_matrix(self.axes)
        self.start = np.zeros(14)
        self.start[:4] = quaternion.multiply(spin.wxyz_icrf, self.turn)
        self.start[:4] /= np.sqrt(self.start[:4] @ self.start[:4])
        self.start[4:7] = spin.angular_velocity @ self.axes
        self.setup = self._compiled_setup()
        self.kicks = len(chosen.kicks)

    def _compiled_setup(self):
        slopes = [0] * len(self.torques)
        if np.any(self.scheme.gradients != 0.0):
            slopes = [torque.slope_address() for torque in self.torques]
            self._refuse_without_slope(slopes)
        kept = [np.append(np.asarray(t.parameters(self.body), float), 0.0) for t in self.torques]
        self._parameters = kept  # the compiled loops hold no more than their addresses
        rows, column = [], 0
        for torque, parameters, slope in zip(self.torques, kept, slopes, strict=True):
            where = parameters.ctypes.data
            rows.append([torque.address(), torque.kind, where, column, slope])
            column += torque.columns
        turn = np.concatenate([self.turn, self.axes.reshape(9)])
        inverses = 1.0 / np.sort(self.body.moments)
        numbers = np.concatenate([self.moments, inverses, turn, [LARGEST_TURN]])
        chosen = self.scheme
        coefficients = np.array([chosen.kicks, np.append(chosen.flights, 0.0), chosen.gradients])
        return numbers, coefficients, np.array(rows, dtype=np.int64)

    def _refuse_without_slope(self, slopes):
        names = [
            type(torque).__name__
            for torque, slope in zip(self.torques, slopes, strict=True)
            if not slope
        ]
        if names:
            raise AttitudeError(
                f'the scheme "{self.scheme.name}" needs the force gradient of every torque, which '
                f"{' and '.join(names)} does not tell; GravityGradient, ConstantTorque and a "
                'CustomTorque with a slope do. Take "suzuki" or "blanes-moan", which need none.'
            )

    def check_step(self, step):
        """Raise the AttitudeError for a step that cannot resolve the rotation at the epoch."""
        if not step <= _LONGEST_STEP:
            raise AttitudeError(
                f"step is {step:.3g} s; give one of at most {_LONGEST_STEP:.0e} s, which is longer "
                "than the age of anything."
            )
        rate = float(np.sqrt(self.start[4:7] @ self.start[4:7]))
        rate *= float(np.max(np.abs(self.scheme.flights)))
        if step * rate > LARGEST_TURN:
            self._refuse(step, rate, 0.0)

    def _refuse(self, step, rate, t):
        """`rate`: of the turn between two torques over the length of the step, rad/s."""
        at = "at the epoch" if t == 0.0 else f"{t:.9g} s after the epoch"
        could = LARGEST_TURN / rate
        if not could > _LEAST_STEP:
            raise AttitudeError(
                f"{at} the body turns faster than any step could resolve ({rate:.3g} rad/s); check "
                "the torque, or ask for earlier epochs only."
            )
        raise AttitudeError(
            f"a step of {abs(step):.6g} s cannot resolve the motion: {at} the body turns by "
            f"{abs(step) * rate:.3g} rad between two torques; a step below {could:.3g} s could "
            f"(at most {LARGEST_TURN:.2f} rad), and {0.1 * could:.2g} s is a good first choice."
        )

    def check_span(self, seconds, step):
        """Raise the AttitudeError for an epoch so many steps away that they cannot be counted."""
        if not abs(seconds) <= _MOST_STEPS * abs(step):
            raise AttitudeError(
                f"an epoch lies {seconds:.3g} s from that of the spin, more than 2^53 steps of "
                f"{abs(step):.3g} s; give a nearer epoch, or a longer step."
            )

    def sampled(self, times):
        """What the torques are given at epochs (2, ...), pairs: (..., columns), at least one."""
        shape = times.shape[1:]
        hi, lo = np.ascontiguousarray(times).reshape(2, -1)
        parts = [torque.sample(self.epoch, hi, lo) for torque in self.torques if torque.columns]
        parts = parts or [np.zeros((hi.size, 1))]
        joined = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.ascontiguousarray(joined).reshape(*shape, joined.shape[1])

    def kick_times(self, starts, h):
        """Epochs (2, ..., n + 1) of the kicks of steps that start at (2, ...), of lengths h.

        In pairs: after 1e8 steps a double of seconds leaves the place on an orbit uncertain by
        1e-10 rad, which would show as a random walk of what is conserved.
        """
        share = np.concatenate([[0.0], np.cumsum(self.scheme.flights)])
        share[-1] = 1.0
        hi, lo = starts[0][..., None], starts[1][..., None]
        return np.array(pairs.add((hi, lo), np.asarray(h)[..., None] * share))

    def march(self, state, start, h, steps, every):
        """Take steps of one length from a state, in place; the kept states (steps // every, 14).

        start: a pair of seconds, or how many such steps lead there from the epoch.
        """
        from attitude.solution.march import march

        if np.ndim(start):
            starts = np.array(pairs.add(pairs.product(np.arange(steps), h), *start))
        else:
            starts = np.array(pairs.product(start + np.arange(steps), h))
        times = self.kick_times(starts, h)
        rows = np.concatenate([times[:, :, :-1].reshape(2, -1), times[:, -1:, -1]], axis=1)
        kept = np.empty((steps // every, 14))
        given = self.sampled(rows)
        self.judge(march(*self.setup, state, starts[0, 0], h, steps, given, kept, every), h)
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

    def acceleration(self, seconds, low, found):
        """Rates of change (..., 3) of the angular velocity over the body axes."""
        from attitude.solution.march import accelerations

        flat = found.reshape(-1, 7)
        known = np.all(np.isfinite(flat), axis=-1)
        states = np.zeros((int(known.sum()), 14))
        states[:, :4] = quaternion.multiply(flat[known, :4], self.turn)
        states[:, 4:7] = flat[known, 4:] @ self.axes
        t = np.zeros((2, len(states)))
        t[0] = seconds.reshape(-1)[known]
        t[1] = 0.0 if low is None else np.asarray(low).reshape(-1)[known]
        out = np.full((len(flat), 3), np.nan)
        some = np.empty((len(states), 3))
        numbers, _, models = self.setup
        self.judge(accelerations(numbers, models, states, t[0], self.sampled(t), some), 0.0)
        out[known] = some @ self.axes.T
        return out.reshape((*found.shape[:-1], 3))

    def revisit(self, states, starts, h, place, steps, parts):
        """States (T, 14 -> 7) some whole steps and a part of one after kept ones, at (2, S)."""
        from attitude.solution.march import revisit

        # steps of length h from the starts, as many as the farthest epoch wants
        hi, lo = pairs.product(np.arange(max(int(steps.max()), 1)), h)
        whole = np.array(pairs.add((starts[0][:, None], starts[1][:, None]), hi, lo))
        times = self.kick_times(whole, h)
        rows = np.concatenate(
            [times[:, :, :, :-1].reshape(2, len(states), -1), times[:, :, -1:, -1]], axis=2
        )
        given = self.sampled(rows if steps.any() else rows[:, :, :1])
        last = np.array(pairs.add(starts[:, place], *pairs.product(steps, h)))
        within = self.sampled(self.kick_times(last, parts))
        out = np.empty((len(place), 7))
        start = np.ascontiguousarray(starts[0])
        answer = revisit(*self.setup, states, start, h, place, steps, parts, given, within, out)
        self.judge(answer, h)
        return out


class FixedSteps:
    """States after every so many steps in one direction of time."""

    def __init__(self, system, h):
        self.system, self.h, self.every = system, h, _EVERY
        self.kept = system.start[None].copy()  # grows by doubling
        self.count = 1  # of kept states, that of the epoch included

    @property
    def reached(self):
        return (self.count - 1) * self.every * self.h

    def states(self, seconds, low):
        """(T, 7) at seconds + low of this direction."""
        self.system.check_span(np.max(np.abs(seconds + low)), self.h)
        number, parts = self._steps(seconds, low)
        order = np.lexsort((np.abs(parts), number))
        self._extend(int(number[order[-1]]))
        segment = number[order] // self.every
        rank = np.cumsum(np.diff(segment, prepend=segment[0]) != 0)
        # As many segments and epochs at a time as may be prepared together.
        most = max(1, _ROWS // (self.every * self.system.kicks))
        out = np.empty((len(seconds), 7))
        begin = 0
        while begin < len(order):
            end = int(np.searchsorted(rank, rank[begin] + most))
            end = min(end, begin + _ROWS // self.system.kicks)
            here = order[begin:end]
            out[here] = self._some(segment[begin:end], number[here], parts[here])
            begin = end
        return out

    def _steps(self, seconds, low):
        """How many whole steps lead to epochs, and seconds of a last one."""
        number = np.floor((seconds + low) / self.h)
        hi, lo = pairs.product(number, self.h)
        parts = (seconds - hi) + (low - lo)
        # a quotient that was rounded up to the next whole number
        early = parts * np.sign(self.h) < 0.0
        number[early] -= 1.0
        parts[early] += self.h
        return np.maximum(number, 0.0).astype(np.int64), parts

    def _some(self, segment, number, parts):
        used, place = np.unique(segment, return_inverse=True)
        starts = np.array(pairs.product(used * self.every, self.h))
        steps = number - segment * self.every
        return self.system.revisit(self.kept[used], starts, self.h, place, steps, parts)

    def _extend(self, number):
        """Keep states up to a number of steps."""
        while (self.count - 1) < number // self.every:
            if self.count > _MOST:
                self.kept[: self.count // 2 + 1] = self.kept[: self.count : 2]
                self.count, self.every = self.count // 2 + 1, 2 * self.every
                continue
            run = min(
                max(1, _STEPS // self.every),
                number // self.every - (self.count - 1),
                _MOST + 1 - self.count,
            )
            if self.count + run > len(self.kept):
                larger = np.empty((max(2 * len(self.kept), self.count + run), 14))
                larger[: self.count] = self.kept[: self.count]
                self.kept = larger
            state = self.kept[self.count - 1].copy()
            start = (self.count - 1) * self.every
            made = self.system.march(state, start, self.h, run * self.every, self.every)
            self.kept[self.count : self.count + run] = made
            self.count += run


class VaryingSteps:
    """States after every step, each as long as the error estimate allows."""

    def __init__(self, system, sign, tolerance):
        self.system, self.sign, self.tolerance = system, sign, tolerance
        self.times, self.kept = [0.0], [system.start.copy()]
        self.h = None
        # A step that ends beyond the epoch asked for must not leave a path that ends there.
        spans = [torque.span(system.epoch) for torque in system.torques]
        self.last = min(last if sign > 0.0 else -first for first, last in spans)

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
        starts = np.stack([times[used], np.zeros(len(used))])
        out = np.empty((len(seconds), 7))
        out[order] = self.system.revisit(kept, starts, 0.0, place, steps, parts)
        return out

    def _extend(self, last):
        self.system.check_span(last, self._longest(self.kept[-1]))
        while abs(self.times[-1]) < abs(last):
            self._step(last)

    def _step(self, asked):
        """One step; its half steps, which are kept, tell how wrong it is."""
        system, t, state = self.system, self.times[-1], self.kept[-1]
        order = system.scheme.order
        h = self.h if self.h is not None else self._first()
        for _ in range(_MOST_REFUSALS):
            # Beyond the last epoch of a path, it is the path that says so.
            room = max(self.last, abs(asked)) - abs(t)
            h = self.sign * min(abs(h), self._longest(state), room)
            end = t + h
            h = end - t
            whole, half = state.copy(), state.copy()
            system.march(whole, (t, 0.0), h, 1, 1)
            system.march(half, (t, 0.0), 0.5 * h, 2, 2)
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
