"""Body, torques and scheme of a torqued motion, packed for the loops of `solution.march`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs, quaternion
from attitude.compilation.callback_errors import raising_callback_errors
from attitude.compilation.decorators import EntryPoint
from attitude.errors import AttitudeError
from attitude.solution import march_layout as layout
from attitude.solution.march_layout import OMEGA, STATE_ENTRIES, WXYZ
from attitude.splitting.ascending import ascending
from attitude.torques.torque import LINEAR, SLIP

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import BoolArray, FloatArray, IntArray
    from attitude.body import Body
    from attitude.spin import Spin
    from attitude.splitting.schemes import Scheme
    from attitude.torques.torque import Torque

# The largest turn between two torques: most torques vary with twice the attitude, and are aliased
# where the body turns by more than this between samples.
LARGEST_TURN: float = 0.5 * np.pi
# s; no motion of a body needs others.
_LEAST_STEP, _LONGEST_STEP = 1e-70, 1e40
# Up to here, a double holds every whole number.
_MOST_STEPS = 2.0**53
_NONE = np.zeros((3, 3))


class System:
    """The system that is integrated, and its compiled loops.

    Parameters
    ----------
    body : Body
    spin : Spin
    torques : tuple of Torque
    chosen : Scheme

    Attributes
    ----------
    start : (14,) array
        State at the epoch, over the principal axes in ascending order: `march_layout`.
    setup : tuple of three arrays
        Body, scheme and models of `march_layout`.
    kicks : int
        Of a step.
    order : int
        Of the error in the step.
    columns : int
        Numbers that the torques sample at each kick.
    """

    def __init__(self, body: Body, spin: Spin, torques: tuple[Torque, ...], chosen: Scheme) -> None:
        if np.min(body.moments) <= 0.0:
            raise AttitudeError(
                "the body is a rod, with a moment of zero, about whose axis any torque would turn "
                "it infinitely fast; give it a small moment there."
            )
        self.epoch, self.torques, self.scheme = spin.epoch, torques, chosen
        self.body = body
        self.moments, self.axes = ascending(body)
        self.turn = quaternion.from_matrix(self.axes)
        self.start = np.zeros(STATE_ENTRIES)
        self.start[WXYZ] = quaternion.multiply(spin.wxyz_icrf, self.turn)
        self.start[WXYZ] /= np.sqrt(self.start[WXYZ] @ self.start[WXYZ])
        self.start[OMEGA] = spin.angular_velocity @ self.axes
        self.setup = self._numbers(), self._coefficients(), self._models()
        self.kicks = len(chosen.kicks)
        self.columns = sum(torque.columns for torque in torques)
        # The midpoint rule of a slip is of second order in a scheme of any.
        slips = any(torque.kind == SLIP for torque in torques)
        self.order = min(chosen.order, 2) if slips else chosen.order

    # Packing -------------------------------------------------------------------------------------

    def _numbers(self) -> FloatArray:
        numbers = np.empty(layout.BODY_ENTRIES)
        by_rate = sum((torque.by_rate() for torque in self.torques if torque.kind == LINEAR), _NONE)
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
        # The compiled loops hold addresses only: this list keeps the arrays alive.
        self._parameters = [
            np.append(np.asarray(torque.parameters(self.body), float), 0.0)
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
        names = [
            type(torque).__name__
            for torque, slope in zip(self.torques, slopes, strict=True)
            if not slope
        ]
        if names:
            raise AttitudeError(
                f'the scheme "{self.scheme.name}" needs the force gradient of every torque, which '
                f"{' and '.join(names)} does not define; GravityGradient, ConstantTorque and a "
                'CustomTorque with slope= do. Take "suzuki" or "blanes-moan", which need none.'
            )

    # Limits --------------------------------------------------------------------------------------

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

    # Calls ---------------------------------------------------------------------------------------

    def sampled(self, times: FloatArray) -> FloatArray:
        """Samples of all torques at epochs (2, ...), pairs: (..., columns), one column or more."""
        shape = times.shape[1:]
        hi, lo = np.ascontiguousarray(times).reshape(2, -1)
        parts = [torque.sample(self.epoch, hi, lo) for torque in self.torques if torque.columns]
        parts = parts or [np.zeros((hi.size, 1))]
        joined = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.ascontiguousarray(joined).reshape(*shape, joined.shape[1])

    def kick_times(self, starts: FloatArray, h: float | FloatArray) -> FloatArray:
        """Epochs (2, ..., n + 1) of the kicks of steps that start at (2, ...), of lengths h.

        In pairs: after 1e8 steps a double of seconds leaves the place on an orbit uncertain by
        1e-10 rad, which would show as a random walk of the conserved quantities.
        """
        share = np.concatenate([[0.0], np.cumsum(self.scheme.flights)])
        share[-1] = 1.0
        hi, lo = starts[0][..., None], starts[1][..., None]
        return np.array(pairs.add((hi, lo), np.asarray(h)[..., None] * share))

    def march(self, state: FloatArray, start: int, h: float, steps: int, every: int) -> FloatArray:
        """Take steps of one length from a state, in place; the kept states (steps // every, 14).

        start: the number of such steps from the epoch to it.
        """
        from attitude.solution.march import march

        starts = np.array(pairs.product(start + np.arange(float(steps)), h))
        times = self.kick_times(starts, h)
        rows = np.concatenate([times[:, :, :-1].reshape(2, -1), times[:, -1:, -1]], axis=1)
        kept = np.empty((steps // every, STATE_ENTRIES))
        given = self.sampled(rows)
        self.run(march, h, *self.setup, state, float(start), h, steps, given, kept, every)
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
        label: Callable[[int], str],
    ) -> FloatArray:
        """Take the steps of the samples from N states, in place; states (N, T, 7) at epochs.

        Parameters
        ----------
        setup : tuple of three arrays
            As `setup`, with a leading axis of bodies, 1 or N, of the first and the last.
        states : (N, 14) array
        start : int
            Number of steps from the epoch to them.
        h : float
            s.
        number, parts : (T,) arrays
            Whole steps to each epoch from there, ascending, and the seconds after those.
        samples : tuple of two arrays
            Of `samples_of`.
        label : callable
            Name of a state in error messages.

        Raises
        ------
        AttitudeError
            As `run`, with the name of the state.
        """
        from attitude.solution.march_members import march_members

        steps = (len(samples[0]) - 1) // self.kicks_between
        out = np.empty((len(states), len(number), 7))

        member = 0

        def loop(*arguments: Any) -> tuple[int, float, float]:
            nonlocal member
            fault, t, rate, member = march_members(*arguments)
            return fault, t, rate

        rest = float(start), h, steps, number, parts, *samples, out
        try:
            self.run(loop, h, *setup, states, *rest)
        except AttitudeError as err:
            raise AttitudeError(f"{label(member)}: {err}") from err
        return out

    @property
    def kicks_between(self) -> int:
        """Kicks of a step, of which the last is the first of the next step."""
        return self.kicks - 1

    def samples_of(
        self, start: int, h: float, steps: int, number: IntArray, parts: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Samples at the kicks of steps, and of parts of steps, as `march_members` takes them."""
        starts = np.array(pairs.product(start + np.arange(float(max(steps, 1))), h))
        times = self.kick_times(starts, h)
        rows = np.concatenate([times[:, :, :-1].reshape(2, -1), times[:, -1:, -1]], axis=1)
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
        """States (T, 7) at epochs after kept ones.

        Parameters
        ----------
        states, numbers : (S, 14), (S,) arrays
            Kept states, and the numbers of steps from the epoch to them.
        h : float
            s, of the whole steps.
        place, steps, parts : (T,) arrays
            Of each epoch: the kept state before it, the whole steps from there, and the seconds
            after those.
        """
        from attitude.solution.march import revisit

        starts = np.array(pairs.product(numbers, h))
        # Steps of length h from the starts, as many as the farthest epoch needs.
        hi, lo = pairs.product(np.arange(max(float(steps.max()), 1.0)), h)
        whole = np.array(pairs.add((starts[0][:, None], starts[1][:, None]), hi, lo))
        times = self.kick_times(whole, h)
        rows = np.concatenate(
            [times[:, :, :, :-1].reshape(2, len(states), -1), times[:, :, -1:, -1]], axis=2
        )
        given = self.sampled(rows if steps.any() else rows[:, :, :1])
        begin = starts[0, place], starts[1, place]
        last = np.array(pairs.add(begin, *pairs.product(steps.astype(np.float64), h)))
        within = self.sampled(self.kick_times(last, parts))
        out = np.empty((len(place), 7))
        self.run(
            *(revisit, h, *self.setup, states, numbers, h, place, steps, parts),
            *(given, within, out),
        )
        return out

    def acceleration(self, seconds: FloatArray, low: FloatArray, found: FloatArray) -> FloatArray:
        """Rates of change (N, 3) of the angular velocity over the body axes, rad/s2.

        found: (N, 7), attitudes and angular velocities at seconds + low (N,), as `over_body_axes`
        gives them.
        """
        from attitude.solution.march import accelerations

        known: BoolArray = np.all(np.isfinite(found), axis=-1)
        states = np.zeros((int(known.sum()), STATE_ENTRIES))
        states[:, WXYZ] = quaternion.multiply(found[known, :4], self.turn)
        states[:, OMEGA] = found[known, 4:] @ self.axes
        t = np.stack([seconds[known], low[known]])
        out = np.full((len(found), 3), np.nan)
        some = np.empty((len(states), 3))
        numbers, _, models = self.setup
        self.run(accelerations, 0.0, numbers, models, states, t[0], self.sampled(t), some)
        out[known] = some @ self.axes.T
        return out

    def over_body_axes(self, states: FloatArray) -> FloatArray:
        """(N, 7) of the integration as unit quaternions of the body axes, and rates over them."""
        out = np.empty(states.shape)
        q = quaternion.multiply(states[:, :4], quaternion.conjugate(self.turn))
        out[:, :4] = q / np.sqrt(np.sum(q * q, axis=-1))[:, None]
        out[:, 4:] = states[:, 4:] @ self.axes.T
        return out
