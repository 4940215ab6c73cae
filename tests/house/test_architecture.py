"""Layers of the package: imports point one way, and importing the package costs little."""

import ast
import importlib
import re
import subprocess
import sys
from functools import cache

import pytest

import attitude
from benchmarks import measures
from tests.support.modules import MODULES, PACKAGE, folder_of, nodes_of, of_modules, tree_of
from tests.support.places import ROOT

# Each row may import from the rows above it, and within a row from the left.  Types count too.
LAYERS = (
    ("errors",),
    ("_support",),
    ("_compilation", "_textfiles"),
    ("_solver", "proof", "scattering", "shape"),
    ("epochs", "light_curve"),
    ("frames",),
    ("paths",),
    ("motions",),
    ("conditions", "catalog", "fitting", "jacobi", "jax", "torch", "plots"),
    ("scene", "torques"),
    ("averaged", "events", "formats", "referee"),
    ("ensemble", "photometry", "viewer"),
    ("inversion", "survey"),
    ("cli", "__main__"),
)
# Paths that hand on the names of other modules: nothing of the package imports them.
HANDED_ON = ("arcs", "published", "quaternion", "representations", "splitting")
PLACE = {name: (row, k) for row, names in enumerate(LAYERS) for k, name in enumerate(names)}
HEAVY = ("numba", "llvmlite", "astropy", "scipy", "skyfield", "matplotlib", "erfa", "jplephem")


# Names of types, which type checkers alone import: a module of any row may be annotated with them.
TYPES = "attitude._support.annotations"


@cache
def _imports(name, *, lazy=True, typed=True):
    """Modules of the package that a module imports.

    Those inside functions only if lazy, those for annotations (`if TYPE_CHECKING:`) only if typed.
    """
    nodes = nodes_of(name) if lazy else _executed(tree_of(name))
    hidden = () if typed else list(_for_type_checkers(name))
    found = set()
    for node in nodes:
        if node in hidden:
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name} imports relatively"
            # from attitude import gates: the module; from attitude.gates import real: its name
            found |= {
                full if (full := f"{node.module}.{alias.name}") in MODULES else node.module
                for alias in node.names
                if alias.name != "__version__"
            }
    found.discard(TYPES)
    return frozenset(each for each in found if each == "attitude" or each.startswith("attitude."))


def _executed(tree):
    """The statements that importing runs: all but the bodies of functions."""
    stack = list(tree.body)
    while stack:
        node = stack.pop()
        yield node
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            stack.extend(ast.iter_child_nodes(node))


@of_modules()
def test_imports_point_to_earlier_layers(name):
    """A module knows the rows above its own, and folders on its left, lazily or not."""
    folder = folder_of(name)
    if folder == "__init__" or folder in HANDED_ON:
        return
    assert folder in PLACE, f"{folder} is not named in LAYERS; add it"
    for other in _imports(name) - {name}:
        there = folder_of(other)
        if there not in (folder, "__init__"):
            assert PLACE[there] < PLACE[folder], f"{name} imports {other}"


def test_every_name_of_the_order_exists():
    """A renamed file must not leave the test of directions empty."""
    for names in (*LAYERS, HANDED_ON):
        for name in names:
            assert (PACKAGE / name).is_dir() or (PACKAGE / f"{name}.py").is_file(), name


def test_architecture_lists_the_folders_in_the_order_of_imports():
    text = (ROOT / "docs" / "architecture.md").read_text()
    block = re.search(r"## Folders\n.*?```text\n(.*?)```", text, re.S).group(1)
    names = [name for line in block.splitlines() for name in line.split("  ")[0].split(", ")]
    assert names == [name for row in LAYERS for name in row if name != "__main__"]
    handed_on = re.search(r"^((?:`\w+`(?:, | and ))*`\w+`) hand on names", text, re.M).group(1)
    assert set(re.findall(r"\w+", handed_on)) - {"and"} == set(HANDED_ON)


@pytest.mark.parametrize("name", HANDED_ON)
def test_earlier_paths_only_hand_names_on(name):
    """No functions or classes of their own, and nothing of the package imports them."""
    tree = tree_of(f"attitude.{name}")
    assert all(isinstance(node, (ast.Expr, ast.ImportFrom, ast.Assign)) for node in tree.body)
    users = [each for each in MODULES if f"attitude.{name}" in _imports(each)]
    assert set(users) <= {"attitude"}, users


def _for_type_checkers(name):
    """The statements inside of `if TYPE_CHECKING:` of a module."""
    for node in nodes_of(name):
        if isinstance(node, ast.If) and getattr(node.test, "id", None) == "TYPE_CHECKING":
            yield from node.body


