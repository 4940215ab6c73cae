"""Figures of an inversion: the fit, residuals, the curve folded by both periods, poles, pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude import plots
from attitude._support.constants import GAP_OF_NIGHTS_S
from attitude._support.quantity_text import time_unit
from attitude.errors import AttitudeError
from attitude.inversion import _lattices, _neighbours, _verdicts
from attitude.inversion._ellipsoid import SearchState
from attitude.inversion._problem import interpolated
from attitude.inversion._refinement import MOTION, NAMES
from attitude.photometry import _folding, _spectrum
from attitude.photometry._curve import LightCurve, dimming
from attitude.photometry._figures import DATA, MODEL, OTHER, draw_series
from attitude.photometry._spectrum import OVERSAMPLING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from attitude._support.annotations import FilePath, FloatArray, IntArray
    from attitude.epochs._instants import Instant
    from attitude.inversion._solution import CurveFit, Prediction, Solution, SpinStates
    from attitude.inversion._states import Posterior


# Grid frequencies of the map to either side.
_SIDE = 60
# Nights of a figure at most.
_NIGHTS = 20
# Columns of panels.
_COLUMNS = 3
# Points a night from which nights have panels.
_FEW = 3
# Points of a line of the model.
_FINE = 200
# Magnitudes that a panel shows at least.
_LEAST_HEIGHT = 0.05


class _Night(NamedTuple):
    """A panel: its date, points with errors and residuals, and the model with its error."""

    title: str
    hours: FloatArray
    value: FloatArray
    error: FloatArray
    residual: FloatArray
    line: tuple[FloatArray, FloatArray, FloatArray]

    @property
    def shown(self) -> FloatArray:
        """All magnitudes of the panel."""
        _, model, band = self.line
        return np.concatenate([self.value, model - band, model + band])


def of_nights(solution: CurveFit, path: FilePath | None = None) -> Figure:
    """A panel a night: points, the model as a line, residuals under it.

    Points are in the first filter and at the zero point of the line.  Of curves of few points a
    night, one panel of the whole curve.
    """
    problem, curve = solution.weighted.problem, solution.curve
    seconds = problem.seconds
    groups = _neighbours.nights_of(seconds)
    if np.median([len(group) for group in groups]) < _FEW:
        return of_fit(solution, path)
    reduced = problem.magnitude - solution._zero_points
    chosen = sorted(groups, key=lambda night: -len(night))[:_NIGHTS]
    nights = []
    for points in sorted(chosen, key=lambda night: night[0]):
        fine = np.linspace(seconds[points[0]], seconds[points[-1]], _FINE)
        predicted = solution.predict(_at(curve, fine))
        model = predicted.magnitude
        if not curve.unit_distances:
            model = model - dimming(predicted.sun, predicted.observer)
        start = seconds[points[0]]
        nights.append(
            _Night(
                _date(curve.epoch.after(float(start))),
                (seconds[points] - start) / 3600.0,
                reduced[points],
                problem.sigma[points],
                solution.residuals[points],
                ((fine - start) / 3600.0, model, np.zeros(_FINE)),
            )
        )
    words = f", {len(nights)} of {len(groups)} nights" if len(nights) < len(groups) else ""
    figure = _panels(nights, "reduced magnitude", f"{repr(solution)[1:-1]}{words}")
    return plots.saved(figure, path)


def of_prediction(
    prediction: Prediction, path: FilePath | None = None, observed: LightCurve | None = None
) -> Figure:
    """A panel a night of what is predicted, with the error of its form, and of what was observed.

    All in the filter of the first epoch.  Points of a night are shifted by their mean residual in
    each filter, which is beside its date.
    """
    nights = []
    in_one_filter = prediction.magnitude - prediction.colour
    for points in _neighbours.nights_of(prediction.seconds)[:_NIGHTS]:
        start = float(prediction.seconds[points[0]])
        title = _date(prediction.epoch.after(start))
        hours = (prediction.seconds[points] - start) / 3600.0
        line = hours, in_one_filter[points], prediction.form[points]
        seen = value = error = residual = np.zeros(0)
        night = None if observed is None else _in_night(observed, prediction, points)
        if night is not None:
            seen = (
                night.seconds + (night.epoch.seconds - prediction.epoch.seconds) - start
            ) / 3600.0
            error = night.magnitude_sigma
            if night.has_geometry:
                name = prediction.fit.curve.filters[prediction.filter[0]]
                model = prediction.fit.predict(night, filter=name).magnitude
            else:
                model = np.interp(seen, hours, line[1])
            offset = _means(night.magnitude - model, night.filter)
            value = night.magnitude - offset
            residual = value - model
            title += _words_of_shifts(night, -offset)
        nights.append(_Night(title, seen, value, error, residual, line))
    level = f"level to {np.median(prediction.level):.3f} mag; the band is the error of the form"
    words = f"{repr(prediction.fit)[1:-1]}\n{level}"
    return plots.saved(_panels(nights, "magnitude", words), path)


def _in_night(observed: LightCurve, prediction: Prediction, points: IntArray) -> LightCurve | None:
    """The observed points of the night of predicted epochs, or within these without geometry."""
    times = observed.seconds + (observed.epoch.seconds - prediction.epoch.seconds)
    first, last = prediction.seconds[points[[0, -1]]]
    more = GAP_OF_NIGHTS_S if observed.has_geometry else 0.0
    inside = (times >= first - more) & (times <= last + more)
    return observed[inside] if np.any(inside) else None


def _words_of_shifts(observed: LightCurve, shift: FloatArray) -> str:
    """By how much points (N,) are shifted; those of several filters in a second line."""
    shifts = {observed.filters[k]: by for k, by in zip(observed.filter, shift, strict=True)}
    if len(shifts) == 1:
        return f", shifted {shift[0]:+.3f} mag"
    return "\nshifted " + ", ".join(f"{name} {by:+.3f}" for name, by in shifts.items()) + " mag"


def _means(values: FloatArray, group: IntArray) -> FloatArray:
    """The mean (N,) of values (N,) in the group of each."""
    counts = np.maximum(np.bincount(group), 1)
    return (np.bincount(group, values) / counts)[group]


def _at(curve: LightCurve, emission: FloatArray) -> LightCurve:
    """The geometry of a curve, interpolated at epochs of emission."""
    sun, observer = interpolated(curve, curve.emission, emission)
    return LightCurve(
        emission,
        np.zeros(len(emission)),
        sun=sun,
        observer=observer,
        epoch=curve.epoch,
        time_of="emission",
    )


def _date(epoch: Instant, digits: int = 16) -> str:
    return epoch.utc_iso[:digits].replace("T", " ")


def _panels(nights: Sequence[_Night], name: str, title: str) -> Figure:
    """A figure of panels with residuals under them where there are points, all of one scale."""
    from matplotlib.ticker import MaxNLocator

    columns = min(_COLUMNS, len(nights))
    rows = -(-len(nights) // columns)
    figure = plots.new_figure((max(2.8 * columns + 0.6, 7.0), 2.9 * rows + 0.7))
    cells = figure.subfigures(rows, columns, squeeze=False, wspace=0.01, hspace=0.01)
    ranges = [night.shown for night in nights]
    height = max(_LEAST_HEIGHT, 1.15 * max(float(np.ptp(values)) for values in ranges))
    off = [float(np.abs(night.residual).max()) for night in nights if len(night.residual)]
    for k, night in enumerate(nights):
        row, column = divmod(k, columns)
        ratios = {"height_ratios": (3, 1)} if off else {}
        axes = cells[row, column].subplots(2 if off else 1, 1, sharex=True, gridspec_kw=ratios)
        above, below = axes if off else (axes, None)
        hours, model, band = night.line
        above.fill_between(hours, model - band, model + band, color=MODEL, alpha=0.25, lw=0)
        if len(hours) > 1:
            above.plot(hours, model, color=MODEL, lw=1.2)
        else:
            above.errorbar(hours, model, band, fmt="D", ms=4, color=MODEL)
        if below is not None and len(night.hours):
            error = np.nan_to_num(night.error)
            for panel, values in ((above, night.value), (below, night.residual)):
                panel.errorbar(night.hours, values, error, fmt="o", ms=2.5, lw=0.7, color=DATA)
        if below is not None:
            below.set_ylim(1.3 * max(off), -1.3 * max(off))
            below.axhline(0.0, color=OTHER, lw=0.8)
        middle = 0.5 * float(ranges[k].min() + ranges[k].max())
        above.set_ylim(middle + 0.5 * height, middle - 0.5 * height)
        above.set_title(night.title, fontsize=9, parse_math=False)
        for panel, count in ((above, 5), (below, 3)):
            if panel is not None:
                panel.tick_params(labelsize=9)
                panel.yaxis.set_major_locator(MaxNLocator(count))
                panel.xaxis.set_major_locator(MaxNLocator(5))
        if column == 0:
            above.set_ylabel(name, fontsize=9)
            if below is not None:
                below.set_ylabel("residual", fontsize=9)
        if k + columns >= len(nights):
            (above if below is None else below).set_xlabel("hours from the date", fontsize=9)
        cells[row, column].align_ylabels()
    for k in range(len(nights), rows * columns):
        cells[divmod(k, columns)].set_visible(False)
    figure.suptitle(title, fontsize=9)
    return figure


def of_fit(solution: CurveFit, path: FilePath | None = None) -> Figure:
    """The fit of a refinement and its residuals."""
    figure = plots.new_figure((8.0, 8.0))
    above, below = figure.subplots(2, 1)
    _fit(above, below, solution)
    figure.suptitle(repr(solution)[1:-1], fontsize=9)
    return plots.saved(figure, path)


def of_states(states: SpinStates[Solution], path: FilePath | None = None) -> Figure:
    """The best fit, residuals by session, both folds, a map of chi-squared, periods and poles.

    Where all solutions turn about one axis, without what belongs to P_psi.
    """
    best = states[0]
    are_axial = all(state.is_axial for state in states)
    figure = plots.new_figure((9.0, 7.2 if are_axial else 10.5))
    axes = figure.subplots(2 if are_axial else 3, 2).T
    _fit(axes[0, 0], axes[1, 0], best)
    _folded(axes[0, 1], best, 0)
    colours = [
        MODEL
        if _verdicts.competes(
            state.weighted, best.weighted, best._problem, is_hidden=not best.tie.is_wide
        )
        else OTHER
        for state in states
    ]
    _poles(axes[1, -1], states, colours)
    if not are_axial:
        _folded(axes[1, 1], best, 1)
        _map(axes[0, 2], best)
        _rates(axes[0, 2], states, colours)
    figure.suptitle(f"{states.verdict}: {repr(best)[1:-1]}", fontsize=9)
    return plots.saved(figure, path)


def _rates(axes: Axes, states: SpinStates[Solution], colours: Sequence[str]) -> None:
    """Both frequencies of each state, the best last, over the others."""
    size, unit = time_unit(states[0].P_phi)
    for state, colour in zip(reversed(states), reversed(colours), strict=True):
        rates = np.array(SearchState.of(state.state).rates)
        phi, psi = rates / state.curve.span * size
        mark = "o" if state.mode == "LAM" else "s"
        axes.plot(phi, psi, mark, mfc="none", mew=1.8, color=colour)
    axes.set_xlabel(f"1/P_phi of the long axis, 1/{unit}")
    axes.set_ylabel(f"1/P_psi, 1/{unit}")
    axes.ticklabel_format(useOffset=False)
    axes.locator_params("x", nbins=4)
    for mode, mark in (("LAM", "o"), ("SAM or PA", "s")):
        axes.plot([], [], mark, mfc="none", color=MODEL, label=mode)
    axes.legend(fontsize=9, loc="upper right")


def _poles(axes: Axes, states: SpinStates[Solution], colours: Sequence[str]) -> None:
    """The pole of each state with its rank, the best last, over the others."""
    poles = [tuple(np.degrees(state.pole).tolist()) for state in states]
    for pole, colour in zip(reversed(poles), reversed(colours), strict=True):
        axes.plot(*pole, "o", color=colour, ms=4, clip_on=False)
    axes.set_xlabel("ecliptic longitude of the momentum, deg")
    axes.set_ylabel("latitude, deg")
    axes.set_xlim(0.0, 360.0)
    axes.set_ylim(-90.0, 90.0)
    for state, place in zip(states, free_places(poles), strict=True):
        if place is not None:
            axes.text(*place, str(state.rank), fontsize=9, ha="center", va="center")


def of_posterior(posterior: Posterior, path: FilePath | None = None) -> Figure:
    """A corner figure of the first solution's parameters."""
    figure = plots.new_figure((9.0, 9.0))
    axes = figure.subplots(MOTION, MOTION, sharex="col")
    of_best = posterior.offsets[posterior.solution == 0]
    for row in range(MOTION):
        for column in range(MOTION):
            panel = axes[row, column]
            if column > row:
                panel.set_visible(False)
            elif column == row:
                panel.hist(of_best[:, row], 30, color=DATA)
            else:
                panel.plot(of_best[:, column], of_best[:, row], ",", color=DATA)
            if row == MOTION - 1:
                panel.set_xlabel(NAMES[column], fontsize=9)
            panel.locator_params(nbins=2)
            panel.tick_params(labelsize=9, labelleft=column == 0 < row)
            panel.tick_params("x", rotation=60)
    return plots.saved(figure, path)


