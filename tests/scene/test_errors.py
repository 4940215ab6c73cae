"""Standard deviations of a scene's quantities: against samples of the motion, and their limits."""

import numpy as np
import pytest

from attitude import Arcs, AttitudeError, Body, FreeRotation, Impulse, Scene, Spin, shape
from attitude.arcs import InertiaChange
from attitude.motions._table import AttitudeTable
from attitude.scene import View
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque

COUNT = 1500
T = np.array([0.0, 3.0, 11.0])
SUN = (0.3, -0.8, 0.5)
OBSERVER = (-0.5, -0.6, 0.7)
ROOT = np.random.default_rng(4).normal(size=(9, 9)) * 3e-5
SPIN = Spin(
    epoch="2026-01-01",
    wxyz=(1, 2, 3, 4),
    angular_velocity=(0.9, 0.2, 0.1),
    frame="ecliptic",
    covariance=ROOT @ ROOT.T,
)
BODY = Body(tensor=[[11.0, 1.0, 0.5], [1.0, 20.0, -2.0], [0.5, -2.0, 25.0]])
MOTION = FreeRotation(BODY, SPIN)
ELLIPSOID = shape.Ellipsoid((3.0, 2.0, 1.0))
NAMES = tuple(name for name in View.columns() if name.endswith("_sigma"))


def scene_of(motion=MOTION, **settings):
    settings = {"center": "mars barycenter", "light_time": False, "shape": ELLIPSOID, **settings}
    return Scene(motion, **settings)


def fixed(motion=MOTION, shape=ELLIPSOID, **settings):
    return Scene(motion, None, OBSERVER, SUN, shape=shape, **settings)


@pytest.fixture(scope="module")
def samples():
    return MOTION.sample(COUNT, seed=11)


@pytest.mark.parametrize("name", [each for each in NAMES if each != "magnitude_sigma"])
def test_within_the_scatter_of_samples(samples, name):
    view = fixed().at(T)
    found, plain = getattr(view, name), name.removesuffix("_sigma")
    centre = np.asarray(getattr(view, plain))
    each = np.array([getattr(fixed(motion).at(T), plain) for motion in samples]) - centre
    if View.columns()[name].unit == "rad":
        each = (each + np.pi) % (2.0 * np.pi) - np.pi
    scatter = np.sqrt(np.mean(each**2, axis=0))
    assert found.shape == centre.shape
    # Five deviations of the root mean square of COUNT draws.
    assert np.all(np.abs(found - scatter) <= 5.0 * found / np.sqrt(2.0 * COUNT))
    assert name == "phase_angle_sigma" or np.all(found > 1e-6)


def test_magnitudes_of_paths_and_of_directions_have_the_same_errors():
    """The errors are those of the attitude: paths and distances are exact."""
    view = scene_of(ephemeris="builtin").at(T)
    assert np.array_equal(view.magnitude_sigma, view.reduced_magnitude_sigma)
    relative = view.brightness_sigma / view.brightness
    assert np.allclose(view.magnitude_sigma, 2.5 / np.log(10.0) * relative, rtol=1e-14)


def test_facets_of_an_ellipsoid_have_its_errors():
    whole, facets = fixed().at(T), fixed(shape=ELLIPSOID.facets(20000)).at(T)
    assert np.allclose(facets.brightness_sigma, whole.brightness_sigma, rtol=2e-2)


def test_steps_are_no_shorter_than_the_cells_of_shadows():
    """The table of shadows is constant over a cell, where a shorter step would see no change."""
    near, far = (shape.Ellipsoid((1.0, 1.0, 1.0)).facets(500) for _ in range(2))
    corners = np.concatenate([near.vertices, far.vertices + np.array([3.0, 0.0, 0.0])])
    pair = shape.Mesh(corners, np.concatenate([near.facets, far.facets + len(near.vertices)]))
    sigma = np.array([0.3, 0.6, 1.0])
    tiny = FreeRotation(BODY, SPIN.with_covariance({"attitude": 1e-9 * sigma}))
    small = FreeRotation(BODY, SPIN.with_covariance({"attitude": 1e-2 * sigma}))
    one, other = (fixed(each, pair).at(T).brightness_sigma for each in (tiny, small))
    assert np.all(one > 0.0)
    assert np.allclose(one / 1e-9, other / 1e-2, rtol=1e-6)


def test_no_error_is_exactly_none():
    view = fixed(FreeRotation(BODY, SPIN.with_covariance(np.zeros((9, 9))))).at(T)
    for name in NAMES:
        if name != "magnitude_sigma":
            assert not np.any(getattr(view, name)), name


def test_a_phase_angle_has_no_error_even_without_a_motion():
    view = Scene(None, None, OBSERVER, SUN).at(["2026-01-01", "2026-01-02"])
    assert np.array_equal(view.phase_angle_sigma, [0.0, 0.0])


def test_scalar_and_missing_epochs():
    rows, one = fixed().at([3.0, np.nan, 11.0]), fixed().at(3.0)
    for name in NAMES:
        if name in ("magnitude_sigma", "phase_angle_sigma"):
            continue
        found = getattr(rows, name)
        assert np.array_equal(found[0], getattr(one, name)), name
        if "aspect" not in name:
            assert np.all(np.isnan(found[1])) and np.all(np.isfinite(found[[0, 2]])), name


