"""Rules of the code: sizes, names, docstrings, annotations, contracts, constants."""

import ast
import collections
import importlib
import re
from contextlib import suppress

import attitude
from attitude._support import constants
from attitude.motions._motion import Motion
from attitude.paths import Ephemeris, Path
from attitude.scattering import Law
from tests.support.modules import MODULES, nodes_of, of_modules, tree_of

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
LONGEST_BODY = 60


@of_modules()
def test_function_bodies_fit(name):
    """Without the docstring."""
    for node in nodes_of(name):
        if isinstance(node, FUNCTIONS):
            body = node.body[1:] if ast.get_docstring(node) else node.body
            length = body[-1].end_lineno - body[0].lineno + 1 if body else 0
            assert length <= LONGEST_BODY, f"{node.name} has {length} lines"


def test_no_two_public_classes_of_one_name():
    """A public class is one that a module without a leading underscore defines or hands on."""
    places = collections.defaultdict(set)
    for name in attitude.PUBLIC_MODULES:
        try:
            module = importlib.import_module(name)
        except ImportError:  # jax, torch
            continue
        for label in getattr(module, "__all__", ()):
            with suppress(attitude.AttitudeError):  # needs a package that is not installed
                value = getattr(module, label)
                if isinstance(value, type):
                    places[label].add(value)
    assert {name: classes for name, classes in places.items() if len(classes) > 1} == {}


def test_no_public_name_of_astropy():
    """Names of astropy that users import beside ours mean astropy's things."""
    from astropy import coordinates, table, time, units

    theirs = {
        each
        for module in (coordinates, table, time, units)
        for each in dir(module)
        if each[0].isupper() and isinstance(getattr(module, each), type)
    }
    assert {"Quantity", "Time", "QTable", "SkyCoord"} <= theirs
    for name in MODULES:
        for node in tree_of(name).body:
            if isinstance(node, ast.ClassDef):
                assert node.name not in theirs, f"{name} defines {node.name}"


def _members(contract):
    """Public members of a contract, but those that any object may have."""
    common = {"name", "source", "meta", "close", "at"}
    return {each for each in dir(contract) if not each.startswith("_")} - common


# Modules that define a contract, or wrap objects from outside in it once.
BASES = {
    "attitude.motions._motion": Motion,
    "attitude.paths._path": Path,
    "attitude.paths": Ephemeris,
    "attitude.scattering._law": Law,
}


@of_modules()
def test_contracts_are_used_and_not_probed(name):
    """No hasattr or getattr for a member of Motion, Path, Ephemeris or Law outside of its base."""
    members = set().union(*map(_members, BASES.values()))
    if name in BASES:
        return
    for node in nodes_of(name):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("hasattr", "getattr"):
            probed = node.args[1]
            if isinstance(probed, ast.Constant) and ast.unparse(node.args[0]) != "self":
                where = f"{name}:{node.lineno} probes for {probed.value}"
                assert probed.value not in members - FOREIGN.get(name, set()), where


# Members of contracts that objects of other packages have under the same name.
FOREIGN = {
    "attitude.paths._foreign": {"center"},  # a vector function of skyfield
    "attitude.paths._tabulated": {"shape"},
}


def test_each_constant_stands_once():
    """Physical constants, lengths of days, origins of calendars, colours of figures."""
    kinds = (float, str)
    values = {value: name for name, value in vars(constants).items() if name.isupper()}
    values = {value: name for value, name in values.items() if isinstance(value, kinds)}
    assert len(values) >= 13
    for name in MODULES:
        if name == "attitude._support.constants":
            continue
        for node in nodes_of(name):
            if isinstance(node, ast.Constant) and isinstance(node.value, (int, *kinds)):
                assert node.value not in values, (
                    f"{name}:{node.lineno} writes {values[node.value]} out"
                )


def _public(tree):
    """Public functions and classes of a module, methods and properties of its public classes."""
    for node in tree.body:
        if isinstance(node, (*FUNCTIONS, ast.ClassDef)) and not node.name.startswith("_"):
            if _is_overload(node):
                continue
            yield node.name, node
            if isinstance(node, ast.ClassDef):
                for inner in node.body:
                    named = isinstance(inner, FUNCTIONS) and not inner.name.startswith("_")
                    if named and not _is_overload(inner):
                        yield f"{node.name}.{inner.name}", inner


def _is_overload(node):
    return any(ast.unparse(each).endswith("overload") for each in node.decorator_list)


@of_modules()
def test_public_names_have_docstrings(name):
    assert ast.get_docstring(tree_of(name)), "the module has no docstring"
    for label, node in _public(tree_of(name)):
        assert ast.get_docstring(node), f"{label} has no docstring"


@of_modules()
def test_docstrings_say_what_the_function_is(name):
    """None begins with "Of": of what, before it is said what."""
    for node in nodes_of(name):
        if isinstance(node, (*FUNCTIONS, ast.ClassDef, ast.Module)):
            text = ast.get_docstring(node) or ""
            assert not text.startswith("Of "), f"{getattr(node, 'name', name)}: {text}"


COMPILED = {
    "entry_point",
    "sized_entry_point",
    "quickly_compiled",
    "slowly_compiled",
    "inlined_entry_point",
    "subroutine",
    "force_inlined",
    "callback",
    "reduction",
    "reduction_subroutine",
    "reduction_inlined",
    "reduction_callback",
    "reduction_within",
}


@of_modules()
def test_public_names_are_annotated(name):
    """Parameters and results of public functions, methods and properties; constructors too."""
    for label, node in _public(tree_of(name)):
        if isinstance(node, ast.ClassDef):
            inits = [x for x in node.body if isinstance(x, FUNCTIONS) and x.name == "__init__"]
            for init in inits:
                _check_annotated(f"{label}.__init__", init, result=False)
            continue
        decorators = {re.split(r"[.(]", ast.unparse(each))[-1] for each in node.decorator_list}
        if not decorators & COMPILED:
            _check_annotated(label, node, result=True)


@of_modules()
def test_compiled_functions_copy_arrays_in_loops(name):
    """numba compiles the sentence of a shape error with `a[:] = b`: 4 s of a function's 10."""
    for node in nodes_of(name):
        decorators = {
            re.split(r"[.(]", ast.unparse(each))[-1] for each in getattr(node, "decorator_list", ())
        }
        if not isinstance(node, FUNCTIONS) or not decorators & COMPILED:
            continue
        for line in ast.walk(node):
            if isinstance(line, ast.Assign) and not isinstance(line.value, ast.Constant):
                slices = [each for each in ast.walk(line.targets[0]) if isinstance(each, ast.Slice)]
                assert not slices, f"{node.name}, line {line.lineno}: {ast.unparse(line)}"


def _check_annotated(label, node, *, result):
    given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    if "." in label and given and given[0].arg in ("self", "cls"):
        given = given[1:]
    missing = [each.arg for each in given if each.annotation is None]
    assert not missing, f"{label} has no annotation of {', '.join(missing)}"
    if result:
        assert node.returns is not None, f"{label} has no annotation of its result"
