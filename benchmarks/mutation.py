"""Would the tests notice a wrong constant or operator in the code of the solution?

python benchmarks/mutation.py                     all modules of MODULES
python benchmarks/mutation.py twofloat elliptic   some of them
python benchmarks/mutation.py --list series       the changes, without running them
python benchmarks/mutation.py --table             the table of docs/accuracy.md
python benchmarks/mutation.py --log FILE          append each result to FILE; what it has is not
                                                  run again: a run that was stopped goes on
python benchmarks/mutation.py --workers 4         processes; 2 if not said

Constants and operators are changed one by one.  Each change is imported in a process of its own,
not compiled, and runs the checks of `tests/support/battery.py` until one fails: then the change
is killed.  `tests/data/equivalent_changes.toml` has the reason why each of the others changes
nothing that can be observed.  Of the modules of derivatives a random sample is run.
"""

from __future__ import annotations

import ast
import copy
import hashlib
import importlib.util
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.doc_tables import Table, markdown

MAKES = ("mutation",)
EQUIVALENT = ROOT / "tests" / "data" / "equivalent_changes.toml"

# The chain from a state to its attitudes, pairs of doubles, quaternions and elliptic functions,
# axes of tensors, and periods.
MODULES = {
    "twofloat": "attitude._solver.twofloat",
    "pairs": "attitude._support.pairs",
    "series": "attitude._solver.series",
    "kernel": "attitude._solver.kernel",
    "constants": "attitude._solver.constants",
    "elliptic": "attitude._solver.elliptic",
    "quaternion": "attitude.frames.quaternion",
    "jacobi": "attitude.jacobi._jacobi",
    "steps": "attitude.jacobi._steps",
    "principal_axes": "attitude._solver.principal_axes",
    "regime_loops": "attitude._solver.regime_loops",
    "regime": "attitude._solver.regime",
}
# Derivatives of attitudes.  Their checks take twenty seconds where they pass: of all changes of
# these modules together SAMPLE are run, drawn by `random.Random(SEED)`.
SAMPLED = {
    name: f"attitude._solver.{name}"
    for name in (
        *("derivatives", "tangents", "uniform_tangents", "short_times", "columns"),
        *("sensitivity_loops", "sensitivities"),
    )
}
# Changes of the modules of SAMPLED that are drawn, and the seed of the draw.
SAMPLE = 400
SEED = 38
# Seconds of processor after which a change counts as killed: a loop without end.
PATIENCE = 15
# The checks of derivatives take a third of this where they pass.
PATIENCE_OF_DERIVATIVES = 60

_OPERATORS = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.FloorDiv: (ast.Mult,),
    ast.Mod: (ast.FloorDiv,),
    ast.Pow: (ast.Mult,),
    ast.BitAnd: (ast.BitOr,),
    ast.BitOr: (ast.BitAnd,),
    ast.BitXor: (ast.BitAnd,),
    ast.LShift: (ast.RShift,),
    ast.RShift: (ast.LShift,),
    ast.MatMult: (ast.Add,),
}
# Each comparison with the other boundary, and the other way round.
_COMPARISONS = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
}


@dataclass
class Change:
    """One change of a module: its name, without lines; the tree, the node and what is done."""

    module: str
    name: str
    tree: ast.Module = field(repr=False)
    node: ast.AST = field(repr=False)
    change: tuple = ()


