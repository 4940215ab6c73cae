"""The lit share of the Sun's disc against rays: for each, its nearest approach to the occulter."""

import numpy as np
import pytest

from attitude import paths
from attitude._support.constants import ASTRONOMICAL_UNIT_M as AU
from attitude._support.constants import (
    EARTH_FLATTENING,
    EARTH_RADIUS_M,
    SPEED_OF_LIGHT_M_S,
    SUN_RADIUS_M,
)
from attitude.scene import _shadow
from tests.support.scenes import envisat_over_graz


def witness(center_before, radius, flattening, sun, sun_distance, strips=1200, points=151):
    """The free share of the Sun's disc, by rays through strips of the disc.

    center_before: from the body to the occulter's centre, m, some seconds earlier (K,): (3, K).
    """
    sine = SUN_RADIUS_M / sun_distance
    edge = 2.0 * np.sin(0.5 * np.arcsin(sine))
    toward = center_before(np.zeros(1))[:, 0]
    up = np.cross(sun, toward)
    up /= np.linalg.norm(up)
    right = np.cross(up, sun)
    # Strips along the line to the occulter, equally spaced in the angle whose sine is their place.
    angle = (np.arange(strips) + 0.5) / strips * np.pi - 0.5 * np.pi
    y, width = edge * np.sin(angle), edge * np.cos(angle)
    x = width[:, None] * np.linspace(-1.0, 1.0, points)
    y = np.broadcast_to(y[:, None], x.shape)
    # Lambert's projection: chords of the sphere of directions.
    square = x * x + y * y
    z, factor = 1.0 - 0.5 * square, np.sqrt(1.0 - 0.25 * square)
    rays = [(factor * (x * right[k] + y * up[k]) + z * sun[k]).ravel() for k in range(3)]
    clear = nearest(np.array(rays), center_before, radius, flattening).reshape(x.shape) - 1.0
    # The covered part of a step between two rays, by a straight line.
    a, b = clear[:, :-1], clear[:, 1:]
    part = np.where(
        (a < 0.0) & (b < 0.0),
        1.0,
        np.where((a >= 0.0) & (b >= 0.0), 0.0, -np.minimum(a, b) / abs(a - b)),
    )
    covered = part.mean(axis=1) * 2.0 * width
    weight = edge * np.cos(angle) * np.pi / strips
    return 1.0 - covered @ weight / (np.pi * edge**2)


def nearest(rays, center_before, radius, flattening):
    """Least square of the distance from the centre along each ray, over that of the surface."""
    stretch = np.array([[1.0], [1.0], [1.0 / (1.0 - flattening)]])

    def square(s):
        off = s * rays - center_before(s / SPEED_OF_LIGHT_M_S)
        return np.sum((stretch * off) ** 2, axis=0) / radius**2

    s = np.sum(rays * center_before(np.zeros(1)), axis=0)
    h = 0.01 * radius
    for _ in range(4):  # the vertex of a parabola
        before, here, after = square(s - h), square(s), square(s + h)
        s = s + 0.5 * h * (before - after) / (before - 2.0 * here + after)
    return np.where(s > 0.0, square(s), np.inf)


