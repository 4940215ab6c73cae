"""The block for Celestia in docs/howto/other_tools.md: its grammar, its files and its axes."""

import re
import shlex

import numpy as np
import pytest

from attitude import catalog, cli
from attitude.frames import matrix_to_icrf
from tests.support.places import ROOT

PAGE = (ROOT / "docs" / "howto" / "other_tools.md").read_text()
BLOCK = re.search(r'```text\n("Toutatis.*?)```', PAGE, re.DOTALL)[1]
TOKENS = re.compile(r'\s*("[^"]*"|[A-Za-z]\w*|[-+]?[\d.]+(?:[eE][-+]?\d+)?|[][{}])')
# Keys of the rotation in CreateSpiceRotation of Celestia's src/celengine/parseobject.cpp.
KEYS = {"Kernel", "Frame", "BaseFrame", "Period", "Beginning", "Ending"}
# SPICE's name of the axes of each frame of a body.
AXES = {"EclipticJ2000": "ECLIPJ2000", "EquatorJ2000": "J2000"}


def tokens(text):
    """Strings, names, numbers and brackets of an .ssc file; nothing else may stand there."""
    at, found = 0, []
    while text[at:].strip():
        match = TOKENS.match(text, at)
        assert match, text[at:]
        found.append(match[1])
        at = match.end()
    return found


def value(tokens):
    """A value of the grammar: a block of names with values, an array, or one token."""
    token = tokens.pop(0)
    if token == "{":
        block = {}
        while tokens[0] != "}":
            name = tokens.pop(0)
            assert name.isidentifier() and name not in block
            block[name] = value(tokens)
        tokens.pop(0)
        return block
    if token == "[":
        row = []
        while tokens[0] != "]":
            row.append(value(tokens))
        tokens.pop(0)
        return row
    assert token not in "}]"
    return token.strip('"') if token[0] == '"' else float(token)


def body():
    name, parent, *rest = tokens(BLOCK)
    assert name[0] == parent[0] == '"'
    block = value(rest)
    assert not rest
    return block


def test_the_block_is_what_celestia_parses():
    block = body()
    spin = block["SpiceRotation"]
    assert set(spin) <= KEYS and ("Beginning" in spin) == ("Ending" in spin)
    (axes,) = block["BodyFrame"]
    assert AXES[axes] == spin["BaseFrame"]
    for each in (spin["Beginning"], spin["Ending"]):
        assert re.fullmatch(r"\d{4} \d\d \d\d \d\d:\d\d:\d\d", each)


def test_its_files_and_axes_are_those_of_the_motion(tmp_path, monkeypatch):
    """Beginning and end lie within the C-kernel that the page's command writes."""
    spiceypy = pytest.importorskip("spiceypy", reason="spiceypy is not installed")
    command = shlex.split(re.search(r"^attitude (convert toutatis data/.*)$", PAGE, re.M)[1])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    assert cli.main(command) == 0
    spin = body()["SpiceRotation"]
    assert sorted(spin["Kernel"]) == sorted(file.name for file in (tmp_path / "data").iterdir())
    history = catalog.entry("toutatis").motion().at(["1992-12-02T01:00", "1992-12-29T12:00"])
    with spiceypy.KernelPool([str(tmp_path / "data" / name) for name in spin["Kernel"]]):
        since_j2000 = history.epoch.seconds + history.seconds
        found = [spiceypy.pxform(spin["Frame"], spin["BaseFrame"], t) for t in since_j2000]
    expected = matrix_to_icrf("ecliptic").T @ history.matrix
    assert np.allclose(found, expected, rtol=0, atol=2e-6)
