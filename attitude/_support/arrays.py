"""Values that do not change: read-only arrays, immutable classes; memory for results; components
of vectors; distinct ones of many values, and those between gaps.

An immutable object stays so after copying, pickling and unpickling.

A class whose constructor converts its arguments (text, Quantities and lists to arrays in SI units)
writes its ``__init__`` and annotates it with the types that callers pass; the attributes in the
class body are annotated with the types that the object holds.  Such a dataclass is made with
``init=False``: the generated ``__init__`` would have one annotation for both.  A private attribute
is declared in ``__init__`` as ``self._name: Type``: in the class body it would be a field.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from attitude._support.synonyms import Answering

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from attitude._support.annotations import FloatArray, IntArray


Array = TypeVar("Array", bound=NDArray[Any])
Item = TypeVar("Item")

# Entries that are copied at a time.
_PART = 1 << 20


def frozen(array: Array) -> Array:
    """The array itself, made read-only in place."""
    array.setflags(False)  # type: ignore[call-arg]  # a keyword takes 2.5 times as long
    return array


def read_only(array: Array) -> Array:
    """A read-only view: for a writable array, another type to numba, it would compile once more."""
    return frozen(array.view())


def copied(array: Array) -> Array:
    """A copy in parts, between which Python acts on signals: new memory costs more than copying."""
    if array.size <= _PART:
        return array.copy(order="K")
    copy = np.empty_like(array)
    put(copy, array)
    return copy


def put(target: NDArray[Any], source: NDArray[Any]) -> None:
    """Copy an array into one of the same shape, in parts as `copied` of its longest axis."""
    if target.size <= _PART:
        target[...] = source
        return
    length = max(target.shape)
    before = (slice(None),) * target.shape.index(length)
    step = max(length * _PART // target.size, 1)
    for first in range(0, length, step):
        place = (*before, slice(first, first + step))
        target[place] = source[place]


class Immutable(Answering):
    """Base of objects whose attributes cannot be assigned; values computed on demand are cached."""

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{type(self).__name__} does not change; make a new one.")

    def __setstate__(self, state: dict[str, Any]) -> None:
        # A pickle of a numpy array does not record that the array is read-only.
        for name, value in state.items():
            if isinstance(value, np.ndarray):
                frozen(value)
            object.__setattr__(self, name, value)

    def _set(self, name: str, value: Any) -> Any:
        """Assign in a constructor, or cache a value computed on demand; return the value."""
        object.__setattr__(self, name, value)
        return value

    def _set_all(self, **values: Any) -> None:
        """Assign several attributes in a constructor, in a fifth of the time."""
        self.__dict__.update(values)


class Valued(Immutable):
    """Base of objects that are equal, and have one hash, if their values are.

    A class names the attributes that are its value in `_value`.
    """

    _value: tuple[str, ...] = ()

    def _key(self) -> tuple[Any, ...]:
        return tuple(_comparable(getattr(self, name)) for name in self._value)

    def __eq__(self, other: object) -> bool:
        if self is other or not self._value:
            return self is other
        return (
            isinstance(other, Valued) and type(self) is type(other) and self._key() == other._key()
        )

    def __hash__(self) -> int:
        return hash((type(self).__name__, self._key())) if self._value else object.__hash__(self)


def _comparable(value: Any) -> Any:
    """An array as its shape and bytes, in which both zeros are one; anything else as it is."""
    if not isinstance(value, np.ndarray):
        return tuple(map(_comparable, value)) if isinstance(value, (tuple, list)) else value
    return value.shape, np.ascontiguousarray(value + 0.0).tobytes()


# ---- Memory for results, of large pages where that is cheaper, and views with other orders of axes

# Bytes of a large page, and the least size of an array for which numpy requests such pages.
_PAGE = 1 << 21
_LARGE = 1 << 22
_DOUBLE = 8
# Directions at a time, so that temporary arrays stay in the second-level cache.
_TURNED = 1 << 13


def new_array(*shape: int) -> FloatArray:
    """An array of doubles whose entries are not set yet.

    The first write to each page of new memory costs 0.5 ns a byte with the usual pages of 4 KB, and
    0.1 ns with large ones (benchmarks/memory.py).  numpy requests large pages from Linux, which
    needs them at multiples of their size: in an array that begins elsewhere the pages at both
    ends stay small, a quarter of an array of 8 MB.
    """
    count = math.prod(shape)
    if count * _DOUBLE < _LARGE:
        return np.empty(shape)
    # so much longer that the first and the last large page lie within the memory
    memory = np.empty(count + 2 * _PAGE // _DOUBLE)
    first = -memory.ctypes.data % _PAGE // _DOUBLE
    return memory[first : first + count].reshape(shape)


def two_across(unit: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (3,) across one and each other, right-handed before it."""
    first = np.cross(unit, np.eye(3)[np.argmin(np.abs(unit))])
    first = first / np.linalg.norm(first)
    return first, np.cross(unit, first)


