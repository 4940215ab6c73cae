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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.synonyms import arguments
from attitude.averaged import _mean_state, _resonances
from attitude.averaged._history import AveragedHistory
from attitude.averaged._mean_torques import Crossing, MeanTorques, Packing, checked_orbits
from attitude.averaged._polhode import FARTHEST, LAM_PLUS, REGIONS, Axes
from attitude.averaged._tracks import WEAK, AveragedEvent, Course, Track
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin, refuse_others
from attitude.torques._torqued import TorquedRotation, _torques

if TYPE_CHECKING:
    from astropy.table import QTable

    from attitude._support.annotations import (
        BoolArray,
        Epochs,
        FilePath,
        FloatArray,
        IntArray,
        Real,
    )
    from attitude.epochs._instants import Instant
    from attitude.torques._torque import Torque

# Default largest degree of the harmonics of a torque of one direction.
DEGREE = 32
# Of `check`: turn of the body in the longest step of the full motion, rad.
_COARSEST = 0.15
# How often these steps are halved at most: light on facets needs that many.
_HALVINGS = 4
# Share of the difference from the means below which their error is small.
_CLOSE = 0.1
# Error that is rounding, however small the difference is.
_ROUNDING = 1e-10
# Seconds by which a path may begin behind the epoch of the spin, by rounding.
_ROUNDED = 1e-9
# Turn of the body in a step of the full motion through a resonance, rad.
_FINE = 0.05
# Branches of a tree, at most.
_MOST_BRANCHES = 256
# Share of these up to which resonances are split: passages have to be split too.
_SPLIT_SHARE = 0.25
# Least odds of a branch, over those of equally likely ones: 0.001 in a tree of 256.
_LEAST_ODDS = 0.256


# ---- Branches


@dataclass(frozen=True, eq=False)
class Branch:
    """One leaf of the tree of passages.

    Attributes
    ----------
    odds : float
        The product of the odds of its passages.
    regions : tuple of str
        In the order of time.
    kicks : tuple of float
        By which resonances have changed y, where the tree is split there, in the order of time.
    events : tuple of AveragedEvent
    until : float
        TDB seconds since the epoch up to which it is known: that of the tree, or its end.
    """

    odds: float
    regions: tuple[str, ...]
    kicks: tuple[float, ...]
    events: tuple[AveragedEvent, ...]
    until: float
    _track: Track

    def _seconds(self, t: Epochs) -> FloatArray:
        """Epochs as TDB seconds since that of the spin, within the span of the branch."""
        seconds = seconds_of(self._track.course.packing.torques.instant, t)
        outside = (seconds * self._track.sign < 0.0) | (
            (seconds - self.until) * self._track.sign > 0.0
        )
        if np.any(outside):
            wrong = float(seconds[outside].flat[0])
            raise AttitudeError(
                f"an epoch lies {wrong:.9g} s after that of the spin, and this branch is known "
                f"from 0 to {self.until:.9g} s; give epochs between them, or a longer tree."
            )
        return seconds

    def at(self, t: Epochs) -> AveragedHistory:
        """The mean states of this branch at epochs between that of the spin and `until`.

        Raises
        ------
        AttitudeError
            For epochs outside of that span.
        """
        seconds = self._seconds(t)
        states, regions = self._track.states(seconds.reshape(-1))
        shape = seconds.shape
        packing = self._track.course.packing
        return AveragedHistory(packing, seconds, states.reshape(*shape, 4), regions.reshape(shape))

    def scatter(self, t: Epochs) -> dict[str, FloatArray]:
        """How far full motions of this branch lie from its means, at epochs of shape S.

        Each resonance of nutation and precession kicks momentum and energy by its phase, and each
        passage comes early or late, by phases that means do not know; both are followed to later
        epochs.  To first order in the kicks, without capture; `error_estimate` has the rest.

        Returns
        -------
        dict
            Root mean squares over the phases: "size" of |L| as a share, "y", and "pole" in rad;
            NaN where a kicked motion has ended before.

        Raises
        ------
        AttitudeError
            For epochs outside of the span of the branch.
        """
        seconds = self._seconds(t)
        rms = _resonances.scatter(self._track, seconds.reshape(-1))
        names = "size", "y", "pole"
        return {name: rms[:, k].reshape(seconds.shape) for k, name in enumerate(names)}


