"""The `CurveProblem` of a light curve: scaled epochs, linear terms, points binned if too many."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.inversion.curve import CALIBRATED
from attitude.inversion.problem import CurveProblem

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, IntArray
    from attitude.inversion.curve import LightCurve

# Standard deviation of the fitted zero points, mag, above which they are taken as free.
_UNCALIBRATED = 0.15
# Points of a search; more are averaged.
MOST_POINTS = 2500
# Terms of the phase angle: widths, and the standard deviation of the curvature, mag; drift in time.
_SURGE, _WIDE, _CURVATURE, _DRIFT = np.radians(5.0), np.radians(50.0), 0.5, 0.05


def problem(
    curve: LightCurve,
    most_frequency: float,
    error: float,
    zero_points: Any,
    *,
    is_known: bool = False,
) -> Any:
    """The problem of a curve, and its points (N,) or None where they are averages.

    Parameters
    ----------
    curve : LightCurve
    most_frequency : float
        Hz.
    error : float
        Model error, mag.
    zero_points : str, float or tuple of str
        As of `LightCurve`.
    is_known : bool
        Whether shape and law are known: without terms of the phase angle and of time.
    """
    span = curve.span
    bins = _bins(curve, most_frequency)
    values = _averaged(curve, bins)
    t = values["emission"] / span
    alpha = values["alpha"]
    terms = [] if is_known else list(phase_terms(alpha, t).T)
    prior = [] if is_known else [np.inf, np.inf, _CURVATURE, _DRIFT]
    for k in range(len(curve.filters)):
        terms.append((values["filter"] == k).astype(float))
        prior.append(np.inf)
    for k, width in enumerate(session_widths(curve, zero_points)):
        if width > 0.0:
            terms.append((values["session"] == k).astype(float))
            prior.append(width)
    found = CurveProblem.of(
        t,
        span,
        values["sun"].T,
        values["observer"].T,
        values["reduced"],
        values["sigma"],
        np.stack(terms, axis=-1),
        np.array(prior),
        error,
    )
    return found, bins


def are_free(offsets: FloatArray) -> bool:
    """Whether fitted zero points (S,), mag, are those of sessions that share no system."""
    return bool(len(offsets) > 2 and offsets.std() > _UNCALIBRATED)


def phase_terms(alpha: FloatArray, t: FloatArray) -> FloatArray:
    """Terms (N, 4) of the phase angle (rad) and of the epoch (spans) in the magnitude."""
    return np.stack([alpha / _WIDE, np.exp(-alpha / _SURGE), (alpha / _WIDE) ** 2, 2.0 * t], axis=1)


def session_widths(curve: LightCurve, zero_points: Any) -> FloatArray:
    """Standard deviations (S,) of the zero points of the sessions, mag; 0 for a shared one."""
    count = len(curve.sessions)
    if count == 1 or zero_points == "shared":
        return np.zeros(count)
    if zero_points == "free":
        return np.full(count, np.inf)
    if zero_points == "auto":
        return np.full(count, CALIBRATED)
    if isinstance(zero_points, tuple):
        return np.array([np.inf if each in zero_points else 0.0 for each in curve.sessions])
    return np.full(count, float(zero_points))


def _bins(curve: LightCurve, most_frequency: float) -> IntArray | None:
    """The number of the average of each point; None if all points are taken."""
    if len(curve) <= MOST_POINTS:
        return None
    width = min(1.0 / (40.0 * most_frequency), curve.span / MOST_POINTS)
    while True:
        cell = np.floor((curve.emission - curve.emission.min()) / width).astype(np.int64)
        keys = (cell * len(curve.sessions) + curve.session) * len(curve.filters) + curve.filter
        found = np.unique(keys, return_inverse=True)[1].reshape(-1)
        if found.max() < 2 * MOST_POINTS or width > 1.0 / (12.0 * most_frequency):
            return found.astype(np.int64)
        width *= 1.3


def _averaged(curve: LightCurve, bins: IntArray | None) -> dict[str, Any]:
    unit = {}
    for name in ("sun", "observer"):
        vectors = getattr(curve, name)
        unit[name] = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    values: dict[str, Any] = {
        "emission": curve.emission,
        "reduced": curve.reduced,
        "sigma": curve.sigma,
        "session": curve.session,
        "filter": curve.filter,
        **unit,
    }
    if bins is not None:
        weight = 1.0 / curve.sigma**2
        total = np.bincount(bins, weight)
        first = np.unique(bins, return_index=True)[1]
        for name in ("emission", "reduced"):
            values[name] = np.bincount(bins, weight * values[name]) / total
        for name in ("sun", "observer"):
            mean = np.stack(
                [np.bincount(bins, weight * values[name][:, k]) / total for k in range(3)], axis=1
            )
            values[name] = mean / np.linalg.norm(mean, axis=1)[:, None]
        values["sigma"] = 1.0 / np.sqrt(total)
        for name in ("session", "filter"):
            values[name] = values[name][first]
        order = np.argsort(values["emission"], kind="stable")
        values = {name: each[order] for name, each in values.items()}
    cross = np.linalg.norm(np.cross(values["sun"], values["observer"]), axis=1)
    dot = np.sum(values["sun"] * values["observer"], axis=1)
    values["alpha"] = np.arctan2(cross, dot)
    return values
