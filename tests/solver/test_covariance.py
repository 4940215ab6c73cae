"""Covariances of attitudes: against the sensitivity, against samples, and bad input."""

import warnings

import numpy as np
import pytest

from attitude import AttitudeError, AttitudeTable, Body, FreeRotation, Spin
from attitude.errors import AttitudeWarning, CovarianceWarning
from attitude.frames import representations as forms
from attitude.frames.quaternion import conjugate, multiply

BODIES = {
    "tumbling": ((10, 20, 26), (9.0, 2.0, 1.0)),
    "hyperbolic": ((10, 20, 26), (1.0, 15.0, 1.0)),
    "symmetric": ((2, 2, 3), (0.3, 0.4, 0.9)),
    "sphere": ((2, 2, 2), (0.3, 0.5, 1.0)),
    "axis": ((1, 2, 2.7), (0.0, 0.0, 1.0)),
    "equator": ((2, 2, 3), (0.3, 0.5, 0.0)),
    "rest": ((1, 2, 2.7), (0.0, 0.0, 0.0)),
}


def spin_of(omega, covariance, **more):
    return Spin(
        epoch="2026-01-01",
        wxyz=(1, 2, 3, 4),
        angular_velocity=omega,
        covariance=covariance,
        **more,
    )


def full(seed=1, size=1e-4):
    root = np.random.default_rng(seed).normal(size=(9, 9)) * size
    return root @ root.T


@pytest.mark.parametrize("name", BODIES)
def test_products_of_the_sensitivity(name):
    moments, omega = BODIES[name]
    given = full()
    motion = FreeRotation(Body(moments=moments), spin_of(omega, given))
    t = np.linspace(-20.0, 30.0, 300)
    history = motion.at(t)
    attitude, rates = motion.sensitivity_at(t, angular_velocity=True)
    both = np.concatenate([attitude, rates], axis=1)
    expected = both @ given @ np.swapaxes(both, 1, 2)
    assert history.covariance.shape == (300, 6, 6)
    scale = np.abs(expected).max(axis=(1, 2))
    assert np.all(np.abs(history.covariance - expected).max(axis=(1, 2)) < 1e-13 * scale)
    assert np.array_equal(history.covariance, np.swapaxes(history.covariance, 1, 2))
    part = motion.covariance_at(t, rates=False)
    assert np.array_equal(part, history.covariance[:, :3, :3])
    for k in (0, 130, 150, 299):  # the same bits whatever the block
        assert np.array_equal(motion.covariance_at(t[k], rates=False), part[k])
    assert np.array_equal(history.sigma, np.sqrt(np.diagonal(part, axis1=1, axis2=2)))
    assert np.array_equal(history.sigma_deg, np.degrees(history.sigma))


@pytest.mark.filterwarnings("ignore::attitude.errors.CovarianceWarning")
@pytest.mark.parametrize("name", BODIES)
def test_large_results_have_the_bits_of_small_ones(name):
    """Results beyond 4 MB are stored past the caches, in whole lines of them."""
    moments, omega = BODIES[name]
    motion = FreeRotation(Body(moments=moments), spin_of(omega, full()))
    t = np.linspace(-20.0, 3000.0, 60003)
    t[777] = np.nan
    for rates in (False, True):
        found = motion.covariance_at(t, rates=rates)
        parts = [motion.covariance_at(t[k : k + 5000], rates=rates) for k in range(0, t.size, 5000)]
        assert np.array_equal(found, np.concatenate(parts), equal_nan=True)
        assert np.isnan(found[777]).all() and np.isfinite(found[778]).all()


@pytest.mark.parametrize("name", BODIES)
def test_within_the_scatter_of_samples(name):
    moments, omega = BODIES[name]
    motion = FreeRotation(Body(moments=moments), spin_of(omega, full(2, 1e-5)))
    t, count = np.array([0.0, 7.0, 19.0]), 2000
    wxyz = motion.at(t).wxyz
    turns = np.array(
        [
            forms.to_rotation_vector(multiply(each.at(t).wxyz, conjugate(wxyz)))
            for each in motion.sample(count, seed=5)
        ]
    )
    found = np.mean(turns[:, :, :, None] * turns[:, :, None, :], axis=0)
    linear = motion.covariance_at(t, rates=False)
    size = np.sqrt(np.diagonal(linear, axis1=1, axis2=2))
    scatter = size[:, :, None] * size[:, None, :] * np.sqrt(2.0 / count)
    assert np.all(np.abs(found - linear) < 5.0 * scatter)


