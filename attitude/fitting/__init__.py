"""The free rotation through measurements, by least squares with derivatives in closed form.

_attitudes      `fit`, `fit_rates`, `fit_directions`, and the first guesses of each
_minimum        `Fit`, the result; the iteration on growing spans, robust losses
_model          the motion of parameters and its derivatives
_observations   residuals of each kind of records
"""

from attitude.fitting._attitudes import fit, fit_directions, fit_rates
from attitude.fitting._minimum import Fit

__all__ = ["Fit", "fit", "fit_directions", "fit_rates"]