def placed(distance, share, flattening, toward=(0.3, 0.2)):
    """Sun and centre (3,) of an Earth with the Sun's centre `share` of its radius off the limb."""
    sun = np.array([np.cos(toward[0]) * np.cos(toward[1]), np.sin(toward[0]), np.sin(toward[1])])
    sun /= np.linalg.norm(sun)
    side = np.cross(sun, (0.3, -0.7, 0.6))
    side /= np.linalg.norm(side)

    def center(apart):
        return distance * (np.cos(apart) * sun + np.sin(apart) * side)

    inside, outside = 0.0, np.pi
    for _ in range(60):
        middle = 0.5 * (inside + outside)
        at = center(middle)[:, None]
        free = nearest(sun[:, None], lambda s, at=at: at + 0.0 * s, EARTH_RADIUS_M, flattening)
        inside, outside = (inside, middle) if free[0] > 1.0 else (middle, outside)
    return sun, center(inside + share * np.arcsin(SUN_RADIUS_M / AU))


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 0.0), (2e4, -2.2e4, 3e3)])
@pytest.mark.parametrize("share", [-0.8, 0.1, 0.9])
@pytest.mark.parametrize("height", [2e5, 8e5, 3.6e7, 1.37e9])
def test_rays_past_a_moving_flattened_earth(height, share, velocity):
    """From low orbits to that distance at which Earth and Sun look alike."""
    distance = EARTH_RADIUS_M + height
    sun, center = placed(distance, share, EARTH_FLATTENING)
    velocity = np.array(velocity)

    def before(seconds):
        return center[:, None] - velocity[:, None] * seconds

    expected = witness(before, EARTH_RADIUS_M, EARTH_FLATTENING, sun, AU)
    # Where the Earth was when its light left it.
    light = distance / SPEED_OF_LIGHT_M_S
    found = _shadow.lit_fraction(
        before(light),
        EARTH_RADIUS_M,
        sun[:, None],
        np.array([AU]),
        flattening=EARTH_FLATTENING,
        velocity=lambda where: velocity[:, None],
    )
    assert 0.0 < expected < 1.0
    assert abs(found[0] - expected) < 1e-5


def test_a_small_occulter_within_the_disc():
    sun, center = placed(3e9, -0.7, EARTH_FLATTENING)
    found = _shadow.lit_fraction(
        center[:, None], EARTH_RADIUS_M, sun[:, None], np.array([AU]), flattening=EARTH_FLATTENING
    )
    # Strips that touch the bent outline of the occulter: more rays for the same error.
    expected = witness(
        lambda s: center[:, None] + 0.0 * s,
        EARTH_RADIUS_M,
        EARTH_FLATTENING,
        sun,
        AU,
        strips=2000,
        points=601,
    )
    assert 0.5 < found[0] < 0.9
    assert abs(found[0] - expected) < 1e-5


def test_contacts_are_smooth():
    """Near the first and the last contact, slivers narrower than the points of the outline."""
    distance = EARTH_RADIUS_M + 8e5
    for contact, sign in ((1.0, 1.0), (-1.0, -1.0)):
        depth = np.geomspace(1e-6, 1e-2, 30)
        sun, center = zip(
            *(placed(distance, contact - sign * each, 0.0) for each in depth), strict=True
        )
        lit = _shadow.lit_fraction(
            np.array(center).T, EARTH_RADIUS_M, np.array(sun).T, np.full(len(depth), AU)
        )
        covered = 1.0 - lit if sign > 0 else lit
        # A cap of a circle of radius 1 cut off by a line at this depth, to first order.
        cap = 4.0 * np.sqrt(2.0) / 3.0 * depth**1.5 / np.pi
        assert np.all(np.diff(covered) > 0.0)
        assert np.max(np.abs(covered / cap - 1.0)) < 0.01


def test_a_scene_takes_the_light_that_passed_the_limb():
    """With the Earth's place at the epoch of its centre's light, 9e-3 of the disc were missing."""
    scene, _, start = envisat_over_graz()
    coarse = np.arange(0.0, 6000.0, 2.0)
    lit = scene.since(start, coarse).lit_fraction
    middle = coarse[(lit > 0.0) & (lit < 1.0)]
    assert len(middle) > 4
    view = scene.since(start, middle)
    hi, _ = view.emission
    earth = paths.relative("earth", "ssb", scene.ephemeris)
    for k, seconds in enumerate(hi):
        sun = view.sun_direction_icrf[k]
        body = scene.center.position(start, np.array([seconds]))[0]
        now = earth.position(start, np.array([seconds]))[0]

        def before(light, seconds=seconds, body=body, now=now):
            if np.size(light) == 1:
                there = earth.position(start, seconds - np.ravel(light))
            else:  # straight between two epochs
                ends = earth.position(start, seconds - np.array([0.0, 0.1]))
                there = ends[0] + (ends[1] - ends[0]) * (np.asarray(light)[:, None] / 0.1)
            return (there - now - body).T

        expected = witness(before, EARTH_RADIUS_M, EARTH_FLATTENING, sun, view.sun_distance[k])
        assert abs(view.lit_fraction[k] - expected) < 1e-5
