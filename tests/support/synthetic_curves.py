"""Light curves of known bodies for the inversion, by a forward model of its own.

Random convex hulls with planed faces; moments by signed tetrahedra; Euler's equations and the
quaternion by DOP853 to 1e-12; brightness by sums over facets (Lommel-Seeliger and Lambert, a phase
function in flux); two-body orbits of the asteroid and the Earth, light time by iteration.  Nothing
of the package is imported.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial import ConvexHull

LIGHT_DAY_AU = 173.14463267424034  # astronomical units in a day of light
GAUSS = 0.01720209895  # mean motion at 1 au, rad/d
_BLOCK = 10_000  # epochs whose facets are in memory


@dataclass
class Case:
    """A synthetic light curve and its truth; days, au, ecliptic axes."""

    jd: np.ndarray  # TDB, of reception
    magnitude: np.ndarray
    sigma: np.ndarray
    session: np.ndarray
    sun: np.ndarray  # (N, 3) from the body
    observer: np.ndarray
    mode: str
    P_psi: float
    P_phi: float  # of the long axis
    pole: np.ndarray
    moments: np.ndarray
    most: float  # largest frequency of the search, 1/d
    exact: np.ndarray | None = None  # magnitude without errors, where it is known
    filter: np.ndarray | None = None
    orbit: float | None = None  # period of a moon
    exposure: float = 0.0  # d
    drift: np.ndarray | None = None  # of the frequencies of phi and psi, turns per span^2


def hull(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Moments (ascending, largest 1), normals (F, 3) over principal axes, and areas (F,)."""
    while True:
        b = rng.uniform(0.45, 0.92)
        axes = np.array([1.0, b, b * rng.uniform(0.6, 0.97)])
        points = rng.normal(size=(500, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        rough = 1.0 + sum(
            rng.normal(0.0, 0.05) * np.exp(4.0 * (points @ _unit(rng) - 1.0)) for _ in range(12)
        )
        points = points * rough[:, None]
        for _ in range(rng.integers(0, 5)):
            d, height = _unit(rng), rng.uniform(0.8, 0.97)
            points -= np.maximum(points @ d - height, 0.0)[:, None] * d
        points = points * axes
        found = ConvexHull(points)
        corners = points[found.simplices] - points.mean(axis=0)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal *= np.sign(np.sum(normal * corners.sum(axis=1), axis=1))[:, None]
        volume = np.abs(np.linalg.det(corners)) / 6.0
        center = (volume[:, None] * corners.sum(axis=1) / 4.0).sum(axis=0) / volume.sum()
        total = corners.sum(axis=1)
        second = np.einsum("f,fi,fj->ij", volume, total, total) / 20.0
        second += np.einsum("f,fki,fkj->ij", volume, corners, corners) / 20.0
        second = second / volume.sum() - np.outer(center, center)
        values, turn = np.linalg.eigh(np.trace(second) * np.eye(3) - second)
        turn[:, 2] *= np.linalg.det(turn)
        if values[1] - values[0] > 0.05 * values[2] and values[2] - values[1] > 0.01 * values[2]:
            size = np.linalg.norm(normal, axis=1)
            return values / values[2], normal / size[:, None] @ turn, 0.5 * size


def _unit(rng):
    d = rng.normal(size=3)
    return d / np.linalg.norm(d)


def _kepler(elements, t):
    a, e, inclination, node, argument, anomaly, n = elements
    mean = anomaly + n * t
    E = mean.copy()
    for _ in range(15):
        E -= (E - e * np.sin(E) - mean) / (1.0 - e * np.cos(E))
    x, y = a * (np.cos(E) - e), a * math.sqrt(1.0 - e * e) * np.sin(E)
    co, so, ci, si = math.cos(node), math.sin(node), math.cos(inclination), math.sin(inclination)
    cw, sw = math.cos(argument), math.sin(argument)
    p = np.array([co * cw - so * sw * ci, so * cw + co * sw * ci, sw * si])
    q = np.array([-co * sw - so * cw * ci, -so * sw + co * cw * ci, cw * si])
    return x[:, None] * p + y[:, None] * q


def encounter(rng: np.random.Generator, span: float):
    """Orbits of an asteroid that is seen near the Earth, and of the Earth."""
    t = np.linspace(-0.5 * span, 0.5 * span, 9)
    while True:
        a = rng.uniform(0.9, 2.4)
        body = (a, rng.uniform(0.1, 0.55), math.radians(rng.uniform(2, 25)))
        body += (*rng.uniform(0.0, 2.0 * math.pi, 3), GAUSS / a**1.5)
        earth = (1.0, 0.0167, 0.0, 0.0, 1.8, rng.uniform(0.0, 2.0 * math.pi), GAUSS)
        place, line = _kepler(body, t), _kepler(body, t) - _kepler(earth, t)
        far, off = np.linalg.norm(line, axis=1), np.linalg.norm(place, axis=1)
        phase = np.degrees(np.arccos(np.clip(np.sum(line * place, axis=1) / far / off, -1, 1)))
        if far.min() < 0.08 or far.max() > 1.2 or phase.max() > 75.0 or off.min() < 0.95:
            continue
        unit = line / far[:, None]
        sweep = math.degrees(math.acos(max(-1.0, float((unit @ unit.T).min()))))
        if min(25.0, 0.5 * span) < sweep < 120.0:
            return body, earth


def _rates(t, y, moments, torque=(0.0, 0.0, 0.0)):
    w, x, yy, z, a, b, c = y
    i, j, k = moments
    along_x, along_y, along_z = np.divide(torque, moments)
    return np.array(
        [
            0.5 * (-x * a - yy * b - z * c),
            0.5 * (w * a + yy * c - z * b),
            0.5 * (w * b + z * a - x * c),
            0.5 * (w * c + x * b - yy * a),
            (j - k) * b * c / i + along_x,
            (k - i) * c * a / j + along_y,
            (i - j) * a * b / k + along_z,
        ]
    )


def _matrices(q):
    w, x, y, z = (q / np.linalg.norm(q, axis=-1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _integrated(moments, start, t, torque=(0.0, 0.0, 0.0)):
    return solve_ivp(
        _rates, (t[0], t[-1]), start, "DOP853", t, args=(moments, torque), rtol=1e-12, atol=1e-13
    ).y.T


def _periods(moments, start):
    """Mode, P_psi and P_phi of the long axis, from a dense integration over whole periods."""
    speed = np.linalg.norm(start[4:])
    t = np.linspace(0.0, 120.0 * 2.0 * math.pi / speed, 24001)
    y = _integrated(moments, start, t)
    momentum = y[:, 4:] * moments
    is_long = np.sum(moments * start[4:] ** 2) > np.sum(momentum[0] ** 2) / moments[1]
    z = momentum[:, 1]
    up = np.flatnonzero((z[:-1] < 0.0) & (z[1:] >= 0.0))
    cross = t[up] - z[up] * (t[up + 1] - t[up]) / (z[up + 1] - z[up])
    P_psi = (cross[-1] - cross[0]) / (len(cross) - 1)
    turn = _matrices(y[:, :4])
    along = turn[0] @ momentum[0]
    along /= np.linalg.norm(along)
    first = np.cross(along, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first)
    axis = turn[:, :, 0]
    angle = np.unwrap(np.arctan2(axis @ np.cross(along, first), axis @ first))
    # over whole psi periods, where the periodic part returns
    ends = np.interp(cross[[0, -1]], t, angle)
    P_phi = 2.0 * math.pi * (cross[-1] - cross[0]) / abs(ends[1] - ends[0])
    return ("LAM" if is_long else "SAM"), P_psi, P_phi, along


def case(seed: int, style: dict) -> Case:
    """A case of a seed and a style; see `benchmarks.inversion.STYLES`."""
    rng = np.random.default_rng(seed)
    moments, normals, areas = hull(rng)
    rate = 2.0 * math.pi / style["P"]
    while True:
        w = rng.normal(size=3) * np.array([1.0, 0.7, 1.0])
        if style["mode"] == "PA":
            w = np.array([0.0, 0.0, 1.0])
            break
        D = np.sum((moments * w) ** 2) / np.sum(moments * w * w)
        is_long = moments[1] > D
        edge = moments[0] if is_long else moments[2]
        place = (D - edge) / (moments[1] - edge)
        if ("LAM" if is_long else "SAM") == style["mode"] and 0.06 < place < 0.9:
            break
    w *= rate / np.linalg.norm(w)
    q = rng.normal(size=4)
    start = np.r_[q / np.linalg.norm(q), w]
    span = style["span"]
    body, earth = style.get("orbits") or encounter(rng, span)
    jd, session = _epochs(rng, style)
    t = jd - 2460000.5
    light = np.zeros_like(t)
    for _ in range(6):
        place = _kepler(body, t - light)
        light = np.linalg.norm(place - _kepler(earth, t), axis=1) / LIGHT_DAY_AU
    to_sun, to_observer = -place, _kepler(earth, t) - place
    left = t - light
    # per moment, along the long and the short axis: rates change by some turns per span^2
    change = 2.0 * math.pi * style.get("drift", 0.0) / span**2
    torque = change * moments * np.array([1.0, 0.0, 1.0])
    y = _integrated(moments, start, left, torque)
    turn = _matrices(y[:, :4])
    r, d = np.linalg.norm(to_sun, axis=1), np.linalg.norm(to_observer, axis=1)
    lambert = rng.uniform(0.05, 0.15)
    flux = np.empty_like(t)
    for first in range(0, len(t), _BLOCK):
        on = slice(first, first + _BLOCK)
        s = np.einsum("tji,tj->ti", turn[on], to_sun[on] / r[on, None]) @ normals.T
        o = np.einsum("tji,tj->ti", turn[on], to_observer[on] / d[on, None]) @ normals.T
        both = (s > 0.0) & (o > 0.0)
        lit = np.where(both, s * o * (1.0 / np.where(both, s + o, 1.0) + lambert), 0.0)
        flux[on] = lit @ areas
    phase = np.degrees(np.arccos(np.sum(to_sun * to_observer, axis=1) / r / d))
    flux *= np.maximum(0.5 * np.exp(-phase / 5.0) - 0.006 * phase + 1.0, 0.2)
    sigma = style["noise"] * rng.uniform(0.7, 1.3, t.size)
    zero = rng.normal(0.0, style.get("zero", 0.0), session.max() + 1)
    magnitude = 20.0 - 2.5 * np.log10(flux / areas.sum()) + 5.0 * np.log10(r * d)
    exact = magnitude.copy()
    magnitude += sigma * rng.normal(size=t.size) + zero[session]
    drift = np.zeros(2)
    if style["mode"] == "PA":
        mode, P_psi, P_phi = "PA", math.inf, style["P"]
        pole = turn[0][:, 2]
    else:
        at = np.array([left[0], 0.5 * (left[0] + left[-1]), left[-1]])
        states = _integrated(moments, start, at, torque) if change else [start] * 3
        mode, P_psi, P_phi, pole = _periods(moments, states[1])
        if change:
            ends = [1.0 / np.array(_periods(moments, states[k])[2:0:-1]) for k in (0, 2)]
            drift = (ends[1] - ends[0]) * np.ptp(left)
    most = style.get("most", 3.2) / style["P"]
    geometry = jd, magnitude, sigma, session, to_sun, to_observer
    return Case(*geometry, mode, P_psi, P_phi, pole, moments, most, exact, drift=drift)


def variation(made: Case) -> float:
    """Standard deviation, mag, of the magnitude without errors less what every fit projects out.

    These are a constant that all sessions share, terms of the phase angle, and a drift.
    """
    r, d = np.linalg.norm(made.sun, axis=1), np.linalg.norm(made.observer, axis=1)
    alpha = np.arccos(np.sum(made.sun * made.observer, axis=1) / r / d)
    t = made.jd - made.jd.mean()
    terms = np.stack(
        [np.ones_like(t), alpha, np.exp(-np.degrees(alpha) / 5.0), alpha**2, t], axis=-1
    )
    reduced = made.exact - 5.0 * np.log10(r * d)
    return float(np.std(reduced - terms @ np.linalg.lstsq(terms, reduced, rcond=None)[0]))


def is_decidable(made: Case) -> bool:
    """Whether the magnitude of the body itself varies by as much as its errors.

    A body seen nearly from its pole varies by less: no period then stands out from those of noise.
    Only the forward model decides this, nothing that an inversion finds.
    """
    return variation(made) >= math.sqrt(float(np.mean(made.sigma**2)))


def _epochs(rng, style):
    if "apparitions" in style:
        return _epochs_of_apparitions(rng, style)
    nights = np.sort(rng.choice(int(style["span"]), style["nights"], replace=False))
    begin = rng.uniform(0.6, 0.9)
    t, session = [], []
    for k, night in enumerate(nights):
        length = rng.uniform(*style["hours"]) / 24.0
        count = max(3, int(length * 24.0 * style["per_hour"]))
        here = night + begin + (0.0 if style.get("one_site") else rng.normal(0.0, 0.05))
        inside = rng.uniform(0.0, length, count)
        if style.get("even"):  # epochs of so many points would be equal as Julian dates
            inside = np.linspace(0.0, length, count)
        t.append(here + np.sort(inside))
        session.append(np.full(count, k))
    t = np.concatenate(t) - 0.5 * style["span"]
    order = np.argsort(t)
    return 2460000.5 + t[order], np.concatenate(session)[order]


def _epochs_of_apparitions(rng, style):
    """Julian dates and sessions of nights within apparitions: first and last date, and how many."""
    jd, session = [], []
    for first, last, count in style["apparitions"]:
        part = {**style, "span": last - first, "nights": count}
        del part["apparitions"]
        own, number = _epochs(rng, part)
        jd.append(own - 2460000.5 + 0.5 * (first + last))
        session.append(number + sum(len(np.unique(each)) for each in session))
    return np.concatenate(jd), np.concatenate(session)
