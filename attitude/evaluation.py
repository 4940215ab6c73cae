"""Constants and attitudes of freely rotating bodies, by the compiled solution.

It is imported (and, the first time on a machine, compiled) at the first propagation.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.errors import AttitudeError
from attitude.immutable import frozen, read_only
from attitude.solution import codes
from attitude.solution.record import CONSTANTS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray, IntArray

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


def constants_of(
    moments: FloatArray,
    wxyz: FloatArray,
    omega: FloatArray,
    principal: FloatArray,
    *,
    differences: FloatArray | None = None,
    rates: bool = True,
    wxyz_low: FloatArray | None = None,
    first: int = 0,
    count: int = 1,
) -> NDArray[Any]:
    """Constants (B,) of motions whose principal moments and rates are pairs of doubles.

    Parameters
    ----------
    moments, omega : (B, 3, 2) arrays
        Principal moments of inertia in any unit, and rad/s over the principal axes.
    wxyz : (B, 4) array
        Attitudes at the epoch, body to inertial.
    principal : (1 or B, 4) array
        Unit quaternion from principal axes to body axes.
    differences : (3, 2) array of a single motion or (B, 3, 2) array, optional
        Where these are known to more digits than follow from pairs of moments and rates: see
        `attitude.solution.principal.PrincipalAxes.differences`.  NaN for a motion without them.
    rates : bool
        Whether `evaluate` is to compute angular velocities.
    wxyz_low : (B, 4) array, optional
        Second doubles of the attitudes, which are then of unit length.
    first, count : int
        Number of the first body, and of all bodies, for the error message.

    Returns
    -------
    (B,) structured array of `attitude.solution.record.CONSTANTS`

    Raises
    ------
    AttitudeError
        For the first state that is not physical.
    """
    constants, faults = prepared(
        moments, wxyz, omega, principal, differences=differences, rates=rates, wxyz_low=wxyz_low
    )
    if faults:
        k = int(np.flatnonzero(constants["fault"])[0])
        where = f"State {first + k} of {count}: " if count > 1 else ""
        raise AttitudeError(where + fault_of(constants[k], moments[k], wxyz[k], omega[k]))
    return constants


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
    """As `constants_of`, but states that are not physical are counted, not refused.

    Returns
    -------
    constants : (B,) structured array
        ``fault`` is not 0 where the state is not physical.
    faults : int
        Number of such states.
    """
    prepare_all, _ = _compiled()
    # zeros, two microseconds faster than np.zeros of a record with so many fields
    constants: NDArray[Any] = np.ndarray(
        len(moments), CONSTANTS, bytearray(len(moments) * CONSTANTS.itemsize)
    )
    given = writable(moments), writable(wxyz), writable(omega), writable(principal)
    return constants, prepare_all(*given, constants, differences, rates, wxyz_low)


def faults_of(moments: FloatArray, wxyz: FloatArray, omega: FloatArray) -> IntArray:
    """Numbers (K,) of the states (B,), given as to `constants_of`, that are not physical."""
    _compiled()
    from attitude.solution.classify import classify_all

    constants: NDArray[Any] = np.ndarray(
        len(moments), CONSTANTS, bytearray(len(moments) * CONSTANTS.itemsize)
    )
    given = writable(moments), writable(wxyz), writable(omega)
    if not classify_all(*given, constants)[0]:
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
    """Fill attitudes and angular velocities of B motions at given epochs.

    Parameters
    ----------
    constants : (B,) array
        Of `constants_of`.
    t, t_low : (1 or B, T) arrays
        The epochs t + t_low, s; t_low may be None.  Read-only arrays save a view of each.
    wxyz : (B, 4, T) array
        Filled: body to inertial.
    rates : (B, 3, T) array or None
        Filled: rad/s over the body axes.

    Raises
    ------
    AttitudeError
        For epochs so far away that two doubles of time do not resolve the phases.
    """
    _, evaluate_all = _compiled()
    if t.flags.writeable:
        t = read_only(t)
    if t_low is not None and t_low.flags.writeable:
        t_low = read_only(t_low)
    count = t.shape[1]
    block = max(EPOCHS // len(constants), 1) if len(constants) > 1 else EPOCHS
    for first in range(0, count, block):
        end = first + block if first + block < count else count
        body = evaluate_all(constants, t, t_low, wxyz, rates, first, end)
        if body >= 0:
            row = body if len(t) > 1 else 0
            refuse_epoch(
                constants[body], t[row, first:end], None if t_low is None else t_low[row, first:end]
            )


def evaluated(
    constants: NDArray[Any],
    t: FloatArray,
    t_low: FloatArray | None,
    wxyz: FloatArray,
    rates: FloatArray | None,
    first: int,
    end: int,
) -> int:
    """As `evaluate` for the epochs from `first` to `end`, in one call of compiled code.

    Returns
    -------
    int
        -1, or the number of a motion with an epoch beyond its reach; then not all are filled.
    """
    _, evaluate_all = _compiled()
    found: int = evaluate_all(constants, t, t_low, wxyz, rates, first, end)
    return found


def refuse_epoch(constants: Any, t: FloatArray, t_low: FloatArray | None) -> None:
    """Raise the AttitudeError of a motion for epochs of which one is beyond its reach."""
    far = np.nanmax(np.abs(t if t_low is None else t + t_low))
    fastest = max(abs(constants[phase][0]) for phase in ("precession", "nutation"))
    raise AttitudeError(
        f"an epoch lies {far:.3g} s from that of the state; at {fastest:.3g} turns per second "
        "two doubles of time resolve this motion for 5e16 turns to either side. Give a nearer "
        "epoch."
    )


@cache
def _compiled():
    from attitude.solution.motion import evaluate_all, prepare_all

    return prepare_all, evaluate_all


def writable(array: Any) -> Any:
    """The array, or a contiguous copy of one that is read-only or strided: numba would compile
    everything anew for its type."""
    return array if array.flags.writeable and array.flags.c_contiguous else copy_of(array)


def copy_of(array: Any) -> Any:
    """A copy; of records by their bytes, because numpy copies them field by field."""
    if array.dtype.names is None or not array.flags.c_contiguous:
        return array.copy()
    return array.view(np.uint8).copy().view(array.dtype)


def _listed(row):
    return "(" + ", ".join(f"{x:.17g}" for x in row) + ")"
