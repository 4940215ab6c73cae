"""`Ensemble`: many freely rotating bodies, each evaluated at its own or at shared epochs.

`EnsembleHistory`: their attitudes.  `ArcsEnsemble`, `TorquedEnsemble`: the same states with
impulses, and under torques.  Each of the four names the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self, cast

import numpy as np

from attitude import catalog, frames
from attitude._solver import regime as solver_regime
from attitude._solver import sensitivities, states
from attitude._solver.march_layout import OMEGA, STATE_ENTRIES, WXYZ
from attitude._solver.regime import Mode, Regime
from attitude._solver.states import Evaluation, Results, Solved, States
from attitude._support import markup, pairs, validation
from attitude._support.arrays import Immutable, frozen, read_only
from attitude._support.blocks import ProgressBar, in_blocks
from attitude._support.pairs import Seconds
from attitude._textfiles.lines import prefixed
from attitude.averaged._ensemble import AveragedEnsemble
from attitude.ensemble import _arcs, _light, _members, _quantities, _tables
from attitude.ensemble._evaluation import MemberGrid, MemberRows
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.formats import tables
from attitude.frames import quaternion
from attitude.light_curve._magnitudes import SUN_V
from attitude.motions import _published
from attitude.motions._body import Body, tensors_of
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._history import AttitudeHistory
from attitude.motions._spin import Spin
from attitude.torques import _schemes
from attitude.torques._arcs import Arcs, known_changes
from attitude.torques._system import System
from attitude.torques._torqued import TorquedRotation, whole_steps

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from astropy.table import QTable
    from astropy.time import Time
    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import Epochs, FilePath, FloatArray, IntArray, Real, Reals
    from attitude.ensemble._members import Inertia
    from attitude.light_curve._visibility import Visibility
    from attitude.scattering._law import Law
    from attitude.scene._scene import Scene
    from attitude.torques._arcs import Change
    from attitude.torques._schemes import Scheme
    from attitude.torques._torque import Torque


# The attributes that are pickled.
_KEPT = (
    "wxyz",
    "angular_velocity",
    "frame",
    "names",
    "on_error",
    "_inertia",
    "_members",
    "_low",
    "_start",
    "_bad",
)


# ---- Percentiles, histograms and coverage of quantities, without an array of members and epochs

# Numbers held at a time: 8 MB for each thread.
_HELD = 1 << 20
# Epochs that are evaluated together at least, since each part costs a set-up of all members.
_FEWEST = 16
# Members whose constants, 34 MB, are kept for several parts.
_MOST_KEPT = 35_000
# Members that are evaluated together: their attitudes stay in the second-level cache.
_FEW = 256


class Coverage(NamedTuple):
    """How long, and with what gaps, a quantity of each member is within its bounds.

    fraction: (N,), of the span of epochs: intervals with both ends within count whole, with one end
        half.
    longest_gap: (N,), s; the longest time between two epochs within that follow each other, or
        between such an epoch and an end of the span; the whole span where none is within.
    """

    fraction: FloatArray
    longest_gap: FloatArray


def _percentiles(values: FloatArray, percentages: FloatArray, finished: Any) -> FloatArray:
    """Percentiles (P, T) of rows (T, N), which are reordered."""
    unknown = np.isnan(values).any(axis=1)
    if unknown.any():
        out = np.full((len(percentages), len(values)), np.nan)
        out[:, ~unknown] = _percentiles(values[~unknown], percentages, finished)
        for k in np.flatnonzero(unknown):
            row = values[k][~np.isnan(values[k])]
            if len(row):
                out[:, [k]] = _percentiles(row[None], percentages, finished)
        return out
    place = percentages / 100.0 * (values.shape[1] - 1)
    below = np.floor(place).astype(np.int64)
    ranks = np.concatenate([below, np.minimum(below + 1, values.shape[1] - 1)])
    # the numbers of two members, of which a quantity may be known by another that grows with it
    lower, upper = np.split(finished(_of_ranks(values, ranks)), 2, axis=1)
    values_there: FloatArray = lower + (upper - lower) * (place - below)
    return values_there.T


def _of_ranks(values: FloatArray, ranks: IntArray) -> FloatArray:
    """The numbers (T, R) of given ranks in rows (T, N): a third of the time of a partition."""
    from attitude.ensemble._quantities import BINS, candidates

    out = np.empty((len(values), len(ranks)))
    counts, wanted = np.empty(BINS, dtype=np.int64), np.empty(BINS, dtype=np.int64)
    ranked, places = np.empty(values.shape[1] + 1), np.empty(len(ranks), dtype=np.int64)
    for k, row in enumerate(values):
        count = candidates(row, ranks, counts, wanted, ranked, places)
        out[k] = np.sort(ranked[:count])[places]
    return out


def _covered(within: Any, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fraction of the span and longest gap (n,) of flags (n, T) at ascending times (1 or n, T)."""
    steps, span = np.diff(times), times[:, -1] - times[:, 0]
    ends = 0.5 * (within[:, 1:].astype(np.float64) + within[:, :-1])
    fraction = np.sum(ends * steps, axis=1) / span
    # The last time within up to each epoch, and the first one from it on.
    first, last = times[:, :1], times[:, -1:]
    seen = np.where(within, times, first)
    before = np.maximum.accumulate(seen, axis=1)
    gap = np.max(times[:, 1:] - before[:, :-1], axis=1, where=within[:, 1:], initial=0.0)
    final = np.where(within.any(axis=1), last[:, 0] - before[:, -1], span)
    return fraction, np.maximum(gap, final)


# ---- The ensemble


