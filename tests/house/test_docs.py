"""Pages of docs that are made from the sources are up to date, and their links lead somewhere."""

import ast
import importlib.util
import os
import re
import subprocess
import sys
import tomllib
from contextlib import suppress
from importlib import metadata

import pytest

from tests.support.places import PAGES, ROOT


def _script(name):
    """A script of docs, as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_first_lines_of_docstrings_fit_the_list_of_files():
    """The site lists all files by the first lines of their docstrings."""
    make_map = _script("make_map")
    files = [file for file in make_map.PACKAGE.rglob("*.py") if file.name != "__main__.py"]
    for file in files:
        assert 0 < len(make_map.first_line(file)) <= 100, file
    assert len(list(make_map.lines())) == len(files) - 1  # the package itself has no line


def test_docstrings_of_folders_name_their_files_and_no_others():
    """The map of a folder, with private files as `_name`."""
    count = 0
    for file in (ROOT / "attitude").glob("*/__init__.py"):
        text = ast.get_docstring(ast.parse(file.read_text()))
        files = {each.stem for each in file.parent.glob("*.py")} - {"__init__"}
        named = set(re.findall(r"(?<![\w.])_[a-z]\w*", text))
        assert named <= files, f"{file.parent.name} names {named - files}"
        missing = files - set(re.findall(r"\w+", text))
        assert not missing, f"{file.parent.name} misses {missing}"
        count += len(named)
    assert count > 80


@pytest.mark.parametrize(
    ("page", "most_lines", "most_characters"),
    [
        # what a version does, not how it came
        ("CHANGELOG.md", 60, 125),
        # two screens, one of them the list of folders
        ("docs/architecture.md", 115, 110),
    ],
)
def test_pages_to_be_read_at_once_are_short(page, most_lines, most_characters):
    lines = (ROOT / page).read_text().splitlines()
    assert len(lines) <= most_lines
    assert max(map(len, lines)) <= most_characters


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    text = page.read_text()
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), f"{page.name} links to {target}"
        if anchor and file.suffix == ".md":
            heads = re.findall(r"^#+ (.*)$", file.read_text(), re.MULTILINE)
            names = {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
            assert anchor in names, f"{page.name} links to {target}"


def test_files_that_recipes_name_exist():
    text = (ROOT / "docs" / "architecture.md").read_text()
    named = set(re.findall(r"\b((?:tests|benchmarks|docs)/[\w/]+\.(?:py|md))\b", text))
    assert len(named) > 8
    for name in named:
        assert (ROOT / name).is_file(), name
    folders = set(re.findall(r"\btests/\w+(?![\w./])", text))
    assert {"tests/formats", "tests/inversion"} <= folders
    for name in folders:
        assert (ROOT / name).is_dir(), name
    inside = set(re.findall(r"`(\w+/[\w/]+\.py)`", text)) - named
    assert len(inside) > 15
    for name in inside:
        assert "NAME" in name or (ROOT / "attitude" / name).is_file(), name


def test_the_pages_about_the_inside_name_files_that_exist():
    """File names in backticks, in any folder of the package where none is given."""
    package = ROOT / "attitude"
    files = {file.relative_to(package).as_posix() for file in package.rglob("*.py")}
    files |= {name.rpartition("/")[2] for name in files}
    for page, least in (("compilation.md", 15), ("derivation.md", 20)):
        text = (ROOT / "docs" / page).read_text()
        named = set(re.findall(r"`([\w/]+\.py)`", text))
        assert len(named) > least
        for name in named:
            assert name in files or (ROOT / name).is_file(), f"{page} names {name}"


def test_the_site_shows_every_section_of_mission_files():
    """docs/files.md is made from the docstring of the reader."""
    from attitude.formats import _surface, mission

    assert ".. automodule:: attitude.formats.mission" in (ROOT / "docs" / "files.md").read_text()
    for name in [*mission._KEYS, *_surface._SHAPES, *_surface._ANY_SHAPE]:
        assert re.search(rf"\b{name}\b", mission.__doc__), name


def test_the_gallery_is_that_of_the_examples():
    """Each figure was drawn by the example as it is."""
    made = _script("make_gallery")
    stored = made.stored()
    assert len(stored) >= 3
    assert stored == {name: made.hash_of(name) for name in stored}, "run docs/make_gallery.py"
    assert set(stored) == {file.stem for file in made.FOLDER.glob("*.webp")}
    assert (ROOT / "docs" / "gallery.md").read_text() == made.page()


def test_public_modules_exist_and_pages_are_in_the_site():
    import attitude

    for name in attitude.PUBLIC_MODULES:
        file = ROOT.joinpath(*name.split("."))
        assert file.with_suffix(".py").is_file() or (file / "__init__.py").is_file(), name
    index = (ROOT / "docs" / "index.md").read_text()
    for page in (ROOT / "docs").glob("*.md"):
        assert page.stem == "index" or f"\n{page.stem}\n" in index, f"{page.name} is in no contents"


def test_docs_import_from_public_modules():
    """Functions of own laws are compiled by `attitude.scattering.reduction_subroutine`."""
    import attitude

    pages = [*PAGES, *(ROOT / "docs" / "howto").glob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]
    examples = sorted((ROOT / "examples").glob("*.py"))
    for file in [page for page in pages if "_build" not in page.parts] + examples:
        for name in re.findall(r"\bfrom (attitude[\w.]*) import ", file.read_text()):
            known = name in attitude.PUBLIC_MODULES
            assert known, f"{file.name} imports from {name}"


# Units other than SI and radians, as docstrings spell them behind "in" or a comma, or at the end.
_NOT_SI = {
    "deg": r"deg|degrees?",
    "h": r"h|hours?",
    "d": r"d|days?",
    "km": r"km",
    "au": r"au",
    "arcsec": r"arcsec|arcseconds?",
}


def test_public_numbers_are_si_or_name_their_unit():
    """A public attribute in another unit has the unit at the end of its name."""
    import importlib
    import inspect

    import attitude

    spelled = {unit: re.compile(rf"(?:,|\bin) (?:{each})[.,;]") for unit, each in _NOT_SI.items()}
    seen, bad = set(), []
    for module in attitude.PUBLIC_MODULES:
        try:
            found = importlib.import_module(module)
        except ImportError:  # jax, torch
            continue
        names = getattr(found, "__all__", vars(found))
        classes = []
        for name in names:
            with suppress(attitude.AttitudeError):  # needs a package that is not installed
                classes += filter(inspect.isclass, [getattr(found, name)])
        for owner in classes:
            if owner in seen or not owner.__module__.startswith("attitude"):
                continue
            seen.add(owner)
            docs = {name: each.__doc__ or "" for name, each in vars(owner).items()}
            docs = {name: text.split("\n")[0] for name, text in docs.items() if name[0] != "_"}
            heads = re.findall(
                r"^    (\w[\w, ]*) : .*\n((?:        .*\n)*)", owner.__doc__ or "", re.M
            )
            docs |= {name: text for names, text in heads for name in names.split(", ")}
            for name, text in docs.items():
                for unit, pattern in spelled.items():
                    if pattern.search(text) and not name.endswith(f"_{unit}"):
                        bad.append(f"{owner.__qualname__}.{name}: {text.strip()}")
    assert len(seen) > 80
    # The columns of DAMIT's files, and arguments that take any Quantity.
    assert not [each for each in bad if not each.startswith("DamitLightCurve.")], bad


def _brought_by_the_install_line():
    """Names of all distributions that `pip install .` installs, as the metadata here say."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names, wanted = set(), list(project["dependencies"])
    while wanted:
        given = wanted.pop()
        name = re.match(r"[\w.-]+", given).group().lower().replace("_", "-").replace(".", "-")
        if name not in names and "extra ==" not in given:
            names.add(name)
            with suppress(metadata.PackageNotFoundError):  # for another system or Python
                wanted += metadata.requires(name) or []
    return names