class _Sites(ast.NodeVisitor):
    """Every node that can be changed, with its function and statement."""

    def __init__(self):
        self.found, self._where, self._statement = [], [], None

    def visit(self, node):
        if isinstance(node, ast.stmt):
            before, self._statement = self._statement, node
            super().visit(node)
            self._statement = before
        else:
            super().visit(node)

    def visit_FunctionDef(self, node):
        self._where.append(node.name)
        for child in [*node.args.defaults, *node.args.kw_defaults, *node.body]:
            if child is not None:
                self.visit(child)
        self._where.pop()

    def visit_ClassDef(self, node):
        self._where.append(node.name)
        for child in node.body:
            self.visit(child)
        self._where.pop()

    def visit_AnnAssign(self, node):
        if node.value is not None:
            self.visit(node.value)

    def visit_If(self, node):
        is_typing = isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        if not is_typing:
            self.generic_visit(node)

    def visit_Raise(self, node):
        """Sentences of errors are left as they are."""

    def visit_Import(self, node):
        pass

    visit_ImportFrom = visit_Import

    def _add(self, node, changes):
        where = ".".join(self._where)
        self.found += [(node, change, where, self._statement) for change in changes]

    def visit_BinOp(self, node):
        self._add(node, [("op", kind()) for kind in _OPERATORS.get(type(node.op), ())])
        self.generic_visit(node)

    def visit_AugAssign(self, node):
        self._add(node, [("op", kind()) for kind in _OPERATORS.get(type(node.op), ())])
        self.generic_visit(node)

    def visit_Compare(self, node):
        for k, operator in enumerate(node.ops):
            self._add(node, [("ops", k, kind()) for kind in _COMPARISONS[type(operator)]])
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        self._add(node, [("op", other)])
        self.generic_visit(node)

    def visit_UnaryOp(self, node):
        self._add(node, [("bare",)])
        self.generic_visit(node)

    def visit_Constant(self, node):
        self._add(node, [("value", value) for value in _other_values(node.value)])

    def visit_JoinedStr(self, node):
        pass

    def visit_Break(self, node):
        self._add(node, [("pass",)])

    visit_Continue = visit_Break


