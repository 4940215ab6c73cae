"""The sources that the machine code of a function is made from, as one hash of their text.

They are the module of the function, what it imports from the package, what those modules import,
and so on, the modules of functions in its closure, and this folder.  The hash is of the text and
not of the times of the files: machine code stays valid if the same version is installed again.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite

_ROOT = Path(__file__).parent.parent
_PACKAGE = _ROOT.name
# Of no effect on machine code.
_TYPES = f"{_PACKAGE}.annotations"
_COMMENT = re.compile("#.*")
# All imports are absolute; tests/test_compilation.py compares what is found with syntax trees.
_IMPORT = re.compile(
    rf"^[ \t]*from[ \t]+({_PACKAGE}[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)"
    rf"|^[ \t]*import[ \t]+({_PACKAGE}\.[\w.]*)",
    re.MULTILINE,
)


class _Source(NamedTuple):
    """One module: the hash of its text, and the modules of the package that it imports."""

    digest: str
    imports: frozenset[str]


def stamp_of(function: Callable[..., Any]) -> str:
    """A hash of the sources on which the machine code of a function depends."""
    names = _reached({*_modules_of(function), *_of_the_compiler()})
    found = hashlib.sha256(llvmlite.__version__.encode())
    for name in sorted(names):
        found.update(f"{name} {_source(name).digest}\n".encode())
    return found.hexdigest()


def _modules_of(function: Any) -> Iterator[str]:
    """The modules of a function and of the functions in its closure."""
    function = getattr(function, "py_func", function)
    yield function.__module__
    for cell in function.__closure__ or ():
        yield from _modules_in(cell.cell_contents)


def _modules_in(value: Any) -> Iterator[str]:
    if isinstance(value, (tuple, list)):
        for each in value:
            yield from _modules_in(each)
    elif hasattr(value, "py_func") or hasattr(value, "__code__"):
        yield from _modules_of(value)


def _reached(names: Iterable[str]) -> set[str]:
    """The modules of the package among some, and all that they import, directly or not."""
    found: set[str] = set()
    left = [name for name in names if name.partition(".")[0] == _PACKAGE]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left.extend(_source(name).imports)
    return found


@cache
def _of_the_compiler() -> frozenset[str]:
    """The modules of this folder: they define what instructions compile to."""
    folder = Path(__file__).parent
    return frozenset(f"{_PACKAGE}.{folder.name}.{each.stem}" for each in folder.glob("*.py"))


@cache
def _source(name: str) -> _Source:
    path = _path(name)
    if path is None:
        return _Source("", frozenset())
    text = path.read_bytes()
    imports = frozenset(_imported(text.decode()))
    return _Source(hashlib.sha256(text).hexdigest(), imports)


def _imported(text: str) -> Iterator[str]:
    """The modules of the package that a text imports, or imports names from."""
    for module, names, whole in _IMPORT.findall(text):
        if whole:
            yield whole
        for each in _COMMENT.sub("", names).strip("()").split(","):
            word = each.split()
            if word:
                inner = f"{module}.{word[0]}"
                if module != _TYPES:
                    yield inner if _path(inner) is not None else module


@cache
def _path(name: str) -> Path | None:
    """The file of a module or package; None if there is none."""
    place = _ROOT.joinpath(*name.split(".")[1:])
    files = place.with_suffix(".py"), place / "__init__.py"
    return next((each for each in files if each.is_file()), None)
