"""Sphinx extension: formulas as MathML, which browsers draw without scripts and network."""

from docutils import nodes
from latex2mathml.converter import convert


def _inline(translator, node):
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(translator, node):
    # latex2mathml knows the first of these two equal environments.
    text = node.astext().replace("{aligned}", "{align*}")
    if r"\\" in text and r"\begin" not in text:
        text = rf"\begin{{align*}}{text}\end{{align*}}"
    shown = convert(text, display="block")
    translator.body.append(f'<div class="math" style="margin: 0.7rem 0">{shown}</div>')
    raise nodes.SkipNode


def setup(app):
    """Register the renderer "mathml"."""
    app.add_html_math_renderer(
        "mathml", inline_renderers=(_inline, None), block_renderers=(_block, None)
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}
