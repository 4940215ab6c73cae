"""Motions from directions of stars and of the Sun over the body axes."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, fit_directions, frames
from attitude.frames import quaternion
from attitude.frames import representations as forms

EPOCH = "2026-01-01"
TURN = forms.to_matrix(forms.from_axis_angle((1, 2, -1), 0.4))
TWO = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]])
SUN = np.array([0.6, 0.0, 0.8])
STATES = {
    "short axis": (0.1, 0.15, 1.0),
    "long axis": (1.0, 0.15, 0.1),
    "near the separatrix": (0.01, 1.5, 0.01),
}


def motion(rates, turn=None):
    body = Body(moments=(10, 20, 26))
    if turn is not None:
        body = Body(tensor=turn @ np.diag([10.0, 20.0, 26.0]) @ turn.T)
    spin = Spin(epoch=EPOCH, wxyz=(1, -2, 3, 0.5), angular_velocity=rates)
    return FreeRotation(body, spin)


def seen(motion, t, known):
    return motion.at(t).inertial_to_body(np.broadcast_to(known, (len(t), 3)))


def relative(body):
    return body.tensor / np.trace(body.tensor)


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return 2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0]))


@pytest.mark.parametrize("name", STATES)
@pytest.mark.parametrize("axes", ["principal", "free"])
@pytest.mark.parametrize("together", [True, False])
def test_two_stars_give_the_motion_back(name, axes, together):
    """Both at each epoch, or one after the other."""
    given = motion(STATES[name], TURN if axes == "free" else None)
    t = np.arange(0.0, 100.0, 0.2)
    t = np.repeat(t[::2], 2) if together else t
    known = np.resize(TWO, (len(t), 3))
    found = fit_directions(t, 3.0 * seen(given, t, known), known, epoch=EPOCH, axes=axes)
    assert found.rms < 1e-11
    assert np.max(np.abs(relative(found.motion.body) - relative(given.body))) < 1e-9
    assert apart(found.motion.at(200.0).wxyz, given.at(200.0).wxyz) < 1e-9
    assert found.residuals.shape == (len(t), 3) and found.rate_residuals is None


def test_the_turn_about_one_direction_stays_open():
    given = motion(STATES["short axis"])
    t = np.arange(0.0, 100.0, 0.2)
    random = np.random.default_rng(3)
    measured = seen(given, t, SUN) + random.normal(scale=1e-3, size=(len(t), 3))
    found = fit_directions(t, measured, SUN, epoch=EPOCH, sigma=1e-3)
    variances = np.diag(found.covariance)
    assert np.all(np.isinf(variances[:3])) and np.all(variances[3:] < 1e-4)
    # Two components of each direction, each with its error.
    assert abs(found.rms / (np.sqrt(2.0) * 1e-3) - 1.0) < 0.1
    errors = np.sqrt(variances[3:6])
    off = found.motion.spin.angular_velocity - given.spin.angular_velocity
    assert np.all(np.abs(off) < 5.0 * errors)
    # The spin: nothing is known about the turn about the Sun, the directions across are known.
    covariance = found.motion.spin.covariance[:3, :3]
    unknown = (np.pi**2 / 3.0 + 2.0) / 3.0
    assert abs(SUN @ covariance @ SUN / unknown - 1.0) < 1e-3
    across = np.cross(SUN, (0.0, 1.0, 0.0))
    assert across @ covariance @ across < 1e-4
    # The Sun is then predicted, whatever the turn about it.
    later = found.motion.at(120.0).inertial_to_body(SUN)
    assert np.linalg.norm(later - given.at(120.0).inertial_to_body(SUN)) < 1e-2


def test_a_spin_about_the_direction_seen_determines_nothing_else():
    body = Body(moments=(10, 20, 26))
    spin = Spin(epoch=EPOCH, wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.5))
    given = FreeRotation(body, spin)
    t = np.arange(0.0, 60.0, 0.5)
    found = fit_directions(t, seen(given, t, (0, 0, 1)), (0, 0, 1), body, epoch=EPOCH)
    assert found.rms < 1e-9
    assert np.isinf(found.covariance[2, 2])
    assert np.all(np.isfinite(found.motion.spin.covariance))


def test_frames_and_starts():
    given = motion(STATES["short axis"])
    t = np.arange(0.0, 60.0, 0.2)
    known = np.resize(TWO, (len(t), 3))
    ecliptic = known @ frames.matrix_to_icrf("ecliptic")
    found = fit_directions(t, seen(given, t, known), ecliptic, epoch=EPOCH, frame="ecliptic")
    assert apart(found.motion.at(30.0).wxyz, given.at(30.0).wxyz) < 1e-9
    # Directions two rad apart: from a start.
    t = np.arange(0.0, 200.0, 2.1)
    known = np.resize(TWO, (len(t), 3))
    near = FreeRotation(Body(moments=(10, 20.001, 26)), given.spin)
    found = fit_directions(t, seen(given, t, known), known, epoch=EPOCH, start=near)
    assert found.rms < 1e-11
    assert np.max(np.abs(relative(found.motion.body) - relative(given.body))) < 1e-9


def test_outliers():
    given = motion(STATES["long axis"])
    random = np.random.default_rng(8)
    t = np.repeat(np.arange(0.0, 100.0, 0.4), 2)
    known = np.resize(TWO, (len(t), 3))
    measured = seen(given, t, known) + random.normal(scale=1e-3, size=(len(t), 3))
    wrong = random.choice(len(t), len(t) // 10, replace=False)
    measured[wrong] = random.normal(size=(len(wrong), 3))
    found = fit_directions(t, measured, known, epoch=EPOCH, sigma=1e-3, loss="cauchy")
    assert apart(found.motion.at(50.0).wxyz, given.at(50.0).wxyz) < 1e-3
    angles = np.linalg.norm(found.residuals, axis=1)
    assert np.median(np.delete(angles, wrong)) < 2e-3 < np.median(angles[wrong])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda t, b, s: fit_directions(t, b, s), "with epoch="),
        (lambda t, b, s: fit_directions(t, b[:3], s, epoch=EPOCH), "body_directions has shape"),
        (lambda t, b, s: fit_directions(t, b, s[:4], epoch=EPOCH), "inertial_directions has"),
        (lambda t, b, s: fit_directions(t, 0.0 * b, s, epoch=EPOCH), "length zero"),
        (lambda t, b, s: fit_directions(t[:3], b[:3], s[:3], epoch=EPOCH), "8 parameters"),
        (lambda t, b, s: fit_directions(t, b, s, epoch=EPOCH, sigma=np.inf), "0 directions with"),
        (lambda t, b, s: fit_directions(t[::-1], b, s, epoch=EPOCH), "do not increase"),
        (lambda t, b, s: fit_directions(t, b, s, epoch=EPOCH, frame="mars"), "frame"),
        (lambda t, b, s: fit_directions(t, b, s, epoch=EPOCH, loss="huber"), "f_scale="),
        (lambda t, b, s: fit_directions(t, b, s, epoch=EPOCH, axes="z"), "principal"),
        (
            lambda t, b, s: fit_directions(np.zeros(len(t)), b, SUN, epoch=EPOCH),
            "fewer than three epochs",
        ),
        (
            lambda t, b, s: fit_directions(t, b, s, epoch=EPOCH, start=motion((0, 0, 1), TURN)),
            'axes="free"',
        ),
    ],
)
def test_what_is_refused(call, sentence):
    t = np.arange(0.0, 10.0, 0.2)
    known = np.resize(TWO, (len(t), 3))
    with pytest.raises(AttitudeError, match=sentence):
        call(t, seen(motion(STATES["short axis"]), t, known), known)
