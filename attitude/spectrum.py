"""The spectrum of a tumbler's light curve.

These names stand in `attitude.photometry`: `lines`, the frequencies at which it has lines; `fit`
and `search`, Fourier series in two frequencies through a light curve; `HasSamples`, the base of
objects that are a light curve.
"""

from attitude.photometry._samples import HasSamples, Line, Samples, lines
from attitude.photometry._series import SeriesFit, fit, search

__all__ = ["HasSamples", "Line", "Samples", "SeriesFit", "fit", "lines", "search"]
