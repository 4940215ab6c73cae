"""Body, torques and scheme, packed for the compiled loops; derivatives of a torqued motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.callbacks import raising_callback_errors
from attitude._compilation.decorators import EntryPoint
from attitude._solver import march_layout as layout
from attitude._solver.march_layout import OMEGA, OMEGA_LOW, STATE_ENTRIES, WXYZ
from attitude._solver.sensitivities import Derivatives
from attitude._solver.states import Evaluation, Results, States
from attitude._support import pairs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._differentiable import changed
from attitude.torques._schemes import ascending
from attitude.torques._torque import GravityGradient

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import BoolArray, FloatArray, IntArray
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.motions._spin import Spin
    from attitude.torques._schemes import Scheme
    from attitude.torques._torque import InertiaHistory, Torque
    from attitude.torques._torqued import StepMesh


# The largest turn between two torques: most torques vary with twice the attitude, and are aliased
# where the body turns by more than this between samples.
LARGEST_TURN: float = 0.5 * np.pi
# s; no motion of a body needs shorter steps, nor longer ones.
_LEAST_STEP = 1e-70
_LONGEST_STEP = 1e40
# Up to here, a double holds every whole number.
_MOST_STEPS = 2.0**53
_NONE = np.zeros((3, 3))


class System:
    """Body, torques and scheme, the arrays of `march_layout`, and the compiled loops.

    `start` (14,) is the state at the epoch over the principal axes; `columns` counts the numbers
    that torques sample at each kick; `origin` is the instant from which seconds of functions count.
    """

    def __init__(
        self,
        body: Body,
        spin: Spin,
        torques: tuple[Torque, ...],
        chosen: Scheme,
        origin: Instant | None = None,
    ) -> None:
        if np.min(body.moments) <= 0.0:
            raise AttitudeError(
                "the body is a rod, with a moment of zero, about whose axis any torque would turn "
                "it infinitely fast; give it a small moment there."
            )
        self.epoch, self.torques, self.scheme = spin.epoch, torques, chosen
        self.origin = spin.epoch if origin is None else origin
        epoch_pair = self.epoch.seconds, self.epoch.low
        self.shift = pairs.add(epoch_pair, -self.origin.seconds, -self.origin.low)
        self.body, self.spin, self.inertia = body, spin, _inertia_of(torques)
        if self.inertia is not None and self.shift != (0.0, 0.0):
            raise AttitudeError(
                "an InertiaHistory counts seconds from the epoch of the spin; leave out origin=."
            )
        self.moments, self.axes = ascending(body)
        self.turn = quaternion.from_matrix(self.axes)
        self.start = np.zeros(STATE_ENTRIES)
        self.start[WXYZ] = quaternion.multiply(spin.wxyz_icrf, self.turn)
        self.start[WXYZ] /= np.sqrt(self.start[WXYZ] @ self.start[WXYZ])
        self.start[OMEGA] = spin.angular_velocity @ self.axes
        self.setup = self._numbers(), self._coefficients(), self._models()
        self.kicks = len(chosen.kicks)
        self.columns = sum(torque.columns for torque in torques)
        self.slips = any(torque.kind == layout.SLIP for torque in torques)

    def under(self, torques: tuple[Torque, ...]) -> System:
        """The same system under other torques."""
        return System(self.body, self.spin, torques, self.scheme, self.origin)

    # ---- Packing

    def _numbers(self) -> FloatArray:
        numbers = np.empty(layout.BODY_ENTRIES)
        by_rate = sum(
            (torque.by_rate() for torque in self.torques if torque.kind == layout.LINEAR), _NONE
        )
        damping = self.axes.T @ by_rate @ self.axes / np.sort(self.body.moments)[:, None]
        for first, values in (
            (layout.MOMENTS, self.moments),
            (layout.INVERSES, 1.0 / np.sort(self.body.moments)),
            (layout.TURN, self.turn),
            (layout.MATRIX, self.axes.reshape(9)),
            (layout.LARGEST_TURN, np.array([LARGEST_TURN])),
            (layout.DAMPING, damping.reshape(9)),
            (layout.DAMPING_SIZE, np.array([np.max(np.sum(np.abs(damping), axis=1))])),
        ):
            numbers[first : first + len(values)] = values
        return numbers

    def _coefficients(self) -> FloatArray:
        coefficients = np.zeros((layout.SCHEME_ROWS, len(self.scheme.kicks)))
        coefficients[layout.KICKS] = self.scheme.kicks
        coefficients[layout.FLIGHTS, :-1] = self.scheme.flights
        coefficients[layout.GRADIENTS] = self.scheme.gradients
        return coefficients

    def _models(self) -> IntArray:
        slopes = [0] * len(self.torques)
        if np.any(self.scheme.gradients != 0.0):
            slopes = [torque.slope_address() for torque in self.torques]
            self._refuse_without_slope(slopes)
        # The compiled loops hold addresses only: this list keeps the arrays alive.  A function of
        # the user has no parameters but the last one, which it adds to its time.
        self._parameters = [
            np.append(np.asarray(torque.parameters(self.body), float), self.shift[0])
            for torque in self.torques
        ]
        models = np.empty((len(self.torques), layout.MODEL_ENTRIES), dtype=np.int64)
        column = 0
        for row, torque, parameters, slope in zip(
            models, self.torques, self._parameters, slopes, strict=True
        ):
            row[layout.FUNCTION] = torque.address()
            row[layout.KIND] = torque.kind
            row[layout.PARAMETERS] = parameters.ctypes.data
            row[layout.COLUMN] = column
            row[layout.SLOPE] = slope
            column += torque.columns
        return models

    def _refuse_without_slope(self, slopes: list[int]) -> None:
        lacking = [torque for torque, slope in zip(self.torques, slopes, strict=True) if not slope]
        if names := [type(torque).__name__ for torque in lacking]:
            raise AttitudeError(
                f'the scheme "{self.scheme.name}" needs the force gradient of every torque, which '
                f"{' and '.join(names)} does not define; GravityGradient, ConstantTorque and a "
                'CustomTorque with slope= do. Take "suzuki" or "blanes-moan", which need none.'
            )

    # ---- Limits

    def check_step(self, step: float) -> None:
        """Raise the AttitudeError for a step that cannot resolve the rotation at the epoch."""
        if not step <= _LONGEST_STEP:
            raise AttitudeError(
                f"step is {step:.3g} s; give one of at most {_LONGEST_STEP:.0e} s, which is longer "
                "than the age of anything."
            )
        rate = float(np.sqrt(self.start[OMEGA] @ self.start[OMEGA]))
        rate *= float(np.max(np.abs(self.scheme.flights)))
        if step * rate > LARGEST_TURN:
            self._refuse_step(step, rate, 0.0)

    def _refuse_step(self, step: float, rate: float, t: float) -> None:
        """`rate`: of the turn between two torques over the length of the step, rad/s."""
        at = "at the epoch" if t == 0.0 else f"{t:.9g} s after the epoch"
        longest = LARGEST_TURN / rate
        if not longest > _LEAST_STEP:
            raise AttitudeError(
                f"{at} the body turns faster than any step could resolve ({rate:.3g} rad/s); check "
                "the torque, or give earlier epochs only."
            )
        raise AttitudeError(
            f"a step of {abs(step):.6g} s cannot resolve the motion: {at} the body turns by "
            f"{abs(step) * rate:.3g} rad between two torques; a step below {longest:.3g} s could "
            f"(at most {LARGEST_TURN:.2f} rad), and {0.1 * longest:.2g} s is a good first choice."
        )

    def check_span(self, seconds: float, step: float) -> None:
        """Raise the AttitudeError for an epoch more steps away than can be counted."""
        if not abs(seconds) <= _MOST_STEPS * abs(step):
            raise AttitudeError(
                f"an epoch lies {seconds:.3g} s from that of the spin, more than 2^53 steps of "
                f"{abs(step):.3g} s; give a nearer epoch, or a longer step."
            )

    def run(self, loop: Callable[..., Any], h: float, *arguments: Any) -> None:
        """Run a loop; raise what a torque raised, or the AttitudeError for its fault."""
        by_users = any(torque.is_users for torque in self.torques)
        if by_users and isinstance(loop, EntryPoint):
            loop = loop.compiled
        with raising_callback_errors():
            fault, t, rate = loop(*arguments)
        if fault == layout.FINE:
            return
        t += self.shift[0]
        if fault == layout.TOO_ROUGH:
            raise AttitudeError(
                f"no step {t:.9g} s after the epoch is short enough for the tolerance; the torque "
                "is not smooth there, or the tolerance is below rounding. Give a larger tolerance, "
                "or a fixed step."
            )
        if fault == layout.TOO_LONG:
            self._refuse_step(h, rate, t)
        raise AttitudeError(
            f"the torque is not finite {t:.9g} s after the epoch; a torque must return finite "
            "numbers at all attitudes and epochs. Check it, or give earlier epochs only."
        )

    # ---- Calls

    def sampled(self, times: FloatArray) -> FloatArray:
        """Samples of all torques at epochs (2, ...), pairs: (..., columns), one column or more."""
        shape = times.shape[1:]
        hi, lo = np.ascontiguousarray(times).reshape(2, -1)
        if self.shift != (0.0, 0.0):
            hi, lo = pairs.add((hi, lo), *self.shift)
        parts = [torque.sample(self.origin, hi, lo) for torque in self.torques if torque.columns]
        parts = parts or [np.zeros((hi.size, 1))]
        joined = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.ascontiguousarray(joined).reshape(*shape, joined.shape[1])

    def kick_times(self, starts: FloatArray, h: float | FloatArray) -> FloatArray:
        """Epochs (2, ..., n + 1) of the kicks of steps from (2, ...), of lengths h, in pairs.

        After 1e8 steps a double of seconds leaves the place on an orbit uncertain by 1e-10 rad.
        """
        share = np.concatenate([[0.0], np.cumsum(self.scheme.flights)])
        share[-1] = 1.0
        hi, lo = starts[0][..., None], starts[1][..., None]
        return np.array(pairs.add((hi, lo), np.asarray(h)[..., None] * share))

    def march(self, state: FloatArray, start: int, h: float, steps: int, every: int) -> FloatArray:
        """Take steps from state number `start`, in place; the kept states (steps // every, 14)."""
        from attitude._solver.march import march

        starts = np.array(pairs.product(start + np.arange(float(steps)), h))
        kept = np.empty((steps // every, STATE_ENTRIES))
        samples = self.sampled(_successive(self.kick_times(starts, h)))
        self.run(march, h, *self.setup, state, float(start), h, steps, samples, kept, every)
        return kept

    def march_members(
        self,
        setup: tuple[FloatArray, FloatArray, IntArray],
        states: FloatArray,
        start: int,
        h: float,
        number: IntArray,
        parts: FloatArray,
        samples: tuple[FloatArray, FloatArray],
        *,
        label: Callable[[int], str],
    ) -> FloatArray:
        """Take the steps of samples from states (N, 14), in place; states (N, T, 7)."""
        from attitude._solver.march import march_members

        # the last kick of a step is the first of the next
        steps = (len(samples[0]) - 1) // (self.kicks - 1)
        out = np.empty((len(states), len(number), 7))

        member = 0

        def loop(*arguments: Any) -> tuple[int, float, float]:
            nonlocal member
            fault, t, rate, member = march_members(*arguments)
            return fault, t, rate

        try:
            self.run(loop, h, *setup, states, float(start), h, steps, number, parts, *samples, out)
        except AttitudeError as err:
            raise AttitudeError(f"{label(member)}: {err}") from err
        return out

    def samples_of(
        self, start: int, h: float, steps: int, number: IntArray, parts: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Samples at the kicks of steps, and of parts of steps, as `march_members` takes them."""
        starts = np.array(pairs.product(start + np.arange(float(max(steps, 1))), h))
        rows = _successive(self.kick_times(starts, h))
        if not steps:
            rows = rows[:, :1]
        begin = np.array(pairs.product((start + number).astype(np.float64), h))
        return self.sampled(rows), self.sampled(self.kick_times(begin, parts))

    def revisit(
        self,
        states: FloatArray,
        numbers: FloatArray,
        h: float,
        place: IntArray,
        steps: IntArray,
        parts: FloatArray,
    ) -> FloatArray:
        """States (T, 7) at epochs after kept ones (S, 14)."""
        from attitude._solver.march import revisit

        starts = np.array(pairs.product(numbers, h))
        # Steps of length h from the starts, as many as the farthest epoch needs.
        hi, lo = pairs.product(np.arange(max(float(steps.max()), 1.0)), h)
        whole = np.array(pairs.add((starts[0][:, None], starts[1][:, None]), hi, lo))
        rows = _successive(self.kick_times(whole, h))
        samples = self.sampled(rows if steps.any() else rows[:, :, :1])
        begin = starts[0, place], starts[1, place]
        last = np.array(pairs.add(begin, *pairs.product(steps.astype(np.float64), h)))
        within = self.sampled(self.kick_times(last, parts))
        out = np.empty((len(place), 7))
        self.run(
            revisit,
            h,
            *self.setup,
            states,
            numbers,
            h,
            place,
            steps,
            parts,
            samples,
            within,
            out,
        )
        return out

    def acceleration(self, seconds: FloatArray, low: FloatArray, motion: FloatArray) -> FloatArray:
        """Rates (N, 3) of the angular velocity, rad/s2, body axes, of states (N, 7)."""
        from attitude._solver.march import accelerations

        if self.inertia is not None:
            raise AttitudeError(
                "angular accelerations are not defined with an InertiaHistory; difference the "
                "angular velocities."
            )
        rates = self._at_states(accelerations, seconds, low, motion)
        if self.slips:
            slip = self.turning_rates(seconds, low, motion) - motion[:, 4:]
            torque = np.cross(motion[:, 4:] @ self.body.tensor, slip)
            rates += np.linalg.solve(self.body.tensor, torque.T).T
        return rates

    def turning_rates(self, seconds: FloatArray, low: FloatArray, motion: FloatArray) -> FloatArray:
        """Rates (N, 3) at which attitudes turn, rad/s, body axes, of states (N, 7) of a motion.

        With an `InertiaHistory` the angular velocities of the motion have its slip.
        """
        from attitude._solver.march import slips

        if not self.slips or self.inertia is not None:
            return motion[:, 4:]
        return motion[:, 4:] + self._at_states(slips, seconds, low, motion)

    def _at_states(
        self, loop: Callable[..., Any], seconds: FloatArray, low: FloatArray, motion: FloatArray
    ) -> FloatArray:
        """Vectors (N, 3) over the body axes that a loop of `march` fills at states (N, 7)."""
        known: BoolArray = np.all(np.isfinite(motion), axis=-1)
        states = np.zeros((int(known.sum()), STATE_ENTRIES))
        states[:, WXYZ] = quaternion.multiply(motion[known, :4], self.turn)
        states[:, OMEGA] = motion[known, 4:] @ self.axes
        t = np.stack([seconds[known], low[known]])
        out = np.full((len(motion), 3), np.nan)
        some = np.empty((len(states), 3))
        numbers, _, models = self.setup
        self.run(loop, 0.0, numbers, models, states, t[0], self.sampled(t), some)
        out[known] = some @ self.axes.T
        return out

    def over_body_axes(self, states: FloatArray) -> FloatArray:
        """(N, 7) of the integration as unit quaternions of the body axes, and rates over them."""
        out = np.empty(states.shape)
        q = quaternion.multiply(states[:, :4], quaternion.conjugate(self.turn))
        out[:, :4] = q / np.sqrt(np.sum(q * q, axis=-1))[:, None]
        out[:, 4:] = states[:, 4:] @ self.axes.T
        return out

    def turning(self, seconds: FloatArray, low: FloatArray, rates: FloatArray) -> FloatArray:
        """I(t)^-1 I w (N, 3), the angular velocities, of rates w (N, 3) over the body axes."""
        if self.inertia is None or not len(rates):
            return rates
        tensors = self.body.tensor + self.inertia.tensors(seconds + low)
        momentum = (rates @ self.body.tensor)[..., None]
        return np.asarray(np.linalg.solve(tensors, momentum)[..., 0], dtype=np.float64)


def _successive(times):
    """Epochs (2, ..., steps n + 1) of the kicks (2, ..., steps, n + 1) of successive steps.

    The last kick of a step is the first of the next.
    """
    before = times[..., :-1].reshape(*times.shape[:-2], -1)
    return np.concatenate([before, times[..., -1:, -1]], axis=-1)


def _inertia_of(torques: tuple[Torque, ...]) -> InertiaHistory | None:
    """The `InertiaHistory` among torques, which may stand beside torques of the attitude only."""
    changing = [torque for torque in torques if torque.changes_inertia]
    if not changing:
        return None
    beside = [
        type(torque).__name__
        for torque in torques
        if torque is not changing[0]
        and (torque.kind != layout.BY_ATTITUDE or isinstance(torque, GravityGradient))
    ]
    if beside:
        raise AttitudeError(
            f"{' and '.join(beside)} cannot act beside an InertiaHistory, because it takes the "
            "angular velocity or the tensor of the body, which change; give torques that depend on "
            "the attitude alone (a CustomTorque with depends_on_rate=False)."
        )
    return changing[0]  # type: ignore[return-value]


# ---- Derivatives of a torqued motion by its state and its moments: the chain of those of its steps
# A step is a product of kicks and free motions.  The derivative of a free motion is in closed form
# (`attitude._solver.sensitivities`); that of a kick, whose torque may be any function, is taken by
# differences of fourth order of the change that the compiled kick makes.  Their product is the
# derivative of the scheme with its steps, not of an integration beside it.

# Steps whose derivatives are in memory together: 4 MB.
_BLOCK = 4096
# Step of the attitude, rad: differences of fourth order with it err by 1e-12 of a torque that is
# smooth.
_TURN = 1e-3
# The same as a share of the rate and of the moments.
_SHARE = 1e-3
NODES = np.array([1.0, -1.0, 2.0, -2.0])
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12.0
# One-sided, for moments: at a flat body they cannot change to both sides.
_SIDED = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0
# Moments (rows) by the second moments of mass (columns), which are independent and not negative.
_BY_MASS = np.ones((3, 3)) - np.eye(3)


class TorquedSensitivity(Derivatives):
    """The derivatives of one torqued motion by the state, the moments and parameters of torques.

    ``meshes(side, until)`` gives the `StepMesh` after (0) or before (1) the epoch,
    ``states(seconds, low)`` states (N, 7); each parameter is a step and the systems at it times
    `NODES`.
    """

    def __init__(
        self,
        system: System,
        body: Body,
        spin: Spin,
        meshes: Callable[[int, float], StepMesh],
        states: Callable[[FloatArray, FloatArray], FloatArray],
        parameters: Sequence[tuple[float, Sequence[System]]] = (),
    ) -> None:
        self._system, self._body, self._meshes, self._states = system, body, meshes, states
        self._others = self._with_other_moments(spin)
        self._parameters = tuple(parameters)
        self._width = 9 + len(self._parameters)
        kinds = {torque.kind for torque in system.torques}
        self._by_rate, self._slips = bool({layout.BY_RATE, layout.LINEAR} & kinds), system.slips

    def at(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Changes of attitude (S, 3, 9 + P), ICRF axes, and of the angular velocity, body axes."""
        t, low_parts = pairs.Seconds(seconds, low).flat
        derivatives = np.full((t.size, self._width, self._width), np.nan)
        with np.errstate(invalid="ignore"):
            sides = t + low_parts >= 0.0, t + low_parts < 0.0
        for side, on_side in enumerate(sides):
            if np.any(on_side):
                derivatives[on_side] = self._on_side(side, t[on_side], low_parts[on_side])
        shape = (*np.shape(seconds), 3, self._width)
        if rates and self._system.inertia is not None:
            self._with_turning(t, low_parts, derivatives)
        omega = derivatives[:, 3:6].reshape(shape) if rates else None
        return derivatives[:, :3].reshape(shape), omega

    def by_elements(
        self, seconds: FloatArray, low: FloatArray | None, rates: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """Refused: the elements of a torqued motion change with time."""
        raise AttitudeError(
            'by is "elements"; a motion under torques has no constant elements. Give by="state".'
        )

    def _with_turning(self, t: FloatArray, low: FloatArray, maps: FloatArray) -> None:
        """Turn changes of I^-1 L in maps (T, 9 + P, 9 + P) into those of I(t)^-1 L."""
        system, body = self._system, self._body
        known = np.isfinite(t + low)
        assert system.inertia is not None
        rates = self._states(t[known], low[known])[:, 4:]
        gained = rates - system.turning(t[known], low[known], rates)
        tensors = body.tensor + system.inertia.tensors(t[known] + low[known])
        changes = body.tensor @ maps[known, 3:6]
        # by the moments, of which I and I(t) have the same change
        axes = body.principal_axes
        changes[..., 6:9] += axes * (gained @ axes)[:, None, :]
        maps[known, 3:6] = np.linalg.solve(tensors, changes)

    def _on_side(self, side: int, t: FloatArray, low: FloatArray) -> FloatArray:
        """The maps (T, 9 + P, 9 + P) from the epoch to t + low, of one direction."""
        order = np.argsort(np.abs(t + low), kind="stable")
        t, low = t[order], low[order]
        mesh = self._meshes(side, float(t[-1] + low[-1]))
        place, parts = mesh.place(t, low)
        derivatives = np.empty((len(t), self._width, self._width))
        whole = np.eye(self._width)
        for first in range(0, mesh.count, _BLOCK):
            end = min(first + _BLOCK, mesh.count)
            starts = mesh.times[:, first:end]
            states = self._states(*starts)
            begin, stop = np.searchsorted(place, [first, end])
            before = np.empty((end - first, self._width, self._width))
            steps = self._maps(states, starts, mesh.lengths(first, end), mesh.halves)
            for k, step in enumerate(steps):
                before[k] = whole
                whole = step @ whole
            in_block = place[begin:stop] - first
            last = self._maps(states[in_block], starts[:, in_block], parts[begin:stop], mesh.halves)
            derivatives[order[begin:stop]] = last @ before[in_block]
        return derivatives

    def _maps(self, states, starts, lengths, halves):
        """The maps (N, 9 + P, 9 + P) of steps from states (N, 7) over the body axes."""
        whole = np.broadcast_to(np.eye(self._width), (len(states), self._width, self._width))
        length, wxyz, omega = lengths / halves, states[:, :4], states[:, 4:]
        for half in range(halves):
            begin = np.stack([starts[0] + half * length, starts[1]])
            times = self._system.kick_times(begin, length)
            wxyz, omega, step = self._step(wxyz, omega, times, length)
            whole = step @ whole
        return whole

    def _step(self, wxyz, omega, times, h):
        """States after steps of lengths h (N,), and the maps (N, 9 + P, 9 + P)."""
        scheme = self._system.scheme
        whole = np.broadcast_to(np.eye(self._width), (len(h), self._width, self._width))
        for j, (share, gradient) in enumerate(zip(scheme.kicks, scheme.gradients, strict=True)):
            if share != 0.0 or gradient != 0.0:
                wxyz, omega, change = self._kick(
                    wxyz, omega, times=times[..., j], h=share * h, cubed=gradient * h**3
                )
                whole = change @ whole
            if j < len(scheme.flights) and scheme.flights[j] != 0.0:
                wxyz, omega, change = self._flight(wxyz, omega, scheme.flights[j] * h)
                whole = change @ whole
        return wxyz, omega, whole

    def _flight(self, wxyz, omega, t):
        """States after free motions for t (N,) seconds, and the maps (N, 9 + P, 9 + P)."""
        count, body = len(t), self._body
        rates, wxyz = omega @ body.principal_axes, np.ascontiguousarray(wxyz)
        moments, principal = body.moments_as_pairs[None], body.principal_wxyz[None]
        after, turning = np.empty((count, 4, 1)), np.empty((count, 3, 1))
        attitude, rate = np.empty((count, 3, 9, 1)), np.empty((count, 3, 9, 1))
        states = States(moments, principal, rates, None, wxyz)
        results = Results(after, turning, attitude, rate)
        Evaluation(states).grid(pairs.Seconds(t[:, None]), results)
        changes = np.zeros((count, self._width, self._width))
        changes[:, :3, :9], changes[:, 3:6, :9] = attitude[..., 0], rate[..., 0]
        changes[:, 6:, 6:] = np.eye(self._width - 6)
        return after[..., 0], turning[..., 0], changes

    def _kick(self, wxyz, omega, times, h, cubed):
        """States after torques for h (N,) seconds, and the maps (N, 9 + P, 9 + P)."""
        count = len(h)
        kick = times, h, cubed, self._system.sampled(times)
        after, gained = _kicked(self._system, wxyz, omega, kick)
        maps = np.broadcast_to(np.eye(self._width), (count, self._width, self._width)).copy()
        many = times.repeat(4, axis=1), *(np.repeat(array, 4, axis=0) for array in kick[1:])
        pace = _SHARE * np.sqrt(np.sum(omega**2 + gained**2, axis=1))
        pace = np.where(pace > 0.0, pace, 1.0)
        for j in range(6 if self._by_rate or self._slips else 3):
            q, w = wxyz.repeat(4, axis=0), omega.repeat(4, axis=0)
            if j < 3:
                size = np.full(count, _TURN)
                turns = forms.from_rotation_vector(_TURN * NODES[:, None] * np.eye(3)[j])
                q = quaternion.multiply(np.tile(turns, (count, 1)), q)
            else:
                size = pace
                w[:, j - 3] += (NODES * pace[:, None]).reshape(-1)
            ends, gains = _kicked(self._system, q, w, many)
            if self._slips:
                turned = _turns(ends, after.repeat(4, axis=0)).reshape(count, 4, 3)
                maps[:, :3, j] = np.einsum("nks,k->ns", turned, _WEIGHTS) / size[:, None]
            # a difference of the changes: the state itself would hide a weak torque by rounding
            changes = gains.reshape(count, 4, 3) - gained[:, None]
            maps[:, 3:6, j] += np.einsum("nks,k->ns", changes, _WEIGHTS) / size[:, None]

        def by_parameter(weights, others):
            """The change (N, 6) of the end of the kick, by systems with other parameters."""
            total = np.zeros((count, 6))
            for weight, other in zip(weights, others, strict=True):
                end, gain = _kicked(other, wxyz, omega, kick)
                if self._slips:
                    total[:, :3] += weight * _turns(end, after)
                total[:, 3:] += weight * (gain - gained)
            return total

        longest = _SHARE * float(np.max(self._body.moments))
        by_mass = [by_parameter(_SIDED[1:] / longest, others) for others in self._others]
        maps[:, :6, 6:9] = np.stack(by_mass, axis=-1) @ np.linalg.inv(_BY_MASS)
        for j, (step, systems) in enumerate(self._parameters, start=9):
            maps[:, :6, j] += by_parameter(_WEIGHTS / step, systems)
        return after, omega + gained, maps

    def _with_other_moments(self, spin: Spin) -> list[list[System]]:
        """Systems whose three second moments of mass are larger by four steps each."""
        size = _SHARE * float(np.max(self._body.moments))
        system = self._system

        def larger(column, k):
            change = np.concatenate([np.zeros(6), k * size * column])
            body, _ = changed(self._body, spin, change)
            return System(body, spin, system.torques, system.scheme, system.origin)

        return [[larger(column, k) for k in range(1, 5)] for column in _BY_MASS.T]


def _kicked(system, wxyz, omega, kick):
    """Attitudes (N, 4) after kicks, and the changes (N, 3) of the angular velocity, body axes.

    kick: epochs (2, N), lengths (N,), coefficients (N,) of the force gradient, and samples.
    """
    from attitude._solver.march import kicks

    times, h, cubed, samples = kick
    states = np.zeros((len(h), STATE_ENTRIES))
    states[:, WXYZ] = quaternion.multiply(wxyz, system.turn)
    states[:, OMEGA] = omega @ system.axes
    out = np.empty_like(states)
    numbers, _, models = system.setup
    first = np.ascontiguousarray(times[0])
    system.run(kicks, 0.0, numbers, models, states, first, h, cubed, samples, out)
    gained = (out[:, OMEGA] - states[:, OMEGA]) + out[:, OMEGA_LOW]
    after = quaternion.multiply(out[:, WXYZ], quaternion.conjugate(system.turn))
    return after, gained @ system.axes.T


def _turns(wxyz: FloatArray, reference: FloatArray) -> FloatArray:
    """Rotation vectors (N, 3), inertial axes, from reference attitudes to others."""
    return forms.to_rotation_vector(quaternion.multiply(wxyz, quaternion.conjugate(reference)))
