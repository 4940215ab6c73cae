"""Values that do not change: read-only arrays, also after copying, pickling and unpickling."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = TypeVar("Array", bound=NDArray[Any])


def frozen(array: Array) -> Array:
    """The array itself, from now on read-only."""
    array.setflags(write=False)
    return array


def read_only(array: Array) -> Array:
    """A read-only view.

    Compiled code takes read-only arrays throughout: a writable array is another type, for which
    everything would be compiled once more.
    """
    view = array.view()
    view.flags.writeable = False
    return view


class Immutable:
    """Base of objects whose attributes do not change; what they compute on demand is kept."""

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{type(self).__name__} does not change; make a new one.")

    def __setstate__(self, state: dict[str, Any]) -> None:
        # numpy forgets in a pickle that an array is read-only.
        for name, value in state.items():
            object.__setattr__(self, name, _refrozen(value))

    def _set(self, name: str, value: Any) -> Any:
        """Assign while the object is being made, or keep what was computed on demand."""
        object.__setattr__(self, name, value)
        return value


def _refrozen(value):
    return frozen(value) if isinstance(value, np.ndarray) else value
