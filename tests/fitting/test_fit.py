"""A motion is found again from its records: exact ones, noisy ones, the radar's of Toutatis."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.errors import AttitudeWarning
from attitude.fitting import fit
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._table import AttitudeTable
from tests.support.places import DATA

STATES = {
    "short axis": ((10, 20, 26), (0.1, 0.15, 1.0)),
    "long axis": ((10, 20, 26), (1.0, 0.15, 0.1)),
    "near the separatrix": ((10, 20, 26), (0.01, 1.5, 0.01)),
    "other order": ((26, 10, 20), (0.4, 0.3, 0.2)),
    "flat": ((10, 10.5, 20.4), (0.3, 0.2, 1.0)),
}


def motion(moments, rates):
    spin = Spin(epoch="2026-01-01", wxyz=(1, -2, 3, 0.5), angular_velocity=rates)
    return FreeRotation(Body(moments=moments), spin)


def noisy(given, t, sigma, seed):
    """A table of attitudes with errors."""
    noise = np.random.default_rng(seed).normal(size=(len(t), 3)) * sigma
    wxyz = quaternion.multiply(given.at(t).wxyz, forms.from_rotation_vector(noise))
    return AttitudeTable("2026-01-01", t, wxyz)


def excess(motion, given, table, sigma):
    """chi2 of a motion less that of the truth."""
    turns = [
        forms.to_rotation_vector(
            quaternion.multiply(table.history.wxyz, quaternion.conjugate(m.at(table.seconds).wxyz))
        )
        for m in (motion, given)
    ]
    return (np.sum(turns[0] ** 2) - np.sum(turns[1] ** 2)) / sigma**2


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


@pytest.mark.parametrize("name", STATES)
@pytest.mark.parametrize("rates", [True, False])
def test_exact_records_give_the_motion_back(name, rates):
    given = motion(*STATES[name])
    table = AttitudeTable.from_history(given.at(np.arange(0.0, 200.0, 0.4)), rates=rates)
    found = fit(table)
    assert found.rms < 1e-10
    moments = found.motion.body.moments / found.motion.body.moments.sum()
    assert np.max(np.abs(moments - given.body.moments / given.body.moments.sum())) < 1e-9
    assert apart(found.motion.at(1000.0).wxyz, given.at(1000.0).wxyz) < 1e-7
    assert found.motion.body.relative


def test_noise_comes_out_as_the_residuals_and_moments_within_their_covariance():
    given = motion((10, 20, 26), (0.1, 0.15, 1.0))
    random = np.random.default_rng(4)
    history = given.at(np.arange(0.0, 300.0, 0.5))
    noise = random.normal(scale=1e-3, size=(len(history), 3))
    wxyz = quaternion.multiply(history.wxyz, forms.from_rotation_vector(noise))
    found = fit(AttitudeTable(history.epoch, history.seconds, wxyz))
    # rms of three components: 1.7e-3 within a few percent for 600 records
    assert abs(found.rms / (np.sqrt(3.0) * 1e-3) - 1.0) < 0.05
    assert np.corrcoef(found.residuals.ravel(), noise.ravel())[0, 1] > 0.98
    off = found.motion.spin.angular_velocity - given.spin.angular_velocity
    errors = np.sqrt(np.diag(found.covariance)[3:6])
    assert np.all(np.abs(off) < 5.0 * errors) and np.all(errors < 2e-4)
    assert found.rate_residuals is None


def test_axes_that_are_not_the_principal_ones():
    turn = forms.to_matrix(forms.from_axis_angle((1, 2, -1), 0.4))
    body = Body(tensor=turn @ np.diag([10.0, 20.0, 26.0]) @ turn.T)
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.3, 0.2, 0.7))
    given = FreeRotation(body, spin)
    table = AttitudeTable.from_history(given.at(np.arange(0.0, 120.0, 0.4)))
    found = fit(table, axes="free")
    assert found.rms < 1e-9
    tensor = found.motion.body.tensor / np.trace(found.motion.body.tensor)
    assert np.max(np.abs(tensor - body.tensor / np.trace(body.tensor))) < 1e-8
    with pytest.warns(AttitudeWarning, match="far larger than the errors"):
        assert fit(table).rms > 1e-2  # principal axes will not do
    known = fit(table, body=body)
    assert known.rms < 1e-11 and known.motion.body is body


def test_a_steady_rotation_leaves_the_moments_open():
    given = motion((10, 20, 26), (0.0, 0.0, 0.5))
    found = fit(AttitudeTable.from_history(given.at(np.arange(0.0, 60.0, 0.5))))
    assert found.rms < 1e-9
    assert np.isinf(found.covariance[6:, 6:].diagonal()).any() or np.all(
        np.abs(found.covariance) < 1.0
    )


@pytest.mark.parametrize(
    ("seed", "rates", "sigma", "t"),
    [
        (0, (0.001, 0.001, 1.0), 2e-3, np.arange(0.0, 120.0, 0.5)),
        (5, (0.001, 0.001, 1.0), 2e-3, np.arange(0.0, 120.0, 0.5)),
        (1, (0.0005, 0.001, 0.15), 3e-3, np.linspace(0.0, 2000.0, 1000)),
    ],
)
def test_the_wobble_of_a_nearly_steady_rotation(seed, rates, sigma, t):
    """Of its many minima the one of the truth, or a lower one, is returned."""
    given = motion((10, 20, 26), rates)
    table = noisy(given, t, sigma, seed)
    assert excess(fit(table, sigma=sigma).motion, given, table, sigma) < 0.0


@pytest.mark.parametrize("seed", [1, 2])
def test_a_needle_that_turns_about_its_long_axis(seed):
    """Its wobble is found before other first guesses are tried, and without a warning."""
    given = motion((0.01, 1.0, 1.005), (1.0, 3.0e-4, 4.0e-4))
    table = noisy(given, np.linspace(0.0, 2000.0, 2000), 0.01, seed)
    assert excess(fit(table, sigma=0.01).motion, given, table, 0.01) < 0.0


@pytest.mark.parametrize("rates", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
def test_without_an_evident_wobble_the_body_is_a_sphere(rates):
    given = motion((10, 20, 26), rates)
    found = fit(noisy(given, np.arange(0.0, 120.0, 0.5), 2e-3, 8), sigma=2e-3)
    assert np.allclose(found.motion.body.moments, 1.0 / 3.0, rtol=1e-12)
    assert np.all(np.isinf(found.covariance.diagonal()[6:]))
    late, true = found.motion.at(200.0), given.at(200.0)
    assert apart(late.wxyz, true.wxyz) < 5.0 * np.max(late.sigma)
    off = late.angular_velocity - true.angular_velocity
    assert np.all(np.abs(off) < 5.0 * late.sigma_angular_velocity)


@pytest.mark.parametrize("later", [3000.0, 30000.0])
def test_two_sessions(later):
    """The first one predicts the second to 0.2 rad, or not at all."""
    given = motion((10, 20, 26), (0.4, 0.3, 1.0))
    t = np.concatenate([np.arange(0.0, 20.0, 0.3), np.arange(later, later + 20.0, 0.3)])
    if later > 1e4:
        with pytest.warns(AttitudeWarning, match="between records 66 and 67 .* are not counted"):
            fit(noisy(given, t, 3e-3, 1), sigma=3e-3)
        return
    for seed in (0, 6, 7):
        table = noisy(given, t, 3e-3, seed)
        found = fit(table, sigma=3e-3)
        assert excess(found.motion, given, table, 3e-3) < 0.0
        late = found.motion.at(1.5 * later)
        assert apart(late.wxyz, given.at(1.5 * later).wxyz) < 5.0 * np.max(late.sigma)


def test_errors_without_degrees_of_freedom():
    """Six numbers for six parameters: the errors are those of sigma, or unknown."""
    given = motion((10, 20, 26), (0.1, 0.15, 1.0))
    table = noisy(given, np.array([0.0, 1.0]), 0.01, 0)
    found = fit(table, given.body, sigma=0.01)
    assert np.allclose(found.motion.at(0.0).sigma, 0.01, rtol=1e-6)
    with pytest.warns(AttitudeWarning, match="no more numbers than .* Give sigma="):
        found = fit(table, given.body)
    assert np.all(np.isinf(found.covariance.diagonal()))
    assert np.all(found.motion.spin.covariance.diagonal()[:3] > 1.0)


def test_coarse_records_with_rates():
    """Six turns between records: rates and the growing span keep count."""
    given = motion((10, 20, 26), (0.1, 0.15, 1.0))
    t = np.concatenate([np.arange(0.0, 20.0, 0.5), np.arange(20.0, 300.0, 37.0)])
    found = fit(AttitudeTable.from_history(given.at(t)))
    assert found.rms < 1e-9


def test_the_radar_attitudes_of_toutatis():
    """18 attitudes of 1992 and 2008, of which the model of Takahashi et al. (2013) was made."""

    path = DATA / "toutatis-observed.csv"
    rows = [line.split(",") for line in path.read_text().splitlines() if line[0] == "1"]
    angles = np.radians([[float(value) for value in row[1:4]] for row in rows])
    rates = np.radians([[float(value) for value in row[4:7]] for row in rows]) / 86400.0
    table = AttitudeTable(
        rows[0][0],
        [row[0] for row in rows],
        quaternion.from_euler("ZXZ", angles),
        angular_velocity=rates,
        frame="ecliptic",
    )
    found = fit(table, sigma=np.radians(5.0), rate_sigma=np.radians(3.0) / 86400.0)
    # Published: moments 3.0836, 3.235, 1, periods 5.38 and 7.4 d (the observations err by 3-15 deg)
    moments = found.motion.body.moments / found.motion.body.moments[2]
    assert np.allclose(moments, (3.0836, 3.235, 1.0), atol=0.15)
    assert found.motion.mode.name == "LONG_AXIS"
    assert abs(found.motion.period_psi / 86400.0 - 5.38) < 0.1
    assert abs(found.motion.period_phi / 86400.0 - 7.4) < 0.1
    assert np.degrees(found.rms) < 15.0


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
@pytest.mark.parametrize("axes", ["principal", "free"])
def test_a_tenth_of_outliers(loss, axes):
    """Attitudes anywhere, from the first record on, where the squares of least squares fail."""
    given = motion((10, 20, 26), (0.1, 0.15, 1.0))
    random = np.random.default_rng(6)
    history = given.at(np.arange(0.0, 200.0, 0.4))
    noise = random.normal(scale=1e-3, size=(len(history), 3))
    wrong = np.concatenate([[0, 3], random.choice(np.arange(5, len(history)), 48, replace=False)])
    noise[wrong] = random.normal(size=(50, 3))
    wxyz = quaternion.multiply(history.wxyz, forms.from_rotation_vector(noise))
    table = AttitudeTable(history.epoch, history.seconds, wxyz)
    found = fit(table, sigma=1e-3, loss=loss, axes=axes)
    angles = np.linalg.norm(found.residuals, axis=1)
    # Three components of 1e-3 rad: the median angle is 1.54e-3.
    assert abs(np.median(np.delete(angles, wrong)) / 1.54e-3 - 1.0) < 0.15
    off = found.motion.spin.angular_velocity - given.spin.angular_velocity
    errors = np.sqrt(np.diag(found.covariance)[3:6])
    assert np.all(np.abs(off) < 5.0 * errors) and np.all(errors < 3e-4)
    assert apart(found.motion.at(100.0).wxyz, given.at(100.0).wxyz) < 2e-3


def test_least_squares_are_a_robust_loss_of_large_scale():
    given = motion((10, 20, 26), (0.1, 0.15, 1.0))
    random = np.random.default_rng(7)
    history = given.at(np.arange(0.0, 100.0, 0.5))
    noise = forms.from_rotation_vector(random.normal(scale=1e-3, size=(len(history), 3)))
    wxyz = quaternion.multiply(history.wxyz, noise)
    table = AttitudeTable(history.epoch, history.seconds, wxyz)
    plain = fit(table, sigma=1e-3)
    for loss in ("soft_l1", "huber", "cauchy"):
        found = fit(table, sigma=1e-3, loss=loss, f_scale=1e4)
        # Iterations end within 1e-3 standard errors.
        errors = np.sqrt(np.diag(plain.covariance)[3:6])
        off = found.motion.spin.angular_velocity - plain.motion.spin.angular_velocity
        assert np.all(np.abs(off) < 3e-3 * errors)
        assert np.allclose(found.covariance, plain.covariance, rtol=1e-3, atol=1e-12)


@pytest.mark.parametrize("moments", [(10, 10, 10), (10, 10, 16), (16, 10, 10)])
@pytest.mark.parametrize("axes", ["principal", "free"])
def test_symmetric_and_spherical_bodies(moments, axes):
    given = motion(moments, (0.3, 0.2, 1.0))
    found = fit(AttitudeTable.from_history(given.at(np.arange(0.0, 100.0, 0.4))), axes=axes)
    assert found.rms < 1e-11
    assert np.all(np.isfinite(found.motion.spin.covariance))
    assert apart(found.motion.at(200.0).wxyz, given.at(200.0).wxyz) < 1e-9
    if len({*moments}) == 1 and axes == "free":
        # A sphere turns steadily, as does any body about a principal axis, here of any direction.
        assert np.any(np.isinf(found.covariance.diagonal()[6:]))
        return
    tensor = found.motion.body.tensor / np.trace(found.motion.body.tensor)
    assert np.max(np.abs(tensor - given.body.tensor / np.trace(given.body.tensor))) < 1e-9


def test_a_start_in_place_of_the_first_guess():
    """Records 1.6 turns apart, without rates."""
    given = motion((10, 20, 26), (0.1, 0.15, 1.0))
    table = AttitudeTable.from_history(given.at(np.arange(0.0, 400.0, 9.7)), rates=False)
    near = motion((10, 20.001, 26), (0.1, 0.15, 1.0001))
    found = fit(table, start=near)
    assert found.rms < 1e-10
    assert apart(found.motion.at(1000.0).wxyz, given.at(1000.0).wxyz) < 1e-7


def test_a_fit_does_not_move_away_from_its_start():
    """Four flips of a T-handle; the first records alone leave its shape open."""
    given = motion((10, 20, 26), (0.001, 1.0, 0.001))
    for seed in (1, 2):
        table = noisy(given, np.arange(0.0, 100.0, 0.25), 3e-3, seed)
        found = fit(table, sigma=3e-3, start=given)
        assert excess(found.motion, given, table, 3e-3) < 0.0


# Random bodies and axes of rotation; exact records 2.2 and 2.8 rad apart.
@pytest.mark.parametrize("loss", ["linear", "soft_l1", "huber", "cauchy"])
@pytest.mark.parametrize("step", [2.2, 2.8])
def test_coarse_records_without_rates(loss, step):
    random = np.random.default_rng(3)
    for _ in range(2):
        moments, rates = np.sort(random.uniform(0.5, 1.0, 3)), random.normal(size=3)
        given = motion(moments, rates / np.linalg.norm(rates))
        table = AttitudeTable.from_history(given.at(np.arange(120) * step), rates=False)
        assert fit(table, sigma=1e-3, loss=loss).rms < 1e-10


@pytest.mark.parametrize("rates", [(1e-3, 2e-3, 1e-3), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("sigma", [1.7e-3, None])
def test_dense_noisy_records_of_a_slow_body(rates, known, sigma):
    """The turn between neighbours is 1.4 of their noise, or nothing."""
    given = motion((10, 17, 20), rates)
    history = given.at(np.arange(3000.0))
    random = np.random.default_rng(0)
    for _ in range(3):
        noise = forms.from_rotation_vector(random.normal(scale=1.7e-3, size=(3000, 3)))
        wxyz = quaternion.multiply(history.wxyz, noise)
        table = AttitudeTable(history.epoch, history.seconds, wxyz)
        found = fit(table, given.body if known else None, sigma=sigma)
        assert abs(found.rms / (np.sqrt(3.0) * 1.7e-3) - 1.0) < 0.05


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
@pytest.mark.parametrize("share", [0.0, 0.2])
def test_robust_losses_of_large_noise(loss, share):
    """Noise of 0.01 rad, with no outliers or a fifth."""
    given = motion((10, 20, 26), (0.1, 0.15, 0.5))
    history = given.at(np.arange(150) * 2.0)
    for seed in range(4):
        random = np.random.default_rng(seed)
        noise = random.normal(scale=1e-2, size=(150, 3))
        noise[random.random(150) < share] *= 70.0
        wxyz = quaternion.multiply(history.wxyz, forms.from_rotation_vector(noise))
        table = AttitudeTable(history.epoch, history.seconds, wxyz)
        found = fit(table, sigma=1e-2, loss=loss)
        assert apart(found.motion.at(history.seconds).wxyz, history.wxyz) < 0.05


def test_a_third_of_outliers_without_a_warning():
    given = motion((10, 20, 26), (0.1, 0.3, 1.0))
    history, random = given.at(np.arange(0.0, 60.0, 0.2)), np.random.default_rng(1)
    noise = random.normal(scale=1e-2, size=(300, 3))
    noise[random.random(300) < 0.33] *= 100.0
    wxyz = quaternion.multiply(history.wxyz, forms.from_rotation_vector(noise))
    table = AttitudeTable(history.epoch, history.seconds, wxyz)
    found = fit(table, sigma=1e-2, loss="cauchy")
    assert apart(found.motion.at(history.seconds).wxyz, history.wxyz) < 0.02


@pytest.mark.parametrize("axes", ["principal", "free"])
@pytest.mark.parametrize("rates", [True, False])
def test_a_body_at_rest(axes, rates):
    history = motion((10, 17, 20), (0.0, 0.0, 0.0)).at(np.arange(20.0))
    found = fit(AttitudeTable.from_history(history, rates=rates), axes=axes)
    assert found.rms < 1e-15 and np.linalg.norm(found.motion.spin.angular_velocity) < 1e-15


def test_a_warning_where_no_free_rotation_fits():
    history = motion(*STATES["long axis"]).at(np.arange(100.0))
    turned = quaternion.multiply(
        history.wxyz, forms.from_axis_angle((0, 0, 1), np.arange(100) ** 2)
    )
    table = AttitudeTable(history.epoch, history.seconds, turned)
    with pytest.warns(AttitudeWarning, match="far larger than the errors"):
        fit(table, sigma=1e-3)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda table: fit(5), "AttitudeTable"),
        (lambda table: fit(table, axes="x"), "principal"),
        (lambda table: fit(table, axes=np.eye(3)), "axes is array"),
        (lambda table: fit(table, loss=np.eye(3)), "loss is array"),
        (lambda table: fit(table.history[::-1]), "in the order of time"),
        (lambda table: fit(motion(*STATES["flat"]).at([0.0, np.nan, 2.0])), "not finite"),
        (lambda table: fit(table, body=3), "Body"),
        (lambda table: fit(table, sigma=0.0), "give one number greater than zero"),
        (lambda table: fit(table, sigma=1e-300), "from 1e-100 to 1e.100"),
        (lambda table: fit(table, sigma=np.inf), "0 records; give three or more of finite"),
        (
            lambda table: fit(
                AttitudeTable.from_history(table.history, rates=False),
                sigma=[0.1, 0.1] + 8 * [np.inf],
            ),
            "2 records; give",
        ),
        (lambda table: fit(table.history[:2]), "2 records"),
        (lambda table: fit(table, loss="huber"), "give sigma=, or f_scale="),
        (lambda table: fit(table, loss="l1", sigma=1.0), "must be one of"),
        (lambda table: fit(table, sigma=1.0, loss="huber", f_scale=-1.0), "greater than zero"),
        (lambda table: fit(table, start=table), "give a FreeRotation"),
    ],
)
def test_what_is_refused(call, sentence):
    table = AttitudeTable.from_history(motion(*STATES["long axis"]).at(np.arange(10.0)))
    with pytest.raises(AttitudeError, match=sentence):
        call(table)
