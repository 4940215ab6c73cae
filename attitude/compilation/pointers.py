"""Numbers at addresses, and functions that are called by theirs, in compiled loops.

numba counts the references to an array by atomic instructions, for which all that is under way
must be waited for, wherever one is passed to a function; an address is a number like others.  The
caller keeps the memory alive.

The functions below define each in Python; `lowering` has the instructions.
"""

import ctypes

_POINTER = ctypes.c_void_p
# void function(double t, double *, double *, double *, double *, double *): see solution.march
C_FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.POINTER(ctypes.c_double)] * 5)
_CALL = ctypes.CFUNCTYPE(None, ctypes.c_double, *[_POINTER] * 5)
SCRATCH = 16  # doubles


class _Scratch(int):
    """The address of memory that lives as long as this number does."""


def call(address, t, wxyz, omega, given, parameters, out):
    """Call a function of `solution.march`; all but t are addresses."""
    _CALL(int(address))(t, *map(int, (wxyz, omega, given, parameters, out)))


def scratch():
    """The address of 16 doubles that last as long as the calling function.

    An array would be released after its last use by name, whoever holds its address.
    """
    memory = (ctypes.c_double * SCRATCH)()
    address = _Scratch(ctypes.addressof(memory))
    address.memory = memory
    return address


def number(address, k):
    """The double in place k from an address."""
    return ctypes.c_double.from_address(int(address + 8 * k)).value


def whole(address, k):
    """The whole number of 64 bits in place k from an address."""
    return ctypes.c_int64.from_address(int(address + 8 * k)).value


def put(address, k, x):
    """Store a double in place k from an address."""
    ctypes.c_double.from_address(int(address + 8 * k)).value = x


def put_three(address, k, x, y, z):
    """Store three doubles from place k on."""
    put(address, k, x)
    put(address, k + 1, y)
    put(address, k + 2, z)


def vector(pointer, count):
    """The doubles at a C pointer as an array (count,)."""
    import numpy as np

    return np.ctypeslib.as_array(pointer, (count,))
