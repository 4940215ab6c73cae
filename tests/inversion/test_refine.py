"""`inversion.refine`: free motion, impulses and torques, found from light curves near a start."""

import numpy as np
import pytest

from attitude import Body, FreeRotation, Spin, inversion, light_curve
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.arcs import Arcs, Impulse
from attitude.errors import AttitudeError
from attitude.frames import representations as forms
from attitude.frames.quaternion import conjugate, multiply
from attitude.inversion import _moving
from attitude.shape import Ellipsoid
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque, SolarRadiation
from tests.support.tumbler import (
    AXES,
    BODY,
    DAY,
    MOMENTS,
    RATES,
    SHAPE,
    SPIN,
    directions,
    start_beside,
)

MOMENTUM = float(np.linalg.norm(MOMENTS * RATES))


def _curve(motion, count=120, span=5.0, sigma=0.02):
    generator = np.random.default_rng(0)
    t = np.sort(generator.uniform(-0.5 * span, 0.5 * span, count)) * DAY
    sun, observer = directions(t)
    matrix = motion.at(t).matrix
    seen = [np.einsum("nij,ni->nj", matrix, each) for each in (sun, observer)]
    flux = light_curve.brightness(SHAPE, "lommel-seeliger", *seen)
    magnitude = 15.0 - 2.5 * np.log10(flux) + sigma * generator.normal(size=count)
    far = {"sun": sun * ASTRONOMICAL_UNIT_M, "observer": observer * ASTRONOMICAL_UNIT_M}
    return inversion.LightCurve(t, magnitude, sigma, epoch=motion.epoch, light_time=False, **far)


def _is_truth(refinement):
    """Whether rates and moments lie within 4 standard errors, and the fit leaves the noise."""
    covariance = refinement.motion.spin.covariance
    off = np.concatenate(
        [refinement.point.spin.angular_velocity - RATES, refinement.point.body.moments]
    )
    off[3:] -= MOMENTS
    sigma = np.sqrt(np.diag(covariance)[3:])
    assert np.all(np.abs(off[:5]) < 4.0 * sigma[:5] + 1e-12)
    assert refinement.chi_squared < 1.2
    return True


def test_free_motion_from_a_start():
    found = inversion.refine(_curve(FreeRotation(BODY, SPIN)), start_beside())
    assert _is_truth(found)
    assert isinstance(found.motion, FreeRotation)
    magnitude, sigma = found.predict()
    assert np.std(magnitude - found.curve.magnitude) < 0.025
    assert np.all(sigma > 0.0)
    assert found.shape.is_convex


@pytest.mark.slow
def test_two_spin_states_and_one_shape():
    momentum = 0.1 * MOMENTUM * np.array([0.5, -0.6, 0.6])
    truth = Arcs(BODY, SPIN, [Impulse(0.5 * DAY, momentum)])
    unknown = Impulse(0.5 * DAY, (0.0, 0.0, 0.0))
    found = inversion.refine(_curve(truth), start_beside(), arcs=unknown)
    assert _is_truth(found)
    assert np.all(np.abs(found.values - momentum) < 4.0 * found.values_sigma)
    assert np.all(found.values_sigma < 0.05 * MOMENTUM)
    before, after = found.states
    change = after.momentum - before.momentum
    matrix = truth.at(0.5 * DAY).matrix
    assert np.linalg.norm(change - matrix @ momentum) < 0.05 * MOMENTUM


@pytest.mark.slow
def test_a_constant_torque():
    torque = 0.1 * MOMENTUM / (6.0 * DAY) * np.array([3.0, -2.0, 4.0])
    truth = TorquedRotation(BODY, SPIN, ConstantTorque(torque), tolerance=1e-6)
    start = FreeRotation(BODY, SPIN)
    found = inversion.refine(
        _curve(truth, 80, 4.0),
        start,
        torques=ConstantTorque(0.8 * torque),
        moments=BODY,
        shape="ellipsoid",
    )
    assert found.chi_squared < 1.3
    assert np.all(np.abs(found.values - torque) < 4.0 * found.values_sigma)
    assert np.all(found.values_sigma < 0.2 * np.linalg.norm(torque))


@pytest.mark.parametrize("kind", ["arcs", "torque", "sunlight"])
def test_tangents_are_those_of_differences(kind):
    arcs = torques = None
    start, seconds = start_beside(), np.linspace(-2.0, 2.0, 9) * DAY
    if kind == "arcs":
        arcs = [
            Impulse(0.4 * DAY, 0.02 * MOMENTUM * np.ones(3)),
            Impulse(1.1 * DAY, 0.05 * MOMENTUM * np.array([1.0, -1.0, 0.5]), frame="icrf"),
        ]
    elif kind == "torque":
        torques = ConstantTorque(0.1 * MOMENTUM / (4.0 * DAY) * np.array([1.0, 2.0, -1.0]))
    else:
        body = Body(moments=MOMENTS * 1e9)
        start = FreeRotation(body, start.spin)
        place = ASTRONOMICAL_UNIT_M * np.array([1.0, 0.2, 0.1])
        mesh = Ellipsoid(AXES * 20.0).facets(200)
        mesh = type(mesh)(mesh.vertices + 0.5 * AXES, mesh.facets)
        torques = SolarRadiation(mesh, lambda t: np.broadcast_to(place, (*np.shape(t), 3)))
    ends = float(seconds[0]), float(seconds[-1])
    point = _moving.moving_point(start, start.epoch, ends, arcs, torques)
    _, slopes = point.attitudes(seconds)
    sizes = np.full(point.size, 1e-5)
    sizes[3:6] *= np.linalg.norm(RATES)
    sizes[_moving.STATE :] *= np.maximum(np.abs(point.values), 1e-3 * MOMENTUM / DAY)
    for p in range(point.size):
        step = np.zeros(point.size)
        step[p] = sizes[p]
        one, two = (point.moved(sign * step).motion.at(seconds).wxyz for sign in (1.0, -1.0))
        slope = forms.to_rotation_vector(multiply(one, conjugate(two))) / (2.0 * sizes[p])
        assert slope == pytest.approx(slopes[..., p], abs=1e-3 * np.abs(slopes[..., p]).max())


