"""The modules of the package, their syntax trees, and tests of each of them."""

import ast
from functools import cache
from pathlib import Path

import pytest

import attitude

PACKAGE = Path(attitude.__file__).parent


def _modules():
    """Dotted names of all modules of the package, with their files."""
    files = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return files


def folder_of(name):
    """The folder, or file at the top level, that holds a module."""
    words = name.split(".")
    return words[1] if len(words) > 1 else "__init__"


MODULES = _modules()
FOLDERS = {}
for _name in MODULES:
    FOLDERS.setdefault(folder_of(_name), []).append(_name)


def of_modules(*, but=()):
    """A test of the name of a module becomes one of each folder: all, or all `but` some."""

    def decorated(test):
        @pytest.mark.parametrize("folder", [name for name in FOLDERS if name not in but])
        def of_folder(folder):
            failed = []
            for name in FOLDERS[folder]:
                try:
                    test(name)
                except AssertionError as error:
                    failed.append(f"{name}: {error}")
            assert not failed, "\n".join(failed)

        of_folder.__name__, of_folder.__doc__ = test.__name__, test.__doc__
        return of_folder

    return decorated


@cache
def tree_of(name):
    """The syntax tree of a module."""
    return ast.parse(MODULES[name].read_text())


@cache
def nodes_of(name):
    """All nodes of the tree of a module."""
    return list(ast.walk(tree_of(name)))
