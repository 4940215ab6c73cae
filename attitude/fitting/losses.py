"""Robust losses: how much a record counts whose residual is large.

A loss rho is a function of z, the square of a residual over that of its standard error times
`f_scale`; rho(z) is z for small z.  The names are those of scipy.optimize.least_squares, but a
residual is the whole vector of a record, so that a result does not depend on the axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals

NAMES = ("linear", "soft_l1", "huber", "cauchy")


@dataclass(frozen=True)
class Loss:
    """A loss and its scale.

    Attributes
    ----------
    name : str
        One of `NAMES`.
    scale : float
        In standard errors: where residuals begin to count as outliers.
    """

    name: str
    scale: float

    @property
    def robust(self) -> bool:
        """Whether large residuals count less than in least squares."""
        return self.name != "linear"

    def values(self, squares: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Losses (N,), their first derivatives and their second times the argument.

        Of squares (N,) of weighted residuals; the losses are in the same unit.
        """
        z = squares / self.scale**2
        if self.name == "soft_l1":
            root = np.sqrt(1.0 + z)
            rho, first, second = 2.0 * (root - 1.0), 1.0 / root, -0.5 * z / root**3
        elif self.name == "huber":
            root = np.sqrt(np.maximum(z, 1.0))
            outside = z > 1.0
            rho = np.where(outside, 2.0 * root - 1.0, z)
            first, second = 1.0 / root, np.where(outside, -0.5 / root, 0.0)
        elif self.name == "cauchy":
            rho, first, second = np.log1p(z), 1.0 / (1.0 + z), -z / (1.0 + z) ** 2
        else:
            rho, first, second = z, np.ones_like(z), np.zeros_like(z)
        return rho * self.scale**2, first, second


def known(name: str, f_scale: Real | None, sigma: Reals | None) -> Loss:
    """The loss of a name and scale.

    Parameters
    ----------
    name : str
    f_scale : float or None
        In standard errors; 1 by default.
    sigma : array_like or None
        The standard errors given.

    Raises
    ------
    AttitudeError
        For another name, a scale that is not above zero, and a robust loss without errors.
    """
    if name not in NAMES:
        listed = ", ".join(f'"{each}"' for each in NAMES)
        raise AttitudeError(f"loss is {name!r}; it must be one of {listed}.")
    if name != "linear" and sigma is None and f_scale is None:
        raise AttitudeError(
            f'loss="{name}" needs the size of usual residuals; give sigma=, or f_scale= in the '
            "unit of the residuals."
        )
    return Loss(name, 1.0 if f_scale is None else validation.positive(f_scale, "f_scale"))
