"""The states of N freely rotating bodies: construction, members, parts and joined ensembles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from attitude import epochs, frames, validation
from attitude.body import Body
from attitude.ensemble import arguments, inertia, members
from attitude.ensemble import epoch as instants
from attitude.ensemble.inertia import Inertia
from attitude.ensemble.members import Members
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.immutable import Immutable, frozen
from attitude.spin import Spin

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import Epochs, FloatArray, IntArray, Reals
    from attitude.ensemble.rows import MemberGrid

_KEPT = (
    *("wxyz", "angular_velocity", "frame", "names", "on_error"),
    *("_inertia", "_members", "_low", "_start", "_bad"),
)


class Collection(Immutable):
    """Base of `Ensemble`: the states of its members, and how they are chosen and joined."""

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
        self._members: Members
        self._low: FloatArray | None
        self._start: FloatArray
        self._bad: IntArray
        if wxyz is None or angular_velocity is None:
            missing = "wxyz" if wxyz is None else "angular_velocity"
            raise AttitudeError(f"{missing} is missing; give one row, or one for each member.")
        relative = validation.flag(relative, "relative")
        rates = arguments.rows(angular_velocity, "angular_velocity", 3, "rad/s")
        attitudes = arguments.rows(wxyz, "wxyz", 4, None)
        start = instants.of_members(epoch)
        given = [each for each in (body, moments, tensors) if each is not None]
        if len(given) != 1:
            raise AttitudeError(
                "an Ensemble takes one of body=, moments= (N, 3) and tensors= (N, 3, 3)."
            )
        if moments is not None:
            found = inertia.of_moments(moments, relative)
        elif body is not None:
            found = inertia.of_bodies(
                [body] if isinstance(body, Body) else list(arguments.listed(body))
            )
        else:
            assert tensors is not None
            found = inertia.of_tensors(tensors, relative)
        sizes = {
            {2: "moments", 3: "tensors"}[found.array.ndim] if body is None else "body": found.size,
            "wxyz": len(attitudes),
            "angular_velocity": len(rates),
            "epoch": start.shape[1],
        }
        count = arguments.count(sizes, names)
        rates = np.broadcast_to(rates, (count, 3))
        attitudes = np.broadcast_to(attitudes, (count, 4))
        self._fill(found, attitudes, None, rates, start, frame, names, on_error)

    def _fill(
        self,
        given: inertia.Given,
        wxyz: FloatArray,
        low: FloatArray | None,
        rates: FloatArray,
        start: FloatArray,
        frame: str,
        names: Any,
        on_error: str,
    ) -> None:
        """Set the attributes of members, and check them."""
        self._set("on_error", validation.one_of(on_error, "on_error", ("raise", "nan")))
        self._set("frame", frames.known(frame))
        self._set("_start", frozen(start))
        self._set("_low", low)
        self._set("names", arguments.known_names(names, len(wxyz)))
        attitude = members.to_icrf(self.frame, wxyz, low)
        found, resolved = given.resolved(rates, on_error == "raise")
        self._set("_inertia", found)
        self._set("_members", Members(found.moments, found.principal, *resolved, *attitude))
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

    @classmethod
    def _of(cls, **values: Any) -> Self:
        """An ensemble with given attributes, which are those of checked members."""
        made = cls.__new__(cls)
        made.__setstate__(values)
        return made

    @classmethod
    def of(cls, motions: Iterable[FreeRotation], names: Sequence[str] | None = None) -> Self:
        """The ensemble of motions.

        Parameters
        ----------
        motions : iterable of FreeRotation
            Their frames are those of the spins; several frames become ICRF.  Covariances of spins
            are left out.
        names : sequence of str, optional

        Raises
        ------
        AttitudeError
            For other objects, and for no motions.
        """
        given = list(arguments.listed(motions))
        for k, motion in enumerate(given):
            if not isinstance(motion, FreeRotation):
                raise AttitudeError(
                    f"motion {k} is {validation.shown(motion)}; give FreeRotations."
                )
        if not given:
            raise AttitudeError("no motions are given; give at least one FreeRotation.")
        bodies = [motion.body for motion in given]
        found = inertia.of_bodies(bodies[:1] if all(b is bodies[0] for b in bodies) else bodies)
        spins = [motion.spin for motion in given]
        frame = spins[0].frame if len({spin.frame for spin in spins}) == 1 else "icrf"
        turned = any(spin.frame != frame for spin in spins)
        wxyz = np.array([spin.wxyz_icrf if turned else spin.wxyz for spin in spins])
        low = np.array([(s.wxyz_icrf_as_pairs if turned else s.wxyz_as_pairs)[:, 1] for s in spins])
        low[[not spin.is_rounded for spin in spins]] = 0.0
        rates = np.array([spin.angular_velocity for spin in spins])
        start = np.array([[s.epoch.seconds, s.epoch.low] for s in spins]).T.copy()
        if np.all(start == start[:, :1]):
            start = start[:, :1].copy()
        made = cls.__new__(cls)
        second = low if low.any() else None
        made._fill(found, wxyz, second, rates, start, frame, names, "raise")
        return made

    def _with_low(self, low: FloatArray) -> Self:
        """The same members, whose attitudes of unit length have second doubles (N, 4)."""
        if not low.any():
            return self
        made, attitude = self[:], members.to_icrf(self.frame, self.wxyz, low)
        made._set("_low", frozen(low))
        made._set("_members", replace(self._members, wxyz=attitude[0], low=attitude[1]))
        return made

    @classmethod
    def concatenated(cls, ensembles: Iterable[Self]) -> Self:
        """The members of several ensembles, one after the other; also ``first + second``.

        Raises
        ------
        AttitudeError
            For other objects, no ensembles, several frames, names of some of them only, and
            relative moments beside moments in kg m2.
        """
        parts = list(arguments.listed(ensembles))
        for part in parts:
            if not isinstance(part, Collection):
                raise AttitudeError(f"{validation.shown(part)} is no Ensemble; give ensembles.")
        if not parts:
            raise AttitudeError("no ensembles are given; give at least one.")
        if len({part.frame for part in parts}) > 1:
            named = ", ".join(sorted({part.frame for part in parts}))
            raise AttitudeError(f"the ensembles have the frames {named}; give ensembles of one.")
        if len({part.names is None for part in parts}) > 1:
            raise AttitudeError("only some of the ensembles have names; give names to all or none.")
        counts = [len(part) for part in parts]
        first = np.cumsum([0, *counts[:-1]])
        wrong = np.concatenate([part._bad + at for part, at in zip(parts, first, strict=True)])
        names = None if parts[0].names is None else np.concatenate([part.names for part in parts])
        return cls._of(
            wxyz=np.concatenate([part.wxyz for part in parts]),
            angular_velocity=np.concatenate([part.angular_velocity for part in parts]),
            frame=parts[0].frame,
            names=arguments.known_names(names, sum(counts)),
            on_error="nan" if any(part.on_error == "nan" for part in parts) else "raise",
            _inertia=inertia.joined([part._inertia for part in parts], counts),
            _members=members.joined([part._members for part in parts]),
            _low=members.joined_rows([(part._low, part.wxyz) for part in parts]),
            _start=arguments.joined_epochs([part._start for part in parts], counts),
            _bad=wrong,
        )

    def __add__(self, other: Self) -> Self:
        return type(self).concatenated([self, other])

    def __len__(self) -> int:
        return len(self.wxyz)

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
        array = np.asarray(index)
        if array.size == 0:
            array = array.astype(np.int64)
        if array.dtype.kind == "U":
            return np.array([self.number(each) for each in array.ravel()], dtype=np.int64)
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
            raise AttitudeError(
                f"member {array.ravel()[bad[0]]} (entry {bad[0]}) is out of range: the ensemble "
                f"has {len(self)} members, 0 to {len(self) - 1}."
            )
        found: IntArray = np.where(array < 0, array + len(self), array).astype(np.int64)
        return found

    def number(self, member: int | str) -> int:
        """The number of a member of a number (below 0: from the end) or a name.

        Raises
        ------
        AttitudeError
            For a number out of range, and a name that no member has.
        """
        if isinstance(member, str):
            found = -1 if self.names is None else self._numbers.get(member, -1)
            if found < 0:
                raise AttitudeError(
                    f"no member is called {member!r}"
                    + ("; the ensemble has no names." if self.names is None else ".")
                )
            return found
        if not isinstance(member, (int, np.integer)) or isinstance(member, bool):
            raise AttitudeError(f"member is {validation.shown(member)}; give a number or a name.")
        if not -len(self) <= member < len(self):
            raise AttitudeError(
                f"member {member} is out of range: the ensemble has {len(self)} members."
            )
        return int(member) % len(self)

    @property
    def _numbers(self) -> dict[str, int]:
        """The number of each name."""
        if "_by_name" not in self.__dict__:
            assert self.names is not None
            self._set("_by_name", {name: k for k, name in enumerate(self.names.tolist())})
        found: dict[str, int] = self.__dict__["_by_name"]
        return found

    def label(self, k: int) -> str:
        """The name of member k in error messages."""
        where = f"member {k} of {len(self)}"
        return where if self.names is None else f"{where} ({str(self.names[k])!r})"

    def _member(self, k: int) -> FreeRotation:
        if k in self._bad:
            raise AttitudeError(f"{self.label(k)}: {self._members.fault(k)}")
        given = self.epoch_of(k), self.wxyz[k], self.angular_velocity[k], self.frame
        spin = Spin(*given)
        if self._low is not None:
            spin._set("wxyz_as_pairs", frozen(np.stack([self.wxyz[k], self._low[k]], axis=-1)))
            spin._set("wxyz", frozen(self.wxyz[k].copy()))
        return FreeRotation(self._inertia.body(k), spin)

    def epoch_of(self, k: int) -> epochs.Instant:
        """The epoch from which the seconds of member k count."""
        return epochs.Instant(*self._start[:, k if self._start.shape[1] > 1 else 0])

    def epochs_of(self, member: IntArray) -> tuple[FloatArray, FloatArray]:
        """The epochs of members, TDB seconds past J2000 in two doubles, of the shape given."""
        which = member if self._start.shape[1] > 1 else np.zeros_like(member)
        return self._start[0][which], self._start[1][which]

    @property
    def epoch(self) -> epochs.Instant | None:
        """The epoch that all members share, or None."""
        return self.epoch_of(0) if self._start.shape[1] == 1 else None

    @property
    def start_of_seconds(self) -> epochs.Instant:
        """The epoch that all members share, or J2000."""
        return self.epoch_of(0) if self._start.shape[1] == 1 else epochs.Instant(0.0)

    @property
    def is_physical(self) -> NDArray[np.bool_]:
        """(N,) whether each member has a state that a body can have."""
        found = np.ones(len(self), dtype=bool)
        found[self._bad] = False
        return found

    if TYPE_CHECKING:

        def grid_of(self, t: Any, low: Any = None) -> MemberGrid:
            """Defined by `attitudes.Evaluated`."""

    def __getstate__(self) -> dict[str, Any]:
        return {name: self.__dict__[name] for name in _KEPT}

    def __repr__(self) -> str:
        start = "epochs of their own" if self.epoch is None else f"{self.epoch.utc_iso} UTC"
        return f"<{type(self).__name__} of {len(self)} members, from {start}>"
