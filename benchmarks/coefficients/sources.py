"""Where numbers stand in the package: module-level names, and literals inside functions."""

import ast
import math
import operator
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np

PACKAGE = Path(__file__).resolve().parents[2] / "attitude"
# A float of more significant digits than this was computed or measured.
DIGITS = 10
# At least so many quotients of long numbers in one function are a series; fewer are a formula.
_SERIES = 3
_OPERATIONS = {
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


def module(file):
    """The module of a file below the package."""
    return import_module("attitude." + file.removesuffix(".py").replace("/", "."))


def named(file, *names):
    """The numbers of module-level names as one flat list of floats, in their order."""
    return [float(x) for name in names for x in _flat(getattr(module(file), name))]


def _flat(value):
    if isinstance(value, (tuple, list)):
        return [x for each in value for x in _flat(each)]
    return np.ravel(value).tolist()


def literals(file, function):
    """The constant numbers of a function in the order of the source, floats and whole numbers.

    A product, quotient or power of constants, such as ``2.0 / 575.0``, is one number.
    """
    for node in _tree(file).body:
        if isinstance(node, ast.FunctionDef) and node.name == function:
            return [x for statement in node.body for x in _constants(statement)]
    raise LookupError(f"{file} has no function {function}; name the one that holds the numbers.")


def is_long(x):
    """Whether a number is a float of more than `DIGITS` significant digits."""
    digits = repr(abs(x)).partition("e")[0].replace(".", "").strip("0")
    return isinstance(x, float) and len(digits) > DIGITS


def long_constants():
    """(file, owner) of the computed or measured numbers of the package.

    These are floats written with more than `DIGITS` digits; quotients of that many digits that are
    assigned at module level, but for powers of two; and functions with several such quotients.
    The owner is the module-level name, function or class.
    """
    found = set()
    for path in sorted(PACKAGE.rglob("*.py")):
        file = path.relative_to(PACKAGE).as_posix()
        for node in _tree(file).body:
            inside = isinstance(node, (ast.FunctionDef, ast.ClassDef))
            numbers = [x for x in _constants(node) if is_long(x) and not _is_power_of_two(x)]
            if len(numbers) >= (_SERIES if inside else 1) or _has_long_literal(node):
                found |= {(file, owner) for owner in _owners(node)}
    return found


def prose(file):
    """The source as running text, without line ends and comment signs."""
    lines = (PACKAGE / file).read_text("utf-8").splitlines()
    return " ".join(" ".join(line.strip().removeprefix("#") for line in lines).split())


@cache
def _tree(file):
    return ast.parse((PACKAGE / file).read_text("utf-8"))


def _owners(node):
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return [node.name]
    targets = getattr(node, "targets", [getattr(node, "target", node)])
    names = [each.id for top in targets for each in ast.walk(top) if isinstance(each, ast.Name)]
    return names or [f"line {node.lineno}"]


def _has_long_literal(node):
    return any(isinstance(each, ast.Constant) and is_long(each.value) for each in _numbers(node))


def _numbers(node):
    return (x for x in ast.walk(node) if isinstance(x, ast.Constant) and _is_number(x.value))


def _is_number(value):
    return type(value) in (int, float)


def _is_power_of_two(x):
    return abs(math.frexp(x)[0]) == 0.5


def _constants(node):
    """The numbers below a node of the syntax tree, products, quotients and powers evaluated."""
    value = _value(node)
    if value is not None:
        return [value]
    return [x for child in ast.iter_child_nodes(node) for x in _constants(child)]


def _value(node):
    """The number that a node stands for, or None."""
    if isinstance(node, ast.Constant) and _is_number(node.value):
        return node.value
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = _value(node.operand)
        return None if value is None else -value
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        left, right = _value(node.left), _value(node.right)
        if left is not None and right is not None:
            return _OPERATIONS[type(node.op)](left, right)
    return None
