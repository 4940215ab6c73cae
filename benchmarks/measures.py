"""How large is the house, and how is it knit?  Files, lines, tokens, rooms, chains and circles.

    python benchmarks/measures.py                # of this checkout
    python benchmarks/measures.py ROOT           # of another one
    python benchmarks/measures.py --folders      # of each folder too, and what its code consists of
    python benchmarks/measures.py -v             # name circles, bases, vague names and long calls

What is counted, of the Python files of attitude/ but those of the subjects that stand on top of the
rest (LATER):

* lines: all.  Lines of code: those not blank, no comment alone and not of a docstring.  Tokens:
  those of Python's tokenize without comments, docstrings, line ends and indentation.
* rooms: files and folders at the top level but `__init__.py`, which is counted, and files that hand
  names on: 16 lines or fewer that are neither blank nor a comment.
* longest chain: the most modules of which each imports the next when it is loaded.  An import
  inside a function is none, and one under `if TYPE_CHECKING:` is one of types.
* circles: sets of modules each of which leads to all others, imports of types counted; those of
  more than one folder, and folders that lead to each other, are counted as `between`.
* bases for one class: classes that have one subclass in the package, in another file, and whose
  name no `__init__.py` down to the second level holds.
* assignments of several names: statements with a tuple of two or more targets on the left.
* vague names: places that assign one of VAGUE, and parameters of such a name, of all files.
* long calls: functions with more than eight positional parameters, without the compiled ones.
* kinds of code: each line of code is counted once, in the first that fits of imports; signatures,
  with decorators; raised errors; constants of modules; fields of classes; bodies of compiled
  functions; other bodies.
"""

import argparse
import ast
import io
import re
import sys
import tokenize
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

PACKAGE = "attitude"
LATER = {"averaged", "proof", "averaged.py", "proof.py"}
VAGUE = ("found", "each", "part", "given", "made", "rest", "here", "own", "near")
KINDS = ("imports", "signatures", "errors", "constants", "fields", "compiled", "bodies")
MOST_POSITIONAL = 8
HANDS_ON = 16
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
SKIPPED_TOKENS = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}
# Decorators of `attitude._compilation`, and callbacks of compiled loops.
COMPILED = re.compile(r"(entry_point|subroutine|inlined|compiled|callback|reduction|intrinsic)")


@dataclass
class Module:
    """A file of the package, and what is counted in it."""

    name: str
    path: Path
    text: str
    tree: ast.Module
    loads: set = field(default_factory=set)
    types: set = field(default_factory=set)

    @cached_property
    def nodes(self):
        """All nodes of the tree."""
        return list(ast.walk(self.tree))

    @cached_property
    def docstrings(self):
        """Numbers of the lines of docstrings."""
        lines = set()
        for node in self.nodes:
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and node.body:
                first = node.body[0]
                value = getattr(first, "value", None) if isinstance(first, ast.Expr) else None
                if isinstance(getattr(value, "value", None), str):
                    lines |= set(range(first.lineno, first.end_lineno + 1))
        return lines

    @property
    def folder(self):
        """The part of the package at the top level that holds the module."""
        return ".".join(self.name.split(".")[:2])


@dataclass
class Measures:
    """What the command prints; lists name what is counted."""

    files: int
    lines: int
    code: int
    tokens: int
    rooms: list
    chain: list
    load_circles: list
    circles: list
    between: list
    bases: list
    several_names: int
    vague: dict
    long_calls: list
    folders: dict


