"""The notebooks of the documentation run from beginning to end, and what they say is true."""

import ast
import json
import re

import pytest

from tests.support.places import ROOT

BOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))

# A number that each notebook prints, and the bounds within which its text stays true.
CLAIMS = {
    "asteroid_photometry": (r"best pair: ([\d.]+) and", 5.33, 5.43),  # published 5.38 +- 0.03 d
    "debris_pass": (r"([-\d.]+) mag at", -3.5, -2.0),
    "detumbling": (r"after (\d+) min", 80, 92),
    "impulse": (r"of the push alone: ([\d.]+) deg", 7.0, 16.0),
    "inversion": (r"P_psi ([\d.]+) d", 5.33, 5.43),  # published 5.38 +- 0.03 d
    "fit": (r"predicted sigma: ([\d.]+)", 0.7, 1.4),  # 20 fits: 1 +- 0.16
    "paper": (r"package differ by (\S+)", 0.0, 1e-12),
    # The tilt grows and falls with w sqrt((C - B) (B - A) / (A C)) = 12.01 / s: 2 ln(10) / 12.01 s.
    "t_handle": (r"a tenth of the tilt: ([\d.]+) s", 0.3830, 0.3840),
    "survey": (r"LONG_AXIS +(\d+)", 0.45e4, 0.5e4),
}


def test_each_notebook_has_a_claim():
    assert [path.stem for path in BOOKS] == sorted(CLAIMS)


def _shown(text, names):
    """Run a cell; the value of its last expression, None without one."""
    tree = ast.parse(text)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None


@pytest.mark.parametrize(
    "path",
    [
        # its search, 50 s, is that of the tests of `attitude invert`
        pytest.param(path, marks=[pytest.mark.slow] * (path.stem == "inversion"), id=path.stem)
        for path in BOOKS
    ],
)
def test_the_cells_of_a_notebook_run(path, monkeypatch, capsys):
    """In this process, with 1e4 in place of 1e6 bodies."""
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    monkeypatch.chdir(path.parent)  # where Jupyter and the site run it
    names, figures = {"__name__": "notebook"}, []
    for cell in json.loads(path.read_text())["cells"]:
        if cell["cell_type"] == "code":
            text = "".join(cell["source"]).replace("1_000_000", "10_000")
            shown = _shown(text, names)
            if hasattr(shown, "_repr_png_"):
                figures.append(shown._repr_png_())
            elif hasattr(shown, "_repr_html_"):
                assert shown._repr_html_()
    assert figures and all(each.startswith(b"\x89PNG") for each in figures)
    pattern, least, most = CLAIMS[path.stem]
    assert least <= float(re.search(pattern, capsys.readouterr().out)[1]) <= most


@pytest.mark.slow
@pytest.mark.parametrize("path", BOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_in_a_kernel(path, monkeypatch):
    """Each in a kernel of its own, as a reader runs it; 5 to 40 s."""
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    book = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(
        book, timeout=300, resources={"metadata": {"path": path.parent}}
    ).execute()
    outputs = [out for cell in book.cells for out in cell.get("outputs", ())]
    assert any("image/png" in out.get("data", {}) for out in outputs)
