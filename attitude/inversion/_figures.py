"""Figures of an inversion: the fit, residuals, the curve folded by both periods, poles, pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import plots
from attitude.inversion import _lattices, _search, _verdicts
from attitude.photometry import _spectrum
from attitude.photometry._spectrum import OVERSAMPLING

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath
    from attitude.inversion._refine import Refinement
    from attitude.inversion._solution import Solution, SpinStates


_DAY = 86400.0
# Grid frequencies of the map to either side.
_SIDE = 60
_DATA, _MODEL, _OTHER = "#0072b2", "#d55e00", "0.6"


def of_solution(solution: Solution, path: FilePath | None = None) -> Any:
    """The fit of one solution, its residuals, and the curve folded by both periods."""
    figure = plots.new_figure((11.0, 8.0))
    axes = figure.subplots(2, 2)
    _fit(axes[0, 0], axes[1, 0], solution)
    _folded(axes[0, 1], solution, 0)
    _folded(axes[1, 1], solution, 1)
    figure.suptitle(repr(solution)[1:-1], fontsize=9)
    return _saved(figure, path)


def of_fit(found: Refinement, path: FilePath | None = None) -> Any:
    """The fit of a refinement and its residuals."""
    figure = plots.new_figure((8.0, 8.0))
    above, below = figure.subplots(2, 1)
    _fit(above, below, found)
    figure.suptitle(repr(found)[1:-1], fontsize=9)
    return _saved(figure, path)


def of_states(found: SpinStates, path: FilePath | None = None) -> Any:
    """The best fit, residuals by session, both folds, a map of chi-squared, periods and poles."""
    figure = plots.new_figure((12.0, 8.0))
    axes = figure.subplots(2, 3)
    best = found[0]
    _fit(axes[0, 0], axes[1, 0], best)
    _folded(axes[0, 1], best, 0)
    _folded(axes[1, 1], best, 1)
    first = best.evidence
    _map(axes[0, 2], best)
    for each in found:
        behind = each.evidence - first
        colour = _MODEL if behind < 16.0 else _OTHER
        phi, psi = np.array(_verdicts.rates(each.state)) / each.curve.span * _DAY
        axes[0, 2].plot(phi, psi, "o" if each.mode == "LAM" else "s", mfc="none", color=colour)
        longitude, latitude = np.degrees(each.pole)
        axes[1, 2].plot(longitude, latitude, "o", color=colour)
        axes[1, 2].annotate(str(each.rank), (longitude, latitude), fontsize=7)
    axes[0, 2].set_xlabel("1/P_phi of the long axis, 1/d")
    axes[0, 2].set_ylabel("1/P_psi, 1/d")
    axes[1, 2].set_xlabel("ecliptic longitude of the momentum, deg")
    axes[1, 2].set_ylabel("latitude, deg")
    axes[1, 2].set_xlim(0.0, 360.0)
    axes[1, 2].set_ylim(-90.0, 90.0)
    figure.suptitle(f"{found.verdict}: {repr(best)[1:-1]}", fontsize=9)
    return _saved(figure, path)


def _map(axes: Any, best: Solution) -> None:
    """The share of chi-squared that series at i/P_phi + 2j/P_psi leave, near the best."""
    if best.is_axial:
        return
    problem = best.weighted.problem
    phi, psi = _verdicts.rates(best.state)
    step = 1.0 / OVERSAMPLING
    sides = []
    for centre in (phi, 2.0 * psi):
        least = max(2, round(centre / step) - _SIDE)
        sides.append(np.arange(least, least + 2 * _SIDE + 1))
    made = _lattices.tables(problem, 8 * int(max(each[-1] for each in sides)) + 8)
    one, two = (each.ravel() for each in np.meshgrid(*sides, indexing="ij"))
    gain = np.empty(len(one))
    _spectrum.decreases(*made[:4], one, two, _spectrum.harmonics(2), 1.0, gain)
    left = (1.0 - gain / made.total).reshape(len(sides[0]), len(sides[1]))
    unit = step / best.curve.span * _DAY
    x, y = sides[0] * unit, 0.5 * sides[1] * unit
    shown = axes.pcolormesh(x, y, left.T, shading="nearest", cmap="viridis", vmin=0.0, vmax=1.0)
    axes.figure.colorbar(shown, ax=axes, label="chi-squared left")
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])


def _fit(above: Any, below: Any, solution: Solution | Refinement) -> None:
    problem = solution.weighted.problem
    days = problem.t * problem.span / _DAY
    shown = problem.magnitude
    above.plot(days, shown, ".", color=_DATA, label="observed")
    above.plot(days, shown - solution.residuals, "x", color=_MODEL, label="computed", ms=4)
    above.invert_yaxis()
    above.set_ylabel("reduced magnitude")
    above.legend(fontsize=8)
    averaged = len(solution.curve) != len(days)
    session = np.zeros(len(days), np.int64) if averaged else solution.curve.session
    for number in np.unique(session):
        own = session == number
        below.plot(days[own], solution.residuals[own], ".", color=f"C{number % 10}")
    below.axhline(0.0, color=_OTHER)
    below.invert_yaxis()
    below.set_xlabel("days from the epoch")
    below.set_ylabel("residual, mag")


def _folded(axes: Any, solution: Solution, which: int) -> None:
    problem = solution.weighted.problem
    rate = _verdicts.rates(solution.state)[which]
    name = ("P_phi", "P_psi")[which]
    if _search.is_axial(solution.state) and which:
        axes.set_visible(False)
        return
    magnitude = problem.magnitude - np.mean(problem.magnitude)
    axes.plot(np.mod(rate * problem.t, 1.0), magnitude, ".", color=_DATA)
    axes.plot(
        np.mod(rate * problem.t, 1.0), magnitude - solution.residuals, "x", color=_MODEL, ms=4
    )
    axes.invert_yaxis()
    axes.set_xlabel(f"phase of {name} = {solution.curve.span / rate / _DAY:.5g} d")
    axes.set_ylabel("magnitude less its mean")


def _saved(figure: Any, path: FilePath | None) -> Any:
    if path is not None:
        figure.savefig(path, dpi=130)
    return figure
