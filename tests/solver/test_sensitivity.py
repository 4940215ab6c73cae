"""Sensitivities against central differences of the 60-digit oracle, in every regime."""

import math

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, propagate
from attitude._solver import sensitivities, short_times
from attitude._solver.states import IDENTITY, States
from attitude.frames import representations as forms
from attitude.frames.quaternion import conjugate, matrix, multiply
from attitude.motions import _propagation
from tests.support.differences import excess, sensitivity, tensor_sensitivity
from tests.support.sensitivity_states import STATES, WXYZ


def _epochs(omega, revolutions):
    return [n * 2.0 * np.pi / (max(map(abs, omega)) or 1.0) for n in revolutions]


def _compare(computed, expected, tolerance, least=1e-20):
    for j in range(9):
        size = np.abs(expected[:, :, j]).max(axis=1)
        size[size < least] = 1.0  # zero in exact arithmetic
        error = np.abs(computed[:, :, j] - expected[:, :, j]).max(axis=1)
        assert np.all(error <= tolerance * size), (j, error / size)


@pytest.mark.parametrize("name", STATES)
def test_against_differences_of_the_oracle(name):
    moments, omega, tolerance = STATES[name]
    times = _epochs(omega, (1.3, 1e3 + 0.3, 1e6 + 0.7))
    found = propagate(moments, WXYZ, omega, times, angular_velocity=True, sensitivity=True)
    attitude, rates = sensitivity(moments, WXYZ, omega, times)
    _compare(found[2], attitude, tolerance)
    _compare(found[3], rates, 2.0 * tolerance)


@pytest.mark.parametrize(
    "name",
    [
        *("middle axis, 1e-8", "short-axis mode", "needle of 1e-5", "sphere", "short axis"),
        *("equator of a symmetric body", "long axis", "lamina", "at rest"),
        *("needle about its length, 1e-2", "needle about its length, 1e-6"),
    ],
)
def test_beside_the_epoch(name):
    """Columns of the moments begin with t^2, and are right where they are small."""
    moments, omega, tolerance = STATES[name]
    times = [-0.3, 1e-12, 1e-6, 1e-2, 0.1, 0.5, 1.0, 2.0]
    found = propagate(moments, WXYZ, omega, times, angular_velocity=True, sensitivity=True)
    attitude, rates = sensitivity(moments, WXYZ, omega, times)
    _compare(found[2], attitude, tolerance, 1e-50)
    _compare(found[3], rates, 2.0 * tolerance, 1e-50)


@pytest.mark.parametrize("omega", [(0.3, 0.5, 1.0), (0.0, 0.0, 1.0)])
def test_covariances_beside_the_epoch(omega):
    """They add the columns, those of uniform rotations too, of a sphere and of a needle."""
    moments = (2.0, 2.0, 2.0) if omega[0] else (1.0, 1.005, 1e-2)
    sigma = 1e-3 * np.array([0, 0, 0, 1, 2, 3, 4, 5, 6])
    body, wxyz = Body(moments=moments, relative=True), (1.0, 0.0, 0.0, 0.0)
    spin = Spin("2026-01-01", wxyz, omega, covariance=np.diag(sigma**2))
    times = [1e-7, 1e-3, 0.4, 40.0]
    columns = np.concatenate(sensitivity(moments, wxyz, omega, times), axis=1) * sigma
    expected = columns @ np.swapaxes(columns, 1, 2)
    size = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
    scale = np.maximum(size[:, :, None] * size[:, None, :], 1e-60)
    found = FreeRotation(body, spin).covariance_at(times)
    assert np.abs((found - expected) / scale).max() < 1e-14


def test_a_needle_about_its_length_does_not_notice_its_moments():
    """Their columns are zero, not rounding of the angular momentum over a small moment."""
    found = propagate((1, 1.00005, 1e-4), WXYZ, (0, 0, 1.0), [2.0, 900.0], sensitivity=True)[1]
    assert np.abs(found[:, :, 6:]).max() <= 1e-30


@pytest.mark.parametrize(
    ("moments", "omega"),
    [
        pytest.param((1.0, 0.999999978, 1e-6), (-0.12, -0.43, 696116.0), marks=pytest.mark.slow),
        ((0.0001, 1.0, 0.9999464513912483), (-7770.963891075163, 1.4356907, 0.33)),
        ((1.0, 0.9999371109563242, 0.0001), (3.6e-5, 8.4e-7, 1.0)),
        ((1.0, 1.0, 1e-4), (3e-3, 2e-4, 1.0)),
        ((1.0, 1.01, 0.02), (0.03, 0.02, 1.0)),
        pytest.param((1.0, 1.00000000005, 1e-10), (3e-10, 2e-11, 1.0), marks=pytest.mark.slow),
    ],
)
def test_a_needle_that_precesses_slowly(moments, omega):
    """Early in the precession columns are as small as its angle, those of I3 as its square."""
    revolution = 2.0 * math.pi / max(map(abs, omega))
    times = [r * revolution for r in (0.2, 1.3, -2.3, 30.7, -50.3, 1e3)]
    assert excess(moments, WXYZ, omega, times) <= 1.0


