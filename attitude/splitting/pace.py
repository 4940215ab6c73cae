"""Sizes of the blocks of a long computation, such that Ctrl-C is heard between them."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

# s.  Python acts on a signal when a compiled loop returns; 0.2 s is felt as at once.
_LONGEST, _SHORTEST = 0.05, 0.02
_FIRST, _LARGEST_GROWTH = 8, 16


class Pace:
    """The number of items in a block that takes a twentieth of a second, or fewer.

    Parameters
    ----------
    most : int
        Largest number of items, whatever they take.

    Attributes
    ----------
    size : int
        For the next block.
    items : int
        Of the present block; set in it.
    """

    def __init__(self, most: int) -> None:
        self.most, self.size, self.items = most, min(most, _FIRST), 0

    @contextmanager
    def measured(self) -> Iterator[None]:
        """Run a block that sets `items`, and adapt `size` to the time that it takes."""
        begin, self.items = time.monotonic(), 0
        yield
        took = time.monotonic() - begin
        if took > _LONGEST:
            self.size = min(self.most, max(1, int(self.items * _LONGEST / took)))
        elif self.items >= self.size and took < _SHORTEST:
            grown = _LARGEST_GROWTH * took < _SHORTEST
            self.size = min(self.most, (_LARGEST_GROWTH if grown else 2) * self.size)