# Half the width and height of a number on the map of poles, deg.
_NUMBER = np.array([9.0, 6.0])
# Half the width and height of a mark, deg.
_MARK = np.array([4.0, 3.0])


def free_places(poles: Sequence[tuple[float, float]]) -> list[tuple[float, float] | None]:
    """Where the number of each pole (lon, lat, deg; best first) hides no other; None: nowhere."""
    taken = [(np.array(pole), _MARK) for pole in poles]
    places: list[tuple[float, float] | None] = []
    for k, pole in enumerate(poles):
        # its own mark is beside it
        others = taken[:k] + taken[k + 1 :]
        for across, up in ((1, 1), (-1, 1), (1, -1), (-1, -1), (0, 1.6), (0, -1.6)):
            place = np.array(pole) + (_NUMBER + 0.7 * _MARK) * np.array([across, up])
            inside = 9.0 < place[0] < 351.0 and abs(place[1]) < 84.0
            free = all(np.any(np.abs(place - at) > _NUMBER + size) for at, size in others)
            if inside and free:
                taken.append((place, _NUMBER))
                places.append((float(place[0]), float(place[1])))
                break
        else:
            places.append(None)
    return places


def _map(axes: Axes, best: Solution) -> None:
    """The share of chi-squared that series at i/P_phi + 2j/P_psi leave, near the best."""
    if best.is_axial:
        return
    problem = best.weighted.problem
    phi, psi = SearchState.of(best.state).rates
    step = 1.0 / OVERSAMPLING
    sides = []
    for centre in (phi, 2.0 * psi):
        least = max(2, round(centre / step) - _SIDE)
        sides.append(np.arange(least, least + 2 * _SIDE + 1))
    sums = _lattices.tables(problem, 8 * int(max(side[-1] for side in sides)) + 8)
    one, two = (axis.ravel() for axis in np.meshgrid(*sides, indexing="ij"))
    gain = _spectrum.decreases(sums, one, two, _spectrum.harmonics(2))
    left = (1.0 - gain / sums.total).reshape(len(sides[0]), len(sides[1]))
    width = step / best.curve.span * time_unit(best.P_phi)[0]
    x, y = sides[0] * width, 0.5 * sides[1] * width
    shown = axes.pcolormesh(x, y, left.T, shading="nearest", cmap="viridis", vmin=0.0, vmax=1.0)
    axes.figure.colorbar(shown, ax=axes, label="chi-squared left")
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])


