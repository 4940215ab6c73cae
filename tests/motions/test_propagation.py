"""The array floor: shapes, memory that is filled in place, and what is refused."""

import math

import numpy as np
import pytest
from astropy import units as u

from attitude import AttitudeError, Body, FreeRotation, Spin, propagate
from attitude.frames import quaternion
from tests.support import states

STATE = ((10.0, 20.0, 26.0), (1.0, 0.0, 0.0, 0.0), (1.0, 15.0, 1.0))
T = np.linspace(-30.0, 60.0, 17)


def _batch(count):
    """moments, wxyz0 and omega0 of some bodies."""
    sample = states.sample(count, families=["tumbling", "separatrix", "sphere"])[::3]
    return [np.array(rows) for rows in zip(*(state[1:] for state in sample), strict=True)]


# ---- shapes ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bodies", "epochs", "result"),
    [
        ((), (), ()),
        ((), (17,), (17,)),
        ((), (0,), (0,)),
        ((), (3, 5), (3, 5)),
        ((4,), (), (4,)),
        ((4,), (17,), (4, 17)),
        ((4,), (4, 17), (4, 17)),
        ((4,), (1, 17), (4, 17)),
        ((2, 3), (5,), (2, 3, 5)),
        ((2, 3), (3, 5), (2, 3, 5)),
        ((2, 1), (3, 5), (2, 3, 5)),
        ((0,), (17,), (0, 17)),
        ((4,), (0,), (4, 0)),
        ((600,), (2,), (600, 2)),  # more than a block of 256
    ],
)
def test_shapes_broadcast(bodies, epochs, result):
    count = math.prod(bodies)
    rows = [row[:count].reshape(*bodies, row.shape[-1]) for row in _batch(max(count, 1))]
    t = np.linspace(0.0, 3.0, math.prod(epochs)).reshape(epochs)
    wxyz, omega = propagate(*rows, t, angular_velocity=True)
    assert wxyz.shape == (*result, 4) and omega.shape == (*result, 3)
    # each entry is what its own body gives at its own epoch
    lead = result[:-1] if epochs else result
    rows = [np.broadcast_to(row, (*lead, row.shape[-1])) for row in rows]
    t = np.broadcast_to(t, result)
    for index in list(np.ndindex(*result))[:: max(1, math.prod(result) // 30)]:
        body = [row[index[:-1] if epochs else index] for row in rows]
        one = propagate(*body, t[index], angular_velocity=True)
        assert np.array_equal(one[0], wxyz[index]) and np.array_equal(one[1], omega[index])


def test_one_number_gives_one_attitude():
    for t in (1.5, np.float64(1.5), np.array(1.5), 1.5 * u.s, "1.5 s"):
        assert propagate(*STATE, t).shape == (4,)
        assert np.array_equal(propagate(*STATE, t), propagate(*STATE, [1.5])[0])


def test_an_own_epoch_for_each_body():
    rows = _batch(9)
    t = np.linspace(0.0, 8.0, 9)
    wxyz = propagate(*rows, t[:, None])[:, 0]
    assert wxyz.shape == (9, 4)
    for k in range(9):
        assert np.array_equal(wxyz[k], propagate(*(row[k] for row in rows), t[k]))


def test_one_body_with_many_rates():
    """moments and wxyz0 of one body broadcast against rates of many."""
    omega0 = np.random.default_rng(1).normal(size=(5, 3))
    wxyz = propagate(STATE[0], STATE[1], omega0, T)
    for k in range(5):
        assert np.array_equal(wxyz[k], propagate(STATE[0], STATE[1], omega0[k], T))


@pytest.mark.parametrize(
    "layout",
    [
        lambda row: np.asfortranarray(row),
        lambda row: np.concatenate([row, row], axis=-1)[..., : row.shape[-1]],
        lambda row: row[::-1][::-1],
        lambda row: row.tolist(),
        lambda row: row.astype(np.float64).copy(),
        lambda row: row.astype(object),
    ],
)
def test_any_layout_of_the_input(layout):
    rows = _batch(6)
    expected = propagate(*rows, T)
    assert np.array_equal(propagate(*map(layout, rows), T), expected)
    for t in (np.repeat(T, 2)[::2], T.astype(object), T.astype(object).tolist()):
        assert np.array_equal(propagate(*rows, t), expected)


def test_the_input_is_left_alone():
    rows = [*_batch(4), np.linspace(0, 5, 6)]
    before = [row.copy() for row in rows]
    for row in rows:
        row.setflags(write=False)
    propagate(*rows, t_low=rows[3], angular_velocity=True)
    assert all(np.array_equal(one, two) for one, two in zip(rows, before, strict=True))


def test_results_are_views_of_component_major_memory():
    wxyz, omega = propagate(*_batch(3), T, angular_velocity=True)
    assert np.moveaxis(wxyz, -1, -2).flags.c_contiguous
    assert np.moveaxis(omega, -1, -2).flags.c_contiguous
    assert wxyz.flags.writeable  # the caller's own


# ---- out= --------------------------------------------------------------------------------------


def _row_major(*shape):
    return np.full(shape, np.nan)


def _component_major(*shape):
    return np.moveaxis(np.full((*shape[:-2], shape[-1], shape[-2]), np.nan), -1, -2)


@pytest.mark.parametrize("make", [_row_major, _component_major])
@pytest.mark.parametrize("count", [None, 5])
def test_out_is_filled_and_returned(make, count):
    rows = STATE if count is None else _batch(count)
    lead = () if count is None else (count,)
    out, rates_out = make(*lead, 17, 4), make(*lead, 17, 3)
    found = propagate(*rows, T, angular_velocity=True, out=out, rates_out=rates_out)
    expected = propagate(*rows, T, angular_velocity=True)
    assert found[0] is out and found[1] is rates_out
    assert np.array_equal(out, expected[0]) and np.array_equal(rates_out, expected[1])


def test_out_may_be_part_of_a_larger_array():
    """Filled, and nothing beside it."""
    large = np.zeros((40, 6))
    propagate(*STATE, T, out=large[3:37:2, 1:5])
    assert np.array_equal(large[3:37:2, 1:5], propagate(*STATE, T))
    large[3:37:2, 1:5] = 0.0
    assert not large.any()


def test_out_for_one_number():
    out, rates_out = np.empty(4), np.empty(3)
    found = propagate(*STATE, 2.0, angular_velocity=True, out=out, rates_out=rates_out)
    assert found[0] is out and found[1] is rates_out
    assert np.array_equal(out, propagate(*STATE, 2.0))
    rows, out = _batch(5), np.empty((5, 4))
    assert propagate(*rows, 2.0, out=out) is out
    assert np.array_equal(out, propagate(*rows, 2.0))


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (np.empty((16, 4)), r"out is an array of shape and type .*must be float64 \(17, 4\)"),
        (np.empty((4, 17)), r"must be float64 \(17, 4\)"),
        (np.empty((17, 4), dtype=np.float32), "must be float64"),
        (np.empty((17, 4), dtype=">f8"), "must be float64"),
        ([[0.0] * 4] * 17, "must be float64"),
        (np.broadcast_to(0.0, (17, 4)), "out is read-only; give an array that can be filled"),
    ],
)
def test_bad_out(out, message):
    with pytest.raises(AttitudeError, match=message):
        propagate(*STATE, T, out=out)


