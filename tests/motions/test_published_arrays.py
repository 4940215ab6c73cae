"""Published spin states in arrays: the bits of `Spin.from_periods`, and each bad member named."""

import math

import numpy as np
import pytest
from astropy import units as u

from attitude import AttitudeError, Body, Mode, Spin
from attitude.frames import quaternion
from attitude.motions._published import longest_P_phi
from attitude.published import states_from_periods

NAMES = ("mode", "convention", "P_psi", "P_phi", "pole", "phi0", "psi0", "theta_branch")
ONE = {
    "mode": "SAM",
    "convention": "S",
    "P_psi": 263.0 * 3600,
    "P_phi": 27.38 * 3600,
    "pole": np.radians([250.0, -75.0]),
    "phi0": 0.3,
    "psi0": 0.5,
    "theta_branch": None,
}
APOPHIS = (0.61, 0.965, 1.0)


def drawn(count, seed=1):
    """Moments (N, 3), and the keywords of states in every mode, convention and branch."""
    random = np.random.default_rng(seed)
    x, y, z = random.uniform(0.1, 1.0, (3, count))
    moments = np.stack([y + z, x + z, x + y], axis=1)
    mode, convention = random.choice(["LAM", "SAM"], count), random.choice(["L", "S"], count)
    P_psi = 10.0 ** random.uniform(-3.0, 8.0, count)
    longest = [
        longest_P_phi(np.sort(each), *labels)
        for each, *labels in zip(moments, mode, convention, P_psi, strict=True)
    ]
    librates = (mode == "LAM") == (convention == "S")
    center = np.where(mode == "LAM", 0.5 * math.pi, 0.0) + 0.01
    keywords = {
        "mode": mode,
        "convention": convention,
        "P_psi": P_psi,
        "P_phi": longest * random.uniform(0.3, 0.99, count),
        "pole": np.stack([random.uniform(0, 6, count), random.uniform(-1.5, 1.5, count)], axis=1),
        "phi0": random.uniform(0.0, 6.0, count),
        "psi0": np.where(librates, center, random.uniform(0.0, 6.0, count)),
        "theta_branch": random.choice(["acute", "obtuse"], count),
    }
    return moments, keywords


def test_each_member_has_the_bits_of_spin_from_periods():
    moments, keywords = drawn(300)
    found = states_from_periods(moments, **keywords)
    assert not found.bad.any()
    for k, row in enumerate(moments):
        given = {name: each[k] for name, each in keywords.items()}
        spin = Spin.from_periods(Body(moments=row), epoch="2026-01-01", **given)
        np.testing.assert_array_equal(found.wxyz[k], spin.wxyz)
        np.testing.assert_array_equal(found.angular_velocity[k], spin.angular_velocity)


def test_blocks_and_the_order_of_members_change_no_bit():
    moments, keywords = drawn(50)
    again = np.random.default_rng(2).integers(0, 50, 9000)  # more than one block
    found = states_from_periods(moments, **keywords)
    many = states_from_periods(moments[again], **{n: each[again] for n, each in keywords.items()})
    np.testing.assert_array_equal(many.wxyz, found.wxyz[again])
    np.testing.assert_array_equal(many.angular_velocity, found.angular_velocity[again])


def test_principal_axes_are_those_of_tensors():
    moments, keywords = drawn(30)
    turns = quaternion.matrix(quaternion.unit(np.random.default_rng(3).normal(size=(30, 4))))
    tensors = turns @ (moments[:, :, None] * np.swapaxes(turns, 1, 2))
    bodies = [Body(tensor=0.5 * (each + each.T)) for each in tensors]
    found = states_from_periods(
        np.array([body.moments for body in bodies]),
        principal_axes=np.array([body.principal_axes for body in bodies]),
        **keywords,
    )
    for k, body in enumerate(bodies):
        given = {name: each[k] for name, each in keywords.items()}
        spin = Spin.from_periods(body, epoch="2026-01-01", **given)
        np.testing.assert_array_equal(found.wxyz[k], spin.wxyz)
        np.testing.assert_array_equal(found.angular_velocity[k], spin.angular_velocity)


def test_single_values_serve_all_members():
    body = Body(moments=APOPHIS, relative=True)
    spin = Spin.from_periods(body, epoch="2026-01-01", **ONE)
    phases = np.linspace(0.0, 6.0, 5)
    quantities = {**ONE, "P_psi": 263 * u.h, "pole": [250 * u.deg, -75 * u.deg], "mode": "sam"}
    for moments in (APOPHIS, body, [APOPHIS] * 5):
        found = states_from_periods(moments, **{**quantities, "phi0": phases})
        assert found.wxyz.shape == (5, 4)
        np.testing.assert_allclose(found.angular_velocity, [spin.angular_velocity] * 5, rtol=1e-15)
    alone = states_from_periods(body, **{**ONE, "mode": Mode.SHORT_AXIS})
    np.testing.assert_array_equal(alone.wxyz, [spin.wxyz])
    assert states_from_periods(np.zeros((0, 3)), **ONE).wxyz.shape == (0, 4)


