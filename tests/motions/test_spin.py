"""The state at an epoch: every way to give it is the same state, and what is refused."""

import datetime
import inspect
import math
import re

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.spatial.transform import Rotation

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.frames import quaternion

WXYZ = np.array([0.5, -0.1, 0.7, 0.5])
WXYZ = WXYZ / np.linalg.norm(WXYZ)
OMEGA = (0.1, -0.2, 0.3)
GIVEN = {"epoch": "2026-01-01", "angular_velocity": OMEGA}


@pytest.mark.parametrize(
    "spin",
    [
        Spin(wxyz=WXYZ, **GIVEN),
        Spin(wxyz=tuple(3.7 * WXYZ), **GIVEN),
        Spin.from_rotation(rotation=Rotation.from_quat(WXYZ[[1, 2, 3, 0]]), **GIVEN),
        Spin.from_matrix(matrix=Rotation.from_quat(WXYZ[[1, 2, 3, 0]]).as_matrix(), **GIVEN),
        Spin(dcm=Rotation.from_quat(WXYZ[[1, 2, 3, 0]]).as_matrix().T, **GIVEN),
        Spin.from_euler(
            sequence="ZXZ",
            angles=Rotation.from_quat(WXYZ[[1, 2, 3, 0]]).as_euler("ZXZ"),
            **GIVEN,
        ),
        Spin.from_euler(
            sequence="321",
            angles=Rotation.from_quat(WXYZ[[1, 2, 3, 0]]).as_euler("ZYX", degrees=True) * u.deg,
            **GIVEN,
        ),
    ],
)
def test_every_way_to_give_an_attitude(spin):
    """The same to 4e-16, but for the sign, which a matrix does not have."""
    sign = np.sign(spin.wxyz @ WXYZ)
    assert np.max(np.abs(sign * spin.wxyz - WXYZ)) < 4e-16
    assert np.linalg.norm(spin.wxyz) == pytest.approx(1.0, abs=3e-16)


def test_euler_angles_turn_about_body_axes_one_after_the_other():
    """ "ZXZ" and "313": matrix = Rz(a) Rx(b) Rz(c), body to frame."""
    a, b, c = 0.3, 0.5, -0.7

    def about(axis, angle):
        return Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix()

    expected = about(2, a) @ about(0, b) @ about(2, c)
    for sequence in ("ZXZ", "313", 313):
        spin = Spin.from_euler(sequence=sequence, angles=(a, b, c), **GIVEN)
        matrix = Rotation.from_quat(spin.wxyz[[1, 2, 3, 0]]).as_matrix()
        assert np.max(np.abs(matrix - expected)) < 4e-16


@pytest.mark.parametrize(
    "epoch",
    [
        "2026-01-01",
        "2026-01-01T00:00:00",
        "2026-01-01T00:01:09.184 TT",
        Time("2026-01-01", scale="utc"),
        datetime.datetime(2026, 1, 1),
        datetime.datetime(2026, 1, 1, 1, tzinfo=datetime.timezone(datetime.timedelta(hours=1))),
        np.datetime64("2026-01-01"),
    ],
)
def test_every_way_to_give_an_epoch(epoch):
    spin = Spin(epoch=epoch, wxyz=WXYZ, angular_velocity=OMEGA)
    assert spin.epoch.utc_iso == "2026-01-01T00:00:00"
    assert spin.epoch.seconds == pytest.approx(820497669.184, abs=1e-3)  # s, TDB past J2000


@pytest.mark.parametrize(
    "rate",
    [
        np.degrees(OMEGA) * u.deg / u.s,
        np.array(OMEGA) / (2 * np.pi) * 60 * u.cycle / u.min,
        tuple(f"{math.degrees(w) * 86400!r} deg/day" for w in OMEGA),
        np.array(OMEGA) / u.s,
    ],
)
def test_rates_in_any_unit(rate):
    if getattr(rate, "unit", None) == 1 / u.s:
        with pytest.raises(AttitudeError, match="angular_velocity is in 1 / s; give it in rad/s"):
            Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=rate)
        return
    spin = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=rate)
    assert np.allclose(spin.angular_velocity, OMEGA, rtol=4e-16)


