"""The free rotation through measurements, by least squares with derivatives in closed form.

``attitudes``, ``rates``, ``directions``
    `fit`, `fit_rates`, `fit_directions`: attitudes, angular velocities alone, directions.
``model``
    The motion of parameters and its derivatives.
``observations``, ``losses``
    Residuals of each kind of records; robust losses.
``first_guess``, ``sightings``, ``minimum``
    Where the iteration starts, and how it goes on.
``result``
    `Fit`: the motion, its covariance, residuals.
"""

from attitude.fitting._attitudes import fit, fit_directions, fit_rates
from attitude.fitting._minimum import Fit

__all__ = ["Fit", "fit", "fit_directions", "fit_rates"]
