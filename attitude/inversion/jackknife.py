"""Covariances that contain the error of the model: the delete-group jackknife.

Residuals of one night, one observer or one part of the span are correlated where the model errs, so
that the curvature alone gives errors that are too small.  Each group of points is left out in turn.
What the parameters then change by follows from one step of Newton's, or, where that is more than
one standard error, from another fit.  Directions in which the jackknife's variance exceeds that of
the curvature, by more than the largest eigenvalue of a sample covariance does by chance (Marchenko
& Pastur: (1 + sqrt(P/G))^2 for P parameters and G groups), take the jackknife's.

Source: Cameron & Miller, Journal of Human Resources 50, 317 (2015), section VI; Shaby, J. Comput.
Graph. Stat. 23, 801 (2014) for the adjustment of samples.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from attitude.inversion import refinement

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude.annotations import BoolArray, FloatArray, IntArray
    from attitude.inversion.robust import Weighted

# Groups of one kind at least, and refits at most.
_LEAST_GROUPS, _REFITS = 5, 12
# Parts of the span, and epochs closer than this, s, which belong to one night.
_PARTS, _NIGHT = 10, 0.3 * 86400.0


class Modelled(Protocol):
    """Magnitudes (N,) and their Jacobian (P, N)."""

    @property
    def magnitude(self) -> FloatArray:
        """Of each point."""

    @property
    def jacobian(self) -> FloatArray:
        """By all parameters, those of the motion first."""


class GroupErrors(NamedTuple):
    """Covariances (K, K) of the parameters of the motion: of the density, and with model error.

    widening (K, K) turns samples of the former into those of the latter.
    """

    formal: FloatArray
    covariance: FloatArray
    widening: FloatArray


def errors(
    found: Weighted,
    here: Modelled,
    groupings: Sequence[IntArray],
    count: int,
    refitted: Callable[[BoolArray], FloatArray | None],
    formal: FloatArray | None = None,
) -> GroupErrors:
    """The covariances of the first `count` parameters.

    Parameters
    ----------
    found : Weighted
    here : Modelled
        Of its state, at the points of its problem.
    groupings : sequence of (N,) arrays of int
        The group of each point: nights, sessions, parts of the span.
    count : int
    refitted : callable
        The change (count,) of the parameters in a fit of some points (N,) alone, or None.
    formal : (count, count) array, optional
        In place of that of the curvature.
    """
    normal, problem = found.refined.normal, found.problem
    if formal is None:
        formal = refinement.inverse(normal)[:count, :count]
    free = np.diag(normal)[:count] != 1.0
    r = (problem.y - here.magnitude) * problem.root
    r = r - problem.u.T @ (problem.u @ r)
    jacobian = here.jacobian * problem.root
    jacobian = jacobian - (jacobian @ problem.u.T) @ problem.u
    scale = np.sqrt(np.diag(normal))
    jacobian /= scale[:, None]
    jacobian[:count][~free] = 0.0
    scaled = normal / np.outer(scale, scale)
    factor: FloatArray = np.asarray(
        np.linalg.cholesky(_regular(formal[np.ix_(free, free)])), dtype=np.float64
    )
    inflation = np.eye(len(factor))
    for group in groupings:
        total = int(group.max()) + 1
        if total < _LEAST_GROUPS:
            continue
        changes = []
        for number in range(total):
            on = group == number
            part = jacobian[:, on]
            change = np.linalg.solve(scaled - part @ part.T, -part @ r[on]) / scale
            changes.append(np.linalg.solve(factor, change[:count][free]))
        _refit(changes, group, refitted, factor, free)
        spread = np.array(changes)
        inner = (total - 1.0) / total * spread.T @ spread
        inflation = _larger(inflation, inner, total)
    root = _root(inflation)
    widening, covariance = np.eye(count), np.zeros((count, count))
    at = np.ix_(free, free)
    widening[at] = factor @ root @ np.linalg.inv(factor)
    covariance[at] = factor @ inflation @ factor.T
    kept = np.zeros((count, count))
    kept[at] = formal[at]
    return GroupErrors(kept, 0.5 * (covariance + covariance.T), widening)


def _refit(
    changes: list[FloatArray],
    group: IntArray,
    refitted: Callable[[BoolArray], FloatArray | None],
    factor: FloatArray,
    free: BoolArray,
) -> None:
    """Replace changes of more than one standard error by those of fits, in place."""
    length = np.array([float(np.linalg.norm(each)) for each in changes])
    for number in np.argsort(-length)[:_REFITS]:
        if length[number] < 1.0:
            break
        change = refitted(group != number)
        if change is not None:
            changes[number] = np.linalg.solve(factor, change[free])


def _larger(inflation: FloatArray, inner: FloatArray, groups: int) -> FloatArray:
    """A covariance, with that of a jackknife in the directions in which it is larger for sure."""
    root = _root(inflation)
    back = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(back @ inner @ back.T)
    edge = (1.0 + math.sqrt(len(values) / groups)) ** 2
    values = np.where(values > edge, values, 1.0)
    found: FloatArray = root @ (vectors * values) @ vectors.T @ root.T
    return found


def _root(matrix: FloatArray) -> FloatArray:
    """The symmetric root of a symmetric matrix."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    found: FloatArray = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    return found


def _regular(covariance: FloatArray) -> FloatArray:
    """A covariance whose factor exists."""
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    scaled = covariance / np.outer(size, size) + 1e-10 * np.eye(len(size))
    found: FloatArray = scaled * np.outer(size, size)
    return found


def groupings(t: FloatArray, span: float, session: IntArray | None) -> tuple[IntArray, ...]:
    """Nights, sessions and tenths of the span of epochs t (N,), spans.

    Parameters
    ----------
    t : (N,) array
    span : float
        s.
    session : (N,) array of int, optional
        If the points are not averages.
    """
    parts = np.floor((t - t.min()) * (_PARTS * 0.999999 / max(float(np.ptp(t)), 1e-12)))
    found = [_nights(t * span), _dense(parts)]
    if session is not None and len(session) == len(t):
        found.append(_dense(session))
    return tuple(found)


def _dense(numbers: FloatArray | IntArray) -> IntArray:
    """The same groups numbered without gaps."""
    return np.unique(numbers, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _nights(emission: FloatArray) -> IntArray:
    """The number of the night of each epoch (s)."""
    order = np.argsort(emission, kind="stable")
    number = np.zeros(len(emission), np.int64)
    number[order[1:]] = np.cumsum(np.diff(emission[order]) > _NIGHT)
    return number
