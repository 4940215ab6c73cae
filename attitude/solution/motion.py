"""The doors of the solution: constants of many bodies, attitudes of many bodies.

All loops over bodies and epochs are inside.  The constants are made in three stages, each compiled
by itself: nested in one function they would be optimised anew at every level, for seconds.
"""

from attitude.solution import codes
from attitude.solution.constants import attach, classify, reach, solve
from attitude.solution.kernel import evaluate
from attitude.solution.machine import compiled, inlined


def prepare_all(moments, wxyz, omega, axes, constants):
    """Constants of B motions.

    Given
        moments    (B, 3, 2) principal moments, pairs
        wxyz       (B, 4) body to inertial at the epoch, any length
        omega      (B, 3, 2) rad/s over the principal axes, pairs
        axes       (1 or B, 3, 3) columns: principal axes in the given body axes
    Filled
        constants  (B,) of solution.layout.CONSTANTS; fault tells what is wrong with a body
    Returned
        whether any body has a fault
    """
    faults = _classify_all(moments, wxyz, omega, axes, constants)
    _solve_all(constants)
    _attach_all(wxyz, constants)
    return faults > 0


@compiled
def _classify_all(moments, wxyz, omega, axes, constants):
    faults = 0
    for b in range(len(constants)):
        c = constants[b]
        classify(moments[b], wxyz[b], omega[b], axes[b if len(axes) > 1 else 0], c)
        faults += c.fault != codes.FINE
    return faults


@compiled
def _solve_all(constants):
    for b in range(len(constants)):
        if constants[b].fault == codes.FINE and constants[b].form != codes.UNIFORM:
            solve(constants[b])


@compiled
def _attach_all(wxyz, constants):
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE:
            if c.form != codes.UNIFORM:
                attach(wxyz[b], c)
            c.reach = reach(c)


@compiled
def evaluate_all(constants, t, t_low, wxyz, rates):
    """Attitudes, and angular velocities unless rates is None, of B motions.

    Given
        constants  (B,) from prepare_all
        t          (1 or B, T) seconds since the epoch
        t_low      the same shape, added to t; or None
    Filled
        wxyz       (B, 4, T)
        rates      (B, 3, T) rad/s over the given body axes, or None
    Returned
        -1, or the first body that was asked for an epoch beyond its reach, where nothing is
        filled any more
    """
    for b in range(len(constants)):
        k = b if len(t) > 1 else 0
        if _beyond(t[k], constants[b].reach):
            return b
        evaluate(
            constants[b],
            t[k],
            None if t_low is None else t_low[k],
            wxyz[b],
            None if rates is None else rates[b],
        )
    return -1


@inlined
def _beyond(t, reach):
    # No early exit: as a reduction this vectorises and costs less than reading t once more.
    beyond = 0
    for i in range(len(t)):
        beyond |= abs(t[i]) > reach
    return beyond != 0