def test_nothing_seen_has_no_magnitude_error():
    body = Body(moments=(1, 2, 2.5))
    still = Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0), covariance={"attitude": 0.1})
    scene = Scene(FreeRotation(body, still), None, (0, 0, 1), (0, 0, -1), shape=ELLIPSOID)
    view = scene.at([0.0])
    assert view.brightness_sigma[0] == 0.0 and np.isnan(view.reduced_magnitude_sigma[0])
    # The observer on an axis: the angle to it has no derivative.
    found = view.observer_axis_angles_sigma[0]
    assert np.isnan(found[2]) and np.allclose(found[:2], 0.1)


def test_columns_of_tables():
    table = fixed().at(T).table("reduced_magnitude", "reduced_magnitude_sigma", "sub_solar_sigma")
    assert table["reduced_magnitude_sigma"].unit == "mag"
    assert table["sub_solar_sigma"].shape == (3, 2)


def test_vectors_of_a_history(samples):
    v = np.array([1.0, -2.0, 3.0])
    history = MOTION.at(T)
    for there in ("body_to_inertial", "inertial_to_body"):
        found = getattr(history, f"{there}_sigma")(v)
        each = np.array([getattr(motion.at(T), there)(v) for motion in samples])
        scatter = np.sqrt(np.mean((each - getattr(history, there)(v)) ** 2, axis=0))
        assert np.all(np.abs(found - scatter) <= 5.0 * found / np.sqrt(2.0 * COUNT))
        rows = getattr(history, f"{there}_sigma")(np.tile(v, (3, 1)))
        assert np.array_equal(rows, found)
        assert np.array_equal(getattr(history[1], f"{there}_sigma")(v), found[1])


def test_the_momentum_has_the_covariance_of_samples(samples):
    each = np.array([motion.momentum for motion in samples]) - MOTION.momentum
    found = MOTION.momentum_covariance
    size = np.sqrt(np.diag(found))
    scatter = np.outer(size, size) * np.sqrt(2.0 / COUNT)
    assert np.all(np.abs(each.T @ each / COUNT - found) < 5.0 * scatter)


@pytest.mark.parametrize(
    "motion",
    [
        Arcs(BODY, SPIN, [Impulse(at=2.0, angular_momentum=(0, 3.0, 9.0))]),
        TorquedRotation(BODY, SPIN, ConstantTorque((0.3, -0.2, 0.3)), step=0.1),
    ],
)
def test_a_momentum_that_changes_has_a_covariance_at_each_epoch(motion):
    """Against half the differences of motions one standard deviation to either side."""

    def values(one):
        history, view = one.at(T), fixed(one).at(T)
        momentum = history.body_to_inertial(history.angular_velocity @ one.body.tensor)
        return np.column_stack([momentum, view.aspect_angle, view.sun_aspect_angle])

    ends = np.array([values(one) for one in motion.sigma_points()])
    half = 0.5 * (ends[::2] - ends[1::2])
    expected = np.einsum("kti,ktj->tij", half, half)
    found = motion.momentum_covariance_at(T)
    assert np.max(np.abs(found - expected[:, :3, :3])) < 1e-6 * np.max(found)
    view = fixed(motion).at(T)
    sigmas = np.stack([view.aspect_angle_sigma, view.sun_aspect_angle_sigma], axis=-1)
    variances = np.diagonal(expected, axis1=1, axis2=2)[:, 3:]
    assert sigmas == pytest.approx(np.sqrt(variances), rel=1e-6)
    with pytest.raises(AttitudeError, match="momentum_covariance_at"):
        motion.momentum_covariance  # noqa: B018
    known = MOTION.momentum_covariance
    assert MOTION.momentum_covariance_at(T) == pytest.approx(np.tile(known, (3, 1, 1)), rel=1e-9)
    with pytest.raises(AttitudeError, match=r"covariance of the angular momentum .* changes"):
        Arcs(BODY, SPIN, [InertiaChange(at=2.0, body=BODY)]).momentum_covariance_at(T)


class Foreign:
    """An object with .at(t), whose histories have a motion without derivatives."""

    epoch, body, momentum = MOTION.epoch, BODY, MOTION.momentum

    def at(self, t, low=None):
        history = MOTION.at(t, low)
        return type(history)(self, history.epoch, history.seconds, history.low, history.wxyz)


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        (FreeRotation(BODY, SPIN.with_covariance(None)), "the spin has no covariance; make it"),
        (AttitudeTable.from_history(MOTION.at(np.arange(20.0))), "AttitudeTable has no derivat"),
        (Foreign(), "Foreign has no (derivatives|covariance)"),
    ],
)
def test_without_a_covariance(motion, message):
    view = fixed(motion).at(T)
    for name in NAMES:
        if name in ("magnitude_sigma", "phase_angle_sigma"):
            continue
        if "ax" in name and motion.body is None:
            continue  # the error of the axes is that there are none
        with pytest.raises(AttitudeError, match=message):
            getattr(view, name)
