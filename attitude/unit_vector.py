"""Directions that are given as vectors of any length."""

import numpy as np

from attitude import gates
from attitude.errors import AttitudeError


def unit_vector(value, name):
    """The vector (3,) of length one along a value, or an AttitudeError for what has no direction.

    >>> unit_vector((0, 3e-300, -4e-300), "axis")
    array([ 0. ,  0.6, -0.8])
    """
    vector = gates.real(value, name, shape=(3,))
    size = np.max(np.abs(vector))
    if size == 0.0:
        raise AttitudeError(
            f"{name} is zero, which has no direction; give a vector of any other length."
        )
    vector = vector / size  # so that its square neither over- nor underflows
    return vector / np.sqrt(vector @ vector)