def test_rates_out_wants_rates():
    with pytest.raises(AttitudeError, match="without angular_velocity=True; give both"):
        propagate(*STATE, T, rates_out=np.empty((17, 3)))
    with pytest.raises(AttitudeError, match=r"rates_out is an array .* float64 \(17, 3\)"):
        propagate(*STATE, T, angular_velocity=True, rates_out=np.empty((17, 4)))


# ---- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"moments": (-1, 2, 2)}, r"moments are \(-1, 2, 2\); .* must be finite and not negative"),
        ({"moments": (math.nan, 2, 2)}, r"moments are \(nan, 2, 2\); .* must be finite"),
        ({"moments": (math.inf, 2, 2)}, "must be finite"),
        ({"moments": (0, 0, 0)}, "at most one of them zero"),
        ({"moments": (0, 0, 1)}, "exceeds the sum of the other two"),
        ({"moments": (1, 2, 3.1)}, "no body has a moment of inertia that exceeds the sum"),
        ({"moments": (0, 1, 1)}, "the spin about an axis without inertia is undefined"),
        ({"moments": (1e-46, 1, 1)}, "may differ by a factor of at most 1e45"),
        ({"moments": (1, 2)}, r"moments has shape \(2,\); give \(..., 3\)"),
        ({"moments": 5.0}, r"moments has shape \(\)"),
        ({"moments": "abc"}, "moments is 'abc'"),
        ({"moments": None}, "takes either moments .* or"),
        ({"moments": ((1, 2), (3,))}, "moments is ragged"),
        ({"wxyz0": (0, 0, 0, 0)}, r"wxyz is \(0, 0, 0, 0\); give four finite numbers"),
        ({"wxyz0": (1, 0, math.nan, 0)}, r"wxyz is \(1, 0, nan, 0\)"),
        ({"wxyz0": (math.inf, 0, 0, 0)}, r"wxyz is \(inf, 0, 0, 0\)"),
        ({"wxyz0": (1, 0, 0)}, r"wxyz0 has shape \(3,\); give \(..., 4\)"),
        ({"wxyz0": (1j, 0, 0, 0)}, "give real numbers"),
        ({"omega0": (1, math.nan, 1)}, r"the angular velocity is \(1, nan, 1\) rad/s"),
        ({"omega0": (1, 1, -math.inf)}, "each component must be finite"),
        ({"omega0": (1, 2)}, r"omega0 has shape \(2,\)"),
        ({"omega0": [1, 2, 3] * u.m}, "omega0 is in m; give it in rad/s"),
        ({"t": None}, "t is None; give real numbers in s"),
        ({"t": "soon"}, "t is 'soon'"),
        ({"t": [1, 2] * u.m}, "t is in m; give it in s"),
        ({"t": 1j}, "t is 1j; give real numbers"),
        ({"t": [[1, 2], [3]]}, "t is ragged"),
        ({"t": True}, "t is True"),
        ({"t": np.array([1.0, None])}, "give real numbers in s"),
        ({"t": np.array([1.0, True], dtype=object)}, "give real numbers in s"),
        ({"t": np.array([1.0, 10**400], dtype=object)}, "beyond the range of doubles"),
        ({"t": [1, 10**5000]}, "t is a very large list, beyond the range of doubles"),
        ({"t_low": [1.0, 2.0]}, r"t_low has shape \(2,\), t has \(17,\); give both"),
        ({"t_low": "x"}, "t_low is 'x'"),
        ({"moments": np.ones((5, 3)), "t": np.zeros((4, 17))}, r"do not broadcast .*t\[:, None\]"),
        ({"t": 1e17}, "an epoch lies 1e\\+17 s from that of the state.*Give a nearer epoch"),
        ({"t": [0, -math.inf]}, "inf s from that of the state"),
        ({"t_low": math.inf}, "inf s from that of the state"),
        ({"omega0": (0, 0, 0), "t": math.inf}, "inf s"),
    ],
)
def test_bad_input_is_a_sentence(options, message):
    given = {"moments": STATE[0], "wxyz0": STATE[1], "omega0": STATE[2], "t": T, **options}
    with pytest.raises(AttitudeError, match=message):
        propagate(**given)


