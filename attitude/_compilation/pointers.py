"""Numbers at addresses, and calls of functions by address, in compiled loops.

numba counts references to an array with atomic instructions, which stall the processor, wherever an
array is passed to a function.  An address is a plain integer; the caller keeps the memory alive.

The functions below are the definitions in Python; `lowering` has the instructions.
"""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray


_POINTER = ctypes.c_void_p
# void function(double t, double *, double *, double *, double *, double *)
C_FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.POINTER(ctypes.c_double)] * 5)
_CALL = ctypes.CFUNCTYPE(None, ctypes.c_double, *[_POINTER] * 5)
SCRATCH = 16  # doubles


class _Scratch(int):
    """The address of memory that lives as long as this object."""

    memory: ctypes.Array[ctypes.c_double]


def call(
    address: int, t: float, wxyz: int, omega: int, samples: int, parameters: int, out: int
) -> None:
    """Call the C function of a torque (`callbacks`); all arguments but t are addresses."""
    _CALL(int(address))(t, *map(int, (wxyz, omega, samples, parameters, out)))


def scratch() -> int:
    """The address of 16 doubles that live until the calling function returns.

    numba releases an array after the last use of its name, even while its address is in use.
    """
    memory = (ctypes.c_double * SCRATCH)()
    address = _Scratch(ctypes.addressof(memory))
    address.memory = memory
    return address


def number(address: int, k: int) -> float:
    """The k-th double, from 0, at an address."""
    return ctypes.c_double.from_address(int(address + 8 * k)).value


def whole(address: int, k: int) -> int:
    """The k-th 64-bit integer, from 0, at an address."""
    return ctypes.c_int64.from_address(int(address + 8 * k)).value


def put(address: int, k: int, x: float) -> None:
    """Store the k-th double at an address."""
    ctypes.c_double.from_address(int(address + 8 * k)).value = x


def put_three(address: int, k: int, x: float, y: float, z: float) -> None:
    """Store the doubles k, k + 1 and k + 2 at an address."""
    put(address, k, x)
    put(address, k + 1, y)
    put(address, k + 2, z)


def vector(pointer: Any, count: int) -> FloatArray:
    """The doubles at a C pointer as an array (count,)."""
    import numpy as np

    return np.ctypeslib.as_array(pointer, (count,))
