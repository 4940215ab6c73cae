"""Named axes: against 40 digits of the definitions, and against ERFA and SPICE."""

import erfa
import mpmath
import numpy as np
import pytest

from attitude.errors import AttitudeError
from attitude.frames import FRAMES, attitude_to_icrf, matrix_to_icrf, vector_to_icrf, wxyz_to_icrf
from tests.support.frames import definition


@pytest.mark.parametrize("frame", FRAMES)
def test_each_entry_is_its_definition_to_rounding(frame):
    with mpmath.workdps(40):
        exact = definition(frame)
        ours = matrix_to_icrf(frame)
        for i in range(3):
            for j in range(3):
                assert ours[i, j] == float(exact[i, j])


@pytest.mark.parametrize("frame", FRAMES)
def test_the_quaternion_is_the_same_rotation(frame):
    w, x, y, z = wxyz_to_icrf(frame)
    matrix = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    assert np.max(np.abs(matrix - matrix_to_icrf(frame))) < 3e-16  # products of numbers below 1
    assert abs(w * w + x * x + y * y + z * z - 1.0) < 3e-16


def rotation(q):
    """The matrix of a quaternion of any length."""
    w, x, y, z = q
    return mpmath.matrix(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    ) / mpmath.fsum(each * each for each in q)


@pytest.mark.parametrize("frame", FRAMES)
def test_pairs_hold_thirty_digits(frame):
    vector, wxyz = (0.3, -1e5, 7e-9), (0.1, -0.7, 0.5, 0.5)
    with mpmath.workdps(50):
        exact = definition(frame) * mpmath.matrix(vector)
        for pair, true in zip(vector_to_icrf(frame, vector), exact, strict=True):
            assert abs(mpmath.mpf(float(pair[0])) + mpmath.mpf(float(pair[1])) - true) < 1e-26
        turned = [
            mpmath.mpf(float(a)) + mpmath.mpf(float(b))
            for a, b in attitude_to_icrf(frame, [(x, 1e-17 * x) for x in wxyz])
        ]
        given = [mpmath.mpf(x) + mpmath.mpf(1e-17 * x) for x in wxyz]
        apart = rotation(turned) - definition(frame) * rotation(given)
        assert mpmath.mnorm(apart) < 1e-31


def test_eme2000_is_erfas_frame_bias():
    bias = erfa.bp00(2451545.0, 0.0)[0]
    # One rounding of the diagonal.
    assert np.max(np.abs(matrix_to_icrf("EME2000").T - bias)) < 2e-16
    angle = np.linalg.norm(bias - np.eye(3)) / np.sqrt(2.0)
    assert angle == pytest.approx(np.radians(23.15e-3 / 3600.0), rel=1e-2)


def test_the_ecliptic_is_that_of_spice():
    spiceypy = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    theirs = spiceypy.pxform("ECLIPJ2000", "J2000", 0.0)
    assert np.max(np.abs(matrix_to_icrf("ecliptic") - theirs)) < 3e-16


def test_the_arrays_are_read_only():
    for array in (matrix_to_icrf("ecliptic"), wxyz_to_icrf("ecliptic")):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("frame", ["itrf", "", None, 3, ["icrf"]])
def test_other_names_are_refused_with_the_allowed_ones(frame):
    with pytest.raises(AttitudeError, match="must be one of 'icrf'"):
        matrix_to_icrf(frame)


def test_j2000_is_refused_because_it_means_two_things():
    with pytest.raises(AttitudeError, match="two things"):
        matrix_to_icrf("J2000")
