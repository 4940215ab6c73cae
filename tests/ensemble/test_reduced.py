"""Percentiles, histograms and coverage against numpy on the whole array."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, Ensemble, FreeRotation, Scene, Spin
from attitude.ensemble import AngleTo
from attitude.shape import Ellipsoid
from tests.support import states

EPOCH = "2026-01-01"
BODY = Body(moments=(10, 20, 26))
MOTION = FreeRotation(BODY, Spin(EPOCH, (1, 2, 3, 4), (0.01, 0.02, 0.15)))
T = np.linspace(0.0, 300.0, 41)


@pytest.fixture(scope="module")
def ensemble():
    """Members of one body."""
    return Ensemble.sample(MOTION, 301, covariance={"attitude": 0.3, "angular_velocity": 0.01})


def _angles(ensemble, axis, target):
    history = ensemble.at(T)
    turned = history.body_to_inertial(axis / np.linalg.norm(axis))
    return np.arccos(np.clip(np.sum(turned * target, axis=-1), -1.0, 1.0))


@pytest.mark.parametrize("threads", [1, 2])
def test_percentiles_of_an_angle(ensemble, threads):
    axis, target = np.array([0.0, 0.3, 2.0]), np.array([0.6, 0.0, 0.8])
    q = [0.0, 5.0, 50.0, 97.3, 100.0]
    found = ensemble.percentiles(AngleTo(axis, 5 * target), T, q, threads=threads)
    # arc cosines near 0 and pi know half of the digits
    assert np.allclose(found, np.percentile(_angles(ensemble, axis, target), q, axis=0), atol=1e-7)
    moving = np.stack([np.cos(T / 50), np.sin(T / 50), 0 * T], axis=-1)
    found = ensemble.percentiles(AngleTo(axis, moving), T, [50.0])[0]
    assert np.allclose(found, np.median(_angles(ensemble, axis, moving), axis=0), atol=1e-7)
    seen = AngleTo(axis, MOTION.at(7.0).body_to_inertial(axis))
    aligned = Ensemble.of([MOTION]).percentiles(seen, [7.0])
    assert np.all(aligned < 1e-15)


def test_functions_and_members_that_are_unknown():
    kept = Ensemble(
        moments=[(1, 2, 2.5), (1, 1, 5), (2, 3, 4)], wxyz=(1, 0, 0, 0),
        angular_velocity=[(0.1, 0, 0.2), (1, 1, 1), (0.3, 0.1, 0.2)], epoch=EPOCH, on_error="nan",
    )  # fmt: skip
    given = kept.at(T).wxyz[..., 2]
    found = kept.percentiles(lambda history: history.wxyz[..., 2], T, [25.0, 50.0])
    assert np.allclose(found, np.nanpercentile(given, [25.0, 50.0], axis=0), atol=1e-15)
    assert np.isnan(kept[[1]].percentiles(lambda history: history.wxyz[..., 2], T)).all()
    assert np.isnan(kept[:0].percentiles(lambda history: history.wxyz[..., 2], T)).all()


@pytest.mark.parametrize("name", ["magnitude", "aspect_angle", "phase_angle", "brightness"])
def test_quantities_of_scenes(ensemble, name):
    from attitude import paths

    center = paths.fixed((1.2e11, 5e10, 1e10))
    shape = Ellipsoid((300.0, 200.0, 100.0))
    options = {"center": center, "observer": "earth", "sun": "sun", "shape": shape}
    few = ensemble[:5]
    each = [getattr(Scene(few[k], **options).at(T), name) for k in range(5)]
    scene = Scene(None, **options)
    found = few.percentiles(name, T, [0.0, 30.0, 100.0], scene=scene)
    assert np.allclose(found, np.percentile(each, [0.0, 30.0, 100.0], axis=0), rtol=1e-11)
    with_motion = Scene(few[0], **options)
    assert np.array_equal(few.percentiles(name, T, [30.0], scene=with_motion)[0], found[1])


def test_scenes_of_members_with_epochs_of_their_own():
    given = states.sample(1, seed=4)[:3]
    starts = ["2026-01-01", "2026-01-02", "2026-01-03T04:00"]
    members = [
        FreeRotation(Body(moments=s.moments), Spin(e, s.wxyz0, s.omega0))
        for s, e in zip(given, starts, strict=True)
    ]
    scene = Scene(None, observer=(1, 0, 0), sun=(0, 1, 0), shape=Ellipsoid((3, 2, 1)))
    dates = ["2026-02-01", "2026-02-02", "2026-02-05"]
    found = Ensemble.of(members).percentiles("reduced_magnitude", dates, [50.0], scene=scene)
    options = {"observer": (1, 0, 0), "sun": (0, 1, 0), "shape": Ellipsoid((3, 2, 1))}
    each = [Scene(motion, **options).at(dates).reduced_magnitude for motion in members]
    assert np.allclose(found[0], np.median(each, axis=0), rtol=0, atol=1e-7)


def test_histograms(ensemble):
    edges = np.array([0.0, 0.5, 1.0, 1.2, 2.0])
    quantity = AngleTo((0, 0, 1), (1, 0, 0))
    found = ensemble.histograms(quantity, T, edges)
    values = _angles(ensemble, np.array([0.0, 0, 1]), np.array([1.0, 0, 0]))
    expected = [np.histogram(values[:, k], edges)[0] for k in range(len(T))]
    assert np.array_equal(found, expected)
    ends = ensemble.histograms(lambda h: np.broadcast_to(2.0, h.shape), T, [1.0, 2.0])
    assert np.all(ends == len(ensemble))


def test_coverage(ensemble):
    quantity, limit = AngleTo((0, 0, 1), (1, 0, 0)), 1.0
    found = ensemble.coverage(quantity, T, greatest=limit, threads=2)
    within = _angles(ensemble, np.array([0.0, 0, 1]), np.array([1.0, 0, 0])) <= limit
    for k in range(len(ensemble)):
        share = np.mean(0.5 * (within[k, 1:].astype(float) + within[k, :-1]))
        assert abs(found.fraction[k] - share) < 1e-12
        times = T[within[k]]
        gaps = np.diff(np.concatenate([[T[0]], times, [T[-1]]])) if len(times) else [T[-1] - T[0]]
        assert abs(found.longest_gap[k] - np.max(gaps)) < 1e-12
    assert 0.1 < np.mean(found.fraction) < 0.9
    in_degrees = ensemble.coverage(quantity, T, greatest=f"{np.degrees(limit)} deg")
    np.testing.assert_allclose(in_degrees.fraction, found.fraction, atol=1e-12)
    never = ensemble.coverage(quantity, T, least=4.0)
    assert np.all(never.fraction == 0.0) and np.all(never.longest_gap == 300.0)
    always = ensemble.coverage(quantity, T)
    assert np.all(always.fraction == 1.0) and np.allclose(always.longest_gap, 300.0 / 40)


def test_bad_input(ensemble):
    angle = AngleTo((0, 0, 1), (1, 0, 0))
    scene = Scene(None, observer=(1, 0, 0), sun=(1, 0, 0))
    for call, sentence in (
        (lambda: ensemble.percentiles("magnitude", T), "give scene="),
        (lambda: ensemble.percentiles("colour", T, scene=scene), "is not a number of a view"),
        (lambda: ensemble.percentiles(3, T), "quantity is 3"),
        (lambda: ensemble.percentiles(angle, T, [101]), "percentages are"),
        (lambda: ensemble.percentiles(angle, 5.0), "t is one epoch"),
        (lambda: ensemble.percentiles(lambda h: 3.0, T), "return one number for each attitude"),
        (lambda: ensemble.histograms(angle, T, [1, 0]), "edges are"),
        (lambda: ensemble.coverage(angle, T[::-1]), "t does not ascend"),
        (lambda: ensemble.coverage(angle, T, least=None), "least is None"),
        (lambda: ensemble.coverage(angle, T, greatest="x"), "greatest is 'x'"),
        (lambda: AngleTo((0, 0, 0), (1, 0, 0)), "axis is zero"),
        (lambda: AngleTo((0, 0, 1), np.zeros((4, 3))), "target holds a zero vector"),
        (lambda: ensemble.percentiles(AngleTo((0, 0, 1), np.ones((4, 3))), T), "target has 4"),
        (lambda: ensemble.percentiles(AngleTo((0, 0, 1), np.ones((400, 3))), T), "target has 400"),
    ):  # fmt: skip
        with pytest.raises(AttitudeError, match=sentence):
            call()
