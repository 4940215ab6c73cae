"""The doors of the solution: constants of many bodies, attitudes of many bodies.

All loops over bodies and epochs are compiled.  Each stage, and each form of the solution, is
compiled by itself and only when a state wants it: nested in one function they would be optimised
anew at every level, for seconds.
"""

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


def prepare_all(moments, wxyz, omega, principal, constants, differences=None, rates=True):
    """Constants of B motions.

    Given
        moments    (B, 3, 2) principal moments, pairs
        wxyz       (B, 4) body to inertial at the epoch, any length
        omega      (B, 3, 2) rad/s over the principal axes, pairs
        principal  (1 or B, 4) unit quaternion, principal axes to given body axes
        differences  of one motion, what is known better than from the pairs; or None: B - A,
                   C - B and D2 as solution.principal has them, (3, 2)
        rates      whether angular velocities will be asked for
    Filled
        constants  (B,) of solution.record.CONSTANTS, zeros at first; fault tells what is wrong
    Returned
        how many have a fault
    """
    faults, uniform, cancelled = classify_all(moments, wxyz, omega, constants)
    if uniform:
        uniform_all(wxyz, principal, constants)
    tumbling = len(constants) - faults - uniform
    if tumbling:
        if differences is not None:
            constants["gaps"], constants["d2"] = differences[:2], differences[2]
        elif cancelled:
            refine_all(constants)
        hyperbolic = solve_all(constants)
        if hyperbolic < tumbling:
            trigonometric_all(constants)
            if rates:
                trigonometric_rates_all(constants)
        if hyperbolic:
            hyperbolic_all(constants)
            if rates:
                hyperbolic_rates_all(constants)
        attach_all(wxyz, principal, constants)
    return faults


def evaluate_all(constants, t, t_low, wxyz, rates):
    """Attitudes, and angular velocities unless rates is None, of B motions: see `kernel`.

    Returned is -1, or a body that was asked for an epoch beyond its reach; then not all are filled.
    """
    for form in set(constants["form"].tolist()):
        body = OF_FORM[form](constants, t, t_low, wxyz, rates)
        if body >= 0:
            return body
    return -1


OF_FORM = {
    codes.UNIFORM: kernel.uniform,
    codes.TRIGONOMETRIC: kernel.trigonometric,
    codes.HYPERBOLIC: kernel.hyperbolic,
}
