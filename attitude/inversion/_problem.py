"""A light curve as numbers: scaled epochs, directions, magnitudes, and projected-out terms.

Epochs are in units of the span, from the middle, so that rates are turns per span.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._support.arrays import parted, units
from attitude._support.constants import GAP_OF_NIGHTS_S, OPPOSITION_SURGE_RAD
from attitude._support.least_squares import Decomposed
from attitude.errors import AttitudeError
from attitude.inversion._settings import DEFAULT, Settings, Tally
from attitude.photometry._curve import WAYS, LightCurve, angle_between

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray, IntArray


# Nodes of exposures whose body turns by up to some 0.3 of a turn: an error below 1e-4 of the
# brightness (tests/inversion/test_exposures.py).
_NODES = 5
# Nodes where fits are only ranked: the mean of a wave of 0.4 turns to 1 %.
_FEW_NODES = 2
# Exposures, in spans, that are shorter than this have one node.
_INSTANT = 1e-9
# Eigenvalues of the scaled linear terms, relative to 1, below which a combination is a copy.
_COPY = 1e-10


@cache
def _quadrature(count: int) -> tuple[FloatArray, FloatArray]:
    """Nodes from -1 to 1, and weights, of Gauss and Legendre."""
    return np.polynomial.legendre.leggauss(count)


def inverse_factor(
    terms: FloatArray, prior: FloatArray, is_local: BoolArray
) -> tuple[FloatArray, int]:
    """W (L, K) with W W^T the inverse of B^T B + V^-1, and how many of its columns are local.

    These are the first ones: one for each local term that shares no point with another one, so that
    B W is zero there but for the points of the term, by the first of them.

    Given
        terms     B (N, L), weighted
        prior     (L,) roots of the diagonal of V
        is_local  (L,) terms that may be local: those of one session, say
    """
    inner = terms.T @ terms + np.diag(1.0 / prior**2)
    apart = _without_common_points(terms, np.flatnonzero(is_local))
    others = np.setdiff1d(np.arange(len(prior)), apart)
    diagonal, crossed = inner[apart, apart], inner[np.ix_(apart, others)]
    shares = crossed / diagonal[:, None]
    of_others = inner[np.ix_(others, others)]
    # against their size before the local terms: what these take off whole is a copy
    scale = np.sqrt(np.diag(of_others))
    factor = Decomposed(of_others - crossed.T @ shares, scale).inverse_factor(_COPY)
    out = np.zeros((len(prior), len(apart) + factor.shape[1]))
    out[apart, np.arange(len(apart))] = 1.0 / np.sqrt(diagonal)
    out[apart, len(apart) :] = -shares @ factor
    out[others, len(apart) :] = factor
    return out, len(apart)


def _without_common_points(terms: FloatArray, local: IntArray) -> IntArray:
    """Those of some terms (N, L) that share no point with one before, by their first point."""
    has = terms != 0.0
    taken, chosen = np.zeros(len(terms), bool), []
    # a zero point and a slope of one night are not at right angles
    for k in local:
        if not np.any(taken & has[:, k]):
            chosen.append(k)
            taken |= has[:, k]
    numbers = np.array(chosen, int)
    return numbers[np.argsort(has.argmax(axis=0)[numbers], kind="stable")]


@dataclass(frozen=True, eq=False)
class CurveProblem:
    """Magnitudes with weights, and the terms in which they are linear."""

    t: FloatArray  # (N,), epochs of emission from the middle of the span, in spans
    span: float  # s
    sun: FloatArray  # (3, N), unit vectors, ICRF
    observer: FloatArray  # (3, N), as `sun`
    magnitude: FloatArray  # (N,), reduced to unit distances
    sigma: FloatArray  # (N,), of the magnitudes as given
    terms: FloatArray  # (N, L), in which the magnitude is linear
    prior: FloatArray  # (L,), standard deviation of the coefficient of each term; inf: free
    model_error: float  # magnitudes, added to sigma in quadrature
    orbit: float = 0.0  # turns per span of the series of a moon's orbit, the last terms; 0: none
    settings: Settings = DEFAULT
    # The work done on this and on all problems that were made from it.
    tally: Tally = field(default_factory=Tally)
    exposure: FloatArray | None = None  # (N,), spans, over which the brightness is averaged, if any
    nodes: int = _NODES  # of each exposure
    # The number (N,) of the session and filter of each point; by default all are of one.
    series: IntArray = field(default_factory=lambda: np.zeros(0, int))

    def __post_init__(self) -> None:
        if not len(self.series):
            object.__setattr__(self, "series", np.zeros(len(self.t), int))
        for name in ("t", "sun", "observer"):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name)))

    @property
    def errors(self) -> FloatArray:
        """Errors (N,) of the magnitudes, that of the model in quadrature."""
        return np.hypot(self.sigma, self.model_error)

    @cached_property
    def root(self) -> FloatArray:
        """Roots (N,) of the weights."""
        return 1.0 / self.errors

    @cached_property
    def bisector(self) -> FloatArray:
        """Unit vectors (3, N) between the directions to Sun and observer."""
        total = self.sun + self.observer
        return np.asarray(total / np.linalg.norm(total, axis=0), np.float64)

    @cached_property
    def u(self) -> FloatArray:
        """Combinations (K, N) of weighted terms whose squares are what coefficients take up.

        Marginal over coefficients of variance V: I - B (V^-1 + B^T B)^-1 B^T.
        """
        weighted = self.terms * self.root[:, None]
        return np.ascontiguousarray((weighted @ self._inverse(weighted)).T)

    def _inverse(self, weighted: FloatArray) -> FloatArray:
        """That of `inverse_factor`, where terms of less than half of the points are local."""
        count = np.count_nonzero(weighted, axis=0)
        return inverse_factor(weighted, self.prior, (count > 0) & (2 * count < len(self)))[0]

    @cached_property
    def y(self) -> FloatArray:
        """Magnitudes (N,) less their mean, since a constant is a free term of every curve."""
        return self.magnitude - np.average(self.magnitude, weights=self.root**2)

    def with_model_error(self, model_error: float) -> CurveProblem:
        """The same magnitudes with another model error."""
        return replace(self, model_error=model_error)

    def with_errors(self, sigma: FloatArray) -> CurveProblem:
        """The same magnitudes with other errors (N,) and this model error."""
        return replace(self, sigma=sigma)

    def with_weights(self, weights: FloatArray) -> CurveProblem:
        """The same magnitudes, whose squared errors are divided by weights (N,)."""
        size = self.errors / np.sqrt(weights)
        # the model error stays: sigma takes up what the weights change
        sigma = np.sqrt(np.maximum(size**2 - self.model_error**2, self.sigma**2))
        return self.with_errors(sigma)

    def with_terms(self, terms: FloatArray, prior: FloatArray, orbit: float) -> CurveProblem:
        """The same magnitudes with the series (N, M) of an orbit, of standard deviations (M,)."""
        return replace(
            self,
            terms=np.concatenate([self.terms, terms], axis=1),
            prior=np.concatenate([self.prior, prior]),
            orbit=orbit,
        )

    def part(self, chosen: BoolArray | IntArray) -> CurveProblem:
        """Some of the points alone, by a mask (N,) or numbers."""
        return replace(
            self,
            t=self.t[chosen],
            sun=self.sun[:, chosen],
            observer=self.observer[:, chosen],
            magnitude=self.magnitude[chosen],
            sigma=self.sigma[chosen],
            terms=self.terms[chosen],
            exposure=None if self.exposure is None else self.exposure[chosen],
            series=self.series[chosen],
        )

    def __len__(self) -> int:
        return len(self.t)

    @property
    def seconds(self) -> FloatArray:
        """Epochs (N,) of emission, s from the middle of the span."""
        return self.t * self.span

    def with_few_nodes(self) -> CurveProblem:
        """The problem with few nodes of its exposures, by which fits are ranked."""
        return self if self.exposure is None else replace(self, nodes=_FEW_NODES)

    @cached_property
    def at_nodes(self) -> CurveProblem:
        """The problem at nodes of the exposures, (K, N) in a row, if any; vectors of the middle."""
        if self.exposure is None or float(self.exposure.max()) < _INSTANT:
            return self
        places, _ = _quadrature(self.nodes)
        t = self.t + 0.5 * places[:, None] * self.exposure
        sun, observer = (np.tile(vectors, self.nodes) for vectors in (self.sun, self.observer))
        series = np.tile(self.series, self.nodes)
        nodes = t.reshape(-1)
        return replace(self, t=nodes, sun=sun, observer=observer, exposure=None, series=series)

    def mean_magnitudes(self, magnitude: FloatArray) -> FloatArray:
        """Magnitudes (..., N) of the mean fluxes, from those (..., K N) at the nodes."""
        if magnitude.shape[-1] == len(self):
            return magnitude
        at = magnitude.reshape(*magnitude.shape[:-1], self.nodes, -1)
        _, weights = _quadrature(self.nodes)
        flux = np.sum(0.5 * weights[:, None] * 10.0 ** (-0.4 * at), axis=-2)
        return -2.5 * np.log10(flux)

    def shares(self, magnitude: FloatArray) -> FloatArray | None:
        """Shares (K, N) of nodes with magnitudes (K N,) in fluxes of exposures; None without any.

        Derivatives of magnitudes of mean fluxes are sums of those at nodes times these.
        """
        if len(magnitude) == len(self):
            return None
        at = magnitude.reshape(self.nodes, -1)
        _, weights = _quadrature(self.nodes)
        share = 0.5 * weights[:, None] * 10.0 ** (-0.4 * (at - self.mean_magnitudes(magnitude)))
        return np.asarray(share, np.float64)

    def projected(self, rows: FloatArray) -> FloatArray:
        """Weighted rows (..., N), the linear terms taken off."""
        weighted = rows * self.root
        return weighted - (weighted @ self.u.T) @ self.u

    def coefficients(self, model: FloatArray) -> FloatArray:
        """Coefficients (L,) of the linear terms for model magnitudes (N,)."""
        b = self.terms * self.root[:, None]
        inverse = self._inverse(b)
        return inverse @ (inverse.T @ (b.T @ ((self.magnitude - model) * self.root)))

    def offsets(self, model: FloatArray) -> FloatArray:
        """Zero points (S,), mag, of the calibrated sessions for model magnitudes (N,)."""
        return self.coefficients(model)[self.prior == CALIBRATED]

    @property
    def detrended(self) -> FloatArray:
        """Magnitudes (N,) without the linear terms that fit them best."""
        return self.magnitude - self.terms @ self.coefficients(np.zeros(len(self)))

    def chi_squared(self, model: FloatArray) -> float:
        """Sum of squares of weighted residuals, least over the coefficients."""
        r = (self.magnitude - model) * self.root
        along = self.u @ r
        return float(r @ r - along @ along)


# ---- The `CurveProblem` of a light curve: scaled epochs, linear terms, points binned if too many

LEAST_POINTS: int = 20
# Errors, mag, that are assumed where none are given: of nights, and of surveys beside them, in a
# curve without any; their scatter is far larger (Hanus & Durech, Planet. Space Sci. 73, 75, 2012).
UNKNOWN_SIGMA: float = 0.02
_OF_SURVEY = 0.1
# Points a night that a survey has at most.
_FEW_A_NIGHT = 4.0
# Standard deviation, mag, of the zero points of sessions whose magnitudes share one system.
CALIBRATED: float = 0.1
# The share of points that have the brightest magnitude exactly, from which they may be saturated.
_SATURATED = 0.05
# Standard deviation of the fitted zero points, mag, above which they are taken as free.
_UNCALIBRATED = 0.15
# Points of a search; more are averaged.
MOST_POINTS = 2500
# Phase angle over which its slope and its curvature count.
_WIDE = np.radians(50.0)
# Standard deviation of the curvature over that angle, mag.
_CURVATURE = 0.5
# Standard deviation of a drift in half the span, mag.
_DRIFT = 0.05
# Standard deviations of the terms of the phase angle and of the epoch.
_PHASE_WIDTHS = (np.inf, np.inf, _CURVATURE, _DRIFT)
# Standard deviation, mag over the wide one, of the slope of a filter from that of all: phase
# reddening of 0.003 mag a degree.
_REDDENING = 0.15


def usable(curve: Any) -> LightCurve:
    """The light curve as magnitudes, all with errors; AttitudeError without geometry.

    Notes say what errors were assumed, and that points may be saturated.
    """
    if not isinstance(curve, LightCurve):
        raise AttitudeError(
            f"curve is {validation.shown(curve)}; give a LightCurve, such as LightCurve.read(file)."
        )
    if not curve.has_geometry:
        raise AttitudeError(
            "the light curve has no geometry, which an inversion needs: the directions of Sun and "
            f"observer at each epoch. Give {WAYS}, as in "
            'LightCurve.read(file, path="orbit.oem", site="568").'
        )
    count, spread = len(curve), curve.emission  # of dates at a barycenter: an error
    if count < LEAST_POINTS:
        raise AttitudeError(
            f"the light curve has {count} points at different epochs; give at least "
            f"{LEAST_POINTS}, better some hundred."
        )
    if not np.ptp(spread) > 0.0:
        raise AttitudeError("all points are of one epoch; give a longer light curve.")
    magnitude, errors = np.array(curve.magnitude), np.array(curve.magnitude_sigma)
    notes = list(curve.notes)
    unknown = ~(errors > 0.0)
    if np.any(unknown):
        known = errors[~unknown]
        assumed = max(UNKNOWN_SIGMA, float(np.median(known)) if len(known) else 0.0)
        errors[unknown] = assumed
        of_survey = _beside_nights(curve) & (len(known) == 0)
        errors[of_survey] = _OF_SURVEY
        surveys = np.count_nonzero(of_survey)
        more = f", {_OF_SURVEY:.3f} mag for {surveys} of surveys" if surveys else ""
        notes.append(
            f"{np.count_nonzero(unknown)} of {count} points have no error; {assumed:.3f} mag is "
            f"assumed{more}."
        )
    brightest = np.count_nonzero(magnitude == magnitude.min())
    if brightest >= 5 and brightest > _SATURATED * count and np.ptp(magnitude) > 0.0:
        notes.append(
            f"{brightest} points share the brightest magnitude {magnitude.min():.3f} exactly, as "
            "saturated ones do; leave such points out."
        )
    return curve.replaced(magnitude=magnitude, sigma=errors, notes=notes)


def _beside_nights(curve: LightCurve) -> BoolArray:
    """Which points (N,) are of sessions with few a night, where others have many."""
    sparse = np.zeros(len(curve), bool)
    for label in np.unique(curve.session):
        session = curve.session == label
        nights = len(parted(curve.emission[session], GAP_OF_NIGHTS_S))
        sparse |= session & (nights > 1) & (np.count_nonzero(session) <= _FEW_A_NIGHT * nights)
    return sparse & (np.count_nonzero(~sparse) >= LEAST_POINTS)


def problem(
    curve: LightCurve,
    most_frequency: float,
    error: float,
    zero_points: Any,
    *,
    is_known: bool = False,
    settings: Settings = DEFAULT,
    tally: Tally | None = None,
) -> tuple[CurveProblem, list[str]]:
    """The problem of a curve, error in mag, and a sentence where its points are averaged."""
    span = curve.span
    bins = _bins(curve, most_frequency)
    values = _averaged(curve, bins)
    t = values["emission"] / span
    terms = common_terms(curve, values["alpha"], t, values["filter"], is_known=is_known)
    prior = [] if is_known else [*_PHASE_WIDTHS]
    prior += [np.inf] * len(curve.filters)
    prior += [_REDDENING] * (len(terms) - len(prior))
    for k, width in enumerate(session_widths(curve, zero_points)):
        if width > 0.0:
            terms.append((values["session"] == k).astype(float))
            prior.append(width)
    free = int(np.count_nonzero(np.isinf(prior)))
    if free >= len(t):
        raise AttitudeError(
            f"the light curve has {len(t)} points, and its {free} free zero points and phase terms "
            "fit any brightness; give fewer filters, or fewer sessions with free zero points."
        )
    whole_problem = CurveProblem(
        t=t,
        span=span,
        sun=values["sun"].T,
        observer=values["observer"].T,
        magnitude=values["reduced"],
        sigma=values["sigma"],
        terms=np.stack(terms, axis=-1),
        prior=np.array(prior),
        model_error=error,
        settings=settings,
        tally=Tally() if tally is None else tally,
        exposure=values["exposure"] / span if np.any(values["exposure"]) else None,
        series=values["session"] * len(curve.filters) + values["filter"],
    )
    if bins is None or len(whole_problem) == len(curve):
        return whole_problem, []
    return whole_problem, [f"{len(curve)} points were averaged to {len(whole_problem)}."]


def interpolated(
    curve: LightCurve, epochs: FloatArray, t: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Vectors (T, 3) to Sun and observer at epochs (T,), from those of the points (N,)."""
    known, first = np.unique(epochs, return_index=True)
    sun, observer = (
        np.stack([np.interp(t, known, vectors[first, k]) for k in range(3)], axis=1)
        for vectors in curve.vectors
    )
    return sun, observer