def test_no_error_is_exactly_none():
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin_of((1, 15, 1), np.zeros((9, 9))))
    history = motion.at(np.linspace(0.0, 1e6, 7))
    assert not np.any(history.covariance) and not np.any(history.sigma)
    assert motion.sigma_points() == [] and not np.any(history.nonlinearity)


def test_the_attitude_at_the_epoch_has_the_given_error():
    spin = spin_of((1, 15, 1), {"attitude": ["1 deg", "2 deg", "3 deg"]}, frame="ecliptic")
    history = FreeRotation(Body(moments=(10, 20, 26)), spin).at(0.0)
    over_ecliptic = spin.covariance[:3, :3]
    assert np.allclose(np.degrees(np.sqrt(np.diag(over_ecliptic))), [1, 2, 3])
    assert np.isclose(np.trace(history.covariance[:3, :3]), np.trace(over_ecliptic))
    assert not np.allclose(history.sigma_deg, [1, 2, 3])


def test_nonlinearity_says_when_the_covariance_misleads():
    small, large = (
        FreeRotation(Body(moments=(10, 20, 26)), spin_of((1, 15, 1), {"angular_velocity": size}))
        for size in (1e-8, 3e-2)
    )
    t = np.array([0.0, 1.0, 100.0])
    assert np.all(small.at(t).nonlinearity < 1e-4)
    assert np.isnan(small.nonlinearity_at([0.0, 1.0], [np.nan, 0.0])).tolist() == [True, False]
    with pytest.warns(CovarianceWarning, match="nonlinearity"):
        found = large.at(t).nonlinearity
    assert found[0] < 1e-6 and found[2] >= 1.0


def test_sigma_points_carry_mean_and_covariance():
    motion = FreeRotation(Body(moments=(10, 20, 26)), spin_of((9, 2, 1), full(3, 1e-6)))
    points = motion.sigma_points()
    assert len(points) == 18
    rates = np.array([each.spin.angular_velocity for each in points]) - [9, 2, 1]
    expected = motion.spin.covariance[3:6, 3:6]
    assert np.allclose(0.5 * rates.T @ rates, expected, atol=1e-9 * np.abs(expected).max())


def test_errors_of_a_common_scale_are_none():
    """Ratios of moments decide: rounding of a singular covariance must not add directions."""
    moments = np.array([10.0, 20.0, 26.0])
    common = np.zeros((9, 9))
    common[6:, 6:] = 0.01 * np.outer(moments, moments)
    motion = FreeRotation(Body(moments=moments), spin_of((1, 15, 1), common))
    assert len(motion.sigma_points()) == 2
    # Of 1e5 rad in each moment alone.
    assert np.all(motion.at([0.0, 1e3, 1e5]).sigma < 2e-9)
    assert motion.predictable_time() == np.inf


# Times until errors reach a tolerance -------------------------------------------------------------


def largest(motion, seconds):
    return np.sqrt(np.linalg.eigvalsh(motion.covariance_at(seconds, rates=False))[..., -1])


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("size", [1e-5, 1e-2])
def test_the_first_time_at_which_the_tolerance_is_reached(name, size):
    moments, omega = BODIES[name]
    speed = max(np.linalg.norm(omega), 0.1)
    errors = {"attitude": 0.01, "angular_velocity": size * speed}
    motion = FreeRotation(Body(moments=moments), spin_of(omega, errors))
    found = motion.predictable_time(tolerance="0.2 rad")
    assert largest(motion, found) == pytest.approx(0.2, rel=1e-9)
    before = largest(motion, found * np.linspace(0.0, 1.0, 20001)[:-1])
    # Between 64 samples of a period the error may have been larger: by half a step of the phase,
    # of a wave as large as the error itself.
    assert np.max(before) < 0.2 * (1.0 + 0.5 * (np.pi / 64) ** 2 * 4)