class Ensemble(Immutable):
    """The free rotations of N bodies, as arrays.

    Parameters
    ----------
    body : Body, or N of them
        Or moments=, or tensors=.
    wxyz : (4,) or (N, 4) array_like
        Quaternions from body axes to `frame`, scalar first; of any length.
    angular_velocity : (3,) or (N, 3) array_like
        rad/s over the body axes, or a Quantity.
    epoch : one epoch, or N
        As for `Spin`: ISO text in UTC, astropy or skyfield Time, datetime, datetime64.
    frame : str
        As for `Spin`.
    names : N of str, optional
        Names of the members, which differ from each other; blanks at their ends are left out.
    moments : (3,) or (N, 3) array_like
        Principal moments about the body axes, kg m2.
    tensors : (3, 3) or (N, 3, 3) array_like
        Inertia tensors in body axes, kg m2; their doubles are taken as exact, as by `Body`.
    relative : bool
        True if the unit of moments or tensors is unknown.
    on_error : "raise" or "nan"
        "nan" keeps members with a state that no body has: their attitudes, periods, energy and
        brightness are NaN, their mode is -1; and epochs beyond the reach of a member give NaN.

    Attributes
    ----------
    wxyz : (N, 4) array
        As given.
    angular_velocity : (N, 3) array
        rad/s over the body axes.
    names : (N,) array of str, or None
    frame, on_error : str

    Raises
    ------
    AttitudeError
        For members that are not physical, the first of which is named; arrays of different
        lengths; names given twice, empty names.

    Notes
    -----
    Attitudes have the bits of `FreeRotation.at`, whatever the ensemble, the order of rows and the
    number of threads.  Constants of a member are computed anew in each call, in 1.1 us, and are
    not kept.  benchmarks/ensembles.py measures the cost.

    >>> tops = Ensemble(
    ...     moments=[(10, 20, 26), (1, 2, 2.5)], wxyz=(1, 0, 0, 0),
    ...     angular_velocity=[(1, 15, 1), (0.2, 0.1, 0)], epoch="2026-01-01",
    ... )
    >>> tops.at([0.0, 30.0, 60.0]).wxyz.shape
    (2, 3, 4)
    >>> tops.at([60.0, 5.0, 6.0], member=[0, 1, 1]).wxyz[0].round(6)
    array([ 0.006059,  0.14546 , -0.019617,  0.989151])
    >>> tops[0].mode.name, tops.period_psi.round(6)
    ('SHORT_AXIS', array([ 2.347113, 55.168519]))
    """

    wxyz: FloatArray
    angular_velocity: FloatArray
    frame: str
    names: NDArray[np.str_] | None
    on_error: str

    def __init__(
        self,
        body: Body | Sequence[Body] | None = None,
        wxyz: Reals | None = None,
        angular_velocity: Reals | None = None,
        epoch: Epochs | None = None,
        frame: str = "icrf",
        names: Sequence[str] | None = None,
        *,
        moments: Reals | None = None,
        tensors: Reals | None = None,
        relative: bool = False,
        on_error: str = "raise",
    ) -> None:
        self._inertia: Inertia
        self._members: States
        self._low: FloatArray | None
        self._start: FloatArray
        self._bad: IntArray
        if wxyz is None or angular_velocity is None:
            missing = "wxyz" if wxyz is None else "angular_velocity"
            raise AttitudeError(
                f"{missing} is missing; give one row, or one for each member; of motions use "
                "Ensemble.of([FreeRotation(body, spin), ...])."
            )
        relative = validation.flag(relative, "relative")
        rates = _members.rows(angular_velocity, "angular_velocity", (3,), "rad/s")
        attitudes = _members.rows(wxyz, "wxyz", (4,), None)
        start = _members.of_members(epoch)
        inertias = [argument for argument in (body, moments, tensors) if argument is not None]
        if len(inertias) != 1:
            raise AttitudeError(
                "an Ensemble takes one of body=, moments= (N, 3) and tensors= (N, 3, 3)."
            )
        if moments is not None:
            inertia = _members.of_arrays(moments, "moments", (3,), relative)
        elif body is not None:
            inertia = _members.of_bodies(
                [body] if isinstance(body, Body) else list(_members.listed(body))
            )
        else:
            assert tensors is not None
            inertia = _members.of_arrays(tensors, "tensors", (3, 3), relative)
        argument = {2: "moments", 3: "tensors"}[inertia.array.ndim] if body is None else "body"
        sizes = {
            argument: len(inertia.array),
            "wxyz": len(attitudes),
            "angular_velocity": len(rates),
            "epoch": start.shape[1],
        }
        count = _members.count(sizes, names)
        rates = np.broadcast_to(rates, (count, 3))
        attitudes = np.broadcast_to(attitudes, (count, 4))
        self._fill(
            inertia, attitudes, None, rates, start, frame=frame, names=names, on_error=on_error
        )

    def _fill(
        self,
        given_inertia: _members.Given,
        wxyz: FloatArray,
        low: FloatArray | None,
        rates: FloatArray,
        start: FloatArray,
        *,
        frame: str,
        names: Any,
        on_error: str,
    ) -> None:
        """Set the attributes of members, and check them."""
        self._set("on_error", validation.one_of(on_error, "on_error", ("raise", "nan")))
        self._set("frame", frames.known(frame))
        self._set_all(_start=frozen(start), _low=low)
        self._set("names", _members.known_names(names, len(wxyz)))
        attitude = _members.to_icrf(self.frame, wxyz, low)
        inertia, omega, differences = given_inertia.resolved(rates, on_error == "raise")
        states = States(inertia.moments, inertia.principal, omega, differences, *attitude)
        self._set_all(_inertia=inertia, _members=states)
        self._set("wxyz", frozen(np.ascontiguousarray(wxyz)))
        self._set("angular_velocity", frozen(np.ascontiguousarray(rates)))
        self._check()

    def _check(self) -> None:
        """Find the members that are not physical, and refuse them unless `on_error` is "nan"."""
        self._set("_bad", frozen(self._members.faults()))
        if self.on_error == "raise" and len(self._bad):
            first = int(self._bad[0])
            others = len(self._bad) - 1
            more = f" Of the {len(self)} members {others} more are wrong." if others else ""
            raise AttitudeError(f"{self.label(first)}: {self._members.fault(first)}{more}")

    # ---- Construction

    @classmethod
    def of(
        cls, motions: Iterable[FreeRotation | str] | str, names: Sequence[str] | None = None
    ) -> Self:
        """The ensemble of motions.

        Parameters
        ----------
        motions : iterable of FreeRotation, or of names in the catalogue
            Their frames are those of the spins; several frames become ICRF.  Covariances of spins
            are left out.
        names : sequence of str, optional

        Raises
        ------
        AttitudeError
            For other objects, and for no motions.
        """
        listed = [motions] if isinstance(motions, str) else _members.listed(motions)
        all_motions = [
            catalog.entry(motion).motion()
            if isinstance(motion, str)
            else validation.instance(motion, FreeRotation, f"motion {k}", "FreeRotations")
            for k, motion in enumerate(listed)
        ]
        if not all_motions:
            raise AttitudeError("no motions are given; give at least one FreeRotation.")
        bodies = [motion.body for motion in all_motions]
        inertia = _members.of_bodies(bodies[:1] if all(b is bodies[0] for b in bodies) else bodies)
        spins = [motion.spin for motion in all_motions]
        frame = spins[0].frame if len({spin.frame for spin in spins}) == 1 else "icrf"
        turned = any(spin.frame != frame for spin in spins)
        wxyz = np.array([spin.wxyz_icrf if turned else spin.wxyz for spin in spins])
        low = np.array([(s.wxyz_icrf_as_pairs if turned else s.wxyz_as_pairs)[:, 1] for s in spins])
        low[[not spin.is_rounded for spin in spins]] = 0.0
        rates = np.array([spin.angular_velocity for spin in spins])
        start = np.array([[s.epoch.seconds, s.epoch.low] for s in spins]).T.copy()
        if np.all(start == start[:, :1]):
            start = start[:, :1].copy()
        ensemble = cls.__new__(cls)
        second = low if low.any() else None
        ensemble._fill(
            inertia, wxyz, second, rates, start, frame=frame, names=names, on_error="raise"
        )
        return ensemble

    @classmethod
    def from_periods(
        cls,
        body: Body | None = None,
        *,
        epoch: Epochs,
        pole: Reals,
        phi0: Reals,
        mode: Any = None,
        convention: Any = None,
        P_psi: Reals | None = None,
        P_phi: Reals | None = None,
        psi0: Reals | None = None,
        theta_branch: Any = None,
        P: Reals | None = None,
        frame: str = "ecliptic",
        moments: Reals | None = None,
        relative: bool = True,
        names: Sequence[str] | None = None,
        on_error: str = "raise",
    ) -> Self:
        """Members from published spin states, each as by `Spin.from_periods`.

        Parameters
        ----------
        body : Body
            Of all members; or moments=.
        moments : (3,) or (N, 3) array_like
            Principal moments about the body axes.
        relative : bool
            Whether the unit of the moments is unknown; of a body, its own.
        epoch, pole, phi0, mode, convention, P_psi, P_phi, psi0, theta_branch, P
            As in `Spin.from_periods`; each one value, or one for each member: pole (N, 2).  P is
            NaN for members that tumble; P_psi, P_phi and psi0 are NaN for relaxed rotators.
        frame, names, on_error
            As in `Ensemble`.

        Raises
        ------
        AttitudeError
            For the first member that no motion has, with its possible range, unless
            on_error="nan"; and as `Ensemble`.
        """
        if (body is None) == (moments is None):
            raise AttitudeError("from_periods takes either body= or moments= (N, 3).")
        known = names
        if names is not None:
            known = [str(name) for name in np.asarray(names).ravel().tolist()]
        states = _published.states_from_periods(
            body if moments is None else moments,
            pole=pole,
            phi0=phi0,
            mode=mode,
            convention=convention,
            P_psi=P_psi,
            P_phi=P_phi,
            psi0=psi0,
            theta_branch=theta_branch,
            P=P,
            names=known,
            on_error=on_error,
        )
        return cls(
            body,
            states.wxyz,
            states.angular_velocity,
            epoch,
            frame,
            known,
            moments=moments,
            relative=relative if body is None else False,
            on_error=on_error,
        )

    @classmethod
    def from_table(
        cls,
        table: Any,
        *,
        frame: str | None = None,
        relative: bool | None = None,
        on_error: str = "raise",
    ) -> Self:
        """Members from the rows of a table or a file.

        Parameters
        ----------
        table : astropy QTable or Table, pandas DataFrame, pyarrow Table, mapping, or file name
            One row is one member; files end in .parquet, .ecsv, .fits or .csv.  Columns:

            ``name``     optional
            ``epoch``    a Time column, dates as text (UTC), or ``epoch_seconds`` and
            ``epoch_low``: TDB seconds past J2000 in two doubles
            ``wxyz``     or ``w, x, y, z``: body to `frame`
            ``angular_velocity``  or ``omega_x, omega_y, omega_z``: rad/s over the body axes
            ``moments``  or ``moment_x, moment_y, moment_z``: kg m2, about the body axes
            ``tensor``   or ``tensor_xx, tensor_xy, ... tensor_zz``: in place of the moments

            or those of a survey's simulation, of ellipsoids: ``spin_epochMJD_TDB``, ``ObjID``,
            ``axis_a``, ``pole_lon_deg``, ``period_h`` ...; see `attitude.survey`
        frame, relative : optional
            By default those of the meta data of the table, else "icrf" and False; of a survey's
            columns "ecliptic" and True.
        on_error
            As in `Ensemble`.

        Raises
        ------
        AttitudeError
            For columns that are missing or cannot be read, and as `Ensemble`.
        """
        origin = _tables.origin_of(table)
        data = table if origin is None else tables.columns_of(origin)
        origin = origin or "the table"
        columns, meta = _tables.columns_of(data, origin)
        unknown = bool(meta.get("relative", False)) if relative is None else relative
        arguments = _tables.arguments(
            columns, validation.flag(unknown, "relative"), origin, on_error
        )
        axes = str(meta.get("frame", "icrf")) if frame is None else frame
        for name, value in (("frame", frame), ("relative", relative)):
            if name in arguments and value not in (None, arguments[name]):
                raise AttitudeError(
                    f"{origin} has the columns of a survey, whose {name} is {arguments[name]!r}, "
                    f"not {value!r}; leave {name} out."
                )
        low = arguments.pop("low", None)
        with prefixed(origin):
            ensemble = cls(**{"frame": axes, "relative": unknown, **arguments}, on_error=on_error)
        return ensemble if low is None else ensemble._with_low(low)

    @classmethod
    def sample(
        cls,
        motion: FreeRotation,
        count: int,
        seed: int | np.random.Generator = 0,
        *,
        covariance: Reals | Mapping[str, Reals] | None = None,
        distributions: Mapping[str, Any] | None = None,
    ) -> Self:
        """Members drawn about a motion.

        Parameters
        ----------
        motion : FreeRotation
        count : int
            0 or more.
        seed : int or numpy Generator
        covariance : (9, 9) or (6, 6) array_like, or mapping, optional
            As in `Spin`, over the axes of the spin's frame; by default that of the spin.
        distributions : mapping, optional
            In place of a covariance: by name a function of (generator, n) or an object with
            ``rvs(size=, random_state=)``, such as of scipy.stats, that draws n rows of

            ``attitude``   rotation vectors (n, 3), rad, over the axes of the spin's frame
            ``wxyz``       attitudes (n, 4) in the frame, in place of `attitude`
            ``angular_velocity``  (n, 3), rad/s over the body axes
            ``moments``    (n, 3) principal moments

            What is not named is that of the motion.

        Returns
        -------
        Ensemble
            Its frame is "icrf".  Draws whose moments are no body's are drawn anew.

        Raises
        ------
        AttitudeError
            Without a covariance and distributions, for draws of other shapes, and if 9 of 10 draws
            are no body's moments.
        """
        validation.instance(motion, FreeRotation, "motion", "a FreeRotation")
        number = validation.count(count, "count", 0)
        if covariance is not None and distributions is not None:
            raise AttitudeError("covariance and distributions are both given; give one of them.")
        drawn = _tables.drawn(motion, number, seed, covariance, distributions)
        body = motion.body
        shared: dict[str, Any] = {
            "epoch": motion.spin.epoch,
            "wxyz": drawn.wxyz,
            "angular_velocity": drawn.rates,
        }
        if drawn.moments is None:
            return cls(body, **shared)
        if body.has_given_axes:
            return cls(moments=drawn.moments, relative=body.relative, **shared)
        tensors = tensors_of(drawn.moments, body.principal_axes)
        return cls(tensors=tensors, relative=body.relative, **shared)

    @classmethod
    def concatenated(cls, ensembles: Iterable[Self]) -> Self:
        """The members of several ensembles, one after the other; also ``first + second``.

        Raises
        ------
        AttitudeError
            For other objects, no ensembles, several frames, names of some of them only, and
            relative moments beside moments in kg m2.
        """
        parts = list(_members.listed(ensembles))
        for other in parts:
            if not isinstance(other, Ensemble):
                raise AttitudeError(f"{validation.shown(other)} is no Ensemble; give ensembles.")
        if not parts:
            raise AttitudeError("no ensembles are given; give at least one.")
        if len({other.frame for other in parts}) > 1:
            named = ", ".join(sorted({other.frame for other in parts}))
            raise AttitudeError(f"the ensembles have the frames {named}; give ensembles of one.")
        if len({other.names is None for other in parts}) > 1:
            raise AttitudeError("only some of the ensembles have names; give names to all or none.")
        counts = [len(other) for other in parts]
        first = np.cumsum([0, *counts[:-1]])
        wrong = np.concatenate([other._bad + at for other, at in zip(parts, first, strict=True)])
        names = None if parts[0].names is None else np.concatenate([other.names for other in parts])
        return cls._of(
            wxyz=np.concatenate([other.wxyz for other in parts]),
            angular_velocity=np.concatenate([other.angular_velocity for other in parts]),
            frame=parts[0].frame,
            names=_members.known_names(names, sum(counts)),
            on_error="nan" if any(other.on_error == "nan" for other in parts) else "raise",
            _inertia=_members.joined_inertia([other._inertia for other in parts], counts),
            _members=states.joined([other._members for other in parts]),
            _low=states.joined_rows([(other._low, other.wxyz) for other in parts]),
            _start=_members.joined_epochs([other._start for other in parts], counts),
            _bad=wrong,
        )

    @classmethod
    def _of(cls, **values: Any) -> Self:
        """An ensemble with given attributes, which are those of checked members."""
        ensemble = cls.__new__(cls)
        ensemble.__setstate__(values)
        return ensemble

    def _with_low(self, low: FloatArray) -> Self:
        """The same members, whose attitudes of unit length have second doubles (N, 4)."""
        if not low.any():
            return self
        copy, attitude = self[:], _members.to_icrf(self.frame, self.wxyz, low)
        copy._set("_low", frozen(low))
        copy._set("_members", replace(self._members, wxyz=attitude[0], low=attitude[1]))
        return copy

    # ---- Members

    def __len__(self) -> int:
        return len(self.wxyz)

    def __iter__(self) -> Iterator[FreeRotation]:
        return map(self.__getitem__, range(len(self)))

    def __getitem__(self, index: Any) -> Any:
        """A FreeRotation for a number or a name; an Ensemble for a slice, mask or index array."""
        if isinstance(index, (str, int, np.integer)) and not isinstance(index, bool):
            return self._member(self.number(index if isinstance(index, str) else int(index)))
        which = self._chosen(index)
        numbers = np.arange(len(self))[which]
        return self._of(
            wxyz=self.wxyz[which],
            angular_velocity=self.angular_velocity[which],
            frame=self.frame,
            names=None if self.names is None else self.names[which],
            on_error=self.on_error,
            _inertia=self._inertia.taken(which),
            _members=self._members.taken(which),
            _low=None if self._low is None else self._low[which],
            _start=self._start if self._start.shape[1] == 1 else self._start[:, which],
            _bad=np.flatnonzero(np.isin(numbers, self._bad)) if len(self._bad) else self._bad,
        )

    def _chosen(self, index: Any) -> Any:
        """A slice, or an array of numbers, of members."""
        if isinstance(index, slice):
            return index
        try:
            array = np.asarray(index)
        except ValueError:
            array = np.empty((0, 0), dtype=object)  # ragged lists, which are refused below
        if array.shape == (0,):
            array = array.astype(np.int64)
        if array.dtype.kind == "U":
            return np.array([self.number(label) for label in array.ravel()], dtype=np.int64)
        if array.ndim != 1 or array.dtype.kind not in "biu":
            raise AttitudeError(
                f"members are chosen by {validation.shown(index)}; give a number or name, a slice, "
                "a mask (N,), or a row of numbers or names."
            )
        if array.dtype.kind == "b":
            if len(array) != len(self):
                raise AttitudeError(
                    f"the mask has {len(array)} entries, the ensemble {len(self)} members."
                )
            return np.flatnonzero(array)
        return self._in_range(array)

    def _in_range(self, array: NDArray[Any]) -> IntArray:
        """Numbers of members of any shape, those below 0 counted from the end."""
        bad = np.flatnonzero((array.ravel() < -len(self)) | (array.ravel() >= len(self)))
        if len(bad):
            raise self._outside(f"{array.ravel()[bad[0]]} (entry {bad[0]})")
        return np.where(array < 0, array + len(self), array).astype(np.int64)

    def _outside(self, member: str) -> AttitudeError:
        """The error for the number of a member that there is not."""
        return AttitudeError(
            f"member {member} is out of range: the ensemble has {len(self)} members, 0 to "
            f"{len(self) - 1}."
        )

    def _member(self, k: int) -> FreeRotation:
        if k in self._bad:
            raise AttitudeError(f"{self.label(k)}: {self._members.fault(k)}")
        spin = Spin(self.epoch_of(k), self.wxyz[k], self.angular_velocity[k], self.frame)
        if self._low is not None:
            spin._set("wxyz_as_pairs", frozen(np.stack([self.wxyz[k], self._low[k]], axis=-1)))
            spin._set("wxyz", frozen(self.wxyz[k].copy()))
        return FreeRotation(self._inertia.body(k), spin)

    def number(self, member: int | str) -> int:
        """The number of a member of a number (below 0: from the end) or a name.

        Raises
        ------
        AttitudeError
            For a number out of range, and a name that no member has.
        """
        if isinstance(member, str):
            number = -1 if self.names is None else self._numbers.get(member, -1)
            if number < 0:
                raise AttitudeError(
                    f"no member is called {member!r}"
                    + ("; the ensemble has no names." if self.names is None else ".")
                )
            return number
        if not isinstance(member, (int, np.integer)) or isinstance(member, bool):
            raise AttitudeError(f"member is {validation.shown(member)}; give a number or a name.")
        if not -len(self) <= member < len(self):
            raise self._outside(f"{member}")
        return int(member) % len(self)

    @cached_property
    def _numbers(self) -> dict[str, int]:
        """The number of each name."""
        assert self.names is not None
        return {name: k for k, name in enumerate(self.names.tolist())}

    def label(self, k: int) -> str:
        """The name of member k in error messages."""
        k = self.number(k)
        where = f"member {k} of {len(self)}"
        return where if self.names is None else f"{where} ({str(self.names[k])!r})"

    def __add__(self, other: Self) -> Self:
        return type(self).concatenated([self, other])

    def __getstate__(self) -> dict[str, Any]:
        return {name: self.__dict__[name] for name in _KEPT}

    def __repr__(self) -> str:
        start = "epochs of their own" if self.epoch is None else f"{self.epoch.utc_iso} UTC"
        return f"<{type(self).__name__} of {len(self)} members, from {start}>"

    def _repr_html_(self) -> str:
        """A table for notebooks: periods and rates of the first members."""
        few = self[:8]
        rows: list[tuple[str, ...]] = [("member", "mode", "period psi, s", "period phi, s")]
        for k, mode in enumerate(few.mode.tolist()):
            periods = (f"{period[k]:.9g}" for period in (few.period_psi, few.period_phi))
            name = str(k) if self.names is None else str(self.names[k])
            rows.append((name, Mode(mode).name if mode >= 0 else "not physical", *periods))
        if len(self) > len(few):
            rows.append(("...", "", "", ""))
        return markup.table(repr(self)[1:-1], rows)

    # ---- Epochs

    @property
    def epoch(self) -> _instants.Instant | None:
        """The epoch that all members share, or None."""
        return _instants.Instant(*self._start[:, 0]) if self._start.shape[1] == 1 else None

    def epoch_of(self, k: int) -> _instants.Instant:
        """The epoch from which the seconds of member k count."""
        k = self.number(k)
        return _instants.Instant(*self._start[:, k if self._start.shape[1] > 1 else 0])

    def epochs_of(self, member: IntArray) -> tuple[FloatArray, FloatArray]:
        """The epochs of members, TDB seconds past J2000 in two doubles, of the shape given."""
        member = self._members_of(member)[0]
        which = member if self._start.shape[1] > 1 else np.zeros_like(member)
        return self._start[0][which], self._start[1][which]

    @property
    def start_of_seconds(self) -> _instants.Instant:
        """The epoch that all members share, or J2000."""
        return self.epoch or _instants.J2000

    # ---- States, periods and invariants

    @property
    def is_physical(self) -> NDArray[np.bool_]:
        """(N,) whether each member has a state that a body can have."""
        physical = np.ones(len(self), dtype=bool)
        physical[self._bad] = False
        return physical

    @property
    def wxyz_icrf(self) -> FloatArray:
        """(N, 4) attitudes at the epochs of the members, body to ICRF, scalar first."""
        return self._members.wxyz

    @property
    def principal_moments(self) -> FloatArray:
        """(1 or N, 3) principal moments, kg m2 or relative, as `Body.moments`."""
        return self._inertia.moments[..., 0]

    @property
    def principal_axes(self) -> FloatArray:
        """(1 or N, 3, 3) principal axes in body axes, as columns."""
        return self._inertia.axes

    @property
    def relative(self) -> bool:
        """Whether the unit of the moments is unknown."""
        return self._inertia.relative

    @cached_property
    def momentum(self) -> FloatArray:
        """(N, 3) angular momenta in ICRF, kg m2/s, or rad/s times the relative unit of inertia."""
        if self._inertia.has_tensors:
            in_body = np.einsum("...ij,...j->...i", self._inertia.tensors(), self.angular_velocity)
        else:
            in_body = self._inertia.array * self.angular_velocity
        momentum = np.ascontiguousarray(quaternion.rotate(self.wxyz_icrf, in_body))
        momentum[self._bad] = np.nan
        return frozen(momentum)

    @cached_property
    def energy(self) -> FloatArray:
        """(N,) kinetic energies, J, or rad2/s2 times the relative unit of inertia."""
        rates = self._members.omega
        rates = rates if rates.ndim == 2 else rates[..., 0]
        energy = 0.5 * np.sum(self.principal_moments * rates**2, axis=-1)
        energy[self._bad] = np.nan
        return frozen(energy)

    @cached_property
    def regime(self) -> Regime:
        """The `Regime` (N,) of the members: periods, ranges and times in both conventions."""
        return Regime(self._summary[0].copy())

    @property
    def mode(self) -> NDArray[np.int64]:
        """(N,) codes of `Mode`; -1 for a member that is not physical."""
        return self.regime.mode

    @cached_property
    def period_psi(self) -> FloatArray:
        """(N,) periods, s, of the rotation about the axis about which the momentum circulates."""
        return solver_regime.period_of(self._summary[1][0])

    @cached_property
    def period_phi(self) -> FloatArray:
        """(N,) mean periods, s, of the axis of `period_psi` about the momentum."""
        return solver_regime.period_of(self._summary[1][1])

    @property
    def energy_ratio(self) -> FloatArray:
        """(N,) E/E0 = 2 E C / L^2: 1 for rotation about the short axis, NaN at rest."""
        return self.regime.energy_ratio

    def nutation(self, convention: str) -> FloatArray:
        """Ranges (N, 2), rad, of the angle of the long ("L") or short axis to the momentum."""
        return self.regime.nutation(convention)

    @cached_property
    def _summary(self) -> tuple[NDArray[Any], FloatArray]:
        """Rows (N,) of the regimes, and turns per second (2, N) of psi and phi."""
        return solver_regime.summary(self._evaluation(), len(self))

    # ---- Attitudes

    def at(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        *,
        low: ArrayLike | None = None,
        angular_velocity: bool = False,
        threads: int = 1,
        out: FloatArray | None = None,
        rates_out: FloatArray | None = None,
    ) -> EnsembleHistory:
        """The attitudes of the members at some epochs.

        Parameters
        ----------
        t : (T,) or (N, T) array_like; with `member` of any shape S
            Seconds since the epoch of the member, or epochs, as for `FreeRotation.at`.  Arrays of
            float64 are not copied: leave them unchanged as long as the answer is in use.
        member : int, name, or array_like of shape S, optional
            The member of each epoch: numbers 0 to N - 1, or names.  Rows of one member that stand
            together are fastest; rows in another order take 0.1 us more each.
        low : array_like, optional
            With plain seconds: a second double; t + low are the seconds.
        angular_velocity : bool
            Compute `EnsembleHistory.angular_velocity` in the same pass.
        threads : int
            Number of threads; the bits of the answer do not depend on it.
        out, rates_out : float64 arrays (S, 4) and (S, 3), optional
            Filled with attitudes and angular velocities; S is (N, T) without `member`.  Arrays
            whose memory is component-major, (N, 4, T) or ``(4, *S)``, are filled in place.

        Returns
        -------
        EnsembleHistory
            Of shape (N, T), (N,) for a single epoch, or S.

        Raises
        ------
        AttitudeError
            For epochs that cannot be read or lie more than 5e16 turns away, shapes that do not fit,
            members out of range.
        """
        epochs = self._epochs(t, low, member)
        with_rates = validation.flag(angular_velocity, "angular_velocity") or rates_out is not None
        outs = [(out, "out", 4), (rates_out, "rates_out", 3)][: 1 + with_rates]
        return self._history(epochs, outs, threads)

    def blocks(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        *,
        low: ArrayLike | None = None,
        rows: int = 1 << 18,
        angular_velocity: bool = False,
        threads: int = 1,
    ) -> Iterator[tuple[Any, EnsembleHistory]]:
        """The answer of `at` in parts of at most `rows` attitudes, made one after the other.

        Parameters
        ----------
        t, member, low, angular_velocity, threads
            As in `at`.
        rows : int
            An attitude takes 32 bytes, 56 with its rates.

        Yields
        ------
        place : slice, or pair of slices
            ``history.wxyz`` is ``at(t, member).wxyz[place]``.
        history : EnsembleHistory

        Raises
        ------
        AttitudeError
            As `at`.
        """
        epochs = self._epochs(t, low, member)
        with_rates = validation.flag(angular_velocity, "angular_velocity")
        outs = [(None, "out", 4), (None, "rates_out", 3)][: 1 + with_rates]
        parts = epochs.parts(validation.count(rows, "rows"))
        return ((place, self._history(block, outs, threads)) for place, block in parts)

    def sensitivity_at(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        *,
        low: ArrayLike | None = None,
        angular_velocity: bool = False,
        threads: int = 1,
        out: FloatArray | None = None,
        rates_out: FloatArray | None = None,
    ) -> FloatArray | tuple[FloatArray, FloatArray]:
        """The derivatives of attitudes by the states and the moments, in closed form.

        Parameters
        ----------
        t, member, low, threads
            As in `at`.  In parts of bounded memory: `history.sensitivity` of `blocks`.
        angular_velocity : bool
            Whether the derivatives of the angular velocity are returned too.
        out, rates_out : float64 arrays (S, 3, 9), optional
            Filled; as in `at`.

        Returns
        -------
        attitude : (S, 3, 9) array
            Rotation vector (rad, ICRF axes) of the change of attitude for a unit change of the
            attitude at the epoch (3, rotation vector, rad, ICRF axes), the angular velocity
            (3, rad/s, body axes) and the principal moments (3, in the unit of the member).
        omega : (S, 3, 9) array
            Of the angular velocity, body axes; only with `angular_velocity`.

        Raises
        ------
        AttitudeError
            As `at`, and for rods; with ``on_error="nan"`` their derivatives are NaN.

        Notes
        -----
        The bits and the accuracy of `FreeRotation.sensitivity_at`.
        """
        epochs = self._epochs(t, low, member)
        with_rates = validation.flag(angular_velocity, "angular_velocity") or rates_out is not None
        outs = [(out, "out"), (rates_out, "rates_out")][: 1 + with_rates]
        memory = [epochs.memory(*array, 3, sensitivities.PARAMETERS) for array in outs]
        epochs.fill(self._evaluation(), Results(None, None, *memory), threads)
        views = [epochs.shaped(a, b[0]) for a, b in zip(memory, outs, strict=True)]
        return (views[0], views[1]) if with_rates else views[0]

    def evaluated(
        self, member: IntArray, seconds: FloatArray, low: FloatArray | None
    ) -> FloatArray:
        """Angular velocities (S, 3), rad/s in body axes, of members (S) at seconds + low (S)."""
        epochs = MemberRows(len(self), member, Seconds(seconds, low))
        wxyz, rates = (np.empty((width, epochs.size)) for width in (4, 3))
        epochs.fill(self._evaluation(), Results(wxyz, rates), 1)
        return epochs.shaped(rates, None)

    def grid_of(self, t: Epochs, low: ArrayLike | None = None) -> MemberGrid:
        """The epochs of all members, given as for `at`; AttitudeError for a single epoch."""
        epochs = self._epochs(t, low, None)
        if not isinstance(epochs, MemberGrid) or epochs.scalar:
            raise AttitudeError("t is one epoch; give (T,) or (N, T).")
        return epochs

    def _epochs(self, t: Any, low: Any, member: ArrayLike | None) -> MemberGrid | MemberRows:
        """The epochs of all members, or of the rows of given ones."""
        if member is None:
            return MemberGrid(len(self), *_members.shared(self._start, t, low, len(self)))
        known, in_runs = self._members_of(member)
        seconds, who = _members.of_rows(self._start, t, low, known)
        return MemberRows(len(self), who, seconds, in_runs)

    def _members_of(self, member: ArrayLike) -> tuple[IntArray, bool]:
        """Numbers of members, of the shape given, and whether equal ones stand in long runs."""
        try:
            array = np.asarray(member)
        except ValueError as err:
            raise AttitudeError("member is ragged; give one number or name for each row.") from err
        if array.dtype.kind == "U" or (array.dtype == object and array.size):
            names = [self.number(label) for label in array.ravel().tolist()]
            array = np.array(names, dtype=np.int64).reshape(array.shape)
        if array.size == 0:
            return np.zeros(array.shape, dtype=np.int64), True
        if array.dtype.kind not in "iu":
            raise AttitudeError(
                f"member is {validation.shown(member)}; give whole numbers or names of members."
            )
        numbers: IntArray = np.asarray(array, dtype=np.int64, order="C")
        least, greatest, in_runs = states.survey(numbers.reshape(-1))
        if least < 0 or greatest >= len(self):
            flat = numbers.reshape(-1)
            row = int(np.argmax((flat < 0) | (flat >= len(self))))
            raise self._outside(f"{flat[row]} of row {row}")
        return numbers, in_runs

    def _history(self, epochs: MemberGrid | MemberRows, outs: Any, threads: int) -> EnsembleHistory:
        """The history of some epochs, in the output arrays (out, name, width) if they are given."""
        memory = [epochs.memory(*array) for array in outs]
        epochs.fill(self._evaluation(), Results(*memory), threads)
        views = [read_only(epochs.shaped(a, b[0])) for a, b in zip(memory, outs, strict=True)]
        history = EnsembleHistory(self, epochs.member, *epochs.seconds, views[0])
        if len(views) > 1:
            history.__dict__["angular_velocity"] = views[1]
        return history

    def _evaluation(self, solved: Solved | None = None) -> Evaluation:
        """The members as the compiled solution takes them, or their constants that are kept."""
        source = self._members if solved is None else solved
        return Evaluation(source, self.label, self.on_error == "raise")

    # ---- Brightness

    def brightness(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        *,
        shape: Any,
        law: str | Law = "lommel-seeliger",
        shadows: bool | Visibility = True,
        low: ArrayLike | None = None,
        threads: int = 1,
        out: FloatArray | None = None,
        _magnitudes: tuple[float, bool] | None = None,
    ) -> FloatArray:
        """Intensity towards the observer over the Sun's irradiance, straight from the states.

        Parameters
        ----------
        t, member, low
            The epochs at which light leaves the body, as in `at`.
        sun, observer : (..., 3) array_like
            Vectors from the body in ICRF, of any length above zero, that broadcast to (S, 3);
            NaN gives NaN.  `member` is before them: give them by name, ``sun=, observer=``.
        shape : Ellipsoid, Mesh, N of them, or (3,) or (N, 3) array_like
            Arrays are semi-axes of ellipsoids along the body axes, m.
        law, shadows
            As in `light_curve.brightness`: ellipsoids need a law with a closed form.
        threads : int
            Number of threads; the bits of the answer do not depend on it.
        out : (S) float64 array in C order, optional

        Returns
        -------
        (S) array
            m2/sr.

        Raises
        ------
        AttitudeError
            As `at` and `light_curve.brightness`; for a shape that is missing.
        """
        epochs = self._epochs(t, low, member)
        to_sun = _light.known_vectors(sun, "sun", epochs.shape)
        to_observer = _light.known_vectors(observer, "observer", epochs.shape)
        shapes = _light.known_shapes(shape, len(self), self.label)
        source = _light.Light(self._evaluation(), shapes, law, shadows)
        result = validation.output(out, epochs.shape)
        flat = result.reshape(-1)
        # Of the methods below: the Sun at 1 au, and whether at the lengths of the vectors.
        source.fill(epochs, to_sun, to_observer, flat, threads, *(_magnitudes or (None, False)))
        return result

    def reduced_magnitude(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        *,
        sun_magnitude: Real = SUN_V,
        **options: Any,
    ) -> FloatArray:
        """Magnitudes (S) at 1 au from Sun and observer: V(1, 1, alpha); inf where nothing is seen.

        Arguments as in `brightness`; `sun_magnitude` is that of the Sun at 1 au, by default in
        Johnson V.
        """
        band = validation.number(sun_magnitude, "sun_magnitude", unit="mag")
        return self.brightness(t, member, sun, observer, _magnitudes=(band, False), **options)

    def magnitude(
        self,
        t: Epochs,
        member: ArrayLike | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        *,
        sun_magnitude: Real = SUN_V,
        **options: Any,
    ) -> FloatArray:
        """Apparent magnitudes (S), for vectors to Sun and observer in m or Quantities.

        Arguments as in `reduced_magnitude`.
        """
        band = validation.number(sun_magnitude, "sun_magnitude", unit="mag")
        return self.brightness(t, member, sun, observer, _magnitudes=(band, True), **options)

    # ---- Percentiles, histograms, coverage

    def percentiles(
        self,
        quantity: Any,
        t: Epochs,
        percentages: Reals = (5.0, 50.0, 95.0),
        *,
        scene: Scene | None = None,
        low: ArrayLike | None = None,
        threads: int = 1,
    ) -> FloatArray:
        """Percentiles of a quantity over the members, at each epoch.

        Parameters
        ----------
        quantity : str, AngleTo or callable
            The name of a quantity of `scene` with one number at each epoch ("magnitude",
            "aspect_angle" ...); an `AngleTo(axis, target)`; or a function that takes an
            EnsembleHistory (n, T) and returns numbers (n, T).
        t : (T,) or (N, T)
            As in `at`; with a scene (T,), the epochs at which light is received.
        percentages : (P,) array_like
            0 to 100; between two members the numbers are interpolated linearly, as by numpy.
        scene : Scene, optional
            Its motion is replaced by each member.
        threads : int
            Each takes some 20 MB.

        Returns
        -------
        (P, T) array
            NaN is left out; NaN where no member has a number.

        Raises
        ------
        AttitudeError
            For other quantities, percentages out of range, and as `at`.

        Notes
        -----
        Epochs are evaluated in parts of some 1e6 numbers, of at least 16 epochs; constants of up
        to 35,000 members are kept meanwhile, those of more are set up for each part.
        """
        wanted = validation.real(percentages, "percentages")
        if wanted.ndim != 1 or np.any((wanted < 0.0) | (wanted > 100.0)):
            raise AttitudeError(f"percentages are {wanted.tolist()}; give a row of 0 to 100.")
        known, grid = _quantities.known(quantity, scene, self, t, low)
        length = grid.length
        out = np.full((len(wanted), length), np.nan)
        kept = self._evaluation(self._members.solved() if len(self) <= _MOST_KEPT else None)
        size = max(_FEWEST, _HELD // max(len(self), 1))

        def work(begin: int, end: int) -> None:
            epochs = slice(begin, end)
            values = np.empty((end - begin, len(self)))
            for first in range(0, len(self), _FEW):
                which = slice(first, min(first + _FEW, len(self)))
                values[:, which] = self._measured(known, grid, kept, which, epochs).T
            out[:, epochs] = _percentiles(values, wanted, known.finished)

        if len(self):
            in_blocks(work, length, size, threads, ProgressBar("percentiles"))
        return out

    def histograms(
        self,
        quantity: Any,
        t: Epochs,
        edges: Reals,
        *,
        scene: Scene | None = None,
        low: ArrayLike | None = None,
    ) -> IntArray:
        """Numbers of members (T, B) in each of B bins, at each epoch.

        Parameters
        ----------
        quantity, t, scene, low
            As in `percentiles`.
        edges : (B + 1,) array_like
            Ascending, in the unit of the quantity; a bin holds its lower edge, the last one both.

        Raises
        ------
        AttitudeError
            For edges that do not ascend, and as `percentiles`.
        """
        bounds = validation.real(edges, "edges")
        if bounds.ndim != 1 or len(bounds) < 2 or np.any(np.diff(bounds) <= 0.0):
            raise AttitudeError(f"edges are {validation.shown(edges)}; give an ascending row.")
        known, grid = _quantities.known(quantity, scene, self, t, low)
        bins, length = len(bounds) - 1, grid.length
        counts = np.zeros(length * bins, dtype=np.int64)
        bar, done = ProgressBar("histograms"), 0
        for which, epochs in grid.pieces(_HELD >> 2):
            values = known.finished(self._measured(known, grid, self._evaluation(), which, epochs))
            place = np.searchsorted(bounds, values, side="right") - 1
            place[values == bounds[-1]] = bins - 1
            inside = (place >= 0) & (place < bins) & ~np.isnan(values)
            row = np.broadcast_to(np.arange(epochs.start, epochs.stop), values.shape)
            index = (row * bins + place)[inside]
            counts += np.bincount(index, minlength=len(counts))
            done += values.size
            bar(done, len(self) * length)
        return counts.reshape(length, bins)

    def coverage(
        self,
        quantity: Any,
        t: Epochs,
        *,
        least: Real = -np.inf,
        greatest: Real = np.inf,
        scene: Scene | None = None,
        low: ArrayLike | None = None,
        threads: int = 1,
    ) -> Coverage:
        """The fraction of time for which a quantity is within bounds, and its longest gap.

        Parameters
        ----------
        quantity, t, scene, low
            As in `percentiles`; epochs ascend, and are so close that no crossing is lost.
        least, greatest : float
            Bounds, which are within; in the unit of the quantity (an AngleTo: rad, or text or a
            Quantity with another unit).  NaN is not within.
        threads : int

        Returns
        -------
        Coverage

        Raises
        ------
        AttitudeError
            For epochs that do not ascend, fewer than two, bounds that are no numbers, and as
            `percentiles`.
        """
        bounds = {"least": least, "greatest": greatest}
        unit = "rad" if isinstance(quantity, _quantities.AngleTo) else None
        first, last = (
            float(validation.real(bound, name, shape=(), unit=unit, finite=False))
            for name, bound in bounds.items()
        )
        known, grid = _quantities.known(quantity, scene, self, t, low)
        if grid.length < 2 or not np.all(np.diff(grid.t.hi) > 0.0):
            raise AttitudeError("t does not ascend, or holds fewer than two epochs; give (T,).")
        fraction, gap = np.empty((2, len(self)))
        size = max(1, (_HELD >> 2) // grid.length)
        every = slice(0, grid.length)

        def work(begin: int, end: int) -> None:
            which = slice(begin, end)
            values = known.finished(self._measured(known, grid, self._evaluation(), which, every))
            with np.errstate(invalid="ignore"):
                within = (values >= first) & (values <= last)
            times = grid.t.hi[which] if len(grid.t.hi) > 1 else grid.t.hi
            fraction[which], gap[which] = _covered(within, times)

        in_blocks(work, len(self), size, threads, ProgressBar("coverage"))
        return Coverage(fraction, gap)

    def _measured(
        self, known: Any, grid: MemberGrid, evaluation: Evaluation, which: slice, epochs: slice
    ) -> FloatArray:
        """What a quantity measures of some members at some epochs."""
        rows = which if len(grid.t.hi) > 1 else slice(None)
        t = grid.t.taken((rows, epochs)).mapped(np.ascontiguousarray)
        count, length = which.stop - which.start, epochs.stop - epochs.start
        wxyz = np.empty((count, 4, length))
        evaluation.grid(t, Results(wxyz), first=which.start)
        history = EnsembleHistory._of_all(self, t, np.moveaxis(wxyz, 1, 2), first=which.start)
        return known.measured(history, epochs)

    # ---- Impulses and torques

    def _refuse_epochs(self, what: str) -> None:
        if self.epoch is None:
            raise AttitudeError(
                f"the members have epochs of their own; {what} need one epoch for all members."
            )

    def _refuse_bad(self) -> None:
        if len(self._bad):
            raise AttitudeError(
                "some members are not physical; leave them out: ensemble[ensemble.is_physical]."
            )

    def arcs(self, changes: Any) -> ArcsEnsemble:
        """The same states with impulses or changes of inertia: an `ArcsEnsemble`."""
        return ArcsEnsemble(self, changes)

    def torqued(
        self, torques: Any, step: Real, scheme: str | Scheme = "kick-rotate-kick"
    ) -> TorquedEnsemble:
        """The same states under torques, with one scheme and one step: a `TorquedEnsemble`."""
        return TorquedEnsemble(self, torques, step, scheme)

    def averaged(self, torques: Any, **settings: Any) -> AveragedEnsemble:
        """The mean rotations of the same states under weak torques: an `AveragedEnsemble`.

        Parameters
        ----------
        torques, settings
            orbit=, passages=, least_tilt=, tolerance=, degree=, order= and on_error= of
            `attitude.averaged.AveragedEnsemble`.

        Raises
        ------
        AttitudeError
            For members with epochs of their own or that are not physical, and as
            `AveragedEnsemble`.
        """
        self._refuse_bad()
        names = None if self.names is None else self.names.tolist()
        motions = [self[k] for k in range(len(self))]
        return AveragedEnsemble(motions, torques, names=names, **settings)

    # ---- Tables

    def table(self) -> QTable:
        """The members as an astropy QTable with the columns that `from_table` reads."""
        from astropy.table import QTable

        arrays = {"wxyz": self.wxyz, "angular_velocity": self.angular_velocity}
        if self._low is not None:
            arrays["low"] = self._low
        inertia = self._inertia.array
        arrays["tensor" if inertia.ndim == 3 else "moments"] = np.broadcast_to(
            inertia, (len(self), *inertia.shape[1:])
        )
        columns: dict[str, Any] = {} if self.names is None else {"name": np.array(self.names)}
        start = np.broadcast_to(self._start, (2, len(self)))
        columns |= {"epoch_seconds": start[0], "epoch_low": start[1], **_tables.of_arrays(arrays)}
        meta = {"frame": self.frame, "relative": self._inertia.relative}
        return QTable({name: np.array(column) for name, column in columns.items()}, meta=meta)

    def write(self, path: FilePath) -> None:
        """Write a file that `from_table` reads back bit for bit: .parquet, .ecsv or .fits.

        The file appears whole or not at all.

        Raises
        ------
        AttitudeError
            For another ending, names that it cannot hold, and a file that cannot be written.
        """
        comments = self.names is not None and np.char.startswith(self.names, "#").any()
        if comments and tables.kind_of(path) == "ecsv":
            raise AttitudeError("a name begins with '#', as comments in ECSV do; give .fits.")
        tables.write_columns(path, self.table())


# ---- Attitudes of the members of an ensemble at epochs


class EnsembleHistory(AttitudeHistory):
    """The rotation of members of an ensemble, each at epochs of its own or at shared ones.

    Made by ``ensemble.at(t)``, of shape S = (N, T), or ``ensemble.at(t, member=index)``, of the
    shape S of the index.  It has all attributes and methods of `AttitudeHistory`.

    Attributes
    ----------
    ensemble : Ensemble
    member : (S) array of int
        The number of the member of each attitude.
    wxyz, xyzw : (S, 4) arrays
        Body to ICRF, scalar first or last; continuous in sign along the motion of a member.
    seconds, low : arrays of shape S (low may be None)
        TDB seconds since the epoch of the member: seconds + low.
    epoch : Instant
        The epoch of the ensemble, or J2000 if the members have epochs of their own.
    """

    ensemble: Ensemble
    member: IntArray

    def __init__(
        self,
        ensemble: Ensemble,
        member: IntArray,
        seconds: FloatArray,
        low: FloatArray | None,
        wxyz: FloatArray,
        motion: Any = None,
    ) -> None:
        source = ensemble if motion is None else motion
        super().__init__(source, ensemble.start_of_seconds, seconds, low, wxyz)
        self._set_all(ensemble=ensemble, member=frozen(member))

    @classmethod
    def _of_all(
        cls,
        ensemble: Ensemble,
        t: Seconds,
        wxyz: FloatArray,
        rates: FloatArray | None = None,
        first: int = 0,
        motion: Any = None,
    ) -> Self:
        """Attitudes and rates (N, T, ...) of members from `first` on, at epochs (T,) or (N, T)."""
        shape = wxyz.shape[:2]
        member = np.broadcast_to(np.arange(first, first + shape[0])[:, None], shape)
        spread = t.mapped(lambda array: np.broadcast_to(array, shape))
        history = cls(ensemble, member, *spread, wxyz, motion)
        if rates is not None:
            history.__dict__["angular_velocity"] = frozen(rates)
        return history

    def __getitem__(self, index: Any) -> Self:
        """Some of the attitudes: history[3], history[:, 10:20], history[mask]."""
        history = super().__getitem__(index)
        member, times = np.asarray(self.member[index]), Seconds.of(history)
        chosen = type(self)(self.ensemble, member, *times, history.wxyz, self.motion)
        if "angular_velocity" in history.__dict__:
            chosen.__dict__["angular_velocity"] = history.angular_velocity
        return chosen

    def __repr__(self) -> str:
        size, members = self.seconds.size, len(self.ensemble)
        return f"<EnsembleHistory of {size} attitudes of an ensemble of {members}>"

    @cached_property
    def angular_velocity(self) -> FloatArray:
        """(S, 3) rad/s over the body axes."""
        return frozen(self.ensemble.evaluated(self.member, self.seconds, self.low))

    @cached_property
    def turning_rate(self) -> FloatArray:
        """(S, 3) rad/s over the body axes: `angular_velocity`."""
        return self.angular_velocity

    @cached_property
    def sensitivity(self) -> FloatArray:
        """(S, 3, 9) derivatives of the attitudes; see `Ensemble.sensitivity_at`."""
        columns = self.ensemble.sensitivity_at(self.seconds, self.member, low=self.low)
        return frozen(cast("FloatArray", columns))

    @cached_property
    def angular_acceleration(self) -> FloatArray:
        """(S, 3) rad/s2 over the body axes, by Euler's equations of the bodies at the epoch."""
        moments, axes = self.ensemble.principal_moments, self.ensemble.principal_axes
        which = self.member if len(moments) > 1 else np.zeros_like(self.member)
        differences, turn = moments[which], axes[which]
        w = np.einsum("...ij,...i->...j", turn, self.angular_velocity)
        rate = np.zeros(w.shape)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            torque = (differences[..., j] - differences[..., k]) * w[..., j] * w[..., k]
            rod = differences[..., i] == 0.0
            rate[..., i] = np.where(rod, 0.0, torque / np.where(rod, 1.0, differences[..., i]))
        return frozen(np.einsum("...ij,...j->...i", turn, rate))

    @cached_property
    def time(self) -> Time:
        """The epochs (S) as an astropy Time in TDB, rounded to 5e-12 s; NaN epochs are masked."""
        if self.ensemble.epoch is not None:
            return _instants.times(self.epoch, self.seconds, self.low)
        start = self.ensemble.epochs_of(self.member)
        times = Seconds.of(self)
        return _instants.times(self.epoch, *pairs.add(start, times.hi, times.low))

    def table(self, *, rates: bool = True, sigma: bool = False) -> QTable:
        """As `AttitudeHistory.table`, one row for each attitude, with columns member and name.

        Raises
        ------
        AttitudeError
            For standard deviations, which an ensemble does not have.
        """
        if sigma:
            raise AttitudeError("an ensemble has no standard deviations; leave out sigma=True.")
        flat = self if len(self.shape) == 1 else self[np.ones(self.shape, dtype=bool)]
        columns = super(EnsembleHistory, flat).table(rates=rates)
        columns.add_column(np.array(flat.member), index=0, name="member")
        if self.ensemble.names is not None:
            columns.add_column(self.ensemble.names[flat.member], index=1, name="name")
        if self.ensemble.epoch is None:
            del columns.meta["epoch"]
        return columns


# ---- The same members with impulses, and under torques


class ChangedHistory(EnsembleHistory):
    """Attitudes of the members of an ArcsEnsemble or a TorquedEnsemble, with their rates."""

    @cached_property
    def sensitivity(self) -> FloatArray:
        """(S, 3, 9) derivatives of the attitudes: `sensitivity_at` of the motion of each member."""
        return self._of_members(3, 9, answer=lambda motion, t: motion.sensitivity_at(*t))

    @cached_property
    def angular_acceleration(self) -> FloatArray:
        """(S, 3) rad/s2 over the body axes, of the motion of each member."""
        return self._of_members(3, answer=lambda motion, t: motion.angular_acceleration_at(*t))

    @cached_property
    def turning_rate(self) -> FloatArray:
        """(S, 3) rad/s over the body axes, of the motion of each member."""
        return self._of_members(3, answer=lambda motion, t: motion.at(*t).turning_rate)

    def _of_members(self, *width: int, answer: Callable[[Any, Seconds], FloatArray]) -> FloatArray:
        """What the motions of the members answer (S, *W) at their epochs."""
        values = np.empty((*self.shape, *width))
        for k in np.unique(self.member).tolist():
            on = self.member == k
            values[on] = answer(self.motion[k], Seconds.of(self).taken(on))
        return frozen(values)


class ArcsEnsemble(Immutable):
    """The rotations of N bodies with the same changes, each an `Arcs`.

    ensemble: states at one epoch.
    changes: as in `Arcs`; seconds count from the epoch of the ensemble.  Those at given epochs with
        given momenta are compiled over members, 0.1 ms a member and change; events and functions
        are resolved member by member.
    AttitudeError for members with epochs of their own, and as `Arcs`, with the name of the member.

    Attitudes have the bits of `Arcs.at`.
    """

    ensemble: Ensemble
    changes: tuple[Change, ...]
    _chains: _arcs.Chains | None
    _singles: tuple[Arcs, ...] | None

    def __init__(self, ensemble: Ensemble, changes: Any) -> None:
        ensemble._refuse_epochs("changes")
        known = known_changes(changes)
        self._set_all(ensemble=ensemble, changes=known, _chains=None, _singles=None)
        if len(ensemble) and not _arcs.are_alike(known):
            self._set("_singles", tuple(self._single(k) for k in range(len(ensemble))))
            return
        with self._named():
            chains = _arcs.Chains(
                ensemble._members, ensemble._inertia, ensemble.start_of_seconds, known
            )
            self._set("_chains", chains)

    def _single(self, k: int) -> Arcs:
        """The motion of member k; its errors have the name of the member."""
        motion = self.ensemble[k]
        with prefixed(self.ensemble.label(k)):
            return Arcs(motion.body, motion.spin, self.changes)

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Raise the error of the single motion of a member that failed."""
        try:
            yield
        except _arcs.Failed as failed:
            self._single(failed.member)
            raise AttitudeError(
                f"{self.ensemble.label(failed.member)}: an epoch lies beyond its reach."
            ) from None

    def __len__(self) -> int:
        return len(self.ensemble)

    def __iter__(self) -> Iterator[Arcs]:
        return map(self.__getitem__, range(len(self)))

    def __getitem__(self, k: int | str) -> Arcs:
        """The motion of one member, of a number or a name."""
        number = self.ensemble.number(k)
        return self._single(number) if self._singles is None else self._singles[number]

    def __repr__(self) -> str:
        return f"<ArcsEnsemble of {len(self)} members>"

    def at(self, t: Epochs, low: ArrayLike | None = None, *, threads: int = 1) -> ChangedHistory:
        """Attitudes and angular velocities (N, T) of all members at epochs (T,)."""
        hi, lo = _inputs.seconds_since(self.ensemble.start_of_seconds, t, low)
        if hi.ndim != 1:
            raise AttitudeError(f"t is {validation.shown(t)}; give a row (T,) of epochs.")
        count, length = len(self), len(hi)
        wxyz, rates = np.empty((count, 4, length)), np.empty((count, 3, length))

        def evaluate_singles(begin: int, end: int) -> None:
            """Fill the rows of members one by one; errors have the name of the member."""
            for k in range(begin, end):
                motion = self[k]
                with prefixed(self.ensemble.label(k)):
                    history = motion.at(hi, lo)
                    wxyz[k], rates[k] = history.wxyz.T, history.angular_velocity.T

        if self._chains is None:
            in_blocks(evaluate_singles, count, 64, threads, ProgressBar("chains of arcs"))
        else:
            try:
                self._chains.fill(Seconds(hi, lo), wxyz, rates, threads)
            except _arcs.Failed as failed:
                evaluate_singles(failed.member, failed.member + 1)
        attitudes, turning = (read_only(np.moveaxis(array, 1, 2)) for array in (wxyz, rates))
        times = Seconds(hi.copy(), lo)
        return ChangedHistory._of_all(self.ensemble, times, attitudes, turning, motion=self)


# Steps for which torques are sampled together.
_STEPS = 1024
# Steps of all members in one compiled call: 50 ms.
_TAKEN = 1 << 16


class TorquedEnsemble(Immutable):
    """The rotations of N bodies under the same torques.

    ensemble: states at one epoch; their frame, bodies and names.
    torques: as in `TorquedRotation`.
    step: s, of all members.
    scheme: as in `TorquedRotation`.
    AttitudeError for members with epochs of their own or that are not physical, a step that does
        not resolve the rotation of a member, and as `TorquedRotation`.

    Attitudes are those of ``TorquedRotation(body, spin, torques, step=step, scheme=scheme)``.
    States are integrated anew in each call of `at`, and are not kept.
    """

    ensemble: Ensemble
    torques: tuple[Torque, ...]
    step: float
    scheme: Scheme

    def __init__(
        self,
        ensemble: Ensemble,
        torques: Any,
        step: Real,
        scheme: str | Scheme = "kick-rotate-kick",
    ) -> None:
        self._systems: list[System]
        self._states: FloatArray
        ensemble._refuse_epochs("torques")
        ensemble._refuse_bad()
        self._set("ensemble", ensemble)
        self._set("step", validation.positive(step, "step", unit="s"))
        self._set("scheme", _schemes.scheme(scheme))
        self._set_all(torques=(), _systems=[], _states=np.zeros((0, STATE_ENTRIES)))
        if len(ensemble):
            first = TorquedRotation(
                ensemble[0].body,
                ensemble[0].spin,
                torques,
                step=None,
                scheme=self.scheme,
                step_tolerance=1e-2,
            )
            self._set("torques", first.torques)
            self._prepare()

    def __reduce__(self) -> tuple[Any, ...]:
        # The systems hold addresses, which are those of one process.
        return type(self), (self.ensemble, self.torques, self.step, self.scheme)

    def _prepare(self) -> None:
        """Pack the bodies and the states of the members."""
        ensemble = self.ensemble
        shared = len(ensemble.principal_moments) == 1
        kept = [ensemble[k] for k in range(1 if shared else len(ensemble))]
        systems = [System(member.body, member.spin, self.torques, self.scheme) for member in kept]
        self._set("_systems", systems)
        states = np.zeros((len(ensemble), STATE_ENTRIES))
        turns = np.array([system.turn for system in systems])
        states[:, WXYZ] = quaternion.multiply(ensemble.wxyz_icrf, turns)
        # By the products of single vectors, so that the bits are those of a TorquedRotation.
        for k, state in enumerate(states):
            state[WXYZ] /= np.sqrt(state[WXYZ] @ state[WXYZ])
            state[OMEGA] = ensemble.angular_velocity[k] @ self._system(k).axes
        speeds = np.sum(states[:, OMEGA] ** 2, axis=1)
        worst = int(np.argmax(speeds))
        with prefixed(ensemble.label(worst)):
            motion = ensemble[worst]
            System(motion.body, motion.spin, self.torques, self.scheme).check_step(self.step)
        self._set("_states", frozen(states))

    def _system(self, k: int) -> System:
        """That of member k: all share one, or have one each."""
        return self._systems[0 if len(self._systems) == 1 else k]

    def __len__(self) -> int:
        return len(self.ensemble)

    def __iter__(self) -> Iterator[TorquedRotation]:
        return map(self.__getitem__, range(len(self)))

    def __getitem__(self, k: int | str) -> TorquedRotation:
        """The motion of one member, of a number or a name."""
        motion = self.ensemble[self.ensemble.number(k)]
        return TorquedRotation(
            motion.body, motion.spin, self.torques, step=self.step, scheme=self.scheme
        )

    def __repr__(self) -> str:
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<TorquedEnsemble of {len(self)} members: {names}; step {self.step:g} s>"

    def at(self, t: Epochs, low: ArrayLike | None = None, *, threads: int = 1) -> ChangedHistory:
        """The attitudes and angular velocities of all members at some epochs; t (T,)."""
        times = _inputs.seconds_since(self.ensemble.start_of_seconds, t, low).mapped(np.array)
        hi = times.hi
        if hi.ndim != 1 or np.isinf(hi).any():
            raise AttitudeError(f"t is {validation.shown(t)}; give a row (T,) of finite epochs.")
        seconds, lo = hi, times.low
        out = np.full((len(self), len(seconds), 7), np.nan)
        total = seconds + lo
        for sign, side in ((1.0, total >= 0.0), (-1.0, total < 0.0)):
            if side.any() and len(self):
                self._integrate(sign * self.step, seconds, lo, np.flatnonzero(side), out, threads)
        if any(system.inertia is not None for system in self._systems):
            for k, states in enumerate(out):
                states[:, 4:] = self._system(k).turning(seconds, lo, states[:, 4:])
        attitudes, rates = out[..., :4], out[..., 4:]
        return ChangedHistory._of_all(self.ensemble, times, attitudes, rates, motion=self)

    def _integrate(
        self,
        h: float,
        seconds: FloatArray,
        low: FloatArray,
        which: IntArray,
        out: FloatArray,
        threads: int,
    ) -> None:
        """Fill the states at epochs `which` of one direction of time."""
        first, states = self._systems[0], self._states.copy()
        first.check_span(float(np.max(np.abs(seconds[which]))), h)
        number, parts = whole_steps(seconds[which], low[which], h)
        order = np.lexsort((np.abs(parts), number))
        which, number, parts = which[order], number[order], parts[order]
        size = max(1, _TAKEN // _STEPS)
        bar = ProgressBar("torqued members")
        for start in range(0, int(number[-1]) + 1, _STEPS):
            steps = min(_STEPS, int(number[-1]) - start)
            final = start + _STEPS > number[-1]
            a, b = np.searchsorted(number, [start, start + steps + final])
            places = number[a:b] - start, np.ascontiguousarray(parts[a:b])
            samples = first.samples_of(start, h, steps, *places)

            def work(begin: int, end: int) -> None:
                some = states[begin:end]
                place = np.ix_(np.arange(begin, end), which[a:b])  # noqa: B023
                out[place] = self._marched(begin, some, start, h, places, samples)  # noqa: B023

            in_blocks(work, len(self), size, threads)
            bar(start + steps + 1, int(number[-1]) + 1)

    def _marched(
        self, first: int, states: FloatArray, start: int, h: float, places: Any, samples: Any
    ) -> FloatArray:
        """States (n, T, 7) over body axes of some members, which are advanced in place."""
        shared = len(self._systems) == 1
        systems = self._systems if shared else self._systems[first : first + len(states)]
        setup = (
            np.array([system.setup[0] for system in systems]),
            systems[0].setup[1],
            np.array([system.setup[2] for system in systems]),
        )
        number, parts = places

        def label(k: int) -> str:
            return self.ensemble.label(first + k)

        advanced = systems[0].march_members(
            setup, states, start, h, number, parts, samples, label=label
        )
        for k in range(len(advanced)):
            advanced[k] = systems[0 if shared else k].over_body_axes(advanced[k])
        return advanced