def are_free(offsets: FloatArray) -> bool:
    """Whether fitted zero points (S,), mag, are those of sessions that share no system."""
    return bool(len(offsets) > 2 and offsets.std() > _UNCALIBRATED)


def common_terms(
    curve: LightCurve, alpha: FloatArray, t: FloatArray, filter: IntArray, *, is_known: bool
) -> list[FloatArray]:
    """Terms (N,) in which magnitudes of all sessions are linear.

    Of the phase angle (rad) and the epoch (spans), but for a known law; of each filter, and where
    there are several its slope with the phase angle.
    """
    in_filters = [(filter == k).astype(float) for k in range(len(curve.filters))]
    if is_known:
        return in_filters
    slope = alpha / _WIDE
    terms = [slope, np.exp(-alpha / OPPOSITION_SURGE_RAD), slope**2, 2.0 * t, *in_filters]
    if len(in_filters) > 1:
        terms += [slope * in_filter for in_filter in in_filters]
    return terms


def filter_columns(curve: LightCurve, *, is_known: bool) -> slice:
    """Which of the `common_terms` are those of the filters."""
    first = 0 if is_known else len(_PHASE_WIDTHS)
    return slice(first, first + len(curve.filters))


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
        return np.array([np.inf if session in zero_points else 0.0 for session in curve.sessions])
    return np.full(count, float(zero_points))


