"""The spectrum of a tumbler's light curve.

frequencies   `lines`: the frequencies at which it has lines
series        `fit`, `search`: Fourier series in two frequencies through a light curve
samples       `HasSamples`: the base of objects that are a light curve, and their numbers
refinement    series in any number of frequencies at the least squares of all parameters
transforms    sums of exponentials over uneven epochs, by a gridded transform
pair_scan     closed normal equations of pairs of frequencies, compiled
pair_search   the best of all pairs of two grids
significance  chance and aliases of one cycle a day
"""

from attitude.photometry._samples import HasSamples, Line, Samples, lines
from attitude.photometry._series import SeriesFit, fit, search

__all__ = ["HasSamples", "Line", "Samples", "SeriesFit", "fit", "lines", "search"]