def test_the_first_block_of_the_readme_needs_no_extra(tmp_path):
    """What stands in the first block runs after the first command: no other package can load."""
    block = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    brought = _brought_by_the_install_line()
    others = {
        module
        for module, owners in metadata.packages_distributions().items()
        if not any(re.sub(r"[_.]", "-", each).lower() in brought for each in owners)
    } - {"attitude", "numba", "sitecustomize", "__editable___attitude_propagation_finder"}
    assert "pytest" in others and "numpy" not in others
    hide = f"import sys\nfor name in {sorted(others)!r}:\n    sys.modules[name] = None\n"
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", hide + block],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "toutatis.png").stat().st_size > 10_000


def test_pages_and_messages_install_from_one_place():
    """`validation.SOURCE`; extras in quotes, since zsh expands brackets."""
    from attitude._support import validation

    pages = [*PAGES, *(ROOT / "docs" / "howto").glob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]
    sources = [
        file for folder in ("attitude", "examples") for file in (ROOT / folder).rglob("*.py")
    ]
    wrong, count = [], 0
    for file in [*pages, *sources]:
        for line in file.read_text().splitlines():
            for found in re.findall(
                r'pip install (?:-e )?((?:\\?")?[\w.-]+(?:\[[^\]]*\](?:\\?")?)?)', line
            ):
                is_own = re.match(r'["\\]*(?:\.|attitude)', found) is not None
                count += is_own
                name = re.match(r'["\\]*([\w.-]+)', found).group(1)
                quoted = "[" not in found or '"' in found[:2]
                if is_own and not (name == validation.SOURCE and quoted):
                    wrong.append(f"{file.name}: {line.strip()}")
    assert wrong == [] and count > 5