def test_relaxed_rotators_among_tumblers():
    nan = math.nan
    found = states_from_periods(
        [APOPHIS] * 3,
        **{**ONE, "P_psi": [ONE["P_psi"], nan, nan], "P_phi": [ONE["P_phi"], nan, nan]}
        | {"psi0": [0.5, nan, nan], "P": [nan, 3600.0, nan], "mode": ["SAM", "", None]},
        on_error="nan",
    )
    body = Body(moments=APOPHIS)
    given = {name: ONE[name] for name in ("pole", "phi0")}
    spins = [
        Spin.from_periods(body, epoch="2026-01-01", **ONE),
        Spin.from_periods(body, epoch="2026-01-01", P=3600.0, **given),
    ]
    np.testing.assert_array_equal(found.wxyz[:2], [spin.wxyz for spin in spins])
    np.testing.assert_array_equal(
        found.angular_velocity[:2], [spin.angular_velocity for spin in spins]
    )
    assert found.bad.tolist() == [False, False, True] and np.isnan(found.wxyz[2]).all()
    assert found.reason(2).startswith("mode, P_psi, P_phi, psi0 are missing")
    about_z = states_from_periods(None, P=[60.0, 30.0], **given)
    np.testing.assert_allclose(about_z.angular_velocity[:, 2], [math.pi / 30, math.pi / 15])
    np.testing.assert_array_equal(
        about_z.wxyz[0], Spin.from_periods(None, epoch="2026-01-01", P=60.0, **given).wxyz
    )


BAD = {
    "no motion has the periods": ({"P_phi": 60 * 3600.0}, "can be .* at the most"),
    "a period of no sign": ({"P_psi": -1.0}, "P_psi is -1.0; it must be greater than zero"),
    "an unknown mode": ({"mode": "MAM"}, "give \"LAM\""),
    "an unknown convention": ({"convention": "Q"}, "convention is 'Q'"),
    "degrees for radians": ({"phi0": 40.0}, "Plain numbers are radians"),
    "a latitude beyond the pole": ({"pole": (0.0, 2.0)}, "pole latitude is 2 rad"),
    "no number": ({"psi0": math.nan}, "psi0 is missing"),
    "a libration": ({"convention": "L"}, "psi librates in SAM"),
    "a psi out of reach": (
        {"convention": "L", "theta_branch": "acute", "psi0": 1.5},
        "psi librates within",
    ),
    "beside the separatrix": ({"P_psi": 1e9, "P_phi": 1e7}, "near to the separatrix"),
    "no body": ({"moments": (0.1, 0.2, 1.0)}, "exceeds the sum"),
    "a mode that the body lacks": ({"moments": (0.61, 1.0, 1.0)}, "greatest two are equal"),
    "both sorts of periods": ({"P": 10.0}, "leave out mode, convention, P_psi"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_a_bad_member_is_named_and_the_others_keep_their_bits(what):
    changed, sentence = BAD[what]
    good = {"moments": APOPHIS, "P": math.nan, **ONE}
    bad = {**good, **changed}
    members = [good, bad, good]
    given = {name: [each[name] for each in members] for name in good}
    found = states_from_periods(**given, on_error="nan")
    assert found.bad.tolist() == [False, True, False]
    assert found.reason(0) == ""
    expected = states_from_periods(APOPHIS, **ONE)
    np.testing.assert_array_equal(found.wxyz[[0, 2]], [expected.wxyz[0]] * 2)
    assert np.isnan(found.wxyz[1]).all() and np.isnan(found.angular_velocity[1]).all()
    with pytest.raises(AttitudeError, match=f"Member 1 of 3: .*{sentence}"):
        states_from_periods(**given)
    with pytest.raises(AttitudeError, match=f"Member 'b': .*{sentence}"):
        states_from_periods(**given, names=["a", "b", "c"])


def test_shapes_that_do_not_fit():
    with pytest.raises(AttitudeError, match="numbers of members differ"):
        states_from_periods([APOPHIS] * 3, **{**ONE, "phi0": [0.1, 0.2]})
    with pytest.raises(AttitudeError, match="numbers of members differ"):
        states_from_periods([APOPHIS] * 3, **{**ONE, "mode": ["SAM", "LAM"]})
    with pytest.raises(AttitudeError, match="on_error is 'skip'"):
        states_from_periods(APOPHIS, **ONE, on_error="skip")
    with pytest.raises(AttitudeError, match="leave out principal_axes"):
        states_from_periods(Body(moments=APOPHIS), **ONE, principal_axes=np.eye(3))
