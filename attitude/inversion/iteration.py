"""Levenberg and Marquardt's iteration for any model with derivatives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from attitude.annotations import FloatArray

    class Near(Protocol):
        """The cost near a state: half its second derivatives, and minus half its first ones."""

        @property
        def cost(self) -> float: ...

        @property
        def normal(self) -> FloatArray: ...

        @property
        def gradient(self) -> FloatArray: ...


State = TypeVar("State")
Found = TypeVar("Found", bound="Near")
# Damping, relative to the diagonal, at which no step lowers the cost.
_STUCK = 1e6


def minimum(
    at: Callable[[State], Found],
    moved: Callable[[Found, FloatArray], State | None],
    start: State,
    iterations: int,
    gain: float,
) -> Found:
    """The least cost near a start.

    Parameters
    ----------
    at : callable
        The cost near a state.
    moved : callable
        The state after a step (P,), which it may shorten; None where there is no such state.
    start : state
    iterations : int
    gain : float
        Relative decrease of the cost at which the iteration ends.
    """
    best = at(start)
    damping = 3e-3
    for count in range(1, iterations):
        found = _next(best, moved, damping)
        if found is None:
            break
        trial, damping = found
        here = at(trial)
        if here.cost < best.cost:
            won = best.cost - here.cost
            best = here
            damping = max(0.3 * damping, 1e-7)
            if count > 2 and won < gain * here.cost:
                break
        else:
            damping *= 5.0
    return best


def _next(
    best: Found, moved: Callable[[Found, FloatArray], State | None], damping: float
) -> tuple[State, float] | None:
    """The next state to try and its damping; None if none is left."""
    scale = np.sqrt(np.diag(best.normal)) + 1e-12
    scaled = best.normal / np.outer(scale, scale)
    size = len(scale)
    while damping < _STUCK and math.isfinite(best.cost):
        step = np.linalg.solve(scaled + damping * np.eye(size), best.gradient / scale) / scale
        trial = moved(best, step)
        if trial is not None:
            return trial, damping
        damping *= 5.0
    return None
