"""Decorators of functions on numbers and arrays that are compiled, or run in Python.

There are two families.  `entry_point`, `inlined_entry_point`, `subroutine` and `force_inlined` set
no fastmath flag: error-free transforms depend on the order of every operation, and an epoch has the
same bits whether it is evaluated alone, in an array or in a block.  A product and a sum are fused
only by `instructions.fma`.  The decorators named ``reduction`` are for sums over facets: terms may
be added in any order, products and sums may be fused, NaN and infinity keep their meaning.  The
last digits then depend on the instructions of the machine, but not on blocks or threads.

numba is imported at the first call of an entry point, but small calls of a `sized_entry_point` run
in Python while that pays (`choice`).  ``ATTITUDE_COMPILE=never``, or numba's own
``NUMBA_DISABLE_JIT=1``, runs everything in Python, some thousand times slower, for debuggers and
coverage.
"""

from __future__ import annotations

import math
import os
import sys
import threading
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from time import thread_time
from types import FunctionType
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from attitude._compilation import choice, ieee

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping


# No caller needs the wrapper for C.
_EXACT = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
_ANY_ORDER = {**_EXACT, "fastmath": {"reassoc", "contract", "arcp", "nsz"}}
# Functions that only compiled code calls: their machine code is part of the cache entry of the
# caller, and without the wrapper for Python compilation takes half the time.
_INNER = {"no_cpython_wrapper": True}

_lock = threading.RLock()
# Names of the entry points that Python has called as machine code.
_compiled: set[str] = set()
# Entry points that have run in Python, and the number of calls that were counted.
_in_python: dict[EntryPoint, None] = {}
_number = 0


def _after_fork() -> None:
    """In a forked process no other thread lives, and none holds the lock."""
    global _lock
    _lock = threading.RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


UNCOMPILED: bool = choice.MODE == "never"
# Seconds for each number of the arguments in Python, until a call was measured.
_FIRST_GUESS = 1e-4
# Epochs below which a pass over arrays takes longer in Python than a loop.
_FEW = 24
# Names of arguments that are working memory or tables, whose size says nothing about the work.
_NO_WORK = {"block", "records", "cells", "starts", "widths", "knots", "knots_low", "table"}


