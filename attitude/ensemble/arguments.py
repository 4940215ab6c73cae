"""Arguments of ensembles: rows, names, and numbers of members that agree."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import frozen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray


def listed(given: Any) -> Iterable[Any]:
    """The entries of an iterable; AttitudeError for anything else."""
    try:
        return iter(given)
    except TypeError as err:
        raise AttitudeError(f"{validation.shown(given)} is not a list of objects.") from err


def rows(given: Any, name: str, width: int, unit: str | None) -> FloatArray:
    """Rows (N, width), or one row (1, width); NaN is left to the check of the members."""
    array = validation.real(given, name, unit=unit, finite=False)
    if array.shape == (width,):
        return array[None]
    if array.ndim == 2 and array.shape[1] == width:
        return array
    raise AttitudeError(f"{name} has shape {array.shape}; give ({width},) or (N, {width}).")


def count(sizes: dict[str, int], names: Any) -> int:
    """The number of members, from the lengths of the arguments, each of which may be 1."""
    if names is not None:
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
    """Names (N,) of which no two are equal, or None."""
    if names is None:
        return None
    found = np.array([str(each) for each in np.asarray(names).ravel().tolist()], dtype=np.str_)
    if len(found) != count:
        raise AttitudeError(f"{len(found)} names are given for {count} members; give one each.")
    unique, times = np.unique(found, return_counts=True)
    if len(unique) < len(found):
        name = unique[np.argmax(times > 1)]
        raise AttitudeError(f"two members are called {str(name)!r}; give names that differ.")
    return frozen(found)


def joined_epochs(starts: Sequence[FloatArray], counts: Sequence[int]) -> FloatArray:
    """The epochs (2, N) of joined ensembles, (2, 1) if all are equal."""
    if all(each.shape[1] == 1 and np.array_equal(each, starts[0]) for each in starts):
        return starts[0]
    parts = zip(starts, counts, strict=True)
    return np.concatenate([np.broadcast_to(each, (2, n)) for each, n in parts], axis=1)
