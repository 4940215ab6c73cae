"""Directions to Sun and observer, and states of an ellipsoid, for tests of the inversion."""

import numpy as np

COUNT = 60


def geometry(seed=0, count=COUNT):
    generator = np.random.default_rng(seed)
    t = np.sort(generator.uniform(-0.5, 0.5, count))
    sun = generator.normal(size=(3, count))
    sun /= np.linalg.norm(sun, axis=0)
    observer = sun + 0.7 * generator.normal(size=(3, count))
    return t, sun, observer / np.linalg.norm(observer, axis=0)


def in_plane(generator, count, normal):
    """Unit vectors (3, count) in the plane of a normal."""
    first = np.cross(normal, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first)
    angle = generator.uniform(-0.6, 0.6, count)
    return np.outer(first, np.cos(angle)) + np.outer(np.cross(normal, first), np.sin(angle))


def ellipsoid_state(nutation=14.7, x=0.2):
    generator = np.random.default_rng(1)
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    return np.concatenate([[20.3, nutation, 0.2, -1.0, x], turn.ravel(), [1.1, 0.7]])