@pytest.mark.parametrize(
    ("moments", "omega", "span"),
    [
        # 3 % from the separatrix: terms are 70 times as large as the columns
        ((1.2616243, 0.8247285, 0.9833716), (0.5075468, 0.8498101, 0.6048531), 1.03),
        ((1.2764472, 1.1038615, 1.5731732), (0.9829519, -0.5418541, 0.3273753), 1.21),
        # nearly symmetric: the columns have poles of third order
        ((0.5659525, 0.5581523, 0.7634777), (0.432654, -2.5971375, 0.9973608), 1.57),
    ],
)
def test_while_terms_cancel(moments, omega, span):
    """Until the terms of a column no longer cancel, series follow one another."""
    times = [span * share for share in (-2.9, -2.1, -1.52, -0.99, 0.9, 1.1, 1.7, 3.3, 5.1, 7.3)]
    assert excess(moments, WXYZ, omega, times) <= 1.0


@pytest.mark.parametrize("times", [[0.3, 0.9], [-0.2, -1.0], [-1.0, 0.02], [-0.02, 0.9]])
def test_series_on_the_side_of_the_epochs(times):
    """As many series as the epochs need on each side: the same bits as with all."""
    given = (10, 20, 26), WXYZ, (1, 15, 1)
    every = propagate(*given, [*times, -1.0, 1.0], angular_velocity=True, sensitivity=True)
    some = propagate(*given, times, angular_velocity=True, sensitivity=True)
    for one, other in zip(every, some, strict=True):
        assert one[: len(times)].tobytes() == other.tobytes()


def test_a_product_of_series_in_python():
    random = np.random.default_rng(35)
    a, b = random.normal(size=(2, 3 * short_times.TERMS))
    for n in range(short_times.TERMS):
        given = a, b, n % 3, (n + 1) % 3, n
        assert short_times._product(*given) == short_times._product.py_func(*given)


def test_series_in_python_and_in_vectors_have_the_same_bits():
    """A tumbler, a flip and a needle, with spans to both sides."""
    moments = np.array([(1.0, 2.0, 2.6), (1.0, 2.0, 2.6), (1e-3, 1.0, 1.0 + 1e-9)])
    omega = np.array([(0.3, -0.2, 0.5), (1e-9, 1.0, 1e-9), (5.0, 1e-3, -2e-3)])
    wxyz = np.array([(0.5, -0.5, 0.5, 0.5)] * 3)
    prepared = States(moments, IDENTITY, omega, None, wxyz).solved()
    tangents = sensitivities.tangents_of(
        prepared.moments, prepared.wxyz, prepared.principal, prepared.constants
    )
    span, spans = np.empty(3), np.array([(3, 2), (1, 4), (2, 2)])
    short_times.spans_of(prepared.constants, span)
    assert np.all(span > 0.0)
    records = []
    of_motions = prepared.constants.view(np.recarray), tangents.view(np.recarray), np.arange(3)
    for setup in (short_times.short_setup.dispatcher, short_times.short_setup.uncompiled):
        records.append(np.zeros(3 + int(np.sum(spans - 1)), short_times.SHORT).view(np.recarray))
        setup(*of_motions, span, spans, records[-1])
    assert np.max(np.abs(records[0]["series"])) > 0.1
    for name in short_times.SHORT.names:
        assert np.array_equal(records[0][name], records[1][name]), name


@pytest.mark.parametrize(
    ("moments", "omega", "times"),
    [
        # by the difference of momenta 4.5e-15 after a radian, 6.7e-15 after 0.8: by series instead
        ((1.3753889, 0.7811148, 1.3828242), (-0.3516171, -2.3125816, -0.1888972), (0.4, 0.6, 0.84)),
        ((20.0, 26.0, 10.0), (0.2, 0.78848, 1.0), (0.628, -0.9, 1.5)),
        # a remainder of 5.9e-15 where a series reached 0.22 of its radius of convergence
        ((0.0990902, 0.84144, 0.8362154), (0.2447005, 1.0, -0.220797), (1.2, 1.55, -1.75)),
        # 4.3e-15 by the quaternion of the solution at the epoch, whose norm errs by 7e-16
        (
            (0.5745821793631019, 0.4861089183925399, 0.5742186486512748),
            (-1.2355844544689116, -1.7763653849182433, -0.3351965739266949),
            (0.137, -0.316, 0.69),
        ),
    ],
)
def test_within_two_radians(moments, omega, times):
    """Series of the change of attitude: a few roundings."""
    for wxyz in (WXYZ, (0.4, -0.2, 0.8, 0.3)):
        assert excess(moments, wxyz, omega, list(times)) <= 0.4


