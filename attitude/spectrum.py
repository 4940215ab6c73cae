"""Lines in the spectrum of a tumbler's light curve, and Fourier series in two frequencies.

The code is in photometry/_samples.py and photometry/_series.py.
"""

from attitude.photometry._samples import Line, Samples, lines
from attitude.photometry._series import SeriesFit, fit, search

__all__ = ["Line", "Samples", "SeriesFit", "fit", "lines", "search"]