@pytest.mark.parametrize("name", ["tumbling", "symmetric", "sphere", "axis", "equator"])
def test_the_time_agrees_with_that_of_relative_errors(name):
    moments, omega = BODIES[name]
    size = 1e-6 * np.linalg.norm(omega)
    motion = FreeRotation(Body(moments=moments), spin_of(omega, {"angular_velocity": size}))
    older = motion.predictable_time(rates_error=1e-6, tolerance=0.05)
    # The drift alone, added over both phases; the periodic part is 1e-2 of it.
    assert motion.predictable_time(tolerance=0.05) == pytest.approx(older, rel=0.02)
    assert motion.predictable_time(moments_error=0.0) == np.inf


def test_times_without_growth():
    body = Body(moments=(10, 20, 26))
    for errors, expected in (({"attitude": 0.05}, np.inf), ({"attitude": 0.2}, 0.0), ({}, np.inf)):
        motion = FreeRotation(body, spin_of((9, 2, 1), errors))
        assert motion.predictable_time() == expected
    with pytest.raises(AttitudeError, match=r"tolerance is -1\.0"):
        motion.predictable_time(tolerance=-1)


def test_nothing_is_predictable_beyond_a_flip_whose_side_is_open():
    """Linear errors reach 3 rad after 10.1 s, but the side to which the body turns is open."""
    body, omega = Body(moments=(10, 20, 26)), (1e-7, 15.0, 0.8e-7)
    open_side = FreeRotation(body, spin_of(omega, {"angular_velocity": 1e-10}))
    assert open_side.predictable_time(tolerance=3.0) == 0.5 * open_side.period_psi
    firm = FreeRotation(body, spin_of(omega, {"angular_velocity": 1e-12}))
    assert firm.predictable_time(tolerance=3.0) > 100.0 * firm.period_psi / 2


def test_samples_repeat_and_keep_moments_of_bodies():
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin_of((0.1, 0.2, 1), {"moments": 0.05}))
    one, two = motion.sample(20, seed=1), motion.sample(20, seed=1)
    assert all(
        np.array_equal(a.body.moments, b.body.moments) for a, b in zip(one, two, strict=True)
    )
    for each in one:
        moments = np.sort(each.body.moments)
        assert moments[2] <= moments[0] + moments[1] + 1e-12
    hopeless = FreeRotation(Body(moments=(1, 2, 3)), spin_of((0.1, 0.2, 1), {"moments": 1e6}))
    with pytest.raises(AttitudeError, match="draws"):
        hopeless.sample(50)


@pytest.mark.parametrize(
    ("covariance", "words"),
    [
        (np.eye(5), "shape"),
        (np.diag([1, 1, 1, 1, 1, 1, 1, 1, -1.0]), "not negative"),
        (np.triu(np.ones((9, 9))), "not symmetric"),
        (
            np.ones((6, 6)) - 2.0 * np.eye(6) + 2.5 * np.eye(6) - 1.2 * np.ones((6, 6)),
            "negative|not",
        ),
        (np.full((9, 9), np.nan), "finite"),
        ({"attitude": "-1 rad"}, r"attitude is -1\.0; .* not negative"),
        ({"attitudes": 1.0}, "its names are"),
        ({"angular_velocity": "1 kg"}, "kg"),
        ("large", "covariance"),
    ],
)
def test_what_is_refused(covariance, words):
    with pytest.raises(AttitudeError, match=words):
        spin_of((1, 2, 3), covariance)