class Branches(Sequence[Branch]):
    """The leaves of a tree of passages, the likeliest first.

    Attributes
    ----------
    odds : (B,) array
        Their sum is what the tree covers: branches with odds below 1e-3 are left out.
    until : float
        TDB seconds since the epoch up to which the tree is grown.
    """

    def __init__(self, leaves: Sequence[Branch], until: float) -> None:
        self._leaves = tuple(leaves)
        self.until = until
        self.odds: FloatArray = frozen(np.array([leaf.odds for leaf in leaves]))

    @overload
    def __getitem__(self, index: int) -> Branch: ...

    @overload
    def __getitem__(self, index: slice) -> Branches: ...

    def __getitem__(self, index: int | slice) -> Branch | Branches:
        """One branch, or some of them."""
        if isinstance(index, slice):
            return Branches(self._leaves[index], self.until)
        return self._leaves[index]

    def __len__(self) -> int:
        return len(self._leaves)

    def __iter__(self) -> Iterator[Branch]:
        return iter(self._leaves)

    def __repr__(self) -> str:
        return f"<Branches: {len(self)} with odds of {np.sum(self.odds):.4g} in all>"

    def at(self, t: Epochs) -> AveragedHistory:
        """Mean states (B, ...) of all branches, NaN behind the end of a branch; with `odds`."""
        packing = self._leaves[0]._track.course.packing
        seconds = seconds_of(packing.torques.instant, t)
        sign = self._leaves[0]._track.sign
        if np.any(seconds * sign < 0.0) or np.any((seconds - self.until) * sign > 0.0):
            raise AttitudeError(
                f"the tree is known from 0 to {self.until:.9g} s after the epoch of the spin; give "
                "epochs between them, or a longer tree."
            )
        flat = seconds.reshape(-1)
        states = np.empty((len(self), len(flat), 4))
        regions = np.empty((len(self), len(flat)), dtype=np.int64)
        for k, leaf in enumerate(self._leaves):
            states[k], regions[k] = leaf._track.states(flat)
            states[k, (flat - leaf.until) * sign > 0.0] = np.nan
        shape = len(self), *seconds.shape
        return AveragedHistory(
            packing,
            np.broadcast_to(seconds, shape),
            states.reshape(*shape, 4),
            regions.reshape(shape),
            self.odds,
        )

    def table(self) -> QTable:
        """A QTable with a row for each branch: odds, regions, seconds of passages, kicks."""
        from astropy.table import QTable

        table = QTable({"odds": np.array(self.odds)})
        table["regions"] = [" ".join(leaf.regions) for leaf in self._leaves]
        passages = [[e for e in leaf.events if e.kind == "passage"] for leaf in self._leaves]
        table["tdb_seconds"] = [" ".join(f"{e.seconds:.9g}" for e in row) for row in passages]
        table["kicks"] = [" ".join(f"{kick:.3g}" for kick in leaf.kicks) for leaf in self._leaves]
        return table


