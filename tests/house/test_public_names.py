"""Public modules, names and signatures are those of tests/data/public_names.json.

    python tests/house/test_public_names.py --remake     # write the list, and print what changed

The list has a line for each name: what it is, and the parameters of what is called, with their
kinds and defaults, without annotations.  Defaults that are no literals stand as `Class(...)`.
A module is public if `attitude.PUBLIC_MODULES` or KEPT names it; a module without `__all__` offers
the names without a leading underscore that it assigns, defines, or imports as themselves.
"""

import ast
import enum
import importlib
import inspect
import json
import re
import sys
import textwrap
from pathlib import Path

import pytest

import attitude
from attitude._support.synonyms import is_absent
from tests.support.places import ROOT

LIST = ROOT / "tests" / "data" / "public_names.json"
COMMAND = "python tests/house/test_public_names.py --remake"
# Import paths that stay although their files may move: each hands on at least the names listed.
KEPT = (
    *("arcs", "catalog", "conditions", "ensemble", "epochs", "events", "fitting", "formats"),
    *("formats.acm", "formats.aem", "formats.apm", "formats.ck", "formats.damit"),
    *("formats.damit_light_curve", "formats.detect", "formats.mission"),
    *("formats.spin_file", "formats.stk", "formats.tables", "frames", "inversion", "jacobi"),
    *("light_curve", "paths", "photometry", "published", "quaternion", "referee"),
    *("representations", "scattering", "scene", "shape", "splitting", "survey", "torques"),
    "viewer",
)
# The line of a name that exists only where an optional package is installed.
OPTIONAL = "needs an optional package"
# Pages that name modules: all but those about the inside of the package.
PAGES = (
    "README.md",
    "docs/*.md",
    "docs/howto/*.md",
    "docs/notebooks/*.ipynb",
    "examples/*.py",
)
INSIDE = {"architecture.md", "compilation.md"}


def public_modules():
    """Dotted names of the public modules, sorted."""
    return sorted({*attitude.PUBLIC_MODULES, *(f"attitude.{name}" for name in KEPT)})


def module_file(name):
    """The source file of a module of the package, None where there is none."""
    path = ROOT.joinpath(*name.split("."))
    files = [path / "__init__.py", path.with_suffix(".py")]
    return next((file for file in files if file.is_file()), None)


def named_modules():
    """Modules that pages and examples import or name: {module: [files]}."""
    found = {}
    for pattern in PAGES:
        for page in sorted(ROOT.glob(pattern)):
            if page.name in INSIDE:
                continue
            text = page.read_text("utf-8")
            names = set(re.findall(r"\battitude(?:\.[a-z_]\w*)+", text))
            for module, imported in re.findall(r"from (attitude[\w.]*) import \(?([^\n\"]*)", text):
                names.add(module)
                names |= {f"{module}.{each}" for each in re.findall(r"(\w+)(?: as \w+)?", imported)}
            for module in {_longest_module(name) for name in names} - {None, "attitude"}:
                found.setdefault(module, []).append(page.relative_to(ROOT).as_posix())
    return {module: found[module] for module in sorted(found)}


def _longest_module(name):
    while name and module_file(name) is None:
        name = name.rpartition(".")[0]
    return name or None


def signatures(module_name):
    """{name: line} of the public names of a module, and {class.member: line} of its classes."""
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as err:
        raise AssertionError(f"{module_name} is gone; scripts import it ({err}).") from None
    except ImportError:  # its sentence says which optional package is not installed
        return _signatures_from_source(ast.parse(module_file(module_name).read_text("utf-8")))
    tree = ast.parse(Path(module.__file__).read_text("utf-8"))
    lines = {}
    for name in getattr(module, "__all__", None) or _offered(tree):
        try:
            value = getattr(module, name)
        except attitude.AttitudeError:  # the optional package of this name is not installed
            lines[name] = OPTIONAL
            continue
        lines[name] = _line(value)
        if inspect.isclass(value):
            for member in _members(value):
                lines[f"{name}.{member}"] = _member_line(value, member)
    return dict(sorted(lines.items()))


