"""What a law accepts as its numbers."""

from dataclasses import MISSING, dataclass, field

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError


@dataclass(frozen=True)
class Parameter:
    """What a field of a law takes.

    Attributes
    ----------
    low, high : float
        The range of a number, both ends allowed.
    unit : str or None
        As astropy spells it; None for pure numbers.
    words : tuple of str
        Those allowed, where the field is a word.
    is_required : bool
        Whether there is no usual value.
    """

    low: float
    high: float
    unit: str | None
    words: tuple
    is_required: bool

    def accepted(self, value, name):
        """The value as the law keeps it, a float in the unit or a word, or an AttitudeError."""
        if self.words:
            return validation.one_of(value, name, self.words)
        given = validation.number(value, name, unit=self.unit)
        if not self.low <= given <= self.high:
            raise AttitudeError(f"{name} is {given!r}; it must lie {self._range()}.")
        return given

    def as_number(self, value):
        """An accepted value as compiled code takes it: of a word, its place among the words."""
        return float(self.words.index(value)) if self.words else value

    def __str__(self):
        if self.words:
            return f"one of {', '.join(map(repr, self.words))}"
        return f"a number {self._range()}"

    def _range(self):
        return f"from {self.low:g} to {self.high:g}" + (f" {self.unit}" if self.unit else "")


def parameter(usual=MISSING, *, low=-np.inf, high=np.inf, unit=None, words=()):
    """A field of a law: a number in a range and a unit, or one of some words.

    Parameters
    ----------
    usual : float or str, optional
        The value unless one is given; without it the field is required.
    low, high, unit, words : as of `Parameter`
    """
    kept = Parameter(low, high, unit, tuple(words), usual is MISSING)
    return field(default=usual, metadata={"parameter": kept})


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
