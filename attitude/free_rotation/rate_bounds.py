"""Upper bounds of the derivatives of a body-fixed direction, used to prove intervals free of zeros.

A body axis a, seen from inertial axes, moves by R a with

    |(R a)'| <= |w|,   |(R a)''| <= |w'| + |w|^2,   |(R a)'''| <= |w''| + 3 |w'| |w| + |w|^3.

For a free rotation the greatest |w| follows from energy and momentum, and Euler's equations
w1' = k1 w2 w3 with |k| <= 1 (no moment exceeds the sum of the others) give the rest:
|w'|^2 <= sum k_i^2 w_j^2 w_k^2, also <= |w|^4 / 3, and |w''| <= sqrt(2) |w'| |w|.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.motion import RateBounds
from attitude.regime import regimes

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body

# Factor that covers the rounding of the closed forms.
_ROUNDED = 1.0 + 1e-12


def of_free_rotation(body: Body, omega: FloatArray) -> RateBounds:
    """`RateBounds` of a free rotation from its angular velocity (3,), rad/s in body axes."""
    moments = np.asarray(body.moments)
    rates = body.rates_about_principal_axes(np.array(omega))[:, 0]
    w = float(np.max(regimes(moments, rates).spin_rate_range)) if np.any(rates) else 0.0
    rate = _acceleration(moments, rates, w)
    w, rate = w * _ROUNDED, rate * _ROUNDED
    return RateBounds(w, rate + w * w, np.sqrt(2.0) * rate * w + 3.0 * rate * w + w**3)


def _acceleration(moments: FloatArray, rates: FloatArray, w: float) -> float:
    """A bound of |w'|: the lower of that from the greatest components and |w|^2 / sqrt 3."""
    some = moments > 0.0
    if not w > 0.0:
        return 0.0
    scaled = rates / w
    energy = np.sum(moments * scaled**2)
    momentum = np.sum((moments * scaled) ** 2)
    squares = np.zeros(3)
    squares[some] = np.minimum(energy / moments[some], momentum / moments[some] ** 2)
    total = 0.0
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        if some[i]:
            gain = (moments[j] - moments[k]) / moments[i]
            total += gain * gain * squares[j] * squares[k]
    return w * w * float(min(np.sqrt(total), np.sqrt(1.0 / 3.0)))