class Compilable:
    """A Python function of numbers and arrays that numba can compile by options of `njit`.

    A call from Python runs the function in Python; compiled code calls its machine code, which is
    `kept` on disk.  numba reads py_func and targetoptions of a global function to inline it.
    is_elementwise: whether its loop is one pass over arrays in Python; see `elementwise`.
    """

    def __init__(
        self, python: Callable[..., Any], options: Mapping[str, Any], kept: bool = False
    ) -> None:
        self.py_func = python
        self.targetoptions = options
        self._kept = kept
        self._dispatcher: Any = None
        self._python: Callable[..., Any] | None = None
        self.is_elementwise = False
        self.__name__, self.__doc__ = python.__name__, python.__doc__
        self.__module__, self.__qualname__ = python.__module__, python.__qualname__
        self.__wrapped__ = python

    def __call__(self, *arguments: Any) -> Any:
        return self.uncompiled(*arguments)

    def uncompiled(self, *arguments: Any) -> Any:
        """The result, computed in Python."""
        if self._python is None:
            self._python = _for_python(self.py_func)
            if self.is_elementwise:
                self._python.__globals__["range"] = _few_or_at_once
        return self._python(*arguments)

    def for_python(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Take another function for Python, which must return the same bits in less time."""
        self._python = function
        return function

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.__module__}.{self.__name__}>"

    def __reduce__(self) -> str:
        # By name, as functions are pickled: numba's cache hashes it to distinguish closures.
        return self.__qualname__

    @property
    def dispatcher(self) -> Any:
        """numba's dispatcher of the function, created at the first access."""
        if self._dispatcher is None:
            with _lock:
                if self._dispatcher is None:
                    from attitude._compilation import lowering

                    self._dispatcher = lowering.dispatcher(
                        self.py_func, self.targetoptions, self._kept
                    )
        return self._dispatcher

    @property
    def _numba_type_(self) -> Any:
        # numba reads this attribute of a global object whose type it does not know.
        return self.dispatcher._numba_type_


class EntryPoint(Compilable):
    """A `Compilable` that Python calls too: compiled at the first call for each set of types.

    run: what a call of the entry point calls: for loops in which 0.1 us counts.  Read it at each
        call; it is replaced at the first.
    """

    def __init__(
        self,
        python: Callable[..., Any],
        options: Mapping[str, Any],
        kept: bool = True,
        sized: bool = False,
        to_compile: float = choice.TO_COMPILE,
    ) -> None:
        super().__init__(python, options, kept)
        self._to_compile = to_compile
        self.run: Callable[..., Any] = self._first
        # Seconds in Python for each number; those of all calls; and calls, in Python or not.
        self._pace, self._spent, self._calls = _FIRST_GUESS, 0.0, 0
        # The number of the last call among all, and what ran in Python between any two calls.
        self._number, self._seconds, self._settled = 0, 0.0, 0
        self._steps: list[EntryPoint] | None = None
        self._follows = False
        if UNCOMPILED:
            self.run = self._in_python
        elif sized and choice.MODE == "automatic":
            self.run = self._by_size

    def __call__(self, *arguments: Any) -> Any:
        return self.run(*arguments)

    def compiled(self, *arguments: Any) -> Any:
        """The result by machine code, whatever the size, unless compilation is switched off."""
        return (self._in_python if UNCOMPILED else self._first)(*arguments)

    def _by_size(self, *arguments: Any) -> Any:
        """The result, computed in Python where that pays; the size of the largest array counts."""
        arrays = [
            argument
            for argument, name in zip(arguments, self._names, strict=True)
            if isinstance(argument, np.ndarray) and name not in _NO_WORK
        ]
        size = 1 + max((array.size for array in arrays), default=0)
        kept, predicted = self._is_on_disk, size * self._pace
        steps = self._note_call()
        together = self._spent + sum(step._spent for step in steps)
        together = math.inf if self._follows else together * (1.0 + 1.0 / max(self._calls, 1))
        if not choice.is_worth_python(
            predicted, kept, self._spent, self._to_compile, self._calls, together
        ):
            if self._calls >= choice.STEADY_CALLS and together >= choice.STEADY:
                _follow(steps)
            return self._first(*arguments)
        with choice.InPython() as run:
            result = self._in_python(*arguments)
        self._pace = run.seconds / size
        self._spent += run.seconds
        self._calls += 1
        _in_python[self] = None
        return result

    def _note_call(self) -> list[EntryPoint]:
        """Count a call; what has run in Python between every two calls so far, [] at the first."""
        global _number
        if self._number:
            known = list(_in_python) if self._steps is None else self._steps
            self._steps = [
                step for step in known if step._number > self._number and step is not self
            ]
        _number += 1
        self._number = _number
        return self._steps or []

    def _settling(self, *arguments: Any) -> Any:
        """One of the first calls as machine code, after which what is slow beside it follows."""
        steps = self._note_call()
        begin = thread_time()
        result = self.dispatcher(*arguments)
        self._seconds += thread_time() - begin
        self._settled += 1
        if self._settled >= choice.REPEATS or (self._settled > 1 and not steps):
            self.run = self.dispatcher
            each_call = sum(step._spent / max(step._calls, 1) for step in steps)
            if self._settled >= choice.REPEATS and each_call > self._seconds / self._settled:
                _follow(steps)
        return result

    @cached_property
    def _names(self) -> tuple[str, ...]:
        """The names of the arguments."""
        code = self.py_func.__code__
        return code.co_varnames[: code.co_argcount]

    @cached_property
    def _is_on_disk(self) -> bool:
        """Whether numba keeps machine code of the function, be it of an older source."""
        source = Path(self.py_func.__code__.co_filename)
        index = f"{source.stem}.{self.__name__}-*.nbi"
        chosen = os.environ.get("NUMBA_CACHE_DIR")
        if chosen:
            return any(Path(chosen).glob(f"*/{index}"))
        return any((source.parent / "__pycache__").glob(index))

    def _first(self, *arguments: Any) -> Any:
        name = f"{self.__module__}.{self.__name__}"
        is_new = name not in _compiled
        self.run = self.dispatcher
        _compiled.add(name)
        result = self.run(*arguments)
        if is_new and choice.MODE == "automatic":
            _in_python.pop(self, None)
            self._steps, self._seconds, self._settled = None, 0.0, 0
            self.run = self._settling
        return result

    def _in_python(self, *arguments: Any) -> Any:
        # Compiled code neither raises nor warns at a division by zero or an overflow.
        with np.errstate(all="ignore"):
            return self.uncompiled(*map(_with_fields, arguments))


def _follow(steps: list[EntryPoint]) -> None:
    """Let functions compile at their next call from Python."""
    for step in steps:
        step._follows = True


def compiled_names() -> set[str]:
    """Names of the entry points that Python has called as machine code."""
    return set(_compiled)


def _for_python(loop: Callable[..., Any]) -> FunctionType:
    """The function with `ieee` as ``math`` and entry points not compiled, which they would be anew
    for it.
    """
    function = cast(FunctionType, loop)
    names = {**function.__globals__, "math": ieee}
    for name in function.__code__.co_names:
        if isinstance(names.get(name), EntryPoint):
            names[name] = names[name].uncompiled
    return FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, function.__closure__
    )


