"""One bound for all epochs: it holds where certificates look; faults raise it or are refused."""

import random

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.motions._free_rotation import chain_of
from attitude.proof._error_bound import error_bound_of
from tests.support import states
from tests.support.measure import motion_of

pytest.importorskip("flint", reason="python-flint is not installed")


@pytest.mark.parametrize("family", states.FAMILIES)
def test_holds_at_all_epochs(family):
    generator = random.Random(family)
    for state in states.sample(4, 7, [family]):
        try:
            motion = motion_of(state)
        except AttitudeError:
            continue  # rates that the solution refuses to drop
        turns = [0.0, *(s * 10.0 ** generator.uniform(-1, 12) for s in (1, -1) * 4)]
        t = np.array(turns) * states.revolution(state)
        bound = motion.error_bound()
        constant, rate = bound
        assert np.all(motion.certificate(t).error <= constant + rate * np.abs(t)), state
        assert 0.0 < constant < 6e-15 and bound.span > 1e11 * states.revolution(state)


@pytest.mark.parametrize(
    "tensor",
    [
        [[2.0, 0.1, 0.2], [0.1, 2.5, 0.5], [0.2, 0.5, 2.9]],
        [[2.0, 0.0, 0.0], [0.0, 2.5, 0.5], [0.0, 0.5, 2.5]],  # symmetric
    ],
)
def test_full_tensors(tensor):
    motion = FreeRotation(Body(tensor=tensor), Spin("2026-01-01", (1, 2, 0, 1), (0.3, -0.2, 0.6)))
    t = np.array([0.0, 1.0, -1e5, 1e9])
    constant, rate = motion.error_bound()
    assert np.all(motion.certificate(t).error <= constant + rate * np.abs(t))
    assert constant < 6e-15


_FAULTS = [
    ("precession", (0,), 1e-14),
    ("nutation", (0,), 1e-14),
    ("nutation", (1,), 1e-3),
    ("nutation0", (0,), 1e-13),
    ("alpha", (0, 1), 1e-12),
    ("beta", (0, 0), 1e-13),
    ("frame", (0, 0), 1e-13),
    ("decay", (), 1e-13),
    ("tilt", (), 1e-12),
    ("nome", (), 1e-12),
]
_BODIES = {
    "trigonometric": ((3.0, 4.0, 6.0), (0.4, 0.2, 1.0)),
    "hyperbolic": ((10.0, 20.0, 26.0), (0.86, -0.15, 0.688)),
}
# Fields that the trigonometric form does not have.
_HYPERBOLIC_ONLY = ("decay", "tilt", "nome")


@pytest.mark.parametrize(("field", "place", "by"), _FAULTS)
@pytest.mark.parametrize("form", _BODIES)
def test_a_fault_of_a_constant_shows(form, field, place, by):
    """The certificate sees it, and the bound rises and still holds, or is refused."""
    if form == "trigonometric" and field in _HYPERBOLIC_ONLY:
        pytest.skip("not a constant of this form")
    moments, rates = _BODIES[form]
    motion = FreeRotation(Body(moments=moments), Spin("2026-01-01", (1, 0, 0, 0), rates))
    constant, rate = motion.error_bound()
    t = np.array([0.0, 3.3, 1e3, -1e6, 1e9])
    before = motion.certificate(t).error
    faulty = motion._constants.copy()
    if place:
        faulty[field][(0, *place)] *= 1.0 + by
    else:
        faulty[field][0] *= 1.0 + by
    motion._set("_constants", faulty)
    after = motion.certificate(t).error
    assert np.any(after != before)
    chain = chain_of(motion.body, motion.spin, record=faulty[0])
    try:
        worse = error_bound_of(faulty[0], chain.solution)
    except AttitudeError as err:
        assert "no bound for all epochs is proved" in str(err)
        return
    assert worse.constant > constant or worse.rate > rate
    assert np.all(after <= worse.constant + worse.rate * np.abs(t))


@pytest.mark.parametrize(
    ("tensor", "rates"),
    [
        ([[138, 0, -6], [0, 132, -6], [-6, -6, 135]], (10, -34, -7)),
        ([[124, 2, 8], [2, 133, 10], [8, 10, 130]], (3, -6, 0)),
        ([[98, 4, 10], [4, 110, 14], [10, 14, 107]], (0, 24, -24)),
    ],
)
def test_tensors_with_a_rate_that_is_exactly_zero(tensor, rates):
    """The sense of that axis is open: it is the one of the record."""
    motion = FreeRotation(Body(tensor=tensor), Spin("2026-01-01", (1, 2, 0, 1), rates))
    t = np.array([0.0, 1.0, -1e5, 1e9])
    constant, rate = motion.error_bound()
    assert np.all(motion.certificate(t).error <= constant + rate * np.abs(t))
    assert constant < 6e-15
