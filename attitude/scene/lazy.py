"""What a view answers: each made when first asked for, kept, and listed as evaluated."""

import numpy as np

from attitude.immutable import frozen


class Quantity:
    """A property that is made once; made by `quantity`.

    Attributes
    ----------
    name : str
    unit : str
        As astropy spells it; "" for pure numbers and what is none.
    parts : tuple of str
        What the entries of the last axis are; () for a number at each epoch.
    about : str
        One line.
    """

    def __init__(self, function, unit, parts, is_column):
        self.function = function
        self.unit = unit
        self.parts = parts
        self.is_column = is_column
        self.__doc__ = function.__doc__
        self.about = " ".join((function.__doc__ or "").split("\n\n")[0].split())

    def __set_name__(self, owner, name):
        self.name = name

    def __get__(self, view, owner=None):
        # Python asks here only until the value stands in the __dict__ of the view.
        if view is None:
            return self
        value = self.function(view)
        if isinstance(value, np.ndarray):
            value = frozen(value) if value.ndim else value[()]
        view.__dict__[self.name] = value
        view.__dict__["_evaluated"].append(self.name)
        return value


def quantity(unit="", parts=()):
    """Decorator of a method of a view: a number, or a row of `parts`, at each epoch."""
    return lambda function: Quantity(function, unit, tuple(parts), True)


def kept(function):
    """Decorator of a method of a view for what is no column of a table."""
    return Quantity(function, "", (), False)
