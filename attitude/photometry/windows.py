"""The spectral window of epochs, and what it does to periods: aliases and harmonics, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from attitude.spectrum import transforms

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray
    from attitude.spectrum.samples import Samples

# Grid frequencies per 1/span, and power from which a line of the window makes aliases.
_OVERSAMPLING, _STRONG = 4.0, 0.15
# Power from which a line of the window makes aliases of harmonics too.
_DOMINANT = 0.5
# Lines of a window that are kept, multiples of them, ratios of harmonics.
_KEPT = 6
_MULTIPLES = (1, -1, 2, -2)
_RATIOS = ((1, 2), (2, 1), (1, 3), (3, 1), (2, 3), (3, 2), (1, 4), (4, 1), (3, 4), (4, 3))
_NAMES = ((1.0 / 86400.0, "1 /d"), (1.0 / 86164.1, "1 /sidereal d"), (2.0 / 86400.0, "2 /d"))


class WindowLine(NamedTuple):
    """A line of the spectral window: frequency in Hz, power (1 at zero frequency)."""

    frequency: float
    power: float


class Window(NamedTuple):
    """The spectral window of epochs: frequencies (K,), Hz, powers (K,), and the strong lines."""

    frequency: FloatArray
    power: FloatArray
    lines: tuple[WindowLine, ...]


def window(samples: Samples, most: float) -> Window:
    """The spectral window |sum w e^(2 pi i f t)|^2 / (sum w)^2 up to a frequency, Hz.

    Parameters
    ----------
    samples : Samples
    most : float
    """
    spacing = 1.0 / (_OVERSAMPLING * max(samples.span, 1e-300))
    count = max(int(most / spacing) + 2, 8)
    weights = samples.weights**2
    made = transforms.sums(samples.t - samples.t.min(), weights[None], spacing, count)[0]
    power = np.asarray(np.abs(made) ** 2 / np.sum(weights) ** 2, dtype=np.float64)
    frequency: FloatArray = spacing * np.arange(count, dtype=np.float64)
    inner = np.arange(1, count - 1)
    is_peak = (power[inner] >= power[inner - 1]) & (power[inner] >= power[inner + 1])
    at = inner[is_peak & (power[inner] > _STRONG) & (frequency[inner] > 2.0 / samples.span)]
    lines: list[WindowLine] = []
    for k in at[np.argsort(-power[at], kind="stable")]:
        if all(abs(frequency[k] - each.frequency) > 1.5 / samples.span for each in lines):
            lines.append(WindowLine(float(frequency[k]), float(power[k])))
        if len(lines) == _KEPT:
            break
    return Window(frequency, power, tuple(lines))


def relation(
    frequency: float, better: Sequence[float], lines: Sequence[WindowLine], near: float
) -> str:
    """How a frequency follows from a better one: "alias of #1 (1 /d)", "2/1 of #1", or "".

    Parameters
    ----------
    frequency : float
        Hz.
    better : sequence of float
        Frequencies of the peaks before it, the best first.
    lines : sequence of WindowLine
    near : float
        Hz, within which frequencies are equal.
    """
    for rank, other in enumerate(better, 1):
        for a, b in _RATIOS:
            if abs(frequency - other * a / b) < near:
                return f"{a}/{b} of #{rank}" if b > 1 else f"{a} x #{rank}"
    for rank, other in enumerate(better, 1):
        for line in lines:
            for many in _MULTIPLES:
                for ratio in (1.0, 0.5, 2.0) if line.power > _DOMINANT else (1.0,):
                    expected = abs(other * ratio + many * line.frequency)
                    if abs(frequency - expected) < near:
                        share = {1.0: "", 0.5: "half of ", 2.0: "twice "}[ratio]
                        return f"alias of {share}#{rank} ({_spelled(many * line.frequency, near)})"
    return ""


def _spelled(shift: float, near: float) -> str:
    sign = "+" if shift > 0.0 else "-"
    for size, name in _NAMES:
        if abs(abs(shift) - size) < near:
            return f"{sign}{name}"
    return f"{sign}{abs(shift) * 86400.0:.4g} /d"
