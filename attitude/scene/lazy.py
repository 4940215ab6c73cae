"""Properties of a view that are computed at their first use, kept, and listed as evaluated."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

import numpy as np

from attitude.immutable import frozen

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

Value = TypeVar("Value")


class LazyProperty(Generic[Value]):
    """A property of a view, computed once per view; made by `quantity` and `kept`.

    Attributes
    ----------
    name : str
    unit : str
        In the spelling of astropy; "" for pure numbers and for values that are not numbers.
    parts : tuple of str
        Names of the entries of the last axis; () for one number at each epoch.
    is_column : bool
        Whether a table can hold the property: one number, or one row of `parts`, at each epoch.
    about : str
        Description in one line.
    """

    name: str

    def __init__(
        self, function: Callable[[Any], Value], unit: str, parts: tuple[str, ...], is_column: bool
    ) -> None:
        self.function = function
        self.unit = unit
        self.parts = parts
        self.is_column = is_column
        self.about = " ".join((function.__doc__ or "").split("\n\n")[0].split())
        self.__doc__ = inspect.cleandoc(function.__doc__ or "")
        if is_column:
            self.__doc__ += "\n\n" + self._shape_and_unit()

    def _shape_and_unit(self) -> str:
        shape = f"(S, {len(self.parts)}): {', '.join(self.parts)}" if self.parts else "S"
        return f"Shape {shape}; {self.unit or 'pure number'}."

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, view: None, owner: type) -> LazyProperty[Value]: ...

    @overload
    def __get__(self, view: object, owner: type | None = None) -> Value: ...

    def __get__(self, view: Any, owner: type | None = None) -> Any:
        # Called only until the value is in the __dict__ of the view, which Python looks up first.
        if view is None:
            return self
        value: Any = self.function(view)
        if isinstance(value, np.ndarray):
            value = frozen(value) if value.ndim else value[()]
        view.__dict__[self.name] = value
        view.__dict__["_evaluated"].append(self.name)
        return value

    def __repr__(self) -> str:
        return f"<LazyProperty {self.name}>"


def quantity(
    unit: str = "", parts: Iterable[str] = ()
) -> Callable[[Callable[[Any], Value]], LazyProperty[Value]]:
    """Decorator of a method of a view that returns a number, or a row of `parts`, at each epoch."""
    return lambda function: LazyProperty(function, unit, tuple(parts), True)


def kept(function: Callable[[Any], Value]) -> LazyProperty[Value]:
    """Decorator of a method of a view whose result a table cannot hold as a column."""
    return LazyProperty(function, "", (), False)