@of_modules()
def test_annotations_are_imported_by_type_checkers_only(name):
    hidden = list(_for_type_checkers(name))
    for node in nodes_of(name):
        if isinstance(node, ast.ImportFrom) and node.module == TYPES:
            assert node in hidden, f"{name} imports {TYPES} when it runs"


def test_type_checkers_see_the_lazy_names():
    """The names that are imported on first use, from the modules that define them."""
    stub = ast.parse((ROOT / "attitude" / "__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    seen = {node.names[0].asname: node.module for node in imports}
    modules = dict.fromkeys(attitude._MODULES, "attitude")
    errors = {"AttitudeError": "attitude.errors"}
    assert seen == {**modules, **attitude._WHERE, **errors}
    imports = list(_for_type_checkers("attitude.torques"))
    seen = {each.asname: node.module for node in imports for each in node.names}
    assert seen == importlib.import_module("attitude.torques")._WHERE


COMPILERS = ("numba", "llvmlite")


@of_modules(but=("_compilation",))
def test_only_the_compilation_knows_the_compiler(name):
    for node in nodes_of(name):
        found = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        found += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        for each in found:
            assert each.partition(".")[0] not in COMPILERS, f"{name} imports {each}"


# Parsers of text, and functions that open files: numpy's and those of Python's modules too.
PARSERS = ("xml", "tomllib", "csv", "json", "configparser", "codecs", "fileinput", "linecache")
OPENERS = (
    *("open", "fdopen", "read_text", "read_bytes", "write_text", "write_bytes", "open_text"),
    *("loadtxt", "genfromtxt", "fromfile", "fromregex", "savetxt", "tofile"),
)
# Exactly what modules outside of textfiles/ use of these, and why.
ALLOWED_ACCESS = {
    # The summary of a SPICE kernel, checked before SPICE reads it: a binary format.
    "attitude.formats._ck_files": {"open"},
    # FITS, a binary format, is given to astropy as an open file; Parquet has JSON in its schema.
    "attitude.formats.tables": {"open", "json"},
    # An SPK, a binary format, is given to jplephem as an open file.
    "attitude.paths._spk": {"open"},
    # The argument open= of a mesh, not the function.
    "attitude.shape._mesh": {"open"},
    # The sources of the package themselves, of which machine code on disk keeps a hash.
    "attitude._compilation.disk_cache": {"path.read_bytes"},
    # Standard output is turned to the null device after the reader of a pipe has gone.
    "attitude.cli": {"os.open"},
}


def _text_access(name):
    """Parsers that a module imports, and functions that open files it names."""
    found = set()
    for node in nodes_of(name):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names} & {*PARSERS}
        elif isinstance(node, ast.ImportFrom):
            names = {alias.name for alias in node.names} & {*OPENERS}
            found |= names | ({node.module.partition(".")[0]} & {*PARSERS})
        elif isinstance(node, ast.Name) and node.id in OPENERS:
            found.add(node.id)
        elif isinstance(node, ast.Attribute) and node.attr in OPENERS:
            found.add(ast.unparse(node))
    return found


@of_modules(but=("_textfiles",))
def test_only_textfiles_reads_and_parses_text(name):
    """One reader of each notation and one policy for XML: no second one opens or parses files."""
    assert _text_access(name) == ALLOWED_ACCESS.get(name, set()), f"{name}: use attitude._textfiles"


def test_no_cycles():
    """No module leads back to itself, neither when it is loaded nor from inside a function.

    Two files of one folder may name each other's classes in annotations, which nothing runs.
    """
    assert _cycles(lazy=True) == []


def _cycles(lazy):
    """Sets of modules each of which leads to all the others."""
    graph = {name: _imports(name, lazy=lazy, typed=False) - {"attitude"} for name in MODULES}
    reach = {name: _reachable(name, graph) for name in graph}
    found = []
    for name in graph:
        ring = {other for other in reach[name] if name in reach.get(other, ())}
        if len(ring) > 1 and ring not in found:
            found.append(ring)
    return found


def _reachable(name, graph):
    done, stack = set(), [name]
    while stack:
        for other in graph.get(stack.pop(), ()):
            if other not in done:
                done.add(other)
                stack.append(other)
    return done


def test_nothing_is_imported_from_a_file_of_tests():
    """What tests and benchmarks share stands in modules of tests/support/."""
    for folder in ("tests", "benchmarks"):
        for file in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text())):
                modules = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
                if isinstance(node, (ast.Import, ast.ImportFrom)):
                    modules += [alias.name for alias in node.names]
                for module in modules:
                    is_test = re.match(r"(tests\..*)?test_", module)
                    assert not is_test, f"{file.relative_to(ROOT)} imports {module}"