def test_frames_lead_to_icrf():
    """The pole of the ecliptic is at 90 deg - 84381.448 arcsec of declination, 270 deg."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=OMEGA, frame="ecliptic")
    pole = Rotation.from_quat(spin.wxyz_icrf[[1, 2, 3, 0]]).as_matrix() @ (0, 0, 1)
    tilt = math.radians(84381.448 / 3600)
    assert np.allclose(pole, (0, -math.sin(tilt), math.cos(tilt)), rtol=0, atol=2e-16)
    assert spin.frame == "ecliptic"
    assert np.array_equal(spin.wxyz, (1, 0, 0, 0))
    for frame in ("icrf", "ICRF", "gcrf"):
        same = Spin(epoch="2026-01-01", wxyz=WXYZ, angular_velocity=OMEGA, frame=frame)
        assert np.allclose(same.wxyz_icrf, WXYZ, rtol=0, atol=2e-16)


def test_a_spin_is_a_value():
    given = WXYZ.copy()
    spin = Spin(epoch="2026-01-01", wxyz=given, angular_velocity=OMEGA)
    given[0] = 0.0
    assert spin.wxyz[0] == pytest.approx(WXYZ[0], rel=1e-15)
    for name in ("wxyz", "angular_velocity", "wxyz_icrf"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(spin, name)[0] = 0.0
    with pytest.raises(AttributeError):
        spin.frame = "ecliptic"


@given(
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: max(map(abs, q)) > 0.1),
    st.integers(-900, 900),
)
def test_the_unit_quaternion_has_31_digits(wxyz, power):
    """That of the doubles given; those of unit length within rounding stay as they are."""
    given_doubles = np.ldexp(wxyz, power)
    spin = Spin(epoch="2026-01-01", wxyz=given_doubles, angular_velocity=OMEGA)
    assert np.array_equal(spin.wxyz, spin.wxyz_as_pairs[:, 0])
    with mp.workdps(60):
        exact = [mpf(float(x)) for x in given_doubles]
        size = mp.norm(exact)
        found = [mpf(float(a)) + mpf(float(b)) for a, b in spin.wxyz_as_pairs]
        off = max(abs(a - b / size) for a, b in zip(found, exact, strict=True))
        kept = abs(size - 1) <= 4.0 * np.finfo(float).eps and np.array_equal(
            spin.wxyz, given_doubles
        )
        assert off < (1e-15 if kept else 1e-31)
    again = Spin(epoch="2026-01-01", wxyz=spin.wxyz, angular_velocity=OMEGA)
    assert np.array_equal(again.wxyz, spin.wxyz)


@pytest.mark.parametrize("frame", ["icrf", "ecliptic"])
def test_a_free_rotation_starts_at_the_unit_quaternion_in_pairs(frame):
    """The second doubles of the unit quaternion are part of its attitudes.

    They are smaller than the rounding of a free rotation: over 2000 attitudes, the share of them in
    the differences from the first doubles is 1 with a standard deviation of 0.04, and 0 if they are
    left out.
    """
    rng = np.random.default_rng(5)
    body = Body(moments=(10, 20, 26))
    shares = np.zeros(2)
    for wxyz in rng.normal(size=(2000, 4)):
        spin = Spin(epoch="2026-01-01", wxyz=wxyz, angular_velocity=(1, 15, 1), frame=frame)
        hi, lo = spin.wxyz_icrf_as_pairs.T
        error = quaternion.multiply(quaternion.conjugate(hi), FreeRotation(body, spin).at(0.0).wxyz)
        left_out = quaternion.multiply(quaternion.conjugate(hi), lo)[1:]
        shares += error[1:] @ left_out, left_out @ left_out
    assert abs(shares[0] / shares[1] - 1.0) < 0.3


# ---- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"wxyz": (0, 0, 0, 0)}, r"wxyz holds \(0, 0, 0, 0\), .* give a quaternion \(w"),
        ({"wxyz": (math.nan, 0, 0, 1)}, "wxyz holds nan; every number in it must be finite"),
        ({"wxyz": (1, 0, 0)}, r"wxyz has shape \(3,\); give \(4\)"),
        ({"wxyz": np.eye(4)}, r"wxyz has shape \(4, 4\)"),
        ({"wxyz": "identity"}, "wxyz is 'identity'"),
        ({"wxyz": [1, 0, 0, 0] * u.m}, "wxyz is in m; it must be a pure number"),
        ({"angular_velocity": (1, 2)}, r"angular_velocity has shape \(2,\); give \(3\)"),
        ({"angular_velocity": (1, 2, math.inf)}, "angular_velocity holds inf"),
        ({"angular_velocity": [1, 2, 3] * u.m}, "in m; give it in rad/s or a unit that converts"),
        ({"angular_velocity": ("1 deg/fortnite",) * 3}, "not a unit that astropy knows"),
        ({"angular_velocity": None}, "Spin is given no rates; give angular_velocity="),
        ({"frame": "b1950"}, "frame is 'b1950'; it must be one of 'icrf', 'gcrf', 'eme2000'"),
        ({"frame": "J2000"}, "means two things"),
        ({"frame": None}, "frame is None"),
        ({"epoch": "2026-13-01"}, "a date that does not exist"),
        ({"epoch": "2026-02-29"}, "a date that does not exist"),
        ({"epoch": "New Year"}, 'cannot be read as a date; write it like "2026-01-01T00:00:00"'),
        ({"epoch": "2026-01-01T25:00:00"}, "hours go from 00 to 23"),
        ({"epoch": "2026-01-01 XYZ"}, "epoch is '2026-01-01 XYZ'"),
        ({"epoch": 2460000.5}, "a length of time; give an epoch"),
        ({"epoch": None}, "epoch is None"),
        ({"epoch": math.nan}, "epoch is nan"),
        ({"epoch": ["2026-01-01", "2026-01-02"]}, r"epoch has shape \(2,\); give one epoch"),
        ({"epoch": np.datetime64("NaT", "s")}, "which is not an epoch"),
    ],
)
def test_bad_input_is_a_sentence(options, message):
    given = {"epoch": "2026-01-01", "wxyz": WXYZ, "angular_velocity": OMEGA, **options}
    with pytest.raises(AttitudeError, match=message):
        Spin(**given)


@pytest.mark.parametrize("frame", ["icrf", "ecliptic"])
def test_dcm_takes_the_frame_to_the_body_and_matrix_the_body_to_the_frame(frame):
    """The long axis z of a body towards x of the frame, as a user writes its unit vectors down."""
    axes = np.array(
        [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    )  # rows: x, y, z of the body
    one = Spin(dcm=axes, frame=frame, **GIVEN)
    other = Spin.from_matrix(matrix=axes.T, frame=frame, **GIVEN)
    assert one == other
    assert quaternion.rotate(one.wxyz, (0, 0, 1)) == pytest.approx([1, 0, 0], abs=1e-15)
    history = FreeRotation(Body(moments=(10, 20, 26)), Spin(dcm=axes, **GIVEN)).at(0.0)
    assert np.max(np.abs(history.dcm - axes)) < 1e-15


def test_one_attitude_is_given():
    for attitude in ({}, {"wxyz": WXYZ, "dcm": np.eye(3)}):
        with pytest.raises(
            AttitudeError, match=r"either wxyz=.*from body axes to the frame, or dcm="
        ):
            Spin(**GIVEN, **attitude)
    with pytest.raises(AttitudeError, match="Spin is given no rates"):
        Spin("2026-01-01", WXYZ)
    with pytest.raises(AttitudeError, match=r"use Spin.from_matrix .body to frame., or give dcm="):
        Spin(matrix=np.eye(3), **GIVEN)


@pytest.mark.parametrize("named", [Body, Spin])
def test_arguments_are_shown(named):
    """By help and by shift-tab, which ask `inspect.signature`."""
    shown = list(inspect.signature(named).parameters)
    assert shown == list(inspect.signature(named.__init__).parameters)[1:] and "self" not in shown
    assert {"moments", "tensor"} <= set(shown) or {"epoch", "wxyz", "dcm"} <= set(shown)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1.0, 1.0, -1.0]), "matrix is a reflection"),
        (-np.eye(3), "matrix is a reflection"),
        (np.eye(3) * 1.001, "matrix is not a rotation.*differs from the unit matrix by 0.002"),
        (np.zeros((3, 3)), "matrix is not a rotation"),
        (np.ones((3, 3)), "Give orthonormal columns"),
        (np.eye(4), r"matrix has shape \(4, 4\); give \(3, 3\)"),
        (np.full((3, 3), math.nan), "matrix holds nan"),
    ],
)
def test_what_is_no_rotation_matrix(matrix, message):
    with pytest.raises(AttitudeError, match=message):
        Spin.from_matrix(matrix=matrix, **GIVEN)
    with pytest.raises(AttitudeError, match=re.sub("^matrix", "dcm", message)):
        Spin(dcm=matrix, **GIVEN)


@pytest.mark.parametrize(
    ("rotation", "message"),
    [
        (np.eye(3), "give a scipy Rotation"),
        (Rotation.from_quat(np.eye(4)), "rotation holds 4 rotations; give one"),
    ],
)
def test_what_is_no_rotation(rotation, message):
    with pytest.raises(AttitudeError, match=message):
        Spin.from_rotation(rotation=rotation, **GIVEN)


@pytest.mark.parametrize(
    ("sequence", "angles", "message"),
    [
        ("ZZX", (1, 2, 3), "sequence is 'ZZX'; give three axes, no two neighbours equal"),
        ("ZX", (1, 2, 3), "give three axes"),
        ("zXZ", (1, 2, 3), "give three axes"),
        ("abc", (1, 2, 3), "give three axes"),
        (3130, (1, 2, 3), "give three axes"),
        (None, (1, 2, 3), "sequence is None"),
        ("ZXZ", (1, 2), r"angles has shape \(2,\); give \(3\)"),
        ("ZXZ", (1, 2, math.nan), "angles holds nan"),
        ("ZXZ", [1, 2, 3] * u.m, "angles is in m; give it in rad"),
    ],
)
def test_bad_euler_angles(sequence, angles, message):
    with pytest.raises(AttitudeError, match=message):
        Spin.from_euler(sequence=sequence, angles=angles, **GIVEN)
