"""What an inversion returns: solutions, each with motion, errors, shape and residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from attitude.errors import AttitudeError
from attitude.free_rotation import FreeRotation
from attitude.inversion import aliases, blas_threads, jackknife, refinement, search, states
from attitude.inversion.curve_fit import CurveFit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude.annotations import FilePath, FloatArray
    from attitude.flat_table import FlatTable
    from attitude.inversion.convex import Tie
    from attitude.inversion.curve import LightCurve
    from attitude.inversion.jackknife import GroupErrors
    from attitude.inversion.posterior import Posterior
    from attitude.inversion.problem import CurveProblem
    from attitude.inversion.robust import Weighted
    from attitude.published.published import Published

_DAY = 86400.0


class Solution(CurveFit):
    """One spin state that fits a light curve; made by `spin_states`.

    Attributes
    ----------
    curve, weighted, evidence, rank, relation
        As of `CurveFit`.
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
        return search.is_axial(self.state)

    @cached_property
    def motion(self) -> FreeRotation:
        """The free rotation, with the covariance of its state; moments are relative."""
        return states.motion(self.state, self.curve.span, self.curve.epoch, self.covariance)

    @property
    def moments(self) -> FloatArray:
        """(3,) relative principal moments, ascending."""
        found: FloatArray = np.sort(states.physical(self.state).moments)
        return found

    @cached_property
    def _covariances(self) -> tuple[FloatArray, GroupErrors]:
        problem = self._problem
        session = None if len(problem) < len(self.curve) else self.curve.session
        groups = jackknife.groupings(problem.t, problem.span, session)
        rivals = [each.weighted for each in self._rivals if each is not self] + self._beside
        with blas_threads.limited():
            return states.covariance(self.weighted, groups, self.tie, rivals)

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
        psi = aliases.rates(self.state)[1]
        return self.curve.span / psi if psi > 0.0 else math.inf

    @property
    def P_phi(self) -> float:
        """s, of the long axis about the momentum; the period of rotation about one axis."""
        return self.curve.span / aliases.rates(self.state)[0]

    @property
    def periods_sigma(self) -> tuple[float, float]:
        """Standard errors of P_psi and P_phi (long axis), s."""
        c = self._covariances[1].covariance
        phi, psi = aliases.rates(self.state)
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

        x, y, z = matrix_to_icrf("ecliptic").T @ search.pole(self.state)
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
        from attitude.inversion import posterior

        return posterior.sampled(self._rivals, method, walkers, steps, seed)

    def _model(self, problem: CurveProblem) -> refinement.ShapeModel:
        """Magnitudes and their derivatives at the epochs of a problem."""
        return refinement.model(problem, self.state)

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure: fit by night, residuals, folded by both periods; saved if a path is given."""
        from attitude.inversion import figures

        return figures.of_solution(self, path)

    def __repr__(self) -> str:
        psi, phi = self.P_psi / _DAY, self.P_phi / _DAY
        longitude, latitude = np.degrees(self.pole)
        periods = f"P {phi:.6g} d" if self.is_axial else f"P_phi(L) {phi:.6g} d, P_psi {psi:.6g} d"
        return (
            f"<Solution {self.rank}: {self.mode}, {periods}, pole {longitude:.1f} "
            f"{latitude:+.1f} deg, rms {self.rms:.3f} mag>"
        )


class SpinStates(Sequence[Any]):
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

        from attitude.flat_table import FlatTable

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
        from attitude.inversion import figures

        if not isinstance(self[0], Solution):
            return figures.of_fit(self[0], path)
        return figures.of_states(self, path)

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