@pytest.mark.parametrize("bad", [0, 3, 299])
def test_the_wrong_body_of_a_batch_is_named(bad):
    moments, wxyz0, omega0 = _batch(300)
    moments[bad] = (1, 2, 4)
    with pytest.raises(AttitudeError, match=rf"State {bad} of 300: moments are \(1, 2, 4\)"):
        propagate(moments, wxyz0, omega0, T)


@pytest.mark.parametrize("count", [3, 700])
def test_one_far_epoch_among_many_bodies_is_told(count):
    """With the number of its body, in one block and in several."""
    rows = _batch(count)
    t = np.zeros((count, 2))
    t[count - 1, 1] = 1e25
    sentence = rf"^State {count - 1} of {count}: an epoch lies 1e\+25 s"
    for options in ({}, {"sensitivity": True}, {"threads": 2}):
        with pytest.raises(AttitudeError, match=sentence):
            propagate(*rows, t, **options)


def test_the_body_without_derivatives_is_named():
    """A rod, and an epoch at which the derivatives of a flip exceed the range of doubles."""
    moments = np.array([(10.0, 20.0, 26.0), (0.0, 1.0, 1.0)])
    with pytest.raises(AttitudeError, match=r"^State 1 of 2: moments are \[0.0, 1.0, 1.0\]"):
        propagate(moments, STATE[1], (0.0, 1.0, 0.0), [1.0], sensitivity=True)
    omega = [(1.0, 2.0, 3.0), (0.0, 1.0, 0.0)]
    with pytest.raises(AttitudeError, match=r"^State 1 of 2: .* multiplies errors by e every"):
        propagate(moments[0], STATE[1], omega, [[1e4], [1e4]], sensitivity=True)


def test_an_error_is_a_value_error():
    with pytest.raises(ValueError, match="Check the numbers and their units"):
        propagate((1, 1, 5), *STATE[1:], T)


def test_a_time_to_the_edge_of_the_reach():
    """Just short of 5e16 turns there is an answer, of unit length."""
    t = 4.9e16 * 2 * math.pi / 2.0 * 2
    wxyz = propagate((1.0, 1.0, 1.0), STATE[1], (0.0, 0.0, 2.0), [t, -t])
    assert np.max(np.abs(np.sum(wxyz**2, axis=-1) - 1)) < 1e-15
    with pytest.raises(AttitudeError, match="5e16 turns"):
        propagate((1.0, 1.0, 1.0), STATE[1], (0.0, 0.0, 2.0), [1.05 * t])


def _tensors(count):
    random = np.random.default_rng(17)
    x, y, z = random.uniform(0.1, 1.0, (3, count))
    moments = np.stack([y + z, x + z, x + y], axis=1)
    turns = quaternion.matrix(quaternion.unit(random.normal(size=(count, 4))))
    tensors = turns @ (moments[:, :, None] * np.swapaxes(turns, 1, 2))
    tensors = 0.5 * (tensors + np.swapaxes(tensors, 1, 2))
    tensors[::7] = moments[::7, :, None] * np.eye(3)  # some are diagonal
    return tensors, random.normal(size=(count, 4)), random.normal(size=(count, 3))


