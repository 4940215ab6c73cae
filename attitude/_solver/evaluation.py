"""Constants and attitudes of freely rotating bodies, by the compiled solution.

It is imported (and, the first time on a machine, compiled) at the first propagation.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver import codes, kernel
from attitude._solver.constants import (
    classify_all,
    hyperbolic_all,
    hyperbolic_rates_all,
    refine_all,
    solve_all,
    trigonometric_all,
    trigonometric_rates_all,
    uniform_all,
)
from attitude._solver.kernel import attach_all
from attitude._solver.records import CONSTANTS
from attitude._support.arrays import frozen, read_only
from attitude._support.pairs import Seconds
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude._compilation.decorators import EntryPoint
    from attitude._support.annotations import FloatArray, IntArray


# ---- Entry points of the solution: compute the constants of B motions, evaluate them at epochs
# All loops over bodies and epochs are compiled.  Each stage, and each form of the solution, is
# compiled separately and only when a state needs it: nested in one function, they would be
# optimised again at every level, for seconds.  ``entry_point.run(...)`` saves the 0.1 us of one
# more call of a Python function.

# Writable, as in all calls: to numba a read-only array is another type.
_NO_LOW = np.zeros((1, 4))
# Bytes of the constants of a motion.
_SIZE = CONSTANTS.itemsize


def _take_differences(differences, constants):
    """Fill differences (B, 3, 2) of the motions that have them and tumble; whether any other may.

    They are exact, in place of those that cancelled.
    """
    if len(constants) == 1:  # without masks, which take ten microseconds
        only = differences[0]
        if math.isnan(only[0, 0]):
            return True
        constants["gaps"], constants["d2"] = only[:2], only[2]
        return False
    known = (constants["form"] != codes.UNIFORM) & ~np.isnan(differences[:, 0, 0])
    constants["gaps"][known], constants["d2"][known] = differences[known, :2], differences[known, 2]
    constants["cancelled"][known] = 0
    return True


def evaluate_all(
    constants: NDArray[Any],
    t: FloatArray,
    t_low: FloatArray | None,
    wxyz: FloatArray,
    rates: FloatArray | None,
    first: int,
    end: int,
) -> int:
    """Fill columns of attitudes, and of angular velocities unless rates is None: see `kernel`.

    Returns -1, or the number of a body with an epoch beyond its reach; then not all are filled.
    """
    # To numba a read-only array is of another type, for which each loop would be compiled anew.
    if constants.flags.writeable:
        constants = read_only(constants)
    if t.flags.writeable:
        t = read_only(t)
    if t_low is not None and t_low.flags.writeable:
        t_low = read_only(t_low)
    for form in set(constants["form"].tolist()):
        body = OF_FORM[form].run(constants, t, t_low, wxyz, rates, first, end, first)
        if body >= 0:
            return body
    return -1


OF_FORM: dict[int, EntryPoint] = {
    codes.UNIFORM: kernel.uniform,
    codes.TRIGONOMETRIC: kernel.trigonometric,
    codes.HYPERBOLIC: kernel.hyperbolic,
}


# So many epochs, 2 ms of work, are evaluated in one call of compiled code: Python acts on signals,
# such as that of Ctrl-C, between the calls.
EPOCHS = 1 << 18
_NO_FAULT = frozen(np.zeros(0, dtype=np.int64))

_FAULTS = {
    codes.BAD_MOMENT: (
        "moments are {moments}; principal moments of inertia must be finite and not negative, "
        "and at most one of them zero."
    ),
    codes.NO_TRIANGLE: (
        "moments are {moments}; no body has a moment of inertia that exceeds the sum of the other "
        "two. Check the numbers and their units."
    ),
    codes.RATIO_TOO_LARGE: (
        "moments are {moments}; they may differ by a factor of at most 1e45. Give 0 for the "
        "moment of an ideal rod about itself."
    ),
    codes.SPIN_ABOUT_ROD: (
        "the angular velocity is {omega} rad/s and the moments are {moments}; the spin about an "
        "axis without inertia is undefined. Give 0 for that component, or a moment above zero."
    ),
    codes.UNEQUAL_ROD: (
        "moments are {moments}; a body without inertia about one axis is a rod, whose other two "
        "moments are equal. Give two equal moments, or three above zero."
    ),
    codes.BAD_RATE: "the angular velocity is {omega} rad/s; each component must be finite.",
    codes.LOST_RATE: (
        "the angular velocity is {omega} rad/s, about the middle axis but for rates below 2^-400 "
        "(4e-121) of it. They turn the body over in the end, and doubles do not follow them until "
        "then: give 0 for them, or larger ones."
    ),
    codes.BAD_ATTITUDE: "wxyz is {wxyz}; give four finite numbers that are not all zero.",
}


def prepared(
    moments: FloatArray,
    wxyz: FloatArray,
    omega: FloatArray,
    principal: FloatArray,
    *,
    differences: FloatArray | None = None,
    rates: bool = True,
    wxyz_low: FloatArray | None = None,
) -> tuple[NDArray[Any], int]:
    """Constants (B,) of motions, and how many have a fault: what is not physical.

    Given
        moments    (B, 3, 2) principal moments, pairs
        wxyz       (B, 4) body to inertial at the epoch, any length
        omega      (B, 3, 2) rad/s over the principal axes, pairs
        principal  (1 or B, 4) unit quaternion, principal axes to given body axes
        differences  (B, 3, 2) B - A, C - B and D2, pairs, where principal_axes has them to more
                   digits than follow from the pairs above; NaN for motions without; or None
        rates      whether the series of the angular velocity are filled too
        wxyz_low   (B, 4) second doubles of wxyz, then of unit length; or None
    """
    # zeros, two microseconds faster than np.zeros of a record with so many fields
    count = len(moments)
    constants: NDArray[Any] = np.ndarray(count, CONSTANTS, bytearray(count * _SIZE))
    # as `writable`, without calls of functions, which take half a microsecond in all
    if not moments.flags.carray:
        moments = moments.copy()
    if not wxyz.flags.carray:
        wxyz = wxyz.copy()
    if not omega.flags.carray:
        omega = omega.copy()
    if not principal.flags.carray:
        principal = principal.copy()
    low = _NO_LOW if wxyz_low is None else wxyz_low
    faults, uniform, cancelled = classify_all.run(moments, wxyz, omega, constants)
    if uniform:
        uniform_all.run(wxyz, low, principal, constants)
    tumbling = count - faults - uniform
    if tumbling:
        if differences is not None:
            cancelled = _take_differences(differences, constants) and cancelled
        if cancelled:
            refine_all(constants)
        hyperbolic = solve_all.run(constants)
        if hyperbolic < tumbling:
            trigonometric_all.run(constants)
            if rates:
                trigonometric_rates_all.run(constants)
        if hyperbolic:
            hyperbolic_all.run(constants)
            if rates:
                hyperbolic_rates_all.run(constants)
        attach_all.run(wxyz, low, principal, constants)
    return constants, faults


def faults_of(moments: FloatArray, wxyz: FloatArray, omega: FloatArray) -> IntArray:
    """Numbers (K,) of the states (B,), given as to `prepared`, that are not physical."""
    count = len(moments)
    constants: NDArray[Any] = np.ndarray(count, CONSTANTS, bytearray(count * _SIZE))
    if not classify_all(writable(moments), writable(wxyz), writable(omega), constants)[0]:
        return _NO_FAULT
    return np.flatnonzero(constants["fault"])


def fault_of(constants: Any, moments: FloatArray, wxyz: FloatArray, omega: FloatArray) -> str:
    """The sentence on a state that is not physical, with its numbers; arguments as of one body."""
    return _FAULTS[int(constants["fault"])].format(
        moments=_listed(moments[:, 0]), wxyz=_listed(wxyz), omega=_listed(omega[:, 0])
    )


def evaluate(
    constants: NDArray[Any],
    t: FloatArray,
    t_low: FloatArray | None,
    wxyz: FloatArray,
    rates: FloatArray | None,
) -> None:
    """Fill wxyz (B, 4, T) and rates (B, 3, T) of B motions at epochs t, t_low (1 or B, T)."""
    count = t.shape[1]
    block = max(EPOCHS // len(constants), 1) if len(constants) > 1 else EPOCHS
    for first in range(0, count, block):
        end = first + block if first + block < count else count
        body = evaluate_all(constants, t, t_low, wxyz, rates, first, end)
        if body >= 0:
            few = body if len(t) > 1 else 0, slice(first, end)
            raise AttitudeError(refusal(constants[body], *Seconds(t, t_low).taken(few)))


def refusal(constants: Any, t: FloatArray, t_low: FloatArray | None) -> str:
    """The sentence on a motion and epochs of which one is beyond its reach."""
    far = np.nanmax(np.abs(Seconds(t, t_low).rounded))
    fastest = max(abs(constants[phase][0]) for phase in ("precession", "nutation"))
    return (
        f"an epoch lies {far:.3g} s from that of the state; at {fastest:.3g} turns per second "
        "two doubles of time resolve this motion for 5e16 turns to either side. Give a nearer "
        "epoch."
    )


def writable(array: Any) -> Any:
    """The array; of a read-only or strided one, for which numba compiles anew, a plain copy."""
    return array if array.flags.carray else copy_of(array)


def copy_of(array: Any) -> Any:
    """A copy; of records by their bytes, because numpy copies them field by field."""
    if array.dtype.names is None or not array.flags.c_contiguous:
        return array.copy()
    return array.view(np.uint8).copy().view(array.dtype)


def _listed(row):
    return "(" + ", ".join(f"{x:.17g}" for x in row) + ")"
