"""The README of a package index: its links and pictures are addresses in the repository."""

import importlib.util
import re
import sys
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
