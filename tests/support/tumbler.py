"""A tumbling ellipsoid, the directions in which it is seen, and a start beside its state."""

import numpy as np

from attitude import Body, FreeRotation, Spin
from attitude.shape import Ellipsoid

DAY = 86400.0
AXES = np.array([1.0, 0.7, 0.5])
MOMENTS = (AXES**2).sum() - AXES**2
MOMENTS /= MOMENTS.max()
RATES = 2.0 * np.pi / (0.5 * DAY) * np.array([0.5, 0.3, 0.8])
BODY = Body(moments=MOMENTS, relative=True)
SPIN = Spin("2026-01-01", (0.3, 0.2, -0.4, 0.8), RATES)
SHAPE = Ellipsoid(AXES)


def directions(seconds):
    a, b = np.radians(3.0 * seconds / DAY), np.radians(20.0 + 5.0 * seconds / DAY)
    sun = np.stack([np.cos(a), np.sin(a), 0.1 + 0.0 * a], axis=-1)
    observer = np.stack([np.cos(b), np.sin(b), 0.3 + 0.0 * b], axis=-1)
    return [each / np.linalg.norm(each, axis=1)[:, None] for each in (sun, observer)]


def start_beside(turn=0.05, rate=0.004):
    generator = np.random.default_rng(1)
    wxyz = np.array(SPIN.wxyz) + turn * generator.normal(size=4)
    rates = RATES * (1.0 + rate * generator.normal(size=3))
    return FreeRotation(
        Body(moments=MOMENTS * [1.02, 0.99, 1.0], relative=True), Spin("2026-01-01", wxyz, rates)
    )