def test_tensors_have_the_bits_of_free_rotation():
    tensors, wxyz, omega = _tensors(40)
    wxyz = quaternion.unit(wxyz)
    t = np.array([0.0, 1.0, 1e3, 1e9])
    attitudes, rates = propagate(None, wxyz, omega, t, tensors=tensors, angular_velocity=True)
    for k in range(len(tensors)):
        spin = Spin("2026-01-01", wxyz[k], omega[k])
        if spin.is_rounded:
            continue
        history = FreeRotation(Body(tensor=tensors[k]), spin).at(t)
        np.testing.assert_array_equal(attitudes[k], history.wxyz)
        np.testing.assert_array_equal(rates[k], history.angular_velocity)
    one = propagate(None, wxyz[1], omega[1], t, tensors=tensors[1])
    np.testing.assert_array_equal(one, attitudes[1])


def test_derivatives_of_bodies_given_by_tensors():
    """Those of FreeRotation, through the covariance that belongs to the same nine parameters."""
    tensors, wxyz, omega = _tensors(3)
    wxyz = quaternion.unit(wxyz)
    given = {"attitude": 1e-3, "angular_velocity": 1e-4, "moments": 1e-3}
    t = np.array([1.0, 50.0])
    _, derivatives = propagate(None, wxyz, omega, t, tensors=tensors, sensitivity=True)
    for k in (1, 2):
        motion = FreeRotation(
            Body(tensor=tensors[k]), Spin("2026-01-01", wxyz[k], omega[k], covariance=given)
        )
        covariance = motion.covariance_at(t, rates=False)
        weights = np.array([1e-3] * 3 + [1e-4] * 3 + [1e-3] * 3)
        scaled = derivatives[k] * weights
        np.testing.assert_allclose(
            scaled @ np.swapaxes(scaled, 1, 2), covariance, rtol=1e-9, atol=1e-20
        )


def test_threads_and_blocks_change_no_bit():
    tensors, wxyz, omega = _tensors(70)
    moments = np.linalg.eigvalsh(tensors)
    t = np.linspace(0.0, 1e4, 30000)  # eight bodies in a block
    right = np.array([propagate(m, q, w, t) for m, q, w in zip(moments, wxyz, omega, strict=True)])
    for threads in (1, 2, 3):
        np.testing.assert_array_equal(propagate(moments, wxyz, omega, t, threads=threads), right)
    long = np.linspace(0.0, 1e4, 3 * 2**18 + 5)  # one body in four pieces
    one = propagate(moments[0], wxyz[0], omega[0], long, threads=2)
    np.testing.assert_array_equal(one, propagate(moments[0], wxyz[0], omega[0], long))
    np.testing.assert_array_equal(one[-3:], propagate(moments[0], wxyz[0], omega[0], long[-3:]))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"moments": (1, 2, 2), "tensors": np.eye(3)}, "either moments"),
        ({"moments": None}, "either moments"),
        ({"moments": None, "tensors": [(1, 2, 3)]}, r"give \(..., 3, 3\)"),
        ({"moments": None, "tensors": [[1, 2, 0], [0, 1, 0], [0, 0, 1.0]]}, "symmetric matrices"),
        ({"moments": None, "tensors": np.full((3, 3), np.nan)}, "symmetric matrices"),
        (
            {"moments": None, "tensors": [np.eye(3), [[1, 9, 0], [9, 1, 0], [0, 0, 1]]]},
            "State 1 of 2",
        ),
        ({"moments": (1, 2, 2), "threads": 0}, "threads is 0"),
    ],
)
def test_tensors_and_threads_that_are_refused(arguments, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        propagate(arguments.pop("moments"), (1, 0, 0, 0), (1, 2, 3), [0.0, 1.0], **arguments)


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_rates_of_a_tensor_that_are_no_numbers_are_refused(place, bad):
    """Each component by itself, in Python and in machine code."""
    from attitude._solver.principal_axes import PrincipalAxes

    tensor = np.array([[2.0, 0.1, 0.2], [0.1, 2.5, 0.5], [0.2, 0.5, 2.9]])
    omega = [1.0, 2.0, 3.0]
    omega[place] = bad
    with pytest.raises(AttitudeError, match=f"the angular velocity is .*{bad}"):
        propagate(None, (1, 0, 0, 0), omega, [0.0], tensors=tensor)
    many = np.tile(omega, (40, 1))  # enough for machine code
    rates, differences = PrincipalAxes.of(tensor[None]).over_axes(many)
    np.testing.assert_array_equal(rates[..., 0], many)
    assert np.isnan(differences).all()
