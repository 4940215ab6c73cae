"""A table of records answers like the motion it was taken from, and says where it cannot."""

import copy
import pickle

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin
from attitude.frames import quaternion
from attitude.motions._table import AttitudeTable

SPIN = Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.02, 0.1))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
T = np.arange(0.0, 400.0, 2.0)


def apart(p, q):
    d = quaternion.multiply(quaternion.conjugate(p), q)
    return np.max(2.0 * np.arctan2(np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])))


def table(rates=True, **how):
    return AttitudeTable.from_history(MOTION.at(T), rates=rates, **how)


# Errors of the interpolation at 2 s steps of a 0.1 rad/s tumbler, that is 0.2 rad a step: measured
# within a factor of three of these, and a tenfold loss is a fault.
@pytest.mark.parametrize(
    ("rates", "method", "degree", "angle", "rate"),
    [
        (True, "hermite", 7, 1e-10, 3e-10),
        (True, "hermite", 3, 3e-6, 1e-5),
        (False, "lagrange", 7, 1e-7, 3e-7),
        (True, "lagrange", 7, 1e-7, 3e-7),
        (False, "slerp", 1, 2e-3, 1e-2),
        (True, "slerp", 1, 2e-3, 1e-3),
    ],
)
def test_it_answers_between_records(rates, method, degree, angle, rate):
    found = table(rates, method=method, degree=degree)
    assert (found.method, found.degree) == (method, degree)
    t = np.random.default_rng(1).uniform(T[0], T[-1], 1000)
    true, read = MOTION.at(t), found.at(t)
    assert angle / 100 < apart(true.wxyz, read.wxyz) < angle
    assert np.max(np.abs(true.angular_velocity - read.angular_velocity)) < rate
    inside = read.wxyz[np.argsort(t)]
    assert np.min(np.sum(inside[1:] * inside[:-1], axis=1)) > 0.0  # continuous in sign


def test_acceleration_is_the_derivative_of_the_rates():
    t = 21.3 + 2.8 * np.arange(100)  # never at a record, where pieces meet
    for found in (table(), table(rates=False)):
        ahead, behind = (found.at(t + h).angular_velocity for h in (1e-3, -1e-3))
        # 1e-3 s: truncation 1e-9 rad/s2, rounding 1e-13 of the rates
        assert np.max(np.abs(found.at(t).angular_acceleration - (ahead - behind) / 2e-3)) < 5e-9
    true = MOTION.at(t).angular_acceleration
    assert np.max(np.abs(table().at(t)[5:].angular_acceleration - true[5:])) < 1e-8


def test_at_its_records_it_answers_with_just_those():
    for method in ("hermite", "lagrange", "slerp"):
        found = table(method=method)
        assert np.array_equal(found.at(T).wxyz, MOTION.at(T).wxyz)
        assert np.array_equal(found.at(T).angular_velocity, MOTION.at(T).angular_velocity)
    assert np.array_equal(found.history.wxyz, found.wxyz)
    assert np.array_equal(found.at(MOTION.at(T).time).wxyz.shape, (len(T), 4))


def test_signs_of_the_records_do_not_matter_and_are_kept():
    flips = np.where(np.random.default_rng(2).random(len(T)) < 0.5, -1.0, 1.0)[:, None]
    history = MOTION.at(T)
    mixed = AttitudeTable(history.epoch, T, history.wxyz * flips)
    plain = AttitudeTable(history.epoch, T, history.wxyz)
    assert np.array_equal(mixed.wxyz, history.wxyz * flips)
    assert apart(mixed.at(T[:-1] + 0.7).wxyz, plain.at(T[:-1] + 0.7).wxyz) < 1e-15


def test_outside_of_its_span_and_in_gaps_it_refuses():
    found = table()
    for t in (-1.0, 398.1, np.inf):
        with pytest.raises(AttitudeError, match=r"no attitude at .*2026-01-01T00:00:00 to"):
            found.at([5.0, t])
    assert np.isnan(found.at([np.nan, 1.0]).wxyz[0]).all()
    early, late = AttitudeTable.from_history(MOTION.at(T[:50])), MOTION.at(T[80:])
    both = AttitudeTable.joined([early, AttitudeTable.from_history(late)])
    assert len(both) == 50 + len(T) - 80 and len(both.segments) == 2
    assert apart(both.at([3.0, 300.0]).wxyz, MOTION.at([3.0, 300.0]).wxyz) < 1e-10
    with pytest.raises(AttitudeError, match="no attitude"):
        both.at(130.0)
    used = AttitudeTable(
        SPIN.epoch, T, MOTION.at(T).wxyz, usable=(SPIN.epoch.after(10.0), SPIN.epoch.after(20.0))
    )
    used.at([10.0, 20.0])
    with pytest.raises(AttitudeError):
        used.at(8.0)
    for ends in ((20.0, 10.0), (T[-1] + 1.0, T[-1] + 2.0), (-2.0, -1.0)):
        with pytest.raises(AttitudeError, match="the usable span ends before it begins, or lies"):
            usable = [SPIN.epoch.after(end) for end in ends]
            AttitudeTable(SPIN.epoch, T, MOTION.at(T).wxyz, usable=usable)