# ---- The motion


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
        averaged where the torque changes the momentum by less than 1e-3 of a turn in a turn of the
        path.  One for all torques, or one for each.
    passages : str or int
        At the separatrix the motion goes to one of two regions by a coin with computed odds:
        "likeliest" takes the greater odds, a whole number seeds a draw, and "all" follows all
        branches: `at` then returns states (B, ...) of the branches that `branches` names.
    least_tilt : float or Quantity
        rad, or text with its unit.  The greatest nutation to which damping may lead, and that of a
        state that nutates less; it decides when an unstable uniform rotation is left.
    tolerance : float
        Of a step, of L in units of |L| and of y.
    degree : int
        Largest degree of the spherical harmonics of light and flow, 2 to 64; for the YORP effect
        64, since it is a small remainder of the torque.
    order : int
        1, or 2 for means of second order in the torques, which need paths that are followed, and
        some 10 ms in each step: docs/averaged.md has what they gain.

    Raises
    ------
    AttitudeError
        For a body with three equal moments, a path that turns faster than ten turns or nutations
        of the body, torques that are not weak (|N| P/(2 pi |L|) > 0.05), epochs beyond the path.

    Notes
    -----
    Errors of first order are of the order of |N| P/(2 pi |L|) times the change.  Resonances of
    nutation and precession are listed in `events` with what a crossing does, and not treated.
    docs/averaged.md has the mathematics and limits.
    """

    body: Body
    spin: Spin
    torques: tuple[Torque, ...]

    @arguments({"torque": "give torques="}, "AveragedMotion(body, spin, torques)")
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
        order: int = 1,
    ) -> None:
        refuse_others(body, spin, "AveragedMotion takes a Body, a Spin and torques")
        acting = _torques(torques)
        settings = Settings.checked(
            orbit, passages, least_tilt, tolerance, degree, len(acting), order
        )
        self._begin(MeanTorques(body, acting, spin.epoch, settings.degree), spin, settings)

    @classmethod
    def _of_shared(
        cls, shared: MeanTorques, spin: Spin, settings: Settings, number: int = 0
    ) -> Self:
        """A motion under means that others have too; its number decides its draws."""
        motion = cls.__new__(cls)
        motion._begin(shared, spin, settings, number)
        return motion

    def _begin(self, shared: MeanTorques, spin: Spin, settings: Settings, number: int = 0) -> None:
        """Set the attributes, and find the mean state."""
        body = shared.body
        self._set_all(body=body, spin=spin, torques=shared.torques, axes=shared.axes)
        self._set_all(
            tolerance=settings.tolerance, passages=settings.passages, least_y=settings.least_y
        )
        size, y, region = self.axes.state(spin.angular_velocity)
        ends, edge = (self.least_y, -self.least_y), self.axes.separatrix
        if abs(edge) < FARTHEST:
            # sin^2 of the greatest nutation is p/p_s in SAM, (1 - p)/(1 - p_s) in LAM
            square = math.exp(-self.least_y)
            low, high = (math.log(square + (1.0 + square) * math.exp(x)) for x in (-edge, edge))
            ends = -low, high
        packing = shared.packing(settings.kinds, size, y, region)
        momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ body.tensor)
        self._refuse_strong(packing, np.append(momentum, y), region)
        shift, bend = np.zeros(3), 0.0
        if ends[0] < y < ends[1]:
            shift, bend = _mean_state.corrections(self.axes, body, spin, self.torques, spin.epoch)
        mean = np.append(momentum - shift, y - bend)
        if (mean[3] < edge) != (region < LAM_PLUS):
            mean[3] = y
        self._refuse_strong(packing, mean, region)
        pace = 2.0 * math.pi * float(self.axes.moments[2]) / size
        course = Course(packing, ends, self.tolerance, pace, settings.order)
        self._set_all(start=frozen(mean), start_region=region, packing=packing, _course=course)
        self._set("_tracks", [Track(course, mean, region, sign) for sign in (1.0, -1.0)])
        self._set("_farthest", [0.0, 0.0])
        seed = self.passages if isinstance(self.passages, int) else 0
        draws = [np.random.default_rng((seed, number, k)) for k in range(2)]
        self._set("_draws", draws)

    @staticmethod
    def _refuse_strong(packing: Packing, x: FloatArray, region: int) -> None:
        eps = packing.weakness_of(0.0, x, region)
        if not math.isfinite(eps):
            raise AttitudeError(
                "the mean torque is not finite at the epoch of the spin; check the torques."
            )
        if not eps <= WEAK:
            raise AttitudeError(
                f"the torques are not weak: |N| P/(2 pi L) is {eps:.3g} at the epoch, and means "
                f"need less than {WEAK}. Integrate by TorquedRotation."
            )

    axes: Axes
    least_y: float
    packing: Packing
    start: FloatArray
    start_region: int
    tolerance: float
    passages: Any
    _course: Course
    _tracks: list[Track]
    _farthest: list[float]
    _draws: list[np.random.Generator]

    def __repr__(self) -> str:
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<AveragedMotion: {names}>"

    @property
    def epoch(self) -> Instant:
        """Instant from which its seconds count: that of the spin."""
        return self.spin.epoch

    @property
    def span(self) -> tuple[float, float]:
        """First and last TDB seconds since the epoch that the paths of the torques cover."""
        return self.packing.torques.span

    @property
    def is_averaged(self) -> tuple[bool, ...]:
        """Whether each torque is averaged over the turn of its path."""
        return self.packing.averaged

    def _choose(self, track: Track, crossing: Crossing) -> int:
        odds = crossing.odds
        if isinstance(self.passages, int):
            first, second = odds
            draw = self._draws[0 if track.sign > 0.0 else 1].random()
            return first if draw < odds[first] else second
        return max(odds, key=lambda region: odds[region])

    # ---- Answers

    def _check_span(self, seconds: FloatArray) -> None:
        first, last = self.span
        # spans are rounded inwards; the state at the epoch is known
        begin = min(first, 0.0) if first < _ROUNDED else first
        if seconds.size and (np.min(seconds) < begin or np.max(seconds) > last):
            raise AttitudeError(
                "an epoch lies outside of the paths and fields of the torques, which cover "
                f"{first:.6g} to {last:.6g} s after the epoch of the spin; give a longer path, a "
                "field of one epoch, as IGRF(epoch=...), or other epochs."
            )

    def _extended(self, until: float) -> Track:
        """The track up to seconds `until`, or its end."""
        which = 0 if until >= 0.0 else 1
        track = self._tracks[which]
        track.extend(until, self._choose)
        self._farthest[which] = max(self._farthest[which], abs(until))
        return track

    def at(self, t: Epochs) -> AveragedHistory:
        """The mean states at epochs of any shape; of all branches, (B, ...), for passages="all".

        Raises
        ------
        AttitudeError
            For epochs outside of the paths, or beyond the end of the motion ("no longer weak",
            "too slow for its path"): `reaches` says how far it goes.
        """
        seconds = seconds_of(self.epoch, t)
        self._check_span(seconds)
        if self.passages == "all":
            end = float(seconds.flat[np.argmax(np.abs(seconds))]) if seconds.size else 0.0
            return self._tree(end).at(seconds)
        for farthest, _ in _directions(seconds):
            ended = self._extended(farthest).ended
            if ended is not None and abs(farthest) > abs(ended.seconds):
                raise AttitudeError(
                    f"the motion ends {ended.seconds:.9g} s after the epoch: {ended.kind}. Give "
                    "epochs up to that one, or integrate by TorquedRotation from there."
                )
        states, regions = self._known(seconds.reshape(-1))
        shape = seconds.shape
        return AveragedHistory(
            self.packing, seconds, states.reshape(*shape, 4), regions.reshape(shape)
        )

    def reaches(self, until: Epochs) -> float:
        """TDB seconds of the last epoch on the way to one at which means hold: `until`, or the end.

        Of the branch of `passages`; of the likeliest one for passages="all".
        """
        seconds = second_of(self.epoch, until)
        self._check_span(np.array([seconds]))
        ended = self.ends(seconds)
        return seconds if ended is None else ended.seconds

    def ends(self, until: Epochs) -> AveragedEvent | None:
        """The event that ends the motion on the way to an epoch, or None; as `reaches`."""
        seconds = second_of(self.epoch, until)
        ended = self._extended(seconds).ended
        return None if ended is None or abs(ended.seconds) > abs(seconds) else ended

    def _known(self, seconds: FloatArray) -> tuple[FloatArray, IntArray]:
        """States (T, 4), NaN beyond the end, and regions (T,) at seconds that are integrated."""
        states = np.full((len(seconds), 4), np.nan)
        regions = np.zeros(len(seconds), dtype=np.int64)
        for track in self._tracks:
            chosen = seconds >= 0.0 if track.sign > 0.0 else seconds < 0.0
            if track.ended is not None:
                chosen &= np.abs(seconds) <= abs(track.ended.seconds)
            if np.any(chosen):
                states[chosen], regions[chosen] = track.states(seconds[chosen])
        return states, regions

    def _count_passages(self, until: float) -> int:
        """Passages of the separatrix up to seconds that are integrated."""
        return len(self._tracks[0 if until >= 0.0 else 1].passages(until))

    @property
    def events(self) -> tuple[AveragedEvent, ...]:
        """Events up to the farthest epochs asked so far, in the order of time.

        Passages of the separatrix, uniform rotation reached and left, resonances up to the order of
        `attitude.averaged.HIGHEST`, the end.
        """
        events: list[AveragedEvent] = []
        for track, farthest in zip(self._tracks, self._farthest, strict=True):
            if farthest == 0.0:
                continue
            until = farthest * track.sign
            self._extended(until)
            events += track.happened(until)
            events += _resonances.crossed(track, until)
        return tuple(sorted(events, key=lambda event: event.seconds))

    def branches(
        self,
        until: Epochs | None = None,
        *,
        least_kick: Real | None = None,
        most: int = _MOST_BRANCHES,
    ) -> Branches:
        """All branches of the motion up to an epoch, the likeliest first.

        Each has odds of at least 0.256 over their largest number, 1e-3 of 256: their odds add up
        to what they cover.

        Parameters
        ----------
        until : epoch, optional
            By default the farthest one asked so far.
        least_kick : float, optional
            Branch too at resonances of nutation and precession whose `scatter` of y is at least
            this and which do not capture: into four quarters of their phases, each with its mean
            kick, up to a quarter of `most`.  `Branch.scatter` has what is left of the kicks.
        most : int
            Branches at most; each takes some 4 ms.
        """
        if until is None:
            forward, backward = self._farthest
            end = forward if forward >= backward else -backward
            if end == 0.0:
                raise AttitudeError("no epoch has been asked; give one, as in branches(until).")
        else:
            end = second_of(self.epoch, until)
        self._check_span(np.array([end]))
        least = math.inf if least_kick is None else validation.positive(least_kick, "least_kick")
        return self._tree(end, least, validation.count(most, "most"))

    def _tree(
        self, end: float, least_kick: float = math.inf, most: int = _MOST_BRANCHES
    ) -> Branches:
        """The branches up to seconds `end`."""
        sign = 1.0 if end >= 0.0 else -1.0
        which = 0 if sign > 0.0 else 1
        self._farthest[which] = max(self._farthest[which], abs(end))
        growing = [Track(self._course, self.start, self.start_region, sign)]
        ended: list[Track] = []
        weak: set[_resonances.Weak] = set()
        while growing:
            # the likeliest first, so that those left out are the least likely
            track = growing.pop(int(np.argmax([one.odds for one in growing])))
            track.extend(end, lambda one, crossing: None)
            count = len(growing) + len(ended) + 1
            reached = sign * min(abs(end), abs(float(track.clock[0])))
            split: list[Track] = []
            if math.isfinite(least_kick) and count < _SPLIT_SHARE * most:
                split = _resonances.split(track, reached, least_kick, weak)
            if split:
                growing += split
            elif track.waits is None or track.reaches(end):
                ended.append(track)
            else:
                least_odds = _LEAST_ODDS / most if count < most else math.inf
                growing += _passed(track, track.waits, least_odds)
        ended.sort(key=lambda track: -track.odds)
        return Branches([self._branch(track, end) for track in ended], end)

    def _branch(self, track: Track, end: float) -> Branch:
        passages = track.passages(end)
        regions = (REGIONS[self.start_region], *(event.after for event in passages))
        until = end
        if track.ended is not None and (track.ended.seconds - end) * track.sign < 0.0:
            until = track.ended.seconds
        kicks = tuple(float(kick[3]) for _, kick in track.kicks)
        return Branch(track.odds, regions, kicks, tuple(track.happened(end)), until, track)

    def error_estimate(self, t: Epochs) -> FloatArray:
        """The error of the mean momentum to expect, a share of |L|, at epochs of shape S.

        The sum over steps of |change of L|/|L| times eps = |N| P/(2 pi |L|), the order of
        first-order means; where torques are averaged over turns T of their paths,
        |N| T/(2 pi |L|) is added to eps, and once to the sum, since the place on the path at the
        epoch is averaged too.  Harmonics beyond the degree add 0.25/degree^2 of |N| dt/|L| of
        light and flow, a bound for meshes of asteroids.  Resonances and the branch that a passage
        takes are left out; `check` measures.
        """
        seconds = seconds_of(self.epoch, t)
        self._check_span(seconds)
        out = np.zeros(seconds.shape)
        for farthest, chosen in _directions(seconds):
            out[chosen] = self._extended(self.reaches(farthest)).error_to(seconds[chosen])
        return out

    def plot(self, path: FilePath | None = None, *, until: Epochs, title: str | None = None) -> Any:
        """A figure (of matplotlib) from the epoch of the spin to another one, or to the end.

        Its panels, `path` and `title` are those of `AveragedHistory.plot`.
        """
        from attitude.averaged import _plots

        return _plots.of_motion(self, until, path, title)

    def through(
        self, event: AveragedEvent, phases: tuple[Real, Real] | None = None, seed: int = 0
    ) -> AveragedMotion:
        """The mean motion behind a resonance, through which `TorquedRotation` takes the full one.

        Parameters
        ----------
        event : AveragedEvent
            A resonance of `events`.
        phases : (float, float), optional
            Of nutation and precession before it, in turns; drawn without them.
        seed : int
            Of the draw.

        Returns
        -------
        AveragedMotion
            Its epoch lies behind the resonance.

        Raises
        ------
        AttitudeError
            For another event, one that begins before the epoch, torques by functions of seconds
            since the epoch of the spin, and where the motion is still held after four times the
            time in which means cross the resonance.
        """
        is_resonance = isinstance(event, AveragedEvent) and event.kind == "resonance"
        if not is_resonance or not event.lasts > 0.0:
            raise AttitudeError(
                f"event is {event}; give one of the resonances of events, which has terms that "
                "do not average out."
            )
        sign = 1.0 if event.seconds >= 0.0 else -1.0
        begin = event.seconds - sign * event.lasts
        if begin * sign < 0.0:
            raise AttitudeError(
                f"the resonance begins {begin:.6g} s after the epoch of the spin, on its other "
                "side; integrate by TorquedRotation from the epoch."
            )
        if any(torque.is_of_seconds for torque in self.torques):
            raise AttitudeError(
                "a torque is a function of seconds since the epoch of the spin, and the motion "
                "behind the resonance has an epoch of its own; give a path in place of a function."
            )
        before = self.at(begin)
        if before.seconds.shape:
            raise AttitudeError('passages is "all"; choose one branch, or passages="likeliest".')
        free, place = self._osculating(before, phases, seed), float(self.at(event.seconds).y)
        step = _FINE / float(np.linalg.norm(free.spin.angular_velocity))
        full = TorquedRotation(self.body, free.spin, self.torques, step=step)
        for count in range(2, 6):
            history = full.at(sign * count * event.lasts)
            epoch = self.epoch.after(begin + sign * count * event.lasts)
            spin = Spin(epoch, history.wxyz, history.angular_velocity, frame="icrf")
            if abs(self.axes.state(spin.angular_velocity)[1] - place) > event.width:
                return self._from(spin)
        raise AttitudeError(
            f"the resonance has held the motion for {4.0 * event.lasts:.6g} s, and means cannot "
            "follow it there; integrate by TorquedRotation, or try other phases."
        )

    def _osculating(
        self, mean: AveragedHistory, phases: tuple[Real, Real] | None, seed: int
    ) -> FreeRotation:
        """The free rotation of a state that has a mean state, to first order."""
        if phases is None:
            one, two = validation.generator(seed).random(2)
            phases = float(one), float(two)
        shift, bend = _mean_state.corrections(
            self.axes,
            self.body,
            mean.free_rotation(phases).spin,
            self.torques,
            self.epoch,
            float(mean.seconds),
        )
        state = np.append(mean.momentum + shift, mean.y + bend)
        return AveragedHistory(self.packing, mean.seconds, state, mean.region).free_rotation(phases)

    def _from(self, spin: Spin) -> AveragedMotion:
        """A mean motion from another state, with the settings of this one."""
        return AveragedMotion(
            self.body,
            spin,
            self.torques,
            orbit=["averaged" if averaged else "followed" for averaged in self.is_averaged],
            passages=self.passages,
            least_tilt=math.atan(math.exp(0.5 * self.least_y)),
            tolerance=self.tolerance,
            degree=self.packing.torques.degree,
            order=self._course.order,
        )

    def check(self, turns: Real = 1e3) -> dict[str, float]:
        """Compare with `TorquedRotation` over the first turns of the body.

        The steps of the full motion are halved until that changes its state by a tenth of the
        difference that is found, or four times: light on facets needs the most.

        Returns
        -------
        dict
            "seconds" of the comparison; "size", "energy" and "pole": differences of |L| and energy
            as shares of themselves and of the pole in rad; "size change", "energy change", "pole
            change": what they changed by; "size error", "energy error", "pole error": what the last
            halving changed, a bound of the errors of the full motion; "step" of it in s; "odds"
            of the branch that comes nearest, which is the one compared.
        """
        seconds = float(validation.positive(turns, "turns") * self._course.pace)
        step = _COARSEST / float(np.linalg.norm(self.spin.angular_velocity))
        tree = self._tree(seconds)
        truth = self._of_full_motion(seconds, step)
        for _ in range(_HALVINGS):
            step, coarser = 0.5 * step, truth
            truth = self._of_full_motion(seconds, step)
            errors = _differences(truth, coarser)
            gaps = tree.at(seconds).momentum - truth.momentum
            nearest = tree[int(np.nanargmin(np.sum(gaps**2, axis=-1)))]
            differences = _differences(truth, nearest.at(seconds))
            if all(
                abs(errors[name]) <= max(_CLOSE * abs(differences[name]), _ROUNDING)
                for name in errors
            ):
                break
        start = AveragedHistory(
            self.packing, np.array(0.0), self.start, np.array(self.start_region)
        )
        result = {"seconds": seconds, "step": step, "odds": nearest.odds, **differences}
        for name, change in _differences(truth, start).items():
            result[f"{name} change"] = change
            result[f"{name} error"] = abs(errors[name])
        return result

    def _of_full_motion(self, seconds: float, step: float) -> AveragedHistory:
        """The mean state at seconds of a `TorquedRotation` with steps of so many seconds."""
        full = TorquedRotation(self.body, self.spin, self.torques, step=step)
        history = full.at(seconds)
        spin = Spin(
            epoch=self.epoch.after(seconds),
            wxyz=history.wxyz,
            angular_velocity=history.angular_velocity,
            frame="icrf",
        )
        _, y, region = self.axes.state(spin.angular_velocity)
        shift, bend = _mean_state.corrections(
            self.axes, self.body, spin, self.torques, self.epoch, seconds
        )
        momentum = quaternion.rotate(spin.wxyz_icrf, spin.angular_velocity @ self.body.tensor)
        state = np.append(momentum - shift, y - bend)
        return AveragedHistory(self.packing, np.array(seconds), state, np.array(region))


def _directions(seconds: FloatArray) -> Iterator[tuple[float, BoolArray]]:
    """The farthest of seconds from the epoch on, and before it, and which lie on that side."""
    for sign, chosen in ((1.0, seconds >= 0.0), (-1.0, seconds < 0.0)):
        if np.any(chosen):
            yield sign * float(np.max(np.abs(seconds[chosen]))), chosen


def _passed(track: Track, crossing: Crossing, least_odds: float) -> list[Track]:
    """The track beyond the separatrix: in one region, or in both if both are likely enough."""
    tracks, odds = [track], crossing.odds
    chosen, other = sorted(odds, key=lambda region: -odds[region])
    if track.odds * odds[other] >= least_odds:
        tracks.append(track.branched())
        tracks[1].odds *= odds[other]
        tracks[1].pass_to(other, crossing)
    track.odds *= odds[chosen]
    track.pass_to(chosen, crossing)
    return tracks


def _differences(truth: AveragedHistory, other: AveragedHistory) -> dict[str, float]:
    """How far another state is off: |L| and energy, as shares of the truth, and the pole in rad."""
    across = np.cross(other.pole, truth.pole)
    return {
        "size": float(other.size / truth.size - 1.0),
        "energy": float(other.energy / truth.energy - 1.0),
        "pole": float(np.sqrt(across @ across)),
    }


@dataclass(frozen=True)
class Settings:
    """What the arguments of `AveragedMotion` say."""

    kinds: list[str]  # "auto", "averaged" or "followed" of each torque
    passages: Any
    least_y: float  # 2 ln tan of the least tilt
    tolerance: float
    degree: int
    order: int = 1

    @classmethod
    def checked(
        cls,
        orbit: Any,
        passages: Any,
        least_tilt: Any,
        tolerance: Any,
        degree: Any,
        count: int,
        order: Any = 1,
    ) -> Settings:
        """The settings of arguments, for a count of torques."""
        step = validation.positive(tolerance, "tolerance")
        if not 1e-12 <= step <= 1e-2:
            raise AttitudeError(f"tolerance is {step!r}; give one from 1e-12 to 1e-2.")
        tilt = validation.positive(least_tilt, "least_tilt", unit="rad")
        if not 1e-9 <= tilt < 0.5:
            raise AttitudeError(f"least_tilt is {tilt:.3g} rad; give one from 1e-9 to 0.5 rad.")
        edge = 2.0 * math.log(math.tan(tilt))
        if isinstance(passages, str):
            passages = validation.one_of(passages, "passages", ("likeliest", "all"))
        elif isinstance(passages, int) and passages >= 0:
            passages = validation.count(passages, "passages", 0)
        else:
            raise AttitudeError(
                f'passages is {validation.shown(passages)}; give "likeliest", "all", or a whole '
                "number from 0 on, the seed of a draw."
            )
        degree = validation.count(degree, "degree", 2, 64)
        kinds, order = checked_orbits(orbit, count), validation.count(order, "order")
        if order > 2:
            raise AttitudeError(f"order is {order}; give 1 or 2.")
        if order == 2 and "averaged" in kinds:
            raise AttitudeError(
                "order is 2, and a torque is averaged over the turn of its path, which errs by "
                'more than that gains; give orbit="followed", or order=1.'
            )
        if order == 2:
            kinds = ["followed"] * count
        return cls(kinds, passages, edge, step, degree, order)


def seconds_of(epoch: Instant, t: Epochs) -> FloatArray:
    """Epochs as TDB seconds since that of the spin."""
    seconds = np.asarray(_inputs.seconds_since(epoch, t).rounded)
    if not np.all(np.isfinite(seconds)):
        raise AttitudeError("an epoch is not finite; give finite epochs.")
    return seconds


def second_of(epoch: Instant, until: Epochs) -> float:
    """One epoch as TDB seconds since that of the spin."""
    seconds = seconds_of(epoch, until)
    if seconds.shape:
        raise AttitudeError(f"until has shape {seconds.shape}; give one epoch.")
    return float(seconds)
