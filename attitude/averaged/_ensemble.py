"""`AveragedEnsemble`: the mean rotations of N states under the same torques."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.blocks import ProgressBar, in_blocks
from attitude.averaged._history import AveragedHistory
from attitude.averaged._mean_torques import MeanTorques
from attitude.averaged._motion import DEGREE, AveragedMotion, Settings, second_of, seconds_of
from attitude.averaged._polhode import LAM_PLUS, REGIONS
from attitude.averaged._tracks import AveragedEvent
from attitude.errors import AttitudeError
from attitude.motions._free_rotation import FreeRotation
from attitude.torques._torqued import _torques

if TYPE_CHECKING:
    from astropy.table import QTable

    from attitude._support.annotations import BoolArray, Epochs, FloatArray, IntArray, Real
    from attitude.epochs._instants import Instant
    from attitude.torques._torque import Torque

# Members that a thread takes at a time.
_AT_ONCE = 8


def _gathered(name: str, meaning: str) -> FloatArray:
    """The property of an `AveragedEnsembleHistory` that joins this one of its groups."""
    joined: Any = cached_property(lambda self: self._of_groups(name))
    joined.__doc__ = meaning
    return joined


class AveragedEnsembleHistory(Immutable):
    """Mean states (N, T) of the members of an `AveragedEnsemble`; NaN beyond the end of a member.

    Attributes
    ----------
    seconds : (T,) array
        TDB seconds since the epoch of the members.
    """

    seconds: FloatArray

    def __init__(
        self, seconds: FloatArray, groups: Sequence[tuple[IntArray, AveragedHistory]]
    ) -> None:
        self._groups: Sequence[tuple[IntArray, AveragedHistory]]
        self._set_all(seconds=frozen(np.array(seconds)), _groups=tuple(groups))

    def _of_groups(self, name: str) -> Any:
        rows = [(index, np.asarray(getattr(states, name))) for index, states in self._groups]
        count = sum(len(index) for index, _ in rows)
        out = np.empty((count, *rows[0][1].shape[1:]), dtype=rows[0][1].dtype)
        for index, values in rows:
            out[index] = values
        return frozen(out)

    def __len__(self) -> int:
        return sum(len(index) for index, _ in self._groups)

    def __repr__(self) -> str:
        return f"<AveragedEnsembleHistory of {len(self)} members, {len(self.seconds)} epochs>"

    momentum = _gathered("momentum", "(N, T, 3) in N m s, ICRF axes.")
    size = _gathered("size", "|L| (N, T) in N m s.")
    pole = _gathered("pole", "Unit vectors (N, T, 3) along the momentum, ICRF axes.")
    y = _gathered("y", "2 ln tan theta (N, T).")
    theta = _gathered(
        "theta", "The angle (N, T) in rad between momentum and short axis, as of `AveragedHistory`."
    )
    energy = _gathered("energy", "Kinetic energy (N, T) in J.")
    P_psi = _gathered("P_psi", "Periods of the nutation (N, T) in s.")
    P_phi = _gathered("P_phi", "Mean periods (N, T) in s of the long axis about the momentum.")

    @cached_property
    def region(self) -> IntArray:
        """0 to 3 (N, T): SAM+, SAM-, LAM+, LAM-; -1 beyond the end of a member."""
        known: IntArray = np.where(np.isfinite(self.y), self._of_groups("region"), -1)
        return known

    @cached_property
    def is_known(self) -> BoolArray:
        """(N, T), False beyond the end of a member."""
        flags: BoolArray = np.isfinite(self.y)
        return flags

    @cached_property
    def mode(self) -> Any:
        """ "SAM", "LAM" or "" (N, T)."""
        named = np.where(self.region < LAM_PLUS, "SAM", "LAM")
        return np.where(self.is_known, named, "")


class AveragedEnsemble(Immutable):
    """The mean rotations of N bodies under the same torques.

    Tables of the torques are made once for each body and shared by its members.

    Parameters
    ----------
    motions : sequence of FreeRotation
        States at one epoch.
    torques, orbit, least_tilt, tolerance, degree, order
        As of `AveragedMotion`.
    passages : str or int
        "likeliest", or a whole number: the seed of draws that differ from member to member.
    on_error : str
        "raise", or "nan" for members that a mean motion refuses, as for torques that are not weak.
    names : sequence of str, optional

    Raises
    ------
    AttitudeError
        For no members, epochs that differ, and as `AveragedMotion` for the first member refused.
    """

    names: tuple[str, ...] | None
    torques: tuple[Torque, ...]

    def __init__(
        self,
        motions: Sequence[FreeRotation],
        torques: Any,
        *,
        orbit: Any = "auto",
        passages: Any = 0,
        least_tilt: Real = "0.01 deg",
        tolerance: Real = 1e-7,
        degree: int = DEGREE,
        order: int = 1,
        on_error: str = "raise",
        names: Sequence[str] | None = None,
    ) -> None:
        self._members: tuple[AveragedMotion | None, ...]
        states = list(motions)
        for motion in states:
            if not isinstance(motion, FreeRotation):
                raise AttitudeError(
                    f"motions holds {validation.shown(motion)}; give FreeRotations of one epoch."
                )
        if not states:
            raise AttitudeError("motions is empty; give at least one FreeRotation.")
        start = states[0].spin.epoch
        if any(motion.spin.epoch != start for motion in states):
            raise AttitudeError(
                "the members have epochs of their own; give states at one epoch for all members."
            )
        if passages == "all":
            raise AttitudeError(
                'passages is "all", which follows a tree for each member; give "likeliest" or the '
                "seed of a draw, or take ensemble[k].branches(until)."
            )
        if names is not None and len(names) != len(states):
            raise AttitudeError(f"names has {len(names)} entries for {len(states)} members.")
        self._set("names", None if names is None else tuple(map(str, names)))
        self._set("torques", _torques(torques))
        settings = Settings.checked(
            orbit, passages, least_tilt, tolerance, degree, len(self.torques), order
        )
        validation.one_of(on_error, "on_error", ("raise", "nan"))
        self._set("_members", self._made(states, settings, on_error))

    def _made(
        self, motions: Sequence[FreeRotation], settings: Settings, on_error: str
    ) -> tuple[AveragedMotion | None, ...]:
        """The members; None for one that is refused."""
        shared: dict[bytes, MeanTorques] = {}
        members: list[AveragedMotion | None] = []
        for k, motion in enumerate(motions):
            body = motion.body
            key = np.append(body.tensor, body.center_of_mass).tobytes() + bytes([body.relative])
            try:
                if key not in shared:
                    shared[key] = MeanTorques(
                        body, self.torques, motion.spin.epoch, settings.degree
                    )
                members.append(AveragedMotion._of_shared(shared[key], motion.spin, settings, k))
            except AttitudeError as err:
                if on_error == "raise":
                    raise AttitudeError(f"{self.label(k)}: {err}") from err
                members.append(None)
        if all(member is None for member in members):
            raise AttitudeError(
                'every member is refused as a mean motion; give on_error="raise" to see why.'
            )
        return tuple(members)

    @property
    def epoch(self) -> Instant:
        """Instant from which seconds count, that of all members."""
        return next(member for member in self._members if member is not None).epoch

    def label(self, k: int) -> str:
        """The name of a member, or its number."""
        return f"member {k}" if self.names is None else self.names[k]

    def __len__(self) -> int:
        return len(self._members)

    def __getitem__(self, k: int | str) -> AveragedMotion:
        """The motion of one member, of a number or a name."""
        if isinstance(k, str):
            if self.names is None or k not in self.names:
                raise AttitudeError(f"no member is named {k!r}.")
            k = self.names.index(k)
        member = self._members[k]
        if member is None:
            raise AttitudeError(f"{self.label(k)} is refused as a mean motion.")
        return member

    def __repr__(self) -> str:
        names = ", ".join(type(torque).__name__ for torque in self.torques)
        return f"<AveragedEnsemble of {len(self)} members: {names}>"

    def _extend(self, until: float, threads: int) -> None:
        """Integrate all members to seconds `until` or to their ends."""

        def work(begin: int, end: int) -> None:
            for member in self._members[begin:end]:
                if member is not None:
                    member.reaches(until)

        bar = ProgressBar("averaged members")
        in_blocks(work, len(self), _AT_ONCE, threads, bar)

    def at(self, t: Epochs, *, threads: int = 1) -> AveragedEnsembleHistory:
        """The mean states (N, T) of all members at epochs (T,), NaN beyond the end of a member.

        Parameters
        ----------
        t : epochs
            As of `AveragedMotion.at`.
        threads : int
            That integrate the members.

        Raises
        ------
        AttitudeError
            For epochs of another shape, and outside of the paths of the torques.
        """
        seconds = np.atleast_1d(seconds_of(self.epoch, t))
        if seconds.ndim != 1 or not len(seconds):
            raise AttitudeError(
                f"t has shape {seconds.shape}; give epochs (T,), the same for all members."
            )
        for until in {float(np.max(seconds)), float(np.min(seconds))}:
            self._extend(until, threads)
        rows: dict[int, list[int]] = {}
        for k, member in enumerate(self._members):
            if member is not None:
                rows.setdefault(id(member.packing), []).append(k)
        refused = [k for k, member in enumerate(self._members) if member is None]
        groups = []
        for index in rows.values():
            some = [*index, *refused]
            refused = []
            states = np.full((len(some), len(seconds), 4), np.nan)
            regions = np.zeros((len(some), len(seconds)), dtype=np.int64)
            for n, k in enumerate(index):
                states[n], regions[n] = self[k]._known(seconds)
            packing = self[index[0]].packing
            spread = np.broadcast_to(seconds, regions.shape)
            history = AveragedHistory(packing, spread, states, regions)
            groups.append((np.array(some), history))
        return AveragedEnsembleHistory(seconds, groups)

    def ends(self, until: Epochs, *, threads: int = 1) -> list[AveragedEvent | None]:
        """The event that ends each member before an epoch, or None."""
        end = second_of(self.epoch, until)
        self._extend(end, threads)
        return [None if member is None else member.ends(end) for member in self._members]

    def table(self, until: Epochs, *, threads: int = 1) -> QTable:
        """A QTable with a row for each member: its state at an epoch, or at its end before that.

        Columns: name, tdb_seconds, end, passages (their count), region, size, theta, P_psi, P_phi,
        pole_x, pole_y, pole_z.
        """
        from astropy.table import QTable
        from astropy.units import Quantity

        end = second_of(self.epoch, until)
        ends = self.ends(end, threads=threads)
        rows = []
        for member, event in zip(self._members, ends, strict=True):
            if member is None:
                rows.append(("refused", np.nan, 0, "", *[np.nan] * 7))
                continue
            last = end if event is None else event.seconds
            states = member.at(last)
            rows.append(
                (
                    "" if event is None else event.kind,
                    last,
                    member._count_passages(last),
                    REGIONS[int(states.region)],
                    *map(float, (states.size, states.theta, states.P_psi, states.P_phi)),
                    *states.pole.tolist(),
                )
            )
        columns = list(zip(*rows, strict=True))
        table = QTable({"name": [self.label(k) for k in range(len(self))]})
        table["end"] = list(columns[0])
        table["tdb_seconds"] = Quantity(columns[1], "s")
        table["passages"], table["region"] = list(columns[2]), list(columns[3])
        units = ("N m s", "rad", "s", "s", "", "", "")
        names = ("size", "theta", "P_psi", "P_phi", "pole_x", "pole_y", "pole_z")
        for name, unit, values in zip(names, units, columns[4:], strict=True):
            table[name] = Quantity(values, unit) if unit else np.array(values)
        return table
