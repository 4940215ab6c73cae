"""The site: its links and anchors lead somewhere, and nothing on a page is cut.

Building it takes minutes and the extra `docs`: with `-m slow`.
"""

import importlib.util
import subprocess
import sys

import pytest

from tests.support import browser
from tests.support.places import ROOT

SITE = ROOT / "docs" / "_build" / "html"
# Widths of a desk and of a telephone, px.
WIDTHS = (1280, 390)
# Boxes of code, tables and pictures: what is wider than its own box scrolls there, and the page
# does not.
MEASURE = """() => {
  const cut = [];
  const page = document.documentElement;
  if (page.scrollWidth > page.clientWidth + 1) cut.push(`the page: ${page.scrollWidth} px`);
  for (const box of document.querySelectorAll("article pre, article table, article img")) {
    if (!box.offsetParent) continue;
    const shape = box.getBoundingClientRect();
    let scroller = box;
    while (scroller && !/auto|scroll/.test(getComputedStyle(scroller).overflowX))
      scroller = scroller.parentElement;
    const frame = (scroller || page).getBoundingClientRect();
    const wide = Math.max(shape.right, shape.left + box.scrollWidth) > page.clientWidth + 1;
    const reached = scroller && frame.right <= page.clientWidth + 1 && frame.width > 150;
    if (wide && !reached) cut.push(`${box.tagName} ${box.textContent.slice(0, 50)}`);
  }
  return cut;
}"""


@pytest.fixture(scope="module")
def make_site():
    """docs/make_site.py, as a module."""
    spec = importlib.util.spec_from_file_location("make_site", ROOT / "docs" / "make_site.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_links_that_lead_nowhere_are_found(make_site, tmp_path):
    (tmp_path / "a.html").write_text(
        '<h1 id="top"></h1><a href="b.html#part">1</a><a href="b.html#none">2</a>'
        '<a href="#top">3</a><a href="#bottom">4</a><img src="lost.png">'
        '<a href="https://example.org/x#y">5</a>'
    )
    (tmp_path / "b.html").write_text('<a name="part"></a><a href="a.html">back</a>')
    count, wrong = make_site.broken(tmp_path)
    assert count == 6
    assert wrong == ["a.html: #bottom", "a.html: b.html#none", "a.html: lost.png"]


def test_the_index_of_names_has_a_sentence_for_each(make_site, tmp_path, monkeypatch):
    monkeypatch.setattr(make_site, "DOCS", tmp_path)
    make_site.api_pages()
    index = (tmp_path / "api" / "index.md").read_text()
    rows = [line.split(" | ") for line in index.splitlines() if line.startswith("| ")]
    rows = [row for row in rows if row[0] not in ("| module", "| name", "| ---")]
    assert len(rows) > 300
    short = [row for row in rows if len(row) != 2 or len(row[1]) < 10]
    assert not short
    page = (tmp_path / "api" / "attitude.inversion.md").read_text()
    assert "{py:obj}`spin_states <attitude.inversion.spin_states>`" in page


@pytest.fixture(scope="module")
def site():
    """The pages, built without the results of notebooks."""
    for package in ("sphinx", "furo", "myst_nb", "latex2mathml"):
        pytest.importorskip(package, reason=f"{package} of the extra docs is not installed")
    command = [sys.executable, ROOT / "docs" / "make_site.py", "--no-notebooks"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "0 lead nowhere" in run.stdout
    return SITE


@pytest.mark.slow
def test_nothing_is_cut_on_a_desk_and_on_a_telephone(site):
    pages = [file for file in sorted(site.rglob("*.html")) if "_modules" not in file.parts]
    assert len(pages) > 80
    cut = []
    with browser.running() as chromium:
        for width in WIDTHS:
            page = chromium.new_page(viewport={"width": width, "height": 900})
            for file in pages:
                page.goto(file.as_uri())
                found = page.evaluate(MEASURE)
                cut += [f"{file.relative_to(site)} at {width} px: {each}" for each in found]
            page.close()
    assert not cut, "\n".join(cut)