def test_nothing_of_the_package_is_imported_by_the_package_itself():
    """Modules name the module they want; `from attitude import propagate` is for users."""
    for name in MODULES:
        if folder_of(name) not in ("__init__", "cli", "__main__"):
            assert "attitude" not in _imports(name), (
                f"{name} imports names that the package offers to users"
            )


def _loaded_by(statement):
    """Names of the heavy packages that a statement loads, in a fresh process."""
    code = f"import sys\n{statement}\nprint(*[name for name in {HEAVY!r} if name in sys.modules])"
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=PACKAGE.parent,
    )
    return run.stdout.split()


def test_importing_the_package_loads_nothing_heavy():
    assert _loaded_by("import attitude") == []


def test_naming_what_the_package_offers_loads_nothing_heavy():
    """Until it is used."""
    assert _loaded_by("from attitude import Body, FreeRotation, Mode, Spin, propagate") == []
    assert _loaded_by("from attitude import AttitudeHistory") == []
    assert "scipy" not in _loaded_by("from attitude.ensemble import Ensemble")


def test_matplotlib_is_loaded_by_plots_only():
    """It is a dependency, and takes 0.3 s: the main job, `plots` and `viewer` do without."""
    job = "from attitude import cli, inversion, photometry, plots, viewer; "
    job += "cli.main(['propagate', 'toutatis', '--stop', '2 d', '--step', '1 d'])"
    assert "matplotlib" not in _loaded_by(job)
    drawn = (
        "from attitude import catalog, plots; plots.overview(catalog.entry('toutatis').motion())"
    )
    assert "matplotlib" in _loaded_by(drawn)


def test_modules_are_reached_after_importing_the_package():
    reached = "import attitude\nassert attitude.events._windows and attitude.catalog.entry"
    assert "numpy" not in _loaded_by("import attitude")
    run = subprocess.run([sys.executable, "-c", reached], cwd=PACKAGE.parent, check=False)
    assert run.returncode == 0
    public = {name.split(".")[1] for name in attitude.PUBLIC_MODULES if "." in name}
    assert {"catalog", "inversion", "photometry", "viewer", "torques"} <= public
    assert set(dir(attitude)) == {*public, *attitude.__all__, "__version__"}
    without = "import sys, inspect\nsys.modules |= {'jax': None, 'torch': None}\nimport attitude\n"
    each = f"""{without}
for name in set(attitude.PUBLIC_MODULES) - {{'attitude.jax', 'attitude.torch'}}: eval(name)
print(*(name for name, _ in inspect.getmembers(attitude)))
try: from attitude import jax
except ImportError as error: assert 'attitude.jax needs jax: ' in str(error), error
else: assert False"""
    run = subprocess.run(
        [sys.executable, "-c", each], cwd=PACKAGE.parent, check=True, capture_output=True, text=True
    )
    assert public - set(run.stdout.split()) == {"jax", "torch"}


def test_moments_and_plain_epochs_need_nothing_heavy():
    """A body of moments and a spin at an ISO date; erfa, for dates, is small."""
    made = "from attitude import Body, Spin; Body(moments=(1, 2, 2)); "
    made += "Spin(epoch='2026-01-01', wxyz=(1, 0, 0, 0), angular_velocity=(1, 2, 3))"
    assert set(_loaded_by(made)) <= {"erfa"}


def test_the_package_names_what_it_has():
    assert set(attitude.__all__) <= set(dir(attitude))
    for name in attitude.__all__:
        assert getattr(attitude, name).__name__ == name
    with pytest.raises(AttributeError, match="module 'attitude' has no attribute 'quaternions'"):
        _ = attitude.quaternions


# A field and parameters of public names, in `catalog`, `paths` and `scattering`.
MOST_VAGUE_NAMES = 4


def test_the_package_keeps_its_measures():
    """Those of benchmarks/measures.py that the structure fixes; it names circles with -v."""
    counted = measures.measure(ROOT)
    assert counted.files <= 270
    assert len(counted.rooms) <= 32
    assert len(counted.chain) <= 20
    assert counted.between == []
    assert len(counted.circles) <= 6
    assert len(counted.bases) <= 3
    assert not counted.long_calls
    assert sum(map(len, counted.vague.values())) <= MOST_VAGUE_NAMES
