"""Covariances of fits, against the spread of fits to 150 sets of noisy records."""

from functools import cache

import numpy as np
import pytest

from attitude import AttitudeTable, Body, FreeRotation, Spin, fit, fit_directions, fit_rates
from attitude.frames import quaternion
from attitude.frames import representations as forms

EPOCH = "2026-01-01"
T = np.linspace(0.0, 60.0, 101)
TURN = forms.to_matrix(forms.from_axis_angle((1, 2, -1), 0.4))
NOISE = 1e-3
FITS = 150
LATER = 100.0
STARS = np.resize([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, 0.8, -0.6]], (len(T), 3))


def truth(free):
    body = Body(moments=(10, 20, 26))
    if free:
        body = Body(tensor=TURN @ np.diag([10.0, 20.0, 26.0]) @ TURN.T)
    spin = Spin(epoch=EPOCH, wxyz=(1, -2, 3, 0.5), angular_velocity=(0.3, 0.2, 0.7))
    return FreeRotation(body, spin)


def noisy_attitudes(motion, random):
    noise = forms.from_rotation_vector(random.normal(scale=NOISE, size=(len(T), 3)))
    return AttitudeTable(EPOCH, T, quaternion.multiply(motion.at(T).wxyz, noise))


def noisy_directions(motion, random):
    measured = motion.at(T).inertial_to_body(STARS)
    return measured + random.normal(scale=NOISE, size=measured.shape)


def noisy_rates(motion, random):
    rates = motion.at(T).angular_velocity
    return rates + random.normal(scale=NOISE, size=rates.shape)


WAYS = {
    "attitudes": (False, lambda motion, random: fit(noisy_attitudes(motion, random), start=motion)),
    "a known body": (
        False,
        lambda motion, random: fit(noisy_attitudes(motion, random), motion.body),
    ),
    "free axes": (
        True,
        lambda motion, random: fit(noisy_attitudes(motion, random), axes="free", start=motion),
    ),
    "rates": (
        False,
        lambda motion, random: fit_rates(T, noisy_rates(motion, random), epoch=EPOCH, start=motion),
    ),
    "directions": (
        False,
        lambda motion, random: fit_directions(
            T, noisy_directions(motion, random), STARS, epoch=EPOCH, start=motion
        ),
    ),
}


@cache
def fitted(name):
    """The fits of one way to sets of records, each with its own noise."""
    free, way = WAYS[name]
    random = np.random.default_rng(16)
    return [way(truth(free), random) for _ in range(FITS)]


def shape_of(body, free):
    """Logarithms of the second moments of mass, as documented."""
    second = 0.5 * np.trace(body.tensor) * np.eye(3) - body.tensor
    values, vectors = np.linalg.eigh(second)
    matrix = (vectors * np.log(values)) @ vectors.T
    matrix -= np.trace(matrix) / 3.0 * np.eye(3)
    return [matrix[0, 0], matrix[1, 1], *((matrix[0, 1], matrix[0, 2], matrix[1, 2]) * free)]


def turn_between(q, p):
    """The turn from p to q, over the axes before both."""
    return forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(p), q))


def parameters(motion, truth, count, free):
    """Parameters of a fit less the true ones, as documented."""
    turn = turn_between(motion.spin.wxyz, truth.spin.wxyz)
    rates = motion.spin.angular_velocity - truth.spin.angular_velocity
    shape = np.subtract(shape_of(motion.body, free), shape_of(truth.body, free))
    return np.concatenate([turn, rates, shape])[:count]


def check(errors, covariances):
    """Errors (F, P) of fits have the covariances (F, P, P) that the fits state."""
    count = errors.shape[1]
    # The variance of a variance from F samples is 2/F of its square; a factor of five.
    ratio = np.mean(errors**2, axis=0) / np.mean(np.diagonal(covariances, axis1=1, axis2=2), axis=0)
    assert np.all(np.abs(ratio - 1.0) < 5.0 * np.sqrt(2.0 / len(errors))), ratio
    # With correlations: chi squared of P degrees of freedom.
    chi = np.array([e @ np.linalg.solve(c, e) for e, c in zip(errors, covariances, strict=True)])
    assert abs(np.mean(chi) - count) < 5.0 * np.sqrt(2.0 * count / len(errors)), np.mean(chi)


@pytest.mark.parametrize("name", WAYS)
def test_covariances_are_those_of_many_fits(name):
    free, _ = WAYS[name]
    given, found = truth(free), fitted(name)
    known = np.arange(3 * (name == "rates"), len(found[0].covariance))
    errors = np.array(
        [parameters(each.motion, given, len(each.covariance), free)[known] for each in found]
    )
    check(errors, np.array([each.covariance[np.ix_(known, known)] for each in found]))


@pytest.mark.parametrize("name", ["attitudes", "a known body", "directions"])
def test_the_errors_of_the_fitted_motion_are_those_of_its_history(name):
    free, _ = WAYS[name]
    errors, covariances = [], []
    expected = truth(free).at(LATER)
    for each in fitted(name):
        later = each.motion.at(LATER)
        turn = quaternion.multiply(later.wxyz, quaternion.conjugate(expected.wxyz))
        rates = later.angular_velocity - expected.angular_velocity
        errors.append(np.concatenate([forms.to_rotation_vector(turn), rates]))
        covariances.append(later.covariance)
    check(np.array(errors), np.array(covariances))


def test_with_free_axes_the_history_has_the_errors_of_the_principal_axes():
    free, _ = WAYS["free axes"]
    given = truth(free)
    errors, covariances = [], []
    axes = given.body.principal_axes
    for each in fitted("free axes"):
        motion = each.motion
        later = motion.at(LATER)
        turn = later.matrix @ motion.body.principal_axes @ (given.at(LATER).matrix @ axes).T
        errors.append(forms.to_rotation_vector(quaternion.from_matrix(turn)))
        covariances.append(later.covariance[:3, :3])
    check(np.array(errors), np.array(covariances))


def test_moments_of_the_spin_are_those_of_the_body():
    """Errors of the moments, whose sum is 1 exactly, in the order of the moments of the body."""
    for name in ("attitudes", "free axes"):
        given = truth(WAYS[name][0])
        found = [each.motion for each in fitted(name)]
        moments = given.body.moments / given.body.moments.sum()
        errors = np.array([each.body.moments - moments for each in found])
        covariances = np.array([each.spin.covariance[6:, 6:] for each in found])
        assert np.max(np.abs(covariances.sum(axis=2))) < 1e-12
        check(errors[:, :2], covariances[:, :2, :2])


def test_a_symmetric_body_has_finite_errors():
    """The directions of its equal axes are undetermined, and have no influence."""
    body = Body(tensor=TURN @ np.diag([10.0, 10.0, 16.0]) @ TURN.T)
    given = FreeRotation(body, truth(True).spin)
    random = np.random.default_rng(20)
    found = fit(noisy_attitudes(given, random), axes="free")
    assert 0.9 < found.rms / (np.sqrt(3.0) * NOISE) < 1.1
    assert np.all(np.isfinite(found.covariance))
    later = found.motion.at(LATER)
    off = quaternion.multiply(later.wxyz, quaternion.conjugate(given.at(LATER).wxyz))
    # The attitude of the body, whose errors those of the principal axes bound in size.
    assert np.linalg.norm(forms.to_rotation_vector(off)) < 10.0 * np.max(later.sigma)
    assert np.max(later.sigma_deg) < 3.0
