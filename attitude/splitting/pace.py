"""Sizes of the blocks of a long computation, such that Ctrl-C is heard between them."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

# s.  Python acts on a signal when a compiled loop returns; 0.2 s is felt as at once.
_LONGEST, _SHORTEST = 0.05, 0.02
_FIRST = 64


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
    """

    def __init__(self, most: int) -> None:
        self.most, self.size = most, min(most, _FIRST)

    @contextmanager
    def measured(self, full: bool) -> Iterator[None]:
        """Run a block, and adapt `size` to the time that it takes.

        full: whether the block has `size` items; a smaller one does not make `size` grow.
        """
        begin = time.monotonic()
        yield
        took = time.monotonic() - begin
        if took > _LONGEST:
            self.size = max(1, int(self.size * _LONGEST / took))
        elif full and took < _SHORTEST:
            self.size = min(self.most, 2 * self.size)