def _with_fields(argument: Any) -> Any:
    """A structured array or element with its fields as attributes, as in compiled code."""
    if isinstance(argument, np.ndarray) and argument.dtype.names:
        return argument.view(np.recarray)
    if isinstance(argument, np.void) and not isinstance(argument, np.record):
        # the result is a view of the array, as the element is
        return argument.view((np.record, argument.dtype))
    return argument


def named(loop: Callable[..., Any], name: str) -> Callable[..., Any]:
    """A function made within another, under the name that its module gives it.

    One source then serves several loops that differ in the functions they call; pickles and the
    cache on disk find each by its name.
    """
    loop.__name__ = loop.__qualname__ = name
    return loop


def entry_point(function: Callable[..., Any]) -> EntryPoint:
    """Compile a function at its first call from Python, and keep the machine code on disk."""
    return EntryPoint(function, _EXACT)


def sized_entry_point(function: Callable[..., Any]) -> EntryPoint:
    """As `entry_point`, for loops over entries of arrays: few run in Python (`choice`)."""
    return EntryPoint(function, _EXACT, sized=True)


def quickly_compiled(function: Callable[..., Any]) -> EntryPoint:
    """As `sized_entry_point`, for short loops, which take less time to compile."""
    return EntryPoint(function, _EXACT, sized=True, to_compile=choice.TO_COMPILE_SHORT)


def slowly_compiled(function: Callable[..., Any]) -> EntryPoint:
    """As `sized_entry_point`, for functions of derivatives, which take longer to compile."""
    return EntryPoint(function, _EXACT, sized=True, to_compile=choice.TO_COMPILE_DERIVATIVES)


def inlined_entry_point(function: Callable[..., Any]) -> EntryPoint:
    """As `sized_entry_point`; compiled callers inline the function.

    Without inlining, the process that compiles caller and function would run a copy of the loop
    that was optimised before the callees of the loop were known, and which is not vectorised.
    """
    return EntryPoint(function, {**_EXACT, "forceinline": True}, sized=True)


def subroutine(function: Callable[..., Any]) -> Compilable:
    """For functions that only compiled code calls; LLVM decides whether to inline them."""
    return Compilable(function, {**_EXACT, **_INNER})


def force_inlined(function: Callable[..., Any]) -> Compilable:
    """As `subroutine`, inlined regardless of length: for long functions with one call in a loop."""
    return Compilable(function, {**_EXACT, **_INNER, "forceinline": True})


def elementwise(function: Compilable) -> Compilable:
    """In Python a loop over epochs without branches is one pass over arrays, where they are many.

    Its index is the array of all of them, and each element has the same bits.  Such a function has
    no other loop of as many passes, and no index but that of the epoch.
    """
    function.is_elementwise = True
    return function


def _few_or_at_once(count: int) -> Iterable[Any]:
    """Indices one by one, or the array of all of them where they are many."""
    return range(count) if count < _FEW else (np.arange(count),)


def reduction(function: Callable[..., Any]) -> EntryPoint:
    """As `entry_point`, for sums whose terms may be added in any order."""
    return EntryPoint(function, _ANY_ORDER)


def reduction_over(*called: Compilable) -> Callable[[Callable[..., Any]], EntryPoint]:
    """As `reduction`, for a closure over compilable functions, which are compiled into it.

    The machine code is kept on disk if all of `called` belong to the package: the cache is not
    invalidated by edits of other functions.
    """
    package = __name__.partition(".")[0]
    kept = all(callee.__module__.partition(".")[0] == package for callee in called)
    modules = dict.fromkeys(callee.__module__.rpartition(".")[2] for callee in called)

    def decorated(function: Callable[..., Any]) -> EntryPoint:
        # numba keeps one index for each qualified name and line, of one stamp: the sources of
        # different closures differ, and each would discard the machine code of the others.
        function.__qualname__ += "." + ".".join(modules)
        return EntryPoint(function, _ANY_ORDER, kept)

    return decorated


def reduction_subroutine(function: Callable[..., Any]) -> Compilable:
    """As `reduction`, for functions that only compiled code calls; LLVM decides on inlining."""
    return Compilable(function, {**_ANY_ORDER, **_INNER})


def reduction_within(function: Callable[..., Any]) -> Compilable:
    """As `reduction_subroutine`, inlined regardless of length: for functions of SIMD vectors."""
    return Compilable(function, {**_ANY_ORDER, **_INNER, "forceinline": True})


def reduction_inlined(function: Callable[..., Any]) -> Compilable:
    """As `reduction`, copied into callers before types are inferred: calls stop vectorisation."""
    return Compilable(function, {**_ANY_ORDER, "inline": "always"})


# ---- What runs compiled in this process, and where machine code is kept


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
        The folder below which machine code is kept: ``NUMBA_CACHE_DIR``, else the package's, in
        folders ``__pycache__``.  If it cannot be written: numba's in the user's cache folder.
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
        compiled=tuple(sorted(compiled_names())),
        cache=Path(chosen) if chosen else Path(__file__).parent.parent,
    )
