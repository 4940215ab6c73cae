"""HTML of tables and SVG of small line plots, for objects that notebooks show."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


# Epochs of a table of attitudes.
_SHOWN = 5
_WIDTH, _HEIGHT, _EDGE = 260.0, 150.0, 8.0
# Points of a line that are drawn.
_MOST = 600


def rows_of(text: str) -> tuple[str, list[tuple[str, str]]]:
    r"""The first line of a description, and names and values of its other lines.

    >>> rows_of("Short-axis mode\n  period psi   2.3 s\n               at the epoch")
    ('Short-axis mode', [('period psi', '2.3 s'), ('', 'at the epoch')])
    """
    head, *rest = text.splitlines()
    rows = []
    for line in rest:
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
        + "".join(f'<td style="text-align:left">{html.escape(str(each))}</td>' for each in row)
        + "</tr>"
        for row in rows
    )
    beside = "".join(f'<div style="margin-left:1em">{each}</div>' for each in pictures)
    return (
        '<div style="display:flex;align-items:flex-start;flex-wrap:wrap">'
        f'<div><b>{html.escape(head)}</b><table style="font-size:90%">{cells}</table></div>'
        f"{beside}</div>"
    )


def described(text: str, span: Sequence[object] | None) -> str:
    """A table of a description, or of its one line and the ends of a span."""
    head, rows = rows_of(text)
    ends = zip(("from", "to"), span or (), strict=False)
    return table(head, rows or [(name, str(each)) for name, each in ends])


def attitudes(head: str, seconds: NDArray[np.float64], wxyz: NDArray[np.float64]) -> str:
    """A table of the first of some attitudes (S, 4), and their components against time."""
    if seconds.ndim > 1:
        return table(head, [])
    times, rows = seconds.reshape(-1), wxyz.reshape(-1, 4)
    cells: list[tuple[str, ...]] = [("s since the epoch", "w", "x", "y", "z")]
    cells += [
        (f"{t:.9g}", *(f"{each:.6f}" for each in q))
        for t, q in zip(times[:_SHOWN].tolist(), rows[:_SHOWN].tolist(), strict=True)
    ]
    if len(times) > _SHOWN:
        cells.append(("...", "", "", "", ""))
    if len(times) < 3:
        return table(head, cells)
    lines = [(times, rows[:, k]) for k in range(4)]
    colors = ("#444444", "#0072b2", "#d55e00", "#009e73")
    return table(head, cells, line_plot(lines, "w, x, y, z against time", colors=colors))


def line_plot(
    lines: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
    caption: str,
    *,
    colors: Sequence[str] = ("#0072b2", "#d55e00", "#009e73"),
    is_equal: bool = False,
    is_downward: bool = False,
) -> str:
    """An SVG of lines (x, y) of one scale, with a caption; points that are not finite are gaps.

    `is_equal`: one scale for x and y.  `is_downward`: y grows downwards, as magnitudes do.
    """
    finite = [np.isfinite(x) & np.isfinite(y) for x, y in lines]
    if not any(np.any(each) for each in finite):
        return ""
    x = np.concatenate([line[0][good] for line, good in zip(lines, finite, strict=True)])
    y = np.concatenate([line[1][good] for line, good in zip(lines, finite, strict=True)])
    low = np.array([x.min(), y.min()])
    width = np.array([np.ptp(x), np.ptp(y)])
    width = np.where(width > 0.0, width, 1.0)
    room = np.array([_WIDTH, _HEIGHT]) - 2.0 * _EDGE
    scale = np.full(2, np.min(room / width)) if is_equal else room / width
    paths = []
    for k, (a, b) in enumerate(lines):
        chosen = np.linspace(0, len(a) - 1, min(len(a), _MOST)).astype(np.int64)
        points = (np.stack([a, b], axis=1)[chosen] - low) * scale + _EDGE
        if not is_downward:
            points[:, 1] = _HEIGHT - points[:, 1]
        color = colors[k % len(colors)]
        paths.append(f'<path d="{_path(points)}" fill="none" stroke="{color}"/>')
    return (
        f'<figure style="margin:0"><svg width="{_WIDTH:.0f}" height="{_HEIGHT:.0f}" '
        f'role="img" aria-label="{html.escape(caption)}">{"".join(paths)}</svg>'
        f'<figcaption style="font-size:80%">{html.escape(caption)}</figcaption></figure>'
    )


def _path(points: NDArray[np.float64]) -> str:
    words, is_gap = [], True
    for x, y in points:
        if not (np.isfinite(x) and np.isfinite(y)):
            is_gap = True
            continue
        words.append(f"{'M' if is_gap else 'L'}{x:.1f} {y:.1f}")
        is_gap = False
    return "".join(words)