def test_errors_of_a_flip():
    """Errors of the middle moment alone: right from the first second to the first turning over."""
    spin = Spin("2026-01-01", (1, 0, 0, 0), (math.sin(math.pi), 1, 0),
                covariance={"moments": (0, 0.01, 0)})  # fmt: skip
    times = [1.0, 10.0, 20.0, 70.0, 80.0]
    found = FreeRotation(Body(moments=(1, 2, 2.6)), spin).at(times).sigma
    by_moment = sensitivity((1, 2, 2.6), (1, 0, 0, 0), (math.sin(math.pi), 1, 0), times)[0][..., 7]
    expected = 0.01 * np.abs(by_moment)
    size = expected.max(axis=1)
    assert np.all(np.abs(found - expected).max(axis=1) <= 4e-15 * size)
    assert size[2] < 2.6e-14 and size[4] > 1e-3  # rad


def test_a_tensor_spun_about_its_middle_axis():
    """Its axes and moments are irrational: rounding moves the spin by 1e-17 from the axis."""
    axes = matrix(forms.from_rotation_vector(np.array([0.3, -0.5, 0.8])))
    tensor = axes @ np.diag([1.0, 2.0, 2.6]) @ axes.T
    tensor = 0.5 * (tensor + tensor.T)
    omega, times = axes[:, 1], [0.5, 3.0, 20.0, 90.0]
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=omega)
    found = FreeRotation(Body(tensor=tensor), spin).sensitivity_at(times)
    _compare(found, tensor_sensitivity(tensor, omega, times), 4e-15)


def test_series_of_short_times_of_nearly_symmetric_bodies():
    moments, omega = (
        (0.7142232756, 1.1189726819, 0.7142237898),
        (-2.0781687, -1.7430382, -1.1886594),
    )
    times = [0.36, 0.72, 0.74, 1.0, 1.25]  # s, of which the series serve up to 0.73
    found = propagate(moments, WXYZ, omega, times, sensitivity=True)[1]
    _compare(found, sensitivity(moments, WXYZ, omega, times)[0], 4e-15)


@pytest.mark.parametrize("omega", [(0.3, 0.2, 1.0), (1e-5, 1.0, 1e-6), (0.0, 0.0, 1.0)])
@pytest.mark.parametrize(("inertia", "tempo"), [(600, 0), (-600, 0), (-400, -290), (500, 290)])
def test_units_change_no_digit(omega, inertia, tempo):
    """Squares of the momentum are no doubles, its derivatives are: the same bits in all units."""
    t, moments = np.array([0.1, 3.0, 40.0]), np.array([1.0, 2.0, 2.7])
    right = propagate(moments, WXYZ, omega, t, angular_velocity=True, sensitivity=True)[2:]
    size, rate = 2.0**inertia, 2.0**tempo
    given = size * moments, WXYZ, rate * np.array(omega), t / rate
    found = propagate(*given, angular_velocity=True, sensitivity=True)[2:]
    for ours, scaled, unit in zip(right, found, (1.0, rate), strict=True):
        assert np.array_equal(ours[..., 3:6], scaled[..., 3:6] * rate / unit)
        assert np.array_equal(ours[..., 6:], scaled[..., 6:] * size / unit)


def test_the_middle_axis_grows_as_it_should():
    moments, omega = (1, 2, 2.7), (0, 1.0, 0)
    times = [1.0, 10.0, 30.0]
    found = propagate(moments, WXYZ, omega, times, sensitivity=True)[1]
    _compare(found, sensitivity(moments, WXYZ, omega, times)[0], 4e-14)
    with pytest.raises(AttitudeError, match="unstable"):
        propagate(moments, WXYZ, omega, [1e4], sensitivity=True)


def test_on_the_exact_separatrix():
    """One passage, which does not return: derivatives grow by e with 1/wp, and stay right."""
    moments, omega = (1, 2, 2.25), (0.75, 1.0, 1.0)
    times = [0.1, 1.0, 5.0, 20.0]
    found = propagate(moments, WXYZ, omega, times, angular_velocity=True, sensitivity=True)
    attitude, rates = sensitivity(moments, WXYZ, omega, times)
    for one, other in ((found[2], attitude), (found[3], rates)):
        scale = np.abs(other).max(axis=(1, 2))
        assert np.all(np.abs(one - other).max(axis=(1, 2)) < 1e-14 * scale)


