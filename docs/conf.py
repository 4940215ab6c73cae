"""The site: ``python docs/make_site.py`` builds it, without a network, with warnings as errors."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "docs"))

import attitude

project = "attitude"
author = "the attitude developers"
version = release = attitude.__version__
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "myst_nb",
    "mathml",
]
html_math_renderer = "mathml"
exclude_patterns = ["_build", "figures"]
html_show_copyright = False
html_theme = "furo"
html_title = "attitude"
html_static_path = ["static"]
html_css_files = ["attitude.css"]
# Pages link to headings of other pages, as on the forge.
myst_heading_anchors = 4
myst_fence_as_directive = ["math"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
suppress_warnings = [
    "myst.xref_missing",  # links to scripts, data and tests, which are no part of the site
    "myst.header",
    "ref.python",  # a word of a docstring that several classes have as an attribute
    "misc.highlighting_failure",  # cells with "..." or of two languages
]
autodoc_mock_imports = ["jax", "torch"]
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_typehints = "none"
autodoc_member_order = "groupwise"
default_role = "py:obj"


def _readable(app, what, name, obj, options, lines):
    """Docstrings as reStructuredText: maps of modules as they stand, |x| as absolute values."""
    if what == "module":
        lines[:] = _public(lines)
    found, in_map = [], False
    has_table = any(line.startswith("====") for line in lines)
    for line in lines:
        starts = (
            what == "module" and not has_table and re.match(r"[\w`*]\S*(,? \S+)*\s{2,}\S", line)
        )
        if starts and not in_map:
            found += ["", "::", ""]
        was_in_map, in_map = in_map, bool(starts) or (in_map and line.startswith(" "))
        if was_in_map and not in_map:
            found.append("")
        if in_map:
            found.append(f"    {line}")
        else:
            found.append(re.sub(r"\|(?=\S)", r"\\|", line))
    lines[:] = found


def _public(lines):
    """The docstring of a folder without the map of its private files."""
    kept, private = [], False
    for line in lines:
        private = re.match(r"_\w+(, _\w+)*\s{2,}", line) or (private and line.startswith(" "))
        if not private:
            kept.append(line)
    return kept


def _back_links(app, exception):
    """Links of pages of sources back to the API: viewcode knows one public module for each file.

    The names of a file may be on the pages of several: each is on its own page by the page's name.
    """
    if exception or app.builder.name != "html":
        return
    for file in Path(app.outdir, "_modules").rglob("*.html"):
        text = file.read_text("utf-8")
        mended = re.sub(
            r'(href="[./]*/api/)([\w.]+)(\.html#)[\w.]+?\.((?:[A-Z]\w*\.)?\w+")',
            r"\1\2\3\2.\4",
            text,
        )
        if mended != text:
            file.write_text(mended, "utf-8")


def setup(app):
    """Connect the changes of docstrings and of links."""
    app.connect("autodoc-process-docstring", _readable, priority=900)
    app.connect("build-finished", _back_links)
