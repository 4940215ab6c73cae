"""Light curves of rotators over several apparitions, and how their solutions are judged."""

from __future__ import annotations

import math

import numpy as np
from astropy import units
from astropy.time import Time

from attitude import inversion
from attitude.frames import matrix_to_icrf
from attitude.inversion import _pole_map
from attitude.inversion._ellipsoid import SearchState
from tests.support import synthetic_curves

_HOURS = 3600.0


def rotator(seed: int) -> tuple[inversion.LightCurve, float, np.ndarray]:
    """A light curve of 25 years, the period (h) and the pole (ecliptic axes)."""
    rng = np.random.default_rng(seed)
    _, normals, areas = synthetic_curves.hull(rng)
    period = math.exp(rng.uniform(math.log(2.6), math.log(20.0)))
    pole = rng.normal(size=3)
    pole /= np.linalg.norm(pole)
    a = rng.uniform(2.1, 2.8)
    body = (a, rng.uniform(0.05, 0.2), math.radians(rng.uniform(2, 15)))
    body += (*rng.uniform(0.0, 2.0 * math.pi, 3), synthetic_curves.GAUSS / a**1.5)
    earth = (1.0, 0.0167, 0.0, 0.0, 1.8, rng.uniform(0.0, 2.0 * math.pi), synthetic_curves.GAUSS)
    t, session = _epochs(rng, body, earth)
    place = synthetic_curves._kepler(body, t)
    sun, observer = -place, synthetic_curves._kepler(earth, t) - place
    first = np.cross(pole, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first)
    angle = 2.0 * math.pi * 24.0 / period * t
    x = np.outer(np.cos(angle), first) + np.outer(np.sin(angle), np.cross(pole, first))
    turn = np.stack([x, np.cross(pole, x), np.broadcast_to(pole, x.shape)], axis=-1)
    r, d = np.linalg.norm(sun, axis=1), np.linalg.norm(observer, axis=1)
    s = np.einsum("tji,tj->ti", turn, sun / r[:, None]) @ normals.T
    o = np.einsum("tji,tj->ti", turn, observer / d[:, None]) @ normals.T
    both = (s > 0.0) & (o > 0.0)
    lit = np.where(both, s * o * (1.0 / np.where(both, s + o, 1.0) + 0.1), 0.0)
    phase = np.degrees(np.arccos(np.clip(np.sum(sun * observer, axis=1) / r / d, -1.0, 1.0)))
    flux = (lit @ areas) * (0.5 * np.exp(-phase / 5.0) - 0.006 * phase + 1.0)
    is_sparse = session == "survey"
    sigma = np.where(is_sparse, 0.05, 0.015)
    names = np.unique(session[~is_sparse])
    zero = dict(zip(names, rng.normal(0.0, 0.5, len(names)), strict=True)) | {"survey": 0.0}
    magnitude = 15.0 - 2.5 * np.log10(flux / areas.sum()) + 5.0 * np.log10(r * d)
    magnitude += sigma * rng.normal(size=t.size) + np.array([zero[each] for each in session])
    curve = inversion.LightCurve(
        Time(2455000.5 + t, format="jd", scale="tdb"), magnitude, sigma,
        sun=sun * units.au, observer=observer * units.au, session=session,
        zero_points=tuple(names.tolist()), light_time=False, frame="ecliptic",
    )  # fmt: skip
    return curve, period, pole


def _epochs(rng, body, earth):
    """Days from the middle, and sessions: nights of six apparitions, and a survey."""
    days = np.arange(-4500.0, 4500.0)
    place = synthetic_curves._kepler(body, days)
    line = place - synthetic_curves._kepler(earth, days)
    cosine = np.sum(place * line, axis=1)
    cosine /= np.linalg.norm(place, axis=1) * np.linalg.norm(line, axis=1)
    is_seen = cosine > math.cos(math.radians(22.0))
    starts = np.flatnonzero(is_seen[1:] & ~is_seen[:-1])
    t, session = [], []
    for number, start in enumerate(rng.choice(starts[:-1], 6, replace=False)):
        end = start + 1 + int(np.argmin(is_seen[start + 1 :]))
        for night in range(4):
            begin = days[rng.integers(start + 1, end)] + rng.uniform(0.0, 0.3)
            inside = np.sort(rng.uniform(0.0, rng.uniform(3.0, 7.0) / 24.0, 24))
            t.append(begin + inside)
            session.append([f"{number}-{night}"] * 24)
    late = days[is_seen & (days > 1000.0)]
    t.append(rng.choice(late, 120) + rng.uniform(0.0, 0.4, 120))
    session.append(["survey"] * 120)
    t, session = np.concatenate(t), np.concatenate(session)
    order = np.argsort(t)
    return t[order], session[order]


def judged(found, curve, period: float, pole: np.ndarray) -> tuple[bool, float, float]:
    """Whether rank 1 has the right number of turns; angles of it and of the list, deg."""
    truth = matrix_to_icrf("ecliptic") @ pole
    listed, own, right = 180.0, 180.0, False
    for each in found:
        here = SearchState.of(each.state).pole
        other = _pole_map.mirrored(here, _pole_map.plane_of(each.weighted.problem))
        cosines = np.clip([here @ truth, other @ truth], -1.0, 1.0)
        angles = np.degrees(np.arccos(cosines)).tolist()
        turns = curve.span / _HOURS * abs(_HOURS / each.P_phi - 1.0 / period)
        if each is found[0]:
            own, right = angles[0], turns < 0.5
        # about other poles the scene turns otherwise
        if turns < 1.5:
            listed = min(listed, *angles)
    return right, own, listed
