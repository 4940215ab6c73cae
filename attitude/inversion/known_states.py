"""Ranked spin states of a body of known shape: a search, and least squares from its best states."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation import FreeRotation
from attitude.inversion import (
    curve_problem,
    known_shape,
    moving,
    moving_fit,
    robust,
    search,
    verdicts,
)
from attitude.inversion.convex import Tie
from attitude.inversion.pass_search import PassSearch
from attitude.inversion.refine import Refinement
from attitude.spin import Spin

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude.annotations import FloatArray
    from attitude.inversion.curve import LightCurve
    from attitude.scattering import Law
    from attitude.shape import Mesh

# States of the search that are fitted, and the cost behind the best beyond which none is.
_FITTED, _BEHIND = 12, 150.0
# Rates and momenta closer than this, relative, are one.
_SAME = 0.01
# Turn, rad, and share of the rate, within which two minima are in one lobe of the density.
_LOBE_TURN, _LOBE_RATE = 0.3, 0.1
# Mean square of residuals, without the worst 3 %, over sigma and 0.01 mag of an accepted state.
_FLOOR = 1.25


def body_of(mesh: Mesh, moments: Any) -> Body:
    """The body of a mesh: homogeneous, a Body that is given, or three moments about its axes.

    Raises
    ------
    AttitudeError
        For moments that are free or tied: with a known shape they are known.
    """
    if isinstance(moments, Body):
        return moments
    if isinstance(moments, str) and moments == "shape":
        return Body.from_shape(mesh, density=1.0)
    if isinstance(moments, str) or np.ndim(moments) != 1:
        raise AttitudeError(
            f'moments is {moments!r}; with a known shape give "shape" (homogeneous), three moments '
            "about its axes, or a Body."
        )
    return Body(moments=moments, relative=True)


def found(
    curve: LightCurve,
    most: float,
    mesh: Mesh,
    law: str | Law | None,
    moments: Any,
    seconds: float,
    seed: int,
    progress: Callable[[str], object],
) -> tuple[list[Refinement], str, str, tuple[str, ...]]:
    """Solutions, the best first, the verdict, its criterion, and notes; see `spin_states`."""
    body = body_of(mesh, moments)
    axes = body.principal_axes
    known = known_shape.known(mesh, law).over(axes)
    zero_points = curve.zero_points
    problem, bins = curve_problem.problem(
        curve, most, search.ELLIPSOID_ERROR, zero_points, is_known=True
    )
    notes = list(curve.notes)
    if bins is not None:
        notes.append(f"{len(curve)} points were averaged to {len(problem)}.")
    made = PassSearch(
        problem,
        known,
        body.moments,
        2.0 * math.pi * most,
        validation.generator(seed),
        time.monotonic() + seconds,
        progress,
    )
    made.run()
    solutions = [
        _fitted(curve, problem, known, body, made, k)
        for k in range(len(made.found.cost))
        if k < _FITTED and made.found.cost[k] < made.found.cost[0] + _BEHIND
    ]
    solutions.sort(key=lambda each: each.evidence)
    kept: list[Refinement] = []
    for each in solutions:
        if not any(_is_same(each, other) for other in kept):
            each.rank = len(kept)
            each.relation = _relation(each, kept[0]) if kept else "best"
            each.rivals = _rivals(each, solutions)
            kept.append(each)
    return kept, *_verdict(kept), tuple(notes)


def _fitted(curve, problem, known, body, made, k):
    """The least squares from a state of the search."""
    epoch = curve.epoch.after(made.origin)
    spin = Spin(epoch, made.found.wxyz[k], made.found.omega[k])
    own = Body(moments=body.moments, relative=body.relative, mass=body.mass)
    ends = float(curve.emission[0]), float(curve.emission[-1])
    point = moving.of(FreeRotation(own, spin), curve.epoch, ends, None, None)
    fit = moving_fit.of(curve.epoch, problem, point, known, Tie())
    weighted = fit.weighted(problem, moving_fit.MovingState(point, np.zeros(0)))
    return Refinement(curve, weighted, problem, fit, body)


def _vectors(each: Refinement) -> tuple[FloatArray, FloatArray]:
    """Momentum, over axes in space, and rates over body axes."""
    first = FreeRotation(each.point.body, each.point.spin)
    momentum = first.momentum / np.max(each.point.body.moments)
    return momentum, each.point.spin.angular_velocity


def _is_same(one: Refinement, other: Refinement) -> bool:
    (a, v), (b, w) = _vectors(one), _vectors(other)
    size = float(np.linalg.norm(w))
    turn = abs(float(one.point.spin.wxyz_icrf @ other.point.spin.wxyz_icrf))
    return bool(
        np.linalg.norm(a - b) < _SAME * size
        and np.linalg.norm(v - w) < _SAME * size
        and turn > math.cos(0.05)
    )


def _rivals(
    each: Refinement, solutions: Sequence[Refinement]
) -> tuple[tuple[FloatArray, float], ...]:
    """Offsets of the other minima in the lobe of one, and how far their evidence is behind."""
    rate = float(np.linalg.norm(each.point.spin.angular_velocity))
    found = []
    for other in solutions:
        offset = other.point.difference(each.point)
        near = np.linalg.norm(offset[:3]) < _LOBE_TURN
        if other is not each and near and np.linalg.norm(offset[3:6]) < _LOBE_RATE * rate:
            found.append((offset, other.evidence - each.evidence))
    return tuple(found)


def _has_rates(one: Refinement, other: Refinement) -> bool:
    """Whether two states have the same momentum in space, and the same sizes of the rates."""
    (a, v), (b, w) = _vectors(one), _vectors(other)
    size = float(np.linalg.norm(w))
    near = np.linalg.norm(np.abs(v) - np.abs(w)) < 0.05 * size
    return bool(near and np.linalg.norm(a - b) < 0.05 * size)


def _relation(each: Refinement, best: Refinement) -> str:
    if _has_rates(each, best):
        return "same momentum, other attitude"
    a, b = _vectors(each)[0], _vectors(best)[0]
    cosine = float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b))
    pole = "same pole" if cosine > 0.97 else "antipode" if cosine < -0.97 else "other pole"
    same = abs(float(np.linalg.norm(a) / np.linalg.norm(b)) - 1.0) < 0.02
    return pole if same else f"other periods, {pole}"


def _verdict(found: Sequence[Refinement]) -> tuple[str, str]:
    """The verdict and its criterion in words."""
    if not found:
        return verdicts.OPEN, "No solution was found."
    best = found[0]
    floor = robust.floor_ratio(best.weighted, best._problem)
    gap = min(
        (e.evidence - best.evidence for e in found[1:] if not _has_rates(e, best)),
        default=math.inf,
    )
    words = (
        f"chi2/N is {floor:.2f} with errors of sigma and {robust.FLOOR_ERROR:g} mag (floor "
        f"{_FLOOR:g}); the next rates are {gap:.1f} behind in -2 ln(evidence) "
        f"({verdicts.COMPETING:g} needed)."
    )
    if floor < _FLOOR and gap > verdicts.COMPETING:
        return verdicts.SOLVED, words
    return verdicts.OPEN, words
