"""Ranges, units and words that the parameters of a law accept."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude.annotations import FloatArray, Real, Reals


class NumberField:
    """Type annotation of a field of a law: accepts a number, a Quantity or text; holds a float.

    Type checkers apply ``__set__`` to the constructor and ``__get__`` to the attribute.  At run
    time the class does nothing.
    """

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: Any = None) -> float: ...

        def __set__(self, instance: object, value: Real) -> None: ...


@dataclass(frozen=True)
class Parameter:
    """Values that a field of a law accepts.

    Attributes
    ----------
    low, high : float
        The range of a number, both ends included.
    unit : str or None
        Unit of the number, as astropy spells it; None for a pure number.
    words : tuple of str
        The words allowed if the field is a word; empty if it is a number.
    is_required : bool
        Whether the field has no default.
    """

    low: float
    high: float
    unit: str | None
    words: tuple[str, ...]
    is_required: bool

    def accepted(self, value: Real, name: str) -> float | str:
        """The value as the law holds it: a float in `unit`, or a word.

        Raises
        ------
        AttitudeError
            For a number out of range, a unit that does not convert, or an unknown word; `name` is
            the name of the field in the message.
        """
        if self.words:
            word: Any = value
            return validation.one_of(word, name, self.words)
        given = validation.number(value, name, unit=self.unit)
        if not self.low <= given <= self.high:
            raise AttitudeError(f"{name} is {given!r}; it must lie {self._range()}.")
        return given

    def as_number(self, value: float | str) -> float:
        """An accepted value for compiled code: the number, or the index of a word in `words`."""
        return float(self.words.index(str(value)) if self.words else value)

    def __str__(self) -> str:
        if self.words:
            return f"one of {', '.join(map(repr, self.words))}"
        return f"a number {self._range()}"

    def _range(self) -> str:
        return f"from {self.low:g} to {self.high:g}" + (f" {self.unit}" if self.unit else "")


def parameter(
    usual: Any = MISSING,
    *,
    low: float = -np.inf,
    high: float = np.inf,
    unit: str | None = None,
    words: Iterable[str] = (),
) -> Any:
    """A dataclass field of a law: a number with range and unit, or one of several words.

    Parameters
    ----------
    usual : float or str, optional
        The default; without it the field is required.
    low, high, unit, words : as of `Parameter`

    Returns
    -------
    dataclasses.Field
        Typed as Any, since its value is assigned to a field annotated ``float``, ``str`` or
        `NumberField`.
    """
    kept = Parameter(low, high, unit, tuple(words), usual is MISSING)
    return field(default=usual, metadata={"parameter": kept})


def geometry(mu0: Reals, mu: Reals, alpha: Reals) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cosines of incidence and emission and the phase angle (rad) as arrays of one shape.

    Each range is checked; whether the three angles belong to one geometry is not.

    Raises
    ------
    AttitudeError
        For cosines beyond -1 to 1, phase angles beyond 0 to pi, or shapes that do not broadcast.
    """
    mu0, mu, alpha = together(
        mu0=validation.real(mu0, "mu0"),
        mu=validation.real(mu, "mu"),
        alpha=validation.real(alpha, "alpha", unit="rad"),
    )
    for array, name in ((mu0, "mu0"), (mu, "mu")):
        if np.any(np.abs(array) > 1.0 + 1e-9):
            raise AttitudeError(f"{name} holds {np.max(np.abs(array))}; cosines lie from -1 to 1.")
    if np.any((alpha < 0.0) | (alpha > np.pi)):
        raise AttitudeError("alpha must lie from 0 to pi rad.")
    return mu0, mu, alpha


def together(**arrays: FloatArray) -> tuple[FloatArray, ...]:
    """The arrays broadcast to one shape; AttitudeError with their shapes if that is impossible."""
    try:
        return tuple(np.broadcast_arrays(*arrays.values()))
    except ValueError as err:
        listed = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise AttitudeError(
            f"the shapes do not broadcast: {listed}; give equal ones, or single numbers."
        ) from err