def _fit(above: Axes, below: Axes, solution: CurveFit) -> None:
    problem = solution.weighted.problem
    seconds = problem.seconds
    size, unit = time_unit(float(np.ptp(seconds)))
    t = seconds / size
    shown = problem.magnitude - solution._zero_points
    above.plot(t, shown, ".", color=DATA, label="observed")
    above.plot(t, shown - solution.residuals, "x", color=MODEL, label="computed", ms=4)
    above.invert_yaxis()
    above.set_ylabel("reduced magnitude")
    above.legend(fontsize=9, loc="best")
    averaged = len(solution.curve) != len(t)
    session = np.zeros(len(t), np.int64) if averaged else solution.curve.session
    for number in np.unique(session):
        chosen = session == number
        below.plot(t[chosen], solution.residuals[chosen], ".", color=f"C{number % 10}")
    below.axhline(0.0, color=OTHER)
    below.invert_yaxis()
    for panel in (above, below):
        panel.set_xlabel(f"{unit} from {_date(solution.curve.epoch, 19)} UTC")
    below.set_ylabel("residual, mag")


def _folded(axes: Axes, solution: Solution, which: int) -> None:
    """The curve folded with a period, without the lines of the series that have the other one.

    Of several apparitions that with most points: in each the body shows another amplitude.
    """
    periods = [solution.P_phi] if solution.is_axial else [solution.P_phi, solution.P_psi]
    if which >= len(periods):
        axes.set_visible(False)
        return
    curve, words = solution.curve, ""
    apparitions = _neighbours.apparitions_of(curve.emission)
    if len(apparitions) > 1:
        curve = curve[max(apparitions, key=len)]
        words = f", {_date(curve.epoch, 10)}"
    try:
        folded = _folding.fold(curve, np.array(periods), order=4 if solution.is_axial else 2)
    except AttitudeError:  # fewer points than a series has unknowns
        axes.set_visible(False)
        return
    axes.plot(folded.phase[which], folded.values[which], ".", color=DATA, ms=3)
    draw_series(axes, folded, which)
    size, unit = time_unit(periods[which])
    name = ("P_phi", "P_psi")[which] if len(periods) == 2 else "P"
    axes.set_xlabel(f"phase of {name} = {periods[which] / size:.6g} {unit}{words}")
    axes.set_ylabel("mag, without the other lines" if len(periods) == 2 else "mag")