def test_segments_with_other_epochs_are_counted_from_the_first():
    later = FreeRotation(
        MOTION.body,
        Spin(
            epoch=SPIN.epoch.after(1000.0),
            wxyz=MOTION.at(1000.0).wxyz,
            angular_velocity=MOTION.at(1000.0).angular_velocity,
        ),
    )
    both = AttitudeTable.joined([table(), AttitudeTable.from_history(later.at(T))])
    assert apart(both.at(1101.0).wxyz, MOTION.at(1101.0).wxyz) < 1e-10
    assert both.seconds[len(T)] == 1000.0
    assert both.span[1] == SPIN.epoch.after(1000.0 + T[-1])


def test_coarse_records_are_refused_between_but_answered_at():
    t = np.arange(0.0, 400.0, 40.0)
    found = AttitudeTable.from_history(MOTION.at(t))
    assert np.array_equal(np.abs(found.at(t).wxyz), np.abs(MOTION.at(t).wxyz))
    with pytest.raises(AttitudeError, match="half a turn apart"):
        found.at(50.0)


def test_shapes_of_t_are_kept_and_a_single_record_holds_still():
    found = table()
    assert found.at(3.0).wxyz.shape == (4,)
    assert found.at(np.ones((2, 3))).wxyz.shape == (2, 3, 4)
    assert found.at(np.ones((2, 3))).angular_velocity.shape == (2, 3, 3)
    assert found.at([]).wxyz.shape == (0, 4)
    one = AttitudeTable("2026-01-01", [5.0], [[1, 0, 0, 0]])
    assert np.array_equal(one.at(5.0).wxyz, (1, 0, 0, 0))
    assert np.array_equal(one.at(5.0).angular_velocity, (0, 0, 0))
    two = AttitudeTable("2026-01-01", [5.0, 6.0], [[1, 0, 0, 0], [0.8, 0, 0, 0.6]])
    assert (two.method, two.degree) == ("lagrange", 1)
    # Hermite of one record would extrapolate from it to the next.
    assert [table(True, degree=degree).degree for degree in (1, 2, 4, 6)] == [3, 3, 3, 5]


def test_nanoseconds_between_records_far_from_the_epoch():
    t, low = np.full(5, 1e9), np.arange(5) * 1e-9
    history = MOTION.at(t, low)
    found = AttitudeTable(history.epoch, t, history.wxyz, low=low)
    assert apart(found.at(1e9, 1.5e-9).wxyz, MOTION.at(1e9, 1.5e-9).wxyz) < 1e-14


LATER = "2026-02-01", "2026-03-01"
WRONG_WAY = "2026-01-01T00:00:01.5", "2026-01-01T00:00:01"


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda q: AttitudeTable("2026-01-01", [0, 2, 1], q), "epoch 2 of t is earlier"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 1], q), "epoch 2 of t is the same"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1], q), "shape"),
        (lambda q: AttitudeTable("2026-01-01", 0.0, q[:1]), "row of epochs"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, np.nan], q), "not finite"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 1e308], q), r"t lies at 1e\+308 s; give 1e"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 1e16], q), r"lie 1 s to 1e\+16 s apart"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q * 1.01), "off 1 by"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q * 0.0), "no attitude"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, method="spline"), "spline"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, degree=2.5), "degree"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, frame="j2000"), "two things"),
        (lambda q: AttitudeTable.joined([]), "no segments"),
        (lambda q: AttitudeTable.joined(3), r"tables\[0\] is 3"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, method=3), "method is 3"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, meta=3), "meta is 3"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, usable=3), "usable is 3"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, usable=(None,) * 3), "a pair of"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, usable=LATER), "outside of the rec"),
        (lambda q: AttitudeTable("2026-01-01", [0, 1, 2], q, usable=WRONG_WAY), "before it begins"),
    ],
)
def test_what_is_refused(make, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        make(np.array([[1.0, 0, 0, 0]] * 3))


def test_it_does_not_change_and_survives_pickling():
    found = table()
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert np.array_equal(other.at(T + 0.0).wxyz, found.at(T).wxyz)
        assert not other.wxyz.flags.writeable
    with pytest.raises(AttributeError):
        found.epoch = None
    with pytest.raises(ValueError):
        found.wxyz[0] = 0.0
    assert "hermite of degree 7" in repr(found)