def _offered(tree):
    """Names without a leading underscore that a module defines, assigns, or imports `as` itself."""
    names = set()
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for target in targets:
                names |= {each.id for each in ast.walk(target) if isinstance(each, ast.Name)}
        elif isinstance(node, ast.ImportFrom):
            names |= {alias.name for alias in node.names if alias.asname == alias.name}
    return sorted(name for name in names if not name.startswith("_"))


def _signatures_from_source(tree):
    """Functions of a module whose optional package is not installed."""
    lines = {}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            for each in ast.walk(node.args):
                if isinstance(each, ast.arg):
                    each.annotation = None
            lines[node.name] = f"function ({ast.unparse(node.args)})"
    return lines


def _line(value):
    if inspect.isclass(value):
        if issubclass(value, enum.Enum):
            return "enumeration"
        if getattr(value, "_is_protocol", False):
            return "protocol"
        return f"class {_parameters(value)}".strip()
    if inspect.ismodule(value):
        return "module"
    if callable(value):
        return f"function {_parameters(getattr(value, 'py_func', value))}"
    return "value"


def _parameters(function):
    """(parameters) with kinds and defaults; empty where Python cannot tell."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return ""
    parameters = [
        each.replace(
            annotation=inspect.Parameter.empty,
            default=each.default if each.default is each.empty else _Text(_default(each.default)),
        )
        for each in signature.parameters.values()
    ]
    text = str(inspect.Signature(parameters))
    return ast.unparse(ast.parse(f"def f{text}: ...").body[0].args).join("()")


class _Text(str):
    """A text whose repr is itself."""

    __slots__ = ()

    def __repr__(self):
        return str(self)


def _default(value):
    """A default as Python's text: the literal, Enumeration.MEMBER, a name, or Class(...)."""
    if isinstance(value, enum.Enum):
        return f"{type(value).__name__}.{value.name}"
    if isinstance(value, tuple):
        items = ", ".join(map(_default, value))
        return f"({items},)" if len(value) == 1 else f"({items})"
    if value is None or isinstance(value, (bool, int, float, str)):
        return repr(value)
    return getattr(value, "__name__", f"{type(value).__name__}(...)")


def _members(kind):
    """Public members that classes of the package give a class: methods, properties, attributes."""
    names = set()
    for base in kind.__mro__:
        if not base.__module__.startswith("attitude"):
            continue
        names |= {name for name in vars(base) if not is_absent(base, name)}
        names |= {*getattr(base, "__annotations__", ()), *_set_in_methods(base)}
    return sorted(name for name in names if not name.startswith("_"))


