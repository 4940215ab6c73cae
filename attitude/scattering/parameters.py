"""What a law accepts as its numbers."""

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError


def within(value, name, low, high, *, unit=None):
    """A number from low to high, both allowed; see `gates.number`."""
    given = validation.number(value, name, unit=unit)
    if not low <= given <= high:
        raise AttitudeError(
            f"{name} is {given!r}; it must lie from {low:g} to {high:g}"
            + (f" {unit}." if unit else ".")
        )
    return given


def geometry(mu0, mu, alpha):
    """Cosines of incidence and emission and the phase angle as arrays of one shape.

    Angles that no three directions make are the caller's: only the single ranges are checked.
    """
    arrays = together(
        mu0=validation.real(mu0, "mu0"),
        mu=validation.real(mu, "mu"),
        alpha=validation.real(alpha, "alpha", unit="rad"),
    )
    for array, name in zip(arrays[:2], ("mu0", "mu"), strict=True):
        if np.any(np.abs(array) > 1.0 + 1e-9):
            raise AttitudeError(f"{name} holds {np.max(np.abs(array))}; cosines lie from -1 to 1.")
    if np.any((arrays[2] < 0.0) | (arrays[2] > np.pi)):
        raise AttitudeError("alpha must lie from 0 to pi rad.")
    return arrays


def together(**arrays):
    """The arrays in the one shape to which they broadcast."""
    try:
        return np.broadcast_arrays(*arrays.values())
    except ValueError as err:
        listed = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise AttitudeError(
            f"the shapes do not broadcast: {listed}; give equal ones, or single numbers."
        ) from err
