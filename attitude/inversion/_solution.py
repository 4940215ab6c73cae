"""What an inversion returns: solutions, each with motion, errors, shape and predictions."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from attitude._support.constants import SPEED_OF_LIGHT_M_S
from attitude._support.synonyms import Answering
from attitude.epochs import _inputs
from attitude.errors import AttitudeError
from attitude.inversion import _errors, _problem, _refinement, _search, _shapes, _states, _verdicts
from attitude.inversion._shapes import sphere
from attitude.motions._free_rotation import FreeRotation
from attitude.photometry._curve import LightCurve, angle_between, dimming
from attitude.scattering._weighted import LommelSeeligerLambert

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude._support.annotations import Epochs, FilePath, FloatArray
    from attitude._support.tables import FlatTable
    from attitude.inversion._errors import GroupErrors, Modelled
    from attitude.inversion._posterior import Posterior
    from attitude.inversion._problem import CurveProblem
    from attitude.inversion._refinement import Weighted
    from attitude.inversion._shapes import Tie
    from attitude.motions._published import Published
    from attitude.scattering._law import Law
    from attitude.shape._mesh import Mesh


# ---- Magnitudes that a solution predicts, with the errors of motion, shape and zero points


def predicted(
    solution: CurveFit, times: Epochs | LightCurve | None
) -> tuple[FloatArray, FloatArray]:
    """Apparent magnitudes (T,) and their standard errors; see `CurveFit.predict`."""
    curve = solution.curve
    emission, sun, observer = _geometry(curve, times)
    alpha = angle_between(sun, observer)
    own = solution.weighted.problem
    terms = _terms(solution, emission, alpha)
    unit = [(each / np.linalg.norm(each, axis=1)[:, None]).T for each in (sun, observer)]
    there = replace(own, t=emission / own.span, sun=unit[0].copy(), observer=unit[1].copy())
    here = solution._model(own)
    coefficients = own.coefficients(here.magnitude)
    made = solution._model(there)
    magnitude = made.magnitude + terms @ coefficients
    if not curve.unit_distances:
        magnitude += dimming(sun, observer)
    # the linear terms follow the parameters
    b = own.terms * own.root[:, None]
    inverse = np.linalg.pinv(b.T @ b + np.diag(1.0 / own.prior**2), hermitian=True)
    follow = -inverse @ (b.T @ (here.jacobian * own.root).T)
    slopes = made.jacobian.T + terms @ follow
    variance = np.sum(
        (slopes @ _refinement.inverse(solution.weighted.refined.normal)) * slopes, axis=1
    )
    variance += np.sum((terms @ inverse) * terms, axis=1)
    floor = float(np.median(np.abs(solution.residuals))) * 1.48
    return magnitude, np.sqrt(np.maximum(variance, 0.0) + floor**2)


def _geometry(curve: LightCurve, times: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Epochs of emission from that of the curve, and vectors to Sun and observer."""
    if times is None:
        return curve.emission, *curve.vectors
    if isinstance(times, LightCurve):
        shift = times.epoch.seconds - curve.epoch.seconds
        return times.emission + shift, *times.vectors
    hi, lo = _inputs.seconds_since(curve.epoch, times)
    t = np.atleast_1d(np.asarray(hi + (0.0 if lo is None else lo), dtype=float))
    known, first = np.unique(curve.seconds, return_index=True)
    outside = (t < known[0]) | (t > known[-1])
    if np.any(outside):
        raise AttitudeError(
            f"{np.count_nonzero(outside)} of {len(t)} epochs lie outside of the light curve, whose "
            "geometry ends there; give a LightCurve of these epochs (its magnitudes do not matter)."
        )
    sun, observer = (
        np.stack([np.interp(t, known, vectors[first, k]) for k in range(3)], axis=1)
        for vectors in curve.vectors
    )
    late = float(np.median(curve.seconds - curve.emission))
    light = np.linalg.norm(observer, axis=1) / SPEED_OF_LIGHT_M_S if late > 0.0 else 0.0
    return t - light, sun, observer


