"""The contract of motions: a new kind in a page, and what every kind keeps."""

import numpy as np
import pytest

from attitude import AttitudeError, AttitudeTable, Body, FreeRotation, Scene, Spin, epochs, events
from attitude.arcs import Arcs, AxisCrossesDirection, Impulse, InertiaChange
from attitude.formats import aem
from attitude.motions._motion import Motion, RateBounds, motion_of
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque

START = epochs.instant("2026-01-01")
BODY = Body(moments=(1, 2, 2.5))
SPIN = Spin(epoch=START, wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.2, 0.3))
SUN = (1.0, 0.0, 0.0)
OBSERVER = (0.0, 1.0, 0.0)


class Scan(Motion):
    """A telescope that sweeps about z: 0.5 rad to either side, a full sweep in 100 s."""

    epoch, body, smooth = START, BODY, True
    _w = 2.0 * np.pi / 100.0

    def _evaluate(self, seconds, low, order):
        phase = self._w * (seconds if low is None else seconds + low)
        half, zero = 0.25 * np.sin(phase), 0.0 * phase
        wxyz = np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)
        rate = np.stack([zero, zero, 0.5 * self._w * np.cos(phase)], axis=-1)
        bend = np.stack([zero, zero, -0.5 * self._w**2 * np.sin(phase)], axis=-1)
        return [wxyz, rate, bend][: order + 1]

    def rate_bounds(self, seconds):
        w, bend = 0.5 * self._w, 0.5 * self._w**2
        return RateBounds(w, bend + w * w, np.inf)


def test_a_new_kind_of_motion_drives_everything(tmp_path):
    motion = Scan()
    history = motion.at([0.0, 25.0, 100.0])
    assert history.body_to_inertial((1, 0, 0))[1] == pytest.approx([np.cos(0.5), np.sin(0.5), 0])
    assert history.angular_acceleration[1, 2] == pytest.approx(-0.5 * (np.pi / 50) ** 2)
    view = Scene(motion, None, observer=OBSERVER, sun=SUN).at(np.linspace(0.0, 100.0, 5))
    assert view.sun_direction[1] == pytest.approx([np.cos(0.5), -np.sin(0.5), 0.0])
    assert view.aspect_angle == pytest.approx(np.full(5, np.pi / 2))
    lit = events.in_cone(motion, (1, 0, 0), SUN, 0.25)
    times, inside = events.find_discrete(0.0, 100.0, lit)
    crossed = np.arcsin(0.5) * 100 / (2 * np.pi)
    assert times == pytest.approx([crossed, 50 - crossed, 50 + crossed, 100 - crossed], abs=1e-9)
    assert inside.tolist() == [False, True, False, True]
    path = tmp_path / "scan.aem"
    aem.write(
        path, motion, t=np.linspace(0.0, 100.0, 11), object_name="SCAN", object_id="2026-001A"
    )
    assert aem.read(path).at("2026-01-01T00:00:20").wxyz == pytest.approx(motion.at(20.0).wxyz)
    with motion as same:
        assert same is motion
    with pytest.raises(AttributeError, match="does not change"):
        motion.epoch = START
    with pytest.raises(AttitudeError, match="Scan has no regime"):
        _ = motion.regime


TABLE = AttitudeTable.from_history(FreeRotation(BODY, SPIN).at(np.linspace(0.0, 60.0, 241)))
CHANGES = [
    Impulse(at=5.0, angular_momentum=(0.1, 0.2, 0.3)),
    InertiaChange(at=9.0, body=Body(moments=(1, 2.2, 2.5))),
]
KINDS = {
    "free": FreeRotation(BODY, SPIN),
    "arcs": Arcs(BODY, SPIN, CHANGES),
    "torqued": TorquedRotation(BODY, SPIN, ConstantTorque((0.01, 0.02, 0.03)), step=0.01),
    "table": TABLE,
    "scan": Scan(),
}


@pytest.mark.parametrize("motion", KINDS.values(), ids=KINDS)
def test_every_kind_keeps_the_contract(motion):
    assert isinstance(motion, Motion) and motion_of(motion) is motion
    assert motion.epoch == START
    seconds = np.array([[1.0, 2.5, np.nan], [7.0, 20.0, 31.0]])
    history = motion.at(seconds)
    assert history.motion is motion and history.wxyz.shape == (2, 3, 4)
    assert np.isnan(history.wxyz[0, 2]).all() and np.isnan(history.angular_velocity[0, 2]).all()
    known = ~np.isnan(seconds)
    size = np.linalg.norm(history.wxyz[known], axis=-1)
    assert size == pytest.approx(np.ones(5), abs=1e-15)
    rates = motion.angular_velocity_at(seconds)
    assert rates.tobytes() == history.angular_velocity.tobytes()
    bends = motion.angular_acceleration_at(seconds)[known]
    assert bends == pytest.approx(history.angular_acceleration[known], abs=1e-12)
    # each is the derivative of the one before: 1e-4 s, truncation 1e-8, tables 1e-6
    h = 1e-4
    ahead, behind = (motion.at(seconds[known] + d) for d in (h, -h))
    change = (ahead.angular_velocity - behind.angular_velocity) / (2 * h)
    assert change == pytest.approx(bends, abs=1e-5)
    turned = (ahead.body_to_inertial((1, 0, 0)) - behind.body_to_inertial((1, 0, 0))) / (2 * h)
    want = np.cross(
        history.angular_velocity_inertial[known], history.body_to_inertial((1, 0, 0))[known]
    )
    assert turned == pytest.approx(want, abs=1e-6)
    # two doubles of time
    low = motion.at([1e-9 * 0.0 + 3.0], [1e-9])
    assert low.low[0] == 1e-9
    assert motion.has_rates_at(np.array([1.0])) and motion.joints.ndim == 1
    if motion.span is not None:
        assert motion.span[0] == START
    if motion.body is not None:
        momentum = history.body_to_inertial(motion.momentum_in_body(history))[known]
        if motion.momentum is not None:
            assert momentum == pytest.approx(np.tile(motion.momentum, (5, 1)), abs=1e-14)


