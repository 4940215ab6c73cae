"""States of N members as the compiled solution takes them: epochs, inertia, attitudes in ICRF."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import frames
from attitude._solver.principal_axes import PrincipalAxes
from attitude._solver.states import BLOCK, IDENTITY, spread_rows, symmetric_tensors
from attitude._support import pairs as support_pairs
from attitude._support import validation
from attitude._support.arrays import frozen
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.motions._body import Body

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import FloatArray, IntArray, Reals


# ---- Epochs of members, and the epochs at which they are evaluated, as TDB seconds

_DATES = "ISO dates in UTC, an astropy or skyfield Time, datetimes or datetime64"


def of_members(epoch: Any) -> FloatArray:
    """The epochs of members as TDB seconds past J2000 in two doubles, (2, 1) or (2, N)."""
    if isinstance(epoch, _instants.Instant):
        return np.array([[epoch.seconds], [epoch.low]])
    if isinstance(epoch, support_pairs.Seconds):
        return np.stack(support_pairs.two_sum(epoch.hi, epoch.low))
    if epoch is None:
        raise AttitudeError(f"epoch is missing; give one epoch, or one for each member: {_DATES}.")
    kind, _, _ = _inputs.entries(epoch, "epoch", _DATES)
    if kind in _inputs.LENGTHS:
        raise AttitudeError(
            f"epoch is {validation.shown(epoch)}, a length of time; give one epoch, or one for "
            f"each member: {_DATES}."
        )
    hi, lo = _inputs.past_j2000(epoch, "epoch")
    if hi.ndim > 1:
        raise AttitudeError(f"epoch has shape {hi.shape}; give one epoch, or one for each member.")
    sums = np.stack(support_pairs.two_sum(hi, lo)).reshape(2, -1)
    bad = np.flatnonzero(~np.isfinite(sums[0]))
    if len(bad):
        raise AttitudeError(
            f"epoch {bad[0]} of {sums.shape[1]} is missing (NaT, NaN or masked); give a date for "
            "each member."
        )
    return sums


def shared(
    start: FloatArray, t: Any, low: ArrayLike | None, count: int
) -> tuple[support_pairs.Seconds, bool]:
    """Epochs (1 or N, T) of all of N members, and if T is one; start (2, 1), t (T,)."""
    hi, lo, are_dates = _epochs(start, t, low)
    if hi.ndim > 2 or (hi.ndim == 2 and len(hi) != count):
        raise AttitudeError(
            f"t has shape {hi.shape}; give (T,) for all members or ({count}, T), one row for each; "
            "for other rows give member=."
        )
    scalar = hi.ndim == 0
    seconds = support_pairs.Seconds(hi, lo).mapped(np.atleast_2d)
    if are_dates:
        seconds = support_pairs.Seconds(*seconds.plus(-start[0][:, None], -start[1][:, None]))
    return seconds, scalar


def received(
    start: _instants.Instant, shared: _instants.Instant | None, t: Any, low: ArrayLike | None
) -> tuple[FloatArray, FloatArray | None]:
    """Epochs (T,) of a scene as seconds since `start`, in two doubles."""
    if shared is None:
        hi, lo = support_pairs.add(_inputs.past_j2000(t, "t"), -start.seconds, -start.low)
    else:
        hi, lo = _inputs.seconds_since(start, t, low)
    if hi.ndim != 1:
        raise AttitudeError(f"t has shape {hi.shape}; give (T,), the epochs of a scene.")
    return hi, lo


def of_rows(
    start: FloatArray, t: Any, low: ArrayLike | None, member: IntArray
) -> tuple[support_pairs.Seconds, IntArray]:
    """Epochs of rows and their members, of any shape S."""
    hi, lo, are_dates = _epochs(start, t, low)
    seconds = support_pairs.Seconds(hi, lo)
    if hi.shape != member.shape:
        if hi.ndim and member.ndim:
            raise AttitudeError(
                f"t has shape {hi.shape} and member {member.shape}; give one member for each epoch."
            )
        shape = hi.shape if hi.ndim else member.shape
        seconds = seconds.mapped(lambda array: np.array(np.broadcast_to(array, shape)))
        member = np.array(np.broadcast_to(member, shape))
    if are_dates:
        seconds = support_pairs.Seconds(*seconds.plus(-start[0][member], -start[1][member]))
    return seconds, member


def _epochs(
    start: FloatArray, t: Any, low: ArrayLike | None
) -> tuple[FloatArray, FloatArray | None, bool]:
    """Epochs in two doubles, and whether they are past J2000; else s as given, or since a date."""
    if start.shape[1] != 1 and not (type(t) is np.ndarray and t.dtype == np.float64):
        kind, _, _ = _inputs.entries(t, "t", _DATES)
        if kind == "TimeDelta":
            raise AttitudeError(
                "t is a TimeDelta, but the members have epochs of their own; give seconds, a "
                "Quantity or dates."
            )
        if kind not in _inputs.LENGTHS:
            if low is not None:
                raise AttitudeError(
                    f"low is given, but t is {validation.shown(t)}; leave out low, the second "
                    "double of plain seconds."
                )
            return *_inputs.past_j2000(t, "t"), True
    # Without members any epoch will do.
    first = _instants.Instant(*start[:, 0]) if start.shape[1] else _instants.J2000
    return *_inputs.seconds_since(first, t, low), False


# ---- The inertia of N bodies as arrays, one row for all of them or one each


class Given(NamedTuple):
    """What a caller gave as bodies, one row for all of them or one each.

    array: principal moments about the body axes, or tensors; kg m2, or relative.
    """

    array: FloatArray  # (1 or N, 3) or (1 or N, 3, 3)
    relative: bool  # whether the unit is unknown
    bodies: NDArray[np.object_] | None  # (1 or N,) of Body, if objects were given

    def resolved(
        self, omega: FloatArray, raises: bool
    ) -> tuple[Inertia, FloatArray, FloatArray | None]:
        """The inertia, and `omega` and `differences` of the `States` of rates (N, 3), body axes."""
        count = len(self.array)
        moments, axes = np.zeros((count, 3, 2)), np.broadcast_to(np.eye(3), (count, 3, 3))
        if self.array.ndim == 2:
            moments[..., 0] = self.array
            principal = np.broadcast_to(IDENTITY, (count, 4))
            return Inertia(*self, moments, axes, principal), omega, None
        axes, principal = np.empty((count, 3, 3)), np.empty((count, 4))
        rates, differences = np.empty((2, len(omega), 3, 2))
        for first in range(0, len(omega), BLOCK):
            block = slice(first, first + BLOCK)
            if count > 1 or first == 0:
                of = block if count > 1 else slice(0, 1)
                some = symmetric_tensors(self.array[of], first, count, raises=raises)
                axes_of_block = PrincipalAxes.of(some)
                moments[of], axes[of], principal[of] = (
                    axes_of_block.moments,
                    axes_of_block.axes[..., 0],
                    axes_of_block.wxyz,
                )
            rates[block], differences[block] = axes_of_block.over_axes(omega[block].copy())
        inertia = Inertia(*self, moments, axes, principal)
        if np.isnan(differences[:, 0, 0]).all() and not rates[..., 1].any():
            return inertia, np.ascontiguousarray(rates[..., 0]), None
        return inertia, rates, differences


@dataclass(frozen=True, eq=False)
class Inertia:
    """Moments of N bodies; arrays have the leading axis 1 if all bodies share one inertia.

    array, relative, bodies: as in `Given`.
    """

    array: FloatArray
    relative: bool
    bodies: NDArray[np.object_] | None
    moments: FloatArray  # (1 or N, 3, 2), principal moments in pairs of doubles
    axes: FloatArray  # (1 or N, 3, 3), columns: the principal axes in body axes
    principal: FloatArray  # (1 or N, 4), the unit quaternion from principal to body axes

    def __len__(self) -> int:
        """1, or the number of bodies."""
        return self.array.shape[0]

    def body(self, k: int) -> Body:
        """The Body of member k."""
        k = k if len(self) > 1 else 0
        if self.bodies is not None:
            return self.bodies[k]
        kind = "moments" if self.array.ndim == 2 else "tensor"
        return Body(**{kind: self.array[k]}, relative=self.relative)

    def taken(self, index: Any) -> Inertia:
        """The inertia of some of the members."""
        if len(self) == 1:
            return self
        bodies = None if self.bodies is None else self.bodies[index]
        arrays = (array[index] for array in (self.moments, self.axes, self.principal))
        return Inertia(self.array[index], self.relative, bodies, *arrays)

    @property
    def has_tensors(self) -> bool:
        """Whether the principal axes of any member may differ from its body axes."""
        return self.array.ndim == 3

    def tensors(self) -> FloatArray:
        """Inertia tensors (1 or N, 3, 3) in body axes."""
        return self.array if self.has_tensors else self.array[:, :, None] * np.eye(3)


def of_arrays(inertia: Reals, name: str, last: tuple[int, ...], relative: bool) -> Given:
    """Principal moments (3,) or (N, 3) about the body axes, or tensors (3, 3) or (N, 3, 3)."""
    return Given(rows(inertia, name, last, None if relative else "kg m2"), relative, None)


def of_bodies(bodies: Sequence[Body]) -> Given:
    """Body objects, one for all members or one each."""
    for k, body in enumerate(bodies):
        validation.instance(body, Body, f"body {k}", "one Body, or one for each member")
    relative = {body.relative for body in bodies}
    if len(relative) > 1:
        raise AttitudeError(
            "some bodies have relative moments and others have moments in kg m2; give members of "
            "both kinds as two ensembles."
        )
    objects = np.empty(len(bodies), dtype=object)
    objects[:] = bodies
    plain = all(body.has_given_axes for body in bodies)
    array = np.array([body.moments if plain else body.tensor for body in bodies])
    return Given(
        array.reshape(len(bodies), *((3,) if plain else (3, 3))), True in relative, objects
    )


def joined_inertia(parts: Sequence[Inertia], counts: Sequence[int]) -> Inertia:
    """The inertia of ensembles of `counts` members, one after the other."""
    first = parts[0]
    if len({inertia.relative for inertia in parts}) > 1:
        raise AttitudeError(
            "one ensemble has relative moments and another has moments in kg m2; they stay apart."
        )
    if all(inertia is first and len(inertia) == 1 for inertia in parts):
        return first
    tensors = any(inertia.has_tensors for inertia in parts)
    array = spread_rows(
        [inertia.tensors() if tensors else inertia.array for inertia in parts], counts
    )
    objects = [inertia.bodies for inertia in parts if inertia.bodies is not None]
    bodies = spread_rows(objects, counts) if len(objects) == len(parts) else None
    names = "moments", "axes", "principal"
    arrays = (spread_rows([getattr(inertia, name) for inertia in parts], counts) for name in names)
    return Inertia(array, first.relative, bodies, *arrays)


def to_icrf(
    frame: str, wxyz: FloatArray, low: FloatArray | None
) -> tuple[FloatArray, FloatArray | None]:
    """Attitudes (N, 4) and their second doubles (or None) in ICRF, as `Spin` has them."""
    if low is None:
        wxyz, low = quaternion.all_unit_in_pairs(wxyz)
    if frame == "icrf":
        return wxyz, low
    turned = quaternion.multiply(frames.wxyz_to_icrf(frame), wxyz)
    if low is None:
        return turned, None
    rounded = np.flatnonzero(low.any(axis=1))
    pairs = np.stack([wxyz[rounded], low[rounded]], axis=-1)
    in_icrf = frames.attitude_to_icrf(frame, pairs)
    second = np.zeros(wxyz.shape)
    turned[rounded], second[rounded] = in_icrf[..., 0], in_icrf[..., 1]
    return turned, second


# ---- Arguments of ensembles: rows, names, and numbers of members that agree


def listed(objects: Any) -> Iterable[Any]:
    """The entries of an iterable; AttitudeError for anything else."""
    try:
        return iter(objects)
    except TypeError as err:
        raise AttitudeError(f"{validation.shown(objects)} is not a list of objects.") from err


def rows(values: Any, name: str, last: tuple[int, ...], unit: str | None) -> FloatArray:
    """Rows (N, *last), or one row (1, *last); NaN is left to the check of the members."""
    array = validation.real(values, name, unit=unit, finite=False)
    if array.shape == last:
        return array[None]
    if array.shape[1:] == last:
        return array
    listed = ", ".join(map(str, last))
    raise AttitudeError(f"{name} has shape {array.shape}; give {last} or (N, {listed}).")


def count(sizes: dict[str, int], names: Any) -> int:
    """The number of members, from the lengths of the arguments, each of which may be 1."""
    if names is not None:
        if not hasattr(names, "__len__"):
            raise AttitudeError(f"names is {validation.shown(names)}; give one for each member.")
        sizes = {**sizes, "names": len(names)}
    several = {name: size for name, size in sizes.items() if size != 1}
    if len(set(several.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in several.items())
        raise AttitudeError(
            f"the arguments have different numbers of members ({listed}); give the same number, or "
            "one for all."
        )
    return next(iter(several.values()), 1)


def known_names(names: Any, count: int) -> NDArray[np.str_] | None:
    """Names (N,) of which no two are equal, without blanks at their ends, or None."""
    if names is None:
        return None
    labels = np.array([str(label).strip() for label in np.asarray(names).ravel().tolist()], np.str_)
    if len(labels) != count:
        raise AttitudeError(f"{len(labels)} names are given for {count} members; give one each.")
    unique, times = np.unique(labels, return_counts=True)
    if len(unique) < len(labels):
        name = unique[np.argmax(times > 1)]
        raise AttitudeError(f"two members are called {str(name)!r}; give names that differ.")
    if "" in unique:
        raise AttitudeError(f"member {labels.tolist().index('')} has an empty name; give it one.")
    return frozen(labels)


def joined_epochs(starts: Sequence[FloatArray], counts: Sequence[int]) -> FloatArray:
    """The epochs (2, N) of joined ensembles, (2, 1) if all are equal."""
    if all(epochs.shape[1] == 1 and np.array_equal(epochs, starts[0]) for epochs in starts):
        return starts[0]
    parts = zip(starts, counts, strict=True)
    return np.concatenate([np.broadcast_to(epochs, (2, n)) for epochs, n in parts], axis=1)
