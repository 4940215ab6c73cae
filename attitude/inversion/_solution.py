"""What an inversion returns: solutions, each with motion, errors, shape and predictions."""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, cast, overload

import numpy as np

from attitude._support import markup, quantity_text, validation
from attitude._support.arrays import Immutable, frozen, units
from attitude._support.constants import DAY_S, SPEED_OF_LIGHT_M_S
from attitude._support.least_squares import inverse
from attitude._support.quantity_text import TIME_UNITS
from attitude._support.synonyms import Answering
from attitude._textfiles.lines import path_text
from attitude.epochs import _inputs, _instants
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.inversion import (
    _errors,
    _neighbours,
    _problem,
    _refinement,
    _satellites,
    _shapes,
    _states,
    _verdicts,
)
from attitude.inversion._ellipsoid import SearchState, is_axial
from attitude.inversion._shapes import sphere
from attitude.motions._free_rotation import FreeRotation
from attitude.paths import _places
from attitude.photometry._curve import LightCurve, angle_between, dimming
from attitude.scene._scene import Scene

if TYPE_CHECKING:
    from collections.abc import Iterator

    from astropy.table import QTable
    from astropy.time import Time
    from matplotlib.figure import Figure

    from attitude._support.annotations import Epochs, FilePath, FloatArray, IntArray
    from attitude._support.tables import FlatTable
    from attitude.inversion._errors import GroupErrors
    from attitude.inversion._evidence import Robust, Weighted
    from attitude.inversion._moving import Motion
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._shapes import Tie
    from attitude.inversion._states import Posterior
    from attitude.motions._published import Published
    from attitude.paths._path import Path
    from attitude.scattering._law import Law
    from attitude.shape._mesh import Mesh


# ---- Magnitudes that a solution predicts, with the errors of motion, shape and zero points


@dataclass(frozen=True, eq=False, repr=False)
class Prediction(Immutable):
    """Magnitudes that a fit predicts; unpacks as ``magnitude, sigma = best.predict(dates)``.

    Attributes
    ----------
    epoch : Instant
        Of the curve.
    seconds : (T,) array
        TDB s from it, of reception (of emission, where the curve has those).
    magnitude : (T,) array
        Apparent magnitudes, or at 1 au where those of the curve are.
    sigma : (T,) array
        Standard errors: of the motion, the shape, the zero points, the phase terms and the model.
    form : (T,) array
        Of them, the errors about the mean of the night (of all epochs, where nights have less than
        three): those of the form of the light curve.
    level : (T,) array
        The error of that mean.
    sun, observer : (T, 3) arrays
        Vectors from the body, m, ICRF.
    filter : (T,) array of int
        Numbers into the filters of the curve that was fitted.
    colour : (T,) array
        Magnitudes in these filters less those in the filter of the first epoch.
    fit : CurveFit
    """

    epoch: Instant
    seconds: FloatArray
    magnitude: FloatArray
    sigma: FloatArray
    form: FloatArray
    level: FloatArray
    sun: FloatArray
    observer: FloatArray
    filter: IntArray
    colour: FloatArray
    fit: CurveFit

    def __iter__(self) -> Iterator[FloatArray]:
        return iter((self.magnitude, self.sigma))

    @property
    def times(self) -> Time:
        """The epochs (T,) as an astropy Time in TDB."""
        return _instants.times(self.epoch, self.seconds)

    @property
    def phase_angle(self) -> FloatArray:
        """Angle (T,) at the body between Sun and observer, rad."""
        return angle_between(self.sun, self.observer)

    def table(self) -> QTable:
        """A row for each epoch: UTC, magnitude, errors, phase angle."""
        from astropy import units
        from astropy.table import QTable

        time = self.times.utc
        time.format = "isot"
        table = QTable({"time": time, "magnitude": self.magnitude * units.mag})
        for key in ("sigma", "form", "level"):
            table[key] = getattr(self, key) * units.mag
        table["phase_angle"] = np.degrees(self.phase_angle) * units.deg
        return table

    def plot(self, path: FilePath | None = None, *, observed: LightCurve | None = None) -> Figure:
        """A figure with a panel a night: the model as a line with its error, points if given.

        Parameters
        ----------
        path : str or path, optional
            Where it is saved.
        observed : LightCurve, optional
            Points that were observed at these nights, with their residuals below.
        """
        from attitude.inversion import _figures

        return _figures.of_prediction(self, path, observed)

    def __repr__(self) -> str:
        return (
            f"<Prediction of {len(self.seconds)} magnitudes from {self.times[0].utc.isot[:16]} "
            f"UTC: form to {np.median(self.form):.3f} mag, level to {np.median(self.level):.3f} "
            "mag>"
        )