@pytest.mark.parametrize("name", ["free", "arcs", "scan"])
def test_rate_bounds_hold(name):
    """Bounds of axes between joints, by dense samples."""
    motion = KINDS[name]
    for start in (0.0, *motion.joints):
        end = min([t for t in motion.joints if t > start], default=start + 200.0)
        bounds = motion.rate_bounds(float(start))
        history = motion.at(np.linspace(start, end, 20001)[1:-1])
        speed = np.linalg.norm(history.angular_velocity, axis=-1)
        assert np.max(speed) <= bounds.first
        bend = np.linalg.norm(history.angular_acceleration, axis=-1)
        assert np.max(np.hypot(bend, speed**2)) <= bounds.second
        assert np.max(speed) > 0.9 * bounds.first  # and are no wild guess


@pytest.mark.parametrize("scale", [1e-300, 1e-200, 1.0, 1e300])
def test_rate_bounds_at_any_scale(scale):
    body = Body(moments=np.array([10.0, 20.0, 26.0]) * scale)
    spin = Spin("2026-01-01", (1, 0, 0, 0), np.array([0.1, 0.2, 0.3]))
    usual = FreeRotation(Body(moments=(10, 20, 26)), spin).rate_bounds(0.0)
    assert FreeRotation(body, spin).rate_bounds(0.0) == pytest.approx(usual, rel=1e-14)
    for rates in ((1e199, 2e199, 3e199), (0.0, 0.0, 1e200)):
        fast = FreeRotation(body, Spin("2026-01-01", (1, 0, 0, 0), rates))
        assert fast.rate_bounds(0.0)[1:] == (np.inf, np.inf)
        if rates[0]:
            with pytest.raises(AttitudeError, match="beyond the range of doubles"):
                _ = fast.at(0.0).angular_acceleration


def test_the_inertia_of_arcs():
    motion = KINDS["arcs"]
    with pytest.raises(AttitudeError, match="the long axis follows from a body's inertia"):
        motion.constant_body("the long axis")
    assert motion.body_at(8.0) is motion.body and motion.body_at(9.0) is CHANGES[1].body
    history = motion.at([8.999, 9.0, 30.0])
    momentum = history.body_to_inertial(motion.momentum_in_body(history))
    assert momentum[1:] == pytest.approx(momentum[:-1], abs=1e-15)


def test_a_trigger_is_known_by_its_class():
    class Fake:
        arm = drift = 0.0

        def values(self, history):
            return history.wxyz[..., 0], history.wxyz[..., 1]

    with pytest.raises(AttitudeError, match=r"changes\[0\].at is"):
        Arcs(BODY, SPIN, [Impulse(at=Fake(), angular_momentum=(0, 0, 0.1))])
    when = AxisCrossesDirection((1, 0, 0), (0, 0, 1))
    assert len(Arcs(BODY, SPIN, [Impulse(at=when, angular_momentum=(0, 0, 0.1))]).joints) == 1


class Other:
    """Not of this package: an object with .at(t)."""

    def __init__(self, motion=KINDS["free"]):
        self.motion, self.spin, self.body = motion, motion.spin, motion.body

    def at(self, t, low=None):
        return self.motion.at(t, low=low)


def test_other_objects_with_at():
    """What has .at(t), and an epoch, drives scenes, events and writers as well."""
    foreign = motion_of(Other())
    assert foreign.epoch == START and foreign.body is BODY
    t = np.array([1.0, 2.0])
    assert foreign.at(t).wxyz.tobytes() == KINDS["free"].at(t).wxyz.tobytes()
    assert foreign.angular_acceleration_at(t).shape == (2, 3)
    view = Scene(Other(), None, observer=OBSERVER, sun=SUN).at(t)
    assert view.aspect_angle == pytest.approx(
        Scene(KINDS["free"], None, observer=OBSERVER, sun=SUN).at(t).aspect_angle, abs=1e-14
    )


class Timeless:
    def at(self, t):
        return KINDS["free"].at(t)


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (5, "motion is int; give a FreeRotation"),
        (FreeRotation, "motion is the class FreeRotation; give"),
        (Timeless(), "neither .epoch nor .spin"),
    ],
)
def test_what_is_no_motion(value, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        motion_of(value)
    with pytest.raises(AttitudeError, match=sentence):
        Scene(value, None, observer=OBSERVER, sun=SUN)


def test_a_motion_without_an_evaluation():
    with pytest.raises(NotImplementedError, match="Motion defines no _evaluate"):
        Motion._evaluate(Motion(), np.zeros(1), None, 0)
