"""HTML of tables and SVG of small line plots, for objects that notebooks show."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support.constants import COLORS

if TYPE_CHECKING:
    from numpy.typing import NDArray


# Epochs of a table of attitudes.
_SHOWN = 5
# Pixels of a picture and of the edge about it.
_WIDTH = 260.0
_HEIGHT = 150.0
_EDGE = 8.0
# Points of a line that are drawn.
_MOST = 600


def rows_of(text: str) -> tuple[str, list[tuple[str, str]]]:
    r"""The first line of a description, and names and values of its other lines.

    >>> rows_of("Short-axis mode\n  period psi   2.3 s\n               at the epoch")
    ('Short-axis mode', [('period psi', '2.3 s'), ('', 'at the epoch')])
    """
    head, *lines = text.splitlines()
    rows = []
    for line in lines:
        name, _, value = re.sub(r"\s{2,}", "\t", line.strip()).partition("\t")
        rows.append((name, value) if value else _alone(line, name))
    return head, rows


def _alone(line: str, text: str) -> tuple[str, str]:
    """A line of one column: the value of the name above it if it is indented far."""
    is_value = len(line) - len(line.lstrip()) > 8
    return ("", text) if is_value else (text, "")


def table(head: str, rows: Iterable[Sequence[str]], *pictures: str) -> str:
    """An HTML table of texts under a heading, with pictures (SVG) beside it."""
    cells = "".join(
        "<tr>"
        + "".join(f'<td style="text-align:left">{html.escape(str(cell))}</td>' for cell in row)
        + "</tr>"
        for row in rows
    )
    beside = "".join(f'<div style="margin-left:1em">{picture}</div>' for picture in pictures)
    return (
        '<div style="display:flex;align-items:flex-start;flex-wrap:wrap">'
        f'<div><b>{html.escape(head)}</b><table style="font-size:90%">{cells}</table></div>'
        f"{beside}</div>"
    )


def of_table(head: str, columns: Any, most: int = 12, *pictures: str) -> str:
    """The first rows of an astropy table under a heading, with units, and pictures beside them."""
    names = list(columns.colnames)
    shown = columns[:most]
    units = [getattr(columns[name], "unit", None) for name in names]
    heads = [f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True)]
    texts = [_texts(shown[name]) for name in names]
    rows = [heads, *map(list, zip(*texts, strict=True))]
    if len(columns) > most:
        rows.append([f"... {len(columns)} in all", *[""] * (len(names) - 1)])
    return table(head, rows, *pictures)


def _texts(column: Any) -> list[str]:
    """The entries of a column of a table, numbers to six digits."""
    texts = []
    for entry in column:
        value = getattr(entry, "value", entry)
        is_array = isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype.kind == "f"
        is_number = is_array or isinstance(value, (float, np.floating))
        texts.append(f"{float(value):.6g}" if is_number else str(value))
    return texts


def described(text: str, span: Sequence[object] | None) -> str:
    """A table of a description, or of its one line and the ends of a span."""
    head, rows = rows_of(text)
    ends = zip(("from", "to"), span or (), strict=False)
    return table(head, rows or [(name, str(value)) for name, value in ends])


def attitudes(head: str, seconds: NDArray[np.float64], wxyz: NDArray[np.float64]) -> str:
    """A table of the first of some attitudes (S, 4), and their components against time."""
    if seconds.ndim > 1:
        return table(head, [])
    times, rows = seconds.reshape(-1), wxyz.reshape(-1, 4)
    cells: list[tuple[str, ...]] = [("s since the epoch", "w", "x", "y", "z")]
    cells += [
        (f"{t:.9g}", *(f"{number:.6f}" for number in q))
        for t, q in zip(times[:_SHOWN].tolist(), rows[:_SHOWN].tolist(), strict=True)
    ]
    if len(times) > _SHOWN:
        cells.append(("...", "", "", "", ""))
    if len(times) < 3:
        return table(head, cells)
    lines = [(times, rows[:, k]) for k in range(4)]
    colors = ("#444444", *COLORS)
    return table(head, cells, line_plot(lines, "w, x, y, z against time", colors=colors))


def line_plot(
    lines: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
    caption: str,
    *,
    colors: Sequence[str] = COLORS,
    is_equal: bool = False,
    is_downward: bool = False,
    is_dotted: bool = False,
) -> str:
    """An SVG of lines (x, y) of one scale, with a caption; points that are not finite are gaps.

    `is_equal`: one scale for x and y.  `is_downward`: y grows downwards, as magnitudes do.
    `is_dotted`: a dot for each point in place of lines.
    """
    curves = [np.stack(line, axis=1) for line in lines]
    finite = np.concatenate([rows[np.isfinite(rows).all(axis=1)] for rows in curves])
    if not finite.size:
        return ""
    low, width = finite.min(axis=0), np.ptp(finite, axis=0)
    width = np.where(width > 0.0, width, 1.0)
    room = np.array([_WIDTH, _HEIGHT]) - 2.0 * _EDGE
    scale = np.full(2, np.min(room / width)) if is_equal else room / width
    paths = []
    for k, rows in enumerate(curves):
        chosen = np.linspace(0, len(rows) - 1, min(len(rows), _MOST)).astype(np.int64)
        points = (rows[chosen] - low) * scale + _EDGE
        if not is_downward:
            points[:, 1] = _HEIGHT - points[:, 1]
        color = colors[k % len(colors)]
        dots = ' stroke-linecap="round" stroke-width="2.5"' if is_dotted else ""
        drawn = _path(points, is_dotted=is_dotted)
        paths.append(f'<path d="{drawn}" fill="none" stroke="{color}"{dots}/>')
    return _figure(_WIDTH, "".join(paths), caption)


def solid(corners: NDArray[np.float64], normals: NDArray[np.float64], caption: str) -> str:
    """An SVG of the facets (F, 3, 3) of a surface that face the viewer, lit from beside him."""
    toward = np.array([0.48, 0.64, 0.6])
    right = np.array([-0.8, 0.6, 0.0])
    up = np.cross(toward, right)
    facing = np.flatnonzero(normals @ toward > 0.0)
    order = facing[np.argsort(np.mean(corners[facing], axis=1) @ toward)]
    flat = np.stack([corners[order] @ right, -(corners[order] @ up)], axis=-1)
    if not len(order):
        return ""
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    scale = (_HEIGHT - 2.0 * _EDGE) / max(float(np.max(high - low)), 1e-300)
    flat = (flat - 0.5 * (low + high)) * scale + 0.5 * _HEIGHT
    light = normals[order] @ np.array([0.1, 0.75, 0.65])
    shades = (60.0 + 170.0 * np.clip(light, 0.0, 1.0)).astype(int).tolist()
    drawn = "".join(
        f'<path d="{_path(points)}Z" fill="rgb({shade},{shade},{shade})" '
        f'stroke="rgb({shade},{shade},{shade})" stroke-width="0.4"/>'
        for points, shade in zip(flat, shades, strict=True)
    )
    return _figure(_HEIGHT, drawn, caption)


def _figure(width: float, drawn: str, caption: str) -> str:
    """An SVG of paths over its caption."""
    text = html.escape(caption)
    return (
        f'<figure style="margin:0"><svg width="{width:.0f}" height="{_HEIGHT:.0f}" role="img" '
        f'aria-label="{text}">{drawn}</svg>'
        f'<figcaption style="font-size:80%">{text}</figcaption></figure>'
    )


def _path(points: NDArray[np.float64], *, is_dotted: bool = False) -> str:
    words, is_gap = [], True
    for x, y in points:
        if not (np.isfinite(x) and np.isfinite(y)):
            is_gap = True
            continue
        words.append(f"{'M' if is_gap or is_dotted else 'L'}{x:.1f} {y:.1f}")
        if is_dotted:
            words.append("h0")
        is_gap = False
    return "".join(words)