def test_all_forms_agree_where_they_meet():
    """A motion next to a uniform one, or next to another form, has nearly the same derivatives."""
    times = np.linspace(0.0, 20.0, 9)
    for moments, omega, change in (
        ((1, 2, 2.7), (0, 0, 1.0), (1e-9, 0, 0)),
        ((2, 2, 3), (0.3, 0.5, 0), (0, 0, 1e-9)),
        ((1, 2, 2.7), (0, 0, 0), (1e-9, 0, 0)),
    ):
        other = np.add(omega, change)
        one = propagate(moments, WXYZ, omega, times, sensitivity=True)[1]
        two = propagate(moments, WXYZ, other, times, sensitivity=True)[1]
        assert np.abs(one - two).max() < 1e-6 * np.abs(one).max()


def test_a_tensor_and_another_frame():
    rotation = forms.from_rotation_vector(np.array([0.3, -0.5, 0.8]))
    axes = matrix(rotation)
    tensor = axes @ np.diag([2.0, 3.0, 4.5]) @ axes.T
    body = Body(tensor=0.5 * (tensor + tensor.T))
    spin = Spin(
        epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.2, 1.0, 0.3), frame="ecliptic"
    )
    motion = FreeRotation(body, spin)
    t = 12.5
    found, rates = motion.sensitivity_at(t, angular_velocity=True)
    for j in range(9):
        step = 1e-5
        sides = [motion.changed(sign * step * np.eye(9)[j]).at(t) for sign in (1, -1)]
        turn = multiply(sides[0].wxyz, conjugate(sides[1].wxyz))
        numeric = forms.to_rotation_vector(turn) / (2 * step)
        assert np.abs(found[:, j] - numeric).max() < 1e-7 * np.abs(found).max()
        numeric = (sides[0].angular_velocity - sides[1].angular_velocity) / (2 * step)
        assert np.abs(rates[:, j] - numeric).max() < 1e-7 * np.abs(found).max()


def test_body_axes():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.2, 1.0, 0.3))
    motion = FreeRotation(Body(moments=(2, 3, 4.5)), spin)
    inertial, body = (motion.sensitivity_at([0.0, 3.0], axes=axes) for axes in ("inertial", "body"))
    assert np.allclose(body[0, :, :3], np.eye(3), atol=1e-15)
    history = motion.at([0.0, 3.0])
    assert np.allclose(history.matrix[1] @ body[1, :, 3:], inertial[1, :, 3:], atol=1e-13)
    back = history.matrix[1] @ body[1, :, :3] @ history.matrix[0].T
    assert np.allclose(back, inertial[1, :, :3], atol=1e-13)


def test_shapes_blocks_and_memory():
    moments = np.array([[10, 20, 26], [1, 2, 2.7], [2, 2, 2.0]])
    omega = np.array([[1, 15, 1], [0, 0, 1.0], [1, 2, 3]])
    t = np.linspace(-5.0, 5.0, 777)
    wxyz, found = propagate(moments, WXYZ, omega, t, sensitivity=True)
    assert found.shape == (3, 777, 3, 9)
    for b in range(3):
        one, alone = propagate(moments[b], WXYZ, omega[b], t, sensitivity=True)
        assert np.array_equal(one, wxyz[b])
        assert np.array_equal(alone, found[b])
        for k in (0, 300, 776):  # the same bits whatever the block
            assert np.array_equal(
                propagate(moments[b], WXYZ, omega[b], t[k], sensitivity=True)[1], found[b, k]
            )
    out = np.empty((3, 777, 3, 9))
    assert propagate(moments, WXYZ, omega, t, sensitivity=True, sensitivity_out=out)[1] is out
    assert np.array_equal(out, found)
    with pytest.raises(AttitudeError, match="sensitivity_out"):
        propagate(moments, WXYZ, omega, t, sensitivity_out=out)
    with pytest.raises(AttitudeError, match="rod"):
        propagate((0, 1, 1), WXYZ, (0, 1, 1), t, sensitivity=True)
    gap = propagate(moments, WXYZ, omega, [1.0, np.nan], sensitivity=True)[1]
    assert np.isnan(gap[:, 1]).all() and np.isfinite(gap[:, 0]).all()


