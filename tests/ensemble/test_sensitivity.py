"""Derivatives of ensembles have the bits of `FreeRotation.sensitivity_at`, in every layout."""

import numpy as np
import pytest

from attitude import AttitudeError, Ensemble

EPOCH = "2026-01-01"
MOMENTS = np.array([(10, 20, 26), (1, 2, 2.5), (3, 3, 4), (10, 20, 26), (5, 5, 5)], dtype=float)
OMEGA = np.array([(1, 15, 1), (0.2, 0.1, 0), (0.1, 0.2, 0.3), (0, 0, 0.4), (0.1, 0.2, 0.3)])
TIMES = np.array([0.0, 0.01, 5.0, 60.0, 1e5])


@pytest.fixture(scope="module")
def tops():
    random = np.random.default_rng(5)
    return Ensemble(
        moments=MOMENTS, wxyz=random.normal(size=(5, 4)), angular_velocity=OMEGA, epoch=EPOCH
    )


@pytest.mark.parametrize("threads", [1, 2])
def test_grids_have_the_bits_of_single_motions(tops, threads):
    attitude, omega = tops.sensitivity_at(TIMES, angular_velocity=True, threads=threads)
    assert attitude.shape == omega.shape == (5, 5, 3, 9)
    for k in range(5):
        expected = tops[k].sensitivity_at(TIMES, angular_velocity=True)
        assert np.array_equal(attitude[k], expected[0])
        assert np.array_equal(omega[k], expected[1])
    assert np.array_equal(tops.sensitivity_at(5.0), attitude[:, 2])
    own = np.tile(TIMES, (5, 1))
    assert np.array_equal(tops.sensitivity_at(own), attitude)


@pytest.mark.parametrize("ordered", [True, False])
def test_ragged_rows_in_any_order(tops, ordered):
    random = np.random.default_rng(6)
    member = random.integers(0, 5, 400)
    member = np.sort(member) if ordered else member
    t = random.uniform(0.0, 100.0, 400)
    attitude, omega = tops.sensitivity_at(t, member, angular_velocity=True, threads=2)
    for k in range(5):
        expected = tops[k].sensitivity_at(t[member == k], angular_velocity=True)
        assert np.array_equal(attitude[member == k], expected[0])
        assert np.array_equal(omega[member == k], expected[1])


def test_blocks_and_output_arrays(tops):
    whole = tops.sensitivity_at(TIMES)
    for place, history in tops.blocks(TIMES, rows=7):
        assert np.array_equal(history.sensitivity, whole[place])
    out = np.empty((5, 5, 3, 9))
    assert tops.sensitivity_at(TIMES, out=out) is out
    assert np.array_equal(out, whole)
    with pytest.raises(AttitudeError, match=r"it must be float64 \(5, 5, 3, 9\)"):
        tops.sensitivity_at(TIMES, out=np.empty((5, 5, 3)))


def with_faults(on_error):
    """A rod, a body that cannot exist, one about its middle axis, and a sound one."""
    return Ensemble(
        moments=[(0, 1, 1), (1, 1, 9), (1, 2, 2.5), (10, 20, 26)],
        wxyz=(1, 0, 0, 0),
        angular_velocity=[(0, 1, 0), (0, 1, 0), (0, 1, 0), (1, 15, 1)],
        epoch=EPOCH,
        names=["rod", "none", "middle", "sound"],
        on_error=on_error,
    )


def test_rates_whose_products_are_no_doubles_have_no_derivatives():
    kwargs = {"moments": (1, 2, 2.7), "wxyz": (1, 0, 0, 0), "epoch": EPOCH}
    kwargs["angular_velocity"] = [(0.1, 0.2, 0.3), (1e-160, 2e-160, 0), (0, 0, 1e-160), (0, 0, 0)]
    found = Ensemble(**kwargs, on_error="nan").sensitivity_at([1.0], angular_velocity=True)
    for columns in found:
        assert np.array_equal(
            np.isnan(columns[:, 0, 0, 3:]).all(axis=-1), [False, True, True, False]
        )
    with pytest.raises(AttitudeError, match=r"member 1.* between 1e-90 and 1e90 rad/s"):
        Ensemble(**kwargs).sensitivity_at([1.0])


def test_members_without_derivatives_are_named_or_nan():
    found = with_faults("nan").sensitivity_at([0.0, 1e4])
    assert np.all(np.isnan(found[:2])) and np.all(np.isfinite(found[3]))
    # Errors of a rotation about the middle axis grow beyond the range of doubles.
    assert np.all(np.isfinite(found[2, 0])) and np.all(np.isnan(found[2, 1]))
    rows = with_faults("nan").sensitivity_at([1e4, 0.0, 1e4], member=["middle", "middle", "sound"])
    assert np.array_equal(np.isnan(rows[:, 0, 0]), [True, False, False])
    strict = Ensemble(
        moments=[(0, 1, 1), (1, 2, 2.5), (10, 20, 26)],
        wxyz=(1, 0, 0, 0),
        angular_velocity=[(0, 1, 0), (0, 1, 0), (1, 15, 1)],
        epoch=EPOCH,
        names=["rod", "middle", "sound"],
    )
    for t, member, name in ((0.0, None, "rod"), ([1e4, 0.0], [1, 2], "middle")):
        with pytest.raises(AttitudeError, match=name):
            strict.sensitivity_at(t, member)