def test_what_cannot_be_refined():
    curve, start = _curve(FreeRotation(BODY, SPIN), count=40), start_beside()
    with pytest.raises(AttitudeError, match="start is int"):
        inversion.refine(curve, 3)
    with pytest.raises(AttitudeError, match="one of them"):
        impulse = Impulse(0.0, (0.0, 0.0, 0.0))
        inversion.refine(curve, start, arcs=impulse, torques=ConstantTorque((0.0, 0.0, 0.0)))
    with pytest.raises(AttitudeError, match=r"arcs\[0\] depends on the motion"):
        inversion.refine(curve, start, arcs=Impulse(0.0, lambda history: np.zeros(3)))
    with pytest.raises(AttitudeError, match="moments is"):
        inversion.refine(curve, start, moments="known")
    relative = FreeRotation(Body(moments=MOMENTS, relative=True), start.spin)
    yorp = SolarRadiation(SHAPE.facets(20), lambda t: np.ones((*np.shape(t), 3)))
    with pytest.raises(AttitudeError, match="moments of the body are relative"):
        inversion.refine(curve, relative, torques=yorp)


@pytest.mark.parametrize(
    ("days", "words"),
    [
        ([5.5], "after all points"),
        ([1.0, 5.5], r"arcs\[1\].*after all points"),
        ([-1.0], "earlier than the epoch of the spin"),
        ([1.0, 1.0], "the same as"),
        ([2.0, 1.0], "earlier than"),
    ],
)
def test_impulses_of_which_a_curve_says_nothing(days, words):
    curve = _curve(FreeRotation(BODY, SPIN), count=40)
    arcs = [Impulse(day * DAY, (0.0, 0.0, 0.0)) for day in days]
    with pytest.raises(AttitudeError, match=words):
        inversion.refine(curve, start_beside(), arcs=arcs)


def test_impulses_before_all_points():
    curve, start = _curve(FreeRotation(BODY, SPIN), count=40), start_beside()
    early = FreeRotation(start.body, start.spin_at(-9.0 * DAY))
    with pytest.raises(AttitudeError, match="before all points"):
        inversion.refine(curve, early, arcs=Impulse(DAY, (0.0, 0.0, 0.0)))


def test_moments_that_are_given_stay():
    curve = _curve(FreeRotation(BODY, SPIN))
    found = inversion.refine(curve, start_beside(), moments=[3.0 * each for each in MOMENTS])
    assert found.point.body.moments / found.point.body.moments.max() == pytest.approx(MOMENTS)
    assert found.chi_squared < 1.2
    assert found.moments / found.moments.max() == pytest.approx(np.sort(MOMENTS))


def test_what_is_held_has_no_errors():
    """A rotation about one axis, of which rates across it and moments are held."""
    motion = FreeRotation(BODY, Spin(SPIN.epoch, SPIN.wxyz, [0.0, 0.0, RATES[2]]))
    found = inversion.refine(_curve(motion), motion, shape=SHAPE.facets(100), law="lambert")
    assert not np.any(found.covariance[[3, 4, 6, 7]])
    assert found.weighted.refined.free.tolist() == [True] * 3 + [False] * 2 + [True] + [False] * 2
    assert found.predict().form.max() < 0.2 and found.predict().level.max() < 0.2


def test_nights_that_are_off_widen_the_errors_of_an_ellipsoid():
    """Its modes of areas are held: they took up what each night changes, so that none did."""
    curve = _curve(FreeRotation(BODY, SPIN))
    half_day = np.floor(curve.seconds / (0.5 * DAY)).astype(int)
    off = 0.05 * np.random.default_rng(2).normal(size=11)[half_day]
    shifted = curve.replaced(magnitude=curve.magnitude + off)
    found = inversion.refine(shifted, start_beside(), shape="ellipsoid")
    wider = np.diag(found.covariance) / np.diag(found.weighted.refined.covariance)[: _moving.STATE]
    assert np.median(np.sqrt(wider)) > 1.3


def test_a_file_says_what_it_does_not_store(tmp_path):
    curve, path = _curve(FreeRotation(BODY, SPIN)), tmp_path / "spin.toml"
    for arcs in (None, Impulse(0.5 * DAY, (0.0, 0.0, 0.0))):
        fit = inversion.refine(curve, start_beside(), arcs=arcs, shape=SHAPE.facets(50))
        fit.write(path)
        assert ("no free rotation" in path.read_text()) == (arcs is not None)