def _other_values(value):
    """What a constant is changed to."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1]
    if isinstance(value, float):
        # beyond 2^53 a double and the next whole number are the same
        values = [value + 1.0 if value + 1.0 != value else 2.0 * value]
        digits = repr(value).replace(".", "").replace("-", "").split("e")[0].strip("0")
        if len(digits) >= 12:
            values.append(value * (1.0 + 1e-12))
        return values
    return []


class _Replaced(ast.NodeTransformer):
    """Change the one node that has a mark."""

    def __init__(self, change):
        self._change = change

    def visit(self, node):
        if not hasattr(node, "is_changed"):
            return self.generic_visit(node)
        kind, *rest = self._change
        if kind == "bare":
            return node.operand
        if kind == "pass":
            return ast.copy_location(ast.Pass(), node)
        if kind == "op":
            node.op = rest[0]
        elif kind == "ops":
            node.ops[rest[0]] = rest[1]
        else:
            node.value = rest[0]
        return node


def _header(statement):
    """The text of a statement without what it contains."""
    return ast.unparse(statement).splitlines()[0]


def _named(statement, change):
    """The text of a statement with [before|after] where a marked node is changed."""
    before = _header(statement)
    after = _header(_Replaced(change).visit(copy.deepcopy(statement)))
    first = next(
        (k for k, (x, y) in enumerate(zip(before, after, strict=False)) if x != y),
        min(len(before), len(after)),
    )
    most = min(len(before), len(after)) - first
    last = next((k for k in range(most) if before[-1 - k] != after[-1 - k]), most)
    ends = len(before) - last, len(after) - last
    left, right = before[:first], before[ends[0] :]
    left = left if len(left) <= 44 else "..." + left[-40:]
    right = right if len(right) <= 34 else right[:30] + "..."
    return f"{left}[{before[first : ends[0]]}|{after[first : ends[1]]}]{right}"


def _name_of(module):
    return {**MODULES, **SAMPLED}[module]


def _file_of(module):
    return _name_of(module).replace(".", "/")


def changes_of(module):
    """All changes of a module, in the order of its source."""
    path = ROOT / f"{_file_of(module)}.py"
    tree = ast.parse(path.read_text(encoding="utf-8"))
    sites = _Sites()
    sites.visit(tree)
    changes, names = [], Counter()
    for node, change, where, statement in sites.found:
        node.is_changed = True
        name = f"{module}.{where or 'constants'}: {_named(statement, change)}"
        del node.is_changed
        names[name] += 1
        if names[name] > 1:
            name += f" ({names[name]})"
        changes.append(Change(module, name, tree, node, change))
    return changes


def chosen_changes(modules):
    """All changes of modules, and of those of SAMPLED the ones that are drawn."""
    chosen = [change for name in modules if name in MODULES for change in changes_of(name)]
    pool = [change for name in SAMPLED for change in changes_of(name)]
    drawn = {change.name for change in Random(SEED).sample(pool, SAMPLE)}
    return chosen + [x for x in pool if x.name in drawn and x.module in modules]


# ---- Running a change


class _Finder:
    """Imports one module from a changed tree."""

    def __init__(self, name, tree):
        self._name, self._tree = name, tree

    def find_spec(self, name, path=None, target=None):
        if name != self._name:
            return None
        file = ROOT / (name.replace(".", "/") + ".py")
        return importlib.util.spec_from_loader(name, self, origin=str(file))

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        file = str(ROOT / (self._name.replace(".", "/") + ".py"))
        module.__file__ = file
        exec(compile(self._tree, file, "exec"), module.__dict__)


# Checks that look first at each module, by what they kill in the shortest time.
_FIRST = {
    "twofloat": ("pairs", "expansions"),
    "pairs": ("pairs_of_arrays", "epochs"),
    "series": ("sines", "phases", "coefficients"),
    "kernel": ("quaternions", "attitudes"),
    "constants": ("attitudes", "records", "limits"),
    "elliptic": ("integrals",),
    "quaternion": ("quaternions", "units", "forms_of_attitudes"),
    "jacobi": ("jacobi",),
    "steps": ("steps",),
    "principal_axes": ("wide_numbers", "principal_axes", "diagonal_tensors"),
    "regime_loops": ("cycles", "uniform_regimes", "periods"),
    "regime": ("blocks_of_regimes", "uniform_regimes", "periods"),
}


def _checks_for(module, names):
    """The names of the checks of a change, in order: those of derivatives, or all others."""
    from tests.support.battery import OF_DERIVATIVES

    if module in SAMPLED:
        return OF_DERIVATIVES
    first = _FIRST[module]
    return [*first, *(x for x in names if x not in first and x not in OF_DERIVATIVES)]


def _run(change, truths, out):
    """In a process of its own: import the change, run the checks; write what kills it."""
    patience = PATIENCE_OF_DERIVATIVES if change.module in SAMPLED else PATIENCE
    limit = int(time.process_time()) + patience
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
    signal.alarm(20 * patience)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    check = "import"
    try:
        change.node.is_changed = True
        tree = ast.fix_missing_locations(_Replaced(change.change).visit(change.tree))
        sys.meta_path.insert(0, _Finder(_name_of(change.module), tree))
        from tests.support import battery

        for check in _checks_for(change.module, battery.CHECKS):
            battery.CHECKS[check](truths)
    except BaseException as err:
        os.write(out, f"{check}: {type(err).__name__}".encode())
        os._exit(1)
    os._exit(0)


def _outcome(change, truths):
    """What killed a change, or "" if it survived."""
    source, target = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(source)
        _run(change, truths, target)
    os.close(target)
    with os.fdopen(source) as stream:
        text = stream.read()
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code in (-signal.SIGTERM, -signal.SIGINT, -signal.SIGHUP):
        os._exit(1)  # the run is stopped: that says nothing of the change
    return "" if code == 0 else text or "no end"


def _forget():
    """Let the package and the checks be imported anew."""
    for name in [name for name in sys.modules if name.split(".")[0] in ("attitude", "tests")]:
        del sys.modules[name]


def _digest():
    """A number of the sources of the package and of its checks."""
    files = [*(ROOT / "attitude").rglob("*.py"), *(ROOT / "tests" / "support").glob("*.py")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()


def _logged(log):
    """The results of a file, which begins with the number of the sources; made if it is not."""
    digest = _digest()
    lines = log.read_text().splitlines() if log.exists() else []
    if not lines:
        log.write_text(f"{digest}\n")
    elif lines[0] != digest:
        sys.exit(f"{log} is of other sources of the package or of its checks; name another file.")
    # the last line of a run that was stopped may be half a line
    whole = [line for line in lines[1:] if line.endswith("]")]
    if len(whole) < len(lines) - 1:
        log.write_text("\n".join([digest, *whole]) + "\n")
    return dict(map(json.loads, whole))


def outcomes(changes, log, workers=2):
    """Name -> what killed it, or "" for what survived; in processes that fork for each change.

    Each result is appended to the file `log`; what it has already is not run again.
    """
    found = _logged(log)
    left = [change for change in changes if change.name not in found]
    if left:
        _run_all(left, log, workers, bool(found))
    found = _logged(log)
    return {change.name: found[change.name] for change in changes}


def _run_all(changes, log, workers, goes_on):
    os.environ["ATTITUDE_COMPILE"] = "never"  # before the package is imported
    from tests.support import battery

    truths = battery.truths()
    if not goes_on:
        for check in battery.CHECKS.values():
            check(truths)  # unchanged, all pass
    _forget()
    for worker in range(workers):
        if os.fork() == 0:
            with log.open("a") as stream:
                for change in changes[worker::workers]:
                    line = json.dumps([change.name, _outcome(change, truths)])
                    stream.write(f"{line}\n")  # in one piece
                    stream.flush()
            os._exit(0)
    for _ in range(workers):
        os.wait()


def equivalent():
    """Name -> the reason why a change changes nothing that can be observed."""
    table = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))
    return {name: reason for reason, names in table.items() for name in names}


def summary(killers):
    """Module -> (changes, killed, equivalent, survivors without a reason)."""
    reasons = equivalent()
    rows = {}
    for name, killer in killers.items():
        row = rows.setdefault(name.split(".")[0], [0, 0, 0, []])
        row[0] += 1
        if killer:
            row[1] += 1
        elif name in reasons:
            row[2] += 1
        else:
            row[3].append(name)
    return rows


def shares(rows):
    """Per cent of all changes that were killed, and of those that are not equivalent."""
    count, killed, same = (sum(row[k] for row in rows.values()) for k in range(3))
    return 100.0 * killed / count, 100.0 * killed / (count - same)


def tables(quick):
    """The table of docs/accuracy.md; from a process of its own, which compiles nothing."""
    if not quick:
        command = [sys.executable, __file__, "--table"]
        yield Table("mutation", subprocess.run(command, capture_output=True, text=True).stdout)


def _table(rows):
    """Changes of each module in Markdown."""
    cells = [
        (f"`{_file_of(name)}.py`", count, killed, same, len(left))
        for name, (count, killed, same, left) in rows.items()
    ]
    cells.append(("in all", *(sum(row[k] for row in cells) for k in range(1, 5))))
    cells = [(*row, f"{100.0 * row[2] / (row[1] - row[3]):.1f} %") for row in cells]
    pools = {_file_of(name): len(changes_of(name)) for name in rows if name in SAMPLED}
    cells = [
        (name, f"{count} of {pools[name[1:-4]]}" if name[1:-4] in pools else count, *others)
        for name, count, *others in cells
    ]
    header = ("module", "changes", "killed", "equivalent", "others left", "killed of the others")
    of_all, of_others = shares(rows)
    killed = f"{of_all:.1f} % of all changes, {of_others:.1f} % of those that are not equivalent"
    rows = [tuple(map(str, row)) for row in cells]
    sample = f"of the modules of derivatives, {SAMPLE} changes drawn with the seed {SEED}"
    day = time.strftime("%Y-%m-%d")
    return f"{markdown(header, rows)}\n\nKilled are {killed}; {sample}; run of {day}.\n"


def main(arguments):
    """Print what survives; the exit code is 1 below 98 % of those that are not equivalent, for
    survivors without a reason, and for reasons of what is killed.
    """
    arguments, log = list(arguments), Path(tempfile.mkdtemp()) / "log"
    workers = 2
    if "--log" in arguments:
        place = arguments.index("--log")
        _, log = arguments.pop(place), Path(arguments.pop(place))
    if "--workers" in arguments:
        place = arguments.index("--workers")
        _, workers = arguments.pop(place), int(arguments.pop(place))
    names = [x for x in arguments if not x.startswith("-")] or [*MODULES, *SAMPLED]
    changes = chosen_changes(names)
    if "--list" in arguments:
        print(*(change.name for change in changes), sep="\n")
        return 0
    start = time.perf_counter()
    found = outcomes(changes, log, workers)
    rows = summary(found)
    if "--table" in arguments:
        print(_table(rows), end="")
        return 0
    for module, (count, killed, same, left) in rows.items():
        print(f"{module}: {count} changes, {killed} killed, {same} equivalent, {len(left)} left")
        print(*(f"    {name}" for name in left), sep="\n")
    of_all, of_others = shares(rows)
    killed = sum(row[1] for row in rows.values())
    print(
        f"{killed} of {len(found)} changes killed, {of_all:.1f} %; {of_others:.1f} % of those that "
        f"are not equivalent; {time.perf_counter() - start:.0f} s"
    )
    print("by", dict(Counter(x.split(":")[0] for x in found.values() if x).most_common()))
    stale = [name for name in equivalent() if found.get(name)]
    print(*(f"named equivalent, but killed: {name}" for name in stale), sep="\n")
    return int(of_others < 98.0 or any(row[3] for row in rows.values()) or bool(stale))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