def _set_in_methods(kind):
    """Attributes that methods assign to self."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(kind)))
    except (OSError, TypeError):
        return set()
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and isinstance(node.ctx, ast.Store)
        and getattr(node.value, "id", None) == "self"
    }


def _member_line(kind, name):
    """A method with its parameters, or "value" for a property or attribute."""
    stored = inspect.getattr_static(kind, name, None)
    if isinstance(stored, (classmethod, staticmethod)):
        return f"{type(stored).__name__} {_parameters(getattr(kind, name))}"
    if inspect.isfunction(stored):
        text = _parameters(stored)
        return "method " + re.sub(r"^\(self(, /)?(, )?", "(", text)
    return "value"


def current():
    """What the package offers: {module: {name: line}}."""
    return {name: signatures(name) for name in public_modules()}


def differences(listed, offered):
    """Sentences: names and parameters that the list has and the module has not, and additions."""
    sentences = []
    optional = {each for lines in (listed, offered) for each in lines if lines[each] == OPTIONAL}
    listed, offered = (
        {
            name: OPTIONAL if name in optional else line
            for name, line in lines.items()
            if name in optional or name.partition(".")[0] not in optional
        }
        for lines in (listed, offered)
    )
    for name, line in listed.items():
        if name not in offered:
            sentences.append(f"{name} is gone; it was {line}.")
        elif offered[name] != line:
            sentences.append(_changed(name, line, offered[name]))
    sentences += [
        f"{name} is new and not in {LIST.name}: {line}."
        for name, line in offered.items()
        if name not in listed
    ]
    return sentences


def _changed(name, before, after):
    old, new = _parameter_names(before), _parameter_names(after)
    gone = [each for each in old if each not in new]
    more = [each for each in new if each not in old]
    what = "The kind, order or default of a parameter changed"
    if before.partition(" ")[0] != after.partition(" ")[0]:
        what = "It is of another kind"
    elif gone or more:
        what = "; ".join(
            f"{word} {', '.join(names)}"
            for word, names in (("it lost", gone), ("it got", more))
            if names
        )
        what = what[0].upper() + what[1:]
    return f"{name} was {before}, and is {after}. {what}."


def _parameter_names(line):
    _, _, parameters = line.partition(" ")
    if not parameters:
        return []
    args = ast.parse(f"def f{parameters}: ...").body[0].args
    return [each.arg for each in ast.walk(args) if isinstance(each, ast.arg)]


LISTED = json.loads(LIST.read_text("utf-8")) if LIST.is_file() else {"modules": {}}


@pytest.mark.parametrize("module", LISTED["modules"])
def test_names_and_parameters_stay(module):
    sentences = differences(LISTED["modules"][module], signatures(module))
    assert not sentences, "\n".join([f"{module}: {each}" for each in sentences] + [COMMAND])


def test_the_list_has_each_public_module():
    missing = [name for name in public_modules() if name not in LISTED["modules"]]
    assert not missing, f"{', '.join(missing)} are public and not listed: {COMMAND}"


def test_pages_and_examples_name_listed_modules():
    """Others than those of `others_named` would be public without anyone having decided it."""
    named = set(named_modules()) - set(LISTED["modules"])
    new = named - set(LISTED["others_named"])
    assert not new, f"docs or examples name {', '.join(sorted(new))}, which are not public"


def test_sentences_say_what_changed():
    """A name that vanishes, a parameter renamed, a default changed, a new name."""
    listed = {
        "read": "function (path, *, frame='icrf')",
        "write": "function (path, low=None)",
        "Body": "class (moments=None)",
        "Body.axes": "value",
    }
    offered = {
        "read": "function (file, *, frame='icrf')",
        "write": "function (path, low=0.0)",
        "Body": "class (moments=None)",
        "extra": "value",
    }
    assert differences(listed, listed) == []
    sentences = differences(listed, offered)
    assert len(sentences) == 4
    assert sentences[0].endswith("It lost path; it got file.")
    assert "default of a parameter changed" in sentences[1]
    assert sentences[2] == "Body.axes is gone; it was value."
    assert sentences[3].startswith("extra is new")


def remake():
    """Write the list, and print what changed."""
    modules = current()
    for module in sorted({*modules, *LISTED["modules"]}):
        before = LISTED["modules"].get(module, {})
        for sentence in differences(before, modules.get(module, {})):
            print(f"{module}: {sentence}")
    others = {name: files for name, files in named_modules().items() if name not in modules}
    written = {"made_by": COMMAND, "others_named": others, "modules": modules}
    LIST.write_text(json.dumps(written, indent=1, ensure_ascii=False) + "\n", "utf-8")
    print(
        f"{LIST.name}: {len(modules)} modules, {sum(map(len, modules.values()))} names; docs and "
        f"examples also name {', '.join(others) or 'no others'}."
    )


if __name__ == "__main__":
    if sys.argv[1:] != ["--remake"]:
        sys.exit(f"The list is written by: {COMMAND}")
    remake()