def _terms(solution: CurveFit, emission: FloatArray, alpha: FloatArray) -> FloatArray:
    """Linear terms (T, L) at other epochs: of the first filter, sessions at their mean."""
    own = solution.weighted.problem
    found = np.zeros((len(emission), own.terms.shape[1]))
    made = _problem.phase_terms(alpha, emission / own.span)
    found[:, : made.shape[1]] = made
    found[:, made.shape[1]] = 1.0
    return found


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
    motion : Motion
        With the covariance of its state.
    """

    motion: Any

    # What a spin file says of its origin.
    _made = "by a fit to a light curve"

    def __init__(
        self, curve: LightCurve, weighted: Weighted, problem: CurveProblem, rank: int, relation: str
    ) -> None:
        self.curve, self.weighted, self._problem = curve, weighted, problem
        self.evidence: float = weighted.evidence
        self.rank, self.relation = rank, relation

    @cached_property
    def shape(self) -> Mesh:
        """The closed convex mesh of the areas, of the volume of the unit sphere, in m."""
        return _shapes.mesh(self.weighted.refined.areas, sphere().normals)

    @property
    def law(self) -> Law:
        """The scattering law without its phase function, which the linear terms replace."""
        return LommelSeeligerLambert(c=_shapes.LAMBERT, a=0.0, k=0.0)

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

    @abstractmethod
    def _model(self, problem: CurveProblem) -> Modelled:
        """Magnitudes and their derivatives at the epochs of a problem."""

    def predict(self, times: Epochs | LightCurve | None = None) -> tuple[FloatArray, FloatArray]:
        """Apparent magnitudes at epochs of reception, and their standard errors.

        Parameters
        ----------
        times : epochs, or LightCurve, optional
            Epochs within the curve, where its geometry is interpolated; or a curve with geometry
            of its own.  By default those of the curve.

        Returns
        -------
        magnitude, sigma : (T,) arrays
            The error of the motion, the shape and the zero points, and the model error.

        Raises
        ------
        AttitudeError
            For epochs outside of the curve.
        """
        return predicted(self, times)

    def write(self, path: FilePath, **labels: str | None) -> None:
        """Write the spin file of the state with its covariance; see `formats.spin_file.write`."""
        from attitude.formats import spin_file

        note = labels.pop("note", None) or f"{self._made}: {self!r}"
        source = labels.pop("source", None) or "attitude.inversion"
        first = FreeRotation(self.motion.body, self.motion.spin)
        spin_file.write(path, first, source=source, note=note, **labels)


_DAY = 86400.0


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

    def __init__(
        self,
        curve: LightCurve,
        weighted: Weighted,
        problem: CurveProblem,
        tie: Tie,
        rank: int,
    ) -> None:
        super().__init__(curve, weighted, problem, rank, "")
        self.tie = tie
        self._rivals: list[Solution] = [self]
        self._beside: list[Weighted] = []

    @property
    def state(self) -> FloatArray:
        """Parameters of the search: elements per span, orientation, ellipsoid, modes of areas."""
        return self.weighted.refined.state

    @property
    def is_axial(self) -> bool:
        """Whether the body rotates about one principal axis."""
        return _search.is_axial(self.state)

    @cached_property
    def motion(self) -> FreeRotation:
        """The free rotation, with the covariance of its state; moments are relative."""
        return _states.motion(self.state, self.curve.span, self.curve.epoch, self.covariance)

    @property
    def moments(self) -> FloatArray:
        """(3,) relative principal moments, ascending."""
        found: FloatArray = np.sort(_states.physical(self.state).moments)
        return found

    @cached_property
    def _covariances(self) -> tuple[FloatArray, GroupErrors]:
        problem = self._problem
        session = None if len(problem) < len(self.curve) else self.curve.session
        groups = _errors.groupings(problem.t, problem.span, session)
        rivals = [each.weighted for each in self._rivals if each is not self] + self._beside
        with _refinement.limited():
            return _states.covariance(self.weighted, groups, self.tie, rivals)

    @property
    def covariance(self) -> FloatArray:
        """(9, 9) of the rotation vector (rad, ICRF axes), rates (rad/s, body axes) and moments."""
        scale = np.ones(9)
        scale[3:6] = 1.0 / self.curve.span
        found: FloatArray = self._covariances[0] * np.outer(scale, scale)
        return found

    def published(self, convention: str = "L", frame: str = "ecliptic") -> Published:
        """The state in the form of papers; see `FreeRotation.published`."""
        return self.motion.published(convention, frame=frame)

    @property
    def mode(self) -> str:
        """ "LAM", "SAM", or "PA" for rotation about one axis."""
        return "PA" if self.is_axial else "LAM" if self.state[1] > 0.0 else "SAM"

    @property
    def P_psi(self) -> float:
        """s; infinite for rotation about one axis."""
        psi = _verdicts.rates(self.state)[1]
        return self.curve.span / psi if psi > 0.0 else math.inf

    @property
    def P_phi(self) -> float:
        """s, of the long axis about the momentum; the period of rotation about one axis."""
        return self.curve.span / _verdicts.rates(self.state)[0]

    @property
    def periods_sigma(self) -> tuple[float, float]:
        """Standard errors of P_psi and P_phi (long axis), s."""
        c = self._covariances[1].covariance
        phi, psi = _verdicts.rates(self.state)
        if self.is_axial:
            return math.inf, 2.0 * math.sqrt(c[3, 3]) * self.curve.span / phi**2
        sign = 1.0 if self.state[1] > 0.0 else -1.0
        by = np.array([2.0, -sign if sign > 0.0 else 0.0])
        variance = float(by @ c[3:5, 3:5] @ by)
        return (
            math.sqrt(c[4, 4]) * self.curve.span / psi**2,
            math.sqrt(variance) * self.curve.span / phi**2,
        )

    @property
    def pole(self) -> FloatArray:
        """Longitude and latitude of the momentum, J2000 ecliptic, rad."""
        from attitude.frames import matrix_to_icrf

        x, y, z = matrix_to_icrf("ecliptic").T @ _search.pole(self.state)
        return np.array([math.atan2(y, x) % (2.0 * math.pi), math.asin(max(-1.0, min(1.0, z)))])

    @property
    def pole_sigma(self) -> float:
        """Standard error of the direction of the momentum, rad, the larger of two."""
        inner = self._covariances[1].covariance[:2, :2]
        return math.sqrt(float(np.linalg.eigvalsh(inner)[-1]))

    def sample(self, count: int, seed: int = 0) -> list[FreeRotation]:
        """Motions drawn from the covariance; see `FreeRotation.sample`."""
        return self.motion.sample(count, seed)

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
        from attitude.inversion import _posterior

        return _posterior.sampled(self._rivals, method, walkers, steps, seed)

    def _model(self, problem: CurveProblem) -> _refinement.ShapeModel:
        """Magnitudes and their derivatives at the epochs of a problem."""
        return _refinement.model(problem, self.state)

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure: fit by night, residuals, folded by both periods; saved if a path is given."""
        from attitude.inversion import _figures

        return _figures.of_solution(self, path)

    def __repr__(self) -> str:
        psi, phi = self.P_psi / _DAY, self.P_phi / _DAY
        longitude, latitude = np.degrees(self.pole)
        periods = f"P {phi:.6g} d" if self.is_axial else f"P_phi(L) {phi:.6g} d, P_psi {psi:.6g} d"
        return (
            f"<Solution {self.rank}: {self.mode}, {periods}, pole {longitude:.1f} "
            f"{latitude:+.1f} deg, rms {self.rms:.3f} mag>"
        )


