"""Entry points of the solution: compute the constants of B motions, evaluate them at epochs.

All loops over bodies and epochs are compiled.  Each stage, and each form of the solution, is
compiled separately and only when a state needs it: nested in one function, they would be optimised
again at every level, for seconds.  ``entry_point.run(...)`` saves the 0.1 us of one more call of a
Python function.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.solution import codes, kernel
from attitude.solution.classify import classify_all, refine_all
from attitude.solution.coefficients import (
    hyperbolic_all,
    hyperbolic_rates_all,
    trigonometric_all,
    trigonometric_rates_all,
)
from attitude.solution.constants import solve_all
from attitude.solution.given_axes import attach_all
from attitude.solution.uniform import uniform_all

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from attitude.annotations import FloatArray
    from attitude.compilation.decorators import EntryPoint

# Writable, as in all calls: to numba a read-only array is another type.
_NO_LOW = np.zeros((1, 4))


def prepare_all(
    moments: FloatArray,
    wxyz: FloatArray,
    omega: FloatArray,
    principal: FloatArray,
    constants: NDArray[Any],
    differences: FloatArray | None = None,
    rates: bool = True,
    wxyz_low: FloatArray | None = None,
) -> int:
    """Fill the constants of B motions.

    Given
        moments    (B, 3, 2) principal moments, pairs
        wxyz       (B, 4) body to inertial at the epoch, any length
        omega      (B, 3, 2) rad/s over the principal axes, pairs
        principal  (1 or B, 4) unit quaternion, principal axes to given body axes
        differences  B - A, C - B and D2, pairs, where solution.principal has them to more digits
                   than follow from the pairs above: (3, 2) of a single motion, or (B, 3, 2) with
                   NaN for motions without; or None
        rates      whether the series of the angular velocity are filled too
        wxyz_low   (B, 4) second doubles of wxyz, then of unit length; or None
    Filled
        constants  (B,) of solution.record.CONSTANTS, zeros at first; `fault` is the code of what
                   is not physical
    Returned
        how many have a fault
    """
    low = _NO_LOW if wxyz_low is None else wxyz_low
    faults, uniform, cancelled = classify_all.run(moments, wxyz, omega, constants)
    if uniform:
        uniform_all.run(wxyz, low, principal, constants)
    tumbling = len(constants) - faults - uniform
    if tumbling:
        if differences is not None:
            _take_differences(differences, constants)
        if cancelled and (differences is None or differences.ndim == 3):
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
    return faults


def _take_differences(differences, constants):
    """Fill differences (3, 2) of one motion, or (B, 3, 2) of those that have them and tumble."""
    if differences.ndim == 2:
        constants["gaps"], constants["d2"] = differences[:2], differences[2]
        return
    known = (constants["form"] != codes.UNIFORM) & ~np.isnan(differences[:, 0, 0])
    constants["gaps"][known], constants["d2"][known] = differences[known, :2], differences[known, 2]
    constants["cancelled"][known] = 0  # D2 is exact


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

    Returned
        -1, or the number of a body with an epoch beyond its reach; then not all are filled
    """
    # To numba a read-only array is of another type, for which each loop would be compiled anew.
    constants, t = _read_only(constants), _read_only(t)
    t_low = None if t_low is None else _read_only(t_low)
    for form in set(constants["form"].tolist()):
        body = OF_FORM[form].run(constants, t, t_low, wxyz, rates, first, end, first)
        if body >= 0:
            return body
    return -1


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, or a view of one that can be written."""
    if array.flags.writeable:
        array = array.view()
        array.flags.writeable = False
    return array


OF_FORM: dict[int, EntryPoint] = {
    codes.UNIFORM: kernel.uniform,
    codes.TRIGONOMETRIC: kernel.trigonometric,
    codes.HYPERBOLIC: kernel.hyperbolic,
}
