"""The spectrum of a tumbler's light curve.

frequencies   `lines`: the frequencies at which it has lines
series        `fit`, `search`: Fourier series in two frequencies through a light curve
"""

from attitude.spectrum.frequencies import Line, lines
from attitude.spectrum.series import SeriesFit, fit, search

__all__ = ["Line", "SeriesFit", "fit", "lines", "search"]
