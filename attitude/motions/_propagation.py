"""Exact attitudes from plain arrays, for optimisers and inner loops."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from attitude._solver.states import IDENTITY, Evaluation, Results, States, StatesOfTensors
from attitude._support import validation
from attitude._support.arrays import frozen, new_array, put
from attitude._support.pairs import Seconds
from attitude._support.synonyms import arguments
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import FloatArray, Reals


_HINTS = {
    "body": "give body.moments first, or use FreeRotation(body, spin).at(t)",
    "spin": "give spin.wxyz and spin.angular_velocity, or use FreeRotation(body, spin).at(t)",
    **dict.fromkeys(("q0", "wxyz", "quaternion"), "give wxyz0="),
    **dict.fromkeys(("w0", "omega"), "give omega0="),
}


@overload
def propagate(
    moments: Reals | None,
    wxyz0: Reals,
    omega0: Reals,
    t: Reals,
    *,
    tensors: Reals | None = None,
    t_low: Reals | None = None,
    angular_velocity: Literal[False] = False,
    out: FloatArray | None = None,
    rates_out: None = None,
    threads: int = 1,
) -> FloatArray: ...


@overload
def propagate(
    moments: Reals | None,
    wxyz0: Reals,
    omega0: Reals,
    t: Reals,
    *,
    tensors: Reals | None = None,
    t_low: Reals | None = None,
    angular_velocity: Literal[True],
    out: FloatArray | None = None,
    rates_out: FloatArray | None = None,
    threads: int = 1,
) -> tuple[FloatArray, FloatArray]: ...


@overload
def propagate(
    moments: Reals | None,
    wxyz0: Reals,
    omega0: Reals,
    t: Reals,
    *,
    tensors: Reals | None = None,
    t_low: Reals | None = None,
    angular_velocity: bool = False,
    sensitivity: Literal[True],
    out: FloatArray | None = None,
    rates_out: FloatArray | None = None,
    sensitivity_out: FloatArray | None = None,
    threads: int = 1,
) -> tuple[FloatArray, ...]: ...


@overload
def propagate(
    moments: Reals | None,
    wxyz0: Reals,
    omega0: Reals,
    t: Reals,
    *,
    tensors: Reals | None = None,
    t_low: Reals | None = None,
    angular_velocity: bool,
    out: FloatArray | None = None,
    rates_out: FloatArray | None = None,
    threads: int = 1,
) -> FloatArray | tuple[FloatArray, FloatArray]: ...


@arguments(
    _HINTS,
    "propagate(moments, wxyz0, omega0, t); of a body and a spin, FreeRotation(body, spin).at(t)",
)
def propagate(
    moments: Reals | None,
    wxyz0: Reals,
    omega0: Reals,
    t: Reals,
    *,
    tensors: Reals | None = None,
    t_low: Reals | None = None,
    angular_velocity: bool = False,
    sensitivity: bool = False,
    out: FloatArray | None = None,
    rates_out: FloatArray | None = None,
    sensitivity_out: FloatArray | None = None,
    threads: int = 1,
) -> FloatArray | tuple[FloatArray, ...]:
    """Exact attitudes of freely rotating bodies at any time.

    Parameters
    ----------
    moments : (..., 3) array_like, or None
        Principal moments of inertia about the body axes x, y, z: any unit, any order.  None with
        `tensors`.
    wxyz0 : (..., 4) array_like
        Attitude at t = 0, body to inertial, scalar first; of any length.
    omega0 : (..., 3) array_like
        Angular velocity at t = 0 over the body axes, rad/s.
    t : (..., T) array_like, or a number
        Seconds.  The last axis is time; the others broadcast with those of the bodies.
        NaN gives NaN.
    tensors : (..., 3, 3) array_like, optional
        Inertia tensors in body axes, in place of the moments; their doubles are taken as exact, as
        by `Body`, and the results have the precision of those of moments.  25 us a body.
    t_low : array_like of t's shape, optional
        What one double of t leaves out: the epoch is t + t_low.
    angular_velocity : bool
        Whether the angular velocity is returned too.
    sensitivity : bool
        Whether the derivatives of the attitude are returned too, and with `angular_velocity` those
        of the angular velocity.
    out, rates_out, sensitivity_out : float64 arrays (..., T, 4), (..., T, 3), (..., T, 3, 9)
        Optional.  Filled with the results, and returned.  Views of (..., 4, T) memory are filled
        in place; others cost a copy.
    threads : int
        Number of threads; the bits of the results do not depend on it.

    Returns
    -------
    wxyz : (..., T, 4) array
        Body to inertial, scalar first, unit length, with the sign of a continuous motion from
        wxyz0.  A view of component-major memory; without the T axis if t is a single number.
    omega : (..., T, 3) array, only with angular_velocity=True
        rad/s over the body axes.
    sensitivity : (..., T, 3, 9) array, only with sensitivity=True
        The rotation vector (rad, inertial axes) of the change of attitude for a unit change of the
        first attitude (3, rotation vector, inertial axes), of the angular velocity (3, rad/s, body
        axes) and of the principal moments (3).  Its error is 4e-15 of the largest entry of a
        column (benchmarks/sensitivity.py; docs/sensitivities.md).
    omega_sensitivity : (..., T, 3, 9) array, only with both
        That of the angular velocity, over the body axes.

    Raises
    ------
    AttitudeError
        For states that are not physical, shapes that do not broadcast, or spans of more than
        5e16 turns, which two doubles of time cannot resolve; for sensitivities of a rod.

    Notes
    -----
    The error is at most 4e-15 rad for the exact doubles given, within 1e15 turns in every regime;
    benchmarks/accuracy.py measures it.  Rates below 2^-400 (4e-121) of the largest count as 0,
    and are refused beside rotation about the middle axis, which they turn over in the end.
    Solution: van Zon & Schofield (2006), J. Comput. Phys.
    225, 145, in the form of docs/derivation.md.

    >>> wxyz = propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), [0.0, 60.0])
    >>> wxyz.shape
    (2, 4)
    >>> wxyz[1].round(6)
    array([ 0.006059,  0.14546 , -0.019617,  0.989151])
    """
    if angular_velocity is not False:
        angular_velocity = validation.flag(angular_velocity, "angular_velocity")
    if sensitivity is not False:
        sensitivity = validation.flag(sensitivity, "sensitivity")
    inertia, inner = _inertia(moments, tensors)
    wxyz0 = validation.rows(wxyz0, "wxyz0", 4)
    omega0 = validation.rows(omega0, "omega0", 3, unit="rad/s")
    t = validation.seconds(t, "t")
    scalar = t.ndim == 0
    t = t.reshape(1) if scalar else t
    if t_low is not None:
        t_low = _low_parts(validation.seconds(t_low, "t_low"), t)
    lead = _leading_shape(inertia.shape[: inertia.ndim - inner], wxyz0, omega0, t)
    count = math.prod(lead)
    shape = lead + t.shape[-1:]
    results = [(result_memory(out, "out", shape, (4,), scalar), out)]
    if angular_velocity:
        results.append((result_memory(rates_out, "rates_out", shape, (3,), scalar), rates_out))
    elif rates_out is not None:
        raise AttitudeError("rates_out is given without angular_velocity=True; give both.")
    if sensitivity:
        memory = result_memory(sensitivity_out, "sensitivity_out", shape, (3, 9), scalar)
        results.append((memory, sensitivity_out))
        if angular_velocity:
            results.append((result_memory(None, "", shape, (3, 9), scalar), None))
    elif sensitivity_out is not None:
        raise AttitudeError("sensitivity_out is given without sensitivity=True; give both.")
    bodies = _flat(inertia, lead, count, inner)
    attitudes, rates = _flat(wxyz0, lead, count), _flat(omega0, lead, count)
    source: States | StatesOfTensors
    if inner == 1:
        source = States(bodies, IDENTITY, rates, None, attitudes)
    else:
        source = StatesOfTensors(bodies, attitudes, rates)
    times = Seconds(_epochs(t, lead, count), None if t_low is None else _epochs(t_low, lead, count))
    # Comprehensions are calls in Python 3.11: these two loops as such cost 4 % of one epoch.
    flat: list[FloatArray | None] = []
    for memory, _ in results:
        flat.append(memory.reshape(count, *memory.shape[len(lead) :]) if lead else memory[None])
    if not angular_velocity:
        flat.insert(1, None)
    evaluation = Evaluation(source, lambda k: f"State {k} of {count}" if count > 1 else "")
    evaluation.grid(times, Results(*flat), threads)
    views = []
    for memory, array in results:
        views.append(result(memory, array, scalar, len(lead)))
    return tuple(views) if len(views) > 1 else views[0]


def linearized(
    moments: FloatArray,
    wxyz: FloatArray,
    omega: FloatArray,
    t: FloatArray,
    *,
    angular_velocity: bool = False,
) -> tuple[FloatArray, ...]:
    """`propagate` with derivatives, for least squares: B states (B, 4), (B, 3) of a body at (T,).

    Columns of derivatives are within 4e-12 of their largest entries over some turns, not of those
    at each epoch.  That saves the series of epochs near that of the state, which take longest.
    """
    count, length = len(wxyz), len(t)
    rates = new_array(count, 3, length) if angular_velocity else None
    columns = [new_array(count, 3, 9, length) for _ in range(1 + angular_velocity)]
    attitudes = new_array(count, 4, length)
    states = States(np.reshape(moments, (1, 3)), IDENTITY, omega, None, wxyz)
    filled = Results(attitudes, rates, *columns)
    Evaluation(states, all_digits=False).grid(Seconds(frozen(t[None])), filled)
    results = [array for array in filled if array is not None]
    return tuple(np.moveaxis(array, -1, 1) for array in results)


def of_arrays(
    arrays: Sequence[Any],
    broadcast_to: Callable[..., Any],
    run: Callable[..., tuple[Any, Any]],
    rates: bool,
) -> Any:
    """Attitudes, and with rates angular velocities, of arrays or tensors of another library.

    arrays: moments (..., 3), wxyz0 (..., 4), omega0 (..., 3) and t (..., T) or a number.
    broadcast_to: of that library.  run: both results, of bodies (L, ...) and epochs (L or 1, T).
    """
    *bodies, times = arrays
    for name, array, width in zip(("moments", "wxyz0", "omega0"), bodies, (3, 4, 3), strict=True):
        if array.shape[-1:] != (width,):
            raise AttitudeError(f"{name} has shape {tuple(array.shape)}; give (..., {width}).")
    scalar = times.ndim == 0
    times = times.reshape(1) if scalar else times
    moments, wxyz0, omega0 = bodies
    lead = _leading_shape(moments.shape[:-1], wxyz0, omega0, times)
    bodies = [broadcast_to(rows, (*lead, rows.shape[-1])) for rows in bodies]
    # Axes of length 1 keep the epochs shared.
    times = times.reshape((1,) * (len(lead) + 1 - times.ndim) + tuple(times.shape))
    wxyz, omega = run(*bodies, times)
    if scalar:
        wxyz, omega = wxyz[..., 0, :], omega[..., 0, :]
    return (wxyz, omega) if rates else wxyz


def _low_parts(t_low, t):
    """t_low in the shape of t; one number serves all epochs."""
    t_low = np.broadcast_to(t_low, t.shape) if t_low.ndim == 0 else t_low
    if t_low.size != t.size:
        raise AttitudeError(
            f"t_low has shape {t_low.shape}, t has {t.shape}; give both in the same shape."
        )
    return t_low.reshape(t.shape)


def _inertia(moments, tensors):
    """Moments (..., 3) or tensors (..., 3, 3), and how many axes of the array are of one body."""
    if (moments is None) == (tensors is None):
        raise AttitudeError(
            "propagate takes either moments (..., 3) or, with moments=None, tensors (..., 3, 3)."
        )
    if tensors is None:
        return validation.rows(moments, "moments", 3), 1
    tensors = validation.rows(tensors, "tensors", 3)
    if tensors.shape[-2:] != (3, 3):
        raise AttitudeError(f"tensors has shape {tensors.shape}; give (..., 3, 3).")
    return tensors, 2


def _leading_shape(inertia, wxyz0, omega0, t):
    """The shape that the axes before the last ones broadcast to; that of the inertia is given."""
    if inertia == () and wxyz0.ndim == omega0.ndim == t.ndim == 1:
        return ()
    parts = {
        "moments or tensors": tuple(inertia),
        "wxyz0": tuple(wxyz0.shape[:-1]),
        "omega0": tuple(omega0.shape[:-1]),
        "t": tuple(t.shape[:-1]),
    }
    try:
        return np.broadcast_shapes(*parts.values())
    except ValueError as err:
        listed = ", ".join(f"{name} {shape}" for name, shape in parts.items())
        raise AttitudeError(
            f"the leading axes do not broadcast ({listed}); give equal ones, or t[:, None] for "
            "one epoch per body."
        ) from err


def _flat(array, lead, count, inner=1):
    """The rows of the bodies (count, ...), each of the last `inner` axes of an array."""
    if array.ndim == inner and not lead:
        return array[None]
    row = array.shape[array.ndim - inner :]
    if array.shape[:-inner] != lead:
        array = np.broadcast_to(array, (*lead, *row))
    return array.reshape(count, *row)


def _epochs(t, lead, count):
    """A read-only view (1, T) if all bodies share the epochs, else (B, T)."""
    rows = t.reshape(1, t.size) if t.size == t.shape[-1] else _flat(t, lead, count)
    return frozen(rows if rows.flags.c_contiguous else np.ascontiguousarray(rows))


def result_memory(
    out: Any, name: str, shape: tuple[int, ...], width: tuple[int, ...], scalar: bool
) -> FloatArray:
    """Component-major memory (..., width, T) for the result; that of `out` where possible."""
    if out is not None:
        expected = (*shape[:-1], *width) if scalar else (*shape, *width)
        if not isinstance(out, np.ndarray) or out.dtype != np.float64 or out.shape != expected:
            of_out = getattr(out, "shape", None), getattr(out, "dtype", type(out).__name__)
            raise AttitudeError(
                f"{name} is an array of shape and type {of_out}; it must be float64 {expected}."
            )
        if not out.flags.writeable:
            raise AttitudeError(f"{name} is read-only; give an array that can be filled.")
        memory = out[..., None] if scalar else np.moveaxis(out, len(shape) - 1, -1)
        if memory.flags.c_contiguous:
            return memory
    return new_array(*shape[:-1], *width, shape[-1])


def result(memory: FloatArray, out: FloatArray | None, scalar: bool, leading: int) -> FloatArray:
    """The result as it is returned: a view of the memory, or `out`."""
    if scalar:
        view = memory[..., 0]
    else:  # three microseconds faster than np.moveaxis
        view = memory.transpose(*range(leading), -1, *range(leading, memory.ndim - 1))
    if out is None:
        return view
    if not np.shares_memory(out, view):
        put(out, view)
    return out
