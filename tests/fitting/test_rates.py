"""Inertia ratios and state from angular velocities alone."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, fit_rates
from attitude.frames import representations as forms

EPOCH = "2026-01-01"
T = np.arange(0.0, 200.0, 0.4)
TURN = forms.to_matrix(forms.from_axis_angle((1, 2, -1), 0.4))
STATES = {
    "short axis": ((10, 20, 26), (0.1, 0.15, 1.0)),
    "long axis": ((10, 20, 26), (1.0, 0.15, 0.1)),
    "near the separatrix": ((10, 20, 26), (0.01, 1.5, 0.01)),
    "flat": ((10, 10.5, 20.4), (0.3, 0.2, 1.0)),
}


def motion(moments, rates, turn=None):
    body = Body(moments=moments)
    if turn is not None:
        body = Body(tensor=turn @ np.diag(np.array(moments, dtype=float)) @ turn.T)
    return FreeRotation(body, Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=rates))


def relative(body):
    return body.tensor / np.trace(body.tensor)


@pytest.mark.parametrize("name", STATES)
@pytest.mark.parametrize("axes", ["principal", "free"])
def test_exact_rates_give_body_and_state_back(name, axes):
    given = motion(*STATES[name], TURN if axes == "free" else None)
    found = fit_rates(T, given.at(T).angular_velocity, epoch=EPOCH, axes=axes)
    assert found.rate_rms < 1e-12
    assert np.max(np.abs(relative(found.motion.body) - relative(given.body))) < 1e-9
    off = found.motion.spin.angular_velocity - given.spin.angular_velocity
    assert np.max(np.abs(off)) < 1e-9
    # The first attitude given is the identity too.
    matrix, expected = found.motion.at(50.0).matrix, given.at(50.0).matrix
    assert np.max(np.abs(matrix - expected)) < 1e-9
    assert found.residuals.shape == (0, 3) and np.isnan(found.rms)
    assert "rad/s" in repr(found)


@pytest.mark.parametrize("axes", ["principal", "free"])
def test_a_body_at_rest(axes):
    found = fit_rates(T, np.zeros((len(T), 3)), epoch=EPOCH, axes=axes)
    assert found.rate_rms == 0.0 and found.motion.mode.name == "AT_REST"


@pytest.mark.filterwarnings("ignore::attitude.errors.CovarianceWarning")
def test_the_attitude_is_undetermined():
    given = motion(*STATES["short axis"])
    noise = np.random.default_rng(2).normal(scale=1e-4, size=(len(T), 3))
    found = fit_rates(T, given.at(T).angular_velocity + noise, epoch=EPOCH)
    assert np.all(np.isinf(np.diag(found.covariance)[:3]))
    assert np.all(np.diag(found.covariance)[3:] < 1e-6)
    covariance = found.motion.spin.covariance
    unknown = (np.pi**2 / 3.0 + 2.0) / 3.0
    assert np.allclose(covariance[:3, :3], unknown * np.eye(3), rtol=1e-12, atol=0.0)
    assert np.all(covariance[:3, 3:] == 0.0)
    # Rates later have errors of the size of those of the fit.
    later = np.diag(found.motion.at(100.0).covariance)[3:]
    assert np.all(later > 0.0) and np.all(later < 1e-8)
    assert np.array_equal(found.motion.spin.wxyz, (1, 0, 0, 0))


def test_a_known_body_needs_one_record():
    given = motion(*STATES["short axis"])
    rates = given.at(T).angular_velocity
    one = fit_rates([10.0], rates[25:26], given.body, epoch=EPOCH, sigma=1e-3)
    # three numbers for three rates, whose errors are therefore those given
    assert np.allclose(one.covariance.diagonal()[3:], 1e-6, rtol=1e-9)
    assert np.allclose(one.motion.spin.angular_velocity, rates[25], rtol=0.0, atol=1e-15)
    assert one.motion.spin.epoch == given.epoch.after(10.0)
    many = fit_rates(T, rates, given.body, epoch=EPOCH)
    assert many.rate_rms < 1e-14 and many.motion.body is given.body
    # Coarse records with a known body keep count of the turns; so does a start.
    t = np.concatenate([np.arange(0.0, 20.0, 0.5), np.arange(20.0, 300.0, 37.0)])
    assert fit_rates(t, given.at(t).angular_velocity, given.body, epoch=EPOCH).rate_rms < 1e-12
    far = np.arange(0.0, 400.0, 9.7)
    near = motion((10, 20.001, 26), (0.1, 0.15, 1.0001))
    assert fit_rates(far, given.at(far).angular_velocity, epoch=EPOCH, start=near).rate_rms < 1e-12


def test_outliers_and_gaps():
    given = motion(*STATES["long axis"])
    random = np.random.default_rng(5)
    t = T[(T < 60.0) | (T > 110.0)]
    rates = given.at(t).angular_velocity + random.normal(scale=1e-4, size=(len(t), 3))
    rates[random.choice(len(t), len(t) // 10, replace=False)] += random.normal(size=3)
    found = fit_rates(t, rates, epoch=EPOCH, sigma=1e-4, loss="cauchy")
    off = found.motion.spin.angular_velocity - given.spin.angular_velocity
    assert np.all(np.abs(off) < 5.0 * np.sqrt(np.diag(found.covariance)[3:6]))
    assert np.max(np.abs(relative(found.motion.body) - relative(given.body))) < 1e-3


def test_dates_are_epochs():
    given = motion(*STATES["short axis"])
    history = given.at(T)
    found = fit_rates(history.time, history.angular_velocity)
    assert found.rate_rms < 1e-9
    assert abs(found.motion.epoch.seconds - given.epoch.seconds) < 1e-9


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda t, w: fit_rates(t, w), "with epoch="),
        (lambda t, w: fit_rates(t, w[:4], epoch=EPOCH), "angular_velocity has shape"),
        (lambda t, w: fit_rates(t[:3], w[:3], epoch=EPOCH), "are 3; give four or more"),
        (lambda t, w: fit_rates(t[::-1], w, epoch=EPOCH), "do not increase"),
        (lambda t, w: fit_rates(t[::20], w[::20], epoch=EPOCH), "too far apart"),
        (lambda t, w: fit_rates(t, w, epoch=EPOCH, sigma=-1.0), "greater than zero"),
        (lambda t, w: fit_rates(t, w, epoch=EPOCH, loss="huber"), "give sigma=, or f_scale="),
        (lambda t, w: fit_rates(t, w, epoch=EPOCH, loss="l1"), "must be one of"),
        (lambda t, w: fit_rates(t, w, epoch=EPOCH, f_scale=0.0), "f_scale"),
        (lambda t, w: fit_rates(t, w, epoch=EPOCH, start=3), "give a FreeRotation"),
        (lambda t, w: fit_rates(5.0, w, epoch=EPOCH), "one row of epochs"),
        (lambda t, w: fit_rates(t, "x", epoch=EPOCH), "angular_velocity"),
    ],
)
def test_what_is_refused(call, sentence):
    history = motion(*STATES["short axis"]).at(T)
    with pytest.raises(AttitudeError, match=sentence):
        call(T, history.angular_velocity)