def units(vectors: FloatArray) -> FloatArray:
    """Vectors (..., k) divided by their lengths."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def between(a: FloatArray, b: FloatArray) -> FloatArray:
    """The angle (N,) between directions (3, N) of any length, 0 to pi rad, exact at both ends."""
    out = new_array(a.shape[1])
    for begin in range(0, out.size, _TURNED):
        block = slice(begin, begin + _TURNED)
        (x, y, z), (u, v, w) = a[:, block], b[:, block]
        p, q, r = y * w - z * v, z * u - x * w, x * v - y * u
        np.arctan2(np.sqrt(p * p + q * q + r * r), x * u + y * v + z * w, out=out[block])
    return out


def components_last(array: FloatArray) -> FloatArray:
    """A view (..., k) of an array (k, ...), as ``numpy.moveaxis(array, 0, -1)``, by few calls."""
    return array.T if array.ndim <= 2 else array.transpose(*range(1, array.ndim), 0)


def components_first(array: FloatArray) -> FloatArray:
    """A view (k, ...) of an array (..., k), as ``numpy.moveaxis(array, -1, 0)``, by few calls."""
    return array.T if array.ndim <= 2 else array.transpose(-1, *range(array.ndim - 1))


def bisected(is_low: Callable[[Any], Any], low: Any, high: Any, steps: int) -> tuple[Any, Any]:
    """Both ends, numbers or arrays (...), after so many halvings of the intervals between them.

    `is_low` says of places in their middles whether they lie on the side of `low`.
    """
    for _ in range(steps):
        middle = 0.5 * (low + high)
        below = is_low(middle)
        if isinstance(below, np.ndarray):
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        else:
            low, high = (middle, high) if below else (low, middle)
    return low, high


# ---- Distinct ones of many values, and values between gaps


def distinct(
    items: Iterable[Item], are_one: Callable[[Item, Item], bool], most: float = math.inf
) -> list[Item]:
    """The first items, so many at most, that are not one with an item before them."""
    chosen: list[Item] = []
    for item in items:
        if not any(are_one(item, other) for other in chosen):
            chosen.append(item)
            if len(chosen) >= most:
                break
    return chosen


def parted(values: FloatArray, gap: float) -> list[IntArray]:
    """Numbers of the values (N,) between gaps wider than a given one, in ascending order."""
    order = np.argsort(values, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(values[order]) > gap) + 1)


def part_of_each(values: FloatArray, gap: float) -> IntArray:
    """The number (N,) of the part of `parted` that each value is in."""
    numbers = np.empty(len(values), np.int64)
    for number, places in enumerate(parted(values, gap)):
        numbers[places] = number
    return numbers


def in_turn(*sequences: Iterable[Item]) -> Iterator[Item]:
    """The first items of sequences, then the second ones, to the end of the longest sequence."""
    for items in itertools.zip_longest(*sequences):
        yield from (item for item in items if item is not None)
