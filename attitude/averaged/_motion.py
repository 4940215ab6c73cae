"""`AveragedMotion`: the mean rotation of a body under weak torques, over years.

>>> from attitude import Body, Spin
>>> from attitude.averaged import AveragedMotion
>>> from attitude.torques import InternalDissipation
>>> body = Body(moments=(10, 20, 26))
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.001, 0.0005, 0.01))
>>> motion = AveragedMotion(body, spin, InternalDissipation(1e-4))
>>> states = motion.at([0.0, 86400.0 * 30])
>>> bool(states.theta[1] < states.theta[0])
True
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.callbacks import raising_callback_errors
from attitude._solver import regime as solver_regime
from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude.averaged import _mean_state
from attitude.averaged import _rates as layout
from attitude.averaged._means import means_of
from attitude.averaged._pack import Packed, Sampling, turn_period
from attitude.averaged._polhode import LAM_PLUS, REGIONS, Axes, Nutations, shares
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.torques._torqued import TorquedRotation, _torques

if TYPE_CHECKING:
    from astropy.table import QTable

    from attitude._support.annotations import Epochs, FloatArray, IntArray, Real
    from attitude.epochs._instants import Instant
    from attitude.torques._torque import Torque

# Default largest degree of the harmonics of a torque of one direction.
DEGREE = 32
# |N| P/(2 pi |L|) beyond which means of first order are refused.
_WEAK = 0.05
# Change of L in one turn of a path below which "auto" averages over the turn.
_SMALL = 1e-3 * 2.0 * math.pi
# Rows of the trajectory that one call fills.
_ROWS = 4096
# Passages without progress after which a rotation stays at the separatrix; branches of a tree, and
# the least odds of one.
_MOST_PASSAGES, _MOST_BRANCHES, _LEAST_ODDS = 100, 256, 1e-3


@dataclass(frozen=True)
class AveragedEvent:
    """Something that happens to a mean rotation.

    Attributes
    ----------
    kind : str
        "passage" of the separatrix; "uniform rotation reached" or "left": the tilt from an axis
        falls to the least tilt, or grows again; "no longer weak", which ends the motion.
    seconds : float
        TDB seconds since the epoch of the spin.
    before, after : str
        Regions: "SAM+", "SAM-", "LAM+", "LAM-", the mode and the end of the circulated axis that
        the momentum is near.
    odds : dict of str to float
        Of a passage: the odds of the regions that may follow.
    is_proved : bool
        Of a passage: False where y rises on one arc of a lap and falls on the other, so that the
        rule for the odds is not proved.
    """

    kind: str
    seconds: float
    before: str
    after: str
    odds: dict[str, float] = field(default_factory=dict)
    is_proved: bool = True


class AveragedHistory(Immutable):
    """Mean states at epochs of shape S, made by `AveragedMotion.at`.

    Attributes
    ----------
    seconds : array of shape S
        TDB seconds since the epoch of the spin.
    momentum : (S, 3) array
        N m s over ICRF axes.
    y : array of shape S
        2 ln tan theta.
    region : array of shape S
        0 to 3: SAM+, SAM-, LAM+, LAM-.
    """

    def __init__(
        self, motion: AveragedMotion, seconds: FloatArray, states: FloatArray, region: IntArray
    ) -> None:
        self.__dict__.update(
            motion=motion,
            seconds=frozen(np.asarray(seconds)),
            momentum=frozen(np.array(states[..., :3])),
            y=frozen(np.array(states[..., 3])),
            region=frozen(np.asarray(region)),
        )

    motion: AveragedMotion
    seconds: FloatArray
    momentum: FloatArray
    y: FloatArray
    region: IntArray

    def __len__(self) -> int:
        if not self.seconds.shape:
            raise TypeError("a history of one scalar epoch has no length")
        return len(self.seconds)

    def __getitem__(self, index: Any) -> AveragedHistory:
        """The history of some of the epochs."""
        states = np.concatenate([self.momentum, self.y[..., None]], axis=-1)[index]
        return AveragedHistory(self.motion, self.seconds[index], states, self.region[index])

    def __repr__(self) -> str:
        return f"<AveragedHistory of {self.seconds.size} epochs>"

    @property
    def size(self) -> FloatArray:
        """|L| (S,) in N m s."""
        return np.asarray(np.sqrt(np.sum(self.momentum**2, axis=-1)))

    @property
    def pole(self) -> FloatArray:
        """Unit vectors (S, 3) along the momentum, ICRF axes."""
        return np.asarray(self.momentum / self.size[..., None])

    @property
    def theta(self) -> FloatArray:
        """The angle (S,) in rad between momentum and short axis, where the middle one is across."""
        return np.asarray(np.arctan(np.exp(0.5 * self.y)))

    @property
    def mode(self) -> Any:
        """ "SAM" or "LAM" for each epoch (S,)."""
        return np.where(self.region < LAM_PLUS, "SAM", "LAM")

    @property
    def near_end(self) -> FloatArray:
        """Unit vectors (S, 3) over the body axes: the end of the axis that the momentum circles."""
        ends = np.array([self.motion.axes.end(k) for k in range(4)])
        return np.asarray(ends[self.region])

    @property
    def energy(self) -> FloatArray:
        """Kinetic energy (S,) in J."""
        return self.motion.axes.energy(self.size, self.y)

    @cached_property
    def P_psi(self) -> FloatArray:
        """Periods of the nutation (S,) in s."""
        out = np.empty(self.y.size)
        flat, region = self.y.reshape(-1), self.region.reshape(-1)
        for k in range(4):
            chosen = region == k
            h = np.abs(flat[chosen] - self.motion.axes.separatrix)
            out[chosen] = Nutations.of(self.motion.axes, k, np.maximum(h, 1e-15)).period
        return frozen(out.reshape(self.y.shape) / self.size)

    @cached_property
    def P_phi(self) -> FloatArray:
        """Mean periods (S,) in s of the long axis about the momentum."""
        axes = self.motion.axes
        p, rest = shares(self.y)
        zero = np.zeros_like(p)
        unit = np.stack([np.sqrt(p), zero, np.sqrt(rest)], axis=-1)
        omega = self.size[..., None] * unit / axes.moments
        found = solver_regime.regimes(axes.moments, omega.reshape(-1, 3))
        return frozen(np.asarray(found.P_phi_L).reshape(self.y.shape))

    @cached_property
    def weakness(self) -> FloatArray:
        """|N| P/(2 pi |L|) (S,), the share of the momentum that torques change in a radian."""
        states = np.concatenate([self.momentum, self.y[..., None]], axis=-1).reshape(-1, 4)
        flat = zip(self.seconds.reshape(-1), states, self.region.reshape(-1), strict=True)
        found = [self.motion.weakness_of(float(t), x, int(k)) for t, x, k in flat]
        return frozen(np.array(found).reshape(self.y.shape))

    def free_rotation(self, phases: tuple[Real, Real] | None = None, seed: int = 0) -> FreeRotation:
        """The exact free rotation with the mean momentum and energy of one epoch.

        Parameters
        ----------
        phases : (float, float), optional
            Of nutation and precession, in turns.  Means leave both unknown: without them they are
            drawn at random.
        seed : int
            Of the draw.

        Raises
        ------
        AttitudeError
            For a history of more than one epoch; choose one, ``states[k]``.
        """
        if self.seconds.shape:
            raise AttitudeError(
                f"the history has {self.seconds.size} epochs, and a free rotation starts from one; "
                "choose it, as in states[0].free_rotation()."
            )
        if phases is None:
            one, two = validation.generator(seed).random(2)
        else:
            one, two = (validation.number(each, "phases") for each in phases)
        axes = self.motion.axes
        count = 4096
        nodes = axes.nodes(float(self.y), int(self.region), count)
        unit = nodes[int((one % 1.0) * count) % count]
        unit = unit / np.sqrt(unit @ unit)
        omega = axes.matrix @ (float(self.size) * unit / axes.moments)
        start, target = axes.matrix @ unit, self.pole
        half = start + target
        if half @ half < 1e-12:
            half = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
        wxyz = np.array([0.0, *(half / np.sqrt(half @ half))])
        angle = math.pi * two
        turn = np.array([math.cos(angle), *(math.sin(angle) * target)])
        epoch = self.motion.epoch.after(float(self.seconds))
        spin = Spin(
            epoch=epoch, wxyz=quaternion.multiply(turn, wxyz), angular_velocity=omega, frame="icrf"
        )
        return FreeRotation(self.motion.body, spin)

    def table(self) -> QTable:
        """A QTable with a row for each epoch: times, momentum, theta, mode, energy, periods."""
        from astropy.table import QTable
        from astropy.units import Quantity

        t = np.atleast_1d(self.seconds)
        found = QTable({"time": _instants.times(self.motion.epoch, t)})
        found["tdb_seconds"] = Quantity(t, "s")
        for name, unit in (("size", "N m s"), ("theta", "rad"), ("energy", "J")):
            found[name] = Quantity(np.atleast_1d(getattr(self, name)), unit)
        for k, name in enumerate(("pole_x", "pole_y", "pole_z")):
            found[name] = np.atleast_2d(self.pole)[:, k]
        found["region"] = [REGIONS[k] for k in np.atleast_1d(self.region)]
        for name in ("P_psi", "P_phi"):
            found[name] = Quantity(np.atleast_1d(getattr(self, name)), "s")
        return found


class _Track:
    """One trajectory in one direction of time, extended on demand."""

    def __init__(self, motion: AveragedMotion, x: FloatArray, region: int, sign: float) -> None:
        self.motion, self.x, self.region, self.sign = motion, x.copy(), region, sign
        self.clock = np.array([0.0, sign * motion.first_step(x), 0.0])
        self.rows: list[FloatArray] = []
        self.events: list[AveragedEvent] = []
        self.ended: AveragedEvent | None = None
        self.odds, self._idle = 1.0, 0
        least, greatest = motion.limits
        if x[3] <= least or x[3] >= greatest:
            self.x[3] = min(max(x[3], least), greatest)
            self.clock[2] = -1.0 if x[3] <= least else 1.0

    def branched(self) -> _Track:
        """A copy that shares what has been."""
        other = _Track.__new__(_Track)
        other.__dict__.update(self.__dict__)
        other.x, other.clock = self.x.copy(), self.clock.copy()
        other.rows, other.events = list(self.rows), list(self.events)
        return other

    def extend(self, until: float, choose: Callable[[_Track, dict[int, float]], int]) -> None:
        """Integrate up to seconds `until` or to the end."""
        motion, packed = self.motion, self.motion.packed
        limits = np.array([*motion.limits, _WEAK, self.sign])
        while self.ended is None and (until - self.clock[0]) * self.sign > 0.0:
            forcing, end = motion.window(float(self.clock[0]), self.sign)
            rows = np.empty((_ROWS, layout.ROW_ENTRIES))
            arguments = packed.data, packed.models, forcing, packed.work, rows
            target = end if np.isfinite(end) else max(until * self.sign, 1.0) * 1.25 * self.sign
            with raising_callback_errors():
                status, count = layout.advance(
                    self.clock, self.x, self.region, target, motion.tolerance, limits, *arguments
                )
            if count:
                self.rows.append(rows[:count].copy())
                self._idle = 0 if count > 3 else self._idle
            if status == layout.BAD:
                raise AttitudeError(
                    f"the mean torque is not finite {self.clock[0]:.9g} s after the epoch; check "
                    "the torques, or give earlier epochs only."
                )
            if status in (layout.PASSAGE, layout.CLAMPED, layout.RELEASED, layout.STRONG):
                self._happens(status, forcing, choose)

    def _happens(self, status, forcing, choose):
        """Note an event and set the state behind it."""
        t, name = float(self.clock[0]), REGIONS[self.region]
        if status == layout.STRONG:
            self.ended = AveragedEvent("no longer weak", t, name, name)
            self.events.append(self.ended)
        elif status == layout.CLAMPED:
            self.clock[2] = -1.0 if self.region < LAM_PLUS else 1.0
            self.events.append(AveragedEvent("uniform rotation reached", t, name, name))
        elif status == layout.RELEASED:
            self.clock[2] = 0.0
            self.events.append(AveragedEvent("uniform rotation left", t, name, name))
        else:
            self._idle += 1
            if self._idle > _MOST_PASSAGES:
                self.ended = AveragedEvent("stays at the separatrix", t, name, name)
                self.events.append(self.ended)
                return
            odds, proved = self.motion.odds_of(t, self.x, self.region, forcing, self.sign)
            self.pass_to(choose(self, odds), odds, proved)

    def pass_to(self, region: int, odds: dict[int, float], proved: bool = True) -> None:
        """Continue on the other side of the separatrix."""
        before = REGIONS[self.region]
        side = 1.0 if region >= LAM_PLUS else -1.0
        named = {REGIONS[k]: v for k, v in odds.items()}
        t = float(self.clock[0])
        self.events.append(AveragedEvent("passage", t, before, REGIONS[region], named, proved))
        self.region = region
        self.x[3] = self.motion.axes.separatrix + side * layout.BEYOND
        self.clock[1] = self.sign * self.motion.first_step(self.x)

    def states(self, t: FloatArray) -> tuple[FloatArray, IntArray]:
        """States (T, 4) and regions at seconds (T,)."""
        if not self.rows:
            return np.tile(self.x, (len(t), 1)), np.full(len(t), self.region)
        rows = self._joined()
        k = np.searchsorted(self.sign * rows[:, 0], self.sign * t, side="right") - 1
        row = rows[np.clip(k, 0, len(rows) - 1)]
        share = ((t - row[:, 0]) / row[:, 1])[:, None]
        rest = 1.0 - share
        terms = row[:, layout.ROW_TERMS : layout.ROW_END].reshape(-1, 5, 4)
        inner = terms[:, 2] + share * (terms[:, 3] + rest * terms[:, 4])
        states = terms[:, 0] + share * (terms[:, 1] + rest * inner)
        return states, row[:, layout.ROW_REGION].astype(np.int64)

    def _joined(self) -> FloatArray:
        if len(self.rows) > 1:
            self.rows = [np.concatenate(self.rows)]
        return self.rows[0]


@dataclass(frozen=True, eq=False)
class Branch:
    """One leaf of the tree of passages.

    Attributes
    ----------
    odds : float
        The product of the odds of its passages.
    regions : tuple of str
        In the order of time.
    events : tuple of AveragedEvent
    """

    odds: float
    regions: tuple[str, ...]
    events: tuple[AveragedEvent, ...]
    _motion: AveragedMotion
    _track: _Track

    def at(self, t: Epochs) -> AveragedHistory:
        """The mean states of this branch at epochs up to that for which the tree was grown."""
        seconds = self._motion.seconds_of(t)
        states, regions = self._track.states(seconds.reshape(-1))
        shape = seconds.shape
        return AveragedHistory(
            self._motion, seconds, states.reshape(*shape, 4), regions.reshape(shape)
        )


class AveragedMotion(Immutable):
    """The mean rotation of a body under weak torques.

    Momentum (three numbers over inertial axes) and energy are integrated with their rates averaged
    over nutation and precession, whose two phases are lost.

    Parameters
    ----------
    body : Body
    spin : Spin
        The state, converted to the mean state.
    torques : Torque, function or sequence of them
        As of `TorquedRotation`.
    orbit : str or sequence of str
        "averaged" over the turn of the path of each torque, "followed" along it, or "auto":
        averaged where the torque changes the momentum by less than 1e-3 rad in a turn.  One for
        all torques, or one for each.
    passages : str or int
        At the separatrix the motion goes to one of two regions by a coin with computed odds:
        "likeliest" takes the greater odds, a whole number seeds a draw, and `branches` follows all.
    least_tilt : float or Quantity
        rad, or text with its unit.  The tilt from an axis to which damping may lead; it decides
        when an unstable uniform rotation is left.
    tolerance : float
        Of a step, of L in units of |L| and of y.
    degree : int
        Largest degree of the spherical harmonics of light and flow.

    Raises
    ------
    AttitudeError
        For a body with three equal moments, a path that turns faster than ten nutations or
        precessions, torques that are not weak (|N| P/(2 pi |L|) > 0.05), epochs beyond the path.

    Notes
    -----
    Means of first order: errors are of the order of |N| P/(2 pi |L|) times the change.  Resonances
    of nutation and precession are not treated.  docs/averaged.md has the mathematics and limits.
    """

    body: Body
    spin: Spin
    torques: tuple[Torque, ...]

    def __init__(
        self,
        body: Body,
        spin: Spin,
        torques: Any,
        *,
        orbit: Any = "auto",
        passages: Any = "likeliest",
        least_tilt: Real = "0.01 deg",
        tolerance: Real = 1e-7,
        degree: int = DEGREE,
    ) -> None:
        self._set_all(body=body, spin=spin, torques=_torques(torques))
        self._set("tolerance", validation.positive(tolerance, "tolerance"))
        if not 1e-12 <= self.tolerance <= 1e-2:
            raise AttitudeError(f"tolerance is {self.tolerance!r}; give one from 1e-12 to 1e-2.")
        tilt = validation.positive(least_tilt, "least_tilt", unit="rad")
        if not 1e-9 <= tilt < 0.5:
            raise AttitudeError(f"least_tilt is {tilt:.3g} rad; give one from 1e-9 to 0.5 rad.")
        self._set("axes", Axes(body))
        edge = 2.0 * math.log(math.tan(tilt))
        self._set("limits", (edge, -edge))
        self._set("passages", _checked_passages(passages))
        degree = validation.count(degree, "degree", 2)
        if degree > 64:
            raise AttitudeError(f"degree is {degree}; give a whole number from 2 to 64.")
        kinds = _orbits(orbit, len(self.torques))
        self._set("packed", self._pack(kinds, degree))
        _size, y, region = self.axes.state(spin.angular_velocity)
        momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ body.tensor)
        self._set("_windows", {})
        shift, bend = np.zeros(3), 0.0
        if self.limits[0] < y < self.limits[1]:
            shift, bend = _mean_state.corrections(self.axes, body, spin, self.torques, spin.epoch)
        mean = np.append(momentum - shift, y - bend)
        if (mean[3] < self.axes.separatrix) != (region < LAM_PLUS):
            mean[3] = y
        self._set("start", frozen(mean))
        self._set("start_region", region)
        self._refuse_strong()
        tracks = [_Track(self, mean, region, sign) for sign in (1.0, -1.0)]
        self._set("_tracks", tracks)
        seed = self.passages if isinstance(self.passages, int) else 0
        self._set("_random", np.random.default_rng(seed))

    axes: Axes
    limits: tuple[float, float]
    packed: Packed
    start: FloatArray
    start_region: int
    tolerance: float
    passages: Any
    _windows: dict[int, FloatArray]
    _tracks: list[_Track]
    _random: np.random.Generator

    def __repr__(self) -> str:
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<AveragedMotion: {names}>"

    @property
    def epoch(self) -> Instant:
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    # ---- Torques and paths

    def _pack(self, kinds: list[str], degree: int) -> Packed:
        size, y, region = self.axes.state(self.spin.angular_velocity)
        h = max(abs(y - self.axes.separatrix), 1e-9)
        slowest = float(Nutations.of(self.axes, region, np.array([h])).period[0]) / size
        means = []
        for torque, kind in zip(self.torques, kinds, strict=True):
            period = turn_period(torque, self.epoch)
            if period < 10.0 * slowest:
                raise AttitudeError(
                    f"the path of {type(torque).__name__} turns once in {period:.4g} s, and the "
                    f"body nutates once in {slowest:.4g} s; means over the nutation need a path "
                    "that is ten times slower. Integrate by TorquedRotation."
                )
            for mean in means_of(torque, self.body, self.axes, degree):
                one = Sampling(torque, period, False, float("inf"))
                packed = Packed(self.axes, self.body, [(one, mean)], self.epoch)
                averaged = kind == "averaged" and np.isfinite(period)
                if kind == "auto" and np.isfinite(period):
                    averaged = self._turn_of(packed, size, y, region, period) < _SMALL
                sampling = Sampling(torque, period, averaged, float("inf"))
                interval = packed.interval(sampling, mean)
                means.append((Sampling(torque, period, averaged, interval), mean))
        return Packed(self.axes, self.body, means, self.epoch)

    def _turn_of(self, packed, size, y, region, period):
        """rad by which a torque turns the momentum in a turn of its path."""
        x, out = np.array([0.6 * size, 0.0, 0.8 * size, y]), np.empty(4)
        forcing = packed.window(0, float("inf"), (0.0, 0.0))
        arguments = packed.data, packed.models, forcing, packed.work, out, 1
        eps = layout.rates_at(0.0, x, region, *arguments)
        return eps * size / float(self.axes.moments[2]) * period

    def _refuse_strong(self) -> None:
        eps = self.weakness_of(0.0, self.start, self.start_region)
        if not eps <= _WEAK:
            raise AttitudeError(
                f"the torques are not weak: |N| P/(2 pi L) is {eps:.3g} at the epoch, and means "
                f"need less than {_WEAK}. Integrate by TorquedRotation."
            )

    @cached_property
    def span(self) -> tuple[float, float]:
        """First and last TDB seconds since the epoch that the paths of the torques cover."""
        spans = [torque.span(self.epoch) for torque in self.torques]
        return max(a for a, _ in spans), min(b for _, b in spans)

    def window(self, t: float, sign: float) -> tuple[FloatArray, float]:
        """Numbers of the paths in the window of a time, and where the window ends."""
        length = self.packed.length
        if not np.isfinite(length):
            if 0 not in self._windows:
                self._windows[0] = self.packed.window(0, length, self.span)
            return self._windows[0], float("inf")
        # a step that ends a window does so to rounding
        place = t / length + 1e-6 * sign
        number = math.floor(place) if sign > 0.0 else math.ceil(place) - 1
        if number not in self._windows:
            if len(self._windows) > 8:
                self._windows.clear()
            self._windows[number] = self.packed.window(number, length, self.span)
        end = (number + 1) * length if sign > 0.0 else number * length
        return self._windows[number], min(max(end, self.span[0]), self.span[1])

    def weakness_of(self, t: float, x: FloatArray, region: int) -> float:
        """|N| P/(2 pi |L|) of a state (4,): L, y."""
        forcing, _ = self.window(t, 1.0 if t < self.span[1] else -1.0)
        packed, out = self.packed, np.empty(4)
        state = np.array(x)
        arguments = packed.data, packed.models, forcing, packed.work, out, 1
        with raising_callback_errors():
            return float(layout.rates_at(t, state, region, *arguments))

    def first_step(self, x: FloatArray) -> float:
        """Seconds: a hundred turns of the body."""
        size = float(np.sqrt(x[:3] @ x[:3]))
        return 100.0 * 2.0 * math.pi * float(self.axes.moments[2]) / size

    def odds_of(
        self, t: float, x: FloatArray, region: int, forcing: FloatArray, sign: float
    ) -> tuple[dict[int, float], bool]:
        """Odds of the two regions beyond the separatrix, and whether the rule is proved.

        From the changes of y on the four arcs in one lap: those that lead away, in proportion.
        """
        packed, out = self.packed, np.empty(4)
        arcs, seconds = self.axes.arcs
        state = x.copy()
        state[3] = self.axes.separatrix
        arguments = packed.data, packed.models, forcing, arcs, seconds, packed.work, out
        layout.changes_on_arcs(t, state, *arguments)
        change = sign * out.reshape(2, 2)  # by sA and by sC
        if region >= LAM_PLUS:
            pair, goals = -change[region - LAM_PLUS], (0, 1)
        else:
            pair, goals = change[:, region], (2, 3)
        share = np.maximum(pair, 0.0)
        total = float(np.sum(share))
        if total <= 0.0:
            return {goals[0]: 0.5, goals[1]: 0.5}, False
        odds = {goal: float(s) / total for goal, s in zip(goals, share, strict=True)}
        return odds, bool(np.all(pair > 0.0))

    def _choose(self, track: _Track, odds: dict[int, float]) -> int:
        if isinstance(self.passages, int):
            first, second = odds
            return first if self._random.random() < odds[first] else second
        return max(odds, key=lambda region: odds[region])

    # ---- Answers

    def seconds_of(self, t: Epochs) -> FloatArray:
        """Epochs as TDB seconds since that of the spin."""
        hi, lo = _inputs.seconds_since(self.epoch, t)
        found = np.asarray(hi if lo is None else hi + lo, dtype=np.float64)
        if not np.all(np.isfinite(found)):
            raise AttitudeError("an epoch is not finite; give finite epochs.")
        return found

    def _check_span(self, seconds: FloatArray) -> None:
        first, last = self.span
        if seconds.size and (np.min(seconds) < first or np.max(seconds) > last):
            raise AttitudeError(
                f"an epoch lies outside of the paths of the torques, which cover {first:.6g} to "
                f"{last:.6g} s after the epoch of the spin; give a longer path, or other epochs."
            )

    def at(self, t: Epochs) -> AveragedHistory:
        """The mean states at epochs of any shape.

        Raises
        ------
        AttitudeError
            For epochs outside of the paths, or beyond the end of the motion ("no longer weak").
        """
        seconds = self.seconds_of(t)
        self._check_span(seconds)
        flat = seconds.reshape(-1)
        states, regions = np.empty((len(flat), 4)), np.zeros(len(flat), dtype=np.int64)
        for track in self._tracks:
            chosen = flat >= 0.0 if track.sign > 0.0 else flat < 0.0
            if not np.any(chosen):
                continue
            farthest = float(np.max(np.abs(flat[chosen]))) * track.sign
            track.extend(farthest, self._choose)
            if track.ended is not None and (farthest - track.ended.seconds) * track.sign > 0.0:
                raise AttitudeError(
                    f"the motion ends {track.ended.seconds:.9g} s after the epoch: "
                    f"{track.ended.kind}. Give earlier epochs, or integrate by TorquedRotation "
                    "from there."
                )
            states[chosen], regions[chosen] = track.states(flat[chosen])
        shape = seconds.shape
        return AveragedHistory(self, seconds, states.reshape(*shape, 4), regions.reshape(shape))

    @property
    def events(self) -> tuple[AveragedEvent, ...]:
        """Events up to the farthest epochs asked so far, in the order of time."""
        found = [event for track in self._tracks for event in track.events]
        return tuple(sorted(found, key=lambda event: event.seconds))

    def branches(self, until: Epochs) -> list[Branch]:
        """All branches of the motion up to an epoch after that of the spin, the likeliest first.

        At most 256, each with odds of at least 1e-3: their odds add up to what they cover.
        """
        end = float(self.seconds_of(until))
        self._check_span(np.array([end]))
        growing = [_Track(self, self.start, self.start_region, 1.0)]
        leaves = []
        while growing:
            track = growing.pop()

            def choose(one: _Track, odds: dict[int, float]) -> int:
                regions = sorted(odds, key=lambda region: -odds[region])
                chosen, other = regions
                if one.odds * odds[other] >= _LEAST_ODDS and len(growing) < _MOST_BRANCHES:
                    copy = one.branched()
                    copy.odds *= odds[other]
                    copy.pass_to(other, odds)
                    growing.append(copy)
                one.odds *= odds[chosen]
                return chosen

            track.extend(end, choose)
            leaves.append(track)
        leaves.sort(key=lambda track: -track.odds)
        return [self._branch(track) for track in leaves]

    def _branch(self, track: _Track) -> Branch:
        passed = [e for e in track.events if e.kind == "passage"]
        regions = (REGIONS[self.start_region], *(e.after for e in passed))
        return Branch(track.odds, regions, tuple(track.events), self, track)

    def check(self, turns: Real = 1e3) -> dict[str, float]:
        """Compare with `TorquedRotation` over the first turns of the body.

        Returns
        -------
        dict
            "seconds" of the comparison; "size", "energy" and "pole": differences of |L| and energy
            as shares of themselves and of the pole in rad; "size change", "energy change", "pole
            change": what they changed by.
        """
        seconds = validation.positive(turns, "turns") * self.first_step(self.start) / 100.0
        rate = float(np.sqrt(self.spin.angular_velocity @ self.spin.angular_velocity))
        full = TorquedRotation(self.body, self.spin, self.torques, step=0.15 / rate)
        history = full.at(seconds)
        spin = Spin(
            epoch=self.epoch.after(seconds),
            wxyz=history.wxyz,
            angular_velocity=history.angular_velocity,
            frame="icrf",
        )
        _size, y, region = self.axes.state(spin.angular_velocity)
        shift, bend = _mean_state.corrections(
            self.axes, self.body, spin, self.torques, self.epoch, seconds
        )
        momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ self.body.tensor)
        states = np.append(momentum - shift, y - bend)
        truth = AveragedHistory(self, np.array(seconds), states, np.array(region))
        mean, start = self.at(seconds), self.at(0.0)
        found = {"seconds": float(seconds)}
        for name, other in (("", mean), (" change", start)):
            found["size" + name] = float(other.size / truth.size - 1.0)
            found["energy" + name] = float(other.energy / truth.energy - 1.0)
            across = np.cross(other.pole, truth.pole)
            found["pole" + name] = float(np.sqrt(across @ across))
        return found


def _checked_passages(given: Any) -> Any:
    if isinstance(given, str):
        return validation.one_of(given, "passages", ("likeliest",))
    return validation.count(given, "passages", 0)


def _orbits(given: Any, count: int) -> list[str]:
    several = [given] * count if isinstance(given, str) else given
    if not isinstance(several, Iterable):
        raise AttitudeError('orbit is not text; give "auto", "averaged" or "followed".')
    listed = list(several)
    if len(listed) != count:
        raise AttitudeError(
            f"orbit has {len(listed)} entries for {count} torques; give one for all, or one each."
        )
    return [validation.one_of(each, "orbit", ("auto", "averaged", "followed")) for each in listed]