def _bins(curve: LightCurve, most_frequency: float) -> IntArray | None:
    """The number of the average of each point; None if all points are taken."""
    if len(curve) <= MOST_POINTS:
        return None
    width = min(1.0 / (40.0 * most_frequency), curve.span / MOST_POINTS)
    while True:
        cell = np.floor((curve.emission - curve.emission.min()) / width).astype(np.int64)
        keys = (cell * len(curve.sessions) + curve.session) * len(curve.filters) + curve.filter
        numbers = np.unique(keys, return_inverse=True)[1].reshape(-1)
        if numbers.max() < 2 * MOST_POINTS or width > 1.0 / (12.0 * most_frequency):
            return numbers.astype(np.int64)
        width *= 1.3


def _averaged(curve: LightCurve, bins: IntArray | None) -> dict[str, Any]:
    """Columns of the points of a curve, or of their averages."""
    values: dict[str, Any] = {
        "emission": curve.emission,
        "reduced": curve.reduced_magnitude,
        "sigma": curve.sigma,
        "session": curve.session,
        "filter": curve.filter,
        "exposure": curve.exposure,
        "sun": units(curve.vectors[0]),
        "observer": units(curve.vectors[1]),
    }
    if bins is not None:
        weight = 1.0 / curve.sigma**2
        total = np.bincount(bins, weight)
        first = np.unique(bins, return_index=True)[1]
        for name in ("emission", "reduced"):
            values[name] = np.bincount(bins, weight * values[name]) / total
        for name in ("sun", "observer"):
            mean = [np.bincount(bins, weight * component) / total for component in values[name].T]
            values[name] = units(np.stack(mean, axis=1))
        values["sigma"] = 1.0 / np.sqrt(total)
        for name in ("session", "filter", "exposure"):
            values[name] = values[name][first]
        order = np.argsort(values["emission"], kind="stable")
        values = {name: column[order] for name, column in values.items()}
    values["alpha"] = angle_between(values["sun"], values["observer"])
    return values
