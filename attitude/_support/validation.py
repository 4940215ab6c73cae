"""Check the numbers and arguments that callers give, once: shape, unit, finiteness, names.

All other code works on float64 arrays in SI units and radians.  No function here changes a value
except by converting it to the unit of the result.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Collection, Hashable, Sequence
from types import EllipsisType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from attitude._support import quantity_text
from attitude._support.quantity_text import quoted
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude._support.annotations import BoolArray, FloatArray, Real, Reals


Choice = TypeVar("Choice")
Kind = TypeVar("Kind")

# Types of entries that need no conversion of unit and no check.
_NUMBERS = {int, float}
# Up to so many numbers, a sum of Python's floats is faster than a function of numpy.
_FEW = 16


def real(
    value: Reals,
    name: str,
    *,
    shape: Sequence[int | EllipsisType] | None = None,
    unit: str | None = None,
    finite: bool = True,
) -> FloatArray:
    """The value as a new float64 array."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        array: FloatArray = value.copy("K")
    else:
        array = _floats(value, name, unit)
    if shape is not None and array.shape != shape and not _fits(array.shape, shape):
        size = f"has shape {array.shape}" if array.shape else "is one number"
        raise AttitudeError(f"{name} {size}; give {_spelled(shape)}.")
    if finite and not is_finite(array):
        bad = array[~np.isfinite(array)].flat[0]
        raise AttitudeError(f"{name} holds {bad}; every number in it must be finite.")
    return array


def is_finite(array: FloatArray) -> bool:
    """Whether all numbers are finite; of few numbers in a fifth of numpy's time."""
    if array.size <= _FEW and math.isfinite(sum(array.ravel().tolist())):
        return True
    return bool(np.isfinite(array).all())


def rows(value: Reals, name: str, width: int, *, unit: str | None = None) -> FloatArray:
    """The value as a float64 array (..., width), not copied if it is one; NaN and infinity pass."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        array: FloatArray = value
    else:
        array = _floats(value, name, unit)
    if array.shape[-1:] != (width,):
        raise AttitudeError(f"{name} has shape {array.shape}; give {_spelled((..., width))}.")
    return array


def seconds(value: Reals, name: str) -> FloatArray:
    """The value as a float64 array of seconds, not copied if it is one already; NaN is allowed."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    if type(value) is float:
        return np.array(value)
    return _floats(value, name, "s")


def number(value: Real, name: str, *, unit: str | None = None) -> float:
    """One finite number as a float in `unit`; see `real`."""
    if type(value) is float and -math.inf < value < math.inf:
        return value
    return float(real(value, name, shape=(), unit=unit))


def positive(value: Real, name: str, *, unit: str | None = None) -> float:
    """One finite number greater than zero as a float in `unit`; see `real`."""
    value_given = number(value, name, unit=unit)
    if not value_given > 0.0:
        raise AttitudeError(f"{name} is {shown(value_given)}; it must be greater than zero.")
    return value_given


def count(value: object, name: str, least: int = 1, most: float = math.inf) -> int:
    """A whole number from `least` to `most` as an int; AttitudeError for anything else."""
    number = value if isinstance(value, (int, np.integer)) else math.nan
    if least <= number <= most and not isinstance(value, bool):
        return int(number)
    bounds = f", at least {least}" if most == math.inf else f" from {least} to {most}"
    raise AttitudeError(f"{name} is {shown(value)}; give a whole number{bounds}.")


def generator(seed: int | np.random.Generator, name: str = "seed") -> np.random.Generator:
    """A numpy Generator of a seed, or the one that is given."""
    try:
        return np.random.default_rng(seed)
    except (TypeError, ValueError):
        raise AttitudeError(
            f"{name} is {shown(seed)}; give a whole number, at least 0, or a numpy Generator."
        ) from None


def not_negative(value: Real, name: str) -> float:
    """One finite number of at least zero as a float; see `real`."""
    value_given = number(value, name)
    if value_given < 0.0:
        raise AttitudeError(f"{name} is {shown(value_given)}; it must not be negative.")
    return value_given


def angle_from_plane(value: Real, name: str, example: str) -> float:
    """An elevation or a latitude in rad, from -pi/2 to pi/2."""
    angle = number(value, name, unit="rad")
    if not abs(angle) <= 0.5 * math.pi:
        raise AttitudeError(
            f"{name} is {angle!r} rad; it goes from -pi/2 to pi/2 (give degrees as text, such as "
            f'"{example}").'
        )
    return angle


