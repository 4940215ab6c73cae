"""What every fit to a light curve has: residuals, shape, law, predictions, a spin file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.free_rotation import FreeRotation
from attitude.inversion import convex, minkowski, predictions
from attitude.inversion.facets import sphere
from attitude.scattering import LommelSeeligerLambert

if TYPE_CHECKING:
    from attitude.annotations import Epochs, FilePath, FloatArray
    from attitude.inversion.curve import LightCurve
    from attitude.inversion.jackknife import Modelled
    from attitude.inversion.problem import CurveProblem
    from attitude.inversion.robust import Weighted
    from attitude.scattering import Law
    from attitude.shape import Mesh


class CurveFit(ABC):
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
        return minkowski.mesh(self.weighted.refined.areas, sphere().normals)

    @property
    def law(self) -> Law:
        """The scattering law without its phase function, which the linear terms replace."""
        return LommelSeeligerLambert(c=convex.LAMBERT, a=0.0, k=0.0)

    @property
    def residuals(self) -> FloatArray:
        """Observed less computed magnitudes, in the order of the curve (of averages, if many)."""
        return self.weighted.residual

    @property
    def rms(self) -> float:
        """Of the residuals, mag."""
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
        return predictions.predicted(self, times)

    def write(self, path: FilePath, **labels: str | None) -> None:
        """Write the spin file of the state with its covariance; see `formats.spin_file.write`."""
        from attitude.formats import spin_file

        note = labels.pop("note", None) or f"{self._made}: {self!r}"
        source = labels.pop("source", None) or "attitude.inversion"
        first = FreeRotation(self.motion.body, self.motion.spin)
        spin_file.write(path, first, source=source, note=note, **labels)
