"""Which fields of a motion's record each form of the solution reads.

A field that is not read may hold anything: here NaN, so that a wrong branch shows.
"""

import numpy as np
import pytest

from attitude._solver import codes
from attitude._solver.evaluation import evaluate_all
from tests.support import states
from tests.support.uncompiled_answers import STATES

EPOCHS = np.array([[-3e4, 0.0, 1.3, 60.0, 1e6]])
ALWAYS = {"form", "frame"}
# Fields that `solution.kernel` reads, by form: for attitudes, and for angular velocities besides.
READ = {
    codes.UNIFORM: ({"precession"}, {"rates"}),
    codes.TRIGONOMETRIC: (
        {"precession", "nutation", "nutation0", "alpha", "beta"},
        {"rates", "axes"},
    ),
    codes.HYPERBOLIC: (
        {"precession", "nutation", "nutation0", "winds", "decay", "nome", "tilt", "alpha", "beta"},
        {"rates", "axes"},
    ),
}


def constants_of(name):
    moments, rates = STATES[name]
    pairs = np.zeros((1, 3, 2)), np.zeros((1, 3, 2))
    pairs[0][0, :, 0], pairs[1][0, :, 0] = moments, rates
    unit = np.array([[1.0, 0.0, 0.0, 0.0]])
    return states.constants_of(pairs[0], np.array([[1.0, 2, 3, 4]]), pairs[1], unit)


def evaluated(constants, rates):
    wxyz = np.empty((1, 4, EPOCHS.size))
    omega = np.empty((1, 3, EPOCHS.size)) if rates else None
    assert evaluate_all(constants, EPOCHS, None, wxyz, omega, 0, EPOCHS.shape[1]) == -1
    return np.concatenate([wxyz.ravel(), [] if omega is None else omega.ravel()])


@pytest.mark.parametrize("rates", [False, True], ids=["attitudes", "rates"])
@pytest.mark.parametrize("name", STATES)
def test_unused_fields_may_be_nan(name, rates):
    constants = np.array(constants_of(name))
    want = evaluated(constants, rates)
    assert np.isfinite(want).all()
    attitude, velocity = READ[int(constants["form"][0])]
    read = ALWAYS | attitude | (velocity if rates else set())
    spoiled = constants.copy()
    for field in spoiled.dtype.names:
        if field not in read:
            kind = spoiled[field].dtype.kind
            spoiled[field] = np.nan if kind == "f" else -(2**40)
    assert evaluated(spoiled, rates).tobytes() == want.tobytes()


@pytest.mark.parametrize("name", ["short_axis", "near_separatrix", "principal_axis"])
def test_fields_that_are_read_show(name):
    """The table above names no field too many: NaN in any of them is seen."""
    constants = np.array(constants_of(name))
    attitude, velocity = READ[int(constants["form"][0])]
    for field in attitude | velocity | {"frame"}:
        spoiled = constants.copy()
        spoiled[field] = np.nan
        assert np.isnan(evaluated(spoiled, True)).any(), field


def test_every_form_is_tried():
    forms = {int(constants_of(name)["form"][0]) for name in STATES}
    assert forms == set(READ)