def modules_of(root):
    """{dotted name: Module} of the package in a checkout."""
    modules = {}
    for path in sorted((root / PACKAGE).rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        text = path.read_text("utf-8")
        modules[name] = Module(name, path, text, ast.parse(text))
    return modules


def note_imports(modules):
    """Fill in which of some modules each one loads, and imports for types."""
    for module in modules.values():
        _collect_imports(module, module.tree, module.loads, modules)
        module.loads.discard(module.name)
        module.types.discard(module.name)


def _collect_imports(module, node, into, modules):
    """Add the modules that the statements below a node import when the module is loaded."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (*FUNCTIONS, ast.Lambda)):
            continue
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            for statements, kind in ((child.body, module.types), (child.orelse, into)):
                _collect_imports(module, ast.Module(statements, []), kind, modules)
            continue
        if isinstance(child, ast.ImportFrom):
            source = _source(module, child)
            if source.startswith(PACKAGE) and not LATER & set(source.split(".")[1:2]):
                into |= {
                    _known(f"{source}.{alias.name}", modules) or _known(source, modules)
                    for alias in child.names
                }
        elif isinstance(child, ast.Import):
            into |= {
                _known(alias.name, modules)
                for alias in child.names
                if alias.name.startswith(PACKAGE)
            }
        _collect_imports(module, child, into, modules)


def _source(module, node):
    """The dotted name of the module that `from ... import` names."""
    if node.level == 0:
        return node.module or ""
    parts = module.name.split(".")
    if module.path.name != "__init__.py":
        parts = parts[:-1]
    parts = parts[: len(parts) - (node.level - 1)]
    return ".".join([*parts, *([node.module] if node.module else [])])


def _known(name, modules):
    """The longest beginning of a dotted name that is a module."""
    while name and name not in modules:
        name = name.rpartition(".")[0]
    return name


def kinds_of(module):
    """Lines of code of each of KINDS: neither blank, nor a comment alone, nor of a docstring."""
    kinds = {}
    _collect_kinds(module.tree, "bodies", kinds)
    counts = dict.fromkeys(KINDS, 0)
    for number, line in enumerate(module.text.splitlines(), 1):
        if number not in module.docstrings and _is_code(line):
            counts[kinds.get(number, "bodies")] += 1
    return counts


def _collect_kinds(node, of_bodies, kinds):
    """Note the kind of each line below a node; of_bodies: that of statements in functions."""
    for child in ast.iter_child_nodes(node):
        first, last = getattr(child, "lineno", 0), getattr(child, "end_lineno", 0)
        inner, kind = of_bodies, None
        if isinstance(child, (*FUNCTIONS, ast.ClassDef)):
            if any(COMPILED.search(ast.unparse(d)) for d in child.decorator_list):
                inner = "compiled"
            kinds.update(dict.fromkeys(range(first, last + 1), inner))
            first = min([first, *(d.lineno for d in child.decorator_list)])
            kind, last = "signatures", max(child.lineno, child.body[0].lineno - 1)
        elif isinstance(child, (ast.Import, ast.ImportFrom)):
            kind = "imports"
        elif isinstance(child, ast.Raise):
            kind = "errors"
        elif isinstance(child, (ast.Assign, ast.AnnAssign)):
            kind = {ast.Module: "constants", ast.ClassDef: "fields"}.get(type(node))
        if kind is not None:
            kinds.update(dict.fromkeys(range(first, last + 1), kind))
        _collect_kinds(child, inner, kinds)


def _is_code(line):
    return bool(line.strip()) and not line.strip().startswith("#")


def tokens_of(module):
    """Tokens without comments, docstrings, line ends and indentation."""
    read = tokenize.generate_tokens(io.StringIO(module.text).readline)
    return sum(
        token.type not in SKIPPED_TOKENS
        and not (token.type == tokenize.STRING and token.start[0] in module.docstrings)
        for token in read
    )


def rooms_of(root):
    """Files and folders at the top level, without files that only hand names on."""
    return sorted(
        path.name
        for path in (root / PACKAGE).iterdir()
        if path.name not in LATER | {"__pycache__"}
        and (_is_room(path) if path.suffix == ".py" else any(path.rglob("*.py")))
    )


def _is_room(path):
    is_always = path.name in ("__init__.py", "__main__.py")
    return is_always or sum(map(_is_code, path.read_text("utf-8").splitlines())) > HANDS_ON


def circles_of(graph):
    """Sets of nodes each of which leads to all others of its set (Tarjan's algorithm)."""
    index, low, stack, circles = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph[node]:
            if other not in graph:
                continue
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            place = stack.index(node)
            circle = stack[place:]
            del stack[place:]
            if len(circle) > 1:
                circles.append(sorted(circle))

    for node in graph:
        if node not in index:
            visit(node)
    return sorted(circles, key=lambda circle: (-len(circle), circle))


def longest_chain(graph):
    """The modules of the longest chain of imports."""
    chains = {}

    def chain(node):
        if node not in chains:
            chains[node] = [node]  # ends a circle
            below = [chain(other) for other in sorted(graph[node]) if other in graph]
            chains[node] = [node, *max(below, key=len, default=[])]
        return chains[node]

    return max((chain(node) for node in graph), key=len)


def bases_for_one_class(root, modules):
    """(base, its module, module of the one subclass) of bases that are not public."""
    places, subclasses = {}, {}
    for module in modules.values():
        for node in module.tree.body:
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(module.name)
                for base in node.bases:
                    name = ast.unparse(base).split("[")[0].rpartition(".")[2]
                    subclasses.setdefault(name, []).append(module.name)
    package = root / PACKAGE
    public = " ".join(
        path.read_text("utf-8")
        for pattern in ("__init__.py", "*/__init__.py", "*/*/__init__.py")
        for path in package.glob(pattern)
    )
    return [
        (name, places[name][0], users[0])
        for name, users in subclasses.items()
        if len(users) == len(places.get(name, ())) == 1
        and places[name] != users
        and not re.search(rf"\b{name}\b", public)
    ]


def several_names(module):
    """Statements that assign to a tuple of two or more names."""
    return sum(
        any(isinstance(target, ast.Tuple) and len(target.elts) > 1 for target in node.targets)
        for node in module.nodes
        if isinstance(node, ast.Assign)
    )


def vague_names(module):
    """(name, line) of each place that assigns a vague name, and of each parameter with one."""
    places = []
    for node in module.nodes:
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            places.append((node.lineno, node.col_offset, node.id))
        elif isinstance(node, ast.arg):
            places.append((node.lineno, node.col_offset, node.arg))
    return [(name, line) for line, _, name in sorted(places) if name in VAGUE]


def compiled_by_calls(module):
    """Names of the functions that a call of `attitude._compilation` compiles: loops of a form."""
    return {
        node.id
        for call in module.nodes
        if isinstance(call, ast.Call) and COMPILED.search(ast.unparse(call.func))
        for node in ast.walk(call)
        if isinstance(node, ast.Name)
    }


def long_calls(module):
    """(function, line, count) of functions in Python with too many positional parameters."""
    calls = []
    compiled = compiled_by_calls(module)
    for node in module.nodes:
        if not isinstance(node, FUNCTIONS) or node.name in compiled:
            continue
        if any(COMPILED.search(ast.unparse(decorator)) for decorator in node.decorator_list):
            continue
        count = len(node.args.posonlyargs) + len(node.args.args)
        if count > MOST_POSITIONAL:
            calls.append((node.name, node.lineno, count))
    return calls


def measure(root):
    """The measures of the package in a checkout."""
    every = modules_of(root)
    package = root / PACKAGE
    modules = {
        name: module
        for name, module in every.items()
        if module.path.relative_to(package).parts[0] not in LATER
    }
    note_imports(modules)
    loads = {name: module.loads for name, module in modules.items()}
    both = {name: module.loads | module.types for name, module in modules.items()}
    folders = {}
    for name, others in both.items():
        folder = modules[name].folder
        folders.setdefault(folder, set()).update(modules[other].folder for other in others)
        folders[folder] -= {folder, PACKAGE}
    circles = circles_of(both)
    across = [c for c in circles if len({modules[name].folder for name in c}) > 1]
    sizes = _by_folder(modules)
    files, lines, code, tokens = (sum(row[k] for row in sizes.values()) for k in range(4))
    return Measures(
        files=files,
        lines=lines,
        code=code,
        tokens=tokens,
        rooms=rooms_of(root),
        chain=longest_chain(loads),
        load_circles=circles_of(loads),
        circles=circles,
        between=across + circles_of(folders),
        bases=bases_for_one_class(root, modules),
        several_names=sum(map(several_names, modules.values())),
        vague={name: places for name, m in every.items() if (places := vague_names(m))},
        long_calls=[(name, *call) for name, m in modules.items() for call in long_calls(m)],
        folders=sizes,
    )


def _by_folder(modules):
    """{folder: (files, lines, lines of code, tokens, and lines of code of each of KINDS)}."""
    sums = {}
    for module in modules.values():
        kinds = kinds_of(module).values()
        row = 1, len(module.text.splitlines()), sum(kinds), tokens_of(module), *kinds
        before = sums.get(module.folder, (0,) * len(row))
        sums[module.folder] = tuple(a + b for a, b in zip(before, row, strict=True))
    return sums


def rows_of(measures):
    """(measure, number) of what is printed first."""
    return [
        ("files", measures.files),
        ("lines", measures.lines),
        ("lines of code", measures.code),
        ("tokens", measures.tokens),
        ("rooms at the top level", len(measures.rooms)),
        ("longest import chain at load", len(measures.chain)),
        ("circles at load", len(measures.load_circles)),
        ("circles, imports of types counted", len(measures.circles)),
        ("circles between folders", len(measures.between)),
        ("bases made for one class elsewhere", len(measures.bases)),
        ("assignments of several names", measures.several_names),
        ("vague names", sum(map(len, measures.vague.values()))),
        ("functions of more than 8 positional", len(measures.long_calls)),
    ]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("root", nargs="?", default=Path(__file__).resolve().parent.parent)
    parser.add_argument("--folders", action="store_true", help="a row for each folder")
    parser.add_argument("-v", action="store_true", dest="verbose", help="name what is counted")
    options = parser.parse_args(arguments)
    root = Path(options.root).resolve()
    if not (root / PACKAGE).is_dir():
        parser.error(f"{root} has no folder {PACKAGE}/; give the root of a checkout.")
    measures = measure(root)
    for name, number in rows_of(measures):
        print(f"{name:38}{number:8d}")
    if options.folders:
        titles = ("files", "lines", "code", "tokens", *KINDS)
        print(f"\n{'folder':26}" + "".join(f"{title:>11}" for title in titles))
        rows = sorted(measures.folders.items(), key=lambda item: -item[1][3])
        sums = [sum(column) for column in zip(*measures.folders.values(), strict=True)]
        for name, row in [*rows, ("all", sums)]:
            print(f"{name:26}" + "".join(f"{number:11d}" for number in row))
    if options.verbose:
        print_names(measures)


def print_names(measures):
    """What is behind the numbers."""
    print("\nrooms:", *measures.rooms)
    print("chain:", " > ".join(measures.chain))
    for title, circles in (
        ("circle at load", measures.load_circles),
        ("circle", measures.circles),
        ("between folders", measures.between),
    ):
        for circle in circles:
            print(f"{title} of {len(circle)}: {' '.join(circle)}")
    for name, place, user in measures.bases:
        print(f"base {name} of {place} has its one subclass in {user}")
    counts = dict.fromkeys(VAGUE, 0)
    for places in measures.vague.values():
        for name, _ in places:
            counts[name] += 1
    print("vague names:", ", ".join(f"{name} {count}" for name, count in counts.items()))
    for module, places in measures.vague.items():
        print(f"  {module}:", " ".join(f"{name}:{line}" for name, line in places))
    for module, name, line, count in measures.long_calls:
        print(f"long call: {module}:{line} {name} has {count} positional parameters")


if __name__ == "__main__":
    main(sys.argv[1:])
