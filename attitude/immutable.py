"""Values that do not change: read-only arrays, also after copying, pickling and unpickling."""

import numpy as np


def frozen(array):
    """The array itself, from now on read-only."""
    array.setflags(write=False)
    return array


def read_only(array):
    """A read-only view; always one, since a writable array is another type to numba, for which all
    would be compiled once more.
    """
    view = array.view()
    view.flags.writeable = False
    return view


class Frozen:
    """For frozen dataclasses with arrays: numpy forgets in a pickle that an array is read-only."""

    def __setstate__(self, state):
        for name, value in state.items():
            object.__setattr__(self, name, _refrozen(value))

    def _set(self, name, value):
        """Assign while the object is being made, or keep what was computed on demand."""
        object.__setattr__(self, name, value)
        return value


def _refrozen(value):
    return frozen(value) if isinstance(value, np.ndarray) else value