@pytest.mark.parametrize("count", [20001, 20005, 30000])
@pytest.mark.parametrize("omega", [(1.0, 15.0, 1.0), (1.0, 1.0, 15.0)])
def test_large_results_have_the_bits_of_small_ones(count, omega):
    """Results beyond 4 MB are stored past the caches, in whole lines of them."""
    moments, t = (10.0, 20.0, 26.0), np.linspace(-40.0, 900.0, count)
    t[1234] = np.nan
    memory = np.full(27 * count + 16, 7.0)
    for shift in (0, 3):
        out = memory[shift : shift + 27 * count].reshape(3, 9, count).transpose(2, 0, 1)
        assert propagate(moments, WXYZ, omega, t, sensitivity=True, sensitivity_out=out)[1] is out
        for first in range(0, count, 4000):
            part = t[first : first + 4000]
            alone = propagate(moments, WXYZ, omega, part, sensitivity=True)[1]
            assert np.array_equal(alone, out[first : first + 4000], equal_nan=True)
    both = {"sensitivity": True, "angular_velocity": True}
    rates = propagate(moments, WXYZ, omega, t, **both)[-1]
    for first in range(0, count, 4000):
        alone = propagate(moments, WXYZ, omega, t[first : first + 4000], **both)[-1]
        assert np.array_equal(alone, rates[first : first + 4000], equal_nan=True)
    assert np.all(memory[27 * count + 3 :] == 7.0)  # nothing is stored beyond the result


def test_the_epoch_is_exact():
    for moments, omega, _ in STATES.values():
        found = propagate(moments, WXYZ, omega, 0.0, sensitivity=True)[1]
        expected = np.zeros((3, 9))
        expected[:, :3] = np.eye(3)
        assert np.abs(found - expected).max() <= 1e-30


def test_a_second_double_of_the_epoch():
    moments, omega = (10, 20, 26), (1, 15, 1)
    t, low = 1e9, 3e-8
    whole = propagate(moments, WXYZ, omega, t, t_low=low, sensitivity=True)[1]
    swapped = propagate(moments, WXYZ, omega, low, t_low=t, sensitivity=True)[1]
    assert np.array_equal(whole, swapped)
    assert np.any(whole != propagate(moments, WXYZ, omega, t, sensitivity=True)[1])


def test_a_body_at_rest_has_no_series():
    """At its epoch too: its rates change the attitude by their time alone."""
    times = [0.0, 1.0, -10.0]
    found = propagate(
        (1, 2, 3), (1, 0, 0, 0), (0, 0, 0), times, angular_velocity=True, sensitivity=True
    )
    expected = np.zeros((3, 3, 9))
    expected[:, :, :3] = np.eye(3)
    expected[:, :, 3:6] = np.array(times)[:, None, None] * np.eye(3)
    assert np.array_equal(found[2], expected)
    assert np.array_equal(found[3][..., 3:6], np.broadcast_to(np.eye(3), (3, 3, 3)))


@pytest.mark.parametrize("wobble", [0.3, 1e-2, 1e-5, 1e-8, 1e-11])
def test_derivatives_for_least_squares(wobble):
    """Within 4e-12 of the largest entries of exact ones, at any wobble about the middle axis."""
    omega = np.array([(wobble, 1.0, 0.5 * wobble), (1.0, wobble, wobble)])
    t = np.linspace(-30.0, 40.0, 71)
    given = (1.0, 2.0, 2.6), np.array([(0.5, -0.5, 0.5, 0.5)] * 2), omega, t
    exact = propagate(*given, angular_velocity=True, sensitivity=True)
    close = _propagation.linearized(*given, angular_velocity=True)
    for want, found in zip(exact, close, strict=True):
        size = np.abs(want).max(axis=(1, 2), keepdims=True)
        assert np.max(np.abs(found - want) / np.maximum(size, 1e-300)) < 4e-12


def test_least_squares_takes_series_only_where_terms_cancel(monkeypatch):
    """Epochs next to that of the state have series otherwise, which take most of the time."""
    spans = []
    setup = short_times.short_setup
    monkeypatch.setattr(
        short_times,
        "short_setup",
        lambda *call: (spans.append(len(call[-1])), setup(*call)),
    )
    moments, wxyz, t = (1.0, 2.0, 2.6), np.array([(0.5, -0.5, 0.5, 0.5)]), np.array([0.0, 0.1, 3.0])
    propagate(moments, wxyz, [(1.0, 0.3, 0.2)], t, sensitivity=True)
    assert len(spans) == 1
    _propagation.linearized(moments, wxyz, np.array([(1.0, 0.3, 0.2)]), t)
    assert len(spans) == 1
    _propagation.linearized(moments, wxyz, np.array([(1e-8, 1.0, 1e-8)]), t)
    assert len(spans) == 2