def returned(values: object, name: str) -> FloatArray:
    """What a function returned as a float64 array; AttitudeError for what are no numbers."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise AttitudeError(
            f"{name} returns {shown(values)}; it must return an array of real numbers."
        ) from None


def output(out: object, shape: tuple[int, ...]) -> FloatArray:
    """The output array that was given, or a new one; AttitudeError for one of another kind."""
    if out is None:
        return np.empty(shape)
    what = f"a {type(out).__name__}"
    if isinstance(out, np.ndarray):
        is_double = out.shape == shape and out.dtype == np.float64
        if is_double and out.flags.c_contiguous and out.flags.writeable:
            return out
        what = f"an array of {out.dtype} of shape {out.shape}"
    raise AttitudeError(
        f"out is {what}; give a writable float64 array of shape {shape} in C order."
    )


def one_of(value: Choice, name: str, allowed: Collection[Choice]) -> Choice:
    """The value itself if it is among the allowed ones, else an AttitudeError."""
    if not isinstance(value, Hashable) or value not in allowed:
        listed = ", ".join(repr(choice) for choice in allowed)
        raise AttitudeError(f"{name} is {shown(value)}; it must be one of {listed}.")
    return value


def flag(value: object, name: str) -> bool:
    """A truth value as a bool: True, False, those of numpy, 1 or 0."""
    if isinstance(value, (bool, np.bool_, int)) and value in (0, 1):
        return bool(value)
    raise AttitudeError(f"{name} is {shown(value)}; it must be True or False.")


def broadcast(array: FloatArray, name: str, shape: tuple[int, ...], whose: str) -> FloatArray:
    """The array broadcast to a shape, read-only; AttitudeError where it cannot be."""
    try:
        return np.broadcast_to(array, shape)
    except ValueError as err:
        raise AttitudeError(
            f"{name} has shape {array.shape}; give a single number, or one for each {whose}, "
            f"{shape}."
        ) from err


def together(**arrays: FloatArray) -> tuple[FloatArray, ...]:
    """The arrays broadcast to one shape; AttitudeError with their shapes if that is impossible."""
    try:
        return tuple(np.broadcast_arrays(*arrays.values()))
    except ValueError as err:
        listed = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise AttitudeError(
            f"the leading axes do not broadcast: {listed}; give equal ones, or one of either."
        ) from err


def instance(value: object, kind: type[Kind], name: str, wanted: str) -> Kind:
    """The value itself if it is of a class, else an AttitudeError that says what is wanted."""
    if isinstance(value, kind):
        return value
    raise AttitudeError(f"{name} is {shown(value)}; give {wanted}.")


def refuse_class(value: object, name: str) -> None:
    """AttitudeError for a class where an object is expected."""
    if isinstance(value, type):
        raise AttitudeError(
            f"{name} is the class {value.__name__}; give an object, made by {value.__name__}(...)."
        )


def unit_vector(value: Reals, name: str) -> FloatArray:
    """The vector (3,) of length one along a value; AttitudeError for a vector of length zero.

    >>> unit_vector((0, 3e-300, -4e-300), "axis")
    array([ 0. ,  0.6, -0.8])
    """
    vector = real(value, name, shape=(3,))
    size = np.max(np.abs(vector))
    if size == 0.0:
        raise AttitudeError(
            f"{name} is zero, which has no direction; give a vector of any other length."
        )
    vector = vector / size  # so that its square neither overflows nor underflows
    return vector / np.sqrt(vector @ vector)


def _floats(value: Any, name: str, unit: str | None) -> FloatArray:
    if type(value) in (tuple, list) and _NUMBERS.issuperset(map(type, value)):
        return _doubles(value, name)
    if isinstance(value, str):
        numbers = _common(value, name, unit)
        if numbers is not None:
            return numbers
    mask = unmasked(value)[1]
    if mask is not None and np.any(mask):
        raise AttitudeError(
            f"{name} has masked entries; give a number for each, or leave them out."
        )
    if isinstance(value, str) or _holds(value, str) or holds_quantities(value):
        value = _quantity(value, name)
    elif not hasattr(value, "to_value"):
        value = _with_unit(value, getattr(value, "unit", None))  # a column of a table
    if hasattr(value, "unit") and hasattr(value, "to_value"):
        value = _in_unit(value, name, unit)
    try:
        # of a truth value among numbers numpy would make a number
        array = np.asarray(value, object if _holds(value, (bool, np.bool_)) else None)
    except ValueError as err:
        raise AttitudeError(f"{name} is ragged; give an array with rows of equal length.") from err
    except TypeError as err:
        raise AttitudeError(f"{name} is {shown(value)}; give real numbers.") from err
    if array.dtype.kind == "O" and all(map(_is_real, array.flat)):
        return _doubles(array, name)
    if array.dtype.kind not in "fiu":
        raise AttitudeError(
            f"{name} is {shown(value)}; give real numbers"
            + (f" in {unit}, or a Quantity." if unit else ".")
        )
    return np.array(array, dtype=np.float64)


def _is_real(entry: object) -> bool:
    """Whether an entry of an array of objects is a number."""
    return isinstance(entry, numbers.Real) and not isinstance(entry, (bool, np.bool_))


def _doubles(value: Any, name: str) -> FloatArray:
    """Numbers of Python as doubles; AttitudeError for whole numbers beyond their range."""
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        raise AttitudeError(
            f"{name} is {shown(value)}, beyond the range of doubles; give smaller numbers."
        ) from None


def _common(text: str, name: str, unit: str | None) -> FloatArray | None:
    """Numbers of a text without a unit, or with a common one that converts; None for others."""
    words, own_unit = quantity_text.numbers_and_unit(text, name)
    factor = quantity_text.common_factor(own_unit, unit) if own_unit else 1.0
    if factor is None:
        return None
    numbers = np.array([float(word) for word in words])
    return (numbers if len(numbers) > 1 else numbers[0:1].reshape(())) * factor


def unmasked(value: Any) -> tuple[Any, BoolArray | None]:
    """The data without its mask, and the mask or None, for masked arrays of numpy and astropy."""
    if isinstance(value, np.ma.MaskedArray):
        unit = getattr(value, "unit", None)
        return _with_unit(np.ma.getdata(value), unit), np.ma.getmaskarray(value)
    if hasattr(value, "unmasked") and hasattr(value, "mask"):
        return value.unmasked, np.asarray(value.mask)
    return value, None


def _with_unit(data: Any, unit: Any) -> Any:
    """The data, as a Quantity if they are numbers and there is a unit."""
    if unit is None or np.asarray(data).dtype.kind not in "fiu":
        return data
    from astropy.units import Quantity

    return Quantity(np.asarray(data), unit)


def _holds(value, kind):
    return isinstance(value, (list, tuple)) and any(isinstance(item, kind) for item in value)


def holds_quantities(value: Any) -> bool:
    """Whether a list holds Quantities, at any depth."""
    return isinstance(value, (list, tuple)) and any(
        hasattr(item, "to_value") or holds_quantities(item) for item in value
    )


def _quantity(value: Any, name: str) -> Any:
    """Text, or a list of text, Quantities and numbers, as an astropy Quantity."""
    from astropy import units

    if isinstance(value, str):
        words, unit = quantity_text.numbers_and_unit(value, name)
        numbers = [float(word) for word in words]
        return units.Quantity(
            numbers if len(numbers) > 1 else numbers[0],
            quantity_text.unit_of(unit, name) if unit else "",
        )
    try:
        if isinstance(value, (list, tuple)):
            # Each entry may have a unit of its own.
            return units.Quantity([_quantity(item, name) for item in value])
        return units.Quantity(value)
    except AttitudeError:
        raise
    except (TypeError, ValueError):
        raise AttitudeError(
            f"{name} is {shown(value)}, which are not numbers with units that convert to each "
            'other; write it like "14.5 deg/day".'
        ) from None


def _in_unit(quantity: Any, name: str, unit: str | None) -> Any:
    """The numbers of a Quantity in a unit; without a unit, of a dimensionless Quantity."""
    from astropy import units

    if unit is None:
        if quantity.unit.is_equivalent(units.dimensionless_unscaled):
            return quantity.to_value(units.dimensionless_unscaled)
        raise AttitudeError(
            f"{name} is in {quoted(quantity.unit, mark='')}; it must be a pure number."
        )
    if quantity.unit == units.dimensionless_unscaled:
        return quantity.value
    target = units.Unit(unit)
    try:
        return quantity.to_value(target)
    except ValueError:  # another dimension, or an unknown name that astropy kept from a file
        raise AttitudeError(
            f"{name} is in {quoted(quantity.unit, mark='')}; give it in {unit} or a unit that "
            "converts to it."
        ) from None


def _fits(shape, allowed):
    if allowed and allowed[0] is Ellipsis:
        tail = allowed[1:]
        return len(shape) >= len(tail) and (not tail or shape[-len(tail) :] == tuple(tail))
    return shape == tuple(allowed)


def _spelled(shape: Sequence[int | EllipsisType]) -> str:
    if tuple(shape) == ():
        return "a single number"
    return "(" + ", ".join("..." if n is Ellipsis else str(n) for n in shape) + ")"


def shown(value: object) -> str:
    """A value for an error message: its repr on one line, at most 60 characters."""
    return quoted(value)


# ---- Calls that fail, of packages that are not installed

# What pip installs, and where: no package index has the package before its release.  From then on
# "attitude-propagation" and "" (CONTRIBUTING.md); a test compares README and docs.
SOURCE: str = "."
WHERE: str = ", in a checkout of this project"


def installing(extra: str) -> str:
    """The command that installs the packages of an extra, for the end of a sentence.

    >>> installing("jax")
    'pip install ".[jax]", in a checkout of this project'
    """
    return f'pip install "{SOURCE}[{extra}]"{WHERE}'
