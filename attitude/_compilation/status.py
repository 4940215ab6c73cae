"""What of the package runs compiled in this process, and where machine code is kept."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from attitude._compilation import choice, decorators


@dataclass(frozen=True)
class CompilationStatus:
    """How the calls of this process have been run so far.

    Attributes
    ----------
    mode : str
        "automatic", "always" or "never": the environment variable ``ATTITUDE_COMPILE``.
    seconds_in_python : float
        s of the processor, what small calls have taken in Python.
    limits : tuple of float
        s, up to which small calls run there: all of them where machine code is on the disk, and
        those of one function where it would have to be compiled.
    compiler_loaded : bool
        Whether numba has been imported.
    compiled : tuple of str
        The entry points that run as machine code.
    cache : pathlib.Path
        The folder in which machine code is kept if it can be written.
    """

    mode: str
    seconds_in_python: float
    limits: tuple[float, float]
    compiler_loaded: bool
    compiled: tuple[str, ...]
    cache: Path


def compilation_status() -> CompilationStatus:
    """The `CompilationStatus` of this process.

    >>> compilation_status().mode in ("automatic", "always", "never")
    True
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return CompilationStatus(
        mode=choice.MODE,
        seconds_in_python=choice.spent(),
        limits=(choice.TO_LOAD, choice.TO_COMPILE),
        compiler_loaded="numba" in sys.modules,
        compiled=tuple(sorted(decorators.compiled_names())),
        cache=Path(chosen) if chosen else Path(__file__).parent / "__pycache__",
    )
