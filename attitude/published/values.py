"""One published number with its unit, error and source."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from attitude import validation

# SI units and radians in the units of the catalogue, as astropy converts them.
_DEGREE = np.pi / 180.0
_SI = {None: 1.0, "s": 1.0, "kg": 1.0, "kg m2": 1.0, "h": 3600.0, "day": 86400.0}
_SI |= {"deg": _DEGREE, "deg/day": _DEGREE / 86400.0}


@dataclass(frozen=True)
class Value:
    """One published number.

    Attributes
    ----------
    name : str
    value : float, list or str
        In `unit`.
    unit : str or None
        As astropy spells it; None for text and pure numbers.
    error : float or list or None
        As printed, in `unit`; [minus, plus] where they differ.
    source : str
        Publication.
    """

    name: str
    value: Any
    unit: str | None
    error: Any
    source: str

    @property
    def si(self) -> Any:
        """The value as a float or array in SI units and radians; text as it is."""
        if isinstance(self.value, str):
            return self.value
        return validation.real(self.value, self.name)[()] * _SI[self.unit]

    def __str__(self) -> str:
        error = f" ({self.spelled_error})" if self.spelled_error else ""
        unit = "" if self.unit is None else f" {self.unit}"
        return f"{self.name}: {self.spelled}{error}{unit} [{self.source}]"

    @property
    def spelled(self) -> str:
        """The value as text."""
        return self.value if isinstance(self.value, str) else _spelled(self.value)

    @property
    def spelled_error(self) -> str:
        """The error as text, "" if there is none."""
        if self.error is None:
            return ""
        both = isinstance(self.error, list)
        return f"-{self.error[0]} +{self.error[1]}" if both else f"+-{self.error}"


def _spelled(value: Any) -> str:
    if isinstance(value, list):
        return "(" + ", ".join(_spelled(each) for each in value) + ")"
    return repr(value)
