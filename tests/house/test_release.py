"""The README of a package index: its links and pictures are addresses in the repository."""

import importlib.util
import json
import re
import sys
import tomllib
from types import ModuleType, SimpleNamespace

import pytest

from tests.support.places import ROOT

REPOSITORY = "https://example.org/name/attitude"


@pytest.fixture
def build(monkeypatch):
    """hatch_build.py, with a stand-in for the class of hatchling, which is not installed here."""
    parts = "hatchling", "hatchling.metadata", "hatchling.metadata.plugin"
    for name in (*parts, "hatchling.metadata.plugin.interface"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["hatchling.metadata.plugin.interface"].MetadataHookInterface = object
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def metadata(build):
    found = {}
    build.ReadmeAndLinks.update(SimpleNamespace(root=str(ROOT)), found)
    return found


def test_without_an_address_nothing_changes(build, monkeypatch):
    monkeypatch.delenv(build.VARIABLE, raising=False)
    found = metadata(build)
    assert found["readme"]["text"] == (ROOT / "README.md").read_text()
    assert found["urls"] == {"Paper": build.PAPER}


def test_every_link_of_the_readme_leads_to_a_file(build, monkeypatch):
    monkeypatch.setenv(build.VARIABLE, REPOSITORY + "/")
    found = metadata(build)
    text = found["readme"]["text"]
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    assert len(targets) > 50 and all(each.startswith(("https://", "#")) for each in targets)
    own = [each.removeprefix(REPOSITORY) for each in targets if each.startswith(REPOSITORY)]
    assert any(each.startswith("/raw/main/docs/figures/") for each in own)
    for each in own:
        kind, path = re.fullmatch(r"/(raw|blob)/main/([^#]+)(?:#.*)?", each).groups()
        assert (ROOT / path).is_file()
        assert (kind == "raw") == path.endswith((".png", ".webp", ".svg"))
    assert found["urls"]["Source"] == REPOSITORY


def test_a_picture_that_is_a_link(build):
    found = build.absolute("[![a](p.png)](page.md) [b](#c) [d](https://x.y)", "R")
    assert found == "[![a](R/raw/main/p.png)](R/blob/main/page.md) [b](#c) [d](https://x.y)"


# What publishing needs ----------------------------------------------------------------------------


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def parsed(path):
    """The value of a YAML file; `on` of workflows is the key True of YAML 1.1."""
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    return yaml.safe_load((ROOT / path).read_text())


def test_one_version_everywhere():
    import attitude

    version = PROJECT["version"]
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.M).group(1)
    archived = json.loads((ROOT / ".zenodo.json").read_text())
    recipe = (ROOT / "docs" / "release" / "conda" / "recipe.yaml").read_text()
    built = re.search(r'^  version: "(.*)"$', recipe, re.M).group(1)
    assert {attitude.__version__, cited, archived["version"], built} == {version}
    assert archived["license"] == PROJECT["license"]
    assert archived["keywords"] == PROJECT["keywords"]


def test_the_recipe_has_the_dependencies_of_the_package():
    """By name and bounds; conda-forge calls matplotlib without its user interfaces another name."""
    recipe = parsed("docs/release/conda/recipe.yaml")
    run = {re.sub(r"\s", "", each) for each in recipe["requirements"]["run"][1:]}
    wanted = {each.replace("matplotlib", "matplotlib-base") for each in PROJECT["dependencies"]}
    assert run == wanted
    assert f">={recipe['context']['python_min']}" == PROJECT["requires-python"]
    assert recipe["build"]["python"]["entry_points"] == [
        f"{name} = {where}" for name, where in PROJECT["scripts"].items()
    ]
    assert recipe["about"]["summary"] == PROJECT["description"]


def test_the_workflows_test_what_the_package_says_it_runs_on():
    jobs = parsed(".github/workflows/tests.yml")["jobs"]
    matrix = jobs["suite"]["strategy"]["matrix"]
    assert {each.split("-")[0] for each in matrix["os"]} == {"ubuntu", "macos", "windows"}
    tested = {*matrix["python"], *(each["python"] for each in matrix["include"])}
    named = {
        each.rpartition(" ")[2] for each in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", each)
    }
    assert tested == named
    extras = set(PROJECT["optional-dependencies"])
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text()
    assert set(re.findall(r'"\.\[(.*?)\]"', text)) <= extras


def test_a_release_is_built_tried_and_then_published():
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text()
    jobs = parsed(".github/workflows/release.yml")["jobs"]
    assert jobs["try"]["needs"] == "build" and jobs["publish"]["needs"] == "try"
    assert jobs["publish"]["permissions"] == {"id-token": "write"}
    # The tag is compared with the line that pyproject.toml has.
    line = re.search(r'grep -qx "(.*?)" pyproject', text).group(1).replace('\\"', '"')
    assert line.replace("${GITHUB_REF_NAME#v}", PROJECT["version"]) in (
        (ROOT / "pyproject.toml").read_text().splitlines()
    )
    commands = [each["run"] for job in jobs.values() for each in job["steps"] if "run" in each]
    assert (
        'attitude propagate toutatis --start 1992-12-02 --stop 1992-12-19 --step "1 d"' in commands
    )