class SpinStates(Answering, Sequence[Any]):
    """The solutions of a light curve, the best first; of a known shape, each a `Refinement`.

    Attributes
    ----------
    verdict : str
        "solved", "periods only" (the pole is not decided) or "not solved".
    criterion : str
        The numbers that led to the verdict.
    notes : tuple of str
        What was assumed, and what is doubtful in the curve.
    """

    def __init__(
        self, solutions: list[Any], verdict: str, criterion: str, notes: tuple[str, ...]
    ) -> None:
        self._solutions = solutions
        self.verdict, self.criterion, self.notes = verdict, criterion, notes

    @overload
    def __getitem__(self, index: int) -> Any: ...

    @overload
    def __getitem__(self, index: slice) -> list[Any]: ...

    def __getitem__(self, index: int | slice) -> Any:
        """The solution of a rank."""
        if isinstance(index, int) and not self._solutions:
            raise AttitudeError(f"there is no solution: {self.criterion}")
        return self._solutions[index]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._solutions)

    def __len__(self) -> int:
        return len(self._solutions)

    def table(self) -> FlatTable:
        """A row for each solution: mode, periods, pole, moments, fit, relation to the best."""
        from astropy import units

        from attitude._support.tables import FlatTable

        rows = self._solutions
        first = rows[0].evidence if rows else 0.0
        moments = np.array([each.moments for each in rows]).reshape(-1, 3)
        poles = np.array([each.pole for each in rows]).reshape(-1, 2)
        return FlatTable(
            {
                "rank": np.arange(len(rows)),
                "mode": [each.mode for each in rows],
                "P_phi": np.array([each.P_phi for each in rows]) / _DAY * units.d,
                "P_psi": np.array([each.P_psi for each in rows]) / _DAY * units.d,
                "longitude": np.degrees(poles[:, 0]) * units.deg,
                "latitude": np.degrees(poles[:, 1]) * units.deg,
                "A/C": moments[:, 0] / moments[:, 2],
                "B/C": moments[:, 1] / moments[:, 2],
                "rms": np.array([each.rms for each in rows]) * units.mag,
                "evidence": np.array([each.evidence - first for each in rows]),
                "relation": [each.relation for each in rows],
            }
        )

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure of the best fit, and of the periods and poles of all solutions."""
        from attitude.inversion import _figures

        if not isinstance(self[0], Solution):
            return _figures.of_fit(self[0], path)
        return _figures.of_states(self, path)

    def __repr__(self) -> str:
        return f"<SpinStates: {self.verdict}, {len(self)} solutions>"

    def __str__(self) -> str:
        lines = [f"{self.verdict}: {self.criterion}", *self.notes]
        for k, each in enumerate(self._solutions[:10]):
            psi, phi = each.P_psi / _DAY, each.P_phi / _DAY
            longitude, latitude = np.degrees(each.pole)
            lines.append(
                f"{k:2d} {each.mode:3s}  P_phi {phi:10.5f} d  P_psi {psi:10.5f} d  pole "
                f"{longitude:5.1f} {latitude:+5.1f}  rms {each.rms:.3f}  evidence "
                f"{each.evidence - self._solutions[0].evidence:+8.1f}  {each.relation}"
            )
        return "\n".join(lines)