@pytest.mark.filterwarnings("ignore::attitude.errors.CovarianceWarning")
def test_moments_of_a_relative_body_have_errors_in_its_unit():
    """The common scale of the moments and of their errors changes nothing."""
    errors = {"attitude": 1e-3, "angular_velocity": 1e-4, "moments": [0.01, 0.02, 0.03]}
    body = Body(moments=(1.0, 2.0, 2.6), relative=True)
    relative = FreeRotation(body, spin_of((0.1, 1.5, 0.1), errors))
    errors["moments"] = [10.0, 20.0, 30.0]
    heavy = FreeRotation(Body(moments=(1e3, 2e3, 2.6e3)), spin_of((0.1, 1.5, 0.1), errors))
    t = np.array([0.0, 10.0, 100.0])
    assert np.allclose(relative.at(t).covariance, heavy.at(t).covariance, rtol=1e-11)
    assert relative.sigma_points()[0].body.relative
    time = relative.predictable_time(tolerance=0.2)
    assert time == pytest.approx(heavy.predictable_time(tolerance=0.2), rel=1e-9)


def test_tables_say_that_they_have_no_covariance():
    table = AttitudeTable("2026-01-01", [0.0, 20.0], [[1, 0, 0, 0], [0.8, 0, 0, 0.6]])
    for motion in (table,):
        history, kind = motion.at([0.0, 20.0]), type(motion).__name__
        for name in ("covariance", "attitude_covariance", "sigma", "nonlinearity"):
            with pytest.raises(AttitudeError, match=f"{kind} has no derivatives"):
                getattr(history, name)
        with pytest.raises(AttitudeError, match=f"{kind} has no derivatives"):
            history.body_to_inertial_sigma((0, 0, 1))
        with pytest.raises(AttitudeError, match=f"{kind} has no derivatives"):
            motion.momentum_covariance  # noqa: B018


def test_without_a_covariance():
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin_of((1, 2, 3), None))
    for name in ("covariance", "sigma", "nonlinearity"):
        with pytest.raises(AttitudeError, match="has no covariance"):
            getattr(motion.at(1.0), name)
    again = FreeRotation(motion.body, motion.spin.with_covariance({"attitude": 0.1}))
    assert np.allclose(again.at(0.0).sigma, 0.1)
    assert again.spin.with_covariance(None).covariance is None


def large(errors, omega=(0.3, 1.0, 0.2)):
    """A motion of a body with errors."""
    return FreeRotation(Body(moments=(1, 2, 3)), spin_of(omega, errors))


def test_a_covariance_without_meaning_warns_once():
    motion = large({"attitude": "61 deg"})
    with pytest.warns(CovarianceWarning, match="reaches 61 deg: covariances do not describe"):
        _ = motion.at(0.0).sigma
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _ = motion.at([0.0, 1.0]).covariance  # said before
        _ = large({"attitude": "59 deg"}).at(0.0).covariance  # linear at the epoch
        grown = large({"angular_velocity": 1e-3})
        _ = grown.at(10.0).sigma
        assert 100.0 < grown.predictable_time(tolerance=1.5) < 1e5  # looks beyond, and says nothing
    with pytest.warns(CovarianceWarning):
        grown.covariance_at([10.0, 1e5], rates=False)
    assert issubclass(CovarianceWarning, AttitudeWarning)


def test_covariances_warn_of_nonlinearity():
    """Below 60 deg: about the middle axis errors of 29 deg are linear at first, then not."""
    errors, omega = {"angular_velocity": 0.02}, (0.02, 1.0, 0.02)
    motion = large(errors, omega)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        before = motion.at(5.8)
        assert 25.0 < np.max(before.sigma_deg) < 35.0 and before.nonlinearity < 0.1
    with pytest.warns(CovarianceWarning, match="nonlinearity of the errors of the attitude reach"):
        _ = motion.at(13.1).nonlinearity
    motion = large(errors, omega)
    with pytest.warns(CovarianceWarning, match="nonlinearity of the errors of the attitude reach"):
        later = motion.at([13.1, 13.2]).sigma_deg
    assert np.max(later) < 50.0


def test_warnings_pass_over_nan_epochs():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion = large({"attitude": "20 deg"})
        assert np.all(np.isnan(motion.at([np.nan]).sigma))
        _ = motion.at([np.nan, 0.0]).sigma
    with pytest.warns(CovarianceWarning):
        _ = large({"attitude": "70 deg"}).at([np.nan, 0.0]).sigma
