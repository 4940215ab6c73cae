"""Bodies, states and orbits that tests of mean rotations share."""

import math

import numpy as np

from attitude import Body, Spin, paths
from attitude.averaged import AveragedHistory, AveragedMotion, _mean_state
from attitude.averaged._polhode import LAM_PLUS, REGIONS, Axes
from attitude.splitting import TorquedRotation

EPOCH = "2026-01-01"
AU = 149597870700.0
# Of the Earth, m3/s2.
GM = 3.986004418e14
DAY = 86400.0
ENVISAT = Body(moments=(17023.0, 124826.0, 129112.0))


def spinning(omega=(0.039, 0.0052, 0.026), wxyz=(0.8, 0.2, 0.4, 0.4)):
    """A state of the epoch; the default rates are those of a short-axis mode of `ENVISAT`."""
    return Spin(epoch=EPOCH, wxyz=wxyz, angular_velocity=omega)


def circle(radius, first=-1e9, last=1e9, slope=0.0):
    """A circular orbit that is known for a span, inclined by an angle in rad."""

    class Circle(paths.Path):
        name, center, source = "satellite", "earth", "a circle"
        span = tuple(spinning().epoch.after(t) for t in (first, last))

        def position(self, instant, seconds, low=None):
            t = np.asarray(seconds) + (instant.seconds - spinning().epoch.seconds)
            angle = math.sqrt(GM / radius**3) * t
            across = math.cos(slope) * np.sin(angle), math.sin(slope) * np.sin(angle)
            return radius * np.stack([np.cos(angle), *across], axis=-1)

    return Circle()


def late_passages(body, torques, count, span=4000.0, seed=2):
    """The passage from LAM+ to SAM+, and seconds (N, 2) by which full motions are early.

    Of a count of motions with random phases and |L| = 1 N m s, those that are in SAM+: against
    their means 20 delays behind the passage, and at span s.
    """
    axes, rng, early = Axes(body), np.random.default_rng(seed), []
    first = axes.nodes(axes.separatrix + 0.3, LAM_PLUS, 16)[3] / axes.moments
    packing, passage = AveragedMotion(body, spinning(first), torques).packing, None
    for _ in range(count):
        # random within many laps, so that each place of the last one is as likely
        x = np.array([0.0, 0.0, 1.0, axes.separatrix + 0.3 + 0.05 * rng.random()])
        start = AveragedHistory(packing, np.array(0.0), x, np.array(LAM_PLUS))
        free = start.free_rotation(phases=tuple(rng.random(2)))
        motion = AveragedMotion(body, free.spin, torques, passages="all", tolerance=1e-9)
        (leaf,) = [one for one in motion.branches(span) if one.regions[-1] == REGIONS[0]]
        (event,) = [event for event in leaf.events if event.kind == "passage"]
        times = [event.seconds + 20.0 * event.delay, span]
        step = 0.3 / np.linalg.norm(free.spin.angular_velocity)
        history = TorquedRotation(body, free.spin, torques, step=step).at(times)
        ends = [
            Spin(motion.epoch.after(t), state.wxyz, state.angular_velocity, frame="icrf")
            for t, state in zip(times, history, strict=True)
        ]
        if any(axes.state(end.angular_velocity)[2] != 0 for end in ends):
            continue
        passage, row = event, []
        for t, end in zip(times, ends, strict=True):
            y = axes.state(end.angular_velocity)[1]
            bend = _mean_state.corrections(axes, body, end, motion.torques, motion.epoch, t)[1]
            state = leaf.at(t)
            rate = packing.rates_of(t, np.append(state.momentum, state.y), 0)[0][3]
            row.append((y - bend - float(state.y)) / rate)
        early.append(row)
    return passage, np.array(early)