def _exposures(
    curve: LightCurve, times: Epochs | LightCurve | None, count: int, span: float
) -> FloatArray | None:
    """Exposures (T,), spans: those of a curve, or the usual one of the curve that was fitted."""
    if times is None or isinstance(times, LightCurve):
        return (curve if times is None else times).exposure / span
    return np.full(count, float(np.median(curve.exposure)) / span)


def _factor(covariance: FloatArray) -> FloatArray:
    """F (P, P) with F F^T the covariance, of which rounding may have left eigenvalues below 0."""
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    return vectors * np.sqrt(np.maximum(values, 0.0))


def _geometry(
    curve: LightCurve,
    times: Epochs | LightCurve | None,
    path: Path | str | None,
    site: Path | str | None,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Seconds of reception and of emission, (T,), and vectors (T, 3) to Sun and observer."""
    if times is None:
        return curve.seconds, curve.emission, *curve.vectors
    if isinstance(times, LightCurve):
        if path is not None or site is not None:
            raise AttitudeError(
                "a light curve is given with path= or site=, but has a geometry of its own; give "
                "its times, as in predict(curve.times, path=orbit)."
            )
        shift = times.epoch.seconds - curve.epoch.seconds
        return times.seconds + shift, times.emission + shift, *times.vectors
    t = np.atleast_1d(_inputs.seconds_since(curve.epoch, times).rounded)
    if path is not None or curve.scenes:
        return _of_scene(_scene(curve, path, site), curve, t)
    if site is not None:
        raise AttitudeError(
            "site is given, but the curve has vectors in place of a path; give path= too."
        )
    _refuse_unknown(curve, t)
    sun, observer = _problem.interpolated(curve, curve.seconds, t)
    late = float(np.median(curve.seconds - curve.emission))
    light = np.linalg.norm(observer, axis=1) / SPEED_OF_LIGHT_M_S if late > 0.0 else 0.0
    return t, t - light, sun, observer


def _of_scene(
    scene: Scene, curve: LightCurve, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """What `_geometry` returns, at times (T,) of light where those of the curve are."""
    ordered, order = np.unique(t, return_inverse=True)
    seen = LightCurve(
        ordered,
        np.zeros(len(ordered)),
        epoch=curve.epoch,
        scene=scene,
        time_of=curve.time_of,
        light_time=scene.light_time,
    )
    emission = seen.emission + (seen.epoch.seconds - curve.epoch.seconds)
    sun, observer = seen.vectors
    return t, emission[order], sun[order], observer[order]


# Gap between two points of a curve, s, in whose middle vectors are interpolated, as near to points
# of wider gaps: as far as the Earth bends its way, those of a body at 1 au are off by 0.1 degrees.
_GAP = 7.0 * DAY_S
# The angle between their directions up to which they are interpolated.
_TURN = math.radians(20.0)


def _refuse_unknown(curve: LightCurve, t: FloatArray) -> None:
    """Refuse epochs (T,) outside of a curve with vectors, and in gaps too wide to interpolate."""
    known, first = np.unique(curve.seconds, return_index=True)
    after = np.clip(np.searchsorted(known, t), 0, len(known) - 1)
    before = np.clip(np.searchsorted(known, t, "right") - 1, 0, len(known) - 1)
    outside = (t < known[0]) | (t > known[-1])
    in_gap = (t - known[before]) * (known[after] - t) > (0.5 * _GAP) ** 2
    for vectors in curve.vectors:
        in_gap |= angle_between(vectors[first[before]], vectors[first[after]]) > _TURN
    for is_unknown, where in (
        (outside, "outside of the light curve, whose geometry, given as vectors, ends there"),
        (in_gap, "in a gap of the light curve, too wide to interpolate its vectors"),
    ):
        if np.any(is_unknown):
            count, epoch = np.count_nonzero(is_unknown), curve.epoch.after(t[is_unknown][0])
            words = f", one of {count}," if count > 1 else ""
            raise AttitudeError(
                f"the epoch {epoch.utc_iso[:19]} UTC{words} lies {where}; give path= (the orbit) "
                'and site=, as in predict(dates, path="orbit.oem", site="568").'
            )


def _scene(curve: LightCurve, path: Path | str | None, site: Path | str | None) -> Scene:
    """The scene of a site, by default that of most points, and of the body or of a path."""
    name = curve.sites[int(np.argmax(np.bincount(curve.site)))] if site is None else site
    of_site = curve.scenes.get(name) if isinstance(name, str) else None
    if path is None and of_site is not None:
        return of_site
    if of_site is not None:
        place: Any = of_site.observer
    else:
        place = _places.place("earth" if name == "" else name, "site", is_observer=True)
    if path is not None:
        body: Any = _places.place(path, "path")
        return Scene(None, body, place)
    scene = next(iter(curve.scenes.values()))
    return Scene(
        None,
        scene.center,
        place,
        scene.sun,
        light_time=scene.light_time,
        ephemeris=scene.ephemeris,
    )


def _filters(
    curve: LightCurve, times: Epochs | LightCurve | None, filter: str | None, count: int
) -> IntArray:
    """The number of the filter of each epoch (T,): the one given, or that of the point, or 0."""
    if filter is not None:
        validation.one_of(filter, "filter", curve.filters)
        return np.full(count, curve.filters.index(filter))
    points = curve if times is None else times
    if not isinstance(points, LightCurve):
        return np.zeros(count, np.int64)
    numbers = {name: number for number, name in enumerate(curve.filters)}
    return np.array([numbers.get(points.filters[k], 0) for k in points.filter])


def _terms(
    solution: CurveFit, emission: FloatArray, alpha: FloatArray, filters: IntArray
) -> FloatArray:
    """Linear terms (T, L) at other epochs, in filters (T,) by their numbers.

    Zero points are those that sessions share, or the mean of a filter whose sessions share none.
    """
    curve, fitted_problem = solution.curve, solution.weighted.problem
    t = emission / fitted_problem.span
    common = _problem.common_terms(curve, alpha, t, filters, is_known=solution._is_known)
    terms = np.zeros((len(emission), fitted_problem.terms.shape[1]))
    terms[:, : len(common)] = np.stack(common, axis=-1)
    columns = _problem.filter_columns(curve, is_known=solution._is_known)
    of_filters = fitted_problem.terms[:, columns]
    is_free = np.isinf(fitted_problem.prior)
    is_free[: len(common)] = False
    for number in np.unique(filters):
        shares = fitted_problem.terms[of_filters[:, number] > 0.0].mean(axis=0)
        if np.isclose(shares[is_free].sum(), 1.0):
            terms[np.ix_(filters == number, is_free)] = shares[is_free]
    if fitted_problem.orbit:
        series = _satellites.changing(fitted_problem.orbit, t)
        terms[:, -series.shape[1] :] = series
    return terms


# ---- What every fit to a light curve has: residuals, shape, law, predictions, a spin file


class CurveFit(Answering, ABC):
    """A motion and a shape that fit a light curve: `Solution` and `Refinement`.

    Attributes
    ----------
    curve : LightCurve
    weighted : Weighted
        Parameters, residuals and weights.
    evidence : float
        -2 ln of the posterior density at its maximum, but for a constant; see `Weighted`.
    rank : int
        Among the solutions of a curve, from 0.
    relation : str
        To the best of them, in words.
    """

    # What a spin file says of its origin, and whether shape and law are known.
    _made = "by a fit to a light curve"
    _is_known = False

    def __init__(
        self,
        curve: LightCurve,
        weighted: Weighted[object],
        problem: CurveProblem,
        rank: int,
        relation: str,
    ) -> None:
        self.curve = curve
        self.weighted = weighted
        self._problem = problem
        self.evidence: float = weighted.evidence
        self.rank = rank
        self.relation = relation

    @cached_property
    def shape(self) -> Mesh:
        """The closed convex mesh of the areas, of the volume of the unit sphere, in m."""
        return _shapes.mesh(self.weighted.refined.areas, sphere().normals)

    @property
    def law(self) -> Law:
        """The scattering law without its phase function, which the linear terms replace."""
        return _shapes.LAW

    @property
    def residuals(self) -> FloatArray:
        """Observed less computed magnitudes, in the order of the curve (of averages, if many)."""
        return self.weighted.residual

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, mag."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def chi_squared(self) -> float:
        """Mean square of the residuals over the given errors alone."""
        return float(np.mean((self.residuals / self._problem.sigma) ** 2))

    @property
    @abstractmethod
    def motion(self) -> Motion:
        """With the covariance of its state."""

    @property
    @abstractmethod
    def moments(self) -> FloatArray:
        """(3,) principal moments, ascending, in the unit of the body or relative."""

    @property
    @abstractmethod
    def mode(self) -> str:
        """ "LAM", "SAM", or "PA" for rotation about one axis."""

    @property
    @abstractmethod
    def P_psi(self) -> float:
        """s; infinite for rotation about one axis."""

    @property
    @abstractmethod
    def P_phi(self) -> float:
        """s, of the long axis about the momentum."""

    @property
    @abstractmethod
    def periods_sigma(self) -> tuple[float, float]:
        """Standard errors of P_psi and P_phi (long axis), s."""

    @property
    @abstractmethod
    def pole(self) -> FloatArray:
        """Longitude and latitude of the momentum, J2000 ecliptic, rad."""

    @property
    @abstractmethod
    def pole_sigma(self) -> float:
        """Standard error of the direction of the momentum, rad, the larger of two."""

    def __repr__(self) -> str:
        longitude, latitude = np.degrees(self.pole)
        psi, phi = quantity_text.of_time(self.P_psi), quantity_text.of_time(self.P_phi)
        periods = f"P {phi}" if self.mode == "PA" else f"P_phi(L) {phi}, P_psi {psi}"
        return (
            f"<{type(self).__name__} {self.rank}: {self.mode}, {periods}, pole {longitude:.1f} "
            f"{latitude:+.1f} deg, rms {self.rms:.3f} mag>"
        )

    def _values(self) -> list[tuple[str, str]]:
        """Periods and pole with their standard errors."""
        longitude, latitude = np.degrees(self.pole)
        is_rotation = self.mode == "PA"
        psi, phi = self.periods_sigma
        sigma = math.degrees(self.pole_sigma)
        periods = [("period" if is_rotation else "P_phi (long axis)", (self.P_phi, phi))]
        if not is_rotation:
            periods.append(("P_psi", (self.P_psi, psi)))
        return [
            *((name, _with_error(*period)) for name, period in periods),
            ("pole, ecliptic", f"{longitude:.2f} {latitude:+.2f} deg"),
            (
                "error of the pole",
                f"{sigma:.2g} deg" if sigma < 90.0 else "above 90 deg, the whole sky",
            ),
        ]

    def _words_of_errors(self) -> str:
        """Periods and pole with their standard errors."""
        return ", ".join(" ".join(row) for row in self._values())

    @abstractmethod
    def _model(self, problem: CurveProblem) -> _refinement.ShapeModel:
        """Magnitudes and their derivatives at the epochs of a problem."""

    @property
    @abstractmethod
    def _is_changing(self) -> bool:
        """Whether the motion is that of a free rotation only near its epoch."""

    def predict(
        self,
        times: Epochs | LightCurve | None = None,
        *,
        path: Path | str | None = None,
        site: Path | str | None = None,
        filter: str | None = None,
    ) -> Prediction:
        """Magnitudes at epochs, and their errors, those of form and level apart.

        Parameters
        ----------
        times : epochs, or LightCurve, optional
            Any number of epochs, of reception, or of emission where those of the curve are; plain
            numbers are TDB seconds since ``curve.epoch``, the middle of the curve.  Beyond the
            curve too if it was made with ``path=`` or ``scene=``.  With geometry given as
            vectors, epochs near its points, where it is interpolated: anywhere in gaps of up to
            7 d and 20 degrees.  Or a curve with geometry of its own.  By default the epochs of the
            curve.
        path : Path, name, file or text, optional
            The orbit of the body, in place of the geometry of the curve.
        site : Path or text, optional
            The observer: a site of the curve (by default that of most points), or another place.
        filter : str, optional
            Of the curve.  By default the filter of each point of a light curve, where this curve
            has it, and else the first.

        Returns
        -------
        Prediction
            Which unpacks as magnitude, sigma: (T,) arrays.

        Raises
        ------
        AttitudeError
            For epochs outside of a curve whose geometry is given as vectors, or in its gaps, and
            for other filters.

        Notes
        -----
        Zero points of sessions are left out where a session of the filter shares one; where none
        does, they are at their mean over the points in the filter.
        The phase angle of a prediction may leave the range of the curve: `level` and `form` then
        grow with the errors of the phase terms, as far as these are linear.
        """
        curve = self.curve
        seconds, emission, sun, observer = _geometry(curve, times, path, site)
        if not len(emission):
            raise AttitudeError("times is empty; give at least one epoch.")
        fitted_problem = self.weighted.problem
        filters = _filters(curve, times, filter, len(emission))
        alpha = angle_between(sun, observer)
        terms = _terms(self, emission, alpha, filters)
        by_filter = terms - _terms(self, emission, alpha, np.full_like(filters, filters[0]))
        to_sun, to_observer = (units(vectors).T for vectors in (sun, observer))
        there = replace(
            fitted_problem,
            t=emission / fitted_problem.span,
            sun=to_sun,
            observer=to_observer,
            exposure=_exposures(curve, times, len(emission), fitted_problem.span),
        )
        fitted = self._model(fitted_problem)
        model = self._model(there)
        coefficients = fitted_problem.coefficients(fitted.magnitude)
        magnitude = model.magnitude + terms @ coefficients
        if not curve.unit_distances:
            magnitude += dimming(sun, observer)
        # the linear terms follow the parameters
        b = fitted_problem.terms * fitted_problem.root[:, None]
        normal = b.T @ b + np.diag(1.0 / fitted_problem.prior**2)
        of_terms = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
        follow = -of_terms @ (b.T @ (fitted.jacobian * fitted_problem.root).T)
        # columns whose outer product is the covariance of the magnitudes
        factor = np.concatenate(
            [
                (model.jacobian.T + terms @ follow) @ _factor(self.weighted.refined.covariance),
                terms @ _factor(of_terms),
            ],
            axis=1,
        )
        mean = np.empty_like(factor)
        groups = _neighbours.nights_of(emission)
        if np.median([len(group) for group in groups]) < 3.0:
            groups = [np.arange(len(emission))]
        for night in groups:
            mean[night] = factor[night].mean(axis=0)
        floor = 1.48 * float(np.median(np.abs(self.residuals)))
        return Prediction(
            epoch=curve.epoch,
            seconds=frozen(seconds),
            magnitude=frozen(magnitude),
            sigma=frozen(np.sqrt(np.sum(factor**2, axis=1) + floor**2)),
            form=frozen(np.sqrt(np.sum((factor - mean) ** 2, axis=1) + floor**2)),
            level=frozen(np.linalg.norm(mean, axis=1)),
            sun=sun,
            observer=observer,
            filter=frozen(filters),
            colour=frozen(by_filter @ coefficients),
            fit=self,
        )

    @property
    def _zero_points(self) -> FloatArray:
        """(N,) mag, what filter and session add to a point that is fitted, as `predict` has them.

        That of the first filter is 0, and that of its sessions at their mean.
        """
        problem = self.weighted.problem
        alpha = angle_between(problem.sun.T, problem.observer.T)
        terms = _terms(self, problem.seconds, alpha, np.zeros(len(problem), np.int64))
        return (problem.terms - terms) @ problem.coefficients(self.weighted.refined.magnitude)

    @property
    def _groups(self) -> tuple[IntArray, ...]:
        """Numbers of the groups of points by which errors are found, by several groupings."""
        return _errors.groupings(self._problem.t, self._problem.span, self.curve.session)

    def plot(self, path: FilePath | None = None) -> Figure:
        """A figure with a panel a night: points, model, residuals; saved if a path is given."""
        from attitude.inversion import _figures

        return _figures.of_nights(self, path)

    def write(self, path: FilePath, **labels: Any) -> None:
        """Write the spin file (.toml) of the state with its covariance, shape and scattering law.

        The state is that of a free rotation: a drift, impulses and torques are not stored, and the
        note says so.
        `labels` are name, source and note, as `formats.spin_file.write` takes them.  ``attitude
        view``, ``attitude lightcurve`` and mission files that name the file draw its shape; the
        shape alone is written by ``shape.write("x.obj")``.

        Raises
        ------
        AttitudeError
            For a name that does not end in .toml, and as `formats.spin_file.write`.
        """
        from attitude.formats import _surface, spin_file

        if not path_text(path).lower().endswith(".toml"):
            raise AttitudeError(
                f"{os.fspath(path)!r} is to hold the state, its errors and the shape as a spin "
                "file; give a name that ends in .toml. The shape alone is written by "
                'shape.write("x.obj"), also .txt (DAMIT), .stl and .ply.'
            )
        law = self.law if _surface.has_lines(self.law) else None
        note = labels.pop("note", None) or f"{self._made}: {self!r}, {self._words_of_errors()}."
        if self._is_changing:
            note += " Its motion is no free rotation: the state is that at its epoch alone."
        source = labels.pop("source", None) or "attitude.inversion"
        first = FreeRotation(self.motion.body, self.motion.spin)
        surface = {"shape": self.shape, "law": law}
        spin_file.write(path, first, source=source, note=note, **(surface | labels))


class Solution(CurveFit):
    """One spin state that fits a light curve; made by `spin_states`.

    Attributes
    ----------
    curve, weighted, evidence, rank, relation
        As in `CurveFit`.
    tie : Tie
        Of the moments of motion and shape.
    """

    _made = "by inversion of a light curve"
    weighted: Robust

    def __init__(
        self,
        curve: LightCurve,
        weighted: Robust,
        problem: CurveProblem,
        tie: Tie,
        rank: int,
        relation: str = "best",
        rivals: Sequence[Robust] = (),
    ) -> None:
        super().__init__(curve, weighted, problem, rank, relation)
        self.tie = tie
        # those that compete with it
        self._rivals = rivals

    @property
    def state(self) -> FloatArray:
        """Parameters of the search: elements per span, orientation, ellipsoid, modes of areas."""
        return self.weighted.refined.state

    @property
    def is_axial(self) -> bool:
        """Whether the body rotates about one principal axis."""
        return is_axial(self.state)

    @cached_property
    def motion(self) -> FreeRotation:
        """The free rotation, with the covariance of its state; moments are relative.

        With a drift it is that at the epoch of the curve, its middle.
        """
        return _states.motion(
            self.state, self.curve.span, self.curve.epoch, self.covariance, self.tie.moments
        )

    @property
    def moments(self) -> FloatArray:
        """(3,) relative principal moments, ascending."""
        return np.sort(_states.physical(self.state, self.tie.moments).moments)

    @cached_property
    def _covariances(self) -> tuple[FloatArray, GroupErrors]:
        with _refinement.limited():
            return _states.covariance(self.weighted, self._groups, self.tie, self._rivals)

    def _errors_of(self, solution: Robust) -> GroupErrors:
        """The covariances of the parameters of the motion of this solution, or of a rival."""
        if solution is self.weighted:
            return self._covariances[1]
        with _refinement.limited():
            return _states.covariance(solution, self._groups, self.tie)[1]

    @property
    def covariance(self) -> FloatArray:
        """(9, 9) of the rotation vector (rad, ICRF axes), rates (rad/s, body axes) and moments."""
        scale = np.ones(9)
        scale[3:6] = 1.0 / self.curve.span
        return self._covariances[0] * np.outer(scale, scale)

    def published(self, convention: str = "L", frame: str = "ecliptic") -> Published:
        """The state in the form of papers; see `FreeRotation.published`."""
        return self.motion.published(convention, frame=frame)

    @property
    def mode(self) -> str:
        """ "LAM", "SAM", or "PA" for rotation about one axis."""
        return (
            "PA" if self.is_axial else "LAM" if SearchState.of(self.state).nutation > 0.0 else "SAM"
        )

    @property
    def P_psi(self) -> float:
        """s; infinite for rotation about one axis."""
        psi = SearchState.of(self.state).rates[1]
        return self.curve.span / psi if psi > 0.0 else math.inf

    @property
    def P_phi(self) -> float:
        """s, of the long axis about the momentum; the period of rotation about one axis."""
        return self.curve.span / SearchState.of(self.state).rates[0]

    @property
    def drift(self) -> FloatArray:
        """(2,) how fast the frequencies 1/P_phi (long axis) and 1/P_psi change, 1/s^2.

        Zeros where no drift was searched.
        """
        return self._frequencies_by @ _refinement.drift_of(self.state) / self.curve.span**2

    @property
    def _is_changing(self) -> bool:
        return bool(np.any(self.drift))

    @property
    def drift_sigma(self) -> FloatArray:
        """(2,) standard errors of `drift`: of the curvature, widened as those of the rates are."""
        begin, normal = _refinement.SIZE, self.weighted.refined.normal
        if len(normal) == begin:
            return np.zeros(_refinement.DRIFT)
        curvature = inverse(normal)
        rates = slice(_refinement.PRECESSION, _refinement.NUTATION + 1)
        wider = np.diag(self._covariances[1].covariance)[rates] / np.diag(curvature)[rates]
        inner = float(wider.max()) * curvature[begin:, begin:]
        by = self._frequencies_by
        return np.sqrt(np.diag(by @ inner @ by.T)) / self.curve.span**2

    @property
    def _frequencies_by(self) -> FloatArray:
        """Derivatives (2, 2) of the frequencies of phi and psi by precession and nutation."""
        nutation = 1.0 if SearchState.of(self.state).nutation > 0.0 else -1.0
        return np.array([[2.0, -max(nutation, 0.0)], [0.0, nutation]])

    @property
    def periods_sigma(self) -> tuple[float, float]:
        """Standard errors of P_psi and P_phi (long axis), s."""
        c = self._covariances[1].covariance
        phi, psi = SearchState.of(self.state).rates
        if self.is_axial:
            sigma = math.sqrt(c[_refinement.PRECESSION, _refinement.PRECESSION])
            return math.inf, 2.0 * sigma * self.curve.span / phi**2
        by, rates = self._frequencies_by, slice(_refinement.PRECESSION, _refinement.NUTATION + 1)
        of_phi, of_psi = np.sqrt(np.diag(by @ c[rates, rates] @ by.T)).tolist()
        return of_psi * self.curve.span / psi**2, of_phi * self.curve.span / phi**2

    @property
    def pole(self) -> FloatArray:
        """Longitude and latitude of the momentum, J2000 ecliptic, rad."""
        from attitude.frames import matrix_to_icrf

        x, y, z = matrix_to_icrf("ecliptic").T @ SearchState.of(self.state).pole
        return np.array([math.atan2(y, x) % (2.0 * math.pi), math.asin(max(-1.0, min(1.0, z)))])

    @property
    def pole_sigma(self) -> float:
        """Standard error of the direction of the momentum, rad, the larger of two."""
        inner = self._covariances[1].covariance[_refinement.TILT, _refinement.TILT]
        return math.sqrt(float(np.linalg.eigvalsh(inner)[-1]))

    def sample(self, count: int, seed: int | np.random.Generator = 0) -> list[FreeRotation]:
        """Motions drawn from the errors of the five elements and of axes along the momentum.

        In these the posterior is nearly normal: periods scatter by `periods_sigma`, attitudes by
        the standard deviations of ``motion``.  Draws of the latter, in rates and moments, scatter
        more.  Draws that are no body's are drawn anew; an AttitudeError if 9 of 10 are.
        """
        return _states.drawn(self, count, seed)

    def posterior(
        self, method: str = "emcee", *, walkers: int = 32, steps: int = 600, seed: int = 0
    ) -> Posterior:
        """Samples of the motion from this solution and those that compete with it.

        Parameters
        ----------
        method : str
            "emcee", which the extra "posterior" installs.
        walkers, steps : int
            Of each ensemble; the first quarter of the steps is left out.
        seed : int

        Raises
        ------
        AttitudeError
            If emcee is not installed, and for rotation about one axis.
        """
        return _states.sampled(self, method, walkers, steps, seed)

    def _model(self, problem: CurveProblem) -> _refinement.ShapeModel:
        """Magnitudes and their derivatives at the epochs of a problem."""
        return _refinement.model(problem, self.state)

    def _repr_html_(self) -> str:
        """A table for notebooks, the fit and the shape."""
        rows = [("rank, relation", f"{self.rank}, {self.relation}"), ("mode", self.mode)]
        rows += [
            *self._values(),
            ("moments", " : ".join(f"{moment:.4g}" for moment in self.moments / self.moments[0])),
            ("rms", f"{self.rms:.4f} mag"),
        ]
        t = self.weighted.problem.t
        days = (t - t.min()) * self.curve.span / TIME_UNITS["d"]
        fit = markup.line_plot(
            [(days, self.residuals)],
            f"residuals over {np.ptp(days):.4g} d, {np.ptp(self.residuals):.3g} mag in all",
            is_downward=True,
            is_dotted=True,
        )
        shape = markup.solid(self.shape.corners, self.shape.normals, "shape, from x, y, z > 0")
        return markup.table("Solution", rows, fit, shape)


# Rows that are printed at least.
_SHOWN = 10
# Difference of evidence to the best within which all are printed.
_ALIKE = 25.0
# Of a search: `Solution`, or `Refinement` for a known shape.
Fit = TypeVar("Fit", bound=CurveFit, covariant=True)


def _with_error(seconds: float, sigma: float) -> str:
    """A period to the second digit of its standard error."""
    size, unit = quantity_text.time_unit(seconds)
    digits = 1 - math.floor(math.log10(sigma / size)) if 0.0 < sigma < math.inf else 5
    return f"{seconds / size:.{min(max(digits, 0), 12)}f} +- {sigma / size:.2g} {unit}"


class SpinStates(Answering, Sequence[Fit]):
    """The solutions of a light curve, the best first; of a known shape, each a `Refinement`.

    Attributes
    ----------
    verdict : str
        "solved", "periods only" (the pole is not decided), "not solved", or "a satellite of period"
        and that period: rotation about one axis, beside dips at the period of a moon; it ends with
        "the rotation not solved" where other rotations compete.
    criterion : str
        The numbers that led to the verdict.
    notes : tuple of str
        What was assumed, and what is doubtful in the curve.
    """

    def __init__(
        self, solutions: list[Fit], verdict: str, criterion: str, notes: tuple[str, ...]
    ) -> None:
        self._solutions = solutions
        self.verdict, self.criterion, self.notes = verdict, criterion, notes

    @overload
    def __getitem__(self, index: int) -> Fit: ...

    @overload
    def __getitem__(self, index: slice) -> list[Fit]: ...

    def __getitem__(self, index: int | slice) -> Fit | list[Fit]:
        """The solution of a rank."""
        if isinstance(index, int) and not self._solutions:
            raise AttitudeError(f"there is no solution: {self.criterion}")
        return self._solutions[index]

    def __iter__(self) -> Iterator[Fit]:
        return iter(self._solutions)

    def __len__(self) -> int:
        return len(self._solutions)

    @property
    def _unit(self) -> tuple[float, str]:
        """The unit of time of the periods: its length in s, and its name."""
        return quantity_text.time_unit(self._solutions[0].P_phi if self._solutions else math.inf)

    def table(self) -> FlatTable:
        """A row for each solution: mode, periods, pole, moments, fit, relation to the best."""
        from astropy import units

        from attitude._support.tables import FlatTable

        rows = self._solutions
        first = rows[0].evidence if rows else 0.0
        moments = np.array([row.moments for row in rows]).reshape(-1, 3)
        poles = np.array([row.pole for row in rows]).reshape(-1, 2)
        size, unit = self._unit
        return FlatTable(
            {
                "rank": np.arange(len(rows)),
                "mode": [row.mode for row in rows],
                "P_phi": np.array([row.P_phi for row in rows]) / size * units.Unit(unit),
                "P_psi": np.array([row.P_psi for row in rows]) / size * units.Unit(unit),
                "longitude": np.degrees(poles[:, 0]) * units.deg,
                "latitude": np.degrees(poles[:, 1]) * units.deg,
                "A/C": moments[:, 0] / moments[:, 2],
                "B/C": moments[:, 1] / moments[:, 2],
                "rms": np.array([row.rms for row in rows]) * units.mag,
                "evidence": np.array([row.evidence - first for row in rows]),
                "relation": [row.relation for row in rows],
            }
        )

    def plot(self, path: FilePath | None = None) -> Figure:
        """A figure of the best fit, and of the periods and poles of all solutions."""
        from attitude.inversion import _figures

        best = self[0]
        if not isinstance(best, Solution):
            return _figures.of_fit(best, path)
        return _figures.of_states(cast("SpinStates[Solution]", self), path)

    def _repr_html_(self) -> str:
        """Verdict and ranked solutions for notebooks."""
        return markup.of_table(f"{self.verdict}: {self.criterion}", self.table())

    def __repr__(self) -> str:
        return f"<SpinStates: {self.verdict}, {len(self)} solutions>"

    def __str__(self) -> str:
        return "\n".join(texts_of(self))

    def _ranking(self) -> str:
        """Verdict, notes and a row for each of the first solutions, and for the first of a mode."""
        lines = [f"{self.verdict}: {self.criterion}", *self.notes]
        size, unit = self._unit
        first = self._solutions[0].evidence if self._solutions else 0.0
        alike = sum(solution.evidence < first + _ALIKE for solution in self._solutions)
        modes = [solution.mode for solution in self._solutions]
        shown = {*range(len(self))[: max(_SHOWN, alike)], *map(modes.index, modes)}
        for k in sorted(shown):
            solution = self._solutions[k]
            psi, phi = solution.P_psi / size, solution.P_phi / size
            longitude, latitude = np.degrees(solution.pole)
            lines.append(
                f"{k:2d} {solution.mode:3s}  P_phi {phi:10.5f} {unit}  P_psi {psi:10.5f} {unit}  "
                f"pole {longitude:5.1f} {latitude:+5.1f}  rms {solution.rms:.3f}  evidence "
                f"{solution.evidence - first:+8.1f}  {solution.relation}"
            )
        if len(shown) < len(self):
            lines.append(f"and {len(self) - len(shown)} more")
        return "\n".join(line for line in lines if line)

    def _errors_of_best(self) -> str:
        """Periods and pole of the best with their errors, which take a while."""
        name = "rank 0, if it is right" if self.verdict.endswith(_verdicts.OPEN) else "best"
        return f"{name}: {self._solutions[0]._words_of_errors()}"


def texts_of(states: SpinStates[Any]) -> Iterator[str]:
    """The verdict with the ranked solutions, then the errors of the best, which take a while."""
    yield states._ranking()
    if len(states):
        yield states._errors_of_best()
